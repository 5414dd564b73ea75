// SPDX-License-Identifier: Apache-2.0
// How finely the faces of a CAD file are tessellated: each direction of a face as its own curvature asks for, and equal
// counts on both sides of edges that are whole sides of two faces, so that their triangles meet.
#include "cli/cli.h"
#include "io/bend.h"
#include "kernel/context.h"
#include "kernel/union_find.h"

// The direction that a curve runs in along a whole side of the square: 0, 1, or -1.
static int side_of(const kn_cad_face *face, int curve)
{
    const kn_spline *c = &face->trim.curves[curve];
    size_t n = (size_t)c->count[0];
    int along = -1;
    for (size_t d = 0; d < 2; d++) {
        double from = c->coef[d * n], to = c->coef[d * n + n - 1];
        bool ends = (from == 0.0 || from == 1.0) && (to == 0.0 || to == 1.0);
        if (!ends || (from != to && along >= 0)) return -1;
        if (from != to) along = (int)d;
    }
    return along;
}

// Direction d of face f is number 2 f + d; directions that have a common side are of one class.
static void join_sides(int *parent, const kn_cad *cad)
{
    for (int i = 0; i < cad->nedges; i++) {
        const kn_cad_edge *e = &cad->edges[i];
        int number[2];
        if (e->more || e->point || e->face[1] < 0) continue;
        for (int k = 0; k < 2; k++) {
            const kn_cad_face *face = &cad->faces[e->face[k]];
            int d = face->whole ? side_of(face, e->curve[k]) : -1;
            number[k] = d < 0 ? -1 : 2 * e->face[k] + d;
        }
        if (number[0] < 0 || number[1] < 0) continue;
        const kn_spline *a = &cad->faces[e->face[0]].surface, *b = &cad->faces[e->face[1]].surface;
        if (kn_spline_spans(a, number[0] % 2) != kn_spline_spans(b, number[1] % 2)) continue;
        kn_class_unite(parent, number[0], number[1]);
    }
}

kn_status cli_cad_segments(kn_ctx *ctx, int (**out)[2], const kn_cad *cad, double tol)
{
    size_t n = 2 * (size_t)cad->nfaces;
    kn_mark mark = kn_scratch_mark(ctx);
    int *parent = kn_scratch(ctx, n + 1, sizeof *parent), *most = kn_scratch(ctx, n + 1, sizeof *most);
    int(*counts)[2] = kn_alloc(ctx, n / 2 + 1, sizeof *counts);
    kn_status status = parent && most && counts ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++) parent[i] = (int)i, most[i] = 1;
    if (status == KN_OK) join_sides(parent, cad);
    for (int f = 0; status == KN_OK && f < cad->nfaces; f++) {
        const kn_spline *s = &cad->faces[f].surface;
        double bend[3];
        status = kn_spline_bends(ctx, bend, s);
        for (int d = 0; status == KN_OK && d < 2; d++) {
            int own = kn_bend_segments(2.0 * bend[d], tol), root = kn_class_root(parent, 2 * f + d);
            if (own == 1 && s->degree[d] > 1) own = 2; // what bends is seen to
            if (own > most[root]) most[root] = own;
        }
    }
    for (size_t i = 0; status == KN_OK && i < n; i++) counts[i / 2][i % 2] = most[kn_class_root(parent, (int)i)];
    kn_scratch_release(ctx, mark);
    if (status == KN_OK)
        *out = counts;
    else
        kn_free(ctx, counts);
    return status;
}
