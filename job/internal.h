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
    int bezier;              // counted over all parts
    int offset[2];
    bool inside;                             // u and v of all control points within [0,1]
    double top;                              // max |w|
    bool mirrored;                           // d runs the other way round than the tile's: outward is -(r x t)
    kn_bezier d;                             // of one to three variables
    kn_tile_cover cover[6];                  // of the faces of a volume; cell: how far the tile is that hides it
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
// powers of w), to which degree. A matrix belongs to a key.
typedef struct kn_job_key {
    int patch; // of job->patches, or of the cell's own (kn_job_leaf)
    kn_job_rect rect;
    uint8_t turn; // of it into the cell where it lies (kn_job_place)
    bool whole;   // over the whole cell; else over kn_job_box of the rect
    bool exact;
    uint8_t nterms;
    uint8_t degree[KN_SHELL_TERMS][2], power[KN_SHELL_TERMS];
    uint8_t composed[KN_JOB_VARS]; // degree
} kn_job_key;

// The edge that an edge of the base coincides with. Edges of surface s: 4s + 0 and 1 at the ends of u (they run along
// v), 4s + 2 and 3 at the ends of v.
typedef struct kn_job_partner {
    int edge;      // -1: none
    bool reversed; // they run in opposite directions
    bool single;   // no third edge coincides with them
    bool goes_on;  // so do cell lines and normals, and a tile goes on over it (kn_job_match_edges)
} kn_job_partner;

// Degrees of u, v and w of a Bezier patch of the tile, in each variable (kn_job_find_least).
typedef struct kn_job_least {
    int degree[3][KN_JOB_VARS];
} kn_job_least;

// A cell, perhaps of another surface than the tile's own, and the way into its coordinates: turn % 4 quarter turns,
// then, with KN_JOB_FLIP, (u, v, w) -> (u, 1 - v, -w): over an edge at which the normal turns over.
enum { KN_JOB_FLIP = 4 };
typedef struct kn_job_place {
    int surface, cell[2], turn;
} kn_job_place;

// A term of a piece: its degrees, and its power of w.
typedef struct kn_job_term {
    uint8_t degree[2], power;
} kn_job_term;

typedef struct kn_job_surface {
    int body;                   // kn_job_options.bodies
    int origin, origin_cell[2]; // kn_job_origin; no two surfaces of one origin have a cell number in common
    int part[2], parts[2];      // which part of the origin's grid of parts, which follow one another, u slowest
    int count[2];               // as kn_job_base
    kn_shell *shell;
    int cells[2];
    bool closed[2];
    double *lines[2]; // cells + 1 each, in S's parameters
    bool *knot[2];    // whether S is not one polynomial across line i; cells + 1 each
    kn_job_partner partner[4];
    double box[2][2];   // its lower and upper ends in the origin's domain, which [0,1]^2 stands for
    size_t first_cell;  // in the job's order
    int degree_sum;     // of n: what fits into max_degree
    bool borrows[4];    // along each edge, from the partner's surface (kn_job_borrow)
    int corner[4];      // 4 surface + corner, whose coefficients are borrowed; -1: none are
    size_t first_term;  // of job->terms: those of all surfaces whose edges are shared, which whole cells compose for
    int nterms;         // 0: their own alone
    bool meets;         // patches of its cells interpolate (kn_job_meet)
    int joint[4];       // where it does: of all corners of surfaces in one place the first, 4 surface + corner
    bool pole[4];       // and edges that are one point with one normal
    int tile_degree;    // the largest of the tile's patches
    double jacobian[2]; // bounds
} kn_job_surface;

// A set of keys in the order of their first appearance.
typedef struct kn_job_keys {
    kn_job_key *list;
    size_t *uses; // of each key, by cells that share a list
    size_t count, room;
    uint32_t *slot; // open addressing: 1 + index, 0 empty; nslots is a power of two
    size_t nslots;
} kn_job_keys;

// What a cell asks for, in an order that all cells with the same list share: keys, and the instances they belong to.
typedef struct kn_job_ref {
    uint32_t key, instance;
} kn_job_ref;
typedef struct kn_job_list {
    size_t first;
    uint32_t count;
    size_t numbers; // coefficients of all its patches, of one component
    size_t weights; // of all matrices that compose them
    size_t uses;    // cells
} kn_job_list;
// A set of lists: refs[first .. first + count - 1] each.
typedef struct kn_job_lists {
    kn_job_ref *refs;
    size_t nrefs, refs_room;
    kn_job_list *list;
    size_t count, room;
    uint32_t *slot;
    size_t nslots;
} kn_job_lists;

