// SPDX-License-Identifier: Apache-2.0
// Fuzzes slices: patches and triangles cut by planes, contours that are joined, drawings of them.
#include "tests/fuzz/feed.h"

#include <knurl/io.h>
#include <knurl/slice.h>

#include <math.h>

static kn_status look(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    size_t *layers = user;
    if (layer->index != (*layers)++) abort();
    size_t open = 0;
    for (size_t i = 0; i < layer->nloops; i++) {
        if (layer->loops[i].npoints < 2) abort();
        open += !layer->loops[i].closed;
        for (size_t k = 0; k < 2 * layer->loops[i].npoints; k++)
            if (!isfinite(layer->loops[i].points[k])) abort();
    }
    if (open != layer->nopen) abort();
    return kn_write_svg_slice(ctx, "/dev/null", layer, &(kn_svg_options){.box = {-1, -1, 1, 1}});
}

static void cut(feed *f, kn_sink *sink, const kn_patch *patch)
{
    kn_patch_block block = {0, 1, patch};
    void *product = NULL;
    if (sink->work(f->ctx, sink->user, &block, &product) != KN_OK) return;
    feed_any(sink->commit(f->ctx, sink->user, &block, product));
}

static void patches(feed *f, kn_sink *sink)
{
    for (int i = feed_int(f, 1, 3); i > 0; i--) {
        kn_bezier a;
        feed_bezier(f, &a, 2);
        if (kn_bezier_dim(&a) == 3) {
            kn_patch p = {.bezier = a, .reversed = feed_byte(f) % 2};
            cut(f, sink, &p);
        }
        kn_bezier_clear(f->ctx, &a);
    }
}

static void triangles(feed *f, kn_sink *sink)
{
    double position[18];
    uint32_t corner[12];
    for (int i = 0; i < 18; i++) position[i] = feed_int(f, -3, 3);
    for (int i = 0; i < 12; i++) corner[i] = (uint32_t)feed_int(f, 0, 5);
    kn_mesh mesh = {.nvertices = 6, .ntriangles = 4, .position = position, .triangle = corner};
    cut(f, sink, &(kn_patch){.mesh = &mesh});
}

// A job over a bilinear square that hangs in space.
static void job(feed *f, const kn_slice_options *o)
{
    const double knots[4] = {0, 0, 1, 1}, *k[2] = {knots, knots};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    double coef[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0};
    for (int i = 8; i < 12; i++) coef[i] = feed_int(f, -2, 2);
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *made = NULL;
    size_t layers = 0;
    kn_status status = kn_spline_init(f->ctx, &base, 2, 3, false, degree, count, k, coef);
    if (status == KN_OK) status = kn_builtin_tile(f->ctx, &tile, "bump");
    kn_job_options options = {.count = {1, 1}, .normal_tol = 0.1, .max_degree = 40};
    if (status == KN_OK) status = kn_job_create(f->ctx, &made, &base, 1, &tile, &options);
    const kn_job *jobs[] = {made};
    if (status == KN_OK) feed_any(kn_slice_job(f->ctx, jobs, 1, o, look, &layers, NULL));
    kn_job_destroy(f->ctx, made);
    kn_tile_clear(f->ctx, &tile);
    kn_spline_clear(f->ctx, &base);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    kn_sink sink = {0};
    size_t layers = 0;
    int call = feed_byte(&f);
    kn_slice_options o = {.first = feed_number(&f), .step = feed_number(&f), .count = 1 + (size_t)feed_int(&f, 0, 6)};
    o.tol = feed_byte(&f) % 8 == 0 ? feed_number(&f) : 0.1;
    o.join = feed_byte(&f) % 8 == 0 ? feed_number(&f) : 0.0;
    if (o.tol < 0.05) o.tol = 0.05; // the work grows without bound
    if (call % 8 == 0)
        job(&f, &o);
    else if (kn_slice_sink(f.ctx, &sink, &o, look, &layers) == KN_OK) {
        if (call % 2)
            patches(&f, &sink);
        else
            triangles(&f, &sink);
        feed_any(sink.end(f.ctx, sink.user));
        kn_sink_close(f.ctx, &sink);
    }
    feed_end(&f);
    return 0;
}
