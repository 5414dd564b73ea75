// SPDX-License-Identifier: Apache-2.0
// The curves of a trimmed patch.
#include "io/trim_edges.h"

#include "kernel/context.h"

#include <math.h>
#include <string.h>

enum { SPAN_POINTS = 8 };

typedef struct loading {
    kn_ctx *ctx;
    const kn_patch *patch;
    const kn_patch_net *net;
    const kn_patch_bounds *bounds; // NULL: none, or such as contradict themselves
    kn_spline surface;             // in mm
    double mm;
    const char *format;
    int *rank; // of each edge's vertices: those of the higher one are both's
} loading;

enum { INSIDE, BORDER, TOLD };

static bool on_border(const kn_spline *c, int *var)
{
    int n = c->count[0];
    for (int v = 0; v < 2; v++) {
        double at = c->coef[(1 - v) * n];
        bool all = c->degree[0] == 1 && n == 2 && (at == 0.0 || at == 1.0);
        if (!all || c->coef[(1 - v) * n + 1] != at) continue;
        *var = v;
        return true;
    }
    return false;
}

// ---- curves ----

// Equal spans from lo to hi, degree + 1 knots at the ends and degree between: pieces that meet.
static kn_status even_axis(kn_ctx *ctx, kn_patch_axis *x, int degree, int spans, double lo, double hi)
{
    int *times = kn_scratch(ctx, (size_t)spans + 1, sizeof *times);
    double *breaks = kn_scratch(ctx, (size_t)spans + 1, sizeof *breaks);
    if (!times || !breaks) return KN_ENOMEM;
    for (int k = 0; k <= spans; k++) {
        times[k] = k == 0 || k == spans ? degree + 1 : degree;
        breaks[k] = k == spans ? hi : lo + (hi - lo) * k / spans;
    }
    *x = (kn_patch_axis){degree, degree * spans + 1, spans + 1, times, breaks};
    return KN_OK;
}

static kn_status make_line(kn_ctx *ctx, kn_patch_curve *line, double **point, int degree, int spans)
{
    *point = kn_scratch(ctx, (size_t)(degree * spans) + 1, 4 * sizeof **point);
    *line = (kn_patch_curve){.point = *point, .step = 4, .first = -1};
    return *point ? even_axis(ctx, &line->axis, degree, spans, 0.0, spans) : KN_ENOMEM;
}

static int line_spans(const kn_spline *c)
{
    return c->degree[0] == 1 ? c->count[0] - 1 : SPAN_POINTS * kn_spline_spans(c, 0);
}

// Points of a trim curve: those of a polyline are its own; of others, eight to a span.
static kn_status sample_line(kn_ctx *ctx, double (*line)[2], const kn_spline *c)
{
    int n = c->count[0], spans = line_spans(c);
    double lo, hi;
    kn_status status = KN_OK;
    kn_spline_domain(c, 0, &lo, &hi);
    for (int k = 0; k <= spans && status == KN_OK; k++) {
        double at = k == spans ? hi : lo + (hi - lo) * k / spans;
        int own = k == spans ? n - 1 : c->degree[0] == 1 ? k : 0;
        line[k][0] = c->coef[own], line[k][1] = c->coef[n + own];
        if (c->degree[0] > 1 && k > 0 && k < spans) status = kn_spline_eval(ctx, line[k], c, &at);
    }
    return status;
}

// The polyline as the curve in the plane.
static kn_status add_plane(kn_ctx *ctx, kn_trim_edge *e, const double (*line)[2])
{
    double *p;
    kn_status status = make_line(ctx, &e->plane, &p, 1, e->nline - 1);
    for (int k = 0; k < e->nline && status == KN_OK; k++, p += 4) {
        p[0] = line[k][0], p[1] = line[k][1];
        p[2] = 0.0, p[3] = 1.0;
    }
    return status;
}

