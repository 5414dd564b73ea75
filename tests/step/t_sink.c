// SPDX-License-Identifier: Apache-2.0
// The text of STEP files: structure, numbers, strings, limits, equal bytes for any number of threads.
// What another CAD system makes of them: tests/bridges/t_occt_step.c.
#include "tests/support/patches.h"
#include <knurl/step.h>

#include "io/text_buffer.h"
#include "kernel/parallel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATCHES = 12 };

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_tile tile;
    kn_patch patch[PATCHES];
    char path[TEST_PATH_BYTES];
} world;

static void world_make(world *w, int threads)
{
    *w = (world){.memory = TEST_MEMORY_INIT};
    w->ctx = test_ctx(&w->memory, threads);
    test_rng rng = test_random(8);
    test_tile_make(&w->tile, 2);
    for (int i = 0; i < PATCHES; i++) {
        test_patch(w->ctx, &w->patch[i], &rng, 1 + i % 4, 3, i % 5 == 4, i, 0.1);
        w->patch[i].id = (kn_patch_id){.cell = {i, 2}, .part = i % 3 == 1, .patch = i};
        w->patch[i].look = i % 3 == 1;
    }
    test_tmp_path(w->path, "out.step");
}

static void world_clear(world *w)
{
    for (int i = 0; i < PATCHES; i++) kn_bezier_clear(w->ctx, &w->patch[i].bezier);
    remove(w->path);
    test_ctx_end(w->ctx, &w->memory);
}

static char *write_step(world *w, const kn_step_options *options, size_t block)
{
    kn_sink sink;
    kn_job_report report = test_report(PATCHES, 4, 3);
    assert_int_equal(kn_step_sink(w->ctx, &sink, w->path, options), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, &report, w->patch, PATCHES, block), KN_OK);
    size_t bytes = 0;
    char *text = test_read_file(w->path, &bytes);
    assert_non_null(text);
    assert_int_equal(sink.bytes(sink.user), bytes);
    kn_sink_close(w->ctx, &sink);
    return text;
}

static int count(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = strstr(text, word); at != NULL; at = strstr(at + 1, word)) n++;
    return n;
}

static int compare(const void *a, const void *b)
{
    long x = *(const long *)a, y = *(const long *)b;
    return (x > y) - (x < y);
}

// Every number is defined once, and every number that is referred to is defined.
static void expect_consistent(const char *text)
{
    int n = 0, room = count(text, "\n#");

    long *defined = calloc((size_t)room + 1, sizeof *defined);
    assert_non_null(defined);
    for (const char *at = strstr(text, "\n#"); at != NULL; at = strstr(at + 1, "\n#")) {
        char *end;
        long id = strtol(at + 2, &end, 10);
        if (*end == '=') defined[n++] = id; // else a wrapped line that begins with a reference
    }
    qsort(defined, (size_t)n, sizeof *defined, compare);
    for (int i = 1; i < n; i++) assert_true(defined[i] > defined[i - 1]);
    for (const char *at = strchr(text, '#'); at != NULL; at = strchr(at + 1, '#')) {
        long id = strtol(at + 1, NULL, 10);
        assert_non_null(bsearch(&id, defined, (size_t)n, sizeof *defined, compare));
    }
    free(defined);
}

static void structure(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    kn_step_options options = {.product = "A 'pot'", .uncertainty_mm = 0.02, .time_stamp = "2026-01-02T03:04:05"};
    char *text = write_step(&w, &options, 5);
    assert_ptr_equal(strstr(text, "ISO-10303-21;\nHEADER;\n"), text);
    assert_non_null(strstr(text, "FILE_NAME('A ''pot''','2026-01-02T03:04:05',"));
    assert_non_null(strstr(text, "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"));
    assert_string_equal(text + strlen(text) - strlen("\nENDSEC;\nEND-ISO-10303-21;\n"),
                        "\nENDSEC;\nEND-ISO-10303-21;\n");
    assert_non_null(strstr(text, "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.02),#11,"));
    assert_non_null(strstr(text, "SI_UNIT(.MILLI.,.METRE.)"));
    assert_int_equal(count(text, "=ADVANCED_FACE("), PATCHES);
    assert_int_equal(count(text, "=OPEN_SHELL("), PATCHES); // nobody meets anybody
    assert_int_equal(count(text, "=SHELL_BASED_SURFACE_MODEL("), 2);
    assert_int_equal(count(text, "=STYLED_ITEM("), 2);
    assert_int_equal(count(text, "=COLOUR_RGB("), 2);
    assert_int_equal(count(text, "RATIONAL_B_SPLINE_SURFACE("), 2); // patches 4 and 9
    assert_int_equal(count(text, "=EDGE_CURVE("), 4 * PATCHES);
    assert_int_equal(count(text, "'s0 c7,2 wire rod 7'"), 1);
    for (const char *at = text, *end; (end = strchr(at, '\n')) != NULL; at = end + 1) assert_true(end - at <= 220);
    expect_consistent(text);
    free(text);
    world_clear(&w);
}

