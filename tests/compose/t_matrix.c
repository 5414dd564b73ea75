// SPDX-License-Identifier: Apache-2.0
// kn_compose_matrix: the same as symbolic composition, convex in the unit cell, and equal on shared edges bit for
// bit.
#include "tests/support/support.h"

#include <float.h>
#include <knurl/compose.h>
#include <math.h>
#include <string.h>

static void random_part(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int nvars, const int *degree, double lo,
                        double hi)
{
    assert_int_equal(kn_bezier_init(ctx, out, nvars, 3, false, degree), KN_OK);
    for (size_t i = 0; i < 3 * kn_bezier_count(out); i++) out->coef[i] = test_uniform(rng, lo, hi);
}

static void random_tile(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int m, int n, double lo, double hi)
{
    const int degree[2] = {m, n};
    random_part(ctx, out, rng, 2, degree, lo, hi);
}

// M times the control points of random terms against kn_compose_piece. Both sum the same products; each coefficient
// carries at most gamma(8 (a + b + 1) m) of the sum of absolute terms, here < 400 ulps of it; |P| <= 1 and, in the
// unit cell, the absolute terms of a row sum to 1. Curves, surfaces and volumes.
static void equals_symbolic(void **state)
{
    (void)state;
    test_rng rng = test_random(1);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int run = 0; run < test_scale(12); run++) {
        kn_bezier tile = {0}, out = {0};
        const int of_tile[3] = {test_int(&rng, 1, 3), test_int(&rng, 1, 3), test_int(&rng, 0, 1)};
        random_part(ctx, &tile, &rng, run % 2 == 0 ? 2 : run % 4, of_tile, 0, 1);
        kn_shell_piece piece = {.nterms = 2, .power = {0, 1}};
        kn_compose_matrix m[2];
        for (int k = 0; k < 2; k++) {
            const int degree[2] = {test_int(&rng, 1, 3), test_int(&rng, 1, 3)};
            assert_int_equal(kn_bezier_init(ctx, &piece.term[k], 2, 3, false, degree), KN_OK);
            for (size_t i = 0; i < 3 * kn_bezier_count(&piece.term[k]); i++)
                piece.term[k].coef[i] = test_uniform(&rng, -1, 1);
        }
        assert_int_equal(kn_compose_piece(ctx, &out, &piece, &tile), KN_OK);
        for (int k = 0; k < 2; k++) {
            assert_int_equal(kn_compose_matrix_init(ctx, &m[k], &tile, piece.term[k].degree, k, out.degree, NULL),
                             KN_OK);
            assert_int_equal(m[k].rows, kn_bezier_count(&out));
            assert_int_equal(m[k].cols, kn_bezier_count(&piece.term[k]));
        }
        for (size_t q = 0; q < m[0].rows; q++)
            for (size_t c = 0; c < 3; c++) {
                double sum = 0;
                for (int k = 0; k < 2; k++)
                    for (size_t j = 0; j < m[k].cols; j++)
                        sum += m[k].m[j * m[k].rows + q] * piece.term[k].coef[c * m[k].cols + j];
                assert_true(fabs(sum - out.coef[c * m[0].rows + q]) <= 2 * 400 * DBL_EPSILON);
            }
        for (int k = 0; k < 2; k++) kn_bezier_clear(ctx, &piece.term[k]), kn_compose_matrix_clear(ctx, &m[k]);
        kn_bezier_clear(ctx, &tile), kn_bezier_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// Non-negative with rows that sum to 1 (sum_ab B_a B_b = 1), also when elevated: a convex combination.
static void convex_in_the_unit_cell(void **state)
{
    (void)state;
    test_rng rng = test_random(2);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int run = 0; run < test_scale(10); run++) {
        kn_bezier tile = {0};
        kn_compose_matrix m;
        const int degree[2] = {test_int(&rng, 0, 4), test_int(&rng, 0, 4)};
        random_tile(ctx, &tile, &rng, test_int(&rng, 0, 3), test_int(&rng, 1, 3), 0, 1);
        int sum = degree[0] + degree[1];
        const int rows[2] = {tile.degree[0] * sum + test_int(&rng, 0, 3),
                             tile.degree[1] * sum + test_int(&rng, 0, 3)};
        assert_int_equal(kn_compose_matrix_init(ctx, &m, &tile, degree, 0, rows, NULL), KN_OK);
        for (size_t q = 0; q < m.rows; q++) {
            double row = 0;
            for (size_t j = 0; j < m.cols; j++) {
                assert_true(m.m[j * m.rows + q] >= 0);
                row += m.m[j * m.rows + q];
            }
            assert_true(fabs(row - 1) <= 100 * DBL_EPSILON); // gamma(4 (a + b) + columns)
        }
        kn_compose_matrix_clear(ctx, &m);
        kn_bezier_clear(ctx, &tile);
    }
    test_ctx_end(ctx, &memory);
}

