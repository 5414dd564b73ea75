// SPDX-License-Identifier: Apache-2.0
// A shell made ready for its inverse: the pieces of T, their leaves, and a hierarchy of boxes over these.
#include "trivar/inverse.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "kernel/knots.h"
#include "solve/cells.h"
#include "trivar/internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static const double CLOSED = 1e-11, COLLAPSED = 0x1p-43;
enum { MANY = 256, MAX_DEPTH = 6 };

// All pieces of T: between neighbouring knots of n (which are all there are, or lines of the shell), or of a volume.
typedef struct bricks {
    double *breaks[3];
    int n[3]; // intervals
    size_t count, size;
    double *coef, *error; // size, and the inverse's net.ncomp, for each
} bricks;

void kn_shell_inverse_destroy(kn_ctx *ctx, kn_shell_inverse *inverse)
{
    if (!inverse) return;
    for (size_t i = 0; i < inverse->npoles; i++) {
        kn_bezier_clear(ctx, &inverse->pole[i].axis);
        kn_bezier_clear(ctx, &inverse->pole[i].slope);
    }
    kn_free(ctx, inverse->pole);
    kn_free(ctx, inverse->leaf);
    kn_free(ctx, inverse->coef);
    kn_free(ctx, inverse->error);
    kn_free(ctx, inverse->order);
    kn_free(ctx, inverse->node);
    kn_free(ctx, inverse);
}

// ---- pieces ----

static kn_status take_room(kn_ctx *ctx, bricks *b, const kn_net *net)
{
    b->count = (size_t)b->n[0] * (size_t)b->n[1] * (size_t)b->n[2];
    b->size = (size_t)net->ncomp * net->count;
    if ((double)b->count * (double)b->size > (double)KN_MAX_COEFS)
        return kn_fail(ctx, KN_ELIMIT, "inverse: %zu pieces of %zu coefficients", b->count, b->size);
    b->coef = kn_alloc_zero(ctx, b->count * b->size, sizeof *b->coef);
    b->error = kn_alloc_zero(ctx, b->count * (size_t)net->ncomp, sizeof *b->error);
    return b->coef && b->error ? KN_OK : KN_ENOMEM;
}

// Convex combinations all of them (extraction, lines, restriction, elevation) but for the products h n, W n and w^k.
static double roundings_of(const kn_net *net, int nterms)
{
    return 18.0 * (net->degree[0] + net->degree[1] + 2) + 2.0 * 128.0 + 8.0 * net->degree[2] + nterms + 16.0;
}

// Adds term w^power to the coefficients of one brick, and to its errors.
static kn_status add_term(kn_ctx *ctx, double *coef, double *error, const kn_net *net, kn_bezier *term, int power,
                          int nterms, const double w[2])
{
    double height[KN_MAX_DEGREE + 1];
    kn_status status = kn_bezier_elevate(ctx, term, term, net->degree);
    if (status != KN_OK) return status;
    size_t row = (size_t)net->degree[2] + 1, n = net->count / row;
    double high = pow(fmax(fabs(w[0]), fabs(w[1])), power);
    kn_bernstein_power(height, power, net->degree[2], w[0], w[1]);
    for (size_t i = 0; i < (size_t)net->ncomp * n; i++)
        for (size_t j = 0; j < row; j++) coef[i * row + j] += term->coef[i] * height[j];
    for (int c = 0; c < net->ncomp; c++)
        error[c] += kn_rounding(roundings_of(net, nterms)) * high * kn_largest(term->coef + (size_t)c * n, n);
    return KN_OK;
}

static kn_status piece_over(kn_ctx *ctx, kn_shell_piece *piece, const kn_shell *shell, int i, int j)
{
    const int at[2] = {i, j};
    double lo[2], hi[2];
    int cell[2];
    bool fits = false;
    for (int v = 0; v < 2; v++) {
        const double *cut = shell->cut[v] + at[v], *line = shell->line[v];
        cell[v] = kn_interval(line, shell->nlines[v], 0.5 * cut[0] + 0.5 * cut[1]);
        double width = line[cell[v] + 1] - line[cell[v]];
        lo[v] = (cut[0] - line[cell[v]]) / width;
        hi[v] = cut[1] == line[cell[v] + 1] ? 1.0 : (cut[1] - line[cell[v]]) / width;
    }
    kn_status status = kn_shell_piece_init(ctx, piece, &fits, shell, cell, lo, hi, 0);
    assert(status != KN_OK || (fits && piece->exact));
    return status;
}

