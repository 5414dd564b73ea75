// SPDX-License-Identifier: Apache-2.0
// Support positions: places that are known, from closed forms and from T itself, and none that is lost.
#include "tests/support/kinds.h"

#include <math.h>
#include <stdio.h>

typedef struct asked {
    kn_support *place;
    size_t n;
    bool complete;
} asked;

static kn_shell *shell_of(kn_ctx *ctx, const kn_spline *s, const kn_shell_options *o)
{
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

static kn_shell_inverse *inverse_of(kn_ctx *ctx, const kn_shell *shell, double w0, double w1)
{
    kn_shell_inverse *inverse = NULL;
    if (kn_shell_inverse_create(ctx, &inverse, shell, w0, w1) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return inverse;
}

static asked ask(kn_ctx *ctx, const kn_shell_inverse *inverse, double x, double y, double z)
{
    const double p[3] = {x, y, z};
    asked a = {0};
    if (kn_shell_support(ctx, &a.place, &a.n, &a.complete, inverse, p) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    for (size_t i = 1; i < a.n; i++) assert_true(fabs(a.place[i - 1].uvw[2]) <= fabs(a.place[i].uvw[2]));
    return a;
}

static bool holds(const kn_support *s, const double uvw[3])
{
    bool in = true;
    for (int d = 0; d < 3; d++) in = in && fabs(s->uvw[d] - uvw[d]) <= s->error[d];
    return in;
}

// The shell of a surface alone.
typedef struct made {
    kn_spline s;
    kn_shell *shell;
    kn_shell_inverse *inverse;
} made;

// tol: of n; T is what is inverted, so that a rough n will do where truth is T itself.
static made make(kn_ctx *ctx, void (*surface)(kn_ctx *, kn_spline *), double tol, double w0, double w1)
{
    const kn_shell_options o = {.normal_tol = tol};
    made m;
    surface(ctx, &m.s);
    m.shell = shell_of(ctx, &m.s, &o);
    m.inverse = inverse_of(ctx, m.shell, w0, w1);
    return m;
}

static void clear(kn_ctx *ctx, made *m)
{
    kn_shell_inverse_destroy(ctx, m->inverse);
    kn_shell_destroy(ctx, m->shell);
    kn_spline_clear(ctx, &m->s);
}

// ---- places that T came from ----

// What is certified holds for every T within its coefficients' bound, a few hundred roundings of them; that of the
// point is one. So the place that the point was computed from lies in a box, without any tolerance.
static void check_recovered(kn_ctx *ctx, const kn_shell_inverse *inverse, const long double t[3], const double at[3],
                            const char *name)
{
    asked a = ask(ctx, inverse, (double)t[0], (double)t[1], (double)t[2]);
    size_t found = 0;
    for (size_t i = 0; i < a.n; i++) {
        if (!holds(&a.place[i], at)) continue;
        found++;
        if (!a.place[i].certified) fail_msg("%s: (%.17g, %.17g, %.17g) is not certified", name, at[0], at[1], at[2]);
        for (int d = 0; d < 3; d++) assert_true(a.place[i].error[d] < 1e-8);
    }
    if (found != 1) fail_msg("%s: (%.17g, %.17g, %.17g) was found %zu times", name, at[0], at[1], at[2], found);
    assert_true(a.complete);
    kn_free(ctx, a.place);
}

static void surfaces_recovered(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(41);
    const kn_shell_options plain = {0};
    for (int k = 0; k < SURFACE_CASES; k++) {
        made m = make(ctx, surface_cases[k].make, 1e-4, -0.25, 0.25);
        double lo[2], hi[2];
        for (int v = 0; v < 2; v++) kn_spline_domain(&m.s, v, &lo[v], &hi[v]);
        for (int i = 0; i < test_scale(100); i++) {
            double at[3] = {test_uniform(&rng, lo[0], hi[0]), test_uniform(&rng, lo[1], hi[1]),
                            test_uniform(&rng, -0.25, 0.25)};
            long double t[3];
            direct_kind(t, NULL, m.shell, &plain, at[0], at[1], at[2]);
            check_recovered(ctx, m.inverse, t, at, surface_cases[k].name);
        }
        clear(ctx, &m);
    }
    test_ctx_end(ctx, &memory);
}

static void fields_recovered(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(42);
    for (int k = 0; k < 4; k++) {
        kn_spline s, h, psi;
        (k % 2 ? make_torus : make_wavy)(ctx, &s);
        make_field(ctx, &h, &rng, &s, 2, 1, 1.0, 0.2);
        make_field(ctx, &psi, &rng, &s, 2, 3, 0.0, 0.3);
        kn_shell_options o = {
            .thickness = &h, .attraction = k > 1 ? &psi : NULL, .attraction_power = k, .normal_tol = 1e-4};
        kn_shell *shell = shell_of(ctx, &s, &o);
        kn_shell_inverse *inverse = inverse_of(ctx, shell, -0.1, 0.3);
        double lo[2], hi[2];
        for (int v = 0; v < 2; v++) kn_spline_domain(&s, v, &lo[v], &hi[v]);
        for (int i = 0; i < test_scale(40); i++) {
            double at[3] = {test_uniform(&rng, lo[0], hi[0]), test_uniform(&rng, lo[1], hi[1]),
                            test_uniform(&rng, -0.1, 0.3)};
            long double t[3];
            direct_kind(t, NULL, shell, &o, at[0], at[1], at[2]);
            check_recovered(ctx, inverse, t, at, "fields");
        }
        kn_shell_inverse_destroy(ctx, inverse);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &h);
        kn_spline_clear(ctx, &psi);
    }
    test_ctx_end(ctx, &memory);
}

static void volumes_recovered(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(43);
    for (int k = 0; k < VOLUME_OF_SPANS; k++) { // the last one is random, and folds
        kn_spline volume;
        kn_shell *shell = NULL;
        double w[2], lo[3], hi[3];
        make_volume(ctx, &volume, k);
        assert_int_equal(kn_shell_from_volume(ctx, &shell, &volume, NULL), KN_OK);
        kn_shell_heights(shell, w);
        kn_shell_inverse *inverse = inverse_of(ctx, shell, w[0], w[1]);
        for (int v = 0; v < 3; v++) kn_spline_domain(&volume, v, &lo[v], &hi[v]);
        for (int i = 0; i < test_scale(40); i++) {
            double at[3];
            long double x[3], t[3];
            for (int v = 0; v < 2; v++) x[v] = at[v] = test_uniform(&rng, lo[v], hi[v]);
            at[2] = test_uniform(&rng, w[0], w[1]);
            x[2] = lo[2] + (long double)at[2];
            direct_volume(t, &volume, x);
            check_recovered(ctx, inverse, t, at, "volume");
        }
        kn_shell_inverse_destroy(ctx, inverse);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &volume);
    }
    test_ctx_end(ctx, &memory);
}

// ---- closed forms: n is within 1e-6 of the true normal, so that |w| 1e-6 is what T may differ from the exact offset
// ----

static void torus_places(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(44);
    made m = make(ctx, make_torus, 1e-6, -8.0, 8.0);
    for (int i = 0; i < 6; i++) { // inside the tube, at a distance from its centre: two normals each of both circles
        double turn = test_uniform(&rng, 0.1, 1.4), rho = test_uniform(&rng, 0.2, 0.9),
               phi = test_uniform(&rng, 0.1, 6.0);
        double r = 3.0 + rho * cos(phi), z = rho * sin(phi), far = hypot(r + 3.0, z);
        double want[4] = {rho - 1.0, -rho - 1.0, far - 1.0, -far - 1.0};
        asked a = ask(ctx, m.inverse, r * cos(turn), r * sin(turn), z);
        assert_int_equal(a.n, 4);
        assert_true(a.complete);
        for (int k = 0; k < 4; k++) {
            bool found = false;
            for (size_t j = 0; j < a.n; j++)
                found = found || (a.place[j].certified && fabs(a.place[j].uvw[2] - want[k]) < 1e-5 * fabs(want[k]));
            assert_true(found);
        }
        kn_free(ctx, a.place);
    }
    clear(ctx, &m);
    test_ctx_end(ctx, &memory);
}

static void sphere_places(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    made m = make(ctx, make_sphere, 1e-6, -3.9, 1.0);
    asked a = ask(ctx, m.inverse, 0.3, 0.2, 0.1); // near the centre: on both sides of it
    double rho = sqrt(0.14);
    assert_int_equal(a.n, 2);
    assert_true(a.complete && a.place[0].certified && a.place[1].certified);
    assert_true(fabs(a.place[0].uvw[2] - (rho - 2.0)) < 1e-5 && fabs(a.place[1].uvw[2] + rho + 2.0) < 1e-5);
    assert_true(fabs(a.place[1].uvw[0] - a.place[0].uvw[0] - 2.0) < 1e-5); // opposite
    kn_free(ctx, a.place);
    a = ask(ctx, m.inverse, 0.0, 2.9, 0.0);
    assert_int_equal(a.n, 1);
    assert_true(a.complete && a.place[0].certified && fabs(a.place[0].uvw[2] - 0.9) < 1e-5);
    assert_true(fabs(a.place[0].uvw[0] - 1.0) < 1e-6 && fabs(a.place[0].uvw[1] - 1.0) < 1e-6);
    kn_free(ctx, a.place);
    a = ask(ctx, m.inverse, 0.0, 3.1, 0.0); // too high
    assert_true(a.n == 0 && a.complete);
    kn_free(ctx, a.place);
    clear(ctx, &m);
    test_ctx_end(ctx, &memory);
}

static void poles_are_one_place(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    made m = make(ctx, make_sphere, 1e-6, -0.5, 0.5);
    for (int i = 0; i < 10; i++) {
        double w = -0.45 + 0.1 * i, z = (i % 2 ? 1.0 : -1.0) * (2.0 + w);
        asked a = ask(ctx, m.inverse, 0.0, 0.0, z);
        assert_int_equal(a.n, 1);
        assert_true(a.complete && a.place[0].certified && a.place[0].at_edge);
        assert_true(a.place[0].error[0] >= 2.0); // any u
        assert_true(a.place[0].uvw[1] == (i % 2 ? 2.0 : 0.0) && a.place[0].error[1] < 1e-11);
        // z is rounded, n at the pole is one vector within 1e-6 of the axis, and its length within 1e-6 of 1
        assert_true(fabs(a.place[0].uvw[2] - w) < 1e-6);
        kn_free(ctx, a.place);
        for (double far = 1e-3; far > 1e-9; far *= 0.1) { // beside it: u is known again
            a = ask(ctx, m.inverse, 0.6 * far, 0.8 * far, z);
            assert_true(a.n == 1 && a.complete && a.place[0].certified && a.place[0].error[0] < 0.1);
            kn_free(ctx, a.place);
        }
    }
    asked a = ask(ctx, m.inverse, 0.0, 0.0, 2.6);
    assert_true(a.n == 0 && a.complete);
    clear(ctx, &m);
    test_ctx_end(ctx, &memory);
}

// On seams, cell lines and knots of n several pieces meet: one place, whatever their number.
static void borders_are_one_place(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(45);
    const kn_shell_options plain = {0};
    for (int k = 1; k < SURFACE_CASES; k++) {
        made m = make(ctx, surface_cases[k].make, 1e-4, -0.25, 0.25);
        const kn_spline *n = kn_shell_normal(m.shell);
        bool closed[2];
        kn_shell_closed(m.shell, closed);
        for (int i = 0; i < test_scale(12); i++) {
            double at[3] = {0, 0, (i % 3 - 1) * 0.25 * (i % 2)};
            long double t[3];
            for (int v = 0; v < 2; v++) {
                double lo, hi;
                kn_spline_domain(&m.s, v, &lo, &hi);
                at[v] = i % 3 == v ? test_uniform(&rng, lo, hi)
                                   : n->knots[v][test_int(&rng, 0, n->count[v] + n->degree[v])];
                if (k == 3 && v == 1 && (at[v] == lo || at[v] == hi)) at[v] = 1.0; // poles are another test
            }
            direct_kind(t, NULL, m.shell, &plain, at[0], at[1], at[2]);
            asked a = ask(ctx, m.inverse, (double)t[0], (double)t[1], (double)t[2]);
            if (a.n != 1 || !a.complete || !a.place[0].certified)
                fail_msg("%s: %zu places at (%.17g, %.17g, %g)", surface_cases[k].name, a.n, at[0], at[1], at[2]);
            for (int v = 0; v < 2; v++) { // the other end of a closed variable is the same place
                double lo, hi;
                kn_spline_domain(&m.s, v, &lo, &hi);
                if (closed[v] && at[v] == hi && a.place[0].uvw[v] < 0.5 * (lo + hi)) at[v] = lo;
            }
            assert_true(holds(&a.place[0], at));
            kn_free(ctx, a.place);
        }
        clear(ctx, &m);
    }
    test_ctx_end(ctx, &memory);
}

// ---- folds ----

// T = (u, v, w^2 - w) on [0,1]^3: folds at w = 1/2.
static kn_shell *folding(kn_ctx *ctx)
{
    const int degree[3] = {1, 1, 2}, count[3] = {2, 2, 3};
    const double k1[4] = {0, 0, 1, 1}, k2[6] = {0, 0, 0, 1, 1, 1}, *knots[3] = {k1, k1, k2};
    const double height[3] = {0.0, -0.5, 0.0};
    double coef[36];
    for (int i = 0; i < 12; i++) {
        coef[i] = i / 6;
        coef[12 + i] = i / 3 % 2;
        coef[24 + i] = height[i % 3];
    }
    kn_spline volume;
    kn_shell *shell = NULL;
    assert_int_equal(kn_spline_init(ctx, &volume, 3, 3, false, degree, count, knots, coef), KN_OK);
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &volume, NULL), KN_OK);
    kn_spline_clear(ctx, &volume);
    return shell;
}

