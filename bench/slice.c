// SPDX-License-Identifier: Apache-2.0
// Slicing: layers and contour points a second, and memory for ever more cells: `knurl` around a cylinder, a hundred
// cells of it cut by each layer at most. The argument is the largest power of ten of cells, 4 by default.
// Processor time of one thread. No library in Debian slices such objects: lib3mf stores slices and makes none.
#include "bench/bench.h"

#include <stdlib.h>

#include <knurl/construct.h>
#include <knurl/io.h>
#include <knurl/slice.h>

typedef struct tally {
    size_t loops, open, points;
} tally;

static kn_status count(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    (void)ctx;
    tally *t = user;
    t->loops += layer->nloops, t->open += layer->nopen;
    for (size_t i = 0; i < layer->nloops; i++) t->points += layer->loops[i].npoints;
    return KN_OK;
}

// 20 layers through `cells` cells, ten around for each hundred up to a hundred around.
static kn_status measure(size_t cells)
{
    kn_ctx *ctx = NULL;
    if (kn_ctx_create(&ctx, &(kn_ctx_options){.threads = 1}) != KN_OK) return KN_ENOMEM;
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    tally t = {0};
    kn_slice_job_report report = {0};
    const double origin[3] = {0, 0, 0};
    int around = cells >= 10000 ? 100 : 20, along = (int)(cells / (size_t)around);
    const double axis[3] = {0, 0, 6.2831853 / around * along}; // square cells
    kn_status status = kn_construct_cylinder(ctx, &base, origin, axis, 1.0);
    if (status == KN_OK) status = kn_builtin_tile(ctx, &tile, "knurl");
    kn_job_options o = {.count = {around, along}, .height = 1.0 / around, .normal_tol = 1e-3, .max_degree = 40};
    if (status == KN_OK) status = kn_job_create(ctx, &job, &base, 1, &tile, &o);
    size_t before = kn_ctx_counters(ctx).live_bytes;
    double step = axis[2] / 21;
    kn_slice_options s = {.first = step * 1.01, .step = step, .count = 20, .tol = 0.01 / around};
    const kn_job *jobs[] = {job};
    double start = bench_now(BENCH_THREAD);
    if (status == KN_OK) status = kn_slice_job(ctx, jobs, 1, &s, count, &t, &report);
    double seconds = bench_now(BENCH_THREAD) - start;
    double more = (double)(kn_ctx_counters(ctx).peak_bytes - before) - 8.0 * (double)cells;
    if (status != KN_OK) fprintf(stderr, "%s\n", kn_ctx_message(ctx));
    printf("| %zu | %.3g | %.3g | %zu | %zu | %zu | %.1f |\n", cells, 20 / seconds, (double)t.points / seconds,
           report.cells, t.loops, t.open, 1e-6 * more);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    kn_ctx_destroy(ctx);
    return status;
}

int main(int argc, char **argv)
{
    int last = argc > 1 ? (int)strtol(argv[1], NULL, 10) : 4;
    size_t cells = 1000;
    printf("| cells | layers/s | points/s | cells composed | contours | open | MB beyond 8 bytes a cell |\n");
    printf("|---|---|---|---|---|---|---|\n");
    for (int power = 3; power <= last; power++, cells *= 10)
        if (measure(cells) != KN_OK) return 1;
    return 0;
}
