// SPDX-License-Identifier: Apache-2.0
// kn_gltf_read: the triangles of a glTF file. tinygltf parses; every index and size is checked here before use.
#include <cmath>
#include <cstring>
#include <new>

#include <tiny_gltf.h>

#include "bridges/tinygltf/gltf.h"
extern "C" {
#include "io/in_file.h"
#include "kernel/context.h"
}

namespace
{

enum { MAX_NESTING = 64 }; // of JSON: the parser's values are recursive

struct reader {
    kn_ctx *ctx;
    const char *path;
    const tinygltf::Model *model;
    kn_scene scene;
    int room;
};

// An accessor whose elements all lie inside its buffer.
struct view {
    const unsigned char *data;
    size_t count, stride;
    int component;
};

// Column-major, as glTF writes it: 12 numbers of the affine part, column by column.
struct affine {
    double m[4][3];
};

kn_status bad(const reader *r, const char *what, int index)
{
    return kn_fail(r->ctx, KN_EPARSE, "%s: %s %d", r->path, what, index);
}

// ---- accessors ----

size_t component_bytes(int component)
{
    switch (component) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return 4;
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
    default: return 0;
    }
}

// Every sum below is of numbers that are checked to be at most the buffer's size first, so none overflows.
kn_status get_view(const reader *r, view *out, int index, int type)
{
    const tinygltf::Model &m = *r->model;
    if (index < 0 || static_cast<size_t>(index) >= m.accessors.size()) return bad(r, "no accessor", index);
    const tinygltf::Accessor &a = m.accessors[static_cast<size_t>(index)];
    size_t element = component_bytes(a.componentType) * (type == TINYGLTF_TYPE_VEC4   ? 4
                                                         : type == TINYGLTF_TYPE_VEC3 ? 3
                                                                                      : 1);
    if (a.type != type || element == 0) return bad(r, "unexpected type of accessor", index);
    if (a.sparse.isSparse) return bad(r, "sparse accessor (not supported)", index);
    if (a.bufferView < 0 || static_cast<size_t>(a.bufferView) >= m.bufferViews.size())
        return bad(r, "no bufferView for accessor", index);
    const tinygltf::BufferView &v = m.bufferViews[static_cast<size_t>(a.bufferView)];
    if (v.buffer < 0 || static_cast<size_t>(v.buffer) >= m.buffers.size())
        return bad(r, "no buffer for bufferView", a.bufferView);
    const std::vector<unsigned char> &data = m.buffers[static_cast<size_t>(v.buffer)].data;
    if (v.byteOffset > data.size() || v.byteLength > data.size() - v.byteOffset)
        return bad(r, "the buffer is too short for bufferView", a.bufferView);
    size_t stride = v.byteStride ? v.byteStride : element;
    if (a.count == 0 || a.byteOffset > v.byteLength || element > v.byteLength - a.byteOffset || stride < element ||
        a.count - 1 > (v.byteLength - a.byteOffset - element) / stride)
        return bad(r, "the bufferView is too short for accessor", index);
    *out = view{data.data() + v.byteOffset + a.byteOffset, a.count, stride, a.componentType};
    return KN_OK;
}

