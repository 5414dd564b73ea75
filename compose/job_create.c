// SPDX-License-Identifier: Apache-2.0
// Planning a job: defaults, counts, shells, pieces.
#include "compose/job.h"
#include "kernel/parallel.h"

#include <math.h>

static const int least_normal_degree = 3; // of n in each variable
static const int usual_normal_degree = 5;

static kn_status check_options(kn_ctx *ctx, const kn_job_options *o)
{
    const double numbers[] = {o->size[0], o->size[1], o->normal_tol, o->mesh_tol};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (!(numbers[i] >= 0.0) || isinf(numbers[i]))
            return kn_fail(ctx, KN_EDOMAIN, "job: sizes and tolerances must be finite and not negative: %g",
                           numbers[i]);
    if (!isfinite(o->height) || !isfinite(o->offset))
        return kn_fail(ctx, KN_EDOMAIN, "job: height %g, offset %g", o->height, o->offset);
    if (o->count[0] < 0 || o->count[1] < 0)
        return kn_fail(ctx, KN_EDOMAIN, "job: count %d, %d", o->count[0], o->count[1]);
    if (o->max_degree < 0) return kn_fail(ctx, KN_EDOMAIN, "job: degree limit %d", o->max_degree);
    if (o->max_degree > KN_MAX_DEGREE)
        return kn_fail(ctx, KN_ELIMIT, "job: degree limit %d, at most %d", o->max_degree, KN_MAX_DEGREE);
    return KN_OK;
}

static kn_status check_surfaces(kn_ctx *ctx, const kn_spline *surfaces, int nsurfaces)
{
    if (nsurfaces < 1) return kn_fail(ctx, KN_EDOMAIN, "job: %d surfaces", nsurfaces);
    kn_status status = KN_OK;
    for (int s = 0; status == KN_OK && s < nsurfaces; s++) {
        if (surfaces[s].nvars != 2 || kn_spline_dim(&surfaces[s]) != 3)
            return kn_fail(ctx, KN_EDOMAIN, "job: surface %d has %d variables, %d components", s, surfaces[s].nvars,
                           kn_spline_dim(&surfaces[s]));
        status = kn_spline_check(ctx, &surfaces[s]);
    }
    return status;
}

static kn_status copy_tile(kn_ctx *ctx, kn_tile *out, const kn_tile *tile)
{
    kn_tile copy = *tile;
    copy.parts = kn_alloc_zero(ctx, (size_t)tile->nparts, sizeof *copy.parts);
    if (!copy.parts) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (int p = 0; p < tile->nparts; p++) {
        const kn_tile_part *from = &tile->parts[p];
        kn_tile_part *to = &copy.parts[p];
        *to = *from;
        to->surfaces = kn_alloc_zero(ctx, (size_t)from->nsurfaces, sizeof *to->surfaces);
        if (!to->surfaces) status = KN_ENOMEM;
        if (status != KN_OK) to->nsurfaces = 0;
        for (int s = 0; status == KN_OK && s < from->nsurfaces; s++)
            status = kn_spline_copy(ctx, &to->surfaces[s], &from->surfaces[s]);
    }
    if (status == KN_OK)
        *out = copy;
    else
        kn_tile_clear(ctx, &copy);
    return status;
}

static kn_status base_diagonal(kn_ctx *ctx, double *out, const kn_spline *surfaces, int nsurfaces)
{
    double least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY}, lo[3], hi[3];
    for (int s = 0; s < nsurfaces; s++) {
        kn_status status = kn_spline_box(ctx, lo, hi, &surfaces[s]);
        if (status != KN_OK) return status;
        for (int c = 0; c < 3; c++) {
            least[c] = fmin(least[c], lo[c]);
            most[c] = fmax(most[c], hi[c]);
        }
    }
    double d[3] = {most[0] - least[0], most[1] - least[1], most[2] - least[2]};
    *out = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (!(*out > 0.0) || isinf(*out)) return kn_fail(ctx, KN_EDOMAIN, "job: a base of diagonal %g", *out);
    return KN_OK;
}

