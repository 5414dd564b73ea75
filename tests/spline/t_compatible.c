// SPDX-License-Identifier: Apache-2.0
// Splines brought onto one grid, refined to a grid, reparameterized.
#include <math.h>
#include <string.h>

#include "tests/spline/oracle.h"
#include "tests/support/support.h"

static kn_spline curve(kn_ctx *ctx, int degree, int count, const double *knots, const double *coef)
{
    kn_spline s;
    const double *const k[] = {knots};
    assert_int_equal(kn_spline_init(ctx, &s, 1, 1, false, &degree, &count, k, coef), KN_OK);
    return s;
}

static void assert_numbers(const double *a, const double *b, int n)
{
    for (int i = 0; i < n; i++) assert_true(a[i] == b[i]);
}

// x over [0,2] as a line beside others: elevated and refined, it has its control points at the Greville sites,
// exactly.
static void a_line_and_a_parabola(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline list[3] = {
        curve(ctx, 1, 2, (double[]){0, 0, 2, 2}, (double[]){0, 2}),
        curve(ctx, 2, 4, (double[]){0, 0, 0, 0.5, 2, 2, 2}, (double[]){3, -1, 4, 1}),
        curve(ctx, 1, 3, (double[]){0, 0, 1, 2, 2}, (double[]){0, 8, 2}),
    };
    assert_int_equal(kn_spline_make_compatible(ctx, list, 3), KN_OK);
    const double knots[] = {0, 0, 0, 0.5, 1, 1, 2, 2, 2};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(list[i].degree[0], 2);
        assert_int_equal(list[i].count[0], 6);
        assert_numbers(list[i].knots[0], knots, 9);
    }
    assert_numbers(list[0].coef, (double[]){0, 0.25, 0.75, 1, 1.5, 2}, 6);
    assert_numbers(list[2].coef, (double[]){0, 2, 6, 8, 5, 2}, 6); // f(0,.5) f(.5,1) f(1,1) f(1,2)
    size_t before = kn_ctx_counters(ctx).allocations;
    double *coef = list[1].coef;
    assert_int_equal(kn_spline_make_compatible(ctx, list, 3), KN_OK); // again: nothing to do, nothing moves
    assert_int_equal(kn_ctx_counters(ctx).allocations, before);
    assert_ptr_equal(list[1].coef, coef);
    for (int i = 0; i < 3; i++) kn_spline_clear(ctx, &list[i]);
    test_ctx_end(ctx, &memory);
}

// 7 p + 2 roundings a step of elevation, 6 p + 1 for insertion, each variable; degrees up to 4, at most 4 steps.
static int operations(const kn_spline *s)
{
    int n = 1;
    for (int d = 0; d < s->nvars; d++) n += (6 * s->degree[d] + 3) + 4 * (7 * s->degree[d] + 2);
    return n;
}

static void random_spline(kn_ctx *ctx, kn_spline *s, test_rng *rng, int nvars)
{
    int degree[KN_MAX_VARS], count[KN_MAX_VARS];
    for (int d = 0; d < nvars; d++) {
        degree[d] = test_int(rng, 0, 4);
        count[d] = degree[d] + 1 + test_int(rng, 0, nvars > 2 ? 2 : 5);
    }
    bool rational = test_int(rng, 0, 1);
    test_random_spline(ctx, s, rng, nvars, test_int(rng, 2, 4), rational, degree, count, 9);
    for (int d = 0; d < nvars; d++) { // all over [0,1]
        kn_spline t = {0};
        assert_int_equal(kn_spline_reparameterize(ctx, &t, s, d, 0, 1), KN_OK);
        kn_spline_swap(s, &t);
        kn_spline_clear(ctx, &t);
    }
}

static void compatible_splines_keep_their_values(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(20); round > 0; round--) {
        kn_spline list[3], old[3] = {{0}};
        int nvars = test_int(&rng, 1, 3);
        for (int i = 0; i < 3; i++) {
            random_spline(ctx, &list[i], &rng, nvars);
            assert_int_equal(kn_spline_copy(ctx, &old[i], &list[i]), KN_OK);
        }
        assert_int_equal(kn_spline_make_compatible(ctx, list, 3), KN_OK);
        for (int i = 0; i < 3; i++) {
            assert_int_equal(kn_spline_check(ctx, &list[i]), KN_OK);
            for (int d = 0; d < nvars; d++) {
                int n = list[0].count[d] + list[0].degree[d] + 1;
                assert_int_equal(list[i].degree[d], list[0].degree[d]);
                assert_int_equal(list[i].count[d], list[0].count[d]);
                assert_numbers(list[i].knots[d], list[0].knots[d], n);
            }
            oracle_assert_same(&old[i], &list[i], 5, 5, 0.0, operations(&list[i]));
        }
        for (int i = 0; i < 3; i++) {
            kn_spline_clear(ctx, &list[i]);
            kn_spline_clear(ctx, &old[i]);
        }
    }
    test_ctx_end(ctx, &memory);
}

