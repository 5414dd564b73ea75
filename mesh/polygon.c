// SPDX-License-Identifier: Apache-2.0 A region between closed loops, as triangles: loops are joined by bridges to
// one ring of corners, from which ears are cut, the best shaped one first; then edges between two triangles are
// flipped where that makes the smaller angle larger. Source: Eberly, Triangulation by ear clipping (2002); Lawson,
// Software for C1 surface interpolation (1977).
#include "mesh/trimmed.h"

#include <math.h>
#include <stdlib.h>

typedef struct corner {
    int point, prev, next;
    double shape; // of the ear here: > 0, the larger the better; 0: there is none
} corner;

typedef struct ring {
    const kn_outline *o;
    corner *corner;
    int n;
} ring;

double kn_turn(const double *a, const double *b, const double *c)
{
    double l = (a[0] - c[0]) * (b[1] - c[1]), r = (a[1] - c[1]) * (b[0] - c[0]), det = l - r;
    return fabs(det) <= 3.4e-16 * (fabs(l) + fabs(r)) ? 0.0 : det; // Shewchuk's first bound
}

static const double *at(const ring *g, int k)
{
    return g->o->at[g->corner[k].point];
}

static bool same(const double *a, const double *b)
{
    return a[0] == b[0] && a[1] == b[1];
}

static double square(const double *a, const double *b)
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

// ---- bridges ----

static bool between(const double *a, const double *b, const double *p)
{
    return (p[0] - a[0]) * (p[0] - b[0]) + (p[1] - a[1]) * (p[1] - b[1]) < 0.0;
}

// Whether the segment p q meets the segment a b elsewhere than in p or q.
static bool blocks(const double *p, const double *q, const double *a, const double *b)
{
    double s = kn_turn(p, q, a), t = kn_turn(p, q, b), u = kn_turn(a, b, p), v = kn_turn(a, b, q);
    if (s == 0.0 && !same(a, p) && !same(a, q) && between(p, q, a)) return true;
    if (t == 0.0 && !same(b, p) && !same(b, q) && between(p, q, b)) return true;
    if (u == 0.0 && !same(p, a) && !same(p, b) && between(a, b, p)) return true;
    if (v == 0.0 && !same(q, a) && !same(q, b) && between(a, b, q)) return true;
    return ((s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0)) && ((u > 0.0 && v < 0.0) || (u < 0.0 && v > 0.0));
}

// Whether the way from corner k to q starts inside the region.
static bool opens(const ring *g, int k, const double *q)
{
    const double *p = at(g, k), *a = at(g, g->corner[k].prev), *b = at(g, g->corner[k].next);
    bool left_in = kn_turn(a, p, q) > 0.0, left_out = kn_turn(p, b, q) > 0.0;
    return kn_turn(a, p, b) > 0.0 ? left_in && left_out : left_in || left_out;
}

static bool is_free(const ring *g, int from, int to)
{
    const double *p = at(g, from), *q = at(g, to);
    if (same(p, q) || !opens(g, from, q) || !opens(g, to, p)) return false;
    for (int k = 0; k < g->n; k++)
        if (blocks(p, q, at(g, k), at(g, g->corner[k].next))) return false;
    return true;
}

typedef struct pair {
    double length;
    int from, to;
} pair;

static int compare_pairs(const void *a, const void *b)
{
    const pair *x = a, *y = b;
    if (x->length != y->length) return x->length < y->length ? -1 : 1;
    return x->from != y->from ? (x->from < y->from ? -1 : 1) : (x->to > y->to) - (x->to < y->to);
}

// Doubles both corners, so that the ring runs over the bridge and back.
static void bridge(ring *g, int from, int to)
{
    int a = g->n++, b = g->n++;
    corner *c = g->corner;
    c[a] = c[from], c[b] = c[to];
    c[c[from].next].prev = a;
    c[c[to].next].prev = b;
    c[from].next = b, c[b].prev = from;
    c[to].next = a, c[a].prev = to;
}

