// SPDX-License-Identifier: Apache-2.0
// kn_mesh_map_by, kn_mesh_map: a mesh through a map, its edges split until the image is near enough.
//
// Whether an edge is split depends on its two ends alone, and it is split in its middle: triangles that share it, of
// one mesh or of two, agree about all that becomes of it, and the result has no gaps. A triangle none of whose edges
// is split, and whose image is bent all the same, gets a vertex inside.
#include "mesh/net.h"

#include <knurl/mesh.h>

#include <math.h>
#include <string.h>

enum { MOST_LEVELS = 12 };
#define MOST_TRIANGLES ((size_t)1 << 24)

typedef struct edge {
    uint32_t a, b;   // a < b
    uint32_t middle; // 1 + the vertex there; 0: it is not split
    bool used;
} edge;

typedef struct triangle {
    uint32_t corner[3];
    uint8_t level[3]; // of the edges that begin at the corners
} triangle;

typedef struct mapping {
    kn_mesh_function function;
    void *user;
    double tolerance;
    size_t limit;
    double deviation; // largest one that is left
    // Vertices: where they come from, their normals there (0: none) and their images.
    double *from, *from_normal, *to;
    size_t nvertices, vertex_room;
    edge *edges; // open addressing, a power of two
    size_t nedges, nslots;
    triangle *stack;
    size_t nstack, stack_room;
    uint32_t *done;
    size_t ndone, done_room;
} mapping;

static void mapping_clear(kn_ctx *ctx, mapping *m)
{
    kn_free(ctx, m->from);
    kn_free(ctx, m->from_normal);
    kn_free(ctx, m->to);
    kn_free(ctx, m->edges);
    kn_free(ctx, m->stack);
    kn_free(ctx, m->done);
}

// ---- vertices ----

static kn_status grow_vertices(kn_ctx *ctx, mapping *m)
{
    if (m->nvertices < m->vertex_room) return KN_OK;
    if (m->nvertices >= UINT32_MAX / 2) return kn_fail(ctx, KN_ELIMIT, "mesh: %zu vertices", m->nvertices);
    size_t room = 2 * m->vertex_room;
    double **const list[3] = {&m->from, &m->from_normal, &m->to};
    for (int k = 0; k < 3; k++) {
        double *longer = kn_resize(ctx, *list[k], room, 3 * sizeof *longer);
        if (!longer) return KN_ENOMEM;
        *list[k] = longer;
    }
    m->vertex_room = room;
    return KN_OK;
}

static kn_status image(kn_ctx *ctx, const mapping *m, double to[3], const double from[3])
{
    return m->function(ctx, m->user, to, NULL, from, NULL);
}

// A vertex between others: their means, the normal's length made one.
static kn_status add_mean(kn_ctx *ctx, mapping *m, uint32_t *out, const uint32_t *of, size_t n)
{
    kn_status status = grow_vertices(ctx, m);
    if (status != KN_OK) return status;
    double *from = m->from + 3 * m->nvertices, *normal = m->from_normal + 3 * m->nvertices, square = 0.0;
    for (size_t c = 0; c < 3; c++) {
        double sum = 0.0;
        normal[c] = 0.0;
        for (size_t k = 0; k < n; k++) {
            sum += m->from[3 * (size_t)of[k] + c];
            normal[c] += m->from_normal[3 * (size_t)of[k] + c];
        }
        from[c] = sum / (double)n;
        square += normal[c] * normal[c];
    }
    for (size_t c = 0; c < 3 && square > 0.0; c++) normal[c] /= sqrt(square);
    status = image(ctx, m, m->to + 3 * m->nvertices, from);
    if (status == KN_OK) *out = (uint32_t)m->nvertices++;
    return status;
}

// ---- edges ----

static size_t slot_of(const mapping *m, uint32_t a, uint32_t b)
{
    uint64_t x = ((uint64_t)a << 32 | b) * 0x9e3779b97f4a7c15u;
    for (size_t at = (size_t)(x ^ x >> 32);; at++) {
        const edge *e = &m->edges[at &= m->nslots - 1];
        if (!e->used || (e->a == a && e->b == b)) return at;
    }
}

