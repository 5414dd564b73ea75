// SPDX-License-Identifier: Apache-2.0
// Lower degrees, on raw arrays: no allocation, no status.
#ifndef KERNEL_REDUCE_H
#define KERNEL_REDUCE_H

#include <stdbool.h>
#include <stddef.h>

#include "kernel/knots.h"

// ---- least squares against a banded map E, the coefficients of an elevation ----
// d minimises |E d - b| (Euclidean). fixed: so many numbers at each end of d are the caller's, and the others minimise
// what is left; as many rows of E at each end have none of the others. By Givens rotations (kernel/banded.h).
typedef struct kn_projection {
    const kn_band *e; // with terms[], first[] not decreasing
    int columns, fixed;
    double *r, *turns, *row; // kn_projection_room numbers in all, from r on
} kn_projection;
size_t kn_projection_room(int rows, int columns, int width);
void kn_projection_factor(kn_projection *p, const kn_band *e, int columns, int fixed, double *room);
// d (columns, inner), the numbers that are fixed filled in, from b (rows, inner); work: inner numbers.
void kn_projection_solve(const kn_projection *p, double *d, const double *b, size_t inner, double *work);

// ---- Bernstein form ----
// The elevation from m to n as a band: rows n + 1, width m + 1, room for terms[] given.
void kn_bernstein_elevation(kn_band *e, int m, int n);
// p (m + 1) = the polynomial of degree m whose elevation has b's first (m + 1) / 2 and last m / 2 + 1 of n + 1
// coefficients: the polynomial itself where it is of degree m.
void kn_bernstein_lower(double *p, int m, const double *b, int n);
// Whether b (n + 1) is exactly the elevation of p (m + 1).
bool kn_bernstein_is_elevated(const double *b, int n, const double *p, int m);
// max |b - elevation of p|, as computed.
double kn_bernstein_misfit(const double *b, int n, const double *p, int m);
// The degree of the polynomial with the coefficients b, exactly, or n where the numbers are too large or small
// to say.
int kn_bernstein_degree(const double *b, int n);

#endif
