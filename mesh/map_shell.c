// SPDX-License-Identifier: Apache-2.0
// kn_mesh_map: a mesh through a shell.
#include "kernel/context.h"

#include <knurl/mesh.h>

typedef struct through {
    const kn_shell *shell;
    bool estimate;
} through;

static kn_status map(kn_ctx *ctx, void *user, double point[3], double *normal, const double from[3],
                     const double *from_normal)
{
    const through *t = user;
    kn_status status = kn_shell_eval(ctx, point, NULL, t->shell, from[0], from[1], from[2]);
    if (status != KN_OK || !normal) return status;
    status = t->estimate ? kn_shell_map_normal_estimate(ctx, normal, t->shell, from, from_normal)
                         : kn_shell_map_normal(ctx, normal, t->shell, from, from_normal);
    if (status != KN_EUNDEFINED) return status;
    kn_ctx_clear_error(ctx); // what its triangles say
    return KN_OK;
}

kn_status kn_mesh_map(kn_ctx *ctx, kn_mesh *out, double *deviation, const kn_mesh *mesh, const kn_shell *shell,
                      const kn_mesh_map_options *options)
{
    through t = {shell, options && options->estimate_normals};
    return kn_mesh_map_by(ctx, out, deviation, mesh, map, &t, options);
}
