// SPDX-License-Identifier: Apache-2.0
// Cell lines of a surface.
#include "compose/job.h"

#include <math.h>

// parts[i] >= 1 of spans breaks[i] .. breaks[i+1], proportional to their lengths, `count` together: what the floors
// of the shares leave over goes to the largest remainders, what the minimum of one took too much comes from the
// smallest.
static void share(int *parts, const double *breaks, int spans, int count)
{
    double total = breaks[spans] - breaks[0];
    int sum = 0;
    for (int i = 0; i < spans; i++) {
        double part = floor(count * ((breaks[i + 1] - breaks[i]) / total));
        parts[i] = part < 1.0 ? 1 : (int)part;
        sum += parts[i];
    }
    for (; sum != count; sum += sum < count ? 1 : -1) {
        int best = -1;
        double most = 0.0;
        for (int i = 0; i < spans; i++) {
            double rest = count * ((breaks[i + 1] - breaks[i]) / total) - parts[i];
            double value = sum < count ? rest : -rest;
            if (sum > count && parts[i] == 1) continue;
            if (best < 0 || value > most) best = i, most = value;
        }
        parts[best] += sum < count ? 1 : -1;
    }
}

kn_status kn_job_make_lines(kn_ctx *ctx, double **lines, bool **knot, const kn_spline *surface, int var, int count)
{
    int spans = kn_spline_spans(surface, var), n = 0;
    kn_mark mark = kn_scratch_mark(ctx);
    double *breaks = kn_scratch(ctx, (size_t)spans + 1, sizeof *breaks);
    int *parts = kn_scratch(ctx, (size_t)spans, sizeof *parts);
    double *line = kn_alloc(ctx, (size_t)count + 1, sizeof *line);
    bool *is_knot = kn_alloc_zero(ctx, (size_t)count + 1, sizeof *is_knot);
    bool ok = breaks && parts && line && is_knot;
    if (ok) {
        const double *k = surface->knots[var];
        int nknots = surface->count[var] + surface->degree[var] + 1;
        for (int i = 0; i < nknots; i++)
            if (n == 0 || k[i] != breaks[n - 1]) breaks[n++] = k[i];
        share(parts, breaks, spans, count);
        int at = 0;
        for (int i = 0; i < spans; i++) {
            is_knot[at] = true;
            for (int j = 0; j < parts[i]; j++)
                line[at++] = breaks[i] + (breaks[i + 1] - breaks[i]) * ((double)j / parts[i]);
        }
        line[at] = breaks[spans];
        is_knot[at] = true;
        *lines = line;
        *knot = is_knot;
    } else {
        kn_free(ctx, line);
        kn_free(ctx, is_knot);
    }
    kn_scratch_release(ctx, mark);
    return ok ? KN_OK : KN_ENOMEM;
}
