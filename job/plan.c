// SPDX-License-Identifier: Apache-2.0
// Which pieces of the shell each cell composes with which parts of the tile.
#include "job/internal.h"
#include "kernel/parallel.h"

#include <math.h>

// What one cell needs; made by any thread, merged in order and then forgotten.
typedef struct cell_plan {
    kn_job_key *keys;
    int count, room;
    kn_normal_certificate normal; // the worst of the pieces in use
    double stand_in;
} cell_plan;

typedef struct planning {
    kn_job *job;
    kn_job_keys keys;
    size_t room; // of job->leaves
} planning;

// What the recursion over one cell carries along.
typedef struct cell_work {
    const kn_job *job;
    int surface, cell[2]; // the tile's own
    kn_job_pieces pieces;
    cell_plan *plan;
} cell_work;

static void worsen(kn_normal_certificate *worst, const kn_normal_certificate *with)
{
    worst->length_error = fmax(worst->length_error, with->length_error);
    worst->angle_error = fmax(worst->angle_error, with->angle_error);
    worst->certified = worst->certified && with->certified;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

static kn_status add_leaf(kn_ctx *ctx, cell_work *w, int patch, kn_job_rect rect, int turn, bool whole,
                          const kn_shell_piece *piece)
{
    cell_plan *plan = w->plan;
    if (plan->count == plan->room) {
        int room = plan->room > 0 ? 2 * plan->room : w->job->npatches;
        kn_job_key *keys = kn_resize(ctx, plan->keys, (size_t)room, sizeof *keys);
        if (!keys) return KN_ENOMEM;
        plan->keys = keys;
        plan->room = room;
    }
    kn_job_key key = {.patch = patch, .rect = rect, .turn = (uint8_t)turn, .whole = whole, .exact = piece->exact};
    int factor = 1;
    key.nterms = (uint8_t)piece->nterms;
    for (int t = 0; t < piece->nterms; t++) {
        const int *degree = piece->term[t].degree;
        for (int d = 0; d < 2; d++) key.degree[t][d] = (uint8_t)degree[d];
        key.power[t] = (uint8_t)piece->power[t];
        factor = larger(factor, degree[0] + degree[1] + piece->power[t]);
    }
    key.factor = (uint8_t)factor;
    plan->keys[plan->count++] = key;
    worsen(&plan->normal, &piece->normal);
    plan->stand_in = fmax(plan->stand_in, piece->deviation * w->job->patches[patch].top);
    return KN_OK;
}

// Whether S is not one polynomial over the box: a line strictly inside it at which S has a knot, or the seam of a
// closed direction. Beyond open ends S's end pieces are extended.
static bool crosses_knot(const kn_job_surface *s, const int cell[2], const double lo[2], const double hi[2])
{
    for (int d = 0; d < 2; d++)
        for (double line = floor(lo[d]) + 1.0; line < hi[d]; line += 1.0) {
            int at = cell[d] + (int)line, n = s->cells[d];
            if (s->closed[d]) at = (at % n + n) % n;
            if (at < 0 || at > n || (!s->closed[d] && (at == 0 || at == n))) continue;
            if (s->knot[d][at]) return true;
        }
    return false;
}

static double spread(const kn_bezier *d)
{
    double lo[2], hi[2];
    kn_job_box(lo, hi, d);
    return (hi[0] - lo[0]) * (hi[0] - lo[0]) + (hi[1] - lo[1]) * (hi[1] - lo[1]);
}

// The variable whose bisection makes the two boxes smaller together.
static kn_status choose_cut(kn_ctx *ctx, int *var, const kn_bezier *d, kn_job_rect rect)
{
    kn_bezier left = {0}, right = {0};
    double size[KN_JOB_VARS] = {INFINITY, INFINITY, INFINITY};
    kn_status status = KN_OK;
    for (int v = 0; status == KN_OK && v < d->nvars; v++) {
        if (rect.level[v] == KN_JOB_MAX_DEPTH) continue;
        status = kn_bezier_subdivide(ctx, &left, &right, d, v, 0.5);
        if (status == KN_OK) size[v] = spread(&left) + spread(&right);
    }
    *var = 0;
    for (int v = 1; v < d->nvars; v++)
        if (size[v] < size[*var]) *var = v;
    kn_bezier_clear(ctx, &left);
    kn_bezier_clear(ctx, &right);
    return status;
}

static kn_status give_up(kn_ctx *ctx, const cell_work *w, int patch, bool crosses)
{
    const kn_job_patch *p = &w->job->patches[patch];
    const char *name = w->job->tile.parts[p->part].name;
    const kn_job_surface *s = &w->job->surfaces[w->surface];
    int cell[2] = {s->origin_cell[0] + w->cell[0], s->origin_cell[1] + w->cell[1]};
    if (crosses)
        return kn_fail(ctx, KN_EDOMAIN,
                       "job: patch %d of tile part \"%s\" crosses a knot line of surface %d in cell %d,%d, and not "
                       "along a parameter line of its own",
                       p->patch, name, s->origin, cell[0], cell[1]);
    return kn_fail(ctx, KN_EUNDECIDED,
                   "job: no normal of low degree within the tolerance for patch %d of tile part \"%s\" in cell %d,%d "
                   "of surface %d, after %d bisections each way",
                   p->patch, name, cell[0], cell[1], s->origin, KN_JOB_MAX_DEPTH);
}

// One part of a patch over the tight box around it, or, where no piece fits there, its halves.
static kn_status plan_rect(kn_ctx *ctx, cell_work *w, int patch, const kn_job_place *place, kn_job_rect rect)
{
    enum { CROSSING_DEPTH = 6 };
    kn_bezier d = {0};
    kn_status status = kn_job_restrict(ctx, &d, &w->job->patches[patch], rect, place->turn);
    if (status != KN_OK) return status;
    double lo[2], hi[2];
    kn_job_box(lo, hi, &d);
    int depth = rect.level[0] + rect.level[1] + rect.level[2], index = 0, var = 0;
    bool crosses = crosses_knot(&w->job->surfaces[place->surface], place->cell, lo, hi), fits = false;
    if (!crosses) {
        status = kn_job_pieces_get(ctx, &index, &w->pieces, place, lo, hi);
        fits = status == KN_OK && w->pieces.list[index].fits;
    }
    if (status == KN_OK && fits)
        status = add_leaf(ctx, w, patch, rect, place->turn, false, &w->pieces.list[index].piece);
    if (status == KN_OK && !fits) {
        if (depth >= (crosses ? CROSSING_DEPTH : d.nvars * KN_JOB_MAX_DEPTH))
            status = give_up(ctx, w, patch, crosses);
        else
            status = choose_cut(ctx, &var, &d, rect);
        for (int half = 0; status == KN_OK && half < 2; half++) {
            kn_job_rect part = rect;
            part.level[var]++;
            part.index[var] = (uint16_t)(2 * rect.index[var] + half);
            status = plan_rect(ctx, w, patch, place, part);
        }
    }
    kn_bezier_clear(ctx, &d);
    return status;
}

static kn_status plan_patch(kn_ctx *ctx, cell_work *w, int patch)
{
    static const double zero[2] = {0.0, 0.0}, one[2] = {1.0, 1.0};
    const kn_job_patch *p = &w->job->patches[patch];
    kn_job_place place = kn_job_find_place(w->job, w->surface, w->cell, p->offset);
    kn_job_rect all = {.level = {0}};
    if (p->inside) {
        int index;
        kn_status status = kn_job_pieces_get(ctx, &index, &w->pieces, &place, zero, one);
        if (status != KN_OK) return status;
        if (w->pieces.list[index].fits)
            return add_leaf(ctx, w, patch, all, place.turn, true, &w->pieces.list[index].piece);
    }
    return plan_rect(ctx, w, patch, &place, all);
}

static void drop_plan(kn_ctx *ctx, void *user, void *made)
{
    (void)user;
    cell_plan *plan = made;
    kn_free(ctx, plan->keys);
    kn_free(ctx, plan);
}

static kn_status plan_cell(kn_ctx *ctx, void *user, size_t index, void **out)
{
    const planning *p = user;
    cell_plan *plan = kn_alloc_zero(ctx, 1, sizeof *plan);
    if (!plan) return KN_ENOMEM;
    cell_work w = {.job = p->job, .plan = plan};
    kn_job_locate(p->job, index, &w.surface, w.cell);
    w.pieces.job = p->job;
    plan->normal.certified = true;
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < p->job->npatches; k++) status = plan_patch(ctx, &w, k);
    kn_job_pieces_end(ctx, &w.pieces);
    if (status == KN_OK)
        *out = plan;
    else
        drop_plan(ctx, user, plan);
    return status;
}

