// SPDX-License-Identifier: Apache-2.0
// Mesh parts of a tile, cut off at ends of the domain; and what is left of a mesh when triangles go.
#include "job/internal.h"

#include <math.h>
#include <string.h>

static const double near_line = 1e-9; // of a cell: what counts as on it (kn_job_clip_box)

kn_status kn_job_keep_triangles(kn_ctx *ctx, kn_mesh *mesh, const bool *keep)
{
    kn_mark mark = kn_scratch_mark(ctx);
    uint32_t *to = kn_scratch(ctx, mesh->nvertices, sizeof *to), n = 0;
    if (!to) return KN_ENOMEM;
    for (size_t v = 0; v < mesh->nvertices; v++) to[v] = UINT32_MAX;
    size_t kept = 0;
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        if (!keep[t]) continue;
        memmove(mesh->triangle + 3 * kept++, mesh->triangle + 3 * t, 3 * sizeof *mesh->triangle);
    }
    mesh->ntriangles = kept;
    for (size_t i = 0; i < 3 * kept; i++) to[mesh->triangle[i]] = 0;
    for (size_t v = 0; v < mesh->nvertices; v++) {
        if (to[v] == UINT32_MAX) continue;
        memmove(mesh->position + 3 * (size_t)n, mesh->position + 3 * v, 3 * sizeof *mesh->position);
        if (mesh->normal) memmove(mesh->normal + 3 * (size_t)n, mesh->normal + 3 * v, 3 * sizeof *mesh->normal);
        to[v] = n++;
    }
    mesh->nvertices = n;
    for (size_t i = 0; i < 3 * kept; i++) mesh->triangle[i] = to[mesh->triangle[i]];
    kn_scratch_release(ctx, mark);
    return KN_OK;
}

// kept: sign (x - line) <= 0
static kn_status clip_at(kn_ctx *ctx, kn_mesh *mesh, int axis, double line, double sign)
{
    double lo = INFINITY, hi = -INFINITY;
    bool beyond = false;
    for (size_t v = 0; v < mesh->nvertices; v++) {
        const double *p = mesh->position + 3 * v;
        lo = fmin(lo, p[1 - axis]), hi = fmax(hi, p[1 - axis]);
        beyond = beyond || sign * (p[axis] - line) > near_line;
    }
    if (!beyond) return KN_OK;
    kn_mesh_segment end;
    end.from[axis] = end.to[axis] = line;
    end.from[1 - axis] = lo - 1.0, end.to[1 - axis] = hi + 1.0;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_mesh_cut(ctx, mesh, &end, 1, near_line);
    bool *keep = status == KN_OK ? kn_scratch(ctx, mesh->ntriangles, sizeof *keep) : NULL;
    if (status == KN_OK && !keep) status = KN_ENOMEM;
    for (size_t t = 0; status == KN_OK && t < mesh->ntriangles; t++) {
        keep[t] = true;
        for (size_t k = 0; k < 3; k++) {
            double x = mesh->position[3 * (size_t)mesh->triangle[3 * t + k] + (size_t)axis];
            keep[t] = keep[t] && sign * (x - line) <= near_line;
        }
    }
    if (status == KN_OK) status = kn_job_keep_triangles(ctx, mesh, keep);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_job_clip_mesh(kn_ctx *ctx, kn_mesh *mesh, const double end[2][2])
{
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < 4; k++)
        if (isfinite(end[k / 2][k % 2]) && mesh->ntriangles > 0)
            status = clip_at(ctx, mesh, k / 2, end[k / 2][k % 2], k % 2 == 0 ? -1.0 : 1.0);
    return status;
}