static kn_status grow_edges(kn_ctx *ctx, mapping *m)
{
    if (2 * m->nedges < m->nslots) return KN_OK;
    mapping longer = *m;
    longer.nslots = m->nslots > 0 ? 2 * m->nslots : 256;
    longer.edges = kn_alloc_zero(ctx, longer.nslots, sizeof *longer.edges);
    if (!longer.edges) return KN_ENOMEM;
    for (size_t i = 0; i < m->nslots; i++)
        if (m->edges[i].used) longer.edges[slot_of(&longer, m->edges[i].a, m->edges[i].b)] = m->edges[i];
    kn_free(ctx, m->edges);
    m->edges = longer.edges;
    m->nslots = longer.nslots;
    return KN_OK;
}

// The distance of p from the segment between a and b; from a where they are one.
static double off_segment(const double *p, const double *a, const double *b)
{
    double along = 0.0, square = 0.0, sum = 0.0;
    for (int c = 0; c < 3; c++) {
        along += (p[c] - a[c]) * (b[c] - a[c]);
        square += (b[c] - a[c]) * (b[c] - a[c]);
    }
    double t = square > 0.0 ? fmin(fmax(along / square, 0.0), 1.0) : 0.0;
    for (int c = 0; c < 3; c++) {
        double d = p[c] - (a[c] + t * (b[c] - a[c]));
        sum += d * d;
    }
    return sqrt(sum);
}

// The largest distance of three points of the image, at quarters of the edge, from its chord: the same whichever end
// comes first.
static kn_status bend(kn_ctx *ctx, const mapping *m, double *out, uint32_t a, uint32_t b)
{
    const double *p = m->from + 3 * (size_t)a, *q = m->from + 3 * (size_t)b;
    const double *x = m->to + 3 * (size_t)a, *y = m->to + 3 * (size_t)b;
    double at[3][3], to[3];
    for (int c = 0; c < 3; c++) {
        at[1][c] = (p[c] + q[c]) / 2.0;
        at[0][c] = (p[c] + at[1][c]) / 2.0;
        at[2][c] = (q[c] + at[1][c]) / 2.0;
    }
    *out = 0.0;
    for (int k = 0; k < 3; k++) {
        kn_status status = image(ctx, m, to, at[k]);
        if (status != KN_OK) return status;
        double one = off_segment(to, x, y), other = off_segment(to, y, x);
        *out = fmax(*out, fmax(one, other));
    }
    return KN_OK;
}

// *middle: 1 + the vertex in the middle of the edge, which is made, or 0: the edge stays whole.
static kn_status ask_edge(kn_ctx *ctx, mapping *m, uint32_t *middle, uint32_t p, uint32_t q, int level)
{
    uint32_t a = p < q ? p : q, b = p < q ? q : p;
    kn_status status = grow_edges(ctx, m);
    if (status != KN_OK) return status;
    size_t at = slot_of(m, a, b);
    if (!m->edges[at].used) {
        edge e = {.a = a, .b = b, .used = true};
        double amount = 0.0;
        if (m->tolerance > 0.0) status = bend(ctx, m, &amount, a, b);
        if (status == KN_OK && amount > m->tolerance && level < MOST_LEVELS) {
            uint32_t vertex = 0;
            status = add_mean(ctx, m, &vertex, (const uint32_t[]){a, b}, 2);
            e.middle = vertex + 1;
        } else {
            m->deviation = fmax(m->deviation, amount);
        }
        if (status != KN_OK) return status;
        m->edges[at] = e;
        m->nedges++;
    }
    *middle = m->edges[at].middle;
    return KN_OK;
}

// ---- triangles ----

