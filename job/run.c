// SPDX-License-Identifier: Apache-2.0
// Running a job: blocks of cells are composed on any thread and committed in order.
#include "job/looks.h"
#include "job/run.h"
#include "kernel/parallel.h"

#include <math.h>
#include <stdatomic.h>
#include <time.h>

enum { STRIDE = 16 }; // blocks from one noted place to the next

// A place in the sequence of blocks of all ranges.
typedef struct place {
    kn_job_cursor at;
    size_t range;
} place;

typedef struct runner {
    const kn_job *job;
    kn_sink *sinks;
    int nsinks;
    kn_job_matrix *matrices;
    const kn_cell_range *ranges; // ascending and apart
    size_t nranges;
    place *noted; // where block STRIDE i begins
    size_t nblocks;
    const kn_job_notes *notes; // NULL: none
    size_t done;               // blocks before this run
    uint64_t identity;
    double noted_at;    // seconds
    struct home *homes; // one for each block in flight
    size_t nhomes;
} runner;

// Memory that blocks are composed into, one after the other.
typedef struct home {
    atomic_bool taken;
    _Atomic(const kn_ctx *) last; // whose processor's cache may hold it; NULL: nobody's
    kn_job_product kept;
} home;

typedef struct product {
    kn_job_product made;
    home *home; // where its memory goes
    void **of_sink;
    int nworked; // sinks whose product is in of_sink
} product;

// ---- the sequence of blocks ----

static place begin_range(const runner *r, size_t range, size_t patch)
{
    place p = {.range = range};
    if (range < r->nranges) p.at = kn_job_cursor_at(r->job, r->ranges[range].first, r->ranges[range].count);
    p.at.patch = patch;
    return p;
}

// Cells with plans of their own are kept several together, and may reach over the end of a range: those that begin
// before `done` are there already.
static bool next(kn_job_block *block, place *p, const runner *r)
{
    while (p->range < r->nranges) {
        if (kn_job_next_block(block, &p->at, r->job)) return true;
        size_t done = p->at.cell;
        place to = begin_range(r, p->range + 1, p->at.patch);
        if (to.range < r->nranges && to.at.cell < done) {
            size_t end = to.at.end;
            to.at = p->at;
            to.at.end = end > done ? end : done;
        }
        *p = to;
    }
    return false;
}

static kn_status note_blocks(kn_ctx *ctx, runner *r)
{
    place at = begin_range(r, 0, 0), before = at;
    kn_job_block block;
    size_t room = 0;
    for (; next(&block, &at, r); before = at, r->nblocks++) {
        size_t i = r->nblocks / STRIDE;
        if (r->nblocks % STRIDE != 0) continue;
        if (i == room) {
            room = 2 * room + 16;
            place *noted = kn_resize(ctx, r->noted, room, sizeof *noted);
            if (!noted) return KN_ENOMEM;
            r->noted = noted;
        }
        r->noted[i] = before;
    }
    return KN_OK;
}

static void find_block(kn_job_block *block, const runner *r, size_t index)
{
    place at = r->noted[index / STRIDE];
    for (size_t i = 0; i <= index % STRIDE; i++) (void)next(block, &at, r);
}

// ---- notes ----

