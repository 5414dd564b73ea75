// SPDX-License-Identifier: Apache-2.0
// Pieces of a shell, each made once for a cell.
#include "job/internal.h"

static bool same(const kn_job_piece *p, const kn_job_place *place, const double lo[2], const double hi[2])
{
    if (p->surface != place->surface) return false;
    for (int d = 0; d < 2; d++)
        if (p->cell[d] != place->cell[d] || p->lo[d] != lo[d] || p->hi[d] != hi[d]) return false;
    return true;
}

// Coefficients where there was but an outline.
static kn_status fill(kn_ctx *ctx, kn_job_pieces *pieces, kn_job_piece *p)
{
    if (!p->fits || p->piece.term[0].coef) return KN_OK;
    const kn_job_surface *s = &pieces->job->surfaces[p->surface];
    kn_shell_piece_clear(ctx, &p->piece);
    p->fits = false;
    return kn_shell_piece_init(ctx, &p->piece, &p->fits, s->shell, p->cell, p->lo, p->hi, s->degree_sum);
}

kn_status kn_job_pieces_get(kn_ctx *ctx, int *index, kn_job_pieces *pieces, const kn_job_place *place,
                            const double lo[2], const double hi[2])
{
    for (int i = 0; i < pieces->count; i++)
        if (same(&pieces->list[i], place, lo, hi)) {
            *index = i;
            return pieces->outline ? KN_OK : fill(ctx, pieces, &pieces->list[i]);
        }
    if (pieces->count == pieces->room) {
        int room = pieces->room > 0 ? 2 * pieces->room : 8;
        kn_job_piece *list = kn_resize(ctx, pieces->list, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        pieces->list = list;
        pieces->room = room;
    }
    kn_job_piece *p = &pieces->list[pieces->count];
    *p = (kn_job_piece){.surface = place->surface, .cell = {place->cell[0], place->cell[1]}};
    for (int d = 0; d < 2; d++) p->lo[d] = lo[d], p->hi[d] = hi[d];
    const kn_job_surface *s = &pieces->job->surfaces[place->surface];
    kn_status status = pieces->outline
                           ? kn_shell_piece_outline(ctx, &p->piece, &p->fits, s->shell, p->cell, lo, hi,
                                                    s->degree_sum)
                           : kn_shell_piece_init(ctx, &p->piece, &p->fits, s->shell, p->cell, lo, hi, s->degree_sum);
    if (status != KN_OK) return status;
    *index = pieces->count++;
    return KN_OK;
}

void kn_job_pieces_clear(kn_ctx *ctx, kn_job_pieces *pieces)
{
    for (int i = 0; i < pieces->count; i++)
        if (pieces->list[i].fits) kn_shell_piece_clear(ctx, &pieces->list[i].piece);
    pieces->count = 0;
}

void kn_job_pieces_end(kn_ctx *ctx, kn_job_pieces *pieces)
{
    kn_job_pieces_clear(ctx, pieces);
    kn_free(ctx, pieces->list);
    *pieces = (kn_job_pieces){0};
}
