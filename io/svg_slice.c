// SPDX-License-Identifier: Apache-2.0
// kn_write_svg_slice: one layer as an SVG drawing in millimetres.
#include "io/out_file.h"
#include "io/text_buffer.h"
#include "kernel/context.h"

#include <knurl/io.h>
#include <math.h>

enum { DIGITS = 9 };

static void number(kn_text *t, const char *before, double x)
{
    kn_text_put(t, before);
    kn_text_plain_real(t, x, DIGITS);
}

// M x,y L x,y .. Z
static void loop_path(kn_text *t, const kn_slice_loop *loop, double unit)
{
    for (size_t i = 0; i < loop->npoints; i++) {
        number(t, i == 0 ? "M" : "L", loop->points[2 * i] * unit);
        number(t, ",", loop->points[2 * i + 1] * unit);
        if (i % 8 == 7) kn_text_newline(t);
    }
    kn_text_put(t, loop->closed ? "Z\n" : "\n");
}

// stroke: of open contours, which have no inside to fill.
static void paths(kn_text *t, const kn_slice *layer, double unit, bool closed, double stroke)
{
    bool any = false;
    for (size_t i = 0; i < layer->nloops; i++) {
        if (layer->loops[i].closed != closed) continue;
        if (!any && closed) {
            kn_text_put(t, "<path class=\"closed\" fill=\"#222\" fill-rule=\"nonzero\" d=\"\n");
        } else if (!any) {
            number(t, "<path class=\"open\" fill=\"none\" stroke=\"#c22\" stroke-width=\"", stroke);
            kn_text_put(t, "\" d=\"\n");
        }
        any = true;
        loop_path(t, &layer->loops[i], unit);
    }
    if (any) kn_text_put(t, "\"/>\n");
}

// y points up: the drawing is turned over.
static void format(kn_text *t, const kn_slice *layer, const kn_svg_options *o)
{
    double unit = o->unit_mm > 0.0 ? o->unit_mm : 1.0;
    double width = (o->box[2] - o->box[0]) * unit, height = (o->box[3] - o->box[1]) * unit;
    kn_text_put(t, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"");
    number(t, "", width);
    number(t, "mm\" height=\"", height);
    number(t, "mm\" viewBox=\"", o->box[0] * unit);
    number(t, " ", -o->box[3] * unit);
    number(t, " ", width);
    number(t, " ", height);
    number(t, "\">\n<title>z = ", layer->z * unit);
    kn_text_put(t, " mm</title>\n<g transform=\"scale(1,-1)\">\n");
    paths(t, layer, unit, true, 0.0);
    paths(t, layer, unit, false, width / 600.0);
    kn_text_put(t, "</g>\n</svg>\n");
}

kn_status kn_write_svg_slice(kn_ctx *ctx, const char *path, const kn_slice *layer, const kn_svg_options *o)
{
    for (int i = 0; i < 4; i++)
        if (!isfinite(o->box[i])) return kn_fail(ctx, KN_EDOMAIN, "%s: the drawing's box is not finite", path);
    if (!(o->box[0] < o->box[2] && o->box[1] < o->box[3]) || !(o->unit_mm >= 0.0) || !isfinite(o->unit_mm))
        return kn_fail(ctx, KN_EDOMAIN, "%s: a drawing from %g,%g to %g,%g in units of %g mm", path, o->box[0],
                       o->box[1], o->box[2], o->box[3], o->unit_mm);
    kn_out_file *file = NULL;
    kn_text text = {.ctx = ctx};
    kn_status status = kn_out_open(ctx, &file, path);
    if (status != KN_OK) return status;
    format(&text, layer, o);
    status = text.failed ? KN_ENOMEM : kn_out_write(ctx, file, text.data, text.bytes);
    if (status == KN_OK) status = kn_out_commit(ctx, file);
    kn_out_close(ctx, file);
    kn_text_clear(&text);
    return status;
}
