// SPDX-License-Identifier: Apache-2.0
// Curves, surfaces and volumes from a few numbers, or from each other.
#ifndef KNURL_CONSTRUCT_H
#define KNURL_CONSTRUCT_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// Common to all below:
// in:     operands as in spline.h. Numbers are finite (else KN_EDOMAIN), points have dim numbers, vectors 3. Operands
//         that are combined may differ in degrees and knots: they are elevated and refined to common ones first. Of
//         polynomial and rational ones the polynomial get the weight 1, and all combinations are of homogeneous
//         coordinates; where that makes a difference it is said.
// out:    initialised, overwritten, may be an operand; unchanged by a call that fails. What is made from numbers has
//         the domain [0,1] in each variable. What is made from splines keeps their variables and domains; a variable
//         that is added comes last and has the domain [0,1]. A surface made from numbers has S_u x S_v outwards.
// fails:  KN_ENOMEM, KN_ELIMIT, KN_EDOMAIN as said.
// error:  where nothing is said, each coefficient comes from operands' by sums of a few products: gamma(8) of the
//         sums of absolute values, after elevation and refinement.

// ---- curves ----
// The straight segment from a to b: degree 1.
KN_API KN_CHECKED kn_status kn_construct_line(kn_ctx *ctx, kn_spline *out, int dim, const double *a, const double *b);
// The polyline through n >= 2 points, point i at i/(n-1): degree 1.
KN_API KN_CHECKED kn_status kn_construct_polyline(kn_ctx *ctx, kn_spline *out, int dim, int n, const double *points);
// center + cos(t) x + sin(t) y for t from 0 to angle, 0 < angle <= 2 pi: an arc of a circle where x and y are
// perpendicular and equally long, of an ellipse otherwise.
// in:     angle in radians; 1 to 4 times the double next to pi/2 stand for exact quarter turns. x, y not parallel.
// out:    rational of degree 2, one piece for each quarter begun, all equally long in t and in the parameter, joined
//         by double knots; weights 1 and cos(half a piece's angle). The first point is center + x, and after a whole
//         turn the last control point is the first, bit for bit.
// fails:  KN_EDOMAIN the angle; KN_EUNDEFINED x and y are parallel.
// error:  of a coefficient gamma(4) (|center| + |x| + |y|), two units in the last place for cos and sin included.
//         With center 0 and x, y axes of length r, x^2 + y^2 = r^2 w^2 up to 16 u r^2 in each Bernstein coefficient.
// source: Piegl & Tiller, The NURBS Book, section 7.5.
KN_API KN_CHECKED kn_status kn_construct_arc(kn_ctx *ctx, kn_spline *out, const double center[3], const double x[3],
                                             const double y[3], double angle);
// The whole ellipse with conjugate half-diameters x and y: kn_construct_arc by a whole turn.
KN_API KN_CHECKED kn_status kn_construct_ellipse(kn_ctx *ctx, kn_spline *out, const double center[3],
                                                 const double x[3], const double y[3]);
// The circle around center in the plane across normal (any length), counterclockwise seen from its tip. It begins in
// the direction that kn_construct_sphere calls x for the axis `normal`.
// fails:  KN_EDOMAIN radius <= 0; KN_EUNDEFINED normal 0.
KN_API KN_CHECKED kn_status kn_construct_circle(kn_ctx *ctx, kn_spline *out, const double center[3],
                                                const double normal[3], double radius);

// ---- surfaces of revolution by name: u the angle, counterclockwise around the axis, v along the profile ----
// Rational of degree 2 in u on four pieces of a quarter turn; closed bit for bit. x is the unit vector across the
// axis in the plane of the axis and the coordinate axis least parallel to it (the first of equals), on its side; u =
// 0 lies there.
// error:  of a coefficient gamma(10) of the sum of the lengths in it.

// v: from the south pole to the north pole along z, degree 2 on two pieces. All control points of a pole are one
// point up to the rounding of its weights. fails: KN_EDOMAIN radius <= 0.
KN_API KN_CHECKED kn_status kn_construct_sphere(kn_ctx *ctx, kn_spline *out, const double center[3], double radius);
// v: the circle of radius minor, counterclockwise in (distance from the axis, axis), from the outermost point on;
// degree 2 on four pieces. fails: KN_EDOMAIN not 0 < minor < major; KN_EUNDEFINED axis 0.
KN_API KN_CHECKED kn_status kn_construct_torus(kn_ctx *ctx, kn_spline *out, const double center[3],
                                               const double axis[3], double major, double minor);
// v: from the circle around base to that around base + axis, degree 1; no caps. fails: as the torus; radius <= 0.
KN_API KN_CHECKED kn_status kn_construct_cylinder(kn_ctx *ctx, kn_spline *out, const double base[3],
                                                  const double axis[3], double radius);
// The same with different radii: a frustum, or a cone where one is 0. fails: KN_EDOMAIN a radius < 0, or both 0.
KN_API KN_CHECKED kn_status kn_construct_cone(kn_ctx *ctx, kn_spline *out, const double base[3], const double axis[3],
                                              double base_radius, double top_radius);

