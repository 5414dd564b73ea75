// SPDX-License-Identifier: Apache-2.0
// Small bases and tiles, and a sink that keeps what it gets, for the tests of tiles and jobs.
#ifndef TESTS_SUPPORT_SCENE_H
#define TESTS_SUPPORT_SCENE_H

#include <knurl/job.h>

// ---- bases ----
// A bicubic patch over [0,1]^2 that bends by `bend`.
void scene_bicubic(kn_ctx *ctx, kn_spline *out, double bend);
// An eighth of a torus as one rational biquadratic patch.
void scene_torus(kn_ctx *ctx, kn_spline *out);
// A whole cylinder, closed in u: a rational quadratic of four spans.
void scene_cylinder(kn_ctx *ctx, kn_spline *out);
// A bicubic spline of 3 x 2 spans of unequal length.
void scene_spline(kn_ctx *ctx, kn_spline *out);

// ---- tiles ----
// A multilinear spline over [0,1]^nvars with these corners, three numbers each, the last variable fastest.
void scene_multilinear(kn_ctx *ctx, kn_spline *out, int nvars, const double *corner);
// To part 0 a polynomial patch of degrees (m, n): component by component, its control points [i][j] with j fastest.
void scene_add_patch(kn_ctx *ctx, kn_tile *tile, int m, int n, const double *coef);
// A tilted bilinear plate over [0.1, 0.9]^2 of the cell, from w = 0.2 to w = 1: it composes cheaply.
void scene_plate(kn_ctx *ctx, kn_tile *out);
// A trilinear box over [0.1, 0.6] x [0.2, 0.9] of the cell, from w = 0 to w = 0.5: a closed body.
void scene_box(kn_ctx *ctx, kn_tile *out);
// Four biquadratic patches that cover the cell, run in different directions, and are 0 on its border.
void scene_dome(kn_ctx *ctx, kn_tile *out);
// One patch of degrees (2, 1): a sheet from u = -0.25 to u = 1.25 over v in [0.25, 0.75], bent in w.
void scene_strip(kn_ctx *ctx, kn_tile *out);
// One bilinear patch turned by 30 degrees, whose corners reach into the neighbours.
void scene_diamond(kn_ctx *ctx, kn_tile *out);

// ---- a sink that keeps copies of all patches ----
typedef struct scene_result {
    kn_patch *patches; // with coefficients of their own
    size_t count, room;
    int begun, ended, closed;
} scene_result;
kn_sink scene_sink(scene_result *result);
void scene_result_clear(scene_result *result);
// Runs the job into such a sink, which has to begin, end and be closed once.
void scene_run(kn_ctx *ctx, const kn_job *job, scene_result *r);

// ---- jobs ----
// The parameter that lies so many cells from the corner of cell 0 of a surface of the job, wrapped where the shell is
// closed; beyond open ends the last cell goes on.
long double scene_parameter(const kn_job *job, int surface, int var, long double cells);

// ---- allocations that fail ----
// A job over what `make` makes, created in ctx and destroyed again; base and tile live in a context of their own.
typedef void (*scene_make)(kn_ctx *safe, kn_spline *base, kn_tile *tile);
kn_status scene_try_job(kn_ctx *ctx, scene_make make, const kn_job_options *options);

// Shoelace of a trim's curves, which are of degree 1; all of the square where there is none.
double scene_trim_area(const kn_trim *trim);

#endif
