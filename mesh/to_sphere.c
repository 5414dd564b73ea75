// SPDX-License-Identifier: Apache-2.0
// kn_mesh_to_sphere: vertices are taken away until a tetrahedron is left, which lies on the sphere without a fold,
// and put back where none comes to be (Praun & Hoppe).
//
// Of every closed surface of genus 0 some vertex with at most five neighbours can go: outside of its ring chords do
// not cross, so that of five corners two have none, and from one of these the triangles of the others are new edges.
// Seen from ring[0] the triangles of a hole do not overlap: hence near ring[0], between its two edges, there is a
// place from which they do not either.
#include "kernel/context.h"
#include "mesh/sphere.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

// A vertex that was taken away, and its ring.
typedef struct removal {
    uint32_t vertex, first; // ring[first ..] of all
    int k;
} removal;

typedef struct candidate {
    double cost;
    uint32_t vertex;
} candidate;

// alive[0 .. nalive - 1] are the vertices that are left; those of later rounds come behind, in their order.
typedef struct work {
    kn_mesh_rings rings;
    kn_mesh_globe globe;
    uint32_t *alive, *ring;
    size_t nalive, nring;
    removal *removals;
    candidate *candidates;
    size_t *round; // where the removals of each begin
    size_t nremovals, nrounds, round_room;
    bool *locked;
} work;

static int by_cost(const void *a, const void *b)
{
    const candidate *x = a, *y = b;
    return x->cost != y->cost ? (x->cost > y->cost) - (x->cost < y->cost)
                              : (x->vertex > y->vertex) - (x->vertex < y->vertex);
}

static double distance2(const double *p, const double *q)
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++) sum += (p[c] - q[c]) * (p[c] - q[c]);
    return sum;
}

// How far a vertex stands out of its neighbours.
static double cost_of(const work *w, uint32_t v)
{
    const kn_mesh_rings *r = &w->rings;
    double mean[3] = {0};
    uint32_t node = r->head[v];
    for (uint32_t i = 0; i < r->degree[v]; i++, node = r->next[node])
        for (size_t c = 0; c < 3; c++) mean[c] += w->globe.position[3 * (size_t)r->to[node] + c] / r->degree[v];
    return distance2(mean, w->globe.position + 3 * (size_t)v);
}

// The ring from the corner whose diagonals are new, and shortest. 0: from none, or it is too large.
static int choose_ring(uint32_t out[KN_MESH_MOST_RING], const work *w, uint32_t v, uint32_t most)
{
    uint32_t ring[KN_MESH_MOST_RING];
    if (w->rings.degree[v] > most) return 0;
    int k = kn_mesh_ring(ring, &w->rings, v), best = -1;
    double shortest = INFINITY;
    for (int s = 0; s < k; s++) {
        double sum = 0.0;
        bool fresh = true;
        for (int i = 2; fresh && i <= k - 2; i++) {
            uint32_t other = ring[(s + i) % k];
            fresh = !kn_mesh_are_neighbours(&w->rings, ring[s], other);
            sum += distance2(w->globe.position + 3 * (size_t)ring[s], w->globe.position + 3 * (size_t)other);
        }
        if (fresh && (best < 0 || sum < shortest)) shortest = sum, best = s;
    }
    for (int i = 0; best >= 0 && i < k; i++) out[i] = ring[(best + i) % k];
    return best >= 0 ? k : 0;
}

static bool take_one(work *w, uint32_t v, uint32_t most)
{
    uint32_t *ring = w->ring + w->nring;
    if (w->locked[v]) return false;
    int k = choose_ring(ring, w, v, most);
    if (k == 0) return false;
    kn_mesh_take_out(&w->rings, v, ring, k);
    w->removals[w->nremovals++] = (removal){v, (uint32_t)w->nring, k};
    w->nring += (size_t)k;
    for (int i = 0; i < k; i++) w->locked[ring[i]] = true;
    return true;
}