// ---- sizes ----

static void resolve_size(kn_job_options *o, double diagonal)
{
    for (int d = 0; d < 2; d++)
        if (o->size[d] == 0.0) o->size[d] = o->size[1 - d] > 0.0 ? o->size[1 - d] : diagonal / 20.0;
}

// The mean side of a cell, every cell counted once.
static double mean_cell_size(const kn_job_measure *measures, int (*counts)[2], int nsurfaces)
{
    double sum = 0.0, cells = 0.0;
    for (int s = 0; s < nsurfaces; s++) {
        double n = (double)counts[s][0] * counts[s][1];
        for (int d = 0; d < 2; d++) sum += n / 2.0 * kn_job_mean_length(&measures[s], d) / counts[s][d];
        cells += n;
    }
    return sum / cells;
}

// The largest distance from the patch, u and v as long as `cell`, to its triangulation with `segments` in each
// direction, measured in the middle of every edge of the triangles.
static kn_status measure_chord(kn_ctx *ctx, double *chord, const kn_bezier *patch, int segments, double cell)
{
    size_t n = 2 * (size_t)segments + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    double *at = kn_scratch(ctx, n * n, 2 * sizeof *at), *p = kn_scratch(ctx, n * n, 3 * sizeof *p);
    kn_status status = at && p ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n * n; i++) {
        at[2 * i] = (double)(i / n) / (double)(n - 1);
        at[2 * i + 1] = (double)(i % n) / (double)(n - 1);
    }
    if (status == KN_OK) status = kn_bezier_eval_batch(ctx, p, patch, n * n, at);
    for (size_t i = 0; status == KN_OK && i < n * n; i++) {
        p[3 * i] *= cell;
        p[3 * i + 1] *= cell;
    }
    *chord = 0.0;
    for (size_t i = 0; status == KN_OK && i < n * n; i++) {
        // Ends of the edge whose middle is point i: along r, along t, or the diagonal; corners are none.
        size_t odd_r = (i / n) % 2, odd_t = (i % n) % 2, step = odd_r * n + odd_t;
        if (step != 0) *chord = fmax(*chord, kn_job_off_chord(p + 3 * i, p + 3 * (i - step), p + 3 * (i + step)));
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// The least power of two that keeps every patch within mesh_tol, with the base's own bend over its cells.
static kn_status choose_segments(kn_ctx *ctx, kn_job *job, const kn_job_measure *measures, int (*counts)[2])
{
    double bend = 0.0;
    for (int s = 0; s < job->nsurfaces; s++) {
        double here = 0.0;
        for (int d = 0; d < 2; d++) here += measures[s].bend[d] / counts[s][d] / counts[s][d];
        bend = fmax(bend, here);
    }
    job->segments = 2;
    for (int k = 0; k < job->npatches; k++) {
        const kn_bezier *d = &job->patches[k].d;
        size_t n = kn_bezier_count(d);
        double extent = 0.0, chord;
        for (size_t i = 0; i < 2 * n; i++) extent = fmax(extent, fabs(d->coef[i] - d->coef[i < n ? 0 : n]));
        for (; job->segments < KN_JOB_MAX_SEGMENTS; job->segments *= 2) {
            double steps = (double)job->segments * job->segments;
            kn_status status = measure_chord(ctx, &chord, d, job->segments, job->report.cell_size);
            if (status != KN_OK) return status;
            if (chord + bend * extent * extent / steps <= job->options.mesh_tol) break;
        }
    }
    return KN_OK;
}

// Counts and everything that hangs on the size of a cell.
static kn_status decide_sizes(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces)
{
    size_t n = (size_t)job->nsurfaces;
    kn_job_options *o = &job->options;
    kn_job_measure *measures = kn_alloc(ctx, n, sizeof *measures);
    int(*counts)[2] = kn_alloc(ctx, n, sizeof *counts);
    kn_job_partner *partners = kn_alloc(ctx, 4 * n, sizeof *partners);
    double diagonal = 0.0;
    kn_status status = measures && counts && partners ? base_diagonal(ctx, &diagonal, surfaces, job->nsurfaces)
                                                      : KN_ENOMEM;
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++)
        status = kn_job_measure_surface(ctx, &measures[s], &surfaces[s]);
    resolve_size(o, diagonal);
    if (status == KN_OK) status = kn_job_find_partners(ctx, partners, surfaces, job->nsurfaces, 1e-9 * diagonal);
    if (status == KN_OK) status = kn_job_counts(ctx, counts, surfaces, job->nsurfaces, measures, o, partners);
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) {
        size_t cells = (size_t)counts[s][0] * (size_t)counts[s][1];
        job->surfaces[s].first_cell = job->ncells;
        for (int d = 0; d < 2; d++) job->surfaces[s].cells[d] = counts[s][d];
        for (int e = 0; e < 4; e++) job->surfaces[s].partner[e] = partners[4 * s + e];
        if (cells > KN_JOB_MAX_CELLS - job->ncells)
            status = kn_fail(ctx, KN_ELIMIT, "job: more than %zu cells", KN_JOB_MAX_CELLS);
        else
            job->ncells += cells;
    }
    if (status == KN_OK) {
        double size = mean_cell_size(measures, counts, job->nsurfaces);
        if (o->height == 0.0) o->height = (job->tile.aspect > 0.0 ? job->tile.aspect : 1.0) * size;
        if (o->mesh_tol == 0.0) o->mesh_tol = size / 100.0;
        job->report.cell_size = size;
        job->report.height = o->height;
        status = kn_job_make_patches(ctx, job);
    }
    if (status == KN_OK) status = choose_segments(ctx, job, measures, counts);
    kn_free(ctx, measures);
    kn_free(ctx, counts);
    kn_free(ctx, partners);
    return status;
}