// Cells of one surface that follow one another, up to the first cell of the next entry, and share one list; or that
// have their own plans, which are made when they are asked for: then so many that a block holds them.
#define KN_JOB_OWN UINT32_MAX
typedef struct kn_job_alike {
    size_t first_cell;
    uint32_t list;            // KN_JOB_OWN: none
    size_t npatches, numbers; // of all these cells where they have their own plans
} kn_job_alike;

// The same tile placed otherwise (stagger, mirror): a range of job->patches.
typedef struct kn_job_variant {
    int first, count;
} kn_job_variant;

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
    kn_job_least *least; // of each Bezier patch of the tile; NULL: the patch's own degrees
    kn_job_surface *surfaces;
    int nsurfaces;
    kn_job_term *terms;             // of the surfaces
    struct kn_job_meeting *meeting; // NULL: no patches interpolate
    double meeting_height;          // of the tile, in the largest thickness: what their errors are relative to
    struct kn_job_borders *borders; // of trims; NULL: nothing is trimmed
    struct kn_job_varying *varying; // NULL: tiles are the same everywhere
    struct kn_job_looks *looks;     // colours by fields; NULL: none
    kn_job_variant *variants;       // [0]: as modelled
    int nvariants;
    size_t ncells;
    // The plan. Memory does not depend on the number of cells: the lists and keys that cells share are limited, and
    // what does not fit is planned again when it is composed (KN_JOB_OWN).
    kn_job_keys keys;
    kn_job_lists lists;
    kn_job_alike *alike; // nalike + 1 of them: the last one begins at ncells
    size_t nalike;
    struct kn_job_tiling *tiling; // shift, stagger, mirror, angle; NULL: none
    kn_job_dart *darts;           // by cell; NULL: none are scattered
    size_t ndarts;
    uint64_t *there; // a bit for each cell that is; NULL: all are
    uint8_t *detail; // of each cell: how often its segments are halved (kn_job_view); NULL: never
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
    int origin, body, part[2], parts[2];
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

// ---- borrow.c ----
// What n of a surface has to be so that along edges over which surfaces go on all n have one degree and are as smooth.
typedef struct kn_job_evened {
    int least[2];  // degree
    bool apart[2]; // across cell lines: kn_shell_options
    bool again;    // it is not so, and was not yet asked for
} kn_job_evened;
// of: for each surface, zero before the first call; *again: some of them have to be made again.
kn_status kn_job_even_degrees(kn_ctx *ctx, kn_job_evened *of, bool *again, const kn_job *job);
// Who borrows from whom, and the terms that families of surfaces have in common.
kn_status kn_job_share_edges(kn_ctx *ctx, kn_job *job);
// The coefficients of a whole cell's piece along edges of the surface that others lend, and at its corners. Of pieces
// without coefficients, and stand-ins, nothing changes.
kn_status kn_job_borrow(kn_ctx *ctx, const kn_job *job, int surface, const int cell[2], kn_shell_piece *piece);
bool kn_job_borrows(const kn_job *job, int surface, const int cell[2]);
// meets, joint and pole of all surfaces.
kn_status kn_job_find_meeting(kn_ctx *ctx, kn_job *job);
// Whether a surface's patches meet those of another one over an edge, where these surfaces do.
bool kn_job_meets(const kn_job *job, int surface, int edge);

// ---- least.c ----
// job->least, so that patches which share an edge have one degree along it.
kn_status kn_job_find_least(kn_ctx *ctx, kn_job *job);
// Those in which a patch is composed over a whole cell; over less of one, its own.
void kn_job_least_degrees(int least[3][KN_JOB_VARS], const kn_job *job, const kn_job_patch *patch, bool whole);
// Raises `degree` to that of a term composed with components of these degrees.
void kn_job_raise(int degree[KN_JOB_VARS], const int least[3][KN_JOB_VARS], const int term[2], int power);

// ---- edges.c ----
// partners: 4 for each surface, of the same body.
kn_status kn_job_find_partners(kn_ctx *ctx, kn_job_partner *partners, const kn_spline *surfaces, const int *bodies,
                               int nsurfaces, double tol);
