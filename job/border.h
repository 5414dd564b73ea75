// SPDX-License-Identifier: Apache-2.0
// Inside job: the borders of trimmed surfaces, as segments on the lattice of cells.
#ifndef JOB_BORDER_H
#define JOB_BORDER_H

#include "job/internal.h"

// In lattice coordinates of a surface of the job (whole numbers on cell lines); the region lies to the left.
typedef struct kn_job_segment {
    double from[2], to[2];
} kn_job_segment;

// Of one surface of the job. Sides of the square of which the trim is a part are not among them. Where the surface is
// closed the segments come again a turn before and after.
typedef struct kn_job_border_list {
    kn_job_segment *list;
    size_t n, room;
    int first, ncolumns; // of cells, along u
    size_t *start;       // ncolumns + 1: where the segments that a column may have begin in `index`
    uint32_t *index;
    double off;        // of the segments from the border, at most
    double top, speed; // of kn_job_border_speed, where the tile has a mesh
} kn_job_border_list;

struct kn_job_borders {
    kn_trim *trims; // copies, of the surfaces of the base
    int ntrims;
    kn_job_border_list *surfaces; // of the job
    int nsurfaces;
    uint64_t *whole; // a bit for each cell that lies in the region with all that its tiles occupy
};

// ---- border.c ----
// job->borders from options.trims; shells and lines are there.
kn_status kn_job_borders_init(kn_ctx *ctx, kn_job *job);
void kn_job_borders_clear(kn_ctx *ctx, kn_job *job);
// Where x on the lattice lies on an axis of the surface's domain, of x in [0,1] of its origin's.
double kn_job_lattice_of(const kn_job_surface *s, int d, double x);
// Over the domain and |w| <= top, T moves by at most *speed times the way on the lattice.
kn_status kn_job_border_speed(kn_ctx *ctx, double *speed, const kn_job *job, int surface, double top);

// ---- border_find.c ----
bool kn_job_is_bordered(const kn_job *job, int surface); // its base is trimmed
// Whether the border may touch the box, on the lattice.
bool kn_job_border_touches(const kn_job *job, int surface, const double lo[2], const double hi[2]);
// The segments that may touch the box: `room` of them at most; returns how many there are.
size_t kn_job_border_take(kn_job_segment *out, size_t room, const kn_job *job, int surface, const double lo[2],
                          const double hi[2]);
// Whether a place on the lattice lies in the region; beyond the domain: the nearest place in it.
kn_status kn_job_border_side(kn_ctx *ctx, kn_answer *out, const kn_job *job, int surface, const double x[2]);
// Where a cell lies: KN_UNKNOWN, the border touches it. memo: what was last asked for; .surface -1: nothing.
typedef struct kn_job_border_memo {
    int surface, cell[2];
    kn_answer answer;
} kn_job_border_memo;
kn_status kn_job_border_cell(kn_ctx *ctx, kn_answer *out, kn_job_border_memo *memo, const kn_job *job, int surface,
                             const int cell[2]);

// ---- border_cut.c ----
// Regions of the [0,1]^2 of a part of a patch; an empty one is all of it.
typedef struct kn_job_regions {
    kn_trim *list;
    int n;
} kn_job_regions;
void kn_job_regions_clear(kn_ctx *ctx, kn_job_regions *regions);
// What of a region of D goes into the trimmed base, appended to an empty list: none where it lies beyond. The pieces
// of x are there. plan->crossing, as far as the cuts are off.
struct kn_crossing;
kn_status kn_job_border_cut(kn_ctx *ctx, kn_job_regions *out, struct kn_crossing *x, const kn_trim *region);

// ---- border_unite.c ----
// Regions that lie side by side, along cuts that have the same points on both sides, become one; where that cannot be
// done they stay what they are.
kn_status kn_job_unite_regions(kn_ctx *ctx, kn_job_regions *regions);

// ---- border_clip.c ----
// Whether tiles are cut off at borders of trims.
bool kn_job_clips_trims(const kn_job *job);
// How d, in the coordinates of the place's cell, lies to the border of the place's surface: KN_UNKNOWN, it may cross.
kn_status kn_job_border_of_patch(kn_ctx *ctx, kn_answer *out, const kn_job_cell_plan *plan, const kn_job_place *place,
                                 const kn_bezier *d);
// The cell lies in the region with all its tiles: nothing is to be cut.
bool kn_job_border_is_whole(const kn_job_cell_plan *plan);
// How a box on the lattice of a surface lies to its border.
kn_status kn_job_border_of_box(kn_ctx *ctx, kn_answer *out, const kn_job *job, int surface, const double lo[2],
                               const double hi[2]);
// Appends what the border leaves of a leaf whose piece is there; leaf->trim is what there is of it without the border.
kn_status kn_job_clip_leaf(kn_ctx *ctx, kn_job_cell_plan *plan, kn_job_leaf *leaf, const kn_job_place *place,
                           const kn_bezier *d);

// ---- border_mesh.c ----
// What of a mesh of a part, placed in the plan's cell, lies in the region; plan->crossing, as far as the cuts are off.
kn_status kn_job_border_cut_mesh(kn_ctx *ctx, kn_mesh *mesh, kn_job_cell_plan *plan);

#endif
