// SPDX-License-Identifier: Apache-2.0
// How far T may go before its Jacobian vanishes.
//
// Over a box, J(w) at every (u,v) is a mean of the polynomials sum_k c_k w^k, c_k coefficient i of J_k: it stays
// positive as long as all of them do, and the least of their first roots is a lower bound of its own, which halving
// the box improves. At corners of boxes coefficients are values: their roots are upper bounds.
#include "fold/internal.h"
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "kernel/parallel.h"
#include "solve/net.h"

#include <math.h>
#include <string.h>

enum { DEPTH = 40, LEAST_WORK = 64, WORK = 1 << 24 }; // halvings of a box; coefficients to look at in all
static const double enough = 0.99;                    // a lower bound by an upper one
static const double share = 0x1p-20;                  // J counts as 0 below so much of its terms

// lower: J does not vanish below it. upper: where that can be shown no more, for what J or its rounding is. most:
// where J itself counts as 0, whatever its rounding.
typedef struct side {
    double lower, upper, most, where[2];
} side;

// J in powers of the height over one box, and its halves: level k >= 1 has them at 2k - 1 and 2k, level 0 the whole.
typedef struct search {
    int top, degree[2];
    size_t count;
    double error[KN_MAX_COMPS], gain[KN_MAX_COMPS]; // gain: less it, a coefficient is the most that it may be
    double base, reach;                             // heights base + w, 0 <= w <= reach
    bool flat[2][2];
    double lo[2], width[2];
    double *stack;
} search;

// ---- one box ----

// Whether the coefficient (i,j) of a box is on an edge along which J_0 is 0.
static bool on_flat(const search *s, const double lo[2], const double hi[2], size_t i, size_t j)
{
    size_t at[2] = {i, j};
    for (int v = 0; v < 2; v++) {
        if (s->flat[v][0] && at[v] == 0 && lo[v] == 0.0) return true;
        if (s->flat[v][1] && at[v] == (size_t)s->degree[v] && hi[v] == 1.0) return true;
    }
    return false;
}

static double height(const search *s, double root)
{
    return root >= s->reach ? INFINITY : s->base + root;
}

// No J of the box vanishes below this; no more than is needed is found out when that is not above `wanted`.
static double lower_bound(const search *s, const double *c, const double lo[2], const double hi[2], double wanted)
{
    double least = INFINITY;
    size_t columns = (size_t)s->degree[1] + 1;
    bool flat = s->flat[0][0] || s->flat[0][1] || s->flat[1][0] || s->flat[1][1];
    for (size_t k = 0; k < s->count; k++) {
        bool zero = flat && on_flat(s, lo, hi, k / columns, k % columns);
        double h = height(s, kn_fold_first_root(c + k, s->count, s->error, s->top, 0.0, zero));
        least = h < least ? h : least;
        if (least < wanted) break;
    }
    return least;
}

static void look_at_corners(side *found, const search *s, const double *c, const double lo[2], const double hi[2])
{
    for (int k = 0; k < 4; k++) {
        bool end[2] = {k / 2 == 1, k % 2 == 1};
        size_t i = end[0] ? (size_t)s->degree[0] : 0, j = end[1] ? (size_t)s->degree[1] : 0;
        const double *at = c + i * ((size_t)s->degree[1] + 1) + j;
        bool zero = on_flat(s, lo, hi, i, j);
        double h = height(s, kn_fold_first_root(at, s->count, s->error, s->top, share, zero));
        if (!(h < found->most) && !(h < found->upper)) continue;
        found->upper = fmin(found->upper, h);
        h = height(s, kn_fold_first_root(at, s->count, s->gain, s->top, share, zero));
        if (!(h < found->most)) continue;
        found->most = h;
        for (int v = 0; v < 2; v++) found->where[v] = s->lo[v] + (end[v] ? hi[v] : lo[v]) * s->width[v];
    }
}

static void halve(const search *s, int depth, bool second, int var)
{
    size_t all = s->count * ((size_t)s->top + 1), outer = (size_t)s->top + 1, nv = (size_t)s->degree[1] + 1;
    const double *now = s->stack + (depth == 0 ? 0 : (size_t)(2 * depth - (second ? 0 : 1))) * all;
    double *first = s->stack + (size_t)(2 * depth + 1) * all;
    if (var == 0) kn_bernstein_split(first, first + all, now, outer, s->degree[0], nv, 0.5);
    if (var == 1)
        kn_bernstein_split(first, first + all, now, outer * ((size_t)s->degree[0] + 1), s->degree[1], 1, 0.5);
}