static void compatibility_refuses(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline list[3] = {
        curve(ctx, 1, 2, (double[]){0, 0, 2, 2}, (double[]){0, 2}),
        curve(ctx, 1, 2, (double[]){0, 0, 3, 3}, (double[]){0, 2}),
        {0},
    };
    kn_spline before[3];
    memcpy(before, list, sizeof list);
    assert_int_equal(kn_spline_make_compatible(ctx, list, 2), KN_EDOMAIN);
    assert_int_equal(kn_spline_make_compatible(ctx, list + 1, 2), KN_EDOMAIN); // an empty one
    assert_int_equal(kn_spline_make_compatible(ctx, list + 2, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_make_compatible(ctx, list, -1), KN_EDOMAIN);
    assert_int_equal(kn_spline_make_compatible(ctx, list, 0), KN_OK);
    assert_int_equal(kn_spline_make_compatible(ctx, list, 1), KN_OK);
    assert_memory_equal(before, list, sizeof list);
    for (int i = 0; i < 3; i++) kn_spline_clear(ctx, &list[i]);
    test_ctx_end(ctx, &memory);
}

static void refinement_to_a_grid(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double u[] = {0, 0, 0, 1, 2, 2, 2}, v[] = {0, 0, 4, 4}, fine[] = {0, 0, 0, 0.5, 1, 1.5, 2, 2, 2};
    const double *const knots[] = {u, v}, unsorted[] = {1.5, 0.5, 1, 0};
    const double coef[] = {0, 4, 0, 4, 2, 6, 4, 8}; // u^2 + v
    kn_spline s, t = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 2, 1, false, (int[]){2, 1}, (int[]){4, 2}, knots, coef), KN_OK);
    const double *const to[] = {unsorted, (double[]){2}};
    assert_int_equal(kn_spline_refine(ctx, &t, &s, (int[]){4, 1}, to), KN_OK);
    assert_int_equal(t.count[0], 6);
    assert_int_equal(t.count[1], 3);
    assert_numbers(t.knots[0], fine, 9);
    const double x[] = {0, 0, 0.5, 1.5, 3, 4}; // products of neighbours
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 3; j++) assert_true(t.coef[3 * i + j] == x[i] + 2 * j);
    const double *const all[] = {fine, v};
    assert_int_equal(kn_spline_refine(ctx, &s, &s, (int[]){9, 4}, all), KN_OK); // in place, a whole knot vector
    assert_int_equal(s.count[0], 6);
    assert_int_equal(s.count[1], 2);
    const double outside[] = {2.5}, much[] = {1, 1, 1, 1}, nan[] = {NAN};
    const struct {
        const double *knots;
        int n;
        kn_status status;
    } bad[] = {{outside, 1, KN_EDOMAIN},
               {much, 4, KN_EDOMAIN},
               {nan, 1, KN_EDOMAIN},
               {much, -1, KN_EDOMAIN},
               {much, 1 << 29, KN_ELIMIT}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(
            kn_spline_refine(ctx, &t, &s, (int[]){bad[i].n, 0}, (const double *const[]){bad[i].knots, v}),
            bad[i].status);
    assert_int_equal(kn_spline_refine(ctx, &t, &(kn_spline){0}, (int[]){0, 0}, all), KN_EDOMAIN);
    assert_int_equal(t.count[0], 6);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &t);
    test_ctx_end(ctx, &memory);
}

// Knots are the exactly mapped ones rounded once, which long double tells: its error, 2^-62, is far below half an ulp
// except near ties: |knot - exact| <= (1/2 + 2^-9) ulp, and the error of the long double itself.
static void reparameterization(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int round = test_scale(200); round > 0; round--) {
        kn_spline s, t = {0};
        test_random_spline(ctx, &s, &rng, 1, 1, false, (int[]){2}, (int[]){9}, 9);
        double lo = test_uniform(&rng, -5, 5), hi = lo + test_uniform(&rng, 1e-3, 7);
        assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 0, lo, hi), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &t), KN_OK);
        assert_memory_equal(t.coef, s.coef, 9 * sizeof(double));
        assert_true(t.knots[0][0] == lo && t.knots[0][11] == hi);
        long double a = s.knots[0][0], b = s.knots[0][11];
        for (int i = 0; i < 12; i++) {
            long double exact = lo + ((long double)s.knots[0][i] - a) / (b - a) * ((long double)hi - lo);
            double near = (double)exact, ulp = nextafter(fabs(near), INFINITY) - fabs(near);
            assert_true(fabsl(t.knots[0][i] - exact) <= (0.5L + 0x1p-9L) * ulp + 0x1p-60L);
        }
        double from, end;
        kn_spline_domain(&s, 0, &from, &end);
        assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 0, from, end),
                         KN_OK); // the same domain: all as it was
        assert_memory_equal(t.knots[0], s.knots[0], 12 * sizeof(double));
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
    }
    kn_spline s = curve(ctx, 1, 4, (double[]){0, 0, 1, 2, 4, 4}, (double[]){1, 2, 3, 4}), t = {0};
    assert_int_equal(kn_spline_reparameterize(ctx, &s, &s, 0, -8, 8), KN_OK); // in place, exact
    assert_numbers(s.knots[0], (double[]){-8, -8, -4, 0, 8, 8}, 6);
    assert_int_equal(kn_spline_reparameterize(ctx, &s, &s, 0, 1e300, 1.5e308), KN_OK);
    assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
    assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 1, 0, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 0, 1, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 0, 2, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 0, NAN, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 0, 0, INFINITY), KN_EDOMAIN);
    assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 0, -1.7e308, 1.7e308), KN_EDOMAIN);  // length overflows
    assert_int_equal(kn_spline_reparameterize(ctx, &t, &s, 0, 1, nextafter(1, 2)), KN_EDOMAIN); // knots fall together
    assert_int_equal(kn_spline_reparameterize(ctx, &t, &(kn_spline){0}, 0, 0, 1), KN_EDOMAIN);
    assert_int_equal(t.nvars, 0);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static kn_status make(kn_ctx *ctx, kn_spline *s, int degree, double knot)
{
    double coef[64], knots[16];
    const double *const k[] = {knots, knots};
    int n = 0;
    for (int i = 0; i <= degree; i++) knots[n++] = 0;
    knots[n++] = knot;
    for (int i = 0; i <= degree; i++) knots[n++] = 2;
    for (int i = 0; i < 64; i++) coef[i] = 1 + i % 5;
    return kn_spline_init(ctx, s, 2, 2, false, (int[]){degree, degree}, (int[]){degree + 2, degree + 2}, k, coef);
}

