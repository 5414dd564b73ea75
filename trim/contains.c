// SPDX-License-Identifier: Apache-2.0
// kn_trim_contains: how often the boundary winds around a point, by the ray from it to the right.
//
// A piece of curve whose box lies to the right of the point crosses the ray, counted with signs, as often as its two
// ends say; one whose box lies elsewhere, not at all; others are halved. Points on the ray count as below it.
#include "kernel/context.h"
#include "trim/internal.h"

#include <math.h>
#include <string.h>

enum { HALVINGS = 48 };

typedef struct arc {
    double x[KN_MAX_DEGREE + 1], y[KN_MAX_DEGREE + 1];
} arc;

static void range(double *lo, double *hi, const double *x, int degree)
{
    *lo = *hi = x[0];
    for (int i = 1; i <= degree; i++) {
        *lo = fmin(*lo, x[i]);
        *hi = fmax(*hi, x[i]);
    }
}

// left and x, which becomes right.
static void halve(double *left, double *x, int degree)
{
    left[0] = x[0];
    for (int k = 1; k <= degree; k++) {
        for (int i = 0; i <= degree - k; i++) x[i] = 0.5 * (x[i] + x[i + 1]);
        left[k] = x[0];
    }
}

// *crossings += the ray's, upwards 1 and downwards -1; false: too near to tell.
static bool count(int *crossings, arc *a, int degree, const double point[2], int halvings)
{
    double lo[2], hi[2];
    range(&lo[0], &hi[0], a->x, degree);
    range(&lo[1], &hi[1], a->y, degree);
    if (hi[0] < point[0] || lo[1] > point[1] || hi[1] <= point[1]) return true;
    if (lo[0] > point[0]) {
        *crossings += (a->y[degree] > point[1]) - (a->y[0] > point[1]);
        return true;
    }
    if (halvings == 0) return false;
    arc left;
    halve(left.x, a->x, degree);
    halve(left.y, a->y, degree);
    return count(crossings, &left, degree, point, halvings - 1) && count(crossings, a, degree, point, halvings - 1);
}

static kn_status count_curve(kn_ctx *ctx, int *crossings, bool *known, const kn_spline *curve, const double point[2])
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, curve);
    for (size_t i = 0; status == KN_OK && *known && i < n; i++) {
        int degree = pieces[i].degree[0];
        size_t bytes = ((size_t)degree + 1) * sizeof(double);
        arc a;
        memcpy(a.x, pieces[i].coef, bytes);
        memcpy(a.y, pieces[i].coef + degree + 1, bytes);
        *known = count(crossings, &a, degree, point, HALVINGS);
    }
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    return status;
}

kn_status kn_trim_contains(kn_ctx *ctx, kn_answer *out, const kn_trim *trim, const double point[2])
{
    if (!isfinite(point[0]) || !isfinite(point[1]))
        return kn_fail(ctx, KN_EDOMAIN, "trim: the point (%g, %g)", point[0], point[1]);
    bool known = true;
    int crossings = 0;
    if (trim->nloops == 0) {
        *out = point[0] >= 0.0 && point[0] <= 1.0 && point[1] >= 0.0 && point[1] <= 1.0 ? KN_YES : KN_NO;
        return KN_OK;
    }
    for (int i = 0; known && i < trim->ncurves; i++) {
        kn_status status = count_curve(ctx, &crossings, &known, &trim->curves[i], point);
        if (status != KN_OK) return status;
    }
    *out = !known ? KN_UNKNOWN : crossings > 0 ? KN_YES : KN_NO;
    return KN_OK;
}
