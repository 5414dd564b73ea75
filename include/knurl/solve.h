// SPDX-License-Identifier: Apache-2.0
// Certified signs, roots, intersections and closest points.
//
// What is called certified here holds for the function that the given coefficients define exactly: the rounding of
// the computation is inside the bounds (docs/numerics.md, "solve"). What cannot be decided is said to be so.
#ifndef KNURL_SOLVE_H
#define KNURL_SOLVE_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { KN_SOLVE_MAX_DEPTH = 1000 }; // halvings of one box, at most

// ---- predicates on one piece ----
// Common to the three:
// in:     f polynomial, or rational with positive weights (else KN_EDOMAIN); lo, hi: nvars numbers each,
//         0 <= lo <= hi <= 1 (else KN_EDOMAIN), both NULL for [0,1]^nvars; depth 0 .. KN_SOLVE_MAX_DEPTH, the number
//         of times that a box may be halved before the answer is "unknown"; 0 looks at the coefficients alone.
// out:    one answer; unchanged on failure. NaN among the coefficients gives "unknown".
// fails:  KN_EDOMAIN, KN_ENOMEM, KN_ECANCELLED.
// error:  none: a definite answer holds for the exact function.
// cost:   one pass over the coefficients where that decides; at most 2^depth boxes. From the first box on that is
//         undecided at the full depth, or whose coefficients differ by no more than their rounding, it looks for two
//         different signs alone, 4 halvings deep.

typedef enum kn_answer { KN_NO = -1, KN_UNKNOWN = 0, KN_YES = 1 } kn_answer;
typedef enum kn_sign {
    KN_SIGN_NEGATIVE = -1, // f < 0 everywhere
    KN_SIGN_UNKNOWN = 0,
    KN_SIGN_POSITIVE = 1, // f > 0 everywhere
    KN_SIGN_MIXED = 2,    // f > 0 somewhere and f < 0 somewhere
} kn_sign;

// The sign of f, of dimension 1 (else KN_EDOMAIN), over the closed box.
KN_API KN_CHECKED kn_status kn_solve_sign(kn_ctx *ctx, kn_sign *out, const kn_bezier *f, const double *lo,
                                          const double *hi, int depth);
// KN_YES: f, of any dimension, vanishes nowhere on the closed box: each box it was divided into has a plane through 0
// with all coefficients on one side. KN_NO: it has a zero there (found for dimension 1, and where the first
// coefficient of a box is exactly 0; kn_solve_zeros finds the others).
// source: the plane by Gilbert's iteration, An iterative procedure for computing the minimum of a quadratic form on a
//         convex set, SIAM J. Control 4 (1966).
KN_API KN_CHECKED kn_status kn_solve_nonzero(kn_ctx *ctx, kn_answer *out, const kn_bezier *f, const double *lo,
                                             const double *hi, int depth);
// The sign of the partial derivative of f, of dimension 1 (else KN_EDOMAIN), in variable var.
// fails:  also KN_ELIMIT: twice the degree of a rational piece passes KN_MAX_DEGREE.
KN_API KN_CHECKED kn_status kn_solve_monotone(kn_ctx *ctx, kn_sign *out, const kn_bezier *f, int var,
                                              const double *lo, const double *hi, int depth);

// ---- zeros of systems ----

// Zero means the default in every field.
typedef struct kn_solve_options {
    double tolerance;     // boxes narrower than this part of their span are not divided further: default 2^-50
    double residual;      // more equations than unknowns: |f_k| <= residual max |coefficients of f_k| counts as zero;
                          // default 1e-12
    int max_depth;        // divisions of one span, at most: default 200, <= KN_SOLVE_MAX_DEPTH
    size_t max_boxes;     // boxes looked at, at most: default 500000
    size_t max_undecided; // boxes open at one time, at most: default 2048. Beyond it the zeros count as a continuum
} kn_solve_options;
KN_API kn_solve_options kn_solve_defaults(void);

typedef enum kn_root_kind {
    KN_ROOT_POSSIBLE, // there may be none, one or many in the box: it could not be excluded
    KN_ROOT_UNIQUE,   // the box holds exactly one, certified
} kn_root_kind;

// lo <= at <= hi in the parameters of the functions. at_edge: the box reaches the boundary of the domain, and may
// reach beyond it by its own width; what is certified is then said of the functions continued beyond the boundary.
// least, most: bounds of the number of roots in the box, each counted with its multiplicity; most -1: not known.
typedef struct kn_root {
    kn_root_kind kind;
    bool at_edge;
    int least, most;
    double at[KN_MAX_VARS], lo[KN_MAX_VARS], hi[KN_MAX_VARS];
} kn_root;

