// SPDX-License-Identifier: Apache-2.0
// Inside mesh: one connectivity for two closed meshes.
#ifndef MESH_CLOSED_H
#define MESH_CLOSED_H

#include <knurl/mesh.h>

// kn_mesh_morph where both are closed, of one component and genus 0.
kn_status kn_mesh_morph_closed(kn_ctx *ctx, kn_mesh *out, double **target, const kn_mesh *a, const kn_mesh *b);

#endif
