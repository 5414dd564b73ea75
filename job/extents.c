// SPDX-License-Identifier: Apache-2.0
// What the tiles of a cell occupy: boxes of (u, v, w), one for each cell that they reach into.
#include "job/placement.h"
#include "job/vary.h"

#include <math.h>

void kn_job_extents_clear(kn_ctx *ctx, kn_job_extents *e)
{
    kn_free(ctx, e->list);
    *e = (kn_job_extents){0};
}

// Widens the extent of the same offset, or appends one.
static kn_status add(kn_ctx *ctx, kn_job_extents *e, const kn_job_extent *one)
{
    for (int k = 0; k < e->count; k++) {
        kn_job_extent *to = &e->list[k];
        if (to->offset[0] != one->offset[0] || to->offset[1] != one->offset[1]) continue;
        for (int d = 0; d < 2; d++) to->lo[d] = fmin(to->lo[d], one->lo[d]), to->hi[d] = fmax(to->hi[d], one->hi[d]);
        to->w[0] = fmin(to->w[0], one->w[0]), to->w[1] = fmax(to->w[1], one->w[1]);
        to->drifts = to->drifts || one->drifts;
        return KN_OK;
    }
    if (e->count == e->room) {
        int room = e->room > 0 ? 2 * e->room : 4;
        kn_job_extent *list = kn_resize(ctx, e->list, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        e->list = list;
        e->room = room;
    }
    e->list[e->count++] = *one;
    return KN_OK;
}

static void range(double *lo, double *hi, const double *x, size_t n)
{
    *lo = *hi = x[0];
    for (size_t i = 1; i < n; i++) *lo = fmin(*lo, x[i]), *hi = fmax(*hi, x[i]);
}

static kn_status add_patches(kn_ctx *ctx, kn_job_extents *e, const kn_job_patch *list, int n)
{
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < n; k++) {
        size_t count = kn_bezier_count(&list[k].d);
        kn_job_extent one = {.offset = {list[k].offset[0], list[k].offset[1]}};
        for (int d = 0; d < 2; d++) range(&one.lo[d], &one.hi[d], list[k].d.coef + (size_t)d * count, count);
        range(&one.w[0], &one.w[1], list[k].d.coef + 2 * count, count);
        status = add(ctx, e, &one);
    }
    return status;
}

// A mesh is mapped vertex by vertex: a box for each cell that the box of all of them meets.
static kn_status add_mesh(kn_ctx *ctx, kn_job_extents *e, const kn_job *job, const kn_mesh *mesh,
                          const double *position, const double map[3][4])
{
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < mesh->nvertices; i++) {
        const double *p = position + 3 * i, w = kn_job_place_w(&job->options, p[2]);
        for (int c = 0; c < 3; c++) {
            double x = map[c][0] * p[0] + map[c][1] * p[1] + map[c][2] * w + map[c][3];
            lo[c] = fmin(lo[c], x), hi[c] = fmax(hi[c], x);
        }
    }
    kn_status status = KN_OK;
    for (int i = (int)floor(lo[0]); status == KN_OK && i < fmax(hi[0], floor(lo[0]) + 1.0); i++)
        for (int j = (int)floor(lo[1]); status == KN_OK && j < fmax(hi[1], floor(lo[1]) + 1.0); j++) {
            const int offset[2] = {i, j};
            kn_job_extent one = {.offset = {i, j}, .w = {lo[2], hi[2]}, .drifts = true};
            for (int d = 0; d < 2; d++) {
                one.lo[d] = fmin(fmax(lo[d] - offset[d], 0.0), 1.0);
                one.hi[d] = fmin(fmax(hi[d] - offset[d], 0.0), 1.0);
            }
            status = add(ctx, e, &one);
        }
    return status;
}

static kn_status add_meshes(kn_ctx *ctx, kn_job_extents *e, const kn_job *job, const double map[3][4])
{
    kn_status status = KN_OK;
    for (int p = 0; status == KN_OK && p < job->tile.nparts; p++) {
        const kn_mesh *mesh = &job->tile.parts[p].mesh;
        if (mesh->nvertices > 0) status = add_mesh(ctx, e, job, mesh, mesh->position, map);
    }
    return status;
}

// A tile that is not plain, as it is planned.
static kn_status add_own(kn_ctx *ctx, kn_job_extents *e, const kn_job *job, int surface, const int cell[2],
                         const kn_job_instance *instance)
{
    kn_job_patches own = {0};
    kn_status status = kn_job_cut_own(ctx, &own, job, surface, cell, instance);
    if (status == KN_OK) status = add_patches(ctx, e, own.list, own.n);
    kn_job_patches_clear(ctx, &own);
    if (status == KN_OK) status = add_meshes(ctx, e, job, instance->map);
    return status;
}

kn_status kn_job_cell_extents(kn_ctx *ctx, kn_job_extents *out, const kn_job *job, int surface, const int cell[2])
{
    kn_job_instance_list instances = {0};
    out->count = 0;
    kn_status status = kn_job_instances(ctx, &instances, job, surface, cell);
    for (int i = 0; status == KN_OK && i < instances.count; i++) {
        kn_job_instance *one = &instances.list[i];
        status = kn_job_vary_instance(ctx, one, job, surface, cell);
        if (status == KN_OK && !one->plain) {
            status = add_own(ctx, out, job, surface, cell, one);
        } else if (status == KN_OK) {
            const kn_job_variant *v = &job->variants[one->variant];
            status = add_patches(ctx, out, job->patches + v->first, v->count);
            if (status == KN_OK) status = add_meshes(ctx, out, job, (const double(*)[4])one->map);
        }
    }
    kn_free(ctx, instances.list);
    return status;
}
