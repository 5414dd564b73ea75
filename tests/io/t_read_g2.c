// SPDX-License-Identifier: Apache-2.0
// The reader of GoTools .g2 files.
#include "tests/support/support.h"

#include <knurl/io.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static kn_status parse(kn_ctx *ctx, kn_model *out, const char *text, size_t bytes)
{
    char *exact = malloc(bytes > 0 ? bytes : 1); // no byte beyond the end: a sanitizer sees any step beyond
    assert_non_null(exact);
    memcpy(exact, text, bytes);
    kn_status status = kn_parse_g2(ctx, out, "x.g2", exact, bytes);
    free(exact);
    return status;
}

// A quarter of a cylinder, rational, with colours; a line; a box with one curved edge.
static const char sample[] = "200 1 0 4 255 0 128 255\n"
                             "3 1\n"
                             "3 3\n0 0 0 2 2 2\n"
                             "2 2\n0 0 1 1\n"
                             "1 0 0 1\n0.7071067811865476 0.7071067811865476 0 0.7071067811865476\n0 1 0 1\n"
                             "1 0 5 1\n0.7071067811865476 0.7071067811865476 3.5355339059327378 0.7071067811865476\n"
                             "0 1 5 1\n"
                             "\n"
                             "100 1 0 0\n2 0\n2 2\n-1 -1 3 3\n0 0 1 2\n"
                             "700 1 0 0\n3 0\n2 2\n0 0 1 1\n3 3\n0 0 0 1 1 1\n2 2\n0 0 1 1\n"
                             "0 0 0 1 0 0 0 1 0 1 1 0 0 2 0 1 2 0.5\n"
                             "0 0 1 1 0 1 0 1 1 1 1 1 0 2 1 1 2 1.5\n";

static void kinds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(parse(ctx, &model, sample, strlen(sample)), KN_OK);
    assert_int_equal(model.nsplines, 3);

    const kn_spline *cylinder = &model.splines[0];
    assert_true(cylinder->rational);
    assert_int_equal(cylinder->ncomp, 4);
    for (int i = 0; i <= 8; i++) { // x^2 + y^2 = 1: quotients of numbers below 2, few roundings each
        double at[2] = {0.25 * i, 0.125 * i}, p[3];
        assert_int_equal(kn_spline_eval(ctx, p, cylinder, at), KN_OK);
        assert_true(fabs(p[0] * p[0] + p[1] * p[1] - 1.0) <= 1e-14);
        assert_true(fabs(p[2] - 5.0 * at[1]) <= 1e-14);
    }

    const kn_spline *line = &model.splines[1];
    double at[3] = {1.0}, p[3], lo, hi;
    assert_int_equal(line->nvars, 1);
    assert_int_equal(kn_spline_dim(line), 2);
    kn_spline_domain(line, 0, &lo, &hi);
    assert_true(lo == -1.0 && hi == 3.0);
    assert_int_equal(kn_spline_eval(ctx, p, line, at), KN_OK);
    assert_true(p[0] == 0.5 && p[1] == 1.0);

    const kn_spline *volume = &model.splines[2];
    assert_int_equal(volume->nvars, 3);
    for (int i = 0; i <= 1; i++) // the corners: u along x, v along y, w along z
        for (int j = 0; j <= 1; j++)
            for (int k = 0; k <= 1; k++) {
                at[0] = i, at[1] = j, at[2] = k;
                assert_int_equal(kn_spline_eval(ctx, p, volume, at), KN_OK);
                assert_true(p[0] == i && p[1] == 2 * j && p[2] == k + 0.5 * i * j);
            }
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

