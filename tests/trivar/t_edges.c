// SPDX-License-Identifier: Apache-2.0
// kn_shell_edges, and normals where factors of S_u x S_v vanish: edges that are points, to any order, two of them
// that meet, edges along which S_v vanishes, an apex, and places that have no normal at all.
#include "tests/support/surfaces.h"

#include <knurl/construct.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

static const kn_normal_method methods[2] = {KN_NORMAL_FITTED, KN_NORMAL_EXACT_DIRECTION};

// ---- a paraboloid z = a x^2 + b y^2 over degenerate maps (u,v) -> (x,y) of bidegree (3,3) ----
// Wherever the map's Jacobian does not vanish the normal is that of the paraboloid; at its zeros along an edge so is
// the limit.

static const double a = 0.4, b = -0.3;

typedef struct place {
    double x, y;
} place;

typedef struct map_case {
    const char *name;
    place (*map)(double u, double v);
    int sign;                // of x_u y_v - x_v y_u
    kn_edge_kind kind[2][2]; // of the edges u = 0, u = 1, v = 0, v = 1
    int order[2][2];
} map_case;

static place wedge(double u, double v) // -v
{
    return (place){v, u * v};
}

static place sharp_wedge(double u, double v) // -2 v^3
{
    return (place){v * v, u * v * v};
}

static place two_points(double u, double v) // u v^2
{
    return (place){u * v, u * v * v};
}

static place lune(double u, double v) // -v (1 - v)
{
    return (place){v, u * v * (1.0 - v)};
}

static place slow_edge(double u, double v) // 2 v
{
    return (place){u, v * v};
}

static place slow_corner(double u, double v) // 6 u^2 (1 - v)
{
    return (place){u * u * u, 1.0 - (1.0 - v) * (1.0 - v)};
}

static const map_case maps[] = {
    {"wedge", wedge, -1, {{KN_EDGE_CURVE, KN_EDGE_CURVE}, {KN_EDGE_POLE, KN_EDGE_CURVE}}, {{0, 0}, {1, 0}}},
    {"sharp wedge",
     sharp_wedge,
     -1,
     {{KN_EDGE_CURVE, KN_EDGE_CURVE}, {KN_EDGE_POLE, KN_EDGE_CURVE}},
     {{0, 0}, {3, 0}}},
    {"two points", two_points, 1, {{KN_EDGE_POLE, KN_EDGE_CURVE}, {KN_EDGE_POLE, KN_EDGE_CURVE}}, {{1, 0}, {2, 0}}},
    {"lune", lune, -1, {{KN_EDGE_CURVE, KN_EDGE_CURVE}, {KN_EDGE_POLE, KN_EDGE_POLE}}, {{0, 0}, {1, 1}}},
    {"slow edge", slow_edge, 1, {{KN_EDGE_CURVE, KN_EDGE_CURVE}, {KN_EDGE_CURVE, KN_EDGE_CURVE}}, {{0, 0}, {1, 0}}},
    {"slow corner",
     slow_corner,
     1,
     {{KN_EDGE_CURVE, KN_EDGE_CURVE}, {KN_EDGE_CURVE, KN_EDGE_CURVE}},
     {{2, 0}, {0, 1}}},
};

// The Bernstein coefficients of degree 3 of a cubic from its values at 0, 1/3, 2/3, 1.
static void to_bernstein(double *f, size_t step)
{
    double p = f[step], q = f[2 * step], s = f[0], t = f[3 * step];
    f[step] = (-5.0 * s + 18.0 * p - 9.0 * q + 2.0 * t) / 6.0;
    f[2 * step] = (2.0 * s - 9.0 * p + 18.0 * q - 5.0 * t) / 6.0;
}

