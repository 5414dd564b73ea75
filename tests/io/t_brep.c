// SPDX-License-Identifier: Apache-2.0
// Faces joined while they pass by: grids of known topology in several orders, memory that follows the front, journals.
#include <stdlib.h>
#include <string.h>

#include "io/brep.h"
#include "tests/support/support.h"

// Corner (i,j) of a grid on a surface of nu by nv faces, closed in u and v as told: its point.
typedef struct grid {
    int nu, nv;
    bool closed_u, closed_v;
} grid;

static void corner(double x[3], const grid *g, int i, int j)
{
    if (g->closed_u) i %= g->nu;
    if (g->closed_v) j %= g->nv;
    x[0] = i, x[1] = j, x[2] = 0.5 * i * j;
}

static kn_brep_key vertex_key(const double x[3])
{
    bool turned;
    return kn_brep_hash(&turned, x, 3, 1, 1, 1);
}

// Edge k of the face (i,j), counterclockwise: two points.
static kn_brep_edge make_edge(const grid *g, int i, int j, int k)
{
    static const int at[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    double x[2][3];
    bool turned;
    for (int e = 0; e < 2; e++) corner(x[e], g, i + at[k + e][0], j + at[k + e][1]);
    kn_brep_edge edge = {.key = kn_brep_hash(&turned, x[0], 3, 1, 2, 3)};
    edge.forward = !turned;
    for (int e = 0; e < 2; e++) edge.vertex[e] = vertex_key(x[turned ? 1 - e : e]);
    return edge;
}

typedef struct count {
    uint64_t vertices, edges, next, closed;
    int body;
} count;

static void add(kn_ctx *ctx, kn_brep *b, const grid *g, int i, int j, count *c)
{
    kn_brep_edge edges[4];
    kn_brep_name names[4];
    int closed;
    for (int k = 0; k < 4; k++) edges[k] = make_edge(g, i, j, k);
    assert_int_equal(kn_brep_add(ctx, b, 0, edges, 4, NULL, 0, &c->next, names), KN_OK);
    for (int k = 0; k < 4; k++) {
        c->edges += names[k].new_edge;
        for (int e = 0; e < 2; e++) c->vertices += names[k].new_vertex[e];
        // The loop is connected: where one edge ends the next one starts.
        int n = (k + 1) % 4;
        uint64_t end = names[k].vertex[edges[k].forward], start = names[n].vertex[!edges[n].forward];
        assert_true(end == start);
    }
    assert_int_equal(kn_brep_end_face(ctx, b, c->next++, 7, &closed), KN_OK);
    if (closed != KN_BREP_NONE) c->closed++, c->body = closed;
}

// A torus has as many vertices as faces, and twice as many edges; it closes with the last face. A cylinder and a sheet
// never close.
static void known_topology(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int run = 0; run < test_scale(40); run++) {
        grid g = {test_int(&rng, 3, 12), test_int(&rng, 3, 12), run % 2, run / 2 % 2};
        int n = g.nu * g.nv, order[144];
        kn_brep *b = NULL;
        count c = {.next = 100};
        assert_int_equal(kn_brep_create(ctx, &b), KN_OK);
        for (int k = 0; k < n; k++) order[k] = k;
        for (int k = n - 1; k > 0 && run % 3; k--) { // row by row, or any order
            int to = test_int(&rng, 0, k), t = order[k];
            order[k] = order[to], order[to] = t;
        }
        for (int k = 0; k < n; k++) {
            assert_int_equal(c.closed, 0);
            add(ctx, b, &g, order[k] % g.nu, order[k] / g.nu, &c);
        }
        uint64_t nu = (uint64_t)g.nu, nv = (uint64_t)g.nv;
        uint64_t columns = nu + !g.closed_u, rows = nv + !g.closed_v;
        assert_int_equal(c.edges, nu * rows + nv * columns);
        // A vertex of which all faces have passed is forgotten, and the order may bring it back: only row by row, or
        // where the fan of each is complete, there is one of each.
        assert_true(c.vertices >= columns * rows);
        if (run % 3 == 0) assert_int_equal(c.vertices, columns * rows);
        assert_int_equal(c.closed, g.closed_u && g.closed_v);
        int body = KN_BREP_NONE, bodies = 0;
        while (kn_brep_next_body(b, &body)) {
            kn_brep_walk walk = kn_brep_faces(b, body);
            int faces = 0;
            while (kn_brep_step(b, &walk)) {
                assert_true(walk.number >= 100 && walk.number < c.next && walk.look == 7);
                faces++;
            }
            assert_int_equal(faces, n);
            assert_int_equal(kn_brep_look(b, body), 7);
            bodies++;
        }
        assert_int_equal(bodies, 1);
        kn_brep_destroy(ctx, b);
    }
    test_ctx_end(ctx, &memory);
}

