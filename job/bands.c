// SPDX-License-Identifier: Apache-2.0
// Pieces of whole cells, for many cells at once.
#include "job/run.h"

static bool same_terms(const kn_job_key *a, const kn_job_key *b)
{
    if (a == b) return true;
    if (a->nterms != b->nterms) return false;
    for (int t = 0; t < a->nterms; t++)
        if (a->degree[t][0] != b->degree[t][0] || a->degree[t][1] != b->degree[t][1] || a->power[t] != b->power[t])
            return false;
    return true;
}

static bool has(const kn_job_band *b, const kn_job_place *place, const kn_job_key *key)
{
    return b->surface == place->surface && b->cell[0] == place->cell[0] && place->cell[1] >= b->cell[1] &&
           place->cell[1] - b->cell[1] < b->count && same_terms(b->like, key);
}

// The terms of a key, as an outline has them.
static kn_shell_piece outline_of(const kn_job_key *key, int ncomp)
{
    kn_shell_piece p = {.nterms = key->nterms};
    for (int t = 0; t < key->nterms; t++) {
        p.term[t] = (kn_bezier){
            .nvars = 2, .ncomp = ncomp, .rational = ncomp == 4, .degree = {key->degree[t][0], key->degree[t][1]}};
        p.power[t] = key->power[t];
    }
    return p;
}

static kn_status make(kn_ctx *ctx, kn_job_band *b, const kn_job *job, const kn_job_place *place,
                      const kn_job_key *key, int cells)
{
    const kn_job_surface *s = &job->surfaces[place->surface];
    size_t each = 0, ncomp = kn_job_components(s);
    const kn_shell_piece like = outline_of(key, (int)ncomp);
    for (int t = 0; t < like.nterms; t++) each += ncomp * kn_bezier_count(&like.term[t]);
    kn_mark mark = kn_scratch_mark(ctx);
    double *rows = kn_scratch(ctx, (size_t)cells * each, sizeof *rows);
    int made = 0;
    kn_status status = rows ? kn_shell_piece_rows(ctx, rows, &made, s->shell, &like, place->cell, cells) : KN_ENOMEM;
    if (status != KN_OK || made == 0) kn_scratch_release(ctx, mark);
    *b = (kn_job_band){.surface = place->surface,
                       .cell = {place->cell[0], place->cell[1]},
                       .count = made > 0 ? made : 1,
                       .like = key,
                       .rows = made > 0 ? rows : NULL,
                       .each = each};
    return status;
}

kn_status kn_job_bands_get(kn_ctx *ctx, const double **rows, kn_job_bands *bands, const kn_job_place *place,
                           const kn_job_key *key, int cells)
{
    const kn_job_band *found = NULL;
    *rows = NULL;
    if (kn_job_borrows(bands->job, place->surface, place->cell)) return KN_OK;
    for (int i = 0; !found && i < bands->count; i++)
        if (has(&bands->band[i], place, key)) found = &bands->band[i];
    if (!found) {
        kn_job_band made;
        kn_status status = make(ctx, &made, bands->job, place, key, cells);
        if (status != KN_OK) return status;
        found = &bands->band[bands->next];
        bands->band[bands->next] = made;
        bands->next = (bands->next + 1) % KN_JOB_BANDS;
        if (bands->count < KN_JOB_BANDS) bands->count++;
    }
    *rows = found->rows ? found->rows + (size_t)(place->cell[1] - found->cell[1]) * found->each : NULL;
    return KN_OK;
}
