// SPDX-License-Identifier: Apache-2.0
// Splines evaluated in long double by de Boor's algorithm on control values.
#include "tests/spline/oracle.h"
#include "kernel/knots.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

// The piece on span s in one variable: c holds its degree + 1 control values and is destroyed. absolute: every
// difference is replaced by the sum of absolute values.
static long double de_boor(long double *c, const double *knots, int p, int s, long double t, int order, bool absolute)
{
    if (order > p) return 0.0L;
    for (int m = p; m > p - order; m--) // differences: degree m to m - 1
        for (int i = 0; i < m; i++) {
            long double h = (long double)knots[s + 1 + i] - knots[s - m + 1 + i];
            c[i] = m * (absolute ? c[i + 1] + c[i] : c[i + 1] - c[i]) / h;
        }
    for (int m = p - order; m > 0; m--)
        for (int i = 0; i < m; i++) {
            long double lo = knots[s - m + 1 + i], hi = knots[s + 1 + i], u = (t - lo) / (hi - lo),
                        v = (hi - t) / (hi - lo);
            c[i] = absolute ? fabsl(v) * c[i] + fabsl(u) * c[i + 1] : v * c[i] + u * c[i + 1];
        }
    return c[0];
}

static long double reduce(const kn_spline *s, const double *coef, const double *at, const int *a, const int *span,
                          int d, bool absolute)
{
    long double c[KN_MAX_DEGREE + 1];
    size_t inner = 1;
    for (int e = d + 1; e < s->nvars; e++) inner *= (size_t)s->count[e];
    for (int i = 0; i <= s->degree[d]; i++) {
        const double *from = coef + (size_t)(span[d] - s->degree[d] + i) * inner;
        if (d + 1 < s->nvars)
            c[i] = reduce(s, from, at, a, span, d + 1, absolute);
        else
            c[i] = absolute ? fabs(*from) : *from;
    }
    return de_boor(c, s->knots[d], s->degree[d], span[d], at[d], a ? a[d] : 0, absolute);
}

void oracle_homogeneous(long double *value, long double *size, const kn_spline *s, const double *at, const int *a,
                        const int *span)
{
    int own[KN_MAX_VARS];
    for (int d = 0; d < s->nvars && !span; d++) {
        int i = s->count[d] - 1;
        while (i > s->degree[d] && !(s->knots[d][i] <= at[d] && s->knots[d][i] < s->knots[d][i + 1])) i--;
        if (at[d] >= s->knots[d][s->count[d]]) i = s->count[d] - 1;
        own[d] = i;
    }
    size_t n = kn_spline_count(s);
    for (int c = 0; c < s->ncomp; c++) {
        const double *coef = s->coef + (size_t)c * n;
        if (value) value[c] = reduce(s, coef, at, a, span ? span : own, 0, false);
        if (size) size[c] = reduce(s, coef, at, a, span ? span : own, 0, true);
    }
}

void oracle_value(long double *value, const kn_spline *s, const double *at)
{
    long double all[KN_MAX_COMPS];
    int dim = kn_spline_dim(s);
    oracle_homogeneous(all, NULL, s, at, NULL, NULL);
    for (int c = 0; c < dim; c++) value[c] = s->rational ? all[c] / all[dim] : all[c];
}

double oracle_gamma(int operations)
{
    double nu = operations * (DBL_EPSILON / 2);
    return nu / (1 - nu);
}

int oracle_eval_operations(const kn_spline *s)
{
    int n = 0;
    for (int d = 0; d < s->nvars; d++) n += 6 * s->degree[d] + 1;
    return n;
}

void oracle_assert_same(const kn_spline *s, const kn_spline *t, uint64_t salt, int points, double beyond,
                        int operations)
{
    test_rng rng = {salt};
    assert_int_equal(s->nvars, t->nvars);
    assert_int_equal(s->ncomp, t->ncomp);
    assert_true(s->rational == t->rational);
    for (int i = 0; i < points; i++) {
        long double u[KN_MAX_COMPS], v[KN_MAX_COMPS], su[KN_MAX_COMPS], sv[KN_MAX_COMPS];
        double at[KN_MAX_VARS];
        for (int d = 0; d < s->nvars; d++) {
            double lo, hi;
            kn_spline_domain(s, d, &lo, &hi);
            at[d] = test_uniform(&rng, lo - beyond, hi + beyond);
        }
        oracle_homogeneous(u, su, s, at, NULL, NULL);
        oracle_homogeneous(v, sv, t, at, NULL, NULL);
        for (int c = 0; c < s->ncomp; c++)
            if (!(fabsl(u[c] - v[c]) <= oracle_gamma(operations) * (su[c] + sv[c])))
                fail_msg("component %d differs by %Lg, bound %Lg", c, fabsl(u[c] - v[c]),
                         oracle_gamma(operations) * (su[c] + sv[c]));
    }
}

double oracle_largest(const kn_spline *s)
{
    double most = 0;
    for (size_t i = 0; i < kn_spline_count(s) * (size_t)s->ncomp; i++) most = fmax(most, fabs(s->coef[i]));
    return most;
}

int oracle_lower(int a, int b)
{
    return a < b ? a : b;
}

int oracle_multiplicity(const kn_spline *s, int var, double at)
{
    int n = 0;
    for (int i = 0; i < s->count[var] + s->degree[var] + 1; i++) n += s->knots[var][i] == at;
    return n;
}

double oracle_growth(const kn_spline *out)
{
    double total = 1;
    for (int d = 0; d < out->nvars; d++) {
        double breaks[16], w[64 * 16], most = 0;
        int first[64], n = kn_knots_breaks(breaks, NULL, out->knots[d], out->degree[d], out->count[d]);
        assert_true(out->count[d] <= 64 && out->degree[d] < 16 && n <= 16);
        kn_band band = {.rows = out->count[d], .first = first, .w = w};
        kn_band_join(&band, breaks, n, out->degree[d], out->knots[d]);
        for (int i = 0; i < band.rows; i++) {
            double sum = 0;
            for (int k = 0; k < band.width; k++) sum += fabs(w[i * band.width + k]);
            most = fmax(most, sum);
        }
        total *= most;
    }
    return total;
}

double oracle_sampled_distance(const kn_spline *a, const kn_spline *b, test_rng *rng, int n)
{
    double most = 0;
    for (; n > 0; n--) {
        double at[3], sum = 0;
        long double x[4], y[4];
        for (int d = 0; d < a->nvars; d++) {
            double lo, hi;
            kn_spline_domain(a, d, &lo, &hi);
            at[d] = test_uniform(rng, lo, hi);
        }
        oracle_value(x, a, at);
        oracle_value(y, b, at);
        for (int c = 0; c < kn_spline_dim(a); c++) sum += (double)((x[c] - y[c]) * (x[c] - y[c]));
        most = fmax(most, sqrt(sum));
    }
    return most;
}
