// SPDX-License-Identifier: Apache-2.0
// kn_occt_make, kn_occt_probe_*.
#include <cmath>
#include <cstring>
#include <utility>

#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepClass3d_SolidClassifier.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_Surface.hxx>
#include <IGESControl_Writer.hxx>
#include <STEPControl_Writer.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>

#include "bridges/occt/cad_model.hpp"
#include "bridges/occt/guard.hpp"
#include "bridges/occt/occt_probe.h"

struct kn_occt_probe {
    kn_occt::document d;
};

namespace
{

TopoDS_Shape rounded(const TopoDS_Shape &shape, double radius)
{
    BRepFilletAPI_MakeFillet fillet(shape);
    for (TopExp_Explorer e(shape, TopAbs_EDGE); e.More(); e.Next()) fillet.Add(radius, TopoDS::Edge(e.Current()));
    return fillet.Shape();
}

TopoDS_Shape drilled()
{
    TopoDS_Shape hole = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(5, 10, -1), gp_Dir(0, 0, 1)), 3, 40).Shape();
    TopoDS_Shape part = BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), hole).Shape();
    gp_Trsf turn, move;
    turn.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(1, 1, 2)), 0.7);
    move.SetTranslation(gp_Vec(30, -20, 10));
    return part.Moved(TopLoc_Location(move * turn)); // a location, which the reader has to apply
}

Handle(Geom_BSplineCurve) through(std::initializer_list<gp_Pnt> points, bool closed)
{
    Handle(TColgp_HArray1OfPnt) array = new TColgp_HArray1OfPnt(1, static_cast<int>(points.size()));
    int i = 1;
    for (const gp_Pnt &p : points) array->SetValue(i++, p);
    GeomAPI_Interpolate fit(array, closed, 1e-9);
    fit.Perform();
    return fit.Curve();
}

TopoDS_Shape knob()
{
    Handle(Geom_BSplineCurve)
        side = through({gp_Pnt(8, 0, 0), gp_Pnt(10, 0, 4), gp_Pnt(9, 0, 9), gp_Pnt(11, 0, 14)}, false);
    BRepBuilderAPI_MakeWire wire(BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(8, 0, 0)).Edge(),
                                 BRepBuilderAPI_MakeEdge(side).Edge(),
                                 BRepBuilderAPI_MakeEdge(gp_Pnt(11, 0, 14), gp_Pnt(0, 0, 14)).Edge(),
                                 BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 14), gp_Pnt(0, 0, 0)).Edge());
    TopoDS_Shape solid = BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(wire.Wire()).Face(),
                                               gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)))
                             .Shape();
    BRepFilletAPI_MakeFillet fillet(solid);
    for (TopExp_Explorer e(solid, TopAbs_EDGE); e.More(); e.Next()) {
        TopoDS_Edge edge = TopoDS::Edge(e.Current());
        if (BRep_Tool::Degenerated(edge)) continue;
        double a, b;
        Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, a, b);
        gp_Pnt p = curve->Value(a), q = curve->Value(0.5 * (a + b));
        if (std::fabs(p.Z() - 14) < 1e-6 && std::fabs(q.Z() - 14) < 1e-6 && p.X() > 10) {
            fillet.Add(1.0, edge);
            break;
        }
    }
    return fillet.Shape();
}

TopoDS_Shape extruded()
{
    Handle(Geom_BSplineCurve)
        ring = through({gp_Pnt(0, 0, 0), gp_Pnt(8, -2, 0), gp_Pnt(12, 5, 0), gp_Pnt(3, 9, 0)}, true);
    BRepBuilderAPI_MakeWire wire(BRepBuilderAPI_MakeEdge(ring).Edge());
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(wire.Wire()).Face(), gp_Vec(2, 3, 11)).Shape();
}

TopoDS_Shape saddle()
{
    TopoDS_Shape pipe = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(2, 1, -20), gp_Dir(0, 0, 1)), 4, 40).Shape();
    return BRepAlgoAPI_Common(pipe, BRepPrimAPI_MakeSphere(9).Shape()).Shape();
}

TopoDS_Shape hollow()
{
    TopoDS_Shape all = rounded(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), 1);
    const TopoDS_Shape less[] = {BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(5, -1, 4), gp_Dir(0, 1, 0)), 1.5, 30).Shape(),
                                 BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(5, 10, 8), gp_Dir(0, 0, 1)), 2, 6).Shape(),
                                 BRepPrimAPI_MakeSphere(gp_Pnt(5, 10, 22), 3).Shape()};
    for (const TopoDS_Shape &part : less) all = BRepAlgoAPI_Cut(all, part).Shape();
    return all;
}

TopoDS_Shape shape_of(kn_occt_kind kind)
{
    switch (kind) {
    case KN_OCCT_BOX: return BRepPrimAPI_MakeBox(10, 20, 30).Shape();
    case KN_OCCT_CYLINDER: return BRepPrimAPI_MakeCylinder(5, 20).Shape();
    case KN_OCCT_SPHERE: return BRepPrimAPI_MakeSphere(7).Shape();
    case KN_OCCT_TORUS: return BRepPrimAPI_MakeTorus(10, 3).Shape();
    case KN_OCCT_CONE: return BRepPrimAPI_MakeCone(6, 2, 9).Shape();
    case KN_OCCT_APEX: return BRepPrimAPI_MakeCone(6, 0, 9).Shape();
    case KN_OCCT_FILLET: return rounded(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), 2);
    case KN_OCCT_DRILLED: return drilled();
    case KN_OCCT_KNOB: return knob();
    case KN_OCCT_EXTRUDED: return extruded();
    case KN_OCCT_SECTOR: return BRepPrimAPI_MakeTorus(10, 3, 1.5707963267948966).Shape();
    case KN_OCCT_SADDLE: return saddle();
    case KN_OCCT_HOLLOW: return hollow();
    case KN_OCCT_KINDS: break;
    }
    return TopoDS_Shape();
}

