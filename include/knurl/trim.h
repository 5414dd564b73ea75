// SPDX-License-Identifier: Apache-2.0
// Regions of a parameter plane bounded by curves: what is left of a patch that was cut.
#ifndef KNURL_TRIM_H
#define KNURL_TRIM_H

#include <knurl/solve.h>
#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// Closed loops of curves; the region lies to the left of each: outer loops run counterclockwise, holes clockwise. A
// zero-initialised kn_trim is the whole domain. kn_trim_clear ends it.
typedef struct kn_trim {
    kn_spline *curves; // of one variable and dimension 2, one after the other; each begins where the one before it in
    int ncurves;       // its loop ends, bit for bit, and the first where the last ends
    int *loop_end;     // loop i: curves loop_end[i - 1] (i = 0: 0) .. loop_end[i] - 1
    int nloops;
} kn_trim;
KN_API void kn_trim_clear(kn_ctx *ctx, kn_trim *trim); // leaves it empty; NULL is fine
// out = a, bit for bit; out: initialised, its old contents freed. fails: KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_trim_copy(kn_ctx *ctx, kn_trim *out, const kn_trim *a);

// The same curve run backwards, in place: control points in reverse, knots negated. Twice is nothing, bit for bit.
// Where a curve is to be cut or sampled alike from both sides, that is done in the direction in which the ends of its
// knots add up to a positive number.
KN_API void kn_trim_turn(kn_spline *curve);

// KN_OK, or KN_EDOMAIN with a message that names the curve or loop: a curve that is no polynomial spline of one
// variable and dimension 2, or whose ends lie outside [0,1]^2 or control points outside [-1,2]^2; loops that are not
// closed bit for bit, or numbered wrongly; an area (of all loops together) that is not positive. Also what
// kn_spline_check finds, and KN_ENOMEM. That loops do not cross is not checked.
KN_API KN_CHECKED kn_status kn_trim_check(kn_ctx *ctx, const kn_trim *trim);

// Whether the point (r,t) lies in the region, of which the boundary is a part. KN_UNKNOWN: within about 1e-13 of a
// curve, or of a line that curves have in common.
// in:     a trim that kn_trim_check accepts; finite numbers (else KN_EDOMAIN).
// error:  definite answers hold for curves that rounding moved by gamma(3 p) for each halving, 48 at most.
// cost:   some halvings of those pieces whose boxes the ray from the point to the right meets.
KN_API KN_CHECKED kn_status kn_trim_contains(kn_ctx *ctx, kn_answer *out, const kn_trim *trim, const double point[2]);

// What became of a region that was cut.
typedef struct kn_trim_cut_report {
    bool below, above; // whether there is anything there: f < 0 somewhere, f > 0 somewhere
    double residual;   // |f| <= residual along all curves of the cut, rounding included
} kn_trim_cut_report;
// Cuts a region along {f = 0}: below gets what has f < 0, above what has f > 0. Where f vanishes along a whole edge
// of the square, that factor is divided out first, and does not count as a cut.
// in:     a trim that kn_trim_check accepts, with loops that do not meet; f of two variables and dimension 1,
//         polynomial, in the trim's (r,t); 0 < tol <= 0.1.
// out:    two different trims, initialised, overwritten; either may be `trim`. Empty with report->below (above): the
//         whole square; empty without: nothing. The curves of the cut are new, polylines (degree 1, knots 0 .. n) in
//         both, bit for bit the same but for their direction: a reversed curve has its control points reversed and
//         its knots negated, so that cuts through both sides of it, too, meet in the same points. Their ends on
//         edges of the square are the roots of f along the edge, rounded to multiples of 2^-53, and depend on f's
//         coefficients on that edge alone, whichever way it runs (unless f vanishes there). Elsewhere they are the
//         roots of f along the old curve, which is subdivided there. What is smaller than 1e-12 is left out. Every
//         point of the cut is within tol of a zero of f, but for the way from the end of it to the first corner of
//         the polyline: report->residual tells what that does.
// fails:  KN_EDOMAIN (shapes, tol), KN_ELIMIT (f's degrees, added, times a curve's pass KN_MAX_DEGREE),
//         KN_EUNDECIDED (curves that touch: the message says where), KN_ENOMEM, KN_ECANCELLED; outputs unchanged.
// error:  residual: gamma of the composition, f(curve), and the largest coefficient of that.
// cost:   kn_solve_curves_bezier, kn_solve_roots for each curve.
KN_API KN_CHECKED kn_status kn_trim_cut(kn_ctx *ctx, kn_trim *below, kn_trim *above, kn_trim_cut_report *report,
                                        const kn_trim *trim, const kn_bezier *f, double tol);

// The part of a region in the box [lo,hi], whose corners become those of [0,1]^2; *any: there is something (else out is
// empty). An empty trim stays empty: all of it.
// out:    initialised, overwritten, may be trim. Curves along sides of the box are lines exactly on sides of the square.
// fails:  as kn_trim_cut; KN_EDOMAIN not 0 <= lo < hi <= 1; out and *any unchanged.
// error:  the cut is exact but for the rounding of its ends; coordinates within 1e-9 of a side of the box, at ends of
//         curves, lie on it.
// cost:   that of kn_trim_cut for each side of the box that is none of the square.
KN_API KN_CHECKED kn_status kn_trim_restrict(kn_ctx *ctx, kn_trim *out, bool *any, const kn_trim *trim,
                                             const double lo[2], const double hi[2]);

#ifdef __cplusplus
}
#endif
#endif
