// SPDX-License-Identifier: Apache-2.0
// Two places with one image: Newton's method on T(a) - T(b) = 0, by the shortest step, inside the regions.
#include "fold/meet.h"

#include <string.h>

enum { STEPS = 40 };

typedef struct search {
    kn_meet *m;
    int chart[2];
    double x[2][3], lo[2][3], hi[2][3];
    double unit[2][3]; // a parameter's length in space
    double point[2][3], slope[2][9];
    bool keep; // the component of b - a along `along`, in units, stays `distance`
    double along[3], distance;
} search;

static double norm3(const double *x)
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

static kn_status look(search *s)
{
    for (int i = 0; i < 2; i++) {
        kn_status status = kn_meet_point(s->m, s->point[i], s->slope[i], s->chart[i], s->x[i]);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

static double gap(const search *s)
{
    double d[3];
    for (int k = 0; k < 3; k++) d[k] = s->point[0][k] - s->point[1][k];
    return norm3(d);
}

// g x = f by elimination with pivots, n <= 4; false when it is singular to working precision.
static bool eliminate(double *x, double g[4][4], const double *f, int n)
{
    double a[4][5];
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) a[i][j] = g[i][j];
        a[i][n] = f[i];
    }
    for (int c = 0; c < n; c++) {
        int p = c;
        for (int i = c + 1; i < n; i++)
            if (fabs(a[i][c]) > fabs(a[p][c])) p = i;
        if (!(fabs(a[p][c]) > 0.0)) return false;
        for (int j = 0; j <= n; j++) {
            double t = a[c][j];
            a[c][j] = a[p][j], a[p][j] = t;
        }
        for (int i = c + 1; i < n; i++)
            for (int j = n; j >= c; j--) a[i][j] -= a[i][c] / a[c][c] * a[c][j];
    }
    for (int i = n - 1; i >= 0; i--) {
        x[i] = a[i][n];
        for (int j = i + 1; j < n; j++) x[i] -= a[i][j] * x[j];
        x[i] /= a[i][i];
    }
    return true;
}

// The shortest step, in lengths, of the variables that are free.
static bool find_step(double step[6], const search *s, const bool *fixed)
{
    double row[4][6] = {{0}}, g[4][4], f[4], y[4], trace = 0.0;
    int n = s->keep ? 4 : 3;
    for (int v = 0; v < 6; v++) {
        int i = v / 3, d = v % 3;
        double sign = i ? -1.0 : 1.0;
        if (fixed[v]) continue;
        for (int k = 0; k < 3; k++) row[k][v] = sign * s->slope[i][3 * d + k] / s->unit[i][d];
        row[3][v] = -sign * s->along[d];
    }
    f[3] = -s->distance;
    for (int k = 0; k < 3; k++) {
        f[k] = s->point[0][k] - s->point[1][k];
        f[3] += s->along[k] * (s->x[1][k] - s->x[0][k]) * s->unit[0][k];
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            g[i][j] = 0.0;
            for (int v = 0; v < 6; v++) g[i][j] += row[i][v] * row[j][v];
            if (i == j) trace += g[i][i];
        }
    for (int i = 0; i < n; i++) g[i][i] += 1e-13 * trace;
    if (!eliminate(y, g, f, n)) return false;
    for (int v = 0; v < 6; v++) {
        step[v] = 0.0;
        for (int i = 0; i < n; i++) step[v] -= row[i][v] * y[i];
    }
    return true;
}

// One step inside the boxes: a variable that would leave its end stays there, and the others do without it.
static bool advance(search *s)
{
    bool fixed[6] = {false};
    double step[6], most = 0.0;
    for (int round = 0; round < 7; round++) {
        bool again = false;
        if (!find_step(step, s, fixed)) return false;
        for (int v = 0; v < 6; v++) {
            double x = s->x[v / 3][v % 3];
            bool out = (step[v] < 0.0 && x <= s->lo[v / 3][v % 3]) || (step[v] > 0.0 && x >= s->hi[v / 3][v % 3]);
            if (!fixed[v] && out) fixed[v] = again = true;
        }
        if (!again) break;
    }
    for (int v = 0; v < 6; v++) most = fmax(most, fabs(step[v]));
    double share = most > 0.2 * s->m->whole ? 0.2 * s->m->whole / most : 1.0;
    if (!(most < INFINITY)) return false;
    for (int v = 0; v < 6; v++) {
        double *x = &s->x[v / 3][v % 3];
        *x = fmin(fmax(*x + share * step[v] / s->unit[v / 3][v % 3], s->lo[v / 3][v % 3]), s->hi[v / 3][v % 3]);
    }
    return true;
}

// ---- whether two places are one ----

