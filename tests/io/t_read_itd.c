// SPDX-License-Identifier: Apache-2.0
// The reader of IRIT data files.
#include "tests/support/support.h"

#include <knurl/io.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static kn_status parse(kn_ctx *ctx, kn_model *out, const char *text)
{
    size_t bytes = strlen(text);
    char *exact = malloc(bytes > 0 ? bytes : 1); // no byte beyond the end: a sanitizer sees any step beyond
    assert_non_null(exact);
    memcpy(exact, text, bytes);
    kn_status status = kn_parse_itd(ctx, out, "x.itd", exact, bytes);
    free(exact);
    return status;
}

// A quarter circle, a bilinear patch with attributes and a floating knot vector, a trivariate, a line, a square.
static const char sample[] =
    "A comment outside of brackets, with \"quotes\".\n"
    "[OBJECT SCENE\n"
    "  [OBJECT [COLOR 4] [RGB \"255,0,[128\"] ARC\n"
    "    [CURVE BEZIER 3 P2\n"
    "      [1 1 0]\n"
    "      [0.7071067811865476 0.7071067811865476 0.7071067811865476]\n"
    "      [1 0 1]\n"
    "    ]\n"
    "  ]\n"
    "  [OBJECT PATCH [SURFACE BSPLINE 3 2 3 2 E3 [KV -2 -1 0 1 2 3] [KV 0 0 1 1]\n"
    "    [0 0 0][1 0 0][2 0 0]\n"
    "    [0 4 1] [1 4 1] [2 4 1]]]\n"
    "  [OBJECT VOLUME [TRIVAR BEZIER 2 2 2 E3 [0 0 0] [1 0 0] [0 2 0] [1 2 0.5]\n"
    "    [0 0 1] [1 0 1] [0 2 1] [1 2 1.5]]]\n"
    "]\n"
    "[OBJECT NONE [NUMBER 3.5]] [OBJECT M [MATRIX 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]]\n"
    "[OBJECT L [POLYLINE 3 [0 0 0] [1 0 0] [1 2 0]]]\n"
    "[OBJECT P [POLYGON [PLANE 0 0 1 0] 4 [[NORMAL 0 0 1] 0 0 0] [I 1 0 0] [1 1 0] [0 1 0]]\n"
    "  [POLYGON 3 [0 0 0] [0 0 0] [1 1 1]]]\n";

static void check_splines(kn_ctx *ctx, const kn_model *model)
{
    double p[3], at[3];
    const kn_spline *arc = &model->splines[0], *patch = &model->splines[1], *volume = &model->splines[2];
    assert_int_equal(kn_spline_dim(arc), 2);
    for (int i = 0; i <= 8; i++) { // x^2 + y^2 = 1: quotients of numbers below 2, few roundings each
        at[0] = 0.125 * i;
        assert_int_equal(kn_spline_eval(ctx, p, arc, at), KN_OK);
        assert_true(fabs(p[0] * p[0] + p[1] * p[1] - 1.0) <= 1e-14);
    }
    // Points at knot averages (Greville) make x linear: -1.5, -0.5+..: nodes are -0.5, 0.5, 1.5, so x = u + 0.5.
    double lo, hi;
    kn_spline_domain(patch, 0, &lo, &hi);
    assert_true(lo == 0 && hi == 1);
    for (int i = 0; i <= 4; i++) {
        at[0] = 0.25 * i, at[1] = 1 - 0.25 * i;
        assert_int_equal(kn_spline_eval(ctx, p, patch, at), KN_OK);
        assert_true(fabs(p[0] - (at[0] + 0.5)) <= 1e-15 && fabs(p[1] - 4 * at[1]) <= 1e-15);
        assert_true(fabs(p[2] - at[1]) <= 1e-15);
    }
    for (int i = 0; i < 8; i++) {
        for (int d = 0; d < 3; d++) at[d] = i >> d & 1;
        assert_int_equal(kn_spline_eval(ctx, p, volume, at), KN_OK);
        assert_true(p[0] == at[0] && p[1] == 2 * at[1] && p[2] == at[2] + 0.5 * at[0] * at[1]);
    }
}

