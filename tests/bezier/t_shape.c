// SPDX-License-Identifier: Apache-2.0
// Life, degree elevation, subdivision, restriction, division by an edge, derivatives as pieces.
#include "bezier/shape.h"
#include "tests/bezier/reference.h"

#include <float.h>
#include <math.h>

// f(at) == g(to) in every homogeneous component, exactly.
static void assert_same_at(const kn_bezier *f, const double *at, const kn_bezier *g, const double *to)
{
    long double vf[KN_MAX_COMPS], vg[KN_MAX_COMPS];
    assert_int_equal(f->ncomp, g->ncomp);
    assert_int_equal(f->rational, g->rational);
    ref_homogeneous(vf, f, at);
    ref_homogeneous(vg, g, to);
    for (int c = 0; c < f->ncomp; c++) assert_true(vf[c] == vg[c]);
}

static void life(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[3] = {2, 0, 4};
    kn_bezier a, b = {0}, c = {0};
    assert_int_equal(kn_bezier_init(ctx, &a, 3, 3, true, degree), KN_OK);
    assert_int_equal(kn_bezier_count(&a), 15);
    assert_int_equal(kn_bezier_dim(&a), 2);
    for (int i = 0; i < 45; i++) assert_true(a.coef[i] == 0.0);
    a.coef[44] = 8.0;
    assert_int_equal(kn_bezier_copy(ctx, &b, &a), KN_OK);
    ref_assert_same(&a, &b);
    assert_ptr_not_equal(a.coef, b.coef);
    assert_int_equal(kn_bezier_copy(ctx, &b, &b), KN_OK); // onto itself
    ref_assert_same(&a, &b);
    kn_bezier_swap(&b, &c);
    assert_null(b.coef);
    ref_assert_same(&a, &c);
    assert_int_equal(kn_bezier_copy(ctx, &c, &b), KN_OK); // an empty one
    assert_null(c.coef);
    assert_int_equal(kn_bezier_dim(&c), 0);
    kn_bezier_clear(ctx, &a);
    assert_null(a.coef);
    assert_int_equal(a.nvars, 0);
    kn_bezier_clear(ctx, &a); // twice is fine
    kn_bezier_clear(ctx, NULL);
    assert_int_equal(kn_ctx_counters(ctx).live_blocks, 0);
    test_ctx_end(ctx, &memory);
}

static void refuse_init(kn_ctx *ctx, int nvars, int ncomp, bool rational, const int *degree, kn_status expected)
{
    kn_bezier out;
    ref_make_sentinel(ctx, &out);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_init(ctx, &out, nvars, ncomp, rational, degree), expected);
    assert_int_equal(kn_ctx_error(ctx), expected);
    assert_true(ref_is_sentinel(&out));
    kn_bezier_clear(ctx, &out);
}

