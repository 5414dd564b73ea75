// SPDX-License-Identifier: Apache-2.0
// The text of STEP files: structure, numbers, strings, limits, equal bytes for any number of threads.
// What another CAD system makes of them: tests/bridges/t_occt_step.c.
#include "tests/support/sink_world.h"
#include <knurl/step.h>

#include "io/text_buffer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static kn_status open_step(kn_ctx *ctx, kn_sink *out, const char *path, const void *options)
{
    return kn_step_sink(ctx, out, path, options);
}

static void world_make(sink_world *w)
{
    sink_world_make(w, open_step, "out.step", 1);
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
    sink_world w;
    world_make(&w);
    kn_step_options options = {.product = "A 'pot'", .uncertainty_mm = 0.02, .time_stamp = "2026-01-02T03:04:05"};
    char *text = sink_world_write(&w, &options, SINK_PATCHES, 5);
    assert_ptr_equal(strstr(text, "ISO-10303-21;\nHEADER;\n"), text);
    assert_non_null(strstr(text, "FILE_NAME('A ''pot''','2026-01-02T03:04:05',"));
    assert_non_null(strstr(text, "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"));
    assert_string_equal(text + strlen(text) - strlen("\nENDSEC;\nEND-ISO-10303-21;\n"),
                        "\nENDSEC;\nEND-ISO-10303-21;\n");
    assert_non_null(strstr(text, "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.02),#11,"));
    assert_non_null(strstr(text, "SI_UNIT(.MILLI.,.METRE.)"));
    assert_int_equal(count(text, "=ADVANCED_FACE("), SINK_PATCHES);
    assert_int_equal(count(text, "=OPEN_SHELL("), SINK_PATCHES); // nobody meets anybody
    assert_int_equal(count(text, "=SHELL_BASED_SURFACE_MODEL("), 2);
    assert_int_equal(count(text, "=STYLED_ITEM("), 2);
    assert_int_equal(count(text, "=COLOUR_RGB("), 2);
    assert_int_equal(count(text, "RATIONAL_B_SPLINE_SURFACE("), 2); // patches 4 and 9
    assert_int_equal(count(text, "=EDGE_CURVE("), 4 * SINK_PATCHES);
    assert_int_equal(count(text, "'s0 c7,2 wire rod 7'"), 1);
    for (const char *at = text, *end; (end = strchr(at, '\n')) != NULL; at = end + 1) assert_true(end - at <= 220);
    expect_consistent(text);
    free(text);
    sink_world_clear(&w);
}

// A cube in two looks: twelve edges, eight vertices, one solid, whose faces have colours of their own; without its lid
// a shell; with a face that looks inwards no solid either.
static void bodies(void **state)
{
    (void)state;
    for (int lack = 0; lack < 3; lack++) {
        sink_world w;
        world_make(&w);
        sink_world_cube(&w);
        w.patch[3].reversed = lack == 2;
        char *text = sink_world_write(&w, NULL, lack == 1 ? 5 : 6, 2);
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
        sink_world_clear(&w);
    }
}

static void no_patches(void **state)
{
    (void)state;
    sink_world w;
    world_make(&w);
    w.report = test_report(0, 1, 1);
    char *text = sink_world_write(&w, NULL, 0, 1);
    expect_consistent(text);
    assert_int_equal(count(text, "OPEN_SHELL"), 0);
    free(text);
    sink_world_clear(&w);
}

static void equal_bytes(void **state)
{
    (void)state;
    sink_world_equal_bytes(open_step, "out.step");
}

static void refusals(void **state)
{
    (void)state;
    sink_world w;
    world_make(&w);
    kn_sink sink;
    sink_world_expect_refusals(&w);
    kn_job_report huge = test_report((size_t)1 << 40, 25, 25); // more numbers than 31 bits
    sink_world_expect_refused(&w, &huge, &w.patch[3], KN_ELIMIT);
    kn_step_options options = {.unit_mm = -1.0};
    assert_int_equal(kn_step_sink(w.ctx, &sink, w.path, &options), KN_EDOMAIN);
    kn_ctx_clear_error(w.ctx);
    options = (kn_step_options){.uncertainty_mm = NAN};
    assert_int_equal(kn_step_sink(w.ctx, &sink, w.path, &options), KN_EDOMAIN);
    sink_world_clear(&w);
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

static void without_memory(void **state)
{
    (void)state;
    sink_world w;
    world_make(&w);
    sink_world_starve(&w, NULL);
    sink_world_clear(&w);
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