static void kinds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(parse(ctx, &model, sample), KN_OK);
    assert_int_equal(model.nsplines, 4);
    check_splines(ctx, &model);
    const kn_spline *line = &model.splines[3];
    double at = 1.5, p[3];
    assert_int_equal(line->degree[0], 1);
    assert_int_equal(kn_spline_eval(ctx, p, line, &at), KN_OK);
    assert_true(p[0] == 1 && p[1] == 1 && p[2] == 0);

    // The square is two triangles; of the other polygon nothing is left.
    static const uint32_t corners[] = {0, 1, 2, 0, 2, 3};
    assert_int_equal(model.mesh.ntriangles, 2);
    assert_int_equal(model.mesh.nvertices, 7);
    assert_memory_equal(model.mesh.triangle, corners, sizeof corners);
    assert_true(model.mesh.position[6] == 1 && model.mesh.position[7] == 1 && model.mesh.position[8] == 0);
    assert_null(model.mesh.normal);
    kn_model_clear(ctx, &model);
    assert_null(model.mesh.position);
    test_ctx_end(ctx, &memory);
}

static void errors_name_line_and_value(void **state)
{
    (void)state;
    static const struct {
        const char *text, *message;
        kn_status status;
    } cases[] = {
        {"", "no curve", KN_EPARSE},
        {"nothing but words", "no curve", KN_EPARSE},
        {"[OBJECT A\n", "x.itd:2: the file ends where ']'", KN_EPARSE},
        {"]", "bracket is not opened", KN_EPARSE},
        {"[OBJECT A [TRIMSRF [SURFACE", "not read: TRIMSRF", KN_EPARSE},
        {"[CURVE BEZIER 2 E3 [0 0 0]\n[1 0 x]]", "x.itd:2: control point is not a number: x", KN_EPARSE},
        {"[CURVE BEZIER 2 E3 [0 0 0] [1 0 0 0]]", "']' after a control point is missing: 0", KN_EPARSE},
        {"[CURVE BEZIER 2 E3 [0 0 0] [1 0]]", "control point is not a number: ]", KN_EPARSE},
        {"[CURVE BEZIER 2 E3 [0 0 0] [1 0 0] [2 0 0]]", "']' after the control points is missing", KN_EPARSE},
        {"[CURVE BEZIER 2 E3 [0 0 0] [1 0 0]", "the file ends", KN_EPARSE},
        {"[CURVE BEZIER 2 E0 [0] [1]]", "none of E1", KN_EPARSE},
        {"[CURVE BEZIER 2 P1 [1 0] [0 1]]", "weight is not positive: 0", KN_EPARSE},
        {"[CURVE BEZIER 2 P1 [1 0] [1 1e999]]", "not finite", KN_EPARSE},
        {"[CURVE HERMITE 2 E3]", "neither BEZIER nor BSPLINE", KN_EPARSE},
        {"[CURVE BSPLINE 2 2 E3 [KV 0 0 1 0.5] [0 0 0] [1 0 0]]", "knots decrease", KN_EPARSE},
        {"[CURVE BSPLINE 2 2 E3 [KV 0 0 0 1] [0 0 0] [1 0 0]]", "more than 2 times", KN_EPARSE},
        {"[CURVE BSPLINE 2 2 E3 [KVP 0 0 1 1] [0 0 0] [1 0 0]]", "periodic", KN_EPARSE},
        {"[CURVE BSPLINE 1 2 E3 [KV 0 0 1]]", "fewer than the order", KN_EPARSE},
        {"[CURVE BEZIER 58 E3 [0 0 0]]", "order 58", KN_ELIMIT},
        {"[CURVE BSPLINE 1000000000 4 E3 [KV 0 0 0 0 1]]", "bytes follow", KN_EPARSE},
        {"[SURFACE BEZIER 2 2 E3 [0 0 0] [1 0 0] [2 0 0] [3 0 0]]", "zero area", KN_EPARSE},
        {"[POLYGON 2 [0 0 0] [1 0 0]]", "polygon of 2", KN_EPARSE},
        {"[POLYLINE 1 [0 0 0]]", "polyline of 1", KN_EPARSE},
        {"[POLYGON 1000000000 [0 0 0]]", "bytes follow", KN_EPARSE},
        {"[POLYGON 3 [0 0 0] [1 0 0] [INNER 1 1 0]]", "not a number: INNER", KN_EPARSE},
        {"[OBJECT A [[CURVE", "keyword is missing", KN_EPARSE},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        kn_ctx_clear_error(ctx);
        assert_int_equal(parse(ctx, &model, cases[i].text), cases[i].status);
        if (!strstr(kn_ctx_message(ctx), cases[i].message)) fail_msg("%s: %s", cases[i].text, kn_ctx_message(ctx));
        assert_int_equal(strncmp(kn_ctx_message(ctx), "x.itd:", 6), 0);
        assert_null(model.splines);
    }
    test_ctx_end(ctx, &memory);
}

