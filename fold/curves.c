// SPDX-License-Identifier: Apache-2.0
// Where the Jacobian vanishes at one height, as polylines on the base: marching squares.
#include "fold/internal.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

static const size_t none = SIZE_MAX;

// Points lie on edges of the grid: number 2 (i n1 + j) on that from (i,j) to (i+1,j), one more to (i,j+1).
typedef struct march {
    const kn_spline *f;
    size_t n[2];
    double *at[2], *value;
    double *point;     // two numbers for each edge
    size_t (*link)[2]; // the points that it is joined to
    bool *taken;
} march;

// ---- J at this height as one spline ----

static kn_status at_height(kn_ctx *ctx, kn_spline *f, const kn_shell *shell, double w)
{
    kn_spline *list = NULL;
    int n = 0, weight = 0;
    kn_status status = kn_shell_jacobian(ctx, &list, &n, &weight, shell);
    if (status != KN_OK) return status;
    if (list[0].nvars == 3) {
        status = kn_spline_isoparametric(ctx, f, &list[0], 2, w);
    } else {
        double power = 1.0;
        size_t count = kn_spline_count(&list[0]);
        for (int k = 1; k < n; k++) { // they share their knots
            power *= w;
            for (size_t i = 0; i < count; i++) list[0].coef[i] += power * list[k].coef[i];
        }
        kn_spline_swap(f, &list[0]);
    }
    kn_fold_clear_splines(ctx, list, n);
    return status;
}

// ---- points on edges ----

static bool sign_at(const march *m, size_t i, size_t j)
{
    return m->value[i * m->n[1] + j] >= 0.0;
}

static kn_status bisect(kn_ctx *ctx, double out[2], const march *m, const size_t at[2], int var)
{
    double a[2] = {m->at[0][at[0]], m->at[1][at[1]]}, b[2] = {a[0], a[1]}, x;
    bool sign = sign_at(m, at[0], at[1]);
    b[var] = m->at[var][at[var] + 1];
    for (int k = 0; k < 48; k++) {
        memcpy(out, a, sizeof a);
        out[var] = 0.5 * (a[var] + b[var]);
        kn_status status = kn_spline_eval(ctx, &x, m->f, out);
        if (status != KN_OK) return status;
        if ((x >= 0.0) == sign)
            a[var] = out[var];
        else
            b[var] = out[var];
    }
    return KN_OK;
}

static kn_status find_points(kn_ctx *ctx, march *m)
{
    kn_status status = KN_OK;
    for (size_t i = 0; i < m->n[0] && status == KN_OK; i++)
        for (size_t j = 0; j < m->n[1] && status == KN_OK; j++)
            for (int v = 0; v < 2 && status == KN_OK; v++) {
                size_t at[2] = {i, j}, edge = 2 * (i * m->n[1] + j) + (size_t)v;
                m->link[edge][0] = m->link[edge][1] = none;
                m->taken[edge] = true;
                if (at[v] + 1 == m->n[v] || sign_at(m, i, j) == sign_at(m, i + (v == 0), j + (v == 1))) continue;
                m->taken[edge] = false;
                status = bisect(ctx, m->point + 2 * edge, m, at, v);
            }
    return status;
}

// ---- squares ----

static void join(march *m, size_t a, size_t b)
{
    m->link[a][m->link[a][0] == none ? 0 : 1] = b;
    m->link[b][m->link[b][0] == none ? 0 : 1] = a;
}

// The four edges of a square in turn; where all four are crossed the sign in the middle tells which belong together.
static kn_status square(kn_ctx *ctx, march *m, size_t i, size_t j)
{
    size_t here = 2 * (i * m->n[1] + j), edge[4] = {here, here + 2 * m->n[1] + 1, here + 2, here + 1}, crossed[4];
    bool c[4] = {sign_at(m, i, j), sign_at(m, i + 1, j), sign_at(m, i + 1, j + 1), sign_at(m, i, j + 1)};
    int n = 0;
    for (int k = 0; k < 4; k++)
        if (c[k] != c[(k + 1) % 4]) crossed[n++] = edge[k];
    if (n == 2) join(m, crossed[0], crossed[1]);
    if (n != 4) return KN_OK;
    double at[2] = {0.5 * (m->at[0][i] + m->at[0][i + 1]), 0.5 * (m->at[1][j] + m->at[1][j + 1])}, x;
    kn_status status = kn_spline_eval(ctx, &x, m->f, at);
    int turn = status == KN_OK && (x >= 0.0) == c[0] ? 0 : 3; // corner 0 goes with the middle: cut off 1 and 3
    join(m, edge[turn], edge[(turn + 1) % 4]);
    join(m, edge[(turn + 2) % 4], edge[(turn + 3) % 4]);
    return status;
}

