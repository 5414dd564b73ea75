// SPDX-License-Identifier: Apache-2.0
// Exact composition of a patch with a shell: symbolically, and as a matrix that all cells share.
#ifndef KNURL_COMPOSE_H
#define KNURL_COMPOSE_H

#include <knurl/shell.h>

#ifdef __cplusplus
extern "C" {
#endif

// out(x) = outer(inner(x)), by products of polynomials alone, exact but for rounding.
// in:     outer with nvars >= 1; inner with as many value components, any nvars: a point (0), a curve, a surface, a
//         volume in anything; each polynomial or rational.
// out:    initialised, overwritten, may be an operand; rational if either operand is.
//         out.degree[d] = inner.degree[d] * sum of outer's degrees.
// fails:  KN_EDOMAIN shapes, KN_ELIMIT degree > KN_MAX_DEGREE, KN_ENOMEM; out unchanged.
// error:  gamma(P (T + n + 3) + K + N + n + 1) times the same expression in absolute values, |x| and |w - x| of
//         inner's coefficients and |c| of outer's (relative, where inner lies in the unit cell and outer is
//         positive). P the sum of outer's degrees, N and n the variables of outer and inner, T = prod
//         (inner.degree[d] + 1), K the product of the two largest (outer.degree[d] + 1). Measured: at most 11 u up to
//         degree 56. Small integers give the doubles nearest to the exact coefficients.
// cost:   about ncomp prod_(all but two variables) (p + 1) * p log2 p * T * count(out) / 3 multiply-adds, the two
//         being chosen (docs/composition.md); no allocation when out has the right size and scratch has grown.
// source: Elber, Geometric Texture Modeling, sidebar on composition; DeRose, Goldman, Hagen & Mann, Functional
//         composition algorithms via blossoming, ACM TOG 12 (1993); the nest: docs/composition.md.
KN_API KN_CHECKED kn_status kn_bezier_compose(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer,
                                              const kn_bezier *inner);

// out(x) = outer(inner(x)) for splines. inner is split where it crosses knots of outer along parameter lines: where
// a component (of a rational inner: a quotient) depends on one of inner's variables alone, up and down as often as it
// likes. Everywhere else each piece of inner has to lie inside one piece of outer.
// in:     as for kn_bezier_compose; weights of inner positive. Beyond outer's domain its end pieces are extended, as
//         kn_spline_eval does.
// out:    may be an operand. Knots: inner's, and where inner crosses knots of outer. At a knot of inner the
//         continuity of inner is kept; at a crossing that of outer at the knot that is crossed; where both meet, the
//         smaller one. Crossings nearer than 2^-44 of the domain's length and 2^-51 of its largest parameter to each
//         other, or to a knot of inner, become one. Where inner's values, but not its control points, lie inside a
//         piece of outer, control points of the result may lie outside outer's, and weights may be negative.
// fails:  KN_EDOMAIN shapes, or a component that crosses a knot of outer in another way (the message names both);
//         KN_EUNDECIDED whether it does (it touches the knot along a curve); KN_ELIMIT degree > KN_MAX_DEGREE;
//         KN_ENOMEM; out unchanged. Less than 2^-40 of the component's size beyond a knot does not count.
// error:  for each piece as kn_bezier_compose, on the pieces of both operands (knot insertion, gamma(6 p + 1) each);
//         a crossing is a root of the piece's own Bernstein form, to neighbouring doubles; then J for the way to few
//         knots (kn_spline_from_bezier).
// cost:   that of the pieces.
KN_API KN_CHECKED kn_status kn_spline_compose(kn_ctx *ctx, kn_spline *out, const kn_spline *outer,
                                              const kn_spline *inner);
// out(.., t, ..) = a(.., g(t), ..): variable var replaced by a univariate function of one component, polynomial or
// rational, not necessarily monotone: a reparameterization.
// out:    may be an operand; degree[var] = a.degree[var] * g.degree[0]; rational if either operand is.
// fails:  KN_EDOMAIN var, g's shape; KN_ELIMIT degree > KN_MAX_DEGREE; KN_ENOMEM; out unchanged.
// error:  as kn_bezier_compose of a curve with g (n = N = 1), and gamma(p + 1) for the sum over a's coefficients.
// cost:   ncomp count(a) (p m + 1) multiply-adds and a composition of univariate functions; no allocation when out
//         has the right size.
KN_API KN_CHECKED kn_status kn_bezier_substitute(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var,
                                                 const kn_bezier *g);
// The same for splines: out's domain in variable var is that of g; a's knots there become knots where g crosses them,
// with continuity and exceptions as in kn_spline_compose. The other variables keep knots and degrees.
KN_API KN_CHECKED kn_status kn_spline_substitute(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var,
                                                 const kn_spline *g);

// Sensitivities of f = outer(inner) = (sum_i c_i B_i)(inner).
// d f / d c_i, i = index (outer.nvars numbers): B_i(inner(x)), the same for every component, of dimension 1. Of a
// rational outer c_i is a homogeneous coordinate: B_i(inner) / W(inner); the derivative by the weight of that control
// point is -f times that.
// out:    may be outer or inner. fails, error: as kn_bezier_compose; KN_EDOMAIN also for an index out of range.
// cost:   as kn_bezier_compose with one component.
KN_API KN_CHECKED kn_status kn_bezier_compose_outer_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer,
                                                                const kn_bezier *inner, const int *index);
