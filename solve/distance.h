// SPDX-License-Identifier: Apache-2.0
// Lower bounds of the distance from the origin to a piece over a box.
#ifndef SOLVE_DISTANCE_H
#define SOLVE_DISTANCE_H

#include "solve/search.h"

enum { KN_CLOSEST_VARS = 3 };

// Workspace for pieces of one shape: net has dim components and, last, the weight when rational.
typedef struct kn_distance {
    kn_net net, square; // square: twice the degrees, one component
    int dim;
    bool rational;
    double *weights, *square_weights; // of scaled coefficients
    size_t *places;
    double *scaled, *a, *w, *g, *slopes, *work;
} kn_distance;

kn_status kn_distance_init(kn_ctx *ctx, kn_distance *d, const kn_net *net, bool rational);
// A certified lower bound of the distance over the box with these coefficients, whose errors are given. limit: about
// the least distance known. at: a point of [0,1]^nvars that is likely to be near the closest.
double kn_distance_bound(kn_distance *d, const double *coef, const double *error, double limit, double *at);

#endif
