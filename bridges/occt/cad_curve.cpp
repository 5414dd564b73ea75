// SPDX-License-Identifier: Apache-2.0
// Curves and surfaces of OCCT as splines.
#include <algorithm>
#include <cmath>

#include <GeomConvert.hxx>
#include <GeomConvert_ApproxCurve.hxx>
#include <GeomConvert_ApproxSurface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Line.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Parabola.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Standard_Failure.hxx>
#include <gp_Ax2.hxx>

#include "bridges/occt/cad_curve.hpp"

namespace kn_occt
{
namespace
{

const double pi = 3.14159265358979323846;
const double approximation = 1e-5; // mm: of what has no exact spline
enum { MOST_SEGMENTS = 200, MOST_DEGREE = 9 };

// cos and sin with zeros where they ought to be.
void turn(double angle, double *c, double *s)
{
    *c = std::cos(angle), *s = std::sin(angle);
    if (std::fabs(*c) < 1e-15) *c = 0.0, *s = *s > 0 ? 1.0 : -1.0;
    if (std::fabs(*s) < 1e-15) *s = 0.0, *c = *c > 0 ? 1.0 : -1.0;
}

// The unit circle's arc over [lo,hi] as quadratics: (cos, sin, 0, weight), homogeneous. Of a full circle the last is
// the first, bit for bit.
section arc(double lo, double hi)
{
    section s;
    s.degree = 2, s.rational = true;
    s.w.arcs = true, s.w.lo = lo;
    s.w.n = std::max(1, static_cast<int>(std::ceil((hi - lo) / (pi / 2) - 1e-9)));
    s.w.step = (hi - lo) / s.w.n;
    bool full = std::fabs(hi - lo - 2 * pi) < 1e-12;
    for (int i = 0; i <= s.w.n; i++) {
        double end = i == s.w.n ? hi : lo + i * s.w.step;
        for (int k = 0; k < (i == 0 || i == s.w.n ? 3 : 2); k++) s.knots.push_back(end);
        pole p = {0, 0, 0, 1};
        turn(end, &p.x, &p.y);
        if (full && i == s.w.n) p = s.poles.front();
        s.poles.push_back(p);
        if (i == s.w.n) break;
        pole m = {0, 0, 0, std::cos(s.w.step / 2)};
        turn(lo + (i + 0.5) * s.w.step, &m.x, &m.y);
        s.poles.push_back(m);
    }
    return s;
}

section segment(double lo, double hi)
{
    section s;
    s.knots = {lo, lo, hi, hi};
    return s;
}

pole at(const gp_Pnt &p, double w)
{
    return pole{p.X() * w, p.Y() * w, p.Z() * w, w};
}

// The affine image c + x a + y b of a curve in the plane.
section image(section s, const gp_Pnt &c, const gp_Vec &a, const gp_Vec &b)
{
    for (pole &p : s.poles) {
        gp_XYZ q = c.XYZ() * p.w + a.XYZ() * p.x + b.XYZ() * p.y;
        p = pole{q.X(), q.Y(), q.Z(), p.w};
    }
    return s;
}

// Knots of OCCT's repeated, from the bounds; exactly from lo to hi, whole periods away.
std::vector<double> flat(const TColStd_Array1OfReal &knots, const TColStd_Array1OfInteger &mults, double lo,
                         double hi)
{
    std::vector<double> out;
    double shift = lo - knots.First();
    if (std::fabs(shift) < 1e-9 * (hi - lo)) shift = 0.0;
    for (int i = knots.Lower(); i <= knots.Upper(); i++)
        for (int k = 0; k < mults(i); k++)
            out.push_back(i == knots.Lower() ? lo : i == knots.Upper() ? hi : knots(i) + shift);
    return out;
}

section spline_section(Handle(Geom_BSplineCurve) c, double lo, double hi)
{
    section s;
    s.degree = c->Degree();
    bool clamped = c->Multiplicity(1) == s.degree + 1 && c->Multiplicity(c->NbKnots()) == s.degree + 1;
    if (c->IsPeriodic() || !clamped || lo != c->FirstParameter() || hi != c->LastParameter()) {
        c = Handle(Geom_BSplineCurve)::DownCast(c->Copy());
        double near = 1e-9 * (hi - lo);
        if (c->IsPeriodic() &&
            std::fabs(hi - lo - c->Period()) <= near) { // Segment takes the wrong poles of a whole one
            if (std::fabs(lo - c->FirstParameter()) > near) c->SetOrigin(lo, near);
            c->SetNotPeriodic();
            c->Segment(c->FirstParameter(), c->LastParameter());
        } else {
            c->Segment(lo, hi);
        }
    }
    s.rational = c->IsRational();
    s.knots = flat(c->Knots(), c->Multiplicities(), lo, hi);
    for (int i = 1; i <= c->NbPoles(); i++) s.poles.push_back(at(c->Pole(i), c->Weight(i)));
    return s;
}

// p turned about the axis through o along z by all of an arc; x, y, z may be left-handed, as the surface is.
patch revolve(const section &profile, double lo, double hi, const gp_Ax3 &axes)
{
    section circle = arc(lo, hi);
    patch out;
    out.degree[0] = 2, out.degree[1] = profile.degree;
    out.rational = true;
    out.knots[0] = circle.knots, out.knots[1] = profile.knots;
    out.w[0] = circle.w, out.w[1] = profile.w;
    out.error = profile.error;
    gp_XYZ o = axes.Location().XYZ(), x = axes.XDirection().XYZ(), y = axes.YDirection().XYZ(),
           z = axes.Direction().XYZ();
    for (const pole &c : circle.poles)
        for (const pole &p : profile.poles) {
            gp_XYZ d = gp_XYZ(p.x, p.y, p.z) - o * p.w;
            double along = d.Dot(z), a = d.Dot(x), b = d.Dot(y);
            if (std::hypot(a, b) <= 1e-15 * (std::fabs(along) + o.Modulus() + 1.0)) a = b = 0.0; // a pole
            gp_XYZ q = (o * p.w + z * along) * c.w + x * (a * c.x - b * c.y) + y * (b * c.x + a * c.y);
            out.poles.push_back(pole{q.X(), q.Y(), q.Z(), p.w * c.w});
        }
    return out;
}

patch extrude(const section &curve, double lo, double hi, const gp_Dir &along)
{
    patch out;
    out.degree[0] = curve.degree, out.degree[1] = 1;
    out.rational = curve.rational;
    out.knots[0] = curve.knots, out.knots[1] = {lo, lo, hi, hi};
    out.w[0] = curve.w;
    out.error = curve.error;
    for (const pole &p : curve.poles)
        for (double v : {lo, hi})
            out.poles.push_back(
                pole{p.x + v * p.w * along.X(), p.y + v * p.w * along.Y(), p.z + v * p.w * along.Z(), p.w});
    return out;
}

patch plane(const Handle(Geom_Plane) & s, const double box[4])
{
    patch out;
    for (int d = 0; d < 2; d++) out.knots[d] = {box[2 * d], box[2 * d], box[2 * d + 1], box[2 * d + 1]};
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) out.poles.push_back(at(s->Value(box[i], box[2 + j]), 1));
    return out;
}

patch spline_patch(Handle(Geom_BSplineSurface) s, const double box[4])
{
    double u0, u1, v0, v1;
    s->Bounds(u0, u1, v0, v1);
    patch out;
    out.degree[0] = s->UDegree(), out.degree[1] = s->VDegree();
    bool clamped = s->UMultiplicity(1) == s->UDegree() + 1 && s->VMultiplicity(1) == s->VDegree() + 1 &&
                   s->UMultiplicity(s->NbUKnots()) == s->UDegree() + 1 &&
                   s->VMultiplicity(s->NbVKnots()) == s->VDegree() + 1;
    if (s->IsUPeriodic() || s->IsVPeriodic() || !clamped || u0 != box[0] || u1 != box[1] || v0 != box[2] ||
        v1 != box[3]) {
        s = Handle(Geom_BSplineSurface)::DownCast(s->Copy());
        // Segment takes the wrong poles of a whole period
        if (s->IsUPeriodic() && box[0] == u0 && std::fabs(box[1] - u1) <= 1e-9 * (u1 - u0)) s->SetUNotPeriodic();
        if (s->IsVPeriodic() && box[2] == v0 && std::fabs(box[3] - v1) <= 1e-9 * (v1 - v0)) s->SetVNotPeriodic();
        s->Segment(box[0], box[1], box[2], box[3], 1e-9 * (box[1] - box[0]), 1e-9 * (box[3] - box[2]));
    }
    out.rational = s->IsURational() || s->IsVRational();
    out.knots[0] = flat(s->UKnots(), s->UMultiplicities(), box[0], box[1]);
    out.knots[1] = flat(s->VKnots(), s->VMultiplicities(), box[2], box[3]);
    for (int i = 1; i <= s->NbUPoles(); i++)
        for (int j = 1; j <= s->NbVPoles(); j++) out.poles.push_back(at(s->Pole(i, j), s->Weight(i, j)));
    return out;
}

// The profile of an elementary surface at u = 0; null: none of them.
bool elementary(const Handle(Geom_Surface) & surface, double lo, double hi, section *out, gp_Ax3 *axes)
{
    Handle(Geom_ElementarySurface) e = Handle(Geom_ElementarySurface)::DownCast(surface);
    if (e.IsNull() || surface->IsKind(STANDARD_TYPE(Geom_Plane))) return false;
    *axes = e->Position();
    gp_Pnt o = axes->Location();
    gp_Vec x(axes->XDirection()), z(axes->Direction());
    if (Handle(Geom_SphericalSurface) s = Handle(Geom_SphericalSurface)::DownCast(e); !s.IsNull()) {
        *out = image(arc(lo, hi), o, x * s->Radius(), z * s->Radius());
    } else if (Handle(Geom_ToroidalSurface) s = Handle(Geom_ToroidalSurface)::DownCast(e); !s.IsNull()) {
        *out = image(arc(lo, hi), o.Translated(x * s->MajorRadius()), x * s->MinorRadius(), z * s->MinorRadius());
    } else { // cylinder, cone
        *out = segment(lo, hi);
        for (double v : {lo, hi}) out->poles.push_back(at(surface->Value(0.0, v), 1));
    }
    return true;
}

} // namespace

