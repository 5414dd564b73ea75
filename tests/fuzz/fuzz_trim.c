// SPDX-License-Identifier: Apache-2.0
// Fuzzes trims: cuts of regions that were cut before, broken trims, and the tessellation of what is left.
#include "tests/fuzz/feed.h"

#include <knurl/mesh.h>
#include <knurl/trim.h>

// The answer and the context agree.
static bool went_well(feed *f, kn_status status)
{
    if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort();
    kn_ctx_clear_error(f->ctx);
    return status == KN_OK;
}

// What comes out of a cut is a trim.
static void examine(feed *f, const kn_trim *trim, const kn_bezier *patch)
{
    kn_answer answer;
    kn_mesh mesh = {0};
    if (!went_well(f, kn_trim_check(f->ctx, trim))) abort();
    const double at[2] = {feed_number(f), feed_number(f)};
    feed_any(kn_trim_contains(f->ctx, &answer, trim, at));
    kn_ctx_clear_error(f->ctx);
    int segments[2] = {feed_count(f, 1, 9), feed_count(f, 1, 9)};
    (void)went_well(f, kn_mesh_add_trimmed(f->ctx, &mesh, patch, trim, segments, feed_byte(f) % 2));
    for (size_t k = 0; k < 3 * mesh.ntriangles; k++)
        if (mesh.triangle[k] >= mesh.nvertices) abort();
    kn_mesh_clear(f->ctx, &mesh);
}

// A curve with numbers that nothing made.
static void spoil(feed *f, kn_trim *trim)
{
    kn_trim copy = {0};
    if (kn_trim_copy(f->ctx, &copy, trim) != KN_OK) abort();
    if (copy.ncurves > 0) {
        kn_spline *c = &copy.curves[feed_byte(f) % copy.ncurves];
        c->coef[feed_byte(f) % (2 * c->count[0])] = feed_number(f);
        kn_trim_turn(c);
        if (feed_byte(f) % 2) copy.loop_end[0] = feed_int(f, -1, 9);
    }
    feed_any(kn_trim_check(f->ctx, &copy));
    kn_ctx_clear_error(f->ctx);
    kn_trim_clear(f->ctx, &copy);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    kn_trim region = {0}, below = {0}, above = {0};
    kn_bezier patch = {0};
    const int degree[2] = {2, 1};
    if (kn_bezier_init(f.ctx, &patch, 2, 3, false, degree) != KN_OK) abort();
    for (size_t i = 0; i < 3 * kn_bezier_count(&patch); i++) patch.coef[i] = feed_finite(&f);
    bool there = true;
    for (int i = 0; i < 4 && there; i++) {
        kn_trim_cut_report report = {0};
        kn_bezier g = {0};
        const int shape[2] = {feed_int(&f, 0, 3), feed_int(&f, 0, 3)};
        if (kn_bezier_init(f.ctx, &g, 2, 1, false, shape) != KN_OK) abort();
        for (size_t k = 0; k < kn_bezier_count(&g); k++) g.coef[k] = feed_number(&f);
        double tol = feed_byte(&f) < 240 ? 1.0 / (16 << feed_int(&f, 0, 4)) : feed_number(&f);
        tol = tol > 0.0 && tol < 4e-3 ? 4e-3 : tol; // finer ones take their time
        if (went_well(&f, kn_trim_cut(f.ctx, &below, &above, &report, &region, &g, tol))) {
            if (!report.below && !report.above) abort();
            if (report.below) examine(&f, &below, &patch);
            if (report.above) examine(&f, &above, &patch);
            bool up = report.above && (feed_byte(&f) % 2 || !report.below);
            if (kn_trim_copy(f.ctx, &region, up ? &above : &below) != KN_OK) abort();
        }
        kn_bezier_clear(f.ctx, &g);
        spoil(&f, &region);
        if (feed_byte(&f) % 4 == 0) {
            double lo[2] = {feed_int(&f, 0, 8) / 8.0, feed_int(&f, 0, 8) / 8.0};
            double hi[2] = {feed_int(&f, 0, 8) / 8.0, feed_int(&f, 0, 8) / 8.0};
            if (went_well(&f, kn_trim_restrict(f.ctx, &region, &there, &region, lo, hi)) && there)
                examine(&f, &region, &patch);
        }
    }
    kn_trim_clear(f.ctx, &region), kn_trim_clear(f.ctx, &below), kn_trim_clear(f.ctx, &above);
    kn_bezier_clear(f.ctx, &patch);
    feed_end(&f);
    return 0;
}
