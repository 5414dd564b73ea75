// SPDX-License-Identifier: Apache-2.0
// Threads: an index range, and a pipeline whose products are committed in order.
#include "kernel/parallel.h"
#include "kernel/context.h"
#include "kernel/worker.h"

#include <pthread.h>

// ---- a team: one context and one thread per member; member 0 is the calling thread ----
typedef struct member {
    kn_ctx *worker;
    void (*run)(void *job, kn_ctx *worker);
    void *job;
    pthread_t thread;
} member;

typedef struct team {
    member *members;
    int size, running; // members[1 .. running-1] have threads
} team;

static void *member_main(void *arg)
{
    member *m = arg;
    m->run(m->job, m->worker);
    return NULL;
}

static void team_finish(kn_ctx *ctx, team *t)
{
    for (int i = 0; i < t->size; i++) kn_ctx_destroy(t->members[i].worker);
    kn_free(ctx, t->members);
}

static kn_status team_init(kn_ctx *ctx, team *t, size_t most)
{
    size_t threads = (size_t)kn_ctx_threads(ctx);
    int size = (int)(threads < most ? threads : most);
    *t = (team){.members = kn_alloc_zero(ctx, (size_t)size, sizeof *t->members), .running = 1};
    if (!t->members) return KN_ENOMEM;
    for (; t->size < size; t->size++)
        if (!(t->members[t->size].worker = kn_worker_create(ctx))) return KN_ENOMEM;
    return KN_OK;
}

// A thread that the system refuses is one thread less: the results do not depend on the number of threads.
static void team_start(team *t, void (*run)(void *, kn_ctx *), void *job)
{
    for (; t->running < t->size; t->running++) {
        member *m = &t->members[t->running];
        m->run = run;
        m->job = job;
        if (pthread_create(&m->thread, NULL, member_main, m) != 0) break;
    }
}

static void team_join(team *t)
{
    for (int i = 1; i < t->running; i++) (void)pthread_join(t->members[i].thread, NULL);
}

// ---- kn_parallel ----
typedef struct range {
    pthread_mutex_t mutex;
    size_t next, n, done;
    bool stop;
    kn_task task;
    void *user;
    // The lowest failing index. Indices start in order, so every index below one that has failed has started and
    // will be heard: the lowest one does not depend on timing.
    size_t failed;
    kn_status status;
    kn_ctx *failed_worker;
} range;

static bool range_take(range *r, size_t *index)
{
    (void)pthread_mutex_lock(&r->mutex);
    bool some = !r->stop && r->next < r->n;
    if (some) *index = r->next++;
    (void)pthread_mutex_unlock(&r->mutex);
    return some;
}

// Does one index and answers how many are done.
static size_t range_do(range *r, kn_ctx *worker, size_t index)
{
    kn_ctx_clear_error(worker);
    kn_status status = r->task(worker, r->user, index);
    (void)pthread_mutex_lock(&r->mutex);
    if (status != KN_OK) {
        if (r->status == KN_OK || index < r->failed) {
            r->failed = index;
            r->status = status;
            r->failed_worker = worker;
        }
        r->stop = true;
    }
    size_t done = ++r->done;
    (void)pthread_mutex_unlock(&r->mutex);
    return done;
}

static void range_run(void *job, kn_ctx *worker)
{
    range *r = job;
    size_t index;
    while (range_take(r, &index)) (void)range_do(r, worker, index);
}

static kn_status range_lead(kn_ctx *ctx, range *r, kn_ctx *worker, const char *stage)
{
    kn_status status = KN_OK;
    size_t index;
    while (status == KN_OK && range_take(r, &index)) {
        size_t done = range_do(r, worker, index);
        if (stage) status = kn_progress(ctx, stage, (double)done / (double)r->n);
    }
    if (status != KN_OK) {
        (void)pthread_mutex_lock(&r->mutex);
        r->stop = true;
        (void)pthread_mutex_unlock(&r->mutex);
    }
    return status;
}

kn_status kn_parallel(kn_ctx *ctx, size_t n, kn_task task, void *user, const char *stage)
{
    if (n == 0) return KN_OK;
    team t;
    kn_status status = team_init(ctx, &t, n);
    range r = {.n = n, .task = task, .user = user};
    if (status == KN_OK && pthread_mutex_init(&r.mutex, NULL) != 0)
        status = kn_fail(ctx, KN_ENOMEM, "no memory for a mutex");
    else if (status == KN_OK) {
        team_start(&t, range_run, &r);
        status = range_lead(ctx, &r, t.members[0].worker, stage);
        team_join(&t);
        if (status == KN_OK && r.status != KN_OK) status = kn_worker_report(ctx, r.failed_worker, r.status);
        (void)pthread_mutex_destroy(&r.mutex);
    }
    team_finish(ctx, &t);
    return status;
}

