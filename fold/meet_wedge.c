// SPDX-License-Identifier: Apache-2.0
// Two shells that have an edge of their bases in common, at an angle, and nothing else near it.
//
// Let both edges be the curve C. With v the distance of a place from the edge and w its height, both in parts of its
// box, T = C(s) + v a + w b with a and b means of values of T_v and T_w, and C(s) - C(s') = (s - s') c with c one of
// C'. So two places have one image only where (s - s') c + v a + w b = v' a' + w' b'. A functional that vanishes at
// c, is positive at all a and b and negative at all a' and b' leaves v = w = v' = w' = 0. m - (m.c / e.c) e is one
// for each c when |m.c| <= k e.c, m.x > k |e.x| for all a and b, -m.x > k |e.x| for all a' and b'. Where the edges
// are the same within j only, the distances are at most j (1 + k) / the least of those functionals, for unit m and e.
// Where the edge ends at a pole or an apex a is itself a multiple of the distance from there: that is divided out.
#include "fold/meet_slopes.h"

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool make_unit(double *v)
{
    double length = sqrt(dot(v, v));
    for (int k = 0; k < 3; k++) v[k] /= length;
    return length > 0.0 && isfinite(1.0 / length);
}

// The columns: 0 along the edge, 1 and 2 away from it and up in the first box, 3 and 4 in the second.
enum { ALONG, COLUMNS = 5 };

// Unit e, the mean direction of the edge, and unit m across it, halving the angle between the two shells.
static bool choose(double e[3], double m[3], const kn_meet_hull *h)
{
    double mean[COLUMNS][3] = {{0}}, side[2][3] = {{0}};
    for (const kn_meet_vectors *v = h->list; v; v = v->next)
        for (size_t k = 0; k < v->n; k++)
            for (size_t c = 0; c < 3; c++) mean[v->column][c] += v->x[c * v->n + k];
    if (!make_unit(mean[ALONG])) return false;
    for (int k = 0; k < 3; k++) e[k] = mean[ALONG][k];
    for (int i = 1; i < COLUMNS; i++) {
        double t = dot(mean[i], e);
        for (int k = 0; k < 3; k++) mean[i][k] -= t * e[k];
        if (!make_unit(mean[i])) return false;
        for (int k = 0; k < 3; k++) side[(i - 1) / 2][k] += mean[i][k];
    }
    if (!make_unit(side[0]) || !make_unit(side[1])) return false;
    for (int k = 0; k < 3; k++) m[k] = side[0][k] - side[1][k];
    return make_unit(m);
}

// What f.x may be beside what it is computed as, for the vectors of a list.
static double error_of(const kn_meet_vectors *v, const double *f)
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++) sum += fabs(f[c]) * (v->error[c] + kn_rounding(16.0) * v->size[c]);
    return sum * (1.0 + 0x1p-40);
}

static double length_of(const kn_meet_vectors *v)
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++) sum += (v->size[c] + v->error[c]) * (v->size[c] + v->error[c]);
    return sqrt(sum) * (1.0 + 0x1p-40);
}

static bool parts_them(const kn_meet_hull *h)
{
    double e[3], m[3], tilt = 0.0, stretch = 0.0, least = INFINITY, reach = 0.0;
    if (!choose(e, m, h)) return false;
    for (const kn_meet_vectors *v = h->list; v; v = v->next) {
        if (v->column != ALONG) continue;
        double em = error_of(v, m), ee = error_of(v, e);
        for (size_t k = 0; k < v->n; k++) {
            const double x[3] = {v->x[k], v->x[v->n + k], v->x[2 * v->n + k]};
            double along = (dot(e, x) - ee) * (1.0 - 0x1p-40);
            if (!(along > 0.0)) return false;
            tilt = fmax(tilt, (fabs(dot(m, x)) + em) / along);
            stretch = fmax(stretch, length_of(v) / along);
        }
    }
    tilt *= 1.0 + 0x1p-40;
    for (const kn_meet_vectors *v = h->list; v; v = v->next) {
        if (v->column == ALONG) continue;
        double em = error_of(v, m), ee = error_of(v, e), side = v->column < 3 ? 1.0 : -1.0;
        for (size_t k = 0; k < v->n; k++) {
            const double x[3] = {v->x[k], v->x[v->n + k], v->x[2 * v->n + k]};
            least = fmin(least, side * dot(m, x) - em - (fabs(dot(e, x)) + ee) * tilt);
        }
        reach = fmax(reach, length_of(v));
    }
    if (!(least > 0.0)) return false;
    // the way from one place to the edge, along it, and to the other
    double away = 1.01 * h->jump * (1.0 + tilt) / least * reach;
    return away + 1.01 * stretch * (away + h->jump) <= h->m->resolution;
}

