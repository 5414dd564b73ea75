// SPDX-License-Identifier: Apache-2.0
// A surface patch as writers of CAD files need it.
#include "io/patch_net.h"

#include "kernel/context.h"

#include <math.h>
#include <string.h>

static const int side_start[4] = {0, 1, 3, 0}, side_end[4] = {1, 2, 2, 3};
static const int side_fit[4] = {2, 1, 3, 0}; // which of kn_patch.edge

double kn_patch_same(double largest)
{
    return fmax(1e-7, 1e-12 * largest); // far above the rounding of a composition
}

kn_status kn_patch_axis_load(kn_ctx *ctx, kn_patch_axis *axis, const kn_spline *s, int var)
{
    int degree = s->degree[var], count = s->count[var], most = count - degree + 1, n = 0;
    const double *knots = s->knots[var];
    int *times = kn_scratch(ctx, (size_t)most, sizeof *times);
    double *breaks = kn_scratch(ctx, (size_t)most, sizeof *breaks);
    if (!times || !breaks) return KN_ENOMEM;
    for (int k = 0; k < count + degree + 1; k++) {
        if (k > 0 && knots[k] == knots[k - 1]) {
            times[n - 1]++;
            continue;
        }
        times[n] = 1, breaks[n++] = knots[k];
    }
    *axis = (kn_patch_axis){degree, count, n, times, breaks};
    return KN_OK;
}

kn_status kn_patch_curve_load(kn_ctx *ctx, kn_patch_curve *line, const kn_spline *s, int var, double mm,
                              const char *format)
{
    size_t n = kn_spline_count(s);
    double *point = kn_scratch(ctx, n, 4 * sizeof *point), largest = 0.0;
    bool good = true, rational = false;
    if (!point) return KN_ENOMEM;
    for (size_t k = 0; k < n && good; k++) {
        double weight = s->rational ? s->coef[3 * n + k] : 1.0;
        good = weight > 0.0 && isfinite(weight);
        for (size_t c = 0; c < 3 && good; c++) {
            double x = s->coef[c * n + k] / weight * mm;
            point[4 * k + c] = x;
            good = isfinite(x);
            largest = fmax(largest, fabs(x));
        }
        point[4 * k + 3] = weight;
        rational = rational || weight != point[3];
    }
    if (!good) return kn_fail(ctx, KN_EUNDEFINED, "%s: a control point of a patch is not finite", format);
    for (size_t k = 0; k < n && !rational; k++) point[4 * k + 3] = 1.0;
    *line = (kn_patch_curve){.point = point, .step = 4, .rational = rational, .first = -1, .largest = largest};
    return kn_patch_axis_load(ctx, &line->axis, s, var);
}

static int corner_point(const kn_patch_net *f, int corner)
{
    int nr = f->axis[0].n, nt = f->axis[1].n;
    return (corner == 1 || corner == 2 ? nr - 1 : 0) * nt + (corner >= 2 ? nt - 1 : 0);
}

static kn_brep_key corner_key(const kn_patch_net *f, int corner)
{
    bool turned;
    return kn_brep_hash(&turned, f->point + 4 * corner_point(f, corner), 3, 1, 1, 0);
}

// Knot k of the curve that runs the other way over the same domain.
double kn_patch_knot(const kn_patch_axis *x, int k, bool turned)
{
    double lo = x->breaks[0], hi = x->breaks[x->nbreaks - 1];
    return turned ? lo + (hi - x->breaks[x->nbreaks - 1 - k]) : x->breaks[k];
}

// Curves of equal control points are different ones where their inner knots are. Knots that were turned round are off
// by a rounding: half of their digits count.
kn_brep_key kn_patch_curve_key(bool *turned, const kn_patch_curve *line)
{
    const kn_patch_axis *x = &line->axis;
    kn_brep_key key = kn_brep_hash(turned, line->point, line->rational ? 4 : 3, 1, (size_t)x->n, line->step);
    double lo = x->breaks[0], length = x->breaks[x->nbreaks - 1] - lo;
    for (int k = 1; k + 1 < x->nbreaks; k++) {
        key = kn_brep_mix(key, rint((kn_patch_knot(x, k, *turned) - lo) / length * 0x1p26));
        key = kn_brep_mix(key, x->times[*turned ? x->nbreaks - 1 - k : k]);
    }
    return key;
}

static bool same_axis(const kn_patch_axis *x, const kn_patch_axis *y)
{
    bool same = x->n == y->n && x->degree == y->degree && x->nbreaks == y->nbreaks;
    for (int k = 0; same && k < x->nbreaks; k++) same = x->breaks[k] == y->breaks[k] && x->times[k] == y->times[k];
    return same;
}

