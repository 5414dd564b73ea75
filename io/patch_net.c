// SPDX-License-Identifier: Apache-2.0
// A surface patch as writers of CAD files need it.
#include "io/patch_net.h"

#include "kernel/context.h"
#include "kernel/hash.h"

#include <math.h>
#include <stdio.h>
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

// Scaled and projected; *largest coordinate.
static kn_status load_points(kn_ctx *ctx, const double **out, const kn_spline *s, double mm, double *largest,
                             const char *format)
{
    size_t n = kn_spline_count(s);
    double *point = kn_scratch(ctx, n, 4 * sizeof *point);
    if (!point) return KN_ENOMEM;
    bool good = true;
    *largest = 0.0;
    for (size_t k = 0; k < n && good; k++) {
        double weight = s->rational ? s->coef[3 * n + k] : 1.0;
        good = weight > 0.0 && isfinite(weight);
        for (size_t c = 0; c < 3 && good; c++) {
            double x = s->coef[c * n + k] / weight * mm;
            point[4 * k + c] = x;
            good = isfinite(x);
            *largest = fmax(*largest, fabs(x));
        }
        point[4 * k + 3] = weight;
    }
    if (!good) return kn_fail(ctx, KN_EUNDEFINED, "%s: a control point of a patch is not finite", format);
    bool rational = false;
    for (size_t k = 0; k < n; k++) rational = rational || point[4 * k + 3] != point[3];
    for (size_t k = 0; k < n && !rational; k++) point[4 * k + 3] = 1.0;
    *out = point;
    return KN_OK;
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

static bool equal_keys(kn_brep_key a, kn_brep_key b)
{
    return a.a == b.a && a.b == b.b;
}

// Curves of equal control points are different ones where their knots are. Knots that were turned round are off by a
// rounding: half of the digits of each count.
static void add_knots(kn_brep_key *key, const kn_patch_axis *x, bool turned)
{
    for (int k = 1; k + 1 < x->nbreaks; k++) {
        int at = turned ? x->nbreaks - 1 - k : k;
        double knot = turned ? 1.0 - x->breaks[at] : x->breaks[at];
        key->a = kn_hash_add(key->a, (uint64_t)rint(knot * 0x1p30) * 64 + (uint64_t)x->times[at]);
        key->b = kn_hash_add(key->b, key->a);
    }
}

static kn_status load_side(kn_ctx *ctx, kn_patch_net *f, int e, const kn_patch *patch, double mm, const char *format)
{
    kn_patch_side *s = &f->side[e];
    int nr = f->axis[0].n, nt = f->axis[1].n;
    *s = (kn_patch_side){.axis = &f->axis[e % 2], .by = e % 2 == 0 ? nt : 1};
    s->first = e == 1 ? (nr - 1) * nt : e == 2 ? nt - 1 : 0;
    s->point = f->point + 4 * s->first, s->step = 4 * (ptrdiff_t)s->by;
    const kn_spline *fit = patch->edge ? &patch->edge[side_fit[e]] : NULL;
    kn_status status = KN_OK;
    if (fit && kn_spline_count(fit) != (size_t)s->axis->n) { // equal counts: the edge of the net itself
        double largest;
        status = kn_patch_axis_load(ctx, &s->own, fit, 0);
        if (status == KN_OK) status = load_points(ctx, &s->point, fit, mm, &largest, format);
        s->axis = &s->own, s->step = 4, s->first = -1;
    }
    if (status != KN_OK) return status;
    s->edge.key = kn_brep_hash(&s->turned, s->point, 4, 1, (size_t)s->axis->n, s->step);
    add_knots(&s->edge.key, s->axis, s->turned);
    s->collapsed = true;
    for (int k = 1; k < s->axis->n; k++)
        for (int c = 0; c < 3; c++)
            s->collapsed = s->collapsed && fabs(s->point[k * s->step + c] - s->point[c]) <= f->same;
    return KN_OK;
}

// Which vertices are one because an edge is a point, and whether the surface is closed.
static void join_corners(kn_patch_net *f, bool reversed)
{
    for (int e = 0; e < 4; e++) {
        kn_patch_side *s = &f->side[e];
        kn_brep_key start = corner_key(f, side_start[e]), end = corner_key(f, side_end[e]);
        if (s->collapsed && !equal_keys(start, end)) f->pair[f->npairs][0] = start, f->pair[f->npairs++][1] = end;
        s->along = (e < 2) != s->turned;
        s->edge.forward = s->along != reversed;
        s->edge.vertex[0] = s->turned ? end : start, s->edge.vertex[1] = s->turned ? start : end;
        s->corner[0] = corner_point(f, s->turned ? side_end[e] : side_start[e]);
        s->corner[1] = corner_point(f, s->turned ? side_start[e] : side_end[e]);
    }
    for (int v = 0; v < 2; v++) { // closed in r: the edges r = 0 and r = 1 are one
        const kn_patch_side *lo = &f->side[v == 0 ? 3 : 0], *hi = &f->side[v == 0 ? 1 : 2];
        f->closed[v] = equal_keys(lo->edge.key, hi->edge.key) && lo->turned == hi->turned;
    }
}

kn_status kn_patch_net_load(kn_ctx *ctx, kn_patch_net *net, const kn_patch *patch, double mm, const char *format)
{
    kn_spline s = kn_patch_spline(patch);
    double largest = 0.0;
    *net = (kn_patch_net){.n = (int)kn_spline_count(&s)};
    kn_status status = load_points(ctx, &net->point, &s, mm, &largest, format);
    for (int v = 0; v < 2 && status == KN_OK; v++) status = kn_patch_axis_load(ctx, &net->axis[v], &s, v);
    if (status != KN_OK) return status;
    for (int k = 1; k < net->n; k++) net->rational = net->rational || net->point[4 * k + 3] != net->point[3];
    net->same = kn_patch_same(largest);
    for (int e = 0; e < 4 && status == KN_OK; e++) status = load_side(ctx, net, e, patch, mm, format);
    if (status == KN_OK) join_corners(net, patch->reversed);
    return status;
}

void kn_patch_name(char name[KN_PATCH_NAME_BYTES], const kn_patch_id *id, const char *part, bool face)
{
    size_t room = (size_t)KN_PATCH_NAME_BYTES;
    int length = snprintf(name, room, "s%d c%d,%d %s", id->surface, id->cell[0], id->cell[1], part);
    if (!face || length < 0 || (size_t)length >= room) return;
    int more = snprintf(name + length, room - (size_t)length, " %d", id->patch);
    length += more;
    if (id->piece > 0 && more > 0 && (size_t)length < room)
        snprintf(name + length, room - (size_t)length, ".%d", id->piece);
}
