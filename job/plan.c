// SPDX-License-Identifier: Apache-2.0
// The plan of a job: cells that ask for the same share one list, so that memory depends on how many different ones
// there are, and not on how many cells.
#include "job/internal.h"
#include "kernel/parallel.h"

#include <math.h>

enum {
    MOST_REFS = 1 << 20, // in all lists, beyond which cells have their own plans
    MOST_KEYS = 1 << 16,
    MOST_ALIKE = 1 << 18,
    MOST_CELLS = 64,       // planned by one thread together
    OWN_NUMBERS = 1 << 18, // coefficients of cells with their own plans that become one block
    OWN_CELLS = 4096,
};

// Plans of cells that follow one another, each of them for `cells` of one surface that are alike.
typedef struct entry {
    kn_job_cell_plan plan;
    size_t first_cell, cells;
} entry;
typedef struct bunch {
    entry *list;
    size_t count;
} bunch;

typedef struct planning {
    kn_job *job;
    size_t each; // cells of a bunch
    size_t room; // of job->alike
    kn_job_ref *refs;
    size_t refs_room;
} planning;

static int larger(int a, int b)
{
    return a > b ? a : b;
}

static void worsen(kn_normal_certificate *worst, const kn_normal_certificate *with)
{
    worst->length_error = fmax(worst->length_error, with->length_error);
    worst->angle_error = fmax(worst->angle_error, with->angle_error);
    worst->certified = worst->certified && with->certified;
}

static void drop_bunch(kn_ctx *ctx, void *user, void *made)
{
    (void)user;
    bunch *b = made;
    for (size_t i = 0; i < b->count; i++) kn_job_cell_plan_clear(ctx, &b->list[i].plan);
    kn_free(ctx, b->list);
    kn_free(ctx, b);
}

static bool alike(const kn_job_cell_plan *a, const kn_job_cell_plan *b)
{
    if (!a->shared || !b->shared || a->surface != b->surface || a->there != b->there || a->count != b->count)
        return false;
    for (int i = 0; i < a->count; i++)
        if (a->leaves[i].instance != b->leaves[i].instance || !kn_job_same_key(&a->leaves[i].key, &b->leaves[i].key))
            return false;
    return true;
}

// A plan like the one before it is counted there.
static void keep(kn_ctx *ctx, bunch *b, kn_job_cell_plan *plan, size_t cell)
{
    entry *last = b->count > 0 ? &b->list[b->count - 1] : NULL;
    kn_job_pieces_end(ctx, &plan->pieces);
    if (!last || !alike(&last->plan, plan)) {
        b->list[b->count++] = (entry){*plan, cell, 1};
        return;
    }
    worsen(&last->plan.normal, &plan->normal);
    last->plan.stand_in = fmax(last->plan.stand_in, plan->stand_in);
    last->plan.crossing = fmax(last->plan.crossing, plan->crossing);
    last->cells++;
    kn_job_cell_plan_clear(ctx, plan);
}

static kn_status plan_bunch(kn_ctx *ctx, void *user, size_t index, void **out)
{
    const planning *p = user;
    size_t first = index * p->each, rest = p->job->ncells - first, n = rest < p->each ? rest : p->each;
    bunch *b = kn_alloc_zero(ctx, 1, sizeof *b);
    if (!b) return KN_ENOMEM;
    b->list = kn_alloc_zero(ctx, n, sizeof *b->list);
    kn_status status = b->list ? KN_OK : KN_ENOMEM;
    for (size_t i = first; status == KN_OK && i < first + n; i++) {
        kn_job_cell_plan plan = {0};
        status = kn_job_plan_cell(ctx, &plan, p->job, i, true);
        if (status == KN_OK) keep(ctx, b, &plan, i);
    }
    if (status == KN_OK)
        *out = b;
    else
        drop_bunch(ctx, user, b);
    return status;
}

// ---- cells that share ----

