// SPDX-License-Identifier: Apache-2.0
// Meshes from OBJ, STL, PLY and OFF files through OpenMesh.
#ifndef BRIDGES_OPENMESH_READ_H
#define BRIDGES_OPENMESH_READ_H

#include <knurl/mesh.h>

#ifdef __cplusplus
extern "C" {
#endif

// The triangles of a .obj, .stl, .ply or .off file, told apart by its ending in letters of either case.
// out:   initialised (possibly empty), overwritten; no normals. Polygons become fans of triangles about their first
//        corner; triangles of which two corners are one vertex are left out; vertices of an STL file that are equal
//        become one.
// fails: KN_EDOMAIN another ending; KN_EIO; KN_EPARSE no such file, an index without its vertex, a coordinate that is
//        not finite, no triangle: the message names the file; KN_ELIMIT 2^31 vertices or triangles; KN_ENOMEM; out
//        unchanged.
// error: OpenMesh reads coordinates of STL and OFF files in single precision.
KN_API KN_CHECKED kn_status kn_openmesh_read(kn_ctx *ctx, kn_mesh *out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