// Rounded to multiples of 1/36, which are what these maps have: their vanishing rows are then zero, or a unit in the
// last place, as in a file.
static void make_map(kn_ctx *ctx, kn_spline *out, place (*map)(double, double))
{
    static const double knots[8] = {0, 0, 0, 0, 1, 1, 1, 1};
    const double *both[2] = {knots, knots};
    double coef[32];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            place p = map(i / 3.0, j / 3.0);
            coef[4 * i + j] = p.x, coef[16 + 4 * i + j] = p.y;
        }
    for (size_t k = 0; k < 8; k++) to_bernstein(coef + 4 * k, 1);
    for (size_t k = 0; k < 8; k++) to_bernstein(coef + k / 4 * 16 + k % 4, 4);
    for (int k = 0; k < 32; k++) coef[k] = round(coef[k] * 36.0) / 36.0;
    assert_int_equal(kn_spline_init(ctx, out, 2, 2, false, (const int[2]){3, 3}, (const int[2]){4, 4}, both, coef),
                     KN_OK);
}

static void make_paraboloid(kn_ctx *ctx, kn_spline *out, place (*map)(double, double))
{
    const double keep[6] = {1, 0, 0, 1, 0, 0}, lift[6] = {0, 0, 0, 0, a, b};
    kn_spline g = {0}, squares = {0};
    *out = (kn_spline){0};
    make_map(ctx, &g, map);
    assert_int_equal(kn_spline_product(ctx, &squares, &g, &g), KN_OK);
    assert_int_equal(kn_spline_affine(ctx, &squares, &squares, 3, lift, NULL), KN_OK);
    assert_int_equal(kn_spline_affine(ctx, out, &g, 3, keep, NULL), KN_OK);
    assert_int_equal(kn_spline_sum(ctx, out, out, &squares), KN_OK);
    kn_spline_clear(ctx, &g);
    kn_spline_clear(ctx, &squares);
}

// n at the parameters against the unit vector that is meant: within both errors of the certificate, and a little for
// evaluation in double.
static void expect_normal(kn_ctx *ctx, const kn_shell *shell, const char *name, double u, double v,
                          const double wanted[3])
{
    kn_normal_certificate c = kn_shell_certificate(shell);
    double n[3], unit[3], at[2] = {u, v}, off = 0.0;
    assert_int_equal(kn_spline_eval(ctx, n, kn_shell_normal(shell), at), KN_OK);
    assert_int_equal(kn_shell_unit_normal(ctx, unit, shell, u, v), KN_OK);
    for (int k = 0; k < 3; k++) off += (n[k] - wanted[k]) * (n[k] - wanted[k]);
    // A direction of bidegree (11,11) at most, divided up to three times: each coefficient is exact to some 100 ulps
    // of the largest, and |N| is above 1/100 of that.
    if (!(test_max_difference(unit, wanted, 3) <= 1e-11))
        fail_msg("%s: unit normal at (%g, %g) is off by %g", name, u, v, test_max_difference(unit, wanted, 3));
    if (!(sqrt(off) <= c.length_error + c.angle_error + 1e-11))
        fail_msg("%s: n at (%g, %g) is off by %g, certified %g, %g", name, u, v, sqrt(off), c.length_error,
                 c.angle_error);
}

static kn_shell *create(kn_ctx *ctx, const kn_spline *s, kn_normal_method method, const char *name)
{
    kn_shell_options o = {.normal = method, .normal_tol = 1e-5};
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s: %s", name, kn_ctx_message(ctx));
    return shell;
}

