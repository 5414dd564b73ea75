// SPDX-License-Identifier: Apache-2.0
// Lengths of a surface's isoparametric curves, and how much they bend.
#include "compose/job.h"

#include <math.h>

enum { STEPS_PER_SPAN = 32, MAX_STEPS = 4096 };

static double distance(const double *p, const double *q)
{
    return sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
}

// The polygon through n + 1 points: its length, and the largest second difference, which is |S''| / n^2; a curve with
// |S''| over a unit interval is |S''| / 8 from its chord.
static void measure_polygon(double *length, double *bend, const double *p, int n)
{
    *length = 0.0;
    for (int i = 0; i < n; i++) *length += distance(p + 3 * i, p + 3 * (i + 1));
    for (int i = 1; i < n; i++) {
        const double *a = p + 3 * (i - 1);
        double twice[3] = {2.0 * a[3] - a[6], 2.0 * a[4] - a[7], 2.0 * a[5] - a[8]};
        *bend = fmax(*bend, distance(a, twice) * n * n / 8.0);
    }
}

kn_status kn_job_measure_surface(kn_ctx *ctx, kn_job_measure *out, const kn_spline *surface)
{
    kn_job_measure m = {.bend = {0.0, 0.0}};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = KN_OK;
    for (int along = 0; status == KN_OK && along < 2; along++) {
        int n = kn_spline_spans(surface, along) * STEPS_PER_SPAN;
        n = n < MAX_STEPS ? n : MAX_STEPS;
        double *at = kn_scratch(ctx, (size_t)n + 1, 2 * sizeof *at),
               *p = kn_scratch(ctx, (size_t)n + 1, 3 * sizeof *p);
        if (!at || !p) status = KN_ENOMEM;
        double lo[2], hi[2];
        for (int d = 0; d < 2; d++) kn_spline_domain(surface, d, &lo[d], &hi[d]);
        for (int k = 0; status == KN_OK && k < 3; k++) {
            int across = 1 - along;
            for (int i = 0; i <= n; i++) {
                at[2 * i + along] = i == n ? hi[along] : lo[along] + (hi[along] - lo[along]) * i / n;
                at[2 * i + across] = k == 2 ? hi[across] : lo[across] + (hi[across] - lo[across]) * k / 2.0;
            }
            status = kn_spline_eval_batch(ctx, p, surface, (size_t)n + 1, at);
            if (status == KN_OK) measure_polygon(&m.length[along][k], &m.bend[along], p, n);
        }
        kn_scratch_release(ctx, mark);
    }
    if (status == KN_OK) *out = m;
    return status;
}

double kn_job_mean_length(const kn_job_measure *m, int along)
{
    return (m->length[along][0] + m->length[along][1] + m->length[along][2]) / 3.0;
}
