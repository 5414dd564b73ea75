// SPDX-License-Identifier: Apache-2.0
// Banded systems of B-spline fitting along one axis, on raw arrays: no allocation, no status.
// Data are seen as (outer, n, inner): element (o, i, j) lies at (o * n + i) * inner + j.
#ifndef KERNEL_BANDED_H
#define KERNEL_BANDED_H

#include <stdbool.h>
#include <stddef.h>

// ---- collocation: as many sites as B-splines ----
// Row i has the values of the B-splines at site[i], all within degree of the diagonal. The matrix is totally
// positive, so that elimination needs no pivoting (de Boor & Pinkus, Numer. Math. 27, 1977): L and U are
// non-negative, |L||U| = A, and the computed c has |A c - f| <= gamma(8 degree + 4) A |c|; docs/numerics.md.
typedef struct kn_collocation {
    int count, degree;
    double *band; // count rows of 2 degree + 1: the L U factors, L with unit diagonal
} kn_collocation;
size_t kn_collocation_room(int count, int degree); // doubles for `band`
// site_span[i]: the knot span whose polynomials serve site i.
void kn_collocation_factor(kn_collocation *c, const double *knots, const double *site, const int *site_span);
// Whether all pivots are positive and finite: with sites that keep the conditions of Schoenberg and Whitney false
// only when values underflow, or the condition passes 1/u.
bool kn_collocation_regular(const kn_collocation *c);
// in place, data (outer, count, inner): values at the sites become coefficients.
void kn_collocation_solve(const kn_collocation *c, double *data, size_t outer, size_t inner);
// in place, count numbers: the functional sum_i b_i c_i of the coefficients becomes one of the values at the sites.
void kn_collocation_solve_transposed(const kn_collocation *c, double *b);

// ---- least squares: more rows than columns ----
// Row i of A holds `width` numbers for the columns first[i] .. first[i] + width - 1 (those beyond the last column do
// not count), first[] not decreasing. Givens rotations turn A into an upper band R, row by row, without fill.
// Source: Golub & Van Loan, Matrix Computations, section 5.2.5; Cox, The least squares solution of overdetermined
// linear equations having band or augmented band structure, IMA J. Numer. Anal. 1 (1981).

// Rotates one row into r (columns x width: row j holds the columns j .. j + width - 1; zeros at first). turn: width
// pairs (cosine, sine), one for each column first + k. row becomes zeros.
void kn_banded_turn_row(double *r, int columns, int width, double *row, int first, double *turn);
// The same rotations on the right-hand sides: x (columns, inner) and the row's own y (inner).
void kn_banded_turn_data(double *x, int columns, int width, double *y, int first, const double *turn, size_t inner);
// in place, x (columns, inner): solves R x = what is in it. All diagonal elements are nonzero.
void kn_banded_back(const double *r, int columns, int width, double *x, size_t inner);

#endif
