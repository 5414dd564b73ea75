// SPDX-License-Identifier: Apache-2.0
// The first positive root of a polynomial, from below.
#include "fold/internal.h"
#include "kernel/binomial.h"

#include <math.h>
#include <string.h>

static const double tiny = 1e-280;            // below it squares and products may have underflown
static const double less = 1.0 - 0x1p-46;     // more than the roundings of a closed form
static const double rounding = 8.0 * 0x1p-53; // of the discriminant, relative to its terms

// The first root of a + b w + c w^2 for a > 0.
static double quadratic(double a, double b, double c)
{
    if (b >= 0.0 && c >= 0.0) return INFINITY;
    double bb = b * b, ac = 4.0 * a * c;
    if (!isfinite(bb) || !isfinite(ac) || (bb < tiny && b != 0.0) || (fabs(ac) < tiny && c != 0.0)) {
        // a / 2 is left for each of the two: no root before that is used up
        double first = b < 0.0 ? 0.5 * a / -b : INFINITY, second = c < 0.0 ? sqrt(0.5 * a / -c) : INFINITY;
        double root = first < second ? first : second;
        return root > 0.0 ? root * less : 0.0;
    }
    double disc = bb - ac + rounding * (bb + fabs(ac));
    if (disc < 0.0) return INFINITY;
    double root = b <= 0.0 ? 2.0 * a / (sqrt(disc) - b) : (b + sqrt(disc * (1.0 - 4.0 * rounding))) / (-2.0 * c);
    return root * less;
}

// A number up to which q_0 exceeds what the negative coefficients take away; INFINITY without any.
static double step_of(const double *q, int top)
{
    double step = INFINITY;
    int negative = 0;
    for (int k = 1; k <= top; k++) negative += q[k] < 0.0;
    if (negative == 0) return INFINITY;
    for (int k = 1; k <= top; k++)
        if (q[k] < 0.0) step = fmin(step, pow(q[0] / -q[k], 1.0 / k));
    // The least of these is at most `negative` times as far as all together reach; halve what is too far.
    double lo = 0.0, hi = step;
    for (int i = 0; i < 30; i++) {
        double s = 0.5 * (lo + hi), sum = 0.0;
        for (int k = top; k > 0; k--) sum = (sum + fmin(q[k], 0.0)) * s;
        if (q[0] + sum > 0.0)
            lo = s;
        else
            hi = s;
    }
    return lo * (1.0 - 0x1p-20);
}

// Steps towards the root, each to where q, expanded about the last place, is certainly still positive.
static double stepped(double *q, int top)
{
    enum { STEPS = 60 };
    double at = 0.0;
    for (int i = 0; i < STEPS && q[0] > 0.0; i++) {
        double step = step_of(q, top);
        if (step == INFINITY) return INFINITY;
        if (!(step > 1e-5 * at) || !isfinite(step)) break;
        // Taylor's shift; what rounding may have added is taken off every coefficient.
        double size[KN_MAX_COMPS];
        for (int k = 0; k <= top; k++) size[k] = fabs(q[k]);
        for (int m = 0; m < top; m++)
            for (int k = top - 1; k >= m; k--) q[k] += step * q[k + 1], size[k] += step * size[k + 1];
        for (int k = 0; k <= top; k++) q[k] -= 4.0 * (top + 2) * 0x1p-53 * size[k];
        at += step * (1.0 - 0x1p-50);
    }
    return at;
}

double kn_fold_first_root(const double *c, size_t step, const double *error, int top, double share, bool zero_at_0)
{
    double q[KN_MAX_COMPS];
    for (int k = 0; k <= top; k++) {
        double x = c[(size_t)k * step];
        q[k] = x - (error[k] + (share + 0x1p-50) * fabs(x));
        if (!(q[k] > -INFINITY)) return 0.0;
    }
    int first = 0;
    if (zero_at_0) // w^first divides it: the next coefficient decides next to 0
        for (first = 1; first < top && c[(size_t)first * step] == 0.0 && error[first] == 0.0;) first++;
    const double *p = q + first;
    if (first > top || !(p[0] > 0.0)) return 0.0;
    top -= first;
    if (top == 0) return INFINITY;
    if (top <= 2) return quadratic(p[0], p[1], top == 2 ? p[2] : 0.0);
    return stepped(q + first, top);
}
