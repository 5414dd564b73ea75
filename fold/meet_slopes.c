// SPDX-License-Identifier: Apache-2.0
// Vectors whose means are the partials of T over parts of a domain.
#include "fold/meet_slopes.h"

#include "kernel/bernstein.h"

#include <string.h>

// Restricted to the part's share of one piece, box [lo,hi] in parameters.
typedef struct share {
    const kn_meet_part *p;
    double scale[3];
    kn_meet_patch patch;
    double lo[3], hi[3];
    double middle, ratio; // rational: 1/w = (1 + t) / middle, |t| <= ratio
    bool flat;
    double center[3 * (KN_MAX_DEGREE + 1)]; // what was taken off T: for each layer of coefficients, if flat
} share;

static kn_meet_vectors *new_vectors(kn_meet_hull *h, int column, size_t n)
{
    kn_meet_vectors *v = kn_scratch(h->m->ctx, 1, sizeof *v);
    if (!v) return NULL;
    *v = (kn_meet_vectors){
        .next = h->list, .column = column, .n = n, .x = kn_scratch(h->m->ctx, 3 * n, sizeof(double))};
    if (!v->x) return NULL;
    h->list = v;
    return v;
}

static size_t places(const kn_net *net, int less)
{
    return less < 0 ? net->count : net->count / (size_t)(net->degree[less] + 1) * (size_t)net->degree[less];
}

// The range of the weights, its middle and how far 1/w is from 1/middle.
static bool weigh(share *s)
{
    const double *w = s->patch.coef + 3 * s->patch.net.count;
    double least = INFINITY, most = -INFINITY;
    s->middle = 1.0, s->ratio = 0.0;
    if (!s->patch.rational) return true;
    for (size_t k = 0; k < s->patch.net.count; k++) least = fmin(least, w[k]), most = fmax(most, w[k]);
    least -= s->patch.error[3], most += s->patch.error[3];
    if (!(least > 0.0)) return false;
    s->middle = 0.5 * least + 0.5 * most;
    s->ratio = (s->middle / least - 1.0) * (1.0 + 0x1p-40) + 0x1p-50;
    return true;
}

// T's numerator less center * weight, so that T is small. Where the weight does not depend on w each layer of
// coefficients has a center of its own, center(w), which T_u and T_v do not feel, and T_w meets no derivative of it
// but its own, which is put back.
static void recenter(kn_meet_patch *p, const double *center, bool flat)
{
    size_t n = p->net.count, layers = (size_t)p->net.degree[2] + 1;
    double weight = p->rational ? kn_largest(p->coef + 3 * n, n) : 1.0;
    for (size_t c = 0; c < 3; c++) {
        double size = kn_largest(p->coef + c * n, n), most = 0.0;
        for (size_t k = 0; k < n; k++) {
            double x = center[3 * (flat ? k % layers : layers / 2) + c];
            p->coef[c * n + k] -= x * (p->rational ? p->coef[3 * n + k] : 1.0);
            most = fmax(most, fabs(x));
        }
        p->error[c] += most * (p->rational ? p->error[3] : 0.0) + kn_rounding(2.0) * (size + 2.0 * most * weight);
    }
}

// The largest |center| of a component.
static double reach_of(const share *s, size_t c)
{
    double most = 0.0;
    for (int l = 0; l <= s->patch.net.degree[2]; l++) most = fmax(most, fabs(s->center[3 * (size_t)l + c]));
    return most;
}

