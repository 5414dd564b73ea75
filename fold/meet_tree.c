// SPDX-License-Identifier: Apache-2.0
// The hierarchy: boxes of parameters inside one piece each, with boxes around their images; groups of them above.
#include "fold/meet.h"

#include "bezier/bounds.h"

#include <stdlib.h>
#include <string.h>

static kn_status add_node(kn_meet *m, const kn_meet_node *node)
{
    if (m->nnodes == m->room_nodes) {
        size_t room = 2 * m->room_nodes + 64;
        void *more = kn_resize(m->ctx, m->nodes, room, sizeof *m->nodes);
        if (!more) return KN_ENOMEM;
        m->nodes = more, m->room_nodes = room;
    }
    m->nodes[m->nnodes++] = *node;
    return KN_OK;
}

// ---- boxes around images ----

// The longest line of control points in variable d.
static double measure(const double *x, const kn_net *net, int d)
{
    size_t inner = kn_net_inner(net, d), row = (size_t)net->degree[d] * inner;
    double most = 0.0;
    for (size_t o = 0; o < net->count; o += row + inner)
        for (size_t i = o; i < o + inner; i++) {
            double sum = 0.0;
            for (size_t j = i; j < i + row; j += inner) {
                double s = 0.0;
                for (size_t k = 0; k < 3; k++) {
                    double y = x[k * net->count + j + inner] - x[k * net->count + j];
                    s += y * y;
                }
                sum += sqrt(s);
            }
            most = fmax(most, sum);
        }
    return most;
}

// The mean direction from the first to the last control points in each variable.
static void find_chords(double chords[3][3], const double *x, const kn_net *net)
{
    for (int d = 0; d < 3; d++) {
        size_t inner = kn_net_inner(net, d), row = (size_t)net->degree[d] * inner;
        for (size_t k = 0; k < 3; k++) {
            chords[d][k] = 0.0;
            for (size_t o = 0; o < net->count; o += row + inner)
                for (size_t i = o; i < o + inner; i++)
                    chords[d][k] += x[k * net->count + i + row] - x[k * net->count + i];
        }
    }
}

// The derivative in variable c at corner `corner` (bit d: the upper end of variable d), per box.
static void corner_slope(double out[3], const double *x, const kn_net *net, int c, int corner)
{
    size_t at = 0, step = kn_net_inner(net, c);
    for (int d = 0; d < 3; d++)
        if (corner >> d & 1) at += (size_t)net->degree[d] * kn_net_inner(net, d);
    for (size_t k = 0; k < 3; k++) {
        const double *p = x + k * net->count + at;
        out[k] = corner >> c & 1 ? p[0] - *(p - step) : p[step] - p[0];
        out[k] *= net->degree[c];
    }
}

// How much the partials change along variable d, each relative to itself: what keeps T from being certified. Where
// one vanishes, at a pole, the change counts 1: it is not one that cutting ends. Of the partial in `turning` the
// direction alone counts: near an apex its length is divided out.
static double bend(const double *x, const kn_net *net, int d, int turning)
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        double size[8], slope[8][3], most = 0.0, change = 0.0;
        if (net->degree[c] == 0) continue;
        for (int i = 0; i < 8; i++) {
            corner_slope(slope[i], x, net, c, i);
            size[i] = sqrt(slope[i][0] * slope[i][0] + slope[i][1] * slope[i][1] + slope[i][2] * slope[i][2]);
            most = fmax(most, size[i]);
        }
        for (int i = 0; i < 8; i++) {
            int j = i ^ 1 << d;
            double low = fmin(size[i], size[j]), diff = 0.0;
            if (fmax(size[i], size[j]) <= 1e-6 * most) continue;
            bool turns = c == turning && low > 1e-6 * most;
            double a = turns ? low / size[i] : 1.0, b = turns ? low / size[j] : 1.0;
            for (int k = 0; k < 3; k++) diff += pow(a * slope[i][k] - b * slope[j][k], 2.0);
            if (c == turning && low <= 1e-6 * most) continue;
            change = fmax(change, low <= 1e-6 * most ? 1.0 : sqrt(diff) / low);
        }
        sum += change;
    }
    return sum;
}

// The variable to divide: the one along which T bends most, when it bends at all, and else the longest. bends[d]: of
// the pieces side by side.
static void choose_cut(kn_meet_node *node, const double bends[3])
{
    double most = 0.02;
    int spans[2] = {node->last[0] - node->first[0] + 1, node->last[1] - node->first[1] + 1};
    node->cut = 0;
    for (int d = 1; d < 3; d++)
        if (node->length[d] > node->length[node->cut]) node->cut = d;
    for (int d = 0; d < 3; d++)
        if (bends[d] > most && node->length[d] > 1e-3 * node->length[node->cut]) most = bends[d], node->cut = d;
    if (spans[0] * spans[1] > KN_MEET_MOST) node->cut = spans[0] >= spans[1] ? 0 : 1;
}

