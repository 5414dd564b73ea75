// SPDX-License-Identifier: Apache-2.0
// Inside job: variation of tiles from place to place.
#ifndef JOB_VARY_H
#define JOB_VARY_H

#include "job/internal.h"

// ---- spot.c ----
// A point of a surface of the job in lattice coordinates: x[d] in [0, cells[d]], whole numbers on cell lines.
typedef struct kn_job_spot {
    int surface;
    double x[2];
} kn_job_spot;
// Where (u, v), counted from the corner of a cell, lies: over seams and shared edges as kn_job_find_place goes, on
// the border beyond open ends. The same answer from every cell and surface that has the point, bit for bit: u and v
// are rounded to 2^-40 of a cell, and a point on shared edges counts as one of the lowest surface.
kn_job_spot kn_job_find_spot(const kn_job *job, int surface, const int cell[2], const double uv[2]);
// All spots that are this point, over seams and shared edges, at most `room`; returns how many. out[0] is the spot.
int kn_job_spot_names(kn_job_spot *out, const kn_job *job, kn_job_spot spot, int room);
// What a field asks for; with KN_CELLS_FREE uv counts cells, evenly.
kn_status kn_job_fill_spot(kn_ctx *ctx, kn_place *out, const kn_job *job, const kn_job_spot *spot, unsigned needs);

// ---- taper.c ----
// Of the corners of cells: how far along S the nearest open end, or cell without a tile by the mask, is. NULL: of a
// surface that has none within the taper's length.
typedef struct kn_job_taper {
    double **distance; // of each surface: (cells[0] + 1) (cells[1] + 1), u slowest
    int nsurfaces;
} kn_job_taper;
kn_status kn_job_make_taper(kn_ctx *ctx, kn_job_taper *out, const kn_job *job);
void kn_job_taper_clear(kn_ctx *ctx, kn_job_taper *taper);
// 0 at open ends, 1 from options->taper away from them, and 3 x^2 - 2 x^3 between.
double kn_job_taper_at(const kn_job *job, const kn_job_spot *spot);

// ---- chance.c ----
bool kn_job_has_chance(const kn_job *job);
kn_status kn_job_check_chance(kn_ctx *ctx, const kn_job *job);
// options->random for one tile: from the seed and the numbers of its surface, cell and instance alone.
void kn_job_change_by_chance(kn_job_instance *instance, const kn_job *job, int surface, const int cell[2]);

// ---- vary.c ----
// What a field changes.
typedef enum kn_job_effect { KN_EFFECT_PARAMETER, KN_EFFECT_HEIGHT, KN_EFFECT_OFFSET } kn_job_effect;
typedef struct kn_job_rule {
    kn_job_effect effect;
    int parameter; // of the tile
    kn_field field;
} kn_job_rule;
typedef struct kn_job_varying {
    kn_job_rule *rules;
    int nrules;
    unsigned needs;
    int *first;       // of each part: how many Bezier patches the parts before it have
    kn_bezier *moves; // [(first[part] + patch) * nrules + rule]: target less patch, w in length units; empty: none
    size_t nmoves;
    kn_job_taper taper;
} kn_job_varying;
// What kn_job_vary_patch does to a patch, done to the vertices of a part's mesh: 3 numbers each, w in length units,
// before instance->map.
kn_status kn_job_vary_mesh(kn_ctx *ctx, double *position, const kn_job *job, int surface, const int cell[2],
                           const kn_job_instance *instance, int part);

// d (control points of a Bezier patch of the placed tile) / d (a parameter of it, the same everywhere), w in length
// units, before instance->map; ranges of parameters are left out. out: initialised, overwritten.
kn_status kn_job_vary_slope(kn_ctx *ctx, kn_bezier *out, const kn_job *job, int surface, const int cell[2],
                            const kn_job_instance *instance, int part, int spline, int patch, int parameter);

#endif
