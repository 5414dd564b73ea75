// SPDX-License-Identifier: Apache-2.0
// Inside step: curves of a STEP file, as edges of faces and by themselves.
#ifndef STEP_LINE_H
#define STEP_LINE_H

#include "step/write.h"

// One variable of a curve or surface: distinct knots and how often each occurs.
typedef struct kn_step_axis {
    int degree, n; // n control points
    int nbreaks;
    const int *times;
    const double *breaks;
} kn_step_axis;

typedef struct kn_step_line {
    kn_step_axis axis;
    const double *point; // of control point k at point + k * step: x, y, z in mm, weight
    ptrdiff_t step;
    bool rational;        // weights differ
    bool own;             // the points are written with the curve
    uint32_t first, next; // their numbers: first + k * next
} kn_step_line;

// "#k=" with a number that counts from the patch.
void kn_step_put_relative(kn_text *text, uint32_t k);
// "#k=CARTESIAN_POINT(..);" of dim numbers.
void kn_step_put_point(kn_text *text, uint32_t k, const double *x, int dim);
// "#number=" and the form, whose every '#' is the next one of the references, all of them counted from the patch.
void kn_step_put_form(kn_text *text, uint32_t number, const char *form, const uint32_t *references);
void kn_step_put_logical(kn_text *text, bool value);
// "(..)" of an axis: multiplicities, or the knots; turned: those of the curve that runs the other way.
void kn_step_put_times(kn_text *text, const kn_step_axis *x, bool turned);
void kn_step_put_breaks(kn_text *text, const kn_step_axis *x, bool turned);

// ---- all in scratch ----
kn_status kn_step_load_axis(kn_ctx *ctx, kn_step_axis *x, const kn_spline *s, int var);
// Projected control points times mm, four numbers each. *largest: of the coordinates. what: for the message.
// fails: KN_EUNDEFINED.
kn_status kn_step_load_points(kn_ctx *ctx, double **point, bool *rational, double *largest, const kn_spline *s,
                              double mm, const char *what);
// Points of its own, from number `first` on.
kn_status kn_step_load_line(kn_ctx *ctx, kn_step_line *line, const kn_spline *s, double mm, uint32_t first);

// By which both faces of an edge know it; *turned as kn_brep_hash.
kn_brep_key kn_step_line_key(bool *turned, const kn_step_line *line);
void kn_step_put_line_points(kn_text *text, const kn_step_line *line);
// The entity without its number, of the curve or of the one that runs the other way.
void kn_step_put_line(kn_text *text, const kn_step_line *line, bool turned, bool closed);

#endif
