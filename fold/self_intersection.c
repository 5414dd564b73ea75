// SPDX-License-Identifier: Apache-2.0
// Global self-intersection: pairs of boxes of a hierarchy, the largest first, until planes and the criterion of
// injectivity settle all of them or two places with one image are found.
#include "fold/meet.h"

#include <string.h>

enum { MOST_ATTEMPTS = 100 };

// Two nodes in doubt; a == b is a node with itself.
typedef struct pair {
    double size;
    size_t number; // in the order of making: pairs of one size are taken in it
    int a, b;
} pair;

typedef struct queue {
    pair *heap;
    size_t n, room, made;
} queue;

static bool is_before(const pair *a, const pair *b)
{
    return a->size != b->size ? a->size > b->size : a->number < b->number;
}

static kn_status push(kn_meet *m, queue *q, int a, int b)
{
    if (q->n == q->room) {
        size_t room = 2 * q->room + 256;
        void *more = kn_resize(m->ctx, q->heap, room, sizeof *q->heap);
        if (!more) return KN_ENOMEM;
        q->heap = more, q->room = room;
    }
    pair p = {fmax(m->nodes[a].size, m->nodes[b].size), q->made++, a, b};
    size_t i = q->n++;
    for (; i > 0 && is_before(&p, &q->heap[(i - 1) / 2]); i = (i - 1) / 2) q->heap[i] = q->heap[(i - 1) / 2];
    q->heap[i] = p;
    return KN_OK;
}

static pair pop(queue *q)
{
    pair top = q->heap[0], last = q->heap[--q->n];
    size_t i = 0;
    for (size_t child = 1; child < q->n; child = 2 * i + 1) {
        if (child + 1 < q->n && is_before(&q->heap[child + 1], &q->heap[child])) child++;
        if (!is_before(&q->heap[child], &last)) break;
        q->heap[i] = q->heap[child];
        i = child;
    }
    q->heap[i] = last;
    return top;
}

// ---- one pair ----

static bool is_group(const kn_meet_node *n)
{
    return n->chart < 0;
}

// A node with itself: both halves with themselves and with each other.
static kn_status halve_self(kn_meet *m, queue *q, int a)
{
    kn_status status = m->nodes[a].child[0] < 0 ? kn_meet_split(m, a) : KN_OK;
    if (status != KN_OK) return status;
    int x = m->nodes[a].child[0], y = m->nodes[a].child[1];
    status = push(m, q, x, x);
    if (status == KN_OK) status = push(m, q, y, y);
    return status == KN_OK ? push(m, q, x, y) : status;
}

// The larger one is halved, a group before a box.
static kn_status halve(kn_meet *m, queue *q, int a, int b)
{
    const kn_meet_node *x = &m->nodes[a], *y = &m->nodes[b];
    bool first = is_group(x) != is_group(y) ? is_group(x) : x->size >= y->size;
    int whole = first ? a : b, other = first ? b : a;
    kn_status status = m->nodes[whole].child[0] < 0 ? kn_meet_split(m, whole) : KN_OK;
    for (int i = 0; i < 2 && status == KN_OK; i++) {
        int child = m->nodes[whole].child[i];
        status = first ? push(m, q, child, other) : push(m, q, other, child);
    }
    return status;
}

static void doubt(const kn_meet *m, kn_fold_intersection *out, const pair *p)
{
    if (out->undecided++ > 0) return;
    const kn_meet_node *n[2] = {&m->nodes[p->a], &m->nodes[p->b]};
    kn_fold_region *r[2] = {&out->a, &out->b};
    for (int i = 0; i < 2; i++) {
        while (is_group(n[i])) n[i] = &m->nodes[n[i]->child[0]];
        r[i]->shell = n[i]->chart;
        memcpy(r[i]->lo, n[i]->lo, sizeof r[i]->lo);
        memcpy(r[i]->hi, n[i]->hi, sizeof r[i]->hi);
    }
}

// Whether they share a face, an edge or a corner in the parameters of one chart: then nothing lies between them.
static bool touch(const kn_meet_node *a, const kn_meet_node *b)
{
    for (int d = 0; d < 3; d++)
        if (a->lo[d] > b->hi[d] || b->lo[d] > a->hi[d]) return false;
    return a->chart == b->chart;
}

static kn_status settle(kn_meet *m, queue *q, kn_fold_intersection *out, const pair *p, bool *found)
{
    const kn_meet_node *a = &m->nodes[p->a], *b = &m->nodes[p->b];
    bool done = false, self = p->a == p->b, small = p->size <= m->resolution;
    kn_status status = KN_OK;
    m->hollow = false;
    if (!self && kn_meet_separate(&a->box, &b->box, 1.0)) return KN_OK;
    if (is_group(a) || is_group(b)) return self ? halve_self(m, q, p->a) : halve(m, q, p->a, p->b);
    if (!self && !touch(a, b)) status = kn_meet_plane(m, &done, p->a, p->b);
    if (status == KN_OK && !done) status = kn_meet_injective(m, &done, p->a, p->b);
    if (status == KN_OK && !done && !self) status = kn_meet_fibre(m, &done, p->a, p->b);
    if (status != KN_OK || done) return status;
    bool tries = !self && (small || !kn_meet_separate(&a->box, &b->box, 0.5));
    if (!tries && m->hollow && m->attempts < MOST_ATTEMPTS) tries = true, m->attempts++;
    if (tries) {
        m->boxes++;
        status = kn_meet_witness(m, out, found, p->a, p->b);
        if (status != KN_OK || *found) return status;
    }
    if (small) {
        doubt(m, out, p);
        return KN_OK;
    }
    return self ? halve_self(m, q, p->a) : halve(m, q, p->a, p->b);
}

