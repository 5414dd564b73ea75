// SPDX-License-Identifier: Apache-2.0
// What is in front of a box, pixel by pixel and then in a pyramid of them: N. Greene, M. Kass, G. Miller,
// Hierarchical Z-buffer visibility, SIGGRAPH 1993.
//
// A pixel of the buffer holds a depth before which every ray through any point of it has certainly been stopped,
// INFINITY where none is known. Depth grows along every ray: clip w, which is 0 at the eye, or the way against the
// direction towards a camera far away. A pixel of the pyramid holds the greatest of four of the level below.
//
// A disc of a surface stops every ray around whose point x in the picture the image of its border winds: that
// winding number is the degree at x of the map from the disc to the picture, and where it is not 0 x has a
// preimage. Of the border a polygon is known, and how far from each side the arc beside it may be: all that winds
// as often around x when x is farther away than that.
#include "job/depth.h"

#include <math.h>

// Pixels: for what rounding does to coordinates up to FAR_AWAY, and for ends of arcs that should meet.
static const double slack = 2.5e-3;
static const double far_away = 1e6;

static double row(const double *m, const double p[3])
{
    return m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
}

// How far row(p) may be off where p is off by `radius`, and rounding counts.
static double row_error(const double *m, const double p[3], double radius)
{
    double size = fabs(m[0] * p[0]) + fabs(m[1] * p[1]) + fabs(m[2] * p[2]) + fabs(m[3]);
    return hypot(m[0], hypot(m[1], m[2])) * radius * (1.0 + 0x1p-40) + 16.0 * 0x1p-53 * size;
}

bool kn_job_depth_point(kn_job_dot *out, const kn_job_depth *d, const double p[3], double radius)
{
    const double *m = d->camera->view.matrix;
    const double *eye = d->camera->eye;
    double w = row(m + 12, p), ew = row_error(m + 12, p, radius);
    double z = row(m + 8, p), ez = row_error(m + 8, p, radius);
    if (!(w - ew > 0.0) || !(w + z >= ew + ez)) return false; // beside the eye, or too near to be in the picture
    for (int k = 0; k < 2; k++) {
        double x = row(m + 4 * k, p), ex = row_error(m + 4 * k, p, radius), half = 0.5 * d->size[k];
        out->at[k] = half * (x / w + 1.0); // |x'/w' - x/w| <= (|x' - x| + |x/w| |w' - w|) / w'
        out->off[k] = half * (ex + fabs(x / w) * ew) / (w - ew);
        if (!(fabs(out->at[k]) < far_away) || !(out->off[k] < far_away)) return false;
    }
    const double away[4] = {-eye[0], -eye[1], -eye[2], 0.0}, *depth = eye[3] == 0.0 ? away : m + 12;
    double middle = row(depth, p), off = row_error(depth, p, radius);
    out->near = middle - off, out->far = middle + off;
    return true;
}

// ---- memory ----

void kn_job_depth_clear(kn_ctx *ctx, kn_job_depth *d)
{
    for (int l = 0; l < KN_JOB_DEPTH_LEVELS; l++) kn_free(ctx, d->level[l]);
    *d = (kn_job_depth){0};
}

kn_status kn_job_depth_init(kn_ctx *ctx, kn_job_depth *out, const kn_job_camera *camera)
{
    kn_job_depth d = {.camera = camera};
    const int *pixels = camera->view.pixels;
    double most = pixels[0] > pixels[1] ? pixels[0] : pixels[1], scale = fmin(1.0, KN_JOB_DEPTH_PIXELS / most);
    int size[2];
    for (int k = 0; k < 2; k++) d.size[k] = size[k] = (int)fmax(1.0, floor(scale * pixels[k]));
    while (d.nlevels < KN_JOB_DEPTH_LEVELS) {
        size_t n = (size_t)size[0] * (size_t)size[1];
        double *level = kn_alloc(ctx, n, sizeof *level);
        if (!level) {
            kn_job_depth_clear(ctx, &d);
            return KN_ENOMEM;
        }
        for (size_t i = 0; i < n; i++) level[i] = INFINITY;
        d.level[d.nlevels] = level;
        d.wide[d.nlevels] = size[0], d.tall[d.nlevels++] = size[1];
        if (size[0] == 1 && size[1] == 1) break;
        for (int k = 0; k < 2; k++) size[k] = (size[k] + 1) / 2;
    }
    *out = d;
    return KN_OK;
}

// ---- discs ----

static double square(double x)
{
    return x * x;
}

