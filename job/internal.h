// SPDX-License-Identifier: Apache-2.0
// Inside job: what a job knows once it is planned, and the steps that find it out.
#ifndef JOB_INTERNAL_H
#define JOB_INTERNAL_H

#include "kernel/context.h"

#include <knurl/job.h>

enum {
    KN_JOB_MAX_COUNT = 1 << 16, // cells of one surface in one direction
    KN_JOB_VARS = 3,            // most variables of a tile patch: curves, surfaces, volumes
    KN_JOB_MAX_DEPTH = 10,      // bisections of a tile patch in each variable
    KN_JOB_MAX_SEGMENTS = 64,
    KN_JOB_MAX_REACH = 256, // cells that a tile reaches beyond its own, each way
};
#define KN_JOB_MAX_CELLS ((size_t)1 << 27) // all together

// One Bezier patch of the placed tile, or what is left of it between the cell lines that cut it. d has (u, v, w), w
// in length units, in the coordinates of the cell at `offset` from the tile's own.
typedef struct kn_job_patch {
    int part, spline, patch; // patch: Bezier patch of the part, counted over its splines
    int offset[2];
    bool inside; // u and v of all control points within [0,1]
    double top;  // max |w|
    kn_bezier d; // of one to three variables
    double lo[KN_JOB_VARS], hi[KN_JOB_VARS]; // where in the Bezier patch's [0,1]^n it lies
} kn_job_patch;
typedef struct kn_job_patches {
    kn_job_patch *list;
    int n, room;
} kn_job_patches;

// A dyadic part of a patch: [index, index + 1] / 2^level in each variable; 0 in those that it has not.
typedef struct kn_job_rect {
    uint8_t level[KN_JOB_VARS];
    uint16_t index[KN_JOB_VARS];
} kn_job_rect;

// One way to compose: which part of the tile, over which box of its cell, with which terms of the piece (degrees and
// powers of w), to which degree. A leaf of the plan is the number of its key, and a matrix belongs to a
// key.
typedef struct kn_job_key {
    int patch; // of job->patches
    kn_job_rect rect;
    uint8_t turn; // quarter turns of it into the cell where it lies (kn_job_place)
    bool whole;   // over the whole cell; else over kn_job_box of the rect
    bool exact;
    uint8_t nterms;
    uint8_t degree[KN_SHELL_TERMS][2], power[KN_SHELL_TERMS];
    uint8_t factor; // composed degree / the tile patch's degree: the largest sum of a term's degrees and power
} kn_job_key;

// The edge that an edge of the base coincides with. Edges of surface s: 4s + 0 and 1 at the ends of u (they run along
// v), 4s + 2 and 3 at the ends of v.
typedef struct kn_job_partner {
    int edge;      // -1: none
    bool reversed; // they run in opposite directions
    bool single;   // no third edge coincides with them
    bool goes_on;  // so do cell lines and normals, and a tile goes on over it (kn_job_match_edges)
} kn_job_partner;

// A cell, perhaps of another surface than the tile's own, and the quarter turns into its coordinates.
typedef struct kn_job_place {
    int surface, cell[2], turn;
} kn_job_place;

typedef struct kn_job_surface {
    int origin, origin_cell[2]; // kn_job_origin; no two surfaces of one origin have a cell number in common
    int part[2], parts[2];      // which part of the origin's grid of parts, which follow one another, u slowest
    int count[2];               // as kn_job_base
    kn_shell *shell;
    int cells[2];
    bool closed[2];
    double *lines[2]; // cells + 1 each, in S's parameters
    bool *knot[2];    // whether S is not one polynomial across line i; cells + 1 each
    kn_job_partner partner[4];
    size_t first_cell;  // in the job's order
    int degree_sum;     // of n: what fits into max_degree
    int tile_degree;    // the largest of the tile's patches
    double jacobian[2]; // bounds
} kn_job_surface;

// The leaves of a cell: job->leaves[first .. first + count - 1].
typedef struct kn_job_cell {
    size_t first;
    uint32_t count;
} kn_job_cell;

// The centre of a scattered tile, in the coordinates of the cell in which it lies.
typedef struct kn_job_dart {
    size_t cell; // in the job's order
    double at[2];
} kn_job_dart;

struct kn_job {
    kn_job_options options; // defaults resolved
    kn_tile tile;           // rotated
    kn_job_report report;
    double diagonal, w_length; // of the base; of w = 1, about
    bool has_fields;           // of T: thickness, direction, attraction, or the stretch
    int segments;
    kn_job_patch *patches;
    int npatches;
    kn_job_surface *surfaces;
    int nsurfaces;
    kn_job_key *keys;
    size_t *uses; // of each key
    size_t nkeys;
    uint32_t *leaves;
    size_t nleaves;
    kn_job_cell *cells;
    size_t ncells;
    kn_job_dart *darts; // by cell; NULL: one tile in each
    size_t ndarts;
};

