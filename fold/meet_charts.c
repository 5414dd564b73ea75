// SPDX-License-Identifier: Apache-2.0
// Shells cut into Bezier pieces of T, and what is known of their breaks and edges.
#include "fold/meet.h"

#include "kernel/knots.h"

#include <string.h>

// ---- pieces ----

static size_t piece_index(const kn_meet_chart *c, int i, int j, int k)
{
    return ((size_t)i * (size_t)(c->nbreaks[1] - 1) + (size_t)j) * (size_t)(c->nbreaks[2] - 1) + (size_t)k;
}

// Roundings behind a coefficient: S, n and the fields are made compatible and multiplied, which are convex
// combinations, 6 a new knot or argument and less than 3 for each coefficient that meets in a product, and are cut
// into pieces, 6 p + 1 in each variable. Bounded by the degrees p of T, all relative to its largest coefficient.
static double roundings(const kn_spline *volume)
{
    double n = 64.0;
    for (int d = 0; d < 3; d++) n += 64.0 * (volume->degree[d] + 1);
    return n;
}

static kn_status cut(kn_meet *m, kn_meet_chart *c)
{
    const kn_spline *v = &c->volume;
    for (int d = 0; d < 3; d++) {
        c->nbreaks[d] = kn_spline_spans(v, d) + 1;
        c->breaks[d] = kn_alloc(m->ctx, (size_t)c->nbreaks[d], sizeof *c->breaks[d]);
        if (!c->breaks[d]) return KN_ENOMEM;
        kn_knots_breaks(c->breaks[d], NULL, v->knots[d], v->degree[d], v->count[d]);
    }
    size_t n = kn_spline_count(v);
    for (int k = 0; k < v->ncomp; k++)
        c->error[k] = kn_rounding(roundings(v)) * kn_largest(v->coef + (size_t)k * n, n) + kn_underflow();
    return kn_spline_to_bezier(m->ctx, &c->pieces, &c->npieces, v);
}

static bool is_flat(const kn_meet_chart *c)
{
    size_t row = (size_t)c->volume.count[2], n = kn_spline_count(&c->volume);
    if (!c->volume.rational) return true;
    const double *w = c->volume.coef + 3 * n;
    for (size_t i = 0; i < n; i++)
        if (w[i] != w[i - i % row]) return false;
    return true;
}

// ---- breaks and poles ----

// The largest distance of two control points over the same place, plainly; INFINITY where weights differ.
static double face_jump(const kn_bezier *a, const kn_bezier *b, int var)
{
    size_t n = kn_bezier_count(a), inner = 1, side = (size_t)a->degree[var] + 1;
    for (int d = var + 1; d < 3; d++) inner *= (size_t)a->degree[d] + 1;
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        if (i / inner % side != 0) continue;
        size_t j = i + (side - 1) * inner; // the same place at a's upper end
        double wa = a->rational ? a->coef[3 * n + j] : 1.0, wb = a->rational ? b->coef[3 * n + i] : 1.0, sum = 0.0;
        if (wa != wb) return INFINITY;
        for (int k = 0; k < 3; k++) {
            double x = (a->coef[(size_t)k * n + j] - b->coef[(size_t)k * n + i]) / wa;
            sum += x * x;
        }
        most = fmax(most, sqrt(sum));
    }
    return most;
}

static kn_status find_jumps(kn_meet *m, kn_meet_chart *c)
{
    for (int d = 0; d < 2; d++) {
        c->jump[d] = kn_alloc_zero(m->ctx, (size_t)c->nbreaks[d], sizeof(double));
        if (!c->jump[d]) return KN_ENOMEM;
        for (int i = 0; i < c->nbreaks[0] - 1; i++)
            for (int j = 0; j < c->nbreaks[1] - 1; j++)
                for (int k = 0; k < c->nbreaks[2] - 1; k++) {
                    if ((d == 0 ? i : j) == 0) continue;
                    const kn_bezier *b = &c->pieces[piece_index(c, i, j, k)],
                                    *a = &c->pieces[piece_index(c, d == 0 ? i - 1 : i, d == 1 ? j - 1 : j, k)];
                    double *jump = &c->jump[d][d == 0 ? i : j];
                    *jump = fmax(*jump, face_jump(a, b, d));
                }
    }
    return KN_OK;
}