// Column d: T_d = (N_d - T w_d) / w, with |T| small.
static kn_status plain_column(kn_meet_hull *h, const share *s, int d)
{
    const kn_meet_patch *p = &s->patch;
    size_t n = p->net.count, less = places(&p->net, d), inner = kn_net_inner(&p->net, d);
    int degree = p->net.degree[d];
    double scale = s->scale[d] / (s->hi[d] - s->lo[d]), slope = 0.0;
    h->fits = h->fits && degree > 0;
    if (degree == 0) return KN_OK;
    kn_meet_vectors *v = new_vectors(h, s->p->column[d], less);
    double *dw = kn_scratch(h->m->ctx, less, sizeof *dw);
    if (!v || !dw) return KN_ENOMEM;
    kn_bernstein_differentiate(v->x, p->coef, 3 * n / inner / (size_t)(degree + 1), degree, inner);
    for (size_t k = 0; k < 3 * less; k++) v->x[k] *= scale / s->middle;
    for (size_t k = 0; k < 3 * less && d == 2 && s->flat; k++) {
        const double *center = s->center + 3 * (k % (size_t)degree) + k / less;
        v->x[k] += degree * (center[3] - center[0]) * scale;
    }
    if (p->rational) {
        kn_bernstein_differentiate(dw, p->coef + 3 * n, n / inner / (size_t)(degree + 1), degree, inner);
        slope = (kn_largest(dw, less) + 2.0 * degree * p->error[3]) * fabs(scale) / s->middle;
    }
    for (size_t c = 0; c < 3; c++) {
        double size = v->size[c] = kn_largest(v->x + c * less, less);
        v->error[c] = (2.0 * degree * p->error[c] * fabs(scale) / s->middle +
                       kn_rounding(8.0) * (size + 2.0 * degree * reach_of(s, c) * fabs(scale))) *
                      (1.0 + s->ratio);
        if (!p->rational) continue;
        double reach = (kn_largest(p->coef + c * n, n) + p->error[c]) * (1.0 + s->ratio) / s->middle;
        v->error[c] += size * s->ratio + 1.01 * reach * slope * (1.0 + s->ratio);
    }
    return KN_OK;
}

// ---- mixed partials ----

// One component differentiated in a variable, per box; degree: before and after. Returns how many there are.
static size_t differentiate(double *out, const double *x, int degree[3], int d)
{
    size_t inner = 1, outer = 1;
    for (int e = d + 1; e < 3; e++) inner *= (size_t)degree[e] + 1;
    for (int e = 0; e < d; e++) outer *= (size_t)degree[e] + 1;
    kn_bernstein_differentiate(out, x, outer, degree[d], inner);
    return outer * inner * (size_t)degree[d]--;
}

// The largest coefficients of a component and its derivatives in variables y and d, per box, errors included.
typedef struct extents {
    double all, y, d, both;
} extents;

// *both: where the coefficients of the mixed derivative go.
static kn_status measure(kn_meet_hull *h, extents *out, double *both, const double *x, double error,
                         const kn_meet_patch *p, int y, int d)
{
    int degree[3], ny = p->net.degree[y], nd = p->net.degree[d];
    memcpy(degree, p->net.degree, sizeof degree);
    double *one = kn_scratch(h->m->ctx, p->net.count, sizeof *one);
    if (!one) return KN_ENOMEM;
    out->all = kn_largest(x, p->net.count) + error;
    out->d = kn_largest(one, differentiate(one, x, degree, d)) + 2.0 * nd * error;
    degree[d] = nd;
    out->y = kn_largest(one, differentiate(one, x, degree, y)) + 2.0 * ny * error;
    out->both = kn_largest(both, differentiate(both, one, degree, d)) + 4.0 * ny * nd * error;
    return KN_OK;
}

// T_yd times `scale`, a column for y: (N_yd - T_d w_y - T_y w_d - T w_yd) / w. Adds to most[c] what it reaches.
static kn_status mixed_column(kn_meet_hull *h, const share *s, int y, int d, double scale, double most[3])
{
    const kn_meet_patch *p = &s->patch;
    int ny = p->net.degree[y], nd = p->net.degree[d];
    size_t n = p->net.count, less = n / (size_t)((ny + 1) * (nd + 1)) * (size_t)(ny * nd);
    extents weight = {0}, t;
    kn_status status = KN_OK;
    h->fits = h->fits && less > 0;
    if (!h->fits) return KN_OK;
    kn_meet_vectors *v = new_vectors(h, s->p->column[y], less);
    double *spare = kn_scratch(h->m->ctx, less, sizeof *spare), unit = fabs(scale) * (1.0 + s->ratio) / s->middle;
    if (!v || !spare) return KN_ENOMEM;
    if (p->rational) status = measure(h, &weight, spare, p->coef + 3 * n, p->error[3], p, y, d);
    double wy = weight.y * (1.0 + s->ratio) / s->middle, wd = weight.d * (1.0 + s->ratio) / s->middle,
           wyd = weight.both * (1.0 + s->ratio) / s->middle;
    for (size_t c = 0; c < 3 && status == KN_OK; c++) {
        double *x = v->x + c * less;
        status = measure(h, &t, x, p->coef + c * n, p->error[c], p, y, d);
        if (status != KN_OK) break;
        double reach = t.all * (1.0 + s->ratio) / s->middle;
        double ty = t.y * (1.0 + s->ratio) / s->middle + reach * wy,
               td = t.d * (1.0 + s->ratio) / s->middle + reach * wd;
        for (size_t k = 0; k < less; k++) x[k] *= scale / s->middle;
        v->size[c] = kn_largest(x, less);
        v->error[c] = 4.0 * ny * nd * (p->error[c] + kn_rounding(16.0) * t.all) * unit + v->size[c] * s->ratio +
                      1.01 * fabs(scale) * (td * wy + ty * wd + reach * wyd);
        most[c] = fmax(most[c], (v->size[c] + v->error[c]) * (1.0 + 0x1p-40));
    }
    return status;
}