// ---- merging ----

static bool same_leaves(const uint32_t *a, const uint32_t *b, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (a[i] != b[i]) return false;
    return true;
}

// Appends a cell's leaves; cells like the one before them (the rule, on a regular surface) share its list.
static kn_status merge_cell(kn_ctx *ctx, planning *m, size_t cell, const cell_plan *plan)
{
    kn_job *job = m->job;
    size_t n = (size_t)plan->count;
    if (job->nleaves + n > m->room) {
        size_t room = 2 * m->room > job->nleaves + n ? 2 * m->room : job->nleaves + n;
        uint32_t *leaves = kn_resize(ctx, job->leaves, room, sizeof *leaves);
        if (!leaves) return KN_ENOMEM;
        job->leaves = leaves;
        m->room = room;
    }
    uint32_t *to = job->leaves + job->nleaves;
    for (size_t i = 0; i < n; i++) {
        kn_status status = kn_job_keys_add(ctx, &to[i], &m->keys, &plan->keys[i]);
        if (status != KN_OK) return status;
        m->keys.uses[to[i]]++;
    }
    const kn_job_cell *before = cell > 0 ? &job->cells[cell - 1] : NULL;
    if (before && before->count == n && same_leaves(job->leaves + before->first, to, n)) {
        job->cells[cell] = *before;
    } else {
        job->cells[cell] = (kn_job_cell){job->nleaves, (uint32_t)n};
        job->nleaves += n;
    }
    return KN_OK;
}

