// SPDX-License-Identifier: Apache-2.0
// Runs that are interrupted and gone on with: the same bytes as without, refusals, and running out of memory.
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include "kernel/context.h"

#include <knurl/io.h>
#include <knurl/step.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SINKS = 5, COUNT = 34 };

// Fails at its commit number `at` (of this run), and can be saved: an interruption at a chosen block.
typedef struct fuse {
    size_t at, commits;
} fuse;

static kn_status fuse_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)block, (void)product;
    fuse *f = user;
    return ++f->commits == f->at ? kn_fail(ctx, KN_EIO, "the fuse") : KN_OK;
}

static kn_status fuse_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    (void)user;
    *data = kn_alloc(ctx, 1, 1);
    *bytes = 0;
    return *data ? KN_OK : KN_ENOMEM;
}

static kn_status fuse_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                              const unsigned char *data, size_t bytes)
{
    (void)ctx, (void)user, (void)tile, (void)report, (void)data;
    return bytes == 0 ? KN_OK : KN_EDOMAIN;
}

static kn_sink fuse_sink(fuse *f)
{
    return (kn_sink){.user = f, .commit = fuse_commit, .save = fuse_save, .restore = fuse_restore};
}

// Bilinear domes and a wall beside them, in two parts, over a flat square: about three blocks.
static kn_status make_job(kn_ctx *ctx, kn_job **job, int count, double height)
{
    const int degree[2] = {1, 1}, points[2] = {2, 2};
    const double knots[] = {0, 0, 1, 1}, *k[2] = {knots, knots};
    const double flat[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0};
    const double sheet[12] = {0, 0, 0.5, 0.5, 0, 1, 0, 1, 0, 0.5, 0.5, 1};
    kn_spline s = {0};
    kn_tile tile = {0};
    kn_status status = kn_spline_init(ctx, &s, 2, 3, false, degree, points, k, sheet);
    if (status == KN_OK) status = kn_tile_init(ctx, &tile, "sheet", 2);
    for (int i = 0; status == KN_OK && i < 3; i++) status = kn_tile_add(ctx, &tile, i / 2, &s);
    if (status == KN_OK) memcpy(s.coef, flat, sizeof flat);
    kn_job_options o = {.count = {count, count}, .height = height, .normal_tol = 1e-2, .mesh_tol = 1.0};
    if (status == KN_OK) status = kn_job_create(ctx, job, &s, 1, &tile, &o);
    kn_spline_clear(ctx, &s);
    kn_tile_clear(ctx, &tile);
    return status;
}

typedef struct paths {
    char step[TEST_PATH_BYTES], stl[TEST_PATH_BYTES], obj[TEST_PATH_BYTES], mtl[TEST_PATH_BYTES];
    char journal[TEST_PATH_BYTES];
} paths;

static void name_paths(paths *p, const char *name)
{
    char file[64];
    snprintf(file, sizeof file, "%s.step", name), test_tmp_path(p->step, file);
    snprintf(file, sizeof file, "%s.stl", name), test_tmp_path(p->stl, file);
    snprintf(file, sizeof file, "%s.obj", name), test_tmp_path(p->obj, file);
    snprintf(file, sizeof file, "%s.mtl", name), test_tmp_path(p->mtl, file);
    snprintf(file, sizeof file, "%s.journal", name), test_tmp_path(p->journal, file);
}

// An OBJ file has the name of its materials in it: the whole files are made under the same names, and put aside.
static void put_aside(const paths *from, const paths *to)
{
    assert_int_equal(rename(from->step, to->step), 0);
    assert_int_equal(rename(from->stl, to->stl), 0);
    assert_int_equal(rename(from->obj, to->obj), 0);
    assert_int_equal(rename(from->mtl, to->mtl), 0);
}

static void remove_paths(const paths *p)
{
    remove(p->step), remove(p->stl), remove(p->obj), remove(p->mtl), remove(p->journal);
}

static bool exists(const char *path)
{
    FILE *f = fopen(path, "rb");
    if (f) fclose(f);
    return f != NULL;
}

