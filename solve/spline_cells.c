// SPDX-License-Identifier: Apache-2.0
// The cells of splines over one domain.
#include "solve/cells.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <string.h>

// What one spline has in one variable for each interval of the common grid.
typedef struct axis {
    int *span;
    double *matrix;
} axis;

typedef struct builder {
    const kn_spline *f;
    int nf, nvars, n[KN_MAX_VARS]; // intervals of the common grid
    double *breaks[KN_MAX_VARS];
    axis *axes;    // nf x nvars
    double *scale; // of each equation: a power of two
    const double *error;
    double margin;  // of scaled equations: as much counts as 0
    double *window; // two times the coefficients of a cell
} builder;

static kn_status check(kn_ctx *ctx, const kn_spline *f, int nf, kn_net *net)
{
    int equations = 0, degree[KN_MAX_VARS] = {0};
    if (nf < 1 || nf > KN_MAX_COMPS) return kn_fail(ctx, KN_EDOMAIN, "zeros: %d functions", nf);
    for (int i = 0; i < nf; i++) {
        kn_status status = kn_spline_check(ctx, &f[i]);
        if (status != KN_OK) return status;
        if (f[i].nvars < 1 || f[i].nvars != f[0].nvars)
            return kn_fail(ctx, KN_EDOMAIN, "zeros: functions of %d and %d variables", f[0].nvars, f[i].nvars);
        for (int d = 0; d < f[i].nvars; d++) {
            double lo, hi, lo0, hi0;
            kn_spline_domain(&f[i], d, &lo, &hi);
            kn_spline_domain(&f[0], d, &lo0, &hi0);
            if (lo != lo0 || hi != hi0)
                return kn_fail(ctx, KN_EDOMAIN, "zeros: domains [%g, %g] and [%g, %g] in variable %d", lo0, hi0, lo,
                               hi, d);
            if (f[i].degree[d] > degree[d]) degree[d] = f[i].degree[d];
        }
        equations += kn_spline_dim(&f[i]);
    }
    if (equations > KN_MAX_COMPS) return kn_fail(ctx, KN_ELIMIT, "zeros: %d equations", equations);
    double count = equations;
    for (int d = 0; d < f[0].nvars; d++) count *= degree[d] + 1.0;
    if (count > (double)KN_MAX_COEFS) return kn_fail(ctx, KN_ELIMIT, "zeros: %g coefficients in a cell", count);
    *net = kn_net_make(f[0].nvars, equations, degree);
    return KN_OK;
}

// The union of all breaks of variable d.
static kn_status common_breaks(kn_ctx *ctx, builder *b, int d)
{
    int room = 0;
    for (int i = 0; i < b->nf; i++) room += kn_spline_spans(&b->f[i], d) + 1;
    double *x = kn_scratch(ctx, 3 * (size_t)room, sizeof *x), *own = x ? x + room : NULL,
           *old = x ? own + room : NULL;
    if (!x) return KN_ENOMEM;
    int n = 0;
    for (int i = 0; i < b->nf; i++) {
        int k = kn_knots_breaks(own, NULL, b->f[i].knots[d], b->f[i].degree[d], b->f[i].count[d]);
        memcpy(old, x, (size_t)n * sizeof *old);
        n = kn_knots_union(x, old, n, own, k);
    }
    b->breaks[d] = x;
    b->n[d] = n - 1;
    return KN_OK;
}

static kn_status make_axis(kn_ctx *ctx, builder *b, int i, int d)
{
    const kn_spline *s = &b->f[i];
    axis *x = &b->axes[i * b->nvars + d];
    int p = s->degree[d];
    size_t size = (size_t)(p + 1) * (size_t)(p + 1);
    x->span = kn_scratch(ctx, (size_t)b->n[d], sizeof *x->span);
    x->matrix = kn_scratch(ctx, (size_t)b->n[d] * size, sizeof *x->matrix);
    if (!x->span || !x->matrix) return KN_ENOMEM;
    for (int k = 0; k < b->n[d]; k++) {
        x->span[k] = kn_knots_span(s->knots[d], p, s->count[d], b->breaks[d][k]);
        kn_extraction(x->matrix + (size_t)k * size, s->knots[d], p, x->span[k], b->breaks[d][k], b->breaks[d][k + 1]);
    }
    return KN_OK;
}

bool kn_may_jump(const kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++)
        for (int k = 1; k < s->count[d]; k++)
            if (s->knots[d][k] == s->knots[d][k + s->degree[d]] && s->knots[d][k] > s->knots[d][0]) return true;
    return false;
}