// A parameter's length in space at a place: the longest over the heights there are.
static kn_status lengths(kn_meet *m, double out[3], int chart, const double at[3])
{
    const kn_meet_chart *c = &m->charts[chart];
    double w[3] = {at[2], c->breaks[2][0], c->breaks[2][c->nbreaks[2] - 1]}, p[3], slope[9];
    out[0] = out[1] = out[2] = 0.0;
    for (int i = 0; i < 3; i++) {
        const double x[3] = {at[0], at[1], w[i]};
        kn_status status = kn_meet_point(m, p, slope, chart, x);
        if (status != KN_OK) return status;
        for (int d = 0; d < 3; d++) out[d] = fmax(out[d], norm3(slope + 3 * d));
    }
    return KN_OK;
}

static double at_end(const kn_meet_chart *c, int var, int end)
{
    return c->breaks[var][end ? c->nbreaks[var] - 1 : 0];
}

// The length of a way from a to b across a glued edge.
static double way_across(const search *s, const kn_meet_glue *g, int first, double l[2][3])
{
    const kn_meet_chart *c[2] = {&s->m->charts[s->chart[0]], &s->m->charts[s->chart[1]]};
    double way = 0.0, part[2];
    for (int i = 0; i < 2; i++) {
        int e = i ? 1 - first : first, x = g->var[e], t = 1 - x;
        way += fabs(s->x[i][x] - at_end(c[i], x, g->end[e])) * l[i][x];
        part[i] = (s->x[i][t] - at_end(c[i], t, 0)) / (at_end(c[i], t, 1) - at_end(c[i], t, 0));
    }
    int t = 1 - g->var[first];
    if (g->reversed) part[1] = 1.0 - part[1];
    way += fabs(part[0] - part[1]) * (at_end(c[0], t, 1) - at_end(c[0], t, 0)) * l[0][t];
    if (g->jump < INFINITY) return way + fabs(s->x[0][2] - g->flip * s->x[1][2]) * l[0][2];
    return way + fabs(s->x[0][2]) * l[0][2] + fabs(s->x[1][2]) * l[1][2];
}

// A corner of a chart or an edge that is one point, and how far it is from a place.
typedef struct tip {
    double point[3], reach;
} tip;

