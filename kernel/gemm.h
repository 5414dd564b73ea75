// SPDX-License-Identifier: Apache-2.0
// C = A B for small dense matrices, many rows of A against one B that is packed once.
//
// Every element of C receives its terms in ascending order of the summation index, one rounding each, from zero,
// whatever the shape of the blocks: element (i, j) depends on row i of A and on column j of B alone, bit for bit.
// Hence results do not depend on how rows are gathered into calls, nor on threads. The AVX2 and AVX-512 kernels round
// c + a b once (fused multiply-add), the plain one and SSE2 twice: between machines results may differ by
// gamma(2 k) sum |a||b|. Source of the blocking: Goto & van de Geijn, Anatomy of high-performance matrix
// multiplication, ACM TOMS 34(3), 2008.
#ifndef KERNEL_GEMM_H
#define KERNEL_GEMM_H

#include <stddef.h>

// Numbers that packing a k x n matrix takes.
size_t kn_gemm_room(size_t k, size_t n);
// Packs B, whose element (i, j) is b[i * row + j * column].
void kn_gemm_pack(double *packed, const double *b, size_t k, size_t n, size_t row, size_t column);
// The same of rows first .. first + count - 1 alone: b is where they begin.
void kn_gemm_pack_some(double *packed, const double *b, size_t k, size_t first, size_t count, size_t n, size_t row,
                       size_t column);

// c[i][j] = sum over p = 0 .. k-1 of a[i][p] B(p, j), for i < rows, j < n: rows are given by their addresses.
// work: room for rows * k numbers.
void kn_gemm(double *const *c, const double *const *a, size_t rows, const double *packed, size_t k, size_t n,
             double *work);
// The same on a chosen kind of machine, for tests and measurements; kn_gemm takes the best there is.
typedef enum kn_gemm_kind { KN_GEMM_PLAIN, KN_GEMM_SSE2, KN_GEMM_AVX2, KN_GEMM_AVX512, KN_GEMM_KINDS } kn_gemm_kind;
kn_gemm_kind kn_gemm_best(void);
void kn_gemm_as(kn_gemm_kind kind, double *const *c, const double *const *a, size_t rows, const double *packed,
                size_t k, size_t n, double *work);

#endif
