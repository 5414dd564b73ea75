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
    double error;      // bound or estimate of the distance from the file's surface, mm; 0: the same, up to rounding
    double trim_error; // likewise of its edges from the file's, mm: curves of the trim are polynomials
    // In the square [0,1]^2 that stands for the surface's domain, never empty; curve k lies along edge[k].
    kn_trim trim;
    int *edge;
    bool whole; // the trim is the whole square: one loop along its sides
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
    int instances;            // places that it has in the file's assembly, 1 or more
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

// "plane", "cylinder", "cone", "sphere", "torus", "extrusion", "revolution", "bezier", "bspline", "offset", "other";
// NULL for what is no type. Static storage.
KN_API const char *kn_cad_type_name(kn_cad_type type);

// KN_OK, or KN_EDOMAIN with a message that names the face, edge or body: numbers of a face, curve, edge or body that
// there is not, an edge and a curve that do not name each other, a surface that is none in three dimensions, an empty
// trim, one called whole that is not, colours outside [0,1], an angle outside [0, pi], a placement or an error that is
// not finite or negative, a name that does not end or has control characters. Also what kn_spline_check and
// kn_trim_check find, and KN_ENOMEM.
KN_API KN_CHECKED kn_status kn_cad_check(kn_ctx *ctx, const kn_cad *cad);

// The model as bytes (version 1; little-endian, doubles as IEEE 754 has them), for kn_cad_parse on any machine.
// in:    what kn_cad_check accepts.
// out:   *data, *bytes of it: kn_free.
// fails: KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_cad_write(kn_ctx *ctx, unsigned char **data, size_t *bytes, const kn_cad *cad);
// The way back, bit for bit. name stands for the bytes in messages.
// in:    any bytes.
// out:   overwritten (what it held is cleared); kn_cad_clear. kn_cad_check accepts it.
// fails: KN_EPARSE, "name: byte N: what": not such bytes, another version, counts that cannot fit the bytes that
//        follow, bytes that are missing or left over; KN_EDOMAIN, KN_ELIMIT what kn_cad_check finds; KN_ENOMEM. out
//        unchanged.
// cost:  nothing is allocated for a count before it is known to fit.
KN_API KN_CHECKED kn_status kn_cad_parse(kn_ctx *ctx, kn_cad *out, const char *name, const unsigned char *data,
                                         size_t bytes);

#ifdef __cplusplus
}
#endif
#endif