// partner[].goes_on of all surfaces, whose shells and lines are there, for the heights w that the tile occupies.
// Beyond a crease the tile would be torn.
kn_status kn_job_match_edges(kn_ctx *ctx, kn_job *job, const double w[2]);
// Whether the normal turns over where a tile goes on over the edge.
bool kn_job_turns_over(int edge, const kn_job_partner *partner);
// Where the cell at `offset` from a cell of the surface lies: on the surface beyond an edge that the two share with
// agreeing (or opposite) normals and cell lines; otherwise on its own surface, where closed directions wrap, and open
// ends too where the placement says cyclic; other open ends extend.
kn_job_place kn_job_find_place(const kn_job *job, int surface, const int cell[2], const int offset[2]);
// Whether it lies beyond an end at which tiles are cut off (KN_BORDER_CLIP).
bool kn_job_is_clipped(const kn_job *job, int surface, const int cell[2], const int offset[2]);
// Those ends in the coordinates of the place's cell: end[variable][0] below it and [1] above, infinite where there is
// none.
void kn_job_clip_ends(double end[2][2], const kn_job *job, const kn_job_place *place);
// Where the box [lo,hi] of (u,v) lies, to 1e-9 of a cell; what is flat along an end is inside.
typedef enum kn_job_clipped { KN_CLIP_INSIDE, KN_CLIP_ACROSS, KN_CLIP_OUTSIDE } kn_job_clipped;
kn_job_clipped kn_job_clip_box(const double lo[2], const double hi[2], const double end[2][2]);

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
    const double *cuts[2]; // more lines at which patches are cut, in [0,1): of u and of v, in every cell
    int ncuts[2];
} kn_job_change;
// Appends the patches of a tile, placed by the options' height, offset and side, changed by `change` (NULL: not) and
// cut at cell lines. On failure the list is as it was.
kn_status kn_job_cut_patches(kn_ctx *ctx, kn_job_patches *out, const kn_tile *tile, const kn_job_options *options,
                             const kn_job_change *change);
void kn_job_patches_clear(kn_ctx *ctx, kn_job_patches *patches);
int kn_job_bezier_patches(const kn_spline *spline);
// Where w of the tile lies: [0,1] spans the height.
double kn_job_place_w(const kn_job_options *options, double w);
// The largest degree of job->tile's splines, and so of all patches.
int kn_job_tile_degree(const kn_job *job);

// ---- faces.c ----
// cover of the volumes among patches->list[first ..], which are those of one tile.
kn_status kn_job_cover_faces(kn_ctx *ctx, kn_job_patches *patches, int first);
// kn_patch.hidden of a part of a volume in a cell.
kn_status kn_job_hide_faces(kn_ctx *ctx, uint8_t *hidden, const kn_job *job, const kn_job_patch *patch,
                            const kn_job_rect *rect, int surface, const int cell[2]);

// ---- rect.c ----
// The part of a patch that rect names, after the turn of a place (kn_job_place).
kn_status kn_job_restrict(kn_ctx *ctx, kn_bezier *out, const kn_job_patch *patch, kn_job_rect rect, int turn);
// n points (u, v, w), component by component, `step` numbers from one component to the next.
void kn_job_turn(double *u, size_t step, size_t n, int turn);
// A box with dyadic sides around (u, v) of d, hardly larger than it must be.
void kn_job_box(double lo[2], double hi[2], const kn_bezier *d);
// The patch of a key in the coordinates of its box, [0,1]^2.
kn_status kn_job_in_box(kn_ctx *ctx, kn_bezier *out, double lo[2], double hi[2], const kn_job_patch *patch,
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
    bool outline; // kn_shell_piece_outline will do
    kn_job_piece *list;
    int count, room;
} kn_job_pieces;
kn_status kn_job_pieces_get(kn_ctx *ctx, int *index, kn_job_pieces *pieces, const kn_job_place *place,
                            const double lo[2], const double hi[2]);
void kn_job_pieces_clear(kn_ctx *ctx, kn_job_pieces *pieces); // empty, room kept
void kn_job_pieces_end(kn_ctx *ctx, kn_job_pieces *pieces);

