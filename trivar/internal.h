// SPDX-License-Identifier: Apache-2.0
// Inside trivar: what a shell holds, and the steps by which it is made.
#ifndef TRIVAR_INTERNAL_H
#define TRIVAR_INTERNAL_H

#include "bezier/norm_bound.h"

#include <knurl/shell.h>

// The direction of the normal of S over one of its knot spans, a polynomial in [0,1]^2 of that span, three
// components: S_u x S_v up to a positive factor, with the factors that vanish along its edges divided out.
typedef struct kn_direction {
    kn_bezier n;
    double error;    // bound of the error of every coefficient vector of n
    int exponent;    // n is so many powers of two smaller than S_u x S_v (of a rational S, W^3 times it)
    int order[2][2]; // [variable][end]: how often x or (1 - x) was divided out
} kn_direction;

// A spline that T is made of, beside n: whole, and over the knot spans of S. Its knots are knots of S.
typedef struct kn_shell_field {
    kn_spline whole;
    kn_bezier *span; // nspans of them
    int power;       // of w
} kn_shell_field;

typedef enum kn_shell_kind {
    KN_SHELL_NORMAL,    // T = S + w h n + w^k psi
    KN_SHELL_DIRECTION, // T = S + w h d + w^k psi
    KN_SHELL_VOLUME,    // T = the volume
} kn_shell_kind;

// T = S + w h n + sum_t field[t] w^power. `n` is there in shells of KN_SHELL_NORMAL alone, with all that belongs to
// it (direction, certificates); the h of KN_SHELL_DIRECTION is in field[0] already. A volume with one span in w is
// held as its powers of w and as it is; with several (kn_shell_has_terms is false) only as it is.
struct kn_shell {
    kn_shell_kind kind;
    kn_spline surface, normal;
    kn_spline local;          // S, or the volume, less a translation: what normals and Jacobians are computed from
    kn_bezier *local_span;    // its nspans pieces over the knot spans; NULL of a volume
    double size, slack;       // of S or of the volume: kn_extent
    kn_shell_field thickness; // h; `whole` empty: 1
    kn_shell_field field[KN_SHELL_TERMS - 1];
    int nfields;
    bool
        homogeneous; // T = (S's four components + the fields' four) / weight; else the fields add to S after division
    kn_spline volume; // its third domain begins at 0
    kn_normal_method method;
    double normal_tol;
    bool closed[2];
    double *line[2]; // cell lines
    int nlines[2];
    double *knot[2]; // distinct knots of S: the borders of `direction` and `span`
    int nknots[2];
    // Distinct knots of n: the borders of `normal_piece` and `certificates`. Knots of S are among them, and every cell
    // lies between two that are neighbours unless it has one inside. Without n: the knots of S.
    double *cut[2];
    int ncuts[2];
    double *box[2]; // lines and cuts together: the borders of kn_shell_jacobian_grid
    int nboxes[2];  // intervals
    kn_direction *direction;
    kn_bezier *span, *normal_piece; // pieces of S over its knot spans, and of n
    size_t ndirections, nspans, nnormal_pieces;
    kn_normal_certificate *certificates; // one for each of normal_piece
    kn_normal_certificate certificate;   // of all of them
};

// Where the control points of a spline in space lie.
typedef struct kn_extent {
    double size;      // the largest side of their box
    double middle[3]; // of the box
    double slack;     // what the rounding of coordinates as far from the origin as these may be: 16 units
} kn_extent;
kn_extent kn_extent_of(const kn_spline *s);
// The coefficients along one edge of an array (count[0], count[1]).
typedef struct kn_row {
    size_t first, step, count;
} kn_row;
kn_row kn_edge_row(const int count[2], int var, int end);
// The points of a row agree with its first one to `near` in each coordinate. coef: components of `size` numbers, the
// fourth the weight where `rational`.
bool kn_one_point(const double *coef, size_t size, bool rational, const kn_row *row, double near);
// The interval of breaks[0 .. n-1] that serves x: the right-hand one at a break, the end ones outside.
int kn_interval(const double *breaks, int n, double x);
// u-bound of k roundings: k u / (1 - k u).
double kn_gamma(double k);
enum { KN_LEAST_DEGREE = 3 }; // of n in one variable, or of m where n = N m
// Records that S has no normal at a place (singular), or that it could not be decided whether it has one near it.
kn_status kn_fail_normal(kn_ctx *ctx, const kn_shell *shell, const double at[2], bool singular);
// ---- snap_edges.c ----
// Edges of s whose control points agree to 1e-9 of its size, but not as nearly as rounding leaves them, become one
// point: the middle of theirs.
void kn_snap_edges(kn_spline *s);
// What a message about a normal that was not found may add: that an edge is nearly one point, 1e-4 of S's size; or "".
const char *kn_thin_edge(const kn_shell *shell);
// ---- edges.c ----
// What the edge at this end of variable var is.
kn_shell_edge kn_edge_of(const kn_shell *shell, int var, int end);

