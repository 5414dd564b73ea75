// SPDX-License-Identifier: Apache-2.0
// Jobs: a tile over the cells of a base, streamed as patches into sinks.
#ifndef KNURL_JOB_H
#define KNURL_JOB_H

#include <knurl/cells.h>
#include <knurl/compose.h>
#include <knurl/field.h>
#include <knurl/shell.h>
#include <knurl/tile.h>
#include <knurl/trim.h>

#ifdef __cplusplus
extern "C" {
#endif

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

// How tiles go on beyond the ends of a surface that is not closed (the vocabulary of other tools: extend, clip,
// cyclic).
typedef enum kn_job_border {
    KN_BORDER_EXTEND, // what reaches beyond stays, over the surface extended as a polynomial
    KN_BORDER_CLIP,   // what reaches beyond is cut off: along a parameter line, or trimmed within crossing_tol
    KN_BORDER_CYCLIC, // what reaches beyond comes in at the other end
} kn_job_border;

// What becomes of a tile patch that crosses a knot line of S otherwise than along a parameter line of its own.
typedef enum kn_job_crossing {
    KN_CROSSING_REFUSE,      // KN_EDOMAIN
    KN_CROSSING_TRIM,        // exactly composed pieces, trimmed along the preimage of the line to within crossing_tol
    KN_CROSSING_APPROXIMATE, // one untrimmed patch, within crossing_tol of T(D), certified
} kn_job_crossing;

// What becomes of tiles that cross the border of a trimmed surface (kn_job_options.trims). Cells that certainly lie
// beyond it, with all that their tiles occupy, are not there: KN_DROP_TRIM.
typedef enum kn_job_trimmed {
    KN_TRIMMED_KEEP, // they stay whole
    // They are cut off at the border, within crossing_tol: surfaces are trimmed along its preimage, curves end there,
    // triangles are cut along it. Not for volumes that cross it.
    KN_TRIMMED_CLIP,
    // Heights fall off to nothing (options.taper, 0: over one cell) towards the cells that the border crosses, and
    // to open ends. There a covering tile, which lies on the surface itself, is cut off as above, so that the face
    // keeps its border; another tile is not there.
    KN_TRIMMED_TAPER,
} kn_job_trimmed;

// Seeded Poisson-disk placement of a casual tile in place of one in each cell.
typedef struct kn_job_scatter {
    double distance; // least distance of two centres, length units; 0: no scatter, one tile in each cell
    uint64_t seed;
} kn_job_scatter;

// Where tiles lie. Zero: one in each cell, as modelled.
typedef struct kn_job_placement {
    double shift[2];   // of the whole tiling, in cells
    double stagger[2]; // [0]: each next row (in v) is shifted by so many cells in u; [1]: each next column in v
    bool mirror[2];    // every second column mirrored in u; every second row in v
    double angle;      // radians, of a casual tile about its cell's centre, beside the quarter turns
    kn_job_border border[2];
    kn_job_scatter scatter;
} kn_job_placement;

// What a camera sees: what lies beyond the picture is left out, and tessellations are as coarse as it allows.
typedef struct kn_job_view {
    // clip = matrix (x, y, z, 1), row by row: seen where |clip x|, |clip y| and |clip z| are at most clip w.
    double matrix[16];
    int pixels[2]; // width and height of the picture
    // Cells smaller than this on the screen go; 0: none.
    double least_pixels;
    // What a coarser tessellation may be off, on the screen; 0: 0.5. Cells side by side may then have different
    // segments, and gaps of that size between them.
    double chord_pixels;
    // Cells go that are certainly behind the base, which is opaque, or behind covering tiles in its place (unless
    // another selection leaves holes in these); tiles below the base stay. Not with fields, nor over volumes.
    bool hidden;
} kn_job_view;

// Which cells there are. Zero: all. A cell is there when all that is given agrees.
typedef struct kn_job_selection {
    const int *surfaces; // of the base, nsurfaces of them; NULL: all
    int nsurfaces;
    kn_field mask; // at the cell's middle: above 0.5
    bool cone;     // the normal at the middle within `cone_angle` radians of cone_axis
    double cone_axis[3], cone_angle;
    int skip[2];    // every skip-th cell only, from the first one; 0: 1
    double density; // the share of cells that stay, chosen by chance from `seed`; 0: 1
    uint64_t seed;
    size_t first, count; // a range of the cells in the job's order; count 0: all from `first`
    bool slab;           // those whose image may touch z in [slab_z[0], slab_z[1]]: certified to miss none
    double slab_z[2];
    const kn_job_view *view; // borrowed; NULL: none
} kn_job_selection;

// Why a cell is not there: the first of these that is not met.
typedef enum kn_job_drop {
    KN_DROP_SURFACE,
    KN_DROP_RANGE,
    KN_DROP_SKIP,
    KN_DROP_DENSITY,
    KN_DROP_MASK,
    KN_DROP_CONE,
    KN_DROP_TRIM, // beyond the border of a trimmed surface
    KN_DROP_SLAB,
    KN_DROP_OUTSIDE, // of the picture
    KN_DROP_SMALL,   // on the screen
    KN_DROP_HIDDEN,
    KN_DROP_REASONS
} kn_job_drop;

// The value of a tile's parameter, or of a change that every tile can have, over the base. Control points are taken
// at the places that they have in the unvaried tile, so that tiles which meet there still do.
typedef struct kn_job_vary {
    // Of the tile; or "height" (factor), "offset" (added, length units), which every tile has where it has no
    // parameter of that name.
    const char *parameter;
    kn_field field;
} kn_job_vary;

// Colours of tiles by a field: in the base colour's place, the other numbers of the material stay. The field is asked
// once for each cell, at its middle, so that a tile has one colour, also where it reaches into other cells. Its range
// is cut into equal steps: k / steps <= value < (k + 1) / steps has the palette's colour at k / (steps - 1) of its
// length, linear between its colours; what is below 0 and above 1 has the first one and the last. As many steps as
// colours: those alone. Cells are composed as they are without colours.
typedef struct kn_job_color {
    const char *part;           // of the tile; NULL: each. Of several that are for one part the last one holds
    kn_field field;             // borrowed
    const double (*palette)[3]; // linear RGB in [0,1], npalette >= 1 of them; the job copies them
    int npalette;
    int steps; // at most 256; 0: 16
} kn_job_color;

// Changes of each tile by chance, from the seed: casual tiles alone. Amplitudes; 0: none.
typedef struct kn_job_random {
    uint64_t seed;
    double angle, shift, scale, height; // radians; cells; and relative
} kn_job_random;

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
    kn_job_placement placement;
    kn_job_selection select;
    // What there is of each surface of the base, in the [0,1]^2 that stands for its domain (an empty one: all of it);
    // read while the job is planned. Sides of the square are no borders: there `border` holds. NULL: all of all. Not
    // for volumes, nor with KN_CELLS_FREE.
    const kn_trim *trims;
    // The body that each surface of the base belongs to: those of different bodies share no edges, even where they
    // coincide (equal parts of an assembly, each in its own coordinates). Read while the job is planned. NULL: one.
    const int *bodies;
    kn_job_trimmed trimmed;
    const kn_job_vary *vary;   // nvary of them, borrowed with all that they point to
    const kn_job_color *color; // ncolor of them
    int nvary, ncolor;
    kn_job_random random;
    // Heights fall off to nothing over this distance from open ends of the base and borders of the mask, length
    // units; with KN_TRIMMED_TAPER from borders of trims, too.
    double taper;
    kn_job_crossing crossing;
    double crossing_tol; // length units; 0: 1e-3 of a cell
    int max_degree;      // of a composed patch in one variable; 0: 25 (what OCCT reads); at most KN_MAX_DEGREE
    double mesh_tol;     // chord height of tessellations, length units; 0: 1/100 of the mean cell size
    bool symbolic;       // compose each cell symbolically (the reference) instead of by matrix
    // Patches over cells for which no polynomial of the degrees that there is room for is n interpolate T(D), with
    // N/|N| itself, in the least degrees that do, 32 at most, so that edges are the same on both sides bit for bit
    // (stand_in_error bounds that). They are polynomials, on rational surfaces too. Of tiles of surfaces alone, those
    // patches that stay in their cells and are not cut by trims, up to 200,000 on surfaces that hang together, and
    // without an attraction of power 1; elsewhere, and of false, patches over such cells have stand-ins for n, each
    // its own.
    bool equal_edges;
} kn_job_options;
KN_API kn_job_options kn_job_defaults(void);

