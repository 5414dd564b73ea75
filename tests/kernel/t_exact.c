// SPDX-License-Identifier: Apache-2.0
// Sums of products that are zero, and those that only look so.
#include <math.h>

#include "kernel/exact.h"
#include "tests/support/support.h"

static void zero_or_not(void **state)
{
    (void)state;
    assert_true(kn_exact_zero(NULL, NULL, NULL, 0));
    assert_true(kn_exact_zero((double[]){0.3}, (double[]){0.3}, (double[]){7}, 1));
    assert_true(kn_exact_zero((double[]){0.1, 0.1}, (double[]){0.3, 0.3}, (double[]){7, -7}, 2));
    // (1 + 2^-80) 3 - 3 = 3 2^-80: lost in doubles
    assert_true(kn_exact_zero((double[]){1, 1}, (double[]){-0x1p-80, 0}, (double[]){3, -3}, 2) == false);
    assert_true(kn_exact_zero((double[]){1, 1, 0x1p-80}, (double[]){-0x1p-80, 0, 0}, (double[]){3, -3, -3}, 3));
    assert_false(kn_exact_zero((double[]){1, 1, 0x1p-80}, (double[]){-0x1p-80, 0, 0}, (double[]){3, -3, -2}, 3));
    // beyond what can be said
    assert_false(kn_exact_zero((double[]){0x1p-600, 0x1p-600}, (double[]){0, 0}, (double[]){0x1p-600, -0x1p-600}, 2));
    assert_false(kn_exact_zero((double[]){1e200}, (double[]){0}, (double[]){1e200}, 1));
    assert_false(kn_exact_zero((double[]){1}, (double[]){0}, (double[]){NAN}, 1));
}

// (a - b) c + (b - a) c = 0 and (a - b) c + (b - a - e) c != 0, e the smallest change of b, for all numbers.
static void random_sums(void **state)
{
    (void)state;
    test_rng rng = test_random(1);
    for (int round = test_scale(20000); round > 0; round--) {
        double a = ldexp(test_uniform(&rng, -1, 1), test_int(&rng, -60, 60));
        double b = ldexp(test_uniform(&rng, -1, 1), test_int(&rng, -60, 60)), c = test_uniform(&rng, 1, 2);
        double near = nextafter(b, 1e9);
        assert_true(kn_exact_zero((double[]){a, b}, (double[]){b, a}, (double[]){c, c}, 2));
        assert_true(kn_exact_zero((double[]){a, b, a}, (double[]){b, 0, 0}, (double[]){c, c, -c}, 3));
        assert_false(kn_exact_zero((double[]){a, near}, (double[]){b, a}, (double[]){c, c}, 2));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(zero_or_not), cmocka_unit_test(random_sums)};
    return cmocka_run_group_tests_name("kernel/exact", tests, NULL, NULL);
}
