// SPDX-License-Identifier: Apache-2.0
// kn_occt_bench_*: a shell of faces for OCCT's writers.
#include <vector>

#include <BRep_Builder.hxx>
#include <Geom2d_Line.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>

#include "bridges/occt/guard.hpp"
#include "bridges/occt/occt_bench.h"

struct kn_occt_bench {
    TopoDS_Shell shell;
};

namespace
{

const double tolerance = 1e-7;

struct grid {
    int nu, nv;
    BRep_Builder builder;
    std::vector<TopoDS_Vertex> vertices; // (nu + 1) x (nv + 1)
    std::vector<TopoDS_Edge> along_u, along_v;
};

TColStd_Array1OfReal two_knots()
{
    TColStd_Array1OfReal knots(1, 2);
    knots(1) = 0.0, knots(2) = 1.0;
    return knots;
}

TColStd_Array1OfInteger two_times()
{
    TColStd_Array1OfInteger times(1, 2);
    times(1) = times(2) = 4;
    return times;
}

gp_Pnt point_of(const double p[3])
{
    return gp_Pnt(p[0], p[1], p[2]);
}

TopoDS_Vertex &vertex(grid &g, int i, int j, const double p[3])
{
    TopoDS_Vertex &v = g.vertices[static_cast<size_t>(i * (g.nv + 1) + j)];
    if (v.IsNull()) g.builder.MakeVertex(v, point_of(p), tolerance);
    return v;
}

// The edge on these four points, made when the first face asks for it.
TopoDS_Edge &edge(grid &g, TopoDS_Edge &e, const double (*p)[3], int first, int step, const TopoDS_Vertex &from,
                  const TopoDS_Vertex &to)
{
    if (!e.IsNull()) return e;
    TColgp_Array1OfPnt poles(1, 4);
    for (int k = 0; k < 4; k++) poles(k + 1) = point_of(p[first + k * step]);
    g.builder.MakeEdge(e, new Geom_BSplineCurve(poles, two_knots(), two_times(), 3), tolerance);
    g.builder.Add(e, from.Oriented(TopAbs_FORWARD));
    g.builder.Add(e, to.Oriented(TopAbs_REVERSED));
    g.builder.Range(e, 0.0, 1.0);
    return e;
}

void add_face(grid &g, TopoDS_Shell &shell, int i, int j, const double (*p)[3])
{
    TColgp_Array2OfPnt poles(1, 4, 1, 4);
    for (int k = 0; k < 16; k++) poles(k / 4 + 1, k % 4 + 1) = point_of(p[k]);
    TopoDS_Face face;
    g.builder.MakeFace(face, new Geom_BSplineSurface(poles, two_knots(), two_knots(), two_times(), two_times(), 3, 3),
                       tolerance);
    const TopoDS_Vertex a = vertex(g, i, j, p[0]), b = vertex(g, i + 1, j, p[12]), c = vertex(g, i + 1, j + 1, p[15]),
                        d = vertex(g, i, j + 1, p[3]);
    size_t u = static_cast<size_t>(i * (g.nv + 1) + j), v = static_cast<size_t>(i * g.nv + j);
    TopoDS_Edge sides[4] = {edge(g, g.along_u[u], p, 0, 4, a, b),
                            edge(g, g.along_v[v + static_cast<size_t>(g.nv)], p, 12, 1, b, c),
                            edge(g, g.along_u[u + 1], p, 3, 4, d, c), edge(g, g.along_v[v], p, 0, 1, a, d)};
    const gp_Pnt2d from[4] = {gp_Pnt2d(0, 0), gp_Pnt2d(1, 0), gp_Pnt2d(0, 1), gp_Pnt2d(0, 0)};
    TopoDS_Wire wire;
    g.builder.MakeWire(wire);
    for (int e = 0; e < 4; e++) {
        gp_Dir2d along(e % 2 == 0 ? 1 : 0, e % 2);
        g.builder.UpdateEdge(sides[e], new Geom2d_Line(from[e], along), face, tolerance);
        g.builder.Range(sides[e], face, 0.0, 1.0);
        g.builder.Add(wire, e < 2 ? sides[e] : TopoDS::Edge(sides[e].Reversed()));
    }
    wire.Closed(Standard_True);
    g.builder.Add(face, wire);
    g.builder.Add(shell, face);
}

} // namespace

kn_status kn_occt_bench_grid(kn_ctx *ctx, kn_occt_bench **out, int nu, int nv,
                             void (*net)(double point[16][3], int i, int j))
{
    kn_occt_bench *bench = nullptr;
    kn_status status = kn_occt::guarded(ctx, "grid", [&] {
        bench = new kn_occt_bench;
        size_t n = static_cast<size_t>(nu + 1) * static_cast<size_t>(nv + 1);
        grid g = {nu,
                  nv,
                  BRep_Builder(),
                  std::vector<TopoDS_Vertex>(n),
                  std::vector<TopoDS_Edge>(n),
                  std::vector<TopoDS_Edge>(n)};
        g.builder.MakeShell(bench->shell);
        for (int i = 0; i < nu; i++)
            for (int j = 0; j < nv; j++) {
                double p[16][3];
                net(p, i, j);
                add_face(g, bench->shell, i, j, p);
            }
        return KN_OK;
    });
    if (status == KN_OK)
        *out = bench;
    else
        kn_occt_bench_close(bench);
    return status;
}

kn_status kn_occt_bench_write(kn_ctx *ctx, const kn_occt_bench *bench, const char *path, kn_occt_writer how)
{
    return kn_occt::guarded(ctx, path, [&] {
        bool written = false;
        if (how != KN_OCCT_STEP) {
            IGESControl_Controller::Init();
            IGESControl_Writer writer("MM", how == KN_OCCT_IGES_BREP);
            written = writer.AddShape(bench->shell);
            writer.ComputeModel();
            written = written && writer.Write(path);
        } else {
            STEPControl_Controller::Init();
            STEPControl_Writer writer;
            Interface_Static::SetIVal("write.surfacecurve.mode", 0);
            written = writer.Transfer(bench->shell, STEPControl_AsIs) == IFSelect_RetDone;
            written = written && writer.Write(path) == IFSelect_RetDone;
        }
        return written ? KN_OK : kn_fail(ctx, KN_EIO, "%s: OCCT cannot write it", path);
    });
}

void kn_occt_bench_close(kn_occt_bench *bench)
{
    delete bench;
}
