// SPDX-License-Identifier: Apache-2.0
// Boxes in space that certainly contain what a cell's tiles compose to, without composing.
//
// Over a box of (u,v) inside one piece of S a point of the result is S + w m, m the normal in use: n or a stand-in,
// each within e = length error + angle error <= 2 normal_tol of the unit normal. So it lies in
//     hull(S over the box) + w (hull(n over the box) + 2 e),
// and beyond the domain, where n may drift off, in hull(S) + w [-1 - e, 1 + e]. S is restricted to the box, with its
// rounding (kn_bezier_box); of n the control points that act there will do, for it turns little over a few cells.
// Where T has fields, or is a volume, the control points of T itself that act there are taken, over all heights.
// What composing rounds is inside `slack`.
#include "job/placement.h"
#include "kernel/bounds.h"
#include "kernel/knots.h"

#include <math.h>

// More roundings than any composition makes, gamma(n) about n 2^-53 (docs/numerics.md, compose).
static const double roundings = 8192.0 * 0x1p-53;

static void clear_pieces(kn_ctx *ctx, kn_job_bounds_pieces *p)
{
    for (size_t i = 0; i < p->n; i++) kn_bezier_clear(ctx, &p->list[i]);
    kn_free(ctx, p->list);
    for (int d = 0; d < 2; d++) kn_free(ctx, p->breaks[d]);
}

void kn_job_bounds_clear(kn_ctx *ctx, kn_job_bounds *b)
{
    for (int s = 0; b->surfaces && s < b->job->nsurfaces; s++) {
        kn_job_bounds_surface *to = &b->surfaces[s];
        clear_pieces(ctx, &to->s);
        clear_pieces(ctx, &to->n);
        kn_spline_clear(ctx, &to->volume);
    }
    kn_free(ctx, b->surfaces);
    *b = (kn_job_bounds){0};
}

static kn_status take_pieces(kn_ctx *ctx, kn_job_bounds_pieces *to, const kn_spline *s)
{
    for (int d = 0; d < 2; d++) {
        to->nbreaks[d] = kn_spline_spans(s, d) + 1;
        to->breaks[d] = kn_alloc(ctx, (size_t)to->nbreaks[d], sizeof **to->breaks);
        if (!to->breaks[d]) return KN_ENOMEM;
        (void)kn_knots_breaks(to->breaks[d], NULL, s->knots[d], s->degree[d], s->count[d]);
    }
    return kn_spline_to_bezier(ctx, &to->list, &to->n, s);
}

// Heights that are a little apart, for T as a volume.
static kn_status take_volume(kn_ctx *ctx, kn_job_bounds_surface *to, const kn_shell *shell, const double w[2])
{
    double all[2], lo = w[0], hi = w[1];
    kn_shell_heights(shell, all);
    lo = fmin(fmax(lo, all[0]), all[1]), hi = fmin(fmax(hi, all[0]), all[1]);
    if (!(lo < hi)) {
        double middle = lo, step = fmax(fabs(lo), 1.0) * 0x1p-20;
        lo = fmax(middle - step, all[0]), hi = fmin(middle + step, all[1]);
    }
    return kn_shell_volume(ctx, &to->volume, shell, lo, hi);
}

double kn_job_top(const kn_job *job)
{
    double top = 0.0;
    for (int k = 0; k < job->npatches; k++) top = fmax(top, job->patches[k].top);
    for (int p = 0; p < job->tile.nparts; p++) {
        const kn_mesh *mesh = &job->tile.parts[p].mesh;
        for (size_t i = 0; i < mesh->nvertices; i++)
            top = fmax(top, fabs(kn_job_place_w(&job->options, mesh->position[3 * i + 2])));
    }
    return top;
}

bool kn_job_has_mesh(const kn_job *job)
{
    for (int p = 0; p < job->tile.nparts; p++)
        if (job->tile.parts[p].mesh.nvertices > 0) return true;
    return false;
}

