// SPDX-License-Identifier: Apache-2.0
// Inside slice: pieces of contours, and how they become loops.
#ifndef SLICE_INTERNAL_H
#define SLICE_INTERNAL_H

#include "kernel/context.h"

#include <knurl/slice.h>

// A piece of a contour: points[first .. first + n - 1] of its list.
typedef struct kn_slice_line {
    size_t plane, first, n;
    int part, layer;
} kn_slice_line;

// A growing list of pieces. Zero-initialised it is empty.
typedef struct kn_slice_lines {
    double *points; // (x, y)
    size_t npoints, point_room;
    kn_slice_line *list;
    size_t nlines, line_room;
    size_t doubtful;
} kn_slice_lines;
void kn_slice_lines_clear(kn_ctx *ctx, kn_slice_lines *lines);
// A new empty piece at the end; then its points one by one. A point equal to the one before it is left out.
kn_status kn_slice_begin_line(kn_ctx *ctx, kn_slice_lines *lines, size_t plane, const kn_patch_id *id);
kn_status kn_slice_add_point(kn_ctx *ctx, kn_slice_lines *lines, double x, double y);
// Appends all of b's.
kn_status kn_slice_append(kn_ctx *ctx, kn_slice_lines *a, const kn_slice_lines *b);

// Some of the layers: first .. end - 1.
typedef struct kn_slice_window {
    kn_slice_options options;
    size_t first, end;
} kn_slice_window;
// KN_EDOMAIN where options are none.
kn_status kn_slice_check(kn_ctx *ctx, const kn_slice_options *o);
// A sink for the window alone: fn gets its layers.
kn_status kn_slice_window_sink(kn_ctx *ctx, kn_sink *out, const kn_slice_window *window, kn_slice_fn fn, void *user);
// The planes with lo < z <= hi, where zero counts as above: index from *from to before *to.
void kn_slice_planes(const kn_slice_window *w, double lo, double hi, size_t *from, size_t *to);
double kn_slice_height(const kn_slice_options *o, size_t plane);

// ---- contour.c ---- The contours of a Bezier patch of two variables.
kn_status kn_slice_patch(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *w, const kn_patch_id *id,
                         const kn_bezier *patch, bool reversed);
// ---- triangles.c ---- Of a mesh, counterclockwise outwards.
kn_status kn_slice_mesh(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *w, const kn_patch_id *id,
                        const kn_mesh *mesh);
// ---- chain.c ---- Joins the pieces of one plane, lines[0 .. n-1], into loops, and gives them to fn.
kn_status kn_slice_chain(kn_ctx *ctx, const kn_slice_lines *from, const kn_slice_line *lines, size_t n,
                         const kn_slice_options *o, size_t plane, kn_slice_fn fn, void *user);

#endif