// Control points j = 0 .. 3 of the cubic over the segment from a to b of the trim.
static kn_status put_cubic(kn_ctx *ctx, double *p, const kn_spline *surface, const double *a, const double *b)
{
    double from[9], to[9], d[2] = {b[0] - a[0], b[1] - a[1]};
    kn_status status = kn_spline_derivatives(ctx, from, surface, a, 1);
    if (status == KN_OK) status = kn_spline_derivatives(ctx, to, surface, b, 1);
    if (status != KN_OK) return status;
    for (int c = 0; c < 3; c++) {
        p[c] = from[c];
        p[4 + c] = from[c] + (from[3 + c] * d[0] + from[6 + c] * d[1]) / 3.0;
        p[8 + c] = to[c] - (to[3 + c] * d[0] + to[6 + c] * d[1]) / 3.0;
        p[12 + c] = to[c];
    }
    for (int j = 0; j < 4; j++) p[4 * j + 3] = 1.0;
    return KN_OK;
}

static kn_status add_cubics(kn_ctx *ctx, kn_trim_edge *e, const kn_spline *surface)
{
    int spans = e->plane.axis.n - 1;
    double *p;
    kn_status status = make_line(ctx, &e->space, &p, 3, spans);
    for (int k = 0; k < spans && status == KN_OK; k++)
        status = put_cubic(ctx, p + 12 * k, surface, e->plane.point + 4 * k, e->plane.point + 4 * k + 4);
    return status;
}

// Along the side of the square where variable v runs.
static kn_status add_border(const loading *l, kn_trim_edge *e, int v)
{
    kn_ctx *ctx = l->ctx;
    const double *p = e->plane.point;
    double from = p[v], to = p[4 + v], lo = fmin(from, to), hi = fmax(from, to);
    bool upper = p[1 - v] == 1.0;
    kn_spline part = {0};
    kn_status status = kn_patch_side_spline(ctx, &part, l->patch, v == 0 ? (upper ? 2 : 0) : (upper ? 1 : 3));
    if (status == KN_OK && (lo > 0.0 || hi < 1.0)) status = kn_spline_restrict(ctx, &part, &part, &lo, &hi);
    if (status == KN_OK && from > to) status = kn_spline_reverse(ctx, &part, &part, 0);
    if (status == KN_OK) status = kn_patch_curve_load(ctx, &e->space, &part, 0, l->mm, l->format);
    kn_spline_clear(ctx, &part);
    if (status == KN_OK)
        status = even_axis(ctx, &e->plane.axis, 1, 1, e->space.axis.breaks[0],
                           e->space.axis.breaks[e->space.axis.nbreaks - 1]);
    return status;
}

// ---- edges that are told ----

static bool fits(const kn_patch_edge *e, const kn_spline *curve)
{
    double lo[2], hi[2];
    const kn_spline *plane = e->plane;
    bool good = plane && e->curve->nvars == 1 && kn_spline_dim(e->curve) == 3 && plane->nvars == 1 &&
                plane->ncomp == 2 && !plane->rational && e->point[0] && e->point[1];
    if (!good) return false;
    kn_spline_domain(e->curve, 0, &lo[0], &hi[0]);
    kn_spline_domain(plane, 0, &lo[1], &hi[1]);
    int n = plane->count[0], m = curve->count[0];
    good = lo[0] == lo[1] && hi[0] == hi[1];
    for (int c = 0; c < 2; c++)
        good = good && plane->coef[c * n] == curve->coef[c * m + (e->against ? m - 1 : 0)] &&
               plane->coef[c * n + n - 1] == curve->coef[c * m + (e->against ? 0 : m - 1)];
    return good;
}

