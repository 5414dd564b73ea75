// SPDX-License-Identifier: Apache-2.0
// The text of IGES files: records, pointers and counts, bodies, limits, equal bytes for any number of threads.
// What another CAD system makes of them: tests/bridges/t_occt_iges.c.
#include "tests/support/patches.h"
#include <knurl/iges.h>

#include "kernel/parallel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATCHES = 12, LINE = 81 };

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_tile tile;
    kn_patch patch[PATCHES];
    kn_iges_options options;
    size_t exact; // of the patches, as the report has it
    char path[TEST_PATH_BYTES], parameters[TEST_PATH_BYTES];
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
    test_tmp_path(w->path, "out.igs");
    snprintf(w->parameters, sizeof w->parameters, "%.480s.parameters.tmp-0", w->path);
}

static void world_clear(world *w)
{
    for (int i = 0; i < PATCHES; i++) kn_bezier_clear(w->ctx, &w->patch[i].bezier);
    remove(w->path);
    test_ctx_end(w->ctx, &w->memory);
}

static char *write_iges(world *w, const kn_iges_options *options, size_t n, size_t block)
{
    kn_sink sink;
    kn_job_report report = test_report(PATCHES, 4, 3);
    report.exact_patches = w->exact;
    assert_int_equal(kn_iges_sink(w->ctx, &sink, w->path, options), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, &report, w->patch, n, block), KN_OK);
    size_t bytes = 0;
    char *text = test_read_file(w->path, &bytes);
    assert_non_null(text);
    assert_int_equal(sink.bytes(sink.user), bytes);
    kn_sink_close(w->ctx, &sink);
    assert_null(test_read_file(w->parameters, NULL)); // not left there
    return text;
}

static long field(const char *line, int at, int width)
{
    char digits[16] = {0};
    memcpy(digits, line + at, (size_t)width);
    return strtol(digits, NULL, 10);
}

// How many entities there are of each type, and whether all numbers fit: records of 80 columns, sections in order and
// counted, directory entries and their parameter lines refer to each other, pointers below zero are colours.
typedef struct counts {
    int of[600];
    long directory, parameters;
} counts;

static counts expect_consistent(const char *text)
{
    counts n = {0};
    size_t length = strlen(text), lines = length / LINE;
    static const char order[] = "SGDPT";
    long section[5] = {0};
    int at = 0;
    assert_int_equal(length % LINE, 0);
    for (size_t i = 0; i < lines; i++) {
        const char *line = text + LINE * i;
        assert_int_equal(line[80], '\n');
        for (int k = 0; k < 80; k++) assert_true(line[k] >= 32 && line[k] < 127);
        while (line[72] != order[at]) assert_true(++at < 5);
        assert_int_equal(field(line, 73, 7), ++section[at]);
    }
    const char *directory = text + LINE * (section[0] + section[1]), *parameters = directory + LINE * section[2];
    const char *last = text + LINE * (lines - 1);
    for (int s = 0; s < 4; s++) assert_int_equal(field(last, 8 * s + 1, 7), section[s]);
    long next = 1;
    for (long e = 0; e < section[2]; e += 2) {
        const char *one = directory + LINE * e, *two = one + LINE;
        long type = field(one, 0, 8), first = field(one, 8, 8), count = field(two, 24, 8), colour = field(two, 16, 8);
        assert_int_equal(field(two, 0, 8), type);
        assert_int_equal(first, next); // in order and without gaps
        next += count;
        n.of[type]++;
        for (long k = first; k < next; k++) assert_int_equal(field(parameters + LINE * (k - 1), 65, 7), e + 1);
        assert_int_equal(field(parameters + LINE * (first - 1), 0, 3), type);
        if (colour < 0) assert_int_equal(field(directory + LINE * (-colour - 1), 0, 8), 314);
        assert_true(colour <= 0);
    }
    assert_int_equal(next - 1, section[3]);
    n.directory = section[2], n.parameters = section[3];
    return n;
}

