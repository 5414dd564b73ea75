// SPDX-License-Identifier: Apache-2.0
// The curves of a trimmed patch.
#include "io/trim_edges.h"

#include "kernel/context.h"

#include <math.h>
#include <string.h>

static bool on_border(const kn_spline *c, int *var)
{
    int n = c->count[0];
    for (int v = 0; v < 2; v++) {
        double at = c->coef[(1 - v) * n];
        bool all = c->degree[0] == 1 && n == 2 && (at == 0.0 || at == 1.0);
        if (!all || c->coef[(1 - v) * n + 1] != at) continue;
        *var = v;
        return true;
    }
    return false;
}

// Knots 0 .. spans, degree + 1 of them at the ends and degree between: pieces that meet.
static kn_status even_axis(kn_ctx *ctx, kn_patch_axis *x, int degree, int spans)
{
    int *times = kn_scratch(ctx, (size_t)spans + 1, sizeof *times);
    double *breaks = kn_scratch(ctx, (size_t)spans + 1, sizeof *breaks);
    if (!times || !breaks) return KN_ENOMEM;
    for (int k = 0; k <= spans; k++) {
        times[k] = k == 0 || k == spans ? degree + 1 : degree;
        breaks[k] = k;
    }
    *x = (kn_patch_axis){degree, degree * spans + 1, spans + 1, times, breaks};
    return KN_OK;
}

static kn_status make_line(kn_ctx *ctx, kn_patch_curve *line, double **point, int degree, int spans)
{
    *point = kn_scratch(ctx, (size_t)(degree * spans) + 1, 4 * sizeof **point);
    *line = (kn_patch_curve){.point = *point, .step = 4, .first = -1};
    return *point ? even_axis(ctx, &line->axis, degree, spans) : KN_ENOMEM;
}

// Points of a trim curve: those of a polyline are its own; of others, eight to a span.
static kn_status sample_plane(kn_ctx *ctx, kn_trim_edge *e, const kn_spline *c)
{
    int n = c->count[0], spans = c->degree[0] == 1 ? n - 1 : 8 * kn_spline_spans(c, 0);
    double *p, lo, hi;
    kn_spline_domain(c, 0, &lo, &hi);
    kn_status status = make_line(ctx, &e->plane, &p, 1, spans);
    for (int k = 0; k <= spans && status == KN_OK; k++, p += 4) {
        double at = k == spans ? hi : lo + (hi - lo) * k / spans;
        int own = k == spans ? n - 1 : c->degree[0] == 1 ? k : 0;
        p[0] = c->coef[own], p[1] = c->coef[n + own];
        if (c->degree[0] > 1 && k > 0 && k < spans) status = kn_spline_eval(ctx, p, c, &at);
        p[2] = 0.0, p[3] = 1.0;
    }
    return status;
}

// Control points j = 0 .. 3 of the cubic over the segment from a to b of the trim.
static kn_status put_cubic(kn_ctx *ctx, double *p, const kn_spline *surface, const double *a, const double *b)
{
    double from[9], to[9], d[2] = {b[0] - a[0], b[1] - a[1]};
    kn_status status = kn_spline_derivatives(ctx, from, surface, a, 1);
    if (status == KN_OK) status = kn_spline_derivatives(ctx, to, surface, b, 1);
    if (status != KN_OK) return status;
    for (int c = 0; c < 3; c++) {
        p[c] = from[c];
        p[4 + c] = from[c] + (from[3 + c] * d[0] + from[6 + c] * d[1]) / 3.0;
        p[8 + c] = to[c] - (to[3 + c] * d[0] + to[6 + c] * d[1]) / 3.0;
        p[12 + c] = to[c];
    }
    for (int j = 0; j < 4; j++) p[4 * j + 3] = 1.0;
    return KN_OK;
}

static kn_status add_cubics(kn_ctx *ctx, kn_trim_edge *e, const kn_spline *surface)
{
    int spans = e->plane.axis.n - 1;
    double *p;
    kn_status status = make_line(ctx, &e->space, &p, 3, spans);
    for (int k = 0; k < spans && status == KN_OK; k++)
        status = put_cubic(ctx, p + 12 * k, surface, e->plane.point + 4 * k, e->plane.point + 4 * k + 4);
    return status;
}

// Along the side of the square where variable v runs.
static kn_status add_border(kn_ctx *ctx, kn_trim_edge *e, const kn_patch *patch, int v, double mm, const char *format)
{
    const double *p = e->plane.point;
    double from = p[v], to = p[4 + v], lo = fmin(from, to), hi = fmax(from, to);
    bool upper = p[1 - v] == 1.0;
    kn_spline part = {0};
    kn_status status = kn_patch_side_spline(ctx, &part, patch, v == 0 ? (upper ? 2 : 0) : (upper ? 1 : 3));
    if (status == KN_OK && (lo > 0.0 || hi < 1.0)) status = kn_spline_restrict(ctx, &part, &part, &lo, &hi);
    if (status == KN_OK && from > to) status = kn_spline_reverse(ctx, &part, &part, 0);
    if (status == KN_OK) status = kn_patch_curve_load(ctx, &e->space, &part, 0, mm, format);
    kn_spline_clear(ctx, &part);
    return status;
}

// A curve that is a point has no edge; its start is then that of the next one.
static void join_starts(kn_trim_edge *edges, const kn_trim *trim)
{
    for (int i = 0, first = 0; i < trim->nloops; first = trim->loop_end[i++]) {
        int n = trim->loop_end[i] - first;
        for (int k = 0; k < n; k++) {
            int at = k, steps = 0;
            while (edges[first + at].collapsed && steps++ < n) at = (at + 1) % n;
            edges[first + k].start = first + at;
        }
    }
}

kn_status kn_trim_edges(kn_ctx *ctx, kn_trim_edge **out, const kn_patch *patch, const kn_patch_net *net, double mm,
                        const char *format)
{
    const kn_trim *trim = patch->trim;
    kn_spline surface = {0}, view = kn_patch_spline(patch);
    kn_trim_edge *edges = kn_scratch(ctx, (size_t)trim->ncurves, sizeof *edges);
    kn_status status = edges ? kn_spline_scale(ctx, &surface, &view, mm) : KN_ENOMEM;
    for (int k = 0; k < trim->ncurves && status == KN_OK; k++) {
        int v;
        edges[k] = (kn_trim_edge){.start = k};
        status = sample_plane(ctx, &edges[k], &trim->curves[k]);
        if (status != KN_OK) break;
        status = on_border(&trim->curves[k], &v) ? add_border(ctx, &edges[k], patch, v, mm, format)
                                                 : add_cubics(ctx, &edges[k], &surface);
        if (status == KN_OK) edges[k].collapsed = kn_patch_curve_collapsed(&edges[k].space, net->same);
    }
    if (status == KN_OK) join_starts(edges, trim);
    kn_spline_clear(ctx, &surface);
    *out = edges;
    return status;
}

double kn_trim_edges_area(const kn_trim_edge *edges, int first, int last)
{
    double sum = 0.0;
    for (int k = first; k < last; k++)
        for (int i = 0; i + 1 < edges[k].plane.axis.n; i++) {
            const double *p = edges[k].plane.point + 4 * i, *q = p + 4;
            sum += p[0] * q[1] - p[1] * q[0];
        }
    return sum;
}
