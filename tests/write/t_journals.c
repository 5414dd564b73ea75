// SPDX-License-Identifier: Apache-2.0
// Every sink that claims to be saved and gone on with: what is interrupted behind any patch, once or twice, becomes the
// same file, byte for byte, as what goes through. And what nobody can go on with is not left.
#include "tests/support/scene.h"
#include "tests/write/world.h"

#include "kernel/context.h"

#include <knurl/iges.h>
#include <knurl/step.h>
#include <knurl/write.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// ---- sinks ----

typedef kn_status (*open_sink)(kn_ctx *ctx, kn_sink *out, const char *path);

static kn_status open_step(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return kn_step_sink(ctx, out, path, NULL);
}

static kn_status open_ap242(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return kn_step_sink(ctx, out, path, &(kn_step_options){.schema = KN_STEP_AP242, .unit_mm = 10});
}

static kn_status open_iges(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return kn_iges_sink(ctx, out, path, NULL);
}

static kn_status open_iges_surfaces(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return kn_iges_sink(ctx, out, path, &(kn_iges_options){.surfaces = true});
}

static kn_status limited(kn_ctx *ctx, kn_sink *out, const char *path, open_sink open)
{
    kn_sink inner = {0};
    const kn_limit_options o = {.max_degree = 3, .tolerance = 1e-2};
    kn_status status = open(ctx, &inner, path);
    if (status != KN_OK) return status;
    status = kn_limit_sink(ctx, out, &inner, 1, &o, NULL);
    if (status != KN_OK) kn_sink_close(ctx, &inner);
    return status;
}

static kn_status open_limited_step(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return limited(ctx, out, path, open_step);
}

static kn_status open_limited_itd(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return limited(ctx, out, path, kn_itd_sink);
}

static const struct {
    const char *name, *beside; // a second file, or NULL
    open_sink open;
} formats[] = {{"run.g2", NULL, kn_g2_sink},
               {"run.itd", NULL, kn_itd_sink},
               {"run.vtu", NULL, kn_vtu_sink},
               {"run.pov", NULL, kn_pov_sink},
               {"surfaces.obj", "surfaces.mtl", kn_obj_surfaces_sink},
               {"run.obj", "run.mtl", kn_obj_sink},
               {"run.stl", NULL, kn_stl_sink},
               {"run.step", NULL, open_step},
               {"ap242.step", NULL, open_ap242},
               {"run.igs", NULL, open_iges},
               {"surfaces.igs", NULL, open_iges_surfaces},
               {"limited.step", NULL, open_limited_step},
               {"limited.itd", NULL, open_limited_itd}};
enum { FORMATS = sizeof formats / sizeof *formats };

// Refuses to be saved.
static kn_status fuse_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx, (void)user, (void)block, (void)product;
    return KN_OK;
}

static kn_status fuse_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    (void)user, (void)data, (void)bytes;
    return kn_fail(ctx, KN_EDOMAIN, "no state");
}

static kn_status fuse_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                              const unsigned char *data, size_t bytes)
{
    (void)user, (void)tile, (void)report, (void)data, (void)bytes;
    return kn_fail(ctx, KN_EDOMAIN, "no state");
}

static const kn_sink fuse = {.commit = fuse_commit, .save = fuse_save, .restore = fuse_restore};

// ---- jobs ----

