// SPDX-License-Identifier: Apache-2.0
// A disk laid flat: its border on the unit circle by lengths, every other vertex the weighted mean of its neighbours,
//     sum_j w_ij (x_j - x_i) = 0.
// With positive weights and a border that is strictly convex this is an embedding (Tutte, Floater); the weights are
// those of the Laplacian, (cot a + cot b) / 2 with the angles opposite to the edge, kept positive. The matrix is
// symmetric and positive definite: conjugate gradients, scaled by the diagonal.
#include "kernel/context.h"
#include "mesh/edges.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979324;

// Rows of the matrix: of vertex v entries first[v] .. first[v + 1] - 1.
typedef struct laplacian {
    size_t n, *first;
    uint32_t *at;
    double *weight, *diagonal;
    bool *border;
} laplacian;

static double cotangent(const kn_mesh *m, uint32_t apex, uint32_t a, uint32_t b)
{
    const double *p = m->position + 3 * (size_t)apex, *q = m->position + 3 * (size_t)a,
                 *r = m->position + 3 * (size_t)b;
    double x[3], y[3], c[3];
    for (int k = 0; k < 3; k++) x[k] = q[k] - p[k], y[k] = r[k] - p[k];
    for (int k = 0; k < 3; k++) c[k] = x[(k + 1) % 3] * y[(k + 2) % 3] - x[(k + 2) % 3] * y[(k + 1) % 3];
    double along = x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    double cross = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    return fabs(along) < 1e6 * cross ? along / cross : along > 0.0 ? 1e6 : -1e6;
}

static double weight_of(const kn_mesh *m, const kn_mesh_side *sides, size_t group)
{
    enum { STEEPEST = 20 };
    const double least = 0.05; // positive, and not so small that rounding turns triangles over
    double sum = 0.0;
    for (size_t k = 0; k < group; k++) {
        const uint32_t *t = m->triangle + 3 * (size_t)sides[k].triangle;
        sum += 0.5 * cotangent(m, t[(sides[k].corner + 2) % 3], sides[k].from, sides[k].to);
    }
    return fmin(fmax(sum, least), STEEPEST);
}

static void fill(laplacian *s, const kn_mesh *m, const kn_mesh_side *sides)
{
    size_t n = 3 * m->ntriangles;
    for (size_t at = 0, group; at < n; at += group) {
        group = kn_mesh_side_group(sides, n, at);
        s->first[sides[at].from + 1]++, s->first[sides[at].to + 1]++;
    }
    for (size_t v = 0; v < s->n; v++) s->first[v + 1] += s->first[v];
    for (size_t at = 0, group; at < n; at += group) {
        group = kn_mesh_side_group(sides, n, at);
        double w = weight_of(m, sides + at, group);
        for (int end = 0; end < 2; end++) {
            uint32_t v = end == 0 ? sides[at].from : sides[at].to, other = end == 0 ? sides[at].to : sides[at].from;
            size_t to = s->first[v] + (size_t)s->diagonal[v];
            s->at[to] = other;
            s->weight[to] = w;
            s->diagonal[v] += 1.0; // counts, for now
        }
        s->border[sides[at].from] |= group == 1;
        s->border[sides[at].to] |= group == 1;
    }
    for (size_t v = 0; v < s->n; v++) {
        s->diagonal[v] = 0.0;
        for (size_t k = s->first[v]; k < s->first[v + 1]; k++) s->diagonal[v] += s->weight[k];
    }
}

// y = L x; rows of the border are left out.
static void apply(double *y, const laplacian *s, const double *x)
{
    for (size_t v = 0; v < s->n; v++) {
        double sum = 0.0;
        if (!s->border[v] && s->diagonal[v] > 0.0) {
            sum = s->diagonal[v] * x[v];
            for (size_t k = s->first[v]; k < s->first[v + 1]; k++) sum -= s->weight[k] * x[s->at[k]];
        }
        y[v] = sum;
    }
}

static double dot(const double *a, const double *b, size_t n)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

// Conjugate gradients from x, whose values on the border stay. room: 4 n numbers.
static kn_status solve(kn_ctx *ctx, double *x, const laplacian *s, double *room)
{
    size_t n = s->n, most = 200 + 20 * (size_t)sqrt((double)n);
    double *r = room, *z = room + n, *p = room + 2 * n, *q = room + 3 * n;
    apply(r, s, x);
    for (size_t v = 0; v < n; v++) {
        bool inner = !s->border[v] && s->diagonal[v] > 0.0;
        r[v] = inner ? -r[v] : 0.0;
        p[v] = z[v] = inner ? r[v] / s->diagonal[v] : 0.0;
    }
    double rz = dot(r, z, n), start = rz;
    for (size_t k = 0; rz > 1e-28 * start && k < most; k++) {
        apply(q, s, p);
        double pq = dot(p, q, n);
        if (!(pq > 0.0)) break;
        double step = rz / pq;
        for (size_t v = 0; v < n; v++) {
            x[v] += step * p[v];
            r[v] -= step * q[v];
            z[v] = s->border[v] || s->diagonal[v] == 0.0 ? 0.0 : r[v] / s->diagonal[v];
        }
        double next = dot(r, z, n), ratio = next / rz;
        for (size_t v = 0; v < n; v++) p[v] = z[v] + ratio * p[v];
        rz = next;
        kn_status status = k % 64 == 0 ? kn_progress(ctx, "flatten", 0.0) : KN_OK;
        if (status != KN_OK) return status;
    }
    if (rz > 1e-18 * start) return kn_fail(ctx, KN_EUNDECIDED, "mesh: flattening does not converge");
    return KN_OK;
}

