// SPDX-License-Identifier: Apache-2.0
// The Bezier pieces of a tile's surfaces, volumes, meshes and curves.
#include "tile/net.h"

#include "kernel/bernstein.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

enum { MOST_PIECES = 1 << 27 };

int kn_tile_side_points(double (*out)[3], const kn_tile_net *net, int side)
{
    const kn_bezier *b = &net->pieces[side / 4].surface;
    int var = side % 4 / 2, other = 1 - var, end = side % 2 ? b->degree[var] : 0, n = b->degree[other] + 1;
    size_t count = kn_bezier_count(b), row = (size_t)b->degree[1] + 1;
    size_t start = var == 0 ? (size_t)end * row : (size_t)end, step = var == 0 ? 1 : row;
    for (int k = 0; k < n; k++)
        for (size_t c = 0; c < 3; c++) out[k][c] = b->coef[c * count + start + (size_t)k * step];
    return n;
}

// Counterclockwise round the parameters run t = 0 and r = 1, with growing parameters.
static bool counterclockwise(const kn_tile_net *net, int side)
{
    bool plain = side % 4 == 1 || side % 4 == 2;
    return plain != net->pieces[side / 4].inwards;
}

bool kn_tile_side_agrees(const kn_tile_net *net, int side)
{
    const kn_tile_side *s = &net->sides[side];
    bool opposite = counterclockwise(net, side) != counterclockwise(net, s->mate);
    return opposite != s->reversed;
}

bool kn_tile_offset(int offset[2], const double a[3], const double b[3])
{
    for (int c = 0; c < 2; c++) {
        double cells = nearbyint(a[c] - b[c]);
        if (!(fabs(cells) <= KN_TILE_MAX_CELLS)) return false;
        offset[c] = (int)cells;
    }
    return true;
}

// The distance of curves is at most that of their control points in one degree. A difference of three numbers rounds
// twice, elevation gamma(n + 3) at most, the norm five times.
double kn_tile_side_distance(const kn_tile_net *net, int a, int b, const int offset[2], bool reversed, double *at)
{
    double p[KN_TILE_SIDE_POINTS][3], q[KN_TILE_SIDE_POINTS][3], raised[KN_TILE_SIDE_POINTS][3];
    int n = kn_tile_side_points(p, net, a), m = kn_tile_side_points(q, net, b), most = n > m ? n : m, where = 0;
    double size = 0.0, worst = 0.0;
    if (n < most) {
        kn_bernstein_elevate(raised[0], p[0], 1, n - 1, most - 1, 3);
        memcpy(p, raised, (size_t)most * sizeof *p);
    }
    if (m < most) {
        kn_bernstein_elevate(raised[0], q[0], 1, m - 1, most - 1, 3);
        memcpy(q, raised, (size_t)most * sizeof *q);
    }
    for (int k = 0; k < most; k++) {
        const double *x = p[k], *y = q[reversed ? most - 1 - k : k];
        double d[3] = {x[0] - y[0] - offset[0], x[1] - y[1] - offset[1], x[2] - y[2]};
        double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (int c = 0; c < 3; c++) size = fmax(size, fmax(fabs(x[c]), fabs(y[c])));
        if (!(length <= worst)) worst = length, where = k;
    }
    if (at) *at = (double)where / (most > 1 ? most - 1 : 1);
    double roundings = n == m ? 4.0 : 2.0 * most + 12.0;
    return worst == 0.0 && n == m ? 0.0 : worst * (1.0 + 4.0 * DBL_EPSILON) + roundings * DBL_EPSILON * size;
}

bool kn_tile_in_line(const double (*points)[3], int n, int c, double tolerance)
{
    double line = nearbyint(points[0][c]);
    for (int k = 0; k < n; k++)
        if (!(fabs(points[k][c] - line) <= tolerance)) return false;
    return true;
}

// Room for one more in an array of n elements.
static kn_status grow(kn_ctx *ctx, void **array, int *room, int n, size_t size)
{
    if (n < *room) return KN_OK;
    if (n >= MOST_PIECES) return kn_fail(ctx, KN_ELIMIT, "tile: more than %d pieces", MOST_PIECES);
    int more = *room ? 2 * *room : 16;
    void *block = *array ? kn_resize(ctx, *array, (size_t)more, size) : kn_alloc(ctx, (size_t)more, size);
    if (!block) return KN_ENOMEM;
    *array = block;
    *room = more;
    return KN_OK;
}

kn_status kn_tile_net_add(kn_ctx *ctx, kn_tile_net *net, kn_tile_piece *piece)
{
    void *array = net->pieces;
    kn_status status = grow(ctx, &array, &net->piece_room, net->npieces, sizeof *net->pieces);
    net->pieces = array;
    if (status != KN_OK) return status;
    net->pieces[net->npieces++] = *piece;
    piece->surface = (kn_bezier){0};
    return KN_OK;
}