// Plates, walls and curves in two parts, over a bent base.
static kn_job *make_job(kn_ctx *ctx)
{
    kn_job *job = NULL;
    kn_spline base = {0}, s = {0};
    kn_tile tile = {0};
    const double corner[3][12] = {{0.1, 0.1, 0.2, 0.1, 0.9, 0.4, 0.9, 0.1, 0.6, 0.9, 0.9, 1.0},
                                  {0.1, 0.1, 0.0, 0.1, 0.1, 0.2, 0.9, 0.1, 0.0, 0.9, 0.1, 0.6},
                                  {0.2, 0.3, 0.2, 0.8, 0.7, 0.9}};
    kn_job_options o = {.count = {2, 3}, .height = 0.1, .normal_tol = 1e-2, .mesh_tol = 1.0};
    scene_bicubic(ctx, &base, 0.3);
    assert_int_equal(kn_tile_init(ctx, &tile, "plates", 2), KN_OK);
    for (int i = 0; i < 3; i++) {
        scene_multilinear(ctx, &s, i < 2 ? 2 : 1, corner[i]);
        assert_int_equal(kn_tile_add(ctx, &tile, i > 0, &s), KN_OK);
        kn_spline_clear(ctx, &s);
    }
    if (kn_job_create(ctx, &job, &base, 1, &tile, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_spline_clear(ctx, &base);
    kn_tile_clear(ctx, &tile);
    return job;
}

typedef struct files {
    char path[TEST_PATH_BYTES], beside[TEST_PATH_BYTES], journal[TEST_PATH_BYTES];
} files;

static files name_files(int format)
{
    files f = {{0}, {0}, {0}};
    test_tmp_path(f.path, formats[format].name);
    if (formats[format].beside) test_tmp_path(f.beside, formats[format].beside);
    test_tmp_path(f.journal, "run.journal");
    return f;
}

static bool exists(const char *path)
{
    return access(path, F_OK) == 0;
}

// Of one file, or of the temporary names of both, or of IGES' parameters.
static bool any_temporary(const files *f)
{
    char name[TEST_PATH_BYTES + 32];
    static const char *const ends[] = {".tmp-0", ".tmp-1", ".parameters.tmp-0", ".parameters.tmp-1"};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
        for (int k = 0; k < 2; k++) {
            snprintf(name, sizeof name, "%s%s", k ? f->beside : f->path, ends[i]);
            if (exists(name)) return true;
        }
    return false;
}

static void remove_files(const files *f)
{
    remove(f->path), remove(f->journal);
    if (f->beside[0]) remove(f->beside);
}

static void assert_file(const char *path, const char *text, size_t bytes)
{
    size_t n = 0;
    char *own = test_read_file(path, &n);
    assert_non_null(own);
    assert_int_equal(n, bytes);
    assert_memory_equal(own, text, bytes);
    free(own);
}

// ---- patches, with interruptions ----

static void check(kn_ctx *ctx, kn_status status)
{
    if (status != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
}

static void feed(world *w, kn_sink *sink, int from, int to)
{
    for (int i = from; i < to; i++) {
        void *product = NULL;
        const kn_patch_block block = {(size_t)i, 1, &w->patch[i]};
        if (sink->work) check(w->ctx, sink->work(w->ctx, sink->user, &block, &product));
        check(w->ctx, sink->commit(w->ctx, sink->user, &block, product));
    }
}

// What a run is saved as behind so many patches, and writes before it ends all of a sudden.
typedef struct part {
    unsigned char *data;
    size_t bytes;
} part;

static part interrupt(world *w, kn_sink *sink, int from, int to)
{
    part p = {0};
    feed(w, sink, from, to);
    check(w->ctx, sink->save(w->ctx, sink->user, &p.data, &p.bytes));
    feed(w, sink, to, to < PATCHES ? to + 1 : to); // lost, and cut off
    kn_sink_close(w->ctx, sink);
    return p;
}

static kn_sink go_on(world *w, open_sink open, const char *path, part *p)
{
    kn_sink sink = {0};
    check(w->ctx, open(w->ctx, &sink, path));
    check(w->ctx, sink.restore(w->ctx, sink.user, &w->tile.tile, &w->report, p->data, p->bytes));
    kn_free(w->ctx, p->data);
    return sink;
}

// Interrupted behind patches a and b, if these are not negative.
static void run(world *w, open_sink open, const char *path, int a, int b)
{
    kn_sink sink = {0};
    check(w->ctx, open(w->ctx, &sink, path));
    assert_true(sink.save && sink.restore && sink.forget);
    if (sink.begin) check(w->ctx, sink.begin(w->ctx, sink.user, &w->tile.tile, &w->report));
    int at = 0;
    for (int k = 0; k < 2; k++) {
        int to = k == 0 ? a : b;
        if (to < 0) continue;
        part p = interrupt(w, &sink, at, to);
        sink = go_on(w, open, path, &p);
        at = to;
    }
    feed(w, &sink, at, PATCHES);
    if (sink.end) check(w->ctx, sink.end(w->ctx, sink.user));
    kn_sink_close(w->ctx, &sink);
}

// Volumes are one piece each, as CAD files want them.
static void cut_volumes(world *w, kn_bezier **pieces, size_t *n)
{
    for (int i = 6; i < PATCHES; i++) {
        check(w->ctx, kn_spline_to_bezier(w->ctx, &pieces[i - 6], &n[i - 6], &w->spline[i]));
        w->patch[i].spline = NULL;
        w->patch[i].bezier = pieces[i - 6][0];
    }
    w->report.curves = 1, w->report.volumes = PATCHES - 6;
}

static void the_same_bytes(void **state)
{
    (void)state;
    world w;
    kn_bezier *pieces[PATCHES - 6];
    size_t npieces[PATCHES - 6];
    world_make(&w, "unused");
    cut_volumes(&w, pieces, npieces);
    for (int format = 0; format < FORMATS; format++) {
        files f = name_files(format);
        size_t bytes = 0, beside_bytes = 0;
        run(&w, formats[format].open, f.path, -1, -1);
        char *text = test_read_file(f.path, &bytes);
        char *beside = f.beside[0] ? test_read_file(f.beside, &beside_bytes) : NULL;
        assert_true(text && bytes > 0 && !any_temporary(&f));
        for (int a = 0; a <= PATCHES; a++)
            for (int b = a - 1; b <= PATCHES; b += a % 2 ? 3 : 1) { // b < a: once only
                remove_files(&f);
                run(&w, formats[format].open, f.path, a, b < a ? -1 : b);
                assert_file(f.path, text, bytes);
                if (beside) assert_file(f.beside, beside, beside_bytes);
                assert_false(any_temporary(&f));
            }
        free(text), free(beside);
        remove_files(&f);
    }
    for (size_t k = 0; k < PATCHES - 6; k++) {
        for (size_t i = 0; i < npieces[k]; i++) kn_bezier_clear(w.ctx, &pieces[k][i]);
        kn_free(w.ctx, pieces[k]);
    }
    world_clear(&w);
}

// ---- journals ----

static kn_status run_job(kn_ctx *ctx, const kn_job *job, open_sink open, const char *path, const char *journal,
                         bool fused, bool in_the_way)
{
    kn_sink sinks[2] = {{0}, fuse};
    kn_ctx_clear_error(ctx);
    assert_int_equal(open(ctx, &sinks[0], path), KN_OK);
    if (in_the_way) assert_int_equal(mkdir(path, 0700), 0); // where the file is to be renamed to
    kn_status status = kn_run_with_journal(ctx, &job, 1, sinks, fused ? 2 : 1, journal, true, -1.0, 7);
    kn_sink_close(ctx, &sinks[0]);
    return status;
}

// Where no journal came about nobody goes on: nothing is left.
static void nothing_is_left(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_job *job = make_job(ctx);
    char nowhere[TEST_PATH_BYTES];
    test_tmp_path(nowhere, "no_such_folder/run.journal");
    for (int format = 0; format < FORMATS; format++) {
        files f = name_files(format);
        assert_int_equal(run_job(ctx, job, formats[format].open, f.path, f.journal, true, false), KN_EDOMAIN);
        assert_string_equal(kn_ctx_message(ctx), "no state");
        assert_false(any_temporary(&f) || exists(f.journal) || exists(f.path));
        assert_int_equal(run_job(ctx, job, formats[format].open, f.path, nowhere, false, false), KN_EIO);
        assert_false(any_temporary(&f) || exists(f.path));
    }
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

// The last step fails, where a folder has the file's name. One file is gone on with when that has gone; of two, one has
// its name already, or is used up: the other one is not left.
static void no_last_name(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_job *job = make_job(ctx);
    for (int format = 0; format < FORMATS; format++) {
        files f = name_files(format);
        assert_int_equal(run_job(ctx, job, formats[format].open, f.path, f.journal, false, true), KN_EIO);
        assert_int_equal(rmdir(f.path), 0);
        bool one = !f.beside[0] && !strstr(f.path, ".igs");
        assert_int_equal(any_temporary(&f), one);
        kn_status status = run_job(ctx, job, formats[format].open, f.path, f.journal, false, false);
        assert_int_equal(status, one ? KN_OK : KN_EIO);
        assert_int_equal(exists(f.path), one);
        assert_false(any_temporary(&f));
        remove_files(&f);
    }
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_same_bytes), cmocka_unit_test(nothing_is_left),
                                       cmocka_unit_test(no_last_name)};
    return cmocka_run_group_tests_name("write/journals", tests, NULL, NULL);
}
