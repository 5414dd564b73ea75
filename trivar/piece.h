// SPDX-License-Identifier: Apache-2.0
// Inside trivar: where the box of a piece lies.
#ifndef TRIVAR_PIECE_H
#define TRIVAR_PIECE_H

#include "trivar/internal.h"

// A box in S's parameters, and where it lies.
typedef struct kn_piece_box {
    double lo[2], hi[2], slack[2]; // slack: what counts as rounding along each variable
    int span[2];                   // of S
    int cut[2];                    // of n
    bool plain;                    // inside the domain, without a knot of n in its interior
    bool inside;                   // inside the domain
    bool knotless;                 // without a knot of n in its interior
    bool crosses[2];               // a knot of S in its interior
} kn_piece_box;
#define KN_PIECE_BOX ((kn_piece_box){.plain = true, .inside = true, .knotless = true})

// The side [lo, hi] of a cell along variable v; the box begins as KN_PIECE_BOX.
void kn_piece_place(kn_piece_box *b, const kn_shell *shell, int v, int cell, double lo, double hi);
// That side in the coordinates of interval `at` between breaks.
void kn_piece_local(double *lo, double *hi, const kn_piece_box *b, int v, const double *breaks, int at);

#endif
