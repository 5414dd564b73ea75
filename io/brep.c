// SPDX-License-Identifier: Apache-2.0
// Which faces meet along which edges: tables of what waits, and a forest of bodies that grow together.
#include "io/brep.h"

#include "kernel/context.h"
#include "kernel/hash.h"

#include <string.h>

static const uint32_t NONE = UINT32_MAX;
enum { FIRST_ROOM = 64, CHUNK_BYTES = 42, VARINT_BYTES = 10 };

// An edge or a vertex that waits. uses: of a vertex, the edges that do; of an edge 1; 0: the place is empty.
typedef struct entry {
    kn_brep_key key;
    uint64_t number;
    uint32_t body, uses;
    uint32_t vertex[2], pcurve; // of an edge
    bool forward, against, seed;
    bool twice; // a seed for two faces, in opposite directions
} entry;

typedef struct table {
    entry *entries;
    size_t room, count; // room is a power of two, a third of it empty at least
} table;

// Faces of a body: the first one's number, then the differences of the others, seven bits to a byte, the lowest bit
// of all for a change of the look, which then follows.
typedef struct chunk {
    uint64_t number, last;
    int look, last_look;
    uint32_t next;
    uint16_t used;
    unsigned char data[CHUNK_BYTES];
} chunk;

// A root (parent NONE), or what became part of another body. refs: edges and bodies that name it.
typedef struct body {
    uint32_t parent, refs, waiting, head, tail;
    int look;
    bool there, odd; // odd: two faces use an edge in the same direction
    bool held;
    uint64_t faces;
} body;

struct kn_brep {
    table edges, vertices;
    body *bodies;
    chunk *chunks;
    size_t nbodies, body_room, nchunks, chunk_room;
    uint32_t free_body, free_chunk; // lists, by parent and by next
    uint32_t face;                  // body of the face that was added last
};

// ---- keys ----

static uint64_t bits_of(double x)
{
    uint64_t bits;
    double positive = x + 0.0; // of a zero too
    memcpy(&bits, &positive, sizeof bits);
    return bits;
}

kn_brep_key kn_brep_mix(kn_brep_key key, double x)
{
    uint64_t bits = bits_of(x);
    key.a = kn_hash_add(key.a, bits);
    key.b = kn_hash_add(key.b, bits ^ 0x452821e638d01377u) + key.a;
    return key;
}

kn_brep_key kn_brep_hash(bool *turned, const double *x, int ncomp, size_t comp, size_t n, ptrdiff_t step)
{
    kn_brep_key key = {0x243f6a8885a308d3u, 0x13198a2e03707344u};
    int order = 0;
    const double *end = x + (ptrdiff_t)(n - 1) * step;
    for (size_t i = 0; i < n && order == 0; i++)
        for (size_t c = 0; c < (size_t)ncomp && order == 0; c++) {
            double a = x[c * comp + i * (size_t)step], b = end[(ptrdiff_t)(c * comp) - (ptrdiff_t)i * step];
            order = (a > b) - (a < b);
        }
    *turned = order > 0;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < (size_t)ncomp; c++) {
            const double *at = *turned ? end - (ptrdiff_t)i * step : x + (ptrdiff_t)i * step;
            key = kn_brep_mix(key, at[c * comp]);
        }
    return key;
}

// ---- tables: open addressing, the next place when one is taken ----

static entry *find(const table *t, kn_brep_key key)
{
    if (t->room == 0) return NULL;
    size_t mask = t->room - 1, at = key.a & mask;
    for (; t->entries[at].uses > 0; at = (at + 1) & mask)
        if (kn_brep_same(t->entries[at].key, key)) return &t->entries[at];
    return NULL;
}

static entry *put(table *t, const entry *e)
{
    size_t mask = t->room - 1, at = e->key.a & mask;
    while (t->entries[at].uses > 0) at = (at + 1) & mask;
    t->entries[at] = *e;
    t->count++;
    return &t->entries[at];
}