// ---- shell.c ----
// Lines, closed directions and pieces, from the surface, the fields and the options' lines.
kn_status kn_shell_set_grid(kn_ctx *ctx, kn_shell *shell, const kn_shell_options *options);
// box[] from lines and cuts.
kn_status kn_shell_set_boxes(kn_ctx *ctx, kn_shell *shell);
// kn_shell_options with its defaults resolved.
kn_status kn_shell_resolve(kn_ctx *ctx, kn_shell_options *out, const kn_shell_options *options);

// ---- fields.c ----
// thickness and field[] from the options, checked; their knots become knots of shell->surface.
kn_status kn_shell_take_fields(kn_ctx *ctx, kn_shell *shell, const kn_shell_options *options);
// The pieces of f over the spans of the shell, whose knots are there.
kn_status kn_shell_cut(kn_ctx *ctx, kn_bezier **span, const kn_shell *shell, const kn_spline *f);
// f is the same at both ends of variable var, to 1e-12 of its size and the rounding of its coordinates; of a rational
// f so are the weights.
kn_status kn_shell_ends_meet(kn_ctx *ctx, bool *meet, const kn_spline *f, int var);
// No longer closed: directions in which the normals of the two edges differ, a crease.
void kn_shell_open_seams(kn_shell *shell);
// Whether T is a sum of powers of w: nterms of them with S, which is the first (power 0).
static inline bool kn_shell_has_terms(const kn_shell *s)
{
    return s->kind != KN_SHELL_VOLUME || s->nfields > 0;
}
int kn_shell_nterms(const kn_shell *shell);
// *out = term t as a spline: three components, or four homogeneous ones (as a polynomial) when S is rational.
kn_status kn_shell_term(kn_ctx *ctx, kn_spline *out, int *power, const kn_shell *shell, int t);

// ---- numerator.c ----
// *out = the direction of one piece of S; *zero: its area vanishes identically (then *out stays empty).
// acting: the largest vector (without the weight) and weight among the control points of S behind the piece.
// slack: edges that vanish when the points of S move so far count as vanishing.
kn_status kn_direction_init(kn_ctx *ctx, kn_direction *out, bool *zero, const kn_bezier *piece,
                            const double acting[2], double slack);
void kn_direction_clear(kn_ctx *ctx, kn_direction *d);
// The length of the direction at x in [0,1]^2 of the span, and the unit normal; 0 (and zeros) where it vanishes.
double kn_direction_length(double unit[3], const kn_bezier *direction, const double x[2]);
// The unit normal alone; false (and zeros) where the direction vanishes.
bool kn_direction_unit(double unit[3], const kn_bezier *direction, const double x[2]);
// ---- regular.c ----
typedef enum kn_regularity {
    KN_REGULAR,  // the direction vanishes nowhere on [0,1]^2
    KN_SINGULAR, // it does, but for rounding, near at[2]
    KN_UNDECIDED // the work ran out at at[2]
} kn_regularity;
// *work: what is left of it, in multiply-adds; the first halvings are free.
kn_status kn_direction_regular(kn_ctx *ctx, kn_regularity *answer, double at[2], const kn_direction *d, double *work);
// ---- directions.c ----
#define KN_REGULAR_WORK 1e8 // for a whole surface: some tenths of a second
// *out = s less a translation that brings it to the origin where it lies far from there (and is 0 else): subtraction
// of numbers that are alike is exact, and the weight times the translation takes one rounding of the result.
kn_status kn_spline_to_origin(kn_ctx *ctx, kn_spline *out, const kn_spline *s);
// direction[], one for each span; refuses a surface without area or without a normal.
kn_status kn_shell_make_directions(kn_ctx *ctx, kn_shell *shell);
// Lowers *max_degree, of n or of m, to what the certificates can multiply.
kn_status kn_shell_limit_degree(kn_ctx *ctx, int *max_degree, const kn_shell *shell);

// ---- certify.c ----
typedef struct kn_certify_options {
    double limit;           // neither error may pass it; give up as soon as one does
    double target[2];       // length and angle bounds at or below these need no subdivision
    double normal_error;    // of n's coefficients
    double direction_error; // of the direction's coefficients
    double *work;           // multiply-adds that are left: without any nothing is halved. NULL: no limit
} kn_certify_options;
// Bounds over [0,1]^2 of how far m is from direction/|direction|. certified is false, and the numbers INFINITY, when
// a bound passes the limit or none was found.
kn_status kn_certify(kn_ctx *ctx, kn_normal_certificate *out, const kn_bezier *m, const kn_bezier *direction,
                     const kn_certify_options *options);
// The largest errors of both kinds at 16 points inside: a lower bound of what kn_certify finds.
void kn_sample_errors(double *length, double *angle, const kn_bezier *m, const kn_bezier *direction);

