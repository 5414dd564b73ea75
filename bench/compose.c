// SPDX-License-Identifier: Apache-2.0
// Composed patches per second of a job into a sink that drops them: chain links over a bent bicubic patch, by matrix
// and by symbolic composition of every cell, on one thread and on two; the matrix product against the machine's peak;
// whole bicubic tile patches in pieces of degrees (3,3,1) and (8,8,1) on one thread and on two; composed and
// tessellated triangles per second; and the time from nothing to a closed STL file of a million triangles.
#include "bench/bench.h"

#include "kernel/gemm.h"

#include <knurl/io.h>

#include <pthread.h>

enum { CELLS = 8, ROWS = 48 }; // ROWS: of the product measured by itself, 16 cells of 3 components

typedef struct task {
    kn_ctx *ctx;
    const kn_job *job;
    bool failed;
} task;

static kn_status drop(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx, (void)block, (void)product;
    *(size_t *)user += block->count;
    return KN_OK;
}

static void run(void *user)
{
    task *t = user;
    size_t count = 0;
    kn_sink sink = {.user = &count, .commit = drop};
    if (kn_job_run(t->ctx, t->job, &sink, 1) != KN_OK || count != kn_job_describe(t->job).patches) t->failed = true;
}

static kn_status make_base(kn_ctx *ctx, kn_spline *out)
{
    const double knots[] = {0, 0, 0, 0, 1, 1, 1, 1}, *k[2] = {knots, knots};
    const int degree[2] = {3, 3}, count[2] = {4, 4};
    double coef[48];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            coef[4 * i + j] = i;
            coef[16 + 4 * i + j] = j - 0.02 * i * i;
            coef[32 + 4 * i + j] = 0.05 * (i * i - i * j);
        }
    return kn_spline_init(ctx, out, 2, 3, false, degree, count, k, coef);
}

typedef struct product {
    double *c, *a, *packed, *work, **to;
    const double **from;
    size_t k, n;
} product;

static void multiply(void *user)
{
    product *p = user;
    for (int i = 0; i < 200; i++) kn_gemm(p->to, p->from, ROWS, p->packed, p->k, p->n, p->work);
}

// The product of one tile patch with 16 cells: k control points of S and n, n composed ones.
static double product_rate(size_t k, size_t n)
{
    product p = {calloc(ROWS * n, sizeof(double)),
                 calloc(ROWS * k, sizeof(double)),
                 calloc(kn_gemm_room(k, n), sizeof(double)),
                 calloc(ROWS * k, sizeof(double)),
                 calloc(ROWS, sizeof(double *)),
                 calloc(ROWS, sizeof(double *)),
                 k,
                 n};
    if (!p.c || !p.a || !p.packed || !p.work || !p.to || !p.from) exit(1);
    for (size_t i = 0; i < ROWS; i++) {
        p.to[i] = p.c + i * n;
        p.from[i] = p.a + i * k;
    }
    bench_rival rival = {.name = "product", .work = multiply, .user = &p};
    bench_compare(&rival, 1, BENCH_THREAD);
    free(p.c), free(p.a), free(p.packed), free(p.work), free(p.to), free(p.from);
    return 200.0 * 2.0 * ROWS * (double)k * (double)n / rival.seconds;
}

// ---- whole bicubic tile patches ----

// u and v depend on both variables by their whole degree, so that the patch composes to seven times its own.
static kn_status make_bump(kn_ctx *ctx, kn_tile *tile)
{
    const double knots[] = {0, 0, 0, 0, 1, 1, 1, 1}, *k[2] = {knots, knots};
    const int degree[2] = {3, 3}, count[2] = {4, 4};
    double coef[48];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double bend = i == 1 && j == 2 ? 0.05 : 0.0;
            coef[4 * i + j] = i / 3.0 + bend;
            coef[16 + 4 * i + j] = j / 3.0 - bend;
            coef[32 + 4 * i + j] = i % 3 && j % 3 ? 0.9 : 0.1;
        }
    kn_spline s = {0};
    kn_status status = kn_spline_init(ctx, &s, 2, 3, false, degree, count, k, coef);
    if (status == KN_OK) status = kn_tile_init(ctx, tile, "bump", 1);
    if (status == KN_OK) status = kn_tile_add(ctx, tile, 0, &s);
    kn_spline_clear(ctx, &s);
    return status;
}

// What the peak is measured with, run in turn with the job: what slows one slows the other.
typedef struct arithmetic {
    bench_flops work;
    double flops, sink;
} arithmetic;

