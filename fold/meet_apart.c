// SPDX-License-Identifier: Apache-2.0
// Images that have a plane between them, or one through all that they share.
#include "fold/meet.h"

#include <string.h>

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double *out, const double *a, const double *b)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

// Across the plane with normal v the boxes reach sum_i half_i |v . axis_i| from their centers. All is multiplied by
// |v|, which need not be 1; the sums of a few products of rounded numbers are within 2^-48 of their absolute values.
static bool is_between(const kn_oriented_box *a, const kn_oriented_box *b, const double *v, double shrink)
{
    double reach = 0.0, far = 0.0, size = 0.0;
    for (int i = 0; i < 3; i++) {
        reach += a->half[i] * fabs(dot(v, a->axis[i])) + b->half[i] * fabs(dot(v, b->axis[i]));
        far += v[i] * (a->center[i] - b->center[i]);
        size += fabs(v[i]) * (fabs(a->center[i]) + fabs(b->center[i]) + 2.0 * (a->half[i] + b->half[i]));
        size += (a->half[i] + b->half[i]) * (fabs(v[0]) + fabs(v[1]) + fabs(v[2]));
    }
    return fabs(far) > shrink * reach + 0x1p-48 * size;
}

// The fifteen candidates of two boxes: their faces, and edges of one across edges of the other.
bool kn_meet_separate(const kn_oriented_box *a, const kn_oriented_box *b, double shrink)
{
    double v[3];
    for (int i = 0; i < 3; i++)
        if (is_between(a, b, a->axis[i], shrink) || is_between(a, b, b->axis[i], shrink)) return true;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            cross(v, a->axis[i], b->axis[j]);
            if (is_between(a, b, v, shrink)) return true;
        }
    return false;
}

// ---- a plane between control points ----

// The least and the largest of v . x over a cloud; *at: where the least is.
static void range(double *lo, double *hi, size_t *at, const kn_meet_cloud *c, const double *v)
{
    *lo = INFINITY, *hi = -INFINITY, *at = 0;
    for (size_t k = 0; k < c->n; k++) {
        double t = v[0] * c->x[k] + v[1] * c->x[c->room + k] + v[2] * c->x[2 * c->room + k];
        if (t < *lo) *lo = t, *at = k;
        *hi = fmax(*hi, t);
    }
}

// Gilbert's iteration: v is a point of the hull of all differences a_i - b_j, moved towards the one that lies
// farthest against it, as near to 0 as the segment comes. v . (a_i - b_j) > 0 for all is a plane between them.
static bool find_plane(const kn_meet_cloud *a, const kn_meet_cloud *b, const double *start, double size)
{
    enum { TURNS = 24 };
    double v[3] = {start[0], start[1], start[2]}, slack = a->slack + b->slack + (a->error + b->error) * size;
    for (int turn = 0; turn < TURNS; turn++) {
        double alo, ahi, blo, bhi, minus[3] = {-v[0], -v[1], -v[2]}, p[3], d[3], along = 0.0, length = 0.0;
        double sum = fabs(v[0]) + fabs(v[1]) + fabs(v[2]);
        size_t i, j;
        range(&alo, &ahi, &i, a, v);
        range(&blo, &bhi, &j, b, minus);
        if (alo + blo > sum * (slack + kn_rounding(8.0) * size)) return true;
        for (int k = 0; k < 3; k++) {
            p[k] = a->x[(size_t)k * a->room + i] - b->x[(size_t)k * b->room + j];
            d[k] = p[k] - v[k];
            along -= d[k] * v[k], length += d[k] * d[k];
        }
        if (!(length > 0.0) || !(along > 0.0)) return false;
        double t = fmin(along / length, 1.0);
        for (int k = 0; k < 3; k++) v[k] += t * d[k];
    }
    return false;
}

static bool is_small(const kn_meet_node *n)
{
    int pieces = 1;
    for (int d = 0; d < 3; d++) pieces *= n->last[d] - n->first[d] + 1;
    return n->chart >= 0 && pieces <= 8;
}