// ---- shells ----

// A tile patch of degree m over S of degrees (a,b) and n of (p,q), summed to A and N, composes to degree
// m max(A, N + 1), and with rational S, where w n is multiplied by the weight of degrees (a,b), to m (A + N + 1).
static kn_status fit_degrees(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces)
{
    int tile = 1, limit = job->options.max_degree;
    for (int k = 0; k < job->npatches; k++)
        for (int d = 0; d < 2; d++)
            if (job->patches[k].d.degree[d] > tile) tile = job->patches[k].d.degree[d];
    for (int s = 0; s < job->nsurfaces; s++) {
        const int *degree = surfaces[s].degree;
        int a = degree[0] + degree[1], weight = surfaces[s].rational ? a : 0;
        int least = 2 * least_normal_degree + 1 + weight;
        if (a > least) least = a;
        if (tile * least > limit)
            return kn_fail(ctx, KN_EDOMAIN,
                           "job: tile patches of degree %d over surface %d of degrees %d, %d compose to degree %d or "
                           "more, and the limit is %d: --max-degree %d is needed%s",
                           tile, s, degree[0], degree[1], tile * least, limit, tile * least,
                           tile * least > KN_MAX_DEGREE ? ", which is more than there is" : "");
        job->surfaces[s].degree_sum = limit / tile - 1 - weight;
    }
    return KN_OK;
}

typedef struct shells {
    kn_job *job;
    const kn_spline *surfaces;
    double w[2]; // the heights that the tile occupies
} shells;