static void find_degrees(kn_net *net, const kn_shell_piece *piece)
{
    int degree[3] = {0, 0, 1};
    for (int t = 0; t < piece->nterms; t++) {
        for (int v = 0; v < 2; v++)
            if (piece->term[t].degree[v] > degree[v]) degree[v] = piece->term[t].degree[v];
        if (piece->power[t] > degree[2]) degree[2] = piece->power[t];
    }
    *net = kn_net_make(3, piece->term[0].ncomp, degree);
}

static kn_status bricks_of_terms(kn_ctx *ctx, bricks *b, kn_net *net, const kn_shell *shell, const double w[2])
{
    kn_status status = KN_OK;
    for (int v = 0; v < 2; v++) {
        b->n[v] = shell->ncuts[v] - 1;
        memcpy(b->breaks[v], shell->cut[v], (size_t)shell->ncuts[v] * sizeof *b->breaks[v]);
    }
    b->n[2] = 1;
    memcpy(b->breaks[2], w, 2 * sizeof *w);
    for (int i = 0; i < b->n[0]; i++)
        for (int j = 0; j < b->n[1] && status == KN_OK; j++) {
            kn_shell_piece piece = {0};
            size_t at = (size_t)i * (size_t)b->n[1] + (size_t)j;
            status = piece_over(ctx, &piece, shell, i, j);
            if (status == KN_OK && at == 0) {
                find_degrees(net, &piece);
                if (net->degree[2] > KN_MAX_DEGREE)
                    status = kn_fail(ctx, KN_ELIMIT, "inverse: degree %d in w", net->degree[2]);
                if (status == KN_OK) status = take_room(ctx, b, net);
            }
            for (int t = 0; t < piece.nterms && status == KN_OK; t++)
                status = add_term(ctx, b->coef + at * b->size, b->error + at * (size_t)net->ncomp, net,
                                  &piece.term[t], piece.power[t], piece.nterms, w);
            kn_shell_piece_clear(ctx, &piece);
        }
    return status;
}

static kn_status bricks_of_volume(kn_ctx *ctx, bricks *b, kn_net *net, const kn_spline *volume)
{
    kn_bezier *piece = NULL;
    size_t npieces = 0, n = kn_spline_count(volume);
    double steps = 8.0; // two maps of knots
    *net = kn_net_make(3, volume->ncomp, volume->degree);
    for (int d = 0; d < 3; d++) {
        b->n[d] = kn_knots_breaks(b->breaks[d], NULL, volume->knots[d], volume->degree[d], volume->count[d]) - 1;
        steps += 2.0 * (6.0 * volume->degree[d] + 1.0);
    }
    kn_status status = take_room(ctx, b, net);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &piece, &npieces, volume);
    for (size_t i = 0; i < npieces && status == KN_OK && b->coef; i++) {
        memcpy(b->coef + i * b->size, piece[i].coef, b->size * sizeof *b->coef);
        for (size_t c = 0; c < (size_t)net->ncomp; c++)
            b->error[i * (size_t)net->ncomp + c] = kn_rounding(steps) * kn_largest(volume->coef + c * n, n);
        kn_bezier_clear(ctx, &piece[i]);
    }
    kn_free(ctx, piece);
    return status;
}

static kn_status room_for_breaks(kn_ctx *ctx, bricks *b, const int room[3])
{
    for (int d = 0; d < 3; d++) {
        b->breaks[d] = kn_scratch(ctx, (size_t)room[d], sizeof *b->breaks[d]);
        if (!b->breaks[d]) return KN_ENOMEM;
    }
    return KN_OK;
}

static kn_status make_bricks(kn_ctx *ctx, bricks *b, kn_shell_inverse *v, const kn_shell *shell, const double w[2])
{
    if (!shell->volume.coef) {
        const int room[3] = {shell->ncuts[0], shell->ncuts[1], 2};
        kn_status status = room_for_breaks(ctx, b, room);
        v->jumps = kn_may_jump(&shell->surface) || (shell->normal.coef && kn_may_jump(&shell->normal));
        for (int k = 0; k < shell->nfields; k++) v->jumps = v->jumps || kn_may_jump(&shell->field[k].whole);
        if (shell->thickness.whole.coef) v->jumps = v->jumps || kn_may_jump(&shell->thickness.whole);
        return status == KN_OK ? bricks_of_terms(ctx, b, &v->net, shell, w) : status;
    }
    kn_spline volume = {0};
    kn_status status = kn_shell_volume(ctx, &volume, shell, w[0], w[1]);
    if (status == KN_OK) {
        const int room[3] = {kn_spline_spans(&volume, 0) + 1, kn_spline_spans(&volume, 1) + 1,
                             kn_spline_spans(&volume, 2) + 1};
        status = room_for_breaks(ctx, b, room);
        v->jumps = kn_may_jump(&volume);
    }
    if (status == KN_OK) status = bricks_of_volume(ctx, b, &v->net, &volume);
    kn_spline_clear(ctx, &volume);
    return status;
}

