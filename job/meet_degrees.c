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

// What a patch in its cell needs along r and t, on which borders of the cell (bits) edges along r and t lie, and a
// number for each edge that is the same for edges with the same control points: those along r, then those along t.
typedef struct note {
    uint8_t need[2], borders[2];
    uint64_t edge[4];
} note;

struct kn_job_meeting {
    bool noting;   // else degrees are known
    size_t *first; // of each surface's patches: cell by cell, v fastest, in each as job->patches
    note *notes;
    size_t count;
    uint8_t (*degree)[2];
    uint8_t *fate; // kn_job_meeting_fate of each
};

void kn_job_meeting_free(kn_ctx *ctx, struct kn_job_meeting *m)
{
    if (!m) return;
    kn_free(ctx, m->first);
    kn_free(ctx, m->notes);
    kn_free(ctx, m->degree);
    kn_free(ctx, m->fate);
    kn_free(ctx, m);
}

bool kn_job_notes_meeting(const kn_job *job)
{
    return job->meeting && job->meeting->noting;
}

bool kn_job_may_meet(const kn_job *job, const kn_job_place *place)
{
    const kn_job_surface *s = &job->surfaces[place->surface];
    return s->meets && place->cell[0] >= 0 && place->cell[0] < s->cells[0] && place->cell[1] >= 0 &&
           place->cell[1] < s->cells[1];
}

static size_t slot_of(const kn_job *job, const kn_job_place *place, int patch)
{
    size_t columns = (size_t)job->surfaces[place->surface].cells[1];
    size_t cell = (size_t)place->cell[0] * columns + (size_t)place->cell[1];
    return job->meeting->first[place->surface] + cell * (size_t)job->npatches + (size_t)patch;
}

static int highest(const kn_job *job)
{
    return job->options.max_degree < HIGHEST ? job->options.max_degree : HIGHEST;
}

void kn_job_meeting_degree(int degree[2], const kn_job *job, const kn_job_place *place, int patch)
{
    const struct kn_job_meeting *m = job->meeting;
    for (int v = 0; v < 2; v++) degree[v] = m ? m->degree[slot_of(job, place, patch)][v] : highest(job);
}

kn_job_meeting_fate kn_job_fate_of(const kn_job *job, const kn_job_place *place, int patch)
{
    return job->meeting ? (kn_job_meeting_fate)job->meeting->fate[slot_of(job, place, patch)] : KN_JOB_UNKNOWN;
}

void kn_job_set_fate(const kn_job *job, const kn_job_place *place, int patch, kn_job_meeting_fate fate)
{
    uint8_t *known = job->meeting ? &job->meeting->fate[slot_of(job, place, patch)] : NULL;
    if (known && *known == KN_JOB_UNKNOWN) *known = (uint8_t)fate; // threads that run only read it
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

kn_status kn_job_note_meeting(kn_ctx *ctx, const kn_job *job, int patch, const kn_job_place *place,
                              const kn_job_rect *rect)
{
    note *to = &job->meeting->notes[slot_of(job, place, patch)];
    int most = highest(job), p = most < EASY ? most : EASY, need[2] = {1, 1};
    kn_bezier d = {0};
    kn_status status = kn_job_restrict(ctx, &d, &job->patches[patch], *rect, place->turn);
    if (status == KN_OK) status = find_need(ctx, need, job, place, &d, p);
    if (status == KN_OK && p < most && (need[0] >= p - 1 || need[1] >= p - 1)) // aliases, perhaps
        status = find_need(ctx, need, job, place, &d, most);
    if (status == KN_EUNDEFINED) { // no normal somewhere: stand-ins stay
        kn_ctx_clear_error(ctx);
        status = KN_OK;
    }
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        to->need[v] = (uint8_t)need[v];
        for (int end = 0; end < 2; end++) note_edge(to, &d, v, end);
    }
    kn_bezier_clear(ctx, &d);
    return status;
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
    const struct kn_job_meeting *m = job->meeting;
    size_t cell = m->first[surface] / (size_t)job->npatches + (size_t)i * (size_t)job->surfaces[surface].cells[1] +
                  (size_t)j;
    return (int)(2 * m->count + 4 * cell) + border;
}

typedef struct edge {
    uint64_t number;
    int node;
} edge;

