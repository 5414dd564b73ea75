// SPDX-License-Identifier: Apache-2.0
// Edges of patches along the ends of the base's surfaces: where a body that they take a place in goes on.
#ifndef CLI_BORDER_H
#define CLI_BORDER_H

#include "cli/cli.h"

#include "io/brep.h"

// Side 2 var + end of a surface of the base is where its variable var begins (end 0) or ends.
typedef struct cli_border_edge {
    int surface, side;
    double from, to; // where along the side, in [0,1] of its domain, from < to
    bool flat;       // w = 0 all along: it lies on the base, by the tile and not by any distance
    bool along;      // the curve runs from `from` to `to`
    kn_spline curve; // that of the patch: control points as it has them
    kn_brep_key key; // of its control points
    kn_patch_id id;
} cli_border_edge;

typedef struct cli_border {
    const kn_job *job;      // borrowed
    cli_border_edge *edges; // sorted by surface, side and from once cli_border_sort was called
    size_t count, room;
    bool trimmed;                  // a patch near an end is trimmed, or no surface: it is not among them
    bool apart;                    // away from the ends there are edges that patches do not share bit for bit
    kn_brep_key odd;               // of those edges: exclusive or of the keys, in which pairs cancel
    struct cli_border_part *parts; // of the job
    int reach;                     // of the tile: how many cells beyond its own
} cli_border;

// A sink for the job that fills *border, which stays where it is until cli_border_clear.
kn_status cli_border_sink(kn_ctx *ctx, kn_sink *out, cli_border *border, const kn_job *job);
// The edges of `from` go to `to`, which may be zero; both are cleared by the caller.
kn_status cli_border_move(kn_ctx *ctx, cli_border *to, cli_border *from);
void cli_border_sort(cli_border *border);
void cli_border_clear(kn_ctx *ctx, cli_border *border);

#endif
