// SPDX-License-Identifier: Apache-2.0
// T is injective on a convex domain where its derivative stays near one matrix.
//
// For places x, y of a convex domain H, on which T is continuous and piecewise smooth, T(y) - T(x) = M (y - x) with
// M a mean of values of DT along the segment. Let A M = 1 + E and |E| <= K, element by element, for all of H. From
// T(x) = T(y) follows |y - x| <= K |y - x|, and y = x when the spectral radius of K is below 1: when there is d > 0
// with K d < d. Where T jumps by at most j across a line, T(y) - T(x) = M (y - x) + j and
// |y - x| <= (1 - K)^-1 |A| j: places with one image are that near to each other, across that line.
//
// H lies in the parameters of one chart, or of two that a glue makes one. At a pole, where T_u = 0, H is a triangle:
// X is the distance from the pole, Y = X y, y across. With T - T_0(w) = X Q, in which the division is exact,
// T_Y = Q_y and T_X = (X Q)_X - y Q_y.
//
// At an apex T_u = 0 where v = 0 and w = 0, v the distance from it. With both in parts of the box and z = v + k w the
// domain |Y| <= z, Y = z y, is convex, too. T_Y = T_y / z is a mean of values of T_yv and T_yw / k, as T_y is v times
// one of T_yv and w times one of T_yw; T_v and T_w become T_v - y T_Y and T_w - k y T_Y.
#include "fold/meet_slopes.h"

static bool invert(double out[3][3], double in[3][3])
{
    double det = 0.0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            out[i][j] = in[a][c] * in[b][d] - in[a][d] * in[b][c];
            if (j == 0) det += out[i][0] * in[0][i];
        }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) out[i][j] /= det;
    return isfinite(1.0 / det) && isfinite(det);
}

// Sums of the rows of |A|: the units in which the parameters are, however thin or large the shell is.
static void row_sums(double out[3], double a[3][3])
{
    for (int i = 0; i < 3; i++) out[i] = fabs(a[i][0]) + fabs(a[i][1]) + fabs(a[i][2]);
}

// x with (1 - K) x >= g, x > 0, K >= 0, by the formula and checked; false when there is none. g in the units of x.
static bool majorant(double x[3], double k[3][3], const double g[3])
{
    double a[3][3], b[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            if (!(k[i][j] < 1e100)) return false;
            a[i][j] = (i == j) - k[i][j];
        }
    if (!invert(b, a)) return false;
    for (int i = 0; i < 3; i++) x[i] = (b[i][0] * g[0] + b[i][1] * g[1] + b[i][2] * g[2]) * (1.0 + 0x1p-20);
    for (int i = 0; i < 3; i++) {
        double right = (k[i][0] * x[0] + k[i][1] * x[1] + k[i][2] * x[2] + g[i]) * (1.0 + 0x1p-40);
        if (!(x[i] > 0.0 && x[i] < INFINITY && x[i] >= right && k[i][0] + k[i][1] + k[i][2] >= 0.0)) return false;
    }
    return true;
}

// The middle of the range of the vectors of each column.
static void middles(double mid[3][3], const kn_meet_hull *h)
{
    double lo[3][3], hi[3][3];
    for (int i = 0; i < 9; i++) lo[i / 3][i % 3] = INFINITY, hi[i / 3][i % 3] = -INFINITY;
    for (const kn_meet_vectors *v = h->list; v; v = v->next)
        for (size_t c = 0; c < 3; c++)
            for (size_t k = 0; k < v->n; k++) {
                lo[c][v->column] = fmin(lo[c][v->column], v->x[c * v->n + k]);
                hi[c][v->column] = fmax(hi[c][v->column], v->x[c * v->n + k]);
            }
    for (int i = 0; i < 9; i++) mid[i / 3][i % 3] = 0.5 * lo[i / 3][i % 3] + 0.5 * hi[i / 3][i % 3];
}

