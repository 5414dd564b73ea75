// SPDX-License-Identifier: Apache-2.0
// STEP, IGES and BREP files through Open CASCADE as models of splines.
#ifndef BRIDGES_OCCT_CAD_READ_H
#define BRIDGES_OCCT_CAD_READ_H

#include <knurl/cad.h>

#ifdef __cplusplus
extern "C" {
#endif

// By the first bytes of the file, whatever it is called. One at a time in a process: OCCT keeps its settings in globals.
// out:    overwritten (what it held is cleared); kn_cad_clear. Bodies: each part of the assembly once; in it solids,
//         shells outside of solids, loose faces together. Faces body by body, as the shells have them. Splines over
//         OCCT's parameters at the ends of circles' arcs (a quarter at most each), so that a cylinder that goes round
//         is closed in u over [0, 2 pi]. Faces that cannot be read are left out, with a warning to the context's log.
// fails:  KN_EIO, KN_EPARSE (no such format, a STEP file without its end, what OCCT refuses, no face), KN_EUNDECIDED
//         (OCCT threw), KN_ENOMEM; out unchanged.
// error:  lines, conics, splines and what is made of them: rounding. Others: kn_cad_face.error as OCCT estimates it.
//         Curves of trims that are no polynomials are met to about 1e-5 mm at the quarters of each cubic.
KN_CHECKED kn_status kn_occt_read(kn_ctx *ctx, kn_cad *out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