static void calculate(void *user)
{
    arithmetic *a = user;
    a->flops = 0.0;
    for (int i = 0; i < 20; i++) a->flops += a->work(&a->sink);
}

static void *calculate_beside(void *user)
{
    calculate(user);
    return NULL;
}

// The same arithmetic on two threads at once, which share nothing: what two processors can gain.
static void calculate_twice(void *user)
{
    arithmetic *a = user, other = {.work = a->work};
    pthread_t thread;
    bool two = pthread_create(&thread, NULL, calculate_beside, &other) == 0;
    calculate(a);
    if (two)
        (void)pthread_join(thread, NULL);
    else
        calculate(&other);
}

// Patches per second with pieces of the degrees that n gets: in processor time of one thread, with what that is of
// the peak; and on the clock on one and two threads.
static kn_status compose_whole(kn_ctx *ctx[2], const kn_spline *base, const kn_tile *tile, kn_normal_method normal,
                               int count, bool *failed)
{
    kn_job *job = NULL;
    kn_job_options o = {.count = {count, count}, .normal_tol = 1e-3, .max_degree = KN_MAX_DEGREE, .normal = normal};
    kn_status status = kn_job_create(ctx[1], &job, base, 1, tile, &o);
    if (status != KN_OK) return status;
    kn_job_report r = kn_job_describe(job);
    const kn_spline *n = kn_shell_normal(kn_job_shell(job, 0));
    const char *isa;
    arithmetic peak = {.work = bench_peak_work(&isa)};
    task tasks[2] = {{ctx[0], job, false}, {ctx[1], job, false}};
    bench_rival rivals[4] = {{"1 thread", run, &tasks[0], 0, 0},
                             {"2 threads", run, &tasks[1], 0, 0},
                             {"arithmetic, 1 thread", calculate, &peak, 0, 0},
                             {"arithmetic, 2 threads", calculate_twice, &peak, 0, 0}};
    bench_rival paired[2] = {{"peak", calculate, &peak, 0, 0}, {"1 thread", run, &tasks[0], 0, 0}};
    bench_compare(paired, 2, BENCH_THREAD);
    bench_compare(rivals, 4, BENCH_WALL);
    double k = 16.0 + (n->degree[0] + 1) * (n->degree[1] + 1), patches = (double)r.patches;
    double flops = 2.0 * 3.0 * k * (double)r.control_points;
    printf("(%d,%d,1) to (%d,%d), %zu patches: %.0f patches/s of processor time, %.0f %% of the peak in turn "
           "(at the peak alone %.0f)\n",
           n->degree[0], n->degree[1], r.degree[0], r.degree[1], r.patches, patches / paired[1].seconds,
           100.0 * paired[1].ratio * flops / peak.flops,
           paired[1].ratio * patches / peak.flops * bench_peak_flops(&isa));
    for (int i = 0; i < 2; i++) {
        printf("    %-9s %9.0f patches/s  %5.2f x\n", rivals[i].name, patches / rivals[i].seconds, rivals[i].ratio);
        *failed = *failed || tasks[i].failed;
    }
    printf("    the machine's own gain from a second thread, arithmetic that shares nothing, in turn: %.2f x\n",
           2.0 * rivals[2].seconds / rivals[3].seconds);
    kn_job_destroy(ctx[1], job);
    return KN_OK;
}

// ---- triangles ----

// Seconds from the creation of a context to a closed file; *triangles in it.
static kn_status write_stl(const char *path, const kn_spline *base, const char *name, int count, double tolerance,
                           int threads, double *seconds, size_t *triangles)
{
    kn_ctx *ctx = NULL;
    kn_ctx_options options = {.threads = threads};
    double start = bench_now(BENCH_WALL);
    if (kn_ctx_create(&ctx, &options) != KN_OK) return KN_ENOMEM;
    kn_job *job = NULL;
    kn_tile tile = {0};
    kn_sink sink = {0};
    kn_job_options o = {.count = {count, count}, .normal_tol = 1e-3, .max_degree = 14, .mesh_tol = tolerance};
    kn_status status = kn_builtin_tile(ctx, &tile, name);
    if (status == KN_OK) status = kn_job_create(ctx, &job, base, 1, &tile, &o);
    if (status == KN_OK) status = kn_stl_sink(ctx, &sink, path);
    if (status == KN_OK) status = kn_job_run(ctx, job, &sink, 1);
    kn_sink_close(ctx, &sink);
    *seconds = bench_now(BENCH_WALL) - start;
    if (status == KN_OK) *triangles = kn_job_describe(job).triangles;
    if (status != KN_OK) fprintf(stderr, "%s\n", kn_ctx_message(ctx));
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_ctx_destroy(ctx);
    return status;
}