section section_of(const Handle(Geom_Curve) & curve, double lo, double hi)
{
    if (Handle(Geom_TrimmedCurve) c = Handle(Geom_TrimmedCurve)::DownCast(curve); !c.IsNull())
        return section_of(c->BasisCurve(), lo, hi);
    if (Handle(Geom_Line) c = Handle(Geom_Line)::DownCast(curve); !c.IsNull()) {
        section s = segment(lo, hi);
        s.poles = {at(c->Value(lo), 1), at(c->Value(hi), 1)};
        return s;
    }
    if (Handle(Geom_Circle) c = Handle(Geom_Circle)::DownCast(curve); !c.IsNull())
        return image(arc(lo, hi), c->Location(), gp_Vec(c->Position().XDirection()) * c->Radius(),
                     gp_Vec(c->Position().YDirection()) * c->Radius());
    if (Handle(Geom_Ellipse) c = Handle(Geom_Ellipse)::DownCast(curve); !c.IsNull())
        return image(arc(lo, hi), c->Location(), gp_Vec(c->Position().XDirection()) * c->MajorRadius(),
                     gp_Vec(c->Position().YDirection()) * c->MinorRadius());
    if (Handle(Geom_BSplineCurve) c = Handle(Geom_BSplineCurve)::DownCast(curve); !c.IsNull())
        return spline_section(c, lo, hi);
    Handle(Geom_Curve) part = new Geom_TrimmedCurve(curve, lo, hi);
    if (curve->IsKind(STANDARD_TYPE(Geom_Parabola)) || curve->IsKind(STANDARD_TYPE(Geom_BezierCurve)))
        return spline_section(GeomConvert::CurveToBSplineCurve(part), lo, hi); // keep their parameters
    GeomConvert_ApproxCurve fit(part, approximation, GeomAbs_C1, MOST_SEGMENTS, MOST_DEGREE);
    if (!fit.HasResult()) throw Standard_Failure("a curve cannot be approximated");
    section s = spline_section(fit.Curve(), lo, hi);
    s.error = fit.MaxError();
    return s;
}

