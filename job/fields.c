// SPDX-License-Identifier: Apache-2.0
// Fields over a base that do not depend on a variable need no degree there.
#include "job/internal.h"

#include <math.h>

// Lines of coefficients along variable v: the first of line i, and the step to the next.
typedef struct lines {
    size_t n, step, count;
} lines;

static lines along(const kn_spline *f, int v)
{
    size_t n = (size_t)f->count[v], step = v == 0 ? (size_t)f->count[1] : 1;
    return (lines){n, step, kn_spline_count(f) * (size_t)f->ncomp / n};
}

static void range(double *least, double *most, const kn_spline *f, lines l, size_t line)
{
    const double *c = &f->coef[line / l.step * l.n * l.step + line % l.step];
    *least = *most = *c;
    for (size_t k = 1; k < l.n; k++) *least = fmin(*least, c[k * l.step]), *most = fmax(*most, c[k * l.step]);
}

double kn_job_field_variation(const kn_spline *f, int v)
{
    lines l = along(f, v);
    double all = 0.0, least, most;
    for (size_t i = 0; i < l.count; i++) {
        range(&least, &most, f, l, i);
        all = fmax(all, most - least);
    }
    return all;
}

kn_status kn_job_lower_field(kn_ctx *ctx, kn_spline *f, int v)
{
    int degree[2] = {f->degree[0], f->degree[1]}, count[2] = {f->count[0], f->count[1]};
    double ends[2], least, most;
    const double *knots[2] = {f->knots[0], f->knots[1]};
    kn_spline_domain(f, v, &ends[0], &ends[1]);
    degree[v] = 0, count[v] = 1, knots[v] = ends;
    lines l = along(f, v);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline out = {0};
    double *coef = kn_scratch(ctx, l.count, sizeof *coef);
    for (size_t i = 0; coef && i < l.count; i++) {
        range(&least, &most, f, l, i);
        coef[i] = least + 0.5 * (most - least);
    }
    kn_status status = coef ? kn_spline_init(ctx, &out, 2, f->ncomp, false, degree, count, knots, coef) : KN_ENOMEM;
    if (status == KN_OK) kn_spline_swap(f, &out);
    kn_spline_clear(ctx, &out);
    kn_scratch_release(ctx, mark);
    return status;
}
