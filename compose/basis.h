// SPDX-License-Identifier: Apache-2.0
// Bernstein polynomials of functions in Bernstein form: what every composition is made of.
#ifndef COMPOSE_BASIS_H
#define COMPOSE_BASIS_H

#include "kernel/context.h"

#include <knurl/bezier.h>

// basis[i] = C(p,i) x^i (w - x)^(p-i) for i = 0 .. p, of degree p times x's in each variable: the Bernstein
// polynomials of degree p at x/w, times w^p. w NULL stands for the constant 1. x and w are polynomials of one
// component and one shape; basis: p + 1 empty pieces, still empty on failure.
kn_status kn_compose_basis(kn_ctx *ctx, kn_bezier *basis, int p, const kn_bezier *x, const kn_bezier *w);
// power[i] = x^i for i = 0 .. p; as above.
kn_status kn_compose_powers(kn_ctx *ctx, kn_bezier *power, int p, const kn_bezier *x);

// n empty pieces (NULL: KN_ENOMEM recorded), and their end.
kn_bezier *kn_compose_list(kn_ctx *ctx, int n);
void kn_compose_list_clear(kn_ctx *ctx, kn_bezier *list, int n);

#endif
