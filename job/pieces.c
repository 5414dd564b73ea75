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

// The whole piece, with what its cell borrows.
static kn_status make(kn_ctx *ctx, kn_job_piece *p, const kn_job *job)
{
    const kn_job_surface *s = &job->surfaces[p->surface];
    bool whole = p->lo[0] == 0.0 && p->lo[1] == 0.0 && p->hi[0] == 1.0 && p->hi[1] == 1.0, fits = false;
    kn_shell_piece made = {0};
    kn_status status = kn_shell_piece_init(ctx, &made, &fits, s->shell, p->cell, p->lo, p->hi, s->degree_sum);
    if (status == KN_OK && fits && whole) status = kn_job_borrow(ctx, job, p->surface, p->cell, &made);
    if (status == KN_OK) {
        p->piece = made;
        p->fits = fits;
    } else {
        kn_shell_piece_clear(ctx, &made);
    }
    return status;
}

// Coefficients where there was but an outline.
static kn_status fill(kn_ctx *ctx, kn_job_pieces *pieces, kn_job_piece *p)
{
    if (!p->fits || p->piece.term[0].coef) return KN_OK;
    kn_shell_piece_clear(ctx, &p->piece);
    p->fits = false;
    return make(ctx, p, pieces->job);
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
    kn_status status = pieces->outline ? kn_shell_piece_outline(ctx, &p->piece, &p->fits, s->shell, p->cell, lo, hi,
                                                                s->degree_sum)
                                       : make(ctx, p, pieces->job);
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