// What a job will make; everything is known before the first patch is composed.
typedef struct kn_job_report {
    int nsurfaces; // of the base
    int nparts;    // surfaces of the job, which counts parts between creases, and rows of cells, one by one
    size_t cells, patches, exact_patches, control_points, triangles;
    size_t dropped[KN_DROP_REASONS]; // cells that are not there
    size_t curves, volumes, meshes;  // of the patches: those that are no surfaces
    int degree[2];                   // the largest in r and in t; of volumes, of all variables
    double height, cell_size;        // in force, length units
    kn_normal_certificate normal;    // over all pieces in use
    double normal_tol;               // in force
    int max_degree;                  // in force
    // Bound of |patch - T(D)| where a stand-in for n is used, length units, the thickness included; 0: none is. Where
    // D reaches beyond the surface's domain T(D) is S + w times its unit normal there, and not kn_shell_eval, which
    // extends n.
    double stand_in_error;
    double jacobian_lo, jacobian_hi; // kn_shell_jacobian_bounds over the heights that the tile occupies
    kn_cells_spread spread;          // of all cells
    double cells_error;              // bound of |S in use - S(map)| with KN_CELLS_FREE; 0: exact
    int even_instead;                // parts, of nparts, that kept even lines and S with KN_CELLS_FREE
    double stretch_error;            // relative, of the heights that follow the stretch (kn_cells_stretch)
    // Bound of |patch - T(D)|, and of the gap between trimmed pieces, where tile patches cross knot lines
    // (options.crossing), and from trimmed edges to ends and borders of trims that clip, length units, rounding
    // included; 0: none does.
    // Patches that are approximated side by side may be of different degrees: their gap is at most twice that.
    double crossing_error;
    // Told to sinks behind a kn_limit_sink: patches above fit_degree in a variable come as splines, each within
    // fit_tolerance (length units, certified) of what was composed; degree and control_points are then what may come,
    // the latter an estimate. 0: patches come as they are composed.
    int fit_degree;
    double fit_tolerance;
    // The most that one patch's trim has: curves, and their spans (those of a degree above 1 count 8 times).
    size_t trim_curves, trim_spans;
    double edge_error; // the most that kn_patch_bounds say
} kn_job_report;

