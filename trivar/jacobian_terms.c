// SPDX-License-Identifier: Apache-2.0
// det dT/d(u,v,w) over one box as a polynomial in w, with a bound of the rounding of every coefficient.
//
// T = sum_t f_t w^p_t, f_0 = S and p_0 = 0, so that T_u = sum f_t,u w^p_t, T_v likewise, T_w = sum p_t f_t w^(p_t -
// 1):
//     det = sum_r w^r J_r,  J_r = sum_c p_c f_c . X_(r - p_c + 1),  X_m =
//     sum_(p_a + p_b = m) f_a,u x f_b,v.
// For S = P/W all is times W^3, which divides what would be W^4: with A = P_u W - P W_u (S_u = A / W^2), B likewise,
//     W^3 S_u x S_v = W (P_u x P_v) - W_v (P_u x P) - W_u (P x P_v),  W^3 (S_u
//     x g) = W (A x g).
// A volume P/W, in all three variables:
//     W^4 det = W (P_w . P_u x P_v) - P . (W_u (P_v x P_w) + W_v (P_w x P_u) +
//     W_w (P_u x P_v)).
//
// Rounding: coefficients of a product are means of products of coefficients, so that |a| |b| bounds them, gamma of
// the number of terms times that their rounding, and e_a |b| + |a| e_b + e_a e_b what errors of a and b leave. What is
// 0 because control points are 0 or alike (a constant psi, a plane's n) is 0 exactly and carries no error: at great
// heights even 1e-16 w^k would be much.
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

// A function with the largest of its coefficient vectors, a bound of the error of each, and how many rows of them are
// zero along each edge, exactly and by structure: what a product inherits.
typedef struct factor {
    kn_bezier b;
    double size, error;
    int zero[3][2];
    unsigned none; // bit c: component c is 0 exactly; error is 0 when all are
    kn_same same;  // of a term or the weight: what is given
} factor;

enum { ALWAYS = 1000 }; // zero[][] of the function 0

typedef kn_status (*operation)(kn_ctx *, kn_bezier *, const kn_bezier *, const kn_bezier *);

static void clear(kn_ctx *ctx, factor *f, size_t n)
{
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &f[i].b);
}

static void measure(factor *f)
{
    f->size = kn_largest_vector(&f->b, 0, f->b.ncomp);
}

// The components of a op b that are 0 exactly.
static unsigned none_of(const factor *a, const factor *b, operation op)
{
    unsigned all = a->none | b->none, none = 0;
    if (op == kn_bezier_dot) return (all & 7u) == 7u;
    if (op == kn_bezier_product) { // one of the two has one component
        unsigned one = a->b.ncomp == 1 ? a->none : b->none, many = a->b.ncomp == 1 ? b->none : a->none;
        return (one & 1u) != 0 ? ~0u : many;
    }
    for (int c = 0; c < 3; c++) {
        int j = (c + 1) % 3, k = (c + 2) % 3;
        bool first = ((a->none >> j | b->none >> k) & 1u) != 0, second = ((a->none >> k | b->none >> j) & 1u) != 0;
        if (first && second) none |= 1u << c;
    }
    return none;
}

// Takes over what is known to be 0.
static void set_none(factor *f, unsigned none)
{
    size_t count = kn_bezier_count(&f->b), n = (size_t)f->b.ncomp;
    f->none = none & ((1u << n) - 1u);
    for (size_t c = 0; c < n; c++)
        for (size_t k = 0; k < count && (f->none >> c & 1u) != 0; k++) f->b.coef[c * count + k] = 0.0;
    if (f->none == (1u << n) - 1u) f->error = 0.0;
    measure(f);
}

static void swap(factor *a, factor *b)
{
    factor t = *a;
    *a = *b;
    *b = t;
}

// *out = a op b. Products that may underflow lose more than rounding: then nothing is known.
static kn_status multiply(kn_ctx *ctx, factor *out, const factor *a, const factor *b, operation op)
{
    double bound = a->size * b->size;
    unsigned none = none_of(a, b, op);
    size_t na = kn_bezier_count(&a->b), nb = kn_bezier_count(&b->b);
    double terms = 3.0 * (double)(na < nb ? na : nb);
    double round = bound > 0.0 && bound < 0x1p-900 ? INFINITY : 4.0 * kn_gamma(2.0 * terms + 64.0) * bound;
    double error = 1.001 * (round + a->error * b->size + a->size * b->error + a->error * b->error);
    kn_status status = op(ctx, &out->b, &a->b, &b->b);
    if (status != KN_OK) return status;
    for (int e = 0; e < 6; e++) {
        int zero = a->zero[e / 2][e % 2] + b->zero[e / 2][e % 2];
        out->zero[e / 2][e % 2] = zero > ALWAYS ? ALWAYS : zero;
    }
    out->error = error;
    set_none(out, none);
    return KN_OK;
}

