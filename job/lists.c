// SPDX-License-Identifier: Apache-2.0
// A set of lists of keys.
#include "job/internal.h"

#include <string.h>

static uint64_t hash(const kn_job_ref *refs, size_t n)
{
    uint64_t h = n;
    for (size_t i = 0; i < n; i++)
        h = (h ^ ((uint64_t)refs[i].key << 32 | refs[i].instance)) * 0x9e3779b97f4a7c15u + 1;
    return h ^ h >> 29;
}

static bool same(const kn_job_ref *a, const kn_job_ref *b, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (a[i].key != b[i].key || a[i].instance != b[i].instance) return false;
    return true;
}

// The slot that holds the list, or the empty one where it belongs.
static size_t find(const kn_job_lists *lists, const kn_job_ref *refs, size_t n)
{
    for (size_t at = (size_t)hash(refs, n);; at++) {
        at &= lists->nslots - 1;
        if (lists->slot[at] == 0) return at;
        const kn_job_list *l = &lists->list[lists->slot[at] - 1];
        if (l->count == n && same(lists->refs + l->first, refs, n)) return at;
    }
}

static kn_status grow(kn_ctx *ctx, kn_job_lists *lists)
{
    size_t room = lists->room > 0 ? 2 * lists->room : 64;
    kn_job_list *list = kn_resize(ctx, lists->list, room, sizeof *list);
    if (!list) return KN_ENOMEM;
    lists->list = list;
    uint32_t *slot = kn_alloc_zero(ctx, 2 * room, sizeof *slot);
    if (!slot) return KN_ENOMEM;
    kn_free(ctx, lists->slot);
    lists->slot = slot;
    lists->room = room;
    lists->nslots = 2 * room;
    for (size_t i = 0; i < lists->count; i++) {
        const kn_job_list *l = &lists->list[i];
        slot[find(lists, lists->refs + l->first, l->count)] = (uint32_t)i + 1;
    }
    return KN_OK;
}

static kn_status reserve_refs(kn_ctx *ctx, kn_job_lists *lists, size_t n)
{
    size_t needed = lists->nrefs + n;
    if (needed <= lists->refs_room) return KN_OK;
    size_t room = 2 * lists->refs_room > needed ? 2 * lists->refs_room : needed + 16;
    kn_job_ref *refs = kn_resize(ctx, lists->refs, room, sizeof *refs);
    if (!refs) return KN_ENOMEM;
    lists->refs = refs;
    lists->refs_room = room;
    return KN_OK;
}

kn_status kn_job_lists_add(kn_ctx *ctx, uint32_t *index, kn_job_lists *lists, const kn_job_ref *refs, size_t n)
{
    kn_status status = lists->count == lists->room ? grow(ctx, lists) : KN_OK;
    if (status == KN_OK) status = reserve_refs(ctx, lists, n);
    if (status != KN_OK) return status;
    size_t at = find(lists, refs, n);
    if (lists->slot[at] == 0) {
        if (n > 0) memcpy(lists->refs + lists->nrefs, refs, n * sizeof *refs);
        lists->list[lists->count] = (kn_job_list){.first = lists->nrefs, .count = (uint32_t)n};
        lists->nrefs += n;
        lists->slot[at] = (uint32_t)++lists->count;
    }
    *index = lists->slot[at] - 1;
    return KN_OK;
}
