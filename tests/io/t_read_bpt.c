// SPDX-License-Identifier: Apache-2.0
// The reader of .bpt files: the teapot, and input that is wrong in every way.
#include "tests/support/support.h"

#include <knurl/io.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Two patches: degrees 1,2 (u, v) and 1,1.
static const char two[] = "2\n"
                          "1 2\n"
                          "0 0 0\n1 0 0\n" // u fastest
                          "0 1 0\n1 1 0.5\n"
                          "0 2 0\n1 2 -1e-3\n"
                          "1 1\n"
                          "0 0 1\n1 0 1\n0 1 1\n1 1 1\n";

static kn_status parse(kn_ctx *ctx, kn_model *out, const char *text, size_t bytes)
{
    // exactly as many bytes as there are: a sanitizer sees any step beyond
    char *exact = malloc(bytes > 0 ? bytes : 1);
    assert_non_null(exact);
    memcpy(exact, text, bytes);
    kn_status status = kn_parse_bpt(ctx, out, "x.bpt", exact, bytes);
    free(exact);
    return status;
}

static void order_of_points(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(parse(ctx, &model, two, strlen(two)), KN_OK);
    assert_int_equal(model.nsplines, 2);
    const kn_spline *s = &model.splines[0];
    assert_int_equal(s->nvars, 2);
    assert_int_equal(s->ncomp, 3);
    assert_false(s->rational);
    assert_int_equal(s->degree[0], 1);
    assert_int_equal(s->degree[1], 2);
    static const double coef[18] = {0, 0, 0, 1, 1, 1, 0, 1, 2, 0, 1, 2, 0, 0, 0, 0, 0.5, -1e-3};
    for (int k = 0; k < 18; k++) assert_true(s->coef[k] == coef[k]);
    double lo, hi;
    kn_spline_domain(s, 1, &lo, &hi);
    assert_true(lo == 0.0 && hi == 1.0);
    // over what was there before
    assert_int_equal(parse(ctx, &model, two, strlen(two)), KN_OK);
    assert_int_equal(model.nsplines, 2);
    kn_model_clear(ctx, &model);
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

static void teapot(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(kn_read_model(ctx, &model, "data/teapot.bpt"), KN_OK);
    assert_int_equal(model.nsplines, 32);
    double lo[3], hi[3], box_lo[3] = {9, 9, 9}, box_hi[3] = {-9, -9, -9};
    for (int i = 0; i < model.nsplines; i++) {
        assert_int_equal(model.splines[i].degree[0], 3);
        assert_int_equal(model.splines[i].degree[1], 3);
        assert_int_equal(kn_spline_check(ctx, &model.splines[i]), KN_OK);
        assert_int_equal(kn_spline_box(ctx, lo, hi, &model.splines[i]), KN_OK);
        for (int c = 0; c < 3; c++) {
            if (lo[c] < box_lo[c]) box_lo[c] = lo[c];
            if (hi[c] > box_hi[c]) box_hi[c] = hi[c];
        }
    }
    // published: the pot stands on z = 0 and is 3.15 high; spout and handle reach along x
    assert_true(box_lo[2] == 0.0 && box_hi[2] == 3.15);
    assert_true(box_lo[0] == -3.0 && box_hi[0] > 3.4);
    assert_true(box_lo[1] == -2.0 && box_hi[1] == 2.0);
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

static void expect_failure(const char *text, size_t bytes, kn_status expected, const char *message)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(parse(ctx, &model, text, bytes), expected);
    assert_int_equal(kn_ctx_error(ctx), expected);
    if (message != NULL) assert_string_equal(kn_ctx_message(ctx), message);
    assert_ptr_equal(strstr(kn_ctx_message(ctx), "x.bpt:"), kn_ctx_message(ctx));
    assert_null(model.splines);
    test_ctx_end(ctx, &memory);
}

static void bad_input(void **state)
{
    (void)state;
    static const struct {
        const char *text, *message;
        kn_status status;
    } cases[] = {
        {"", "x.bpt:1: the file ends where number of patches was expected", KN_EPARSE},
        {" \n\n ", "x.bpt:3: the file ends where number of patches was expected", KN_EPARSE},
        {"two", "x.bpt:1: number of patches is not an integer: two", KN_EPARSE},
        {"1.5", "x.bpt:1: number of patches is not an integer: 1.5", KN_EPARSE},
        {"0", "x.bpt:1: number of patches is not in 1 .. 2147483647: 0", KN_EPARSE},
        {"-3", "x.bpt:1: number of patches is not in 1 .. 2147483647: -3", KN_EPARSE},
        {"99999999999999999999", "x.bpt:1: number of patches is not in 1 .. 2147483647: 99999999999999999999",
         KN_EPARSE},
        {"1000000000\n3 3\n0 0 0\n", "x.bpt:1: 1000000000 patches expected, but only 11 bytes follow", KN_EPARSE},
        {"1\n1 1 0 0 0 1 0 0 0 1 0 1 1 nan", "x.bpt:2: control point is not finite: nan", KN_EPARSE},
        {"1\n1 1 0 0 0 1 0 0\n0 1 -Infinity 1 1 1", "x.bpt:3: control point is not finite: -Infinity", KN_EPARSE},
        {"1\n1 1 0 0 0 1 0 0\n0 1 1e999 1 1 1", "x.bpt:3: control point is not finite: 1e999", KN_EPARSE},
        {"1\n1 1 0 0 0 1 0 0\n0 1 0x10 1 1 1", "x.bpt:3: control point is not a number: 0x10", KN_EPARSE},
        {"1\n1 1 0 0 0 1 0 0\n0 1 . 1 1 1", "x.bpt:3: control point is not a number: .", KN_EPARSE},
        {"1\n1 1 0 0 0 1 0 0\n0 1 1e 1 1 1", "x.bpt:3: control point is not a number: 1e", KN_EPARSE},
        {"1\n1 1 0 0 0 1 0 0\n0 1 1,5 1 1 1", "x.bpt:3: control point is not a number: 1,5", KN_EPARSE},
        {"1\n0 1 0 0 0 1 0 0 0 1 0", "x.bpt:2: degree in u is not in 1 .. 56: 0", KN_EPARSE},
        {"1\n1 57 0 0 0 1 0 0 0 1 0", "x.bpt:2: degree in v is not in 1 .. 56: 57", KN_EPARSE},
        {"1\n1 1 0 0 0 1 0 0 0 1 0 1 1 0 junk", "x.bpt:2: text after the last patch is not expected: junk",
         KN_EPARSE},
        {"1\n1 1\n0 0 0 1 1 1 2 2 2 3 3 3", "x.bpt:2: patch 1 has zero area", KN_EPARSE},
        {"1\n1 1\n5 5 5 5 5 5 5 5 5 5 5 5", "x.bpt:2: patch 1 has zero area", KN_EPARSE},
        {"1\n2 1\n0 0 0 1 1 0 2 0 0 0 0 0 1 1 0 2 0 0", "x.bpt:2: patch 1 has zero area", KN_EPARSE},
        {"1\n1 1\n.1 .1 .1 .2 .2 .2 .3 .3 .3 .7 .7 .7", "x.bpt:2: patch 1 has zero area", KN_EPARSE},
        {"1\n3 3\n0 0 0", "x.bpt:2: 48 numbers expected (coordinates), but only 6 bytes follow", KN_EPARSE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        expect_failure(cases[i].text, strlen(cases[i].text), cases[i].status, cases[i].message);
}

// Cut before each word: something is missing, and is named.
static void truncated(void **state)
{
    (void)state;
    for (size_t n = 0; n < strlen(two); n++)
        if (n == 0 || strchr(" \n", two[n - 1]) != NULL) expect_failure(two, n, KN_EPARSE, NULL);
    expect_failure("1\n1 1 0000000000000 0 0 1 0 0 0 1 0 1", strlen("1\n1 1 0000000000000 0 0 1 0 0 0 1 0 1"),
                   KN_EPARSE, "x.bpt:2: the file ends where control point 4 of patch 1 was expected");
}

static void garbage(void **state)
{
    (void)state;
    expect_failure("\x7f"
                   "ELF\x02\x01\x01\x00\x00\xff\xfe",
                   11, KN_EPARSE, "x.bpt:1: number of patches is not an integer: ?ELF???????");
    size_t n = 1 << 16;
    char *line = malloc(n);
    assert_non_null(line);
    memset(line, '7', n);
    expect_failure(
        line, n, KN_EPARSE,
        "x.bpt:1: number of patches is not in 1 .. 2147483647: 7777777777777777777777777777777777777777...");
    memcpy(line, "1\n1 1 ", 6);
    expect_failure(line, n, KN_EPARSE,
                   "x.bpt:2: control point is too long a number: 7777777777777777777777777777777777777777...");
    free(line);
    test_rng rng = test_random(3);
    for (int i = 0, runs = test_scale(2000); i < runs; i++) { // any status will do: no crash, no leak
        char text[sizeof two];
        size_t length = (size_t)test_int(&rng, 0, (int)strlen(two));
        memcpy(text, two, sizeof two);
        for (int k = test_int(&rng, 0, 4); k > 0; k--)
            text[test_int(&rng, 0, (int)strlen(two) - 1)] = " \n-.e1029\xff"[test_int(&rng, 0, 9)];
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        kn_model model = {0};
        if (parse(ctx, &model, text, length) == KN_OK)
            for (int s = 0; s < model.nsplines; s++) assert_int_equal(kn_spline_check(ctx, &model.splines[s]), KN_OK);
        kn_model_clear(ctx, &model);
        test_ctx_end(ctx, &memory);
    }
}

static void no_file(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(kn_read_bpt(ctx, &model, "/nowhere/x.bpt"), KN_EIO);
    assert_string_equal(kn_ctx_message(ctx), "/nowhere/x.bpt: cannot open: No such file or directory");
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_read_bpt(ctx, &model, "data"), KN_EIO);
    assert_string_equal(kn_ctx_message(ctx), "data: cannot read: Is a directory");
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_read_model(ctx, &model, "data/teapot"), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_read_model(ctx, &model, "t"), KN_EDOMAIN);
    assert_null(model.splines);
    test_ctx_end(ctx, &memory);
}

static kn_status parse_two(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_model model = {0}, empty = {0};
    kn_status status = kn_parse_bpt(ctx, &model, "x.bpt", two, strlen(two));
    if (status != KN_OK) assert_memory_equal(&model, &empty, sizeof model);
    kn_model_clear(ctx, &model);
    return status;
}

static kn_status read_file(kn_ctx *ctx, void *user)
{
    kn_model model = {0}, empty = {0};
    kn_status status = kn_read_bpt(ctx, &model, user);
    if (status != KN_OK) assert_memory_equal(&model, &empty, sizeof model);
    kn_model_clear(ctx, &model);
    return status;
}

static kn_status read_model(kn_ctx *ctx, void *user)
{
    kn_model model = {0};
    kn_status status = kn_read_model(ctx, &model, user);
    kn_model_clear(ctx, &model);
    return status;
}

static void without_memory(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "two.bpt");
    size_t n = (1 << 17) + strlen(two); // more than the first guess of its size
    char *padded = malloc(n);
    assert_non_null(padded);
    memset(padded, ' ', n);
    memcpy(padded + n - strlen(two), two, strlen(two));
    test_write_file(path, padded, n);
    free(padded);
    test_allocation_failures(parse_two, NULL);
    test_allocation_failures(read_file, path);
    test_allocation_failures(read_model, path);
    remove(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order_of_points), cmocka_unit_test(teapot),  cmocka_unit_test(bad_input),
        cmocka_unit_test(truncated),       cmocka_unit_test(garbage), cmocka_unit_test(no_file),
        cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("io/read_bpt", tests, NULL, NULL);
}
