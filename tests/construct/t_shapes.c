// SPDX-License-Identifier: Apache-2.0
// Curves and surfaces from numbers.
#include <math.h>
#include <string.h>

#include <knurl/construct.h>

#include "tests/support/support.h"

static const double quarter = 0x1.921fb54442d18p+0, origin[3] = {0, 0, 0};
static const double ex[3] = {1, 0, 0}, ey[3] = {0, 1, 0}, ez[3] = {0, 0, 1};

static double gamma_of(double n)
{
    return n * 0x1p-53 / (1.0 - n * 0x1p-53);
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double *a, const double *b)
{
    for (int c = 0; c < 3; c++) out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static void lines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double a[] = {1, 2, 3, 4}, b[] = {-1, 5, 0, 7}, line_knots[] = {0, 0, 1, 1};
    assert_int_equal(kn_construct_line(ctx, &s, 4, a, b), KN_OK);
    assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
    assert_memory_equal(s.knots[0], line_knots, sizeof line_knots);
    for (int c = 0; c < 4; c++) assert_true(s.coef[2 * c] == a[c] && s.coef[2 * c + 1] == b[c]);
    const double points[] = {0, 1, 2, 5, 7, 7, 3, 3, 9, 0}, knots[] = {0, 0, 0.25, 0.5, 0.75, 1, 1};
    assert_int_equal(kn_construct_polyline(ctx, &s, 2, 5, points), KN_OK);
    assert_memory_equal(s.knots[0], knots, sizeof knots);
    for (int i = 0; i < 10; i++) assert_true(s.coef[i % 2 * 5 + i / 2] == points[i]);
    const double bad[] = {0, NAN};
    assert_int_equal(kn_construct_line(ctx, &s, 0, a, b), KN_EDOMAIN);
    assert_int_equal(kn_construct_line(ctx, &s, KN_MAX_COMPS + 1, a, b), KN_ELIMIT);
    assert_int_equal(kn_construct_line(ctx, &s, 1, &bad[0], &bad[1]), KN_EDOMAIN);
    assert_int_equal(kn_construct_polyline(ctx, &s, 2, 1, points), KN_EDOMAIN);
    assert_int_equal(kn_construct_polyline(ctx, &s, 0, 3, points), KN_EDOMAIN);
    assert_int_equal(kn_construct_polyline(ctx, &s, KN_MAX_COMPS + 1, 3, points), KN_ELIMIT);
    assert_int_equal(s.count[0], 5); // as it was
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Sum of sign_c (component c)^2 of each piece; the largest coefficient. Four products of pieces with coefficients up to
// `size`, T terms: gamma(T + 3 nvars + 4) 4 size^2 of it is rounding of this computation.
static double largest_of_form(kn_ctx *ctx, const kn_spline *s, const double *factor)
{
    kn_bezier *piece = NULL, c = {0}, square = {0}, sum = {0};
    size_t n = 0;
    double largest = 0.0;
    assert_int_equal(kn_spline_to_bezier(ctx, &piece, &n, s), KN_OK);
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 4; k++) {
            assert_int_equal(kn_bezier_components(ctx, &c, &piece[i], k, 1), KN_OK);
            assert_int_equal(kn_bezier_product(ctx, &square, &c, &c), KN_OK);
            assert_int_equal(kn_bezier_scale(ctx, &square, &square, factor[k]), KN_OK);
            if (k == 0)
                assert_int_equal(kn_bezier_copy(ctx, &sum, &square), KN_OK);
            else
                assert_int_equal(kn_bezier_sum(ctx, &sum, &sum, &square), KN_OK);
        }
        for (size_t k = 0; k < kn_bezier_count(&sum); k++) largest = fmax(largest, fabs(sum.coef[k]));
        kn_bezier_clear(ctx, &piece[i]);
    }
    kn_free(ctx, piece);
    kn_bezier_clear(ctx, &c);
    kn_bezier_clear(ctx, &square);
    kn_bezier_clear(ctx, &sum);
    return largest;
}

