// SPDX-License-Identifier: Apache-2.0
// The end of every operation that makes a spline: its arrays are copied to the output's, which are used again.
#include <string.h>

#include "kernel/context.h"
#include "spline/internal.h"

enum { ARRAYS = KN_MAX_VARS + 1 }; // knots, then coefficients

// The arrays of s and their lengths; NULL and 0 where there is none.
static void list(double **array, size_t *length, const kn_spline *s)
{
    for (int d = 0; d < KN_MAX_VARS; d++) {
        bool used = d < s->nvars;
        array[d] = used ? s->knots[d] : NULL;
        length[d] = used ? (size_t)s->count[d] + (size_t)s->degree[d] + 1 : 0;
    }
    array[KN_MAX_VARS] = s->nvars > 0 ? s->coef : NULL;
    length[KN_MAX_VARS] = s->nvars > 0 ? kn_spline_count(s) * (size_t)s->ncomp : 0;
}

// Whether an array of the result is read from elsewhere than its own place.
static bool is_source(double *const *from, const double *array, int place)
{
    for (int i = 0; i < ARRAYS; i++)
        if (i != place && from[i] == array) return true;
    return false;
}

// to[i] = where array i of the result goes: the output's own place, or a new array.
static kn_status choose(kn_ctx *ctx, double **to, double *const *from, const size_t *length, double *const *old,
                        const size_t *old_length)
{
    for (int i = 0; i < ARRAYS; i++) {
        bool stays = from[i] && from[i] == old[i];
        bool fits = old[i] && length[i] == old_length[i] && !is_source(from, old[i], i);
        if (!from[i] || stays || fits) {
            to[i] = from[i] ? old[i] : NULL;
            continue;
        }
        to[i] = kn_alloc(ctx, length[i], sizeof *to[i]);
        if (to[i]) continue;
        for (int k = 0; k < i; k++)
            if (to[k] != old[k]) kn_free(ctx, to[k]);
        return KN_ENOMEM;
    }
    return KN_OK;
}

kn_status kn_spline_store(kn_ctx *ctx, kn_spline *out, const kn_spline *s)
{
    double *from[ARRAYS], *old[ARRAYS], *to[ARRAYS];
    size_t length[ARRAYS], old_length[ARRAYS];
    list(from, length, s);
    list(old, old_length, out);
    kn_status status = choose(ctx, to, from, length, old, old_length);
    if (status != KN_OK) return status;
    kn_spline result = *s;
    for (int i = 0; i < ARRAYS; i++) {
        if (to[i] && to[i] != from[i]) memcpy(to[i], from[i], length[i] * sizeof *to[i]);
        if (i < KN_MAX_VARS) result.knots[i] = to[i];
    }
    result.coef = to[KN_MAX_VARS];
    for (int i = 0; i < ARRAYS; i++)
        if (old[i] != to[i]) kn_free(ctx, old[i]);
    *out = result;
    return KN_OK;
}
