// SPDX-License-Identifier: Apache-2.0
// Lines against a bicubic B-spline surface of 20 x 20 control points, and closest points on it, one thread: ours,
// certified, and SISL's s1856 and s1954 where it is installed, with the number of answers of each. Roots of one
// variable: ours alone.
#include "bench/bench.h"

#include <knurl/solve.h>

#include <math.h>

#ifdef KN_WITH_SISL
#include <sisl.h>
#endif

enum { COUNT = 20, DEGREE = 3, DIM = 3, KNOTS = COUNT + DEGREE + 1, QUERIES = 40, RIVALS = 3 };

typedef struct data {
    kn_ctx *ctx;
    kn_spline s;
    double knots[KNOTS], coef[DIM * COUNT * COUNT];
    double point[QUERIES][DIM], direction[QUERIES][DIM], distance[QUERIES];
    size_t found, certain, boxes;
    bool failed;
#ifdef KN_WITH_SISL
    SISLSurf *surface;
    double distance_sisl[QUERIES];
    size_t found_sisl, curves_sisl, failed_sisl;
#endif
} data;

static double noise(unsigned long long *state)
{
    *state = *state * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(*state >> 11) * 0x1p-53;
}

static void fill(data *d)
{
    unsigned long long state = 1;
    for (int i = 0; i < KNOTS; i++) d->knots[i] = i <= DEGREE ? 0.0 : i >= COUNT ? COUNT - DEGREE : i - DEGREE;
    for (int i = 0; i < COUNT; i++)
        for (int j = 0; j < COUNT; j++) {
            double *c = d->coef + i * COUNT + j;
            c[0] = i, c[COUNT * COUNT] = j, c[2 * COUNT * COUNT] = 3.0 * noise(&state);
        }
    for (int k = 0; k < QUERIES; k++) { // points about the surface; lines that are steep, and every fourth one flat
        for (int c = 0; c < DIM; c++) {
            d->point[k][c] = c < 2 ? 1.0 + 17.0 * noise(&state) : 4.0 * noise(&state) - 1.0;
            d->direction[k][c] = 2.0 * noise(&state) - 1.0;
        }
        d->direction[k][2] += k % 4 == 0 ? 0.0 : 2.0;
        if (k % 4 == 0) d->direction[k][2] *= 0.05;
    }
    d->s = (kn_spline){.nvars = 2,
                       .ncomp = 3,
                       .degree = {DEGREE, DEGREE},
                       .count = {COUNT, COUNT},
                       .knots = {d->knots, d->knots},
                       .coef = d->coef};
}

static void lines(void *user)
{
    data *d = user;
    d->found = d->certain = d->boxes = 0;
    for (int k = 0; k < QUERIES; k++) {
        kn_root *roots = NULL;
        kn_solve_report report = {0};
        size_t n = 0;
        if (kn_solve_intersect_line_surface(d->ctx, &roots, &n, &report, &d->s, d->point[k], d->direction[k], NULL) !=
            KN_OK)
            d->failed = true;
        d->found += n;
        d->certain += n - report.possible;
        d->boxes += report.boxes;
        kn_free(d->ctx, roots);
    }
}

static void closest(void *user)
{
    data *d = user;
    d->boxes = 0;
    for (int k = 0; k < QUERIES; k++) {
        kn_closest *best = NULL;
        kn_solve_report report = {0};
        size_t n = 0;
        if (kn_solve_closest(d->ctx, &best, &n, NULL, &report, &d->s, d->point[k], NULL) != KN_OK || n == 0)
            d->failed = true;
        else
            d->distance[k] = best[0].distance;
        d->boxes += report.boxes;
        kn_free(d->ctx, best);
    }
}

#ifdef KN_WITH_SISL
// SISL's vertices: components fastest, then the first variable.
static SISLSurf *sisl_surface(const data *d)
{
    double knots[2][KNOTS], vertices[COUNT * COUNT * DIM];
    for (int i = 0; i < 2; i++) memcpy(knots[i], d->knots, sizeof d->knots);
    for (int i = 0; i < COUNT; i++)
        for (int j = 0; j < COUNT; j++)
            for (int c = 0; c < DIM; c++)
                vertices[(j * COUNT + i) * DIM + c] = d->coef[c * COUNT * COUNT + i * COUNT + j];
    return newSurf(COUNT, COUNT, DEGREE + 1, DEGREE + 1, knots[0], knots[1], vertices, 1, DIM, 1);
}

static void drop(double *parameters, SISLIntcurve **curves, int ncurves)
{
    free(parameters);
    if (curves) freeIntcrvlist(curves, ncurves);
}

static void sisl_lines(void *user)
{
    data *d = user;
    d->found_sisl = d->curves_sisl = d->failed_sisl = 0;
    for (int k = 0; k < QUERIES; k++) {
        int points = 0, ncurves = 0, status = 0;
        double *parameters = NULL;
        SISLIntcurve **curves = NULL;
        s1856(d->surface, d->point[k], d->direction[k], DIM, 1e-15, 1e-9, &points, &parameters, &ncurves, &curves,
              &status);
        d->found_sisl += (size_t)points, d->curves_sisl += (size_t)ncurves, d->failed_sisl += status < 0;
        drop(parameters, curves, ncurves);
    }
}

