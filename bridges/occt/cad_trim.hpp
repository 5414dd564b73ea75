// SPDX-License-Identifier: Apache-2.0
// The outline of a face of OCCT in the square of its spline's parameters.
#ifndef BRIDGES_OCCT_CAD_TRIM_HPP
#define BRIDGES_OCCT_CAD_TRIM_HPP

#include <vector>

#include <Geom2d_Curve.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include "bridges/occt/cad_curve.hpp"

namespace kn_occt
{

// One use of an edge by a face, in the order and sense in which its loop runs (the face taken as FORWARD).
struct use {
    TopoDS_Edge edge;
    Handle(Geom2d_Curve) curve; // in OCCT's parameters
    double first, last;
    bool reversed; // the loop runs from last to first
    bool degenerate;
    // The parameter in which the curve in the square is made: OCCT's u is first + (pace.back(x) - from) * rate.
    warp pace;
    double from = 0.0, rate = 1.0, ends[2] = {0.0, 0.0}; // x at first and last
    bool paced = false;                                  // else x is u
    double at(double x) const;
    double slope(double x) const; // du / dx
};
typedef std::vector<use> loop;

// From OCCT's (u,v) to [0,1]^2: warped, scaled.
struct chart {
    warp w[2];
    double lo[2], hi[2];
    double size[2]; // mm in the unit of r and of t, at most about
    void at(const gp_Pnt2d &p, double out[2]) const;
    void along(const gp_Pnt2d &p, const gp_Vec2d &v, double out[2]) const;
};

// A curve in the square as a polynomial spline.
struct outline {
    int degree = 1;
    std::vector<double> knots, x, y;
    double error = 0.0; // mm, estimated
};

// fails: throws Standard_Failure: an edge without a curve on the face, edges that do not form loops.
std::vector<loop> loops_of(const TopoDS_Face &shape);
// The box of the loops' curves, u0, u1, v0, v1: at the ends of the surface where it comes near them.
void box_of(double box[4], const TopoDS_Face &face, const std::vector<loop> &loops);
// Lines and polynomial splines as they are, others as cubics that are met to about tolerance, mm.
outline outline_of(const use &u, const chart &c, double tolerance);
// In the parameter of an edge's curve in space, which is `line` over OCCT's [first,last]: all of it at the right time,
// to about tolerance.
outline paced_outline(use u, const chart &c, const section &line, double first, double last, double tolerance);

} // namespace kn_occt

#endif