// *sum += sign f; an empty sum is 0. Both are raised to common degrees on the way.
static kn_status add(kn_ctx *ctx, factor *sum, const factor *f, int sign)
{
    kn_status status;
    if (!sum->b.coef) {
        status = kn_bezier_scale(ctx, &sum->b, &f->b, sign);
        sum->error = f->error, sum->none = f->none;
        for (int e = 0; e < 6; e++) sum->zero[e / 2][e % 2] = f->zero[e / 2][e % 2];
    } else {
        status = sign > 0 ? kn_bezier_sum(ctx, &sum->b, &sum->b, &f->b)
                          : kn_bezier_difference(ctx, &sum->b, &sum->b, &f->b);
        sum->error = 1.001 * (sum->error + f->error) + kn_gamma(256.0) * (sum->size + f->size);
        sum->none &= f->none;
        for (int e = 0; e < 6; e++) {
            int *zero = &sum->zero[e / 2][e % 2];
            *zero = *zero < f->zero[e / 2][e % 2] ? *zero : f->zero[e / 2][e % 2];
        }
    }
    if (status == KN_OK) measure(sum);
    return status;
}

// *out = the derivative of f in variable var, per unit of the parameter: the box is `width` wide.
static kn_status slope(kn_ctx *ctx, factor *out, const factor *f, int var, double width)
{
    int degree = f->b.degree[var];
    kn_status status = kn_bezier_derivative(ctx, &out->b, &f->b, var);
    if (status == KN_OK) status = kn_bezier_scale(ctx, &out->b, &out->b, 1.0 / width);
    if (status != KN_OK) return status;
    out->error = 1.001 * (2.0 * degree * f->error / width + kn_gamma(8.0) * 2.0 * degree * f->size / width);
    for (int e = 0; e < 6; e++) out->zero[e / 2][e % 2] = degree == 0 ? ALWAYS : 0;
    set_none(out, f->none | f->same.alike[var]);
    return KN_OK;
}

// *out = P_var W - P W_var, W^2 times the derivative of P/W. t: room for two.
static kn_status rational_slope(kn_ctx *ctx, factor *out, factor *t, const factor *p, const factor *w, int var,
                                double width)
{
    kn_status status = slope(ctx, &t[0], p, var, width);
    if (status == KN_OK) status = multiply(ctx, out, &t[0], w, kn_bezier_product);
    if (status == KN_OK) status = slope(ctx, &t[0], w, var, width);
    if (status == KN_OK) status = multiply(ctx, &t[1], p, &t[0], kn_bezier_product);
    if (status == KN_OK) status = add(ctx, out, &t[1], -1);
    return status;
}

// ---- edges ----

// Coefficient k of row `row` along variable var: its place in one component.
static size_t row_place(const kn_bezier *b, int var, int row, size_t k)
{
    size_t inner = 1;
    for (int d = var + 1; d < b->nvars; d++) inner *= (size_t)b->degree[d] + 1;
    return k / inner * inner * ((size_t)b->degree[var] + 1) + (size_t)row * inner + k % inner;
}

static double row_size(const kn_bezier *b, int var, int row)
{
    size_t count = kn_bezier_count(b), cross = count / ((size_t)b->degree[var] + 1);
    double largest = 0.0;
    for (size_t c = 0; c < (size_t)b->ncomp; c++)
        for (size_t k = 0; k < cross; k++)
            largest = fmax(largest, fabs(b->coef[c * count + row_place(b, var, row, k)]));
    return largest;
}

static void zero_row(kn_bezier *b, int var, int row)
{
    size_t count = kn_bezier_count(b), cross = count / ((size_t)b->degree[var] + 1);
    for (size_t c = 0; c < (size_t)b->ncomp; c++)
        for (size_t k = 0; k < cross; k++) b->coef[c * count + row_place(b, var, row, k)] = 0.0;
}

// Rows of f from an edge inwards count as zero while they are within `slack`, `most` of them, and become so.
static void clear_rows(factor *f, int var, int end, int most, double slack)
{
    int rows = f->b.degree[var] + 1, *zero = &f->zero[var][end];
    if (*zero == ALWAYS) return;
    while (*zero < most && *zero < rows - 1) {
        int row = end ? rows - 1 - *zero : *zero;
        if (!(row_size(&f->b, var, row) <= slack)) return;
        zero_row(&f->b, var, row);
        ++*zero;
    }
}

