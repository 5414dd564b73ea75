// SPDX-License-Identifier: Apache-2.0
// How the patches of an MFEM mesh meet: vertices are one where their coordinates are equal bit for bit; edges are known
// by their vertices, as MFEM knows them, and have to have the same control points then; faces likewise. Edges opposite
// each other in a patch have one knot vector: edges fall into classes, each with a direction.
#include "write/mfem.h"
#include "write/text_sink.h"

#include "kernel/context.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

void kn_mfem_edge(int e, int corner[2], int *var)
{
    static const int ends[12][3] = {{0, 1, 0}, {1, 2, 1}, {3, 2, 0}, {0, 3, 1}, {4, 5, 0}, {5, 6, 1},
                                    {7, 6, 0}, {4, 7, 1}, {0, 4, 2}, {1, 5, 2}, {2, 6, 2}, {3, 7, 2}};
    corner[0] = ends[e][0], corner[1] = ends[e][1], *var = ends[e][2];
}

void kn_mfem_face(int f, int corner[4], int *var, int *end)
{
    static const int corners[6][4] = {{3, 2, 1, 0}, {0, 1, 5, 4}, {1, 2, 6, 5},
                                      {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}};
    static const int place[6][2] = {{2, 0}, {1, 0}, {0, 1}, {1, 1}, {0, 0}, {2, 1}};
    for (int k = 0; k < 4; k++) corner[k] = corners[f][k];
    *var = place[f][0], *end = place[f][1];
}

// Something that patches share: sorted by its key, those of one key are one.
typedef struct use {
    uint64_t key[4];
    uint64_t sum; // of control points
    size_t index; // which of them, counted over all cells
} use;

static int compare(const void *a, const void *b)
{
    const use *x = a, *y = b;
    int order = memcmp(x->key, y->key, sizeof x->key);
    return order != 0 ? order : x->index < y->index ? -1 : x->index > y->index;
}

static bool same(const use *a, const use *b)
{
    return memcmp(a->key, b->key, sizeof a->key) == 0;
}

typedef struct topology {
    const kn_mfem_cell *cells;
    size_t n;
    int nvars, corners, edges, faces;
    uint32_t *vertex, *edge; // of each cell
    use *uses;               // one kind after the other
    bool *backward;          // of each edge of each cell: from the larger vertex to the smaller one
    // Of each edge: a class's members lead to its root, in its direction or against it.
    uint32_t *parent, *ends;
    bool *turned;
    uint32_t nvertices, nedges;
} topology;

// Numbers for uses, in the order of their first appearance.
static uint32_t number_uses(kn_ctx *ctx, topology *t, uint32_t *number, size_t n, kn_status *status)
{
    uint32_t next = 0;
    size_t *first = kn_alloc(ctx, n + 1, sizeof *first); // of each use, the one that appears first of its kind
    if (!first) {
        *status = KN_ENOMEM;
        return 0;
    }
    qsort(t->uses, n, sizeof *t->uses, compare);
    for (size_t i = 0, begin = 0; i < n; i++) {
        if (!same(&t->uses[i], &t->uses[begin])) begin = i;
        first[t->uses[i].index] = t->uses[begin].index;
    }
    for (size_t i = 0; i < n; i++) number[i] = first[i] == i ? next++ : number[first[i]];
    kn_free(ctx, first);
    return next;
}

static kn_status find_vertices(kn_ctx *ctx, topology *t)
{
    kn_status status = KN_OK;
    size_t corners = (size_t)t->corners, n = t->n * corners;
    for (size_t i = 0; i < n; i++) {
        use *u = &t->uses[i];
        *u = (use){.index = i};
        for (int c = 0; c < 3; c++) {
            double x = t->cells[i / corners].corner[i % corners][c] + 0.0; // one zero
            memcpy(&u->key[c], &x, sizeof x);
        }
    }
    t->nvertices = number_uses(ctx, t, t->vertex, n, &status);
    return status;
}

static kn_status refuse(kn_ctx *ctx, const topology *t, size_t cell, const char *why)
{
    return kn_write_refuse(ctx, "MFEM", &t->cells[cell].id, why);
}