static kn_status triangles(const kn_spline *base)
{
    static const char path[] = "/tmp/knurl-bench.stl";
    kn_status status = KN_OK;
    for (int threads = 1; threads <= 2; threads++) {
        double seconds[5];
        size_t n = 0;
        for (int i = 0; i < 5 && status == KN_OK; i++)
            status = write_stl(path, base, "scale", 45, 0.002, threads, &seconds[i], &n);
        if (status != KN_OK) return status;
        double s = bench_median(seconds, 5);
        printf("from nothing to a closed STL file, %d thread%s: %zu triangles in %.2f s, %.2f million/s\n", threads,
               threads > 1 ? "s" : "", n, s, (double)n / s * 1e-6);
    }
    remove(path);
    return status;
}

int main(void)
{
    kn_ctx *ctx[2] = {NULL, NULL};
    for (int i = 0; i < 2; i++) {
        kn_ctx_options o = {.threads = i + 1};
        if (kn_ctx_create(&ctx[i], &o) != KN_OK) return 1;
    }
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *jobs[2] = {NULL, NULL};
    kn_status status = make_base(ctx[1], &base);
    if (status == KN_OK) status = kn_builtin_tile(ctx[1], &tile, "chain");
    for (int i = 0; i < 2 && status == KN_OK; i++) {
        kn_job_options o = {.count = {CELLS, CELLS}, .normal_tol = 1e-3, .max_degree = 14, .symbolic = i == 1};
        status = kn_job_create(ctx[1], &jobs[i], &base, 1, &tile, &o);
    }
    if (status != KN_OK) {
        fprintf(stderr, "%s\n", kn_ctx_message(ctx[1]));
        return 1;
    }
    kn_job_report r = kn_job_describe(jobs[0]);
    task tasks[4];
    bench_rival rivals[4] = {{.name = "symbolic, 1 thread"},
                             {.name = "symbolic, 2 threads"},
                             {.name = "matrix, 1 thread"},
                             {.name = "matrix, 2 threads"}};
    for (int i = 0; i < 4; i++) {
        tasks[i] = (task){ctx[i % 2], jobs[i < 2], false};
        rivals[i].work = run;
        rivals[i].user = &tasks[i];
    }
    bench_compare(rivals, 4, BENCH_WALL);

    size_t points = r.control_points / r.patches, k = 16 + 16;
    const char *isa;
    double peak = bench_peak_flops(&isa), flops = 2.0 * 3.0 * (double)(k * points);
    printf("%zu patches of degree %d, %d (%zu control points), %zu of them exact\n", r.patches, r.degree[0],
           r.degree[1], points, r.exact_patches);
    for (int i = 0; i < 4; i++) {
        double rate = (double)r.patches / rivals[i].seconds;
        printf("%-20s %10.0f patches/s  %6.2f x", rivals[i].name, rate, rivals[i].ratio);
        if (i >= 2) printf("  %6.2f GFLOP/s", rate * flops * 1e-9);
        printf("%s\n", tasks[i].failed ? "  FAILED" : "");
    }
    double rate = product_rate(k, points);
    printf("the product alone    %6.2f GFLOP/s of %.2f (%s), %.0f %%\n", rate * 1e-9, peak * 1e-9, isa,
           100 * rate / peak);
    bool failed = false;
    for (int i = 0; i < 4; i++) failed = failed || tasks[i].failed;
    kn_tile bump = {0};
    status = make_bump(ctx[1], &bump);
    if (status == KN_OK) status = compose_whole(ctx, &base, &bump, KN_NORMAL_FITTED, 128, &failed);
    if (status == KN_OK) status = compose_whole(ctx, &base, &bump, KN_NORMAL_EXACT_DIRECTION, 48, &failed);
    if (status == KN_OK) status = triangles(&base);
    if (status != KN_OK) fprintf(stderr, "%s\n", kn_ctx_message(ctx[1]));
    failed = failed || status != KN_OK;
    kn_tile_clear(ctx[1], &bump);
    for (int i = 0; i < 2; i++) kn_job_destroy(ctx[1], jobs[i]);
    kn_tile_clear(ctx[1], &tile), kn_spline_clear(ctx[1], &base);
    for (int i = 0; i < 2; i++) kn_ctx_destroy(ctx[i]);
    return failed;
}
