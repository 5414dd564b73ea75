// SPDX-License-Identifier: Apache-2.0
// Pictures of triangle scenes: a path tracer on Embree in a small photographic studio.
#ifndef BRIDGES_RENDER_H
#define BRIDGES_RENDER_H

#include "bridges/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum kn_up_axis { KN_UP_Z, KN_UP_Y } kn_up_axis;

enum { KN_RENDER_MAX_SIDE = 1 << 14, KN_RENDER_MAX_SAMPLES = 1 << 14, KN_RENDER_MAX_BOUNCES = 32 };

// Zero means the default in every field.
typedef struct kn_render_options {
    int width, height; // pixels; 0: 1600 and 1200
    int samples;       // paths for a pixel of fine detail; half as many for smooth ones; 0: 24
    int bounces;       // surfaces of the object that a path meets; 0: 4
    int up;            // kn_up_axis of the scene's coordinates: KN_UP_Z for models, KN_UP_Y for glTF
    double azimuth;    // degrees, counterclockwise from above, from the three-quarter view with +x at the right
    double elevation;  // of the camera above the horizon, degrees, below 90; 0: 18
    double fov;        // vertical angle of view, degrees, below 120; 0: 24
    double exposure;   // stops added to the lights
    double flatness;   // share in [0,1] of the object's picture that is its plain colour without light: for colours
                       // that a legend explains
    uint32_t seed;     // of the sampling pattern
} kn_render_options;
KN_API kn_render_options kn_render_defaults(void);

// A picture of the scene, framed so that all of it is seen with a margin, standing on a seamless ground and lit by
// soft key, fill, top and rim lights and a dome. Metallic-roughness materials (GGX). Stage "render".
// in:    normals may be missing (flat triangles); colours of vertices lie in [0,1]. The scene may have any unit and place.
// out:   rgb holds 3 width height bytes, sRGB, row by row from the top.
// fails: KN_EDOMAIN no triangles, a scene of no extent, a vertex that is not finite or an index out of range, options
//        out of range; KN_ELIMIT a side or samples above KN_RENDER_MAX_*; KN_ECANCELLED; KN_ENOMEM. rgb is then
//        unspecified.
// error: a Monte Carlo estimate; the same bytes for any number of threads on one machine.
// cost:  5 to 12 rays a sample, 8 samples a pixel of plain ground; 100 bytes a triangle (Embree's hierarchy), 24 a
//        vertex, 124 a pixel.
// source: Kajiya, The rendering equation, 1986; Walter et al., Microfacet models for refraction, 2007 (GGX); Heitz,
//        Sampling the GGX distribution of visible normals, 2018; Veach & Guibas, multiple importance sampling, 1995.
KN_API KN_CHECKED kn_status kn_render(kn_ctx *ctx, uint8_t *rgb, const kn_scene *scene,
                                      const kn_render_options *options);

#ifdef __cplusplus
}
#endif
#endif
