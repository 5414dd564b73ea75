// SPDX-License-Identifier: Apache-2.0
// Samples over [0,1]^2 as a field, bilinear between them.
#include "kernel/context.h"

#include <knurl/field.h>
#include <math.h>

// The two samples around t and the part of the second one.
static double neighbours(int at[2], int n, bool closed, double t)
{
    double x = closed ? (t - floor(t)) * n : fmin(fmax(t, 0.0), 1.0) * (n - 1);
    int last = closed ? n - 1 : n - 2, i = (int)x;
    if (!(x >= 0.0)) i = 0; // t is not a number
    at[0] = i < last ? i : last;
    at[1] = closed ? (at[0] + 1) % n : at[0] + 1;
    return x - at[0];
}

static double grid_value(const void *user, const kn_place *place)
{
    const kn_field_samples *s = user;
    int at[2][2];
    double part[2], row[2];
    for (int d = 0; d < 2; d++) part[d] = neighbours(at[d], s->n[d], s->closed[d], place->uv[d]);
    for (int k = 0; k < 2; k++) {
        const double *v = s->values + (size_t)at[0][k] * (size_t)s->n[1];
        row[k] = (1.0 - part[1]) * v[at[1][0]] + part[1] * v[at[1][1]];
    }
    return (1.0 - part[0]) * row[0] + part[0] * row[1];
}

kn_status kn_field_grid(kn_ctx *ctx, kn_field *out, const kn_field_samples *samples)
{
    for (int d = 0; d < 2; d++)
        if (samples->n[d] < (samples->closed[d] ? 1 : 2))
            return kn_fail(ctx, KN_EDOMAIN, "field: %d samples in %s", samples->n[d], d == 0 ? "u" : "v");
    size_t n = (size_t)samples->n[0] * (size_t)samples->n[1];
    for (size_t i = 0; i < n; i++)
        if (!isfinite(samples->values[i]))
            return kn_fail(ctx, KN_EDOMAIN, "field: sample %zu is %g", i, samples->values[i]);
    *out = (kn_field){grid_value, samples, 0};
    return KN_OK;
}