static bool holds(const kn_meet_hull *h)
{
    double mid[3][3], a[3][3], k[3][3] = {{0}}, x[3], unit[3], g[3], length = 0.0;
    middles(mid, h);
    if (!invert(a, mid)) return false;
    for (const kn_meet_vectors *v = h->list; v; v = v->next)
        for (int i = 0; i < 3; i++) {
            double most = 0.0, size = 0.0, error = 0.0;
            for (size_t p = 0; p < v->n; p++) {
                const double *y = v->x + p;
                double e = a[i][0] * y[0] + a[i][1] * y[v->n] + a[i][2] * y[2 * v->n];
                most = fmax(most, fabs(e - (i == v->column)));
            }
            for (size_t c = 0; c < 3; c++) {
                error += fabs(a[i][c]) * v->error[c];
                size += fabs(a[i][c]) * v->size[c];
            }
            k[i][v->column] = fmax(k[i][v->column],
                                   (most + error) * (1.0 + 0x1p-40) + kn_rounding(8.0) * (size + 1.0));
        }
    row_sums(unit, a);
    if (!majorant(x, k, unit)) return false;
    if (h->jump == 0.0) return true;
    for (int i = 0; i < 3; i++) g[i] = unit[i] * h->jump * (1.0 + 0x1p-40) + 0x1p-1000;
    if (!majorant(x, k, g)) return false;
    for (int d = 0; d < 3; d++)
        length += 2.0 * x[d] * sqrt(mid[0][d] * mid[0][d] + mid[1][d] * mid[1][d] + mid[2][d] * mid[2][d]);
    return length <= h->m->resolution;
}

// ---- H ----

static void edge_of(double *at, const kn_meet_chart *c, int var, int end)
{
    *at = c->breaks[var][end ? c->nbreaks[var] - 1 : 0];
}

// Makes the part a fan where its box touches a pole or an apex. across: y at its lo and hi.
static void open_fan(const kn_meet *m, kn_meet_part *p, double y0, double y1, double half)
{
    const kn_meet_chart *c = &m->charts[p->chart];
    bool stands = p->lo[2] == 0.0 || p->hi[2] == 0.0;
    p->pole = p->tip = -1;
    for (int d = 0; d < 2 && p->pole < 0 && p->tip < 0; d++)
        for (int e = 0; e < 2 && p->pole < 0 && p->tip < 0; e++) {
            double at;
            edge_of(&at, c, d, e);
            if (e ? p->hi[d] < at : p->lo[d] > at) continue;
            if (c->pole[d][e]) p->pole = d, p->pole_end = e;
            if (c->apex[d][e] && stands) p->tip = d, p->tip_end = e;
        }
    p->fan = p->tip >= 0;
    if (p->pole < 0 && p->tip < 0) return;
    int x = p->pole >= 0 ? p->pole : p->tip, y = 1 - x;
    p->across[0] = y0, p->across[1] = y1;
    p->scale[y] *= half;
    if (p->pole >= 0) p->scale[x] = fabs(p->scale[x]);
}