kn_status kn_meet_plane(kn_meet *m, bool *apart, int ia, int ib)
{
    kn_meet_node x[2] = {m->nodes[ia], m->nodes[ib]};
    kn_meet_cloud cloud[2];
    double v[3], size = 0.0;
    *apart = false;
    if (!is_small(&x[0]) || !is_small(&x[1])) return KN_OK;
    kn_mark mark = kn_scratch_mark(m->ctx);
    kn_status status = kn_meet_gather(m, &cloud[0], &x[0]);
    if (status == KN_OK) status = kn_meet_gather(m, &cloud[1], &x[1]);
    for (int k = 0; k < 3; k++) {
        v[k] = x[0].box.center[k] - x[1].box.center[k];
        for (int i = 0; i < 2; i++) size = fmax(size, fabs(x[i].box.center[k]) + x[i].size);
    }
    if (status == KN_OK) *apart = find_plane(&cloud[0], &cloud[1], v, size);
    kn_scratch_release(m->ctx, mark);
    return status;
}

// ---- through what they share ----

// What a node shares with another: the part of its box where each variable is at the given end (0, 1; -1: anywhere).
typedef struct part {
    const kn_meet_node *node;
    double at[3]; // a place there
    int end[3];
    bool special; // a pole, an apex, or a corner of the chart: other parameters may have the same fibre or point
} part;

// How a part's node lies to one side of a plane: f = v . T - c >= slope s - touch, s the sum of the distances from
// the ends, in parts of the node's box.
typedef struct lean {
    double slope, touch;
    double least, most; // weights
} lean;

// s of control point k.
static double distance(const part *p, const kn_net *net, const double from[3], const double to[3], size_t k)
{
    double s = 0.0;
    for (int d = 0; d < 3; d++) {
        double n = net->degree[d], i = (double)(k / kn_net_inner(net, d) % (size_t)(net->degree[d] + 1));
        if (p->end[d] < 0 || n == 0.0) continue;
        double x = (from[d] + (to[d] - from[d]) * (i / n) - p->node->lo[d]) / (p->node->hi[d] - p->node->lo[d]);
        s += p->end[d] ? 1.0 - x : x;
    }
    return s < 0x1p-20 ? 0.0 : s;
}

// With weights means of f_k >= slope s_k - touch are at least slope (least w / most w) s - touch.
static void lean_of(lean *l, const part *side, const kn_meet_patch *p, const double from[3], const double to[3],
                    const double *v, double c)
{
    size_t n = p->net.count;
    double error = 0.0, least = INFINITY;
    for (size_t k = 0; k < n; k++) {
        double w = p->rational ? p->coef[3 * n + k] : 1.0, f = -c, size = fabs(c);
        double s = distance(side, &p->net, from, to, k);
        for (int d = 0; d < 3; d++) {
            double x = p->coef[(size_t)d * n + k] / w;
            f += v[d] * x;
            size += fabs(v[d] * x);
        }
        least = fmin(least, w), l->most = fmax(l->most, w);
        error = fmax(error, kn_rounding(8.0) * size);
        if (s > 0.0)
            l->slope = fmin(l->slope, f / s);
        else
            l->touch = fmax(l->touch, -f);
    }
    l->least = fmin(l->least, least);
    for (int d = 0; d < 3; d++)
        error += fabs(v[d]) * (p->error[d] + (p->rational ? 2.0 * fabs(c) * p->error[3] : 0.0)) / (0.9 * least);
    l->touch = fmax(l->touch, 0.0) + 2.0 * error;
}

// What is done with each piece of a part's node.
typedef struct sums {
    double all[3], some[3]; // of control points, and of those with s = 0
    size_t n, shared;
} sums;

static void add_points(sums *sum, const part *side, const kn_meet_patch *p, const double from[3], const double to[3])
{
    size_t n = p->net.count;
    for (size_t k = 0; k < n; k++) {
        bool in = distance(side, &p->net, from, to, k) == 0.0;
        sum->shared += in, sum->n++;
        for (int d = 0; d < 3; d++) {
            double x = p->coef[(size_t)d * n + k] / (p->rational ? p->coef[3 * n + k] : 1.0);
            sum->all[d] += x;
            if (in) sum->some[d] += x;
        }
    }
}

// sum != NULL: adds the points of all pieces; else lean: how they lie.
static kn_status survey(kn_meet *m, const part *side, sums *sum, lean *l, const double *v, double c)
{
    const kn_meet_node *n = side->node;
    int at[3];
    for (at[0] = n->first[0]; at[0] <= n->last[0]; at[0]++)
        for (at[1] = n->first[1]; at[1] <= n->last[1]; at[1]++)
            for (at[2] = n->first[2]; at[2] <= n->last[2]; at[2]++) {
                kn_meet_patch p;
                double from[3], to[3];
                kn_mark mark = kn_scratch_mark(m->ctx);
                kn_status status = kn_meet_restrict(m, &p, from, to, n->chart, at, n->lo, n->hi);
                if (status == KN_OK && sum) add_points(sum, side, &p, from, to);
                if (status == KN_OK && !sum) lean_of(l, side, &p, from, to, v, c);
                kn_scratch_release(m->ctx, mark);
                if (status != KN_OK) return status;
            }
    return KN_OK;
}