// ---- leaves.c ----
// One patch, or part of one, that a cell composes.
typedef struct kn_job_leaf {
    kn_job_key key;
    int instance;    // of the cell
    bool own;        // key.patch is one of plan->own, else of job->patches
    int piece;       // of plan->pieces: D is composed with it in its own cell and box (kn_job_leaf_source). -1: none
    int shift[2];    // the piece's cell less the cell where D lies (kn_job_cross)
    bool alone;      // the piece's box is not that of the key: no matrix serves it
    int part, patch; // of a mesh: kn_patch_id
    // Filled by kn_job_cross and by kn_job_map_meshes; they belong to the leaf.
    kn_trim trim;   // what there is of it, in the [0,1]^2 of its rect; empty: all
    kn_bezier made; // not empty: the output patch itself, approximated: nothing is composed
    kn_mesh mesh;   // not empty: a mapped part of a mesh, and no patch
} kn_job_leaf;

// What one cell composes, and with what.
typedef struct kn_job_cell_plan {
    const kn_job *job;
    int surface, cell[2];
    bool there; // kn_job_has_cell
    kn_job_leaf *leaves;
    int count, room;
    int asked;                    // patches of tiles, up to now
    kn_job_patches own;           // patches of instances that are not plain
    kn_job_pieces pieces;         // what the leaves are composed with
    bool shared;                  // all leaves are of job->patches and without trims, meshes and shifts
    kn_normal_certificate normal; // the worst of the pieces in use
    double stand_in;
    double crossing; // kn_job_report.crossing_error
    size_t trim_curves, trim_spans;
} kn_job_cell_plan;
// Appends a leaf, which takes what belongs to *leaf: that is then empty. Sets key's terms from the piece.
kn_status kn_job_add_leaf(kn_ctx *ctx, kn_job_cell_plan *plan, kn_job_leaf *leaf);
void kn_job_cell_plan_clear(kn_ctx *ctx, kn_job_cell_plan *plan);
const kn_job_patch *kn_job_leaf_patch(const kn_job_cell_plan *plan, const kn_job_leaf *leaf);
void kn_job_leaf_degree(const kn_job_leaf *leaf, int degree[KN_JOB_VARS]);
// D of a leaf in the coordinates of its piece's box, [0,1]^2, in which the piece is a function.
kn_status kn_job_leaf_source(kn_ctx *ctx, kn_bezier *out, const kn_job_cell_plan *plan, const kn_job_leaf *leaf);

// ---- meet_degrees.c ----
// job->meeting: the degrees of patches that interpolate.
kn_status kn_job_find_meeting_degrees(kn_ctx *ctx, kn_job *job);
void kn_job_meeting_free(kn_ctx *ctx, kn_job *job);
// Whether patches in the cell there interpolate, if they can: it is one of the surface's own.
bool kn_job_may_meet(const kn_job_cell_plan *plan, const kn_job_place *place);
// While cells are planned to find them: then each patch is noted, and nothing is planned.
bool kn_job_notes_meeting(const kn_job *job);
kn_status kn_job_note_meeting(kn_ctx *ctx, const kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                              const kn_job_place *place, bool can);
// Of the patch of this number (kn_job_cell_plan.asked) in the plan of its cell.
void kn_job_meeting_degree(int degree[2], const kn_job_cell_plan *plan, int number);
// What the plan found, for the run, which need not look again.
typedef enum kn_job_meeting_fate { KN_JOB_UNKNOWN, KN_JOB_MEETS, KN_JOB_STAYS } kn_job_meeting_fate;
kn_job_meeting_fate kn_job_fate_of(const kn_job_cell_plan *plan, int number);
void kn_job_set_fate(const kn_job_cell_plan *plan, int number, kn_job_meeting_fate fate);

// ---- meet.c ----
// *out = job->meeting_height, by the thickness at corners of cells that interpolate.
kn_status kn_job_meeting_scale(kn_ctx *ctx, double *out, const kn_job *job);
// at: T(d) with N/|N| at Chebyshev-Lobatto sites of these degrees, component by component, along t fastest. Leaves
// scratch memory. fails: KN_EUNDEFINED no normal; KN_ENOMEM.
kn_status kn_job_sample(kn_ctx *ctx, double *at, const kn_job *job, const kn_job_place *place, const kn_bezier *d,
                        const int degree[2]);
// Appends one leaf that interpolates T(D), of the patch of this number, in the cell at `place`; *met: it is near
// enough, else there is none.
kn_status kn_job_meet(kn_ctx *ctx, bool *met, kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                      const kn_job_place *place, int number);

