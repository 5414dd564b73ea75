// SPDX-License-Identifier: Apache-2.0
// A mesh of the tile over the border of a trimmed base: cut along it, before it goes through the shell, and what lies
// beyond goes.
//
// No triangle of the cut mesh is crossed by the border, so that its middle tells where it lies: the straight way to
// there from a place that certainly lies in the region, beside a segment of the border, crosses an even number of
// segments.
#include "job/border.h"

#include <math.h>

enum { MOST_SEGMENTS = 4096 };        // of the border, over one mesh
static const double on_line = 1e-9;   // of a cell
static const double around = 0x1p-8;  // of a cell: segments so far from the mesh are looked at, too
static const double beside = 0x1p-10; // of a cell: how far from its segment the certain place lies, at most

typedef struct cutting {
    const kn_job *job;
    const kn_job_cell_plan *plan;
    double lo[2], hi[2], top; // of the mesh, in the cell's coordinates; max |w|
    kn_mesh_segment *list;    // the same coordinates
    size_t n;
} cutting;

static double cross(const double *o, const double *a, const double *b)
{
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

static void find_box(cutting *c, const kn_mesh *mesh)
{
    for (int d = 0; d < 2; d++) c->lo[d] = INFINITY, c->hi[d] = -INFINITY;
    c->top = 0.0;
    for (size_t i = 0; i < mesh->nvertices; i++) {
        const double *p = mesh->position + 3 * i;
        for (int d = 0; d < 2; d++) c->lo[d] = fmin(c->lo[d], p[d]), c->hi[d] = fmax(c->hi[d], p[d]);
        c->top = fmax(c->top, fabs(p[2]));
    }
}

// ---- where the mesh lies ----

// Of the part of the box over the cell at an offset from the plan's. *foreign: that is no cell of the same lattice.
static kn_status part_side(kn_ctx *ctx, kn_answer *out, bool *foreign, const cutting *c, const int offset[2])
{
    const kn_job_cell_plan *plan = c->plan;
    kn_job_place place = kn_job_find_place(c->job, plan->surface, plan->cell, offset);
    double corner[2][3] = {{0.0}, {0.0}}, lo[2], hi[2];
    *foreign = place.surface != plan->surface || place.turn != 0;
    for (int d = 0; d < 2; d++) {
        *foreign = *foreign || place.cell[d] != plan->cell[d] + offset[d];
        corner[0][d] = fmax(c->lo[d] - offset[d], 0.0), corner[1][d] = fmin(c->hi[d] - offset[d], 1.0);
    }
    for (int k = 0; k < 2; k++) kn_job_turn(corner[k], 1, 1, place.turn);
    for (int d = 0; d < 2; d++) {
        lo[d] = place.cell[d] + fmin(corner[0][d], corner[1][d]);
        hi[d] = place.cell[d] + fmax(corner[0][d], corner[1][d]);
    }
    *out = KN_YES;
    if (!kn_job_is_bordered(c->job, place.surface)) return KN_OK;
    return kn_job_border_of_box(ctx, out, c->job, place.surface, lo, hi);
}

// Of all of it: KN_UNKNOWN, the border may cross it. A mesh that reaches over to another surface is not cut.
static kn_status find_side(kn_ctx *ctx, kn_answer *out, const cutting *c, int part)
{
    const kn_job_surface *s = &c->job->surfaces[c->plan->surface];
    int first[2], last[2], yes = 0, no = 0, all = 0;
    bool foreign = false;
    for (int d = 0; d < 2; d++) {
        first[d] = (int)floor(c->lo[d] + on_line), last[d] = (int)ceil(c->hi[d] - on_line) - 1;
        if (last[d] < first[d]) first[d] = last[d] = last[d] == 0 ? 0 : first[d]; // flat, along a line between cells
    }
    kn_status status = KN_OK;
    for (int i = first[0]; i <= last[0]; i++)
        for (int j = first[1]; status == KN_OK && j <= last[1]; j++) {
            bool over;
            kn_answer side;
            status = part_side(ctx, &side, &over, c, (const int[]){i, j});
            foreign = foreign || over;
            yes += side == KN_YES, no += side == KN_NO, all++;
        }
    *out = yes == all ? KN_YES : no == all ? KN_NO : KN_UNKNOWN;
    if (status != KN_OK || *out != KN_UNKNOWN || !foreign) return status;
    return kn_fail(ctx, KN_EDOMAIN,
                   "job: the mesh of tile part \"%s\" in cell %d,%d of surface %d crosses a border and reaches over "
                   "to another surface, where meshes are not cut; --trimmed keep keeps it whole",
                   c->job->tile.parts[part].name, s->origin_cell[0] + c->plan->cell[0],
                   s->origin_cell[1] + c->plan->cell[1], s->origin);
}

// ---- the border ----

// Where the border ends on an open end of the domain, it goes on straight beyond: there what is nearest counts.
static void go_beyond(cutting *c, size_t segment, bool from)
{
    const kn_job_surface *s = &c->job->surfaces[c->plan->surface];
    const kn_mesh_segment *of = &c->list[segment];
    const double *end = from ? of->from : of->to;
    for (size_t i = 0; i < c->n; i++) {
        const double *other = from ? c->list[i].to : c->list[i].from;
        if (other[0] == end[0] && other[1] == end[1]) return;
    }
    for (int d = 0; d < 2; d++) {
        double below = -c->plan->cell[d], above = s->cells[d] - c->plan->cell[d];
        bool is_below = end[d] <= below + on_line && c->lo[d] < below;
        bool is_above = end[d] >= above - on_line && c->hi[d] > above;
        if (s->closed[d] || (!is_below && !is_above)) continue;
        double out[2] = {end[0], end[1]};
        out[d] = is_below ? c->lo[d] - 1.0 : c->hi[d] + 1.0;
        kn_mesh_segment *to = &c->list[c->n++];
        for (int k = 0; k < 2; k++) to->from[k] = from ? out[k] : end[k], to->to[k] = from ? end[k] : out[k];
        return;
    }
}

static kn_status take_border(kn_ctx *ctx, cutting *c)
{
    const kn_job_surface *s = &c->job->surfaces[c->plan->surface];
    const int *cell = c->plan->cell;
    double lo[2], hi[2];
    for (int d = 0; d < 2; d++) lo[d] = cell[d] + c->lo[d] - around, hi[d] = cell[d] + c->hi[d] + around;
    kn_job_segment *found = kn_scratch(ctx, MOST_SEGMENTS, sizeof *found);
    if (!found) return KN_ENOMEM;
    c->n = kn_job_border_take(found, MOST_SEGMENTS, c->job, c->plan->surface, lo, hi);
    if (c->n > MOST_SEGMENTS)
        return kn_fail(
            ctx, KN_ELIMIT,
            "job: %zu segments of the border of surface %d run through one mesh in cell %d,%d; at most %d: "
            "a larger --crossing-tol makes fewer",
            c->n, s->origin, s->origin_cell[0] + cell[0], s->origin_cell[1] + cell[1], MOST_SEGMENTS);
    c->list = kn_scratch(ctx, 3 * c->n, sizeof *c->list);
    if (!c->list) return KN_ENOMEM;
    for (size_t i = 0; i < c->n; i++)
        for (int d = 0; d < 2; d++) {
            c->list[i].from[d] = found[i].from[d] - cell[d];
            c->list[i].to[d] = found[i].to[d] - cell[d];
        }
    for (size_t i = 0, n = c->n; i < n; i++) {
        go_beyond(c, i, true);
        go_beyond(c, i, false);
    }
    return KN_OK;
}

// ---- a place that certainly lies in the region ----

static double off_segment(const double *p, const kn_mesh_segment *s)
{
    double a = s->to[0] - s->from[0], b = s->to[1] - s->from[1], x = p[0] - s->from[0], y = p[1] - s->from[1];
    double square = a * a + b * b, t = square > 0.0 ? fmin(fmax((a * x + b * y) / square, 0.0), 1.0) : 0.0;
    return hypot(x - t * a, y - t * b);
}

// How long the part of a segment near the mesh is, and its middle.
static double part_near(double middle[2], const cutting *c, const kn_mesh_segment *s)
{
    double from = 0.0, to = 1.0;
    for (int d = 0; d < 2; d++) {
        double lo = c->lo[d] - 0.5 * around, hi = c->hi[d] + 0.5 * around, way = s->to[d] - s->from[d];
        if (way == 0.0 && (s->from[d] < lo || s->from[d] > hi)) return 0.0;
        if (way == 0.0) continue;
        double p = (lo - s->from[d]) / way, q = (hi - s->from[d]) / way;
        from = fmax(from, fmin(p, q)), to = fmin(to, fmax(p, q));
    }
    if (!(from < to)) return 0.0;
    for (int d = 0; d < 2; d++) middle[d] = s->from[d] + 0.5 * (from + to) * (s->to[d] - s->from[d]);
    return (to - from) * hypot(s->to[0] - s->from[0], s->to[1] - s->from[1]);
}

// Beside the middle of a segment, half as far as the next one is: of all segments one that leaves most room. *found:
// no, there is no border near the mesh.
static void find_place_inside(double at[2], bool *found, const cutting *c)
{
    double best = 0.0;
    for (size_t i = 0; i < c->n && best < beside; i++) {
        const kn_mesh_segment *s = &c->list[i];
        double middle[2] = {0.0, 0.0}, room = 2.0 * beside, length = part_near(middle, c, s);
        if (!(length > best)) continue;
        room = fmin(room, length);
        for (size_t k = 0; k < c->n && room > 2.0 * best; k++)
            if (k != i) room = fmin(room, off_segment(middle, &c->list[k]));
        if (!(0.5 * room > best)) continue;
        best = 0.5 * room;
        double a = s->to[0] - s->from[0], b = s->to[1] - s->from[1], whole = hypot(a, b);
        at[0] = middle[0] - best * b / whole, at[1] = middle[1] + best * a / whole;
    }
    *found = best > 0.0;
}

// What lies on the border is in the region.
static bool lies_inside(const cutting *c, const double inside[2], const double at[2])
{
    bool in = true;
    for (size_t i = 0; i < c->n; i++) {
        const kn_mesh_segment *s = &c->list[i];
        if ((cross(at, inside, s->from) > 0.0) == (cross(at, inside, s->to) > 0.0)) continue;
        double length = hypot(s->to[0] - s->from[0], s->to[1] - s->from[1]);
        bool left = cross(s->from, s->to, at) >= -on_line * length;
        if (left != (cross(s->from, s->to, inside) > 0.0)) in = !in;
    }
    return in;
}

// ---- the mesh ----

static kn_status keep_inside(kn_ctx *ctx, kn_mesh *mesh, const cutting *c, const double inside[2])
{
    bool *keep = kn_scratch(ctx, mesh->ntriangles, sizeof *keep);
    if (!keep) return KN_ENOMEM;
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        double middle[2] = {0.0, 0.0};
        for (size_t k = 0; k < 6; k++)
            middle[k % 2] += mesh->position[3 * (size_t)mesh->triangle[3 * t + k / 2] + k % 2] / 3.0;
        keep[t] = lies_inside(c, inside, middle);
    }
    return kn_job_keep_triangles(ctx, mesh, keep);
}

