// SPDX-License-Identifier: Apache-2.0
// Indexed triangle meshes and the tessellation of patches.
#ifndef KNURL_MESH_H
#define KNURL_MESH_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// position and normal: 3 numbers a vertex (normal unit length); triangle: 3 vertex indices each, counterclockwise
// seen from outside. A zero-initialised kn_mesh is a valid empty one; kn_mesh_clear frees it.
typedef struct kn_mesh {
    size_t nvertices, ntriangles;
    double *position, *normal;
    uint32_t *triangle;
    size_t vertex_room, triangle_room; // allocated
} kn_mesh;
KN_API void kn_mesh_clear(kn_ctx *ctx, kn_mesh *mesh);

// Appends (segments[0]+1)(segments[1]+1) vertices and 2 segments[0] segments[1] triangles (fewer where they are
// degenerate: two corners equal) of a patch over [0,1]^2, dim 3. Points on an edge depend on that edge's control
// points alone, so that patches which share an edge and its segments share its points bit for bit. reversed flips
// triangles and normals. Where the normal vanishes (a collapsed edge) the limit from inside is taken.
KN_API KN_CHECKED kn_status kn_mesh_add_patch(kn_ctx *ctx, kn_mesh *mesh, const kn_bezier *patch,
                                              const int segments[2], bool reversed);

#ifdef __cplusplus
}
#endif
#endif
