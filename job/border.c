// SPDX-License-Identifier: Apache-2.0
// The borders of trimmed surfaces: curves of trims as segments on the lattice of cells.
//
// A Bezier curve c and its chord differ by no more than the largest distance of a control point c_i from the chord's
// point at i / p: both are curves of degree p over the same basis. Cells are affine images of their part of the
// domain, so that the same holds on the lattice with each coordinate times the largest slope there.
#include "job/border.h"
#include "job/placement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_HALVINGS = 24, MOST_SEGMENTS = 1 << 22 };
static const double on_side = 1e-9; // of the square: what lies on a side of it

// ---- the lattice ----

static double parameter_of(const kn_job_surface *s, int d, double x)
{
    double first = s->lines[d][0], last = s->lines[d][s->cells[d]];
    double at = first + (x - s->box[0][d]) / (s->box[1][d] - s->box[0][d]) * (last - first);
    return x == s->box[1][d] ? last : at;
}

double kn_job_lattice_of(const kn_job_surface *s, int d, double x)
{
    double at = parameter_of(s, d, x);
    int lo = 0, hi = s->cells[d] - 1;
    while (lo < hi) {
        int middle = (lo + hi + 1) / 2;
        if (s->lines[d][middle] <= at)
            lo = middle;
        else
            hi = middle - 1;
    }
    double from = s->lines[d][lo], to = s->lines[d][lo + 1];
    double place = at == to ? lo + 1.0 : lo + (at - from) / (to - from);
    return round(place * 0x1p40) * 0x1p-40;
}

// Of cells on the lattice over [0,1] of the origin, at most; and whether it is one affine map.
static double slope_of(bool *affine, const kn_job_surface *s, int d)
{
    double least = INFINITY, most = 0.0;
    for (int i = 0; i < s->cells[d]; i++) {
        double width = s->lines[d][i + 1] - s->lines[d][i];
        least = fmin(least, width), most = fmax(most, width);
    }
    *affine = most - least <= 1e-12 * most;
    return (s->lines[d][s->cells[d]] - s->lines[d][0]) / (s->box[1][d] - s->box[0][d]) / least * (1.0 + 1e-12);
}

// ---- segments ----

typedef struct tracing {
    const kn_job_surface *surface;
    kn_job_border_list *out;
    double slope[2], tol;
    bool affine[2];
} tracing;

