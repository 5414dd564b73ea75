// SPDX-License-Identifier: Apache-2.0
// The life of a job, and what it tells.
#include "job/internal.h"

kn_job_options kn_job_defaults(void)
{
    return (kn_job_options){0};
}

void kn_job_destroy(kn_ctx *ctx, kn_job *job)
{
    if (!job) return;
    for (int k = 0; k < job->npatches; k++) kn_bezier_clear(ctx, &job->patches[k].d);
    for (int s = 0; job->surfaces && s < job->nsurfaces; s++) {
        kn_job_surface *surface = &job->surfaces[s];
        kn_shell_destroy(ctx, surface->shell);
        for (int d = 0; d < 2; d++) {
            kn_free(ctx, surface->lines[d]);
            kn_free(ctx, surface->knot[d]);
        }
    }
    kn_tile_clear(ctx, &job->tile);
    kn_free(ctx, job->patches);
    kn_free(ctx, job->surfaces);
    kn_free(ctx, job->keys);
    kn_free(ctx, job->uses);
    kn_free(ctx, job->leaves);
    kn_free(ctx, job->cells);
    kn_free(ctx, job->darts);
    kn_free(ctx, job);
}

kn_job_report kn_job_describe(const kn_job *job)
{
    return job->report;
}

const kn_tile *kn_job_tile(const kn_job *job)
{
    return &job->tile;
}

const kn_shell *kn_job_shell(const kn_job *job, int surface)
{
    return surface >= 0 && surface < job->nsurfaces ? job->surfaces[surface].shell : NULL;
}

const double *kn_job_lines(const kn_job *job, int surface, int var)
{
    if (surface < 0 || surface >= job->nsurfaces || var < 0 || var > 1) return NULL;
    return job->surfaces[surface].lines[var];
}

int kn_job_origin(const kn_job *job, int surface, int first_cell[2])
{
    if (surface < 0 || surface >= job->nsurfaces) return -1;
    const kn_job_surface *s = &job->surfaces[surface];
    for (int d = 0; d < 2 && first_cell; d++) first_cell[d] = s->origin_cell[d];
    return s->origin;
}

// The surface of the job that has the cell which id names, and its number there; false: there is none.
static bool find_cell(int *surface, int cell[2], const kn_job *job, const kn_patch_id *id)
{
    for (int i = 0; i < job->nsurfaces; i++) {
        const kn_job_surface *s = &job->surfaces[i];
        bool here = s->origin == id->surface;
        for (int d = 0; d < 2; d++) {
            here = here && id->cell[d] >= s->origin_cell[d] && id->cell[d] - s->origin_cell[d] < s->cells[d];
            cell[d] = here ? id->cell[d] - s->origin_cell[d] : 0;
        }
        *surface = i;
        if (here) return true;
    }
    return false;
}

// The leaf of the cell that id names; NULL: there is none.
static const kn_job_key *find_leaf(const kn_job *job, int surface, const int at[2], const kn_patch_id *id)
{
    const kn_job_surface *s = &job->surfaces[surface];
    const kn_job_cell *cell = &job->cells[s->first_cell + (size_t)at[0] * (size_t)s->cells[1] + (size_t)at[1]];
    int piece = 0;
    for (uint32_t i = 0; i < cell->count; i++) {
        const kn_job_key *key = &job->keys[job->leaves[cell->first + i]];
        const kn_job_patch *p = &job->patches[key->patch];
        if (p->part == id->part && p->patch == id->patch && piece++ == id->piece) return key;
    }
    return NULL;
}

kn_status kn_job_source(kn_ctx *ctx, kn_bezier *out, kn_patch_place *place, const kn_job *job, const kn_patch_id *id)
{
    int surface, cell[2];
    const kn_job_key *key = find_cell(&surface, cell, job, id) ? find_leaf(job, surface, cell, id) : NULL;
    if (!key) return kn_fail(ctx, KN_EDOMAIN, "job: no such patch");
    const kn_job_patch *patch = &job->patches[key->patch];
    kn_bezier d = {0};
    kn_status status = kn_job_restrict(ctx, &d, patch, key->rect, key->turn);
    if (status != KN_OK) return status;
    kn_job_place at = kn_job_find_place(job, surface, cell, patch->offset);
    size_t n = kn_bezier_count(&d);
    if (at.surface == surface && at.turn == 0)
        for (size_t c = 0; c < 2; c++) {
            for (size_t i = 0; i < n; i++) d.coef[c * n + i] += at.cell[c] - cell[c];
            at.cell[c] = cell[c];
        }
    if (place) *place = (kn_patch_place){at.surface, {at.cell[0], at.cell[1]}};
    kn_bezier_swap(out, &d);
    kn_bezier_clear(ctx, &d);
    return KN_OK;
}
