// SPDX-License-Identifier: Apache-2.0
// kn_shell: the map T(u,v,w) = S(u,v) + n(u,v) w from texture space to the neighbourhood of a base surface S,
// n a spline fitted to the unit normal of S. Source: Elber, Geometric Texture Modeling, IEEE CG&A 25(4), 2005.
#ifndef KNURL_SHELL_H
#define KNURL_SHELL_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// How far a vector field m is from the true unit normal N/|N|, N = S_u x S_v. Both are upper bounds over the whole
// region, computed from Bernstein coefficients with their own rounding included, never from samples.
typedef struct kn_normal_certificate {
    double length_error; // bound of | |m| - 1 |
    double angle_error;  // bound of the angle between m and N, radians
    bool certified;      // false: no bound could be established (the numbers are then INFINITY)
} kn_normal_certificate;

typedef struct kn_shell kn_shell;

// Zero means the default in every field.
typedef struct kn_shell_options {
    // Cell lines in S's own parameters, increasing, from one end of the domain to the other. Every interior knot of S
    // must be among them (KN_EDOMAIN otherwise). NULL: the knots of S.
    const double *lines[2];
    int nlines[2];
    double normal_tol; // the largest length error and angle error allowed; 0: 1e-6
    int max_degree;    // of n in one variable, at least 3; 0: 5
    int max_spans;     // knot intervals of n in one variable, beyond which refinement gives up; 0: 4096
} kn_shell_options;

KN_API kn_shell_options kn_shell_defaults(void);

// The shell of a surface (nvars 2, dim 3, polynomial or rational), which is copied. n is a spline of degree 3 .. 5,
// C2 or smoother wherever S is C3 or smoother, whose knots contain the cell lines and more lines where the tolerance
// asks for them; an edge of S that is collapsed to a point is divided out of N exactly first.
// fails: KN_EDOMAIN (shapes, lines, a surface of zero area: the message says which), KN_EUNDEFINED (no normal at some
//        point: the message names it), KN_EUNDECIDED (normal_tol not met within max_spans), KN_ELIMIT, KN_ENOMEM.
KN_API KN_CHECKED kn_status kn_shell_create(kn_ctx *ctx, kn_shell **out, const kn_spline *surface,
                                            const kn_shell_options *options);
KN_API void kn_shell_destroy(kn_ctx *ctx, kn_shell *shell);

KN_API const kn_spline *kn_shell_surface(const kn_shell *shell);
KN_API const kn_spline *kn_shell_normal(const kn_shell *shell);
KN_API kn_normal_certificate kn_shell_certificate(const kn_shell *shell);
KN_API void kn_shell_cells(const kn_shell *shell, int cells[2]);
// closed[d]: the two edges across variable d coincide, so that cell -1 is the last cell.
KN_API void kn_shell_closed(const kn_shell *shell, bool closed[2]);

// T at (u,v) in S's parameters and signed height w in S's length unit. jacobian, when not NULL, receives the 3 x 3
// matrix dT/d(u,v,w), row by row.
KN_API KN_CHECKED kn_status kn_shell_eval(kn_ctx *ctx, double point[3], double *jacobian, const kn_shell *shell,
                                          double u, double v, double w);
// The true unit normal of S at (u,v), by direct evaluation (poles divided out), without the fitted spline.
KN_API KN_CHECKED kn_status kn_shell_unit_normal(kn_ctx *ctx, double normal[3], const kn_shell *shell, double u,
                                                 double v);

// Bounds of det dT/d(u,v,w) over the cells for w in [w0,w1]: *lo <= det <= *hi, rounding included (source: J is a
// quadratic in w with coefficients that are splines over (u,v)). The unit: length^3 per parameter^2 length.
KN_API KN_CHECKED kn_status kn_shell_jacobian_bounds(kn_ctx *ctx, double *lo, double *hi, const kn_shell *shell,
                                                     double w0, double w1);

// T as one polynomial or rational piece over a box of (u,v): T = sum_k term[k](x) w^k, x in [0,1]^2 over the box, w
// in length units. term[k] has 3 components, or 4 homogeneous ones when S is rational (weight 0 in term[1]).
enum { KN_SHELL_TERMS = 2 };
typedef struct kn_shell_piece {
    int nterms;
    kn_bezier term[KN_SHELL_TERMS];
    bool exact; // n is the shell's own spline; false: a polynomial that stands in for it on this box
    kn_normal_certificate normal; // of the n in use, over this box
    double deviation;             // bound of |n in use - the shell's n| over the box; 0 when exact
} kn_shell_piece;

// The piece over the box [lo,hi] of cell (i,j), in cell coordinates: [0,1]^2 is the whole cell; boxes may reach
// beyond it, and beyond the domain, where S's end pieces are extended as polynomials; the box must not contain a knot
// of S in its interior (KN_EDOMAIN). i or j outside 0 .. cells-1 wraps in closed directions and extends in open ones.
// Where n has knots inside the box, *fits tells whether one polynomial of degrees (a,b), a + b <= degree_sum, meets
// normal_tol over the whole box; if none does, *fits is false, out is unchanged, and the caller may try smaller
// boxes.
KN_API KN_CHECKED kn_status kn_shell_piece_init(kn_ctx *ctx, kn_shell_piece *out, bool *fits, const kn_shell *shell,
                                                const int cell[2], const double lo[2], const double hi[2],
                                                int degree_sum);
KN_API void kn_shell_piece_clear(kn_ctx *ctx, kn_shell_piece *piece);

#ifdef __cplusplus
}
#endif
#endif
