// SPDX-License-Identifier: Apache-2.0
// kn_occt_*: reads STEP through Open CASCADE and asks it what it thinks of the result.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <STEPControl_Reader.hxx>
#include <StepShape_AdvancedFace.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include "bridges/occt/guard.hpp"
#include "bridges/occt/occt_check.h"

struct kn_occt_model {
    STEPCAFControl_Reader reader;
    IGESCAFControl_Reader iges_reader;
    bool iges = false; // read by the second one
    Handle(TDocStd_Document) document;
    TopoDS_Shape shape;
    std::vector<TopoDS_Face> faces; // in the order of the file: OCCT takes unconnected shells apart
    std::vector<TCollection_AsciiString> names;
};

using kn_occt::guarded;

namespace
{

void collect_faces(kn_occt_model *m)
{
    const Handle(XSControl_WorkSession) &session = m->reader.Reader().WS();
    const Handle(Transfer_TransientProcess) &process = session->TransferReader()->TransientProcess();
    const Handle(Interface_InterfaceModel) &entities = session->Model();
    for (int i = 1; i <= entities->NbEntities(); i++) {
        Handle(StepShape_AdvancedFace) entity = Handle(StepShape_AdvancedFace)::DownCast(entities->Value(i));
        if (entity.IsNull()) continue;
        for (TopExp_Explorer e(TransferBRep::ShapeResult(process, entity), TopAbs_FACE); e.More(); e.Next()) {
            m->faces.push_back(TopoDS::Face(e.Current()));
            m->names.push_back(entity->Name().IsNull() ? TCollection_AsciiString() : entity->Name()->String());
        }
    }
}

// Faces (510), trimmed surfaces (144) and surfaces (128), each once: those that are there in the result.
void collect_iges_faces(kn_occt_model *m)
{
    const Handle(XSControl_WorkSession) &session = m->iges_reader.WS();
    const Handle(Transfer_TransientProcess) &process = session->TransferReader()->TransientProcess();
    const Handle(Interface_InterfaceModel) &entities = session->Model();
    TopTools_IndexedMapOfShape there, taken;
    TopExp::MapShapes(m->shape, TopAbs_FACE, there);
    for (int i = 1; i <= entities->NbEntities(); i++) {
        Handle(IGESData_IGESEntity) entity = Handle(IGESData_IGESEntity)::DownCast(entities->Value(i));
        int type = entity.IsNull() ? 0 : entity->TypeNumber();
        if (type != 510 && type != 144 && type != 128) continue;
        TopoDS_Shape shape = TransferBRep::ShapeResult(process, entity);
        if (shape.IsNull()) continue;
        for (TopExp_Explorer e(shape, TopAbs_FACE); e.More(); e.Next()) {
            int at = there.FindIndex(e.Current());
            if (at == 0 || taken.Contains(e.Current())) continue;
            taken.Add(e.Current());
            m->faces.push_back(TopoDS::Face(there(at))); // as it is turned there
            Handle(TCollection_HAsciiString) name = entity->NameValue();
            m->names.push_back(name.IsNull() ? TCollection_AsciiString() : name->String());
        }
    }
}

kn_status load_iges(kn_ctx *ctx, kn_occt_model *m, const char *path)
{
    m->iges = true;
    m->iges_reader.SetColorMode(Standard_True);
    m->iges_reader.SetNameMode(Standard_True);
    if (m->iges_reader.ReadFile(path) != IFSelect_RetDone)
        return kn_fail(ctx, KN_EPARSE, "%s: OCCT cannot read it", path);
    m->document = new TDocStd_Document("BinXCAF");
    XCAFDoc_DocumentTool::Set(m->document->Main());
    if (!m->iges_reader.Transfer(m->document)) return kn_fail(ctx, KN_EPARSE, "%s: OCCT finds no shape in it", path);
    m->shape = m->iges_reader.OneShape();
    collect_iges_faces(m);
    return KN_OK;
}

kn_status load(kn_ctx *ctx, kn_occt_model *m, const char *path)
{
    m->reader.SetColorMode(Standard_True);
    m->reader.SetNameMode(Standard_False); // those of faces come from the entities themselves
    if (m->reader.ReadFile(path) != IFSelect_RetDone) return kn_fail(ctx, KN_EPARSE, "%s: OCCT cannot read it", path);
    m->document = new TDocStd_Document("BinXCAF");
    XCAFDoc_DocumentTool::Set(m->document->Main());
    if (!m->reader.Transfer(m->document)) return kn_fail(ctx, KN_EPARSE, "%s: OCCT finds no shape in it", path);
    m->shape = m->reader.ChangeReader().OneShape();
    collect_faces(m);
    return KN_OK;
}

int count(const TopoDS_Shape &shape, TopAbs_ShapeEnum kind)
{
    TopTools_IndexedMapOfShape map;
    TopExp::MapShapes(shape, kind, map);
    return map.Extent();
}

double unit_in_mm(const kn_occt_model *m)
{
    if (m->iges) {
        Handle(IGESData_IGESModel) model = Handle(IGESData_IGESModel)::DownCast(m->iges_reader.WS()->Model());
        return model->GlobalSection().UnitFlag() == 2 ? 1.0 : 0.0;
    }
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    const_cast<STEPControl_Reader &>(m->reader.Reader()).FileUnits(lengths, angles, solid_angles);
    if (lengths.Length() != 1) return 0.0;
    if (lengths.First().IsEqual("millimetre")) return 1.0;
    if (lengths.First().IsEqual("centimetre")) return 10.0;
    if (lengths.First().IsEqual("metre")) return 1000.0;
    if (lengths.First().IsEqual("INCH") || lengths.First().IsEqual("inch")) return 25.4;
    return 0.0;
}

void check_face(kn_occt_report &report, Bnd_Box &box, const TopoDS_Face &face, int index)
{
    if (report.valid || BRepCheck_Analyzer(face).IsValid()) // of a valid whole all faces are
        report.valid_faces++;
    else if (report.first_invalid < 0)
        report.first_invalid = index;
    report.max_tolerance = std::fmax(report.max_tolerance, BRep_Tool::Tolerance(face));
    for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next())
        report.max_tolerance = std::fmax(report.max_tolerance, BRep_Tool::Tolerance(TopoDS::Edge(e.Current())));
    for (TopExp_Explorer e(face, TopAbs_VERTEX); e.More(); e.Next())
        report.max_tolerance = std::fmax(report.max_tolerance, BRep_Tool::Tolerance(TopoDS::Vertex(e.Current())));
    Handle(Geom_BSplineSurface) surface = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(face));
    if (surface.IsNull()) return;
    report.rational_faces += surface->IsURational() || surface->IsVRational();
    int degree = std::max(surface->UDegree(), surface->VDegree());
    if (degree > report.max_degree) report.max_degree = degree;
    for (int i = 1; i <= surface->NbUPoles(); i++)
        for (int j = 1; j <= surface->NbVPoles(); j++) box.Add(surface->Pole(i, j));
}

