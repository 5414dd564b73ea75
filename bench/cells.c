// SPDX-License-Identifier: Apache-2.0
// Memory and time for each cell, for ever more cells: `scale` over a bent square, into the sink that counts, into STL
// and into STEP (to /dev/null). The argument is the largest power of ten, 5 unless it says otherwise. Processor time,
// which other programs do not lengthen.
//
// The base is bilinear, and so is its direction in place of a normal: a scale's patches compose to degree 6 alone, so
// that a million cells, 16 million patches, stay within a file's entity numbers and within minutes.
#include "bench/bench.h"

#include <knurl/io.h>
#include <knurl/step.h>

typedef struct measured {
    double plan, run; // seconds of the processor
    size_t cells, peak;
} measured;

static double processor(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static kn_status make_base(kn_ctx *ctx, kn_spline *base, kn_spline *direction)
{
    const double knots[] = {0, 0, 1, 1}, *k[2] = {knots, knots};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    const double square[12] = {0, 0, 1000, 1000, 0, 1000, 0, 1000, 0, 30, 20, 0};
    const double up[12] = {0, 0.03, 0, 0.02, -0.02, 0, 0, 0.01, 1, 1, 1, 1};
    kn_status status = kn_spline_init(ctx, base, 2, 3, false, degree, count, k, square);
    return status == KN_OK ? kn_spline_init(ctx, direction, 2, 3, false, degree, count, k, up) : status;
}

// kind 0: counts; 1: STL; 2: STEP.
static kn_status measure(measured *m, int kind, int count)
{
    kn_ctx *ctx = NULL;
    if (kn_ctx_create(&ctx, &(kn_ctx_options){.threads = 2}) != KN_OK) return KN_ENOMEM;
    kn_spline base = {0}, direction = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_sink sink = {0};
    kn_status status = make_base(ctx, &base, &direction);
    if (status == KN_OK) status = kn_builtin_tile(ctx, &tile, "scale");
    size_t before = kn_ctx_counters(ctx).live_bytes;
    kn_job_options o = {.count = {count, count}, .direction = &direction, .mesh_tol = 1e4};
    double start = processor();
    if (status == KN_OK) status = kn_job_create(ctx, &job, &base, 1, &tile, &o);
    m->plan = processor() - start;
    if (status == KN_OK && kind == 0) status = kn_null_sink(ctx, &sink);
    if (status == KN_OK && kind == 1) status = kn_stl_sink(ctx, &sink, "/dev/null");
    if (status == KN_OK && kind == 2) status = kn_step_sink(ctx, &sink, "/dev/null", NULL);
    start = processor();
    if (status == KN_OK) status = kn_job_run(ctx, job, &sink, 1);
    m->run = processor() - start;
    m->peak = kn_ctx_counters(ctx).peak_bytes - before;
    m->cells = (size_t)count * (size_t)count;
    if (status != KN_OK) fprintf(stderr, "%s\n", kn_ctx_message(ctx));
    kn_sink_close(ctx, &sink);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base), kn_spline_clear(ctx, &direction);
    kn_ctx_destroy(ctx);
    return status;
}

int main(int argc, char **argv)
{
    static const char *const names[3] = {"count", "STL", "STEP"};
    static const int counts[4] = {32, 100, 316, 1000};
    int most = argc > 1 ? (int)strtol(argv[1], NULL, 10) : 5;
    printf("sink        cells   plan us/cell  compose and write us/cell  both, over that of 1e3  peak MiB\n");
    for (int kind = 0; kind < 3; kind++) {
        double first = 0.0;
        for (int power = 3; power <= most && power <= 6; power++) {
            measured m;
            if (measure(&m, kind, counts[power - 3]) != KN_OK) return 1;
            double n = (double)m.cells, each = (m.plan + m.run) / n;
            if (power == 3) first = each;
            printf("%-6s %10zu %14.2f %26.2f %23.2f %9.1f\n", names[kind], m.cells, 1e6 * m.plan / n, 1e6 * m.run / n,
                   each / first, (double)m.peak / 1048576.0);
            fflush(stdout);
        }
    }
    return 0;
}