uint32_t get_index(const view *v, size_t i)
{
    const unsigned char *from = v->data + i * v->stride;
    uint16_t two;
    uint32_t four;
    if (v->component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return from[0];
    if (v->component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return memcpy(&two, from, 2), two;
    return memcpy(&four, from, 4), four;
}

void get_vector(const view *v, size_t i, double out[3])
{
    float from[3];
    memcpy(from, v->data + i * v->stride, sizeof from);
    for (int c = 0; c < 3; c++) out[c] = static_cast<double>(from[c]);
}

// A channel of a colour in [0,1]; integers are shares of their largest.
float get_channel(const view *v, size_t i, size_t c)
{
    const unsigned char *from = v->data + i * v->stride + c * component_bytes(v->component);
    uint16_t two;
    float real;
    if (v->component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return static_cast<float>(from[0]) / 255.0f;
    if (v->component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT)
        return memcpy(&two, from, 2), static_cast<float>(two) / 65535.0f;
    memcpy(&real, from, 4);
    return real > 0.0f ? (real < 1.0f ? real : 1.0f) : 0.0f;
}

// ---- transforms ----

affine multiply(const affine &a, const affine &b)
{
    affine out;
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 3; i++) {
            double sum = j == 3 ? a.m[3][i] : 0.0;
            for (int k = 0; k < 3; k++) sum += a.m[k][i] * b.m[j][k];
            out.m[j][i] = sum;
        }
    return out;
}

// T R S, or the matrix that the node gives instead.
affine node_transform(const tinygltf::Node &n)
{
    affine out = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};
    if (n.matrix.size() == 16) {
        for (size_t j = 0; j < 4; j++)
            for (size_t i = 0; i < 3; i++) out.m[j][i] = n.matrix[4 * j + i];
        return out;
    }
    if (n.rotation.size() == 4) {
        double x = n.rotation[0], y = n.rotation[1], z = n.rotation[2], w = n.rotation[3];
        out = {{{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)},
                {0, 0, 0}}};
    }
    for (size_t j = 0; j < 3 && n.scale.size() == 3; j++)
        for (size_t i = 0; i < 3; i++) out.m[j][i] *= n.scale[j];
    for (size_t i = 0; i < 3 && n.translation.size() == 3; i++) out.m[3][i] = n.translation[i];
    return out;
}

// The cofactor matrix of the linear part: det(A) times its inverse transpose, which maps normals. Answers det(A).
double cofactors(double out[3][3], const affine &a)
{
    for (int j = 0; j < 3; j++) {
        const double *p = a.m[(j + 1) % 3], *q = a.m[(j + 2) % 3];
        for (int i = 0; i < 3; i++) out[j][i] = p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3];
    }
    return a.m[0][0] * out[0][0] + a.m[0][1] * out[0][1] + a.m[0][2] * out[0][2];
}

// ---- primitives ----

kn_material get_material(const reader *r, int index)
{
    kn_material out = {{1.0, 1.0, 1.0}, 1.0, 1.0}; // what glTF gives a primitive without a material
    if (index < 0 || static_cast<size_t>(index) >= r->model->materials.size()) return out;
    const tinygltf::PbrMetallicRoughness &p = r->model->materials[static_cast<size_t>(index)].pbrMetallicRoughness;
    auto unit = [](double x) { return x > 0.0 ? (x < 1.0 ? x : 1.0) : 0.0; };
    for (size_t c = 0; c < 3 && p.baseColorFactor.size() == 4; c++) out.base_color[c] = unit(p.baseColorFactor[c]);
    out.metallic = unit(p.metallicFactor), out.roughness = unit(p.roughnessFactor);
    return out;
}

kn_status fill_vertices(const reader *r, kn_mesh *mesh, const view *position, const view *normal, const affine &to)
{
    double n[3], p[3], k[3][3], sign = cofactors(k, to) < 0.0 ? -1.0 : 1.0;
    for (size_t v = 0; v < position->count; v++) {
        double *out = mesh->position + 3 * v;
        get_vector(position, v, p);
        for (int i = 0; i < 3; i++) {
            out[i] = to.m[0][i] * p[0] + to.m[1][i] * p[1] + to.m[2][i] * p[2] + to.m[3][i];
            if (!std::isfinite(out[i])) return kn_fail(r->ctx, KN_EPARSE, "%s: vertex %zu is not finite", r->path, v);
        }
        if (!normal) continue;
        out = mesh->normal + 3 * v;
        get_vector(normal, v, n);
        for (int i = 0; i < 3; i++) out[i] = sign * (k[0][i] * n[0] + k[1][i] * n[1] + k[2][i] * n[2]);
        double length = std::sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
        if (!std::isfinite(length)) return kn_fail(r->ctx, KN_EPARSE, "%s: normal %zu is not finite", r->path, v);
        for (int i = 0; i < 3 && length > 0.0; i++) out[i] /= length;
    }
    return KN_OK;
}

