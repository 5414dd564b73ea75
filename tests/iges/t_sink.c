// SPDX-License-Identifier: Apache-2.0
// The text of IGES files: records, pointers and counts, bodies, limits, equal bytes for any number of threads.
// What another CAD system makes of them: tests/bridges/t_occt_iges.c.
#include "tests/support/sink_world.h"
#include <knurl/iges.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE = 81 };

static kn_status open_iges(kn_ctx *ctx, kn_sink *out, const char *path, const void *options)
{
    return kn_iges_sink(ctx, out, path, options);
}

static void world_make(sink_world *w)
{
    sink_world_make(w, open_iges, "out.igs", 1);
}

// The file that waits for the directory is not left there.
static void expect_nothing_beside(const sink_world *w)
{
    char parameters[TEST_PATH_BYTES];
    snprintf(parameters, sizeof parameters, "%.480s.parameters.tmp-0", w->path);
    assert_null(test_read_file(parameters, NULL));
}

static char *write_iges(sink_world *w, const kn_iges_options *options, size_t n, size_t block)
{
    char *text = sink_world_write(w, options, n, block);
    expect_nothing_beside(w);
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
    sink_world w;
    world_make(&w);
    kn_iges_options options = {.product = "A \xc3\xa9", .uncertainty_mm = 0.02, .time_stamp = "2026-01-02T03:04:05"};
    char *text = write_iges(&w, &options, SINK_PATCHES, 5);
    counts n = expect_consistent(text);
    assert_non_null(strstr(text, "1H,,1H;,3HA _,3HA _,5Hknurl,"));
    assert_non_null(strstr(text, "1.,2,2HMM,1,0.,15H20260102.030405,0.02,")); // 0.02 mm, in millimetres
    assert_int_equal(n.of[128], SINK_PATCHES);
    assert_int_equal(n.of[510], SINK_PATCHES);
    assert_int_equal(n.of[514], SINK_PATCHES); // nobody meets anybody
    assert_int_equal(n.of[504], 4 * SINK_PATCHES);
    assert_int_equal(n.of[126], 4 * SINK_PATCHES);
    assert_int_equal(n.of[502], 4 * SINK_PATCHES);
    assert_int_equal(n.of[406], SINK_PATCHES);
    assert_int_equal(n.of[314], 2);
    assert_int_equal(n.of[186], 0);
    assert_non_null(strstr(text, "406,1,18Hs0 c7,2 wire rod 7;"));
    free(text);
    options = (kn_iges_options){.surfaces = true};
    text = write_iges(&w, &options, SINK_PATCHES, 5);
    n = expect_consistent(text);
    assert_int_equal(n.directory, 2 * (2 * SINK_PATCHES + 2)); // surfaces, names, two colours
    assert_int_equal(n.of[128], SINK_PATCHES);
    free(text);
    text = write_iges(&w, NULL, 0, 1);
    n = expect_consistent(text);
    assert_int_equal(n.directory, 0);
    free(text);
    sink_world_clear(&w);
}

// Faces by the names of their surfaces, with what is approximated marked; without a name there is no entity for it.
static void names(void **state)
{
    (void)state;
    sink_world w;
    static const char *const surfaces[2] = {"caf\xc3\xa9", ""};
    kn_iges_options options = {.surface_names = surfaces, .nsurfaces = 2};
    world_make(&w);
    w.patch[5].id.surface = 1, w.patch[6].id.surface = 2;
    w.patch[7].id.piece = 3, w.patch[7].exact = false;
    w.report.exact_patches = SINK_PATCHES - 1;
    for (int k = 0; k < 2; k++) {
        options.surfaces = k == 1;
        options.plain_names = false;
        char *text = write_iges(&w, &options, SINK_PATCHES, 5);
        assert_int_equal(expect_consistent(text).of[406], SINK_PATCHES);
        assert_non_null(strstr(text, "Hcaf_ c4,2 wire rod 4;"));
        assert_non_null(strstr(text, "Hs1 c5,2 link 5;"));
        assert_non_null(strstr(text, "Hs2 c6,2 link 6;"));
        assert_non_null(strstr(text, "Hcaf_ c7,2 wire rod 7.3 ~;"));
        free(text);
        options.plain_names = true;
        text = write_iges(&w, &options, SINK_PATCHES, 5);
        assert_int_equal(expect_consistent(text).of[406], SINK_PATCHES - 2);
        assert_non_null(strstr(text, "406,1,4Hcaf_;"));
        assert_non_null(strstr(text, "406,1,6Hcaf_ ~;"));
        free(text);
    }
    sink_world_clear(&w);
}

// The numbers of a surface, read back, are those of the patch: the first variable fastest.
static void numbers(void **state)
{
    (void)state;
    sink_world w;
    world_make(&w);
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
    sink_world_clear(&w);
}

// A cube in two looks: twelve edges, eight vertices, one solid; without its lid a shell; with a face that looks
// inwards no solid either.
static void bodies(void **state)
{
    (void)state;
    for (int lack = 0; lack < 3; lack++) {
        sink_world w;
        world_make(&w);
        sink_world_cube(&w);
        w.patch[3].reversed = lack == 2;
        char *text = write_iges(&w, NULL, lack == 1 ? 5 : 6, 2);
        counts n = expect_consistent(text);
        assert_int_equal(n.of[504], 12);
        assert_int_equal(n.of[126], 12);
        assert_int_equal(n.of[502], 8);
        assert_int_equal(n.of[508], lack == 1 ? 5 : 6);
        assert_int_equal(n.of[186], lack == 0);
        assert_int_equal(n.of[514], 1);
        free(text);
        sink_world_clear(&w);
    }
}