static kn_status push(kn_ctx *ctx, mapping *m, uint32_t a, uint32_t b, uint32_t c, const int *level)
{
    if (m->nstack == m->stack_room) {
        size_t room = m->stack_room > 0 ? 2 * m->stack_room : 64;
        triangle *list = kn_resize(ctx, m->stack, room, sizeof *list);
        if (!list) return KN_ENOMEM;
        m->stack = list;
        m->stack_room = room;
    }
    triangle t = {{a, b, c}, {0, 0, 0}};
    for (int k = 0; k < 3; k++) t.level[k] = (uint8_t)level[k];
    m->stack[m->nstack++] = t;
    return KN_OK;
}

static kn_status finish(kn_ctx *ctx, mapping *m, const uint32_t corner[3])
{
    if (m->ndone == m->limit)
        return kn_fail(ctx, KN_ELIMIT, "mesh: more than %zu triangles for a tolerance of %g", m->limit, m->tolerance);
    if (m->ndone == m->done_room) {
        size_t room = m->done_room > 0 ? 2 * m->done_room : 64;
        uint32_t *list = kn_resize(ctx, m->done, room, 3 * sizeof *list);
        if (!list) return KN_ENOMEM;
        m->done = list;
        m->done_room = room;
    }
    memcpy(m->done + 3 * m->ndone++, corner, 3 * sizeof *corner);
    return KN_OK;
}