static void limits(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int small[KN_MAX_VARS + 1] = {0}, high[1] = {KN_MAX_DEGREE + 1}, negative[2] = {1, -1};
    const int huge[1] = {2147483647}, top[1] = {KN_MAX_DEGREE};
    const int many[KN_MAX_VARS] = {56, 56, 56, 56, 56, 56, 56, 56}; // 57^8 coefficients: more than 2^46
    const int full[7] = {15, 15, 15, 15, 15, 15, 15};               // 16^7 = KN_MAX_COEFS
    kn_bezier out;
    refuse_init(ctx, KN_MAX_VARS + 1, 1, false, small, KN_ELIMIT);
    refuse_init(ctx, 1, KN_MAX_COMPS + 1, false, small, KN_ELIMIT);
    refuse_init(ctx, 1, 1, false, high, KN_ELIMIT);
    refuse_init(ctx, 1, 1, false, huge, KN_ELIMIT);
    refuse_init(ctx, 8, 64, true, many, KN_ELIMIT);
    refuse_init(ctx, 7, 2, false, full, KN_ELIMIT);
    assert_int_equal(kn_bezier_check(ctx, "limits", 7, 1, false, full), KN_OK); // without the 2 GiB
    refuse_init(ctx, 2, 1, false, negative, KN_EDOMAIN);
    refuse_init(ctx, -1, 1, false, small, KN_EDOMAIN);
    refuse_init(ctx, 1, 0, false, small, KN_EDOMAIN);
    refuse_init(ctx, 1, 1, true, small, KN_EDOMAIN); // a weight alone
    assert_int_equal(kn_bezier_init(ctx, &out, 1, KN_MAX_COMPS, true, top), KN_OK);
    kn_bezier_clear(ctx, &out);
    assert_int_equal(kn_bezier_init(ctx, &out, KN_MAX_VARS, 1, false, small), KN_OK);
    kn_bezier_clear(ctx, &out);
    assert_int_equal(kn_bezier_init(ctx, &out, 0, 1, false, NULL), KN_OK); // a constant
    assert_int_equal(kn_bezier_count(&out), 1);
    kn_bezier_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static void elevation(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 4), degree[4], to[4];
        kn_bezier a, e = {0};
        ref_random_degrees(&rng, degree, nvars);
        for (int d = 0; d < nvars; d++) to[d] = degree[d] + test_int(&rng, 0, 2);
        test_random_bezier(ctx, &a, &rng, nvars, 3, n % 2 == 0, degree, 9);
        double m = ref_multiple(nvars, to), at[4];
        for (size_t i = 0; i < 3 * kn_bezier_count(&a); i++) a.coef[i] *= m;
        assert_int_equal(kn_bezier_elevate(ctx, &e, &a, to), KN_OK);
        assert_memory_equal(e.degree, to, (size_t)nvars * sizeof *to);
        ref_random_point(&rng, at, nvars);
        assert_same_at(&a, at, &e, at);
        assert_int_equal(kn_bezier_elevate(ctx, &a, &a, to), KN_OK); // in place
        ref_assert_same(&a, &e);
        assert_int_equal(kn_bezier_elevate(ctx, &a, &a, to), KN_OK); // to the degree it has
        ref_assert_same(&a, &e);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &e);
    }
    test_ctx_end(ctx, &memory);
}

static void highest_elevation(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[1] = {3}, to[1] = {KN_MAX_DEGREE}, over[1] = {KN_MAX_DEGREE + 1}, lower[1] = {2};
    kn_bezier a, e;
    assert_int_equal(kn_bezier_init(ctx, &a, 1, 1, false, degree), KN_OK);
    ref_make_sentinel(ctx, &e);
    assert_int_equal(kn_bezier_elevate(ctx, &e, &a, over), KN_ELIMIT);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_elevate(ctx, &e, &a, lower), KN_EDOMAIN);
    assert_true(ref_is_sentinel(&e));
    for (int i = 0; i < 4; i++) a.coef[i] = 1.0;
    assert_int_equal(kn_bezier_elevate(ctx, &e, &a, to), KN_OK);
    for (int i = 0; i <= KN_MAX_DEGREE; i++) assert_true(e.coef[i] == 1.0);
    a.coef[0] = -1.0; // 1 - 2 (1-t)^3: c_k = (C(56,k) - 2 C(53,k)) / C(56,k), integers below 2^53
    assert_int_equal(kn_bezier_elevate(ctx, &e, &a, to), KN_OK);
    for (int k = 0; k <= KN_MAX_DEGREE; k++) {
        long long over_k = ref_binomial(56, k) - 2 * ref_binomial(53, k);
        assert_true(e.coef[k] == (double)over_k / (double)ref_binomial(56, k));
    }
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &e);
    test_ctx_end(ctx, &memory);
}

static void subdivision(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 4), degree[4], var = test_int(&rng, 0, nvars - 1);
        double x[4], y[4], t = test_int(&rng, -2, 6) / 4.0;
        kn_bezier a, l = {0}, r = {0};
        ref_random_degrees(&rng, degree, nvars);
        test_random_bezier(ctx, &a, &rng, nvars, 3, n % 2 == 0, degree, 9);
        assert_int_equal(kn_bezier_subdivide(ctx, &l, &r, &a, var, t), KN_OK);
        ref_random_point(&rng, x, nvars);
        for (int d = 0; d < nvars; d++) y[d] = x[d];
        y[var] = t * x[var];
        assert_same_at(&l, x, &a, y);
        y[var] = t + (1.0 - t) * x[var];
        assert_same_at(&r, x, &a, y);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &l);
        kn_bezier_clear(ctx, &r);
    }
    test_ctx_end(ctx, &memory);
}

