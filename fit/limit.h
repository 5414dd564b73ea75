// SPDX-License-Identifier: Apache-2.0
// What fits of limited degree share: a piece of degree d over [0,1] becomes 2^level equal spans of degree p, C1, each
// with the piece's values and first derivatives at its ends. docs/numerics.md, "fit", says why edges agree.
#ifndef FIT_LIMIT_H
#define FIT_LIMIT_H

#include <knurl/fit.h>

#include "bezier/norm_bound.h"
#include "kernel/context.h"

// One variable of such a fit. Coefficients are those of the spline whose inner knots occur p - 1 times: all of the
// spans' Bezier coefficients but those where spans join, which lie midway between their neighbours.
typedef struct kn_limit_axis {
    int from, to, level; // degrees d and p; from == to: the piece as it is, level 0
} kn_limit_axis;

// (p - 1) 2^level + 2.
size_t kn_limit_count(const kn_limit_axis *x);
// 2^level (p + 1): all coefficients of all spans.
size_t kn_limit_apart(const kn_limit_axis *x);
// matrix (kn_limit_count, d + 1), in scratch: from the piece's coefficients to the spline's. p > d is not for it.
kn_status kn_limit_matrix(kn_ctx *ctx, double **matrix, const kn_limit_axis *x);
// out (outer, apart, inner) from the spline's coefficients in (outer, count, inner).
void kn_limit_spread(double *out, const double *in, size_t outer, const kn_limit_axis *x, size_t inner);
// in (apart) becomes out (count), the same for one line of numbers.
void kn_limit_join(double *out, const double *in, const kn_limit_axis *x);
// out (outer, 2^level (d + 1), inner): the pieces over the spans of in (outer, d + 1, inner). KN_ENOMEM.
kn_status kn_limit_restrict(kn_ctx *ctx, double *out, const double *in, size_t outer, const kn_limit_axis *x,
                            size_t inner);

// An edge of a surface, fitted by itself: ncomp arrays of kn_limit_count numbers.
typedef struct kn_limit_edge {
    kn_limit_axis axis;
    double *coef;
    bool turned; // run through against the surface's direction
} kn_limit_edge;
// The fit's edges, 2 var + end, become these: knots inserted to the axes' levels, which are no lower.
kn_status kn_limit_put_edges(kn_ctx *ctx, double *coef, size_t ncomp, const kn_limit_axis axis[2],
                             const kn_limit_edge edges[4]);

// A piece and its fit.
typedef struct kn_limit_fit {
    const kn_bezier *a;
    const kn_fit_limits *limits;
    kn_limit_axis axis[KN_MAX_VARS];
    double *coef; // ncomp arrays of the axes' counts
    double error;
    size_t worst;   // the span where it is largest, as far as that is known
    kn_parts rough; // the piece's largest numbers
} kn_limit_fit;
// *angle = a bound of the angle between the normals of a surface and of its fit along the edge where variable var
// ends, error that of their distance. INFINITY: it could not be certified, as where the normal vanishes. KN_ENOMEM.
kn_status kn_limit_edge_angle(kn_ctx *ctx, double *angle, const kn_limit_fit *f, double error, int var, bool at_end);

#endif