// Ten thousand tori pass by: as much memory as for a few of them.
static void memory_follows_the_front(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_brep *b = NULL;
    assert_int_equal(kn_brep_create(ctx, &b), KN_OK);
    grid g = {4, 4, true, true};
    size_t after[2] = {0, 0};
    for (int k = 0; k < 10000; k++) {
        count c = {.next = 1};
        for (int i = 0; i < 16; i++) add(ctx, b, &g, i % 4, i / 4, &c);
        assert_int_equal(c.closed, 1);
        kn_brep_drop(b, c.body);
        if (k == 9 || k == 9999) after[k == 9999] = kn_ctx_counters(ctx).peak_bytes;
    }
    assert_int_equal(after[0], after[1]);
    int body = KN_BREP_NONE;
    assert_false(kn_brep_next_body(b, &body));
    kn_brep_destroy(ctx, b);
    test_ctx_end(ctx, &memory);
}

// Numbers of any size and distance, and looks that change, come back in order.
static void lists_of_faces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    kn_brep *b = NULL;
    assert_int_equal(kn_brep_create(ctx, &b), KN_OK);
    grid g = {1000, 1, false, false};
    uint64_t number[1000], next = 1;
    int look[1000];
    for (int i = 0; i < 1000; i++) {
        kn_brep_edge edges[4];
        kn_brep_name names[4];
        int closed;
        for (int k = 0; k < 4; k++) edges[k] = make_edge(&g, i, 0, k);
        assert_int_equal(kn_brep_add(ctx, b, 0, edges, 4, NULL, 0, &next, names), KN_OK);
        next += (uint64_t)1 << test_int(&rng, 0, 40);
        number[i] = next, look[i] = test_int(&rng, 0, 3) ? (i > 0 ? look[i - 1] : 0) : test_int(&rng, 0, 300);
        assert_int_equal(kn_brep_end_face(ctx, b, number[i], look[i], &closed), KN_OK);
        assert_int_equal(closed, KN_BREP_NONE);
    }
    int body = KN_BREP_NONE;
    assert_true(kn_brep_next_body(b, &body));
    assert_int_equal(kn_brep_look(b, body), KN_BREP_NONE);
    kn_brep_walk walk = kn_brep_faces(b, body);
    for (int i = 0; i < 1000; i++) {
        assert_true(kn_brep_step(b, &walk));
        assert_true(walk.number == number[i] && walk.look == look[i]);
    }
    assert_false(kn_brep_step(b, &walk));
    kn_brep_destroy(ctx, b);
    test_ctx_end(ctx, &memory);
}

