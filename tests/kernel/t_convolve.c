// SPDX-License-Identifier: Apache-2.0
// Convolution at every level: equal to the plain reference on integers, within its bound elsewhere; scaling and
// division by the binomials; the table of binomials.
#include "kernel/convolve.h"
#include "kernel/bernstein.h"
#include "kernel/binomial.h"
#include "tests/support/support.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct arrays {
    size_t na, nb, nc;
    double *a, *b, *c, *expected, *size, *work, *room;
} arrays;

static double *numbers(size_t n)
{
    double *x = malloc((n + 1) * sizeof *x);
    assert_non_null(x);
    return x;
}

static size_t work_of(kn_convolve_level level, int nvars, const int *da, const int *db)
{
    kn_convolution p;
    kn_convolution_init(&p, level, nvars, da, db);
    return p.thin_room + p.wide_room + p.sum_room;
}

static void make(arrays *x, int nvars, const int *da, const int *db)
{
    int dc[KN_MAX_VARS] = {0};
    size_t most = kn_convolve_work(nvars, da, db);
    for (int d = 0; d < nvars; d++) dc[d] = da[d] + db[d];
    for (kn_convolve_level l = KN_CONVOLVE_SSE2; l <= kn_convolve_best(); l++)
        if (work_of(l, nvars, da, db) > most) most = work_of(l, nvars, da, db);
    x->na = kn_bernstein_count(nvars, da), x->nb = kn_bernstein_count(nvars, db),
    x->nc = kn_bernstein_count(nvars, dc);
    x->a = numbers(x->na), x->b = numbers(x->nb), x->c = numbers(x->nc);
    x->expected = numbers(x->nc), x->size = numbers(x->nc);
    x->room = aligned_alloc(64, (most * sizeof(double) + 63) / 64 * 64);
    assert_non_null(x->room);
    x->work = x->room;
    for (size_t i = 0; i < most; i++) x->work[i] = NAN; // "not cleared"
}

static void clear(arrays *x)
{
    double *all[] = {x->a, x->b, x->c, x->expected, x->size, x->room};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
}

// Integers: every product and sum is exact, whatever the order. A guard behind c must survive.
static void check_integers(test_rng *rng, int nvars, const int *da, const int *db)
{
    arrays x;
    make(&x, nvars, da, db);
    for (size_t i = 0; i < x.na; i++) x.a[i] = test_int(rng, -9, 9);
    for (size_t i = 0; i < x.nb; i++) x.b[i] = test_int(rng, -9, 9);
    for (size_t i = 0; i < x.nc; i++) x.expected[i] = (double)(i % 7);
    double sign = test_int(rng, 0, 1) ? 1.0 : -1.0;
    kn_convolve_plain(x.expected, nvars, x.a, da, x.b, db, sign);
    for (int l = KN_CONVOLVE_SSE2; l <= (int)kn_convolve_best() + 1; l++) { // the last one: the public call
        for (size_t i = 0; i < x.nc; i++) x.c[i] = (double)(i % 7);
        x.c[x.nc] = 12345.0;
        if (l <= (int)kn_convolve_best())
            kn_convolve_as((kn_convolve_level)l, x.c, nvars, x.a, da, x.b, db, sign, x.work);
        else
            kn_convolve(x.c, nvars, x.a, da, x.b, db, sign, x.work);
        for (size_t i = 0; i < x.nc; i++)
            if (x.c[i] != x.expected[i])
                fail_msg("level %d, place %zu: %g, not %g (degrees .. %d, .. %d)", l, i, x.c[i], x.expected[i],
                         nvars ? da[nvars - 1] : 0, nvars ? db[nvars - 1] : 0);
        assert_true(x.c[x.nc] == 12345.0);
    }
    clear(&x);
}

static int lesser(int a, int b)
{
    return a < b ? a : b;
}

// The roundings L that kernel/convolve.h states.
static int stated(int nvars, const int *da, const int *db)
{
    int terms = 1, planes = 1, plane = 2;
    for (int d = 0; d < nvars; d++) {
        int pairs = lesser(da[d], db[d]) + 1;
        terms *= pairs;
        if (d < nvars - 2)
            planes *= pairs;
        else
            plane += pairs - 1;
    }
    return lesser(terms, 20 + planes * (plane + 40));
}