// curve_like: the zeros look like a continuum, which the boxes cover: max_undecided was passed, there are fewer
// equations than unknowns, or a box longer than 2^-6 of its span is undecided as a whole.
typedef struct kn_solve_report {
    size_t boxes;    // looked at
    size_t possible; // roots that are not certain
    bool curve_like;
    bool limited; // max_boxes or max_depth was passed
} kn_solve_report;

// All common zeros, in the closed domain, of every component of f[0 .. nf-1].
// in:     splines over the same variables (1 .. KN_MAX_VARS) and domain (else KN_EDOMAIN), that kn_spline_check
//         accepts. Rational ones vanish where their numerators do. options NULL: the defaults.
// out:    *roots: *nroots of them, sorted by lo, for kn_free; every zero lies in one of the boxes. report may be
//         NULL. As many equations as unknowns m = n: regular zeros become KN_ROOT_UNIQUE, with boxes about as narrow
//         as the coefficients allow; multiple ones and clusters KN_ROOT_POSSIBLE. A zero on a face that spans share
//         is reported once. m > n: all are KN_ROOT_POSSIBLE, of the points where all equations vanish within
//         options.residual. m < n: boxes that cover the zeros, about max_undecided of them. So is it, with
//         report->curve_like, when the zeros of m >= n equations form a continuum.
// fails:  KN_EDOMAIN, KN_ELIMIT (the degrees together pass KN_MAX_COEFS), KN_ENOMEM, KN_ECANCELLED.
// error:  none: boxes are certified to hold what they claim, of the exact function.
// cost:   time and memory are bounded by max_boxes and max_undecided.
// source: Sherbrooke & Patrikalakis, Computation of the solutions of nonlinear polynomial systems, CAGD 10 (1993);
//         Mourrain & Pavone, Subdivision methods for solving polynomial equations, JSC 44 (2009); Krawczyk, Newton-
//         Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken, Computing 4 (1969).
KN_API KN_CHECKED kn_status kn_solve_zeros(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report,
                                           const kn_spline *f, int nf, const kn_solve_options *options);
// The same for pieces, over [0,1]^nvars. NaN and infinite coefficients are KN_EDOMAIN.
KN_API KN_CHECKED kn_status kn_solve_zeros_bezier(kn_ctx *ctx, kn_root **roots, size_t *nroots,
                                                  kn_solve_report *report, const kn_bezier *f, int nf,
                                                  const kn_solve_options *options);

// ---- roots of one function of one variable ----
// All roots of f, of one variable and dimension 1 (else KN_EDOMAIN), in the closed domain.
// out:    as kn_solve_zeros, with `least` and `most`. A box lo == hi is an exact root, of multiplicity least == most
//         when f is a piece or the knots allow it. KN_ROOT_POSSIBLE only where 106 bits do not decide: `most` by
//         Descartes. A piece that is zero throughout is one possible root, report->curve_like.
// error:  coefficients of a piece count as exact; those of a spline's spans have the rounding of knot insertion.
// cost:   about 100 (degree + 1)^2 flops for each halving; a simple root takes a few, and twenty values.
// source: Lane & Riesenfeld, Bounds on a polynomial, BIT 21 (1981); Mourrain, Rouillier & Roy, The Bernstein basis
//         and real root isolation, MSRI Publ. 52 (2005).
KN_API KN_CHECKED kn_status kn_solve_roots(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report,
                                           const kn_spline *f, const kn_solve_options *options);

