// SPDX-License-Identifier: Apache-2.0
// kn_mesh_clear.
#include "kernel/context.h"

#include <knurl/mesh.h>

void kn_mesh_clear(kn_ctx *ctx, kn_mesh *mesh)
{
    if (!mesh) return;
    kn_free(ctx, mesh->position);
    kn_free(ctx, mesh->normal);
    kn_free(ctx, mesh->triangle);
    *mesh = (kn_mesh){0};
}
