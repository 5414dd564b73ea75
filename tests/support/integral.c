// SPDX-License-Identifier: Apache-2.0
#include "tests/support/integral.h"

#include "tests/support/support.h"

#include <math.h>

enum { MOST_NODES = 96, RATIONAL_NODES = 24, AREA_NODES = 12 };

// Newton on the Legendre polynomial, from its asymptotic roots.
void test_gauss(int n, double *node, double *weight)
{
    const double pi = acos(-1.0);
    for (int i = 0; i < n; i++) {
        double x = cos(pi * (i + 0.75) / (n + 0.5)), slope = 1.0;
        for (int round = 0; round < 8; round++) {
            double p = x, before = 1.0;
            for (int k = 2; k <= n; k++) {
                double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
                before = p, p = next;
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            if (n > 1) x -= p / slope;
        }
        node[i] = 0.5 * (1.0 - x);
        weight[i] = n == 1 ? 1.0 : 1.0 / ((1.0 - x * x) * slope * slope);
    }
}

static void add_box(kn_ctx *ctx, double *volume, double *area, const kn_spline *s, const double lo[2],
                    const double hi[2], bool reversed)
{
    static double at[2 * MOST_NODES * MOST_NODES], out[9 * MOST_NODES * MOST_NODES];
    double node[2][MOST_NODES], weight[2][MOST_NODES], sign = reversed ? -1.0 : 1.0;
    int n[2];
    for (int v = 0; v < 2; v++) { // det(x, x_r, x_t) is of degree 3 p - 1 at most
        n[v] = (3 * s->degree[v] + 1) / 2;
        if (n[v] < AREA_NODES) n[v] = AREA_NODES;
        if (s->rational && n[v] < RATIONAL_NODES) n[v] = RATIONAL_NODES;
        assert_true(n[v] <= MOST_NODES);
        test_gauss(n[v], node[v], weight[v]);
    }
    size_t count = 0;
    for (int i = 0; i < n[0]; i++)
        for (int j = 0; j < n[1]; j++, count++) {
            at[2 * count] = lo[0] + (hi[0] - lo[0]) * node[0][i];
            at[2 * count + 1] = lo[1] + (hi[1] - lo[1]) * node[1][j];
        }
    assert_int_equal(kn_spline_eval_batch_partials(ctx, out, s, count, at), KN_OK);
    for (size_t k = 0; k < count; k++) {
        const double *x = out + 9 * k, *r = x + 3, *t = x + 6;
        double c[3] = {r[1] * t[2] - r[2] * t[1], r[2] * t[0] - r[0] * t[2], r[0] * t[1] - r[1] * t[0]};
        double w = weight[0][k / (size_t)n[1]] * weight[1][k % (size_t)n[1]] * (hi[0] - lo[0]) * (hi[1] - lo[1]);
        *volume += sign * w * (x[0] * c[0] + x[1] * c[1] + x[2] * c[2]) / 3.0;
        *area += w * sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    }
}

void test_add_integrals(kn_ctx *ctx, double *volume, double *area, const kn_patch *patch)
{
    kn_spline s = kn_patch_spline(patch);
    assert_int_equal(s.nvars, 2);
    const double *u = s.knots[0], *v = s.knots[1];
    for (int i = s.degree[0]; i < s.count[0]; i++)
        for (int j = s.degree[1]; j < s.count[1]; j++)
            if (u[i] < u[i + 1] && v[j] < v[j + 1])
                add_box(ctx, volume, area, &s, (double[2]){u[i], v[j]}, (double[2]){u[i + 1], v[j + 1]},
                        patch->reversed);
}

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)product;
    test_integrals *sums = user;
    for (size_t i = 0; i < block->count; i++) {
        const kn_patch *patch = &block->patches[i];
        if (kn_patch_nvars(patch) == 2) {
            test_add_integrals(ctx, &sums->volume, &sums->area, patch);
            sums->faces++;
        }
        for (int k = 0; k < 6 && kn_patch_nvars(patch) == 3; k++) {
            kn_patch face = {0};
            if (patch->hidden >> k & 1) continue;
            assert_int_equal(kn_patch_face(ctx, &face, patch, k), KN_OK);
            test_add_integrals(ctx, &sums->volume, &sums->area, &face);
            kn_bezier_clear(ctx, &face.bezier);
            sums->faces++;
        }
    }
    return KN_OK;
}

kn_sink test_integral_sink(test_integrals *out)
{
    return (kn_sink){.user = out, .commit = commit};
}
