// SPDX-License-Identifier: Apache-2.0
// Composition in scaled Bernstein coefficients: which variable is expanded, which is nested, and the arithmetic.
#ifndef COMPOSE_NEST_H
#define COMPOSE_NEST_H

#include "kernel/context.h"
#include "kernel/convolve.h"

#include <knurl/bezier.h>

enum { KN_NEST_MOST = KN_MAX_VARS * KN_MAX_DEGREE };

// f = sum_i c_i prod_d x_d^(i_d) s_d^(p_d - i_d), x_d and s_d polynomials of inner degrees m: all polynomials on the
// way have degrees g m with a *level* g <= sum p, and lie in memory as the sums of kernel/convolve.h do.
typedef struct kn_nest {
    int outer, inner; // variables
    int p[KN_MAX_VARS], m[KN_MAX_VARS], sum;
    int order[KN_MAX_VARS]; // of outer's variables: the first `expanded` ones together, then one after the other
    int expanded;
    double count[KN_NEST_MOST + 1];  // coefficients on level g
    size_t room[KN_NEST_MOST + 1];   // numbers that they take
    kn_convolution up[KN_NEST_MOST]; // the product of a factor, of degrees m, and level g
} kn_nest;

// The nest of fewest multiply-adds for ncomp components among those that expand one or two variables.
void kn_nest_plan(kn_nest *nest, const kn_bezier *outer, const kn_bezier *inner);
// The same with variables given by hand: order and expanded are set, the rest is filled in.
void kn_nest_shape(kn_nest *nest, const kn_bezier *outer, const kn_bezier *inner);
// Multiply-adds of a nest.
double kn_nest_cost(const kn_nest *nest, int ncomp);

// out (ncomp polynomials on the level nest->sum, room after room, scaled) = the nest of outer's components at the
// factors x_d = factor + 2 d n and s_d behind it, n = prod (m + 1) numbers each, dense, scaled. KN_ENOMEM: scratch.
kn_status kn_nest_run(kn_ctx *ctx, double *out, const kn_nest *nest, const kn_bezier *outer, const double *factor);
// out (batch polynomials on level g + 1) += in (batch, level g) times a factor.
kn_status kn_nest_times(kn_ctx *ctx, double *out, const kn_nest *nest, const double *in, size_t batch, int g,
                        const double *factor);
// The factors of kn_nest_run from inner's components X_d: x_d = (X_d - lo_d w)/(hi_d - lo_d) and
// s_d = (hi_d w - X_d)/(hi_d - lo_d), w = 1 for a polynomial inner; lo and hi NULL: 0 and 1.
kn_status kn_nest_factors(kn_ctx *ctx, double *factor, const kn_nest *nest, const kn_bezier *inner, const double *lo,
                          const double *hi);
// w^sum into out, on that level; w plain coefficients of inner's degrees.
kn_status kn_nest_power(kn_ctx *ctx, double *out, const kn_nest *nest, const double *w);
// out (ncomp, dense) = plain coefficients of what kn_nest_run and kn_nest_power have made.
void kn_nest_divide(double *out, const kn_nest *nest, const double *value, int ncomp);
// kn_bezier_compose over the box [lo,hi] of outer's domain (NULL: the unit box), all checks done.
kn_status kn_compose_over(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer, const kn_bezier *inner,
                          const double *lo, const double *hi);
// The plain reference of kn_bezier_compose: all Bernstein polynomials of each variable, one product after the other.
kn_status kn_compose_plain(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer, const kn_bezier *inner);

#endif