static kn_status append(kn_ctx *ctx, kn_job_border_list *b, const double from[2], const double to[2])
{
    if (from[0] == to[0] && from[1] == to[1]) return KN_OK;
    if (b->n == b->room) {
        if (b->n >= MOST_SEGMENTS)
            return kn_fail(ctx, KN_ELIMIT, "job: the border of a trim has more than %d segments", MOST_SEGMENTS);
        size_t room = b->room > 0 ? 2 * b->room : 64;
        kn_job_segment *list = kn_resize(ctx, b->list, room, sizeof *list);
        if (!list) return KN_ENOMEM;
        b->list = list;
        b->room = room;
    }
    b->list[b->n++] = (kn_job_segment){{from[0], from[1]}, {to[0], to[1]}};
    return KN_OK;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// A segment in the origin's [0,1]^2. Where the lattice is bent at cell lines, it is cut there.
static kn_status add_segment(kn_ctx *ctx, const tracing *t, const double from[2], const double to[2])
{
    const kn_job_surface *s = t->surface;
    size_t n = 0, room = (size_t)s->cells[0] + (size_t)s->cells[1] + 2;
    for (int d = 0; d < 2; d++)
        if (fmax(fabs(from[d]), fabs(to[d])) <= on_side || fmax(fabs(from[d] - 1.0), fabs(to[d] - 1.0)) <= on_side)
            return KN_OK; // a side of the square
    kn_mark mark = kn_scratch_mark(ctx);
    double *at = kn_scratch(ctx, room, sizeof *at), last[2];
    if (!at) return KN_ENOMEM;
    for (int d = 0; d < 2; d++) {
        double a = parameter_of(s, d, from[d]), b = parameter_of(s, d, to[d]);
        for (int i = 1; !t->affine[d] && i < s->cells[d]; i++) {
            double x = (s->lines[d][i] - a) / (b - a);
            if (x > 0.0 && x < 1.0) at[n++] = x;
        }
        last[d] = kn_job_lattice_of(s, d, from[d]);
    }
    qsort(at, n, sizeof *at, compare);
    at[n] = 1.0;
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i <= n; i++) {
        double next[2];
        for (int d = 0; d < 2; d++)
            next[d] = kn_job_lattice_of(s, d, i == n ? to[d] : from[d] + at[i] * (to[d] - from[d]));
        status = append(ctx, t->out, last, next);
        memcpy(last, next, sizeof last);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

static double off_chord(const kn_bezier *c, const double slope[2])
{
    int p = c->degree[0];
    double most = 0.0;
    for (int i = 1; i < p; i++) {
        double off[2];
        for (int d = 0; d < 2; d++) {
            const double *x = c->coef + d * (p + 1);
            off[d] = slope[d] * (x[i] - (x[0] + (x[p] - x[0]) * i / p));
        }
        most = fmax(most, hypot(off[0], off[1]));
    }
    return most * (1.0 + 1e-12);
}

static kn_status trace(kn_ctx *ctx, tracing *t, const kn_bezier *c, int halvings)
{
    double off = off_chord(c, t->slope);
    int p = c->degree[0];
    if (off <= t->tol || halvings == MOST_HALVINGS) {
        const double from[2] = {c->coef[0], c->coef[p + 1]}, to[2] = {c->coef[p], c->coef[2 * p + 1]};
        t->out->off = fmax(t->out->off, off);
        return add_segment(ctx, t, from, to);
    }
    kn_bezier half[2] = {{0}, {0}};
    kn_status status = kn_bezier_subdivide(ctx, &half[0], &half[1], c, 0, 0.5);
    for (int k = 0; status == KN_OK && k < 2; k++) status = trace(ctx, t, &half[k], halvings + 1);
    for (int k = 0; k < 2; k++) kn_bezier_clear(ctx, &half[k]);
    return status;
}

// A turn before and a turn after.
static kn_status repeat(kn_ctx *ctx, kn_job_border_list *b, int d, int cells)
{
    kn_status status = KN_OK;
    size_t n = b->n;
    for (size_t i = 0; i < 2 * n && status == KN_OK; i++) {
        kn_job_segment s = b->list[i % n];
        double by = i < n ? -cells : cells;
        s.from[d] += by, s.to[d] += by;
        status = append(ctx, b, s.from, s.to);
    }
    return status;
}

static int column(const kn_job_border_list *b, double x)
{
    return (int)fmin(fmax(floor(x) - b->first, 0.0), b->ncolumns - 1);
}

static kn_status make_columns(kn_ctx *ctx, kn_job_border_list *b)
{
    size_t total = 0;
    b->start = kn_alloc_zero(ctx, (size_t)b->ncolumns + 1, sizeof *b->start);
    if (!b->start) return KN_ENOMEM;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < b->n; i++) {
            const kn_job_segment *s = &b->list[i];
            int last = column(b, fmax(s->from[0], s->to[0]) + b->off);
            for (int k = column(b, fmin(s->from[0], s->to[0]) - b->off); k <= last; k++) {
                if (pass == 0)
                    b->start[k + 1]++, total++;
                else
                    b->index[b->start[k]++] = (uint32_t)i;
            }
        }
        if (pass == 0) {
            b->index = kn_alloc(ctx, total, sizeof *b->index);
            if (!b->index) return KN_ENOMEM;
            for (int k = 0; k < b->ncolumns; k++) b->start[k + 1] += b->start[k];
        }
    }
    memmove(b->start + 1, b->start, (size_t)b->ncolumns * sizeof *b->start); // each moved to its own end
    b->start[0] = 0;
    return KN_OK;
}

