// SPDX-License-Identifier: Apache-2.0
// Two adjacent splines as one.
#include <math.h>
#include <string.h>

#include "spline/in_scratch.h"
#include "spline/removal.h"
#include "kernel/context.h"

static kn_status check(kn_ctx *ctx, const kn_spline *a, const kn_spline *b, int var)
{
    kn_status status = kn_spline_expect(ctx, "spline_merge", a, var);
    if (status == KN_OK) status = kn_spline_expect(ctx, "spline_merge", b, 0);
    if (status != KN_OK) return status;
    if (a->nvars != b->nvars || kn_spline_dim(a) != kn_spline_dim(b))
        return kn_fail(ctx, KN_EDOMAIN, "spline_merge: %d and %d variables, dimensions %d and %d", a->nvars, b->nvars,
                       kn_spline_dim(a), kn_spline_dim(b));
    if (kn_spline_dim(a) >= KN_MAX_COMPS && a->rational != b->rational)
        return kn_fail(ctx, KN_ELIMIT, "spline_merge: %d components and a weight", kn_spline_dim(a));
    for (int d = 0; d < a->nvars; d++) {
        double lo[2], hi[2];
        kn_spline_domain(a, d, &lo[0], &hi[0]);
        kn_spline_domain(b, d, &lo[1], &hi[1]);
        if (d == var ? hi[0] != lo[1] || !isfinite(hi[1] - lo[0]) : lo[0] != lo[1] || hi[0] != hi[1])
            return kn_fail(ctx, KN_EDOMAIN, "spline_merge: variable %d%s: [%g, %g] and [%g, %g]", d,
                           d == var ? ", of the merge" : "", lo[0], hi[0], lo[1], hi[1]);
    }
    return KN_OK;
}

// A polynomial s gets the weight 1.
static kn_status weighted(kn_ctx *ctx, kn_spline *s)
{
    size_t n = kn_spline_count(s), old = n * (size_t)s->ncomp;
    double *coef = kn_scratch(ctx, old + n, sizeof *coef);
    if (!coef) return KN_ENOMEM;
    memcpy(coef, s->coef, old * sizeof *coef);
    for (size_t i = 0; i < n; i++) coef[old + i] = 1.0;
    s->coef = coef, s->ncomp++, s->rational = true;
    return KN_OK;
}

// Degrees of all variables, and knots of all but var, become equal.
static kn_status match(kn_ctx *ctx, kn_spline *a, kn_spline *b, int var)
{
    kn_status status = KN_OK;
    if (a->rational != b->rational) status = weighted(ctx, a->rational ? b : a);
    for (int d = a->nvars - 1; d >= 0 && status == KN_OK; d--) {
        int degree = a->degree[d] > b->degree[d] ? a->degree[d] : b->degree[d];
        status = kn_spline_elevate_in_scratch(ctx, a, d, degree);
        if (status == KN_OK) status = kn_spline_elevate_in_scratch(ctx, b, d, degree);
        if (status != KN_OK || d == var) continue;
        status = kn_spline_unite_in_scratch(ctx, a, d, b->knots[d], b->count[d] + degree + 1);
        if (status == KN_OK) status = kn_spline_unite_in_scratch(ctx, b, d, a->knots[d], a->count[d] + degree + 1);
    }
    return status;
}

// The rows of a, then those of b, with degree + 1 knots where they meet.
static kn_status put_together(kn_ctx *ctx, kn_rows *both, const kn_spline *a, const kn_spline *b, int var)
{
    kn_rows x, y;
    kn_status status = kn_rows_of(ctx, &x, a, var);
    if (status == KN_OK) status = kn_rows_of(ctx, &y, b, var);
    if (status != KN_OK) return status;
    if (x.count > (int)KN_MAX_COEFS - y.count)
        return kn_fail(ctx, KN_ELIMIT, "spline_merge: %d and %d control points", x.count, y.count);
    size_t p = (size_t)x.degree, width = x.lines * (size_t)x.ncomp, nx = (size_t)x.count, ny = (size_t)y.count;
    *both = x;
    both->count = x.count + y.count;
    both->knots = kn_scratch(ctx, nx + ny + p + 1, sizeof *both->knots);
    both->row = kn_scratch(ctx, (nx + ny) * width, sizeof *both->row);
    if (!both->knots || !both->row) return KN_ENOMEM;
    memcpy(both->knots, x.knots, (nx + p + 1) * sizeof *x.knots);
    memcpy(both->knots + nx + p + 1, y.knots + p + 1, ny * sizeof *y.knots);
    memcpy(both->row, x.row, nx * width * sizeof *x.row);
    memcpy(both->row + nx * width, y.row, ny * width * sizeof *y.row);
    return KN_OK;
}

kn_status kn_spline_merge(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *a, const kn_spline *b, int var,
                          double tolerance)
{
    kn_status status = check(ctx, a, b, var);
    if (status == KN_OK) status = kn_spline_expect_tolerance(ctx, "spline_merge", tolerance);
    if (status != KN_OK) return status;
    kn_spline s = *a, t = *b;
    kn_rows rows;
    double bound = 0.0;
    kn_mark mark = kn_scratch_mark(ctx);
    status = match(ctx, &s, &t, var);
    if (status == KN_OK) status = put_together(ctx, &rows, &s, &t, var);
    if (status == KN_OK)
        status = kn_rows_remove(ctx, "spline_merge", &rows, &bound, tolerance, a->knots[var][a->count[var]]);
    if (status == KN_OK) { // the shape's limits, before anything of this size is made
        s.count[var] = rows.count;
        status = kn_spline_shape(ctx, "spline_merge", s.nvars, s.ncomp, s.rational, s.degree, s.count);
    }
    if (status == KN_OK) status = kn_rows_to(ctx, &s, var, &rows);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s); // last: out may be a or b
    if (status == KN_OK && error) *error = bound;
    kn_scratch_release(ctx, mark);
    return status;
}
