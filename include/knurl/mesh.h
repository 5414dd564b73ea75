// SPDX-License-Identifier: Apache-2.0
// Indexed triangle meshes and the tessellation of patches.
#ifndef KNURL_MESH_H
#define KNURL_MESH_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// position and normal: 3 numbers a vertex (normal unit length, or NULL: not known); triangle: 3 vertex indices each, counterclockwise
// seen from outside. A zero-initialised kn_mesh is a valid empty one; kn_mesh_clear frees it.
typedef struct kn_mesh {
    size_t nvertices, ntriangles;
    double *position, *normal;
    uint32_t *triangle;
    size_t vertex_room, triangle_room; // allocated
} kn_mesh;
// Frees the arrays; the mesh is empty afterwards. NULL and an empty mesh are fine.
KN_API void kn_mesh_clear(kn_ctx *ctx, kn_mesh *mesh);

// out = a. out: initialised, overwritten, may be a. fails: KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_mesh_copy(kn_ctx *ctx, kn_mesh *out, const kn_mesh *a);

// Appends a patch over [0,1]^2 on the uniform grid of segments[0] x segments[1]: vertices with r slowest, unit
// normals along r x t, and two triangles for each rectangle, less those of which two corners coincide.
// in:     patch of two variables in dimension 3, polynomial or rational; segments at least 1 each; reversed flips
//         triangles and normals.
// out:    (segments[0]+1)(segments[1]+1) more vertices, at most 2 segments[0] segments[1] more triangles. Points on
//         an edge depend on that edge's control points and segments alone, whichever way the edge is run, so that
//         patches which share an edge share its points bit for bit. Where r x t vanishes (a collapsed edge, a cusp)
//         the normal is its limit from inside, to about 1e-6; (0,0,1) where the patch has none there either.
// fails:  KN_EDOMAIN (shape, segments), KN_ELIMIT (more than 2^32 - 1 vertices, degree > KN_MAX_DEGREE), KN_ENOMEM;
//         the mesh holds what it held.
// error:  |point - exact| <= gamma(4 (n + m) + 2) max |control point| for degrees (n, m); rational: over the least
//         weight.
// cost:   per vertex and component about 3 (m + 1) products, and per line of r 2 (n + 1)(m + 1); no allocation but
//         the arrays' growth, by half each time.
KN_API KN_CHECKED kn_status kn_mesh_add_patch(kn_ctx *ctx, kn_mesh *mesh, const kn_bezier *patch,
                                              const int segments[2], bool reversed);

#ifdef __cplusplus
}
#endif
#endif
