// SPDX-License-Identifier: Apache-2.0
// Splines as grids of Bezier pieces side by side in one array, and the way back to few knots.
#include <limits.h>
#include <string.h>

#include "spline/internal.h"
#include "kernel/context.h"

// ---- one piece ----
// Copies the box of coefficients that starts at first, row by row along the last variable: to the piece or from it.
static void move_piece(const kn_bezier *piece, const kn_spline *s, const int *first, bool to_piece)
{
    int index[KN_MAX_VARS] = {0}, last = s->nvars - 1;
    size_t row = (size_t)s->degree[last] + 1, all = kn_spline_count(s), n = kn_bezier_count(piece);
    for (size_t done = 0; done < n; done += row) {
        size_t place = 0;
        for (int d = 0; d <= last; d++) place = place * (size_t)s->count[d] + (size_t)(first[d] + index[d]);
        for (int d = last - 1; d >= 0 && ++index[d] > s->degree[d]; d--) index[d] = 0;
        for (size_t c = 0; c < (size_t)s->ncomp; c++) {
            double *own = piece->coef + c * n + done, *there = s->coef + c * all + place;
            memcpy(to_piece ? own : there, to_piece ? there : own, row * sizeof *own);
        }
    }
}

void kn_spline_get_piece(kn_bezier *piece, const kn_spline *s, const int *first)
{
    move_piece(piece, s, first, true);
}

void kn_spline_put_piece(kn_spline *s, const kn_bezier *piece, const int *first)
{
    move_piece(piece, s, first, false);
}

// ---- grids ----
kn_status kn_spline_breaks(kn_ctx *ctx, kn_grid *grid, const kn_spline *s, int var)
{
    size_t n = (size_t)kn_spline_spans(s, var) + 1;
    grid->breaks[var] = kn_scratch(ctx, n, sizeof *grid->breaks[var]);
    grid->times[var] = kn_scratch(ctx, n, sizeof *grid->times[var]);
    if (!grid->breaks[var] || !grid->times[var]) return KN_ENOMEM;
    grid->nbreaks[var] = kn_knots_breaks(grid->breaks[var], grid->times[var], s->knots[var], s->degree[var],
                                         s->count[var]);
    return KN_OK;
}

kn_status kn_spline_pieces_in_scratch(kn_ctx *ctx, const char *call, kn_spline *s, const kn_grid *grid)
{
    for (int d = 0; d < s->nvars; d++) {
        int pieces = grid->nbreaks[d] - 1;
        if (pieces > INT_MAX / (s->degree[d] + 1))
            return kn_fail(ctx, KN_ELIMIT, "%s: %d pieces of degree %d", call, pieces, s->degree[d]);
        s->count[d] = pieces * (s->degree[d] + 1);
    }
    return kn_spline_in_scratch(ctx, call, s);
}

void kn_grid_multiplicities(kn_grid *grid, int var, int degree)
{
    int n = grid->nbreaks[var], *times = grid->times[var];
    for (int i = 1; i < n - 1; i++)
        times[i] = times[i] < -1 ? degree + 1 : times[i] >= degree ? 0 : degree - times[i];
    times[0] = times[n - 1] = degree + 1;
}

// ---- all pieces ----
kn_status kn_spline_split_in_scratch(kn_ctx *ctx, kn_spline *s, int var, const kn_grid *grid)
{
    int n = grid->nbreaks[var], order = s->degree[var] + 1;
    if (n > INT_MAX / order) return kn_fail(ctx, KN_ELIMIT, "spline: %d pieces of degree %d", n - 1, order - 1);
    double *to = kn_scratch(ctx, (size_t)n * (size_t)order, sizeof *to);
    if (!to) return KN_ENOMEM;
    for (int i = 0; i < n * order; i++) to[i] = grid->breaks[var][i / order];
    return kn_spline_refine_in_scratch(ctx, s, var, to, (n - 1) * order);
}

kn_status kn_spline_split_on_grid(kn_ctx *ctx, kn_spline *s, const kn_grid *grid)
{
    kn_status status = KN_OK;
    for (int d = 0; d < s->nvars && status == KN_OK; d++) status = kn_spline_split_in_scratch(ctx, s, d, grid);
    return status;
}

// Rows from their first weight to their last that is not zero: what kn_band_apply then does is what it must do.
static void drop_zeros(kn_band *band)
{
    for (int i = 0; i < band->rows; i++) {
        double *w = band->w + (size_t)i * (size_t)band->width;
        int first = 0, last = band->width - 1;
        while (last > 0 && w[last] == 0.0) last--;
        while (first < last && w[first] == 0.0) first++;
        if (first > 0) memmove(w, w + first, (size_t)(last - first + 1) * sizeof *w);
        band->first[i] += first, band->terms[i] = last - first + 1;
    }
}

kn_status kn_spline_join_in_scratch(kn_ctx *ctx, kn_spline *s, int var, const kn_grid *grid)
{
    int p = s->degree[var], n = grid->nbreaks[var];
    int nknots = kn_knots_repeat(NULL, grid->breaks[var], grid->times[var], n);
    kn_band band;
    double *to = kn_scratch(ctx, (size_t)nknots, sizeof *to);
    kn_status status = to ? kn_spline_refining_band(ctx, &band, nknots - p - 1, p + 1) : KN_ENOMEM;
    if (status != KN_OK) return status;
    kn_knots_repeat(to, grid->breaks[var], grid->times[var], n);
    kn_band_join(&band, grid->breaks[var], n, p, to);
    drop_zeros(&band);
    return kn_spline_map_in_scratch(ctx, s, var, p, to, &band);
}

kn_status kn_spline_join_on_grid(kn_ctx *ctx, kn_spline *s, const kn_grid *grid)
{
    kn_status status = KN_OK;
    for (int d = 0; d < s->nvars && status == KN_OK; d++) status = kn_spline_join_in_scratch(ctx, s, d, grid);
    return status;
}
