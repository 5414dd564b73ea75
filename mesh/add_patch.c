// SPDX-License-Identifier: Apache-2.0
// kn_mesh_add_patch: a patch on a uniform grid of parameters.
//
// Values are B(r) C B(t)^T with tables of Bernstein polynomials. Two neighbours may run their common edge in opposite
// directions and still get the same points bit for bit, because the tables are made symmetric,
// B_k(i / s) = B_(n-k)((s - i) / s) to the last bit, and sums are taken in pairs (k, n - k).
// At an end of the grid the table is exactly (1, 0, .., 0), so that an edge does not feel the other control points.
// First derivatives come from differences of control points: they are exactly zero along an edge whose control points
// are all equal.
#include "kernel/bernstein.h"
#include "mesh/net.h"

#include <knurl/mesh.h>

#include <math.h>
#include <string.h>

// value[p] = B_p(i / s) as described above; by_degree: table (n + 1, s + 1), else (s + 1, n + 1).
static void fill_table(double *table, int n, int s, bool by_degree, double *basis)
{
    size_t rows = (size_t)s + 1, cols = (size_t)n + 1;
    for (int i = 0; 2 * i <= s; i++) {
        kn_bernstein_basis(basis, n, (double)i / s);
        for (int k = 0; k <= n; k++) {
            double value = 2 * i == s && 2 * k > n ? basis[n - k] : basis[k];
            size_t a = (size_t)i, b = (size_t)k, c = (size_t)(s - i), d = (size_t)(n - k);
            table[by_degree ? b * rows + a : a * cols + b] = value;
            table[by_degree ? d * rows + c : c * cols + d] = value;
        }
    }
}

// Everything a grid needs, in scratch: tables by degree (rows) for t, by grid line for r.
typedef struct grid {
    int a, b;                // segments in r and t
    double *at_r, *slope_r;  // (a + 1, n + 1) and (a + 1, n)
    double *at_t, *slope_t;  // (m + 1, b + 1) and (m, b + 1)
    double *row, *step;      // one line of r: coefficients in t of the value, and their differences
    double *value, *dr, *dt; // (ncomp, b + 1) each
    double *work;            // for normal_at, and for tables
} grid;

static kn_status grid_init(kn_ctx *ctx, grid *g, const kn_patch_net *net, const int segments[2])
{
    size_t n = (size_t)net->n, m = (size_t)net->m, nc = (size_t)net->ncomp;
    size_t a1 = (size_t)segments[0] + 1, b1 = (size_t)segments[1] + 1;
    size_t size = a1 * (2 * n + 1) + b1 * (2 * m + 1) + 2 * (m + 1) + 3 * nc * b1 + 2 * (n + 1) + 3 * (m + 1);
    double *at = kn_scratch(ctx, size, sizeof *at);
    if (!at) return KN_ENOMEM;
    g->a = segments[0], g->b = segments[1];
    g->at_r = at, at += a1 * (n + 1);
    g->slope_r = at, at += a1 * n;
    g->at_t = at, at += b1 * (m + 1);
    g->slope_t = at, at += b1 * m;
    g->row = at, at += m + 1;
    g->step = at, at += m + 1;
    g->value = at, at += nc * b1;
    g->dr = at, at += nc * b1;
    g->dt = at, at += nc * b1;
    g->work = at, at += 2 * (n + 1) + 3 * (m + 1);
    fill_table(g->at_r, net->n, g->a, false, g->work);
    fill_table(g->at_t, net->m, g->b, true, g->work);
    if (n > 0) fill_table(g->slope_r, net->n - 1, g->a, false, g->work);
    if (m > 0) fill_table(g->slope_t, net->m - 1, g->b, true, g->work);
    return KN_OK;
}

// Points and normals of grid line i in r.
static void line_of_vertices(double *position, double *normal, const kn_patch_net *net, grid *g, int i, double sign)
{
    size_t n1 = (size_t)net->n + 1, m1 = (size_t)net->m + 1, b1 = (size_t)g->b + 1;
    for (int c = 0; c < net->ncomp; c++) {
        kn_patch_net_combine(g->row, g->at_r + (size_t)i * n1, net->coef + (size_t)c * n1 * m1, net->n, m1);
        kn_patch_net_combine(g->value + (size_t)c * b1, g->row, g->at_t, net->m, b1);
        kn_patch_net_differences(g->step, g->row, net->m);
        kn_patch_net_combine(g->dt + (size_t)c * b1, g->step, g->slope_t, net->m - 1, b1);
        kn_patch_net_combine(g->row, g->slope_r + (size_t)i * (n1 - 1), net->step + (size_t)c * (n1 - 1) * m1,
                             net->n - 1, m1);
        kn_patch_net_combine(g->dr + (size_t)c * b1, g->row, g->at_t, net->m, b1);
    }
    for (size_t j = 0; j < b1; j++) {
        double value[4], dr[4], dt[4];
        for (int c = 0; c < net->ncomp; c++) {
            size_t at = (size_t)c * b1 + j;
            value[c] = g->value[at], dr[c] = g->dr[at], dt[c] = g->dt[at];
        }
        for (int c = 0; c < 3; c++) position[3 * j + (size_t)c] = net->ncomp == 4 ? value[c] / value[3] : value[c];
        if (!kn_patch_net_unit_normal(normal + 3 * j, net, value, dr, dt, sign))
            kn_patch_net_limit_normal(normal + 3 * j, net, (double)i / g->a, (double)j / g->b, sign, g->work);
    }
}

static void add_triangles(kn_mesh *mesh, size_t first, const grid *g, bool reversed)
{
    size_t b1 = (size_t)g->b + 1;
    for (size_t i = 0; i < (size_t)g->a; i++)
        for (size_t j = 0; j + 1 < b1; j++) {
            size_t p = first + i * b1 + j, q = p + b1, r = q + 1, s = p + 1;
            if (reversed) {
                kn_mesh_add_triangle(mesh, p, r, q);
                kn_mesh_add_triangle(mesh, p, s, r);
            } else {
                kn_mesh_add_triangle(mesh, p, q, r);
                kn_mesh_add_triangle(mesh, p, r, s);
            }
        }
}

kn_status kn_mesh_add_patch(kn_ctx *ctx, kn_mesh *mesh, const kn_bezier *patch, const int segments[2], bool reversed)
{
    kn_status status = kn_mesh_check_patch(ctx, mesh, patch, segments);
    if (status != KN_OK) return status;
    kn_patch_net net;
    size_t a = (size_t)segments[0], b = (size_t)segments[1], first = mesh->nvertices;
    grid g;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_patch_net_init(ctx, &net, patch);
    if (status == KN_OK) status = grid_init(ctx, &g, &net, segments);
    if (status == KN_OK) status = kn_mesh_reserve(ctx, mesh, (a + 1) * (b + 1), 2 * a * b, true);
    if (status == KN_OK) {
        for (int i = 0; i <= g.a; i++) {
            size_t at = 3 * (first + (size_t)i * (b + 1));
            line_of_vertices(mesh->position + at, mesh->normal + at, &net, &g, i, reversed ? -1.0 : 1.0);
        }
        mesh->nvertices += (a + 1) * (b + 1);
        add_triangles(mesh, first, &g, reversed);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