// ---- one variable more: a curve becomes a surface, a surface a volume, .. ----
// out(.., t) = (1 - t) a + t b, of equal dimension over equal domains; degree 1 in t. At t = 0 and 1 bit for bit a
// and b as made compatible. Rational: the segments are straight; the weights decide the speed along them.
// fails:  KN_EDOMAIN dimensions, variables or domains differ; KN_ELIMIT variables.
KN_API KN_CHECKED kn_status kn_construct_ruled(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
// out(.., t) = a + t vector; dim numbers. At t = 0 bit for bit a. Of a curve S_u x S_v is tangent x vector.
KN_API KN_CHECKED kn_status kn_construct_extruded(kn_ctx *ctx, kn_spline *out, const kn_spline *a,
                                                  const double *vector);
// a, of dimension 3, turned about the axis through origin by t angle, counterclockwise seen from the axis' tip:
// degree 2, pieces and angle as for kn_construct_arc. At t = 0 bit for bit a, and a whole turn closes bit for bit.
// Control points nearer to the axis than 16 u (|point| + |origin|) count as on it and stay single points. S_u x S_v
// points away from the axis where the curve a runs against the axis.
// fails:  KN_EDOMAIN dimension, angle; KN_EUNDEFINED axis 0.
// source: Piegl & Tiller, The NURBS Book, section 8.5.
KN_API KN_CHECKED kn_status kn_construct_revolved(kn_ctx *ctx, kn_spline *out, const kn_spline *a,
                                                  const double origin[3], const double axis[3], double angle);
// Through n >= 2 sections, of equal dimension over equal domains: section i at site[i], interpolated with this
// degree (1 .. n-1) in the added variable on averaged knots; its domain is that of the sites.
// in:     sites: n increasing numbers, or NULL: chord lengths of the control points, averaged, from 0 to 1.
// out:    the first and the last section bit for bit as made compatible; the others within rounding.
// fails:  KN_EDOMAIN; KN_EUNDEFINED sections that coincide (sites NULL), weights that do not stay positive.
// error:  as kn_fit_interpolate in the added variable. Rational: weights are interpolated, too.
// source: Piegl & Tiller, The NURBS Book, section 10.3.
KN_API KN_CHECKED kn_status kn_construct_skinned(kn_ctx *ctx, kn_spline *out, int n, const kn_spline *sections,
                                                 int degree, const double *sites);

// ---- sums ----
// out(u.., v..) = profile(u..) + trajectory(v..), of equal dimension: the profile moved without turning; exact.
// out:    profile's variables, then trajectory's, with their degrees and knots; rational if either is.
KN_API KN_CHECKED kn_status kn_construct_swept(kn_ctx *ctx, kn_spline *out, const kn_spline *profile,
                                               const kn_spline *trajectory);
// out(u.., v) = trajectory(v) + M(v) profile(u..): the profile, in coordinates (n, b, t), moves with the frame t =
// the trajectory's direction, b = the part of `up` across t, n = b x t, all of length 1. Both of dimension 3, the
// trajectory a curve.
// out:    M is replaced by a cubic spline that agrees with it within the tolerance, the rest is exact: *estimate
//         (NULL: not wanted) is the largest distance found at samples times the size of the profile: an estimate, no
//         bound. Degrees in v: those of trajectory and cubic, added up where the trajectory is rational.
// fails:  KN_EDOMAIN; KN_EUNDEFINED no tangent, or one that is parallel to up, at a place in the message;
//         KN_EUNDECIDED the tolerance needs more than 4096 control points, at a corner of the trajectory for example.
KN_API KN_CHECKED kn_status kn_construct_swept_frame(kn_ctx *ctx, kn_spline *out, double *estimate,
                                                     const kn_spline *profile, const kn_spline *trajectory,
                                                     const double up[3], double tolerance);
// The Boolean sum of 2 nvars boundaries: faces[2 d] at the lower and faces[2 d + 1] at the upper end of variable d,
// each over the other variables in their order. nvars 2: the Coons surface of the curves u = 0, u = 1 (over v) and v
// = 0, v = 1 (over u); 3: the volume between six surfaces; any number. With P_d the linear interpolation between two
// faces, out = faces - (1 - P_0)(1 - P_1) .. faces.
// in:     faces of equal dimension; domains agree. Where two meet, control points (homogeneous; as made compatible)
//         differ by at most the tolerance >= 0 in each component.
// out:    degree at least 1 in each variable. Boundaries are bit for bit the faces as made compatible; where two
//         differ, that of the lower variable wins. Of surfaces S_u x S_v follows from the curves.
// fails:  KN_EDOMAIN shapes, domains, faces that do not meet (the message says which); KN_EUNDEFINED weights that do
//         not stay positive.
// error:  gamma(sum_d (p_d + 8)) of the sums of absolute values. Rational: sums of homogeneous coordinates.
// source: Coons (1967); Gordon, Blending-function methods of bivariate and multivariate interpolation, SINUM 8
//         (1971).
KN_API KN_CHECKED kn_status kn_construct_coons(kn_ctx *ctx, kn_spline *out, int nvars, const kn_spline *const *faces,
                                               double tolerance);

#ifdef __cplusplus
}
#endif
#endif
