// SPDX-License-Identifier: Apache-2.0
// Writing STEP: faces and bytes each second for 10,000 bicubic patches, on one thread and on two.
#include "bench/bench.h"
#include "kernel/parallel.h"

#include <knurl/io.h>
#include <knurl/step.h>

enum { FACES = 10000, BLOCK = 64 };

static const char path[] = "bench-step.tmp.step";

typedef struct job {
    kn_ctx *ctx;
    kn_patch patch[FACES];
    double *coef;
    kn_tile tile;
    kn_tile_part part;
    kn_sink sink;
    size_t bytes;
} job;

static void need(kn_status status)
{
    if (status == KN_OK) return;
    fprintf(stderr, "bench step: %s\n", kn_status_name(status));
    exit(1);
}

static kn_patch_block block_of(const job *j, size_t index)
{
    size_t first = index * BLOCK, count = FACES - first < BLOCK ? FACES - first : BLOCK;
    return (kn_patch_block){first, count, j->patch + first};
}

static kn_status work(kn_ctx *worker, void *user, size_t index, void **product)
{
    const job *j = user;
    kn_patch_block block = block_of(j, index);
    return j->sink.work(worker, j->sink.user, &block, product);
}

static kn_status commit(kn_ctx *ctx, void *user, size_t index, void *product)
{
    const job *j = user;
    kn_patch_block block = block_of(j, index);
    return j->sink.commit(ctx, j->sink.user, &block, product);
}

static void drop(kn_ctx *ctx, void *user, void *product)
{
    const job *j = user;
    j->sink.discard(ctx, j->sink.user, product);
}

static void write_file(void *user)
{
    job *j = user;
    kn_job_report report = {.patches = FACES, .degree = {3, 3}};
    kn_pipeline pipeline = {j, work, commit, drop};
    need(kn_step_sink(j->ctx, &j->sink, path, NULL));
    need(j->sink.begin(j->ctx, j->sink.user, &j->tile, &report));
    need(kn_pipeline_run(j->ctx, &pipeline, (FACES + BLOCK - 1) / BLOCK, 8, NULL));
    need(j->sink.end(j->ctx, j->sink.user));
    j->bytes = j->sink.bytes(j->sink.user);
    kn_sink_close(j->ctx, &j->sink);
}

// Coordinates with all 53 bits in use, as composition makes them.
static job *make(int threads)
{
    job *j = calloc(1, sizeof *j);
    double *coef = malloc((size_t)FACES * 48 * sizeof *coef);
    uint64_t state = 1;
    if (j == NULL || coef == NULL) exit(1);
    kn_ctx_options options = {.threads = threads};
    need(kn_ctx_create(&j->ctx, &options));
    for (size_t i = 0; i < (size_t)FACES * 48; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        coef[i] = (double)(state >> 11) * 0x1p-53 * 10.0 - 5.0;
    }
    for (int i = 0; i < FACES; i++) {
        kn_bezier b = {.nvars = 2, .ncomp = 3, .degree = {3, 3}, .coef = coef + 48 * (size_t)i};
        j->patch[i] = (kn_patch){.id = {.cell = {i % 100, i / 100}}, .bezier = b};
    }
    j->coef = coef;
    memcpy(j->part.name, "part", 5);
    j->tile = (kn_tile){.parts = &j->part, .nparts = 1};
    return j;
}

static void finish(job *j)
{
    kn_ctx_destroy(j->ctx);
    free(j->coef);
    free(j);
}

int main(void)
{
    job *one = make(1), *two = make(2);
    bench_rival rivals[2] = {{.name = "1 thread", .work = write_file, .user = one},
                             {.name = "2 threads", .work = write_file, .user = two}};
    bench_compare(rivals, 2, BENCH_WALL);
    printf("STEP, %d bicubic faces, %.1f MB\n", FACES, 1e-6 * (double)one->bytes);
    for (int i = 0; i < 2; i++)
        printf("  %-10s %8.0f faces/s  %6.1f MB/s  x %.2f\n", rivals[i].name, FACES / rivals[i].seconds,
               1e-6 * (double)one->bytes / rivals[i].seconds, rivals[i].ratio);
    finish(one);
    finish(two);
    remove(path);
    return 0;
}
