// SPDX-License-Identifier: Apache-2.0
// Shells with a thickness, a direction and an attraction given as splines.
#include "tests/support/kinds.h"

#include <math.h>
#include <string.h>

// The kinds: bit 0 a thickness, bit 1 a direction, bit 2 an attraction with w^power.
typedef struct kind {
    kn_spline s, h, d, psi;
    kn_shell_options o;
    kn_shell *shell;
} kind;

static void kind_options(kn_ctx *ctx, kind *k, test_rng *rng, int bits, int power)
{
    make_field(ctx, &k->h, rng, &k->s, 2, 1, 1.0, 0.4);
    make_field(ctx, &k->d, rng, &k->s, 1, 3, 0.5, 0.5);
    make_field(ctx, &k->psi, rng, &k->s, 1, 3, 0.0, 0.3);
    k->o = (kn_shell_options){.normal_tol = 1e-3, .attraction_power = power};
    if (bits & 1) k->o.thickness = &k->h;
    if (bits & 2) k->o.direction = &k->d;
    if (bits & 4) k->o.attraction = &k->psi;
}

static void kind_init(kn_ctx *ctx, kind *k, test_rng *rng, int surface, int bits, int power)
{
    *k = (kind){.shell = NULL};
    surface_cases[surface].make(ctx, &k->s);
    kind_options(ctx, k, rng, bits, power);
    if (kn_shell_create(ctx, &k->shell, &k->s, &k->o) != KN_OK)
        fail_msg("%s, kind %d: %s", surface_cases[surface].name, bits, kn_ctx_message(ctx));
}

static void kind_clear(kn_ctx *ctx, kind *k)
{
    kn_shell_destroy(ctx, k->shell);
    kn_spline_clear(ctx, &k->s), kn_spline_clear(ctx, &k->h);
    kn_spline_clear(ctx, &k->d), kn_spline_clear(ctx, &k->psi);
}

static void random_place(double at[2], test_rng *rng, const kn_spline *s)
{
    for (int v = 0; v < 2; v++) {
        double lo, hi;
        kn_spline_domain(s, v, &lo, &hi);
        at[v] = test_uniform(rng, lo, hi);
    }
}

// Some 200 roundings of numbers below 10, and slopes of n and of the fields on their spans below 1000.
static void equals_direct_evaluation(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(41);
    for (int run = 0; run < SURFACE_CASES * 7; run++) {
        kind k;
        int bits = 1 + run % 7;
        kind_init(ctx, &k, &rng, run / 7, bits, run % 4);
        for (int i = 0; i < test_scale(20); i++) {
            double at[2], w = test_uniform(&rng, -1, 1), p[3], j[9];
            long double t[3], d[9];
            random_place(at, &rng, &k.s);
            assert_int_equal(kn_shell_eval(ctx, p, j, k.shell, at[0], at[1], w), KN_OK);
            direct_kind(t, d, k.shell, &k.o, at[0], at[1], w);
            for (int c = 0; c < 3; c++) assert_true(fabsl(p[c] - t[c]) < 1e-12L);
            for (int c = 0; c < 9; c++) assert_true(fabsl(j[c] - d[c]) < 1e-10L);
        }
        kn_normal_certificate c = kn_shell_certificate(k.shell);
        double w[2];
        kn_shell_heights(k.shell, w);
        assert_true(c.certified && isinf(w[0]) && isinf(w[1]) && w[0] < w[1]);
        assert_true((c.length_error == 0.0 && c.angle_error == 0.0) == ((bits & 2) != 0));
        kind_clear(ctx, &k);
    }
    test_ctx_end(ctx, &memory);
}

