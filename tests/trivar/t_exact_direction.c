// SPDX-License-Identifier: Apache-2.0
// n = N m: its direction to rounding, its degrees and continuity, shared edges, pieces of T, limits, memory.
#include "tests/support/surfaces.h"

#include <math.h>
#include <string.h>

static kn_shell *create(kn_ctx *ctx, const kn_spline *s, double tol, int max_degree)
{
    kn_shell_options o = {.normal = KN_NORMAL_EXACT_DIRECTION, .normal_tol = tol, .max_degree = max_degree};
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

// How often the knot at index i of variable v is there.
static int times(const kn_spline *s, int v, int i)
{
    int n = 0;
    for (int k = 0; k < s->count[v] + s->degree[v] + 1; k++) n += s->knots[v][k] == s->knots[v][i];
    return n;
}

// The degree of N plus 3: 2 p - 1 of a polynomial of degree p, 3 p - 1 of a rational; a sphere's poles take two off
// in v.
static void degrees(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[SURFACE_CASES][2] = {{4, 4}, {8, 5}, {8, 8}, {8, 7}, {8, 8}, {8, 8}, {12, 10}};
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = create(ctx, &s, 1e-3, 0);
        const kn_spline *n = kn_shell_normal(shell);
        if (n->degree[0] != degree[k][0] || n->degree[1] != degree[k][1])
            fail_msg("%s: degrees %d, %d", surface_cases[k].name, n->degree[0], n->degree[1]);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// The knots of n next to the ends of variable v.
static void inner_knots(double next[2], const kn_spline *n, int v)
{
    next[0] = n->knots[v][n->degree[v] + 1];
    next[1] = n->knots[v][n->count[v] - 1];
}

// Whatever the tolerance, the angle is rounding: in N, degree (5,5), about 100 terms; in long double none. In the span
// next to a pole, where n is one vector, it is the error of the length there times (1 - x)^7 times the sine of the
// angle by which N has turned since: at most. The length is what the tolerance is for.
static void direction_is_exact(void **state)
{
    (void)state;
    const double tol = 0.05;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        kn_shell_edge edges[2][2];
        double lo[2], hi[2], next[2];
        long double length, angle, longest = 0;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = create(ctx, &s, tol, 0);
        kn_shell_edges(shell, edges);
        bool poles = edges[1][0].kind == KN_EDGE_POLE && edges[1][1].kind == KN_EDGE_POLE; // the sphere's
        for (int v = 0; v < 2; v++) kn_spline_domain(&s, v, &lo[v], &hi[v]);
        inner_knots(next, kn_shell_normal(shell), 1);
        for (int i = 0; i < 1000; i++) {
            double u = test_uniform(&rng, lo[0], hi[0]), v = test_uniform(&rng, lo[1], hi[1]);
            long double most = 1e-13L;
            if (!direct_errors(&length, &angle, shell, u, v)) continue;
            longest = fmaxl(longest, length);
            double x = (v - lo[1]) / (next[0] - lo[1]), y = (hi[1] - v) / (hi[1] - next[1]);
            if (poles && x < 1.0) most += tol * pow(1.0 - x, 7); // sin <= 1
            if (poles && y < 1.0) most += tol * pow(1.0 - y, 7);
            if (!(angle < most)) fail_msg("%s: angle %Lg at (%g, %g)", surface_cases[k].name, angle, u, v);
        }
        assert_true(kn_shell_certificate(shell).angle_error < (poles ? 0.1 * tol : 1e-10));
        assert_true(longest <= kn_shell_certificate(shell).length_error + 1e-17L);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Every coefficient of n along the edge is the unit normal there, bit for bit the same.
static void expect_one_vector(const kn_spline *n, int var, int end, const double wanted[3])
{
    size_t count = kn_spline_count(n), cross = (size_t)n->count[1 - var], step = var == 0 ? 1 : (size_t)n->count[1];
    size_t first = end ? (size_t)(n->count[var] - 1) * (var == 0 ? cross : 1) : 0;
    for (size_t c = 0; c < 3; c++)
        for (size_t k = 0; k < cross; k++) {
            assert_true(n->coef[c * count + first + k * step] == n->coef[c * count + first]);
            assert_true(fabs(n->coef[c * count + first] - wanted[c]) <= 1e-13); // rounding of N: some 100 units
        }
}

// At a pole n is one vector; the length next to it and the angle keep to the tolerance, and the map is that of one
// point at every height.
static void poles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (double tol = 1e-2; tol > 5e-7; tol *= 1e-2) {
        kn_spline s;
        long double length, angle;
        make_dome(ctx, &s);
        kn_shell *shell = create(ctx, &s, tol, 0);
        kn_normal_certificate c = kn_shell_certificate(shell);
        expect_one_vector(kn_shell_normal(shell), 1, 0, (const double[3]){0, 0, -1});
        assert_true(c.certified && c.length_error <= tol && c.angle_error <= 0.1 * tol);
        for (int i = 0; i <= 20; i++)
            for (int j = 1; j <= 40; j++) {
                assert_true(direct_errors(&length, &angle, shell, i / 20.0, 0.002 * j * j / 4.0));
                assert_true(length <= c.length_error + 1e-15L && angle <= c.angle_error + 1e-12L);
            }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
        make_sphere(ctx, &s);
        shell = create(ctx, &s, tol, 0);
        expect_one_vector(kn_shell_normal(shell), 1, 0, (const double[3]){0, 0, -1});
        expect_one_vector(kn_shell_normal(shell), 1, 1, (const double[3]){0, 0, 1});
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// No knot but a crease makes n jump; inside a span of S it is C2, as m.
static void continuity(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = create(ctx, &s, 1e-4, 0);
        const kn_spline *n = kn_shell_normal(shell);
        for (int v = 0; v < 2; v++)
            for (int i = n->degree[v] + 1; i < n->count[v]; i++) {
                bool of_s = false;
                for (int j = 0; j < s.count[v] + s.degree[v] + 1; j++) of_s = of_s || s.knots[v][j] == n->knots[v][i];
                int most = of_s ? n->degree[v] : n->degree[v] - 2; // C0, C2
                if (!(times(n, v, i) <= most))
                    fail_msg("%s: knot %g of variable %d is there %d times", surface_cases[k].name, n->knots[v][i], v,
                             times(n, v, i));
            }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void make_strips(kn_ctx *ctx, kn_spline *out, const double coef[18])
{
    static const double ku[5] = {0, 0, 1, 2, 2}, kv[4] = {0, 0, 1, 1};
    const double *knots[2] = {ku, kv};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[2]){1, 1}, (const int[2]){3, 2}, knots, coef),
                     KN_OK);
}

// Two strips in a plane that meet where |S_u| jumps: by 3 all along the line, and n is one vector on both sides; by a
// factor that varies along it, and n jumps, in length alone and within the certificate.
static void uneven_speeds(void **state)
{
    (void)state;
    const double even[18] = {0, 0, 1, 1, 4, 4, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0};
    const double uneven[18] = {0, 0, 1, 1, 4, 6, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int k = 0; k < 2; k++) {
        kn_spline s;
        make_strips(ctx, &s, k == 0 ? even : uneven);
        kn_shell *shell = create(ctx, &s, 1e-6, 0);
        const kn_spline *n = kn_shell_normal(shell);
        kn_normal_certificate c = kn_shell_certificate(shell);
        int middle = n->degree[0] + 1;
        while (n->knots[0][middle] < 1.0) middle++;
        assert_true(n->knots[0][middle] == 1.0 && times(n, 0, middle) == n->degree[0] + k);
        assert_true(c.length_error <= 1e-6 && c.angle_error < 1e-12);
        for (int i = 0; i <= 40; i++)
            for (int j = 0; j <= 20; j++) {
                double x[3], at[2] = {i / 20.0, j / 20.0};
                assert_int_equal(kn_spline_eval(ctx, x, n, at), KN_OK);
                assert_true(fabs(x[0]) < 1e-14 && fabs(x[1]) < 1e-14 && fabs(x[2] - 1.0) <= c.length_error + 1e-15);
            }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// A crease: each side has its own normal.
static void creases(void **state)
{
    (void)state;
    const double roof[18] = {0, 0, 1, 1, 2, 2, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    double left[3], right[3];
    make_strips(ctx, &s, roof);
    kn_shell *shell = create(ctx, &s, 1e-6, 0);
    assert_int_equal(kn_spline_eval(ctx, left, kn_shell_normal(shell), (const double[2]){0.999, 0.5}), KN_OK);
    assert_int_equal(kn_spline_eval(ctx, right, kn_shell_normal(shell), (const double[2]){1.0, 0.5}), KN_OK);
    const double a[3] = {-sqrt(0.5), 0, sqrt(0.5)}, b[3] = {sqrt(0.5), 0, sqrt(0.5)};
    assert_true(test_max_difference(left, a, 3) < 1e-12 && test_max_difference(right, b, 3) < 1e-12);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Patches 4 and 5 of the teapot mirror each other across the edge u = 1 / u = 0: |S_u x S_v| agrees there, and so do
// the coefficients of n.
static void shared_edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline a, b;
    bool found = make_teapot(ctx, &a, 4) && make_teapot(ctx, &b, 5);
    if (found) {
        kn_shell *sa = create(ctx, &a, 1e-4, 0), *sb = create(ctx, &b, 1e-4, 0);
        const kn_spline *na = kn_shell_normal(sa), *nb = kn_shell_normal(sb);
        assert_int_equal(na->count[1], nb->count[1]);
        size_t count_a = kn_spline_count(na), count_b = kn_spline_count(nb), row = (size_t)na->count[1];
        for (size_t c = 0; c < 3; c++)
            for (size_t j = 0; j < row; j++) { // 2^-44: products of degree 8 and the way back from pieces, J below 20
                double x = na->coef[c * count_a + count_a - row + j], y = nb->coef[c * count_b + j];
                assert_true(fabs(x - y) <= 0x1p-44);
            }
        kn_shell_destroy(ctx, sa);
        kn_shell_destroy(ctx, sb);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
    if (!found) skip();
}

// The pieces of T take n as it is where no knot of n lies inside.
static void pieces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_wavy(ctx, &s);
    kn_shell *shell = create(ctx, &s, 0.05, 5);
    const int cell[2] = {1, 0};
    const double lo[2] = {0, 0}, hi[2] = {0x1p-6, 0x1p-6};
    kn_shell_piece piece;
    bool fits = false;
    assert_int_equal(kn_shell_piece_init(ctx, &piece, &fits, shell, cell, lo, hi, 0), KN_OK);
    assert_true(fits && piece.exact && piece.deviation == 0.0 && piece.normal.certified);
    assert_true(piece.normal.length_error <= 0.05 && piece.normal.angle_error < 1e-11);
    const kn_spline *n = kn_shell_normal(shell);
    assert_true(piece.term[1].degree[0] == n->degree[0] && piece.term[1].degree[1] == n->degree[1]);
    for (int i = 0; i <= 8; i++) {
        const double x[2] = {i / 8.0, (i * 3 % 8) / 8.0};
        double f[2][3], p[3];
        for (int t = 0; t < 2; t++) assert_int_equal(kn_bezier_eval(ctx, f[t], &piece.term[t], x), KN_OK);
        double u = 1.0 + x[0] * 0x1p-6, v = 2.0 * x[1] * 0x1p-6; // cell (1,0) is [1,2] x [0,2]
        assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, u, v, 0.75), KN_OK);
        for (int c = 0; c < 3; c++) assert_true(fabs(f[0][c] + 0.75 * f[1][c] - p[c]) < 1e-13);
    }
    kn_shell_piece_clear(ctx, &piece);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// ---- failures ----

// The certificate squares n: N and m have 28 degrees between them, and m three at least.
static void limits(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int p = 13; p <= 14; p++) {
        double knots[30], coef[6 * 15];
        for (int i = 0; i <= p; i++) {
            knots[i] = 0, knots[p + 1 + i] = 1;
            for (int j = 0; j < 2; j++) {
                double t = (double)i / p, *c = coef + 2 * i + j;
                c[0] = t, c[2 * (p + 1)] = j, c[4 * (p + 1)] = 0.1 * t * (1 - t);
            }
        }
        const double kv[4] = {0, 0, 1, 1}, *both[2] = {knots, kv};
        kn_spline s;
        kn_shell *shell = NULL;
        kn_shell_options o = {.normal = KN_NORMAL_EXACT_DIRECTION, .normal_tol = 1e-3, .max_degree = 12};
        assert_int_equal(
            kn_spline_init(ctx, &s, 2, 3, false, (const int[2]){p, 1}, (const int[2]){p + 1, 2}, both, coef), KN_OK);
        kn_status status = kn_shell_create(ctx, &shell, &s, &o);
        if (p == 13) {
            assert_int_equal(status, KN_OK);
            assert_int_equal(kn_shell_normal(shell)->degree[0], 28);
        } else {
            assert_int_equal(status, KN_ELIMIT);
            assert_null(shell);
            assert_non_null(strstr(kn_ctx_message(ctx), "degree 27 in variable 0, above 25"));
        }
        kn_ctx_clear_error(ctx);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    kn_spline s;
    kn_shell *shell = NULL;
    kn_shell_options o = {.normal = (kn_normal_method)7};
    make_plane(ctx, &s);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "normal 7"));
    kn_ctx_clear_error(ctx);
    o = (kn_shell_options){.normal = KN_NORMAL_EXACT_DIRECTION, .normal_tol = 1e-15}; // below rounding
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_EUNDECIDED);
    kn_ctx_clear_error(ctx);
    kn_spline_clear(ctx, &s);
    make_wavy(ctx, &s);
    o = (kn_shell_options){.normal = KN_NORMAL_EXACT_DIRECTION, .max_spans = 8};
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_EUNDECIDED);
    assert_non_null(strstr(kn_ctx_message(ctx), "max_spans"));
    assert_null(shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A power of two changes no bit of n.
static void any_scale(void **state)
{
    (void)state;
    static const int exponents[] = {0, -280, 280};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_normal_certificate first = {0};
    for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k++) {
        kn_spline s;
        make_wavy(ctx, &s);
        for (size_t i = 0; i < 3 * kn_spline_count(&s); i++) s.coef[i] = ldexp(s.coef[i], exponents[k]);
        kn_shell *shell = create(ctx, &s, 1e-3, 0);
        kn_normal_certificate c = kn_shell_certificate(shell);
        if (k == 0) first = c;
        assert_true(c.certified && c.length_error == first.length_error && c.angle_error == first.angle_error);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// user: a surface_case
static kn_status create_once(kn_ctx *ctx, void *user)
{
    const surface_case *c = user;
    kn_spline s = {0};
    kn_shell *shell = NULL;
    test_memory memory = TEST_MEMORY_INIT; // the surface from another context: its making cannot fail
    kn_ctx *other = test_ctx(&memory, 1);
    c->make(other, &s);
    kn_shell_options o = {.normal = KN_NORMAL_EXACT_DIRECTION, .normal_tol = 0.1};
    kn_status status = kn_shell_create(ctx, &shell, &s, &o);
    if (status != KN_OK) assert_null(shell);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(other, &s);
    test_ctx_end(other, &memory);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    surface_case plane = surface_cases[0], wavy = surface_cases[4];
    test_allocation_failures(create_once, &plane);
    test_allocation_failures(create_once, &wavy);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(degrees),
        cmocka_unit_test(direction_is_exact),
        cmocka_unit_test(poles),
        cmocka_unit_test(continuity),
        cmocka_unit_test(uneven_speeds),
        cmocka_unit_test(creases),
        cmocka_unit_test(shared_edges),
        cmocka_unit_test(pieces),
        cmocka_unit_test(limits),
        cmocka_unit_test(any_scale),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("trivar/exact_direction", tests, NULL, NULL);
}
