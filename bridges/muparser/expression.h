// SPDX-License-Identifier: Apache-2.0
// Expressions as fields, through muParser.
#ifndef BRIDGES_EXPRESSION_H
#define BRIDGES_EXPRESSION_H

#include <knurl/field.h>

#ifdef __cplusplus
extern "C" {
#endif

// An expression of the place, compiled.
typedef struct kn_expression kn_expression;

// Compiles text: numbers, + - * / ^, comparisons, && || and a ? b : c, and
//     u v             parameters in [0,1] over the surface
//     x y z           the point, length units
//     nx ny nz        the unit normal
//     mean gauss      curvatures
//     face            number of the surface
//     pi
//     sin cos tan asin acos atan atan2 sinh cosh tanh exp ln log2 log10 sqrt abs sign rint floor min max sum avg
//     clamp(x,a,b)    x kept in [a,b]
//     mix(a,b,t)      a + t (b - a)
//     smooth(a,b,x)   0 below a, 1 above b, cubic between
//     mod(x,y)        x - y floor(x / y)
//     noise(x,y,z)    kn_noise of the seed
// out:    kn_expression_destroy ends it.
// fails:  KN_EPARSE: what is wrong, "at POSITION" (a character of the text, from 1); an assignment, several values;
//         KN_ENOMEM; out unchanged.
// error:  a few roundings each, and those of the system's mathematical functions.
// cost:   a copy for each thread of ctx: more threads than that wait for each other.
KN_API KN_CHECKED kn_status kn_expression_create(kn_ctx *ctx, kn_expression **out, const char *text, uint64_t seed);
KN_API void kn_expression_destroy(kn_ctx *ctx, kn_expression *expression); // NULL is fine
// Its values; expression: borrowed. needs: what its variables ask for. Where it is undefined the value is not finite.
KN_API kn_field kn_expression_field(const kn_expression *expression);

#ifdef __cplusplus
}
#endif
#endif
