// SPDX-License-Identifier: Apache-2.0
// What the base stops of the rays towards a camera: discs of it, drawn into a depth buffer.
//
// S is cut into a grid of pieces, a few pixels each. A disc is a square of them; its border is known from the
// control points of arcs, in whose hull each arc is, in space and (all being before the camera) in the picture: it
// is as far from its chord as they are. Squares of 2, 4 .. 32 pieces, each half over the next one, leave no gap
// between themselves; over an edge that two surfaces share a disc consists of half a square on each side.
//
// A covering tile takes the base's place, everywhere within W = max |w| of the point of S under it. Over a disc it
// is a disc too, whose border is within W of the other's: what is known of arcs and depths grows by that.
#include "job/depth.h"
#include "kernel/parallel.h"

#include <math.h>

enum {
    PIECE_PIXELS = 8,  // wanted side of a piece
    LEAST_PIECES = 8,  // along a surface
    MOST_PIECES = 128, // the same, where its own pieces are not more
    MOST_SIDE = 32,    // pieces along a disc
    MOST_IN_ALL = 1 << 17,
    MOST_ARCS = 4 * MOST_SIDE,
};
static const double roundings = 8192.0 * 0x1p-53; // as job/bounds.c
static const double meets = 1e-3;                 // pixels: points that are taken for one

// Of one surface: (n0 + 1)(n1 + 1) vertices, and n0 n1 pieces between them, the last variable fastest.
typedef struct grid {
    int n[2];
    bool closed[2];
    double *at;     // of vertices, 2 pixels each; NAN: not known
    double *off[2]; // of arcs along u, n0 (n1 + 1), and along v, (n0 + 1) n1
    double *far;    // of pieces; INFINITY: they cannot be drawn
} grid;

static void grid_clear(kn_ctx *ctx, grid *g)
{
    kn_free(ctx, g->at);
    kn_free(ctx, g->far);
    for (int d = 0; d < 2; d++) kn_free(ctx, g->off[d]);
    *g = (grid){0};
}

static size_t vertex(const grid *g, int i, int j)
{
    return (size_t)i * (size_t)(g->n[1] + 1) + (size_t)j;
}

static size_t arc(const grid *g, int var, int i, int j)
{
    return (size_t)i * (size_t)(var == 0 ? g->n[1] + 1 : g->n[1]) + (size_t)j;
}

static kn_status grid_init(kn_ctx *ctx, grid *g)
{
    size_t n0 = (size_t)g->n[0], n1 = (size_t)g->n[1], nat = 2 * (n0 + 1) * (n1 + 1);
    g->at = kn_alloc(ctx, nat, sizeof *g->at);
    g->off[0] = kn_alloc_zero(ctx, n0 * (n1 + 1), sizeof *g->off[0]);
    g->off[1] = kn_alloc_zero(ctx, (n0 + 1) * n1, sizeof *g->off[1]);
    g->far = kn_alloc(ctx, n0 * n1, sizeof *g->far);
    if (!g->at || !g->off[0] || !g->off[1] || !g->far) return KN_ENOMEM;
    for (size_t i = 0; i < nat; i++) g->at[i] = NAN;
    for (size_t i = 0; i < n0 * n1; i++) g->far[i] = INFINITY;
    return KN_OK;
}

// ---- pieces ----

typedef struct drawing {
    kn_job_depth *depth;
    const kn_job_bounds *bounds;
    double thick; // W
} drawing;

static double distance(const double *p, const double *a, const double *b)
{
    const double d[2] = {b[0] - a[0], b[1] - a[1]}, q[2] = {p[0] - a[0], p[1] - a[1]},
                 length = d[0] * d[0] + d[1] * d[1];
    double t = length > 0.0 ? fmin(fmax((q[0] * d[0] + q[1] * d[1]) / length, 0.0), 1.0) : 0.0;
    return hypot(q[0] - t * d[0], q[1] - t * d[1]);
}

