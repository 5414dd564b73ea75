// SPDX-License-Identifier: Apache-2.0
// Fuzzes the writers: models of any numbers through every sink, into files that are then removed.
#include "tests/fuzz/feed.h"

#include <knurl/write.h>

#include <stdio.h>
#include <unistd.h>

static void make_spline(feed *f, kn_spline *out, int nvars)
{
    kn_bezier b = {0};
    int degree[3];
    bool rational = feed_byte(f) % 2;
    for (int d = 0; d < nvars; d++) degree[d] = feed_int(f, 0, 3);
    if (kn_bezier_init(f->ctx, &b, nvars, 3 + rational, rational, degree) != KN_OK) abort();
    size_t n = kn_bezier_count(&b);
    for (size_t i = 0; i < (3 + (size_t)rational) * n; i++) b.coef[i] = i < 3 * n ? feed_number(f) : feed_finite(f);
    if (kn_spline_of_bezier(f->ctx, out, &b) != KN_OK) abort();
    kn_bezier_clear(f->ctx, &b);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static kn_status (*const sinks[])(kn_ctx *, kn_sink *, const char *) = {
        kn_g2_sink, kn_itd_sink, kn_obj_surfaces_sink, kn_vtu_sink, kn_mfem_sink, kn_pov_sink};
    feed f = feed_begin(data, size);
    kn_spline splines[3] = {{0}};
    char path[64];
    int which = feed_int(&f, 0, 5), n = feed_int(&f, 1, 3), nvars = feed_int(&f, 1, 3);
    (void)snprintf(path, sizeof path, "/tmp/knurl-fuzz-%ld.%s", (long)getpid(), which == 2 ? "obj" : "out");
    for (int i = 0; i < n; i++) make_spline(&f, &splines[i], feed_byte(&f) % 4 ? nvars : feed_int(&f, 1, 3));
    const kn_model model = {.splines = splines, .nsplines = n};
    const kn_stream_options o = {.split = feed_byte(&f) % 2, .unit_domains = feed_byte(&f) % 2, .mesh_tol = 1e6};
    kn_sink sink = {0};
    if (sinks[which](f.ctx, &sink, path) != KN_OK) abort();
    feed_any(kn_stream_model(f.ctx, &model, "fuzz", &o, &sink, 1));
    kn_sink_close(f.ctx, &sink);
    kn_tile tile = {0};
    const kn_patch patch = {.spline = &splines[0], .look = feed_int(&f, 0, 1), .segments = {1, 1, 1}};
    kn_ctx_clear_error(f.ctx);
    if (kn_tile_init(f.ctx, &tile, "fuzz", 1) != KN_OK) abort();
    if (sinks[which](f.ctx, &sink, path) != KN_OK) abort();
    feed_any(kn_stream_patches(f.ctx, &tile, &patch, 1, 0.0, &sink, 1));
    kn_sink_close(f.ctx, &sink);
    kn_tile_clear(f.ctx, &tile);
    for (int i = 0; i < n; i++) kn_spline_clear(f.ctx, &splines[i]);
    (void)remove(path);
    (void)snprintf(path, sizeof path, "/tmp/knurl-fuzz-%ld.mtl", (long)getpid());
    if (which == 2) (void)remove(path);
    feed_end(&f);
    return 0;
}
