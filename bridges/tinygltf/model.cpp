// SPDX-License-Identifier: Apache-2.0
// Float32 meshes become a glTF file through tinygltf.
#include <cfloat>
#include <cmath>
#include <cstring>
#include <new>
#include <ostream>
#include <streambuf>
#include <strings.h>

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include "bridges/tinygltf/model.h"

namespace
{

using namespace kng;

// The writer takes a value of its own kind.
tinygltf::Value to_value(const nlohmann::json &from)
{
    if (from.is_boolean()) return tinygltf::Value(from.get<bool>());
    if (from.is_number_integer()) return tinygltf::Value(from.get<int>());
    if (from.is_number()) return tinygltf::Value(from.get<double>());
    if (from.is_string()) return tinygltf::Value(from.get<std::string>());
    if (from.is_array()) {
        tinygltf::Value::Array array;
        for (const nlohmann::json &item : from) array.push_back(to_value(item));
        return tinygltf::Value(array);
    }
    tinygltf::Value::Object object;
    for (const auto &item : from.items()) object[item.key()] = to_value(item.value());
    return tinygltf::Value(object);
}

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

void set_range(tinygltf::Accessor *a, const float *vertex, size_t count, size_t step = 6)
{
    for (size_t c = 0; c < 3; c++) {
        float lo = vertex[c], hi = vertex[c];
        for (size_t i = 1; i < count; i++) {
            lo = vertex[step * i + c] < lo ? vertex[step * i + c] : lo;
            hi = vertex[step * i + c] > hi ? vertex[step * i + c] : hi;
        }
        a->minValues.push_back(static_cast<double>(lo)), a->maxValues.push_back(static_cast<double>(hi));
    }
}

// What is no UTF-8 in a name, of a file's for one, becomes U+FFFD: JSON holds no other text.
std::string valid(const char *name)
{
    const auto replace = nlohmann::json::error_handler_t::replace;
    return nlohmann::json::parse(nlohmann::json(name).dump(-1, ' ', false, replace)).get<std::string>();
}

int add_material(tinygltf::Model *model, const part *p)
{
    tinygltf::Material m;
    const double *c = p->material.base_color;
    m.name = valid(p->name);
    m.doubleSided = true; // tiles may be open sheets
    m.pbrMetallicRoughness.baseColorFactor = {c[0], c[1], c[2], 1.0};
    m.pbrMetallicRoughness.metallicFactor = p->material.metallic;
    m.pbrMetallicRoughness.roughnessFactor = p->material.roughness;
    model->materials.push_back(m);
    return static_cast<int>(model->materials.size()) - 1;
}

// Indices are 16 bits wide where they fit; 65535 itself is reserved for primitive restart.
int add_indices(tinygltf::Model *model, const uint32_t *index, size_t n, size_t nvertices)
{
    if (nvertices > 65535) {
        add_view(model, index, 4 * n, 0, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
        return add_accessor(model, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, 0, n);
    }
    std::vector<uint16_t> narrow(n);
    for (size_t i = 0; i < n; i++) narrow[i] = static_cast<uint16_t>(index[i]);
    add_view(model, narrow.data(), 2 * n, 0, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    return add_accessor(model, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_SCALAR, 0, n);
}

// Views and accessors of a part's morph targets.
void add_targets(tinygltf::Model *model, tinygltf::Primitive *primitive, const part *p)
{
    size_t n = p->mesh.nvertices;
    for (size_t k = 0; k < p->ntargets; k++) {
        const float *moves = p->targets + 6 * n * k;
        add_view(model, moves, 24 * n, 24, TINYGLTF_TARGET_ARRAY_BUFFER);
        std::map<std::string, int> target;
        int position = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 0, n);
        set_range(&model->accessors[static_cast<size_t>(position)], moves, n);
        target["POSITION"] = position;
        target["NORMAL"] = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 12, n);
        primitive->targets.push_back(target);
    }
}

// One time after another each target alone counts: the first time is that of the mesh as it is.
void add_animation(tinygltf::Model *model, size_t ntargets, double seconds)
{
    std::vector<float> times(ntargets + 1), weights((ntargets + 1) * ntargets, 0.0f);
    for (size_t k = 0; k <= ntargets; k++) {
        times[k] = static_cast<float>(seconds * static_cast<double>(k) / static_cast<double>(ntargets));
        if (k > 0) weights[k * ntargets + k - 1] = 1.0f;
    }
    add_view(model, times.data(), 4 * times.size(), 0, 0);
    int input = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, 0, times.size());
    tinygltf::Accessor *a = &model->accessors[static_cast<size_t>(input)];
    a->minValues.push_back(0.0), a->maxValues.push_back(static_cast<double>(times.back()));
    add_view(model, weights.data(), 4 * weights.size(), 0, 0);
    int output = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, 0, weights.size());
    tinygltf::Animation animation;
    animation.name = "time";
    tinygltf::AnimationSampler sampler;
    sampler.input = input, sampler.output = output, sampler.interpolation = "LINEAR";
    animation.samplers.push_back(sampler);
    for (size_t i = 0; i < model->nodes.size(); i++) {
        if (model->nodes[i].mesh < 0) continue;
        tinygltf::AnimationChannel channel;
        channel.sampler = 0, channel.target_node = static_cast<int>(i), channel.target_path = "weights";
        animation.channels.push_back(channel);
    }
    model->animations.push_back(animation);
}

