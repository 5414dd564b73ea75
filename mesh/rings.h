// SPDX-License-Identifier: Apache-2.0
// Inside mesh: a closed surface from which vertices are taken away one by one, and put back.
#ifndef MESH_RINGS_H
#define MESH_RINGS_H

#include <knurl/mesh.h>

enum { KN_MESH_MOST_RING = 12 };

// The neighbours of each vertex, counterclockwise: circular lists of nodes.
typedef struct kn_mesh_rings {
    size_t n;                   // vertices of the mesh, alive or not
    uint32_t *to, *next, *prev; // of nodes
    uint32_t *head, *degree;    // of vertices; without a ring: UINT32_MAX, 0
    uint32_t free;              // nodes, linked by next
} kn_mesh_rings;

// Of a mesh each of whose edges has two triangles, which run along it in both directions. fails: KN_EDOMAIN a vertex
// where the surface touches itself; KN_ENOMEM. Cleared by kn_mesh_rings_clear, also after a failure.
kn_status kn_mesh_rings_init(kn_ctx *ctx, kn_mesh_rings *out, const kn_mesh *mesh);
void kn_mesh_rings_clear(kn_ctx *ctx, kn_mesh_rings *rings);

// The neighbours of v, at most KN_MESH_MOST_RING. Returns how many.
int kn_mesh_ring(uint32_t out[KN_MESH_MOST_RING], const kn_mesh_rings *rings, uint32_t v);
bool kn_mesh_are_neighbours(const kn_mesh_rings *rings, uint32_t a, uint32_t b);
// Takes v away; triangles from ring[0] to the others fill the place. ring: the k neighbours of v from one of them on,
// none of ring[2] .. ring[k - 2] a neighbour of ring[0].
void kn_mesh_take_out(kn_mesh_rings *rings, uint32_t v, const uint32_t *ring, int k);
// Undoes the last of these that is not undone.
void kn_mesh_put_back(kn_mesh_rings *rings, uint32_t v, const uint32_t *ring, int k);

#endif
