// SPDX-License-Identifier: Apache-2.0
// A mesh of the tile over the border of a trimmed base: cut along it, before it goes through the shell, and what lies
// beyond goes.
//
// No triangle of the cut mesh is crossed by the border, so that its middle tells where it lies: the straight way to
// there from a place that certainly lies in the region, beside a segment of the border, crosses an even number of
// segments. A mesh that reaches over to other surfaces is cut along the cell lines first, and what lies in a cell of
// another surface is taken there.
#include "job/border.h"

#include <math.h>
#include <string.h>

enum { MOST_SEGMENTS = 4096 };        // of the border, over one mesh
static const double on_line = 1e-9;   // of a cell
static const double around = 0x1p-8;  // of a cell: segments so far from the mesh are looked at, too
static const double beside = 0x1p-10; // of a cell: how far from its segment the certain place lies, at most

typedef struct cutting {
    const kn_job *job;
    int surface, cell[2];
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

// ---- the border ----

// Where the border ends on an open end of the domain, it goes on straight beyond: there what is nearest counts.
static void go_beyond(cutting *c, size_t segment, bool from)
{
    const kn_job_surface *s = &c->job->surfaces[c->surface];
    const kn_mesh_segment *of = &c->list[segment];
    const double *end = from ? of->from : of->to;
    for (size_t i = 0; i < c->n; i++) {
        const double *other = from ? c->list[i].to : c->list[i].from;
        if (other[0] == end[0] && other[1] == end[1]) return;
    }
    for (int d = 0; d < 2; d++) {
        double below = -c->cell[d], above = s->cells[d] - c->cell[d];
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
    const kn_job_surface *s = &c->job->surfaces[c->surface];
    const int *cell = c->cell;
    double lo[2], hi[2];
    for (int d = 0; d < 2; d++) lo[d] = cell[d] + c->lo[d] - around, hi[d] = cell[d] + c->hi[d] + around;
    kn_job_segment *found = kn_scratch(ctx, MOST_SEGMENTS, sizeof *found);
    if (!found) return KN_ENOMEM;
    c->n = kn_job_border_take(found, MOST_SEGMENTS, c->job, c->surface, lo, hi);
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

// c knows where the mesh lies.
static kn_status cut(kn_ctx *ctx, kn_job_cell_plan *plan, kn_mesh *mesh, cutting *c)
{
    double inside[2] = {0.0, 0.0}, speed, lo[2], hi[2];
    bool found = false;
    kn_answer side = KN_YES;
    find_box(c, mesh);
    for (int d = 0; d < 2; d++) lo[d] = c->cell[d] + c->lo[d], hi[d] = c->cell[d] + c->hi[d];
    kn_status status = KN_OK;
    if (kn_job_is_bordered(c->job, c->surface)) status = kn_job_border_of_box(ctx, &side, c->job, c->surface, lo, hi);
    if (status == KN_OK && side == KN_UNKNOWN) status = take_border(ctx, c);
    if (status == KN_OK && side == KN_UNKNOWN) find_place_inside(inside, &found, c);
    if (status == KN_OK && side == KN_UNKNOWN && !found) {
        const double middle[2] = {0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1])};
        status = kn_job_border_side(ctx, &side, c->job, c->surface, middle);
    }
    if (status == KN_OK && side == KN_NO) mesh->nvertices = mesh->ntriangles = 0;
    if (status != KN_OK || !found) return status;
    status = kn_mesh_cut(ctx, mesh, c->list, c->n, on_line);
    if (status == KN_OK) status = keep_inside(ctx, mesh, c, inside);
    if (status == KN_OK) status = kn_job_border_speed(ctx, &speed, c->job, c->surface, c->top);
    if (status == KN_OK) {
        double off = c->job->borders->surfaces[c->surface].off + on_line;
        plan->crossing = fmax(plan->crossing, speed * off * (1.0 + 1e-12));
    }
    return status;
}

// ---- meshes that reach over to other surfaces ----

// The box around the plan's cell in which (u,v) is of its own lattice: end[variable][0] below it and [1] above.
static void own_ends(double end[2][2], const kn_job_cell_plan *plan)
{
    const kn_job_surface *s = &plan->job->surfaces[plan->surface];
    for (int k = 0; k < 4; k++) {
        int d = k / 2, e = k % 2, offset[2] = {0, 0};
        offset[d] = e == 0 ? -plan->cell[d] - 1 : s->cells[d] - plan->cell[d];
        kn_job_place place = kn_job_find_place(plan->job, plan->surface, plan->cell, offset);
        bool own = place.surface == plan->surface && place.turn == 0;
        for (int c = 0; c < 2; c++) own = own && place.cell[c] == plan->cell[c] + offset[c];
        double far = e == 0 ? -INFINITY : INFINITY, line = offset[d] + (e == 0 ? 1.0 : 0.0);
        end[d][e] = s->closed[d] || own ? far : line;
    }
}

// Along all cell lines.
static kn_status cut_at_lines(kn_ctx *ctx, kn_mesh *mesh, const cutting *c)
{
    size_t n = 0, room = 2;
    for (int d = 0; d < 2; d++) room += (size_t)(c->hi[d] - c->lo[d]) + 2;
    kn_mesh_segment *lines = kn_scratch(ctx, room, sizeof *lines);
    if (!lines) return KN_ENOMEM;
    for (int d = 0; d < 2; d++)
        for (double x = floor(c->lo[d]) + 1.0; x < c->hi[d]; x += 1.0) {
            lines[n].from[d] = lines[n].to[d] = x;
            lines[n].from[1 - d] = c->lo[1 - d] - 1.0, lines[n++].to[1 - d] = c->hi[1 - d] + 1.0;
        }
    return kn_mesh_cut(ctx, mesh, lines, n, on_line);
}

// There and back between the coordinates of the plan's cell and those of the place at an offset from it.
static void turn_mesh(kn_mesh *mesh, const int offset[2], int turn, bool back)
{
    for (size_t i = 0; i < mesh->nvertices; i++) {
        double *p = mesh->position + 3 * i;
        if (!back) p[0] -= offset[0], p[1] -= offset[1];
        if (back && (turn & KN_JOB_FLIP)) kn_job_turn(p, 1, 1, KN_JOB_FLIP);
        kn_job_turn(p, 1, 1, !back ? turn : (4 - turn % KN_JOB_FLIP) % 4);
        if (back) p[0] += offset[0], p[1] += offset[1];
    }
}

static kn_status append(kn_ctx *ctx, kn_mesh *mesh, const kn_mesh *more, bool normals)
{
    size_t n = mesh->nvertices, t = mesh->ntriangles, nvertices = n + more->nvertices, count = t + more->ntriangles;
    if (nvertices > UINT32_MAX) return kn_fail(ctx, KN_ELIMIT, "job: a mesh of %zu vertices", nvertices);
    kn_mesh sum = {.nvertices = nvertices, .ntriangles = count, .vertex_room = nvertices, .triangle_room = count};
    sum.position = kn_alloc(ctx, nvertices, 3 * sizeof *sum.position);
    sum.triangle = kn_alloc(ctx, count, 3 * sizeof *sum.triangle);
    if (normals) sum.normal = kn_alloc(ctx, nvertices, 3 * sizeof *sum.normal);
    if (!sum.position || !sum.triangle || (normals && !sum.normal)) {
        kn_mesh_clear(ctx, &sum);
        return KN_ENOMEM;
    }
    const kn_mesh *parts[2] = {mesh, more};
    for (size_t k = 0, at = 0, first = 0; k < 2; at += parts[k]->nvertices, first += parts[k]->ntriangles, k++) {
        const kn_mesh *p = parts[k];
        if (p->nvertices == 0) continue;
        memcpy(sum.position + 3 * at, p->position, 3 * p->nvertices * sizeof *sum.position);
        if (normals) memcpy(sum.normal + 3 * at, p->normal, 3 * p->nvertices * sizeof *sum.normal);
        for (size_t i = 0; i < 3 * p->ntriangles; i++) sum.triangle[3 * first + i] = p->triangle[i] + (uint32_t)at;
    }
    kn_mesh_clear(ctx, mesh);
    *mesh = sum;
    return KN_OK;
}

// What of the mesh lies in one cell of another surface, or (own) in the plan's own lattice, cut there.
static kn_status add_zone(kn_ctx *ctx, kn_mesh *out, const kn_mesh *mesh, kn_job_cell_plan *plan,
                          const double end[2][2], const int offset[2], bool own)
{
    kn_job_place place = {plan->surface, {plan->cell[0], plan->cell[1]}, 0};
    if (!own) place = kn_job_find_place(plan->job, plan->surface, plan->cell, offset);
    const int none[2] = {0, 0}, *by = own ? none : offset;
    kn_mesh part = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    bool *keep = kn_scratch(ctx, mesh->ntriangles, sizeof *keep), any = false;
    if (!keep) return KN_ENOMEM;
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        double at[2] = {0.0, 0.0};
        bool in_own = true, in_cell = true;
        for (size_t k = 0; k < 6; k++)
            at[k % 2] += mesh->position[3 * (size_t)mesh->triangle[3 * t + k / 2] + k % 2] / 3.0;
        for (int d = 0; d < 2; d++) {
            in_own = in_own && at[d] >= end[d][0] - on_line && at[d] <= end[d][1] + on_line;
            in_cell = in_cell && (int)floor(at[d]) == offset[d];
        }
        keep[t] = own ? in_own : !in_own && in_cell;
        any = any || keep[t];
    }
    kn_status status = any ? kn_mesh_copy(ctx, &part, mesh) : KN_OK;
    if (status == KN_OK && any) status = kn_job_keep_triangles(ctx, &part, keep);
    if (status == KN_OK && any) {
        cutting c = {.job = plan->job, .surface = place.surface, .cell = {place.cell[0], place.cell[1]}};
        turn_mesh(&part, by, place.turn, false);
        status = cut(ctx, plan, &part, &c);
        turn_mesh(&part, by, place.turn, true);
    }
    if (status == KN_OK && part.ntriangles > 0) status = append(ctx, out, &part, mesh->normal != NULL);
    kn_mesh_clear(ctx, &part);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status cut_zones(kn_ctx *ctx, kn_mesh *mesh, kn_job_cell_plan *plan, const cutting *c,
                           const double end[2][2])
{
    kn_mesh out = {0};
    const int none[2] = {0, 0};
    kn_status status = cut_at_lines(ctx, mesh, c);
    if (status == KN_OK) status = add_zone(ctx, &out, mesh, plan, end, none, true);
    for (int i = (int)floor(c->lo[0]); i <= (int)floor(c->hi[0]); i++)
        for (int j = (int)floor(c->lo[1]); status == KN_OK && j <= (int)floor(c->hi[1]); j++)
            status = add_zone(ctx, &out, mesh, plan, end, (const int[]){i, j}, false);
    if (status == KN_OK) {
        kn_mesh old = *mesh;
        *mesh = out;
        out = old;
    }
    kn_mesh_clear(ctx, &out);
    return status;
}

kn_status kn_job_border_cut_mesh(kn_ctx *ctx, kn_mesh *mesh, kn_job_cell_plan *plan)
{
    const kn_job *job = plan->job;
    cutting c = {.job = job, .surface = plan->surface, .cell = {plan->cell[0], plan->cell[1]}};
    double end[2][2];
    if (!job->borders || job->options.trimmed != KN_TRIMMED_CLIP || kn_job_border_is_whole(plan) ||
        mesh->nvertices == 0)
        return KN_OK;
    find_box(&c, mesh);
    own_ends(end, plan);
    bool over = false;
    for (int d = 0; d < 2; d++) over = over || c.lo[d] < end[d][0] - on_line || c.hi[d] > end[d][1] + on_line;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = over ? cut_zones(ctx, mesh, plan, &c, (const double(*)[2])end) : cut(ctx, plan, mesh, &c);
    kn_scratch_release(ctx, mark);
    return status;
}
