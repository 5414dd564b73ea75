// SPDX-License-Identifier: Apache-2.0
// Patches of degree 24 made splines of degree 5 and of cubics, with edges and certificates: kn_fit_limit_degree with
// and without an angle to keep, and the arithmetic that its transforms alone would be at the machine's peak.
#include <math.h>

#include <knurl/fit.h>

#include "bench/bench.h"

enum { DEGREE = 24, PATCHES = 4, CASES = 4 };

typedef struct work {
    kn_ctx *ctx;
    const kn_bezier *patches;
    kn_fit_limits limits;
    size_t points, spans;
} work;

static void check(kn_status status)
{
    if (status != KN_OK) exit(1);
}

static double random_number(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

// Gentle relief over the unit square, as what composes does.
static void make_patch(kn_ctx *ctx, kn_bezier *out, uint64_t *state)
{
    check(kn_bezier_init(ctx, out, 2, 3, false, (int[]){DEGREE, DEGREE}));
    size_t n = kn_bezier_count(out), m = DEGREE + 1;
    double phase = 6.0 * random_number(state), wave = 2.0 + 3.0 * random_number(state);
    for (size_t i = 0; i < n; i++) {
        double u = (double)(i / m) / DEGREE, v = (double)(i % m) / DEGREE;
        out->coef[i] = u, out->coef[n + i] = v;
        out->coef[2 * n + i] = 0.3 * sin(wave * u + phase) * cos(wave * v);
    }
}

static void limit(void *user)
{
    work *w = user;
    w->points = w->spans = 0;
    for (int i = 0; i < PATCHES; i++) {
        kn_spline out = {0}, edges[4] = {{0}, {0}, {0}, {0}};
        kn_fit_limited report;
        check(kn_fit_limit_degree(w->ctx, &out, edges, &report, &w->patches[i], &w->limits));
        w->points += kn_spline_count(&out);
        w->spans += (size_t)report.spans[0] * (size_t)report.spans[1];
        kn_spline_clear(w->ctx, &out);
        for (int e = 0; e < 4; e++) kn_spline_clear(w->ctx, &edges[e]);
    }
}

// Operations of one pass over a patch on `spans` by `spans` spans: the map along both variables, the piece on its spans
// and the fit raised to its degrees.
static double flops(double spans, double p)
{
    double m = DEGREE + 1, k = (p - 1) * spans + 2, all = spans * m, one = 3.0 * 2.0;
    return one *
           (k * m * m + k * k * m + all * m * m + all * all * m + spans * spans * (p + 1) * (m - p) * (m + p + 1));
}

int main(void)
{
    kn_ctx *ctx;
    kn_bezier patches[PATCHES] = {{0}};
    uint64_t state = 1;
    check(kn_ctx_create(&ctx, NULL));
    for (int i = 0; i < PATCHES; i++) make_patch(ctx, &patches[i], &state);
    static const char *const names[CASES] = {"degree 5, no angle", "degree 5, 1 degree", "cubic, no angle",
                                             "cubic, 1 degree"};
    work w[CASES];
    bench_rival rivals[CASES];
    for (int i = 0; i < CASES; i++) {
        w[i] = (work){.ctx = ctx, .patches = patches};
        w[i].limits = (kn_fit_limits){.max_degree = i < 2 ? 11 : 3,
                                      .tolerance = 1e-3,
                                      .quantum = 0x1p-20,
                                      .angle = i % 2 ? 0.5 * 0.017453292519943295 : 0.0};
        rivals[i] = (bench_rival){.name = names[i], .work = limit, .user = &w[i]};
    }
    bench_compare(rivals, CASES, BENCH_THREAD);
    const char *isa;
    double peak = bench_peak_flops(&isa);
    printf("%d patches of degree %d, one thread; peak %.1f Gflop/s (%s)\n", PATCHES, DEGREE, 1e-9 * peak, isa);
    for (int i = 0; i < CASES; i++) {
        double spans = sqrt((double)w[i].spans / PATCHES), p = i < 2 ? 5.0 : 3.0;
        printf("%-20s %7.3f ms a patch, %6.1f points, %5.1f spans; one pass at the peak %.4f ms\n", rivals[i].name,
               1e3 * rivals[i].seconds / PATCHES, (double)w[i].points / PATCHES, spans * spans,
               1e3 * flops(spans, p) / peak);
    }
    for (int i = 0; i < PATCHES; i++) kn_bezier_clear(ctx, &patches[i]);
    kn_ctx_destroy(ctx);
    return 0;
}
