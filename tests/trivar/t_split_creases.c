// SPDX-License-Identifier: Apache-2.0
// The pieces of a surface between its creases.
#include "tests/support/surfaces.h"

#include <knurl/construct.h>

#include <math.h>
#include <string.h>

static void clear_pieces(kn_ctx *ctx, kn_spline *pieces, const int counts[2])
{
    for (int i = 0; i < counts[0] * counts[1]; i++) kn_spline_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
}

static int split_counts(kn_ctx *ctx, int counts[2], const kn_spline *s, double angle)
{
    kn_spline *pieces = NULL;
    if (kn_shell_split_creases(ctx, &pieces, counts, s, angle) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    clear_pieces(ctx, pieces, counts);
    return counts[0] * counts[1];
}

// The wall over a polyline in the plane z = 0.
static void make_wall(kn_ctx *ctx, kn_spline *out, int n, const double *points)
{
    kn_spline line = {0};
    const double up[3] = {0, 0, 2};
    *out = (kn_spline){0};
    assert_int_equal(kn_construct_polyline(ctx, &line, 3, n, points), KN_OK);
    assert_int_equal(kn_construct_extruded(ctx, out, &line, up), KN_OK);
    kn_spline_clear(ctx, &line);
}

// A square tube: four sides, S on each bit for bit, neighbours with one edge.
static void a_box(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double corners[15] = {0, 0, 0, 3, 0, 0, 3, 2, 0, 0, 2, 0, 0, 0, 0};
    kn_spline s, *piece = NULL;
    int counts[2];
    make_wall(ctx, &s, 5, corners);
    const int degree[2] = {3, 2}; // C0 knots of higher multiplicity
    for (int run = 0; run < 2; run++) {
        assert_int_equal(kn_shell_split_creases(ctx, &piece, counts, &s, 1e-6), KN_OK);
        assert_int_equal(counts[0], 4);
        assert_int_equal(counts[1], 1);
        for (int k = 0; k < 4; k++) {
            double lo, hi, p[3], q[3], before;
            kn_spline_domain(&piece[k], 0, &lo, &hi);
            if (k > 0) kn_spline_domain(&piece[k - 1], 0, &before, &before);
            if (k > 0) assert_true(lo == before);
            for (int i = 0; i <= 10; i++) {
                double at[2] = {i == 10 ? hi : lo + i * (hi - lo) / 10, i / 10.0};
                if (i == 10 && k < 3) continue; // the next piece's
                assert_int_equal(kn_spline_eval(ctx, p, &s, at), KN_OK);
                assert_int_equal(kn_spline_eval(ctx, q, &piece[k], at), KN_OK);
                assert_memory_equal(p, q, sizeof p);
            }
            size_t row = (size_t)s.count[1], n = kn_spline_count(&piece[k]);
            for (size_t c = 0; c < 3 && k > 0; c++)
                assert_memory_equal(piece[k].coef + c * n,
                                    piece[k - 1].coef + (c + 1) * kn_spline_count(&piece[k - 1]) - row,
                                    row * sizeof(double));
        }
        clear_pieces(ctx, piece, counts);
        assert_int_equal(kn_spline_elevate(ctx, &s, &s, degree), KN_OK);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A fold by exactly 0.3 radians, in either variable, and a surface that jumps.
static void the_angle_counts(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double fold[9] = {-2, 0, 0, 0, 0, 0, cos(0.3), sin(0.3), 0};
    kn_spline s;
    int counts[2];
    make_wall(ctx, &s, 3, fold);
    for (int var = 0; var < 2; var++) {
        const double angle[6] = {0.0, 1e-9, 0.2999, 0.3001, 0.6, 1.57};
        for (int k = 0; k < 6; k++) {
            assert_int_equal(split_counts(ctx, counts, &s, angle[k]), k < 3 ? 2 : 1);
            assert_int_equal(counts[var], k < 3 ? 2 : 1);
        }
        assert_int_equal(kn_spline_permute(ctx, &s, &s, (const int[2]){1, 0}), KN_OK);
    }
    double middle = s.knots[0][2];
    assert_int_equal(kn_spline_insert_knots(ctx, &s, &s, 0, &middle, 1), KN_OK);
    assert_int_equal(split_counts(ctx, counts, &s, 0.4), 1); // degree + 1 knots, both sides meet
    s.coef[4] += 1e-6;
    assert_int_equal(split_counts(ctx, counts, &s, 1.0), 2);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// C0 in parameters and smooth in space: arcs of rational circles, and a spline with a knot of full multiplicity.
static void smooth_shapes_stay_whole(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    int counts[2];
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        assert_int_equal(split_counts(ctx, counts, &s, 1e-9), 1);
        double lo, hi;
        kn_spline_domain(&s, 0, &lo, &hi);
        const double at = lo + 0.375 * (hi - lo), more[5] = {at, at, at, at, at};
        assert_int_equal(kn_spline_insert_knots(ctx, &s, &s, 0, more, s.degree[0]), KN_OK);
        assert_int_equal(split_counts(ctx, counts, &s, 1e-9), 1);
        assert_int_equal(split_counts(ctx, counts, &s, 0.0) > 1, 1);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// A sheet folded along lines of both variables: a grid of pieces. And a crease that flattens out along its line: it
// counts, for it is one somewhere.
static void grids(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double ku[5] = {0, 0, 1, 2, 2}, kv[6] = {0, 0, 1, 2, 3, 3}, *knots[2] = {ku, kv};
    double coef[36];
    for (int i = 0; i < 12; i++) {
        coef[i] = i / 4, coef[12 + i] = i % 4;
        coef[24 + i] = (i / 4 == 1 ? 0.5 : 0) + (i % 4 == 1 ? 0.25 : 0); // smooth at v = 2 no more than at v = 1
    }
    kn_spline s;
    int counts[2];
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[2]){1, 1}, (const int[2]){3, 4}, knots, coef),
                     KN_OK);
    assert_int_equal(split_counts(ctx, counts, &s, 1e-3), 6);
    assert_int_equal(counts[0], 2);
    for (int i = 0; i < 12; i++) s.coef[24 + i] = i / 4 == 1 && i % 4 == 3 ? 0.1 : 0; // flat but for one corner
    assert_int_equal(split_counts(ctx, counts, &s, 1e-3), 4);
    assert_int_equal(counts[0], 2);
    assert_int_equal(counts[1], 2); // v = 2; at v = 1 both sides are flat
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static kn_status split_call(kn_ctx *ctx, void *user)
{
    kn_spline *pieces = NULL;
    int counts[2] = {7, 7};
    kn_status status = kn_shell_split_creases(ctx, &pieces, counts, user, 1e-6);
    assert_true((status == KN_OK) == (pieces != NULL));
    if (status == KN_OK) clear_pieces(ctx, pieces, counts);
    if (status != KN_OK) assert_true(counts[0] == 7 && counts[1] == 7);
    return status;
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double corners[9] = {0, 0, 0, 3, 0, 0, 3, 2, 0};
    kn_spline s, line = {0}, *pieces = NULL;
    int counts[2];
    make_wall(ctx, &s, 3, corners);
    assert_int_equal(kn_construct_polyline(ctx, &line, 3, 3, corners), KN_OK);
    assert_int_equal(kn_shell_split_creases(ctx, &pieces, counts, &line, 0.1), KN_EDOMAIN);
    assert_int_equal(kn_shell_split_creases(ctx, &pieces, counts, &s, -0.1), KN_EDOMAIN);
    assert_int_equal(kn_shell_split_creases(ctx, &pieces, counts, &s, 1.6), KN_EDOMAIN);
    assert_int_equal(kn_shell_split_creases(ctx, &pieces, counts, &s, NAN), KN_EDOMAIN);
    assert_null(pieces);
    test_allocation_failures(split_call, &s);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &line);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box), cmocka_unit_test(the_angle_counts), cmocka_unit_test(smooth_shapes_stay_whole),
        cmocka_unit_test(grids), cmocka_unit_test(failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
