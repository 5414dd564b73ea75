// SPDX-License-Identifier: Apache-2.0
// Points and normals of a patch, and the arrays of a mesh.
#include "mesh/net.h"

#include "kernel/bernstein.h"

#include <math.h>
#include <string.h>

// A normal counts as vanished when it is this small beside the patch's largest partial derivatives; then the limit is
// extrapolated from three points at INSIDE, INSIDE / 2 and INSIDE / 4 of the parameter range inwards.
#define VANISHED 1e-9
#define INSIDE 0.0078125

// out[x] = sum_k weight[k] row[k * length + x], k = 0 .. n, in an order that reversing k does not change.
void kn_patch_net_combine(double *restrict out, const double *restrict weight, const double *restrict row, int n,
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

void kn_patch_net_differences(double *out, const double *in, int n)
{
    for (int k = 0; k < n; k++) out[k] = in[k + 1] - in[k];
}

// normal = direction of (dr x dt), flipped by sign; false where it vanishes. value, dr, dt: ncomp numbers, those of a
// rational patch homogeneous: then p' = (P' - p w') / w, and the factor 1 / w > 0 does not matter.
bool kn_patch_net_unit_normal(double normal[3], const kn_patch_net *net, const double *value, const double *dr,
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
static bool normal_at(double normal[3], const kn_patch_net *net, double r, double t, double sign, double *work)
{
    size_t n1 = (size_t)net->n + 1, m1 = (size_t)net->m + 1;
    double *br = work, *cr = br + n1, *bt = cr + n1, *ct = bt + m1, *row = ct + m1;
    double value[4], dr[4], dt[4];
    kn_bernstein_basis(br, net->n, r);
    kn_bernstein_basis(bt, net->m, t);
    if (net->n > 0) kn_bernstein_basis(cr, net->n - 1, r);
    if (net->m > 0) kn_bernstein_basis(ct, net->m - 1, t);
    for (int c = 0; c < net->ncomp; c++) {
        kn_patch_net_combine(row, br, net->coef + (size_t)c * n1 * m1, net->n, m1);
        kn_patch_net_combine(&value[c], row, bt, net->m, 1);
        kn_patch_net_differences(row, row, net->m);
        kn_patch_net_combine(&dt[c], row, ct, net->m - 1, 1);
        kn_patch_net_combine(row, cr, net->step + (size_t)c * (n1 - 1) * m1, net->n - 1, m1);
        kn_patch_net_combine(&dr[c], row, bt, net->m, 1);
    }
    return kn_patch_net_unit_normal(normal, net, value, dr, dt, sign);
}

// The limit of the unit normal at (r,t) as that point is approached along (dr,dt), by extrapolation of its Taylor
// series in the distance h: (n(h) - 6 n(h/2) + 8 n(h/4)) / 3 = n(0) + O(h^3).
static bool limit_along(double normal[3], const kn_patch_net *net, double r, double t, double dr, double dt,
                        double sign, double *work)
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
void kn_patch_net_limit_normal(double normal[3], const kn_patch_net *net, double r, double t, double sign,
                               double *work)
{
    double dr = r > 0.5 ? -1.0 : 1.0, dt = t > 0.5 ? -1.0 : 1.0;
    if (limit_along(normal, net, r, t, 0.0, dt, sign, work)) return;
    if (limit_along(normal, net, r, t, dr, 0.0, sign, work)) return;
    if (limit_along(normal, net, r, t, dr, dt, sign, work)) return;
    normal[0] = 0.0, normal[1] = 0.0, normal[2] = 1.0;
}

static double largest(double most, double x)
{
    return fabs(x) > most ? fabs(x) : most;
}

// Fills net->step, and net->vanished from bounds of the partial derivatives (up to the degrees, which cancel).
static void net_differences(kn_patch_net *net)
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

kn_status kn_patch_net_init(kn_ctx *ctx, kn_patch_net *net, const kn_bezier *patch)
{
    *net = (kn_patch_net){patch->degree[0], patch->degree[1], patch->ncomp, patch->coef, NULL, 0.0};
    size_t n = (size_t)net->n, m1 = (size_t)net->m + 1;
    net->step = kn_scratch(ctx, (size_t)net->ncomp * n * m1 + 1, sizeof *net->step);
    if (!net->step) return KN_ENOMEM;
    net_differences(net);
    return KN_OK;
}

size_t kn_patch_net_room(const kn_patch_net *net)
{
    return 2 * ((size_t)net->n + 1) + 3 * ((size_t)net->m + 1);
}

// B_p(x), from the nearer end: then reversing the patch reverses the table bit for bit.
static void symmetric_basis(double *basis, int n, const kn_mesh_place *x)
{
    bool upper = x->below < x->at;
    kn_bernstein_basis(basis, n, upper ? x->below : x->at);
    for (int k = 0; 2 * k < n; k++) {
        double low = basis[k];
        if (upper) basis[k] = basis[n - k];
        if (upper || x->at == x->below) basis[n - k] = low;
    }
}

void kn_patch_net_point(double position[3], double normal[3], const kn_patch_net *net, const kn_mesh_place *r,
                        const kn_mesh_place *t, double sign, double *work)
{
    size_t n1 = (size_t)net->n + 1, m1 = (size_t)net->m + 1;
    double *br = work, *bt = br + n1, *row = bt + m1, value[4];
    symmetric_basis(br, net->n, r);
    symmetric_basis(bt, net->m, t);
    for (int c = 0; c < net->ncomp; c++) {
        kn_patch_net_combine(row, br, net->coef + (size_t)c * n1 * m1, net->n, m1);
        kn_patch_net_combine(&value[c], row, bt, net->m, 1);
    }
    for (int c = 0; c < 3; c++) position[c] = net->ncomp == 4 ? value[c] / value[3] : value[c];
    if (!normal_at(normal, net, r->at, t->at, sign, work))
        kn_patch_net_limit_normal(normal, net, r->at, t->at, sign, work);
}

static bool same_point(const double *position, size_t p, size_t q)
{
    const double *a = position + 3 * p, *b = position + 3 * q;
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

void kn_mesh_add_triangle(kn_mesh *mesh, size_t p, size_t q, size_t r)
{
    if (same_point(mesh->position, p, q) || same_point(mesh->position, q, r) || same_point(mesh->position, r, p))
        return;
    uint32_t *corner = mesh->triangle + 3 * mesh->ntriangles++;
    corner[0] = (uint32_t)p, corner[1] = (uint32_t)q, corner[2] = (uint32_t)r;
}

kn_status kn_mesh_reserve(kn_ctx *ctx, kn_mesh *mesh, size_t vertices, size_t triangles, bool normals)
{
    size_t need = mesh->nvertices + vertices, room = mesh->vertex_room + mesh->vertex_room / 2;
    if (need > mesh->vertex_room || (normals && need > 0 && !mesh->normal)) {
        room = room > need ? room : need;
        double *position = kn_resize(ctx, mesh->position, room, 3 * sizeof *position);
        if (!position) return KN_ENOMEM;
        mesh->position = position;
        double *normal = normals ? kn_resize(ctx, mesh->normal, room, 3 * sizeof *normal) : NULL;
        if (normals && !normal) return KN_ENOMEM;
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

kn_status kn_mesh_check(kn_ctx *ctx, const kn_mesh *mesh)
{
    for (size_t i = 0; i < 3 * mesh->ntriangles; i++)
        if (mesh->triangle[i] >= mesh->nvertices)
            return kn_fail(ctx, KN_EDOMAIN, "mesh: triangle %zu refers to vertex %lu of %zu", i / 3,
                           (unsigned long)mesh->triangle[i], mesh->nvertices);
    return KN_OK;
}

kn_status kn_mesh_check_patch(kn_ctx *ctx, const kn_mesh *mesh, const kn_bezier *patch, const int segments[2])
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
