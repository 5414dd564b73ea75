// SPDX-License-Identifier: Apache-2.0
// Inside cad: a model as bytes. Numbers are little-endian: u32, and f64 as the 64 bits of a double.
//
//     "KNCAD" 0 0 2     the format's version, last byte of the eight
//     u32 nbodies, nvertices, nedges, nfaces
//     body:    name (64 bytes, zeros after its end), u32 solid, instances, 12 f64
//     vertex:  3 f64
//     edge:    u32 face[2], curve[2] (-1: 0xffffffff), flags (1 more, 2 point, 4 it has a line), f64 angle;
//              with a line u32 vertex[2], f64 error, spline
//     face:    name, u32 type, body, shell, flags (1 colored, 2 whole, 4 uses), f64 color[3], error, trim_error, spline,
//              u32 ncurves, nloops, loop_end.., edge.., splines; uses of all curves
//     use:     u32 flags (1 against, 2 it has a plane); that spline
//     spline:  u32 nvars, ncomp, rational, for each variable u32 degree, count, its knots, the coefficients
#ifndef CAD_STREAM_H
#define CAD_STREAM_H

#include <knurl/cad.h>

enum {
    KN_CAD_VERSION = 2,
    KN_CAD_BODY_BYTES = KN_NAME_BYTES + 2 * 4 + 12 * 8,
    KN_CAD_VERTEX_BYTES = 3 * 8,
    KN_CAD_EDGE_BYTES = 5 * 4 + 8,
    KN_CAD_FACE_BYTES = KN_NAME_BYTES + 4 * 4 + 5 * 8 + 3 * 4 + 2 * 4, // less what grows: the least
    KN_CAD_MORE = 1,
    KN_CAD_POINT = 2,
    KN_CAD_HAS_LINE = 4,
    KN_CAD_COLORED = 1,
    KN_CAD_WHOLE = 2,
    KN_CAD_USES = 4,
    KN_CAD_AGAINST = 1,
    KN_CAD_HAS_PLANE = 2,
};

#endif