// Whether the criterion fails already at the corners and in the middle of H: a guess that spares most of the work. At
// each end of a variable that may choose its rates the partials are taken in units of their mean.
static kn_status looks_bent(kn_meet *m, bool *bent, const kn_meet_part *p)
{
    double slope[9][9], mean[3][3] = {{0}}, lo[9], hi[9], mid[3][3], a[3][3], k[3][3] = {{0}};
    double x[3], unit[3], point[3];
    for (int i = 0; i < 9; i++) {
        for (int d = 0; d < 3; d++) { // a little inside: the ends may be breaks, where the piece beyond would count
            double t = i == 8 ? 0.5 : i >> d & 1 ? 1.0 - 0x1p-20 : 0x1p-20;
            x[d] = p->lo[d] + t * (p->hi[d] - p->lo[d]);
        }
        kn_status status = kn_meet_point(m, point, slope[i], p->chart, x);
        if (status != KN_OK) return status;
        for (int d = 0; d < 3; d++) {
            const double *s = slope[i] + 3 * d;
            mean[d][i == 8 ? 2 : i >> d & 1] += sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) / (i == 8 ? 1.0 : 4.0);
        }
    }
    for (int e = 0; e < 9; e++) {
        lo[e] = INFINITY, hi[e] = -INFINITY;
        for (int i = 0; i < 9; i++) {
            int d = e / 3, side = i == 8 ? 2 : i >> d & 1;
            slope[i][e] *= d < 2 && mean[d][side] > 0.0 ? 1.0 / mean[d][side] : 1.0;
            lo[e] = fmin(lo[e], slope[i][e]), hi[e] = fmax(hi[e], slope[i][e]);
        }
        mid[e % 3][e / 3] = 0.5 * lo[e] + 0.5 * hi[e];
    }
    *bent = !invert(a, mid);
    for (int i = 0; i < 9 && !*bent; i++)
        for (int r = 0; r < 3; r++)
            for (int d = 0; d < 3; d++) {
                const double *s = slope[i] + 3 * d;
                double e = a[r][0] * s[0] + a[r][1] * s[1] + a[r][2] * s[2] - (r == d);
                k[r][d] = fmax(k[r][d], fabs(e));
            }
    row_sums(unit, a);
    *bent = *bent || !majorant(x, k, unit);
    return KN_OK;
}

// How much longer T_u is above an apex than beside it, at the ends of the box.
static kn_status set_lift(kn_meet *m, kn_meet_part *p)
{
    double at[2][3], point[3], slope[9], length[2] = {0.0};
    p->lift = 1.0;
    if (p->tip < 0) return KN_OK;
    int x = p->tip, u = 1 - x;
    double tip = p->tip_end ? p->hi[x] : p->lo[x], away = p->tip_end ? p->lo[x] : p->hi[x];
    for (int i = 0; i < 2; i++) {
        at[i][u] = 0.5 * p->lo[u] + 0.5 * p->hi[u];
        at[i][x] = i ? tip : away;
        at[i][2] = i && p->lo[2] == 0.0 ? p->hi[2] : i ? p->lo[2] : 0.0;
        kn_status status = kn_meet_point(m, point, slope, p->chart, at[i]);
        if (status != KN_OK) return status;
        for (int k = 0; k < 3; k++) length[i] += slope[3 * u + k] * slope[3 * u + k];
    }
    double lift = sqrt(length[1] / length[0]);
    if (lift > 1e-6 && lift < 1e6) p->lift = lift;
    return KN_OK;
}

// Boxes near an apex are made to reach it: what T_u shrinks by on the way does not count there.
static void reach_apex(const kn_meet_chart *c, int var, double *lo, double *hi, double *w0, double *w1)
{
    double height = *w0 >= 0.0 ? *w0 : *w1 <= 0.0 ? -*w1 : INFINITY;
    for (int e = 0; e < 2; e++) {
        double at;
        edge_of(&at, c, var, e);
        if (!c->apex[var][e] || (e ? at - *hi : *lo - at) > 4.0 * (*hi - *lo) || height > 4.0 * (*w1 - *w0)) continue;
        *(e ? hi : lo) = at;
        *(*w0 >= 0.0 ? w0 : w1) = 0.0;
    }
}

