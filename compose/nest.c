// SPDX-License-Identifier: Apache-2.0
// Composition in scaled Bernstein coefficients.
//
// With E the expanded variables and d one of the others
//     f = sum_(i_d) x_d^(i_d) s_d^(p_d - i_d) (sum_(i_E) c_(i_E, i_d) prod_(e in E) x_e^(i_e) s_e^(p_e - i_e)).
// The inner sum has scalar coefficients: one small matrix product for all components and all i_d. The outer one has
// polynomials as coefficients; a form of degree n over n + 1 of them is halved,
//     sum_(i <= n) x^i s^(n-i) f_i
//         = s^(n-k+1) (sum_(i < k) x^i s^(k-1-i) f_i) + x^k (sum_(i >= k) x^(i-k) s^(n-i) f_i),
// and the powers outside are multiplied one factor at a time: each factor is as small as can be, and a form of degree
// n costs about n log2 n such products. docs/composition.md compares this with the other nests.
#include "compose/nest.h"
#include "kernel/bernstein.h"
#include "kernel/binomial.h"
#include "kernel/gemm.h"

#include <string.h>

void kn_nest_shape(kn_nest *nest, const kn_bezier *outer, const kn_bezier *inner)
{
    kn_convolve_level level = kn_convolve_best();
    int at[KN_MAX_VARS] = {0};
    nest->outer = outer->nvars;
    nest->inner = inner->nvars;
    memcpy(nest->p, outer->degree, sizeof nest->p);
    memcpy(nest->m, inner->degree, sizeof nest->m);
    nest->sum = 0;
    for (int d = 0; d < nest->outer; d++) nest->sum += nest->p[d];
    nest->room[0] = 8; // a constant, where vectors may begin
    nest->count[0] = 1.0;
    for (int g = 0; g < nest->sum; g++) {
        kn_convolution_init(&nest->up[g], level, nest->inner, nest->m, at);
        nest->room[g + 1] = nest->up[g].sum_room;
        nest->count[g + 1] = 1.0;
        for (int d = 0; d < nest->inner; d++) {
            at[d] += nest->m[d];
            nest->count[g + 1] *= at[d] + 1;
        }
    }
}

// ---- the plan ----
static int low_half(int n) // of the n + 1 coefficients of a form, those that s multiplies
{
    return n / 2 + 1;
}

// Products of a form of degree n by x and s, each weighted by the size of what it multiplies.
static double form_cost(const kn_nest *nest, int n, int g)
{
    if (n == 0) return 0.0;
    int k = low_half(n);
    double cost = form_cost(nest, k - 1, g) + form_cost(nest, n - k, g);
    for (int j = k - 1; j < n; j++) cost += nest->count[g + j];
    for (int j = n - k; j < n; j++) cost += nest->count[g + j];
    return cost;
}

double kn_nest_cost(const kn_nest *nest, int ncomp)
{
    double products = 0.0, width = 1.0, rows = ncomp;
    int g = 0;
    for (int j = 0; j < nest->expanded; j++) {
        int p = nest->p[nest->order[j]];
        for (int q = 1; q <= p; q++, g++) products += (q + 1) * width * nest->count[g];
        width *= p + 1;
    }
    for (int j = nest->expanded; j < nest->outer; j++) rows *= nest->p[nest->order[j]] + 1;
    double sums = rows * width * nest->count[g];
    for (int j = nest->expanded; j < nest->outer; j++) {
        int p = nest->p[nest->order[j]];
        rows /= p + 1;
        products += rows * form_cost(nest, p, g);
        g += p;
    }
    return sums + (nest->sum > 0 ? nest->count[1] : 0.0) * products;
}

// Variables by degree: the expanded ones from the highest, the others from the lowest.
static void put_in_order(kn_nest *nest, const bool *expanded)
{
    nest->expanded = 0;
    for (int d = 0; d < nest->outer; d++) nest->expanded += expanded[d];
    int first = 0, rest = nest->expanded;
    for (int d = 0; d < nest->outer; d++) {
        int start = expanded[d] ? 0 : nest->expanded, at = expanded[d] ? first++ : rest++;
        for (; at > start; at--) {
            int before = nest->p[nest->order[at - 1]];
            if (expanded[d] ? before >= nest->p[d] : before <= nest->p[d]) break;
            nest->order[at] = nest->order[at - 1];
        }
        nest->order[at] = d;
    }
}

