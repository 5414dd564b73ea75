// SPDX-License-Identifier: Apache-2.0
// Where a shell folds: certified signs of its Jacobian, safe heights, and global self-intersection.
#ifndef KNURL_FOLD_H
#define KNURL_FOLD_H

#include <knurl/mesh.h>
#include <knurl/shell.h>
#include <knurl/solve.h>

#ifdef __cplusplus
extern "C" {
#endif

// A box of one shell's (u,v,w).
typedef struct kn_fold_region {
    int shell; // index into the shells at hand
    double lo[3], hi[3];
} kn_fold_region;

// ---- local: the Jacobian ----

// positive, negative: everywhere in the region, poles (where the vanishing factor is divided out) included. mixed: both
// signs occur, `where` is a place of the negative or smaller one. undecided: within `work` boxes nothing was proved.
typedef enum kn_fold_verdict { KN_FOLD_POSITIVE, KN_FOLD_NEGATIVE, KN_FOLD_MIXED, KN_FOLD_UNDECIDED } kn_fold_verdict;
typedef struct kn_fold_sign {
    kn_fold_verdict verdict;
    double where[3]; // of the least value found, or where nothing could be decided
    double value;    // det dT/d(u,v,w) there
    double lo, hi;   // bounds of det dT/d(u,v,w) over the region, rounding included
} kn_fold_sign;
KN_API KN_CHECKED kn_status kn_fold_jacobian_sign(kn_ctx *ctx, kn_fold_sign *out, const kn_shell *shell,
                                                  const double lo[3], const double hi[3]);

// How far T may go before the Jacobian vanishes: for every |w| below these heights it is positive over the cell
// (guaranteed), and they are within 1 % of the largest such heights. INFINITY: no limit.
typedef struct kn_fold_heights {
    double above, below;
    double where_above[2], where_below[2]; // (u,v) of the limit
} kn_fold_heights;
// cells: one for each cell of the shell, u slowest (kn_shell_cells); NULL: not wanted. overall: their least.
KN_API KN_CHECKED kn_status kn_fold_safe_heights(kn_ctx *ctx, kn_fold_heights *cells, kn_fold_heights *overall,
                                                 const kn_shell *shell);

// The zero set of the Jacobian for display: triangles in space, T of {J = 0} for w in [w0,w1].
KN_API KN_CHECKED kn_status kn_fold_surface(kn_ctx *ctx, kn_mesh *out, const kn_shell *shell, double w0, double w1,
                                            int steps);
// The curves {J(.,.,w) = 0} on the base as polylines in (u,v): points, two numbers each; *ends[i] is where line i
// ends. kn_free both.
KN_API KN_CHECKED kn_status kn_fold_curves(kn_ctx *ctx, double **points, size_t **ends, size_t *nlines,
                                           const kn_shell *shell, double w, int steps);

// ---- global: two places with one image ----

typedef enum kn_fold_global {
    KN_FOLD_NONE,  // certified: T is injective over the regions (shared edges and poles apart)
    KN_FOLD_FOUND, // a witness
    KN_FOLD_OPEN,  // undecided
} kn_fold_global;
typedef struct kn_fold_intersection {
    kn_fold_global verdict;
    kn_fold_region a, b;  // FOUND: points (lo = hi) whose images agree to 1e-10 of the size; OPEN: boxes in doubt
    double point[3], gap; // FOUND: the image, and the distance of the two images
    size_t boxes;         // visited
    size_t undecided;     // pairs that could not be decided
} kn_fold_intersection;
typedef struct kn_fold_options {
    size_t work; // boxes to visit before it gives up; 0: 2 million
    double size; // boxes of images smaller than this share of the whole are not split further; 0: 1e-6
} kn_fold_options;
// Whether two places of the regions, of one shell or of two, have the same image. Places on shared edges, seams and
// poles, where T is the same point by construction, do not count.
// in: shells that may share edges (a teapot's patches); regions NULL: all of every shell for w in [w[0], w[1]].
KN_API KN_CHECKED kn_status kn_fold_self_intersection(kn_ctx *ctx, kn_fold_intersection *out,
                                                      const kn_shell *const *shells, int nshells,
                                                      const kn_fold_region *regions, size_t nregions,
                                                      const double w[2], const kn_fold_options *options);

#ifdef __cplusplus
}
#endif
#endif
