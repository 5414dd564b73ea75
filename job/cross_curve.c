// SPDX-License-Identifier: Apache-2.0
// Curves of the tile that cross knot lines: cut at the roots, exactly.
#include "job/cross.h"

#include <knurl/solve.h>
#include <math.h>
#include <stdlib.h>

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// at[0 .. n - 1], sorted: where the curve meets a line, or an end at which it is cut off. Places nearer than 2^-40 to
// another, or to an end, are one.
static kn_status find_cuts(kn_ctx *ctx, double *at, int *n, int room, const kn_crossing *x)
{
    kn_bezier part = {0};
    kn_spline f = {0};
    kn_status status = KN_OK;
    *n = 0;
    for (int c = 0; c < 2; c++)
        for (int k = 0; status == KN_OK && k < x->n[c] + 2; k++) {
            kn_root *roots = NULL;
            size_t nroots = 0;
            double line = k < x->n[c] ? x->line[c][k] : x->end[c][k - x->n[c]];
            if (!isfinite(line)) continue;
            status = kn_bezier_components(ctx, &part, x->d, c, 1);
            for (size_t i = 0; status == KN_OK && i < kn_bezier_count(&part); i++) part.coef[i] -= line;
            if (status == KN_OK) status = kn_spline_of_bezier(ctx, &f, &part);
            if (status == KN_OK) status = kn_solve_roots(ctx, &roots, &nroots, NULL, &f, NULL);
            for (size_t i = 0; i < nroots && *n < room; i++) at[(*n)++] = roots[i].at[0];
            kn_free(ctx, roots);
        }
    qsort(at, (size_t)*n, sizeof *at, compare);
    int kept = 0;
    for (int i = 0; i < *n; i++)
        if (at[i] > (kept > 0 ? at[kept - 1] : 0.0) + 0x1p-40 && at[i] < 1.0 - 0x1p-40) at[kept++] = at[i];
    *n = kept;
    kn_bezier_clear(ctx, &part);
    kn_spline_clear(ctx, &f);
    return status;
}

// The box in which the middle of the part lies, if that is not cut off.
static kn_status find_box(kn_ctx *ctx, int box[2], bool *there, const kn_crossing *x, double middle)
{
    double p[3];
    kn_status status = kn_bezier_eval(ctx, p, x->d, &middle);
    *there = true;
    for (int c = 0; c < 2; c++) {
        *there = *there && status == KN_OK && p[c] >= x->end[c][0] && p[c] <= x->end[c][1];
        box[c] = 0;
        while (status == KN_OK && box[c] < x->n[c] && p[c] > x->line[c][box[c]]) box[c]++;
    }
    return status;
}

// The part [from,to] as a patch of the cell's own.
static kn_status own_patch(kn_ctx *ctx, int *index, const kn_crossing *x, double from, double to)
{
    kn_job_patches *own = &x->plan->own;
    if (own->n == own->room) {
        int room = own->room > 0 ? 2 * own->room : 8;
        kn_job_patch *list = kn_resize(ctx, own->list, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        own->list = list;
        own->room = room;
    }
    const kn_job_rect *rect = &x->leaf->key.rect;
    kn_job_patch p = *kn_job_leaf_patch(x->plan, x->leaf);
    double span = p.hi[0] - p.lo[0], step = ldexp(span, -rect->level[0]), start = p.lo[0] + rect->index[0] * step;
    p.d = (kn_bezier){0};
    p.lo[0] = start + from * step, p.hi[0] = start + to * step;
    p.inside = false;
    kn_status status = kn_bezier_restrict(ctx, &p.d, x->d, &from, &to);
    if (status != KN_OK) return status;
    *index = own->n;
    own->list[own->n++] = p;
    return KN_OK;
}

kn_status kn_cross_curve(kn_ctx *ctx, bool *crossed, kn_crossing *x)
{
    enum { ROOM = 2 * KN_MAX_DEGREE * (KN_CROSS_LINES + 2) + 1 };
    double at[ROOM + 1];
    bool fits = true, there;
    int n = 0, box[2];
    kn_status status = find_cuts(ctx, at, &n, ROOM, x);
    at[n] = 1.0;
    for (int pass = 0; status == KN_OK && fits && pass < 2; pass++) // first only whether all pieces fit
        for (int k = 0; status == KN_OK && fits && k <= n; k++) {
            double from = k > 0 ? at[k - 1] : 0.0;
            kn_job_leaf part = *x->leaf;
            status = find_box(ctx, box, &there, x, 0.5 * (from + at[k]));
            if (!there) continue;
            if (status == KN_OK) status = kn_crossing_piece(ctx, &fits, x, box[0], box[1]);
            if (pass == 0 || status != KN_OK || !fits) continue;
            status = own_patch(ctx, &part.key.patch, x, from, at[k]);
            part.own = true;
            part.key.rect = (kn_job_rect){{0}, {0}};
            part.key.turn = 0;
            part.piece = x->piece[box[0]][box[1]];
            for (int c = 0; c < 2; c++) part.shift[c] = x->shift[box[0]][box[1]][c];
            if (status == KN_OK) status = kn_job_add_leaf(ctx, x->plan, &part);
        }
    *crossed = fits;
    return status;
}