// Two faces that use their edge in the same direction are no closed body; nor are three at one edge. A face that is
// its own neighbour across a seam is.
static void odd_ones(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_brep *b = NULL;
    kn_brep_name names[2];
    uint64_t next = 1;
    int closed;
    assert_int_equal(kn_brep_create(ctx, &b), KN_OK);
    const double x[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}};
    bool turned;
    kn_brep_edge one = {.key = {1, 2}, .vertex = {vertex_key(x[0]), vertex_key(x[1])}, .forward = true};
    kn_brep_key negative = vertex_key(x[3]);
    assert_memory_equal(&one.vertex[0], &negative, sizeof negative);
    // The same points from either end have one key.
    kn_brep_key there = kn_brep_hash(&turned, x[0], 3, 1, 3, 3);
    bool before = turned;
    kn_brep_key back = kn_brep_hash(&turned, x[2], 3, 1, 3, -3);
    assert_true(there.a == back.a && there.b == back.b && turned != before);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(kn_brep_add(ctx, b, 0, &one, 1, NULL, 0, &next, names), KN_OK);
        assert_int_equal(kn_brep_end_face(ctx, b, next++, 0, &closed), KN_OK);
        assert_int_equal(closed, KN_BREP_NONE);
    }
    kn_brep_edge seam[2] = {{.key = {3, 4}, .vertex = {{5, 5}, {6, 6}}, .forward = true}};
    seam[1] = seam[0], seam[1].forward = false;
    assert_int_equal(kn_brep_add(ctx, b, 0, seam, 2, NULL, 0, &next, names), KN_OK);
    assert_true(names[0].new_edge && !names[1].new_edge && names[0].edge == names[1].edge);
    assert_int_equal(kn_brep_end_face(ctx, b, next++, 0, &closed), KN_OK);
    assert_int_not_equal(closed, KN_BREP_NONE);
    // Two ends of a collapsed edge are one vertex; where they already have two numbers the face stands alone.
    kn_brep_edge fan[2] = {{.key = {7, 7}, .vertex = {{10, 0}, {20, 0}}, .forward = true},
                           {.key = {8, 8}, .vertex = {{11, 0}, {20, 0}}, .forward = false}};
    const kn_brep_key pair[1][2] = {{{10, 0}, {11, 0}}};
    assert_int_equal(kn_brep_add(ctx, b, 0, fan, 2, pair, 1, &next, names), KN_OK);
    assert_true(names[0].vertex[0] == names[1].vertex[0] && names[0].vertex[1] == names[1].vertex[1]);
    assert_int_equal(names[0].new_vertex[0] + names[1].new_vertex[0], 1);
    kn_brep_edge apart[2] = {{.key = {9, 9}, .vertex = {{10, 0}, {30, 0}}},
                             {.key = {9, 1}, .vertex = {{12, 0}, {40, 0}}}};
    assert_int_equal(kn_brep_add(ctx, b, 0, apart, 2, NULL, 0, &next, names), KN_OK);
    assert_int_equal(kn_brep_end_face(ctx, b, next++, 0, &closed), KN_OK);
    const kn_brep_key conflict[1][2] = {{{10, 0}, {12, 0}}};
    kn_brep_edge last[1] = {{.key = {7, 7}, .vertex = {{10, 0}, {20, 0}}, .forward = false}};
    assert_int_equal(kn_brep_add(ctx, b, 0, last, 1, conflict, 1, &next, names), KN_OK);
    assert_true(names[0].new_edge && names[0].new_vertex[0] && names[0].new_vertex[1]);
    assert_int_equal(kn_brep_end_face(ctx, b, next++, 0, &closed), KN_OK);
    assert_int_equal(closed, KN_BREP_NONE);
    kn_brep_destroy(ctx, b);
    test_ctx_end(ctx, &memory);
}

// Saved in the middle and gone on with by another one: the same names.
static void journals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    grid g = {7, 5, true, true};
    for (int cut = 0; cut < 35; cut += 6) {
        kn_brep *b = NULL, *again = NULL;
        count one = {.next = 1}, two;
        assert_int_equal(kn_brep_create(ctx, &b), KN_OK);
        assert_int_equal(kn_brep_create(ctx, &again), KN_OK);
        for (int k = 0; k < cut; k++) add(ctx, b, &g, k % 7, k / 7, &one);
        kn_state s = {.ctx = ctx};
        kn_brep_save(b, &s);
        assert_false(s.failed);
        kn_state_reader r = {s.data, s.bytes};
        assert_int_equal(kn_brep_restore(ctx, again, &r), KN_OK);
        assert_int_equal(r.bytes, 0);
        two = one;
        for (int k = cut; k < 35; k++) add(ctx, b, &g, k % 7, k / 7, &one), add(ctx, again, &g, k % 7, k / 7, &two);
        assert_memory_equal(&one, &two, sizeof one);
        assert_int_equal(two.closed, 1);
        for (size_t most = 0; most < s.bytes; most += 97) { // cut short: refused, and as it was
            kn_state_reader part = {s.data, most};
            assert_int_equal(kn_brep_restore(ctx, again, &part), KN_EDOMAIN);
            kn_ctx_clear_error(ctx);
        }
        kn_free(ctx, s.data);
        kn_brep_destroy(ctx, b), kn_brep_destroy(ctx, again);
    }
    test_ctx_end(ctx, &memory);
}

