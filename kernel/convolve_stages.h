// SPDX-License-Identifier: Apache-2.0
// Convolution in one kind of vectors, to be included once by a file that defines LANES, INLINE (with the target
// attribute of its machine), vec, tail and the operations on them.
//
// A row i of the thin operand and a row k of the wide one make row i + k of c:
//     c[i + k][j0 + t + q] += thin[i][j0 + t] wide[k][q].
// A block holds R rows of thin and the sums of R rows of c, W vectors each. The rows of wide pass by; after row k of
// wide, row k of the block's part of c has all that this block gives to it: it is added to c, and the sums move up by
// one row. So every product is computed once, and no sum leaves the registers before it is complete. The last vector
// may reach into c's next row, to which it adds zeros.
#ifndef KERNEL_CONVOLVE_STAGES_H
#define KERNEL_CONVOLVE_STAGES_H

#include <string.h>

#include "kernel/convolve_plane.h"

typedef struct block {
    double *c;
    const double *thin, *wide; // wide: where a vector without shift starts
    size_t step_c, step_thin, step_wide;
    int columns, sweeps; // of thin; rows of wide
    double sign;
} block;

typedef vec tile[KN_PLANE_ROWS][KN_PLANE_VECTORS];

INLINE void clear(tile s, int rows, int vectors)
{
#pragma GCC unroll 8
    for (int i = 0; i < rows; i++)
#pragma GCC unroll 8
        for (int w = 0; w < vectors; w++) s[i][w] = zero();
}

// s[i] += thin[i][t] times a row of wide shifted by t.
INLINE void column(tile s, const double *thin, size_t step, const double *wide, int rows, int vectors)
{
    vec v[KN_PLANE_VECTORS];
#pragma GCC unroll 8
    for (int w = 0; w < vectors; w++) v[w] = load(wide + LANES * w);
#pragma GCC unroll 8
    for (int i = 0; i < rows; i++) {
        vec x = splat(thin[(size_t)i * step]);
#pragma GCC unroll 8
        for (int w = 0; w < vectors; w++) s[i][w] = multiply_add(x, v[w], s[i][w]);
    }
}

INLINE void add_row(double *c, const vec *row, int vectors, double sign)
{
    vec x = splat(sign);
#pragma GCC unroll 8
    for (int w = 0; w < vectors; w++) store(c + LANES * w, multiply_add(x, row[w], load(c + LANES * w)));
}

// Few sums wait for each other: then even and odd columns have their own.
INLINE void sweep(const block *b, int rows, int vectors)
{
    const bool twice = rows * vectors <= 5;
    const int odds = twice ? vectors : 0; // gcc without optimisation unrolls for plain conditions only
    tile s, odd;
    double *c = b->c;
    const double *wide = b->wide;
    clear(s, rows, vectors);
    if (twice) clear(odd, rows, vectors);
    for (int k = 0; k < b->sweeps; k++, c += b->step_c, wide += b->step_wide) {
        int t = 0;
        for (; twice && t + 1 < b->columns; t += 2) {
            column(s, b->thin + t, b->step_thin, wide - t, rows, vectors);
            column(odd, b->thin + t + 1, b->step_thin, wide - t - 1, rows, vectors);
        }
        for (; t < b->columns; t++) column(s, b->thin + t, b->step_thin, wide - t, rows, vectors);
#pragma GCC unroll 8
        for (int w = 0; w < odds; w++) s[0][w] = add(s[0][w], odd[0][w]);
        add_row(c, s[0], vectors, b->sign);
#pragma GCC unroll 8
        for (int i = 0; i < rows; i++)
#pragma GCC unroll 8
            for (int w = 0; w < vectors; w++) {
                s[i][w] = i + 1 < rows ? s[i + 1][w] : zero();
                if (twice) odd[i][w] = i + 1 < rows ? odd[i + 1][w] : zero();
            }
    }
#pragma GCC unroll 8
    for (int i = 0; i < rows - 1; i++, c += b->step_c) {
#pragma GCC unroll 8
        for (int w = 0; w < odds; w++) s[i][w] = add(s[i][w], odd[i][w]);
        add_row(c, s[i], vectors, b->sign);
    }
}

// Constant numbers of rows and vectors, so that the sums live in registers.
INLINE void sweep_rows(const block *b, int rows, int vectors)
{
    const int most = kn_plane_rows(LANES, vectors);
    if (rows == 1) sweep(b, 1, vectors);
    if (rows == 2 && most >= 2) sweep(b, 2, vectors);
    if (rows == 3 && most >= 3) sweep(b, 3, vectors);
    if (rows == 4 && most >= 4) sweep(b, 4, vectors);
    if (rows == 5 && most >= 5) sweep(b, 5, vectors);
    if (rows == 6 && most >= 6) sweep(b, 6, vectors);
    if (rows == 7 && most >= 7) sweep(b, 7, vectors);
    if (rows == 8 && most >= 8) sweep(b, 8, vectors);
}