static kn_status find_edges(kn_ctx *ctx, topology *t)
{
    kn_status status = KN_OK;
    size_t edges = (size_t)t->edges, n = t->n * edges;
    for (size_t i = 0; i < n; i++) {
        int corner[2], var;
        use *u = &t->uses[i];
        kn_mfem_edge((int)(i % edges), corner, &var);
        const uint32_t *v = t->vertex + i / edges * (size_t)t->corners;
        uint32_t a = v[corner[0]], b = v[corner[1]];
        assert(a != b);
        *u = (use){.key = {a < b ? a : b, a < b ? b : a}, .sum = t->cells[i / edges].edge[i % edges], .index = i};
        t->backward[i] = a > b;
    }
    t->nedges = number_uses(ctx, t, t->edge, n, &status);
    if (status != KN_OK) return status;
    for (size_t i = 0, begin = 0; i < n; i++) {
        const use *u = &t->uses[i];
        if (!same(u, &t->uses[begin])) begin = i;
        if (u->sum != t->uses[begin].sum)
            return refuse(ctx, t, u->index / edges,
                          "has an edge between the vertices of another one, and not the same");
        if (t->nvars == 2 && i - begin >= 2) return refuse(ctx, t, u->index / edges, "is the third one at an edge");
        t->ends[2 * t->edge[u->index]] = (uint32_t)u->key[0];
        t->ends[2 * t->edge[u->index] + 1] = (uint32_t)u->key[1];
    }
    return KN_OK;
}

// ---- classes of edges ----

static uint32_t root_of(topology *t, uint32_t e, bool *turned)
{
    for (*turned = false; t->parent[e] != e; e = t->parent[e]) {
        uint32_t up = t->parent[e];
        if (t->parent[up] != up) { // halve the path
            t->turned[e] = t->turned[e] != t->turned[up];
            t->parent[e] = t->parent[up];
        }
        *turned = *turned != t->turned[e];
    }
    return e;
}

static kn_status join(kn_ctx *ctx, topology *t, size_t cell, uint32_t a, uint32_t b, bool against)
{
    bool ta, tb;
    uint32_t ra = root_of(t, a, &ta), rb = root_of(t, b, &tb);
    bool turned = (ta != tb) != against;
    if (ra == rb) return turned ? refuse(ctx, t, cell, "closes a ring of patches that is twisted") : KN_OK;
    uint32_t low = ra < rb ? ra : rb, high = ra < rb ? rb : ra;
    t->parent[high] = low;
    t->turned[high] = turned;
    return KN_OK;
}

// knots: for each root, its knot vector and the same backwards; 0: not known yet.
static kn_status check_knots(kn_ctx *ctx, topology *t, uint64_t (*knots)[2])
{
    for (size_t i = 0; i < t->n * (size_t)t->edges; i++) {
        int corner[2], var;
        bool turned;
        size_t cell = i / (size_t)t->edges;
        kn_mfem_edge((int)(i % (size_t)t->edges), corner, &var);
        uint32_t root = root_of(t, t->edge[i], &turned);
        bool against = turned != t->backward[i];
        const uint64_t *own = t->cells[cell].knots[var], pair[2] = {own[against], own[!against]};
        if (knots[root][0] == 0) memcpy(knots[root], pair, sizeof pair);
        if (memcmp(knots[root], pair, sizeof pair) != 0)
            return refuse(ctx, t, cell, "has other knots or degrees than a patch beside it");
    }
    return KN_OK;
}

static kn_status find_classes(kn_ctx *ctx, topology *t)
{
    kn_status status = KN_OK;
    for (uint32_t e = 0; e < t->nedges; e++) t->parent[e] = e, t->turned[e] = false;
    for (size_t cell = 0; status == KN_OK && cell < t->n; cell++) {
        int first[3] = {-1, -1, -1};
        for (int e = 0; status == KN_OK && e < t->edges; e++) {
            int corner[2], var;
            kn_mfem_edge(e, corner, &var);
            size_t at = cell * (size_t)t->edges + (size_t)e, to = cell * (size_t)t->edges + (size_t)first[var];
            if (first[var] < 0)
                first[var] = e;
            else
                status = join(ctx, t, cell, t->edge[to], t->edge[at], t->backward[to] != t->backward[at]);
        }
    }
    if (status != KN_OK) return status;
    uint64_t(*knots)[2] = kn_alloc_zero(ctx, (size_t)t->nedges + 1, sizeof *knots);
    status = knots ? check_knots(ctx, t, knots) : KN_ENOMEM;
    kn_free(ctx, knots);
    return status;
}

