// SPDX-License-Identifier: Apache-2.0
// A surface of the tile over the border of a trimmed base: what of its [0,1]^2 goes into the region.
//
// Near the patch the region is bounded by segments. By the line of one of them, a u + b v = c, a Bernstein function of
// (r,t), the patch is cut in two, and what the other segments have on either side goes on with that side: a binary
// space partition. The part to the left of the last segment on its way is in the region, the part to its right is
// not. That asks for nothing of D: it may fold over, stand upright or cover the border many times. In the end the
// parts that are left become one.
#include "job/border.h"
#include "job/cross.h"

#include <math.h>
#include <string.h>

enum { MOST_SEGMENTS = 1024 };      // of the border, over one patch
static const double on_line = 1e-9; // of a cell

typedef struct cutting {
    kn_crossing *x;
    double delta; // how far the cuts may be off, on the lattice
    kn_job_regions *out;
} cutting;

// ---- segments ----

typedef struct line {
    double at[2], left[2]; // a point, and the unit normal towards the region
} line;

static line line_of(const kn_job_segment *s)
{
    double a = s->to[0] - s->from[0], b = s->to[1] - s->from[1], length = hypot(a, b);
    return (line){{s->from[0], s->from[1]}, {-b / length, a / length}};
}

static double side_of(const line *l, const double p[2])
{
    return l->left[0] * (p[0] - l->at[0]) + l->left[1] * (p[1] - l->at[1]);
}

// The part of a segment in the box; false: none that counts.
static bool clip_to_box(kn_job_segment *s, const double lo[2], const double hi[2])
{
    double from = 0.0, to = 1.0;
    for (int d = 0; d < 2; d++) {
        double a = s->from[d], way = s->to[d] - a;
        if (way == 0.0 && (a < lo[d] || a > hi[d])) return false;
        if (way == 0.0) continue;
        double p = (lo[d] - a) / way, q = (hi[d] - a) / way;
        from = fmax(from, fmin(p, q)), to = fmin(to, fmax(p, q));
    }
    if (!(from < to)) return false;
    const kn_job_segment whole = *s;
    for (int d = 0; d < 2; d++) {
        if (from > 0.0) s->from[d] = whole.from[d] + from * (whole.to[d] - whole.from[d]);
        if (to < 1.0) s->to[d] = whole.from[d] + to * (whole.to[d] - whole.from[d]);
    }
    return hypot(s->to[0] - s->from[0], s->to[1] - s->from[1]) > on_line;
}

// What of a segment lies to the left and to the right of a line; what lies on it is on neither side.
static void divide(bool *is_left, bool *is_right, kn_job_segment *left, kn_job_segment *right,
                   const kn_job_segment *s, const line *l)
{
    double a = side_of(l, s->from), b = side_of(l, s->to);
    *left = *right = *s;
    *is_left = a > on_line || b > on_line;
    *is_right = a < -on_line || b < -on_line;
    if (!*is_left || !*is_right) return;
    double t = a / (a - b), at[2];
    for (int d = 0; d < 2; d++) at[d] = s->from[d] + t * (s->to[d] - s->from[d]);
    memcpy(a > 0.0 ? left->to : left->from, at, sizeof at);
    memcpy(a > 0.0 ? right->from : right->to, at, sizeof at);
}

// The segment whose line cuts fewest of the others, and among those halves them best.
static size_t choose(const kn_job_segment *list, size_t n)
{
    size_t best = 0, least = SIZE_MAX;
    size_t step = n > 32 ? n / 32 : 1; // some of them will do
    for (size_t i = 0; i < n; i += step) {
        line l = line_of(&list[i]);
        size_t sides[2] = {0, 0}, cuts = 0;
        for (size_t k = 0; k < n; k++) {
            double a = side_of(&l, list[k].from), b = side_of(&l, list[k].to);
            bool left = a > on_line || b > on_line, right = a < -on_line || b < -on_line;
            cuts += left && right;
            sides[0] += left, sides[1] += right;
        }
        size_t more = sides[0] > sides[1] ? sides[0] : sides[1], cost = 8 * cuts + more;
        if (cost < least) best = i, least = cost;
    }
    return best;
}

// ---- regions ----

void kn_job_regions_clear(kn_ctx *ctx, kn_job_regions *r)
{
    for (int i = 0; i < r->n; i++) kn_trim_clear(ctx, &r->list[i]);
    kn_free(ctx, r->list);
    *r = (kn_job_regions){0};
}

static kn_status keep(kn_ctx *ctx, kn_job_regions *r, kn_trim *region)
{
    kn_trim *list = kn_resize(ctx, r->list, (size_t)r->n + 1, sizeof *list);
    if (!list) return KN_ENOMEM;
    r->list = list;
    list[r->n++] = *region;
    *region = (kn_trim){0};
    return KN_OK;
}

// Where the cut touches the boundary of the region, or runs along it, it is moved a little: that is part of delta.
static kn_status cut(kn_ctx *ctx, cutting *c, kn_trim *left, kn_trim *right, kn_trim_cut_report *report,
                     const kn_trim *region, const line *l)
{
    static const double moves[] = {0.0, 0.125, -0.125, 0.25, -0.25, 0.375, -0.375};
    kn_status status = KN_EUNDECIDED;
    for (size_t k = 0; status == KN_EUNDECIDED && k < sizeof moves / sizeof *moves; k++) {
        double by = moves[k] * c->delta;
        const double f[3] = {l->left[0], l->left[1], -(l->left[0] * l->at[0] + l->left[1] * l->at[1]) - by};
        if (k > 0) kn_ctx_clear_error(ctx);
        status = kn_cross_cut_by(ctx, right, left, report, c->x, region, f, 0.5 * c->delta);
        if (status == KN_OK) c->x->off = fmax(c->x->off, fabs(by) + report->residual);
    }
    return status;
}

