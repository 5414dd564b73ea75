// SPDX-License-Identifier: Apache-2.0
// With f = N / w, A = N.N and G = A - t^2 w^2: |f|^2 = t^2 + G / w^2. Lower bounds of G:
// - its smallest coefficient;
// - where G grows or falls along a variable, its smallest value lies on a face, and that variable is done with;
// - G(x) >= G(c) + G'(c) (x - c) + m/2 |x - c|^2, m <= 0 below all eigenvalues of G'' (Adjiman & Floudas, 1996). Near
//   a minimum m is 0 or rounding, and with c the minimum nothing is lost.
#include "solve/distance.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"

#include <string.h>

kn_status kn_distance_init(kn_ctx *ctx, kn_distance *d, const kn_net *net, bool rational)
{
    int twice[KN_MAX_VARS];
    for (int i = 0; i < net->nvars; i++) twice[i] = 2 * net->degree[i];
    *d = (kn_distance){.net = *net, .square = kn_net_make(net->nvars, 1, twice), .rational = rational};
    d->dim = net->ncomp - rational;
    size_t n = net->count, m = d->square.count, k = (size_t)net->nvars;
    d->weights = kn_scratch(ctx, n, sizeof *d->weights);
    d->square_weights = kn_scratch(ctx, m, sizeof *d->square_weights);
    d->places = kn_scratch(ctx, n, sizeof *d->places);
    d->scaled = kn_scratch(ctx, n, sizeof *d->scaled);
    d->a = kn_scratch(ctx, 3 * m, sizeof *d->a);
    d->slopes = kn_scratch(ctx, (k + 2) * m, sizeof *d->slopes);
    d->work = kn_scratch(ctx, (k + 1) * m, sizeof *d->work);
    if (!d->weights || !d->square_weights || !d->places || !d->scaled || !d->a || !d->slopes || !d->work)
        return KN_ENOMEM;
    d->w = d->a + m;
    d->g = d->w + m;
    kn_bernstein_weights(d->weights, net->nvars, net->degree);
    kn_bernstein_weights(d->square_weights, net->nvars, twice);
    kn_bernstein_places(d->places, net->nvars, net->degree, twice);
    return KN_OK;
}

// out = the sum of the squares of components first .. first + count - 1. The error: of sums of T products of scaled
// coefficients, and of the components themselves.
static double squares(kn_distance *d, double *out, const double *coef, const double *error, int first, int count)
{
    size_t n = d->net.count, m = d->square.count;
    double slack = 0.0, size = 0.0;
    memset(out, 0, m * sizeof *out);
    for (int c = first; c < first + count; c++) {
        const double *x = coef + (size_t)c * n;
        double big = kn_largest(x, n);
        for (size_t i = 0; i < n; i++) d->scaled[i] = d->weights[i] * x[i];
        kn_bernstein_convolve(out, d->scaled, d->places, n, d->scaled, d->places, n,
                              d->net.degree[d->net.nvars - 1] + 1, 1.0);
        slack += error[c] * (2.0 * big + error[c]);
        size += big * big;
    }
    for (size_t i = 0; i < m; i++) out[i] /= d->square_weights[i];
    return (slack + kn_rounding((double)n * count + 3.0 * d->net.nvars + 4.0) * size) * (1.0 + 0x1p-40) +
           kn_underflow();
}

// Drops variable v of g: its lower or upper face.
static void face(kn_net *net, double *g, int v, bool upper)
{
    size_t inner = kn_net_inner(net, v), row = (size_t)(net->degree[v] + 1) * inner, at = upper ? row - inner : 0,
           to = 0;
    for (size_t o = 0; o < net->count; o += row)
        for (size_t i = 0; i < inner; i++) g[to++] = g[o + at + i];
    net->count = to;
    net->degree[v] = 0;
}

// Whether g grows (1) or falls (-1) along v as a whole; 0: neither. Errors of g do not matter: what is bounded is the
// function with the computed coefficients, and that is within the error of G.
static int direction(const kn_net *net, const double *g, int v)
{
    size_t inner = kn_net_inner(net, v), row = (size_t)net->degree[v] * inner;
    bool up = true, down = true;
    for (size_t o = 0; o < net->count; o += row + inner)
        for (size_t i = o; i < o + row; i++) {
            up = up && g[i + inner] >= g[i];
            down = down && g[i + inner] <= g[i];
        }
    return up ? 1 : down ? -1 : 0;
}

