// SPDX-License-Identifier: Apache-2.0
// Tiles: textures over the unit cell of the (u,v) plane.
#ifndef KNURL_TILE_H
#define KNURL_TILE_H

#include <knurl/mesh.h>
#include <knurl/solve.h>
#include <knurl/spline.h>
#include <knurl/trim.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { KN_NAME_BYTES = 64 };

typedef struct kn_material {
    double base_color[3]; // linear RGB in [0,1]
    double metallic, roughness;
} kn_material;

// A named part of a tile: curves, surfaces (oriented outwards by r x t) and volumes (right-handed) of three
// components (u, v, w), polynomial, and a triangle mesh of (u, v, w), in any mixture.
typedef struct kn_tile_part {
    char name[KN_NAME_BYTES];
    kn_material material;
    kn_spline *splines; // of one, two or three variables
    kn_trim *trims;     // of each spline, over [0,1]^2, empty unless it is a trimmed surface; NULL: none is
    int nsplines;
    kn_mesh mesh; // empty: none
    // Where parameter k of the tile, at its target, puts spline i: targets[k * nsplines + i], of the same degrees and
    // knots, or empty where it changes nothing; and the mesh's vertices: mesh_targets[k], 3 numbers each, or NULL.
    // NULL: no parameter changes the part.
    kn_spline *targets;
    double **mesh_targets;
    bool plain; // nobody chose its material: a program may take another one
} kn_tile_part;

// A number by which a tile can be varied (a blend shape): control points are P + sum over parameters of
// (x - value) / (target - value) (P at the target - P).
typedef struct kn_tile_parameter {
    char name[KN_NAME_BYTES];
    double value;  // at which the tile is as its parts say
    double target; // at which it is as their targets say; not `value`
    double lo, hi; // what makes sense
} kn_tile_parameter;

// A texture over the unit cell of (u,v); w in [0,1] spans the height. Surfaces may reach into neighbouring cells.
typedef struct kn_tile {
    char name[KN_NAME_BYTES];
    char about[2 * KN_NAME_BYTES]; // one line for a listing
    bool covering; // it covers the cell and replaces the base (definition 3 of the source); else casual
    double aspect; // height of w = 1 over the cell's width at which the tile looks as it was modelled
    kn_tile_part *parts;
    int nparts;
    kn_tile_parameter *parameters;
    int nparameters;
} kn_tile;

// A tile of nparts >= 1 empty parts. Everything in a tile belongs to it; out is overwritten, kn_tile_clear ends it.
// fails: KN_EDOMAIN nparts, KN_ELIMIT a name of KN_NAME_BYTES or more, KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_tile_init(kn_ctx *ctx, kn_tile *out, const char *name, int nparts);
KN_API void kn_tile_clear(kn_ctx *ctx, kn_tile *tile);
// out = the tile with all that belongs to it; overwritten. fails: KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_tile_copy(kn_ctx *ctx, kn_tile *out, const kn_tile *tile);

// Appends a copy of a curve, surface or volume to a part; of a surface what lies in the trim, whose [0,1]^2 stands
// for the surface's domain. fails: KN_EDOMAIN no such part, a trim for what is no surface; KN_ENOMEM; the tile is
// then unchanged.
KN_API KN_CHECKED kn_status kn_tile_add(kn_ctx *ctx, kn_tile *tile, int part, const kn_spline *spline);
KN_API KN_CHECKED kn_status kn_tile_add_trimmed(kn_ctx *ctx, kn_tile *tile, int part, const kn_spline *surface,
                                                const kn_trim *trim);
// The part's mesh is a copy of this one, (u, v, w) its positions, normals in the same space or none; its targets, if
// it had any, are gone. fails: KN_EDOMAIN no such part, KN_ENOMEM; the tile is then unchanged.
KN_API KN_CHECKED kn_status kn_tile_set_mesh(kn_ctx *ctx, kn_tile *tile, int part, const kn_mesh *mesh);

// Appends a parameter, which changes nothing yet. fails: KN_ELIMIT a name of KN_NAME_BYTES or more, KN_ENOMEM; the
// tile is then unchanged. What kn_tile_check says of parameters is not checked here.
KN_API KN_CHECKED kn_status kn_tile_add_parameter(kn_ctx *ctx, kn_tile *tile, const char *name, double value,
                                                  double target, double lo, double hi);
