// SPDX-License-Identifier: Apache-2.0
// kn_shell_piece_rows: the pieces of a row of cells, against kn_shell_piece_init bit for bit.
#include "tests/support/kinds.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_LINES = 128, MOST_NUMBERS = 1 << 12 };

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Thirds of the knot spans of S and of a field along v.
static int make_lines(double *lines, const kn_spline *s, const kn_spline *field, int v)
{
    double breaks[MOST_LINES];
    int n = 0, nbreaks = 0;
    for (int i = s->degree[v]; i <= s->count[v]; i++) breaks[nbreaks++] = s->knots[v][i];
    for (int i = field->degree[v]; i <= field->count[v]; i++) breaks[nbreaks++] = field->knots[v][i];
    qsort(breaks, (size_t)nbreaks, sizeof *breaks, by_value);
    for (int i = 0; i + 1 < nbreaks; i++) {
        double width = breaks[i + 1] - breaks[i];
        for (int k = 0; k < 3 && width > 0.0; k++) lines[n++] = breaks[i] + width * k / 3.0;
    }
    lines[n++] = breaks[nbreaks - 1];
    return n;
}

// A shell of kind `bits` (1 a thickness, 2 a direction, 4 an attraction).
static kn_shell *make_shell(kn_ctx *ctx, kn_spline *s, test_rng *rng, int surface, int bits)
{
    kn_spline h = {0}, d = {0}, psi = {0};
    kn_shell *shell = NULL;
    double lines[2][MOST_LINES];
    surface_cases[surface].make(ctx, s);
    make_field(ctx, &h, rng, s, 2, 1, 1.0, 0.4);
    make_field(ctx, &d, rng, s, 1, 3, 0.5, 0.5);
    make_field(ctx, &psi, rng, s, 1, 3, 0.0, 0.3);
    kn_shell_options o = {.normal_tol = 1e-3, .attraction_power = 2};
    if (bits & 1) o.thickness = &h;
    if (bits & 2) o.direction = &d;
    if (bits & 4) o.attraction = &psi;
    for (int v = 0; v < 2; v++) {
        o.lines[v] = lines[v];
        o.nlines[v] = make_lines(lines[v], s, &h, v);
    }
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_spline_clear(ctx, &h), kn_spline_clear(ctx, &d), kn_spline_clear(ctx, &psi);
    return shell;
}

static size_t row_length(const kn_shell_piece *p)
{
    size_t n = 0;
    for (int t = 0; t < p->nterms; t++) n += kn_bezier_count(&p->term[t]);
    return n;
}

static bool same_terms(const kn_shell_piece *a, const kn_shell_piece *b)
{
    bool same = a->nterms == b->nterms;
    for (int t = 0; same && t < a->nterms; t++)
        same = a->power[t] == b->power[t] && a->term[t].ncomp == b->term[t].ncomp &&
               a->term[t].degree[0] == b->term[t].degree[0] && a->term[t].degree[1] == b->term[t].degree[1];
    return same;
}

static void check_cell(const double *rows, const kn_shell_piece *p)
{
    size_t row = row_length(p), first = 0;
    for (int t = 0; t < p->nterms; t++) {
        size_t n = kn_bezier_count(&p->term[t]);
        for (size_t c = 0; c < (size_t)p->term[t].ncomp; c++)
            assert_memory_equal(rows + c * row + first, p->term[t].coef + c * n, n * sizeof *rows);
        first += n;
    }
}