// d f / d X_(comp,q), q = index (inner.nvars numbers), of outer's dimension: (d_comp outer)(inner) B_q. Of a rational
// inner X is a homogeneous coordinate: the same over w; comp = kn_bezier_dim(inner) is the weight:
// -sum_d x_d (d_d outer)(inner) B_q / w.
// out:    may be outer or inner. Rational when outer or inner is; degrees as they come from derivative, composition
//         and product.
// fails:  KN_EDOMAIN shapes, comp, index; KN_ELIMIT degree > KN_MAX_DEGREE (the derivative of a rational outer has
//         twice its degrees); KN_ENOMEM; out unchanged.
// error:  kn_bezier_derivative, kn_bezier_compose and kn_bezier_product, one after the other.
KN_API KN_CHECKED kn_status kn_bezier_compose_inner_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer,
                                                                const kn_bezier *inner, int comp, const int *index);

// out = T(D(r,t)) by symbolic composition of each term of the piece, sum_k term[k](u,v) w^power[k]: the reference for
// the matrix below.
// in:     tile: D, any number of variables, three polynomial components (u, v, w), u and v in box coordinates, w in
//         length units.
// out:    initialised, overwritten, may be tile; rational if term[0] is.
//         out.degree[d] = tile.degree[d] * max over k of (term[k]'s degrees summed, + power[k]).
// fails:  KN_EDOMAIN shapes, a negative power, KN_ELIMIT degree > KN_MAX_DEGREE, KN_ENOMEM; out unchanged.
// error:  as kn_bezier_compose.
KN_API KN_CHECKED kn_status kn_compose_piece(kn_ctx *ctx, kn_bezier *out, const kn_shell_piece *piece,
                                             const kn_bezier *tile);

// The matrix of one tile patch for one pair of degrees: row q, column a*(degree_v+1)+b holds Bernstein coefficient q
// of B_a(u(x)) B_b(v(x)) w(x)^power in degrees rows_degree. It depends on the tile alone: M times the control points
// of term[power] of any cell gives what that term contributes to the composed patch.
// in:     tile: a curve, surface or volume of components (u, v, w), polynomial; rows_degree, tile.nvars of them:
//         rows_degree[d] >= u_d degree[0] + v_d degree[1] + w_d power, where u_d is the least degree in variable d
//         within which u is but for rounding (2^-48 of a cell, of w of its size; kn_bezier_least_degree), so v_d and
//         w_d. most: degrees in each variable beyond which u, v and w are not taken, for the rest is known to be
//         rounding: those of a patch of which the tile is a part, or which it is mapped from; NULL: as found.
// out:    overwritten; ended by kn_compose_matrix_clear. In the unit cell with power 0: m >= 0, rows sum to 1. Rows
//         on a face, an edge or a corner depend on that alone, bit for bit the same in every patch that has it.
// fails:  KN_EDOMAIN shapes, degrees, KN_ELIMIT degree > KN_MAX_DEGREE, KN_ENOMEM; out unchanged.
// error:  docs/numerics.md, compose. cost: cols products of polynomials.
typedef struct kn_compose_matrix {
    int rows_degree[3];
    size_t rows, cols;
    double *m; // column by column: element (q, j) is m[j * rows + q]; owned
} kn_compose_matrix;
KN_API KN_CHECKED kn_status kn_compose_matrix_init(kn_ctx *ctx, kn_compose_matrix *out, const kn_bezier *tile,
                                                   const int degree[2], int power, const int *rows_degree,
                                                   const int (*most)[3]);
KN_API void kn_compose_matrix_clear(kn_ctx *ctx, kn_compose_matrix *matrix);

#ifdef __cplusplus
}
#endif
#endif
