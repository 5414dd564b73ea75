// SPDX-License-Identifier: Apache-2.0
// Which edges of the shells are the same places: seams of one shell, common edges of two.
#include "fold/meet.h"

#include <string.h>

// The face of T over one edge, in (along, w) over [0,1] along the edge.
static kn_status make_face(kn_meet *m, kn_spline *out, const kn_meet_chart *c, int var, int end)
{
    double lo, hi;
    kn_spline_domain(&c->volume, var, &lo, &hi);
    kn_status status = kn_spline_isoparametric(m->ctx, out, &c->volume, var, end ? hi : lo);
    return status == KN_OK ? kn_spline_reparameterize(m->ctx, out, out, 0, 0.0, 1.0) : status;
}

// *jump = a bound of |a - b| over their common domain.
static kn_status distance(kn_meet *m, double *jump, const kn_spline *a, const kn_spline *b)
{
    kn_spline d = {0};
    double lo[3], hi[3], sum = 0.0;
    *jump = INFINITY;
    kn_status status = kn_spline_difference(m->ctx, &d, a, b);
    if (status == KN_OK) status = kn_spline_box(m->ctx, lo, hi, &d);
    for (int k = 0; k < 3 && status == KN_OK; k++) {
        double x = fmax(fabs(lo[k]), fabs(hi[k]));
        sum += x * x;
    }
    if (status == KN_OK) *jump = sqrt(sum) * (1.0 + 0x1p-40);
    kn_spline_clear(m->ctx, &d);
    return status;
}

static kn_status add_glue(kn_meet *m, const kn_meet_glue *glue)
{
    if (m->nglues == m->room_glues) {
        size_t room = 2 * m->room_glues + 16;
        void *more = kn_resize(m->ctx, m->glues, room, sizeof *m->glues);
        if (!more) return KN_ENOMEM;
        m->glues = more, m->room_glues = room;
    }
    m->glues[m->nglues++] = *glue;
    return KN_OK;
}

// The common heights of two faces, b's counted in reverse when flip is negative.
static bool common_heights(double w[2], const kn_spline *a, const kn_spline *b, double flip)
{
    double lo, hi;
    kn_spline_domain(a, 1, &w[0], &w[1]);
    kn_spline_domain(b, 1, &lo, &hi);
    if (flip < 0.0) {
        double t = lo;
        lo = -hi, hi = -t;
    }
    w[0] = fmax(w[0], lo);
    w[1] = fmin(w[1], hi);
    return w[0] < w[1];
}

// b over [0,1] and the heights w, turned so that it runs as a does.
static kn_status turn(kn_meet *m, kn_spline *out, const kn_spline *b, bool reversed, double flip, const double w[2])
{
    double lo[2] = {0.0, flip > 0.0 ? w[0] : -w[1]}, hi[2] = {1.0, flip > 0.0 ? w[1] : -w[0]};
    kn_status status = kn_spline_restrict(m->ctx, out, b, lo, hi);
    if (status == KN_OK && reversed) status = kn_spline_reverse(m->ctx, out, out, 0);
    if (status == KN_OK && flip < 0.0) {
        status = kn_spline_reverse(m->ctx, out, out, 1);
        if (status == KN_OK) status = kn_spline_reparameterize(m->ctx, out, out, 1, w[0], w[1]);
    }
    return status;
}

// The faces a and b in this position: *jump is their distance where they are the same but for the tolerance.
static kn_status compare(kn_meet *m, double *jump, const kn_spline *a, const kn_spline *b, bool reversed, double flip)
{
    double w[2];
    kn_spline x = {0}, y = {0};
    *jump = INFINITY;
    if (!common_heights(w, a, b, flip)) return KN_OK;
    const double lo[2] = {0.0, w[0]}, hi[2] = {1.0, w[1]};
    kn_status status = kn_spline_restrict(m->ctx, &x, a, lo, hi);
    if (status == KN_OK) status = turn(m, &y, b, reversed, flip, w);
    if (status == KN_OK) status = distance(m, jump, &x, &y);
    kn_spline_clear(m->ctx, &x);
    kn_spline_clear(m->ctx, &y);
    return status;
}