static void structure(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    kn_iges_options options = {.product = "A \xc3\xa9", .uncertainty_mm = 0.02, .time_stamp = "2026-01-02T03:04:05"};
    char *text = write_iges(&w, &options, PATCHES, 5);
    counts n = expect_consistent(text);
    assert_non_null(strstr(text, "1H,,1H;,3HA _,3HA _,5Hknurl,"));
    assert_non_null(strstr(text, "1.,2,2HMM,1,0.,15H20260102.030405,0.02,")); // 0.02 mm, in millimetres
    assert_int_equal(n.of[128], PATCHES);
    assert_int_equal(n.of[510], PATCHES);
    assert_int_equal(n.of[514], PATCHES); // nobody meets anybody
    assert_int_equal(n.of[504], 4 * PATCHES);
    assert_int_equal(n.of[126], 4 * PATCHES);
    assert_int_equal(n.of[502], 4 * PATCHES);
    assert_int_equal(n.of[406], PATCHES);
    assert_int_equal(n.of[314], 2);
    assert_int_equal(n.of[186], 0);
    assert_non_null(strstr(text, "406,1,18Hs0 c7,2 wire rod 7;"));
    free(text);
    options = (kn_iges_options){.surfaces = true};
    text = write_iges(&w, &options, PATCHES, 5);
    n = expect_consistent(text);
    assert_int_equal(n.directory, 2 * (2 * PATCHES + 2)); // surfaces, names, two colours
    assert_int_equal(n.of[128], PATCHES);
    free(text);
    text = write_iges(&w, NULL, 0, 1);
    n = expect_consistent(text);
    assert_int_equal(n.directory, 0);
    free(text);
    world_clear(&w);
}

// Faces by the names of their surfaces, with what is approximated marked; without a name there is no entity for it.
static void names(void **state)
{
    (void)state;
    world w;
    static const char *const surfaces[2] = {"caf\xc3\xa9", ""};
    kn_iges_options options = {.surface_names = surfaces, .nsurfaces = 2};
    world_make(&w, 1);
    w.patch[5].id.surface = 1, w.patch[6].id.surface = 2;
    w.patch[7].id.piece = 3, w.patch[7].exact = false;
    w.exact = PATCHES - 1;
    for (int k = 0; k < 2; k++) {
        options.surfaces = k == 1;
        options.plain_names = false;
        char *text = write_iges(&w, &options, PATCHES, 5);
        assert_int_equal(expect_consistent(text).of[406], PATCHES);
        assert_non_null(strstr(text, "Hcaf_ c4,2 wire rod 4;"));
        assert_non_null(strstr(text, "Hs1 c5,2 link 5;"));
        assert_non_null(strstr(text, "Hs2 c6,2 link 6;"));
        assert_non_null(strstr(text, "Hcaf_ c7,2 wire rod 7.3 ~;"));
        free(text);
        options.plain_names = true;
        text = write_iges(&w, &options, PATCHES, 5);
        assert_int_equal(expect_consistent(text).of[406], PATCHES - 2);
        assert_non_null(strstr(text, "406,1,4Hcaf_;"));
        assert_non_null(strstr(text, "406,1,6Hcaf_ ~;"));
        free(text);
    }
    world_clear(&w);
}

// The numbers of a surface, read back, are those of the patch: the first variable fastest.
static void numbers(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    char *text = write_iges(&w, &(kn_iges_options){.surfaces = true}, 1, 1);
    const kn_bezier *b = &w.patch[0].bezier; // degrees 1 and 3
    b->coef[0] = 1e-30, b->coef[1] = -12345678901234567890.0;
    free(text);
    text = write_iges(&w, &(kn_iges_options){.surfaces = true}, 1, 1);
    const char *at = strstr(text, "128,1,3,1,3,0,0,1,0,0,0.,0.,1.,1.,0.,0.,0.,0.,1.,1.,1.,1.,");
    assert_non_null(at);
    assert_non_null(strstr(text, "1.D-30"));
    assert_non_null(strstr(text, "-1.2345678901234567D19"));
    double found[12 + 8 + 24 + 4];
    char flat[4096] = {0};
    size_t n = 0;
    for (; at[72] == 'P' || n == 0; at += LINE) { // the parameters of all lines, one after the other
        memcpy(flat + n, at, 64);
        n += 64;
        if (memchr(at, ';', 64)) break;
    }
    char *s = strstr(flat, ",0,0,0.,") + 5;
    for (int k = 0; k < 48; k++) {
        char *end = s + strcspn(s, ",;");
        for (char *c = s; c < end; c++)
            if (*c == 'D') *c = 'E';
        found[k] = strtod(s, NULL);
        s = end + 1;
    }
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 4; j++)
            for (int c = 0; c < 3; c++)
                assert_true(found[12 + 8 + 3 * (2 * j + i) + c] == b->coef[8 * c + 4 * i + j]);
    free(text);
    world_clear(&w);
}

