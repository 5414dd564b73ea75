// SPDX-License-Identifier: Apache-2.0
// kn_mesh_cut.
//
// Nothing but edges is cut, and where depends on the edge's two ends and the segment alone: triangles on both sides
// of an edge, also of two meshes, stay side by side, wherever they stand in space. First the ends of segments become
// vertices, on edges that pass them and inside triangles; then whatever edge a segment crosses is cut there.
#include "mesh/net.h"

#include "kernel/hash.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_TRIANGLES ((size_t)1 << 24)
static const uint32_t none = UINT32_MAX;

typedef struct split {
    uint32_t a, b, vertex; // a < b; b = 0: empty
} split;

typedef struct cutting {
    kn_mesh mesh;
    double near;
    split *splits; // of one step: open addressing, a power of two
    size_t nsplits, nslots;
} cutting;

// What an edge is asked in one step: whether it is cut at *point, and where along it.
typedef struct step {
    const kn_mesh_segment *segment;
    const double *end; // the end that becomes a vertex; NULL: the segment cuts
    double normal[2];  // unit normal, to the left
} step;

static const double *at(const cutting *c, uint32_t vertex)
{
    return c->mesh.position + 3 * (size_t)vertex;
}

static double cross(const double *o, const double *a, const double *b)
{
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

static bool comes_first(const double *p, const double *q)
{
    for (int k = 0; k < 3; k++)
        if (p[k] != q[k]) return p[k] < q[k];
    return false;
}

// ---- where an edge is cut; p comes before q ----

static bool passes(double *t, const double *p, const double *q, const double *end, double near)
{
    const double way[2] = {q[0] - p[0], q[1] - p[1]}, to[2] = {end[0] - p[0], end[1] - p[1]};
    double length = hypot(way[0], way[1]);
    if (!(length > 2.0 * near)) return false;
    double along = (way[0] * to[0] + way[1] * to[1]) / length;
    if (!(along > near && along < length - near) || !(fabs(cross(p, q, end)) <= near * length)) return false;
    *t = along / length;
    return true;
}

static double side_of(const step *s, const double *p)
{
    return s->normal[0] * (p[0] - s->segment->from[0]) + s->normal[1] * (p[1] - s->segment->from[1]);
}

static bool crosses(double *t, const step *s, const double *p, const double *q, double near)
{
    double a = side_of(s, p), b = side_of(s, q);
    if (!((a > near && b < -near) || (a < -near && b > near))) return false;
    if ((cross(p, q, s->segment->from) > 0.0) == (cross(p, q, s->segment->to) > 0.0)) return false;
    *t = a / (a - b);
    return true;
}

// ---- vertices ----

static kn_status new_vertex(kn_ctx *ctx, cutting *c, uint32_t *vertex)
{
    if (c->mesh.nvertices >= none) return kn_fail(ctx, KN_ELIMIT, "mesh: %zu vertices", c->mesh.nvertices);
    kn_status status = kn_mesh_reserve(ctx, &c->mesh, 1, 0, c->mesh.normal != NULL);
    if (status == KN_OK) *vertex = (uint32_t)c->mesh.nvertices++;
    return status;
}

// The sum of the corners' normals by their weights, of length 1; the first one's where that vanishes.
static void mean_normal(cutting *c, uint32_t vertex, const uint32_t *of, const double *weight, int n)
{
    double *out = c->mesh.normal + 3 * (size_t)vertex, sum[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) sum[k] += weight[i] * c->mesh.normal[3 * (size_t)of[i] + (size_t)k];
    double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    for (int k = 0; k < 3; k++)
        out[k] = length > 0.0 ? sum[k] / length : c->mesh.normal[3 * (size_t)of[0] + (size_t)k];
}

// The vertex at t of the way from p to q, in its place in the plane where that is known.
static kn_status cut_edge(kn_ctx *ctx, cutting *c, uint32_t *vertex, const step *s, uint32_t p, uint32_t q, double t)
{
    kn_status status = new_vertex(ctx, c, vertex);
    if (status != KN_OK) return status;
    double *out = c->mesh.position + 3 * (size_t)*vertex;
    for (int k = 0; k < 3; k++) out[k] = at(c, p)[k] + t * (at(c, q)[k] - at(c, p)[k]);
    for (int k = 0; k < 2; k++) {
        if (s->end)
            out[k] = s->end[k];
        else if (s->segment->from[k] == s->segment->to[k])
            out[k] = s->segment->from[k];
    }
    if (c->mesh.normal) mean_normal(c, *vertex, (const uint32_t[]){p, q}, (const double[]){1.0 - t, t}, 2);
    return KN_OK;
}

// ---- edges that are cut ----

static split *slot_of(const cutting *c, uint32_t a, uint32_t b)
{
    size_t slot = (size_t)kn_hash_mix((uint64_t)a << 32 | b) & (c->nslots - 1);
    while (c->splits[slot].b > 0 && (c->splits[slot].a != a || c->splits[slot].b != b))
        slot = (slot + 1) & (c->nslots - 1);
    return &c->splits[slot];
}

static kn_status grow_splits(kn_ctx *ctx, cutting *c)
{
    if (2 * (c->nsplits + 1) < c->nslots) return KN_OK;
    cutting more = {.nslots = c->nslots > 0 ? 2 * c->nslots : 64};
    more.splits = kn_alloc_zero(ctx, more.nslots, sizeof *more.splits);
    if (!more.splits) return KN_ENOMEM;
    for (size_t i = 0; i < c->nslots; i++)
        if (c->splits[i].b > 0) *slot_of(&more, c->splits[i].a, c->splits[i].b) = c->splits[i];
    kn_free(ctx, c->splits);
    c->splits = more.splits, c->nslots = more.nslots;
    return KN_OK;
}

static kn_status ask_edge(kn_ctx *ctx, cutting *c, uint32_t *middle, const step *s, uint32_t a, uint32_t b)
{
    bool swap = comes_first(at(c, b), at(c, a));
    uint32_t p = swap ? b : a, q = swap ? a : b;
    double t = 0.0;
    *middle = none;
    if (s->end ? !passes(&t, at(c, p), at(c, q), s->end, c->near) : !crosses(&t, s, at(c, p), at(c, q), c->near))
        return KN_OK;
    kn_status status = grow_splits(ctx, c);
    if (status != KN_OK) return status;
    split *found = slot_of(c, a < b ? a : b, a < b ? b : a);
    if (found->b == 0) {
        uint32_t vertex = 0;
        status = cut_edge(ctx, c, &vertex, s, p, q, t);
        if (status != KN_OK) return status;
        *found = (split){a < b ? a : b, a < b ? b : a, vertex};
        c->nsplits++;
    }
    *middle = found->vertex;
    return KN_OK;
}

// ---- triangles ----

// Replaces triangle t by n others.
static kn_status replace(kn_ctx *ctx, cutting *c, size_t t, const uint32_t (*by)[3], int n)
{
    if (c->mesh.ntriangles + (size_t)n > MOST_TRIANGLES)
        return kn_fail(ctx, KN_ELIMIT, "mesh: more than %zu triangles to cut", MOST_TRIANGLES);
    kn_status status = kn_mesh_reserve(ctx, &c->mesh, 0, (size_t)n - 1, c->mesh.normal != NULL);
    if (status != KN_OK) return status;
    memcpy(c->mesh.triangle + 3 * t, by[0], sizeof *by);
    memcpy(c->mesh.triangle + 3 * c->mesh.ntriangles, by[1], (size_t)(n - 1) * sizeof *by);
    c->mesh.ntriangles += (size_t)n - 1;
    return KN_OK;
}

// middle[k]: on the edge from corner k on.
static kn_status divide(kn_ctx *ctx, cutting *c, size_t t, const uint32_t middle[3])
{
    uint32_t v[3], m[3], n = 0;
    size_t first = 0; // so that the last edges are those that stay
    for (size_t k = 0; k < 3; k++) n += middle[k] != none;
    for (size_t k = 0; k < 3; k++)
        if (middle[k] != none && (n == 1 || middle[(k + 2) % 3] == none)) first = k;
    for (size_t k = 0; k < 3; k++) {
        v[k] = c->mesh.triangle[3 * t + (first + k) % 3];
        m[k] = middle[(first + k) % 3];
    }
    const uint32_t one[2][3] = {{v[0], m[0], v[2]}, {m[0], v[1], v[2]}};
    const uint32_t two[3][3] = {{m[0], v[1], m[1]}, {v[0], m[0], m[1]}, {v[0], m[1], v[2]}};
    const uint32_t three[4][3] = {{v[0], m[0], m[2]}, {m[0], v[1], m[1]}, {m[1], v[2], m[2]}, {m[0], m[1], m[2]}};
    return n == 1 ? replace(ctx, c, t, one, 2) : n == 2 ? replace(ctx, c, t, two, 3) : replace(ctx, c, t, three, 4);
}

// Three triangles around the end, where it lies clear of all edges; nothing where it does not lie inside.
static kn_status divide_inside(kn_ctx *ctx, cutting *c, size_t t, const double *end)
{
    const uint32_t v[3] = {c->mesh.triangle[3 * t], c->mesh.triangle[3 * t + 1], c->mesh.triangle[3 * t + 2]};
    double area[3], whole = cross(at(c, v[0]), at(c, v[1]), at(c, v[2])), sign = whole < 0.0 ? -1.0 : 1.0, z = 0.0;
    for (int k = 0; k < 3; k++) {
        const double *p = at(c, v[(k + 1) % 3]), *q = at(c, v[(k + 2) % 3]);
        area[k] = sign * cross(p, q, end);
        if (!(area[k] > c->near * hypot(q[0] - p[0], q[1] - p[1]))) return KN_OK;
        area[k] /= fabs(whole);
        z += area[k] * at(c, v[k])[2];
    }
    uint32_t m = 0;
    kn_status status = new_vertex(ctx, c, &m);
    if (status != KN_OK) return status;
    memcpy(c->mesh.position + 3 * (size_t)m, (const double[]){end[0], end[1], z}, 3 * sizeof z);
    if (c->mesh.normal) mean_normal(c, m, v, area, 3);
    return replace(ctx, c, t, (const uint32_t[3][3]){{v[0], v[1], m}, {v[1], v[2], m}, {v[2], v[0], m}}, 3);
}

static bool meets(const cutting *c, size_t t, const double lo[2], const double hi[2])
{
    const uint32_t *v = c->mesh.triangle + 3 * t;
    for (int d = 0; d < 2; d++) {
        double p = at(c, v[0])[d], q = at(c, v[1])[d], r = at(c, v[2])[d];
        if ((p < lo[d] && q < lo[d] && r < lo[d]) || (p > hi[d] && q > hi[d] && r > hi[d])) return false;
    }
    return true;
}

static kn_status take_step(kn_ctx *ctx, cutting *c, const step *s)
{
    double lo[2], hi[2];
    kn_status status = KN_OK;
    for (int d = 0; d < 2; d++) {
        lo[d] = (s->end ? s->end[d] : fmin(s->segment->from[d], s->segment->to[d])) - c->near;
        hi[d] = (s->end ? s->end[d] : fmax(s->segment->from[d], s->segment->to[d])) + c->near;
    }
    if (c->nsplits > 0) memset(c->splits, 0, c->nslots * sizeof *c->splits);
    c->nsplits = 0;
    for (size_t t = 0, n = c->mesh.ntriangles; status == KN_OK && t < n; t++) {
        uint32_t middle[3] = {none, none, none};
        if (!meets(c, t, lo, hi)) continue;
        for (size_t k = 0; status == KN_OK && k < 3; k++) {
            const uint32_t *v = c->mesh.triangle + 3 * t;
            status = ask_edge(ctx, c, &middle[k], s, v[k], v[(k + 1) % 3]);
        }
        if (status != KN_OK) break;
        if (middle[0] != none || middle[1] != none || middle[2] != none)
            status = divide(ctx, c, t, middle);
        else if (s->end)
            status = divide_inside(ctx, c, t, s->end);
    }
    return status;
}

// ---- all ----

static int compare_points(const void *a, const void *b)
{
    const double *p = a, *q = b;
    for (int k = 0; k < 2; k++)
        if (p[k] != q[k]) return p[k] < q[k] ? -1 : 1;
    return 0;
}

static int compare_segments(const void *a, const void *b)
{
    const kn_mesh_segment *x = a, *y = b;
    int order = compare_points(x->from, y->from);
    return order != 0 ? order : compare_points(x->to, y->to);
}

static kn_status check(kn_ctx *ctx, const kn_mesh *mesh, const kn_mesh_segment *segments, size_t n, double near)
{
    if (!(near > 0.0) || !isfinite(near)) return kn_fail(ctx, KN_EDOMAIN, "mesh: near is %g", near);
    for (size_t i = 0; i < n; i++)
        for (int d = 0; d < 2; d++)
            if (!isfinite(segments[i].from[d]) || !isfinite(segments[i].to[d]))
                return kn_fail(ctx, KN_EDOMAIN, "mesh: segment %zu is not finite", i);
    return kn_mesh_check(ctx, mesh);
}

static kn_status insert_ends(kn_ctx *ctx, cutting *c, const kn_mesh_segment *segments, size_t n)
{
    kn_mark mark = kn_scratch_mark(ctx);
    double(*ends)[2] = kn_scratch(ctx, 2 * n, sizeof *ends);
    if (!ends) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) {
        memcpy(ends[2 * i], segments[i].from, sizeof *ends);
        memcpy(ends[2 * i + 1], segments[i].to, sizeof *ends);
    }
    qsort(ends, 2 * n, sizeof *ends, compare_points);
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < 2 * n; i++) {
        if (i > 0 && compare_points(ends[i - 1], ends[i]) == 0) continue;
        status = take_step(ctx, c, &(step){.end = ends[i]});
        if (status == KN_OK) status = kn_progress(ctx, "mesh", 0.25 * (double)i / (double)n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status cut_along(kn_ctx *ctx, cutting *c, const kn_mesh_segment *segments, size_t n)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_mesh_segment *sorted = kn_scratch(ctx, n, sizeof *sorted);
    if (!sorted) return KN_ENOMEM;
    memcpy(sorted, segments, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare_segments);
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        const double *from = sorted[i].from, *to = sorted[i].to;
        double length = hypot(to[0] - from[0], to[1] - from[1]);
        step s = {.segment = &sorted[i]};
        s.normal[0] = (from[1] - to[1]) / length, s.normal[1] = (to[0] - from[0]) / length;
        if (length > c->near) status = take_step(ctx, c, &s); // what crosses a shorter one passes its ends
        if (status == KN_OK) status = kn_progress(ctx, "mesh", 0.5 + 0.5 * (double)i / (double)n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_mesh_cut(kn_ctx *ctx, kn_mesh *mesh, const kn_mesh_segment *segments, size_t n, double near)
{
    cutting c = {.near = near};
    kn_status status = check(ctx, mesh, segments, n, near);
    if (status != KN_OK || n == 0) return status;
    status = kn_mesh_copy(ctx, &c.mesh, mesh);
    if (status == KN_OK) status = insert_ends(ctx, &c, segments, n);
    if (status == KN_OK) status = cut_along(ctx, &c, segments, n);
    if (status == KN_OK) {
        kn_mesh old = *mesh;
        *mesh = c.mesh;
        c.mesh = old;
    }
    kn_mesh_clear(ctx, &c.mesh);
    kn_free(ctx, c.splits);
    return status;
}
