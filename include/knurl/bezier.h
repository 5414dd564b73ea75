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

// ---- life ----
// *out = a piece with these shapes and all coefficients zero. out is overwritten, not cleared.
KN_API KN_CHECKED kn_status kn_bezier_init(kn_ctx *ctx, kn_bezier *out, int nvars, int ncomp, bool rational,
                                           const int *degree);
KN_API void kn_bezier_clear(kn_ctx *ctx, kn_bezier *b);
KN_API void kn_bezier_swap(kn_bezier *a, kn_bezier *b);
KN_API KN_CHECKED kn_status kn_bezier_copy(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a);
// Coefficients of one component: prod_d (degree[d] + 1).
KN_API size_t kn_bezier_count(const kn_bezier *b);
// Components of a value: ncomp, less the weight when rational.
KN_API int kn_bezier_dim(const kn_bezier *b);

// ---- values ----
KN_API KN_CHECKED kn_status kn_bezier_eval(kn_ctx *ctx, double *out, const kn_bezier *b, const double *at);
// npoints values: out[i*dim + c] at the point at[i*nvars .. i*nvars + nvars-1].
KN_API KN_CHECKED kn_status kn_bezier_eval_batch(kn_ctx *ctx, double *out, const kn_bezier *b, size_t npoints,
                                                 const double *at);
// All partial derivatives of total order <= order. out holds kn_derivative_count(nvars, order) values of dim
// components each, in the order of kn_derivative_index.
KN_API KN_CHECKED kn_status kn_bezier_derivatives(kn_ctx *ctx, double *out, const kn_bezier *b, const double *at,
                                                  int order);
// The number of multi-indices a over nvars variables with |a| <= order: C(nvars + order, order); 0 if it overflows
// int.
KN_API int kn_derivative_count(int nvars, int order);
// The place of the multi-index a: by total order, then lexicographically with the first variable slowest and
// highest first: for two variables f, f_u, f_v, f_uu, f_uv, f_vv, ...
KN_API int kn_derivative_index(int nvars, const int *a);

// ---- algebra: out is initialised (possibly empty), overwritten, and may be an operand ----
KN_API KN_CHECKED kn_status kn_bezier_sum(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
KN_API KN_CHECKED kn_status kn_bezier_difference(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
KN_API KN_CHECKED kn_status kn_bezier_scale(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, double factor);
KN_API KN_CHECKED kn_status kn_bezier_product(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
KN_API KN_CHECKED kn_status kn_bezier_dot(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
KN_API KN_CHECKED kn_status kn_bezier_cross(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);
KN_API KN_CHECKED kn_status kn_bezier_derivative(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var);
// Components first .. first+count-1 as a polynomial piece (of a rational piece: homogeneous components).
KN_API KN_CHECKED kn_status kn_bezier_components(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int first,
                                                 int count);

// ---- shape of the representation: the function is unchanged, or restricted ----
KN_API KN_CHECKED kn_status kn_bezier_elevate(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const int *degree);
// left(t) = a on [0,at] and right(t) = a on [at,1] of variable var, each over [0,1] again. left, right: not a.
KN_API KN_CHECKED kn_status kn_bezier_subdivide(kn_ctx *ctx, kn_bezier *left, kn_bezier *right, const kn_bezier *a,
                                                int var, double at);
// out(x) = a(lo + x (hi - lo)), component by component of x; lo and hi may lie outside [0,1], and lo > hi reverses.
KN_API KN_CHECKED kn_status kn_bezier_restrict(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const double *lo,
                                               const double *hi);
// Removes the factor x_var^k (at_end false) or (1 - x_var)^k (at_end true) that all of a's coefficients share, with
// the largest such k, which *order receives: the exact division by which poles are handled. A zero piece:
// KN_EUNDEFINED.
KN_API KN_CHECKED kn_status kn_bezier_divide_edge(kn_ctx *ctx, kn_bezier *out, int *order, const kn_bezier *a,
                                                  int var, bool at_end);

#ifdef __cplusplus
}
#endif
#endif
