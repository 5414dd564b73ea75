// SPDX-License-Identifier: Apache-2.0
// GoTools and IRIT files: what is written is read back bit for bit; what they do not hold is refused.
#include "tests/support/patches.h"

#include <knurl/write.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATCHES = 8 };

typedef kn_status (*make_sink)(kn_ctx *ctx, kn_sink *out, const char *path);

// A curve, plain, rational and reversed surfaces, a spline of several spans, a volume and a reversed one.
typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_tile tile;
    kn_patch patch[PATCHES];
    kn_spline spline[PATCHES]; // behind patches 4 .. 7
    kn_job_report report;
    char path[TEST_PATH_BYTES];
} world;

static void world_make(world *w, const char *name)
{
    *w = (world){.memory = TEST_MEMORY_INIT, .report = test_report(PATCHES, 4, 4)};
    w->ctx = test_ctx(&w->memory, 1);
    test_rng rng = test_random(41);
    test_tile_make(&w->tile, 3);
    for (int i = 0; i < 4; i++) {
        test_patch(w->ctx, &w->patch[i], &rng, 3, 2, i >= 2, i, 0.1);
        w->patch[i].reversed = i % 2;
    }
    const int degree[3] = {3, 2, 1}, count[3] = {6, 4, 3};
    for (int i = 4; i < PATCHES; i++) {
        int nvars = i == 4 ? 1 : i == 5 ? 2 : 3;
        bool rational = i % 2 == 0;
        test_random_spline(w->ctx, &w->spline[i], &rng, nvars, 3 + rational, rational, degree, count, 9);
        size_t n = kn_spline_count(&w->spline[i]);
        for (size_t k = 0; k < 3 * n; k++) w->spline[i].coef[k] /= 3.0; // not a number of a few digits
        w->patch[i] = (kn_patch){.spline = &w->spline[i], .reversed = i == 7, .segments = {2, 2, 2}};
    }
    for (int i = 0; i < PATCHES; i++) {
        w->patch[i].look = w->patch[i].id.part = i % 3;
        w->patch[i].id.patch = i;
    }
    test_tmp_path(w->path, name);
}

static void world_clear(world *w)
{
    for (int i = 0; i < 4; i++) kn_bezier_clear(w->ctx, &w->patch[i].bezier);
    for (int i = 4; i < PATCHES; i++) kn_spline_clear(w->ctx, &w->spline[i]);
    remove(w->path);
    test_ctx_end(w->ctx, &w->memory);
}

static void write_with(world *w, make_sink make, size_t block)
{
    kn_sink sink = {0};
    assert_int_equal(make(w->ctx, &sink, w->path), KN_OK);
    if (test_feed(w->ctx, &sink, &w->tile.tile, &w->report, w->patch, PATCHES, block) != KN_OK)
        fail_msg("%s", kn_ctx_message(w->ctx));
    size_t bytes = sink.bytes(sink.user), there = 0;
    kn_sink_close(w->ctx, &sink);
    char *text = test_read_file(w->path, &there);
    assert_int_equal(bytes, there);
    free(text);
}

static void assert_equal_splines(const kn_spline *a, const kn_spline *b)
{
    assert_int_equal(a->nvars, b->nvars);
    assert_int_equal(a->ncomp, b->ncomp);
    assert_int_equal(a->rational, b->rational);
    for (int d = 0; d < a->nvars; d++) {
        assert_int_equal(a->degree[d], b->degree[d]);
        assert_int_equal(a->count[d], b->count[d]);
        size_t knots = (size_t)(a->count[d] + a->degree[d] + 1);
        for (size_t i = 0; i < knots; i++) assert_true(a->knots[d][i] == b->knots[d][i]);
    }
    size_t n = kn_spline_count(a) * (size_t)a->ncomp;
    for (size_t i = 0; i < n; i++) assert_true(a->coef[i] == b->coef[i]);
}

// Reversed ones have their first two variables swapped.
static void assert_read_back(world *w)
{
    static const int order[3] = {1, 0, 2};
    kn_model model = {0};
    if (kn_read_model(w->ctx, &model, w->path) != KN_OK) fail_msg("%s", kn_ctx_message(w->ctx));
    assert_int_equal(model.nsplines, PATCHES);
    for (int i = 0; i < PATCHES; i++) {
        kn_spline s = kn_patch_spline(&w->patch[i]), turned = {0};
        bool turn = w->patch[i].reversed && s.nvars > 1;
        if (turn) assert_int_equal(kn_spline_permute(w->ctx, &turned, &s, order), KN_OK);
        assert_equal_splines(&model.splines[i], turn ? &turned : &s);
        kn_spline_clear(w->ctx, &turned);
    }
    kn_model_clear(w->ctx, &model);
}