static kn_status project(kn_meet *m, kn_meet_cloud *all, const kn_meet_patch *p)
{
    double least = 1.0, size = 0.0, slack = fmax(fmax(p->error[0], p->error[1]), p->error[2]);
    size_t n = p->net.count;
    if (p->rational) {
        const double *w = p->coef + 3 * n;
        least = INFINITY;
        for (size_t i = 0; i < n; i++) least = fmin(least, w[i]);
        least -= p->error[3];
        if (!(least > 0.0)) return kn_fail(m->ctx, KN_EUNDECIDED, "self-intersection: a weight near zero");
        for (size_t i = 0; i < 3 * n; i++) p->coef[i] /= w[i % n];
        all->error = 0x1p-52;
    }
    size = kn_largest(p->coef, 3 * n) * (1.0 + 0x1p-20);
    if (!(size < INFINITY)) return kn_fail(m->ctx, KN_EUNDECIDED, "self-intersection: numbers overflow");
    // |x/w - x'/w'| <= (|x - x'| + |x'/w'| |w - w'|) / w
    slack = (slack + (p->rational ? size * p->error[3] : 0.0)) / least + kn_rounding(4.0) * size;
    all->slack = fmax(all->slack, slack);
    for (size_t k = 0; k < 3; k++) memcpy(all->x + k * all->room + all->n, p->coef + k * n, n * sizeof *p->coef);
    all->n += n;
    return KN_OK;
}

static void take_longest(double *out, double *bends, const kn_meet_patch *p, const kn_meet_node *node,
                         const kn_meet_chart *c)
{
    int turning = c->apex[0][0] || c->apex[0][1] ? 1 : c->apex[1][0] || c->apex[1][1] ? 0 : -1;
    for (int d = 0; d < 3; d++) {
        double n = node->last[d] - node->first[d] + 1;
        out[d] = fmax(out[d], n * measure(p->coef, &p->net, d));
        bends[d] = fmax(bends[d], n * bend(p->coef, &p->net, d, turning));
    }
}

static kn_status gather(kn_meet *m, kn_meet_cloud *all, kn_meet_node *node)
{
    int at[3];
    double from[3], to[3], bends[3] = {0.0};
    for (int d = 0; d < 3; d++) node->length[d] = 0.0;
    for (at[0] = node->first[0]; at[0] <= node->last[0]; at[0]++)
        for (at[1] = node->first[1]; at[1] <= node->last[1]; at[1]++)
            for (at[2] = node->first[2]; at[2] <= node->last[2]; at[2]++) {
                kn_meet_patch p;
                kn_mark mark = kn_scratch_mark(m->ctx);
                kn_status status = kn_meet_restrict(m, &p, from, to, node->chart, at, node->lo, node->hi);
                if (status == KN_OK) status = project(m, all, &p);
                if (status == KN_OK) take_longest(node->length, bends, &p, node, &m->charts[node->chart]);
                kn_scratch_release(m->ctx, mark);
                if (status != KN_OK) return status;
            }
    choose_cut(node, bends);
    return KN_OK;
}

