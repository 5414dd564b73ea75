// SPDX-License-Identifier: Apache-2.0
// How far the normals along the edges of a limited surface turn from the exact ones.
//
// On a piece of an edge let X_r, X_t be the derivatives of the exact surface, Y_r, Y_t those of its fit, D = X - Y,
// N = X_r x X_t, M = Y_r x Y_t. Then
//     N - M = X_r x D_t + D_r x X_t - D_r x D_t,  M x N = Y_r (D_t . N) - Y_t (D_r . N),
// as X_r and X_t are orthogonal to N. So the sine of the angle between M and N is at most |N - M| / |N|, and, where
// |N - M| < |N|, at most (|Y_r| |D_t . N| + |Y_t| |D_r . N|) / (|N| (|N| - |N - M|)): what lies in the tangent plane
// does not count there. Each X lies in a ball about the mean of its coefficients, which bounds all of this; pieces
// are halved until the bound is as wanted. Of P/w the normal's direction is that of the derivatives P' - (P/w) w',
// whatever the positive factor 1/w.
//
// Where N vanishes at an end of a piece, and M with it as derivatives at corners are kept, there is no bound; but on
// [h,2h] from there is one, however small h is: N, M and N - M shrink alike.
#include "fit/limit.h"

#include <math.h>
#include <string.h>

#include "kernel/bernstein.h"

// Towards an end without a normal, and of any other piece.
enum { SINGULAR_HALVINGS = 10, MOST_HALVINGS = 6 };

// Curves along an edge, ncomp arrays of n + 1 numbers: the exact surface, and the derivatives (r: along, t: across)
// of it and of the fit, all raised to the exact degree.
enum { POINT, EXACT_R, EXACT_T, FIT_R, FIT_T, CURVES };
typedef struct strip {
    const kn_limit_rows *rows;
    int n[CURVES]; // degrees
    double *coef[CURVES];
} strip;

typedef struct ball {
    double middle[3], radius;
    double difference, loose; // of D; what is to be added to each of its coefficients, in any direction
} ball;

static double norm3(const double x[3])
{
    return hypot(hypot(x[0], x[1]), x[2]);
}
static double dot3(const double x[3], const double y[3])
{
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}
static void cross3(double z[3], const double x[3], const double y[3])
{
    for (int c = 0; c < 3; c++) z[c] = x[(c + 1) % 3] * y[(c + 2) % 3] - x[(c + 2) % 3] * y[(c + 1) % 3];
}

// x = the derivative, coefficient i of a, of which c is the point.
static void derivative(double x[3], const strip *s, int curve, size_t i, const double c[3])
{
    size_t n = (size_t)s->n[curve] + 1;
    const double *a = s->coef[curve];
    double w = s->rows->rational ? a[3 * n + i] : 0.0;
    for (size_t k = 0; k < 3; k++) x[k] = a[k * n + i] - c[k] * w;
}

// d = coefficient i of the difference of the derivatives, `exact` and the fit's.
static void difference(double d[3], const strip *s, int exact, size_t i, const double c[3])
{
    double y[3];
    derivative(d, s, exact, i, c);
    derivative(y, s, exact + 2, i, c);
    for (int k = 0; k < 3; k++) d[k] -= y[k];
}

// c and *radius: of all P/w; polynomial: 0 and 0. false: a weight is not positive.
static bool points_of(double c[3], double *radius, const strip *s)
{
    size_t n = (size_t)s->n[POINT] + 1;
    const double *p = s->coef[POINT];
    memset(c, 0, 3 * sizeof *c);
    *radius = 0.0;
    for (int pass = 0; pass < 2 && s->rows->rational; pass++)
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
    double e = s->rows->rounding[exact - EXACT_R], most_w = 0.0, most_v = 0.0, most_d = 0.0;
    ball out = {.radius = 0.0};
    for (size_t i = 0; i < n; i++) {
        double x[3];
        derivative(x, s, exact, i, c);
        for (int k = 0; k < 3; k++) out.middle[k] += x[k] / (double)n;
    }
    for (size_t i = 0; i < n; i++) {
        double x[3], d[3];
        derivative(x, s, exact, i, c);
        difference(d, s, exact, i, c);
        for (int k = 0; k < 3; k++) x[k] -= out.middle[k];
        out.radius = fmax(out.radius, norm3(x));
        out.difference = fmax(out.difference, norm3(d));
        if (!s->rows->rational) continue;
        double w = s->coef[exact][3 * n + i], v = s->coef[exact + 2][3 * n + i];
        most_w = fmax(most_w, fabs(w)), most_v = fmax(most_v, fabs(v)), most_d = fmax(most_d, fabs(w - v));
    }
    out.radius = kn_round_up(out.radius + radius * most_w) + e;
    out.loose = kn_round_up(radius * most_d + s->rows->error * most_v) + e;
    out.difference = kn_round_up(out.difference) + out.loose;
    return out;
}