tinygltf::Primitive triangles_of(tinygltf::Model *model, const part *p)
{
    const chunk *c = &p->mesh;
    add_view(model, c->vertex, 24 * c->nvertices, 24, TINYGLTF_TARGET_ARRAY_BUFFER);
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    int position = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 0, c->nvertices);
    set_range(&model->accessors[static_cast<size_t>(position)], c->vertex, c->nvertices);
    primitive.attributes["POSITION"] = position;
    primitive.attributes["NORMAL"] = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 12,
                                                  c->nvertices);
    if (c->color) {
        add_view(model, c->color, 12 * c->nvertices, 12, TINYGLTF_TARGET_ARRAY_BUFFER);
        primitive.attributes["COLOR_0"] = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 0,
                                                       c->nvertices);
    }
    primitive.indices = add_indices(model, c->triangle, 3 * c->ntriangles, c->nvertices);
    add_targets(model, &primitive, p);
    return primitive;
}

// All curves of a part: segments of one primitive, for one of each curve (a line strip) would need an accessor each.
tinygltf::Primitive lines_of(tinygltf::Model *model, const lines *l)
{
    std::vector<uint32_t> ends;
    ends.reserve(2 * (l->npoints - l->nlines));
    uint32_t at = 0;
    for (size_t k = 0; k < l->nlines; at += l->length[k++])
        for (uint32_t i = 0; i + 1 < l->length[k]; i++) ends.push_back(at + i), ends.push_back(at + i + 1);
    add_view(model, l->point, 12 * l->npoints, 12, TINYGLTF_TARGET_ARRAY_BUFFER);
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_LINE;
    int position = add_accessor(model, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 0, l->npoints);
    set_range(&model->accessors[static_cast<size_t>(position)], l->point, l->npoints, 3);
    primitive.attributes["POSITION"] = position;
    primitive.indices = add_indices(model, ends.data(), ends.size(), l->npoints);
    return primitive;
}

void add_part(tinygltf::Model *model, const part *p)
{
    if (model->buffers.empty()) model->buffers.emplace_back();

    tinygltf::Mesh mesh;
    mesh.name = valid(p->name);
    mesh.weights.assign(p->ntargets, 0.0);
    if (p->mesh.ntriangles > 0) mesh.primitives.push_back(triangles_of(model, p));
    if (p->curves.nlines > 0) mesh.primitives.push_back(lines_of(model, &p->curves));
    const int material = add_material(model, p);
    for (tinygltf::Primitive &primitive : mesh.primitives) primitive.material = material;
    tinygltf::Node node;
    node.name = valid(p->name);
    node.mesh = static_cast<int>(model->meshes.size());
    model->meshes.push_back(mesh);
    model->nodes[0].children.push_back(static_cast<int>(model->nodes.size()));
    model->nodes.push_back(node);
}

