// SPDX-License-Identifier: Apache-2.0
// Points along the loops of a trim.
#include "mesh/trimmed.h"

#include <math.h>

enum { MOST = 1 << 20 }; // points of one outline

void kn_outline_clear(kn_ctx *ctx, kn_outline *outline)
{
    kn_free(ctx, outline->at);
    kn_free(ctx, outline->loop_end);
    *outline = (kn_outline){0};
}

kn_status kn_outline_add(kn_ctx *ctx, kn_outline *out, const double at[2])
{
    if (out->n == MOST) return kn_fail(ctx, KN_ELIMIT, "mesh: more than %d points around a trimmed patch", MOST);
    if (out->n == out->room) {
        int room = out->room > 0 ? 2 * out->room : 64;
        double(*list)[2] = kn_resize(ctx, out->at, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        out->at = list;
        out->room = room;
    }
    for (int c = 0; c < 2; c++) out->at[out->n][c] = at[c];
    out->n++;
    return KN_OK;
}

// The steps of the grid from a to b, rounded up.
static int steps(const double *a, const double *b, const int segments[2])
{
    double most = fmax(fabs(b[0] - a[0]) * segments[0], fabs(b[1] - a[1]) * segments[1]);
    return most > 1e6 ? 1000000 : most > 1.0 ? (int)ceil(most * (1.0 - 1e-9)) : 1;
}

// The lines of the grid strictly between the ends, along an edge of the square.
static kn_status add_edge(kn_ctx *ctx, kn_outline *out, const double *a, const double *b, int v, int segments)
{
    kn_status status = kn_outline_add(ctx, out, a);
    bool up = b[v] > a[v];
    double lo = up ? a[v] : b[v], hi = up ? b[v] : a[v];
    for (int k = 1; status == KN_OK && k < segments; k++) {
        int i = up ? k : segments - k;
        double x = (double)i / segments, p[2] = {a[0], a[1]};
        if (x <= lo + 1e-9 || x >= hi - 1e-9) continue;
        p[v] = x;
        status = kn_outline_add(ctx, out, p);
    }
    return status;
}

// Where both coordinates of a are not after those of b: the direction in which a segment is divided.
static bool runs_up(const double *a, const double *b)
{
    return a[0] < b[0] || (a[0] == b[0] && a[1] < b[1]);
}

static kn_status add_segment(kn_ctx *ctx, kn_outline *out, const double *a, const double *b, const int segments[2])
{
    kn_status status = kn_outline_add(ctx, out, a);
    int n = steps(a, b, segments);
    bool up = runs_up(a, b);
    const double *from = up ? a : b, *to = up ? b : a;
    for (int k = 1; status == KN_OK && k < n; k++) {
        double t = (double)(up ? k : n - k) / n;
        double p[2] = {from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t};
        status = kn_outline_add(ctx, out, p);
    }
    return status;
}

// A curve of higher degree, span by span, over positive knots.
static kn_status walk(kn_ctx *ctx, kn_outline *out, const kn_spline *curve, const int segments[2])
{
    int p = curve->degree[0], n = curve->count[0];
    const double *knots = curve->knots[0];
    kn_status status = kn_outline_add(ctx, out, (const double[2]){curve->coef[0], curve->coef[n]});
    for (int s = p; status == KN_OK && s < n; s++) {
        if (!(knots[s + 1] > knots[s])) continue;
        int parts = 2;
        for (int i = s - p; i < s; i++) {
            double a[2] = {curve->coef[i], curve->coef[n + i]}, b[2] = {curve->coef[i + 1], curve->coef[n + i + 1]};
            parts += steps(a, b, segments);
        }
        for (int k = 1; status == KN_OK && k <= parts; k++) {
            double at[2], x = k == parts ? knots[s + 1] : knots[s] + (knots[s + 1] - knots[s]) * ((double)k / parts);
            status = kn_spline_eval(ctx, at, curve, &x);
            if (status == KN_OK && s + 1 == n && k == parts)
                at[0] = curve->coef[n - 1], at[1] = curve->coef[2 * n - 1];
            if (status == KN_OK) status = kn_outline_add(ctx, out, at);
        }
    }
    return status;
}

// Its points are those of the direction in which knots are positive (kn_trim_turn); the last one is left out.
static kn_status add_curve(kn_ctx *ctx, kn_outline *out, const kn_spline *curve, const int segments[2])
{
    int first = out->n, n = curve->count[0] + curve->degree[0] + 1;
    if (curve->knots[0][0] + curve->knots[0][n - 1] >= 0.0) {
        kn_status status = walk(ctx, out, curve, segments);
        out->n -= status == KN_OK;
        return status;
    }
    kn_spline turned = {0};
    kn_status status = kn_spline_copy(ctx, &turned, curve);
    if (status == KN_OK) kn_trim_turn(&turned);
    if (status == KN_OK) status = walk(ctx, out, &turned, segments);
    for (int i = first, j = out->n - 1; status == KN_OK && i < j; i++, j--)
        for (int c = 0; c < 2; c++) {
            double swap = out->at[i][c];
            out->at[i][c] = out->at[j][c];
            out->at[j][c] = swap;
        }
    out->n -= status == KN_OK;
    kn_spline_clear(ctx, &turned);
    return status;
}

static kn_status add_any(kn_ctx *ctx, kn_outline *out, const kn_spline *curve, const int segments[2])
{
    int n = curve->count[0];
    kn_status status = KN_OK;
    if (curve->degree[0] != 1) return add_curve(ctx, out, curve, segments);
    for (int i = 0; status == KN_OK && i + 1 < n; i++) {
        double a[2] = {curve->coef[i], curve->coef[n + i]}, b[2] = {curve->coef[i + 1], curve->coef[n + i + 1]};
        int edge = -1;
        for (int v = 0; v < 2; v++)
            if (a[1 - v] == b[1 - v] && (a[1 - v] == 0.0 || a[1 - v] == 1.0)) edge = v;
        status = edge >= 0 ? add_edge(ctx, out, a, b, edge, segments[edge]) : add_segment(ctx, out, a, b, segments);
    }
    return status;
}

kn_status kn_outline_sample(kn_ctx *ctx, kn_outline *out, const kn_trim *trim, const int segments[2])
{
    out->loop_end = kn_alloc(ctx, (size_t)trim->nloops, sizeof *out->loop_end);
    if (!out->loop_end) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (int i = 0, k = 0; status == KN_OK && i < trim->nloops; i++) {
        for (; status == KN_OK && k < trim->loop_end[i]; k++) status = add_any(ctx, out, &trim->curves[k], segments);
        out->loop_end[out->nloops++] = out->n;
    }
    return status;
}

bool kn_outline_contains(const kn_outline *o, double r, double t)
{
    int winding = 0;
    for (int l = 0, first = 0; l < o->nloops; first = o->loop_end[l++])
        for (int k = first; k < o->loop_end[l]; k++) {
            const double *p = o->at[k], *q = o->at[k + 1 < o->loop_end[l] ? k + 1 : first];
            if ((p[1] > t) == (q[1] > t)) continue;
            if (p[0] + (t - p[1]) / (q[1] - p[1]) * (q[0] - p[0]) > r) winding += q[1] > p[1] ? 1 : -1;
        }
    return winding > 0;
}