// From what is shared to the middle of the rest, across the fibre, of length 1; false when there is none.
static kn_status direction(kn_meet *m, double out[3], bool *any, const part *side, const double *along)
{
    sums sum = {0};
    kn_status status = survey(m, side, &sum, NULL, NULL, 0.0);
    if (status != KN_OK) return status;
    for (int d = 0; d < 3; d++)
        out[d] = sum.all[d] / (double)sum.n - sum.some[d] / (double)(sum.shared ? sum.shared : 1);
    double t = dot(along, along) > 0.0 ? dot(out, along) / dot(along, along) : 0.0;
    for (int k = 0; k < 3; k++) out[k] -= t * along[k];
    double length = sqrt(dot(out, out));
    *any = length > 0.0;
    for (int k = 0; k < 3 && *any; k++) out[k] /= length;
    return KN_OK;
}

// The plane through the shared fibre, whose direction is `along`, that halves the angle between the two. With
// f >= slope s - touch on one side and <= -(slope s - touch) on the other equal images have slope s <= the sum of
// both touches on both: that part of each box must be shorter than the resolution.
static kn_status try_plane(kn_meet *m, bool *apart, const part side[2], const double *along, const double *point)
{
    double v[3], d[2][3], touch = 0.0;
    lean l[2];
    *apart = false;
    for (int i = 0; i < 2; i++) {
        bool any;
        kn_status status = direction(m, d[i], &any, &side[i], along);
        if (status != KN_OK || !any) return status;
    }
    for (int k = 0; k < 3; k++) v[k] = d[0][k] - d[1][k];
    double length = sqrt(dot(v, v));
    if (!(length > 1e-3)) return KN_OK;
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 3; k++) v[k] = (i ? -1.0 : 1.0) * fabs(1.0 / length) * (d[0][k] - d[1][k]);
        l[i] = (lean){.slope = INFINITY, .least = INFINITY};
        kn_status status = survey(m, &side[i], NULL, &l[i], v, dot(v, point));
        if (status != KN_OK) return status;
        if (!(l[i].slope > 0.0)) return KN_OK;
        touch += l[i].touch;
    }
    *apart = true;
    for (int i = 0; i < 2; i++) {
        // 0.99 pays for the rounding of s, f / s and the weights
        double reach = side[i].node->length[0] + side[i].node->length[1] + side[i].node->length[2];
        *apart = *apart && 2.0 * touch * reach <= m->resolution * l[i].slope * 0.99 * l[i].least / l[i].most;
    }
    return KN_OK;
}

static bool is_end(const kn_meet_chart *c, const kn_meet_node *n, int var, int end)
{
    return end ? n->hi[var] >= c->breaks[var][c->nbreaks[var] - 1] : n->lo[var] <= c->breaks[var][0];
}

// The four corners of a node's (u,v); two that a pole makes one are given once. Returns how many.
static int corners(const kn_meet *m, part *out, const kn_meet_node *n)
{
    const kn_meet_chart *c = &m->charts[n->chart];
    int count = 0;
    for (int i = 0; i < 4; i++) {
        int end[2] = {i / 2, i % 2}, pole = -1;
        for (int d = 0; d < 2; d++)
            if (c->pole[d][end[d]] && is_end(c, n, d, end[d])) pole = d;
        if (pole >= 0 && end[1 - pole] == 1) continue;
        out[count] = (part){.node = n, .end = {end[0], end[1], -1}};
        out[count].special = pole >= 0 || (is_end(c, n, 0, end[0]) && is_end(c, n, 1, end[1]));
        if (pole >= 0) out[count].end[1 - pole] = -1;
        for (int d = 0; d < 2; d++) out[count].at[d] = end[d] ? n->hi[d] : n->lo[d];
        count++;
    }
    return count;
}

