// SPDX-License-Identifier: Apache-2.0
// Octaves of noise as a field.
#include "kernel/context.h"

#include <knurl/field.h>
#include <math.h>

enum { MAX_OCTAVES = 32 };

// (lo + hi) / 2 + (hi - lo) / 2 (sum 2^-k noise_k) / (sum 2^-k), noise_k of the point by size / 2^k.
static double noise_value(const void *user, const kn_place *place)
{
    const kn_field_octaves *o = user;
    double p[3], sum = 0.0, all = 0.0, strength = 1.0;
    bool plain = o->lo == 0.0 && o->hi == 0.0;
    for (int c = 0; c < 3; c++) p[c] = place->point[c] / o->size;
    for (int k = 0; k < (o->octaves > 0 ? o->octaves : 1); k++) {
        sum += strength * kn_noise(p, o->seed + (uint64_t)k);
        all += strength;
        strength *= 0.5;
        for (int c = 0; c < 3; c++) p[c] *= 2.0;
    }
    return plain ? sum / all : fmin(fmax(o->lo + 0.5 * (sum / all + 1.0) * (o->hi - o->lo), o->lo), o->hi);
}

kn_status kn_field_noise(kn_ctx *ctx, kn_field *out, const kn_field_octaves *o)
{
    if (!(o->size > 0.0) || isinf(o->size)) return kn_fail(ctx, KN_EDOMAIN, "field: noise of size %g", o->size);
    if (!isfinite(o->lo) || !isfinite(o->hi) || o->lo > o->hi)
        return kn_fail(ctx, KN_EDOMAIN, "field: noise from %g to %g", o->lo, o->hi);
    if (o->octaves < 0 || o->octaves > MAX_OCTAVES)
        return kn_fail(ctx, o->octaves < 0 ? KN_EDOMAIN : KN_ELIMIT, "field: noise of %d octaves, at most %d",
                       o->octaves, MAX_OCTAVES);
    *out = (kn_field){noise_value, o, KN_NEEDS_POINT};
    return KN_OK;
}
