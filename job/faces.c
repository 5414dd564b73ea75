// SPDX-License-Identifier: Apache-2.0
// Faces of volumes that others hide: of the same tile, of tiles in neighbouring cells, and of other pieces of the
// same volume.
#include "job/internal.h"

kn_status kn_job_cover_faces(kn_ctx *ctx, kn_job_patches *patches, int first)
{
    size_t n = (size_t)(patches->n - first), volumes = 0;
    kn_job_patch *list = patches->list + first;
    for (size_t i = 0; i < n; i++) volumes += list[i].d.nvars == 3;
    if (volumes == 0) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_bezier *views = kn_scratch(ctx, n, sizeof *views);
    kn_tile_cover *cover = kn_scratch(ctx, 6 * n, sizeof *cover);
    for (size_t i = 0; views && i < n; i++) views[i] = list[i].d;
    kn_status status = views && cover ? kn_tile_cover_faces(ctx, cover, views, n) : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < 6 * n; i++) {
        kn_tile_cover *to = &list[i / 6].cover[i % 6];
        *to = cover[i];
        // A = B + cell in coordinates of cells at offsets of their own: B's tile is so many cells from A's
        for (int c = 0; c < 2 && to->covered; c++) to->cell[c] += list[i / 6].offset[c] - list[to->by].offset[c];
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// Whether the cell at `offset` from a cell has the same tile in the same place.
static kn_status has_same(kn_ctx *ctx, bool *same, const kn_job *job, int surface, const int cell[2],
                          const int offset[2])
{
    *same = false;
    if (job->tiling || job->darts || job->varying || job->options.random.angle != 0.0 ||
        job->options.random.shift != 0.0 || job->options.random.scale != 0.0 || job->options.random.height != 0.0)
        return KN_OK;
    kn_job_place place = kn_job_find_place(job, surface, cell, offset);
    const kn_job_surface *s = &job->surfaces[place.surface];
    if (place.turn != 0) return KN_OK;
    for (int d = 0; d < 2; d++) {
        int n = s->cells[d];
        if (s->closed[d]) place.cell[d] = (place.cell[d] % n + n) % n;
        if (place.cell[d] < 0 || place.cell[d] >= n) return KN_OK;
    }
    return kn_job_has_cell(ctx, same, job, place.surface, place.cell);
}

kn_status kn_job_hide_faces(kn_ctx *ctx, uint8_t *hidden, const kn_job *job, const kn_job_patch *patch,
                            const kn_job_rect *rect, int surface, const int cell[2])
{
    uint8_t bits = 0;
    kn_status status = KN_OK;
    for (int face = 0; face < 6 && status == KN_OK; face++) {
        const kn_tile_cover *cover = &patch->cover[face];
        int var = face / 2, last = (1 << rect->level[var]) - 1;
        bool hides = face % 2 == 0 ? rect->index[var] > 0 : rect->index[var] < last;
        if (!hides && cover->covered) {
            hides = cover->cell[0] == 0 && cover->cell[1] == 0;
            if (!hides) status = has_same(ctx, &hides, job, surface, cell, cover->cell);
        }
        if (hides) bits = (uint8_t)(bits | 1u << face);
    }
    if (status == KN_OK) *hidden = bits;
    return status;
}
