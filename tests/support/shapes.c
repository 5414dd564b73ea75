// SPDX-License-Identifier: Apache-2.0
// Small random Bezier pieces and splines with integer coefficients, for which much of the algebra is exact.
#include "tests/support/support.h"

#include <stdlib.h>

static void fill(double *coef, test_rng *rng, int ncomp, size_t count, bool rational, int bound)
{
    for (int c = 0; c < ncomp; c++) {
        bool weight = rational && c == ncomp - 1;
        for (size_t i = 0; i < count; i++) *coef++ = test_int(rng, weight ? 1 : -bound, bound);
    }
}

void test_random_bezier(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int nvars, int ncomp, bool rational,
                        const int *degree, int bound)
{
    assert_int_equal(kn_bezier_init(ctx, out, nvars, ncomp, rational, degree), KN_OK);
    fill(out->coef, rng, ncomp, kn_bezier_count(out), rational, bound);
}

// degree + 1 zeros, interior knots that rise by 0 or 1 but never repeat more than degree times, degree + 1 ends.
static void random_knots(double *knots, test_rng *rng, int degree, int count)
{
    int multiplicity = degree, interior = count - degree - 1;
    double at = 0.0;
    for (int i = 0; i <= degree; i++) *knots++ = 0.0;
    for (int i = 0; i < interior; i++) {
        bool rise = multiplicity >= degree || test_int(rng, 0, 2) > 0;
        multiplicity = rise ? 1 : multiplicity + 1;
        at += rise ? 1.0 : 0.0;
        *knots++ = at;
    }
    for (int i = 0; i <= degree; i++) *knots++ = at + 1.0;
}

void test_random_spline(kn_ctx *ctx, kn_spline *out, test_rng *rng, int nvars, int ncomp, bool rational,
                        const int *degree, const int *count, int bound)
{
    double *knots[KN_MAX_VARS] = {NULL};
    for (int d = 0; d < nvars; d++) {
        assert_true(count[d] > degree[d]);
        knots[d] = malloc((size_t)(count[d] + degree[d] + 1) * sizeof *knots[d]);
        assert_non_null(knots[d]);
        random_knots(knots[d], rng, degree[d], count[d]);
    }
    kn_status status = kn_spline_init(ctx, out, nvars, ncomp, rational, degree, count, (const double *const *)knots,
                                      NULL);
    for (int d = 0; d < nvars; d++) free(knots[d]);
    assert_int_equal(status, KN_OK);
    fill(out->coef, rng, ncomp, kn_spline_count(out), rational, bound);
}
