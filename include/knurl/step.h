// SPDX-License-Identifier: Apache-2.0
// STEP files: what CAD systems take in, solids with shared edges.
#ifndef KNURL_STEP_H
#define KNURL_STEP_H

#include <knurl/io.h>

#ifdef __cplusplus
extern "C" {
#endif

// Application protocols (ISO 10303).
typedef enum kn_step_schema {
    KN_STEP_AP214,
    KN_STEP_AP242,
    KN_STEP_AP203, // its colours are those of a module that came later, which the file names too
} kn_step_schema;

// A body that the patches take a place in: what another writer made of a CAD file, less the faces that the patches
// replace. Numbers are those of its entities.
typedef struct kn_step_seed { // an edge of the body that an edge of a patch is, too
    kn_spline curve;          // that of the patch, control points as it has them, either way round
    uint32_t edge;            // EDGE_CURVE
    uint32_t vertex[2];       // VERTEX_POINTs at the curve's start and end
    bool along;               // EDGE_CURVE runs along the curve
    int body;                 // of the patches whose edges it is (kn_patch.body)
    int shell;                // of the host's shells: that of the face which stays and uses the edge
    bool forward;             // the boundary of that face runs along the curve, counterclockwise seen from outside
} kn_step_seed;
typedef struct kn_step_shell { // its text is not among the entities: the sink writes it, with the patches' faces
    uint32_t number;
    bool closed;
    const uint32_t *faces; // that stay, nfaces of them
    int nfaces;
} kn_step_shell;
typedef struct kn_step_host {
    const char *entities; // "#n=..;" line by line, 0 < n <= numbers, in millimetres, with their product structure
    size_t bytes;
    uint32_t numbers;
    uint32_t context; // GEOMETRIC_REPRESENTATION_CONTEXT, for colours
    const kn_step_shell *shells;
    int nshells;
    // Patches belong to the shell that they are tied to by seeds, from edge to edge. Where no face of a shell stays, it
    // gets all patches of those surfaces of the base for which shell_of, of nsurfaces numbers, names it; -1: none.
    // Bodies that belong to no shell stand in a product of their own.
    const int *shell_of;
    int nsurfaces;
    const kn_step_seed *seeds;
    int nseeds;
} kn_step_host;

typedef struct kn_step_options {
    const char *product; // name in the product structure, UTF-8; NULL: "knurl"
    double unit_mm;      // millimetres in one length unit; 0: 1
    // UNCERTAINTY_MEASURE_WITH_UNIT, the largest gap between neighbouring faces; 0: 1e-3. What the job's report says
    // of gaps is written where it is more.
    double uncertainty_mm;
    // ISO 8601 for the header; NULL: "1970-01-01T00:00:00", so that equal jobs give equal bytes
    const char *time_stamp;
    kn_step_schema schema;
    const char *const *surface_names; // of the base's, in the place of "s0", "s1" .., nsurfaces of them, copied;
    int nsurfaces;                    // NULL or "": that
    // Faces are called as their surfaces alone, "" where these have no name, and bodies as their parts: for what no
    // job made.
    bool plain_names;
    const kn_step_host *host; // borrowed until the sink is closed, of the same schema; NULL: none
    // An assembly: cells whose control points are those of an earlier one, turned and shifted (within 1e-9 of the cell's
    // size, all of them; weights within 2e-11), are instances of its part. Others, mirrored ones too, are parts of their
    // own. For AP214 and AP242, and for tiles whose bodies are closed by the faces of one cell. A new cell is compared
    // with 1024 others at most, of 64 MiB. Such a file cannot be gone on with.
    bool instances;
    // Of the whole file; NULL: none. Such a file cannot be gone on with (kn_run_with_journal).
    const kn_filter *filter;
} kn_step_options;

// A sink that writes a STEP file as those of io.h do (a new file beside path, named when the job has ended), in
// millimetres: one ADVANCED_FACE for each patch, on its own control points, named "s0 c3,4 ring 12": surface, cell,
// part, patch (".1": piece). Edges that neighbours have in common bit for bit are one edge, those of trimmed patches, too,
// and those that patches tell of (kn_patch_bounds); bodies that are closed by them are solids, others shells. Edges that are collapsed to a point (within 1e-7 mm or 1e-12 of the coordinates) are
// left out. A colour for each part of the tile. Rational form only where weights differ. Where some faces are exact
// and others not, the names of those that are not end with " ~"; the header says how far off they may be.
// fails: also KN_EUNDEFINED (a control point that is not finite, a weight that is not positive), KN_ELIMIT (more than
//        2^31 entities), KN_EDOMAIN (options; instances of cells that do not close their bodies; a host whose seeds
//        contradict each other, or a shell of it that was closed and is not with the patches: the message says how
//        many edges have one face).
// error: coordinates are the shortest decimals that read back as the same doubles; before that, one rounding for the
//        unit unless it is 1, one for the projection of a rational point.
KN_API KN_CHECKED kn_status kn_step_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_step_options *options);

#ifdef __cplusplus
}
#endif
#endif
