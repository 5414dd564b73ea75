// SPDX-License-Identifier: Apache-2.0
// All places that a shell maps to a point: the search for zeros on the leaves whose boxes hold the point, and the
// poles apart.
#include "kernel/context.h"
#include "trivar/internal.h"
#include "trivar/inverse.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_BOXES = 16384, LEAST_BOXES = 256, WORK = 1 << 22, MAX_OPEN = 512, STACK = 128 };

static bool in_box(const double *lo, const double *hi, const double *p)
{
    return p[0] >= lo[0] && p[0] <= hi[0] && p[1] >= lo[1] && p[1] <= hi[1] && p[2] >= lo[2] && p[2] <= hi[2];
}

static bool in_leaf(const kn_leaf *leaf, const double *p)
{
    if (!in_box(leaf->space_lo, leaf->space_hi, p)) return false;
    const double *m = leaf->to;
    for (int k = 0; k < 3; k++, m += 3) {
        double y = m[0] * p[0] + m[1] * p[1] + m[2] * p[2];
        if (y < leaf->least[k] || y > leaf->most[k]) return false;
    }
    return true;
}

static kn_status add_leaf(kn_ctx *ctx, kn_cells *cells, const kn_shell_inverse *v, size_t i, const double *p)
{
    double *coef, *error, *box;
    size_t m = (size_t)v->net.ncomp;
    kn_status status = kn_cells_add(ctx, cells, &coef, &error, &box);
    if (status != KN_OK) return status;
    kn_leaf_shift(coef, error, &v->net, v->coef + i * m * v->net.count, v->error + i * m, p);
    memcpy(box, v->leaf[i].lo, 3 * sizeof *box);
    memcpy(box + 3, v->leaf[i].hi, 3 * sizeof *box);
    return KN_OK;
}

static kn_status gather(kn_ctx *ctx, kn_cells *cells, const kn_shell_inverse *v, const double *p)
{
    size_t stack[STACK], depth = 0;
    kn_status status = KN_OK;
    stack[depth++] = 0;
    while (depth > 0 && status == KN_OK) {
        size_t at = stack[--depth];
        const kn_leaf_node *node = &v->node[at];
        if (!in_box(node->lo, node->hi, p)) continue;
        for (size_t i = node->first; i < node->first + node->count && status == KN_OK; i++)
            if (in_leaf(&v->leaf[v->order[i]], p)) status = add_leaf(ctx, cells, v, v->order[i], p);
        if (node->count == 0) stack[depth++] = node->other, stack[depth++] = at + 1;
    }
    return status;
}

// ---- poles ----

// Whether the point is on the axis, as far as T is known, and the slopes of T beside the pole lie on one side of a
// plane through the axis: then T - axis(w) = t slope vanishes at t = 0 alone. w in [0,1] of the pole's interval.
static bool opens(const kn_pole *pole, double w, const double *p)
{
    const kn_bezier *s = &pole->slope;
    int n = s->degree[0];
    size_t plane = kn_bezier_count(s), along = (size_t)pole->axis.degree[0] + 1;
    double value[KN_MAX_DEGREE + 1][3], axis[3], away[3], middle[3] = {0}, length = 0.0, wide = 0.0, off = 0.0,
                                                          dot = 0.0;
    if (s->degree[1] != 1) return false; // not a straight axis
    for (size_t c = 0; c < 3; c++) {
        const double *a = pole->axis.coef;
        double w0 = pole->axis.rational ? a[3 * along] : 1.0, w1 = pole->axis.rational ? a[3 * along + 1] : 1.0;
        double weight = (1.0 - w) * w0 + w * w1;
        axis[c] = a[c * along + 1] / w1 - a[c * along] / w0;
        away[c] = p[c] - ((1.0 - w) * a[c * along] + w * a[c * along + 1]) / weight;
        length += axis[c] * axis[c];
        dot += axis[c] * away[c];
    }
    for (int c = 0; c < 3; c++) off = fmax(off, fabs(away[c] - dot / length * axis[c]));
    if (!(length > 0.0 && off <= pole->error)) return false;
    for (int o = 0; o <= n; o++) {
        dot = 0.0;
        for (size_t c = 0; c < 3; c++) {
            const double *x = s->coef + c * plane + (size_t)o * 2, *h = s->coef + 3 * plane + (size_t)o * 2;
            value[o][c] = (1.0 - w) * x[0] + w * x[1];
            if (s->ncomp > 3) value[o][c] -= p[c] * ((1.0 - w) * h[0] + w * h[1]);
            dot += value[o][c] * axis[c];
        }
        for (int c = 0; c < 3; c++) middle[c] += value[o][c] -= dot / length * axis[c];
    }
    for (int c = 0; c < 3; c++) wide += fabs(middle[c]);
    double point = 1.0 + fabs(p[0]) + fabs(p[1]) + fabs(p[2]);
    double slack = wide * point * 2.0 * (pole->slope_error + 0x1p-30 * kn_largest(s->coef, plane * (size_t)s->ncomp));
    for (int o = 0; o <= n; o++)
        if (!(value[o][0] * middle[0] + value[o][1] * middle[1] + value[o][2] * middle[2] > slack)) return false;
    return true;
}

