// SPDX-License-Identifier: Apache-2.0
// How far the normals along the edges of a limited surface turn from the exact ones.
//
// On a piece of an edge let X_r, X_t be the derivatives of the exact surface, Y_r, Y_t those of its fit. Then
//     X_r x X_t - Y_r x Y_t = X_r x D_t + D_r x X_t - D_r x D_t,  D = X - Y,
// and the sine of the angle between the two is at most the norm of this over |X_r x X_t|. Each X lies in a ball about
// the mean of its coefficients, which bounds both from the right sides; pieces are halved until the balls are small.
// Of P/w the normal's direction is that of the derivatives P' - (P/w) w', whatever the positive factor 1/w.
#include "fit/limit.h"

#include <math.h>
#include <string.h>

#include "bezier/norm_bound.h"
#include "kernel/bernstein.h"

enum { MOST_HALVINGS = 6 };

// Curves along an edge, ncomp arrays of n + 1 numbers: the exact surface, and the derivatives (r: along, t: across)
// of it and of the fit, all raised to the exact degree.
enum { POINT, EXACT_R, EXACT_T, FIT_R, FIT_T, CURVES };
typedef struct strip {
    int ncomp, n[CURVES]; // degrees
    bool rational;
    double *coef[CURVES];
    double rounding[2]; // of a coefficient of derivatives r and t, at most
    double error;       // |fit - exact|
} strip;

typedef struct ball {
    double middle[3], radius, difference; // of D
} ball;

static double norm3(const double x[3])
{
    return hypot(hypot(x[0], x[1]), x[2]);
}

// c and *radius: of all P/w; polynomial: 0 and 0. false: a weight is not positive.
static bool points_of(double c[3], double *radius, const strip *s)
{
    size_t n = (size_t)s->n[POINT] + 1;
    const double *p = s->coef[POINT];
    memset(c, 0, 3 * sizeof *c);
    *radius = 0.0;
    for (int pass = 0; pass < 2 && s->rational; pass++)
        for (size_t i = 0; i < n; i++) {
            double w = p[3 * n + i], x[3];
            if (!(w > 0.0)) return false;
            for (size_t k = 0; k < 3; k++) x[k] = p[k * n + i] / w - (pass ? c[k] : 0.0);
            for (size_t k = 0; k < 3 && !pass; k++) c[k] += x[k] / (double)n;
            if (pass) *radius = fmax(*radius, kn_round_up(norm3(x)));
        }
    return true;
}

static ball ball_of(const strip *s, int exact, const double c[3], double radius)
{
    size_t n = (size_t)s->n[exact] + 1;
    const double *a = s->coef[exact], *b = s->coef[exact + 2];
    double e = s->rounding[exact - EXACT_R], most_w = 0.0, most_v = 0.0, most_d = 0.0;
    ball out = {.radius = 0.0};
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < n; i++) {
            double x[3], d[3], w = s->rational ? a[3 * n + i] : 0.0, v = s->rational ? b[3 * n + i] : 0.0;
            for (size_t k = 0; k < 3; k++) {
                x[k] = a[k * n + i] - c[k] * w - out.middle[k] * pass;
                d[k] = a[k * n + i] - b[k * n + i] - c[k] * (w - v);
            }
            for (size_t k = 0; k < 3 && !pass; k++) out.middle[k] += x[k] / (double)n;
            if (!pass) continue;
            out.radius = fmax(out.radius, norm3(x));
            out.difference = fmax(out.difference, norm3(d));
            most_w = fmax(most_w, fabs(w)), most_v = fmax(most_v, fabs(v)), most_d = fmax(most_d, fabs(w - v));
        }
    out.radius = kn_round_up(out.radius + radius * most_w) + e;
    out.difference = kn_round_up(out.difference + radius * most_d + s->error * most_v) + e;
    return out;
}

