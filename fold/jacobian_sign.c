// SPDX-License-Identifier: Apache-2.0
// The sign of the Jacobian over a box of (u,v,w): Bernstein coefficients in all three, halved where they differ.
#include "fold/internal.h"
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "solve/net.h"

#include <math.h>
#include <string.h>

enum { DEPTH = 90, FINE = 6 };
static const double margin = 0.02;                // of the range of values: how far bounds may lie outside it
static const size_t whole_work = (size_t)1 << 24; // coefficients to look at

typedef struct box {
    double lo[3], hi[3];
} box;

typedef struct search {
    kn_ctx *ctx;
    kn_net net;          // one component; with a denominator two arrays
    size_t arrays, rows; // of each box: the arrays, then an error for each row of the third variable
    size_t work, spent;
    const kn_shell_jacobian_piece *p;
    box part; // of the region that p covers, in parameters
    bool positive, negative, undecided;
    double where[3]; // undecided
    kn_fold_sign found;
    double most; // the largest value found
    double *stack;
} search;

static double parameter(const search *s, int v, double x)
{
    return x == 1.0 ? s->part.hi[v] : s->part.lo[v] + x * (s->part.hi[v] - s->part.lo[v]);
}

static size_t size_of(const search *s)
{
    return s->arrays * s->net.count + s->rows;
}

// Of the coefficient k. Great heights have great errors, but low ones do not.
static double error_of(const search *s, const double *c, size_t k)
{
    return c[s->arrays * s->net.count + k % s->rows];
}

// ---- values: what was divided out comes back ----

// The factor f at both ends of variable v over [a,b], parameters: bounds of it, rounding included.
static void factor_range(const search *s, int v, double a, double b, double out[2])
{
    const kn_shell_jacobian_piece *p = s->p;
    out[0] = out[1] = 1.0;
    if (p->order[v][0] + p->order[v][1] == 0) return;
    double width = p->hi[v] - p->lo[v], x = fmax(0.0, (a - p->lo[v]) / width), y = fmin(1.0, (b - p->lo[v]) / width);
    for (int k = 0; k < p->order[v][0]; k++) out[0] *= x, out[1] *= y;
    for (int k = 0; k < p->order[v][1]; k++) out[0] *= 1.0 - y, out[1] *= 1.0 - x;
    out[0] *= 1.0 - 0x1p-40, out[1] = out[1] * (1.0 + 0x1p-40) + 0x1p-50;
}

// det from the coefficient k, where it is a value.
static double value_at(const search *s, const double *c, size_t k, const double at[3])
{
    double f[2], value = c[k];
    if (s->arrays > 1) value /= c[s->net.count + k];
    for (int v = 0; v < s->p->j.nvars && v < 3; v++) {
        double x = parameter(s, v, at[v]);
        factor_range(s, v, x, x, f);
        value *= f[0];
    }
    return value;
}

// Bounds of det over the box.
static void bounds(const search *s, double out[2], const double *c, const box *b)
{
    double lo = INFINITY, hi = -INFINITY, f[2], all[2] = {1.0, 1.0};
    for (size_t k = 0; k < s->net.count; k++) {
        double x = c[k] - error_of(s, c, k), y = c[k] + error_of(s, c, k);
        if (s->arrays > 1) {
            double d = c[s->net.count + k], off = 0x1p-40;
            x /= x > 0.0 ? d * (1.0 + off) : d * (1.0 - off);
            y /= y > 0.0 ? d * (1.0 - off) : d * (1.0 + off);
        }
        if (!(x <= y)) lo = -INFINITY, hi = INFINITY;
        lo = fmin(lo, x), hi = fmax(hi, y);
    }
    for (int v = 0; v < s->p->j.nvars; v++) {
        factor_range(s, v, parameter(s, v, b->lo[v]), parameter(s, v, b->hi[v]), f);
        all[0] *= f[0], all[1] *= f[1];
    }
    out[0] = lo * (lo > 0.0 ? all[0] : all[1]);
    out[1] = hi * (hi > 0.0 ? all[1] : all[0]);
}

