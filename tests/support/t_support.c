// SPDX-License-Identifier: Apache-2.0
// The test support itself: a failing allocator that does not fail, or random numbers that are not, would hide much.
#include "tests/support/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The first outputs for state 1234567, as published with the reference implementation.
static void random_bits_are_splitmix(void **state)
{
    (void)state;
    const uint64_t expected[] = {UINT64_C(6457827717110365317), UINT64_C(3203168211198807973),
                                 UINT64_C(9817491932198370423), UINT64_C(4593380528125082431)};
    test_rng rng = {1234567};
    for (int i = 0; i < 4; i++) assert_true(test_bits(&rng) == expected[i]);
}

static void random_ranges(void **state)
{
    (void)state;
    test_rng rng = test_random(1), other = test_random(2);
    assert_true(test_bits(&rng) != test_bits(&other));
    bool seen[5] = {false};
    for (int i = 0; i < 1000; i++) {
        int k = test_int(&rng, -2, 2);
        assert_in_range(k + 2, 0, 4);
        seen[k + 2] = true;
        double x = test_uniform(&rng, 3.0, 4.0);
        assert_true(x >= 3.0 && x < 4.0);
    }
    for (int i = 0; i < 5; i++) assert_true(seen[i]);
}

static void allocator_fails_once_and_counts(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_allocator a = test_allocator(&memory);
    memory.fail_at = 1;
    void *first = a.allocate(a.user, 10);
    assert_non_null(first);
    assert_false(atomic_load(&memory.failed));
    assert_null(a.allocate(a.user, 10));
    assert_true(atomic_load(&memory.failed));
    void *grown = a.resize(a.user, first, 20);
    assert_non_null(grown);
    assert_true(atomic_load(&memory.live) == 1);
    a.release(a.user, grown);
    assert_true(atomic_load(&memory.live) == 0);
    assert_true(atomic_load(&memory.calls) == 3);
}

typedef struct record {
    int calls, failures;
} record;

static kn_status one_piece(kn_ctx *ctx, void *user)
{
    record *r = user;
    kn_bezier b = {0};
    kn_status status = kn_bezier_init(ctx, &b, 1, 1, false, (int[]){3});
    r->calls++;
    if (status != KN_OK) r->failures++;
    kn_bezier_clear(ctx, &b);
    return status;
}

static void every_allocation_is_failed(void **state)
{
    (void)state;
    record r = {0};
    test_allocation_failures(one_piece, &r);
    assert_int_equal(r.failures, 1);
    assert_int_equal(r.calls, 2);
}

static void differences(void **state)
{
    (void)state;
    const double a[] = {1.0, 2.0}, b[] = {1.5, 2.25}, c[] = {1.0, (double)NAN};
    assert_true(test_max_difference(a, b, 2) == 0.5);
    assert_true(test_max_difference(a, c, 2) > 1e300);
    assert_true(test_max_difference(a, b, 0) == 0.0);
}

static void files(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "files");
    assert_null(test_read_file(path, NULL));
    char data[5000];
    memset(data, 'x', sizeof data);
    test_write_file(path, data, sizeof data);
    size_t bytes = 0;
    char *back = test_read_file(path, &bytes);
    assert_non_null(back);
    assert_true(bytes == sizeof data);
    assert_memory_equal(back, data, bytes);
    assert_true(back[bytes] == 0);
    free(back);
    assert_int_equal(remove(path), 0);
}

// Clamped, within the multiplicity that kn_spline allows, integers throughout.
static void random_splines_are_valid(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int i = 0; i < 20; i++) {
        kn_spline s = {0};
        int degree[2] = {test_int(&rng, 1, 4), test_int(&rng, 1, 4)};
        int count[2] = {degree[0] + test_int(&rng, 1, 5), degree[1] + test_int(&rng, 1, 5)};
        test_random_spline(ctx, &s, &rng, 2, 4, true, degree, count, 3);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        for (size_t k = 0; k < 4 * kn_spline_count(&s); k++) assert_true(s.coef[k] == rint(s.coef[k]));
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_bits_are_splitmix),
        cmocka_unit_test(random_ranges),
        cmocka_unit_test(allocator_fails_once_and_counts),
        cmocka_unit_test(every_allocation_is_failed),
        cmocka_unit_test(differences),
        cmocka_unit_test(files),
        cmocka_unit_test(random_splines_are_valid),
    };
    return cmocka_run_group_tests_name("support/support", tests, NULL, NULL);
}