static kn_status load_told(const loading *l, kn_trim_edge *e, int at)
{
    const kn_patch_edge *told = &l->bounds->edges[at];
    const kn_spline *plane = told->plane;
    if (!fits(told, &l->patch->trim->curves[at]))
        return kn_fail(l->ctx, KN_EDOMAIN,
                       "%s: surface %d, patch %d: its edge %llu does not fit curve %d of its trim", l->format,
                       l->patch->id.surface, l->patch->id.patch, (unsigned long long)told->number, at);
    int n = plane->count[0];
    double *p = kn_scratch(l->ctx, (size_t)n, 4 * sizeof *p);
    kn_status status = p ? kn_patch_curve_load(l->ctx, &e->space, told->curve, 0, l->mm, l->format) : KN_ENOMEM;
    if (status != KN_OK) return status;
    e->plane = (kn_patch_curve){.point = p, .step = 4, .first = -1};
    for (int k = 0; k < n; k++) {
        p[4 * k] = plane->coef[k], p[4 * k + 1] = plane->coef[n + k];
        p[4 * k + 2] = 0.0, p[4 * k + 3] = 1.0;
    }
    e->against = told->against;
    return kn_patch_axis_load(l->ctx, &e->plane.axis, plane, 0);
}

// Edges one after the other meet in one vertex, points between them apart: else nothing of the loop is told.
static bool meet(const kn_patch_bounds *bounds, const kn_trim *trim)
{
    for (int i = 0, first = 0; i < trim->nloops; first = trim->loop_end[i++])
        for (int k = first, n = trim->loop_end[i]; k < n; k++) {
            const kn_patch_edge *a = &bounds->edges[k], *b = &bounds->edges[k + 1 < n ? k + 1 : first];
            int from = !a->against, to = b->against; // ends of the curves where the loop goes on
            if (!a->curve || !b->curve) continue;
            if (a->vertex[from] != b->vertex[to] || memcmp(a->point[from], b->point[to], 3 * sizeof(double)) != 0)
                return false;
        }
    return true;
}

static kn_status load_edge(loading *l, kn_trim_edges *out, int at)
{
    const kn_spline *curve = &l->patch->trim->curves[at];
    kn_trim_edge *e = &out->edge[at];
    int v = 0;
    kn_status status = sample_line(l->ctx, out->line + e->line, curve);
    if (status != KN_OK) return status;
    bool told = l->bounds && l->bounds->edges[at].curve;
    l->rank[at] = told ? TOLD : on_border(curve, &v) ? BORDER : INSIDE;
    if (told) {
        status = load_told(l, e, at);
    } else {
        status = add_plane(l->ctx, e, (const double(*)[2])(out->line + e->line));
        if (status == KN_OK && l->rank[at] == BORDER)
            status = add_border(l, e, v);
        else if (status == KN_OK)
            status = add_cubics(l->ctx, e, &l->surface);
    }
    if (status == KN_OK) e->collapsed = !told && kn_patch_curve_collapsed(&e->space, l->net->same);
    return status;
}

// ---- keys ----

static kn_brep_key mix_number(kn_brep_key key, uint64_t number)
{
    return kn_brep_mix(kn_brep_mix(key, (double)(number >> 32)), (double)(number & UINT32_MAX));
}

typedef struct corner {
    kn_brep_key key;
    double at[3];
} corner;

// Where edge k starts (end 0) or ends (end 1) along its loop.
static corner corner_of(const loading *l, const kn_trim_edges *t, int k, int end)
{
    const kn_trim_edge *e = &t->edge[k];
    bool turned, last = (end == 1) != e->against;
    const double *p = e->space.point + (last ? (e->space.axis.n - 1) * e->space.step : 0);
    corner c;
    for (int i = 0; i < 3; i++) c.at[i] = l->rank[k] == TOLD ? l->bounds->edges[k].point[last][i] * l->mm : p[i];
    c.key = kn_brep_hash(&turned, c.at, 3, 1, 1, 0);
    if (l->rank[k] == TOLD) c.key = mix_number(kn_brep_mix(c.key, 1.0), l->bounds->edges[k].vertex[last]);
    return c;
}

static void set_vertex(kn_trim_edge *e, const corner *c, int end)
{
    int at = (end == 1) != (e->against != e->turned); // in the direction of the key
    e->edge.vertex[at] = c->key;
    memcpy(e->at[at], c->at, sizeof c->at);
}