OUTLINE void sweep_1(const block *b, int rows)
{
    sweep_rows(b, rows, 1);
}
OUTLINE void sweep_2(const block *b, int rows)
{
    sweep_rows(b, rows, 2);
}
OUTLINE void sweep_3(const block *b, int rows)
{
    sweep_rows(b, rows, 3);
}
OUTLINE void sweep_4(const block *b, int rows)
{
    sweep_rows(b, rows, 4);
}
#if LANES == 8
OUTLINE void sweep_5(const block *b, int rows)
{
    sweep_rows(b, rows, 5);
}
OUTLINE void sweep_6(const block *b, int rows)
{
    sweep_rows(b, rows, 6);
}
#endif

OUTLINE void sweep_all(const block *b, int rows, int vectors)
{
    switch (vectors) {
    case 1: sweep_1(b, rows); break;
    case 2: sweep_2(b, rows); break;
    case 3: sweep_3(b, rows); break;
    case 4: sweep_4(b, rows); break;
#if LANES == 8
    case 5: sweep_5(b, rows); break;
    case 6: sweep_6(b, rows); break;
#endif
    default: break;
    }
}

INLINE void sweep_blocks(const kn_convolution *p, const kn_plane *s, block *b, double *c, const double *thin,
                         int vectors)
{
    for (int i = 0; i < s->thin_rows; i += p->rows) {
        int rows = s->thin_rows - i < p->rows ? s->thin_rows - i : p->rows;
        b->c = c + (size_t)i * b->step_c;
        b->thin = thin + (size_t)i * s->thin_step;
        sweep_all(b, rows, vectors);
    }
}

// What all rows give to the same columns is summed apart, so that c takes one addition instead of one for each block.
OUTLINE __attribute__((noinline)) void sweep_aside(const kn_convolution *p, const kn_plane *s, block *b, double *c,
                                                   const double *thin, int vectors)
{
    double aside[KN_ASIDE_ROWS * KN_PLANE_VECTORS * LANES];
    int all = s->thin_rows + s->wide_rows - 1;
    b->step_c = (size_t)(LANES * vectors), b->sign = 1.0;
    memset(aside, 0, (size_t)all * b->step_c * sizeof *aside);
    sweep_blocks(p, s, b, aside, thin, vectors);
    vec sign = splat(s->sign);
    for (const double *from = aside; all > 0; all--, c += s->sum_step, from += b->step_c)
        for (int w = 0; w < LANES * vectors; w += LANES) {
            vec sum = multiply_add(sign, load(from + w), load(c + w));
            store(c + w, sum);
        }
}

// Blocks of columns and rows of thin against parts of the wide rows.
OUTLINE void plane(double *sums, const double *thin, const double *wide, const kn_convolution *p, const kn_plane *s)
{
    block b = {.step_c = s->sum_step, .step_thin = s->thin_step, .step_wide = s->wide_step};
    b.sweeps = s->wide_rows, b.sign = s->sign;
    b.wide = wide + p->before;
    for (int first = 0; first < s->wide_columns; first += p->part, b.wide += p->padded) {
        int part = s->wide_columns - first < p->part ? s->wide_columns - first : p->part;
        for (int j = 0; j < s->thin_columns; j += p->columns) {
            b.columns = s->thin_columns - j < p->columns ? s->thin_columns - j : p->columns;
            int vectors = (b.columns + part - 1 + LANES - 1) / LANES;
            double *c = sums + (size_t)(j + first);
            if (p->aside)
                sweep_aside(p, s, &b, c, thin + (size_t)j, vectors);
            else
                sweep_blocks(p, s, &b, c, thin + (size_t)j, vectors);
        }
    }
}

INLINE void pack_row(double *to, const double *from, const double *column, vec w, size_t n, size_t before,
                     size_t padded)
{
    size_t j = 0;
    for (; j < before; j += LANES, to += LANES) store(to, zero());
    for (j = 0; j + LANES <= n; j += LANES, to += LANES)
        store(to, multiply(multiply(w, load(column + j)), load(from + j)));
    if (j < n) {
        store(to, multiply(multiply(w, load(column + j)), load_tail(from + j, tail_of((int)(n - j)))));
        to += LANES, j += LANES;
    }
    for (; before + j < padded; j += LANES, to += LANES) store(to, zero());
}

OUTLINE void pack_rows(double *packed, const double *from, const kn_weighed *w, int part, size_t before,
                       size_t padded)
{
    for (int k = 0; k < w->rows; k++, from += w->step) {
        vec weight = splat(w->before * w->row[k]);
        double *to = packed + (size_t)k * w->packed_step;
        for (int first = 0; first < w->columns; first += part, to += padded) {
            int n = w->columns - first < part ? w->columns - first : part;
            pack_row(to, from + first, w->column + first, weight, (size_t)n, before, padded);
        }
    }
}

OUTLINE void divide_rows(double *out, const double *sums, const kn_weighed *w)
{
    int n = w->columns;
    for (int i = 0; i < w->rows; i++, out += w->step, sums += w->packed_step) {
        vec d = splat(w->before * w->row[i]), r = splat(w->before_inverse * w->row_inverse[i]);
        for (int j = 0; j < n; j += LANES) {
            vec q = quotient(load(sums + j), multiply(d, load(w->column + j)),
                             multiply(r, load(w->column_inverse + j)));
            if (n - j >= LANES)
                store(out + j, q);
            else
                store_tail(out + j, tail_of(n - j), q);
        }
    }
}

#endif