// loop[k]: the loop that corner k belongs to; joins the shortest free pair of two loops until `left` are left.
static kn_status join(kn_ctx *ctx, ring *g, int *loop, int holes)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = KN_OK;
    while (status == KN_OK && holes > 0) {
        bool joined = false;
        int target = -1;
        for (int k = 0; k < g->n && target < 0; k++)
            if (loop[k] > 0) target = loop[k];
        size_t count = 0, room = 0;
        for (int k = 0; k < g->n; k++) room += loop[k] == target;
        room *= (size_t)g->n;
        pair *pairs = kn_scratch(ctx, room, sizeof *pairs);
        if (!pairs) return KN_ENOMEM;
        for (int k = 0; k < g->n; k++)
            for (int m = 0; loop[k] == target && m < g->n; m++)
                if (loop[m] != target) pairs[count++] = (pair){square(at(g, k), at(g, m)), k, m};
        if (count > 0) qsort(pairs, count, sizeof *pairs, compare_pairs);
        for (size_t i = 0; !joined && i < count; i++) {
            if (!is_free(g, pairs[i].from, pairs[i].to)) continue;
            int to = loop[pairs[i].to];
            loop[g->n] = loop[g->n + 1] = to;
            bridge(g, pairs[i].from, pairs[i].to);
            for (int k = 0; k < g->n; k++)
                if (loop[k] == target) loop[k] = to;
            joined = true;
        }
        kn_scratch_release(ctx, mark);
        if (!joined) status = kn_fail(ctx, KN_EUNDECIDED, "mesh: the loops of a trimmed patch cross or touch");
        holes--;
    }
    return status;
}

// ---- ears ----

static bool inside(const double *a, const double *b, const double *c, const double *p)
{
    return kn_turn(a, b, p) >= 0.0 && kn_turn(b, c, p) >= 0.0 && kn_turn(c, a, p) >= 0.0;
}

static double shape_of(const double *a, const double *b, const double *c)
{
    double area = kn_turn(a, b, c), long_side = fmax(square(a, b), fmax(square(b, c), square(c, a)));
    return area > 0.0 ? area / long_side : 0.0;
}

static double ear(const ring *g, int k, bool loose)
{
    int i = g->corner[k].prev, j = g->corner[k].next;
    const double *a = at(g, i), *b = at(g, k), *c = at(g, j);
    double shape = shape_of(a, b, c);
    if (!(shape > 0.0) || loose) return shape;
    for (int m = g->corner[j].next; m != i; m = g->corner[m].next) {
        const double *p = at(g, m);
        if (same(p, a) || same(p, b) || same(p, c)) continue;
        if (inside(a, b, c, p)) return 0.0;
    }
    return shape;
}

static kn_status add(kn_ctx *ctx, kn_triangles *out, int a, int b, int c)
{
    if (out->n == out->room) {
        int room = out->room > 0 ? 2 * out->room : 128;
        int(*list)[3] = kn_resize(ctx, out->corner, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        out->corner = list;
        out->room = room;
    }
    int *t = out->corner[out->n++];
    t[0] = a, t[1] = b, t[2] = c;
    return KN_OK;
}

// One closed ring of `left` corners that contains `start`.
static kn_status clip(kn_ctx *ctx, kn_triangles *out, ring *g, int start, int left)
{
    kn_status status = KN_OK;
    int k = start;
    for (int i = 0; i < left; i++, k = g->corner[k].next) g->corner[k].shape = ear(g, k, false);
    while (status == KN_OK && left > 3) {
        int best = start;
        k = start;
        for (int i = 0; i < left; i++, k = g->corner[k].next)
            if (g->corner[k].shape > g->corner[best].shape) best = k;
        if (!(g->corner[best].shape > 0.0)) { // only rounding, or loops that touch, can bring that about
            double most = -1.0;
            for (int i = 0; i < left; i++, k = g->corner[k].next)
                if (ear(g, k, true) > most) most = ear(g, k, true), best = k;
        }
        corner *c = g->corner;
        int a = c[best].prev, b = c[best].next;
        if (kn_turn(at(g, a), at(g, best), at(g, b)) > 0.0)
            status = add(ctx, out, c[a].point, c[best].point, c[b].point);
        c[a].next = b, c[b].prev = a;
        left--;
        start = a;
        c[a].shape = ear(g, a, false), c[b].shape = ear(g, b, false);
    }
    const corner *c = g->corner;
    if (status == KN_OK && left == 3 && shape_of(at(g, start), at(g, c[start].next), at(g, c[start].prev)) > 0.0)
        status = add(ctx, out, c[start].point, c[c[start].next].point, c[c[start].prev].point);
    return status;
}

// ---- all ----

static double signed_area(const kn_outline *o, int first, int last)
{
    double sum = 0.0;
    for (int i = first, j = last - 1; i < last; j = i++) sum += o->at[j][0] * o->at[i][1] - o->at[i][0] * o->at[j][1];
    return sum;
}

static bool winds(const kn_outline *o, int first, int last, const double *p)
{
    bool in = false;
    for (int i = first, j = last - 1; i < last; j = i++) {
        const double *a = o->at[j], *b = o->at[i];
        if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) in = !in;
    }
    return in;
}

