// SPDX-License-Identifier: Apache-2.0
// The life of a job, and what it tells.
#include "job/border.h"
#include "job/looks.h"

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
    kn_job_select_clear(ctx, job);
    kn_job_instances_clear(ctx, job);
    kn_job_vary_clear(ctx, job);
    kn_job_borders_clear(ctx, job);
    kn_job_looks_clear(ctx, job);
    kn_tile_clear(ctx, &job->tile);
    kn_free(ctx, job->patches);
    kn_free(ctx, job->surfaces);
    kn_free(ctx, job->terms);
    kn_free(ctx, job->least);
    kn_job_meeting_free(ctx, job);
    kn_free(ctx, job->variants);
    kn_free(ctx, job->keys.list);
    kn_free(ctx, job->keys.uses);
    kn_free(ctx, job->keys.slot);
    kn_free(ctx, job->lists.refs);
    kn_free(ctx, job->lists.list);
    kn_free(ctx, job->lists.slot);
    kn_free(ctx, job->alike);
    kn_free(ctx, job->there);
    kn_free(ctx, job->detail);
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

bool kn_job_find_cell(size_t *index, const kn_job *job, const kn_patch_id *id)
{
    int surface, cell[2];
    if (!find_cell(&surface, cell, job, id)) return false;
    const kn_job_surface *s = &job->surfaces[surface];
    *index = s->first_cell + (size_t)cell[0] * (size_t)s->cells[1] + (size_t)cell[1];
    return true;
}

// The key that id names in a list; false: there is none.
static bool find_ref(kn_job_key *key, const kn_job *job, const kn_job_list *list, const kn_patch_id *id)
{
    int piece = 0;
    for (size_t i = list->first; i < list->first + list->count; i++) {
        const kn_job_ref *ref = &job->lists.refs[i];
        *key = job->keys.list[ref->key];
        const kn_job_patch *p = &job->patches[key->patch];
        if ((int)ref->instance == id->instance && p->part == id->part && p->patch == id->patch &&
            piece++ == id->piece)
            return true;
    }
    return false;
}

const kn_job_leaf *kn_job_find_leaf(const kn_job_cell_plan *plan, const kn_patch_id *id)
{
    int piece = 0;
    for (int i = 0; i < plan->count; i++) {
        const kn_job_leaf *leaf = &plan->leaves[i];
        if (leaf->mesh.position) continue;
        const kn_job_patch *p = kn_job_leaf_patch(plan, leaf);
        if (leaf->instance == id->instance && p->part == id->part && p->patch == id->patch && piece++ == id->piece)
            return leaf;
    }
    return NULL;
}

// D of that leaf, and the offset of the cell in whose coordinates it is.
static kn_status find_source(kn_ctx *ctx, kn_bezier *d, int offset[2], const kn_job *job, size_t cell,
                             const kn_patch_id *id)
{
    const kn_job_alike *alike = &job->alike[kn_job_find_alike(job, cell)];
    kn_job_cell_plan plan = {0};
    kn_job_key key = {0};
    const kn_job_patch *patch = NULL;
    kn_status status = KN_OK;
    if (alike->list != KN_JOB_OWN) {
        if (find_ref(&key, job, &job->lists.list[alike->list], id)) patch = &job->patches[key.patch];
    } else {
        status = kn_job_plan_cell(ctx, &plan, job, cell, false);
        const kn_job_leaf *leaf = status == KN_OK ? kn_job_find_leaf(&plan, id) : NULL;
        if (leaf) patch = kn_job_leaf_patch(&plan, leaf), key = leaf->key;
    }
    if (status == KN_OK && !patch) status = kn_fail(ctx, KN_EDOMAIN, "job: no such patch");
    if (status == KN_OK) {
        status = kn_job_restrict(ctx, d, patch, key.rect, key.turn);
        offset[0] = patch->offset[0], offset[1] = patch->offset[1];
    }
    kn_job_cell_plan_clear(ctx, &plan);
    return status;
}

kn_status kn_job_source(kn_ctx *ctx, kn_bezier *out, kn_patch_place *place, const kn_job *job, const kn_patch_id *id)
{
    int surface, cell[2], offset[2];
    kn_bezier d = {0};
    if (!find_cell(&surface, cell, job, id)) return kn_fail(ctx, KN_EDOMAIN, "job: no such patch");
    const kn_job_surface *s = &job->surfaces[surface];
    size_t index = s->first_cell + (size_t)cell[0] * (size_t)s->cells[1] + (size_t)cell[1];
    kn_status status = find_source(ctx, &d, offset, job, index, id);
    if (status != KN_OK) return status;
    kn_job_place at = kn_job_find_place(job, surface, cell, offset);
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
