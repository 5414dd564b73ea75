// SPDX-License-Identifier: Apache-2.0
// Vertices on the unit sphere: where they may be, and where they are best.
//
// Of a triangle of area A in space and det(p, q, r) = 2 S on the sphere the map between them stretches by
//     D (1 + (A / S)^2),  D = half the sum over edges of |edge on the sphere|^2 (cotangent of the angle opposite),
// the angle in space: the Dirichlet energies of the linear map and of its inverse where the triangle is small, as S is
// its area then; and without end where S vanishes, be it small or as large as half the sphere.
#include "mesh/sphere.h"

#include <float.h>
#include <string.h>

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double *a, const double *b)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void subtract(double out[3], const double *a, const double *b)
{
    for (int c = 0; c < 3; c++) out[c] = a[c] - b[c];
}

static bool normalize(double x[3])
{
    double length = sqrt(dot(x, x));
    if (!(length > 1e-150 && length < 1e150)) return false;
    for (int c = 0; c < 3; c++) x[c] /= length;
    return true;
}

// Two differences (a rounding each), two products and a difference of them, a product, two sums: at most 8 roundings
// of the sum of absolute values, and as many for that; what falls below the range of doubles is at most 2^-1074 each
// time, times factors below 4.
double kn_mesh_turn_value(const double *p, const double *q, const double *r, double *bound)
{
    double a[3], b[3], sum = 0.0, most = 0.0;
    subtract(a, q, p);
    subtract(b, r, p);
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, e = (c + 2) % 3;
        double x = a[d] * b[e], y = a[e] * b[d];
        sum += p[c] * (x - y);
        most += fabs(p[c]) * (fabs(x) + fabs(y));
    }
    *bound = 10.0 * DBL_EPSILON * most + 1e-300;
    return sum;
}

// ---- how much a vertex's triangles are stretched ----

typedef struct stretch {
    double energy, slope[3];
} stretch;

// Adds the triangle of v at x and two neighbours. false: it may have turned over.
static bool add_triangle(stretch *s, const kn_mesh_globe *g, const double *x, uint32_t v, uint32_t b, uint32_t c)
{
    const double *y = g->xyz + 3 * (size_t)b, *z = g->xyz + 3 * (size_t)c;
    const double *p = g->position + 3 * (size_t)v, *q = g->position + 3 * (size_t)b, *r = g->position + 3 * (size_t)c;
    double u[3], w[3], t[3], n[3], bound, turn = kn_mesh_turn_value(x, y, z, &bound);
    if (!(turn > bound)) return false;
    subtract(u, q, p), subtract(w, r, p), subtract(t, r, q);
    cross(n, u, w);
    double uu = dot(u, u), ww = dot(w, w), tt = dot(t, t);
    double area = 0.5 * sqrt(dot(n, n)), least = 0.02 * fmax(uu, fmax(ww, tt)); // needles: not for ever
    area = fmax(area, least);
    if (!(area > 0.0)) return true;
    double ku = (ww + tt - uu) / (8.0 * area), kw = (uu + tt - ww) / (8.0 * area), kt = (uu + ww - tt) / (8.0 * area);
    subtract(u, y, x), subtract(w, z, x), subtract(t, z, y);
    double d = ku * dot(u, u) + kw * dot(w, w) + kt * dot(t, t);
    double ratio = 2.0 * area * g->scale / turn, factor = 1.0 + ratio * ratio;
    s->energy += d * factor;
    cross(n, y, z); // the slope of turn
    double by_turn = -2.0 * d * ratio * ratio / turn;
    for (int k = 0; k < 3; k++) s->slope[k] += -2.0 * factor * (ku * u[k] + kw * w[k]) + by_turn * n[k];
    return true;
}

static bool add_ring(stretch *s, const kn_mesh_globe *g, const double *x, uint32_t v)
{
    const kn_mesh_rings *r = g->rings;
    *s = (stretch){0};
    uint32_t node = r->head[v];
    for (uint32_t i = 0; i < r->degree[v]; i++, node = r->next[node])
        if (!add_triangle(s, g, x, v, r->to[node], r->to[r->next[node]])) return false;
    return isfinite(s->energy);
}