static kn_status share_list(kn_ctx *ctx, planning *p, uint32_t *list, const entry *e)
{
    const kn_job_cell_plan *plan = &e->plan;
    kn_job *job = p->job;
    size_t n = (size_t)plan->count, numbers = 0, weights = 0;
    if (n > p->refs_room) {
        kn_job_ref *refs = kn_resize(ctx, p->refs, 2 * n, sizeof *refs);
        if (!refs) return KN_ENOMEM;
        p->refs = refs;
        p->refs_room = 2 * n;
    }
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        const kn_job_leaf *leaf = &plan->leaves[i];
        int degree[KN_JOB_VARS];
        p->refs[i].instance = (uint32_t)leaf->instance;
        status = kn_job_keys_add(ctx, &p->refs[i].key, &job->keys, &leaf->key);
        kn_job_leaf_degree(leaf, degree);
        numbers += kn_job_numbers(degree);
        weights += kn_job_numbers(degree) * kn_job_columns(&leaf->key);
    }
    if (status == KN_OK) status = kn_job_lists_add(ctx, list, &job->lists, p->refs, n);
    if (status == KN_OK) {
        job->lists.list[*list].numbers = numbers;
        job->lists.list[*list].weights = weights;
        job->lists.list[*list].uses += e->cells;
    }
    return status;
}

// ---- cells with plans of their own ----

static void count_leaf(kn_job_report *r, const kn_job *job, int nvars, const kn_job_key *key, const int *degree,
                       size_t uses)
{
    int segments[KN_JOB_VARS];
    kn_job_segments(job, key, segments);
    r->patches += uses;
    r->exact_patches += key->exact ? uses : 0;
    r->control_points += uses * kn_job_numbers(degree);
    if (nvars == 2 && !job->detail) r->triangles += uses * kn_job_triangles(nvars, segments, 0); // else: count_seen
    r->curves += nvars == 1 ? uses : 0;
    r->volumes += nvars == 3 ? uses : 0;
    int most = nvars == 3 ? larger(degree[0], larger(degree[1], degree[2])) : 0;
    for (int d = 0; d < 2; d++) r->degree[d] = larger(r->degree[d], larger(degree[d], most));
}

static void count_own(kn_job *job, kn_job_alike *to, const kn_job_cell_plan *plan)
{
    kn_job_report *r = &job->report;
    size_t ncomp = kn_job_components(&job->surfaces[plan->surface]);
    for (int i = 0; i < plan->count; i++) {
        const kn_job_leaf *leaf = &plan->leaves[i];
        int degree[KN_JOB_VARS] = {0};
        to->npatches++;
        if (leaf->mesh.position) {
            r->patches++;
            r->exact_patches++;
            r->meshes++;
            r->triangles += leaf->mesh.ntriangles;
            continue;
        }
        int nvars = leaf->made.coef ? leaf->made.nvars : kn_job_leaf_patch(plan, leaf)->d.nvars;
        kn_job_leaf_degree(leaf, degree);
        to->numbers += (leaf->made.coef ? (size_t)leaf->made.ncomp : ncomp) * kn_job_numbers(degree);
        count_leaf(r, job, nvars, &leaf->key, degree, 1);
    }
}

// ---- merging ----

// Triangles of volumes, of which each cell shows other faces, and of cells that each have their own detail.
static kn_status count_seen(kn_ctx *ctx, kn_job *job, const entry *e)
{
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < e->plan.count; i++) {
        const kn_job_leaf *leaf = &e->plan.leaves[i];
        if (leaf->mesh.position) continue;
        const kn_job_patch *patch = kn_job_leaf_patch(&e->plan, leaf);
        int nvars = leaf->made.coef ? leaf->made.nvars : patch->d.nvars;
        if (nvars != 3 && !job->detail) continue; // count_leaf
        for (size_t cell = e->first_cell; status == KN_OK && cell < e->first_cell + e->cells; cell++) {
            int segments[KN_JOB_VARS], surface, at[2];
            uint8_t hidden = 0;
            kn_job_segments(job, &leaf->key, segments);
            kn_job_coarsen(job, cell, segments);
            kn_job_locate(job, cell, &surface, at);
            if (nvars == 3) status = kn_job_hide_faces(ctx, &hidden, job, patch, &leaf->key.rect, surface, at);
            if (status == KN_OK) job->report.triangles += kn_job_triangles(nvars, segments, hidden);
        }
    }
    return status;
}

