// SPDX-License-Identifier: Apache-2.0
// kn_gltf_sink: patches become float32 meshes, one for each part of the tile, written through tinygltf at the end.
#include <cfloat>
#include <cmath>
#include <cstring>
#include <new>
#include <ostream>
#include <streambuf>
#include <strings.h>

#include <tiny_gltf.h>

#include "bridges/tinygltf/gltf.h"
extern "C" {
#include "io/out_file.h"
#include "kernel/context.h"
}

namespace
{

// Interleaved vertices: position and normal, 6 floats each.
struct chunk {
    size_t nvertices, ntriangles, vertex_room, triangle_room;
    float *vertex;
    uint32_t *triangle;
};

struct part {
    char name[KN_NAME_BYTES];
    kn_material material;
    chunk mesh;
};

struct sink {
    kn_out_file *file;
    char *name;
    double unit_mm;
    bool binary, weld;
    int nparts;
    part *parts;
};

// What one block makes: a chunk for each part.
struct product {
    int nparts;
    chunk *chunks;
};

void clear_chunk(kn_ctx *ctx, chunk *c)
{
    kn_free(ctx, c->vertex);
    kn_free(ctx, c->triangle);
    *c = chunk{};
}

bool reserve(kn_ctx *ctx, chunk *c, size_t nvertices, size_t ntriangles)
{
    if (nvertices > c->vertex_room) {
        size_t room = nvertices > 2 * c->vertex_room ? nvertices : 2 * c->vertex_room;
        void *p = c->vertex ? kn_resize(ctx, c->vertex, room, 6 * sizeof(float)) : kn_alloc(ctx, room, 24);
        if (!p) return false;
        c->vertex = static_cast<float *>(p), c->vertex_room = room;
    }
    if (ntriangles > c->triangle_room) {
        size_t room = ntriangles > 2 * c->triangle_room ? ntriangles : 2 * c->triangle_room;
        void *p = c->triangle ? kn_resize(ctx, c->triangle, room, 12) : kn_alloc(ctx, room, 3 * sizeof(uint32_t));
        if (!p) return false;
        c->triangle = static_cast<uint32_t *>(p), c->triangle_room = room;
    }
    return true;
}

// Adding zero turns -0 into 0, so that equal numbers have equal bits.
kn_status to_float(kn_ctx *ctx, float *out, const double *in)
{
    for (int i = 0; i < 3; i++) {
        if (!(std::fabs(in[i]) <= static_cast<double>(FLT_MAX)))
            return kn_fail(ctx, KN_EDOMAIN, "gltf: a vertex has the coordinate %g, beyond float32", in[i]);
        out[i] = static_cast<float>(in[i]) + 0.0f;
    }
    return KN_OK;
}

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
    kn_free(ctx, p->chunks);
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

kn_status work(kn_ctx *worker, void *user, const kn_patch_block *block, void **out)
{
    const sink *s = static_cast<const sink *>(user);
    product *p = static_cast<product *>(kn_alloc_zero(worker, 1, sizeof *p));
    chunk *chunks = static_cast<chunk *>(kn_alloc_zero(worker, static_cast<size_t>(s->nparts), sizeof *chunks));
    kn_mesh mesh = {};
    kn_status status = p && chunks ? KN_OK : KN_ENOMEM;
    if (p) p->nparts = s->nparts, p->chunks = chunks;
    for (int i = 0; i < s->nparts && status == KN_OK; i++) {
        mesh.nvertices = mesh.ntriangles = 0;
        for (size_t k = 0; k < block->count && status == KN_OK; k++) {
            const kn_patch *patch = block->patches + k;
            if (patch->id.part == i)
                status = kn_mesh_add_patch(worker, &mesh, &patch->bezier, patch->segments, patch->reversed);
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

kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *, void *user_product)
{
    sink *s = static_cast<sink *>(user);
    product *p = static_cast<product *>(user_product);
    kn_status status = KN_OK;
    for (int i = 0; i < s->nparts && status == KN_OK; i++) status = append(ctx, &s->parts[i].mesh, p->chunks + i);
    discard(ctx, user, p);
    return status;
}

// ---- the file ----

void add_view(tinygltf::Model *model, const void *data, size_t bytes, size_t stride, int target)
{
    std::vector<unsigned char> &buffer = model->buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0, view.byteOffset = buffer.size(), view.byteLength = bytes, view.byteStride = stride;
    view.target = target;
    const unsigned char *from = static_cast<const unsigned char *>(data);
    buffer.insert(buffer.end(), from, from + bytes);
    buffer.resize((buffer.size() + 3) & ~static_cast<size_t>(3));
    model->bufferViews.push_back(view);
}

// An accessor into the last view; answers its index.
int add_accessor(tinygltf::Model *model, int component, int type, size_t offset, size_t count)
{
    tinygltf::Accessor a;
    a.bufferView = static_cast<int>(model->bufferViews.size()) - 1;
    a.byteOffset = offset, a.componentType = component, a.type = type, a.count = count;
    model->accessors.push_back(a);
    return static_cast<int>(model->accessors.size()) - 1;
}

void set_range(tinygltf::Accessor *a, const float *vertex, size_t count)
{
    for (size_t c = 0; c < 3; c++) {
        float lo = vertex[c], hi = vertex[c];
        for (size_t i = 1; i < count; i++) {
            lo = vertex[6 * i + c] < lo ? vertex[6 * i + c] : lo;
            hi = vertex[6 * i + c] > hi ? vertex[6 * i + c] : hi;
        }
        a->minValues.push_back(static_cast<double>(lo)), a->maxValues.push_back(static_cast<double>(hi));
    }
}

int add_material(tinygltf::Model *model, const part *p)
{
    tinygltf::Material m;
    const double *c = p->material.base_color;
    m.name = p->name;
    m.doubleSided = true; // tiles may be open sheets
    m.pbrMetallicRoughness.baseColorFactor = {c[0], c[1], c[2], 1.0};
    m.pbrMetallicRoughness.metallicFactor = p->material.metallic;
    m.pbrMetallicRoughness.roughnessFactor = p->material.roughness;
    model->materials.push_back(m);
    return static_cast<int>(model->materials.size()) - 1;
}

// Indices are 16 bits wide where they fit; 65535 itself is reserved for primitive restart.
int add_indices(tinygltf::Model *model, const chunk *c)
{
    size_t n = 3 * c->ntriangles;
    if (c->nvertices > 65535) {
        add_view(model, c->triangle, 4 * n, 0, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
        return add_accessor(model, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, 0, n);
    }
    std::vector<uint16_t> narrow(n);
    for (size_t i = 0; i < n; i++) narrow[i] = static_cast<uint16_t>(c->triangle[i]);
    add_view(model, narrow.data(), 2 * n, 0, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    return add_accessor(model, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_SCALAR, 0, n);
}

void add_part(tinygltf::Model *model, const part *p)
{
    const chunk *c = &p->mesh;
    if (model->buffers.empty()) model->buffers.emplace_back();
    add_view(model, c->vertex, 24 * c->nvertices, 24, TINYGLTF_TARGET_ARRAY_BUFFER);
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    int position = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 0, c->nvertices);
    set_range(&model->accessors[static_cast<size_t>(position)], c->vertex, c->nvertices);
    primitive.attributes["POSITION"] = position;
    primitive.attributes["NORMAL"] = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 12,
                                                  c->nvertices);
    primitive.indices = add_indices(model, c);
    primitive.material = add_material(model, p);

    tinygltf::Mesh mesh;
    mesh.name = p->name;
    mesh.primitives.push_back(primitive);
    tinygltf::Node node;
    node.name = p->name;
    node.mesh = static_cast<int>(model->meshes.size());
    model->meshes.push_back(mesh);
    model->nodes[0].children.push_back(static_cast<int>(model->nodes.size()));
    model->nodes.push_back(node);
}

// The root turns (x, y, z) into (x, z, -y), a quarter turn about x, and length units into metres.
void add_root(tinygltf::Model *model, const sink *s)
{
    tinygltf::Node root;
    const double metres = s->unit_mm * 1e-3, half = std::sqrt(0.5);
    root.name = s->name;
    root.rotation = {-half, 0.0, 0.0, half};
    root.scale = {metres, metres, metres};
    model->nodes.push_back(root);
    tinygltf::Scene scene;
    scene.name = s->name;
    scene.nodes.push_back(0);
    model->scenes.push_back(scene);
    model->defaultScene = 0;
    model->asset.version = "2.0";
    model->asset.generator = "knurl " KN_VERSION_STRING;
}

// A stream buffer over a kn_out_file; the first failure stays.
class out_buffer : public std::streambuf
{
  public:
    out_buffer(kn_ctx *ctx, kn_out_file *file) : ctx_(ctx), file_(file)
    {
    }
    kn_status status() const
    {
        return status_;
    }

  protected:
    std::streamsize xsputn(const char *text, std::streamsize n) override
    {
        if (status_ == KN_OK) status_ = kn_out_write(ctx_, file_, text, static_cast<size_t>(n));
        return status_ == KN_OK ? n : 0;
    }
    int_type overflow(int_type c) override
    {
        char byte = traits_type::to_char_type(c);
        if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
        return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
    }

  private:
    kn_ctx *ctx_;
    kn_out_file *file_;
    kn_status status_ = KN_OK;
};

kn_status write_model(kn_ctx *ctx, sink *s)
{
    size_t total = 0;
    for (int i = 0; i < s->nparts; i++)
        total += 24 * s->parts[i].mesh.nvertices + 12 * s->parts[i].mesh.ntriangles + 4;
    if (total > UINT32_MAX - (1u << 20)) // leaves room for the JSON: the lengths in a .glb have 32 bits
        return kn_fail(ctx, KN_ELIMIT, "gltf: %zu bytes of mesh, more than a glTF file holds", total);
    tinygltf::Model model;
    add_root(&model, s);
    for (int i = 0; i < s->nparts; i++) {
        if (s->parts[i].mesh.ntriangles == 0) continue; // an accessor must not be empty
        if (model.buffers.empty()) model.buffers.emplace_back(), model.buffers[0].data.reserve(total);
        add_part(&model, s->parts + i);
        clear_chunk(ctx, &s->parts[i].mesh);
    }
    out_buffer buffer(ctx, s->file);
    std::ostream stream(&buffer);
    tinygltf::TinyGLTF writer;
    bool ok = writer.WriteGltfSceneToStream(&model, stream, false, s->binary);
    if (buffer.status() != KN_OK) return buffer.status();
    if (!ok || !stream.good()) return kn_fail(ctx, KN_EIO, "gltf: the file could not be written");
    return KN_OK;
}

kn_status end(kn_ctx *ctx, void *user)
{
    sink *s = static_cast<sink *>(user);
    kn_status status = KN_OK;
    try {
        status = write_model(ctx, s);
    } catch (const std::bad_alloc &) {
        return kn_fail(ctx, KN_ENOMEM, "gltf: no memory for the file's contents");
    } catch (const std::exception &e) {
        return kn_fail(ctx, KN_EIO, "gltf: %s", e.what());
    }
    if (status != KN_OK) return status;
    return kn_out_commit(ctx, s->file);
}

void close_sink(kn_ctx *ctx, void *user)
{
    sink *s = static_cast<sink *>(user);
    if (!s) return;
    kn_out_close(ctx, s->file);
    for (int i = 0; i < s->nparts; i++) clear_chunk(ctx, &s->parts[i].mesh);
    kn_free(ctx, s->parts);
    kn_free(ctx, s->name);
    kn_free(ctx, s);
}

size_t bytes(const void *user)
{
    return kn_out_bytes(static_cast<const sink *>(user)->file);
}

bool ends_in(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    return n > m && !strcasecmp(path + n - m, ending);
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
    if (!ends_in(path, ".glb") && !ends_in(path, ".gltf"))
        return kn_fail(ctx, KN_EDOMAIN, "gltf: %s ends neither in .glb nor in .gltf", path);
    if (!(o.unit_mm >= 0.0 && std::isfinite(o.unit_mm)))
        return kn_fail(ctx, KN_EDOMAIN, "gltf: %g millimetres in a unit", o.unit_mm);
    sink *s = static_cast<sink *>(kn_alloc_zero(ctx, 1, sizeof *s));
    if (!s) return KN_ENOMEM;
    s->unit_mm = o.unit_mm > 0.0 ? o.unit_mm : 1.0;
    s->binary = ends_in(path, ".glb"), s->weld = !o.keep_duplicates;
    s->name = static_cast<char *>(kn_alloc(ctx, strlen(name) + 1, 1));
    kn_status status = s->name ? kn_out_open(ctx, &s->file, path) : KN_ENOMEM;
    if (status != KN_OK) {
        close_sink(ctx, s);
        return status;
    }
    memcpy(s->name, name, strlen(name) + 1);
    *out = kn_sink{s, begin, work, commit, discard, end, close_sink, bytes};
    return KN_OK;
}
