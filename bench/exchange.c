// SPDX-License-Identifier: Apache-2.0
// Writing STEP and IGES: one open shell of n x n bicubic faces with shared edges and vertices, by knurl's sinks and
// by Open CASCADE's writers, each in a process of its own, whose time and largest memory are taken. OCCT's time
// begins when its faces are there; knurl's includes making the patches. Beside it what the machine could do: writing
// so many bytes that are there already, and the text of so many numbers alone.
//     bench/exchange          OCCT writes IGES of 900 and 2,500 faces: its time grows with the square
//     bench/exchange all      and of 10,000
#include "bench/bench.h"
#include "io/decimal.h"
#include "kernel/hash.h"
#include "kernel/parallel.h"

#include <knurl/iges.h>
#include <knurl/step.h>

#include <fcntl.h>
#include <stdbool.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#ifdef KN_WITH_OCCT
#include "bridges/occt/occt_bench.h"
#endif

enum { BLOCK = 64, ROUNDS = 7, NUMBERS = 72 }; // of a face: 16 points, and two new edges of 4 in IGES

static const char path[] = "bench-exchange.tmp";

static void need(kn_status status)
{
    if (status == KN_OK) return;
    fprintf(stderr, "bench exchange: %s\n", kn_status_name(status));
    exit(1);
}

// Coordinates with all 53 bits in use, as composition makes them: of control point (i,j) of the whole net.
static void control_point(double p[3], int i, int j)
{
    uint64_t h = kn_hash_add((uint64_t)i, (uint64_t)j);
    p[0] = i + 0.4 * kn_hash_unit(h);
    p[1] = j + 0.4 * kn_hash_unit(kn_hash_mix(h));
    p[2] = 0.9 * kn_hash_unit(kn_hash_mix(kn_hash_mix(h)));
}

static void net(double point[16][3], int i, int j)
{
    for (int k = 0; k < 16; k++) control_point(point[k], 3 * i + k / 4, 3 * j + k % 4);
}

// ---- knurl ----

typedef struct job {
    int side, threads;
    bool iges;
    int how; // of OCCT's writers
    kn_sink sink;
} job;

static size_t block_count(const job *j, size_t index)
{
    size_t faces = (size_t)j->side * (size_t)j->side, first = index * BLOCK;
    return faces - first < BLOCK ? faces - first : BLOCK;
}

static kn_status work(kn_ctx *worker, void *user, size_t index, void **product)
{
    const job *j = user;
    double coef[BLOCK][48], point[16][3];
    kn_patch patch[BLOCK] = {0};
    kn_patch_block block = {index * BLOCK, block_count(j, index), patch};
    for (size_t k = 0; k < block.count; k++) {
        int at = (int)(block.first + k), row = at / j->side, column = at % j->side;
        net(point, row, column);
        for (int c = 0; c < 48; c++) coef[k][c] = point[c % 16][c / 16];
        patch[k].id.cell[0] = row, patch[k].id.cell[1] = column;
        patch[k].bezier = (kn_bezier){.nvars = 2, .ncomp = 3, .degree = {3, 3}, .coef = coef[k]};
    }
    return j->sink.work(worker, j->sink.user, &block, product);
}

static kn_status commit(kn_ctx *ctx, void *user, size_t index, void *product)
{
    const job *j = user;
    kn_patch_block block = {index * BLOCK, block_count(j, index), NULL}; // what there is of them is in the product
    return j->sink.commit(ctx, j->sink.user, &block, product);
}

static void drop(kn_ctx *ctx, void *user, void *product)
{
    const job *j = user;
    j->sink.discard(ctx, j->sink.user, product);
}

typedef struct result {
    double seconds, processor, before, peak; // of all threads; MB of memory
    size_t bytes;
} result;

// Of all threads, and of the system for them: does not count what other programs take.
static double processor_time(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double peak_memory(void)
{
    struct rusage use;
    getrusage(RUSAGE_SELF, &use);
    return 1e-3 * (double)use.ru_maxrss * 1.024;
}

static void run_knurl(result *r, void *user)
{
    job *j = user;
    kn_ctx *ctx = NULL;
    size_t faces = (size_t)j->side * (size_t)j->side;
    kn_tile_part part = {.name = "part"};
    kn_tile tile = {.parts = &part, .nparts = 1};
    kn_job_report report = {.patches = faces, .control_points = 16 * faces, .degree = {3, 3}};
    kn_pipeline pipeline = {j, work, commit, drop};
    need(kn_ctx_create(&ctx, &(kn_ctx_options){.threads = j->threads}));
    r->before = peak_memory();
    double start = bench_now(BENCH_WALL), processor = processor_time();
    need(j->iges ? kn_iges_sink(ctx, &j->sink, path, NULL) : kn_step_sink(ctx, &j->sink, path, NULL));
    need(j->sink.begin(ctx, j->sink.user, &tile, &report));
    need(kn_pipeline_run(ctx, &pipeline, (faces + BLOCK - 1) / BLOCK, 2 * (size_t)j->threads + 1, NULL));
    need(j->sink.end(ctx, j->sink.user));
    r->seconds = bench_now(BENCH_WALL) - start;
    r->processor = processor_time() - processor;
    r->bytes = j->sink.bytes(j->sink.user);
    kn_sink_close(ctx, &j->sink);
    kn_ctx_destroy(ctx);
    r->peak = peak_memory();
}

// ---- Open CASCADE ----

#ifdef KN_WITH_OCCT
static void run_occt(result *r, void *user)
{
    const job *j = user;
    kn_ctx *ctx = NULL;
    kn_occt_bench *bench = NULL;
    need(kn_ctx_create(&ctx, NULL));
    need(kn_occt_bench_grid(ctx, &bench, j->side, j->side, net));
    r->before = peak_memory();
    double start = bench_now(BENCH_WALL), processor = processor_time();
    need(kn_occt_bench_write(ctx, bench, path, (kn_occt_writer)j->how));
    r->seconds = bench_now(BENCH_WALL) - start;
    r->processor = processor_time() - processor;
    r->peak = peak_memory();
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END) != 0) need(KN_EIO);
    r->bytes = (size_t)ftell(file);
    fclose(file);
    kn_occt_bench_close(bench);
    kn_ctx_destroy(ctx);
}
#endif

