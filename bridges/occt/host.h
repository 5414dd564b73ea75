// SPDX-License-Identifier: Apache-2.0
// The body that a texture takes a place in, written by Open CASCADE.
//
// A request, and what comes back, are words between white space:
//     knurl-host 1
//     faces N  f ..               faces of the model that the texture replaces; 0: none, the whole document as it is
//     tolerance T                 mm, of the points that follow
//     edge E N  x y z ..          3 N + 1 points along edge E of the model: ends of its N parts, two inside each
//     end
// and
//     knurl-host 1
//     context #                   GEOMETRIC_REPRESENTATION_CONTEXT
//     gap G                       mm, the most that points of the request are off their edges
//     shell # closed N  # ..      once for each that loses faces: its number, 1 or 0, the faces that stay
//     face f s                    for each replaced face: the place of its shell in that list
//     edge E N                    for each edge of the request, then for each part, in the order of its points:
//       # # # along               EDGE_CURVE, VERTEX_POINT where it starts and ends, 1: EDGE_CURVE runs that way
//     entities NUMBERS BYTES      then a newline, and the entities, "#n=..;" line by line, n <= NUMBERS
#ifndef BRIDGES_OCCT_HOST_H
#define BRIDGES_OCCT_HOST_H

#include <knurl/base.h>

#ifdef __cplusplus
extern "C" {
#endif

// Numbers of faces and edges are those that kn_occt_read_cad gives them. schema: "AP203", "AP214" or "AP242".
// out: *text, *bytes of it: kn_free. fails: KN_EIO, KN_EPARSE the file or the request; KN_EDOMAIN no such face or edge,
// points off an edge; KN_EUNDECIDED OCCT threw; KN_ENOMEM; out unchanged.
KN_CHECKED kn_status kn_occt_write_host(kn_ctx *ctx, char **text, size_t *bytes, const char *path,
                                        const char *request, size_t request_bytes, const char *schema);

#ifdef __cplusplus
}
#endif
#endif
