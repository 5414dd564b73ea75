// SPDX-License-Identifier: Apache-2.0
// kn_spline_compose: splines in splines, split where they cross knots, against evaluation and by hand.
#include "tests/support/support.h"

#include <knurl/compose.h>
#include <math.h>
#include <string.h>

// A univariate spline of one component or more.
static kn_spline curve(kn_ctx *ctx, int degree, int count, const double *knots, int ncomp, bool rational,
                       const double *coef)
{
    kn_spline s = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 1, ncomp, rational, &degree, &count, &knots, coef), KN_OK);
    return s;
}

// out(t) against outer(inner(t)) at random t, relative to `size`, the largest coefficient of outer.
static void check_values(kn_ctx *ctx, const kn_spline *out, const kn_spline *outer, const kn_spline *inner,
                         test_rng *rng, int points, double tolerance)
{
    double size = 0.0;
    size_t n = kn_spline_count(outer) * (size_t)kn_spline_dim(outer);
    for (size_t i = 0; i < n; i++) size = fmax(size, fabs(outer->coef[i]));
    for (int k = 0; k < points; k++) {
        double t[KN_MAX_VARS], x[KN_MAX_COMPS], want[KN_MAX_COMPS], got[KN_MAX_COMPS];
        for (int d = 0; d < inner->nvars; d++) {
            double lo, hi;
            kn_spline_domain(inner, d, &lo, &hi);
            t[d] = test_uniform(rng, lo, hi);
        }
        assert_int_equal(kn_spline_eval(ctx, x, inner, t), KN_OK);
        assert_int_equal(kn_spline_eval(ctx, want, outer, x), KN_OK);
        assert_int_equal(kn_spline_eval(ctx, got, out, t), KN_OK);
        for (int c = 0; c < kn_spline_dim(outer); c++) assert_true(fabs(got[c] - want[c]) <= tolerance * size);
    }
}

// A quadratic on 0, 1, 2, 3, C1, at x = t/2: the same coefficients on twice the knots, bit for bit.
static void scaled_parameter(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 2, 3, 3, 3}, coef[] = {1, 4, -2, 8, 6}, line[] = {0, 0, 6, 6},
                 ends[] = {0, 3};
    kn_spline outer = curve(ctx, 2, 5, knots, 1, false, coef), inner = curve(ctx, 1, 2, line, 1, false, ends);
    kn_spline out = {0};
    assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_OK);
    assert_int_equal(out.count[0], 5);
    for (int i = 0; i < 8; i++) assert_true(out.knots[0][i] == 2 * knots[i]);
    for (int i = 0; i < 5; i++) assert_true(out.coef[i] == coef[i]);
    // mirrored, in place: the last coefficients come first
    const double back[] = {3, 0};
    kn_spline mirror = curve(ctx, 1, 2, line, 1, false, back);
    assert_int_equal(kn_spline_compose(ctx, &mirror, &outer, &mirror), KN_OK);
    assert_int_equal(mirror.count[0], 5);
    for (int i = 0; i < 5; i++) assert_true(mirror.coef[i] == coef[4 - i]);
    assert_int_equal(kn_spline_compose(ctx, &outer, &outer, &inner), KN_OK);
    assert_true(outer.count[0] == 5 && outer.coef[3] == 8);
    kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
    kn_spline_clear(ctx, &mirror);
    test_ctx_end(ctx, &memory);
}

// How often `knot` occurs in variable var.
static int times(const kn_spline *s, int var, double knot)
{
    int n = 0;
    for (int i = 0; i < s->count[var] + s->degree[var] + 1; i++) n += s->knots[var][i] == knot;
    return n;
}

// The continuity at a break is the smaller one of inner's and outer's.
static void continuity(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(21);
    // outer: cubic, C2 at 1, C0 at 2, a jump at 3; inner: quadratic, C1 at 1/2, C0 at 1, x(t) = 4 t
    const double knots[] = {0, 0, 0, 0, 1, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4};
    const double coef[] = {1, 0, 2, -1, 3, 1, 1, 2, 5, 4, 3, 1};
    const double own[] = {0, 0, 0, 0.5, 1, 1, 1}, straight[] = {0, 1, 3, 4};
    kn_spline outer = curve(ctx, 3, 12, knots, 1, false, coef), inner = curve(ctx, 2, 4, own, 1, false, straight);
    kn_spline out = {0};
    assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_OK);
    assert_int_equal(out.degree[0], 6);
    assert_int_equal(times(&out, 0, 0.25), 4); // C2
    assert_int_equal(times(&out, 0, 0.5), 6);  // C0 of outer at 2, where inner is C1
    assert_int_equal(times(&out, 0, 0.75), 7); // a jump
    assert_int_equal(out.count[0], 7 + 4 + 6 + 7);
    // C2 spans of degree 6 on equal spans: J is 1 below C2's 3 arguments outside, at most 2^3; 200 roundings a piece
    check_values(ctx, &out, &outer, &inner, &rng, 50, 8 * 200 * 0x1p-53);
    kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// A spline with C0 knots at the integers inside [0, n]: no coefficient of a result comes from beyond its piece.
