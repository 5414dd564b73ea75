// SPDX-License-Identifier: Apache-2.0
// kn_spline: polynomial or rational pieces on a clamped tensor-product knot grid, any number of variables.
#ifndef KNURL_SPLINE_H
#define KNURL_SPLINE_H

#include <knurl/bezier.h>

#ifdef __cplusplus
extern "C" {
#endif

// Variable d has count[d] control points and count[d] + degree[d] + 1 knots, not decreasing, the first and last
// degree[d] + 1 of them equal (clamped), no interior knot more than degree[d] + 1 times. The domain of variable d is
// [knots[d][0], knots[d][last]]. coef: ncomp arrays of prod_d count[d] numbers, components slowest, the last variable
// fastest. rational as in kn_bezier. A zero-initialised kn_spline is a valid empty one.
typedef struct kn_spline {
    int nvars, ncomp;
    bool rational;
    int degree[KN_MAX_VARS];
    int count[KN_MAX_VARS];
    double *knots[KN_MAX_VARS];
    double *coef;
} kn_spline;

// Error bounds below: gamma(n) = n u / (1 - n u), u = 2^-53; p_d the degree in variable d; |a| the spline with the
// absolute values of a's coefficients. Derivations: docs/numerics.md.
//
// Operands are splines that kn_spline_check accepts, or that knurl made; an empty operand is KN_EDOMAIN everywhere
// but in clear, swap, copy and check. Outputs are initialised (possibly empty), overwritten, may be an operand, and
// are unchanged by a call that fails. Every call that makes a spline may fail with KN_ENOMEM, and with KN_ELIMIT
// beyond KN_MAX_COEFS.

// ---- life ----
// *out = a spline with these numbers.
// in:     knots[d]: count[d] + degree[d] + 1 numbers, copied and checked as above. coef: copied as it is;
//         NULL: zeros.
// out:    overwritten, not cleared: for a fresh variable; kn_spline_clear it.
// fails:  KN_EDOMAIN numbers out of range or knots that break a rule (the message says which); KN_ELIMIT.
KN_API KN_CHECKED kn_status kn_spline_init(kn_ctx *ctx, kn_spline *out, int nvars, int ncomp, bool rational,
                                           const int *degree, const int *count, const double *const *knots,
                                           const double *coef);
// Frees the arrays of s, which becomes empty. An empty one is fine.
KN_API void kn_spline_clear(kn_ctx *ctx, kn_spline *s);
KN_API void kn_spline_swap(kn_spline *a, kn_spline *b);
// out: initialised, its old contents freed.
KN_API KN_CHECKED kn_status kn_spline_copy(kn_ctx *ctx, kn_spline *out, const kn_spline *a);
// KN_OK, or KN_EDOMAIN / KN_ELIMIT with a message saying which rule above is broken (also: not finite, weight <= 0).
KN_API KN_CHECKED kn_status kn_spline_check(kn_ctx *ctx, const kn_spline *s);
KN_API size_t kn_spline_count(const kn_spline *s); // control points
KN_API int kn_spline_dim(const kn_spline *s);      // ncomp, less the weight when rational
KN_API void kn_spline_domain(const kn_spline *s, int var, double *lo, double *hi);
// Non-empty knot intervals of variable var.
KN_API int kn_spline_spans(const kn_spline *s, int var);
// The box of the control points (projected when rational): dim numbers each. It contains the whole spline.
// fails:  KN_EDOMAIN a weight that is not positive.
// error:  none: the tightest doubles outside; rational quotients are rounded outwards.
KN_API KN_CHECKED kn_status kn_spline_box(kn_ctx *ctx, double *lo, double *hi, const kn_spline *s);
// A box that contains s over [lo,hi], dim numbers each: that of the coefficients there, rounding included.
// in:     nvars finite numbers lo <= hi each, also beyond the domain, where the end pieces go on.
// fails:  KN_EDOMAIN the box, or a weight whose coefficients there, less their error, are not all positive.
// cost:   twice kn_spline_restrict.
KN_API KN_CHECKED kn_status kn_spline_box_over(kn_ctx *ctx, double *box_lo, double *box_hi, const kn_spline *s,
                                               const double *lo, const double *hi);
// As kn_bezier_oriented_box, for the control points of s.
KN_API KN_CHECKED kn_status kn_spline_oriented_box(kn_ctx *ctx, kn_oriented_box *out, const kn_spline *s);

// ---- values: parameters outside the domain extend the end pieces; at a knot the right-hand piece counts ----
// out = s(at), dim numbers, of a rational spline after division by the weight.
// fails:  KN_EUNDEFINED the weight is zero there. A parameter that is not finite gives a value that is not.
// error:  with E = sum_d (6 p_d + 1): gamma(E) sum |c_k| N_k for each component; rational, weights positive, inside
//         the domain: gamma(2 E + 1) (sum |c_k| N_k) / (sum w_k N_k). Beyond the domain with the absolute values of
//         the recurrence's factors. At the ends of the domain exact.
// cost:   ncomp prod_d (p_d + 1) multiply-adds and sum_d p_d^2 divisions; no allocation.
// source: Cox, de Boor; Piegl & Tiller, The NURBS Book, algorithms A2.1, A2.2.
KN_API KN_CHECKED kn_status kn_spline_eval(kn_ctx *ctx, double *out, const kn_spline *s, const double *at);
// npoints values: out[i*dim + c] at the point at[i*nvars .. i*nvars + nvars-1].
// out:    not an input. Where the weight is zero a value that is not finite, and no failure. The same bits on every
//         machine and for batches cut anyhow; kn_spline_eval sums in another order, so that last bits differ.
// error:  inside the domain, over the control points that act, n = sum_d (17 p_d + 3): polynomial gamma(n) max |c_k|;
//         rational, weights positive, 3 gamma(n + 2) q max |c_k / w_k|, q = max w / min w, gamma(n + 2) q <= 1/4.
// cost:   in vectors where the machine has them; tables of prod_d count[d] * ncomp (up to p + 1 times that for small
//         splines) and sum_d spans * (p_d + 1)^2 numbers of scratch, made only where there are points enough to pay
//         for them.
KN_API KN_CHECKED kn_status kn_spline_eval_batch(kn_ctx *ctx, double *out, const kn_spline *s, size_t npoints,
                                                 const double *at);
// Values and all first partials at npoints points: out[(i*(1 + nvars) + k)*dim + c], k = 0 the value, k = 1 + d the
// derivative in variable d.
// out:    the values have kn_spline_eval_batch's bits; all else as there.
// error:  a partial in variable d, polynomial, inside the domain: gamma(n) (2 p_d / h) max |c_k|, n = sum_e (17 p_e
//         + 3), h the length of the knot interval, over the control points that act. rational, weights positive:
//         12 gamma(n + 4) q^2 (2 p_d / h) max |P_k|, q = max w / min w, P_k = c_k / w_k; gamma(n + 2) q <= 1/4.
// cost:   about twice kn_spline_eval_batch.
KN_API KN_CHECKED kn_status kn_spline_eval_batch_partials(kn_ctx *ctx, double *out, const kn_spline *s,
                                                          size_t npoints, const double *at);
// Values on the grid at[0] x at[1] x .., n[d] parameters in variable d: out[i*dim + c], i the place in the grid, the
// last variable fastest.
// out:    as kn_spline_eval_batch; the sums go in another order, so that last bits differ, but for one variable.
// error:  as kn_spline_eval_batch.
// cost:   (p_0 + 1) ncomp multiply-adds a point, and less for the other variables where the grid is large; scratch:
//         the control points, the basis of all parameters, and rows of about 640 numbers for each control point of
//         the variables before the last.
KN_API KN_CHECKED kn_status kn_spline_eval_grid(kn_ctx *ctx, double *out, const kn_spline *s, const size_t *n,
                                                const double *const *at);
// All partial derivatives of total order <= order.
// out:    kn_derivative_count(nvars, order) values of dim components each, in the order of kn_derivative_index.
// fails:  KN_EDOMAIN order < 0; KN_ELIMIT order > KN_MAX_DEGREE or too many; KN_EUNDEFINED the weight is zero.
// error:  polynomial: gamma(E - order), E as for kn_spline_eval, order that of the derivative at hand, times the same
//         sum with differences taken as sums of absolute values. rational: as kn_bezier_derivatives.
// cost:   count(nvars, order) values of kn_spline_eval at most.
KN_API KN_CHECKED kn_status kn_spline_derivatives(kn_ctx *ctx, double *out, const kn_spline *s, const double *at,
                                                  int order);

// ---- algebra ----
// Operations on two or three splines act on the intersection of their domains, to which the operands are restricted
// exactly; KN_EDOMAIN when it has no interior, when variables differ, or an operand is empty. Knots of the operands
// are one knot where they are equal bit for bit. A polynomial beside a rational operand has the weight 1. KN_ELIMIT
// when a degree of the result passes KN_MAX_DEGREE or its components KN_MAX_COMPS. Nothing is allocated when out has
// the result's numbers of knots and coefficients.

// out = a + b and out = a - b, of equal dimension (else KN_EDOMAIN).
// out:    polynomial, or with the same weights on the same knots: the higher degree in each variable, and each knot
//         as often as the continuity of the rougher operand asks. Otherwise over the product of the weights, with
//         degrees and knots as for a product.
// error:  polynomial: gamma(1 + e_a)|a|_k + gamma(1 + e_b)|b|_k, e_a, e_b the roundings of restriction, elevation and
//         knot insertion, |a| and |b| restricted, elevated and refined too. Otherwise as a product.
KN_API KN_CHECKED kn_status kn_spline_sum(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
KN_API KN_CHECKED kn_status kn_spline_difference(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
// out = factor a: knots and weight stay. error: gamma(1)|c_k|.
KN_API KN_CHECKED kn_status kn_spline_scale(kn_ctx *ctx, kn_spline *out, const kn_spline *a, double factor);
// out = a * b, component by component; an operand of dimension 1 multiplies every component. Weights multiply.
// out:    degrees p + q; a knot that a has m times (0: not at all) and b has n times stays
//         p + q - min(p - m, q - n) times, the least that the product's continuity allows (a missing knot: no limit).
// fails:  KN_EDOMAIN dimensions differ and neither is 1.
// error:  gamma(L + 3 nvars + sum_d (6 (u_d + v_d + x_d) + 3)) S_k, L as for kn_bezier_product. c_k is taken from one
//         piece (kn_spline_from_bezier): u_d <= p_d and v_d <= q_d knots are new for a coefficient of a's and b's
//         piece there, x_d arguments of c_k are no ends of it (6 y + 1 is 0 for y = 0). S_k: |a| * |b| on that piece,
//         its Bernstein coefficients weighted by the blossom's factors in absolute value, at most J max |a| max |b|,
//         J the growth on the way back to few knots.
// cost:   for each box of the merged knots that of kn_bezier_product; one banded map an axis to the pieces of each
//         operand and back from those of the result, all in scratch.
// source: by Bezier pieces; the knots: Morken, Some identities for products and degree raising of splines, Constr.
//         Approx. 7 (1991).
KN_API KN_CHECKED kn_status kn_spline_product(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
// out = sum_c a_c b_c, of dimension 1, for equal dimensions (else KN_EDOMAIN). All else as for a product.
KN_API KN_CHECKED kn_status kn_spline_dot(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
// out = a x b, both of dimension 3 (else KN_EDOMAIN). All else as for a product.
KN_API KN_CHECKED kn_status kn_spline_cross(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
// out = det(a, b, c) = a . (b x c), of dimension 1; all three of dimension 3 (else KN_EDOMAIN). Weights multiply.
// out:    degrees p + q + r; knots by the roughest operand at each, as for a product.
// error:  gamma(L + L' + 4 nvars + sum_d (6 (u_d + v_d + w_d + x_d) + 4)) S_k, L and L' as for
//         kn_bezier_determinant, all else as for a product: S_k from the six |a_i| * |b_j| * |c_k|.
KN_API KN_CHECKED kn_status kn_spline_determinant(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b,
                                                  const kn_spline *c);
// out = the partial derivative of a in variable var.
// out:    polynomial: one degree less in var (0 stays 0, and the coefficients become 0), every knot as often as
//         before but at most degree + 1 times. rational: over the square of the weight, all degrees double.
// fails:  KN_EDOMAIN var.
// error:  polynomial: gamma(4)|c_k|: p (c_i+1 - c_i) / (t_i+p+1 - t_i+1), differences first.
KN_API KN_CHECKED kn_status kn_spline_derivative(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var);
// out = a with degree[d] in variable d; each knot as much more often as the degree rises.
// fails:  KN_EDOMAIN a degree below a's; KN_ELIMIT.
// error:  convex combinations: for each variable and each step from p to p + 1 gamma(6 V + 2 D) |a|_k, |a| elevated
//         too: D knots are different among the p + 1 of the elevated vector between which the coefficient lies, and
//         V have all their copies among them, one less if all have; of all coefficients the largest such number.
// cost:   prod count * (p + 1) multiply-adds a variable, whatever the rise, and for each coefficient of a variable
//         and step D blossoms of the V knots that are not a's.
// source: by blossoms (Ramshaw, Blossoms are polar forms, CAGD 6, 1989); Prautzsch, CAGD 1 (1984).
KN_API KN_CHECKED kn_status kn_spline_elevate(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const int *degree);

// The least degrees that represent a within tolerance, variable by variable.
// in:     tolerance >= 0. 0: elevation of the reduced spline gives a's knots and coefficients again, bit for bit.
// out:    nvars numbers: degree[d] with those of the variables before it lowered already, so that kn_spline_reduce to
//         all of them has an error <= tolerance where tolerance > 0. Unchanged on failure.
// fails:  KN_EDOMAIN tolerance.
// cost:   a reduction and, for tolerance > 0, its bound for each degree that is tried.
KN_API KN_CHECKED kn_status kn_spline_least_degree(kn_ctx *ctx, int *degree, const kn_spline *a, double tolerance);
// out = a with lower degrees.
// in:     0 <= degree[d] <= a's.
// out:    a break of multiplicity m keeps max(m - fall of the degree, 1) knots: the continuity stays. Lines of
//         coefficients that are of the lower degree, but for rounding, are taken back, by the pieces: an elevation is
//         undone. Others become the nearest in the sense of least squares of the coefficients on the knots of the
//         elevated result, with both ends of the domain kept bit for bit (in a variable that keeps a degree >= 1).
//         *error >= |out - a| (Euclidean norm of values) over the domain, rounding included; INFINITY when a
//         coefficient is not finite, or a weight of a or out not positive. NULL: not wanted.
// fails:  KN_EDOMAIN degree; KN_ELIMIT the grid on which both are compared.
// error:  *error as for kn_bezier_reduce, over all pieces of the difference.
// cost:   least squares: prod count * degree^2 multiply-adds a variable; the bound: all pieces of the difference.
// source: as kn_bezier_reduce; banded least squares by Givens rotations.
KN_API KN_CHECKED kn_status kn_spline_reduce(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *a,
                                             const int *degree);
// out_r = sum_c matrix[r * dim(a) + c] a_c + offset[r] for r < dim; offset NULL: zeros. All else as kn_bezier_affine.
KN_API KN_CHECKED kn_status kn_spline_affine(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int dim,
                                             const double *matrix, const double *offset);
// Components first .. first+count-1 as a polynomial spline (of a rational one: homogeneous components), exactly.
// fails:  KN_EDOMAIN they are not all among the ncomp components, or count < 1.
KN_API KN_CHECKED kn_status kn_spline_components(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int first,
                                                 int count);
// out = the antiderivative of a in variable var that is zero at the domain's start.
// out:    one degree more in var, every interior knot as often as before: one continuity more, jumps become kinks.
// fails:  KN_EDOMAIN var, or a rational; KN_ELIMIT.
// error:  gamma(k + 2) sum_(i<k) |c_i| (t_i+p+1 - t_i) / (p + 1) for coefficient k along var; exact where all is.
// source: de Boor, A Practical Guide to Splines, chapter X.
KN_API KN_CHECKED kn_status kn_spline_antiderivative(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var);
// out = the integral of a over its domain, dim numbers.
// fails:  KN_EDOMAIN a rational.
// error:  gamma(sum_d (count[d] + 2) + 1) sum_k |c_k| prod_d (t_k+p+1 - t_k) / (p_d + 1); exact where all is.
// cost:   a multiply-add a coefficient.
KN_API KN_CHECKED kn_status kn_spline_integral(kn_ctx *ctx, double *out, const kn_spline *a);
// All first partials in one spline: component c * nvars + d is the derivative of a_c in variable d.
// out:    polynomial: a's degrees, interior knots of every variable once more often, at most degree + 1 times: the
//         grid that holds all partials. rational: over the square of the weight, degrees double, continuity one less.
// fails:  KN_ELIMIT dim * nvars components (and a weight) pass KN_MAX_COMPS, doubled degrees, coefficients.
// error:  polynomial, of the derivative in variable v: gamma(7 p_v + sum_(d != v) (6 u_d + 1)) |a_v|_k, |a_v| what
//         kn_spline_derivative gives, coefficients in absolute value, on out's degrees and knots; u_d <= p_d knots
//         are new for c_k, of all coefficients the most. rational: as kn_spline_derivative.
KN_API KN_CHECKED kn_status kn_spline_gradient(kn_ctx *ctx, kn_spline *out, const kn_spline *a);
// out = sum_d of the derivative of a_d in variable d, of dimension 1. Degrees and knots as kn_spline_gradient.
// fails:  KN_EDOMAIN dim is not nvars; KN_ELIMIT as said.
// error:  with n the most roundings of a partial in it, gamma(n + nvars - 1) times the sum of the |a_d|_k.
KN_API KN_CHECKED kn_status kn_spline_divergence(kn_ctx *ctx, kn_spline *out, const kn_spline *a);
// out[d] >= |derivative of a in variable d| (Euclidean norm) over the domain: nvars numbers. At knots both sides
// count; the height of a jump does not.
// fails:  and source as kn_bezier_lipschitz.
// cost:   as kn_spline_derivative; rational: two products for each piece.
KN_API KN_CHECKED kn_status kn_spline_lipschitz(kn_ctx *ctx, double *out, const kn_spline *a);

// ---- pieces ----
// out = a with fewer knots in variable var.
// in:     tolerance >= 0; INFINITY is one.
// out:    first all knots go whose removal is exact in exact arithmetic with numbers that doubles hold: what exact
//         insertion put there, leaving the bits that were there before it. Then, for tolerance > 0, the cheapest ones
//         in turn, each moving as few coefficients as little as possible. *error >= |out - a| (Euclidean norm of
//         values) over the domain, rounding included, and *error <= tolerance; 0 when no more than the exact ones
//         went. NULL: not wanted. The ends of the domain stay bit for bit.
// fails:  KN_EDOMAIN var, tolerance, or tolerance > 0 and a weight that is not positive.
// error:  *error: the largest distance of coefficients on a's knots, projected when rational, plus gamma(6 p + 3) of
//         the largest.
// cost:   rounds of prod count * (p + 1) multiply-adds each, about (2 p + 3) log n of them.
// source: Tiller, Knot-removal algorithms for NURBS curves and surfaces, CAD 24 (1992); Lyche & Morken, Knot removal
//         for parametric B-spline curves and surfaces, CAGD 4 (1987).
KN_API KN_CHECKED kn_status kn_spline_remove_knots(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *a,
                                                   int var, double tolerance);
// out = a on a grid that contains, in every variable d, the n[d] knots (each as often as it is listed, or as a
// has it).
// in:     any order; knots at the ends of the domain are allowed and change nothing, so that the knots of another
//         spline of the same degrees will do.
// fails:  KN_EDOMAIN n[d] < 0, a knot outside the domain, or listed more than degree + 1 times; KN_ELIMIT.
// error:  and cost as kn_spline_insert_knots, in each variable.
KN_API KN_CHECKED kn_status kn_spline_refine(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const int *n,
                                             const double *const *knots);
// Brings n splines over one domain, in place, to the same degrees and knots; values are unchanged.
// in:     list[0 .. n-1]: the same variables; dimensions and weights may differ. n 0 and 1: nothing happens.
// out:    in each variable the highest degree, and each knot as often as the roughest of them needs. A spline that
//         has them already is not touched. All of the list is unchanged on failure.
// fails:  KN_EDOMAIN n < 0, an empty one, other variables or domains (bit for bit); KN_ELIMIT.
// error:  and cost of elevation and knot insertion: all convex combinations.
KN_API KN_CHECKED kn_status kn_spline_make_compatible(kn_ctx *ctx, kn_spline *list, int n);
// One spline of a and b, where a ends in var b begins: with the continuity they have there within tolerance.
// in:     the same variables, dimension and domains (bit for bit) but for var, where b's begins at the end of a's.
//         A polynomial beside a rational one has the weight 1; homogeneous coordinates are compared.
// out:    degrees and cross knots made compatible (convex combinations, with their rounding, where they differ). The
//         common break has degree + 1 knots less those that kn_spline_remove_knots can remove there within tolerance:
//         with 0 those whose removal is exact, and ends that agree bit for bit are joined. Ends that are too far
//         apart stay apart: a jump. *error as there: of the joining. NULL: not wanted.
// fails:  KN_EDOMAIN var, domains, dimensions, tolerance, or tolerance > 0 and a weight that is not positive;
//         KN_ELIMIT.
// cost:   as elevation, refinement and removal.
KN_API KN_CHECKED kn_status kn_spline_merge(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *a,
                                            const kn_spline *b, int var, double tolerance);
// The same values over [lo,hi] in variable var: out(.., lo + x (hi - lo), ..) = a(.., a_lo + x (a_hi - a_lo), ..).
// out:    coefficients stay bit for bit; lo and hi are its domain exactly, and equal knots stay equal.
// fails:  KN_EDOMAIN var, not lo < hi, not finite, or two different knots would become one.
// error:  each knot is the exact one, computed to twice the precision and rounded once.
KN_API KN_CHECKED kn_status kn_spline_reparameterize(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var,
                                                     double lo, double hi);
// out(.., x_var, ..) = a(.., lo + hi - x_var, ..) over the same domain [lo,hi] of var.
// out:    coefficients bit for bit; knots lo + (hi - t) with two roundings, none in [0,1] beyond that of 1 - t.
// fails:  KN_EDOMAIN var, or rounded knots that fall together beyond their multiplicity.
KN_API KN_CHECKED kn_status kn_spline_reverse(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var);
// Variable d of out is variable order[d] of a, a permutation (else KN_EDOMAIN); bit for bit.
KN_API KN_CHECKED kn_status kn_spline_permute(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const int *order);
// The curve, surface, .. of one variable less at x_var = at.
// in:     any real `at`: beyond the domain the end pieces are extended, at a knot the right-hand piece counts.
// out:    the other variables' degrees and knots, bit for bit. At the ends of the domain a's own coefficients.
// fails:  KN_EDOMAIN var, or a of one variable (a point: kn_spline_eval).
// error:  gamma(6 p + 1) sum_k N_k |c_k| for each coefficient, inside the domain a convex combination; beyond it with
//         the absolute values of the recurrence's factors.
// cost:   ncomp prod count / count[var] * (p + 1) multiply-adds.
KN_API KN_CHECKED kn_status kn_spline_isoparametric(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var,
                                                    double at);
// Inserts n knots (any order, repeated for multiplicity) into variable var; the function is unchanged.
// fails:  KN_EDOMAIN var, n < 0, a knot that is not inside the domain, or more than degree + 1 equal ones.
// error:  convex combinations without any cancellation: gamma(6 v + 1) sum_k w_ik |c_k|, v <= p the new knots among
//         the p between which the coefficient lies. Coefficients that no new knot concerns stay bit for bit.
// cost:   ncomp prod count * (v + 1) multiply-adds, and v (v + 1) for each coefficient of that variable; nothing is
//         allocated when out has the right size.
// source: the Oslo algorithm, by blossoms; Lyche & Morken, Making the Oslo algorithm more efficient, SINUM 23 (1986).
KN_API KN_CHECKED kn_status kn_spline_insert_knots(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var,
                                                   const double *knots, int n);
// left and right of `at` in variable var, each over its part of the domain.
// out:    two different splines; one of them may be a.
// fails:  KN_EDOMAIN var, or `at` not inside the domain. error, cost: as knot insertion.
KN_API KN_CHECKED kn_status kn_spline_subdivide(kn_ctx *ctx, kn_spline *left, kn_spline *right, const kn_spline *a,
                                                int var, double at);
// out = a over the sub-box [lo,hi]; a box beyond the domain extends the end pieces.
// out:    its domain is the box, and its knots inside it are those of a.
// fails:  KN_EDOMAIN not lo < hi, not finite.
// error:  inside the domain as knot insertion; beyond it with the absolute values of the recurrence's factors.
KN_API KN_CHECKED kn_status kn_spline_restrict(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const double *lo,
                                               const double *hi);
// The Bezier pieces, one for each box of non-empty knot intervals.
// out:    *pieces is an array of *npieces, the last variable fastest, to be cleared one by one and freed with
//         kn_free. Neighbours share their common coefficients bit for bit (where the spline is continuous).
// error:  as knot insertion in each variable.
KN_API KN_CHECKED kn_status kn_spline_to_bezier(kn_ctx *ctx, kn_bezier **pieces, size_t *npieces, const kn_spline *a);
// The way back: pieces of one shape on the grid of breaks[d][0 .. nbreaks[d]-1] (increasing), last variable fastest,
// that agree to order continuity[d] (-1 .. degree-1) at every interior break of variable d; the knots there get
// multiplicity degree - continuity.
// out:    a coefficient is the blossom of one piece at degree neighbouring knots, of all pieces in its support the
//         one whose weights have the smallest sum of absolute values, the lowest of equals; that the others agree is
//         not checked. Coefficients that one piece has already are copied bit for bit.
// fails:  KN_EDOMAIN shapes differ, breaks, continuity; KN_ELIMIT.
// error:  in each variable gamma(6 p + 1) J max |c|, J with the factors' absolute values, and errors of the pieces
//         grow by J, the largest such sum. On equal spans J = 1 at continuity 0 and for C1 quadratics, 3 for C2 cubics,
//         9 and 45 for quartics and quintics of the highest continuity; it grows with uneven spans.
KN_API KN_CHECKED kn_status kn_spline_from_bezier(kn_ctx *ctx, kn_spline *out, const kn_bezier *pieces,
                                                  const int *nbreaks, const double *const *breaks,
                                                  const int *continuity);
// The piece as a spline over [0,1]^nvars, exactly; an empty one gives an empty one. fails: KN_EDOMAIN nvars 0.
KN_API KN_CHECKED kn_status kn_spline_of_bezier(kn_ctx *ctx, kn_spline *out, const kn_bezier *a);

#ifdef __cplusplus
}
#endif
#endif