// How far the arc on the side `end` of variable 1 - var is off its chord; its ends.
static double arc_off(const kn_job_dot *dots, const int degree[2], int var, int end, const double **a,
                      const double **b)
{
    size_t row = (size_t)degree[1] + 1, step = var == 0 ? row : 1, n = (size_t)degree[var];
    const kn_job_dot *first = dots + (end == 0 ? 0 : var == 0 ? row - 1 : (size_t)degree[0] * row);
    double most = 0.0;
    *a = first->at, *b = first[n * step].at;
    for (size_t k = 0; k <= n; k++) {
        const kn_job_dot *p = first + k * step;
        most = fmax(most, distance(p->at, *a, *b) + hypot(p->off[0], p->off[1]));
    }
    return most;
}

// Control points in the picture; false: not all of them are before the camera.
static bool take_dots(kn_job_dot *dots, double *far, const drawing *d, const kn_bezier *piece, double size)
{
    size_t n = kn_bezier_count(piece);
    const double *x = piece->coef, *w = piece->rational ? x + 3 * n : NULL;
    double least = 1.0, most = 1.0;
    for (size_t k = 0; w && k < n; k++) {
        least = k == 0 ? w[k] : fmin(least, w[k]), most = k == 0 ? w[k] : fmax(most, w[k]);
        if (!(w[k] > 0.0)) return false;
    }
    double radius = d->thick + roundings * size * (most / least);
    *far = -INFINITY;
    for (size_t k = 0; k < n; k++) {
        double weight = w ? w[k] : 1.0, p[3] = {x[k] / weight, x[n + k] / weight, x[2 * n + k] / weight};
        if (!kn_job_depth_point(&dots[k], d->depth, p, radius)) return false;
        *far = fmax(*far, dots[k].far);
    }
    return true;
}