static kn_status prepare(kn_ctx *ctx, builder *b, kn_cells *cells)
{
    kn_status status = KN_OK;
    b->axes = kn_scratch(ctx, (size_t)(b->nf * b->nvars), sizeof *b->axes);
    b->scale = kn_scratch(ctx, (size_t)cells->net.ncomp, sizeof *b->scale);
    b->window = kn_scratch(ctx, 2 * cells->net.count, sizeof *b->window);
    if (!b->axes || !b->scale || !b->window) return KN_ENOMEM;
    for (int d = 0; d < b->nvars && status == KN_OK; d++) status = common_breaks(ctx, b, d);
    for (int i = 0, c = 0; i < b->nf && status == KN_OK; i++) {
        size_t count = kn_spline_count(&b->f[i]);
        for (int d = 0; d < b->nvars && status == KN_OK; d++) status = make_axis(ctx, b, i, d);
        for (int k = 0; k < kn_spline_dim(&b->f[i]); k++, c++) {
            int e = 0;
            (void)frexp(kn_largest(b->f[i].coef + (size_t)k * count, count), &e);
            b->scale[c] = ldexp(1.0, e < -1000 ? 1000 : -e);
        }
        cells->jumps = cells->jumps || kn_may_jump(&b->f[i]);
    }
    for (int d = 0; d < b->nvars; d++) kn_spline_domain(&b->f[0], d, &cells->lo[d], &cells->hi[d]);
    return status;
}

// Control points on one side of 0 in the cell: values are convex combinations of them.
static bool excluded(const builder *b, const int *cell)
{
    for (int i = 0, c = 0; i < b->nf; i++) {
        const kn_spline *s = &b->f[i];
        int span[KN_MAX_VARS];
        size_t count = kn_bernstein_count(s->nvars, s->degree);
        for (int d = 0; d < s->nvars; d++) span[d] = b->axes[i * b->nvars + d].span[cell[d]];
        for (int k = 0; k < kn_spline_dim(s); k++, c++) {
            double error = (b->error ? b->error[c] : 0.0) + b->margin / b->scale[c];
            bool positive = true, negative = true;
            kn_window(b->window, s, k, span);
            for (size_t j = 0; j < count; j++) {
                positive = positive && b->window[j] > error;
                negative = negative && b->window[j] < -error;
            }
            if (positive || negative) return true;
        }
    }
    return false;
}

static kn_status add(kn_ctx *ctx, const builder *b, kn_cells *cells, const int *cell)
{
    double *coef, *error, *box;
    size_t n = cells->net.count;
    kn_status status = kn_cells_add(ctx, cells, &coef, &error, &box);
    if (status != KN_OK) return status;
    for (int d = 0; d < b->nvars; d++) {
        box[d] = b->breaks[d][cell[d]];
        box[b->nvars + d] = b->breaks[d][cell[d] + 1];
    }
    for (int i = 0, c = 0; i < b->nf; i++) {
        const kn_spline *s = &b->f[i];
        const double *matrix[KN_MAX_VARS];
        int span[KN_MAX_VARS];
        size_t count = kn_bernstein_count(s->nvars, s->degree);
        for (int d = 0; d < s->nvars; d++) {
            const axis *x = &b->axes[i * b->nvars + d];
            span[d] = x->span[cell[d]];
            matrix[d] = x->matrix + (size_t)cell[d] * (size_t)(s->degree[d] + 1) * (size_t)(s->degree[d] + 1);
        }
        for (int k = 0; k < kn_spline_dim(s); k++, c++, coef += n) {
            kn_window(b->window, s, k, span);
            error[c] = b->error ? b->error[c] * b->scale[c] : 0.0;
            for (size_t j = 0; j < count; j++) {
                double x = b->window[j];
                b->window[j] = x * b->scale[c];
                if (x != 0.0 && fabs(b->window[j]) < 0x1p-1021) error[c] += kn_underflow(); // else it is exact
            }
            kn_extract(b->window, &error[c], s->degree, s->nvars, matrix, b->window + n);
            kn_raise(b->window, &error[c], s->nvars, s->degree, cells->net.degree, b->window + n);
            memcpy(coef, b->window, n * sizeof *coef);
        }
    }
    return KN_OK;
}

kn_status kn_cells_of_splines(kn_ctx *ctx, kn_cells *cells, const kn_spline *f, int nf, const double *error,
                              double residual)
{
    kn_status status = check(ctx, f, nf, &cells->net);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    builder b = {.f = f, .nf = nf, .nvars = f[0].nvars, .error = error};
    if (cells->net.ncomp > b.nvars) b.margin = 1.01 * residual;
    int cell[KN_MAX_VARS] = {0};
    status = prepare(ctx, &b, cells);
    while (status == KN_OK) {
        if (!excluded(&b, cell)) status = add(ctx, &b, cells, cell);
        int d = b.nvars - 1;
        while (d >= 0 && ++cell[d] == b.n[d]) cell[d--] = 0;
        if (d < 0) break;
    }
    kn_scratch_release(ctx, mark);
    return status;
}
