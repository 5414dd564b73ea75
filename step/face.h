// SPDX-License-Identifier: Apache-2.0
// Inside step: what plain and trimmed faces of a STEP file share.
#ifndef STEP_FACE_H
#define STEP_FACE_H

#include "step/line.h"

// A surface and its four edges: 0: t = 0, 1: r = 1, 2: t = 1, 3: r = 0, each running with r or t.
typedef struct kn_step_net {
    kn_step_axis axis[2];
    int n; // control points
    bool rational;
    const double *point; // n times x, y, z in mm, weight
    double same;
    bool closed[2]; // in each variable
    kn_step_line line[4];
    uint32_t numbers; // of its points, its surface, which is number n, and points that edges have of their own
} kn_step_net;

// *net of a patch in scratch: scaled and projected points.
kn_status kn_step_load(kn_ctx *ctx, kn_step_net *net, const kn_patch *patch, double mm);
double kn_step_same(double largest);                           // points nearer than this are one
void kn_step_put_points(kn_text *text, const kn_step_net *f);  // numbers 0 .. n - 1
void kn_step_put_surface(kn_text *text, const kn_step_net *f); // number n
// The curve of edge e of a net as a spline of the patch's own units, for kn_spline_clear.
kn_status kn_step_edge_spline(kn_ctx *ctx, kn_spline *out, const kn_patch *patch, int e);

// ---- trimmed.c ----
kn_status kn_step_put_trimmed(kn_text *text, kn_step_item *item, const kn_patch *patch, const kn_step_naming *naming,
                              const char *part, double mm);

#endif
