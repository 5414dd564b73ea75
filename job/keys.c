// SPDX-License-Identifier: Apache-2.0
// A set of keys.
#include "job/internal.h"
#include "kernel/hash.h"

static uint64_t term_of(const kn_job_key *k, int t)
{
    return (uint64_t)k->degree[t][0] << 16 | (uint64_t)k->degree[t][1] << 8 | k->power[t];
}

// All fields of a key but the terms, without loss: levels, indices and a degree; patch, degrees and the flags.
static uint64_t place_of(const kn_job_key *k)
{
    uint64_t p = k->composed[2];
    for (int d = 0; d < KN_JOB_VARS; d++) p = (p << 4 | k->rect.level[d]) << 12 | k->rect.index[d];
    return p;
}

static uint64_t kind_of(const kn_job_key *k)
{
    uint32_t flags = (uint32_t)(k->turn << 2 | k->whole << 1 | k->exact);
    return (uint64_t)(uint32_t)k->patch << 32 | (uint64_t)k->composed[0] << 24 | (uint64_t)k->composed[1] << 16 |
           (uint64_t)k->nterms << 8 | flags;
}

bool kn_job_same_key(const kn_job_key *a, const kn_job_key *b)
{
    if (place_of(a) != place_of(b) || kind_of(a) != kind_of(b)) return false;
    for (int t = 0; t < a->nterms; t++)
        if (term_of(a, t) != term_of(b, t)) return false;
    return true;
}

// The slot that holds key, or the empty one where it belongs.
static size_t find(const kn_job_keys *keys, const kn_job_key *key)
{
    uint64_t terms = kind_of(key);
    for (int t = 0; t < key->nterms; t++) terms = terms * 0x9e3779b97f4a7c15u + term_of(key, t);
    size_t at = (size_t)kn_hash_add(terms, place_of(key));
    for (;; at++) {
        at &= keys->nslots - 1;
        if (keys->slot[at] == 0 || kn_job_same_key(key, &keys->list[keys->slot[at] - 1])) return at;
    }
}

static kn_status grow(kn_ctx *ctx, kn_job_keys *keys)
{
    size_t room = keys->room > 0 ? 2 * keys->room : 64;
    kn_job_key *list = kn_resize(ctx, keys->list, room, sizeof *list);
    if (!list) return KN_ENOMEM;
    keys->list = list;
    size_t *uses = kn_resize(ctx, keys->uses, room, sizeof *uses);
    if (!uses) return KN_ENOMEM;
    keys->uses = uses;
    uint32_t *slot = kn_alloc_zero(ctx, 2 * room, sizeof *slot);
    if (!slot) return KN_ENOMEM;
    kn_free(ctx, keys->slot);
    keys->slot = slot;
    keys->room = room;
    keys->nslots = 2 * room;
    for (size_t i = 0; i < keys->count; i++) slot[find(keys, &keys->list[i])] = (uint32_t)i + 1;
    return KN_OK;
}

kn_status kn_job_keys_add(kn_ctx *ctx, uint32_t *index, kn_job_keys *keys, const kn_job_key *key)
{
    if (keys->count >= UINT32_MAX / 4) return kn_fail(ctx, KN_ELIMIT, "job: too many different pieces");
    kn_status status = keys->count == keys->room ? grow(ctx, keys) : KN_OK;
    if (status != KN_OK) return status;
    size_t at = find(keys, key);
    if (keys->slot[at] == 0) {
        keys->list[keys->count] = *key;
        keys->uses[keys->count] = 0;
        keys->slot[at] = (uint32_t)++keys->count;
    }
    *index = keys->slot[at] - 1;
    return KN_OK;
}

bool kn_job_keys_find(uint32_t *index, const kn_job_keys *keys, const kn_job_key *key)
{
    if (keys->nslots == 0) return false;
    size_t at = find(keys, key);
    if (keys->slot[at] == 0) return false;
    *index = keys->slot[at] - 1;
    return true;
}
