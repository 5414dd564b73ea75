// SPDX-License-Identifier: Apache-2.0
// Counts of cells, and everything that hangs on the size of a cell.
#include "job/internal.h"

#include <math.h>

kn_status kn_job_diagonal(kn_ctx *ctx, double *out, const kn_spline *surfaces, int nsurfaces)
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

void kn_job_resolve_size(kn_job_options *o, double diagonal)
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

// The largest distance from the patch, u and v as long as `cell` and w as `w_length`, to its triangulation with
// `segments` in each direction, measured in the middle of every edge of the triangles. Of a volume on its face `face`,
// of a curve along it.
static kn_status measure_sheet(kn_ctx *ctx, double *chord, const kn_bezier *patch, int face, int segments,
                               double cell, double w_length)
{
    size_t n = 2 * (size_t)segments + 1, rows = patch->nvars == 1 ? 1 : n, nvars = (size_t)patch->nvars;
    size_t fixed = nvars == 3 ? (size_t)face / 2 : nvars; // variable
    kn_mark mark = kn_scratch_mark(ctx);
    double *at = kn_scratch(ctx, rows * n, nvars * sizeof *at), *p = kn_scratch(ctx, rows * n, 3 * sizeof *p);
    kn_status status = at && p ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < rows * n; i++) {
        size_t index[2] = {i % n, i / n}, k = 0;
        for (size_t v = nvars; v-- > 0;) // the last one fastest
            at[nvars * i + v] = v == fixed ? face % 2 : (double)index[k++] / (double)(n - 1);
    }
    if (status == KN_OK) status = kn_bezier_eval_batch(ctx, p, patch, rows * n, at);
    for (size_t i = 0; status == KN_OK && i < rows * n; i++) {
        p[3 * i] *= cell;
        p[3 * i + 1] *= cell;
        p[3 * i + 2] *= w_length;
    }
    for (size_t i = 0; status == KN_OK && i < rows * n; i++) {
        // Ends of the edge whose middle is point i: along r, along t, or the diagonal; corners are none.
        size_t odd_r = (i / n) % 2, odd_t = (i % n) % 2, step = odd_r * n + odd_t;
        if (step != 0) *chord = fmax(*chord, kn_job_off_chord(p + 3 * i, p + 3 * (i - step), p + 3 * (i + step)));
    }
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status measure_chord(kn_ctx *ctx, double *chord, const kn_bezier *patch, int segments, double cell,
                               double w_length)
{
    kn_status status = KN_OK;
    *chord = 0.0;
    for (int face = 0; status == KN_OK && face < (patch->nvars == 3 ? 6 : 1); face++)
        status = measure_sheet(ctx, chord, patch, face, segments, cell, w_length);
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
            kn_status status = measure_chord(ctx, &chord, d, job->segments, job->report.cell_size, job->w_length);
            if (status != KN_OK) return status;
            if (chord + bend * extent * extent / steps <= job->options.mesh_tol) break;
        }
    }
    return KN_OK;
}

// What is measured of all surfaces on the way.
typedef struct sizes {
    kn_job_measure *measures;
    int (*counts)[2];
    kn_job_partner *partners;
    kn_job_class *classes;
} sizes;

static kn_status measure_all(kn_ctx *ctx, sizes *z, const kn_spline *surfaces, int n)
{
    kn_status status = KN_OK;
    for (int s = 0; status == KN_OK && s < n; s++)
        status = kn_job_measure_surface(ctx, &z->measures[s], &surfaces[s]);
    return status;
}

