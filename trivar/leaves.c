// SPDX-License-Identifier: Apache-2.0
// T cut until Newton's method is safe: on a leaf, and an eighth beyond it, the derivative of Y T differs from the
// identity by less than GOOD, Y the inverse of the Jacobian in the middle. Where T folds or has a pole that cannot
// be; there the cutting ends after some halvings and is left to the search.
#include "kernel/context.h"
#include "trivar/internal.h"
#include "trivar/inverse.h"

#include <string.h>

static const double GOOD = 0.6, WIDER = 0.125, RUNG = 0.25, LAST_RUNG = 0x1p-40;

typedef struct cutter {
    kn_shell_inverse *inverse;
    const kn_brick *brick;
    kn_finder f;  // for three equations on one box
    double *part; // the coordinates over the box, homogeneous ones when T is rational
    double part_error[4];
    double *work;
} cutter;

void kn_leaf_shift(double *out, double *out_error, const kn_net *net, const double *coef, const double *error,
                   const double point[3])
{
    size_t n = net->count;
    const double *w = net->ncomp > 3 ? coef + 3 * n : NULL;
    double heavy = w ? kn_largest(w, n) : 1.0;
    for (size_t c = 0; c < 3; c++) {
        const double *x = coef + c * n;
        double p = point[c];
        for (size_t i = 0; i < n; i++) out[c * n + i] = w ? x[i] - p * w[i] : x[i] - p;
        out_error[c] = (error[c] + (w ? fabs(p) * error[3] : 0.0) +
                        kn_rounding(3.0) * (kn_largest(x, n) + fabs(p) * heavy) + kn_underflow()) *
                       (1.0 + 0x1p-40);
    }
}

// The equations T = T(middle) over the box, and about the inverse of their Jacobian there. False: it is singular.
static bool prepare(cutter *c, const double *lo, const double *hi)
{
    const kn_net *net = &c->inverse->net;
    double middle[3] = {0.5, 0.5, 0.5}, value[4], jacobian[12], point[3];
    for (int k = 0; k < net->ncomp; k++) c->part_error[k] = c->brick->error[k];
    kn_net_restrict(c->part, c->part_error, net, c->brick->coef, lo, hi, c->work);
    kn_net_jacobian(net, c->part, middle, value, jacobian, c->work);
    for (int k = 0; k < 3; k++) point[k] = c->inverse->rational ? value[k] / value[3] : value[k];
    kn_leaf_shift(c->f.coef, c->f.error, net, c->part, c->part_error, point);
    kn_net_jacobian(&c->f.net, c->f.coef, middle, value, jacobian, c->f.work);
    return kn_left_inverse(c->f.y, jacobian, 3, 3);
}

static double departure(cutter *c, const double *lo, const double *hi)
{
    double a[3], b[3];
    for (int d = 0; d < 3; d++) {
        double more = WIDER * (hi[d] - lo[d]);
        a[d] = lo[d] - more;
        b[d] = hi[d] + more;
    }
    if (!prepare(c, a, b)) return INFINITY;
    kn_finder_combine(&c->f);
    return kn_finder_kappa(&c->f);
}

// ---- one leaf ----

