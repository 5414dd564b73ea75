// SPDX-License-Identifier: Apache-2.0
// What fits of limited degree share: a piece of degree d over [0,1] becomes 2^level equal spans of degree p, C1, each
// with the piece's values and first derivatives at its ends. docs/numerics.md, "fit", says why edges agree.
#ifndef FIT_LIMIT_H
#define FIT_LIMIT_H

#include <knurl/fit.h>

#include "bezier/norm_bound.h"
#include "kernel/context.h"

enum { KN_ANGLE_LEVEL = 5 };                         // of halvings that angles may ask for
enum { KN_EDGE_PARTS = 128, KN_SURFACE_PARTS = 32 }; // an edge is so many tolerances long: its own, its surfaces'

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

// A piece and its fit.
typedef struct kn_limit_fit {
    const kn_bezier *a;
    const kn_fit_limits *limits;
    kn_limit_axis axis[KN_MAX_VARS];
    double *coef; // ncomp arrays of the axes' counts
    double error;
    size_t worst;   // the span where it is largest, as far as that is known
    double *spans;  // the piece's coefficients on all spans, where they are known, in scratch; else NULL
    kn_parts rough; // the piece's largest numbers
} kn_limit_fit;

// An edge of a surface, fitted by itself: ncomp arrays of kn_limit_count numbers.
typedef struct kn_limit_edge {
    kn_limit_axis axis;
    double *coef;
    bool turned;        // run through against the surface's direction
    double size, error; // as kn_limit_narrow has it; of the distance
} kn_limit_edge;
// The fit's edges, 2 var + end, become these: knots inserted to the axes' levels, which are no lower.
kn_status kn_limit_put_edges(kn_ctx *ctx, double *coef, size_t ncomp, const kn_limit_axis axis[2],
                             const kn_limit_edge edges[4]);

// line = the control points, one component of an edge, on the spans of `to`, in the surface's direction. KN_ENOMEM.
kn_status kn_limit_edge_row(kn_ctx *ctx, double *line, const double *coef, const kn_limit_edge *edge,
                            const kn_limit_axis *to);
// What an edge asks for by itself: limits are narrowed to a part of its size. *size: the largest distance of a control
// point from the first; 0 where that is next to nothing.
void kn_limit_narrow(kn_fit_limits *limits, double *size, const kn_bezier *edge);
// *tilt = about how far the tangents of a curve's fit turn, radians, but for where they (almost) vanish; f->spans is
// known. It decides on levels and certifies nothing. KN_ENOMEM.
kn_status kn_limit_tilt(kn_ctx *ctx, double *tilt, const kn_limit_fit *f);

// ---- angles ----

// Along an edge of a piece and of its fit, ncomp arrays each: the edge and the derivative across it.
typedef struct kn_limit_rows {
    int ncomp;
    bool rational;
    kn_limit_axis along;
    const double *exact[2]; // degree + 1 numbers
    const double *fit[2];   // kn_limit_count numbers
    double error;           // of the distance of both
    double rounding[2];     // of coefficients of derivatives along and across, at most
} kn_limit_rows;
// How far normals along an edge turn.
typedef struct kn_limit_turn {
    double goal;   // in: a bound below this is as good as any; 0: as close as can be
    double angle;  // a bound, but for what is unknown
    double sample; // the largest that was met, computed
    bool unknown;  // somewhere there is no bound
    // The piece has no normal in places, but for rounding; there, and within 2^-10 of a span from there, is no bound.
    bool singular;
} kn_limit_turn;
// turn becomes that of itself and of the rows; begin with zeros but for the goal. KN_ENOMEM.
kn_status kn_limit_turn_of(kn_ctx *ctx, kn_limit_turn *turn, const kn_limit_rows *rows);
// out: rows of coef (ncomp, n0, n1) where variable var ends, in scratch: the edge, and slope times the step inwards.
kn_status kn_limit_rows_at(kn_ctx *ctx, double *out[2], const double *coef, size_t ncomp, const size_t n[2], int var,
                           bool at_end, double slope);
// rows->rounding and an addition to its error, n numbers in each component of a fit; across it variable var. false: a
// weight may not be positive.
bool kn_limit_round_rows(kn_limit_rows *rows, const kn_limit_fit *f, int var, const double *coef, size_t n);
// *turn, but for the goal that stands there, along the edge where variable var ends; error: of the distance there.
kn_status kn_limit_edge_angle(kn_ctx *ctx, kn_limit_turn *turn, const kn_limit_fit *f, double error, int var,
                              bool at_end);
// The levels of the fit's axes rise until the angles along its edges are as the limits say, where more spans help.
kn_status kn_limit_raise_levels(kn_ctx *ctx, kn_limit_fit *f, const kn_limit_edge edges[4]);

#endif
