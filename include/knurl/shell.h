// SPDX-License-Identifier: Apache-2.0
// kn_shell: the map T from texture space (u,v,w) to the neighbourhood of a base: T = S + w h n + w^k psi over a
// surface S with its unit normal n (or a field in its place), or a trivariate spline itself.
// Source: Elber, Geometric Texture Modeling, IEEE CG&A 25(4), 2005.
#ifndef KNURL_SHELL_H
#define KNURL_SHELL_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// How far a vector field m is from the true unit normal N/|N|, N = S_u x S_v. Both are upper bounds over the whole
// region, computed from Bernstein coefficients with their own rounding included, never from samples.
typedef struct kn_normal_certificate {
    double length_error; // bound of | |m| - 1 |
    double angle_error;  // bound of the angle between m and N, radians
    bool certified;      // false: no bound could be established (the numbers are then INFINITY)
} kn_normal_certificate;

typedef struct kn_shell kn_shell;

// How n represents the unit normal N/|N|.
typedef enum kn_normal_method {
    KN_NORMAL_FITTED,          // a spline of low degree that interpolates N/|N|
    KN_NORMAL_EXACT_DIRECTION, // N m, m a spline near 1/|N|: the direction is exact, the degree that of N plus m's
} kn_normal_method;

// Zero means the default in every field. Splines are copied; their variables are S's own, over S's domain (bit for
// bit), and their knots become knots of S (inserted exactly; one within rounding of a knot of S is that knot), at
// which cell lines must lie. Everything of them is exact: T = S + w h n + w^k psi, or S + w h d + w^k psi.
typedef struct kn_shell_options {
    kn_normal_method normal;
    const kn_spline *direction;  // d, dim 3, polynomial: takes the place of n, any length. NULL: n
    const kn_spline *thickness;  // dim 1, polynomial, positive: h, w counts in thicknesses. NULL: 1
    const kn_spline *attraction; // dim 3, polynomial: psi. NULL: none
    int attraction_power;        // k >= 1; 0: 2
    // Cell lines in S's own parameters, increasing, from one end of the domain to the other. Every interior knot of S
    // must be among them (KN_EDOMAIN otherwise). NULL: the knots of S, those of the fields above among them.
    const double *lines[2];
    int nlines[2];
    double normal_tol; // the largest length error and angle error allowed; 0: 1e-6
    // Of n in one variable, of m where n = N m; at least 3, lowered where S has high degrees (as below). 0: 5, or 3
    // for m: more leave fewer spans, but tiles compose to higher degrees.
    int max_degree;
    int min_degree[2]; // and at least these, up to 18; 0: 3
    // Where max_degree leaves knots of n between cell lines: degrees up to 18 instead, if their sum is no more than
    // this; 0: never. Then n is one polynomial over every cell, C2 across their lines, or C0 where that does not do.
    int cell_degree_sum;
    bool cells_apart[2]; // n is C0 alone across lines in this variable, whatever its degree
    int max_spans;       // knot intervals of n in one variable, beyond which refinement gives up; 0: 4096
} kn_shell_options;

KN_API kn_shell_options kn_shell_defaults(void);