// ---- text ----

static void put_numbers(kn_text *text, const uint64_t *x, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (i > 0) kn_text_char(text, ' ');
        kn_text_integer(text, x[i]);
    }
    kn_text_newline(text);
}

static void put_section(kn_text *text, const char *name, uint64_t n)
{
    kn_text_newline(text);
    kn_text_put(text, name);
    kn_text_newline(text);
    put_numbers(text, &n, 1);
}

// Attributes are the numbers of looks, from 1.
static void put_elements(kn_text *text, const topology *t)
{
    put_section(text, "elements", t->n);
    for (size_t i = 0; i < t->n; i++) {
        uint64_t line[10] = {(uint64_t)t->cells[i].look + 1, t->nvars == 2 ? 3 : 5};
        for (int k = 0; k < t->corners; k++) line[2 + k] = t->vertex[i * (size_t)t->corners + (size_t)k];
        put_numbers(text, line, 2 + (size_t)t->corners);
    }
}

// Edges, or faces, that one patch has: their attribute is 1 + 2 variable + end.
static void put_boundary(kn_text *text, topology *t, size_t n, size_t each)
{
    size_t count = 0;
    for (int pass = 0; pass < 2; pass++) {
        if (pass == 1) put_section(text, "boundary", count);
        for (size_t i = 0; i < n; i++) {
            const use *u = &t->uses[i];
            if ((i > 0 && same(u, u - 1)) || (i + 1 < n && same(u, u + 1))) continue;
            count++;
            if (pass == 0) continue;
            int corner[4], var, end = 0, k = (int)(u->index % each);
            const uint32_t *v = t->vertex + u->index / each * (size_t)t->corners;
            if (t->nvars == 3) {
                kn_mfem_face(k, corner, &var, &end);
                put_numbers(text,
                            (uint64_t[]){(uint64_t)(1 + 2 * var + end), 3, v[corner[0]], v[corner[1]], v[corner[2]],
                                         v[corner[3]]},
                            6);
            } else { // edge k of a square lies where the other variable ends, and runs around
                static const int attribute[4] = {3, 2, 4, 1};
                put_numbers(text, (uint64_t[]){(uint64_t)attribute[k], 1, v[k], v[(k + 1) % 4]}, 4);
            }
        }
    }
}

static void put_edges(kn_text *text, topology *t, uint32_t *class)
{
    uint32_t next = 0;
    put_section(text, "edges", t->nedges);
    for (uint32_t e = 0; e < t->nedges; e++) { // the root of a class is its first edge
        bool turned;
        uint32_t root = root_of(t, e, &turned);
        if (root == e) class[e] = next++;
        put_numbers(text, (uint64_t[]){class[root], t -> ends[2 * e + turned], t -> ends[2 * e + !turned]}, 3);
    }
    put_section(text, "vertices", t->nvertices);
}

static kn_status find_faces(kn_ctx *ctx, topology *t)
{
    size_t n = t->n * (size_t)t->faces;
    for (size_t i = 0; i < n; i++) {
        int corner[4], var, end;
        use *u = &t->uses[i];
        kn_mfem_face((int)(i % (size_t)t->faces), corner, &var, &end);
        *u = (use){.sum = t->cells[i / (size_t)t->faces].face[i % (size_t)t->faces], .index = i};
        for (int k = 0; k < 4; k++) {
            uint64_t x = t->vertex[i / (size_t)t->faces * (size_t)t->corners + (size_t)corner[k]];
            int at = k;
            for (; at > 0 && u->key[at - 1] > x; at--) u->key[at] = u->key[at - 1];
            u->key[at] = x;
        }
    }
    qsort(t->uses, n, sizeof *t->uses, compare);
    for (size_t i = 1; i < n; i++) {
        const use *u = &t->uses[i];
        if (same(u, u - 1) && u->sum != u[-1].sum)
            return refuse(ctx, t, u->index / (size_t)t->faces, "meets another one in a face that is not the same");
        if (i > 1 && same(u, u - 1) && same(u, u - 2))
            return refuse(ctx, t, u->index / (size_t)t->faces, "is the third one at a face");
    }
    return KN_OK;
}

