// SPDX-License-Identifier: Apache-2.0
// Inside the glTF bridge: float32 meshes, and the file that they become.
#ifndef BRIDGES_TINYGLTF_MODEL_H
#define BRIDGES_TINYGLTF_MODEL_H

#include "bridges/tinygltf/gltf.h"
extern "C" {
#include "io/out_file.h"
#include "kernel/context.h"
}

namespace kng
{

// Interleaved vertices: position and normal, 6 floats each.
struct chunk {
    size_t nvertices, ntriangles, vertex_room, triangle_room;
    float *vertex;
    uint32_t *triangle;
    float *color; // linear RGB, 3 floats a vertex; NULL: none
};

// Polylines: points, 3 floats each, and how many of them each line has.
struct lines {
    size_t npoints, nlines, point_room, line_room;
    float *point;
    uint32_t *length;
};

struct part {
    char name[KN_NAME_BYTES];
    kn_material material;
    chunk mesh;
    lines curves;
    float *targets; // ntargets morph targets: differences of position and normal, 6 floats a vertex; NULL: none
    size_t ntargets;
};

// Everything but the meshes that a file has. extras: a JSON object for the asset, or NULL.
struct file_options {
    const char *name, *extras;
    double unit_mm;
    bool binary;
    double seconds; // of an animation of the parts' morph targets, one after the other
};

void clear_chunk(kn_ctx *ctx, chunk *c);
bool reserve(kn_ctx *ctx, chunk *c, size_t nvertices, size_t ntriangles);
void clear_lines(kn_ctx *ctx, lines *l);
bool reserve_lines(kn_ctx *ctx, lines *l, size_t npoints, size_t nlines);
// Three floats. fails: KN_EDOMAIN beyond float32.
kn_status to_float(kn_ctx *ctx, float *out, const double *in);
// fails: KN_EDOMAIN another ending than .glb and .gltf, unit_mm; else *binary tells which, and *unit_mm is above 0.
kn_status check_file(kn_ctx *ctx, const char *path, bool *binary, double *unit_mm);
// Writes the parts, clearing each as it goes, and commits the file. No exception leaves it.
kn_status write_file(kn_ctx *ctx, kn_out_file *file, const file_options *options, part *parts, int nparts);

} // namespace kng

#endif