// The place of row q of an edge: side 0 r=0, 1 r=1, 2 t=0, 3 t=1.
static size_t edge_row(const kn_compose_matrix *m, int side, int q)
{
    size_t row = (size_t)m->rows_degree[1] + 1, at = (size_t)q;
    if (side == 1) at += m->rows - row;
    if (side >= 2) at = (size_t)q * row + (side == 3 ? row - 1 : 0);
    return at;
}

// Rows p of a and q of b agree bit for bit.
static void assert_same_rows(const kn_compose_matrix *a, size_t p, const kn_compose_matrix *b, size_t q)
{
    assert_int_equal(a->cols, b->cols);
    for (size_t j = 0; j < a->cols; j++)
        assert_memory_equal(&a->m[j * a->rows + p], &b->m[j * b->rows + q], sizeof(double));
}

static double *edge_coef(kn_bezier *b, int c, int side, int i)
{
    size_t row = (size_t)b->degree[1] + 1, count = kn_bezier_count(b), at = (size_t)i;
    if (side == 1) at += count - row;
    if (side >= 2) at = (size_t)i * row + (side == 3 ? row - 1 : 0);
    return b->coef + (size_t)c * count + at;
}

// Two random patches that share a cubic edge, on any sides and in either direction, have the same rows there.
static void shared_edges_are_equal(void **state)
{
    (void)state;
    test_rng rng = test_random(3);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[2] = {2, 3};
    for (int run = 0; run < 32; run++) {
        int side[2] = {run & 3, (run >> 2) & 3}, power = run & 1;
        bool reversed = run & 16;
        kn_bezier tile[2];
        kn_compose_matrix m[2];
        for (int k = 0; k < 2; k++) random_tile(ctx, &tile[k], &rng, 3, 3, -0.2, 1.2);
        for (int c = 0; c < 3; c++)
            for (int i = 0; i <= 3; i++)
                *edge_coef(&tile[1], c, side[1], reversed ? 3 - i : i) = *edge_coef(&tile[0], c, side[0], i);
        const int rows[2] = {19, 19};
        for (int k = 0; k < 2; k++)
            assert_int_equal(kn_compose_matrix_init(ctx, &m[k], &tile[k], degree, power, rows, NULL), KN_OK);
        for (int q = 0; q <= 19; q++)
            assert_same_rows(&m[0], edge_row(&m[0], side[0], q), &m[1],
                             edge_row(&m[1], side[1], reversed ? 19 - q : q));
        for (int k = 0; k < 2; k++) kn_compose_matrix_clear(ctx, &m[k]), kn_bezier_clear(ctx, &tile[k]);
    }
    test_ctx_end(ctx, &memory);
}

