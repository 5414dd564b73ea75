// SPDX-License-Identifier: Apache-2.0
// What a fit of S(map) has to respect: lines, how smooth S(map) is across each, and seams.
#include "cells/fit.h"
#include "cells/internal.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <math.h>

enum { PLACES = 5 };
static const double SAME = 1e-9; // of derivatives: S is C1 where both sides agree so far, whatever its knots say

// ---- pieces ----

kn_status kn_piece_grid_init(kn_ctx *ctx, kn_piece_grid *g, const kn_spline *s)
{
    *g = (kn_piece_grid){.npieces = 0};
    for (int d = 0; d < 2; d++) {
        g->brk[d] = kn_cells_breaks(ctx, &g->n[d], s, d);
        if (!g->brk[d]) return KN_ENOMEM;
        g->n[d]--;
    }
    return kn_spline_to_bezier(ctx, &g->piece, &g->npieces, s);
}

void kn_piece_grid_clear(kn_ctx *ctx, kn_piece_grid *g)
{
    for (size_t i = 0; i < g->npieces; i++) kn_bezier_clear(ctx, &g->piece[i]);
    kn_free(ctx, g->piece);
    *g = (kn_piece_grid){.npieces = 0};
}

static double norm(const double *v)
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// The derivatives of S in variable d at PLACES points on one side of its knot line i, along span j of the other
// variable. side 0: before the line (before the end, for i = 0), 1: behind it.
static kn_status slopes(kn_ctx *ctx, double *slope, const kn_piece_grid *s, int d, int i, int j, int side)
{
    int span = side == 1 ? i : i > 0 ? i - 1 : s->n[d] - 1;
    int piece = d == 0 ? span * s->n[1] + j : j * s->n[1] + span;
    double at[2 * PLACES], value[9 * PLACES], width = s->brk[d][span + 1] - s->brk[d][span];
    for (int k = 0; k < PLACES; k++) at[2 * k + d] = 1 - side, at[2 * k + 1 - d] = (double)k / (PLACES - 1);
    kn_status status = kn_bezier_eval_batch_partials(ctx, value, &s->piece[piece], PLACES, at);
    for (int k = 0; status == KN_OK && k < 3 * PLACES; k++)
        slope[k] = value[9 * (k / 3) + 3 * (1 + d) + k % 3] / width;
    return status;
}

kn_status kn_piece_grid_is_c1(kn_ctx *ctx, bool *yes, const kn_piece_grid *s, int d, int i)
{
    double before[3 * PLACES], behind[3 * PLACES], most = 0.0, off = 0.0;
    for (int j = 0; j < s->n[1 - d]; j++) {
        kn_status status = slopes(ctx, before, s, d, i, j, 0);
        if (status == KN_OK) status = slopes(ctx, behind, s, d, i, j, 1);
        if (status != KN_OK) return status;
        for (int k = 0; k < 3 * PLACES; k += 3) {
            const double jump[3] = {before[k] - behind[k], before[k + 1] - behind[k + 1],
                                    before[k + 2] - behind[k + 2]};
            most = fmax(most, norm(before + k)), off = fmax(off, norm(jump));
        }
    }
    *yes = off <= SAME * most;
    return KN_OK;
}

// ---- lines ----

// How often S(map) is differentiable across line i, as far as S is concerned: all coefficients of the map there are
// one knot of S, but for rounding. Otherwise 2, all that is asked for.
static kn_status smooth_across(kn_ctx *ctx, int *smooth, const kn_cells_target *f, int d, int i)
{
    const kn_spline *s = f->surface;
    kn_spline line = {0};
    kn_status status = kn_spline_isoparametric(ctx, &line, f->map, d, f->lines[d][i]);
    if (status != KN_OK) return status;
    size_t n = kn_spline_count(&line);
    const double *at = line.coef + (size_t)d * n;
    double lo = at[0], hi = at[0];
    for (size_t k = 1; k < n; k++) lo = fmin(lo, at[k]), hi = fmax(hi, at[k]);
    double slack = 0x1p-44 * fmax(fabs(lo), fabs(hi)) + 0x1p-1000;
    int p = s->degree[d];
    *smooth = 2;
    for (int k = p + 1, times = 1, knot = 1; status == KN_OK && k < s->count[d]; k += times, knot++) {
        double t = s->knots[d][k];
        for (times = 1; s->knots[d][k + times] == t;) times++;
        if (!(t >= lo - slack && t <= hi + slack && hi - lo <= slack)) continue;
        bool c1 = false;
        *smooth = p - times < 2 ? p - times : 2;
        if (*smooth == 0) status = kn_piece_grid_is_c1(ctx, &c1, &f->s, d, knot);
        if (c1) *smooth = 1;
    }
    kn_spline_clear(ctx, &line);
    return status;
}

