// SPDX-License-Identifier: Apache-2.0
// Cell lines of all surfaces, and how even the cells between them are.
#include "job/internal.h"

#include <string.h>

// Which lines are knots of S, or ends of its domain: those that are equal to one.
static kn_status find_knots(kn_ctx *ctx, bool **out, const double *lines, int count, const kn_spline *s, int var)
{
    bool *knot = kn_alloc_zero(ctx, (size_t)count + 1, sizeof *knot);
    const double *k = s->knots[var];
    if (!knot) return KN_ENOMEM;
    for (int i = 0, j = 0; i <= count; i++) {
        while (k[j] < lines[i]) j++; // the last line is the last knot
        knot[i] = k[j] == lines[i];
    }
    *out = knot;
    return KN_OK;
}

bool kn_job_is_even(const kn_job *job, int along)
{
    const kn_job_options *o = &job->options;
    return o->spacing == KN_CELLS_EVEN || o->spacing == KN_CELLS_FREE || // free corners start there
           (o->spacing == KN_CELLS_DEFAULT && o->count[along] == 0);
}

static bool together(const kn_job *job, const kn_job_class *classes, int a, int b)
{
    return classes[a].id == classes[b].id && job->surfaces[a / 2].cells[a % 2] == job->surfaces[b / 2].cells[b % 2] &&
           kn_job_is_even(job, a % 2) && kn_job_is_even(job, b % 2);
}

// Direction `first` (2 surface + variable) and all later ones of its class that have as many cells. Where a class
// meets itself backwards every member takes part in both directions.
static kn_status place_class(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces, const kn_job_class *classes,
                             int first)
{
    int n = 0, at = 0, count = job->surfaces[first / 2].cells[first % 2];
    for (int m = first; m < 2 * job->nsurfaces; m++) n += together(job, classes, first, m);
    int copies = classes[first].mirrored ? 2 : 1;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_cells_along *along = kn_scratch(ctx, (size_t)(copies * n), sizeof *along);
    double **lines = kn_scratch(ctx, (size_t)(copies * n), sizeof *lines);
    kn_status status = along && lines ? KN_OK : KN_ENOMEM;
    for (int m = first; status == KN_OK && m < 2 * job->nsurfaces; m++)
        for (int k = 0; k < copies && together(job, classes, first, m); k++)
            along[at++] = (kn_cells_along){&surfaces[m / 2], m % 2, classes[m].reversed != (k == 1)};
    if (status == KN_OK) status = kn_cells_shared_lines(ctx, lines, along, copies * n, count);
    at = 0;
    for (int m = first; status == KN_OK && m < 2 * job->nsurfaces; m++) {
        if (!together(job, classes, first, m)) continue;
        job->surfaces[m / 2].lines[m % 2] = lines[at];
        if (copies == 2) kn_free(ctx, lines[at + 1]);
        at += copies;
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_job_make_lines(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces, const kn_job_class *classes)
{
    kn_status status = KN_OK;
    for (int m = 0; status == KN_OK && m < 2 * job->nsurfaces; m++) {
        kn_job_surface *s = &job->surfaces[m / 2];
        double **lines = &s->lines[m % 2];
        if (!kn_job_is_even(job, m % 2))
            status = kn_cells_uniform_lines(ctx, lines, &surfaces[m / 2], m % 2, s->cells[m % 2]);
        else if (!*lines)
            status = place_class(ctx, job, surfaces, classes, m);
        if (status == KN_OK)
            status = find_knots(ctx, &s->knot[m % 2], *lines, s->cells[m % 2], &surfaces[m / 2], m % 2);
    }
    return status;
}

kn_status kn_job_measure_spread(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_cells_grid *grids = kn_scratch(ctx, (size_t)job->nsurfaces, sizeof *grids);
    kn_status status = grids ? KN_OK : KN_ENOMEM;
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) {
        const kn_job_surface *from = &job->surfaces[s];
        grids[s].surface = &surfaces[s];
        for (int d = 0; d < 2; d++) grids[s].lines[d] = from->lines[d], grids[s].nlines[d] = from->cells[d] + 1;
    }
    if (status == KN_OK) status = kn_cells_measure_all(ctx, &job->report.spread, grids, job->nsurfaces);
    kn_scratch_release(ctx, mark);
    return status;
}