// The knots of the fields are cell lines, and S is what it was.
static void knots_become_lines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(42);
    kind k;
    int cells[2];
    kind_init(ctx, &k, &rng, 0, 5, 3); // a plane of one span; h and psi have the same knots
    kn_shell_cells(k.shell, cells);
    assert_int_equal(cells[0], 2);
    assert_int_equal(cells[1], 2);
    const kn_spline *s = kn_shell_surface(k.shell);
    assert_true(s->knots[0][s->degree[0] + 1] == k.h.knots[0][k.h.degree[0] + 1]);
    for (int i = 0; i < 50; i++) {
        double at[2], p[3], q[3];
        random_place(at, &rng, &k.s);
        assert_int_equal(kn_spline_eval(ctx, p, &k.s, at), KN_OK);
        assert_int_equal(kn_spline_eval(ctx, q, s, at), KN_OK);
        assert_true(test_max_difference(p, q, 3) < 1e-14);
    }
    kind_clear(ctx, &k);

    // A knot within rounding of a knot of S is that knot.
    kn_spline wavy = {0}, h = {0};
    make_wavy(ctx, &wavy);
    double lo, hi, t = wavy.knots[0][4], one[9], kv[2][8];
    const double *knots[2] = {kv[0], kv[1]};
    for (int v = 0; v < 2; v++) {
        kn_spline_domain(&wavy, v, &lo, &hi);
        for (int i = 0; i < 5; i++) kv[v][i] = i < 2 ? lo : hi;
    }
    for (int i = 0; i < 9; i++) one[i] = 1.0;
    kn_spline_domain(&wavy, 0, &lo, &hi);
    kv[0][2] = nextafter(t, hi), kv[0][3] = hi, kv[0][4] = hi;
    kn_spline_domain(&wavy, 1, &lo, &hi);
    kv[1][2] = hi, kv[1][3] = hi;
    assert_true(t > wavy.knots[0][0] && t < wavy.knots[0][wavy.count[0]]);
    assert_int_equal(kn_spline_init(ctx, &h, 2, 1, false, (const int[2]){1, 1}, (const int[2]){3, 2}, knots, one),
                     KN_OK);
    kn_shell *shell = NULL;
    assert_int_equal(kn_shell_create(ctx, &shell, &wavy, &(kn_shell_options){.thickness = &h, .normal_tol = 1e-3}),
                     KN_OK);
    assert_int_equal(kn_shell_surface(shell)->count[0], wavy.count[0]);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &wavy), kn_spline_clear(ctx, &h);
    test_ctx_end(ctx, &memory);
}

// T of a piece at x in its box.
static void piece_value(long double t[3], const kn_shell_piece *p, const long double x[2], long double w)
{
    long double sum[4] = {0}, value[4];
    for (int k = 0; k < p->nterms; k++) {
        direct_piece(value, &p->term[k], x);
        for (int c = 0; c < p->term[k].ncomp; c++) sum[c] += powl(w, p->power[k]) * value[c];
    }
    for (int c = 0; c < 3; c++) t[c] = p->term[0].rational ? sum[c] / sum[3] : sum[c];
}

// Cell line i where the lines are the knots of S.
static double line_of(const kn_shell *shell, int var, int i)
{
    const kn_spline *s = kn_shell_surface(shell);
    int at = s->degree[var];
    for (; i > 0; i--)
        for (at++; s->knots[var][at] == s->knots[var][at - 1];) at++;
    return s->knots[var][at];
}