// One run into all kinds of files; at: the commit at which it stops. counted: of the counting sink.
static kn_status run_jobs(kn_ctx *ctx, const kn_job *const *jobs, int njobs, const paths *p, bool resume, size_t at,
                          size_t *counted, size_t *commits)
{
    kn_sink sinks[SINKS] = {{0}};
    fuse f = {.at = at};
    kn_status status = kn_step_sink(ctx, &sinks[0], p->step, NULL);
    if (status == KN_OK) status = kn_stl_sink(ctx, &sinks[1], p->stl);
    if (status == KN_OK) status = kn_obj_sink(ctx, &sinks[2], p->obj);
    if (status == KN_OK) status = kn_null_sink(ctx, &sinks[3]);
    sinks[4] = fuse_sink(&f);
    if (status == KN_OK) status = kn_run_with_journal(ctx, jobs, njobs, sinks, SINKS, p->journal, resume, -1.0, 7);
    if (status == KN_OK) *counted = sinks[3].bytes(sinks[3].user);
    *commits = f.commits;
    for (int k = 0; k < SINKS; k++) kn_sink_close(ctx, &sinks[k]);
    return status;
}

static kn_status run(kn_ctx *ctx, const kn_job *job, const paths *p, bool resume, size_t at, size_t *counted,
                     size_t *commits)
{
    return run_jobs(ctx, &job, 1, p, resume, at, counted, commits);
}

static void assert_same_file(const char *a, const char *b)
{
    FILE *x = fopen(a, "rb"), *y = fopen(b, "rb");
    static char bx[1 << 16], by[1 << 16];
    assert_non_null(x);
    assert_non_null(y);
    for (size_t n = 1; n > 0;) {
        n = fread(bx, 1, sizeof bx, x);
        assert_int_equal(fread(by, 1, sizeof by, y), n);
        assert_memory_equal(bx, by, n);
    }
    fclose(x), fclose(y);
}

static void assert_same_files(const paths *a, const paths *b)
{
    assert_same_file(a->step, b->step);
    assert_same_file(a->stl, b->stl);
    assert_same_file(a->obj, b->obj);
    assert_same_file(a->mtl, b->mtl);
}

// After 1, 2, .. blocks of every run, with one thread and two in turn.
static void the_same_bytes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT, two = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1), *other = test_ctx(&two, 2);
    kn_job *job = NULL;
    paths whole, parts;
    size_t counted = 0, again = 0, blocks = 0, commits = 0, all = 0;
    name_paths(&whole, "whole"), name_paths(&parts, "parts");
    assert_int_equal(make_job(ctx, &job, COUNT, 0.1), KN_OK);
    assert_int_equal(run(ctx, job, &parts, false, 0, &counted, &blocks), KN_OK);
    assert_true(blocks >= 3);
    assert_false(exists(parts.journal));
    put_aside(&parts, &whole);
    kn_status status = KN_EIO;
    for (int k = 0; status != KN_OK; k++) {
        status = run(k % 2 ? ctx : other, job, &parts, k > 0, 2, &again, &commits);
        all += commits;
        assert_true(status == KN_OK || status == KN_EIO);
        assert_true(exists(parts.journal) == (status != KN_OK));
        if (status != KN_OK) assert_false(exists(parts.step)); // the name is for whole files
        assert_true((size_t)k <= blocks);
    }
    // each run but the last does one block, and stops in the next
    assert_int_equal(all, 2 * (blocks - 1) + 1);
    assert_int_equal(counted, again);
    assert_same_files(&whole, &parts);
    remove_paths(&whole), remove_paths(&parts);
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
    test_ctx_end(other, &two);
}