static kn_status add_curve(kn_ctx *ctx, kn_tile_net *net, kn_tile_edge place, kn_bezier *curve)
{
    void *array = net->curves;
    kn_status status = grow(ctx, &array, &net->curve_room, net->ncurves, sizeof *net->curves);
    net->curves = array;
    if (status != KN_OK) return status;
    net->curves[net->ncurves++] = (kn_tile_curve){.place = place, .curve = *curve};
    *curve = (kn_bezier){0};
    return KN_OK;
}

static kn_status add_spline(kn_ctx *ctx, kn_tile_net *net, kn_tile_net *volumes, int part, int index,
                            const kn_spline *s)
{
    kn_bezier *list = NULL;
    size_t n = 0;
    if (s->ncomp != 3 || s->rational || s->nvars < 1 || s->nvars > 3)
        return kn_fail(ctx, KN_EDOMAIN, "tile: spline %d of part %d is no polynomial (u,v,w) one", index, part);
    kn_status status = kn_spline_to_bezier(ctx, &list, &n, s);
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        kn_tile_piece piece = {{part, index, (int)i, -1, -1}, list[i], false};
        if (s->nvars == 1)
            status = add_curve(ctx, net, piece.place, &list[i]);
        else {
            status = kn_tile_net_add(ctx, s->nvars == 2 ? net : volumes, &piece);
            list[i] = piece.surface;
        }
    }
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &list[i]);
    kn_free(ctx, list);
    return status;
}

// Corner 0 at r = 0, the edge from corner 1 to corner 2 at r = 1.
static kn_status add_mesh(kn_ctx *ctx, kn_tile_net *net, int part, const kn_mesh *mesh)
{
    static const int degree[2] = {1, 1}, corner[4] = {0, 0, 1, 2};
    kn_status status = KN_OK;
    for (size_t i = 0; i < mesh->ntriangles && status == KN_OK; i++) {
        kn_tile_piece piece = {.place = {part, -1, (int)i, -1, -1}};
        if (i >= MOST_PIECES) return kn_fail(ctx, KN_ELIMIT, "tile: more than %d triangles", MOST_PIECES);
        status = kn_bezier_init(ctx, &piece.surface, 2, 3, false, degree);
        for (size_t k = 0; k < 4 && status == KN_OK; k++)
            for (size_t c = 0; c < 3; c++)
                piece.surface.coef[4 * c + k] = mesh->position[3 * mesh->triangle[3 * i + (size_t)corner[k]] + c];
        if (status == KN_OK) status = kn_tile_net_add(ctx, net, &piece);
        kn_bezier_clear(ctx, &piece.surface);
    }
    return status;
}

static bool all_finite(const kn_tile_net *net)
{
    for (int i = 0; i < net->npieces + net->ncurves; i++) {
        const kn_bezier *b = i < net->npieces ? &net->pieces[i].surface : &net->curves[i - net->npieces].curve;
        size_t n = 3 * kn_bezier_count(b);
        for (size_t k = 0; k < n; k++)
            if (!isfinite(b->coef[k])) return false;
    }
    return true;
}

static kn_status collect(kn_ctx *ctx, kn_tile_net *net, kn_tile_net *volumes, const kn_tile *tile)
{
    kn_status status = KN_OK;
    for (int p = 0; p < tile->nparts && status == KN_OK; p++) {
        const kn_tile_part *part = &tile->parts[p];
        for (int s = 0; s < part->nsplines && status == KN_OK; s++) {
            if (part->trims && part->trims[s].nloops > 0)
                net->unchecked++;
            else
                status = add_spline(ctx, net, volumes, p, s, &part->splines[s]);
        }
        if (status == KN_OK) status = add_mesh(ctx, net, p, &part->mesh);
    }
    return status;
}

kn_status kn_tile_net_make(kn_ctx *ctx, kn_tile_net *out, const kn_tile *tile, double tolerance)
{
    kn_tile_net net = {0}, volumes = {0};
    kn_status status = collect(ctx, &net, &volumes, tile);
    if (status == KN_OK && !(all_finite(&net) && all_finite(&volumes)))
        status = kn_fail(ctx, KN_EDOMAIN, "tile: a coordinate is not finite");
    if (status == KN_OK && net.npieces + net.ncurves + volumes.npieces == 0 && net.unchecked == 0)
        status = kn_fail(ctx, KN_EDOMAIN, "tile: it is empty");
    if (status == KN_OK && volumes.npieces > 0)
        status = kn_tile_net_faces(ctx, &net, volumes.pieces, volumes.npieces, tolerance);
    if (status == KN_OK) status = kn_tile_net_join(ctx, &net, tolerance);
    kn_tile_net_clear(ctx, &volumes);
    if (status == KN_OK)
        *out = net;
    else
        kn_tile_net_clear(ctx, &net);
    return status;
}

void kn_tile_net_clear(kn_ctx *ctx, kn_tile_net *net)
{
    for (int i = 0; i < net->npieces; i++) kn_bezier_clear(ctx, &net->pieces[i].surface);
    for (int i = 0; i < net->ncurves; i++) kn_bezier_clear(ctx, &net->curves[i].curve);
    kn_free(ctx, net->pieces);
    kn_free(ctx, net->curves);
    kn_free(ctx, net->sides);
    kn_free(ctx, net->tips);
    *net = (kn_tile_net){0};
}
