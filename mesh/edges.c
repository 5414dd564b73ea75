// SPDX-License-Identifier: Apache-2.0
#include "mesh/edges.h"
#include "kernel/context.h"

#include <stdlib.h>

static uint32_t lower(const kn_mesh_side *s)
{
    return s->from < s->to ? s->from : s->to;
}

static uint32_t upper(const kn_mesh_side *s)
{
    return s->from < s->to ? s->to : s->from;
}

static int compare(const void *a, const void *b)
{
    const kn_mesh_side *x = a, *y = b;
    if (lower(x) != lower(y)) return lower(x) < lower(y) ? -1 : 1;
    if (upper(x) != upper(y)) return upper(x) < upper(y) ? -1 : 1;
    if (x->from != y->from) return x->from < y->from ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

kn_mesh_side *kn_mesh_sides(kn_ctx *ctx, const kn_mesh *mesh)
{
    size_t n = 3 * mesh->ntriangles;
    kn_mesh_side *sides = kn_alloc(ctx, n, sizeof *sides);
    for (size_t i = 0; sides && i < n; i++) {
        const uint32_t *t = mesh->triangle + i / 3 * 3;
        sides[i] = (kn_mesh_side){t[i % 3], t[(i + 1) % 3], (uint32_t)(i / 3), (int)(i % 3)};
    }
    if (sides) qsort(sides, n, sizeof *sides, compare);
    return sides;
}

size_t kn_mesh_side_group(const kn_mesh_side *sides, size_t n, size_t at)
{
    size_t end = at + 1;
    while (end < n && lower(&sides[end]) == lower(&sides[at]) && upper(&sides[end]) == upper(&sides[at])) end++;
    return end - at;
}