// How far the edge that should be one point is from that, for each layer where it should. The layer of the base may
// lie beside w = 0 by what rounding or a sliver left.
static double spread(const share *s, int x, int y, bool base_alone, bool upper)
{
    const kn_meet_patch *p = &s->patch;
    size_t n = p->net.count, iy = kn_net_inner(&p->net, y);
    int nw = p->net.degree[2];
    double left = 0.0, beside = upper ? fabs(s->hi[2]) : fabs(s->lo[2]);
    for (size_t c = 0; c < 3; c++) {
        double most = 0.0, size = kn_largest(p->coef + c * n, n);
        for (int l = 0; l <= nw; l++) {
            if (base_alone && l != (upper ? nw : 0)) continue;
            size_t at = (size_t)l + (s->p->tip_end ? (size_t)p->net.degree[x] * kn_net_inner(&p->net, x) : 0);
            double first = p->coef[c * n + at] / (p->rational ? p->coef[3 * n + at] : 1.0);
            for (size_t i = 0; i <= (size_t)p->net.degree[y]; i++) {
                size_t k = at + i * iy;
                most = fmax(most, fabs(p->coef[c * n + k] - first * (p->rational ? p->coef[3 * n + k] : 1.0)));
            }
        }
        most += 4.0 * (p->error[c] + kn_rounding(8.0) * size);
        if (p->rational) most += 4.0 * p->error[3] * size * (1.0 + s->ratio) / s->middle;
        if (base_alone) most += 4.0 * nw * beside / (s->hi[2] - s->lo[2]) * (size + s->middle * reach_of(s, c));
        left += most * (1.0 + s->ratio) * (1.0 + s->ratio) / s->middle;
    }
    return left;
}

// Near an edge that is one point T_y = v q + lift w q' with q and lift q' means of T_yv and T_yw, all in parts of the
// box; at a pole q' = 0. T less what it varies by along that edge is meant: that counts as a jump.
static kn_status tip_columns(kn_meet_hull *h, const share *s)
{
    const kn_meet_part *p = s->p;
    int x = p->tip, y = 1 - x;
    const kn_meet_chart *c = &h->m->charts[p->chart];
    bool pole = c->pole[x][p->tip_end], upper = p->lo[2] < 0.0;
    double scale = s->scale[y] / (s->hi[y] - s->lo[y]), most[3] = {0.0};
    double away = fabs(s->scale[x]) / (s->hi[x] - s->lo[x]) * (p->tip_end ? -1.0 : 1.0),
           up = fabs(s->scale[2]) / (s->hi[2] - s->lo[2]) * (upper ? -1.0 : 1.0) / p->lift;
    h->jump += 4.0 * spread(s, x, y, !pole, upper);
    kn_status status = mixed_column(h, s, y, x, scale * away, most);
    if (status == KN_OK && !pole) status = mixed_column(h, s, y, 2, scale * up, most);
    for (int d = 0; d < 3 && status == KN_OK && h->fits; d++) {
        if (d == y) continue;
        status = plain_column(h, s, d);
        double turn = p->fan ? fmax(fabs(p->across[0]), fabs(p->across[1])) * (d == 2 ? p->lift : 1.0) : 0.0;
        for (int k = 0; k < 3 && status == KN_OK && h->fits; k++) h->list->error[k] += 1.01 * turn * most[k];
    }
    return status;
}

// ---- poles ----

// Coefficient (t, y, layer) of an array with degrees dt, dy, dw seen with the pole's variable first, at index 0.
typedef struct fan {
    int t, y, n[3]; // variables, degrees in t, y, w
    bool turned;    // the pole is at the upper end
    const kn_net *net;
} fan;

static size_t fan_place(const fan *f, int it, int iy, int iw)
{
    size_t i[3];
    i[f->t] = (size_t)(f->turned ? f->n[0] - it : it);
    i[f->y] = (size_t)iy;
    i[2] = (size_t)iw;
    return i[0] * kn_net_inner(f->net, 0) + i[1] * kn_net_inner(f->net, 1) + i[2];
}

