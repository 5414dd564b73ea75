// SPDX-License-Identifier: Apache-2.0
// Fits of limited degree: bounds against long double samples, edges that agree exactly, continuity, failures.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fit/check.h"

// A sheet over the unit square of these degrees with smooth random relief; rational: with weights in [0.7, 1].
static void make_sheet(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int p, int q, bool rational)
{
    assert_int_equal(kn_bezier_init(ctx, out, 2, rational ? 4 : 3, rational, (int[]){p, q}), KN_OK);
    size_t n = kn_bezier_count(out);
    for (int i = 0; i <= p; i++)
        for (int j = 0; j <= q; j++) {
            size_t at = (size_t)(i * (q + 1) + j);
            double w = rational ? test_uniform(rng, 0.7, 1.0) : 1.0;
            double x[3] = {(double)i / p, (double)j / q, test_uniform(rng, -0.5, 0.5)};
            for (size_t c = 0; c < 3; c++) out->coef[c * n + at] = w * (x[c] + test_uniform(rng, -0.02, 0.02));
            if (rational) out->coef[3 * n + at] = w;
        }
}

// value[3] at (u,v), by de Casteljau in long double: of a piece, or of the span of a spline where (u,v) lies.
static void casteljau(long double value[3], const double *coef, size_t step, size_t n, int p, int q, size_t row,
                      bool rational, long double u, long double v)
{
    long double r[4] = {0}, b[64], line[64];
    for (int c = 0; c < (rational ? 4 : 3); c++) {
        for (int i = 0; i <= p; i++) {
            for (int j = 0; j <= q; j++) b[j] = coef[(size_t)c * n + (size_t)i * row + (size_t)j * step];
            for (int k = q; k > 0; k--)
                for (int j = 0; j < k; j++) b[j] = (1.0L - v) * b[j] + v * b[j + 1];
            line[i] = b[0];
        }
        for (int k = p; k > 0; k--)
            for (int i = 0; i < k; i++) line[i] = (1.0L - u) * line[i] + u * line[i + 1];
        r[c] = line[0];
    }
    for (int c = 0; c < 3; c++) value[c] = rational ? r[c] / r[3] : r[c];
}

static void piece_at(long double value[3], const kn_bezier *a, long double u, long double v)
{
    casteljau(value, a->coef, 1, kn_bezier_count(a), a->degree[0], a->degree[1], (size_t)a->degree[1] + 1,
              a->rational, u, v);
}

// de Boor at knots t, degree p, coefficients b of `count` (overwritten): exact where all numbers are dyadic and
// short.
static long double de_boor(const double *t, int p, int count, long double *b, long double x)
{
    int s = p;
    while (s < count - 1 && t[s + 1] <= x) s++;
    for (int r = 1; r <= p; r++)
        for (int i = s; i >= s - p + r; i--) {
            long double w = (x - t[i]) / ((long double)t[i + p - r + 1] - t[i]);
            b[i] = (1.0L - w) * b[i - 1] + w * b[i];
        }
    return b[s];
}

static void spline_at(long double value[3], const kn_spline *s, long double u, long double v)
{
    long double r[4] = {0}, *line = malloc(sizeof *line * (size_t)s->count[0]);
    long double *b = malloc(sizeof *b * (size_t)s->count[1]);
    assert_non_null(line), assert_non_null(b);
    for (int c = 0; c < s->ncomp; c++) {
        const double *coef = s->coef + (size_t)c * kn_spline_count(s);
        for (int i = 0; i < s->count[0]; i++) {
            for (int j = 0; j < s->count[1]; j++) b[j] = coef[(size_t)i * (size_t)s->count[1] + (size_t)j];
            line[i] = de_boor(s->knots[1], s->degree[1], s->count[1], b, v);
        }
        r[c] = de_boor(s->knots[0], s->degree[0], s->count[0], line, u);
    }
    for (int c = 0; c < 3; c++) value[c] = s->rational ? r[c] / r[3] : r[c];
    free(line), free(b);
}