// The value of a B-spline by the recursion of Cox and de Boor on the basis functions, straight from the definition.
static double basis(const double *t, int i, int p, double x, double end)
{
    bool inside = x < end ? t[i] <= x && x < t[i + 1] : t[i] < x && x == t[i + 1]; // at the end: from the left
    if (p == 0) return inside ? 1.0 : 0.0;
    double value = 0.0;
    if (t[i + p] > t[i]) value += (x - t[i]) / (t[i + p] - t[i]) * basis(t, i, p - 1, x, end);
    if (t[i + p + 1] > t[i + 1])
        value += (t[i + p + 1] - x) / (t[i + p + 1] - t[i + 1]) * basis(t, i + 1, p - 1, x, end);
    return value;
}

// Unclamped knots, even ones and others, become clamped ones of the same function.
static void unclamped(void **state)
{
    (void)state;
    static const struct {
        int n, order;
        double knots[14];
    } cases[] = {
        {5, 4, {0, 1, 2, 3, 4, 5, 6, 7, 8}},
        {4, 4, {-3, -2, -1, 0, 1, 2, 3, 4}},
        {6, 4, {0, 0, 1, 1, 2, 2, 3, 5, 5, 5}},
        {6, 3, {0, 0, 0, 1, 1, 2, 3, 4, 4.5}},
        {6, 3, {-1, 0, 0, 1, 1, 1, 3, 3, 3}},
        {5, 2, {0, 1, 2, 3, 4, 5, 6}},
        {7, 5, {0, 0.5, 1, 1, 2, 4, 4, 5, 5, 5, 5, 6}},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        int n = cases[c].n, p = cases[c].order - 1, length = 0;
        const double *t = cases[c].knots;
        double coef[2][8], lo, hi;
        char text[2048];
        // a surface: the case in u, clamped linear in v, so that lines of the array are strided too
        length += snprintf(text, sizeof text, "200 1 0 0 3 0 %d %d ", n, p + 1);
        for (int i = 0; i <= n + p; i++) length += snprintf(text + length, 99, "%.17g ", t[i]);
        length += snprintf(text + length, 99, "2 2 0 0 1 1 ");
        for (int j = 0; j < 2; j++)
            for (int i = 0; i < n; i++) {
                coef[j][i] = test_int(&rng, -9, 9);
                length += snprintf(text + length, 99, "%d %d %g\n", i, j, coef[j][i]);
            }
        kn_model model = {0};
        assert_int_equal(parse(ctx, &model, text, (size_t)length), KN_OK);
        const kn_spline *s = model.splines;
        assert_int_equal(kn_spline_check(ctx, s), KN_OK);
        kn_spline_domain(s, 0, &lo, &hi);
        assert_true(lo == t[p] && hi == t[n]);
        for (int k = 0; k <= 40; k++) {
            double at[2] = {lo + (hi - lo) * k / 40.0, 0.25}, value[3], expected = 0.0;
            for (int i = 0; i < n; i++)
                expected += basis(t, i, p, at[0], hi) * (0.75 * coef[0][i] + 0.25 * coef[1][i]);
            assert_int_equal(kn_spline_eval(ctx, value, s, at), KN_OK);
            // convex combinations of numbers up to 9: a few ulps of 9 for each of some 2 p insertions and p levels
            assert_true(fabs(value[2] - expected) <= 9.0 * 2.3e-16 * 8.0 * (3 * p + 3));
        }
        kn_model_clear(ctx, &model);
    }
    test_ctx_end(ctx, &memory);
}

