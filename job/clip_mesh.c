// SPDX-License-Identifier: Apache-2.0
// Mesh parts of a tile, cut off at ends of the domain.
//
// A new vertex depends on the two ends of its edge alone, from the one with the smaller coordinate on: triangles on
// both sides of an edge, and meshes of neighbouring cells, get the same one. On the line it lies exactly.
#include "job/internal.h"

#include <math.h>
#include <string.h>

static const double near_line = 1e-9; // of a cell: what counts as on it (kn_job_clip_box)

typedef struct cut_edge {
    uint32_t from, to, vertex; // from < to; to = 0: empty
} cut_edge;
typedef struct clipping {
    const kn_mesh *in;
    kn_mesh out;
    int axis;
    double line, sign; // kept: sign (x - line) <= 0
    uint32_t *moved;   // where a vertex of `in` went, less 1
    cut_edge *edges;   // open addressing
    size_t nslots;     // a power of two
} clipping;

// -1: kept, 0: on the line, 1: cut off.
static int side_of(const clipping *c, uint32_t vertex)
{
    double over = c->sign * (c->in->position[3 * (size_t)vertex + (size_t)c->axis] - c->line);
    return (over > near_line) - (over < -near_line);
}

static uint32_t keep(clipping *c, uint32_t vertex)
{
    if (c->moved[vertex] > 0) return c->moved[vertex] - 1;
    size_t to = 3 * c->out.nvertices, from = 3 * (size_t)vertex;
    memcpy(c->out.position + to, c->in->position + from, 3 * sizeof *c->out.position);
    if (c->in->normal) memcpy(c->out.normal + to, c->in->normal + from, 3 * sizeof *c->out.normal);
    c->moved[vertex] = (uint32_t)++c->out.nvertices;
    return c->moved[vertex] - 1;
}

static uint32_t cross_edge(clipping *c, uint32_t a, uint32_t b)
{
    uint32_t from = a < b ? a : b, to = a < b ? b : a;
    size_t slot = ((size_t)from * 0x9e3779b1u + (size_t)to * 0x85ebca77u) & (c->nslots - 1);
    for (; c->edges[slot].to > 0; slot = (slot + 1) & (c->nslots - 1))
        if (c->edges[slot].from == from && c->edges[slot].to == to) return c->edges[slot].vertex;
    size_t axis = (size_t)c->axis, at = 3 * c->out.nvertices;
    const double *p = c->in->position + 3 * (size_t)a, *q = c->in->position + 3 * (size_t)b;
    bool swap = p[axis] > q[axis];
    const double *low = swap ? q : p, *high = swap ? p : q;
    double t = (c->line - low[axis]) / (high[axis] - low[axis]);
    for (size_t k = 0; k < 3; k++) c->out.position[at + k] = low[k] + t * (high[k] - low[k]);
    c->out.position[at + axis] = c->line;
    if (c->in->normal) {
        const double *m = c->in->normal + (low - c->in->position), *n = c->in->normal + (high - c->in->position);
        double sum[3], square = 0.0;
        for (int k = 0; k < 3; k++) {
            sum[k] = m[k] + t * (n[k] - m[k]);
            square += sum[k] * sum[k];
        }
        for (size_t k = 0; k < 3; k++) c->out.normal[at + k] = square > 0.0 ? sum[k] / sqrt(square) : m[k];
    }
    c->edges[slot] = (cut_edge){from, to, (uint32_t)c->out.nvertices++};
    return c->edges[slot].vertex;
}

static void add_triangle(clipping *c, const uint32_t corner[3])
{
    memcpy(c->out.triangle + 3 * c->out.ntriangles++, corner, 3 * sizeof *corner);
}

// What is left of one triangle: nothing, it, a smaller one or two.
static void clip_triangle(clipping *c, const uint32_t corner[3])
{
    int side[3];
    uint32_t left[4];
    int n = 0;
    for (int k = 0; k < 3; k++) side[k] = side_of(c, corner[k]);
    bool below = side[0] < 0 || side[1] < 0 || side[2]<0, above = side[0]> 0 || side[1] > 0 || side[2] > 0;
    if (above && !below) return;
    for (int k = 0; k < 3; k++) {
        int next = (k + 1) % 3;
        if (side[k] <= 0) left[n++] = keep(c, corner[k]);
        if (side[k] * side[next] < 0) left[n++] = cross_edge(c, corner[k], corner[next]);
    }
    add_triangle(c, left);
    if (n == 4) add_triangle(c, (const uint32_t[]){left[0], left[2], left[3]});
}

// Room for the most that there may be: each triangle cut into two, with two new vertices.
static kn_status begin(kn_ctx *ctx, clipping *c)
{
    size_t cut = 0, vertices, triangles;
    for (size_t t = 0; t < c->in->ntriangles; t++) {
        int low = 1, high = -1;
        for (size_t k = 0; k < 3; k++) {
            int side = side_of(c, c->in->triangle[3 * t + k]);
            low = side < low ? side : low, high = side > high ? side : high;
        }
        cut += low * high < 0;
    }
    vertices = c->in->nvertices + 2 * cut, triangles = c->in->ntriangles + cut;
    if (vertices > UINT32_MAX) return kn_fail(ctx, KN_ELIMIT, "job: a mesh of %zu vertices", vertices);
    for (c->nslots = 16; c->nslots < 4 * cut; c->nslots *= 2) continue;
    c->out.vertex_room = vertices, c->out.triangle_room = triangles;
    c->out.position = kn_alloc(ctx, 3 * vertices, sizeof *c->out.position);
    c->out.triangle = kn_alloc(ctx, 3 * triangles, sizeof *c->out.triangle);
    if (c->in->normal) c->out.normal = kn_alloc(ctx, 3 * vertices, sizeof *c->out.normal);
    c->moved = kn_scratch(ctx, c->in->nvertices, sizeof *c->moved);
    c->edges = kn_scratch(ctx, c->nslots, sizeof *c->edges);
    if (!c->out.position || !c->out.triangle || (c->in->normal && !c->out.normal) || !c->moved || !c->edges)
        return KN_ENOMEM;
    memset(c->moved, 0, c->in->nvertices * sizeof *c->moved);
    memset(c->edges, 0, c->nslots * sizeof *c->edges);
    return KN_OK;
}

static kn_status clip_at(kn_ctx *ctx, kn_mesh *mesh, int axis, double line, double sign)
{
    clipping c = {.in = mesh, .axis = axis, .line = line, .sign = sign};
    bool above = false;
    for (size_t v = 0; v < mesh->nvertices && !above; v++) above = side_of(&c, (uint32_t)v) > 0;
    if (!above) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = begin(ctx, &c);
    for (size_t t = 0; status == KN_OK && t < mesh->ntriangles; t++) clip_triangle(&c, mesh->triangle + 3 * t);
    if (status == KN_OK) {
        kn_mesh old = *mesh;
        *mesh = c.out;
        c.out = old;
    }
    kn_mesh_clear(ctx, &c.out);
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
