// SPDX-License-Identifier: Apache-2.0
// Tiles, their exact composition with a shell, periodic placement, and jobs that stream patches into sinks.
#ifndef KNURL_COMPOSE_H
#define KNURL_COMPOSE_H

#include <knurl/cells.h>
#include <knurl/shell.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { KN_NAME_BYTES = 64 };

typedef struct kn_material {
    double base_color[3]; // linear RGB in [0,1]
    double metallic, roughness;
} kn_material;

// A named part of a tile: surfaces with three components (u, v, w), polynomial, oriented outwards by r x t.
typedef struct kn_tile_part {
    char name[KN_NAME_BYTES];
    kn_material material;
    kn_spline *surfaces;
    int nsurfaces;
} kn_tile_part;

// A texture over the unit cell of (u,v); w in [0,1] spans the height. Surfaces may reach into neighbouring cells.
typedef struct kn_tile {
    char name[KN_NAME_BYTES];
    char about[2 * KN_NAME_BYTES]; // one line for a listing
    bool covering; // it covers the cell and replaces the base (definition 3 of the source); else casual
    double aspect; // height of w = 1 over the cell's width at which the tile looks as it was modelled
    kn_tile_part *parts;
    int nparts;
} kn_tile;

// A tile of nparts >= 1 empty parts. Everything in a tile belongs to it; out is overwritten, kn_tile_clear ends it.
// fails: KN_EDOMAIN nparts, KN_ELIMIT a name of KN_NAME_BYTES or more, KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_tile_init(kn_ctx *ctx, kn_tile *out, const char *name, int nparts);
KN_API void kn_tile_clear(kn_ctx *ctx, kn_tile *tile);
// Appends a copy of the surface to a part. fails: KN_EDOMAIN no such part, KN_ENOMEM; the tile is then unchanged.
KN_API KN_CHECKED kn_status kn_tile_add(kn_ctx *ctx, kn_tile *tile, int part, const kn_spline *surface);
// KN_OK, or KN_EDOMAIN: the message names the part and the surface that is no polynomial (u,v,w) surface, not finite
// or of zero area (all coefficients of its r x t within their rounding of zero); or an aspect that is negative or not
// finite, or no surface at all. Also what kn_spline_check finds, and KN_ENOMEM.
KN_API KN_CHECKED kn_status kn_tile_check(kn_ctx *ctx, const kn_tile *tile);
// Quarter turns of the (u,v) cell about its centre, counterclockwise, any number: (u,v) -> (1-v, u), one rounding
// each. fails: KN_EDOMAIN a surface that is no polynomial (u,v,w) surface; the tile is then unchanged. Allocates
// nothing.
KN_API KN_CHECKED kn_status kn_tile_rotate(kn_ctx *ctx, kn_tile *tile, int quarter_turns);

// ---- composition of one patch ----

// out(x) = outer(inner(x)), by products of polynomials alone, exact but for rounding.
// in:     outer with nvars >= 1; inner with as many value components, any nvars: a point (0), a curve, a surface, a
//         volume in anything; each polynomial or rational.
// out:    initialised, overwritten, may be an operand; rational if either operand is.
//         out.degree[d] = inner.degree[d] * sum of outer's degrees.
// fails:  KN_EDOMAIN shapes, KN_ELIMIT degree > KN_MAX_DEGREE, KN_ENOMEM; out unchanged.
// error:  gamma(P (T + n + 3) + K + N + n + 1) times the same expression in absolute values, |x| and |w - x| of
//         inner's coefficients and |c| of outer's (relative, where inner lies in the unit cell and outer is
//         positive). P the sum of outer's degrees, N and n the variables of outer and inner, T = prod
//         (inner.degree[d] + 1), K the product of the two largest (outer.degree[d] + 1). Measured: at most 11 u up to
//         degree 56. Small integers give the doubles nearest to the exact coefficients.
// cost:   about ncomp prod_(all but two variables) (p + 1) * p log2 p * T * count(out) / 3 multiply-adds, the two
//         being chosen (docs/composition.md); no allocation when out has the right size and scratch has grown.
// source: Elber, Geometric Texture Modeling, sidebar on composition; DeRose, Goldman, Hagen & Mann, Functional
//         composition algorithms via blossoming, ACM TOG 12 (1993); the nest: docs/composition.md.
KN_API KN_CHECKED kn_status kn_bezier_compose(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer,
                                              const kn_bezier *inner);