// ---- plan_cell.c ----
typedef struct kn_job_instance kn_job_instance;
// Appends the patches of an instance that is not plain: varied, placed and cut.
kn_status kn_job_cut_own(kn_ctx *ctx, kn_job_patches *out, const kn_job *job, int surface, const int cell[2],
                         const kn_job_instance *instance);
// *plan, zero-initialised, = what the cell numbered `index` composes: the same answer whenever it is asked.
// outline: to count it; pieces may come without coefficients then (kn_job_cross and kn_job_map_meshes get them
// whole).
kn_status kn_job_plan_cell(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job *job, size_t index, bool outline);

// ---- job.c ----
// The cell, in the job's order, and the leaf of its plan that id names; false and NULL: there is none.
bool kn_job_find_cell(size_t *index, const kn_job *job, const kn_patch_id *id);
const kn_job_leaf *kn_job_find_leaf(const kn_job_cell_plan *plan, const kn_patch_id *id);

// ---- plan.c ----
// job->keys, lists, alike and what the report says of them; patches and surfaces are there.
kn_status kn_job_plan(kn_ctx *ctx, kn_job *job);
// The entry of job->alike that has the cell.
size_t kn_job_find_alike(const kn_job *job, size_t cell);

// ---- keys.c ----
kn_status kn_job_keys_add(kn_ctx *ctx, uint32_t *index, kn_job_keys *keys, const kn_job_key *key);
bool kn_job_same_key(const kn_job_key *a, const kn_job_key *b);
// Whether the set has the key; *index where it is.
bool kn_job_keys_find(uint32_t *index, const kn_job_keys *keys, const kn_job_key *key);
// ---- lists.c ----
kn_status kn_job_lists_add(kn_ctx *ctx, uint32_t *index, kn_job_lists *lists, const kn_job_ref *refs, size_t n);

// ---- blocks.c ----
// Cells of one surface that are composed together: as many as make half a MiB to 2 MiB of coefficients, or one.
typedef struct kn_job_block {
    size_t first_cell, ncells, first_patch, npatches, numbers;
} kn_job_block;
// A place in the sequence of blocks, which is made as it is asked for; zero: the beginning.
typedef struct kn_job_cursor {
    size_t alike, cell, patch;
    size_t end; // before which cell the sequence ends, unless cells with plans of their own go on; 0: it does not
} kn_job_cursor;
// The sequence of blocks of a range of cells, and of those with plans of their own that are kept with them.
kn_job_cursor kn_job_cursor_at(const kn_job *job, size_t first_cell, size_t ncells);
bool kn_job_next_block(kn_job_block *out, kn_job_cursor *at, const kn_job *job); // false: there is none

// ======== what others decide of a cell: hooks of the plan ========

// ---- select.c ----
// Each has a step before the first cell, for tables that all cells need (job->surfaces, patches and shells are
// there), and one that frees them; any thread calls what lies between.
kn_status kn_job_select_init(kn_ctx *ctx, kn_job *job);
void kn_job_select_clear(kn_ctx *ctx, kn_job *job);
// Whether a surface of the base is among those that are selected.
bool kn_job_selects(const kn_job_selection *o, int origin);
kn_status kn_job_has_cell(kn_ctx *ctx, bool *has, const kn_job *job, int surface, const int cell[2]);

// ---- instances.c ----
// A tile of a cell. Plain: the patches of a variant, as other cells have them. Otherwise its own: cut anew.
typedef struct kn_job_instance {
    int id; // kn_patch_id.instance
    bool plain;
    int variant;      // plain: of job->variants
    double map[3][4]; // where (u, v, w, 1) of the placed tile goes, w in length units; linear part regular
} kn_job_instance;
typedef struct kn_job_instance_list {
    kn_job_instance *list;
    int count, room;
} kn_job_instance_list;
kn_status kn_job_instances_init(kn_ctx *ctx, kn_job *job);
// Where patches are cut so that those of staggered rows have their corners in the same places.
void kn_job_take_cuts(kn_job_change *change, const kn_job *job);
void kn_job_instances_clear(kn_ctx *ctx, kn_job *job);
// The tiles of a cell, appended to an empty list.
kn_status kn_job_instances(kn_ctx *ctx, kn_job_instance_list *out, const kn_job *job, int surface, const int cell[2]);
kn_status kn_job_add_instance(kn_ctx *ctx, kn_job_instance_list *list, const kn_job_instance *instance);