// Triangle t of a list, a strip or a fan, turned over where the transform mirrors.
kn_status fill_triangles(const reader *r, kn_mesh *mesh, const view *index, int mode, bool mirrored)
{
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        size_t corner[3] = {3 * t, 3 * t + 1, 3 * t + 2};
        if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) corner[0] = t, corner[1] = t + 1 + t % 2, corner[2] = t + 2 - t % 2;
        if (mode == TINYGLTF_MODE_TRIANGLE_FAN) corner[0] = t + 1, corner[1] = t + 2, corner[2] = 0;
        uint32_t *out = mesh->triangle + 3 * t;
        for (int k = 0; k < 3; k++) {
            out[k] = index ? get_index(index, corner[k]) : static_cast<uint32_t>(corner[k]);
            if (out[k] >= mesh->nvertices)
                return kn_fail(r->ctx, KN_EPARSE, "%s: triangle %zu has vertex %u of %zu", r->path, t, out[k],
                               mesh->nvertices);
        }
        if (mirrored) std::swap(out[1], out[2]);
    }
    return KN_OK;
}

kn_status fill_mesh(const reader *r, kn_mesh *mesh, const view *position, const view *normal, const view *index,
                    int mode, const affine &to)
{
    size_t nv = position->count, corners = index ? index->count : nv;
    size_t nt = mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
    if (nv > UINT32_MAX || (mode == TINYGLTF_MODE_TRIANGLES && corners % 3 != 0))
        return kn_fail(r->ctx, KN_EPARSE, "%s: %zu vertices, %zu corners of triangles", r->path, nv, corners);
    mesh->position = static_cast<double *>(kn_alloc(r->ctx, nv, 3 * sizeof(double)));
    mesh->normal = normal ? static_cast<double *>(kn_alloc(r->ctx, nv, 3 * sizeof(double))) : nullptr;
    mesh->triangle = static_cast<uint32_t *>(kn_alloc(r->ctx, nt, 3 * sizeof(uint32_t)));
    if (!mesh->position || !mesh->triangle || (normal && !mesh->normal)) return KN_ENOMEM;
    mesh->nvertices = mesh->vertex_room = nv, mesh->ntriangles = mesh->triangle_room = nt;
    double k[3][3];
    kn_status status = fill_vertices(r, mesh, position, normal, to);
    return status == KN_OK ? fill_triangles(r, mesh, index, mode, cofactors(k, to) < 0.0) : status;
}