static kn_status find_tips(kn_meet *m, tip out[8], int *n, int chart, const double x[3], const double l[3])
{
    const kn_meet_chart *c = &m->charts[chart];
    *n = 0;
    for (int k = 0; k < 8; k++) {
        int d = k / 2 % 2, e = k % 2;
        double at[3] = {at_end(c, 0, d), at_end(c, 1, e), fmax(c->breaks[2][0], 0.0)}, away[2];
        if (k >= 4) at[d] = at_end(c, d, e), at[1 - d] = x[1 - d];
        if (k >= 4 && !c->pole[d][e] && !c->apex[d][e]) continue;
        for (int i = 0; i < 2; i++) away[i] = fabs(x[i] - at[i]) * l[i];
        tip *t = &out[(*n)++];
        t->reach = away[0] + away[1] + (k >= 4 && c->apex[d][e] ? fabs(x[2]) * l[2] : 0.0);
        kn_status status = kn_meet_point(m, t->point, NULL, chart, at);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

// The length of a way through a corner, a pole or an apex that both have.
static kn_status way_around(double *way, search *s, double l[2][3])
{
    tip tips[2][8];
    int n[2];
    for (int i = 0; i < 2; i++) {
        kn_status status = find_tips(s->m, tips[i], &n[i], s->chart[i], s->x[i], l[i]);
        if (status != KN_OK) return status;
    }
    double up = fmin(fabs(s->x[0][2] - s->x[1][2]), fabs(s->x[0][2] + s->x[1][2])) * l[0][2];
    for (int j = 0; j < n[0]; j++)
        for (int k = 0; k < n[1]; k++) {
            double d[3];
            for (int c = 0; c < 3; c++) d[c] = tips[0][j].point[c] - tips[1][k].point[c];
            if (norm3(d) <= s->m->resolution) *way = fmin(*way, tips[0][j].reach + tips[1][k].reach + up);
        }
    return KN_OK;
}

// *way = the length, about, of the shortest way from a to b along the shells, as far as short ones go.
static kn_status find_way(double *way, search *s)
{
    double l[2][3];
    kn_status status = lengths(s->m, l[0], s->chart[0], s->x[0]);
    if (status == KN_OK) status = lengths(s->m, l[1], s->chart[1], s->x[1]);
    if (status != KN_OK) return status;
    *way = INFINITY;
    if (s->chart[0] == s->chart[1]) {
        *way = 0.0;
        for (int d = 0; d < 3; d++) *way += fabs(s->x[0][d] - s->x[1][d]) * fmax(l[0][d], l[1][d]);
    }
    for (size_t i = 0; i < s->m->nglues; i++)
        for (int first = 0; first < 2; first++) {
            const kn_meet_glue *g = &s->m->glues[i];
            if (g->chart[first] == s->chart[0] && g->chart[1 - first] == s->chart[1])
                *way = fmin(*way, way_across(s, g, first, l));
        }
    return way_around(way, s, l);
}

// ---- the search ----

static kn_status start(search *s, int a, int b)
{
    const kn_meet_node *n[2] = {&s->m->nodes[a], &s->m->nodes[b]};
    double length = 0.0;
    bool close = n[0]->chart == n[1]->chart;
    for (int i = 0; i < 2; i++) {
        s->chart[i] = n[i]->chart;
        for (int d = 0; d < 3; d++) {
            s->x[i][d] = 0.5 * n[i]->lo[d] + 0.5 * n[i]->hi[d];
            s->lo[i][d] = s->m->regions[n[i]->region].lo[d], s->hi[i][d] = s->m->regions[n[i]->region].hi[d];
        }
        kn_status status = lengths(s->m, s->unit[i], s->chart[i], s->x[i]);
        if (status != KN_OK) return status;
        for (int d = 0; d < 3; d++) s->unit[i][d] = fmax(s->unit[i][d], 1e-12 * s->m->whole);
    }
    for (int d = 0; d < 3; d++) {
        double x = n[0]->hi[d] - n[0]->lo[d] + n[1]->hi[d] - n[1]->lo[d];
        s->along[d] = (s->x[1][d] - s->x[0][d]) * s->unit[0][d];
        close = close && fabs(s->x[1][d] - s->x[0][d]) <= 4.0 * x;
        length += s->along[d] * s->along[d];
    }
    s->distance = sqrt(length);
    s->keep = close && s->distance > 0.0;
    for (int d = 0; d < 3 && s->keep; d++) s->along[d] /= s->distance, s->unit[1][d] = s->unit[0][d];
    return KN_OK;
}

// Newton's method; *now: the gap that it leaves.
static kn_status approach(search *s, double *now)
{
    kn_status status = look(s);
    double before = INFINITY, goal = 1e-14 * s->m->whole;
    *now = gap(s);
    for (int step = 0; step < STEPS && status == KN_OK && *now > goal; step++) {
        if (step > 8 && !(*now < 0.9 * before)) break;
        before = *now;
        if (!advance(s)) break;
        status = look(s);
        *now = gap(s);
    }
    return status;
}

// Where the shells meet at an angle the shortest steps may end on the common edge, where the two places are one. From
// there to half of the heights, and as far away from the edge: false where there is no such edge.
static bool leave_edge(search *s)
{
    for (size_t i = 0; i < 2 * s->m->nglues; i++) {
        const kn_meet_glue *g = &s->m->glues[i / 2];
        int first = (int)(i % 2);
        if (g->jump < INFINITY || g->chart[first] != s->chart[0] || g->chart[1 - first] != s->chart[1]) continue;
        for (int k = 0; k < 2; k++) {
            int e = k ? 1 - first : first, var = g->var[e];
            double lo = s->lo[k][2], hi = s->hi[k][2], w = 0.5 * (fabs(lo) > fabs(hi) ? lo : hi);
            double at = at_end(&s->m->charts[s->chart[k]], var, g->end[e]), away = fabs(w);
            away *= s->unit[k][2] / s->unit[k][var];
            s->x[k][2] = w;
            s->x[k][var] = fmin(fmax(g->end[e] ? at - away : at + away, s->lo[k][var]), s->hi[k][var]);
        }
        return true;
    }
    return false;
}

kn_status kn_meet_witness(kn_meet *m, kn_fold_intersection *out, bool *found, int a, int b)
{
    search s = {.m = m};
    double way = 0.0, now;
    *found = false;
    kn_status status = start(&s, a, b);
    if (status == KN_OK) status = approach(&s, &now);
    if (status != KN_OK || !(now <= 1e-11 * m->whole)) return status;
    status = find_way(&way, &s);
    if (status == KN_OK && !(way > 10.0 * m->resolution) && leave_edge(&s)) {
        status = approach(&s, &now);
        if (status != KN_OK || !(now <= 1e-11 * m->whole)) return status;
        status = find_way(&way, &s);
    }
    if (status != KN_OK || !(way > 10.0 * m->resolution)) return status;
    *found = true;
    out->verdict = KN_FOLD_FOUND;
    out->gap = now;
    out->a.shell = s.chart[0], out->b.shell = s.chart[1];
    for (int d = 0; d < 3; d++) {
        out->a.lo[d] = out->a.hi[d] = s.x[0][d];
        out->b.lo[d] = out->b.hi[d] = s.x[1][d];
        out->point[d] = 0.5 * s.point[0][d] + 0.5 * s.point[1][d];
    }
    return KN_OK;
}
