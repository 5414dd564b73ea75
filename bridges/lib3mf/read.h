// SPDX-License-Identifier: Apache-2.0
// Meshes from 3MF files through lib3mf.
#ifndef BRIDGES_LIB3MF_READ_H
#define BRIDGES_LIB3MF_READ_H

#include <knurl/mesh.h>

#ifdef __cplusplus
extern "C" {
#endif

// The triangles of all build items of a .3mf file, with their transforms and those of components, as one mesh.
// out:   initialised (possibly empty), overwritten; in the file's unit, no normals. Triangles of which two corners are
//        one vertex are left out.
// fails: KN_EIO; KN_EPARSE what lib3mf refuses, a coordinate that is not finite, no triangle: the message names the
//        file; KN_ELIMIT 2^31 vertices or triangles, components nested more than 32 deep; KN_ENOMEM; out unchanged.
// error: coordinates are in single precision, and lib3mf moves them to a grid (their units in the fifth digit).
KN_API KN_CHECKED kn_status kn_3mf_read(kn_ctx *ctx, kn_mesh *out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
