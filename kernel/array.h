// SPDX-License-Identifier: Apache-2.0
// Dense coefficient arrays, of pieces and splines alike, turned, mirrored and mapped: no allocation, no status. An
// array is seen as (outer, n, inner), or as ncomp arrays of count[0] x .. x count[nvars-1], the last index fastest.
#ifndef KERNEL_ARRAY_H
#define KERNEL_ARRAY_H

#include <stdbool.h>
#include <stddef.h>

// out(o, i, j) = in(o, n - 1 - i, j). out is not in.
void kn_array_reverse(double *out, const double *in, size_t outer, size_t n, size_t inner);
// Whether order holds each of 0 .. nvars - 1 once.
bool kn_array_is_order(int nvars, const int *order);
// Index d of out is index order[d] of in, a permutation; count: of in. out is not in.
void kn_array_permute(double *out, const double *in, size_t ncomp, int nvars, const int *count, const int *order);
// out_r = sum_c matrix[r * columns + c] in_c + offset[r] weight, for `rows` arrays of n numbers from `columns` ones.
// An entry that is zero takes no part, so that 1 alone in a row copies bit for bit. offset NULL: none; weight
// NULL: 1.
void kn_array_affine(double *out, const double *in, size_t n, int rows, int columns, const double *matrix,
                     const double *offset, const double *weight);
// sum of weight[0][i_0] .. in(i_0, ..), index by index, the last first; weight[d] NULL: ones.
double kn_array_weighted_sum(const double *in, int nvars, const int *count, const double *const *weight);

#endif