static kn_status insert(kn_ctx *ctx, table *t, const entry *e, entry **placed)
{
    if (3 * (t->count + 1) > 2 * t->room) {
        table larger = {.room = t->room > 0 ? 2 * t->room : FIRST_ROOM};
        larger.entries = kn_alloc_zero(ctx, larger.room, sizeof *larger.entries);
        if (!larger.entries) return KN_ENOMEM;
        for (size_t i = 0; i < t->room; i++)
            if (t->entries[i].uses > 0) (void)put(&larger, &t->entries[i]);
        kn_free(ctx, t->entries);
        *t = larger;
    }
    entry *at = put(t, e);
    if (placed) *placed = at;
    return KN_OK;
}

// Those behind it that would not be found any more move up.
static void take_out(table *t, entry *e)
{
    size_t mask = t->room - 1, hole = (size_t)(e - t->entries);
    for (size_t at = (hole + 1) & mask; t->entries[at].uses > 0; at = (at + 1) & mask) {
        size_t home = t->entries[at].key.a & mask;
        if (((at - home) & mask) < ((at - hole) & mask)) continue;
        t->entries[hole] = t->entries[at];
        hole = at;
    }
    t->entries[hole] = (entry){.uses = 0};
    t->count--;
}

static void release_vertex(kn_brep *b, kn_brep_key key)
{
    entry *v = find(&b->vertices, key);
    if (v && --v->uses == 0) {
        v->uses = 1;
        take_out(&b->vertices, v);
    }
}

// ---- bodies ----

static void release_body(kn_brep *b, uint32_t at)
{
    while (at != NONE) {
        body *x = &b->bodies[at];
        uint32_t parent = x->parent;
        if (--x->refs > 0 || parent == NONE) return; // roots go when they are dropped
        *x = (body){.parent = b->free_body};
        b->free_body = at;
        at = parent;
    }
}

static uint32_t root_of(const kn_brep *b, uint32_t at)
{
    while (b->bodies[at].parent != NONE) at = b->bodies[at].parent;
    return at;
}

static kn_status new_body(kn_ctx *ctx, kn_brep *b, uint32_t *out)
{
    if (b->free_body == NONE) {
        if (b->nbodies == b->body_room) {
            size_t room = b->body_room > 0 ? 2 * b->body_room : FIRST_ROOM;
            if (room >= NONE) return kn_fail(ctx, KN_ELIMIT, "%zu bodies", room);
            body *more = kn_resize(ctx, b->bodies, room, sizeof *more);
            if (!more) return KN_ENOMEM;
            b->bodies = more, b->body_room = room;
        }
        b->bodies[b->nbodies] = (body){.parent = NONE};
        b->free_body = (uint32_t)b->nbodies++;
    }
    *out = b->free_body;
    b->free_body = b->bodies[*out].parent;
    b->bodies[*out] = (body){.parent = NONE, .head = NONE, .tail = NONE, .look = KN_BREP_NONE, .there = true};
    return KN_OK;
}

// The body with fewer faces becomes part of the other; answers that.
static uint32_t unite(kn_brep *b, uint32_t one, uint32_t two)
{
    if (one == two) return one;
    uint32_t big = b->bodies[one].faces >= b->bodies[two].faces ? one : two, small = big == one ? two : one;
    body *x = &b->bodies[big], *y = &b->bodies[small];
    if (x->head == NONE) {
        x->head = y->head, x->tail = y->tail, x->look = y->look;
    } else if (y->head != NONE) {
        b->chunks[x->tail].next = y->head;
        x->tail = y->tail;
        if (x->look != y->look) x->look = KN_BREP_NONE;
    }
    x->faces += y->faces;
    x->waiting += y->waiting;
    x->odd = x->odd || y->odd, x->held = x->held || y->held;
    y->parent = big, y->head = y->tail = NONE;
    x->refs++; // y names it
    y->refs++;
    release_body(b, small);
    return big;
}

// ---- faces ----