static void degenerate_maps(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t k = 0; k < 2 * sizeof maps / sizeof *maps; k++) {
        const map_case *m = &maps[k / 2];
        kn_spline s;
        kn_shell_edge edges[2][2];
        make_paraboloid(ctx, &s, m->map);
        kn_shell *shell = create(ctx, &s, methods[k % 2], m->name);
        kn_shell_edges(shell, edges);
        for (int e = 0; e < 4; e++) {
            const kn_shell_edge *edge = &edges[e / 2][e % 2];
            if (edge->kind != m->kind[e / 2][e % 2] || edge->order != m->order[e / 2][e % 2])
                fail_msg("%s: edge %d is of kind %d and order %d", m->name, e, (int)edge->kind, edge->order);
            place p = m->map(e == 1 ? 1.0 : 0.0, e == 3 ? 1.0 : 0.0);
            const double point[3] = {p.x, p.y, a * p.x * p.x + b * p.y * p.y};
            if (edge->kind == KN_EDGE_POLE) assert_true(test_max_difference(edge->point, point, 3) <= 1e-15);
        }
        for (int i = 0; i <= 12; i++)
            for (int j = 0; j <= 12; j++) {
                double u = i / 12.0, v = j / 12.0;
                place p = m->map(u, v);
                double d[3] = {-2.0 * a * p.x, -2.0 * b * p.y, 1.0}, length = sqrt(d[0] * d[0] + d[1] * d[1] + 1.0);
                for (int c = 0; c < 3; c++) d[c] *= m->sign / length;
                expect_normal(ctx, shell, m->name, u, v, d);
            }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// ---- an apex: v^k times a parabola (t, t^2, 1), a piece of a cone ----

static void make_cone(kn_ctx *ctx, kn_spline *out, int k)
{
    static const double ku[6] = {0, 0, 0, 1, 1, 1}, kv[8] = {0, 0, 0, 0, 1, 1, 1, 1};
    static const double curve[3][3] = {{0, 0, 1}, {0.5, 0, 1}, {1, 1, 1}};
    const double *knots[2] = {ku, kv + (3 - k)}; // the middle 2 (k + 1) of them
    double coef[3 * 3 * 4] = {0};
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++) coef[(c * 3 + i) * (k + 1) + k] = curve[i][c]; // v^k: the last coefficient alone
    assert_int_equal(
        kn_spline_init(ctx, out, 2, 3, false, (const int[2]){2, k}, (const int[2]){3, k + 1}, knots, coef), KN_OK);
}

// c' x c for c = (t, t^2, 1): (2t, -1, -t^2); at the apex as anywhere on the line. T opens there into the curve w n.
static void apexes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int k = 1; k <= 3; k++)
        for (int m = 0; m < 2; m++) {
            kn_spline s;
            kn_shell_edge edges[2][2];
            make_cone(ctx, &s, k);
            kn_shell *shell = create(ctx, &s, methods[m], "cone");
            kn_shell_edges(shell, edges);
            assert_int_equal(edges[1][0].kind, KN_EDGE_APEX);
            assert_int_equal(edges[1][0].order, 2 * k - 1); // v^(k-1) from S_v, v^k from S_u
            assert_true(edges[1][0].point[0] == 0.0 && edges[1][0].point[1] == 0.0 && edges[1][0].point[2] == 0.0);
            assert_true(edges[1][1].kind == KN_EDGE_CURVE && edges[1][1].order == 0);
            assert_true(edges[0][0].kind == KN_EDGE_CURVE && edges[0][1].kind == KN_EDGE_CURVE);
            for (int i = 0; i <= 10; i++)
                for (int j = 0; j <= 4; j++) {
                    double t = i / 10.0, d[3] = {2.0 * t, -1.0, -t * t}, p[3];
                    double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
                    for (int c = 0; c < 3; c++) d[c] /= length;
                    expect_normal(ctx, shell, "cone", t, j / 4.0, d);
                    if (j > 0) continue;
                    assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, t, 0.0, 0.5), KN_OK);
                    for (int c = 0; c < 3; c++) assert_true(fabs(p[c] - 0.5 * d[c]) <= 1e-5);
                }
            kn_shell_destroy(ctx, shell);
            kn_spline_clear(ctx, &s);
        }
    test_ctx_end(ctx, &memory);
}

// ---- surfaces of revolution ----

