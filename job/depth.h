// SPDX-License-Identifier: Apache-2.0
// Inside job: a depth buffer that certainly knows what is in front of a box.
#ifndef JOB_DEPTH_H
#define JOB_DEPTH_H

#include "job/placement.h"

enum {
    KN_JOB_DEPTH_PIXELS = 512, // at most, each way: the picture may have more
    KN_JOB_DEPTH_LEVELS = 10,  // of the pyramid: down to one pixel
};
typedef struct kn_job_depth {
    const kn_job_camera *camera;
    int size[2], nlevels;
    int wide[KN_JOB_DEPTH_LEVELS], tall[KN_JOB_DEPTH_LEVELS];
    double *level[KN_JOB_DEPTH_LEVELS];
} kn_job_depth;
// Nothing is in front of anything. camera: borrowed.
kn_status kn_job_depth_init(kn_ctx *ctx, kn_job_depth *out, const kn_job_camera *camera);
void kn_job_depth_clear(kn_ctx *ctx, kn_job_depth *depth);

// Where a point is in the buffer: pixels, how far all within `radius` of it may be off, and how deep they are.
typedef struct kn_job_dot {
    double at[2], off[2], near, far;
} kn_job_dot;
// false: it may be nearer than the picture begins, or very far out of it.
bool kn_job_depth_point(kn_job_dot *out, const kn_job_depth *depth, const double p[3], double radius);

// One arc of the border of a disc: from there to there in the picture, and how far it may be off the segment.
typedef struct kn_job_arc {
    double from[2], to[2], off;
} kn_job_arc;
// A disc of a surface no deeper than `depth`, inside a border that closes (within 1e-3 pixels).
void kn_job_depth_disc(kn_job_depth *d, const kn_job_arc *arcs, int n, double depth);
// Once all discs are there; then any thread may ask whether a box is behind them wherever it is in the picture.
void kn_job_depth_finish(kn_job_depth *depth);
bool kn_job_depth_hides(const kn_job_depth *depth, const double lo[3], const double hi[3]);

// ---- occlude.c ----
// What of the base, or of covering tiles in its place, the camera sees first. Not with fields, nor over volumes.
kn_status kn_job_occlude(kn_ctx *ctx, kn_job_depth *out, const kn_job_bounds *bounds, const kn_job_camera *camera);

#endif
