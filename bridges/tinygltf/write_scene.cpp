// SPDX-License-Identifier: Apache-2.0
// kn_gltf_write: meshes with a material and perhaps colours of their vertices, as a glTF file.
#include <cstdio>
#include <cstring>

#include "bridges/tinygltf/model.h"

namespace
{

using namespace kng;

kn_status fill(kn_ctx *ctx, part *out, const kn_scene_item *item, int index)
{
    const kn_mesh &m = item->mesh;
    chunk *c = &out->mesh;
    snprintf(out->name, sizeof out->name, "mesh %d", index);
    out->material = item->material;
    if (!m.normal && m.nvertices > 0) return kn_fail(ctx, KN_EDOMAIN, "gltf: mesh %d has no normals", index);
    if (m.nvertices >= UINT32_MAX / 24 || m.ntriangles >= UINT32_MAX / 12)
        return kn_fail(ctx, KN_ELIMIT, "gltf: %zu vertices and %zu triangles in one mesh", m.nvertices, m.ntriangles);
    if (!reserve(ctx, c, m.nvertices, m.ntriangles)) return KN_ENOMEM;
    if (item->color && m.nvertices > 0)
        c->color = static_cast<float *>(kn_alloc(ctx, m.nvertices, 3 * sizeof(float)));
    if (item->color && m.nvertices > 0 && !c->color) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (size_t i = 0; i < m.nvertices && status == KN_OK; i++) {
        status = to_float(ctx, c->vertex + 6 * i, m.position + 3 * i);
        if (status == KN_OK) status = to_float(ctx, c->vertex + 6 * i + 3, m.normal + 3 * i);
    }
    for (size_t i = 0; i < 3 * m.ntriangles && status == KN_OK; i++) {
        if (m.triangle[i] >= m.nvertices)
            return kn_fail(ctx, KN_EDOMAIN, "gltf: triangle %zu of mesh %d has vertex %u of %zu", i / 3, index,
                           m.triangle[i], m.nvertices);
        c->triangle[i] = m.triangle[i];
    }
    if (c->color && item->color) memcpy(c->color, item->color, 3 * m.nvertices * sizeof(float));
    c->nvertices = m.nvertices, c->ntriangles = m.ntriangles;
    return status;
}

// The morph targets of item `index`: what each later frame's vertices differ by from the first frame's.
kn_status fill_targets(kn_ctx *ctx, part *out, const kn_scene *frames, int nframes, int index)
{
    const kn_mesh &base = frames[0].items[index].mesh;
    size_t n = base.nvertices;
    out->ntargets = static_cast<size_t>(nframes) - 1;
    for (int f = 1; f < nframes && n == 0; f++)
        if (frames[f].items[index].mesh.nvertices > 0)
            return kn_fail(ctx, KN_EDOMAIN, "gltf: mesh %d is empty in the first frame, but not in frame %d", index,
                           f);
    if (n == 0 || nframes == 1) return KN_OK;
    out->targets = static_cast<float *>(kn_alloc(ctx, 6 * n * out->ntargets, sizeof(float)));
    if (!out->targets) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (int f = 1; f < nframes; f++) {
        const kn_mesh &m = frames[f].items[index].mesh;
        if (m.nvertices != n || m.ntriangles != base.ntriangles || !m.normal ||
            memcmp(m.triangle, base.triangle, 3 * m.ntriangles * sizeof *m.triangle) != 0)
            return kn_fail(ctx, KN_EDOMAIN, "gltf: mesh %d has other triangles in frame %d than in the first", index,
                           f);
        float *to = out->targets + 6 * n * (static_cast<size_t>(f) - 1);
        for (size_t i = 0; i < n && status == KN_OK; i++) {
            double move[6];
            for (size_t c = 0; c < 3; c++) {
                move[c] = m.position[3 * i + c] - base.position[3 * i + c];
                move[3 + c] = m.normal[3 * i + c] - base.normal[3 * i + c];
            }
            status = to_float(ctx, to + 6 * i, move);
            if (status == KN_OK) status = to_float(ctx, to + 6 * i + 3, move + 3);
        }
    }
    return status;
}

} // namespace

kn_status kn_gltf_write(kn_ctx *ctx, const char *path, const kn_scene *scene, const kn_gltf_options *options)
{
    return kn_gltf_write_frames(ctx, path, scene, 1, 1.0, options);
}

kn_status kn_gltf_write_frames(kn_ctx *ctx, const char *path, const kn_scene *frames, int nframes, double seconds,
                               const kn_gltf_options *options)
{
    kn_gltf_options o = options ? *options : kn_gltf_defaults();
    file_options file = {o.name ? o.name : "knurl", o.extras, 0.0, false, seconds};
    kn_status status = check_file(ctx, path, &file.binary, &o.unit_mm);
    file.unit_mm = o.unit_mm;
    if (status == KN_OK && (nframes < 1 || !(seconds > 0.0)))
        status = kn_fail(ctx, KN_EDOMAIN, "gltf: %d frames in %g seconds", nframes, seconds);
    for (int f = 1; f < nframes && status == KN_OK; f++)
        if (frames[f].nitems != frames[0].nitems)
            status = kn_fail(ctx, KN_EDOMAIN, "gltf: frame %d has %d meshes, the first %d", f, frames[f].nitems,
                             frames[0].nitems);
    if (status != KN_OK) return status;
    int n = frames[0].nitems;
    part *parts = static_cast<part *>(kn_alloc_zero(ctx, static_cast<size_t>(n) + 1, sizeof *parts));
    kn_out_file *out = nullptr;
    if (!parts) status = KN_ENOMEM;
    for (int i = 0; i < n && status == KN_OK; i++) {
        status = fill(ctx, parts + i, frames[0].items + i, i);
        if (status == KN_OK) status = fill_targets(ctx, parts + i, frames, nframes, i);
    }
    if (status == KN_OK) status = kn_out_open(ctx, &out, path);
    if (status == KN_OK) status = write_file(ctx, out, &file, parts, n);
    kn_out_close(ctx, out);
    for (int i = 0; i < n && parts; i++) {
        clear_chunk(ctx, &parts[i].mesh);
        kn_free(ctx, parts[i].targets);
    }
    kn_free(ctx, parts);
    return status;
}
