// SPDX-License-Identifier: Apache-2.0
// kn_bezier_compose, kn_compose_piece: symbolic composition against direct evaluation.
#include "tests/support/support.h"

#include "compose/nest.h"

#include <knurl/compose.h>
#include <math.h>
#include <string.h>

// The value and a size for its rounding: sum_i |coef_i| |B_i|, both over the weight.
static void long_eval(long double *out, long double *size, const kn_bezier *b, const long double *at)
{
    size_t n = kn_bezier_count(b);
    int dim = kn_bezier_dim(b);
    long double value[KN_MAX_COMPS] = {0}, most[KN_MAX_COMPS] = {0};
    for (size_t i = 0; i < n; i++) {
        long double f = 1;
        size_t rest = i;
        for (int d = b->nvars - 1; d >= 0; d--) {
            int p = b->degree[d], k = (int)(rest % (size_t)(p + 1));
            rest /= (size_t)(p + 1);
            long double c = 1;
            for (int j = 1; j <= k; j++) c = c * (p - k + j) / j;
            f *= c * powl(at[d], k) * powl(1 - at[d], p - k);
        }
        for (int c = 0; c < b->ncomp; c++) {
            value[c] += f * b->coef[(size_t)c * n + i];
            most[c] += fabsl(f * b->coef[(size_t)c * n + i]);
        }
    }
    for (int c = 0; c < dim; c++) {
        out[c] = b->rational ? value[c] / value[dim] : value[c];
        size[c] = b->rational ? (most[c] + fabsl(out[c]) * most[dim]) / fabsl(value[dim]) : most[c];
    }
}

static void random_piece(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int nvars, int dim, bool rational, int most,
                         double lo, double hi)
{
    int degree[KN_MAX_VARS];
    for (int d = 0; d < nvars; d++) degree[d] = test_int(rng, 1, most);
    assert_int_equal(kn_bezier_init(ctx, out, nvars, dim + rational, rational, degree), KN_OK);
    size_t n = kn_bezier_count(out);
    for (size_t i = 0; i < n; i++) {
        double w = rational ? test_uniform(rng, 0.5, 2.0) : 1.0;
        for (int c = 0; c < dim; c++) out->coef[(size_t)c * n + i] = w * test_uniform(rng, lo, hi);
        if (rational) out->coef[(size_t)dim * n + i] = w;
    }
}

// out(x) against outer(inner(x)) in long double at random x, relative to the size of the values.
static void check_composed(const kn_bezier *out, const kn_bezier *outer, const kn_bezier *inner, test_rng *rng,
                           double tolerance)
{
    for (int run = 0; run < 4; run++) {
        long double x[KN_MAX_VARS], y[KN_MAX_COMPS], z[KN_MAX_COMPS], got[KN_MAX_COMPS];
        long double unused[KN_MAX_COMPS], size[KN_MAX_COMPS];
        for (int d = 0; d < inner->nvars; d++) x[d] = test_uniform(rng, 0, 1);
        long_eval(y, unused, inner, x);
        long_eval(z, size, outer, y);
        long_eval(got, unused, out, x);
        for (int c = 0; c < kn_bezier_dim(outer); c++) assert_true(fabsl(got[c] - z[c]) <= tolerance * size[c]);
    }
}