// The border, from `start` on, by its length around the circle.
static void place_border(double *x, double *y, const kn_mesh *m, const uint32_t *next, uint32_t start)
{
    double length = 0.0, at = 0.0;
    for (int round = 0; round < 2; round++) {
        uint32_t v = start;
        do {
            const double *p = m->position + 3 * (size_t)v, *q = m->position + 3 * (size_t)next[v];
            double way = sqrt((q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]) +
                              (q[2] - p[2]) * (q[2] - p[2]));
            if (round == 1) {
                x[v] = cos(2.0 * pi * at / length);
                y[v] = sin(2.0 * pi * at / length);
                at += way;
            } else
                length += way;
            v = next[v];
        } while (v != start);
    }
}

static kn_status check_disk(kn_ctx *ctx, const kn_mesh *mesh)
{
    kn_mesh_topology t;
    kn_status status = kn_mesh_survey(ctx, &t, mesh);
    if (status != KN_OK || (t.components == 1 && t.irregular == 0 && t.loops == 1 && t.euler == 1)) return status;
    return kn_fail(ctx, KN_EDOMAIN,
                   "mesh: no disk: %d components, %d border loops, Euler characteristic %ld, %zu irregular edges",
                   t.components, t.loops, t.euler, t.irregular);
}

// Every triangle with vertices keeps its side, or the disk is folded.
static kn_status check_sides(kn_ctx *ctx, const double *x, const double *y, const kn_mesh *mesh)
{
    for (size_t i = 0; i < mesh->ntriangles; i++) {
        const uint32_t *t = mesh->triangle + 3 * i;
        double area = (x[t[1]] - x[t[0]]) * (y[t[2]] - y[t[0]]) - (x[t[2]] - x[t[0]]) * (y[t[1]] - y[t[0]]);
        if (!(area > 0.0)) return kn_fail(ctx, KN_EUNDECIDED, "mesh: triangle %zu vanishes in the flat disk", i);
    }
    return KN_OK;
}

kn_status kn_mesh_flatten(kn_ctx *ctx, double *xy, const kn_mesh *mesh, uint32_t start)
{
    kn_status status = check_disk(ctx, mesh);
    if (status != KN_OK) return status;
    size_t n = mesh->nvertices, nsides = 3 * mesh->ntriangles;
    kn_mesh_side *sides = kn_mesh_sides(ctx, mesh);
    laplacian s = {.n = n,
                   .first = kn_alloc_zero(ctx, n + 1, sizeof *s.first),
                   .at = kn_alloc(ctx, 2 * nsides, sizeof *s.at),
                   .weight = kn_alloc(ctx, 2 * nsides, sizeof *s.weight),
                   .diagonal = kn_alloc_zero(ctx, n, sizeof *s.diagonal),
                   .border = kn_alloc_zero(ctx, n, sizeof *s.border)};
    uint32_t *next = kn_alloc_zero(ctx, n, sizeof *next);
    double *x = kn_alloc_zero(ctx, 6 * n, sizeof *x), *y = x ? x + n : NULL;
    if (!sides || !s.first || !s.at || !s.weight || !s.diagonal || !s.border || !next || !x) status = KN_ENOMEM;
    if (status == KN_OK) {
        fill(&s, mesh, sides);
        for (size_t i = 0; i < nsides; i += kn_mesh_side_group(sides, nsides, i))
            if (kn_mesh_side_group(sides, nsides, i) == 1) next[sides[i].from] = sides[i].to;
        if (start >= n || !s.border[start])
            status = kn_fail(ctx, KN_EDOMAIN, "mesh: vertex %u is not on the border", (unsigned)start);
    }
    if (status == KN_OK) place_border(x, y, mesh, next, start);
    if (status == KN_OK) status = solve(ctx, x, &s, x + 2 * n);
    if (status == KN_OK) status = solve(ctx, y, &s, x + 2 * n);
    if (status == KN_OK) status = check_sides(ctx, x, y, mesh);
    for (size_t v = 0; status == KN_OK && v < n; v++) xy[2 * v] = x[v], xy[2 * v + 1] = y[v];
    kn_free(ctx, sides);
    kn_free(ctx, s.first);
    kn_free(ctx, s.at);
    kn_free(ctx, s.weight);
    kn_free(ctx, s.diagonal);
    kn_free(ctx, s.border);
    kn_free(ctx, next);
    kn_free(ctx, x);
    return status;
}
