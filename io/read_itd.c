// SPDX-License-Identifier: Apache-2.0
// Reads IRIT data files: curves, surfaces and trivariates, polylines and polygons.
//
// Format (IRIT user's manual, "Data file format"): everything is "[KEYWORD ...]". An object, "[OBJECT [attribute value]
// .. NAME body]", holds geometry or further objects. "[SURFACE BSPLINE nu nv ku kv P3 [KV ..] [KV ..] [w x y z] ..]":
// counts, orders, the kind of points (E: polynomial, P: rational, the weight first and coordinates multiplied by it),
// a knot vector for each variable, and control points with the first variable fastest; "[SURFACE BEZIER nu nv E3 ..]"
// has counts alone. "[POLYGON [PLANE ..] n [[NORMAL ..] x y z] ..]". What lies outside brackets is a comment.
#include <knurl/io.h>

#include "io/model.h"
#include "io/net.h"
#include "io/text_scan.h"
#include "kernel/context.h"

#include <limits.h>
#include <string.h>

enum { MAX_COORDINATES = 9 };

static bool is_word(const kn_scan *scan, const char *word)
{
    return scan->length == strlen(word) && memcmp(scan->word, word, scan->length) == 0;
}

static kn_status fail_end(kn_scan *scan, const char *what)
{
    return kn_scan_fail(scan, KN_EPARSE, "the file ends where %s was expected", what);
}

static kn_status expect(kn_scan *scan, const char *word, const char *what)
{
    if (!kn_scan_word(scan)) return fail_end(scan, what);
    return is_word(scan, word) ? KN_OK : kn_scan_fail_word(scan, what, "missing");
}

// Behind the bracket that closes the one which was read last.
static kn_status skip_group(kn_scan *scan)
{
    for (size_t depth = 1; depth > 0;) {
        if (!kn_scan_word(scan)) return fail_end(scan, "']'");
        depth += is_word(scan, "[");
        depth -= is_word(scan, "]");
    }
    return KN_OK;
}

// Groups of attributes that stand before a word; the word is read.
static kn_status skip_attributes(kn_scan *scan, const char *what)
{
    for (;;) {
        if (!kn_scan_word(scan)) return fail_end(scan, what);
        if (!is_word(scan, "[")) return KN_OK;
        kn_status status = skip_group(scan);
        if (status != KN_OK) return status;
    }
}

// ---- splines ----

// "E3" or "P3".
static kn_status parse_point_type(kn_scan *scan, kn_net *net)
{
    const char *what = "kind of points";
    if (!kn_scan_word(scan)) return fail_end(scan, what);
    char kind = scan->length > 0 ? scan->word[0] : ' ';
    if (scan->length != 2 || (kind != 'E' && kind != 'P') || scan->word[1] < '1' ||
        scan->word[1] > '0' + MAX_COORDINATES)
        return kn_scan_fail_word(scan, what, "none of E1 .. E9, P1 .. P9");
    net->dim = scan->word[1] - '0';
    net->rational = kind == 'P';
    net->ncomp = net->dim + net->rational;
    return KN_OK;
}

static kn_status parse_knots(kn_scan *scan, kn_net *net, int d)
{
    kn_status status = expect(scan, "[", "knot vector");
    if (status != KN_OK) return status;
    if (!kn_scan_word(scan)) return fail_end(scan, "KV");
    if (is_word(scan, "KVP")) return kn_scan_fail(scan, KN_EPARSE, "a periodic knot vector (KVP) is not read");
    if (!is_word(scan, "KV")) return kn_scan_fail_word(scan, "knot vector", "missing");
    for (int i = 0; i <= net->count[d] + net->degree[d] && status == KN_OK; i++)
        status = kn_net_scan_knot(scan, net, d, i);
    scan->item = 0;
    if (status == KN_OK) status = kn_net_check_domain(scan, net, d);
    return status == KN_OK ? expect(scan, "]", "']' after the knots") : status;
}