kn_status kn_job_bounds_init(kn_ctx *ctx, kn_job_bounds *out, const kn_job *job)
{
    kn_job_bounds b = {.job = job};
    b.w[1] = kn_job_top(job);
    b.w[0] = -b.w[1]; // a tile may go on over an edge at which n turns over
    b.surfaces = kn_alloc_zero(ctx, (size_t)job->nsurfaces, sizeof *b.surfaces);
    kn_status status = b.surfaces ? KN_OK : KN_ENOMEM;
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) {
        const kn_shell *shell = job->surfaces[s].shell;
        kn_job_bounds_surface *to = &b.surfaces[s];
        double lo[3], hi[3];
        status = kn_spline_box(ctx, lo, hi, kn_shell_surface(shell));
        for (int c = 0; status == KN_OK && c < 3; c++) to->size = fmax(to->size, fmax(fabs(lo[c]), fabs(hi[c])));
        if (status == KN_OK && (job->has_fields || !kn_shell_normal(shell)->coef))
            status = take_volume(ctx, to, shell, b.w);
        else if (status == KN_OK)
            status = take_pieces(ctx, &to->s, kn_shell_surface(shell));
        if (status == KN_OK && to->s.n > 0 && kn_job_has_mesh(job))
            status = take_pieces(ctx, &to->n, kn_shell_normal(shell));
    }
    if (status == KN_OK)
        *out = b;
    else
        kn_job_bounds_clear(ctx, &b);
    return status;
}

// ---- one box ----

// The interval of (u or v) that a box of a cell is, as kn_shell_piece_init takes it; whether it is inside the domain.
static bool interval(double *a, double *b, const kn_job_surface *s, int d, int cell, double lo, double hi)
{
    int n = s->cells[d];
    if (s->closed[d]) {
        cell = (cell % n + n) % n;
    } else {
        int near = cell < 0 ? 0 : cell >= n ? n - 1 : cell;
        lo += cell - near, hi += cell - near;
        cell = near;
    }
    const double *line = s->lines[d];
    double width = line[cell + 1] - line[cell];
    *a = lo == 1.0 ? line[cell + 1] : line[cell] + lo * width;
    *b = hi == 1.0 ? line[cell + 1] : line[cell] + hi * width;
    double period = s->closed[d] ? line[n] - line[0] : 0.0;
    if (*a >= line[n]) *a -= period, *b -= period;
    if (*b <= line[0]) *a += period, *b += period;
    return *a >= line[0] && *b <= line[n];
}

static int find_break(const double *breaks, int n, double t)
{
    int lo = 0, hi = n - 1;
    while (hi - lo > 1) {
        int middle = lo + (hi - lo) / 2;
        *(t < breaks[middle] ? &hi : &lo) = middle;
    }
    return lo;
}

// S, or n, over the parameters [a,b], one piece after the other; the end pieces go on beyond the domain. Local
// coordinates are off by a few roundings of numbers near 1: so much wider.
static kn_status pieces_box(kn_ctx *ctx, double *lo, double *hi, const kn_job_bounds_pieces *s, const double a[2],
                            const double b[2])
{
    int first[2], last[2], at[2];
    for (int d = 0; d < 2; d++) {
        first[d] = find_break(s->breaks[d], s->nbreaks[d], a[d]);
        last[d] = find_break(s->breaks[d], s->nbreaks[d], b[d]);
        while (last[d] > first[d] && s->breaks[d][last[d]] >= b[d]) last[d]--;
    }
    for (int c = 0; c < 3; c++) lo[c] = INFINITY, hi[c] = -INFINITY;
    for (at[0] = first[0]; at[0] <= last[0]; at[0]++)
        for (at[1] = first[1]; at[1] <= last[1]; at[1]++) {
            double from[2], to[2], least[3], most[3];
            for (int d = 0; d < 2; d++) {
                double start = s->breaks[d][at[d]], width = s->breaks[d][at[d] + 1] - start;
                double more = 16.0 * 0x1p-53 * (1.0 + (fabs(start) + fabs(width)) / width);
                from[d] = at[d] > first[d] ? 0.0 : (a[d] - start) / width - more;
                to[d] = at[d] < last[d] ? 1.0 : (b[d] - start) / width + more;
            }
            size_t index = (size_t)at[0] * (size_t)(s->nbreaks[1] - 1) + (size_t)at[1];
            kn_status status = kn_bezier_box(ctx, least, most, &s->list[index], from, to);
            if (status != KN_OK) return status;
            for (int c = 0; c < 3; c++) lo[c] = fmin(lo[c], least[c]), hi[c] = fmax(hi[c], most[c]);
        }
    return KN_OK;
}