static size_t fan_index(const fan *f, int it, int iy, int iw, int ny)
{
    return ((size_t)it * (size_t)(ny + 1) + (size_t)iy) * (size_t)(f->n[2] + 1) + (size_t)iw;
}

// q, degree top in t: T - T_0 = X Q with Q = q / w; of rational pieces Q less its middle, which goes to center.
// What is left of T - T_0 at the pole itself counts as a jump.
static double *quotient(kn_meet_hull *h, const share *s, const fan *f, int *top, double center[3], double error[3])
{
    const kn_meet_patch *p = &s->patch;
    size_t all = p->net.count, size = (size_t)(f->n[0] + 1) * (size_t)(f->n[1] + 1) * (size_t)(f->n[2] + 1);
    double *q = kn_scratch(h->m->ctx, 3 * size, sizeof *q), left = 0.0;
    if (!q) return NULL;
    *top = f->n[0] - 1;
    for (int c = 0; c < 3; c++) {
        const double *x = p->coef + (size_t)c * all, *w = p->rational ? p->coef + 3 * all : NULL;
        double most = 0.0, base = 0.0;
        for (int l = 0; l <= f->n[2]; l++) {
            size_t at = fan_place(f, 0, 0, l);
            double t0 = x[at] / (w ? w[at] : 1.0);
            base = fmax(base, fabs(t0));
            for (int j = 0; j <= f->n[0]; j++)
                for (int i = 0; i <= f->n[1]; i++) {
                    size_t k = fan_place(f, j, i, l);
                    double y = x[k] - t0 * (w ? w[k] : 1.0);
                    if (j == 0)
                        left = fmax(left, fabs(y) * (1.0 + s->ratio) / s->middle);
                    else
                        q[(size_t)c * size + fan_index(f, j - 1, i, l, f->n[1])] = y * f->n[0] / j;
                    most = fmax(most, fabs(x[k]) + fabs(t0) * (w ? w[k] : 1.0));
                }
        }
        error[c] = f->n[0] * (p->error[c] + base * (p->rational ? p->error[3] : 0.0) + kn_rounding(6.0) * most);
        center[c] = 0.0;
    }
    h->jump += 4.0 * left + 2.0 * (error[0] + error[1] + error[2]) / s->middle;
    if (!p->rational) return q;
    // raised to degree n in t: q_j = (j / n) q_(j-1) + (1 - j / n) q_j
    *top = f->n[0];
    for (int c = 0; c < 3; c++) {
        double *x = q + (size_t)c * size, most = 0.0;
        center[c] = x[fan_index(f, 0, f->n[1] / 2, f->n[2] / 2, f->n[1])] /
                    p->coef[3 * all + fan_place(f, 0, f->n[1] / 2, f->n[2] / 2)];
        for (int i = 0; i <= f->n[1]; i++)
            for (int l = 0; l <= f->n[2]; l++)
                for (int j = f->n[0]; j >= 0; j--) {
                    double a = j > 0 ? x[fan_index(f, j - 1, i, l, f->n[1])] : 0.0;
                    double b = j < f->n[0] ? x[fan_index(f, j, i, l, f->n[1])] : 0.0;
                    double y = center[c] * p->coef[3 * all + fan_place(f, j, i, l)];
                    x[fan_index(f, j, i, l, f->n[1])] = (j * a + (f->n[0] - j) * b) / f->n[0] - y;
                    most = fmax(most, fmax(fabs(a), fabs(b)) + fabs(y));
                }
        error[c] += fabs(center[c]) * p->error[3] + kn_rounding(8.0) * most;
    }
    return q;
}

// Bounds of |w_y| and |X w_X - y w_y| in H's variables, over the middle of the weights.
static void weight_slopes(double slope[2], const share *s, const fan *f, double scale)
{
    const double *w = s->patch.coef + 3 * s->patch.net.count;
    double wy = 0.0, wx = 0.0;
    slope[0] = slope[1] = 0.0;
    if (!s->patch.rational) return;
    for (int j = 0; j <= f->n[0]; j++)
        for (int i = 0; i <= f->n[1]; i++) {
            if (i < f->n[1]) wy = fmax(wy, fabs(w[fan_place(f, j, i + 1, 0)] - w[fan_place(f, j, i, 0)]) * f->n[1]);
            if (j < f->n[0]) wx = fmax(wx, fabs(w[fan_place(f, j + 1, i, 0)] - w[fan_place(f, j, i, 0)]) * f->n[0]);
        }
    slope[0] = 1.01 * (wy + 2.0 * f->n[1] * s->patch.error[3]) * fabs(scale) / s->middle;
    slope[1] = 1.01 * (wx + 2.0 * f->n[0] * s->patch.error[3]) / s->middle + slope[0];
}

