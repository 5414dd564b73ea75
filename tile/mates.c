// SPDX-License-Identifier: Apache-2.0
// Which edges of a tile's pieces, and which ends of its curves, are one in the tiling.
#include "tile/net.h"

#include <math.h>

typedef struct search {
    kn_tile_net *net;
    const double (*points)[3]; // of sides the middle of the chord, of tips themselves
    double tolerance, best;    // how smoothly the best mate goes on
    int self;
    kn_tile_side *found;
} search;

// The mean of the derivative across a side, out of the piece.
static void across(double out[3], const kn_tile_net *net, int side)
{
    const kn_bezier *b = &net->pieces[side / 4].surface;
    int var = side % 4 / 2, n = b->degree[var], end = side % 2 ? n : 0, next = side % 2 ? n - 1 : 1;
    size_t count = kn_bezier_count(b), row = (size_t)b->degree[1] + 1;
    size_t step = var == 0 ? 1 : row, stride = var == 0 ? row : 1;
    out[0] = out[1] = out[2] = 0.0;
    for (size_t k = 0; n > 0 && k <= (size_t)b->degree[1 - var]; k++)
        for (size_t c = 0; c < 3; c++)
            out[c] += b->coef[c * count + (size_t)end * stride + k * step] -
                      b->coef[c * count + (size_t)next * stride + k * step];
}

static double cosine(const double a[3], const double b[3])
{
    double aa = 0.0, bb = 0.0, ab = 0.0;
    for (int c = 0; c < 3; c++) aa += a[c] * a[c], bb += b[c] * b[c], ab += a[c] * b[c];
    return aa > 0.0 && bb > 0.0 ? ab / sqrt(aa * bb) : 0.0;
}

// Of several mates the one that goes on most smoothly, the first among equals.
static void offer(search *s, int j, const int offset[2], bool reversed, double smooth)
{
    s->found->nmates++;
    if (s->found->mate >= 0 && smooth <= s->best) return;
    s->best = smooth;
    s->found->mate = j;
    s->found->offset[0] = offset[0], s->found->offset[1] = offset[1];
    s->found->reversed = reversed;
}

static kn_status meet_side(void *user, int j)
{
    search *s = user;
    int offset[2];
    if (j == s->self || s->net->sides[j].point) return KN_OK;
    if (!kn_tile_offset(offset, s->points[s->self], s->points[j])) return KN_OK;
    for (int reversed = 0; reversed < 2; reversed++)
        if (kn_tile_side_distance(s->net, s->self, j, offset, reversed == 1, NULL) <= s->tolerance) {
            double out[3], in[3];
            across(out, s->net, s->self);
            across(in, s->net, j);
            offer(s, j, offset, reversed == 1, -cosine(out, in));
            break;
        }
    return KN_OK;
}

static void tip_tangent(double out[3], const kn_tile_net *net, int tip)
{
    const kn_bezier *b = &net->curves[tip / 2].curve;
    size_t n = (size_t)b->degree[0] + 1, end = tip % 2 ? n - 1 : 0, next = n == 1 ? 0 : tip % 2 ? n - 2 : 1;
    for (size_t c = 0; c < 3; c++) out[c] = b->coef[c * n + end] - b->coef[c * n + next];
}

static kn_status meet_tip(void *user, int j)
{
    search *s = user;
    int offset[2];
    const double *a = s->points[s->self], *b = s->points[j];
    if (j == s->self || !kn_tile_offset(offset, a, b)) return KN_OK;
    double u = a[0] - b[0] - offset[0], v = a[1] - b[1] - offset[1], w = a[2] - b[2], out[3], in[3];
    if (!(sqrt(u * u + v * v + w * w) <= s->tolerance)) return KN_OK;
    tip_tangent(out, s->net, s->self);
    tip_tangent(in, s->net, j);
    offer(s, j, offset, false, -cosine(out, in));
    return KN_OK;
}

static kn_status join(kn_ctx *ctx, kn_tile_net *net, kn_tile_side *list, const double (*points)[3], int n,
                      double tolerance, bool tips)
{
    kn_tile_places places = {0};
    kn_status status = kn_tile_places_make(ctx, &places, points, n);
    for (int i = 0; i < n && status == KN_OK; i++) {
        if (i % 1024 == 0) status = kn_progress(ctx, "edges", (double)i / n);
        if (status != KN_OK || list[i].point) continue;
        search s = {net, points, tolerance, -INFINITY, i, &list[i]};
        status = kn_tile_places_near(ctx, &places, points[i], 2.0 * tolerance, tips ? meet_tip : meet_side, &s);
    }
    kn_tile_places_clear(ctx, &places);
    return status;
}

// The sides' middles, and which sides are points.
static void describe(double (*points)[3], kn_tile_net *net)
{
    double p[KN_TILE_SIDE_POINTS][3];
    for (int i = 0; i < 4 * net->npieces; i++) {
        int n = kn_tile_side_points(p, net, i);
        net->sides[i] = (kn_tile_side){.mate = -1, .point = true};
        for (int c = 0; c < 3; c++) {
            points[i][c] = 0.5 * p[0][c] + 0.5 * p[n - 1][c];
            for (int k = 1; k < n; k++)
                if (p[k][c] != p[0][c]) net->sides[i].point = false;
        }
    }
}

static void describe_tips(double (*points)[3], kn_tile_net *net)
{
    for (int i = 0; i < 2 * net->ncurves; i++) {
        const kn_bezier *b = &net->curves[i / 2].curve;
        size_t n = (size_t)b->degree[0] + 1;
        net->tips[i] = (kn_tile_side){.mate = -1};
        for (size_t c = 0; c < 3; c++) points[i][c] = b->coef[c * n + (i % 2 ? n - 1 : 0)];
    }
}

kn_status kn_tile_net_join(kn_ctx *ctx, kn_tile_net *net, double tolerance)
{
    int nsides = 4 * net->npieces, ntips = 2 * net->ncurves;
    double(*points)[3] = kn_alloc(ctx, (size_t)nsides + (size_t)ntips + 1, sizeof *points);
    net->sides = kn_alloc(ctx, (size_t)nsides + 1, sizeof *net->sides);
    net->tips = kn_alloc(ctx, (size_t)ntips + 1, sizeof *net->tips);
    kn_status status = points && net->sides && net->tips ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        describe(points, net);
        describe_tips(points + nsides, net);
        status = join(ctx, net, net->sides, (const double(*)[3])points, nsides, tolerance, false);
    }
    if (status == KN_OK)
        status = join(ctx, net, net->tips, (const double(*)[3])(points + nsides), ntips, tolerance, true);
    kn_free(ctx, points);
    return status;
}
