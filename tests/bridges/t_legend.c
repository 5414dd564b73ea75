// SPDX-License-Identifier: Apache-2.0
// The legend: its bar has the colours that were given, its texts leave ink, and nothing else of the picture changes.
#include "tests/support/support.h"

#include <stdlib.h>
#include <string.h>

#if KN_WITH_CAIRO
#include "bridges/cairo/legend.h"

enum { WIDTH = 640, HEIGHT = 64, BYTES = 3 * WIDTH * HEIGHT };

static const uint8_t colors[6] = {200, 30, 20, 20, 60, 200}; // red, then blue

static kn_legend plain(void)
{
    return (kn_legend){.colors = colors, .ncolors = 2};
}

static size_t count(const uint8_t *rgb, const uint8_t color[3])
{
    size_t n = 0;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) n += memcmp(rgb + 3 * i, color, 3) == 0;
    return n;
}

// Pixels darker than the paper by half.
static size_t ink(const uint8_t *rgb)
{
    size_t n = 0;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) n += rgb[3 * i] < 120 && rgb[3 * i + 1] < 120 && rgb[3 * i + 2] < 120;
    return n;
}

static void the_bar_has_its_colors(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    uint8_t *rgb = calloc(BYTES + 3, 1);
    kn_legend l = plain();
    rgb[BYTES] = 77;
    assert_int_equal(kn_legend_draw(ctx, rgb, WIDTH, HEIGHT, &l), KN_OK);
    size_t red = count(rgb, colors), blue = count(rgb, colors + 3);
    assert_true(red > 1000 && blue > 1000);
    assert_true(red < blue + HEIGHT && blue < red + HEIGHT); // halves, but for a column
    assert_int_equal(rgb[BYTES], 77);
    // Red lies left of blue in every row.
    for (size_t i = 1; i < WIDTH * HEIGHT; i++)
        if (i % WIDTH != 0 && memcmp(rgb + 3 * i, colors, 3) == 0)
            assert_true(memcmp(rgb + 3 * (i - 1), colors + 3, 3) != 0);
    free(rgb);
    test_ctx_end(ctx, &memory);
}

static void texts_leave_ink(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    uint8_t *rgb = calloc(BYTES, 1);
    const kn_legend_tick ticks[2] = {{0, "0.1"}, {1, "\u2265 3"}}, mark = {0.5, "here"};
    kn_legend l = plain();
    assert_int_equal(kn_legend_draw(ctx, rgb, WIDTH, HEIGHT, &l), KN_OK);
    size_t before = ink(rgb);
    l.title = "A title that is by far too long for the half of the picture that it may have, and shrinks";
    assert_int_equal(kn_legend_draw(ctx, rgb, WIDTH, HEIGHT, &l), KN_OK);
    size_t titled = ink(rgb);
    assert_true(titled > before);
    for (size_t y = 0; y < HEIGHT; y++) // not into the bar's half
        assert_true(rgb[3 * (y * WIDTH + WIDTH / 2 - 4)] > 200);
    l.ticks = ticks, l.nticks = 2, l.mark = &mark;
    assert_int_equal(kn_legend_draw(ctx, rgb, WIDTH, HEIGHT, &l), KN_OK);
    assert_true(ink(rgb) > titled);
    free(rgb);
    test_ctx_end(ctx, &memory);
}

static void bad_requests_are_refused(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    uint8_t rgb[6] = {1, 2, 3, 4, 5, 6};
    const kn_legend_tick outside = {1.5, "x"};
    kn_legend l = plain();
    assert_int_equal(kn_legend_draw(ctx, rgb, 0, HEIGHT, &l), KN_EDOMAIN);
    assert_int_equal(kn_legend_draw(ctx, rgb, 1, KN_LEGEND_MIN_HEIGHT - 1, &l), KN_EDOMAIN);
    assert_int_equal(kn_legend_draw(ctx, rgb, KN_LEGEND_MAX_SIDE + 1, HEIGHT, &l), KN_ELIMIT);
    l.mark = &outside;
    assert_int_equal(kn_legend_draw(ctx, rgb, WIDTH, HEIGHT, &l), KN_EDOMAIN);
    l.mark = NULL, l.ncolors = 0;
    assert_int_equal(kn_legend_draw(ctx, rgb, WIDTH, HEIGHT, &l), KN_EDOMAIN);
    for (uint8_t i = 0; i < 6; i++) assert_int_equal(rgb[i], i + 1);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bar_has_its_colors),
        cmocka_unit_test(texts_leave_ink),
        cmocka_unit_test(bad_requests_are_refused),
    };
    return cmocka_run_group_tests_name("bridges/legend", tests, NULL, NULL);
}
#else
int main(void)
{
    return 0;
}
#endif
