// SPDX-License-Identifier: Apache-2.0
// Shells of other kinds than S + w n for the tests: fields, volumes, and T by direct evaluation.
#ifndef TESTS_SUPPORT_KINDS_H
#define TESTS_SUPPORT_KINDS_H

#include "tests/support/surfaces.h"

// A spline of ncomp components over the domain of `like` with one knot of its own in each variable; coefficients
// uniform in middle +- radius.
void make_field(kn_ctx *ctx, kn_spline *out, test_rng *rng, const kn_spline *like, int degree, int ncomp,
                double middle, double radius);
// T and, when it is not NULL, the Jacobian matrix, row by row, in long double: S + w h n + w^power psi, from the
// shell's S and, where d is NULL, n; h and psi NULL: none.
void direct_kind(long double t[3], long double j[9], const kn_shell *shell, const kn_shell_options *o, long double u,
                 long double v, long double w);
// A trivariate polynomial or rational spline in long double: dim numbers.
void direct_volume(long double *out, const kn_spline *s, const long double at[3]);
// The same of a Bezier piece in two variables, homogeneous: ncomp numbers.
void direct_piece(long double *out, const kn_bezier *b, const long double at[2]);
// Five volumes: ruled between two surfaces, extruded, swept, revolved (rational), and a random one of three spans in
// w.
enum { VOLUME_CASES = 5, VOLUME_OF_SPANS = 4 };
void make_volume(kn_ctx *ctx, kn_spline *out, int which);

#endif