static void expect_failure(const char *text, size_t bytes, kn_status expected, const char *message)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(parse(ctx, &model, text, bytes), expected);
    if (message != NULL) assert_string_equal(kn_ctx_message(ctx), message);
    assert_ptr_equal(strstr(kn_ctx_message(ctx), "x.g2:"), kn_ctx_message(ctx));
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
        {"", "x.g2:1: the file ends where class of object of object 1 was expected", KN_EPARSE},
        {"130 1 0 0", "x.g2:1: class of object is none of 100 (curve), 200 (surface), 700 (volume): 130", KN_EPARSE},
        {"solid 1 0 0", "x.g2:1: class of object is not an integer: solid", KN_EPARSE},
        {"200 2 0 0", "x.g2:1: major version is not in 1 .. 1: 2", KN_EPARSE},
        {"200 1 0 9", "x.g2:1: number of colour values is not in 0 .. 4: 9", KN_EPARSE},
        {"100 1 0 4 1 2 3 256", "x.g2:1: colour value is not in 0 .. 255: 256", KN_EPARSE},
        {"100 1 0 0\n64 0", "x.g2:2: dimension is not in 1 .. 63: 64", KN_EPARSE},
        {"100 1 0 0\n3 2", "x.g2:2: rational flag is not in 0 .. 1: 2", KN_EPARSE},
        {"100 1 0 0\n3 0\n1000000000 4\n0 0", "x.g2:3: 1000000004 numbers expected (knots), but only 4 bytes follow",
         KN_EPARSE},
        {"100 1 0 0\n3 0\n2 1000000000\n0 0", "x.g2:3: order 1000000000, but at most 57 is allowed", KN_ELIMIT},
        {"100 1 0 0\n3 0\n60 58\n0 0", "x.g2:3: order 58, but at most 57 is allowed", KN_ELIMIT},
        {"100 1 0 0\n3 0\n3 4\n0 0", "x.g2:3: 3 control points are fewer than the order 4", KN_EPARSE},
        {"100 1 0 0\n1 0\n3 2\n0 0 1 0.5 1\n1 2 3", "x.g2:4: knots decrease: 0.5 after 1", KN_EPARSE},
        {"100 1 0 0\n1 0\n3 2\n0 0 0 1 1\n1 2 3", "x.g2:4: knot 0 more than 2 times, the order", KN_EPARSE},
        {"100 1 0 0\n1 0\n2 2\n0 1 1 2\n1 2", "x.g2:4: knots leave an empty domain: 1 to 1", KN_EPARSE},
        {"100 1 0 0\n1 0\n2 2\n0 0 inf inf\n1 2", "x.g2:4: knot is not finite: inf", KN_EPARSE},
        {"100 1 0 0\n1 0\n2 2\n0 0 1 1\n1 NaN", "x.g2:5: control point is not finite: NaN", KN_EPARSE},
        {"100 1 0 0\n1 1\n2 2\n0 0 1 1\n1 1 2\n-1", "x.g2:6: weight is not positive: -1", KN_EPARSE},
        {"100 1 0 0\n1 1\n2 2\n0 0 1 1\n1 0 2 1", "x.g2:5: weight is not positive: 0", KN_EPARSE},
        {"100 1 0 0\n1 0\n2 2\n0 0 1 1\n1 2\njunk", "x.g2:6: class of object is not an integer: junk", KN_EPARSE},
        {"200 1 0 0\n3 0\n2 2 0 0 1 1 2 2 0 0 1 1\n0 0 0 1 1 1 2 2 2 3 3 3",
         "x.g2:2: surface (object 1) has zero area", KN_EPARSE},
        {"200 1 0 0\n2 0\n2 2 0 0 1 1 2 2 0 0 1 1\n0 0 1 1 0 0 1 1", "x.g2:2: surface (object 1) has zero area",
         KN_EPARSE},
        {"700 1 0 0\n3 0\n2 2 0 0 1 1 2 2 0 0 1 1 2 2 0 0 1 1\n0 0 0 1",
         "x.g2:3: 24 numbers expected (coordinates of control points), but only 8 bytes follow", KN_EPARSE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        expect_failure(cases[i].text, strlen(cases[i].text), cases[i].status, cases[i].message);
}

// Cut before each word: the file is then short, unless an object had just ended.
static void truncated(void **state)
{
    (void)state;
    const char *second = strstr(sample, "100 1"), *third = strstr(sample, "700 1");
    for (size_t n = 0; n < strlen(sample); n++) {
        bool whole = sample + n == second || sample + n == second - 1 || sample + n == third;
        if (!whole && (n == 0 || strchr(" \n", sample[n - 1]) != NULL)) expect_failure(sample, n, KN_EPARSE, NULL);
    }
}

