// SPDX-License-Identifier: Apache-2.0
// kn_slice_job: layer by layer, from the cells near each.
//
// Layers are taken in groups, as many as touch no more than MANY cells (or a single one): only these are composed,
// cut and forgotten again. A cell is composed as often as groups touch it.
#include "slice/internal.h"

enum { MANY = 2048 };

typedef struct work {
    const kn_job *const *jobs;
    kn_job_slabs **slabs;
    int njobs;
    const kn_slice_options *options;
    kn_slice_fn fn;
    void *user;
    kn_slice_job_report report;
} work;

static kn_status count_cells(kn_ctx *ctx, size_t *cells, const work *w, size_t first, size_t end)
{
    kn_status status = KN_OK;
    *cells = 0;
    for (int j = 0; status == KN_OK && j < w->njobs; j++) {
        kn_cell_range *ranges = NULL;
        size_t n = 0;
        status = kn_job_slabs_find(ctx, &ranges, &n, w->slabs[j], kn_slice_height(w->options, first),
                                   kn_slice_height(w->options, end - 1));
        for (size_t i = 0; status == KN_OK && i < n; i++) *cells += ranges[i].count;
        kn_free(ctx, ranges);
    }
    return status;
}

// The end of the group that begins at `first`: doubled while there are few cells.
static kn_status find_group(kn_ctx *ctx, size_t *end, size_t *cells, const work *w, size_t first)
{
    kn_status status = KN_OK;
    *end = first + 1;
    status = count_cells(ctx, cells, w, first, *end);
    for (size_t n = 2; status == KN_OK && *end < w->options->count && *cells < MANY; n *= 2) {
        size_t to = first + n < w->options->count ? first + n : w->options->count, more;
        status = count_cells(ctx, &more, w, first, to);
        if (status != KN_OK || more > MANY) break;
        *end = to;
        *cells = more;
    }
    return status;
}

static kn_status run_job(kn_ctx *ctx, const work *w, int j, kn_sink *sink, double lo, double hi)
{
    kn_cell_range *ranges = NULL;
    size_t n = 0;
    kn_status status = kn_job_slabs_find(ctx, &ranges, &n, w->slabs[j], lo, hi);
    kn_sink part = *sink; // it ends when all jobs have
    part.begin = NULL, part.end = NULL;
    if (status == KN_OK && n > 0) status = kn_job_run_cells(ctx, w->jobs[j], ranges, n, &part, 1);
    kn_free(ctx, ranges);
    return status;
}

static kn_status slice_group(kn_ctx *ctx, work *w, size_t first, size_t end)
{
    kn_slice_window window = {*w->options, first, end, 0.0, false};
    for (int j = 0; j < w->njobs; j++) {
        const kn_job_report report = kn_job_describe(w->jobs[j]);
        kn_slice_meet(&window, &report);
    }
    kn_sink sink = {0};
    kn_status status = kn_slice_window_sink(ctx, &sink, &window, w->fn, w->user);
    if (status != KN_OK) return status;
    for (int j = 0; status == KN_OK && j < w->njobs; j++)
        status = run_job(ctx, w, j, &sink, kn_slice_height(w->options, first), kn_slice_height(w->options, end - 1));
    if (status == KN_OK) status = sink.end(ctx, sink.user);
    kn_sink_close(ctx, &sink);
    return status;
}

static kn_status slice_all(kn_ctx *ctx, work *w)
{
    kn_status status = KN_OK;
    for (size_t first = 0, end, cells; status == KN_OK && first < w->options->count; first = end) {
        status = find_group(ctx, &end, &cells, w, first);
        if (status == KN_OK) status = slice_group(ctx, w, first, end);
        if (status == KN_OK) status = kn_progress(ctx, "slice", (double)end / (double)w->options->count);
        w->report.cells += cells;
        w->report.most_cells = cells > w->report.most_cells ? cells : w->report.most_cells;
        w->report.groups++;
    }
    return status;
}

kn_status kn_slice_job(kn_ctx *ctx, const kn_job *const *jobs, int njobs, const kn_slice_options *options,
                       kn_slice_fn fn, void *user, kn_slice_job_report *report)
{
    if (njobs < 1) return kn_fail(ctx, KN_EDOMAIN, "slice: %d jobs", njobs);
    kn_status status = kn_slice_check(ctx, options);
    if (status != KN_OK) return status;
    work w = {.jobs = jobs, .njobs = njobs, .options = options, .fn = fn, .user = user};
    w.slabs = kn_alloc_zero(ctx, (size_t)njobs, sizeof(kn_job_slabs *));
    if (!w.slabs) return KN_ENOMEM;
    for (int j = 0; status == KN_OK && j < njobs; j++) status = kn_job_slabs_create(ctx, &w.slabs[j], jobs[j]);
    if (status == KN_OK) status = slice_all(ctx, &w);
    if (status == KN_OK && report) *report = w.report;
    for (int j = 0; j < njobs; j++) kn_job_slabs_destroy(ctx, w.slabs[j]);
    kn_free(ctx, w.slabs);
    return status;
}