// The shell of a surface (nvars 2, dim 3, polynomial or rational), which is copied. N is S_u x S_v over each knot
// span, with the factors that vanish along its edges divided out exactly (of S = P/W: W^3 times it). The knots of n
// contain the cell lines (of more than 64 in a variable a share of them), and more where the tolerance asks for it.
// An edge whose control points agree to 1e-9 of S's size in each coordinate, but not as nearly as rounding leaves them,
// is noise around a pole: in the shell's copy (kn_shell_surface) they become one point, the middle of theirs, and two
// such edges that meet become one. S in use then differs from the caller's by no more than that, and so do the ends of
// the edges beside it from those of neighbouring surfaces. An edge that is larger, up to 1e-4, is taken as it is; where
// no normal is found then, the message says so.
// KN_NORMAL_FITTED: degrees 3 .. max_degree in each variable, the lowest that do (with cell_degree_sum 1 .. 18, where
//         max_degree is not enough); C2 or smoother wherever S is C3 or smoother, as far as these degrees go (C0: cell_degree_sum). n
//         interpolates N/|N|, so that its coefficients along an edge depend on N/|N| and on the knots along that edge
//         alone; over the seam of a closed S they are the same bit for bit; where S is one point with one normal, n is
//         one vector.
// KN_NORMAL_EXACT_DIRECTION: degrees of N plus 3 .. max_degree. n = N m, m a spline that interpolates 1/|N|: the
//         angle error is rounding. n is as smooth as S_u x S_v and m. Along an edge that two surfaces share, and
//         where they touch, their n agree when |S_u x S_v| of the two is the same but for one factor, and else to the
//         tolerance, in length alone. At a pole n is one vector, which turns it in the spans next to the pole by less
//         than a tenth of the tolerance (the certificate says by how much). Beside a factor that was divided out n is
//         C0 on the next line.
// At a knot where S is C1 or less n is joined if both sides agree (of N m: in length too, but for one factor along
// the line), and else it jumps there.
// out:    *out is the caller's: kn_shell_destroy. A shell is never written to afterwards: any number of threads may
//         use it, each with a context of its own.
//         With a direction of its own S needs no normal, and is not asked for one.
// fails:  KN_EDOMAIN (shapes, options, lines, fields over another domain, a thickness that is not certainly positive,
//         a surface of zero area: the message says which), KN_EUNDEFINED (no normal at some point: the message names
//         it, in the parameters and in space), KN_EUNDECIDED (normal_tol not met within max_spans, or below about
//         1e-12, what rounding leaves; a surface so wild that the search for points without a normal, or meeting the
//         tolerance, would take some seconds: 1e9 (1e-6 / normal_tol)^(1/3) multiply-adds, four times that with an
//         exact direction, for each span of S and 1 more), KN_ELIMIT (more knot spans than max_spans, max_degree above
//         12, a degree p of S with 2 p - 1, of a rational S 3 p - 1, above KN_MAX_DEGREE - 3, with an exact
//         direction above KN_MAX_DEGREE / 2 - 3: N and n are multiplied), KN_ENOMEM.
// error:  kn_shell_certificate bounds the whole of it; docs/normals.md.
// cost:   about 20 us for each span of n and round of refinement, twice that with an exact direction; a patch of the
//         Utah teapot at 1e-6: 3 to 150 ms.
// source: Elber 2005, sidebar "Unit Normal Field Approximation"; de Boor & Pinkus, Numer. Math. 27 (1977).
KN_API KN_CHECKED kn_status kn_shell_create(kn_ctx *ctx, kn_shell **out, const kn_spline *surface,
                                            const kn_shell_options *options);
KN_API void kn_shell_destroy(kn_ctx *ctx, kn_shell *shell);

// S, with the knots of the fields inserted and noisy poles collapsed (kn_shell_create); of a volume its face at w = 0.
KN_API const kn_spline *kn_shell_surface(const kn_shell *shell);
// n, without the thickness. With a direction in its place: h d. Of a volume an empty spline.
KN_API const kn_spline *kn_shell_normal(const kn_shell *shell);
// Of n. Errors 0, certified, where there is no n: a direction and a volume are what they are.
KN_API kn_normal_certificate kn_shell_certificate(const kn_shell *shell);
KN_API void kn_shell_cells(const kn_shell *shell, int cells[2]);
// closed[d]: the two edges across variable d coincide, and so do n, to ten normal_tol, and the fields (the faces of a
// volume), so that cell -1 is the last cell.
KN_API void kn_shell_closed(const kn_shell *shell, bool closed[2]);

