// SPDX-License-Identifier: Apache-2.0 kn_mesh_add_trimmed: what a trim leaves of a patch, as triangles.  Boxes of
// the grid that lie inside the region, clear of its boundary, become two triangles each. What remains between them
// and the boundary is a region of its own, bounded by the points along the boundary and by the grid's corners, and
// is triangulated in the plane.
#include "mesh/net.h"
#include "mesh/trimmed.h"

#include <math.h>
#include <string.h>

// Boxes are kept this part of a step away from the boundary, against slivers.
#define CLEARANCE 0.3

enum { OUTSIDE = 0, INSIDE = 1, MET = 2 };

typedef struct grid {
    int a, b;             // boxes in r and in t
    unsigned char *state; // of box (i, j): i * b + j
    int *vertex;          // of corner (i, j): i * (b + 1) + j: point of the outline; -1: not yet
} grid;

static unsigned char state(const grid *g, int i, int j)
{
    return i < 0 || j < 0 || i >= g->a || j >= g->b ? OUTSIDE : g->state[i * g->b + j];
}

// Boxes that the boundary meets, or nearly.
static void mark_boundary(grid *g, const kn_outline *o)
{
    const int n[2] = {g->a, g->b};
    for (int l = 0, first = 0; l < o->nloops; first = o->loop_end[l++])
        for (int k = first; k < o->loop_end[l]; k++) {
            const double *p = o->at[k], *q = o->at[k + 1 < o->loop_end[l] ? k + 1 : first];
            int lo[2], hi[2];
            bool edge = false;
            for (int c = 0; c < 2; c++) {
                // along an edge of the square the boxes beside it may stay: its points are the grid's
                bool on = p[c] == q[c] && (p[c] == 0.0 || p[c] == 1.0);
                bool from = p[1 - c] * n[1 - c] == rint(p[1 - c] * n[1 - c]);
                bool to = q[1 - c] * n[1 - c] == rint(q[1 - c] * n[1 - c]);
                edge = edge || (on && from && to);
                lo[c] = (int)floor(fmin(p[c], q[c]) * n[c] - CLEARANCE);
                hi[c] = (int)floor(fmax(p[c], q[c]) * n[c] + CLEARANCE);
            }
            if (edge) continue;
            for (int i = lo[0] > 0 ? lo[0] : 0; i <= hi[0] && i < g->a; i++)
                for (int j = lo[1] > 0 ? lo[1] : 0; j <= hi[1] && j < g->b; j++) g->state[i * g->b + j] = MET;
        }
}

// A run of boxes between two that the boundary meets lies on one side of it.
static void fill_inside(grid *g, const kn_outline *o)
{
    for (int i = 0; i < g->a; i++) {
        bool known = false, in = false;
        for (int j = 0; j < g->b; j++) {
            if (g->state[i * g->b + j] == MET) {
                known = false;
                continue;
            }
            if (!known) in = kn_outline_contains(o, (i + 0.5) / g->a, (j + 0.5) / g->b);
            known = true;
            g->state[i * g->b + j] = in ? INSIDE : OUTSIDE;
        }
    }
    // where two boxes touch at a corner alone, one goes: loops around the boxes must not touch themselves
    for (bool changed = true; changed;) {
        changed = false;
        for (int i = 1; i < g->a; i++)
            for (int j = 1; j < g->b; j++) {
                bool p = state(g, i - 1, j - 1) == INSIDE, q = state(g, i, j - 1) == INSIDE;
                bool r = state(g, i, j) == INSIDE, s = state(g, i - 1, j) == INSIDE;
                if (p != r || q != s || p == q) continue;
                g->state[i * g->b + (p ? j : j - 1)] = MET;
                changed = true;
            }
    }
}

// ---- the rest of the region ----

static kn_status corner(kn_ctx *ctx, int *point, grid *g, kn_outline *o, int i, int j)
{
    int *v = &g->vertex[i * (g->b + 1) + j];
    kn_status status = KN_OK;
    if (*v < 0) {
        *v = o->n;
        status = kn_outline_add(ctx, o, (const double[2]){(double)i / g->a, (double)j / g->b});
    }
    *point = *v;
    return status;
}

// Corners of the boundary that are corners of the grid are the same vertex.
static void find_corners(grid *g, const kn_outline *o)
{
    for (int k = 0; k < o->n; k++) {
        double x = rint(o->at[k][0] * g->a), y = rint(o->at[k][1] * g->b);
        if (o->at[k][0] == x / g->a && o->at[k][1] == y / g->b) g->vertex[(int)x * (g->b + 1) + (int)y] = k;
    }
}

// Directed sides that bound the rest, which lies to their left: those of the boundary that no inside box has, and
// those of inside boxes, backwards, that neither another one nor the boundary has.
typedef struct sides {
    int (*list)[2];
    int n;
} sides;

