// SPDX-License-Identifier: Apache-2.0
// kn_tile_periodicity: to which order copies of a tile join.
#include "tile/net.h"

#include <math.h>

enum { INSIDE = 2 };

static kn_tile_edge place_of(const kn_tile_net *net, int side)
{
    kn_tile_edge place = net->pieces[side / 4].place;
    // A triangle's corner 0 is the side r = 0; t = 0 leads to corner 1, r = 1 on to corner 2.
    static const int triangle[4] = {0, 1, 0, 2};
    place.edge = place.spline < 0 ? triangle[side % 4] : side % 4;
    return place;
}

static kn_tile_edge place_of_tip(const kn_tile_net *net, int tip)
{
    kn_tile_edge place = net->curves[tip / 2].place;
    place.edge = tip % 2;
    return place;
}

static kn_status point_of(kn_ctx *ctx, double out[3], const kn_tile_net *net, int side, double x)
{
    int var = side % 4 / 2;
    double at[2];
    at[var] = side % 2;
    at[1 - var] = x;
    return kn_bezier_eval(ctx, out, &net->pieces[side / 4].surface, at);
}

// Whether the report has to say of a joint of this order that it is the first of the lowest.
static bool is_lower(const kn_tile_periodicity_report *r, int d, int order, bool decided)
{
    return order < r->order[d] || (order == r->order[d] && decided && !r->decided[d]);
}

static void note(kn_tile_periodicity_report *r, int d, int order, bool decided, const kn_tile_gap *gap)
{
    if (!is_lower(r, d, order, decided)) return;
    r->order[d] = order;
    r->decided[d] = decided;
    r->first[d] = *gap;
}

// Counts a joint for the directions in which its mate is moved.
static void count_joint(kn_tile_periodicity_report *r, const kn_tile_gap *gap, const kn_tile_joint *joint, int most)
{
    bool inside = gap->offset[0] == 0 && gap->offset[1] == 0;
    for (int d = 0; d < 3; d++) {
        if (d == INSIDE ? !inside : gap->offset[d] == 0) continue;
        r->joints[d]++;
        if (joint->order < most) note(r, d, joint->order, joint->decided, gap);
    }
}

static kn_status add_joint(kn_ctx *ctx, kn_tile_periodicity_report *r, const kn_tile_net *net, int side,
                           const kn_tile_periodicity_options *o)
{
    const kn_tile_side *s = &net->sides[side];
    kn_tile_joint joint = {0};
    kn_tile_gap gap = {place_of(net, side), place_of(net, s->mate), {s->offset[0], s->offset[1]}, 0.0, {0.0}, 0.0};
    kn_status status = kn_tile_joint_order(ctx, &joint, net, side, o->angle, o->max_order);
    if (status == KN_OK) status = point_of(ctx, gap.point, net, side, joint.at);
    if (status != KN_OK) return status;
    gap.at = joint.at, gap.amount = joint.amount;
    count_joint(r, &gap, &joint, o->max_order);
    if (!kn_tile_side_agrees(net, side)) r->reversed++;
    return KN_OK;
}

// Of the sides without a mate the one that is nearest to this one, and what is amiss there.
static kn_status find_nearest(kn_ctx *ctx, kn_tile_gap *gap, const kn_tile_net *net, int side)
{
    double p[KN_TILE_SIDE_POINTS][3], q[KN_TILE_SIDE_POINTS][3], middle[3], other[3];
    int n = kn_tile_side_points(p, net, side);
    *gap = (kn_tile_gap){.edge = place_of(net, side), .mate = {-1, -1, -1, -1, -1}, .amount = INFINITY};
    for (int c = 0; c < 3; c++) middle[c] = 0.5 * (p[0][c] + p[n - 1][c]);
    for (int j = 0; j < 4 * net->npieces; j++) {
        int offset[2];
        if (j == side || net->sides[j].mate >= 0 || net->sides[j].point) continue;
        int m = kn_tile_side_points(q, net, j);
        for (int c = 0; c < 3; c++) other[c] = 0.5 * (q[0][c] + q[m - 1][c]);
        if (!kn_tile_offset(offset, middle, other)) continue;
        for (int reversed = 0; reversed < 2; reversed++) {
            double at = 0.0, distance = kn_tile_side_distance(net, side, j, offset, reversed == 1, &at);
            if (!(distance < gap->amount)) continue;
            gap->amount = distance, gap->at = at, gap->mate = place_of(net, j);
            gap->offset[0] = offset[0], gap->offset[1] = offset[1];
        }
    }
    return point_of(ctx, gap->point, net, side, gap->at);
}

static kn_status add_open(kn_ctx *ctx, kn_tile_periodicity_report *r, const kn_tile_net *net, int side,
                          double tolerance)
{
    double p[KN_TILE_SIDE_POINTS][3];
    int n = kn_tile_side_points(p, net, side);
    if (r->open < KN_TILE_LISTED) r->open_edges[r->open] = place_of(net, side);
    r->open++;
    for (int d = 0; d < 2; d++) {
        if (!kn_tile_in_line((const double(*)[3])p, n, d, tolerance) || !is_lower(r, d, -1, true)) continue;
        kn_tile_gap gap;
        kn_status status = find_nearest(ctx, &gap, net, side);
        if (status != KN_OK) return status;
        note(r, d, -1, true, &gap);
    }
    return KN_OK;
}

