// SPDX-License-Identifier: Apache-2.0
// Quasi-interpolation, and fits to a tolerance.
#include <math.h>
#include <string.h>

#include "tests/fit/check.h"

enum { ROOM = 80 };

// ---- functions ----

// Component c: prod_d of a polynomial of degree p_d in x_d.
typedef struct polynomial {
    int nvars, dim;
    int degree[3];
    double a[2][3][12];
    int calls;
} polynomial;

static kn_status polynomial_at(void *user, double *value, const double *at)
{
    polynomial *f = user;
    f->calls++;
    for (int c = 0; c < f->dim; c++) {
        value[c] = 1.0;
        for (int d = 0; d < f->nvars; d++) {
            double sum = 0.0;
            for (int k = f->degree[d]; k >= 0; k--) sum = sum * at[d] + f->a[c][d][k];
            value[c] *= sum;
        }
    }
    return KN_OK;
}

// One at one parameter, zero elsewhere.
static kn_status delta_at(void *user, double *value, const double *at)
{
    value[0] = at[0] == *(const double *)user ? 1.0 : 0.0;
    return KN_OK;
}

// The largest sum of absolute weights of the functionals along one axis.
static double weight_sum(kn_ctx *ctx, const double *knots, int degree, int count)
{
    double sites[ROOM], sums[ROOM] = {0}, largest = 0.0;
    kn_spline q = {0};
    assert_int_equal(kn_fit_greville(ctx, sites, knots, degree, count), KN_OK);
    for (int i = 0; i < count; i++) {
        assert_int_equal(kn_fit_quasi(ctx, &q, 1, 1, &degree, &count, &knots, delta_at, &sites[i]), KN_OK);
        for (int j = 0; j < count; j++) {
            sums[j] += fabs(q.coef[j]);
            if (j < i - degree || j > i + degree) assert_true(q.coef[j] == 0.0); // local
        }
    }
    for (int j = 0; j < count; j++) largest = fmax(largest, sums[j]);
    kn_spline_clear(ctx, &q);
    return largest;
}

// ---- reproduction ----

// The functional w of a coefficient solves (V + dV)^T w = b + db, |dV| <= gamma(8 p + 4) V, |db| <= gamma(5 p) |b|, the
// rows of V and |b| sum to 1: applied to a polynomial with Bernstein coefficients at most M it errs by
// gamma(13 p + 4) (|w| + 1) M at most, its own sum by gamma(p + 2) |w| M, the values of f by gamma(2 p + 2) M |w|. M is
// the sum of |a_k| X^k where |x| <= X: blossoms of x^k are means of products of k numbers of the interval.
static void reproduces_polynomials(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(30); round > 0; round--) {
        polynomial f = {.nvars = 1 + round % 3, .dim = 1 + round % 2};
        int count[3];
        double knots[3][ROOM], tolerance = 1.0, operations = 0.0;
        const double *k[3] = {knots[0], knots[1], knots[2]};
        for (int d = 0; d < f.nvars; d++) {
            int p = f.degree[d] = test_int(&rng, 0, f.nvars > 2 ? 3 : 8);
            count[d] = p + 1 + test_int(&rng, 0, f.nvars > 2 ? 4 : 10);
            kn_spline s;
            test_random_spline(ctx, &s, &rng, 1, 1, false, &p, &count[d], 9);
            double end = s.knots[0][count[d]], size = 0.0;
            for (int i = 0; i <= count[d] + p; i++) knots[d][i] = s.knots[0][i] / end * 2 - 1; // [-1,1]
            kn_spline_clear(ctx, &s);
            for (int c = 0; c < f.dim; c++) {
                double sum = 0.0;
                for (int i = 0; i <= p; i++) sum += fabs(f.a[c][d][i] = test_int(&rng, -9, 9));
                size = fmax(size, sum);
            }
            tolerance *= (weight_sum(ctx, knots[d], p, count[d]) + 1.0) * size;
            operations += 16 * p + 8;
        }
        kn_spline q = {0};
        assert_int_equal(kn_fit_quasi(ctx, &q, f.nvars, f.dim, f.degree, count, k, polynomial_at, &f), KN_OK);
        assert_int_equal(f.calls, (int)check_product(count, f.nvars));
        assert_int_equal(kn_spline_check(ctx, &q), KN_OK);
        tolerance *= check_gamma(operations + check_eval_operations(&q) + 20);
        for (int i = 0; i < 50; i++) {
            double at[3], value[2], expected[2];
            for (int d = 0; d < 3; d++) at[d] = test_uniform(&rng, -1, 1);
            assert_int_equal(kn_spline_eval(ctx, value, &q, at), KN_OK);
            (void)polynomial_at(&f, expected, at);
            for (int c = 0; c < f.dim; c++) assert_true(fabs(value[c] - expected[c]) <= tolerance);
        }
        kn_spline_clear(ctx, &q);
    }
    test_ctx_end(ctx, &memory);
}