static void look_at_corners(search *s, const double *c, const box *b)
{
    size_t row[2] = {(size_t)s->net.degree[1] + 1, (size_t)s->net.degree[2] + 1};
    for (int e = 0; e < 8; e++) {
        double at[3];
        size_t index[3];
        for (int v = 0; v < 3; v++) {
            bool end = (e >> v) % 2 == 1;
            at[v] = end ? b->hi[v] : b->lo[v];
            index[v] = end ? (size_t)s->net.degree[v] : 0;
        }
        size_t k = (index[0] * row[0] + index[1]) * row[1] + index[2];
        double value = value_at(s, c, k, at);
        if (c[k] > error_of(s, c, k)) s->positive = true;
        if (c[k] < -error_of(s, c, k)) s->negative = true;
        s->most = fmax(s->most, value);
        if (!(value < s->found.value)) continue;
        s->found.value = value;
        for (int v = 0; v < 3; v++) s->found.where[v] = parameter(s, v, at[v]);
    }
}

// ---- signs ----

// At an apex and w = 0 the Jacobian is 0, as T is one point there: such a coefficient is exactly 0, and takes no
// part.
static bool at_apex(const search *s, const box *b, size_t k)
{
    size_t row = (size_t)s->net.degree[2] + 1, columns = (size_t)s->net.degree[1] + 1;
    size_t at[2] = {k / row / columns, k / row % columns};
    if (k % row != 0 || parameter(s, 2, b->lo[2]) != 0.0) return false;
    for (int v = 0; v < 2; v++) {
        if (s->p->flat[v][0] && at[v] == 0 && parameter(s, v, b->lo[v]) == s->p->lo[v]) return true;
        if (s->p->flat[v][1] && at[v] == (size_t)s->net.degree[v] && parameter(s, v, b->hi[v]) == s->p->hi[v])
            return true;
    }
    return false;
}

// 1, -1, or 0: unknown.
static int sign_of(const search *s, const double *c, const box *b)
{
    bool positive = true, negative = true, apex = false;
    for (int v = 0; v < 2; v++) apex = apex || s->p->flat[v][0] || s->p->flat[v][1];
    for (size_t k = 0; k < s->net.count && (positive || negative); k++) {
        if (apex && c[k] == 0.0 && at_apex(s, b, k)) continue;
        positive = positive && c[k] > error_of(s, c, k);
        negative = negative && c[k] < -error_of(s, c, k);
    }
    return positive ? 1 : negative ? -1 : 0;
}

static double *level(const search *s, int depth, bool second)
{
    return s->stack + (depth == 0 ? 0 : (size_t)(2 * depth - (second ? 0 : 1))) * size_of(s);
}

static void halve(const search *s, int depth, bool second, int var)
{
    size_t inner = kn_net_inner(&s->net, var), m = (size_t)s->net.degree[var] + 1;
    double *half[2] = {level(s, depth + 1, false), level(s, depth + 1, true)}, *now = level(s, depth, second);
    size_t n = s->arrays * s->net.count;
    kn_bernstein_split(half[0], half[1], now, n / m / inner, s->net.degree[var], inner, 0.5);
    if (var == 2) kn_bernstein_split(half[0] + n, half[1] + n, now + n, 1, s->net.degree[2], 1, 0.5);
    for (int e = 0; e < 2 && var != 2; e++) memcpy(half[e] + n, now + n, s->rows * sizeof *now);
}