// The vertex of a key, or of the other end of a collapsed edge.
static const entry *vertex_of(const table *vertices, kn_brep_key key, const kn_brep_key (*pairs)[2], int npairs)
{
    const entry *v = find(vertices, key);
    for (int i = 0; i < npairs && !v; i++)
        for (int k = 0; k < 2 && !v; k++)
            if (kn_brep_same(pairs[i][k], key)) v = find(vertices, pairs[i][1 - k]);
    return v;
}

static kn_status take_vertices(kn_ctx *ctx, kn_brep *b, const kn_brep_edge *e, const kn_brep_key (*pairs)[2],
                               int npairs, uint64_t *next, kn_brep_name *name)
{
    for (int k = 0; k < 2; k++) {
        entry *v = find(&b->vertices, e->vertex[k]);
        name->new_vertex[k] = false;
        if (!v) {
            const entry *other = vertex_of(&b->vertices, e->vertex[k], pairs, npairs);
            name->new_vertex[k] = other == NULL;
            entry fresh = {.key = e->vertex[k], .number = other ? other->number : (*next)++, .uses = 1};
            kn_status status = insert(ctx, &b->vertices, &fresh, &v);
            if (status != KN_OK) return status;
            v->uses = 0;
        }
        v->uses++;
        name->vertex[k] = v->number;
    }
    return KN_OK;
}

// Edge i waits since an earlier face: not any more.
static void join(kn_brep *b, const kn_brep_edge *e, entry *waiting, uint32_t *at)
{
    uint32_t named = waiting->body, root = root_of(b, named);
    bool odd = waiting->forward == e->forward && !waiting->twice;
    if (waiting->twice) // the other one is to run against this one
        waiting->twice = false, waiting->forward = e->forward;
    else
        take_out(&b->edges, waiting);
    b->bodies[root].waiting--;
    if (odd) b->bodies[root].odd = true;
    *at = *at == NONE ? root : unite(b, *at, root);
    release_body(b, named);
    for (int k = 0; k < 2; k++) release_vertex(b, e->vertex[k]);
}

// Nothing of the face is shared: vertices along its boundary by their keys alone.
static kn_status name_alone(kn_ctx *ctx, const kn_brep_edge *edges, int n, const kn_brep_key (*pairs)[2], int npairs,
                            uint64_t *next, kn_brep_name *names)
{
    table known = {0};
    kn_status status = KN_OK;
    if (npairs > KN_BREP_PAIRS) npairs = KN_BREP_PAIRS;
    for (int i = 0; i < n && status == KN_OK; i++) {
        for (int k = 0; k < 2 && status == KN_OK; k++) {
            const entry *v = vertex_of(&known, edges[i].vertex[k], pairs, npairs);
            names[i].new_vertex[k] = v == NULL;
            names[i].vertex[k] = v ? v->number : (*next)++;
            entry fresh = {.key = edges[i].vertex[k], .number = names[i].vertex[k], .uses = 1};
            if (!find(&known, fresh.key)) status = insert(ctx, &known, &fresh, NULL);
        }
    }
    for (int i = 0; i < n; i++) {
        *next += 2;
        names[i].edge = *next - 1, names[i].new_edge = names[i].last = true, names[i].against = names[i].seam = false;
        names[i].pcurve[0] = edges[i].pcurve, names[i].pcurve[1] = 0;
    }
    kn_free(ctx, known.entries);
    return status;
}

// Edge i, which nobody waits for: it waits from now on, by names[i] until wait_on. A seam's second use ends that.
static kn_status begin_edge(kn_ctx *ctx, kn_brep *b, const kn_brep_edge *edges, int i, uint32_t at, uint64_t *next,
                            kn_brep_name *names)
{
    entry *twin = find(&b->edges, edges[i].key);
    if (twin) {
        kn_brep_name *first = &names[twin->vertex[0]], *second = &names[i];
        second->edge = first->edge, second->new_edge = false;
        first->last = first->seam = true;
        first->pcurve[1] = edges[i].pcurve;
        if (twin->forward == edges[i].forward) b->bodies[at].odd = true;
        take_out(&b->edges, twin);
        return KN_OK;
    }
    *next += 2;
    names[i].edge = *next - 1;
    entry fresh = {.key = edges[i].key, .number = names[i].edge, .body = at, .uses = 1, .vertex = {(uint32_t)i, 0}};
    fresh.forward = edges[i].forward, fresh.pcurve = (uint32_t)edges[i].pcurve;
    return insert(ctx, &b->edges, &fresh, NULL);
}