// Stable identity of an output patch.
typedef struct kn_patch_id {
    int surface;  // of the base
    int cell[2];  // counted over the whole of it, also where the job takes it in parts (kn_job_origin)
    int part;     // of the tile
    int patch;    // Bezier patch of the part, counted over its splines; then its mesh
    int piece;    // 0 .. when a patch had to be subdivided
    int instance; // 0 .. of the tiles that a cell has (scatter)
    int layer;    // kn_job_run_layers
} kn_patch_id;

// An edge of a trimmed patch that others have, too: those whose number, curve, vertices and points are the same, bit
// for bit. The curve may run either way along the trim's.
typedef struct kn_patch_edge {
    uint64_t number;        // from 0 on
    const kn_spline *curve; // in space, over [a,b]; NULL: this curve of the trim is known by itself alone
    const kn_spline *plane; // of dimension 2, polynomial, over [a,b]: the same in the patch's square
    bool against;           // the trim's curve runs from b to a
    uint64_t vertex[2];     // numbers of the points where the curve starts and ends
    const double *point[2];
} kn_patch_edge;
// What is around a patch.
typedef struct kn_patch_bounds {
    const kn_patch_edge *edges; // one for each curve of the patch's trim
    // The solid that it belongs to, counted from 0, and by which of its shells; 0: the outer one, others are around
    // voids. body -1: whatever closes is a solid.
    int body, shell;
    double error; // how far the edges' curves may be from the patch and from their points, length units
} kn_patch_bounds;