// x^2 + y^2 = r^2 w^2 holds for exact cos, sin and cos h. Those that are stored have 2 u each, x and y a rounding more by
// r: 2 (3 u + 3 u + 2 u) r^2 = 16 u r^2, and the products that check it gamma(3 + 3 + 4) 3 r^2.
static void arcs_lie_on_circles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    kn_spline s = {0};
    for (int round = test_scale(100); round > 0; round--) {
        double r = exp(test_uniform(&rng, -3, 3)), x[3] = {r, 0, 0}, y[3] = {0, r, 0}, at = 1.0, end[3];
        double angle = round <= 4 ? round * quarter : test_uniform(&rng, 1e-3, 4 * quarter);
        assert_int_equal(kn_construct_arc(ctx, &s, origin, x, y, angle), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        assert_int_equal(kn_spline_spans(&s, 0), (int)ceil(angle / quarter * (1 - 1e-15)));
        const double form[] = {1, 1, 0, -r * r};
        assert_true(largest_of_form(ctx, &s, form) <= (16 * 0x1p-53 + 3 * gamma_of(10) + gamma_of(2)) * r * r);
        int n = s.count[0];
        assert_true(s.coef[0] == r && s.coef[n] == 0.0 && s.coef[3 * n] == 1.0);
        assert_int_equal(kn_spline_eval(ctx, end, &s, &at), KN_OK);
        assert_true(fabs(end[0] - r * cos(angle)) <= gamma_of(8) * r);
        assert_true(fabs(end[1] - r * sin(angle)) <= gamma_of(8) * r);
        for (int i = 0; i < 4 && round == 4; i++) assert_true(s.coef[i * n] == s.coef[i * n + n - 1]);
        if (round == 1) assert_true(s.coef[n - 1] == 0.0 && s.coef[2 * n - 1] == r); // an exact quarter
        // Counterclockwise: the polar angle grows with the parameter.
        double before = 0.0;
        for (int i = 1; i < 20; i++) {
            double t = i / 20.0, p[3];
            assert_int_equal(kn_spline_eval(ctx, p, &s, &t), KN_OK);
            double polar = atan2(p[1], p[0]);
            if (polar < 0.0) polar += 4 * quarter;
            assert_true(polar > before && polar < angle);
            before = polar;
        }
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Affine images: the ellipse's control points are those of the unit circle, mapped.
static void ellipses(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline unit = {0}, s = {0};
    const double center[3] = {3, -2, 5}, x[3] = {2, 1, 0}, y[3] = {-1, 4, 2}, slant[3] = {2, -1, 2};
    assert_int_equal(kn_construct_ellipse(ctx, &unit, origin, ex, ey), KN_OK);
    assert_int_equal(kn_construct_ellipse(ctx, &s, center, x, y), KN_OK);
    for (int i = 0; i < 9; i++)
        for (int c = 0; c < 3; c++)
            assert_true(fabs(s.coef[c * 9 + i] - (unit.coef[27 + i] * center[c] + unit.coef[i] * x[c] +
                                                  unit.coef[9 + i] * y[c])) <= gamma_of(8) * 16);
    // A circle across a slanted normal: its points keep distance and plane, and it runs counterclockwise.
    const double radius = 3, p0 = 0.0, p1 = 0.1;
    double a[3], b[3], turn[3];
    assert_int_equal(kn_construct_circle(ctx, &s, center, slant, radius), KN_OK);
    for (int i = 0; i <= 50; i++) {
        double t = i / 50.0, p[3];
        assert_int_equal(kn_spline_eval(ctx, p, &s, &t), KN_OK);
        for (int c = 0; c < 3; c++) p[c] -= center[c];
        // 13 roundings in the basis, twice; coefficients with 10; numbers up to 8, weights at least 1/2.
        assert_true(fabs(sqrt(dot(p, p)) - radius) <= gamma_of(50) * 16);
        assert_true(fabs(dot(p, slant)) <= gamma_of(50) * 16 * 5);
    }
    assert_int_equal(kn_spline_eval(ctx, a, &s, &p0), KN_OK);
    assert_int_equal(kn_spline_eval(ctx, b, &s, &p1), KN_OK);
    for (int c = 0; c < 3; c++) a[c] -= center[c], b[c] -= center[c];
    cross(turn, a, b);
    assert_true(dot(turn, slant) > 0.0);
    kn_spline_clear(ctx, &unit);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void curve_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double bad[3] = {0, INFINITY, 0}, twice[3] = {-2, 0, 0};
    const double angles[] = {0, -1, 4 * quarter + 1e-9, NAN};
    for (int i = 0; i < 4; i++) assert_int_equal(kn_construct_arc(ctx, &s, origin, ex, ey, angles[i]), KN_EDOMAIN);
    assert_int_equal(kn_construct_arc(ctx, &s, bad, ex, ey, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_arc(ctx, &s, origin, bad, ey, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_arc(ctx, &s, origin, ex, bad, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_arc(ctx, &s, origin, ex, twice, 1), KN_EUNDEFINED);
    assert_int_equal(kn_construct_arc(ctx, &s, origin, ex, origin, 1), KN_EUNDEFINED);
    assert_int_equal(kn_construct_ellipse(ctx, &s, origin, origin, ex), KN_EUNDEFINED);
    assert_int_equal(kn_construct_circle(ctx, &s, origin, ez, 0), KN_EDOMAIN);
    assert_int_equal(kn_construct_circle(ctx, &s, origin, ez, NAN), KN_EDOMAIN);
    assert_int_equal(kn_construct_circle(ctx, &s, origin, origin, 1), KN_EUNDEFINED);
    assert_int_equal(kn_construct_circle(ctx, &s, origin, bad, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_circle(ctx, &s, bad, ez, 1), KN_EDOMAIN);
    assert_int_equal(s.nvars, 0);
    test_ctx_end(ctx, &memory);
}

// ---- surfaces ----

// x^2 + y^2 + z^2 = r^2 w^2: coefficients of x, y, z are products of two of the numbers of an arc and r, 2 + 2 u each and
// five roundings; 2 (9 + 9 + 9 + 5) u r^2, and the products that check it gamma(9 + 6 + 4) 4 r^2.
static void sphere_is_a_sphere(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    for (double r = 0.1; r < 100; r *= 3.7) {
        assert_int_equal(kn_construct_sphere(ctx, &s, origin, r), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        const double form[] = {1, 1, 1, -r * r};
        assert_true(largest_of_form(ctx, &s, form) <= (64 * 0x1p-53 + 4 * gamma_of(19) + gamma_of(2)) * r * r);
        for (int j = 0; j < 5; j++)
            for (int c = 0; c < 4; c++) // closed, and the poles are at (0, 0, -+r)
                assert_true(s.coef[c * 45 + j] == s.coef[c * 45 + 40 + j]);
        for (int i = 0; i < 9; i++)
            for (int end = 0; end < 2; end++) {
                double w = s.coef[135 + i * 5 + 4 * end];
                assert_true(s.coef[i * 5 + 4 * end] == 0.0 && s.coef[45 + i * 5 + 4 * end] == 0.0);
                assert_true(fabs(s.coef[90 + i * 5 + 4 * end] - (end ? r : -r) * w) <= gamma_of(1) * r);
            }
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef struct solid {
    double center[3], axis[3]; // axis of length 1
    double radius[2];          // cone: at base and top; torus: major, minor; sphere: radius
    double height;             // 0: torus; negative: sphere
} solid;

// The signed distance from the surface's own equation, and the outward direction.
static double off_surface(double out[3], const solid *b, const double p[3])
{
    double q[3], across[3], rho = 0.0, z;
    for (int c = 0; c < 3; c++) q[c] = p[c] - b->center[c];
    z = dot(q, b->axis);
    for (int c = 0; c < 3; c++) across[c] = q[c] - z * b->axis[c], rho += across[c] * across[c];
    rho = sqrt(rho);
    if (b->height < 0.0) {
        memcpy(out, q, 3 * sizeof *out);
        return sqrt(dot(q, q)) - b->radius[0];
    }
    for (int c = 0; c < 3; c++) across[c] /= rho;
    if (b->height == 0.0) {
        for (int c = 0; c < 3; c++) out[c] = q[c] - b->radius[0] * across[c];
        return sqrt(dot(out, out)) - b->radius[1];
    }
    double slope = (b->radius[1] - b->radius[0]) / b->height;
    for (int c = 0; c < 3; c++) out[c] = across[c] - slope * b->axis[c];
    return rho - (b->radius[0] + slope * z);
}

// Points within rounding of the equation: 14 + 14 roundings of the basis twice, coefficients with 10 + 4, and 20 of the
// equation, sizes up to |center| + radii + height over weights that are at least 1/2.
static void assert_solid(kn_ctx *ctx, const kn_spline *s, const solid *b)
{
    double size = sqrt(dot(b->center, b->center)) + b->radius[0] + b->radius[1] + fabs(b->height);
    assert_int_equal(kn_spline_check(ctx, s), KN_OK);
    for (int i = 0; i < 24; i++)
        for (int j = 0; j < 12; j++) {
            double at[2] = {i / 24.0 + 0.01, j / 12.0 + 0.03}, d[9], outward[3], normal[3];
            assert_int_equal(kn_spline_derivatives(ctx, d, s, at, 1), KN_OK);
            assert_true(fabs(off_surface(outward, b, d)) <= 4.0 * gamma_of(2 * 28 + 1 + 14 + 20) * size);
            cross(normal, d + 3, d + 6);
            assert_true(dot(normal, outward) > 0.0);
            // S_u lies across outward: derivatives are sums of as many terms, of numbers up to 8 times the size.
            assert_true(fabs(dot(d + 3, outward)) <= 8.0 * 4.0 * gamma_of(4 * 28 + 40) * size * size);
            double turn[3];
            double from[3] = {d[0] - b->center[0], d[1] - b->center[1], d[2] - b->center[2]};
            cross(turn, b->axis, from);
            assert_true(dot(turn, d + 3) > 0.0); // counterclockwise
        }
}

static void surfaces_keep_their_equations(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    kn_spline s = {0};
    for (int round = test_scale(5); round > 0; round--) {
        solid b = {.center = {test_int(&rng, -9, 9), test_int(&rng, -9, 9), test_int(&rng, -9, 9)}};
        double v[3], length = 0.0;
        for (int c = 0; c < 3; c++) v[c] = test_uniform(&rng, -1, 1), length += v[c] * v[c];
        if (round == 5) v[0] = v[1] = 0.0, length = v[2] * v[2];
        length = sqrt(length);
        for (int c = 0; c < 3; c++) b.axis[c] = v[c] / length;
        b.radius[0] = test_uniform(&rng, 2, 5), b.radius[1] = test_uniform(&rng, 0.1, 1.9);
        assert_int_equal(kn_construct_torus(ctx, &s, b.center, v, b.radius[0], b.radius[1]), KN_OK);
        assert_solid(ctx, &s, &b);
        b.height = length;
        assert_int_equal(kn_construct_cone(ctx, &s, b.center, v, b.radius[0], b.radius[1]), KN_OK);
        assert_solid(ctx, &s, &b);
        b.radius[1] = 0.0;
        assert_int_equal(kn_construct_cone(ctx, &s, b.center, v, b.radius[0], b.radius[1]), KN_OK);
        assert_solid(ctx, &s, &b);
        b.radius[1] = b.radius[0];
        assert_int_equal(kn_construct_cylinder(ctx, &s, b.center, v, b.radius[0]), KN_OK);
        assert_solid(ctx, &s, &b);
        for (int c = 0; c < 4; c++)
            for (int j = 0; j < 2; j++) assert_true(s.coef[c * 18 + j] == s.coef[c * 18 + 16 + j]);
        b.height = -1.0, memcpy(b.axis, ez, sizeof ez);
        assert_int_equal(kn_construct_sphere(ctx, &s, b.center, b.radius[0]), KN_OK);
        assert_solid(ctx, &s, &b);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void surface_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double bad[3] = {0, 0, NAN};
    const double radii[] = {0, -1, NAN, INFINITY};
    for (int i = 0; i < 4; i++) {
        assert_int_equal(kn_construct_sphere(ctx, &s, origin, radii[i]), KN_EDOMAIN);
        assert_int_equal(kn_construct_cylinder(ctx, &s, origin, ez, radii[i]), KN_EDOMAIN);
        assert_int_equal(kn_construct_torus(ctx, &s, origin, ez, 2, radii[i]), KN_EDOMAIN);
        if (i > 0) assert_int_equal(kn_construct_cone(ctx, &s, origin, ez, radii[i], 1), KN_EDOMAIN);
        if (i > 0) assert_int_equal(kn_construct_cone(ctx, &s, origin, ez, 1, radii[i]), KN_EDOMAIN);
    }
    assert_int_equal(kn_construct_cone(ctx, &s, origin, ez, 0, 0), KN_EDOMAIN);
    assert_int_equal(kn_construct_torus(ctx, &s, origin, ez, 1, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_torus(ctx, &s, origin, origin, 2, 1), KN_EUNDEFINED);
    assert_int_equal(kn_construct_cylinder(ctx, &s, origin, origin, 1), KN_EUNDEFINED);
    assert_int_equal(kn_construct_cylinder(ctx, &s, bad, ez, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_cylinder(ctx, &s, origin, bad, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_torus(ctx, &s, bad, ez, 2, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_sphere(ctx, &s, bad, 1), KN_EDOMAIN);
    assert_int_equal(s.nvars, 0);
    test_ctx_end(ctx, &memory);
}

static kn_status make(kn_ctx *ctx, kn_spline *s, int which)
{
    switch (which) {
    case 0: return kn_construct_line(ctx, s, 3, ex, ey);
    case 1: return kn_construct_circle(ctx, s, origin, ez, 2);
    case 2: return kn_construct_sphere(ctx, s, ex, 2);
    case 3: return kn_construct_torus(ctx, s, ex, ey, 2, 1);
    default: return kn_construct_cylinder(ctx, s, ex, ey, 2);
    }
}

static kn_status once(kn_ctx *ctx, void *user)
{
    kn_spline s = {0};
    kn_status status = make(ctx, &s, *(int *)user);
    if (status != KN_OK) assert_true(s.nvars == 0 && !s.coef);
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    for (int which = 0; which < 5; which++) test_allocation_failures(once, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lines),
                                       cmocka_unit_test(arcs_lie_on_circles),
                                       cmocka_unit_test(ellipses),
                                       cmocka_unit_test(curve_failures),
                                       cmocka_unit_test(sphere_is_a_sphere),
                                       cmocka_unit_test(surfaces_keep_their_equations),
                                       cmocka_unit_test(surface_failures),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("construct/shapes", tests, NULL, NULL);
}
