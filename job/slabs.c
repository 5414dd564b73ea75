// SPDX-License-Identifier: Apache-2.0
// Which cells may touch a slab of heights: the range of z of every cell, taken once, and of groups of them.
#include "job/placement.h"
#include "kernel/parallel.h"

#include <math.h>

enum {
    GROUP = 64,           // cells, or groups, of which one range is kept
    BLOCK = GROUP * GROUP // cells of one task
};

typedef struct span {
    float lo, hi; // rounded outwards; lo > hi: no cell
} span;

struct kn_job_slabs {
    const kn_job *job;
    span *cells, *groups, *blocks;
    size_t ncells, ngroups, nblocks;
};

typedef struct making {
    kn_job_slabs *slabs;
    kn_job_bounds bounds;
} making;

static float down(double x)
{
    float f = (float)x;
    return f > x ? nextafterf(f, -INFINITY) : f;
}

static float up(double x)
{
    float f = (float)x;
    return f < x ? nextafterf(f, INFINITY) : f;
}

static void widen(span *a, span b)
{
    if (b.lo > b.hi) return;
    a->lo = fminf(a->lo, b.lo), a->hi = fmaxf(a->hi, b.hi);
}

static kn_status measure_cell(kn_ctx *ctx, span *out, const making *m, kn_job_extents *extents, size_t index)
{
    const kn_job *job = m->slabs->job;
    int surface, cell[2];
    bool there = false;
    double lo[3], hi[3];
    kn_job_locate(job, index, &surface, cell);
    *out = (span){INFINITY, -INFINITY};
    kn_status status = kn_job_has_cell(ctx, &there, job, surface, cell);
    if (status != KN_OK || !there) return status;
    status = kn_job_cell_extents(ctx, extents, job, surface, cell);
    if (status == KN_OK) status = kn_job_bounds_cell(ctx, lo, hi, &m->bounds, surface, cell, extents);
    if (status == KN_OK && extents->count > 0) *out = (span){down(lo[2]), up(hi[2])};
    return status;
}

static kn_status measure_block(kn_ctx *ctx, void *user, size_t block)
{
    const making *m = user;
    kn_job_slabs *s = m->slabs;
    kn_job_extents extents = {0};
    size_t first = block * BLOCK, end = first + BLOCK < s->ncells ? first + BLOCK : s->ncells;
    kn_status status = KN_OK;
    span *all = &s->blocks[block];
    *all = (span){INFINITY, -INFINITY};
    for (size_t i = first; status == KN_OK && i < end; i++) {
        span *group = &s->groups[i / GROUP];
        if (i % GROUP == 0) *group = (span){INFINITY, -INFINITY};
        status = measure_cell(ctx, &s->cells[i], m, &extents, i);
        if (status != KN_OK) break;
        widen(group, s->cells[i]);
        widen(all, s->cells[i]);
    }
    kn_job_extents_clear(ctx, &extents);
    return status;
}

void kn_job_slabs_destroy(kn_ctx *ctx, kn_job_slabs *slabs)
{
    if (!slabs) return;
    kn_free(ctx, slabs->cells);
    kn_free(ctx, slabs->groups);
    kn_free(ctx, slabs->blocks);
    kn_free(ctx, slabs);
}

kn_status kn_job_slabs_create(kn_ctx *ctx, kn_job_slabs **out, const kn_job *job)
{
    kn_job_slabs *s = kn_alloc_zero(ctx, 1, sizeof *s);
    if (!s) return KN_ENOMEM;
    making m = {.slabs = s};
    s->job = job;
    s->ncells = job->ncells;
    s->ngroups = (s->ncells + GROUP - 1) / GROUP;
    s->nblocks = (s->ncells + BLOCK - 1) / BLOCK;
    s->cells = kn_alloc(ctx, s->ncells, sizeof *s->cells);
    s->groups = kn_alloc(ctx, s->ngroups, sizeof *s->groups);
    s->blocks = kn_alloc(ctx, s->nblocks, sizeof *s->blocks);
    kn_status status = s->cells && s->groups && s->blocks ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) status = kn_job_bounds_init(ctx, &m.bounds, job);
    if (status == KN_OK) status = kn_parallel(ctx, s->nblocks, measure_block, &m, "slabs");
    kn_job_bounds_clear(ctx, &m.bounds);
    if (status == KN_OK)
        *out = s;
    else
        kn_job_slabs_destroy(ctx, s);
    return status;
}

void kn_job_slabs_range(const kn_job_slabs *slabs, double z[2])
{
    span all = {INFINITY, -INFINITY};
    for (size_t i = 0; i < slabs->nblocks; i++) widen(&all, slabs->blocks[i]);
    z[0] = all.lo, z[1] = all.hi;
}

static bool touches(span s, const double z[2])
{
    return s.lo <= s.hi && s.lo <= z[1] && s.hi >= z[0];
}

typedef struct found {
    kn_cell_range *list;
    size_t n, room;
} found;

static kn_status add(kn_ctx *ctx, found *f, size_t cell)
{
    if (f->n > 0 && f->list[f->n - 1].first + f->list[f->n - 1].count == cell) {
        f->list[f->n - 1].count++;
        return KN_OK;
    }
    if (f->n == f->room) {
        size_t room = f->room > 0 ? 2 * f->room : 16;
        kn_cell_range *list = kn_resize(ctx, f->list, room, sizeof *list);
        if (!list) return KN_ENOMEM;
        f->list = list;
        f->room = room;
    }
    f->list[f->n++] = (kn_cell_range){cell, 1};
    return KN_OK;
}

static kn_status find_in_group(kn_ctx *ctx, found *f, const kn_job_slabs *s, size_t group, const double z[2])
{
    size_t end = (group + 1) * GROUP < s->ncells ? (group + 1) * GROUP : s->ncells;
    kn_status status = KN_OK;
    for (size_t i = group * GROUP; status == KN_OK && i < end; i++)
        if (touches(s->cells[i], z)) status = add(ctx, f, i);
    return status;
}

kn_status kn_job_slabs_find(kn_ctx *ctx, kn_cell_range **ranges, size_t *n, const kn_job_slabs *slabs, double z0,
                            double z1)
{
    const double z[2] = {z0, z1};
    found f = {0};
    kn_status status = KN_OK;
    if (!(z0 <= z1)) return kn_fail(ctx, KN_EDOMAIN, "job: a slab from %g to %g", z0, z1);
    f.list = kn_alloc(ctx, f.room = 16, sizeof *f.list);
    if (!f.list) return KN_ENOMEM;
    for (size_t b = 0; status == KN_OK && b < slabs->nblocks; b++) {
        size_t end = (b + 1) * GROUP < slabs->ngroups ? (b + 1) * GROUP : slabs->ngroups;
        if (!touches(slabs->blocks[b], z)) continue;
        for (size_t g = b * GROUP; status == KN_OK && g < end; g++)
            if (touches(slabs->groups[g], z)) status = find_in_group(ctx, &f, slabs, g, z);
    }
    if (status == KN_OK)
        *ranges = f.list, *n = f.n;
    else
        kn_free(ctx, f.list);
    return status;
}
