// SPDX-License-Identifier: Apache-2.0
// Models from CAD files: bodies of trimmed faces, with names, colours, and what is next to what.
#ifndef KNURL_CAD_H
#define KNURL_CAD_H

#include <knurl/tile.h>
#include <knurl/trim.h>

#ifdef __cplusplus
extern "C" {
#endif

// What a face is in its file; all are splines here.
typedef enum kn_cad_type {
    KN_CAD_PLANE,
    KN_CAD_CYLINDER,
    KN_CAD_CONE,
    KN_CAD_SPHERE,
    KN_CAD_TORUS,
    KN_CAD_EXTRUSION,
    KN_CAD_REVOLUTION,
    KN_CAD_BEZIER,
    KN_CAD_BSPLINE,
    KN_CAD_OFFSET,
    KN_CAD_OTHER,
    KN_CAD_TYPES
} kn_cad_type;

typedef struct kn_cad_face {
    char name[KN_NAME_BYTES]; // UTF-8; "": none
    kn_cad_type type;
    int body;
    bool colored;
    double color[3]; // linear RGB
    // Over the box of the face's trim, in millimetres, in the coordinates of its body; Su x Sv looks out of it.
    kn_spline surface;
    double error; // bound or estimate of the distance from the file's surface, mm; 0: the same one, up to rounding
    // In the square [0,1]^2 that stands for the surface's domain, never empty; curve k lies along edge[k].
    kn_trim trim;
    int *edge;
    bool whole; // the trim is the whole square
} kn_cad_face;

typedef struct kn_cad_edge {
    // The uses of the edge: a face and the curve of its trim. face[1] -1: the edge is open. A seam is used twice by one
    // face. An edge of more than two faces has the first two, and `more`.
    int face[2], curve[2];
    bool more;
    bool point;   // collapsed to one: the pole of a sphere
    double angle; // the largest between the outward normals of its two faces, of some along it, radians
} kn_cad_edge;

typedef struct kn_cad_body {
    char name[KN_NAME_BYTES]; // of its part
    bool solid;               // closed, and said to be a solid
    int instances;            // places that it has in the file's assembly
    double place[12];         // the first of them, by rows: x' = place[0..2] x + place[3]
} kn_cad_body;

// A zero-initialised kn_cad is a valid empty one; kn_cad_clear ends it.
typedef struct kn_cad {
    kn_cad_face *faces; // in the order of the file
    int nfaces;
    kn_cad_edge *edges;
    int nedges;
    kn_cad_body *bodies;
    int nbodies;
} kn_cad;
KN_API void kn_cad_clear(kn_ctx *ctx, kn_cad *cad); // leaves it empty; NULL is fine

#ifdef __cplusplus
}
#endif
#endif
