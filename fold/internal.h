// SPDX-License-Identifier: Apache-2.0
// Inside fold: what the tests of the Jacobian share.
#ifndef FOLD_INTERNAL_H
#define FOLD_INTERNAL_H

#include <knurl/fold.h>

// ---- pieces.c ----
// The box of the shell's grid with this number, 0 .. n-1, and how many there are.
size_t kn_fold_boxes(const kn_shell *shell);
kn_status kn_fold_piece(kn_ctx *ctx, kn_shell_jacobian_piece *out, const kn_shell *shell, size_t index);
// Turns j of a piece (its errors with it) into powers of the height above p->lo[2], or below 0 when `below`: two
// variables, component k the coefficient of height^k. A volume's j had three.
kn_status kn_fold_to_heights(kn_ctx *ctx, kn_shell_jacobian_piece *p, bool below);
// Turns j of a piece over the part [lo,hi] of its box, in its own coordinates [0,1]^2 (of a volume [0,1]^3; else
// heights themselves in the third), into one component in three variables over [0,1]^3; the denominator likewise.
// error[l], KN_FOLD_ROWS at most: of the coefficients in row l of the third variable.
enum { KN_FOLD_ROWS = KN_MAX_DEGREE + 1 };
kn_status kn_fold_to_box(kn_ctx *ctx, kn_shell_jacobian_piece *p, double *error, const double lo[3],
                         const double hi[3]);

// ---- first_root.c ----
// At most the first w > 0 at which sum_k c_k w^k may be 0, where each c_k is known within error[k] + share |c_k|;
// INFINITY when there is none, 0 when it is not positive next to 0. c_k at c[k * step]. zero_at_0: c_0 is 0 exactly.
double kn_fold_first_root(const double *c, size_t step, const double *error, int top, double share, bool zero_at_0);

// ---- sampled.c ----
// Parameters for display: `steps` equal ones for each cell, n[v] in all, their ends moved inwards by a little, as J may
// vanish there for all w. at[v]: kn_free.
kn_status kn_fold_parameters(kn_ctx *ctx, double *at[2], size_t n[2], const kn_shell *shell, int steps);
void kn_fold_clear_splines(kn_ctx *ctx, kn_spline *list, int n);

#endif
