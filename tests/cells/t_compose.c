// SPDX-License-Identifier: Apache-2.0
// kn_cells_compose: S(map) exactly. Values against S at the map's values; degrees; every failure.
#include "tests/support/support.h"

#include <knurl/cells.h>
#include <knurl/compose.h>
#include <knurl/construct.h>
#include <math.h>
#include <string.h>

static const double origin[3] = {0}, axis[3] = {0, 0, 2};

// Random cells of [0,1]^2 with corners moved by up to a fifth of a cell; n lines, every one kept that `keep` divides.
static void random_map(kn_ctx *ctx, kn_spline *out, test_rng *rng, int n, int keep)
{
    double knots[64], coef[2 * 32 * 32];
    const double *both[2] = {knots, knots};
    for (int i = 0; i <= n; i++) knots[i + 1] = i;
    knots[0] = 0, knots[n + 2] = n;
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= n; j++) {
            const int at[2] = {i, j};
            for (int d = 0; d < 2; d++)
                coef[(d * (n + 1) + i) * (n + 1) + j] =
                    (at[d] + (at[d] % keep == 0 ? 0.0 : test_uniform(rng, -0.2, 0.2))) / n;
        }
    assert_int_equal(
        kn_spline_init(ctx, out, 2, 2, false, (const int[]){1, 1}, (const int[]){n + 1, n + 1}, both, coef), KN_OK);
}

// Two roundings of values and those of composition, relative to the size of the surface: gamma of some hundred.
static void values(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(51);
    for (int which = 0; which < 3; which++) {
        kn_spline s = {0}, map = {0}, out = {0};
        if (which == 0) test_random_spline(ctx, &s, &rng, 2, 3, false, (const int[]){3, 2}, (const int[]){4, 3}, 9);
        if (which == 1) assert_int_equal(kn_construct_cone(ctx, &s, origin, axis, 1, 0.3), KN_OK);
        if (which == 2) assert_int_equal(kn_construct_torus(ctx, &s, origin, axis, 3, 1), KN_OK);
        for (int d = 0; d < 2; d++) assert_int_equal(kn_spline_reparameterize(ctx, &s, &s, d, 0, 1), KN_OK);
        random_map(ctx, &map, &rng, 8, 2); // lines 2, 4, 6 are the quarters of circles
        assert_int_equal(kn_cells_compose(ctx, &out, &s, &map), KN_OK);
        for (int d = 0; d < 2; d++) {
            assert_int_equal(out.degree[d], s.degree[0] + s.degree[1]);
            assert_int_equal(kn_spline_spans(&out, d), 8);
        }
        assert_true(out.rational == s.rational);
        for (int k = 0; k < 2000; k++) {
            double at[2] = {test_uniform(&rng, 0, 8), test_uniform(&rng, 0, 8)}, uv[2], a[3], b[3];
            assert_int_equal(kn_spline_eval(ctx, uv, &map, at), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, a, &s, uv), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, b, &out, at), KN_OK);
            assert_true(test_max_difference(a, b, 3) <= 500 * 0x1p-53 * 10);
        }
        assert_int_equal(kn_cells_compose(ctx, &map, &s, &map), KN_OK); // in place
        assert_memory_equal(map.coef, out.coef, (size_t)out.ncomp * kn_spline_count(&out) * sizeof *out.coef);
        kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

static void refused(kn_ctx *ctx, kn_status want, const kn_spline *s, const kn_spline *map, const char *says)
{
    kn_spline out = {0};
    assert_int_equal(kn_cells_compose(ctx, &out, s, map), want);
    assert_true(out.coef == NULL && kn_ctx_error(ctx) == want);
    assert_non_null(strstr(kn_ctx_message(ctx), says));
    kn_ctx_clear_error(ctx);
}

static void fails(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(52);
    kn_spline s = {0}, map = {0}, other = {0}, high = {0};
    assert_int_equal(kn_construct_cone(ctx, &s, origin, axis, 1, 0.3), KN_OK);
    random_map(ctx, &map, &rng, 7, 7);
    refused(ctx, KN_EDOMAIN, &s, &map, "cell (1,"); // the first quarter lies in 7/4
    refused(ctx, KN_EDOMAIN, &map, &map, "surface");
    refused(ctx, KN_EDOMAIN, &s, &s, "map");
    random_map(ctx, &other, &rng, 8, 2);
    other.coef[9] += 1.0;
    refused(ctx, KN_EDOMAIN, &s, &other, "the map reaches");
    other.coef[9] = NAN;
    refused(ctx, KN_EDOMAIN, &s, &other, "");
    test_random_spline(ctx, &high, &rng, 2, 3, false, (const int[]){40, 20}, (const int[]){41, 21}, 9);
    for (int d = 0; d < 2; d++) assert_int_equal(kn_spline_reparameterize(ctx, &high, &high, d, 0, 1), KN_OK);
    refused(ctx, KN_ELIMIT, &high, &map, "");
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &other), kn_spline_clear(ctx, &high);
    test_ctx_end(ctx, &memory);
}

static kn_status short_of_memory(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_spline s = {0}, map = {0}, out = {0};
    kn_status status = kn_construct_cone(ctx, &s, origin, axis, 1, 0.3);
    if (status == KN_OK) status = kn_cells_relax(ctx, &map, &s, (const int[]){4, 1}, NULL);
    if (status == KN_OK) status = kn_cells_compose(ctx, &out, &s, &map);
    assert_true((status == KN_OK) == (out.coef != NULL));
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    return status;
}

static void memory_fails(void **state)
{
    (void)state;
    test_allocation_failures(short_of_memory, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(values), cmocka_unit_test(fails),
                                       cmocka_unit_test(memory_fails)};
    return cmocka_run_group_tests_name("cells/compose", tests, NULL, NULL);
}