// T at (u,v) in S's parameters and signed height w (in S's length unit, or what thickness, direction and volume make
// of it). jacobian, when not NULL, receives the 3 x 3 matrix dT/d(u,v,w), row by row. Beyond the domain the end
// pieces of S, of n and of the fields go on.
// fails: KN_EDOMAIN (not finite), KN_ENOMEM; outputs unchanged. error: as kn_spline_derivatives, of S plus |w|^k of
//        each field; of a volume as that of the volume.
KN_API KN_CHECKED kn_status kn_shell_eval(kn_ctx *ctx, double point[3], double *jacobian, const kn_shell *shell,
                                          double u, double v, double w);
// The true unit normal of S at (u,v), by direct evaluation (poles divided out, but not where a direction or a volume
// takes the place of n), without the fitted spline.
// fails: KN_EDOMAIN (not finite), KN_EUNDEFINED (none there, which can happen beyond the domain alone); unchanged.
KN_API KN_CHECKED kn_status kn_shell_unit_normal(kn_ctx *ctx, double normal[3], const kn_shell *shell, double u,
                                                 double v);

// Bounds of det dT/d(u,v,w) over the cells for w in [w0,w1]: *lo <= det <= *hi, rounding included, for shells of
// every kind (source: det is a polynomial in w with coefficients that are splines over (u,v); kn_shell_jacobian). The
// unit: length^3 per parameter^2 and unit of w. The bounds lie within about 2 % of the range outside the true ones (T
// with an attraction: a little more); at a pole det is 0 and lo is 0 less the rounding. Where numbers over- or
// underflow they are -INFINITY and INFINITY.
// fails:  KN_EDOMAIN (w0 > w1, not finite), KN_ELIMIT as kn_shell_jacobian, KN_ENOMEM, KN_ECANCELLED; outputs
//         unchanged. cost: about 60 us for each span of n.
KN_API KN_CHECKED kn_status kn_shell_jacobian_bounds(kn_ctx *ctx, double *lo, double *hi, const kn_shell *shell,
                                                     double w0, double w1);

// ---- shells of other kinds ----

// T = the volume itself (three variables, dim 3, polynomial or rational; copied): ruled between two surfaces,
// extruded, swept, revolved (construct.h), or read from a file. w counts from the lower end of the volume's third
// domain [a,b]: T(u,v,w) = volume(u, v, a + w), 0 <= w <= b - a; beyond that the end pieces go on. S is its face at
// w = 0, which may be degenerate. Of the options the cell lines and max_spans alone count.
// fails: as kn_shell_create for shapes and lines; KN_ELIMIT a degree in w of KN_SHELL_TERMS or more; KN_ENOMEM.
//        A volume with knots in w has no pieces (kn_shell_piece_init: KN_EDOMAIN); all else works.
// error: pieces are in powers of w: coefficient k is off by gamma(3 m + k + 4) C(m,k) 2^k max |coefficient| / (b -
//        a)^k for degree m in w. kn_shell_eval and kn_shell_volume use the volume as it is.
KN_API KN_CHECKED kn_status kn_shell_from_volume(kn_ctx *ctx, kn_shell **out, const kn_spline *volume,
                                                 const kn_shell_options *options);
// The heights for which T is defined: 0 and b - a of a volume, and -INFINITY, INFINITY otherwise.
KN_API void kn_shell_heights(const kn_shell *shell, double w[2]);
// out = T over the whole domain and w in [w0,w1] as one trivariate spline in (u, v, w), polynomial or rational.
// out:    initialised, overwritten. The degree in w is the largest power of w in T (1 for n alone); in u and v the
//         largest of S, h n and the fields, each plus that of the weight when S is rational. Knots: those of all.
//         Of a volume the volume itself, restricted.
// fails:  KN_EDOMAIN (not w0 < w1, not finite), KN_ELIMIT degrees, coefficients; KN_ENOMEM; out unchanged.
// error:  kn_spline_product (h n, and the weight's products), kn_spline_make_compatible, and gamma(k + 4) for w^k in
//         Bernstein form, of the sums in absolute values. Of a volume kn_spline_restrict.
KN_API KN_CHECKED kn_status kn_shell_volume(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, double w0, double w1);

