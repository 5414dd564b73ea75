// SPDX-License-Identifier: Apache-2.0
// Patches on their way through a file to Open CASCADE.
#ifndef TESTS_BRIDGES_OCCT_TRIP_H
#define TESTS_BRIDGES_OCCT_TRIP_H

#include "bridges/occt/occt_check.h"
#include "tests/support/patches.h"

typedef struct trip {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
    test_tile tile;
    kn_patch patch[32];
    size_t count;
    char path[TEST_PATH_BYTES];
    kn_occt_model *model;
    kn_occt_report report;
} trip;

// file: .igs or .step; parts of the tile.
void trip_start(trip *t, const char *file, int nparts);
void trip_end(trip *t);
// A patch of random control points beside the last one: surface 2, cell (its number, 7), patch 12.
kn_patch *trip_add(trip *t, int m, int n, bool rational);
// Two patches for each of n cuts along {f = 0}, f random: one for each side of it, the first one with a hole. The fourth
// two are turned round.
void trip_add_cuts(trip *t, kn_trim *side, int n);
// Feeds the sink, whose path is the trip's, in blocks, and closes it.
void trip_write(trip *t, kn_sink *sink, size_t block);
// The model and what is in it: in millimetres, each face a valid one, as many as patches.
void trip_read(trip *t);
// Faces are the patches, unit_mm times as large, at places by chance.
void trip_expect_points(trip *t, double unit_mm);

#endif