// Counts of cells, and which edges meet.
static kn_status count_cells(kn_ctx *ctx, kn_job *job, sizes *z, const kn_spline *surfaces)
{
    int n = job->nsurfaces;
    kn_mark mark = kn_scratch_mark(ctx);
    int *bodies = kn_scratch(ctx, (size_t)n, sizeof *bodies);
    kn_status status = bodies ? KN_OK : KN_ENOMEM;
    for (int s = 0; status == KN_OK && s < n; s++) bodies[s] = job->surfaces[s].body;
    if (status == KN_OK) status = kn_job_find_partners(ctx, z->partners, surfaces, bodies, n, 1e-9 * job->diagonal);
    kn_scratch_release(ctx, mark);
    if (status == KN_OK) status = kn_job_find_classes(ctx, z->classes, z->partners, n);
    if (status == KN_OK) status = kn_job_counts(ctx, z->counts, job, surfaces, z->measures, z->classes);
    for (int s = 0; status == KN_OK && s < n; s++) {
        size_t cells = (size_t)z->counts[s][0] * (size_t)z->counts[s][1];
        job->surfaces[s].first_cell = job->ncells;
        for (int d = 0; d < 2; d++) job->surfaces[s].cells[d] = z->counts[s][d];
        for (int e = 0; e < 4; e++) job->surfaces[s].partner[e] = z->partners[4 * s + e];
        if (cells > KN_JOB_MAX_CELLS - job->ncells)
            status = kn_fail(ctx, KN_ELIMIT, "job: more than %zu cells", KN_JOB_MAX_CELLS);
        else
            job->ncells += cells;
    }
    if (status == KN_OK) kn_job_number_cells(job);
    return status;
}

static kn_status place_cells(kn_ctx *ctx, kn_job *job, sizes *z, kn_job_bases *bases)
{
    kn_status status = kn_job_make_lines(ctx, job, bases->faces, z->classes);
    if (status == KN_OK && job->options.spacing == KN_CELLS_FREE) {
        status = kn_job_free_corners(ctx, job, bases, mean_cell_size(z->measures, z->counts, job->nsurfaces));
        if (status == KN_OK) status = measure_all(ctx, z, bases->faces, job->nsurfaces);
    }
    if (status == KN_OK) status = kn_job_measure_spread(ctx, job, bases->faces);
    if (status == KN_OK && job->options.stretch) status = kn_job_stretch(ctx, job, bases);
    return status;
}

static kn_status decide_heights(kn_ctx *ctx, kn_job *job, const sizes *z)
{
    kn_job_options *o = &job->options;
    double size = mean_cell_size(z->measures, z->counts, job->nsurfaces);
    if (o->height == 0.0) o->height = (job->tile.aspect > 0.0 ? job->tile.aspect : 1.0) * size;
    if (o->mesh_tol == 0.0) o->mesh_tol = size / 100.0;
    if (o->crossing_tol == 0.0) o->crossing_tol = size / 1000.0;
    if (o->taper == 0.0 && o->trimmed == KN_TRIMMED_TAPER) o->taper = size;
    if (o->side == KN_JOB_BELOW) o->height = -fabs(o->height);
    job->report.cell_size = size;
    job->report.height = o->height;
    kn_status status = kn_job_make_patches(ctx, job);
    return status == KN_OK ? choose_segments(ctx, job, z->measures, z->counts) : status;
}

kn_status kn_job_decide_sizes(kn_ctx *ctx, kn_job *job, kn_job_bases *bases)
{
    size_t n = (size_t)job->nsurfaces;
    sizes z = {.measures = kn_alloc(ctx, n, sizeof *z.measures)};
    z.counts = kn_alloc(ctx, n, sizeof *z.counts);
    z.partners = kn_alloc(ctx, 4 * n, sizeof *z.partners);
    z.classes = kn_alloc(ctx, 2 * n, sizeof *z.classes);
    bool room = z.measures && z.counts && z.partners && z.classes;
    kn_status status = room ? kn_job_diagonal(ctx, &job->diagonal, bases->faces, bases->n) : KN_ENOMEM;
    kn_job_resolve_size(&job->options, job->diagonal);
    if (status == KN_OK) status = measure_all(ctx, &z, bases->faces, job->nsurfaces);
    if (status == KN_OK) status = count_cells(ctx, job, &z, bases->faces);
    if (status == KN_OK) status = place_cells(ctx, job, &z, bases);
    if (status == KN_OK) status = decide_heights(ctx, job, &z);
    kn_free(ctx, z.measures);
    kn_free(ctx, z.counts);
    kn_free(ctx, z.partners);
    kn_free(ctx, z.classes);
    return status;
}