static kn_status parse_point(kn_scan *scan, kn_net *net, size_t n, size_t k)
{
    size_t at = kn_net_place(net, k);
    scan->item = k + 1;
    kn_status status = expect(scan, "[", "control point");
    for (int i = 0; i < net->ncomp && status == KN_OK; i++) {
        bool weight = net->rational && i == 0; // first in the file, last in a spline
        int c = !net->rational ? i : weight ? net->dim : i - 1;
        double *value = &net->coef[(size_t)c * n + at];
        status = kn_scan_real(scan, value, weight ? "weight" : "control point");
        if (status == KN_OK && weight && !(*value > 0.0)) status = kn_scan_fail_word(scan, "weight", "not positive");
    }
    return status == KN_OK ? expect(scan, "]", "']' after a control point") : status;
}

// Counts, and orders of what is no Bezier spline.
static kn_status parse_counts(kn_scan *scan, kn_net *net, bool bezier)
{
    int order[KN_NET_VARIABLES] = {0};
    kn_status status = KN_OK;
    for (int d = 0; d < net->nvars && status == KN_OK; d++)
        status = kn_scan_int(scan, &net->count[d], "number of control points", 1, INT_MAX / 2);
    for (int d = 0; d < net->nvars && status == KN_OK; d++) {
        order[d] = net->count[d];
        if (!bezier) status = kn_scan_int(scan, &order[d], "order", 1, INT_MAX / 2);
    }
    if (status == KN_OK) status = parse_point_type(scan, net);
    for (int d = 0; d < net->nvars && status == KN_OK; d++) {
        status = kn_net_set_variable(scan, net, d, net->count[d], order[d], !bezier);
        if (status == KN_OK && bezier) kn_net_bezier_knots(net, d);
    }
    return status;
}

static kn_status parse_net(kn_scan *scan, kn_net *net)
{
    kn_status status = skip_attributes(scan, "BEZIER or BSPLINE");
    if (status != KN_OK) return status;
    bool bezier = is_word(scan, "BEZIER");
    size_t n = 0;
    if (!bezier && !is_word(scan, "BSPLINE")) return kn_scan_fail_word(scan, "kind", "neither BEZIER nor BSPLINE");
    status = parse_counts(scan, net, bezier);
    for (int d = 0; d < net->nvars && status == KN_OK && !bezier; d++) status = parse_knots(scan, net, d);
    if (status == KN_OK) status = kn_net_make_room(scan, net, &n);
    for (size_t k = 0; k < n && status == KN_OK; k++) status = parse_point(scan, net, n, k);
    scan->item = 0;
    return status == KN_OK ? expect(scan, "]", "']' after the control points") : status;
}

static kn_status parse_spline(kn_scan *scan, kn_model *model, int nvars)
{
    kn_net net = {.nvars = nvars};
    kn_spline spline = {0};
    int line = scan->line;
    kn_status status = parse_net(scan, &net);
    if (status == KN_OK) status = kn_net_spline(scan, &spline, &net, line);
    if (status == KN_OK) status = kn_model_append(scan->ctx, model, &spline);
    kn_spline_clear(scan->ctx, &spline);
    kn_net_clear(scan->ctx, &net);
    return status;
}

// ---- polygons ----

// "[x y z]", with attributes and an "I" (an edge inside a face) before the numbers.
static kn_status parse_vertex(kn_scan *scan, double xyz[3])
{
    kn_status status = expect(scan, "[", "vertex");
    while (status == KN_OK && !kn_scan_at_end(scan) && (*scan->at == '[' || *scan->at == 'I')) {
        kn_scan_word(scan);
        if (is_word(scan, "["))
            status = skip_group(scan);
        else if (!is_word(scan, "I"))
            status = kn_scan_fail_word(scan, "coordinate", "not a number");
    }
    for (int c = 0; c < 3 && status == KN_OK; c++) status = kn_scan_real(scan, &xyz[c], "coordinate");
    return status == KN_OK ? expect(scan, "]", "']' after a vertex") : status;
}