// 1: the box stands on the base, -1: it hangs from it, 0: neither.
static double stands(const kn_meet_node *n)
{
    return n->lo[2] == 0.0 ? 1.0 : n->hi[2] == 0.0 ? -1.0 : 0.0;
}

static bool is_at(const kn_meet_chart *c, const kn_meet_node *n, int var, int end)
{
    return end ? n->hi[var] >= c->breaks[var][c->nbreaks[var] - 1] : n->lo[var] <= c->breaks[var][0];
}

static kn_meet_part part_of(const kn_meet_chart *c, const kn_meet_node *n, int var, int end, int first)
{
    kn_meet_part p = {.chart = n->chart, .pole = -1, .tip = -1, .lift = 1.0};
    for (int e = 0; e < 2; e++)
        if ((c->pole[1 - var][e] || c->apex[1 - var][e]) && is_at(c, n, 1 - var, e)) p.tip = 1 - var, p.tip_end = e;
    for (int d = 0; d < 3; d++) p.lo[d] = n->lo[d], p.hi[d] = n->hi[d], p.scale[d] = n->hi[d] - n->lo[d];
    p.scale[var] *= end ? -1.0 : 1.0;
    p.scale[2] *= stands(n);
    p.column[var] = first, p.column[1 - var] = ALONG, p.column[2] = first + 1;
    return p;
}

kn_status kn_meet_wedge(kn_meet *m, bool *apart, const kn_meet_node *a, const kn_meet_node *b, const kn_meet_glue *g,
                        int first)
{
    const int second = 1 - first, ta = 1 - g->var[first], tb = 1 - g->var[second];
    const kn_meet_chart *ca = &m->charts[a->chart], *cb = &m->charts[b->chart];
    kn_meet_hull h = {.m = m, .fits = true, .jump = g->base};
    if (!is_at(ca, a, g->var[first], g->end[first]) || !is_at(cb, b, g->var[second], g->end[second])) return KN_OK;
    if (stands(a) == 0.0 || stands(b) == 0.0) return KN_OK;
    kn_meet_part p = part_of(ca, a, g->var[first], g->end[first], 1),
                 q = part_of(cb, b, g->var[second], g->end[second], 3);
    double t0 = ca->breaks[ta][0], la = ca->breaks[ta][ca->nbreaks[ta] - 1] - t0, s0 = cb->breaks[tb][0],
           lb = cb->breaks[tb][cb->nbreaks[tb] - 1] - s0;
    double lo = (b->lo[tb] - s0) / lb, hi = (b->hi[tb] - s0) / lb;
    if (g->reversed) {
        double t = lo;
        lo = 1.0 - hi, hi = 1.0 - t;
    }
    lo = t0 + la * lo, hi = t0 + la * hi;
    // C has to be known from s to s': a is made to reach b, by more than the rounding of the map between the two
    double gap = fmax(lo - p.hi[ta], p.lo[ta] - hi), width = p.hi[ta] - p.lo[ta];
    if (gap > width + (hi - lo)) return KN_OK;
    p.lo[ta] = fmax(t0, fmin(p.lo[ta], hi) - 0x1p-49 * la);
    p.hi[ta] = fmin(t0 + la, fmax(p.hi[ta], lo) + 0x1p-49 * la);
    q.scale[tb] = width * (lb / la) * (g->reversed ? -1.0 : 1.0);
    kn_status status = kn_meet_add_part(&h, &p);
    if (status == KN_OK && h.fits) status = kn_meet_add_part(&h, &q);
    if (status == KN_OK && h.fits) *apart = parts_them(&h);
    m->hollow = !*apart;
    return status;
}