static kn_status commit(kn_ctx *ctx, void *user, size_t index, void *made)
{
    planning *p = user;
    const cell_plan *plan = made;
    kn_status status = merge_cell(ctx, p, index, plan);
    worsen(&p->job->report.normal, &plan->normal);
    p->job->report.stand_in_error = fmax(p->job->report.stand_in_error, plan->stand_in);
    drop_plan(ctx, user, made);
    return status;
}

void kn_job_segments(const kn_job *job, const kn_job_key *key, int segments[KN_JOB_VARS])
{
    for (int d = 0; d < KN_JOB_VARS; d++) segments[d] = larger(job->segments >> key->rect.level[d], 1);
}

static void count_all(kn_job *job)
{
    kn_job_report *r = &job->report;
    r->cells = job->ncells;
    for (size_t i = 0; i < job->nkeys; i++) {
        const kn_job_key *key = &job->keys[i];
        int degree[KN_JOB_VARS], segments[KN_JOB_VARS], nvars = job->patches[key->patch].d.nvars;
        kn_job_degree(job, key, degree);
        kn_job_segments(job, key, segments);
        r->patches += job->uses[i];
        if (nvars == 1) r->curves += job->uses[i];
        if (nvars == 3) r->volumes += job->uses[i];
        r->exact_patches += key->exact ? job->uses[i] : 0;
        r->control_points += job->uses[i] * (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1) *
                             (size_t)(degree[2] + 1);
        if (nvars == 2) r->triangles += job->uses[i] * 2 * (size_t)segments[0] * (size_t)segments[1];
        for (int d = 0; d < 2; d++) r->degree[d] = larger(r->degree[d], degree[d]);
    }
}

kn_status kn_job_plan(kn_ctx *ctx, kn_job *job)
{
    enum { AHEAD = 64 }; // for each thread: cells differ much in what they cost
    planning p = {.job = job};
    const kn_pipeline pipeline = {&p, plan_cell, commit, drop_plan};
    job->cells = kn_alloc_zero(ctx, job->ncells, sizeof *job->cells);
    job->report.normal = (kn_normal_certificate){.certified = true};
    kn_status status = job->cells ? KN_OK : KN_ENOMEM;
    size_t ahead = AHEAD * (size_t)kn_ctx_threads(ctx);
    if (status == KN_OK) status = kn_pipeline_run(ctx, &pipeline, job->ncells, ahead, "plan");
    job->keys = p.keys.list;
    job->uses = p.keys.uses;
    job->nkeys = p.keys.count;
    kn_free(ctx, p.keys.slot);
    if (status == KN_OK) count_all(job);
    return status;
}
