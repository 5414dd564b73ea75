// SPDX-License-Identifier: Apache-2.0
// Inside io: a spline as a file has it, before it is known to be a clamped one.
#ifndef IO_NET_H
#define IO_NET_H

#include "io/text_scan.h"

#include <knurl/spline.h>

enum { KN_NET_VARIABLES = 3 };

// Zero is empty; kn_net_clear ends it.
typedef struct kn_net {
    int nvars, ncomp, dim; // ncomp: the weight, which comes last, included
    bool rational;
    int degree[KN_NET_VARIABLES], count[KN_NET_VARIABLES];
    double *knots[KN_NET_VARIABLES];
    double *coef; // as in a kn_spline
} kn_net;
void kn_net_clear(kn_ctx *ctx, kn_net *net);

// count[d] and degree[d] from a file's numbers of control points and order: an order that fits, and room for knots
// where `knots` follow. Allocates knots[d].
KN_CHECKED kn_status kn_net_set_variable(kn_scan *scan, kn_net *net, int d, int count, int order, bool knots);
// knots[d] as a Bezier variable has them.
void kn_net_bezier_knots(kn_net *net, int d);
// The next knot, number i of variable d, which is no smaller than those before it, nor too often there.
KN_CHECKED kn_status kn_net_scan_knot(kn_scan *scan, kn_net *net, int d, int i);
// Whether the knots, all of them read, leave a domain.
KN_CHECKED kn_status kn_net_check_domain(kn_scan *scan, const kn_net *net, int d);
// Allocates coef, when so many numbers can follow. *points: how many control points.
KN_CHECKED kn_status kn_net_make_room(kn_scan *scan, kn_net *net, size_t *points);
// Where control point k of a file that runs the first variable fastest goes in a spline (last variable fastest).
size_t kn_net_place(const kn_net *net, size_t k);
// The spline, clamped by knot insertion where it was not. line: where the object began, for messages.
KN_CHECKED kn_status kn_net_spline(kn_scan *scan, kn_spline *out, kn_net *net, int line);

#endif
