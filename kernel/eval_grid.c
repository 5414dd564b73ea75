// SPDX-License-Identifier: Apache-2.0
// Evaluation on a grid. The last variable is done first, for a block of its parameters at a time; then each variable
// before it combines rows, contiguous in the parameters that are already done:
//     R_d[..][x] = sum_k N_k(t_d) R_(d+1)[.., first + k][x],
// one parameter of the middle variables at a time, so that what one pass reads stays in the caches.
#include "kernel/context.h"
#include "kernel/eval_block.h"

#include <string.h>

enum { ROW = 640 }; // numbers in a row, about: some rows fit into the nearest cache

typedef struct grid {
    const kn_eval_function *f;
    const kn_eval_kernels *run;
    double *out, *basis[KN_MAX_VARS];
    size_t *first[KN_MAX_VARS]; // coefficients, not numbers
    kn_eval_axis axis[KN_MAX_VARS];
    double *turned;             // coefficients, the last variable slowest: [count][others][ncomp]
    double *wide;               // the last variable done: [block][others][ncomp]
    double *level[KN_MAX_VARS]; // level[d]: rows for the coefficients of the variables below d
    size_t n[KN_MAX_VARS], block, row, others;
    size_t lines[KN_MAX_VARS]; // products of the counts below d
} grid;

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

static double *take(double *memory, size_t *used, size_t n)
{
    double *at = memory ? memory + *used : NULL;
    *used += kn_eval_aligned(n);
    return at;
}

// Lays out everything; answers the numbers used. memory NULL: only that.
static size_t lay(grid *g, const kn_eval_function *f, const size_t *n, double *memory)
{
    size_t used = 0, ncomp = (size_t)f->ncomp;
    int last = f->nvars - 1;
    *g = (grid){.f = f};
    g->others = 1;
    for (int d = 0; d < f->nvars; d++) {
        g->n[d] = n[d], g->lines[d] = g->others;
        if (d < last) g->others *= (size_t)f->count[d];
        used += kn_eval_lay_axis(&g->axis[d], f, d, false, 1, memory ? memory + used : NULL);
        g->basis[d] = take(memory, &used, n[d] * (size_t)g->axis[d].width);
        g->first[d] = (size_t *)(void *)take(memory, &used, n[d]); // a size_t is no larger than a number
    }
    g->block = smaller(n[last], ROW / ncomp);
    g->row = kn_eval_aligned(g->block * ncomp + KN_EVAL_VECTOR); // room for a vector beside the last value
    g->turned = take(memory, &used, (size_t)f->count[last] * g->others * ncomp);
    g->wide = take(memory, &used, g->block * g->others * ncomp + KN_EVAL_VECTOR);
    for (int d = last; d >= 0; d--) g->level[d] = take(memory, &used, g->lines[d] * g->row);
    return used;
}

size_t kn_eval_grid_room(const kn_eval_function *f, const size_t *n)
{
    grid g;
    return lay(&g, f, n, NULL);
}

static void turn(const grid *g)
{
    const kn_eval_function *f = g->f;
    size_t count = (size_t)f->count[f->nvars - 1], ncomp = (size_t)f->ncomp;
    for (size_t c = 0; c < ncomp; c++)
        for (size_t i = 0; i < g->others; i++)
            for (size_t k = 0; k < count; k++)
                g->turned[(k * g->others + i) * ncomp + c] = f->coef[(c * g->others + i) * count + k];
}

// [j][others][ncomp] -> [others][row of (j, ncomp)], four numbers at a time: the next one overwrites what is too much.
static void untwist(const grid *g, double *to, size_t n)
{
    size_t ncomp = (size_t)g->f->ncomp, all = g->others * ncomp;
    for (size_t i = 0; i < g->others; i++, to += g->row)
        for (size_t j = 0; j < n; j++) {
            const double *from = g->wide + j * all + i * ncomp;
            if (ncomp <= KN_EVAL_VECTOR)
                memcpy(to + j * ncomp, from, KN_EVAL_VECTOR * sizeof *to);
            else
                memcpy(to + j * ncomp, from, ncomp * sizeof *to);
        }
}

// A row of homogeneous values to points.
static void divide(double *out, const double *row, size_t n, size_t ncomp)
{
    for (size_t j = 0; j < n; j++, row += ncomp, out += ncomp - 1) {
        double w = row[ncomp - 1];
        for (size_t c = 0; c + 1 < ncomp; c++) out[c] = row[c] / w;
    }
}