// The vertices of a polygon or a polyline, *n of them for kn_free.
static kn_status parse_vertices(kn_scan *scan, double **out, size_t *n)
{
    int count = 0;
    double *xyz = NULL;
    kn_status status = skip_attributes(scan, "number of vertices");
    if (status != KN_OK) return status;
    scan->at = scan->word; // the number is read again, as one
    status = kn_scan_int(scan, &count, "number of vertices", 1, INT_MAX / 2);
    if (status == KN_OK) status = kn_scan_room(scan, 3.0 * count, "coordinates of vertices");
    if (status == KN_OK && !(xyz = kn_alloc(scan->ctx, (size_t)count, 3 * sizeof *xyz))) status = KN_ENOMEM;
    for (int i = 0; i < count && status == KN_OK; i++) {
        scan->item = (size_t)i + 1;
        status = parse_vertex(scan, xyz + 3 * (size_t)i);
    }
    scan->item = 0;
    if (status == KN_OK) status = expect(scan, "]", "']' after the vertices");
    if (status == KN_OK)
        *out = xyz, *n = (size_t)count;
    else
        kn_free(scan->ctx, xyz);
    return status;
}

// Room for so many more, by half as much again.
static kn_status grow_mesh(kn_ctx *ctx, kn_mesh *mesh, size_t nv, size_t nt)
{
    size_t v = mesh->nvertices + nv, t = mesh->ntriangles + nt;
    if (v > mesh->vertex_room) {
        size_t room = v + v / 2;
        double *larger = mesh->position ? kn_resize(ctx, mesh->position, room, 3 * sizeof *larger)
                                        : kn_alloc(ctx, room, 3 * sizeof *larger);
        if (!larger) return KN_ENOMEM;
        mesh->position = larger, mesh->vertex_room = room;
    }
    if (t > mesh->triangle_room) {
        size_t room = t + t / 2;
        uint32_t *larger = mesh->triangle ? kn_resize(ctx, mesh->triangle, room, 3 * sizeof *larger)
                                          : kn_alloc(ctx, room, 3 * sizeof *larger);
        if (!larger) return KN_ENOMEM;
        mesh->triangle = larger, mesh->triangle_room = room;
    }
    return KN_OK;
}

static bool same_place(const double *a, const double *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

// A fan about the first vertex: right for convex polygons, which IRIT's are unless it is told otherwise.
static kn_status add_polygon(kn_scan *scan, kn_mesh *mesh, const double *xyz, size_t n)
{
    if (n < 3) return kn_scan_fail(scan, KN_EPARSE, "a polygon of %zu vertices", n);
    if (mesh->nvertices + n > UINT32_MAX) return kn_scan_fail(scan, KN_ELIMIT, "more than 2^32 - 1 vertices");
    kn_status status = grow_mesh(scan->ctx, mesh, n, n - 2);
    if (status != KN_OK) return status;
    uint32_t first = (uint32_t)mesh->nvertices;
    memcpy(mesh->position + 3 * mesh->nvertices, xyz, n * 3 * sizeof *xyz);
    mesh->nvertices += n;
    for (size_t i = 2; i < n; i++) {
        const double *a = xyz, *b = xyz + 3 * (i - 1), *c = xyz + 3 * i;
        if (same_place(a, b) || same_place(b, c) || same_place(c, a)) continue;
        uint32_t *t = mesh->triangle + 3 * mesh->ntriangles++;
        t[0] = first, t[1] = first + (uint32_t)i - 1, t[2] = first + (uint32_t)i;
    }
    return KN_OK;
}

static kn_status parse_polygon(kn_scan *scan, kn_model *model)
{
    double *xyz = NULL;
    size_t n = 0;
    kn_status status = parse_vertices(scan, &xyz, &n);
    if (status == KN_OK) status = add_polygon(scan, &model->mesh, xyz, n);
    kn_free(scan->ctx, xyz);
    return status;
}

// A curve of degree 1, its knots 0, 0, 1, 2 .. n - 1, n - 1.
static kn_status add_polyline(kn_scan *scan, kn_model *model, const double *xyz, size_t n)
{
    kn_net net = {.nvars = 1, .ncomp = 3, .dim = 3};
    kn_spline spline = {0};
    if (n < 2) return kn_scan_fail(scan, KN_EPARSE, "a polyline of %zu vertices", n);
    kn_status status = kn_net_set_variable(scan, &net, 0, (int)n, 2, false);
    if (status == KN_OK && !(net.coef = kn_alloc(scan->ctx, n, 3 * sizeof *net.coef))) status = KN_ENOMEM;
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        net.knots[0][i + 1] = (double)i;
        for (size_t c = 0; c < 3; c++) net.coef[c * n + i] = xyz[3 * i + c];
    }
    if (status == KN_OK) {
        net.knots[0][0] = 0.0, net.knots[0][n + 1] = (double)n - 1.0;
        status = kn_net_spline(scan, &spline, &net, scan->line);
    }
    if (status == KN_OK) status = kn_model_append(scan->ctx, model, &spline);
    kn_spline_clear(scan->ctx, &spline);
    kn_net_clear(scan->ctx, &net);
    return status;
}