// The derivative of g along v, in d->slopes[slot].
static double *slope(kn_distance *d, const kn_net *net, const double *g, int v, size_t slot, kn_net *of)
{
    double *out = d->slopes + slot * d->square.count;
    size_t inner = kn_net_inner(net, v);
    kn_bernstein_differentiate(out, g, net->count / (inner * (size_t)(net->degree[v] + 1)), net->degree[v], inner);
    *of = *net;
    of->degree[v] = net->degree[v] > 0 ? net->degree[v] - 1 : 0;
    of->count = kn_bernstein_count(net->nvars, of->degree);
    return out;
}

// Below all eigenvalues of all symmetric matrices in a box of them: those of the middle, by Gershgorin's discs after
// Jacobi's rotations, less the half widths.
static double least_eigenvalue(double h[KN_CLOSEST_VARS][KN_CLOSEST_VARS], double radius, int n)
{
    double norm = 0.0, least = INFINITY;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) norm = fmax(norm, fabs(h[i][j]));
    for (int sweep = 0; sweep < 6; sweep++)
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++) {
                if (h[p][q] == 0.0) continue;
                double theta = (h[q][q] - h[p][p]) / (2.0 * h[p][q]);
                double t = (theta >= 0.0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
                double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
                for (int k = 0; k < n; k++) {
                    double x = h[k][p], y = h[k][q];
                    h[k][p] = c * x - s * y;
                    h[k][q] = s * x + c * y;
                }
                for (int k = 0; k < n; k++) {
                    double x = h[p][k], y = h[q][k];
                    h[p][k] = c * x - s * y;
                    h[q][k] = s * x + c * y;
                }
            }
    for (int i = 0; i < n; i++) {
        double disc = h[i][i];
        for (int j = 0; j < n; j++) disc -= j == i ? 0.0 : fabs(h[i][j]);
        least = fmin(least, disc);
    }
    return least - radius - 0x1p-40 * norm; // 6 sweeps of rotations round by far less
}

// The least eigenvalue of G'' over the box, in its own parameters.
static double curvature(kn_distance *d, const kn_net *net, const double *g)
{
    int n = net->nvars;
    double h[KN_CLOSEST_VARS][KN_CLOSEST_VARS] = {{0}}, radius = 0.0, big = kn_largest(g, net->count);
    for (int i = 0; i < n; i++) {
        kn_net first, second;
        double row[KN_CLOSEST_VARS] = {0};
        if (net->degree[i] == 0) continue;
        const double *along = slope(d, net, g, i, 0, &first);
        for (int j = 0; j < n; j++) {
            if (net->degree[j] == 0) continue;
            const double *c = slope(d, &first, along, j, 1, &second);
            double lo = c[0], hi = c[0];
            for (size_t k = 1; k < second.count; k++) lo = c[k] < lo ? c[k] : lo, hi = c[k] > hi ? c[k] : hi;
            h[i][j] = 0.5 * (lo + hi);
            row[j] = 0.5 * (hi - lo) + kn_rounding(32.0) * net->degree[i] * net->degree[j] * big;
        }
        double sum = 0.0;
        for (int j = 0; j < n; j++) sum += row[j];
        radius = fmax(radius, sum);
    }
    int k = 0, active[KN_CLOSEST_VARS]; // without the variables that are done with
    double m[KN_CLOSEST_VARS][KN_CLOSEST_VARS] = {{0}};
    for (int i = 0; i < n; i++)
        if (net->degree[i] > 0) active[k++] = i;
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++) m[i][j] = 0.5 * (h[active[i]][active[j]] + h[active[j]][active[i]]);
    return k > 0 ? least_eigenvalue(m, radius, k) : 0.0;
}

