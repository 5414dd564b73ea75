// SPDX-License-Identifier: Apache-2.0
// How many spans along an edge the angle of normals there asks for. The fit's derivative across an edge is the map of
// the piece's, whatever the number of spans across (fit/limit_degree.c): rows of numbers decide, before any surface
// is fitted.
#include "fit/limit.h"

#include <math.h>

#include "kernel/bernstein.h"

// Where normals vanish at an end nothing is kept all along an edge: the rest of it need not be as good.
static const double PARTLY = 4.0;

// *turn along edge e, were there x->level levels along it.
static kn_status try_level(kn_ctx *ctx, kn_limit_turn *turn, const kn_limit_fit *f, const kn_limit_edge *edge, int e,
                           const kn_limit_axis *x)
{
    int var = e / 2;
    size_t n[2], ncomp = (size_t)f->a->ncomp, count = kn_limit_count(x), own = kn_limit_count(&edge->axis);
    for (int v = 0; v < 2; v++) n[v] = (size_t)f->axis[v].from + 1;
    double *exact[2], *matrix, *line = kn_scratch(ctx, ncomp * count, sizeof *line);
    double *across = kn_scratch(ctx, ncomp * count, sizeof *across);
    kn_limit_rows rows = {.ncomp = f->a->ncomp, .rational = f->a->rational, .along = *x, .error = edge->error};
    if (!line || !across) return KN_ENOMEM;
    kn_status status = kn_limit_rows_at(ctx, exact, f->a->coef, ncomp, n, var, e % 2, f->axis[var].from);
    if (status == KN_OK) status = kn_limit_matrix(ctx, &matrix, x);
    if (status != KN_OK) return status;
    kn_bernstein_transform(across, exact[1], ncomp, (int)count, x->from + 1, 1, matrix);
    for (size_t c = 0; c < ncomp && status == KN_OK; c++)
        status = kn_limit_edge_row(ctx, line + c * count, edge->coef + c * own, edge, x);
    // Of inner rows no more is known than their size, which is about the edge's: it tells where no normal is.
    bool rounded = status == KN_OK && kn_limit_round_rows(&rows, f, var, line, count);
    if (status == KN_OK && !rounded) turn->unknown = true;
    rows.exact[0] = exact[0], rows.exact[1] = exact[1], rows.fit[0] = line, rows.fit[1] = across;
    return rounded ? kn_limit_turn_of(ctx, turn, &rows) : status;
}

// The least level, no lower than the axis has, at which the angle is kept; the last that helped where none is.
static kn_status raise(kn_ctx *ctx, int *level, const kn_limit_fit *f, const kn_limit_edge *edge, int e)
{
    kn_limit_axis x = f->axis[1 - e / 2];
    double goal = 0.98 * f->limits->angle, last = INFINITY; // rounding is not looked at here
    kn_status status = KN_OK;
    int idle = 0;
    *level = x.level;
    for (; status == KN_OK && idle < 2; x.level++) {
        kn_limit_turn turn = {.goal = goal};
        kn_mark mark = kn_scratch_mark(ctx);
        status = try_level(ctx, &turn, f, edge, e, &x);
        kn_scratch_release(ctx, mark);
        bool helps = turn.angle < 0.5 * last;
        if (helps) *level = x.level, last = turn.angle;
        idle = helps ? 0 : idle + 1;
        double enough = turn.unknown ? PARTLY * goal : goal;
        if (turn.angle <= enough) *level = x.level;
        if (turn.angle <= enough || x.level >= KN_ANGLE_LEVEL || x.level >= f->limits->max_level) break;
    }
    return status;
}

kn_status kn_limit_raise_levels(kn_ctx *ctx, kn_limit_fit *f, const kn_limit_edge edges[4])
{
    kn_status status = KN_OK;
    for (int e = 0; e < 4 && status == KN_OK; e++) {
        const kn_limit_axis *across = &f->axis[e / 2];
        kn_limit_axis *along = &f->axis[1 - e / 2];
        int level = along->level;
        // Without a row of its own beside the edge, or without an edge, more spans are of no use.
        if (along->from == along->to || across->to < 3 || edges[e].size == 0.0) continue;
        status = raise(ctx, &level, f, &edges[e], e);
        if (level > along->level) along->level = level;
    }
    return status;
}
