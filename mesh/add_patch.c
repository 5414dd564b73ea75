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
#include "kernel/context.h"

#include <knurl/mesh.h>

#include <math.h>
#include <string.h>

// A normal counts as vanished when it is this small beside the patch's largest partial derivatives; then the limit is
// extrapolated from three points at INSIDE, INSIDE / 2 and INSIDE / 4 of the parameter range inwards.
#define VANISHED 1e-9
#define INSIDE 0.0078125

// A patch and its differences, the components of a point slowest; w has the fourth, homogeneous one.
typedef struct patch_net {
    int n, m, ncomp;    // degrees; 3, or 4 when rational
    const double *coef; // (ncomp, n + 1, m + 1)
    double *step;       // (ncomp, n, m + 1): coefficients of dr / n
    double vanished;    // |normal| at or below this is no normal
} patch_net;

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

// out[x] = sum_k weight[k] row[k * length + x], k = 0 .. n, in an order that reversing k does not change.
static void combine(double *restrict out, const double *restrict weight, const double *restrict row, int n,
                    size_t length)
{
    memset(out, 0, length * sizeof *out);
    for (int k = 0; 2 * k <= n; k++) {
        const double *restrict p = row + (size_t)k * length, *restrict q = row + (size_t)(n - k) * length;
        double a = weight[k], b = weight[n - k];
        if (2 * k == n)
            for (size_t x = 0; x < length; x++) out[x] += a * p[x];
        else
            for (size_t x = 0; x < length; x++) out[x] += a * p[x] + b * q[x];
    }
}

static void differences(double *out, const double *in, int n)
{
    for (int k = 0; k < n; k++) out[k] = in[k + 1] - in[k];
}

// normal = direction of (dr x dt), flipped by sign; false where it vanishes. value, dr, dt: ncomp numbers, those of a
// rational patch homogeneous: then p' = (P' - p w') / w, and the factor 1 / w > 0 does not matter.
static bool unit_normal(double normal[3], const patch_net *net, const double *value, const double *dr,
                        const double *dt, double sign)
{
    double a[3], b[3];
    for (int c = 0; c < 3; c++) {
        a[c] = dr[c], b[c] = dt[c];
        if (net->ncomp == 4) a[c] -= value[c] / value[3] * dr[3], b[c] -= value[c] / value[3] * dt[3];
    }
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    double length = sqrt(x * x + y * y + z * z);
    if (!(length > net->vanished)) return false;
    normal[0] = sign * (x / length), normal[1] = sign * (y / length), normal[2] = sign * (z / length);
    return true;
}

// The unit normal at (r,t) by direct evaluation, work: 2 (n + 1) + 3 (m + 1) numbers.
static bool normal_at(double normal[3], const patch_net *net, double r, double t, double sign, double *work)
{
    size_t n1 = (size_t)net->n + 1, m1 = (size_t)net->m + 1;
    double *br = work, *cr = br + n1, *bt = cr + n1, *ct = bt + m1, *row = ct + m1;
    double value[4], dr[4], dt[4];
    kn_bernstein_basis(br, net->n, r);
    kn_bernstein_basis(bt, net->m, t);
    if (net->n > 0) kn_bernstein_basis(cr, net->n - 1, r);
    if (net->m > 0) kn_bernstein_basis(ct, net->m - 1, t);
    for (int c = 0; c < net->ncomp; c++) {
        combine(row, br, net->coef + (size_t)c * n1 * m1, net->n, m1);
        combine(&value[c], row, bt, net->m, 1);
        differences(row, row, net->m);
        combine(&dt[c], row, ct, net->m - 1, 1);
        combine(row, cr, net->step + (size_t)c * (n1 - 1) * m1, net->n - 1, m1);
        combine(&dr[c], row, bt, net->m, 1);
    }
    return unit_normal(normal, net, value, dr, dt, sign);
}

// The limit of the unit normal at (r,t) as that point is approached along (dr,dt), by extrapolation of its Taylor
// series in the distance h: (n(h) - 6 n(h/2) + 8 n(h/4)) / 3 = n(0) + O(h^3).
static bool limit_along(double normal[3], const patch_net *net, double r, double t, double dr, double dt, double sign,
                        double *work)
{
    double sum[3] = {0.0, 0.0, 0.0}, one[3];
    const double weight[3] = {1.0 / 3.0, -2.0, 8.0 / 3.0};
    double h = INSIDE, length = 0.0;
    for (int k = 0; k < 3; k++, h /= 2.0) {
        if (!normal_at(one, net, r + h * dr, t + h * dt, sign, work)) return false;
        for (int c = 0; c < 3; c++) sum[c] += weight[k] * one[c];
    }
    for (int c = 0; c < 3; c++) length += sum[c] * sum[c];
    length = sqrt(length);
    if (!(length > 0.5)) return false;
    for (int c = 0; c < 3; c++) normal[c] = sum[c] / length;
    return true;
}