// Corner k of a cube, bit by bit; faces counterclockwise from outside, in the order of a patch's (0,0), (0,1), (1,0), (1,1)
// with t first: r x t points out.
static const int cube[6][4] = {{0, 4, 2, 6}, {1, 3, 5, 7}, {0, 1, 4, 5}, {2, 6, 3, 7}, {0, 2, 1, 3}, {4, 5, 6, 7}};

// A cube in two looks: twelve edges, eight vertices, one solid, whose faces have colours of their own; without its lid
// a shell; with a face that looks inwards no solid either.
static void bodies(void **state)
{
    (void)state;
    for (int lack = 0; lack < 3; lack++) {
        world w;
        world_make(&w, 1);
        kn_sink sink;
        kn_job_report report = test_report(6, 1, 1);
        for (int f = 0; f < 6; f++) {
            kn_bezier *b = &w.patch[f].bezier;
            kn_bezier_clear(w.ctx, b);
            assert_int_equal(kn_bezier_init(w.ctx, b, 2, 3, false, (int[]){1, 1}), KN_OK);
            for (int k = 0; k < 4; k++)
                for (int c = 0; c < 3; c++) b->coef[4 * c + k] = (cube[f][k] >> c & 1) ? 10.0 : 0.0;
            w.patch[f].look = w.patch[f].id.part = f == 5;
            w.patch[f].reversed = lack == 2 && f == 3;
        }
        assert_int_equal(kn_step_sink(w.ctx, &sink, w.path, NULL), KN_OK);
        assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &report, w.patch, lack == 1 ? 5 : 6, 2), KN_OK);
        kn_sink_close(w.ctx, &sink);
        char *text = test_read_file(w.path, NULL);
        assert_non_null(text);
        expect_consistent(text);
        assert_int_equal(count(text, "=EDGE_CURVE("), 12);
        assert_int_equal(count(text, "=VERTEX_POINT("), 8);
        assert_int_equal(count(text, "=ORIENTED_EDGE("), lack == 1 ? 20 : 24);
        assert_int_equal(count(text, "=MANIFOLD_SOLID_BREP("), lack == 0);
        assert_int_equal(count(text, "=CLOSED_SHELL("), lack == 0);
        assert_int_equal(count(text, "=OPEN_SHELL("), lack != 0);
        assert_int_equal(count(text, "=STYLED_ITEM("), lack == 1 ? 1 : 6);
        assert_int_equal(count(text, "=ADVANCED_BREP_SHAPE_REPRESENTATION("), lack == 0);
        free(text);
        world_clear(&w);
    }
}

static void no_patches(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    kn_sink sink;
    kn_job_report report = test_report(0, 1, 1);
    assert_int_equal(kn_step_sink(w.ctx, &sink, w.path, NULL), KN_OK);
    assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &report, NULL, 0, 1), KN_OK);
    kn_sink_close(w.ctx, &sink);
    char *text = test_read_file(w.path, NULL);
    assert_non_null(text);
    expect_consistent(text);
    assert_int_equal(count(text, "OPEN_SHELL"), 0);
    free(text);
    world_clear(&w);
}

// ---- threads: the pipeline that jobs use ----
typedef struct feed {
    const kn_sink *sink;
    const kn_patch *patches;
} feed;

static kn_status pipe_work(kn_ctx *worker, void *user, size_t index, void **product)
{
    feed *f = user;
    kn_patch_block block = {index, 1, f->patches + index};
    return f->sink->work(worker, f->sink->user, &block, product);
}

static kn_status pipe_commit(kn_ctx *ctx, void *user, size_t index, void *product)
{
    feed *f = user;
    kn_patch_block block = {index, 1, f->patches + index};
    return f->sink->commit(ctx, f->sink->user, &block, product);
}

static void pipe_drop(kn_ctx *ctx, void *user, void *product)
{
    feed *f = user;
    f->sink->discard(ctx, f->sink->user, product);
}

static void equal_bytes(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    char *once = write_step(&w, NULL, PATCHES), *in_blocks = write_step(&w, NULL, 5);
    assert_string_equal(once, in_blocks);
    free(in_blocks);
    world_clear(&w);
    for (int threads = 1; threads <= 5; threads += 2) {
        world_make(&w, threads);
        kn_sink sink;
        kn_job_report report = test_report(PATCHES, 4, 3);
        assert_int_equal(kn_step_sink(w.ctx, &sink, w.path, NULL), KN_OK);
        assert_int_equal(sink.begin(w.ctx, sink.user, &w.tile.tile, &report), KN_OK);
        feed f = {&sink, w.patch};
        kn_pipeline pipeline = {&f, pipe_work, pipe_commit, pipe_drop};
        assert_int_equal(kn_pipeline_run(w.ctx, &pipeline, PATCHES, 4, NULL), KN_OK);
        assert_int_equal(sink.end(w.ctx, sink.user), KN_OK);
        kn_sink_close(w.ctx, &sink);
        char *text = test_read_file(w.path, NULL);
        assert_non_null(text);
        assert_string_equal(text, once);
        free(text);
        world_clear(&w);
    }
    free(once);
}

