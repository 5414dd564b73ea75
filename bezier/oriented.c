// SPDX-License-Identifier: Apache-2.0
// Small oriented boxes around points: a few systems of axes are tried, and each box is made to hold every point.
#include "bezier/bounds.h"
#include "kernel/bounds.h"

#include <math.h>
#include <string.h>

typedef struct cloud {
    const double *points; // dim arrays of n numbers
    int dim;
    size_t n;
    double relative, lo[3], hi[3];
} cloud;

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void get_point(double *x, const cloud *c, size_t k)
{
    for (int i = 0; i < 3; i++) x[i] = i < c->dim ? c->points[(size_t)i * c->n + k] : 0.0;
}

// ---- axes ----

// Jacobi's rotation that makes m[p][q] zero, applied to the axes too.
static void rotate(double m[3][3], double axis[3][3], int p, int q)
{
    if (m[p][q] == 0.0) return;
    double theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
    double t = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(theta * theta + 1.0)), c = 1.0 / sqrt(t * t + 1.0);
    for (int i = 0; i < 3; i++) {
        double x = m[i][p], y = m[i][q];
        m[i][p] = c * (x - t * y), m[i][q] = c * (y + t * x);
    }
    for (int i = 0; i < 3; i++) {
        double x = m[p][i], y = m[q][i], a = axis[p][i], b = axis[q][i];
        m[p][i] = c * (x - t * y), m[q][i] = c * (y + t * x);
        axis[p][i] = c * (a - t * b), axis[q][i] = c * (b + t * a);
    }
}

// The principal axes of the points, the longest first; scaled by a power of two against overflow.
static void principal_axes(double axis[3][3], const cloud *c)
{
    double m[3][3] = {{0}}, mid[3], big = 0.0, x[3];
    for (int i = 0; i < 3; i++) {
        mid[i] = 0.5 * c->lo[i] + 0.5 * c->hi[i];
        big = fmax(big, c->hi[i] - mid[i]);
        for (int j = 0; j < 3; j++) axis[i][j] = i == j;
    }
    int e = big > 0.0 ? ilogb(big) : 0;
    double mean[3] = {0}, n = (double)c->n;
    for (size_t k = 0; k < c->n; k++) {
        get_point(x, c, k);
        for (int i = 0; i < 3; i++) x[i] = scalbn(x[i] - mid[i], -e);
        for (int i = 0; i < 3; i++) {
            mean[i] += x[i] / n;
            for (int j = 0; j < 3; j++) m[i][j] += x[i] * x[j] / n;
        }
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) m[i][j] -= mean[i] * mean[j];
    for (int sweep = 0; sweep < 8; sweep++)
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++) rotate(m, axis, p, q);
    for (int i = 0; i < 2; i++)
        for (int j = 2; j > i; j--)
            if (m[j][j] > m[j - 1][j - 1]) {
                double t = m[j][j], row[3];
                m[j][j] = m[j - 1][j - 1], m[j - 1][j - 1] = t;
                memcpy(row, axis[j], sizeof row);
                memcpy(axis[j], axis[j - 1], sizeof row);
                memcpy(axis[j - 1], row, sizeof row);
            }
}

// The next axis along v, less its part along those that there are; false when too little is left.
static bool add_axis(double axis[3][3], int have, const double *v)
{
    double x[3] = {v[0], v[1], v[2]}, big = fmax(fabs(x[0]), fmax(fabs(x[1]), fabs(x[2])));
    if (!(big > 0.0 && big < INFINITY)) return false;
    int e = ilogb(big);
    for (int i = 0; i < 3; i++) x[i] = scalbn(x[i], -e);
    for (int pass = 0; pass < 2; pass++) { // the second one takes what the first rounded
        for (int k = 0; k < have; k++) {
            double along = dot(x, axis[k]);
            for (int i = 0; i < 3; i++) x[i] -= along * axis[k][i];
        }
        double length = sqrt(dot(x, x));
        if (!(length > 1e-5)) return false;
        for (int i = 0; i < 3; i++) x[i] /= length;
    }
    memcpy(axis[have], x, sizeof x);
    return true;
}

