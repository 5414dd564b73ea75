// SPDX-License-Identifier: Apache-2.0
// Inside bridges/occt: edges of a model cut at points, wherever they are used; all else stays as it is.
#ifndef BRIDGES_OCCT_SPLIT_HPP
#define BRIDGES_OCCT_SPLIT_HPP

#include <NCollection_DataMap.hxx>
#include <TDocStd_Document.hxx>
#include <TopTools_ShapeMapHasher.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <gp_Pnt.hxx>

#include <stdexcept>
#include <vector>

namespace kn_occt
{

struct split_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// One part of an edge that was cut, in the direction of the points: from vertex[0] to vertex[1].
struct part {
    TopoDS_Edge edge;
    TopoDS_Vertex vertex[2];
    bool along; // the edge's curve runs that way, too
};

class splitter
{
  public:
    // Points 0, 3, 6 .. along the edge, either way, from one end to the other, are where the parts begin and end, the
    // two between lie on them, in their order; all within the tolerance of the edge. Parts have the edge's own curve;
    // a single one is the edge itself. An edge that is cut again, from its other face, is to be cut at the same places.
    // Throws split_error.
    void cut(const TopoDS_Edge &given, const std::vector<gp_Pnt> &points, double tolerance, std::vector<part> &out);
    // What a shape has become.
    TopoDS_Shape apply(const TopoDS_Shape &shape);
    // All shapes of the document, with the labels of their subshapes.
    void apply_to(const Handle(TDocStd_Document) & document);
    // The most that any of the points was off its edge.
    double gap() const
    {
        return widest;
    }

  private:
    double widest = 0.0;
    TopoDS_Shape build(const TopoDS_Shape &shape);
    NCollection_DataMap<TopoDS_Shape, std::vector<TopoDS_Shape>, TopTools_ShapeMapHasher> parts; // by the whole edge
    NCollection_DataMap<TopoDS_Shape, std::vector<part>, TopTools_ShapeMapHasher> done;          // likewise, along it
    NCollection_DataMap<TopoDS_Shape, TopoDS_Shape, TopTools_ShapeMapHasher> made;
};

} // namespace kn_occt

#endif
