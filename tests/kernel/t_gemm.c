// SPDX-License-Identifier: Apache-2.0
// kernel/gemm: values, bounds, and independence of the shape of calls.
#include "tests/support/support.h"

#include "kernel/gemm.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct problem {
    size_t rows, k, n;
    double *a, *b, *c, *packed, *work; // row-major; c has a guard number after each row
    double **c_row;
    const double **a_row;
} problem;

static problem make(size_t rows, size_t k, size_t n)
{
    problem p = {.rows = rows, .k = k, .n = n};
    p.a = calloc(rows * k + 1, sizeof(double));
    p.b = calloc(k * n + 1, sizeof(double));
    p.c = calloc(rows * (n + 1) + 1, sizeof(double));
    p.packed = calloc(kn_gemm_room(k, n) + 1, sizeof(double));
    p.work = calloc(rows * k + 1, sizeof(double));
    p.c_row = calloc(rows + 1, sizeof *p.c_row);
    p.a_row = calloc(rows + 1, sizeof *p.a_row);
    assert_true(p.a && p.b && p.c && p.packed && p.work && p.c_row && p.a_row);
    for (size_t i = 0; i < rows; i++) {
        p.c_row[i] = p.c + i * (n + 1);
        p.a_row[i] = p.a + i * k;
    }
    return p;
}

static void end(problem *p)
{
    free(p->a), free(p->b), free(p->c), free(p->packed), free(p->work), free(p->c_row), free(p->a_row);
}

static bool has(kn_gemm_kind kind)
{
    return kind <= kn_gemm_best();
}

// Small integers: every sum is exact, so all kinds answer the same and equal the definition.
static void exact_on_integers(void **state)
{
    (void)state;
    test_rng rng = test_random(1);
    for (int run = 0; run < test_scale(60); run++) {
        problem p = make((size_t)test_int(&rng, 0, 29), (size_t)test_int(&rng, 0, 9), (size_t)test_int(&rng, 1, 50));
        for (size_t i = 0; i < p.rows * p.k; i++) p.a[i] = test_int(&rng, -9, 9);
        for (size_t i = 0; i < p.k * p.n; i++) p.b[i] = test_int(&rng, -9, 9);
        kn_gemm_pack(p.packed, p.b, p.k, p.n, p.n, 1);
        for (kn_gemm_kind kind = KN_GEMM_PLAIN; kind < KN_GEMM_KINDS; kind++) {
            if (!has(kind)) continue;
            for (size_t i = 0; i < p.rows * (p.n + 1); i++) p.c[i] = (double)(i % 7);
            kn_gemm_as(kind, p.c_row, p.a_row, p.rows, p.packed, p.k, p.n, p.work);
            for (size_t i = 0; i < p.rows; i++) {
                for (size_t j = 0; j < p.n; j++) {
                    double sum = 0.0; // whatever C was before
                    for (size_t q = 0; q < p.k; q++) sum += p.a[i * p.k + q] * p.b[q * p.n + j];
                    assert_true(p.c_row[i][j] == sum);
                }
                assert_true(p.c_row[i][p.n] == (double)((i * (p.n + 1) + p.n) % 7)); // nothing beyond the row
            }
        }
        end(&p);
    }
}

// A transposed B packs to the same bytes.
static void packs_strided(void **state)
{
    (void)state;
    problem p = make(1, 5, 19), t = make(1, 19, 5);
    for (size_t i = 0; i < 5; i++)
        for (size_t j = 0; j < 19; j++) p.b[i * 19 + j] = t.b[j * 5 + i] = (double)(100 * i + j);
    kn_gemm_pack(p.packed, p.b, 5, 19, 19, 1);
    double *again = calloc(kn_gemm_room(5, 19), sizeof(double));
    assert_non_null(again);
    kn_gemm_pack(again, t.b, 5, 19, 1, 5);
    assert_memory_equal(again, p.packed, kn_gemm_room(5, 19) * sizeof(double));
    memset(again, 0x7f, kn_gemm_room(5, 19) * sizeof(double));
    kn_gemm_pack_some(again, t.b + 2, 5, 2, 3, 19, 1, 5); // rows 2 to 4, then the others
    kn_gemm_pack_some(again, t.b, 5, 0, 2, 19, 1, 5);
    assert_memory_equal(again, p.packed, kn_gemm_room(5, 19) * sizeof(double));
    free(again);
    end(&p);
    end(&t);
}

