// SPDX-License-Identifier: Apache-2.0
// Two closed meshes on one sphere become one (Alexa, Merging polyhedral shapes with scattered features, Visual
// Computer 16, 2000).
//
// Faces are the places where a triangle of a and one of b overlap: convex, of at most six corners. All follows from
// signs of det(p, q, r) of three vertices on the sphere, each certain (kn_mesh_turn), so that what is built is what
// there is. From a face one goes over its edges to those beside it.
//
// Inside a triangle of a, and of b, the map to space is the projection from the centre onto a plane: great circles
// are straight lines, hence the faces are flat pieces of the triangles of a as they are of those of b.
#include "mesh/overlay.h"
#include "kernel/context.h"
#include "kernel/hash.h"
#include "mesh/edges.h"
#include "mesh/sphere.h"

#include <string.h>

enum { MOST_FACES = 1 << 24, MOST_SEGMENTS = 6 };
static const uint32_t none = UINT32_MAX;

// ---- numbers by pairs of numbers ----

typedef struct table {
    uint64_t *key; // UINT64_MAX: none
    uint32_t *value;
    size_t room, count; // room: a power of two
} table;

static size_t slot_of(const table *t, uint64_t key)
{
    size_t at = (size_t)kn_hash_mix(key) & (t->room - 1);
    while (t->key[at] != UINT64_MAX && t->key[at] != key) at = (at + 1) & (t->room - 1);
    return at;
}

static kn_status table_grow(kn_ctx *ctx, table *t)
{
    size_t room = t->room > 0 ? 2 * t->room : 64;
    table more = {.key = kn_alloc(ctx, room, sizeof *more.key),
                  .value = kn_alloc(ctx, room, sizeof *more.value),
                  .room = room,
                  .count = t->count};
    if (!more.key || !more.value) {
        kn_free(ctx, more.key);
        kn_free(ctx, more.value);
        return KN_ENOMEM;
    }
    memset(more.key, 0xff, room * sizeof *more.key);
    for (size_t i = 0; i < t->room; i++) {
        if (t->key[i] == UINT64_MAX) continue;
        size_t at = slot_of(&more, t->key[i]);
        more.key[at] = t->key[i];
        more.value[at] = t->value[i];
    }
    kn_free(ctx, t->key);
    kn_free(ctx, t->value);
    *t = more;
    return KN_OK;
}

// *value = that of (x, y), which becomes `otherwise` if there is none; *is_new tells.
static kn_status table_get(kn_ctx *ctx, table *t, uint32_t x, uint32_t y, uint32_t otherwise, uint32_t *value,
                           bool *is_new)
{
    kn_status status = 2 * (t->count + 1) > t->room ? table_grow(ctx, t) : KN_OK;
    if (status != KN_OK) return status;
    uint64_t key = (uint64_t)x << 32 | y;
    size_t at = slot_of(t, key);
    *is_new = t->key[at] == UINT64_MAX;
    if (*is_new) {
        t->key[at] = key;
        t->value[at] = otherwise;
        t->count++;
    }
    *value = t->value[at];
    return KN_OK;
}

static void table_clear(kn_ctx *ctx, table *t)
{
    kn_free(ctx, t->key);
    kn_free(ctx, t->value);
    *t = (table){0};
}

// ---- a mesh on the sphere ----

typedef struct layer {
    const kn_mesh *mesh;
    double *xyz;
    uint32_t *twin;   // of side k of triangle t, at 3 t + k: the other side of its edge
    uint32_t *vertex; // of the result
} layer;

static kn_status layer_init(kn_ctx *ctx, layer *l, const kn_mesh *mesh, const double *on)
{
    size_t n = 3 * mesh->ntriangles;
    l->mesh = mesh;
    l->xyz = kn_alloc(ctx, mesh->nvertices, 3 * sizeof *l->xyz);
    l->twin = kn_alloc(ctx, n, sizeof *l->twin);
    l->vertex = kn_alloc(ctx, mesh->nvertices, sizeof *l->vertex);
    kn_mesh_side *sides = kn_mesh_sides(ctx, mesh);
    bool ok = l->xyz && l->twin && l->vertex && sides;
    if (ok) memcpy(l->xyz, on, 3 * mesh->nvertices * sizeof *on);
    for (size_t i = 0; ok && i < n; i += 2)
        for (size_t k = 0; k < 2; k++) {
            const kn_mesh_side *s = &sides[i + k], *other = &sides[i + 1 - k];
            l->twin[3 * s->triangle + (uint32_t)s->corner] = 3 * other->triangle + (uint32_t)other->corner;
        }
    kn_free(ctx, sides);
    return ok ? KN_OK : KN_ENOMEM;
}