// ---- vary.c ----
kn_status kn_job_vary_init(kn_ctx *ctx, kn_job *job);
void kn_job_vary_clear(kn_ctx *ctx, kn_job *job);
// Changes an instance by chance, or makes it one of its own (plain = false, map set) because
// kn_job_vary_patch has something to change in it.
kn_status kn_job_vary_instance(kn_ctx *ctx, kn_job_instance *instance, const kn_job *job, int surface,
                               const int cell[2]);
// Changes the control points of one Bezier patch of the tile, w in length units, before instance->map and before it
// is cut at cell lines. Asked for every patch of instances that are not plain.
kn_status kn_job_vary_patch(kn_ctx *ctx, kn_bezier *d, const kn_job *job, int surface, const int cell[2],
                            const kn_job_instance *instance, int part, int spline, int patch);

// ---- cross.c ----
// A part of a patch that crosses knot lines of S, however it is cut: *crossed = true with leaves appended (pieces by
// kn_job_pieces_get, kn_job_add_leaf), or false, and it is bisected further and then refused. leaf: as far as it is
// known, key.patch, key.rect, own and instance; d: its (u, v, w) in the cell at `place`.
kn_status kn_job_cross(kn_ctx *ctx, bool *crossed, kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                       const kn_job_place *place, const kn_bezier *d);

// ---- leaf_trim.c ----
// Whether the tile's surface is trimmed of which the leaf is a part; and what that leaves, in the [0,1]^2 of its
// rect.
bool kn_job_is_trimmed(const kn_job_cell_plan *plan, const kn_job_leaf *leaf);
kn_status kn_job_leaf_trim(kn_ctx *ctx, kn_trim *out, bool *any, const kn_job_cell_plan *plan,
                           const kn_job_leaf *leaf);

// ---- cross_boxes.c ----
// Whether S has a knot at a cell line inside its domain, or is closed there: `line` counts from the cell. Where
// patches may cross, so do lines count between cells of different widths, at which (u,v) in cells is bent.
bool kn_job_is_knot(const kn_job *job, const kn_job_surface *s, const int cell[2], int var, double line);

// ---- variants.c ----
// Appends the patches of the tile placed by an affine map, as kn_job_instance has it, to job->patches.
kn_status kn_job_add_variant(kn_ctx *ctx, int *variant, kn_job *job, const double map[3][4]);
void kn_job_map_patch(kn_bezier *d, const double map[3][4]); // in place
bool kn_job_map_mirrors(const double map[3][4]);

// ---- meshes.c ----
// Appends leaves for the mesh parts of one tile of a cell.
kn_status kn_job_map_meshes(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job_instance *instance);

// ---- clip_mesh.c ----
// Cuts off what of a mesh's (u,v) lies beyond the ends (kn_job_clip_ends), in place.
kn_status kn_job_clip_mesh(kn_ctx *ctx, kn_mesh *mesh, const double end[2][2]);
// Those triangles alone, and their vertices, in their order. On failure the mesh is as it was.
kn_status kn_job_keep_triangles(kn_ctx *ctx, kn_mesh *mesh, const bool *keep);

// ---- facts.c ----
// Surface and cell of the cell numbered `index` in the job's order.
void kn_job_locate(const kn_job *job, size_t index, int *surface, int cell[2]);
// The degree of the output patch of a key; coefficients of one component; what tessellations cut it into.
void kn_job_degree(const kn_job_key *key, int degree[KN_JOB_VARS]);
size_t kn_job_numbers(const int degree[KN_JOB_VARS]);
size_t kn_job_columns(const kn_job_key *key); // of its matrix: coefficients of one component of its piece
void kn_job_segments(const kn_job *job, const kn_job_key *key, int segments[KN_JOB_VARS]);
// Fewer of them, as far away as a cell is from the camera.
void kn_job_coarsen(const kn_job *job, size_t cell, int segments[KN_JOB_VARS]);
size_t kn_job_triangles(int nvars, const int segments[KN_JOB_VARS], uint8_t hidden);
size_t kn_job_components(const kn_job_surface *s); // of its patches: 3, or 4 homogeneous ones

#endif
