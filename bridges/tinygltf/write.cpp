// SPDX-License-Identifier: Apache-2.0
// kn_gltf_sink: patches become float32 meshes, one for each part of the tile, written through tinygltf at the end.
#include <cstring>

#include "bridges/tinygltf/model.h"

namespace
{

using namespace kng;

struct sink {
    kn_out_file *file;
    char *name;
    double unit_mm;
    bool binary, weld;
    int nparts;
    part *parts;
};

// What one block makes: a chunk and lines for each part.
struct product {
    int nparts;
    chunk *chunks;
    lines *curves;
};

uint32_t hash_vertex(const float *v)
{
    uint32_t bits[6], h = 2166136261u;
    memcpy(bits, v, sizeof bits);
    for (uint32_t b : bits) {
        h = (h ^ b) * 0x9E3779B1u;
        h ^= h >> 15;
    }
    return h;
}

// The index of v among the vertices of c, at its end if it is new. table has mask + 1 slots of index + 1, or 0.
uint32_t place_vertex(chunk *c, uint32_t *table, size_t mask, const float *v)
{
    if (table) {
        size_t slot = hash_vertex(v) & mask;
        for (; table[slot]; slot = (slot + 1) & mask)
            if (!memcmp(c->vertex + 6 * (table[slot] - 1), v, 24)) return table[slot] - 1;
        table[slot] = static_cast<uint32_t>(c->nvertices + 1);
    }
    memcpy(c->vertex + 6 * c->nvertices, v, 24);
    return static_cast<uint32_t>(c->nvertices++);
}

// Appends mesh to the empty chunk c: rounded, welded, without the triangles that this makes degenerate.
kn_status convert(kn_ctx *ctx, chunk *c, const kn_mesh *mesh, bool weld)
{
    size_t slots = 64;
    while (slots < 2 * mesh->nvertices) slots *= 2;
    kn_mark mark = kn_scratch_mark(ctx);
    uint32_t *map = static_cast<uint32_t *>(kn_scratch(ctx, mesh->nvertices + 1, sizeof *map));
    uint32_t *table = weld ? static_cast<uint32_t *>(kn_scratch(ctx, slots, sizeof *table)) : nullptr;
    bool ok = map && (table || !weld) && reserve(ctx, c, mesh->nvertices, mesh->ntriangles);
    kn_status status = ok ? KN_OK : KN_ENOMEM;
    if (ok && table) memset(table, 0, slots * sizeof *table);
    for (size_t i = 0; i < mesh->nvertices && status == KN_OK; i++) {
        float v[6];
        status = to_float(ctx, v, mesh->position + 3 * i);
        if (status == KN_OK) status = to_float(ctx, v + 3, mesh->normal + 3 * i);
        if (status == KN_OK) map[i] = place_vertex(c, table, slots - 1, v);
    }
    for (size_t t = 0; t < mesh->ntriangles && status == KN_OK; t++) {
        const uint32_t *from = mesh->triangle + 3 * t;
        uint32_t a = map[from[0]], b = map[from[1]], d = map[from[2]], *to = c->triangle + 3 * c->ntriangles;
        if (a != b && b != d && d != a) to[0] = a, to[1] = b, to[2] = d, c->ntriangles++;
    }
    kn_scratch_release(ctx, mark);
    return status;
}

void discard(kn_ctx *ctx, void *, void *user_product)
{
    product *p = static_cast<product *>(user_product);
    if (!p) return;
    for (int i = 0; i < p->nparts && p->chunks; i++) clear_chunk(ctx, p->chunks + i);
    for (int i = 0; i < p->nparts && p->curves; i++) clear_lines(ctx, p->curves + i);
    kn_free(ctx, p->chunks);
    kn_free(ctx, p->curves);
    kn_free(ctx, p);
}

kn_status begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *)
{
    sink *s = static_cast<sink *>(user);
    size_t n = static_cast<size_t>(tile->nparts);
    part *parts = static_cast<part *>(kn_alloc_zero(ctx, n, sizeof *parts));
    if (!parts) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) {
        memcpy(parts[i].name, tile->parts[i].name, KN_NAME_BYTES - 1);
        parts[i].material = tile->parts[i].material;
    }
    s->parts = parts, s->nparts = tile->nparts;
    return KN_OK;
}