// Where a parameter, at its target, puts a spline of a part: a copy of `target`, which takes the place of one that is
// there. fails: KN_EDOMAIN no such parameter, part or spline, other degrees or knots; KN_ENOMEM; no change.
KN_API KN_CHECKED kn_status kn_tile_set_target(kn_ctx *ctx, kn_tile *tile, int parameter, int part, int spline,
                                               const kn_spline *target);
// The same for the vertices of the part's mesh, 3 numbers each. fails: KN_EDOMAIN no such parameter or part, no mesh
// in it; KN_ENOMEM; no change.
KN_API KN_CHECKED kn_status kn_tile_set_mesh_target(kn_ctx *ctx, kn_tile *tile, int parameter, int part,
                                                    const double *position);
// out = the tile with its parameters at these values (tile->nparameters of them, taken into their ranges), without
// parameters; normals of meshes are left out. Coordinates that a target leaves as they are stay bit for bit.
// out:   overwritten, not cleared; may not be tile.
// fails: KN_EDOMAIN a value that is not finite, and what kn_tile_check finds wrong with parameters; KN_ENOMEM; out
//        unchanged.
// error: gamma(4) |x| (|target| + |base|) for each parameter and coordinate, x as in kn_tile_parameter.
KN_API KN_CHECKED kn_status kn_tile_vary(kn_ctx *ctx, kn_tile *out, const kn_tile *tile, const double *values);

// out = a tile with one parameter, "morph": a at 0, b at 1, and what lies between on the straight way of each control
// point. Name, materials and aspect are a's; parameters of a and b stay at their values, and are gone.
// in:     as many parts, and in each as many splines of the same kinds, one after the other, not trimmed; a mesh in
// both
//         parts or in none, two of which kn_mesh_morph finds one connectivity.
// out:    overwritten, not cleared; may not be a or b. Splines over [0,1], their degrees and knots those of both.
// fails:  KN_EDOMAIN what differs (the message says where), and what kn_tile_check finds; as
// kn_spline_make_compatible
//         and kn_mesh_morph; out unchanged.
// error:  that of kn_spline_make_compatible: convex combinations.
KN_API KN_CHECKED kn_status kn_tile_morph(kn_ctx *ctx, kn_tile *out, const kn_tile *a, const kn_tile *b);

// KN_OK, or KN_EDOMAIN: the message names the part and the spline that is no polynomial (u,v,w) curve, surface or
// volume, not finite, without length, area or volume (all coefficients of P_r, P_r x P_s, det(P_r, P_s, P_t) within
// their rounding of zero), or a volume of which a Bezier piece is certainly left-handed; the trim that
// kn_trim_check refuses; the vertex or triangle of a mesh that is not finite, refers to no vertex or to one twice;
// the parameter without a name of its own, or with numbers that make no sense (value and target different, value in
// [lo, hi]), and the target that is not finite or does not belong to its spline; or an aspect that is negative or not
// finite, or nothing at all. Also what kn_spline_check finds, and KN_ENOMEM.
KN_API KN_CHECKED kn_status kn_tile_check(kn_ctx *ctx, const kn_tile *tile);
// What lies on a face of a volume: `by`, the volume of the tile in the cell at `cell` from its own.
typedef struct kn_tile_cover {
    bool covered;
    size_t by;
    int cell[2];
} kn_tile_cover;
// cover[6 i + 2 var + end] of the face where variable var of list[i] ends: the face of another volume, of the tile in
// the same cell or in another one, that has the same control points, to 1e-12 of the largest coordinate and of 1, in
// any of the eight ways to run through them. Faces that are left lie outside, if the volumes meet in whole
// faces. What is no volume of polynomial (u,v,w) is left out.
// in:    Bezier patches of a tile, w in any unit. out: 6 n entries. fails: KN_ENOMEM, KN_ECANCELLED; cover undefined.
// cost:  six faces sorted by their mean w, and a comparison of all pairs of equal mean.
KN_API KN_CHECKED kn_status kn_tile_cover_faces(kn_ctx *ctx, kn_tile_cover *cover, const kn_bezier *list, size_t n);