// The control points of f that act over [a,b] of its first two variables.
static void acting(int first[2], int last[2], const kn_spline *f, const double a[2], const double b[2])
{
    for (int d = 0; d < 2; d++) {
        const double *knots = f->knots[d];
        first[d] = kn_knots_span(knots, f->degree[d], f->count[d], a[d]) - f->degree[d];
        last[d] = kn_knots_span(knots, f->degree[d], f->count[d], b[d]);
        while (last[d] > first[d] + f->degree[d] && knots[last[d]] >= b[d]) last[d]--;
    }
}

// Their box, with all of a third variable: f is in their hull.
static void acting_box(double *lo, double *hi, const kn_spline *f, const double a[2], const double b[2])
{
    int first[2], last[2], dim = kn_spline_dim(f);
    acting(first, last, f, a, b);
    size_t n = kn_spline_count(f), deep = f->nvars > 2 ? (size_t)f->count[2] : 1;
    size_t run = (size_t)(last[1] - first[1] + 1) * deep;
    for (int c = 0; c < dim; c++) {
        lo[c] = INFINITY, hi[c] = -INFINITY;
        for (int i = first[0]; i <= last[0]; i++) {
            size_t at = ((size_t)i * (size_t)f->count[1] + (size_t)first[1]) * deep;
            const double *w = f->rational ? f->coef + (size_t)dim * n + at : NULL;
            double least, most;
            kn_hull_range(&least, &most, run, f->coef + (size_t)c * n + at, NULL, w, NULL);
            lo[c] = fmin(lo[c], least), hi[c] = fmax(hi[c], most);
        }
    }
}

// [lo,hi] += [w0,w1] [a,b]
static void add_product(double *lo, double *hi, const double w[2], double a, double b)
{
    double p[4] = {w[0] * a, w[0] * b, w[1] * a, w[1] * b};
    *lo += fmin(fmin(p[0], p[1]), fmin(p[2], p[3]));
    *hi += fmax(fmax(p[0], p[1]), fmax(p[2], p[3]));
}

kn_status kn_job_bounds_box(kn_ctx *ctx, double lo[3], double hi[3], const kn_job_bounds *bounds,
                            const kn_job_place *place, const kn_job_extent *e)
{
    const kn_job_surface *s = &bounds->job->surfaces[place->surface];
    const kn_job_bounds_surface *from = &bounds->surfaces[place->surface];
    double a[2], b[2], tol = 2.0 * bounds->job->options.normal_tol;
    bool inside = true;
    for (int d = 0; d < 2; d++) inside = interval(&a[d], &b[d], s, d, place->cell[d], e->lo[d], e->hi[d]) && inside;
    double top = fmax(fabs(e->w[0]), fabs(e->w[1])), size = from->size + top;
    const kn_job_options *o = &bounds->job->options;
    const kn_job_border *border = o->placement.border; // trims are off by as much
    bool apart = o->crossing != KN_CROSSING_REFUSE || border[0] == KN_BORDER_CLIP || border[1] == KN_BORDER_CLIP;
    double extra = apart ? bounds->job->options.crossing_tol : 0.0;
    if (from->volume.coef) {
        for (int c = 0; c < 3; c++) lo[c] = -INFINITY, hi[c] = INFINITY;
        bool heights = e->w[0] >= bounds->w[0] && e->w[1] <= bounds->w[1];
        if (!inside || !heights || (apart && extra == 0.0)) return KN_OK;
        acting_box(lo, hi, &from->volume, a, b);
        size = 0.0;
        for (int c = 0; c < 3; c++) size = fmax(size, fmax(fabs(lo[c]), fabs(hi[c])));
        // a stand-in moves n by 2 e, of a thickness that fills the hull at most
        for (int c = 0; c < 3; c++) lo[c] -= 2.0 * tol * size, hi[c] += 2.0 * tol * size;
    } else if ((!inside && e->drifts && from->n.n == 0) || (apart && extra == 0.0)) {
        for (int c = 0; c < 3; c++) lo[c] = -INFINITY, hi[c] = INFINITY;
        return KN_OK;
    } else {
        kn_status status = pieces_box(ctx, lo, hi, &from->s, a, b);
        if (status != KN_OK) return status;
        double n_lo[3] = {-1.0, -1.0, -1.0}, n_hi[3] = {1.0, 1.0, 1.0};
        if (inside) acting_box(n_lo, n_hi, kn_shell_normal(s->shell), a, b);
        if (!inside && e->drifts) { // a mesh takes n as it goes on, patches a stand-in for the unit normal
            status = pieces_box(ctx, n_lo, n_hi, &from->n, a, b);
            if (status != KN_OK) return status;
            for (int c = 0; c < 3; c++) n_lo[c] = fmin(n_lo[c], -1.0), n_hi[c] = fmax(n_hi[c], 1.0);
        }
        for (int c = 0; c < 3; c++) {
            add_product(&lo[c], &hi[c], e->w, n_lo[c] - 2.0 * tol, n_hi[c] + 2.0 * tol);
            size = fmax(size, fmax(fabs(lo[c]), fabs(hi[c])));
        }
    }
    for (int c = 0; c < 3; c++) lo[c] -= roundings * size + extra, hi[c] += roundings * size + extra;
    return KN_OK;
}

