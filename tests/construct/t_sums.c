// SPDX-License-Identifier: Apache-2.0
// Sweeps and Boolean sums.
#include <math.h>
#include <string.h>

#include <knurl/construct.h>
#include <knurl/fit.h>

#include "tests/support/support.h"

static double gamma_of(double n)
{
    return n * 0x1p-53 / (1.0 - n * 0x1p-53);
}

static kn_spline operand(kn_ctx *ctx, test_rng *rng, int nvars, int dim, bool rational)
{
    int degree[3] = {0}, count[3] = {0};
    kn_spline s;
    for (int d = 0; d < nvars; d++) degree[d] = test_int(rng, 1, 3), count[d] = degree[d] + 1 + test_int(rng, 0, 3);
    test_random_spline(ctx, &s, rng, nvars, dim + rational, rational, degree, count, 9);
    for (int d = 0; d < nvars; d++) assert_int_equal(kn_spline_reparameterize(ctx, &s, &s, d, 0, 1), KN_OK);
    return s;
}

// ---- sweeps ----

// The value is the sum of the values. Roundings: at most 19 for each of four variables, twice with the division, 3 in
// coefficients; homogeneous numbers up to 2 * 81 over weights >= 1.
static void swept(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(40); round > 0; round--) {
        int np = test_int(&rng, 1, 2), nt = test_int(&rng, 1, 2);
        kn_spline p = operand(ctx, &rng, np, 3, round % 2), t = operand(ctx, &rng, nt, 3, round % 3 == 0), s = {0};
        assert_int_equal(kn_construct_swept(ctx, &s, &p, &t), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        assert_true(s.rational == (p.rational || t.rational));
        for (int d = 0; d < np + nt; d++) {
            const kn_spline *from = d < np ? &p : &t;
            int e = d < np ? d : d - np;
            assert_int_equal(s.degree[d], from->degree[e]);
            assert_memory_equal(s.knots[d], from->knots[e],
                                (size_t)(from->count[e] + from->degree[e] + 1) * sizeof(double));
        }
        for (int i = 0; i < 20; i++) {
            double at[4], a[3], b[3], value[3];
            for (int d = 0; d < 4; d++) at[d] = test_uniform(&rng, 0, 1);
            assert_int_equal(kn_spline_eval(ctx, a, &p, at), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, b, &t, at + np), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, value, &s, at), KN_OK);
            for (int c = 0; c < 3; c++)
                assert_true(fabs(value[c] - (a[c] + b[c])) <= 2.0 * gamma_of(2 * 4 * 19 + 4) * 162);
        }
        if (!s.rational) // integers: exact sums of control points
            for (size_t c = 0, n = kn_spline_count(&p), m = kn_spline_count(&t); c < 3; c++)
                for (size_t i = 0; i < n * m; i++)
                    assert_true(s.coef[c * n * m + i] == p.coef[c * n + i / m] + t.coef[c * m + i % m]);
        kn_spline_clear(ctx, &p);
        kn_spline_clear(ctx, &t);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Where the frame was sampled, at 0.3 and 0.75 of each of its spans, the surface keeps the estimate; which in turn keeps
// the tolerance. exact(u, v) comes from the closed form.
typedef void (*closed_form)(double out[3], const double at[2]);

static void assert_frame(kn_ctx *ctx, const kn_spline *s, double estimate, closed_form exact, double size)
{
    assert_int_equal(kn_spline_check(ctx, s), KN_OK);
    for (int i = s->degree[1]; i < s->count[1]; i++)
        for (int k = 0; k < 12; k++) {
            double lo = s->knots[1][i], hi = s->knots[1][i + 1], p[3], q[3], square = 0.0;
            double at[2] = {(k / 2) / 5.0, lo + (k % 2 ? 0.75 : 0.3) * (hi - lo)};
            if (lo == hi) continue;
            assert_int_equal(kn_spline_eval(ctx, p, s, at), KN_OK);
            exact(q, at);
            for (int c = 0; c < 3; c++) square += (p[c] - q[c]) * (p[c] - q[c]);
            assert_true(sqrt(square) <= estimate + gamma_of(500) * size);
        }
}