static void restriction(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 4), degree[4];
        double lo[4], hi[4], x[4], y[4];
        kn_bezier a, c = {0};
        ref_random_degrees(&rng, degree, nvars);
        test_random_bezier(ctx, &a, &rng, nvars, 3, n % 2 == 0, degree, 9);
        for (int d = 0; d < nvars; d++) { // halves, to keep four variables exact; also lo > hi and lo == hi
            lo[d] = test_int(&rng, -2, 3) / 2.0;
            hi[d] = test_int(&rng, -2, 3) / 2.0;
        }
        assert_int_equal(kn_bezier_restrict(ctx, &c, &a, lo, hi), KN_OK);
        for (int d = 0; d < nvars; d++) {
            x[d] = test_int(&rng, -1, 3) / 2.0;
            y[d] = lo[d] + x[d] * (hi[d] - lo[d]);
        }
        assert_same_at(&c, x, &a, y);
        assert_int_equal(kn_bezier_restrict(ctx, &a, &a, lo, hi), KN_OK); // in place
        ref_assert_same(&a, &c);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &c);
    }
    test_ctx_end(ctx, &memory);
}

// Neighbouring restrictions share their edge bit for bit, whatever the numbers; the unit box changes no bit.
static void restrictions_meet(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    const int degree[2] = {5, 3};
    kn_bezier a, l = {0}, r = {0}, same = {0};
    assert_int_equal(kn_bezier_init(ctx, &a, 2, 1, false, degree), KN_OK);
    for (int i = 0; i < 24; i++) a.coef[i] = test_uniform(&rng, -1.0, 1.0);
    const double t = test_uniform(&rng, 0.2, 0.8), zero[2] = {0.0, 0.0}, one[2] = {1.0, 1.0};
    const double mid_hi[2] = {t, 1.0}, mid_lo[2] = {t, 0.0};
    assert_int_equal(kn_bezier_restrict(ctx, &l, &a, zero, mid_hi), KN_OK);
    assert_int_equal(kn_bezier_restrict(ctx, &r, &a, mid_lo, one), KN_OK);
    for (int j = 0; j < 4; j++) {
        assert_true(l.coef[5 * 4 + j] == r.coef[j]);
        assert_true(l.coef[j] == a.coef[j]);
        assert_true(r.coef[5 * 4 + j] == a.coef[5 * 4 + j]);
    }
    assert_int_equal(kn_bezier_restrict(ctx, &same, &a, zero, one), KN_OK);
    ref_assert_same(&same, &a);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &l);
    kn_bezier_clear(ctx, &r);
    kn_bezier_clear(ctx, &same);
    test_ctx_end(ctx, &memory);
}

// a = x_var^k q or (1 - x_var)^k q with coefficients made integers: the division gives q back.
static void edge_division(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 3), degree[4], to[4], zero[4] = {0}, var = test_int(&rng, 0, nvars - 1);
        int k = test_int(&rng, 0, 3), order = -1;
        bool at_end = n % 2;
        kn_bezier q, x, a = {0}, out = {0};
        ref_random_degrees(&rng, degree, nvars);
        for (int d = 0; d < nvars; d++) to[d] = degree[d] + (d == var ? k : 0);
        test_random_bezier(ctx, &q, &rng, nvars, 2, false, degree, 9);
        q.coef[0] = q.coef[kn_bezier_count(&q) - 1] = 5.0; // not divisible once more
        double m = ref_multiple(nvars, to);
        for (size_t i = 0; i < 2 * kn_bezier_count(&q); i++) q.coef[i] *= m;
        zero[var] = k;
        assert_int_equal(kn_bezier_init(ctx, &x, nvars, 1, false, zero), KN_OK);
        x.coef[at_end ? 0 : k] = 1.0; // x^k or (1-x)^k
        assert_int_equal(kn_bezier_product(ctx, &a, &q, &x), KN_OK);
        assert_int_equal(kn_bezier_divide_edge(ctx, &out, &order, &a, var, at_end), KN_OK);
        assert_int_equal(order, k);
        ref_assert_same(&out, &q);
        assert_int_equal(kn_bezier_divide_edge(ctx, &a, &order, &a, var, at_end), KN_OK); // in place
        ref_assert_same(&a, &q);
        kn_bezier_clear(ctx, &q);
        kn_bezier_clear(ctx, &x);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