typedef struct kn_patch {
    kn_patch_id id;
    int look; // part of the tile that sinks begin with (kn_job_look_tile): by it they choose name and material
    int body; // of the base (kn_job_options.bodies): patches of different bodies share no edges
    // One to three variables, 3 components or 4 homogeneous ones; borrowed, valid during the call, as all that
    // follows.
    kn_bezier bezier;
    // Not NULL: in the place of bezier, which is then empty, a spline over [0,1]^nvars (kn_limit_sink,
    // kn_merge_sink).
    const kn_spline *spline;
    // Of a limited surface: its edges r = 0, r = 1, t = 0, t = 1, four splines of one variable, each fitted by
    // itself, so that both faces of an edge have the same one, bit for bit up to its direction; they are the ends of
    // spline, which may have more knots. NULL: the ends of spline or bezier themselves.
    const kn_spline *edge;
    const kn_trim *trim;           // of a surface: what there is of it, in its [0,1]^2; NULL: all
    const kn_patch_bounds *bounds; // of a trimmed surface; NULL: nothing is known
    const kn_mesh *mesh;           // not NULL: a mapped part of a mesh; bezier is then empty
    bool reversed;                 // outward is -(r x t): the job's height is negative
    bool exact;                    // false: composed with a stand-in for n
    uint8_t hidden;  // faces of a volume behind others: bit 2 var + end. The outside of volumes is without them
    int segments[3]; // in each variable, by which tessellations of neighbouring patches match
} kn_patch;

// ---- what a patch looks like ----
KN_API int kn_patch_nvars(const kn_patch *patch); // of bezier or spline; 0: a mesh
// Its bezier or its spline, as a spline (clamped, over [0,1]^nvars) that borrows all arrays: read it, and neither
// clear nor change it. Empty for a mesh.
KN_API kn_spline kn_patch_spline(const kn_patch *patch);
// Appends triangles: of a surface (kn_mesh_add_patch, kn_mesh_add_trimmed), of the faces of a volume that are not
// hidden, of a mapped mesh; none of a curve. fails: as those; the mesh holds what it held.
KN_API KN_CHECKED kn_status kn_patch_tessellate(kn_ctx *ctx, kn_mesh *mesh, const kn_patch *patch);
// The points of a curve at its segments: kn_patch_line_points of them (0: it is no curve), 3 numbers each.
// fails: KN_EDOMAIN no curve, KN_ENOMEM.
KN_API size_t kn_patch_line_points(const kn_patch *patch);
KN_API KN_CHECKED kn_status kn_patch_line(kn_ctx *ctx, double *points, const kn_patch *patch);
// out = the face of a volume where variable face / 2 ends (face % 2), as a surface with outside and segments; its
// control points are the caller's (kn_bezier_clear), all else is borrowed from patch. fails: KN_EDOMAIN no volume, no
// such face; KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_patch_face(kn_ctx *ctx, kn_patch *out, const kn_patch *patch, int face);

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
    // For jobs that can be interrupted (kn_job_run_from); NULL: not with this sink. save, between two commits: *data
    // = the state as *bytes bytes from the context's allocator; what was written so far then stays when the sink is
    // closed before its end. restore, in place of begin, on a new sink of the same kind and path: as it was when that
    // was saved.
    kn_status (*save)(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes);
    kn_status (*restore)(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                         const unsigned char *data, size_t bytes);
    // Nobody can go on from what was saved: what was written does not stay. NULL: there is nothing that would.
    void (*forget)(void *user);
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
// fails:  as kn_shell_create, kn_spline_check and kn_tile_check; KN_EDOMAIN options negative or not finite, colours
//         (kn_job_color) of no part, field or palette, fewer cells than knot spans, a max_degree that leaves no room
//         for the normal (the message says what is needed), a tile patch that crosses a knot line of a surface and
//         not along a parameter line of its own; KN_ELIMIT counts, cells, max_degree, a tile that reaches more than
//         256 cells beyond its own; KN_EUNDECIDED no normal within normal_tol after ten bisections each way;
//         KN_ECANCELLED, KN_ENOMEM. *out unchanged.
KN_API KN_CHECKED kn_status kn_job_create(kn_ctx *ctx, kn_job **out, const kn_spline *surfaces, int nsurfaces,
                                          const kn_tile *tile, const kn_job_options *options);
