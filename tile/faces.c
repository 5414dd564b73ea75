// SPDX-License-Identifier: Apache-2.0
// The faces of a tile's volumes: which two are one, and which bound the whole.
#include "tile/net.h"

#include <math.h>

typedef struct faces {
    kn_ctx *ctx;
    kn_tile_piece *list;
    double (*middle)[3];
    bool *joined;
    int n, self, mate, offset[2];
    double tolerance;
} faces;

// Of variables 0, 1, 2 those that are not var, in order, run round the end 1 of var counterclockwise seen from
// outside but for var = 1.
static kn_status make_face(kn_ctx *ctx, kn_tile_piece *out, const kn_tile_piece *volume, int var, int end)
{
    const kn_bezier *v = &volume->surface;
    int a = var == 0 ? 1 : 0, b = var == 2 ? 1 : 2, degree[2] = {v->degree[a], v->degree[b]};
    size_t step[3] = {(size_t)(v->degree[1] + 1) * (size_t)(v->degree[2] + 1), (size_t)v->degree[2] + 1, 1};
    size_t all = kn_bezier_count(v), start = end ? (size_t)v->degree[var] * step[var] : 0, at = 0;
    kn_bezier face = {0};
    kn_status status = kn_bezier_init(ctx, &face, 2, 3, false, degree);
    if (status != KN_OK) return status;
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i <= (size_t)degree[0]; i++)
            for (size_t j = 0; j <= (size_t)degree[1]; j++)
                face.coef[at++] = v->coef[c * all + start + i * step[a] + j * step[b]];
    *out = (kn_tile_piece){volume->place, face, (var == 1) == (end == 1)};
    out->place.face = 2 * var + end;
    return KN_OK;
}

static void corner(double out[3], const kn_bezier *b, int i, int j)
{
    size_t n = kn_bezier_count(b), row = (size_t)b->degree[1] + 1;
    size_t at = (i ? (size_t)b->degree[0] * row : 0) + (j ? row - 1 : 0);
    for (size_t c = 0; c < 3; c++) out[c] = b->coef[c * n + at];
}

// The largest distance of coefficients of a and b moved by offset, which have the same degrees; rounding included.
static double net_distance(const kn_bezier *a, const kn_bezier *b, const int offset[2])
{
    size_t n = kn_bezier_count(a);
    double worst = 0.0, size = 0.0;
    for (size_t k = 0; k < n; k++) {
        double sum = 0.0;
        for (size_t c = 0; c < 3; c++) {
            double x = a->coef[c * n + k], y = b->coef[c * n + k], d = x - y - (c < 2 ? offset[c] : 0.0);
            sum += d * d;
            size = fmax(size, fmax(fabs(x), fabs(y)));
        }
        worst = fmax(worst, sqrt(sum));
    }
    return worst == 0.0 ? 0.0 : worst + 0x1p-45 * size;
}

// b run as a is, by turn: bit 0 exchanges its variables, bits 1 and 2 reverse them; and both in one degree.
static kn_status turned_distance(kn_ctx *ctx, double *out, const kn_bezier *a, const kn_bezier *b, int turn,
                                 const int offset[2])
{
    static const int exchange[2] = {1, 0};
    kn_bezier x = {0}, y = {0};
    int degree[2];
    kn_status status = kn_bezier_copy(ctx, &y, b);
    if (status == KN_OK && turn & 1) status = kn_bezier_permute(ctx, &y, &y, exchange);
    for (int d = 0; d < 2 && status == KN_OK; d++)
        if (turn >> (d + 1) & 1) status = kn_bezier_reverse(ctx, &y, &y, d);
    for (int d = 0; d < 2; d++) degree[d] = a->degree[d] > y.degree[d] ? a->degree[d] : y.degree[d];
    if (status == KN_OK) status = kn_bezier_elevate(ctx, &x, a, degree);
    if (status == KN_OK) status = kn_bezier_elevate(ctx, &y, &y, degree);
    if (status == KN_OK) *out = net_distance(&x, &y, offset);
    kn_bezier_clear(ctx, &x);
    kn_bezier_clear(ctx, &y);
    return status;
}

// Whether the corners fit: corner (i, j) of a is the one of b that turn takes there.
static bool corners_fit(const faces *f, int j, int turn, const int offset[2])
{
    for (int k = 0; k < 4; k++) {
        int at[2] = {k >> 1, k & 1}, to[2];
        double p[3], q[3];
        for (int d = 0; d < 2; d++) {
            int from = turn & 1 ? 1 - d : d; // variable d of the turned b is this one of b
            to[from] = turn >> (d + 1) & 1 ? 1 - at[d] : at[d];
        }
        corner(p, &f->list[f->self].surface, at[0], at[1]);
        corner(q, &f->list[j].surface, to[0], to[1]);
        for (int c = 0; c < 3; c++)
            if (!(fabs(p[c] - q[c] - (c < 2 ? offset[c] : 0.0)) <= 2.0 * f->tolerance)) return false;
    }
    return true;
}