void kn_nest_plan(kn_nest *nest, const kn_bezier *outer, const kn_bezier *inner)
{
    kn_nest_shape(nest, outer, inner);
    int best[2] = {0, 0};
    double least = -1.0;
    for (int a = 0; a < nest->outer; a++)
        for (int b = a; b < nest->outer; b++) {
            bool expanded[KN_MAX_VARS] = {false};
            expanded[a] = expanded[b] = true;
            put_in_order(nest, expanded);
            double cost = kn_nest_cost(nest, outer->ncomp);
            if (least < 0.0 || cost < least) least = cost, best[0] = a, best[1] = b;
        }
    bool expanded[KN_MAX_VARS] = {false};
    expanded[best[0]] = expanded[best[1]] = true;
    put_in_order(nest, expanded);
}

// ---- products ----
// The factor is one operand of all products of the batch: it is packed once.
kn_status kn_nest_times(kn_ctx *ctx, double *out, const kn_nest *nest, const double *in, size_t batch, int g,
                        const double *factor)
{
    const kn_convolution *p = &nest->up[g];
    static const size_t constant[KN_MAX_VARS] = {0};
    size_t dense[KN_MAX_VARS + 1] = {0};
    const size_t *step = g > 0 ? nest->up[g - 1].sum_step : constant;
    dense[nest->inner] = 1;
    for (int d = nest->inner - 1; d >= 0; d--) dense[d] = dense[d + 1] * ((size_t)nest->m[d] + 1);
    kn_mark mark = kn_scratch_mark(ctx);
    double *thin = kn_scratch(ctx, p->thin_room, sizeof *thin), *wide = kn_scratch(ctx, p->wide_room, sizeof *wide);
    if (thin && wide) {
        if (p->swapped)
            kn_convolution_pack_wide(p, wide, factor, dense + 1, false);
        else
            kn_convolution_pack_thin(p, thin, factor, dense + 1, false);
        for (size_t i = 0; i < batch; i++, in += nest->room[g], out += nest->room[g + 1]) {
            if (p->swapped)
                kn_convolution_pack_thin(p, thin, in, step, false);
            else
                kn_convolution_pack_wide(p, wide, in, step, false);
            kn_convolution_run(p, out, thin, wide, 1.0);
        }
    }
    kn_scratch_release(ctx, mark);
    return thin && wide ? KN_OK : KN_ENOMEM;
}

// The same into a new array.
static double *multiplied(kn_ctx *ctx, const kn_nest *nest, const double *in, size_t batch, int g,
                          const double *factor)
{
    size_t n = batch * nest->room[g + 1];
    double *out = kn_scratch(ctx, n, sizeof *out);
    if (!out) return NULL;
    memset(out, 0, n * sizeof *out);
    return kn_nest_times(ctx, out, nest, in, batch, g, factor) == KN_OK ? out : NULL;
}

// out += in factor^times, in of degrees g m.
static kn_status add_multiple(kn_ctx *ctx, double *out, const kn_nest *nest, const double *in, size_t batch, int g,
                              const double *factor, int times)
{
    for (; in && times > 1; times--, g++) in = multiplied(ctx, nest, in, batch, g, factor);
    return in ? kn_nest_times(ctx, out, nest, in, batch, g, factor) : KN_ENOMEM;
}

// out = sum_(i <= n) x^i s^(n-i) f_i, f_i a batch of polynomials on level g at f + i * batch * room[g]; n >= 1.
static kn_status form(kn_ctx *ctx, double *out, const kn_nest *nest, const double *f, int n, size_t batch, int g,
                      const double *x, const double *s)
{
    int k = low_half(n), degree[2] = {k - 1, n - k};
    const double *half[2] = {f, f + (size_t)k * batch * nest->room[g]};
    kn_status status = KN_OK;
    memset(out, 0, batch * nest->room[g + n] * sizeof *out);
    for (int i = 0; status == KN_OK && i < 2; i++) {
        kn_mark mark = kn_scratch_mark(ctx);
        const double *value = half[i];
        if (degree[i] > 0) {
            double *sum = kn_scratch(ctx, batch * nest->room[g + degree[i]], sizeof *sum);
            status = sum ? form(ctx, sum, nest, half[i], degree[i], batch, g, x, s) : KN_ENOMEM;
            value = sum;
        }
        if (status == KN_OK)
            status = add_multiple(ctx, out, nest, value, batch, g + degree[i], i ? x : s, n - degree[i]);
        kn_scratch_release(ctx, mark);
    }
    return status;
}