static void rough_spline(kn_ctx *ctx, kn_spline *out, test_rng *rng, int nvars, int ncomp, bool rational,
                         const int *degree, const int *spans)
{
    double knots[3][32];
    const double *list[3] = {knots[0], knots[1], knots[2]};
    int count[3];
    for (int d = 0; d < nvars; d++) {
        int n = 0;
        for (int i = 0; i <= spans[d]; i++)
            for (int k = 0; k < degree[d] + (i == 0 || i == spans[d]); k++) knots[d][n++] = i;
        count[d] = n - degree[d] - 1;
    }
    assert_int_equal(kn_spline_init(ctx, out, nvars, ncomp, rational, degree, count, list, NULL), KN_OK);
    size_t n = kn_spline_count(out);
    for (size_t i = 0; i < n; i++) {
        double w = rational ? test_uniform(rng, 0.5, 2.0) : 1.0;
        for (int c = 0; c < kn_spline_dim(out); c++) out->coef[(size_t)c * n + i] = w * test_uniform(rng, -1, 1);
        if (rational) out->coef[(size_t)(ncomp - 1) * n + i] = w;
    }
}

// Component c of inner becomes a function of variable var alone (-1: of both), with values in [lo, hi].
static void set_component(kn_spline *inner, test_rng *rng, int c, int var, double lo, double hi)
{
    size_t n = kn_spline_count(inner), row = (size_t)inner->count[1];
    double line[64];
    for (int i = 0; i < 64; i++) line[i] = test_uniform(rng, lo, hi);
    for (size_t i = 0; i < n; i++) {
        double x = var < 0 ? test_uniform(rng, lo, hi) : line[var == 0 ? i / row : i % row];
        double w = inner->rational ? inner->coef[(size_t)(inner->ncomp - 1) * n + i] : 1.0;
        inner->coef[(size_t)c * n + i] = w * x;
    }
}

// Surfaces in volumes that cross knots of two variables along parameter lines, up and down, beyond the domain too;
// the third component does as it likes inside one span. J = 1: pieces have P (T + n + 3) + .. < 250 roundings,
// values of inner at the knots' slope 100 more; beyond the domain by 1/4 the extension grows by (1 + 2/4)^degree a
// side, below 2^7 in all.
static void crossing_knots(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(22);
    for (int run = 0; run < test_scale(8); run++) {
        bool outer_rational = run & 1, inner_rational = run & 2;
        const int degree[3] = {2, 2, 1}, spans[3] = {4, 3, 2}, own[2] = {2, test_int(&rng, 1, 2)}, pieces[2] = {2, 1};
        kn_spline outer, inner, out = {0};
        rough_spline(ctx, &outer, &rng, 3, 3 + outer_rational, outer_rational, degree, spans);
        rough_spline(ctx, &inner, &rng, 2, 3 + inner_rational, inner_rational, own, pieces);
        if (inner_rational) // the weight is a product: x_0 depends on the first variable alone all the same
            for (size_t i = 0; i < kn_spline_count(&inner); i++)
                inner.coef[3 * kn_spline_count(&inner) + i] = (1.0 + 0.25 * (double)(i / (size_t)inner.count[1])) *
                                                              (1.0 + 0.5 * (double)(i % (size_t)inner.count[1] % 2));
        set_component(&inner, &rng, 0, 0, run & 4 ? -0.25 : 0.0, 4.0);
        set_component(&inner, &rng, 1, 1, 0.0, run & 4 ? 3.25 : 3.0);
        set_component(&inner, &rng, 2, -1, run % 3 == 0 ? 0.0 : 1.0, run % 3 == 0 ? 1.0 : 2.0);
        assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_OK);
        if (!out.rational) assert_int_equal(kn_spline_check(ctx, &out), KN_OK); // weights: positive values only
        assert_int_equal(out.rational, outer_rational || inner_rational);
        check_values(ctx, &out, &outer, &inner, &rng, 40, 4 * 128 * 350 * 0x1p-53);
        kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// A crossing of two components at one place is one break, however each is rounded: x_1 = k x_0, x_0 a cubic, and knots
// a and k a. A constant component on a jump has the value from the right, as kn_spline_eval has.
static void together(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(24);
    const double own[8] = {0, 0, 0, 0, 1, 1, 1, 1}, rise[4] = {0.05, 0.35, 0.4, 0.95};
    for (int run = 0; run < test_scale(40); run++) {
        const double k = test_uniform(&rng, 0.5, 1.5), a = test_uniform(&rng, 0.2, 0.8);
        const double knots[2][5] = {{0, 0, a, 1, 1}, {0, 0, k * a, 2, 2}}, *list[2] = {knots[0], knots[1]};
        double both[8], coef[9];
        for (int i = 0; i < 4; i++) both[i] = rise[i], both[4 + i] = k * rise[i];
        for (int i = 0; i < 9; i++) coef[i] = test_uniform(&rng, -1, 1);
        kn_spline outer = {0}, inner = curve(ctx, 3, 4, own, 2, false, both), out = {0};
        assert_int_equal(kn_spline_init(ctx, &outer, 2, 1, false, (int[]){1, 1}, (int[]){3, 3}, list, coef), KN_OK);
        assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_OK);
        assert_int_equal(kn_spline_spans(&out, 0), 2);
        kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
    }
    const double jump[] = {0, 0, 1, 1, 2, 2}, coef[] = {0, 1, 5, 6}, line[] = {0, 0, 1, 1}, still[] = {1, 1};
    kn_spline outer = curve(ctx, 1, 4, jump, 1, false, coef), inner = curve(ctx, 1, 2, line, 1, false, still);
    assert_int_equal(kn_spline_compose(ctx, &inner, &outer, &inner), KN_OK);
    for (int i = 0; i < inner.count[0]; i++) assert_true(inner.coef[i] == 5.0);
    kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner);
    test_ctx_end(ctx, &memory);
}

