// SPDX-License-Identifier: Apache-2.0
// Inside step: what plain and trimmed faces of a STEP file share.
#ifndef STEP_FACE_H
#define STEP_FACE_H

#include "step/write.h"

// One variable of a surface: distinct knots and how often each occurs.
typedef struct kn_step_axis {
    int degree, n; // n control points
    int nbreaks;
    const int *times;
    const double *breaks;
} kn_step_axis;

typedef struct kn_step_net {
    kn_step_axis axis[2];
    int n; // control points
    bool rational;
    const double *point; // n times x, y, z in mm, weight
    double same;
    bool closed[2]; // in each variable
} kn_step_net;

// "#k=" with a number that counts from the patch.
void kn_step_put_relative(kn_text *text, uint32_t k);
// *net of a patch's bezier, or of its spline, in scratch: scaled and projected points.
kn_status kn_step_load(kn_ctx *ctx, kn_step_net *net, const kn_patch *patch, double mm);
double kn_step_same(double largest);                           // points nearer than this are one
void kn_step_put_points(kn_text *text, const kn_step_net *f);  // numbers 0 .. n - 1
void kn_step_put_surface(kn_text *text, const kn_step_net *f); // number n
void kn_step_put_logical(kn_text *text, bool value);
void kn_step_put_knots(kn_text *text, const kn_step_axis *x, bool times); // "(..)": multiplicities, or the knots

// ---- trimmed.c ----
kn_status kn_step_put_trimmed(kn_text *text, kn_step_item *item, const kn_patch *patch, const char *part, double mm);

#endif
