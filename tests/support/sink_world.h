// SPDX-License-Identifier: Apache-2.0
// A few patches for the tests of sinks that write text, and what holds of all of these.
#ifndef TESTS_SUPPORT_SINK_WORLD_H
#define TESTS_SUPPORT_SINK_WORLD_H

#include "tests/support/patches.h"

enum { SINK_PATCHES = 12 };

// Opens the sink; options: its own.
typedef kn_status (*sink_open)(kn_ctx *ctx, kn_sink *out, const char *path, const void *options);

typedef struct sink_world {
    test_memory memory;
    kn_ctx *ctx;
    test_tile tile;
    kn_patch patch[SINK_PATCHES]; // of degrees (1 .. 4, 3), in two looks, some rational; none meets another
    kn_job_report report;         // of all of them
    sink_open open;
    char path[TEST_PATH_BYTES];
} sink_world;
void sink_world_make(sink_world *w, sink_open open, const char *file, int threads);
void sink_world_clear(sink_world *w);
// The first six patches become the faces of a cube, the last one in the second look; r x t points out.
void sink_world_cube(sink_world *w);

// The file of the first n patches, fed in blocks, for free().
char *sink_world_write(sink_world *w, const void *options, size_t n, size_t block);
// The same file from blocks of any size, and from any number of threads.
void sink_world_equal_bytes(sink_open open, const char *file);
// A job of one patch is refused, and nothing is left behind.
void sink_world_expect_refused(sink_world *w, const kn_job_report *report, const kn_patch *patch, kn_status expected);
// What was not announced, numbers that are none, a weight of 0, and a folder that is not there are refused.
void sink_world_expect_refusals(sink_world *w);
// test_allocation_failures of all patches.
void sink_world_starve(sink_world *w, const void *options);

#endif
