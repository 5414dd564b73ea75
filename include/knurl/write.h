// SPDX-License-Identifier: Apache-2.0
// Streaming writers of exact patches: GoTools, IRIT, OBJ surfaces, VTK, MFEM, POV-Ray.
// STL, OBJ triangles: io.h; STEP: step.h; IGES: iges.h.
#ifndef KNURL_WRITE_H
#define KNURL_WRITE_H

#include <knurl/io.h>

#ifdef __cplusplus
extern "C" {
#endif

// Sinks for kn_job_run and kn_stream_model, as those of io.h: a new file beside path gets the name when the job has
// ended; the same bytes for any number of threads; memory is that of the blocks in flight; runs can be noted and
// gone on with. A patch is one piece or a spline (kn_patch_spline) and goes out as it is: numbers are the shortest
// that read back as the same doubles. Reversed surfaces and volumes have their first two variables swapped, so that
// r x t looks outside and volumes are right-handed.
// fails:  KN_EDOMAIN also for kinds of patches that a format does not hold, control points that are not finite, and
//         weights that are not positive; all before anything is written where the job's report tells.

// GoTools .g2: curves (100), surfaces (200), volumes (700) with colours, trimmed surfaces as bounded surfaces (210)
// whose loops are curves in the parameter plane; kn_read_g2 reads all but these back, bit for bit. No meshes, no names.
KN_API KN_CHECKED kn_status kn_g2_sink(kn_ctx *ctx, kn_sink *out, const char *path);
// IRIT data (.itd): curves, surfaces, trivariates, trimmed surfaces (TRIMSRF), meshes as polygons; each an object
// with a name, "s0_c3_4_ring_12" for surface, cell, part and patch, and the colour of its part. kn_read_itd reads all but
// trimmed surfaces back, bit for bit.
KN_API KN_CHECKED kn_status kn_itd_sink(kn_ctx *ctx, kn_sink *out, const char *path);

// Wavefront OBJ with curves and surfaces instead of triangles ("cstype bspline", "rat bspline"), trims as loops of
// curves of the parameter plane, volumes as those of their faces that lie outside, meshes as triangles; groups and
// materials as kn_obj_sink has them. error: rational points are divided by their weights.
KN_API KN_CHECKED kn_status kn_obj_surfaces_sink(kn_ctx *ctx, kn_sink *out, const char *path);
// VTK unstructured grid (.vtu): Bezier curves, quadrilaterals and hexahedra of any degree, with RationalWeights and
// HigherOrderDegrees, and the numbers of part and surface as cell data: what ParaView draws exactly, and analysis takes
// volumes from. Splines go out piece by piece, trimmed surfaces and meshes as triangles. error: rational points are
// divided by their weights, pieces as kn_spline_to_bezier.
KN_API KN_CHECKED kn_status kn_vtu_sink(kn_ctx *ctx, kn_sink *out, const char *path);

// MFEM NURBS mesh (.mesh, v1.0): surfaces in space or volumes, each a patch with its knots and homogeneous control points.
// Vertices are one where their coordinates are equal bit for bit, edges and faces where their vertices are. Attributes
// of patches are 1 + part, of the boundary 1 + 2 variable + end.
// fails:  also KN_EDOMAIN an edge that is closed or a point, patches of both kinds, three patches at an edge of surfaces
//         or at a face: at the begin where the tile or the report tells; at the end edges or faces between the same
//         vertices with other control points; neighbours with other knots or degrees along a common variable; a ring
//         of patches that is twisted. Messages name the patch.
// memory: about 1 KiB for each patch, until the end. Runs cannot be noted.
KN_API KN_CHECKED kn_status kn_mfem_sink(kn_ctx *ctx, kn_sink *out, const char *path);
// POV-Ray scene (.pov): polynomial surfaces of degrees up to 3 as bicubic patches, all else as triangles with normals,
// curves as thin tubes; the materials of parts; a camera, lights and a floor that show all of it, z upwards.
// error: nine digits.
KN_API KN_CHECKED kn_status kn_pov_sink(kn_ctx *ctx, kn_sink *out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
