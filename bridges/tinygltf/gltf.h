// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 through tinygltf: a sink that tessellates a job's patches, and a reader of triangles.
#ifndef BRIDGES_GLTF_H
#define BRIDGES_GLTF_H

#include "bridges/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

// Zero means the default in every field.
typedef struct kn_gltf_options {
    const char *name;     // of the root node; NULL: "knurl"
    double unit_mm;       // millimetres in one length unit; 0: 1
    bool keep_duplicates; // leave vertices whose float positions and normals are equal apart (the sink)
    const char *extras;   // kn_gltf_write: a JSON object that goes into the asset's extras; NULL: none
} kn_gltf_options;
KN_API kn_gltf_options kn_gltf_defaults(void);

// A sink that writes path as one binary file (.glb) or as JSON with its buffer embedded (.gltf).
// Each part of the tile becomes one mesh with one material under a root node that scales length units to metres and
// turns z upwards into glTF's y upwards; vertices stay in length units, as float32, with normals. Curves become the
// segments of their polylines (kn_patch_line), one primitive of lines for all of a part.
// in:    path and options are copied.
// fails: KN_EDOMAIN another ending, unit_mm negative or not finite; KN_EIO the folder refuses a file; KN_ENOMEM.
// While
//        the job runs: also KN_EDOMAIN a point beyond float32, KN_ELIMIT more than 4 GiB. Nothing is left behind.
// error: a coordinate is rounded once to float32 after kn_mesh_add_patch.
// cost:  the whole mesh is held until the end: 24 bytes a vertex, 12 a triangle, three times over while writing.
// source: Khronos, glTF 2.0 Specification (ISO/IEC 12113:2022).
KN_API KN_CHECKED kn_status kn_gltf_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_gltf_options *options);

// Writes the items of a scene in length units, z upwards, as a file like the sink's: a mesh and a material each, with
// the colours of vertices as COLOR_0.
// in:    every mesh has normals, or is empty, and then left out.
// fails: KN_EDOMAIN another ending, unit_mm, no normals, an index out of range, beyond float32; KN_ELIMIT; KN_EIO,
// also
//        when extras is no JSON; KN_ENOMEM. Nothing is left behind.
KN_API KN_CHECKED kn_status kn_gltf_write(kn_ctx *ctx, const char *path, const kn_scene *scene,
                                          const kn_gltf_options *options);

// The same of meshes that move: the first frame as it is, and each later one as a morph target of it, with an
// animation "time" of their weights, frame after frame at equal steps over so many seconds. in:    nframes >= 1
// scenes with as many items, whose meshes have the same triangles; seconds > 0. fails: as kn_gltf_write, and
// KN_EDOMAIN for what differs.
KN_API KN_CHECKED kn_status kn_gltf_write_frames(kn_ctx *ctx, const char *path, const kn_scene *frames, int nframes,
                                                 double seconds, const kn_gltf_options *options);

// The triangles of the default scene (or of all nodes) of a .glb or .gltf file, told apart by content: one item for
// each primitive of each node, in metres, y upwards, node transforms applied. Strips and fans become triangles;
// points and lines are left out. COLOR_0 is read, textures are not.
// out:   initialised (possibly empty), overwritten; kn_scene_clear.
// fails: KN_EIO; KN_EPARSE bad JSON or structure, an index or accessor outside its buffer, not finite positions, an
//        extension that is required, sparse accessors: the message names the file; KN_ELIMIT a file above 4 GiB;
//        KN_ENOMEM. out unchanged.
// error: float32 positions are transformed in double precision.
KN_API KN_CHECKED kn_status kn_gltf_read(kn_ctx *ctx, kn_scene *out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
