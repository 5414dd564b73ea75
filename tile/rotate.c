// SPDX-License-Identifier: Apache-2.0
// Quarter turns of a tile.
#include "tile/internal.h"

// One quarter turn counterclockwise about (1/2, 1/2): (u, v) -> (1 - v, u). Integers stay exact, so edges on cell
// lines stay on them. n points, their coordinates `next` numbers apart, one point after the other by `step`.
static void quarter(double *at, size_t n, size_t step, size_t next)
{
    for (size_t i = 0; i < n; i++) {
        double *u = at + i * step, *v = u + next, turned = 1.0 - *v;
        *v = *u;
        *u = turned;
    }
}

static void quarter_spline(kn_spline *s)
{
    if (s->coef) quarter(s->coef, kn_spline_count(s), 1, kn_spline_count(s));
}

// Normals turn like differences of points.
static void quarter_mesh(kn_mesh *m)
{
    quarter(m->position, m->nvertices, 3, 1);
    for (size_t i = 0; m->normal && i < m->nvertices; i++) {
        double u = m->normal[3 * i];
        m->normal[3 * i] = -m->normal[3 * i + 1];
        m->normal[3 * i + 1] = u;
    }
}

static void quarter_part(kn_tile_part *part, int nparameters)
{
    for (int s = 0; s < part->nsplines; s++) quarter_spline(&part->splines[s]);
    for (int s = 0; part->targets && s < nparameters * part->nsplines; s++) quarter_spline(&part->targets[s]);
    quarter_mesh(&part->mesh);
    for (int k = 0; part->mesh_targets && k < nparameters; k++)
        if (part->mesh_targets[k]) quarter(part->mesh_targets[k], part->mesh.nvertices, 3, 1);
}

static bool is_point(const kn_spline *s)
{
    return !s->coef || (s->ncomp == 3 && !s->rational);
}

kn_status kn_tile_rotate(kn_ctx *ctx, kn_tile *tile, int quarter_turns)
{
    for (int p = 0; p < tile->nparts; p++) {
        const kn_tile_part *part = &tile->parts[p];
        for (int s = 0; s < part->nsplines; s++) {
            bool fine = is_point(&part->splines[s]);
            for (int k = 0; part->targets && k < tile->nparameters; k++)
                fine = fine && is_point(&part->targets[k * part->nsplines + s]);
            if (!fine)
                return kn_fail(ctx, KN_EDOMAIN, "rotate: part %d, spline %d has no polynomial values (u,v,w)", p, s);
        }
    }
    int turns = (quarter_turns % 4 + 4) % 4;
    for (int p = 0; p < tile->nparts; p++)
        for (int k = 0; k < turns; k++) quarter_part(&tile->parts[p], tile->nparameters);
    return KN_OK;
}
