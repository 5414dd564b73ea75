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
// J = det dT/d(u,v,w) of T as the shell holds it. Poles count without the factor that vanishes there for all w, and
// an edge collapsed within 1e-12 as collapsed exactly (kn_shell_jacobian). At a cone's apex J is 0 for w = 0 alone,
// as T is one point there: that counts as neither sign.

// positive, negative: everywhere in the region, certified. mixed: both signs occur, each at a point and beyond its
// rounding. undecided: within the work limit nothing was proved, or J vanishes where no rounding can tell.
typedef enum kn_fold_verdict { KN_FOLD_POSITIVE, KN_FOLD_NEGATIVE, KN_FOLD_MIXED, KN_FOLD_UNDECIDED } kn_fold_verdict;
typedef struct kn_fold_sign {
    kn_fold_verdict verdict;
    double where[3]; // of the least value found (negative, when mixed), or where nothing could be decided
    double value;    // the least value found: at a pole 0
    double lo, hi;   // bounds of J over the region, rounding included; when decided within about 2 % of its range
} kn_fold_sign;
// The sign of J over the box [lo,hi] of (u,v,w), less what of it lies outside the domain (and a volume's heights).
// fails:  KN_EDOMAIN (lo > hi, not finite, the box lies outside), KN_ELIMIT as kn_shell_jacobian, KN_ENOMEM,
//         KN_ECANCELLED; out unchanged.
// error:  none: definite answers include all rounding (docs/numerics.md, "fold").
// cost:   kn_shell_jacobian_piece_init for each box of the grid that it meets, and some us for each box it is halved
//         into; limited by 2^24 coefficients, some 0.3 s.
KN_API KN_CHECKED kn_status kn_fold_jacobian_sign(kn_ctx *ctx, kn_fold_sign *out, const kn_shell *shell,
                                                  const double lo[3], const double hi[3]);

// How far T may go before J vanishes: J > 0 over the cell for 0 < w < above and for 0 > w > -below, guaranteed.
typedef struct kn_fold_heights {
    double above, below; // INFINITY: J has no zero on that side (within the heights of a volume), certified
    // No more than about these would be safe: found at a place where J, not its rounding, falls below 2^-20 of its
    // terms. INFINITY: no limit was found; a finite `above` is then as far as rounding lets J be known. Else above >=
    // 0.99 above_most unless that, or the work limit, ends the search first.
    double above_most, below_most;
    double where_above[2], where_below[2]; // (u,v) of them; the middle of the domain where they are INFINITY
} kn_fold_heights;
// out:    cells: one for each cell of the shell, u slowest (kn_shell_cells); overall: their least. NULL: not wanted.
//         0 where J is not positive right above w = 0 (a left-handed volume; below a cone's apex). A volume has no
//         `below`: INFINITY. What does not fold may have finite heights, with `most` INFINITY: J is known within some
//         1e-13 of its terms, and one of them, w^k, that is 0 though the control points behind it are neither 0 nor
//         alike, limits w to about 1e13 to the power 1/k (a tilted plane: 1e10 and more; a high power of an
//         attraction: less).
// fails:  KN_ELIMIT as kn_shell_jacobian, KN_ENOMEM, KN_ECANCELLED; outputs unchanged.
// error:  none: above and below are lower bounds, rounding included.
// cost:   kn_shell_jacobian_piece_init for each box of the grid, twice where it comes near the least, and some us for
//         each halving, limited by 2^24 coefficients; on the threads of the context, with the same result for any
//         number of them.
// source: Elber 2005, "Modeling the geometric texture"; lower bounds from coefficients by halving.
KN_API KN_CHECKED kn_status kn_fold_safe_heights(kn_ctx *ctx, kn_fold_heights *cells, kn_fold_heights *overall,
                                                 const kn_shell *shell);

// The zero set of J for display: T of {J = 0}, w0 < w < w1, as triangles.
// in:     steps >= 1: how often a cell is divided in each direction.
// out:    a mesh, initialised (empty will do) and overwritten. Vertices: for each place of the grid the roots in w at
//         which J changes its sign, to 2^-48 of the distance of the levels at which signs are looked at (some 4 for
//         each power of w); neighbours are joined where each is the other's nearest. Where J only touches 0 (the
//         centre of a sphere), or roots merge within the grid, the surface has no triangles.
// fails:  KN_EDOMAIN (heights, steps), KN_ELIMIT (more than 2^26 places; as kn_shell_jacobian), KN_ENOMEM,
//         KN_ECANCELLED; out unchanged.
// cost:   kn_shell_jacobian, and about 1 us for each place and root.
KN_API KN_CHECKED kn_status kn_fold_surface(kn_ctx *ctx, kn_mesh *out, const kn_shell *shell, double w0, double w1,
                                            int steps);
