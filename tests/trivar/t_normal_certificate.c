// SPDX-License-Identifier: Apache-2.0
// The certificates of both constructions of the normal against 100,000 samples in long double for each surface and
// tolerance: no sample passes a bound, and the bounds are not above 10 times the worst sample.
#include "tests/support/surfaces.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { SAMPLES = 100000 };

// The true normal on a random grid over a surface.
typedef struct truth {
    kn_spline s;
    size_t nu, nv;
    double *u, *v;
    long double (*normal)[3];
    long double slope[2];
    long double *error; // of the angle, by which `normal` itself may be wrong; HUGE_VALL: do not look at this place
} truth;

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double *places(test_rng *rng, const kn_spline *s, int var, size_t n)
{
    double lo, hi, *x = malloc(n * sizeof *x);
    assert_non_null(x);
    kn_spline_domain(s, var, &lo, &hi);
    for (size_t i = 0; i < n; i++) x[i] = test_uniform(rng, lo, hi);
    qsort(x, n, sizeof *x, by_value);
    return x;
}

// A bound of what terms of a derivative in variable var are made of: 2 p / h |P|, h the shortest span.
static long double slope(const kn_spline *s, int var)
{
    size_t n = kn_spline_count(s);
    double most = 0.0, h = INFINITY;
    for (size_t i = 0; i < (size_t)s->ncomp * n; i++) most = fmax(most, fabs(s->coef[i]));
    for (int i = 0; i < s->count[var] + s->degree[var]; i++) {
        double step = s->knots[var][i + 1] - s->knots[var][i];
        if (step > 0.0) h = fmin(h, step);
    }
    return 2.0L * s->degree[var] / h * most;
}

// S_u x S_v from homogeneous values and derivatives f[0 .. 3 ncomp - 1]. A derivative sums fewer than 4 * 16 terms,
// of which a rational one takes two sums, and the quotient rule multiplies by |S| / W: 1000 roundings cover all that.
static void find_normal(truth *t, size_t at, const long double *f)
{
    long double d[2][3], length[2] = {0, 0}, across = 0.0L, *n = t->normal[at];
    int nc = t->s.ncomp;
    for (int v = 0; v < 2; v++) {
        for (int c = 0; c < 3; c++) {
            d[v][c] = f[(1 + v) * nc + c];
            if (nc == 4) d[v][c] = (d[v][c] - f[(1 + v) * nc + 3] * f[c] / f[3]) / f[3];
            length[v] += d[v][c] * d[v][c];
        }
        length[v] = sqrtl(length[v]);
    }
    for (int c = 0; c < 3; c++) {
        n[c] = d[0][(c + 1) % 3] * d[1][(c + 2) % 3] - d[0][(c + 2) % 3] * d[1][(c + 1) % 3];
        across += n[c] * n[c];
    }
    across = sqrtl(across);
    long double wrong = t->slope[0] * length[1] + t->slope[1] * length[0];
    t->error[at] = 1000.0L * LDBL_EPSILON * wrong / across;
    if (!(t->error[at] < 1e-13L)) t->error[at] = HUGE_VALL; // at a pole the cross product is rounding
    for (int c = 0; c < 3; c++) n[c] /= across;
}

static void truth_init(truth *t, test_rng *rng, size_t samples) // t->s is there
{
    t->nu = (size_t)sqrt((double)samples);
    t->nv = (samples + t->nu - 1) / t->nu;
    t->u = places(rng, &t->s, 0, t->nu);
    t->v = places(rng, &t->s, 1, t->nv);
    size_t n = t->nu * t->nv, step = 3 * (size_t)t->s.ncomp;
    long double *f = malloc(n * step * sizeof *f);
    t->normal = malloc(n * sizeof *t->normal);
    t->error = malloc(n * sizeof *t->error);
    assert_true(f && t->normal && t->error);
    for (int var = 0; var < 2; var++) t->slope[var] = slope(&t->s, var);
    direct_grid(f, &t->s, t->nu, t->u, t->nv, t->v);
    for (size_t i = 0; i < n; i++) find_normal(t, i, f + i * step);
    free(f);
}

static void truth_clear(kn_ctx *ctx, truth *t)
{
    free(t->u), free(t->v), free(t->normal), free(t->error);
    kn_spline_clear(ctx, &t->s);
}

// ---- one shell against it ----

typedef struct worst {
    long double length, angle;        // of samples
    double length_bound, angle_bound; // of certificates
    size_t looked;
} worst;

static void compare(worst *w, const truth *t, const kn_shell *shell, const char *name)
{
    kn_normal_certificate c = kn_shell_certificate(shell);
    size_t points = t->nu * t->nv;
    long double *n = malloc(9 * points * sizeof *n);
    assert_non_null(n);
    direct_grid(n, kn_shell_normal(shell), t->nu, t->u, t->nv, t->v);
    for (size_t i = 0; i < points; i++) {
        const long double *a = n + 9 * i, *b = t->normal[i];
        long double aa = 0.0L, cross = 0.0L, dot = 0.0L;
        for (int k = 0; k < 3; k++) {
            long double x = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
            aa += a[k] * a[k], dot += a[k] * b[k], cross += x * x;
        }
        long double length = fabsl(sqrtl(aa) - 1.0L), angle = atan2l(sqrtl(cross), dot), slack = 1e-17L;
        if (!(length <= c.length_error + slack))
            fail_msg("%s: at (%.17g, %.17g) length %Lg above %g", name, t->u[i / t->nv], t->v[i % t->nv], length,
                     c.length_error);
        w->length = fmaxl(w->length, length);
        if (t->error[i] == HUGE_VALL) continue;
        if (!(angle <= c.angle_error + t->error[i] + slack))
            fail_msg("%s: at (%.17g, %.17g) angle %Lg above %g", name, t->u[i / t->nv], t->v[i % t->nv], angle,
                     c.angle_error);
        w->angle = fmaxl(w->angle, angle);
        w->looked++;
    }
    w->length_bound = fmax(w->length_bound, c.length_error);
    w->angle_bound = fmax(w->angle_bound, c.angle_error);
    free(n);
}

