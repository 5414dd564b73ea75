// SPDX-License-Identifier: Apache-2.0
// kn_openmesh_read: OpenMesh's readers fill a list of vertices and triangles. Its half-edge meshes would leave out
// what is not manifold, without a word to the caller.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <strings.h>
#include <vector>

#include <OpenMesh/Core/IO/MeshIO.hh>

#include "bridges/openmesh/importer.hpp"
#include "bridges/openmesh/read.h"
extern "C" {
#include "io/in_file.h"
#include "kernel/context.h"
}

namespace
{

using OpenMesh::FaceHandle;
using OpenMesh::Vec3d;
using OpenMesh::Vec3f;
using OpenMesh::VertexHandle;

const size_t MOST = 0x7fffffff;

// Takes positions and faces, and drops the rest.
class soup : public kn_openmesh::deaf_importer
{
  public:
    std::vector<double> position;
    std::vector<uint32_t> triangle;
    std::string wrong; // the first thing that is

    using deaf_importer::add_face;

    VertexHandle add_vertex(const Vec3f &p) override
    {
        return add(p[0], p[1], p[2]);
    }
    VertexHandle add_vertex(const Vec3d &p) override
    {
        return add(p[0], p[1], p[2]);
    }
    VertexHandle add_vertex() override
    {
        return add(0, 0, 0);
    }
    void set_point(VertexHandle v, const Vec3f &p) override
    {
        for (unsigned c = 0; v.is_valid() && 3 * size_t(v.idx()) + c < position.size(); c++)
            position[3 * size_t(v.idx()) + c] = double(p[c]);
    }
    FaceHandle add_face(const VHandles &corner) override
    {
        for (const VertexHandle &v : corner)
            if (v.idx() < 0 || size_t(v.idx()) >= n_vertices()) {
                blame("a face has vertex " + std::to_string(v.idx() + 1L) + " of " + std::to_string(n_vertices()));
                return FaceHandle();
            }
        for (size_t i = 2; i < corner.size(); i++) {
            uint32_t a = uint32_t(corner[0].idx()), b = uint32_t(corner[i - 1].idx()), c = uint32_t(corner[i].idx());
            if (a != b && b != c && c != a) triangle.insert(triangle.end(), {a, b, c});
        }
        if (n_faces() > MOST) blame("more than 2^31 triangles");
        return FaceHandle(int(n_faces()));
    }
    size_t n_vertices() const override
    {
        return position.size() / 3;
    }
    size_t n_faces() const override
    {
        return triangle.size() / 3;
    }
    void blame(const std::string &what)
    {
        if (wrong.empty()) wrong = what;
    }

  private:
    VertexHandle add(double x, double y, double z)
    {
        if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z))
            blame("vertex " + std::to_string(n_vertices() + 1) + " is not finite");
        if (n_vertices() >= MOST) blame("more than 2^31 vertices");
        position.insert(position.end(), {x, y, z});
        return VertexHandle(int(n_vertices() - 1));
    }
};

bool ends_in(const char *path, const char *ending)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot, ending) == 0;
}

// OpenMesh writes what it thinks of a file to standard error; whoever called us has a message of its own.
struct silence {
    silence()
    {
        omerr().disable();
    }
    ~silence()
    {
        omerr().enable();
    }
};

kn_status take(kn_ctx *ctx, kn_mesh *out, const soup &from)
{
    kn_mesh mesh = {};
    mesh.nvertices = mesh.vertex_room = from.n_vertices();
    mesh.ntriangles = mesh.triangle_room = from.n_faces();
    mesh.position = static_cast<double *>(kn_alloc(ctx, mesh.nvertices, 3 * sizeof(double)));
    mesh.triangle = static_cast<uint32_t *>(kn_alloc(ctx, mesh.ntriangles, 3 * sizeof(uint32_t)));
    if (!mesh.position || !mesh.triangle) {
        kn_mesh_clear(ctx, &mesh);
        return KN_ENOMEM;
    }
    memcpy(mesh.position, from.position.data(), from.position.size() * sizeof(double));
    memcpy(mesh.triangle, from.triangle.data(), from.triangle.size() * sizeof(uint32_t));
    kn_mesh_clear(ctx, out);
    *out = mesh;
    return KN_OK;
}

// Whether path can be opened, in the words of the system; and of a binary STL file whether its count fits its size:
// OpenMesh believes the count.
kn_status look_at(kn_ctx *ctx, const char *path)
{
    char *text = nullptr;
    size_t bytes = 0;
    kn_status status = kn_in_read(ctx, &text, &bytes, path);
    if (status != KN_OK) return status;
    uint32_t count = 0;
    bool binary = bytes >= 84 && memcmp(text, "solid", 5) != 0;
    if (binary) memcpy(&count, text + 80, 4);
    if (bytes == 0)
        status = kn_fail(ctx, KN_EPARSE, "%s: the file is empty", path);
    else if (ends_in(path, ".stl") && binary && bytes - 84 < size_t(count) * 50)
        status = kn_fail(ctx, KN_EPARSE, "%s: %u triangles expected, but only %zu bytes follow", path, count,
                         bytes - 84);
    else if (ends_in(path, ".ply") && std::string(text, bytes).find("\nend_header") == std::string::npos)
        status = kn_fail(ctx, KN_EPARSE, "%s: the header has no end", path); // OpenMesh would look for it for ever
    kn_free(ctx, text);
    return status;
}

kn_status read_mesh(kn_ctx *ctx, kn_mesh *out, const char *path)
{
    soup found;
    OpenMesh::IO::Options options;
    bool ok;
    {
        silence quiet;
        ok = OpenMesh::IO::IOManager().read(path, found, options);
    }
    if (!found.wrong.empty()) return kn_fail(ctx, KN_EPARSE, "%s: %s", path, found.wrong.c_str());
    if (!ok) return kn_fail(ctx, KN_EPARSE, "%s: damaged, or not what its ending says", path);
    if (found.triangle.empty()) return kn_fail(ctx, KN_EPARSE, "%s: no triangle", path);
    return take(ctx, out, found);
}

} // namespace

kn_status kn_openmesh_read(kn_ctx *ctx, kn_mesh *out, const char *path)
{
    if (!ends_in(path, ".obj") && !ends_in(path, ".stl") && !ends_in(path, ".ply") && !ends_in(path, ".off"))
        return kn_fail(ctx, KN_EDOMAIN, "%s: no mesh by its ending; .obj, .stl, .ply and .off are read", path);
    try {
        kn_status status = look_at(ctx, path);
        return status == KN_OK ? read_mesh(ctx, out, path) : status;
    } catch (const std::bad_alloc &) {
        return kn_fail(ctx, KN_ENOMEM, "%s: no memory for the file's contents", path);
    } catch (const std::exception &e) {
        return kn_fail(ctx, KN_EPARSE, "%s: %s", path, e.what());
    }
}
