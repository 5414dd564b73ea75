// SPDX-License-Identifier: Apache-2.0
// Pieces of a shell over boxes: against the shell, against direct evaluation, neighbours, wrapping and failures.
#include "tests/support/surfaces.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// A shell whose cells halve the knot spans of s.
static kn_shell *halved(kn_ctx *ctx, const kn_spline *s, double tol)
{
    double lines[2][64];
    kn_shell_options o = kn_shell_defaults();
    o.normal_tol = tol;
    for (int v = 0; v < 2; v++) {
        int n = 0;
        for (int i = 0; i < s->count[v] + s->degree[v] + 1; i++) {
            double k = s->knots[v][i];
            if (n > 0 && k == lines[v][n - 1]) continue;
            if (n > 0) lines[v][n] = 0.5 * (lines[v][n - 1] + k), n++;
            lines[v][n++] = k;
        }
        o.lines[v] = lines[v];
        o.nlines[v] = n;
    }
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

// T of the piece at x and height w.
static void piece_eval(kn_ctx *ctx, double out[3], const kn_shell_piece *p, const double x[2], double w)
{
    double a[4], b[4];
    kn_bezier s = p->term[0], n = p->term[1];
    s.rational = n.rational = false; // homogeneous values
    assert_int_equal(kn_bezier_eval(ctx, a, &s, x), KN_OK);
    assert_int_equal(kn_bezier_eval(ctx, b, &n, x), KN_OK);
    for (int c = 0; c < 3; c++) out[c] = (a[c] + w * b[c]) / (s.ncomp == 4 ? a[3] : 1.0);
    if (s.ncomp == 4) assert_true(b[3] == 0.0);
}

// The piece's own normal against S_u x S_v of its own surface, in long double. Beyond a pole the cross product turns
// over while the direction with its factor divided out does not: there the angle counts up to sign.
static void check_own_certificate(kn_ctx *ctx, const kn_shell_piece *p, const double x[2])
{
    kn_spline s = {0}, n = {0};
    long double q[3], su[3], sv[3], d[3], f[12], m[3], mm = 0, dd = 0, dot = 0, cross = 0;
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &p->term[0]), KN_OK);
    kn_bezier plain = p->term[1];
    plain.rational = false; // its weight is zero by contract
    assert_int_equal(kn_spline_of_bezier(ctx, &n, &plain), KN_OK);
    direct_surface(q, su, sv, d, &s, x[0], x[1]);
    direct_spline(f, &s, x[0], x[1]);
    long double w = s.rational ? f[3] : 1.0L;
    direct_spline(f, &n, x[0], x[1]);
    for (int c = 0; c < 3; c++) m[c] = f[c] / w;
    for (int c = 0; c < 3; c++) {
        long double y = m[(c + 1) % 3] * d[(c + 2) % 3] - m[(c + 2) % 3] * d[(c + 1) % 3];
        cross += y * y, mm += m[c] * m[c], dd += d[c] * d[c], dot += m[c] * d[c];
    }
    // 1e-12: the box's own surface and normal are rounded once more than the shell's, S_u and S_v by some 40 units of
    // coordinates below 10 times twice their degree, which S_u x S_v feels the more the shorter it is
    if (dd > 1e-14L)
        assert_true(atan2l(sqrtl(cross), fabsl(dot)) <= p->normal.angle_error + 1e-12L + 1e-12L / sqrtl(dd));
    assert_true(fabsl(sqrtl(mm) - 1.0L) <= p->normal.length_error + 1e-12L);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &n);
}

typedef struct tally {
    int exact, stand_in, none;
} tally;

// The outline says the same of the piece, with or without coefficients.
static void check_outline(kn_ctx *ctx, const kn_shell_piece *p, bool fits, const kn_shell *shell, const int cell[2],
                          const double lo[2], const double hi[2], int degree_sum)
{
    kn_shell_piece q = {0};
    bool same = !fits;
    assert_int_equal(kn_shell_piece_outline(ctx, &q, &same, shell, cell, lo, hi, degree_sum), KN_OK);
    assert_true(same == fits);
    if (!fits) return;
    assert_int_equal(q.nterms, p->nterms);
    assert_true(q.exact == p->exact && q.deviation == p->deviation);
    assert_true(q.normal.length_error == p->normal.length_error && q.normal.angle_error == p->normal.angle_error);
    for (int k = 0; k < q.nterms; k++) {
        const kn_bezier *a = &q.term[k], *b = &p->term[k];
        assert_int_equal(q.power[k], p->power[k]);
        assert_true(a->nvars == b->nvars && a->ncomp == b->ncomp && a->rational == b->rational);
        for (int v = 0; v < 2; v++) assert_int_equal(a->degree[v], b->degree[v]);
    }
    kn_shell_piece_clear(ctx, &q);
}