static void equal_bytes(void **state)
{
    (void)state;
    sink_world_equal_bytes(open_iges, "out.igs");
}

// Saved after some patches, closed, and gone on with by another sink: the same bytes.
static void gone_on_with(void **state)
{
    (void)state;
    sink_world w;
    world_make(&w);
    char *once = write_iges(&w, NULL, SINK_PATCHES, SINK_PATCHES);
    for (size_t done = 0; done < SINK_PATCHES; done += 5) {
        kn_sink sink;
        void *product = NULL;
        unsigned char *saved = NULL;
        size_t bytes = 0;
        assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, NULL), KN_OK);
        assert_int_equal(sink.begin(w.ctx, sink.user, &w.tile.tile, &w.report), KN_OK);
        kn_patch_block block = {0, done, w.patch}, rest = {done, SINK_PATCHES - done, w.patch + done};
        assert_int_equal(sink.work(w.ctx, sink.user, &block, &product), KN_OK);
        assert_int_equal(sink.commit(w.ctx, sink.user, &block, product), KN_OK);
        assert_int_equal(sink.save(w.ctx, sink.user, &saved, &bytes), KN_OK);
        kn_sink_close(w.ctx, &sink);
        assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, NULL), KN_OK);
        assert_int_equal(sink.restore(w.ctx, sink.user, &w.tile.tile, &w.report, saved, bytes), KN_OK);
        assert_int_equal(sink.work(w.ctx, sink.user, &rest, &product), KN_OK);
        assert_int_equal(sink.commit(w.ctx, sink.user, &rest, product), KN_OK);
        assert_int_equal(sink.end(w.ctx, sink.user), KN_OK);
        kn_sink_close(w.ctx, &sink);
        char *text = test_read_file(w.path, NULL);
        assert_non_null(text);
        assert_string_equal(text, once);
        expect_nothing_beside(&w);
        assert_int_equal(kn_iges_sink(w.ctx, &sink, w.path, NULL), KN_OK); // half a state, and nothing to go on with
        assert_int_not_equal(sink.restore(w.ctx, sink.user, &w.tile.tile, &w.report, saved, bytes / 2), KN_OK);
        kn_ctx_clear_error(w.ctx);
        kn_sink_close(w.ctx, &sink);
        kn_free(w.ctx, saved);
        free(text);
    }
    free(once);
    sink_world_clear(&w);
}

static void refusals(void **state)
{
    (void)state;
    sink_world w;
    world_make(&w);
    kn_sink sink;
    sink_world_expect_refusals(&w);
    kn_job_report huge = test_report(3000000, 25, 25); // more lines than seven digits count
    kn_job_report meshes = test_report(1, 4, 3);
    sink_world_expect_refused(&w, &huge, &w.patch[3], KN_ELIMIT);
    meshes.meshes = 1;
    sink_world_expect_refused(&w, &meshes, &w.patch[3], KN_EDOMAIN);
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
    sink_world_clear(&w);
}

// Beside what is no file there is no place for another one: it has no name then.
static void into_a_pipe(void **state)
{
    (void)state;
    sink_world w;
    world_make(&w);
    kn_sink sink;
    assert_int_equal(kn_iges_sink(w.ctx, &sink, "/dev/null", NULL), KN_OK);
    assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &w.report, w.patch, SINK_PATCHES, 4), KN_OK);
    kn_sink_close(w.ctx, &sink);
    sink_world_clear(&w);
}

static void without_memory(void **state)
{
    (void)state;
    sink_world w;
    static const char *const called[2] = {"one", NULL};
    kn_iges_options options = {.surface_names = called, .nsurfaces = 2};
    kn_bezier f = {0};
    kn_trim side[2] = {{0}}, whole = {0};
    kn_trim_cut_report report;
    world_make(&w);
    assert_int_equal(kn_bezier_init(w.ctx, &f, 2, 1, false, (int[]){1, 1}), KN_OK);
    f.coef[0] = -1.0, f.coef[1] = 0.5, f.coef[2] = 0.25, f.coef[3] = 1.0;
    assert_int_equal(kn_trim_cut(w.ctx, &side[0], &side[1], &report, &whole, &f, 1e-2), KN_OK);
    w.patch[2].trim = &side[0], w.patch[7].trim = &side[1];
    w.patch[7].reversed = true;
    for (int surfaces = 0; surfaces < 2; surfaces++) {
        options.surfaces = surfaces;
        sink_world_starve(&w, &options);
        char *text = write_iges(&w, &options, SINK_PATCHES, 4);
        counts n = expect_consistent(text);
        assert_int_equal(n.of[144], surfaces ? 2 : 0);
        assert_int_equal(n.of[142], surfaces ? 2 : 0);
        assert_int_equal(n.of[102], surfaces ? 4 : 0);
        assert_int_equal(n.of[510], surfaces ? 0 : SINK_PATCHES);
        free(text);
        remove(w.path);
    }
    kn_bezier_clear(w.ctx, &f);
    for (int i = 0; i < 2; i++) kn_trim_clear(w.ctx, &side[i]);
    sink_world_clear(&w);
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
