// SPDX-License-Identifier: Apache-2.0
// The contours of a triangle mesh. A point on an edge depends on its two ends alone, so that triangles meet bit for bit.
#include "slice/internal.h"

#include "bezier/norm_bound.h"

#include <math.h>
#include <string.h>

// Where the edge from a to b, or back, goes through the plane.
static void cross(double out[2], const double *a, const double *b, double z)
{
    bool swap = a[2] != b[2] ? a[2] > b[2] : a[0] != b[0] ? a[0] > b[0] : a[1] > b[1];
    const double *p = swap ? b : a, *q = swap ? a : b;
    double s = (z - p[2]) / (q[2] - p[2]);
    for (int c = 0; c < 2; c++) out[c] = s <= 0.5 ? p[c] + s * (q[c] - p[c]) : q[c] - (1.0 - s) * (q[c] - p[c]);
}

// Material to the left: with z up and the outside in front, the contour runs so that what is above lies left.
static kn_status cut(kn_ctx *ctx, kn_slice_lines *out, size_t plane, double z, const kn_patch_id *id,
                     const double *const corner[3])
{
    double from[2] = {0}, to[2] = {0};
    for (int k = 0; k < 3; k++) {
        const double *a = corner[k], *b = corner[(k + 1) % 3];
        bool above_a = a[2] >= z, above_b = b[2] >= z;
        if (above_a == above_b) continue;
        cross(above_a ? from : to, a, b, z);
    }
    kn_status status = kn_slice_begin_line(ctx, out, plane, id);
    if (status == KN_OK) status = kn_slice_add_point(ctx, out, from[0], from[1]);
    if (status == KN_OK) status = kn_slice_add_point(ctx, out, to[0], to[1]);
    return status;
}

kn_status kn_slice_mesh(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *w, const kn_patch_id *id,
                        const kn_mesh *mesh)
{
    kn_status status = KN_OK;
    double largest = 0.0; // of x and y: s has five roundings, s (q - p) two more and the sum one
    for (size_t i = 0; i < mesh->nvertices; i++)
        largest = fmax(largest, fmax(fabs(mesh->position[3 * i]), fabs(mesh->position[3 * i + 1])));
    double rounding = kn_round_up(1.5 * kn_gamma_up(16.0) * largest);
    for (size_t i = 0; status == KN_OK && i < mesh->ntriangles; i++) {
        const double *corner[3];
        for (int k = 0; k < 3; k++) corner[k] = mesh->position + 3 * (size_t)mesh->triangle[3 * i + (size_t)k];
        double lo = fmin(corner[0][2], fmin(corner[1][2], corner[2][2]));
        double hi = fmax(corner[0][2], fmax(corner[1][2], corner[2][2]));
        size_t from, to;
        kn_slice_planes(w, lo, hi, &from, &to);
        for (size_t plane = from; status == KN_OK && plane < to; plane++) {
            status = cut(ctx, out, plane, kn_slice_height(&w->options, plane), id, corner);
            if (status == KN_OK) status = kn_slice_add_note(ctx, out, plane, 0, rounding);
        }
    }
    return status;
}