// out(x) = outer(inner(x)) for splines. inner is split where it crosses knots of outer along parameter lines: where
// a component (of a rational inner: a quotient) depends on one of inner's variables alone, up and down as often as it
// likes. Everywhere else each piece of inner has to lie inside one piece of outer.
// in:     as for kn_bezier_compose; weights of inner positive. Beyond outer's domain its end pieces are extended, as
//         kn_spline_eval does.
// out:    may be an operand. Knots: inner's, and where inner crosses knots of outer. At a knot of inner the
//         continuity of inner is kept; at a crossing that of outer at the knot that is crossed; where both meet, the
//         smaller one. Crossings nearer than 2^-44 of the domain's length and 2^-51 of its largest parameter to each
//         other, or to a knot of inner, become one. Where inner's values, but not its control points, lie inside a
//         piece of outer, control points of the result may lie outside outer's, and weights may be negative.
// fails:  KN_EDOMAIN shapes, or a component that crosses a knot of outer in another way (the message names both);
//         KN_EUNDECIDED whether it does (it touches the knot along a curve); KN_ELIMIT degree > KN_MAX_DEGREE;
//         KN_ENOMEM; out unchanged. Less than 2^-40 of the component's size beyond a knot does not count.
// error:  for each piece as kn_bezier_compose, on the pieces of both operands (knot insertion, gamma(6 p + 1) each);
//         a crossing is a root of the piece's own Bernstein form, to neighbouring doubles; then J for the way to few
//         knots (kn_spline_from_bezier).
// cost:   that of the pieces.
KN_API KN_CHECKED kn_status kn_spline_compose(kn_ctx *ctx, kn_spline *out, const kn_spline *outer,
                                              const kn_spline *inner);
// out(.., t, ..) = a(.., g(t), ..): variable var replaced by a univariate function of one component, polynomial or
// rational, not necessarily monotone: a reparameterization.
// out:    may be an operand; degree[var] = a.degree[var] * g.degree[0]; rational if either operand is.
// fails:  KN_EDOMAIN var, g's shape; KN_ELIMIT degree > KN_MAX_DEGREE; KN_ENOMEM; out unchanged.
// error:  as kn_bezier_compose of a curve with g (n = N = 1), and gamma(p + 1) for the sum over a's coefficients.
// cost:   ncomp count(a) (p m + 1) multiply-adds and a composition of univariate functions; no allocation when out
//         has the right size.
KN_API KN_CHECKED kn_status kn_bezier_substitute(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var,
                                                 const kn_bezier *g);
// The same for splines: out's domain in variable var is that of g; a's knots there become knots where g crosses them,
// with continuity and exceptions as in kn_spline_compose. The other variables keep knots and degrees.
KN_API KN_CHECKED kn_status kn_spline_substitute(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var,
                                                 const kn_spline *g);

// Sensitivities of f = outer(inner) = (sum_i c_i B_i)(inner).
// d f / d c_i, i = index (outer.nvars numbers): B_i(inner(x)), the same for every component, of dimension 1. Of a
// rational outer c_i is a homogeneous coordinate: B_i(inner) / W(inner); the derivative by the weight of that control
// point is -f times that.
// out:    may be outer or inner. fails, error: as kn_bezier_compose; KN_EDOMAIN also for an index out of range.
// cost:   as kn_bezier_compose with one component.
KN_API KN_CHECKED kn_status kn_bezier_compose_outer_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer,
                                                                const kn_bezier *inner, const int *index);
// d f / d X_(comp,q), q = index (inner.nvars numbers), of outer's dimension: (d_comp outer)(inner) B_q. Of a rational
// inner X is a homogeneous coordinate: the same over w; comp = kn_bezier_dim(inner) is the weight:
// -sum_d x_d (d_d outer)(inner) B_q / w.
// out:    may be outer or inner. Rational when outer or inner is; degrees as they come from derivative, composition
//         and product.
// fails:  KN_EDOMAIN shapes, comp, index; KN_ELIMIT degree > KN_MAX_DEGREE (the derivative of a rational outer has
//         twice its degrees); KN_ENOMEM; out unchanged.
// error:  kn_bezier_derivative, kn_bezier_compose and kn_bezier_product, one after the other.
KN_API KN_CHECKED kn_status kn_bezier_compose_inner_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer,
                                                                const kn_bezier *inner, int comp, const int *index);

