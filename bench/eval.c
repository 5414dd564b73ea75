// SPDX-License-Identifier: Apache-2.0
// Points per second of a bicubic B-spline surface, 20 x 20 control points, one thread: values and first partials at
// random parameters, values on a grid, and point by point; SISL's s1421 and s1506 in the same run where it is
// installed.
#include "bench/bench.h"

#include <knurl/spline.h>

#include "kernel/eval.h"

#ifdef KN_WITH_SISL
#include <sisl.h>
#endif

enum {
    COUNT = 20,
    DEGREE = 3,
    DIM = 3,
    KNOTS = COUNT + DEGREE + 1,
    FEW = 10000,
    POINTS = 100000,
    GRID = 200,
    RIVALS = 8
};

// What one point costs, whoever computes it well. Values: per variable 15 for the Bernstein polynomials and 28 for the
// B-splines; 16 products, 12 sums, 4 products and 3 sums for each component. With partials: twice the B-splines and
// the inner sums, three outer ones. On a grid: 4 products and 3 sums; all else is spread over many points.
enum { FLOPS = 2 * (15 + 28) + DIM * 35, FLOPS_PARTIALS = 2 * (24 + 56) + DIM * (56 + 21), FLOPS_GRID = DIM * 7 };

typedef struct data {
    kn_ctx *ctx;
    kn_spline s;
    double knots[KNOTS], *at, *out, *memory, grid[GRID];
    bool partials; // what the batched kernels are asked for
    size_t npoints;
    kn_eval_function f;
    const double *axes[2];
    kn_eval_plan plan;
    bool failed;
#ifdef KN_WITH_SISL
    SISLSurf *surface;
    double normals[3 * GRID * GRID];
#endif
} data;

typedef struct at_level {
    data *d;
    kn_eval_level level;
} at_level;

static void planned(void *user)
{
    at_level *a = user;
    kn_eval_planned(a->d->out, &a->d->plan, a->d->npoints, a->d->at, a->d->partials, a->level);
}

static void plain(void *user)
{
    data *d = user;
    kn_eval_plain(d->out, &d->f, d->npoints, d->at, d->partials);
}

static void batch(void *user)
{
    data *d = user;
    if (kn_spline_eval_batch(d->ctx, d->out, &d->s, d->npoints, d->at) != KN_OK) d->failed = true;
}

static void batch_partials(void *user)
{
    data *d = user;
    if (kn_spline_eval_batch_partials(d->ctx, d->out, &d->s, d->npoints, d->at) != KN_OK) d->failed = true;
}

static void on_grid(void *user)
{
    data *d = user;
    const size_t n[2] = {GRID, GRID};
    const double *const at[2] = {d->grid, d->grid};
    if (kn_spline_eval_grid(d->ctx, d->out, &d->s, n, at) != KN_OK) d->failed = true;
}

static void one_by_one(void *user)
{
    data *d = user;
    for (size_t i = 0; i < d->npoints; i++)
        if (kn_spline_eval(d->ctx, d->out + DIM * i, &d->s, d->at + 2 * i) != KN_OK) d->failed = true;
}

#ifdef KN_WITH_SISL
static void sisl(void *user)
{
    data *d = user;
    double normal[3];
    int left_u = 0, left_v = 0, status = 0;
    for (size_t i = 0; i < d->npoints; i++) {
        s1421(d->surface, 0, d->at + 2 * i, &left_u, &left_v, d->out + DIM * i, normal, &status);
        if (status < 0) d->failed = true;
    }
}

static void sisl_partials(void *user)
{
    data *d = user;
    double normal[3];
    int left_u = 0, left_v = 0, status = 0;
    for (size_t i = 0; i < d->npoints; i++) {
        s1421(d->surface, 1, d->at + 2 * i, &left_u, &left_v, d->out + 3 * DIM * i, normal, &status);
        if (status < 0) d->failed = true;
    }
}

