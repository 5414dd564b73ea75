// SPDX-License-Identifier: Apache-2.0
// What the operations on kn_spline share: storage, and maps along one variable.
#ifndef SPLINE_INTERNAL_H
#define SPLINE_INTERNAL_H

#include <knurl/spline.h>

#include "kernel/knots.h"

// KN_OK when these numbers are a legal shape, else KN_EDOMAIN or KN_ELIMIT, recorded under the name of the call.
kn_status kn_spline_shape(kn_ctx *ctx, const char *call, int nvars, int ncomp, bool rational, const int *degree,
                          const int *count);
// *out = a spline of this (legal) shape with its arrays allocated and not filled.
kn_status kn_spline_alloc(kn_ctx *ctx, kn_spline *out, int nvars, int ncomp, bool rational, const int *degree,
                          const int *count);
// KN_OK when s is not empty and 0 <= var < nvars.
kn_status kn_spline_expect(kn_ctx *ctx, const char *call, const kn_spline *s, int var);
// The array of one component seen along var is (outer, count[var], inner).
size_t kn_spline_inner(const kn_spline *s, int var);
size_t kn_spline_outer(const kn_spline *s, int var); // components included

// ---- where results live: how an operation allocates nothing in the steady state ----
// Temporary splines have their arrays in scratch, or borrow an operand's, which nothing writes to; the result is
// copied last, and out's arrays are used again where their lengths fit. Nothing is cleared; out is untouched by
// a failure:
//     kn_mark mark = kn_scratch_mark(ctx);
//     kn_spline s = *a;                                                  // borrowed
//     kn_status status = kn_spline_refine_in_scratch(ctx, &s, var, ..);  // any of the three below; s's arrays change
//     if (status == KN_OK) status = kn_spline_store(ctx, out, &s);       // last: out may be an operand
//     kn_scratch_release(ctx, mark);

// out = s, wherever its arrays live, out's own among them; an empty s makes out empty.
kn_status kn_spline_store(kn_ctx *ctx, kn_spline *out, const kn_spline *s);
// s->knots and s->coef = scratch, not filled, for the shape that s has, after kn_spline_shape.
kn_status kn_spline_in_scratch(kn_ctx *ctx, const char *call, kn_spline *s);
// s = band applied along var; knots (band->rows + degree + 1) replace those of var. band and knots may lie in scratch.
kn_status kn_spline_map_in_scratch(kn_ctx *ctx, kn_spline *s, int var, int degree, const double *knots,
                                   const kn_band *band);
// s = the same function on the knots `to` of var, rows + degree + 1 of them (kn_band_refine).
kn_status kn_spline_refine_in_scratch(kn_ctx *ctx, kn_spline *s, int var, const double *to, int rows);

// Room for a band in scratch.
kn_status kn_spline_band(kn_ctx *ctx, kn_band *band, int rows, int width);
// The same with terms[], for kn_band_refine and kn_band_elevate, which then work on no more than they need.
kn_status kn_spline_refining_band(kn_ctx *ctx, kn_band *band, int rows, int width);
// Between s and a piece of its degrees: the box of coefficients that starts at index first[d] in each variable.
void kn_spline_get_piece(kn_bezier *piece, const kn_spline *s, const int *first);
void kn_spline_put_piece(kn_spline *s, const kn_bezier *piece, const int *first);

// A grid of Bezier pieces: per variable the breaks and how many knots the spline keeps at each.
typedef struct kn_grid {
    int nbreaks[KN_MAX_VARS];
    double *breaks[KN_MAX_VARS];
    int *times[KN_MAX_VARS];
} kn_grid;
// The distinct knots of s in var, and how often it has each, in scratch.
kn_status kn_spline_breaks(kn_ctx *ctx, kn_grid *grid, const kn_spline *s, int var);
// index of the next box of the grid, the last variable fastest; false after the last one.
static inline bool kn_grid_next(int *index, const kn_grid *grid, int nvars)
{
    int d = nvars - 1;
    while (d >= 0 && ++index[d] == grid->nbreaks[d] - 1) index[d--] = 0;
    return d >= 0;
}
// s->knots and s->coef = scratch, not filled, for pieces side by side, one for each box of the grid, of the degrees,
// components and variables that s has.
kn_status kn_spline_pieces_in_scratch(kn_ctx *ctx, const char *call, kn_spline *s, const kn_grid *grid);
// s split into such pieces in var, or in all variables: every break at multiplicity degree + 1. The breaks contain the
// knots of s inside their range.
kn_status kn_spline_split_in_scratch(kn_ctx *ctx, kn_spline *s, int var, const kn_grid *grid);
kn_status kn_spline_split_on_grid(kn_ctx *ctx, kn_spline *s, const kn_grid *grid);
// The way back from such pieces: knots as times[] says. The knots that s had are not read.
kn_status kn_spline_join_in_scratch(kn_ctx *ctx, kn_spline *s, int var, const kn_grid *grid);
kn_status kn_spline_join_on_grid(kn_ctx *ctx, kn_spline *s, const kn_grid *grid);
// grid->times: from the continuity at the interior breaks of var to the multiplicity at this degree, none for a
// continuity of the degree or more; degree + 1 at the ends.
void kn_grid_multiplicities(kn_grid *grid, int var, int degree);

// out = op(a) piece by piece. op answers pieces of this shape, in the parameters of [0,1] and in the array that its
// out has; it gets the size of the box. The knots are those of a's continuity, less one in variable `rough` (-1:
// none, KN_EVERY_VAR: in each).
enum { KN_EVERY_VAR = -2 };
typedef kn_status (*kn_piece_op)(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const double *size,
                                 const void *user);
kn_status kn_spline_by_pieces(kn_ctx *ctx, const char *call, kn_spline *out, const kn_spline *a,
                              const kn_bezier *shape, kn_piece_op op, const void *user, int rough);
// KN_OK when both are splines over the same variables and the same domain.
kn_status kn_spline_expect_pair(kn_ctx *ctx, const char *call, const kn_spline *a, const kn_spline *b);

#endif