// A segment in (n, b) along a quarter circle of radius 5, t = (-sin, cos, 0), b = z: n = b x t = (-cos, -sin, 0).
static void along_a_quarter(double out[3], const double at[2])
{
    const double arc[3] = {1, sqrt(0.5), 1}; // the parameter of the rational quarter
    double v = at[1], b[3] = {(1 - v) * (1 - v), 2 * v * (1 - v), v * v};
    double w = b[0] + b[1] * arc[1] + b[2], c = (b[0] + b[1] * arc[1]) / w, s = (b[1] * arc[1] + b[2]) / w;
    double n = 1.0 - at[0], up = 2.0 * at[0];
    out[0] = (5.0 - n) * c, out[1] = (5.0 - n) * s, out[2] = up;
}

// A parabola (v, v^2, 0) with the point (0, 0, 1) to (1, 0, 1) in (n, b, t): t = (1, 2 v) / sqrt(1 + 4 v^2).
static void along_a_parabola(double out[3], const double at[2])
{
    double v = at[1], r = sqrt(1.0 + 4.0 * v * v);
    out[0] = v + (1.0 - at[0] * 2.0 * v) / r;
    out[1] = v * v + (2.0 * v + at[0]) / r;
    out[2] = 0.0;
}

static void swept_frame(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double none[3] = {0}, x[3] = {5, 0, 0}, y[3] = {0, 5, 0}, up[3] = {0, 0, 2}, down[3] = {0, 0, -1};
    kn_spline p = {0}, t = {0}, s = {0};
    double estimate;
    assert_int_equal(kn_construct_line(ctx, &p, 3, (double[]){1, 0, 0}, (double[]){0, 2, 0}), KN_OK);
    assert_int_equal(kn_construct_arc(ctx, &t, none, x, y, 0x1.921fb54442d18p+0), KN_OK);
    for (double tolerance = 1e-2; tolerance > 1e-9; tolerance *= 1e-3) {
        assert_int_equal(kn_construct_swept_frame(ctx, &s, &estimate, &p, &t, up, tolerance), KN_OK);
        assert_true(estimate <= tolerance);
        assert_frame(ctx, &s, estimate, along_a_quarter, 20);
        assert_int_equal(s.degree[1], 5);
    }
    assert_int_equal(kn_construct_line(ctx, &p, 3, (double[]){0, 0, 1}, (double[]){1, 0, 1}), KN_OK);
    const double knots[] = {0, 0, 0, 1, 1, 1}, parabola[] = {0, 0.5, 1, 0, 0, 1, 0, 0, 0};
    kn_spline_clear(ctx, &t);
    assert_int_equal(
        kn_spline_init(ctx, &t, 1, 3, false, (int[]){2}, (int[]){3}, (const double *[]){knots}, parabola), KN_OK);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &estimate, &p, &t, down, 1e-6), KN_OK);
    assert_true(estimate <= 1e-6 && !s.rational);
    kn_spline_clear(ctx, &s);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &estimate, &p, &t, up, 1e-6), KN_OK);
    for (int i = 3; i < s.count[1]; i++) { // n = b x t = (-2 v, 1) / r for b = z
        double at[2] = {0.5, s.knots[1][i] + 0.3 * (s.knots[1][i + 1] - s.knots[1][i])}, a[3], b[3];
        assert_int_equal(kn_spline_eval(ctx, a, &s, at), KN_OK);
        along_a_parabola(b, at);
        for (int c = 0; c < 3; c++) assert_true(fabs(a[c] - b[c]) <= estimate + gamma_of(500) * 4);
    }
    // Along a straight line the frame is constant: one span, and no error beyond rounding.
    kn_spline_clear(ctx, &t);
    assert_int_equal(kn_construct_line(ctx, &t, 3, none, x), KN_OK);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &estimate, &p, &t, up, 1e-9), KN_OK);
    size_t n = kn_spline_count(&s) * 3; // only the direction of up counts: the same bits for any length
    double *same = test_malloc(n * sizeof *same);
    memcpy(same, s.coef, n * sizeof *same);
    for (int power = -1000; power <= 1000; power += 400) {
        const double length = ldexp(1.0, power), scaled[3] = {up[0] * length, up[1] * length, up[2] * length};
        assert_int_equal(kn_construct_swept_frame(ctx, &s, &estimate, &p, &t, scaled, 1e-9), KN_OK);
        assert_memory_equal(s.coef, same, n * sizeof *same);
    }
    test_free(same);
    assert_true(estimate <= gamma_of(100) * 8);
    assert_int_equal(kn_spline_spans(&s, 1), 1);
    kn_spline_clear(ctx, &p);
    kn_spline_clear(ctx, &t);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void sweep_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    kn_spline p = {0}, line = {0}, still = {0}, corner = {0}, s = {0}, empty = {0};
    kn_spline flat = operand(ctx, &rng, 1, 2, false), surface = operand(ctx, &rng, 2, 3, false);
    const double a[3] = {0}, b[3] = {0, 0, 4}, up[3] = {0, 0, 1}, x[3] = {1, 0, 0}, bad[3] = {NAN, 0, 0};
    const double bend[] = {0, 0, 0, 1, 0, 0, 1, 1, 0};
    double e = -1.0;
    assert_int_equal(kn_construct_line(ctx, &p, 3, a, x), KN_OK);
    assert_int_equal(kn_construct_line(ctx, &line, 3, a, b), KN_OK);
    assert_int_equal(kn_construct_line(ctx, &still, 3, a, a), KN_OK);
    assert_int_equal(kn_construct_polyline(ctx, &corner, 3, 3, bend), KN_OK);
    assert_int_equal(kn_construct_swept(ctx, &s, &p, &flat), KN_EDOMAIN);
    assert_int_equal(kn_construct_swept(ctx, &s, &empty, &p), KN_EDOMAIN);
    assert_int_equal(kn_construct_swept(ctx, &s, &p, &empty), KN_EDOMAIN);
    const kn_spline *const bad_profiles[] = {&empty, &flat}, *const bad_trajectories[] = {&empty, &flat, &surface};
    for (int i = 0; i < 2; i++)
        assert_int_equal(kn_construct_swept_frame(ctx, &s, &e, bad_profiles[i], &line, x, 1), KN_EDOMAIN);
    for (int i = 0; i < 3; i++)
        assert_int_equal(kn_construct_swept_frame(ctx, &s, &e, &p, bad_trajectories[i], x, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &e, &p, &line, x, 0), KN_EDOMAIN);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &e, &p, &line, bad, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &e, &p, &line, up, 1), KN_EUNDEFINED);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &e, &p, &still, up, 1), KN_EUNDEFINED);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &e, &p, &corner, up, 1e-3), KN_EUNDECIDED);
    assert_int_equal(kn_ctx_error(ctx), KN_EUNDECIDED);
    kn_spline light;
    const double w[] = {0, 1, 0, 0, 0, 0, 1, 0};
    assert_int_equal(kn_spline_init(ctx, &light, 1, 4, true, p.degree, p.count, (const double *const *)p.knots, w),
                     KN_OK);
    assert_int_equal(kn_construct_swept_frame(ctx, &s, &e, &light, &corner, up, 1), KN_EDOMAIN);
    assert_true(s.nvars == 0 && e == -1.0);
    int degree[KN_MAX_VARS], count[KN_MAX_VARS];
    for (int d = 0; d < KN_MAX_VARS; d++) degree[d] = 1, count[d] = 2;
    kn_spline full;
    test_random_spline(ctx, &full, &rng, KN_MAX_VARS, 3, false, degree, count, 9);
    assert_int_equal(kn_construct_swept(ctx, &s, &full, &line), KN_ELIMIT);
    kn_spline *const all[] = {&p, &line, &still, &corner, &flat, &surface, &light, &full};
    for (int i = 0; i < 8; i++) kn_spline_clear(ctx, all[i]);
    test_ctx_end(ctx, &memory);
}

