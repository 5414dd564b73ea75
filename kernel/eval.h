// SPDX-License-Identifier: Apache-2.0
// Values and first partial derivatives of one piecewise polynomial at many points or on a grid: plain versions, and
// vector versions chosen at run time.
//
// In each variable a point lies in span [a,b] at x = (t - a) (1/(b - a)), exactly 1 at the end of the domain. The
// B-splines there are N_k = sum_r B_r(x) E_rk: Bernstein polynomials times the span's extraction matrix, whose
// elements are blossoms, >= 0, with rows that add up to 1; their derivatives are G_k = sum_r B'_r(x) E_rk, with
// B'_r = p/(b - a) (b_(r-1) - b_r), b of degree p - 1.
//
// At points the value is sum_k N_k (sum_j N_j (sum_i N_i c_ijk)), the first variable innermost. Sums ascend; the last
// variable's is (even k) + (odd k), which lets wide vectors hold two neighbours. Where the table for it is small
// (kn_eval_splits), the last variable is in Bezier form: c_ijr = sum_k E_rk c_ijk, and the last sum runs over r.
// On a grid the last variable is innermost, all sums ascend, and nothing is split.
//
// No multiplication is fused with an addition: all versions, on all machines, for batches cut anyhow, give the same
// bits. Bounds: docs/numerics.md.
#ifndef KERNEL_EVAL_H
#define KERNEL_EVAL_H

#include <stdbool.h>
#include <stddef.h>

#include <knurl/base.h>

// What is evaluated. As in kn_spline; a variable whose knots are NULL is a Bezier piece over [0,1]. nvars >= 1.
typedef struct kn_eval_function {
    int nvars, ncomp;
    bool rational;
    const int *degree, *count;
    const double *const *knots;
    const double *coef;
} kn_eval_function;

typedef enum kn_eval_level {
    KN_EVAL_PLAIN,
    KN_EVAL_SSE2,
    KN_EVAL_AVX2,
    KN_EVAL_AVX512,
    KN_EVAL_LEVELS
} kn_eval_level;
// The highest level that this machine and this build have. Elsewhere than on x86, SSE2 is the vector version of the
// baseline.
kn_eval_level kn_eval_best(void);
const char *kn_eval_level_name(kn_eval_level level);

// Whether evaluation at points takes the last variable in Bezier form: by the shape alone, never by the points.
bool kn_eval_splits(const kn_eval_function *f);

// out[i * dim + c] for the npoints points at[i * nvars + d], one by one, without tables: the reference. With partials
// out[(i * (1 + nvars) + k) * dim + c], k = 0 the value, k = 1 + d the derivative in variable d. Parameters beyond
// the domain extend the end pieces; a weight of zero gives a value that is not finite.
void kn_eval_plain(double *out, const kn_eval_function *f, size_t npoints, const double *at, bool partials);
// out[i * dim + c], i over the grid, the last variable fastest; the reference.
void kn_eval_grid_plain(double *out, const kn_eval_function *f, const size_t *n, const double *const *at);

// Tables of one function, in memory that the caller provides.
typedef struct kn_eval_axis {
    int degree, width; // width: degree + 1 rounded up to whole vectors
    int spans, buckets, steps;
    double lo, end, scale;
    double step;            // spans begin at lo + i step, bit for bit, and are equally long; 0: no
    size_t stride;          // of packed coefficients, in numbers
    double *left, *inverse; // of each span: where it begins, 1 / its length
    size_t *first, even;    // where in the packed coefficients its own begin; even: it is i * even (0: it is not)
    double *extract;        // per span: (degree + 1) x width; NULL: Bezier form
    double *binomial, *low; // of degree and degree - 1
    int *start;             // the span to search from, of a bucket
    double *b, *g;          // of one block of points: Bernstein polynomials and derivatives, [degree + 1][block]
    double *basis, *slope;  // the same in B-splines, [block][width]; NULL without extract
} kn_eval_axis;
typedef struct kn_eval_plan {
    int nvars, ncomp, width; // width: ncomp rounded up to whole vectors
    bool rational;
    double *packed; // coefficients, components innermost, `width` numbers each; of four, the weight is the last
    kn_eval_axis axis[KN_MAX_VARS];
} kn_eval_plan;

// Whether tables pay for themselves with this many points.
bool kn_eval_wants_plan(const kn_eval_function *f, size_t npoints);
// Numbers of memory that a plan takes; it must be aligned to 64 bytes and outlive the plan.
size_t kn_eval_room(const kn_eval_function *f);
void kn_eval_prepare(kn_eval_plan *plan, const kn_eval_function *f, double *memory);
// As kn_eval_plain, by tables and vectors. level: SSE2 .. kn_eval_best().
void kn_eval_planned(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, bool partials,
                     kn_eval_level level);
// As kn_eval_grid_plain. memory: kn_eval_grid_room numbers, aligned to 64 bytes. nvars >= 2.
size_t kn_eval_grid_room(const kn_eval_function *f, const size_t *n);
void kn_eval_grid_planned(double *out, const kn_eval_function *f, const size_t *n, const double *const *at,
                          double *memory, kn_eval_level level);

// The whole: by tables where they pay, at the best level; scratch from the context. fails: KN_ENOMEM.
kn_status kn_eval_batch(kn_ctx *ctx, double *out, const kn_eval_function *f, size_t npoints, const double *at,
                        bool partials);
kn_status kn_eval_grid(kn_ctx *ctx, double *out, const kn_eval_function *f, const size_t *n, const double *const *at);

#endif