// COLOR_0 without its opacity.
kn_status fill_colors(const reader *r, kn_scene_item *item, const tinygltf::Primitive &primitive)
{
    auto at = primitive.attributes.find("COLOR_0");
    size_t nv = item->mesh.nvertices, index = at == primitive.attributes.end() ? 0 : static_cast<size_t>(at->second);
    if (at == primitive.attributes.end() || item->mesh.ntriangles == 0) return KN_OK;
    if (at->second < 0 || index >= r->model->accessors.size()) return bad(r, "no accessor", at->second);
    int type = r->model->accessors[index].type == TINYGLTF_TYPE_VEC4 ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3;
    view color = {};
    kn_status status = get_view(r, &color, at->second, type);
    if (status != KN_OK) return status;
    if (color.count != nv || color.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        return bad(r, "colours do not fit in accessor", at->second);
    item->color = static_cast<float *>(kn_alloc(r->ctx, nv, 3 * sizeof(float)));
    if (!item->color) return KN_ENOMEM;
    for (size_t v = 0; v < nv; v++)
        for (size_t c = 0; c < 3; c++) item->color[3 * v + c] = get_channel(&color, v, c);
    return KN_OK;
}

kn_status add_item(reader *r, kn_scene_item *item)
{
    if (r->scene.nitems == r->room) {
        int room = r->room ? 2 * r->room : 8;
        size_t n = static_cast<size_t>(room);
        void *p = r->scene.items ? kn_resize(r->ctx, r->scene.items, n, sizeof *item)
                                 : kn_alloc(r->ctx, n, sizeof *item);
        if (!p) return KN_ENOMEM;
        r->scene.items = static_cast<kn_scene_item *>(p), r->room = room;
    }
    r->scene.items[r->scene.nitems++] = *item;
    return KN_OK;
}

kn_status add_primitive(reader *r, const tinygltf::Primitive &primitive, const affine &to)
{
    int mode = primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP && mode != TINYGLTF_MODE_TRIANGLE_FAN)
        return KN_OK;
    auto position_at = primitive.attributes.find("POSITION"), normal_at = primitive.attributes.find("NORMAL");
    bool has_normal = normal_at != primitive.attributes.end(), has_index = primitive.indices >= 0;
    if (position_at == primitive.attributes.end()) return KN_OK; // nothing to draw, says the specification
    view position = {}, normal = {}, index = {};
    kn_status status = get_view(r, &position, position_at->second, TINYGLTF_TYPE_VEC3);
    if (status == KN_OK && has_normal) status = get_view(r, &normal, normal_at->second, TINYGLTF_TYPE_VEC3);
    if (status == KN_OK && has_index) status = get_view(r, &index, primitive.indices, TINYGLTF_TYPE_SCALAR);
    if (status != KN_OK) return status;
    const int real = TINYGLTF_COMPONENT_TYPE_FLOAT;
    if (position.component != real || (has_normal && (normal.component != real || normal.count != position.count)))
        return bad(r, "positions and normals do not fit in accessor", position_at->second);
    if (has_index && index.component == real)
        return bad(r, "indices are not integers in accessor", primitive.indices);

    kn_scene_item item = {};
    item.material = get_material(r, primitive.material);
    status = fill_mesh(r, &item.mesh, &position, has_normal ? &normal : nullptr, has_index ? &index : nullptr, mode,
                       to);
    if (status == KN_OK) status = fill_colors(r, &item, primitive);
    if (status == KN_OK && item.mesh.ntriangles > 0) {
        status = add_item(r, &item);
        if (status == KN_OK) item = kn_scene_item{};
    }
    kn_scene_item_clear(r->ctx, &item);
    return status;
}

// ---- nodes ----

struct visit {
    int node;
    affine to;
};

// The roots: of the default scene, else of the first, else every node that is nobody's child.
std::vector<int> roots(const tinygltf::Model &m)
{
    size_t scene = m.defaultScene >= 0 ? static_cast<size_t>(m.defaultScene) : 0;
    if (scene < m.scenes.size()) return m.scenes[scene].nodes;
    std::vector<bool> child(m.nodes.size(), false);
    for (const tinygltf::Node &n : m.nodes)
        for (int c : n.children)
            if (c >= 0 && static_cast<size_t>(c) < child.size()) child[static_cast<size_t>(c)] = true;
    std::vector<int> out;
    for (size_t i = 0; i < child.size(); i++)
        if (!child[i]) out.push_back(static_cast<int>(i));
    return out;
}

// Depth first without recursion, children in their order. A node that is met twice breaks the tree: refused.
kn_status add_nodes(reader *r)
{
    const tinygltf::Model &m = *r->model;
    const affine identity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};
    std::vector<visit> stack;
    std::vector<bool> seen(m.nodes.size(), false);
    std::vector<int> first = roots(m);
    for (size_t i = first.size(); i-- > 0;) stack.push_back(visit{first[i], identity});
    while (!stack.empty()) {
        visit v = stack.back();
        stack.pop_back();
        if (v.node < 0 || static_cast<size_t>(v.node) >= m.nodes.size()) return bad(r, "no node", v.node);
        if (seen[static_cast<size_t>(v.node)]) return bad(r, "not a tree at node", v.node);
        seen[static_cast<size_t>(v.node)] = true;
        const tinygltf::Node &n = m.nodes[static_cast<size_t>(v.node)];
        affine to = multiply(v.to, node_transform(n));
        if (n.mesh >= 0) {
            if (static_cast<size_t>(n.mesh) >= m.meshes.size()) return bad(r, "no mesh", n.mesh);
            for (const tinygltf::Primitive &p : m.meshes[static_cast<size_t>(n.mesh)].primitives) {
                kn_status status = add_primitive(r, p, to);
                if (status != KN_OK) return status;
            }
        }
        for (size_t i = n.children.size(); i-- > 0;) stack.push_back(visit{n.children[i], to});
    }
    return KN_OK;
}