static kn_status starved(kn_ctx *ctx, void *user)
{
    (void)user;
    grid g = {12, 12, true, false};
    kn_brep *b = NULL;
    uint64_t next = 1;
    int closed;
    kn_status status = kn_brep_create(ctx, &b);
    for (int k = 0; k < 144 && status == KN_OK; k++) {
        kn_brep_edge edges[4];
        kn_brep_name names[4];
        for (int e = 0; e < 4; e++) edges[e] = make_edge(&g, k % 12, k / 12, e);
        status = kn_brep_add(ctx, b, 0, edges, 4, NULL, 0, &next, names);
        if (status == KN_OK) status = kn_brep_end_face(ctx, b, next++, 0, &closed);
    }
    kn_brep_destroy(ctx, b);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_allocation_failures(starved, NULL);
}

static kn_brep_key number_key(double x)
{
    return kn_brep_mix((kn_brep_key){1, 2}, x);
}

// A ring of n edges of one face, from vertex to vertex.
static void make_ring(kn_brep_edge *edges, int n, double first)
{
    for (int i = 0; i < n; i++) {
        edges[i] = (kn_brep_edge){.key = number_key(first + i), .forward = true};
        edges[i].vertex[0] = number_key(-1 - i), edges[i].vertex[1] = number_key(-1 - (i + 1) % n);
    }
}

