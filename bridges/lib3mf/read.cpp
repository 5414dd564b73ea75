// SPDX-License-Identifier: Apache-2.0
// kn_3mf_read: the build items of a 3MF file, walked through their components.
#include <cmath>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <vector>

#include <Model/COM/NMR_DLLInterfaces.h>

#include "bridges/lib3mf/read.h"
extern "C" {
#include "io/in_file.h"
#include "kernel/context.h"
}

namespace
{

const int DEEPEST = 32;
const size_t MOST = 0x7fffffff;

struct release {
    void operator()(void *p) const
    {
        NMR::lib3mf_release(static_cast<NMR::PLib3MFBase *>(p));
    }
};
using handle = std::unique_ptr<void, release>;

// Column-major, as the format multiplies rows: p' = sum over k of p_k m[k] + m[3].
struct affine {
    double m[4][3];
};

struct reader {
    kn_ctx *ctx;
    const char *path;
    std::vector<double> position;
    std::vector<uint32_t> triangle;
};

kn_status fail(const reader *r, NMR::PLib3MFBase *object)
{
    DWORD code = 0;
    LPCSTR message = nullptr;
    bool known = object && NMR::lib3mf_getlasterror(object, &code, &message) == 0 && message;
    return kn_fail(r->ctx, KN_EPARSE, "%s: %s", r->path, known ? message : "lib3mf cannot read it");
}

affine transform_of(const NMR::MODELTRANSFORM &t)
{
    affine out;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 4; k++) out.m[k][i] = static_cast<double>(t.m_fFields[i][k]);
    return out;
}

// First inner, then outer.
affine multiply(const affine &outer, const affine &inner)
{
    affine out;
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 3; i++) {
            double sum = k == 3 ? outer.m[3][i] : 0.0;
            for (int j = 0; j < 3; j++) sum += outer.m[j][i] * inner.m[k][j];
            out.m[k][i] = sum;
        }
    return out;
}

bool mirrors(const affine &a)
{
    const double(*m)[3] = a.m;
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) <
           0.0;
}

kn_status add_vertices(reader *r, NMR::PLib3MFModelMeshObject *mesh, DWORD n, const affine &to)
{
    for (DWORD i = 0; i < n; i++) {
        NMR::MODELMESHVERTEX v;
        if (NMR::lib3mf_meshobject_getvertex(mesh, i, &v) != 0) return fail(r, mesh);
        for (int c = 0; c < 3; c++) {
            double x = to.m[3][c];
            for (int k = 0; k < 3; k++) x += to.m[k][c] * static_cast<double>(v.m_fPosition[k]);
            if (!std::isfinite(x)) return kn_fail(r->ctx, KN_EPARSE, "%s: vertex %u is not finite", r->path, i);
            r->position.push_back(x);
        }
    }
    return KN_OK;
}

kn_status add_mesh(reader *r, NMR::PLib3MFModelMeshObject *mesh, const affine &to)
{
    DWORD nv = 0, nt = 0;
    size_t first = r->position.size() / 3;
    bool mirrored = mirrors(to);
    if (NMR::lib3mf_meshobject_getvertexcount(mesh, &nv) != 0 ||
        NMR::lib3mf_meshobject_gettrianglecount(mesh, &nt) != 0)
        return fail(r, mesh);
    if (first + nv > MOST || r->triangle.size() / 3 + nt > MOST)
        return kn_fail(r->ctx, KN_ELIMIT, "%s: more than 2^31 vertices or triangles", r->path);
    kn_status status = add_vertices(r, mesh, nv, to);
    for (DWORD i = 0; i < nt && status == KN_OK; i++) {
        NMR::MODELMESHTRIANGLE t;
        if (NMR::lib3mf_meshobject_gettriangle(mesh, i, &t) != 0) return fail(r, mesh);
        uint32_t a = t.m_nIndices[0], b = t.m_nIndices[mirrored ? 2 : 1], c = t.m_nIndices[mirrored ? 1 : 2];
        if (a >= nv || b >= nv || c >= nv)
            return kn_fail(r->ctx, KN_EPARSE, "%s: triangle %u has a vertex beyond the last of %u", r->path, i, nv);
        uint32_t from = static_cast<uint32_t>(first);
        if (a != b && b != c && c != a) r->triangle.insert(r->triangle.end(), {from + a, from + b, from + c});
    }
    return status;
}

