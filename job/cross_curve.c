// SPDX-License-Identifier: Apache-2.0
// Curves of the tile that cross knot lines: cut at the roots, exactly.
#include "job/border.h"
#include "job/cross.h"

#include <knurl/solve.h>
#include <math.h>
#include <stdlib.h>

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Appends where the curve meets the line of a segment, as near the segment as that is off the border.
static kn_status cut_at_segment(kn_ctx *ctx, double *at, int *n, int room, const kn_crossing *x,
                                const kn_job_segment *s, double off)
{
    kn_bezier part = {0};
    kn_spline f = {0};
    kn_root *roots = NULL;
    size_t nroots = 0, count = kn_bezier_count(x->d);
    double a = s->to[0] - s->from[0], b = s->to[1] - s->from[1], length = hypot(a, b);
    kn_status status = kn_bezier_components(ctx, &part, x->d, 0, 1);
    for (size_t i = 0; status == KN_OK && i < count; i++)
        part.coef[i] = (a * (x->d->coef[count + i] - s->from[1]) - b * (x->d->coef[i] - s->from[0])) / length;
    if (status == KN_OK) status = kn_spline_of_bezier(ctx, &f, &part);
    if (status == KN_OK) status = kn_solve_roots(ctx, &roots, &nroots, NULL, &f, NULL);
    for (size_t i = 0; status == KN_OK && i < nroots && *n < room; i++) {
        double p[3];
        status = kn_bezier_eval(ctx, p, x->d, roots[i].at);
        double along = (a * (p[0] - s->from[0]) + b * (p[1] - s->from[1])) / length;
        if (status == KN_OK && along >= -off && along <= length + off) at[(*n)++] = roots[i].at[0];
    }
    kn_free(ctx, roots);
    kn_bezier_clear(ctx, &part);
    kn_spline_clear(ctx, &f);
    return status;
}

// The same of all segments of the border of a trim that are near.
static kn_status cut_at_border(kn_ctx *ctx, double *at, int *n, int room, const kn_crossing *x)
{
    enum { MOST = 256 };
    const kn_job *job = x->plan->job;
    int surface = x->place->surface;
    if (!kn_job_clips_trims(job) || !kn_job_is_bordered(job, surface)) return KN_OK;
    double lo[2], hi[2], off = job->borders->surfaces[surface].off;
    for (int d = 0; d < 2; d++) lo[d] = x->place->cell[d] + x->lo[d], hi[d] = x->place->cell[d] + x->hi[d];
    kn_mark mark = kn_scratch_mark(ctx);
    kn_job_segment *list = kn_scratch(ctx, MOST, sizeof *list);
    size_t found = list ? kn_job_border_take(list, MOST, job, surface, lo, hi) : 0;
    kn_status status = list ? KN_OK : KN_ENOMEM;
    if (found > MOST)
        status = kn_fail(ctx, KN_ELIMIT, "job: %zu segments of a border run over one curve of the tile, at most %d",
                         found, MOST);
    for (size_t i = 0; status == KN_OK && i < found; i++) {
        for (int d = 0; d < 2; d++) list[i].from[d] -= x->place->cell[d], list[i].to[d] -= x->place->cell[d];
        status = cut_at_segment(ctx, at, n, room, x, &list[i], off);
    }
    kn_scratch_release(ctx, mark);
    return status;
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
    if (status == KN_OK) status = cut_at_border(ctx, at, n, room, x);
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
    if (status == KN_OK && *there && kn_job_clips_trims(x->plan->job)) {
        const double at[2] = {x->place->cell[0] + p[0], x->place->cell[1] + p[1]};
        kn_answer side;
        status = kn_job_border_side(ctx, &side, x->plan->job, x->place->surface, at);
        *there = side != KN_NO;
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
    enum { ROOM = 2 * KN_MAX_DEGREE * (KN_CROSS_LINES + 2) + 1024 };
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
