// SPDX-License-Identifier: Apache-2.0
// Support positions of points about a surface, one thread: all of them, certified, by the inverse of a shell; beside
// it the closest points of the surface, certified, and SISL's, where it is installed: s1954 searches, s1775 iterates
// from a guess that is 0.05 of the domain away. The surface: one bicubic patch, and 20 x 20 control points.
#include "bench/bench.h"

#include <knurl/shell.h>
#include <knurl/solve.h>

#include <math.h>

#ifdef KN_WITH_SISL
#include <sisl.h>
#endif

enum { MOST = 20, DEGREE = 3, DIM = 3, QUERIES = 200, RIVALS = 4 };
static const double HEIGHT = 0.2;

typedef struct data {
    kn_ctx *ctx;
    int count;
    kn_spline s;
    kn_shell_inverse *inverse;
    double knots[MOST + DEGREE + 1], coef[DIM * MOST * MOST], uvw[QUERIES][3], point[QUERIES][DIM];
    size_t places, certified;
    double distance, off; // the largest error of a parameter, in boxes and of s1775
    bool failed;
#ifdef KN_WITH_SISL
    SISLSurf *surface;
    size_t failed_sisl;
#endif
} data;

static double noise(unsigned long long *state)
{
    *state = *state * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(*state >> 11) * 0x1p-53;
}

static void fill(data *d, int count, kn_shell **shell)
{
    unsigned long long state = 1;
    int n = count * count, spans = count - DEGREE;
    d->count = count;
    for (int i = 0; i < count + DEGREE + 1; i++) d->knots[i] = i <= DEGREE ? 0.0 : i >= count ? spans : i - DEGREE;
    for (int i = 0; i < n; i++) {
        d->coef[i] = i / count;
        d->coef[n + i] = i % count - 0.02 * (i / count) * (i / count);
        d->coef[2 * n + i] = 0.5 * noise(&state);
    }
    d->s = (kn_spline){.nvars = 2,
                       .ncomp = 3,
                       .degree = {DEGREE, DEGREE},
                       .count = {count, count},
                       .knots = {d->knots, d->knots},
                       .coef = d->coef};
    if (kn_shell_create(d->ctx, shell, &d->s, NULL) != KN_OK) d->failed = true;
    for (int k = 0; k < QUERIES && !d->failed; k++) {
        double *at = d->uvw[k];
        for (int v = 0; v < 2; v++) at[v] = spans * noise(&state);
        at[2] = HEIGHT * (2.0 * noise(&state) - 1.0);
        if (kn_shell_eval(d->ctx, d->point[k], NULL, *shell, at[0], at[1], at[2]) != KN_OK) d->failed = true;
    }
}

static void support(void *user)
{
    data *d = user;
    d->places = d->certified = 0;
    d->distance = 0.0;
    for (int k = 0; k < QUERIES; k++) {
        kn_support *places = NULL;
        size_t n = 0;
        bool complete = false;
        if (kn_shell_support(d->ctx, &places, &n, &complete, d->inverse, d->point[k]) != KN_OK || !complete || n == 0)
            d->failed = true;
        for (size_t i = 0; i < n; i++) {
            d->certified += places[i].certified;
            for (int v = 0; v < 3; v++) d->distance = fmax(d->distance, places[i].error[v]);
        }
        d->places += n;
        kn_free(d->ctx, places);
    }
}

static void closest(void *user)
{
    data *d = user;
    for (int k = 0; k < QUERIES; k++) {
        kn_closest *best = NULL;
        size_t n = 0;
        if (kn_solve_closest(d->ctx, &best, &n, NULL, NULL, &d->s, d->point[k], NULL) != KN_OK || n == 0)
            d->failed = true;
        kn_free(d->ctx, best);
    }
}