static kn_status cut(kn_ctx *ctx, kn_job_cell_plan *plan, kn_mesh *mesh, cutting *c)
{
    double inside[2] = {0.0, 0.0}, speed;
    bool found = false;
    kn_status status = take_border(ctx, c);
    if (status == KN_OK) find_place_inside(inside, &found, c);
    if (status == KN_OK && !found) {
        const double middle[2] = {plan->cell[0] + 0.5 * (c->lo[0] + c->hi[0]),
                                  plan->cell[1] + 0.5 * (c->lo[1] + c->hi[1])};
        kn_answer side;
        status = kn_job_border_side(ctx, &side, c->job, plan->surface, middle);
        if (status == KN_OK && side == KN_NO) mesh->nvertices = mesh->ntriangles = 0;
        return status;
    }
    if (status == KN_OK) status = kn_mesh_cut(ctx, mesh, c->list, c->n, on_line);
    if (status == KN_OK) status = keep_inside(ctx, mesh, c, inside);
    if (status == KN_OK) status = kn_job_border_speed(ctx, &speed, c->job, plan->surface, c->top);
    if (status == KN_OK) {
        double off = c->job->borders->surfaces[plan->surface].off + on_line;
        plan->crossing = fmax(plan->crossing, speed * off * (1.0 + 1e-12));
    }
    return status;
}

kn_status kn_job_border_cut_mesh(kn_ctx *ctx, kn_mesh *mesh, kn_job_cell_plan *plan, int part)
{
    cutting c = {.job = plan->job, .plan = plan};
    kn_answer side;
    if (!c.job->borders || c.job->options.trimmed != KN_TRIMMED_CLIP || kn_job_border_is_whole(plan) ||
        mesh->nvertices == 0)
        return KN_OK;
    find_box(&c, mesh);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = find_side(ctx, &side, &c, part);
    if (status == KN_OK && side == KN_NO) mesh->nvertices = mesh->ntriangles = 0;
    if (status == KN_OK && side == KN_UNKNOWN) status = cut(ctx, plan, mesh, &c);
    kn_scratch_release(ctx, mark);
    return status;
}