static kn_status merge(kn_ctx *ctx, planning *p, const entry *e)
{
    const kn_job_cell_plan *plan = &e->plan;
    kn_job *job = p->job;
    uint32_t list = KN_JOB_OWN;
    bool room = job->lists.nrefs < MOST_REFS && job->keys.count < MOST_KEYS && job->nalike < MOST_ALIKE;
    kn_status status = plan->shared && room ? share_list(ctx, p, &list, e) : KN_OK;
    if (status != KN_OK) return status;
    if (job->nalike + 2 > p->room) {
        size_t more = 2 * p->room + 8;
        kn_job_alike *alike = kn_resize(ctx, job->alike, more, sizeof *alike);
        if (!alike) return KN_ENOMEM;
        job->alike = alike;
        p->room = more;
    }
    kn_job_alike *last = job->nalike > 0 ? &job->alike[job->nalike - 1] : NULL;
    bool goes_on = last && last->list == list && e->first_cell != job->surfaces[plan->surface].first_cell;
    if (goes_on && list == KN_JOB_OWN)
        goes_on = last->numbers < OWN_NUMBERS && e->first_cell - last->first_cell < OWN_CELLS;
    if (!goes_on) {
        last = &job->alike[job->nalike++];
        *last = (kn_job_alike){.first_cell = e->first_cell, .list = list};
    }
    if (list == KN_JOB_OWN) count_own(job, last, plan);
    if (plan->there) job->report.cells += e->cells;
    return count_seen(ctx, job, e);
}

static kn_status commit(kn_ctx *ctx, void *user, size_t index, void *made)
{
    (void)index;
    planning *p = user;
    const bunch *b = made;
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < b->count; i++) {
        const kn_job_cell_plan *plan = &b->list[i].plan;
        status = merge(ctx, p, &b->list[i]);
        worsen(&p->job->report.normal, &plan->normal);
        p->job->report.stand_in_error = fmax(p->job->report.stand_in_error, plan->stand_in);
        p->job->report.crossing_error = fmax(p->job->report.crossing_error, plan->crossing);
        if (plan->trim_curves > p->job->report.trim_curves) p->job->report.trim_curves = plan->trim_curves;
        if (plan->trim_spans > p->job->report.trim_spans) p->job->report.trim_spans = plan->trim_spans;
    }
    drop_bunch(ctx, user, made);
    return status;
}

// ---- the whole ----

static void count_shared(kn_job *job)
{
    for (size_t l = 0; l < job->lists.count; l++) {
        const kn_job_list *list = &job->lists.list[l];
        for (size_t i = list->first; i < list->first + list->count; i++)
            job->keys.uses[job->lists.refs[i].key] += list->uses;
    }
    for (size_t i = 0; i < job->keys.count; i++) {
        const kn_job_key *key = &job->keys.list[i];
        const kn_job_patch *patch = &job->patches[key->patch];
        int degree[KN_JOB_VARS];
        kn_job_degree(key, degree);
        count_leaf(&job->report, job, patch->d.nvars, key, degree, job->keys.uses[i]);
    }
}

size_t kn_job_find_alike(const kn_job *job, size_t cell)
{
    size_t lo = 0, hi = job->nalike - 1;
    while (lo < hi) {
        size_t middle = (lo + hi + 1) / 2;
        if (job->alike[middle].first_cell <= cell)
            lo = middle;
        else
            hi = middle - 1;
    }
    return lo;
}

kn_status kn_job_plan(kn_ctx *ctx, kn_job *job)
{
    enum { AHEAD = 8 };
    size_t threads = (size_t)kn_ctx_threads(ctx), each = job->ncells / (4 * AHEAD * threads);
    each = each < 1 ? 1 : each > MOST_CELLS ? MOST_CELLS : each;
    planning p = {.job = job, .each = each};
    const kn_pipeline pipeline = {&p, plan_bunch, commit, drop_bunch};
    job->report.normal = (kn_normal_certificate){.certified = true};
    job->report.cells = 0;
    kn_status status = kn_pipeline_run(ctx, &pipeline, (job->ncells + each - 1) / each, AHEAD * threads, "plan");
    kn_free(ctx, p.refs);
    if (status != KN_OK) return status;
    job->alike[job->nalike] = (kn_job_alike){.first_cell = job->ncells};
    count_shared(job);
    return KN_OK;
}