// Known functionals on equal spans, away from the ends: -1/8 10/8 -1/8 for quadratics, -1/6 8/6 -1/6 for cubics; near
// them as the knots say. Weights are quotients of small integers: a few roundings.
static void known_weights(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double knots[ROOM], sites[ROOM];
    const double *k = knots;
    kn_spline q = {0};
    for (int p = 1; p <= 3; p++) {
        int count = 12 + p;
        assert_int_equal(kn_fit_uniform_knots(ctx, knots, p, count, 0, 12), KN_OK);
        assert_int_equal(kn_fit_greville(ctx, sites, knots, p, count), KN_OK);
        const double side[] = {0, 0, -1.0 / 8, -1.0 / 6}, middle[] = {0, 1, 10.0 / 8, 8.0 / 6};
        assert_int_equal(kn_fit_quasi(ctx, &q, 1, 1, &p, &count, &k, delta_at, &sites[7]), KN_OK);
        for (int j = 0; j < count; j++) {
            double expected = j == 7 ? middle[p] : j == 6 || j == 8 ? side[p] : 0.0;
            assert_true(fabs(q.coef[j] - expected) <= check_gamma(100));
        }
    }
    kn_spline_clear(ctx, &q);
    test_ctx_end(ctx, &memory);
}

// ---- order ----

static kn_status smooth_at(void *user, double *value, const double *at)
{
    (void)user;
    value[0] = exp(at[0]);
    return KN_OK;
}

// On a span f depends on sites in a stretch H of at most 2 p + 2 spans. With the best polynomial of degree p there,
// |f - Q f| <= (1 + |Q|) 2 (H/4)^(p+1) / (p+1)! max |f^(p+1)|; f = exp on [0,1]. And from n to 2 n spans the error falls
// by nearly 2^(p+1).
static void has_full_order(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int p = 1; p <= 6; p++) {
        double error[2] = {0};
        for (int fine = 0; fine < 2; fine++) {
            int n = fine ? 24 : 12, count = n + p;
            double knots[ROOM], bound = 2.0 * exp(1.0), value, expected;
            const double *k = knots;
            kn_spline q = {0};
            assert_int_equal(kn_fit_uniform_knots(ctx, knots, p, count, 0, 1), KN_OK);
            assert_int_equal(kn_fit_quasi(ctx, &q, 1, 1, &p, &count, &k, smooth_at, NULL), KN_OK);
            for (int i = 1; i <= p + 1; i++) bound *= (2.0 * p + 2.0) / n / 4.0 / i;
            for (int i = 0; i <= 1000; i++) {
                double at = i / 1000.0;
                assert_int_equal(kn_spline_eval(ctx, &value, &q, &at), KN_OK);
                (void)smooth_at(NULL, &expected, &at);
                error[fine] = fmax(error[fine], fabs(value - expected));
            }
            assert_true(error[fine] <= bound * (1.0 + weight_sum(ctx, knots, p, count)) + 1e-14);
            kn_spline_clear(ctx, &q);
        }
        assert_true(error[1] > 1e-13 && error[1] <= error[0] / pow(2.0, p + 0.6));
    }
    test_ctx_end(ctx, &memory);
}

// Corners are values bit for bit, edges of surfaces the curves' own quasi-interpolants.
static kn_status wave_at(void *user, double *value, const double *at)
{
    const int *swap = user;
    double u = at[0], v = swap && *swap >= 0 ? (double)*swap : at[1];
    value[0] = sin(3 * u + v) + u * v * v;
    value[1] = cos(u - 2 * v);
    return KN_OK;
}