// ---- kn_pipeline_run ----
typedef struct slot {
    bool ready;
    kn_status status;
    void *product;
    kn_ctx *worker;
} slot;

typedef struct line {
    pthread_mutex_t mutex;
    pthread_cond_t change;
    const kn_pipeline *pipeline;
    size_t n, ahead, started, committed; // slots[i % ahead] belongs to committed <= i < committed + ahead
    slot *slots;
    bool stop;
} line;

// Starts the next index if there is room for its product. The mutex is held on entry and on return.
static bool line_work(line *l, kn_ctx *worker)
{
    if (l->stop || l->started >= l->n || l->started - l->committed >= l->ahead) return false;
    size_t index = l->started++;
    (void)pthread_mutex_unlock(&l->mutex);
    slot s = {.ready = true, .worker = worker};
    kn_ctx_clear_error(worker);
    s.status = l->pipeline->work(worker, l->pipeline->user, index, &s.product);
    (void)pthread_mutex_lock(&l->mutex);
    l->slots[index % l->ahead] = s;
    if (s.status != KN_OK) l->stop = true;
    (void)pthread_cond_broadcast(&l->change);
    return true;
}

static void line_run(void *job, kn_ctx *worker)
{
    line *l = job;
    (void)pthread_mutex_lock(&l->mutex);
    while (!l->stop && l->started < l->n)
        if (!line_work(l, worker)) (void)pthread_cond_wait(&l->change, &l->mutex);
    (void)pthread_mutex_unlock(&l->mutex);
}

// Commits the lowest index not yet committed, whose slot is ready. The mutex is held on entry and on return.
static kn_status line_commit(kn_ctx *ctx, line *l, const char *stage)
{
    slot *s = &l->slots[l->committed % l->ahead];
    slot taken = *s;
    s->ready = false;
    if (taken.status != KN_OK) return kn_worker_report(ctx, taken.worker, taken.status);
    size_t index = l->committed;
    (void)pthread_mutex_unlock(&l->mutex);
    kn_status status = l->pipeline->commit(ctx, l->pipeline->user, index, taken.product);
    if (status == KN_OK && stage) status = kn_progress(ctx, stage, (double)(index + 1) / (double)l->n);
    (void)pthread_mutex_lock(&l->mutex);
    l->committed++;
    (void)pthread_cond_broadcast(&l->change);
    return status;
}

// The calling thread: commit what is ready, else work, else wait. Failures are met in index order.
static kn_status line_lead(kn_ctx *ctx, line *l, kn_ctx *worker, const char *stage)
{
    kn_status status = KN_OK;
    (void)pthread_mutex_lock(&l->mutex);
    while (status == KN_OK && l->committed < l->n) {
        if (l->slots[l->committed % l->ahead].ready)
            status = line_commit(ctx, l, stage);
        else if (!line_work(l, worker))
            (void)pthread_cond_wait(&l->change, &l->mutex);
    }
    l->stop = true;
    (void)pthread_cond_broadcast(&l->change);
    (void)pthread_mutex_unlock(&l->mutex);
    return status;
}

static kn_status line_execute(kn_ctx *ctx, line *l, team *t, const char *stage)
{
    if (pthread_mutex_init(&l->mutex, NULL) != 0) return kn_fail(ctx, KN_ENOMEM, "no memory for a mutex");
    if (pthread_cond_init(&l->change, NULL) != 0) {
        (void)pthread_mutex_destroy(&l->mutex);
        return kn_fail(ctx, KN_ENOMEM, "no memory for a condition variable");
    }
    team_start(t, line_run, l);
    kn_status status = line_lead(ctx, l, t->members[0].worker, stage);
    team_join(t);
    for (size_t i = 0; i < l->ahead; i++) {
        const slot *s = &l->slots[i];
        if (s->ready && s->status == KN_OK && l->pipeline->drop)
            l->pipeline->drop(ctx, l->pipeline->user, s->product);
    }
    (void)pthread_cond_destroy(&l->change);
    (void)pthread_mutex_destroy(&l->mutex);
    return status;
}

kn_status kn_pipeline_run(kn_ctx *ctx, const kn_pipeline *pipeline, size_t n, size_t ahead, const char *stage)
{
    if (n == 0) return KN_OK;
    if (ahead == 0) ahead = 1;
    if (ahead > n) ahead = n;
    line l = {.pipeline = pipeline, .n = n, .ahead = ahead};
    team t;
    kn_status status = team_init(ctx, &t, ahead);
    if (status == KN_OK && !(l.slots = kn_alloc_zero(ctx, ahead, sizeof *l.slots))) status = KN_ENOMEM;
    if (status == KN_OK) status = line_execute(ctx, &l, &t, stage);
    kn_free(ctx, l.slots);
    team_finish(ctx, &t);
    return status;
}