// The pieces of S between its creases: knots at which S is only C0 and the normals of the two sides differ by more
// than `angle` radians somewhere along the line; where it cannot be certified that they do not, it counts as a
// crease, as does a knot at which S itself jumps, and one beside a span of S without area.
// in:     0 <= angle <= 1.57; below some 1e-12, what rounding leaves, every knot where S is only C0 is a crease.
// out:    *pieces, counts[0] * counts[1] of them, u slowest, in S's own parameters, kn_spline_clear each, kn_free.
//         Common edges agree bit for bit. One piece, a copy of S, where there is none.
// fails:  KN_EDOMAIN (shape, angle), KN_ELIMIT (degrees as for kn_shell_create), KN_ECANCELLED, KN_ENOMEM; outputs
//         unchanged.
// error:  what is not split is within `angle`, rounding included.
// cost:   two cross products of derivatives for each span along such a knot.
KN_API KN_CHECKED kn_status kn_shell_split_creases(kn_ctx *ctx, kn_spline **pieces, int counts[2],
                                                   const kn_spline *surface, double angle);

// What an edge of the domain is.
typedef enum kn_edge_kind {
    KN_EDGE_CURVE,
    KN_EDGE_POLE, // S is one point there and has one normal, the limit from inside
    KN_EDGE_APEX, // S is one point there, a cone's apex, with a normal for each direction in which it is approached
} kn_edge_kind;
typedef struct kn_shell_edge {
    kn_edge_kind kind;
    double point[3]; // of a pole or apex
    int order;       // how often the vanishing factor was divided out of S_u x S_v there, the most of all spans
} kn_shell_edge;
// edges[variable][end]. One point: all control points of the edge, to 1e-12 of the surface's size and 32 units of
// rounding of the largest coordinate. One normal: all coefficients of N along the edge, to 1e-10 of the largest and
// what that rounding makes of them. At an apex each parameter line keeps its own limit of
// the normal: the shell opens there, into the arc or circle that n draws at distance w. Where S is no base of normals
// (a direction of its own, a volume) every collapsed edge is a pole of order 0.
KN_API void kn_shell_edges(const kn_shell *shell, kn_shell_edge edges[2][2]);

// ---- pieces ----

// T as one polynomial or rational piece over a box of (u,v): T = sum_t term[t](x) w^power[t], x in [0,1]^2 over the
// box, w in the shell's own unit. term[0] is S, power[0] = 0; then h n with power 1, where there is n, and the fields
// (powers may repeat). term[t] has 3 components, or 4 homogeneous ones when T is rational.
enum { KN_SHELL_TERMS = 16 };
typedef struct kn_shell_piece {
    int nterms;
    int power[KN_SHELL_TERMS];
    kn_bezier term[KN_SHELL_TERMS];
    bool exact; // n is the shell's own spline, or there is none; false: a polynomial stands in for it on this box
    kn_normal_certificate normal; // of the n in use, over this box; as kn_shell_certificate where there is none
    // Bound of |h n in use - the shell's h n| over the part of the box inside the domain; 0 when exact. Beyond the
    // domain the shell's n, extended, may drift off any normal, and `normal` alone tells what n in use is.
    double deviation;
} kn_shell_piece;

