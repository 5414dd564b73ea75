// SPDX-License-Identifier: Apache-2.0
// Splines as grids of Bezier pieces side by side in one array, and the way back to minimal knots.
#include <limits.h>
#include <string.h>

#include "spline/internal.h"
#include "kernel/context.h"

// The place in s of row `index` of the box that starts at first, and the next index; rows run along the
// last variable.
static size_t row_place(const kn_spline *s, const int *first, int *index)
{
    size_t place = 0;
    int last = s->nvars - 1;
    for (int d = 0; d <= last; d++) place = place * (size_t)s->count[d] + (size_t)(first[d] + index[d]);
    for (int d = last - 1; d >= 0 && ++index[d] > s->degree[d]; d--) index[d] = 0;
    return place;
}

void kn_spline_get_piece(kn_bezier *piece, const kn_spline *s, const int *first)
{
    int index[KN_MAX_VARS] = {0};
    size_t row = (size_t)s->degree[s->nvars - 1] + 1, all = kn_spline_count(s), n = kn_bezier_count(piece);
    for (size_t done = 0; done < n; done += row) {
        size_t place = row_place(s, first, index);
        for (size_t c = 0; c < (size_t)s->ncomp; c++)
            memcpy(piece->coef + c * n + done, s->coef + c * all + place, row * sizeof *s->coef);
    }
}

void kn_spline_put_piece(kn_spline *s, const kn_bezier *piece, const int *first)
{
    int index[KN_MAX_VARS] = {0};
    size_t row = (size_t)s->degree[s->nvars - 1] + 1, all = kn_spline_count(s), n = kn_bezier_count(piece);
    for (size_t done = 0; done < n; done += row) {
        size_t place = row_place(s, first, index);
        for (size_t c = 0; c < (size_t)s->ncomp; c++)
            memcpy(s->coef + c * all + place, piece->coef + c * n + done, row * sizeof *s->coef);
    }
}

kn_status kn_spline_alloc_split(kn_ctx *ctx, kn_spline *out, int nvars, int ncomp, bool rational, const int *degree,
                                const kn_grid *grid)
{
    int count[KN_MAX_VARS];
    for (int d = 0; d < nvars; d++) {
        if (grid->nbreaks[d] - 1 > INT_MAX / (degree[d] + 1))
            return kn_fail(ctx, KN_ELIMIT, "spline: %d pieces of degree %d", grid->nbreaks[d] - 1, degree[d]);
        count[d] = (grid->nbreaks[d] - 1) * (degree[d] + 1);
    }
    kn_status status = kn_spline_shape(ctx, "spline", nvars, ncomp, rational, degree, count);
    if (status == KN_OK) status = kn_spline_alloc(ctx, out, nvars, ncomp, rational, degree, count);
    if (status != KN_OK) return status;
    for (int d = 0; d < nvars; d++)
        for (int i = 0; i < count[d] + degree[d] + 1; i++) out->knots[d][i] = grid->breaks[d][i / (degree[d] + 1)];
    return KN_OK;
}

static kn_status join_variable(kn_ctx *ctx, kn_spline *s, int var, const kn_grid *grid)
{
    int p = s->degree[var], n = grid->nbreaks[var];
    grid->times[var][0] = grid->times[var][n - 1] = p + 1;
    int nknots = kn_knots_repeat(NULL, grid->breaks[var], grid->times[var], n);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_band band;
    double *to = kn_scratch(ctx, (size_t)nknots, sizeof *to);
    kn_status status = to ? kn_spline_band(ctx, &band, nknots - p - 1, p + 1) : KN_ENOMEM;
    if (status == KN_OK) {
        kn_knots_repeat(to, grid->breaks[var], grid->times[var], n);
        kn_band_join(&band, grid->breaks[var], n, p, to);
        status = kn_spline_map(ctx, s, var, p, to, &band);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_spline_join(kn_ctx *ctx, kn_spline *s, const kn_grid *grid)
{
    kn_status status = KN_OK;
    for (int d = 0; d < s->nvars && status == KN_OK; d++) status = join_variable(ctx, s, d, grid);
    return status;
}