// An edge on u = 1 and the same edge on u = 0 of the next cell: the columns of the common control points are equal,
// all others are zero.
static void edges_across_cells_are_equal(void **state)
{
    (void)state;
    test_rng rng = test_random(4);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[2] = {3, 2}, rows[2] = {18, 18};
    for (int run = 0; run < 8; run++) {
        kn_bezier tile[2];
        kn_compose_matrix m[2];
        int across = run & 1, power = (run >> 1) & 1, step[2] = {3, 1};
        for (int k = 0; k < 2; k++) random_tile(ctx, &tile[k], &rng, 3, 3, 0, 1);
        for (int i = 0; i <= 3; i++) {
            for (int c = 0; c < 3; c++) *edge_coef(&tile[1], c, 0, i) = *edge_coef(&tile[0], c, 1, i);
            *edge_coef(&tile[0], across, 1, i) = 1;
            *edge_coef(&tile[1], across, 0, i) = 0;
        }
        for (int k = 0; k < 2; k++)
            assert_int_equal(kn_compose_matrix_init(ctx, &m[k], &tile[k], degree, power, rows, NULL), KN_OK);
        for (int q = 0; q <= 18; q++) {
            const double *far = m[0].m + edge_row(&m[0], 1, q), *near = m[1].m + edge_row(&m[1], 0, q);
            for (int a = 0; a <= 3; a++)
                for (int b = 0; b <= 2; b++) {
                    int at = 3 * a + b, place = across == 0 ? a : b, most = degree[across];
                    size_t opposite = (size_t)(at - most * step[across]) * m[1].rows;
                    if (place < most) assert_true(far[(size_t)at * m[0].rows] == 0);
                    if (place > 0) assert_true(near[(size_t)at * m[1].rows] == 0);
                    if (place == most) assert_true(far[(size_t)at * m[0].rows] == near[opposite]);
                }
        }
        for (int k = 0; k < 2; k++) kn_compose_matrix_clear(ctx, &m[k]), kn_bezier_clear(ctx, &tile[k]);
    }
    test_ctx_end(ctx, &memory);
}

// Coefficient (i, j) of the face var = end of a volume, in the order of the other two variables.
static size_t on_face(const int *degree, int var, int end, int i, int j)
{
    int at[3], other = var == 0 ? 1 : 0;
    at[var] = end * degree[var];
    at[other] = i, at[3 - var - other] = j;
    return ((size_t)at[0] * (size_t)(degree[1] + 1) + (size_t)at[1]) * (size_t)(degree[2] + 1) + (size_t)at[2];
}

// Two random volumes that share a face, on any sides and turned in any of eight ways, have the same rows there.
static void shared_faces_are_equal(void **state)
{
    (void)state;
    test_rng rng = test_random(5);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int cell[2] = {1, 2}, degree[3] = {2, 2, 2}, rows[3] = {8, 8, 8};
    for (int run = 0; run < 16; run++) {
        kn_bezier tile[2];
        kn_compose_matrix m[2];
        int var[2] = {test_int(&rng, 0, 2), test_int(&rng, 0, 2)}, end[2] = {run & 1, (run >> 1) & 1};
        int turn = test_int(&rng, 0, 7);
        for (int k = 0; k < 2; k++) random_part(ctx, &tile[k], &rng, 3, degree, -0.2, 1.2);
        for (int size = 2; size <= 8; size += 6) { // of control points, then of rows
            const int *of = size == 2 ? degree : rows;
            for (int k = 0; size == 8 && k < 2; k++)
                assert_int_equal(kn_compose_matrix_init(ctx, &m[k], &tile[k], cell, 1, rows, NULL), KN_OK);
            for (int i = 0; i <= size; i++)
                for (int j = 0; j <= size; j++) {
                    int a = turn & 1 ? size - i : i, b = turn & 2 ? size - j : j;
                    size_t p = on_face(of, var[0], end[0], i, j);
                    size_t q = on_face(of, var[1], end[1], turn & 4 ? b : a, turn & 4 ? a : b);
                    for (size_t c = 0; size == 2 && c < 3; c++) tile[1].coef[27 * c + q] = tile[0].coef[27 * c + p];
                    if (size == 8) assert_same_rows(&m[0], p, &m[1], q);
                }
        }
        for (int k = 0; k < 2; k++) kn_compose_matrix_clear(ctx, &m[k]), kn_bezier_clear(ctx, &tile[k]);
    }
    test_ctx_end(ctx, &memory);
}