static kn_status wait_on(kn_ctx *ctx, kn_brep *b, const kn_brep_edge *edge, uint32_t at, const kn_brep_name *name)
{
    entry *e = find(&b->edges, edge->key);
    kn_status status = KN_OK;
    for (int k = 0; k < 2 && status == KN_OK; k++) {
        entry *v = find(&b->vertices, edge->vertex[k]);
        entry fresh = {.key = edge->vertex[k], .number = name->vertex[k], .uses = 1};
        e->vertex[k] = (uint32_t)name->vertex[k];
        if (v)
            v->uses++;
        else // gone with an edge that had other vertices
            status = insert(ctx, &b->vertices, &fresh, NULL);
    }
    b->bodies[at].waiting++, b->bodies[at].refs++;
    return status;
}

// Whether an edge that is a point joins two vertices that have numbers already, or there are too many of them.
static bool contradicts(const kn_brep *b, const kn_brep_key (*pairs)[2], int npairs)
{
    if (npairs > KN_BREP_PAIRS) return true;
    for (int i = 0; i < npairs; i++) {
        const entry *one = find(&b->vertices, pairs[i][0]), *two = find(&b->vertices, pairs[i][1]);
        if (one && two && one->number != two->number) return true;
    }
    return false;
}

static kn_status add_face(kn_ctx *ctx, kn_brep *b, const kn_brep_edge *edges, int n, const kn_brep_key (*pairs)[2],
                          int npairs, uint64_t *next, kn_brep_name *names)
{
    uint32_t at = NONE;
    kn_status status = KN_OK;
    if (contradicts(b, pairs, npairs)) {
        status = name_alone(ctx, edges, n, pairs, npairs, next, names);
        if (status == KN_OK) status = new_body(ctx, b, &b->face);
        if (status == KN_OK) b->bodies[b->face].odd = true;
        return status;
    }
    for (int i = 0; i < n && status == KN_OK; i++)
        status = take_vertices(ctx, b, &edges[i], pairs, npairs, next, &names[i]);
    for (int i = 0; i < n && status == KN_OK; i++) {
        entry *waiting = find(&b->edges, edges[i].key);
        names[i].new_edge = waiting == NULL;
        names[i].edge = waiting ? waiting->number : 0;
        names[i].against = waiting && waiting->against;
        names[i].last = waiting && !waiting->seed, names[i].seam = false;
        names[i].pcurve[0] = waiting ? waiting->pcurve : edges[i].pcurve;
        names[i].pcurve[1] = waiting ? edges[i].pcurve : 0;
        if (waiting) join(b, &edges[i], waiting, &at);
    }
    if (status == KN_OK && at == NONE) status = new_body(ctx, b, &at);
    for (int i = 0; i < n && status == KN_OK; i++)
        if (names[i].new_edge) status = begin_edge(ctx, b, edges, i, at, next, names);
    for (int i = 0; i < n && status == KN_OK; i++)
        if (names[i].new_edge && !names[i].last) status = wait_on(ctx, b, &edges[i], at, &names[i]);
    for (int i = 0; i < n && status == KN_OK; i++)
        for (int k = 0; k < 2; k++) release_vertex(b, edges[i].vertex[k]);
    b->face = at;
    return status;
}

// As faces of the group know them.
static kn_brep_edge edge_in(int group, const kn_brep_edge *edge)
{
    kn_brep_edge e = *edge;
    if (group == 0) return e;
    e.key = kn_brep_mix(e.key, group);
    for (int k = 0; k < 2; k++) e.vertex[k] = kn_brep_mix(e.vertex[k], group);
    return e;
}

