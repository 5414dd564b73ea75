// SPDX-License-Identifier: Apache-2.0
// Degree elevation, one degree at a time: every knot once more often, the continuity as it was.
#include "spline/internal.h"
#include "kernel/context.h"

static kn_status raise_once(kn_ctx *ctx, kn_spline *s, int var)
{
    int p = s->degree[var], nknots = s->count[var] + p + 1, n = 0;
    const double *knots = s->knots[var];
    kn_mark mark = kn_scratch_mark(ctx);
    kn_band band;
    double *to = kn_scratch(ctx, (size_t)nknots + (size_t)kn_spline_spans(s, var) + 1, sizeof *to);
    kn_status status = to ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        for (int i = 0; i < nknots; i++) {
            to[n++] = knots[i];
            if (i + 1 == nknots || knots[i + 1] > knots[i]) to[n++] = knots[i];
        }
        status = kn_spline_band(ctx, &band, n - p - 2, p + 1);
    }
    if (status == KN_OK) {
        kn_band_elevate(&band, knots, p, s->count[var], to);
        status = kn_spline_map(ctx, s, var, p + 1, to, &band);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_spline_elevate(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const int *degree)
{
    kn_status status = kn_spline_expect(ctx, "spline_elevate", a, 0);
    if (status != KN_OK) return status;
    for (int d = 0; d < a->nvars; d++) {
        if (degree[d] < a->degree[d])
            return kn_fail(ctx, KN_EDOMAIN, "spline_elevate: degree %d to %d in variable %d", a->degree[d], degree[d],
                           d);
        if (degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "spline_elevate: degree %d in variable %d", degree[d], d);
    }
    kn_spline s = {0};
    status = kn_spline_copy(ctx, &s, a);
    for (int d = 0; d < a->nvars; d++)
        while (status == KN_OK && s.degree[d] < degree[d]) status = raise_once(ctx, &s, d);
    if (status == KN_OK) kn_spline_swap(out, &s);
    kn_spline_clear(ctx, &s);
    return status;
}
