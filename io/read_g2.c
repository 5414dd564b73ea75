// SPDX-License-Identifier: Apache-2.0
// Reads GoTools .g2 files: spline curves, surfaces and volumes.
//
// Format (GoTools wiki, "GoTools g2 file format"): an object is "class major minor n", n integers of colour, then
// "dimension rational", for each variable "count order" and its knots, and the control points with the first variable
// fastest. Those of rational objects are homogeneous, already multiplied by the weight that comes last.
#include <knurl/io.h>

#include "io/model.h"
#include "io/net.h"
#include "io/text_scan.h"
#include "kernel/context.h"

#include <limits.h>

enum { MAX_COLOUR = 4 };

static kn_status parse_header(kn_scan *scan, kn_net *net)
{
    int code = 0, version = 0, colours = 0, colour = 0;
    kn_status status = kn_scan_int(scan, &code, "class of object", 0, INT_MAX);
    if (status != KN_OK) return status;
    net->nvars = code == 100 ? 1 : code == 200 ? 2 : code == 700 ? 3 : 0;
    if (net->nvars == 0)
        return kn_scan_fail_word(scan, "class of object", "none of 100 (curve), 200 (surface), 700 (volume)");
    status = kn_scan_int(scan, &version, "major version", 1, 1);
    if (status == KN_OK) status = kn_scan_int(scan, &version, "minor version", 0, INT_MAX);
    if (status == KN_OK) status = kn_scan_int(scan, &colours, "number of colour values", 0, MAX_COLOUR);
    for (int i = 0; i < colours && status == KN_OK; i++) status = kn_scan_int(scan, &colour, "colour value", 0, 255);
    int rational = 0;
    if (status == KN_OK) status = kn_scan_int(scan, &net->dim, "dimension", 1, KN_MAX_COMPS - 1);
    if (status == KN_OK) status = kn_scan_int(scan, &rational, "rational flag", 0, 1);
    net->rational = rational == 1;
    net->ncomp = net->dim + rational;
    return status;
}

static kn_status parse_knots(kn_scan *scan, kn_net *net, int d)
{
    int n = 0, order = 0;
    scan->item = 0;
    kn_status status = kn_scan_int(scan, &n, "number of control points", 1, INT_MAX / 2);
    if (status == KN_OK) status = kn_scan_int(scan, &order, "order", 1, INT_MAX / 2);
    if (status == KN_OK) status = kn_net_set_variable(scan, net, d, n, order, true);
    for (int i = 0; i < n + order && status == KN_OK; i++) status = kn_net_scan_knot(scan, net, d, i);
    return status == KN_OK ? kn_net_check_domain(scan, net, d) : status;
}

static kn_status parse_points(kn_scan *scan, kn_net *net)
{
    size_t n = 0;
    kn_status status = kn_net_make_room(scan, net, &n);
    for (size_t k = 0; k < n && status == KN_OK; k++) {
        size_t at = kn_net_place(net, k);
        scan->item = k + 1;
        for (int c = 0; c < net->ncomp && status == KN_OK; c++) {
            double *value = &net->coef[(size_t)c * n + at];
            status = kn_scan_real(scan, value, c < net->dim ? "control point" : "weight");
            if (status == KN_OK && c == net->dim && !(*value > 0.0))
                status = kn_scan_fail_word(scan, "weight", "not positive");
        }
    }
    return status;
}

static kn_status parse_object(kn_scan *scan, kn_spline *out)
{
    kn_net net = {0};
    scan->item = 0;
    kn_status status = parse_header(scan, &net);
    int line = scan->line;
    for (int d = 0; d < net.nvars && status == KN_OK; d++) status = parse_knots(scan, &net, d);
    if (status == KN_OK) status = parse_points(scan, &net);
    if (status == KN_OK) status = kn_net_spline(scan, out, &net, line);
    kn_net_clear(scan->ctx, &net);
    return status;
}

kn_status kn_parse_g2(kn_ctx *ctx, kn_model *out, const char *name, const char *text, size_t bytes)
{
    kn_scan scan = kn_scan_start(ctx, name, text, bytes);
    scan.kind = "object";
    kn_model model = {0};
    kn_status status = KN_OK;
    do { // an empty file is reported by the first object's header
        kn_spline spline = {0};
        scan.object = model.nsplines + 1;
        status = parse_object(&scan, &spline);
        if (status == KN_OK) status = kn_model_append(ctx, &model, &spline);
        kn_spline_clear(ctx, &spline);
    } while (status == KN_OK && !kn_scan_at_end(&scan));
    if (status == KN_OK) kn_model_move(ctx, out, &model);
    kn_model_clear(ctx, &model);
    return status;
}

kn_status kn_read_g2(kn_ctx *ctx, kn_model *out, const char *path)
{
    return kn_read_with(ctx, out, path, kn_parse_g2);
}