static void deep_nesting_costs_nothing(void **state)
{
    (void)state;
    enum { DEPTH = 20000 };
    static char text[3 * DEPTH + 64];
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    size_t n = 0;
    for (int i = 0; i < DEPTH; i++) n += (size_t)snprintf(text + n, sizeof text - n, "[A");
    for (int i = 0; i < DEPTH; i++) text[n++] = ']';
    snprintf(text + n, sizeof text - n, "[CURVE BEZIER 2 E1 [0] [1]]");
    assert_int_equal(parse(ctx, &model, text), KN_OK);
    assert_int_equal(model.nsplines, 1);
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

// From a file, by its ending, as a model and as a tile.
static void files(void **state)
{
    (void)state;
    static const char tile_text[] = "[OBJECT T [SURFACE BEZIER 2 2 E3 [0 0 1] [2 0 1] [0 4 1] [2 4 3]]\n"
                                    "[POLYGON 3 [0 0 0] [2 0 0] [0 4 0]]]";
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    kn_tile tile = {0};
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "model.ITD");
    test_write_file(path, tile_text, sizeof tile_text - 1);
    assert_int_equal(kn_read_itd(ctx, &model, path), KN_OK);
    assert_int_equal(kn_read_model(ctx, &model, path), KN_OK); // gives up what it held
    assert_int_equal(model.nsplines, 1);
    kn_model_clear(ctx, &model);
    const double cell[4] = {0, 0, 2, 4};
    assert_int_equal(kn_read_tile(ctx, &tile, path, cell), KN_OK);
    assert_int_equal(tile.parts[0].nsplines, 1);
    assert_true(tile.parts[0].splines[0].coef[3] == 1 && tile.parts[0].splines[0].coef[7] == 1); // u, v of the corner
    assert_true(tile.parts[0].mesh.position[3] == 1 && tile.parts[0].mesh.position[7] == 1);
    assert_true(fabs(tile.aspect - 1 / sqrt(8)) <= 1e-15);
    kn_tile_clear(ctx, &tile);
    remove(path);
    assert_int_equal(kn_read_itd(ctx, &model, path), KN_EIO);
    test_ctx_end(ctx, &memory);
}

static kn_status parse_all(kn_ctx *ctx, void *user)
{
    kn_model model = {0};
    kn_status status = parse(ctx, &model, user);
    if (status != KN_OK) assert_true(!model.splines && !model.mesh.position);
    kn_model_clear(ctx, &model);
    return status;
}

static void running_out_of_memory(void **state)
{
    (void)state;
    static char text[sizeof sample];
    memcpy(text, sample, sizeof sample);
    test_allocation_failures(parse_all, text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kinds),
        cmocka_unit_test(errors_name_line_and_value),
        cmocka_unit_test(deep_nesting_costs_nothing),
        cmocka_unit_test(files),
        cmocka_unit_test(running_out_of_memory),
    };
    return cmocka_run_group_tests_name("io/read_itd", tests, NULL, NULL);
}