static void layer_clear(kn_ctx *ctx, layer *l)
{
    kn_free(ctx, l->xyz);
    kn_free(ctx, l->twin);
    kn_free(ctx, l->vertex);
}

static const double *on_sphere(const layer *l, uint32_t corner)
{
    return l->xyz + 3 * (size_t)l->mesh->triangle[corner];
}

static const double *in_space(const layer *l, uint32_t corner)
{
    return l->mesh->position + 3 * (size_t)l->mesh->triangle[corner];
}

// Turned by an angle about (2, 3, 6) / 7, which is along no axis of symmetry of what is often drawn.
static void turn_layer(layer *l, const double *on, double angle)
{
    static const double axis[3] = {2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0};
    double c = cos(angle), s = sin(angle);
    for (size_t v = 0; v < l->mesh->nvertices; v++) {
        const double *x = on + 3 * v;
        double along = axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2];
        for (int k = 0; k < 3; k++) {
            int d = (k + 1) % 3, e = (k + 2) % 3;
            l->xyz[3 * v + (size_t)k] = c * x[k] + s * (axis[d] * x[e] - axis[e] * x[d]) +
                                        (1.0 - c) * along * axis[k];
        }
    }
}

static bool layer_is_certain(const layer *l)
{
    for (uint32_t t = 0; t < l->mesh->ntriangles; t++)
        if (kn_mesh_turn(on_sphere(l, 3 * t), on_sphere(l, 3 * t + 1), on_sphere(l, 3 * t + 2)) != 1) return false;
    return true;
}

// ---- what is built ----

typedef struct build {
    layer layer[2];
    kn_mesh mesh;
    double *target;
    uint32_t *pairs; // of triangles that overlap, two numbers each
    size_t npairs, pair_room;
    table seen, crossings;
} build;

static kn_status add_vertex(kn_ctx *ctx, build *b, const double *on_a, const double *on_b)
{
    size_t n = b->mesh.nvertices, room = b->mesh.vertex_room;
    if (n >= none - 1) return kn_fail(ctx, KN_ELIMIT, "mesh: too many vertices");
    void *position = b->mesh.position, *target = b->target;
    kn_status status = kn_make_room(ctx, &position, &b->mesh.vertex_room, n + 1, 3 * sizeof(double));
    b->mesh.position = position;
    if (status == KN_OK) status = kn_make_room(ctx, &target, &room, n + 1, 3 * sizeof(double));
    b->target = target;
    if (status != KN_OK) return status;
    memcpy(b->mesh.position + 3 * n, on_a, 3 * sizeof *on_a);
    memcpy(b->target + 3 * n, on_b, 3 * sizeof *on_b);
    b->mesh.nvertices++;
    return KN_OK;
}

static kn_status add_triangle(kn_ctx *ctx, build *b, uint32_t p, uint32_t q, uint32_t r)
{
    void *triangle = b->mesh.triangle;
    kn_status status = kn_make_room(ctx, &triangle, &b->mesh.triangle_room, b->mesh.ntriangles + 1,
                                    3 * sizeof(uint32_t));
    b->mesh.triangle = triangle;
    if (status != KN_OK) return status;
    uint32_t *t = b->mesh.triangle + 3 * b->mesh.ntriangles++;
    t[0] = p, t[1] = q, t[2] = r;
    return KN_OK;
}