static bool is_grid_side(const grid *g, const kn_outline *o, int p, int q, int box[2])
{
    for (int c = 0; c < 2; c++) {
        double at = o->at[p][c];
        if (at != o->at[q][c] || (at != 0.0 && at != 1.0)) continue;
        int n = c == 0 ? g->b : g->a, last = (c == 0 ? g->a : g->b) - 1;
        double x = o->at[p][1 - c] * n, y = o->at[q][1 - c] * n;
        if (x != rint(x) || y != rint(y) || fabs(x - y) != 1.0) return false;
        box[c] = at == 0.0 ? 0 : last;
        box[1 - c] = (int)fmin(x, y);
        return true;
    }
    return false;
}

static kn_status collect_sides(kn_ctx *ctx, sides *s, grid *g, kn_outline *o)
{
    int boundary = o->n, box[2];
    s->list = kn_scratch(ctx, (size_t)boundary + 4 * (size_t)g->a * (size_t)g->b + 4, sizeof *s->list);
    if (!s->list) return KN_ENOMEM;
    for (int l = 0, first = 0; l < o->nloops; first = o->loop_end[l++])
        for (int k = first; k < o->loop_end[l]; k++) {
            int next = k + 1 < o->loop_end[l] ? k + 1 : first;
            if (is_grid_side(g, o, k, next, box) && state(g, box[0], box[1]) == INSIDE) continue;
            s->list[s->n][0] = k, s->list[s->n++][1] = next;
        }
    static const int di[5] = {0, 1, 1, 0, 0}, dj[5] = {0, 0, 1, 1, 0}, ni[4] = {0, 1, 0, -1}, nj[4] = {-1, 0, 1, 0};
    kn_status status = KN_OK;
    for (int i = 0; i < g->a; i++)
        for (int j = 0; j < g->b; j++)
            for (int e = 0; status == KN_OK && e < 4 && state(g, i, j) == INSIDE; e++) {
                int x = i + ni[e], y = j + nj[e];
                if (state(g, x, y) == INSIDE || x < 0 || y < 0 || x >= g->a || y >= g->b) continue;
                int *side = s->list[s->n++];
                status = corner(ctx, &side[1], g, o, i + di[e], j + dj[e]);
                if (status == KN_OK) status = corner(ctx, &side[0], g, o, i + di[e + 1], j + dj[e + 1]);
            }
    return status;
}

static kn_status crossing(kn_ctx *ctx)
{
    return kn_fail(ctx, KN_EUNDECIDED, "mesh: the loops of a trimmed patch cross or touch");
}

// Of the sides that leave q, the one that turns most to the left from p q; -1: there is none.
static int leftmost(const sides *s, const kn_outline *o, const int *next, int first, int p, int q)
{
    double most = -INFINITY;
    int best = -1;
    for (int m = first; m >= 0; m = next[m]) {
        double a[2], b[2];
        for (int c = 0; c < 2; c++) {
            a[c] = o->at[q][c] - o->at[p][c];
            b[c] = o->at[s->list[m][1]][c] - o->at[q][c];
        }
        double turn = atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
        if (turn > most) most = turn, best = m;
    }
    return best;
}

// Chains sides to loops. Where several leave a point, that which turns most to the left is taken, so that loops which
// touch there come apart.
static kn_status chain(kn_ctx *ctx, kn_outline *rest, int **point, const sides *s, const kn_outline *o)
{
    int *first = kn_scratch(ctx, (size_t)o->n, sizeof *first),
        *next = kn_scratch(ctx, (size_t)s->n + 1, sizeof *next);
    *point = kn_scratch(ctx, (size_t)s->n + 1, sizeof **point);
    rest->loop_end = kn_alloc(ctx, (size_t)s->n + 1, sizeof *rest->loop_end);
    if (!first || !next || !*point || !rest->loop_end) return KN_ENOMEM;
    for (int k = 0; k < o->n; k++) first[k] = -1;
    for (int k = s->n - 1; k >= 0; k--) next[k] = first[s->list[k][0]], first[s->list[k][0]] = k;
    kn_status status = KN_OK;
    for (int start = 0; status == KN_OK && start < s->n; start++) {
        int k = start;
        if (next[start] == -2) continue;
        do {
            int p = s->list[k][0], q = s->list[k][1];
            int *link = &first[p];
            while (*link != k && *link >= 0) link = &next[*link];
            if (*link != k) return crossing(ctx);
            *link = next[k], next[k] = -2;
            (*point)[rest->n] = p;
            status = kn_outline_add(ctx, rest, o->at[p]);
            k = q == s->list[start][0] ? -1 : leftmost(s, o, next, first[q], p, q);
            if (k < 0 && q != s->list[start][0]) return crossing(ctx);
        } while (status == KN_OK && k >= 0);
        rest->loop_end[rest->nloops++] = rest->n;
    }
    return status;
}

// ---- the mesh ----

static kn_mesh_place place_of(double x, int segments)
{
    double i = rint(x * segments);
    return x == i / segments ? (kn_mesh_place){x, (segments - i) / segments} : (kn_mesh_place){x, 1.0 - x};
}