// With q of degrees (top, n) in (X, y), g = (X q)_X - y q_y has the same degrees:
// ((X q)_X)_j = (j + 1) q_j - j q_(j-1), and (y q_y)_i = (1 - i/n) a q'_i + (i/n) b q'_(i-1) where y runs from a to
// b.
static kn_status fan_columns(kn_meet_hull *h, const share *s)
{
    fan f = {.t = s->p->pole, .y = 1 - s->p->pole, .turned = s->p->pole_end == 1, .net = &s->patch.net};
    f.n[0] = f.net->degree[f.t], f.n[1] = f.net->degree[f.y], f.n[2] = f.net->degree[2];
    double scale = s->scale[f.y] / (s->hi[f.y] - s->lo[f.y]), center[3], error[3], slope[2];
    double width = s->p->hi[f.y] - s->p->lo[f.y], a, b;
    double unit = s->scale[f.t] / (s->hi[f.t] - s->lo[f.t]) /
                  s->middle; // X of H for X of the share; 1 but for slivers
    a = s->p->across[0] + (s->p->across[1] - s->p->across[0]) * ((s->lo[f.y] - s->p->lo[f.y]) / width);
    b = s->p->across[0] + (s->p->across[1] - s->p->across[0]) * ((s->hi[f.y] - s->p->lo[f.y]) / width);
    int top = 0, ny = f.n[1];
    h->fits = h->fits && f.n[0] > 0 && ny > 0;
    if (!h->fits) return KN_OK;
    double *q = quotient(h, s, &f, &top, center, error);
    size_t layers = (size_t)f.n[2] + 1, nx = (size_t)(top + 1) * (size_t)(ny + 1) * layers;
    size_t less = (size_t)(top + 1) * (size_t)ny * layers;
    size_t size = (size_t)(f.n[0] + 1) * (size_t)(ny + 1) * layers;
    kn_meet_vectors *x = q ? new_vectors(h, s->p->column[f.t], nx) : NULL;
    kn_meet_vectors *y = x ? new_vectors(h, s->p->column[f.y], less) : NULL;
    if (!y) return KN_ENOMEM;
    weight_slopes(slope, s, &f, scale);
    for (size_t c = 0; c < 3; c++) {
        const double *qc = q + c * size;
        double *xc = x->x + c * nx, *yc = y->x + c * less, most = kn_largest(qc, nx), reach;
        for (int j = 0; j <= top; j++)
            for (int l = 0; l <= f.n[2]; l++) {
                for (int i = 0; i < ny; i++)
                    yc[fan_index(&f, j, i, l, ny - 1)] =
                        ny * (qc[fan_index(&f, j, i + 1, l, ny)] - qc[fan_index(&f, j, i, l, ny)]) * scale * unit;
                for (int i = 0; i <= ny; i++) {
                    double g = (j + 1) * qc[fan_index(&f, j, i, l, ny)];
                    if (j > 0) g -= j * qc[fan_index(&f, j - 1, i, l, ny)];
                    g *= unit;
                    if (i < ny) g -= (double)(ny - i) / ny * a * yc[fan_index(&f, j, i, l, ny - 1)];
                    if (i > 0) g -= (double)i / ny * b * yc[fan_index(&f, j, i - 1, l, ny - 1)];
                    xc[fan_index(&f, j, i, l, ny)] = g;
                }
            }
        error[c] = (error[c] + kn_rounding(8.0) * most) * (1.0 + s->ratio) * unit;
        reach = most * unit * (1.0 + s->ratio) + error[c];
        double sizes[2] = {kn_largest(xc, nx), kn_largest(yc, less)};
        y->error[c] = 2.0 * ny * fabs(scale) * error[c] + sizes[1] * (s->ratio + kn_rounding(8.0)) +
                      1.01 * reach * slope[0] * (1.0 + s->ratio);
        x->error[c] = (2.0 * top + 1.0) * error[c] + 2.0 * ny * fabs(scale) * error[c] +
                      (sizes[0] + sizes[1]) * kn_rounding(16.0) + sizes[0] * s->ratio +
                      1.01 * reach * slope[1] * (1.0 + s->ratio);
        double shift = center[c] * unit * s->middle;
        for (size_t k = 0; k < nx; k++) xc[k] += shift;
        x->error[c] += kn_rounding(4.0) * (fabs(shift) + sizes[0]);
        x->size[c] = sizes[0] + fabs(shift), y->size[c] = sizes[1];
    }
    return KN_OK;
}