// One row of cells from `cell` on, in as many calls as it takes. products: none can be had.
static int check_row(kn_ctx *ctx, const kn_shell *shell, const int first[2], int n, bool products)
{
    const double lo[2] = {0, 0}, hi[2] = {1, 1};
    double *rows = malloc((size_t)n * MOST_NUMBERS * sizeof *rows);
    int cell[2] = {first[0], first[1]}, end = first[1] + n, had = 0, cells[2];
    bool closed[2];
    assert_non_null(rows);
    kn_shell_cells(shell, cells);
    kn_shell_closed(shell, closed);
    while (cell[1] < end) {
        kn_shell_piece like = {0}, p = {0};
        bool fits;
        int made = -1;
        assert_int_equal(kn_shell_piece_outline(ctx, &like, &fits, shell, cell, lo, hi, 16), KN_OK);
        if (!fits) {
            cell[1]++;
            continue;
        }
        size_t each = row_length(&like) * (size_t)like.term[0].ncomp;
        assert_true(each <= MOST_NUMBERS);
        assert_int_equal(kn_shell_piece_rows(ctx, rows, &made, shell, &like, cell, end - cell[1]), KN_OK);
        assert_true(made >= 0 && made <= end - cell[1]);
        assert_true(!products || made == 0);
        for (int k = 0; k < made; k++, cell[1]++, had++) {
            assert_int_equal(kn_shell_piece_init(ctx, &p, &fits, shell, cell, lo, hi, 16), KN_OK);
            assert_true(fits && p.exact && same_terms(&p, &like));
            check_cell(rows + (size_t)k * each, &p);
            kn_shell_piece_clear(ctx, &p);
        }
        if (cell[1] < end && (made > 0 || !products)) { // there is a reason why it ends here
            bool outside = false;
            for (int v = 0; v < 2; v++) outside = outside || (!closed[v] && (cell[v] < 0 || cell[v] >= cells[v]));
            assert_int_equal(kn_shell_piece_init(ctx, &p, &fits, shell, cell, lo, hi, 16), KN_OK);
            assert_true(outside || !fits || !p.exact || !same_terms(&p, &like));
            if (fits) kn_shell_piece_clear(ctx, &p);
        }
        kn_shell_piece_clear(ctx, &like);
        cell[1] += made == 0;
    }
    free(rows);
    return had;
}

static void equal_pieces_one_by_one(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(7);
    int had[6] = {0};
    for (int run = 0; run < SURFACE_CASES * 6; run++) {
        const int kinds[6] = {0, 1, 2, 3, 4, 6};
        int bits = kinds[run % 6], cells[2];
        kn_spline s;
        kn_shell *shell = make_shell(ctx, &s, &rng, run / 6, bits);
        kn_shell_cells(shell, cells);
        // h d is one field; h n, and what is added to a rational S, are products
        bool products = s.rational || ((bits & 1) && !(bits & 2));
        for (int k = 0; k < 4; k++) {
            int cell[2] = {test_int(&rng, -1, cells[0]), test_int(&rng, -2, 1)};
            had[run % 6] += check_row(ctx, shell, cell, cells[1] + 3, products);
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    for (int k = 0; k < 6; k++) assert_true(k == 1 ? had[k] == 0 : had[k] >= 20);
    test_ctx_end(ctx, &memory);
}

static void failures_are_told(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(8);
    kn_spline s;
    kn_shell *shell = make_shell(ctx, &s, &rng, 0, 0); // a plane
    const double lo[2] = {0, 0}, hi[2] = {1, 1};
    int cell[2] = {0, 0}, far[2] = {0, INT_MAX - 2}, made = 17;
    double rows[MOST_NUMBERS];
    kn_shell_piece like = {0}, none = {0}, many = {.nterms = KN_SHELL_TERMS + 1};
    bool fits;
    assert_int_equal(kn_shell_piece_outline(ctx, &like, &fits, shell, cell, lo, hi, 16), KN_OK);
    assert_int_equal(kn_shell_piece_rows(ctx, rows, &made, shell, &like, cell, -1), KN_EDOMAIN);
    assert_int_equal(kn_shell_piece_rows(ctx, rows, &made, shell, &like, far, 4), KN_EDOMAIN);
    assert_int_equal(kn_shell_piece_rows(ctx, rows, &made, shell, &none, cell, 1), KN_EDOMAIN);
    assert_int_equal(kn_shell_piece_rows(ctx, rows, &made, shell, &many, cell, 1), KN_EDOMAIN);
    assert_int_equal(made, 17);
    like.term[1].degree[0]++; // no cell has that
    assert_int_equal(kn_shell_piece_rows(ctx, rows, &made, shell, &like, cell, 1), KN_OK);
    assert_int_equal(made, 0);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static kn_status make_rows(kn_ctx *ctx, void *user)
{
    const kn_shell *shell = user;
    const double lo[2] = {0, 0}, hi[2] = {1, 1};
    const int cell[2] = {1, 0};
    double rows[2 * MOST_NUMBERS];
    kn_shell_piece like = {0};
    bool fits;
    int made = -1;
    kn_status status = kn_shell_piece_outline(ctx, &like, &fits, shell, cell, lo, hi, 16);
    if (status == KN_OK) status = kn_shell_piece_rows(ctx, rows, &made, shell, &like, cell, 2);
    assert_int_equal(made, status == KN_OK ? 2 : -1);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(9);
    kn_spline s;
    kn_shell *shell = make_shell(ctx, &s, &rng, 0, 0);
    test_allocation_failures(make_rows, shell);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(equal_pieces_one_by_one), cmocka_unit_test(failures_are_told),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("trivar/piece_rows", tests, NULL, NULL);
}
