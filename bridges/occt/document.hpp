// SPDX-License-Identifier: Apache-2.0
// A CAD file as OCCT holds it: bodies and their faces, with what the file says of them.
#ifndef BRIDGES_OCCT_DOCUMENT_HPP
#define BRIDGES_OCCT_DOCUMENT_HPP

#include <string>
#include <vector>

#include <TDocStd_Document.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Trsf.hxx>

#include <knurl/base.h>

namespace kn_occt
{

struct body {
    TopoDS_Shape shape; // solid, shell, or a compound of loose faces; in the coordinates of its part
    std::string name;   // of its part
    int instances;
    gp_Trsf place; // of the first
};

struct face {
    TopoDS_Face shape; // with its orientation in the body
    std::string name;
    int body;
    int shell; // of the body; 0: the outer one
    bool colored;
    double color[3]; // linear RGB
};

struct document {
    Handle(TDocStd_Document) xcaf; // keeps it alive; null for BREP
    std::vector<body> bodies;
    std::vector<face> faces;        // body by body, as the shells have them
    std::vector<TopoDS_Edge> edges; // those of the kn_cad, once model_of has made it
    int unread = 0;                 // faces of a STEP file that OCCT could make nothing of
    std::string first_unread;
};

// STEP, IGES or BREP, by the first bytes; lengths in mm. Throws failed (after kn_fail), and what OCCT throws.
// fails: KN_EIO, KN_EPARSE: no such format, a STEP file that does not end, no faces.
void read_document(kn_ctx *ctx, document *out, const char *path);

} // namespace kn_occt

#endif
