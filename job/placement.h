// SPDX-License-Identifier: Apache-2.0
// Inside job: where tiles lie and which cells there are.
#ifndef JOB_PLACEMENT_H
#define JOB_PLACEMENT_H

#include "job/internal.h"

// ---- scatter.c ----
// job->darts, in the order of cells, where the options ask for a scatter; shells and lines are there.
kn_status kn_job_scatter_tiles(kn_ctx *ctx, kn_job *job);
// The first of job->darts that is not of a cell before this one.
size_t kn_job_first_dart(const kn_job *job, size_t cell);

// ---- bounds.c ----
// What patches occupy of the cell at `offset` from their own: u and v in its coordinates, and heights.
typedef struct kn_job_extent {
    int offset[2];
    double lo[2], hi[2], w[2];
} kn_job_extent;
typedef struct kn_job_bounds_surface {
    kn_bezier *pieces; // of S, on a grid of breaks; none where T is taken as a volume
    size_t npieces;
    double *breaks[2];
    int nbreaks[2];
    kn_spline volume; // T over bounds->w; empty: S and n are taken
    double size;      // of S's coordinates
} kn_job_bounds_surface;
typedef struct kn_job_bounds {
    const kn_job *job;
    double w[2];
    kn_job_bounds_surface *surfaces;
} kn_job_bounds;
// w: the heights that are asked for later. The job's shells and lines are there.
kn_status kn_job_bounds_init(kn_ctx *ctx, kn_job_bounds *out, const kn_job *job, const double w[2]);
void kn_job_bounds_clear(kn_ctx *ctx, kn_job_bounds *bounds);
// A box that contains what patches compose to that lie within `extent` in the coordinates of the place (whose turn
// and the extent's offset are not looked at). -INFINITY, INFINITY: not known.
kn_status kn_job_bounds_box(kn_ctx *ctx, double lo[3], double hi[3], const kn_job_bounds *bounds,
                            const kn_job_place *place, const kn_job_extent *extent);

#endif