// What joins edge a's end to edge b's start, with points between them or not.
static void join_corners(const loading *l, kn_trim_edges *t, int a, int b, bool apart)
{
    corner end = corner_of(l, t, a, 1), start = corner_of(l, t, b, 0);
    bool told = l->rank[a] == TOLD || l->rank[b] == TOLD;
    if (!apart || told) {
        corner *better = l->rank[a] > l->rank[b] ? &end : &start;
        set_vertex(&t->edge[a], better, 1), set_vertex(&t->edge[b], better, 0);
        return;
    }
    set_vertex(&t->edge[a], &end, 1), set_vertex(&t->edge[b], &start, 0);
    if (kn_brep_same(end.key, start.key)) return;
    if (t->npairs < KN_BREP_PAIRS) t->pair[t->npairs][0] = end.key, t->pair[t->npairs][1] = start.key;
    t->npairs++;
}

// An edge that is told has its number in its key; one that does not end where its curve ends, its vertices.
static void finish_key(const loading *l, kn_trim_edge *e, int k)
{
    bool turned, told = l->rank[k] == TOLD, own = !told;
    for (int end = 0; end < 2 && own; end++) {
        const double *p = e->space.point + ((end == 1) != e->turned ? (e->space.axis.n - 1) * e->space.step : 0);
        own = kn_brep_same(e->edge.vertex[end], kn_brep_hash(&turned, p, 3, 1, 1, 0));
    }
    if (own) return;
    for (int end = 0; end < 2; end++)
        e->edge.key = mix_number(mix_number(e->edge.key, e->edge.vertex[end].a), e->edge.vertex[end].b);
    if (told) e->edge.key = mix_number(kn_brep_mix(e->edge.key, 1.0), l->bounds->edges[k].number);
}

// Keys of a loop's edges. False: it has none.
static bool set_keys(const loading *l, kn_trim_edges *t, int first, int last)
{
    int start = first;
    while (start < last && t->edge[start].collapsed) start++;
    if (start == last) return false;
    for (int k = first; k < last; k++) {
        kn_trim_edge *e = &t->edge[k];
        if (e->collapsed) continue;
        e->edge.key = kn_patch_curve_key(&e->turned, &e->space);
        e->edge.forward = (e->against == e->turned) != l->patch->reversed;
    }
    for (int k = start, next; k < last; k = next) {
        for (next = k + 1; next < last && t->edge[next].collapsed;) next++;
        int to = next < last ? next : start;
        bool apart = next < last ? next > k + 1 : k + 1 < last || start > first;
        join_corners(l, t, k, to, apart);
    }
    for (int k = first; k < last; k++)
        if (!t->edge[k].collapsed) finish_key(l, &t->edge[k], k);
    return true;
}

// ---- loops ----

// Twice the area inside the polylines of a loop: above 0 for outer ones.
static double area_of(const kn_trim_edges *t, const kn_trim_loop *loop)
{
    double sum = 0.0;
    for (int k = loop->first; k < loop->last; k++)
        for (int i = 0; i + 1 < t->edge[k].nline; i++) {
            const double *p = t->line[t->edge[k].line + i], *q = t->line[t->edge[k].line + i + 1];
            sum += p[0] * q[1] - p[1] * q[0];
        }
    return sum;
}

// Whether the ray from p upwards in the second variable meets loop's polylines an odd number of times.
static bool contains(const kn_trim_edges *t, const kn_trim_loop *loop, const double *p)
{
    bool inside = false;
    for (int k = loop->first; k < loop->last; k++)
        for (int i = 0; i + 1 < t->edge[k].nline; i++) {
            const double *a = t->line[t->edge[k].line + i], *b = t->line[t->edge[k].line + i + 1];
            if ((a[0] > p[0]) == (b[0] > p[0])) continue;
            if (a[1] + (p[0] - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) > p[1]) inside = !inside;
        }
    return inside;
}