// Projected Newton's method for the minimum of g in [0,1]^n, from x; value and slope there.
static void descend(kn_distance *d, const kn_net *net, const double *g, double *x, double *value, double *gradient)
{
    int n = net->nvars;
    double hessian[KN_CLOSEST_VARS * KN_CLOSEST_VARS], inverse[KN_CLOSEST_VARS * KN_CLOSEST_VARS];
    kn_net of[KN_CLOSEST_VARS];
    const double *along[KN_CLOSEST_VARS];
    for (int i = 0; i < n; i++) along[i] = slope(d, net, g, i, (size_t)i, &of[i]);
    for (int step = 0; step < 8; step++) {
        double move = 0.0;
        for (int i = 0; i < n; i++) kn_net_jacobian(&of[i], along[i], x, &gradient[i], hessian + i * n, d->work);
        for (int i = 0; i < n; i++) { // at an end, and pushed out
            bool held = net->degree[i] == 0 || (x[i] <= 0.0 && gradient[i] > 0.0) ||
                        (x[i] >= 1.0 && gradient[i] < 0.0);
            for (int j = 0; j < n && held; j++) hessian[i * n + j] = hessian[j * n + i] = i == j;
        }
        if (!kn_left_inverse(inverse, hessian, n, n)) break;
        for (int i = 0; i < n; i++) {
            double by = 0.0;
            bool held = net->degree[i] == 0 || (x[i] <= 0.0 && gradient[i] > 0.0) ||
                        (x[i] >= 1.0 && gradient[i] < 0.0);
            for (int j = 0; j < n; j++) by -= inverse[i * n + j] * gradient[j];
            if (held) continue;
            double to = fmin(fmax(x[i] + by, 0.0), 1.0);
            move = fmax(move, fabs(to - x[i]));
            x[i] = to;
        }
        if (move < 1e-14) break;
    }
    for (int i = 0; i < n; i++) kn_net_jacobian(&of[i], along[i], x, &gradient[i], hessian + i * n, d->work);
    kn_net_jacobian(net, g, x, value, hessian, d->work);
}

// The bound by curvature; x: where the minimum seems to be.
static double quadratic(kn_distance *d, const kn_net *net, const double *g, double *x)
{
    double value, gradient[KN_CLOSEST_VARS], bent = fmin(curvature(d, net, g), 0.0), steps = 0.0;
    double big = kn_largest(g, net->count);
    descend(d, net, g, x, &value, gradient);
    for (int i = 0; i < net->nvars; i++) {
        if (net->degree[i] == 0) continue;
        double far = fmax(x[i], 1.0 - x[i]);
        value += (gradient[i] > 0.0 ? -gradient[i] * x[i] : gradient[i] * (1.0 - x[i])) + 0.5 * bent * far * far;
        steps += 2.0 * net->degree[i];
    }
    for (int i = 0; i < net->nvars; i++) // the rounding of the value and of each slope
        value -= kn_rounding(8.0 * steps + 16.0) * big * (i == 0 ? 1.0 + 2.0 * steps : 1.0);
    return value - 0x1p-50 * fabs(value);
}

double kn_distance_bound(kn_distance *d, const double *coef, const double *error, double limit, double *at)
{
    int n = d->net.nvars;
    size_t m = d->square.count;
    double t = limit < 0x1p500 ? limit * limit : 0.0, a_error = squares(d, d->a, coef, error, 0, d->dim),
           w_error = 0.0;
    double least_w = 1.0, most_w = 1.0, lowest = INFINITY;
    kn_net net = d->square;
    if (d->rational) w_error = squares(d, d->w, coef, error, d->dim, 1);
    for (size_t i = 0; i < m; i++) {
        double w = d->rational ? d->w[i] : 1.0;
        d->g[i] = d->a[i] - t * w;
        least_w = i == 0 || w < least_w ? w : least_w;
        most_w = i == 0 || w > most_w ? w : most_w;
        double low = d->a[i] > a_error ? (d->a[i] - a_error) / (w + w_error) : 0.0;
        lowest = low < lowest ? low : lowest;
    }
    if (!(least_w > w_error)) least_w = w_error = 0.0;
    double slack = a_error + t * w_error + kn_rounding(4.0) * (kn_largest(d->a, m) + t * most_w);
    for (int v = 0; v < n; v++) at[v] = 0.5;
    for (int again = 1; again;) { // faces
        again = 0;
        for (int v = 0; v < n; v++) {
            int along = net.degree[v] > 0 ? direction(&net, d->g, v) : 0;
            if (along == 0) continue;
            face(&net, d->g, v, along < 0);
            at[v] = along < 0 ? 1.0 : 0.0;
            again = 1;
        }
    }
    double best = d->g[0];
    for (size_t i = 1; i < net.count; i++) best = d->g[i] < best ? d->g[i] : best;
    if (net.count > 1) best = fmax(best, quadratic(d, &net, d->g, at));
    best -= slack * (1.0 + 0x1p-40);
    double square = least_w > 0.0 ? t + best / (best < 0.0 ? (least_w - w_error) : (most_w + w_error)) : -1.0;
    square = fmax(square - 0x1p-50 * (t + fabs(square)), lowest * (1.0 - 0x1p-50));
    return square > 0.0 ? sqrt(square) * (1.0 - 0x1p-50) : 0.0;
}