// The curves {J(.,.,w) = 0} on the base as polylines in (u,v), for display: marching squares.
// out:    *points: two numbers each; line i of *nlines has the points (*ends)[i-1] .. (*ends)[i] - 1, the first from
//         0; a closed line ends with its first point. kn_free both. Points lie on lines of the grid, at changes of
//         sign of J, to 2^-48 of its meshes; between them the curve is not looked at.
// in, fails, cost: as kn_fold_surface.
KN_API KN_CHECKED kn_status kn_fold_curves(kn_ctx *ctx, double **points, size_t **ends, size_t *nlines,
                                           const kn_shell *shell, double w, int steps);

// ---- global: two places with one image ----

typedef enum kn_fold_global {
    KN_FOLD_NONE,  // certified: no two places of the regions have one image, but for what is said below
    KN_FOLD_FOUND, // a witness: T is not injective
    KN_FOLD_OPEN,  // undecided
} kn_fold_global;
typedef struct kn_fold_intersection {
    kn_fold_global verdict;
    kn_fold_region a, b;  // FOUND: two places (lo = hi), inside the regions; OPEN: the first boxes in doubt
    double point[3], gap; // FOUND: the image, and the distance of the two images: at most 1e-11 of the whole size
    size_t boxes;         // work done
    size_t undecided;     // OPEN: pairs of boxes in doubt
} kn_fold_intersection;
typedef struct kn_fold_options {
    size_t work; // boxes and pairs to look at before it gives up; 0: 300 000
    double size; // the resolution, as a part of the size of the whole, at most 0.01; 0: 1e-6
} kn_fold_options;
// Whether two places of the regions, of one shell or of two, have the same image: locally, where the Jacobian
// changes its sign, or far apart, where parts of the shells run into each other.
// in:     shells whose edges may be the same curves (a teapot's patches): that is found by comparing T over the edges
//         from end to end, in both directions and with w counted either way, so that seams, Moebius strips and
//         neighbouring patches are known. Edges that are the same in part only are not. regions, which may touch and
//         overlap: inside the domain and kn_shell_heights; NULL: all of every shell, w in [w[0], w[1]]; w is not
//         looked at otherwise.
// out:    One place is not two: where edges are one, and at poles, the same place has several parameters. With
//         resolution r = options.size times the diameter of all images (of all shells over their whole domain and all
//         heights in question, up and down):
//         NONE: any two different places with one image lie on both sides of a common edge, or about a pole, an
//         apex or a common corner, and are joined along the shells by a way not longer than r. So neighbours whose
//         normals differ by less than r / w count as joined. Everywhere else T is injective.
//         FOUND: a way that long does not join the places, but one of 10 r or more: it is no matter of resolution.
//         Along an edge where two shells meet at an angle, T really overlaps on the hollow side, and so it does below
//         an apex: FOUND. On the other side, where they open, NONE is certified (straight edges in a few boxes,
//         curved ones in tens of thousands).
//         OPEN: images of boxes in doubt became smaller than r, or the work ran out. So does T where it touches
//         itself, or where J vanishes on the boundary of the regions alone.
// fails:  KN_EDOMAIN (no shells, regions or options out of range), KN_EUNDECIDED weights near zero, numbers that
//         overflow; KN_ELIMIT as kn_shell_volume; KN_ENOMEM, KN_ECANCELLED; out unchanged.
// error:  none: NONE holds for the exact T, with all rounding included (docs/numerics.md, "fold"); a witness can be
//         evaluated.
// cost:   about 0.1 ms a box; a few times as many boxes as T has pieces where heights stay below nine tenths of the
//         largest ones, and 1 / distance times as many near them. The same results on every run.
// source: boxes: Gottschalk, Lin & Manocha, OBBTree, SIGGRAPH 1996. planes: Gilbert, SIAM J. Control 4 (1966).
KN_API KN_CHECKED kn_status kn_fold_self_intersection(kn_ctx *ctx, kn_fold_intersection *out,
                                                      const kn_shell *const *shells, int nshells,
                                                      const kn_fold_region *regions, size_t nregions,
                                                      const double w[2], const kn_fold_options *options);

#ifdef __cplusplus
}
#endif
#endif