static kn_status add_sides(kn_ctx *ctx, kn_tile_periodicity_report *r, const kn_tile_net *net,
                           const kn_tile_periodicity_options *o)
{
    kn_status status = KN_OK;
    for (int i = 0; i < 4 * net->npieces && status == KN_OK; i++) {
        const kn_tile_side *s = &net->sides[i];
        if (i % 256 == 0) status = kn_progress(ctx, "joints", (double)i / (4.0 * net->npieces));
        if (status != KN_OK || s->point) continue;
        if (s->nmates > 1) r->crowded++;
        if (s->mate < 0)
            status = add_open(ctx, r, net, i, o->tolerance);
        else if (s->mate > i || net->sides[s->mate].mate != i) // each pair once
            status = add_joint(ctx, r, net, i, o);
    }
    return status;
}

static void tip_point(double out[3], const kn_tile_net *net, int tip)
{
    const kn_bezier *b = &net->curves[tip / 2].curve;
    size_t n = (size_t)b->degree[0] + 1;
    for (size_t c = 0; c < 3; c++) out[c] = b->coef[c * n + (tip % 2 ? n - 1 : 0)];
}

static void find_nearest_tip(kn_tile_gap *gap, const kn_tile_net *net, int tip)
{
    gap->mate.part = -1, gap->amount = INFINITY;
    for (int j = 0; j < 2 * net->ncurves; j++) {
        double q[3], *p = gap->point;
        int offset[2];
        tip_point(q, net, j);
        if (j == tip || net->tips[j].mate >= 0 || !kn_tile_offset(offset, p, q)) continue;
        double u = p[0] - q[0] - offset[0], v = p[1] - q[1] - offset[1], w = p[2] - q[2];
        double distance = sqrt(u * u + v * v + w * w);
        if (!(distance < gap->amount)) continue;
        gap->amount = distance, gap->mate = place_of_tip(net, j);
        gap->offset[0] = offset[0], gap->offset[1] = offset[1];
    }
}

// Ends of curves are free but in lines between cells.
static kn_status add_tip(kn_ctx *ctx, kn_tile_periodicity_report *r, const kn_tile_net *net, int tip,
                         const kn_tile_periodicity_options *o)
{
    const kn_tile_side *s = &net->tips[tip];
    kn_tile_gap gap = {.edge = place_of_tip(net, tip), .at = tip % 2};
    tip_point(gap.point, net, tip);
    if (s->nmates > 1) r->crowded++;
    for (int d = 0; s->mate < 0 && d < 2; d++)
        if (kn_tile_in_line((const double(*)[3]) & gap.point, 1, d, o->tolerance) && is_lower(r, d, -1, true)) {
            find_nearest_tip(&gap, net, tip);
            note(r, d, -1, true, &gap);
        }
    if (s->mate < 0 || (s->mate < tip && net->tips[s->mate].mate == tip)) return KN_OK; // each pair once
    kn_tile_joint joint = kn_tile_tip_order(net, tip, o->angle, o->max_order);
    gap.mate = place_of_tip(net, s->mate), gap.amount = joint.amount;
    gap.offset[0] = s->offset[0], gap.offset[1] = s->offset[1];
    count_joint(r, &gap, &joint, o->max_order);
    return kn_progress(ctx, "joints", 1.0);
}

kn_tile_periodicity_options kn_tile_periodicity_defaults(void)
{
    return (kn_tile_periodicity_options){.tolerance = 1e-12, .angle = 1e-9, .max_order = 2};
}

static kn_status resolve(kn_ctx *ctx, kn_tile_periodicity_options *o)
{
    kn_tile_periodicity_options d = kn_tile_periodicity_defaults();
    if (o->tolerance == 0.0) o->tolerance = d.tolerance;
    if (o->angle == 0.0) o->angle = d.angle;
    if (o->max_order == 0) o->max_order = d.max_order;
    if (!(o->tolerance > 0.0 && o->tolerance <= 1e-6))
        return kn_fail(ctx, KN_EDOMAIN, "periodicity: tolerance %g", o->tolerance);
    if (!(o->angle >= 1e-11 && o->angle <= 0.1)) return kn_fail(ctx, KN_EDOMAIN, "periodicity: angle %g", o->angle);
    if (o->max_order < 1 || o->max_order > 2) return kn_fail(ctx, KN_EDOMAIN, "periodicity: order %d", o->max_order);
    return KN_OK;
}

kn_status kn_tile_periodicity(kn_ctx *ctx, kn_tile_periodicity_report *report, const kn_tile *tile,
                              const kn_tile_periodicity_options *options)
{
    kn_tile_periodicity_options o = options ? *options : kn_tile_periodicity_defaults();
    kn_tile_periodicity_report r = {.open = 0};
    kn_tile_net net = {0};
    kn_status status = resolve(ctx, &o);
    if (status == KN_OK) status = kn_tile_net_make(ctx, &net, tile, o.tolerance);
    if (status != KN_OK) return status;
    for (int d = 0; d < 3; d++) {
        r.order[d] = o.max_order;
        r.decided[d] = true;
        r.joints[d] = net.nfaces[d];
        if (d < 2 && net.ntorn[d] > 0)
            note(&r, d, -1, true,
                 &(kn_tile_gap){.edge = net.torn[d], .mate = {-1, -1, -1, -1, -1}, .amount = INFINITY});
    }
    r.unchecked = net.unchecked;
    status = add_sides(ctx, &r, &net, &o);
    for (int i = 0; i < 2 * net.ncurves && status == KN_OK; i++) status = add_tip(ctx, &r, &net, i, &o);
    kn_tile_net_clear(ctx, &net);
    if (status == KN_OK) *report = r;
    return status;
}