// The piece over the box [lo,hi] of cell (i,j), in cell coordinates: [0,1]^2 is the whole cell; boxes may reach
// beyond it, and beyond the domain, where S's end pieces are extended as polynomials; the box must not contain a knot
// of S in its interior (KN_EDOMAIN). i or j outside 0 .. cells-1 wraps in closed directions and extends in open ones.
// Where n has knots inside the box, *fits tells whether one polynomial of degrees (a,b), a + b <= degree_sum, meets
// normal_tol over the whole box; if none does, *fits is false, out is unchanged, and the caller may try smaller
// boxes. Those tried are interpolants at Chebyshev-Lobatto sites, of degrees that the normal's Chebyshev coefficients
// along three lines each way suggest, and up; with KN_NORMAL_EXACT_DIRECTION N times an interpolant of 1/|N|, so that
// the angle error is rounding there too. Boxes beyond the domain keep n's end piece when that is still within
// normal_tol, and else get a stand-in. A box wholly beyond the seam of a closed direction is taken from the other
// end. out:   overwritten, not cleared: kn_shell_piece_clear. Neighbouring whole cells that are exact share the
//        coefficients of their common edge bit for bit.
// degree_sum is for n alone: h n has the degrees of h more.
// fails: KN_EDOMAIN (lo >= hi, not finite, a knot of S inside, a volume with knots in w), KN_ENOMEM; out and *fits
//        unchanged.
// cost:  exact: some us; a stand-in of degrees (5,5) on a bicubic: about 100 us.
KN_API KN_CHECKED kn_status kn_shell_piece_init(kn_ctx *ctx, kn_shell_piece *out, bool *fits, const kn_shell *shell,
                                                const int cell[2], const double lo[2], const double hi[2],
                                                int degree_sum);
// The same answers, for who only wants to know what the piece is: where n is the shell's own inside the domain, terms
// have their degrees and no coefficients (coef NULL). cost: then some 100 ns.
KN_API KN_CHECKED kn_status kn_shell_piece_outline(kn_ctx *ctx, kn_shell_piece *out, bool *fits,
                                                   const kn_shell *shell, const int cell[2], const double lo[2],
                                                   const double hi[2], int degree_sum);
KN_API void kn_shell_piece_clear(kn_ctx *ctx, kn_shell_piece *piece);
// The pieces over n whole cells (i,j), (i,j+1) .. that follow one another along v, for who composes many: what
// kn_shell_piece_init makes of them, bit for bit, without an object for each.
// in:    like: the terms that are asked for, as the outline of such a cell has them. cell[1] + n is an int.
// out:   *made cells, from the first one on: up to one with other terms than `like`, or beyond the domain, or with a
//        knot inside, or whose terms are products (a thickness of n; terms beside a rational S): that one is for
//        kn_shell_piece_init. rows, room for all n: for each cell its components, of each the coefficients of its
//        terms, one after the other; beyond *made they may change.
// fails: KN_EDOMAIN (n < 0, cell[1] + n too large, no terms, too many), KN_ENOMEM; *made unchanged.
// cost:  of a bicubic with a bicubic normal some 150 ns a cell.
KN_API KN_CHECKED kn_status kn_shell_piece_rows(kn_ctx *ctx, double *rows, int *made, const kn_shell *shell,
                                                const kn_shell_piece *like, const int cell[2], int n);

// ---- the inverse ----

// A shell as Bezier pieces of T with their boxes in space: made once, asked often. It holds all that it needs of the
// shell, and is never written to: any number of threads may ask, each with a context of its own.
typedef struct kn_shell_inverse kn_shell_inverse;

// For places (u,v,w) of the whole domain with w in [w0,w1].
// out:    *out is the caller's: kn_shell_inverse_destroy.
// fails:  KN_EDOMAIN (not w0 < w1, not finite, or beyond kn_shell_heights), KN_ELIMIT (degrees of T above
//         KN_MAX_DEGREE), KN_EUNDEFINED (weights that are not positive), KN_ENOMEM, KN_ECANCELLED; *out unchanged.
// cost:   some 20 us and one copy of its coefficients for each piece: T between neighbouring knots of n, halved up to
//         6 times where there are few, and 20 times as many next to a pole.
KN_API KN_CHECKED kn_status kn_shell_inverse_create(kn_ctx *ctx, kn_shell_inverse **out, const kn_shell *shell,
                                                    double w0, double w1);
KN_API void kn_shell_inverse_destroy(kn_ctx *ctx, kn_shell_inverse *inverse);

