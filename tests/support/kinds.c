// SPDX-License-Identifier: Apache-2.0
// Shells of other kinds than S + w n for the tests.
#include "tests/support/kinds.h"

#include <knurl/construct.h>

#include <math.h>

void make_field(kn_ctx *ctx, kn_spline *out, test_rng *rng, const kn_spline *like, int degree, int ncomp,
                double middle, double radius)
{
    double knots[2][16], coef[3 * 100];
    const double *k[2] = {knots[0], knots[1]};
    int degrees[2] = {degree, degree}, count[2] = {degree + 2, degree + 2};
    for (int v = 0; v < 2; v++) {
        double lo, hi;
        kn_spline_domain(like, v, &lo, &hi);
        for (int i = 0; i <= degree; i++) knots[v][i] = lo, knots[v][degree + 2 + i] = hi;
        knots[v][degree + 1] = lo + (v == 0 ? 0.40625 : 0.71875) * (hi - lo);
    }
    for (int i = 0; i < ncomp * count[0] * count[1]; i++)
        coef[i] = test_uniform(rng, middle - radius, middle + radius);
    assert_int_equal(kn_spline_init(ctx, out, 2, ncomp, false, degrees, count, k, coef), KN_OK);
}

void direct_kind(long double t[3], long double j[9], const kn_shell *shell, const kn_shell_options *o, long double u,
                 long double v, long double w)
{
    long double su[3], sv[3], cross[3], n[9], h[3] = {1, 0, 0}, psi[9] = {0}, unused[9];
    int power = o->attraction_power > 0 ? o->attraction_power : 2;
    long double wk = powl(w, power), slope = power * (power > 1 ? powl(w, power - 1) : 1);
    if (!j) j = unused;
    direct_surface(t, su, sv, cross, kn_shell_surface(shell), u, v);
    direct_spline(n, o->direction ? o->direction : kn_shell_normal(shell), u, v);
    if (o->thickness) direct_spline(h, o->thickness, u, v);
    if (o->attraction) direct_spline(psi, o->attraction, u, v);
    for (int c = 0; c < 3; c++) {
        t[c] += w * h[0] * n[c] + wk * psi[c];
        j[3 * c] = su[c] + w * (h[1] * n[c] + h[0] * n[3 + c]) + wk * psi[3 + c];
        j[3 * c + 1] = sv[c] + w * (h[2] * n[c] + h[0] * n[6 + c]) + wk * psi[6 + c];
        j[3 * c + 2] = h[0] * n[c] + slope * psi[c];
    }
}

// The p + 1 B-splines that do not vanish at t, from the definition.
static int b_splines(long double *value, const kn_spline *s, int var, long double t)
{
    const double *k = s->knots[var];
    int p = s->degree[var], span = p;
    while (span < s->count[var] - 1 && (long double)k[span + 1] <= t) span++;
    for (int i = 0; i <= p; i++) value[i] = i == p;
    for (int q = 1; q <= p; q++)
        for (int i = p - q; i <= p; i++) {
            int g = span - p + i;
            long double left = i > p - q ? value[i] * (t - k[g]) / ((long double)k[g + q] - k[g]) : 0;
            long double right = i < p ? value[i + 1] * (k[g + q + 1] - t) / ((long double)k[g + q + 1] - k[g + 1])
                                      : 0;
            value[i] = left + right;
        }
    return span - p;
}

void direct_volume(long double *out, const kn_spline *s, const long double at[3])
{
    long double b[3][16], sum[4] = {0};
    int first[3];
    for (int d = 0; d < 3; d++) first[d] = b_splines(b[d], s, d, at[d]);
    for (int c = 0; c < s->ncomp; c++)
        for (int i = 0; i <= s->degree[0]; i++)
            for (int j = 0; j <= s->degree[1]; j++)
                for (int k = 0; k <= s->degree[2]; k++) {
                    size_t row = (size_t)c * (size_t)s->count[0] + (size_t)(first[0] + i);
                    size_t place = (row * (size_t)s->count[1] + (size_t)(first[1] + j)) * (size_t)s->count[2] +
                                   (size_t)(first[2] + k);
                    sum[c] += b[0][i] * b[1][j] * b[2][k] * s->coef[place];
                }
    for (int c = 0; c < 3; c++) out[c] = s->rational ? sum[c] / sum[3] : sum[c];
}

