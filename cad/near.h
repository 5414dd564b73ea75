// SPDX-License-Identifier: Apache-2.0
// Inside cad: the face nearest to a point.
#ifndef CAD_NEAR_H
#define CAD_NEAR_H

#include <knurl/cad.h>

// As kn_cad_find says, among the faces that a flag is set for; the first of equals. *face: unchanged where there is none.
KN_CHECKED kn_status kn_cad_nearest(kn_ctx *ctx, int *face, const kn_cad *cad, const bool *among,
                                    const double point[3]);

#endif
