// SPDX-License-Identifier: Apache-2.0
// How far contours are from the true ones, in long double: below what their certificate says, at any scale and place.
#include "tests/support/support.h"

#include <knurl/slice.h>

#include <math.h>
#include <stdlib.h>

// ---- a patch in long double ----

// (X, Y, Z) / W and its partials at (r,t), by de Casteljau's algorithm: out[0] the value, [1] and [2] the partials.
static void direct(long double out[3][3], const kn_bezier *p, long double r, long double t)
{
    int n = p->degree[0], m = p->degree[1];
    long double h[4][3] = {{0}};
    for (int c = 0; c < 4; c++) {
        long double grid[8][8];
        for (int i = 0; i <= n; i++)
            for (int j = 0; j <= m; j++)
                grid[i][j] = c < p->ncomp ? (long double)p->coef[(c * (n + 1) + i) * (m + 1) + j] : 1.0L;
        for (int i = 0; i <= n; i++)
            for (int k = 1; k < m; k++)
                for (int j = 0; j <= m - k; j++) grid[i][j] = (1 - t) * grid[i][j] + t * grid[i][j + 1];
        for (int j = 0; j < 2; j++)
            for (int k = 1; k < n; k++)
                for (int i = 0; i <= n - k; i++) grid[i][j] = (1 - r) * grid[i][j] + r * grid[i + 1][j];
        long double lo = (1 - t) * grid[0][0] + t * grid[0][1], hi = (1 - t) * grid[1][0] + t * grid[1][1];
        h[c][0] = (1 - r) * lo + r * hi;
        h[c][1] = n * (hi - lo);
        h[c][2] = m * ((1 - r) * (grid[0][1] - grid[0][0]) + r * (grid[1][1] - grid[1][0]));
    }
    for (int c = 0; c < 3; c++) {
        out[0][c] = h[c][0] / h[3][0];
        for (int k = 1; k < 3; k++) out[k][c] = (h[c][k] - h[3][k] * out[0][c]) / h[3][0];
    }
}

// The distance in the plane of q from the contour at z, near it: zero of Z - z and of (P - q) along the contour's
// tangent, by Newton's method from the nearest of some points.
static long double distance(const kn_bezier *p, const double q[2], double z, double size)
{
    enum { GRID = 12 };
    long double at[2] = {0}, least = INFINITY, s[3][3];
    for (int i = 0; i <= GRID; i++)
        for (int j = 0; j <= GRID; j++) {
            direct(s, p, (long double)i / GRID, (long double)j / GRID);
            long double d = hypotl(hypotl(s[0][0] - q[0], s[0][1] - q[1]), s[0][2] - z);
            if (d < least) least = d, at[0] = (long double)i / GRID, at[1] = (long double)j / GRID;
        }
    for (int k = 0; k < 14; k++) {
        direct(s, p, at[0], at[1]);
        // along Z_t, -Z_r in parameters; (x, y) of it in space
        long double tx = s[2][2] * s[1][0] - s[1][2] * s[2][0], ty = s[2][2] * s[1][1] - s[1][2] * s[2][1];
        long double l = hypotl(tx, ty), f = s[0][2] - z, g = ((s[0][0] - q[0]) * tx + (s[0][1] - q[1]) * ty) / l;
        long double gr = (s[1][0] * tx + s[1][1] * ty) / l, gt = (s[2][0] * tx + s[2][1] * ty) / l;
        long double det = s[1][2] * gt - s[2][2] * gr;
        at[0] -= (f * gt - s[2][2] * g) / det;
        at[1] -= (s[1][2] * g - f * gr) / det;
    }
    direct(s, p, at[0], at[1]);
    assert_true(fabsl(s[0][2] - z) <= 1e-15L * (fabsl(z) + size));
    return hypotl(s[0][0] - q[0], s[0][1] - q[1]);
}

// ---- contours against it ----

typedef struct looker {
    const kn_bezier *patch;
    double tol, size;
    size_t points, layers, doubtful;
    double error, most;
    bool check;
} looker;

static kn_status look(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    (void)ctx;
    looker *l = user;
    l->layers++;
    l->doubtful += layer->doubtful;
    l->error = fmax(l->error, layer->error);
    for (size_t i = 0; l->check && i < layer->nloops; i++) {
        const kn_slice_loop *loop = &layer->loops[i];
        size_t step = loop->npoints / 5 + 1; // some of them
        for (size_t k = 0; k + 1 < loop->npoints; k += step)
            for (int half = 0; half < 2; half++, l->points++) {
                const double *a = loop->points + 2 * k;
                double q[2] = {a[0] + 0.5 * half * (a[2] - a[0]), a[1] + 0.5 * half * (a[3] - a[1])};
                // half a unit in the last place of q for the middle
                long double d = distance(l->patch, q, layer->z, l->size);
                l->most = fmax(l->most, (double)d);
                assert_true(d <= layer->error + 0x1p-52L * (fabs(q[0]) + fabs(q[1])));
            }
    }
    return KN_OK;
}

