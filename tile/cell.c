// SPDX-License-Identifier: Apache-2.0
// kn_tile_set_cell: a tile in coordinates of its own becomes one over the unit cell.
#include "tile/internal.h"

#include <math.h>

// x -> (x - from) / width in each of the coordinates u, v, w.
typedef struct scaling {
    double from[3], width[3];
} scaling;

// n points, their coordinates `next` numbers apart, one point after the other by `step`.
static void scale(double *at, size_t n, size_t step, size_t next, const scaling *by)
{
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++) {
            double *x = at + i * step + c * next;
            *x = (*x - by->from[c]) / by->width[c];
        }
}

static void scale_spline(kn_spline *s, const scaling *by)
{
    if (s->coef) scale(s->coef, kn_spline_count(s), 1, kn_spline_count(s), by);
}

// Normals map by the inverse transpose: each coordinate times its width, and unit length again.
static void scale_mesh(kn_mesh *m, const scaling *by)
{
    scale(m->position, m->nvertices, 3, 1, by);
    for (size_t i = 0; m->normal && i < m->nvertices; i++) {
        double *n = m->normal + 3 * i;
        for (int c = 0; c < 3; c++) n[c] *= by->width[c];
        double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int c = 0; c < 3 && length > 0.0; c++) n[c] /= length;
    }
}

static void scale_part(kn_tile_part *part, int nparameters, const scaling *by)
{
    for (int s = 0; s < part->nsplines; s++) scale_spline(&part->splines[s], by);
    for (int s = 0; part->targets && s < nparameters * part->nsplines; s++) scale_spline(&part->targets[s], by);
    scale_mesh(&part->mesh, by);
    for (int k = 0; part->mesh_targets && k < nparameters; k++)
        if (part->mesh_targets[k]) scale(part->mesh_targets[k], part->mesh.nvertices, 3, 1, by);
}

static bool is_point(const kn_spline *s)
{
    return !s->coef || (s->ncomp == 3 && !s->rational);
}

static kn_status check_cell(kn_ctx *ctx, const double *cell, double height)
{
    for (int i = 0; i < 4; i++)
        if (!isfinite(cell[i])) return kn_fail(ctx, KN_EDOMAIN, "tile cell: number %d is not finite", i + 1);
    for (int d = 0; d < 2; d++) {
        double width = cell[d + 2] - cell[d];
        if (!(width > 0.0) || !isfinite(width))
            return kn_fail(ctx, KN_EDOMAIN, "tile cell: %c from %g to %g", d ? 'v' : 'u', cell[d], cell[d + 2]);
    }
    if (!(height > 0.0) || !isfinite(height)) return kn_fail(ctx, KN_EDOMAIN, "tile cell: height %g", height);
    return KN_OK;
}

kn_status kn_tile_set_cell(kn_ctx *ctx, kn_tile *tile, const double cell[4], double height)
{
    kn_status status = check_cell(ctx, cell, height);
    if (status != KN_OK) return status;
    for (int p = 0; p < tile->nparts; p++) {
        const kn_tile_part *part = &tile->parts[p];
        int ntargets = part->targets ? tile->nparameters * part->nsplines : 0;
        for (int s = 0; s < part->nsplines + ntargets; s++)
            if (!is_point(s < part->nsplines ? &part->splines[s] : &part->targets[s - part->nsplines]))
                return kn_fail(ctx, KN_EDOMAIN, "tile cell: part %d, spline %d has no polynomial values (u,v,w)", p,
                               s % part->nsplines);
    }
    double du = cell[2] - cell[0], dv = cell[3] - cell[1];
    scaling by = {{cell[0], cell[1], 0.0}, {du, dv, height}};
    for (int p = 0; p < tile->nparts; p++) scale_part(&tile->parts[p], tile->nparameters, &by);
    tile->aspect = height / sqrt(du) / sqrt(dv);
    return KN_OK;
}