// The box of (u,v) after the turns that lead into a place.
static void turn_box(kn_job_extent *e, int turn)
{
    for (int k = 0; k < (turn & 3); k++) { // (u, v) -> (1 - v, u)
        double lo = e->lo[0], hi = e->hi[0];
        e->lo[0] = 1.0 - e->hi[1], e->hi[0] = 1.0 - e->lo[1];
        e->lo[1] = lo, e->hi[1] = hi;
    }
    if ((turn & KN_JOB_FLIP) == 0) return;
    double hi = e->hi[1], w = e->w[1];
    e->hi[1] = 1.0 - e->lo[1], e->lo[1] = 1.0 - hi;
    e->w[1] = -e->w[0], e->w[0] = -w;
}

bool kn_job_place_extent(kn_job_place *place, kn_job_extent *e, const kn_job *job, int surface, const int cell[2])
{
    double end[2][2];
    *place = kn_job_find_place(job, surface, cell, e->offset);
    turn_box(e, place->turn);
    kn_job_clip_ends(end, job, place);
    return kn_job_clip_box(e->lo, e->hi, (const double(*)[2])end) != KN_CLIP_OUTSIDE;
}

kn_status kn_job_bounds_cell(kn_ctx *ctx, double lo[3], double hi[3], const kn_job_bounds *bounds, int surface,
                             const int cell[2], const kn_job_extents *extents)
{
    kn_status status = KN_OK;
    for (int c = 0; c < 3; c++) lo[c] = INFINITY, hi[c] = -INFINITY;
    for (int k = 0; status == KN_OK && k < extents->count; k++) {
        kn_job_extent e = extents->list[k];
        kn_job_place place;
        double least[3], most[3];
        if (!kn_job_place_extent(&place, &e, bounds->job, surface, cell)) continue;
        status = kn_job_bounds_box(ctx, least, most, bounds, &place, &e);
        for (int c = 0; status == KN_OK && c < 3; c++) lo[c] = fmin(lo[c], least[c]), hi[c] = fmax(hi[c], most[c]);
    }
    return status;
}

double kn_job_bounds_facing(const kn_job_bounds *bounds, int surface, const int cell[2], const double direction[3])
{
    const kn_job_surface *s = &bounds->job->surfaces[surface];
    const kn_spline *n = kn_shell_normal(s->shell);
    double a[2], b[2], most = -INFINITY;
    int first[2], last[2];
    for (int d = 0; d < 2; d++) (void)interval(&a[d], &b[d], s, d, cell[d], 0.0, 1.0);
    acting(first, last, n, a, b);
    size_t count = kn_spline_count(n);
    for (int i = first[0]; i <= last[0]; i++)
        for (int j = first[1]; j <= last[1]; j++) {
            const double *c = n->coef + (size_t)i * (size_t)n->count[1] + (size_t)j;
            double dot = c[0] * direction[0] + c[count] * direction[1] + c[2 * count] * direction[2];
            most = fmax(most, dot);
        }
    return most + 4.0 * bounds->job->options.normal_tol + 1e-14;
}