static kn_status add_pair(kn_ctx *ctx, build *b, uint32_t p, uint32_t q)
{
    uint32_t value;
    bool is_new;
    kn_status status = table_get(ctx, &b->seen, p, q, 0, &value, &is_new);
    if (status != KN_OK || !is_new) return status;
    if (b->npairs >= MOST_FACES) return kn_fail(ctx, KN_ELIMIT, "mesh: more than %d faces", MOST_FACES);
    void *pairs = b->pairs;
    status = kn_make_room(ctx, &pairs, &b->pair_room, b->npairs + 1, 2 * sizeof(uint32_t));
    b->pairs = pairs;
    if (status != KN_OK) return status;
    b->pairs[2 * b->npairs] = p, b->pairs[2 * b->npairs + 1] = q;
    b->npairs++;
    return KN_OK;
}

// ---- a face ----

// Of the triangles t[0] and t[1]: side[k][i][j] is the side of edge i of t[k] on which corner j of the other one
// lies.
typedef struct face {
    uint32_t t[2];
    int side[2][3][3];
    uint32_t from[MOST_SEGMENTS], to[MOST_SEGMENTS]; // of its edges: vertices
    int n;
} face;

// Corner i of t[k] lies inside the other triangle.
static bool is_inside(const face *f, int k, int i)
{
    return f->side[1 - k][0][i] > 0 && f->side[1 - k][1][i] > 0 && f->side[1 - k][2][i] > 0;
}

// Edge i of t[k] crosses edge j of the other: 1 into the other triangle, -1 out of it, 0 not at all. The four signs
// are det(p,r,q), det(r,q,s), det(q,s,p), det(s,p,r) of pq and rs; all equal where these cross, and not behind the
// centre.
static int crosses(const face *f, int k, int i, int j)
{
    int j1 = (j + 1) % 3, i1 = (i + 1) % 3;
    const int(*a)[3] = f->side[k], (*b)[3] = f->side[1 - k];
    int way = b[j][i1];
    return -b[j][i] == way && a[i][j] == way && -a[i][j1] == way ? way : 0;
}

// false: a sign is not certain.
static bool find_sides(face *f, const build *b)
{
    for (int k = 0; k < 2; k++)
        for (uint32_t i = 0; i < 3; i++)
            for (uint32_t j = 0; j < 3; j++) {
                const layer *l = &b->layer[k], *m = &b->layer[1 - k];
                f->side[k][i][j] = kn_mesh_turn(on_sphere(l, 3 * f->t[k] + i),
                                                on_sphere(l, 3 * f->t[k] + (i + 1) % 3),
                                                on_sphere(m, 3 * f->t[1 - k] + j));
                if (f->side[k][i][j] == 0) return false;
            }
    return true;
}

// Where the edge of side s of layer k meets that of side o of the other, in space on k.
static void point_on_edge(double out[3], const build *b, int k, uint32_t s, uint32_t o)
{
    const layer *l = &b->layer[k], *m = &b->layer[1 - k];
    uint32_t s1 = s - s % 3 + (s + 1) % 3, o1 = o - o % 3 + (o + 1) % 3;
    double bound, to_p, to_q;
    to_p = fabs(kn_mesh_turn_value(on_sphere(m, o), on_sphere(m, o1), on_sphere(l, s), &bound));
    to_q = fabs(kn_mesh_turn_value(on_sphere(m, o), on_sphere(m, o1), on_sphere(l, s1), &bound));
    double part = to_p / (to_p + to_q);
    const double *p = in_space(l, s), *q = in_space(l, s1);
    for (int c = 0; c < 3; c++) out[c] = (1.0 - part) * p[c] + part * q[c];
}

static kn_status crossing_vertex(kn_ctx *ctx, build *b, const face *f, int k, int i, int j, uint32_t *out)
{
    uint32_t side[2];
    side[k] = 3 * f->t[k] + (uint32_t)i;
    side[1 - k] = 3 * f->t[1 - k] + (uint32_t)j;
    for (int c = 0; c < 2; c++) {
        uint32_t twin = b->layer[c].twin[side[c]];
        if (twin < side[c]) side[c] = twin;
    }
    bool is_new;
    kn_status status = table_get(ctx, &b->crossings, side[0], side[1], (uint32_t)b->mesh.nvertices, out, &is_new);
    if (status != KN_OK || !is_new) return status;
    double on[2][3];
    for (int c = 0; c < 2; c++) point_on_edge(on[c], b, c, side[c], side[1 - c]);
    return add_vertex(ctx, b, on[0], on[1]);
}