// All or none of the list changes.
static kn_status compatible_in_little_memory(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_spline list[3] = {{0}};
    kn_status status = make(ctx, &list[0], 2, 1);
    if (status == KN_OK) status = make(ctx, &list[1], 1, 0.5);
    if (status == KN_OK) status = make(ctx, &list[2], 2, 1.5);
    if (status == KN_OK) {
        kn_spline before[3];
        memcpy(before, list, sizeof list);
        status = kn_spline_make_compatible(ctx, list, 3);
        if (status != KN_OK) assert_memory_equal(before, list, sizeof list);
    }
    for (int i = 0; i < 3; i++) kn_spline_clear(ctx, &list[i]);
    return status;
}

static kn_status change_in_little_memory(kn_ctx *ctx, void *user)
{
    kn_spline a = {0}, out = {0}, right = {0};
    const double u[] = {0.25, 1.5, 1.5}, v[] = {1};
    const double *const knots[] = {u, v};
    kn_status status = make(ctx, &a, 2, 1);
    for (int in_place = 0; in_place < 2 && status == KN_OK; in_place++) {
        kn_spline *to = in_place ? &a : &out, before = *to, before_right = right;
        int which = *(int *)user;
        if (which == 0) status = kn_spline_refine(ctx, to, &a, (int[]){3, 1}, knots);
        if (which == 1) status = kn_spline_reparameterize(ctx, to, &a, 1, 3, 4);
        if (which == 2) status = kn_spline_subdivide(ctx, to, &right, &a, 0, in_place ? 1 : 0.5);
        if (status != KN_OK) {
            assert_memory_equal(&before, to, sizeof before);
            assert_memory_equal(&before_right, &right, sizeof right);
        }
    }
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &out);
    kn_spline_clear(ctx, &right);
    return status;
}

static void little_memory(void **state)
{
    (void)state;
    test_allocation_failures(compatible_in_little_memory, NULL);
    for (int which = 0; which < 3; which++) test_allocation_failures(change_in_little_memory, &which);
}

// The second of two equal calls takes nothing from the allocator: scratch and outputs serve again.
static void steady_state(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline a, out[6] = {{0}};
    const double u[] = {0.25, 1.5, 1.5}, v[] = {1};
    const double *const knots[] = {u, v};
    size_t before = 0;
    assert_int_equal(make(ctx, &a, 2, 1), KN_OK);
    for (int i = 0; i < 2; i++) {
        before = kn_ctx_counters(ctx).allocations;
        assert_int_equal(kn_spline_insert_knots(ctx, &out[0], &a, 0, u, 3), KN_OK);
        assert_int_equal(kn_spline_elevate(ctx, &out[1], &a, (int[]){4, 3}), KN_OK);
        assert_int_equal(kn_spline_refine(ctx, &out[2], &a, (int[]){3, 1}, knots), KN_OK);
        assert_int_equal(kn_spline_subdivide(ctx, &out[3], &out[4], &a, 1, 0.5), KN_OK);
        assert_int_equal(kn_spline_reparameterize(ctx, &out[5], &a, 1, 0, 1), KN_OK);
    }
    assert_int_equal(kn_ctx_counters(ctx).allocations, before);
    for (int i = 0; i < 6; i++) kn_spline_clear(ctx, &out[i]);
    kn_spline_clear(ctx, &a);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_and_a_parabola), cmocka_unit_test(compatible_splines_keep_their_values),
        cmocka_unit_test(compatibility_refuses), cmocka_unit_test(refinement_to_a_grid),
        cmocka_unit_test(reparameterization),    cmocka_unit_test(little_memory),
        cmocka_unit_test(steady_state),
    };
    return cmocka_run_group_tests_name("spline/compatible", tests, NULL, NULL);
}
