// SPDX-License-Identifier: Apache-2.0
// The zero set of the Jacobian as triangles: roots in w over a grid of (u,v), joined to their nearest neighbours.
#include "fold/internal.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

static const size_t none = SIZE_MAX;

typedef struct sheet {
    const kn_shell *shell;
    kn_spline *j;
    int nj;
    double w[2];
    size_t n[2], levels;
    double *at[2], *height; // levels of w at which the sign is looked at
    double *c;              // powers of w at every place of the grid; of a volume J at every level
    size_t *first;          // roots of place p: first[p] .. first[p+1] - 1
    double *root;           // and where they lie
    size_t nroots, room;
} sheet;

// ---- roots ----

static kn_status evaluate(kn_ctx *ctx, double *x, const sheet *s, size_t place, double w)
{
    if (s->j[0].nvars == 3) {
        const double at[3] = {s->at[0][place / s->n[1]], s->at[1][place % s->n[1]], w};
        return kn_spline_eval(ctx, x, &s->j[0], at);
    }
    *x = 0.0;
    for (int k = s->nj - 1; k >= 0; k--) *x = *x * w + s->c[(size_t)k * s->n[0] * s->n[1] + place];
    return KN_OK;
}

static kn_status add_root(kn_ctx *ctx, sheet *s, size_t place, double a, double b, bool sign)
{
    double x;
    if (s->nroots == s->room) {
        size_t room = 2 * s->room + 64;
        double *more = kn_resize(ctx, s->root, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        s->root = more, s->room = room;
    }
    for (int k = 0; k < 48; k++) {
        double middle = 0.5 * (a + b);
        kn_status status = evaluate(ctx, &x, s, place, middle);
        if (status != KN_OK) return status;
        if ((x >= 0.0) == sign)
            a = middle;
        else
            b = middle;
    }
    s->root[s->nroots++] = 0.5 * (a + b);
    return KN_OK;
}

static kn_status find_roots(kn_ctx *ctx, sheet *s)
{
    size_t places = s->n[0] * s->n[1];
    bool volume = s->j[0].nvars == 3;
    kn_status status = KN_OK;
    for (size_t p = 0; p < places && status == KN_OK; p++) {
        double x;
        bool before = false;
        s->first[p] = s->nroots;
        for (size_t l = 0; l < s->levels && status == KN_OK; l++) {
            if (volume)
                x = s->c[p * s->levels + l];
            else
                status = evaluate(ctx, &x, s, p, s->height[l]);
            if (l > 0 && status == KN_OK && (x >= 0.0) != before)
                status = add_root(ctx, s, p, s->height[l - 1], s->height[l], before);
            before = x >= 0.0;
        }
        if (status == KN_OK && p % 4096 == 0) status = kn_progress(ctx, "zero set", (double)p / (double)places);
    }
    s->first[places] = s->nroots;
    return status;
}

static kn_status sample(kn_ctx *ctx, sheet *s)
{
    size_t places = s->n[0] * s->n[1];
    bool volume = s->j[0].nvars == 3;
    int spans = volume ? kn_spline_spans(&s->j[0], 2) : 1;
    s->levels = 4 * (size_t)(volume ? s->j[0].degree[2] * spans : s->nj) + 5;
    const double *at[3] = {s->at[0], s->at[1], NULL};
    size_t n[3] = {s->n[0], s->n[1], s->levels};
    s->height = kn_scratch(ctx, s->levels, sizeof *s->height);
    s->c = kn_scratch(ctx, places * (volume ? s->levels : (size_t)s->nj), sizeof *s->c);
    s->first = kn_scratch(ctx, places + 1, sizeof *s->first);
    if (!s->height || !s->c || !s->first) return KN_ENOMEM;
    for (size_t l = 0; l < s->levels; l++)
        s->height[l] = s->w[0] + (s->w[1] - s->w[0]) * (double)l / (double)(s->levels - 1);
    at[2] = s->height;
    kn_status status = KN_OK;
    for (int k = 0; k < s->nj && status == KN_OK; k++)
        status = kn_spline_eval_grid(ctx, s->c + (size_t)k * places, &s->j[k], n, at);
    return status;
}

// ---- triangles ----

// The root of place b that is nearest to root r, if r is also the nearest to it; none.
static size_t nearest(const sheet *s, size_t place, double w)
{
    size_t best = none;
    for (size_t k = s->first[place]; k < s->first[place + 1]; k++)
        if (best == none || fabs(s->root[k] - w) < fabs(s->root[best] - w)) best = k;
    return best;
}

static size_t match(const sheet *s, size_t a, size_t r, size_t b)
{
    size_t k = nearest(s, b, s->root[r]);
    bool near = k != none && fabs(s->root[k] - s->root[r]) <= 0.5 * (s->w[1] - s->w[0]);
    return near && nearest(s, a, s->root[k]) == r ? k : none;
}

static void triangle(kn_mesh *m, const sheet *s, size_t a, size_t b, size_t c)
{
    for (size_t r = s->first[a]; r < s->first[a + 1]; r++) {
        size_t q = match(s, a, r, b), t = match(s, a, r, c);
        if (q == none || t == none || match(s, b, q, c) != t) continue;
        uint32_t *to = m->triangle + 3 * m->ntriangles++;
        to[0] = (uint32_t)r, to[1] = (uint32_t)q, to[2] = (uint32_t)t;
    }
}

static void add_normals(kn_mesh *m)
{
    memset(m->normal, 0, 3 * m->nvertices * sizeof *m->normal);
    for (size_t t = 0; t < m->ntriangles; t++) {
        const uint32_t *v = m->triangle + 3 * t;
        const double *p = m->position + 3 * v[0], *q = m->position + 3 * v[1], *r = m->position + 3 * v[2];
        for (int c = 0; c < 3; c++) {
            int d = (c + 1) % 3, e = (c + 2) % 3;
            double x = (q[d] - p[d]) * (r[e] - p[e]) - (q[e] - p[e]) * (r[d] - p[d]);
            for (int k = 0; k < 3; k++) m->normal[3 * v[k] + (uint32_t)c] += x;
        }
    }
    for (size_t i = 0; i < m->nvertices; i++) {
        double *n = m->normal + 3 * i, length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        bool there = length > 0.0 && isfinite(length);
        for (int c = 0; c < 3; c++) n[c] = there ? n[c] / length : c == 2 ? 1.0 : 0.0;
    }
}

static kn_status build(kn_ctx *ctx, kn_mesh *m, const sheet *s)
{
    if (s->nroots > UINT32_MAX) return kn_fail(ctx, KN_ELIMIT, "fold: %zu vertices", s->nroots);
    size_t places = s->n[0] * s->n[1];
    m->vertex_room = m->nvertices = s->nroots;
    m->triangle_room = 2 * s->nroots;
    m->position = kn_alloc(ctx, 3 * m->vertex_room, sizeof *m->position);
    m->normal = kn_alloc(ctx, 3 * m->vertex_room, sizeof *m->normal);
    m->triangle = kn_alloc(ctx, 3 * m->triangle_room, sizeof *m->triangle);
    if (!m->position || !m->normal || !m->triangle) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (size_t p = 0; p < places; p++)
        for (size_t r = s->first[p]; r < s->first[p + 1] && status == KN_OK; r++)
            status = kn_shell_eval(ctx, m->position + 3 * r, NULL, s->shell, s->at[0][p / s->n[1]],
                                   s->at[1][p % s->n[1]], s->root[r]);
    for (size_t i = 0; i + 1 < s->n[0]; i++)
        for (size_t j = 0; j + 1 < s->n[1]; j++) {
            size_t a = i * s->n[1] + j, b = a + s->n[1];
            triangle(m, s, a, b, b + 1);
            triangle(m, s, a, b + 1, a + 1);
        }
    if (status == KN_OK) add_normals(m);
    return status;
}

kn_status kn_fold_surface(kn_ctx *ctx, kn_mesh *out, const kn_shell *shell, double w0, double w1, int steps)
{
    if (!(w0 < w1) || !isfinite(w0) || !isfinite(w1))
        return kn_fail(ctx, KN_EDOMAIN, "fold: heights [%g, %g]", w0, w1);
    sheet s = {.shell = shell, .w = {w0, w1}};
    kn_mesh m = {0};
    int weight;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_fold_parameters(ctx, s.at, s.n, shell, steps);
    if (status == KN_OK) status = kn_shell_jacobian(ctx, &s.j, &s.nj, &weight, shell);
    if (status == KN_OK) status = sample(ctx, &s);
    if (status == KN_OK) status = find_roots(ctx, &s);
    if (status == KN_OK) status = build(ctx, &m, &s);
    if (status == KN_OK) {
        kn_mesh_clear(ctx, out);
        *out = m;
    } else {
        kn_mesh_clear(ctx, &m);
    }
    kn_fold_clear_splines(ctx, s.j, s.nj);
    kn_free(ctx, s.root);
    for (int v = 0; v < 2; v++) kn_free(ctx, s.at[v]);
    kn_scratch_release(ctx, mark);
    return status;
}