// ---- measure.c ----
// Isoparametric curves of a surface: means of length over both edges and the middle, and the chord height of one span
// of the whole domain (cells divide it by their count squared). [0] runs along u.
typedef struct kn_job_measure {
    double length[2][3]; // at the lower edge, the middle, the upper edge
    double bend[2];
} kn_job_measure;
kn_status kn_job_measure_surface(kn_ctx *ctx, kn_job_measure *out, const kn_spline *surface);
// The distance of p from the line through a and b.
double kn_job_off_chord(const double *p, const double *a, const double *b);
double kn_job_mean_length(const kn_job_measure *m, int along);

// ---- split.c ----
// A part of a base: the whole of it, or what lies between its creases. Splines that are empty are not there.
typedef struct kn_job_base {
    int origin, part[2], parts[2];
    int count[2];                               // of cells, where rows ask for them; 0: by the options
    kn_spline volume;                           // over [0,1] in w
    kn_spline thickness, direction, attraction; // over the part's domain; their knots are knots of its face
} kn_job_base;
// faces: S of each part, in its own parameters; of a volume its middle layer, by which cells are measured.
typedef struct kn_job_bases {
    kn_job_base *list;
    kn_spline *faces;
    int n, room;
} kn_job_bases;
void kn_job_bases_clear(kn_ctx *ctx, kn_job_bases *bases);
// Whether these can be bases, and the options' fields belong to them.
kn_status kn_job_check_bases(kn_ctx *ctx, const kn_spline *surfaces, int nsurfaces, const kn_job_options *options);
// The parts of all bases; job->surfaces, with their origins, w_length, and the height of a volume.
kn_status kn_job_split(kn_ctx *ctx, kn_job_bases *bases, kn_job *job, const kn_spline *surfaces, int nsurfaces);
// counts[..][along] of all parts of the origin whose first part is `first`: `count` cells shared among them, even in
// parameter, or in length where the spacing says so, and at least one for each knot span.
kn_status kn_job_share_count(kn_ctx *ctx, int (*counts)[2], const kn_job *job, int first, int along, int count,
                             const kn_spline *faces, const kn_job_measure *measures);
// origin_cell of all surfaces, whose cells are there.
void kn_job_number_cells(kn_job *job);

// ---- rows.c ----
// Replaces each part by bands of rows (kn_cells_shared_bands), the same ones for parts side by side.
kn_status kn_job_cut_rows(kn_ctx *ctx, kn_job_bases *bases, const kn_job *job);

// ---- sizes.c ----
// Of the box of all surfaces.
kn_status kn_job_diagonal(kn_ctx *ctx, double *out, const kn_spline *surfaces, int nsurfaces);
// o->size where it is not given.
void kn_job_resolve_size(kn_job_options *o, double diagonal);
// job->surfaces' counts, lines and partners, height, mesh_tol, patches and segments, from the options; the bases'
// faces where corners are free, and their thickness where heights follow the stretch.
kn_status kn_job_decide_sizes(kn_ctx *ctx, kn_job *job, kn_job_bases *bases);

// ---- free.c ----
// Replaces the faces by S(map), and the lines, which are even ones, by integers; report.cells_error and even_instead.
// cell: its mean side.
kn_status kn_job_free_corners(kn_ctx *ctx, kn_job *job, kn_job_bases *bases, double cell);

// ---- fields.c ----
// Of a polynomial field of two variables: how far coefficients differ along variable v.
double kn_job_field_variation(const kn_spline *f, int v);
// Makes it one that does not depend on v, of degree 0 there, in the middle of the coefficients.
kn_status kn_job_lower_field(kn_ctx *ctx, kn_spline *f, int v);

// ---- stretch.c ----
// Multiplies the parts' thickness by the stretch of their cells, whose lines and spread are there;
// report.stretch_error.
kn_status kn_job_stretch(kn_ctx *ctx, kn_job *job, kn_job_bases *bases);

// ---- shells.c ----
// job->surfaces' shells and bounds of the Jacobian.
kn_status kn_job_make_shells(kn_ctx *ctx, kn_job *job, const kn_job_bases *bases);

// ---- edges.c ----
// partners: 4 for each surface.
kn_status kn_job_find_partners(kn_ctx *ctx, kn_job_partner *partners, const kn_spline *surfaces, int nsurfaces,
                               double tol);
// partner[].goes_on of all surfaces, whose shells and lines are there, for the heights w that the tile occupies.
// Beyond a crease the tile would be torn.
kn_status kn_job_match_edges(kn_ctx *ctx, kn_job *job, const double w[2]);
// Where the cell at `offset` from a cell of the surface lies: on the surface beyond an edge that the two share with
// agreeing normals and cell lines; otherwise on its own surface, where closed directions wrap and open ends extend.
kn_job_place kn_job_find_place(const kn_job *job, int surface, const int cell[2], const int offset[2]);

