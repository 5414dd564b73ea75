// SPDX-License-Identifier: Apache-2.0
// kn_occt_write_knob, kn_occt_write_boxes.
#include <cmath>

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPConstruct.hxx>
#include <STEPControl_Writer.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <Transfer_FinderProcess.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferWriter.hxx>
#include <XSControl_WorkSession.hxx>
#include <gp_Ax1.hxx>
#include <gp_Trsf.hxx>

#include "bridges/occt/guard.hpp"
#include "bridges/occt/occt_knob.h"

namespace kn_occt
{
namespace
{

const double grip_radius = 12.0;

TopoDS_Shape revolved()
{
    const double profile[][2] = {{0, 0}, {6, 0}, {6, 8}, {grip_radius, 8}, {grip_radius, 20}, {0, 20}};
    BRepBuilderAPI_MakePolygon outline;
    for (const auto &p : profile) outline.Add(gp_Pnt(p[0], 0, p[1]));
    outline.Close();
    gp_Ax1 axis(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1));
    return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(outline.Wire()).Face(), axis).Shape();
}

TopoDS_Shape rounded(const TopoDS_Shape &shape)
{
    BRepFilletAPI_MakeFillet fillet(shape);
    for (TopExp_Explorer e(shape, TopAbs_EDGE); e.More(); e.Next()) {
        BRepAdaptor_Curve curve(TopoDS::Edge(e.Current()));
        if (curve.GetType() != GeomAbs_Circle || std::fabs(curve.Circle().Radius() - grip_radius) > 1e-9) continue;
        fillet.Add(curve.Circle().Location().Z() > 15 ? 1.5 : 1.0, TopoDS::Edge(e.Current()));
    }
    return fillet.Shape();
}

TopoDS_Shape paint(const Handle(TDocStd_Document) & document, const TopoDS_Shape &knob)
{
    TopoDS_Shape named;
    Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
    Handle(XCAFDoc_ColorTool) colors = XCAFDoc_DocumentTool::ColorTool(document->Main());
    TDF_Label part = shapes->AddShape(knob, Standard_False);
    TDataStd_Name::Set(part, "knob");
    colors->SetColor(part, Quantity_Color(0.6, 0.6, 0.65, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
    for (TopExp_Explorer e(knob, TopAbs_FACE); e.More(); e.Next()) {
        BRepAdaptor_Surface s(TopoDS::Face(e.Current()));
        bool grip = s.GetType() == GeomAbs_Cylinder && std::fabs(s.Cylinder().Radius() - grip_radius) < 1e-9;
        if (!grip && s.GetType() != GeomAbs_Torus) continue;
        TDF_Label face = shapes->AddSubShape(part, e.Current());
        if (grip) named = e.Current();
        colors->SetColor(face, grip ? Quantity_NOC_BLACK : Quantity_NOC_RED, XCAFDoc_ColorSurf);
    }
    return named;
}

} // namespace
} // namespace kn_occt

kn_status kn_occt_write_knob(kn_ctx *ctx, const char *path)
{
    return kn_occt::guarded(ctx, path, [&] {
        Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
        XCAFDoc_DocumentTool::Set(document->Main());
        TopoDS_Shape grip = kn_occt::paint(document, kn_occt::rounded(kn_occt::revolved()));
        STEPCAFControl_Writer writer;
        if (!writer.Transfer(document)) return kn_fail(ctx, KN_EUNDECIDED, "%s: OCCT cannot write it", path);
        Handle(StepRepr_RepresentationItem)
            face = STEPConstruct::FindEntity(writer.ChangeWriter().WS()->TransferWriter()->FinderProcess(), grip);
        if (!face.IsNull()) face->SetName(new TCollection_HAsciiString("grip")); // OCCT writes no names of faces
        if (writer.Write(path) != IFSelect_RetDone) return kn_fail(ctx, KN_EIO, "%s: cannot write", path);
        return KN_OK;
    });
}

kn_status kn_occt_write_boxes(kn_ctx *ctx, const char *path)
{
    return kn_occt::guarded(ctx, path, [&] {
        Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
        XCAFDoc_DocumentTool::Set(document->Main());
        Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
        TDF_Label assembly = shapes->NewShape();
        for (int i = 0; i < 2; i++) {
            gp_Trsf place;
            place.SetTranslation(gp_Vec(40.0 * i, 0, 0));
            TDF_Label part = shapes->AddShape(BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape(), Standard_False);
            shapes->AddComponent(assembly, part, TopLoc_Location(place));
        }
        shapes->UpdateAssemblies();
        STEPCAFControl_Writer writer;
        if (!writer.Transfer(document)) return kn_fail(ctx, KN_EUNDECIDED, "%s: OCCT cannot write it", path);
        if (writer.Write(path) != IFSelect_RetDone) return kn_fail(ctx, KN_EIO, "%s: cannot write", path);
        return KN_OK;
    });
}
