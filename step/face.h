// SPDX-License-Identifier: Apache-2.0
// Inside step: what plain and trimmed faces of a STEP file share.
#ifndef STEP_FACE_H
#define STEP_FACE_H

#include "step/line.h"

void kn_step_put_points(kn_text *text, const kn_patch_net *f);  // numbers 0 .. n - 1
void kn_step_put_surface(kn_text *text, const kn_patch_net *f); // number n
void kn_step_put_plane_context(kn_text *text, uint32_t number); // of curves in the plane of the parameters

// ---- trimmed.c ----
kn_status kn_step_put_trimmed(kn_text *text, kn_step_item *item, kn_step_lists *lists, const kn_patch *patch,
                              double mm);

#endif
