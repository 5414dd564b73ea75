// SPDX-License-Identifier: Apache-2.0
// Readers of spline files, the built-in tiles, and streaming writers of composed patches.
#ifndef KNURL_IO_H
#define KNURL_IO_H

#include <knurl/job.h>
#include <knurl/mesh.h>
#include <knurl/slice.h>

#ifdef __cplusplus
extern "C" {
#endif

// What a reader found: splines of any kinds in file order, and polygons as triangles. A zero-initialised kn_model is
// a valid empty one.
typedef struct kn_model {
    kn_spline *splines;
    int nsplines;
    kn_mesh mesh; // no normals; empty: no polygons
} kn_model;
KN_API void kn_model_clear(kn_ctx *ctx, kn_model *model); // leaves it empty

// Each kn_read_x opens path and calls kn_parse_x on its bytes; name stands for the file in messages.
// in:     text need not end in a zero byte. Numbers are decimal, whatever the locale is.
// out:    overwritten (what it held is cleared); kn_model_clear. Coordinates become the components, u the first
//         variable. Every spline passes kn_spline_check.
// fails:  KN_EPARSE, "name:line: what, value": what is missing, no number, not finite, a weight that is not positive,
//         knots that decrease, a surface of zero area (all control points on a line, or a net that does not change
//         along one variable), counts that cannot fit the bytes that follow, text after the end. KN_ELIMIT, KN_EIO,
//         KN_ENOMEM. out unchanged.
// error:  each number is the double nearest to its text.
// cost:   the file's bytes and the splines in memory; nothing is allocated for a count before it is known to fit.

// .bpt: a count, then for each Bezier patch its degrees "m n" and (m+1)(n+1) points, u running fastest.
KN_API KN_CHECKED kn_status kn_read_bpt(kn_ctx *ctx, kn_model *out, const char *path);
KN_API KN_CHECKED kn_status kn_parse_bpt(kn_ctx *ctx, kn_model *out, const char *name, const char *text,
                                         size_t bytes);
// GoTools .g2: spline curves (100), surfaces (200) and volumes (700), polynomial or rational (control points already
// multiplied by their weights). Knots that are not clamped become so by knot insertion: the same function, with a few
// roundings.
KN_API KN_CHECKED kn_status kn_read_g2(kn_ctx *ctx, kn_model *out, const char *path);
KN_API KN_CHECKED kn_status kn_parse_g2(kn_ctx *ctx, kn_model *out, const char *name, const char *text, size_t bytes);
// IRIT data files (.itd, text): BEZIER and BSPLINE curves, surfaces and trivariates with points E1 .. E9, P1 .. P9;
// polylines as curves of degree 1; polygons as fans of triangles about their first vertex, each with vertices of its
// own, less those of which two corners coincide. Objects may be nested in any depth; attributes, numbers, points,
// vectors, matrices, strings and text outside brackets are skipped. fails: also KN_EPARSE a trimmed or triangular
// surface, a multivariate, a model, a periodic knot vector (not read), no geometry at all.
// source: IRIT 12 user's manual, "Data file format" (Elber, Technion).
KN_API KN_CHECKED kn_status kn_read_itd(kn_ctx *ctx, kn_model *out, const char *path);
KN_API KN_CHECKED kn_status kn_parse_itd(kn_ctx *ctx, kn_model *out, const char *name, const char *text,
                                         size_t bytes);
// By the ending of path, in letters of either case: .bpt, .g2 or .itd (KN_EDOMAIN otherwise).
KN_API KN_CHECKED kn_status kn_read_model(kn_ctx *ctx, kn_model *out, const char *path);

// ---- tiles ----
KN_API int kn_builtin_tile_count(void);
KN_API const char *kn_builtin_tile_name(int index); // NULL outside 0 .. count-1. Static storage
// out = the built-in tile of that name (docs/tiles.md); overwritten, not cleared: kn_tile_clear is the caller's.
// fails: KN_EDOMAIN (no such tile), KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_builtin_tile(kn_ctx *ctx, kn_tile *out, const char *name);
// out = a casual tile of one part, named after the file, from all that a file has that kn_read_model reads.
// in:    cell: u0, v0, u1, v1, u0 < u1, v0 < v1, a rectangle of the file's (u,v) that is mapped to the unit square;
//        NULL: it is that already. w stays as it is; the aspect is 1 / sqrt of the rectangle's area, so that one unit
//        of w looks as long as one unit of u and v.
// out:   overwritten, not cleared.
// fails: KN_EDOMAIN (cell, the path's ending, what kn_tile_check says), and as kn_read_model; out unchanged.
KN_API KN_CHECKED kn_status kn_read_tile(kn_ctx *ctx, kn_tile *out, const char *path, const double *cell);

// ---- writers ----

// What turns the bytes of a writer into those of its file: a compressor (bridges/zlib: kn_gzip_filter). The core has
// none. put: any number of times, `last` with the last one; it gives what there is to write to write(to, ..), whose
// failures it answers.
typedef struct kn_filter {
    kn_status (*begin)(kn_ctx *ctx, void **state, int level);
    kn_status (*put)(kn_ctx *ctx, void *state, const void *data, size_t bytes, bool last,
                     kn_status (*write)(kn_ctx *ctx, void *to, const void *data, size_t bytes), void *to);
    void (*end)(kn_ctx *ctx, void *state); // NULL is fine
    int level;
} kn_filter;

// Sinks for kn_job_run that write a new file beside path and give it the name when the job has ended: path is whole
// or as it was before. A path that exists and is neither file nor folder (a pipe, /dev/null) is written to directly.
// out:    overwritten; kn_sink_close removes the file unless the job ended well. bytes: what is written so far.
// fails:  KN_EIO at once when the file cannot be created, later when it cannot be written (a full disk); KN_ENOMEM,
//         KN_EDOMAIN (options; patches that the job's report did not announce). out unchanged.
// memory: the text of the blocks in flight. The same bytes for any number of threads.

// Binary STL: single precision, triangles of which two corners then coincide left out. fails: also KN_ELIMIT (2^32
// triangles), KN_EDOMAIN a coordinate beyond single precision (the message names surface and cell).
KN_API KN_CHECKED kn_status kn_stl_sink(kn_ctx *ctx, kn_sink *out, const char *path);

// Wavefront OBJ with normals, positions in nine digits, a group for each part, and materials in an .mtl file beside
// it (path with that ending).
KN_API KN_CHECKED kn_status kn_obj_sink(kn_ctx *ctx, kn_sink *out, const char *path);

// Keeps patches as splines over [0,1]^n in the job's order, with the bits that they have; reversed surfaces are run
// through the other way. A base for another job (texture on texture): with a direction, and tiles of low degrees,
// exact to any depth that KN_MAX_DEGREE allows. *model is the caller's, overwritten when the job has ended, and then
// a valid model; until then as it was.
// fails: KN_EDOMAIN meshes, trimmed patches; KN_ENOMEM.
KN_API KN_CHECKED kn_status kn_collect_sink(kn_ctx *ctx, kn_sink *out, kn_model *model);

// Writes nothing. bytes: of the patches' coefficients as doubles.
KN_API KN_CHECKED kn_status kn_null_sink(kn_ctx *ctx, kn_sink *out);

// ---- for receivers of low degrees ----
typedef struct kn_limit_options {
    int max_degree;   // 3 .. KN_MAX_DEGREE: what a receiver takes, in each variable
    double tolerance; // > 0, length units
    // Radians, at most 0.8; 0: one degree. Where exact normals of two neighbours agree along an edge, those of what
    // takes their places differ by no more, certified: each may turn by half of it. But for edges that are counted.
    double seam_angle;
} kn_limit_options;
typedef struct kn_limit_summary {
    size_t exact, limited; // patches that went on as they came, and those that were replaced
    double error; // certified: no point of a limited patch is further from the exact one, at equal parameters
    // Certified, radians: between the normals of a limited patch and of the exact one along its edges, but for
    // unknown_angles edges, and but for places without a normal of singular_angles others (kn_fit_limited). What
    // joined smoothly does so within twice that, which is at most seam_angle but for wide_angles edges, where more
    // spans were of no use.
    double angle;
    size_t unknown_angles, wide_angles, singular_angles;
    int degree[2];                // largest that went on, in r and t; of volumes, of all variables
    size_t spans, control_points; // of all patches that went on
} kn_limit_summary;
// A sink before n others, at least one, which get each patch whose degrees are all at most max_degree as it is, and
// in the place of others splines (kn_patch.spline, .edge) of degree up to 5 within the tolerance
// (kn_fit_limit_degree; quantum 2^floor(log2(tolerance / 1024)), half of seam_angle), which are not exact. Volumes come as those of their
// faces that are not hidden. Trims stay what they are, in the plane of parameters; meshes pass. The report is told
// fit_degree and fit_tolerance where its degrees are above the limit.
// in:     sinks: out's on success, which closes them; the caller's after a failure. summary: NULL, or where it stands
//         after each commit, until the sink is closed.
// fails:  KN_EDOMAIN options, n, sinks without commit; KN_EUNDECIDED a patch needs more than 2^8 spans (the message
//         names it); what the sinks answer. save and restore where all of them have them.
// memory: the limited patches of the blocks in flight. cost: 0.2 to 5 ms for a patch that is limited.
KN_API KN_CHECKED kn_status kn_limit_sink(kn_ctx *ctx, kn_sink *out, const kn_sink *sinks, int n,
                                          const kn_limit_options *options, kn_limit_summary *summary);

// kn_job_run, or of several layers kn_job_run_layers, that can be interrupted: at once, and every `seconds` (0: 5;
// negative: after each block), how far it is goes to the file at `journal` (by convention the output's path and
// ".journal"), which is replaced in one step, and removed when all went well. After a failure, a cancellation, or the
// end of the process the sinks' unfinished files stay beside it, if the journal is there.
// resume: goes on from there, where the journal exists, with new sinks for the same paths: the same bytes as without
//         the interruption. Where there is none it begins.
// in:     sinks: of files (STEP, IGES, STL, OBJ, those of write.h but MFEM) and kn_null_sink; not those that hold all
//         until the end (glTF).
//         identity: as kn_job_notes: 0, or a number for fields and other functions of the job's options.
// fails:  as kn_job_run_from; KN_EIO the journal cannot be written or read, or what it speaks of is gone.
KN_API KN_CHECKED kn_status kn_run_with_journal(kn_ctx *ctx, const kn_job *const *jobs, int njobs, kn_sink *sinks,
                                                int nsinks, const char *journal, bool resume, double seconds,
                                                uint64_t identity);

// ---- fewer faces ----
typedef struct kn_merge_options {
    double tolerance; // > 0, length units: what merging may move
    int cells;        // in each direction that a surface may take patches from; 0: 4; at most 64
    double angle;     // radians, at most 0.8: how far normals along its outer edges may turn; 0: whatever comes
} kn_merge_options;
typedef struct kn_merge_summary {
    size_t patches, faces, merged; // that came, that went on, and those of these that stand for several
    double error;                  // certified: no point moved further, at equal parameters of the pieces
    size_t c2;                     // merged ones that are C2 in both directions; the others are C1
    // Certified, radians: no normal along the outer edges of a merged one turned further, but where normals (almost)
    // vanish: unknown_angles, and places of singular_angles of their edges, as of limited ones.
    double angle;
    size_t unknown_angles, singular_angles;
} kn_merge_summary;
// A sink before n others that puts one surface in the place of patches of one tile part, over up to cells x cells
// cells, where they form a grid, joined bit for bit along their edges (kn_patch.edge, or their ends), of equal
// degrees, and C1 or C2 across all seams within the tolerance; other patches, trimmed ones, curves, volumes and
// meshes go on as they are, in another order. A merged patch has the first one's name; its edges (kn_patch.edge) are
// those of the patches one after the other, so that a neighbour of the same length has the same.
// in:     sinks, summary: as kn_limit_sink, which comes before this one where both are wanted.
// fails:  KN_EDOMAIN options, n, sinks without commit; what the sinks answer. Not for journals (no save).
// memory: the patches of `cells` columns of cells of one surface. The same patches for any number of threads.
KN_API KN_CHECKED kn_status kn_merge_sink(kn_ctx *ctx, kn_sink *out, const kn_sink *sinks, int n,
                                          const kn_merge_options *options, kn_merge_summary *summary);

// ---- what no job composed, through the same sinks ----

// Sends patches to sinks as a job would: begin, blocks in order, end; the work on blocks is done on all threads of the
// context, and the files are the same for any number of them. The sinks are not closed.
// in:     patches: n, each with a look that is a part of the tile; size: for sinks that ask for the size of a cell,
//         length units; 0: 1.
// fails:  KN_EDOMAIN a look that is none, a sink without commit; what the sinks answer; KN_ECANCELLED.
KN_API KN_CHECKED kn_status kn_stream_patches(kn_ctx *ctx, const kn_tile *tile, const kn_patch *patches, size_t n,
                                              double size, kn_sink *sinks, int nsinks);
// Zero means the default in every field.
typedef struct kn_stream_options {
    double mesh_tol;   // chord height of tessellations, length units; 0: a thousandth of the box's diagonal
    bool split;        // at knots where a spline is not C1: what CAD systems want
    bool unit_domains; // variables run from 0 to 1, and not as they do in the model
    int max_degree;    // splines of a higher degree go piece by piece, for a kn_limit_sink; 0: none
} kn_stream_options;
// The splines and the mesh of a model as patches: surface i of the base is spline i, all of one part of this name.
// in:     what lies in the plane goes to z = 0; splines in other dimensions, and of more than three variables, are
//         left out.
// fails:  KN_EDOMAIN the tolerance, nothing that lies in space; as kn_stream_patches; KN_ENOMEM.
// error:  none, but for the knots of unit domains; the chord height is measured by control points, and for rational
//         splines about right.
KN_API KN_CHECKED kn_status kn_stream_model(kn_ctx *ctx, const kn_model *model, const char *name,
                                            const kn_stream_options *options, kn_sink *sinks, int nsinks);

// One layer as an SVG drawing in millimetres: closed contours filled (nonzero), open ones as thin red lines.
typedef struct kn_svg_options {
    double unit_mm; // millimetres in one length unit; 0: 1
    double box[4];  // x0, y0, x1, y1: the drawing, length units; the same for all layers of one object
} kn_svg_options;
// fails: KN_EDOMAIN (options), KN_EIO, KN_ENOMEM: path is whole or as it was before. error: nine digits.
KN_API KN_CHECKED kn_status kn_write_svg_slice(kn_ctx *ctx, const char *path, const kn_slice *layer,
                                               const kn_svg_options *options);

#ifdef __cplusplus
}
#endif
#endif