static void check_box(kn_ctx *ctx, tally *t, const kn_shell *shell, const int cell[2], const double lo[2],
                      const double hi[2], double line[2][2], int degree_sum, test_rng *rng)
{
    kn_shell_piece p = {0};
    bool fits = false;
    double domain[2][2], height = 0.25;
    if (kn_shell_piece_init(ctx, &p, &fits, shell, cell, lo, hi, degree_sum) != KN_OK)
        fail_msg("%s", kn_ctx_message(ctx));
    check_outline(ctx, &p, fits, shell, cell, lo, hi, degree_sum);
    t->exact += fits && p.exact, t->stand_in += fits && !p.exact, t->none += !fits;
    if (!fits) {
        assert_null(p.term[0].coef);
        return;
    }
    assert_int_equal(p.nterms, 2);
    assert_true(p.normal.certified && p.normal.length_error < 1e-4 && p.normal.angle_error < 1e-4);
    // a shell's exact direction is that of its pieces
    if (kn_shell_certificate(shell).angle_error < 1e-9) assert_true(p.normal.angle_error < 1e-9);
    assert_true(p.exact ? p.deviation == 0.0 : p.deviation > 0.0 && p.deviation < 4e-4);
    if (!p.exact && !p.term[0].rational) // a rational piece's term is W n
        assert_true(p.term[1].degree[0] + p.term[1].degree[1] <= degree_sum);
    for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(shell), v, &domain[v][0], &domain[v][1]);
    for (int k = 0; k < 8; k++) {
        double x[2] = {test_uniform(rng, 0, 1), test_uniform(rng, 0, 1)}, at[2], a[3], b[3];
        bool inside = true;
        for (int v = 0; v < 2; v++) {
            at[v] = line[v][0] + (lo[v] + x[v] * (hi[v] - lo[v])) * (line[v][1] - line[v][0]);
            inside = inside && at[v] >= domain[v][0] && at[v] <= domain[v][1];
        }
        check_own_certificate(ctx, &p, x);
        if (!inside) continue;
        piece_eval(ctx, a, &p, x, height);
        assert_int_equal(kn_shell_eval(ctx, b, NULL, shell, at[0], at[1], height), KN_OK);
        // coordinates below 10, some 100 roundings
        assert_true(test_max_difference(a, b, 3) <= height * p.deviation + 1e-12);
    }
    kn_shell_piece_clear(ctx, &p);
}