kn_status kn_brep_add(kn_ctx *ctx, kn_brep *b, int group, const kn_brep_edge *edges, int n,
                      const kn_brep_key (*pairs)[2], int npairs, uint64_t *next, kn_brep_name *names)
{
    if (group == 0) return add_face(ctx, b, edges, n, pairs, npairs, next, names);
    kn_mark mark = kn_scratch_mark(ctx);
    int read = npairs < KN_BREP_PAIRS ? npairs : KN_BREP_PAIRS;
    kn_brep_edge *own = kn_scratch(ctx, (size_t)n, sizeof *own);
    kn_brep_key(*points)[2] = kn_scratch(ctx, (size_t)read, sizeof *points);
    kn_status status = own && points ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < n && status == KN_OK; i++) own[i] = edge_in(group, &edges[i]);
    for (int i = 0; i < 2 * read && status == KN_OK; i++)
        points[i / 2][i % 2] = kn_brep_mix(pairs[i / 2][i % 2], group);
    if (status == KN_OK) status = add_face(ctx, b, own, n, (const kn_brep_key(*)[2])points, npairs, next, names);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status new_chunk(kn_ctx *ctx, kn_brep *b, uint32_t *out)
{
    if (b->free_chunk == NONE) {
        if (b->nchunks == b->chunk_room) {
            size_t room = b->chunk_room > 0 ? 2 * b->chunk_room : FIRST_ROOM;
            if (room >= NONE) return kn_fail(ctx, KN_ELIMIT, "%zu lists of faces", room);
            chunk *more = kn_resize(ctx, b->chunks, room, sizeof *more);
            if (!more) return KN_ENOMEM;
            b->chunks = more, b->chunk_room = room;
        }
        b->chunks[b->nchunks].next = NONE;
        b->free_chunk = (uint32_t)b->nchunks++;
    }
    *out = b->free_chunk;
    b->free_chunk = b->chunks[*out].next;
    return KN_OK;
}

static void put_varint(chunk *c, uint64_t x)
{
    for (; x >= 128; x >>= 7) c->data[c->used++] = (unsigned char)(x | 128);
    c->data[c->used++] = (unsigned char)x;
}

kn_status kn_brep_end_face(kn_ctx *ctx, kn_brep *b, uint64_t number, int look, int *closed)
{
    body *x = &b->bodies[b->face];
    chunk *c = x->tail != NONE ? &b->chunks[x->tail] : NULL;
    if (!c || number <= c->last || c->used + 2 * VARINT_BYTES > CHUNK_BYTES) {
        uint32_t fresh = NONE;
        kn_status status = new_chunk(ctx, b, &fresh);
        if (status != KN_OK) return status;
        c = &b->chunks[fresh];
        *c = (chunk){.number = number, .look = look, .next = NONE};
        if (x->tail != NONE) b->chunks[x->tail].next = fresh;
        if (x->head == NONE) x->head = fresh;
        x->tail = fresh;
    } else {
        put_varint(c, 2 * (number - c->last) + (look != c->last_look));
        if (look != c->last_look) put_varint(c, (uint64_t)look);
    }
    c->last = number, c->last_look = look;
    x->look = x->faces == 0 || x->look == look ? look : KN_BREP_NONE;
    x->faces++;
    *closed = x->waiting == 0 && !x->odd && !x->held ? (int)b->face : KN_BREP_NONE;
    return KN_OK;
}

kn_status kn_brep_open(kn_ctx *ctx, kn_brep *b, int *out)
{
    uint32_t at = NONE;
    kn_status status = new_body(ctx, b, &at);
    if (status != KN_OK) return status;
    b->bodies[at].odd = true;
    *out = (int)at;
    return KN_OK;
}

kn_status kn_brep_append(kn_ctx *ctx, kn_brep *b, int at, uint64_t number, int look)
{
    int closed;
    b->face = (uint32_t)at;
    return kn_brep_end_face(ctx, b, number, look, &closed);
}

// ---- bodies of others ----