double warp::at(double u) const
{
    if (!arcs) return u;
    int i = std::min(std::max(static_cast<int>(std::floor((u - lo) / step)), 0), n - 1);
    double mid = lo + (i + 0.5) * step;
    return lo + step * (i + 0.5 * (1.0 + std::tan((u - mid) / 2) / std::tan(step / 4)));
}

double warp::slope(double u) const
{
    if (!arcs) return 1.0;
    int i = std::min(std::max(static_cast<int>(std::floor((u - lo) / step)), 0), n - 1);
    double c = std::cos((u - lo - (i + 0.5) * step) / 2);
    return step / (4 * std::tan(step / 4) * c * c);
}

double warp::back(double x) const
{
    if (!arcs) return x;
    int i = std::min(std::max(static_cast<int>(std::floor((x - lo) / step)), 0), n - 1);
    double in = (x - lo) / step - i;
    return lo + (i + 0.5) * step + 2 * std::atan((2 * in - 1) * std::tan(step / 4));
}

kn_cad_type type_of(const Handle(Geom_Surface) & surface)
{
    Handle(Geom_RectangularTrimmedSurface) trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface);
    if (!trimmed.IsNull()) return type_of(trimmed->BasisSurface());
    if (surface->IsKind(STANDARD_TYPE(Geom_Plane))) return KN_CAD_PLANE;
    if (surface->IsKind(STANDARD_TYPE(Geom_CylindricalSurface))) return KN_CAD_CYLINDER;
    if (surface->IsKind(STANDARD_TYPE(Geom_ConicalSurface))) return KN_CAD_CONE;
    if (surface->IsKind(STANDARD_TYPE(Geom_SphericalSurface))) return KN_CAD_SPHERE;
    if (surface->IsKind(STANDARD_TYPE(Geom_ToroidalSurface))) return KN_CAD_TORUS;
    if (surface->IsKind(STANDARD_TYPE(Geom_SurfaceOfLinearExtrusion))) return KN_CAD_EXTRUSION;
    if (surface->IsKind(STANDARD_TYPE(Geom_SurfaceOfRevolution))) return KN_CAD_REVOLUTION;
    if (surface->IsKind(STANDARD_TYPE(Geom_BezierSurface))) return KN_CAD_BEZIER;
    if (surface->IsKind(STANDARD_TYPE(Geom_BSplineSurface))) return KN_CAD_BSPLINE;
    if (surface->IsKind(STANDARD_TYPE(Geom_OffsetSurface))) return KN_CAD_OFFSET;
    return KN_CAD_OTHER;
}

