// SPDX-License-Identifier: Apache-2.0
// Where two splines of separate variables agree: a(x) w_b(y) - b(y) w_a(x) = 0. A cell is a pair of pieces whose
// boxes of control points overlap.
#include "solve/cells.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <string.h>

// A box of spans: the box of its control points, and its Bezier piece once a pair needs it.
typedef struct piece {
    int span[KN_MAX_VARS];
    bool made;
    double *lo, *hi, *coef, *error;
} piece;

typedef struct side {
    const kn_spline *s;
    piece *pieces;
    size_t count, size;   // pieces; coefficients of a component of one
    double scale, weight; // the largest coefficient, the least weight
} side;

static kn_status check(kn_ctx *ctx, const char *what, kn_net *net, const kn_spline *a, const kn_spline *b)
{
    const kn_spline *both[2] = {a, b};
    int degree[2 * KN_MAX_VARS] = {0}, nvars = 0;
    kn_status status = kn_spline_check(ctx, a);
    if (status == KN_OK) status = kn_spline_check(ctx, b);
    if (status != KN_OK) return status;
    if (kn_spline_dim(a) != kn_spline_dim(b))
        return kn_fail(ctx, KN_EDOMAIN, "%s: dimensions %d and %d", what, kn_spline_dim(a), kn_spline_dim(b));
    double count = kn_spline_dim(a);
    for (int s = 0; s < 2; s++)
        for (int d = 0; d < both[s]->nvars; d++) {
            degree[nvars++] = both[s]->degree[d];
            count *= both[s]->degree[d] + 1.0;
        }
    if (nvars > KN_MAX_VARS || count > (double)KN_MAX_COEFS)
        return kn_fail(ctx, KN_ELIMIT, "%s: %d variables, %g coefficients in a cell", what, nvars, count);
    *net = kn_net_make(nvars, kn_spline_dim(a), degree);
    return KN_OK;
}

// Convex combinations of P / w, each of which rounds once.
static void bound(const side *t, piece *p, double *work)
{
    const kn_spline *s = t->s;
    int dim = kn_spline_dim(s);
    double *w = work + t->size;
    if (s->rational) kn_window(w, s, dim, p->span);
    for (int c = 0; c < dim; c++) {
        double lo = INFINITY, hi = -INFINITY;
        kn_window(work, s, c, p->span);
        for (size_t i = 0; i < t->size; i++) {
            double x = s->rational ? work[i] / w[i] : work[i];
            lo = x < lo ? x : lo;
            hi = x > hi ? x : hi;
        }
        double more = s->rational ? 0x1p-52 * fmax(fabs(lo), fabs(hi)) : 0.0;
        p->lo[c] = lo - more;
        p->hi[c] = hi + more;
    }
}

static kn_status prepare(kn_ctx *ctx, side *t, const kn_spline *s)
{
    size_t dim = (size_t)kn_spline_dim(s), ncomp = (size_t)s->ncomp, each;
    *t = (side){.s = s, .count = 1, .size = kn_bernstein_count(s->nvars, s->degree)};
    for (int d = 0; d < s->nvars; d++) t->count *= (size_t)kn_spline_spans(s, d);
    each = 2 * dim + ncomp * (t->size + 1);
    t->pieces = kn_scratch(ctx, t->count, sizeof *t->pieces);
    double *room = kn_scratch(ctx, t->count * each + 2 * t->size, sizeof *room),
           *work = room ? room + t->count * each : NULL;
    if (!t->pieces || !room) return KN_ENOMEM;
    t->scale = kn_largest(s->coef, ncomp * kn_spline_count(s));
    t->weight = 1.0;
    for (size_t i = 0; i < kn_spline_count(s) && s->rational; i++) {
        double w = s->coef[dim * kn_spline_count(s) + i];
        t->weight = i == 0 || w < t->weight ? w : t->weight;
    }
    piece p = {.made = false};
    for (int d = 0; d < s->nvars; d++) p.span[d] = kn_knots_next_span(s->knots[d], s->degree[d], s->count[d], -1);
    for (size_t i = 0; i < t->count; i++, room += each) {
        p.lo = room, p.hi = p.lo + dim, p.error = p.hi + dim, p.coef = p.error + ncomp;
        t->pieces[i] = p;
        bound(t, &t->pieces[i], work);
        for (int d = s->nvars - 1; d >= 0; d--) {
            p.span[d] = kn_knots_next_span(s->knots[d], s->degree[d], s->count[d], p.span[d]);
            if (p.span[d] < s->count[d]) break;
            p.span[d] = kn_knots_next_span(s->knots[d], s->degree[d], s->count[d], -1);
        }
    }
    return KN_OK;
}

static kn_status make(kn_ctx *ctx, const side *t, piece *p)
{
    const kn_spline *s = t->s;
    const double *matrix[KN_MAX_VARS];
    kn_mark mark = kn_scratch_mark(ctx);
    double *work = kn_scratch(ctx, t->size, sizeof *work);
    kn_status status = work ? KN_OK : KN_ENOMEM;
    for (int d = 0; d < s->nvars && status == KN_OK; d++) {
        size_t m = (size_t)s->degree[d] + 1;
        double *to = kn_scratch(ctx, m * m, sizeof *to);
        if (!to) status = KN_ENOMEM;
        if (to)
            kn_extraction(to, s->knots[d], s->degree[d], p->span[d], s->knots[d][p->span[d]],
                          s->knots[d][p->span[d] + 1]);
        matrix[d] = to;
    }
    for (int c = 0; c < s->ncomp && status == KN_OK; c++) {
        double *coef = p->coef + (size_t)c * t->size;
        p->error[c] = 0.0;
        kn_window(coef, s, c, p->span);
        kn_extract(coef, &p->error[c], s->degree, s->nvars, matrix, work);
    }
    p->made = status == KN_OK;
    kn_scratch_release(ctx, mark);
    return status;
}