// ---- processes ----

static result in_a_child(void (*run)(result *r, void *user), void *user)
{
    int ends[2], state = 0;
    result r = {0};
    if (pipe(ends) != 0) need(KN_EIO);
    fflush(NULL);
    pid_t child = fork();
    if (child < 0) need(KN_EIO);
    if (child == 0) {
        run(&r, user);
        if (write(ends[1], &r, sizeof r) != (ssize_t)sizeof r) _exit(1);
        _exit(0);
    }
    close(ends[1]);
    bool whole = read(ends[0], &r, sizeof r) == (ssize_t)sizeof r;
    close(ends[0]);
    if (waitpid(child, &state, 0) != child || !WIFEXITED(state) || WEXITSTATUS(state) != 0 || !whole) need(KN_EIO);
    remove(path);
    return r;
}

static result median(job *j)
{
    result r = {0};
    double seconds[ROUNDS], processor[ROUNDS];
    for (int i = 0; i < ROUNDS; i++) {
        r = in_a_child(run_knurl, j);
        seconds[i] = r.seconds, processor[i] = r.processor;
    }
    r.seconds = bench_median(seconds, ROUNDS);
    r.processor = bench_median(processor, ROUNDS);
    return r;
}

static void print(const char *who, const job *j, const result *r)
{
    int faces = j->side * j->side;
    printf("  %-16s %6d faces %8.3f s, processor %8.3f s, %6.1f MB peak (%5.1f before), file %6.1f MB\n", who, faces,
           r->seconds, r->processor, r->peak, r->before, 1e-6 * (double)r->bytes);
}

// ---- what the machine could do ----

static void limits(size_t bytes, double faces)
{
    static char part[1 << 20];
    char text[KN_DECIMAL_BYTES];
    double p[3], start = bench_now(BENCH_WALL), sum = 0.0;
    memset(part, 'x', sizeof part);
    int file = open(path, O_CREAT | O_TRUNC | O_WRONLY, 0600);
    for (size_t left = bytes, n; left > 0; left -= n) {
        n = left < sizeof part ? left : sizeof part;
        if (file < 0 || write(file, part, n) != (ssize_t)n) need(KN_EIO);
    }
    close(file);
    double writing = bench_now(BENCH_WALL) - start;
    remove(path);
    start = bench_now(BENCH_THREAD);
    for (int k = 0; k < (int)faces * NUMBERS / 3; k++) {
        control_point(p, k, 0);
        for (int c = 0; c < 3; c++) sum += (double)kn_decimal_step(text, p[c]);
    }
    double formatting = bench_now(BENCH_THREAD) - start;
    printf(
        "  the machine: %.3f s to write these bytes, %.3f s for the text of %.0f numbers (%.0f MB) on one thread\n",
        writing, formatting, faces * NUMBERS, 1e-6 * sum);
}

static void bench_format(bool iges, bool all)
{
    job j = {.side = 100, .threads = 1, .iges = iges};
    printf("%s, n x n bicubic faces as one shell\n", iges ? "IGES" : "STEP");
    result r = median(&j);
    print("knurl, 1 thread", &j, &r);
    limits(r.bytes, (double)j.side * j.side);
    for (int large = 0; large < 2; large++) {
        j.threads = 2, j.side = large ? 316 : 100;
        r = median(&j);
        print("knurl, 2 threads", &j, &r);
    }
#ifdef KN_WITH_OCCT
    const int sides[] = {30, 50, 100}, first = iges ? 0 : 2, last = iges && !all ? 1 : 2;
    j.how = iges ? KN_OCCT_IGES : KN_OCCT_STEP;
    for (int i = first; i <= last; i++) {
        j.side = sides[i];
        r = in_a_child(run_occt, &j);
        print(iges ? "OCCT, 144" : "OCCT", &j, &r);
    }
    j.side = 100, j.how = KN_OCCT_IGES_BREP;
    if (iges) {
        r = in_a_child(run_occt, &j);
        print("OCCT, 514", &j, &r);
    }
#else
    (void)all;
#endif
}

int main(int argc, char **argv)
{
    bool all = argc > 1 && strcmp(argv[1], "all") == 0;
    bench_format(false, all);
    bench_format(true, all);
    return 0;
}
