// SPDX-License-Identifier: Apache-2.0
// Scalar fields over a base: what varies a texture from place to place.
#ifndef KNURL_FIELD_H
#define KNURL_FIELD_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// A place on a base, as far as a field asks for it (kn_field.needs).
typedef struct kn_place {
    int surface;         // of the base
    double uv[2];        // in [0,1]^2, which stands for the surface's domain
    double point[3];     // S(u,v), KN_NEEDS_POINT
    double normal[3];    // unit length, KN_NEEDS_NORMAL
    double curvature[2]; // mean and Gaussian, KN_NEEDS_CURVATURE
} kn_place;
enum { KN_NEEDS_POINT = 1, KN_NEEDS_NORMAL = 2, KN_NEEDS_CURVATURE = 4 };

// A number for every place. value may be called on any thread, several at a time, and depends on the place alone.
// value NULL: no field.
typedef struct kn_field {
    double (*value)(const void *user, const kn_place *place);
    const void *user; // borrowed
    unsigned needs;
} kn_field;

#ifdef __cplusplus
}
#endif
#endif