// Two layers, interrupted in each of them and between them; and at the very first block, where a note is there already.
static void layers_too(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT, two = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1), *other = test_ctx(&two, 2);
    kn_job *low = NULL, *high = NULL, *odd = NULL;
    paths whole, parts;
    size_t counted = 0, again = 0, blocks = 0, commits = 0;
    name_paths(&whole, "layers"), name_paths(&parts, "some");
    assert_int_equal(make_job(ctx, &low, COUNT, 0.1), KN_OK);
    assert_int_equal(make_job(ctx, &high, COUNT, 0.2), KN_OK);
    assert_int_equal(make_job(ctx, &odd, COUNT, 0.3), KN_OK);
    const kn_job *jobs[] = {low, high}, *others[] = {odd, high};
    assert_int_equal(run_jobs(ctx, jobs, 2, &parts, false, 0, &counted, &blocks), KN_OK);
    assert_true(blocks >= 6);
    put_aside(&parts, &whole);
    assert_int_equal(run_jobs(ctx, jobs, 2, &parts, false, 1, &again, &commits), KN_EIO);
    assert_true(exists(parts.journal));
    kn_status status = KN_EIO;
    for (int k = 0; status != KN_OK; k++) {
        kn_ctx_clear_error(ctx);
        assert_int_equal(run_jobs(ctx, others, 2, &parts, true, 0, &again, &commits),
                         KN_EDOMAIN); // another first layer
        kn_ctx_clear_error(ctx);
        assert_int_equal(run_jobs(ctx, jobs, 1, &parts, true, 0, &again, &commits), KN_EDOMAIN); // too few
        status = run_jobs(k % 2 ? ctx : other, jobs, 2, &parts, true, 2, &again, &commits);
        assert_true(status == KN_OK || status == KN_EIO);
        assert_true((size_t)k <= blocks);
    }
    assert_int_equal(counted, again);
    assert_same_files(&whole, &parts);
    remove_paths(&whole), remove_paths(&parts);
    kn_job_destroy(ctx, low), kn_job_destroy(ctx, high), kn_job_destroy(ctx, odd);
    test_ctx_end(ctx, &memory);
    test_ctx_end(other, &two);
}

static kn_status keep_note(kn_ctx *ctx, void *user, const unsigned char *state, size_t bytes)
{
    unsigned char *copy = kn_alloc(ctx, bytes + sizeof bytes, 1), **kept = user;
    if (!copy) return KN_ENOMEM;
    memcpy(copy, &bytes, sizeof bytes);
    memcpy(copy + sizeof bytes, state, bytes);
    kn_free(ctx, *kept);
    *kept = copy;
    return KN_OK;
}

static kn_status go_on(kn_ctx *ctx, const kn_job *job, int nsinks, const unsigned char *state, size_t bytes,
                       uint64_t identity)
{
    fuse f[2] = {{0, 0}, {0, 0}};
    kn_sink sinks[2] = {fuse_sink(&f[0]), fuse_sink(&f[1])};
    kn_job_notes notes = {.state = state, .bytes = bytes, .identity = identity};
    kn_ctx_clear_error(ctx);
    kn_status status = kn_job_run_from(ctx, job, sinks, nsinks, &notes);
    assert_int_equal(kn_ctx_error(ctx), status);
    return status;
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_job *job = NULL, *higher = NULL;
    assert_int_equal(make_job(ctx, &job, 6, 0.1), KN_OK);
    assert_int_equal(make_job(ctx, &higher, 6, 0.2), KN_OK);
    unsigned char *kept = NULL;
    fuse f = {0, 0};
    kn_sink sink = fuse_sink(&f);
    kn_job_notes notes = {.user = &kept, .note = keep_note, .seconds = -1.0, .identity = 3};
    assert_int_equal(kn_job_run_from(ctx, job, &sink, 1, &notes), KN_OK);
    assert_non_null(kept);
    size_t bytes;
    memcpy(&bytes, kept, sizeof bytes);
    unsigned char *text = kept + sizeof bytes;
    assert_int_equal(go_on(ctx, job, 1, text, bytes, 3), KN_OK); // nothing is left to do
    assert_int_equal(go_on(ctx, job, 1, text, bytes, 4), KN_EDOMAIN);
    assert_int_equal(go_on(ctx, higher, 1, text, bytes, 3), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "another job"));
    assert_int_equal(go_on(ctx, job, 2, text, bytes, 3), KN_EDOMAIN);
    assert_int_equal(go_on(ctx, job, 0, text, bytes, 3), KN_EDOMAIN);
    for (size_t n = 0; n < bytes; n++) assert_int_equal(go_on(ctx, job, 1, text, n, 3), KN_EDOMAIN);
    for (size_t n = 0; n < bytes; n++) {
        text[n] ^= 0x10;
        assert_int_equal(go_on(ctx, job, 1, text, bytes, 3), KN_EDOMAIN);
        text[n] ^= 0x10;
    }
    sink.save = NULL;
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_job_run_from(ctx, job, &sink, 1, &notes), KN_EDOMAIN);
    kn_free(ctx, kept);
    kn_job_destroy(ctx, job);
    kn_job_destroy(ctx, higher);
    test_ctx_end(ctx, &memory);
}

