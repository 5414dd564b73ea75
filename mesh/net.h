// SPDX-License-Identifier: Apache-2.0
// Inside mesh: points and normals of a patch, and what adds to the arrays of a mesh.
#ifndef MESH_NET_H
#define MESH_NET_H

#include "kernel/context.h"

#include <knurl/mesh.h>

// A patch and its differences, the components of a point slowest; w has the fourth, homogeneous one.
typedef struct kn_patch_net {
    int n, m, ncomp;    // degrees; 3, or 4 when rational
    const double *coef; // (ncomp, n + 1, m + 1)
    double *step;       // (ncomp, n, m + 1): coefficients of dr / n
    double vanished;    // |normal| at or below this is no normal
} kn_patch_net;

// In scratch.
kn_status kn_patch_net_init(kn_ctx *ctx, kn_patch_net *net, const kn_bezier *patch);
size_t kn_patch_net_room(const kn_patch_net *net); // numbers of `work`

// A parameter and 1 less it, of which the smaller one is exact.
typedef struct kn_mesh_place {
    double at, below;
} kn_mesh_place;
// At (r,t): on edges the bits of the grid of kn_mesh_add_patch, which depend on the edge alone, whichever way it
// runs.
void kn_patch_net_point(double position[3], double normal[3], const kn_patch_net *net, const kn_mesh_place *r,
                        const kn_mesh_place *t, double sign, double *work);

// out[x] = sum_k weight[k] row[k * length + x], k = 0 .. n, in an order that reversing k does not change.
void kn_patch_net_combine(double *restrict out, const double *restrict weight, const double *restrict row, int n,
                          size_t length);
void kn_patch_net_differences(double *out, const double *in, int n);
// normal = direction of (dr x dt), flipped by sign; false where it vanishes. value, dr, dt: ncomp numbers, those of a
// rational patch homogeneous.
bool kn_patch_net_unit_normal(double normal[3], const kn_patch_net *net, const double *value, const double *dr,
                              const double *dt, double sign);
void kn_patch_net_limit_normal(double normal[3], const kn_patch_net *net, double r, double t, double sign,
                               double *work);

// A triangle, unless two of its corners coincide.
void kn_mesh_add_triangle(kn_mesh *mesh, size_t p, size_t q, size_t r);
// Room for this many more, with normals or, where the mesh has none, without; a failure leaves the mesh as it was,
// though its arrays may be larger than they say.
kn_status kn_mesh_reserve(kn_ctx *ctx, kn_mesh *mesh, size_t vertices, size_t triangles, bool normals);
// KN_EDOMAIN: a triangle refers to no vertex.
kn_status kn_mesh_check(kn_ctx *ctx, const kn_mesh *mesh);
// What kn_mesh_add_patch asks of its operands.
kn_status kn_mesh_check_patch(kn_ctx *ctx, const kn_mesh *mesh, const kn_bezier *patch, const int segments[2]);

#endif
