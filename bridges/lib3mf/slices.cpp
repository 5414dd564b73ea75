// SPDX-License-Identifier: Apache-2.0
// kn_3mf_slices_*: lib3mf's slice stacks.
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <new>
#include <vector>

#include <lib3mf/Model/COM/NMR_DLLInterfaces.h>

#include "bridges/lib3mf/slices.h"
extern "C" {
#include "io/out_file.h"
#include "kernel/context.h"
}

struct kn_3mf_slices {
    NMR::PLib3MFModel *model = nullptr;
    NMR::PLib3MFModelMeshObject *object = nullptr;
    NMR::PLib3MFSliceStack *stack = nullptr;
    kn_out_file *file = nullptr;
    double unit = 1.0, bottom = 0.0, above = 0.0, top = 0.0; // of z, millimetres
    float lo[2] = {FLT_MAX, FLT_MAX}, hi[2] = {-FLT_MAX, -FLT_MAX};
    uint64_t hash = UINT64_C(0xcbf29ce484222325); // of all points and layers, FNV-1a
};

namespace
{

kn_status refused(kn_ctx *ctx, NMR::PLib3MFBase *instance, const char *what)
{
    DWORD code = 0;
    LPCSTR message = nullptr;
    if (instance) NMR::lib3mf_getlasterror(instance, &code, &message);
    return kn_fail(ctx, KN_EIO, "3MF: %s: %s", what, message ? message : "lib3mf refuses");
}

void add_to_hash(kn_3mf_slices *s, const void *data, size_t bytes)
{
    const unsigned char *c = static_cast<const unsigned char *>(data);
    for (size_t i = 0; i < bytes; i++) s->hash = (s->hash ^ c[i]) * UINT64_C(0x100000001b3);
}

// A UUID (of version 8) that follows from what is written and from what it names: the same file for the same slices.
struct uuid {
    char text[40];
};
uuid make_uuid(const kn_3mf_slices *s, uint64_t what)
{
    uuid out;
    uint64_t a = (s->hash ^ what) * UINT64_C(0x9e3779b97f4a7c15), b = (a ^ a >> 31) * UINT64_C(0xbf58476d1ce4e5b9);
    std::snprintf(out.text, sizeof out.text, "%08x-%04x-8%03x-9%03x-%012llx", static_cast<unsigned>(a >> 32),
                  static_cast<unsigned>(a >> 16 & 0xffff), static_cast<unsigned>(a & 0xfff),
                  static_cast<unsigned>(b >> 52), static_cast<unsigned long long>(b & UINT64_C(0xffffffffffff)));
    return out;
}

kn_status open_model(kn_ctx *ctx, kn_3mf_slices *s)
{
    if (NMR::lib3mf_createmodel(&s->model)) return refused(ctx, nullptr, "a model");
    if (NMR::lib3mf_model_setunit(s->model, NMR::MODELUNIT_MILLIMETER)) return refused(ctx, s->model, "its unit");
    if (NMR::lib3mf_model_addslicestack(s->model, static_cast<float>(s->bottom), &s->stack))
        return refused(ctx, s->model, "a stack of slices");
    if (NMR::lib3mf_model_addmeshobject(s->model, &s->object)) return refused(ctx, s->model, "an object");
    return KN_OK;
}

kn_status add_loop(kn_ctx *ctx, kn_3mf_slices *s, NMR::PLib3MFSlice *slice, const kn_slice_loop &loop)
{
    std::vector<NMR::MODELSLICEVERTEX> vertices;
    for (size_t i = 0; i < loop.npoints; i++) {
        NMR::MODELSLICEVERTEX v;
        for (int d = 0; d < 2; d++) {
            double x = loop.points[2 * i + static_cast<size_t>(d)] * s->unit;
            if (!(std::fabs(x) <= static_cast<double>(FLT_MAX)))
                return kn_fail(ctx, KN_EDOMAIN, "3MF: a coordinate %g is beyond single precision", x);
            v.m_fPosition[d] = static_cast<float>(x);
            s->lo[d] = v.m_fPosition[d] < s->lo[d] ? v.m_fPosition[d] : s->lo[d];
            s->hi[d] = v.m_fPosition[d] > s->hi[d] ? v.m_fPosition[d] : s->hi[d];
        }
        bool same = !vertices.empty() && std::memcmp(&vertices.back(), &v, sizeof v) == 0;
        if (!same) vertices.push_back(v);
    }
    while (vertices.size() > 1 && std::memcmp(&vertices.back(), &vertices.front(), sizeof vertices.front()) == 0)
        vertices.pop_back();
    if (vertices.size() < 3) return KN_OK; // thinner than single precision tells
    add_to_hash(s, vertices.data(), vertices.size() * sizeof vertices[0]);
    DWORD first = 0, polygon = 0;
    if (NMR::lib3mf_slice_addvertices(slice, vertices.data(), static_cast<DWORD>(vertices.size()), &first))
        return refused(ctx, slice, "vertices");
    std::vector<DWORD> indices;
    for (size_t i = 0; i < vertices.size(); i++) indices.push_back(first + static_cast<DWORD>(i));
    indices.push_back(first);
    if (NMR::lib3mf_slice_addpolygon(slice, indices.data(), static_cast<DWORD>(indices.size()), &polygon))
        return refused(ctx, slice, "a polygon");
    return KN_OK;
}

// The box around everything, for who knows no slices.
kn_status add_box(kn_ctx *ctx, kn_3mf_slices *s)
{
    NMR::MODELMESHVERTEX corner[8];
    float z[2] = {static_cast<float>(s->bottom), static_cast<float>(s->top)};
    bool empty = s->lo[0] >= s->hi[0] || s->lo[1] >= s->hi[1] || z[0] >= z[1];
    for (int i = 0; i < 8; i++) {
        corner[i].m_fPosition[0] = empty ? static_cast<float>(i & 1) : i & 1 ? s->hi[0] : s->lo[0];
        corner[i].m_fPosition[1] = empty ? static_cast<float>(i >> 1 & 1) : i >> 1 & 1 ? s->hi[1] : s->lo[1];
        corner[i].m_fPosition[2] = empty ? static_cast<float>(i >> 2) : z[i >> 2];
    }
    static const DWORD faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    NMR::MODELMESHTRIANGLE triangle[12];
    for (int i = 0; i < 12; i++)
        for (int k = 0; k < 3; k++) triangle[i].m_nIndices[k] = faces[i][k];
    if (NMR::lib3mf_meshobject_setgeometry(s->object, corner, 8, triangle, 12))
        return refused(ctx, s->object, "the box");
    return KN_OK;
}

kn_status write_model(kn_ctx *ctx, kn_3mf_slices *s)
{
    NMR::PLib3MFModelBuildItem *item = nullptr;
    NMR::PLib3MFModelWriter *writer = nullptr;
    kn_status status = add_box(ctx, s);
    if (status == KN_OK && NMR::lib3mf_meshobject_setslicestack(s->object, s->stack))
        status = refused(ctx, s->object, "slices of the object");
    if (status == KN_OK &&
        NMR::lib3mf_meshobject_setslicesmeshresolution(s->object, NMR::MODELSLICESMESHRESOLUTION_LOW))
        status = refused(ctx, s->object, "the resolution");
    if (status == KN_OK && NMR::lib3mf_model_addbuilditem(s->model, s->object, nullptr, &item))
        status = refused(ctx, s->model, "the build");
    if (status == KN_OK && (NMR::lib3mf_object_setuuidutf8(s->object, make_uuid(s, 1).text) ||
                            NMR::lib3mf_builditem_setuuidutf8(item, make_uuid(s, 2).text) ||
                            NMR::lib3mf_model_setbuilduuidutf8(s->model, make_uuid(s, 3).text)))
        status = refused(ctx, s->model, "identifiers");
    if (status == KN_OK && NMR::lib3mf_model_querywriter(s->model, "3mf", &writer))
        status = refused(ctx, s->model, "a writer");
    ULONG64 size = 0;
    if (status == KN_OK && NMR::lib3mf_writer_getstreamsize(writer, &size)) status = refused(ctx, writer, "its size");
    if (status == KN_OK) {
        std::vector<BYTE> bytes(static_cast<size_t>(size));
        if (NMR::lib3mf_writer_writetobuffer(writer, bytes.data(), size))
            status = refused(ctx, writer, "writing");
        else
            status = kn_out_write(ctx, s->file, bytes.data(), bytes.size());
    }
    if (writer) NMR::lib3mf_release(writer);
    if (item) NMR::lib3mf_release(item);
    return status == KN_OK ? kn_out_commit(ctx, s->file) : status;
}

} // namespace