// ---- curves: zeros of one function of two variables ----
// A line of zeros as a polyline: f >= 0 to the left of its run, f < 0 to its right.
typedef struct kn_solve_curve {
    double *points; // two parameters each
    size_t npoints; // at least 2; a closed one ends with its first point
    bool closed;
} kn_solve_curve;
// The border between {f < 0} and {f >= 0} in [0,1]^2, f of two variables and dimension 1, polynomial.
// in:     0 < tol <= 0.5, parameter units.
// out:    *curves: *n of them, one block to kn_free (the points lie in it). Every point of a curve is within tol of a
//         zero of f, and every zero at which f changes its sign within tol of a curve, but for closed lines that lie
//         in a single box smaller than tol where f_r and f_t both vanish. Curves that are not closed begin and end on
//         edges of the square, at places that depend on f's coefficients along that edge alone (to neighbouring
//         doubles; the coordinate across is 0 or 1 exactly); zero counts as positive, also along a whole edge: so
//         neighbouring patches agree. They neither meet nor cross: at a double point lines are joined so that
//         {f < 0} comes apart. report (NULL: not wanted): possible counts boxes smaller than tol, and places on
//         lines, where that had to be decided by rounded numbers; limited: max_boxes (1e6) was passed, and curves
//         are coarser than tol there.
// fails:  KN_EDOMAIN (shape, tol, coefficients that are not finite), KN_ENOMEM, KN_ECANCELLED; outputs unchanged.
// error:  tol is kept for the function in exact arithmetic, but for a shift by the rounding of f, 8 (n + m) u max |c|
//         for each halving, over |f_r| or |f_t|.
// cost:   about (n + 1)(m + 1)(n + m) flops for each box, some ten for each curve and turn of it, and ten values for
//         each point, of which there are length sqrt(curvature / 8 tol).
KN_API KN_CHECKED kn_status kn_solve_curves_bezier(kn_ctx *ctx, kn_solve_curve **curves, size_t *n,
                                                   kn_solve_report *report, const kn_bezier *f, double tol);

// ---- intersections: everything as for kn_solve_zeros, unless said ----
// Where the line { point + t direction } meets a surface of dimension 3, polynomial or rational.
// in:     point, direction: 3 numbers each, direction not 0 (else KN_EDOMAIN).
// out:    roots in (u, v); at[2] == lo[2] == hi[2] is t there, computed at `at` and no bound.
KN_API KN_CHECKED kn_status kn_solve_intersect_line_surface(kn_ctx *ctx, kn_root **roots, size_t *nroots,
                                                            kn_solve_report *report, const kn_spline *surface,
                                                            const double *point, const double *direction,
                                                            const kn_solve_options *options);
// Where a curve meets a surface, both of dimension 3: roots in (t, u, v).
// cost:   pairs of spans whose boxes of control points overlap are looked at.
KN_API KN_CHECKED kn_status kn_solve_intersect_curve_surface(kn_ctx *ctx, kn_root **roots, size_t *nroots,
                                                             kn_solve_report *report, const kn_spline *curve,
                                                             const kn_spline *surface,
                                                             const kn_solve_options *options);
// Where two curves of equal dimension meet: roots in (t_a, t_b). In the plane they are certified; in space, three
// equations for two unknowns, they are KN_ROOT_POSSIBLE, within options.residual.
KN_API KN_CHECKED kn_status kn_solve_intersect_curves(kn_ctx *ctx, kn_root **roots, size_t *nroots,
                                                      kn_solve_report *report, const kn_spline *a, const kn_spline *b,
                                                      const kn_solve_options *options);

// ---- closest points ----
typedef struct kn_closest {
    double at[KN_MAX_VARS];    // parameters, in the domain
    double point[KN_MAX_VARS]; // s(at); where s jumps there, of the side that is nearer
    double distance;           // from there to the given point
} kn_closest;

// The points of s (1 to 3 variables, dimension 1 .. KN_MAX_VARS) that are closest to `point`, over the whole closed
// domain, boundary included: point inversion where the distance is 0.
// in:     point: dim finite numbers. options: residual r is the accuracy of the distance, in units of the largest
//         distance from point to a control point (default 1e-12); tolerance and max_undecided are not used.
// out:    *closest: *n of them, nearest first, for kn_free: all that were found within 2 r of the nearest, and a
//         continuum of them (the axis of a cylinder) by some of its points. No point of s is nearer than *lower,
//         which is certified; (*closest)[0].distance - *lower <= r, unless report->limited. lower, report may be
//         NULL.
// fails:  KN_EDOMAIN, KN_ELIMIT (twice a degree passes KN_MAX_DEGREE), KN_ENOMEM, KN_ECANCELLED; KN_EUNDECIDED where
//         squares of distances overflow, or weights underflow.
// error:  of a distance: that of the value at `at`; *lower has the rounding taken off.
// cost:   branch and bound on |s - point|^2 in Bernstein form; boxes near a regular minimum end at once, by
//         curvature.
// source: Johnson & Cohen, A framework for efficient minimum distance computations, ICRA 1998; Adjiman, Dallwig,
//         Floudas & Neumaier, A global optimization method, alphaBB, Comput. Chem. Eng. 22 (1998).
KN_API KN_CHECKED kn_status kn_solve_closest(kn_ctx *ctx, kn_closest **closest, size_t *n, double *lower,
                                             kn_solve_report *report, const kn_spline *s, const double *point,
                                             const kn_solve_options *options);

#ifdef __cplusplus
}
#endif
#endif