// What the errors of x w and the rounding of the product make.
static double slack(const double *x, double x_error, const double *w, double w_error, size_t nx, size_t nw)
{
    double big_x = kn_largest(x, nx), big_w = w ? kn_largest(w, nw) : 1.0;
    return (big_x + x_error) * w_error + x_error * big_w + kn_rounding(3.0) * (big_x * big_w);
}

// Two products and a difference, times a power of two.
static kn_status add(kn_ctx *ctx, kn_cells *cells, const side *a, const side *b, const piece *p, const piece *q,
                     double scale)
{
    double *coef, *error, *box;
    size_t na = a->size, nb = b->size;
    int dim = cells->net.ncomp, n = cells->net.nvars;
    kn_status status = kn_cells_add(ctx, cells, &coef, &error, &box);
    if (status != KN_OK) return status;
    const double *wa = a->s->rational ? p->coef + (size_t)dim * na : NULL,
                 *wb = b->s->rational ? q->coef + (size_t)dim * nb : NULL;
    double wa_error = wa ? p->error[dim] : 0.0, wb_error = wb ? q->error[dim] : 0.0;
    for (int d = 0; d < n; d++) {
        const side *t = d < a->s->nvars ? a : b;
        int v = d < a->s->nvars ? d : d - a->s->nvars, span = d < a->s->nvars ? p->span[v] : q->span[v];
        box[d] = t->s->knots[v][span];
        box[n + d] = t->s->knots[v][span + 1];
    }
    for (int c = 0; c < dim; c++) {
        const double *x = p->coef + (size_t)c * na, *y = q->coef + (size_t)c * nb;
        error[c] = slack(x, p->error[c], wb, wb_error, na, nb) + slack(y, q->error[c], wa, wa_error, nb, na);
        error[c] = error[c] * scale * (1.0 + 0x1p-40) + kn_underflow();
        for (size_t i = 0; i < na; i++)
            for (size_t j = 0; j < nb; j++) *coef++ = scale * (x[i] * (wb ? wb[j] : 1.0) - y[j] * (wa ? wa[i] : 1.0));
    }
    return KN_OK;
}

static bool overlap(const piece *p, const piece *q, int dim, double margin)
{
    for (int c = 0; c < dim; c++)
        if (p->lo[c] > q->hi[c] + margin || q->lo[c] > p->hi[c] + margin) return false;
    return true;
}

// More equations than unknowns: |scale w_a w_b (a - b)| <= residual counts as 0.
static kn_status pairs(kn_ctx *ctx, kn_cells *cells, side *a, side *b, double residual)
{
    int exponent = 0;
    kn_status status = KN_OK;
    (void)frexp(a->scale * (b->s->rational ? b->scale : 1.0) + b->scale * (a->s->rational ? a->scale : 1.0),
                &exponent);
    double scale = ldexp(1.0, exponent < -1000 ? 1000 : -exponent), margin = 0.0;
    if (cells->net.ncomp > cells->net.nvars) margin = 1.01 * residual / (scale * a->weight * b->weight);
    for (size_t i = 0; i < a->count && status == KN_OK; i++)
        for (size_t j = 0; j < b->count && status == KN_OK; j++) {
            piece *p = &a->pieces[i], *q = &b->pieces[j];
            if (!overlap(p, q, cells->net.ncomp, margin)) continue;
            if (!p->made) status = make(ctx, a, p);
            if (status == KN_OK && !q->made) status = make(ctx, b, q);
            if (status == KN_OK) status = add(ctx, cells, a, b, p, q, scale);
        }
    return status;
}

kn_status kn_meet(kn_ctx *ctx, const char *what, kn_root **roots, size_t *nroots, kn_solve_report *report,
                  const kn_spline *a, const kn_spline *b, const kn_solve_options *options)
{
    kn_solve_options o;
    kn_cells cells = {0};
    side left, right;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_solve_settle(ctx, &o, options);
    if (status == KN_OK) status = check(ctx, what, &cells.net, a, b);
    if (status == KN_OK) status = prepare(ctx, &left, a);
    if (status == KN_OK) status = prepare(ctx, &right, b);
    if (status == KN_OK) {
        for (int d = 0; d < cells.net.nvars; d++) {
            bool first = d < a->nvars;
            kn_spline_domain(first ? a : b, first ? d : d - a->nvars, &cells.lo[d], &cells.hi[d]);
        }
        cells.jumps = kn_may_jump(a) || kn_may_jump(b);
        status = pairs(ctx, &cells, &left, &right, o.residual);
    }
    if (status == KN_OK) status = kn_cells_solve(ctx, roots, nroots, report, &cells, &o);
    kn_cells_clear(ctx, &cells);
    kn_scratch_release(ctx, mark);
    return status;
}
