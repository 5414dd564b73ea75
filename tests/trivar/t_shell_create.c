// SPDX-License-Identifier: Apache-2.0
// What kn_shell_create refuses, what it tells of itself, and running out of memory.
#include "tests/support/surfaces.h"

#include <math.h>
#include <string.h>

static kn_status make(kn_ctx *ctx, kn_spline *s, const int degree[2], const int count[2], const double *ku,
                      const double *kv, const double *coef)
{
    const double *knots[2] = {ku, kv};
    return kn_spline_init(ctx, s, 2, 3, false, degree, count, knots, coef);
}

static void expect(kn_ctx *ctx, const kn_spline *s, const kn_shell_options *o, kn_status status, const char *says)
{
    kn_shell *shell = (kn_shell *)ctx, *before = shell;
    kn_ctx_clear_error(ctx);
    kn_status got = kn_shell_create(ctx, &shell, s, o);
    if (got != status) fail_msg("%s, not %s: %s", kn_status_name(got), kn_status_name(status), kn_ctx_message(ctx));
    assert_ptr_equal(shell, before);
    assert_int_equal(kn_ctx_error(ctx), status);
    if (!strstr(kn_ctx_message(ctx), says)) fail_msg("\"%s\" without \"%s\"", kn_ctx_message(ctx), says);
}

static const double bilinear[4] = {0, 0, 1, 1};
static const double quadratic[6] = {0, 0, 0, 1, 1, 1};