static void pieces_are_the_shell(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    tally whole = {0}, part = {0}, beyond = {0};
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = halved(ctx, &s, 1e-4);
        int cells[2], cell[2];
        kn_shell_cells(shell, cells);
        for (int i = 0; i < 12; i++) {
            double line[2][2];
            for (int v = 0; v < 2; v++) {
                cell[v] = test_int(&rng, 0, cells[v] - 1);
                // cell lines are the knots and the middles between them
                int span = 0, left = cell[v] / 2;
                const double *t = s.knots[v];
                for (span = s.degree[v]; t[span] == t[span + 1] || left-- > 0; span++) {
                }
                double a = t[span], b = t[span + 1], m = 0.5 * (a + b);
                line[v][0] = cell[v] % 2 ? m : a;
                line[v][1] = cell[v] % 2 ? b : m;
            }
            check_box(ctx, &whole, shell, cell, (const double[2]){0, 0}, (const double[2]){1, 1}, line, 12, &rng);
            check_box(ctx, &part, shell, cell, (const double[2]){0.25, 0.5}, (const double[2]){0.375, 0.75}, line, 12,
                      &rng);
            double lo[2], hi[2]; // over the middle line of the span, where there is no knot of S
            for (int v = 0; v < 2; v++) lo[v] = cell[v] % 2 ? -0.25 : 0.5, hi[v] = cell[v] % 2 ? 0.5 : 1.25;
            check_box(ctx, &beyond, shell, cell, lo, hi, line, 14, &rng);
            for (int v = 0; v < 2; v++) { // beyond the domain
                if (cell[v] == 0) lo[v] = -0.25, hi[v] = 0.75;
                if (cell[v] == cells[v] - 1) lo[v] = 0.25, hi[v] = 1.25;
            }
            check_box(ctx, &beyond, shell, cell, lo, hi, line, 14, &rng);
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    assert_true(whole.exact > 0 && whole.stand_in > 0 && part.exact > 0 && beyond.stand_in > 40);
    test_ctx_end(ctx, &memory);
}

// Boxes of the teapot that reach into neighbouring cells and beyond the patch, poles among them.
static void teapot_boxes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    const int patches[6] = {4, 20, 24, 28, 4, 20};
    bool found = true;
    for (int k = 0; k < 6 && found; k++) {
        kn_spline s;
        double lines[9];
        tally t = {0};
        found = make_teapot(ctx, &s, patches[k]);
        if (!found) break;
        for (int i = 0; i < 9; i++) lines[i] = i / 8.0;
        kn_shell *shell = NULL;
        kn_shell_options o = {.lines = {lines, lines}, .nlines = {9, 9}, .normal_tol = 1e-4};
        if (k >= 4) o.normal = KN_NORMAL_EXACT_DIRECTION;
        assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
        for (int i = 0; i < 8; i++)
            for (int j = 0; j < 8; j++) {
                double line[2][2] = {{lines[i], lines[i + 1]}, {lines[j], lines[j + 1]}};
                check_box(ctx, &t, shell, (const int[2]){i, j}, (const double[2]){-0.25, -0.125},
                          (const double[2]){1.25, 1.125}, line, k < 4 ? 14 : 24, &rng);
            }
        assert_true(t.stand_in + t.exact > 32);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
    if (!found) skip();
}

// ---- neighbours and wrapping ----

static void assert_same_edge(const kn_bezier *a, const kn_bezier *b, int var)
{
    size_t count = kn_bezier_count(a), n = (size_t)a->degree[1 - var] + 1,
           step = var == 0 ? 1 : (size_t)a->degree[1] + 1;
    size_t last = var == 0 ? count - n : (size_t)a->degree[1];
    assert_int_equal(count, kn_bezier_count(b));
    for (size_t c = 0; c < (size_t)a->ncomp; c++)
        for (size_t i = 0; i < n; i++) {
            const double *x = &a->coef[c * count + last + i * step], *y = &b->coef[c * count + i * step];
            assert_true(*x == *y);
        }
}

static void neighbours_share_edges_bit_for_bit(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double zero[2] = {0, 0}, one[2] = {1, 1};
    kn_spline s;
    make_wavy(ctx, &s);
    double lines[2][64];
    kn_shell *shell = NULL;
    kn_shell_options o = {.normal_tol = 1e-3};
    for (int v = 0; v < 2; v++) { // fine enough for the tolerance without more lines
        for (int i = 0; i < 49; i++) lines[v][i] = i / 16.0;
        o.lines[v] = lines[v], o.nlines[v] = 49;
    }
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
    for (int i = 0; i < 48; i += 5)
        for (int var = 0; var < 2; var++) {
            kn_shell_piece a, b;
            bool fits;
            int cell[2] = {i, 47 - i}, next[2] = {i, 47 - i};
            next[var]++;
            if (next[var] > 47) continue;
            assert_int_equal(kn_shell_piece_init(ctx, &a, &fits, shell, cell, zero, one, 10), KN_OK);
            assert_true(fits && a.exact);
            assert_int_equal(kn_shell_piece_init(ctx, &b, &fits, shell, next, zero, one, 10), KN_OK);
            assert_true(fits && b.exact);
            for (int k = 0; k < 2; k++) assert_same_edge(&a.term[k], &b.term[k], var);
            kn_shell_piece_clear(ctx, &a);
            kn_shell_piece_clear(ctx, &b);
        }
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Far more cells than lines of n: whole cells are exact, neighbours share edges, and n has the size that it has for
// fewer cells.
static void many_cells(void **state)
{
    (void)state;
    enum { MOST = 3001 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(9);
    const double zero[2] = {0, 0}, one[2] = {1, 1};
    kn_spline s;
    make_wavy(ctx, &s);
    static double lines[MOST];
    int points[2][2];
    for (int round = 0; round < 2; round++) {
        int n = round == 0 ? 1501 : MOST;
        for (int i = 0; i < n; i++) lines[i] = 3.0 * i / (n - 1);
        kn_shell *shell = NULL;
        kn_shell_options o = {.normal_tol = 1e-3, .lines = {lines, lines}, .nlines = {n, n}};
        assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
        for (int v = 0; v < 2; v++) points[round][v] = kn_shell_normal(shell)->count[v];
        for (int i = 0; i < 200; i++) {
            kn_shell_piece a, b;
            bool fits;
            int var = i % 2, cell[2] = {test_int(&rng, 0, n - 3), test_int(&rng, 0, n - 3)};
            int next[2] = {cell[0] + (var == 0), cell[1] + (var == 1)};
            assert_int_equal(kn_shell_piece_init(ctx, &a, &fits, shell, cell, zero, one, 10), KN_OK);
            assert_true(fits && a.exact);
            assert_int_equal(kn_shell_piece_init(ctx, &b, &fits, shell, next, zero, one, 10), KN_OK);
            assert_true(fits && b.exact);
            for (int k = 0; k < 2; k++) assert_same_edge(&a.term[k], &b.term[k], var);
            kn_shell_piece_clear(ctx, &a);
            kn_shell_piece_clear(ctx, &b);
        }
        kn_shell_destroy(ctx, shell);
    }
    for (int v = 0; v < 2; v++) {
        assert_int_equal(points[0][v], points[1][v]);
        assert_true(points[0][v] < 128);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void assert_same_piece(kn_ctx *ctx, kn_shell_piece *a, kn_shell_piece *b)
{
    for (int k = 0; k < 2; k++) {
        size_t n = kn_bezier_count(&a->term[k]) * (size_t)a->term[k].ncomp;
        assert_int_equal(n, kn_bezier_count(&b->term[k]) * (size_t)b->term[k].ncomp);
        assert_true(test_max_difference(a->term[k].coef, b->term[k].coef, n) == 0.0);
    }
    kn_shell_piece_clear(ctx, a);
    kn_shell_piece_clear(ctx, b);
}

static void closed_directions_wrap(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_cylinder(ctx, &s);
    kn_shell *shell = halved(ctx, &s, 1e-4);
    const double zero[2] = {0, 0}, one[2] = {1, 1}, after[2] = {1, 0}, end[2] = {1.5, 1}, half[2] = {0.5, 1};
    kn_shell_piece a, b;
    bool fits;
    assert_int_equal(kn_shell_piece_init(ctx, &a, &fits, shell, (const int[2]){-1, 0}, zero, one, 12), KN_OK);
    assert_true(fits);
    assert_int_equal(kn_shell_piece_init(ctx, &b, &fits, shell, (const int[2]){7, 0}, zero, one, 12), KN_OK);
    assert_true(fits);
    assert_same_piece(ctx, &a, &b);
    // what lies wholly beyond the seam is the first cell
    assert_int_equal(kn_shell_piece_init(ctx, &a, &fits, shell, (const int[2]){7, 0}, after, end, 12), KN_OK);
    assert_true(fits);
    assert_int_equal(kn_shell_piece_init(ctx, &b, &fits, shell, (const int[2]){8, 0}, zero, half, 12), KN_OK);
    assert_true(fits);
    assert_same_piece(ctx, &a, &b);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void open_directions_extend(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_plane(ctx, &s); // S = (2u, 3v, 1), T = S + w (0,0,1)
    kn_shell *shell = halved(ctx, &s, 1e-6);
    kn_shell_piece p;
    bool fits;
    const double zero[2] = {0, 0}, one[2] = {1, 1}, x[2] = {0.5, 0.5};
    double t[3];
    assert_int_equal(kn_shell_piece_init(ctx, &p, &fits, shell, (const int[2]){-2, 3}, zero, one, 12), KN_OK);
    assert_true(fits && p.exact);
    piece_eval(ctx, t, &p, x, 0.5); // the cell [-1,-0.5] x [1.5,2]
    const double expected[3] = {2 * -0.75, 3 * 1.75, 1.5};
    // rounding of n at most 3 cells away: (1 + 2 * 2)^3 (1 + 2 * 3)^3 times some 1e-16
    assert_true(test_max_difference(t, expected, 3) < 1e-10);
    kn_shell_piece_clear(ctx, &p);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// ---- failures ----

static void failures_are_told(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_wavy(ctx, &s);
    kn_shell *shell = halved(ctx, &s, 1e-6);
    const struct {
        double lo[2], hi[2];
    } bad[] = {{{0, 0}, {0, 1}}, {{0, 1}, {1, 0}}, {{0, NAN}, {1, 1}}, {{0, 0}, {1, INFINITY}}, {{0, 0}, {2.5, 1}}};
    kn_shell_piece p;
    memset(&p, 0x5a, sizeof p);
    kn_shell_piece before = p;
    bool fits = true;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_shell_piece_init(ctx, &p, &fits, shell, (const int[2]){0, 0}, bad[i].lo, bad[i].hi, 12),
                         KN_EDOMAIN);
        assert_true(fits && memcmp(&p, &before, sizeof p) == 0);
        assert_true(strlen(kn_ctx_message(ctx)) > 0);
    }
    // no polynomial of degrees (1,1) is that near
    kn_ctx_clear_error(ctx);
    const double lo[2] = {0.5, 0.5}, hi[2] = {1.5, 1.5};
    for (int k = 0; k < 3; k++) { // no polynomial has such degrees
        fits = true;
        assert_int_equal(kn_shell_piece_init(ctx, &p, &fits, shell, (const int[2]){0, 0}, lo, hi,
                                             (const int[]){INT_MIN, -1, 0}[k]),
                         KN_OK);
        assert_false(fits);
    }
    assert_int_equal(kn_shell_piece_init(ctx, &p, &fits, shell, (const int[2]){0, 0}, lo, hi, 2), KN_OK);
    assert_true(!fits && memcmp(&p, &before, sizeof p) == 0);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// user: {lo, hi} of the box in both variables
static kn_status make_piece(kn_ctx *ctx, void *user)
{
    const double *range = user, lo[2] = {range[0], range[0]}, hi[2] = {range[1], range[1]};
    kn_spline s = {0};
    kn_shell *shell = NULL;
    kn_shell_piece p = {0};
    bool fits = true;
    const double k[4] = {0, 0, 1, 1}, coef[16] = {0, 0, 2, 2, 0, 3, 0, 3, 0, 0, 0, 1, 1, 1, 1, 1};
    const double *knots[2] = {k, k};
    kn_shell_options o = {.normal_tol = 0.01};
    kn_status status = kn_spline_init(ctx, &s, 2, 4, true, (const int[2]){1, 1}, (const int[2]){2, 2}, knots, coef);
    if (status == KN_OK) status = kn_shell_create(ctx, &shell, &s, &o);
    if (status == KN_OK) {
        status = kn_shell_piece_init(ctx, &p, &fits, shell, (const int[2]){0, 0}, lo, hi, 12);
        if (status == KN_OK) assert_true(fits);
        if (status != KN_OK) assert_true(fits && p.term[0].coef == NULL && p.term[1].coef == NULL && p.nterms == 0);
    }
    kn_shell_piece_clear(ctx, &p);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    double whole[2] = {0, 1}, beyond[2] = {-0.5, 1.75};
    test_allocation_failures(make_piece, whole);
    test_allocation_failures(make_piece, beyond);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_are_the_shell),
        cmocka_unit_test(teapot_boxes),
        cmocka_unit_test(neighbours_share_edges_bit_for_bit),
        cmocka_unit_test(many_cells),
        cmocka_unit_test(closed_directions_wrap),
        cmocka_unit_test(open_directions_extend),
        cmocka_unit_test(failures_are_told),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("trivar/shell_piece", tests, NULL, NULL);
}
