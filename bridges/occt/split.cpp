// SPDX-License-Identifier: Apache-2.0
// Edges of a model cut at points, wherever they are used; all else stays as it is.
#include "bridges/occt/split.hpp"

#include <BRepAdaptor_Curve.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Precision.hxx>
#include <ShapeAnalysis_Curve.hxx>
#include <TDF_LabelSequence.hxx>
#include <TNaming_Builder.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace kn_occt
{
namespace
{

TopoDS_Shape plain(const TopoDS_Shape &shape)
{
    return shape.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD);
}

struct site {
    gp_Pnt point;
    double at; // parameter of the edge
};

std::string where(const gp_Pnt &p)
{
    char text[96];
    std::snprintf(text, sizeof text, "%.6g, %.6g, %.6g", p.X(), p.Y(), p.Z());
    return text;
}

// The points' parameters, ascending or descending: *along tells.
void find_sites(std::vector<site> &sites, bool *along, const TopoDS_Edge &edge, const std::vector<gp_Pnt> &points,
                double tolerance, double *gap)
{
    BRepAdaptor_Curve curve(edge);
    const double first = curve.FirstParameter(), last = curve.LastParameter();
    const size_t n = points.size();
    sites.resize(n);
    for (size_t i = 0; i < n; i++) {
        gp_Pnt foot;
        sites[i].point = points[i];
        const double off = ShapeAnalysis_Curve().Project(curve, points[i], Precision::Confusion(), foot, sites[i].at,
                                                         false);
        if (!(off <= tolerance))
            throw split_error("point " + where(points[i]) + " is " + std::to_string(off) +
                              " mm from the edge that it is to cut");
        *gap = std::max(*gap, off);
    }
    *along = sites[1].at < sites[2].at;
    sites[0].at = *along ? first : last;
    sites[n - 1].at = *along ? last : first;
    for (size_t i = 0; i + 1 < n; i++)
        if ((sites[i].at < sites[i + 1].at) != *along)
            throw split_error("the points along an edge are not in order at " + where(points[i]));
    for (size_t end = 0; end < 2; end++)
        if (!(curve.Value(end == 0 ? sites[0].at : sites[n - 1].at).Distance(points[end == 0 ? 0 : n - 1]) <=
              tolerance))
            throw split_error("an edge does not end at " + where(points[end == 0 ? 0 : n - 1]));
}

// The same, from the other end.
void turn(std::vector<part> &list)
{
    std::reverse(list.begin(), list.end());
    for (part &p : list) {
        std::swap(p.vertex[0], p.vertex[1]);
        p.along = !p.along;
    }
}

// For another face: the parts that there are, if they are these. known: along the edge.
void cut_again(const std::vector<part> &known, const std::vector<gp_Pnt> &points, bool along, double tolerance,
               std::vector<part> &out)
{
    std::vector<part> list = known;
    if (!along) turn(list);
    bool same = 3 * list.size() + 1 == points.size();
    for (size_t i = 0; i < list.size() && same; i++)
        for (size_t k = 0; k < 2; k++)
            same = same && BRep_Tool::Pnt(list[i].vertex[k]).Distance(points[3 * (i + k)]) <= tolerance;
    if (!same) throw split_error("the textures on both sides of an edge do not meet: give both the same cells there");
    out = list;
}

} // namespace

