// SPDX-License-Identifier: Apache-2.0
// Reads GoTools .g2 files: spline curves, surfaces and volumes.
//
// Format (GoTools wiki, "GoTools g2 file format"): an object is "class major minor n", n integers of colour, then
// "dimension rational", for each variable "count order" and its knots, and the control points with the first variable
// fastest. Those of rational objects are homogeneous, already multiplied by the weight that comes last.
#include <knurl/io.h>

#include "io/clamp.h"
#include "io/model.h"
#include "io/text_scan.h"
#include "kernel/context.h"

#include <limits.h>

enum { MAX_VARIABLES = 3, MAX_COLOUR = 4 };

// An object as it is read, before it is known to be a clamped spline.
typedef struct object {
    int nvars, ncomp, dim;
    bool rational;
    int degree[MAX_VARIABLES], count[MAX_VARIABLES];
    double *knots[MAX_VARIABLES];
    double *coef; // as in a kn_spline
} object;

static void clear(kn_ctx *ctx, object *o)
{
    for (int d = 0; d < MAX_VARIABLES; d++) kn_free(ctx, o->knots[d]);
    kn_free(ctx, o->coef);
}

static kn_status parse_header(kn_scan *scan, object *o)
{
    int code = 0, version = 0, colours = 0, colour = 0;
    kn_status status = kn_scan_int(scan, &code, "class of object", 0, INT_MAX);
    if (status != KN_OK) return status;
    o->nvars = code == 100 ? 1 : code == 200 ? 2 : code == 700 ? 3 : 0;
    if (o->nvars == 0)
        return kn_scan_fail_word(scan, "class of object", "none of 100 (curve), 200 (surface), 700 (volume)");
    status = kn_scan_int(scan, &version, "major version", 1, 1);
    if (status == KN_OK) status = kn_scan_int(scan, &version, "minor version", 0, INT_MAX);
    if (status == KN_OK) status = kn_scan_int(scan, &colours, "number of colour values", 0, MAX_COLOUR);
    for (int i = 0; i < colours && status == KN_OK; i++) status = kn_scan_int(scan, &colour, "colour value", 0, 255);
    int rational = 0;
    if (status == KN_OK) status = kn_scan_int(scan, &o->dim, "dimension", 1, KN_MAX_COMPS - 1);
    if (status == KN_OK) status = kn_scan_int(scan, &rational, "rational flag", 0, 1);
    o->rational = rational == 1;
    o->ncomp = o->dim + rational;
    return status;
}

// knots[i] among its predecessors: not smaller, and no value more than order times.
static kn_status check_knot(kn_scan *scan, const double *knots, int i, int order)
{
    if (i > 0 && knots[i] < knots[i - 1])
        return kn_scan_fail(scan, KN_EPARSE, "knots decrease: %.17g after %.17g", knots[i], knots[i - 1]);
    if (i >= order && knots[i] == knots[i - order])
        return kn_scan_fail(scan, KN_EPARSE, "knot %.17g more than %d times, the order", knots[i], order);
    return KN_OK;
}

static kn_status parse_knots(kn_scan *scan, object *o, int d)
{
    int n = 0, order = 0;
    scan->item = 0;
    kn_status status = kn_scan_int(scan, &n, "number of control points", 1, INT_MAX / 2);
    if (status == KN_OK) status = kn_scan_int(scan, &order, "order", 1, INT_MAX / 2);
    if (status != KN_OK) return status;
    if (order > KN_MAX_DEGREE + 1)
        return kn_scan_fail(scan, KN_ELIMIT, "order %d, but at most %d is allowed", order, KN_MAX_DEGREE + 1);
    if (n < order) return kn_scan_fail(scan, KN_EPARSE, "%d control points are fewer than the order %d", n, order);
    status = kn_scan_room(scan, (double)n + order, "knots");
    if (status != KN_OK) return status;
    o->degree[d] = order - 1, o->count[d] = n;
    o->knots[d] = kn_alloc(scan->ctx, (size_t)(n + order), sizeof *o->knots[d]);
    if (o->knots[d] == NULL) return KN_ENOMEM;
    for (int i = 0; i < n + order && status == KN_OK; i++) {
        scan->item = (size_t)i + 1;
        status = kn_scan_real(scan, &o->knots[d][i], "knot");
        if (status == KN_OK) status = check_knot(scan, o->knots[d], i, order);
    }
    if (status == KN_OK && !(o->knots[d][order - 1] < o->knots[d][n]))
        status = kn_scan_fail(scan, KN_EPARSE, "knots leave an empty domain: %.17g to %.17g", o->knots[d][order - 1],
                              o->knots[d][n]);
    return status;
}