// Pieces over cells and over boxes inside them against T itself; stand-ins within their deviation.
static void pieces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(43);
    int stand_ins = 0;
    for (int run = 0; run < SURFACE_CASES * 7; run++) {
        kind k;
        int bits = 1 + run % 7, cells[2], power = 1 + run % 3;
        kind_init(ctx, &k, &rng, run / 7, bits, power);
        kn_shell_cells(k.shell, cells);
        for (int i = 0; i < 6; i++) {
            int cell[2] = {test_int(&rng, 0, cells[0] - 1), test_int(&rng, 0, cells[1] - 1)};
            double lo[2] = {0, 0}, hi[2] = {1, 1};
            for (int v = 0; v < 2 && i % 2; v++)
                lo[v] = test_uniform(&rng, 0, 0.4), hi[v] = test_uniform(&rng, 0.5, 1);
            kn_shell_piece p;
            bool fits = false;
            assert_int_equal(kn_shell_piece_init(ctx, &p, &fits, k.shell, cell, lo, hi, 12), KN_OK);
            if (!fits) continue;
            stand_ins += !p.exact;
            assert_int_equal(p.nterms, bits & 4 ? 3 : 2);
            assert_int_equal(p.power[1], 1);
            if (bits & 4) assert_int_equal(p.power[2], power);
            if (bits & 2) assert_true(p.exact);
            for (int m = 0; m < 4; m++) {
                long double x[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, got[3], at[2], t[3],
                            apart = 0;
                double w = test_uniform(&rng, -1, 1);
                for (int v = 0; v < 2; v++) {
                    long double a = line_of(k.shell, v, cell[v]), b = line_of(k.shell, v, cell[v] + 1);
                    at[v] = a + (lo[v] + x[v] * (hi[v] - lo[v])) * (b - a);
                }
                piece_value(got, &p, x, w);
                direct_kind(t, NULL, k.shell, &k.o, at[0], at[1], w);
                for (int c = 0; c < 3; c++) apart += (got[c] - t[c]) * (got[c] - t[c]);
                // deviation bounds the distance of the fields; the rest is rounding as in the test above
                assert_true(sqrtl(apart) <= fabs(w) * p.deviation + 1e-12L);
            }
            kn_shell_piece_clear(ctx, &p);
        }
        kind_clear(ctx, &k);
    }
    assert_true(stand_ins > 0);
    test_ctx_end(ctx, &memory);
}

// Whole cells side by side have the same coefficients along their common edge, bit for bit, h n among them.
static void neighbours_share_their_edge(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(46);
    int pairs = 0;
    for (int run = 0; run < 2 * SURFACE_CASES; run++) {
        kind k;
        int cells[2], var = run % 2;
        kind_init(ctx, &k, &rng, run / 2, 5, 2);
        kn_shell_cells(k.shell, cells);
        for (int i = 0; i + 1 < cells[var]; i++) {
            kn_shell_piece p[2];
            bool fits[2];
            const double lo[2] = {0, 0}, hi[2] = {1, 1};
            for (int m = 0; m < 2; m++) {
                int cell[2] = {0, 0};
                cell[var] = i + m;
                assert_int_equal(kn_shell_piece_init(ctx, &p[m], &fits[m], k.shell, cell, lo, hi, 12), KN_OK);
            }
            bool exact = fits[0] && fits[1] && p[0].exact && p[1].exact;
            pairs += exact;
            for (int t = 0; exact && t < p[0].nterms; t++) {
                const kn_bezier *a = &p[0].term[t], *b = &p[1].term[t];
                size_t n = kn_bezier_count(a), row = (size_t)a->degree[1] + 1, along = var == 0 ? row : n / row;
                size_t far = var == 0 ? n - row : row - 1, step = var == 0 ? 1 : row;
                assert_int_equal(n, kn_bezier_count(b));
                for (size_t j = 0; j < along * (size_t)a->ncomp; j++) {
                    size_t at = j / along * n + j % along * step;
                    assert_true(a->coef[at + far] == b->coef[at]);
                }
            }
            for (int m = 0; m < 2; m++)
                if (fits[m]) kn_shell_piece_clear(ctx, &p[m]);
        }
        kind_clear(ctx, &k);
    }
    assert_true(pairs > 5);
    test_ctx_end(ctx, &memory);
}