// ---- grid.c ----
// One variable of the fitted normal: the lines, how often n is differentiable across each, and what follows from a
// degree: knots, sites and the span of n and of S that serve each site.
typedef struct kn_grid_axis {
    const double *line; // of the shell: where cells end
    int nlines;
    int ncuts, room;
    double *cut;
    int *smooth; // -1: n jumps; KN_SMOOTH: no limit but the degree
    int most;    // n is no smoother than this: KN_LOOSE of high degrees, for which smoother splines need higher ones
                 // still; 0: each cell for itself
    int degree, count;
    double *knots, *site;
    int *site_span, *site_knot_span;
} kn_grid_axis;
enum { KN_SMOOTH = 1000, KN_LOOSE = 2 };
// The knots of S and cell lines: all of them, or about KN_GRID_LINES spread over the spans where there are more.
enum { KN_GRID_LINES = 64 };
kn_status kn_grid_init(kn_ctx *ctx, kn_grid_axis *g, const kn_shell *shell, int var);
void kn_grid_clear(kn_ctx *ctx, kn_grid_axis *g);
// n's at cut i, of the degree that is set.
int kn_grid_continuity(const kn_grid_axis *g, int i);
kn_status kn_grid_set_degree(kn_ctx *ctx, kn_grid_axis *g, int degree, const double *breaks, int nbreaks);
// Cuts the intervals i with split[i]: at the cell line nearest to the middle, or there where a cell has none inside.
kn_status kn_grid_split(kn_ctx *ctx, kn_grid_axis *g, const char *split);

// ---- fit.c ----
// *out = the spline that interpolates the unit normal at the sites of both axes.
kn_status kn_fit_normal(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, const kn_grid_axis axes[2]);
// *out = the spline of one component that interpolates 1/|factor N|, one factor for each span of S.
kn_status kn_fit_reciprocal(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, const kn_grid_axis axes[2],
                            const double *factor);

// ---- exact_direction.c ----
// The direction over a box inside a span of S.
typedef struct kn_direction_box {
    kn_bezier n;
    double error; // bound of the error of every coefficient vector of n
    size_t span;  // of S
} kn_direction_box;
// *out = N m, m the spline near 1/|N| for these axes; boxes: N over all boxes of the axes.
kn_status kn_fit_exact_direction(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, const kn_grid_axis axes[2],
                                 const kn_direction_box *boxes);
// Whether |N| is the same on both sides of interior knot k of variable var, but for one factor all along it.
bool kn_lengths_continue(const kn_shell *shell, int var, int k);

// ---- refine.c ----
// Finds lines and degrees that meet the tolerance; fills normal, cut, normal_piece and the certificates.
// highest: degree of n, or of m.
kn_status kn_refine_normal(kn_ctx *ctx, kn_shell *shell, const kn_shell_options *options, int highest);

// ---- stand_in.c ----
// *out = a polynomial of degrees a + b <= degree_sum that meets limit on [0,1]^2; *fits tells whether there is one.
// exact: a multiple of the direction.
kn_status kn_stand_in(kn_ctx *ctx, kn_bezier *out, kn_normal_certificate *certificate, bool *fits,
                      const kn_bezier *direction, double direction_error, double limit, int degree_sum, bool exact);

// ---- jacobian_terms.c ----
enum { KN_BOX_TERMS = 4, KN_BOX_POWERS = KN_MAX_DEGREE + 1 };
// Components, as bits, in which the control points that act on a box are 0, or do not change along a variable: there
// the function, or its derivative, is 0 exactly.
typedef struct kn_same {
    unsigned none, alike[3];
} kn_same;
// T over one box, [0,1]^nvars in what follows: nvars 2, S + sum_t term[t] w^power[t], term[0] being S; or a volume.
typedef struct kn_box_map {
    int nvars, nterms, power[KN_BOX_TERMS];
    kn_bezier term[KN_BOX_TERMS]; // three components each; of a rational S the numerator P of P/weight
    kn_bezier weight;             // empty: polynomial
    double error[KN_BOX_TERMS];   // of every coefficient vector
    kn_same same[KN_BOX_TERMS], weight_same;
    double weight_error, weight_size;
    double width[3], knot[3], span[3]; // of the box, its knot span and the whole domain, in the parameters of T
    double size, slack;                // kn_extent of S
} kn_box_map;
// *out: its j, error, denominator, and where `divided` also order and flat; the rest is left as it is.
kn_status kn_jacobian_of(kn_ctx *ctx, kn_shell_jacobian_piece *out, const kn_box_map *map, bool divided);
// ---- jacobian_piece.c ----
// kn_shell_jacobian_piece_init over an interval of `breaks` in u and v, which the shell's cuts do not divide; not
// divided: det itself, poles and all.
kn_status kn_jacobian_box(kn_ctx *ctx, kn_shell_jacobian_piece *out, const kn_shell *shell, double *const breaks[2],
                          const int at[3], bool divided);

#endif
