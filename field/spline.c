// SPDX-License-Identifier: Apache-2.0
// A spline over [0,1]^2 as a field.
#include "kernel/context.h"
#include "kernel/knots.h"

#include <knurl/field.h>

// sum_ij N_i(u) N_j(v) c_ij, the last variable first.
static double value_at(const kn_spline *s, const double *coef, const double *u, const double *v)
{
    double sum = 0.0;
    for (int i = 0; i <= s->degree[0]; i++) {
        double row = 0.0;
        for (int j = 0; j <= s->degree[1]; j++) row += v[j] * coef[(size_t)i * (size_t)s->count[1] + (size_t)j];
        sum += u[i] * row;
    }
    return sum;
}

static double spline_value(const void *user, const kn_place *place)
{
    const kn_spline *s = user;
    double basis[2][KN_MAX_DEGREE + 1];
    int span[2];
    for (int d = 0; d < 2; d++) {
        span[d] = kn_knots_span(s->knots[d], s->degree[d], s->count[d], place->uv[d]);
        kn_knots_basis(basis[d], s->knots[d], s->degree[d], span[d], place->uv[d], 0);
    }
    size_t first = (size_t)(span[0] - s->degree[0]) * (size_t)s->count[1] + (size_t)(span[1] - s->degree[1]);
    double value = value_at(s, s->coef + first, basis[0], basis[1]);
    return s->rational ? value / value_at(s, s->coef + kn_spline_count(s) + first, basis[0], basis[1]) : value;
}

kn_status kn_field_spline(kn_ctx *ctx, kn_field *out, const kn_spline *spline)
{
    kn_status status = kn_spline_check(ctx, spline);
    if (status != KN_OK) return status;
    bool fits = spline->nvars == 2 && kn_spline_dim(spline) == 1;
    for (int d = 0; d < 2 && fits; d++) {
        double lo, hi;
        kn_spline_domain(spline, d, &lo, &hi);
        fits = lo == 0.0 && hi == 1.0;
    }
    if (!fits) return kn_fail(ctx, KN_EDOMAIN, "field: a spline is to have one component over [0,1]^2");
    *out = (kn_field){spline_value, spline, 0};
    return KN_OK;
}