// ---- the whole ----

// |dT| <= sum_d width_d |dT/dx_d| |dx_d|; without fields T = S + w n, else T is one spline in (u, v, w).
static kn_status find_speed(kn_ctx *ctx, double *speed, const kn_job *job, const kn_job_surface *s, double top)
{
    double rise[3], turn[2], square = 0.0;
    kn_spline whole = {0};
    kn_status status = KN_OK;
    if (job->has_fields) {
        double reach = fmax(top, 1e-6 * job->w_length);
        status = kn_shell_volume(ctx, &whole, s->shell, -reach, reach);
        if (status == KN_OK) status = kn_spline_lipschitz(ctx, rise, &whole);
        turn[0] = turn[1] = 0.0;
    } else {
        status = kn_spline_lipschitz(ctx, rise, kn_shell_surface(s->shell));
        if (status == KN_OK) status = kn_spline_lipschitz(ctx, turn, kn_shell_normal(s->shell));
    }
    for (int d = 0; status == KN_OK && d < 2; d++) {
        double width = 0.0;
        for (int i = 0; i < s->cells[d]; i++) width = fmax(width, s->lines[d][i + 1] - s->lines[d][i]);
        square += pow(width * (rise[d] + top * turn[d]), 2.0);
    }
    kn_spline_clear(ctx, &whole);
    if (status == KN_OK) *speed = sqrt(square) * (1.0 + 1e-12);
    return status;
}

kn_status kn_job_border_speed(kn_ctx *ctx, double *speed, const kn_job *job, int surface, double top)
{
    const kn_job_border_list *b = &job->borders->surfaces[surface];
    *speed = b->speed;
    return top <= b->top ? KN_OK : find_speed(ctx, speed, job, &job->surfaces[surface], top);
}

// How fine the segments are to be on the lattice: T moves by a quarter of crossing_tol over them, about.
static kn_status choose_tol(kn_ctx *ctx, double *tol, const kn_job *job, const kn_job_surface *s)
{
    const double coarsest = 0x1p-8, finest = 0x1p-30;
    double rise[2], turn[2] = {0.0, 0.0}, top = kn_job_top(job), speed = 0.0;
    kn_status status = kn_spline_lipschitz(ctx, rise, kn_shell_surface(s->shell));
    if (status == KN_OK) status = kn_spline_lipschitz(ctx, turn, kn_shell_normal(s->shell));
    for (int d = 0; d < 2; d++) {
        double width = 0.0;
        for (int i = 0; i < s->cells[d]; i++) width = fmax(width, s->lines[d][i + 1] - s->lines[d][i]);
        speed += width * (rise[d] + 2.0 * top * job->w_length * turn[d]);
    }
    *tol = fmax(fmin(job->options.crossing_tol / (4.0 * speed), coarsest), finest);
    return status;
}

static kn_status trace_surface(kn_ctx *ctx, kn_job *job, int surface)
{
    const kn_job_surface *s = &job->surfaces[surface];
    const kn_trim *trim = &job->borders->trims[s->origin];
    tracing t = {.surface = s, .out = &job->borders->surfaces[surface]};
    if (trim->nloops == 0) return KN_OK;
    t.out->top = kn_job_has_mesh(job) ? kn_job_top(job) : -1.0;
    kn_status status = choose_tol(ctx, &t.tol, job, s);
    if (status == KN_OK && t.out->top >= 0.0) status = find_speed(ctx, &t.out->speed, job, s, t.out->top);
    for (int d = 0; d < 2; d++) t.slope[d] = slope_of(&t.affine[d], s, d);
    for (int i = 0; status == KN_OK && i < trim->ncurves; i++) {
        kn_bezier *pieces = NULL;
        size_t n = 0;
        status = kn_spline_to_bezier(ctx, &pieces, &n, &trim->curves[i]);
        for (size_t k = 0; status == KN_OK && k < n; k++) status = trace(ctx, &t, &pieces[k], 0);
        for (size_t k = 0; k < n; k++) kn_bezier_clear(ctx, &pieces[k]);
        kn_free(ctx, pieces);
    }
    t.out->off += 0x1p-38; // the lattice's grid, and roundings
    t.out->first = s->closed[0] ? -s->cells[0] : 0;
    t.out->ncolumns = s->closed[0] ? 3 * s->cells[0] : s->cells[0];
    for (int d = 0; status == KN_OK && d < 2; d++)
        if (s->closed[d] && t.out->n > 0) status = repeat(ctx, t.out, d, s->cells[d]);
    return status == KN_OK ? make_columns(ctx, t.out) : status;
}