static int compare(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    return x->number != y->number ? (x->number < y->number ? -1 : 1) : x->node - y->node;
}

// Of one cell; edges: room for four of each patch.
static void unite_inside(const kn_job *job, int *parent, edge *edges, int surface, int i, int j)
{
    const kn_job_place place = {.surface = surface, .cell = {i, j}};
    int n = 0;
    for (int k = 0; k < job->npatches; k++) {
        size_t slot = slot_of(job, &place, k);
        const note *from = &job->meeting->notes[slot];
        if (from->need[0] == 0) continue;
        for (int v = 0; v < 2; v++) {
            int node = (int)(2 * slot) + v;
            for (int end = 0; end < 2; end++) edges[n++] = (edge){from->edge[2 * v + end], node};
            for (int b = 0; b < 4; b++)
                if (from->borders[v] >> b & 1) kn_class_unite(parent, node, border_node(job, surface, i, j, b));
        }
    }
    qsort(edges, (size_t)n, sizeof *edges, compare);
    for (int k = 1; k < n; k++)
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

static kn_status solve(kn_ctx *ctx, const kn_job *job)
{
    struct kn_job_meeting *m = job->meeting;
    size_t nodes = 2 * m->count + 4 * (m->count / (size_t)job->npatches);
    int *parent = kn_alloc(ctx, nodes, sizeof *parent);
    uint8_t *most = kn_alloc_zero(ctx, nodes, sizeof *most);
    edge *edges = kn_alloc(ctx, 4 * (size_t)job->npatches, sizeof *edges);
    m->degree = kn_alloc_zero(ctx, m->count, sizeof *m->degree);
    m->fate = kn_alloc_zero(ctx, m->count, sizeof *m->fate);
    kn_status status = parent && most && edges && m->degree && m->fate ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < nodes && status == KN_OK; i++) parent[i] = (int)i;
    for (int s = 0; s < job->nsurfaces && status == KN_OK; s++) {
        const kn_job_surface *on = &job->surfaces[s];
        if (!on->meets) continue;
        for (int i = 0; i < on->cells[0]; i++)
            for (int j = 0; j < on->cells[1]; j++) unite_inside(job, parent, edges, s, i, j);
        unite_borders(job, parent, s);
    }
    for (size_t i = 0; i < 2 * m->count && status == KN_OK; i++) {
        int root = kn_class_root(parent, (int)i);
        if (m->notes[i / 2].need[i % 2] > most[root]) most[root] = m->notes[i / 2].need[i % 2];
    }
    for (size_t i = 0; i < 2 * m->count && status == KN_OK; i++) {
        uint8_t found = most[kn_class_root(parent, (int)i)];
        m->degree[i / 2][i % 2] = found > 0 ? found : (uint8_t)highest(job);
    }
    kn_free(ctx, parent);
    kn_free(ctx, most);
    kn_free(ctx, edges);
    return status;
}

kn_status kn_job_find_meeting_degrees(kn_ctx *ctx, kn_job *job)
{
    // tiles that differ from cell to cell keep the largest degree
    if (job->varying || job->tiling || job->darts || job->nvariants > 1) return KN_OK;
    struct kn_job_meeting *m = job->meeting = kn_alloc_zero(ctx, 1, sizeof *m);
    if (!m || !(m->first = kn_alloc(ctx, (size_t)job->nsurfaces, sizeof *m->first))) return KN_ENOMEM;
    for (int s = 0; s < job->nsurfaces; s++) {
        const kn_job_surface *on = &job->surfaces[s];
        m->first[s] = m->count;
        if (on->meets) m->count += (size_t)on->cells[0] * (size_t)on->cells[1] * (size_t)job->npatches;
    }
    if (m->count == 0) {
        kn_job_meeting_free(ctx, m);
        job->meeting = NULL;
        return KN_OK;
    }
    if (!(m->notes = kn_alloc_zero(ctx, m->count, sizeof *m->notes))) return KN_ENOMEM;
    m->noting = true;
    kn_status status = kn_parallel(ctx, job->ncells, note_cell, job, "degrees");
    m->noting = false;
    if (status == KN_OK) status = solve(ctx, job);
    kn_free(ctx, m->notes);
    m->notes = NULL;
    return status;
}
