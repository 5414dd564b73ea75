// SPDX-License-Identifier: Apache-2.0
// What a camera sees of a box, and whether a cell is hidden by the base around it.
//
// Hidden: T = S + w n, n the unit normal, so that grad w = n: on the way from a point q of the tiles towards the
// camera, in direction d, w falls at the rate |n . d| >= c as long as the way stays over cells whose normals have
// n . d <= -c < 0. From the greatest height to the least it is then not longer than L = (w1 - w0) / c. If the way
// cannot leave the cells around before that, because boxes of the cells of the ring at distance two do not meet the
// box of all such ways, it runs down through the base. (Not so through covering tiles, which take its place: from one
// of them down nothing need be in the way.)
#include "job/placement.h"

#include <math.h>

static double row(const kn_job_camera *c, int k, const double p[3])
{
    const double *m = c->view.matrix + 4 * k;
    return m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
}

static void corner(double p[3], const double lo[3], const double hi[3], int k)
{
    for (int c = 0; c < 3; c++) p[c] = (k >> c) & 1 ? hi[c] : lo[c];
}

// The least of w + sign * x over a box, x row k of clip coordinates: affine, so at a corner; less its rounding.
static double most_inside(const kn_job_camera *camera, int k, double sign, const double lo[3], const double hi[3])
{
    double most = -INFINITY, size = 0.0;
    for (int i = 0; i < 8; i++) {
        double p[3];
        corner(p, lo, hi, i);
        most = fmax(most, row(camera, 3, p) + sign * row(camera, k, p));
        for (int c = 0; c < 3; c++)
            size = fmax(size,
                        fabs(p[c]) * fmax(fabs(camera->view.matrix[4 * k + c]), fabs(camera->view.matrix[12 + c])));
    }
    size += fabs(camera->view.matrix[4 * k + 3]) + fabs(camera->view.matrix[15]);
    return most + 32.0 * 0x1p-53 * size;
}

bool kn_job_out_of_view(const kn_job_camera *camera, const double lo[3], const double hi[3])
{
    for (int c = 0; c < 3; c++)
        if (!isfinite(lo[c]) || !isfinite(hi[c])) return false;
    for (int k = 0; k < 3; k++)
        if (most_inside(camera, k, 1.0, lo, hi) < 0.0 || most_inside(camera, k, -1.0, lo, hi) < 0.0) return true;
    return false;
}

double kn_job_pixels(const kn_job_camera *camera, const double lo[3], const double hi[3])
{
    double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
    for (int i = 0; i < 8; i++) {
        double p[3];
        corner(p, lo, hi, i);
        double w = row(camera, 3, p);
        if (!(w > 0.0) || isinf(w)) return INFINITY;
        for (int k = 0; k < 2; k++) {
            double x = row(camera, k, p) / w;
            least[k] = fmin(least[k], x), most[k] = fmax(most[k], x);
        }
    }
    return fmax(0.5 * camera->view.pixels[0] * (most[0] - least[0]),
                0.5 * camera->view.pixels[1] * (most[1] - least[1]));
}

// |d(x/w)| <= (|row x| + |x/w| |row w|) / w, and |x/w| <= 1 in the picture.
double kn_job_pixel_scale(const kn_job_camera *camera, const double lo[3], const double hi[3])
{
    double least = INFINITY, length[4] = {0.0}, scale = 0.0;
    for (int i = 0; i < 8; i++) {
        double p[3];
        corner(p, lo, hi, i);
        least = fmin(least, row(camera, 3, p));
    }
    if (!(least > 0.0)) return INFINITY;
    for (int k = 0; k < 4; k++)
        for (int c = 0; c < 3; c++) length[k] = hypot(length[k], camera->view.matrix[4 * k + c]);
    for (int k = 0; k < 2; k++) scale = fmax(scale, 0.5 * camera->view.pixels[k] * (length[k] + length[3]) / least);
    return scale;
}

// The point that rows x, y and w of the matrix send to 0: minors of them.
kn_status kn_job_camera_init(kn_ctx *ctx, kn_job_camera *out, const kn_job_view *view)
{
    kn_job_camera c = {.view = *view};
    for (int i = 0; i < 16; i++)
        if (!isfinite(view->matrix[i]))
            return kn_fail(ctx, KN_EDOMAIN, "job: a view with the number %g", view->matrix[i]);
    if (view->pixels[0] < 1 || view->pixels[1] < 1)
        return kn_fail(ctx, KN_EDOMAIN, "job: a view of %d by %d pixels", view->pixels[0], view->pixels[1]);
    if (!(view->least_pixels >= 0.0) || !(view->chord_pixels >= 0.0))
        return kn_fail(ctx, KN_EDOMAIN, "job: a view with cells of %g pixels, chords of %g", view->least_pixels,
                       view->chord_pixels);
    if (c.view.chord_pixels == 0.0) c.view.chord_pixels = 0.5;
    const double *a = view->matrix, *b = view->matrix + 4, *w = view->matrix + 12;
    double length = 0.0, sign = 1.0, size = 0.0;
    for (int k = 0; k < 4; k++, sign = -sign) {
        int i[3], n = 0;
        for (int j = 0; j < 4; j++)
            if (j != k) i[n++] = j;
        c.eye[k] = sign * (a[i[0]] * (b[i[1]] * w[i[2]] - b[i[2]] * w[i[1]]) -
                           a[i[1]] * (b[i[0]] * w[i[2]] - b[i[2]] * w[i[0]]) +
                           a[i[2]] * (b[i[0]] * w[i[1]] - b[i[1]] * w[i[0]]));
        size = fmax(size, fabs(c.eye[k]));
    }
    if (!(size > 0.0)) return kn_fail(ctx, KN_EDOMAIN, "job: a view whose matrix is singular");
    if (fabs(c.eye[3]) > 1e-12 * size) {
        for (int k = 0; k < 3; k++) c.eye[k] /= c.eye[3];
        c.eye[3] = 1.0;
    } else { // depth grows away from the camera
        const double *z = view->matrix + 8;
        for (int k = 0; k < 3; k++) length = hypot(length, c.eye[k]);
        if (z[0] * c.eye[0] + z[1] * c.eye[1] + z[2] * c.eye[2] > 0.0) length = -length;
        for (int k = 0; k < 3; k++) c.eye[k] /= length;
        c.eye[3] = 0.0;
    }
    *out = c;
    return KN_OK;
}

