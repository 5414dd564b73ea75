// SPDX-License-Identifier: Apache-2.0
// Surfaces that the tests of shells share, and their direct evaluation in long double.
#include "tests/support/surfaces.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const surface_case surface_cases[SURFACE_CASES] = {
    {"plane", make_plane}, {"cylinder", make_cylinder},         {"torus", make_torus},     {"sphere", make_sphere},
    {"wavy", make_wavy},   {"double knots", make_double_knots}, {"quintic", make_quintic},
};

static void build(kn_ctx *ctx, kn_spline *out, bool rational, const int *degree, const int *count, const double *ku,
                  const double *kv, const double *coef)
{
    const double *knots[2] = {ku, kv};
    assert_int_equal(kn_spline_init(ctx, out, 2, rational ? 4 : 3, rational, degree, count, knots, coef), KN_OK);
}

void make_plane(kn_ctx *ctx, kn_spline *out)
{
    const double k[4] = {0, 0, 1, 1}, coef[12] = {0, 0, 2, 2, 0, 3, 0, 3, 1, 1, 1, 1};
    build(ctx, out, false, (const int[2]){1, 1}, (const int[2]){2, 2}, k, k, coef);
}

// ---- surfaces of revolution: a profile of homogeneous (radius, height, weight) swept around the z axis ----

static void revolve(kn_ctx *ctx, kn_spline *out, int degree, int count, const double *kv, const double profile[][3])
{
    static const double ku[12] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
    static const double x[9] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, y[9] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
    double coef[4 * 9 * 9];
    int n = 9 * count;
    for (int i = 0; i < 9; i++)
        for (int j = 0; j < count; j++) {
            double w = (i % 2 ? sqrt(0.5) : 1.0) * profile[j][2];
            coef[i * count + j] = x[i] * profile[j][0] * w;
            coef[n + i * count + j] = y[i] * profile[j][0] * w;
            coef[2 * n + i * count + j] = profile[j][1] * w;
            coef[3 * n + i * count + j] = w;
        }
    build(ctx, out, true, (const int[2]){2, degree}, (const int[2]){9, count}, ku, kv, coef);
}

void make_cylinder(kn_ctx *ctx, kn_spline *out)
{
    const double kv[4] = {0, 0, 2, 2}, profile[2][3] = {{1, 0, 1}, {1, 2, 1}};
    revolve(ctx, out, 1, 2, kv, profile);
}

void make_torus(kn_ctx *ctx, kn_spline *out)
{
    const double kv[12] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, h = sqrt(0.5);
    const double profile[9][3] = {{4, 0, 1},  {4, 1, h},  {3, 1, 1},  {2, 1, h}, {2, 0, 1},
                                  {2, -1, h}, {3, -1, 1}, {4, -1, h}, {4, 0, 1}};
    revolve(ctx, out, 2, 9, kv, profile);
}

void make_sphere(kn_ctx *ctx, kn_spline *out)
{
    const double kv[8] = {0, 0, 0, 1, 1, 2, 2, 2}, h = sqrt(0.5);
    const double profile[5][3] = {{0, -2, 1}, {2, -2, h}, {2, 0, 1}, {2, 2, h}, {0, 2, 1}};
    revolve(ctx, out, 2, 5, kv, profile);
}

void make_vase(kn_ctx *ctx, kn_spline *out)
{
    const double kv[11] = {0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4};
    const double profile[7][3] = {{1.0, 0, 1},     {2.2, 0.4, 0.8}, {2.4, 1.8, 1.3}, {1.0, 3.0, 0.9},
                                  {0.6, 3.8, 1.2}, {0.8, 4.6, 0.7}, {1.3, 5.0, 1}};
    revolve(ctx, out, 3, 7, kv, profile);
}

// ---- height fields over the control points' own grid ----

static void height_field(kn_ctx *ctx, kn_spline *out, const int *degree, const int *count, const double *ku,
                         const double *kv)
{
    double coef[3 * 100];
    int n = count[0] * count[1];
    for (int i = 0; i < count[0]; i++)
        for (int j = 0; j < count[1]; j++) {
            coef[i * count[1] + j] = i;
            coef[n + i * count[1] + j] = j;
            coef[2 * n + i * count[1] + j] = 0.25 * ((i * 5 + j * 3) % 4) - 0.125 * ((i * j) % 3);
        }
    build(ctx, out, false, degree, count, ku, kv, coef);
}

void make_wavy(kn_ctx *ctx, kn_spline *out)
{
    const double ku[10] = {0, 0, 0, 0, 1, 2, 3, 3, 3, 3}, kv[9] = {0, 0, 0, 0, 2, 3, 3, 3, 3};
    height_field(ctx, out, (const int[2]){3, 3}, (const int[2]){6, 5}, ku, kv);
}

