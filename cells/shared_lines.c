// SPDX-License-Identifier: Apache-2.0
// Lines at equal steps of the length of several surfaces together.
//
// On each eighth of a knot span the speed f = sum over surfaces of the mean of |S_u| over v is known at the points of
// a Gauss rule. Its interpolant there is sum_k c_k P_k(2 t - 1), c_k = (2 k + 1) sum_j w_j f_j P_k(2 x_j - 1), and
//     integral_0^t P_k(2 s - 1) ds = (P_k+1 - P_k-1)(2 t - 1) / (2 (2 k + 1)),  t for k = 0.
#include "cells/internal.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

enum { PANELS = 8, POINTS = 10 };

typedef struct panel {
    double c[POINTS]; // of the speed
} panel;

typedef struct lengths {
    const kn_cells_along *along;
    int n, spans, count;
    double *breaks;   // spans + 1 for each member
    panel *panels;    // PANELS for each span, in the direction of a member that is not reversed
    double *sums;     // length up to each panel
    double *span_sum; // up to each span
    double *place;    // of each line in its span, 0 <= place < 1
    int *parts;       // cells of each span
} lengths;

// P_0 .. P_n at y.
static void legendre(double *p, int n, double y)
{
    p[0] = 1.0, p[1] = y;
    for (int k = 2; k <= n; k++) p[k] = ((2 * k - 1) * y * p[k - 1] - (k - 1) * p[k - 2]) / k;
}

// The integral of the speed over [0,t] of a panel, and the speed at t.
static double integral(double *speed, const panel *f, double t)
{
    double p[POINTS + 1], sum = f->c[0] * t;
    legendre(p, POINTS, 2.0 * t - 1.0);
    *speed = f->c[0];
    for (int k = 1; k < POINTS; k++) {
        sum += f->c[k] * (p[k + 1] - p[k - 1]) / (2 * (2 * k + 1));
        *speed += f->c[k] * p[k];
    }
    return sum;
}

// ---- the speed ----

static kn_status check_member(kn_ctx *ctx, lengths *l, int m)
{
    const kn_cells_along *a = &l->along[m], *first = &l->along[0];
    kn_status status = kn_cells_expect(ctx, "even lines", a->surface);
    if (status == KN_OK) status = kn_cells_expect_count(ctx, "even lines", a->surface, a->var, l->count);
    if (status != KN_OK) return status;
    int n, spans = l->spans;
    double *b = kn_cells_breaks(ctx, &n, a->surface, a->var);
    if (!b) return KN_ENOMEM;
    bool same = n == spans + 1, backward = a->reversed != first->reversed;
    for (int i = 0; same && i < n; i++) {
        double *f = l->breaks, x = (b[i] - b[0]) / (b[spans] - b[0]);
        double y = m == 0 ? x : (f[backward ? spans - i : i] - f[0]) / (f[spans] - f[0]);
        l->breaks[m * (spans + 1) + i] = b[i];
        same = fabs(x - (backward ? 1.0 - y : y)) <= 1e-6;
    }
    return same ? KN_OK : kn_fail(ctx, KN_EDOMAIN, "even lines: surfaces 0 and %d have other knots", m);
}

// The points of the other variable, whose weights add up to 1.
static kn_status make_across(kn_ctx *ctx, double **x, double **w, int *n, const kn_spline *s, int var)
{
    int nbreaks;
    double *b = kn_cells_breaks(ctx, &nbreaks, s, var), gx[KN_CELLS_POINTS], gw[KN_CELLS_POINTS];
    if (!b) return KN_ENOMEM;
    int m = nbreaks <= 5 ? 8 : nbreaks <= 33 ? 4 : 2;
    *n = 0;
    *x = kn_scratch(ctx, (size_t)nbreaks * (size_t)m, sizeof **x);
    *w = kn_scratch(ctx, (size_t)nbreaks * (size_t)m, sizeof **w);
    if (!*x || !*w) return KN_ENOMEM;
    kn_cells_gauss(gx, gw, m);
    for (int i = 0; i + 1 < nbreaks; i++)
        for (int k = 0; k < m; k++, ++*n) {
            (*x)[*n] = b[i] + (b[i + 1] - b[i]) * gx[k];
            (*w)[*n] = gw[k] * ((b[i + 1] - b[i]) / (b[nbreaks - 1] - b[0]));
        }
    return KN_OK;
}

