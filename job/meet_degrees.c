// SPDX-License-Identifier: Apache-2.0
// The degrees of patches that interpolate (meet.c): each direction of a patch takes the least degree in which those
// that have to share it come near enough. Opposite edges of a patch have one degree, and so have edges that coincide:
// through a row of cells it goes on, and what is sharp in one row costs nothing in others.
#include "job/internal.h"
#include "kernel/context.h"
#include "kernel/hash.h"
#include "kernel/parallel.h"
#include "kernel/union_find.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    EASY = 12,    // a degree that most patches need less than, tried first
    HIGHEST = 32, // Bernstein coefficients may be 2^degree times as large as the part of that degree
};

// What a patch needs along r and t (0: it does not interpolate), in which cell it lies and on which of its borders
// (bits) edges along r and t do, and a number for each edge that is the same for edges with the same control points:
// those along r, then those along t.
typedef struct note {
    uint8_t need[2], borders[2];
    int surface, cell[2];
    uint64_t edge[4];
} note;

// Notes of the patches of one cell, in the order in which it is planned.
typedef struct notes {
    note *list;
    size_t count, room;
} notes;

struct kn_job_meeting {
    bool noting;   // else degrees are known
    size_t *cells; // before each surface's first one: of surfaces whose patches interpolate; and of all
    notes *of;     // each of these cells, while noting
    size_t *first; // patches before each of them, and of all
    size_t count;  // of all
    uint8_t (*degree)[2];
    uint8_t *fate; // kn_job_meeting_fate of each
};

static void free_notes(kn_ctx *ctx, const kn_job *job, struct kn_job_meeting *m)
{
    for (size_t i = 0; m->of && i < m->cells[job->nsurfaces]; i++) kn_free(ctx, m->of[i].list);
    kn_free(ctx, m->of);
    m->of = NULL;
}

void kn_job_meeting_free(kn_ctx *ctx, kn_job *job)
{
    struct kn_job_meeting *m = job->meeting;
    if (!m) return;
    free_notes(ctx, job, m);
    kn_free(ctx, m->cells);
    kn_free(ctx, m->first);
    kn_free(ctx, m->degree);
    kn_free(ctx, m->fate);
    kn_free(ctx, m);
    job->meeting = NULL;
}

bool kn_job_notes_meeting(const kn_job *job)
{
    return job->meeting && job->meeting->noting;
}

bool kn_job_may_meet(const kn_job_cell_plan *plan, const kn_job_place *place)
{
    const kn_job_surface *s = &plan->job->surfaces[place->surface];
    return s->meets && plan->job->surfaces[plan->surface].meets && place->cell[0] >= 0 &&
           place->cell[0] < s->cells[0] && place->cell[1] >= 0 && place->cell[1] < s->cells[1];
}

static size_t cell_number(const kn_job *job, int surface, const int cell[2])
{
    size_t columns = (size_t)job->surfaces[surface].cells[1];
    return job->meeting->cells[surface] + (size_t)cell[0] * columns + (size_t)cell[1];
}

static size_t slot_of(const kn_job_cell_plan *plan, int number)
{
    return plan->job->meeting->first[cell_number(plan->job, plan->surface, plan->cell)] + (size_t)number;
}

static int highest(const kn_job *job)
{
    return job->options.max_degree < HIGHEST ? job->options.max_degree : HIGHEST;
}

void kn_job_meeting_degree(int degree[2], const kn_job_cell_plan *plan, int number)
{
    const struct kn_job_meeting *m = plan->job->meeting;
    for (int v = 0; v < 2; v++) degree[v] = m->degree[slot_of(plan, number)][v];
}

kn_job_meeting_fate kn_job_fate_of(const kn_job_cell_plan *plan, int number)
{
    return (kn_job_meeting_fate)plan->job->meeting->fate[slot_of(plan, number)];
}

void kn_job_set_fate(const kn_job_cell_plan *plan, int number, kn_job_meeting_fate fate)
{
    uint8_t *known = &plan->job->meeting->fate[slot_of(plan, number)];
    if (*known == KN_JOB_UNKNOWN) *known = (uint8_t)fate; // threads that run only read it
}

// ---- notes ----