static kn_status parse_polyline(kn_scan *scan, kn_model *model)
{
    double *xyz = NULL;
    size_t n = 0;
    kn_status status = parse_vertices(scan, &xyz, &n);
    if (status == KN_OK) status = add_polyline(scan, model, xyz, n);
    kn_free(scan->ctx, xyz);
    return status;
}

// ---- objects ----

// What holds geometry that is not read: better said than left out.
static bool is_refused(const kn_scan *scan)
{
    static const char *const words[] = {"TRIMSRF", "TRISRF", "MULTIVAR", "MODEL", "VMODEL", "INSTANCE", "POLYSTRIP"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (is_word(scan, words[i])) return true;
    return false;
}

// The group whose bracket and keyword were read; *depth counts the objects that are open.
static kn_status parse_group(kn_scan *scan, kn_model *model, size_t *depth)
{
    static const char *const splines[] = {"CURVE", "SURFACE", "TRIVAR"};
    scan->object = model->nsplines + 1;
    for (int i = 0; i < 3; i++)
        if (is_word(scan, splines[i])) return parse_spline(scan, model, i + 1);
    if (is_word(scan, "POLYGON")) return parse_polygon(scan, model);
    if (is_word(scan, "POLYLINE")) return parse_polyline(scan, model);
    if (is_refused(scan)) return kn_scan_fail_word(scan, "object", "of a kind that is not read");
    if (is_word(scan, "OBJECT")) {
        ++*depth;
        return KN_OK;
    }
    if (is_word(scan, "]")) return KN_OK; // an empty group
    if (is_word(scan, "[")) return kn_scan_fail_word(scan, "keyword", "missing");
    return skip_group(scan); // an attribute, a number, a matrix ..
}

static kn_status parse_objects(kn_scan *scan, kn_model *model)
{
    size_t depth = 0;
    kn_status status = KN_OK;
    while (status == KN_OK && kn_scan_word(scan)) {
        if (is_word(scan, "[")) {
            if (!kn_scan_word(scan)) return fail_end(scan, "keyword");
            status = parse_group(scan, model, &depth);
        } else if (is_word(scan, "]")) {
            if (depth == 0) return kn_scan_fail_word(scan, "bracket", "not opened");
            depth--;
        } // else a name, or a comment
    }
    if (status != KN_OK) return status;
    if (depth > 0) return fail_end(scan, "']'");
    if (model->nsplines == 0 && model->mesh.ntriangles == 0)
        return kn_scan_fail(scan, KN_EPARSE, "no curve, surface, trivariate or polygon");
    return KN_OK;
}

kn_status kn_parse_itd(kn_ctx *ctx, kn_model *out, const char *name, const char *text, size_t bytes)
{
    kn_scan scan = kn_scan_start(ctx, name, text, bytes);
    scan.kind = "object";
    scan.brackets = true;
    kn_model model = {0};
    kn_status status = parse_objects(&scan, &model);
    if (status == KN_OK) kn_model_move(ctx, out, &model);
    kn_model_clear(ctx, &model);
    return status;
}

kn_status kn_read_itd(kn_ctx *ctx, kn_model *out, const char *path)
{
    return kn_read_with(ctx, out, path, kn_parse_itd);
}
