// SPDX-License-Identifier: Apache-2.0
// Sizes and ranges of a spline.
#include <knurl/spline.h>

#include "kernel/knots.h"

size_t kn_spline_count(const kn_spline *s)
{
    size_t n = s->nvars > 0;
    for (int d = 0; d < s->nvars; d++) n *= (size_t)s->count[d];
    return n;
}

int kn_spline_dim(const kn_spline *s)
{
    return s->ncomp - s->rational;
}

void kn_spline_domain(const kn_spline *s, int var, double *lo, double *hi)
{
    *lo = s->knots[var][0];
    *hi = s->knots[var][s->count[var]];
}

int kn_spline_spans(const kn_spline *s, int var)
{
    return kn_knots_spans(s->knots[var], s->degree[var], s->count[var]);
}
