// SPDX-License-Identifier: Apache-2.0
// Interpolation, least squares and quasi-interpolation on given knots, any number of variables.
#ifndef KNURL_FIT_H
#define KNURL_FIT_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// out = the spline of these degrees, counts and knots that takes values[i*dim + c] at the grid point i of sites[0] x
// sites[1] x ..; count[d] increasing sites in variable d, the last variable fastest.
KN_API KN_CHECKED kn_status kn_fit_interpolate(kn_ctx *ctx, kn_spline *out, int nvars, int dim, const int *degree,
                                               const int *count, const double *const *knots,
                                               const double *const *sites, const double *values);

#ifdef __cplusplus
}
#endif
#endif