// The ends of a curve have the rows of the corners where it meets them.
static void curves_are_edges(void **state)
{
    (void)state;
    test_rng rng = test_random(6);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int cell[2] = {2, 1}, three[2] = {3, 3}, rows[2] = {12, 12};
    for (int side = 0; side < 4; side++) {
        kn_bezier surface = {0}, curve = {0};
        kn_compose_matrix m[2];
        random_part(ctx, &surface, &rng, 2, three, -0.2, 1.2);
        random_part(ctx, &curve, &rng, 1, three, 0, 1);
        for (int c = 0; c < 3; c++)
            for (int i = 0; i <= 3; i++) curve.coef[4 * c + i] = *edge_coef(&surface, c, side, i);
        assert_int_equal(kn_compose_matrix_init(ctx, &m[0], &surface, cell, 1, rows, NULL), KN_OK);
        assert_int_equal(kn_compose_matrix_init(ctx, &m[1], &curve, cell, 1, rows, NULL), KN_OK);
        for (int q = 0; q <= 12; q += 12) // inside, a curve keeps its own direction
            assert_same_rows(&m[0], edge_row(&m[0], side, q), &m[1], (size_t)q);
        for (int k = 0; k < 2; k++) kn_compose_matrix_clear(ctx, &m[k]);
        kn_bezier_clear(ctx, &surface), kn_bezier_clear(ctx, &curve);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[64] = {[0] = 1, [4] = 1, [8] = 1}; // (1 - r)(1 - t) in each component
    kn_bezier tile = {.nvars = 2, .ncomp = 3, .degree = {1, 1}, .coef = c}, other = tile;
    kn_compose_matrix m = {.rows = 7};
    const int degree[2] = {2, 2}, rows[2] = {5, 5}, few[2] = {5, 4}, many[2] = {57, 5}, negative[2] = {2, -1};
    assert_int_equal(kn_compose_matrix_init(ctx, &m, &tile, degree, 1, few, NULL), KN_EDOMAIN);
    assert_int_equal(kn_compose_matrix_init(ctx, &m, &tile, degree, 1, many, NULL), KN_ELIMIT);
    assert_int_equal(kn_compose_matrix_init(ctx, &m, &tile, negative, 1, rows, NULL), KN_EDOMAIN);
    assert_int_equal(kn_compose_matrix_init(ctx, &m, &tile, degree, -1, rows, NULL), KN_EDOMAIN);
    assert_int_equal(kn_compose_matrix_init(ctx, &m, &tile, degree, 1000000000, rows, NULL), KN_ELIMIT);
    other.ncomp = 4, other.rational = true;
    assert_int_equal(kn_compose_matrix_init(ctx, &m, &other, degree, 1, rows, NULL), KN_EDOMAIN);
    other = tile, other.nvars = 4;
    assert_int_equal(kn_compose_matrix_init(ctx, &m, &other, degree, 1, rows, NULL), KN_EDOMAIN);
    assert_true(m.rows == 7 && !m.m);
    kn_compose_matrix_clear(ctx, NULL);
    test_ctx_end(ctx, &memory);
}

static kn_status matrix_call(kn_ctx *ctx, void *user)
{
    (void)user;
    double c[12] = {0, 1, 0, 1, 0, 0, 1, 1, 1, 0, 0, 1};
    const int degree[2] = {1, 1}, rows[2] = {3, 3};
    kn_bezier tile = {.nvars = 2, .ncomp = 3, .degree = {1, 1}, .coef = c};
    kn_compose_matrix m = {0};
    kn_status status = kn_compose_matrix_init(ctx, &m, &tile, degree, 1, rows, NULL);
    assert_true((status == KN_OK) == (m.m != NULL));
    kn_compose_matrix_clear(ctx, &m);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_allocation_failures(matrix_call, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(equals_symbolic),
                                       cmocka_unit_test(convex_in_the_unit_cell),
                                       cmocka_unit_test(shared_edges_are_equal),
                                       cmocka_unit_test(edges_across_cells_are_equal),
                                       cmocka_unit_test(shared_faces_are_equal),
                                       cmocka_unit_test(curves_are_edges),
                                       cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("compose/matrix", tests, NULL, NULL);
}
