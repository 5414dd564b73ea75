// SPDX-License-Identifier: Apache-2.0
// Slices in a 3MF file, read back by lib3mf.
#include "tests/support/support.h"

#if KN_WITH_LIB3MF

#include "bridges/lib3mf/slices.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

static void stack_of_squares(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "slices.3mf");
    kn_3mf_slices *stack = NULL;
    kn_3mf_slices_facts facts;
    const double outer[] = {0, 0, 4, 0, 4, 4, 0, 4}, hole[] = {1, 1, 1, 2, 2, 2, 2, 1}, loose[] = {9, 9, 10, 10};
    const kn_slice_loop loops[] = {{outer, 4, true, 0, 0}, {hole, 4, true, 0, 0}, {loose, 2, false, 0, 0}};
    assert_int_equal(kn_3mf_slices_create(ctx, &stack, path, 25.4, -0.5, 0.25), KN_OK);
    for (size_t k = 0; k < 5; k++) {
        kn_slice layer = {.index = k, .z = 0.25 * (double)k, .loops = loops, .nloops = k == 2 ? 0 : 3};
        assert_int_equal(kn_3mf_slices_add(ctx, stack, &layer), KN_OK);
    }
    size_t bytes = 0;
    assert_int_not_equal(access(path, F_OK), 0); // not before it is whole
    assert_int_equal(kn_3mf_slices_write(ctx, stack, &bytes), KN_OK);
    kn_3mf_slices_destroy(ctx, stack);
    assert_true(bytes > 500);
    assert_int_equal(kn_3mf_slices_look(ctx, &facts, path), KN_OK);
    assert_int_equal(facts.slices, 5);
    assert_int_equal(facts.polygons, 8);
    assert_int_equal(facts.vertices, 32);
    assert_true(fabs(facts.top - 1.25 * 25.4) < 1e-5); // single precision
    assert_int_equal(remove(path), 0);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "refused.3mf");
    kn_3mf_slices *stack = NULL;
    kn_3mf_slices_facts facts;
    assert_int_equal(kn_3mf_slices_create(ctx, &stack, path, 0, 0, 0), KN_EDOMAIN);
    assert_int_equal(kn_3mf_slices_create(ctx, &stack, path, 1, NAN, 0), KN_EDOMAIN);
    assert_int_equal(kn_3mf_slices_create(ctx, &stack, "/no/such/folder/x.3mf", 1, 0, 0), KN_EIO);
    assert_null(stack);
    assert_int_equal(kn_3mf_slices_look(ctx, &facts, path), KN_EIO);
    assert_int_equal(kn_3mf_slices_create(ctx, &stack, path, 1, 0, 0), KN_OK);
    const double far[] = {0, 0, 1e300, 0, 0, 1};
    const kn_slice_loop loop = {far, 3, true, 0, 0};
    kn_slice layer = {.index = 0, .z = 1, .loops = &loop, .nloops = 1}, below = {.index = 1, .z = 1};
    assert_int_equal(kn_3mf_slices_add(ctx, stack, &layer), KN_EDOMAIN);
    assert_int_equal(kn_3mf_slices_add(ctx, stack, &below), KN_EDOMAIN); // not above the first one
    kn_3mf_slices_destroy(ctx, stack);
    assert_int_not_equal(access(path, F_OK), 0); // nothing is left
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(stack_of_squares), cmocka_unit_test(failures)};
    return cmocka_run_group_tests_name("bridges/3mf_slices", tests, NULL, NULL);
}

#else

static void not_built(void **state)
{
    (void)state;
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(not_built)};
    return cmocka_run_group_tests_name("bridges/3mf_slices", tests, NULL, NULL);
}

#endif
