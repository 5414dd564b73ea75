// SPDX-License-Identifier: Apache-2.0
// The sequence of blocks, from the plan.
#include "job/internal.h"

// Coefficients of a block's patches, about: half a MiB, which a second cache holds with all that is read. But every
// block reads its matrices once: where they are large, up to 2 MiB, lest more is read than written.
enum { LEAST_NUMBERS = 1 << 16, MOST_NUMBERS = 1 << 18 };

static size_t target(const kn_job *job, const kn_job_alike *alike)
{
    if (alike->list == KN_JOB_OWN) return LEAST_NUMBERS;
    size_t weights = job->lists.list[alike->list].weights;
    return weights >= MOST_NUMBERS / 4 ? MOST_NUMBERS : 4 * weights > LEAST_NUMBERS ? 4 * weights : LEAST_NUMBERS;
}

// Takes cells of one entry into the block: as many as fill it, or all of those with plans of their own.
static void take(kn_job_block *b, kn_job_cursor *at, const kn_job *job, size_t ncomp)
{
    const kn_job_alike *alike = &job->alike[at->alike];
    size_t rest = alike[1].first_cell - at->cell, n = rest;
    bool part = at->end > 0 && at->end < alike[1].first_cell && alike->list != KN_JOB_OWN;
    if (part) n = rest = at->end - at->cell;
    if (alike->list == KN_JOB_OWN) {
        b->npatches += alike->npatches;
        b->numbers += alike->numbers;
    } else {
        const kn_job_list *list = &job->lists.list[alike->list];
        size_t each = ncomp * list->numbers;
        if (each > 0) {
            n = (target(job, alike) - b->numbers + each - 1) / each;
            n = n > rest ? rest : n;
        }
        b->npatches += n * list->count;
        b->numbers += n * each;
    }
    b->ncells += n;
    at->cell += n;
    if (n == rest && !part) at->alike++;
}

static bool ended(const kn_job_cursor *at, const kn_job *job)
{
    return at->alike >= job->nalike || (at->end > 0 && at->cell >= at->end);
}

kn_job_cursor kn_job_cursor_at(const kn_job *job, size_t first_cell, size_t ncells)
{
    size_t lo = kn_job_find_alike(job, first_cell);
    bool own = lo < job->nalike && job->alike[lo].list == KN_JOB_OWN;
    return (kn_job_cursor){
        .alike = lo, .cell = own ? job->alike[lo].first_cell : first_cell, .end = first_cell + ncells};
}

bool kn_job_next_block(kn_job_block *out, kn_job_cursor *at, const kn_job *job)
{
    kn_job_block b = {.first_cell = at->cell, .first_patch = at->patch};
    int surface = 0, cell[2];
    size_t end = 0, ncomp = 3;
    while (!ended(at, job) && b.numbers < target(job, &job->alike[at->alike])) {
        if (at->cell >= end) {
            if (b.npatches > 0) break; // the next surface begins here
            b = (kn_job_block){.first_cell = at->cell, .first_patch = at->patch};
            kn_job_locate(job, at->cell, &surface, cell);
            const kn_job_surface *s = &job->surfaces[surface];
            end = s->first_cell + (size_t)s->cells[0] * (size_t)s->cells[1];
            ncomp = kn_job_components(s);
        }
        take(&b, at, job, ncomp);
    }
    at->patch += b.npatches;
    *out = b;
    return b.npatches > 0;
}