static double distance(const long double a[3], const long double b[3])
{
    long double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return (double)sqrtl(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

static const double quanta[2] = {0.0, 0x1p-24};

// Samples are below the bound; the bound is below the tolerance, and not ten times the largest sample.
static void samples_below_bound(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    static const int limits[4][2] = {{3, 3}, {11, 5}, {15, 7}, {11, 11}};
    for (int run = 0; run < test_scale(12); run++) {
        kn_bezier a = {0};
        kn_spline out = {0};
        kn_fit_limited report;
        const int *limit = limits[run % 4];
        double tolerance = pow(10.0, -1.0 - run % 3);
        int r = test_int(&rng, 4, 24), t = test_int(&rng, 1, 24); // in this order
        make_sheet(ctx, &a, &rng, r, t, run % 5 == 4);
        kn_fit_limits l = {
            .max_degree = limit[0], .degree = limit[1], .tolerance = tolerance, .quantum = quanta[run % 2]};
        assert_int_equal(kn_fit_limit_degree(ctx, &out, NULL, &report, &a, &l), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &out), KN_OK);
        double most = 0.0;
        for (int i = 0; i < 400; i++) {
            long double u = test_uniform(&rng, 0.0, 1.0), v = test_uniform(&rng, 0.0, 1.0), x[3], y[3];
            piece_at(x, &a, u, v);
            spline_at(y, &out, u, v);
            most = fmax(most, distance(x, y));
        }
        assert_true(most <= report.error && report.error <= tolerance);
        if (report.exact) assert_true(report.error == 0.0);
        // Below, the bound is that of the rounding itself. And the worst span has samples, three at the least.
        if (report.error > 1e-11 && report.spans[0] * report.spans[1] <= 128)
            assert_true(report.error <= 10.0 * most);
        for (int v = 0; v < 2; v++) {
            assert_true(out.degree[v] <= limit[0]);
            assert_int_equal(out.degree[v], a.degree[v] <= limit[0] ? a.degree[v] : limit[1]);
            for (int k = out.degree[v] + 1; k < out.count[v]; k++) // C1: no knot more than p - 1 times
                assert_true(out.knots[v][k] < out.knots[v][k + out.degree[v] - 1]);
        }
        kn_bezier_clear(ctx, &a);
        kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

static bool same_numbers(const kn_spline *a, const kn_spline *b, bool turned)
{
    size_t n = kn_spline_count(a);
    if (a->degree[0] != b->degree[0] || n != kn_spline_count(b) || a->ncomp != b->ncomp) return false;
    for (size_t c = 0; c < (size_t)a->ncomp; c++)
        for (size_t i = 0; i < n; i++)
            if (a->coef[c * n + i] != b->coef[c * n + (turned ? n - 1 - i : i)]) return false;
    return memcmp(a->knots[0], b->knots[0], (n + (size_t)a->degree[0] + 1) * sizeof(double)) == 0; // symmetric
}

// Two sheets of different relief share an edge bit for bit, run through either way: so do their fitted edges. The
// ends of the fitted surfaces are the same to the last bit at every parameter, though they have different spans,
// where corners are short numbers, too: all numbers are then short dyadic ones, and long double is exact. Other
// corners stay what they are, and inserted knots round in the first and last span.
static void edges_agree_exactly(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    int differing = 0;
    const int runs = test_scale(8) > 8 ? test_scale(8) : 8; // in fewer no two sides have different spans
    for (int run = 0; run < runs; run++) {
        int p = test_int(&rng, 6, 20), q = test_int(&rng, 6, 16), degree = run % 4 == 3 ? 5 : 3;
        bool turned = run % 2, short_corners = run % 4 < 2;
        kn_bezier a = {0}, b = {0};
        kn_spline fit[2] = {{0}, {0}}, edge[2][4] = {{{0}, {0}, {0}, {0}}, {{0}, {0}, {0}, {0}}};
        kn_fit_limited report[2];
        make_sheet(ctx, &a, &rng, p, q, false);
        make_sheet(ctx, &b, &rng, p, test_int(&rng, 6, 16), false);
        size_t na = kn_bezier_count(&a), nb = kn_bezier_count(&b), ra = (size_t)q + 1, rb = (size_t)b.degree[1] + 1;
        double wild = run % 3; // b's inside may need many more spans
        for (size_t c = 0; c < 3; c++)
            for (int i = 0; i <= p; i++) {
                double *at = &a.coef[c * na + (size_t)i * ra + ra - 1];
                if (short_corners && (i == 0 || i == p)) *at = rint(*at * 0x1p20) * 0x1p-20;
                for (size_t j = 1; j < rb; j++)
                    if (c == 2) b.coef[c * nb + (size_t)i * rb + j] *= 1.0 + 5.0 * wild;
                b.coef[c * nb + (size_t)(turned ? p - i : i) * rb] = *at; // b's v = 0 is a's v = 1
            }
        kn_fit_limits l = {.max_degree = 5, .degree = degree, .tolerance = 4e-3, .quantum = 0x1p-20};
        assert_int_equal(kn_fit_limit_degree(ctx, &fit[0], edge[0], &report[0], &a, &l), KN_OK);
        assert_int_equal(kn_fit_limit_degree(ctx, &fit[1], edge[1], &report[1], &b, &l), KN_OK);
        differing += report[0].spans[0] != report[1].spans[0];
        assert_true(same_numbers(&edge[0][3], &edge[1][2], turned));
        for (int k = 0; k <= 128; k++) {
            long double x[3], y[3], z[3], u = k / 128.0L, at = turned ? 1.0L - u : u;
            spline_at(x, &fit[0], u, 1.0L);
            spline_at(y, &fit[1], at, 0.0L);
            double h = 1.0 / (kn_spline_spans(&edge[0][3], 0));
            bool inner = (double)u >= h && (double)u <= 1.0 - h;
            for (size_t c = 0; c < 3; c++) {
                long double line[512];
                const kn_spline *e = &edge[0][3];
                for (int i = 0; i < e->count[0]; i++) line[i] = e->coef[c * kn_spline_count(e) + (size_t)i];
                z[c] = de_boor(e->knots[0], e->degree[0], e->count[0], line, u);
                if (short_corners || inner) assert_true(x[c] == y[c] && x[c] == z[c]);
                // Up to 10 halvings, each a mean of numbers up to 2 that rounds by half an ulp at most.
                assert_true(fabsl(x[c] - y[c]) <= 20 * 0x1p-53L && fabsl(x[c] - z[c]) <= 20 * 0x1p-53L);
            }
        }
        for (int k = 0; k < 2; k++) // corners: a's
            for (size_t c = 0; c < 3; c++) {
                size_t n = kn_spline_count(&fit[0]), row = (size_t)fit[0].count[1];
                assert_true(fit[0].coef[c * n + (k ? n - 1 : row - 1)] == a.coef[c * na + (k ? na - 1 : ra - 1)]);
            }
        kn_bezier_clear(ctx, &a), kn_bezier_clear(ctx, &b);
        for (int k = 0; k < 2; k++) {
            kn_spline_clear(ctx, &fit[k]);
            for (int e = 0; e < 4; e++) kn_spline_clear(ctx, &edge[k][e]);
        }
    }
    assert_true(differing > 0);
    test_ctx_end(ctx, &memory);
}

// An edge whose degree is low enough stays as it is, bit for bit, though the surface is limited across it: its other
// face may be exact.
static void kept_edges_stay(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    kn_bezier a = {0};
    kn_spline out = {0}, edge[4] = {{0}, {0}, {0}, {0}};
    kn_fit_limits l = {.max_degree = 5, .tolerance = 1e-2, .quantum = 0x1p-20};
    make_sheet(ctx, &a, &rng, 4, 12, false);
    assert_int_equal(kn_fit_limit_degree(ctx, &out, edge, NULL, &a, &l), KN_OK);
    size_t na = kn_bezier_count(&a), n = kn_spline_count(&out), m = (size_t)out.count[1];
    assert_int_equal(out.count[0], 5);
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < 5; i++)
            for (size_t k = 0; k < 2; k++) {
                double x = a.coef[c * na + i * 13 + 12 * k];
                assert_true(edge[2 + k].coef[c * 5 + i] == x && out.coef[c * n + i * m + (m - 1) * k] == x);
            }
    kn_bezier_clear(ctx, &a);
    kn_spline_clear(ctx, &out);
    for (int e = 0; e < 4; e++) kn_spline_clear(ctx, &edge[e]);
    test_ctx_end(ctx, &memory);
}

// The angle between normals along the edges at samples, by evaluation of derivatives.
static double sampled_angle(kn_ctx *ctx, const kn_bezier *a, const kn_spline *out)
{
    double most = 0.0;
    for (int i = 0; i < 400; i++) {
        double along = (i / 4) / 99.0, at[2] = {i % 4 < 2 ? i % 2 : along, i % 4 < 2 ? along : i % 2}, d[2][9];
        double n[2][3], x[3];
        assert_int_equal(kn_bezier_derivatives(ctx, d[0], a, at, 1), KN_OK);
        assert_int_equal(kn_spline_derivatives(ctx, d[1], out, at, 1), KN_OK);
        for (int k = 0; k < 2; k++)
            for (int c = 0; c < 3; c++) {
                const double *r = d[k] + 3, *t = d[k] + 6;
                n[k][c] = r[(c + 1) % 3] * t[(c + 2) % 3] - r[(c + 2) % 3] * t[(c + 1) % 3];
            }
        for (int c = 0; c < 3; c++)
            x[c] = n[0][(c + 1) % 3] * n[1][(c + 2) % 3] - n[0][(c + 2) % 3] * n[1][(c + 1) % 3];
        double dot = n[0][0] * n[1][0] + n[0][1] * n[1][1] + n[0][2] * n[1][2];
        if (n[0][0] == 0.0 && n[0][1] == 0.0 && n[0][2] == 0.0) continue; // at a pole there is none
        most = fmax(most, atan2(sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]), dot));
    }
    return most;
}

