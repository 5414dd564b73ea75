// SPDX-License-Identifier: Apache-2.0
// Interpolation, least squares and quasi-interpolation on given knots, any number of variables; lower degrees.
#ifndef KNURL_FIT_H
#define KNURL_FIT_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// Common to all below:
// in:     knots[d]: count[d] + degree[d] + 1 of them, clamped, as kn_spline_init takes them. Values and points are
//         point after point, dim numbers each; points of a grid have the last variable fastest. Nothing checks values
//         for NaN. Parameters lie inside the domain of the knots.
// out:    a polynomial spline of dim components: initialised, overwritten. On failure outputs are unchanged.
// fails:  KN_ENOMEM, and those of kn_spline_init for the shape and the knots.
// error:  A is the matrix of B-splines at the sites, of several variables the tensor product; |c| has absolute
//         values.

// ---- interpolation ----
// out takes values[i*dim + c] at the grid point i of sites[0] x sites[1] x ..
// in:     count[d] increasing sites in variable d.
// out:    at a site that is an end of the domain the edge depends on the values on it alone; corners take them bit
//         for bit.
// fails:  KN_EDOMAIN sites that do not increase or lie outside; KN_EUNDEFINED unless each B-spline is positive at its
//         site, t_i < site_i < t_i+p+1 or at an end (Schoenberg & Whitney): the message names variable and index;
//         KN_EUNDECIDED where such a value underflows, or rounding makes a pivot vanish: a condition beyond 1/u, as
//         of equally spaced sites and degrees above 40.
// error:  |A c - f| <= gamma(sum_d (8 p_d + 4)) A|c|, whatever the condition.
// cost:   3 p^2 count[d] for the factors and 4 p multiply-adds for each value, in each variable; scratch (2 p + 1)
//         count[d] numbers.
// source: de Boor, A Practical Guide to Splines, chapter XIII; de Boor & Pinkus, Numer. Math. 27 (1977).
KN_API KN_CHECKED kn_status kn_fit_interpolate(kn_ctx *ctx, kn_spline *out, int nvars, int dim, const int *degree,
                                               const int *count, const double *const *knots,
                                               const double *const *sites, const double *values);

// ---- knots and sites ----
// sites[i] = the mean of knots i+1 .. i+degree (degree 0: the middle of the span), count numbers: those of the
// coefficients of the identity.
// out:    not decreasing, the first and the last the ends of the domain (but for degree 0). They increase, and suit
//         kn_fit_interpolate, where no interior knot occurs degree + 1 times.
// fails:  KN_EDOMAIN, KN_ELIMIT as kn_spline_init.
// error:  gamma(degree + 2) of the distance from the knots' first; a mean of equal knots is exact.
KN_API KN_CHECKED kn_status kn_fit_greville(kn_ctx *ctx, double *sites, const double *knots, int degree, int count);
// knots, count + degree + 1 of them: clamped, the interior ones equally spaced in [lo,hi].
// fails:  KN_EDOMAIN not lo < hi, count <= degree < 0; KN_ELIMIT.
KN_API KN_CHECKED kn_status kn_fit_uniform_knots(kn_ctx *ctx, double *knots, int degree, int count, double lo,
                                                 double hi);
// Knots for the increasing sites of data, nsites >= count: as many, their means over degree neighbours (for degree 0
// the middles); more, spread so that each B-spline has sites of its own. Both interpolation and least squares are
// then defined.
// fails:  KN_EDOMAIN as said; KN_ELIMIT.
// source: Piegl & Tiller, The NURBS Book, (9.8), (9.68), (9.69).
KN_API KN_CHECKED kn_status kn_fit_averaged_knots(kn_ctx *ctx, double *knots, int degree, int count, int nsites,
                                                  const double *sites);
// sites, n[var] of them from 0 to 1, for variable var of the grid of points n[0] x n[1] x ..: steps in proportion to
// (the distance of neighbours)^exponent, averaged over the grid's lines. exponent 1: chord length, 0.5: centripetal,
// 0: equal steps.
// fails:  KN_EDOMAIN numbers out of range (n[var] < 2 among them), an exponent < 0; KN_EUNDEFINED neighbours that
//         coincide on all lines, so that sites would not increase, or lines without length.
// source: Lee, Choosing nodes in parametric curve interpolation, CAD 21 (1989).
KN_API KN_CHECKED kn_status kn_fit_parameters(kn_ctx *ctx, double *sites, int nvars, int dim, const int *n,
                                              const double *points, int var, double exponent);
// The first (at_end: the last) norders control points of a curve from value, first derivative, .. at that end:
// derivatives[k*dim + c], k < norders. They go to their places in coef, dim arrays of count numbers, whose
// others stay.
// fails:  KN_EDOMAIN, KN_ELIMIT; norders not in 1 .. degree + 1.
// error:  the value exact; gamma(7 degree) of the sums of absolute values in the substitution for the others.
KN_API KN_CHECKED kn_status kn_fit_end_coefficients(kn_ctx *ctx, double *coef, int dim, const double *knots,
                                                    int degree, int count, bool at_end, int norders,
                                                    const double *derivatives);

