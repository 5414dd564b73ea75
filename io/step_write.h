// SPDX-License-Identifier: Apache-2.0
// Inside io: the pieces of a STEP AP214 file (ISO 10303-21, 10303-214) and its numbering.
//
// Entity numbers are arithmetic in the place of a patch, so that any thread can write any patch without knowing the
// others; numbers that a patch does not need stay unused, which the format allows.
//     1 .. 21                    context, units, product, representations
//     100 + 16 p ..              shell, surface model and colour of part p
//     KN_STEP_PARTS + 16 nparts  + stride * place: the patches
#ifndef IO_STEP_WRITE_H
#define IO_STEP_WRITE_H

#include <knurl/job.h>

#include "io/text_buffer.h"

enum {
    KN_STEP_GEOMETRY_CONTEXT = 15,
    KN_STEP_PLACEMENT = 19,
    KN_STEP_REPRESENTATION = 20,
    KN_STEP_PRESENTATION = 21,
    KN_STEP_PARTS = 100,       // the first number of part 0
    KN_STEP_PART_NUMBERS = 16, // of each part: the shell first, its surface model next, then its colour
    KN_STEP_FACE_NUMBERS = 20  // of each patch, beyond one for each control point; the last is the face
};

// The header section and everything that does not depend on the patches.
void kn_step_put_header(kn_text *text, const char *product, const char *time_stamp, double uncertainty_mm);
// What patch needs for a face of its own, numbered from `first`: points in millimetres, surface, boundary, face.
// fails: KN_EUNDEFINED (a weight that is not positive, a control point that is not finite), KN_ENOMEM.
KN_CHECKED kn_status kn_step_put_face(kn_text *text, const kn_patch *patch, const char *part, uint64_t first,
                                      double mm);
// A curve's points in millimetres, and the curve, which has the number that a face would have (kn_step_face).
// fails: as kn_step_put_face.
KN_CHECKED kn_status kn_step_put_curve(kn_text *text, const kn_patch *patch, uint64_t first, double mm);
// How many control points a patch has, and from this which number its face gets when numbered from `first`.
uint64_t kn_step_face(const kn_bezier *b, uint64_t first);
// The colour of the part whose numbers start at `first`.
void kn_step_put_style(kn_text *text, const kn_material *material, uint64_t first);
// "#n=" of an entity.
void kn_step_put_number(kn_text *text, uint64_t n);

#endif
