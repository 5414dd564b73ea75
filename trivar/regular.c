// SPDX-License-Identifier: Apache-2.0
// Does a direction vanish somewhere? Coefficients against their mean direction, with subdivision where undecided.
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

enum { DEPTH = 52 };

// n vanishes nowhere where all its coefficients lie strictly on one side of a plane through the origin.
static bool one_sided(const double *n, size_t count, double error)
{
    double d[3] = {0}, length = 0.0;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < count; i++) d[c] += n[(size_t)c * count + i];
        length += d[c] * d[c];
    }
    length = sqrt(length);
    if (!(length > 0.0) || !isfinite(length)) return false;
    for (size_t i = 0; i < count; i++)
        if (!(n[i] * d[0] + n[count + i] * d[1] + n[2 * count + i] * d[2] > error * length)) return false;
    return true;
}

// Depth first, on a stack of one pair of halves for each level.
kn_status kn_direction_regular(kn_ctx *ctx, bool *regular, double at[2], const kn_direction *d)
{
    size_t count = kn_bezier_count(&d->n), size = 3 * count;
    int mu = d->n.degree[0], mv = d->n.degree[1], depth = 0;
    double lo[DEPTH + 1][2] = {{0}}, width[2] = {1.0, 1.0};
    bool second[DEPTH + 1] = {false};
    double error = d->error + kn_gamma(4.0 * (mu + mv + 2) * DEPTH) * kn_largest_vector(&d->n, 0, 3);
    kn_mark mark = kn_scratch_mark(ctx);
    double *stack = kn_scratch(ctx, (2 * DEPTH + 1) * size, sizeof *stack);
    if (!stack) return KN_ENOMEM;
    memcpy(stack, d->n.coef, size * sizeof *stack);
    *regular = true;
    // Level k >= 1 keeps its halves at 2k - 1 (first) and 2k (second); level 0 is the whole.
    for (;;) {
        double *now = stack + (depth == 0 ? 0 : (size_t)(2 * depth - (second[depth] ? 0 : 1))) * size;
        if (!one_sided(now, count, error)) {
            if (depth == DEPTH) {
                *regular = false;
                for (int v = 0; v < 2; v++) at[v] = lo[depth][v] + 0.5 * width[v];
                break;
            }
            int var = depth % 2;
            double *first = stack + (size_t)(2 * depth + 1) * size;
            if (var == 0) kn_bernstein_split(first, first + size, now, 3, mu, (size_t)mv + 1, 0.5);
            if (var == 1) kn_bernstein_split(first, first + size, now, 3 * ((size_t)mu + 1), mv, 1, 0.5);
            memcpy(lo[depth + 1], lo[depth], sizeof lo[0]);
            width[var] *= 0.5;
            second[++depth] = false;
            continue;
        }
        while (depth > 0 && second[depth]) width[--depth % 2] *= 2.0;
        if (depth == 0) break;
        second[depth] = true;
        lo[depth][(depth - 1) % 2] += width[(depth - 1) % 2];
    }
    kn_scratch_release(ctx, mark);
    return KN_OK;
}