static double now(void)
{
    struct timespec t;
    (void)timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static kn_status note_when_due(kn_ctx *ctx, runner *r, size_t done)
{
    double seconds = r->notes->seconds == 0.0 ? 5.0 : r->notes->seconds, time = now();
    if (time >= r->noted_at && time < r->noted_at + seconds) return KN_OK;
    const kn_job_state state = {.identity = r->identity, .done = done, .nblocks = r->nblocks};
    unsigned char *data = NULL;
    size_t bytes = 0;
    kn_status status = kn_job_save_state(ctx, &data, &bytes, &state, r->sinks, r->nsinks);
    if (status == KN_OK) status = r->notes->note(ctx, r->notes->user, data, bytes);
    kn_free(ctx, data);
    r->noted_at = now();
    return status;
}

// The sinks begin, or are as they were.
static kn_status begin_sinks(kn_ctx *ctx, runner *r)
{
    kn_status status = KN_OK;
    if (r->notes) {
        for (int k = 0; k < r->nsinks; k++)
            if (!r->sinks[k].save || !r->sinks[k].restore)
                return kn_fail(ctx, KN_EDOMAIN, "job: sink %d cannot be interrupted and gone on with", k);
        r->identity = kn_job_identity(r->job, r->notes->identity);
        r->noted_at = -INFINITY;
    }
    if (r->notes && r->notes->state) {
        kn_job_state state = {r->identity, 0, r->nblocks, r->notes->state, r->notes->bytes};
        status = kn_job_restore_state(ctx, &state, r->job, r->sinks, r->nsinks);
        r->done = state.done;
        return status;
    }
    for (int k = 0; status == KN_OK && k < r->nsinks; k++)
        if (r->sinks[k].begin)
            status = r->sinks[k].begin(ctx, r->sinks[k].user, kn_job_look_tile(r->job), &r->job->report);
    return status;
}

// ---- the pipeline ----

static home *take_free(const runner *r, const kn_ctx *last)
{
    for (size_t i = 0; i < r->nhomes; i++) {
        home *h = &r->homes[i];
        if (atomic_load_explicit(&h->last, memory_order_relaxed) != last) continue;
        if (!atomic_exchange_explicit(&h->taken, true, memory_order_acquire)) return h;
    }
    return NULL;
}

// One that the worker has had before, or a new one, or any: one is free, for there are as many as blocks in flight.
static home *take_home(const runner *r, const kn_ctx *worker)
{
    home *h = take_free(r, worker);
    if (!h) h = take_free(r, NULL);
    for (size_t i = 0; !h; i = (i + 1) % r->nhomes)
        if (!atomic_exchange_explicit(&r->homes[i].taken, true, memory_order_acquire)) h = &r->homes[i];
    atomic_store_explicit(&h->last, worker, memory_order_relaxed);
    return h;
}

static kn_status make_homes(kn_ctx *ctx, runner *r, size_t n)
{
    r->homes = kn_alloc(ctx, n, sizeof *r->homes);
    if (!r->homes) return KN_ENOMEM;
    for (r->nhomes = 0; r->nhomes < n; r->nhomes++) {
        atomic_init(&r->homes[r->nhomes].taken, false);
        atomic_init(&r->homes[r->nhomes].last, NULL);
        r->homes[r->nhomes].kept = (kn_job_product){0};
    }
    return KN_OK;
}

static void end_homes(kn_ctx *ctx, runner *r)
{
    for (size_t i = 0; i < r->nhomes; i++) kn_job_product_clear(ctx, &r->homes[i].kept);
    kn_free(ctx, r->homes);
}

static void product_free(kn_ctx *ctx, const runner *r, product *p, int first_sink)
{
    for (int k = first_sink; p->of_sink && k < p->nworked; k++)
        if (r->sinks[k].discard && p->of_sink[k]) r->sinks[k].discard(ctx, r->sinks[k].user, p->of_sink[k]);
    kn_job_product_empty(ctx, &p->made);
    p->home->kept = p->made;
    atomic_store_explicit(&p->home->taken, false, memory_order_release);
    kn_free(ctx, p->of_sink);
    kn_free(ctx, p);
}

static kn_status work(kn_ctx *worker, void *user, size_t index, void **out)
{
    const runner *r = user;
    kn_job_block block;
    find_block(&block, r, r->done + index);
    product *p = kn_alloc_zero(worker, 1, sizeof *p);
    if (!p) return KN_ENOMEM;
    p->home = take_home(r, worker);
    p->made = p->home->kept;
    p->of_sink = kn_alloc_zero(worker, (size_t)r->nsinks, sizeof *p->of_sink);
    kn_status status = p->of_sink ? kn_job_compose_block(worker, &p->made, r->job, r->matrices, &block) : KN_ENOMEM;
    for (; status == KN_OK && p->nworked < r->nsinks; p->nworked++) {
        const kn_sink *sink = &r->sinks[p->nworked];
        if (sink->work) status = sink->work(worker, sink->user, &p->made.block, &p->of_sink[p->nworked]);
    }
    if (status == KN_OK)
        *out = p;
    else
        product_free(worker, r, p, 0);
    return status;
}

static kn_status commit(kn_ctx *ctx, void *user, size_t index, void *made)
{
    runner *r = user;
    product *p = made;
    kn_status status = KN_OK;
    int k = 0;
    for (; status == KN_OK && k < r->nsinks; k++)
        status = r->sinks[k].commit(ctx, r->sinks[k].user, &p->made.block, p->of_sink[k]);
    product_free(ctx, r, p, k);
    if (status == KN_OK && r->notes && r->notes->note) status = note_when_due(ctx, r, r->done + index + 1);
    return status;
}

static void drop(kn_ctx *ctx, void *user, void *made)
{
    product_free(ctx, user, made, 0);
}

static kn_status check_ranges(kn_ctx *ctx, const kn_job *job, const kn_cell_range *ranges, size_t n)
{
    for (size_t i = 0, end = 0; i < n; end = ranges[i].first + ranges[i].count, i++)
        if (ranges[i].count < 1 || ranges[i].first < end || ranges[i].first >= job->ncells ||
            ranges[i].count > job->ncells - ranges[i].first)
            return kn_fail(ctx, KN_EDOMAIN, "job: cells %zu and %zu more, of %zu in order", ranges[i].first,
                           ranges[i].count, job->ncells);
    return KN_OK;
}

static kn_status run(kn_ctx *ctx, runner *r)
{
    const kn_job *job = r->job;
    const kn_pipeline pipeline = {r, work, commit, drop};
    for (int k = 0; k < r->nsinks; k++)
        if (!r->sinks[k].commit) return kn_fail(ctx, KN_EDOMAIN, "job: sink %d is closed, or has no commit", k);
    kn_status status = check_ranges(ctx, job, r->ranges, r->nranges);
    if (status == KN_OK) status = note_blocks(ctx, r);
    if (status == KN_OK) status = begin_sinks(ctx, r);
    // Files that have begun are known from here on, whatever becomes of the run.
    if (status == KN_OK && r->notes && r->notes->note) status = note_when_due(ctx, r, r->done);
    if (status == KN_OK) status = kn_job_make_matrices(ctx, &r->matrices, job);
    size_t ahead = 2 * (size_t)kn_ctx_threads(ctx) + 1;
    if (status == KN_OK) status = make_homes(ctx, r, ahead);
    if (status == KN_OK) status = kn_pipeline_run(ctx, &pipeline, r->nblocks - r->done, ahead, "compose");
    for (int k = 0; status == KN_OK && k < r->nsinks; k++)
        if (r->sinks[k].end) status = r->sinks[k].end(ctx, r->sinks[k].user);
    end_homes(ctx, r);
    kn_job_free_matrices(ctx, job, r->matrices);
    kn_free(ctx, r->noted);
    return status;
}

kn_status kn_job_run_from(kn_ctx *ctx, const kn_job *job, kn_sink *sinks, int nsinks, const kn_job_notes *notes)
{
    const kn_cell_range all = {0, job->ncells};
    runner r = {.job = job, .sinks = sinks, .nsinks = nsinks, .ranges = &all, .nranges = 1, .notes = notes};
    return run(ctx, &r);
}

kn_status kn_job_run(kn_ctx *ctx, const kn_job *job, kn_sink *sinks, int nsinks)
{
    return kn_job_run_from(ctx, job, sinks, nsinks, NULL);
}

kn_status kn_job_run_cells(kn_ctx *ctx, const kn_job *job, const kn_cell_range *ranges, size_t n, kn_sink *sinks,
                           int nsinks)
{
    runner r = {.job = job, .sinks = sinks, .nsinks = nsinks, .ranges = ranges, .nranges = n};
    return run(ctx, &r);
}
