// SPDX-License-Identifier: Apache-2.0
// Inside mesh: vertices on the unit sphere.
#ifndef MESH_SPHERE_H
#define MESH_SPHERE_H

#include "mesh/rings.h"

#include <math.h>

// det(p, q, r) as det(p, q - p, r - p).
double kn_mesh_turn_value(const double *p, const double *q, const double *r, double *bound);
// The sign of det(p, q, r) where rounding cannot change it, 0 where it could. 1: seen from outside, the triangle on
// the sphere runs counterclockwise.
static inline int kn_mesh_turn(const double *p, const double *q, const double *r)
{
    double bound, value = kn_mesh_turn_value(p, q, r, &bound);
    return value > bound ? 1 : value < -bound ? -1 : 0;
}

// What is moved about: xyz[3 v] of vertices that have a ring, on the sphere; position: where they are in space.
typedef struct kn_mesh_globe {
    const kn_mesh_rings *rings;
    const double *position;
    double *xyz;
    double scale; // areas in space times this add up to those of the sphere
} kn_mesh_globe;
// Where all triangles around v certainly run counterclockwise: a place for v, whose neighbours have theirs; around it
// they are seen from ring[0] without an overlap. false: none is found.
bool kn_mesh_globe_place(kn_mesh_globe *globe, uint32_t v, const uint32_t *ring, int k);
// Moves v to where its triangles are less stretched, or not at all; none turns over. Returns how far, in mean lengths
// of its edges.
double kn_mesh_globe_relax(kn_mesh_globe *globe, uint32_t v);
// Sets scale, from the vertices alive[0 .. n-1].
void kn_mesh_globe_measure(kn_mesh_globe *globe, const uint32_t *alive, size_t n);

#endif
