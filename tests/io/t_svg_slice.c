// SPDX-License-Identifier: Apache-2.0
// One layer as a drawing: whole text, units, failures that leave nothing behind.
#include "tests/support/support.h"

#include <knurl/io.h>

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const double square[] = {0, 0, 4, 0, 4, 4, 0, 4.5}, line[] = {1, 1, 2, 3};
static const kn_slice_loop loops[] = {{square, 4, true, 0, 0}, {line, 2, false, 0, 0}};
static const kn_slice layer = {.z = 0.5, .loops = loops, .nloops = 2, .nopen = 1};

static void text_of(char *text, size_t room, const char *path)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    text[fread(text, 1, room - 1, file)] = 0;
    fclose(file);
}

static void drawing(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES], text[4096];
    test_tmp_path(path, "slice.svg");
    kn_svg_options o = {.unit_mm = 10, .box = {-1, -2, 5, 6}};
    assert_int_equal(kn_write_svg_slice(ctx, path, &layer, &o), KN_OK);
    text_of(text, sizeof text, path);
    const char *expected =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"60mm\" height=\"80mm\" viewBox=\"-10 -60 60 80\">\n"
        "<title>z = 5 mm</title>\n"
        "<g transform=\"scale(1,-1)\">\n"
        "<path class=\"closed\" fill=\"#222\" fill-rule=\"nonzero\" d=\"\n"
        "M0,0L40,0L40,40L0,45Z\n"
        "\"/>\n"
        "<path class=\"open\" fill=\"none\" stroke=\"#c22\" stroke-width=\"0.1\" d=\"\n"
        "M10,10L20,30\n"
        "\"/>\n"
        "</g>\n"
        "</svg>\n";
    assert_string_equal(text, expected);
    assert_int_equal(remove(path), 0);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "refused.svg");
    const kn_svg_options bad[] = {
        {1, {0, 0, 0, 1}}, {1, {0, 0, 1, NAN}}, {-1, {0, 0, 1, 1}}, {INFINITY, {0, 0, 1, 1}}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(kn_write_svg_slice(ctx, path, &layer, &bad[i]), KN_EDOMAIN);
    const kn_svg_options good = {.box = {0, 0, 1, 1}};
    assert_int_equal(kn_write_svg_slice(ctx, "/no/such/folder/x.svg", &layer, &good), KN_EIO);
    assert_int_not_equal(access(path, F_OK), 0);
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    return kn_write_svg_slice(ctx, user, &layer, &(kn_svg_options){.box = {0, 0, 1, 1}});
}

static void without_memory(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "memory.svg");
    test_allocation_failures(call, path);
    assert_int_equal(remove(path), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(drawing), cmocka_unit_test(failures),
                                       cmocka_unit_test(without_memory)};
    return cmocka_run_group_tests_name("io/svg_slice", tests, NULL, NULL);
}