// The smallest outer loop that a hole is in; the first outer one where rounding hides that; -1: there is none.
static int outer_of(const kn_trim_edges *t, const kn_trim_loop *loops, const double *area, int n, int hole)
{
    int found = -1;
    double least = INFINITY;
    const double *p = t->line[t->edge[loops[hole].first].line];
    for (int k = 0; k < n; k++) {
        if (!(area[k] > 0.0) || !(found < 0 || area[k] < least)) continue;
        bool in = contains(t, &loops[k], p);
        if (found >= 0 && !in) continue;
        found = k;
        if (in) least = area[k];
    }
    return found;
}

// Each outer loop, then the holes in it. A hole in nothing counts as an outer one.
static kn_status sort_loops(kn_ctx *ctx, kn_trim_edges *t, const kn_trim_loop *loops, int n)
{
    double *area = kn_scratch(ctx, (size_t)n + 1, sizeof *area);
    int *outer = kn_scratch(ctx, (size_t)n + 1, sizeof *outer);
    t->loop = kn_scratch(ctx, (size_t)n + 1, sizeof *t->loop);
    if (!area || !outer || !t->loop) return KN_ENOMEM;
    for (int i = 0; i < n; i++) area[i] = area_of(t, &loops[i]);
    for (int i = 0; i < n; i++) {
        outer[i] = area[i] > 0.0 ? i : outer_of(t, loops, area, n, i);
        if (outer[i] < 0) outer[i] = i;
    }
    for (int i = 0; i < n; i++) {
        if (outer[i] != i) continue;
        t->loop[t->nloops] = loops[i];
        t->loop[t->nloops++].outer = true;
        for (int k = 0; k < n; k++)
            if (k != i && outer[k] == i) t->loop[t->nloops++] = loops[k];
    }
    return KN_OK;
}

static kn_status load(loading *l, kn_trim_edges *out)
{
    kn_ctx *ctx = l->ctx;
    const kn_trim *trim = l->patch->trim;
    kn_trim_loop *loops = kn_scratch(ctx, (size_t)trim->nloops + 1, sizeof *loops);
    size_t points = 0;
    out->edge = kn_scratch(ctx, (size_t)trim->ncurves, sizeof *out->edge);
    out->pair = kn_scratch(ctx, KN_BREP_PAIRS, sizeof *out->pair);
    l->rank = kn_scratch(ctx, (size_t)trim->ncurves, sizeof *l->rank);
    if (!loops || !out->edge || !out->pair || !l->rank) return KN_ENOMEM;
    for (int k = 0; k < trim->ncurves; k++) {
        out->edge[k] = (kn_trim_edge){.line = (int)points, .nline = line_spans(&trim->curves[k]) + 1};
        points += (size_t)out->edge[k].nline;
    }
    out->line = kn_scratch(ctx, points, sizeof *out->line);
    kn_status status = out->line ? KN_OK : KN_ENOMEM;
    for (int k = 0; k < trim->ncurves && status == KN_OK; k++) status = load_edge(l, out, k);
    int n = 0;
    for (int i = 0, first = 0; i < trim->nloops && status == KN_OK; first = trim->loop_end[i++])
        if (set_keys(l, out, first, trim->loop_end[i]))
            loops[n++] = (kn_trim_loop){.first = first, .last = trim->loop_end[i]};
    return status == KN_OK ? sort_loops(ctx, out, loops, n) : status;
}

kn_status kn_trim_edges_load(kn_ctx *ctx, kn_trim_edges *out, const kn_patch *patch, const kn_patch_net *net,
                             double mm, const char *format)
{
    loading l = {.ctx = ctx, .patch = patch, .net = net, .bounds = patch->bounds, .mm = mm, .format = format};
    kn_spline view = kn_patch_spline(patch);
    *out = (kn_trim_edges){0};
    if (l.bounds && !meet(l.bounds, patch->trim)) l.bounds = NULL;
    kn_status status = kn_spline_scale(ctx, &l.surface, &view, mm);
    if (status == KN_OK) status = load(&l, out);
    kn_spline_clear(ctx, &l.surface);
    return status;
}
