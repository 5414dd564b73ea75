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
#include "fold/meet.h"

#include "kernel/bernstein.h"

#include <string.h>

// Vectors whose means, each component within the error, are what column `column` of DT is on some part of H.
typedef struct vectors {
    struct vectors *next;
    int column;
    size_t n;
    double *x; // three arrays of n
    double error[3], size[3];
} vectors;

typedef struct hull {
    kn_meet *m;
    vectors *list;
    double jump;
    bool fits; // false: H cannot be treated
} hull;

// A box of one chart as part of H. The derivative in its variable d times scale[d] is one in variable column[d] of H.
typedef struct part {
    int chart, column[3];
    double lo[3], hi[3], scale[3];
    int pole, pole_end; // the variable that runs away from a pole, -1: none
    double across[2];   // y at lo and hi of the other variable
    // H may count a variable at another rate on each knot interval, so that |T_d| is about 1 on all of them: where it
    // is free to, rate[d] for the intervals from first[d] on, 0: not known yet.
    bool free[2];
    int first[2];
    double rate[2][KN_MEET_MOST];
} part;

// Restricted to the part's share of one piece, box [lo,hi] in parameters.
typedef struct share {
    const part *p;
    double scale[3];
    kn_meet_patch patch;
    double lo[3], hi[3];
    double middle, ratio; // rational: 1/w = (1 + t) / middle, |t| <= ratio
    bool flat;
    double center[3 * (KN_MAX_DEGREE + 1)]; // what was taken off T: for each layer of coefficients, if flat
} share;