static void find_boxes(cutter *c, kn_leaf *leaf, bool regular)
{
    const kn_net *net = &c->inverse->net;
    size_t n = net->count;
    const double *w = c->inverse->rational ? c->part + 3 * n : NULL;
    double slack[3], size = 0.0, lightest = 1.0;
    for (size_t i = 0; i < n && w; i++) lightest = fmin(lightest, w[i] - c->part_error[3]);
    for (int k = 0; k < 9; k++) leaf->to[k] = regular ? c->f.y[k] : k % 4 == 0;
    for (int k = 0; k < 3; k++) {
        leaf->space_lo[k] = leaf->least[k] = INFINITY;
        leaf->space_hi[k] = leaf->most[k] = -INFINITY;
    }
    for (size_t i = 0; i < n; i++) {
        double q[3];
        for (size_t k = 0; k < 3; k++) {
            q[k] = w ? c->part[k * n + i] / w[i] : c->part[k * n + i];
            size = fmax(size, fabs(q[k]));
            leaf->space_lo[k] = fmin(leaf->space_lo[k], q[k]);
            leaf->space_hi[k] = fmax(leaf->space_hi[k], q[k]);
        }
        for (int k = 0; k < 3; k++) {
            double y = leaf->to[3 * k] * q[0] + leaf->to[3 * k + 1] * q[1] + leaf->to[3 * k + 2] * q[2];
            leaf->least[k] = fmin(leaf->least[k], y);
            leaf->most[k] = fmax(leaf->most[k], y);
        }
    }
    if (!(lightest > 0.0)) size = INFINITY; // weights that may vanish: no box
    for (int k = 0; k < 3; k++) { // a quotient, its error, and the sums here and for the point that is looked for
        double e = c->part_error[k] + (w ? size * c->part_error[3] : 0.0);
        slack[k] = 2.0 * e / lightest + kn_rounding(16.0) * size;
        double more = slack[k] + 0x1p-30 * (leaf->space_hi[k] - leaf->space_lo[k]);
        leaf->space_lo[k] -= more;
        leaf->space_hi[k] += more;
    }
    for (int k = 0; k < 3; k++) {
        double more = 0x1p-30 * (leaf->most[k] - leaf->least[k]);
        for (int d = 0; d < 3; d++) more += 2.0 * fabs(leaf->to[3 * k + d]) * slack[d];
        leaf->least[k] -= more;
        leaf->most[k] += more;
    }
}

static kn_status grow(kn_ctx *ctx, kn_shell_inverse *v)
{
    if (v->nleaves < v->room) return KN_OK;
    size_t room = 2 * v->room + 16, m = (size_t)v->net.ncomp, size = m * v->net.count;
    kn_leaf *leaf = v->leaf ? kn_resize(ctx, v->leaf, room, sizeof *leaf) : kn_alloc(ctx, room, sizeof *leaf);
    if (!leaf) return KN_ENOMEM;
    v->leaf = leaf;
    double *coef = v->coef ? kn_resize(ctx, v->coef, room * size, sizeof *coef)
                           : kn_alloc(ctx, room * size, sizeof *coef);
    if (!coef) return KN_ENOMEM;
    v->coef = coef;
    double *error = v->error ? kn_resize(ctx, v->error, room * m, sizeof *error)
                             : kn_alloc(ctx, room * m, sizeof *error);
    if (!error) return KN_ENOMEM;
    v->error = error;
    v->room = room;
    return KN_OK;
}

static double in_domain(const kn_brick *b, int d, double s)
{
    return s == 1.0 ? b->hi[d] : b->lo[d] + s * (b->hi[d] - b->lo[d]);
}

static kn_status emit(kn_ctx *ctx, cutter *c, const double *lo, const double *hi)
{
    kn_shell_inverse *v = c->inverse;
    kn_status status = grow(ctx, v);
    if (status != KN_OK) return status;
    kn_leaf *leaf = &v->leaf[v->nleaves];
    size_t m = (size_t)v->net.ncomp;
    find_boxes(c, leaf, prepare(c, lo, hi));
    for (int d = 0; d < 3; d++) {
        leaf->lo[d] = in_domain(c->brick, d, lo[d]);
        leaf->hi[d] = in_domain(c->brick, d, hi[d]);
    }
    memcpy(v->coef + v->nleaves * m * v->net.count, c->part, m * v->net.count * sizeof *c->part);
    memcpy(v->error + v->nleaves * m, c->part_error, m * sizeof *c->part_error);
    v->nleaves++;
    return KN_OK;
}