static bool opens_all_round(const kn_shell_inverse *v, const kn_pole *like, double w, const double *p)
{
    bool all = true;
    for (size_t i = 0; i < v->npoles && all; i++) {
        const kn_pole *q = &v->pole[i];
        if (q->var != like->var || q->end != like->end || q->lo[2] != like->lo[2]) continue;
        all = opens(q, (w - q->lo[2]) / (q->hi[2] - q->lo[2]), p);
    }
    return all;
}

// Where the axis of one pole passes the point within its reach.
static kn_status solve_axis(kn_ctx *ctx, kn_root **roots, size_t *n, const kn_shell_inverse *v, const kn_pole *pole,
                            const double *p)
{
    kn_cells cells = {
        .net = kn_net_make(1, v->net.ncomp, pole->axis.degree), .lo = {pole->lo[2]}, .hi = {pole->hi[2]}};
    double *coef, *error, *box, own[4] = {0};
    kn_net four = cells.net;
    kn_solve_options o = kn_solve_defaults();
    cells.net.ncomp = 3;
    o.residual = pole->reach;
    o.max_boxes = MAX_BOXES;
    kn_status status = kn_cells_add(ctx, &cells, &coef, &error, &box);
    if (status == KN_OK) {
        kn_leaf_shift(coef, error, &four, pole->axis.coef, own, p);
        box[0] = pole->lo[2], box[1] = pole->hi[2];
        status = kn_cells_solve(ctx, roots, n, NULL, &cells, &o);
    }
    kn_cells_clear(ctx, &cells);
    return status;
}

typedef struct list {
    kn_support *item;
    size_t n, room;
} list;

