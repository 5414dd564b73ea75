// SPDX-License-Identifier: Apache-2.0
// Mesh parts of a tile, mapped into a cell.
//
// A vertex lies in the cell in which its (u, v) falls, over seams and shared edges, and its image is asked of that
// place, which has one name (kn_job_find_spot): cells that have a vertex in common get the same point, bit for bit.
#include "job/border.h"
#include "job/internal.h"
#include "job/vary.h"

#include <math.h>

typedef struct target {
    const kn_job *job;
    int surface;
    const int *cell;
    bool turns_over; // the normal does, over some edge
} target;

static bool has_turning_edge(const kn_job *job)
{
    for (int e = 0; e < 4 * job->nsurfaces; e++) {
        const kn_job_partner *p = &job->surfaces[e / 4].partner[e % 4];
        if (p->goes_on && kn_job_turns_over(e % 4, p)) return true;
    }
    return false;
}

// The parameter that lies x cells from the first line of a surface; beyond the ends the last cells go on.
static double parameter(const kn_job_surface *s, int d, double x, double *width)
{
    int cell = (int)fmin(fmax(floor(x), 0.0), s->cells[d] - 1);
    const double *line = s->lines[d] + cell;
    double part = x - cell;
    *width = line[1] - line[0];
    return part == 1.0 ? line[1] : line[0] + part * *width;
}

// Whether (u, v) is beyond an open end, where its own surface goes on as a polynomial; `place` is its cell.
static bool is_beyond(kn_job_place *place, const target *t, const double uv[2])
{
    const kn_job_surface *own = &t->job->surfaces[t->surface];
    int offset[2];
    bool beyond = false;
    for (int d = 0; d < 2; d++) offset[d] = (int)floor(uv[d]);
    *place = kn_job_find_place(t->job, t->surface, t->cell, offset);
    for (int d = 0; d < 2; d++) {
        double x = t->cell[d] + uv[d];
        beyond = beyond || (!own->closed[d] && (x < 0.0 || x > own->cells[d]));
    }
    const kn_job_surface *s = &t->job->surfaces[place->surface];
    for (int d = 0; d < 2 && beyond; d++)
        if (!s->closed[d] && (place->cell[d] < 0 || place->cell[d] >= s->cells[d])) return true;
    return false;
}

static double wrap(double x, int cells)
{
    return x - cells * floor(x / cells);
}

// Where a point of the tile lies in the parameters of the place, and how wide the cell is there.
static void in_place(double at[3], double width[2], const kn_job *job, const kn_job_place *place,
                     const double from[3])
{
    const kn_job_surface *s = &job->surfaces[place->surface];
    double part[3] = {from[0] - floor(from[0]), from[1] - floor(from[1]), from[2]};
    kn_job_turn(part, 1, 1, place->turn);
    for (int d = 0; d < 2; d++) {
        double x = place->cell[d] + part[d];
        at[d] = parameter(s, d, s->closed[d] ? wrap(x, s->cells[d]) : x, &width[d]);
    }
    at[2] = part[2];
}

static kn_status map_normal(kn_ctx *ctx, double *normal, const target *t, const kn_job_place *place,
                            const double from[3], const double *from_normal)
{
    double at[3], width[2], n[3] = {from_normal[0], from_normal[1], from_normal[2]};
    in_place(at, width, t->job, place, from);
    for (int k = 0; k < place->turn % KN_JOB_FLIP; k++) {
        double u = n[0];
        n[0] = -n[1], n[1] = u;
    }
    if (place->turn & KN_JOB_FLIP) n[1] = -n[1], n[2] = -n[2];
    for (int d = 0; d < 2; d++) n[d] /= width[d];
    if (n[0] == 0.0 && n[1] == 0.0 && n[2] == 0.0) return KN_OK; // what its triangles say
    kn_status status = kn_shell_map_normal(ctx, normal, t->job->surfaces[place->surface].shell, at, n);
    if (status != KN_EUNDEFINED) return status;
    kn_ctx_clear_error(ctx);
    return KN_OK;
}

static kn_status map_point(kn_ctx *ctx, void *user, double point[3], double *normal, const double from[3],
                           const double *from_normal)
{
    const target *t = user;
    kn_job_place place;
    double at[3], width[2];
    bool beyond = is_beyond(&place, t, from);
    int surface = place.surface;
    in_place(at, width, t->job, &place, from);
    if (!beyond && !t->turns_over) { // a spot has no sense of w
        kn_job_spot spot = kn_job_find_spot(t->job, t->surface, t->cell, from);
        surface = spot.surface;
        for (int d = 0; d < 2; d++) at[d] = parameter(&t->job->surfaces[surface], d, spot.x[d], &width[d]);
    }
    kn_status status = kn_shell_eval(ctx, point, NULL, t->job->surfaces[surface].shell, at[0], at[1], at[2]);
    return status == KN_OK && normal ? map_normal(ctx, normal, t, &place, from, from_normal) : status;
}