// An edge along which a derivative of S, over the whole domain, is below 1e-12 of S's size, or what the rounding of
// coordinates makes, has collapsed: S's
// derivative vanishes there, and so does that of another field whose own is as small.
static void collapse(factor (*d)[3], const kn_box_map *t)
{
    for (int e = 0; e < 2 * t->nvars; e++)
        for (int var = 0; var < t->nvars; var++) {
            factor *s = &d[0][var];
            double weight = t->weight.coef ? t->weight_size * t->weight_size : 1.0;
            double points = 4.0 * t->term[0].degree[var] * t->slack / t->knot[var]; // off by the slack each
            double near = s->error + weight * (1e-12 * t->size / t->span[var] + points);
            clear_rows(s, e / 2, e % 2, s->b.degree[e / 2], near);
            for (int k = 1; k < t->nterms; k++) {
                factor *f = &d[k][var];
                double slack = f->error + 1e-12 * kn_largest_vector(&t->term[k], 0, 3) / t->span[var];
                clear_rows(f, e / 2, e % 2, s->zero[e / 2][e % 2], slack);
            }
        }
}

// ---- the sums ----

typedef struct work {
    const kn_box_map *map;
    bool rational;
    factor term[KN_BOX_TERMS], weight, weight3;
    factor slope[KN_BOX_TERMS][3]; // of S = P/W times W^2
    factor cross[KN_BOX_POWERS], j[KN_BOX_POWERS], t[6];
} work;

static void clear_work(kn_ctx *ctx, work *w)
{
    clear(ctx, w->term, KN_BOX_TERMS);
    clear(ctx, &w->weight, 1);
    clear(ctx, &w->weight3, 1);
    for (int k = 0; k < KN_BOX_TERMS; k++) clear(ctx, w->slope[k], 3);
    clear(ctx, w->cross, KN_BOX_POWERS);
    clear(ctx, w->j, KN_BOX_POWERS);
    clear(ctx, w->t, 6);
}

static kn_status copy(kn_ctx *ctx, factor *out, const kn_bezier *b, double error, const kn_same *same)
{
    kn_status status = kn_bezier_copy(ctx, &out->b, b);
    out->error = error, out->same = *same;
    if (status == KN_OK) set_none(out, same->none);
    return status;
}

static kn_status start(kn_ctx *ctx, work *w)
{
    const kn_box_map *m = w->map;
    kn_status status = KN_OK;
    for (int k = 0; k < m->nterms && status == KN_OK; k++)
        status = copy(ctx, &w->term[k], &m->term[k], m->error[k], &m->same[k]);
    if (w->rational && status == KN_OK) status = copy(ctx, &w->weight, &m->weight, m->weight_error, &m->weight_same);
    if (w->rational && status == KN_OK) status = multiply(ctx, &w->t[0], &w->weight, &w->weight, kn_bezier_product);
    if (w->rational && status == KN_OK) status = multiply(ctx, &w->weight3, &w->t[0], &w->weight, kn_bezier_product);
    for (int k = 0; k < m->nterms; k++)
        for (int v = 0; v < m->nvars && status == KN_OK; v++)
            status = w->rational && k == 0
                         ? rational_slope(ctx, &w->slope[k][v], w->t, &w->term[k], &w->weight, v, m->width[v])
                         : slope(ctx, &w->slope[k][v], &w->term[k], v, m->width[v]);
    if (status == KN_OK) collapse(w->slope, m);
    return status;
}

// *out = W^3 (S_u x S_v) of the lower degree: as many rows are zero as in A x B.
static kn_status numerator(kn_ctx *ctx, factor *out, work *w)
{
    const kn_box_map *m = w->map;
    factor *t = w->t, *p = &w->term[0], *weight = &w->weight;
    kn_status status = slope(ctx, &t[0], p, 0, m->width[0]);
    if (status == KN_OK) status = slope(ctx, &t[1], p, 1, m->width[1]);
    if (status == KN_OK) status = multiply(ctx, &t[2], &t[0], &t[1], kn_bezier_cross);
    if (status == KN_OK) status = multiply(ctx, out, weight, &t[2], kn_bezier_product);
    for (int v = 0; v < 2 && status == KN_OK; v++) { // W_v (P_u x P), then W_u (P x P_v)
        status = multiply(ctx, &t[2], v == 0 ? &t[0] : p, v == 0 ? p : &t[1], kn_bezier_cross);
        if (status == KN_OK) status = slope(ctx, &t[3], weight, 1 - v, m->width[1 - v]);
        if (status == KN_OK) status = multiply(ctx, &t[4], &t[3], &t[2], kn_bezier_product);
        if (status == KN_OK) status = add(ctx, out, &t[4], -1);
    }
    for (int e = 0; e < 4 && status == KN_OK; e++) {
        int zero = w->slope[0][0].zero[e / 2][e % 2] + w->slope[0][1].zero[e / 2][e % 2];
        clear_rows(out, e / 2, e % 2, zero, INFINITY);
    }
    return status;
}

