// SPDX-License-Identifier: Apache-2.0
// Bounds of the first partial derivatives of a spline.
#include <math.h>
#include <string.h>

#include "bezier/bounds.h"
#include "kernel/bounds.h"
#include "spline/calculus.h"

// The derivative's values are means of its coefficients, each with gamma(4).
static kn_status polynomial(kn_ctx *ctx, double *most, const kn_spline *a, int var)
{
    kn_spline d = *a;
    *most = 0.0;
    if (a->degree[var] == 0) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_spline_differentiate_in_scratch(ctx, &d, var);
    if (status == KN_OK) *most = kn_hull_norm(kn_spline_count(&d), d.ncomp, d.coef);
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- rational: piece by piece ----

typedef struct pieces {
    kn_spline a, size; // split: the coefficients, and what their roundings are relative to
    kn_grid grid;
    kn_bezier piece, piece_size;
    double known;
} pieces;

static kn_status prepare(kn_ctx *ctx, pieces *w, const kn_spline *a)
{
    size_t all = kn_spline_count(a) * (size_t)a->ncomp;
    w->a = w->size = *a;
    w->known = 0.0;
    w->size.coef = kn_scratch(ctx, all, sizeof *w->size.coef);
    if (!w->size.coef) return KN_ENOMEM;
    for (size_t i = 0; i < all; i++) w->size.coef[i] = fabs(a->coef[i]);
    kn_status status = KN_OK;
    for (int d = 0; d < a->nvars && status == KN_OK; d++) status = kn_spline_breaks(ctx, &w->grid, a, d);
    if (status == KN_OK) status = kn_spline_split_on_grid(ctx, &w->a, &w->grid);
    if (status == KN_OK) status = kn_spline_split_on_grid(ctx, &w->size, &w->grid);
    w->piece = (kn_bezier){.nvars = a->nvars, .ncomp = a->ncomp, .rational = true};
    for (int d = 0; d < a->nvars; d++) {
        w->piece.degree[d] = a->degree[d];
        w->known += 6.0 * a->degree[d] + 1.0;
    }
    w->piece_size = w->piece;
    if (status == KN_OK) status = kn_bezier_scratch(ctx, &w->piece, "spline_lipschitz");
    if (status == KN_OK) status = kn_bezier_scratch(ctx, &w->piece_size, "spline_lipschitz");
    return status;
}

// The derivatives on one box of breaks, over its lengths: two roundings.
static kn_status one_piece(kn_ctx *ctx, double *most, pieces *w, const int *index)
{
    int first[KN_MAX_VARS];
    double local[KN_MAX_VARS];
    for (int d = 0; d < w->a.nvars; d++) first[d] = index[d] * (w->a.degree[d] + 1);
    kn_spline_get_piece(&w->piece, &w->a, first);
    kn_spline_get_piece(&w->piece_size, &w->size, first);
    kn_status status = kn_rational_lipschitz(ctx, "spline_lipschitz", local, &w->piece, w->piece_size.coef, w->known);
    for (int d = 0; d < w->a.nvars && status == KN_OK; d++) {
        const double *knots = w->a.knots[d] + first[d];
        double slope = local[d] / (knots[w->a.degree[d] + 1] - knots[0]) * (1.0 + 0x1p-50);
        most[d] = slope > most[d] || isnan(slope) ? slope : most[d];
    }
    return status;
}

static kn_status all_pieces(kn_ctx *ctx, double *most, const kn_spline *a)
{
    int index[KN_MAX_VARS] = {0};
    pieces w;
    kn_status status = prepare(ctx, &w, a);
    for (int d = 0; status == KN_OK && d >= 0;) {
        status = one_piece(ctx, most, &w, index);
        d = a->nvars - 1;
        while (d >= 0 && ++index[d] == w.a.count[d] / (a->degree[d] + 1)) index[d--] = 0;
    }
    return status;
}

kn_status kn_spline_lipschitz(kn_ctx *ctx, double *out, const kn_spline *a)
{
    double most[KN_MAX_VARS] = {0};
    kn_status status = kn_spline_expect(ctx, "spline_lipschitz", a, 0);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    if (a->rational) {
        size_t n = kn_spline_count(a);
        status = kn_hull_positive(n, a->coef + (size_t)kn_spline_dim(a) * n, NULL)
                     ? all_pieces(ctx, most, a)
                     : kn_fail(ctx, KN_EDOMAIN, "spline_lipschitz: a weight is not positive");
    }
    for (int d = 0; d < a->nvars && !a->rational && status == KN_OK; d++) status = polynomial(ctx, &most[d], a, d);
    if (status == KN_OK) memcpy(out, most, (size_t)a->nvars * sizeof *out);
    kn_scratch_release(ctx, mark);
    return status;
}