// Inner values stay in the unit box, where every factor is non-negative and errors stay relative: with degree sums up
// to 10 and products of at most three factors each, 1e-13 is 450 ulps, gamma of all steps together.
static void matches_direct_evaluation(void **state)
{
    (void)state;
    test_rng rng = test_random(1);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int run = 0; run < test_scale(80); run++) {
        kn_bezier outer = {0}, inner = {0}, out = {0};
        int vars = test_int(&rng, 1, 3), x = test_int(&rng, 1, vars == 3 ? 2 : 3);
        random_piece(ctx, &outer, &rng, vars, test_int(&rng, 1, 3), run % 2 == 1, 3, -1, 1);
        random_piece(ctx, &inner, &rng, x, vars, run % 4 >= 2, 2, 0, 1);
        assert_int_equal(kn_bezier_compose(ctx, &out, &outer, &inner), KN_OK);
        int sum = 0;
        for (int d = 0; d < vars; d++) sum += outer.degree[d];
        assert_int_equal(out.nvars, x);
        assert_int_equal(out.rational, run % 4 != 0);
        assert_int_equal(kn_bezier_dim(&out), kn_bezier_dim(&outer));
        for (int d = 0; d < x; d++) assert_int_equal(out.degree[d], sum * inner.degree[d]);
        check_composed(&out, &outer, &inner, &rng, 1e-13);
        kn_bezier_clear(ctx, &outer), kn_bezier_clear(ctx, &inner), kn_bezier_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// f(x) = x^2 with x = 3 + 5t as Bernstein coefficients 0, 0, 1 and 3, 8 gives 9, 24, 64.
static void exact_on_integers(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double square[] = {0, 0, 1}, line[] = {3, 8};
    kn_bezier outer = {.nvars = 1, .ncomp = 1, .degree = {2}, .coef = square};
    kn_bezier inner = {.nvars = 1, .ncomp = 1, .degree = {1}, .coef = line}, out = {0};
    assert_int_equal(kn_bezier_compose(ctx, &out, &outer, &inner), KN_OK);
    assert_int_equal(out.degree[0], 2);
    assert_true(out.coef[0] == 9 && out.coef[1] == 24 && out.coef[2] == 64);
    // in place, with 1 - 2x
    double flip[] = {1, -1};
    outer = (kn_bezier){.nvars = 1, .ncomp = 1, .degree = {1}, .coef = flip};
    assert_int_equal(kn_bezier_compose(ctx, &out, &outer, &out), KN_OK);
    assert_true(out.degree[0] == 2 && out.coef[0] == -17 && out.coef[1] == -47 && out.coef[2] == -127);
    kn_bezier_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// The fast nest against the plain reference, both with relative errors inside the unit cell: up to eight variables
// of either, constants and points among them. Degree sums stay below 13: both errors below 2^9 u.
static void equals_the_reference(void **state)
{
    (void)state;
    test_rng rng = test_random(3);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int run = 0; run < test_scale(40); run++) {
        kn_bezier outer = {0}, inner = {0}, fast = {0}, plain = {0};
        int most = run % 4 == 0 ? KN_MAX_VARS : 3, vars = test_int(&rng, 1, most), x = test_int(&rng, 0, most),
            degree[8];
        bool rational = run & 1;
        for (int d = 0; d < 8; d++) degree[d] = most > 3 ? d % 3 == 0 : test_int(&rng, 0, 4);
        assert_int_equal(kn_bezier_init(ctx, &outer, vars, 2, false, degree), KN_OK);
        for (int d = 0; d < 8; d++) degree[d] = most > 3 ? d == x - 1 || d == 0 : test_int(&rng, 0, 2);
        assert_int_equal(kn_bezier_init(ctx, &inner, x, vars + rational, rational, degree), KN_OK);
        size_t n = kn_bezier_count(&inner);
        for (size_t i = 0; i < 2 * kn_bezier_count(&outer); i++) outer.coef[i] = test_uniform(&rng, 0.5, 1);
        for (size_t i = 0; i < n; i++) {
            double w = rational ? test_uniform(&rng, 0.5, 2) : 1;
            for (int c = 0; c < vars; c++) inner.coef[(size_t)c * n + i] = w * test_uniform(&rng, 0, 1);
            if (rational) inner.coef[(size_t)vars * n + i] = w;
        }
        assert_int_equal(kn_bezier_compose(ctx, &fast, &outer, &inner), KN_OK);
        assert_int_equal(kn_compose_plain(ctx, &plain, &outer, &inner), KN_OK);
        assert_true(fast.ncomp == plain.ncomp && fast.nvars == plain.nvars && fast.rational == plain.rational);
        assert_int_equal(kn_bezier_count(&fast), kn_bezier_count(&plain));
        for (size_t i = 0; i < kn_bezier_count(&fast) * (size_t)fast.ncomp; i++)
            assert_true(fabs(fast.coef[i] - plain.coef[i]) <= 0x1p-43 * plain.coef[i]);
        kn_bezier_clear(ctx, &outer), kn_bezier_clear(ctx, &inner);
        kn_bezier_clear(ctx, &fast), kn_bezier_clear(ctx, &plain);
    }
    test_ctx_end(ctx, &memory);
}

// Once out and the scratch memory have their sizes; rational or not, in place of an operand of that size too.
static void repeated_calls_allocate_nothing(void **state)
{
    (void)state;
    test_rng rng = test_random(4);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier outer[2] = {{0}}, inner[2] = {{0}}, g = {0}, out[6] = {{0}};
    const int three[3] = {3, 3, 1}, one[1] = {2};
    for (int i = 0; i < 2; i++) {
        test_random_bezier(ctx, &outer[i], &rng, 3, 3 + i, i, three, 3);
        test_random_bezier(ctx, &inner[i], &rng, 2, 3 + i, i, three, 3);
    }
    test_random_bezier(ctx, &g, &rng, 1, 2, true, one, 3);
    size_t before = 0;
    for (int run = 0; run < 5; run++) {
        if (run == 2) before = kn_ctx_counters(ctx).allocations;
        for (int i = 0; i < 4; i++)
            assert_int_equal(kn_bezier_compose(ctx, &out[i], &outer[i & 1], &inner[i >> 1]), KN_OK);
        assert_int_equal(kn_bezier_substitute(ctx, &out[4], &outer[0], 1, &g), KN_OK);
        assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &out[5], &outer[1], &inner[1], three), KN_OK);
    }
    assert_int_equal(kn_ctx_counters(ctx).allocations, before);
    for (int i = 0; i < 2; i++) kn_bezier_clear(ctx, &outer[i]), kn_bezier_clear(ctx, &inner[i]);
    for (int i = 0; i < 6; i++) kn_bezier_clear(ctx, &out[i]);
    kn_bezier_clear(ctx, &g);
    test_ctx_end(ctx, &memory);
}

