// SPDX-License-Identifier: Apache-2.0
// The faces of a part in few bytes, against the plain list of their numbers.
#include "tests/support/support.h"

#include "io/step_runs.h"

#include <stdlib.h>

enum { MOST = 4000 };

static void same(const kn_step_runs *runs, const uint64_t *list, size_t n, uint64_t stride)
{
    kn_step_place place = {0};
    uint64_t number;
    for (size_t i = 0; i < n; i++) {
        assert_true(kn_step_runs_next(&number, &place, runs, stride));
        assert_true(number == list[i]);
    }
    assert_false(kn_step_runs_next(&number, &place, runs, stride));
}

static void runs_of_all_kinds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(7);
    for (int round = 0; round < test_scale(40); round++) {
        kn_step_runs runs = {0};
        static uint64_t list[MOST];
        uint64_t stride = (uint64_t)test_int(&rng, 1, 300), at = (uint64_t)test_int(&rng, 1, 1 << 30) * 1000u;
        size_t n = (size_t)test_int(&rng, 0, MOST);
        int most = test_int(&rng, 1, 4);
        for (size_t i = 0; i < n; i++, at += stride) {
            if (test_int(&rng, 0, most) == 0) at += (uint64_t)test_int(&rng, 0, round % 2 ? 1 : 1 << 20); // a gap
            list[i] = at;
            assert_int_equal(kn_step_runs_add(ctx, &runs, at, stride), KN_OK);
        }
        assert_int_equal(kn_step_runs_end(ctx, &runs, stride), KN_OK);
        assert_int_equal(runs.bytes == 0, n == 0);
        same(&runs, list, n, stride);
        kn_step_runs_clear(ctx, &runs);
    }
    test_ctx_end(ctx, &memory);
}

// Two parts of regular cells are some numbers, however many cells; cells in colours of their own some bytes each: a
// skip of at most four bytes (below 2^28), a count and a number of times of one each.
static void bytes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(8);
    enum { CELLS = 20000, PATCHES = 5, STRIDE = 60, COLORS = 16 };
    kn_step_runs part[2] = {{0}}, color[COLORS] = {{0}};
    for (uint64_t c = 0; c < CELLS; c++) {
        int k = test_int(&rng, 0, COLORS - 1);
        for (uint64_t p = 0; p < PATCHES; p++) {
            uint64_t face = 1000 + (c * PATCHES + p) * STRIDE;
            assert_int_equal(kn_step_runs_add(ctx, &part[p > 2], face, STRIDE), KN_OK);
            assert_int_equal(kn_step_runs_add(ctx, &color[k], face, STRIDE), KN_OK);
        }
    }
    size_t all = 0;
    for (int k = 0; k < COLORS; k++) {
        assert_int_equal(kn_step_runs_end(ctx, &color[k], STRIDE), KN_OK);
        all += color[k].bytes;
        kn_step_runs_clear(ctx, &color[k]);
    }
    assert_true(all <= 6 * CELLS);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(kn_step_runs_end(ctx, &part[k], STRIDE), KN_OK);
        assert_true(part[k].bytes <= 20);
        kn_step_runs_clear(ctx, &part[k]);
    }
    test_ctx_end(ctx, &memory);
}

static kn_status add_some(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_step_runs runs = {0};
    kn_status status = KN_OK;
    for (uint64_t i = 1; i < 100 && status == KN_OK; i++) status = kn_step_runs_add(ctx, &runs, i * i, 1);
    if (status == KN_OK) status = kn_step_runs_end(ctx, &runs, 1);
    kn_step_runs_clear(ctx, &runs);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(add_some, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(runs_of_all_kinds), cmocka_unit_test(bytes),
                                       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("io/step_runs", tests, NULL, NULL);
}