// Corner k of a cube, bit by bit: r x t points out.
static const int cube[6][4] = {{0, 1, 2, 3}, {4, 6, 5, 7}, {0, 4, 1, 5}, {2, 3, 6, 7}, {0, 2, 4, 6}, {1, 5, 3, 7}};

// A cube in two looks: twelve edges, eight vertices, one solid; without its lid a shell; with a face that looks
// inwards no solid either.
static void bodies(void **state)
{
    (void)state;
    for (int lack = 0; lack < 3; lack++) {
        world w;
        world_make(&w, 1);
        for (int f = 0; f < 6; f++) {
            kn_bezier *b = &w.patch[f].bezier;
            kn_bezier_clear(w.ctx, b);
            assert_int_equal(kn_bezier_init(w.ctx, b, 2, 3, false, (int[]){1, 1}), KN_OK);
            for (int k = 0; k < 4; k++)
                for (int c = 0; c < 3; c++) b->coef[4 * c + k] = (cube[f][k] >> c & 1) ? 10.0 : 0.0;
            w.patch[f].look = w.patch[f].id.part = f == 5;
            w.patch[f].reversed = lack == 2 && f == 3;
        }
        char *text = write_iges(&w, NULL, lack == 1 ? 5 : 6, 2);
        counts n = expect_consistent(text);
        assert_int_equal(n.of[504], 12);
        assert_int_equal(n.of[126], 12);
        assert_int_equal(n.of[502], 8);
        assert_int_equal(n.of[508], lack == 1 ? 5 : 6);
        assert_int_equal(n.of[186], lack == 0);
        assert_int_equal(n.of[514], 1);
        free(text);
        world_clear(&w);
    }
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
    char *once = write_iges(&w, NULL, PATCHES, PATCHES), *in_blocks = write_iges(&w, NULL, PATCHES, 5);
    assert_string_equal(once, in_blocks);
    free(in_blocks);
    world_clear(&w);
    for (int threads = 1; threads <= 5; threads += 2) {
        world_make(&w, threads);
        kn_sink sink;
        kn_job_report report = test_report(PATCHES, 4, 3);
        assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, NULL), KN_OK);
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

// Saved after some patches, closed, and gone on with by another sink: the same bytes.
static void gone_on_with(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    char *once = write_iges(&w, NULL, PATCHES, PATCHES);
    kn_job_report report = test_report(PATCHES, 4, 3);
    for (size_t done = 0; done < PATCHES; done += 5) {
        kn_sink sink;
        void *product = NULL;
        unsigned char *saved = NULL;
        size_t bytes = 0;
        assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, NULL), KN_OK);
        assert_int_equal(sink.begin(w.ctx, sink.user, &w.tile.tile, &report), KN_OK);
        kn_patch_block block = {0, done, w.patch}, rest = {done, PATCHES - done, w.patch + done};
        assert_int_equal(sink.work(w.ctx, sink.user, &block, &product), KN_OK);
        assert_int_equal(sink.commit(w.ctx, sink.user, &block, product), KN_OK);
        assert_int_equal(sink.save(w.ctx, sink.user, &saved, &bytes), KN_OK);
        kn_sink_close(w.ctx, &sink);
        assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, NULL), KN_OK);
        assert_int_equal(sink.restore(w.ctx, sink.user, &w.tile.tile, &report, saved, bytes), KN_OK);
        assert_int_equal(sink.work(w.ctx, sink.user, &rest, &product), KN_OK);
        assert_int_equal(sink.commit(w.ctx, sink.user, &rest, product), KN_OK);
        assert_int_equal(sink.end(w.ctx, sink.user), KN_OK);
        kn_sink_close(w.ctx, &sink);
        char *text = test_read_file(w.path, NULL);
        assert_non_null(text);
        assert_string_equal(text, once);
        assert_null(test_read_file(w.parameters, NULL));
        assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, NULL), KN_OK); // half a state, and nothing to go on with
        assert_int_not_equal(sink.restore(w.ctx, sink.user, &w.tile.tile, &report, saved, bytes / 2), KN_OK);
        kn_ctx_clear_error(w.ctx);
        kn_sink_close(w.ctx, &sink);
        kn_free(w.ctx, saved);
        free(text);
    }
    free(once);
    world_clear(&w);
}

