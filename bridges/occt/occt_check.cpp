// SPDX-License-Identifier: Apache-2.0
// kn_occt_*: reads STEP through Open CASCADE and asks it what it thinks of the result.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <new>
#include <vector>

#include <BRepCheck_Analyzer.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <StepShape_AdvancedFace.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
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

#include "bridges/occt/occt_check.h"
extern "C" {
#include "kernel/context.h"
}

struct kn_occt_model {
    STEPCAFControl_Reader reader;
    Handle(TDocStd_Document) document;
    TopoDS_Shape shape;
    std::vector<TopoDS_Face> faces; // in the order of the file: OCCT takes unconnected shells apart
    std::vector<TCollection_AsciiString> names;
};

namespace
{

// OCCT reports to the terminal; the library is silent. What printers were there come back at the end.
class silence
{
  public:
    silence() : printers(Message::DefaultMessenger()->ChangePrinters())
    {
        Message::DefaultMessenger()->ChangePrinters().Clear();
    }
    silence(const silence &) = delete;
    silence &operator=(const silence &) = delete;
    ~silence()
    {
        Message::DefaultMessenger()->ChangePrinters() = printers;
    }

  private:
    Message_SequenceOfPrinters printers;
};

// Runs f; what it throws becomes a status.
template <class F> kn_status guarded(kn_ctx *ctx, const char *what, F f)
{
    try {
        silence quiet;
        return f();
    } catch (const std::bad_alloc &) {
        return kn_fail(ctx, KN_ENOMEM, "%s: out of memory", what);
    } catch (const Standard_Failure &failure) {
        return kn_fail(ctx, KN_EUNDECIDED, "%s: OCCT: %s", what, failure.GetMessageString());
    } catch (...) {
        return kn_fail(ctx, KN_EUNDECIDED, "%s: OCCT threw", what);
    }
}

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
    if (BRepCheck_Analyzer(face).IsValid())
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

kn_status kn_occt_open_step(kn_ctx *ctx, kn_occt_model **out, const char *path)
{
    FILE *readable = std::fopen(path, "rb");
    if (readable == nullptr) return kn_fail(ctx, KN_EIO, "%s: cannot open", path);
    std::fclose(readable);
    kn_occt_model *model = nullptr;
    kn_status status = guarded(ctx, path, [&] {
        model = new kn_occt_model;
        return load(ctx, model, path);
    });
    if (status == KN_OK)
        *out = model;
    else
        kn_occt_close(ctx, model);
    return status;
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
        report.faces = count(model->shape, TopAbs_FACE);
        if (static_cast<size_t>(report.faces) != model->faces.size())
            return kn_fail(ctx, KN_EUNDECIDED, "OCCT: %d faces from %zu in the file", report.faces,
                           model->faces.size());
        report.shells = count(model->shape, TopAbs_SHELL);
        report.solids = count(model->shape, TopAbs_SOLID);
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

kn_status kn_occt_face_name(kn_ctx *ctx, char *name, size_t bytes, const kn_occt_model *model, int face)
{
    if (face < 0 || static_cast<size_t>(face) >= model->faces.size())
        return kn_fail(ctx, KN_EDOMAIN, "OCCT: face %d of %zu", face, model->faces.size());
    std::snprintf(name, bytes, "%s", model->names[static_cast<size_t>(face)].ToCString());
    return KN_OK;
}