// ---- counts.c ----
// The class of each direction of each surface (2 surface + variable): lines that meet on shared edges.
typedef struct kn_job_class {
    int id;
    bool reversed; // against the class's own direction
    bool mirrored; // the class meets itself backwards, as on a Moebius strip
} kn_job_class;
kn_status kn_job_find_classes(kn_ctx *ctx, kn_job_class *classes, const kn_job_partner *partners, int nsurfaces);
// counts[s] = cells of surface s in u and in v, as options ask. size: in force when options->count is 0.
kn_status kn_job_counts(kn_ctx *ctx, int (*counts)[2], const kn_job *job, const kn_spline *surfaces,
                        const kn_job_measure *measures, const kn_job_class *classes);

// ---- lines.c ----
// Whether lines of variable `along` are to be at equal steps of length.
bool kn_job_is_even(const kn_job *job, int along);
// job->surfaces' lines and knot flags, from their counts of cells: the options' spacing, even lines for each class.
kn_status kn_job_make_lines(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces, const kn_job_class *classes);
// job->report.spread, of the lines that are there.
kn_status kn_job_measure_spread(kn_ctx *ctx, kn_job *job, const kn_spline *surfaces);

// ---- patches.c ----
// job->patches from job->tile and the options' height and offset.
kn_status kn_job_make_patches(kn_ctx *ctx, kn_job *job);
// Changes one Bezier patch (w in length units) of a tile before it is cut at cell lines.
typedef struct kn_job_change {
    void *user;
    kn_status (*apply)(kn_ctx *ctx, void *user, kn_bezier *d, const kn_tile *tile, int part, int spline, int patch);
} kn_job_change;
// Appends the patches of a tile, placed by the options' height, offset and side, changed by `change` (NULL: not) and
// cut at cell lines. On failure the list is as it was.
kn_status kn_job_cut_patches(kn_ctx *ctx, kn_job_patches *out, const kn_tile *tile, const kn_job_options *options,
                             const kn_job_change *change);
void kn_job_patches_clear(kn_ctx *ctx, kn_job_patches *patches);
// The largest degree of job->tile's splines, and so of all patches.
int kn_job_tile_degree(const kn_job *job);

// ---- rect.c ----
// The part of a patch that rect names, after `turn` quarter turns about the centre of its cell.
kn_status kn_job_restrict(kn_ctx *ctx, kn_bezier *out, const kn_job_patch *patch, kn_job_rect rect, int turn);
// A box with dyadic sides around (u, v) of d, hardly larger than it must be.
void kn_job_box(double lo[2], double hi[2], const kn_bezier *d);
// The patch of a key in the coordinates of its box, [0,1]^2.
kn_status kn_job_in_box(kn_ctx *ctx, kn_bezier *out, double lo[2], double hi[2], const kn_job *job,
                        const kn_job_key *key);

// ---- pieces.c ----
// The pieces of shells that one cell asks for: each is made once.
typedef struct kn_job_piece {
    int surface, cell[2];
    double lo[2], hi[2];
    bool fits;
    kn_shell_piece piece;
} kn_job_piece;
typedef struct kn_job_pieces {
    const kn_job *job;
    kn_job_piece *list;
    int count, room;
} kn_job_pieces;
kn_status kn_job_pieces_get(kn_ctx *ctx, int *index, kn_job_pieces *pieces, const kn_job_place *place,
                            const double lo[2], const double hi[2]);
void kn_job_pieces_clear(kn_ctx *ctx, kn_job_pieces *pieces); // empty, room kept
void kn_job_pieces_end(kn_ctx *ctx, kn_job_pieces *pieces);

// ---- plan.c ----
// job->keys, leaves, cells and what the report says of them; patches and surfaces are there.
kn_status kn_job_plan(kn_ctx *ctx, kn_job *job);

// ---- keys.c ----
// A set of keys in the order of their first appearance.
typedef struct kn_job_keys {
    kn_job_key *list;
    size_t *uses;
    size_t count, room;
    uint32_t *slot; // open addressing: 1 + index, 0 empty; nslots is a power of two
    size_t nslots;
} kn_job_keys;
kn_status kn_job_keys_add(kn_ctx *ctx, uint32_t *index, kn_job_keys *keys, const kn_job_key *key);

// Surface and cell of the cell numbered `index` in the job's order.
void kn_job_locate(const kn_job *job, size_t index, int *surface, int cell[2]);
// The degree of the output patch of a key.
void kn_job_degree(const kn_job *job, const kn_job_key *key, int degree[KN_JOB_VARS]);
void kn_job_segments(const kn_job *job, const kn_job_key *key, int segments[KN_JOB_VARS]);

#endif