// Makes corners into their points on the base, where the node stands on it or hangs from it, and adds apices.
static int points(const kn_meet *m, part *out, const part *corner, int n, const kn_meet_node *node)
{
    const kn_meet_chart *c = &m->charts[node->chart];
    int count = 0, end = node->lo[2] == 0.0 ? 0 : node->hi[2] == 0.0 ? 1 : -1;
    if (end < 0) return 0;
    for (int i = 0; i < n; i++) {
        out[count] = corner[i];
        out[count++].end[2] = end;
    }
    for (int i = 0; i < 4; i++) {
        int d = i / 2, e = i % 2;
        if (!c->apex[d][e] || !is_end(c, node, d, e)) continue;
        out[count] = (part){
            .node = node, .end = {-1, -1, end}, .at = {node->lo[0], node->lo[1], 0.0}, .special = true};
        out[count].end[d] = e, out[count].at[d] = e ? node->hi[d] : node->lo[d];
        count++;
    }
    return count;
}

static kn_status same_point(kn_meet *m, bool *same, double *point, const part *a, const part *b)
{
    double p[3], away = 0.0;
    const part *side[2] = {a, b};
    for (int i = 0; i < 2; i++) {
        const double at[3] = {side[i]->at[0], side[i]->at[1], 0.0};
        kn_status status = kn_meet_point(m, i ? p : point, NULL, side[i]->node->chart, at);
        if (status != KN_OK) return status;
    }
    for (int k = 0; k < 3; k++) away += (p[k] - point[k]) * (p[k] - point[k]);
    *same = sqrt(away) <= m->resolution;
    return KN_OK;
}

// *along: from the lower to the upper end of the fibre's heights, when a and b have the same one.
static kn_status same_fibre(kn_meet *m, bool *same, double *along, double *point, const part *a, const part *b)
{
    double p[2][2][3], away[2] = {0.0, 0.0}, w[2] = {-INFINITY, INFINITY};
    const part *side[2] = {a, b};
    *same = false;
    for (int i = 0; i < 2; i++) {
        const kn_meet_chart *c = &m->charts[side[i]->node->chart];
        w[0] = fmax(w[0], c->breaks[2][0]);
        w[1] = fmin(w[1], c->breaks[2][c->nbreaks[2] - 1]);
    }
    for (int i = 0; i < 2; i++)
        for (int e = 0; e < 2; e++) {
            double at[3] = {side[i]->at[0], side[i]->at[1], w[e]};
            kn_status status = kn_meet_point(m, p[i][e], NULL, side[i]->node->chart, at);
            if (status != KN_OK) return status;
        }
    for (int k = 0; k < 3; k++) {
        double x = p[0][0][k] - p[1][0][k], y = p[0][1][k] - p[1][1][k];
        away[0] += x * x + y * y;
        x = p[0][0][k] - p[1][1][k], y = p[0][1][k] - p[1][0][k];
        away[1] += x * x + y * y;
        along[k] = p[0][1][k] - p[0][0][k];
        point[k] = p[0][0][k];
    }
    *same = sqrt(fmin(away[0], away[1])) <= m->resolution;
    return KN_OK;
}

// Two lists of fibres, or of points: along is 0 then.
static kn_status try_all(kn_meet *m, bool *apart, const part *x, int nx, const part *y, int ny, bool base_alone)
{
    for (int i = 0; i < nx; i++)
        for (int j = 0; j < ny; j++) {
            double along[3] = {0.0}, point[3];
            bool same = false;
            bool one = x[i].node->chart == y[j].node->chart && x[i].at[0] == y[j].at[0] && x[i].at[1] == y[j].at[1];
            if (!one && !(x[i].special && y[j].special)) continue;
            kn_status status = base_alone ? same_point(m, &same, point, &x[i], &y[j])
                                          : same_fibre(m, &same, along, point, &x[i], &y[j]);
            const part side[2] = {x[i], y[j]};
            if (status == KN_OK && same) status = try_plane(m, apart, side, along, point);
            if (status != KN_OK || *apart) return status;
        }
    return KN_OK;
}

kn_status kn_meet_fibre(kn_meet *m, bool *apart, int a, int b)
{
    part x[4], y[4], at[8], to[8];
    *apart = false;
    if (!is_small(&m->nodes[a]) || !is_small(&m->nodes[b])) return KN_OK;
    int nx = corners(m, x, &m->nodes[a]), ny = corners(m, y, &m->nodes[b]);
    kn_status status = try_all(m, apart, x, nx, y, ny, false);
    if (status != KN_OK || *apart) return status;
    int na = points(m, at, x, nx, &m->nodes[a]), nb = points(m, to, y, ny, &m->nodes[b]);
    return try_all(m, apart, at, na, to, nb, true);
}
