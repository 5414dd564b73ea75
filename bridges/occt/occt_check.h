// SPDX-License-Identifier: Apache-2.0
// Looking at a STEP file with Open CASCADE's eyes: what does another CAD system find in what knurl wrote?
#ifndef BRIDGES_OCCT_CHECK_H
#define BRIDGES_OCCT_CHECK_H

#include <knurl/base.h>

#ifdef __cplusplus
extern "C" {
#endif

// One OCCT reader at a time in a process: OCCT keeps its settings in globals.
typedef struct kn_occt_model kn_occt_model;

enum { KN_OCCT_COLOURS = 16 };

typedef struct kn_occt_report {
    int faces, shells, solids; // as OCCT has them: it gives unconnected faces a shell each; of an assembly, once
    int valid_faces;           // BRepCheck finds nothing wrong with them
    int first_invalid;         // the first of the others, -1: none
    int rational_faces;        // on rational surfaces
    int max_degree;            // of any surface
    double unit_mm;            // of the file's coordinates
    double max_tolerance;      // of faces, edges and vertices, mm
    int edges, vertices, free_edges;   // free: of one face only, seams and collapsed edges apart
    int closed_shells, placed_solids;  // placed: as often as the assembly has them
    bool valid;                        // BRepCheck finds nothing wrong with the whole
    double volume, area;               // of the solids, mm3; of all faces, mm2
    double centre[3], inertia[3];      // of the placed solids: of mass, mm; about it, along x, y, z, mm5
    double lo[3], hi[3];               // box of the control points, mm
    int ncolours;                      // different ones
    double colour[KN_OCCT_COLOURS][3]; // linear RGB
} kn_occt_report;

// Reads path (mm, whatever the file's unit). *out: kn_occt_close.
// fails: KN_EIO (cannot be opened), KN_EPARSE (OCCT makes nothing of it), KN_ENOMEM; *out unchanged.
KN_CHECKED kn_status kn_occt_open_step(kn_ctx *ctx, kn_occt_model **out, const char *path);
KN_CHECKED kn_status kn_occt_open_iges(kn_ctx *ctx, kn_occt_model **out, const char *path);
void kn_occt_close(kn_ctx *ctx, kn_occt_model *model); // NULL is fine

// Counts and checks. fails: KN_EUNDECIDED (OCCT threw: the message has its words), KN_ENOMEM; *out unchanged.
KN_CHECKED kn_status kn_occt_check(kn_ctx *ctx, kn_occt_report *out, const kn_occt_model *model);

// Face 0 <= face < report.faces, in the order of the file. point = its surface at (u,v), in mm; normal
// (NULL: not wanted) = the unit normal out of the face, orientation included. fails: KN_EDOMAIN (no such face),
// KN_EUNDEFINED (no normal there), KN_EUNDECIDED (OCCT threw).
KN_CHECKED kn_status kn_occt_eval(kn_ctx *ctx, double point[3], double *normal, const kn_occt_model *model, int face,
                                  double u, double v);
// The volume of all solids, mm3, by quadrature that goes on until it is within `part` of it as OCCT estimates that:
// report.volume is rough where faces are rational and of many spans. fails: KN_EUNDECIDED (OCCT threw).
KN_CHECKED kn_status kn_occt_volume(kn_ctx *ctx, double *out, const kn_occt_model *model, double part);
// Likewise the area of one face, mm2. fails: also KN_EDOMAIN.
KN_CHECKED kn_status kn_occt_area(kn_ctx *ctx, double *out, const kn_occt_model *model, int face, double part);
// The name of the face in the file, cut to bytes - 1 and ended by a zero byte. fails: KN_EDOMAIN.
KN_CHECKED kn_status kn_occt_face_name(kn_ctx *ctx, char *name, size_t bytes, const kn_occt_model *model, int face);

#ifdef __cplusplus
}
#endif
#endif
