// SPDX-License-Identifier: Apache-2.0
// A closed surface from which vertices are taken away one by one, and put back.
#include "mesh/rings.h"
#include "kernel/context.h"
#include "mesh/edges.h"

static uint32_t find(const kn_mesh_rings *r, uint32_t of, uint32_t to)
{
    uint32_t node = r->head[of];
    while (r->to[node] != to) node = r->next[node];
    return node;
}

static void unlink_node(kn_mesh_rings *r, uint32_t of, uint32_t node)
{
    uint32_t before = r->prev[node], after = r->next[node];
    r->next[before] = after;
    r->prev[after] = before;
    r->head[of] = after;
    r->degree[of]--;
    r->next[node] = r->free;
    r->free = node;
}

static uint32_t insert_after(kn_mesh_rings *r, uint32_t of, uint32_t before, uint32_t to)
{
    uint32_t node = r->free;
    r->free = r->next[node];
    r->to[node] = to;
    if (r->degree[of]++ == 0) {
        r->head[of] = r->next[node] = r->prev[node] = node;
        return node;
    }
    uint32_t after = r->next[before];
    r->prev[node] = before, r->next[node] = after;
    r->next[before] = r->prev[after] = node;
    return node;
}

// Corner k of triangle t is the node 3 t + k: the neighbour that comes next in t. Where q -> p is the side at corner j
// of another triangle, its corner j + 1 lies at p, between what comes next there and q.
static void link_corners(kn_mesh_rings *r, const kn_mesh *mesh, const kn_mesh_side *sides)
{
    for (size_t i = 0; i < 3 * mesh->ntriangles; i += 2)
        for (int k = 0; k < 2; k++) {
            const kn_mesh_side *a = &sides[i + (size_t)k], *b = &sides[i + 1 - (size_t)k];
            uint32_t node = 3 * a->triangle + (uint32_t)a->corner;
            uint32_t before = 3 * b->triangle + (uint32_t)((b->corner + 1) % 3);
            r->to[node] = a->to;
            r->next[before] = node;
            r->prev[node] = before;
            r->head[a->from] = node;
            r->degree[a->from]++;
        }
}

kn_status kn_mesh_rings_init(kn_ctx *ctx, kn_mesh_rings *out, const kn_mesh *mesh)
{
    size_t n = mesh->nvertices, nodes = 3 * mesh->ntriangles;
    *out = (kn_mesh_rings){.n = n, .free = UINT32_MAX};
    if (nodes >= UINT32_MAX) return kn_fail(ctx, KN_ELIMIT, "mesh: %zu triangles", mesh->ntriangles);
    out->to = kn_alloc(ctx, 3 * nodes, sizeof *out->to);
    out->head = kn_alloc(ctx, n, sizeof *out->head);
    out->degree = kn_alloc_zero(ctx, n, sizeof *out->degree);
    kn_mesh_side *sides = kn_mesh_sides(ctx, mesh);
    kn_status status = out->to && out->head && out->degree && sides ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        out->next = out->to + nodes;
        out->prev = out->next + nodes;
        for (size_t v = 0; v < n; v++) out->head[v] = UINT32_MAX;
        link_corners(out, mesh, sides);
    }
    for (size_t v = 0; status == KN_OK && v < n; v++) {
        if (out->degree[v] == 0) continue;
        uint32_t count = 1;
        for (uint32_t node = out->next[out->head[v]]; node != out->head[v]; node = out->next[node]) count++;
        if (count != out->degree[v])
            status = kn_fail(ctx, KN_EDOMAIN, "mesh: the surface touches itself at vertex %zu", v);
    }
    kn_free(ctx, sides);
    return status;
}

void kn_mesh_rings_clear(kn_ctx *ctx, kn_mesh_rings *rings)
{
    kn_free(ctx, rings->to);
    kn_free(ctx, rings->head);
    kn_free(ctx, rings->degree);
    *rings = (kn_mesh_rings){0};
}

int kn_mesh_ring(uint32_t out[KN_MESH_MOST_RING], const kn_mesh_rings *rings, uint32_t v)
{
    uint32_t node = rings->head[v];
    int k = (int)rings->degree[v];
    for (int i = 0; i < k; i++, node = rings->next[node]) out[i] = rings->to[node];
    return k;
}

bool kn_mesh_are_neighbours(const kn_mesh_rings *rings, uint32_t a, uint32_t b)
{
    uint32_t of = rings->degree[a] < rings->degree[b] ? a : b, to = of == a ? b : a, node = rings->head[of];
    for (uint32_t i = 0; i < rings->degree[of]; i++, node = rings->next[node])
        if (rings->to[node] == to) return true;
    return false;
}

// Around ring[0] v lies between ring[1] and ring[k-1], around ring[i] between ring[i+1] and ring[i-1].
void kn_mesh_take_out(kn_mesh_rings *r, uint32_t v, const uint32_t *ring, int k)
{
    while (r->degree[v] > 0) unlink_node(r, v, r->head[v]);
    r->head[v] = UINT32_MAX;
    unlink_node(r, ring[1], find(r, ring[1], v));
    unlink_node(r, ring[k - 1], find(r, ring[k - 1], v));
    uint32_t here = find(r, ring[0], v), last = here;
    for (int i = 2; i <= k - 2; i++) {
        last = insert_after(r, ring[0], last, ring[i]);
        r->to[find(r, ring[i], v)] = ring[0];
    }
    unlink_node(r, ring[0], here);
}

void kn_mesh_put_back(kn_mesh_rings *r, uint32_t v, const uint32_t *ring, int k)
{
    for (int i = 2; i <= k - 2; i++) {
        unlink_node(r, ring[0], find(r, ring[0], ring[i]));
        r->to[find(r, ring[i], ring[0])] = v;
    }
    (void)insert_after(r, ring[0], find(r, ring[0], ring[1]), v);
    (void)insert_after(r, ring[1], find(r, ring[1], ring[2]), v);
    (void)insert_after(r, ring[k - 1], find(r, ring[k - 1], ring[0]), v);
    for (uint32_t i = 0, last = UINT32_MAX; i < (uint32_t)k; i++) last = insert_after(r, v, last, ring[i]);
}