#ifdef KN_WITH_SISL
static SISLSurf *sisl_surface(const data *d)
{
    double knots[2][MOST + DEGREE + 1], vertices[MOST * MOST * DIM];
    int n = d->count;
    for (int i = 0; i < 2; i++) memcpy(knots[i], d->knots, sizeof d->knots);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int c = 0; c < DIM; c++) vertices[(j * n + i) * DIM + c] = d->coef[c * n * n + i * n + j];
    return newSurf(n, n, DEGREE + 1, DEGREE + 1, knots[0], knots[1], vertices, 1, DIM, 1);
}

static void sisl_search(void *user)
{
    data *d = user;
    d->failed_sisl = 0;
    for (int k = 0; k < QUERIES; k++) {
        int points = 0, ncurves = 0, status = 0;
        double *parameters = NULL;
        SISLIntcurve **curves = NULL;
        s1954(d->surface, d->point[k], DIM, 1e-15, 1e-9, &points, &parameters, &ncurves, &curves, &status);
        d->failed_sisl += status < 0 || points == 0;
        free(parameters);
        if (curves) freeIntcrvlist(curves, ncurves);
    }
}

static void sisl_iterate(void *user)
{
    data *d = user;
    double end = d->count - DEGREE, lo[2] = {0.0, 0.0}, hi[2] = {end, end}, guess[2], found[2];
    d->off = 0.0;
    for (int k = 0; k < QUERIES; k++) {
        int status = 0;
        for (int v = 0; v < 2; v++) {
            double step = 0.05 * end * ((k >> v) % 2 ? 1.0 : -1.0);
            guess[v] = fmin(fmax(d->uvw[k][v] + step, 0.0), end);
        }
        s1775(d->surface, d->point[k], DIM, 1e-12, lo, hi, guess, found, &status);
        for (int v = 0; v < 2; v++) d->off = fmax(d->off, fabs(found[v] - d->uvw[k][v]));
    }
}
#endif

static bool measure(kn_ctx *ctx, int count)
{
    static data d;
    kn_shell *shell = NULL;
    d = (data){.ctx = ctx};
    fill(&d, count, &shell);
    double start = bench_now(BENCH_THREAD);
    if (d.failed || kn_shell_inverse_create(ctx, &d.inverse, shell, -HEIGHT, HEIGHT) != KN_OK) {
        printf("%s\n", kn_ctx_message(ctx));
        kn_shell_destroy(ctx, shell);
        return false;
    }
    double prepared = bench_now(BENCH_THREAD) - start;
    bench_rival rivals[RIVALS] = {{.name = "support", .work = support, .user = &d},
                                  {.name = "closest", .work = closest, .user = &d}};
    int n = 2;
#ifdef KN_WITH_SISL
    d.surface = sisl_surface(&d);
    rivals[n++] = (bench_rival){.name = "SISL s1954", .work = sisl_search, .user = &d};
    rivals[n++] = (bench_rival){.name = "SISL s1775", .work = sisl_iterate, .user = &d};
#endif
    bench_compare(rivals, n, BENCH_THREAD);
    printf("bicubic, %d x %d control points; the inverse is made in %.2f ms\n", count, count, 1e3 * prepared);
    for (int i = 0; i < n; i++)
        printf("  %-12s %8.1f us a point, %.2f times support's\n", rivals[i].name, 1e6 * rivals[i].seconds / QUERIES,
               1.0 / rivals[i].ratio);
    printf("  support: %zu places of %d points, %zu certified, within %.1e of a parameter\n", d.places, QUERIES,
           d.certified, d.distance);
#ifdef KN_WITH_SISL
    printf("  SISL: s1954 fails %zu times; s1775 is off by %.1e at most\n", d.failed_sisl, d.off);
    freeSurf(d.surface);
#endif
    kn_shell_inverse_destroy(ctx, d.inverse);
    kn_shell_destroy(ctx, shell);
    return !d.failed;
}

int main(void)
{
    kn_ctx *ctx = NULL;
    if (kn_ctx_create(&ctx, NULL) != KN_OK) return 1;
    bool fine = measure(ctx, 4) && measure(ctx, MOST);
    kn_ctx_destroy(ctx);
    return !fine;
}