// Takes away vertices that are no neighbours, of those that stand out least.
static kn_status take_round(kn_ctx *ctx, work *w)
{
    enum { FEW = 7 };
    size_t before = w->nremovals, left = w->nalive;
    for (size_t i = 0; i < w->nalive; i++) {
        w->candidates[i] = (candidate){cost_of(w, w->alive[i]), w->alive[i]};
        w->locked[w->alive[i]] = false;
    }
    qsort(w->candidates, w->nalive, sizeof *w->candidates, by_cost);
    for (size_t i = 0; left > 4 && i < (w->nalive + 1) / 2; i++) left -= take_one(w, w->candidates[i].vertex, FEW);
    for (size_t i = 0; left == w->nalive && i < w->nalive; i++)
        left -= take_one(w, w->candidates[i].vertex, KN_MESH_MOST_RING);
    if (left == w->nalive) return kn_fail(ctx, KN_EUNDECIDED, "mesh: no vertex of %zu can be taken away", left);
    size_t n = 0;
    for (size_t i = 0; i < w->nalive; i++)
        if (w->rings.degree[w->alive[i]] > 0) w->alive[n++] = w->alive[i];
    w->nalive = n;
    if (w->nrounds == w->round_room) {
        size_t room = 2 * w->round_room + 16;
        size_t *more = kn_resize(ctx, w->round, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        w->round = more;
        w->round_room = room;
    }
    w->round[w->nrounds++] = before;
    return kn_progress(ctx, "to sphere", 0.0);
}

static void place_tetrahedron(work *w)
{
    static const double up = 1.0 / 3.0, out = 0.94280904158206337, side = 0.81649658092772603;
    const double place[4][3] = {{0.0, 0.0, 1.0}, {out, 0.0, -up}, {-0.5 * out, side, -up}, {-0.5 * out, -side, -up}};
    uint32_t ring[KN_MESH_MOST_RING];
    uint32_t top = w->alive[0];
    (void)kn_mesh_ring(ring, &w->rings, top);
    memcpy(w->globe.xyz + 3 * (size_t)top, place[0], sizeof place[0]);
    for (int i = 0; i < 3; i++) memcpy(w->globe.xyz + 3 * (size_t)ring[i], place[i + 1], sizeof place[0]);
}

// Moves them all, so many times or until none moves far.
static void sweep(work *w, size_t times)
{
    const double far = 0.02;
    double most = INFINITY;
    kn_mesh_globe_measure(&w->globe, w->alive, w->nalive);
    for (size_t k = 0; k < times && most > far; k++) {
        most = 0.0;
        for (size_t i = 0; i < w->nalive; i++) most = fmax(most, kn_mesh_globe_relax(&w->globe, w->alive[i]));
    }
}

// Puts back what a round took away, the last first, and moves it and its neighbours.
static kn_status put_round(kn_ctx *ctx, work *w, size_t first)
{
    enum { TIMES = 4 };
    size_t end = w->nremovals;
    for (size_t i = end; i-- > first;) {
        const removal *r = &w->removals[i];
        const uint32_t *ring = w->ring + r->first;
        if (!kn_mesh_globe_place(&w->globe, r->vertex, ring, r->k))
            return kn_fail(ctx, KN_EUNDECIDED, "mesh: vertex %u finds no place on the sphere", (unsigned)r->vertex);
        kn_mesh_put_back(&w->rings, r->vertex, ring, r->k);
        w->alive[w->nalive++] = r->vertex;
        for (int k = 0; k < TIMES; k++) (void)kn_mesh_globe_relax(&w->globe, r->vertex);
    }
    w->nremovals = first;
    for (int k = 0; k < TIMES; k++)
        for (size_t i = end; i-- > first;) {
            const removal *r = &w->removals[i];
            kn_mesh_globe_relax(&w->globe, r->vertex);
            for (int j = 0; j < r->k && k % 2 == 1; j++)
                kn_mesh_globe_relax(&w->globe, w->ring[r->first + (size_t)j]);
        }
    return kn_progress(ctx, "to sphere", 0.0);
}

static kn_status spread(kn_ctx *ctx, work *w)
{
    enum { OFTEN = 8, LAST = 12, MOVES = 4000 };
    kn_status status = KN_OK;
    while (status == KN_OK && w->nalive > 4) status = take_round(ctx, w);
    if (status != KN_OK) return status;
    place_tetrahedron(w);
    kn_mesh_globe_measure(&w->globe, w->alive, w->nalive);
    size_t swept = w->nalive;
    for (size_t k = w->nrounds; status == KN_OK && k-- > 0;) {
        status = put_round(ctx, w, w->round[k]);
        if (status != KN_OK || 2 * w->nalive < 3 * swept) continue;
        sweep(w, OFTEN + MOVES / w->nalive);
        swept = w->nalive;
    }
    for (int k = 0; status == KN_OK && k < LAST; k++) {
        sweep(w, 1);
        status = kn_progress(ctx, "to sphere", 0.0);
    }
    return status;
}

// ---- turned to where the mesh is ----

// The eigenvector of the largest eigenvalue of a symmetric matrix, by Jacobi's rotations.
static void largest_eigenvector(double out[4], double m[4][4])
{
    enum { SWEEPS = 40 };
    double v[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (int k = 0; k < SWEEPS; k++)
        for (int p = 0; p < 3; p++)
            for (int q = p + 1; q < 4; q++) {
                if (m[p][q] == 0.0) continue;
                double theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                double t = copysign(1.0, theta) / (fabs(theta) + hypot(theta, 1.0)), c = 1.0 / hypot(t, 1.0),
                       s = t * c;
                for (int i = 0; i < 4; i++) {
                    double a = m[i][p], b = m[i][q];
                    m[i][p] = c * a - s * b, m[i][q] = s * a + c * b;
                }
                for (int i = 0; i < 4; i++) {
                    double a = m[p][i], b = m[q][i];
                    m[p][i] = c * a - s * b, m[q][i] = s * a + c * b;
                    a = v[i][p], b = v[i][q];
                    v[i][p] = c * a - s * b, v[i][q] = s * a + c * b;
                }
            }
    int best = 0;
    for (int i = 1; i < 4; i++)
        if (m[i][i] > m[best][best]) best = i;
    for (int i = 0; i < 4; i++) out[i] = v[i][best];
}

// sum[a][b] = over all triangles of their area, times the middle on the sphere (a), times the direction of the middle
// in space from the centre of them all (b).
static void correlate(double sum[3][3], const kn_mesh *m, const double *xyz)
{
    double centre[4] = {0};
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < m->ntriangles; i++) {
            const double *p[3], *s[3];
            double u[3], w[3], n[3], middle[3], area = 0.0, far = 0.0;
            for (int k = 0; k < 3; k++) {
                p[k] = m->position + 3 * (size_t)m->triangle[3 * i + (size_t)k];
                s[k] = xyz + 3 * (size_t)m->triangle[3 * i + (size_t)k];
            }
            for (int c = 0; c < 3; c++) {
                u[c] = p[1][c] - p[0][c], w[c] = p[2][c] - p[0][c];
                middle[c] = (p[0][c] + p[1][c] + p[2][c]) / 3.0;
            }
            for (int c = 0; c < 3; c++) {
                n[c] = u[(c + 1) % 3] * w[(c + 2) % 3] - u[(c + 2) % 3] * w[(c + 1) % 3];
                area += n[c] * n[c];
            }
            area = sqrt(area);
            for (int c = 0; pass == 0 && c < 3; c++) centre[c] += area * middle[c];
            if (pass == 0) centre[3] += area;
            if (pass == 0 || !(centre[3] > 0.0)) continue;
            for (int c = 0; c < 3; c++) middle[c] -= centre[c] / centre[3], far += middle[c] * middle[c];
            far = sqrt(far);
            for (int a = 0; a < 3 && far > 0.0; a++)
                for (int b = 0; b < 3; b++) sum[a][b] += area * (s[0][a] + s[1][a] + s[2][a]) * middle[b] / far;
        }
}

// The rotation that brings the places on the sphere nearest to the directions of those in space (Horn).
static void turn_to_space(double *xyz, const kn_mesh *m)
{
    double s[3][3] = {{0}}, q[4];
    correlate(s, m, xyz);
    double trace = s[0][0] + s[1][1] + s[2][2];
    double n[4][4] = {{trace, s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]}};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) n[a + 1][b + 1] = s[a][b] + s[b][a] - (a == b ? trace : 0.0);
    for (int a = 1; a < 4; a++) n[a][0] = n[0][a];
    largest_eigenvector(q, n);
    for (size_t v = 0; v < m->nvertices; v++) {
        double *x = xyz + 3 * v, t[3], y[3], length = 0.0; // x + 2 w (q x x) + 2 q x (q x x)
        for (int c = 0; c < 3; c++) {
            int d = (c + 1) % 3, e = (c + 2) % 3;
            t[c] = 2.0 * (q[d + 1] * x[e] - q[e + 1] * x[d]);
        }
        for (int c = 0; c < 3; c++) {
            int d = (c + 1) % 3, e = (c + 2) % 3;
            y[c] = x[c] + q[0] * t[c] + q[d + 1] * t[e] - q[e + 1] * t[d];
            length += y[c] * y[c];
        }
        for (int c = 0; c < 3 && length > 0.0; c++) x[c] = y[c] / sqrt(length);
    }
}

