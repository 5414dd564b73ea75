// SPDX-License-Identifier: Apache-2.0
// Loops of a face as curves in the square.
#include <algorithm>
#include <cmath>

#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <BndLib_Add2dCurve.hxx>
#include <Bnd_Box2d.hxx>
#include <Geom2dAdaptor_Curve.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_BezierCurve.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <Geom_Surface.hxx>
#include <ShapeAnalysis_WireOrder.hxx>
#include <ShapeFix_Wire.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Wire.hxx>

#include "bridges/occt/cad_trim.hpp"

namespace kn_occt
{
namespace
{

enum { MOST_PIECES = 2048, HALVINGS = 12 };

use use_of(const TopoDS_Edge &edge, const TopoDS_Face &face)
{
    use u;
    u.edge = edge;
    u.curve = BRep_Tool::CurveOnSurface(edge, face, u.first, u.last);
    if (u.curve.IsNull()) throw Standard_Failure("an edge has no curve on its face");
    if (!(u.first < u.last)) throw Standard_Failure("an edge has no length in its parameter");
    Handle(Geom2d_TrimmedCurve) trimmed = Handle(Geom2d_TrimmedCurve)::DownCast(u.curve);
    if (!trimmed.IsNull()) u.curve = trimmed->BasisCurve();
    u.reversed = edge.Orientation() == TopAbs_REVERSED;
    u.degenerate = BRep_Tool::Degenerated(edge);
    return u;
}

int count_edges(const TopoDS_Wire &wire)
{
    int n = 0;
    for (TopExp_Explorer e(wire, TopAbs_EDGE); e.More(); e.Next())
        n += e.Current().Orientation() == TopAbs_FORWARD || e.Current().Orientation() == TopAbs_REVERSED;
    return n;
}

loop follow(const TopoDS_Wire &wire, const TopoDS_Face &face)
{
    loop l;
    for (BRepTools_WireExplorer e(wire, face); e.More(); e.Next()) l.push_back(use_of(e.Current(), face));
    return l;
}

// Two ends of an interval near those that there are, become them.
void snap(double *lo, double *hi, double from, double to)
{
    double near = 1e-7 * (to - from);
    if (!(near < 1e90)) return; // without ends
    if (*lo < from + near) *lo = from;
    if (*hi > to - near) *hi = to;
}

// A cubic from one point and derivative to another.
struct piece {
    double s0, s1, p0[2], d0[2], p1[2], d1[2];
};

void evaluate(const use &u, const chart &c, double s, double p[2], double d[2])
{
    gp_Pnt2d q;
    gp_Vec2d v;
    u.curve->D1(u.at(s), q, v);
    c.at(q, p);
    c.along(q, v, d);
    double slope = u.slope(s);
    d[0] *= slope, d[1] *= slope;
}

// How far the curve is from the cubic at its quarters, mm.
double miss(const use &u, const chart &c, const piece &k)
{
    double worst = 0.0;
    for (double x : {0.25, 0.5, 0.75}) {
        double y = 1 - x, h = k.s1 - k.s0, p[2], d[2], off[2];
        evaluate(u, c, k.s0 + x * h, p, d);
        for (int i = 0; i < 2; i++) {
            double value = y * y * (1 + 2 * x) * k.p0[i] + x * x * (1 + 2 * y) * k.p1[i] +
                           h * x * y * (y * k.d0[i] - x * k.d1[i]);
            off[i] = (value - p[i]) * c.size[i];
        }
        worst = std::max(worst, std::hypot(off[0], off[1]));
    }
    return worst;
}

void fit(std::vector<piece> *out, double *error, const use &u, const chart &c, double s0, double s1, double tolerance,
         int depth)
{
    piece k;
    k.s0 = s0, k.s1 = s1;
    evaluate(u, c, s0, k.p0, k.d0);
    evaluate(u, c, s1, k.p1, k.d1);
    double off = miss(u, c, k);
    if (!std::isfinite(off)) throw Standard_Failure("a curve on a face is not finite");
    if (off <= tolerance || depth == 0 || out->size() >= MOST_PIECES) {
        out->push_back(k);
        *error = std::max(*error, off);
        return;
    }
    double mid = 0.5 * (s0 + s1);
    fit(out, error, u, c, s0, mid, tolerance, depth - 1);
    fit(out, error, u, c, mid, s1, tolerance, depth - 1);
}

// Where a curve has corners, or bends abruptly.
std::vector<double> breaks(const use &u)
{
    std::vector<double> out = {u.first};
    Geom2dAdaptor_Curve adaptor(u.curve, u.first, u.last);
    int n = adaptor.NbIntervals(GeomAbs_C2);
    TColStd_Array1OfReal at(1, n + 1);
    adaptor.Intervals(at, GeomAbs_C2);
    for (int i = 2; i <= n; i++)
        if (at(i) > out.back() && at(i) < u.last) out.push_back(at(i));
    out.push_back(u.last);
    if (u.paced) {
        for (double &x : out) x = u.pace.at(u.from + (x - u.first) / u.rate);
        out.front() = u.ends[0], out.back() = u.ends[1];
        for (int i = 1; u.pace.arcs && i < u.pace.n; i++) out.push_back(u.pace.lo + i * u.pace.step);
        std::sort(out.begin(), out.end());
        double near = 1e-9 * (u.ends[1] - u.ends[0]);
        std::vector<double> apart = {u.ends[0]};
        for (double x : out)
            if (x > apart.back() + near && x < u.ends[1] - near) apart.push_back(x);
        apart.push_back(u.ends[1]);
        out = apart;
    }
    if (out.size() < 3) { // a closed conic agrees with its chord everywhere that is looked at, or nearly
        double first = out.front(), last = out.back(), h = (last - first) / 4;
        out = {first, first + h, first + 2 * h, first + 3 * h, last};
    }
    return out;
}

outline fitted(const use &u, const chart &c, double tolerance)
{
    outline out;
    out.degree = 3;
    std::vector<piece> all;
    std::vector<double> at = breaks(u);
    for (size_t i = 0; i + 1 < at.size(); i++) fit(&all, &out.error, u, c, at[i], at[i + 1], tolerance, HALVINGS);
    for (size_t i = 0; i < all.size(); i++) {
        const piece &k = all[i];
        double h = (k.s1 - k.s0) / 3;
        const piece *before = i > 0 ? &all[i - 1] : nullptr;
        bool joint = before != nullptr; // smooth: the joint's point is given by its neighbours
        for (int d = 0; joint && d < 2; d++)
            joint = std::fabs(before->d1[d] - k.d0[d]) <= 1e-9 * (std::fabs(k.d0[0]) + std::fabs(k.d0[1])) &&
                    std::fabs(before->p1[d] - k.p0[d]) <= 1e-14;
        for (int m = 0; m < (i == 0 ? 4 : joint ? 2 : 3); m++) out.knots.push_back(k.s0);
        if (!joint) out.x.push_back(k.p0[0]), out.y.push_back(k.p0[1]);
        out.x.push_back(k.p0[0] + h * k.d0[0]), out.y.push_back(k.p0[1] + h * k.d0[1]);
        out.x.push_back(k.p1[0] - h * k.d1[0]), out.y.push_back(k.p1[1] - h * k.d1[1]);
    }
    out.x.push_back(all.back().p1[0]), out.y.push_back(all.back().p1[1]);
    for (int m = 0; m < 4; m++) out.knots.push_back(at.back());
    return out;
}

outline straight(const use &u, const chart &c)
{
    outline out;
    double p[2], q[2];
    c.at(u.curve->Value(u.first), p);
    c.at(u.curve->Value(u.last), q);
    out.knots = {u.first, u.first, u.last, u.last};
    out.x = {p[0], q[0]}, out.y = {p[1], q[1]};
    return out;
}

// A polynomial spline over [first,last]; null: it is none.
Handle(Geom2d_BSplineCurve) spline_in_plane(const use &u)
{
    Handle(Geom2d_BSplineCurve) c = Handle(Geom2d_BSplineCurve)::DownCast(u.curve);
    if (c.IsNull() || c->IsRational()) return Handle(Geom2d_BSplineCurve)();
    bool clamped = c->Multiplicity(1) == c->Degree() + 1 && c->Multiplicity(c->NbKnots()) == c->Degree() + 1;
    if (!c->IsPeriodic() && clamped && c->FirstParameter() == u.first && c->LastParameter() == u.last) return c;
    if (c->IsPeriodic()) return Handle(Geom2d_BSplineCurve)(); // a segment that goes round would be nothing
    c = Handle(Geom2d_BSplineCurve)::DownCast(c->Copy());
    c->Segment(u.first, u.last);
    return c;
}

// Its control points moved into the square; false: not as it should be there.
bool as_it_is(outline *out, const use &u, const chart &c)
{
    Handle(Geom2d_BSplineCurve) s = spline_in_plane(u);
    if (s.IsNull()) return false;
    out->degree = s->Degree();
    for (int i = 1; i <= s->NbKnots(); i++)
        for (int k = 0; k < s->Multiplicity(i); k++) out->knots.push_back(s->Knot(i));
    for (int i = 1; i <= s->NbPoles(); i++) {
        double p[2];
        c.at(s->Pole(i), p);
        if (!(std::fabs(p[0] - 0.5) <= 1.5 && std::fabs(p[1] - 0.5) <= 1.5)) return false;
        out->x.push_back(p[0]), out->y.push_back(p[1]);
    }
    size_t order = static_cast<size_t>(out->degree) + 1;
    return out->knots.size() == out->x.size() + order && out->knots[order - 1] == out->knots[0] &&
           out->knots[out->x.size()] == out->knots.back();
}

// The chord, where that is the curve at the right times.
bool straight_in_time(outline *out, const use &u, const chart &c)
{
    enum { PLACES = 17 };
    const double exact = 1e-8; // mm
    double p[2], q[2], x[2], d[2];
    evaluate(u, c, u.ends[0], p, d);
    evaluate(u, c, u.ends[1], q, d);
    for (int i = 1; i < PLACES; i++) {
        double t = static_cast<double>(i) / PLACES;
        evaluate(u, c, u.ends[0] + t * (u.ends[1] - u.ends[0]), x, d);
        double off[2];
        for (int k = 0; k < 2; k++) off[k] = ((1 - t) * p[k] + t * q[k] - x[k]) * c.size[k];
        if (!(std::hypot(off[0], off[1]) <= exact)) return false;
    }
    out->knots = {u.ends[0], u.ends[0], u.ends[1], u.ends[1]};
    out->x = {p[0], q[0]}, out->y = {p[1], q[1]};
    return true;
}

bool along_axis(const gp_Dir2d &d)
{
    return std::fabs(d.X()) < 1e-12 || std::fabs(d.Y()) < 1e-12;
}

} // namespace

double use::at(double x) const
{
    return paced ? first + (pace.back(x) - from) * rate : x;
}

double use::slope(double x) const
{
    return paced ? rate / pace.slope(pace.back(x)) : 1.0;
}

void chart::at(const gp_Pnt2d &p, double out[2]) const
{
    for (int d = 0; d < 2; d++) out[d] = (w[d].at(p.Coord(d + 1)) - lo[d]) / (hi[d] - lo[d]);
}

void chart::along(const gp_Pnt2d &p, const gp_Vec2d &v, double out[2]) const
{
    for (int d = 0; d < 2; d++) out[d] = w[d].slope(p.Coord(d + 1)) * v.Coord(d + 1) / (hi[d] - lo[d]);
}

std::vector<loop> loops_of(const TopoDS_Face &shape)
{
    TopoDS_Face face = TopoDS::Face(shape.Oriented(TopAbs_FORWARD));
    std::vector<loop> out;
    for (TopExp_Explorer e(face, TopAbs_WIRE); e.More(); e.Next()) {
        TopoDS_Wire wire = TopoDS::Wire(e.Current());
        size_t n = static_cast<size_t>(count_edges(wire));
        if (n == 0) continue;
        loop l = follow(wire, face);
        if (l.size() != n) { // not in order
            ShapeFix_Wire fix(wire, face, 1e-7);
            fix.FixReorder();
            l = follow(fix.Wire(), face);
        }
        if (l.size() != n) throw Standard_Failure("edges that form no loop");
        out.push_back(l);
    }
    return out;
}

void box_of(double box[4], const TopoDS_Face &face, const std::vector<loop> &loops)
{
    Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
    double bounds[4];
    surface->Bounds(bounds[0], bounds[1], bounds[2], bounds[3]);
    if (loops.empty()) {
        std::copy(bounds, bounds + 4, box);
    } else {
        Bnd_Box2d all;
        for (const loop &l : loops)
            for (const use &u : l) {
                Geom2dAdaptor_Curve curve(u.curve, u.first, u.last);
                if (!u.curve->IsKind(STANDARD_TYPE(Geom2d_Line)))
                    BndLib_Add2dCurve::AddOptimal(u.curve, u.first, u.last, 0.0, all);
                all.Add(curve.Value(u.first));
                all.Add(curve.Value(u.last));
            }
        all.SetGap(0.0);
        all.Get(box[0], box[2], box[1], box[3]);
    }
    for (int d = 0; d < 2; d++) {
        bool periodic = d == 0 ? surface->IsUPeriodic() : surface->IsVPeriodic();
        double period = !periodic ? 0.0 : d == 0 ? surface->UPeriod() : surface->VPeriod();
        if (!periodic)
            snap(&box[2 * d], &box[2 * d + 1], bounds[2 * d], bounds[2 * d + 1]);
        else if (std::fabs(box[2 * d] - bounds[2 * d]) < 1e-7 * period)
            box[2 * d] = bounds[2 * d];
        if (periodic && box[2 * d + 1] - box[2 * d] > (1 - 1e-7) * period) box[2 * d + 1] = box[2 * d] + period;
        double size = box[2 * d + 1] - box[2 * d];
        if (!(size > 1e-12 && size < 1e90)) throw Standard_Failure("a face without area, or without end");
    }
}

outline outline_of(const use &u, const chart &c, double tolerance)
{
    bool warped = c.w[0].arcs || c.w[1].arcs;
    Handle(Geom2d_Line) line = Handle(Geom2d_Line)::DownCast(u.curve);
    outline out;
    if (!line.IsNull() && (!warped || along_axis(line->Direction()))) return straight(u, c);
    if (!warped && as_it_is(&out, u, c)) return out;
    return fitted(u, c, tolerance);
}

outline paced_outline(use u, const chart &c, const section &line, double first, double last, double tolerance)
{
    u.paced = true;
    u.pace = line.w;
    u.from = first, u.rate = (u.last - u.first) / (last - first);
    u.ends[0] = line.knots.front(), u.ends[1] = line.knots.back();
    outline out;
    return straight_in_time(&out, u, c) ? out : fitted(u, c, tolerance);
}

} // namespace kn_occt
