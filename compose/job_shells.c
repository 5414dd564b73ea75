// SPDX-License-Identifier: Apache-2.0
// The shell of each surface of a job: degrees, the bounds of its Jacobian.
#include "compose/job.h"
#include "kernel/parallel.h"

#include <math.h>

static const int least_normal_degree = 3; // of n in each variable
static const int usual_normal_degree = 5;

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
    kn_shell_options o = kn_shell_defaults();
    for (int d = 0; d < 2; d++) {
        o.lines[d] = to->lines[d];
        o.nlines[d] = to->cells[d] + 1;
        if (4 * to->cells[d] > 4096 && 4 * to->cells[d] > o.max_spans) o.max_spans = 4 * to->cells[d];
    }
    o.normal_tol = all->job->options.normal_tol;
    o.max_degree = to->degree_sum / 2 < usual_normal_degree ? to->degree_sum / 2 : usual_normal_degree;
    kn_status status = kn_shell_create(ctx, &to->shell, s, &o);
    if (status != KN_OK) return status;

    kn_shell_closed(to->shell, to->closed);
    return kn_shell_jacobian_bounds(ctx, &to->jacobian[0], &to->jacobian[1], to->shell, all->w[0], all->w[1]);
}

kn_status kn_job_make_shells(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces)
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