// A curve as a polyline.
kn_status add_line(kn_ctx *ctx, lines *l, const kn_patch *patch)
{
    size_t n = kn_patch_line_points(patch);
    if (n == 0) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    double *p = static_cast<double *>(kn_scratch(ctx, n, 3 * sizeof *p));
    kn_status status = p && reserve_lines(ctx, l, l->npoints + n, l->nlines + 1) ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) status = kn_patch_line(ctx, p, patch);
    for (size_t i = 0; i < n && status == KN_OK; i++)
        status = to_float(ctx, l->point + 3 * (l->npoints + i), p + 3 * i);
    if (status == KN_OK) l->length[l->nlines++] = static_cast<uint32_t>(n), l->npoints += n;
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status work(kn_ctx *worker, void *user, const kn_patch_block *block, void **out)
{
    const sink *s = static_cast<const sink *>(user);
    product *p = static_cast<product *>(kn_alloc_zero(worker, 1, sizeof *p));
    chunk *chunks = static_cast<chunk *>(kn_alloc_zero(worker, static_cast<size_t>(s->nparts), sizeof *chunks));
    lines *curves = static_cast<lines *>(kn_alloc_zero(worker, static_cast<size_t>(s->nparts), sizeof *curves));
    kn_mesh mesh = {};
    kn_status status = p && chunks && curves ? KN_OK : KN_ENOMEM;
    if (p) p->nparts = s->nparts, p->chunks = chunks, p->curves = curves;
    for (int i = 0; i < s->nparts && status == KN_OK; i++) {
        mesh.nvertices = mesh.ntriangles = 0;
        for (size_t k = 0; k < block->count && status == KN_OK; k++) {
            const kn_patch *patch = block->patches + k;
            if (patch->look != i) continue;
            status = kn_patch_tessellate(worker, &mesh, patch);
            if (status == KN_OK) status = add_line(worker, curves + i, patch);
        }
        if (status == KN_OK && mesh.ntriangles > 0) status = convert(worker, chunks + i, &mesh, s->weld);
    }
    kn_mesh_clear(worker, &mesh);
    if (status == KN_OK) {
        *out = p;
    } else if (p) {
        discard(worker, user, p);
    } else {
        kn_free(worker, chunks);
        kn_free(worker, curves);
    }
    return status;
}

kn_status append(kn_ctx *ctx, chunk *to, const chunk *from)
{
    size_t nv = to->nvertices + from->nvertices, nt = to->ntriangles + from->ntriangles;
    if (nv >= UINT32_MAX / 24 || nt >= UINT32_MAX / 12)
        return kn_fail(ctx, KN_ELIMIT, "gltf: %zu vertices and %zu triangles in one part", nv, nt);
    if (!reserve(ctx, to, nv, nt)) return KN_ENOMEM;
    if (from->nvertices) memcpy(to->vertex + 6 * to->nvertices, from->vertex, 24 * from->nvertices);
    for (size_t i = 0; i < 3 * from->ntriangles; i++)
        to->triangle[3 * to->ntriangles + i] = from->triangle[i] + static_cast<uint32_t>(to->nvertices);
    to->nvertices = nv, to->ntriangles = nt;
    return KN_OK;
}

kn_status append_lines(kn_ctx *ctx, lines *to, const lines *from)
{
    size_t np = to->npoints + from->npoints, nl = to->nlines + from->nlines;
    if (np >= UINT32_MAX / 20) return kn_fail(ctx, KN_ELIMIT, "gltf: %zu points of curves in one part", np);
    if (from->nlines == 0) return KN_OK;
    if (!reserve_lines(ctx, to, np, nl)) return KN_ENOMEM;
    memcpy(to->point + 3 * to->npoints, from->point, 12 * from->npoints);
    memcpy(to->length + to->nlines, from->length, 4 * from->nlines);
    to->npoints = np, to->nlines = nl;
    return KN_OK;
}

kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *, void *user_product)
{
    sink *s = static_cast<sink *>(user);
    product *p = static_cast<product *>(user_product);
    kn_status status = KN_OK;
    for (int i = 0; i < s->nparts && status == KN_OK; i++) {
        status = append(ctx, &s->parts[i].mesh, p->chunks + i);
        if (status == KN_OK) status = append_lines(ctx, &s->parts[i].curves, p->curves + i);
    }
    discard(ctx, user, p);
    return status;
}

kn_status end(kn_ctx *ctx, void *user)
{
    sink *s = static_cast<sink *>(user);
    const file_options o = {s->name, nullptr, s->unit_mm, s->binary, 0.0};
    return write_file(ctx, s->file, &o, s->parts, s->nparts);
}

void close_sink(kn_ctx *ctx, void *user)
{
    sink *s = static_cast<sink *>(user);
    if (!s) return;
    kn_out_close(ctx, s->file);
    for (int i = 0; i < s->nparts; i++) clear_chunk(ctx, &s->parts[i].mesh), clear_lines(ctx, &s->parts[i].curves);
    kn_free(ctx, s->parts);
    kn_free(ctx, s->name);
    kn_free(ctx, s);
}

size_t bytes(const void *user)
{
    return kn_out_bytes(static_cast<const sink *>(user)->file);
}

} // namespace

kn_gltf_options kn_gltf_defaults(void)
{
    return kn_gltf_options{};
}

kn_status kn_gltf_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_gltf_options *options)
{
    kn_gltf_options o = options ? *options : kn_gltf_defaults();
    const char *name = o.name ? o.name : "knurl";
    bool binary = false;
    kn_status status = check_file(ctx, path, &binary, &o.unit_mm);
    if (status != KN_OK) return status;
    sink *s = static_cast<sink *>(kn_alloc_zero(ctx, 1, sizeof *s));
    if (!s) return KN_ENOMEM;
    s->unit_mm = o.unit_mm, s->binary = binary, s->weld = !o.keep_duplicates;
    s->name = static_cast<char *>(kn_alloc(ctx, strlen(name) + 1, 1));
    status = s->name ? kn_out_open(ctx, &s->file, path) : KN_ENOMEM;
    if (status != KN_OK) {
        close_sink(ctx, s);
        return status;
    }
    memcpy(s->name, name, strlen(name) + 1);
    *out = kn_sink{s, begin, work, commit, discard, end, close_sink, bytes, nullptr, nullptr, nullptr};
    return KN_OK;
}
