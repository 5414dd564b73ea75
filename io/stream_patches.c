// SPDX-License-Identifier: Apache-2.0
// Patches that no job composed, through the sinks of jobs: blocks of them are worked on by any thread and committed in
// order.
#include "kernel/context.h"
#include "kernel/parallel.h"

#include <knurl/io.h>

// A block is a share of all patches, whatever the number of threads is, and not more than 64.
enum { MOST_BLOCK = 64, SHARES = 64 };

static void count_patch(kn_job_report *r, const kn_patch *patch)
{
    kn_spline s = kn_patch_spline(patch);
    if (patch->mesh) {
        r->meshes++;
        r->triangles += patch->mesh->ntriangles;
        return;
    }
    r->control_points += kn_spline_count(&s);
    r->curves += s.nvars == 1;
    r->volumes += s.nvars == 3;
    for (int d = 0; d < s.nvars; d++)
        for (int k = 0; k < 2; k++) // of volumes the largest of all counts for both
            if ((s.nvars == 3 || d == k) && s.degree[d] > r->degree[k]) r->degree[k] = s.degree[d];
    const size_t n[3] = {(size_t)patch->segments[0], (size_t)patch->segments[1], (size_t)patch->segments[2]};
    if (s.nvars == 2) r->triangles += 2 * n[0] * n[1];
    if (s.nvars == 3) r->triangles += 4 * (n[0] * n[1] + n[0] * n[2] + n[1] * n[2]);
    if (!patch->trim) return;
    if (patch->bounds && patch->bounds->error > r->edge_error) r->edge_error = patch->bounds->error;
    size_t spans = 0;
    for (int i = 0; i < patch->trim->ncurves; i++)
        spans += (size_t)kn_spline_spans(&patch->trim->curves[i], 0) * (patch->trim->curves[i].degree[0] > 1 ? 8 : 1);
    if ((size_t)patch->trim->ncurves > r->trim_curves) r->trim_curves = (size_t)patch->trim->ncurves;
    if (spans > r->trim_spans) r->trim_spans = spans;
}

static kn_job_report survey(const kn_patch *patches, size_t n)
{
    kn_job_report r = {.nsurfaces = 1, .nparts = 1, .cells = 1, .patches = n, .exact_patches = n, .cell_size = 1.0};
    for (size_t i = 0; i < n; i++) {
        count_patch(&r, &patches[i]);
        if (patches[i].id.surface >= r.nsurfaces) r.nsurfaces = patches[i].id.surface + 1;
    }
    r.max_degree = r.degree[0] > r.degree[1] ? r.degree[0] : r.degree[1];
    return r;
}

// ---- the pipeline ----

typedef struct runner {
    const kn_patch *patches;
    size_t n, each; // each: of a block
    kn_sink *sinks;
    int nsinks;
} runner;

static kn_patch_block block_at(const runner *r, size_t index)
{
    size_t at = index * r->each, left = r->n - at;
    return (kn_patch_block){at, left < r->each ? left : r->each, r->patches + at};
}

// products: of each sink, from first_sink on not yet committed.
static void product_free(kn_ctx *ctx, const runner *r, void **products, int first_sink)
{
    for (int k = first_sink; products && k < r->nsinks; k++)
        if (products[k] && r->sinks[k].discard) r->sinks[k].discard(ctx, r->sinks[k].user, products[k]);
    kn_free(ctx, products);
}

static kn_status work(kn_ctx *worker, void *user, size_t index, void **out)
{
    const runner *r = user;
    const kn_patch_block block = block_at(r, index);
    void **products = kn_alloc_zero(worker, (size_t)r->nsinks + 1, sizeof *products);
    kn_status status = products ? KN_OK : KN_ENOMEM;
    for (int k = 0; status == KN_OK && k < r->nsinks; k++)
        if (r->sinks[k].work) status = r->sinks[k].work(worker, r->sinks[k].user, &block, &products[k]);
    if (status == KN_OK)
        *out = products;
    else
        product_free(worker, r, products, 0);
    return status;
}

static kn_status commit(kn_ctx *ctx, void *user, size_t index, void *made)
{
    runner *r = user;
    void **products = made;
    const kn_patch_block block = block_at(r, index);
    kn_status status = KN_OK;
    int k = 0;
    for (; status == KN_OK && k < r->nsinks; k++)
        status = r->sinks[k].commit(ctx, r->sinks[k].user, &block, products[k]);
    product_free(ctx, r, products, k);
    return status;
}

static void drop(kn_ctx *ctx, void *user, void *made)
{
    product_free(ctx, user, made, 0);
}

kn_status kn_stream_patches(kn_ctx *ctx, const kn_tile *tile, const kn_patch *patches, size_t n, double size,
                            kn_sink *sinks, int nsinks)
{
    kn_status status = KN_OK;
    kn_job_report report = survey(patches, n);
    if (size > 0.0) report.cell_size = size;
    for (int k = 0; k < nsinks; k++)
        if (!sinks[k].commit) return kn_fail(ctx, KN_EDOMAIN, "stream: sink %d has no commit", k);
    for (size_t i = 0; i < n; i++)
        if (patches[i].look < 0 || patches[i].look >= tile->nparts)
            return kn_fail(ctx, KN_EDOMAIN, "stream: patch %zu of part %d, of %d", i, patches[i].look, tile->nparts);
    for (int k = 0; status == KN_OK && k < nsinks; k++)
        if (sinks[k].begin) status = sinks[k].begin(ctx, sinks[k].user, tile, &report);
    const size_t each = n / SHARES < 1 ? 1 : n / SHARES > MOST_BLOCK ? MOST_BLOCK : n / SHARES;
    runner r = {patches, n, each, sinks, nsinks};
    const kn_pipeline pipeline = {&r, work, commit, drop};
    size_t ahead = 2 * (size_t)kn_ctx_threads(ctx) + 1;
    if (status == KN_OK) status = kn_pipeline_run(ctx, &pipeline, (n + each - 1) / each, ahead, "writing");
    for (int k = 0; status == KN_OK && k < nsinks; k++)
        if (sinks[k].end) status = sinks[k].end(ctx, sinks[k].user);
    return status;
}