KN_API void kn_job_destroy(kn_ctx *ctx, kn_job *job);
KN_API kn_job_report kn_job_describe(const kn_job *job);
// The tile as placed (rotated), whose parts patches refer to; and the shell of one surface of the job, 0 .. nparts -
// 1 (NULL: no such).
KN_API const kn_tile *kn_job_tile(const kn_job *job);
// The tile that sinks begin with: the same, except that a part which has colours by a field is there once for each
// of them, "thorn.00", "thorn.01" ..; splines and meshes are shared, parameters left out. kn_patch.look counts these.
KN_API const kn_tile *kn_job_look_tile(const kn_job *job);
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

// How an output patch changes: d (its control points) / d (parameter k of the tile), and / d (control point `index`
// of the surface of a job's shell, kn_shell_surface).
// in:     a composed patch, of no mesh and not approximated (kn_job_options.crossing). Cuts at cell lines, and lines,
//         stay where they are in the tile patch and on S. A parameter that a field varies grows by the same
//         everywhere, and its range does not count.
// out:    initialised, overwritten, polynomial, of the patch's degrees: by a parameter as many components as the
//         patch has (homogeneous coordinates one by one, where it is rational); by a control point of the base one,
//         the same for every component (its homogeneous coordinates, where it is rational). That counts S alone: n is
//         held, which is exact where a direction takes its place, and else leaves w dn/dP out.
// fails:  KN_EDOMAIN no such patch, parameter, surface or control point; a patch that is no composition; a volume;
//         KN_ENOMEM; out unchanged.
// error:  as kn_compose_matrix_init and kn_bezier_product, in absolute values, and what moves is lowered within 2^-48
//         of a cell (docs/numerics.md); by the base as kn_spline_restrict and kn_compose_matrix_init.
// cost:   the plan of one cell and three matrices for each term.
KN_API KN_CHECKED kn_status kn_job_parameter_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_job *job,
                                                         const kn_patch_id *id, int parameter);
KN_API KN_CHECKED kn_status kn_job_base_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_job *job,
                                                    const kn_patch_id *id, int surface, const int index[2]);

// Composes everything and sends it to the sinks. The same patches in the same order, bit for bit, for any number of
// threads (on one kind of processor: docs/numerics.md, compose). Memory: the matrices and the blocks in flight, 2 MiB
// or one cell each, two for each thread and one more. The sinks are not closed. ctx need not be the one that made the
// job.
//
// fails: what the sinks answer; KN_EDOMAIN a sink without commit, a colour's field that is no number;
//        KN_ECANCELLED, KN_ENOMEM. All products are then discarded.
KN_API KN_CHECKED kn_status kn_job_run(kn_ctx *ctx, const kn_job *job, kn_sink *sinks, int nsinks);

// Several layers, each with a base, tile and options of its own, in one run: sinks begin with the parts of all tiles,
// layer by layer (a name that is there already gets a number), and the layers' reports in one; patches come layer by
// layer, id.layer, id.part and look counted over all. fails: as kn_job_run; KN_EDOMAIN njobs < 1.
KN_API KN_CHECKED kn_status kn_job_run_layers(kn_ctx *ctx, const kn_job *const *jobs, int njobs, kn_sink *sinks,
                                              int nsinks);