static kn_status within(kn_meet *m, bool *injective, const kn_meet_node *a, const kn_meet_node *b)
{
    kn_meet_part p = {.chart = a->chart, .column = {0, 1, 2}};
    kn_meet_hull h = {.m = m, .fits = true};
    for (int d = 0; d < 3; d++) {
        double la = a->hi[d] - a->lo[d], lb = b->hi[d] - b->lo[d];
        if (fmax(a->lo[d], b->lo[d]) - fmin(a->hi[d], b->hi[d]) > 0.3 * fmin(la, lb)) return KN_OK;
        p.lo[d] = fmin(a->lo[d], b->lo[d]);
        p.hi[d] = fmax(a->hi[d], b->hi[d]);
    }
    for (int d = 0; d < 2; d++) reach_apex(&m->charts[p.chart], d, &p.lo[d], &p.hi[d], &p.lo[2], &p.hi[2]);
    for (int d = 0; d < 3; d++) p.scale[d] = p.hi[d] - p.lo[d];
    open_fan(m, &p, -1.0, 1.0, 0.5);
    bool plain = p.pole < 0 && p.tip < 0;
    p.free[0] = p.free[1] = plain;
    bool bent = false;
    int spans[2];
    for (int d = 0; d < 2; d++) {
        int first, last;
        kn_meet_overlap(&m->charts[p.chart], d, p.lo[d], p.hi[d], &first, &last);
        spans[d] = last - first + 1;
    }
    kn_status status = set_lift(m, &p);
    if (status == KN_OK && plain && spans[0] * spans[1] > 2) status = looks_bent(m, &bent, &p);
    if (status == KN_OK && !bent)
        status = kn_meet_add_part(&h, &p);
    else
        h.fits = false;
    if (status == KN_OK && h.fits) *injective = holds(&h);
    return status;
}

