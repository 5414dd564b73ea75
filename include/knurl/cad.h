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

// How a curve of a trim lies along its edge.
typedef struct kn_cad_use {
    // In the square, over the domain of the edge's line: where that point of the edge is, within kn_cad_edge.error. It
    // has the ends of the trim's curve. Empty: not known.
    kn_spline plane;
    bool against; // the trim's curve runs the other way
} kn_cad_use;

typedef struct kn_cad_face {
    char name[KN_NAME_BYTES]; // UTF-8; "": none
    kn_cad_type type;
    int body;
    int shell; // of the body, by which it is closed by itself; 0: the outer one, others are around voids
    bool colored;
    double color[3]; // linear RGB
    // Over the box of the face's trim, in millimetres, in the coordinates of its body; Su x Sv looks out of it.
    kn_spline surface;
    double error;      // bound or estimate of the distance from the file's surface, mm; 0: the same, up to rounding
    double trim_error; // likewise of its edges from the file's, mm: curves of the trim are polynomials
    // In the square [0,1]^2 that stands for the surface's domain, never empty; curve k lies along edge[k].
    kn_trim trim;
    int *edge;
    kn_cad_use *use; // of each curve; NULL: nothing is known
    bool whole;      // the trim is the whole square: one loop along its sides
} kn_cad_face;

typedef struct kn_cad_edge {
    // The uses of the edge: a face and the curve of its trim. face[1] -1: the edge is open. A seam is used twice by one
    // face. An edge of more than two faces has the first two, and `more`.
    int face[2], curve[2];
    bool more;
    bool point;   // collapsed to one: the pole of a sphere
    double angle; // the largest between the outward normals of its two faces, of some along it, radians
    // In millimetres, as the file has it; empty: not known, as of points. Then, where it starts and ends, and how far it
    // may be from these and from its faces, mm, as the file says or as measured at some places, whichever is more.
    kn_spline line;
    int vertex[2];
    double error;
} kn_cad_edge;

typedef struct kn_cad_vertex {
    double at[3]; // mm
} kn_cad_vertex;

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
    kn_cad_vertex *vertices; // of edges that have lines
    int nvertices;
    kn_cad_body *bodies;
    int nbodies;
} kn_cad;
KN_API void kn_cad_clear(kn_ctx *ctx, kn_cad *cad); // leaves it empty; NULL is fine

// "plane", "cylinder", "cone", "sphere", "torus", "extrusion", "revolution", "bezier", "bspline", "offset", "other";
// NULL for what is no type. Static storage.
KN_API const char *kn_cad_type_name(kn_cad_type type);

// KN_OK, or KN_EDOMAIN with a message that names the face, edge or body: numbers of a face, curve, edge or body that
// there is not, an edge and a curve that do not name each other, a surface that is none in three dimensions, an empty
// trim, one called whole that is not, colours outside [0,1], an angle outside [0, pi], a placement or an error that
// is not finite or negative, a name that does not end or has control characters; an edge's line that is none in three
// dimensions, or ends further than its error from its vertices; a use's plane without such a line, of another domain, or with
// other ends than the trim's curve. Also what kn_spline_check and kn_trim_check find, and KN_ENOMEM.
KN_API KN_CHECKED kn_status kn_cad_check(kn_ctx *ctx, const kn_cad *cad);

// The model as bytes (version 2; little-endian, doubles as IEEE 754 has them), for kn_cad_parse on any machine.
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

// ---- several faces ----

// Zero means the default in every field.
typedef struct kn_cad_join_options {
    double angle;     // radians, up to which faces meet smoothly; 0: one degree
    double tolerance; // mm, by which control points may be moved; 0: 1e-3
    bool none;        // nothing is joined: only the report
} kn_cad_join_options;

// An edge between two of the faces, and what became of it.
typedef struct kn_cad_seam {
    int edge, face[2]; // of the model
    bool joined;
    const char *why; // not: "angle", ..; static storage; NULL: joined
    double angle;    // between the normals along it, the largest at 33 places, radians
    double moved;    // a bound of how far either surface was moved along it, mm
} kn_cad_seam;

// Surfaces for a job, one for each face, in their order. Zero is empty.
typedef struct kn_cad_joined {
    kn_spline *surfaces;
    kn_trim *trims; // empty where a face is the whole of its surface
    int *turns;     // 0 .. 3 quarter turns of each from the model's face, (u,v) -> (1 - v, u)
    int n;
    kn_cad_seam *seams; // of all edges between two different ones of the faces
    int nseams;
    double moved; // the most
} kn_cad_joined;
KN_API void kn_cad_joined_clear(kn_ctx *ctx, kn_cad_joined *joined); // leaves it empty; NULL is fine

// Faces side by side as surfaces that a job takes as one domain: where two of them meet smoothly along an edge that is
// a whole side of both, with the same curve on both but for direction and an affine change of its parameter, they get
// the same degrees and knots along it and the same control points, bit for bit. Elsewhere they stay apart.
// in:     a model that kn_cad_check accepts; n different faces of it (else KN_EDOMAIN). options NULL: the defaults.
// out:    initialised, overwritten; seams in the order of the model's edges. Surfaces that are joined are all
//         rational where one of them is, run over [0,1] along their common edges, and are turned by quarter turns,
//         with their trims, so that directions go on from the first face of each group as far as they can. why:
//         "angle", "part of a side" (the edge is no whole side of both), "more faces", "a point", "parameter lines"
//         (other curves, or others' parameters), "turned round" (joined faces lead back to this edge in the other
//         direction), "not wanted".
// fails:  KN_EDOMAIN, KN_ELIMIT (degrees, knots), KN_ENOMEM; out unchanged.
// error:  *moved: control points of a side that moved by d move the surface by d at most; weights that differ by a
//         part e, by 4 e times the size of the surface. Not counted: knots that differ by at most 1e-8 of the domain
//         become one, which moves the surface by up to that times its derivative.
KN_API KN_CHECKED kn_status kn_cad_join(kn_ctx *ctx, kn_cad_joined *out, const kn_cad *cad, const int *faces, int n,
                                        const kn_cad_join_options *options);

// The faces that a text names, joined by '+', what all of several say by '&', which binds closer:
//     3  0,4,7-9              numbers and ranges
//     name:TEXT  body:TEXT    names, letters of either case; * stands for any text, ? for one character. body: also
//                             the number of one
//     type:TYPE               kn_cad_type_name
//     color:#rrggbb           sRGB, to within 1 of 255
//     near:X,Y,Z              the one that is nearest to the point, of those that all else between '&' holds for
// out:    *faces, *n >= 1 of them, increasing: kn_free. Overwritten.
// fails:  KN_EDOMAIN: no such text, or a part of it that no face agrees with: the message says what there is.
//         KN_ENOMEM, KN_ECANCELLED; out unchanged.
// error:  near: where the nearest point of a surface lies inside the trim, certified (kn_solve_closest); else the
//         nearest of points along the trim (64 a span, refined) and of a grid of 33 x 33 inside it.
KN_API KN_CHECKED kn_status kn_cad_find(kn_ctx *ctx, int **faces, int *n, const kn_cad *cad, const char *text);

#ifdef __cplusplus
}
#endif
#endif