// The edge `end` of variable var is a pole when, for each height, all control points of its face are one point within
// the tolerance.
static bool is_pole(const kn_meet_chart *c, int var, int end, double tolerance)
{
    const kn_spline *v = &c->volume;
    size_t n = kn_spline_count(v), row = (size_t)v->count[2], side = (size_t)v->count[var];
    size_t inner = var == 0 ? (size_t)v->count[1] * row : row;
    if (!c->flat_weight) return false;
    for (size_t i = 0; i < n; i++) {
        if (i / inner % side != (end ? side - 1 : 0)) continue;
        size_t first = i % row + (end ? (side - 1) * inner : 0); // the place on the face with the lowest other index
        for (int k = 0; k < 3; k++) {
            double wa = v->rational ? v->coef[3 * n + i] : 1.0, wb = v->rational ? v->coef[3 * n + first] : 1.0;
            if (!(fabs(v->coef[(size_t)k * n + i] / wa - v->coef[(size_t)k * n + first] / wb) <= tolerance))
                return false;
        }
    }
    return true;
}

// Whether the edge of the base is one point within the tolerance, and no pole.
static kn_status find_apex(kn_meet *m, kn_meet_chart *c, int var, int end, double tolerance)
{
    kn_spline base = {0};
    double lo, hi;
    c->apex[var][end] = false;
    kn_spline_domain(&c->volume, 2, &lo, &hi);
    if (c->pole[var][end] || !c->flat_weight || lo > 0.0 || hi < 0.0) return KN_OK;
    kn_status status = kn_spline_isoparametric(m->ctx, &base, &c->volume, 2, 0.0);
    kn_spline_domain(&c->volume, var, &lo, &hi);
    if (status == KN_OK) status = kn_spline_isoparametric(m->ctx, &base, &base, var, end ? hi : lo);
    size_t n = status == KN_OK ? kn_spline_count(&base) : 0;
    c->apex[var][end] = n > 0;
    for (size_t i = 0; i < 3 * n; i++) {
        const double *x = base.coef, *w = base.rational ? x + 3 * n : NULL;
        double y = x[i] / (w ? w[i % n] : 1.0), first = x[i - i % n] / (w ? w[0] : 1.0);
        if (!(fabs(y - first) <= tolerance)) c->apex[var][end] = false;
    }
    kn_spline_clear(m->ctx, &base);
    return status;
}

// ---- all of it ----

// The heights that the regions of a shell need, made symmetric about the base where the shell allows that: a
// neighbour across an edge may count them the other way round.
static bool heights(const kn_meet *m, double w[2], const kn_shell *shell, int index)
{
    double limit[2];
    bool any = false;
    kn_shell_heights(shell, limit);
    w[0] = INFINITY, w[1] = -INFINITY;
    for (size_t r = 0; r < m->nregions; r++) {
        if (m->regions[r].shell != index) continue;
        any = true;
        w[0] = fmin(w[0], m->regions[r].lo[2]);
        w[1] = fmax(w[1], m->regions[r].hi[2]);
    }
    if (!any) w[0] = 0.0, w[1] = limit[1] < INFINITY ? limit[1] : 1.0;
    double most = fmax(fabs(w[0]), fabs(w[1]));
    w[0] = fmax(-most, limit[0]);
    w[1] = fmin(most, limit[1]);
    return w[0] < w[1];
}

kn_status kn_meet_charts(kn_meet *m, const kn_shell *const *shells, int nshells)
{
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    m->charts = kn_alloc_zero(m->ctx, (size_t)nshells, sizeof *m->charts);
    if (!m->charts) return KN_ENOMEM;
    m->ncharts = nshells;
    for (int s = 0; s < nshells; s++) {
        kn_meet_chart *c = &m->charts[s];
        double w[2], a[3], b[3];
        if (!heights(m, w, shells[s], s))
            return kn_fail(m->ctx, KN_EDOMAIN, "self-intersection: shell %d has no height", s);
        kn_status status = kn_shell_volume(m->ctx, &c->volume, shells[s], w[0], w[1]);
        if (status == KN_OK) status = cut(m, c);
        if (status == KN_OK) status = find_jumps(m, c);
        if (status == KN_OK) status = kn_spline_box(m->ctx, a, b, &c->volume);
        if (status != KN_OK) return status;
        c->flat_weight = is_flat(c);
        for (int k = 0; k < 3; k++) lo[k] = fmin(lo[k], a[k]), hi[k] = fmax(hi[k], b[k]);
    }
    m->whole = sqrt((hi[0] - lo[0]) * (hi[0] - lo[0]) + (hi[1] - lo[1]) * (hi[1] - lo[1]) +
                    (hi[2] - lo[2]) * (hi[2] - lo[2]));
    m->resolution *= m->whole;
    if (!(m->whole > 0.0 && m->whole < INFINITY))
        return kn_fail(m->ctx, KN_EDOMAIN, "self-intersection: images of size %g", m->whole);
    for (int s = 0; s < nshells; s++)
        for (int e = 0; e < 4; e++) {
            double tolerance = 0.01 * m->resolution;
            m->charts[s].pole[e / 2][e % 2] = is_pole(&m->charts[s], e / 2, e % 2, tolerance);
            kn_status status = find_apex(m, &m->charts[s], e / 2, e % 2, tolerance);
            if (status != KN_OK) return status;
        }
    return KN_OK;
}