static kn_status survey(kn_ctx *ctx, kn_text *text, topology *t)
{
    kn_status status = find_vertices(ctx, t);
    if (status == KN_OK) status = find_edges(ctx, t);
    if (status == KN_OK) status = find_classes(ctx, t);
    if (status == KN_OK && t->nvars == 3) status = find_faces(ctx, t);
    uint32_t *class = status == KN_OK ? kn_alloc_zero(ctx, (size_t)t->nedges + 1, sizeof *class) : NULL;
    if (status == KN_OK && !class) status = KN_ENOMEM;
    if (status == KN_OK) {
        size_t each = (size_t)(t->nvars == 2 ? t->edges : t->faces);
        put_section(text, "dimension", (uint64_t)t->nvars);
        put_elements(text, t);
        put_boundary(text, t, t->n * each, each);
        put_edges(text, t, class);
    }
    kn_free(ctx, class);
    return status;
}

static kn_status look(kn_ctx *ctx, kn_text *text, topology *t)
{
    kn_status status = find_vertices(ctx, t);
    (void)text;
    if (status == KN_OK) status = find_edges(ctx, t);
    return status == KN_OK && t->nvars == 3 ? find_faces(ctx, t) : status;
}

// A topology of these patches, which `work` does what it is for with.
static kn_status with_topology(kn_ctx *ctx, kn_text *text, const kn_mfem_cell *cells, size_t n, int nvars,
                               kn_status (*work)(kn_ctx *ctx, kn_text *text, topology *t))
{
    topology t = {.cells = cells, .n = n, .nvars = nvars, .corners = nvars == 2 ? 4 : 8};
    t.edges = nvars == 2 ? KN_MFEM_SQUARE_EDGES : KN_MFEM_CUBE_EDGES;
    t.faces = nvars == 2 ? 0 : KN_MFEM_CUBE_FACES;
    size_t edges = n * (size_t)t.edges + 1; // also the most of all kinds
    if (edges > UINT32_MAX) return kn_fail(ctx, KN_ELIMIT, "MFEM: %zu patches", n);
    t.vertex = kn_alloc(ctx, edges, sizeof *t.vertex);
    t.edge = kn_alloc(ctx, edges, sizeof *t.edge);
    t.uses = kn_alloc(ctx, edges, sizeof *t.uses);
    t.backward = kn_alloc(ctx, edges, sizeof *t.backward);
    t.parent = kn_alloc(ctx, edges, sizeof *t.parent);
    t.ends = kn_alloc(ctx, edges, 2 * sizeof *t.ends);
    t.turned = kn_alloc(ctx, edges, sizeof *t.turned);
    bool enough = t.vertex && t.edge && t.uses && t.backward && t.parent && t.ends && t.turned;
    kn_status status = enough ? work(ctx, text, &t) : KN_ENOMEM;
    kn_free(ctx, t.vertex), kn_free(ctx, t.edge), kn_free(ctx, t.uses), kn_free(ctx, t.backward);
    kn_free(ctx, t.parent), kn_free(ctx, t.ends), kn_free(ctx, t.turned);
    return status == KN_OK && text && text->failed ? KN_ENOMEM : status;
}

kn_status kn_mfem_put_topology(kn_ctx *ctx, kn_text *text, const kn_mfem_cell *cells, size_t n, int nvars)
{
    return with_topology(ctx, text, cells, n, nvars, survey);
}

kn_status kn_mfem_check_edges(kn_ctx *ctx, const kn_mfem_cell *cells, size_t n, int nvars)
{
    return with_topology(ctx, NULL, cells, n, nvars, look);
}