static kn_status cross_terms(kn_ctx *ctx, work *w)
{
    const kn_box_map *m = w->map;
    kn_status status = KN_OK;
    factor *t = w->t;
    for (int a = 0; a < m->nterms; a++)
        for (int b = 0; b < m->nterms && status == KN_OK; b++) {
            int weights = (a == 0) + (b == 0);
            if (w->rational && weights == 2) {
                status = numerator(ctx, &t[5], w);
            } else {
                status = multiply(ctx, &t[5], &w->slope[a][0], &w->slope[b][1], kn_bezier_cross);
                if (status == KN_OK && w->rational)
                    status = multiply(ctx, &t[5], &t[5], weights == 1 ? &w->weight : &w->weight3, kn_bezier_product);
            }
            if (status == KN_OK) status = add(ctx, &w->cross[m->power[a] + m->power[b]], &t[5], 1);
        }
    return status;
}

static kn_status powers(kn_ctx *ctx, work *w, int *top)
{
    const kn_box_map *m = w->map;
    kn_status status = KN_OK;
    *top = 0;
    for (int k = 0; k < KN_BOX_POWERS && status == KN_OK; k++)
        for (int c = 1; c < m->nterms && w->cross[k].b.coef && status == KN_OK; c++) {
            int r = k + m->power[c] - 1;
            factor *t = &w->t[0];
            status = multiply(ctx, t, &w->term[c], &w->cross[k], kn_bezier_dot);
            if (status == KN_OK) status = kn_bezier_scale(ctx, &t->b, &t->b, m->power[c]);
            t->error = 1.001 * m->power[c] * (t->error + kn_gamma(2.0) * t->size);
            if (status == KN_OK) measure(t);
            if (status == KN_OK) status = add(ctx, &w->j[r], t, 1);
            if (r > *top) *top = r;
        }
    return status;
}

// W^4 det of a volume, or det.
static kn_status volume(kn_ctx *ctx, work *w)
{
    const kn_box_map *m = w->map;
    factor *t = w->t, *d[3] = {&w->slope[0][0], &w->slope[0][1], &w->slope[0][2]};
    kn_status status = KN_OK;
    if (!w->rational) {
        status = multiply(ctx, &t[0], d[0], d[1], kn_bezier_cross);
        return status == KN_OK ? multiply(ctx, &w->j[0], &t[0], d[2], kn_bezier_dot) : status;
    }
    int zero[3][2];
    for (int e = 0; e < 6; e++)
        zero[e / 2][e % 2] = d[0]->zero[e / 2][e % 2] + d[1]->zero[e / 2][e % 2] + d[2]->zero[e / 2][e % 2];
    for (int v = 0; v < 3 && status == KN_OK; v++) status = slope(ctx, d[v], &w->term[0], v, m->width[v]);
    if (status == KN_OK) status = multiply(ctx, &t[0], d[0], d[1], kn_bezier_cross);
    if (status == KN_OK) status = multiply(ctx, &t[1], &t[0], d[2], kn_bezier_dot);
    if (status == KN_OK) status = multiply(ctx, &w->j[0], &w->weight, &t[1], kn_bezier_product);
    for (int v = 0; v < 3 && status == KN_OK; v++) {
        status = multiply(ctx, &t[0], d[(v + 1) % 3], d[(v + 2) % 3], kn_bezier_cross);
        if (status == KN_OK) status = multiply(ctx, &t[1], &w->term[0], &t[0], kn_bezier_dot);
        if (status == KN_OK) status = slope(ctx, &t[2], &w->weight, v, m->width[v]);
        if (status == KN_OK) status = multiply(ctx, &t[3], &t[2], &t[1], kn_bezier_product);
        if (status == KN_OK) status = add(ctx, &w->j[0], &t[3], -1);
    }
    for (int e = 0; e < 6 && status == KN_OK; e++) clear_rows(&w->j[0], e / 2, e % 2, zero[e / 2][e % 2], INFINITY);
    if (status == KN_OK) status = multiply(ctx, &t[0], &w->weight3, &w->weight, kn_bezier_product);
    if (status == KN_OK) swap(&w->weight3, &t[0]);
    return status;
}