void splitter::cut(const TopoDS_Edge &given, const std::vector<gp_Pnt> &points, double tolerance,
                   std::vector<part> &out)
{
    const TopoDS_Edge edge = TopoDS::Edge(given.Oriented(TopAbs_FORWARD));
    std::vector<site> sites;
    bool along = true;
    find_sites(sites, &along, edge, points, tolerance, &widest);
    const size_t n = (points.size() - 1) / 3;
    if (const std::vector<part> *known = done.Seek(plain(edge))) {
        cut_again(*known, points, along, tolerance, out);
        return;
    }
    BRep_Builder builder;
    TopoDS_Vertex ends[2];
    TopExp::Vertices(edge, ends[0], ends[1]);
    if (ends[0].IsNull() || ends[1].IsNull()) throw split_error("an edge without ends");
    std::vector<TopoDS_Vertex> vertices(n + 1);
    vertices[0] = along ? ends[0] : ends[1];
    vertices[n] = along ? ends[1] : ends[0];
    for (size_t i = 1; i < n; i++) {
        gp_Pnt on = BRepAdaptor_Curve(edge).Value(sites[3 * i].at);
        builder.MakeVertex(vertices[i], sites[3 * i].point,
                           std::max(BRep_Tool::Tolerance(edge), 1.01 * on.Distance(sites[3 * i].point)));
    }
    std::vector<TopoDS_Shape> list(n); // along the edge
    out.resize(n);
    for (size_t i = 0; i < n; i++) {
        const size_t from = along ? i : i + 1, to = along ? i + 1 : i;
        TopoDS_Edge part = edge;
        if (n > 1) {
            part = TopoDS::Edge(edge.EmptyCopied());
            builder.Add(part, vertices[from].Oriented(TopAbs_FORWARD));
            builder.Add(part, vertices[to].Oriented(TopAbs_REVERSED));
            builder.Range(part, sites[3 * from].at, sites[3 * to].at);
        }
        out[i] = {part, {vertices[i], vertices[i + 1]}, along};
        list[along ? i : n - 1 - i] = plain(part);
    }
    if (n > 1) parts.Bind(plain(edge), list);
    std::vector<part> known = out;
    if (!along) turn(known);
    done.Bind(plain(edge), known);
}

TopoDS_Shape splitter::build(const TopoDS_Shape &shape)
{
    if (shape.ShapeType() == TopAbs_VERTEX || shape.ShapeType() == TopAbs_EDGE) return shape;
    std::vector<TopoDS_Shape> children;
    bool changed = false;
    for (TopoDS_Iterator i(shape, false, false); i.More(); i.Next()) {
        const TopoDS_Shape &child = i.Value();
        const std::vector<TopoDS_Shape> *cuts = parts.Seek(plain(child));
        if (cuts == nullptr) {
            children.push_back(apply(child));
            changed = changed || !children.back().IsSame(child);
            continue;
        }
        changed = true;
        bool turned = child.Orientation() == TopAbs_REVERSED;
        for (size_t k = 0; k < cuts->size(); k++) {
            const TopoDS_Shape &part = (*cuts)[turned ? cuts->size() - 1 - k : k];
            children.push_back(part.Located(child.Location()).Oriented(child.Orientation()));
        }
    }
    if (!changed) return shape;
    BRep_Builder builder;
    TopoDS_Shape copy = shape.EmptyCopied();
    for (const TopoDS_Shape &child : children) builder.Add(copy, child);
    copy.Closed(shape.Closed());
    return copy;
}

TopoDS_Shape splitter::apply(const TopoDS_Shape &shape)
{
    if (shape.IsNull() || parts.IsEmpty()) return shape;
    TopoDS_Shape key = plain(shape);
    if (!made.IsBound(key)) made.Bind(key, build(key));
    return made.Find(key).Located(shape.Location()).Oriented(shape.Orientation());
}

void splitter::apply_to(const Handle(TDocStd_Document) & document)
{
    if (parts.IsEmpty()) return;
    Handle(XCAFDoc_ShapeTool) tool = XCAFDoc_DocumentTool::ShapeTool(document->Main());
    TDF_LabelSequence labels;
    tool->GetShapes(labels);
    for (int i = 1; i <= labels.Length(); i++) {
        const TDF_Label label = labels.Value(i);
        if (!XCAFDoc_ShapeTool::IsSimpleShape(label)) continue;
        TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label), other = apply(shape);
        if (other.IsSame(shape)) continue;
        TDF_LabelSequence subs;
        XCAFDoc_ShapeTool::GetSubShapes(label, subs);
        std::vector<TopoDS_Shape> old;
        for (int k = 1; k <= subs.Length(); k++) old.push_back(XCAFDoc_ShapeTool::GetShape(subs.Value(k)));
        tool->SetShape(label, other);
        for (int k = 1; k <= subs.Length(); k++) {
            TopoDS_Shape now = apply(old[static_cast<size_t>(k - 1)]);
            if (!now.IsSame(old[static_cast<size_t>(k - 1)])) TNaming_Builder(subs.Value(k)).Generated(now);
        }
    }
    tool->UpdateAssemblies();
}

} // namespace kn_occt