// Halves the variable that helps most.
static kn_status cut(kn_ctx *ctx, cutter *c, const double *lo, const double *hi, int depth)
{
    double now = depth > 0 ? departure(c, lo, hi) : 0.0, best = INFINITY, a[3], b[3];
    int var = -1;
    if (now < GOOD) return emit(ctx, c, lo, hi);
    int steepest = kn_net_steepest(&c->f.net, c->f.coef, c->f.error);
    for (int d = 0; d < 3; d++) {
        memcpy(b, hi, sizeof b);
        b[d] = 0.5 * (lo[d] + hi[d]);
        double kappa = departure(c, lo, b);
        if (kappa < best) best = kappa, var = d;
    }
    if (var < 0) var = steepest < 0 ? 0 : steepest;
    memcpy(a, lo, sizeof a);
    memcpy(b, hi, sizeof b);
    a[var] = b[var] = 0.5 * (lo[var] + hi[var]);
    kn_status status = cut(ctx, c, lo, b, depth - 1);
    return status == KN_OK ? cut(ctx, c, a, hi, depth - 1) : status;
}

// ---- poles ----

// The coefficients of T along variable var of one component: element (o, k, w), k counted from the end, o along the
// other variable.
static const double *place(const kn_net *net, const double *coef, int var, int end, int o, int k, int w)
{
    int n = net->degree[var], at[3] = {0, 0, w};
    at[var] = end ? n - k : k;
    at[1 - var] = o;
    return coef + ((size_t)at[0] * (size_t)(net->degree[1] + 1) + (size_t)at[1]) * (size_t)(net->degree[2] + 1) +
           (size_t)at[2];
}

// Between T and its axis there are at most `part` derivatives along var.
static double bound_reach(const cutter *c, int var, double part)
{
    const kn_net *net = &c->inverse->net;
    size_t n = net->count, inner = kn_net_inner(net, var), row = (size_t)net->degree[var] * inner;
    double steep[2] = {0}, size = 0.0, lightest = 1.0;
    for (size_t k = 0; k < (size_t)net->ncomp; k++) {
        const double *a = c->brick->coef + k * n;
        for (size_t o = 0; o < n; o += row + inner)
            for (size_t i = o; i < o + row; i++) steep[k > 2] = fmax(steep[k > 2], fabs(a[i + inner] - a[i]));
    }
    for (size_t i = 0; i < n && net->ncomp > 3; i++) lightest = fmin(lightest, c->brick->coef[3 * n + i]);
    for (size_t i = 0; i < 3 * n; i++) size = fmax(size, fabs(c->brick->coef[i]));
    size /= lightest;
    return 4.0 * part * net->degree[var] * (steep[0] + size * steep[1]) / lightest;
}