static void fold_is_not_certified(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_shell *shell = folding(ctx);
    kn_shell_inverse *inverse = inverse_of(ctx, shell, 0.0, 1.0);
    const double fold[3] = {0.3, 0.6, 0.5};
    asked a = ask(ctx, inverse, 0.3, 0.6, -0.25);
    assert_int_equal(a.n, 1);
    assert_true(!a.place[0].certified && holds(&a.place[0], fold));
    assert_true(a.place[0].error[2] < 1e-5); // a double root: the square root of 1e-14, and a little
    kn_free(ctx, a.place);
    a = ask(ctx, inverse, 0.3, 0.6, -0.24); // w = 1/2 -+ 1/10
    assert_int_equal(a.n, 2);
    assert_true(a.complete && a.place[0].certified && a.place[1].certified);
    assert_true(fabs(a.place[0].uvw[2] - 0.4) < 1e-12 && fabs(a.place[1].uvw[2] - 0.6) < 1e-12);
    kn_free(ctx, a.place);
    a = ask(ctx, inverse, 0.3, 0.6, -0.2500001);
    assert_true(a.n == 0 && a.complete);
    kn_free(ctx, a.place);
    kn_shell_inverse_destroy(ctx, inverse);
    kn_shell_destroy(ctx, shell);
    test_ctx_end(ctx, &memory);
}

