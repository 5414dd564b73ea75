// SPDX-License-Identifier: Apache-2.0
// What functions of cells ask of their operands.
#include "cells/internal.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <math.h>

kn_status kn_cells_expect(kn_ctx *ctx, const char *call, const kn_spline *surface)
{
    if (surface->nvars != 2 || kn_spline_dim(surface) != 3)
        return kn_fail(ctx, KN_EDOMAIN, "%s: %d variables, %d components; a surface in space has 2 and 3", call,
                       surface->nvars, kn_spline_dim(surface));
    return kn_spline_check(ctx, surface);
}

kn_status kn_cells_expect_lines(kn_ctx *ctx, const char *call, const kn_spline *surface, int var, const double *lines,
                                int n, bool whole)
{
    double lo, hi;
    if (n < 2) return kn_fail(ctx, KN_EDOMAIN, "%s: %d lines in variable %d", call, n, var);
    kn_spline_domain(surface, var, &lo, &hi);
    for (int i = 0; i < n; i++)
        if (!(lines[i] >= lo && lines[i] <= hi) || (i > 0 && !(lines[i] > lines[i - 1])))
            return kn_fail(ctx, KN_EDOMAIN, "%s: line %d in variable %d, at %g, does not increase or lies outside",
                           call, i, var, lines[i]);
    if (whole && (lines[0] != lo || lines[n - 1] != hi))
        return kn_fail(ctx, KN_EDOMAIN, "%s: lines from %g to %g in variable %d are not all of the domain", call,
                       lines[0], lines[n - 1], var);
    return KN_OK;
}

kn_status kn_cells_expect_count(kn_ctx *ctx, const char *call, const kn_spline *surface, int var, int count)
{
    if (var < 0 || var > 1) return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d of a surface", call, var);
    int spans = kn_spline_spans(surface, var);
    if (count < spans)
        return kn_fail(ctx, KN_EDOMAIN, "%s: %d cells in variable %d, which has %d knot spans", call, count, var,
                       spans);
    return KN_OK;
}

double *kn_cells_breaks(kn_ctx *ctx, int *n, const kn_spline *surface, int var)
{
    double *breaks = kn_scratch(ctx, (size_t)kn_spline_spans(surface, var) + 1, sizeof *breaks);
    if (breaks) *n = kn_knots_breaks(breaks, NULL, surface->knots[var], surface->degree[var], surface->count[var]);
    return breaks;
}