// The smallest outer loop around a hole; -1: none.
static int owner_of(const kn_outline *o, int hole, const double *area)
{
    int best = -1;
    for (int i = 0; i < o->nloops; i++) {
        int first = i > 0 ? o->loop_end[i - 1] : 0, start = hole > 0 ? o->loop_end[hole - 1] : 0;
        if (!(area[i] > 0.0) || !winds(o, first, o->loop_end[i], o->at[start])) continue;
        if (best < 0 || area[i] < area[best]) best = i;
    }
    return best;
}

// One outer loop with its holes.
static kn_status fill_loop(kn_ctx *ctx, kn_triangles *out, const kn_outline *o, int outer, const int *owner)
{
    int n = 0, holes = 0;
    for (int i = 0; i < o->nloops; i++) {
        if (i != outer && owner[i] != outer) continue;
        n += o->loop_end[i] - (i > 0 ? o->loop_end[i - 1] : 0);
        holes += i != outer;
    }
    ring g = {.o = o};
    int room = n + 2 * holes + 2;
    g.corner = kn_scratch(ctx, (size_t)room, sizeof *g.corner);
    int *loop = kn_scratch(ctx, (size_t)room, sizeof *loop), name = 1, start = 0;
    if (!g.corner || !loop) return KN_ENOMEM;
    for (int i = 0; i < o->nloops; i++) {
        if (i != outer && owner[i] != outer) continue;
        int first = i > 0 ? o->loop_end[i - 1] : 0, count = o->loop_end[i] - first, base = g.n;
        for (int k = 0; k < count; k++, g.n++) {
            g.corner[g.n] = (corner){first + k, base + (k + count - 1) % count, base + (k + 1) % count, 0.0};
            loop[g.n] = i == outer ? 0 : name;
        }
        if (i == outer) start = base;
        name += i != outer;
    }
    kn_status status = join(ctx, &g, loop, holes);
    return status == KN_OK ? clip(ctx, out, &g, start, g.n) : status;
}

kn_status kn_outline_triangulate(kn_ctx *ctx, kn_triangles *out, const kn_outline *o)
{
    kn_mark mark = kn_scratch_mark(ctx);
    double *area = kn_scratch(ctx, (size_t)o->nloops, sizeof *area);
    int *owner = kn_scratch(ctx, (size_t)o->nloops, sizeof *owner);
    kn_status status = area && owner ? KN_OK : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < o->nloops; i++)
        area[i] = signed_area(o, i > 0 ? o->loop_end[i - 1] : 0, o->loop_end[i]);
    for (int i = 0; status == KN_OK && i < o->nloops; i++) owner[i] = area[i] > 0.0 ? -1 : owner_of(o, i, area);
    for (int i = 0; status == KN_OK && i < o->nloops; i++) {
        kn_mark inner = kn_scratch_mark(ctx);
        if (area[i] > 0.0) status = fill_loop(ctx, out, o, i, owner);
        kn_scratch_release(ctx, inner);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