// out = T(D(r,t)) by symbolic composition of each term of the piece, sum_k term[k](u,v) w^power[k]: the reference for
// the matrix below.
// in:     tile: D, any number of variables, three polynomial components (u, v, w), u and v in box coordinates, w in
//         length units.
// out:    initialised, overwritten, may be tile; rational if term[0] is.
//         out.degree[d] = tile.degree[d] * max over k of (term[k]'s degrees summed, + power[k]).
// fails:  KN_EDOMAIN shapes, a negative power, KN_ELIMIT degree > KN_MAX_DEGREE, KN_ENOMEM; out unchanged.
// error:  as kn_bezier_compose.
KN_API KN_CHECKED kn_status kn_compose_piece(kn_ctx *ctx, kn_bezier *out, const kn_shell_piece *piece,
                                             const kn_bezier *tile);

// The matrix of one tile patch for one pair of degrees: row q, column a*(degree_v+1)+b holds Bernstein coefficient q
// of B_a(u(r,t)) B_b(v(r,t)) w(r,t)^power in degree (rows_degree[0], rows_degree[1]). It depends on the tile alone: M
// times the control points of term[power] of any cell gives what that term contributes to the composed patch.
// in:     tile of two variables and components (u, v, w), polynomial; rows_degree[d] >= tile.degree[d] (degree[0] +
//         degree[1] + power).
// out:    overwritten; ended by kn_compose_matrix_clear. In the unit cell with power 0: m >= 0, rows sum to 1. Rows
//         on an edge depend on that edge alone, bit for bit the same in every patch that has it.
// fails:  KN_EDOMAIN shapes, degrees, KN_ELIMIT degree > KN_MAX_DEGREE, KN_ENOMEM; out unchanged.
// error:  docs/numerics.md, compose. cost: cols products of polynomials.
typedef struct kn_compose_matrix {
    int rows_degree[2];
    size_t rows, cols;
    double *m; // row by row; owned
} kn_compose_matrix;
KN_API KN_CHECKED kn_status kn_compose_matrix_init(kn_ctx *ctx, kn_compose_matrix *out, const kn_bezier *tile,
                                                   const int degree[2], int power, const int rows_degree[2]);
KN_API void kn_compose_matrix_clear(kn_ctx *ctx, kn_compose_matrix *matrix);

// ---- jobs ----

// Where cell lines lie.
typedef enum kn_cells_spacing {
    KN_CELLS_DEFAULT, // even in each direction whose count comes from a size, uniform where it is given
    KN_CELLS_UNIFORM, // equal parameter steps in each knot span (kn_cells_uniform_lines)
    KN_CELLS_EVEN,    // equal steps of length, for surfaces that share edges together (kn_cells_shared_lines)
    // Corners free in both directions: S is replaced by a fit of S(map) (kn_cells_relax, smooth; kn_cells_fit), from
    // even lines on; on edges that surfaces share they stay there, and on a whole part of S where its cells are too
    // few for a map without a fold, or for a fit within the tolerance in the degrees for which max_degree leaves
    // room (kn_job_report.even_instead counts these). Not for volumes, nor with fields over S.
    KN_CELLS_FREE,
} kn_cells_spacing;

// Where w in [0,1] of the tile lies, H the height.
typedef enum kn_job_side {
    KN_JOB_ABOVE, // [0,H], below the base where H is negative
    KN_JOB_BELOW, // [-|H|,0], w = 1 at -|H|
    KN_JOB_BOTH,  // [-H,H]
} kn_job_side;