// Where control point k of the file (first variable fastest) goes in a spline (last variable fastest).
static size_t place(const object *o, size_t k)
{
    size_t at = 0, stride = 1, index[MAX_VARIABLES];
    for (int d = 0; d < o->nvars; d++) {
        index[d] = k % (size_t)o->count[d];
        k /= (size_t)o->count[d];
    }
    for (int d = o->nvars - 1; d >= 0; d--) {
        at += index[d] * stride;
        stride *= (size_t)o->count[d];
    }
    return at;
}

static kn_status parse_points(kn_scan *scan, object *o)
{
    double total = o->ncomp;
    for (int d = 0; d < o->nvars; d++) total *= o->count[d];
    kn_status status = kn_scan_room(scan, total, "coordinates of control points");
    if (status != KN_OK) return status;
    if (total > (double)KN_MAX_COEFS)
        return kn_scan_fail(scan, KN_ELIMIT, "%.0f coordinates, but at most %zu are allowed", total, KN_MAX_COEFS);
    size_t n = (size_t)total / (size_t)o->ncomp;
    o->coef = kn_alloc(scan->ctx, (size_t)total, sizeof *o->coef);
    if (o->coef == NULL) return KN_ENOMEM;
    for (size_t k = 0; k < n && status == KN_OK; k++) {
        size_t at = place(o, k);
        scan->item = k + 1;
        for (int c = 0; c < o->ncomp && status == KN_OK; c++) {
            double *value = &o->coef[(size_t)c * n + at];
            status = kn_scan_real(scan, value, c < o->dim ? "control point" : "weight");
            if (status == KN_OK && c == o->dim && !(*value > 0.0))
                status = kn_scan_fail_word(scan, "weight", "not positive");
        }
    }
    return status;
}

// Variable d as one axis of the array: components and earlier variables outside it, later variables inside.
static kn_status clamp_variable(kn_ctx *ctx, object *o, int d)
{
    kn_axis axis = {.degree = o->degree[d], .count = o->count[d], .outer = (size_t)o->ncomp, .inner = 1};
    for (int e = 0; e < d; e++) axis.outer *= (size_t)o->count[e];
    for (int e = d + 1; e < o->nvars; e++) axis.inner *= (size_t)o->count[e];
    axis.knots = o->knots[d], axis.coef = o->coef;
    kn_status status = kn_axis_clamped(&axis) ? KN_OK : kn_axis_clamp(ctx, &axis);
    o->knots[d] = axis.knots, o->coef = axis.coef, o->count[d] = axis.count;
    return status;
}

static kn_status parse_object(kn_scan *scan, kn_spline *out)
{
    object o = {0};
    scan->item = 0;
    kn_status status = parse_header(scan, &o);
    int line = scan->line;
    for (int d = 0; d < o.nvars && status == KN_OK; d++) status = parse_knots(scan, &o, d);
    if (status == KN_OK) status = parse_points(scan, &o);
    for (int d = 0; d < o.nvars && status == KN_OK; d++) status = clamp_variable(scan->ctx, &o, d);
    if (status == KN_OK) {
        const double *knots[MAX_VARIABLES] = {o.knots[0], o.knots[1], o.knots[2]};
        status = kn_spline_init(scan->ctx, out, o.nvars, o.ncomp, o.rational, o.degree, o.count, knots, o.coef);
    }
    if (status == KN_OK && kn_spline_no_area(out)) {
        scan->line = line;
        status = kn_scan_fail(scan, KN_EPARSE, "surface (object %d) has zero area", scan->object);
    }
    clear(scan->ctx, &o);
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
