// SPDX-License-Identifier: Apache-2.0
// Slices of textured objects: contours at heights, for layered manufacturing.
#ifndef KNURL_SLICE_H
#define KNURL_SLICE_H

#include <knurl/job.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifdef __cplusplus
}
#endif
#endif