static void expect(kn_ctx *ctx, kn_status status, const char *word, const kn_spline *s, const kn_shell_options *o)
{
    kn_shell *shell = NULL;
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_shell_create(ctx, &shell, s, o), status);
    assert_null(shell);
    if (!strstr(kn_ctx_message(ctx), word)) fail_msg("\"%s\" does not say \"%s\"", kn_ctx_message(ctx), word);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(44);
    kn_spline plane = {0}, wavy = {0}, h = {0}, d = {0}, far = {0};
    make_plane(ctx, &plane);
    make_quintic(ctx, &wavy);
    make_field(ctx, &h, &rng, &plane, 2, 1, 1.0, 0.1);
    make_field(ctx, &d, &rng, &plane, 1, 3, 1.0, 0.1);
    make_field(ctx, &far, &rng, &wavy, 2, 1, 1.0, 0.1);
    expect(ctx, KN_EDOMAIN, "thickness", &plane, &(kn_shell_options){.thickness = &d});
    expect(ctx, KN_EDOMAIN, "direction", &plane, &(kn_shell_options){.direction = &h});
    expect(ctx, KN_EDOMAIN, "attraction", &plane, &(kn_shell_options){.attraction = &h});
    expect(ctx, KN_EDOMAIN, "over", &plane, &(kn_shell_options){.thickness = &far});
    expect(ctx, KN_EDOMAIN, "w^-1", &plane, &(kn_shell_options){.attraction = &d, .attraction_power = -1});
    expect(ctx, KN_ELIMIT, "w^57", &plane, &(kn_shell_options){.attraction = &d, .attraction_power = 57});
    d.rational = true; // the third component is then the weight
    expect(ctx, KN_EDOMAIN, "rational", &plane, &(kn_shell_options){.direction = &d});
    d.rational = false;
    double inside = h.coef[5];
    h.coef[5] = -40.0; // the middle of a bump that goes well below zero
    expect(ctx, KN_EDOMAIN, "not certainly positive", &plane, &(kn_shell_options){.thickness = &h});
    h.coef[5] = -0.05; // a negative coefficient, and yet positive: all others are near 1
    kn_shell *shell = NULL;
    assert_int_equal(kn_shell_create(ctx, &shell, &plane, &(kn_shell_options){.thickness = &h}), KN_OK);
    kn_shell_destroy(ctx, shell);
    h.coef[5] = inside;

    // A surface without a normal has a shell where a direction is given, and nothing to say of its normal.
    double p[3] = {7, 7, 7};
    for (size_t i = 0; i < 3 * kn_spline_count(&plane); i++) plane.coef[i] = 1.0;
    expect(ctx, KN_EDOMAIN, "area", &plane, NULL);
    assert_int_equal(kn_shell_create(ctx, &shell, &plane, &(kn_shell_options){.direction = &d}), KN_OK);
    assert_int_equal(kn_shell_unit_normal(ctx, p, shell, 0.5, 0.5), KN_EUNDEFINED);
    assert_true(p[0] == 7 && p[1] == 7 && p[2] == 7);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &plane), kn_spline_clear(ctx, &wavy), kn_spline_clear(ctx, &h);
    kn_spline_clear(ctx, &d), kn_spline_clear(ctx, &far);
    test_ctx_end(ctx, &memory);
}

static kn_status create_call(kn_ctx *ctx, void *user)
{
    kind *k = user;
    kn_shell *shell = NULL;
    kn_status status = kn_shell_create(ctx, &shell, &k->s, &k->o);
    assert_true((status == KN_OK) == (shell != NULL));
    kn_shell_destroy(ctx, shell);
    return status;
}

static kn_status piece_call(kn_ctx *ctx, void *user)
{
    kind *k = user;
    kn_shell_piece p = {0};
    bool fits = false;
    kn_status status = kn_shell_piece_init(ctx, &p, &fits, k->shell, (const int[2]){0, 0},
                                           (const double[2]){0.1, 0.1}, (const double[2]){0.9, 0.9}, 12);
    assert_true((status == KN_OK) == (p.nterms > 0));
    kn_shell_piece_clear(ctx, &p);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(45);
    for (int bits = 5; bits <= 7; bits += 2) {
        kind k = {.shell = NULL};
        make_plane(ctx, &k.s);
        kind_options(ctx, &k, &rng, bits, 2);
        test_allocation_failures(create_call, &k);
        kind_clear(ctx, &k);
        kind_init(ctx, &k, &rng, 1, bits, 2); // the cylinder is rational
        test_allocation_failures(piece_call, &k);
        kind_clear(ctx, &k);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equals_direct_evaluation),
        cmocka_unit_test(knots_become_lines),
        cmocka_unit_test(pieces),
        cmocka_unit_test(neighbours_share_their_edge),
        cmocka_unit_test(failures),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