static kn_status push(kn_ctx *ctx, list *l, const kn_support *s)
{
    if (l->n == l->room) {
        size_t room = 2 * l->room + 8;
        kn_support *more = l->item ? kn_resize(ctx, l->item, room, sizeof *more) : kn_alloc(ctx, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        l->item = more;
        l->room = room;
    }
    l->item[l->n++] = *s;
    return KN_OK;
}

static void set_parameter(kn_support *s, int d, double at, double lo, double hi)
{
    s->uvw[d] = at;
    s->error[d] = fmax(hi - at, at - lo) * (1.0 + 0x1p-50);
}

// One place for each end of a variable and root along its axis, whatever the number of pieces around it.
static kn_status add_poles(kn_ctx *ctx, list *l, const kn_shell_inverse *v, const double *p)
{
    kn_status status = KN_OK;
    for (size_t i = 0; i < v->npoles && status == KN_OK; i++) {
        const kn_pole *q = &v->pole[i];
        bool first = in_box(q->space_lo, q->space_hi, p);
        for (size_t j = 0; j < i && first; j++)
            first = q->var != v->pole[j].var || q->end != v->pole[j].end || q->lo[2] != v->pole[j].lo[2];
        if (!first) continue;
        kn_root *roots = NULL;
        size_t n = 0;
        status = solve_axis(ctx, &roots, &n, v, q, p);
        for (size_t k = 0; k < n && status == KN_OK; k++) {
            kn_support s = {.at_edge = true, .certified = n == 1 && opens_all_round(v, q, roots[k].at[0], p)};
            int other = 1 - q->var;
            set_parameter(&s, other, 0.5 * v->lo[other] + 0.5 * v->hi[other], v->lo[other], v->hi[other]);
            set_parameter(&s, q->var, q->end ? q->hi[q->var] : q->lo[q->var], q->lo[q->var], q->hi[q->var]);
            set_parameter(&s, 2, roots[k].at[0], roots[k].lo[0], roots[k].hi[0]);
            status = push(ctx, l, &s);
        }
        kn_free(ctx, roots);
    }
    return status;
}

// ---- one place for what touches ----

static bool touch(const kn_support *a, const kn_support *b, const double *shift)
{
    for (int d = 0; d < 3; d++)
        if (!(fabs(a->uvw[d] + shift[d] - b->uvw[d]) <= a->error[d] + b->error[d])) return false;
    return true;
}

static void join(kn_support *a, const kn_support *b, const kn_shell_inverse *v)
{
    a->certified = false;
    for (int d = 0; d < 3; d++) {
        double lo = fmin(a->uvw[d] - a->error[d], b->uvw[d] - b->error[d]);
        double hi = fmax(a->uvw[d] + a->error[d], b->uvw[d] + b->error[d]);
        set_parameter(a, d, fmin(fmax(0.5 * lo + 0.5 * hi, v->lo[d]), v->hi[d]), lo, hi);
    }
    a->at_edge = a->at_edge || b->at_edge;
}

static void drop(list *l, size_t i)
{
    l->item[i] = l->item[--l->n];
}

// A pole takes the place of what touches it and is as near to it.
static void join_poles(list *l, size_t npoles, const kn_shell_inverse *v)
{
    static const double none[3] = {0};
    for (size_t i = 0; i < npoles; i++)
        for (size_t j = npoles; j < l->n; j++) {
            kn_support *pole = &l->item[i];
            int var = pole->error[0] > pole->error[1] ? 1 : 0; // which ends
            bool near = l->item[j].error[var] <= 0x1p-36 * (v->hi[var] - v->lo[var]);
            if (!near || !touch(pole, &l->item[j], none)) continue;
            bool certified = pole->certified;
            join(pole, &l->item[j], v);
            pole->certified = certified;
            drop(l, j--);
        }
}

// Boxes that are not certified become one where they touch. `all`: certified ones too, which may hold the same place.
static void join_touching(list *l, size_t npoles, bool all, const kn_shell_inverse *v)
{
    static const double none[3] = {0};
    for (size_t i = npoles; i < l->n; i++)
        for (size_t j = i + 1; j < l->n; j++) {
            kn_support *a = &l->item[i], *b = &l->item[j];
            if ((!all && (a->certified || b->certified)) || !touch(a, b, none)) continue;
            join(a, b, v);
            drop(l, j);
            j = i; // the box has grown
        }
}

// The two ends of a closed variable are one: the lower end stays. Boxes as long as that are left alone.
static void join_seams(list *l, const kn_shell_inverse *v)
{
    for (int d = 0; d < 2; d++) {
        double shift[3] = {0}, period = v->hi[d] - v->lo[d];
        shift[d] = period;
        for (size_t i = 0; i < l->n && v->closed[d]; i++)
            for (size_t j = 0; j < l->n; j++) {
                kn_support *a = &l->item[i], *b = &l->item[j];
                bool ends = i != j && a->uvw[d] - a->error[d] <= v->lo[d] && b->uvw[d] + b->error[d] >= v->hi[d];
                if (!ends || a->error[d] > 0.125 * period || b->error[d] > 0.125 * period) continue;
                if (!touch(a, b, shift)) continue;
                a->certified = a->certified && b->certified;
                if (i == l->n - 1) i = j; // where a goes
                drop(l, j--);
            }
    }
}

static int by_height(const void *a, const void *b)
{
    const kn_support *x = a, *y = b;
    double hx = fabs(x->uvw[2]), hy = fabs(y->uvw[2]);
    if (hx != hy) return hx < hy ? -1 : 1;
    for (int d = 2; d >= 0; d--)
        if (x->uvw[d] != y->uvw[d]) return x->uvw[d] < y->uvw[d] ? -1 : 1;
    return 0;
}

static kn_status solve_leaves(kn_ctx *ctx, list *l, bool *complete, bool *curve, const kn_shell_inverse *v,
                              const double *p)
{
    kn_cells cells = {.net = v->net, .jumps = v->jumps};
    kn_solve_options o = kn_solve_defaults();
    kn_solve_report report = {0};
    kn_root *roots = NULL;
    size_t n = 0;
    cells.net.ncomp = 3;
    size_t boxes = WORK / (3 * v->net.count);
    o.max_boxes = boxes > MAX_BOXES ? MAX_BOXES : boxes < LEAST_BOXES ? LEAST_BOXES : boxes;
    o.max_undecided = MAX_OPEN;
    memcpy(cells.lo, v->lo, sizeof v->lo);
    memcpy(cells.hi, v->hi, sizeof v->hi);
    kn_status status = gather(ctx, &cells, v, p);
    if (status == KN_OK && cells.count > 0) status = kn_cells_solve(ctx, &roots, &n, &report, &cells, &o);
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        kn_support s = {.certified = roots[i].kind == KN_ROOT_UNIQUE, .at_edge = roots[i].at_edge};
        for (int d = 0; d < 3; d++) set_parameter(&s, d, roots[i].at[d], roots[i].lo[d], roots[i].hi[d]);
        status = push(ctx, l, &s);
    }
    *curve = report.curve_like;
    *complete = !report.limited && !report.curve_like;
    kn_free(ctx, roots);
    kn_cells_clear(ctx, &cells);
    return status;
}

kn_status kn_shell_support(kn_ctx *ctx, kn_support **supports, size_t *n, bool *complete,
                           const kn_shell_inverse *inverse, const double point[3])
{
    double p[3];
    list l = {0};
    bool all = true, curve = false;
    for (int c = 0; c < 3; c++) {
        if (!isfinite(point[c])) return kn_fail(ctx, KN_EDOMAIN, "support: component %d is %g", c, point[c]);
        p[c] = point[c] * inverse->scale;
    }
    kn_status status = add_poles(ctx, &l, inverse, p);
    size_t npoles = l.n;
    if (status == KN_OK) status = solve_leaves(ctx, &l, &all, &curve, inverse, p);
    if (status != KN_OK) {
        kn_free(ctx, l.item);
        return status;
    }
    join_poles(&l, npoles, inverse);
    join_touching(&l, npoles, curve, inverse);
    join_seams(&l, inverse);
    if (l.n > 1) qsort(l.item, l.n, sizeof *l.item, by_height);
    *supports = l.item;
    *n = l.n;
    *complete = all;
    return KN_OK;
}