// ---- what is handed out ----

static void raise(int *degree, const kn_bezier *b)
{
    for (int v = 0; v < b->nvars; v++) degree[v] = b->degree[v] > degree[v] ? b->degree[v] : degree[v];
}

static kn_status elevate(kn_ctx *ctx, factor *f, const int *degree)
{
    kn_status status = kn_bezier_elevate(ctx, &f->b, &f->b, degree);
    f->error += kn_gamma(256.0) * f->size;
    return status;
}

// All J_r in one degree as the components of p->j.
static kn_status pack(kn_ctx *ctx, kn_shell_jacobian_piece *p, work *w, int top)
{
    int nvars = w->map->nvars, degree[KN_MAX_VARS] = {0};
    kn_status status = KN_OK;
    for (int r = 0; r <= top; r++)
        if (w->j[r].b.coef) raise(degree, &w->j[r].b);
    if (w->rational) raise(degree, &w->weight3.b);
    for (int r = 0; r <= top && status == KN_OK; r++)
        if (w->j[r].b.coef) status = elevate(ctx, &w->j[r], degree);
    if (w->rational && status == KN_OK) status = kn_bezier_elevate(ctx, &p->denominator, &w->weight3.b, degree);
    if (status == KN_OK) status = kn_bezier_init(ctx, &p->j, nvars, top + 1, false, degree);
    if (status != KN_OK) return status;
    size_t count = kn_bezier_count(&p->j);
    for (int r = 0; r <= top; r++) {
        const factor *f = &w->j[r];
        for (size_t k = 0; k < count && f->b.coef; k++) p->j.coef[(size_t)r * count + k] = f->b.coef[k];
        p->error[r] = f->b.coef ? f->error : 0.0;
    }
    return KN_OK;
}

// Divides the factor out that all J_r have along edges by structure. Coefficient i of degree n is scaled by C(n, i+k)
// / C(n-k, i) <= n (n-1) .. (n-k+1); raising the degree again costs rounding alone.
static kn_status divide(kn_ctx *ctx, kn_shell_jacobian_piece *p, const work *w, int top)
{
    kn_status status = KN_OK;
    for (int e = 0; e < 2 * p->j.nvars && status == KN_OK; e++) {
        int var = e / 2, n = p->j.degree[var], common = ALWAYS, order;
        for (int r = 0; r <= top; r++)
            if (w->j[r].b.coef && w->j[r].zero[var][e % 2] < common) common = w->j[r].zero[var][e % 2];
        p->flat[var][e % 2] = w->j[0].b.coef && w->j[0].zero[var][e % 2] > common;
        if (common == 0 || common >= n) continue;
        kn_bezier q = {0};
        int degree[KN_MAX_VARS];
        for (int v = 0; v < p->j.nvars; v++) degree[v] = p->j.degree[v];
        status = kn_bezier_divide_edge(ctx, &q, &order, &p->j, var, e % 2);
        if (status == KN_OK && order == common) {
            status = kn_bezier_elevate(ctx, &p->j, &q, degree);
            p->order[var][e % 2] = order;
            for (int r = 0; r <= top; r++) {
                for (int k = 0; k < order; k++) p->error[r] *= n - k;
                p->error[r] += kn_gamma(256.0) * kn_largest_vector(&q, r, 1);
            }
        }
        kn_bezier_clear(ctx, &q);
    }
    return status;
}

kn_status kn_jacobian_of(kn_ctx *ctx, kn_shell_jacobian_piece *out, const kn_box_map *map, bool divided)
{
    int top = 0;
    for (int k = 1; k < map->nterms; k++)
        if (3 * map->power[k] > KN_BOX_POWERS)
            return kn_fail(ctx, KN_ELIMIT, "shell: the Jacobian of a shell with w^%d has powers above %d",
                           map->power[k], (int)KN_BOX_POWERS);
    kn_mark mark = kn_scratch_mark(ctx);
    work *w = kn_scratch(ctx, 1, sizeof *w);
    if (!w) return KN_ENOMEM;
    *w = (work){.map = map, .rational = map->weight.coef != NULL};
    kn_status status = start(ctx, w);
    if (map->nvars == 3) {
        if (status == KN_OK) status = volume(ctx, w);
    } else {
        if (status == KN_OK) status = cross_terms(ctx, w);
        if (status == KN_OK) status = powers(ctx, w, &top);
    }
    if (status == KN_OK) status = pack(ctx, out, w, top);
    if (status == KN_OK && divided) status = divide(ctx, out, w, top);
    clear_work(ctx, w);
    kn_scratch_release(ctx, mark);
    return status;
}