// Halves boxes, depth first, until the lower bound of each is near the least upper bound. found->upper is what is
// known already.
static void refine(side *found, const search *s, size_t work)
{
    double lo[DEPTH + 1][2] = {{0}}, width[DEPTH + 1][2] = {{1.0, 1.0}};
    bool second[DEPTH + 1] = {false};
    size_t all = s->count * ((size_t)s->top + 1);
    int depth = 0;
    found->lower = INFINITY;
    for (;;) {
        const double *now = s->stack + (depth == 0 ? 0 : (size_t)(2 * depth - (second[depth] ? 0 : 1))) * all;
        double hi[2];
        for (int v = 0; v < 2; v++) hi[v] = lo[depth][v] + width[depth][v];
        look_at_corners(found, s, now, lo[depth], hi);
        bool last = depth == DEPTH || work == 0;
        double wanted = fmin(found->lower, enough * found->upper);
        double bound = lower_bound(s, now, lo[depth], hi, last ? 0.0 : wanted);
        if (work > 0) work--;
        if (!last && bound < wanted) {
            int var = depth % 2;
            halve(s, depth, second[depth], var);
            memcpy(lo[depth + 1], lo[depth], sizeof lo[0]);
            memcpy(width[depth + 1], width[depth], sizeof width[0]);
            width[depth + 1][var] *= 0.5;
            second[++depth] = false;
            continue;
        }
        found->lower = fmin(found->lower, bound);
        while (depth > 0 && second[depth]) depth--;
        if (depth == 0) break;
        second[depth] = true;
        lo[depth][(depth - 1) % 2] += width[depth][(depth - 1) % 2];
    }
}

// ---- one box of the shell's grid ----

typedef struct job {
    const kn_shell *shell;
    size_t n, work;      // boxes of the grid; coefficients to look at for each
    side (*side)[2];     // of each box: above, below
    const double *known; // in the second round, for each cell and side: an upper bound
    size_t *cell;
    int columns; // of cells
} job;

static kn_status prepare(kn_ctx *ctx, search *s, kn_shell_jacobian_piece *p, bool below, bool deep)
{
    s->base = p->j.nvars == 3 ? p->lo[2] : 0.0;
    s->reach = p->j.nvars == 3 ? p->hi[2] - p->lo[2] : INFINITY;
    kn_status status = kn_fold_to_heights(ctx, p, below);
    if (status != KN_OK) return status;
    s->top = p->j.ncomp - 1;
    s->count = kn_bezier_count(&p->j);
    size_t all = s->count * ((size_t)s->top + 1);
    for (int v = 0; v < 2; v++) {
        s->degree[v] = p->j.degree[v];
        s->lo[v] = p->lo[v], s->width[v] = p->hi[v] - p->lo[v];
        for (int e = 0; e < 2; e++) s->flat[v][e] = p->flat[v][e] && s->base == 0.0;
    }
    double roundings = (4.0 * (s->degree[0] + s->degree[1]) + 8.0) * DEPTH;
    for (int k = 0; k <= s->top; k++) {
        double most = kn_largest(p->j.coef + (size_t)k * s->count, s->count);
        s->error[k] = 1.001 * (p->error[k] + kn_rounding(roundings) * most);
        s->gain[k] = -s->error[k];
    }
    s->stack = kn_scratch(ctx, deep ? (2 * DEPTH + 1) * all : all, sizeof *s->stack);
    if (!s->stack) return KN_ENOMEM;
    memcpy(s->stack, p->j.coef, all * sizeof *s->stack);
    return KN_OK;
}

static void clear_sides(side out[2])
{
    for (int b = 0; b < 2; b++) out[b] = (side){INFINITY, INFINITY, INFINITY, {0.0, 0.0}};
}

// The bounds that the coefficients of the whole box give.
static kn_status first_look(kn_ctx *ctx, void *user, size_t index)
{
    job *a = user;
    kn_shell_jacobian_piece p = {0};
    const double lo[2] = {0.0, 0.0}, hi[2] = {1.0, 1.0};
    kn_status status = kn_fold_piece(ctx, &p, a->shell, index);
    if (status != KN_OK) return status;
    clear_sides(a->side[index]);
    a->cell[index] = (size_t)p.cell[0] * (size_t)a->columns + (size_t)p.cell[1];
    bool volume = p.j.nvars == 3;
    for (int b = 0; b < (volume ? 1 : 2) && status == KN_OK; b++) {
        kn_mark mark = kn_scratch_mark(ctx);
        search s = {0};
        side *found = &a->side[index][b];
        status = prepare(ctx, &s, &p, b == 1, false);
        if (status == KN_OK) {
            look_at_corners(found, &s, s.stack, lo, hi);
            found->lower = lower_bound(&s, s.stack, lo, hi, 0.0);
        }
        kn_scratch_release(ctx, mark);
    }
    kn_shell_jacobian_piece_clear(ctx, &p);
    return status;
}