// A place (u,v,w) with T(u,v,w) = point: S(u,v) is a support position of the point (definitions 1 and 2 of the
// source).
typedef struct kn_support {
    double uvw[3];   // inside the domain
    double error[3]; // the true place is within so much of uvw in each parameter
    bool certified;  // one place, and no other, is proved to lie in that box; false: it may hold none, one or many
    bool at_edge; // the box reaches an end of the domain, of [w0,w1], or both: the place may lie beyond by the error
} kn_support;
// All support positions of a point with w in the inverse's [w0,w1].
// out:    *supports: *n of them, ordered by |w|, for kn_free. Every place lies in the box of one of them. Where T
//         folds (its Jacobian is singular) they are not certified: one box for each group of places that touch.
//         *complete: no box is wider than its fold makes it; false: places form a continuum (the centre of a sphere),
//         or the work limit was met. u and u + period are one place, and so is a pole, whatever u: its error in u
//         spans the domain.
// fails:  KN_EDOMAIN (not finite), KN_ENOMEM, KN_ECANCELLED; outputs unchanged.
// error:  none: boxes are certified of T itself, with the rounding of its coefficients inside (docs/numerics.md).
// cost:   30 to 90 us where T is regular (bicubic, rational biquadratic), three times that on borders of pieces, up
//         to 0.2 s at a fold: at most 16384 boxes are looked at (fewer where degrees are high: 4 million
//         coefficients), and 512 at one time.
// source: as kn_solve_zeros.
KN_API KN_CHECKED kn_status kn_shell_support(kn_ctx *ctx, kn_support **supports, size_t *n, bool *complete,
                                             const kn_shell_inverse *inverse, const double point[3]);
typedef enum kn_side {
    KN_SIDE_NONE,  // certified: no support position with w in [w0,w1]
    KN_SIDE_ON,    // w = 0 within its error, whatever else
    KN_SIDE_ABOVE, // w > 0
    KN_SIDE_BELOW, // w < 0
    KN_SIDE_BOTH,  // of different support positions
    KN_SIDE_UNDECIDED
} kn_side;
// Whether the point is above the base, below it, on it, both, or none of them within [w0,w1]: definitions 1 and 2.
// Places at an edge count as places.
// fails, error, cost: as kn_shell_support. A place that is not certified and would change the answer makes it
// UNDECIDED.
KN_API KN_CHECKED kn_status kn_shell_side(kn_ctx *ctx, kn_side *out, const kn_shell_inverse *inverse,
                                          const double point[3]);

// ---- normals of mapped geometry ----

// A normal of geometry in texture space at uvw, mapped through T: J^-T normal, unit length; J = dT/d(u,v,w). What
// lies on the normal's side of the geometry lies on that side of the image, where det J < 0 as well: triangles and
// patches turn over there (their own normal is then -J^-T normal), and where det J > 0 they do not.
// in:     normal: any length but 0. uvw: T beyond the domain is as in kn_shell_eval.
// out:    may be normal. At a pole, where S is one point along u (or v), the limit from inside: with normal[0] != 0
//         it is that of the surface u = const, whatever the rest.
// fails:  KN_EDOMAIN (not finite, normal 0), KN_EUNDEFINED (J is singular: columns of unit length have a determinant
//         below 1e-12), KN_ENOMEM; out unchanged.
// error:  a relative rounding e of J's columns (kn_shell_eval's bound over their length) turns it by about 4 e /
//         |det|, det that of the columns of unit length.
// cost:   that of kn_shell_eval.
KN_API KN_CHECKED kn_status kn_shell_map_normal(kn_ctx *ctx, double out[3], const kn_shell *shell,
                                                const double uvw[3], const double normal[3]);
