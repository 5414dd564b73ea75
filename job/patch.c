// SPDX-License-Identifier: Apache-2.0
// What a patch is made of, whether it is one piece or a spline.
#include <knurl/job.h>

#include <string.h>

int kn_patch_nvars(const kn_patch *patch)
{
    return patch->mesh ? 0 : patch->spline ? patch->spline->nvars : patch->bezier.nvars;
}

// The knots of one piece of degree p: p + 1 zeros and as many ones, from the middle of this.
#define EIGHT(x) x, x, x, x, x, x, x, x
static const double one_piece[2 * (KN_MAX_DEGREE + 1)] = {
    EIGHT(0.0), EIGHT(0.0), EIGHT(0.0), EIGHT(0.0), EIGHT(0.0), EIGHT(0.0), EIGHT(0.0), 0.0,
    EIGHT(1.0), EIGHT(1.0), EIGHT(1.0), EIGHT(1.0), EIGHT(1.0), EIGHT(1.0), EIGHT(1.0), 1.0};

kn_spline kn_patch_spline(const kn_patch *patch)
{
    const kn_bezier *b = &patch->bezier;
    kn_spline view = {.nvars = b->nvars, .ncomp = b->ncomp, .rational = b->rational, .coef = b->coef};
    if (patch->spline) return *patch->spline;
    if (patch->mesh) return (kn_spline){0};
    for (int d = 0; d < b->nvars; d++) {
        const double *knots = one_piece + KN_MAX_DEGREE - b->degree[d];
        view.degree[d] = b->degree[d];
        view.count[d] = b->degree[d] + 1;
        memcpy(&view.knots[d], &knots, sizeof knots); // borrowed, and never written to
    }
    return view;
}