static void edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double ku[] = {0, 0, 0, 0, 0.25, 0.25, 0.5, 1, 1, 1, 1}, kv[] = {0, 0, 0, 0.125, 0.75, 1, 1, 1};
    const double *knots[] = {ku, kv};
    const int degree[] = {3, 2}, count[] = {7, 5};
    kn_spline s = {0}, edge = {0};
    int none = -1;
    assert_int_equal(kn_fit_quasi(ctx, &s, 2, 2, degree, count, knots, wave_at, &none), KN_OK);
    for (int end = 0; end < 2; end++) {
        assert_int_equal(kn_fit_quasi(ctx, &edge, 1, 2, degree, count, knots, wave_at, &end), KN_OK);
        for (int i = 0; i < 14; i++) assert_true(edge.coef[i] == s.coef[i * 5 + (end ? 4 : 0)]);
        for (int k = 0; k < 2; k++) {
            double value[2];
            (void)wave_at(&none, value, (const double[]){k, end});
            for (int c = 0; c < 2; c++) assert_true(s.coef[c * 35 + k * 30 + end * 4] == value[c]);
        }
    }
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &edge);
    test_ctx_end(ctx, &memory);
}

// ---- to a tolerance ----

static kn_status bump_at(void *user, double *value, const double *at)
{
    (*(int *)user)++;
    value[0] = 1.0 / (1.0 + 25.0 * at[0] * at[0]) + 0.5 * at[1];
    value[1] = at[1] * at[1] * at[1];
    return KN_OK;
}