// A sum of 196 terms of at most 2^-53 each way is 1e-13 or more as soon as bounds are a-priori; poles, whose
// direction is small beside its coefficients, take another factor of some tens: below this an angle is rounding
// alone.
static const double rounding = 1e-10;

// n is made one vector at a pole: next to it the length's error there turns N m, by (1 - x)^p sin(turn of N over x) of
// it, x in units of the span: x (1 - x)^p is at most 1/(e p), p at least 6 and the turn at most a right angle or so.
static double largest_angle(const kn_shell *shell, double tol)
{
    kn_shell_edge edges[2][2];
    kn_shell_edges(shell, edges);
    for (int e = 0; e < 4; e++)
        if (edges[e / 2][e % 2].kind == KN_EDGE_POLE) return fmax(rounding, 0.1 * tol);
    return rounding;
}

static void check(kn_ctx *ctx, const truth *parts, int n, const char *name, double tol, kn_normal_method method)
{
    worst w = {0};
    size_t samples = 0;
    for (int k = 0; k < n; k++) {
        kn_shell_options o = {.normal = method, .normal_tol = tol};
        kn_shell *shell = NULL;
        if (kn_shell_create(ctx, &shell, &parts[k].s, &o) != KN_OK) fail_msg("%s: %s", name, kn_ctx_message(ctx));
        compare(&w, &parts[k], shell, name);
        if (method == KN_NORMAL_EXACT_DIRECTION)
            assert_true(kn_shell_certificate(shell).angle_error <= largest_angle(shell, tol));
        samples += parts[k].nu * parts[k].nv;
        kn_shell_destroy(ctx, shell);
    }
    assert_true(samples >= SAMPLES && w.looked >= samples / 100 * 98);
    assert_true(w.length_bound <= tol && w.angle_bound <= tol);
    if (!(w.length_bound <= 10.0L * w.length))
        fail_msg("%s, %g: length bound %g, worst sample %Lg", name, tol, w.length_bound, w.length);
    if (!(w.angle_bound <= 10.0L * w.angle || w.angle_bound <= rounding))
        fail_msg("%s, %g: angle bound %g, worst sample %Lg", name, tol, w.angle_bound, w.angle);
}

// last: the smallest tolerance for the method; the smaller ones of large surfaces wait for KN_TEST_SCALE.
static void check_all(kn_ctx *ctx, const truth *parts, int n, const char *name, double last_fitted, double last_exact)
{
    bool all = test_scale(1) > 1;
    for (double tol = 1e-3; tol > 5e-10; tol *= 1e-3) {
        if (all || tol > 0.5 * last_fitted) check(ctx, parts, n, name, tol, KN_NORMAL_FITTED);
        if (all || tol > 0.5 * last_exact) check(ctx, parts, n, name, tol, KN_NORMAL_EXACT_DIRECTION);
    }
}

static void one_surface(void (*make)(kn_ctx *ctx, kn_spline *out), const char *name, double last_fitted,
                        double last_exact)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    truth t = {0};
    make(ctx, &t.s);
    truth_init(&t, &rng, SAMPLES);
    check_all(ctx, &t, 1, name, last_fitted, last_exact);
    truth_clear(ctx, &t);
    test_ctx_end(ctx, &memory);
}

static void torus(void **state)
{
    (void)state;
    one_surface(make_torus, "torus", 1e-6, 1e-6);
}

static void sphere(void **state)
{
    (void)state;
    one_surface(make_sphere, "sphere", 1e-9, 1e-6);
}

static void waves(void **state)
{
    (void)state;
    one_surface(make_waves, "waves", 1e-6, 1e-3);
}

static void vase(void **state)
{
    (void)state;
    one_surface(make_vase, "vase", 1e-6, 1e-6);
}

static void teapot(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    truth parts[TEAPOT_PATCHES] = {0};
    int n = 0;
    while (n < TEAPOT_PATCHES && make_teapot(ctx, &parts[n].s, n)) {
        truth_init(&parts[n], &rng, SAMPLES / TEAPOT_PATCHES + 1);
        n++;
    }
    if (n == TEAPOT_PATCHES) check_all(ctx, parts, n, "teapot", 1e-6, 1e-3);
    for (int k = 0; k < n; k++) truth_clear(ctx, &parts[k]);
    test_ctx_end(ctx, &memory);
    if (n < TEAPOT_PATCHES) skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(torus), cmocka_unit_test(sphere), cmocka_unit_test(waves),
        cmocka_unit_test(vase),  cmocka_unit_test(teapot),
    };
    return cmocka_run_group_tests_name("trivar/normal_certificate", tests, NULL, NULL);
}
