// SPDX-License-Identifier: Apache-2.0
// kn_legend_draw: text and a bar of colours through cairo's image surfaces.
#include "bridges/cairo/legend.h"
#include "kernel/context.h"

#include <cairo/cairo.h>

// Shares of the band: its margin, the height of texts, and where lines stand.
static const double margin = 0.34, title_size = 0.21, text_size = 0.165;
static const double title_line = 0.42, subtitle_line = 0.70, mark_line = 0.25, bar_top = 0.38, bar_bottom = 0.60,
                    tick_line = 0.83;

typedef struct rgb_color {
    double r, g, b;
} rgb_color;
static const rgb_color paper = {0.965, 0.963, 0.957}, ink = {0.10, 0.11, 0.13}, pale_ink = {0.36, 0.37, 0.40};

typedef enum alignment { LEFT, CENTRE } alignment;

static void set_color(cairo_t *c, rgb_color color)
{
    cairo_set_source_rgb(c, color.r, color.g, color.b);
}

// Smaller where it would be wider than `room`. Text at the ends of the bar may reach to the picture's edge, no further.
static void draw_text(cairo_t *c, const char *text, double x, double y, double size, bool bold, alignment align,
                      double room)
{
    cairo_text_extents_t e;
    cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c, size);
    cairo_text_extents(c, text, &e);
    if (e.width > room && e.width > 0) {
        cairo_set_font_size(c, size * room / e.width);
        cairo_text_extents(c, text, &e);
    }
    cairo_move_to(c, align == CENTRE ? x - e.width / 2 - e.x_bearing : x, y);
    cairo_show_text(c, text);
}

// One column of pixels has one colour, so that no filter blurs a break in the colours.
static void draw_bar(cairo_t *c, const kn_legend *l, int left, int right, double top, double bottom)
{
    cairo_set_antialias(c, CAIRO_ANTIALIAS_NONE);
    for (int x = left; x < right; x++) {
        int i = (int)(((double)(x - left) + 0.5) / (double)(right - left) * (double)l->ncolors);
        const uint8_t *p = l->colors + 3 * (i < l->ncolors ? i : l->ncolors - 1);
        set_color(c, (rgb_color){p[0] / 255.0, p[1] / 255.0, p[2] / 255.0});
        cairo_rectangle(c, x, top, 1, bottom - top);
        cairo_fill(c);
    }
    cairo_set_antialias(c, CAIRO_ANTIALIAS_DEFAULT);
}

static void draw_scale(cairo_t *c, const kn_legend *l, double left, double right, double h)
{
    double room = l->nticks > 1 ? (right - left) / l->nticks : right - left;
    draw_bar(c, l, (int)left, (int)right, bar_top * h, bar_bottom * h);
    cairo_set_line_width(c, h * 0.012 > 1 ? h * 0.012 : 1);
    for (int i = 0; i < l->nticks; i++) {
        double x = left + l->ticks[i].at * (right - left);
        set_color(c, ink);
        cairo_move_to(c, x, bar_bottom * h);
        cairo_line_to(c, x, (bar_bottom + 0.05) * h);
        cairo_stroke(c);
        draw_text(c, l->ticks[i].label, x, tick_line * h, text_size * h, false, CENTRE, 1.1 * room);
    }
    if (!l->mark) return;
    double x = left + l->mark->at * (right - left), wide = 0.045 * h;
    set_color(c, ink);
    cairo_move_to(c, x, bar_top * h);
    cairo_line_to(c, x - wide, (bar_top - 0.08) * h);
    cairo_line_to(c, x + wide, (bar_top - 0.08) * h);
    cairo_close_path(c);
    cairo_fill(c);
    draw_text(c, l->mark->label, x, mark_line * h, text_size * h, true, CENTRE, right - left);
}

static void draw(cairo_t *c, const kn_legend *l, double w, double h)
{
    double edge = margin * h < 0.05 * w ? margin * h : 0.05 * w, left = 0.50 * w, right = w - 2 * edge;
    set_color(c, paper);
    cairo_paint(c);
    set_color(c, ink);
    if (l->title) draw_text(c, l->title, edge, title_line * h, title_size * h, true, LEFT, left - 2.5 * edge);
    set_color(c, pale_ink);
    if (l->subtitle)
        draw_text(c, l->subtitle, edge, subtitle_line * h, text_size * h, false, LEFT, left - 2.5 * edge);
    draw_scale(c, l, left, right, h);
}

// Cairo keeps a pixel as a 32-bit number, red above green above blue.
static void copy_pixels(uint8_t *rgb, int width, int height, cairo_surface_t *surface)
{
    cairo_surface_flush(surface);
    const unsigned char *from = cairo_image_surface_get_data(surface);
    size_t stride = (size_t)cairo_image_surface_get_stride(surface);
    for (int y = 0; y < height; y++) {
        const uint32_t *row = (const uint32_t *)(const void *)(from + (size_t)y * stride);
        for (int x = 0; x < width; x++, rgb += 3)
            rgb[0] = (uint8_t)(row[x] >> 16), rgb[1] = (uint8_t)(row[x] >> 8), rgb[2] = (uint8_t)row[x];
    }
}

static kn_status check(kn_ctx *ctx, int width, int height, const kn_legend *l)
{
    if (width < 1 || height < KN_LEGEND_MIN_HEIGHT || l->ncolors < 1 || l->nticks < 0)
        return kn_fail(ctx, KN_EDOMAIN, "legend: %d x %d pixels, %d colours, %d ticks", width, height, l->ncolors,
                       l->nticks);
    if (width > KN_LEGEND_MAX_SIDE || height > KN_LEGEND_MAX_SIDE)
        return kn_fail(ctx, KN_ELIMIT, "legend: %d x %d pixels, above %d", width, height, KN_LEGEND_MAX_SIDE);
    for (int i = 0; i < l->nticks + (l->mark != NULL); i++) {
        double at = i < l->nticks ? l->ticks[i].at : l->mark->at;
        if (!(at >= 0 && at <= 1)) return kn_fail(ctx, KN_EDOMAIN, "legend: a tick at %g, outside [0,1]", at);
    }
    return KN_OK;
}

kn_status kn_legend_draw(kn_ctx *ctx, uint8_t *rgb, int width, int height, const kn_legend *legend)
{
    kn_status status = check(ctx, width, height, legend);
    if (status != KN_OK) return status;
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
    cairo_t *c = cairo_create(surface);
    draw(c, legend, width, height);
    cairo_status_t trouble = cairo_status(c);
    if (trouble == CAIRO_STATUS_SUCCESS) copy_pixels(rgb, width, height, surface);
    cairo_destroy(c);
    cairo_surface_destroy(surface);
    if (trouble == CAIRO_STATUS_SUCCESS) return KN_OK;
    return trouble == CAIRO_STATUS_NO_MEMORY
               ? kn_fail(ctx, KN_ENOMEM, "legend: no memory for %d x %d pixels", width, height)
               : kn_fail(ctx, KN_EDOMAIN, "legend: cairo: %s", cairo_status_to_string(trouble));
}
