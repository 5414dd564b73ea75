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

// ---- extents.c ----
// What patches occupy of the cell at `offset` from their own: u and v in its coordinates, and heights.
typedef struct kn_job_extent {
    int offset[2];
    double lo[2], hi[2], w[2];
    bool drifts; // beyond open ends: a mesh, which follows n wherever that goes
} kn_job_extent;
typedef struct kn_job_extents {
    kn_job_extent *list;
    int count, room;
} kn_job_extents;
// What the tiles of a cell occupy; the room of *out is used again.
kn_status kn_job_cell_extents(kn_ctx *ctx, kn_job_extents *out, const kn_job *job, int surface, const int cell[2]);
void kn_job_extents_clear(kn_ctx *ctx, kn_job_extents *extents);

// ---- bounds.c ----
typedef struct kn_job_bounds_pieces { // of a spline, on a grid of breaks
    kn_bezier *list;
    size_t n;
    double *breaks[2];
    int nbreaks[2];
} kn_job_bounds_pieces;
typedef struct kn_job_bounds_surface {
    kn_job_bounds_pieces s; // of S; none where T is taken as a volume
    kn_job_bounds_pieces n; // of n, where meshes may reach beyond the domain
    kn_spline volume;       // T over bounds->w; empty: S and n are taken
    double size;            // of S's coordinates
} kn_job_bounds_surface;
typedef struct kn_job_bounds {
    const kn_job *job;
    double w[2]; // heights of the tile as modelled, both ways
    kn_job_bounds_surface *surfaces;
} kn_job_bounds;
double kn_job_top(const kn_job *job); // max |w| of the tile, unvaried, length units
bool kn_job_has_mesh(const kn_job *job);
// The job's shells, lines and patches are there.
kn_status kn_job_bounds_init(kn_ctx *ctx, kn_job_bounds *out, const kn_job *job);
void kn_job_bounds_clear(kn_ctx *ctx, kn_job_bounds *bounds);
// A box that contains what patches compose to that lie within `extent` in the coordinates of the place (whose turn
// and the extent's offset are not looked at). -INFINITY, INFINITY: not known.
kn_status kn_job_bounds_box(kn_ctx *ctx, double lo[3], double hi[3], const kn_job_bounds *bounds,
                            const kn_job_place *place, const kn_job_extent *extent);
// Where an extent of a cell lies, and what it is in the coordinates there; false: it is cut off.
bool kn_job_place_extent(kn_job_place *place, kn_job_extent *e, const kn_job *job, int surface, const int cell[2]);
// One that contains all tiles of a cell, which occupy `extents`.
kn_status kn_job_bounds_cell(kn_ctx *ctx, double lo[3], double hi[3], const kn_job_bounds *bounds, int surface,
                             const int cell[2], const kn_job_extents *extents);
// At least the largest n . direction, n the unit normal, over a cell inside the domain.
double kn_job_bounds_facing(const kn_job_bounds *bounds, int surface, const int cell[2], const double direction[3]);

// ---- view.c ----
typedef struct kn_job_camera {
    kn_job_view view;
    double eye[4]; // homogeneous; eye[3] 0: the direction towards the camera, unit length
} kn_job_camera;
kn_status kn_job_camera_init(kn_ctx *ctx, kn_job_camera *out, const kn_job_view *view);
// Whether a box is certainly out of the picture.
bool kn_job_out_of_view(const kn_job_camera *camera, const double lo[3], const double hi[3]);
// The larger side of the image of a box, in pixels; INFINITY where the box reaches the camera.
double kn_job_pixels(const kn_job_camera *camera, const double lo[3], const double hi[3]);
// Pixels that a unit of length in the box spans, at most.
double kn_job_pixel_scale(const kn_job_camera *camera, const double lo[3], const double hi[3]);
// Whether the base around a cell certainly hides its tiles (kn_job_view.hidden); lo, hi: kn_job_bounds_cell.
kn_status kn_job_is_hidden(kn_ctx *ctx, bool *hidden, const kn_job_bounds *bounds, const kn_job_camera *camera,
                           int surface, const int cell[2], const kn_job_extents *extents, const double lo[3],
                           const double hi[3]);

#endif