static void polynomial_derivative(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 4), degree[4], order[KN_MAX_VARS] = {0}, var = test_int(&rng, 0, nvars - 1);
        kn_bezier a, da = {0};
        double at[4];
        long double expected[2], got[2];
        ref_random_degrees(&rng, degree, nvars);
        test_random_bezier(ctx, &a, &rng, nvars, 2, false, degree, 9);
        assert_int_equal(kn_bezier_derivative(ctx, &da, &a, var), KN_OK);
        assert_int_equal(da.degree[var], degree[var] ? degree[var] - 1 : 0);
        ref_random_point(&rng, at, nvars);
        order[var] = 1;
        ref_partial(expected, &a, at, order);
        ref_homogeneous(got, &da, at);
        for (int c = 0; c < 2; c++) assert_true(got[c] == expected[c]);
        assert_int_equal(kn_bezier_derivative(ctx, &a, &a, var), KN_OK); // in place
        ref_assert_same(&a, &da);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &da);
    }
    test_ctx_end(ctx, &memory);
}

// (N/w)' w^2 = N' w - w' N, with coefficients made integers, exactly; and the same from kn_bezier_derivatives, where
// the quotients N/w and (N' - w' N/w)/w are rounded.
static void rational_derivative(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(7);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 2), degree[2], twice[2], order[KN_MAX_VARS] = {0};
        int var = test_int(&rng, 0, nvars - 1);
        kn_bezier a, da = {0};
        double at[2], got[3 * 2];
        for (int d = 0; d < nvars; d++) degree[d] = test_int(&rng, 0, 2), twice[d] = 2 * degree[d];
        test_random_bezier(ctx, &a, &rng, nvars, 3, true, degree, 5);
        double m = ref_multiple(nvars, twice);
        for (size_t i = 0; i < 3 * kn_bezier_count(&a); i++) a.coef[i] *= m;
        assert_int_equal(kn_bezier_derivative(ctx, &da, &a, var), KN_OK);
        for (int d = 0; d < nvars; d++) at[d] = test_int(&rng, 0, 4) / 4.0;
        order[var] = 1;
        long double f[3], df[3], h[3];
        ref_homogeneous(f, &a, at);
        ref_partial(df, &a, at, order);
        ref_homogeneous(h, &da, at);
        assert_int_equal(kn_bezier_derivatives(ctx, got, &a, at, 1), KN_OK);
        for (int c = 0; c < 2; c++) {
            long double top = df[c] * f[2] - df[2] * f[c];
            assert_true(h[c] * f[2] * f[2] == top * h[2]);
            // f_c = fl(f/w), fl(w' f_c), fl(N' - .), fl(./w): at most 4 roundings of |N'/w| + |w' N / w^2|
            long double size = (fabsl(df[c]) * f[2] + fabsl(df[2] * f[c])) / (f[2] * f[2]);
            int place = kn_derivative_index(nvars, order);
            assert_true(fabsl(got[place * 2 + c] - top / (f[2] * f[2])) <= 5 * (long double)DBL_EPSILON / 2 * size);
        }
        assert_int_equal(kn_bezier_derivative(ctx, &a, &a, var), KN_OK); // in place
        ref_assert_same(&a, &da);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &da);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[1] = {3}, high[1] = {29};
    const double zero[1] = {0.0}, infinite[1] = {INFINITY}, nan[1] = {NAN};
    kn_bezier a, rational, empty = {0}, out, right;
    int order = 42;
    assert_int_equal(kn_bezier_init(ctx, &a, 1, 2, false, degree), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &rational, 1, 2, true, high), KN_OK);
    ref_make_sentinel(ctx, &out);
    ref_make_sentinel(ctx, &right);
    assert_int_equal(kn_bezier_elevate(ctx, &out, &empty, degree), KN_EDOMAIN);
    assert_int_equal(kn_bezier_subdivide(ctx, &out, &right, &empty, 0, 0.5), KN_EDOMAIN);
    assert_int_equal(kn_bezier_subdivide(ctx, &out, &right, &a, 1, 0.5), KN_EDOMAIN);
    assert_int_equal(kn_bezier_subdivide(ctx, &out, &right, &a, 0, NAN), KN_EDOMAIN);
    assert_int_equal(kn_bezier_restrict(ctx, &out, &empty, zero, zero), KN_EDOMAIN);
    assert_int_equal(kn_bezier_restrict(ctx, &out, &a, nan, zero), KN_EDOMAIN);
    assert_int_equal(kn_bezier_restrict(ctx, &out, &a, zero, infinite), KN_EDOMAIN);
    assert_int_equal(kn_bezier_derivative(ctx, &out, &empty, 0), KN_EDOMAIN);
    assert_int_equal(kn_bezier_derivative(ctx, &out, &a, -1), KN_EDOMAIN);
    assert_int_equal(kn_bezier_derivative(ctx, &out, &a, 1), KN_EDOMAIN);
    assert_int_equal(kn_bezier_divide_edge(ctx, &out, &order, &empty, 0, false), KN_EDOMAIN);
    assert_int_equal(kn_bezier_divide_edge(ctx, &out, &order, &a, 2, false), KN_EDOMAIN);
    assert_int_equal(kn_ctx_error(ctx), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    kn_bezier forged = a; // put together by hand, beyond the limits
    forged.degree[0] = KN_MAX_DEGREE + 1;
    double value[2];
    assert_int_equal(kn_bezier_eval(ctx, value, &forged, zero), KN_ELIMIT);
    assert_int_equal(kn_bezier_subdivide(ctx, &out, &right, &forged, 0, 0.5), KN_ELIMIT);
    assert_int_equal(kn_bezier_restrict(ctx, &out, &forged, zero, zero), KN_ELIMIT);
    forged.nvars = KN_MAX_VARS + 1;
    assert_int_equal(kn_bezier_product(ctx, &out, &forged, &a), KN_ELIMIT);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_divide_edge(ctx, &out, &order, &a, 0, false), KN_EUNDEFINED);
    assert_int_equal(kn_bezier_divide_edge(ctx, &out, &order, &a, 0, true), KN_EUNDEFINED);
    assert_int_equal(kn_ctx_error(ctx), KN_EUNDEFINED);
    assert_int_equal(kn_bezier_derivative(ctx, &out, &rational, 0), KN_ELIMIT); // degree 58
    assert_int_equal(order, 42);
    assert_true(ref_is_sentinel(&out) && ref_is_sentinel(&right));
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &rational);
    kn_bezier_clear(ctx, &out);
    kn_bezier_clear(ctx, &right);
    test_ctx_end(ctx, &memory);
}