// Piece (i,j) of the grid.
static kn_status take_piece(kn_ctx *ctx, grid *g, const drawing *d, const kn_bezier *piece, double size, int i, int j)
{
    size_t n = kn_bezier_count(piece);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_job_dot *dots = kn_scratch(ctx, n, sizeof *dots);
    double far;
    kn_status status = dots ? KN_OK : KN_ENOMEM;
    if (status == KN_OK && take_dots(dots, &far, d, piece, size)) {
        g->far[(size_t)i * (size_t)g->n[1] + (size_t)j] = far;
        for (int var = 0; var < 2; var++)
            for (int end = 0; end < 2; end++) {
                const double *a, *b;
                double off = arc_off(dots, piece->degree, var, end, &a, &b);
                int from[2] = {i + (var == 1 ? end : 0), j + (var == 0 ? end : 0)};
                double *most = &g->off[var][arc(g, var, from[0], from[1])];
                *most = fmax(*most, off);
                double *p = g->at + 2 * vertex(g, from[0], from[1]);
                double *q = g->at + 2 * vertex(g, from[0] + (var == 0), from[1] + (var == 1));
                for (int k = 0; k < 2; k++) p[k] = a[k], q[k] = b[k];
            }
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// Whether the lines at both ends of variable d are one in the picture.
static bool meets_itself(const grid *g, int d)
{
    for (int k = 0; k <= g->n[1 - d]; k++) {
        const double *a = g->at + 2 * (d == 0 ? vertex(g, 0, k) : vertex(g, k, 0));
        const double *b = g->at + 2 * (d == 0 ? vertex(g, g->n[0], k) : vertex(g, k, g->n[1]));
        if (!(hypot(a[0] - b[0], a[1] - b[1]) <= meets)) return false;
    }
    return true;
}

// As many pieces along a surface as its control points spread over the picture.
static int wanted_pieces(const drawing *d, const kn_job_bounds_surface *s)
{
    double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < s->s.n; i++) {
        const kn_bezier *b = &s->s.list[i];
        size_t n = kn_bezier_count(b);
        for (size_t k = 0; k < n; k++) {
            double w = b->rational ? b->coef[3 * n + k] : 1.0, p[3];
            kn_job_dot dot;
            for (size_t c = 0; c < 3; c++) p[c] = b->coef[c * n + k] / w;
            if (!kn_job_depth_point(&dot, d->depth, p, 0.0)) return MOST_PIECES;
            for (int v = 0; v < 2; v++) least[v] = fmin(least[v], dot.at[v]), most[v] = fmax(most[v], dot.at[v]);
        }
    }
    double side = fmax(most[0] - least[0], most[1] - least[1]) / PIECE_PIXELS;
    return (int)fmin(fmax(side, LEAST_PIECES), MOST_PIECES);
}

static kn_status fill(kn_ctx *ctx, grid *g, const drawing *d, const kn_job_bounds_surface *s, const int parts[2])
{
    kn_bezier one = {0};
    kn_status status = KN_OK;
    int spans = s->s.nbreaks[1] - 1;
    for (int i = 0; status == KN_OK && i < g->n[0]; i++)
        for (int j = 0; status == KN_OK && j < g->n[1]; j++) {
            const int at[2] = {i % parts[0], j % parts[1]};
            double lo[2], hi[2];
            for (int v = 0; v < 2; v++) lo[v] = (double)at[v] / parts[v], hi[v] = (double)(at[v] + 1) / parts[v];
            size_t piece = (size_t)(i / parts[0]) * (size_t)spans + (size_t)(j / parts[1]);
            status = kn_bezier_restrict(ctx, &one, &s->s.list[piece], lo, hi);
            if (status == KN_OK) status = take_piece(ctx, g, d, &one, s->size, i, j);
        }
    kn_bezier_clear(ctx, &one);
    return status;
}

static kn_status make_grid(kn_ctx *ctx, grid *g, const drawing *d, int surface, int pieces)
{
    const kn_job_bounds_surface *s = &d->bounds->surfaces[surface];
    int parts[2];
    for (int v = 0; v < 2; v++) {
        int spans = s->s.nbreaks[v] - 1;
        parts[v] = (pieces + spans - 1) / spans;
        g->n[v] = spans * parts[v];
    }
    kn_status status = grid_init(ctx, g);
    if (status == KN_OK) status = fill(ctx, g, d, s, parts);
    for (int v = 0; status == KN_OK && v < 2; v++)
        g->closed[v] = d->bounds->job->surfaces[surface].closed[v] && meets_itself(g, v);
    return status;
}

// ---- discs ----

typedef struct border {
    kn_job_arc arcs[MOST_ARCS];
    int n;
} border;

static const double *place(const grid *g, const int v[2])
{
    int at[2];
    for (int d = 0; d < 2; d++) at[d] = g->closed[d] ? v[d] % g->n[d] : v[d];
    return g->at + 2 * vertex(g, at[0], at[1]);
}

// Arcs from vertex v on, n of them, in variable var, up or down (step 1, -1); v moves along.
static void walk(border *b, const grid *g, int v[2], int var, int step, int n)
{
    for (int k = 0; k < n; k++) {
        kn_job_arc *to = &b->arcs[b->n++];
        int low[2] = {v[0], v[1]};
        const double *p = place(g, v);
        v[var] += step;
        low[var] -= step < 0;
        for (int d = 0; d < 2; d++) low[d] = g->closed[d] ? low[d] % g->n[d] : low[d];
        const double *q = place(g, v);
        *to = (kn_job_arc){{p[0], p[1]}, {q[0], q[1]}, g->off[var][arc(g, var, low[0], low[1])]};
    }
}

static double farthest(const grid *g, const int first[2], const int size[2])
{
    double most = -INFINITY;
    for (int i = first[0]; i < first[0] + size[0]; i++)
        for (int j = first[1]; j < first[1] + size[1]; j++)
            most = fmax(most, g->far[(size_t)(i % g->n[0]) * (size_t)g->n[1] + (size_t)(j % g->n[1])]);
    return most;
}

// Squares of half the side, each half over the next one, leave no point nearer than a quarter of their side to all
// their borders: where that is more than twice what borders cost, they have drawn all that this one could.
static bool is_needed(const border *b, int side)
{
    double least = INFINITY, most = 0.0;
    for (int i = 0; i < b->n; i++) {
        const kn_job_arc *a = &b->arcs[i];
        least = fmin(least, hypot(a->to[0] - a->from[0], a->to[1] - a->from[1]));
        most = fmax(most, a->off);
    }
    return side == 2 || side * least / 8.0 < 2.0 * (most + 0.75);
}

static void draw_square(const drawing *d, const grid *g, int i, int j, int side)
{
    border b;
    int at[2] = {i, j};
    const int size[2] = {side, side};
    double far = farthest(g, at, size);
    if (isinf(far)) return;
    b.n = 0;
    walk(&b, g, at, 0, 1, side);
    walk(&b, g, at, 1, 1, side);
    walk(&b, g, at, 0, -1, side);
    walk(&b, g, at, 1, -1, side);
    if (is_needed(&b, side)) kn_job_depth_disc(d->depth, b.arcs, b.n, far);
}

// Where squares begin: half of one from each to the next, and up to the end.
static int next_start(const grid *g, int d, int at, int side)
{
    int last = g->closed[d] ? g->n[d] - 1 : g->n[d] - side;
    return at < last && at + side / 2 > last && !g->closed[d] ? last : at + side / 2;
}

static void draw_squares(const drawing *d, const grid *g, int side)
{
    if (side >= g->n[0] + !g->closed[0] || side >= g->n[1] + !g->closed[1]) return;
    int last[2];
    for (int v = 0; v < 2; v++) last[v] = g->closed[v] ? g->n[v] - 1 : g->n[v] - side;
    for (int i = 0; i <= last[0]; i = next_start(g, 0, i, side))
        for (int j = 0; j <= last[1]; j = next_start(g, 1, j, side)) draw_square(d, g, i, j, side);
}

// Half a square at an edge (0 .. 3): around its vertices from `from` on to `to`, which lie on it, by three sides.
// Answers how far it is.
static double half_square(border *b, const grid *g, int edge, int from, int to, int deep)
{
    int across = edge / 2, along = 1 - across, at[2], first[2], size[2], step = to > from ? 1 : -1;
    at[across] = edge % 2 == 0 ? 0 : g->n[across];
    at[along] = from;
    int in = edge % 2 == 0 ? 1 : -1, length = (to - from) * step;
    first[across] = edge % 2 == 0 ? 0 : g->n[across] - deep, size[across] = deep;
    first[along] = step > 0 ? from : to, size[along] = length;
    walk(b, g, at, across, in, deep);
    walk(b, g, at, along, step, length);
    walk(b, g, at, across, -in, deep);
    return farthest(g, first, size);
}

static bool is_near(const double a[2], const double b[2])
{
    return hypot(a[0] - b[0], a[1] - b[1]) <= meets;
}

// Discs over an edge that two surfaces share, from both grids.
static void draw_seam(const drawing *d, const grid *g, const grid *h, int edge, const kn_job_partner *p, int side)
{
    int other = p->edge % 4, n = g->n[1 - edge / 2], deep = side / 2;
    if (n != h->n[1 - other / 2] || side > n || deep > g->n[edge / 2] || deep > h->n[other / 2]) return;
    for (int k = 0; k + side <= n; k += deep) {
        border b = {.n = 0};
        int end = k + side;
        double far = half_square(&b, g, edge, k, end, deep);
        int middle = b.n;
        far = fmax(far, half_square(&b, h, other, p->reversed ? n - end : end, p->reversed ? n - k : k, deep));
        if (isinf(far)) continue;
        if (!is_near(b.arcs[middle - 1].to, b.arcs[middle].from) || !is_near(b.arcs[b.n - 1].to, b.arcs[0].from))
            continue;
        if (is_needed(&b, side)) kn_job_depth_disc(d->depth, b.arcs, b.n, far);
    }
}

static void draw_seams(const drawing *d, const grid *grids, int surface, int side)
{
    const kn_job *job = d->bounds->job;
    for (int e = 0; e < 4; e++) {
        const kn_job_partner *p = &job->surfaces[surface].partner[e];
        if (p->edge <= 4 * surface + e || !p->single) continue;
        if (job->tile.covering && (!p->goes_on || kn_job_turns_over(4 * surface + e, p))) continue;
        draw_seam(d, &grids[surface], &grids[p->edge / 4], e, p, side);
    }
}

static kn_status draw(kn_ctx *ctx, const drawing *d)
{
    const kn_job *job = d->bounds->job;
    grid *grids = kn_alloc_zero(ctx, (size_t)job->nsurfaces, sizeof *grids);
    int pieces = LEAST_PIECES;
    kn_status status = grids ? KN_OK : KN_ENOMEM;
    for (int s = 0; s < job->nsurfaces; s++) { // one number, so that pieces meet at shared edges
        int wanted = wanted_pieces(d, &d->bounds->surfaces[s]);
        pieces = wanted > pieces ? wanted : pieces;
    }
    int most = (int)fmax(LEAST_PIECES, sqrt(MOST_IN_ALL / job->nsurfaces));
    if (pieces > most) pieces = most;
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) {
        status = kn_progress(ctx, "occlude", (double)s / job->nsurfaces);
        if (status == KN_OK) status = make_grid(ctx, &grids[s], d, s, pieces);
    }
    for (int side = 2; status == KN_OK && side <= MOST_SIDE; side *= 2)
        for (int s = 0; s < job->nsurfaces; s++) {
            draw_squares(d, &grids[s], side);
            draw_seams(d, grids, s, side);
        }
    for (int s = 0; grids && s < job->nsurfaces; s++) grid_clear(ctx, &grids[s]);
    kn_free(ctx, grids);
    return status;
}