// T = (v, w, 0): every u is a place.
static void continuum_is_told(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int one[3] = {1, 1, 1}, count[3] = {2, 2, 2};
    const double k[4] = {0, 0, 1, 1}, *knots[3] = {k, k, k};
    double coef[24] = {0};
    for (int i = 0; i < 8; i++) coef[i] = i / 2 % 2, coef[8 + i] = i % 2;
    kn_spline volume;
    kn_shell *shell = NULL;
    assert_int_equal(kn_spline_init(ctx, &volume, 3, 3, false, one, count, knots, coef), KN_OK);
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &volume, NULL), KN_OK);
    kn_shell_inverse *inverse = inverse_of(ctx, shell, 0.0, 1.0);
    asked a = ask(ctx, inverse, 0.25, 0.7, 0.0);
    assert_true(!a.complete);
    for (double u = 0.0; u <= 1.0; u += 0.125) {
        const double at[3] = {u, 0.25, 0.7};
        size_t found = 0;
        for (size_t i = 0; i < a.n; i++) found += holds(&a.place[i], at);
        assert_true(found > 0);
    }
    for (size_t i = 0; i < a.n; i++) assert_false(a.place[i].certified);
    kn_free(ctx, a.place);
    a = ask(ctx, inverse, 0.25, 0.7, 1e-9);
    assert_true(a.n == 0 && a.complete);
    kn_free(ctx, a.place);
    kn_shell_inverse_destroy(ctx, inverse);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &volume);
    test_ctx_end(ctx, &memory);
}

