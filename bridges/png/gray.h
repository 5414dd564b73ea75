// SPDX-License-Identifier: Apache-2.0
// Grey levels of a PNG as samples of a field over (u,v).
#ifndef BRIDGES_PNG_GRAY_H
#define BRIDGES_PNG_GRAY_H

#include <knurl/field.h>

#ifdef __cplusplus
extern "C" {
#endif

#define KN_PNG_MAX_GRAY ((size_t)1 << 26) // pixels

// Samples for kn_field_grid: the picture lies on [0,1]^2 as it is seen, u to the right and v upwards.
// out:   overwritten. out->values is the caller's, for kn_free. black is 0, white 1, levels between in proportion to
//        their numbers in the file (no gamma); of colours the luma of Rec. 709; opacity is left out. One pixel each way
//        is doubled, so that n is at least 2.
// fails: KN_EIO path cannot be opened; KN_EPARSE no PNG, or a damaged one: the message names the file; KN_ELIMIT more
//        than KN_PNG_MAX_GRAY pixels; KN_ENOMEM; out unchanged.
// cost:  8 bytes a pixel, and the picture decoded once more.
// source: ISO/IEC 15948:2004, Portable Network Graphics.
KN_API KN_CHECKED kn_status kn_png_read_gray(kn_ctx *ctx, kn_field_samples *out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
