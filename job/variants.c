// SPDX-License-Identifier: Apache-2.0
// The tile placed otherwise in its cell: affine maps, and the lists of patches that cells share.
#include "job/internal.h"

void kn_job_map_patch(kn_bezier *d, const double map[3][4])
{
    size_t n = kn_bezier_count(d);
    for (size_t i = 0; i < n; i++) {
        const double p[3] = {d->coef[i], d->coef[n + i], d->coef[2 * n + i]};
        for (size_t c = 0; c < 3; c++)
            d->coef[c * n + i] = map[c][0] * p[0] + map[c][1] * p[1] + map[c][2] * p[2] + map[c][3];
    }
}

bool kn_job_map_mirrors(const double map[3][4])
{
    double det = 0.0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        det += map[0][i] * (map[1][j] * map[2][k] - map[1][k] * map[2][j]);
    }
    return det < 0.0;
}

static kn_status change_patch(kn_ctx *ctx, void *user, kn_bezier *d, const kn_tile *tile, int part, int spline,
                              int patch)
{
    (void)ctx, (void)tile, (void)part, (void)spline, (void)patch;
    kn_job_map_patch(d, *(const double(*)[3][4])user);
    return KN_OK;
}

kn_status kn_job_add_variant(kn_ctx *ctx, int *variant, kn_job *job, const double map[3][4])
{
    double copy[3][4];
    for (int i = 0; i < 12; i++) copy[i / 4][i % 4] = map[i / 4][i % 4];
    kn_job_change change = {.user = copy, .apply = change_patch};
    kn_job_take_cuts(&change, job);
    kn_job_variant *list = kn_resize(ctx, job->variants, (size_t)job->nvariants + 1, sizeof *list);
    if (!list) return KN_ENOMEM;
    job->variants = list;
    kn_job_patches patches = {job->patches, job->npatches, job->npatches};
    kn_status status = kn_job_cut_patches(ctx, &patches, &job->tile, &job->options, &change);
    kn_job_variant v = {job->npatches, patches.n - job->npatches};
    job->patches = patches.list;
    job->npatches = patches.n;
    if (status != KN_OK) return status;
    for (int k = v.first; k < v.first + v.count; k++)
        job->patches[k].mirrored = kn_job_map_mirrors((const double(*)[4])copy);
    job->variants[job->nvariants] = v;
    *variant = job->nvariants++;
    return KN_OK;
}