// Normals along the edges turn by no more than is said, and what is said is not far above. A pole has no normal.
static void angles_are_bounded(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(7);
    for (int run = 0; run < test_scale(8); run++) {
        kn_bezier a = {0};
        kn_spline out = {0};
        kn_fit_limited report;
        kn_fit_limits l = {.max_degree = run % 2 ? 5 : 3, .tolerance = run % 4 < 2 ? 1e-2 : 1e-4};
        int r = test_int(&rng, 6, 12), t = test_int(&rng, 4, 12); // in this order
        make_sheet(ctx, &a, &rng, r, t, run % 4 == 3);
        size_t n = kn_bezier_count(&a), m = (size_t)a.degree[1] + 1;
        bool pole = run == 4;
        for (size_t c = 0; c < 3; c++)
            for (size_t j = 0; j < m && pole; j++) a.coef[c * n + j] = 0.0;
        assert_int_equal(kn_fit_limit_degree(ctx, &out, NULL, &report, &a, &l), KN_OK);
        // A pole is a place without a normal of the two edges that end there, too; steep sheets may have others.
        assert_true(report.singular_angles == (pole ? 3 : 0) && report.unknown_angles <= run / 8);
        for (int e = 0; e < 4 && pole; e++) assert_true(report.edge_singular[e] == (e != 1));
        if (pole) assert_true(report.edge_angle[0] == 0.0); // nowhere a normal
        for (int e = 0; e < 4; e++) assert_true(isinf(report.edge_angle[e]) || report.edge_angle[e] <= report.angle);
        if (report.unknown_angles == 0) {
            double most = sampled_angle(ctx, &a, &out);
            // The bound is a quotient of the worst of each span: within a few times the truth, 17 at most as seen.
            assert_true(most > 0.0 && most <= report.angle && report.angle <= 25.0 * most);
        }
        kn_bezier_clear(ctx, &a);
        kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// Angles that are asked for are kept, whatever the tolerance, by more spans; neighbours share their edges all the same.
static void angles_are_kept(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(8);
    size_t points[2] = {0, 0};
    int kept = 0;
    for (int run = 0; run < test_scale(12); run++) {
        kn_bezier a = {0}, b = {0};
        kn_spline out[2] = {{0}, {0}}, edge[2][4] = {{{0}, {0}, {0}, {0}}, {{0}, {0}, {0}, {0}}};
        kn_fit_limited report;
        double angle = pow(10.0, -1.0 - run % 3), size = run % 4 ? 1.0 : 0.03; // as small as the tolerance
        kn_fit_limits l = {.max_degree = run % 2 ? 5 : 3, .tolerance = 0.05, .quantum = 0x1p-16, .angle = angle};
        int r = test_int(&rng, 6, 14), t = test_int(&rng, 4, 14); // in this order
        make_sheet(ctx, &a, &rng, r, t, run % 5 == 4);
        make_sheet(ctx, &b, &rng, r, t, run % 5 == 4);
        size_t n = kn_bezier_count(&a), m = (size_t)t + 1;
        for (size_t c = 0; c < (size_t)a.ncomp; c++)
            for (size_t i = 0; i < n; i++) {
                double scale = c < 2 ? size : c == 2 ? 0.2 * size : 1.0; // less steep than others
                a.coef[c * n + i] *= scale, b.coef[c * n + i] *= scale;
            }
        for (size_t c = 0; c < (size_t)a.ncomp; c++)
            for (size_t i = 0; i < n; i += m) b.coef[c * n + i] = a.coef[c * n + i + m - 1]; // b's t = 0 is a's t = 1
        assert_int_equal(kn_fit_limit_degree(ctx, &out[1], edge[1], NULL, &b, &l), KN_OK);
        assert_int_equal(kn_fit_limit_degree(ctx, &out[0], edge[0], &report, &a, &l), KN_OK);
        assert_true(same_numbers(&edge[0][3], &edge[1][2], false));
        assert_true(report.unknown_angles == 0 && (report.wide_angles == 0) == (report.angle <= angle));
        // More than 32 spans are not tried.
        assert_true(report.wide_angles == 0 || report.spans[0] == 32 || report.spans[1] == 32);
        kept += report.wide_angles == 0;
        assert_true(report.error <= 0.05 && sampled_angle(ctx, &a, &out[0]) <= report.angle);
        points[0] += kn_spline_count(&out[0]);
        l.angle = 0.0;
        assert_int_equal(kn_fit_limit_degree(ctx, &out[0], NULL, &report, &a, &l), KN_OK);
        assert_int_equal(report.wide_angles, 0);
        points[1] += kn_spline_count(&out[0]);
        kn_bezier_clear(ctx, &a), kn_bezier_clear(ctx, &b);
        for (int k = 0; k < 2; k++) {
            kn_spline_clear(ctx, &out[k]);
            for (int e = 0; e < 4; e++) kn_spline_clear(ctx, &edge[k][e]);
        }
    }
    assert_true(points[1] < points[0] && kept > test_scale(12) / 2);
    test_ctx_end(ctx, &memory);
}

// An angle that some hundred spans would not keep is counted, and everything else holds.
static void angles_out_of_reach(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(9);
    kn_bezier a = {0};
    kn_spline out = {0};
    kn_fit_limited report;
    kn_fit_limits l = {.max_degree = 3, .tolerance = 1e-2, .angle = 1e-9};
    make_sheet(ctx, &a, &rng, 9, 8, false);
    assert_int_equal(kn_fit_limit_degree(ctx, &out, NULL, &report, &a, &l), KN_OK);
    assert_true(report.wide_angles == 4 && report.unknown_angles == 0 && report.angle > 1e-9);
    assert_true(report.error <= 1e-2 && report.spans[0] <= 32 && report.spans[1] <= 32);
    assert_true(sampled_angle(ctx, &a, &out) <= report.angle);
    kn_bezier_clear(ctx, &a);
    kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// The first difference of control points across an edge, row by row, times degree and spans: the derivative there.
static void across(double *out, const kn_spline *s, bool at_end)
{
    size_t rows = (size_t)s->count[1], n = (size_t)s->count[0], all = kn_spline_count(s);
    size_t edge = at_end ? rows - 1 : 0, beside = at_end ? rows - 2 : 1;
    double h = s->knots[1][s->degree[1] + 1], sign = at_end ? 1.0 : -1.0;
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < n; i++)
            out[c * n + i] = sign * s->degree[1] / h *
                             (s->coef[c * all + i * rows + edge] - s->coef[c * all + i * rows + beside]);
}

// Halves of one piece, which join smoothly: so do their fits where they have the same spans along the edge. Spans
// have equal lengths in each half, so derivatives compare without factors.
static void smooth_joints_stay(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    int compared = 0;
    for (int run = 0; run < test_scale(12); run++) {
        kn_bezier a = {0}, half[2] = {{0}, {0}};
        kn_spline fit[2] = {{0}, {0}};
        int r = test_int(&rng, 6, 20), t = test_int(&rng, 6, 20); // in this order
        make_sheet(ctx, &a, &rng, r, t, false);
        assert_int_equal(kn_bezier_subdivide(ctx, &half[0], &half[1], &a, 1, 0.5), KN_OK);
        kn_fit_limits l = {.max_degree = 3, .tolerance = 1e-3};
        for (int k = 0; k < 2; k++)
            assert_int_equal(kn_fit_limit_degree(ctx, &fit[k], NULL, NULL, &half[k], &l), KN_OK);
        if (fit[0].count[0] == fit[1].count[0]) {
            double one[3 * 512], two[3 * 512];
            size_t n = 3 * (size_t)fit[0].count[0];
            assert_true(n <= 3 * 512);
            across(one, &fit[0], true);
            across(two, &fit[1], false);
            // Some thousand roundings of numbers of size 1, times the degree and the number of spans.
            for (size_t i = 0; i < n; i++)
                assert_true(fabs(one[i] - two[i]) <= 4096.0 * 0x1p-53 * 20.0 * fit[0].count[1]);
            compared++;
        }
        for (int k = 0; k < 2; k++) kn_bezier_clear(ctx, &half[k]), kn_spline_clear(ctx, &fit[k]);
        kn_bezier_clear(ctx, &a);
    }
    assert_true(compared > 0);
    test_ctx_end(ctx, &memory);
}

// What the limit allows comes out as it was, bit for bit; curves and volumes work alike.
static void kinds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    kn_bezier a = {0};
    kn_spline out = {0};
    kn_fit_limited report;
    kn_fit_limits l = {.max_degree = 7, .tolerance = 1e-2};
    make_sheet(ctx, &a, &rng, 7, 5, false);
    assert_int_equal(kn_fit_limit_degree(ctx, &out, NULL, &report, &a, &l), KN_OK);
    assert_true(report.exact && report.error == 0.0 && report.spans[0] == 1 && report.spans[1] == 1);
    assert_memory_equal(out.coef, a.coef, 3 * kn_bezier_count(&a) * sizeof *a.coef);
    kn_bezier_clear(ctx, &a);
    for (int nvars = 1; nvars <= 3; nvars += 2) {
        assert_int_equal(kn_bezier_init(ctx, &a, nvars, 3, false, (int[]){9, 2, 8}), KN_OK);
        for (size_t i = 0; i < 3 * kn_bezier_count(&a); i++) a.coef[i] = test_uniform(&rng, -1.0, 1.0);
        assert_int_equal(kn_fit_limit_degree(ctx, &out, NULL, &report, &a, &l), KN_OK);
        assert_true(!report.exact && report.error <= 1e-2 && out.nvars == nvars);
        for (int i = 0; i < 200; i++) {
            double at[3], x[3], y[3], sum = 0.0;
            for (int v = 0; v < 3; v++) at[v] = test_uniform(&rng, 0.0, 1.0);
            assert_int_equal(kn_bezier_eval(ctx, x, &a, at), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, y, &out, at), KN_OK);
            for (int c = 0; c < 3; c++) sum += (x[c] - y[c]) * (x[c] - y[c]);
            assert_true(sqrt(sum) <= report.error + 1e-13); // evaluation: some hundred roundings of numbers up to 1
        }
        kn_bezier_clear(ctx, &a);
    }
    kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    kn_bezier a = {0}, empty = {0};
    kn_spline out = {0};
    make_sheet(ctx, &a, &rng, 9, 9, false);
    const struct {
        kn_fit_limits limits;
        kn_status status;
    } cases[] = {
        {{.max_degree = 2, .tolerance = 1.0}, KN_EDOMAIN},
        {{.max_degree = 5, .degree = 6, .tolerance = 1.0}, KN_EDOMAIN},
        {{.max_degree = 5, .degree = 2, .tolerance = 1.0}, KN_EDOMAIN},
        {{.max_degree = 3, .tolerance = 0.0}, KN_EDOMAIN},
        {{.max_degree = 3, .tolerance = NAN}, KN_EDOMAIN},
        {{.max_degree = 3, .tolerance = 1.0, .quantum = 0.3}, KN_EDOMAIN},
        {{.max_degree = 3, .tolerance = 1.0, .quantum = 0.5}, KN_EDOMAIN},
        {{.max_degree = 3, .tolerance = 1.0, .angle = -0.1}, KN_EDOMAIN},
        {{.max_degree = 3, .tolerance = 1.0, .angle = 0.9}, KN_EDOMAIN},
        {{.max_degree = 3, .tolerance = 1.0, .angle = NAN}, KN_EDOMAIN},
        {{.max_degree = 3, .tolerance = 1.0, .max_level = 11}, KN_ELIMIT},
        {{.max_degree = 3, .tolerance = 1e-9, .max_level = 2}, KN_EUNDECIDED},
        {{.max_degree = 3, .tolerance = 1e-300}, KN_EUNDECIDED},
    };
    kn_fit_limited report = {.error = -1.0};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(kn_fit_limit_degree(ctx, &out, NULL, &report, &a, &cases[i].limits), cases[i].status);
        assert_true(out.coef == NULL && report.error == -1.0);
    }
    kn_fit_limits l = {.max_degree = 3, .tolerance = 1e-2};
    assert_int_equal(kn_fit_limit_degree(ctx, &out, NULL, &report, &empty, &l), KN_EDOMAIN);
    a.coef[7] = NAN;
    assert_int_equal(kn_fit_limit_degree(ctx, &out, NULL, &report, &a, &l), KN_EUNDEFINED);
    kn_bezier_clear(ctx, &a);
    test_ctx_end(ctx, &memory);
}

