// SPDX-License-Identifier: Apache-2.0
// Inside knurl: how many straight segments a spline needs to look like itself.
#ifndef IO_BEND_H
#define IO_BEND_H

#include <knurl/spline.h>

// out = what of a spline in space the chord height of one segment for each span is, at most: that of n segments is
// 1/n^2 of it. Of rational splines about right. fails: KN_ENOMEM; out unchanged.
KN_CHECKED kn_status kn_spline_bend(kn_ctx *ctx, double *out, const kn_spline *s);
// The same for each variable by itself: n[d] segments of each span in variable d are within the sum of out[d] / n[d]^2
// over all d.
KN_CHECKED kn_status kn_spline_bends(kn_ctx *ctx, double out[3], const kn_spline *s);
// The segments of a span that are within tol > 0: 1 .. 128.
int kn_bend_segments(double bend, double tol);
// out = those of all spans of variable var of s, as kn_patch counts them: segments >= 1 of each.
// fails: KN_ELIMIT more than 2^30; out unchanged.
KN_CHECKED kn_status kn_bend_total(kn_ctx *ctx, int *out, const kn_spline *s, int var, int segments);

#endif