// Settles the box, or answers the variable along which to halve it. *known: its sign, 0 as long as it is not known.
static int visit(search *s, const double *c, const box *b, int depth, int *known)
{
    double r[2];
    int sign = *known = *known != 0 ? *known : sign_of(s, c, b);
    look_at_corners(s, c, b);
    bounds(s, r, c, b);
    double reach = margin * (s->most - s->found.value);
    bool settled = sign != 0 || (s->positive && s->negative) || s->undecided;
    bool fine = depth >= FINE ||
                (r[0] >= fmin(s->found.lo, s->found.value - reach) && r[1] <= fmax(s->found.hi, s->most + reach));
    bool last = depth == DEPTH || s->spent >= s->work;
    s->spent += s->net.count;
    if ((!settled || !fine) && !last) {
        double least = INFINITY;
        for (size_t l = 0; l < s->rows; l++) least = fmin(least, error_of(s, c, l));
        int var = kn_net_steepest(&s->net, c, &least);
        if (var >= 0) return var;
    }
    if (!settled && !s->undecided) {
        s->undecided = true;
        for (int v = 0; v < 3; v++) s->where[v] = parameter(s, v, 0.5 * (b->lo[v] + b->hi[v]));
    }
    s->positive = s->positive || sign > 0;
    s->negative = s->negative || sign < 0;
    s->found.lo = fmin(s->found.lo, r[0]);
    s->found.hi = fmax(s->found.hi, r[1]);
    return -1;
}

// Depth first: level k >= 1 keeps its halves at 2k - 1 and 2k, level 0 is the whole.
static kn_status divide(search *s)
{
    box b[DEPTH + 1];
    int var[DEPTH + 1] = {0}, sign[DEPTH + 1] = {0}, depth = 0;
    bool second[DEPTH + 1] = {false};
    size_t count = 0, rhythm = kn_net_rhythm(s->net.count);
    b[0] = (box){{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}};
    for (;;) {
        if (++count % rhythm == 0) {
            kn_status status = kn_progress(s->ctx, "Jacobian", (double)s->spent / (double)s->work);
            if (status != KN_OK) return status;
        }
        int along = visit(s, level(s, depth, second[depth]), &b[depth], depth, &sign[depth]);
        if (along >= 0) {
            halve(s, depth, second[depth], along);
            var[depth] = along;
            b[depth + 1] = b[depth];
            b[depth + 1].hi[along] = 0.5 * (b[depth].lo[along] + b[depth].hi[along]);
            second[++depth] = false;
            sign[depth] = sign[depth - 1];
            continue;
        }
        while (depth > 0 && second[depth]) depth--;
        if (depth == 0) return KN_OK;
        second[depth] = true;
        sign[depth] = sign[depth - 1];
        int v = var[depth - 1];
        b[depth].lo[v] = b[depth].hi[v];
        b[depth].hi[v] = b[depth - 1].hi[v];
    }
}

// ---- the pieces of the region ----

// The part of the region in p's box, in its own coordinates (heights themselves unless T is a volume), and in
// parameters; a little wider, so that rounding loses nothing. False when there is none.
static bool cut(box *local, box *part, const kn_shell_jacobian_piece *p, const double lo[3], const double hi[3])
{
    for (int v = 0; v < 3; v++) {
        double a = fmax(lo[v], p->lo[v]), b = fmin(hi[v], p->hi[v]), width = p->hi[v] - p->lo[v];
        if (a > b) return false;
        part->lo[v] = local->lo[v] = a, part->hi[v] = local->hi[v] = b;
        if (v == 2 && p->j.nvars == 2) continue;
        local->lo[v] = a == p->lo[v] ? 0.0 : fmax(0.0, (a - p->lo[v]) / width - 0x1p-50);
        local->hi[v] = b == p->hi[v] ? 1.0 : fmin(1.0, (b - p->lo[v]) / width + 0x1p-50);
    }
    return true;
}

