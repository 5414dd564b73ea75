// SPDX-License-Identifier: Apache-2.0
// GoTools and IRIT files: what is written is read back bit for bit; what they do not hold is refused.
#include "tests/write/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static void assert_read_back(world *w)
{
    kn_model model = {0};
    if (kn_read_model(w->ctx, &model, w->path) != KN_OK) fail_msg("%s", kn_ctx_message(w->ctx));
    assert_int_equal(model.nsplines, PATCHES);
    for (int i = 0; i < PATCHES; i++) {
        kn_spline s;
        world_spline(w, &s, i);
        assert_equal_splines(&model.splines[i], &s);
        kn_spline_clear(w->ctx, &s);
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
        char *a = world_write(&w, formats[f].make, 0, PATCHES, 3, &bytes);
        assert_read_back(&w);
        char *b = world_write(&w, formats[f].make, 0, PATCHES, PATCHES, &again);
        assert_int_equal(bytes, again);
        assert_memory_equal(a, b, bytes);
        // part 1: 0.5 0.5 0.125, linear
        if (f == 0) assert_non_null(strstr(a, "200 1 0 4 188 188 99 255\n3 0\n3 3\n"));
        if (f == 1) assert_non_null(strstr(a, "[RGB \"188,188,99\"] s0_c0_0_wire_rod_1\n[SURFACE BEZIER 3 4 E3\n"));
        free(a), free(b);
        world_clear(&w);
    }
}

static char *write_trimmed(world *w, make_sink make, bool reversed)
{
    w->patch[0].reversed = reversed;
    return world_write(w, make, 0, 1, 1, NULL);
}

// Against the formats' descriptions; reversed, (u,v) are swapped and the loop runs the other way round.
static void trimmed(void **state)
{
    (void)state;
    world w;
    kn_trim trim;
    world_make(&w, "trimmed.g2");
    world_make_trim(&w, &trim);
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
    kn_trim_clear(w.ctx, &trim);
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
    world_refused(&w, kn_g2_sink, 0, PATCHES, "4 of the patches are meshes");
    w.report.meshes = 0;
    w.patch[3].look = 3;
    world_refused(&w, kn_g2_sink, 0, PATCHES, "part 3, of 3");
    w.patch[3].look = 0;
    double *weight = &w.patch[2].bezier.coef[3 * 12], kept = *weight;
    *weight = 0.0;
    world_refused(&w, kn_g2_sink, 0, PATCHES, "a weight that is not positive");
    *weight = kept;
    w.patch[2].bezier.coef[5] = 1e308 * 10;
    world_refused(&w, kn_g2_sink, 0, PATCHES, "not finite");
    world_clear(&w);
}

static void without_memory(void **state)
{
    (void)state;
    world w;
    world_make(&w, "memory.g2");
    world_without_memory(&w, kn_g2_sink, 0, PATCHES);
    world_without_memory(&w, kn_itd_sink, 0, PATCHES);
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