static void expect_refused(world *w, const kn_job_report *report, const kn_patch *patch, kn_status expected)
{
    kn_sink sink;
    assert_int_equal(kn_iges_sink(w->ctx, &sink, w->path, NULL), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, report, patch, 1, 1), expected);
    assert_int_equal(kn_ctx_error(w->ctx), expected);
    kn_ctx_clear_error(w->ctx);
    kn_sink_close(w->ctx, &sink);
    assert_null(test_read_file(w->path, NULL)); // nothing under that name
    assert_null(test_read_file(w->parameters, NULL));
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
    patch->bezier.coef[5] = good;
    kn_bezier *rational = &w.patch[4].bezier;
    rational->coef[3 * kn_bezier_count(rational)] = 0.0;
    expect_refused(&w, &report, &w.patch[4], KN_EUNDEFINED);
    kn_job_report huge = test_report(3000000, 25, 25), meshes = report; // more lines than seven digits count
    expect_refused(&w, &huge, patch, KN_ELIMIT);
    meshes.meshes = 1;
    expect_refused(&w, &meshes, patch, KN_EDOMAIN);

    assert_int_equal(kn_iges_sink(w.ctx, &sink, "/nowhere/x.igs", NULL), KN_EIO);
    kn_ctx_clear_error(w.ctx);
    static const kn_iges_options bad[] = {{.unit_mm = -1.0},
                                          {.uncertainty_mm = NAN},
                                          {.time_stamp = "yesterday"},
                                          {.time_stamp = "2026-01-02T03:04"},
                                          {.nsurfaces = -1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, &bad[i]), KN_EDOMAIN);
        kn_ctx_clear_error(w.ctx);
    }
    char name[400];
    memset(name, 'x', sizeof name);
    name[399] = '\0';
    assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, &(kn_iges_options){.product = name}), KN_EDOMAIN);
    world_clear(&w);
}

// Beside what is no file there is no place for another one: it has no name then.
static void into_a_pipe(void **state)
{
    (void)state;
    world w;
    world_make(&w, 1);
    kn_sink sink;
    kn_job_report report = test_report(PATCHES, 4, 3);
    assert_int_equal(kn_iges_sink(w.ctx, &sink, "/dev/null", NULL), KN_OK);
    assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &report, w.patch, PATCHES, 4), KN_OK);
    kn_sink_close(w.ctx, &sink);
    world_clear(&w);
}

// Patches are made of memory that does not fail; the sink's does.
static kn_status feed_sink(kn_ctx *ctx, void *user)
{
    world *w = user;
    kn_sink sink;
    kn_job_report report = test_report(PATCHES, 4, 3);
    kn_status status = kn_iges_sink(ctx, &sink, w->path, &w->options);
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
    static const char *const called[2] = {"one", NULL};
    kn_bezier f = {0};
    kn_trim side[2] = {{0}}, whole = {0};
    kn_trim_cut_report report;
    world_make(&w, 1);
    w.options.surface_names = called, w.options.nsurfaces = 2;
    assert_int_equal(kn_bezier_init(w.ctx, &f, 2, 1, false, (int[]){1, 1}), KN_OK);
    f.coef[0] = -1.0, f.coef[1] = 0.5, f.coef[2] = 0.25, f.coef[3] = 1.0;
    assert_int_equal(kn_trim_cut(w.ctx, &side[0], &side[1], &report, &whole, &f, 1e-2), KN_OK);
    w.patch[2].trim = &side[0], w.patch[7].trim = &side[1];
    w.patch[7].reversed = true;
    for (int surfaces = 0; surfaces < 2; surfaces++) {
        w.options.surfaces = surfaces;
        test_allocation_failures(feed_sink, &w);
        char *text = write_iges(&w, &w.options, PATCHES, 4);
        counts n = expect_consistent(text);
        assert_int_equal(n.of[144], surfaces ? 2 : 0);
        assert_int_equal(n.of[142], surfaces ? 2 : 0);
        assert_int_equal(n.of[102], surfaces ? 4 : 0);
        assert_int_equal(n.of[510], surfaces ? 0 : PATCHES);
        free(text);
        remove(w.path);
    }
    kn_bezier_clear(w.ctx, &f);
    for (int i = 0; i < 2; i++) kn_trim_clear(w.ctx, &side[i]);
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(structure), cmocka_unit_test(names),       cmocka_unit_test(numbers),
        cmocka_unit_test(bodies),    cmocka_unit_test(equal_bytes), cmocka_unit_test(gone_on_with),
        cmocka_unit_test(refusals),  cmocka_unit_test(into_a_pipe), cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("iges/sink", tests, NULL, NULL);
}