// A bound of |D . N|, n that of the middles, from which N is no further than `spread`.
static double off_plane(const strip *s, int exact, const double c[3], const ball *b, const double n[3], double spread)
{
    double most = 0.0, length = norm3(n);
    for (size_t i = 0; i <= (size_t)s->n[exact]; i++) {
        double d[3];
        difference(d, s, exact, i, c);
        most = fmax(most, fabs(dot3(d, n)));
    }
    return kn_round_up(most + (b->loose + 0x1p-49 * b->difference) * length + b->difference * spread);
}

// What rounding may make of a normal that is none; r, t: lengths of the derivatives.
static double rough_normal(const kn_limit_rows *rows, double r, double t)
{
    return rows->rounding[0] * t + rows->rounding[1] * r + rows->rounding[0] * rows->rounding[1];
}

// A bound of the angle over the piece, INFINITY: none. *nowhere: the exact surface has no normal in it, but for
// rounding.
static double piece_angle(bool *nowhere, const strip *s)
{
    double c[3], radius, n[3];
    *nowhere = false;
    if (!points_of(c, &radius, s)) return INFINITY;
    ball r = ball_of(s, EXACT_R, c, radius), t = ball_of(s, EXACT_T, c, radius);
    cross3(n, r.middle, t.middle);
    double a = kn_round_up(norm3(r.middle)), b = kn_round_up(norm3(t.middle));
    double spread = kn_round_up(a * t.radius + b * r.radius + r.radius * t.radius + 0x1p-49 * a * b);
    double least = (norm3(n) - spread) * (1.0 - 0x1p-46);
    double apart = kn_round_up((a + r.radius) * t.difference + r.difference * (b + t.radius) +
                               r.difference * t.difference);
    *nowhere = norm3(n) + spread <= 3.0 * rough_normal(s->rows, a + r.radius, b + t.radius);
    if (!(least > 0.0)) return INFINITY;
    double sine = kn_round_up(apart / least);
    if (least > apart) {
        double off = (a + r.radius + r.difference) * off_plane(s, EXACT_T, c, &t, n, spread) +
                     (b + t.radius + t.difference) * off_plane(s, EXACT_R, c, &r, n, spread);
        double closer = off / (least * (least - apart));
        sine = fmin(sine, kn_round_up(closer));
    }
    return sine < 1.0 ? kn_round_up(asin(sine)) : INFINITY;
}

// The angle at an end of the piece, computed; -1: there is no normal. *none: of the exact surface.
static double end_angle(bool *none, const strip *s, bool last)
{
    double c[3] = {0.0, 0.0, 0.0}, x[4][3], n[2][3], z[3];
    if (s->rows->rational) {
        size_t m = (size_t)s->n[POINT] + 1, at = last ? m - 1 : 0;
        const double *p = s->coef[POINT];
        for (size_t k = 0; k < 3; k++) c[k] = p[k * m + at] / p[3 * m + at];
    }
    for (int k = 0; k < 4; k++) derivative(x[k], s, EXACT_R + k, last ? (size_t)s->n[EXACT_R + k] : 0, c);
    for (int k = 0; k < 2; k++) cross3(n[k], x[2 * k], x[2 * k + 1]);
    *none = !(norm3(n[0]) > rough_normal(s->rows, norm3(x[0]), norm3(x[1])));
    // Nothing where the normals are no more than rounding.
    for (int k = 0; k < 2; k++) {
        double r = norm3(x[2 * k]), t = norm3(x[2 * k + 1]);
        if (!(norm3(n[k]) > fmax(1e-9 * r * t, rough_normal(s->rows, r, t)))) return -1.0;
    }
    cross3(z, n[0], n[1]);
    return atan2(norm3(z), dot3(n[0], n[1]));
}