// *jump: the distance of the two edges of the bases (heights 0).
static kn_status base_jump(kn_meet *m, double *jump, const kn_spline *a, const kn_spline *b, bool reversed)
{
    kn_spline x = {0}, y = {0};
    *jump = INFINITY;
    kn_status status = kn_spline_isoparametric(m->ctx, &x, a, 1, 0.0);
    if (status == KN_OK) status = kn_spline_isoparametric(m->ctx, &y, b, 1, 0.0);
    if (status == KN_OK && reversed) status = kn_spline_reverse(m->ctx, &y, &y, 0);
    if (status == KN_OK) status = distance(m, jump, &x, &y);
    *jump += 0x1p-44 * m->whole; // more than the rounding of the two isoparametric curves
    kn_spline_clear(m->ctx, &x);
    kn_spline_clear(m->ctx, &y);
    return status;
}

typedef struct edge {
    int chart, var, end;
    kn_spline face;
    double tip[2][3]; // the base at its ends
    bool pole;
} edge;

static bool is_near(const kn_meet *m, const double *a, const double *b)
{
    double s = 0.0;
    for (int k = 0; k < 3; k++) s += (a[k] - b[k]) * (a[k] - b[k]);
    return sqrt(s) <= m->resolution;
}

static kn_status join(kn_meet *m, const edge *a, const edge *b)
{
    for (int reversed = 0; reversed < 2; reversed++) {
        bool any = false;
        double base;
        kn_status status = KN_OK;
        if (!is_near(m, a->tip[0], b->tip[reversed]) || !is_near(m, a->tip[1], b->tip[1 - reversed])) continue;
        status = base_jump(m, &base, &a->face, &b->face, reversed);
        if (status != KN_OK) return status;
        if (!(base <= m->resolution)) continue;
        kn_meet_glue g = {.chart = {a->chart, b->chart},
                          .var = {a->var, b->var},
                          .end = {a->end, b->end},
                          .reversed = reversed,
                          .base = base};
        for (int flip = 0; flip < 2 && status == KN_OK; flip++) {
            g.flip = flip ? -1.0 : 1.0;
            status = compare(m, &g.jump, &a->face, &b->face, reversed, g.flip);
            if (status != KN_OK || !(g.jump <= m->resolution)) continue;
            any = true;
            status = add_glue(m, &g);
        }
        if (status == KN_OK && !any) {
            g.flip = 1.0, g.jump = INFINITY;
            status = add_glue(m, &g);
        }
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

static kn_status find_edge(kn_meet *m, edge *e)
{
    kn_status status = make_face(m, &e->face, &m->charts[e->chart], e->var, e->end);
    for (int i = 0; i < 2 && status == KN_OK; i++) {
        const double at[2] = {i, 0.0};
        status = kn_spline_eval(m->ctx, e->tip[i], &e->face, at);
    }
    e->pole = m->charts[e->chart].pole[e->var][e->end];
    return status;
}

kn_status kn_meet_glues(kn_meet *m)
{
    size_t n = 4 * (size_t)m->ncharts;
    kn_status status = KN_OK;
    edge *edges = kn_alloc_zero(m->ctx, n, sizeof *edges);
    if (!edges) return KN_ENOMEM;
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        edges[i].chart = (int)(i / 4), edges[i].var = (int)(i / 2 % 2), edges[i].end = (int)(i % 2);
        status = find_edge(m, &edges[i]);
    }
    for (size_t i = 0; i < n && status == KN_OK; i++)
        for (size_t j = i + 1; j < n && status == KN_OK; j++)
            if (!edges[i].pole && !edges[j].pole) status = join(m, &edges[i], &edges[j]);
    for (size_t i = 0; i < n; i++) kn_spline_clear(m->ctx, &edges[i].face);
    kn_free(m->ctx, edges);
    return status;
}
