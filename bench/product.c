// SPDX-License-Identifier: Apache-2.0
// Products on one thread: Bezier surfaces of one and three components, small against large ones, and B-spline
// surfaces on their minimal knots, beside the plain convolution and the machine's peak.
#include "bench/bench.h"

#include <math.h>

#include <knurl/spline.h>

#include "kernel/convolve.h"
#include "kernel/bernstein.h"

enum { WORK = 2000, SHAPES = 9, SPLINE_COUNT = 20, SPLINE_DEGREE = 3, SHORT_RUNS = 500 };

typedef struct data {
    kn_ctx *ctx;
    kn_bezier a, b, out;
    kn_spline s, t, u;
    double *work, *sums; // of the kernel alone
    kn_convolution plan;
    long repeats;
    bool failed;
    double sink, peak_flops; // of one run of the machine's peak
} data;

// Runs in turn with the products: their rate as a part of the peak does not feel what else the machine does.
static void peak(void *user)
{
    data *d = user;
    d->peak_flops = 0.0;
    for (int i = 0; i < 3; i++) {
#if defined(__x86_64__)
        if (__builtin_cpu_supports("avx512f")) {
            d->peak_flops += bench_flops_avx512(&d->sink);
            continue;
        }
        if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
            d->peak_flops += bench_flops_avx2(&d->sink);
            continue;
        }
#endif
        d->peak_flops += bench_flops_plain(&d->sink);
    }
}

static void product(void *user)
{
    data *d = user;
    for (long i = 0; i < d->repeats; i++)
        if (kn_bezier_product(d->ctx, &d->out, &d->a, &d->b) != KN_OK) d->failed = true;
}

// The sums of products alone, operands packed already.
static void kernel(void *user)
{
    data *d = user;
    double *thin = d->work, *wide = thin + d->plan.thin_room, *sums = wide + d->plan.wide_room;
    for (long i = 0; i < d->repeats; i++) kn_convolution_run(&d->plan, sums, thin, wide, i % 2 ? -1.0 : 1.0);
}

static void plain(void *user)
{
    data *d = user;
    for (long i = 0; i < d->repeats; i++)
        kn_convolve_plain(d->sums, 2, d->a.coef, d->a.degree, d->b.coef, d->b.degree, i % 2 ? -1.0 : 1.0);
}

static void spline_product(void *user)
{
    data *d = user;
    for (long i = 0; i < d->repeats; i++)
        if (kn_spline_product(d->ctx, &d->u, &d->s, &d->t) != KN_OK) d->failed = true;
}

static void fill(double *x, size_t n, unsigned seed)
{
    for (size_t i = 0; i < n; i++) {
        seed = seed * 1664525u + 1013904223u;
        x[i] = (double)(seed >> 8) * 0x1p-23 - 1.0;
    }
}

static bool make(data *d, int m, int n, int ncomp)
{
    const int da[2] = {m, m}, db[2] = {n, n};
    d->failed = false;
    if (kn_bezier_init(d->ctx, &d->a, 2, ncomp, false, da) != KN_OK) return false;
    if (kn_bezier_init(d->ctx, &d->b, 2, ncomp, false, db) != KN_OK) return false;
    fill(d->a.coef, kn_bezier_count(&d->a) * (size_t)ncomp, 1);
    fill(d->b.coef, kn_bezier_count(&d->b) * (size_t)ncomp, 2);
    kn_convolution_init(&d->plan, kn_convolve_best(), 2, da, db);
    size_t room = d->plan.thin_room + d->plan.wide_room + d->plan.sum_room, step = (size_t)n + 1;
    d->work = aligned_alloc(64, (room * sizeof(double) + 63) / 64 * 64);
    d->sums = calloc((size_t)(m + n + 1) * (size_t)(m + n + 1), sizeof *d->sums);
    if (!d->work || !d->sums) return false;
    const size_t step_a[2] = {(size_t)m + 1, 1}, step_b[2] = {step, 1};
    const kn_bezier *thin = d->plan.swapped ? &d->b : &d->a, *wide = d->plan.swapped ? &d->a : &d->b;
    kn_convolution_pack_thin(&d->plan, d->work, thin->coef, d->plan.swapped ? step_b : step_a, true);
    kn_convolution_pack_wide(&d->plan, d->work + d->plan.thin_room, wide->coef, d->plan.swapped ? step_a : step_b,
                             true);
    kn_convolution_clear(&d->plan, d->work + d->plan.thin_room + d->plan.wide_room);
    double flops = (double)kn_bezier_count(&d->a) * (double)kn_bezier_count(&d->b);
    d->repeats = (long)(WORK * 1000.0 / (flops + 2000.0)) + 1;
    return true;
}

static void clear(data *d)
{
    kn_bezier_clear(d->ctx, &d->a);
    kn_bezier_clear(d->ctx, &d->b);
    free(d->work);
    free(d->sums);
    d->work = d->sums = NULL;
}

