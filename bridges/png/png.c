// SPDX-License-Identifier: Apache-2.0
// kn_png_write: 8-bit RGB and RGBA pictures through libpng, streamed into an output file.
#include "bridges/png/png.h"
#include "io/out_file.h"
#include "kernel/context.h"

#include <png.h>
#include <setjmp.h>

// What libpng's callbacks see. status is the first failure among them.
typedef struct writer {
    kn_ctx *ctx;
    kn_out_file *file;
    kn_status status;
} writer;

static void on_error(png_structp png, png_const_charp message)
{
    writer *w = png_get_error_ptr(png);
    if (w->status == KN_OK) w->status = kn_fail(w->ctx, KN_EIO, "png: %s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    const writer *w = png_get_error_ptr(png);
    kn_log(w->ctx, KN_LOG_WARNING, "png: %s", message);
}

static void on_write(png_structp png, png_bytep data, size_t bytes)
{
    writer *w = png_get_io_ptr(png);
    w->status = kn_out_write(w->ctx, w->file, data, bytes);
    if (w->status != KN_OK) png_error(png, "the file refuses");
}

static void on_flush(png_structp png)
{
    (void)png; // commit flushes
}

static png_voidp on_allocate(png_structp png, png_alloc_size_t bytes)
{
    writer *w = png_get_mem_ptr(png);
    void *block = kn_alloc(w->ctx, 1, bytes);
    if (!block) w->status = KN_ENOMEM;
    return block;
}

static void on_release(png_structp png, png_voidp block)
{
    const writer *w = png_get_mem_ptr(png);
    kn_free(w->ctx, block);
}

// libpng leaves by longjmp on errors, so nothing here changes between setjmp and the calls that may jump.
static void write_image(png_structp png, png_infop info, const uint8_t *pixels, int width, int height, int channels)
{
    if (setjmp(png_jmpbuf(png)) != 0) return;
    png_set_write_fn(png, png_get_error_ptr(png), on_write, on_flush);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, 8,
                 channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    for (int y = 0; y < height; y++) png_write_row(png, pixels + (size_t)y * (size_t)width * (size_t)channels);
    png_write_end(png, info);
}

static kn_status write_png(writer *w, const uint8_t *pixels, int width, int height, int channels)
{
    png_structp png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, w, on_error, on_warning, w, on_allocate,
                                                on_release);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (info)
        write_image(png, info, pixels, width, height, channels);
    else if (w->status == KN_OK)
        w->status = kn_fail(w->ctx, KN_EIO, "png: libpng refuses to start");
    png_destroy_write_struct(&png, &info);
    return w->status;
}

kn_status kn_png_write(kn_ctx *ctx, const char *path, const uint8_t *pixels, int width, int height, int channels)
{
    if (width < 1 || height < 1 || (channels != 3 && channels != 4))
        return kn_fail(ctx, KN_EDOMAIN, "png: %d x %d pixels of %d channels", width, height, channels);
    if (width > KN_PNG_MAX_SIDE || height > KN_PNG_MAX_SIDE)
        return kn_fail(ctx, KN_ELIMIT, "png: %d x %d pixels, above %d", width, height, KN_PNG_MAX_SIDE);
    writer w = {.ctx = ctx};
    kn_status status = kn_out_open(ctx, &w.file, path);
    if (status == KN_OK) status = write_png(&w, pixels, width, height, channels);
    if (status == KN_OK) status = kn_out_commit(ctx, w.file);
    kn_out_close(ctx, w.file);
    return status;
}
