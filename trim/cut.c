// SPDX-License-Identifier: Apache-2.0
// kn_trim_cut: a region on both sides of {f = 0}.
#include "bezier/norm_bound.h"
#include "kernel/context.h"
#include "trim/internal.h"

#include <knurl/compose.h>
#include <math.h>
#include <string.h>

typedef struct cutting {
    kn_trim_pieces pieces;
    kn_trim_links links;
    bool *done; // pieces that are in a loop
} cutting;

static kn_status append(kn_ctx *ctx, kn_trim *out, int *room, const kn_spline *curve, bool turned)
{
    if (out->ncurves == *room) {
        int more = *room > 0 ? 2 * *room : 16;
        kn_spline *curves = kn_resize(ctx, out->curves, (size_t)more, sizeof *curves);
        if (!curves) return KN_ENOMEM;
        out->curves = curves;
        *room = more;
    }
    out->curves[out->ncurves] = (kn_spline){0};
    kn_status status = kn_spline_copy(ctx, &out->curves[out->ncurves], curve);
    if (status != KN_OK) return status;
    if (turned) kn_trim_turn(&out->curves[out->ncurves]);
    out->ncurves++;
    return KN_OK;
}

static const kn_trim_node *node_after(const cutting *c, int piece)
{
    for (int i = 0; i < c->links.nnodes; i++)
        if (c->links.nodes[i].from == piece) return &c->links.nodes[i];
    return NULL;
}

static int next_piece(const cutting *c, int piece)
{
    for (int i = 0, first = 0; i < c->pieces.nloops; first = c->pieces.loop_end[i++])
        if (piece < c->pieces.loop_end[i]) return piece + 1 < c->pieces.loop_end[i] ? piece + 1 : first;
    return piece;
}

// From a piece along the boundary; at a node over the line of zeros to where it leaves or, for the upper side, came
// from; and on, until that piece again.
static kn_status trace(kn_ctx *ctx, kn_trim *out, int *room, const cutting *c, int start, int sign)
{
    int piece = start;
    kn_status status = KN_OK;
    do {
        if (c->done[piece]) return kn_fail(ctx, KN_EUNDECIDED, "trim: the pieces of a cut do not make closed loops");
        c->done[piece] = true;
        status = append(ctx, out, room, &c->pieces.list[piece].curve, false);
        const kn_trim_node *node = node_after(c, piece);
        if (status == KN_OK && node) {
            status = append(ctx, out, room, &c->links.curves[node->link], sign > 0);
            piece = c->links.nodes[node->other].to;
        } else {
            piece = next_piece(c, piece);
        }
    } while (status == KN_OK && piece != start);
    if (status == KN_OK) out->loop_end[out->nloops++] = out->ncurves;
    return status;
}

static kn_status assemble(kn_ctx *ctx, kn_trim *out, const cutting *c, int sign)
{
    int room = 0;
    kn_status status = KN_OK;
    out->loop_end = kn_alloc(ctx, (size_t)(c->pieces.n + c->links.ncurves) + 1, sizeof *out->loop_end);
    if (!out->loop_end) return KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < c->pieces.n; i++)
        if (c->pieces.list[i].sign == sign && !c->done[i]) status = trace(ctx, out, &room, c, i, sign);
    for (int i = c->links.nlinks; status == KN_OK && i < c->links.ncurves; i++) {
        status = append(ctx, out, &room, &c->links.curves[i], sign > 0);
        if (status == KN_OK) out->loop_end[out->nloops++] = out->ncurves;
    }
    if (out->nloops > 0) return status;
    kn_trim_clear(ctx, out);
    return status;
}

// f without the factors that vanish along edges.
static kn_status divide_edges(kn_ctx *ctx, kn_bezier *g, const kn_bezier *f)
{
    kn_status status = kn_bezier_copy(ctx, g, f);
    bool zero = true;
    for (size_t i = 0; i < kn_bezier_count(f); i++) zero = zero && f->coef[i] == 0.0;
    if (zero) return kn_fail(ctx, KN_EUNDECIDED, "trim: the function to cut at is zero");
    for (int k = 0; status == KN_OK && k < 4; k++) {
        int order;
        status = kn_bezier_divide_edge(ctx, g, &order, g, k / 2, k % 2 == 1);
    }
    return status;
}

