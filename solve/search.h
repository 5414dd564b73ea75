// SPDX-License-Identifier: Apache-2.0
// The search for zeros of a system on a list of cells: boxes are narrowed, divided, excluded, or certified.
#ifndef SOLVE_SEARCH_H
#define SOLVE_SEARCH_H

#include "solve/net.h"

// Boxes of the domain that overlap in faces alone, with a polynomial system over [0,1]^nvars on each. Cells on which
// the system cannot vanish may be missing.
typedef struct kn_cells {
    kn_net net;                              // ncomp: the equations
    double lo[KN_MAX_VARS], hi[KN_MAX_VARS]; // the whole domain
    size_t count, room;
    double *coef;  // of cell i: net.ncomp * net.count numbers
    double *error; // net.ncomp numbers
    double *box;   // 2 nvars numbers: lo, hi
    bool jumps;    // the functions need not be continuous from cell to cell
} kn_cells;

// Room for one more cell: its place in the arrays. fails: KN_ENOMEM.
kn_status kn_cells_add(kn_ctx *ctx, kn_cells *cells, double **coef, double **error, double **box);
void kn_cells_clear(kn_ctx *ctx, kn_cells *cells);

// The whole search. Roots in the domain's parameters, sorted.
kn_status kn_cells_solve(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report, kn_cells *cells,
                         const kn_solve_options *options);
// options with zeros replaced; KN_EDOMAIN for what makes no sense.
kn_status kn_solve_settle(kn_ctx *ctx, kn_solve_options *out, const kn_solve_options *options);

// ---- inside the search ----

// A box of a cell, in the cell's parameters.
typedef struct kn_box {
    size_t cell;
    int depth;
    double lo[KN_MAX_VARS], hi[KN_MAX_VARS];
} kn_box;

// A root or an undecided box, in its cell's parameters. Of a certain root `around` holds no other one.
typedef struct kn_found {
    size_t cell;
    kn_root_kind kind;
    double at[KN_MAX_VARS], lo[KN_MAX_VARS], hi[KN_MAX_VARS];
    double around_lo[KN_MAX_VARS], around_hi[KN_MAX_VARS];
} kn_found;

typedef struct kn_finder {
    const kn_cells *cells;
    kn_solve_options options;
    kn_net net, square;                      // the system, and as many combinations of it as there are variables
    double *coef, *error, *work;             // of the system over the box at hand
    double *g, *g_error;                     // Y times it
    double *y;                               // square.ncomp x net.ncomp
    double ratio[KN_MAX_VARS];               // derivatives are taken in units of the box, or of this many of them
    double kappa[KN_MAX_VARS * KN_MAX_VARS]; // max |I - dg/ds| over the box, rounding included
    kn_found *found;
    size_t nfound, room;
} kn_finder;

// coef and error over the box [lo,hi] of a cell.
void kn_finder_load(kn_finder *f, size_t cell, const double *lo, const double *hi);
// The values of all functions of net at s, and their derivatives jacobian[c * nvars + d].
// work: (nvars + 1) * count numbers.
void kn_net_jacobian(const kn_net *net, const double *coef, const double *s, double *value, double *jacobian,
                     double *work);
// y (n x m) times the m x n matrix is about I; false when the matrix has no n independent rows.
bool kn_left_inverse(double *y, const double *matrix, int m, int n);
// g = y coef, g_error.
void kn_finder_combine(kn_finder *f);
// Fills in kappa; its largest row sum.
double kn_finder_kappa(kn_finder *f);
// Whether some function of a net cannot vanish.
bool kn_net_excluded(const kn_net *net, const double *coef, const double *error);
// Cuts from [t0,t1], a part of [0,1]^nvars, what one of the functions cannot vanish on. False: nothing is left.
bool kn_net_narrow(const kn_net *net, const double *coef, const double *error, double *t0, double *t1);

typedef enum kn_fate { KN_FATE_EMPTY, KN_FATE_ROOT, KN_FATE_SPLIT, KN_FATE_UNDECIDED } kn_fate;
// Tries to settle the box by Newton's method with certificate: EMPTY, ROOT (kept in f->found) or SPLIT (not settled).
kn_status kn_finder_certify(kn_ctx *ctx, kn_finder *f, kn_fate *fate, const kn_box *b);
kn_status kn_finder_keep(kn_ctx *ctx, kn_finder *f, const kn_found *found);
// The values of the functions at a point of a cell near [0,1]^nvars, in twofold arithmetic, and their errors.
void kn_cell_value(const kn_cells *cells, size_t cell, const double *at, double *value, double *error, double *work);
// A root of a cell in the domain's parameters, rounded outwards; `at` lies in the domain.
kn_root kn_cells_root(const kn_cells *cells, const kn_found *r);
// What is found becomes roots: in the domain's parameters, those on common faces joined.
kn_status kn_finder_gather(kn_ctx *ctx, kn_finder *f, kn_root **roots, size_t *nroots, bool merge);

#endif
