// SPDX-License-Identifier: Apache-2.0
// Parts of tile patches and the boxes around them.
#include "job/internal.h"

#include <math.h>

// A quarter turn about (1/2, 1/2): (u, v) -> (1 - v, u).
void kn_job_turn(double *u, size_t step, size_t n, int turn)
{
    double *v = u + step, *w = v + step;
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < turn % KN_JOB_FLIP; k++) {
            double before = u[i];
            u[i] = 1.0 - v[i];
            v[i] = before;
        }
        if (turn & KN_JOB_FLIP) v[i] = 1.0 - v[i], w[i] = -w[i];
    }
}

kn_status kn_job_restrict(kn_ctx *ctx, kn_bezier *out, const kn_job_patch *patch, kn_job_rect rect, int turn)
{
    kn_bezier part[2] = {{0}, {0}}, d = {0};
    kn_status status = kn_bezier_copy(ctx, &d, &patch->d);
    for (int var = 0; status == KN_OK && var < patch->d.nvars; var++)
        for (int l = rect.level[var] - 1; status == KN_OK && l >= 0; l--) {
            status = kn_bezier_subdivide(ctx, &part[0], &part[1], &d, var, 0.5);
            if (status == KN_OK) kn_bezier_swap(&d, &part[(rect.index[var] >> l) & 1]);
        }
    if (status == KN_OK) kn_job_turn(d.coef, kn_bezier_count(&d), kn_bezier_count(&d), turn);
    if (status == KN_OK) kn_bezier_swap(out, &d);
    kn_bezier_clear(ctx, &part[0]);
    kn_bezier_clear(ctx, &part[1]);
    kn_bezier_clear(ctx, &d);
    return status;
}

// Sides on multiples of a power of two that is an eighth to a quarter of the width: differences with them are exact
// or nearly so, and patches near one another get the same box and can share a piece. Never thinner than one step, and
// never over a cell line that d does not cross, for lines are multiples of every step.
void kn_job_box(double lo[2], double hi[2], const kn_bezier *d)
{
    size_t n = kn_bezier_count(d);
    for (int c = 0; c < 2; c++) {
        const double *x = d->coef + (size_t)c * n;
        double least = x[0], most = x[0];
        for (size_t i = 1; i < n; i++) {
            least = fmin(least, x[i]);
            most = fmax(most, x[i]);
        }
        int exponent;
        (void)frexp(fmax((most - least) / 4.0, 0x1p-10), &exponent);
        double step = ldexp(1.0, exponent - 1 < -3 ? exponent - 1 : -3);
        lo[c] = floor(least / step) * step;
        hi[c] = ceil(most / step) * step;
        if (hi[c] > lo[c]) continue;
        if (lo[c] >= 1.0)
            lo[c] -= step;
        else
            hi[c] += step;
    }
}

kn_status kn_job_in_box(kn_ctx *ctx, kn_bezier *out, double lo[2], double hi[2], const kn_job_patch *patch,
                        const kn_job_key *key)
{
    kn_bezier d = {0};
    kn_status status = kn_job_restrict(ctx, &d, patch, key->rect, key->turn);
    if (status != KN_OK) return status;
    if (key->whole) {
        for (int c = 0; c < 2; c++) lo[c] = 0.0, hi[c] = 1.0;
    } else {
        kn_job_box(lo, hi, &d);
        size_t n = kn_bezier_count(&d);
        for (size_t c = 0; c < 2; c++)
            for (size_t i = 0; i < n; i++) d.coef[c * n + i] = (d.coef[c * n + i] - lo[c]) / (hi[c] - lo[c]);
    }
    kn_bezier_swap(out, &d);
    kn_bezier_clear(ctx, &d);
    return KN_OK;
}
