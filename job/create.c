// SPDX-License-Identifier: Apache-2.0
// Planning a job: what is asked for is checked and copied, then decided step by step.
#include "job/border.h"
#include "job/looks.h"

#include <math.h>

static kn_status check_options(kn_ctx *ctx, const kn_job_options *o)
{
    const double numbers[] = {o->size[0], o->size[1], o->normal_tol, o->mesh_tol, o->crossing_tol};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (!(numbers[i] >= 0.0) || isinf(numbers[i]))
            return kn_fail(ctx, KN_EDOMAIN, "job: sizes and tolerances must be finite and not negative: %g",
                           numbers[i]);
    if (!isfinite(o->height) || !isfinite(o->offset))
        return kn_fail(ctx, KN_EDOMAIN, "job: height %g, offset %g", o->height, o->offset);
    if (o->side != KN_JOB_ABOVE && o->side != KN_JOB_BELOW && o->side != KN_JOB_BOTH)
        return kn_fail(ctx, KN_EDOMAIN, "job: side %d", (int)o->side);
    if (o->count[0] < 0 || o->count[1] < 0)
        return kn_fail(ctx, KN_EDOMAIN, "job: count %d, %d", o->count[0], o->count[1]);
    if (o->max_degree < 0) return kn_fail(ctx, KN_EDOMAIN, "job: degree limit %d", o->max_degree);
    if (o->max_degree > KN_MAX_DEGREE)
        return kn_fail(ctx, KN_ELIMIT, "job: degree limit %d, at most %d", o->max_degree, KN_MAX_DEGREE);
    return KN_OK;
}

static kn_status plan(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces, int nsurfaces, const kn_tile *tile)
{
    kn_job_bases bases = {0};
    kn_status status = kn_tile_copy(ctx, &job->tile, tile);
    if (status == KN_OK) status = kn_tile_rotate(ctx, &job->tile, job->options.quarter_turns);
    if (status == KN_OK) status = kn_job_looks_init(ctx, job);
    if (status == KN_OK) status = kn_job_split(ctx, &bases, job, surfaces, nsurfaces);
    if (status == KN_OK) status = kn_job_decide_sizes(ctx, job, &bases);
    if (status == KN_OK) status = kn_job_make_shells(ctx, job, &bases);
    if (status == KN_OK) status = kn_job_borders_init(ctx, job);
    if (status == KN_OK) status = kn_job_instances_init(ctx, job);
    if (status == KN_OK) status = kn_job_vary_init(ctx, job);
    if (status == KN_OK) status = kn_job_select_init(ctx, job); // by what tiles occupy
    if (status == KN_OK) status = kn_job_find_least(ctx, job);
    if (status == KN_OK) status = kn_job_find_meeting_degrees(ctx, job);
    if (status == KN_OK) status = kn_job_plan(ctx, job);
    kn_job_bases_clear(ctx, &bases);
    job->options.thickness = job->options.direction = job->options.attraction = NULL; // the caller's
    job->options.trims = NULL, job->options.bodies = NULL;
    return status;
}

kn_status kn_job_create(kn_ctx *ctx, kn_job **out, const kn_spline *surfaces, int nsurfaces, const kn_tile *tile,
                        const kn_job_options *options)
{
    kn_job_options o = options ? *options : kn_job_defaults();
    kn_status status = check_options(ctx, &o);
    if (status == KN_OK) status = kn_job_check_bases(ctx, surfaces, nsurfaces, &o);
    if (status == KN_OK) status = kn_tile_check(ctx, tile);
    if (status != KN_OK) return status;
    if (o.max_degree == 0) o.max_degree = 25;
    if (o.normal_tol == 0.0) o.normal_tol = 1e-6;

    kn_job *job = kn_alloc_zero(ctx, 1, sizeof *job);
    if (!job) return KN_ENOMEM;
    job->options = o;
    job->has_fields = o.thickness || o.direction || o.attraction || o.stretch;
    job->report.normal_tol = o.normal_tol;
    job->report.max_degree = o.max_degree;
    status = plan(ctx, job, surfaces, nsurfaces, tile);
    if (status == KN_OK)
        *out = job;
    else
        kn_job_destroy(ctx, job);
    return status;
}