// Parameters far from 0: x rises over a domain of length 1 across the knots of a C1 quadratic. A break is off by at
// most 4 units of the parameter; x rises by less than 3 slope, and the join leaves that times half the jump of f''
// (spans 0.2 slope and more: below 130 / slope^2) times the length of a span, at most slope.
static void far_from_zero(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(23);
    for (int run = 0; run < test_scale(40); run++) {
        double far = run & 1 ? 1e6 : 1e9, slope = run & 2 ? 100.0 : 1.0, knots[8], coef[5], values[3];
        double own[5] = {far, far, far + test_uniform(&rng, 0.25, 0.75), far + 1, far + 1};
        for (int i = 0; i < 8; i++)
            knots[i] = slope * (i < 3 ? 0.0 : i > 4 ? 1.0 : 0.3 * (i - 2) + test_uniform(&rng, 0.0, 0.1));
        double tolerance = 4 * (nextafter(far, INFINITY) - far) * 3 * 130 /
                           0.5; // the largest coefficient is 1/2 or more
        coef[0] = 0.5;
        for (int i = 1; i < 5; i++) coef[i] = test_uniform(&rng, -1, 1);
        for (int i = 0; i < 3; i++) values[i] = slope * test_uniform(&rng, i / 3.0, (i + 1) / 3.0);
        kn_spline outer = curve(ctx, 2, 5, knots, 1, false, coef), inner = curve(ctx, 1, 3, own, 1, false, values);
        kn_spline out = {0}, other = {0};
        assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_OK);
        check_values(ctx, &out, &outer, &inner, &rng, 20, tolerance);
        assert_int_equal(kn_spline_substitute(ctx, &other, &outer, 0, &inner), KN_OK);
        check_values(ctx, &other, &outer, &inner, &rng, 20, tolerance);
        kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
        kn_spline_clear(ctx, &other);
    }
    test_ctx_end(ctx, &memory);
}