static void read_back(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        make_sink make;
    } formats[] = {{"out.g2", kn_g2_sink}, {"out.itd", kn_itd_sink}};
    for (size_t f = 0; f < 2; f++) {
        world w;
        size_t bytes, again;
        world_make(&w, formats[f].name);
        write_with(&w, formats[f].make, 3);
        assert_read_back(&w);
        char *a = test_read_file(w.path, &bytes);
        write_with(&w, formats[f].make, PATCHES);
        char *b = test_read_file(w.path, &again);
        assert_int_equal(bytes, again);
        assert_memory_equal(a, b, bytes);
        if (f == 0) assert_non_null(strstr(a, "100 1 0 4 188 188 99 255\n3 1\n")); // part 1: 0.5 0.5 0.125 linear
        if (f == 1)
            assert_non_null(strstr(a, "[OBJECT [RGB \"188,188,99\"] s0_c0_0_wire_rod_1\n[SURFACE BEZIER 3 4 E3\n"));
        free(a), free(b);
        world_clear(&w);
    }
}

// A triangle of [0,1]^2, with one curved side.
static void make_trim(kn_ctx *ctx, kn_trim *out)
{
    static const double points[3][6] = {{0, 1, 0, 0}, {1, 0.5, 0, 0, 0.75, 1}, {0, 0, 1, 0}};
    static int ends[1] = {3};
    static kn_spline curves[3];
    const double line[4] = {0, 0, 1, 1}, arc[6] = {0, 0, 0, 1, 1, 1};
    for (int i = 0; i < 3; i++) {
        const double *knots[1] = {i == 1 ? arc : line};
        int degree = i == 1 ? 2 : 1, count = degree + 1;
        assert_int_equal(kn_spline_init(ctx, &curves[i], 1, 2, false, &degree, &count, knots, points[i]), KN_OK);
    }
    *out = (kn_trim){.curves = curves, .ncurves = 3, .loop_end = ends, .nloops = 1};
    assert_int_equal(kn_trim_check(ctx, out), KN_OK);
}

static char *write_trimmed(world *w, make_sink make, bool reversed)
{
    kn_sink sink = {0};
    w->patch[0].reversed = reversed;
    assert_int_equal(make(w->ctx, &sink, w->path), KN_OK);
    if (test_feed(w->ctx, &sink, &w->tile.tile, &w->report, w->patch, 1, 1) != KN_OK)
        fail_msg("%s", kn_ctx_message(w->ctx));
    kn_sink_close(w->ctx, &sink);
    return test_read_file(w->path, NULL);
}

// Against the formats' descriptions; reversed, (u,v) are swapped and the loop runs the other way round.
static void trimmed(void **state)
{
    (void)state;
    world w;
    kn_trim trim;
    world_make(&w, "trimmed.g2");
    make_trim(w.ctx, &trim);
    w.patch[0].trim = &trim;
    char *text = write_trimmed(&w, kn_g2_sink, false);
    assert_int_equal(strncmp(text, "210 1 0 4 137 188 99 255\n200\n3 0\n4 4\n", 37), 0);
    const char *loops =
        "\n1\n3 1e-06\n1 100 0\n2 0\n2 2\n0 0 1 1\n0 0\n1 0\n1 100 0\n2 0\n3 3\n0 0 0 1 1 1\n1 0\n0.5 0.75\n"
        "0 1\n1 100 0\n2 0\n2 2\n0 0 1 1\n0 1\n0 0\n";
    assert_string_equal(text + strlen(text) - strlen(loops), loops);
    free(text);
    text = write_trimmed(&w, kn_g2_sink, true);
    loops = "\n1\n3 1e-06\n1 100 0\n2 0\n2 2\n-1 -1 0 0\n0 0\n1 0\n1 100 0\n2 0\n3 3\n-1 -1 -1 0 0 0\n1 0\n0.75 0.5\n"
            "0 1\n1 100 0\n2 0\n2 2\n-1 -1 0 0\n0 1\n0 0\n";
    assert_string_equal(text + strlen(text) - strlen(loops), loops);
    free(text);
    text = write_trimmed(&w, kn_itd_sink, false);
    assert_non_null(strstr(text, "] s0_c0_0_link_0\n[TRIMSRF\n[SURFACE BEZIER 4 3 E3\n"));
    loops =
        "]\n[TRIMCRV\n[TRIMCRVSEG\n[CURVE BEZIER 2 E2\n  [0 0]\n  [1 0]\n]\n]\n[TRIMCRVSEG\n[CURVE BEZIER 3 E2\n"
        "  [1 0]\n  [0.5 0.75]\n  [0 1]\n]\n]\n[TRIMCRVSEG\n[CURVE BEZIER 2 E2\n  [0 1]\n  [0 0]\n]\n]\n]\n]\n]\n";
    assert_string_equal(text + strlen(text) - strlen(loops), loops);
    free(text);
    for (int i = 0; i < 3; i++) kn_spline_clear(w.ctx, &trim.curves[i]);
    world_clear(&w);
}

