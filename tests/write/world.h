// SPDX-License-Identifier: Apache-2.0
// What the tests of writers share: patches of every kind, and sinks fed with them.
#ifndef TESTS_WRITE_WORLD_H
#define TESTS_WRITE_WORLD_H

#include "tests/support/patches.h"

#include <knurl/write.h>

enum { PATCHES = 8 };

typedef kn_status (*make_sink)(kn_ctx *ctx, kn_sink *out, const char *path);

// Plain, reversed, rational, and rational reversed surfaces of degrees 3, 2; then splines of several spans: a curve,
// a surface, a volume and a reversed one.
typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_tile tile;
    kn_patch patch[PATCHES];
    kn_spline spline[PATCHES]; // behind patches 4 .. 7
    kn_job_report report;
    char path[TEST_PATH_BYTES];
} world;
void world_make(world *w, const char *name);
void world_clear(world *w); // removes the file, too

// Patches first .. first + count - 1, in blocks; the sink is closed. The file's text, for free; *bytes: NULL, not
// wanted.
char *world_write(world *w, make_sink make, int first, int count, size_t block, size_t *bytes);
// The sink refuses them with KN_EDOMAIN, says why, and leaves no file.
void world_refused(world *w, make_sink make, int first, int count, const char *why);
// Every allocation fails once; then no file is left.
void world_without_memory(world *w, make_sink make, int first, int count);

// The patch as a file has it: reversed ones have their first two variables swapped. For kn_spline_clear.
void world_spline(world *w, kn_spline *out, int patch);
// A triangle of [0,1]^2, with one curved side. For kn_trim_clear.
void world_make_trim(world *w, kn_trim *out);

#endif
