// SPDX-License-Identifier: Apache-2.0
// Certified signs, roots, intersections and closest points.
#ifndef KNURL_SOLVE_H
#define KNURL_SOLVE_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifdef __cplusplus
}
#endif
#endif