void make_double_knots(kn_ctx *ctx, kn_spline *out)
{
    const double ku[10] = {0, 0, 0, 0, 1, 1, 2, 2, 2, 2}, kv[11] = {0, 0, 0, 0, 1, 1, 2, 3, 3, 3, 3};
    height_field(ctx, out, (const int[2]){3, 3}, (const int[2]){6, 7}, ku, kv);
}

void make_quintic(kn_ctx *ctx, kn_spline *out)
{
    const double ku[14] = {-1, -1, -1, -1, -1, -1, 0, 2, 3, 3, 3, 3, 3, 3};
    const double kv[11] = {5, 5, 5, 5, 5, 6, 7, 7, 7, 7, 7};
    height_field(ctx, out, (const int[2]){5, 4}, (const int[2]){8, 6}, ku, kv);
}

void make_waves(kn_ctx *ctx, kn_spline *out)
{
    enum { N = 20 };
    double knots[N + 4], coef[3 * N * N];
    for (int i = 0; i < N + 4; i++) knots[i] = i < 4 ? 0.0 : i >= N ? N - 3 : i - 3;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            double *c = coef + N * i + j;
            c[0] = i, c[N * N] = j, c[2 * N * N] = 1.5 * sin(0.9 * i + 0.3 * j) * cos(0.8 * j - 0.2 * i);
        }
    build(ctx, out, false, (const int[2]){3, 3}, (const int[2]){N, N}, knots, knots, coef);
}

// ---- the teapot ----

static bool read_patch(FILE *file, double coef[48], int patch)
{
    int patches, degree[2];
    if (fscanf(file, "%d", &patches) != 1 || patch >= patches) return false;
    for (int k = 0; k <= patch; k++) {
        if (fscanf(file, "%d %d", &degree[0], &degree[1]) != 2 || degree[0] != 3 || degree[1] != 3) return false;
        for (int j = 0; j < 4; j++) // u runs fastest in the file
            for (int i = 0; i < 4; i++)
                for (int c = 0; c < 3; c++)
                    if (fscanf(file, "%lf", &coef[16 * c + 4 * i + j]) != 1) return false;
    }
    return true;
}

void make_dome(kn_ctx *ctx, kn_spline *out)
{
    static const double knots[8] = {0, 0, 0, 0, 1, 1, 1, 1}, height[4] = {0.0, 0.0, -0.1, -0.3};
    const double *both[2] = {knots, knots};
    double coef[48];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double a = 0.5 * i, r = j / 3.0;
            coef[4 * i + j] = r * cos(a), coef[16 + 4 * i + j] = r * sin(a), coef[32 + 4 * i + j] = height[j];
        }
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[2]){3, 3}, (const int[2]){4, 4}, both, coef),
                     KN_OK);
}

bool make_teapot(kn_ctx *ctx, kn_spline *out, int patch)
{
    const double k[8] = {0, 0, 0, 0, 1, 1, 1, 1};
    double coef[48];
    FILE *file = fopen("data/teapot.bpt", "r");
    if (!file) return false;
    bool read = read_patch(file, coef, patch);
    fclose(file);
    if (read) build(ctx, out, false, (const int[2]){3, 3}, (const int[2]){4, 4}, k, k, coef);
    return read;
}

// ---- direct evaluation ----

// The p + 1 B-splines that do not vanish on the span of t, and their slopes, by the recurrence of de Boor and Cox.
static int b_splines(long double *value, long double *slope, const double *k, int p, int count, long double t)
{
    int span = p;
    while (span < count - 1 && (long double)k[span + 1] <= t) span++;
    while (span > p && k[span] == k[span + 1]) span--;
    int first = span - p;
    long double w[16] = {0};
    w[p] = 1.0L;
    for (int q = 1; q <= p; q++) {
        long double next[16] = {0};
        for (int i = p - q; i <= p; i++) {
            int g = first + i;
            long double a = (long double)k[g + q] - k[g], c = (long double)k[g + q + 1] - k[g + 1];
            long double left = a > 0 ? w[i] / a : 0.0L, right = c > 0 && i < p ? w[i + 1] / c : 0.0L;
            if (q == p) slope[i] = p * (left - right);
            next[i] = left * (t - k[g]) + right * (k[g + q + 1] - t);
        }
        memcpy(w, next, sizeof w);
    }
    memcpy(value, w, sizeof w);
    return first;
}

