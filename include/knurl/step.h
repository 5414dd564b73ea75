// SPDX-License-Identifier: Apache-2.0
// STEP files: what CAD systems take in, solids with shared edges.
#ifndef KNURL_STEP_H
#define KNURL_STEP_H

#include <knurl/job.h>

#ifdef __cplusplus
extern "C" {
#endif

// A body that the patches take a place in: what another writer made of a CAD file, less the faces that the patches
// replace. Numbers are those of its entities.
typedef struct kn_step_seed { // an edge of the body that an edge of a patch is, too
    kn_spline curve;          // that of the patch, control points as it has them, either way round
    uint32_t edge;            // EDGE_CURVE
    uint32_t vertex[2];       // VERTEX_POINTs at the curve's start and end
    bool along;               // EDGE_CURVE runs along the curve
} kn_step_seed;
typedef struct kn_step_shell { // its text is not among the entities: the sink writes it, with the patches' faces
    uint32_t number;
    bool closed;
    const uint32_t *faces; // that stay, nfaces of them
    int nfaces;
} kn_step_shell;
typedef struct kn_step_host {
    const char *entities; // "#n=..;" line by line, 0 < n <= numbers
    size_t bytes;
    uint32_t numbers;
    uint32_t context; // GEOMETRIC_REPRESENTATION_CONTEXT, for colours
    const kn_step_shell *shells;
    int nshells;
    // The shell that patches of a surface of the base belong to, nsurfaces of them; -1: none. Bodies of other patches,
    // and those that no seed ties to a shell, stand in a product of their own.
    const int *shell_of;
    int nsurfaces;
    const kn_step_seed *seeds;
    int nseeds;
} kn_step_host;

typedef struct kn_step_options {
    const char *product;   // name in the product structure, UTF-8; NULL: "knurl"
    double unit_mm;        // millimetres in one length unit; 0: 1
    double uncertainty_mm; // UNCERTAINTY_MEASURE_WITH_UNIT, the largest gap between neighbouring faces; 0: 1e-3
    const char
        *time_stamp; // ISO 8601 for the header; NULL: "1970-01-01T00:00:00", so that equal jobs give equal bytes
    const kn_step_host *host; // borrowed until the sink is closed; NULL: none
} kn_step_options;

// A sink that writes a STEP file as those of io.h do (a new file beside path, named when the job has ended).
// STEP AP214 in millimetres: one ADVANCED_FACE for each patch, on its own control points, named "s0 c3,4 ring 12":
// surface, cell, part, patch (".1": piece); edges that are collapsed to a point (within 1e-7 mm or 1e-12 of the
// coordinates) left out; a shell and a colour for each part of the tile. Rational form only where weights differ.
// fails: also KN_EUNDEFINED (a control point that is not finite, a weight that is not positive), KN_ELIMIT (more than
//        2^31 entities).
// error: coordinates are the shortest decimals that read back as the same doubles; before that, one rounding for the
//        unit unless it is 1, one for the projection of a rational point.
KN_API KN_CHECKED kn_status kn_step_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_step_options *options);

#ifdef __cplusplus
}
#endif
#endif