// A corner of t[k] inside the other triangle: there it has barycentric coordinates, all of them positive.
static kn_status corner_vertex(kn_ctx *ctx, build *b, const face *f, int k, int i, uint32_t *out)
{
    const layer *l = &b->layer[k], *m = &b->layer[1 - k];
    uint32_t corner = 3 * f->t[k] + (uint32_t)i, other = 3 * f->t[1 - k], v = l->mesh->triangle[corner];
    kn_status status = KN_OK;
    if (l->vertex[v] == none) {
        double on[3] = {0}, weight[3], sum = 0.0, bound;
        for (uint32_t j = 0; j < 3; j++) {
            weight[j] = fabs(kn_mesh_turn_value(on_sphere(m, other + (j + 1) % 3), on_sphere(m, other + (j + 2) % 3),
                                                on_sphere(l, corner), &bound));
            sum += weight[j];
        }
        for (uint32_t j = 0; j < 3; j++)
            for (int c = 0; c < 3; c++) on[c] += weight[j] / sum * in_space(m, other + j)[c];
        l->vertex[v] = k == 0 ? v : (uint32_t)b->mesh.nvertices;
        if (k == 0)
            memcpy(b->target + 3 * (size_t)v, on, sizeof on);
        else
            status = add_vertex(ctx, b, on, in_space(l, corner));
    }
    *out = l->vertex[v];
    return status;
}

// The part of edge i of t[k] that lies in the other triangle, if any does.
static kn_status add_segment(kn_ctx *ctx, build *b, face *f, int k, int i)
{
    uint32_t end[2] = {none, none};
    kn_status status = KN_OK;
    for (int e = 0; e < 2 && status == KN_OK; e++) {
        int corner = (i + e) % 3;
        if (is_inside(f, k, corner)) status = corner_vertex(ctx, b, f, k, corner, &end[e]);
        for (int j = 0; j < 3 && status == KN_OK; j++)
            if (crosses(f, k, i, j) == 1 - 2 * e) status = crossing_vertex(ctx, b, f, k, i, j, &end[e]);
    }
    if (status != KN_OK || (end[0] == none && end[1] == none)) return status;
    if (end[0] == none || end[1] == none || f->n == MOST_SEGMENTS)
        return kn_fail(ctx, KN_EUNDECIDED, "mesh: edge %d of triangle %u has no end", i, (unsigned)f->t[k]);
    f->from[f->n] = end[0];
    f->to[f->n++] = end[1];
    uint32_t beside = b->layer[k].twin[3 * f->t[k] + (uint32_t)i] / 3;
    return k == 0 ? add_pair(ctx, b, beside, f->t[1]) : add_pair(ctx, b, f->t[0], beside);
}

// Edges one behind the other, and triangles from the first of them.
static kn_status add_polygon(kn_ctx *ctx, build *b, const face *f)
{
    uint32_t corner[MOST_SEGMENTS];
    int at = 0, n = 0;
    do {
        corner[n++] = f->from[at];
        int next = 0;
        while (next < f->n && f->from[next] != f->to[at]) next++;
        at = next;
    } while (at != 0 && at < f->n && n < f->n);
    if (at != 0 || n != f->n || n < 3)
        return kn_fail(ctx, KN_EUNDECIDED, "mesh: triangles %u and %u overlap in no polygon", (unsigned)f->t[0],
                       (unsigned)f->t[1]);
    kn_status status = KN_OK;
    for (int i = 2; i < n && status == KN_OK; i++) status = add_triangle(ctx, b, corner[0], corner[i - 1], corner[i]);
    return status;
}

// *certain = false, and KN_OK: a sign that matters is not certain.
static kn_status add_face(kn_ctx *ctx, build *b, const uint32_t pair[2], bool *certain)
{
    face f = {.t = {pair[0], pair[1]}};
    *certain = find_sides(&f, b);
    if (!*certain) return KN_OK;
    kn_status status = KN_OK;
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3 && status == KN_OK; i++) status = add_segment(ctx, b, &f, k, i);
    return status == KN_OK ? add_polygon(ctx, b, &f) : status;
}

// ---- the whole ----

