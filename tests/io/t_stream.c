// SPDX-License-Identifier: Apache-2.0
// Models through sinks: splines as they are, cut at kinks, over unit domains; meshes; what is left out.
#include "tests/support/patches.h"
#include "tests/support/surfaces.h"

#include "io/bend.h"
#include "kernel/context.h"

#include <knurl/io.h>

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Keeps copies of the splines that it is sent.
typedef struct kept {
    kn_spline spline[64];
    kn_patch patch[64];
    kn_job_report report;
    char part[KN_NAME_BYTES];
    size_t count, triangles;
    int ended;
} kept;

static kn_status kept_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)ctx;
    kept *k = user;
    assert_int_equal(tile->nparts, 1);
    memcpy(k->part, tile->parts[0].name, sizeof k->part);
    k->report = *report;
    return KN_OK;
}

static kn_status kept_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)product;
    kept *k = user;
    kn_mesh mesh = {0};
    kn_status status = KN_OK;
    assert_int_equal(block->first, k->count);
    for (size_t i = 0; status == KN_OK && i < block->count; i++) {
        const kn_patch *p = &block->patches[i];
        kn_spline s = kn_patch_spline(p);
        k->patch[k->count] = *p;
        status = kn_patch_tessellate(ctx, &mesh, p);
        if (status == KN_OK) status = kn_spline_copy(ctx, &k->spline[k->count++], &s);
    }
    k->triangles += mesh.ntriangles;
    kn_mesh_clear(ctx, &mesh);
    return status;
}

static kn_status kept_end(kn_ctx *ctx, void *user)
{
    (void)ctx;
    ((kept *)user)->ended++;
    return KN_OK;
}

static kn_sink kept_sink(kept *k)
{
    *k = (kept){.count = 0};
    return (kn_sink){.user = k, .begin = kept_begin, .commit = kept_commit, .end = kept_end};
}

static void kept_clear(kn_ctx *ctx, kept *k)
{
    for (size_t i = 0; i < k->count; i++) kn_spline_clear(ctx, &k->spline[i]);
    k->count = 0;
}

