// SPDX-License-Identifier: Apache-2.0
// What the constructors share: operands in scratch, common grids, circles.
#ifndef CONSTRUCT_INTERNAL_H
#define CONSTRUCT_INTERNAL_H

#include <knurl/construct.h>

// KN_EDOMAIN (recorded) unless all n numbers are finite.
kn_status kn_construct_finite(kn_ctx *ctx, const char *call, const double *x, int n);

// ---- operands: splines whose arrays are borrowed or lie in scratch ----
// *to = a with a weight of 1 when rational is wanted and a is not; its arrays are a's own, or in scratch.
kn_status kn_construct_operand(kn_ctx *ctx, const char *call, kn_spline *to, const kn_spline *a, bool rational);
// kn_spline_unite_all_in_scratch, when the domains agree (else KN_EDOMAIN).
kn_status kn_construct_unite(kn_ctx *ctx, const char *call, kn_spline *s, const int *var, int n, int least);
// s[0 .. n-1] = list[..] as operands of one dimension over the same variables and domains, on one grid.
kn_status kn_construct_compatible(kn_ctx *ctx, const char *call, kn_spline *s, const kn_spline *list, int n);
// *to in scratch = the shape of a and one variable more, the last, of this degree and count. Knots are copied but for
// the new variable's; coefficients are not filled.
kn_status kn_construct_extend(kn_ctx *ctx, const char *call, kn_spline *to, const kn_spline *a, int degree,
                              int count);
// KN_EUNDEFINED unless all weights are positive.
kn_status kn_construct_check_weights(kn_ctx *ctx, const char *call, const kn_spline *s);

// ---- circles ----
enum { KN_TURN_MAX = 9 };                     // control points of a whole turn
#define KN_QUARTER_TURN 0x1.921fb54442d18p+0  // the double next to pi/2
#define KN_WHOLE_TURN (4.0 * KN_QUARTER_TURN) // exactly four times that
// The unit circle from angle 0 on: n control points (cos, sin) in homogeneous coordinates with their weights, and the
// knots of a quadratic over [0,1].
typedef struct kn_turn {
    int n;
    double c[KN_TURN_MAX], s[KN_TURN_MAX], w[KN_TURN_MAX], knots[KN_TURN_MAX + 3];
    bool closed;
} kn_turn;
kn_status kn_construct_turn(kn_ctx *ctx, const char *call, kn_turn *out, double angle);

// Unit vectors x, y across z, z of any length; x as construct.h says for surfaces of revolution. KN_EUNDEFINED z = 0.
kn_status kn_construct_frame(kn_ctx *ctx, const char *call, double x[3], double y[3], double unit[3],
                             const double z[3]);
double kn_construct_dot(const double a[3], const double b[3]);
void kn_construct_cross(double out[3], const double a[3], const double b[3]);
// False for zero and what is not finite. Scaled by the largest component: squares neither over- nor underflow.
bool kn_construct_normalize(double unit[3], const double v[3]);

// A profile in the half-plane: homogeneous distance from the axis rho, height z (in units of up), weight.
typedef struct kn_profile {
    int degree, n;
    double rho[KN_TURN_MAX], z[KN_TURN_MAX], w[KN_TURN_MAX], knots[KN_TURN_MAX + 3];
} kn_profile;
// out(u,v) = origin + z(v) up + rho(v) (cos x + sin y), a whole turn in u.
kn_status kn_construct_lathe(kn_ctx *ctx, const char *call, kn_spline *out, const kn_profile *profile,
                             const double origin[3], const double up[3], const double x[3], const double y[3]);

#endif