// Lengths become at most 1, and weights: powers of two.
static kn_status normalize(kn_ctx *ctx, kn_shell_inverse *v, bricks *b)
{
    size_t n = v->net.count, m = (size_t)v->net.ncomp;
    double size = 0.0, weight = 0.0, heavy = 1.0, last = 0.0;
    int e = 0;
    v->rational = m > 3;
    for (size_t i = 0; i < b->count; i++) {
        const double *c = b->coef + i * b->size;
        size = fmax(size, kn_largest(c, 3 * n));
        for (size_t k = 3 * n; k < m * n; k++) {
            weight = fmax(weight, c[k]);
            if (!(c[k] > 0.0)) return kn_fail(ctx, KN_EUNDEFINED, "inverse: weight %g", c[k]);
        }
    }
    if (v->rational) {
        (void)frexp(weight, &e);
        heavy = ldexp(1.0, -e);
    }
    (void)frexp(size * heavy, &e);
    if (!isfinite(size) || e > 900 || e < -900) return kn_fail(ctx, KN_EDOMAIN, "inverse: coordinates of %g", size);
    v->scale = ldexp(1.0, -e);
    for (size_t i = 0; i < b->count * b->size; i++) {
        last = i % b->size < 3 * n ? heavy * v->scale : heavy;
        b->coef[i] *= last;
    }
    for (size_t i = 0; i < b->count * m; i++) b->error[i] *= i % m < 3 ? heavy * v->scale : heavy;
    return KN_OK;
}

// ---- ends that meet ----

// The largest difference of f at both ends of variable var, of its size.
static double gap(const kn_spline *f, int var)
{
    size_t count = kn_spline_count(f), inner = 1;
    double most = 0.0, size = 0.0;
    if (!f->coef) return 0.0;
    for (int d = var + 1; d < f->nvars; d++) inner *= (size_t)f->count[d];
    size_t row = inner * (size_t)f->count[var];
    for (size_t i = 0; i < count * (size_t)f->ncomp; i++) {
        size = fmax(size, fabs(f->coef[i]));
        if (i % row < inner) most = fmax(most, fabs(f->coef[i + row - inner] - f->coef[i]));
    }
    return size > 0.0 ? most / size : 0.0;
}

// closed[], and how far apart the ends are at most, of T's size: a product of three is off by three times that.
static void find_closed(double apart[2], kn_shell_inverse *v, const kn_shell *shell)
{
    for (int d = 0; d < 2; d++) {
        double most = fmax(gap(&shell->surface, d), gap(&shell->normal, d));
        most = fmax(most, fmax(gap(&shell->thickness.whole, d), gap(&shell->volume, d)));
        for (int k = 0; k < shell->nfields; k++) most = fmax(most, gap(&shell->field[k].whole, d));
        v->closed[d] = shell->closed[d] && most <= CLOSED;
        apart[d] = v->closed[d] ? 4.0 * most : 0.0;
    }
}

// T does not depend on the other variable at this end of the brick: control points, not coefficients, are compared.
static bool collapsed(const kn_net *net, const double *coef, int var, int end)
{
    size_t n = net->count, step[2] = {kn_net_inner(net, 0), kn_net_inner(net, 1)};
    size_t first = end ? (size_t)net->degree[var] * step[var] : 0;
    for (size_t w = first; w <= first + (size_t)net->degree[2]; w++) {
        const kn_row row = {w, step[1 - var], (size_t)net->degree[1 - var] + 1};
        if (!kn_one_point(coef, n, net->ncomp > 3, &row, COLLAPSED)) return false;
    }
    return true;
}

static kn_status cut_bricks(kn_ctx *ctx, kn_shell_inverse *v, const bricks *b, const double apart[2])
{
    kn_status status = KN_OK;
    for (size_t i = 0; i < b->count && status == KN_OK; i++) {
        kn_brick brick = {.coef = b->coef + i * b->size};
        size_t at = i;
        double more = 0.0;
        for (int d = 2; d >= 0; at /= (size_t)b->n[d], d--) {
            int k = (int)(at % (size_t)b->n[d]);
            bool end[2] = {k == 0, k == b->n[d] - 1};
            brick.lo[d] = b->breaks[d][k];
            brick.hi[d] = b->breaks[d][k + 1];
            if (d == 2) continue;
            for (int e = 0; e < 2; e++) brick.pole[d][e] = end[e] && collapsed(&v->net, brick.coef, d, e);
            if (end[0] || end[1]) more += apart[d];
        }
        for (int c = 0; c < v->net.ncomp; c++)
            brick.error[c] = (b->error[i * (size_t)v->net.ncomp + (size_t)c] + more) * (1.0 + 0x1p-40);
        status = kn_progress(ctx, "inverse", (double)i / (double)b->count);
        if (status == KN_OK) status = kn_leaves_add(ctx, v, &brick);
    }
    return status;
}

