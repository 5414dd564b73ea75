// SPDX-License-Identifier: Apache-2.0
// kn_compose_piece: T(D) for one piece of a shell by symbolic composition, the reference for the matrix.
#include "compose/basis.h"

#include <knurl/compose.h>

// term(u,v) w^k as a polynomial of homogeneous components.
static kn_status compose_term(kn_ctx *ctx, kn_bezier *out, const kn_bezier *term, const kn_bezier *uv,
                              const kn_bezier *wk)
{
    kn_bezier t = *term; // a view: homogeneous components multiply like any others
    t.rational = false;
    kn_status status = kn_bezier_compose(ctx, out, &t, uv);
    return status == KN_OK ? kn_bezier_product(ctx, out, wk, out) : status;
}

static kn_status check(kn_ctx *ctx, const kn_shell_piece *piece, const kn_bezier *tile)
{
    if (!tile->coef || tile->ncomp != 3 || tile->rational)
        return kn_fail(ctx, KN_EDOMAIN, "compose: a tile patch has three polynomial components");
    if (piece->nterms < 1 || piece->nterms > KN_SHELL_TERMS)
        return kn_fail(ctx, KN_EDOMAIN, "compose: a piece of %d terms", piece->nterms);
    for (int k = 0; k < piece->nterms; k++)
        if (piece->term[k].nvars != 2 || piece->term[k].ncomp != piece->term[0].ncomp)
            return kn_fail(ctx, KN_EDOMAIN, "compose: term %d of the piece has %d variables, %d components", k,
                           piece->term[k].nvars, piece->term[k].ncomp);
    for (int k = 0; k < piece->nterms; k++)
        if (piece->power[k] < 0 || piece->power[k] > KN_MAX_DEGREE)
            return kn_fail(ctx, piece->power[k] < 0 ? KN_EDOMAIN : KN_ELIMIT, "compose: term %d has w^%d", k,
                           piece->power[k]);
    return KN_OK;
}

kn_status kn_compose_piece(kn_ctx *ctx, kn_bezier *out, const kn_shell_piece *piece, const kn_bezier *tile)
{
    kn_status status = check(ctx, piece, tile);
    if (status != KN_OK) return status;
    int top = 0;
    for (int k = 0; k < piece->nterms; k++) top = piece->power[k] > top ? piece->power[k] : top;
    kn_bezier uv = {0}, w = {0}, sum = {0}, term = {0}, *power = kn_compose_list(ctx, top + 1);
    status = power ? kn_bezier_components(ctx, &uv, tile, 0, 2) : KN_ENOMEM;
    if (status == KN_OK) status = kn_bezier_components(ctx, &w, tile, 2, 1);
    if (status == KN_OK) status = kn_compose_powers(ctx, power, top, &w);
    for (int k = 0; status == KN_OK && k < piece->nterms; k++) {
        status = compose_term(ctx, &term, &piece->term[k], &uv, &power[piece->power[k]]);
        if (status == KN_OK && k > 0) status = kn_bezier_sum(ctx, &sum, &sum, &term);
        if (status == KN_OK && k == 0) kn_bezier_swap(&sum, &term);
    }
    if (status == KN_OK) {
        sum.rational = piece->term[0].rational;
        kn_bezier_swap(out, &sum);
    }
    kn_bezier_clear(ctx, &uv);
    kn_bezier_clear(ctx, &w);
    kn_bezier_clear(ctx, &sum);
    kn_bezier_clear(ctx, &term);
    kn_compose_list_clear(ctx, power, top + 1);
    return status;
}