// The cofactors of the linear part, by which normals go.
static void turn_normal(double *n, const double map[3][4], double sign)
{
    double to[3], square = 0.0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        to[i] = 0.0;
        for (int c = 0; c < 3; c++) {
            int d = (c + 1) % 3, e = (c + 2) % 3;
            to[i] += sign * n[c] * (map[j][d] * map[k][e] - map[j][e] * map[k][d]);
        }
        square += to[i] * to[i];
    }
    for (int i = 0; i < 3; i++) n[i] = square > 0.0 ? to[i] / sqrt(square) : 0.0;
}

static kn_status check_reach(kn_ctx *ctx, const double *p)
{
    for (int d = 0; d < 2; d++)
        if (!(p[d] >= -KN_JOB_MAX_REACH && p[d] <= KN_JOB_MAX_REACH + 1))
            return kn_fail(ctx, KN_ELIMIT, "job: the tile's mesh reaches to %g cells, more than %d beyond its own",
                           p[d], KN_JOB_MAX_REACH);
    return KN_OK;
}

// The mesh where the instance puts it, w in length units.
static kn_status place_mesh(kn_ctx *ctx, kn_mesh *out, const kn_job_cell_plan *plan, const kn_job_instance *instance,
                            int part)
{
    const kn_job *job = plan->job;
    const double one = kn_job_place_w(&job->options, 1.0) - kn_job_place_w(&job->options, 0.0);
    kn_status status = kn_mesh_copy(ctx, out, &job->tile.parts[part].mesh);
    for (size_t i = 0; status == KN_OK && i < out->nvertices; i++) {
        double *w = &out->position[3 * i + 2];
        *w = kn_job_place_w(&job->options, *w);
        if (out->normal) out->normal[3 * i + 2] /= one;
    }
    if (status == KN_OK)
        status = kn_job_vary_mesh(ctx, out->position, job, plan->surface, plan->cell, instance, part);
    if (job->varying && out->normal) { // of the unvaried one
        kn_free(ctx, out->normal);
        out->normal = NULL;
    }
    double sign = kn_job_map_mirrors(instance->map) ? -1.0 : 1.0;
    for (size_t i = 0; status == KN_OK && i < out->nvertices; i++) {
        double *p = out->position + 3 * i;
        const double q[3] = {p[0], p[1], p[2]};
        for (int c = 0; c < 3; c++) {
            const double *m = instance->map[c];
            p[c] = m[0] * q[0] + m[1] * q[1] + m[2] * q[2] + m[3];
        }
        if (out->normal) turn_normal(out->normal + 3 * i, instance->map, sign);
        status = check_reach(ctx, p);
    }
    return status;
}

static int patches_before_mesh(const kn_tile_part *part)
{
    int n = 0;
    for (int s = 0; s < part->nsplines; s++) {
        int spans = 1;
        for (int d = 0; d < part->splines[s].nvars; d++) spans *= kn_spline_spans(&part->splines[s], d);
        n += spans;
    }
    return n;
}

kn_status kn_job_map_meshes(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job_instance *instance)
{
    const kn_job *job = plan->job;
    target t = {job, plan->surface, plan->cell, has_turning_edge(job)};
    const kn_job_place place = {plan->surface, {plan->cell[0], plan->cell[1]}, 0};
    double end[2][2];
    kn_job_clip_ends(end, job, &place);
    kn_mesh_map_options o = kn_mesh_map_defaults();
    o.tolerance = job->options.mesh_tol;
    o.reversed = (job->options.height < 0.0) != kn_job_map_mirrors(instance->map);
    kn_status status = KN_OK;
    for (int p = 0; status == KN_OK && p < job->tile.nparts; p++) {
        const kn_tile_part *part = &job->tile.parts[p];
        if (part->mesh.ntriangles == 0) continue;
        kn_job_leaf leaf = {.key = {.exact = true}, .instance = instance->id, .piece = -1, .part = p};
        leaf.patch = patches_before_mesh(part);
        kn_mesh placed = {0};
        status = place_mesh(ctx, &placed, plan, instance, p);
        if (status == KN_OK) status = kn_job_clip_mesh(ctx, &placed, (const double(*)[2])end);
        if (status == KN_OK) status = kn_job_border_cut_mesh(ctx, &placed, plan);
        bool any = placed.ntriangles > 0;
        if (status == KN_OK && any) status = kn_mesh_map_by(ctx, &leaf.mesh, NULL, &placed, map_point, &t, &o);
        if (status == KN_OK && any) status = kn_job_add_leaf(ctx, plan, &leaf);
        kn_mesh_clear(ctx, &leaf.mesh);
        kn_mesh_clear(ctx, &placed);
    }
    return status;
}
