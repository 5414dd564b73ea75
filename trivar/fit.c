// SPDX-License-Identifier: Apache-2.0
// The spline that interpolates the unit normal of S on the sites of a grid.
#include "kernel/banded.h"
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

typedef struct values {
    const kn_shell *shell;
    const kn_grid_axis *u, *v;
    size_t room[2];
    double *row;          // 3 x room[1] for each span in v: directions contracted at one site in u
    double *data;         // (ncomp, sites in u, sites in v)
    size_t ncomp;         // 3: unit normals, 1: 1/|factor N|
    const double *factor; // of each span of S
} values;

static double local(const double *breaks, int span, double x)
{
    return (x - breaks[span]) / (breaks[span + 1] - breaks[span]);
}

static void contract_row(values *w, int i)
{
    const kn_shell *s = w->shell;
    int from = w->u->site_span[i], columns = s->nknots[1] - 1;
    double basis[KN_MAX_DEGREE + 1], x = local(s->knot[0], from, w->u->site[i]);
    for (int k = 0; k < columns; k++) {
        const kn_bezier *n = &s->direction[from * columns + k].n;
        kn_bernstein_basis(basis, n->degree[0], x);
        kn_bernstein_contract(w->row + (size_t)k * 3 * w->room[1], n->coef, 3, n->degree[0] + 1,
                              (size_t)n->degree[1] + 1, basis);
    }
}

// Edge factors were divided out, so that neighbouring spans may differ in degree: each site uses its own.
static kn_status value_row(kn_ctx *ctx, values *w, int i)
{
    const kn_shell *s = w->shell;
    int columns = s->nknots[1] - 1;
    size_t nv = (size_t)w->v->count, plane = (size_t)w->u->count * nv;
    double basis[KN_MAX_DEGREE + 1];
    contract_row(w, i);
    for (size_t j = 0; j < nv; j++) {
        int from = w->v->site_span[j];
        int span = w->u->site_span[i] * columns + from;
        const kn_bezier *n = &s->direction[span].n;
        double d[3], square = 0.0;
        kn_bernstein_basis(basis, n->degree[1], local(s->knot[1], from, w->v->site[j]));
        kn_bernstein_contract(d, w->row + (size_t)from * 3 * w->room[1], 3, n->degree[1] + 1, 1, basis);
        double largest = fmax(fabs(d[0]), fmax(fabs(d[1]), fabs(d[2])));
        if (!(largest > 0.0) || !isfinite(largest))
            return kn_fail_normal(ctx, s, (const double[2]){w->u->site[i], w->v->site[j]}, true);
        for (int c = 0; c < 3; c++) square += (d[c] / largest) * (d[c] / largest);
        double *to = w->data + (size_t)i * nv + j;
        if (w->ncomp == 1) *to = 1.0 / (w->factor[span] * largest * sqrt(square));
        for (size_t c = 0; c < 3 && w->ncomp == 3; c++) to[c * plane] = d[c] / largest / sqrt(square);
    }
    return KN_OK;
}

// ---- edges that are one point ----

// The normals along a pole become one vector bit for bit, and so does T there: a point of S stays one fibre, without
// a slit. At an apex each parameter line keeps its own limit.
static void unify_edge(values *w, int var, bool at_end)
{
    size_t nu = (size_t)w->u->count, nv = (size_t)w->v->count, plane = nu * nv;
    size_t cross = var == 0 ? nv : nu, step = var == 0 ? 1 : nv;
    size_t first = at_end ? (var == 0 ? (nu - 1) * nv : nv - 1) : 0;
    double mean[3] = {0}, square = 0.0;
    for (size_t c = 0; c < 3; c++) {
        for (size_t k = 0; k < cross; k++) mean[c] += w->data[c * plane + first + k * step];
        square += mean[c] * mean[c];
    }
    for (size_t k = 0; k < 3 * cross; k++)
        w->data[k / cross * plane + first + k % cross * step] = mean[k / cross] / sqrt(square);
}

