// SPDX-License-Identifier: Apache-2.0
// Values of one piecewise polynomial at many points: the plain version, and vector versions chosen at run time.
//
// In each variable a point lies in span [a,b] at x = (t - a) (1/(b - a)), exactly 1 at the end of the domain, and the
// B-splines there are N_k = sum_r B_r(x) E_rk: Bernstein polynomials times the span's extraction matrix, whose
// elements are blossoms, >= 0, with rows that add up to 1. The value is
// sum_k N_k (sum_j N_j (sum_i N_i c_ijk)), the first variable innermost, every sum in ascending order, no fused
// multiply-add: all versions, on all machines, for batches cut anyhow, give the same bits.
// Error: |computed - exact| <= gamma(sum_d (17 p_d + 3)) max |c| over the control points that act, inside the domain
// (docs/numerics.md).
#ifndef KERNEL_EVAL_H
#define KERNEL_EVAL_H

#include <stdbool.h>
#include <stddef.h>

#include <knurl/base.h>

// What is evaluated. As in kn_spline; a variable whose knots are NULL is a Bezier piece over [0,1].
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

// out[i * dim + c] for the npoints points at[i * nvars + d], one by one, without tables: the reference. Parameters
// beyond the domain extend the end pieces; a weight of zero gives a value that is not finite.
void kn_eval_plain(double *out, const kn_eval_function *f, size_t npoints, const double *at);

// Tables of one function of at most KN_EVAL_MAX_VARS variables, in memory that the caller provides.
enum { KN_EVAL_MAX_VARS = 3 };
typedef struct kn_eval_axis {
    int degree, width; // width: degree + 1 rounded up to whole vectors
    int spans, buckets, steps;
    double lo, end, scale;
    size_t stride;                          // of packed coefficients, in numbers
    const double *left, *inverse, *extract; // per span; extract: (degree + 1) x width, NULL for Bezier
    const double *binomial;
    const size_t *first; // where in the packed coefficients a span's begin
    const int *start;    // the span to search from, of a bucket
    double *basis;       // workspace of one block
} kn_eval_axis;
typedef struct kn_eval_plan {
    int nvars, ncomp, width; // width: ncomp rounded up to whole vectors
    bool rational;
    const double *packed; // coefficients, components innermost, `width` numbers each
    double *bernstein, *x;
    kn_eval_axis axis[KN_EVAL_MAX_VARS];
} kn_eval_plan;

// Whether tables pay for themselves with this many points (never beyond KN_EVAL_MAX_VARS variables).
bool kn_eval_wants_plan(const kn_eval_function *f, size_t npoints);
// Numbers of memory that a plan takes; it must be aligned to 64 bytes and outlive the plan.
size_t kn_eval_room(const kn_eval_function *f);
void kn_eval_prepare(kn_eval_plan *plan, const kn_eval_function *f, double *memory);
// As kn_eval_plain, by tables and vectors. level: SSE2 .. kn_eval_best().
void kn_eval_planned(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, kn_eval_level level);

// The whole: by tables where they pay, at the best level; scratch from the context. fails: KN_ENOMEM.
kn_status kn_eval_batch(kn_ctx *ctx, double *out, const kn_eval_function *f, size_t npoints, const double *at);

#endif