kn_status kn_3mf_slices_create(kn_ctx *ctx, kn_3mf_slices **out, const char *path, double unit_mm, double bottom,
                               double above)
{
    if (!(unit_mm > 0.0) || !std::isfinite(unit_mm) || !std::isfinite(bottom) || !std::isfinite(above))
        return kn_fail(ctx, KN_EDOMAIN, "3MF: a unit of %g mm, from z = %g", unit_mm, bottom);
    kn_3mf_slices *s = new (std::nothrow) kn_3mf_slices;
    if (!s) return kn_fail(ctx, KN_ENOMEM, "3MF: out of memory");
    s->unit = unit_mm;
    s->bottom = s->top = bottom * unit_mm;
    s->above = above * unit_mm;
    kn_status status = kn_out_open(ctx, &s->file, path);
    if (status == KN_OK) status = open_model(ctx, s);
    if (status == KN_OK)
        *out = s;
    else
        kn_3mf_slices_destroy(ctx, s);
    return status;
}

kn_status kn_3mf_slices_add(kn_ctx *ctx, void *stack, const kn_slice *layer)
{
    kn_3mf_slices *s = static_cast<kn_3mf_slices *>(stack);
    NMR::PLib3MFSlice *slice = nullptr;
    double z = layer->z * s->unit + s->above;
    if (!(static_cast<float>(z) > static_cast<float>(s->top)))
        return kn_fail(ctx, KN_EDOMAIN, "3MF: layer %zu at z = %g mm does not lie above the one before it",
                       layer->index, z);
    if (NMR::lib3mf_slicestack_addslice(s->stack, static_cast<float>(z), &slice))
        return refused(ctx, s->stack, "a slice");
    s->top = z;
    add_to_hash(s, &z, sizeof z);
    kn_status status = KN_OK;
    try {
        for (size_t i = 0; status == KN_OK && i < layer->nloops; i++)
            if (layer->loops[i].closed) status = add_loop(ctx, s, slice, layer->loops[i]);
    } catch (const std::bad_alloc &) {
        status = kn_fail(ctx, KN_ENOMEM, "3MF: out of memory");
    }
    NMR::lib3mf_release(slice);
    return status;
}

