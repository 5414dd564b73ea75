// SPDX-License-Identifier: Apache-2.0
// Inside slice: pieces of contours, and how they become loops.
#ifndef SLICE_INTERNAL_H
#define SLICE_INTERNAL_H

#include "kernel/context.h"
#include "mesh/trimmed.h"
#include "solve/curves.h"

#include <knurl/slice.h>

// A piece of a contour: points[first .. first + n - 1] of its list.
typedef struct kn_slice_line {
    size_t plane, first, n;
    int part, layer;
    bool cut[2]; // whether its first and last point lie on a trim
} kn_slice_line;

// What is known of a plane.
typedef struct kn_slice_note {
    size_t plane, doubtful;
    double error;
} kn_slice_note;

// A growing list of pieces. Zero-initialised it is empty.
typedef struct kn_slice_lines {
    double *points; // (x, y)
    size_t npoints, point_room;
    kn_slice_line *list;
    size_t nlines, line_room;
    kn_slice_note *notes; // a plane may have many
    size_t nnotes, note_room;
} kn_slice_lines;
void kn_slice_lines_clear(kn_ctx *ctx, kn_slice_lines *lines);
// A new empty piece at the end; then its points one by one. A point equal to the one before it is left out.
kn_status kn_slice_begin_line(kn_ctx *ctx, kn_slice_lines *lines, size_t plane, const kn_patch_id *id);
kn_status kn_slice_add_point(kn_ctx *ctx, kn_slice_lines *lines, double x, double y);
kn_status kn_slice_add_note(kn_ctx *ctx, kn_slice_lines *lines, size_t plane, size_t doubtful, double error);
// Appends all of b's.
kn_status kn_slice_append(kn_ctx *ctx, kn_slice_lines *a, const kn_slice_lines *b);

// Some of the layers: first .. end - 1.
typedef struct kn_slice_window {
    kn_slice_options options;
    size_t first, end;
    double apart;  // what patches of the job are apart by at most, where they meet
    bool crossing; // it has pieces on both sides of knot lines
} kn_slice_window;
// KN_EDOMAIN where options are none.
kn_status kn_slice_check(kn_ctx *ctx, const kn_slice_options *o);
// How far apart ends may be that are joined: the option, or what the tolerance and the gap at knot lines ask for.
double kn_slice_reach(const kn_slice_window *w);
// What the reports of the jobs say of that; more than one: again and again.
void kn_slice_meet(kn_slice_window *w, const kn_job_report *report);
// A sink for the window alone: fn gets its layers.
kn_status kn_slice_window_sink(kn_ctx *ctx, kn_sink *out, const kn_slice_window *window, kn_slice_fn fn, void *user);
// The planes with lo < z <= hi, where zero counts as above: index from *from to before *to.
void kn_slice_planes(const kn_slice_window *w, double lo, double hi, size_t *from, size_t *to);
double kn_slice_height(const kn_slice_options *o, size_t plane);

// ---- bounds.c ----
typedef struct kn_slice_bounds {
    double first, second; // of the first and second derivatives of (x, y) in any direction
    double value;         // by which a computed (x, y) is off
} kn_slice_bounds;
// in: weights above 0.
kn_status kn_slice_find_bounds(kn_ctx *ctx, kn_slice_bounds *out, const kn_bezier *patch);

// ---- edges.c ----
// An edge in the direction that does not depend on the patch it is taken from: the one in which its control points
// come first in lexicographic order.
typedef struct kn_slice_edge {
    int degree;
    bool reversed;
    double coef[4][KN_MAX_DEGREE + 1], f[KN_MAX_DEGREE + 1];
    kn_sign_changes changes; // in the patch's direction
    double (*points)[2];     // of each change
} kn_slice_edge;
void kn_slice_take_edge(kn_slice_edge *e, const kn_bezier *patch, int side); // sides as kn_solve_trace has them
// Where the edge goes through the plane, and the points there (scratch).
kn_status kn_slice_cut_edge(kn_ctx *ctx, kn_slice_edge *e, size_t *doubtful, double z, bool rational);
// The point of the edge that the end of a curve lies on; false: none, it is inside.
bool kn_slice_known_point(double out[2], const kn_slice_edge *edges, const double at[2]);

// ---- clip.c ----
// The trim's loops as closed polylines within tol of it.
kn_status kn_slice_outline(kn_ctx *ctx, kn_outline *out, const kn_trim *trim, double tol);
// The parts of a line of zeros of f that lie in the region. Ends on the boundary are zeros of f to rounding, where
// there is one within tol. *runs: *n of them, in scratch.
kn_status kn_slice_clip(kn_ctx *ctx, kn_solve_curve **runs, size_t *n, const kn_outline *region,
                        const kn_solve_curve *curve, const kn_bezier *f, double tol);

// ---- contour.c ---- The contours of a Bezier patch of two variables; trim: NULL, all of it.
kn_status kn_slice_patch(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *w, const kn_patch_id *id,
                         const kn_bezier *patch, const kn_trim *trim, bool reversed);
// ---- triangles.c ---- Of a mesh, counterclockwise outwards.
kn_status kn_slice_mesh(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *w, const kn_patch_id *id,
                        const kn_mesh *mesh);
// ---- chain.c ---- Joins the pieces of one plane, lines[0 .. n-1], into loops, and gives them to fn.
kn_status kn_slice_chain(kn_ctx *ctx, const kn_slice_lines *from, const kn_slice_line *lines, size_t n,
                         const kn_slice_window *w, const kn_slice_note *note, kn_slice_fn fn, void *user);

#endif