// ---- expansion and the matrix product ----
static size_t factor_count(const kn_nest *nest)
{
    return kn_bernstein_count(nest->inner, nest->m);
}

// All x^i s^(p-i) of the expanded variables, the last one slowest: `width` polynomials on level g.
static kn_status expand(kn_ctx *ctx, double **basis, size_t *width, int *g, const kn_nest *nest, const double *factor)
{
    *g = 0, *width = 1;
    double *now = kn_scratch(ctx, nest->room[0], sizeof *now);
    if (!now) return KN_ENOMEM;
    memset(now, 0, nest->room[0] * sizeof *now);
    now[0] = 1.0;
    for (int j = 0; j < nest->expanded; j++) {
        const double *x = factor + 2 * (size_t)nest->order[j] * factor_count(nest), *s = x + factor_count(nest);
        size_t group = *width;
        for (int q = 1; q <= nest->p[nest->order[j]]; q++, (*g)++, *width += group) {
            size_t to = nest->room[*g + 1], n = (*width + group) * to;
            double *next = kn_scratch(ctx, n, sizeof *next);
            if (!next) return KN_ENOMEM;
            memset(next, 0, n * sizeof *next);
            kn_status status = kn_nest_times(ctx, next, nest, now, *width, *g, s);
            if (status == KN_OK)
                status = kn_nest_times(ctx, next + *width * to, nest, now + (*width - group) * nest->room[*g], group,
                                       *g, x);
            if (status != KN_OK) return status;
            now = next;
        }
    }
    *basis = now;
    return KN_OK;
}

// The scaled coefficients as a matrix: columns are expanded indices, the last one slowest; rows the others, in the
// order of the nest, components fastest.
static void gather(double *a, size_t width, const kn_nest *nest, const kn_bezier *outer, const double *weight)
{
    size_t step[KN_MAX_VARS], at = 0, column = 1, row = width * (size_t)outer->ncomp, n = kn_bezier_count(outer);
    int index[KN_MAX_VARS] = {0};
    for (int j = 0; j < nest->expanded; j++) {
        step[nest->order[j]] = column;
        column *= (size_t)nest->p[nest->order[j]] + 1;
    }
    for (int j = nest->outer - 1; j >= nest->expanded; j--) {
        step[nest->order[j]] = row;
        row *= (size_t)nest->p[nest->order[j]] + 1;
    }
    for (size_t i = 0; i < n; i++) {
        for (size_t c = 0; c < (size_t)outer->ncomp; c++) a[at + c * width] = weight[i] * outer->coef[c * n + i];
        for (int d = nest->outer - 1; d >= 0; d--) {
            at += step[d];
            if (++index[d] <= nest->p[d]) break;
            at -= step[d] * (size_t)index[d];
            index[d] = 0;
        }
    }
}

// out (rows, n) = a (rows, width) basis (width, n).
static kn_status combine(kn_ctx *ctx, double *out, const double *a, const double *basis, size_t rows, size_t width,
                         size_t n)
{
    double *packed = kn_scratch(ctx, kn_gemm_room(width, n), sizeof *packed);
    double **to = kn_scratch(ctx, rows, sizeof *to);
    const double **from = kn_scratch(ctx, rows, sizeof *from);
    double *work = kn_scratch(ctx, rows * width, sizeof *work);
    if (!packed || !to || !from || !work) return KN_ENOMEM;
    kn_gemm_pack(packed, basis, width, n, n, 1);
    for (size_t i = 0; i < rows; i++) {
        to[i] = out + i * n;
        from[i] = a + i * width;
    }
    kn_gemm(to, from, rows, packed, width, n, work);
    return KN_OK;
}

// All but the nested variables: *f receives the rows, of degrees *g m.
static kn_status expand_and_combine(kn_ctx *ctx, double *f, size_t rows, const kn_nest *nest, const kn_bezier *outer,
                                    const double *factor)
{
    double *basis = NULL;
    size_t width = 1, n = kn_bezier_count(outer);
    int g = 0;
    kn_status status = expand(ctx, &basis, &width, &g, nest, factor);
    if (status != KN_OK) return status;
    double *weight = kn_scratch(ctx, n, sizeof *weight), *a = kn_scratch(ctx, rows * width, sizeof *a);
    if (!weight || !a) return KN_ENOMEM;
    kn_bernstein_weights(weight, outer->nvars, outer->degree);
    gather(a, width, nest, outer, weight);
    return combine(ctx, f, a, basis, rows, width, nest->room[g]);
}

