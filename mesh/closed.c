// SPDX-License-Identifier: Apache-2.0
// One connectivity for two closed meshes: both on the unit sphere (kn_mesh_to_sphere), one laid over the other.
#include "mesh/closed.h"
#include "kernel/context.h"
#include "mesh/overlay.h"

// A mesh whose triangles are counterclockwise seen from outside, on the sphere.
typedef struct spread {
    kn_mesh mesh;
    double *on;
    bool reversed; // they were clockwise
} spread;

static void turn_over(kn_mesh *m)
{
    for (size_t i = 0; i < m->ntriangles; i++) {
        uint32_t *t = m->triangle + 3 * i, kept = t[1];
        t[1] = t[2];
        t[2] = kept;
    }
}

// Six times the volume, from the first vertex.
static double volume(const kn_mesh *m)
{
    double sum = 0.0;
    const double *o = m->position + 3 * (size_t)m->triangle[0];
    for (size_t i = 0; i < m->ntriangles; i++) {
        double x[3][3];
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++)
                x[k][c] = m->position[3 * (size_t)m->triangle[3 * i + (size_t)k] + (size_t)c] - o[c];
        for (int c = 0; c < 3; c++)
            sum += x[0][c] * (x[1][(c + 1) % 3] * x[2][(c + 2) % 3] - x[1][(c + 2) % 3] * x[2][(c + 1) % 3]);
    }
    return sum;
}

static kn_status spread_mesh(kn_ctx *ctx, spread *out, const kn_mesh *mesh)
{
    kn_status status = kn_mesh_copy(ctx, &out->mesh, mesh);
    if (status != KN_OK) return status;
    out->reversed = volume(mesh) < 0.0;
    if (out->reversed) turn_over(&out->mesh);
    out->on = kn_alloc(ctx, mesh->nvertices, 3 * sizeof *out->on);
    return out->on ? kn_mesh_to_sphere(ctx, out->on, &out->mesh) : KN_ENOMEM;
}

kn_status kn_mesh_morph_closed(kn_ctx *ctx, kn_mesh *out, double **target, const kn_mesh *a, const kn_mesh *b)
{
    spread from = {0}, to = {0};
    kn_mesh mesh = {0};
    kn_status status = spread_mesh(ctx, &from, a);
    if (status == KN_OK) status = spread_mesh(ctx, &to, b);
    if (status == KN_OK) status = kn_mesh_overlay(ctx, &mesh, target, &from.mesh, from.on, &to.mesh, to.on);
    if (status == KN_OK) {
        if (from.reversed) turn_over(&mesh);
        kn_mesh_clear(ctx, out);
        *out = mesh;
    }
    kn_mesh_clear(ctx, &from.mesh);
    kn_mesh_clear(ctx, &to.mesh);
    kn_free(ctx, from.on);
    kn_free(ctx, to.on);
    return status;
}
