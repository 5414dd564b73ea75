// SPDX-License-Identifier: Apache-2.0
// IGES files: for CAD systems that take in nothing newer.
#ifndef KNURL_IGES_H
#define KNURL_IGES_H

#include <knurl/job.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct kn_iges_options {
    const char *product;    // name of the product, UTF-8 (other letters than ASCII become '_'); NULL: "knurl"
    double unit_mm;         // millimetres in one length unit; 0: 1
    double uncertainty_mm;  // minimum resolution, the largest gap between neighbouring faces; 0: 1e-3
    const char *time_stamp; // ISO 8601, "2026-01-02T03:04:05"; NULL: the first second of 1970, so that equal jobs
                            // give equal bytes
    bool surfaces; // faces as surfaces (128) and trimmed surfaces (144) alone, for receivers that know no B-rep and
                   // sew themselves
    // As of kn_step_options; letters other than ASCII become '_'.
    const char *const *surface_names;
    int nsurfaces;
    bool plain_names;
} kn_iges_options;

// A sink that writes an IGES 5.3 file as those of io.h do (a new file beside path, named when the job has ended;
// until then also one for the parameter section).
// Millimetres. Each patch is a rational B-spline surface (128) on its own control points, and a face (510, 508) whose
// edges (504, 126) and vertices (502) it shares, bit for bit, with its neighbours: bodies that close are manifold
// solids (186, 514), with voids where patches tell of them, the others open shells (514 form 2). Trimmed patches are such
// faces with curves in the plane of the parameters, too (126); without shells trimmed surfaces (144, 142). Curves are 126. Colours: 314, one for each look in use; names as
// those of STEP (step.h), what is approximated marked there, too: 406 form 15.
// fails: also KN_EUNDEFINED (a control point that is not finite, a weight that is not positive), KN_ELIMIT (more
// lines
//        than seven digits count: some 300,000 bicubic faces), KN_EDOMAIN (meshes; a time stamp that is none).
// error: coordinates are the shortest decimals that read back as the same doubles; before that, one rounding for the
//        unit unless it is 1, one for the projection of a rational point.
KN_API KN_CHECKED kn_status kn_iges_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_iges_options *options);

#ifdef __cplusplus
}
#endif
#endif