static kn_status add_pole(kn_ctx *ctx, cutter *c, int var, int end, double part)
{
    kn_shell_inverse *v = c->inverse;
    const kn_net *net = &v->net;
    if (v->npoles == v->pole_room) {
        size_t room = 2 * v->pole_room + 4;
        kn_pole *more = v->pole ? kn_resize(ctx, v->pole, room, sizeof *more) : kn_alloc(ctx, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        v->pole = more;
        v->pole_room = room;
    }
    kn_pole *p = &v->pole[v->npoles];
    *p = (kn_pole){.var = var, .end = end};
    const int shape[2] = {net->degree[1 - var], net->degree[2]};
    kn_status status = kn_bezier_init(ctx, &p->axis, 1, net->ncomp, v->rational, shape + 1);
    if (status != KN_OK) return status;
    v->npoles++;
    status = kn_bezier_init(ctx, &p->slope, 2, net->ncomp, false, shape);
    if (status != KN_OK) return status;
    double error = 0.0, largest = 0.0;
    size_t along = (size_t)shape[1] + 1, plane = (size_t)(shape[0] + 1) * along;
    for (int k = 0; k < net->ncomp; k++) {
        const double *a = c->brick->coef + (size_t)k * net->count;
        for (int w = 0; w <= shape[1]; w++) {
            p->axis.coef[(size_t)k * along + (size_t)w] = *place(net, a, var, end, 0, 0, w);
            for (int o = 0; o <= shape[0]; o++)
                p->slope.coef[(size_t)k * plane + (size_t)o * along + (size_t)w] =
                    net->degree[var] * (*place(net, a, var, end, o, 1, w) - *place(net, a, var, end, o, 0, w));
        }
        error = fmax(error, c->brick->error[k]);
        largest = fmax(largest, kn_largest(a, net->count));
    }
    double n = net->degree[var];
    p->slope_error = 4.0 * n * error + 8.0 * part * n * n * largest;
    p->error = error;
    p->reach = bound_reach(c, var, part) + 8.0 * error;
    for (size_t k = 0; k < 3; k++) {
        p->space_lo[k] = INFINITY, p->space_hi[k] = -INFINITY;
        for (size_t w = 0; w < along; w++) {
            double x = p->axis.coef[k * along + w] / (v->rational ? p->axis.coef[3 * along + w] : 1.0);
            p->space_lo[k] = fmin(p->space_lo[k], x - 2.0 * p->reach);
            p->space_hi[k] = fmax(p->space_hi[k], x + 2.0 * p->reach);
        }
    }
    for (int d = 0; d < 3; d++) {
        p->lo[d] = c->brick->lo[d];
        p->hi[d] = c->brick->hi[d];
    }
    (end ? p->lo : p->hi)[var] = in_domain(c->brick, var, end ? 1.0 - part : part);
    return KN_OK;
}

// Towards a pole, rungs that are RUNG times as wide each; all look alike from inside.
static kn_status climb(kn_ctx *ctx, cutter *c, double *lo, double *hi, int var, int end)
{
    double far = hi[var] - lo[var];
    for (; far > LAST_RUNG; far *= RUNG) {
        double near = RUNG * far;
        lo[var] = end ? 1.0 - far : near;
        hi[var] = end ? 1.0 - near : far;
        kn_status status = cut(ctx, c, lo, hi, 0);
        if (status != KN_OK) return status;
    }
    return add_pole(ctx, c, var, end, far);
}

static kn_status cut_brick(kn_ctx *ctx, cutter *c)
{
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0};
    for (int var = 0; var < 2; var++) { // poles of one variable: those of the other would meet them in corners
        const bool *pole = c->brick->pole[var];
        if (!pole[0] && !pole[1]) continue;
        if (pole[0] && pole[1]) {
            hi[var] = 0.5;
            kn_status status = climb(ctx, c, lo, hi, var, 0);
            lo[var] = 0.5, hi[var] = 1.0;
            return status == KN_OK ? climb(ctx, c, lo, hi, var, 1) : status;
        }
        return climb(ctx, c, lo, hi, var, pole[1]);
    }
    return cut(ctx, c, lo, hi, c->inverse->depth);
}

kn_status kn_leaves_add(kn_ctx *ctx, kn_shell_inverse *inverse, const kn_brick *brick)
{
    const kn_net *net = &inverse->net;
    size_t n = net->count;
    cutter c = {.inverse = inverse, .brick = brick};
    kn_mark mark = kn_scratch_mark(ctx);
    c.f.net = c.f.square = *net;
    c.f.net.ncomp = c.f.square.ncomp = 3;
    for (int d = 0; d < 3; d++) c.f.ratio[d] = 1.0;
    double *room = kn_scratch(ctx, 20 * n + 16, sizeof *room);
    kn_status status = room ? KN_OK : KN_ENOMEM;
    if (room) {
        c.part = room;
        c.work = room + 4 * n;
        c.f.coef = room + 9 * n;
        c.f.g = room + 12 * n;
        c.f.work = room + 15 * n;
        c.f.error = room + 20 * n;
        c.f.g_error = c.f.error + 3;
        c.f.y = c.f.error + 6;
        status = cut_brick(ctx, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
