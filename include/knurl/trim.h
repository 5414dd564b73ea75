// SPDX-License-Identifier: Apache-2.0
// Regions of a parameter plane bounded by curves: what is left of a patch that was cut.
#ifndef KNURL_TRIM_H
#define KNURL_TRIM_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// Closed loops of curves; the region lies to the left of each: outer loops run counterclockwise, holes clockwise. A
// zero-initialised kn_trim is the whole domain. kn_trim_clear ends it.
typedef struct kn_trim {
    kn_spline *curves; // of one variable and dimension 2, one after the other; each begins where the one before it in
    int ncurves;       // its loop ends, bit for bit, and the first where the last ends
    int *loop_end;     // loop i: curves loop_end[i - 1] (i = 0: 0) .. loop_end[i] - 1
    int nloops;
} kn_trim;
KN_API void kn_trim_clear(kn_ctx *ctx, kn_trim *trim); // leaves it empty; NULL is fine

#ifdef __cplusplus
}
#endif
#endif