static kn_status run(kn_meet *m, kn_fold_intersection *out)
{
    queue q = {0};
    bool found = false;
    kn_status status = push(m, &q, m->root, m->root);
    while (status == KN_OK && q.n > 0 && !found && m->boxes < m->work) {
        pair p = pop(&q);
        if (m->boxes++ % 1024 == 0)
            status = kn_progress(m->ctx, "self-intersection", (double)m->boxes / (double)m->work);
        if (status == KN_OK) status = settle(m, &q, out, &p, &found);
    }
    while (status == KN_OK && q.n > 0 && !found) {
        pair p = pop(&q);
        doubt(m, out, &p);
    }
    kn_free(m->ctx, q.heap);
    if (!found) out->verdict = out->undecided > 0 ? KN_FOLD_OPEN : KN_FOLD_NONE;
    if (found) out->undecided = 0;
    out->boxes = m->boxes;
    return status;
}

// ---- what is asked ----

static kn_status check_region(kn_ctx *ctx, kn_fold_region *out, const kn_fold_region *r,
                              const kn_shell *const *shells, int nshells, size_t index)
{
    double lo[3], hi[3];
    if (r->shell < 0 || r->shell >= nshells)
        return kn_fail(ctx, KN_EDOMAIN, "self-intersection: region %zu: shell %d of %d", index, r->shell, nshells);
    const kn_spline *s = kn_shell_surface(shells[r->shell]);
    for (int d = 0; d < 2; d++) kn_spline_domain(s, d, &lo[d], &hi[d]);
    double w[2];
    kn_shell_heights(shells[r->shell], w);
    lo[2] = w[0], hi[2] = w[1];
    *out = *r;
    for (int d = 0; d < 3; d++) {
        double slack = d < 2 ? 0x1p-40 * (hi[d] - lo[d]) : 0.0;
        if (!(r->lo[d] < r->hi[d] && r->lo[d] >= lo[d] - slack && r->hi[d] <= hi[d] + slack && isfinite(r->lo[d]) &&
              isfinite(r->hi[d])))
            return kn_fail(ctx, KN_EDOMAIN, "self-intersection: region %zu: [%g, %g] in variable %d", index, r->lo[d],
                           r->hi[d], d);
        out->lo[d] = fmax(r->lo[d], lo[d]), out->hi[d] = fmin(r->hi[d], hi[d]);
    }
    return KN_OK;
}

static kn_status take_regions(kn_meet *m, const kn_shell *const *shells, int nshells, const kn_fold_region *regions,
                              size_t nregions, const double w[2])
{
    size_t n = regions ? nregions : (size_t)nshells;
    m->regions = kn_alloc(m->ctx, n, sizeof *m->regions);
    if (!m->regions) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) {
        kn_fold_region all = {.shell = (int)i}, *given = &all;
        if (!regions) {
            for (int d = 0; d < 2; d++) kn_spline_domain(kn_shell_surface(shells[i]), d, &all.lo[d], &all.hi[d]);
            all.lo[2] = w[0], all.hi[2] = w[1];
        } else
            all = regions[i];
        kn_status status = check_region(m->ctx, &m->regions[i], given, shells, nshells, i);
        if (status != KN_OK) return status;
    }
    m->nregions = n;
    return KN_OK;
}

kn_status kn_fold_self_intersection(kn_ctx *ctx, kn_fold_intersection *out, const kn_shell *const *shells,
                                    int nshells, const kn_fold_region *regions, size_t nregions, const double w[2],
                                    const kn_fold_options *options)
{
    kn_fold_options o = options ? *options : (kn_fold_options){0};
    kn_fold_intersection result = {0};
    if (nshells < 1 || (regions && nregions < 1) || (!regions && !w))
        return kn_fail(ctx, KN_EDOMAIN, "self-intersection: %d shells, %zu regions", nshells, nregions);
    if (!(o.size >= 0.0 && o.size <= 0.01)) return kn_fail(ctx, KN_EDOMAIN, "self-intersection: size %g", o.size);
    kn_meet m = {.ctx = ctx, .resolution = o.size > 0.0 ? o.size : 1e-6, .work = o.work ? o.work : 300000};
    kn_status status = take_regions(&m, shells, nshells, regions, nregions, w);
    if (status == KN_OK) status = kn_meet_charts(&m, shells, nshells);
    if (status == KN_OK) status = kn_meet_glues(&m);
    if (status == KN_OK) status = kn_meet_tree(&m);
    if (status == KN_OK) status = run(&m, &result);
    if (status == KN_OK) *out = result;
    kn_meet_clear(&m);
    return status;
}