kn_status kn_brep_hold(kn_ctx *ctx, kn_brep *b, int *out)
{
    uint32_t at = NONE;
    kn_status status = new_body(ctx, b, &at);
    if (status != KN_OK) return status;
    b->bodies[at].held = true;
    b->bodies[at].refs = 1; // the caller
    *out = (int)at;
    return KN_OK;
}

kn_status kn_brep_seed(kn_ctx *ctx, kn_brep *b, int group, int at, const kn_brep_edge *edge, uint64_t number,
                       const uint64_t vertex[2], bool against)
{
    const kn_brep_edge own = edge_in(group, edge);
    edge = &own;
    entry *twin = find(&b->edges, edge->key);
    bool pair = twin && twin->number == number && twin->body == (uint32_t)at && !twin->twice &&
                twin->forward != edge->forward && twin->against == against;
    if (twin && !pair) return kn_fail(ctx, KN_EDOMAIN, "edge #%llu is there twice", (unsigned long long)number);
    for (int k = 0; k < 2; k++) {
        const entry *v = find(&b->vertices, edge->vertex[k]);
        if (v && v->number != vertex[k])
            return kn_fail(ctx, KN_EDOMAIN, "vertices #%llu and #%llu are one point", (unsigned long long)v->number,
                           (unsigned long long)vertex[k]);
    }
    kn_status status = KN_OK;
    for (int k = 0; k < 2 && status == KN_OK; k++) {
        entry *v = find(&b->vertices, edge->vertex[k]),
              fresh = {.key = edge->vertex[k], .number = vertex[k], .uses = 1};
        if (v)
            v->uses++;
        else
            status = insert(ctx, &b->vertices, &fresh, NULL);
    }
    entry fresh = {.key = edge->key, .number = number, .body = (uint32_t)at, .uses = 1};
    fresh.forward = edge->forward, fresh.against = against, fresh.seed = true;
    if (pair)
        twin->twice = true;
    else if (status == KN_OK)
        status = insert(ctx, &b->edges, &fresh, NULL);
    if (status == KN_OK) b->bodies[at].waiting++, b->bodies[at].refs++;
    return status;
}

void kn_brep_tie(kn_brep *b, int at)
{
    b->face = unite(b, b->face, root_of(b, (uint32_t)at));
}

int kn_brep_root(const kn_brep *b, int at)
{
    return (int)root_of(b, (uint32_t)at);
}

bool kn_brep_held(const kn_brep *b, int at)
{
    return b->bodies[at].held;
}

uint32_t kn_brep_waiting(const kn_brep *b, int at, bool *odd)
{
    *odd = b->bodies[at].odd;
    return b->bodies[at].waiting;
}

bool kn_brep_next_body(const kn_brep *b, int *at)
{
    size_t i = *at == KN_BREP_NONE ? 0 : (size_t)*at + 1;
    while (i < b->nbodies && !(b->bodies[i].there && b->bodies[i].parent == NONE)) i++;
    if (i >= b->nbodies) return false;
    *at = (int)i;
    return true;
}

bool kn_brep_next_edge(const kn_brep *b, size_t *at, kn_brep_open_edge *edge)
{
    const entry *e = b->edges.entries;
    for (; *at < b->edges.room; ++*at) {
        const entry *x = &e[*at];
        if (x->uses == 0 || x->seed) continue;
        *edge = (kn_brep_open_edge){x->number, {x->vertex[0], x->vertex[1]}, x->pcurve};
        ++*at;
        return true;
    }
    return false;
}

kn_brep_walk kn_brep_faces(const kn_brep *b, int at)
{
    return (kn_brep_walk){.chunk = b->bodies[at].head, .left = b->bodies[at].faces};
}

static uint64_t take_varint(const chunk *c, uint32_t *at)
{
    uint64_t x = 0;
    for (int shift = 0;; shift += 7) {
        unsigned char byte = c->data[(*at)++];
        x |= (uint64_t)(byte & 127) << shift;
        if (byte < 128) return x;
    }
}