// The parameters of a as they are, those of b across the glued edge: outwards from it, measured in a's lengths.
static kn_status across(kn_meet *m, bool *injective, const kn_meet_node *a, const kn_meet_node *b,
                        const kn_meet_glue *g, int first)
{
    const int second = 1 - first, xa = g->var[first], xb = g->var[second], ta = 1 - xa, tb = 1 - xb;
    const kn_meet_chart *ca = &m->charts[a->chart], *cb = &m->charts[b->chart];
    kn_meet_part p = {.chart = a->chart, .column = {0, 1, 2}}, q = {.chart = b->chart};
    kn_meet_hull h = {.m = m, .fits = g->jump < INFINITY, .jump = g->jump};
    double ea, eb, t0 = ca->breaks[ta][0], la = ca->breaks[ta][ca->nbreaks[ta] - 1] - t0, s0 = cb->breaks[tb][0],
                   lb = cb->breaks[tb][cb->nbreaks[tb] - 1] - s0, lo, hi, w0, w1;
    edge_of(&ea, ca, xa, g->end[first]);
    edge_of(&eb, cb, xb, g->end[second]);
    double da = g->end[first] ? ea - a->lo[xa] : a->hi[xa] - ea,
           db = g->end[second] ? eb - b->lo[xb] : b->hi[xb] - eb;
    if (da > 1.5 * (a->hi[xa] - a->lo[xa]) || db > 1.5 * (b->hi[xb] - b->lo[xb])) return KN_OK; // not at the edge
    lo = t0 + la * ((b->lo[tb] - s0) / lb), hi = t0 + la * ((b->hi[tb] - s0) / lb);
    if (g->reversed) {
        double t = lo;
        lo = 2.0 * t0 + la - hi, hi = 2.0 * t0 + la - t;
    }
    w0 = g->flip > 0.0 ? b->lo[2] : -b->hi[2], w1 = g->flip > 0.0 ? b->hi[2] : -b->lo[2];
    if (fmax(lo, a->lo[ta]) - fmin(hi, a->hi[ta]) > fmax(hi - lo, a->hi[ta] - a->lo[ta])) return KN_OK;
    if (fmax(w0, a->lo[2]) - fmin(w1, a->hi[2]) > fmax(w1 - w0, a->hi[2] - a->lo[2])) return KN_OK;
    // outwards by more than the rounding of the map between the two
    lo = fmax(t0, fmin(lo, a->lo[ta]) - 0x1p-49 * la), hi = fmin(t0 + la, fmax(hi, a->hi[ta]) + 0x1p-49 * la);
    w0 = fmin(w0, a->lo[2]), w1 = fmax(w1, a->hi[2]);
    reach_apex(ca, ta, &lo, &hi, &w0, &w1);
    double heights[2] = {g->flip > 0.0 ? w0 : -w1, g->flip > 0.0 ? w1 : -w0};
    if (w0 < ca->breaks[2][0] || w1 > ca->breaks[2][ca->nbreaks[2] - 1] || heights[0] < cb->breaks[2][0] ||
        heights[1] > cb->breaks[2][cb->nbreaks[2] - 1])
        return KN_OK;
    // b's unit across the edge is worth `unit` of a's
    double unit = (b->length[xb] / (b->hi[xb] - b->lo[xb])) / (a->length[xa] / (a->hi[xa] - a->lo[xa])), whole;
    if (!(unit > 0.0 && unit < INFINITY)) unit = la / lb;
    whole = da + db * unit;
    p.lo[xa] = g->end[first] ? ea - da : ea, p.hi[xa] = g->end[first] ? ea : ea + da;
    p.lo[ta] = lo, p.hi[ta] = hi, p.lo[2] = w0, p.hi[2] = w1;
    p.scale[xa] = whole, p.scale[ta] = hi - lo, p.scale[2] = w1 - w0;
    q.lo[xb] = g->end[second] ? eb - db : eb, q.hi[xb] = g->end[second] ? eb : eb + db;
    double from = s0 + lb * ((lo - t0) / la), to = s0 + lb * ((hi - t0) / la);
    if (g->reversed) {
        double t = from;
        from = 2.0 * s0 + lb - to, to = 2.0 * s0 + lb - t;
    }
    q.lo[tb] = fmax(s0, from - 0x1p-49 * lb), q.hi[tb] = fmin(s0 + lb, to + 0x1p-49 * lb);
    q.lo[2] = heights[0], q.hi[2] = heights[1];
    q.column[xb] = xa, q.column[tb] = ta, q.column[2] = 2;
    q.scale[xb] = whole / unit * (g->end[first] == g->end[second] ? -1.0 : 1.0);
    q.scale[tb] = (hi - lo) * (lb / la) * (g->reversed ? -1.0 : 1.0);
    q.scale[2] = (w1 - w0) * g->flip;
    // y from -1 to 1 along a's direction: the edge lies at `edge`
    double edge = g->end[first] ? -1.0 + 2.0 * da / whole : 1.0 - 2.0 * da / whole;
    double far = g->end[first] ? 1.0 : -1.0;
    open_fan(m, &p, g->end[first] ? -far : edge, g->end[first] ? edge : -far, 0.5);
    open_fan(m, &q, g->end[second] ? far : edge, g->end[second] ? edge : far, 0.5);
    if ((p.pole >= 0) != (q.pole >= 0) || (p.pole >= 0 && (p.pole != ta || q.pole != tb))) return KN_OK;
    if ((p.tip >= 0) != (q.tip >= 0) || (p.tip >= 0 && (p.tip != ta || q.tip != tb))) return KN_OK;
    p.free[xa] = q.free[xb] = p.pole < 0 && p.tip < 0;
    kn_status status = set_lift(m, &p);
    q.lift = p.lift;
    if (status == KN_OK) status = kn_meet_add_part(&h, &p);
    if (status == KN_OK && h.fits) status = kn_meet_add_part(&h, &q);
    if (status == KN_OK && h.fits) *injective = holds(&h);
    return status;
}

kn_status kn_meet_injective(kn_meet *m, bool *injective, int ia, int ib)
{
    const kn_meet_node *a = &m->nodes[ia], *b = &m->nodes[ib];
    kn_status status = KN_OK;
    *injective = false;
    kn_mark mark = kn_scratch_mark(m->ctx);
    if (a->chart == b->chart) status = within(m, injective, a, b);
    for (size_t i = 0; i < m->nglues && !*injective && status == KN_OK && ia != ib; i++)
        for (int first = 0; first < 2 && !*injective && status == KN_OK; first++) {
            const kn_meet_glue *g = &m->glues[i];
            if (g->chart[first] == a->chart && g->chart[1 - first] == b->chart)
                status = g->jump < INFINITY ? across(m, injective, a, b, g, first)
                                            : kn_meet_wedge(m, injective, a, b, g, first);
        }
    kn_scratch_release(m->ctx, mark);
    return status;
}