void direct_piece(long double *out, const kn_bezier *b, const long double at[2])
{
    long double basis[2][KN_MAX_DEGREE + 1];
    for (int d = 0; d < 2; d++) { // C(p,i) x^i (1-x)^(p-i) by the recurrence over degrees
        basis[d][0] = 1;
        for (int q = 1; q <= b->degree[d]; q++)
            for (int i = q; i >= 0; i--)
                basis[d][i] = (i < q ? (1 - at[d]) * basis[d][i] : 0) + (i > 0 ? at[d] * basis[d][i - 1] : 0);
    }
    for (int c = 0; c < b->ncomp; c++) {
        out[c] = 0;
        for (int i = 0; i <= b->degree[0]; i++)
            for (int j = 0; j <= b->degree[1]; j++) {
                size_t row = (size_t)c * (size_t)(b->degree[0] + 1) + (size_t)i;
                out[c] += basis[0][i] * basis[1][j] * b->coef[row * (size_t)(b->degree[1] + 1) + (size_t)j];
            }
    }
}

static void make_random_volume(kn_ctx *ctx, kn_spline *out)
{
    const double ku[6] = {0, 0, 0, 1, 1, 1}, kw[8] = {5, 5, 5, 6, 6.5, 8, 8, 8};
    const double *knots[3] = {ku, ku, kw};
    test_rng rng = test_random(31);
    double coef[3 * 3 * 3 * 5];
    for (int i = 0; i < 45; i++) {
        coef[i] = i / 15 + test_uniform(&rng, -0.2, 0.2);
        coef[45 + i] = i / 5 % 3 + test_uniform(&rng, -0.2, 0.2);
        coef[90 + i] = 0.5 * (i % 5) + test_uniform(&rng, -0.1, 0.1);
    }
    assert_int_equal(
        kn_spline_init(ctx, out, 3, 3, false, (const int[3]){2, 2, 2}, (const int[3]){3, 3, 5}, knots, coef), KN_OK);
}

void make_volume(kn_ctx *ctx, kn_spline *out, int which)
{
    kn_spline s = {0}, other = {0};
    const double along[3] = {0.5, 0, 2}, origin[3] = {0, -6, 0}, axis[3] = {-1, 0, 0};
    const double bend[12] = {0, 0.5, 0, 1, 0, 0.5, 1, 2, 0, 0, 0.75, 2}, k[8] = {0, 0, 0, 0, 3, 3, 3, 3};
    const double *knots[1] = {k};
    kn_status status = KN_OK;
    *out = (kn_spline){0};
    if (which == VOLUME_OF_SPANS) {
        make_random_volume(ctx, out);
        return;
    }
    make_wavy(ctx, &s);
    if (which == 0) status = kn_spline_copy(ctx, &other, &s);
    for (size_t i = 0; i < kn_spline_count(&s) && which == 0; i++)
        other.coef[2 * kn_spline_count(&s) + i] += 2.0 + 0.25 * (double)(i % 3);
    if (which == 0) status = kn_construct_ruled(ctx, out, &s, &other);
    if (which == 1) status = kn_construct_extruded(ctx, out, &s, along);
    if (which == 2) {
        status = kn_spline_init(ctx, &other, 1, 3, false, (const int[1]){3}, (const int[1]){4}, knots, bend);
        if (status == KN_OK) status = kn_construct_swept(ctx, out, &s, &other);
    }
    if (which == 3) status = kn_construct_revolved(ctx, out, &s, origin, axis, 0.5);
    if (status != KN_OK) fail_msg("volume %d: %s", which, kn_ctx_message(ctx));
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &other);
}