static uint64_t add_number(uint64_t h, double x)
{
    uint64_t bits;
    x += 0.0; // of -0
    memcpy(&bits, &x, sizeof bits);
    return kn_hash_add(h, bits);
}

// Edge `end` along variable var.
static void note_edge(note *to, const kn_bezier *d, int var, int end)
{
    size_t n = kn_bezier_count(d), columns = (size_t)d->degree[1] + 1;
    size_t step = var == 0 ? columns : 1, across = var == 0 ? 1 : columns;
    size_t first = end ? across * (size_t)d->degree[1 - var] : 0;
    uint64_t forward = 1, backward = 1;
    int last = d->degree[var], on = 15;
    for (int i = 0; i <= last; i++)
        for (size_t c = 0; c < 3; c++) {
            double x = d->coef[c * n + first + (size_t)i * step];
            forward = add_number(forward, x);
            backward = add_number(backward, d->coef[c * n + first + (size_t)(last - i) * step]);
            if (c < 2 && x != 0.0) on &= ~(1 << 2 * c);
            if (c < 2 && x != 1.0) on &= ~(2 << 2 * c);
        }
    to->borders[var] = (uint8_t)(to->borders[var] | on);
    to->edge[2 * var + end] = forward + backward;
}

// The least degree along variable v that leaves out less than the tolerance: of Chebyshev coefficients of what was
// sampled in degree p, those above it, the largest sum of all lines.
static int degree_along(int v, const double *at, int p, double tolerance)
{
    const double pi = 3.14159265358979323846;
    double rest[KN_MAX_DEGREE + 1] = {0.0}, wave[2 * KN_MAX_DEGREE];
    size_t n = (size_t)p + 1, step = v == 0 ? n : 1, across = v == 0 ? 1 : n;
    for (int k = 0; k < 2 * p; k++) wave[k] = cos(pi * k / p);
    for (size_t line = 0; line < n; line++) {
        double tail = 0.0;
        for (int k = p; k > 0; k--) {
            double sum[3] = {0.0, 0.0, 0.0};
            for (int j = 0; j <= p; j++) {
                double w = wave[j * k % (2 * p)] * (j == 0 || j == p ? 0.5 : 1.0);
                for (size_t c = 0; c < 3; c++) sum[c] += w * at[c * n * n + line * across + (size_t)j * step];
            }
            tail += 2.0 / p * sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
            rest[k - 1] = fmax(rest[k - 1], tail);
        }
    }
    int degree = 1;
    while (degree < p && rest[degree] > tolerance) degree++;
    return degree;
}

static kn_status find_need(kn_ctx *ctx, int need[2], const kn_job *job, const kn_job_place *place, const kn_bezier *d,
                           int p)
{
    double tolerance = 0.5 * job->report.normal_tol * job->meeting_height;
    size_t sites = (size_t)((p + 1) * (p + 1));
    kn_mark mark = kn_scratch_mark(ctx);
    double *at = kn_scratch(ctx, 3 * sites, sizeof *at);
    kn_status status = at ? kn_job_sample(ctx, at, job, place, d, (const int[2]){p, p}) : KN_ENOMEM;
    for (int v = 0; v < 2 && status == KN_OK; v++) need[v] = degree_along(v, at, p, tolerance);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status note_patch(kn_ctx *ctx, note *to, const kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                            const kn_job_place *place)
{
    const kn_job *job = plan->job;
    int most = highest(job), p = most < EASY ? most : EASY, need[2] = {1, 1};
    kn_bezier d = {0};
    kn_status status = kn_job_restrict(ctx, &d, kn_job_leaf_patch(plan, leaf), leaf->key.rect, place->turn);
    if (status == KN_OK) status = find_need(ctx, need, job, place, &d, p);
    if (status == KN_OK && p < most && (need[0] >= p - 1 || need[1] >= p - 1)) // aliases, perhaps
        status = find_need(ctx, need, job, place, &d, most);
    if (status == KN_EUNDEFINED) { // no normal somewhere: stand-ins stay
        kn_ctx_clear_error(ctx);
        status = KN_OK;
    }
    to->surface = place->surface, to->cell[0] = place->cell[0], to->cell[1] = place->cell[1];
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        to->need[v] = (uint8_t)need[v];
        for (int end = 0; end < 2; end++) note_edge(to, &d, v, end);
    }
    kn_bezier_clear(ctx, &d);
    return status;
}

