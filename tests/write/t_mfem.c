// SPDX-License-Identifier: Apache-2.0
// MFEM NURBS meshes, by a reader written from mfem.org's description of the format: there is no MFEM to ask in Debian.
// Its rules for edges (each belongs to a knot vector, in a direction; those opposite each other in a patch to the same
// one in the same direction) are those of MFEM's own check.
#include "tests/support/scene.h"
#include "tests/write/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 64, POINTS = 96 };

typedef struct patch {
    int degree[3], count[3];
    double knots[3][16], points[POINTS][4];
} patch;

typedef struct mesh {
    int dim, elements, boundary, edges, vertices;
    int element[MOST][10], side[2 * MOST][6], edge[4 * MOST][3];
    patch patch[MOST];
} mesh;

static const char *at; // of the text that is read

static void skip_blanks(void)
{
    for (;;) {
        at += strspn(at, " \n");
        if (*at != '#') return;
        at += strcspn(at, "\n");
    }
}

static void word(const char *expected)
{
    skip_blanks();
    size_t n = strlen(expected);
    if (strncmp(at, expected, n) != 0) fail_msg("%s expected at: %.40s", expected, at);
    at += n;
}

static double real(void)
{
    char *end;
    skip_blanks();
    double x = strtod(at, &end);
    assert_true(end != at);
    at = end;
    return x;
}

static int integer(int lo, int hi)
{
    double x = real();
    assert_true(x == (int)x && x >= lo && x <= hi);
    return (int)x;
}

static void read_patch(mesh *m, patch *p)
{
    int n = 1;
    word("knotvectors");
    assert_int_equal(integer(2, 3), m->dim);
    for (int d = 0; d < m->dim; d++) {
        p->degree[d] = integer(1, 9);
        p->count[d] = integer(2, 10);
        for (int i = 0; i <= p->count[d] + p->degree[d]; i++) p->knots[d][i] = real();
        n *= p->count[d];
    }
    word("dimension");
    assert_int_equal(integer(3, 3), 3);
    word("controlpoints");
    assert_true(n <= POINTS);
    for (int i = 0; i < n; i++)
        for (int c = 0; c < 4; c++) p->points[i][c] = real();
}

static mesh *read_mesh(char *text)
{
    mesh *m = calloc(1, sizeof *m);
    assert_non_null(m);
    at = text;
    word("MFEM NURBS mesh v1.0");
    word("dimension");
    m->dim = integer(2, 3);
    int corners = m->dim == 2 ? 4 : 8, ends = m->dim == 2 ? 2 : 4;
    word("elements");
    m->elements = integer(1, MOST);
    for (int i = 0; i < m->elements; i++) {
        m->element[i][0] = integer(1, 9);
        assert_int_equal(integer(3, 5), m->dim == 2 ? 3 : 5); // SQUARE, CUBE
        for (int k = 0; k < corners; k++) m->element[i][2 + k] = integer(0, 10000);
    }
    word("boundary");
    m->boundary = integer(0, 2 * MOST);
    for (int i = 0; i < m->boundary; i++) {
        m->side[i][0] = integer(1, 6);
        assert_int_equal(integer(1, 3), m->dim == 2 ? 1 : 3); // SEGMENT, SQUARE
        for (int k = 0; k < ends; k++) m->side[i][2 + k] = integer(0, 10000);
    }
    word("edges");
    m->edges = integer(1, 4 * MOST);
    for (int i = 0; i < m->edges; i++)
        for (int k = 0; k < 3; k++) m->edge[i][k] = integer(0, 10000);
    word("vertices");
    m->vertices = integer(1, 10000);
    word("patches");
    for (int i = 0; i < m->elements; i++) read_patch(m, &m->patch[i]);
    skip_blanks();
    assert_true(*at == '\0');
    free(text);
    return m;
}

// The knot vector of the edge from vertex a to b: k, or -1 - k against its direction.
static int knot_vector(const mesh *m, int a, int b)
{
    int found = 0, k = 0;
    for (int i = 0; i < m->edges; i++) {
        if (m->edge[i][1] == a && m->edge[i][2] == b) k = m->edge[i][0], found++;
        if (m->edge[i][1] == b && m->edge[i][2] == a) k = -1 - m->edge[i][0], found++;
    }
    assert_int_equal(found, 1);
    return k;
}