static void revolved(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double origin[3] = {1, 2, 3}, axis[3] = {0, 0, 2};
    kn_spline s = {0};
    kn_shell_edge edges[2][2];
    kn_shell_options o = {.normal_tol = 1e-3};
    kn_shell *shell = NULL;
    assert_int_equal(kn_construct_sphere(ctx, &s, origin, 2.0), KN_OK);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
    kn_shell_edges(shell, edges);
    for (int e = 0; e < 2; e++) {
        const double pole[3] = {1, 2, e == 0 ? 1 : 5};
        assert_true(edges[0][e].kind == KN_EDGE_CURVE && edges[0][e].order == 0);
        assert_true(edges[1][e].kind == KN_EDGE_POLE && edges[1][e].order == 1);
        assert_true(test_max_difference(edges[1][e].point, pole, 3) <= 1e-14);
    }
    kn_shell_destroy(ctx, shell);

    assert_int_equal(kn_construct_cone(ctx, &s, origin, axis, 1.0, 0.0), KN_OK);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
    kn_shell_edges(shell, edges);
    const double apex[3] = {1, 2, 5};
    assert_true(edges[1][0].kind == KN_EDGE_CURVE && edges[1][1].kind == KN_EDGE_APEX && edges[1][1].order == 1);
    assert_true(test_max_difference(edges[1][1].point, apex, 3) <= 1e-14);
    kn_shell_destroy(ctx, shell);

    // With a direction of its own a surface needs no normal: its collapsed edges are poles of order 0.
    const double knots[4] = {0, 0, 1, 1};
    kn_spline up = {0};
    double lo[2], hi[2], end[2][4];
    for (int v = 0; v < 2; v++) {
        kn_spline_domain(&s, v, &lo[v], &hi[v]);
        for (int i = 0; i < 4; i++) end[v][i] = knots[i] == 0.0 ? lo[v] : hi[v];
    }
    const double coef[12] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1}, *both[2] = {end[0], end[1]};
    assert_int_equal(kn_spline_init(ctx, &up, 2, 3, false, (const int[2]){1, 1}, (const int[2]){2, 2}, both, coef),
                     KN_OK);
    o.direction = &up;
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
    kn_shell_edges(shell, edges);
    assert_true(edges[1][1].kind == KN_EDGE_POLE && edges[1][1].order == 0 && edges[0][0].kind == KN_EDGE_CURVE);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &up);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// ---- no normal ----

static place squared(double u, double v) // the square of a complex number: 4 |z|^2, zero at (1/2, 1/3) alone
{
    double x = u - 0.5, y = v - 1.0 / 3.0;
    return (place){x * x - y * y, 2.0 * x * y};
}

static place parallel_corner(double u, double v) // u + v, zero at the corner alone
{
    return (place){u + v, 0.5 * (v * v - u * u)};
}

static void no_normal(void **state)
{
    (void)state;
    static const struct {
        place (*map)(double, double);
        double u, v;
    } cases[] = {{squared, 0.5, 1.0 / 3.0}, {parallel_corner, 0.0, 0.0}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int k = 0; k < 4; k++) {
        kn_spline s;
        kn_shell *shell = NULL;
        kn_shell_options o = {.normal = methods[k % 2]};
        double u = NAN, v = NAN, x = NAN, y = NAN, z = NAN;
        make_paraboloid(ctx, &s, cases[k / 2].map);
        assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_EUNDEFINED);
        assert_null(shell);
        const char *message = strstr(kn_ctx_message(ctx), "no normal at");
        assert_non_null(message);
        assert_int_equal(sscanf(message, "no normal at (%lf, %lf), at the point (%lf, %lf, %lf)", &u, &v, &x, &y, &z),
                         5);
        // N is quadratic or linear there: it drowns in its rounding, 1e-13, up to 1e-6 around the zero; six digits
        assert_true(fabs(u - cases[k / 2].u) < 1e-5 && fabs(v - cases[k / 2].v) < 1e-5);
        assert_true(fabs(x) < 1e-5 && fabs(y) < 1e-5 && fabs(z) < 1e-5);
        kn_ctx_clear_error(ctx);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// ---- edges that are nearly one point ----

// Moves the control points of the edge v = 0 by up to `noise` in each coordinate; both: those of u = 0 too, to and fro
// by as much, so that their middle stays (a factor v^2 is there with the pole in its place alone).
static void shake(test_rng *rng, kn_spline *s, bool both, double noise)
{
    size_t count = kn_spline_count(s), nv = (size_t)s->count[1];
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3 && (i % nv == 0 || (both && i < nv)); c++) {
            double by = both ? (i % 2 == 0 ? noise : -noise) : test_uniform(rng, -noise, noise);
            s->coef[c * count + i] += by * (s->rational ? s->coef[3 * count + i] : 1.0);
        }
}

