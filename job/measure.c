// SPDX-License-Identifier: Apache-2.0
// Lengths of a surface's isoparametric curves, and how much they bend.
#include "job/internal.h"

#include <math.h>

enum { STEPS_PER_SPAN = 32, MAX_STEPS = 4096 };

static double distance(const double *p, const double *q)
{
    return sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
}

double kn_job_off_chord(const double *p, const double *a, const double *b)
{
    double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {p[0] - a[0], p[1] - a[1], p[2] - a[2]};
    double length = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    double t = length > 0.0 ? (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) / length : 0.0;
    const double foot[3] = {t * u[0], t * u[1], t * u[2]};
    return distance(v, foot);
}

// The polygon through n + 1 points: its length, and its bend. Over two of n steps a curve is (2/n)^2 of what it would
// be over the whole from its chord, if it went on bending as it does there.
static void measure_polygon(double *length, double *bend, const double *p, int n)
{
    *length = 0.0;
    for (int i = 0; i < n; i++) *length += distance(p + 3 * i, p + 3 * (i + 1));
    for (int i = 1; i < n; i++) {
        double height = kn_job_off_chord(p + 3 * i, p + 3 * (i - 1), p + 3 * (i + 1));
        *bend = fmax(*bend, height * n * n / 4.0);
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