// Where corner k of an element has its control point.
static const double *corner_of(const patch *p, int dim, int k)
{
    static const int place[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    int at_d = 0, stride = 1;
    for (int d = 0; d < dim; stride *= p->count[d++]) at_d += place[k][d] * (p->count[d] - 1) * stride;
    return p->points[at_d];
}

static void assert_edge(mesh *m, int e, int a, int b, int d, int *expected, double (*knots)[16])
{
    const int *v = &m->element[e][2];
    const patch *p = &m->patch[e];
    int k = knot_vector(m, v[a], v[b]), which = k < 0 ? -1 - k : k, n = p->count[d] + p->degree[d] + 1;
    if (*expected == -100) *expected = k;
    assert_int_equal(k, *expected);
    for (int i = 0; i < n; i++) { // of the pieces here all are 0 .. 1
        double x = k < 0 ? 1 - p->knots[d][n - 1 - i] : p->knots[d][i];
        if (knots[which][15] == 0) knots[which][i] = x;
        assert_true(knots[which][i] == x);
    }
    knots[which][15] = 1;
}

static void check(mesh *m)
{
    static const int edges[12][3] = {{0, 1, 0}, {3, 2, 0}, {4, 5, 0}, {7, 6, 0}, {0, 3, 1}, {1, 2, 1},
                                     {4, 7, 1}, {5, 6, 1}, {0, 4, 2}, {1, 5, 2}, {2, 6, 2}, {3, 7, 2}};
    double(*vertex)[4] = calloc((size_t)m->vertices, sizeof *vertex), (*knots)[16] = calloc(MOST, sizeof *knots);
    bool *seen = calloc((size_t)m->vertices, sizeof *seen);
    for (int e = 0; e < m->elements; e++) {
        for (int k = 0; k < (m->dim == 2 ? 4 : 8); k++) {
            int v = m->element[e][2 + k];
            const double *x = corner_of(&m->patch[e], m->dim, k);
            assert_true(v < m->vertices);
            if (!seen[v]) memcpy(vertex[v], x, sizeof *vertex);
            assert_memory_equal(vertex[v], x, sizeof *vertex);
            seen[v] = true;
        }
        for (int d = 0; d < m->dim; d++) {
            int expected = -100;
            for (int i = 0; i < 12; i++)
                if (edges[i][2] == d && (m->dim == 3 || (edges[i][0] < 4 && edges[i][1] < 4)))
                    assert_edge(m, e, edges[i][0], edges[i][1], d, &expected, knots);
        }
    }
    for (int v = 0; v < m->vertices; v++) {
        assert_true(seen[v]);
        for (int u = 0; u < v; u++) assert_true(memcmp(vertex[u], vertex[v], sizeof *vertex) != 0);
    }
    free(vertex), free(knots), free(seen);
}

// The pieces of a random spline on a grid of spans as patches; some are run through in another order of variables.
typedef struct grid {
    world w;
    kn_bezier *pieces;
    size_t n;
    kn_patch patches[MOST];
} grid;

static void grid_make(grid *g, int nvars, const int *count, bool rational)
{
    const int degree[3] = {2, 1, 2};
    kn_spline s = {0};
    world_make(&g->w, "grid.mesh");
    test_rng rng = test_random(7);
    test_random_spline(g->w.ctx, &s, &rng, nvars, 3 + rational, rational, degree, count, 1000);
    assert_int_equal(kn_spline_to_bezier(g->w.ctx, &g->pieces, &g->n, &s), KN_OK);
    kn_spline_clear(g->w.ctx, &s);
    memset(g->patches, 0, sizeof g->patches);
    for (size_t i = 0; i < g->n; i++) g->patches[i] = (kn_patch){.bezier = g->pieces[i], .reversed = i % 3 == 1};
}

static void grid_clear(grid *g)
{
    for (size_t i = 0; i < g->n; i++) kn_bezier_clear(g->w.ctx, &g->pieces[i]);
    kn_free(g->w.ctx, g->pieces);
    world_clear(&g->w);
}

static kn_status grid_write(grid *g)
{
    kn_sink sink = {0};
    assert_int_equal(kn_mfem_sink(g->w.ctx, &sink, g->w.path), KN_OK);
    kn_status status = test_feed(g->w.ctx, &sink, &g->w.tile.tile, &g->w.report, g->patches, g->n, 3);
    kn_sink_close(g->w.ctx, &sink);
    char beside[TEST_PATH_BYTES + 16];
    (void)snprintf(beside, sizeof beside, "%s.patches.tmp-0", g->w.path);
    assert_null(test_read_file(beside, NULL));
    return status;
}

static void surfaces_and_volumes(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        int nvars = 2 + k / 2, cells[3] = {1, 1, 1};
        grid g;
        const int count[3] = {5, 3, 4};
        grid_make(&g, nvars, count, k % 2);
        // how many spans the random knots leave, counted by the pieces' common corners below
        if (grid_write(&g) != KN_OK) fail_msg("%s", kn_ctx_message(g.w.ctx));
        mesh *m = read_mesh(test_read_file(g.w.path, NULL));
        assert_int_equal(m->dim, nvars);
        assert_int_equal(m->elements, g.n);
        check(m);
        // a grid of a x b (x c) patches: Euler's formula, and each patch's own numbers
        int inner = nvars == 2 ? 4 * m->elements - m->boundary : 6 * m->elements - m->boundary;
        assert_int_equal(inner % 2, 0);
        if (nvars == 2) assert_int_equal(m->vertices - m->edges + m->elements, 1);
        if (nvars == 3) assert_int_equal(m->vertices - m->edges + (m->boundary + inner / 2) - m->elements, 1);
        (void)cells;
        free(m);
        grid_clear(&g);
    }
}