static kn_status check(kn_ctx *ctx, bool *any, const kn_job *job)
{
    const kn_job_options *o = &job->options;
    if (o->trimmed != KN_TRIMMED_KEEP && o->trimmed != KN_TRIMMED_CLIP && o->trimmed != KN_TRIMMED_TAPER)
        return kn_fail(ctx, KN_EDOMAIN, "job: trimmed %d", (int)o->trimmed);
    *any = false;
    kn_status status = KN_OK;
    for (int s = 0; o->trims && status == KN_OK && s < job->report.nsurfaces; s++) {
        *any = *any || o->trims[s].nloops > 0;
        status = kn_trim_check(ctx, &o->trims[s]);
    }
    if (status != KN_OK || !*any) return status;
    if (!kn_shell_normal(job->surfaces[0].shell)->coef)
        return kn_fail(ctx, KN_EDOMAIN, "job: volumes cannot be trimmed");
    if (o->spacing == KN_CELLS_FREE)
        return kn_fail(ctx, KN_EDOMAIN,
                       "job: cells with free corners have another domain than the trims of the base: "
                       "another spacing is needed");
    return KN_OK;
}

kn_status kn_job_borders_init(kn_ctx *ctx, kn_job *job)
{
    bool any = false;
    kn_status status = check(ctx, &any, job);
    if (status != KN_OK || !any) return status;
    struct kn_job_borders *b = job->borders = kn_alloc_zero(ctx, 1, sizeof *b);
    if (!b) return KN_ENOMEM;
    b->trims = kn_alloc_zero(ctx, (size_t)job->report.nsurfaces, sizeof *b->trims);
    b->surfaces = kn_alloc_zero(ctx, (size_t)job->nsurfaces, sizeof *b->surfaces);
    b->whole = kn_alloc_zero(ctx, (job->ncells + 63) / 64, sizeof *b->whole);
    if (!b->trims || !b->surfaces || !b->whole) return KN_ENOMEM; // what is there belongs to the job
    b->ntrims = job->report.nsurfaces;
    b->nsurfaces = job->nsurfaces;
    for (int s = 0; status == KN_OK && s < b->ntrims; s++)
        status = kn_trim_copy(ctx, &b->trims[s], &job->options.trims[s]);
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) status = trace_surface(ctx, job, s);
    return status;
}

void kn_job_borders_clear(kn_ctx *ctx, kn_job *job)
{
    struct kn_job_borders *b = job->borders;
    if (!b) return;
    for (int s = 0; b->trims && s < b->ntrims; s++) kn_trim_clear(ctx, &b->trims[s]);
    for (int s = 0; b->surfaces && s < b->nsurfaces; s++) {
        kn_free(ctx, b->surfaces[s].list);
        kn_free(ctx, b->surfaces[s].start);
        kn_free(ctx, b->surfaces[s].index);
    }
    kn_free(ctx, b->trims);
    kn_free(ctx, b->surfaces);
    kn_free(ctx, b->whole);
    kn_free(ctx, b);
    job->borders = NULL;
}
