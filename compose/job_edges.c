// SPDX-License-Identifier: Apache-2.0
// Which edges of a base coincide, and where a cell beyond an edge lies on the surface at the other side.
#include "compose/job.h"

#include <math.h>

// The control points of one edge.
typedef struct edge_points {
    double *point; // 3 n numbers, projected
    int n, degree;
    bool collapsed;
} edge_points;

static double separation(const double *p, const double *q)
{
    return fmax(fabs(p[0] - q[0]), fmax(fabs(p[1] - q[1]), fabs(p[2] - q[2])));
}

static kn_status edge_init(kn_ctx *ctx, edge_points *out, const kn_spline *s, int which, double tol)
{
    int fixed = which >> 1, along = 1 - fixed, n = s->count[along];
    size_t count = kn_spline_count(s), row = (size_t)s->count[1];
    size_t start = (which & 1) == 0 ? 0 : fixed == 0 ? count - row : row - 1, step = along == 0 ? row : 1;
    *out = (edge_points){.point = kn_alloc(ctx, 3 * (size_t)n, sizeof(double)), .n = n, .degree = s->degree[along]};
    if (!out->point) return KN_ENOMEM;
    out->collapsed = true;
    for (int i = 0; i < n; i++) {
        size_t at = start + (size_t)i * step;
        double w = s->rational ? s->coef[3 * count + at] : 1.0;
        for (size_t c = 0; c < 3; c++) out->point[3 * (size_t)i + c] = s->coef[c * count + at] / w;
        if (separation(out->point + 3 * i, out->point) > tol) out->collapsed = false;
    }
    return KN_OK;
}

static bool coincide(bool *reversed, const edge_points *a, const edge_points *b, double tol)
{
    if (a->n != b->n || a->degree != b->degree || a->collapsed || b->collapsed) return false;
    bool forward = true, backward = true;
    for (int i = 0; (forward || backward) && i < a->n; i++) {
        forward = forward && separation(a->point + 3 * i, b->point + 3 * i) <= tol;
        backward = backward && separation(a->point + 3 * i, b->point + 3 * (b->n - 1 - i)) <= tol;
    }
    *reversed = !forward;
    return forward || backward;
}

// The first edge that coincides with e; `single` while there is no second one.
static void find_partner(kn_job_partner *out, const edge_points *edges, int n, int e, double tol)
{
    *out = (kn_job_partner){.edge = -1};
    for (int f = 0; f < n; f++) {
        bool reversed;
        if (f == e || !coincide(&reversed, &edges[e], &edges[f], tol)) continue;
        if (out->edge >= 0) {
            out->single = false;
            return;
        }
        *out = (kn_job_partner){.edge = f, .reversed = reversed, .single = true};
    }
}

kn_status kn_job_find_partners(kn_ctx *ctx, kn_job_partner *partners, const kn_spline *surfaces, int nsurfaces,
                               double tol)
{
    int n = 4 * nsurfaces;
    edge_points *edges = kn_alloc_zero(ctx, (size_t)n, sizeof *edges);
    kn_status status = edges ? KN_OK : KN_ENOMEM;
    for (int e = 0; status == KN_OK && e < n; e++) status = edge_init(ctx, &edges[e], &surfaces[e / 4], e % 4, tol);
    for (int e = 0; status == KN_OK && e < n; e++) find_partner(&partners[e], edges, n, e, tol);
    for (int e = 0; edges && e < n; e++) kn_free(ctx, edges[e].point);
    kn_free(ctx, edges);
    return status;
}

// Directions of the (u,v) plane in quarter turns from +u. Edges: 0 and 1 at the ends of u, 2 and 3 at those of v.
static const int outward[4] = {2, 0, 3, 1}, inward[4] = {0, 2, 1, 3}, forward[4] = {1, 1, 0, 0};

// The rotation that leads out over `edge` and in over its partner. It must run along the partner as the edges
// coincide; a reflection would mean that the normals of the two surfaces disagree.
static bool rotation(int *turn, int edge, const kn_job_partner *p)
{
    int to = p->edge % 4;
    *turn = (inward[to] - outward[edge] + 4) % 4;
    bool same_way = (forward[edge] + *turn) % 4 == forward[to];
    return same_way == !p->reversed;
}

kn_job_place kn_job_find_place(const kn_job *job, int surface, const int cell[2], const int offset[2])
{
    const kn_job_surface *s = &job->surfaces[surface];
    kn_job_place own = {.surface = surface, .cell = {cell[0] + offset[0], cell[1] + offset[1]}};
    int outside = -1;
    for (int d = 0; d < 2; d++) {
        if (s->closed[d] || (own.cell[d] >= 0 && own.cell[d] < s->cells[d])) continue;
        if (outside >= 0) return own; // beyond a corner
        outside = d;
    }
    if (outside < 0) return own;

    bool at_end = own.cell[outside] >= 0;
    int edge = 2 * outside + at_end, along = 1 - outside, n = s->cells[along], turn;
    int depth = at_end ? own.cell[outside] - s->cells[outside] : -1 - own.cell[outside];
    const kn_job_partner *p = &s->partner[edge];
    if (p->edge < 0 || !p->single || !rotation(&turn, edge, p)) return own;
    const kn_job_surface *other = &job->surfaces[p->edge / 4];
    int across = (p->edge % 4) >> 1, i = ((own.cell[along] % n) + n) % n;
    bool same_kind = kn_shell_surface(other->shell)->rational == kn_shell_surface(s->shell)->rational;
    if (!same_kind || other->cells[1 - across] != n || depth >= other->cells[across]) return own;
    kn_job_place place = {.surface = p->edge / 4, .turn = turn};
    place.cell[across] = p->edge % 2 == 0 ? depth : other->cells[across] - 1 - depth;
    place.cell[1 - across] = p->reversed ? n - 1 - i : i;
    return place;
}