// Shapes of a kind, counted once however often and wherever they are placed.
int count_once(const TopoDS_Shape &shape, TopAbs_ShapeEnum kind)
{
    TopTools_IndexedMapOfShape map;
    for (TopExp_Explorer e(shape, kind); e.More(); e.Next()) map.Add(e.Current().Located(TopLoc_Location()));
    return map.Extent();
}

void check_topology(kn_occt_report &report, const TopoDS_Shape &shape)
{
    TopTools_IndexedDataMapOfShapeListOfShape faces_of;
    GProp_GProps area, all;
    report.edges = count(shape, TopAbs_EDGE);
    report.vertices = count(shape, TopAbs_VERTEX);
    TopExp::MapShapesAndAncestors(shape, TopAbs_EDGE, TopAbs_FACE, faces_of);
    for (int i = 1; i <= faces_of.Extent(); i++) {
        const TopoDS_Edge &edge = TopoDS::Edge(faces_of.FindKey(i));
        report.free_edges += !BRep_Tool::Degenerated(edge) && faces_of(i).Extent() == 1;
    }
    for (TopExp_Explorer e(shape, TopAbs_SHELL); e.More(); e.Next())
        report.closed_shells += BRep_Tool::IsClosed(e.Current());
    for (TopExp_Explorer e(shape, TopAbs_SOLID); e.More(); e.Next()) {
        GProp_GProps one;
        // without a tolerance it takes Gauss points by degrees alone, and is 3e-5 off for a plain rod
        BRepGProp::VolumeProperties(e.Current(), one, 1e-10);
        report.volume += one.Mass();
        all.Add(one);
        report.placed_solids++;
    }
    for (int c = 0; c < 3 && report.placed_solids > 0; c++) {
        report.centre[c] = all.CentreOfMass().Coord(c + 1);
        report.inertia[c] = all.MatrixOfInertia().Value(c + 1, c + 1);
    }
    BRepGProp::SurfaceProperties(shape, area);
    report.area = area.Mass();
    report.valid = BRepCheck_Analyzer(shape).IsValid();
}

void list_colours(kn_occt_report *report, const kn_occt_model *m)
{
    Handle(XCAFDoc_ColorTool) tool = XCAFDoc_DocumentTool::ColorTool(m->document->Main());
    TDF_LabelSequence labels;
    tool->GetColors(labels);
    report->ncolours = labels.Length();
    for (int i = 0; i < report->ncolours && i < KN_OCCT_COLOURS; i++) {
        Quantity_Color colour;
        if (!tool->GetColor(labels.Value(i + 1), colour)) continue;
        report->colour[i][0] = colour.Red();
        report->colour[i][1] = colour.Green();
        report->colour[i][2] = colour.Blue();
    }
}

} // namespace

