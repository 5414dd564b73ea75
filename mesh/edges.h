// SPDX-License-Identifier: Apache-2.0
// Inside mesh: edges of triangles, each with the triangles beside it.
#ifndef MESH_EDGES_H
#define MESH_EDGES_H

#include <knurl/mesh.h>

// Corner `corner` of a triangle and the next one: an edge as this triangle runs along it.
typedef struct kn_mesh_side {
    uint32_t from, to, triangle;
    int corner;
} kn_mesh_side;
// All 3 ntriangles sides, those of one edge together; ordered by the vertices, then by `from`. NULL: KN_ENOMEM.
kn_mesh_side *kn_mesh_sides(kn_ctx *ctx, const kn_mesh *mesh);
// How many sides from `at` on are of one edge.
size_t kn_mesh_side_group(const kn_mesh_side *sides, size_t n, size_t at);

#endif