// Multiply-adds by hand, of a cubic function of a linear one: with one component its 4 basis functions are expanded,
// 2 x 2 + 3 x 4 + 4 x 6 products' terms and 4 x 4 sums; put in, the halves are x (c_2 s + c_3 x) x and so on.
static void counts_multiply_adds(void **state)
{
    (void)state;
    kn_bezier outer = {.nvars = 1, .ncomp = 1, .degree = {3}}, inner = {.nvars = 1, .ncomp = 1, .degree = {1}};
    kn_nest nest;
    kn_nest_plan(&nest, &outer, &inner);
    assert_int_equal(nest.expanded, 1);
    assert_true(kn_nest_cost(&nest, 1) == 2 * 2 + 3 * 4 + 4 * 6 + 4 * 4);
    nest.expanded = 0; // 4 coefficients times 2; both halves times 2 twice: of degrees 1 and 2
    assert_true(kn_nest_cost(&nest, 1) == 4 + 4 * 2 + 2 * 2 * 2 + 2 * 3 * 2);
}

// The piece of a shell by hand: S and n of their own degrees, T = S + w n. Out of the unit cell too.
static kn_shell_piece make_piece(kn_ctx *ctx, test_rng *rng, bool rational, int most)
{
    kn_shell_piece piece = {.nterms = 2, .power = {0, test_int(rng, 1, 3)}, .exact = true};
    random_piece(ctx, &piece.term[0], rng, 2, 3, rational, most, -2, 2);
    random_piece(ctx, &piece.term[1], rng, 2, 3, false, most, -1, 1);
    if (!rational) return piece;
    // T = (P + w n W)/W: the second term is W n, with weight 0.
    kn_bezier w = {0}, all = {0};
    assert_int_equal(kn_bezier_components(ctx, &w, &piece.term[0], 3, 1), KN_OK);
    assert_int_equal(kn_bezier_product(ctx, &piece.term[1], &w, &piece.term[1]), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &all, 2, 4, true, piece.term[1].degree), KN_OK);
    memcpy(all.coef, piece.term[1].coef, 3 * kn_bezier_count(&all) * sizeof(double));
    kn_bezier_swap(&all, &piece.term[1]);
    kn_bezier_clear(ctx, &w), kn_bezier_clear(ctx, &all);
    return piece;
}