// |c - exact| <= gamma(k + 1) sum |a||b| for one order of summation with or without fused operations, so two kinds
// differ by at most twice that. The products and sums of `exact` carry 11 more bits.
static void kinds_agree_within_the_bound(void **state)
{
    (void)state;
    test_rng rng = test_random(2);
    problem p = make(37, 52, 121);
    for (size_t i = 0; i < p.rows * p.k; i++) p.a[i] = test_uniform(&rng, -1, 1);
    for (size_t i = 0; i < p.k * p.n; i++) p.b[i] = test_uniform(&rng, -1, 1);
    kn_gemm_pack(p.packed, p.b, p.k, p.n, p.n, 1);
    for (kn_gemm_kind kind = KN_GEMM_PLAIN; kind < KN_GEMM_KINDS; kind++) {
        if (!has(kind)) continue;
        memset(p.c, 0x7f, p.rows * (p.n + 1) * sizeof(double));
        kn_gemm_as(kind, p.c_row, p.a_row, p.rows, p.packed, p.k, p.n, p.work);
        for (size_t i = 0; i < p.rows; i++)
            for (size_t j = 0; j < p.n; j++) {
                long double sum = 0, size = 0;
                for (size_t q = 0; q < p.k; q++) {
                    long double term = (long double)p.a[i * p.k + q] * (long double)p.b[q * p.n + j];
                    sum += term;
                    size += fabsl(term);
                }
                long double bound = (long double)(p.k + 2) * (DBL_EPSILON / 2) * size;
                assert_true(fabsl((long double)p.c_row[i][j] - sum) <= bound);
            }
    }
    end(&p);
}

// A row's result does not depend on the rows beside it, and a column's not on how many columns there are.
static void independent_of_blocks(void **state)
{
    (void)state;
    test_rng rng = test_random(3);
    problem p = make(26, 33, 45), one = make(26, 33, 45);
    for (size_t i = 0; i < p.rows * p.k; i++) p.a[i] = test_uniform(&rng, -1, 1);
    for (size_t i = 0; i < p.k * p.n; i++) p.b[i] = test_uniform(&rng, -1, 1);
    kn_gemm_pack(p.packed, p.b, p.k, p.n, p.n, 1);
    for (kn_gemm_kind kind = KN_GEMM_PLAIN; kind < KN_GEMM_KINDS; kind++) {
        if (!has(kind)) continue;
        memset(p.c, 0x7f, p.rows * (p.n + 1) * sizeof(double));
        memset(one.c, 0x7f, p.rows * (p.n + 1) * sizeof(double));
        kn_gemm_as(kind, p.c_row, p.a_row, p.rows, p.packed, p.k, p.n, p.work);
        for (size_t i = 0; i < p.rows; i++)
            kn_gemm_as(kind, one.c_row + i, p.a_row + i, 1, p.packed, p.k, p.n, p.work);
        assert_memory_equal(one.c, p.c, p.rows * (p.n + 1) * sizeof(double));

        kn_gemm_pack(one.packed, p.b, p.k, 20, p.n, 1);
        memset(one.c, 0x7f, p.rows * (p.n + 1) * sizeof(double));
        kn_gemm_as(kind, one.c_row, p.a_row, p.rows, one.packed, p.k, 20, p.work);
        for (size_t i = 0; i < p.rows; i++) assert_memory_equal(one.c_row[i], p.c_row[i], 20 * sizeof(double));
    }
    end(&p);
    end(&one);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(exact_on_integers), cmocka_unit_test(packs_strided),
                                       cmocka_unit_test(kinds_agree_within_the_bound),
                                       cmocka_unit_test(independent_of_blocks)};
    return cmocka_run_group_tests_name("kernel/gemm", tests, NULL, NULL);
}
