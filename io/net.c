// SPDX-License-Identifier: Apache-2.0
// Splines as files have them: knots and control points as they come, checked, and clamped at the end.
#include "io/net.h"
#include "io/clamp.h"
#include "io/model.h"
#include "kernel/context.h"

void kn_net_clear(kn_ctx *ctx, kn_net *net)
{
    for (int d = 0; d < KN_NET_VARIABLES; d++) kn_free(ctx, net->knots[d]);
    kn_free(ctx, net->coef);
    *net = (kn_net){0};
}

kn_status kn_net_set_variable(kn_scan *scan, kn_net *net, int d, int count, int order, bool knots)
{
    if (order > KN_MAX_DEGREE + 1)
        return kn_scan_fail(scan, KN_ELIMIT, "order %d, but at most %d is allowed", order, KN_MAX_DEGREE + 1);
    if (count < order)
        return kn_scan_fail(scan, KN_EPARSE, "%d control points are fewer than the order %d", count, order);
    kn_status status = knots ? kn_scan_room(scan, (double)count + order, "knots") : KN_OK;
    if (status != KN_OK) return status;
    net->degree[d] = order - 1, net->count[d] = count;
    net->knots[d] = kn_alloc(scan->ctx, (size_t)count + (size_t)order, sizeof *net->knots[d]);
    return net->knots[d] ? KN_OK : KN_ENOMEM;
}

void kn_net_bezier_knots(kn_net *net, int d)
{
    for (int i = 0; i <= net->count[d] + net->degree[d]; i++) net->knots[d][i] = i > net->degree[d] ? 1.0 : 0.0;
}

kn_status kn_net_scan_knot(kn_scan *scan, kn_net *net, int d, int i)
{
    double *knots = net->knots[d];
    int order = net->degree[d] + 1;
    scan->item = (size_t)i + 1;
    kn_status status = kn_scan_real(scan, &knots[i], "knot");
    if (status != KN_OK) return status;
    if (i > 0 && knots[i] < knots[i - 1])
        return kn_scan_fail(scan, KN_EPARSE, "knots decrease: %.17g after %.17g", knots[i], knots[i - 1]);
    if (i >= order && knots[i] == knots[i - order])
        return kn_scan_fail(scan, KN_EPARSE, "knot %.17g more than %d times, the order", knots[i], order);
    return KN_OK;
}

kn_status kn_net_check_domain(kn_scan *scan, const kn_net *net, int d)
{
    double lo = net->knots[d][net->degree[d]], hi = net->knots[d][net->count[d]];
    if (lo < hi) return KN_OK;
    return kn_scan_fail(scan, KN_EPARSE, "knots leave an empty domain: %.17g to %.17g", lo, hi);
}

kn_status kn_net_make_room(kn_scan *scan, kn_net *net, size_t *points)
{
    double total = net->ncomp;
    for (int d = 0; d < net->nvars; d++) total *= net->count[d];
    kn_status status = kn_scan_room(scan, total, "coordinates of control points");
    if (status != KN_OK) return status;
    if (total > (double)KN_MAX_COEFS)
        return kn_scan_fail(scan, KN_ELIMIT, "%.0f coordinates, but at most %zu are allowed", total, KN_MAX_COEFS);
    *points = (size_t)total / (size_t)net->ncomp;
    net->coef = kn_alloc(scan->ctx, (size_t)total, sizeof *net->coef);
    return net->coef ? KN_OK : KN_ENOMEM;
}

size_t kn_net_place(const kn_net *net, size_t k)
{
    size_t at = 0, stride = 1, index[KN_NET_VARIABLES];
    for (int d = 0; d < net->nvars; d++) {
        index[d] = k % (size_t)net->count[d];
        k /= (size_t)net->count[d];
    }
    for (int d = net->nvars - 1; d >= 0; d--) {
        at += index[d] * stride;
        stride *= (size_t)net->count[d];
    }
    return at;
}

// Variable d as one axis of the array: components and earlier variables outside it, later variables inside.
static kn_status clamp_variable(kn_ctx *ctx, kn_net *net, int d)
{
    kn_axis axis = {.degree = net->degree[d], .count = net->count[d], .outer = (size_t)net->ncomp, .inner = 1};
    for (int e = 0; e < d; e++) axis.outer *= (size_t)net->count[e];
    for (int e = d + 1; e < net->nvars; e++) axis.inner *= (size_t)net->count[e];
    axis.knots = net->knots[d], axis.coef = net->coef;
    kn_status status = kn_axis_clamped(&axis) ? KN_OK : kn_axis_clamp(ctx, &axis);
    net->knots[d] = axis.knots, net->coef = axis.coef, net->count[d] = axis.count;
    return status;
}

kn_status kn_net_spline(kn_scan *scan, kn_spline *out, kn_net *net, int line)
{
    kn_status status = KN_OK;
    for (int d = 0; d < net->nvars && status == KN_OK; d++) status = clamp_variable(scan->ctx, net, d);
    if (status == KN_OK) {
        const double *knots[KN_NET_VARIABLES] = {net->knots[0], net->knots[1], net->knots[2]};
        status = kn_spline_init(scan->ctx, out, net->nvars, net->ncomp, net->rational, net->degree, net->count, knots,
                                net->coef);
    }
    if (status == KN_OK && kn_spline_no_area(out)) {
        scan->line = line;
        status = kn_scan_fail(scan, KN_EPARSE, "surface (object %d) has zero area", scan->object);
    }
    return status;
}
