// SPDX-License-Identifier: Apache-2.0
// kn_bezier: one polynomial or rational piece in Bernstein form over [0,1]^nvars, any number of variables.
#ifndef KNURL_BEZIER_H
#define KNURL_BEZIER_H

#include <knurl/base.h>

#ifdef __cplusplus
extern "C" {
#endif

// coef holds ncomp arrays of prod_d (degree[d] + 1) numbers: components slowest, the last variable fastest.
// rational: homogeneous coordinates; the last of the ncomp components is the weight, the others are already
// multiplied by it. A zero-initialised kn_bezier is a valid empty one (nvars 0, coef NULL).
// coef belongs to the kn_bezier: kn_bezier_clear with the context (or allocator) that filled it.
typedef struct kn_bezier {
    int nvars, ncomp;
    bool rational;
    int degree[KN_MAX_VARS];
    double *coef;
} kn_bezier;

// Common to all below:
// in:     operands have coefficients (else KN_EDOMAIN) and shapes that kn_bezier_init would accept (else its
//         failures). NaN and infinite coefficients pass through as IEEE arithmetic has them; nothing checks for them.
// out:    a piece named out is initialised (empty will do), is overwritten, and may be an operand. On failure it is
//         unchanged, and so are arrays of numbers, unless a comment says otherwise.
// fails:  KN_ENOMEM; KN_EDOMAIN and KN_ELIMIT as said; always with a message in the context.
// error:  gamma(n) = n u / (1 - n u), u = 2^-53; docs/numerics.md derives each bound. |a| is the piece whose
//         coefficients are the absolute values of a's; B_i are the Bernstein polynomials at the point, non-negative
//         in [0,1] (outside, read |t| for t and |1 - t| for 1 - t). L = min(T, 20 + M (r + c + 40)) are the roundings
//         of a sum of T products of coefficients of two pieces, one term after the other or in blocks: r and c the
//         lesser numbers of coefficients of the two along the last two variables (1 for none), M the product of those
//         along the others and of the number of products of pieces that are summed.

// ---- life ----
// *out = a piece with these shapes and all coefficients zero. out is overwritten, not cleared: for a fresh variable.
// in:     nvars degrees. nvars 0 is a constant. rational: ncomp >= 2, the weight included.
// fails:  KN_EDOMAIN nvars or a degree < 0, ncomp < 1; KN_ELIMIT KN_MAX_VARS, _COMPS, _DEGREE or _COEFS passed.
KN_API KN_CHECKED kn_status kn_bezier_init(kn_ctx *ctx, kn_bezier *out, int nvars, int ncomp, bool rational,
                                           const int *degree);
// Frees the coefficients and leaves an empty piece. NULL and an empty piece are fine.
KN_API void kn_bezier_clear(kn_ctx *ctx, kn_bezier *b);
KN_API void kn_bezier_swap(kn_bezier *a, kn_bezier *b);
// out = a, bit for bit; an empty a makes out empty.
KN_API KN_CHECKED kn_status kn_bezier_copy(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a);
// Coefficients of one component: prod_d (degree[d] + 1).
KN_API size_t kn_bezier_count(const kn_bezier *b);
// Components of a value: ncomp, less the weight when rational.
KN_API int kn_bezier_dim(const kn_bezier *b);

// ---- values ----
// out = b(at), of a rational piece after division by the weight.
// in:     nvars parameters, any real numbers.
// out:    kn_bezier_dim(b) numbers.
// fails:  KN_EUNDEFINED the weight is zero there.
// error:  with E = sum_d (4 degree[d] + 1): gamma(E) sum |p_i| B_i for each component; rational with positive
//         weights and at in [0,1]^nvars: gamma(2 E + 1) (sum |p_i| B_i) / (sum w_i B_i). Corners of a polynomial
//         piece give their coefficient exactly.
// cost:   ncomp * count multiply-adds and sum_d degree[d]^2 for the Bernstein polynomials.
KN_API KN_CHECKED kn_status kn_bezier_eval(kn_ctx *ctx, double *out, const kn_bezier *b, const double *at);
// npoints values: out[i*dim + c] at the point at[i*nvars .. i*nvars + nvars-1].
// out:    not an input. Where the weight is zero a value that is not finite, and no failure. The same bits on every
//         machine and for batches cut anyhow; kn_bezier_eval sums in another order, so that last bits differ.
// error:  at in [0,1]^nvars, n = sum_d (3 degree[d] + 2): polynomial gamma(n) max |p_i|; rational, weights positive,
//         3 gamma(n + 2) q max |p_i / w_i|, q = max w / min w, where gamma(n + 2) q <= 1/4.
// cost:   as kn_bezier_eval without its set-up, in vectors where the machine has them; count * ncomp numbers of
//         scratch at least.
KN_API KN_CHECKED kn_status kn_bezier_eval_batch(kn_ctx *ctx, double *out, const kn_bezier *b, size_t npoints,
                                                 const double *at);
// Values and all first partials at npoints points: out[(i*(1 + nvars) + k)*dim + c], k = 0 the value, k = 1 + d the
// derivative in variable d.
// out:    the values have kn_bezier_eval_batch's bits; all else as there.
// error:  a partial in variable d, in [0,1]^nvars, n as for kn_bezier_eval_batch: polynomial gamma(n) 2 degree[d]
//         max |p_i|; rational, weights positive, 12 gamma(n + 4) q^2 2 degree[d] max |p_i / w_i|.
// cost:   about twice kn_bezier_eval_batch.
KN_API KN_CHECKED kn_status kn_bezier_eval_batch_partials(kn_ctx *ctx, double *out, const kn_bezier *b,
                                                          size_t npoints, const double *at);
// Values on the grid at[0] x at[1] x .., n[d] parameters in variable d: out[i*dim + c], i the place in the grid, the
// last variable fastest.
// out:    as kn_bezier_eval_batch; the sums go in another order, so that last bits differ, but for one variable.
// error:  as kn_bezier_eval_batch.
// cost:   (degree[0] + 1) ncomp multiply-adds a point, and less for the other variables where the grid is large;
//         scratch: the coefficients, the basis of all parameters, and rows of about 640 numbers for each coefficient
//         of the variables before the last.
KN_API KN_CHECKED kn_status kn_bezier_eval_grid(kn_ctx *ctx, double *out, const kn_bezier *b, const size_t *n,
                                                const double *const *at);
// All partial derivatives of total order <= order.
// out:    kn_derivative_count(nvars, order) values of dim components each, in the order of kn_derivative_index.
// fails:  KN_EDOMAIN order < 0; KN_ELIMIT order > KN_MAX_DEGREE or too many; KN_EUNDEFINED the weight is zero.
// error:  polynomial: gamma(E), E as for kn_bezier_eval, times the same sum with differences taken as sums of
//         absolute values. rational: see docs/numerics.md.
// cost:   about count(nvars, order) * ncomp * count multiply-adds at most.
// source: Piegl & Tiller, The NURBS Book, section 4.3, here in any number of variables.
KN_API KN_CHECKED kn_status kn_bezier_derivatives(kn_ctx *ctx, double *out, const kn_bezier *b, const double *at,
                                                  int order);
// The number of multi-indices a over nvars variables with |a| <= order: C(nvars + order, order); 0 if it overflows
// int, and for negative arguments.
KN_API int kn_derivative_count(int nvars, int order);
// The place of the multi-index a: by total order, then lexicographically with the first variable slowest and
// highest first: for two variables f, f_u, f_v, f_uu, f_uv, f_vv, ...
KN_API int kn_derivative_index(int nvars, const int *a);

// ---- algebra ----
// Operands have the same variables (else KN_EDOMAIN); one polynomial and one rational operand give a rational result,
// as if the polynomial had the weight 1. KN_ELIMIT when a degree of the result passes KN_MAX_DEGREE, its components
// KN_MAX_COMPS or its coefficients KN_MAX_COEFS.

// out = a + b and out = a - b: values of equal dimension.
// out:    polynomial, or with equal weights (the same degrees, bit for bit the same coefficients): the higher degree
//         in each variable and that weight. Otherwise (a wb + b wa) / (wa wb): the degrees add up.
// error:  polynomial or equal weights: gamma(1 + e_a)|a|_k + gamma(1 + e_b)|b|_k, e_a and e_b the roundings
//         of kn_bezier_elevate. Otherwise
//         gamma(L + 3 nvars)(|a| * |wb| + |b| * |wa|)_k, T terms in the sum.
// cost:   the elevation, or two products a component.
KN_API KN_CHECKED kn_status kn_bezier_sum(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
KN_API KN_CHECKED kn_status kn_bezier_difference(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
// out = factor a: the weight stays. error: gamma(1)|c_k|.
KN_API KN_CHECKED kn_status kn_bezier_scale(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, double factor);
// out = a * b, component by component; an operand of dimension 1 multiplies every component. Weights multiply.
// out:    out.degree[d] = a.degree[d] + b.degree[d].
// fails:  KN_EDOMAIN dimensions differ and neither is 1.
// error:  |c_k - exact| <= gamma(L + 3 nvars)(|a| * |b|)_k, T terms in the sum for c_k. Small integers: all is exact
//         but the last quotient, which is rounded to nearest. An infinity or a NaN may make more coefficients NaN
//         than the definition asks for.
// cost:   count(a) count(b) multiply-adds a component, in the machine's vectors, fused where it has that: the last
//         bits depend on the kind of machine. Scratch: operands and result, rows filled up to whole vectors; no
//         allocation when out has the result's number of coefficients. Sum, dot, cross and determinant alike.
// source: Farouki & Rajan, Algorithms for polynomials in Bernstein form, CAGD 5 (1988).
KN_API KN_CHECKED kn_status kn_bezier_product(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
// out = sum_c a_c b_c, of dimension 1. Dimensions are equal (else KN_EDOMAIN). Error and cost as the products in it;
// T counts the terms of all components.
KN_API KN_CHECKED kn_status kn_bezier_dot(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
// out = a x b. Both of dimension 3 (else KN_EDOMAIN). Error and cost as for kn_bezier_dot.
KN_API KN_CHECKED kn_status kn_bezier_cross(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
// out = the partial derivative of a in variable var.
// out:    polynomial: one degree less in var (0 stays 0). rational (N/w)' = (N' w - w' N) / w^2: degrees double;
//         with degree 0 in var they stay, and the value is 0/w.
// fails:  KN_EDOMAIN var; KN_ELIMIT doubled degrees.
// error:  polynomial: gamma(2)|c_k|. rational: gamma(L + 3 nvars + 3)(|N'| * |w| + |w'| * |N|)_k, N' and w' raised to
//         a's degrees, |N'| with the absolute values of its differences; T = 2 prod_d (degree[d] + 1) at most.
KN_API KN_CHECKED kn_status kn_bezier_derivative(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var);
// out = det(a, b, c) = a . (b x c), of dimension 1; weights multiply.
// out:    out.degree[d] = a.degree[d] + b.degree[d] + c.degree[d].
// fails:  KN_EDOMAIN an operand is not of dimension 3, or the variables differ; KN_ELIMIT.
// error:  gamma(L + L' + 4 nvars) times the sum of the six |a_i| * |b_j| * |c_k|: L' for the sums in b x c, L for
//         those in the product with a. Nothing is divided between: integers as for kn_bezier_product.
// cost:   that of kn_bezier_cross(b, c) and kn_bezier_dot.
KN_API KN_CHECKED kn_status kn_bezier_determinant(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b,
                                                  const kn_bezier *c);
// out_r = sum_c matrix[r * dim(a) + c] a_c + offset[r] for r < dim; offset NULL: zeros. The weight stays.
// out:    dimension dim. An entry that is 0 takes no part, whatever it meets, and 1 alone in a row copies bit
//         for bit.
// fails:  KN_EDOMAIN dim < 1; KN_ELIMIT more than KN_MAX_COMPS components.
// error:  gamma(dim(a) + 1)(sum_c |matrix_rc| |a_c| + |offset_r| |w|)_k.
// cost:   count * dim * dim(a) multiply-adds at most.
KN_API KN_CHECKED kn_status kn_bezier_affine(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int dim,
                                             const double *matrix, const double *offset);
// out = the antiderivative of a in variable var that is zero at 0.
// out:    one degree more in var; exact where the divisions by it are.
// fails:  KN_EDOMAIN var, or a rational (its antiderivative need not be); KN_ELIMIT.
// error:  gamma(k) sum_(i<k) |p_i| / (n + 1) for coefficient k = 0 .. n + 1 along var, n a's degree.
// cost:   an addition and a division a coefficient.
KN_API KN_CHECKED kn_status kn_bezier_antiderivative(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var);
// out = the integral of a over [0,1]^nvars: the mean of the coefficients; dim numbers.
// fails:  KN_EDOMAIN a rational.
// error:  gamma(sum_d degree[d] + 1) times the mean of |p_i|; exact where sums and the division are.
KN_API KN_CHECKED kn_status kn_bezier_integral(kn_ctx *ctx, double *out, const kn_bezier *a);
// All first partials in one piece: component c * nvars + d is the derivative of a_c in variable d.
// out:    polynomial: a's degrees. rational: over the square of the weight, degrees double.
// fails:  KN_EDOMAIN nvars 0; KN_ELIMIT dim * nvars components (and a weight) pass KN_MAX_COMPS, or doubled degrees.
// error:  polynomial: gamma(3)(k |p_k - p_(k-1)| + (n-k) |p_(k+1) - p_k|) along variable d, n its degree: no
//         division, exact for integers. rational: as kn_bezier_derivative.
KN_API KN_CHECKED kn_status kn_bezier_gradient(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a);
// out = sum_d of the derivative of a_d in variable d, of dimension 1. Degrees as kn_bezier_gradient.
// fails:  KN_EDOMAIN dim is not nvars; KN_ELIMIT doubled degrees.
// error:  polynomial: gamma(nvars + 2) times the sum of those of the gradient. rational, D the absolute values of the
//         numerator's differences, raised to a's degrees: gamma(L + 4 nvars + 2)(sum_d D_d * |w| + |N_d| * |D_w|)_k,
//         T = (nvars + 1) prod_d (degree[d] + 1) at most; L + nvars + 5 where out's degrees add up to 47 at most.
KN_API KN_CHECKED kn_status kn_bezier_divergence(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a);
// Components first .. first+count-1 as a polynomial piece (of a rational piece: homogeneous components), exactly.
// fails:  KN_EDOMAIN they are not all among the ncomp components, or count < 1.
KN_API KN_CHECKED kn_status kn_bezier_components(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int first,
                                                 int count);

// ---- shape of the representation: the function is unchanged, or restricted ----
// out = a with degree[d] in variable d.
// fails:  KN_EDOMAIN a degree below a's; KN_ELIMIT.
// error:  gamma(sum over raised d of (T_d + 2)) |a|_k, |a| elevated too; T_d terms,
//         min(a.degree[d], the rise, k_d, degree[d] - k_d) + 1 for coefficient k.
KN_API KN_CHECKED kn_status kn_bezier_elevate(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const int *degree);
// The least degrees, variable by variable, that represent a within tolerance.
// in:     tolerance >= 0. 0: a is a polynomial of these degrees in exact arithmetic (where numbers near the ends of
//         the range of doubles hide that, the answer is higher).
// out:    nvars numbers: degree[d] with those of the variables before it lowered already, so that kn_bezier_reduce to
//         all of them has an error <= tolerance where tolerance > 0. Unchanged on failure.
// fails:  KN_EDOMAIN tolerance.
// cost:   a reduction and its bound for each degree that is tried; at 0 count * degree^2 exact sums.
KN_API KN_CHECKED kn_status kn_bezier_least_degree(kn_ctx *ctx, int *degree, const kn_bezier *a, double tolerance);
// out = a with lower degrees.
// in:     0 <= degree[d] <= a's.
// out:    lines of coefficients that are of the lower degree, but for rounding, are taken back: an elevation is
//         undone, bit for bit when it was exact. Others become the nearest in the sense of least squares of
//         coefficients, with both ends kept bit for bit (in a variable that keeps a degree >= 1): faces depend on
//         faces, and neighbours still meet. *error >= |out - a| (Euclidean norm of values) over [0,1]^nvars, rounding
//         included; 0 only when out is a exactly, as when no degree falls; else INFINITY when a coefficient is not
//         finite, or a weight of a or out not positive. NULL: not wanted.
// fails:  KN_EDOMAIN degree.
// error:  *error: at most 1.25 times the largest distance, where halving the difference some hundred times shows
//         that, and rounding; with weights also (max |out - center| max |dw|) / min w.
// cost:   least squares: count * degree^2 multiply-adds a variable; the bound: that of up to 512 halvings.
// source: Lutterkort, Peters & Reif, CAGD 16 (1999); Ahn, Lee, Park & Yoo, CAGD 21 (2004).
KN_API KN_CHECKED kn_status kn_bezier_reduce(kn_ctx *ctx, kn_bezier *out, double *error, const kn_bezier *a,
                                             const int *degree);
// out(.., x_var, ..) = a(.., 1 - x_var, ..), bit for bit. fails: KN_EDOMAIN var.
KN_API KN_CHECKED kn_status kn_bezier_reverse(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var);
// Variable d of out is variable order[d] of a, a permutation (else KN_EDOMAIN); bit for bit.
KN_API KN_CHECKED kn_status kn_bezier_permute(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const int *order);
// left(t) = a on [0,at] and right(t) = a on [at,1] of variable var, each over [0,1] again.
// in:     at any finite number (else KN_EDOMAIN), also outside [0,1].
// out:    left and right: initialised, two pieces; neither may be a. Their common edge is the same bit for bit.
// error:  gamma(3 k) times the subdivision of |a| for coefficient k of left along var, gamma(3 (degree[var] - k)) of
//         right; outside [0,1] with |at| and |1 - at|.
KN_API KN_CHECKED kn_status kn_bezier_subdivide(kn_ctx *ctx, kn_bezier *left, kn_bezier *right, const kn_bezier *a,
                                                int var, double at);
// out(x) = a(lo + x (hi - lo)), component by component of x; lo and hi may lie outside [0,1], and lo > hi reverses.
// in:     nvars finite numbers each (else KN_EDOMAIN). lo 0 and hi 1 leave a variable as it is, bit for bit.
// out:    boxes that share a face give pieces whose coefficients on it agree bit for bit when the others do.
// error:  gamma(sum_d (5 degree[d] + 2)) sum_j M_kj |p_j|, row k of M the coefficients of
//         (|1-lo| + |lo| x)^(degree - k) (|1-hi| + |hi| x)^k: inside [0,1] the matrix of the restriction, whose rows
//         sum to 1.
// cost:   count * sum_d (degree[d] + 1) multiply-adds a component.
KN_API KN_CHECKED kn_status kn_bezier_restrict(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const double *lo,
                                               const double *hi);
// ---- bounds: rounding included, so that what they exclude is excluded ----
// A box that contains a over [lo,hi] (both NULL: [0,1]^nvars): that of the coefficients there, dim numbers each.
// in:     nvars finite numbers lo <= hi each, also beyond [0,1].
// out:    over [0,1]^nvars the tightest doubles around the (projected) coefficients; elsewhere widened by the error
//         of the restriction, with the sizes of the absolute values there. [-infinity, infinity] where a number is
//         a NaN.
// fails:  KN_EDOMAIN the box, or a weight whose coefficients there, less their error, are not all positive.
// cost:   twice kn_bezier_restrict; none of it over [0,1]^nvars.
KN_API KN_CHECKED kn_status kn_bezier_box(kn_ctx *ctx, double *box_lo, double *box_hi, const kn_bezier *a,
                                          const double *lo, const double *hi);
// A box with turned axes: { center + sum_i s_i axis[i], |s_i| <= half[i] }, axis[i] orthonormal within rounding.
typedef struct kn_oriented_box {
    double center[3], axis[3][3], half[3];
} kn_oriented_box;
// A small oriented box that contains a (dimension 2 or 3) over [0,1]^nvars: the smallest surface among boxes along
// the axes of coordinates, the principal axes of the control points, and chords across the piece.
// out:    every point of a is center + sum_i s_i axis[i] with |s_i| <= half[i], for the axes as stored, which are
//         orthonormal but for about 1e-15. Dimension 2: axis[2] = (0,0,1), half[2] = 0. Where a control point is not
//         finite, half is infinite.
// fails:  KN_EDOMAIN another dimension, or a weight that is not positive.
// cost:   about 60 dim operations a control point.
// source: Gottschalk, Lin & Manocha, OBBTree, SIGGRAPH 1996 (principal axes).
KN_API KN_CHECKED kn_status kn_bezier_oriented_box(kn_ctx *ctx, kn_oriented_box *out, const kn_bezier *a);
// out[d] >= |derivative of a in variable d| (Euclidean norm) over [0,1]^nvars: nvars numbers, from the coefficients
// of the derivative; of a rational piece those of N' w - w' N over those of w^2. Translations of a change nothing
// but rounding.
// out:    INFINITY where numbers overflow.
// fails:  rational: KN_EDOMAIN a weight that is not positive; KN_ELIMIT degrees whose doubles pass KN_MAX_DEGREE.
// cost:   as the derivatives; rational twice that.
KN_API KN_CHECKED kn_status kn_bezier_lipschitz(kn_ctx *ctx, double *out, const kn_bezier *a);

// Removes the factor x_var^k (at_end false) or (1 - x_var)^k (at_end true) that all of a's coefficients share, with
// the largest such k, which *order receives: the exact division by which poles are handled. A zero coefficient is one
// that compares equal to 0; of a rational piece the weight's count too.
// fails:  KN_EDOMAIN var; KN_EUNDEFINED a is zero. *order is then unchanged.
// error:  gamma(2)|c_k|: C(n,i+k) / C(n-k,i) times a coefficient of a.
KN_API KN_CHECKED kn_status kn_bezier_divide_edge(kn_ctx *ctx, kn_bezier *out, int *order, const kn_bezier *a,
                                                  int var, bool at_end);

#ifdef __cplusplus
}
#endif
#endif
