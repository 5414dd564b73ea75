// SPDX-License-Identifier: Apache-2.0
// Whether a surface's control points leave it no area.
#include "io/model.h"

#include <float.h>
#include <math.h>

// Control point k, projected when the surface is rational; in the plane z is 0.
static void point_at(double p[3], const kn_spline *s, size_t k)
{
    size_t n = kn_spline_count(s);
    int dim = kn_spline_dim(s);
    double weight = s->rational ? s->coef[(size_t)dim * n + k] : 1.0;
    for (int c = 0; c < 3; c++) p[c] = c < dim ? s->coef[(size_t)c * n + k] / weight : 0.0;
}

// The homogeneous control points of row k+1 equal those of row k along variable `var`, for every k: the surface is a
// curve. Projected points would not do: weights that change along var may still sweep out an area.
static bool constant_along(const kn_spline *s, int var)
{
    size_t n = kn_spline_count(s), inner = var == 0 ? (size_t)s->count[1] : 1;
    for (int c = 0; c < s->ncomp; c++)
        for (size_t k = 0; k < n; k++) {
            bool first = var == 0 ? k < inner : k % (size_t)s->count[1] == 0;
            if (!first && s->coef[(size_t)c * n + k] != s->coef[(size_t)c * n + k - inner]) return false;
        }
    return true;
}

// All points on the line through the first one and the one farthest from it, as far as rounding lets one tell:
// with coordinates up to m, rounded to nearest, a difference d is wrong by at most eps m in each component, so that
// a cross product d x e of parallel differences is at most 2 eps m (|d| + |e|) in each component, in 1-norms.
static bool collinear(const kn_spline *s)
{
    size_t n = kn_spline_count(s);
    double first[3], p[3], axis[3] = {0.0, 0.0, 0.0}, reach = 0.0, m = 0.0;
    point_at(first, s, 0);
    for (size_t k = 0; k < n; k++) {
        point_at(p, s, k);
        double d[3] = {p[0] - first[0], p[1] - first[1], p[2] - first[2]};
        double length = fabs(d[0]) + fabs(d[1]) + fabs(d[2]);
        for (int c = 0; c < 3; c++) m = fmax(m, fabs(p[c]));
        if (length <= reach) continue;
        reach = length;
        for (int c = 0; c < 3; c++) axis[c] = d[c];
    }
    for (size_t k = 0; k < n; k++) {
        point_at(p, s, k);
        double d[3] = {p[0] - first[0], p[1] - first[1], p[2] - first[2]};
        double bound = 2.0 * DBL_EPSILON * m * (fabs(d[0]) + fabs(d[1]) + fabs(d[2]) + reach);
        for (int c = 0; c < 3; c++) {
            int a = (c + 1) % 3, b = (c + 2) % 3;
            if (fabs(d[a] * axis[b] - d[b] * axis[a]) > bound) return false;
        }
    }
    return true;
}

bool kn_spline_no_area(const kn_spline *s)
{
    int dim = kn_spline_dim(s);
    if (s->nvars != 2 || dim < 2 || dim > 3) return false;
    return constant_along(s, 0) || constant_along(s, 1) || collinear(s);
}
