// SPDX-License-Identifier: Apache-2.0
// One variable of a fit of limited degree: least squares over each of the equal spans, with the ends held.
#include "fit/limit.h"

#include <string.h>

#include "kernel/bernstein.h"
#include "kernel/reduce.h"

size_t kn_limit_count(const kn_limit_axis *x)
{
    return x->level == 0 ? (size_t)x->to + 1 : ((size_t)(x->to - 1) << x->level) + 2;
}

size_t kn_limit_apart(const kn_limit_axis *x)
{
    return (size_t)(x->to + 1) << x->level;
}

// g (p + 1, d + 1): from the coefficients of a piece to those of degree p < d with its values and derivatives at both
// ends, and else the nearest in the sense of least squares of coefficients, which is that of L2 (bezier/reduce.c).
static kn_status lower(kn_ctx *ctx, double *g, int d, int p)
{
    size_t n = (size_t)d + 1, m = (size_t)p + 1;
    kn_band e = {.rows = d + 1};
    kn_projection projection;
    e.first = kn_scratch(ctx, 2 * n, sizeof *e.first);
    e.w = kn_scratch(ctx, n * m, sizeof *e.w);
    double *unit = kn_scratch(ctx, n * n, sizeof *unit);
    double *room = kn_scratch(ctx, kn_projection_room(d + 1, p + 1, p + 1) + n, sizeof *room);
    if (!e.first || !e.w || !unit || !room) return KN_ENOMEM;
    e.terms = e.first + n;
    kn_bernstein_elevation(&e, p, d);
    memset(unit, 0, n * n * sizeof *unit);
    for (size_t i = 0; i < n; i++) unit[i * n + i] = 1.0;
    memset(g, 0, m * n * sizeof *g);
    double share = (double)d / p;
    g[0] = g[(m - 1) * n + n - 1] = 1.0;
    g[n] = g[(m - 2) * n + n - 1] = 1.0 - share;
    g[n + 1] = g[(m - 2) * n + n - 2] = share;
    kn_projection_factor(&projection, &e, p + 1, 2, room + n);
    kn_projection_solve(&projection, g, unit, n, room);
    return KN_OK;
}

kn_status kn_limit_matrix(kn_ctx *ctx, double **matrix, const kn_limit_axis *x)
{
    size_t n = (size_t)x->from + 1, m = (size_t)x->to + 1, spans = (size_t)1 << x->level, row = 0;
    *matrix = kn_scratch(ctx, kn_limit_count(x) * n, sizeof **matrix);
    double *g = kn_scratch(ctx, 2 * m * n + n * n, sizeof *g), *one = g ? g + m * n : NULL,
           *cut = g ? one + m * n : NULL;
    if (!*matrix || !g) return KN_ENOMEM;
    kn_status status = lower(ctx, g, x->from, x->to);
    if (status != KN_OK) return status;
    for (size_t s = 0; s < spans; s++) {
        kn_bernstein_restriction(cut, x->from, (double)s / (double)spans, (double)(s + 1) / (double)spans);
        kn_bernstein_transform(one, cut, 1, (int)m, (int)n, n, g);
        size_t first = s > 0, end = s + 1 < spans ? m - 1 : m; // not where spans join
        memcpy(*matrix + row * n, one + first * n, (end - first) * n * sizeof *one);
        row += end - first;
    }
    return KN_OK;
}

void kn_limit_spread(double *out, const double *in, size_t outer, const kn_limit_axis *x, size_t inner)
{
    size_t spans = (size_t)1 << x->level, m = (size_t)x->to + 1, count = kn_limit_count(x);
    for (size_t o = 0; o < outer; o++, in += count * inner) {
        const double *from = in;
        for (size_t s = 0; s < spans; s++) {
            size_t first = s > 0, end = s + 1 < spans ? m - 1 : m;
            if (first)
                for (size_t q = 0; q < inner; q++) out[q] = out[q - inner];
            memcpy(out + first * inner, from, (end - first) * inner * sizeof *out);
            from += (end - first) * inner;
            for (size_t q = 0; q < inner && end < m; q++)
                out[(m - 1) * inner + q] = 0.5 * (out[(m - 2) * inner + q] + from[q]);
            out += m * inner;
        }
    }
}

void kn_limit_join(double *out, const double *in, const kn_limit_axis *x)
{
    size_t spans = (size_t)1 << x->level, m = (size_t)x->to + 1;
    for (size_t s = 0; s < spans; s++, in += m)
        for (size_t i = s > 0; i < (s + 1 < spans ? m - 1 : m); i++) *out++ = in[i];
}

kn_status kn_limit_restrict(kn_ctx *ctx, double *out, const double *in, size_t outer, const kn_limit_axis *x,
                            size_t inner)
{
    size_t n = (size_t)x->from + 1, spans = (size_t)1 << x->level;
    double *matrix = kn_scratch(ctx, n * n * spans, sizeof *matrix);
    if (!matrix) return KN_ENOMEM;
    for (size_t s = 0; s < spans; s++)
        kn_bernstein_restriction(matrix + s * n * n, x->from, (double)s / (double)spans,
                                 (double)(s + 1) / (double)spans);
    kn_bernstein_transform(out, in, outer, (int)(n * spans), (int)n, inner, matrix);
    return KN_OK;
}