// The box around all images, for what consists of so many pieces that no better one pays.
static kn_status bound_roughly(kn_meet *m, kn_meet_node *node)
{
    const kn_spline *v = &m->charts[node->chart].volume;
    double lo[3], hi[3];
    kn_status status = kn_spline_box(m->ctx, lo, hi, v);
    if (status != KN_OK) return status;
    node->box = (kn_oriented_box){.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (int k = 0; k < 3; k++) {
        node->box.center[k] = 0.5 * lo[k] + 0.5 * hi[k];
        node->box.half[k] = hi[k] - lo[k]; // twice as much as need be, errors included
        node->length[k] = node->last[k] - node->first[k];
    }
    node->cut = node->length[0] >= node->length[1] ? 0 : 1;
    return KN_OK;
}

kn_status kn_meet_gather(kn_meet *m, kn_meet_cloud *out, kn_meet_node *node)
{
    const kn_meet_chart *c = &m->charts[node->chart];
    size_t pieces = 1;
    for (int d = 0; d < 3; d++) pieces *= (size_t)(node->last[d] - node->first[d] + 1);
    *out = (kn_meet_cloud){.room = pieces * kn_bezier_count(&c->pieces[0])};
    out->x = kn_scratch(m->ctx, 3 * out->room, sizeof *out->x);
    return out->x ? gather(m, out, node) : KN_ENOMEM;
}

enum { MANY = 1024 };

// The box holds the control points, and every point of T is within the slack of a mean of them.
static kn_status bound(kn_meet *m, kn_meet_node *node)
{
    const kn_meet_chart *c = &m->charts[node->chart];
    size_t pieces = 1;
    for (int d = 0; d < 3; d++) {
        kn_meet_overlap(c, d, node->lo[d], node->hi[d], &node->first[d], &node->last[d]);
        pieces *= (size_t)(node->last[d] - node->first[d] + 1);
    }
    kn_status status = KN_OK;
    if (pieces > MANY)
        status = bound_roughly(m, node);
    else {
        kn_mark mark = kn_scratch_mark(m->ctx);
        kn_meet_cloud all;
        status = kn_meet_gather(m, &all, node);
        if (status == KN_OK) {
            double chords[3][3];
            kn_net net = kn_net_make(3, 3, c->pieces[0].degree);
            if (pieces == 1) find_chords(chords, all.x, &net);
            kn_oriented_box_fit(&node->box, all.x, 3, all.n, all.error, chords, pieces == 1 ? 3 : 0);
            for (int i = 0; i < 3; i++) node->box.half[i] += 2.0 * all.slack; // sqrt(3) would do
        }
        kn_scratch_release(m->ctx, mark);
    }
    double sum = 0.0;
    for (int i = 0; i < 3; i++) sum += node->box.half[i] * node->box.half[i];
    node->size = 2.0 * sqrt(sum);
    return status;
}

kn_status kn_meet_split(kn_meet *m, int index)
{
    kn_meet_node half[2] = {m->nodes[index], m->nodes[index]};
    int d = half[0].cut, middle = (half[0].first[d] + half[0].last[d] + 1) / 2;
    double x = 0.5 * half[0].lo[d] + 0.5 * half[0].hi[d];
    if (half[0].first[d] != half[0].last[d]) x = m->charts[half[0].chart].breaks[d][middle];
    if (d == 2 && half[0].lo[2] < 0.0 && half[0].hi[2] > 0.0) x = 0.0; // edges and tips of the base lie there
    half[0].hi[d] = half[1].lo[d] = x;
    for (int i = 0; i < 2; i++) {
        half[i].child[0] = half[i].child[1] = -1;
        kn_status status = bound(m, &half[i]);
        if (status == KN_OK) status = add_node(m, &half[i]);
        if (status != KN_OK) return status;
    }
    m->nodes[index].child[0] = (int)m->nnodes - 2;
    m->nodes[index].child[1] = (int)m->nnodes - 1;
    m->boxes += 2;
    return KN_OK;
}

static kn_status add_region(kn_meet *m, int region)
{
    const kn_fold_region *r = &m->regions[region];
    kn_meet_node node = {.chart = r->shell, .region = region, .child = {-1, -1}};
    memcpy(node.lo, r->lo, sizeof node.lo);
    memcpy(node.hi, r->hi, sizeof node.hi);
    kn_status status = bound(m, &node);
    m->boxes++;
    if (status == KN_OK && m->nnodes % 256 == 0) status = kn_progress(m->ctx, "self-intersection", 0.0);
    return status == KN_OK ? add_node(m, &node) : status;
}

// ---- groups ----

typedef struct leaf {
    double key;
    int node;
} leaf;

static int by_key(const void *a, const void *b)
{
    const leaf *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->node > y->node) - (x->node < y->node);
}

// The extent of a node's box along the axes of coordinates, a little outwards.
static void extent(double lo[3], double hi[3], const kn_meet_node *node)
{
    for (int k = 0; k < 3; k++) {
        double reach = 0.0;
        for (int i = 0; i < 3; i++) reach += fabs(node->box.axis[i][k]) * node->box.half[i];
        reach += 0x1p-48 * (reach + fabs(node->box.center[k]));
        lo[k] = node->box.center[k] - reach;
        hi[k] = node->box.center[k] + reach;
    }
}

static kn_status group(kn_meet *m, int *out, leaf *leaves, size_t n)
{
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, a[3], b[3], sum = 0.0;
    if (n == 1) {
        *out = leaves[0].node;
        return KN_OK;
    }
    for (size_t i = 0; i < n; i++) {
        extent(a, b, &m->nodes[leaves[i].node]);
        for (int k = 0; k < 3; k++) lo[k] = fmin(lo[k], a[k]), hi[k] = fmax(hi[k], b[k]);
    }
    int d = 0;
    for (int k = 1; k < 3; k++)
        if (hi[k] - lo[k] > hi[d] - lo[d]) d = k;
    for (size_t i = 0; i < n; i++) leaves[i].key = m->nodes[leaves[i].node].box.center[d];
    qsort(leaves, n, sizeof *leaves, by_key);
    kn_meet_node node = {.chart = -1, .region = -1, .box = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
    for (int k = 0; k < 3; k++) {
        node.box.center[k] = 0.5 * lo[k] + 0.5 * hi[k];
        node.box.half[k] = fmax(hi[k] - node.box.center[k], node.box.center[k] - lo[k]) * (1.0 + 0x1p-50);
        sum += node.box.half[k] * node.box.half[k];
    }
    node.size = 2.0 * sqrt(sum);
    kn_status status = group(m, &node.child[0], leaves, n / 2);
    if (status == KN_OK) status = group(m, &node.child[1], leaves + n / 2, n - n / 2);
    if (status == KN_OK) status = add_node(m, &node);
    *out = (int)m->nnodes - 1;
    return status;
}

kn_status kn_meet_tree(kn_meet *m)
{
    kn_status status = KN_OK;
    for (size_t r = 0; r < m->nregions && status == KN_OK; r++) status = add_region(m, (int)r);
    if (status != KN_OK) return status;
    size_t n = m->nnodes;
    leaf *leaves = kn_alloc(m->ctx, n, sizeof *leaves);
    if (!leaves) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) leaves[i].node = (int)i;
    status = group(m, &m->root, leaves, n);
    kn_free(m->ctx, leaves);
    return status;
}