static kn_status meet_face(void *user, int j)
{
    faces *f = user;
    int offset[2];
    if (j <= f->self || f->mate >= 0 || f->joined[j]) return KN_OK;
    if (!kn_tile_offset(offset, f->middle[f->self], f->middle[j])) return KN_OK;
    kn_status status = KN_OK;
    for (int turn = 0; turn < 8 && status == KN_OK && f->mate < 0; turn++) {
        double distance = INFINITY;
        if (!corners_fit(f, j, turn, offset)) continue;
        status = turned_distance(f->ctx, &distance, &f->list[f->self].surface, &f->list[j].surface, turn, offset);
        if (status == KN_OK && distance <= f->tolerance) {
            f->mate = j;
            f->offset[0] = offset[0], f->offset[1] = offset[1];
        }
    }
    return status;
}

static kn_status join_faces(kn_tile_net *net, faces *f)
{
    kn_tile_places places = {0};
    kn_status status = kn_tile_places_make(f->ctx, &places, (const double(*)[3])f->middle, f->n);
    for (int i = 0; i < f->n && status == KN_OK; i++) {
        if (f->joined[i]) continue;
        f->self = i, f->mate = -1;
        status = kn_tile_places_near(f->ctx, &places, f->middle[i], 4.0 * f->tolerance, meet_face, f);
        if (f->mate < 0) continue;
        f->joined[i] = f->joined[f->mate] = true;
        for (int d = 0; d < 2; d++) net->nfaces[d] += f->offset[d] != 0;
        net->nfaces[2] += f->offset[0] == 0 && f->offset[1] == 0;
    }
    kn_tile_places_clear(f->ctx, &places);
    return status;
}

// What bounds the whole; where it lies in a line between cells the tile was cut there.
static kn_status keep_faces(kn_tile_net *net, faces *f)
{
    kn_status status = KN_OK;
    for (int i = 0; i < f->n && status == KN_OK; i++) {
        if (f->joined[i]) continue;
        for (int c = 0; c < 2; c++) {
            const kn_bezier *b = &f->list[i].surface;
            size_t n = kn_bezier_count(b);
            double line = nearbyint(b->coef[(size_t)c * n]);
            bool cut = true;
            for (size_t k = 0; k < n; k++) cut = cut && fabs(b->coef[(size_t)c * n + k] - line) <= f->tolerance;
            if (cut && net->ntorn[c]++ == 0) net->torn[c] = f->list[i].place;
        }
        status = kn_tile_net_add(f->ctx, net, &f->list[i]);
    }
    return status;
}

kn_status kn_tile_net_faces(kn_ctx *ctx, kn_tile_net *net, const kn_tile_piece *volumes, int n, double tolerance)
{
    size_t room = 6 * (size_t)n;
    if (n > 1 << 24) return kn_fail(ctx, KN_ELIMIT, "tile: %d pieces of volumes", n);
    faces f = {.ctx = ctx, .tolerance = tolerance};
    f.list = kn_alloc_zero(ctx, room, sizeof *f.list);
    f.middle = kn_alloc(ctx, room, sizeof *f.middle);
    f.joined = kn_alloc_zero(ctx, room, sizeof *f.joined);
    kn_status status = f.list && f.middle && f.joined ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < n && status == KN_OK; i++)
        for (int k = 0; k < 6 && status == KN_OK; k++, f.n++) {
            double p[4][3];
            status = make_face(ctx, &f.list[f.n], &volumes[i], k / 2, k % 2);
            if (status != KN_OK) break;
            for (int j = 0; j < 4; j++) corner(p[j], &f.list[f.n].surface, j >> 1, j & 1);
            for (int c = 0; c < 3; c++)
                f.middle[f.n][c] = 0.25 * p[0][c] + 0.25 * p[1][c] + 0.25 * p[2][c] + 0.25 * p[3][c];
        }
    if (status == KN_OK) status = join_faces(net, &f);
    if (status == KN_OK) status = keep_faces(net, &f);
    for (int i = 0; f.list && i < (int)room; i++) kn_bezier_clear(ctx, &f.list[i].surface);
    kn_free(ctx, f.list);
    kn_free(ctx, f.middle);
    kn_free(ctx, f.joined);
    return status;
}