void kn_meet_clear(kn_meet *m)
{
    for (int s = 0; s < m->ncharts && m->charts; s++) {
        kn_meet_chart *c = &m->charts[s];
        for (size_t i = 0; i < c->npieces; i++) kn_bezier_clear(m->ctx, &c->pieces[i]);
        kn_free(m->ctx, c->pieces);
        kn_spline_clear(m->ctx, &c->volume);
        for (int d = 0; d < 3; d++) kn_free(m->ctx, c->breaks[d]);
        for (int d = 0; d < 2; d++) kn_free(m->ctx, c->jump[d]);
    }
    kn_free(m->ctx, m->charts);
    kn_free(m->ctx, m->glues);
    kn_free(m->ctx, m->nodes);
    kn_free(m->ctx, m->regions);
}

kn_status kn_meet_point(kn_meet *m, double point[3], double partials[9], int chart, const double uvw[3])
{
    const kn_spline *v = &m->charts[chart].volume;
    double all[12];
    kn_status status = partials ? kn_spline_derivatives(m->ctx, all, v, uvw, 1) : kn_spline_eval(m->ctx, all, v, uvw);
    if (status != KN_OK) return status;
    memcpy(point, all, 3 * sizeof *point);
    if (partials) memcpy(partials, all + 3, 9 * sizeof *partials);
    return KN_OK;
}

// The right-hand one at a break.
static int piece_of(const kn_meet_chart *c, int var, double x)
{
    int lo = 0, hi = c->nbreaks[var] - 2;
    while (lo < hi) {
        int mid = (lo + hi + 1) / 2;
        if (c->breaks[var][mid] <= x)
            lo = mid;
        else
            hi = mid - 1;
    }
    return lo;
}

void kn_meet_overlap(const kn_meet_chart *c, int var, double lo, double hi, int *first, int *last)
{
    *first = piece_of(c, var, lo);
    *last = piece_of(c, var, hi);
    if (*last > *first && c->breaks[var][*last] >= hi) --*last;
}

kn_status kn_meet_restrict(kn_meet *m, kn_meet_patch *out, double from[3], double to[3], int chart, const int at[3],
                           const double lo[3], const double hi[3])
{
    const kn_meet_chart *c = &m->charts[chart];
    const kn_bezier *b = &c->pieces[piece_index(c, at[0], at[1], at[2])];
    double x[3], y[3];
    for (int d = 0; d < 3; d++) {
        double start = c->breaks[d][at[d]], span = c->breaks[d][at[d] + 1] - start;
        // outwards by more than the rounding of the quotient
        x[d] = lo[d] <= start ? 0.0 : fmin(fmax((lo[d] - start) / span - 0x1p-49, 0.0), 1.0);
        y[d] = hi[d] >= start + span ? 1.0 : fmin(fmax((hi[d] - start) / span + 0x1p-49, 0.0), 1.0);
        // slivers, which rounding may make, are taken thicker than they are
        if (y[d] - x[d] < 0x1p-24) x[d] = fmax(0.0, x[d] - 0x1p-24), y[d] = fmin(1.0, y[d] + 0x1p-24);
        from[d] = start + x[d] * span, to[d] = start + y[d] * span;
    }
    *out = (kn_meet_patch){.net = kn_net_make(3, b->ncomp, b->degree), .rational = b->rational};
    size_t size = out->net.count * (size_t)b->ncomp;
    memcpy(out->error, c->error, sizeof out->error);
    out->coef = kn_scratch(m->ctx, size, sizeof *out->coef);
    kn_mark mark = kn_scratch_mark(m->ctx);
    double *work = kn_scratch(m->ctx, size, sizeof *work);
    if (!out->coef || !work) return KN_ENOMEM;
    kn_net_restrict(out->coef, out->error, &out->net, b->coef, x, y, work);
    kn_scratch_release(m->ctx, mark);
    return KN_OK;
}