kn_status kn_3mf_slices_write(kn_ctx *ctx, kn_3mf_slices *s, size_t *bytes)
{
    try {
        kn_status status = write_model(ctx, s);
        if (status == KN_OK && bytes) *bytes = kn_out_bytes(s->file);
        return status;
    } catch (const std::bad_alloc &) {
        return kn_fail(ctx, KN_ENOMEM, "3MF: out of memory");
    }
}

void kn_3mf_slices_destroy(kn_ctx *ctx, kn_3mf_slices *s)
{
    if (!s) return;
    if (s->stack) NMR::lib3mf_release(s->stack);
    if (s->object) NMR::lib3mf_release(s->object);
    if (s->model) NMR::lib3mf_release(s->model);
    kn_out_close(ctx, s->file);
    delete s;
}

namespace
{

kn_status look_at_stack(kn_ctx *ctx, kn_3mf_slices_facts *out, NMR::PLib3MFSliceStack *stack)
{
    DWORD slices = 0;
    if (NMR::lib3mf_slicestack_getslicecount(stack, &slices)) return refused(ctx, stack, "slices");
    out->slices = slices;
    for (DWORD i = 0; i < slices; i++) {
        NMR::PLib3MFSlice *slice = nullptr;
        DWORD vertices = 0, polygons = 0;
        float top = 0;
        if (NMR::lib3mf_slicestack_getslice(stack, i, &slice)) return refused(ctx, stack, "a slice");
        bool bad = NMR::lib3mf_slice_getvertexcount(slice, &vertices) ||
                   NMR::lib3mf_slice_getpolygoncount(slice, &polygons) || NMR::lib3mf_slice_gettopz(slice, &top);
        NMR::lib3mf_release(slice);
        if (bad) return refused(ctx, nullptr, "a slice");
        out->vertices += vertices;
        out->polygons += polygons;
        out->top = static_cast<double>(top);
    }
    return KN_OK;
}

} // namespace

kn_status kn_3mf_slices_look(kn_ctx *ctx, kn_3mf_slices_facts *out, const char *path)
{
    NMR::PLib3MFModel *model = nullptr;
    NMR::PLib3MFModelReader *reader = nullptr;
    NMR::PLib3MFModelResourceIterator *list = nullptr;
    NMR::PLib3MFModelResource *object = nullptr;
    NMR::PLib3MFSliceStack *stack = nullptr;
    kn_3mf_slices_facts facts = {0, 0, 0, 0.0};
    BOOL more = 0;
    DWORD id = 0;
    bool bad = NMR::lib3mf_createmodel(&model) || NMR::lib3mf_model_queryreader(model, "3mf", &reader) ||
               NMR::lib3mf_reader_readfromfileutf8(reader, path) || NMR::lib3mf_model_getmeshobjects(model, &list) ||
               NMR::lib3mf_resourceiterator_movenext(list, &more) || !more ||
               NMR::lib3mf_resourceiterator_getcurrent(list, &object) ||
               NMR::lib3mf_meshobject_getslicestackid(object, &id) ||
               NMR::lib3mf_model_getslicestackById(model, id, &stack);
    kn_status status = bad ? refused(ctx, reader, path) : look_at_stack(ctx, &facts, stack);
    if (status == KN_OK) *out = facts;
    if (stack) NMR::lib3mf_release(stack);
    if (object) NMR::lib3mf_release(object);
    if (list) NMR::lib3mf_release(list);
    if (reader) NMR::lib3mf_release(reader);
    if (model) NMR::lib3mf_release(model);
    return status;
}