// A wavy patch with slopes: Z rises with r over the whole of it, so that contours are graphs.
static void make_patch(kn_ctx *ctx, kn_bezier *p, bool rational, double size, double far, test_rng *rng)
{
    const int degree[2] = {4, 3};
    assert_int_equal(kn_bezier_init(ctx, p, 2, rational ? 4 : 3, rational, degree), KN_OK);
    for (int i = 0; i <= 4; i++)
        for (int j = 0; j <= 3; j++) {
            double w = rational ? test_uniform(rng, 0.9, 1.1) : 1.0;
            double x[3] = {i / 4.0 + test_uniform(rng, -0.1, 0.1), j / 3.0 + test_uniform(rng, -0.1, 0.1),
                           i / 4.0 + test_uniform(rng, -0.3, 0.3)};
            for (int c = 0; c < 3; c++) p->coef[(c * 5 + i) * 4 + j] = w * (far + size * x[c]);
            if (rational) p->coef[(3 * 5 + i) * 4 + j] = w;
        }
}

static void slice(kn_ctx *ctx, looker *l, const kn_slice_options *o)
{
    kn_sink sink;
    kn_patch patch = {.bezier = *l->patch};
    kn_patch_block block = {0, 1, &patch};
    void *product = NULL;
    assert_int_equal(kn_slice_sink(ctx, &sink, o, look, l), KN_OK);
    assert_int_equal(sink.work(ctx, sink.user, &block, &product), KN_OK);
    assert_int_equal(sink.commit(ctx, sink.user, &block, product), KN_OK);
    assert_int_equal(sink.end(ctx, sink.user), KN_OK);
    kn_sink_close(ctx, &sink);
}

static void within_the_certificate(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    const double sizes[] = {1.0, 1e-3, 1e3, 1.0, 1.0}, places[] = {0.0, 0.0, 0.0, 1e5, -1e5};
    const double tols[] = {1e-3, 1e-5, 1e-2, 1e-4, 1e-6};
    for (int k = 0; k < 5; k++)
        for (int rational = 0; rational < 2; rational++) {
            kn_bezier p = {0};
            make_patch(ctx, &p, rational, sizes[k], places[k], &rng);
            looker l = {.patch = &p, .tol = tols[k], .size = sizes[k], .check = true};
            kn_slice_options o = {places[k] + 0.25 * sizes[k], 0.25 * sizes[k], 3, tols[k], 0};
            slice(ctx, &l, &o);
            assert_int_equal(l.layers, 3);
            assert_int_equal(l.doubtful, 0);
            assert_true(l.error > 0 && l.error <= tols[k]);
            assert_true(l.points >= 6);
            assert_true(l.most > 0.02 * l.error); // and it is no idle bound
            kn_bezier_clear(ctx, &p);
        }
    test_ctx_end(ctx, &memory);
}

// What the numbers do not tell is not claimed: a tolerance below the rounding of coordinates is doubted, and the
// certificate says what holds.
static void finer_than_the_numbers(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    kn_bezier p = {0};
    make_patch(ctx, &p, false, 1.0, 1e5, &rng);
    looker l = {.patch = &p, .tol = 1e-10, .size = 1.0};
    kn_slice_options o = {1e5 + 0.5, 1.0, 1, 1e-10, 0};
    slice(ctx, &l, &o);
    assert_true(l.doubtful > 0 && l.error > 1e-10);
    assert_true(l.error < 1e-7); // some hundred roundings of 1e5
    kn_bezier_clear(ctx, &p);
    test_ctx_end(ctx, &memory);
}

// A layer hears of its own doubts alone.
static kn_status count_doubts(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    (void)ctx;
    size_t *doubts = user;
    doubts[layer->index] = layer->doubtful;
    return KN_OK;
}

static void doubts_are_of_a_layer(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier p = {0};
    const int degree[2] = {2, 2};
    size_t doubts[3] = {0};
    assert_int_equal(kn_bezier_init(ctx, &p, 2, 3, false, degree), KN_OK);
    for (int i = 0; i < 3; i++) // z = 4 (r - 1/2) (t - 1/2): a saddle at height 0
        for (int j = 0; j < 3; j++) {
            p.coef[3 * i + j] = i, p.coef[9 + 3 * i + j] = j;
            p.coef[18 + 3 * i + j] = (i - 1) * (j - 1);
        }
    kn_sink sink;
    kn_patch patch = {.bezier = p};
    kn_patch_block block = {0, 1, &patch};
    void *product = NULL;
    kn_slice_options o = {-0.5, 0.5, 3, 1e-3, 0};
    assert_int_equal(kn_slice_sink(ctx, &sink, &o, count_doubts, doubts), KN_OK);
    assert_int_equal(sink.work(ctx, sink.user, &block, &product), KN_OK);
    assert_int_equal(sink.commit(ctx, sink.user, &block, product), KN_OK);
    assert_int_equal(sink.end(ctx, sink.user), KN_OK);
    kn_sink_close(ctx, &sink);
    assert_int_equal(doubts[0], 0);
    assert_true(doubts[1] > 0);
    assert_int_equal(doubts[2], 0);
    kn_bezier_clear(ctx, &p);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(within_the_certificate),
                                       cmocka_unit_test(finer_than_the_numbers),
                                       cmocka_unit_test(doubts_are_of_a_layer)};
    return cmocka_run_group_tests_name("slice/error", tests, NULL, NULL);
}
