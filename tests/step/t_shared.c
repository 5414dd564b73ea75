// SPDX-License-Identifier: Apache-2.0
// Trimmed patches whose edges are told: what is shared, what is a solid, voids; and what contradicts itself. Cushions of
// two squares, one on the other, are bodies that close. The same of IGES.
#include "tests/support/patches.h"

#include <knurl/iges.h>
#include <knurl/step.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATCHES = 4, SIDES = 4 };

static const double corner[SIDES + 1][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_tile tile;
    kn_patch patch[PATCHES];
    size_t npatches;
    kn_spline curve[PATCHES][SIDES], side[SIDES], plane[PATCHES][SIDES];
    kn_patch_edge edge[PATCHES][SIDES];
    kn_patch_bounds bounds[PATCHES];
    double point[PATCHES][SIDES][3];
    int loop_end;
    kn_trim trim;
    bool iges;
    char path[TEST_PATH_BYTES];
} world;

static void make_line(kn_ctx *ctx, kn_spline *out, int comps, const double *from, const double *to)
{
    const double knots[4] = {0, 0, 2, 2}, *all = knots;
    double coef[6];
    for (int c = 0; c < comps; c++) coef[2 * c] = from[c], coef[2 * c + 1] = to[c];
    assert_int_equal(kn_spline_init(ctx, out, 1, comps, false, (int[]){1}, (int[]){2}, &all, coef), KN_OK);
}

// Square i at height z; cushion i / 2 has edges and vertices 4 (i / 2) + k. Every other curve runs against the loop.
static void make_square(world *w, int i, double z)
{
    kn_bezier *b = &w->patch[i].bezier;
    assert_int_equal(kn_bezier_init(w->ctx, b, 2, 3, false, (int[]){1, 1}), KN_OK);
    for (int k = 0; k < 4; k++) b->coef[k] = k / 2, b->coef[4 + k] = k % 2, b->coef[8 + k] = z;
    w->patch[i].exact = true, w->patch[i].reversed = i % 2, w->patch[i].trim = &w->trim;
    w->patch[i].bounds = &w->bounds[i];
    w->bounds[i] = (kn_patch_bounds){.edges = w->edge[i], .shell = i / 2};
    for (int k = 0; k < SIDES; k++)
        memcpy(w->point[i][k], (double[]){corner[k][0], corner[k][1], z}, 3 * sizeof(double));
    for (int k = 0; k < SIDES; k++) {
        bool against = k % 2 == 1;
        int from = against ? (k + 1) % SIDES : k, to = against ? k : (k + 1) % SIDES;
        make_line(w->ctx, &w->curve[i][k], 3, w->point[i][from], w->point[i][to]);
        make_line(w->ctx, &w->plane[i][k], 2, corner[from], corner[to]);
        w->edge[i][k] = (kn_patch_edge){.number = UINT64_MAX - (uint64_t)(4 * (i / 2) + k),
                                        .curve = &w->curve[i][k],
                                        .plane = &w->plane[i][k],
                                        .against = against,
                                        .vertex = {(uint64_t)(4 * (i / 2) + from), (uint64_t)(4 * (i / 2) + to)},
                                        .point = {w->point[i][from], w->point[i][to]}};
    }
}

static void begin(world *w)
{
    *w = (world){.memory = TEST_MEMORY_INIT, .npatches = 2, .loop_end = SIDES};
    w->ctx = test_ctx(&w->memory, 1);
    test_tile_make(&w->tile, 1);
    for (int k = 0; k < SIDES; k++) make_line(w->ctx, &w->side[k], 2, corner[k], corner[k + 1]);
    w->trim = (kn_trim){w->side, SIDES, &w->loop_end, 1};
    for (int i = 0; i < PATCHES; i++) make_square(w, i, i / 2);
    test_tmp_path(w->path, "cushions");
}

static void end(world *w)
{
    for (int i = 0; i < PATCHES; i++) {
        kn_bezier_clear(w->ctx, &w->patch[i].bezier);
        for (int k = 0; k < SIDES; k++)
            kn_spline_clear(w->ctx, &w->curve[i][k]), kn_spline_clear(w->ctx, &w->plane[i][k]);
    }
    for (int k = 0; k < SIDES; k++) kn_spline_clear(w->ctx, &w->side[k]);
    remove(w->path);
    test_ctx_end(w->ctx, &w->memory);
}

static kn_status feed_sink(kn_ctx *ctx, void *user)
{
    world *w = user;
    kn_sink sink = {0};
    kn_job_report report = test_report(w->npatches, 1, 1);
    report.trim_curves = SIDES, report.trim_spans = SIDES;
    kn_status status = w->iges ? kn_iges_sink(ctx, &sink, w->path, NULL) : kn_step_sink(ctx, &sink, w->path, NULL);
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &w->tile.tile, &report, w->patch, w->npatches, 3);
    kn_sink_close(ctx, &sink);
    return status;
}

static int count(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = strstr(text, word); at; at = strstr(at + 1, word)) n++;
    return n;
}