// ---- the file ----

// tinygltf's message on one line.
kn_status fail_parse(const reader *r, const std::string &message)
{
    std::string line;
    for (char c : message) line += c == '\n' || c == '\r' || c == '\t' ? ' ' : c;
    while (!line.empty() && line.back() == ' ') line.pop_back();
    return kn_fail(r->ctx, KN_EPARSE, "%s: %s", r->path, line.empty() ? "not a glTF file" : line.c_str());
}

bool nested_too_deeply(const char *text, size_t bytes)
{
    int depth = 0;
    bool quoted = false;
    for (size_t i = 0; i < bytes; i++) {
        if (quoted && text[i] == '\\') {
            i++;
        } else if (text[i] == '"') {
            quoted = !quoted;
        } else if (!quoted && (text[i] == '[' || text[i] == '{')) {
            if (++depth > MAX_NESTING) return true;
        } else if (!quoted && (text[i] == ']' || text[i] == '}')) {
            depth--;
        }
    }
    return false;
}

bool ignore_image(tinygltf::Image *, const int, std::string *, std::string *, int, int, const unsigned char *, int,
                  void *)
{
    return true;
}

// The JSON of a .glb is its first chunk, whose length stands at byte 12; of a .gltf the whole file.
kn_status load(const reader *r, tinygltf::Model *model, const char *text, size_t bytes)
{
    bool binary = bytes >= 4 && !memcmp(text, "glTF", 4);
    size_t at = 0, length = bytes;
    if (bytes > UINT32_MAX) return kn_fail(r->ctx, KN_ELIMIT, "%s: more than 4 GiB", r->path);
    if (binary && bytes >= 20) {
        uint32_t json;
        memcpy(&json, text + 12, 4);
        at = 20, length = json < bytes - 20 ? json : bytes - 20;
    }
    if (nested_too_deeply(text + at, length)) return fail_parse(r, "JSON nested too deeply");
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(ignore_image, nullptr);
    const char *slash = strrchr(r->path, '/');
    std::string error, warning, folder = slash ? std::string(r->path, slash) : std::string(".");
    unsigned int size = static_cast<unsigned int>(bytes);
    bool ok = binary ? loader.LoadBinaryFromMemory(model, &error, &warning,
                                                   reinterpret_cast<const unsigned char *>(text), size, folder)
                     : loader.LoadASCIIFromString(model, &error, &warning, text, size, folder);
    if (!ok || !error.empty()) return fail_parse(r, error);
    if (model->asset.version.compare(0, 2, "2.") != 0) return fail_parse(r, "not glTF 2");
    if (!model->extensionsRequired.empty())
        return fail_parse(r, "requires the extension " + model->extensionsRequired[0]);
    return KN_OK;
}

kn_status read_scene(reader *r, const char *text, size_t bytes)
{
    try {
        tinygltf::Model model;
        kn_status status = load(r, &model, text, bytes);
        r->model = &model;
        if (status == KN_OK) status = add_nodes(r);
        r->model = nullptr;
        return status;
    } catch (const std::bad_alloc &) {
        return kn_fail(r->ctx, KN_ENOMEM, "%s: no memory for the file's contents", r->path);
    } catch (const std::exception &e) {
        return fail_parse(r, e.what());
    }
}

} // namespace

kn_status kn_gltf_read(kn_ctx *ctx, kn_scene *out, const char *path)
{
    char *text = nullptr;
    size_t bytes = 0;
    kn_status status = kn_in_read(ctx, &text, &bytes, path);
    if (status != KN_OK) return status;
    reader r = {ctx, path, nullptr, kn_scene{}, 0};
    status = read_scene(&r, text, bytes);
    if (status == KN_OK) {
        kn_scene old = *out;
        *out = r.scene, r.scene = old;
    }
    kn_scene_clear(ctx, &r.scene);
    kn_free(ctx, text);
    return status;
}
