// SPDX-License-Identifier: Apache-2.0
// Arrays of coefficients: restriction with a bound of its rounding, and the variable to divide.
#include "solve/net.h"

#include "kernel/bernstein.h"

#include <string.h>

kn_net kn_net_make(int nvars, int ncomp, const int *degree)
{
    kn_net net = {.nvars = nvars, .ncomp = ncomp, .count = kn_bernstein_count(nvars, degree)};
    for (int d = 0; d < nvars; d++) net.degree[d] = degree[d];
    return net;
}

double kn_largest(const double *coef, size_t n)
{
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        double a = fabs(coef[i]);
        most = a > most ? a : most;
    }
    return most;
}

size_t kn_net_inner(const kn_net *net, int d)
{
    return kn_bernstein_count(net->nvars - d - 1, net->degree + d + 1);
}

size_t kn_net_rhythm(size_t coefficients)
{
    size_t boxes = ((size_t)1 << 17) / (coefficients + 1);
    return boxes < 1 ? 1 : boxes > 1024 ? 1024 : boxes;
}

void kn_net_restrict(double *out, double *error, const kn_net *net, const double *in, const double *lo,
                     const double *hi, double *work)
{
    double matrix[(KN_MAX_DEGREE + 1) * (KN_MAX_DEGREE + 1)], growth = 1.0, roundings = 0.0;
    const double *from = in;
    size_t size = (size_t)net->ncomp * net->count;
    int maps = 0;
    for (int d = 0; d < net->nvars; d++) maps += lo[d] != 0.0 || hi[d] != 1.0;
    for (int d = 0; d < net->nvars; d++) {
        if (lo[d] == 0.0 && hi[d] == 1.0) continue;
        int n = net->degree[d];
        size_t inner = kn_net_inner(net, d), outer = size / (inner * (size_t)(n + 1));
        double *to = --maps % 2 == 0 ? out : work; // the last one ends in out
        kn_bernstein_restriction(matrix, n, lo[d], hi[d]);
        kn_bernstein_transform(to, from, outer, n + 1, n + 1, inner, matrix);
        double reach = fmax(fmax(-lo[d], hi[d] - 1.0), 0.0);
        roundings += 5.0 * n + 2.0;
        if (reach > 0.0) growth *= pow(1.0 + 2.0 * reach, n) * (1.0 + 0x1p-40);
        from = to;
    }
    if (from == in) memcpy(out, in, size * sizeof *out);
    if (roundings == 0.0) return;
    for (int c = 0; c < net->ncomp; c++) {
        double most = kn_largest(in + (size_t)c * net->count, net->count);
        error[c] = (growth * (error[c] + kn_rounding(roundings) * most) + kn_underflow()) * (1.0 + 0x1p-40);
    }
}

int kn_net_steepest(const kn_net *net, const double *coef, const double *error)
{
    int best = -1;
    double most = 0.0;
    for (int d = 0; d < net->nvars; d++) {
        size_t inner = kn_net_inner(net, d), row = (size_t)net->degree[d] * inner;
        double sum = 0.0;
        if (net->degree[d] == 0) continue;
        for (int c = 0; c < net->ncomp; c++) {
            const double *a = coef + (size_t)c * net->count;
            double scale = kn_largest(a, net->count), diff = 0.0;
            for (size_t o = 0; o < net->count; o += row + inner)
                for (size_t i = o; i < o + row; i++) {
                    double x = fabs(a[i + inner] - a[i]);
                    diff = x > diff ? x : diff;
                }
            if (net->degree[d] * diff > 2.0 * error[c] && scale > 0.0) sum += net->degree[d] * (diff / scale);
        }
        if (sum > most) most = sum, best = d;
    }
    return best;
}
