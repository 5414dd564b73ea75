// SPDX-License-Identifier: Apache-2.0
// kn_mesh_copy.
#include "kernel/context.h"

#include <knurl/mesh.h>
#include <string.h>

kn_status kn_mesh_copy(kn_ctx *ctx, kn_mesh *out, const kn_mesh *a)
{
    kn_mesh copy = {.nvertices = a->nvertices, .ntriangles = a->ntriangles};
    copy.vertex_room = a->nvertices;
    copy.triangle_room = a->ntriangles;
    if (a->nvertices > 0) copy.position = kn_alloc(ctx, a->nvertices, 3 * sizeof *copy.position);
    if (a->nvertices > 0 && a->normal) copy.normal = kn_alloc(ctx, a->nvertices, 3 * sizeof *copy.normal);
    if (a->ntriangles > 0) copy.triangle = kn_alloc(ctx, a->ntriangles, 3 * sizeof *copy.triangle);
    bool room = (a->nvertices == 0 || (copy.position && (copy.normal || !a->normal))) &&
                (a->ntriangles == 0 || copy.triangle);
    if (!room) {
        kn_mesh_clear(ctx, &copy);
        return KN_ENOMEM;
    }
    if (copy.position) memcpy(copy.position, a->position, 3 * a->nvertices * sizeof *copy.position);
    if (copy.normal) memcpy(copy.normal, a->normal, 3 * a->nvertices * sizeof *copy.normal);
    if (copy.triangle) memcpy(copy.triangle, a->triangle, 3 * a->ntriangles * sizeof *copy.triangle);
    kn_mesh_clear(ctx, out); // last: it may be a
    *out = copy;
    return KN_OK;
}