static kn_status run(kn_ctx *ctx, double *out, const kn_nest *nest, const kn_bezier *outer, const double *factor)
{
    size_t rows = (size_t)outer->ncomp;
    int g = 0;
    for (int j = 0; j < nest->outer; j++)
        if (j < nest->expanded)
            g += nest->p[nest->order[j]];
        else
            rows *= (size_t)nest->p[nest->order[j]] + 1;
    bool all = nest->expanded == nest->outer;
    double *f = all ? out : kn_scratch(ctx, rows * nest->room[g], sizeof *f);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = f ? expand_and_combine(ctx, f, rows, nest, outer, factor) : KN_ENOMEM;
    kn_scratch_release(ctx, mark);
    for (int j = nest->expanded; status == KN_OK && j < nest->outer; j++) {
        int p = nest->p[nest->order[j]];
        const double *x = factor + 2 * (size_t)nest->order[j] * factor_count(nest);
        rows /= (size_t)p + 1;
        bool last = j == nest->outer - 1;
        double *next = last ? out : p == 0 ? f : kn_scratch(ctx, rows * nest->room[g + p], sizeof *next);
        if (!next) return KN_ENOMEM;
        if (p > 0)
            status = form(ctx, next, nest, f, p, rows, g, x, x + factor_count(nest));
        else if (last)
            memcpy(out, f, rows * nest->room[g] * sizeof *out);
        f = next;
        g += p;
    }
    return status;
}

kn_status kn_nest_run(kn_ctx *ctx, double *out, const kn_nest *nest, const kn_bezier *outer, const double *factor)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = run(ctx, out, nest, outer, factor);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_nest_factors(kn_ctx *ctx, double *factor, const kn_nest *nest, const kn_bezier *inner, const double *lo,
                          const double *hi)
{
    size_t n = kn_bezier_count(inner);
    kn_mark mark = kn_scratch_mark(ctx);
    double *weight = kn_scratch(ctx, n, sizeof *weight);
    if (weight) {
        const double *w = inner->rational ? inner->coef + (size_t)(inner->ncomp - 1) * n : NULL;
        kn_bernstein_weights(weight, nest->inner, nest->m);
        for (size_t d = 0; d < (size_t)nest->outer; d++) {
            double *x = factor + 2 * d * n, *s = x + n, size = hi ? hi[d] - lo[d] : 1.0;
            const double *value = inner->coef + d * n;
            for (size_t i = 0; i < n; i++) {
                double one = w ? w[i] : 1.0;
                x[i] = weight[i] * (lo ? (value[i] - lo[d] * one) / size : value[i]);
                s[i] = weight[i] * (hi ? (hi[d] * one - value[i]) / size : one - value[i]);
            }
        }
    }
    kn_scratch_release(ctx, mark);
    return weight ? KN_OK : KN_ENOMEM;
}

static kn_status power_of(kn_ctx *ctx, double *out, const kn_nest *nest, const double *w)
{
    size_t n = factor_count(nest);
    double *factor = kn_scratch(ctx, n, sizeof *factor), *one = kn_scratch(ctx, nest->room[0], sizeof *one);
    if (!factor || !one) return KN_ENOMEM;
    kn_bernstein_weights(factor, nest->inner, nest->m);
    for (size_t i = 0; i < n; i++) factor[i] *= w[i];
    memset(one, 0, nest->room[0] * sizeof *one);
    one[0] = 1.0;
    return add_multiple(ctx, out, nest, one, 1, 0, factor, nest->sum);
}

kn_status kn_nest_power(kn_ctx *ctx, double *out, const kn_nest *nest, const double *w)
{
    memset(out, 0, nest->room[nest->sum] * sizeof *out);
    if (nest->sum == 0) {
        out[0] = 1.0;
        return KN_OK;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = power_of(ctx, out, nest, w);
    kn_scratch_release(ctx, mark);
    return status;
}

void kn_nest_divide(double *out, const kn_nest *nest, const double *value, int ncomp)
{
    size_t step[KN_MAX_VARS + 1], n = 1;
    for (int d = nest->inner - 1; d >= 0; d--) {
        step[d] = n;
        n *= (size_t)(nest->sum * nest->m[d]) + 1;
    }
    for (int c = 0; c < ncomp; c++, out += n, value += nest->room[nest->sum])
        if (nest->sum > 0)
            kn_convolution_divide(&nest->up[nest->sum - 1], out, step, value);
        else
            out[0] = value[0];
}