// ---- the whole ----

// All triangles counterclockwise: a covering of the sphere, and a simple one if their areas add up to 4 pi, not more.
static kn_status check_cover(kn_ctx *ctx, const double *xyz, const kn_mesh *m)
{
    double sum = 0.0;
    for (size_t i = 0; i < m->ntriangles; i++) {
        const double *p[3];
        double bound, cosines = 1.0;
        for (int k = 0; k < 3; k++) p[k] = xyz + 3 * (size_t)m->triangle[3 * i + (size_t)k];
        double value = kn_mesh_turn_value(p[0], p[1], p[2], &bound);
        if (!(value > bound)) return kn_fail(ctx, KN_EUNDECIDED, "mesh: triangle %zu may be folded on the sphere", i);
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++) cosines += p[k][c] * p[(k + 1) % 3][c];
        sum += 2.0 * atan2(value, cosines);
    }
    if (!(sum < 18.0)) return kn_fail(ctx, KN_EUNDECIDED, "mesh: the sphere is covered more than once");
    return KN_OK;
}

static kn_status check_closed(kn_ctx *ctx, const kn_mesh *mesh)
{
    kn_mesh_topology t;
    kn_status status = kn_mesh_survey(ctx, &t, mesh);
    if (status != KN_OK || (t.components == 1 && t.irregular == 0 && t.loops == 0 && t.euler == 2)) return status;
    return kn_fail(
        ctx, KN_EDOMAIN,
        "mesh: no closed surface of genus 0: %d components, %d border loops, Euler characteristic %ld, %zu "
        "irregular edges",
        t.components, t.loops, t.euler, t.irregular);
}

