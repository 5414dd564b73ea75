// SPDX-License-Identifier: Apache-2.0
// Which edges of a base coincide, and where a cell beyond an edge lies on the surface at the other side.
#include "job/internal.h"

#include <math.h>
#include <stdlib.h>

// The curve that one edge is, over [0,1].
typedef struct edge_points {
    double *point;  // 3 n numbers, projected
    double *weight; // n, over the largest
    double *knot;   // n + degree + 1
    int n, degree, index, body;
    bool collapsed;
    double key; // for sorting: near one another where edges coincide, in either direction
} edge_points;

static double separation(const double *p, const double *q)
{
    return fmax(fabs(p[0] - q[0]), fmax(fabs(p[1] - q[1]), fabs(p[2] - q[2])));
}

static kn_status edge_init(kn_ctx *ctx, edge_points *out, const kn_spline *s, int which, double tol)
{
    int fixed = which >> 1, along = 1 - fixed, n = s->count[along], p = s->degree[along];
    size_t count = kn_spline_count(s), row = (size_t)s->count[1], m = (size_t)n;
    size_t start = (which & 1) == 0 ? 0 : fixed == 0 ? count - row : row - 1, step = along == 0 ? row : 1;
    double most = 0.0, lo, hi, *room = kn_alloc(ctx, 5 * m + (size_t)p + 1, sizeof *room);
    *out = (edge_points){room, room + 3 * m, room + 4 * m, n, p, .collapsed = true};
    if (!room) return KN_ENOMEM;
    for (size_t i = 0; i < m; i++) {
        size_t at = start + i * step;
        double w = s->rational ? s->coef[3 * count + at] : 1.0;
        for (size_t c = 0; c < 3; c++) out->point[3 * i + c] = s->coef[c * count + at] / w;
        if (separation(out->point + 3 * i, out->point) > tol) out->collapsed = false;
        out->weight[i] = w;
        most = fmax(most, w);
    }
    for (size_t i = 0; i < m; i++) out->weight[i] /= most;
    kn_spline_domain(s, along, &lo, &hi);
    for (int i = 0; i < n + p + 1; i++) out->knot[i] = (s->knots[along][i] - lo) / (hi - lo);
    const double *last = out->point + 3 * (m - 1), direction[3] = {0.536, 0.312, 0.152}; // coefficients sum to 1
    for (int c = 0; c < 3; c++) out->key += 0.5 * direction[c] * (out->point[c] + last[c]);
    return KN_OK;
}

// The same curve over [0,1], or one run through backwards. Parameters and weights within 1e-9: an edge a cell long is
// then off by no more than tol is of the base.
static bool same_curve(const edge_points *a, const edge_points *b, bool backward, double tol)
{
    const double near = 1e-9;
    bool same = true;
    int n = a->n, last = n + a->degree;
    for (int i = 0; same && i < n; i++) {
        int j = backward ? n - 1 - i : i;
        same = separation(a->point + 3 * i, b->point + 3 * j) <= tol && fabs(a->weight[i] - b->weight[j]) <= near;
    }
    for (int i = 0; same && i <= last; i++)
        same = fabs(a->knot[i] - (backward ? 1.0 - b->knot[last - i] : b->knot[i])) <= near;
    return same;
}

static bool coincide(bool *reversed, const edge_points *a, const edge_points *b, double tol)
{
    if (a->n != b->n || a->degree != b->degree || a->body != b->body || a->collapsed || b->collapsed) return false;
    *reversed = !same_curve(a, b, false, tol);
    return !*reversed || same_curve(a, b, true, tol);
}

static int compare_keys(const void *a, const void *b)
{
    const edge_points *x = a, *y = b;
    return x->key != y->key ? (x->key > y->key) - (x->key < y->key) : x->index - y->index;
}

// Takes edge f as e's partner: the one of lowest number, and `single` while there is no second one.
static void take_partner(kn_job_partner *out, int f, bool reversed)
{
    bool first = out->edge < 0;
    if (first || f < out->edge) *out = (kn_job_partner){.edge = f, .reversed = reversed};
    out->single = first;
}

// Edges sorted by their keys: only those nearby can coincide.
static void find_pairs(kn_job_partner *partners, const edge_points *edges, int n, double tol)
{
    for (int e = 0; e < n; e++) partners[e] = (kn_job_partner){.edge = -1};
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n && edges[j].key - edges[i].key <= 2.0 * tol; j++) {
            bool reversed;
            if (!coincide(&reversed, &edges[i], &edges[j], tol)) continue;
            take_partner(&partners[edges[i].index], edges[j].index, reversed);
            take_partner(&partners[edges[j].index], edges[i].index, reversed);
        }
}