// The estimate is the largest distance at 0.3 and 0.75 of each span; it keeps the tolerance, and only the variable that
// asks for it has many knots. A polynomial of the degree needs a single span.
static void to_tolerance(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double lo[] = {-1, 0}, hi[] = {1, 3};
    int calls = 0;
    for (double tolerance = 1e-2; tolerance > 1e-9; tolerance *= 1e-2) {
        kn_spline s = {0};
        double estimate = -1.0, largest = 0.0;
        assert_int_equal(
            kn_fit_to_tolerance(ctx, &s, &estimate, 2, 2, (int[]){3, 3}, lo, hi, bump_at, &calls, tolerance, 0),
            KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        assert_int_equal(kn_spline_spans(&s, 1), 1);
        for (int i = 3; i < s.count[0]; i++)
            for (int j = 0; j < 4; j++) {
                double a = s.knots[0][i], at[2], value[2], expected[2], square = 0.0;
                at[0] = (j % 2 ? 0.75 : 0.3) * (s.knots[0][i + 1] - a) + a, at[1] = j / 2 ? 2.25 : 0.9;
                assert_int_equal(kn_spline_eval(ctx, value, &s, at), KN_OK);
                (void)bump_at(&calls, expected, at);
                for (int c = 0; c < 2; c++) square += (value[c] - expected[c]) * (value[c] - expected[c]);
                largest = fmax(largest, sqrt(square));
            }
        assert_true(estimate <= tolerance);
        assert_true(fabs(largest - estimate) <= 1e-12); // the same places up to rounding, values up to 27
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// ---- failures ----

static kn_status fails_at(void *user, double *value, const double *at)
{
    value[0] = at[0];
    return (*(int *)user)-- > 0 ? KN_OK : KN_ECANCELLED;
}

static kn_status step_at(void *user, double *value, const double *at)
{
    (void)user;
    value[0] = at[0] < 0.3712 ? 0.0 : 1.0;
    return KN_OK;
}

static kn_status nan_at(void *user, double *value, const double *at)
{
    (void)user;
    value[0] = at[0] > 0.5 ? NAN : 0.0;
    return KN_OK;
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double jump[] = {0, 0, 1, 1, 2, 2}, smooth[] = {0, 0, 1, 1.5, 2, 2}, lo = 0, hi = 1, none = 0;
    const double *const bad[] = {jump}, *const good[] = {smooth};
    kn_spline s = {0};
    double estimate = -1.0;
    int allowed = 3;
    assert_int_equal(kn_fit_quasi(ctx, &s, 1, 1, (int[]){1}, (int[]){4}, bad, smooth_at, NULL), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "jump"));
    assert_int_equal(kn_fit_quasi(ctx, &s, 1, 1, (int[]){1}, (int[]){4}, good, fails_at, &allowed), KN_ECANCELLED);
    assert_int_equal(kn_fit_quasi(ctx, &s, 1, 0, (int[]){1}, (int[]){4}, good, smooth_at, NULL), KN_EDOMAIN);
    const struct {
        int nvars, dim, degree;
        const double *hi;
        double tolerance;
        int max_count;
        kn_status expected;
    } cases[] = {{0, 1, 2, &hi, 1, 0, KN_EDOMAIN},       {1, 0, 2, &hi, 1, 0, KN_EDOMAIN},
                 {1, 1, 0, &hi, 1, 0, KN_EDOMAIN},       {1, 1, 2, &none, 1, 0, KN_EDOMAIN},
                 {1, 1, 2, &hi, 0, 0, KN_EDOMAIN},       {1, 1, 2, &hi, NAN, 0, KN_EDOMAIN},
                 {1, 1, 2, &hi, 1, -1, KN_EDOMAIN},      {1, 1, KN_MAX_DEGREE + 1, &hi, 1, 0, KN_ELIMIT},
                 {1, 1, 2, &hi, 1e-12, 8, KN_EUNDECIDED}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(kn_fit_to_tolerance(ctx, &s, &estimate, cases[i].nvars, cases[i].dim, &cases[i].degree, &lo,
                                             cases[i].hi, smooth_at, NULL, cases[i].tolerance, cases[i].max_count),
                         cases[i].expected);
    assert_int_equal(kn_fit_to_tolerance(ctx, &s, &estimate, 1, 1, (int[]){2}, &lo, &hi, step_at, NULL, 0.1, 0),
                     KN_EUNDECIDED);
    assert_int_equal(kn_fit_to_tolerance(ctx, &s, &estimate, 1, 1, (int[]){2}, &lo, &hi, nan_at, NULL, 0.1, 64),
                     KN_EUNDECIDED);
    for (allowed = 0; allowed < 12; allowed++) {
        int left = allowed;
        kn_status status = kn_fit_to_tolerance(ctx, &s, &estimate, 1, 1, (int[]){2}, &lo, &hi, fails_at, &left, 1e-9,
                                               0);
        assert_int_equal(status, left < 0 ? KN_ECANCELLED : KN_OK);
        if (status != KN_OK) assert_true(s.nvars == 0 && estimate == -1.0);
        kn_spline_clear(ctx, &s);
        estimate = -1.0;
    }
    test_ctx_end(ctx, &memory);
}

static kn_status quasi_once(kn_ctx *ctx, void *user)
{
    const double ku[] = {0, 0, 0, 0, 0.5, 1, 1, 1, 1}, kv[] = {0, 0, 0, 1, 1, 1};
    kn_spline s = {0};
    kn_status status = kn_fit_quasi(ctx, &s, 2, 2, (int[]){3, 2}, (int[]){5, 3}, (const double *[]){ku, kv}, wave_at,
                                    user);
    if (status != KN_OK) assert_true(s.nvars == 0 && !s.coef);
    kn_spline_clear(ctx, &s);
    return status;
}

static kn_status tolerance_once(kn_ctx *ctx, void *user)
{
    kn_spline s = {0};
    double estimate = -1.0;
    kn_status status = kn_fit_to_tolerance(ctx, &s, &estimate, 2, 2, (int[]){2, 3}, (double[]){0, 0},
                                           (double[]){1, 1}, wave_at, user, 1e-3, 0);
    if (status != KN_OK) assert_true(s.nvars == 0 && !s.coef && estimate == -1.0);
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    int none = -1;
    test_allocation_failures(quasi_once, &none);
    test_allocation_failures(tolerance_once, &none);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(reproduces_polynomials), cmocka_unit_test(known_weights),
                                       cmocka_unit_test(has_full_order),         cmocka_unit_test(edges),
                                       cmocka_unit_test(to_tolerance),           cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("fit/quasi", tests, NULL, NULL);
}