// ---- lines ----

typedef struct lines {
    double *point;
    size_t *end, npoints, nlines;
} lines;

static void add(lines *out, const march *m, size_t edge)
{
    memcpy(out->point + 2 * out->npoints++, m->point + 2 * edge, 2 * sizeof *out->point);
}

static void follow(lines *out, march *m, size_t start)
{
    size_t now = start, before = none;
    for (;;) {
        add(out, m, now);
        m->taken[now] = true;
        size_t next = m->link[now][0] != before ? m->link[now][0] : m->link[now][1];
        if (next != none && next == start && before != none) add(out, m, start); // closed
        if (next == none || m->taken[next]) break;
        before = now;
        now = next;
    }
    out->end[out->nlines++] = out->npoints;
}

// Open lines from their ends, then closed ones.
static kn_status trace(kn_ctx *ctx, lines *out, march *m)
{
    size_t edges = 2 * m->n[0] * m->n[1], points = 0;
    for (size_t e = 0; e < edges; e++) points += !m->taken[e];
    out->point = kn_alloc(ctx, 4 * points, sizeof *out->point); // a closed line has its first point twice
    out->end = kn_alloc(ctx, points, sizeof *out->end);
    if (!out->point || !out->end) return KN_ENOMEM;
    for (int round = 0; round < 2; round++)
        for (size_t e = 0; e < edges; e++)
            if (!m->taken[e] && m->link[e][0] != none && (round == 1 || m->link[e][1] == none)) follow(out, m, e);
    return KN_OK;
}

static kn_status march_on(kn_ctx *ctx, lines *out, march *m)
{
    size_t all = m->n[0] * m->n[1];
    const double *const at[2] = {m->at[0], m->at[1]};
    m->value = kn_scratch(ctx, all, sizeof *m->value);
    m->point = kn_scratch(ctx, 4 * all, sizeof *m->point);
    m->link = kn_scratch(ctx, 2 * all, sizeof *m->link);
    m->taken = kn_scratch(ctx, 2 * all, sizeof *m->taken);
    if (!m->value || !m->point || !m->link || !m->taken) return KN_ENOMEM;
    kn_status status = kn_spline_eval_grid(ctx, m->value, m->f, m->n, at);
    if (status == KN_OK) status = find_points(ctx, m);
    for (size_t i = 0; i + 1 < m->n[0] && status == KN_OK; i++)
        for (size_t j = 0; j + 1 < m->n[1] && status == KN_OK; j++) status = square(ctx, m, i, j);
    return status == KN_OK ? trace(ctx, out, m) : status;
}

kn_status kn_fold_curves(kn_ctx *ctx, double **points, size_t **ends, size_t *nlines, const kn_shell *shell, double w,
                         int steps)
{
    if (!isfinite(w)) return kn_fail(ctx, KN_EDOMAIN, "fold: curves at height %g", w);
    march m = {0};
    lines out = {0};
    kn_spline f = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_fold_parameters(ctx, m.at, m.n, shell, steps);
    if (status == KN_OK) status = at_height(ctx, &f, shell, w);
    m.f = &f;
    if (status == KN_OK) status = march_on(ctx, &out, &m);
    if (status == KN_OK) {
        *points = out.point;
        *ends = out.end;
        *nlines = out.nlines;
    } else {
        kn_free(ctx, out.point);
        kn_free(ctx, out.end);
    }
    kn_spline_clear(ctx, &f);
    for (int v = 0; v < 2; v++) kn_free(ctx, m.at[v]);
    kn_scratch_release(ctx, mark);
    return status;
}