// Where a closed S goes on over its seam, both sides have one value bit for bit, and so have n and all that is composed
// with it. Nothing is changed by more than rounding.
static void unify_seam(values *w, int var)
{
    const double near = 1e-12;
    size_t nu = (size_t)w->u->count, nv = (size_t)w->v->count, plane = nu * nv;
    size_t cross = var == 0 ? nv : nu, step = var == 0 ? 1 : nv, far = var == 0 ? (nu - 1) * nv : nv - 1;
    for (size_t k = 0; k < cross; k++) {
        double off = 0.0, size = 0.0;
        for (size_t c = 0; c < w->ncomp; c++) {
            const double *at = w->data + c * plane + k * step;
            off = fmax(off, fabs(at[far] - at[0])), size = fmax(size, fabs(at[0]));
        }
        for (size_t c = 0; c < w->ncomp && off <= near * size; c++) {
            double *at = w->data + c * plane + k * step;
            at[far] = at[0];
        }
    }
}

// Interpolation of a constant gives it back but for rounding: take that away.
static void flatten_edge(values *w, int var, bool at_end)
{
    size_t nu = (size_t)w->u->count, nv = (size_t)w->v->count, plane = nu * nv;
    size_t cross = var == 0 ? nv : nu, step = var == 0 ? 1 : nv;
    size_t first = at_end ? (var == 0 ? (nu - 1) * nv : nv - 1) : 0;
    for (size_t k = 0; k < 3 * cross; k++)
        w->data[k / cross * plane + first + k % cross * step] = w->data[k / cross * plane + first];
}

// ---- the fit ----

static kn_status solve(kn_ctx *ctx, double *data, const kn_grid_axis *g, size_t outer, size_t inner)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_collocation c = {.count = g->count, .degree = g->degree};
    c.band = kn_scratch(ctx, kn_collocation_room(g->count, g->degree), sizeof *c.band);
    if (c.band) {
        kn_collocation_factor(&c, g->knots, g->site, g->site_knot_span);
        kn_collocation_solve(&c, data, outer, inner);
    }
    kn_scratch_release(ctx, mark);
    return c.band ? KN_OK : KN_ENOMEM;
}

static kn_status interpolate(kn_ctx *ctx, values *w)
{
    const kn_shell *s = w->shell;
    size_t nu = (size_t)w->u->count, nv = (size_t)w->v->count;
    bool pole[2][2] = {{false}};
    kn_status status = KN_OK;
    for (int i = 0; i < w->u->count && status == KN_OK; i++) status = value_row(ctx, w, i);
    if (status != KN_OK) return status;
    for (int e = 0; e < 4 && w->ncomp == 3; e++) {
        pole[e / 2][e % 2] = kn_edge_of(s, e / 2, e % 2).kind == KN_EDGE_POLE;
        if (pole[e / 2][e % 2]) unify_edge(w, e / 2, e % 2);
    }
    for (int v = 0; v < 2; v++)
        if (s->closed[v]) unify_seam(w, v);
    status = solve(ctx, w->data, w->u, w->ncomp, nv);
    if (status == KN_OK) status = solve(ctx, w->data, w->v, w->ncomp * nu, 1);
    for (int e = 0; e < 4 && status == KN_OK; e++)
        if (pole[e / 2][e % 2]) flatten_edge(w, e / 2, e % 2);
    return status;
}

static kn_status fit(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, const kn_grid_axis axes[2], size_t ncomp,
                     const double *factor)
{
    values w = {.shell = shell, .u = &axes[0], .v = &axes[1], .ncomp = ncomp, .factor = factor};
    for (size_t i = 0; i < shell->ndirections; i++)
        for (int v = 0; v < 2; v++) {
            size_t n = (size_t)shell->direction[i].n.degree[v] + 1;
            w.room[v] = n > w.room[v] ? n : w.room[v];
        }
    kn_mark mark = kn_scratch_mark(ctx);
    w.row = kn_scratch(ctx, 3 * w.room[1] * (size_t)(shell->nknots[1] - 1), sizeof *w.row);
    w.data = kn_scratch(ctx, ncomp * (size_t)axes[0].count * (size_t)axes[1].count, sizeof *w.data);
    kn_status status = w.row && w.data ? interpolate(ctx, &w) : KN_ENOMEM;
    if (status == KN_OK) {
        int degree[2] = {axes[0].degree, axes[1].degree}, count[2] = {axes[0].count, axes[1].count};
        const double *knots[2] = {axes[0].knots, axes[1].knots};
        status = kn_spline_init(ctx, out, 2, (int)ncomp, false, degree, count, knots, w.data);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_fit_normal(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, const kn_grid_axis axes[2])
{
    return fit(ctx, out, shell, axes, 3, NULL);
}

kn_status kn_fit_reciprocal(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, const kn_grid_axis axes[2],
                            const double *factor)
{
    return fit(ctx, out, shell, axes, 1, factor);
}
