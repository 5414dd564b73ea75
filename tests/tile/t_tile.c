// SPDX-License-Identifier: Apache-2.0
// Tiles: life, check, quarter turns; the end of a sink.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <math.h>
#include <string.h>

static void life(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile = {0}, none = {0};
    assert_int_equal(kn_tile_init(ctx, &tile, "name", 3), KN_OK);
    assert_string_equal(tile.name, "name");
    assert_int_equal(tile.nparts, 3);
    assert_int_equal(tile.parts[2].nsplines, 0);
    kn_tile_clear(ctx, &tile);
    kn_tile_clear(ctx, &tile); // empty now
    kn_tile_clear(ctx, NULL);

    char longest[KN_NAME_BYTES + 1] = {0};
    memset(longest, 'x', KN_NAME_BYTES);
    assert_int_equal(kn_tile_init(ctx, &none, longest, 1), KN_ELIMIT);
    assert_int_equal(kn_tile_init(ctx, &none, "x", 0), KN_EDOMAIN);
    assert_null(none.parts);
    longest[KN_NAME_BYTES - 1] = 0;
    assert_int_equal(kn_tile_init(ctx, &tile, longest, 1), KN_OK);
    kn_spline s = {0};
    assert_int_equal(kn_tile_add(ctx, &tile, 1, &s), KN_EDOMAIN);
    assert_int_equal(kn_tile_add(ctx, &tile, -1, &s), KN_EDOMAIN);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static void check_names_what_is_wrong(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile = {0};
    assert_int_equal(kn_tile_init(ctx, &tile, "empty", 1), KN_OK);
    assert_int_equal(kn_tile_check(ctx, &tile), KN_EDOMAIN); // no surfaces
    kn_tile_clear(ctx, &tile);

    for (int wrong = 0; wrong < 6; wrong++) {
        scene_dome(ctx, &tile);
        strcpy(tile.parts[0].name, "roof");
        kn_spline *s = &tile.parts[0].splines[2];
        size_t n = kn_spline_count(s);
        kn_ctx_clear_error(ctx);
        if (wrong == 0) assert_int_equal(kn_tile_check(ctx, &tile), KN_OK);
        if (wrong == 1) s->coef[4] = NAN;
        if (wrong == 2) s->coef[5] = INFINITY;
        if (wrong == 3) // all on one line
            for (size_t i = 0; i < n; i++)
                s->coef[i] = 0.1 * (double)i, s->coef[n + i] = 0.3 * (double)i, s->coef[2 * n + i] = 1.0 / 3;
        if (wrong == 4) // t does not move it
            for (size_t i = 0; i < 3 * n; i++) s->coef[i] = s->coef[i - i % 3];
        if (wrong == 5) s->ncomp = 2;
        if (wrong > 0) {
            assert_int_equal(kn_tile_check(ctx, &tile), KN_EDOMAIN);
            assert_non_null(strstr(kn_ctx_message(ctx), "roof"));
            assert_non_null(strstr(kn_ctx_message(ctx), "surface 2"));
        }
        s->ncomp = 3;
        kn_tile_clear(ctx, &tile);
    }
    scene_dome(ctx, &tile);
    tile.aspect = NAN;
    assert_int_equal(kn_tile_check(ctx, &tile), KN_EDOMAIN);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// (u, v) -> (1 - v, u), bit for bit, and four of them are none.
static void quarter_turns(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int turns = -5; turns <= 6; turns++) {
        kn_tile tile = {0}, turned = {0};
        scene_strip(ctx, &tile);
        scene_strip(ctx, &turned);
        assert_int_equal(kn_tile_rotate(ctx, &turned, turns), KN_OK);
        const double *a = tile.parts[0].splines[0].coef, *b = turned.parts[0].splines[0].coef;
        for (int i = 0; i < 6; i++) {
            double u = a[i], v = a[6 + i];
            for (int k = 0; k < (turns + 8) % 4; k++) {
                double t = 1 - v;
                v = u, u = t;
            }
            assert_true(b[i] == u && b[6 + i] == v && b[12 + i] == a[12 + i]);
        }
        kn_tile_clear(ctx, &tile), kn_tile_clear(ctx, &turned);
    }
    kn_tile tile = {0};
    scene_strip(ctx, &tile);
    tile.parts[0].splines[0].ncomp = 2;
    assert_int_equal(kn_tile_rotate(ctx, &tile, 1), KN_EDOMAIN);
    tile.parts[0].splines[0].ncomp = 3;
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static void closing_twice(void **state)
{
    (void)state;
    scene_result result;
    kn_sink sink = scene_sink(&result);
    kn_sink_close(NULL, &sink);
    kn_sink_close(NULL, &sink);
    kn_sink_close(NULL, NULL);
    assert_int_equal(result.closed, 1);
    assert_null(sink.commit);
}

static kn_status tile_call(kn_ctx *ctx, void *user)
{
    kn_tile tile = {0};
    kn_status status = kn_tile_init(ctx, &tile, "x", 1);
    assert_true((status == KN_OK) == (tile.parts != NULL));
    for (int k = 0; status == KN_OK && k < 2; k++) {
        status = kn_tile_add(ctx, &tile, 0, user);
        assert_int_equal(tile.parts[0].nsplines, status == KN_OK ? k + 1 : k);
    }
    if (status == KN_OK) status = kn_tile_check(ctx, &tile);
    kn_tile_clear(ctx, &tile);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile = {0};
    scene_diamond(ctx, &tile);
    test_allocation_failures(tile_call, &tile.parts[0].splines[0]);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(life), cmocka_unit_test(check_names_what_is_wrong),
                                       cmocka_unit_test(quarter_turns), cmocka_unit_test(closing_twice),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("tile/tile", tests, NULL, NULL);
}
