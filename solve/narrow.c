// SPDX-License-Identifier: Apache-2.0
// What the coefficients exclude: whole boxes, and their ends (the projected polyhedron).
#include "solve/search.h"

bool kn_net_excluded(const kn_net *net, const double *coef, const double *error)
{
    for (int c = 0; c < net->ncomp; c++) {
        const double *a = coef + (size_t)c * net->count;
        double least = a[0], most = a[0];
        for (size_t i = 1; i < net->count; i++) {
            least = a[i] < least ? a[i] : least;
            most = a[i] > most ? a[i] : most;
        }
        if (least > error[c] || most < -error[c]) return true;
    }
    return false;
}

// The graph over variable d lies in the hull of the segments {k/n} x [lo_k, hi_k]; the first and the last place where
// the hull meets 0 lie on lines from an end of a segment that is >= 0 to one that is <= 0. lo and hi include the
// errors. Crossings are rounded outwards: five roundings of quantities up to 1.
static bool cross(const double *lo, const double *hi, int n, double *t0, double *t1)
{
    double x[2 * (KN_MAX_DEGREE + 1)], y[2 * (KN_MAX_DEGREE + 1)], first = 2.0, last = -1.0;
    int below = 0, above = 2 * (KN_MAX_DEGREE + 1); // from both ends of the arrays
    for (int k = 0; k <= n; k++) {
        double place = (double)k / n;
        if (hi[k] >= 0.0) x[--above] = place, y[above] = hi[k];
        if (lo[k] <= 0.0) x[below] = place, y[below++] = lo[k];
        if (lo[k] > 0.0) x[--above] = place, y[above] = lo[k];
        if (hi[k] < 0.0) x[below] = place, y[below++] = hi[k];
    }
    for (int i = 0; i < below; i++)
        for (int j = above; j < 2 * (KN_MAX_DEGREE + 1); j++) {
            double rise = y[j] - y[i], at = rise > 0.0 ? x[j] + (x[i] - x[j]) * (y[j] / rise) : x[j];
            first = at < first ? at : first;
            last = at > last ? at : last;
            if (!(rise > 0.0)) first = fmin(first, x[i]), last = fmax(last, x[i]);
        }
    if (first > last) return false;
    *t0 = fmax(*t0, first - 0x1p-49);
    *t1 = fmin(*t1, last + 0x1p-49);
    return *t0 <= *t1;
}

static bool narrow_one(const kn_net *net, const double *a, double error, int d, double *t0, double *t1)
{
    double lo[KN_MAX_DEGREE + 1], hi[KN_MAX_DEGREE + 1];
    size_t inner = kn_net_inner(net, d), row = (size_t)(net->degree[d] + 1) * inner;
    int n = net->degree[d];
    lo[0] = hi[0] = lo[n] = hi[n] = 0.0;
    for (int k = 0; k <= n; k++) {
        double least = a[(size_t)k * inner], most = least;
        for (size_t o = (size_t)k * inner; o < net->count; o += row)
            for (size_t i = o; i < o + inner; i++) {
                least = a[i] < least ? a[i] : least;
                most = a[i] > most ? a[i] : most;
            }
        lo[k] = least - error;
        hi[k] = most + error;
    }
    if (n == 0) return lo[0] <= 0.0 && hi[0] >= 0.0;
    if (lo[0] <= 0.0 && hi[0] >= 0.0 && lo[n] <= 0.0 && hi[n] >= 0.0) return true;
    return cross(lo, hi, n, t0, t1);
}

bool kn_net_narrow(const kn_net *net, const double *coef, const double *error, double *t0, double *t1)
{
    for (int c = 0; c < net->ncomp; c++)
        for (int d = 0; d < net->nvars; d++)
            if (!narrow_one(net, coef + (size_t)c * net->count, error[c] * (1.0 + 0x1p-50), d, &t0[d], &t1[d]))
                return false;
    return true;
}
