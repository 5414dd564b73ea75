// SPDX-License-Identifier: Apache-2.0
// What the files of convolution share: the last two variables of a product, in one kind of vectors.
#ifndef KERNEL_CONVOLVE_PLANE_H
#define KERNEL_CONVOLVE_PLANE_H

#include "kernel/convolve.h"

enum { KN_PLANE_VECTORS = 6, KN_PLANE_ROWS = 8, KN_ASIDE_ROWS = KN_MAX_DEGREE + 1 };

// Rows of a block that leave its sums, its vectors and a broadcast in the registers of the machine (16; AVX-512: 32).
// 0: no such block.
static inline int kn_plane_rows(int lanes, int vectors)
{
    switch (vectors) {
    case 1: return 8;
    case 2: return lanes == 8 ? 8 : lanes == 4 ? 5 : 4;
    case 3: return lanes == 8 ? 8 : lanes == 4 ? 4 : 3;
    case 4: return lanes == 8 ? 6 : 2;
    case 5: return lanes == 8 ? 5 : 0;
    case 6: return lanes == 8 ? 4 : 0;
    default: return 0;
    }
}

// sums += sign thin wide in the last two variables; steps from row to row.
typedef struct kn_plane {
    int thin_rows, thin_columns, wide_rows, wide_columns;
    size_t sum_step, thin_step, wide_step;
    double sign;
} kn_plane;

// Rows of coefficients, their binomials and the reciprocals, and those of all variables before them.
typedef struct kn_weighed {
    int rows, columns;
    size_t step, packed_step; // from row to row
    const double *row, *row_inverse, *column, *column_inverse;
    double before, before_inverse;
} kn_weighed;

typedef struct kn_convolve_kernels {
    void (*plane)(double *sums, const double *thin, const double *wide, const kn_convolution *p, const kn_plane *s);
    // before: zeros in front of each of the parts, of which all but the last have `part` numbers; padded: with all
    // zeros. Multiples of the vectors' lengths.
    void (*pack)(double *packed, const double *from, const kn_weighed *w, int part, size_t before, size_t padded);
    void (*divide)(double *out, const double *sums, const kn_weighed *w);
} kn_convolve_kernels;

extern const kn_convolve_kernels kn_convolve_sse2, kn_convolve_avx2, kn_convolve_avx512;

#endif