static kn_status call_shape(kn_ctx *ctx, void *user)
{
    const int degree[2] = {2, 1}, to[2] = {3, 3}, zero[2] = {0, 0};
    const double lo[2] = {0.25, 0.0}, hi[2] = {0.5, 1.0};
    int which = *(const int *)user, order = 42;
    kn_bezier a = {0}, out = {0}, right = {0};
    kn_status status = kn_bezier_init(ctx, &a, 2, 2, true, degree);
    if (status == KN_OK) a.coef[3] = 1.0;
    if (status == KN_OK) status = kn_bezier_init(ctx, &out, 1, 1, false, zero);
    bool made = status == KN_OK;
    if (made && which == 0) status = kn_bezier_elevate(ctx, &out, &a, to);
    if (made && which == 1) status = kn_bezier_subdivide(ctx, &out, &right, &a, 0, 0.5);
    if (made && which == 2) status = kn_bezier_restrict(ctx, &out, &a, lo, hi);
    if (made && which == 3) status = kn_bezier_derivative(ctx, &out, &a, 0);
    if (made && which == 4) status = kn_bezier_divide_edge(ctx, &out, &order, &a, 0, false);
    if (made && which == 5) status = kn_bezier_copy(ctx, &out, &a);
    if (made && status != KN_OK) assert_true(out.nvars == 1 && out.coef && !right.coef && order == 42);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &out);
    kn_bezier_clear(ctx, &right);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    for (int which = 0; which < 6; which++) test_allocation_failures(call_shape, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(life),
                                       cmocka_unit_test(limits),
                                       cmocka_unit_test(elevation),
                                       cmocka_unit_test(highest_elevation),
                                       cmocka_unit_test(subdivision),
                                       cmocka_unit_test(restriction),
                                       cmocka_unit_test(restrictions_meet),
                                       cmocka_unit_test(edge_division),
                                       cmocka_unit_test(polynomial_derivative),
                                       cmocka_unit_test(rational_derivative),
                                       cmocka_unit_test(failures),
                                       cmocka_unit_test(out_of_memory)};
    return cmocka_run_group_tests_name("bezier/shape", tests, NULL, NULL);
}