// What the layers' reports say together: sums, the worst of errors; sizes of the first.
KN_API kn_job_report kn_job_describe_layers(const kn_job *const *jobs, int njobs);

// How a run is noted so that it can go on after an interruption (io.h: kn_run_with_journal does it with a file).
typedef struct kn_job_notes {
    void *user;
    // Called before the first commit and between two: the run as bytes, from which kn_job_run_from goes on. NULL:
    // never.
    kn_status (*note)(kn_ctx *ctx, void *user, const unsigned char *state, size_t bytes);
    double seconds;             // from one to the next; 0: 5; negative: after every block
    const unsigned char *state; // where to go on: what note was given; NULL: from the beginning
    size_t bytes;
    uint64_t identity; // the caller's, of what the job cannot know: fields and other functions of its options
} kn_job_notes;
// The same as kn_job_run, noted. Gone on with, it gives the sinks what is left: their files become the same, byte for
// byte, as without the interruption, for any number of threads.
// fails: also KN_EDOMAIN a sink without save and restore, a state of another job (base, tile, options, identity) or
//        of other sinks, or one that is damaged; what note answers.
KN_API KN_CHECKED kn_status kn_job_run_from(kn_ctx *ctx, const kn_job *job, kn_sink *sinks, int nsinks,
                                            const kn_job_notes *notes);
// The same of several layers (kn_job_run_layers); a state is of all of them. notes NULL: not noted.
KN_API KN_CHECKED kn_status kn_job_run_layers_from(kn_ctx *ctx, const kn_job *const *jobs, int njobs, kn_sink *sinks,
                                                   int nsinks, const kn_job_notes *notes);

// Cells in the job's order: first .. first + count - 1.
typedef struct kn_cell_range {
    size_t first, count;
} kn_cell_range;
// The same for some cells alone. The report that sinks get is that of the whole job, and block->first counts the
// patches of this run. Neighbours of a cell that is composed by a plan of its own may come with it.
// in:    ranges: n of them, ascending and apart (else KN_EDOMAIN); n may be 0.
KN_API KN_CHECKED kn_status kn_job_run_cells(kn_ctx *ctx, const kn_job *job, const kn_cell_range *ranges, size_t n,
                                             kn_sink *sinks, int nsinks);

// ---- cells near a plane ----

// The heights z between which the tiles of every cell of a job lie, from coefficients and without composing: made
// once, asked for each slab. It is never written to: any number of threads may ask.
typedef struct kn_job_slabs kn_job_slabs;
// in:     job: borrowed, for the slabs' life.
// out:    *out, ended by kn_job_slabs_destroy. 8 bytes for each cell.
// fails:  KN_ENOMEM, KN_ECANCELLED, and what a field answers; *out unchanged.
// error:  none: every patch of a cell, as it is composed, lies between its heights (docs/numerics.md, "job").
// cost:   5 us for each cell that the tile of one cell reaches, 20 us and more where tiles are no two alike.
KN_API KN_CHECKED kn_status kn_job_slabs_create(kn_ctx *ctx, kn_job_slabs **out, const kn_job *job);
KN_API void kn_job_slabs_destroy(kn_ctx *ctx, kn_job_slabs *slabs);
// The heights between which all cells lie; lo > hi where there is none.
KN_API void kn_job_slabs_range(const kn_job_slabs *slabs, double z[2]);
// All cells whose tiles may touch z in [z0, z1]; none that does is missing.
// out:    *ranges: *n of them, ascending and apart, for kn_free.
// fails:  KN_EDOMAIN not z0 <= z1, KN_ENOMEM; outputs unchanged.
// cost:   some ns for each 64 cells of the job, and some 0.1 us for each cell that is found.
KN_API KN_CHECKED kn_status kn_job_slabs_find(kn_ctx *ctx, kn_cell_range **ranges, size_t *n,
                                              const kn_job_slabs *slabs, double z0, double z1);

#ifdef __cplusplus
}
#endif
#endif