// Both ways of summing T terms are within gamma(T + 1) and gamma(L + 1) of the exact sum, |a| * |b| in size.
static void check_bound(test_rng *rng, int nvars, const int *da, const int *db)
{
    arrays x;
    make(&x, nvars, da, db);
    int terms = 1;
    for (int d = 0; d < nvars; d++) terms *= (da[d] < db[d] ? da[d] : db[d]) + 1;
    for (size_t i = 0; i < x.na; i++) x.a[i] = fabs(test_uniform(rng, -1, 1));
    for (size_t i = 0; i < x.nb; i++) x.b[i] = fabs(test_uniform(rng, -1, 1));
    memset(x.size, 0, x.nc * sizeof *x.size);
    kn_convolve_plain(x.size, nvars, x.a, da, x.b, db, 1.0);
    for (size_t i = 0; i < x.na; i++) x.a[i] *= test_int(rng, 0, 1) ? 1.0 : -1.0;
    for (size_t i = 0; i < x.nb; i++) x.b[i] *= test_int(rng, 0, 1) ? 1.0 : -1.0;
    memset(x.expected, 0, x.nc * sizeof *x.expected);
    kn_convolve_plain(x.expected, nvars, x.a, da, x.b, db, 1.0);
    double factor = (terms + 2 + stated(nvars, da, db) + 2) *
                    (DBL_EPSILON / 2); // gamma(n + 1) <= (n + 2) u, the size too
    for (kn_convolve_level l = KN_CONVOLVE_SSE2; l <= kn_convolve_best(); l++) {
        memset(x.c, 0, x.nc * sizeof *x.c);
        kn_convolve_as(l, x.c, nvars, x.a, da, x.b, db, 1.0, x.work);
        for (size_t i = 0; i < x.nc; i++) assert_true(fabs(x.c[i] - x.expected[i]) <= factor * x.size[i]);
    }
    clear(&x);
}

static int groups_met(int all, int size, int pairs)
{
    return lesser((all + size - 1) / size, (pairs + size - 2) / size + 1);
}

// The most roundings a term meets in the blocks that were chosen, for `planes` pairs of planes.
static int counted(const kn_convolution *p, int planes)
{
    int rows = p->thin[0] + 1, columns = p->thin[1] + 1, r = lesser(rows, p->wide[0] + 1);
    int c = lesser(columns, p->wide[1] + 1), down = groups_met(rows, p->rows, r);
    int across = planes * (groups_met(columns, p->columns, c) + p->parts - 1);
    int block = lesser(lesser(p->rows, rows) * lesser(p->columns, columns), r * c) + 1;
    return lesser(planes * r * c, block + (p->aside ? down + across : down * across));
}

static void roundings_as_stated(void **state)
{
    (void)state;
    test_rng rng = test_random(5);
    for (int level = KN_CONVOLVE_SSE2; level < KN_CONVOLVE_LEVELS; level++) // no machine is needed to count
        for (int round = test_scale(20000); round > 0; round--) {
            int da[4], db[4];
            for (int d = 0; d < 4; d++) {
                da[d] = test_int(&rng, 0, d < 2 ? 6 : KN_MAX_DEGREE);
                db[d] = test_int(&rng, 0, d < 2 ? 6 : KN_MAX_DEGREE - da[d]);
            }
            kn_convolution p;
            kn_convolution_init(&p, (kn_convolve_level)level, 2, da + 2, db + 2);
            int first = round % 3, planes = 1; // 4, 3 or 2 variables
            for (int d = first; d < 2; d++) planes *= lesser(da[d], db[d]) + 1;
            assert_true(counted(&p, planes) <= stated(4 - first, da + first, db + first));
        }
}