bool ends_in(const char *path, const char *ending)
{
    size_t n = std::strlen(path), m = std::strlen(ending);
    return n >= m && std::strcmp(path + n - m, ending) == 0;
}

bool write(const TopoDS_Shape &shape, const char *path)
{
    if (ends_in(path, ".brep")) return BRepTools::Write(shape, path);
    if (ends_in(path, ".step")) {
        STEPControl_Writer writer;
        return writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone && writer.Write(path) == IFSelect_RetDone;
    }
    IGESControl_Writer writer("MM", 1); // solids
    return writer.AddShape(shape) && writer.Write(path);
}

// Gauss-Newton steps towards p, as long as they come nearer.
gp_Pnt2d refined(const Handle(Geom_Surface) & surface, gp_Pnt2d at, const gp_Pnt &p)
{
    for (int i = 0; i < 20; i++) {
        gp_Pnt q;
        gp_Vec du, dv;
        surface->D1(at.X(), at.Y(), q, du, dv);
        gp_Vec r(q, p);
        double a = du.Dot(du), b = du.Dot(dv), c = dv.Dot(dv), x = du.Dot(r), y = dv.Dot(r), det = a * c - b * b;
        if (!(det > 1e-12 * a * c)) break;
        gp_Pnt2d next(at.X() + (c * x - b * y) / det, at.Y() + (a * y - b * x) / det);
        if (!(surface->Value(next.X(), next.Y()).Distance(p) < r.Magnitude())) break;
        at = next;
    }
    return at;
}

int side_of(TopAbs_State state)
{
    return state == TopAbs_IN ? 1 : state == TopAbs_ON ? 0 : -1;
}

} // namespace

kn_status kn_occt_make(kn_ctx *ctx, kn_occt_kind kind, const char *path)
{
    return kn_occt::guarded(ctx, path, [&] {
        TopoDS_Shape shape = shape_of(kind);
        if (shape.IsNull())
            return kn_fail(ctx, KN_EDOMAIN, "%s: OCCT makes no shape %d", path, static_cast<int>(kind));
        return write(shape, path) ? KN_OK : kn_fail(ctx, KN_EIO, "%s: OCCT cannot write it", path);
    });
}

kn_status kn_occt_probe_open(kn_ctx *ctx, kn_occt_probe **out, kn_cad *cad, const char *path)
{
    kn_cad made = {};
    kn_occt_probe *probe = nullptr;
    kn_status status = kn_occt::guarded(ctx, path, [&] {
        probe = new kn_occt_probe;
        kn_occt::read_document(ctx, &probe->d, path);
        kn_occt::model_of(ctx, &made, &probe->d, path);
        return KN_OK;
    });
    if (status == KN_OK) {
        std::swap(*cad, made);
        *out = probe;
    } else {
        kn_occt_probe_close(ctx, probe);
    }
    kn_cad_clear(ctx, &made);
    return status;
}

void kn_occt_probe_close(kn_ctx *ctx, kn_occt_probe *probe)
{
    (void)kn_occt::guarded(ctx, "close", [&] {
        delete probe;
        return KN_OK;
    });
}

kn_status kn_occt_probe_face(kn_ctx *ctx, kn_occt_place *out, const kn_occt_probe *probe, int face,
                             const double point[3], double tolerance)
{
    return kn_occt::guarded(ctx, "probe", [&] {
        const TopoDS_Face &f = probe->d.faces.at(static_cast<size_t>(face)).shape;
        Handle(Geom_Surface) surface = BRep_Tool::Surface(f);
        ShapeAnalysis_Surface projector(surface);
        gp_Pnt p(point[0], point[1], point[2]), q;
        gp_Pnt2d at = projector.ValueOfUV(p, 1e-9);
        at = refined(surface, at, p); // it ends early on some splines
        kn_occt_place place = {};
        gp_Vec du, dv;
        surface->D1(at.X(), at.Y(), q, du, dv);
        place.distance = p.Distance(q);
        place.u = at.X(), place.v = at.Y();
        gp_Vec n = du.Crossed(dv);
        if (n.Magnitude() > 1e-9 * (du.Magnitude() + dv.Magnitude())) {
            n /= f.Orientation() == TopAbs_REVERSED ? -n.Magnitude() : n.Magnitude();
            for (int c = 0; c < 3; c++) place.normal[c] = n.Coord(c + 1);
        }
        BRepTopAdaptor_FClass2d classifier(f, tolerance);
        place.inside = side_of(classifier.Perform(at));
        *out = place;
        return KN_OK;
    });
}

kn_status kn_occt_probe_body(kn_ctx *ctx, int *out, const kn_occt_probe *probe, int body, const double point[3],
                             double tolerance)
{
    return kn_occt::guarded(ctx, "probe", [&] {
        BRepClass3d_SolidClassifier classifier(probe->d.bodies.at(static_cast<size_t>(body)).shape);
        classifier.Perform(gp_Pnt(point[0], point[1], point[2]), tolerance);
        *out = side_of(classifier.State());
        return KN_OK;
    });
}