// Halves the box where its bound is not good enough for its cell.
static kn_status second_look(kn_ctx *ctx, void *user, size_t index)
{
    job *a = user;
    kn_status status = KN_OK;
    for (int b = 0; b < 2 && status == KN_OK; b++) {
        side *found = &a->side[index][b];
        double known = a->known[2 * a->cell[index] + (size_t)b];
        if (found->lower >= enough * known) continue;
        kn_shell_jacobian_piece p = {0};
        kn_mark mark = kn_scratch_mark(ctx);
        search s = {0};
        status = kn_fold_piece(ctx, &p, a->shell, index);
        if (status == KN_OK) status = prepare(ctx, &s, &p, b == 1, true);
        if (status == KN_OK) {
            side own = *found;
            own.upper = fmin(own.upper, known);
            refine(&own, &s, LEAST_WORK + a->work / (s.count * ((size_t)s.top + 1)));
            own.lower = fmax(found->lower, own.lower);
            *found = own;
        }
        kn_scratch_release(ctx, mark);
        kn_shell_jacobian_piece_clear(ctx, &p);
    }
    return status;
}

// ---- cells ----

static void start(kn_fold_heights *h, const double middle[2])
{
    *h = (kn_fold_heights){INFINITY, INFINITY, INFINITY, INFINITY, {middle[0], middle[1]}, {middle[0], middle[1]}};
}

static void take(double *height, double *most, double where[2], const side *s)
{
    *height = fmin(*height, s->lower);
    if (!(s->most < *most)) return;
    *most = s->most;
    for (int v = 0; v < 2; v++) where[v] = s->where[v];
}

// What was proved may exceed the height at which J counts as 0.
static void settle(kn_fold_heights *h)
{
    h->above_most = fmax(h->above_most, h->above);
    h->below_most = fmax(h->below_most, h->below);
}

static void gather(kn_fold_heights *cells, kn_fold_heights *overall, const job *a, size_t ncells)
{
    double lo[2], hi[2];
    for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(a->shell), v, &lo[v], &hi[v]);
    const double middle[2] = {0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1])};
    start(overall, middle);
    for (size_t c = 0; c < ncells; c++) start(&cells[c], middle);
    for (size_t i = 0; i < a->n; i++) {
        kn_fold_heights *to[2] = {&cells[a->cell[i]], overall};
        for (int k = 0; k < 2; k++) {
            take(&to[k]->above, &to[k]->above_most, to[k]->where_above, &a->side[i][0]);
            take(&to[k]->below, &to[k]->below_most, to[k]->where_below, &a->side[i][1]);
        }
    }
    for (size_t c = 0; c < ncells; c++) settle(&cells[c]);
    settle(overall);
}

static kn_status compute(kn_ctx *ctx, job *a, kn_fold_heights *cells, kn_fold_heights *overall, size_t ncells)
{
    a->side = kn_scratch(ctx, a->n, sizeof *a->side);
    a->cell = kn_scratch(ctx, a->n, sizeof *a->cell);
    double *known = kn_scratch(ctx, 2 * ncells, sizeof *known);
    if (!a->side || !a->cell || !known) return KN_ENOMEM;
    kn_status status = kn_parallel(ctx, a->n, first_look, a, "safe heights");
    if (status != KN_OK) return status;
    for (size_t k = 0; k < 2 * ncells; k++) known[k] = INFINITY;
    for (size_t i = 0; i < a->n; i++)
        for (size_t b = 0; b < 2; b++) {
            double *least = &known[2 * a->cell[i] + b];
            *least = fmin(*least, a->side[i][b].upper);
        }
    a->known = known;
    status = kn_parallel(ctx, a->n, second_look, a, "safe heights");
    if (status == KN_OK) gather(cells, overall, a, ncells);
    return status;
}

kn_status kn_fold_safe_heights(kn_ctx *ctx, kn_fold_heights *cells, kn_fold_heights *overall, const kn_shell *shell)
{
    int count[2];
    kn_shell_cells(shell, count);
    size_t ncells = (size_t)count[0] * (size_t)count[1];
    job a = {.shell = shell, .n = kn_fold_boxes(shell), .columns = count[1]};
    a.work = WORK / a.n;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_fold_heights all, *own = kn_scratch(ctx, ncells, sizeof *own);
    kn_status status = own ? compute(ctx, &a, own, &all, ncells) : KN_ENOMEM;
    if (status == KN_OK && cells) memcpy(cells, own, ncells * sizeof *cells);
    if (status == KN_OK && overall) *overall = all;
    kn_scratch_release(ctx, mark);
    return status;
}
