// SPDX-License-Identifier: Apache-2.0
// The pieces of Newton's method with certificate: Jacobians, their inverses, the system made nearly the identity.
#include "solve/search.h"

#include "kernel/bernstein.h"
#include "solve/twofold.h"

#include <string.h>

// Variable by variable from the last: the values, the derivatives so far, and one derivative more.
void kn_net_jacobian(const kn_net *net, const double *coef, const double *s, double *value, double *jacobian,
                     double *work)
{
    int n = net->nvars;
    double basis[KN_MAX_DEGREE + 1], lower[KN_MAX_DEGREE + 1], slope[KN_MAX_DEGREE + 1];
    for (int c = 0; c < net->ncomp; c++) {
        size_t count = net->count;
        const double *from = coef + (size_t)c * net->count;
        for (int d = n - 1; d >= 0; d--) {
            int p = net->degree[d];
            size_t rest = count / (size_t)(p + 1);
            kn_bernstein_basis(basis, p, s[d]);
            kn_bernstein_basis(lower, p > 0 ? p - 1 : 0, s[d]);
            for (int i = 0; i <= p; i++) slope[i] = p * ((i > 0 ? lower[i - 1] : 0.0) - (i < p ? lower[i] : 0.0));
            kn_bernstein_contract(work + (size_t)(d + 1) * net->count, from, rest, p + 1, 1, slope);
            kn_bernstein_contract(work, from, rest, p + 1, 1, basis);
            for (int e = d + 1; e < n; e++) {
                double *other = work + (size_t)(e + 1) * net->count;
                kn_bernstein_contract(other, other, rest, p + 1, 1, basis);
            }
            from = work;
            count = rest;
        }
        value[c] = n > 0 ? work[0] : from[0];
        for (int d = 0; d < n; d++) jacobian[c * n + d] = work[(size_t)(d + 1) * net->count];
    }
}

// Gauss-Jordan with complete pivoting on rows scaled by their largest element: [A | I] becomes [permuted I | Y].
bool kn_left_inverse(double *y, const double *matrix, int m, int n)
{
    double a[KN_MAX_COMPS * KN_MAX_VARS], t[KN_MAX_VARS * KN_MAX_VARS], scale[KN_MAX_COMPS];
    int row_of[KN_MAX_VARS]; // the row that variable d was solved from
    bool used[KN_MAX_COMPS] = {false}, solved[KN_MAX_VARS] = {false};
    for (int i = 0; i < m; i++) {
        double big = kn_largest(matrix + i * n, (size_t)n);
        if (!(big < INFINITY)) return false;
        scale[i] = big > 0.0 ? 1.0 / big : 0.0;
        for (int d = 0; d < n; d++) a[i * n + d] = matrix[i * n + d];
    }
    for (int step = 0; step < n; step++) { // which rows
        int r = -1, c = -1;
        double best = 1e-13;
        for (int i = 0; i < m; i++)
            for (int d = 0; d < n; d++)
                if (!used[i] && !solved[d] && fabs(a[i * n + d]) * scale[i] > best)
                    best = fabs(a[i * n + d]) * scale[i], r = i, c = d;
        if (r < 0) return false;
        used[r] = solved[c] = true;
        row_of[c] = r;
        for (int i = 0; i < m; i++) {
            double factor = a[i * n + c] / a[r * n + c];
            if (i != r && !used[i])
                for (int d = 0; d < n; d++) a[i * n + d] -= factor * a[r * n + d];
        }
    }
    memset(y, 0, (size_t)(n * m) * sizeof *y);
    for (int i = 0; i < n; i++) // the square matrix, and the identity
        for (int d = 0; d < n; d++) a[i * 2 * n + d] = matrix[row_of[i] * n + d], a[i * 2 * n + n + d] = i == d;
    for (int step = 0; step < n; step++) {
        int r = step;
        for (int i = step; i < n; i++)
            if (fabs(a[i * 2 * n + step]) > fabs(a[r * 2 * n + step])) r = i;
        double pivot = a[r * 2 * n + step];
        if (!(fabs(pivot) > 0.0)) return false;
        for (int d = 0; d < 2 * n; d++) {
            double x = a[r * 2 * n + d];
            a[r * 2 * n + d] = a[step * 2 * n + d];
            a[step * 2 * n + d] = x / pivot;
        }
        for (int i = 0; i < n; i++) {
            double factor = a[i * 2 * n + step];
            if (i == step) continue;
            for (int d = 0; d < 2 * n; d++) a[i * 2 * n + d] -= factor * a[step * 2 * n + d];
        }
    }
    for (int i = 0; i < n; i++)
        for (int d = 0; d < n; d++) t[i * n + d] = a[i * 2 * n + n + d];
    for (int i = 0; i < n; i++)
        for (int d = 0; d < n; d++) y[i * m + row_of[d]] = t[i * n + d];
    return true;
}

