// SPDX-License-Identifier: Apache-2.0
// What Open CASCADE itself says of the faces of a file that kn_occt_read reads; and files to try it on.
#ifndef BRIDGES_OCCT_PROBE_H
#define BRIDGES_OCCT_PROBE_H

#include <knurl/cad.h>

#ifdef __cplusplus
extern "C" {
#endif

// Shapes that OCCT makes, in the order of kn_occt_make's numbers.
typedef enum kn_occt_kind {
    KN_OCCT_BOX,      // 10 x 20 x 30
    KN_OCCT_CYLINDER, // radius 5, height 20
    KN_OCCT_SPHERE,   // radius 7
    KN_OCCT_TORUS,    // radii 10, 3
    KN_OCCT_CONE,     // radii 6 and 2, height 9
    KN_OCCT_APEX,     // a cone that ends in a point
    KN_OCCT_FILLET,   // the box with round edges
    KN_OCCT_DRILLED,  // the box with a hole across it, moved and turned
    KN_OCCT_KNOB,     // turned about an axis from a spline, with a fillet
    KN_OCCT_EXTRUDED, // a spline's loop along a skew direction
    KN_OCCT_SECTOR,   // a quarter of a torus
    KN_OCCT_SADDLE,   // a cylinder cut by a sphere: curves on it that are no lines
    KN_OCCT_HOLLOW,   // the rounded box, drilled, with a cylinder and a sphere inside that are not there
    KN_OCCT_KINDS
} kn_occt_kind;
// Writes it by the ending of path: .brep, .step, .igs. fails: KN_EDOMAIN, KN_EIO, KN_EUNDECIDED (OCCT threw).
KN_CHECKED kn_status kn_occt_make(kn_ctx *ctx, kn_occt_kind kind, const char *path);

typedef struct kn_occt_probe kn_occt_probe;
// *out, and cad as kn_occt_read makes it. fails: as that; both unchanged.
KN_CHECKED kn_status kn_occt_probe_open(kn_ctx *ctx, kn_occt_probe **out, kn_cad *cad, const char *path);
void kn_occt_probe_close(kn_ctx *ctx, kn_occt_probe *probe); // NULL is fine

typedef struct kn_occt_place {
    double distance;  // from the point to the face's surface, as OCCT projects it
    double normal[3]; // out of the body, unit length; zeros where there is none
    int inside;       // 1: in the face, 0: on its border, within tolerance of it, -1: outside
    double u, v;
} kn_occt_place;
// The point's projection on the face's surface. tolerance: in OCCT's parameters.
KN_CHECKED kn_status kn_occt_probe_face(kn_ctx *ctx, kn_occt_place *out, const kn_occt_probe *probe, int face,
                                        const double point[3], double tolerance);
// 1: in the body, 0: on its border, -1: outside.
KN_CHECKED kn_status kn_occt_probe_body(kn_ctx *ctx, int *out, const kn_occt_probe *probe, int body,
                                        const double point[3], double tolerance);

#ifdef __cplusplus
}
#endif
#endif