static bool same_line(const kn_patch_curve *a, const kn_patch_curve *b)
{
    bool same = same_axis(&a->axis, &b->axis) && a->rational == b->rational;
    for (int k = 0; same && k < a->axis.n; k++)
        for (int c = 0; c < (a->rational ? 4 : 3); c++)
            same = same && a->point[k * a->step + c] == b->point[k * b->step + c];
    return same;
}

// The end of the surface itself, on its points, or a fit of the edge.
static kn_status load_side(kn_ctx *ctx, kn_patch_net *f, int e, const kn_patch *patch, double mm, const char *format)
{
    kn_patch_side *s = &f->side[e];
    int nr = f->axis[0].n, nt = f->axis[1].n, first = e == 1 ? (nr - 1) * nt : e == 2 ? nt - 1 : 0;
    kn_patch_curve end = {.axis = f->axis[e % 2], .point = f->point + 4 * first, .first = first};
    end.by = e % 2 == 0 ? nt : 1, end.step = 4 * (ptrdiff_t)end.by;
    for (int k = 1; k < end.axis.n; k++) end.rational = end.rational || end.point[k * end.step + 3] != end.point[3];
    *s = (kn_patch_side){.line = end};
    if (patch->edge) {
        kn_patch_curve own = {0};
        kn_status status = kn_patch_curve_load(ctx, &own, &patch->edge[side_fit[e]], 0, mm, format);
        if (status != KN_OK) return status;
        if (!same_line(&own, &end)) s->line = own;
    }
    s->edge.key = kn_patch_curve_key(&s->turned, &s->line);
    s->collapsed = kn_patch_curve_collapsed(&s->line, f->same);
    return KN_OK;
}

bool kn_patch_curve_collapsed(const kn_patch_curve *line, double same)
{
    bool collapsed = true;
    for (int k = 1; k < line->axis.n; k++)
        for (int c = 0; c < 3; c++)
            collapsed = collapsed && fabs(line->point[k * line->step + c] - line->point[c]) <= same;
    return collapsed;
}

// Which vertices are one because an edge is a point, and whether the surface is closed.
static void join_corners(kn_patch_net *f, bool reversed)
{
    for (int e = 0; e < 4; e++) {
        kn_patch_side *s = &f->side[e];
        kn_brep_key start = corner_key(f, side_start[e]), end = corner_key(f, side_end[e]);
        if (s->collapsed && !kn_brep_same(start, end)) f->pair[f->npairs][0] = start, f->pair[f->npairs++][1] = end;
        s->along = (e < 2) != s->turned;
        s->edge.forward = s->along != reversed;
        s->edge.vertex[0] = s->turned ? end : start, s->edge.vertex[1] = s->turned ? start : end;
        s->corner[0] = corner_point(f, s->turned ? side_end[e] : side_start[e]);
        s->corner[1] = corner_point(f, s->turned ? side_start[e] : side_end[e]);
    }
    for (int v = 0; v < 2; v++) { // closed in r: the edges r = 0 and r = 1 are one
        const kn_patch_side *lo = &f->side[v == 0 ? 3 : 0], *hi = &f->side[v == 0 ? 1 : 2];
        f->closed[v] = kn_brep_same(lo->edge.key, hi->edge.key) && lo->turned == hi->turned;
    }
}

kn_status kn_patch_net_load(kn_ctx *ctx, kn_patch_net *net, const kn_patch *patch, double mm, const char *format)
{
    kn_spline s = kn_patch_spline(patch);
    kn_patch_curve all = {0};
    kn_status status = kn_patch_curve_load(ctx, &all, &s, 0, mm, format);
    if (status != KN_OK) return status;
    *net = (kn_patch_net){.n = (int)kn_spline_count(&s), .point = all.point, .rational = all.rational};
    net->axis[0] = all.axis;
    net->same = kn_patch_same(all.largest);
    status = kn_patch_axis_load(ctx, &net->axis[1], &s, 1);
    for (int e = 0; e < 4 && status == KN_OK; e++) status = load_side(ctx, net, e, patch, mm, format);
    if (status == KN_OK) join_corners(net, patch->reversed);
    return status;
}

kn_status kn_patch_side_spline(kn_ctx *ctx, kn_spline *out, const kn_patch *patch, int e)
{
    if (patch->edge) return kn_spline_copy(ctx, out, &patch->edge[side_fit[e]]);
    kn_spline s = kn_patch_spline(patch);
    return kn_spline_isoparametric(ctx, out, &s, 1 - e % 2, e == 1 || e == 2 ? 1.0 : 0.0);
}