// at: 0 before the chunk's first face, then 1 and the bytes that were read.
bool kn_brep_step(const kn_brep *b, kn_brep_walk *w)
{
    if (w->left == 0) return false;
    const chunk *c = &b->chunks[w->chunk];
    if (w->at > c->used) {
        w->chunk = c->next, w->at = 0;
        c = &b->chunks[w->chunk];
    }
    if (w->at == 0) {
        w->number = c->number, w->look = c->look, w->at = 1;
    } else {
        uint32_t at = w->at - 1;
        uint64_t step = take_varint(c, &at);
        w->number += step / 2;
        if (step % 2) w->look = (int)take_varint(c, &at);
        w->at = at + 1;
    }
    w->left--;
    return true;
}

int kn_brep_look(const kn_brep *b, int at)
{
    return b->bodies[at].look;
}

void kn_brep_drop(kn_brep *b, int at)
{
    body *x = &b->bodies[at];
    if (x->head != NONE) {
        b->chunks[x->tail].next = b->free_chunk;
        b->free_chunk = x->head;
    }
    *x = (body){.parent = b->free_body};
    b->free_body = (uint32_t)at;
}

// ---- life ----

kn_status kn_brep_create(kn_ctx *ctx, kn_brep **out)
{
    kn_brep *b = kn_alloc_zero(ctx, 1, sizeof *b);
    if (!b) return KN_ENOMEM;
    b->free_body = b->free_chunk = b->face = NONE;
    *out = b;
    return KN_OK;
}

static void clear(kn_ctx *ctx, kn_brep *b)
{
    kn_free(ctx, b->edges.entries), kn_free(ctx, b->vertices.entries);
    kn_free(ctx, b->bodies), kn_free(ctx, b->chunks);
}

void kn_brep_destroy(kn_ctx *ctx, kn_brep *b)
{
    if (!b) return;
    clear(ctx, b);
    kn_free(ctx, b);
}

void kn_brep_save(const kn_brep *b, kn_state *state)
{
    kn_state_put(state, b, sizeof *b);
    kn_state_put_block(state, b->edges.entries, b->edges.room * sizeof(entry));
    kn_state_put_block(state, b->vertices.entries, b->vertices.room * sizeof(entry));
    kn_state_put_block(state, b->bodies, b->nbodies * sizeof(body));
    kn_state_put_block(state, b->chunks, b->nchunks * sizeof(chunk));
}

static bool take(kn_ctx *ctx, kn_state_reader *r, void **out, size_t count, size_t size, bool *room)
{
    size_t bytes = 0;
    const void *from = kn_state_take_block(r, &bytes);
    *out = NULL;
    if (!from || bytes != count * size) return false;
    if (bytes == 0) return true;
    *out = kn_alloc(ctx, count, size);
    if (*out) memcpy(*out, from, bytes);
    *room = *room && *out;
    return true;
}

kn_status kn_brep_restore(kn_ctx *ctx, kn_brep *b, kn_state_reader *r)
{
    kn_brep c;
    bool room = true, good = kn_state_take(r, &c, sizeof c);
    void *part[4] = {NULL, NULL, NULL, NULL};
    good = good && take(ctx, r, &part[0], c.edges.room, sizeof(entry), &room);
    good = good && take(ctx, r, &part[1], c.vertices.room, sizeof(entry), &room);
    good = good && take(ctx, r, &part[2], c.nbodies, sizeof(body), &room);
    good = good && take(ctx, r, &part[3], c.nchunks, sizeof(chunk), &room);
    if (!good || !room) {
        for (int i = 0; i < 4; i++) kn_free(ctx, part[i]);
        return room ? kn_state_fail(ctx, "STEP") : KN_ENOMEM;
    }
    clear(ctx, b);
    c.edges.entries = part[0], c.vertices.entries = part[1], c.bodies = part[2], c.chunks = part[3];
    c.body_room = c.nbodies, c.chunk_room = c.nchunks;
    *b = c;
    return KN_OK;
}