kn_status add_object(reader *r, NMR::PLib3MFModelObjectResource *object, const affine &to, int depth)
{
    BOOL is_mesh = false, is_group = false;
    if (depth > DEEPEST) return kn_fail(r->ctx, KN_ELIMIT, "%s: components nested too deeply", r->path);
    if (NMR::lib3mf_object_ismeshobject(object, &is_mesh) != 0 ||
        NMR::lib3mf_object_iscomponentsobject(object, &is_group) != 0)
        return fail(r, object);
    if (is_mesh) return add_mesh(r, object, to);
    DWORD n = 0;
    if (!is_group || NMR::lib3mf_componentsobject_getcomponentcount(object, &n) != 0) return fail(r, object);
    kn_status status = KN_OK;
    for (DWORD i = 0; i < n && status == KN_OK; i++) {
        NMR::PLib3MFModelComponent *component = nullptr;
        NMR::PLib3MFModelObjectResource *part = nullptr;
        NMR::MODELTRANSFORM t;
        if (NMR::lib3mf_componentsobject_getcomponent(object, i, &component) != 0) return fail(r, object);
        handle owner(component);
        if (NMR::lib3mf_component_getobjectresource(component, &part) != 0 ||
            NMR::lib3mf_component_gettransform(component, &t) != 0)
            return fail(r, component);
        handle part_owner(part);
        status = add_object(r, part, multiply(to, transform_of(t)), depth + 1);
    }
    return status;
}

kn_status add_items(reader *r, NMR::PLib3MFModel *model)
{
    NMR::PLib3MFModelBuildItemIterator *items = nullptr;
    if (NMR::lib3mf_model_getbuilditems(model, &items) != 0) return fail(r, model);
    handle owner(items);
    for (;;) {
        BOOL more = false;
        NMR::PLib3MFModelBuildItem *item = nullptr;
        NMR::PLib3MFModelObjectResource *object = nullptr;
        NMR::MODELTRANSFORM t;
        if (NMR::lib3mf_builditemiterator_movenext(items, &more) != 0) return fail(r, items);
        if (!more) return KN_OK;
        if (NMR::lib3mf_builditemiterator_getcurrent(items, &item) != 0) return fail(r, items);
        handle item_owner(item);
        if (NMR::lib3mf_builditem_getobjectresource(item, &object) != 0 ||
            NMR::lib3mf_builditem_getobjecttransform(item, &t) != 0)
            return fail(r, item);
        handle object_owner(object);
        kn_status status = add_object(r, object, transform_of(t), 0);
        if (status != KN_OK) return status;
    }
}

kn_status take(const reader *r, kn_mesh *out)
{
    if (r->triangle.empty()) return kn_fail(r->ctx, KN_EPARSE, "%s: no triangle", r->path);
    kn_mesh mesh = {};
    mesh.nvertices = mesh.vertex_room = r->position.size() / 3;
    mesh.ntriangles = mesh.triangle_room = r->triangle.size() / 3;
    mesh.position = static_cast<double *>(kn_alloc(r->ctx, mesh.nvertices, 3 * sizeof(double)));
    mesh.triangle = static_cast<uint32_t *>(kn_alloc(r->ctx, mesh.ntriangles, 3 * sizeof(uint32_t)));
    if (!mesh.position || !mesh.triangle) {
        kn_mesh_clear(r->ctx, &mesh);
        return KN_ENOMEM;
    }
    memcpy(mesh.position, r->position.data(), r->position.size() * sizeof(double));
    memcpy(mesh.triangle, r->triangle.data(), r->triangle.size() * sizeof(uint32_t));
    kn_mesh_clear(r->ctx, out);
    *out = mesh;
    return KN_OK;
}

kn_status read_model(reader *r, kn_mesh *out, char *text, size_t bytes)
{
    NMR::PLib3MFModel *model = nullptr;
    NMR::PLib3MFModelReader *from = nullptr;
    if (NMR::lib3mf_createmodel(&model) != 0) return fail(r, nullptr);
    handle owner(model);
    if (NMR::lib3mf_model_queryreader(model, "3mf", &from) != 0) return fail(r, model);
    handle from_owner(from);
    if (NMR::lib3mf_reader_readfrombuffer(from, reinterpret_cast<BYTE *>(text), bytes) != 0) return fail(r, from);
    kn_status status = add_items(r, model);
    return status == KN_OK ? take(r, out) : status;
}

} // namespace

kn_status kn_3mf_read(kn_ctx *ctx, kn_mesh *out, const char *path)
{
    char *text = nullptr;
    size_t bytes = 0;
    kn_status status = kn_in_read(ctx, &text, &bytes, path);
    if (status != KN_OK) return status;
    reader r = {ctx, path, {}, {}};
    try {
        status = read_model(&r, out, text, bytes);
    } catch (const std::bad_alloc &) {
        status = kn_fail(ctx, KN_ENOMEM, "%s: no memory for the file's contents", path);
    } catch (const std::exception &e) {
        status = kn_fail(ctx, KN_EPARSE, "%s: %s", path, e.what());
    }
    kn_free(ctx, text);
    return status;
}