static vectors *new_vectors(hull *h, int column, size_t n)
{
    vectors *v = kn_scratch(h->m->ctx, 1, sizeof *v);
    if (!v) return NULL;
    *v = (vectors){.next = h->list, .column = column, .n = n, .x = kn_scratch(h->m->ctx, 3 * n, sizeof(double))};
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
static kn_status plain_column(hull *h, const share *s, int d)
{
    const kn_meet_patch *p = &s->patch;
    size_t n = p->net.count, less = places(&p->net, d), inner = kn_net_inner(&p->net, d);
    int degree = p->net.degree[d];
    double scale = s->scale[d] / (s->hi[d] - s->lo[d]), slope = 0.0;
    h->fits = h->fits && degree > 0;
    if (degree == 0) return KN_OK;
    vectors *v = new_vectors(h, s->p->column[d], less);
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
static double *quotient(hull *h, const share *s, const fan *f, int *top, double center[3], double error[3])
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
static kn_status fan_columns(hull *h, const share *s)
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
    vectors *x = q ? new_vectors(h, s->p->column[f.t], nx) : NULL;
    vectors *y = x ? new_vectors(h, s->p->column[f.y], less) : NULL;
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

static void set_scale(share *s, part *p, const int at[3])
{
    for (int d = 0; d < 3; d++) {
        s->scale[d] = p->scale[d];
        if (d == 2 || !p->free[d]) continue;
        double *rate = &p->rate[d][at[d] - p->first[d]];
        if (*rate == 0.0) *rate = rate_of(s, d);
        s->scale[d] = (p->scale[d] < 0.0 ? -1.0 : 1.0) / *rate;
    }
}

static kn_status add_share(hull *h, part *p, const int at[3])
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
    if (p->pole >= 0) status = fan_columns(h, &s);
    for (int d = 0; d < 3 && status == KN_OK; d++)
        if (d == 2 || p->pole < 0) status = plain_column(h, &s, d);
    return status;
}

static kn_status add_part(hull *h, part *p)
{
    const kn_meet_chart *c = &h->m->charts[p->chart];
    int first[3], last[3], at[3];
    for (int d = 0; d < 3; d++) {
        kn_meet_overlap(c, d, p->lo[d], p->hi[d], &first[d], &last[d]);
        for (int i = first[d] + 1; i <= last[d] && d < 2; i++) h->jump += c->jump[d][i];
    }
    if (p->pole >= 0 && first[p->pole] != last[p->pole]) h->fits = false;
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

// ---- the criterion ----

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

// x with (1 - K) x >= g, x > 0, K >= 0, by the formula and checked; false when there is none.
static bool majorant(double x[3], double k[3][3], const double g[3])
{
    double a[3][3], b[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            if (!(k[i][j] < 1e6)) return false;
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
static void middles(double mid[3][3], const hull *h)
{
    double lo[3][3], hi[3][3];
    for (int i = 0; i < 9; i++) lo[i / 3][i % 3] = INFINITY, hi[i / 3][i % 3] = -INFINITY;
    for (const vectors *v = h->list; v; v = v->next)
        for (size_t c = 0; c < 3; c++)
            for (size_t k = 0; k < v->n; k++) {
                lo[c][v->column] = fmin(lo[c][v->column], v->x[c * v->n + k]);
                hi[c][v->column] = fmax(hi[c][v->column], v->x[c * v->n + k]);
            }
    for (int i = 0; i < 9; i++) mid[i / 3][i % 3] = 0.5 * lo[i / 3][i % 3] + 0.5 * hi[i / 3][i % 3];
}

static bool holds(const hull *h)
{
    double mid[3][3], a[3][3], k[3][3] = {{0}}, x[3], one[3] = {1.0, 1.0, 1.0}, g[3], length = 0.0;
    middles(mid, h);
    if (!invert(a, mid)) return false;
    for (const vectors *v = h->list; v; v = v->next)
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
    if (!majorant(x, k, one)) return false;
    if (h->jump == 0.0) return true;
    for (int i = 0; i < 3; i++)
        g[i] = (fabs(a[i][0]) + fabs(a[i][1]) + fabs(a[i][2])) * h->jump * (1.0 + 0x1p-40) + 0x1p-1000;
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

// Makes the part a fan where its box touches a pole. across: y at its lo and hi.
static void open_fan(const kn_meet *m, part *p, double y0, double y1, double half)
{
    const kn_meet_chart *c = &m->charts[p->chart];
    p->pole = -1;
    for (int d = 0; d < 2 && p->pole < 0; d++)
        for (int e = 0; e < 2 && p->pole < 0; e++) {
            double at;
            edge_of(&at, c, d, e);
            if (c->pole[d][e] && (e ? p->hi[d] >= at : p->lo[d] <= at)) p->pole = d, p->pole_end = e;
        }
    if (p->pole < 0) return;
    int y = 1 - p->pole;
    p->across[0] = y0, p->across[1] = y1;
    p->scale[y] *= half;
    p->scale[p->pole] = fabs(p->scale[p->pole]);
}

// Whether the criterion fails already at the corners and in the middle of H: a guess that spares most of the work. At
// each end of a variable that may choose its rates the partials are taken in units of their mean.
static kn_status looks_bent(kn_meet *m, bool *bent, const part *p)
{
    double slope[9][9], mean[3][3] = {{0}}, lo[9], hi[9], mid[3][3], a[3][3], k[3][3] = {{0}};
    const double one[3] = {1.0, 1.0, 1.0};
    double x[3], point[3];
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
    *bent = *bent || !majorant(x, k, one);
    return KN_OK;
}

static kn_status within(kn_meet *m, bool *injective, const kn_meet_node *a, const kn_meet_node *b)
{
    part p = {.chart = a->chart, .column = {0, 1, 2}};
    hull h = {.m = m, .fits = true};
    for (int d = 0; d < 3; d++) {
        double la = a->hi[d] - a->lo[d], lb = b->hi[d] - b->lo[d];
        if (fmax(a->lo[d], b->lo[d]) - fmin(a->hi[d], b->hi[d]) > 0.3 * fmin(la, lb)) return KN_OK;
        p.lo[d] = fmin(a->lo[d], b->lo[d]);
        p.hi[d] = fmax(a->hi[d], b->hi[d]);
        p.scale[d] = p.hi[d] - p.lo[d];
    }
    open_fan(m, &p, -1.0, 1.0, 0.5);
    p.free[0] = p.free[1] = p.pole < 0;
    bool bent = false;
    int spans[2];
    for (int d = 0; d < 2; d++) {
        int first, last;
        kn_meet_overlap(&m->charts[p.chart], d, p.lo[d], p.hi[d], &first, &last);
        spans[d] = last - first + 1;
    }
    kn_status status = p.pole < 0 && spans[0] * spans[1] > 2 ? looks_bent(m, &bent, &p) : KN_OK;
    if (status == KN_OK && !bent)
        status = add_part(&h, &p);
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
    part p = {.chart = a->chart, .column = {0, 1, 2}}, q = {.chart = b->chart};
    hull h = {.m = m, .fits = g->jump < INFINITY, .jump = g->jump};
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
    p.free[xa] = q.free[xb] = p.pole < 0;
    kn_status status = add_part(&h, &p);
    if (status == KN_OK && h.fits) status = add_part(&h, &q);
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
                status = across(m, injective, a, b, g, first);
        }
    kn_scratch_release(m->ctx, mark);
    return status;
}