// The errors of the rows, with room for the rounding of all halvings: these are means, of errors as of coefficients.
static void take_errors(search *s, const double *error)
{
    double roundings = 4.0 * (s->net.degree[0] + s->net.degree[1] + s->net.degree[2] + 3.0) * DEPTH;
    for (size_t l = 0; l < s->rows; l++) {
        double most = 0.0;
        for (size_t k = l; k < s->net.count; k += s->rows) most = fmax(most, fabs(s->stack[k]));
        s->stack[s->arrays * s->net.count + l] = 1.001 * (error[l] + kn_rounding(roundings) * most) + kn_underflow();
    }
}

static kn_status search_piece(kn_ctx *ctx, search *s, kn_shell_jacobian_piece *p, const box *local)
{
    kn_mark mark = kn_scratch_mark(ctx);
    double error[KN_FOLD_ROWS];
    kn_status status = kn_fold_to_box(ctx, p, error, local->lo, local->hi);
    if (status == KN_OK) {
        s->net = kn_net_make(3, 1, p->j.degree);
        s->arrays = p->denominator.coef ? 2 : 1;
        s->rows = (size_t)p->j.degree[2] + 1;
        s->stack = kn_scratch(ctx, (2 * DEPTH + 1) * size_of(s), sizeof *s->stack);
        if (!s->stack) status = KN_ENOMEM;
    }
    if (status == KN_OK) {
        size_t n = s->net.count;
        memcpy(s->stack, p->j.coef, n * sizeof *s->stack);
        if (s->arrays > 1) memcpy(s->stack + n, p->denominator.coef, n * sizeof *s->stack);
        take_errors(s, error);
        status = divide(s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status check(kn_ctx *ctx, double from[3], double to[3], const kn_shell *shell, const double lo[3],
                       const double hi[3])
{
    double a[3], b[3], w[2];
    for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(shell), v, &a[v], &b[v]);
    kn_shell_heights(shell, w);
    a[2] = w[0], b[2] = w[1];
    for (int v = 0; v < 3; v++) {
        if (!isfinite(lo[v]) || !isfinite(hi[v]) || lo[v] > hi[v])
            return kn_fail(ctx, KN_EDOMAIN, "fold: [%g, %g] in variable %d", lo[v], hi[v], v);
        if (lo[v] > b[v] || hi[v] < a[v])
            return kn_fail(ctx, KN_EDOMAIN, "fold: [%g, %g] in variable %d lies outside the domain [%g, %g]", lo[v],
                           hi[v], v, a[v], b[v]);
        from[v] = fmax(lo[v], a[v]), to[v] = fmin(hi[v], b[v]);
    }
    return KN_OK;
}

static void answer(kn_fold_sign *out, const search *s)
{
    *out = s->found;
    out->verdict = s->positive && s->negative ? KN_FOLD_MIXED
                   : s->undecided             ? KN_FOLD_UNDECIDED
                   : s->positive              ? KN_FOLD_POSITIVE
                                              : KN_FOLD_NEGATIVE;
    if (out->verdict == KN_FOLD_UNDECIDED) memcpy(out->where, s->where, sizeof s->where);
}

kn_status kn_fold_jacobian_sign(kn_ctx *ctx, kn_fold_sign *out, const kn_shell *shell, const double lo[3],
                                const double hi[3])
{
    double from[3] = {0}, to[3] = {0};
    kn_status status = check(ctx, from, to, shell, lo, hi);
    if (status != KN_OK) return status;
    search s = {.ctx = ctx, .work = whole_work, .most = -INFINITY};
    s.found = (kn_fold_sign){.value = INFINITY, .lo = INFINITY, .hi = -INFINITY};
    size_t n = kn_fold_boxes(shell);
    for (size_t k = 0; k < n && status == KN_OK; k++) {
        kn_shell_jacobian_piece p = {0};
        box local;
        status = kn_fold_piece(ctx, &p, shell, k);
        s.p = &p;
        if (status == KN_OK && cut(&local, &s.part, &p, from, to)) status = search_piece(ctx, &s, &p, &local);
        kn_shell_jacobian_piece_clear(ctx, &p);
    }
    if (status == KN_OK) answer(out, &s);
    return status;
}