kn_status kn_job_note_meeting(kn_ctx *ctx, const kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                              const kn_job_place *place, bool can)
{
    notes *of = &plan->job->meeting->of[cell_number(plan->job, plan->surface, plan->cell)];
    kn_status status = kn_make_room(ctx, (void **)&of->list, &of->room, of->count + 1, sizeof *of->list);
    if (status != KN_OK) return status;
    note *to = &of->list[of->count++];
    *to = (note){.need = {0, 0}};
    return can ? note_patch(ctx, to, plan, leaf, place) : KN_OK;
}

static kn_status note_cell(kn_ctx *ctx, void *user, size_t index)
{
    const kn_job *job = user;
    kn_job_cell_plan plan = {0};
    int surface, cell[2];
    kn_job_locate(job, index, &surface, cell);
    if (!job->surfaces[surface].meets) return KN_OK;
    kn_status status = kn_job_plan_cell(ctx, &plan, job, index, true);
    if (status == KN_OK) kn_job_pieces_end(ctx, &plan.pieces);
    if (status == KN_OK) kn_job_cell_plan_clear(ctx, &plan);
    return status;
}

// ---- what has one degree ----

// Nodes: two of each patch (along r, along t), then four of each cell: what lies along its borders.
static int border_node(const kn_job *job, int surface, int i, int j, int border)
{
    return (int)(2 * job->meeting->count + 4 * cell_number(job, surface, (const int[2]){i, j})) + border;
}

typedef struct edge {
    uint64_t number; // of the cell, too
    int node;
} edge;

static int compare(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    return x->number != y->number ? (x->number < y->number ? -1 : 1) : x->node - y->node;
}

// Of patches in one cell, wherever they were planned; edges: room for four of each patch.
static void unite_inside(const kn_job *job, int *parent, edge *edges)
{
    const struct kn_job_meeting *m = job->meeting;
    size_t n = 0, slot = 0;
    for (size_t i = 0; i < m->cells[job->nsurfaces]; i++)
        for (size_t k = 0; k < m->of[i].count; k++, slot++) {
            const note *from = &m->of[i].list[k];
            if (from->need[0] == 0) continue;
            uint64_t cell = cell_number(job, from->surface, from->cell);
            for (int v = 0; v < 2; v++) {
                int node = (int)(2 * slot) + v;
                for (int end = 0; end < 2; end++)
                    edges[n++] = (edge){kn_hash_add(from->edge[2 * v + end], cell), node};
                for (int b = 0; b < 4; b++)
                    if (from->borders[v] >> b & 1)
                        kn_class_unite(parent, node,
                                       border_node(job, from->surface, from->cell[0], from->cell[1], b));
            }
        }
    qsort(edges, n, sizeof *edges, compare);
    for (size_t k = 1; k < n; k++)
        if (edges[k].number == edges[k - 1].number) kn_class_unite(parent, edges[k].node, edges[k - 1].node);
}

// Of neighbours, over the edges of the surface too.
static void unite_borders(const kn_job *job, int *parent, int surface)
{
    const kn_job_surface *s = &job->surfaces[surface];
    int m = s->cells[0], n = s->cells[1];
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) {
            if (i + 1 < m || s->closed[0])
                kn_class_unite(parent, border_node(job, surface, i, j, 1),
                               border_node(job, surface, (i + 1) % m, j, 0));
            if (j + 1 < n || s->closed[1])
                kn_class_unite(parent, border_node(job, surface, i, j, 3),
                               border_node(job, surface, i, (j + 1) % n, 2));
        }
    for (int e = 0; e < 4; e++) {
        const kn_job_partner *p = &s->partner[e];
        if (!kn_job_meets(job, surface, e) || !job->surfaces[p->edge / 4].meets) continue;
        int along = s->cells[1 - (e >> 1)], f = p->edge % 4;
        for (int k = 0; k < along; k++) {
            const kn_job_surface *other = &job->surfaces[p->edge / 4];
            int here[2], there[2];
            here[e >> 1] = e % 2 ? s->cells[e >> 1] - 1 : 0;
            here[1 - (e >> 1)] = k;
            there[f >> 1] = f % 2 ? other->cells[f >> 1] - 1 : 0;
            there[1 - (f >> 1)] = p->reversed ? along - 1 - k : k;
            kn_class_unite(parent, border_node(job, surface, here[0], here[1], e),
                           border_node(job, p->edge / 4, there[0], there[1], f));
        }
    }
}

