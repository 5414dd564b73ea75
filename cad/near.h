// SPDX-License-Identifier: Apache-2.0
// Inside cad: the face nearest to a point.
#ifndef CAD_NEAR_H
#define CAD_NEAR_H

#include <knurl/cad.h>

// As kn_cad_find says; the first of equals. in: a model with faces.
KN_CHECKED kn_status kn_cad_nearest(kn_ctx *ctx, int *face, const kn_cad *cad, const double point[3]);

#endif
