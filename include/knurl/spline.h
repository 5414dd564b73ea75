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

// ---- life ----
// knots[d]: count[d] + degree[d] + 1 numbers, copied and checked as above. coef: copied; NULL means zeros.
KN_API KN_CHECKED kn_status kn_spline_init(kn_ctx *ctx, kn_spline *out, int nvars, int ncomp, bool rational,
                                           const int *degree, const int *count, const double *const *knots,
                                           const double *coef);
KN_API void kn_spline_clear(kn_ctx *ctx, kn_spline *s);
KN_API void kn_spline_swap(kn_spline *a, kn_spline *b);
KN_API KN_CHECKED kn_status kn_spline_copy(kn_ctx *ctx, kn_spline *out, const kn_spline *a);
// KN_OK, or KN_EDOMAIN / KN_ELIMIT with a message saying which rule above is broken (also: not finite, weight <= 0).
KN_API KN_CHECKED kn_status kn_spline_check(kn_ctx *ctx, const kn_spline *s);
KN_API size_t kn_spline_count(const kn_spline *s); // control points
KN_API int kn_spline_dim(const kn_spline *s);      // ncomp, less the weight when rational
KN_API void kn_spline_domain(const kn_spline *s, int var, double *lo, double *hi);
// Non-empty knot intervals of variable var.
KN_API int kn_spline_spans(const kn_spline *s, int var);
// The box of the control points (projected when rational): dim numbers each. It contains the whole spline.
KN_API KN_CHECKED kn_status kn_spline_box(kn_ctx *ctx, double *lo, double *hi, const kn_spline *s);

// ---- values: parameters outside the domain extend the end pieces ----
KN_API KN_CHECKED kn_status kn_spline_eval(kn_ctx *ctx, double *out, const kn_spline *s, const double *at);
KN_API KN_CHECKED kn_status kn_spline_eval_batch(kn_ctx *ctx, double *out, const kn_spline *s, size_t npoints,
                                                 const double *at);
KN_API KN_CHECKED kn_status kn_spline_derivatives(kn_ctx *ctx, double *out, const kn_spline *s, const double *at,
                                                  int order);

// ---- algebra: operands over equal domains; their knots are merged as the result's continuity asks ----
KN_API KN_CHECKED kn_status kn_spline_sum(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
KN_API KN_CHECKED kn_status kn_spline_product(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
KN_API KN_CHECKED kn_status kn_spline_dot(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
KN_API KN_CHECKED kn_status kn_spline_cross(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b);
KN_API KN_CHECKED kn_status kn_spline_derivative(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var);
KN_API KN_CHECKED kn_status kn_spline_elevate(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const int *degree);

// ---- pieces ----
// Inserts n knots (any order, repeated for multiplicity) into variable var; the function is unchanged.
KN_API KN_CHECKED kn_status kn_spline_insert_knots(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var,
                                                   const double *knots, int n);
KN_API KN_CHECKED kn_status kn_spline_subdivide(kn_ctx *ctx, kn_spline *left, kn_spline *right, const kn_spline *a,
                                                int var, double at);
// out = a over the sub-box [lo,hi], lo < hi; a box beyond the domain extends the end pieces.
KN_API KN_CHECKED kn_status kn_spline_restrict(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const double *lo,
                                               const double *hi);
// The Bezier pieces, one for each box of non-empty knot intervals: *pieces is an array of *npieces, the last variable
// fastest, to be cleared one by one and freed with kn_free. Neighbours share their common coefficients bit for bit.
KN_API KN_CHECKED kn_status kn_spline_to_bezier(kn_ctx *ctx, kn_bezier **pieces, size_t *npieces, const kn_spline *a);
// The way back: pieces of one shape on the grid of breaks[d][0 .. nbreaks[d]-1] (increasing), last variable fastest,
// that agree to order continuity[d] (-1 .. degree-1) at every interior break of variable d; the knots there get
// multiplicity degree - continuity. Coefficients that this determines twice are taken from the lower piece.
KN_API KN_CHECKED kn_status kn_spline_from_bezier(kn_ctx *ctx, kn_spline *out, const kn_bezier *pieces,
                                                  const int *nbreaks, const double *const *breaks,
                                                  const int *continuity);
KN_API KN_CHECKED kn_status kn_spline_of_bezier(kn_ctx *ctx, kn_spline *out, const kn_bezier *a); // over [0,1]^n

#ifdef __cplusplus
}
#endif
#endif