static void parse(kn_ctx *ctx, kn_model *model, const char *text)
{
    if (kn_parse_g2(ctx, model, "model", text, strlen(text)) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
}

// A roof of three planes over [0,5], bilinear pieces: kinks at u = 1 and u = 4, none at u = 2, where its degree 1 knot
// lies in a plane; a curve in the plane; a surface of one component.
static const char roof[] = "200 1 0 0\n3 0\n5 2\n0 0 1 2 4 5 5\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n2 0 1\n4 0 3\n5 0 3\n"
                           "0 1 0\n1 1 0\n2 1 1\n4 1 3\n5 1 3\n"
                           "100 1 0 0\n2 0\n3 3\n0 0 0 2 2 2\n0 0\n1 2\n2 0\n"
                           "200 1 0 0\n1 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0\n1\n2\n3\n";

static void as_they_are(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    kept k;
    kn_sink sink = kept_sink(&k);
    parse(ctx, &model, roof);
    assert_int_equal(kn_stream_model(ctx, &model, "a roof", NULL, &sink, 1), KN_OK);
    assert_string_equal(k.part, "a roof");
    assert_int_equal(k.ended, 1);
    assert_int_equal(k.count, 2);
    assert_int_equal(k.report.patches, 2);
    assert_int_equal(k.report.curves, 1);
    assert_int_equal(k.report.degree[0], 2);
    assert_int_equal(k.report.degree[1], 1);
    assert_true(k.report.cell_size == 5.0);
    assert_memory_equal(k.spline[0].coef, model.splines[0].coef, 30 * sizeof(double));
    assert_memory_equal(k.spline[0].knots[0], model.splines[0].knots[0], 7 * sizeof(double));
    assert_int_equal(kn_spline_dim(&k.spline[1]), 3); // in z = 0
    for (int i = 0; i < 3; i++) assert_true(k.spline[1].coef[6 + i] == 0.0);
    assert_true(k.spline[1].knots[0][5] == 2.0);
    kept_clear(ctx, &k);
    sink = kept_sink(&k);
    assert_int_equal(kn_stream_model(ctx, &model, "r", &(kn_stream_options){.unit_domains = true}, &sink, 1), KN_OK);
    const double unit[7] = {0, 0, 0.2, 0.4, 0.8, 1, 1};
    assert_memory_equal(k.spline[0].knots[0], unit, sizeof unit);
    kept_clear(ctx, &k);
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

static void cut_at_kinks(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const kn_stream_options o = {.split = true};
    kn_model model = {0};
    kept k;
    kn_sink sink = kept_sink(&k);
    parse(ctx, &model, roof);
    assert_int_equal(kn_stream_model(ctx, &model, "roof", &o, &sink, 1), KN_OK);
    assert_int_equal(k.count, 4);
    const double ends[4] = {0, 1, 4, 5};
    for (int i = 0; i < 3; i++) {
        double lo, hi;
        kn_spline_domain(&k.spline[i], 0, &lo, &hi);
        assert_true(lo == ends[i] && hi == ends[i + 1]);
    }
    for (size_t c = 0; c < 3; c++) { // the edge at u = 1, on both sides
        assert_true(k.spline[0].coef[4 * c + 2] == k.spline[1].coef[6 * c]);
        assert_true(k.spline[0].coef[4 * c + 3] == k.spline[1].coef[6 * c + 1]);
    }
    kept_clear(ctx, &k);
    kn_model_clear(ctx, &model);

    // A torus: its double knots are C1, and it stays one.
    kn_spline torus = {0};
    make_torus(ctx, &torus);
    model = (kn_model){.splines = &torus, .nsplines = 1};
    sink = kept_sink(&k);
    assert_int_equal(kn_stream_model(ctx, &model, "torus", &o, &sink, 1), KN_OK);
    assert_int_equal(k.count, 1);
    kept_clear(ctx, &k);

    // The same with the circle at one of them lifted: cut there, and nowhere else.
    size_t n = kn_spline_count(&torus), rows = (size_t)torus.count[1];
    assert_int_equal(torus.degree[0], 2);
    for (size_t j = 2 * rows; j < 3 * rows; j++) torus.coef[2 * n + j] += 0.1 * torus.coef[3 * n + j];
    sink = kept_sink(&k);
    assert_int_equal(kn_stream_model(ctx, &model, "torus", &o, &sink, 1), KN_OK);
    assert_int_equal(k.count, 2);
    assert_int_equal(k.spline[0].count[0], 3);
    kept_clear(ctx, &k);
    kn_spline_clear(ctx, &torus);
    test_ctx_end(ctx, &memory);
}

// The tessellation keeps its tolerance: every point of the patch is that near to a point of the triangles' plane, which
// for the middle of each rectangle's diagonal is checked by brute force over a fine grid.
static void fine_enough(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline wavy = {0};
    make_wavy(ctx, &wavy);
    const kn_model model = {.splines = &wavy, .nsplines = 1};
    for (int i = 1; i <= 3; i++) {
        double tol = pow(0.1, i);
        kept k;
        kn_sink sink = kept_sink(&k);
        assert_int_equal(kn_stream_model(ctx, &model, "w", &(kn_stream_options){.mesh_tol = tol}, &sink, 1), KN_OK);
        int n = k.patch[0].segments[0], m = k.patch[0].segments[1];
        assert_int_equal(k.triangles, 2 * n * m);
        assert_int_equal(k.report.triangles, k.triangles);
        double lo[2], hi[2], worst = 0;
        for (int d = 0; d < 2; d++) kn_spline_domain(&wavy, d, &lo[d], &hi[d]);
        for (int a = 0; a < n; a++)
            for (int b = 0; b < m; b++) { // spans are of one length here
                double p[3][3];
                for (int c = 0; c < 3; c++) {
                    double at[2] = {lo[0] + (hi[0] - lo[0]) * (a + 0.5 * c) / n,
                                    lo[1] + (hi[1] - lo[1]) * (b + 0.5 * c) / m};
                    assert_int_equal(kn_spline_eval(ctx, p[c], &wavy, at), KN_OK);
                }
                double gap = 0;
                for (int c = 0; c < 3; c++) gap += pow(p[1][c] - (p[0][c] + p[2][c]) / 2, 2);
                worst = fmax(worst, sqrt(gap));
            }
        assert_true(worst <= tol);
        assert_true(worst > tol / 100); // and not much finer than that
        kept_clear(ctx, &k);
    }
    kn_spline_clear(ctx, &wavy);
    test_ctx_end(ctx, &memory);
}

static void meshes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double position[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 9, 9, 9};
    uint32_t triangle[3] = {0, 1, 2};
    const kn_model model = {.mesh = {.nvertices = 4, .ntriangles = 1, .position = position, .triangle = triangle}};
    char path[TEST_PATH_BYTES];
    kn_sink sink = {0};
    test_tmp_path(path, "stream.obj");
    assert_int_equal(kn_obj_sink(ctx, &sink, path), KN_OK);
    assert_int_equal(kn_stream_model(ctx, &model, "mesh", NULL, &sink, 1), KN_OK);
    kn_sink_close(ctx, &sink);
    char *text = test_read_file(path, NULL);
    assert_non_null(strstr(text, "g mesh\nusemtl mesh\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 9 9 9\nvn 0 0 1\nvn 0 0 1\n"));
    free(text);
    test_ctx_end(ctx, &memory);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    kept k;
    kn_sink sink = kept_sink(&k), none = {.user = &k};
    assert_int_equal(kn_stream_model(ctx, &model, "empty", NULL, &sink, 1), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    parse(ctx, &model, roof);
    assert_int_equal(kn_stream_model(ctx, &model, "r", &(kn_stream_options){.mesh_tol = -1}, &sink, 1), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_stream_model(ctx, &model, "r", NULL, &none, 1), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    test_tile tile;
    test_tile_make(&tile, 1);
    kn_patch patch = {.spline = &model.splines[0], .look = 1};
    assert_int_equal(kn_stream_patches(ctx, &tile.tile, &patch, 1, 0, &sink, 1), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "part 1, of 1"));
    assert_int_equal(k.count, 0);
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

// Numbers that no int holds are refused: of segments, and of what a header claims.
static void too_many(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    int n = -1;
    parse(ctx, &model, roof); // 4 spans in u
    assert_int_equal(kn_bend_total(ctx, &n, &model.splines[0], 0, 1 << 28), KN_OK);
    assert_int_equal(n, 1 << 30);
    assert_int_equal(kn_bend_total(ctx, &n, &model.splines[0], 0, 1 << 29), KN_ELIMIT);
    assert_int_equal(kn_bend_total(ctx, &n, &model.splines[0], 0, INT_MAX), KN_ELIMIT);
    assert_int_equal(kn_bend_total(ctx, &n, &model.splines[0], 1, 1 << 30), KN_OK);
    assert_int_equal(n, 1 << 30);
    kn_model_clear(ctx, &model);
    static const char *const hostile[] = {
        "100 1 0 0\n3 0\n2147483647 2\n0 0 1 1\n", "100 1 0 0\n3 0\n16777217 2\n0 0\n",
        "200 1 0 0\n3 0\n65536 2\n0 0 1 1\n65536 2\n0 0 1 1\n0 0 0\n", "200 1 0 0\n3 0\n99999999999 2\n0 0 1 1\n"};
    for (size_t i = 0; i < sizeof hostile / sizeof *hostile; i++) {
        kn_ctx_clear_error(ctx);
        kn_status status = kn_parse_g2(ctx, &model, "hostile", hostile[i], strlen(hostile[i]));
        assert_true(status == KN_EPARSE || status == KN_ELIMIT);
        assert_int_equal(model.nsplines, 0);
    }
    test_ctx_end(ctx, &memory);
}

// ---- threads ----

enum { MANY = 333 };

typedef struct broken {
    size_t at, committed; // work fails for the block with patch `at`; patches that were committed
    int ended;
} broken;

static kn_status broken_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    broken *b = user;
    if (block->first <= b->at && b->at < block->first + block->count) return kn_fail(worker, KN_EIO, "broken");
    *product = kn_alloc(worker, 1, 1);
    return *product ? KN_OK : KN_ENOMEM;
}

static kn_status broken_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    broken *b = user;
    assert_int_equal(block->first, b->committed);
    b->committed += block->count;
    kn_free(ctx, product);
    return KN_OK;
}

static void broken_discard(kn_ctx *ctx, void *user, void *product)
{
    (void)user;
    kn_free(ctx, product); // or the context's end finds it
}

static kn_status broken_end(kn_ctx *ctx, void *user)
{
    (void)ctx;
    ((broken *)user)->ended++;
    return KN_OK;
}

// The same bytes for any number of threads; what fails does so at the same patch, and what was made is given back.
static void threads(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_patch patches[MANY];
    kn_bezier own[7] = {{0}};
    test_tile tile;
    test_tile_make(&tile, 3);
    kn_ctx *plain = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int i = 0; i < 7; i++) {
        kn_patch one;
        test_patch(plain, &one, &rng, 1 + i % 3, 2, i % 2, i, 0.1);
        own[i] = one.bezier;
    }
    for (int i = 0; i < MANY; i++)
        patches[i] = (kn_patch){.bezier = own[i % 7], .look = i % 3, .id.patch = i, .segments = {2, 3}};
    char *first[2] = {NULL, NULL}, path[2][TEST_PATH_BYTES];
    test_tmp_path(path[0], "threads.obj"), test_tmp_path(path[1], "threads.stl");
    for (int n = 1; n <= 5; n += 2) {
        test_memory inner = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&inner, n);
        kn_sink sinks[3] = {{0}};
        assert_int_equal(kn_obj_sink(ctx, &sinks[0], path[0]), KN_OK);
        assert_int_equal(kn_stl_sink(ctx, &sinks[1], path[1]), KN_OK);
        assert_int_equal(kn_stream_patches(ctx, &tile.tile, patches, MANY, 0.0, sinks, 2), KN_OK);
        for (int k = 0; k < 2; k++) {
            size_t bytes, told = sinks[k].bytes(sinks[k].user);
            kn_sink_close(ctx, &sinks[k]);
            char *text = test_read_file(path[k], &bytes);
            assert_true(text && bytes > 0 && told >= bytes);
            if (first[k]) assert_memory_equal(text, first[k], bytes);
            if (!first[k]) first[k] = text, text = NULL;
            free(text);
        }
        broken b = {.at = 200};
        sinks[0] = (kn_sink){
            .user = &b, .work = broken_work, .commit = broken_commit, .discard = broken_discard, .end = broken_end};
        assert_int_equal(kn_stream_patches(ctx, &tile.tile, patches, MANY, 0.0, sinks, 1), KN_EIO);
        assert_string_equal(kn_ctx_message(ctx), "broken");
        assert_true(b.committed <= 200 && b.committed + 5 > 200 && b.ended == 0); // all blocks before: of 5 patches
        test_ctx_end(ctx, &inner);
    }
    for (int k = 0; k < 2; k++) free(first[k]), remove(path[k]);
    test_tmp_path(path[0], "threads.mtl");
    remove(path[0]);
    for (int i = 0; i < 7; i++) kn_bezier_clear(plain, &own[i]);
    test_ctx_end(plain, &memory);
}

static kn_status stream_roof(kn_ctx *ctx, void *user)
{
    kept k;
    kn_sink sink = kept_sink(&k);
    kn_status status = kn_stream_model(ctx, user, "r", &(kn_stream_options){.split = true, .unit_domains = true},
                                       &sink, 1);
    kept_clear(ctx, &k);
    return status;
}

static void without_memory(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    parse(ctx, &model, roof);
    test_allocation_failures(stream_roof, &model);
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_they_are), cmocka_unit_test(cut_at_kinks),   cmocka_unit_test(fine_enough),
        cmocka_unit_test(meshes),      cmocka_unit_test(too_many),       cmocka_unit_test(threads),
        cmocka_unit_test(refusals),    cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("io/stream", tests, NULL, NULL);
}