static kn_status make_shell(kn_ctx *ctx, void *user, size_t index)
{
    const shells *all = user;
    const kn_spline *s = &all->surfaces[index];
    kn_job_surface *to = &all->job->surfaces[index];
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < 2; d++)
        status = kn_job_make_lines(ctx, &to->lines[d], &to->knot[d], s, d, to->cells[d]);
    if (status != KN_OK) return status;

    kn_shell_options o = kn_shell_defaults();
    for (int d = 0; d < 2; d++) {
        o.lines[d] = to->lines[d];
        o.nlines[d] = to->cells[d] + 1;
        if (4 * to->cells[d] > 4096 && 4 * to->cells[d] > o.max_spans) o.max_spans = 4 * to->cells[d];
    }
    o.normal_tol = all->job->options.normal_tol;
    o.max_degree = to->degree_sum / 2 < usual_normal_degree ? to->degree_sum / 2 : usual_normal_degree;
    status = kn_shell_create(ctx, &to->shell, s, &o);
    if (status != KN_OK) return status;

    kn_shell_closed(to->shell, to->closed);
    return kn_shell_jacobian_bounds(ctx, &to->jacobian[0], &to->jacobian[1], to->shell, all->w[0], all->w[1]);
}

static kn_status make_shells(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces)
{
    shells all = {job, surfaces, {INFINITY, -INFINITY}};
    for (int k = 0; k < job->npatches; k++) {
        size_t n = kn_bezier_count(&job->patches[k].d);
        const double *w = job->patches[k].d.coef + 2 * n;
        for (size_t i = 0; i < n; i++) {
            all.w[0] = fmin(all.w[0], w[i]);
            all.w[1] = fmax(all.w[1], w[i]);
        }
    }
    kn_status status = fit_degrees(ctx, job, surfaces);
    if (status == KN_OK) status = kn_parallel(ctx, (size_t)job->nsurfaces, make_shell, &all, "shell");
    if (status == KN_OK) status = kn_job_match_edges(ctx, job);
    job->report.jacobian_lo = INFINITY;
    job->report.jacobian_hi = -INFINITY;
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) {
        job->report.jacobian_lo = fmin(job->report.jacobian_lo, job->surfaces[s].jacobian[0]);
        job->report.jacobian_hi = fmax(job->report.jacobian_hi, job->surfaces[s].jacobian[1]);
    }
    return status;
}

static kn_status plan(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces, const kn_tile *tile)
{
    kn_status status = copy_tile(ctx, &job->tile, tile);
    if (status == KN_OK) status = kn_tile_rotate(ctx, &job->tile, job->options.quarter_turns);
    if (status == KN_OK) status = decide_sizes(ctx, job, surfaces);
    if (status == KN_OK) status = make_shells(ctx, job, surfaces);
    if (status == KN_OK) status = kn_job_plan(ctx, job);
    return status;
}

kn_status kn_job_create(kn_ctx *ctx, kn_job **out, const kn_spline *surfaces, int nsurfaces, const kn_tile *tile,
                        const kn_job_options *options)
{
    kn_job_options o = options ? *options : kn_job_defaults();
    kn_status status = check_options(ctx, &o);
    if (status == KN_OK) status = check_surfaces(ctx, surfaces, nsurfaces);
    if (status == KN_OK) status = kn_tile_check(ctx, tile);
    if (status != KN_OK) return status;
    if (o.max_degree == 0) o.max_degree = 25;
    if (o.normal_tol == 0.0) o.normal_tol = 1e-6;

    kn_job *job = kn_alloc_zero(ctx, 1, sizeof *job);
    if (!job) return KN_ENOMEM;
    job->options = o;
    job->nsurfaces = job->report.nsurfaces = nsurfaces;
    job->report.normal_tol = o.normal_tol;
    job->report.max_degree = o.max_degree;
    job->surfaces = kn_alloc_zero(ctx, (size_t)nsurfaces, sizeof *job->surfaces);
    status = job->surfaces ? plan(ctx, job, surfaces, tile) : KN_ENOMEM;
    if (status == KN_OK)
        *out = job;
    else
        kn_job_destroy(ctx, job);
    return status;
}
