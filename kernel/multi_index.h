// SPDX-License-Identifier: Apache-2.0
// Multi-indices of partial derivatives, in the order of kn_derivative_index, and the derivatives of a quotient.
#ifndef KERNEL_MULTI_INDEX_H
#define KERNEL_MULTI_INDEX_H

// Replaces a by its successor: by total order, then the first variable highest first. Starts from all zeros.
void kn_multi_index_next(int nvars, int *a);
// The place of a in that order; a's total order must be one that the caller has counted without overflow.
int kn_multi_index_place(int nvars, const int *a);
// f = N / w and all its partial derivatives of total order <= order from those of N and w: in has dim + 1 numbers for
// each multi-index, w last; out has dim. in's first w is not zero. order <= KN_MAX_DEGREE.
void kn_quotient_derivatives(double *out, const double *in, int nvars, int dim, int order);

#endif
