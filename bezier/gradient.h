// SPDX-License-Identifier: Apache-2.0
// Gradient and divergence of a piece over a box of any size, for pieces of splines.
#ifndef BEZIER_GRADIENT_H
#define BEZIER_GRADIENT_H

#include "bezier/shape.h"

// As kn_bezier_gradient and kn_bezier_divergence; size: the lengths of the box that [0,1]^nvars stands for, NULL:
// ones. A size adds one rounding to each derivative.
kn_status kn_bezier_gradient_over(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a,
                                  const double *size);
kn_status kn_bezier_divergence_over(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a,
                                    const double *size);
// to = the derivative of component comp of a in variable var, at a's degrees; to: kn_bezier_count(a) numbers.
void kn_bezier_partial(double *to, const kn_bezier *a, int comp, int var, const double *size);

#endif
