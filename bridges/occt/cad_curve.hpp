// SPDX-License-Identifier: Apache-2.0
// Curves and surfaces of OCCT as splines in homogeneous coordinates, and what becomes of their parameters.
#ifndef BRIDGES_OCCT_CAD_CURVE_HPP
#define BRIDGES_OCCT_CAD_CURVE_HPP

#include <vector>

#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>

#include <knurl/cad.h>

namespace kn_occt
{

// Where a parameter of OCCT's goes in the spline. A circle's angle u becomes that of rational quadratic arcs:
// n of them
// over steps h from lo, joined where angle and parameter agree. In an arc with weights 1, cos(h/2), 1 about
// the angle m
// the parameter x in [0,1] has tan((u - m)/2) = (2 x - 1) tan(h/4).
struct warp {
    bool arcs = false;
    double lo = 0.0, step = 1.0;
    int n = 1;
    double at(double u) const;
    double slope(double u) const;
    double back(double x) const; // of at
};

struct pole {
    double x, y, z, w; // homogeneous
};

// A curve of a surface's parameter.
struct section {
    int degree = 1;
    bool rational = false;
    std::vector<double> knots;
    std::vector<pole> poles;
    warp w;
    double error = 0.0;
};

// A surface over [u0,u1] x [v0,v1].
struct patch {
    int degree[2] = {1, 1};
    bool rational = false;
    std::vector<double> knots[2];
    std::vector<pole> poles; // v fastest
    warp w[2];
    double error = 0.0; // of what could only be approximated, as OCCT estimates it
};

// A curve over [lo,hi]. Exact where it is a line, a conic or a spline. Throws what OCCT throws.
section section_of(const Handle(Geom_Curve) & curve, double lo, double hi);
kn_cad_type type_of(const Handle(Geom_Surface) & surface);
// Exact where the surface is made of lines, conics and splines. Throws what OCCT throws.
patch patch_of(const Handle(Geom_Surface) & surface, const double box[4]); // u0, u1, v0, v1

} // namespace kn_occt

#endif