// Whether x is farther from the segment than its arc may be, a pixel around x included.
static bool is_apart(const kn_job_arc *s, double x, double y)
{
    double dx = s->to[0] - s->from[0], dy = s->to[1] - s->from[1], px = x - s->from[0], py = y - s->from[1];
    double length = dx * dx + dy * dy, t = length > 0.0 ? fmin(fmax((px * dx + py * dy) / length, 0.0), 1.0) : 0.0;
    return square(px - t * dx) + square(py - t * dy) > square(s->off + slack + 0.70711);
}

static int winding(const kn_job_arc *arcs, int n, double x, double y)
{
    int sum = 0;
    for (int i = 0; i < n; i++) {
        const double *a = arcs[i].from, *b = arcs[i].to;
        if ((a[1] <= y) == (b[1] <= y)) continue;
        double side = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
        if (a[1] <= y ? side > 0.0 : side < 0.0) sum += a[1] <= y ? 1 : -1;
    }
    return sum;
}

static bool stops(const kn_job_arc *arcs, int n, double x, double y)
{
    if (winding(arcs, n, x, y) == 0) return false;
    for (int i = 0; i < n; i++)
        if (!is_apart(&arcs[i], x, y)) return false;
    return true;
}

void kn_job_depth_disc(kn_job_depth *d, const kn_job_arc *arcs, int n, double depth)
{
    int lo[2], hi[2];
    for (int k = 0; k < 2; k++) {
        double least = INFINITY, most = -INFINITY;
        for (int i = 0; i < n; i++) least = fmin(least, arcs[i].from[k]), most = fmax(most, arcs[i].from[k]);
        lo[k] = (int)fmax(0.0, floor(least));
        hi[k] = (int)fmin(d->size[k] - 1.0, floor(most));
    }
    for (int y = lo[1]; y <= hi[1]; y++)
        for (int x = lo[0]; x <= hi[0]; x++) {
            double *at = &d->level[0][(size_t)y * (size_t)d->size[0] + (size_t)x];
            if (depth < *at && stops(arcs, n, x + 0.5, y + 0.5)) *at = depth;
        }
}

void kn_job_depth_finish(kn_job_depth *d)
{
    for (int l = 1; l < d->nlevels; l++)
        for (int y = 0; y < d->tall[l]; y++)
            for (int x = 0; x < d->wide[l]; x++) {
                double most = -INFINITY;
                for (int k = 0; k < 4; k++) {
                    int i = 2 * x + (k & 1), j = 2 * y + (k >> 1);
                    if (i >= d->wide[l - 1] || j >= d->tall[l - 1]) continue;
                    most = fmax(most, d->level[l - 1][(size_t)j * (size_t)d->wide[l - 1] + (size_t)i]);
                }
                d->level[l][(size_t)y * (size_t)d->wide[l] + (size_t)x] = most;
            }
}

// ---- boxes ----

typedef struct question {
    const kn_job_depth *d;
    int lo[2], hi[2]; // pixels
    double near;
} question;

// Whether all pixels in question within one of a level end before `near`.
static bool ends_before(const question *q, int level, int x, int y)
{
    const kn_job_depth *d = q->d;
    if (d->level[level][(size_t)y * (size_t)d->wide[level] + (size_t)x] < q->near) return true;
    if (level == 0) return false;
    level--;
    for (int k = 0; k < 4; k++) {
        int at[2] = {2 * x + (k & 1), 2 * y + (k >> 1)};
        if (at[0] < q->lo[0] >> level || at[0] > q->hi[0] >> level) continue;
        if (at[1] < q->lo[1] >> level || at[1] > q->hi[1] >> level) continue;
        if (!ends_before(q, level, at[0], at[1])) return false;
    }
    return true;
}

bool kn_job_depth_hides(const kn_job_depth *d, const double lo[3], const double hi[3])
{
    double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
    question q = {.d = d, .near = INFINITY};
    for (int i = 0; i < 8; i++) {
        double p[3];
        kn_job_dot dot;
        for (int c = 0; c < 3; c++) p[c] = (i >> c) & 1 ? hi[c] : lo[c];
        if (!kn_job_depth_point(&dot, d, p, 0.0)) return false;
        for (int k = 0; k < 2; k++) {
            least[k] = fmin(least[k], dot.at[k] - dot.off[k] - slack);
            most[k] = fmax(most[k], dot.at[k] + dot.off[k] + slack);
        }
        q.near = fmin(q.near, dot.near);
    }
    for (int k = 0; k < 2; k++) {
        if (most[k] < 0.0 || least[k] >= d->size[k]) return false; // out of the picture
        q.lo[k] = (int)fmax(0.0, floor(least[k]));
        q.hi[k] = (int)fmin(d->size[k] - 1.0, floor(most[k]));
    }
    return ends_before(&q, d->nlevels - 1, 0, 0);
}