// A triangle of b that holds corner 0 of a's first triangle.
static bool find_start(const build *b, uint32_t *out)
{
    const layer *l = &b->layer[1];
    for (uint32_t t = 0; t < l->mesh->ntriangles; t++) {
        int inside = 0;
        for (uint32_t i = 0; i < 3; i++)
            inside += kn_mesh_turn(on_sphere(l, 3 * t + i), on_sphere(l, 3 * t + (i + 1) % 3),
                                   on_sphere(&b->layer[0], 0)) == 1;
        *out = t;
        if (inside == 3) return true;
    }
    return false;
}

static kn_status begin(kn_ctx *ctx, build *b)
{
    const kn_mesh *a = b->layer[0].mesh;
    b->mesh.nvertices = b->mesh.ntriangles = b->npairs = 0;
    table_clear(ctx, &b->seen);
    table_clear(ctx, &b->crossings);
    for (int k = 0; k < 2; k++)
        for (size_t v = 0; v < b->layer[k].mesh->nvertices; v++) b->layer[k].vertex[v] = none;
    kn_status status = KN_OK;
    for (size_t v = 0; v < a->nvertices && status == KN_OK; v++)
        status = add_vertex(ctx, b, a->position + 3 * v, a->position + 3 * v);
    return status;
}

// Faces from the first on; *certain as add_face has it.
static kn_status try_faces(kn_ctx *ctx, build *b, bool *certain)
{
    kn_status status = begin(ctx, b);
    uint32_t start = 0;
    *certain = status == KN_OK && layer_is_certain(&b->layer[1]) && find_start(b, &start);
    if (*certain) status = add_pair(ctx, b, 0, start);
    for (size_t i = 0; *certain && status == KN_OK && i < b->npairs; i++) {
        const uint32_t pair[2] = {b->pairs[2 * i], b->pairs[2 * i + 1]};
        status = add_face(ctx, b, pair, certain);
        if (status == KN_OK && i % 4096 == 0) status = kn_progress(ctx, "overlay", 0.0);
    }
    return status;
}

// A sphere has two vertices more than half as many as it has triangles.
static kn_status check_sphere(kn_ctx *ctx, const build *b)
{
    size_t used = b->mesh.nvertices;
    for (size_t v = 0; v < b->layer[0].mesh->nvertices; v++) used -= b->layer[0].vertex[v] == none;
    if (2 * used == b->mesh.ntriangles + 4) return KN_OK;
    return kn_fail(ctx, KN_EUNDECIDED, "mesh: %zu vertices and %zu triangles are no sphere", used,
                   b->mesh.ntriangles);
}

static kn_status find_faces(kn_ctx *ctx, build *b, const double *b_on)
{
    enum { ATTEMPTS = 8 };
    bool certain = false;
    kn_status status = KN_OK;
    double angle = 0.0; // at first as they are; then further and further
    for (int k = 0; k < ATTEMPTS && status == KN_OK && !certain; k++, angle = 1e-6 * ldexp(1.0, 2 * k)) {
        turn_layer(&b->layer[1], b_on, angle);
        status = try_faces(ctx, b, &certain);
    }
    if (status != KN_OK) return status;
    return certain ? check_sphere(ctx, b) : kn_fail(ctx, KN_EUNDECIDED, "mesh: how two meshes lie is not certain");
}

kn_status kn_mesh_overlay(kn_ctx *ctx, kn_mesh *out, double **target, const kn_mesh *a, const double *a_on,
                          const kn_mesh *b, const double *b_on)
{
    build s = {0};
    kn_status status = layer_init(ctx, &s.layer[0], a, a_on);
    if (status == KN_OK) status = layer_init(ctx, &s.layer[1], b, b_on);
    if (status == KN_OK) status = find_faces(ctx, &s, b_on);
    if (status == KN_OK) {
        *out = s.mesh;
        *target = s.target;
    } else {
        kn_mesh_clear(ctx, &s.mesh);
        kn_free(ctx, s.target);
    }
    layer_clear(ctx, &s.layer[0]);
    layer_clear(ctx, &s.layer[1]);
    table_clear(ctx, &s.seen);
    table_clear(ctx, &s.crossings);
    kn_free(ctx, s.pairs);
    return status;
}