// The least time of a product in many short runs, in microseconds: some fall where nothing else runs.
static double least(data *d, double usual)
{
    double least = usual;
    d->repeats = (long)(50.0 / usual) + 1;
    for (int i = 0; i < SHORT_RUNS; i++) {
        double start = bench_now(BENCH_WALL);
        product(d);
        double us = (bench_now(BENCH_WALL) - start) / (double)d->repeats * 1e6;
        if (us < least) least = us;
    }
    return least;
}

static bool bezier_row(data *d, int m, int n, int ncomp, double best)
{
    if (!make(d, m, n, ncomp)) return false;
    bench_rival r[4] = {{"", peak, d, 0, 0}, {"", product, d, 0, 0}, {"", kernel, d, 0, 0}, {"", plain, d, 0, 0}};
    bench_compare(r, 4, BENCH_THREAD);
    double flops = 2.0 * pow(m + 1, 2) * pow(n + 1, 2), done = flops * (double)d->repeats / d->peak_flops;
    double part = ncomp * done * r[1].ratio, floor_us = ncomp * flops / best * 1e6;
    double us = r[1].seconds / (double)d->repeats * 1e6, sums = 100 * done * r[2].ratio;
    printf("%2d,%-2d x %2d,%-2d %5d %11.3f %8.3f %11.3f %11.3f %9.1f %8.1f%% %9.1f%%\n", m, m, n, n, ncomp, us,
           least(d, us), floor_us / part, floor_us, ncomp * r[1].ratio / r[3].ratio, 100 * part, sums);
    clear(d);
    return !d->failed;
}

static bool make_splines(data *d, int ncomp)
{
    double knots[SPLINE_COUNT + SPLINE_DEGREE + 1], *coef = malloc(2 * 400 * (size_t)ncomp * sizeof *coef);
    const double *const axes[2] = {knots, knots};
    const int degree[2] = {SPLINE_DEGREE, SPLINE_DEGREE}, count[2] = {SPLINE_COUNT, SPLINE_COUNT};
    if (!coef) return false;
    for (int i = 0; i <= SPLINE_COUNT + SPLINE_DEGREE; i++)
        knots[i] = i <= SPLINE_DEGREE ? 0 : i >= SPLINE_COUNT ? SPLINE_COUNT - SPLINE_DEGREE : i - SPLINE_DEGREE;
    fill(coef, 800 * (size_t)ncomp, 3);
    bool ok = kn_spline_init(d->ctx, &d->s, 2, ncomp, false, degree, count, axes, coef) == KN_OK &&
              kn_spline_init(d->ctx, &d->t, 2, ncomp, false, degree, count, axes, coef + 400 * ncomp) == KN_OK;
    free(coef);
    return ok;
}

static bool spline_row(data *d, int ncomp)
{
    if (!make_splines(d, ncomp)) return false;
    d->repeats = 20;
    bench_rival r = {"", spline_product, d, 0, 0};
    bench_compare(&r, 1, BENCH_THREAD);
    printf("bicubic %d x %d by the same, %d component%s: %.3f ms, %d x %d control points\n", SPLINE_COUNT,
           SPLINE_COUNT, ncomp, ncomp > 1 ? "s" : "", r.seconds / (double)d->repeats * 1e3, d->u.count[0],
           d->u.count[1]);
    kn_spline_clear(d->ctx, &d->s);
    kn_spline_clear(d->ctx, &d->t);
    return !d->failed;
}

int main(void)
{
    static const int shapes[SHAPES][3] = {{3, 3, 1}, {5, 5, 1}, {8, 8, 1},  {16, 16, 1}, {25, 25, 1},
                                          {3, 3, 3}, {3, 9, 1}, {3, 25, 1}, {3, 45, 1}};
    const char *isa;
    data d = {0};
    kn_ctx_options options = kn_ctx_defaults();
    options.threads = 1;
    if (kn_ctx_create(&d.ctx, &options) != KN_OK) return 1;
    double best = bench_peak_flops(&isa);
    bool ok = true;
    printf("peak of 1 thread, measured here: %.1f GFLOP/s (%s); products run %s\n", best / 1e9, isa,
           kn_convolve_level_name(kn_convolve_best()));
    printf("Bezier surfaces  comps  product us    least     at peak    floor us   x plain  of peak  sums alone\n");
    for (int i = 0; i < SHAPES && ok; i++) ok = bezier_row(&d, shapes[i][0], shapes[i][1], shapes[i][2], best);
    printf("least: of many short runs; floor: the multiply-adds at that peak; of peak: of the peak in the same "
           "rounds; at peak: floor / of peak, "
           "what the product takes where nothing else runs; sums alone: without packing and division\n");
    ok = ok && spline_row(&d, 1) && spline_row(&d, 3);
    printf("SISL has no product of surfaces: no peer in Debian. Medians of %d paired runs, processor time\n",
           BENCH_ROUNDS);
    kn_bezier_clear(d.ctx, &d.out);
    kn_spline_clear(d.ctx, &d.u);
    kn_ctx_destroy(d.ctx);
    if (!ok) fprintf(stderr, "bench/product: failed\n");
    return !ok;
}
