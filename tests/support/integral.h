// SPDX-License-Identifier: Apache-2.0
// Volumes and areas of patches by Gauss's quadrature, span by span: exact, but for rounding, where a patch is polynomial.
#ifndef TESTS_SUPPORT_INTEGRAL_H
#define TESTS_SUPPORT_INTEGRAL_H

#include <knurl/job.h>

// n nodes and weights of [0,1], exact up to degree 2n - 1.
void test_gauss(int n, double *node, double *weight);
// *volume += the patch's part of (1/3) int x . dA over the boundary of a body, outward (of a reversed one too);
// *area += its area (a quadrature: the root is no polynomial). Trims do not count: whole surfaces.
void test_add_integrals(kn_ctx *ctx, double *volume, double *area, const kn_patch *patch);

// The same of all that passes a sink, of volumes their faces that are not hidden.
typedef struct test_integrals {
    double volume, area;
    int faces;
} test_integrals;
kn_sink test_integral_sink(test_integrals *out);

#endif
