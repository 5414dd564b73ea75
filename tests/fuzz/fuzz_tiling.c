// SPDX-License-Identifier: Apache-2.0
// Fuzzes what is proved of tiles: small curves, surfaces, volumes and a mesh on a coarse lattice, so that some meet.
#include "tests/fuzz/feed.h"

#include <knurl/tile.h>

// Quarters mostly, so that edges coincide, within two cells.
static double coordinate(feed *f)
{
    int b = feed_byte(f);
    return b >= 240 ? feed_number(f) : (b % 9) / 4.0 - 0.5;
}

static void add_piece(feed *f, kn_tile *tile, int part)
{
    kn_bezier b = {0};
    kn_spline s = {0};
    int nvars = feed_int(f, 1, 3), degree[3];
    for (int d = 0; d < nvars; d++) degree[d] = feed_int(f, 1, nvars == 3 ? 1 : 2);
    if (kn_bezier_init(f->ctx, &b, nvars, 3, false, degree) != KN_OK) abort();
    size_t n = 3 * kn_bezier_count(&b);
    for (size_t i = 0; i < n; i++) b.coef[i] = coordinate(f);
    if (feed_byte(f) % 4 == 0 && nvars == 2) // a sheet over the cell, whose opposite borders may agree
        for (size_t i = 0; i < n / 3; i++) {
            size_t row = (size_t)degree[1] + 1;
            b.coef[i] = (double)(i / row) / degree[0], b.coef[n / 3 + i] = (double)(i % row) / degree[1];
        }
    if (kn_spline_of_bezier(f->ctx, &s, &b) != KN_OK) abort();
    feed_any(kn_tile_add(f->ctx, tile, part, &s));
    kn_spline_clear(f->ctx, &s);
    kn_bezier_clear(f->ctx, &b);
}

static void add_mesh(feed *f, kn_tile *tile)
{
    kn_mesh mesh = {.nvertices = 5, .ntriangles = (size_t)feed_int(f, 0, 4)};
    mesh.position = feed_room(f, 15);
    mesh.triangle = feed_block(f, 12 * sizeof *mesh.triangle);
    for (int i = 0; i < 15; i++) mesh.position[i] = coordinate(f);
    for (int i = 0; i < 12; i++) mesh.triangle[i] = (uint32_t)feed_int(f, 0, 4);
    feed_any(kn_tile_set_mesh(f->ctx, tile, 0, &mesh));
}

static void periodicity(feed *f, const kn_tile *tile)
{
    kn_tile_periodicity_report r;
    kn_tile_periodicity_options o = kn_tile_periodicity_defaults();
    o.max_order = feed_wild(f, 1, 2);
    if (feed_byte(f) % 16 == 0) o.tolerance = feed_number(f), o.angle = feed_number(f);
    if (kn_tile_periodicity(f->ctx, &r, tile, feed_byte(f) % 2 ? &o : NULL) != KN_OK) return;
    for (int d = 0; d < 3; d++) {
        if (r.order[d] < (d < 2 ? -1 : 0) || r.order[d] > 2) abort();
        if (r.order[d] < 0 && (r.first[d].edge.part < 0 || !r.decided[d])) abort();
    }
}

static void coverage(feed *f, const kn_tile *tile)
{
    kn_tile_coverage_report r;
    kn_tile_coverage_options o = kn_tile_coverage_defaults();
    o.depth = feed_wild(f, 1, 5);
    o.max_boxes = 300;
    if (kn_tile_coverage(f->ctx, &r, tile, &o) != KN_OK) return;
    double bare = 0;
    for (size_t i = 0; i < r.ngaps; i++)
        bare += (r.gaps[i].hi[0] - r.gaps[i].lo[0]) * (r.gaps[i].hi[1] - r.gaps[i].lo[1]);
    if (bare != r.bare || r.covered + r.bare > 1 || (r.covers == KN_YES) != (r.covered == 1)) abort();
    kn_tile_coverage_clear(f->ctx, &r);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    kn_tile tile;
    if (kn_tile_init(f.ctx, &tile, "tile", 2) != KN_OK) abort();
    for (int k = feed_int(&f, 0, 6); k > 0; k--) add_piece(&f, &tile, feed_byte(&f) % 2);
    if (feed_byte(&f) % 2) add_mesh(&f, &tile);
    kn_ctx_clear_error(f.ctx);
    periodicity(&f, &tile);
    kn_ctx_clear_error(f.ctx);
    coverage(&f, &tile);
    kn_tile_clear(f.ctx, &tile);
    feed_end(&f);
    return 0;
}