// Quarter turns of the (u,v) cell about its centre, counterclockwise, any number, of all that the tile has, its
// targets too: (u,v) -> (1-v, u), one rounding each. fails: KN_EDOMAIN a spline without polynomial values (u,v,w);
// the tile is then unchanged. Allocates nothing.
KN_API KN_CHECKED kn_status kn_tile_rotate(kn_ctx *ctx, kn_tile *tile, int quarter_turns);

// Makes a tile in coordinates of its own one over the unit cell: u and v of the rectangle u0, v0, u1, v1, u0 < u1, v0
// < v1, go from 0 to 1, w = height becomes 1, in all that the tile has, its targets too; aspect = height over the
// rectangle's mean side. Allocates nothing. fails: KN_EDOMAIN the cell, a height that is not positive, a spline
// without polynomial values (u,v,w); the tile is
//        then unchanged.
// error: two roundings a coordinate.
KN_API KN_CHECKED kn_status kn_tile_set_cell(kn_ctx *ctx, kn_tile *tile, const double cell[4], double height);

// ---- what can be proved of the tiling: the tile in every cell ----
// The cells are the unit squares of (u,v); a copy of the tile lies in each, moved by whole numbers in u and v.

enum { KN_TILE_LISTED = 16 };

// An edge of a tile. spline: of the part, -1: its mesh. piece: a Bezier piece of the spline in the order of
// kn_spline_to_bezier, or a triangle. Surfaces: edge 2 var + end lies where variable var ends (end 1) or begins (0).
// Volumes: face counts likewise, and edge is one of the face's, whose variables are the other two in their order; -1:
// all of it; face -1 for all else. Curves: edge is the end. Triangles: edge k runs from corner k to the next one.
typedef struct kn_tile_edge {
    int part, spline, piece, face, edge;
} kn_tile_edge;

// A place where an edge and its mate, moved by `offset` cells, do not join as they should.
typedef struct kn_tile_gap {
    kn_tile_edge edge, mate; // mate.part -1: nothing is near
    int offset[2];
    double at;       // parameter of the edge, in [0,1]
    double point[3]; // where that is
    // What is amiss there, estimated. Order -1: the distance to the mate's point of the same parameter. 0: the angle
    // of the normals, or of tangents of curves. 1: the difference of curvatures across.
    double amount;
} kn_tile_gap;

typedef struct kn_tile_periodicity_options {
    double tolerance; // two points within it are one; default 1e-12, <= 1e-6
    double angle;     // what vanishes for a smooth joint is <= angle times its factors' sizes; default 1e-9
    int max_order;    // the highest order that is looked at, 1 or 2; default 2
} kn_tile_periodicity_options;
KN_API kn_tile_periodicity_options kn_tile_periodicity_defaults(void);

// [0]: across lines u = integer, [1]: across lines v = integer, [2]: joints inside the tile.
typedef struct kn_tile_periodicity_report {
    // -1: an edge in such a line has no mate; 0: C0; 1: tangent planes agree; 2: curvatures too. Where nothing joins,
    // nothing is torn: the highest order that is looked at. [2]: of the joints that there are.
    int order[3];
    bool decided[3];      // false: the next order may hold, and could be neither proved nor refuted
    size_t joints[3];     // pairs of edges that are one; across a corner they count for both directions
    kn_tile_gap first[3]; // where order[] is below the highest and decided: the first place where the next one fails
    size_t open;          // edges without a mate: none where all parts are closed
    kn_tile_edge open_edges[KN_TILE_LISTED]; // the first of them
    size_t crowded;                          // edges with several mates; the one that goes on most smoothly counts
    size_t reversed;                         // joints of surfaces that face opposite ways
    size_t unchecked;                        // trimmed surfaces, whose edges are left out
} kn_tile_periodicity_report;