static kn_status open_model(kn_ctx *ctx, kn_occt_model **out, const char *path,
                            kn_status (*read)(kn_ctx *ctx, kn_occt_model *m, const char *path))
{
    FILE *readable = std::fopen(path, "rb");
    if (readable == nullptr) return kn_fail(ctx, KN_EIO, "%s: cannot open", path);
    std::fclose(readable);
    kn_occt_model *model = nullptr;
    kn_status status = guarded(ctx, path, [&] {
        model = new kn_occt_model;
        return read(ctx, model, path);
    });
    if (status == KN_OK)
        *out = model;
    else
        kn_occt_close(ctx, model);
    return status;
}

kn_status kn_occt_open_step(kn_ctx *ctx, kn_occt_model **out, const char *path)
{
    return open_model(ctx, out, path, load);
}

kn_status kn_occt_open_iges(kn_ctx *ctx, kn_occt_model **out, const char *path)
{
    return open_model(ctx, out, path, load_iges);
}

void kn_occt_close(kn_ctx *ctx, kn_occt_model *model)
{
    (void)guarded(ctx, "close", [&] {
        delete model;
        return KN_OK;
    });
}

kn_status kn_occt_check(kn_ctx *ctx, kn_occt_report *out, const kn_occt_model *model)
{
    return guarded(ctx, "check", [&] {
        kn_occt_report report = {};
        Bnd_Box box;
        report.faces = count_once(model->shape, TopAbs_FACE);
        if (static_cast<size_t>(report.faces) != model->faces.size())
            return kn_fail(ctx, KN_EUNDECIDED, "OCCT: %d faces from %zu in the file", report.faces,
                           model->faces.size());
        report.shells = count_once(model->shape, TopAbs_SHELL);
        report.solids = count_once(model->shape, TopAbs_SOLID);
        check_topology(report, model->shape);
        report.first_invalid = -1;
        report.unit_mm = unit_in_mm(model);
        for (int i = 0; i < report.faces; i++) check_face(report, box, model->faces[static_cast<size_t>(i)], i);
        if (!box.IsVoid())
            box.Get(report.lo[0], report.lo[1], report.lo[2], report.hi[0], report.hi[1], report.hi[2]);
        list_colours(&report, model);
        *out = report;
        return KN_OK;
    });
}

kn_status kn_occt_eval(kn_ctx *ctx, double point[3], double *normal, const kn_occt_model *model, int face, double u,
                       double v)
{
    if (face < 0 || static_cast<size_t>(face) >= model->faces.size())
        return kn_fail(ctx, KN_EDOMAIN, "OCCT: face %d of %zu", face, model->faces.size());
    return guarded(ctx, "eval", [&] {
        const TopoDS_Face &f = model->faces[static_cast<size_t>(face)];
        Handle(Geom_Surface) surface = BRep_Tool::Surface(f);
        gp_Pnt p, unused;
        gp_Vec du, dv;
        // D0 is de Boor's algorithm. D1 goes through powers and loses digits at high degrees (1e-6 at degree 25),
        // which a direction can bear and a point cannot.
        surface->D0(u, v, p);
        if (normal != nullptr) {
            surface->D1(u, v, unused, du, dv);
            gp_Vec n = du.Crossed(dv);
            if (!(n.Magnitude() > 0.0))
                return kn_fail(ctx, KN_EUNDEFINED, "OCCT: no normal on face %d at %g, %g", face, u, v);
            double length = f.Orientation() == TopAbs_REVERSED ? -n.Magnitude() : n.Magnitude();
            for (int c = 0; c < 3; c++) normal[c] = n.Coord(c + 1) / length;
        }
        for (int c = 0; c < 3; c++) point[c] = p.Coord(c + 1);
        return KN_OK;
    });
}

kn_status kn_occt_volume(kn_ctx *ctx, double *out, const kn_occt_model *model, double part)
{
    return guarded(ctx, "volume", [&] {
        double sum = 0.0;
        for (TopExp_Explorer e(model->shape, TopAbs_SOLID); e.More(); e.Next()) {
            GProp_GProps one;
            BRepGProp::VolumeProperties(e.Current(), one, part, Standard_False, Standard_False);
            sum += one.Mass();
        }
        *out = sum;
        return KN_OK;
    });
}

kn_status kn_occt_area(kn_ctx *ctx, double *out, const kn_occt_model *model, int face, double part)
{
    if (face < 0 || static_cast<size_t>(face) >= model->faces.size())
        return kn_fail(ctx, KN_EDOMAIN, "OCCT: face %d of %zu", face, model->faces.size());
    return guarded(ctx, "area", [&] {
        GProp_GProps one;
        BRepGProp::SurfaceProperties(model->faces[static_cast<size_t>(face)], one, part);
        *out = one.Mass();
        return KN_OK;
    });
}

kn_status kn_occt_face_name(kn_ctx *ctx, char *name, size_t bytes, const kn_occt_model *model, int face)
{
    if (face < 0 || static_cast<size_t>(face) >= model->faces.size())
        return kn_fail(ctx, KN_EDOMAIN, "OCCT: face %d of %zu", face, model->faces.size());
    std::snprintf(name, bytes, "%s", model->names[static_cast<size_t>(face)].ToCString());
    return KN_OK;
}