// The root turns (x, y, z) into (x, z, -y), a quarter turn about x, and length units into metres.
void add_root(tinygltf::Model *model, const file_options *o)
{
    tinygltf::Node root;
    const double metres = o->unit_mm * 1e-3, half = std::sqrt(0.5);
    root.name = valid(o->name);
    root.rotation = {-half, 0.0, 0.0, half};
    root.scale = {metres, metres, metres};
    model->nodes.push_back(root);
    tinygltf::Scene scene;
    scene.name = valid(o->name);
    scene.nodes.push_back(0);
    model->scenes.push_back(scene);
    model->defaultScene = 0;
    model->asset.version = "2.0";
    model->asset.generator = "knurl " KN_VERSION_STRING;
    if (o->extras) model->asset.extras = to_value(nlohmann::json::parse(o->extras));
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

kn_status write_model(kn_ctx *ctx, kn_out_file *file, const file_options *o, part *parts, int nparts)
{
    size_t total = 0, ntargets = 0;
    for (int i = 0; i < nparts; i++)
        total += ((parts[i].mesh.color ? 36 : 24) + 24 * parts[i].ntargets) * parts[i].mesh.nvertices +
                 12 * parts[i].mesh.ntriangles + 20 * parts[i].curves.npoints + 4;
    if (total > UINT32_MAX - (1u << 20)) // leaves room for the JSON: the lengths in a .glb have 32 bits
        return kn_fail(ctx, KN_ELIMIT, "gltf: %zu bytes of mesh, more than a glTF file holds", total);
    tinygltf::Model model;
    add_root(&model, o);
    for (int i = 0; i < nparts; i++) {
        if (parts[i].mesh.ntriangles + parts[i].curves.nlines == 0) continue; // an accessor must not be empty
        if (model.buffers.empty()) model.buffers.emplace_back(), model.buffers[0].data.reserve(total);
        add_part(&model, parts + i);
        ntargets = parts[i].ntargets;
        clear_chunk(ctx, &parts[i].mesh);
        clear_lines(ctx, &parts[i].curves);
    }
    if (ntargets > 0) add_animation(&model, ntargets, o->seconds);
    out_buffer buffer(ctx, file);
    std::ostream stream(&buffer);
    tinygltf::TinyGLTF writer;
    bool ok = writer.WriteGltfSceneToStream(&model, stream, false, o->binary);
    if (buffer.status() != KN_OK) return buffer.status();
    if (!ok || !stream.good()) return kn_fail(ctx, KN_EIO, "gltf: the file could not be written");
    return KN_OK;
}

bool ends_in(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    return n > m && !strcasecmp(path + n - m, ending);
}

} // namespace

namespace kng
{

void clear_chunk(kn_ctx *ctx, chunk *c)
{
    kn_free(ctx, c->vertex);
    kn_free(ctx, c->triangle);
    kn_free(ctx, c->color);
    *c = chunk{};
}

void clear_lines(kn_ctx *ctx, lines *l)
{
    kn_free(ctx, l->point);
    kn_free(ctx, l->length);
    *l = lines{};
}

bool reserve_lines(kn_ctx *ctx, lines *l, size_t npoints, size_t nlines)
{
    if (npoints > l->point_room) {
        size_t room = npoints > 2 * l->point_room ? npoints : 2 * l->point_room;
        void *p = l->point ? kn_resize(ctx, l->point, room, 12) : kn_alloc(ctx, room, 3 * sizeof(float));
        if (!p) return false;
        l->point = static_cast<float *>(p), l->point_room = room;
    }
    if (nlines > l->line_room) {
        size_t room = nlines > 2 * l->line_room ? nlines : 2 * l->line_room;
        void *p = l->length ? kn_resize(ctx, l->length, room, 4) : kn_alloc(ctx, room, sizeof(uint32_t));
        if (!p) return false;
        l->length = static_cast<uint32_t *>(p), l->line_room = room;
    }
    return true;
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

kn_status check_file(kn_ctx *ctx, const char *path, bool *binary, double *unit_mm)
{
    if (!ends_in(path, ".glb") && !ends_in(path, ".gltf"))
        return kn_fail(ctx, KN_EDOMAIN, "gltf: %s ends neither in .glb nor in .gltf", path);
    if (!(*unit_mm >= 0.0 && std::isfinite(*unit_mm)))
        return kn_fail(ctx, KN_EDOMAIN, "gltf: %g millimetres in a unit", *unit_mm);
    if (*unit_mm == 0.0) *unit_mm = 1.0;
    *binary = ends_in(path, ".glb");
    return KN_OK;
}

kn_status write_file(kn_ctx *ctx, kn_out_file *file, const file_options *options, part *parts, int nparts)
{
    kn_status status = KN_OK;
    try {
        status = write_model(ctx, file, options, parts, nparts);
    } catch (const std::bad_alloc &) {
        return kn_fail(ctx, KN_ENOMEM, "gltf: no memory for the file's contents");
    } catch (const std::exception &e) {
        return kn_fail(ctx, KN_EIO, "gltf: %s", e.what());
    }
    if (status != KN_OK) return status;
    return kn_out_commit(ctx, file);
}

} // namespace kng