// ---- none is lost: Newton's method from many places ----

static bool newton(kn_ctx *ctx, const kn_shell *shell, const double p[3], double uvw[3])
{
    for (int step = 0; step < 30; step++) {
        double t[3], j[9], r[3], move[3];
        assert_int_equal(kn_shell_eval(ctx, t, j, shell, uvw[0], uvw[1], uvw[2]), KN_OK);
        double det = j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
                     j[2] * (j[3] * j[7] - j[4] * j[6]);
        for (int c = 0; c < 3; c++) r[c] = p[c] - t[c];
        for (int d = 0; d < 3; d++) { // Cramer's rule
            double k[9];
            for (int c = 0; c < 9; c++) k[c] = c % 3 == d ? r[c / 3] : j[c];
            move[d] = (k[0] * (k[4] * k[8] - k[5] * k[7]) - k[1] * (k[3] * k[8] - k[5] * k[6]) +
                       k[2] * (k[3] * k[7] - k[4] * k[6])) /
                      det;
        }
        for (int d = 0; d < 3; d++) uvw[d] += move[d];
        double size = fabs(move[0]) + fabs(move[1]) + fabs(move[2]);
        if (!(size < 100.0)) return false;
        if (size < 1e-13) return true;
    }
    return false;
}

static void newton_finds_no_other(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(46);
    made m = make(ctx, make_wavy, 1e-4, -8.0, 8.0); // far beyond the radii of curvature
    size_t several = 0;
    for (int i = 0; i < 10 || i < test_scale(10); i++) { // fewer might all have one place
        double p[3] = {test_uniform(&rng, 1, 4), test_uniform(&rng, 1, 3), test_uniform(&rng, -6, 6)};
        asked a = ask(ctx, m.inverse, p[0], p[1], p[2]);
        several += a.n > 1;
        for (int k = 0; k < 200; k++) {
            double at[3] = {test_uniform(&rng, 0, 3), test_uniform(&rng, 0, 3), test_uniform(&rng, -8, 8)};
            if (!newton(ctx, m.shell, p, at)) continue;
            bool in = at[0] > 0 && at[0] < 3 && at[1] > 0 && at[1] < 3 && fabs(at[2]) < 8, found = false;
            // Newton stops within some rounding of the place: J is far from singular where it converges that fast
            for (size_t j = 0; j < a.n && in; j++) {
                kn_support s = a.place[j];
                for (int d = 0; d < 3; d++) s.error[d] += 1e-10;
                found = found || holds(&s, at);
            }
            if (in && !found)
                fail_msg("(%g, %g, %g) has a place (%.17g, %.17g, %.17g)", p[0], p[1], p[2], at[0], at[1], at[2]);
        }
        kn_free(ctx, a.place);
    }
    assert_true(several > 0);
    clear(ctx, &m);
    test_ctx_end(ctx, &memory);
}

