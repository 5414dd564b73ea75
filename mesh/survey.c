// SPDX-License-Identifier: Apache-2.0
// What kind of surface a mesh is.
#include "kernel/context.h"
#include "mesh/edges.h"
#include "mesh/net.h"

#include <string.h>

static uint32_t root(uint32_t *parent, uint32_t v)
{
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

// Borders: next[v] = where the border goes on from v, UINT32_MAX where it does not pass.
static void count_edges(kn_mesh_topology *out, uint32_t *next, uint32_t *parent, const kn_mesh_side *sides, size_t n)
{
    for (size_t at = 0, group; at < n; at += group) {
        group = kn_mesh_side_group(sides, n, at);
        const kn_mesh_side *s = &sides[at];
        out->edges++;
        if (group == 1) {
            out->border++;
            out->irregular += next[s->from] != UINT32_MAX; // the border meets itself there
            next[s->from] = s->to;
        } else if (group > 2 || s[0].from == s[1].from || s->from == s->to) {
            out->irregular++;
        }
        uint32_t a = root(parent, s->from), b = root(parent, s->to);
        if (a != b) parent[a < b ? b : a] = a < b ? a : b;
    }
}

static int count_loops(uint32_t *next, size_t n)
{
    int loops = 0;
    for (size_t v = 0; v < n; v++) {
        if (next[v] == UINT32_MAX) continue;
        loops++;
        for (uint32_t at = (uint32_t)v; next[at] != UINT32_MAX;) {
            uint32_t to = next[at];
            next[at] = UINT32_MAX;
            at = to;
        }
    }
    return loops;
}

kn_status kn_mesh_survey(kn_ctx *ctx, kn_mesh_topology *out, const kn_mesh *mesh)
{
    kn_mesh_topology t = {0};
    size_t n = mesh->nvertices;
    if (kn_mesh_check(ctx, mesh) != KN_OK) return KN_EDOMAIN;
    kn_mesh_side *sides = kn_mesh_sides(ctx, mesh);
    uint32_t *next = kn_alloc(ctx, n, sizeof *next), *parent = kn_alloc(ctx, n, sizeof *parent);
    bool *used = kn_alloc_zero(ctx, n, sizeof *used);
    kn_status status = sides && next && parent && used ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        for (size_t v = 0; v < n; v++) next[v] = UINT32_MAX, parent[v] = (uint32_t)v;
        for (size_t i = 0; i < 3 * mesh->ntriangles; i++) used[mesh->triangle[i]] = true;
        count_edges(&t, next, parent, sides, 3 * mesh->ntriangles);
        for (size_t v = 0; v < n; v++) {
            t.vertices += used[v];
            t.components += used[v] && parent[v] == v;
        }
        t.loops = count_loops(next, n);
        t.euler = (long)t.vertices - (long)t.edges + (long)mesh->ntriangles;
        *out = t;
    }
    kn_free(ctx, sides);
    kn_free(ctx, next);
    kn_free(ctx, parent);
    kn_free(ctx, used);
    return status;
}