static void bad_options(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_wavy(ctx, &s); // knots 0 1 2 3 and 0 2 3
    kn_shell_options o = kn_shell_defaults();
    o.normal_tol = -1;
    expect(ctx, &s, &o, KN_EDOMAIN, "normal_tol");
    o.normal_tol = NAN;
    expect(ctx, &s, &o, KN_EDOMAIN, "normal_tol");
    o = (kn_shell_options){.max_degree = 2};
    expect(ctx, &s, &o, KN_EDOMAIN, "max_degree");
    o = (kn_shell_options){.max_degree = 57};
    expect(ctx, &s, &o, KN_ELIMIT, "max_degree");
    o = (kn_shell_options){.max_spans = -3};
    expect(ctx, &s, &o, KN_EDOMAIN, "max_spans");
    o = (kn_shell_options){.max_spans = 2};
    expect(ctx, &s, &o, KN_ELIMIT, "max_spans");
    o = (kn_shell_options){.max_spans = 8};
    expect(ctx, &s, &o, KN_EUNDECIDED, "max_spans");
    o = (kn_shell_options){.normal_tol = 1e-17}; // below what double precision can certify
    expect(ctx, &s, &o, KN_EUNDECIDED, "tolerance");
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// (t^2, v, e t), t = u - v: the normal turns over within e of a diagonal, which only a grid of 1/e lines each way
// follows. The work for a tolerance of 0.05 does not suffice for e = 1/500, and does for 1/20.
static void work_is_limited(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double *knots[2] = {quadratic, quadratic};
    for (double e = 0.05; e > 0.001; e /= 25.0) {
        kn_spline s;
        double coef[27];
        for (int i = 0; i < 3; i++) // polar forms of u^2 - 2 u v + v^2, v and e (u - v)
            for (int j = 0; j < 3; j++) {
                coef[3 * i + j] = (i == 2) - 0.5 * i * j + (j == 2);
                coef[9 + 3 * i + j] = 0.5 * j;
                coef[18 + 3 * i + j] = 0.5 * e * (i - j);
            }
        assert_int_equal(
            kn_spline_init(ctx, &s, 2, 3, false, (const int[2]){2, 2}, (const int[2]){3, 3}, knots, coef), KN_OK);
        kn_shell_options o = {.normal_tol = 0.05};
        kn_shell *shell = NULL;
        if (e < 0.01) {
            expect(ctx, &s, &o, KN_EUNDECIDED, "work");
        } else {
            assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
            kn_shell_destroy(ctx, shell);
        }
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void bad_lines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_wavy(ctx, &s);
    static const double missing[] = {0, 1, 1.5, 3}, short_end[] = {0, 1, 2, 2.5}, late[] = {0.5, 1, 2, 3},
                        back[] = {0, 1, 2, 1.5, 3}, twice[] = {0, 1, 1, 2, 3}, nan[] = {0, 1, NAN, 2, 3}, one[] = {0};
    const struct {
        const double *line;
        int n;
    } bad[] = {{missing, 4}, {short_end, 4}, {late, 4}, {back, 5}, {twice, 5}, {nan, 5}, {one, 1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        kn_shell_options o = {.lines = {bad[i].line, NULL}, .nlines = {bad[i].n, 0}};
        expect(ctx, &s, &o, KN_EDOMAIN, "variable 0");
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void bad_surfaces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    const int one[2] = {1, 1}, two[2] = {2, 2}, three[2] = {3, 3};
    const double flat[12] = {0, 1, 2, 3, 0, 2, 4, 6, 0, 0, 0, 0}; // all on one line
    assert_int_equal(make(ctx, &s, one, two, bilinear, bilinear, flat), KN_OK);
    expect(ctx, &s, NULL, KN_EDOMAIN, "area");
    kn_spline_clear(ctx, &s);

    // of two spans in u the second is a line
    const double k5[5] = {0, 0, 1, 2, 2}, half[18] = {0, 0, 1, 1, 1, 1, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0};
    assert_int_equal(make(ctx, &s, one, (const int[2]){3, 2}, k5, bilinear, half), KN_OK);
    expect(ctx, &s, NULL, KN_EDOMAIN, "area");
    kn_spline_clear(ctx, &s);

    // x = u (1 - u), y = v: a fold, whose cross product vanishes on the line u = 1/2 and turns over
    const double fold[27] = {0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    assert_int_equal(make(ctx, &s, two, three, quadratic, quadratic, fold), KN_OK);
    expect(ctx, &s, NULL, KN_EUNDEFINED, "(0.5, ");
    kn_spline_clear(ctx, &s);

    const double curve[6] = {0, 1, 0, 1, 0, 1}, *knots[2] = {bilinear, bilinear};
    assert_int_equal(kn_spline_init(ctx, &s, 1, 3, false, one, two, knots, curve), KN_OK);
    expect(ctx, &s, NULL, KN_EDOMAIN, "not a surface");
    kn_spline_clear(ctx, &s);
    assert_int_equal(kn_spline_init(ctx, &s, 2, 2, false, one, two, knots, flat), KN_OK);
    expect(ctx, &s, NULL, KN_EDOMAIN, "not a surface");
    kn_spline_clear(ctx, &s);

    assert_int_equal(make(ctx, &s, one, two, bilinear, bilinear, flat), KN_OK);
    s.coef[3] = NAN;
    kn_shell *shell = NULL;
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_EDOMAIN);
    assert_null(shell);
    kn_spline_clear(ctx, &s);
    kn_shell_destroy(ctx, NULL);
    test_ctx_end(ctx, &memory);
}

// A crease (C0 knots) leaves n two-sided there: each side keeps its own normal.
static void creases_keep_both_normals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    const double k5[5] = {0, 0, 1, 2, 2}, roof[18] = {0, 0, 1, 1, 2, 2, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0};
    assert_int_equal(make(ctx, &s, (const int[2]){1, 1}, (const int[2]){3, 2}, k5, bilinear, roof), KN_OK);
    kn_shell *shell = NULL;
    assert_int_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_OK);
    assert_true(kn_shell_certificate(shell).angle_error < 1e-12);
    double left[3], right[3];
    assert_int_equal(kn_spline_eval(ctx, left, kn_shell_normal(shell), (const double[2]){0.999, 0.5}), KN_OK);
    assert_int_equal(kn_spline_eval(ctx, right, kn_shell_normal(shell), (const double[2]){1.0, 0.5}), KN_OK);
    const double a[3] = {-sqrt(0.5), 0, sqrt(0.5)}, b[3] = {sqrt(0.5), 0, sqrt(0.5)};
    assert_true(test_max_difference(left, a, 3) < 1e-12 && test_max_difference(right, b, 3) < 1e-12);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void cells_and_closedness(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const bool closed[SURFACE_CASES][2] = {[1] = {true, false}, [2] = {true, true}, [3] = {true, false}};
    const int cells[SURFACE_CASES][2] = {{1, 1}, {4, 1}, {4, 4}, {4, 2}, {3, 2}, {2, 3}, {3, 2}};
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = NULL;
        kn_shell_options o = {.normal_tol = 1e-3};
        assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
        bool c[2];
        int n[2];
        kn_shell_closed(shell, c);
        kn_shell_cells(shell, n);
        for (int v = 0; v < 2; v++) {
            assert_int_equal(c[v], closed[k][v]);
            assert_int_equal(n[v], cells[k][v]);
        }
        const kn_spline *copy = kn_shell_surface(shell);
        assert_true(copy->coef != s.coef);
        assert_true(test_max_difference(copy->coef, s.coef, kn_spline_count(&s) * (size_t)s.ncomp) == 0.0);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// user: a surface_case
static kn_status create(kn_ctx *ctx, void *user)
{
    const surface_case *c = user;
    kn_spline s = {0};
    kn_shell *shell = NULL;
    test_memory memory = TEST_MEMORY_INIT; // the surface from another context: its making cannot fail
    kn_ctx *other = test_ctx(&memory, 1);
    c->make(other, &s);
    kn_shell_options o = {.normal_tol = 0.02};
    kn_status status = kn_shell_create(ctx, &shell, &s, &o);
    if (status != KN_OK) assert_null(shell);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(other, &s);
    test_ctx_end(other, &memory);
    return status;
}

// A sheet of degree p in u with a slight bend.
static void make_sheet(kn_ctx *ctx, kn_spline *out, int p, bool rational)
{
    double knots[2 * (KN_MAX_DEGREE + 1)], coef[4 * 2 * (KN_MAX_DEGREE + 1)];
    int n = 2 * (p + 1);
    for (int i = 0; i <= p; i++) {
        double t = (double)i / p, w = rational ? 1 + 0.1 * t : 1;
        knots[i] = 0, knots[p + 1 + i] = 1;
        for (int j = 0; j < 2; j++) {
            double *c = coef + (size_t)(2 * i + j);
            c[0] = w * t, c[n] = w * j, c[2 * n] = w * 0.1 * t * (1 - t), c[3 * n] = w;
        }
    }
    const double *both[2] = {knots, bilinear};
    const int degree[2] = {p, 1}, count[2] = {p + 1, 2};
    assert_int_equal(kn_spline_init(ctx, out, 2, rational ? 4 : 3, rational, degree, count, both, coef), KN_OK);
}

// The certificate's products of n and S_u x S_v stay within KN_MAX_DEGREE: n's degree gives way, and where too little
// is left the surface is refused.
static void high_degrees(void **state)
{
    (void)state;
    static const struct {
        int degree;
        bool rational;
        int most; // of n
        kn_status status;
    } cases[] = {{16, true, 9, KN_OK},  {18, true, 3, KN_OK},  {19, true, 0, KN_ELIMIT},
                 {24, false, 9, KN_OK}, {27, false, 3, KN_OK}, {28, false, 0, KN_ELIMIT}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        kn_spline s = {0};
        kn_shell *shell = NULL;
        make_sheet(ctx, &s, cases[k].degree, cases[k].rational);
        kn_shell_options o = {.max_degree = 12};
        kn_status status = kn_shell_create(ctx, &shell, &s, &o);
        assert_int_equal(status, cases[k].status);
        if (status == KN_OK) assert_true(kn_shell_normal(shell)->degree[0] <= cases[k].most);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
        kn_ctx_clear_error(ctx);
    }
    test_ctx_end(ctx, &memory);
}

// A power of two changes no bit of n, nor of its certificate: squares that would over- or underflow do not matter.
static void any_scale(void **state)
{
    (void)state;
    static const int exponents[] = {0, -280, 280, -480, 480};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_normal_certificate first = {0};
    for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k++) {
        kn_spline s = {0};
        kn_shell *shell = NULL;
        make_wavy(ctx, &s);
        for (size_t i = 0; i < 3 * kn_spline_count(&s); i++) s.coef[i] = ldexp(s.coef[i], exponents[k]);
        assert_int_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_OK);
        kn_normal_certificate c = kn_shell_certificate(shell);
        if (k == 0) first = c;
        assert_true(c.certified && c.length_error == first.length_error && c.angle_error == first.angle_error);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void allocation_failures(void **state)
{
    (void)state;
    surface_case plane = surface_cases[0], cylinder = surface_cases[1];
    test_allocation_failures(create, &plane);
    test_allocation_failures(create, &cylinder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_options),
        cmocka_unit_test(work_is_limited),
        cmocka_unit_test(bad_lines),
        cmocka_unit_test(bad_surfaces),
        cmocka_unit_test(creases_keep_both_normals),
        cmocka_unit_test(cells_and_closedness),
        cmocka_unit_test(allocation_failures),
        cmocka_unit_test(high_degrees),
        cmocka_unit_test(any_scale),
    };
    return cmocka_run_group_tests_name("trivar/shell_create", tests, NULL, NULL);
}