kn_status kn_job_find_partners(kn_ctx *ctx, kn_job_partner *partners, const kn_spline *surfaces, const int *bodies,
                               int nsurfaces, double tol)
{
    int n = 4 * nsurfaces;
    edge_points *edges = kn_alloc_zero(ctx, (size_t)n, sizeof *edges);
    kn_status status = edges ? KN_OK : KN_ENOMEM;
    for (int e = 0; status == KN_OK && e < n; e++) {
        status = edge_init(ctx, &edges[e], &surfaces[e / 4], e % 4, tol);
        edges[e].index = e, edges[e].body = bodies[e / 4];
    }
    if (status == KN_OK) {
        qsort(edges, (size_t)n, sizeof *edges, compare_keys);
        find_pairs(partners, edges, n, tol);
    }
    for (int e = 0; edges && e < n; e++) kn_free(ctx, edges[e].point);
    kn_free(ctx, edges);
    return status;
}

// Directions of the (u,v) plane in quarter turns from +u. Edges: 0 and 1 at the ends of u, 2 and 3 at those of v.
static const int outward[4] = {2, 0, 3, 1}, inward[4] = {0, 2, 1, 3}, forward[4] = {1, 1, 0, 0};

// The turn (kn_job_place) that leads out over `edge` and in over its partner. It must run along the partner as the edges
// coincide: where a rotation does not, the normals of the two surfaces disagree, and one reflection more, along the
// edge, makes it, with w turned over.
static int turn_over(int edge, const kn_job_partner *p)
{
    int to = p->edge % 4, turn = (inward[to] - outward[edge] + 4) % 4;
    bool same_way = (forward[edge] + turn) % 4 == forward[to];
    if (same_way == !p->reversed) return turn;
    return (to < 2 ? turn : (turn + 2) % 4) | KN_JOB_FLIP; // u -> 1 - u is half a turn and v -> 1 - v
}

bool kn_job_turns_over(int edge, const kn_job_partner *partner)
{
    return partner->edge >= 0 && (turn_over(edge, partner) & KN_JOB_FLIP) != 0;
}

// A place on an edge, seen from the surfaces on both sides; sign: of w and n on the second one.
typedef struct edge_place {
    const kn_shell *shell[2];
    double at[2][2], sign;
} edge_place;

static double apart(const double p[3], const double q[3])
{
    return sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
}

// Shells of S + w n agree where their normals do; what else there may be agrees where T does, at five heights.
static kn_status agrees(kn_ctx *ctx, bool *yes, const kn_job *job, const edge_place *e, const double w[2], double tol)
{
    const kn_job_options *o = &job->options;
    bool volume = kn_shell_normal(e->shell[0])->coef == NULL;
    bool fields = o->thickness || o->direction || o->attraction || o->stretch;
    // what normals that agree may differ by; the stretch makes thicknesses of up to about 4
    double reach = fmax(fabs(w[0]), fabs(w[1])) * job->w_length * (o->stretch ? 4.0 : 1.0);
    double p[2][3], slack = tol * reach + 2e-9 * job->diagonal;
    kn_status status = KN_OK;
    for (int k = 0; k < 5 && *yes && (fields || volume) && status == KN_OK; k++) {
        for (int i = 0; i < 2 && status == KN_OK; i++)
            status = kn_shell_eval(ctx, p[i], NULL, e->shell[i], e->at[i][0], e->at[i][1],
                                   (i == 0 ? 1.0 : e->sign) * (w[0] + 0.25 * k * (w[1] - w[0])));
        if (status == KN_OK) *yes = apart(p[0], p[1]) <= slack;
    }
    for (int i = 0; i < 2 && *yes && !volume && !o->direction && status == KN_OK; i++)
        status = kn_shell_unit_normal(ctx, p[i], e->shell[i], e->at[i][0], e->at[i][1]);
    for (int c = 0; c < 3; c++) p[1][c] *= e->sign;
    if (status == KN_OK && *yes && !volume && !o->direction) *yes = apart(p[0], p[1]) <= tol;
    return status;
}

// Whether a tile may go on over an edge: the cell lines of both sides meet there, and so do the normals, within tol.
static kn_status goes_on(kn_ctx *ctx, bool *yes, const kn_job *job, int surface, int edge, const double w[2],
                         double tol)
{
    const double near = 1e-9; // of the edge, as for its knots
    const kn_job_surface *s = &job->surfaces[surface];
    const kn_job_partner *p = &s->partner[edge];
    const kn_job_surface *other = &job->surfaces[p->edge / 4];
    int fixed[2] = {edge >> 1, (p->edge % 4) >> 1}, n = s->cells[1 - fixed[0]];
    const double *line[2] = {s->lines[1 - fixed[0]], other->lines[1 - fixed[1]]};
    bool flip = kn_job_turns_over(edge, p), volume = kn_shell_normal(s->shell)->coef == NULL;
    edge_place e = {.shell = {s->shell, other->shell}, .sign = flip ? -1.0 : 1.0};
    kn_status status = KN_OK;
    *yes = p->single && !(flip && volume) && other->cells[1 - fixed[1]] == n;
    e.at[0][fixed[0]] = s->lines[fixed[0]][edge % 2 == 0 ? 0 : s->cells[fixed[0]]];
    e.at[1][fixed[1]] = other->lines[fixed[1]][p->edge % 2 == 0 ? 0 : other->cells[fixed[1]]];
    for (int k = 0; status == KN_OK && *yes && k <= 2 * n; k++) { // the lines, and the middles between them
        double x[2];
        for (int i = 0; i < 2; i++) {
            int j = i == 1 && p->reversed ? 2 * n - k : k;
            double t = 0.5 * (line[i][j / 2] + line[i][(j + 1) / 2]);
            x[i] = (t - line[i][0]) / (line[i][n] - line[i][0]);
            e.at[i][1 - fixed[i]] = t;
        }
        *yes = fabs(x[0] - (p->reversed ? 1.0 - x[1] : x[1])) <= near;
        if (*yes) status = agrees(ctx, yes, job, &e, w, tol);
    }
    return status;
}

