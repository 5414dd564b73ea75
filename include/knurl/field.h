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

// ---- fields of the core; more come from expressions and images (bridges) ----

// f = the spline at place->uv.
// in:     spline: two variables over [0,1]^2, dimension 1; borrowed.
// fails:  KN_EDOMAIN another shape or domain, and what kn_spline_check finds; out unchanged.
// error:  gamma(6 p + 6 q + 2) of the sum of absolute values; of a rational one over the weight, twice that.
KN_API KN_CHECKED kn_status kn_field_spline(kn_ctx *ctx, kn_field *out, const kn_spline *spline);

// Samples over [0,1]^2, u slowest, between which values are bilinear: sample i of n lies at i / (n - 1), or at i / n
// in a direction that is closed, where the last one is followed by the first.
typedef struct kn_field_samples {
    int n[2]; // at least 2, of a closed direction at least 1
    bool closed[2];
    const double *values; // n[0] * n[1], finite; borrowed
} kn_field_samples;
// in:     samples: borrowed with all that it points to.
// out:    beyond [0,1] the border's values go on; a closed direction wraps.
// fails:  KN_EDOMAIN n, or a value that is not finite; out unchanged.
// error:  gamma(9) of the largest of the four samples.
KN_API KN_CHECKED kn_status kn_field_grid(kn_ctx *ctx, kn_field *out, const kn_field_samples *samples);

// Gradient noise at a point in space: 0 on the integer lattice, C2, and another function for each seed.
// out:    in [-1,1]; about +-0.85 is reached. 0 where a coordinate is not finite or 2^51 and more, where doubles have
//         no fraction left.
// error:  1e-12: eight products of three weights, off by 31 gamma(7) each, with a sum of two. The same bits
//         everywhere.
// source: Perlin, Improving noise, SIGGRAPH 2002, with gradients chosen by a hash of the lattice point and the seed
//         (Steele, Lea & Flood, Fast splittable pseudorandom number generators, OOPSLA 2014: SplitMix64) in place of
//         a table.
KN_API double kn_noise(const double point[3], uint64_t seed);

// Noise of place->point: octaves of half the size and half the strength each, together in [lo,hi].
typedef struct kn_field_octaves {
    double size; // of the largest lumps, length units
    int octaves; // 0: 1; at most 32
    uint64_t seed;
    double lo, hi; // both 0: -1 and 1
} kn_field_octaves;
// in:     octaves: borrowed.
// fails:  KN_EDOMAIN a size that is not positive, lo > hi, not finite, octaves < 0; KN_ELIMIT octaves; out unchanged.
KN_API KN_CHECKED kn_status kn_field_noise(kn_ctx *ctx, kn_field *out, const kn_field_octaves *octaves);

#ifdef __cplusplus
}
#endif
#endif