// ---- the box that holds all points ----

// With A the axes as columns and A^T A = 1 + E, a point is center + A s for s = (1 + E)^-1 y, y = A^T (x - center).
// So |s_i| <= |y_i| + 4 e max |y|, where no element of E exceeds e <= 1e-3. y has the error
// 5 u sum_j |x_j - center_j| by a difference, products with |a| < 1.01 and sums, and that of the points.
static bool hold_all(kn_oriented_box *box, const cloud *c)
{
    double most[3] = {0}, away[3] = {0}, size[3] = {0}, x[3], e = 0.0, error = 0.0, top = 0.0;
    for (size_t k = 0; k < c->n; k++) {
        get_point(x, c, k);
        for (int i = 0; i < 3; i++) {
            size[i] = fmax(size[i], fabs(x[i]));
            x[i] -= box->center[i];
            away[i] = fmax(away[i], fabs(x[i]));
        }
        for (int i = 0; i < 3; i++) most[i] = fmax(most[i], fabs(dot(box->axis[i], x)));
    }
    for (int i = 0; i < 3; i++) {
        error += 0x1.8p-51 * away[i] + 1.1 * c->relative * size[i];
        for (int j = 0; j <= i; j++) e = fmax(e, fabs(dot(box->axis[i], box->axis[j]) - (i == j)) + 0x1p-50);
    }
    if (error > 0.0) error += 0x1p-1060; // underflow in products
    for (int i = 0; i < 3; i++) top = fmax(top, most[i] + error);
    for (int i = 0; i < c->dim; i++) box->half[i] = (most[i] + error + 4.0 * e * top) * (1.0 + 0x1p-50);
    for (int i = 0; i < 3; i++)
        if (!(box->half[i] < INFINITY) || !isfinite(box->center[i])) return false;
    return e < 1e-3;
}

// The center is put in the middle of the points' extent along each axis.
static bool enclose(kn_oriented_box *box, const cloud *c)
{
    double least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY}, mid[3], x[3];
    for (int i = 0; i < 3; i++) mid[i] = 0.5 * c->lo[i] + 0.5 * c->hi[i];
    for (size_t k = 0; k < c->n; k++) {
        get_point(x, c, k);
        for (int i = 0; i < 3; i++) x[i] -= mid[i];
        for (int i = 0; i < 3; i++) {
            double y = dot(box->axis[i], x);
            least[i] = fmin(least[i], y);
            most[i] = fmax(most[i], y);
        }
    }
    for (int i = 0; i < 3; i++) {
        box->center[i] = mid[i];
        for (int j = 0; j < 3; j++) box->center[i] += (0.5 * least[j] + 0.5 * most[j]) * box->axis[j][i];
    }
    return hold_all(box, c);
}

static double surface(const kn_oriented_box *box, int e)
{
    double h[3];
    for (int i = 0; i < 3; i++) h[i] = scalbn(box->half[i], -e);
    return h[0] * h[1] + h[1] * h[2] + h[2] * h[0];
}

// Smaller: by the surface, which still tells flat boxes apart, then by the lengths. Scaled, so that squares neither
// overflow nor underflow where it matters.
static bool is_smaller(const kn_oriented_box *a, const kn_oriented_box *b)
{
    double x = a->half[0] + a->half[1] + a->half[2], y = b->half[0] + b->half[1] + b->half[2];
    if (!(x > 0.0 && y < INFINITY)) return x < y;
    double s = surface(a, ilogb(x)), t = surface(b, ilogb(x));
    return s != t ? s < t : x < y;
}

// Takes the first of the directions for which the axes are independent, and keeps the box if it is the smaller one.
static void try_axes(kn_oriented_box *out, const cloud *c, double (*direction)[3], int n)
{
    static const double unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    kn_oriented_box box = {.center = {0}};
    int have = 0;
    for (int i = 0; i < n && have < c->dim; i++) {
        double v[3] = {direction[i][0], direction[i][1], c->dim < 3 ? 0.0 : direction[i][2]};
        have += add_axis(box.axis, have, v);
    }
    for (int i = 0; i < 3; i++)
        if (i < c->dim && have < c->dim) have += add_axis(box.axis, have, unit[i]);
    if (c->dim < 3) memcpy(box.axis[2], unit[2], sizeof unit[2]);
    if (have == c->dim && enclose(&box, c) && is_smaller(&box, out)) *out = box;
}

