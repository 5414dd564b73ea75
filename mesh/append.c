// SPDX-License-Identifier: Apache-2.0
// kn_mesh_append.
#include "kernel/context.h"

#include <knurl/mesh.h>

#include <string.h>

static kn_status reserve(kn_ctx *ctx, kn_mesh *mesh, size_t vertices, size_t triangles)
{
    if (vertices > mesh->vertex_room || (vertices > 0 && !mesh->normal)) {
        size_t room = mesh->vertex_room + mesh->vertex_room / 2;
        room = room > vertices ? room : vertices;
        double *position = kn_resize(ctx, mesh->position, room, 3 * sizeof *position);
        if (!position) return KN_ENOMEM;
        mesh->position = position;
        double *normal = kn_resize(ctx, mesh->normal, room, 3 * sizeof *normal);
        if (!normal) return KN_ENOMEM;
        mesh->normal = normal;
        mesh->vertex_room = room;
    }
    if (triangles > mesh->triangle_room) {
        size_t room = mesh->triangle_room + mesh->triangle_room / 2;
        room = room > triangles ? room : triangles;
        uint32_t *triangle = kn_resize(ctx, mesh->triangle, room, 3 * sizeof *triangle);
        if (!triangle) return KN_ENOMEM;
        mesh->triangle = triangle;
        mesh->triangle_room = room;
    }
    return KN_OK;
}

kn_status kn_mesh_append(kn_ctx *ctx, kn_mesh *mesh, const kn_mesh *a)
{
    size_t n = mesh->nvertices, t = mesh->ntriangles;
    if (a->nvertices > UINT32_MAX - n) return kn_fail(ctx, KN_ELIMIT, "mesh: %zu and %zu vertices", n, a->nvertices);
    if ((n > 0 && !mesh->normal) || (a->nvertices > 0 && !a->normal))
        return kn_fail(ctx, KN_EDOMAIN, "mesh: no normals");
    kn_status status = reserve(ctx, mesh, n + a->nvertices, t + a->ntriangles);
    if (status != KN_OK) return status;
    if (a->nvertices > 0) {
        memcpy(mesh->position + 3 * n, a->position, 3 * a->nvertices * sizeof *mesh->position);
        memcpy(mesh->normal + 3 * n, a->normal, 3 * a->nvertices * sizeof *mesh->normal);
    }
    for (size_t i = 0; i < 3 * a->ntriangles; i++) mesh->triangle[3 * t + i] = a->triangle[i] + (uint32_t)n;
    mesh->nvertices += a->nvertices;
    mesh->ntriangles += a->ntriangles;
    return KN_OK;
}
