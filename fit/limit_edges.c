// SPDX-License-Identifier: Apache-2.0
// Edges that were fitted by themselves, put into the fit of a surface.
#include "fit/limit.h"

#include <math.h>
#include <string.h>

#include "kernel/bernstein.h"

kn_status kn_limit_edge_row(kn_ctx *ctx, double *line, const double *coef, const kn_limit_edge *edge,
                            const kn_limit_axis *to)
{
    size_t m = (size_t)to->to + 1, most = kn_limit_apart(to);
    double *now = kn_scratch(ctx, most, sizeof *now), *next = kn_scratch(ctx, most, sizeof *next);
    if (!now || !next) return KN_ENOMEM;
    kn_limit_spread(now, coef, 1, &edge->axis, 1);
    for (int level = edge->axis.level; level < to->level; level++) {
        for (size_t s = 0; s < (size_t)1 << level; s++)
            kn_bernstein_split(next + 2 * s * m, next + (2 * s + 1) * m, now + s * m, 1, to->to, 1, 0.5);
        double *t = now;
        now = next, next = t;
    }
    kn_limit_join(line, now, to);
    size_t n = kn_limit_count(to);
    for (size_t i = 0; edge->turned && i < n / 2; i++) {
        double t = line[i];
        line[i] = line[n - 1 - i], line[n - 1 - i] = t;
    }
    return KN_OK;
}

// The edge where variable var ends takes the place of the surface's own, one component; the row beside it moves
// along, but for its ends, which belong to other edges.
static void put(double *coef, const double *line, const size_t n[2], int var, bool at_end)
{
    size_t step = var == 0 ? 1 : n[1], across = var == 0 ? n[1] : 1, rows = n[var], m = n[1 - var];
    double *row = coef + (at_end ? (rows - 1) * across : 0), *beside = at_end ? row - across : row + across;
    double share = rows > 3 ? 1.0 : rows == 3 ? 0.5 : 0.0;
    for (size_t i = 0; i < m; i++) {
        if (i > 0 && i < m - 1 && share > 0.0) beside[i * step] += share * (line[i] - row[i * step]);
        row[i * step] = line[i];
    }
}