static kn_status split(kn_ctx *ctx, cutting *c, kn_trim *region, const kn_job_segment *list, size_t n);

static kn_status go_on(kn_ctx *ctx, cutting *c, kn_trim *region, const kn_job_segment *list, size_t n, bool inside)
{
    if (n > 0) return split(ctx, c, region, list, n);
    return inside ? keep(ctx, c->out, region) : KN_OK;
}

static kn_status split(kn_ctx *ctx, cutting *c, kn_trim *region, const kn_job_segment *list, size_t n)
{
    size_t chosen = choose(list, n), sides[2] = {0, 0};
    line l = line_of(&list[chosen]);
    kn_trim part[2] = {{0}, {0}};
    kn_trim_cut_report report = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_job_segment *left = kn_scratch(ctx, n, sizeof *left), *right = kn_scratch(ctx, n, sizeof *right);
    kn_status status = left && right ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        bool is_left, is_right;
        if (i == chosen) continue;
        divide(&is_left, &is_right, &left[sides[0]], &right[sides[1]], &list[i], &l);
        sides[0] += is_left, sides[1] += is_right;
    }
    if (status == KN_OK) status = cut(ctx, c, &part[0], &part[1], &report, region, &l);
    if (status == KN_OK && report.above) status = go_on(ctx, c, &part[0], left, sides[0], true);
    if (status == KN_OK && report.below) status = go_on(ctx, c, &part[1], right, sides[1], false);
    kn_trim_clear(ctx, &part[0]);
    kn_trim_clear(ctx, &part[1]);
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- the patch ----

static kn_status no_few(kn_ctx *ctx, const kn_crossing *x, size_t n)
{
    const kn_job *job = x->plan->job;
    const kn_job_surface *s = &job->surfaces[x->place->surface];
    return kn_fail(ctx, KN_ELIMIT,
                   "job: %zu segments of the border of surface %d run through one patch in cell %d,%d; at most %d: a "
                   "larger --crossing-tol makes fewer",
                   n, s->origin, s->origin_cell[0] + x->place->cell[0], s->origin_cell[1] + x->place->cell[1],
                   MOST_SEGMENTS);
}

// Speeds of T over all boxes that D meets: the distance of two images is at most that times the way on the lattice.
static kn_status find_speed(kn_ctx *ctx, double *speed, double *rounding, const kn_crossing *x)
{
    *speed = *rounding = 0.0;
    kn_status status = KN_OK;
    for (int i = 0; i <= x->n[0]; i++)
        for (int j = 0; status == KN_OK && j <= x->n[1]; j++) {
            double one;
            status = kn_crossing_speed(ctx, &one, x, i, j);
            *speed = fmax(*speed, one);
            *rounding = fmax(*rounding, kn_crossing_rounding(x, i, j));
        }
    return status;
}

kn_status kn_job_border_cut(kn_ctx *ctx, kn_job_regions *out, kn_crossing *x, const kn_trim *region)
{
    const double margin = 1e-6, *cell = (const double[]){x->place->cell[0], x->place->cell[1]};
    const kn_job *job = x->plan->job;
    double lo[2], hi[2], speed = 0.0, rounding = 0.0, off = job->borders->surfaces[x->place->surface].off;
    for (int d = 0; d < 2; d++) lo[d] = cell[d] + x->lo[d] - margin, hi[d] = cell[d] + x->hi[d] + margin;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_job_segment *list = kn_scratch(ctx, MOST_SEGMENTS, sizeof *list);
    kn_trim start = {0};
    size_t n = 0, found = list ? kn_job_border_take(list, MOST_SEGMENTS, job, x->place->surface, lo, hi) : 0;
    kn_status status = !list ? KN_ENOMEM : found > MOST_SEGMENTS ? no_few(ctx, x, found) : KN_OK;
    for (size_t i = 0; status == KN_OK && i < found; i++) {
        if (!clip_to_box(&list[i], lo, hi)) continue;
        for (int d = 0; d < 2; d++) list[i].from[d] -= cell[d], list[i].to[d] -= cell[d];
        list[n++] = list[i];
    }
    if (status == KN_OK) status = kn_trim_copy(ctx, &start, region);
    if (status == KN_OK) status = find_speed(ctx, &speed, &rounding, x);
    if (status == KN_OK && n == 0) {
        const double middle[2] = {0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1])};
        kn_answer answer;
        status = kn_job_border_side(ctx, &answer, job, x->place->surface, middle);
        if (status == KN_OK && answer != KN_NO) status = keep(ctx, out, &start);
    } else if (status == KN_OK) {
        double tol = fmax(job->options.crossing_tol / speed - off, 0.25 * job->options.crossing_tol / speed),
               was = x->off;
        cutting c = {x, fmin(fmax(0.5 * tol, 0x1p-36), 0x1p-6), out};
        x->off = 0.0;
        status = split(ctx, &c, &start, list, n);
        if (status == KN_OK) status = kn_job_unite_regions(ctx, out);
        double error = (speed * (off + x->off) + 2.0 * rounding) * (1.0 + 1e-12);
        x->off = was;
        if (status == KN_OK) x->plan->crossing = fmax(x->plan->crossing, error);
    }
    kn_trim_clear(ctx, &start);
    kn_scratch_release(ctx, mark);
    return status;
}