// max |coefficient of the derivative of g_i along d - identity|.
static double departure(const kn_net *net, const double *g, int d, double ratio, double identity)
{
    size_t inner = kn_net_inner(net, d), row = (size_t)net->degree[d] * inner;
    double n = net->degree[d] * ratio, most = net->degree[d] == 0 ? identity : 0.0;
    for (size_t o = 0; o < net->count && row > 0; o += row + inner)
        for (size_t i = o; i < o + row; i++) {
            double x = fabs(n * (g[i + inner] - g[i]) - identity);
            most = x <= most ? most : x;
        }
    return most;
}

// A sum of m products rounds by gamma(m + 1) sum |y| |f|; a difference of coefficients doubles the error of g.
void kn_finder_combine(kn_finder *f)
{
    int m = f->net.ncomp, n = f->square.ncomp;
    size_t count = f->net.count;
    for (int i = 0; i < n; i++) {
        double *g = f->g + (size_t)i * count, error = 0.0;
        memset(g, 0, count * sizeof *g);
        for (int k = 0; k < m; k++) {
            double y = f->y[i * m + k];
            const double *a = f->coef + (size_t)k * count;
            if (y == 0.0) continue;
            for (size_t j = 0; j < count; j++) g[j] += y * a[j];
            error += fabs(y) * (f->error[k] + kn_rounding(m + 1.0) * kn_largest(a, count));
        }
        f->g_error[i] = error * (1.0 + 0x1p-40) + kn_underflow();
    }
}

double kn_finder_kappa(kn_finder *f)
{
    int n = f->square.ncomp;
    double most = 0.0;
    for (int i = 0; i < n; i++) {
        double sum = 0.0, *g = f->g + (size_t)i * f->net.count, big = kn_largest(g, f->net.count);
        for (int d = 0; d < n; d++) {
            double rounding = 2.0 * f->g_error[i] + kn_rounding(8.0) * big;
            double k = departure(&f->square, g, d, f->ratio[d], i == d) + f->ratio[d] * f->net.degree[d] * rounding +
                       kn_rounding(4.0);
            f->kappa[i * n + d] = k *= 1.0 + 0x1p-40;
            sum += k;
        }
        sum *= 1.0 + 0x1p-40;
        most = sum <= most ? most : sum;
    }
    return most;
}

// B_i(t) in twofold numbers: each step costs a product and an addition, 8 u^2 of non-negative terms in [0,1].
static void basis(kn_twofold *b, int n, double t)
{
    kn_twofold s = kn_two_sum(1.0, -t);
    b[0] = (kn_twofold){1.0, 0.0};
    for (int k = 1; k <= n; k++) {
        b[k] = kn_twofold_scale(b[k - 1], t);
        for (int i = k - 1; i > 0; i--)
            b[i] = kn_twofold_add(kn_twofold_multiply(s, b[i]), kn_twofold_scale(b[i - 1], t));
        b[0] = kn_twofold_multiply(s, b[0]);
    }
}

// Together below 24 (sum n_d + nvars) u^2 max |coefficient|, times the growth beyond [0,1]; then one rounding to a
// double.
void kn_cell_value(const kn_cells *cells, size_t cell, const double *at, double *value, double *error, double *work)
{
    const kn_net *net = &cells->net;
    kn_twofold b[KN_MAX_DEGREE + 1], *v = (kn_twofold *)work;
    double growth = 1.0, steps = net->nvars;
    for (int d = 0; d < net->nvars; d++) {
        double reach = fmax(fmax(-at[d], at[d] - 1.0), 0.0);
        if (reach > 0.0) growth *= pow(1.0 + 2.0 * reach, net->degree[d]) * (1.0 + 0x1p-40);
        steps += net->degree[d];
    }
    for (int c = 0; c < net->ncomp; c++) {
        const double *a = cells->coef + ((size_t)net->ncomp * cell + (size_t)c) * net->count;
        size_t count = net->count;
        int last = net->degree[net->nvars - 1]; // the last variable first, from plain coefficients
        basis(b, last, at[net->nvars - 1]);
        count /= (size_t)(last + 1);
        for (size_t o = 0; o < count; o++) {
            const double *line = a + o * (size_t)(last + 1);
            v[o] = kn_twofold_scale(b[0], line[0]);
            for (int i = 1; i <= last; i++) v[o] = kn_twofold_add(v[o], kn_twofold_scale(b[i], line[i]));
        }
        for (int d = net->nvars - 2; d >= 0; d--) {
            int n = net->degree[d];
            basis(b, n, at[d]);
            count /= (size_t)(n + 1);
            for (size_t o = 0; o < count; o++) {
                const kn_twofold *line = v + o * (size_t)(n + 1);
                kn_twofold sum = kn_twofold_multiply(b[0], line[0]);
                for (int i = 1; i <= n; i++) sum = kn_twofold_add(sum, kn_twofold_multiply(b[i], line[i]));
                v[o] = sum;
            }
        }
        value[c] = v[0].hi;
        error[c] = cells->error[(size_t)net->ncomp * cell + (size_t)c] * growth + 0x1.01p-53 * fabs(v[0].hi) +
                   24.0 * steps * 0x1p-106 * growth * kn_largest(a, net->count) + kn_underflow();
    }
}