static void garbage(void **state)
{
    (void)state;
    expect_failure("\x89PNG\r\n\x1a\n", 8, KN_EPARSE, "x.g2:1: class of object is not an integer: ?PNG");
    test_rng rng = test_random(5);
    for (int i = 0, runs = test_scale(2000); i < runs; i++) { // any status will do: no crash, no leak
        char text[sizeof sample];
        size_t length = (size_t)test_int(&rng, 0, (int)strlen(sample));
        memcpy(text, sample, sizeof sample);
        for (int k = test_int(&rng, 0, 4); k > 0; k--)
            text[test_int(&rng, 0, (int)strlen(sample) - 1)] = " \n-.e1029\xff"[test_int(&rng, 0, 9)];
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        kn_model model = {0};
        if (parse(ctx, &model, text, length) == KN_OK)
            for (int s = 0; s < model.nsplines; s++) assert_int_equal(kn_spline_check(ctx, &model.splines[s]), KN_OK);
        kn_model_clear(ctx, &model);
        test_ctx_end(ctx, &memory);
    }
}

// Rational nets that do not change along v have no area only if their weights do not change either.
static void area_of_rational(void **state)
{
    (void)state;
    static const char spun[] = "200 1 0 0 3 1 3 3 0 0 0 1 1 1 2 2 0 0 1 1\n"
                               "0 0 0 1  1 1 0 1  2 0 0 1   0 0 0 1  5 5 0 5  2 0 0 1";
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(parse(ctx, &model, spun, strlen(spun)), KN_OK);
    double a[3], b[3], middle[2] = {0.5, 0.0}, end[2] = {0.5, 1.0};
    assert_int_equal(kn_spline_eval(ctx, a, model.splines, middle), KN_OK);
    assert_int_equal(kn_spline_eval(ctx, b, model.splines, end), KN_OK);
    assert_true(fabs(a[1] - 0.5) < 1e-15 && fabs(b[1] - 5.0 / 6.0) < 1e-15); // it does sweep out an area
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

static kn_status parse_text(kn_ctx *ctx, void *user)
{
    const char *text = user;
    kn_model model = {0}, empty = {0};
    kn_status status = kn_parse_g2(ctx, &model, "x.g2", text, strlen(text));
    if (status != KN_OK) assert_memory_equal(&model, &empty, sizeof model);
    kn_model_clear(ctx, &model);
    return status;
}

static kn_status read_text(kn_ctx *ctx, void *user)
{
    kn_model model = {0};
    kn_status status = kn_read_g2(ctx, &model, user);
    kn_model_clear(ctx, &model);
    return status;
}

static void without_memory(void **state)
{
    (void)state;
    char text[sizeof sample], path[TEST_PATH_BYTES];
    memcpy(text, sample, sizeof sample);
    test_allocation_failures(parse_text, text);
    char floating[] = "200 1 0 0 3 0 4 4 0 1 2 3 4 5 6 7 2 2 0 0 1 1 0 0 0 1 0 0 2 0 1 3 0 0 0 1 0 1 1 0 2 1 1 3 1 0";
    test_allocation_failures(parse_text, floating);
    test_tmp_path(path, "sample.g2");
    test_write_file(path, sample, strlen(sample));
    test_allocation_failures(read_text, path);
    remove(path);
}

static void no_file(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model model = {0};
    assert_int_equal(kn_read_g2(ctx, &model, "/nowhere/x.g2"), KN_EIO);
    assert_string_equal(kn_ctx_message(ctx), "/nowhere/x.g2: cannot open: No such file or directory");
    assert_null(model.splines);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kinds),          cmocka_unit_test(unclamped), cmocka_unit_test(bad_input),
        cmocka_unit_test(truncated),      cmocka_unit_test(garbage),   cmocka_unit_test(area_of_rational),
        cmocka_unit_test(without_memory), cmocka_unit_test(no_file),
    };
    return cmocka_run_group_tests_name("io/read_g2", tests, NULL, NULL);
}