// ---- Boolean sums ----

// Four segments make the bilinear surface, exactly.
static void coons_of_segments(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double corner[2][2][3] = {{{0, 0, 1}, {0, 4, -2}}, {{5, 1, 0}, {6, 3, 8}}}; // [u][v]
    kn_spline face[4] = {{0}}, s = {0};
    const kn_spline *const faces[] = {&face[0], &face[1], &face[2], &face[3]};
    for (int e = 0; e < 2; e++) {
        assert_int_equal(kn_construct_line(ctx, &face[e], 3, corner[e][0], corner[e][1]), KN_OK);
        assert_int_equal(kn_construct_line(ctx, &face[2 + e], 3, corner[0][e], corner[1][e]), KN_OK);
    }
    const double middle[] = {0.5, 0.5};
    double value[3];
    for (int d = 0; d < 2; d++) // degree 2 in both variables, so that there is an inner control point
        for (int e = 0; e < 2; e++)
            assert_int_equal(kn_spline_elevate(ctx, &face[2 * d + e], &face[2 * d + e], (int[]){2}), KN_OK);
    assert_int_equal(kn_construct_coons(ctx, &s, 2, faces, 0.0), KN_OK);
    assert_int_equal(s.count[0] * s.count[1], 9);
    assert_int_equal(kn_spline_eval(ctx, value, &s, middle), KN_OK);
    for (int c = 0; c < 3; c++)
        assert_true(value[c] == (corner[0][0][c] + corner[0][1][c] + corner[1][0][c] + corner[1][1][c]) / 4);
    for (int i = 0; i < 4; i++) kn_spline_clear(ctx, &face[i]);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// One curve between two points, with random control points inside.
static kn_spline between(kn_ctx *ctx, test_rng *rng, const double *a, const double *b, bool rational)
{
    kn_spline s = operand(ctx, rng, 1, 3, rational);
    for (int c = 0; c < 3 + rational; c++) {
        s.coef[c * s.count[0]] = c < 3 ? a[c] : 1.0;
        s.coef[(c + 1) * s.count[0] - 1] = c < 3 ? b[c] : 1.0;
    }
    return s;
}

// Boundaries are the curves bit for bit, as made compatible pair by pair; inside the homogeneous value is
// P1 + P2 - P12 of the curves' values: sizes up to 5 * 9, roundings as for the sums above.
static void coons_of_curves(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int round = test_scale(40); round > 0; round--) {
        double corner[4][3]; // 2 u + v
        bool rational = round % 4 == 0;
        for (int i = 0; i < 12; i++) corner[i / 3][i % 3] = test_int(&rng, -9, 9);
        kn_spline face[4], s = {0};
        const kn_spline *const faces[] = {&face[0], &face[1], &face[2], &face[3]};
        for (int e = 0; e < 2; e++) {
            face[e] = between(ctx, &rng, corner[2 * e], corner[2 * e + 1], rational && e == 0);
            face[2 + e] = between(ctx, &rng, corner[e], corner[2 + e], false);
        }
        if (rational) // heavier middles keep all weights positive
            for (int i = 1; i < face[0].count[0] - 1; i++) face[0].coef[3 * face[0].count[0] + i] = 2.0;
        assert_int_equal(kn_construct_coons(ctx, &s, 2, faces, 0.0), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        for (int i = 0; i < 50; i++) {
            double at[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, h[4][4], value[4];
            kn_spline flat = s;
            flat.rational = false; // homogeneous values
            assert_int_equal(kn_spline_eval(ctx, value, &flat, at), KN_OK);
            for (int f = 0; f < 4; f++) {
                kn_spline curve = face[f];
                curve.rational = false, h[f][3] = 1.0;
                assert_int_equal(kn_spline_eval(ctx, h[f], &curve, &at[f < 2]), KN_OK);
            }
            double u = at[0], v = at[1];
            for (int c = 0; c < 3 + rational; c++) {
                double p12 = 1.0;
                if (c < 3)
                    p12 = (1 - u) * ((1 - v) * corner[0][c] + v * corner[1][c]) +
                          u * ((1 - v) * corner[2][c] + v * corner[3][c]);
                double expected = (1 - u) * h[0][c] + u * h[1][c] + (1 - v) * h[2][c] + v * h[3][c] - p12;
                assert_true(fabs(value[c] - expected) <= gamma_of(200) * 90);
            }
        }
        kn_spline pair[2][2];
        for (int f = 0; f < 4; f++)
            assert_int_equal(kn_spline_copy(ctx, memset(&pair[f / 2][f % 2], 0, sizeof(kn_spline)), &face[f]), KN_OK);
        for (int d = 0; d < 2; d++) assert_int_equal(kn_spline_make_compatible(ctx, pair[d], 2), KN_OK);
        size_t m = (size_t)s.count[0], n = (size_t)s.count[1];
        for (size_t c = 0; c < 3 && !rational; c++)
            for (size_t e = 0; e < 2; e++) {
                for (size_t j = 0; j < n; j++)
                    assert_true(s.coef[(c * m + e * (m - 1)) * n + j] == pair[0][e].coef[c * n + j]);
                for (size_t i = 0; i < m; i++)
                    assert_true(s.coef[(c * m + i) * n + e * (n - 1)] == pair[1][e].coef[c * m + i]);
            }
        for (int f = 0; f < 4; f++) kn_spline_clear(ctx, &face[f]), kn_spline_clear(ctx, &pair[f / 2][f % 2]);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// A function each of whose terms is linear in some variable, u^2 v + v^2 w + w^2 u and others like it, is the Boolean sum
// of its own faces: (1 - P_d) removes the term that is linear in variable d. All numbers are dyadic: exact.
static void coons_volume(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double values[27 * 2];
    const double knots[] = {0, 0, 0, 1, 1, 1}, sites[] = {0, 0.5, 1};
    for (int i = 0; i < 27; i++) {
        double u = i / 9 * 0.5, v = i / 3 % 3 * 0.5, w = i % 3 * 0.5;
        values[2 * i] = u * u * v + v * v * w + w * w * u;
        values[2 * i + 1] = 3 * u * u * w * w - 2 * v * v * u * u + v + 5;
    }
    kn_spline volume = {0}, face[6] = {{0}}, s = {0};
    const kn_spline *faces[6];
    const double *const k[] = {knots, knots, knots}, *const x[] = {sites, sites, sites};
    assert_int_equal(kn_fit_interpolate(ctx, &volume, 3, 2, (int[]){2, 2, 2}, (int[]){3, 3, 3}, k, x, values), KN_OK);
    for (int f = 0; f < 6; f++) {
        faces[f] = &face[f];
        double slice[18];
        for (int n = 0; n < 18; n++) { // the control points at the end f % 2 of variable f / 2
            int r = n % 9 / 3, q = n % 3, end = 2 * (f % 2);
            int at = f / 2 == 0 ? 9 * end + 3 * r + q : f / 2 == 1 ? 9 * r + 3 * end + q : 9 * r + 3 * q + end;
            slice[n] = volume.coef[n / 9 * 27 + at];
        }
        assert_int_equal(kn_spline_init(ctx, &face[f], 2, 2, false, (int[]){2, 2}, (int[]){3, 3}, k, slice), KN_OK);
    }
    assert_int_equal(kn_construct_coons(ctx, &s, 3, faces, 0.0), KN_OK);
    assert_int_equal(kn_spline_count(&s), 27);
    for (int i = 0; i < 54; i++) assert_true(s.coef[i] == volume.coef[i]);
    // A corner of one face moved: the message says which faces do not meet; a tolerance lets it pass, the lower wins.
    face[4].coef[0] += 0x1p-20;
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_construct_coons(ctx, &s, 3, faces, 0x1p-21), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "faces 0 and 4 do not meet"));
    assert_int_equal(kn_construct_coons(ctx, &s, 3, faces, 0x1p-20), KN_OK);
    assert_true(s.coef[0] == face[0].coef[0]);
    face[4].coef[0] -= 0x1p-20;
    // Other failures.
    kn_spline empty = {0};
    assert_int_equal(kn_construct_coons(ctx, &s, 1, faces, 0.0), KN_EDOMAIN);
    assert_int_equal(kn_construct_coons(ctx, &s, 3, faces, -1.0), KN_EDOMAIN);
    assert_int_equal(kn_construct_coons(ctx, &s, 2, faces, 0.0), KN_EDOMAIN); // surfaces for curves
    assert_int_equal(kn_construct_coons(ctx, &s, KN_MAX_VARS + 1, faces, 0.0), KN_ELIMIT);
    faces[3] = &empty;
    assert_int_equal(kn_construct_coons(ctx, &s, 3, faces, 0.0), KN_EDOMAIN);
    faces[3] = &face[3];
    assert_int_equal(kn_spline_reparameterize(ctx, &face[3], &face[3], 0, 0, 2), KN_OK);
    assert_int_equal(kn_construct_coons(ctx, &s, 3, faces, 0.0), KN_EDOMAIN);
    for (int f = 0; f < 6; f++) kn_spline_clear(ctx, &face[f]);
    kn_spline_clear(ctx, &volume);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Weights 1 at the corners and 1/8 in the middle of each edge: 1/8 + 1/8 + 1/8 + 1/8 in halves, less 1.
static void coons_weights(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 1, 1}, coef[] = {0, 0, 0, 1, 0.125, 1};
    kn_spline face = {0}, s = {0};
    assert_int_equal(kn_spline_init(ctx, &face, 1, 2, true, (int[]){2}, (int[]){3}, (const double *[]){knots}, coef),
                     KN_OK);
    assert_int_equal(kn_construct_coons(ctx, &s, 2, (const kn_spline *[]){&face, &face, &face, &face}, 0.0),
                     KN_EUNDEFINED);
    assert_int_equal(s.nvars, 0);
    kn_spline_clear(ctx, &face);
    test_ctx_end(ctx, &memory);
}

static kn_status make(kn_ctx *ctx, kn_spline *s, const kn_spline *a, const kn_spline *b, int which)
{
    const double up[3] = {0, 0, 1};
    if (which == 0) return kn_construct_swept(ctx, s, a, b);
    if (which == 1) return kn_construct_swept_frame(ctx, s, NULL, a, b, up, 0.1);
    return kn_construct_coons(ctx, s, 2, (const kn_spline *[]){a, b, a, b}, 100.0);
}

static kn_status once(kn_ctx *ctx, void *user)
{
    kn_spline a = {0}, b = {0}, s = {0};
    const double knots[] = {0, 0, 1, 1}, finer[] = {0, 0, 0, 0.5, 1, 1, 1};
    const double coef[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 1, 1, 1, 1, 1, 1};
    kn_status status = kn_spline_init(ctx, &a, 1, 3, false, (int[]){1}, (int[]){2}, (const double *[]){knots}, coef);
    if (status == KN_OK)
        status = kn_spline_init(ctx, &b, 1, 4, true, (int[]){2}, (int[]){4}, (const double *[]){finer}, coef);
    if (status == KN_OK) {
        status = make(ctx, &s, &a, &b, *(int *)user);
        if (status != KN_OK) assert_true(s.nvars == 0 && !s.coef);
    }
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &b);
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    for (int which = 0; which < 3; which++) test_allocation_failures(once, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(swept),           cmocka_unit_test(swept_frame),
                                       cmocka_unit_test(sweep_failures),  cmocka_unit_test(coons_of_segments),
                                       cmocka_unit_test(coons_of_curves), cmocka_unit_test(coons_volume),
                                       cmocka_unit_test(coons_weights),   cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("construct/sums", tests, NULL, NULL);
}