// ---- hidden ----

// The direction towards the camera from the middle of a box, how far it may be off elsewhere in the box, and the least
// distance to the camera.
static bool direction(double d[3], double *off, double *distance, const kn_job_camera *camera, const double lo[3],
                      const double hi[3])
{
    double radius = 0.0, length = 0.0;
    *off = 0.0, *distance = INFINITY;
    for (int c = 0; c < 3; c++) d[c] = camera->eye[c];
    if (camera->eye[3] == 0.0) return true;
    for (int c = 0; c < 3; c++) {
        d[c] -= 0.5 * (lo[c] + hi[c]);
        radius = hypot(radius, 0.5 * (hi[c] - lo[c]));
        length = hypot(length, d[c]);
    }
    *distance = length - radius;
    if (!(*distance > 0.0)) return false;
    *off = radius / *distance; // |a/|a| - b/|b|| <= |a - b| / min(|a|, |b|)
    for (int c = 0; c < 3; c++) d[c] /= length;
    return true;
}

static bool meet(const double alo[3], const double ahi[3], const double blo[3], const double bhi[3])
{
    for (int c = 0; c < 3; c++)
        if (alo[c] > bhi[c] || blo[c] > ahi[c]) return false;
    return true;
}

// The cell at a distance from another one of its surface; false: there is none.
static bool neighbour(int out[2], const kn_job_surface *s, const int cell[2], int i, int j)
{
    const int step[2] = {i, j};
    for (int d = 0; d < 2; d++) {
        int n = s->cells[d];
        out[d] = cell[d] + step[d];
        if (s->closed[d] && n >= 5) out[d] = (out[d] + n) % n;
        if (out[d] < 0 || out[d] >= n) return false;
    }
    return true;
}

kn_status kn_job_is_hidden(kn_ctx *ctx, bool *hidden, const kn_job_bounds *bounds, const kn_job_camera *camera,
                           int surface, const int cell[2], const kn_job_extents *extents, const double lo[3],
                           const double hi[3])
{
    static const double margin = 1e-3; // for grad w, which n, fitted, is but nearly
    const kn_job_surface *s = &bounds->job->surfaces[surface];
    double d[3], off, distance, facing = -1.0, w[2] = {INFINITY, -INFINITY};
    *hidden = false;
    if (!direction(d, &off, &distance, camera, lo, hi)) return KN_OK;
    for (int k = 0; k < extents->count; k++) {
        const kn_job_extent *e = &extents->list[k];
        w[0] = fmin(w[0], e->w[0]), w[1] = fmax(w[1], e->w[1]);
        if (e->offset[0] < -1 || e->offset[0] > 1 || e->offset[1] < -1 || e->offset[1] > 1) return KN_OK;
        for (int v = 0; v < 2; v++)
            if (e->lo[v] < -1.0 || e->hi[v] > 2.0) return KN_OK;
    }
    if (bounds->job->tile.covering || w[0] < 0.0) return KN_OK; // below the base, which is not looked through
    w[0] = 0.0;
    int at[2];
    for (int k = 0; k < 25; k++) {
        if (!neighbour(at, s, cell, k / 5 - 2, k % 5 - 2)) return KN_OK;
        facing = fmax(facing, kn_job_bounds_facing(bounds, surface, at, d));
        if (facing + off + margin >= -0.05) return KN_OK;
    }
    double length = (w[1] - w[0]) / -(facing + off + margin), from[3], to[3];
    if (length >= distance) return KN_OK;
    for (int c = 0; c < 3; c++) {
        from[c] = fmin(lo[c], lo[c] + length * (d[c] - off));
        to[c] = fmax(hi[c], hi[c] + length * (d[c] + off));
    }
    for (int k = 0; k < 25; k++) {
        int i = k / 5 - 2, j = k % 5 - 2;
        if (i > -2 && i < 2 && j > -2 && j < 2) continue;
        if (!neighbour(at, s, cell, i, j)) return KN_OK;
        const kn_job_place place = {.surface = surface, .cell = {at[0], at[1]}};
        const kn_job_extent whole = {.hi = {1.0, 1.0}, .w = {w[0], w[1]}};
        double ring_lo[3], ring_hi[3];
        kn_status status = kn_job_bounds_box(ctx, ring_lo, ring_hi, bounds, &place, &whole);
        if (status != KN_OK) return status;
        if (meet(from, to, ring_lo, ring_hi)) return KN_OK;
    }
    *hidden = true;
    return KN_OK;
}
