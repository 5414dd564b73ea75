// SPDX-License-Identifier: Apache-2.0
// Splines cut where they have kinks.
#include "io/split.h"
#include "kernel/context.h"

#include <math.h>

#define SAME_DERIVATIVE 1e-9

// d/dt of the quotient on one side of a control point that lies on the knot, from its neighbour on that side:
// p / h w1 / w0 (X1 - X0).
static void derivative(double out[3], const kn_spline *s, size_t n, size_t at, size_t neighbour, double factor)
{
    double w0 = s->rational ? s->coef[3 * n + at] : 1.0, w1 = s->rational ? s->coef[3 * n + neighbour] : 1.0;
    for (size_t c = 0; c < 3; c++)
        out[c] = factor * (w1 / w0) * (s->coef[c * n + neighbour] / w1 - s->coef[c * n + at] / w0);
}

// The knots equal to knots[last] reach up to `last`, degree of them: control point last - degree lies on them.
static bool is_kink(const kn_spline *s, int var, int last)
{
    size_t n = kn_spline_count(s), inner = 1, outer = 1;
    int p = s->degree[var], on = last - p;
    const double *t = s->knots[var];
    for (int d = var + 1; d < s->nvars; d++) inner *= (size_t)s->count[d];
    for (int d = 0; d < var; d++) outer *= (size_t)s->count[d];
    double left = -p / (t[last] - t[last - p]), right = p / (t[last + 1] - t[last]);
    for (size_t o = 0; o < outer; o++)
        for (size_t i = 0; i < inner; i++) {
            size_t at = (o * (size_t)s->count[var] + (size_t)on) * inner + i;
            double a[3], b[3], gap = 0.0, size = 0.0;
            derivative(a, s, n, at, at - inner, left);
            derivative(b, s, n, at, at + inner, right);
            for (int c = 0; c < 3; c++) {
                gap += (a[c] - b[c]) * (a[c] - b[c]);
                size = fmax(size, fmax(fabs(a[c]), fabs(b[c])));
            }
            if (!(sqrt(gap) <= SAME_DERIVATIVE * size)) return true;
        }
    return false;
}

// The last knot of the first interior one at which s is not C1 in variable var; 0: there is none.
static int find_kink(const kn_spline *s, int var)
{
    int p = s->degree[var], n = s->count[var];
    const double *t = s->knots[var];
    for (int last = p + 1; last < n; last++) {
        if (t[last] == t[last + 1]) continue;
        int times = 1;
        while (t[last - times] == t[last]) times++;
        if (times > p || (times == p && is_kink(s, var, last))) return last;
    }
    return 0;
}

static kn_status split(kn_ctx *ctx, void *user, kn_split_taker take, kn_spline *s, int var)
{
    kn_spline left = {0};
    kn_status status = KN_OK;
    if (var == s->nvars) return take(ctx, user, s);
    for (int at; status == KN_OK && (at = find_kink(s, var)) > 0;) {
        status = kn_spline_subdivide(ctx, &left, s, s, var, s->knots[var][at]);
        if (status == KN_OK) status = split(ctx, user, take, &left, var + 1);
        kn_spline_clear(ctx, &left);
    }
    return status == KN_OK ? split(ctx, user, take, s, var + 1) : status;
}

kn_status kn_split_kinks(kn_ctx *ctx, void *user, kn_split_taker take, kn_spline *s)
{
    return split(ctx, user, take, s, 0);
}
