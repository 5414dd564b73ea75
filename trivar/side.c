// SPDX-License-Identifier: Apache-2.0
// Above or below: the signs of w at all support positions.
#include "kernel/context.h"
#include "trivar/inverse.h"

// What the places certainly are, and what they may be.
typedef struct signs {
    bool above, on, below;
} signs;

static void add(signs *s, bool above, bool on, bool below)
{
    s->above = s->above || above;
    s->on = s->on || on;
    s->below = s->below || below;
}

static kn_side decide(const signs *sure, const signs *maybe)
{
    if (sure->on) return KN_SIDE_ON;
    bool more = maybe->on || (maybe->above && !sure->above) || (maybe->below && !sure->below);
    if (more) return KN_SIDE_UNDECIDED;
    if (sure->above) return sure->below ? KN_SIDE_BOTH : KN_SIDE_ABOVE;
    return sure->below ? KN_SIDE_BELOW : KN_SIDE_NONE;
}

kn_status kn_shell_side(kn_ctx *ctx, kn_side *out, const kn_shell_inverse *inverse, const double point[3])
{
    kn_support *places = NULL;
    size_t n = 0;
    bool complete;
    signs sure = {0}, maybe = {0};
    kn_status status = kn_shell_support(ctx, &places, &n, &complete, inverse, point);
    if (status != KN_OK) return status;
    for (size_t i = 0; i < n; i++) {
        double w = places[i].uvw[2], e = places[i].error[2];
        if (places[i].certified)
            add(&sure, w > e, fabs(w) <= e, w < -e);
        else
            add(&maybe, w + e > 0.0, fabs(w) <= e, w - e < 0.0);
    }
    kn_free(ctx, places);
    *out = decide(&sure, &maybe);
    return KN_OK;
}