// One array of coefficients seen along variable d: its first coefficient in line o, and the way to the last.
typedef struct strip {
    size_t outer, n, inner;
} strip;

static strip strip_of(const kn_spline *s, int d)
{
    return (strip){d == 0 ? 1 : (size_t)s->count[0], (size_t)s->count[d], d == 0 ? (size_t)s->count[1] : 1};
}

// The two edges of S across variable d have the same coefficients.
static bool same_edges(const kn_spline *s, int d, int component)
{
    strip t = strip_of(s, d);
    const double *c = s->coef + (size_t)component * kn_spline_count(s);
    for (size_t o = 0; o < t.outer; o++)
        for (size_t k = 0; k < t.inner; k++)
            if (c[o * t.n * t.inner + k] != c[(o * t.n + t.n - 1) * t.inner + k]) return false;
    return true;
}

// The map goes on from its end in variable d to its start with the same derivatives, but for rounding.
static bool same_slopes(const kn_spline *m, int d)
{
    strip t = strip_of(m, d);
    const double *knots = m->knots[d];
    size_t p = (size_t)m->degree[d];
    double first = knots[p + 1] - knots[1], last = knots[t.n + p - 1] - knots[t.n - 1], jump = 0.0, most = 0.0;
    for (size_t o = 0; o < 2 * t.outer; o++)
        for (size_t k = 0; k < t.inner; k++) {
            const double *a = m->coef + o * t.n * t.inner + k, *b = a + (t.n - 1) * t.inner;
            double start = (a[t.inner] - a[0]) / first, end = (b[0] - *(b - t.inner)) / last;
            most = fmax(most, fabs(start)), jump = fmax(jump, fabs(start - end));
        }
    return jump <= SAME * most;
}

static kn_status find_seam(kn_ctx *ctx, kn_cells_target *f, int d)
{
    bool closed = same_edges(f->map, d, 1 - d) && same_slopes(f->map, d);
    for (int c = 0; closed && c < f->surface->ncomp; c++) closed = same_edges(f->surface, d, c);
    f->closed[d] = false;
    return closed ? kn_piece_grid_is_c1(ctx, &f->closed[d], &f->s, d, 0) : KN_OK;
}

static kn_status make_lines(kn_ctx *ctx, kn_cells_target *f, int d)
{
    const kn_spline *m = f->map;
    int room = kn_spline_spans(m, d) + 1, *times = kn_scratch(ctx, (size_t)room, sizeof *times);
    f->lines[d] = kn_scratch(ctx, (size_t)room, sizeof *f->lines[d]);
    f->smooth[d] = kn_scratch(ctx, (size_t)room, sizeof *f->smooth[d]);
    if (!times || !f->lines[d] || !f->smooth[d]) return KN_ENOMEM;
    f->n[d] = kn_knots_breaks(f->lines[d], times, m->knots[d], m->degree[d], m->count[d]) - 1;
    for (int i = 1; i < f->n[d]; i++) {
        int own = m->degree[d] - times[i];
        kn_status status = own > 0 ? smooth_across(ctx, &f->smooth[d][i], f, d, i) : KN_OK;
        if (status != KN_OK) return status;
        if (own <= 0) f->smooth[d][i] = 0;
        if (f->smooth[d][i] > own) f->smooth[d][i] = own;
    }
    f->smooth[d][0] = f->smooth[d][f->n[d]] = 1; // of a seam
    return find_seam(ctx, f, d);
}

kn_status kn_cells_target_init(kn_ctx *ctx, kn_cells_target *f, const kn_spline *surface, const kn_spline *map)
{
    *f = (kn_cells_target){.surface = surface, .map = map};
    kn_status status = kn_piece_grid_init(ctx, &f->s, surface);
    if (status == KN_OK) status = kn_piece_grid_init(ctx, &f->m, map);
    for (int d = 0; d < 2 && status == KN_OK; d++) status = make_lines(ctx, f, d);
    return status;
}

void kn_cells_target_clear(kn_ctx *ctx, kn_cells_target *f)
{
    kn_piece_grid_clear(ctx, &f->s);
    kn_piece_grid_clear(ctx, &f->m);
}
