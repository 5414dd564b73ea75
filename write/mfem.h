// SPDX-License-Identifier: Apache-2.0
// Inside write: what an MFEM mesh says of how its patches meet.
#ifndef WRITE_MFEM_H
#define WRITE_MFEM_H

#include <knurl/job.h>

#include "io/text_buffer.h"

// A patch as its neighbours see it. Corners, edges and faces are numbered as MFEM does: a square 0 1 2 3 runs around,
// a cube has it at the bottom and 4 5 6 7 above. A sum stands for control points, in whatever order they come.
typedef struct kn_mfem_cell {
    kn_patch_id id; // for messages
    int look;
    double corner[8][3];
    uint64_t edge[12], face[6];
    uint64_t knots[3][2]; // of each variable, and of the variable run backwards
} kn_mfem_cell;

// The corners at the ends of edge e in the direction of its variable, and the variable.
void kn_mfem_edge(int e, int corner[2], int *var);
enum { KN_MFEM_SQUARE_EDGES = 4, KN_MFEM_CUBE_EDGES = 12, KN_MFEM_CUBE_FACES = 6 };
// The corners of face f of a cube, seen from outside counterclockwise, and where it lies: its variable and end.
void kn_mfem_face(int f, int corner[4], int *var, int *end);

// Whether any three of n patches of nvars variables meet at an edge of surfaces, or at a face; of no patch an edge has the
// same corner at both ends. Sums are not looked at. fails: KN_EDOMAIN these (the message says which), KN_ENOMEM.
KN_CHECKED kn_status kn_mfem_check_edges(kn_ctx *ctx, const kn_mfem_cell *cells, size_t n, int nvars);
// The sections dimension, elements, boundary, edges and vertices of n patches of nvars variables, 2 or 3, of which no
// edge has the same corner at both ends.
// fails: KN_EDOMAIN patches that do not meet as MFEM wants them to (the message says which), KN_ENOMEM.
KN_CHECKED kn_status kn_mfem_put_topology(kn_ctx *ctx, kn_text *text, const kn_mfem_cell *cells, size_t n, int nvars);

#endif
