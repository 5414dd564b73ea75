// SPDX-License-Identifier: Apache-2.0
// Cells with free corners: S of each part becomes S(map), over [0,n] x [0,m] for n x m cells.
#include "job/internal.h"

#include <math.h>

static const int least_degree_sum = 6; // of a fit (cells.h)
// Of a cell: what is wished for, and what is taken where max_degree does not leave room for more.
static const double usual_tolerance = 1e-4, largest_error = 1e-3;

static kn_status check(kn_ctx *ctx, const kn_job *job, const kn_job_bases *bases)
{
    const kn_job_options *o = &job->options;
    if (bases->list[0].volume.coef) return kn_fail(ctx, KN_EDOMAIN, "job: free corners over a volume");
    if (o->thickness || o->direction || o->attraction)
        return kn_fail(ctx, KN_EDOMAIN,
                       "job: free corners move the parameters of S away from those of thickness, direction or "
                       "attraction");
    return KN_OK;
}

// Edges that meet the other end of the same surface close it; those that meet anything else keep their corners.
static void find_ends(kn_cells_relax_options *o, const kn_job_surface *s, int surface)
{
    for (int e = 0; e < 4; e++) {
        const kn_job_partner *p = &s->partner[e];
        if (p->edge < 0) continue;
        if (p->edge == 4 * surface + (e ^ 1) && p->single && !p->reversed)
            o->closed[e / 2] = true;
        else
            o->fixed[e / 2][e % 2] = true;
    }
}

// The sum of a face's degrees for which tile patches stay within max_degree. An exact direction of it has twice the
// sum less 2, 6 more to make it a unit, and w.
static int room_for_degrees(const kn_job *job)
{
    int room = job->options.max_degree / kn_job_tile_degree(job);
    if (job->options.normal == KN_NORMAL_EXACT_DIRECTION) room = (room - 5) / 2;
    return room > least_degree_sum ? room : least_degree_sum; // else kn_job_make_shells says what is needed
}

// What stands for the face, or KN_EUNDECIDED: too few cells to bend the lines without a fold, or to stay near S.
static kn_status fit_free(kn_ctx *ctx, kn_spline *face, double *error, const kn_job *job, int surface, double cell)
{
    const kn_job_surface *s = &job->surfaces[surface];
    kn_cells_relax_options o = {.smooth = true, .lines = {s->lines[0], s->lines[1]}};
    kn_cells_fit_options f = {
        .tolerance = usual_tolerance * cell, .at_most = largest_error * cell, .degree_sum = room_for_degrees(job)};
    if (job->options.cells_tol > 0.0) f.tolerance = job->options.cells_tol, f.at_most = 0.0;
    kn_spline map = {0};
    find_ends(&o, s, surface);
    kn_status status = kn_cells_relax(ctx, &map, face, s->cells, &o);
    if (status == KN_OK) status = kn_cells_fit(ctx, face, error, face, &map, &f);
    kn_spline_clear(ctx, &map);
    return status;
}

// A part keeps its even lines where nothing else is found.
static kn_status free_part(kn_ctx *ctx, kn_job *job, kn_spline *face, int surface, double cell)
{
    kn_job_surface *s = &job->surfaces[surface];
    double error = 0.0, *lines[2] = {NULL, NULL};
    kn_status status = fit_free(ctx, face, &error, job, surface, cell);
    if (status == KN_EUNDECIDED) {
        kn_ctx_clear_error(ctx);
        job->report.even_instead++;
        return KN_OK;
    }
    for (int d = 0; status == KN_OK && d < 2; d++)
        status = kn_cells_uniform_lines(ctx, &lines[d], face, d, s->cells[d]);
    for (int d = 0; d < 2; d++) {
        if (status == KN_OK) {
            double *old = s->lines[d];
            s->lines[d] = lines[d], lines[d] = old;
        }
        for (int i = 0; status == KN_OK && i <= s->cells[d]; i++) s->knot[d][i] = true;
        kn_free(ctx, lines[d]);
    }
    if (status == KN_OK) job->report.cells_error = fmax(job->report.cells_error, error);
    return status;
}

kn_status kn_job_free_corners(kn_ctx *ctx, kn_job *job, kn_job_bases *bases, double cell)
{
    kn_status status = check(ctx, job, bases);
    for (int s = 0; status == KN_OK && s < bases->n; s++) {
        status = free_part(ctx, job, &bases->faces[s], s, cell);
        if (status == KN_OK) status = kn_progress(ctx, "corners", (s + 1.0) / bases->n);
    }
    return status;
}
