// SPDX-License-Identifier: Apache-2.0
// Surfaces that the tests of shells share, and their direct evaluation in long double.
#ifndef TESTS_SUPPORT_SURFACES_H
#define TESTS_SUPPORT_SURFACES_H

#include "tests/support/support.h"

#include <knurl/shell.h>

enum { TEAPOT_PATCHES = 32 };

typedef struct surface_case {
    const char *name;
    void (*make)(kn_ctx *ctx, kn_spline *out);
} surface_case;
enum { SURFACE_CASES = 7 };
extern const surface_case surface_cases[SURFACE_CASES];

void make_plane(kn_ctx *ctx, kn_spline *out);        // bilinear, normal (0,0,1)
void make_cylinder(kn_ctx *ctx, kn_spline *out);     // rational, closed in u
void make_torus(kn_ctx *ctx, kn_spline *out);        // radii 3 and 1, rational, closed in u and v
void make_sphere(kn_ctx *ctx, kn_spline *out);       // radius 2, rational, closed in u, poles at both ends of v
void make_wavy(kn_ctx *ctx, kn_spline *out);         // bicubic, C2, a height field
void make_double_knots(kn_ctx *ctx, kn_spline *out); // bicubic, only C1 at its interior knots
void make_quintic(kn_ctx *ctx, kn_spline *out);      // degrees 5 and 4, simple knots
void make_waves(kn_ctx *ctx, kn_spline *out);        // bicubic, 20 x 20 control points, about three waves each way
void make_vase(kn_ctx *ctx, kn_spline *out);         // a rational cubic profile turned about z, closed in u
// Bicubic, a wedge of a dome: control points (r cos a, r sin a, z), r = j/3, a = i/2, smooth at the top. Its edge v = 0
// is the point 0, where (S_u x S_v) / v has a length that varies along u; n is (0,0,-1) there.
void make_dome(kn_ctx *ctx, kn_spline *out);
// A zero-based patch of data/teapot.bpt; false when the file is not there.
bool make_teapot(kn_ctx *ctx, kn_spline *out, int patch);

// value, d/du, d/dv of the components of a bivariate spline, by the recurrences of de Boor; `out` has room for 12.
void direct_spline(long double *out, const kn_spline *s, long double u, long double v);
// S, S_u, S_v and S_u x S_v (not normalised), rational or not.
void direct_surface(long double point[3], long double su[3], long double sv[3], long double cross[3],
                    const kn_spline *s, long double u, long double v);
// The same as direct_spline on the grid u x v, v fastest: 3 ncomp numbers for each of nu nv points.
void direct_grid(long double *out, const kn_spline *s, size_t nu, const double *u, size_t nv, const double *v);
// | |n| - 1 | and the angle of the shell's n against the direct normal at (u,v); false where S_u x S_v vanishes.
bool direct_errors(long double *length, long double *angle, const kn_shell *shell, long double u, long double v);

#endif