kn_status kn_job_match_edges(kn_ctx *ctx, kn_job *job, const double w[2])
{
    kn_status status = KN_OK;
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++)
        for (int e = 0; status == KN_OK && e < 4; e++) {
            kn_job_partner *p = &job->surfaces[s].partner[e];
            if (p->edge >= 0) status = goes_on(ctx, &p->goes_on, job, s, e, w, 10.0 * job->options.normal_tol);
        }
    return status;
}

// Whether the cell lies beyond an end where nothing goes on.
static bool is_end(const kn_job_surface *s, int d, int cell)
{
    return !s->closed[d] && (cell < 0 || cell >= s->cells[d]) && !s->partner[2 * d + (cell >= 0)].goes_on;
}

bool kn_job_is_clipped(const kn_job *job, int surface, const int cell[2], const int offset[2])
{
    for (int d = 0; d < 2; d++)
        if (job->options.placement.border[d] == KN_BORDER_CLIP &&
            is_end(&job->surfaces[surface], d, cell[d] + offset[d]))
            return true;
    return false;
}

void kn_job_clip_ends(double end[2][2], const kn_job *job, const kn_job_place *place)
{
    const kn_job_surface *s = &job->surfaces[place->surface];
    for (int d = 0; d < 2; d++) { // a quarter turn exchanges the directions
        bool clips = job->options.placement.border[d ^ (place->turn & 1)] == KN_BORDER_CLIP && !s->closed[d];
        for (int e = 0; e < 2; e++) {
            end[d][e] = e == 0 ? -INFINITY : INFINITY;
            if (clips && !s->partner[2 * d + e].goes_on) end[d][e] = (e == 0 ? 0 : s->cells[d]) - place->cell[d];
        }
    }
}

kn_job_clipped kn_job_clip_box(const double lo[2], const double hi[2], const double end[2][2])
{
    const double near = 1e-9;
    kn_job_clipped where = KN_CLIP_INSIDE;
    for (int d = 0; d < 2; d++) {
        bool below = lo[d]<end[d][0] - near, above = hi[d]> end[d][1] + near;
        if ((below && hi[d] <= end[d][0] + near) || (above && lo[d] >= end[d][1] - near)) return KN_CLIP_OUTSIDE;
        if (below || above) where = KN_CLIP_ACROSS;
    }
    return where;
}

kn_job_place kn_job_find_place(const kn_job *job, int surface, const int cell[2], const int offset[2])
{
    const kn_job_surface *s = &job->surfaces[surface];
    kn_job_place own = {.surface = surface, .cell = {cell[0] + offset[0], cell[1] + offset[1]}};
    int outside = -1;
    for (int d = 0; d < 2; d++)
        if (job->options.placement.border[d] == KN_BORDER_CYCLIC && is_end(s, d, own.cell[d]))
            own.cell[d] = (own.cell[d] % s->cells[d] + s->cells[d]) % s->cells[d];
    for (int d = 0; d < 2; d++) {
        if (s->closed[d] || (own.cell[d] >= 0 && own.cell[d] < s->cells[d])) continue;
        if (outside >= 0) return own; // beyond a corner
        outside = d;
    }
    if (outside < 0) return own;

    bool at_end = own.cell[outside] >= 0;
    int edge = 2 * outside + at_end, along = 1 - outside, n = s->cells[along];
    int depth = at_end ? own.cell[outside] - s->cells[outside] : -1 - own.cell[outside];
    const kn_job_partner *p = &s->partner[edge];
    if (!p->goes_on) return own;
    const kn_job_surface *other = &job->surfaces[p->edge / 4];
    int across = (p->edge % 4) >> 1, i = ((own.cell[along] % n) + n) % n;
    bool same_kind = kn_shell_surface(other->shell)->rational == kn_shell_surface(s->shell)->rational;
    if (!same_kind || depth >= other->cells[across]) return own;
    kn_job_place place = {.surface = p->edge / 4, .turn = turn_over(edge, p)};
    place.cell[across] = p->edge % 2 == 0 ? depth : other->cells[across] - 1 - depth;
    place.cell[1 - across] = p->reversed ? n - 1 - i : i;
    return place;
}
