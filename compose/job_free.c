// SPDX-License-Identifier: Apache-2.0
// Cells with free corners: S of each part becomes S(map), over [0,n] x [0,m] for n x m cells.
#include "compose/job.h"

#include <math.h>

static const double usual_tolerance = 1e-4; // of a cell

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

// A part keeps its even lines where no smooth map is found.
static kn_status free_part(kn_ctx *ctx, kn_job *job, kn_spline *face, int surface, double tolerance)
{
    kn_job_surface *s = &job->surfaces[surface];
    kn_cells_relax_options o = {.smooth = true, .lines = {s->lines[0], s->lines[1]}};
    kn_spline map = {0};
    double error = 0.0, *lines[2] = {NULL, NULL};
    find_ends(&o, s, surface);
    kn_status status = kn_cells_relax(ctx, &map, face, s->cells, &o);
    if (status == KN_EUNDECIDED) { // too few cells to bend the lines without a fold: they stay
        kn_ctx_clear_error(ctx);
        return KN_OK;
    }
    if (status == KN_OK) status = kn_cells_fit(ctx, face, &error, face, &map, tolerance);
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
    kn_spline_clear(ctx, &map);
    return status;
}

kn_status kn_job_free_corners(kn_ctx *ctx, kn_job *job, kn_job_bases *bases, double cell)
{
    kn_status status = check(ctx, job, bases);
    double tolerance = job->options.cells_tol > 0.0 ? job->options.cells_tol : usual_tolerance * cell;
    for (int s = 0; status == KN_OK && s < bases->n; s++) {
        status = free_part(ctx, job, &bases->faces[s], s, tolerance);
        if (status == KN_OK) status = kn_progress(ctx, "corners", (s + 1.0) / bases->n);
    }
    return status;
}