// x touches the knot 1 from above and from below, as a curve and as a surface: no break there. The surface
// (r - t)^2 touches 0 along a line that is no parameter line: that is not decided.
static void touching(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 2, 2, 2}, coef[] = {1, -3, 5, 2}, unit[] = {0, 0, 0, 1, 1, 1};
    kn_spline outer = curve(ctx, 2, 4, knots, 1, false, coef), out = {0};
    for (int side = -1; side <= 1; side += 2) { // 1 + side (1 - 2t)^2
        const double x[] = {1 + side, 1 - side, 1 + side};
        kn_spline inner = curve(ctx, 2, 3, unit, 1, false, x);
        assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_OK);
        assert_int_equal(out.count[0], 5);
        assert_true(out.coef[0] == (side > 0 ? 2 : 1));
        kn_spline_clear(ctx, &inner);
    }
    const double square[] = {0, 0, 0, 1, 1, 1}, *two[2] = {square, square};
    const int degree[2] = {2, 2}, count[2] = {3, 3};
    double bowl[9], ridge[9];
    const double a[3] = {1, -1, 1}, r[3] = {0, 0, 1}, t[3] = {0, 0.5, 1}; // (1-2r)^2, r^2, r
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            bowl[3 * i + j] = 1 + (a[i] + a[j]) / 2;
            ridge[3 * i + j] = 1 + r[i] - 2 * t[i] * t[j] + r[j];
        }
    kn_spline inner = {0};
    assert_int_equal(kn_spline_init(ctx, &inner, 2, 1, false, degree, count, two, bowl), KN_OK);
    assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_OK);
    assert_true(out.count[0] == 5 && out.count[1] == 5);
    memcpy(inner.coef, ridge, sizeof ridge);
    assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_EUNDECIDED);
    assert_non_null(strstr(kn_ctx_message(ctx), "the knot 1"));
    kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 1, 2, 2}, coef[] = {1, 2, 5}, line[] = {0, 0, 1, 1}, *two[2] = {line, line};
    const double x[] = {0, 1, 1, 2}; // r + t
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    kn_spline outer = curve(ctx, 1, 3, knots, 1, false, coef), inner = {0}, out = {0}, empty = {0};
    assert_int_equal(kn_spline_init(ctx, &inner, 2, 1, false, degree, count, two, x), KN_OK);
    assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "component 0 crosses the knot 1"));
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_spline_compose(ctx, &out, &inner, &outer), KN_EDOMAIN); // 2 variables, 1 component
    assert_int_equal(kn_spline_compose(ctx, &out, &empty, &inner), KN_EDOMAIN);
    assert_int_equal(kn_spline_compose(ctx, &out, &outer, &empty), KN_EDOMAIN);
    assert_int_equal(out.nvars, 0);
    kn_spline high[2] = {{0}, {0}};
    for (int i = 0; i < 2; i++) {
        int p[2] = {29, 2};
        kn_bezier b = {0};
        assert_int_equal(kn_bezier_init(ctx, &b, 1, 1, false, &p[i]), KN_OK);
        assert_int_equal(kn_spline_of_bezier(ctx, &high[i], &b), KN_OK);
        kn_bezier_clear(ctx, &b);
    }
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_spline_compose(ctx, &out, &high[0], &high[1]), KN_ELIMIT);
    assert_non_null(strstr(kn_ctx_message(ctx), "degree 58"));
    kn_spline_clear(ctx, &high[0]), kn_spline_clear(ctx, &high[1]);
    kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    const double knots[] = {0, 0, 1, 2, 2}, coef[] = {1, 2, 5}, line[] = {0, 0, 1, 1}, ends[] = {0, 2};
    const double bump[] = {1, -1, 1, 1, -1, 1}, unit[] = {0, 0, 0, 1, 1, 1}, *two[2] = {line, unit};
    const int one[2] = {1, 2}, few[2] = {2, 3}, three = 3;
    const double *outer_knots = knots;
    kn_spline outer = {0}, inner = {0}, out = {0};
    (void)user;
    kn_status status = kn_spline_init(ctx, &outer, 1, 1, false, one, &three, &outer_knots, coef);
    if (status == KN_OK && *(bool *)user) // touching, as a surface: by halving
        status = kn_spline_init(ctx, &inner, 2, 1, false, one, few, two, bump);
    else if (status == KN_OK)
        status = kn_spline_init(ctx, &inner, 1, 1, false, one, few, two, ends);
    for (int i = 0; status == KN_OK && *(bool *)user && i < 6; i++) inner.coef[i] += 1.0;
    if (status == KN_OK) status = kn_spline_compose(ctx, &out, &outer, &inner);
    assert_true((status == KN_OK) == (out.coef != NULL));
    kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    bool touch = false;
    test_allocation_failures(call, &touch);
    touch = true;
    test_allocation_failures(call, &touch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(scaled_parameter), cmocka_unit_test(continuity),
                                       cmocka_unit_test(crossing_knots),   cmocka_unit_test(far_from_zero),
                                       cmocka_unit_test(together),         cmocka_unit_test(touching),
                                       cmocka_unit_test(failures),         cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("compose/spline_compose", tests, NULL, NULL);
}