// turn becomes that of itself and of the piece, after `depth` halvings; `left` more are worth while.
static kn_status look(kn_ctx *ctx, kn_limit_turn *turn, const strip *s, int depth, int left)
{
    bool nowhere, none[2];
    double here = piece_angle(&nowhere, s);
    if (here <= turn->angle) return KN_OK;
    for (int k = 0; k < 2; k++) turn->sample = fmax(turn->sample, end_angle(&none[k], s, k));
    bool singular = isinf(here) && (none[0] || none[1]);
    if (nowhere || (singular && depth >= SINGULAR_HALVINGS)) {
        turn->singular = true;
        return KN_OK;
    }
    if (here <= fmax(turn->goal, 1.25 * turn->sample) || (left == 0 && !singular)) {
        if (isinf(here))
            turn->unknown = true;
        else
            turn->angle = here;
        return KN_OK;
    }
    if (!singular) left--;
    strip half[2] = {*s, *s};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = KN_OK;
    for (int k = 0; k < CURVES && status == KN_OK; k++) {
        size_t ncomp = (size_t)s->rows->ncomp, all = (size_t)(s->n[k] + 1) * ncomp;
        double *room = kn_scratch(ctx, 2 * all, sizeof *room);
        status = room ? KN_OK : KN_ENOMEM;
        if (!room) break;
        half[0].coef[k] = room, half[1].coef[k] = room + all;
        kn_bernstein_split(room, room + all, s->coef[k], ncomp, s->n[k], 1, 0.5);
    }
    for (int k = 0; k < 2 && status == KN_OK; k++) status = look(ctx, turn, &half[k], depth + 1, left);
    kn_scratch_release(ctx, mark);
    return status;
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

// exact, fit: as those of kn_limit_rows, on all spans apart.
static kn_status look_at_span(kn_ctx *ctx, kn_limit_turn *turn, const kn_limit_rows *rows, double *const exact[2],
                              double *const fit[2], size_t span)
{
    const kn_limit_axis *x = &rows->along;
    size_t ncomp = (size_t)rows->ncomp, spans = (size_t)1 << x->level;
    strip s = {.rows = rows};
    double *fit_point;
    for (int k = 0; k < CURVES; k++) s.n[k] = k == EXACT_R || k == FIT_R ? x->from - 1 : x->from;
    kn_status status = span_of(ctx, &s.coef[POINT], exact[0], ncomp, spans, span, x->from, x->from);
    if (status == KN_OK) status = span_of(ctx, &fit_point, fit[0], ncomp, spans, span, x->to, x->from);
    for (int k = 0; k < 2 && status == KN_OK; k++)
        status = span_of(ctx, &s.coef[k ? FIT_T : EXACT_T], k ? fit[1] : exact[1], ncomp, spans, span,
                         k ? x->to : x->from, x->from);
    for (int k = 0; k < 2 && status == KN_OK; k++) {
        double *d = kn_scratch(ctx, ncomp * (size_t)x->from, sizeof *d);
        if (!d) return KN_ENOMEM;
        s.coef[k ? FIT_R : EXACT_R] = d;
        kn_bernstein_differentiate(d, k ? fit_point : s.coef[POINT], ncomp, x->from, 1);
        for (size_t i = 0; i < ncomp * (size_t)x->from; i++) d[i] *= (double)spans; // by the whole parameter
    }
    return status == KN_OK ? look(ctx, turn, &s, 0, MOST_HALVINGS) : status;
}

kn_status kn_limit_turn_of(kn_ctx *ctx, kn_limit_turn *turn, const kn_limit_rows *rows)
{
    const kn_limit_axis *x = &rows->along;
    size_t ncomp = (size_t)rows->ncomp, spans = (size_t)1 << x->level;
    size_t m = ((size_t)x->from + 1) * ncomp;
    double *exact[2], *fit[2];
    kn_mark mark = kn_scratch_mark(ctx);
    double *both = kn_scratch(ctx, 2 * m, sizeof *both), *cut = kn_scratch(ctx, 2 * m * spans, sizeof *cut);
    for (int k = 0; k < 2; k++) {
        exact[k] = cut ? cut + (size_t)k * m * spans : NULL;
        fit[k] = kn_scratch(ctx, ncomp * kn_limit_apart(x), sizeof *fit[k]);
        if (both) memcpy(both + (size_t)k * m, rows->exact[k], m * sizeof *both);
        if (fit[k]) kn_limit_spread(fit[k], rows->fit[k], ncomp, x, 1);
    }
    kn_status status = both && cut && fit[0] && fit[1] ? kn_limit_restrict(ctx, cut, both, 2 * ncomp, x, 1)
                                                       : KN_ENOMEM;
    for (size_t i = 0; i < spans && status == KN_OK; i++) {
        kn_mark inner = kn_scratch_mark(ctx);
        status = look_at_span(ctx, turn, rows, exact, fit, i);
        kn_scratch_release(ctx, inner);
    }
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

kn_status kn_limit_rows_at(kn_ctx *ctx, double *out[2], const double *coef, size_t ncomp, const size_t n[2], int var,
                           bool at_end, double slope)
{
    size_t all = ncomp * n[1 - var];
    for (size_t i = 0; i < 2; i++) {
        out[i] = kn_scratch(ctx, all, sizeof *out[i]);
        if (!out[i]) return KN_ENOMEM;
        take_row(out[i], coef, ncomp, n, var, at_end, i);
    }
    for (size_t i = 0; i < all; i++) out[1][i] = slope * (out[1][i] - out[0][i]);
    return KN_OK;
}

bool kn_limit_round_rows(kn_limit_rows *rows, const kn_limit_fit *f, int var, const double *coef, size_t n)
{
    const kn_limit_axis *x = &rows->along, *over = &f->axis[var];
    // Restriction, elevation, halvings, a difference and a factor, of coordinates and of weights times coordinates.
    double steps = kn_gamma_up(8.0 * x->from + 3.0 * x->from * (SINGULAR_HALVINGS + MOST_HALVINGS) + 24.0);
    kn_parts rough = f->rough;
    kn_parts_add(&rough, 1.0, coef, n, rows->ncomp, rows->rational);
    double size = 2.0 * steps * rough.coordinate;
    if (rows->rational) { // |P/w| is at most the largest |P| over the least weight; it is wrong, too, and times w'
        double least = INFINITY;
        size_t all = kn_bezier_count(f->a);
        for (size_t i = 0; i < all; i++) least = fmin(least, f->a->coef[3 * all + i]);
        least -= steps * rough.weight;
        if (!(least > 0.0)) return false;
        double spread = 1.0 + rough.weight / least;
        size *= spread * spread;
    }
    rows->error += size; // of inserted knots
    rows->rounding[0] = ldexp(4.0 * x->from * size, x->level);
    rows->rounding[1] = 4.0 * fmax(over->from, ldexp(over->to, over->level)) * size;
    return true;
}

kn_status kn_limit_edge_angle(kn_ctx *ctx, kn_limit_turn *turn, const kn_limit_fit *f, double error, int var,
                              bool at_end)
{
    const kn_limit_axis *x = &f->axis[1 - var], *over = &f->axis[var];
    kn_limit_rows rows = {.ncomp = f->a->ncomp, .rational = f->a->rational, .along = *x, .error = error};
    *turn = (kn_limit_turn){.goal = turn->goal};
    turn->singular = x->from == 0 || over->from == 0;
    turn->unknown = !turn->singular &&
                    !kn_limit_round_rows(&rows, f, var, f->coef, kn_limit_count(x) * kn_limit_count(over));
    if (turn->singular || turn->unknown) return KN_OK;
    size_t n[2][2];
    double *row[2][2];
    for (int v = 0; v < 2; v++) n[0][v] = (size_t)f->axis[v].from + 1, n[1][v] = kn_limit_count(&f->axis[v]);
    kn_mark mark = kn_scratch_mark(ctx);
    size_t ncomp = (size_t)rows.ncomp;
    kn_status status = kn_limit_rows_at(ctx, row[0], f->a->coef, ncomp, n[0], var, at_end, over->from);
    if (status == KN_OK)
        status = kn_limit_rows_at(ctx, row[1], f->coef, ncomp, n[1], var, at_end, ldexp(over->to, over->level));
    for (int k = 0; k < 2 && status == KN_OK; k++) rows.exact[k] = row[0][k], rows.fit[k] = row[1][k];
    if (status == KN_OK) status = kn_limit_turn_of(ctx, turn, &rows);
    kn_scratch_release(ctx, mark);
    return status;
}