// speed[0 .. POINTS-1] += of one member, over a panel as if the domain were [0,1].
static kn_status add_speed(kn_ctx *ctx, double *speed, const kn_cells_along *a, const double *x, const double *across,
                           const double *weight, int n, double size, double *room)
{
    double *at = room, *value = room + 2 * n;
    for (int k = 0; k < POINTS; k++) {
        for (int j = 0; j < n; j++) at[2 * j + a->var] = x[k], at[2 * j + 1 - a->var] = across[j];
        kn_status status = kn_spline_eval_batch_partials(ctx, value, a->surface, (size_t)n, at);
        if (status != KN_OK) return status;
        for (int j = 0; j < n; j++) speed[k] += size * weight[j] * kn_cells_norm(value + 9 * j + 3 * (1 + a->var));
    }
    return KN_OK;
}

// Adds the speeds of a member to l->panels[].c, which hold values at the points until expand.
static kn_status add_member(kn_ctx *ctx, lengths *l, int m)
{
    const kn_cells_along *a = &l->along[m];
    const double *b = l->breaks + m * (l->spans + 1);
    double gx[KN_CELLS_POINTS], gw[KN_CELLS_POINTS], x[POINTS], *across, *weight;
    int n;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = make_across(ctx, &across, &weight, &n, a->surface, 1 - a->var);
    double *room = status == KN_OK ? kn_scratch(ctx, 11 * (size_t)n, sizeof *room) : NULL;
    if (!room) status = KN_ENOMEM;
    kn_cells_gauss(gx, gw, POINTS);
    for (int p = 0; status == KN_OK && p < l->spans * PANELS; p++) {
        int q = a->reversed ? l->spans * PANELS - 1 - p : p, span = q / PANELS;
        double step = (b[span + 1] - b[span]) / PANELS;
        for (int k = 0; k < POINTS; k++) x[k] = b[span] + step * (q % PANELS + gx[a->reversed ? POINTS - 1 - k : k]);
        status = add_speed(ctx, l->panels[p].c, a, x, across, weight, n, step, room);
        if (status == KN_OK) status = kn_progress(ctx, "lines", (m + (double)p / (l->spans * PANELS)) / l->n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// From values at the points to coefficients, and their sums.
static void expand(lengths *l)
{
    double gx[KN_CELLS_POINTS], gw[KN_CELLS_POINTS], p[POINTS + 1], speed;
    kn_cells_gauss(gx, gw, POINTS);
    l->sums[0] = l->span_sum[0] = 0.0;
    for (int i = 0; i < l->spans * PANELS; i++) {
        double f[POINTS];
        memcpy(f, l->panels[i].c, sizeof f);
        memset(l->panels[i].c, 0, sizeof f);
        for (int j = 0; j < POINTS; j++) {
            legendre(p, POINTS, 2.0 * gx[j] - 1.0);
            for (int k = 0; k < POINTS; k++) l->panels[i].c[k] += (2 * k + 1) * gw[j] * f[j] * p[k];
        }
        l->sums[i + 1] = l->sums[i] + integral(&speed, &l->panels[i], 1.0);
        if ((i + 1) % PANELS == 0) l->span_sum[(i + 1) / PANELS] = l->sums[i + 1];
    }
}

// ---- lines ----

// Where the length up to t is `target`: Newton's method inside a bracket, bisection where it leaves that.
static double invert(const panel *f, double target)
{
    double lo = 0.0, hi = 1.0, t = 0.5;
    for (int k = 0; k < 100 && lo < hi; k++) {
        double speed, excess = integral(&speed, f, t) - target, next = t - excess / speed;
        if (excess > 0.0)
            hi = t;
        else
            lo = t;
        if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
        if (fabs(next - t) <= 1e-15) return next;
        t = next;
    }
    return t;
}

// The place in its span of the line at `length` from the span's start, which lies strictly inside.
static double find_place(const lengths *l, int span, double length)
{
    int first = span * PANELS, i = first;
    double at = l->sums[first] + length;
    while (i < first + PANELS - 1 && l->sums[i + 1] < at) i++;
    return (i - first + invert(&l->panels[i], at - l->sums[i])) / PANELS;
}

static void place_lines(lengths *l)
{
    int at = 0;
    kn_cells_share(l->parts, l->span_sum, l->spans, l->count);
    for (int i = 0; i < l->spans; i++)
        for (int j = 0; j < l->parts[i]; j++) {
            double length = (l->span_sum[i + 1] - l->span_sum[i]) * ((double)j / l->parts[i]);
            l->place[at++] = j == 0 ? 0.0 : length > 0.0 ? find_place(l, i, length) : (double)j / l->parts[i];
        }
}

static kn_status write_lines(kn_ctx *ctx, double *line, const lengths *l, int m)
{
    const double *b = l->breaks + m * (l->spans + 1);
    int at = 0;
    for (int i = 0; i < l->spans; i++)
        for (int j = 0; j < l->parts[i]; j++, at++) {
            double x = l->place[at];
            int span = l->along[m].reversed ? l->spans - 1 - i : i;
            if (l->along[m].reversed)
                line[l->count - at] = x == 0.0 ? b[span + 1] : b[span] + (b[span + 1] - b[span]) * (1.0 - x);
            else
                line[at] = b[span] + (b[span + 1] - b[span]) * x;
        }
    line[l->along[m].reversed ? 0 : l->count] = b[l->along[m].reversed ? 0 : l->spans];
    for (int i = 0; i < l->count; i++)
        if (!(line[i] < line[i + 1]))
            return kn_fail(ctx, KN_EDOMAIN, "even lines: %d cells are too many, lines %d and %d fall together",
                           l->count, i, i + 1);
    return KN_OK;
}

static kn_status make_room(kn_ctx *ctx, lengths *l)
{
    size_t spans = (size_t)l->spans;
    l->breaks = kn_scratch(ctx, (spans + 1) * (size_t)l->n, sizeof *l->breaks);
    l->panels = kn_scratch(ctx, spans * PANELS, sizeof *l->panels);
    l->sums = kn_scratch(ctx, spans * PANELS + 1, sizeof *l->sums);
    l->span_sum = kn_scratch(ctx, spans + 1, sizeof *l->span_sum);
    l->place = kn_scratch(ctx, (size_t)l->count, sizeof *l->place);
    l->parts = kn_scratch(ctx, spans, sizeof *l->parts);
    if (!l->breaks || !l->panels || !l->sums || !l->span_sum || !l->place || !l->parts) return KN_ENOMEM;
    memset(l->panels, 0, spans * PANELS * sizeof *l->panels);
    return KN_OK;
}

static kn_status measure(kn_ctx *ctx, lengths *l)
{
    kn_status status = make_room(ctx, l);
    for (int m = 0; status == KN_OK && m < l->n; m++) status = check_member(ctx, l, m);
    for (int m = 0; status == KN_OK && m < l->n; m++) status = add_member(ctx, l, m);
    if (status != KN_OK) return status;
    expand(l);
    double total = l->span_sum[l->spans];
    if (!(total > 0.0) || isinf(total)) return kn_fail(ctx, KN_EDOMAIN, "even lines: a length of %g", total);
    place_lines(l);
    return KN_OK;
}

kn_status kn_cells_shared_lines(kn_ctx *ctx, double **lines, const kn_cells_along *along, int n, int count)
{
    if (n < 1) return kn_fail(ctx, KN_EDOMAIN, "even lines: %d surfaces", n);
    kn_status status = kn_cells_expect(ctx, "even lines", along[0].surface);
    if (status == KN_OK) status = kn_cells_expect_count(ctx, "even lines", along[0].surface, along[0].var, count);
    if (status != KN_OK) return status;
    lengths l = {along, n, kn_spline_spans(along[0].surface, along[0].var), count, .breaks = NULL};
    kn_mark mark = kn_scratch_mark(ctx);
    double **made = kn_scratch(ctx, (size_t)n, sizeof *made);
    if (made) memset(made, 0, (size_t)n * sizeof *made);
    status = made ? measure(ctx, &l) : KN_ENOMEM;
    for (int m = 0; status == KN_OK && m < n; m++) {
        made[m] = kn_alloc(ctx, (size_t)count + 1, sizeof **made);
        status = made[m] ? write_lines(ctx, made[m], &l, m) : KN_ENOMEM;
    }
    for (int m = 0; made && m < n; m++) {
        if (status == KN_OK)
            lines[m] = made[m];
        else
            kn_free(ctx, made[m]);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
