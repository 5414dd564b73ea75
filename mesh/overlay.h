// SPDX-License-Identifier: Apache-2.0
// Inside mesh: two closed meshes on one sphere become one.
#ifndef MESH_OVERLAY_H
#define MESH_OVERLAY_H

#include <knurl/mesh.h>

// The faces that both cut the sphere into, in triangles. a_on, b_on: of kn_mesh_to_sphere. Vertices: those of a,
// those of b, and where edges cross; position: on a, *target: on b. out and *target are overwritten, without being
// cleared. b is turned a little where two vertices or edges come too near to each other.
// fails: KN_EUNDECIDED rounding decides how they lie, KN_ELIMIT, KN_ECANCELLED, KN_ENOMEM; outputs unchanged.
kn_status kn_mesh_overlay(kn_ctx *ctx, kn_mesh *out, double **target, const kn_mesh *a, const double *a_on,
                          const kn_mesh *b, const double *b_on);

#endif