static void on_their_own(void **state)
{
    (void)state;
    world w;
    world_make(&w, "own.mesh");
    mesh *m = read_mesh(world_write(&w, kn_mfem_sink, 7, 1, 1, NULL));
    assert_int_equal(m->elements, 1);
    assert_int_equal(m->vertices, 8);
    assert_int_equal(m->edges, 12);
    assert_int_equal(m->boundary, 6);
    assert_int_equal(m->element[0][0], 2); // part 1
    kn_spline s;
    world_spline(&w, &s, 7);
    size_t n = kn_spline_count(&s);
    for (int d = 0; d < 3; d++)
        assert_memory_equal(m->patch[0].knots[d], s.knots[d],
                            (size_t)(s.count[d] + s.degree[d] + 1) * sizeof(double));
    for (size_t k = 0; k < n; k++) {
        size_t a = (size_t)s.count[0], b = (size_t)s.count[1], c = (size_t)s.count[2];
        size_t from = (k % a * b + k / a % b) * c + k / (a * b);
        for (size_t i = 0; i < 3; i++) assert_true(m->patch[0].points[k][i] == s.coef[i * n + from]);
        assert_true(m->patch[0].points[k][3] == (s.rational ? s.coef[3 * n + from] : 1.0));
    }
    // each side of the boundary lies where its attribute says
    for (int i = 0; i < 6; i++) {
        int var = (m->side[i][0] - 1) / 2, end = (m->side[i][0] - 1) % 2;
        for (int k = 0; k < 4; k++)
            for (int v = 0; v < 8; v++) {
                static const int place[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                                {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
                if (m->element[0][2 + v] == m->side[i][2 + k]) assert_int_equal(place[v][var], end);
            }
    }
    free(m);
    kn_spline_clear(w.ctx, &s);
    world_clear(&w);
}

static void refused(grid *g, const char *why)
{
    kn_ctx_clear_error(g->w.ctx);
    remove(g->w.path);
    assert_int_equal(grid_write(g), KN_EDOMAIN);
    if (!strstr(kn_ctx_message(g->w.ctx), why)) fail_msg("%s", kn_ctx_message(g->w.ctx));
    assert_null(test_read_file(g->w.path, NULL));
    kn_ctx_clear_error(g->w.ctx);
}

static void refusals(void **state)
{
    (void)state;
    grid g;
    const int count[3] = {5, 3, 4};
    grid_make(&g, 2, count, false);
    kn_sink sink = {0};
    assert_int_equal(kn_mfem_sink(g.w.ctx, &sink, "/nowhere/x.mesh"), KN_EIO);
    // the inside of a common edge is moved on one side
    kn_bezier *b = &g.patches[0].bezier;
    assert_int_equal(b->degree[0], 2);
    double kept = b->coef[2];
    for (int k = 2; k < 4; k++) b->coef[k] += 1;
    refused(&g, "an edge between the vertices of another one");
    for (int k = 2; k < 4; k++) b->coef[k] -= 1;
    b->coef[2] = kept;
    // the same patch three times
    size_t n = g.n;
    g.patches[1] = g.patches[2] = g.patches[0];
    g.n = 3;
    refused(&g, "is the third one at an edge");
    g.n = 0;
    refused(&g, "without patches");
    g.n = n;
    // an edge that is a point
    g.n = 1;
    for (int c = 0; c < 3; c++) b->coef[6 * c + 1] = b->coef[6 * c];
    g.patches[0].id = (kn_patch_id){.surface = 4, .cell = {2, 3}, .part = 1, .patch = 7};
    refused(&g, "MFEM: patch 7 of part 1 in cell 2,3 of surface 4 has an edge that is closed or a point");
    g.n = n;
    g.w.report.curves = 2;
    refused(&g, "2 of the patches are curves");
    g.w.report.curves = 0;
    grid_clear(&g);
    world w;
    world_make(&w, "both.mesh");
    world_refused(&w, kn_mfem_sink, 5, 2, "and not of both");
    world_refused(&w, kn_mfem_sink, 4, 1, "is a curve");
    world_clear(&w);
}

// What is wrong with a tile is said before anything is composed: at the begin.
static void refused_tile(const kn_tile *tile, size_t volumes, const char *why)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_sink sink = {0};
    char path[TEST_PATH_BYTES];
    kn_job_report report = test_report(100, 3, 3);
    report.volumes = volumes;
    test_tmp_path(path, "tile.mesh");
    assert_int_equal(kn_mfem_sink(ctx, &sink, path), KN_OK);
    assert_int_equal(sink.begin(ctx, sink.user, tile, &report), why ? KN_EDOMAIN : KN_OK);
    if (why && !strstr(kn_ctx_message(ctx), why)) fail_msg("%s", kn_ctx_message(ctx));
    kn_sink_close(ctx, &sink);
    assert_null(test_read_file(path, NULL));
    test_ctx_end(ctx, &memory);
}

static void refused_tiles(void **state)
{
    (void)state;
    // Plates with one corner after the other, the last variable fastest: three at the first edge, and a triangle.
    static const double plates[4][12] = {{0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0},
                                         {0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1},
                                         {0, 0, 0, 0, 1, 0, -1, 0, 1, -1, 1, 1},
                                         {0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile = {0};
    kn_spline s = {0};
    assert_int_equal(kn_tile_init(ctx, &tile, "plates", 2), KN_OK);
    for (int i = 0; i < 3; i++) {
        refused_tile(&tile, 0, NULL); // two meet at most
        scene_multilinear(ctx, &s, 2, plates[i]);
        assert_int_equal(kn_tile_add(ctx, &tile, i > 0, &s), KN_OK);
        kn_spline_clear(ctx, &s);
    }
    refused_tile(&tile, 0, "patch 1 of part 1 in cell 0,0 of surface 0 is the third one at an edge");
    refused_tile(&tile, 100, NULL); // of volumes alone
    refused_tile(&tile, 50, "of surfaces or of volumes, and not of both");
    kn_tile_clear(ctx, &tile);
    assert_int_equal(kn_tile_init(ctx, &tile, "triangle", 1), KN_OK);
    scene_multilinear(ctx, &s, 2, plates[3]);
    assert_int_equal(kn_tile_add(ctx, &tile, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
    refused_tile(&tile, 0, "patch 0 of part 0 in cell 0,0 of surface 0 has an edge that is closed or a point");
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// A band of three patches that closes with a half turn.
static void twisted(void **state)
{
    (void)state;
    static const double points[3][12] = {// x, y, z of (0,0), (0,1), (1,0), (1,1)
                                         {0, 0, 1, 1, 0, 0, 0, 0, 0, 1, 0, 1},
                                         {1, 1, 2, 2, 0, 0, 3, 3, 0, 1, 0, 1},
                                         {2, 2, 0, 0, 3, 3, 0, 0, 0, 1, 1, 0}};
    grid g;
    const int count[3] = {3, 2, 4}, degree[2] = {1, 1};
    grid_make(&g, 2, count, false);
    kn_bezier band[3] = {{0}};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(kn_bezier_init(g.w.ctx, &band[i], 2, 3, false, degree), KN_OK);
        memcpy(band[i].coef, points[i], sizeof points[i]);
        g.patches[i] = (kn_patch){.bezier = band[i]};
    }
    size_t n = g.n;
    g.n = 3;
    refused(&g, "twisted");
    g.n = n;
    for (int i = 0; i < 3; i++) kn_bezier_clear(g.w.ctx, &band[i]);
    grid_clear(&g);
}

static void without_memory(void **state)
{
    (void)state;
    world w;
    world_make(&w, "memory.mesh");
    world_without_memory(&w, kn_mfem_sink, 6, 2);
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_and_volumes), cmocka_unit_test(on_their_own), cmocka_unit_test(refusals),
        cmocka_unit_test(refused_tiles),        cmocka_unit_test(twisted),      cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("write/mfem", tests, NULL, NULL);
}