// Whether the tiling is continuous (definition 5 of the source), and to which order G^k, across each family of lines
// between cells and inside. Two edges are one when their control points, raised to one degree and moved by whole
// cells, agree within the tolerance, run alike or the other way. Edges are those of surfaces' Bezier pieces, of faces
// of volumes that no other face meets (kn_tile_cover_faces), of triangles, and the ends of curves; edges that are a
// point need no mate. An edge without a mate breaks continuity when it, or a curve's end, lies in a line between
// cells: the tile was cut there. Others are open edges of a tile that stands alone, or reaches over its neighbours.
// A joint is G1 when det(T, A, B) = 0 for all of the edge, T its tangent, A and B the derivatives across it, and A
// and B lie on one side of T; G2 when, moreover, the normal curvature along B is the same on both sides.
// in:     tile: as kn_tile_check wants it, at its parameters' values (targets are not looked at); tolerances > 0
//         or 0 for the default.
// out:    overwritten.
// fails:  KN_EDOMAIN the tile, the options; KN_ELIMIT more than 2^29 edges, or a great many in one place;
//         KN_ENOMEM, KN_ECANCELLED. report unchanged.
// error:  orders are certified: what is within the tolerance by its coefficients is so, rounding included, for every
//         parameter. Numbers of a kn_tile_gap are estimates.
// cost:   a hash of all edges, and for each joint products of degrees 3 n and 7 n, n those of the pieces.
// source: Elber, Geometric texture modeling, IEEE CG&A 25 (2005), definition 5; for G2: Pegna & Wolter, Geometrical
//         criteria to guarantee curvature continuity of blend surfaces, J. Mech. Design 114 (1992).
KN_API KN_CHECKED kn_status kn_tile_periodicity(kn_ctx *ctx, kn_tile_periodicity_report *report, const kn_tile *tile,
                                                const kn_tile_periodicity_options *options);

typedef struct kn_tile_rect {
    double lo[2], hi[2]; // of u and v
} kn_tile_rect;

typedef struct kn_tile_coverage_options {
    double tolerance; // edges within it are one, as in kn_tile_periodicity_options; cracks up to it do not count
    int depth;        // boxes of 2^-depth are divided no further, 1 .. 16; default 8
    size_t max_boxes; // boxes looked at, at most; default 2^17. The rest stays undecided
} kn_tile_coverage_options;
KN_API kn_tile_coverage_options kn_tile_coverage_defaults(void);

typedef struct kn_tile_coverage_report {
    kn_answer covers; // KN_YES: a covering map (definition 3 of the source). KN_NO: a casual one (4): there are gaps
    double covered, bare; // area of the cell that certainly is, certainly is not; they sum to 1 less the undecided
    kn_tile_rect *gaps;   // what is certainly bare: rectangles without common interior, by v and then u
    size_t ngaps;
    size_t boxes; // that were looked at; 0: the whole sheet counted at once
} kn_tile_coverage_report;
KN_API void kn_tile_coverage_clear(kn_ctx *ctx, kn_tile_coverage_report *report); // NULL is fine

// Whether the tiling, seen along w, covers the cell. Volumes count by their faces, meshes by their triangles, curves
// not at all, a trimmed surface not at all (it may be bare where it covers).
// in:     as kn_tile_periodicity.
// out:    overwritten, not cleared: kn_tile_coverage_clear.
// fails:  KN_EDOMAIN the tile, the options; KN_ELIMIT as kn_tile_periodicity, or pieces that reach over more
//         than 2^20 cells together; KN_ENOMEM, KN_ECANCELLED. out unchanged.
// error:  none in what is said to be covered (but for cracks within the tolerance) or bare, rounding included.
//         Undecided remain boxes along the outlines of gaps that are no lines u or v = k 2^-depth, and where only
//         patches that stand upright or meet in an outline cover.
// cost:   a sheet without open edges counts at once: its area with sign is a whole number, how often it covers. Else
//         boxes are quartered, and for each the parts of patches over it summed up: a box that the boundary of such a
//         sum does not meet is covered as often as that boundary winds round it.
KN_API KN_CHECKED kn_status kn_tile_coverage(kn_ctx *ctx, kn_tile_coverage_report *report, const kn_tile *tile,
                                             const kn_tile_coverage_options *options);

#ifdef __cplusplus
}
#endif
#endif