// The distance of the image of the triangle's middle from the plane of its corners' images.
static kn_status bulge(kn_ctx *ctx, const mapping *m, double *out, const uint32_t corner[3])
{
    double at[3], to[3], a[3], b[3], n[3], length = 0.0, height = 0.0;
    const double *p[3], *q[3];
    for (int k = 0; k < 3; k++) p[k] = m->from + 3 * (size_t)corner[k], q[k] = m->to + 3 * (size_t)corner[k];
    for (int c = 0; c < 3; c++) at[c] = (p[0][c] + p[1][c] + p[2][c]) / 3.0;
    kn_status status = image(ctx, m, to, at);
    for (int c = 0; c < 3; c++) a[c] = q[1][c] - q[0][c], b[c] = q[2][c] - q[0][c];
    for (int c = 0; c < 3; c++) {
        n[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
        length += n[c] * n[c];
    }
    for (int c = 0; c < 3 && status == KN_OK; c++) height += n[c] * (to[c] - q[0][c]);
    *out = length > 0.0 ? fabs(height) / sqrt(length) : 0.0;
    return status;
}

// Three triangles around a vertex in the middle.
static kn_status split_inside(kn_ctx *ctx, mapping *m, const triangle *t)
{
    uint32_t middle = 0;
    int inner = 1 + t->level[0];
    for (int k = 1; k < 3; k++) inner = t->level[k] >= inner ? 1 + t->level[k] : inner;
    kn_status status = add_mean(ctx, m, &middle, t->corner, 3);
    for (int k = 0; k < 3 && status == KN_OK; k++)
        status = push(ctx, m, t->corner[k], t->corner[(k + 1) % 3], middle, (const int[]){t->level[k], inner, inner});
    return status;
}

// Cuts off the corner between split edges, or all three; all pieces keep t's sense.
static kn_status split_edges(kn_ctx *ctx, mapping *m, const triangle *t, const uint32_t *middle, int nsplit)
{
    int r = 0, inner = t->level[0] + 1; // r: the corner to begin with
    for (int k = 1; k < 3; k++) inner = t->level[k] >= inner ? 1 + t->level[k] : inner;
    if (nsplit == 1)
        while (!middle[r]) r++;
    if (nsplit == 2)
        while (middle[(r + 2) % 3]) r++;
    uint32_t p = t->corner[r], q = t->corner[(r + 1) % 3], s = t->corner[(r + 2) % 3];
    uint32_t pq = middle[r] - 1, qs = middle[(r + 1) % 3] - 1, sp = middle[(r + 2) % 3] - 1;
    const int a = t->level[r], b = t->level[(r + 1) % 3], c = t->level[(r + 2) % 3];
    kn_status status = KN_OK;
    if (nsplit == 1) { // p-q alone
        status = push(ctx, m, p, pq, s, (const int[]){a + 1, inner, c});
        return status == KN_OK ? push(ctx, m, pq, q, s, (const int[]){a + 1, b, inner}) : status;
    }
    status = push(ctx, m, pq, q, qs, (const int[]){a + 1, b + 1, inner});
    if (status != KN_OK) return status;
    if (nsplit == 2) { // s-p is whole
        status = push(ctx, m, p, pq, qs, (const int[]){a + 1, inner, inner});
        return status == KN_OK ? push(ctx, m, p, qs, s, (const int[]){inner, b + 1, c}) : status;
    }
    status = push(ctx, m, p, pq, sp, (const int[]){a + 1, inner, c + 1});
    if (status == KN_OK) status = push(ctx, m, qs, s, sp, (const int[]){b + 1, c + 1, inner});
    return status == KN_OK ? push(ctx, m, pq, qs, sp, (const int[]){inner, inner, inner}) : status;
}

static kn_status take(kn_ctx *ctx, mapping *m)
{
    triangle t = m->stack[--m->nstack];
    uint32_t middle[3] = {0, 0, 0};
    int nsplit = 0;
    kn_status status = KN_OK;
    for (int k = 0; k < 3 && status == KN_OK; k++) {
        status = ask_edge(ctx, m, &middle[k], t.corner[k], t.corner[(k + 1) % 3], t.level[k]);
        nsplit += middle[k] != 0;
    }
    if (status != KN_OK) return status;
    if (nsplit > 0) return split_edges(ctx, m, &t, middle, nsplit);
    double amount = 0.0;
    if (m->tolerance > 0.0) status = bulge(ctx, m, &amount, t.corner);
    if (status != KN_OK) return status;
    bool last = t.level[0] >= MOST_LEVELS || t.level[1] >= MOST_LEVELS || t.level[2] >= MOST_LEVELS;
    if (amount > m->tolerance && !last) return split_inside(ctx, m, &t);
    m->deviation = fmax(m->deviation, amount);
    return finish(ctx, m, t.corner);
}

// ---- the whole ----

static void add_cross(double *sum, const double *p, const double *q, const double *r)
{
    double a[3], b[3];
    for (int c = 0; c < 3; c++) a[c] = q[c] - p[c], b[c] = r[c] - p[c];
    for (int c = 0; c < 3; c++) sum[c] += a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static void normalize(double *n)
{
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int c = 0; c < 3; c++) n[c] = length > 0.0 ? n[c] / length : c == 2;
}

// The means of the normals of the triangles around each vertex, weighted by their areas.
static void average_normals(double *normal, const double *position, size_t nvertices, const uint32_t *corner,
                            size_t ntriangles)
{
    memset(normal, 0, 3 * nvertices * sizeof *normal);
    for (size_t t = 0; t < ntriangles; t++)
        for (int k = 0; k < 3; k++) {
            const uint32_t *v = corner + 3 * t;
            add_cross(normal + 3 * (size_t)v[k], position + 3 * (size_t)v[0], position + 3 * (size_t)v[1],
                      position + 3 * (size_t)v[2]);
        }
    for (size_t i = 0; i < nvertices; i++) normalize(normal + 3 * i);
}

static kn_status begin(kn_ctx *ctx, mapping *m, const kn_mesh *mesh)
{
    size_t n = mesh->nvertices;
    m->vertex_room = n + n / 2 + 8;
    m->from = kn_alloc(ctx, m->vertex_room, 3 * sizeof *m->from);
    m->from_normal = kn_alloc(ctx, m->vertex_room, 3 * sizeof *m->from_normal);
    m->to = kn_alloc(ctx, m->vertex_room, 3 * sizeof *m->to);
    if (!m->from || !m->from_normal || !m->to) return KN_ENOMEM;
    m->nvertices = n;
    if (n > 0) memcpy(m->from, mesh->position, 3 * n * sizeof *m->from);
    if (n > 0 && mesh->normal)
        memcpy(m->from_normal, mesh->normal, 3 * n * sizeof *m->from_normal);
    else
        average_normals(m->from_normal, mesh->position, n, mesh->triangle, mesh->ntriangles);
    for (size_t i = 0; i < n; i++) {
        kn_status status = image(ctx, m, m->to + 3 * i, m->from + 3 * i);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

// Where T has no normal, or the vertex had none, it is what the triangles say.
static kn_status map_normals(kn_ctx *ctx, const mapping *m, double *normal, bool reversed)
{
    average_normals(normal, m->to, m->nvertices, m->done, m->ndone);
    for (size_t i = 0; i < m->nvertices; i++) {
        double point[3], n[3] = {0.0, 0.0, 0.0};
        kn_status status = m->function(ctx, m->user, point, n, m->from + 3 * i, m->from_normal + 3 * i);
        if (status != KN_OK) return status;
        bool known = n[0] != 0.0 || n[1] != 0.0 || n[2] != 0.0;
        for (size_t c = 0; c < 3; c++) {
            if (known)
                normal[3 * i + c] = n[c];
            else if (reversed)
                normal[3 * i + c] = -normal[3 * i + c];
        }
    }
    return KN_OK;
}

static kn_status check(kn_ctx *ctx, const kn_mesh *mesh, const kn_mesh_map_options *o)
{
    if (!(o->tolerance >= 0.0) || isinf(o->tolerance))
        return kn_fail(ctx, KN_EDOMAIN, "mesh: a tolerance of %g", o->tolerance);
    return kn_mesh_check(ctx, mesh);
}

static kn_status map_triangles(kn_ctx *ctx, mapping *m, const kn_mesh *mesh)
{
    static const int whole[3] = {0, 0, 0};
    kn_status status = KN_OK;
    for (size_t t = 0; t < mesh->ntriangles && status == KN_OK; t++) {
        const uint32_t *v = mesh->triangle + 3 * t;
        status = push(ctx, m, v[0], v[1], v[2], whole);
        while (status == KN_OK && m->nstack > 0) status = take(ctx, m);
        if (status == KN_OK && t % 64 == 63) status = kn_progress(ctx, "mesh", (double)t / (double)mesh->ntriangles);
    }
    return status;
}

kn_mesh_map_options kn_mesh_map_defaults(void)
{
    return (kn_mesh_map_options){0};
}

kn_status kn_mesh_map_by(kn_ctx *ctx, kn_mesh *out, double *deviation, const kn_mesh *mesh, kn_mesh_function function,
                         void *user, const kn_mesh_map_options *options)
{
    kn_mesh_map_options o = options ? *options : kn_mesh_map_defaults();
    mapping m = {.function = function, .user = user, .tolerance = o.tolerance};
    m.limit = o.max_triangles > 0 ? o.max_triangles : MOST_TRIANGLES;
    double *normal = NULL;
    kn_status status = check(ctx, mesh, &o);
    if (status == KN_OK) status = begin(ctx, &m, mesh);
    if (status == KN_OK) status = map_triangles(ctx, &m, mesh);
    if (status == KN_OK) normal = kn_alloc(ctx, m.vertex_room, 3 * sizeof *normal);
    if (status == KN_OK && !normal) status = KN_ENOMEM;
    if (status == KN_OK) status = map_normals(ctx, &m, normal, o.reversed);
    if (status == KN_OK) {
        kn_mesh made = {.nvertices = m.nvertices, .ntriangles = m.ndone, .position = m.to, .normal = normal};
        made.triangle = m.done, made.vertex_room = m.vertex_room, made.triangle_room = m.done_room;
        for (size_t t = 0; o.reversed && t < made.ntriangles; t++) {
            uint32_t *v = made.triangle + 3 * t, second = v[1];
            v[1] = v[2], v[2] = second;
        }
        if (deviation) *deviation = m.deviation;
        kn_mesh_clear(ctx, out); // last: it may be mesh
        *out = made;
        m.to = NULL, m.done = NULL, normal = NULL;
    }
    kn_free(ctx, normal);
    mapping_clear(ctx, &m);
    return status;
}