// ---- failures ----

static int stop(void *user, const char *stage, double fraction)
{
    (void)user, (void)stage, (void)fraction;
    return 1;
}

// Making an inverse reports for each piece.
static void cancelled(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    const kn_ctx_options options = {.allocator = test_allocator(&memory), .progress = stop};
    kn_ctx *ctx = test_ctx(&memory, 1), *other = NULL;
    kn_shell *shell = folding(ctx);
    kn_shell_inverse *inverse = NULL;
    assert_int_equal(kn_ctx_create(&other, &options), KN_OK);
    assert_int_equal(kn_shell_inverse_create(other, &inverse, shell, 0.0, 1.0), KN_ECANCELLED);
    assert_null(inverse);
    kn_ctx_destroy(other);
    kn_shell_destroy(ctx, shell);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_shell *shell = folding(ctx);
    kn_shell_inverse *inverse = NULL;
    const double heights[6][2] = {{0, 0}, {1, 0}, {-0.5, 0.5}, {0.5, 1.5}, {NAN, 1}, {0, INFINITY}};
    for (int i = 0; i < 6; i++) {
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_shell_inverse_create(ctx, &inverse, shell, heights[i][0], heights[i][1]), KN_EDOMAIN);
        assert_null(inverse);
    }
    kn_ctx_clear_error(ctx);
    kn_shell_inverse_destroy(ctx, NULL);
    inverse = inverse_of(ctx, shell, 0.0, 0.5);
    for (int c = 0; c < 3; c++) {
        double p[3] = {0, 0, 0};
        kn_support *places = NULL;
        size_t n = 77;
        bool complete = false;
        p[c] = c == 1 ? NAN : INFINITY;
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_shell_support(ctx, &places, &n, &complete, inverse, p), KN_EDOMAIN);
        assert_true(!places && n == 77 && !complete);
    }
    kn_shell_inverse_destroy(ctx, inverse);
    kn_shell_destroy(ctx, shell);
    test_ctx_end(ctx, &memory);
}