// The edge of the shell's surface is one point but for the rounding of P = p W, and lies within `noise` of the
// caller's (coordinates of up to 3).
static void expect_one_point(const kn_spline *s, const kn_spline *given, double noise)
{
    size_t count = kn_spline_count(s), nv = (size_t)s->count[1];
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++) {
            double w = s->rational ? s->coef[3 * count + i] : 1.0, w0 = s->rational ? s->coef[3 * count] : 1.0;
            double x = s->coef[c * count + i] / w;
            assert_true(fabs(x - given->coef[c * count + i] / w) <= noise + 2e-15);
            if (i % nv == 0) assert_true(fabs(x - s->coef[c * count] / w0) <= 2e-15);
        }
}

// Noise that agrees to 1e-9 of the size (here 1 to 4) is taken for one point, alone or with an edge that it meets.
static void noisy_poles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(9);
    const double centre[3] = {0.5, 0, 1};
    for (int kind = 0; kind < 3; kind++)
        for (double noise = 1e-15; noise < 4e-10; noise *= 7.0) {
            kn_spline s = {0}, given = {0};
            kn_shell_edge edges[2][2];
            if (kind == 2)
                assert_int_equal(kn_construct_sphere(ctx, &s, centre, 2.0), KN_OK);
            else
                make_paraboloid(ctx, &s, kind == 0 ? wedge : two_points);
            shake(&rng, &s, kind == 1, noise);
            assert_int_equal(kn_spline_copy(ctx, &given, &s), KN_OK);
            for (int m = 0; m < 2; m++) {
                kn_shell *shell = create(ctx, &s, methods[m], "noisy");
                kn_shell_edges(shell, edges);
                assert_true(edges[1][0].kind == KN_EDGE_POLE && edges[1][0].order > 0);
                assert_int_equal(edges[0][0].kind, kind == 1 ? KN_EDGE_POLE : KN_EDGE_CURVE);
                expect_one_point(kn_shell_surface(shell), &given, 2.0 * noise);
                assert_memory_equal(s.coef, given.coef, (size_t)s.ncomp * kn_spline_count(&s) * sizeof *s.coef);
                kn_shell_destroy(ctx, shell);
            }
            kn_spline_clear(ctx, &given);
            kn_spline_clear(ctx, &s);
        }
    test_ctx_end(ctx, &memory);
}

// Beyond that nothing moves: a message says what is wrong with the edge, and an edge of 1e-3 is an edge.
static void nearly_a_pole(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(10);
    for (double noise = 1e-8; noise < 2e-7; noise *= 10.0) {
        kn_spline s = {0};
        kn_shell *shell = NULL;
        make_paraboloid(ctx, &s, wedge);
        shake(&rng, &s, false, noise);
        assert_int_not_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_OK);
        assert_null(shell);
        assert_non_null(strstr(kn_ctx_message(ctx), "the edge at the low end of v is nearly one point"));
        kn_ctx_clear_error(ctx);
        kn_spline_clear(ctx, &s);
    }
    const double knots[4] = {0, 0, 1, 1}, *both[2] = {knots, knots};
    for (double width = 1e-10; width < 2e-3; width *= 1e7) { // a trapezium: snapped, and an edge
        kn_spline s = {0};
        const double coef[12] = {0, 0, width, 1, 0, 1, 0, 1, 0, 0, 0, 0};
        kn_shell_edge edges[2][2];
        assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[2]){1, 1}, (const int[2]){2, 2}, both, coef),
                         KN_OK);
        kn_shell *shell = create(ctx, &s, KN_NORMAL_FITTED, "trapezium");
        kn_shell_edges(shell, edges);
        bool snapped = width < 1e-9;
        assert_int_equal(edges[1][0].kind, snapped ? KN_EDGE_POLE : KN_EDGE_CURVE);
        assert_true(kn_shell_surface(shell)->coef[2] == (snapped ? 0.5 * width : width));
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(degenerate_maps), cmocka_unit_test(apexes),      cmocka_unit_test(revolved),
        cmocka_unit_test(no_normal),       cmocka_unit_test(noisy_poles), cmocka_unit_test(nearly_a_pole),
    };
    return cmocka_run_group_tests_name("trivar/edges", tests, NULL, NULL);
}
