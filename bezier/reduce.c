// SPDX-License-Identifier: Apache-2.0
// Degree reduction: exactly where that is possible, else the nearest in the sense of least squares of coefficients.
//
// The Euclidean distance of Bernstein coefficients, best on lower degrees, is best in L2 as well (Lutterkort, Peters
// & Reif, Polynomial degree reduction in the L2-norm equals best Euclidean approximation of Bezier coefficients, CAGD
// 16, 1999); here with the ends kept, so that neighbours still meet (Ahn, Lee, Park & Yoo, CAGD 21, 2004). Each line
// of coefficients is reduced by itself: what an edge becomes depends on the edge alone.
#include "bezier/reduction.h"

#include <math.h>
#include <string.h>

#include "bezier/norm_bound.h"
#include "kernel/bernstein.h"
#include "kernel/reduce.h"

// Lines that are of degree m, but for rounding of the order of their elevation's, are taken back as they were.
static void restore_lines(double *c, bool *exact, const double *a, size_t outer, int n, int m, size_t inner)
{
    double b[KN_MAX_DEGREE + 1], p[KN_MAX_DEGREE + 1];
    for (size_t o = 0; o < outer; o++)
        for (size_t q = 0; q < inner; q++) {
            double most = 0.0;
            for (int i = 0; i <= n; i++) {
                b[i] = a[(o * (size_t)(n + 1) + (size_t)i) * inner + q];
                most = fmax(most, fabs(b[i]));
            }
            kn_bernstein_lower(p, m, b, n);
            if (!(kn_bernstein_misfit(b, n, p, m) <= kn_gamma_up(4.0 * (n + 4)) * most)) {
                *exact = false;
                continue;
            }
            if (*exact && !kn_bernstein_is_elevated(b, n, p, m)) *exact = false;
            for (int k = 0; k <= m; k++) c[(o * (size_t)(m + 1) + (size_t)k) * inner + q] = p[k];
        }
}

kn_status kn_bezier_reduce_axis(kn_ctx *ctx, kn_bezier *c, bool *exact, const kn_bezier *a, int var, int m)
{
    int n = a->degree[var];
    kn_axis x = kn_bezier_axis(a, var);
    kn_bezier low = *a;
    low.degree[var] = m;
    kn_status status = kn_bezier_scratch(ctx, &low, "reduce");
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    size_t cells = (size_t)(n + 1) * (size_t)(m + 1);
    kn_band e = {.rows = n + 1};
    kn_projection p;
    e.first = kn_scratch(ctx, 2 * (size_t)(n + 1), sizeof *e.first);
    e.w = kn_scratch(ctx, cells, sizeof *e.w);
    double *room = kn_scratch(ctx, kn_projection_room(n + 1, m + 1, m + 1) + x.inner, sizeof *room);
    if (e.first && e.w && room) {
        e.terms = e.first + n + 1;
        kn_bernstein_elevation(&e, m, n);
        kn_projection_factor(&p, &e, m + 1, 1, room + x.inner);
        for (size_t o = 0; o < x.outer; o++) {
            double *to = low.coef + o * (size_t)(m + 1) * x.inner;
            const double *from = a->coef + o * (size_t)(n + 1) * x.inner;
            memcpy(to, from, x.inner * sizeof *to);
            memcpy(to + (size_t)m * x.inner, from + (size_t)n * x.inner, x.inner * sizeof *to);
            kn_projection_solve(&p, to, from, x.inner, room);
        }
        restore_lines(low.coef, exact, a->coef, x.outer, n, m, x.inner);
        *c = low;
    } else {
        status = KN_ENOMEM;
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// *d = a - low, with low elevated: gamma(sum (T_d + 2)) of low's largest coefficient, and 1 for the
// difference itself.
static kn_status difference(kn_ctx *ctx, kn_bezier *d, kn_parts *rounding, const kn_bezier *a, const kn_bezier *low)
{
    kn_bezier now = *low;
    double steps = 1.0;
    for (int v = 0; v < a->nvars; v++) {
        int m = now.degree[v], to = a->degree[v], rise = to - m;
        if (rise == 0) continue;
        kn_bezier next = now;
        kn_axis x = kn_bezier_axis(&now, v);
        next.degree[v] = to;
        kn_status status = kn_bezier_scratch(ctx, &next, "reduce");
        if (status != KN_OK) return status;
        kn_bernstein_elevate(next.coef, now.coef, x.outer, m, to, x.inner);
        now = next;
        steps += (rise < m ? rise : m) + 3;
    }
    *d = *a;
    kn_status status = kn_bezier_scratch(ctx, d, "reduce");
    if (status != KN_OK) return status;
    size_t n = kn_bezier_count(a), all = n * (size_t)a->ncomp;
    for (size_t i = 0; i < all; i++) d->coef[i] = a->coef[i] - now.coef[i];
    *rounding = (kn_parts){0.0, 0.0};
    kn_parts_add(rounding, kn_gamma_up(1.0), d->coef, n, a->ncomp, a->rational);
    kn_parts_add(rounding, kn_gamma_up(steps), low->coef, kn_bezier_count(low), a->ncomp, a->rational);
    return KN_OK;
}

kn_status kn_bezier_reduction_error(kn_ctx *ctx, double *error, const kn_bezier *a, const kn_bezier *low)
{
    kn_bezier d;
    kn_deviation v;
    kn_parts rounding;
    double bound = 0.0, least = 0.0;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = difference(ctx, &d, &rounding, a, low);
    if (status == KN_OK) {
        size_t n = kn_bezier_count(&d);
        if (kn_deviation_of(&v, d.coef, n, a->ncomp, a->rational, a->coef, n, low->coef, kn_bezier_count(low))) {
            status = kn_bezier_norm_bound(ctx, &bound, &least, &d, v.radius);
            *error = kn_deviation_bound(&v, bound, &rounding, a->ncomp);
        } else {
            *error = INFINITY;
        }
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_reduce(kn_ctx *ctx, kn_bezier *out, double *error, const kn_bezier *a, const int *degree)
{
    kn_status status = kn_bezier_check_operand(ctx, "reduce", a);
    if (status != KN_OK) return status;
    for (int d = 0; d < a->nvars; d++)
        if (degree[d] < 0 || degree[d] > a->degree[d])
            return kn_fail(ctx, KN_EDOMAIN, "reduce: degree %d to %d in variable %d", a->degree[d], degree[d], d);
    kn_bezier c = *a;
    bool exact = true;
    double bound = 0.0;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = 0; d < a->nvars && status == KN_OK; d++)
        if (degree[d] < a->degree[d]) status = kn_bezier_reduce_axis(ctx, &c, &exact, &c, d, degree[d]);
    if (status == KN_OK && error && !exact) status = kn_bezier_reduction_error(ctx, &bound, a, &c);
    if (status == KN_OK) status = kn_bezier_store(ctx, out, &c);
    if (status == KN_OK && error) *error = bound;
    kn_scratch_release(ctx, mark);
    return status;
}
