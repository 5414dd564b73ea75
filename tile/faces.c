// SPDX-License-Identifier: Apache-2.0
// The faces of a tile's volumes that bound the whole.
#include "tile/net.h"

#include <math.h>

// The face where variable var of a volume ends, its variables the other two in their order: it faces outwards at the
// end 1 of var 0 and 2, and at the end 0 of var 1.
static kn_status make_face(kn_ctx *ctx, kn_tile_piece *out, const kn_tile_piece *volume, int var, int end)
{
    const kn_bezier *v = &volume->surface;
    int a = var == 0 ? 1 : 0, b = var == 2 ? 1 : 2, degree[2] = {v->degree[a], v->degree[b]};
    const size_t step[3] = {(size_t)(v->degree[1] + 1) * (size_t)(v->degree[2] + 1), (size_t)v->degree[2] + 1, 1};
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

// A face without a mate that lies in a line between cells: the tile was cut there.
static void note_cut(kn_tile_net *net, const kn_tile_piece *face, double tolerance)
{
    size_t n = kn_bezier_count(&face->surface);
    for (size_t c = 0; c < 2; c++) {
        const double *x = face->surface.coef + c * n;
        bool cut = true;
        for (size_t k = 0; k < n; k++) cut = cut && fabs(x[k] - nearbyint(x[0])) <= tolerance;
        if (cut && net->ntorn[c]++ == 0) net->torn[c] = face->place;
    }
}

kn_status kn_tile_net_faces(kn_ctx *ctx, kn_tile_net *net, const kn_tile_piece *volumes, int n, double tolerance)
{
    kn_bezier *list = kn_alloc(ctx, (size_t)n, sizeof *list); // borrowed
    kn_tile_cover *cover = kn_alloc(ctx, 6 * (size_t)n, sizeof *cover);
    size_t joined[3] = {0, 0, 0};
    kn_status status = list && cover ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < n && status == KN_OK; i++) list[i] = volumes[i].surface;
    if (status == KN_OK) status = kn_tile_cover_faces(ctx, cover, list, (size_t)n);
    for (int i = 0; i < n && status == KN_OK; i++)
        for (int k = 0; k < 6 && status == KN_OK; k++) {
            const kn_tile_cover *c = &cover[6 * i + k];
            kn_tile_piece face = {.inwards = false};
            if (c->covered) {
                joined[0] += c->cell[0] != 0;
                joined[1] += c->cell[1] != 0;
                joined[2] += c->cell[0] == 0 && c->cell[1] == 0;
                continue;
            }
            status = make_face(ctx, &face, &volumes[i], k / 2, k % 2);
            if (status == KN_OK) note_cut(net, &face, tolerance);
            if (status == KN_OK) status = kn_tile_net_add(ctx, net, &face);
            kn_bezier_clear(ctx, &face.surface);
        }
    for (int d = 0; d < 3; d++) net->nfaces[d] = joined[d] / 2; // each of two counts
    kn_free(ctx, list);
    kn_free(ctx, cover);
    return status;
}
