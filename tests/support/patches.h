// SPDX-License-Identifier: Apache-2.0
// What the tests of sinks share: hand-made patches, and a sink fed by hand.
#ifndef TESTS_SUPPORT_PATCHES_H
#define TESTS_SUPPORT_PATCHES_H

#include "tests/support/support.h"

#include <knurl/io.h>

// A tile with these part names (colours differ), that owns nothing.
typedef struct test_tile {
    kn_tile tile;
    kn_tile_part part[3];
} test_tile;
void test_tile_make(test_tile *out, int nparts);

// A report that announces this many patches of at most this degree.
kn_job_report test_report(size_t patches, int degree_r, int degree_t);

// patch->bezier: degree m, n; control points near the grid (i, j, 0) scaled to the unit square at (x0, 0), moved by
// up to `bump`. Rational: weights in [1, 2].
void test_patch(kn_ctx *ctx, kn_patch *out, test_rng *rng, int m, int n, bool rational, double x0, double bump);

// begin, the patches in blocks of `block`, end; stops at the first failure. The sink stays open.
kn_status test_feed(kn_ctx *ctx, kn_sink *sink, const kn_tile *tile, const kn_job_report *report,
                    const kn_patch *patches, size_t count, size_t block);

#endif