// Zero means the default in every field.
typedef struct kn_job_options {
    int count[2];   // cells over each surface's domain in u and in v, at most 65536; 0: from size
    double size[2]; // wanted cell size, length units; the nearest count is taken (but no fewer than knot spans, and
                    // for even lines up to 15 % off where that suits all spans), equal on edges that surfaces share.
                    // One given: for both. None: 1/20 of the base's diagonal
    // Of w = 1 above the base, negative below; 0: the tile's aspect times the mean cell size. In length units, or
    // what thickness and direction make of it. Over a volume it is a fraction: 0 stands for 1, from one face to the
    // other.
    double height;
    double offset; // added to every height, in the same unit
    kn_job_side side;
    int quarter_turns; // of the tile in its cell
    kn_cells_spacing spacing;
    // Rows of cells, across the surfaces' variable 1, may have different counts where S narrows
    // (kn_cells_shared_bands, surfaces side by side alike). Cells of two bands do not meet at their border: tiles
    // that reach over it go on over the same surface, among the cells there. Casual tiles and sizes alone. Where
    // variable 1 meets a neighbour's variable 0 at an edge, both stay whole.
    bool rows;
    // Heights follow the local stretch: the thickness is multiplied by kn_cells_stretch (of degree 2, or 1 where
    // max_degree leaves no room, or made a function of one variable where there is not even room for that:
    // stretch_error says what it costs), made one on edges that surfaces share. Not for volumes.
    bool stretch;
    // Of S(map) with KN_CELLS_FREE, length units; 0: 1e-4 of a cell, or up to 1e-3 where degrees end before that.
    double cells_tol;
    // The shell. Splines over [0,1]^2, which stands for each surface's domain; NULL: none (shell.h). Their knots
    // become knots of S: cells have lines there. Not for volumes.
    kn_normal_method normal;
    const kn_spline *direction, *thickness, *attraction;
    int attraction_power;
    double normal_tol; // as kn_shell_options; 0: 1e-6
    int max_degree;    // of a composed patch in one variable; 0: 25 (what OCCT reads); at most KN_MAX_DEGREE
    double mesh_tol;   // chord height of tessellations, length units; 0: 1/100 of the mean cell size
    bool symbolic;     // compose each cell symbolically (the reference) instead of by matrix
} kn_job_options;
KN_API kn_job_options kn_job_defaults(void);

// What a job will make; everything is known before the first patch is composed.
typedef struct kn_job_report {
    int nsurfaces; // of the base
    int nparts;    // surfaces of the job, which counts parts between creases, and rows of cells, one by one
    size_t cells, patches, exact_patches, control_points, triangles;
    int degree[2];                // the largest in r and in t
    double height, cell_size;     // in force, length units
    kn_normal_certificate normal; // over all pieces in use
    double normal_tol;            // in force
    int max_degree;               // in force
    // Bound of |patch - T(D)| where a stand-in for n is used, length units, the thickness included; 0: none is. Where
    // D reaches beyond the surface's domain T(D) is S + w times its unit normal there, and not kn_shell_eval, which
    // extends n.
    double stand_in_error;
    double jacobian_lo, jacobian_hi; // kn_shell_jacobian_bounds over the heights that the tile occupies
    kn_cells_spread spread;          // of all cells
    double cells_error;              // bound of |S in use - S(map)| with KN_CELLS_FREE; 0: exact
    int even_instead;                // parts, of nparts, that kept even lines and S with KN_CELLS_FREE
    double stretch_error;            // relative, of the heights that follow the stretch (kn_cells_stretch)
} kn_job_report;

// Stable identity of an output patch.
typedef struct kn_patch_id {
    int surface; // of the base
    int cell[2]; // counted over the whole of it, also where the job takes it in parts (kn_job_origin)
    int part;    // of the tile
    int patch;   // Bezier patch of the part, counted over its surfaces
    int piece;   // 0 .. when a patch had to be subdivided
} kn_patch_id;

typedef struct kn_patch {
    kn_patch_id id;
    kn_bezier bezier; // two variables (r,t), 3 components or 4 homogeneous ones; borrowed, valid during the call
    bool reversed;    // outward is -(r x t): the job's height is negative
    bool exact;       // false: composed with a stand-in for n
    int segments[2];  // in r and t, by which tessellations of neighbouring patches match
} kn_patch;

typedef struct kn_patch_block {
    size_t first; // place of patches[0] in the job's order, counted from 0
    size_t count;
    const kn_patch *patches;
} kn_patch_block;

// Where a job's patches go. Calls: begin once; then for each block work (on any thread, blocks in any order and at
// the same time, with that thread's context), whose *product goes to commit (on the calling thread, blocks in order),
// or to discard when the job stops early; end once, only if all went well. close exactly once, by kn_sink_close: a
// sink that has not ended removes what it wrote. Any of them but commit and close may be NULL. Products are the
// sink's own memory.
typedef struct kn_sink {
    void *user;
    kn_status (*begin)(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report);
    kn_status (*work)(kn_ctx *worker, void *user, const kn_patch_block *block, void **product);
    kn_status (*commit)(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product);
    void (*discard)(kn_ctx *ctx, void *user, void *product);
    kn_status (*end)(kn_ctx *ctx, void *user);
    void (*close)(kn_ctx *ctx, void *user);
    size_t (*bytes)(const void *user); // written so far; NULL: nothing to count
} kn_sink;
KN_API void kn_sink_close(kn_ctx *ctx, kn_sink *sink); // idempotent

