// SPDX-License-Identifier: Apache-2.0
// A surface of the tile over an end of the domain, where the border clips it: trimmed along the preimage of the end.
#include "job/cross.h"

#include <math.h>

// A trim is no coarser and no finer than this in (u, v) of a cell.
#define COARSEST 0x1p-8
#define FINEST 0x1p-40

bool kn_cross_is_clipped(const kn_crossing *x)
{
    bool yes = false;
    for (int k = 0; k < 4; k++) yes = yes || isfinite(x->end[k / 2][k % 2]);
    return yes;
}

// *error: by how much T on the trims differs from T on the ends, which are within delta of them.
static kn_status find_error(kn_ctx *ctx, double *error, const kn_crossing *x, double delta)
{
    *error = 0.0;
    for (int k = 0; k < 4; k++) {
        int var = k / 2, at = k % 2, across = 1 - var;
        for (int b = 0; isfinite(x->end[var][at]) && b <= x->n[across]; b++) {
            int box = at == 0 ? 0 : x->n[var];
            double shift;
            kn_status status = kn_crossing_shift(ctx, &shift, x, var, at, var == 0 ? box : b, var == 0 ? b : box,
                                                 delta);
            if (status != KN_OK) return status;
            *error = fmax(*error, shift);
        }
    }
    return KN_OK;
}

static void swap(kn_trim *a, kn_trim *b)
{
    kn_trim t = *a;
    *a = *b;
    *b = t;
}

kn_status kn_cross_clip(kn_ctx *ctx, bool *fits, bool *any, kn_trim *trim, kn_crossing *x)
{
    double tol = x->plan->job->options.crossing_tol, delta = COARSEST, error = INFINITY;
    kn_trim kept = {0}, other = {0};
    kn_trim_cut_report report = {.below = true, .above = true};
    kn_status status = kn_crossing_pieces(ctx, fits, x);
    if (status != KN_OK || !*fits) return status;
    status = find_error(ctx, &error, x, delta);
    for (; status == KN_OK && error > tol && delta > FINEST; delta /= 4.0)
        status = find_error(ctx, &error, x, delta / 4.0);
    *fits = error <= tol;
    if (status != KN_OK || !*fits) return status;
    bool left = true;
    x->off = 0.0;
    status = kn_trim_copy(ctx, &kept, trim);
    for (int k = 0; status == KN_OK && left && k < 4; k++) {
        if (!isfinite(x->end[k / 2][k % 2])) continue;
        status = kn_cross_cut(ctx, &other, &kept, &report, x, k / 2, x->end[k / 2][k % 2], delta);
        if (k % 2 == 1) swap(&kept, &other);
        left = k % 2 == 0 ? report.above : report.below;
    }
    int exponent;
    (void)frexp(fmax(x->off, FINEST), &exponent); // the next power of two
    if (status == KN_OK) status = find_error(ctx, &error, x, fmin(delta, ldexp(1.0, exponent)));
    if (status == KN_OK) {
        x->plan->crossing = fmax(x->plan->crossing, error);
        x->off = 0.0;
        *any = left;
        swap(trim, &kept);
    }
    kn_trim_clear(ctx, &kept);
    kn_trim_clear(ctx, &other);
    return status;
}