// An edge that one face uses three times: a seam, and one that waits. Too many points: a face by itself. Vertices that an
// edge of the same key has not: other names, and nothing worse.
static void one_face(void **state)
{
    (void)state;
    enum { N = 200 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_brep *b = NULL;
    kn_brep_edge edges[N];
    kn_brep_name names[N];
    kn_brep_key pairs[KN_BREP_PAIRS][2];
    uint64_t next = 1;
    int closed;
    bool odd;
    assert_int_equal(kn_brep_create(ctx, &b), KN_OK);
    make_ring(edges, N, 0.0);
    edges[7].key = edges[100].key = edges[3].key;
    edges[7].forward = false;
    assert_int_equal(kn_brep_add(ctx, b, 0, edges, N, NULL, 0, &next, names), KN_OK);
    assert_int_equal(next, 1 + N + 2 * (N - 1)); // vertices, and edges but the seam's second use
    assert_true(names[3].seam && names[3].last && names[3].new_edge && !names[7].new_edge);
    assert_int_equal(names[7].edge, names[3].edge);
    assert_true(names[100].new_edge && !names[100].last && names[100].edge != names[3].edge);
    assert_int_equal(kn_brep_end_face(ctx, b, next++, 0, &closed), KN_OK);
    assert_int_equal(closed, KN_BREP_NONE);
    int at = KN_BREP_NONE;
    assert_true(kn_brep_next_body(b, &at));
    assert_int_equal(kn_brep_waiting(b, at, &odd), N - 2);
    assert_false(odd);
    // the same edges between other vertices
    for (int i = 0; i < N; i++) edges[i].forward = !edges[i].forward, edges[i].vertex[0] = number_key(1000 + i);
    assert_int_equal(kn_brep_add(ctx, b, 0, edges, N, NULL, 0, &next, names), KN_OK);
    assert_int_equal(kn_brep_end_face(ctx, b, next++, 0, &closed), KN_OK);
    // more pairs than are read: all names are new, the last number that of the last edge
    make_ring(edges, N, 5000.0);
    for (int i = 0; i < KN_BREP_PAIRS; i++) pairs[i][0] = edges[i].vertex[0], pairs[i][1] = number_key(9000 + i);
    uint64_t before = next;
    assert_int_equal(
        kn_brep_add(ctx, b, 0, edges, N, (const kn_brep_key(*)[2])pairs, KN_BREP_PAIRS + 1, &next, names), KN_OK);
    assert_int_equal(next, before + 3 * N);
    for (int i = 0; i < N; i++) {
        assert_true(names[i].new_edge && names[i].last);
        assert_int_equal(names[i].edge, before + N + 2 * (uint64_t)i + 1);
        assert_int_equal(names[i].vertex[1], names[(i + 1) % N].vertex[0]);
    }
    kn_brep_destroy(ctx, b);
    test_ctx_end(ctx, &memory);
}

// Equal rings of two groups are two bodies; equal ones of one group close it.
static void groups(void **state)
{
    (void)state;
    enum { N = 5 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_brep *b = NULL;
    kn_brep_edge edges[N];
    kn_brep_name names[N];
    kn_brep_key pair[1][2] = {{number_key(70), number_key(71)}};
    uint64_t next = 1;
    int closed;
    assert_int_equal(kn_brep_create(ctx, &b), KN_OK);
    for (int round = 0; round < 2; round++) {
        make_ring(edges, N, 0.0);
        for (int i = 0; i < N; i++) edges[i].forward = round == 0;
        for (int group = 0; group < 3; group++) {
            assert_int_equal(kn_brep_add(ctx, b, group, edges, N, (const kn_brep_key(*)[2])pair, 1, &next, names),
                             KN_OK);
            for (int i = 0; i < N; i++)
                assert_true(names[i].new_edge == (round == 0) && names[i].last == (round == 1));
            assert_int_equal(kn_brep_end_face(ctx, b, next++, 0, &closed), KN_OK);
            assert_true((closed != KN_BREP_NONE) == (round == 1));
            if (closed != KN_BREP_NONE) kn_brep_drop(b, closed);
        }
    }
    assert_int_equal(next, 1 + 3 * (N + 2 * N + 2)); // vertices, edges, two faces
    kn_brep_destroy(ctx, b);
    test_ctx_end(ctx, &memory);
}

// An edge of a body of others that two faces to come have: once for each direction, whichever comes first. A third
// time, or in the same direction, or by another name, it is refused.
static void seeds_for_two(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int first = 0; first < 2; first++) {
        kn_brep *b = NULL;
        kn_brep_edge ring[3], edge;
        kn_brep_name names[3];
        const uint64_t vertex[2] = {501, 502};
        uint64_t next = 1;
        int held, closed;
        bool odd;
        assert_int_equal(kn_brep_create(ctx, &b), KN_OK);
        assert_int_equal(kn_brep_hold(ctx, b, &held), KN_OK);
        make_ring(ring, 3, 0.0);
        edge = ring[1];
        for (int k = 0; k < 2; k++) {
            edge.forward = k == 0;
            assert_int_equal(kn_brep_seed(ctx, b, 4, held, &edge, 500, vertex, true), KN_OK);
            if (k == 0) assert_int_equal(kn_brep_seed(ctx, b, 4, held, &edge, 500, vertex, true), KN_EDOMAIN);
        }
        assert_int_equal(kn_brep_seed(ctx, b, 4, held, &edge, 500, vertex, true), KN_EDOMAIN);
        assert_int_equal(kn_brep_seed(ctx, b, 4, held, &edge, 499, vertex, true), KN_EDOMAIN);
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_brep_waiting(b, held, &odd), 2);
        for (int face = 0; face < 2; face++) {
            for (int i = 0; i < 3; i++) ring[i].forward = face == first;
            assert_int_equal(kn_brep_add(ctx, b, 4, ring, 3, NULL, 0, &next, names), KN_OK);
            assert_int_equal(names[1].edge, 500);
            assert_true(!names[1].new_edge && !names[1].last && names[1].against);
            for (int k = 0; k < 2; k++) assert_int_equal(names[1].vertex[k], vertex[k]);
            assert_int_equal(kn_brep_end_face(ctx, b, next++, 0, &closed), KN_OK);
            assert_int_equal(kn_brep_waiting(b, kn_brep_root(b, held), &odd), face == 0 ? 3 : 0);
            assert_false(odd);
        }
        kn_brep_destroy(ctx, b);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_face),
        cmocka_unit_test(groups),
        cmocka_unit_test(seeds_for_two),
        cmocka_unit_test(known_topology),
        cmocka_unit_test(memory_follows_the_front),
        cmocka_unit_test(lists_of_faces),
        cmocka_unit_test(odd_ones),
        cmocka_unit_test(journals),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("io/brep", tests, NULL, NULL);
}