static void all_small_shapes(void **state)
{
    (void)state;
    test_rng rng = test_random(1);
    check_integers(&rng, 0, NULL, NULL);
    for (int m = 0; m <= 12; m++)
        for (int n = 0; n <= 12; n++) {
            check_integers(&rng, 1, (int[]){m}, (int[]){n});
            for (int rows = test_scale(4); rows > 0; rows--)
                check_integers(&rng, 2, (int[]){test_int(&rng, 0, 12), m}, (int[]){test_int(&rng, 0, 12), n});
            check_integers(&rng, 2, (int[]){m, n}, (int[]){m, n});
            check_integers(&rng, 2, (int[]){m, m}, (int[]){n, n});
        }
}

static void more_variables_and_large_ones(void **state)
{
    (void)state;
    static const int large[][4] = {{56, 56, 0, 0}, {28, 28, 28, 28}, {3, 45, 3, 11}, {45, 45, 3, 3}, {3, 3, 45, 45},
                                   {1, 55, 2, 1},  {25, 25, 25, 25}, {0, 56, 3, 0},  {16, 30, 7, 26}};
    test_rng rng = test_random(2);
    for (size_t i = 0; i < sizeof large / sizeof *large; i++) {
        check_integers(&rng, 2, (int[]){large[i][0], large[i][1]}, (int[]){large[i][2], large[i][3]});
        check_bound(&rng, 2, (int[]){large[i][0], large[i][1]}, (int[]){large[i][2], large[i][3]});
    }
    check_integers(&rng, 1, (int[]){56}, (int[]){56});
    for (int round = test_scale(60); round > 0; round--) {
        int nvars = test_int(&rng, 3, 4), da[4], db[4];
        for (int d = 0; d < nvars; d++) da[d] = test_int(&rng, 0, 5), db[d] = test_int(&rng, 0, 5);
        if (nvars == 3 && round % 2) da[2] = test_int(&rng, 0, 30);
        check_integers(&rng, nvars, da, db);
        check_bound(&rng, nvars, da, db);
    }
}

static void table_of_binomials(void **state)
{
    (void)state;
    long long row[KN_MAX_DEGREE + 2] = {1};
    for (int n = 0; n <= KN_MAX_DEGREE; n++) {
        for (int k = 0; k <= n; k++) {
            assert_true(kn_pascal(n)[k] == (double)row[k]);
            assert_true(kn_pascal_inverse(n)[k] == 1.0 / (double)row[k]);
        }
        for (int k = n + 1; k > 0; k--) row[k] += row[k - 1];
    }
}

// Division by one binomial product d below 2^44 rounds as / does, at every level; multiples of d divide exactly.
static void divisions(void **state)
{
    (void)state;
    test_rng rng = test_random(3);
    for (int round = test_scale(300); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), most[] = {0, 40, 24, 14}, da[3], zero[3] = {0};
        for (int d = 0; d < nvars; d++) da[d] = test_int(&rng, 0, most[nvars]);
        arrays x;
        make(&x, nvars, da, zero);
        size_t step[3] = {1, 1, 1};
        for (int d = nvars - 2; d >= 0; d--) step[d] = step[d + 1] * ((size_t)da[d + 1] + 1);
        kn_bernstein_weights(x.size, nvars, da);
        for (size_t i = 0; i < x.na; i++) {
            assert_true(x.size[i] < 0x1p44);
            x.a[i] = round % 2 ? ldexp(test_uniform(&rng, -1, 1), test_int(&rng, -30, 30))
                               : (double)test_int(&rng, -200, 200) * x.size[i];
        }
        if (round % 3 == 0) x.a[0] = INFINITY;
        for (kn_convolve_level l = KN_CONVOLVE_SSE2; l <= kn_convolve_best(); l++) {
            kn_convolution p; // by the constant 1: the sums are a
            kn_convolution_init(&p, l, nvars, da, zero);
            double *thin = x.work, *wide = thin + p.thin_room, *sums = wide + p.wide_room, unit = 1.0;
            size_t none[3] = {0};
            kn_convolution_pack_thin(&p, thin, p.swapped ? &unit : x.a, p.swapped ? none : step, false);
            kn_convolution_pack_wide(&p, wide, p.swapped ? x.a : &unit, p.swapped ? step : none, false);
            kn_convolution_clear(&p, sums);
            if (round % 3) { // zeros beside an infinity make NaN
                kn_convolution_run(&p, sums, thin, wide, 1.0);
            } else {
                for (size_t i = 0; i < x.na; i++) {
                    size_t rest = i, at = 0;
                    for (int d = 0; d < nvars; d++) at += rest / step[d] * p.sum_step[d], rest %= step[d];
                    sums[at] = x.a[i];
                }
            }
            kn_convolution_divide(&p, x.c, step, sums);
            for (size_t i = 0; i < x.na; i++) assert_true(x.c[i] == x.a[i] / x.size[i]);
        }
        clear(&x);
    }
}