// The estimate n_u S_u + n_v S_v + n_w n (equation 4 of the source), unit length; n stands for T_w at w = 0. Good
// where S_u and S_v are nearly orthogonal and as long as n, and w is small, on which it does not depend;
// docs/normals.md says how good.
// fails:  KN_EDOMAIN (not finite), KN_EUNDEFINED (it vanishes), KN_ENOMEM; out unchanged, and may be normal.
KN_API KN_CHECKED kn_status kn_shell_map_normal_estimate(kn_ctx *ctx, double out[3], const kn_shell *shell,
                                                         const double uvw[3], const double normal[3]);

// ---- the Jacobian ----

// Common to the functions of this part: J is that of T as the shell holds it (n fitted, fields exact). An edge of a
// box along which a derivative of S, times the width of the domain, is below 1e-12 of S's size, or what some
// units of rounding of the largest coordinate make, counts as collapsed to a point, and n's and the fields'
// derivatives along it that are as small count as 0: what is certified then is said of the surface with this edge
// collapsed exactly.

// det dT/d(u,v,w) = sum_k J_k(u,v) w^k, or of a volume one J_0(u,v,w).
// out:    *coefficients: *n splines with one component, kn_spline_clear each, kn_free; those of one shell share their
//         degrees and knots. Knots are those of S, n and fields, each degree + 1 times: J may jump there (the
//         derivatives of n and S do). Of a rational T each is the numerator over W^*weight_power, W the weight of S
//         (of the volume): 3, of a volume 4, else 0.
// fails:  KN_ELIMIT (degrees: 2 p + q - 1 and 3 q - 1, p that of S and q the highest of h n and the fields, of a
//         rational S 3 p + 3 q - 1, of a volume 3 p - 1, rational 4 p; powers: 3 attraction_power above 57),
//         KN_ENOMEM, KN_ECANCELLED; outputs unchanged.
// error:  kn_shell_jacobian_piece.error of the box, before factors are divided out.
// cost:   about 100 us for each span of n.
KN_API KN_CHECKED kn_status kn_shell_jacobian(kn_ctx *ctx, kn_spline **coefficients, int *n, int *weight_power,
                                              const kn_shell *shell);

// The boxes on which T is one polynomial or rational piece: between neighbouring knots of S, n and the fields, of a
// volume also in w (boxes[2], else 1).
KN_API void kn_shell_jacobian_grid(const kn_shell *shell, int boxes[3]);
// J over one of them. With x in [0,1]^nvars over [lo,hi]
//     det = f(x) sum_k w^k j_k(x) / d(x),  f = prod_v x_v^order[v][0] (1 - x_v)^order[v][1] >= 0,
// j_k the components of j, bivariate, or of a volume det = f j_0 / d, in three variables. What vanishes at a pole for
// all w is in f, so that j tells whether T folds there.
typedef struct kn_shell_jacobian_piece {
    int cell[2];         // of the shell, in which the box lies
    double lo[3], hi[3]; // in the parameters of T; in w from -INFINITY to INFINITY unless T is a volume
    kn_bezier j;
    double error[KN_MAX_COMPS]; // bound of the error of every coefficient of j_k
    kn_bezier denominator;      // d: one component, j's degrees, positive; empty: 1
    int order[3][2];
    bool flat[3][2]; // j_0 alone vanishes along this edge, where its coefficients are 0 exactly: an apex
} kn_shell_jacobian_piece;
// out:    *out is overwritten, not cleared: kn_shell_jacobian_piece_clear.
// fails:  KN_EDOMAIN (no such box), and as kn_shell_jacobian; out unchanged.
// error:  `error`: of the exact sum of products of the coefficients of S, n and the fields, about 1e-13 of the
//         product of the largest |n|, |S_u| and |S_v|, and so for the other powers (docs/numerics.md, "shell").
KN_API KN_CHECKED kn_status kn_shell_jacobian_piece_init(kn_ctx *ctx, kn_shell_jacobian_piece *out,
                                                         const kn_shell *shell, const int box[3]);
KN_API void kn_shell_jacobian_piece_clear(kn_ctx *ctx, kn_shell_jacobian_piece *piece);

#ifdef __cplusplus
}
#endif
#endif
