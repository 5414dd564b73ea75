// SPDX-License-Identifier: Apache-2.0
// Parts for tests and examples, made with Open CASCADE as they are made in a CAD system.
#ifndef BRIDGES_OCCT_KNOB_H
#define BRIDGES_OCCT_KNOB_H

#include <knurl/base.h>

#ifdef __cplusplus
extern "C" {
#endif

// A knob as a STEP file: a profile revolved about z, two edges rounded. One solid of 7 faces, "knob", light grey: the
// shaft (a cylinder of radius 6 from z = 0 to 8), its end, the underside, the top; tori of radius 1 and 1.5, red; and
// between these "grip", black, a cylinder of radius 12 from z = 9 to 18.5.
// fails: KN_EIO the file, KN_EUNDECIDED OCCT threw.
KN_CHECKED kn_status kn_occt_write_knob(kn_ctx *ctx, const char *path);

// Two boxes of 10 by 20 by 30 mm from the origin on, which are the same in their own coordinates and yet two parts of an
// assembly, 40 mm apart: 12 faces, 6 of each. fails: as before.
KN_CHECKED kn_status kn_occt_write_boxes(kn_ctx *ctx, const char *path);

#ifdef __cplusplus
}
#endif
#endif