static void meshes(void **state)
{
    (void)state;
    world w;
    world_make(&w, "mesh.itd");
    double position[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1.0 / 3};
    uint32_t triangle[6] = {0, 2, 1, 0, 1, 3};
    const kn_mesh mesh = {.nvertices = 4, .ntriangles = 2, .position = position, .triangle = triangle};
    const kn_patch patch = {.mesh = &mesh, .reversed = true};
    kn_sink sink = {0};
    kn_model model = {0};
    assert_int_equal(kn_itd_sink(w.ctx, &sink, w.path), KN_OK);
    assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &w.report, &patch, 1, 1), KN_OK);
    kn_sink_close(w.ctx, &sink);
    assert_int_equal(kn_read_model(w.ctx, &model, w.path), KN_OK);
    assert_int_equal(model.mesh.ntriangles, 2);
    for (size_t t = 0; t < 2; t++)
        for (size_t k = 0; k < 3; k++)
            assert_memory_equal(model.mesh.position + 3 * (size_t)model.mesh.triangle[3 * t + k],
                                position + 3 * (size_t)triangle[3 * t + k], 3 * sizeof *position);
    kn_model_clear(w.ctx, &model);
    remove(w.path);
    assert_int_equal(kn_g2_sink(w.ctx, &sink, w.path), KN_OK);
    assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &w.report, &patch, 1, 1), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(w.ctx), "is a mesh"));
    kn_sink_close(w.ctx, &sink);
    assert_null(test_read_file(w.path, NULL));
    world_clear(&w);
}

static void assert_refused(world *w, const char *why)
{
    kn_sink sink = {0};
    kn_ctx_clear_error(w->ctx);
    assert_int_equal(kn_g2_sink(w->ctx, &sink, w->path), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, &w->report, w->patch, PATCHES, 2), KN_EDOMAIN);
    if (!strstr(kn_ctx_message(w->ctx), why)) fail_msg("%s", kn_ctx_message(w->ctx));
    kn_sink_close(w->ctx, &sink);
    assert_null(test_read_file(w->path, NULL));
}

static void refusals(void **state)
{
    (void)state;
    world w;
    kn_sink sink = {0};
    world_make(&w, "refused.g2");
    assert_int_equal(kn_g2_sink(w.ctx, &sink, "/nowhere/x.g2"), KN_EIO);
    kn_ctx_clear_error(w.ctx);
    assert_int_equal(kn_itd_sink(w.ctx, &sink, "/nowhere/x.itd"), KN_EIO);
    w.report.meshes = 4;
    assert_refused(&w, "4 of the patches are meshes");
    w.report.meshes = 0;
    w.patch[3].look = 3;
    assert_refused(&w, "part 3, of 3");
    w.patch[3].look = 0;
    double *weight = &w.patch[2].bezier.coef[3 * 12], kept = *weight;
    *weight = 0.0;
    assert_refused(&w, "a weight that is not positive");
    *weight = kept;
    w.patch[2].bezier.coef[5] = 1e308 * 10;
    assert_refused(&w, "not finite");
    world_clear(&w);
}

typedef struct trial {
    world *w;
    make_sink make;
} trial;

static kn_status feed_sink(kn_ctx *ctx, void *user)
{
    trial *t = user;
    kn_sink sink = {0};
    kn_status status = t->make(ctx, &sink, t->w->path);
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &t->w->tile.tile, &t->w->report, t->w->patch, PATCHES, 3);
    kn_sink_close(ctx, &sink);
    if (status != KN_OK) assert_null(test_read_file(t->w->path, NULL));
    remove(t->w->path);
    return status;
}

static void without_memory(void **state)
{
    (void)state;
    world w;
    world_make(&w, "memory.g2");
    test_allocation_failures(feed_sink, &(trial){&w, kn_g2_sink});
    test_allocation_failures(feed_sink, &(trial){&w, kn_itd_sink});
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(read_back), cmocka_unit_test(trimmed),        cmocka_unit_test(meshes),
        cmocka_unit_test(refusals),  cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("write/text_sinks", tests, NULL, NULL);
}
