// SPDX-License-Identifier: Apache-2.0
// What the fits share: checks of shapes and sites, values to coefficients, and layers that are given.
#ifndef FIT_INTERNAL_H
#define FIT_INTERNAL_H

#include <knurl/fit.h>

#include "kernel/knots.h"

// KN_OK when a spline may have this shape and these knots.
kn_status kn_fit_expect(kn_ctx *ctx, const char *call, int nvars, int dim, const int *degree, const int *count,
                        const double *const *knots);
// *s = a polynomial spline in scratch with this shape and these knots, checked so; coefficients not filled.
kn_status kn_fit_start(kn_ctx *ctx, const char *call, kn_spline *s, int nvars, int dim, const int *degree,
                       const int *count, const double *const *knots);
// The same check for one variable.
kn_status kn_fit_expect_axis(kn_ctx *ctx, const char *call, const double *knots, int degree, int count);

// One variable of a grid of data.
typedef struct kn_fit_axis {
    int var; // for messages
    int degree, count;
    const double *knots;
    int nsites;
    const double *sites;
} kn_fit_axis;
// Whether B-spline i is positive at x inside the domain: t_i < x < t_i+p+1, or at an end of its support that p + 1
// knots share, from the side that counts.
bool kn_fit_acts(const kn_fit_axis *axis, int i, double x);
// Spans of the sites, which increase and lie in the domain (else KN_EDOMAIN).
kn_status kn_fit_spans(kn_ctx *ctx, const char *call, int *span, const kn_fit_axis *axis);
// KN_OK when some increasing choice of sites suits the B-splines first .. end - 1 (Schoenberg and Whitney); else
// KN_EUNDEFINED. sites do not decrease; equal ones count once.
kn_status kn_fit_suits(kn_ctx *ctx, const char *call, const kn_fit_axis *axis, int first, int end);
// The values of the B-splines at the sites as a band in scratch: nsites rows, width degree + 1.
kn_status kn_fit_basis(kn_ctx *ctx, kn_band *band, const kn_fit_axis *axis, const int *span);

// to (ncomp arrays of n) = from (n points of ncomp numbers).
void kn_fit_by_component(double *to, const double *from, size_t n, int ncomp);

// Given layers; NULL means none. KN_EDOMAIN unless something is left free.
kn_status kn_fit_check_fixed(kn_ctx *ctx, const char *call, int nvars, const int *count, const kn_fit_fixed *fixed);
// coef becomes fixed->coef in the given layers, and zero elsewhere.
void kn_fit_put_fixed(double *coef, int nvars, int dim, const int *count, const kn_fit_fixed *fixed);
// coef's free part becomes `free` (dim arrays of prod (count - first - last) numbers).
void kn_fit_put_free(double *coef, const double *free, int nvars, int dim, const int *count,
                     const kn_fit_fixed *fixed);

// The quasi-interpolant's map along one axis: rows count, width degree + 1, in scratch; from values at `sites`
// (Greville's, increasing) to coefficients.
kn_status kn_fit_quasi_band(kn_ctx *ctx, kn_band *band, const double *knots, int degree, int count,
                            const double *sites);
// s->coef becomes the function's values on the grid of sites, and values become the quasi-interpolant's coefficients.
kn_status kn_fit_sample(kn_ctx *ctx, kn_spline *s, double *const *sites, kn_fit_function function, void *user);
kn_status kn_fit_quasi_apply(kn_ctx *ctx, kn_spline *s, double *const *sites);

#endif