static kn_status put(kn_ctx *ctx, kn_mesh *mesh, const kn_patch_net *net, const grid *g, const kn_outline *o,
                     const kn_triangles *rest, const int *point, bool reversed)
{
    size_t boxes = 0, first = mesh->nvertices;
    for (int k = 0; k < g->a * g->b; k++) boxes += g->state[k] == INSIDE;
    double *work = kn_scratch(ctx, kn_patch_net_room(net), sizeof *work);
    kn_status status = work ? KN_OK : KN_ENOMEM;
    if (first + (size_t)o->n > UINT32_MAX)
        status = kn_fail(ctx, KN_ELIMIT, "mesh: more than %lu vertices", (unsigned long)UINT32_MAX);
    if (status == KN_OK) status = kn_mesh_reserve(ctx, mesh, (size_t)o->n, 2 * boxes + (size_t)rest->n, true);
    if (status != KN_OK) return status;
    for (int k = 0; k < o->n; k++) {
        kn_mesh_place r = place_of(o->at[k][0], g->a), t = place_of(o->at[k][1], g->b);
        size_t at = 3 * (first + (size_t)k);
        kn_patch_net_point(mesh->position + at, mesh->normal + at, net, &r, &t, reversed ? -1.0 : 1.0, work);
    }
    mesh->nvertices += (size_t)o->n;
    for (int k = 0; k < rest->n; k++) {
        size_t c[3];
        for (int e = 0; e < 3; e++) c[e] = first + (size_t)point[rest->corner[k][e]];
        kn_mesh_add_triangle(mesh, c[0], c[reversed ? 2 : 1], c[reversed ? 1 : 2]);
    }
    for (int i = 0; i < g->a; i++)
        for (int j = 0; j < g->b; j++) {
            if (g->state[i * g->b + j] != INSIDE) continue;
            const int *v = &g->vertex[i * (g->b + 1) + j];
            size_t p = first + (size_t)v[0], s = first + (size_t)v[1];
            size_t q = first + (size_t)v[g->b + 1], u = first + (size_t)v[g->b + 2];
            kn_mesh_add_triangle(mesh, p, reversed ? u : q, reversed ? q : u);
            kn_mesh_add_triangle(mesh, p, reversed ? s : u, reversed ? u : s);
        }
    return KN_OK;
}

static kn_status grid_init(kn_ctx *ctx, grid *g, kn_outline *o, const int segments[2])
{
    g->a = segments[0], g->b = segments[1];
    size_t boxes = (size_t)g->a * (size_t)g->b, corners = ((size_t)g->a + 1) * ((size_t)g->b + 1);
    g->state = kn_scratch(ctx, boxes, 1);
    g->vertex = kn_scratch(ctx, corners, sizeof *g->vertex);
    if (!g->state || !g->vertex) return KN_ENOMEM;
    memset(g->state, OUTSIDE, boxes);
    for (size_t k = 0; k < corners; k++) g->vertex[k] = -1;
    mark_boundary(g, o);
    fill_inside(g, o);
    find_corners(g, o);
    kn_status status = KN_OK;
    for (int i = 0, unused; i < g->a; i++) // corners that only inside boxes have
        for (int j = 0; j < g->b; j++)
            for (int e = 0; status == KN_OK && e < 4 && g->state[i * g->b + j] == INSIDE; e++)
                status = corner(ctx, &unused, g, o, i + e / 2, j + e % 2);
    return status;
}

kn_status kn_mesh_add_trimmed(kn_ctx *ctx, kn_mesh *mesh, const kn_bezier *patch, const kn_trim *trim,
                              const int segments[2], bool reversed)
{
    if (trim->nloops == 0) return kn_mesh_add_patch(ctx, mesh, patch, segments, reversed);
    kn_status status = kn_mesh_check_patch(ctx, mesh, patch, segments);
    if (status != KN_OK) return status;
    kn_outline o = {0}, rest = {0};
    kn_triangles triangles = {0};
    kn_patch_net net;
    sides s = {0};
    grid g;
    int *point = NULL;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_patch_net_init(ctx, &net, patch);
    if (status == KN_OK) status = kn_outline_sample(ctx, &o, trim, segments);
    if (status == KN_OK) status = grid_init(ctx, &g, &o, segments);
    if (status == KN_OK) status = collect_sides(ctx, &s, &g, &o);
    if (status == KN_OK) status = chain(ctx, &rest, &point, &s, &o);
    if (status == KN_OK && rest.n > 0) status = kn_outline_triangulate(ctx, &triangles, &rest);
    if (status == KN_OK) status = put(ctx, mesh, &net, &g, &o, &triangles, point, reversed);
    kn_free(ctx, triangles.corner);
    kn_outline_clear(ctx, &o);
    kn_outline_clear(ctx, &rest);
    kn_scratch_release(ctx, mark);
    return status;
}
