// SPDX-License-Identifier: Apache-2.0
// The value of a spline at one point.
#include "spline/internal.h"
#include "kernel/context.h"

#define INLINE static inline __attribute__((always_inline))

// kn_knots_span, tried first where equal spans would have it: no search, no branches that are hard to foresee.
static int span_of(const double *knots, int p, int count, double t)
{
    double lo = knots[p], hi = knots[count];
    if (t >= lo && t < hi) {
        double steps = (t - lo) / (hi - lo) * (count - p); // in this order nothing overflows
        int s = p + (steps < count - p ? (int)steps : 0);
        if (t >= knots[s] && t < knots[s + 1]) return s;
    }
    return kn_knots_span(knots, p, count, t);
}

// The B-splines of span s at t by Cox and de Boor's recurrence; p is a constant where it is worth it.
INLINE void basis_of(double *w, const double *knots, int p, int s, double t)
{
    w[0] = 1.0;
    for (int m = 1; m <= p; m++) {
        double carry = 0.0;
        for (int k = 0; k < m; k++) {
            double lo = knots[s - m + 1 + k], hi = knots[s + 1 + k], old = w[k];
            w[k] = carry + (hi - t) / (hi - lo) * old; // the quotients are exactly 0 and 1 at lo and hi
            carry = (t - lo) / (hi - lo) * old;
        }
        w[m] = carry;
    }
}

// sum_j v_j (sum_i u_i c_ij)
INLINE double surface(const double *c, size_t row, const double *u, int p, const double *v, int q)
{
    double s[KN_MAX_DEGREE + 1], sum;
    s[0] = u[0] * c[0];
    for (int j = 1; j <= q; j++) s[j] = u[0] * c[j];
    for (int i = 1; i <= p; i++)
        for (int j = 0; j <= q; j++) s[j] += u[i] * c[(size_t)i * row + (size_t)j];
    sum = v[0] * s[0];
    for (int j = 1; j <= q; j++) sum += v[j] * s[j];
    return sum;
}

INLINE void bicubic(double *value, const kn_spline *s, const double *at)
{
    double u[4], v[4];
    size_t row = (size_t)s->count[1], n = (size_t)s->count[0] * row;
    int su = span_of(s->knots[0], 3, s->count[0], at[0]), sv = span_of(s->knots[1], 3, s->count[1], at[1]);
    basis_of(u, s->knots[0], 3, su, at[0]);
    basis_of(v, s->knots[1], 3, sv, at[1]);
    const double *c = s->coef + (size_t)(su - 3) * row + (size_t)(sv - 3);
    for (int k = 0; k < s->ncomp; k++, c += n) value[k] = surface(c, row, u, 3, v, 3);
}

// sum over the control points that act at a point; the last variable first. basis[d] has degree[d] + 1 values.
static double contract(const kn_spline *s, double (*basis)[KN_MAX_DEGREE + 1], const double *coef, size_t inner,
                       int d)
{
    double sum = 0.0;
    for (int i = 0; i <= s->degree[d]; i++) {
        const double *c = coef + (size_t)i * inner;
        double value = d + 1 < s->nvars ? contract(s, basis, c, inner / (size_t)s->count[d + 1], d + 1) : *c;
        sum += basis[d][i] * value;
    }
    return sum;
}

static void any(double *value, const kn_spline *s, const double *at)
{
    double basis[KN_MAX_VARS][KN_MAX_DEGREE + 1];
    size_t n = kn_spline_count(s), first = 0;
    for (int d = 0; d < s->nvars; d++) {
        int span = span_of(s->knots[d], s->degree[d], s->count[d], at[d]);
        basis_of(basis[d], s->knots[d], s->degree[d], span, at[d]);
        first = first * (size_t)s->count[d] + (size_t)(span - s->degree[d]);
    }
    for (int c = 0; c < s->ncomp; c++) {
        const double *from = s->coef + (size_t)c * n + first;
        value[c] = s->nvars == 2 ? surface(from, (size_t)s->count[1], basis[0], s->degree[0], basis[1], s->degree[1])
                                 : contract(s, basis, from, n / (size_t)s->count[0], 0);
    }
}

kn_status kn_spline_eval(kn_ctx *ctx, double *out, const kn_spline *s, const double *at)
{
    kn_status status = kn_spline_expect(ctx, "spline_eval", s, 0);
    if (status != KN_OK) return status;
    double value[KN_MAX_COMPS];
    if (s->nvars == 2 && s->degree[0] == 3 && s->degree[1] == 3)
        bicubic(value, s, at);
    else
        any(value, s, at);
    int dim = kn_spline_dim(s);
    if (s->rational && value[dim] == 0.0) return kn_fail(ctx, KN_EUNDEFINED, "spline_eval: the weight is zero");
    for (int c = 0; c < dim; c++) out[c] = s->rational ? value[c] / value[dim] : value[c];
    return KN_OK;
}