// ---- parts ----

// The values of T at the middle of each layer of coefficients, about.
static void find_centers(double *center, const kn_meet_patch *p)
{
    size_t n = p->net.count, layers = (size_t)p->net.degree[2] + 1, first = n / layers / 2 * layers;
    for (size_t l = 0; l < layers; l++)
        for (size_t k = 0; k < 3; k++)
            center[3 * l + k] = p->coef[k * n + first + l] / (p->rational ? p->coef[3 * n + first + l] : 1.0);
}

// The length of the mean line of a share in variable d per parameter.
static double rate_of(const share *s, int d)
{
    const kn_meet_patch *p = &s->patch;
    size_t n = p->net.count, row = kn_net_inner(&p->net, d) * (size_t)p->net.degree[d], from = 0;
    double sum = 0.0;
    for (int e = 0; e < 3; e++)
        if (e != d) from += (size_t)(p->net.degree[e] / 2) * kn_net_inner(&p->net, e);
    for (size_t k = 0; k < 3; k++) {
        double a = p->coef[k * n + from], b = p->coef[k * n + from + row];
        if (p->rational) a /= p->coef[3 * n + from], b /= p->coef[3 * n + from + row];
        sum += (b - a) * (b - a);
    }
    double rate = sqrt(sum) / (s->hi[d] - s->lo[d]);
    return rate > 0.0 && rate < INFINITY ? rate : 1.0;
}

static void set_scale(share *s, kn_meet_part *p, const int at[3])
{
    for (int d = 0; d < 3; d++) {
        s->scale[d] = p->scale[d];
        if (d == 2 || !p->free[d]) continue;
        double *rate = &p->rate[d][at[d] - p->first[d]];
        if (*rate == 0.0) *rate = rate_of(s, d);
        s->scale[d] = (p->scale[d] < 0.0 ? -1.0 : 1.0) / *rate;
    }
}

static kn_status add_share(kn_meet_hull *h, kn_meet_part *p, const int at[3])
{
    kn_meet *m = h->m;
    const kn_meet_chart *c = &m->charts[p->chart];
    share s;
    s.p = p;
    kn_status status = kn_meet_restrict(m, &s.patch, s.lo, s.hi, p->chart, at, p->lo, p->hi);
    if (status != KN_OK) return status;
    h->fits = h->fits && weigh(&s);
    if (!h->fits) return KN_OK;
    set_scale(&s, p, at);
    s.flat = c->flat_weight;
    find_centers(s.center, &s.patch);
    recenter(&s.patch, s.center, s.flat);
    if (p->tip >= 0) return tip_columns(h, &s);
    if (p->pole >= 0) status = fan_columns(h, &s);
    for (int d = 0; d < 3 && status == KN_OK; d++)
        if (d == 2 || p->pole < 0) status = plain_column(h, &s, d);
    return status;
}

kn_status kn_meet_add_part(kn_meet_hull *h, kn_meet_part *p)
{
    const kn_meet_chart *c = &h->m->charts[p->chart];
    int first[3], last[3], at[3];
    for (int d = 0; d < 3; d++) {
        kn_meet_overlap(c, d, p->lo[d], p->hi[d], &first[d], &last[d]);
        for (int i = first[d] + 1; d < 2 && i <= last[d]; i++) h->jump += c->jump[d][i];
    }
    if (p->pole >= 0 && first[p->pole] != last[p->pole]) h->fits = false;
    if (p->tip >= 0 && (first[p->tip] != last[p->tip] || first[2] != last[2])) h->fits = false;
    if ((last[0] - first[0] + 1) * (last[1] - first[1] + 1) > KN_MEET_MOST) h->fits = false;
    h->fits = h->fits && h->jump <= h->m->resolution;
    p->first[0] = first[0], p->first[1] = first[1];
    for (at[0] = first[0]; at[0] <= last[0]; at[0]++)
        for (at[1] = first[1]; at[1] <= last[1]; at[1]++)
            for (at[2] = first[2]; at[2] <= last[2] && h->fits; at[2]++) {
                kn_status status = add_share(h, p, at);
                if (status != KN_OK) return status;
            }
    return KN_OK;
}
