// SPDX-License-Identifier: Apache-2.0
// The judge of bounds, and coefficients to try.
#include "kernel/knots.h"
#include "tests/oracle/exact.h"

#include <math.h>
#include <stdlib.h>

#include <arf.h>

static const double UNIT = 0x1p-53;

static void collect(exact_judge_t *judge, double ratio)
{
    if (judge->count == judge->room) {
        judge->room = judge->room ? 2 * judge->room : 1024;
        judge->ratio = realloc(judge->ratio, judge->room * sizeof *judge->ratio);
        assert_non_null(judge->ratio);
    }
    judge->ratio[judge->count++] = ratio;
    judge->most = fmax(judge->most, ratio);
}

// |a| / |b| to within some 1e-15, whatever the sizes of the two.
static double quotient(const fmpz_t a, const fmpz_t b)
{
    slong ea, eb;
    double x = fmpz_get_d_2exp(&ea, a), y = fmpz_get_d_2exp(&eb, b);
    slong e = ea - eb;
    return ldexp(fabs(x / y), (int)(e > 3000 ? 3000 : e < -3000 ? -3000 : e));
}

// error / size = |x - value/den| / (size/size_den). x and value equal: 0.
static double error_over(double x, const fmpz_t value, const fmpz_t den, const fmpz_t size, const fmpz_t size_den)
{
    fmpq_t q;
    fmpz_t error, other;
    fmpq_init(q), fmpz_init(error), fmpz_init(other);
    fmpq_of_double(q, x);
    fmpz_mul(error, fmpq_numref(q), den);
    fmpz_mul(other, value, fmpq_denref(q));
    fmpz_sub(error, error, other);
    double result = 0.0;
    if (!fmpz_is_zero(error)) {
        fmpz_mul(error, error, size_den);
        fmpz_mul(other, size, den);
        fmpz_mul(other, other, fmpq_denref(q));
        result = fmpz_is_zero(other) ? INFINITY : quotient(error, other);
    }
    fmpq_clear(q), fmpz_clear(error), fmpz_clear(other);
    return result;
}

// The quotients are rounded: a bound must hold by a hair more than itself.
static void judge_ratio(exact_judge_t *judge, double relative, double bound, size_t i, double computed)
{
    judge->all++;
    if (relative == 0.0) return;
    judge->relative = fmax(judge->relative, relative / UNIT);
    if (!(relative <= bound * (1.0 - 1e-13)))
        fail_msg("%s: number %zu, %.17g: error %.3g times its bound", judge->name, i, computed, relative / bound);
    collect(judge, relative / bound);
}

static double gamma_n(int n)
{
    return n * UNIT / (1.0 - n * UNIT);
}

void exact_judge(exact_judge_t *judge, const double *computed, const exact *value, const exact *size,
                 const int *roundings, int all)
{
    size_t n = exact_count(value);
    if (!size) size = value;
    assert_int_equal(exact_count(size), n);
    for (size_t i = 0; i < n; i++) {
        assert_true(isfinite(computed[i]));
        double relative = error_over(computed[i], value->num + i, value->den, size->num + i, size->den);
        judge_ratio(judge, relative, gamma_n(roundings ? roundings[i] : all), i, computed[i]);
    }
}

void exact_judge_one(exact_judge_t *judge, double computed, const fmpq_t value, const fmpq_t size, int roundings)
{
    assert_true(isfinite(computed));
    judge_ratio(judge,
                error_over(computed, fmpq_numref(value), fmpq_denref(value), fmpq_numref(size), fmpq_denref(size)),
                gamma_n(roundings), judge->all, computed);
}

void exact_judge_bound(exact_judge_t *judge, double computed, const fmpq_t value, const fmpq_t bound)
{
    assert_true(isfinite(computed));
    judge_ratio(judge,
                error_over(computed, fmpq_numref(value), fmpq_denref(value), fmpq_numref(bound), fmpq_denref(bound)),
                1.0, judge->all, computed);
}

void exact_assert_nearest(const double *computed, const exact *value)
{
    arf_t x;
    arf_init(x);
    size_t n = exact_count(value);
    for (size_t i = 0; i < n; i++) {
        arf_fmpz_div_fmpz(x, value->num + i, value->den, 53, ARF_RND_NEAR);
        double nearest = arf_get_d(x, ARF_RND_NEAR);
        if (computed[i] != nearest) fail_msg("number %zu: %.17g, not the nearest %.17g", i, computed[i], nearest);
    }
    arf_clear(x);
}

void exact_judge_end(exact_judge_t *judge, double slack)
{
    double middle = 1.0;
    if (judge->count) {
        qsort(judge->ratio, judge->count, sizeof *judge->ratio, kn_knots_by_value);
        middle = 1.0 / judge->ratio[judge->count / 2];
    }
    print_message("# %-34s %8zu numbers, %5.1f%% exact; error/bound <= %5.3f, %7.1f u; bound/error median %6.1f\n",
                  judge->name, judge->all, 100.0 * (double)(judge->all - judge->count) / (double)judge->all,
                  judge->most, judge->relative, middle);
    free(judge->ratio);
    *judge = (exact_judge_t){.name = judge->name};
    bool whole = test_scale(100) >= 100; // the median of a part says less
    if (slack > 0.0 && middle > slack && whole)
        fail_msg("%s: the bound is slack %.0f times in the median", judge->name, middle);
}

// ---- coefficients ----
static double one(test_rng *rng, exact_kind kind, size_t i)
{
    double sign = test_int(rng, 0, 1) ? 1.0 : -1.0;
    switch (kind) {
    case EXACT_INTEGERS: return test_int(rng, -9, 9);
    case EXACT_SCALES: return sign * pow(10.0, test_uniform(rng, -80.0, 80.0));
    case EXACT_HUGE: return sign * 1e80 * test_uniform(rng, 0.5, 1.0);
    case EXACT_TINY: return sign * 1e-80 * test_uniform(rng, 0.5, 1.0);
    case EXACT_CANCEL: return (i % 2 ? -1e6 : 1e6) * (1.0 + 1e-12 * test_uniform(rng, -1.0, 1.0));
    case EXACT_UNIFORM:
    case EXACT_KINDS: break;
    }
    return test_uniform(rng, -1.0, 1.0);
}

void exact_fill(double *out, size_t n, test_rng *rng, exact_kind kind)
{
    for (size_t i = 0; i < n; i++) out[i] = one(rng, kind, i);
}

static void fill(double *coef, size_t count, int ncomp, bool rational, test_rng *rng, exact_kind kind)
{
    exact_fill(coef, count * (size_t)ncomp, rng, kind);
    for (size_t i = 0; rational && i < count; i++)
        coef[count * (size_t)(ncomp - 1) + i] = kind == EXACT_INTEGERS ? test_int(rng, 1, 4)
                                                                       : test_uniform(rng, 0.5, 2.0);
}

void exact_random_bezier(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int nvars, int ncomp, bool rational,
                         const int *degree, exact_kind kind)
{
    assert_int_equal(kn_bezier_init(ctx, out, nvars, ncomp, rational, degree), KN_OK);
    fill(out->coef, kn_bezier_count(out), ncomp, rational, rng, kind);
}

void exact_random_spline(kn_ctx *ctx, kn_spline *out, test_rng *rng, int nvars, int ncomp, bool rational,
                         const int *degree, const int *count, exact_kind kind)
{
    test_random_spline(ctx, out, rng, nvars, ncomp, rational, degree, count, 9);
    if (kind != EXACT_INTEGERS) fill(out->coef, kn_spline_count(out), ncomp, rational, rng, kind);
}