// Scaled packing: one rounding for the weight times the coefficient where the weight is exact.
static void scaled_products(void **state)
{
    (void)state;
    test_rng rng = test_random(4);
    for (int round = test_scale(100); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), da[3], db[3];
        for (int d = 0; d < nvars; d++) da[d] = test_int(&rng, 0, 6), db[d] = test_int(&rng, 0, 6);
        arrays x;
        make(&x, nvars, da, db);
        for (size_t i = 0; i < x.na; i++) x.a[i] = test_int(&rng, -9, 9);
        for (size_t i = 0; i < x.nb; i++) x.b[i] = test_int(&rng, -9, 9);
        double *wa = numbers(x.na), *wb = numbers(x.nb), *wc = numbers(x.nc);
        int dc[3];
        for (int d = 0; d < nvars; d++) dc[d] = da[d] + db[d];
        kn_bernstein_weights(wa, nvars, da);
        kn_bernstein_weights(wb, nvars, db);
        kn_bernstein_weights(wc, nvars, dc);
        for (size_t i = 0; i < x.na; i++) wa[i] *= x.a[i];
        for (size_t i = 0; i < x.nb; i++) wb[i] *= x.b[i];
        memset(x.expected, 0, x.nc * sizeof *x.expected);
        kn_convolve_plain(x.expected, nvars, wa, da, wb, db, 1.0);
        for (kn_convolve_level l = KN_CONVOLVE_SSE2; l <= kn_convolve_best(); l++) {
            kn_convolution p;
            kn_convolution_init(&p, l, nvars, da, db);
            double *thin = x.work, *wide = thin + p.thin_room, *sums = wide + p.wide_room;
            size_t step_a[3] = {1, 1, 1}, step_b[3] = {1, 1, 1}, step_c[3] = {1, 1, 1};
            for (int d = nvars - 2; d >= 0; d--) {
                step_a[d] = step_a[d + 1] * ((size_t)da[d + 1] + 1);
                step_b[d] = step_b[d + 1] * ((size_t)db[d + 1] + 1);
                step_c[d] = step_c[d + 1] * ((size_t)dc[d + 1] + 1);
            }
            kn_convolution_pack_thin(&p, thin, p.swapped ? x.b : x.a, p.swapped ? step_b : step_a, true);
            kn_convolution_pack_wide(&p, wide, p.swapped ? x.a : x.b, p.swapped ? step_a : step_b, true);
            kn_convolution_clear(&p, sums);
            kn_convolution_run(&p, sums, thin, wide, 1.0);
            kn_convolution_divide(&p, x.c, step_c, sums);
            for (size_t i = 0; i < x.nc; i++) assert_true(x.c[i] == x.expected[i] / wc[i]);
        }
        free(wa);
        free(wb);
        free(wc);
        clear(&x);
    }
}

static void names(void **state)
{
    (void)state;
    assert_string_equal(kn_convolve_level_name(KN_CONVOLVE_SSE2), "SSE2");
    assert_string_equal(kn_convolve_level_name(KN_CONVOLVE_AVX512), "AVX-512");
    assert_string_equal(kn_convolve_level_name(KN_CONVOLVE_LEVELS), "?");
    assert_true(kn_convolve_best() < KN_CONVOLVE_LEVELS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_small_shapes),    cmocka_unit_test(more_variables_and_large_ones),
        cmocka_unit_test(table_of_binomials),  cmocka_unit_test(divisions),
        cmocka_unit_test(scaled_products),     cmocka_unit_test(names),
        cmocka_unit_test(roundings_as_stated),
    };
    return cmocka_run_group_tests_name("kernel/convolve", tests, NULL, NULL);
}
