// SPDX-License-Identifier: Apache-2.0
// Curves, surfaces and volumes from a few numbers, or from each other.
#ifndef KNURL_CONSTRUCT_H
#define KNURL_CONSTRUCT_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifdef __cplusplus
}
#endif
#endif
