// SPDX-License-Identifier: Apache-2.0
// Inside step: cells that are one another, moved, as instances of one part.
#ifndef STEP_INSTANCES_H
#define STEP_INSTANCES_H

#include "step/join.h"

// Control points that a thread notes: x, y, z in mm, weight.
typedef struct kn_step_points {
    double *x;
    size_t n, room; // numbers
} kn_step_points;
// Appends those of a patch, and says in *item which they are, and by what its form is known.
// fails: KN_EDOMAIN (a trimmed patch, a curve), KN_EUNDEFINED, KN_ENOMEM.
kn_status kn_step_note_points(kn_ctx *ctx, kn_step_points *points, kn_step_item *item, const kn_patch *patch,
                              double mm);

typedef struct kn_step_cells kn_step_cells;
// join: begun.
kn_status kn_step_cells_create(kn_ctx *ctx, kn_step_cells **out, kn_step_join *join);
void kn_step_cells_destroy(kn_ctx *ctx, kn_step_cells *cells); // NULL is fine
// One more face, whose text is data[item->text_begin] .. data[end]. Where a cell ends with it, that is written.
// fails: KN_EDOMAIN the bodies of a cell are not closed by its own faces.
kn_status kn_step_cells_add(kn_ctx *ctx, kn_step_cells *cells, kn_text *out, const kn_step_item *item,
                            const char *data, size_t end, const double *points);
kn_status kn_step_cells_end(kn_ctx *ctx, kn_step_cells *cells, kn_text *out); // the last cell

#endif