static kn_status starved(kn_ctx *ctx, void *user)
{
    kn_bezier a = {0};
    kn_spline out = {0}, edge[4] = {{0}, {0}, {0}, {0}};
    kn_fit_limited report = {.error = -1.0};
    (void)user;
    kn_status status = kn_bezier_init(ctx, &a, 2, 3, false, (int[]){6, 5});
    for (size_t i = 0; status == KN_OK && i < 3 * kn_bezier_count(&a); i++) a.coef[i] = sin((double)i);
    kn_fit_limits l = {.max_degree = 3, .tolerance = 0.05};
    if (status == KN_OK) status = kn_fit_limit_degree(ctx, &out, edge, &report, &a, &l);
    if (status != KN_OK) assert_true(!out.coef && !edge[0].coef && report.error == -1.0);
    for (int e = 0; e < 4; e++) kn_spline_clear(ctx, &edge[e]);
    kn_bezier_clear(ctx, &a);
    kn_spline_clear(ctx, &out);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_allocation_failures(starved, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_below_bound),
        cmocka_unit_test(edges_agree_exactly),
        cmocka_unit_test(kept_edges_stay),
        cmocka_unit_test(angles_are_bounded),
        cmocka_unit_test(angles_are_kept),
        cmocka_unit_test(angles_out_of_reach),
        cmocka_unit_test(smooth_joints_stay),
        cmocka_unit_test(kinds),
        cmocka_unit_test(failures),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("fit/limit_degree", tests, NULL, NULL);
}
