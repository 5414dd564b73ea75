// SPDX-License-Identifier: Apache-2.0
// kn_mesh_append.
#include "kernel/context.h"
#include "mesh/net.h"

#include <knurl/mesh.h>

#include <string.h>

kn_status kn_mesh_append(kn_ctx *ctx, kn_mesh *mesh, const kn_mesh *a)
{
    size_t n = mesh->nvertices, t = mesh->ntriangles;
    if (a->nvertices > UINT32_MAX - n) return kn_fail(ctx, KN_ELIMIT, "mesh: %zu and %zu vertices", n, a->nvertices);
    if ((n > 0 && !mesh->normal) || (a->nvertices > 0 && !a->normal))
        return kn_fail(ctx, KN_EDOMAIN, "mesh: no normals");
    kn_status status = kn_mesh_reserve(ctx, mesh, a->nvertices, a->ntriangles, true);
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
