// SPDX-License-Identifier: Apache-2.0
// What the tests of sinks share.
#include "tests/support/patches.h"

#include <stdio.h>

void test_tile_make(test_tile *out, int nparts)
{
    static const char *const names[3] = {"link", "wire rod", "it's"};
    *out = (test_tile){.tile = {.nparts = nparts}};
    for (int i = 0; i < nparts; i++) {
        kn_tile_part *part = &out->part[i];
        snprintf(part->name, sizeof part->name, "%s", names[i]);
        part->material = (kn_material){
            .base_color = {0.25 + 0.25 * i, 0.5, 0.125}, .metallic = 1.0, .roughness = 0.5};
    }
    out->tile.parts = out->part;
}

kn_job_report test_report(size_t patches, int degree_r, int degree_t)
{
    return (kn_job_report){.nsurfaces = 1, .patches = patches, .degree = {degree_r, degree_t}, .cell_size = 1.0};
}

void test_patch(kn_ctx *ctx, kn_patch *out, test_rng *rng, int m, int n, bool rational, double x0, double bump)
{
    const int degree[2] = {m, n};
    *out = (kn_patch){.segments = {4, 3}, .exact = true};
    assert_int_equal(kn_bezier_init(ctx, &out->bezier, 2, rational ? 4 : 3, rational, degree), KN_OK);
    size_t count = kn_bezier_count(&out->bezier);
    double *p = out->bezier.coef;
    for (int i = 0; i <= m; i++)
        for (int j = 0; j <= n; j++) {
            size_t k = (size_t)(i * (n + 1) + j);
            double w = rational ? test_uniform(rng, 1.0, 2.0) : 1.0;
            p[k] = w * (x0 + (double)i / m + test_uniform(rng, -bump, bump));
            p[count + k] = w * ((double)j / n + test_uniform(rng, -bump, bump));
            p[2 * count + k] = w * test_uniform(rng, -bump, bump);
            if (rational) p[3 * count + k] = w;
        }
}

kn_status test_feed(kn_ctx *ctx, kn_sink *sink, const kn_tile *tile, const kn_job_report *report,
                    const kn_patch *patches, size_t count, size_t block)
{
    kn_status status = sink->begin != NULL ? sink->begin(ctx, sink->user, tile, report) : KN_OK;
    for (size_t at = 0; at < count && status == KN_OK; at += block) {
        kn_patch_block b = {at, count - at < block ? count - at : block, patches + at};
        void *product = NULL;
        if (sink->work != NULL) status = sink->work(ctx, sink->user, &b, &product);
        if (status == KN_OK) status = sink->commit(ctx, sink->user, &b, product);
    }
    if (status == KN_OK && sink->end != NULL) status = sink->end(ctx, sink->user);
    return status;
}