// ---- least squares ----
// Coefficients that are given: the first[d] and last[d] layers of control points in each variable d. 1 fixes an end
// or an edge, 2 the derivative across it too. coef has the layout of the result's, and only those layers are read.
typedef struct kn_fit_fixed {
    int first[KN_MAX_VARS], last[KN_MAX_VARS];
    const double *coef;
} kn_fit_fixed;

// out minimises the sum over the grid sites[0] x sites[1] x .. of |out - values|^2.
// in:     nsites[d] increasing sites. fixed NULL: nothing. residual NULL: not wanted.
// out:    fixed control points bit for bit as given; *residual the largest distance |out - value| at a site,
//         computed.
// fails:  KN_EDOMAIN sites that do not increase or lie outside, fixed layers that leave nothing free; KN_EUNDEFINED
//         no choice of sites suits the free B-splines (Schoenberg & Whitney): the message names variable and index;
//         KN_EUNDECIDED where values underflow.
// error:  backward stable in each variable: the exact minimiser of a problem whose A differs by gamma(9 (nsites +
//         count) + 5 p) |A| in the Frobenius norm, and whose data by as much of theirs.
// cost:   3 p^2 nsites[d] for the factors and 4 (p + 1) multiply-adds for each value, in each variable; scratch 2 (p
//         + 1) nsites[d] and three grids of values.
// source: Givens rotations: Golub & Van Loan, section 5.2.5; rank: de Boor, A Practical Guide to Splines,
//         chapter XIV.
KN_API KN_CHECKED kn_status kn_fit_least_squares(kn_ctx *ctx, kn_spline *out, double *residual, int nvars, int dim,
                                                 const int *degree, const int *count, const double *const *knots,
                                                 const int *nsites, const double *const *sites, const double *values,
                                                 const kn_fit_fixed *fixed);
// out minimises sum_i weights[i]^2 |out(at_i) - values_i|^2 over npoints parameters at[i*nvars .. ], in any order,
// repeated ones too. weights NULL: ones.
// out:    as kn_fit_least_squares; the residual is without weights.
// fails:  KN_EDOMAIN a parameter outside, weights that are not positive, fixed layers; KN_ELIMIT a band of more than
//         KN_MAX_COEFS numbers; KN_EUNDEFINED a curve: Schoenberg & Whitney as above; otherwise: the points do not
//         determine a control point, to working precision (the message names it).
// error:  as kn_fit_least_squares, for the one matrix.
// cost:   W^2 for each point, W = 1 + sum_d p_d prod_(e > d) count[e] the width of the band; scratch W prod count.
KN_API KN_CHECKED kn_status kn_fit_scattered(kn_ctx *ctx, kn_spline *out, double *residual, int nvars, int dim,
                                             const int *degree, const int *count, const double *const *knots,
                                             size_t npoints, const double *at, const double *values,
                                             const double *weights, const kn_fit_fixed *fixed);

// ---- functions ----
// Writes the dim numbers of a function at the nvars parameters `at`. Anything but KN_OK ends the fit with it.
typedef kn_status (*kn_fit_function)(void *user, double *value, const double *at);

// out = the local quasi-interpolant of a function: coefficient j depends on its values at degree + 1 neighbouring
// Greville sites in each variable, and polynomials of the degrees come out unchanged. No system is solved, and
// nothing far away has influence.
// out:    corners take the function's values bit for bit; an edge depends on the values along it alone.
// fails:  KN_EDOMAIN an interior knot that occurs degree + 1 times; whatever `function` answers.
// error:  O(h^(p+1)) for smooth functions: (1 + |Q|) times the distance from polynomials, |Q| the largest sum of
//         absolute weights: 1, 1.5, 1.7, 2.2 .. for degrees 1, 2, 3, 4 .. inside equal spans, larger at the ends and
//         on uneven ones. Polynomials come out with gamma(sum_d (16 p_d + 8)) prod_d (|Q_d| + 1) times the largest
//         absolute value of their blossoms near by.
// cost:   prod count values of the function; p^3 for each coefficient of each variable; p + 1 multiply-adds for each
//         coefficient in each variable.
// source: Lyche & Schumaker, Local spline approximation methods, J. Approx. Theory 15 (1975); sites as in
//         Sablonniere, Recent progress on univariate and multivariate polynomial and spline quasi-interpolants
//         (2005).
KN_API KN_CHECKED kn_status kn_fit_quasi(kn_ctx *ctx, kn_spline *out, int nvars, int dim, const int *degree,
                                         const int *count, const double *const *knots, kn_fit_function function,
                                         void *user);
