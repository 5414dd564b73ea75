// SPDX-License-Identifier: Apache-2.0
// Inside io: what plain and trimmed faces of a STEP file share.
#ifndef IO_STEP_FACE_H
#define IO_STEP_FACE_H

#include "io/step_write.h"

enum { KN_STEP_NAME_BYTES = KN_NAME_BYTES + 96 };

typedef struct kn_step_net {
    int nr, nt, n; // control points along r, along t, together
    bool rational;
    const double *point; // n times x, y, z in mm, weight
    uint64_t first; // numbers: the points, then the surface, 4 curves, 4 vertices, 4 edges, 4 oriented edges, ...
    double same;
    int vertex[4];     // the corner whose vertex a corner uses
    bool collapsed[4]; // an edge that is a point
    int curve[4];      // the edge whose curve an edge uses: not its own across the seam of a closed patch
} kn_step_net;

// Number `offset` after the points.
uint64_t kn_step_number(const kn_step_net *f, int offset);
// Scaled and projected points; *largest receives the largest coordinate.
kn_status kn_step_load(kn_ctx *ctx, double *point, double *largest, const kn_bezier *b, double mm);
double kn_step_same(double largest); // points nearer than this are one
bool kn_step_weights_differ(const kn_bezier *b);
void kn_step_find_topology(kn_step_net *f);
void kn_step_put_points(kn_text *text, const kn_step_net *f);
void kn_step_put_surface(kn_text *text, const kn_step_net *f);
void kn_step_put_logical(kn_text *text, bool value);
void kn_step_name(char name[KN_STEP_NAME_BYTES], const kn_patch_id *id, const char *part);

// ---- step_trimmed.c ----
kn_status kn_step_put_trimmed(kn_text *text, const kn_patch *patch, const char *part, uint64_t first, double mm);
// Numbers that a trimmed face needs beyond those of a plain one, at most.
uint64_t kn_step_trim_room(const kn_job_report *report);

#endif