patch patch_of(const Handle(Geom_Surface) & surface, const double box[4])
{
    section profile;
    gp_Ax3 axes;
    if (Handle(Geom_RectangularTrimmedSurface) s = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface);
        !s.IsNull())
        return patch_of(s->BasisSurface(), box);
    if (Handle(Geom_Plane) s = Handle(Geom_Plane)::DownCast(surface); !s.IsNull()) return plane(s, box);
    if (elementary(surface, box[2], box[3], &profile, &axes)) return revolve(profile, box[0], box[1], axes);
    if (Handle(Geom_SurfaceOfRevolution) s = Handle(Geom_SurfaceOfRevolution)::DownCast(surface); !s.IsNull())
        return revolve(section_of(s->BasisCurve(), box[2], box[3]), box[0], box[1],
                       gp_Ax3(gp_Ax2(s->Location(), s->Direction())));
    if (Handle(Geom_SurfaceOfLinearExtrusion) s = Handle(Geom_SurfaceOfLinearExtrusion)::DownCast(surface);
        !s.IsNull())
        return extrude(section_of(s->BasisCurve(), box[0], box[1]), box[2], box[3], s->Direction());
    if (Handle(Geom_BSplineSurface) s = Handle(Geom_BSplineSurface)::DownCast(surface); !s.IsNull())
        return spline_patch(s, box);
    Handle(Geom_Surface) part = new Geom_RectangularTrimmedSurface(surface, box[0], box[1], box[2], box[3]);
    if (surface->IsKind(STANDARD_TYPE(Geom_BezierSurface)))
        return spline_patch(GeomConvert::SurfaceToBSplineSurface(part), box);
    GeomConvert_ApproxSurface fit(part, approximation, GeomAbs_C1, GeomAbs_C1, MOST_DEGREE, MOST_DEGREE,
                                  MOST_SEGMENTS, 1);
    if (!fit.HasResult()) throw Standard_Failure("a surface cannot be approximated");
    patch out = spline_patch(fit.Surface(), box);
    out.error = fit.MaxError();
    return out;
}

} // namespace kn_occt