kn_status kn_limit_put_edges(kn_ctx *ctx, double *coef, size_t ncomp, const kn_limit_axis axis[2],
                             const kn_limit_edge edges[4])
{
    size_t n[2] = {kn_limit_count(&axis[0]), kn_limit_count(&axis[1])};
    kn_mark mark = kn_scratch_mark(ctx);
    double *line = kn_scratch(ctx, n[0] > n[1] ? n[0] : n[1], sizeof *line);
    kn_status status = line ? KN_OK : KN_ENOMEM;
    for (int e = 0; e < 4; e++) {
        size_t count = kn_limit_count(&edges[e].axis);
        for (size_t c = 0; c < ncomp && status == KN_OK; c++) {
            status = kn_limit_edge_row(ctx, line, edges[e].coef + c * count, &edges[e], &axis[1 - e / 2]);
            if (status == KN_OK) put(coef + c * n[0] * n[1], line, n, e / 2, e % 2);
        }
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- what an edge asks for by itself ----

// An edge shorter than 2^-10 of the tolerance is none: its control points may be one point but for rounding.
void kn_limit_narrow(kn_fit_limits *limits, double *size, const kn_bezier *edge)
{
    size_t n = (size_t)edge->degree[0] + 1, dim = (size_t)(edge->ncomp - edge->rational);
    double tolerance = limits->tolerance;
    *size = 0.0;
    for (size_t i = 1; i < n; i++) {
        double sum = 0.0;
        for (size_t c = 0; c < dim; c++) {
            double w = edge->rational ? edge->coef[dim * n + i] : 1.0, v = edge->rational ? edge->coef[dim * n] : 1.0;
            double d = edge->coef[c * n + i] / w - edge->coef[c * n] / v;
            sum += d * d;
        }
        *size = fmax(*size, sqrt(sum));
    }
    if (!(*size > 0x1p-10 * tolerance) || !isfinite(*size)) {
        *size = 0.0;
        return;
    }
    limits->tolerance = fmin(tolerance, *size / KN_EDGE_PARTS);
    // Of tangents rounding takes less than a sixteenth of the angle: some hundred quanta, at degree 5 and 2^5 spans.
    double fine = limits->quantum * (limits->tolerance / tolerance),
           angle = limits->angle > 0.0 ? limits->angle : 1.0;
    fine = fmin(fine, 0x1p-14 * angle * *size);
    if (limits->quantum > 0.0) limits->quantum = fmin(limits->quantum, fmax(exp2(floor(log2(fine))), 0x1p-1000));
}

// A piece of a curve: derivatives, made one of points by `centre`, and their differences from the fit's.
typedef struct tangents {
    size_t n, dim;
    double *x, *d; // (dim, n)
} tangents;

static double tilt_of(const tangents *t, double loose, bool last)
{
    double m[KN_MAX_COMPS] = {0.0}, square = 0.0, least = INFINITY, radius = 0.0, most = 0.0, off = 0.0;
    for (size_t c = 0; c < t->dim; c++) {
        for (size_t i = 0; i < t->n; i++) m[c] += t->x[c * t->n + i] / (double)t->n;
        square += m[c] * m[c];
    }
    double length = sqrt(square);
    for (size_t i = 0; i < t->n; i++) {
        double along = 0.0, d_along = 0.0, d_square = 0.0, r_square = 0.0;
        for (size_t c = 0; c < t->dim; c++) {
            double x = t->x[c * t->n + i], d = t->d[c * t->n + i];
            along += x * m[c] / length, d_along += d * m[c] / length;
            d_square += d * d, r_square += (x - m[c]) * (x - m[c]);
        }
        least = fmin(least, along), radius = fmax(radius, sqrt(r_square)), most = fmax(most, sqrt(d_square));
        off = fmax(off, sqrt(fmax(0.0, d_square - d_along * d_along)));
    }
    if (!(least > (last ? 0.1 : 0.5) * length)) return last ? 0.0 : INFINITY; // undecided; vanishing, or almost
    double sine = (off + most * radius / least + loose) / least;
    return sine < 1.0 ? asin(sine) : 2.0;
}

static kn_status look(kn_ctx *ctx, double *tilt, const tangents *t, double loose, int depth)
{
    enum { MOST_DEPTH = 4 };
    double here = tilt_of(t, loose, depth == MOST_DEPTH);
    if (!isinf(here)) {
        *tilt = fmax(*tilt, here);
        return KN_OK;
    }
    size_t all = t->n * t->dim;
    double *room = kn_scratch(ctx, 4 * all, sizeof *room);
    if (!room) return KN_ENOMEM;
    tangents half[2] = {{t->n, t->dim, room, room + 2 * all}, {t->n, t->dim, room + all, room + 3 * all}};
    kn_bernstein_split(half[0].x, half[1].x, t->x, t->dim, (int)t->n - 1, 1, 0.5);
    kn_bernstein_split(half[0].d, half[1].d, t->d, t->dim, (int)t->n - 1, 1, 0.5);
    kn_status status = look(ctx, tilt, &half[0], loose, depth + 1);
    return status == KN_OK ? look(ctx, tilt, &half[1], loose, depth + 1) : status;
}

// The tangents over a span from the curve's and the fit's coefficients (ncomp, n + 1) there. P/w has the direction of
// P' - (P/w) w', P/w about the mean of its control points.
static kn_status span_tilt(kn_ctx *ctx, double *tilt, const kn_limit_fit *f, const double *p, const double *q)
{
    size_t ncomp = (size_t)f->a->ncomp, dim = ncomp - f->a->rational, n = (size_t)f->axis[0].from, m = n + 1;
    double *x = kn_scratch(ctx, 2 * ncomp * n, sizeof *x), *d = x ? x + ncomp * n : NULL, loose = 0.0;
    if (!x) return KN_ENOMEM;
    kn_bernstein_differentiate(x, p, ncomp, (int)n, 1);
    kn_bernstein_differentiate(d, q, ncomp, (int)n, 1);
    for (size_t i = 0; i < ncomp * n; i++) d[i] = x[i] - d[i];
    for (size_t c = 0; c < dim && f->a->rational; c++) {
        double centre = 0.0;
        for (size_t i = 0; i < m; i++) centre += p[c * m + i] / p[dim * m + i] / (double)m;
        for (size_t i = 0; i < n; i++) {
            x[c * n + i] -= centre * x[dim * n + i], d[c * n + i] -= centre * d[dim * n + i];
            loose = fmax(loose, f->error * fabs(x[dim * n + i]));
        }
    }
    return look(ctx, tilt, &(tangents){n, dim, x, d}, loose, 0);
}

kn_status kn_limit_tilt(kn_ctx *ctx, double *tilt, const kn_limit_fit *f)
{
    const kn_limit_axis *x = &f->axis[0];
    size_t ncomp = (size_t)f->a->ncomp, spans = (size_t)1 << x->level, n = (size_t)x->from + 1, m = (size_t)x->to + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    const double *exact = f->spans;
    double *fit = kn_scratch(ctx, ncomp * m * spans, sizeof *fit), *p = kn_scratch(ctx, 2 * ncomp * n, sizeof *p);
    double *q = p ? p + ncomp * n : NULL;
    kn_status status = fit && p ? KN_OK : KN_ENOMEM;
    *tilt = 0.0;
    if (status == KN_OK) kn_limit_spread(fit, f->coef, ncomp, x, 1);
    for (size_t s = 0; s < spans && status == KN_OK; s++) {
        kn_mark inner = kn_scratch_mark(ctx);
        for (size_t c = 0; c < ncomp; c++) {
            memcpy(p + c * n, exact + (c * spans + s) * n, n * sizeof *p);
            kn_bernstein_elevate(q + c * n, fit + (c * spans + s) * m, 1, x->to, x->from, 1);
        }
        status = span_tilt(ctx, tilt, f, p, q);
        kn_scratch_release(ctx, inner);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