// The degree of each patch: the largest need of all that have to share it.
static void take_degrees(const kn_job *job, int *parent, uint8_t *most)
{
    struct kn_job_meeting *m = job->meeting;
    size_t ncells = m->cells[job->nsurfaces], slot = 0;
    for (size_t i = 0; i < ncells; i++)
        for (size_t k = 0; k < 2 * m->of[i].count; k++, slot++) {
            int root = kn_class_root(parent, (int)slot);
            uint8_t need = m->of[i].list[k / 2].need[k % 2];
            if (need > most[root]) most[root] = need;
        }
    for (slot = 0; slot < 2 * m->count; slot++) {
        uint8_t found = most[kn_class_root(parent, (int)slot)];
        m->degree[slot / 2][slot % 2] = found > 0 ? found : (uint8_t)highest(job);
    }
}

static kn_status solve(kn_ctx *ctx, const kn_job *job)
{
    struct kn_job_meeting *m = job->meeting;
    size_t ncells = m->cells[job->nsurfaces];
    m->first = kn_alloc(ctx, ncells + 1, sizeof *m->first);
    if (!m->first) return KN_ENOMEM;
    for (size_t i = 0; i <= ncells; i++) {
        m->first[i] = m->count;
        if (i < ncells) m->count += m->of[i].count;
    }
    size_t nodes = 2 * m->count + 4 * ncells;
    int *parent = kn_alloc(ctx, nodes, sizeof *parent);
    uint8_t *most = kn_alloc_zero(ctx, nodes, sizeof *most);
    edge *edges = kn_alloc(ctx, 4 * m->count + 1, sizeof *edges);
    m->degree = kn_alloc_zero(ctx, m->count + 1, sizeof *m->degree);
    m->fate = kn_alloc_zero(ctx, m->count + 1, sizeof *m->fate);
    kn_status status = parent && most && edges && m->degree && m->fate ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < nodes && status == KN_OK; i++) parent[i] = (int)i;
    if (status == KN_OK) unite_inside(job, parent, edges);
    for (int s = 0; s < job->nsurfaces && status == KN_OK; s++)
        if (job->surfaces[s].meets) unite_borders(job, parent, s);
    if (status == KN_OK) take_degrees(job, parent, most);
    kn_free(ctx, parent);
    kn_free(ctx, most);
    kn_free(ctx, edges);
    return status;
}

kn_status kn_job_find_meeting_degrees(kn_ctx *ctx, kn_job *job)
{
    size_t ncells = 0;
    for (int s = 0; s < job->nsurfaces; s++)
        if (job->surfaces[s].meets) ncells += (size_t)job->surfaces[s].cells[0] * (size_t)job->surfaces[s].cells[1];
    if (ncells == 0) return KN_OK;
    struct kn_job_meeting *m = job->meeting = kn_alloc_zero(ctx, 1, sizeof *m);
    if (!m || !(m->cells = kn_alloc_zero(ctx, (size_t)job->nsurfaces + 1, sizeof *m->cells))) return KN_ENOMEM;
    for (int s = 0; s < job->nsurfaces; s++) {
        const kn_job_surface *on = &job->surfaces[s];
        m->cells[s + 1] = m->cells[s] + (on->meets ? (size_t)on->cells[0] * (size_t)on->cells[1] : 0);
    }
    if (!(m->of = kn_alloc_zero(ctx, ncells, sizeof *m->of))) return KN_ENOMEM;
    m->noting = true;
    kn_status status = kn_parallel(ctx, job->ncells, note_cell, job, "degrees");
    m->noting = false;
    if (status == KN_OK) status = solve(ctx, job);
    free_notes(ctx, job, m);
    return status;
}