// out = a quasi-interpolant over [lo[d],hi[d]] on knots that are halved, variable by variable, until the distance
// from the function at sampled parameters is at most the tolerance.
// in:     degree[d] >= 1, tolerance > 0. out: *estimate (NULL: not wanted) the largest distance at the samples: an
//         estimate, no bound. Features of the function that fall between all samples are not seen.
// fails:  KN_EDOMAIN; KN_EUNDECIDED more than max_count control points in one variable would be needed (0: 4096), or
//         spans shorter than 2^-40 of the largest parameter, as at a jump; whatever `function` answers.
// cost:   each round: 1 + 2 nvars values of the function for each control point, the last 2^nvars more; rounds grow.
KN_API KN_CHECKED kn_status kn_fit_to_tolerance(kn_ctx *ctx, kn_spline *out, double *estimate, int nvars, int dim,
                                                const int *degree, const double *lo, const double *hi,
                                                kn_fit_function function, void *user, double tolerance,
                                                int max_count);

// ---- limited degree ----
typedef struct kn_fit_limits {
    int max_degree;   // of the result in each variable, at least 3: a higher degree is replaced
    int degree;       // by this one, 3 .. max_degree; 0: 5, or max_degree where that is less
    double tolerance; // > 0, length units: of the distance at equal parameters
    // 0, or a power of two, at most tolerance / 4: inner control points of polynomial edges are multiples of it, or of
    // a smaller one where the edge is short, so that knots are inserted without rounding and edges agree exactly also
    // where one side has more spans than the other; but not edges of low degree, which stay what they were, nor the
    // point after a corner from which an edge sets out at no speed: it is that corner.
    double quantum;
    int max_level; // of halving in each variable; 0: 8; at most 10
    // Radians, at most 0.8: spans of a surface in space are halved, up to 5 times, until its normals turn by no more
    // along each edge, certified, as far as that can be had (kn_fit_limited); 0: whatever comes.
    double angle;
} kn_fit_limits;

typedef struct kn_fit_limited {
    double error;           // certified bound of the distance at equal parameters, rounding included; 0: exact
    int spans[KN_MAX_VARS]; // in each variable, equal ones
    bool exact;             // no degree passes the limit: the piece itself
    // Of surfaces in space: a certified bound of the angle between their normals and the piece's along the edges,
    // radians, but for unknown_angles of the four, where none was found, as where the normal almost vanishes.
    // wide_angles of the others are above the limits' angle: more spans were of no use, or too many. Along
    // singular_angles of the others the piece itself has no normal in places, as at a pole: it is no longer than
    // rounding may make it. There, and within 2^-10 of a span from such a place, the bound says nothing. Two that
    // share an edge meet at the angle they had, but for the sum of theirs.
    double angle;
    int unknown_angles, wide_angles, singular_angles;
    double edge_angle[4]; // of each edge, in the order of `edges`: its bound; INFINITY: unknown
    bool edge_singular[4];
} kn_fit_limited;

// out = a spline over [0,1]^nvars of degree at most max_degree in each variable, within the tolerance of the piece a,
// C1 inside. In a variable of lower degree nothing is approximated. Small pieces are fitted more closely: an edge
// within 1/128 of its size, a surface within 1/32 of the least of its edges' sizes, or twice their errors; edges below
// 2^-10 of the tolerance count as points.
// in:     edges: NULL, or four splines, initialised.
// out:    corners are a's, bit for bit. An edge of a surface depends on the control points of a's edge and the limits
//         alone, whichever way it runs: pieces that share an edge bit for bit share the fitted one. edges[0 ..]: r =
//         0, r = 1, t = 0, t = 1 as fitted, each on as few spans as it needs by itself, equal bit for bit on both
//         sides up to the direction; out's ends are these with knots inserted (exactly but for the spans at corners,
//         which may round; see quantum). Empty where a is exact or no surface. The first derivative across an edge
//         depends on a's derivative across it alone, and on the number of spans: pieces that join C1 and have the
//         same number along the edge still do. *report: NULL is fine.
// fails:  KN_EDOMAIN limits; KN_ELIMIT max_level, or more than 2^25 coefficients of a on all spans; KN_EUNDEFINED a
//         control point is not finite; KN_EUNDECIDED more than 2^max_level spans would be needed, or a weight of the
//         fit is not positive; KN_ENOMEM; outputs unchanged.
// error:  *report's bound is at most 1.25 times the largest distance where halving can show it, from the
//         coefficients of the difference.
// cost:   for each number of spans that is tried a transform of the control points along each variable, and for each
//         span the elevation of the fit and a difference.
// source: least squares with end conditions: Lutterkort, Peters & Reif, CAGD 16 (1999); Ahn, Lee, Park & Yoo, CAGD 21
//         (2004). Edges by themselves: docs/numerics.md, "fit".
KN_API KN_CHECKED kn_status kn_fit_limit_degree(kn_ctx *ctx, kn_spline *out, kn_spline *edges, kn_fit_limited *report,
                                                const kn_bezier *a, const kn_fit_limits *limits);

#ifdef __cplusplus
}
#endif
#endif
