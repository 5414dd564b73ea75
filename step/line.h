// SPDX-License-Identifier: Apache-2.0
// Inside step: curves of a STEP file, as edges of faces and by themselves.
#ifndef STEP_LINE_H
#define STEP_LINE_H

#include "io/patch_net.h"
#include "step/write.h"

// A curve's numbers are first + k * by, counted from the patch: those of points that the patch has, or of its own.

// "#k=" with a number that counts from the patch.
void kn_step_put_relative(kn_text *text, uint32_t k);
// "#k=CARTESIAN_POINT(..);" of dim numbers.
void kn_step_put_point(kn_text *text, uint32_t k, const double *x, int dim);
// "#number=" and the form, whose every '#' is the next one of the references, all of them counted from the patch.
void kn_step_put_form(kn_text *text, uint32_t number, const char *form, const uint32_t *references);
void kn_step_put_logical(kn_text *text, bool value);
// "(..)" of an axis: multiplicities, or the knots; turned: those of the curve that runs the other way.
void kn_step_put_times(kn_text *text, const kn_patch_axis *x, bool turned);
void kn_step_put_breaks(kn_text *text, const kn_patch_axis *x, bool turned);

// "#k=CARTESIAN_POINT(..);" of its control points, dim numbers of each.
void kn_step_put_line_points(kn_text *text, const kn_patch_curve *line, int dim);
// The entity without its number, of the curve or of the one that runs the other way.
void kn_step_put_line(kn_text *text, const kn_patch_curve *line, bool turned, bool closed);

#endif