void kn_oriented_box_fit(kn_oriented_box *out, const double *points, int dim, size_t n, double relative,
                         double (*chords)[3], int nchords)
{
    enum { MOST = KN_MAX_VARS + 4 };
    cloud c = {.points = points, .dim = dim, .n = n, .relative = relative};
    double principal[3][3], order[MOST][3];
    *out = (kn_oriented_box){.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .half = {INFINITY, INFINITY, INFINITY}};
    for (int i = 0; i < dim; i++) kn_hull_range(&c.lo[i], &c.hi[i], n, points + (size_t)i * n, NULL, NULL, NULL);
    try_axes(out, &c, NULL, 0); // the axes of coordinates
    if (!(out->half[0] < INFINITY)) return;
    principal_axes(principal, &c);
    try_axes(out, &c, principal, 3);
    if (nchords > KN_MAX_VARS) nchords = KN_MAX_VARS;
    for (int first = 0; first < nchords && first < 2; first++) { // along a chord
        memcpy(order[0], chords[first], sizeof order[0]);
        for (int i = 0; i < nchords; i++) memcpy(order[1 + i], chords[i], sizeof order[0]);
        memcpy(order + 1 + nchords, principal, sizeof principal);
        try_axes(out, &c, order, nchords + 4);
    }
    memcpy(order[0], principal[dim - 1], sizeof order[0]); // the thinnest direction, then along a chord
    for (int i = 0; i < nchords; i++) memcpy(order[1 + i], chords[i], sizeof order[0]);
    memcpy(order + 1 + nchords, principal, sizeof principal);
    try_axes(out, &c, order, nchords + 4);
}

// ---- of control points ----

// The mean direction from the first to the last control points in a variable.
static void chord(double *to, const double *points, int dim, size_t n, size_t outer, int count, size_t inner)
{
    size_t step = (size_t)(count - 1) * inner, stride = (size_t)count * inner;
    for (int c = 0; c < 3; c++) {
        to[c] = 0.0;
        for (size_t o = 0; c < dim && o < outer; o++)
            for (size_t j = 0; j < inner; j++) {
                const double *p = points + (size_t)c * n + o * stride + j;
                to[c] += (p[step] - p[0]) / (double)(outer * inner);
            }
    }
}

kn_status kn_oriented_box_of(kn_ctx *ctx, const char *what, kn_oriented_box *out, const double *coef, int dim,
                             bool rational, int nvars, const int *count)
{
    double chords[KN_MAX_VARS][3] = {{0}};
    size_t n = 1;
    for (int d = 0; d < nvars; d++) n *= (size_t)count[d];
    const double *points = coef, *w = coef + (size_t)dim * n;
    if (dim != 2 && dim != 3) return kn_fail(ctx, KN_EDOMAIN, "%s: of dimension %d", what, dim);
    if (rational && !kn_hull_positive(n, w, NULL))
        return kn_fail(ctx, KN_EDOMAIN, "%s: a weight is not positive", what);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = KN_OK;
    if (rational) {
        double *x = kn_scratch(ctx, (size_t)dim * n, sizeof *x);
        if (!x) status = KN_ENOMEM;
        for (size_t k = 0; k < (size_t)dim * n && x; k++) x[k] = coef[k] / w[k % n];
        points = x;
    }
    size_t outer = 1;
    for (int d = 0; d < nvars && status == KN_OK; d++) {
        chord(chords[d], points, dim, n, outer, count[d], n / outer / (size_t)count[d]);
        outer *= (size_t)count[d];
    }
    if (status == KN_OK) kn_oriented_box_fit(out, points, dim, n, rational ? 0x1p-53 : 0.0, chords, nvars);
    kn_scratch_release(ctx, mark);
    return status;
}
