// SPDX-License-Identifier: Apache-2.0
// Slices of textured objects: contours at heights z, for layered manufacturing.
// Source: Elber, Geometric Texture Modeling, IEEE CG&A 25(4), 2005: only tiles near the contouring level are made.
#ifndef KNURL_SLICE_H
#define KNURL_SLICE_H

#include <knurl/job.h>

#ifdef __cplusplus
extern "C" {
#endif

// A contour in the plane of its layer: material to the left of its run, outlines counterclockwise and holes clockwise,
// for surfaces that are oriented outwards.
typedef struct kn_slice_loop {
    const double *points; // (x, y), two numbers each
    size_t npoints;       // at least 2; the last point of a closed one is not the first again
    bool closed;          // false: it ends at an open edge of what was sliced
    int part, layer;      // kn_patch_id of the patch that its first point is on
} kn_slice_loop;

typedef struct kn_slice {
    size_t index; // 0 .. count - 1
    double z;
    const kn_slice_loop *loops; // in an order that does not depend on the number of threads
    size_t nloops, nopen;       // nopen of them are not closed
    double gap;                 // the largest distance of two ends that were joined; 0: all were equal bit for bit
    // How far points lie from the contour of their patch at z, at most: certified, rounding included; of meshes, from
    // that of their triangles. Above tol only where doubtful > 0.
    double error;
    // Places where rounding decided, and which `error` leaves out: planes that touch, double points, a tolerance
    // finer than the numbers; ends on trims that are farther apart than `join`.
    size_t doubtful;
} kn_slice;

// Takes one layer; z increasing, on the thread that called. What it answers other than KN_OK ends the work.
typedef kn_status (*kn_slice_fn)(kn_ctx *ctx, void *user, const kn_slice *layer);

typedef struct kn_slice_options {
    double first, step; // layer k lies at z = first + k step; step > 0
    size_t count;       // of layers, at most 2^20
    double tol;         // of contours, length units, above 0
    double join;        // ends that are no farther apart count as one; 0: tol, or what the job's report lets expect
} kn_slice_options;

// A sink that cuts every patch it gets with all layers: contours are polylines on composed patches, within tol of the
// true contour, certified from coefficients; points on edges depend on the edge's control points alone, so that
// contours of neighbouring patches meet bit for bit. Where a patch only touches a plane it counts as above it.
// A trimmed patch: the contour of all of it, cut by the trim in (r,t). The patches on the two sides of a trim agree
// to the job's crossing_error alone, and so do the ends there: they are joined, and `gap` tells over which distance.
// Surfaces, and the free faces of volumes; meshes by their triangles; curves have no inside and no contours.
// fn gets all layers, empty ones among them, when the job ends.
// out:    overwritten; kn_sink_close. bytes: none.
// fails:  KN_EDOMAIN (options), KN_ENOMEM; out unchanged. The job: KN_EUNDEFINED a weight that is not positive,
//         KN_ELIMIT; what fn answers.
// memory: the contours of all layers.
KN_API KN_CHECKED kn_status kn_slice_sink(kn_ctx *ctx, kn_sink *out, const kn_slice_options *options, kn_slice_fn fn,
                                          void *user);

typedef struct kn_slice_job_report {
    size_t groups;     // of layers
    size_t cells;      // composed, each time that a group asked for it
    size_t most_cells; // of one group
} kn_slice_job_report;
// Slices jobs (layers of one object: kn_job_run_layers) layer by layer: only cells near a layer are composed, for a
// group of neighbouring layers at a time, and forgotten again.
// in:     njobs >= 1, all of one object. report: NULL: not wanted.
// fails:  as kn_slice_sink, kn_job_slabs_create, kn_job_run_cells; what fn answers.
// memory: 8 bytes for each cell of the jobs, and the patches and contours of about 2000 cells, or of one layer.
KN_API KN_CHECKED kn_status kn_slice_job(kn_ctx *ctx, const kn_job *const *jobs, int njobs,
                                         const kn_slice_options *options, kn_slice_fn fn, void *user,
                                         kn_slice_job_report *report);

#ifdef __cplusplus
}
#endif
#endif
