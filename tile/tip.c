// SPDX-License-Identifier: Apache-2.0
// How smoothly one curve goes on in another: A leads out of the one at its end, B into the other.
//   G1: A x B = 0, A . B > 0. G2: then B = a A, and the other's C'' less a^2 C'' of the one is parallel to B.
#include "tile/net.h"

#include <float.h>
#include <math.h>

// First and second derivatives at a tip, and a bound of what the second is a difference of.
static void derive(double first[3], double second[3], double sizes[2], const kn_tile_net *net, int tip, double sign)
{
    const kn_bezier *b = &net->curves[tip / 2].curve;
    int p = b->degree[0], end = tip % 2 ? p : 0, step = tip % 2 ? -1 : 1, n = p + 1;
    double f = 0.0, s = 0.0;
    for (int c = 0; c < 3; c++) {
        const double *x = b->coef + c * n;
        double d1 = p > 0 ? x[end] - x[end + step] : 0.0, d2 = p > 1 ? x[end + step] - x[end + 2 * step] : 0.0;
        first[c] = sign * p * d1;
        second[c] = p > 1 ? p * (p - 1.0) * (d1 - d2) : 0.0;
        f += first[c] * first[c];
        if (p > 1) s = fmax(s, p * (p - 1.0) * (fabs(d1) + fabs(d2)));
    }
    sizes[0] = sqrt(f);
    sizes[1] = 2.0 * s;
}

static double cross_length(const double a[3], const double b[3])
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, e = (c + 2) % 3;
        double x = a[d] * b[e] - a[e] * b[d];
        sum += x * x;
    }
    return sqrt(sum);
}

kn_tile_joint kn_tile_tip_order(const kn_tile_net *net, int tip, double angle, int most)
{
    const double rounding = 64.0 * DBL_EPSILON;
    double a[3], b[3], aa[3], bb[3], sa[2], sb[2], k[3], ab = 0.0;
    derive(a, aa, sa, net, tip, 1.0);
    derive(b, bb, sb, net, net->tips[tip].mate, -1.0);
    kn_tile_joint joint = {.order = 0, .at = tip % 2};
    double cross = cross_length(a, b), size = sa[0] * sb[0];
    for (int c = 0; c < 3; c++) ab += a[c] * b[c];
    if (!(size > 0.0)) return joint; // a tangent that is not there
    joint.decided = true;
    joint.amount = atan2(cross, ab);
    if (cross + rounding * size <= angle * size && ab > 0.0) {
        double f = sb[0] / sa[0], limit = angle * (sb[1] + f * f * sa[1]) * sb[0];
        for (int c = 0; c < 3; c++) k[c] = bb[c] - f * f * aa[c];
        cross = cross_length(k, b);
        joint.order = most > 1 && cross + rounding * limit / angle <= limit ? 2 : 1;
        joint.amount = cross / (sb[0] * sb[0] * sb[0]);
        if (limit == 0.0) joint.order = most;
    }
    if (joint.order > most) joint.order = most;
    return joint;
}