static void clear_piece(kn_ctx *ctx, kn_shell_piece *piece)
{
    for (int k = 0; k < piece->nterms; k++) kn_bezier_clear(ctx, &piece->term[k]);
}

// T at (u, v, w) by long double, and the size of its terms.
static void eval_piece(long double *out, long double *size, const kn_shell_piece *piece, const long double *at)
{
    long double sum[4] = {0}, most[4] = {0};
    for (int k = 0; k < 2; k++) {
        kn_bezier term = piece->term[k];
        long double value[4] = {0}, terms[4] = {0}, f = powl(at[2], piece->power[k]);
        term.rational = false;
        long_eval(value, terms, &term, at);
        for (int c = 0; c < term.ncomp; c++) sum[c] += f * value[c], most[c] += fabsl(f) * terms[c];
    }
    bool rational = piece->term[0].rational;
    for (int c = 0; c < 3; c++) {
        out[c] = rational ? sum[c] / sum[3] : sum[c];
        size[c] = rational ? (most[c] + fabsl(out[c]) * most[3]) / fabsl(sum[3]) : most[c];
    }
}

// Random tiles and surfaces of degrees 1 .. 5, within KN_MAX_DEGREE: relative error below 1e-12.
static void piece_matches_direct_evaluation(void **state)
{
    (void)state;
    test_rng rng = test_random(2);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int run = 0; run < test_scale(25); run++) {
        int most = 1 + run % 5;
        kn_shell_piece piece = make_piece(ctx, &rng, run % 3 == 2, most);
        int r0 = piece.term[0].degree[0] + piece.term[0].degree[1];
        int r1 = piece.term[1].degree[0] + piece.term[1].degree[1] + piece.power[1];
        int need = r0 > r1 ? r0 : r1, fit = KN_MAX_DEGREE / need;
        kn_bezier tile = {0}, out = {0};
        random_piece(ctx, &tile, &rng, 2, 3, false, fit < most ? fit : most, 0, 1);
        for (size_t i = 0; i < kn_bezier_count(&tile); i++) tile.coef[2 * kn_bezier_count(&tile) + i] *= 0.3;
        assert_int_equal(kn_compose_piece(ctx, &out, &piece, &tile), KN_OK);
        assert_int_equal(out.degree[0], need * tile.degree[0]);
        assert_int_equal(out.degree[1], need * tile.degree[1]);
        assert_int_equal(out.rational, piece.term[0].rational);
        for (int k = 0; k < 5; k++) {
            long double x[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, d[3], t[3], got[3];
            long double unused[3], size[3];
            long_eval(d, unused, &tile, x);
            eval_piece(t, size, &piece, d);
            long_eval(got, unused, &out, x);
            for (int c = 0; c < 3; c++) assert_true(fabsl(got[c] - t[c]) <= 1e-12L * size[c]);
        }
        clear_piece(ctx, &piece);
        kn_bezier_clear(ctx, &tile), kn_bezier_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[64] = {0};
    kn_bezier surface = {.nvars = 2, .ncomp = 3, .degree = {3, 3}, .coef = c}, out = {0}, empty = {0};
    kn_bezier line = {.nvars = 1, .ncomp = 1, .degree = {1}, .coef = c};
    kn_bezier plane = {.nvars = 1, .ncomp = 2, .degree = {10}, .coef = c};
    assert_int_equal(kn_bezier_compose(ctx, &out, &surface, &line), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose(ctx, &out, &empty, &line), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose(ctx, &out, &surface, &empty), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_compose(ctx, &out, &surface, &plane), KN_ELIMIT); // (3 + 3) 10 = 60
    assert_non_null(strstr(kn_ctx_message(ctx), "degree 60"));
    assert_null(out.coef);

    kn_bezier many = {.nvars = 1, .ncomp = KN_MAX_COMPS, .degree = {0}, .coef = c};
    kn_bezier weighted = {.nvars = 1, .ncomp = 2, .rational = true, .degree = {1}, .coef = c};
    assert_int_equal(kn_bezier_compose(ctx, &out, &many, &weighted), KN_ELIMIT); // and a weight
    assert_null(out.coef);

    kn_shell_piece piece = {.nterms = 2, .power = {0, 1}, .term = {surface, surface}};
    assert_int_equal(kn_compose_piece(ctx, &out, &piece, &plane), KN_EDOMAIN);
    kn_bezier rational = {.nvars = 2, .ncomp = 4, .rational = true, .degree = {1, 1}, .coef = c};
    assert_int_equal(kn_compose_piece(ctx, &out, &piece, &rational), KN_EDOMAIN);
    kn_bezier tile = {.nvars = 2, .ncomp = 3, .degree = {1, 1}, .coef = c};
    piece.term[1].ncomp = 2;
    assert_int_equal(kn_compose_piece(ctx, &out, &piece, &tile), KN_EDOMAIN);
    piece.nterms = 0;
    assert_int_equal(kn_compose_piece(ctx, &out, &piece, &tile), KN_EDOMAIN);
    tile.degree[0] = 9; // (3 + 3 + 1) 9 = 63
    piece = (kn_shell_piece){.nterms = 2, .power = {0, 1}, .term = {surface, surface}};
    assert_int_equal(kn_compose_piece(ctx, &out, &piece, &tile), KN_ELIMIT);
    assert_null(out.coef);
    test_ctx_end(ctx, &memory);
}

static kn_status compose_call(kn_ctx *ctx, void *user)
{
    double o[] = {1, 2, 3, 4, 5, 6, 7, 8, 1, 1, 2, 1}, i[] = {0, 1, 2, 1, 1, 2};
    bool rational = *(bool *)user;
    kn_bezier outer = {.nvars = 2, .ncomp = rational ? 3 : 2, .rational = rational, .degree = {1, 1}, .coef = o};
    kn_bezier inner = {.nvars = 1, .ncomp = rational ? 2 : 3, .rational = !rational, .degree = {1}, .coef = i};
    kn_bezier out = {0};
    kn_status status = kn_bezier_compose(ctx, &out, &outer, &inner);
    assert_true((status == KN_OK) == (out.coef != NULL));
    kn_bezier_clear(ctx, &out);
    return status;
}

static kn_status piece_call(kn_ctx *ctx, void *user)
{
    double s[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 1}, n[3] = {0, 0, 1}, d[6] = {0, 1, 0, 1, 0, 1};
    (void)user;
    kn_shell_piece piece = {.nterms = 2,
                            .power = {0, 1},
                            .term = {{.nvars = 2, .ncomp = 3, .degree = {1, 1}, .coef = s},
                                     {.nvars = 2, .ncomp = 3, .degree = {0, 0}, .coef = n}}};
    kn_bezier tile = {.nvars = 2, .ncomp = 3, .degree = {1, 0}, .coef = d}, out = {0};
    kn_status status = kn_compose_piece(ctx, &out, &piece, &tile);
    assert_true((status == KN_OK) == (out.coef != NULL));
    kn_bezier_clear(ctx, &out);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    bool yes = true, no = false;
    test_allocation_failures(compose_call, &yes);
    test_allocation_failures(compose_call, &no);
    test_allocation_failures(piece_call, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(matches_direct_evaluation),
                                       cmocka_unit_test(exact_on_integers),
                                       cmocka_unit_test(equals_the_reference),
                                       cmocka_unit_test(repeated_calls_allocate_nothing),
                                       cmocka_unit_test(counts_multiply_adds),
                                       cmocka_unit_test(piece_matches_direct_evaluation),
                                       cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("compose/compose", tests, NULL, NULL);
}