// A bound of the angle over the piece, INFINITY: none. *good: halves would not be much better.
static double piece_angle(bool *good, const strip *s)
{
    double c[3], radius;
    *good = false;
    if (!points_of(c, &radius, s)) return INFINITY;
    ball r = ball_of(s, EXACT_R, c, radius), t = ball_of(s, EXACT_T, c, radius);
    double *x = r.middle, *y = t.middle;
    double n[3] = {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
    double a = kn_round_up(norm3(x)), b = kn_round_up(norm3(y)), cross = norm3(n) - 0x1p-49 * a * b;
    double least = cross - kn_round_up(a * t.radius + b * r.radius + r.radius * t.radius);
    double most = (a + r.radius) * t.difference + r.difference * (b + t.radius) + r.difference * t.difference;
    double sine = least > 0.0 ? kn_round_up(most / least) : INFINITY;
    *good = least > 0.5 * cross;
    return sine < 1.0 ? kn_round_up(asin(sine)) : INFINITY;
}

// *angle becomes the larger of itself and a bound over the piece.
static kn_status look(kn_ctx *ctx, double *angle, const strip *s, int depth)
{
    bool good;
    double here = piece_angle(&good, s);
    if (here <= *angle) return KN_OK;
    if (good || depth == MOST_HALVINGS) {
        *angle = here;
        return KN_OK;
    }
    strip half[2] = {*s, *s};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = KN_OK;
    for (int k = 0; k < CURVES && status == KN_OK; k++) {
        size_t all = (size_t)(s->n[k] + 1) * (size_t)s->ncomp;
        double *room = kn_scratch(ctx, 2 * all, sizeof *room);
        status = room ? KN_OK : KN_ENOMEM;
        if (!room) break;
        half[0].coef[k] = room, half[1].coef[k] = room + all;
        kn_bernstein_split(room, room + all, s->coef[k], (size_t)s->ncomp, s->n[k], 1, 0.5);
    }
    for (int k = 0; k < 2 && status == KN_OK; k++) status = look(ctx, angle, &half[k], depth + 1);
    kn_scratch_release(ctx, mark);
    return status;
}

// Rows `row` and the one beside it, counted inwards from an edge, of in (ncomp, n0, n1).
static void take_row(double *out, const double *in, size_t ncomp, const size_t n[2], int var, bool at_end, size_t row)
{
    size_t step = var == 0 ? 1 : n[1], first = (at_end ? n[var] - 1 - row : row) * (var == 0 ? n[1] : 1);
    for (size_t c = 0; c < ncomp; c++)
        for (size_t i = 0; i < n[1 - var]; i++) *out++ = in[c * n[0] * n[1] + first + i * step];
}

// The curves over all spans of an edge: spans[k] of them one after the other in coef[k], span by span, each component
// by component.
typedef struct edge_rows {
    double *row[2][2]; // exact and fit; the edge and the derivative across it; (ncomp, span, degree + 1)
} edge_rows;

static kn_status rows_of(kn_ctx *ctx, edge_rows *out, const kn_limit_fit *f, int var, bool at_end)
{
    const kn_limit_axis *along = &f->axis[1 - var], *over = &f->axis[var];
    size_t ncomp = (size_t)f->a->ncomp;
    for (int k = 0; k < 2; k++) {
        size_t n[2], apart;
        for (int v = 0; v < 2; v++) n[v] = k ? kn_limit_count(&f->axis[v]) : (size_t)f->axis[v].from + 1;
        apart = k ? kn_limit_apart(along) : ((size_t)along->from + 1) << along->level;
        double *line = kn_scratch(ctx, 2 * ncomp * n[1 - var], sizeof *line), *beside = line + ncomp * n[1 - var];
        double slope = k ? ldexp(over->to, over->level) : (double)over->from;
        for (int i = 0; i < 2; i++) out->row[k][i] = kn_scratch(ctx, ncomp * apart, sizeof *line);
        if (!line || !out->row[k][0] || !out->row[k][1]) return KN_ENOMEM;
        take_row(line, k ? f->coef : f->a->coef, ncomp, n, var, at_end, 0);
        take_row(beside, k ? f->coef : f->a->coef, ncomp, n, var, at_end, 1);
        for (size_t i = 0; i < ncomp * n[1 - var]; i++) beside[i] = slope * (beside[i] - line[i]);
        for (int i = 0; i < 2; i++) {
            double *from = i ? beside : line;
            if (k) {
                kn_limit_spread(out->row[k][i], from, ncomp, along, 1);
                continue;
            }
            kn_status status = kn_limit_restrict(ctx, out->row[k][i], from, ncomp, along, 1);
            if (status != KN_OK) return status;
        }
    }
    return KN_OK;
}

// in (ncomp, spans, degree + 1): span s of it, raised to degree `to`.
static kn_status span_of(kn_ctx *ctx, double **out, const double *in, size_t ncomp, size_t spans, size_t s,
                         int degree, int to)
{
    size_t m = (size_t)degree + 1;
    double *part = kn_scratch(ctx, ncomp * m, sizeof *part);
    *out = kn_scratch(ctx, ncomp * ((size_t)to + 1), sizeof **out);
    if (!part || !*out) return KN_ENOMEM;
    for (size_t c = 0; c < ncomp; c++) memcpy(part + c * m, in + (c * spans + s) * m, m * sizeof *part);
    kn_bernstein_elevate(*out, part, ncomp, degree, to, 1);
    return KN_OK;
}

static kn_status look_at_span(kn_ctx *ctx, double *angle, const kn_limit_fit *f, strip *s, const edge_rows *rows,
                              int var, size_t span)
{
    const kn_limit_axis *x = &f->axis[1 - var];
    size_t ncomp = (size_t)s->ncomp, spans = (size_t)1 << x->level;
    double *fit;
    kn_status status = span_of(ctx, &s->coef[POINT], rows->row[0][0], ncomp, spans, span, x->from, x->from);
    if (status == KN_OK) status = span_of(ctx, &fit, rows->row[1][0], ncomp, spans, span, x->to, x->from);
    for (int k = 0; k < 2 && status == KN_OK; k++)
        status = span_of(ctx, &s->coef[k ? FIT_T : EXACT_T], rows->row[k][1], ncomp, spans, span, k ? x->to : x->from,
                         x->from);
    for (int k = 0; k < 2 && status == KN_OK; k++) {
        double *d = kn_scratch(ctx, ncomp * (size_t)x->from, sizeof *d);
        if (!d) return KN_ENOMEM;
        s->coef[k ? FIT_R : EXACT_R] = d;
        kn_bernstein_differentiate(d, k ? fit : s->coef[POINT], ncomp, x->from, 1);
    }
    return status == KN_OK ? look(ctx, angle, s, 0) : status;
}

kn_status kn_limit_edge_angle(kn_ctx *ctx, double *angle, const kn_limit_fit *f, double error, int var, bool at_end)
{
    const kn_limit_axis *x = &f->axis[1 - var], *over = &f->axis[var];
    strip s = {.ncomp = f->a->ncomp, .rational = f->a->rational, .error = error};
    *angle = INFINITY;
    if (x->from == 0 || over->from == 0) return KN_OK;
    for (int k = 0; k < CURVES; k++) s.n[k] = k == EXACT_R || k == FIT_R ? x->from - 1 : x->from;
    // Restriction, elevation, halvings, a difference and a factor, of coordinates and of weights times coordinates.
    double steps = kn_gamma_up(8.0 * x->from + 3.0 * x->from * MOST_HALVINGS + 24.0);
    kn_parts rough = f->rough;
    kn_parts_add(&rough, 1.0, f->coef, kn_limit_count(&f->axis[0]) * kn_limit_count(&f->axis[1]), s.ncomp,
                 s.rational);
    double size = 2.0 * steps * rough.coordinate;
    if (s.rational) { // |P/w| is at most the largest |P| over the least weight; it is wrong, too, and times w'
        double least = INFINITY;
        size_t n = kn_bezier_count(f->a);
        for (size_t i = 0; i < n; i++) least = fmin(least, f->a->coef[3 * n + i]);
        least -= steps * rough.weight;
        if (!(least > 0.0)) return KN_OK;
        double spread = 1.0 + rough.weight / least;
        size *= spread * spread;
    }
    s.rounding[0] = 4.0 * x->from * size;
    s.rounding[1] = 4.0 * fmax(over->from, ldexp(over->to, over->level)) * size;
    edge_rows rows;
    double most = 0.0;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = rows_of(ctx, &rows, f, var, at_end);
    for (size_t span = 0; status == KN_OK && span < (size_t)1 << x->level && most < INFINITY; span++) {
        kn_mark inner = kn_scratch_mark(ctx);
        status = look_at_span(ctx, &most, f, &s, &rows, var, span);
        kn_scratch_release(ctx, inner);
    }
    kn_scratch_release(ctx, mark);
    *angle = most;
    return status;
}