double kn_mesh_globe_relax(kn_mesh_globe *g, uint32_t v)
{
    enum { TRIES = 30 };
    const kn_mesh_rings *r = g->rings;
    double *x = g->xyz + 3 * (size_t)v, mean = 0.0, edge[3];
    stretch here, there;
    if (!add_ring(&here, g, x, v)) return 0.0;
    uint32_t node = r->head[v];
    for (uint32_t i = 0; i < r->degree[v]; i++, node = r->next[node]) {
        subtract(edge, g->xyz + 3 * (size_t)r->to[node], x);
        mean += sqrt(dot(edge, edge)) / r->degree[v];
    }
    double outwards = dot(here.slope, x);
    for (int c = 0; c < 3; c++) here.slope[c] -= outwards * x[c];
    double steep = sqrt(dot(here.slope, here.slope)), step = 0.5 * mean / steep;
    if (!(steep > 0.0) || !isfinite(step)) return 0.0;
    for (int k = 0; k < TRIES; k++, step *= 0.5) {
        double y[3];
        for (int c = 0; c < 3; c++) y[c] = x[c] - step * here.slope[c];
        if (!normalize(y) || !add_ring(&there, g, y, v) || !(there.energy < here.energy)) continue;
        memcpy(x, y, sizeof y);
        return step * steep / mean;
    }
    return 0.0;
}

void kn_mesh_globe_measure(kn_mesh_globe *g, const uint32_t *alive, size_t n)
{
    const kn_mesh_rings *r = g->rings;
    double sum = 0.0, u[3], w[3], c[3];
    for (size_t k = 0; k < n; k++) {
        const double *p = g->position + 3 * (size_t)alive[k];
        uint32_t node = r->head[alive[k]];
        for (uint32_t i = 0; i < r->degree[alive[k]]; i++, node = r->next[node]) {
            subtract(u, g->position + 3 * (size_t)r->to[node], p);
            subtract(w, g->position + 3 * (size_t)r->to[r->next[node]], p);
            cross(c, u, w);
            sum += sqrt(dot(c, c)) / 6.0; // each triangle three times
        }
    }
    g->scale = sum > 0.0 ? 12.566370614359172 / sum : 1.0;
}

// ---- where a vertex may be ----

static bool fits(const kn_mesh_globe *g, const double *x, const uint32_t *ring, int k)
{
    for (int i = 0; i < k; i++)
        if (kn_mesh_turn(x, g->xyz + 3 * (size_t)ring[i], g->xyz + 3 * (size_t)ring[(i + 1) % k]) <= 0) return false;
    return true;
}

// At the corner s the places on the inner side of both edges form a wedge; `out` points along its middle, as long as
// the shorter edge.
static bool wedge(double out[3], const double *s, const double *next, const double *last)
{
    double a[3], b[3], left[3], right[3];
    subtract(a, next, s), subtract(b, s, last);
    double length = fmin(sqrt(dot(a, a)), sqrt(dot(b, b)));
    cross(left, s, a), cross(right, s, b);
    if (!normalize(left) || !normalize(right)) return false;
    for (int c = 0; c < 3; c++) out[c] = left[c] + right[c];
    if (!normalize(out)) return false;
    for (int c = 0; c < 3; c++) out[c] *= length;
    return true;
}

bool kn_mesh_globe_place(kn_mesh_globe *g, uint32_t v, const uint32_t *ring, int k)
{
    enum { TRIES = 60 };
    const double *s = g->xyz + 3 * (size_t)ring[0];
    double x[3] = {0}, way[3];
    for (int i = 0; i < k; i++)
        for (int c = 0; c < 3; c++) x[c] += g->xyz[3 * (size_t)ring[i] + (size_t)c];
    bool found = normalize(x) && fits(g, x, ring, k);
    if (!found && !wedge(way, s, g->xyz + 3 * (size_t)ring[1], g->xyz + 3 * (size_t)ring[k - 1])) return false;
    double step = 1.0;
    for (int i = 0; !found && i < TRIES; i++, step *= 0.5) {
        for (int c = 0; c < 3; c++) x[c] = s[c] + step * way[c];
        found = normalize(x) && fits(g, x, ring, k);
    }
    if (found) memcpy(g->xyz + 3 * (size_t)v, x, sizeof x);
    return found;
}