// ---- the hierarchy ----

typedef struct key {
    double at;
    size_t leaf;
} key;

static int by_place(const void *a, const void *b)
{
    const key *x = a, *y = b;
    if (x->at != y->at) return x->at < y->at ? -1 : 1;
    return (x->leaf > y->leaf) - (x->leaf < y->leaf);
}

// Sorts keys[0 .. n-1] by their middles along the longest side of the box of all, until KN_LEAF_NODE are left.
static void build(kn_shell_inverse *v, key *keys, size_t first, size_t n)
{
    kn_leaf_node *node = &v->node[v->nnodes++];
    *node = (kn_leaf_node){.first = first, .count = n};
    int axis = 0;
    for (int d = 0; d < 3; d++) {
        node->lo[d] = INFINITY, node->hi[d] = -INFINITY;
        for (size_t i = 0; i < n; i++) {
            node->lo[d] = fmin(node->lo[d], v->leaf[keys[i].leaf].space_lo[d]);
            node->hi[d] = fmax(node->hi[d], v->leaf[keys[i].leaf].space_hi[d]);
        }
        if (node->hi[d] - node->lo[d] > node->hi[axis] - node->lo[axis]) axis = d;
    }
    if (n <= KN_LEAF_NODE) {
        for (size_t i = 0; i < n; i++) v->order[first + i] = keys[i].leaf;
        return;
    }
    for (size_t i = 0; i < n; i++) {
        const kn_leaf *leaf = &v->leaf[keys[i].leaf];
        keys[i].at = 0.5 * leaf->space_lo[axis] + 0.5 * leaf->space_hi[axis];
    }
    qsort(keys, n, sizeof *keys, by_place);
    node->count = 0;
    build(v, keys, first, n / 2);
    node->other = v->nnodes;
    build(v, keys + n / 2, first + n / 2, n - n / 2);
}

static kn_status make_hierarchy(kn_ctx *ctx, kn_shell_inverse *v)
{
    kn_mark mark = kn_scratch_mark(ctx);
    key *keys = kn_scratch(ctx, v->nleaves, sizeof *keys);
    v->order = kn_alloc(ctx, v->nleaves, sizeof *v->order);
    v->node = kn_alloc(ctx, 2 * v->nleaves, sizeof *v->node);
    kn_status status = keys && v->order && v->node ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < v->nleaves && status == KN_OK; i++) keys[i].leaf = i;
    if (status == KN_OK) build(v, keys, 0, v->nleaves);
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- all of it ----

static kn_status make(kn_ctx *ctx, kn_shell_inverse *v, const kn_shell *shell, const double w[2])
{
    bricks b = {.coef = NULL};
    double apart[2];
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = make_bricks(ctx, &b, v, shell, w);
    if (status == KN_OK) status = normalize(ctx, v, &b);
    if (status == KN_OK) {
        for (int d = 0; d < 3; d++) v->lo[d] = b.breaks[d][0], v->hi[d] = b.breaks[d][b.n[d]];
        while (v->depth < MAX_DEPTH && b.count << (v->depth + 1) <= MANY) v->depth++;
        find_closed(apart, v, shell);
        status = cut_bricks(ctx, v, &b, apart);
    }
    if (status == KN_OK) status = make_hierarchy(ctx, v);
    kn_free(ctx, b.coef);
    kn_free(ctx, b.error);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_shell_inverse_create(kn_ctx *ctx, kn_shell_inverse **out, const kn_shell *shell, double w0, double w1)
{
    double heights[2];
    const double w[2] = {w0, w1};
    kn_shell_heights(shell, heights);
    if (!(w0 < w1) || !isfinite(w1 - w0) || w0 < heights[0] || w1 > heights[1])
        return kn_fail(ctx, KN_EDOMAIN, "inverse: heights [%g, %g]", w0, w1);
    kn_shell_inverse *v = kn_alloc_zero(ctx, 1, sizeof *v);
    if (!v) return KN_ENOMEM;
    kn_status status = make(ctx, v, shell, w);
    if (status == KN_OK)
        *out = v;
    else
        kn_shell_inverse_destroy(ctx, v);
    return status;
}
