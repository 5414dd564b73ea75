// SPDX-License-Identifier: Apache-2.0
// PNG: the file's chunks parsed here, pixels read back through libpng, failures.
#include "tests/support/support.h"

#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bridges/png/png.h"

static uint32_t big_endian(const char *p)
{
    const unsigned char *b = (const unsigned char *)p;
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | (uint32_t)b[3];
}

static void assert_nothing_at(const char *path)
{
    char temporary[TEST_PATH_BYTES + 16];
    snprintf(temporary, sizeof temporary, "%s.tmp-0", path);
    FILE *a = fopen(path, "rb"), *b = fopen(temporary, "rb");
    assert_null(a);
    assert_null(b);
}

// Signature; IHDR with the size, 8 bits, the colour type; sRGB; IDAT; IEND at the very end.
static void check_chunks(const char *path, uint32_t width, uint32_t height, char colour)
{
    size_t bytes;
    char *file = test_read_file(path, &bytes);
    assert_non_null(file);
    assert_true(bytes > 57);
    assert_memory_equal(file, "\x89PNG\r\n\x1a\n", 8);
    assert_memory_equal(file + 12, "IHDR", 4);
    assert_int_equal(big_endian(file + 16), width);
    assert_int_equal(big_endian(file + 20), height);
    assert_int_equal(file[24], 8);
    assert_int_equal(file[25], colour);
    bool srgb = false, data = false;
    size_t at = 8;
    while (at + 12 < bytes) {
        srgb = srgb || !memcmp(file + at + 4, "sRGB", 4);
        data = data || !memcmp(file + at + 4, "IDAT", 4);
        at += 12 + big_endian(file + at);
    }
    assert_int_equal(at + 12, bytes);
    assert_memory_equal(file + at + 4, "IEND", 4);
    assert_true(srgb && data);
    free(file);
}

static void pixels_come_back(void **state)
{
    (void)state;
    enum { WIDTH = 61, HEIGHT = 23 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    uint8_t pixels[WIDTH * HEIGHT * 4], back[WIDTH * HEIGHT * 4];
    for (size_t i = 0; i < sizeof pixels; i++) pixels[i] = (uint8_t)test_int(&rng, 0, 255);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "pixels.png");
    for (int channels = 3; channels <= 4; channels++) {
        assert_int_equal(kn_png_write(ctx, path, pixels, WIDTH, HEIGHT, channels), KN_OK);
        check_chunks(path, WIDTH, HEIGHT, channels == 3 ? 2 : 6);
        png_image image = {.version = PNG_IMAGE_VERSION};
        assert_true(png_image_begin_read_from_file(&image, path));
        image.format = channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
        assert_true(png_image_finish_read(&image, NULL, back, 0, NULL));
        assert_memory_equal(pixels, back, WIDTH * HEIGHT * (size_t)channels);
    }
    remove(path);
    test_ctx_end(ctx, &memory);
}

static void bad_requests_are_refused(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const uint8_t pixels[4] = {1, 2, 3, 4};
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "refused.png");
    assert_int_equal(kn_png_write(ctx, path, pixels, 0, 1, 3), KN_EDOMAIN);
    assert_int_equal(kn_png_write(ctx, path, pixels, 1, -1, 3), KN_EDOMAIN);
    assert_int_equal(kn_png_write(ctx, path, pixels, 1, 1, 2), KN_EDOMAIN);
    assert_int_equal(kn_png_write(ctx, path, pixels, KN_PNG_MAX_SIDE + 1, 1, 3), KN_ELIMIT);
    assert_nothing_at(path);
    test_tmp_path(path, "no such folder/refused.png");
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_png_write(ctx, path, pixels, 1, 1, 4), KN_EIO);
    assert_non_null(strstr(kn_ctx_message(ctx), "no such folder/refused.png"));
    test_ctx_end(ctx, &memory);
}

// Pixels that do not compress, enough of them to reach the file before it is closed.
static void a_full_disk_is_reported(void **state)
{
    (void)state;
    FILE *full = fopen("/dev/full", "wb");
    if (!full) skip();
    fclose(full);
    enum { SIDE = 128 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    uint8_t pixels[SIDE * SIDE * 3];
    for (size_t i = 0; i < sizeof pixels; i++) pixels[i] = (uint8_t)test_int(&rng, 0, 255);
    assert_int_equal(kn_png_write(ctx, "/dev/full", pixels, SIDE, SIDE, 3), KN_EIO);
    assert_int_equal(kn_ctx_error(ctx), KN_EIO);
    assert_int_equal(kn_png_write(ctx, "/dev/full", pixels, 2, 2, 3), KN_EIO); // refused at the end only
    test_ctx_end(ctx, &memory);
}

static kn_status write_small(kn_ctx *ctx, void *path)
{
    const uint8_t pixels[12] = {0};
    kn_status status = kn_png_write(ctx, path, pixels, 2, 2, 3);
    if (status != KN_OK) assert_nothing_at(path);
    remove(path);
    return status;
}

static void running_out_of_memory_leaves_nothing(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "memory.png");
    test_allocation_failures(write_small, path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_come_back),
        cmocka_unit_test(bad_requests_are_refused),
        cmocka_unit_test(a_full_disk_is_reported),
        cmocka_unit_test(running_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests_name("bridges/png", tests, NULL, NULL);
}