// ---- how thick a covering tile is ----

enum { BLOCK = 4096 }; // cells of one task
typedef struct heights {
    const kn_job *job;
    double *most; // of each block
} heights;

static kn_status find_tallest(kn_ctx *ctx, void *user, size_t block)
{
    const heights *h = user;
    kn_job_extents extents = {0};
    size_t first = block * BLOCK, end = first + BLOCK < h->job->ncells ? first + BLOCK : h->job->ncells;
    kn_status status = KN_OK;
    for (size_t i = first; status == KN_OK && i < end; i++) {
        int surface, cell[2];
        kn_job_locate(h->job, i, &surface, cell);
        status = kn_job_cell_extents(ctx, &extents, h->job, surface, cell);
        for (int k = 0; status == KN_OK && k < extents.count; k++)
            for (int e = 0; e < 2; e++) h->most[block] = fmax(h->most[block], fabs(extents.list[k].w[e]));
    }
    kn_job_extents_clear(ctx, &extents);
    return status;
}

// What a normal, or its stand-in, is longer than 1 counts, and by how much pieces at knot lines and at ends are off,
// and meshes.
static kn_status find_thickness(kn_ctx *ctx, double *out, const kn_job *job)
{
    size_t blocks = (job->ncells + BLOCK - 1) / BLOCK;
    heights h = {.job = job, .most = kn_alloc_zero(ctx, blocks, sizeof *h.most)};
    kn_status status = h.most ? kn_parallel(ctx, blocks, find_tallest, &h, "occlude") : KN_ENOMEM;
    *out = 0.0;
    for (size_t b = 0; status == KN_OK && b < blocks; b++) *out = fmax(*out, h.most[b]);
    *out *= 1.0 + 4.0 * job->options.normal_tol;
    const kn_job_border *ends = job->options.placement.border;
    if (job->options.crossing != KN_CROSSING_REFUSE || ends[0] == KN_BORDER_CLIP || ends[1] == KN_BORDER_CLIP)
        *out += job->options.crossing_tol > 0.0 ? job->options.crossing_tol : INFINITY;
    bool meshes = false;
    for (int p = 0; p < job->tile.nparts; p++) meshes = meshes || job->tile.parts[p].mesh.nvertices > 0;
    if (meshes) *out += job->options.mesh_tol;
    kn_free(ctx, h.most);
    return status;
}

kn_status kn_job_occlude(kn_ctx *ctx, kn_job_depth *out, const kn_job_bounds *bounds, const kn_job_camera *camera)
{
    kn_job_depth depth = {0};
    drawing d = {.depth = &depth, .bounds = bounds};
    kn_status status = kn_job_depth_init(ctx, &depth, camera);
    if (status == KN_OK && bounds->job->tile.covering) status = find_thickness(ctx, &d.thick, bounds->job);
    if (status == KN_OK) status = draw(ctx, &d);
    if (status == KN_OK) {
        kn_job_depth_finish(&depth);
        *out = depth;
    } else {
        kn_job_depth_clear(ctx, &depth);
    }
    return status;
}