static void expect_step(world *w, int edges, int vertices, int solids, int voids, int open)
{
    assert_int_equal(feed_sink(w->ctx, w), KN_OK);
    char *text = test_read_file(w->path, NULL);
    assert_non_null(text);
    assert_int_equal(count(text, "=EDGE_CURVE("), edges);
    assert_int_equal(count(text, "=VERTEX_POINT("), vertices);
    assert_int_equal(count(text, "=PCURVE("), SIDES * (int)w->npatches);
    assert_int_equal(count(text, "=MANIFOLD_SOLID_BREP("), solids);
    assert_int_equal(count(text, "=BREP_WITH_VOIDS("), voids);
    assert_int_equal(count(text, "=ORIENTED_CLOSED_SHELL("), voids);
    assert_int_equal(count(text, "=OPEN_SHELL("), open);
    assert_int_equal(count(text, "=ADVANCED_FACE("), w->npatches);
    free(text);
}

static void bodies(void **state)
{
    (void)state;
    world w;
    begin(&w);
    expect_step(&w, 4, 4, 1, 0, 0);
    w.npatches = 4;
    expect_step(&w, 8, 8, 0, 1, 0); // the second one is a void of the first
    w.bounds[2].body = w.bounds[3].body = 1, w.bounds[2].shell = w.bounds[3].shell = 0;
    expect_step(&w, 8, 8, 2, 0, 0);
    w.bounds[0].shell = w.bounds[1].shell = 3; // a void of nothing
    expect_step(&w, 8, 8, 1, 0, 1);
    w.bounds[0].body = w.bounds[1].body = -1;
    expect_step(&w, 8, 8, 2, 0, 0);
    w.patch[1].reversed = false; // looks out where its neighbour looks in
    expect_step(&w, 8, 8, 1, 0, 1);
    end(&w);
}

static void what_does_not_fit(void **state)
{
    (void)state;
    world w;
    begin(&w);
    w.npatches = 3; // all edges a third time: they are open
    memcpy(w.edge[2], w.edge[1], sizeof w.edge[2]);
    w.bounds[2].body = -1;
    expect_step(&w, 8, 8, 1, 0, 1);
    w.npatches = 2;
    double was = w.curve[1][2].coef[5];
    w.curve[1][2].coef[5] = 0.5; // another curve of the same number
    expect_step(&w, 5, 4, 0, 0, 1);
    w.curve[1][2].coef[5] = was;
    w.edge[1][0].number = 77; // the same curve of another number
    expect_step(&w, 5, 4, 0, 0, 1);
    w.edge[1][0].number = w.edge[0][0].number;
    w.edge[1][1].vertex[0] = 99; // edges that do not meet: nothing of the face is shared
    expect_step(&w, 8, 8, 0, 0, 2);
    for (int k = 0; k < SIDES; k++) { // other vertices all along
        w.edge[1][k].vertex[0] = w.edge[0][k].vertex[0] + 10, w.edge[1][k].vertex[1] = w.edge[0][k].vertex[1] + 10;
    }
    expect_step(&w, 8, 8, 0, 0, 2);
    w.edge[1][3].curve = NULL; // one that is not told
    expect_step(&w, 8, 8, 0, 0, 2);
    w.plane[1][0].coef[0] = 0.25;
    kn_ctx_clear_error(w.ctx);
    assert_int_equal(feed_sink(w.ctx, &w), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(w.ctx), "does not fit curve 0 of its trim"));
    w.plane[1][0].coef[0] = 0.0, w.plane[1][0].knots[0][0] = w.plane[1][0].knots[0][1] = 1.0;
    assert_int_equal(feed_sink(w.ctx, &w), KN_EDOMAIN);
    w.plane[1][0].knots[0][0] = w.plane[1][0].knots[0][1] = 0.0;
    w.edge[1][0].plane = NULL;
    assert_int_equal(feed_sink(w.ctx, &w), KN_EDOMAIN);
    w.edge[1][0].plane = &w.plane[1][0], w.edge[1][0].against = true;
    expect_step(&w, 8, 8, 0, 0, 2); // its edges do not meet
    w.edge[1][0].against = false, w.curve[1][0].coef[0] = NAN;
    assert_int_equal(feed_sink(w.ctx, &w), KN_EUNDEFINED);
    end(&w);
}

// Lines of the directory: two for each entity.
static int entities(const char *text, const char *type)
{
    int n = 0;
    for (const char *line = text; *line; line += 81) n += line[72] == 'D' && strncmp(line, type, 8) == 0;
    return n / 2;
}

static void in_iges(void **state)
{
    (void)state;
    world w;
    begin(&w);
    w.iges = true, w.npatches = 4;
    assert_int_equal(feed_sink(w.ctx, &w), KN_OK);
    char *text = test_read_file(w.path, NULL);
    assert_non_null(text);
    assert_int_equal(entities(text, "     186"), 1), assert_int_equal(entities(text, "     514"), 2);
    assert_int_equal(entities(text, "     510"), 4), assert_int_equal(entities(text, "     504"), 8);
    assert_int_equal(entities(text, "     502"), 8), assert_int_equal(entities(text, "     126"), 8 + 16);
    free(text);
    w.plane[2][1].coef[1] = 0.5;
    assert_int_equal(feed_sink(w.ctx, &w), KN_EDOMAIN);
    end(&w);
}

static void without_memory(void **state)
{
    (void)state;
    world w;
    begin(&w);
    w.npatches = 4;
    for (int i = 0; i < 2; i++) {
        w.iges = i == 1;
        test_allocation_failures(feed_sink, &w);
    }
    end(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies),
        cmocka_unit_test(what_does_not_fit),
        cmocka_unit_test(in_iges),
        cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("step/shared", tests, NULL, NULL);
}
