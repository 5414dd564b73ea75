// SPDX-License-Identifier: Apache-2.0
// Inside io: splines cut where they have kinks.
#ifndef IO_SPLIT_H
#define IO_SPLIT_H

#include <knurl/spline.h>

// Takes *piece over (it becomes empty), or leaves it on a failure.
typedef kn_status (*kn_split_taker)(kn_ctx *ctx, void *user, kn_spline *piece);
// Hands out the parts of *s, whose content is given up, that lie between knots at which it is not C1, the first
// variable slowest: CAD systems want faces that are. Where parts meet they have the same control points.
// in:     of dimension 3. Derivatives on both sides of a knot count as equal to 1e-9 of the larger one.
// fails:  what `take` answers; KN_ENOMEM.
KN_CHECKED kn_status kn_split_kinks(kn_ctx *ctx, void *user, kn_split_taker take, kn_spline *s);

#endif
