// SPDX-License-Identifier: Apache-2.0
// kn_png_read_gray: pictures as fields, through libpng.
#include "bridges/png/gray.h"
#include "io/in_file.h"
#include "kernel/context.h"

#include <png.h>
#include <setjmp.h>
#include <string.h>

// What libpng's callbacks see. status is the first failure among them.
typedef struct reader {
    kn_ctx *ctx;
    const char *path;
    const char *text;
    size_t at, bytes;
    kn_status status;
    uint32_t width, height;
    int channels; // 1: grey, 3: colours; two bytes each
    uint8_t *pixels;
} reader;

static void on_error(png_structp png, png_const_charp message)
{
    reader *r = png_get_error_ptr(png);
    if (r->status == KN_OK) r->status = kn_fail(r->ctx, KN_EPARSE, "%s: %s", r->path, message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    const reader *r = png_get_error_ptr(png);
    kn_log(r->ctx, KN_LOG_WARNING, "%s: %s", r->path, message);
}

static void on_read(png_structp png, png_bytep data, size_t bytes)
{
    reader *r = png_get_io_ptr(png);
    if (bytes > r->bytes - r->at) png_error(png, "the picture ends too early");
    memcpy(data, r->text + r->at, bytes);
    r->at += bytes;
}

static png_voidp on_allocate(png_structp png, png_alloc_size_t bytes)
{
    reader *r = png_get_mem_ptr(png);
    void *block = kn_alloc(r->ctx, 1, bytes);
    if (!block) r->status = KN_ENOMEM;
    return block;
}

static void on_release(png_structp png, png_voidp block)
{
    const reader *r = png_get_mem_ptr(png);
    kn_free(r->ctx, block);
}

// libpng leaves by longjmp on errors: all that changes lies in *r.
static void read_pixels(png_structp png, png_infop info, reader *r)
{
    if (setjmp(png_jmpbuf(png)) != 0) return;
    png_set_read_fn(png, r, on_read);
    png_set_user_limits(png, 1u << 26, 1u << 26);
    png_read_info(png, info);
    r->width = png_get_image_width(png, info);
    r->height = png_get_image_height(png, info);
    if ((size_t)r->width > KN_PNG_MAX_GRAY / r->height) {
        r->status = kn_fail(r->ctx, KN_ELIMIT, "%s: %u x %u pixels, above %zu", r->path, (unsigned)r->width,
                            (unsigned)r->height, KN_PNG_MAX_GRAY);
        png_error(png, "too large");
    }
    png_set_expand_16(png);
    png_set_strip_alpha(png);
    int passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    r->channels = png_get_channels(png, info);
    size_t row = png_get_rowbytes(png, info);
    r->pixels = kn_alloc(r->ctx, r->height, row);
    if (!r->pixels) {
        r->status = KN_ENOMEM;
        png_error(png, "out of memory");
    }
    for (int pass = 0; pass < passes; pass++)
        for (uint32_t y = 0; y < r->height; y++) png_read_row(png, r->pixels + y * row, NULL);
    png_read_end(png, info);
}

static double level(const uint8_t *pixel, int channels)
{
    static const double luma[3] = {0.2126, 0.7152, 0.0722};
    double sum = 0;
    for (int c = 0; c < channels; c++) {
        double x = (256 * pixel[2 * c] + pixel[2 * c + 1]) / 65535.0;
        sum += channels == 1 ? x : luma[c] * x;
    }
    return sum;
}

// From rows downwards to u slowest and v upwards.
static kn_status make_samples(const reader *r, kn_field_samples *out)
{
    if (r->channels != 1 && r->channels != 3)
        return kn_fail(r->ctx, KN_EPARSE, "%s: %d channels", r->path, r->channels);
    size_t w = r->width, h = r->height, nu = w > 1 ? w : 2, nv = h > 1 ? h : 2;
    double *values = kn_alloc(r->ctx, nu * nv, sizeof *values);
    if (!values) return KN_ENOMEM;
    for (size_t i = 0; i < nu; i++)
        for (size_t j = 0; j < nv; j++) {
            size_t x = i < w ? i : w - 1, y = j < h ? h - 1 - j : 0;
            values[i * nv + j] = level(r->pixels + (y * w + x) * (size_t)r->channels * 2, r->channels);
        }
    *out = (kn_field_samples){.n = {(int)nu, (int)nv}, .values = values};
    return KN_OK;
}

static kn_status read_png(reader *r)
{
    png_structp png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, r, on_error, on_warning, r, on_allocate,
                                               on_release);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (info)
        read_pixels(png, info, r);
    else if (r->status == KN_OK)
        r->status = kn_fail(r->ctx, KN_EIO, "png: libpng refuses to start");
    png_destroy_read_struct(&png, &info, NULL);
    return r->status;
}

kn_status kn_png_read_gray(kn_ctx *ctx, kn_field_samples *out, const char *path)
{
    char *text = NULL;
    reader r = {.ctx = ctx, .path = path};
    kn_status status = kn_in_read(ctx, &text, &r.bytes, path);
    r.text = text;
    if (status == KN_OK && (r.bytes < 8 || png_sig_cmp((png_const_bytep)text, 0, 8) != 0))
        status = kn_fail(ctx, KN_EPARSE, "%s: not a PNG", path);
    if (status == KN_OK) status = read_png(&r);
    if (status == KN_OK) status = make_samples(&r, out);
    kn_free(ctx, r.pixels);
    kn_free(ctx, text);
    return status;
}