// |f| along the cut, segment by segment: coefficients of f(segment) and their rounding (kn_bezier_compose; segments
// lie in the square).
static kn_status find_residual(kn_ctx *ctx, double *residual, const cutting *c, const kn_bezier *f)
{
    kn_bezier along = {0};
    double size = 0.0, most = 0.0;
    for (size_t i = 0; i < kn_bezier_count(f); i++) size = fmax(size, fabs(f->coef[i]));
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < c->links.ncurves; k++) {
        const kn_spline *curve = &c->links.curves[k];
        for (int i = 0; status == KN_OK && i + 1 < curve->count[0]; i++) {
            const double *p = curve->coef + i, *q = p + curve->count[0];
            double ends[4] = {p[0], p[1], q[0], q[1]};
            const kn_bezier segment = {.nvars = 1, .ncomp = 2, .degree = {1}, .coef = ends};
            status = kn_bezier_compose(ctx, &along, f, &segment);
            for (int d = 0; status == KN_OK && d <= along.degree[0]; d++) most = fmax(most, fabs(along.coef[d]));
        }
    }
    double p = f->degree[0] + f->degree[1], fold = (f->degree[0] + 1.0) * (f->degree[1] + 1.0);
    if (c->links.ncurves > 0) *residual = kn_round_up(most + kn_gamma_up(6.0 * p + fold + 4.0) * size);
    kn_bezier_clear(ctx, &along);
    return status;
}

static kn_status check(kn_ctx *ctx, const kn_bezier *f, double tol)
{
    if (f->nvars != 2 || f->ncomp != 1 || f->rational || !f->coef)
        return kn_fail(ctx, KN_EDOMAIN, "trim: a cut needs a polynomial of two variables and one component");
    for (size_t i = 0; i < kn_bezier_count(f); i++)
        if (!isfinite(f->coef[i])) return kn_fail(ctx, KN_EDOMAIN, "trim: a cut along a function that is not finite");
    if (!(tol > 0.0 && tol <= 0.1)) return kn_fail(ctx, KN_EDOMAIN, "trim: a tolerance of %g", tol);
    return KN_OK;
}

static void swap(kn_trim *a, kn_trim *b)
{
    kn_trim t = *a;
    *a = *b;
    *b = t;
}

// Both sides with the lines of zeros followed to within tol. *solid: each side has an area, which a part that is
// thinner than tol may have lost.
static kn_status cut_within(kn_ctx *ctx, kn_trim side[2], double *residual, bool *solid, const kn_trim *trim,
                            const kn_bezier *f, const kn_bezier *g, double tol)
{
    cutting c = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_trim_boundary(ctx, &c.pieces, trim, f, g);
    if (status == KN_OK) status = kn_trim_link(ctx, &c.links, &c.pieces, trim, g, tol);
    if (status == KN_OK) c.done = kn_scratch(ctx, (size_t)c.pieces.n, sizeof *c.done);
    if (status == KN_OK && !c.done) status = KN_ENOMEM;
    if (status == KN_OK) memset(c.done, 0, (size_t)c.pieces.n * sizeof *c.done);
    *solid = true;
    for (int k = 0; status == KN_OK && k < 2; k++) {
        double area = 0.0;
        status = assemble(ctx, &side[k], &c, k == 0 ? -1 : 1);
        for (int i = 0; status == KN_OK && i < side[k].ncurves; i++)
            status = kn_trim_add_area(ctx, &area, &side[k].curves[i]);
        *solid = *solid && (side[k].nloops == 0 || area > 0.0);
    }
    if (status == KN_OK) status = find_residual(ctx, residual, &c, f);
    kn_trim_pieces_clear(ctx, &c.pieces);
    kn_trim_links_clear(ctx, &c.links);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_trim_cut(kn_ctx *ctx, kn_trim *below, kn_trim *above, kn_trim_cut_report *report, const kn_trim *trim,
                      const kn_bezier *f, double tol)
{
    enum { FINER = 4 };
    kn_status status = check(ctx, f, tol);
    if (status != KN_OK) return status;
    kn_bezier g = {0};
    kn_trim side[2] = {0};
    kn_trim_cut_report told = {0};
    bool solid = false;
    status = divide_edges(ctx, &g, f);
    for (int k = 0; status == KN_OK && !solid && k < FINER; k++, tol /= 16.0) {
        for (int i = 0; i < 2; i++) kn_trim_clear(ctx, &side[i]);
        status = cut_within(ctx, side, &told.residual, &solid, trim, f, &g, tol);
    }
    if (status == KN_OK && !solid)
        status = kn_fail(ctx, KN_EUNDECIDED, "trim: a part that the cut makes is too thin to have an area");
    told.below = side[0].nloops > 0, told.above = side[1].nloops > 0;
    for (int k = 0; status == KN_OK && k < 2; k++) { // all of it on one side: as it was
        if (k == 0 ? told.above : told.below) continue;
        status = kn_trim_copy(ctx, &side[k], trim);
    }
    if (status == KN_OK) {
        swap(below, &side[0]);
        swap(above, &side[1]);
        *report = told;
    }
    for (int k = 0; k < 2; k++) kn_trim_clear(ctx, &side[k]);
    kn_bezier_clear(ctx, &g);
    return status;
}