void direct_spline(long double *out, const kn_spline *s, long double u, long double v)
{
    static const int shape[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    size_t count = kn_spline_count(s), columns = (size_t)s->count[1];
    long double b[2][2][16];
    int first[2] = {b_splines(b[0][0], b[0][1], s->knots[0], s->degree[0], s->count[0], u),
                    b_splines(b[1][0], b[1][1], s->knots[1], s->degree[1], s->count[1], v)};
    for (int m = 0; m < 3; m++)
        for (int c = 0; c < s->ncomp; c++) {
            long double sum = 0.0L;
            for (int i = 0; i <= s->degree[0]; i++)
                for (int j = 0; j <= s->degree[1]; j++)
                    sum += b[0][shape[m][0]][i] * b[1][shape[m][1]][j] *
                           s->coef[(size_t)c * count + (size_t)(first[0] + i) * columns + (size_t)(first[1] + j)];
            out[m * s->ncomp + c] = sum;
        }
}

typedef struct basis {
    size_t first;
    long double value[16], slope[16];
} basis;

// One u at a time: the net is contracted to two curves in v, of values and of slopes in u.
void direct_grid(long double *out, const kn_spline *s, size_t nu, const double *u, size_t nv, const double *v)
{
    size_t count = kn_spline_count(s), columns = (size_t)s->count[1], ncomp = (size_t)s->ncomp;
    long double *row = calloc(2 * ncomp * columns, sizeof *row);
    basis *across = calloc(nv, sizeof *across), b;
    assert_true(row && across);
    for (size_t j = 0; j < nv; j++)
        across[j].first = (size_t)b_splines(across[j].value, across[j].slope, s->knots[1], s->degree[1], s->count[1],
                                            v[j]);
    for (size_t i = 0; i < nu; i++) {
        b.first = (size_t)b_splines(b.value, b.slope, s->knots[0], s->degree[0], s->count[0], u[i]);
        for (size_t k = 0; k < 2 * ncomp * columns; k++) {
            const double *from = s->coef + k / columns % ncomp * count + b.first * columns + k % columns;
            const long double *w = k < ncomp * columns ? b.value : b.slope;
            row[k] = 0.0L;
            for (int a = 0; a <= s->degree[0]; a++) row[k] += w[a] * from[(size_t)a * columns];
        }
        for (size_t j = 0; j < nv; j++)
            for (size_t c = 0; c < 3 * ncomp; c++) {
                const long double *w = c < 2 * ncomp ? across[j].value : across[j].slope;
                const long double *from = row + c % (2 * ncomp) * columns + across[j].first;
                long double sum = 0.0L;
                for (int a = 0; a <= s->degree[1]; a++) sum += w[a] * from[a];
                out[(i * nv + j) * 3 * ncomp + c] = sum;
            }
    }
    free(row);
    free(across);
}

void direct_surface(long double point[3], long double su[3], long double sv[3], long double cross[3],
                    const kn_spline *s, long double u, long double v)
{
    long double f[12];
    direct_spline(f, s, u, v);
    int n = s->ncomp;
    for (int c = 0; c < 3; c++) {
        long double w = s->rational ? f[3] : 1.0L;
        point[c] = f[c] / w;
        su[c] = (f[n + c] - (s->rational ? f[n + 3] * point[c] : 0.0L)) / w;
        sv[c] = (f[2 * n + c] - (s->rational ? f[2 * n + 3] * point[c] : 0.0L)) / w;
    }
    for (int c = 0; c < 3; c++) cross[c] = su[(c + 1) % 3] * sv[(c + 2) % 3] - su[(c + 2) % 3] * sv[(c + 1) % 3];
}

bool direct_errors(long double *length, long double *angle, const kn_shell *shell, long double u, long double v)
{
    long double p[3], su[3], sv[3], d[3], n[9], x, xx = 0, dd = 0, nn = 0, dot = 0, uu = 0, vv = 0;
    direct_surface(p, su, sv, d, kn_shell_surface(shell), u, v);
    direct_spline(n, kn_shell_normal(shell), u, v);
    for (int c = 0; c < 3; c++) {
        x = n[(c + 1) % 3] * d[(c + 2) % 3] - n[(c + 2) % 3] * d[(c + 1) % 3];
        xx += x * x, dd += d[c] * d[c], nn += n[c] * n[c], dot += n[c] * d[c];
        uu += su[c] * su[c], vv += sv[c] * sv[c];
    }
    *length = fabsl(sqrtl(nn) - 1.0L);
    *angle = atan2l(sqrtl(xx), dot);
    return uu > 1e-12L && vv > 1e-12L; // at a pole the cross product is rounding
}
