// SPDX-License-Identifier: Apache-2.0
// det dT/d(u,v,w) = sum_k J_k w^k over the whole shell: the boxes of its grid put side by side.
#include "kernel/context.h"
#include "trivar/internal.h"

typedef struct boxes {
    size_t n;
    int count[3], nvars, terms;
    kn_bezier *piece; // terms arrays of n
    double *breaks[3];
} boxes;

static void clear_boxes(kn_ctx *ctx, boxes *b)
{
    for (size_t k = 0; b->piece && k < b->n * (size_t)b->terms; k++) kn_bezier_clear(ctx, &b->piece[k]);
    kn_free(ctx, b->piece);
    for (int v = 0; v < 3; v++) kn_free(ctx, b->breaks[v]);
}

static kn_status take_box(kn_ctx *ctx, boxes *b, const kn_shell *shell, size_t index)
{
    int at[3] = {(int)(index / (size_t)b->count[2] / (size_t)b->count[1]),
                 (int)(index / (size_t)b->count[2] % (size_t)b->count[1]), (int)(index % (size_t)b->count[2])};
    kn_shell_jacobian_piece p = {0};
    kn_status status = kn_jacobian_box(ctx, &p, shell, shell->box, at, false);
    if (status == KN_OK && !b->piece) {
        b->terms = p.j.ncomp, b->nvars = p.j.nvars;
        b->piece = kn_alloc_zero(ctx, b->n * (size_t)b->terms, sizeof *b->piece);
        if (!b->piece) status = KN_ENOMEM;
    }
    for (int k = 0; k < b->terms && status == KN_OK; k++)
        status = kn_bezier_components(ctx, &b->piece[(size_t)k * b->n + index], &p.j, k, 1);
    for (int v = 0; v < 3 && status == KN_OK; v++) {
        b->breaks[v][at[v]] = p.lo[v];
        b->breaks[v][at[v] + 1] = p.hi[v];
    }
    kn_shell_jacobian_piece_clear(ctx, &p);
    return status;
}

static kn_status join(kn_ctx *ctx, kn_spline *out, const boxes *b, int k)
{
    const double *breaks[3] = {b->breaks[0], b->breaks[1], b->breaks[2]};
    int nbreaks[3], continuity[3] = {-1, -1, -1};
    for (int v = 0; v < 3; v++) nbreaks[v] = b->count[v] + 1;
    return kn_spline_from_bezier(ctx, out, b->piece + (size_t)k * b->n, nbreaks, breaks, continuity);
}

kn_status kn_shell_jacobian(kn_ctx *ctx, kn_spline **coefficients, int *n, int *weight_power, const kn_shell *shell)
{
    boxes b = {0};
    kn_spline *list = NULL;
    kn_status status = KN_OK;
    kn_shell_jacobian_grid(shell, b.count);
    b.n = (size_t)b.count[0] * (size_t)b.count[1] * (size_t)b.count[2];
    for (int v = 0; v < 3 && status == KN_OK; v++) {
        b.breaks[v] = kn_alloc(ctx, (size_t)b.count[v] + 1, sizeof *b.breaks[v]);
        if (!b.breaks[v]) status = KN_ENOMEM;
    }
    for (size_t k = 0; k < b.n && status == KN_OK; k++) {
        status = take_box(ctx, &b, shell, k);
        if (status == KN_OK) status = kn_progress(ctx, "Jacobian", (double)(k + 1) / (double)b.n);
    }
    if (status == KN_OK) {
        list = kn_alloc_zero(ctx, (size_t)b.terms, sizeof *list);
        if (!list) status = KN_ENOMEM;
    }
    for (int k = 0; k < b.terms && status == KN_OK; k++) status = join(ctx, &list[k], &b, k);
    if (status == KN_OK) {
        *coefficients = list;
        *n = b.terms;
        *weight_power = !shell->surface.rational ? 0 : b.nvars == 3 ? 4 : 3;
    } else if (list) {
        for (int k = 0; k < b.terms; k++) kn_spline_clear(ctx, &list[k]);
        kn_free(ctx, list);
    }
    clear_boxes(ctx, &b);
    return status;
}