// The first variable: rows of the result, n of its points each, `step` points from one to the next.
static void finish(const grid *g, double *out, size_t n, size_t step)
{
    size_t ncomp = (size_t)g->f->ncomp, dim = ncomp - g->f->rational;
    size_t first[1];
    kn_eval_rows r = {.in = g->level[1],
                      .basis = g->basis[0],
                      .out = out,
                      .out_row = step * dim,
                      .in_row = g->row,
                      .n = g->n[0],
                      .length = n * ncomp,
                      .degree = g->axis[0].degree,
                      .width = g->axis[0].width};
    r.first = g->first[0], r.scale = g->row;
    if (!g->f->rational) {
        g->run->rows(&r);
        return;
    }
    r.n = 1, r.out = g->level[0], r.first = first;
    for (size_t i = 0; i < g->n[0]; i++, out += step * dim, r.basis += r.width) {
        first[0] = g->first[0][i];
        g->run->rows(&r);
        divide(out, g->level[0], n, ncomp);
    }
}

// Variables d, d-1, .. 0 are left; level[d + 1] is full. step: points of the grid in one step of variable d.
static void descend(const grid *g, int d, double *out, size_t n, size_t step)
{
    size_t dim = (size_t)(g->f->ncomp - g->f->rational);
    if (d == 0) {
        finish(g, out, n, step);
        return;
    }
    for (size_t i = 0; i < g->n[d]; i++, out += step * dim) {
        for (size_t line = 0; line < g->lines[d]; line++) {
            kn_eval_rows r = {.in = g->level[d + 1] + line * (size_t)g->f->count[d] * g->row,
                              .out = g->level[d] + line * g->row,
                              .basis = g->basis[d] + i * (size_t)g->axis[d].width,
                              .first = g->first[d] + i,
                              .scale = g->row,
                              .in_row = g->row,
                              .n = 1,
                              .length = n * (size_t)g->f->ncomp,
                              .degree = g->axis[d].degree,
                              .width = g->axis[d].width};
            g->run->rows(&r);
        }
        descend(g, d - 1, out, n, step * g->n[d]);
    }
}

void kn_eval_grid_planned(double *out, const kn_eval_function *f, const size_t *n, const double *const *at,
                          double *memory, kn_eval_level level)
{
    grid g;
    lay(&g, f, n, memory);
    g.run = kn_eval_of_level(level), g.out = out;
    int last = f->nvars - 1;
    for (int d = 0; d <= last; d++) {
        kn_eval_fill_axis(&g.axis[d], f, d);
        g.run->basis(g.basis[d], g.first[d], &g.axis[d], n[d], at[d]);
    }
    turn(&g);
    size_t all = g.others * (size_t)f->ncomp, dim = (size_t)(f->ncomp - f->rational);
    for (size_t x = 0; x < KN_EVAL_VECTOR; x++) g.wide[g.block * all + x] = 0.0; // read, and overwritten later
    for (size_t done = 0; done < n[last]; done += g.block) {
        size_t m = smaller(g.block, n[last] - done);
        kn_eval_rows r = {.in = g.turned,
                          .out = g.wide,
                          .basis = g.basis[last] + done * (size_t)g.axis[last].width,
                          .first = g.first[last] + done,
                          .scale = all,
                          .in_row = all,
                          .out_row = all,
                          .n = m,
                          .length = all,
                          .degree = g.axis[last].degree,
                          .width = g.axis[last].width};
        g.run->rows(&r);
        untwist(&g, g.level[last], m);
        descend(&g, last - 1, out + done * dim, m, n[last]);
    }
}

kn_status kn_eval_grid(kn_ctx *ctx, double *out, const kn_eval_function *f, const size_t *n, const double *const *at)
{
    for (int d = 0; d < f->nvars; d++)
        if (n[d] == 0) return KN_OK;
    if (f->nvars == 1) return kn_eval_batch(ctx, out, f, n[0], at[0], false);
    kn_mark mark = kn_scratch_mark(ctx);
    double *memory = kn_scratch(ctx, kn_eval_grid_room(f, n), sizeof *memory);
    if (memory) kn_eval_grid_planned(out, f, n, at, memory, kn_eval_best());
    kn_scratch_release(ctx, mark);
    return memory ? KN_OK : KN_ENOMEM;
}