// What the journal speaks of must be there, and be the sinks' own.
static void lost_files(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_job *job = NULL;
    paths p, q;
    char left[TEST_PATH_BYTES + 8];
    size_t counted, commits;
    name_paths(&p, "lost"), name_paths(&q, "elsewhere");
    assert_int_equal(make_job(ctx, &job, COUNT, 0.1), KN_OK);
    assert_int_equal(run(ctx, job, &p, true, 2, &counted, &commits), KN_EIO); // no journal: it begins
    memcpy(q.journal, p.journal, sizeof q.journal);
    kn_ctx_clear_error(ctx);
    assert_int_equal(run(ctx, job, &q, true, 0, &counted, &commits), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "another file"));
    snprintf(left, sizeof left, "%s.tmp-0", p.stl);
    FILE *f = fopen(left, "wb"); // shorter now
    assert_non_null(f);
    fclose(f);
    kn_ctx_clear_error(ctx);
    assert_int_equal(run(ctx, job, &p, true, 0, &counted, &commits), KN_EDOMAIN);
    remove(left);
    kn_ctx_clear_error(ctx);
    assert_int_equal(run(ctx, job, &p, true, 0, &counted, &commits), KN_EIO);
    snprintf(left, sizeof left, "%s.tmp-0", p.step), remove(left);
    snprintf(left, sizeof left, "%s.tmp-0", p.obj), remove(left);
    snprintf(left, sizeof left, "%s.tmp-0", p.mtl), remove(left);
    snprintf(left, sizeof left, "%s.tmp-1", p.stl);
    assert_false(exists(left));
    remove_paths(&p), remove_paths(&q);
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

typedef struct attempt {
    const kn_job *job;
    const unsigned char *state; // NULL: noted from the beginning
    size_t bytes;
    int layers; // 0: kn_job_run_from
} attempt;

static kn_status try_run(kn_ctx *ctx, void *user)
{
    const attempt *a = user;
    unsigned char *kept = NULL;
    kn_sink sink = {0};
    kn_job_notes notes = {.user = &kept, .note = keep_note, .seconds = -1.0, .state = a->state, .bytes = a->bytes};
    kn_status status = kn_null_sink(ctx, &sink);
    const kn_job *jobs[] = {a->job, a->job};
    if (status == KN_OK)
        status = a->layers ? kn_job_run_layers_from(ctx, jobs, a->layers, &sink, 1, &notes)
                           : kn_job_run_from(ctx, a->job, &sink, 1, &notes);
    kn_sink_close(ctx, &sink);
    kn_free(ctx, kept);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    attempt a = {0};
    kn_job *job = NULL;
    unsigned char *kept = NULL;
    kn_sink sink = {0};
    assert_int_equal(make_job(ctx, &job, 2, 0.1), KN_OK);
    a.job = job;
    test_allocation_failures(try_run, &a);
    kn_job_notes notes = {.user = &kept, .note = keep_note, .seconds = -1.0};
    assert_int_equal(kn_null_sink(ctx, &sink), KN_OK);
    assert_int_equal(kn_job_run_from(ctx, job, &sink, 1, &notes), KN_OK);
    kn_sink_close(ctx, &sink);
    memcpy(&a.bytes, kept, sizeof a.bytes);
    a.state = kept + sizeof a.bytes;
    test_allocation_failures(try_run, &a);
    a = (attempt){.job = job, .layers = 2};
    test_allocation_failures(try_run, &a);
    kn_free(ctx, kept);
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_same_bytes), cmocka_unit_test(layers_too),
                                       cmocka_unit_test(refusals), cmocka_unit_test(lost_files),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("io/journal", tests, NULL, NULL);
}
