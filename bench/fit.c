// SPDX-License-Identifier: Apache-2.0
// Interpolation of a grid of points by a bicubic surface, beside SISL's s1537 where it is installed: the same points, the
// same parameters, free ends. And least squares, quasi-interpolation and parameters of the same data.
#include <math.h>

#include <knurl/fit.h>

#include "bench/bench.h"

#ifdef KN_WITH_SISL
#include <sisl.h>
#define PEER 1
#endif

enum { N = 100, P = 3, COARSE = 50 };

typedef struct data {
    kn_ctx *ctx;
    kn_spline s;
    double points[N * N * 3], sites[N], knots[N + P + 1], coarse[COARSE + P + 1];
} data;

static void check(kn_status status)
{
    if (status != KN_OK) exit(1);
}

static void interpolate(void *user)
{
    data *w = user;
    check(kn_fit_interpolate(w->ctx, &w->s, 2, 3, (int[]){P, P}, (int[]){N, N},
                             (const double *[]){w->knots, w->knots}, (const double *[]){w->sites, w->sites},
                             w->points));
}

static void least_squares(void *user)
{
    data *w = user;
    check(kn_fit_least_squares(w->ctx, &w->s, NULL, 2, 3, (int[]){P, P}, (int[]){COARSE, COARSE},
                               (const double *[]){w->coarse, w->coarse}, (int[]){N, N},
                               (const double *[]){w->sites, w->sites}, w->points, NULL));
}

static kn_status wave(void *user, double *value, const double *at)
{
    (void)user;
    value[0] = at[0], value[1] = at[1], value[2] = at[0] * at[1];
    return KN_OK;
}

static void quasi(void *user)
{
    data *w = user;
    check(kn_fit_quasi(w->ctx, &w->s, 2, 3, (int[]){P, P}, (int[]){N, N}, (const double *[]){w->knots, w->knots},
                       wave, NULL));
}

#ifdef PEER
static void sisl(void *user)
{
    data *w = user;
    SISLSurf *s = NULL;
    int status;
    s1537(w->points, N, N, 3, w->sites, w->sites, 0, 0, 0, 0, P + 1, P + 1, 1, 1, &s, &status);
    if (status < 0) exit(1);
    freeSurf(s);
}
#endif

int main(void)
{
    static data w;
    check(kn_ctx_create(&w.ctx, NULL));
    for (int i = 0; i < N; i++) w.sites[i] = (double)i / (N - 1);
    for (int i = 0; i < N * N; i++) {
        double u = w.sites[i / N], v = w.sites[i % N];
        w.points[3 * i] = u, w.points[3 * i + 1] = v, w.points[3 * i + 2] = sin(5 * u) * cos(3 * v);
    }
    check(kn_fit_averaged_knots(w.ctx, w.knots, P, N, N, w.sites));
    check(kn_fit_averaged_knots(w.ctx, w.coarse, P, COARSE, N, w.sites));
    bench_rival rivals[] = {
        {.name = "interpolation", .work = interpolate, .user = &w},
        {.name = "least squares on 50 x 50", .work = least_squares, .user = &w},
        {.name = "quasi-interpolation", .work = quasi, .user = &w},
#ifdef PEER
        {.name = "SISL s1537", .work = sisl, .user = &w},
#endif
    };
    int n = (int)(sizeof rivals / sizeof *rivals);
    bench_compare(rivals, n, BENCH_THREAD);
    printf("bicubic, %d x %d points in space; median of %d runs in turn; ratio: interpolation's time / this one's\n",
           N, N, BENCH_ROUNDS);
    for (int i = 0; i < n; i++)
        printf("%-26s %9.3f ms   %6.3f\n", rivals[i].name, 1e3 * rivals[i].seconds, rivals[i].ratio);
    kn_spline_clear(w.ctx, &w.s);
    kn_ctx_destroy(w.ctx);
    return 0;
}