// Across the edge in t first, then in r, then inwards along the diagonal; (0,0,1) where there is no limit.
static void limit_normal(double normal[3], const patch_net *net, double r, double t, double sign, double *work)
{
    double dr = r > 0.5 ? -1.0 : 1.0, dt = t > 0.5 ? -1.0 : 1.0;
    if (limit_along(normal, net, r, t, 0.0, dt, sign, work)) return;
    if (limit_along(normal, net, r, t, dr, 0.0, sign, work)) return;
    if (limit_along(normal, net, r, t, dr, dt, sign, work)) return;
    normal[0] = 0.0, normal[1] = 0.0, normal[2] = 1.0;
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

static kn_status grid_init(kn_ctx *ctx, grid *g, patch_net *net, const int segments[2])
{
    size_t n = (size_t)net->n, m = (size_t)net->m, nc = (size_t)net->ncomp;
    size_t a1 = (size_t)segments[0] + 1, b1 = (size_t)segments[1] + 1;
    size_t size = a1 * (2 * n + 1) + b1 * (2 * m + 1) + 2 * (m + 1) + 3 * nc * b1 + 2 * (n + 1) + 3 * (m + 1);
    double *at = kn_scratch(ctx, size + nc * n * (m + 1), sizeof *at);
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
    net->step = at;
    fill_table(g->at_r, net->n, g->a, false, g->work);
    fill_table(g->at_t, net->m, g->b, true, g->work);
    if (n > 0) fill_table(g->slope_r, net->n - 1, g->a, false, g->work);
    if (m > 0) fill_table(g->slope_t, net->m - 1, g->b, true, g->work);
    return KN_OK;
}

static double largest(double most, double x)
{
    return fabs(x) > most ? fabs(x) : most;
}

// Fills net->step, and net->vanished from bounds of the partial derivatives (up to the degrees, which cancel).
static void net_differences(patch_net *net)
{
    size_t n1 = (size_t)net->n + 1, m1 = (size_t)net->m + 1;
    double size[2] = {0.0, 0.0}, dr[2] = {0.0, 0.0}, dt[2] = {0.0, 0.0}, least = 1.0;
    for (int c = 0; c < net->ncomp; c++) {
        const double *p = net->coef + (size_t)c * n1 * m1;
        double *step = net->step + (size_t)c * (n1 - 1) * m1;
        int w = c == 3;
        for (size_t i = 0; i < n1 * m1; i++) {
            size[w] = largest(size[w], p[i]);
            if (w) least = i == 0 || p[i] < least ? p[i] : least;
            if ((i + 1) % m1 != 0) dt[w] = largest(dt[w], p[i + 1] - p[i]);
        }
        for (size_t i = 0; i < (n1 - 1) * m1; i++) dr[w] = largest(dr[w], step[i] = p[i + m1] - p[i]);
    }
    double per_weight = net->ncomp == 4 ? size[0] / least : 0.0;
    net->vanished = VANISHED * (dr[0] + per_weight * dr[1]) * (dt[0] + per_weight * dt[1]);
}

// Points and normals of grid line i in r.
static void line_of_vertices(double *position, double *normal, const patch_net *net, grid *g, int i, double sign)
{
    size_t n1 = (size_t)net->n + 1, m1 = (size_t)net->m + 1, b1 = (size_t)g->b + 1;
    for (int c = 0; c < net->ncomp; c++) {
        combine(g->row, g->at_r + (size_t)i * n1, net->coef + (size_t)c * n1 * m1, net->n, m1);
        combine(g->value + (size_t)c * b1, g->row, g->at_t, net->m, b1);
        differences(g->step, g->row, net->m);
        combine(g->dt + (size_t)c * b1, g->step, g->slope_t, net->m - 1, b1);
        combine(g->row, g->slope_r + (size_t)i * (n1 - 1), net->step + (size_t)c * (n1 - 1) * m1, net->n - 1, m1);
        combine(g->dr + (size_t)c * b1, g->row, g->at_t, net->m, b1);
    }
    for (size_t j = 0; j < b1; j++) {
        double value[4], dr[4], dt[4];
        for (int c = 0; c < net->ncomp; c++) {
            size_t at = (size_t)c * b1 + j;
            value[c] = g->value[at], dr[c] = g->dr[at], dt[c] = g->dt[at];
        }
        for (int c = 0; c < 3; c++) position[3 * j + (size_t)c] = net->ncomp == 4 ? value[c] / value[3] : value[c];
        if (!unit_normal(normal + 3 * j, net, value, dr, dt, sign))
            limit_normal(normal + 3 * j, net, (double)i / g->a, (double)j / g->b, sign, g->work);
    }
}

static bool same_point(const double *position, size_t p, size_t q)
{
    const double *a = position + 3 * p, *b = position + 3 * q;
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static void add_triangle(kn_mesh *mesh, size_t p, size_t q, size_t r)
{
    if (same_point(mesh->position, p, q) || same_point(mesh->position, q, r) || same_point(mesh->position, r, p))
        return;
    uint32_t *corner = mesh->triangle + 3 * mesh->ntriangles++;
    corner[0] = (uint32_t)p, corner[1] = (uint32_t)q, corner[2] = (uint32_t)r;
}

static void add_triangles(kn_mesh *mesh, size_t first, const grid *g, bool reversed)
{
    size_t b1 = (size_t)g->b + 1;
    for (size_t i = 0; i < (size_t)g->a; i++)
        for (size_t j = 0; j + 1 < b1; j++) {
            size_t p = first + i * b1 + j, q = p + b1, r = q + 1, s = p + 1;
            if (reversed) {
                add_triangle(mesh, p, r, q);
                add_triangle(mesh, p, s, r);
            } else {
                add_triangle(mesh, p, q, r);
                add_triangle(mesh, p, r, s);
            }
        }
}

// Room for this many more; a failure leaves the mesh as it was, though its arrays may be larger than they say.
static kn_status reserve(kn_ctx *ctx, kn_mesh *mesh, size_t vertices, size_t triangles)
{
    size_t need = mesh->nvertices + vertices, room = mesh->vertex_room + mesh->vertex_room / 2;
    if (need > mesh->vertex_room) {
        room = room > need ? room : need;
        double *position = kn_resize(ctx, mesh->position, room, 3 * sizeof *position);
        if (!position) return KN_ENOMEM;
        mesh->position = position;
        double *normal = kn_resize(ctx, mesh->normal, room, 3 * sizeof *normal);
        if (!normal) return KN_ENOMEM;
        mesh->normal = normal;
        mesh->vertex_room = room;
    }
    need = mesh->ntriangles + triangles, room = mesh->triangle_room + mesh->triangle_room / 2;
    if (need > mesh->triangle_room) {
        room = room > need ? room : need;
        uint32_t *triangle = kn_resize(ctx, mesh->triangle, room, 3 * sizeof *triangle);
        if (!triangle) return KN_ENOMEM;
        mesh->triangle = triangle;
        mesh->triangle_room = room;
    }
    return KN_OK;
}

static kn_status check(kn_ctx *ctx, const kn_mesh *mesh, const kn_bezier *patch, const int segments[2])
{
    int dim = patch->ncomp - (patch->rational ? 1 : 0);
    if (!patch->coef) return kn_fail(ctx, KN_EDOMAIN, "mesh: a patch without coefficients");
    if (patch->nvars != 2 || dim != 3)
        return kn_fail(ctx, KN_EDOMAIN, "mesh: a patch of %d variables in dimension %d; 2 and 3 are wanted",
                       patch->nvars, dim);
    for (int d = 0; d < 2; d++)
        if (patch->degree[d] < 0 || patch->degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "mesh: degree %d", patch->degree[d]);
    if (segments[0] < 1 || segments[1] < 1)
        return kn_fail(ctx, KN_EDOMAIN, "mesh: %d x %d segments", segments[0], segments[1]);
    size_t lines = (size_t)segments[0] + 1, vertices = (size_t)segments[1] + 1;
    if (vertices > (UINT32_MAX - mesh->nvertices) / lines)
        return kn_fail(ctx, KN_ELIMIT, "mesh: more than %lu vertices", (unsigned long)UINT32_MAX);
    return KN_OK;
}

kn_status kn_mesh_add_patch(kn_ctx *ctx, kn_mesh *mesh, const kn_bezier *patch, const int segments[2], bool reversed)
{
    kn_status status = check(ctx, mesh, patch, segments);
    if (status != KN_OK) return status;
    patch_net net = {.n = patch->degree[0], .m = patch->degree[1], .ncomp = patch->ncomp, .coef = patch->coef};
    size_t a = (size_t)segments[0], b = (size_t)segments[1], first = mesh->nvertices;
    grid g;
    kn_mark mark = kn_scratch_mark(ctx);
    status = grid_init(ctx, &g, &net, segments);
    if (status == KN_OK) status = reserve(ctx, mesh, (a + 1) * (b + 1), 2 * a * b);
    if (status == KN_OK) {
        net_differences(&net);
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