static void sisl_closest(void *user)
{
    data *d = user;
    d->failed_sisl = 0;
    for (int k = 0; k < QUERIES; k++) {
        int points = 0, ncurves = 0, status = 0, left_u = 0, left_v = 0;
        double *parameters = NULL, x[DIM], normal[DIM];
        SISLIntcurve **curves = NULL;
        s1954(d->surface, d->point[k], DIM, 1e-15, 1e-9, &points, &parameters, &ncurves, &curves, &status);
        d->distance_sisl[k] = INFINITY;
        if (points > 0) {
            s1421(d->surface, 0, parameters, &left_u, &left_v, x, normal, &status);
            d->distance_sisl[k] = hypot(hypot(x[0] - d->point[k][0], x[1] - d->point[k][1]), x[2] - d->point[k][2]);
        }
        d->failed_sisl += status < 0 || points == 0;
        drop(parameters, curves, ncurves);
    }
}
#endif

static void tell(const char *what, const bench_rival *r, int n)
{
    for (int i = 0; i < n; i++)
        printf("%-14s %-8s %9.1f us each%s", what, r[i].name, 1e6 * r[i].seconds / QUERIES, i == 0 ? "\n" : "");
    if (n > 1) printf("   knurl is %.2f times as fast\n", r[1].ratio > 0.0 ? 1.0 / r[1].ratio : 0.0);
}

// Chebyshev's polynomial of degree 16: sixteen simple roots.
static void one_variable(data *d)
{
    enum { N = 16, TIMES = 200 };
    double knots[2 * (N + 1)], c[N + 1], power[N + 1] = {0}, last[N + 1] = {1.0}, now[N + 1] = {-1.0, 2.0};
    for (int i = 0; i < 2 * (N + 1); i++) knots[i] = i > N;
    for (int k = 2; k <= N; k++) { // T_k(2x - 1) = 2 (2x - 1) T_k-1 - T_k-2
        for (int i = 0; i <= N; i++) power[i] = -2.0 * now[i] - last[i] + (i > 0 ? 4.0 * now[i - 1] : 0.0);
        memcpy(last, now, sizeof now);
        memcpy(now, power, sizeof now);
    }
    for (int i = 0; i <= N; i++) {
        double ratio = 1.0; // C(i,k) / C(N,k)
        c[i] = 0.0;
        for (int k = 0; k <= i; k++) {
            c[i] += ratio * now[k];
            ratio *= (double)(i - k) / (N - k);
        }
    }
    kn_spline f = {.nvars = 1, .ncomp = 1, .degree = {N}, .count = {N + 1}, .knots = {knots}, .coef = c};
    double best = INFINITY;
    size_t n = 0;
    for (int t = 0; t < TIMES; t++) {
        kn_root *roots = NULL;
        double start = bench_now(BENCH_THREAD);
        if (kn_solve_roots(d->ctx, &roots, &n, NULL, &f, NULL) != KN_OK) d->failed = true;
        best = fmin(best, bench_now(BENCH_THREAD) - start);
        kn_free(d->ctx, roots);
    }
    printf("roots, degree %d: %zu found, %.1f us\n", N, n, 1e6 * best);
}

int main(void)
{
    static data d;
    if (kn_ctx_create(&d.ctx, NULL) != KN_OK) return 1;
    fill(&d);
    bench_rival rivals[2][RIVALS] = {{{.name = "knurl", .work = lines, .user = &d}},
                                     {{.name = "knurl", .work = closest, .user = &d}}};
    int n = 1;
#ifdef KN_WITH_SISL
    d.surface = sisl_surface(&d);
    rivals[0][1] = (bench_rival){.name = "SISL", .work = sisl_lines, .user = &d};
    rivals[1][1] = (bench_rival){.name = "SISL", .work = sisl_closest, .user = &d};
    n = 2;
#endif
    bench_compare(rivals[0], n, BENCH_THREAD);
    tell("line, surface", rivals[0], n);
    printf("  knurl: %zu points, %zu certified, %.1f boxes a line\n", d.found, d.certain, (double)d.boxes / QUERIES);
#ifdef KN_WITH_SISL
    printf("  SISL: %zu points, %zu curves, %zu failures\n", d.found_sisl, d.curves_sisl, d.failed_sisl);
#endif
    bench_compare(rivals[1], n, BENCH_THREAD);
    tell("closest point", rivals[1], n);
    printf("  knurl: %.1f boxes a point, certified within 1e-12 of the size\n", (double)d.boxes / QUERIES);
#ifdef KN_WITH_SISL
    int nearer = 0, farther = 0;
    for (int k = 0; k < QUERIES; k++) {
        nearer += d.distance[k] < d.distance_sisl[k] - 1e-8;
        farther += d.distance[k] > d.distance_sisl[k] + 1e-8;
    }
    printf("  SISL: %zu failures; knurl is nearer %d times and farther %d times of %d\n", d.failed_sisl, nearer,
           farther, QUERIES);
    freeSurf(d.surface);
#endif
    one_variable(&d);
    kn_ctx_destroy(d.ctx);
    return d.failed;
}
