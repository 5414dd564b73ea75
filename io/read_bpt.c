// SPDX-License-Identifier: Apache-2.0
// Reads Bezier patch files, the form in which the Utah teapot was published.
#include <knurl/io.h>

#include "io/model.h"
#include "io/text_scan.h"
#include "kernel/context.h"

// One patch "m n" and its (m+1)(n+1) points, u fastest in the file, v fastest in the spline.
static kn_status parse_patch(kn_scan *scan, kn_spline *out)
{
    kn_bezier patch = {0};
    int degree[2] = {0, 0};
    scan->item = 0;
    kn_status status = kn_scan_int(scan, &degree[0], "degree in u", 1, KN_MAX_DEGREE);
    if (status == KN_OK) status = kn_scan_int(scan, &degree[1], "degree in v", 1, KN_MAX_DEGREE);
    int nu = degree[0] + 1, nv = degree[1] + 1, line = scan->line;
    if (status == KN_OK) status = kn_scan_room(scan, 3.0 * nu * nv, "coordinates");
    if (status == KN_OK) status = kn_bezier_init(scan->ctx, &patch, 2, 3, false, degree);
    for (int k = 0; k < nu * nv && status == KN_OK; k++) {
        int to = (k % nu) * nv + k / nu;
        scan->item = (size_t)k + 1;
        for (int c = 0; c < 3 && status == KN_OK; c++)
            status = kn_scan_real(scan, &patch.coef[c * nu * nv + to], "control point");
    }
    if (status == KN_OK) status = kn_spline_of_bezier(scan->ctx, out, &patch);
    if (status == KN_OK && kn_spline_no_area(out)) {
        scan->line = line;
        status = kn_scan_fail(scan, KN_EPARSE, "patch %d has zero area", scan->object);
    }
    kn_bezier_clear(scan->ctx, &patch);
    return status;
}

static kn_status parse_patches(kn_scan *scan, kn_model *model)
{
    int count = 0;
    kn_status status = kn_scan_int(scan, &count, "number of patches", 1, 2147483647);
    double left = (double)(scan->end - scan->at); // each patch has two degrees at least, and each ends a word
    if (status == KN_OK && 4.0 * count > left + 1.0)
        status = kn_scan_fail(scan, KN_EPARSE, "%d patches expected, but only %.0f bytes follow", count, left);
    for (int i = 0; i < count && status == KN_OK; i++) {
        kn_spline spline = {0};
        scan->object = i + 1;
        status = parse_patch(scan, &spline);
        if (status == KN_OK) status = kn_model_append(scan->ctx, model, &spline);
        kn_spline_clear(scan->ctx, &spline);
    }
    if (status == KN_OK && kn_scan_word(scan))
        status = kn_scan_fail_word(scan, "text after the last patch", "not expected");
    return status;
}

kn_status kn_parse_bpt(kn_ctx *ctx, kn_model *out, const char *name, const char *text, size_t bytes)
{
    kn_scan scan = kn_scan_start(ctx, name, text, bytes);
    scan.kind = "patch";
    kn_model model = {0};
    kn_status status = parse_patches(&scan, &model);
    if (status == KN_OK) kn_model_move(ctx, out, &model);
    kn_model_clear(ctx, &model);
    return status;
}

kn_status kn_read_bpt(kn_ctx *ctx, kn_model *out, const char *path)
{
    return kn_read_with(ctx, out, path, kn_parse_bpt);
}
