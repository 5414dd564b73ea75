// SPDX-License-Identifier: Apache-2.0
// Lists of cells, and the cells of splines over one domain.
#include "solve/cells.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <string.h>

kn_status kn_cells_add(kn_ctx *ctx, kn_cells *cells, double **coef, double **error, double **box)
{
    size_t m = (size_t)cells->net.ncomp, size = m * cells->net.count, ends = 2 * (size_t)cells->net.nvars;
    if (cells->count == cells->room) {
        size_t room = 2 * cells->room + 4;
        double *const old[3] = {cells->coef, cells->error, cells->box};
        double **const to[3] = {&cells->coef, &cells->error, &cells->box};
        const size_t each[3] = {size, m, ends};
        for (int i = 0; i < 3; i++) {
            double *more = old[i] ? kn_resize(ctx, old[i], room * each[i], sizeof *more)
                                  : kn_alloc(ctx, room * each[i], sizeof *more);
            if (!more) return KN_ENOMEM;
            *to[i] = more;
        }
        cells->room = room;
    }
    size_t at = cells->count++;
    *coef = cells->coef + at * size;
    *error = cells->error + at * m;
    *box = cells->box + at * ends;
    return KN_OK;
}

void kn_cells_clear(kn_ctx *ctx, kn_cells *cells)
{
    kn_free(ctx, cells->coef);
    kn_free(ctx, cells->error);
    kn_free(ctx, cells->box);
    cells->coef = cells->error = cells->box = NULL;
}

// Row i: the blossom at a .. a b .. b with i times b, the coefficient i over [a,b].
void kn_extraction(double *matrix, const double *knots, int degree, int span, double a, double b)
{
    double args[KN_MAX_DEGREE + 1];
    for (int i = 0; i <= degree; i++) {
        for (int k = 0; k < degree; k++) args[k] = k < degree - i ? a : b;
        kn_knots_blossom(matrix + i * (degree + 1), knots, degree, span, args);
    }
}

static bool identity(const double *matrix, int n)
{
    for (int i = 0; i <= n; i++)
        for (int k = 0; k <= n; k++)
            if (matrix[i * (n + 1) + k] != (i == k)) return false;
    return true;
}

void kn_window(double *out, const kn_spline *s, int comp, const int *span)
{
    const double *coef = s->coef + (size_t)comp * kn_spline_count(s);
    int last = s->nvars - 1, row = s->degree[last] + 1, index[KN_MAX_VARS] = {0};
    size_t rows = 1;
    for (int d = 0; d < last; d++) rows *= (size_t)s->degree[d] + 1;
    for (size_t r = 0; r < rows; r++, out += row) {
        size_t at = 0;
        for (int d = 0; d <= last; d++)
            at = at * (size_t)s->count[d] + (size_t)(span[d] - s->degree[d] + (d < last ? index[d] : 0));
        for (int k = 0; k < row; k++) out[k] = coef[at + (size_t)k];
        for (int d = last - 1; d >= 0 && ++index[d] > s->degree[d]; d--) index[d] = 0;
    }
}

void kn_extract(double *coef, double *error, const int *degree, int nvars, const double *const *matrix, double *work)
{
    size_t count = kn_bernstein_count(nvars, degree);
    double roundings = 0.0, most = kn_largest(coef, count);
    for (int d = 0; d < nvars; d++) {
        int n = degree[d];
        size_t inner = kn_bernstein_count(nvars - d - 1, degree + d + 1);
        if (identity(matrix[d], n)) continue;
        kn_bernstein_transform(work, coef, count / (inner * (size_t)(n + 1)), n + 1, n + 1, inner, matrix[d]);
        memcpy(coef, work, count * sizeof *coef);
        roundings += 6.0 * n + 1.0;
    }
    if (roundings > 0.0) *error += (kn_rounding(roundings) * most + kn_underflow()) * (1.0 + 0x1p-40);
}

void kn_raise(double *coef, double *error, int nvars, const int *from, const int *to, double *work)
{
    int degree[KN_MAX_VARS] = {0};
    double roundings = 0.0;
    for (int d = 0; d < nvars; d++) degree[d] = from[d];
    double most = kn_largest(coef, kn_bernstein_count(nvars, degree));
    for (int d = 0; d < nvars; d++) {
        if (degree[d] == to[d]) continue;
        size_t inner = kn_bernstein_count(nvars - d - 1, degree + d + 1), outer = kn_bernstein_count(d, degree);
        kn_bernstein_elevate(work, coef, outer, degree[d], to[d], inner);
        roundings += (degree[d] < to[d] - degree[d] ? degree[d] : to[d] - degree[d]) + 3.0;
        degree[d] = to[d];
        memcpy(coef, work, kn_bernstein_count(nvars, degree) * sizeof *coef);
    }
    if (roundings > 0.0) *error += (kn_rounding(roundings) * most + kn_underflow()) * (1.0 + 0x1p-40);
}