static kn_status work_init(kn_ctx *ctx, work *w, const kn_mesh *mesh, double *xyz)
{
    size_t n = mesh->nvertices;
    w->globe = (kn_mesh_globe){&w->rings, mesh->position, xyz, 1.0};
    w->alive = kn_alloc(ctx, n, sizeof *w->alive);
    w->ring = kn_alloc(ctx, n, KN_MESH_MOST_RING * sizeof *w->ring);
    w->removals = kn_alloc(ctx, n, sizeof *w->removals);
    w->candidates = kn_alloc(ctx, n, sizeof *w->candidates);
    w->locked = kn_alloc_zero(ctx, n, sizeof *w->locked);
    if (!w->alive || !w->ring || !w->removals || !w->candidates || !w->locked) return KN_ENOMEM;
    kn_status status = kn_mesh_rings_init(ctx, &w->rings, mesh);
    for (size_t v = 0; status == KN_OK && v < n; v++)
        if (w->rings.degree[v] > 0) w->alive[w->nalive++] = (uint32_t)v;
    return status;
}

static void work_clear(kn_ctx *ctx, work *w)
{
    kn_mesh_rings_clear(ctx, &w->rings);
    kn_free(ctx, w->alive);
    kn_free(ctx, w->ring);
    kn_free(ctx, w->removals);
    kn_free(ctx, w->candidates);
    kn_free(ctx, w->locked);
    kn_free(ctx, w->round);
}

kn_status kn_mesh_to_sphere(kn_ctx *ctx, double *xyz, const kn_mesh *mesh)
{
    kn_status status = check_closed(ctx, mesh);
    if (status != KN_OK) return status;
    work w = {0};
    double *x = kn_alloc_zero(ctx, mesh->nvertices, 3 * sizeof *x);
    status = x ? work_init(ctx, &w, mesh, x) : KN_ENOMEM;
    if (status == KN_OK) status = spread(ctx, &w);
    if (status == KN_OK) {
        turn_to_space(x, mesh);
        status = check_cover(ctx, x, mesh);
    }
    if (status == KN_OK) memcpy(xyz, x, 3 * mesh->nvertices * sizeof *x);
    work_clear(ctx, &w);
    kn_free(ctx, x);
    return status;
}