typedef struct kn_job kn_job;

// Plans tile x cells over the surfaces (dim 3, two variables, or all of them volumes of three; copied, as the tile
// is). Counts, shells and subdivisions are decided here. A surface with creases (kn_shell_split_creases, a tenth of
// normal_tol) is taken in parts, each with a shell of its own, unless a direction is given: a tile that reaches over
// a crease goes on over the extended surface of its own side, and a count is shared among the parts.
//
// A tile patch that crosses cell lines along its own parameter lines is cut there and continues in the next cell
// (wrapped where the surface is closed, on the surface at the other side of a shared edge where cell lines, normals,
// to ten normal_tol, and fields go on over it, and else on its own extended surface); otherwise it keeps its cell,
// over a box that reaches beyond it. Where no polynomial normal of low degree over the whole cell is within
// normal_tol, patches are composed over smaller boxes and bisected as needed.
//
// out:    *out, ended by kn_job_destroy.
// fails:  as kn_shell_create, kn_spline_check and kn_tile_check; KN_EDOMAIN options negative or not finite, fewer
//         cells than knot spans, a max_degree that leaves no room for the normal (the message says what is needed), a
//         tile patch that crosses a knot line of a surface and not along a parameter line of its own;
//         KN_ELIMIT counts, cells, max_degree, a tile that reaches more than 256 cells beyond its own;
//         KN_EUNDECIDED no normal within normal_tol after ten bisections each way; KN_ECANCELLED, KN_ENOMEM. *out
//         unchanged.
KN_API KN_CHECKED kn_status kn_job_create(kn_ctx *ctx, kn_job **out, const kn_spline *surfaces, int nsurfaces,
                                          const kn_tile *tile, const kn_job_options *options);
KN_API void kn_job_destroy(kn_ctx *ctx, kn_job *job);
KN_API kn_job_report kn_job_describe(const kn_job *job);
// The tile as placed (rotated), whose parts patches refer to; and the shell of one surface of the job, 0 .. nparts -
// 1 (NULL: no such).
KN_API const kn_tile *kn_job_tile(const kn_job *job);
KN_API const kn_shell *kn_job_shell(const kn_job *job, int surface);
// Which surface of the base a surface of the job is a part of (-1: no such surface), and the number of its first cell
// among the cells of that one (NULL: not wanted).
KN_API int kn_job_origin(const kn_job *job, int surface, int first_cell[2]);
// The cell lines of a surface of the job in variable var, in its own parameters: kn_shell_cells + 1 numbers. NULL: no
// such surface.
KN_API const double *kn_job_lines(const kn_job *job, int surface, int var);
// Where the (u,v) of a tile patch count from: the corner of this cell, which is [0,1]^2, of a surface of the job.
typedef struct kn_patch_place {
    int surface, cell[2];
} kn_patch_place;
// The tile patch D behind an output patch, restricted to its piece: (u, v, w), u and v counted in cells from *place
// (NULL: not wanted), w in length units; out: initialised, overwritten. The place is the patch's own cell, beyond
// whose edges D may reach, or the cell of another surface where the tile continues over an edge that the two
// surfaces share. Lets a caller check patch = T(D), with kn_job_lines. fails: KN_EDOMAIN no such patch, KN_ENOMEM;
// out unchanged.
KN_API KN_CHECKED kn_status kn_job_source(kn_ctx *ctx, kn_bezier *out, kn_patch_place *place, const kn_job *job,
                                          const kn_patch_id *id);

// Composes everything and sends it to the sinks. The same patches in the same order, bit for bit, for any number of
// threads (on one kind of processor: docs/numerics.md, compose). Memory: the matrices and the blocks in flight, 2 MiB
// or one cell each, two for each thread and one more. The sinks are not closed. ctx need not be the one that made the
// job.
//
// fails: what the sinks answer; KN_EDOMAIN a sink without commit; KN_ECANCELLED, KN_ENOMEM. All products are
//        then discarded.
KN_API KN_CHECKED kn_status kn_job_run(kn_ctx *ctx, const kn_job *job, kn_sink *sinks, int nsinks);

#ifdef __cplusplus
}
#endif
#endif
