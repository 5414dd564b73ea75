// SPDX-License-Identifier: Apache-2.0
// Edges that were fitted by themselves, put into the fit of a surface.
#include "fit/limit.h"

#include <string.h>

#include "kernel/bernstein.h"

// line (count of `to`) = the edge, of one component, with knots inserted up to to->level, in the surface's direction.
static kn_status refined(kn_ctx *ctx, double *line, const double *coef, const kn_limit_edge *edge,
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
            status = refined(ctx, line, edges[e].coef + c * count, &edges[e], &axis[1 - e / 2]);
            if (status == KN_OK) put(coef + c * n[0] * n[1], line, n, e / 2, e % 2);
        }
    }
    kn_scratch_release(ctx, mark);
    return status;
}