static kn_status create_and_ask(kn_ctx *ctx, void *user)
{
    kn_shell_inverse *inverse = NULL;
    kn_support *places = NULL;
    size_t n = 0;
    bool complete;
    const double p[3] = {0.3, 0.6, -0.24};
    kn_status status = kn_shell_inverse_create(ctx, &inverse, user, 0.0, 1.0);
    assert_true((status == KN_OK) == (inverse != NULL));
    if (status == KN_OK) status = kn_shell_support(ctx, &places, &n, &complete, inverse, p);
    assert_true(status == KN_OK || (!places && n == 0));
    kn_free(ctx, places);
    kn_shell_inverse_destroy(ctx, inverse);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_shell *volume = folding(ctx);
    kn_spline s;
    make_plane(ctx, &s);
    kn_shell *plane = shell_of(ctx, &s, NULL);
    test_allocation_failures(create_and_ask, volume);
    test_allocation_failures(create_and_ask, plane);
    kn_shell_destroy(ctx, volume);
    kn_shell_destroy(ctx, plane);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_recovered),
        cmocka_unit_test(fields_recovered),
        cmocka_unit_test(volumes_recovered),
        cmocka_unit_test(torus_places),
        cmocka_unit_test(sphere_places),
        cmocka_unit_test(poles_are_one_place),
        cmocka_unit_test(borders_are_one_place),
        cmocka_unit_test(fold_is_not_certified),
        cmocka_unit_test(continuum_is_told),
        cmocka_unit_test(newton_finds_no_other),
        cmocka_unit_test(failures),
        cmocka_unit_test(cancelled),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("trivar/support", tests, NULL, NULL);
}