static void expect_refused(world *w, const kn_job_report *report, const kn_patch *patch, kn_status expected)
{
    kn_sink sink;
    assert_int_equal(kn_step_sink(w->ctx, &sink, w->path, NULL), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, report, patch, 1, 1), expected);
    assert_int_equal(kn_ctx_error(w->ctx), expected);
    kn_ctx_clear_error(w->ctx);
    kn_sink_close(w->ctx, &sink);
    assert_null(test_read_file(w->path, NULL)); // nothing under that name
}

static void refusals(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    kn_sink sink;
    kn_job_report report = test_report(1, 4, 3), small = test_report(1, 3, 3), none = test_report(0, 4, 3);
    kn_patch *patch = &w.patch[3];
    expect_refused(&w, &small, patch, KN_EDOMAIN); // degree 4 where 3 was announced
    expect_refused(&w, &none, patch, KN_EDOMAIN);
    patch->look = 2;
    expect_refused(&w, &report, patch, KN_EDOMAIN);
    patch->look = 0;
    double good = patch->bezier.coef[5];
    patch->bezier.coef[5] = NAN;
    expect_refused(&w, &report, patch, KN_EUNDEFINED);
    patch->bezier.coef[5] = -INFINITY;
    expect_refused(&w, &report, patch, KN_EUNDEFINED);
    patch->bezier.coef[5] = good;
    kn_bezier *rational = &w.patch[4].bezier;
    rational->coef[3 * kn_bezier_count(rational)] = 0.0;
    expect_refused(&w, &report, &w.patch[4], KN_EUNDEFINED);
    kn_job_report huge = test_report((size_t)1 << 40, 25, 25); // more numbers than 31 bits
    expect_refused(&w, &huge, patch, KN_ELIMIT);

    assert_int_equal(kn_step_sink(w.ctx, &sink, "/nowhere/x.step", NULL), KN_EIO);
    kn_ctx_clear_error(w.ctx);
    kn_step_options options = {.unit_mm = -1.0};
    assert_int_equal(kn_step_sink(w.ctx, &sink, w.path, &options), KN_EDOMAIN);
    kn_ctx_clear_error(w.ctx);
    options = (kn_step_options){.uncertainty_mm = NAN};
    assert_int_equal(kn_step_sink(w.ctx, &sink, w.path, &options), KN_EDOMAIN);
    world_clear(&w);
}

static void strings(void **state)
{
    (void)state;
    static const struct {
        const char *in, *out;
    } cases[] = {
        {"", "''"},
        {"plain ~", "'plain ~'"},
        {"it's", "'it''s'"},
        {"a\\b", "'a\\\\b'"},
        {"tab\there", "'tab\\X\\09here'"},
        {"\xc3\xa9", "'\\X\\E9'"},
        {"\xe2\x82\xac", "'\\X2\\20AC\\X0\\'"},
        {"\xf0\x9f\xab\x96", "'\\X4\\0001FAD6\\X0\\'"},
        {"\xe9t\xe9", "'\\X\\E9t\\X\\E9'"}, // Latin-1 by mistake
        {"cut \xe2\x82", "'cut \\X\\E2\\X\\82'"},
        {"\xff", "'\\X\\FF'"},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        kn_text text = {.ctx = ctx};
        kn_text_step_string(&text, cases[i].in);
        kn_text_char(&text, '\0');
        assert_string_equal(text.data, cases[i].out);
        kn_text_clear(&text);
    }
    test_ctx_end(ctx, &memory);
}

// Patches are made of memory that does not fail; the sink's does.
static kn_status feed_sink(kn_ctx *ctx, void *user)
{
    world *w = user;
    kn_sink sink;
    kn_job_report report = test_report(PATCHES, 4, 3);
    kn_status status = kn_step_sink(ctx, &sink, w->path, NULL);
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &w->tile.tile, &report, w->patch, PATCHES, 4);
    kn_sink_close(ctx, &sink);
    if (status != KN_OK) assert_null(test_read_file(w->path, NULL));
    return status;
}

static void without_memory(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    test_allocation_failures(feed_sink, &w);
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(structure),      cmocka_unit_test(bodies),   cmocka_unit_test(no_patches),
        cmocka_unit_test(equal_bytes),    cmocka_unit_test(refusals), cmocka_unit_test(strings),
        cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("step/sink", tests, NULL, NULL);
}
