// SPDX-License-Identifier: Apache-2.0
// Products of multivariate coefficient arrays: the arithmetic of every product and composition. No allocation.
#ifndef KERNEL_CONVOLVE_H
#define KERNEL_CONVOLVE_H

#include <stdbool.h>
#include <stddef.h>

#include <knurl/base.h>

// c += sign * a * b: c[k] += sign sum_(i + j = k) a[i] b[j] over multi-indices of nvars variables; arrays dense, the
// last variable fastest, a of degrees da[d], b of db[d], c of da[d] + db[d]. With a, b and c scaled Bernstein
// coefficients (times their binomials) it is the product of the polynomials.
// in:     sign 1 or -1; a and b may be the same, c is apart from both. work: kn_convolve_work numbers, 64-byte
//         aligned, not cleared.
// error:  T terms in a sum: gamma(L + 1) sum |a_i b_j| beside what c held, L = min(T, 20 + M (r + c + 40)), r and c
//         the lesser of da[d] + 1 and db[d] + 1 in the last two variables (1 for none), M the product of the others,
//         for da[d] + db[d] <= KN_MAX_DEGREE, else T; products and sums may be fused, in an order that depends on the
//         machine and the degrees alone. Small integers are exact. Beside an infinity or a NaN more coefficients of c
//         may become NaN than the definition asks for.
void kn_convolve(double *c, int nvars, const double *a, const int *da, const double *b, const int *db, double sign,
                 double *work);
size_t kn_convolve_work(int nvars, const int *da, const int *db);
// The plain reference, one term after the other: gamma(T + 1).
void kn_convolve_plain(double *c, int nvars, const double *a, const int *da, const double *b, const int *db,
                       double sign);

// ---- the same in parts: many products of equal shapes, or one packed operand against several others ----
// The version that runs: vectors of 2, 4 or 8 numbers; AVX2 and AVX-512 with fused multiply-adds. SSE2 stands for the
// baseline of any machine.
typedef enum kn_convolve_level {
    KN_CONVOLVE_SSE2,
    KN_CONVOLVE_AVX2,
    KN_CONVOLVE_AVX512,
    KN_CONVOLVE_LEVELS
} kn_convolve_level;
kn_convolve_level kn_convolve_best(void);
const char *kn_convolve_level_name(kn_convolve_level level);
// kn_convolve as that machine does it, at most kn_convolve_best(). work: thin_room + wide_room + sum_room numbers of
// its kn_convolution.
void kn_convolve_as(kn_convolve_level level, double *c, int nvars, const double *a, const int *da, const double *b,
                    const int *db, double sign, double *work);

// How a product is cut. One operand, the wide one, runs along the vectors: it is packed into rows with zeros on both
// sides, from which a vector starting anywhere can be read. The numbers of the other, the thin one, are broadcast. In
// the last two variables a block of rows x vectors of sums stays in registers while the wide operand's rows pass by.
// All three arrays live in the caller's memory, 64-byte aligned, their rows whole vectors.
typedef struct kn_convolution {
    kn_convolve_level level;
    bool swapped;                             // a is the wide one; else b is
    int nvars;                                // at least 1
    int thin[KN_MAX_VARS], wide[KN_MAX_VARS]; // degrees
    int sum[KN_MAX_VARS];                     // and the product's
    int parts, part;                          // of a wide row, and numbers in one
    int vectors, columns, rows;               // of a block: vectors of sums, columns and rows of the thin operand
    bool aside;                               // the sums of all blocks of rows are put together before they are added
    size_t before, padded;                    // zeros in front of a packed part, and its length with all zeros
    size_t thin_step[KN_MAX_VARS], wide_step[KN_MAX_VARS], sum_step[KN_MAX_VARS];
    size_t thin_room, wide_room, sum_room; // numbers
} kn_convolution;
void kn_convolution_init(kn_convolution *p, kn_convolve_level level, int nvars, const int *da, const int *db);
// From dense or strided arrays: step[d] from one index of variable d to the next, that of the last variable is 1 (or
// never used). scaled: times the binomials of the operand's degrees, as the product of Bernstein forms wants them:
// gamma(N), N - 1 roundings for the product of the binomials (none below 2^53) and one for that with the coefficient.
void kn_convolution_pack_thin(const kn_convolution *p, double *thin, const double *from, const size_t *step,
                              bool scaled);
void kn_convolution_pack_wide(const kn_convolution *p, double *wide, const double *from, const size_t *step,
                              bool scaled);
// sums += sign * thin * wide; kn_convolution_clear sets them to zero.
void kn_convolution_clear(const kn_convolution *p, double *sums);
void kn_convolution_run(const kn_convolution *p, double *sums, const double *thin, const double *wide, double sign);
// out = sums divided by the binomials of the product's degrees.
// error:  gamma(N): N - 1 roundings for the product of the binomials, and the quotient's, which is that to nearest
//         on every machine while the product of the binomials is below 2^44.
void kn_convolution_divide(const kn_convolution *p, double *out, const size_t *step, const double *sums);

#endif