static void sisl_grid(void *user)
{
    data *d = user;
    int status = 0;
    s1506(d->surface, 0, GRID, d->grid, GRID, d->grid, d->out, d->normals, &status);
    if (status < 0) d->failed = true;
}

// SISL's vertices: components fastest, then the first variable.
static SISLSurf *sisl_surface(const data *d)
{
    double knots[2][KNOTS], vertices[COUNT * COUNT * DIM];
    for (int i = 0; i < 2; i++) memcpy(knots[i], d->knots, sizeof d->knots);
    for (int i = 0; i < COUNT; i++)
        for (int j = 0; j < COUNT; j++)
            for (int c = 0; c < DIM; c++)
                vertices[(j * COUNT + i) * DIM + c] = d->s.coef[(c * COUNT + i) * COUNT + j];
    return newSurf(COUNT, COUNT, DEGREE + 1, DEGREE + 1, knots[0], knots[1], vertices, 1, DIM, 1);
}
#endif

static double uniform(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static bool make(data *d)
{
    uint64_t seed = 1;
    double coef[COUNT * COUNT * DIM];
    const double *const knots[2] = {d->knots, d->knots};
    const int degree[2] = {DEGREE, DEGREE}, count[2] = {COUNT, COUNT};
    kn_ctx_options options = kn_ctx_defaults();
    options.threads = 1;
    for (int i = 0; i < KNOTS; i++) d->knots[i] = i <= DEGREE ? 0 : i >= COUNT ? COUNT - DEGREE : i - DEGREE;
    for (int i = 0; i < COUNT * COUNT * DIM; i++) coef[i] = uniform(&seed);
    if (kn_ctx_create(&d->ctx, &options) != KN_OK) return false;
    if (kn_spline_init(d->ctx, &d->s, 2, DIM, false, degree, count, knots, coef) != KN_OK) return false;
    d->axes[0] = d->s.knots[0], d->axes[1] = d->s.knots[1];
    d->f = (kn_eval_function){2, DIM, false, d->s.degree, d->s.count, d->axes, d->s.coef};
    d->at = malloc(2 * POINTS * sizeof *d->at);
    d->out = malloc(3 * DIM * POINTS * sizeof *d->out); // the largest: with partials
    d->memory = aligned_alloc(64, (kn_eval_room(&d->f) * sizeof *d->memory + 63) / 64 * 64);
    if (!d->at || !d->out || !d->memory) return false;
    for (int i = 0; i < 2 * POINTS; i++) d->at[i] = (COUNT - DEGREE) * uniform(&seed);
    for (int i = 0; i < GRID; i++) d->grid[i] = (COUNT - DEGREE) * (double)i / (GRID - 1);
    kn_eval_prepare(&d->plan, &d->f, d->memory);
#ifdef KN_WITH_SISL
    d->surface = sisl_surface(d);
    if (!d->surface) return false;
#endif
    return true;
}

static void clear(data *d)
{
    free(d->at);
    free(d->out);
    free(d->memory);
    kn_spline_clear(d->ctx, &d->s);
    kn_ctx_destroy(d->ctx);
#ifdef KN_WITH_SISL
    if (d->surface) freeSurf(d->surface);
#endif
}

// One table. count: points of a run, each of `flops` operations and `numbers` numbers in and out.
static void print(const char *title, const bench_rival *rivals, int n, bool has_sisl, double count, double flops,
                  double numbers)
{
    const char *isa;
    double peak = bench_peak_flops(&isa), bytes = bench_peak_bytes();
    printf("%s\n%-30s %9s %10s %9s %8s %8s\n", title, "", "Mpoint/s", has_sisl ? "x SISL" : "x first", "GFLOP/s",
           "of peak", "of GB/s");
    for (int i = 0; i < n; i++) {
        double rate = count / rivals[i].seconds;
        printf("%-30s %9.2f %10.2f %9.2f %7.1f%% %7.1f%%\n", rivals[i].name, rate / 1e6, rivals[i].ratio,
               rate * flops / 1e9, 100 * rate * flops / peak, 100 * rate * numbers * sizeof(double) / bytes);
    }
    printf("peak of 1 thread, measured here: %.1f GFLOP/s (%s), %.1f GB/s\n\n", peak / 1e9, isa, bytes / 1e9);
}

// The batched kernels at each level.
static int add_levels(bench_rival *rivals, int n, at_level *levels, data *d)
{
    static const char *const names[] = {"", "kernel, SSE2", "kernel, AVX2", "kernel, AVX-512"};
    for (kn_eval_level l = KN_EVAL_SSE2; l <= kn_eval_best(); l++) {
        levels[l] = (at_level){d, l};
        rivals[n++] = (bench_rival){names[l], planned, &levels[l], 0, 0};
    }
    return n;
}

static void values(data *d, bool has_sisl)
{
    bench_rival rivals[RIVALS];
    at_level levels[KN_EVAL_LEVELS];
    int n = 0;
#ifdef KN_WITH_SISL
    rivals[n++] = (bench_rival){"SISL s1421", sisl, d, 0, 0};
#endif
    rivals[n++] = (bench_rival){"kn_spline_eval", one_by_one, d, 0, 0};
    rivals[n++] = (bench_rival){"plain reference", plain, d, 0, 0};
    n = add_levels(rivals, n, levels, d);
    rivals[n++] = (bench_rival){"kn_spline_eval_batch", batch, d, 0, 0};
    bench_compare(rivals, n, BENCH_THREAD);
    char title[64];
    snprintf(title, sizeof title, "values at %zu random points", d->npoints);
    print(title, rivals, n, has_sisl, (double)d->npoints, FLOPS, 2 + DIM);
}

static void partials(data *d, bool has_sisl)
{
    bench_rival rivals[RIVALS];
    at_level levels[KN_EVAL_LEVELS];
    int n = 0;
    d->partials = true;
#ifdef KN_WITH_SISL
    rivals[n++] = (bench_rival){"SISL s1421", sisl_partials, d, 0, 0};
#endif
    n = add_levels(rivals, n, levels, d);
    rivals[n++] = (bench_rival){"kn_spline_eval_batch_partials", batch_partials, d, 0, 0};
    bench_compare(rivals, n, BENCH_THREAD);
    char title[64];
    snprintf(title, sizeof title, "values and first partials at %zu random points", d->npoints);
    print(title, rivals, n, has_sisl, (double)d->npoints, FLOPS_PARTIALS, 2 + 3 * DIM);
    d->partials = false;
}

static void grid(data *d, bool has_sisl)
{
    bench_rival rivals[RIVALS];
    int n = 0;
#ifdef KN_WITH_SISL
    rivals[n++] = (bench_rival){"SISL s1506", sisl_grid, d, 0, 0};
#endif
    rivals[n++] = (bench_rival){"kn_spline_eval_grid", on_grid, d, 0, 0};
    bench_compare(rivals, n, BENCH_THREAD);
    print("values on a grid of 200 x 200", rivals, n, has_sisl, (double)GRID * GRID, FLOPS_GRID, DIM);
}

int main(void)
{
    static data d;
    bool has_sisl = false;
    if (!make(&d)) {
        fprintf(stderr, "bench/eval: out of memory\n");
        return 1;
    }
#ifdef KN_WITH_SISL
    has_sisl = true;
#endif
    printf(
        "bicubic surface, %d x %d control points, %d components, 1 thread, %s; medians of %d paired runs, processor "
        "time\n\n",
        COUNT, COUNT, DIM, kn_eval_level_name(kn_eval_best()), BENCH_ROUNDS);
    if (!has_sisl) printf("SISL: not built in (libsisl-dev), no ratio to it\n");
    const size_t npoints[] = {FEW, POINTS}; // in the second-level cache, and beyond it
    for (int i = 0; i < 2; i++) {
        d.npoints = npoints[i];
        values(&d, has_sisl);
        partials(&d, has_sisl);
    }
    grid(&d, has_sisl);
    clear(&d);
    return d.failed;
}
