// SPDX-License-Identifier: Apache-2.0
// Control points at an end of a curve from its derivatives there.
#include "fit/internal.h"
#include "kernel/context.h"

// Derivative k at an end is a combination of the k + 1 control points next to it: a triangular system.
kn_status kn_fit_end_coefficients(kn_ctx *ctx, double *coef, int dim, const double *knots, int degree, int count,
                                  bool at_end, int norders, const double *derivatives)
{
    kn_status status = kn_fit_expect(ctx, "fit_end_coefficients", 1, dim, &degree, &count, &knots);
    if (status != KN_OK) return status;
    if (norders < 1 || norders > degree + 1)
        return kn_fail(ctx, KN_EDOMAIN, "fit_end_coefficients: %d values for degree %d", norders, degree);
    size_t room = (size_t)norders * (size_t)(degree + 1);
    kn_mark mark = kn_scratch_mark(ctx);
    double *w = kn_scratch(ctx, room, sizeof *w);
    if (w) {
        int span = kn_knots_span(knots, degree, count, at_end ? knots[count] : knots[0]);
        kn_knots_basis(w, knots, degree, span, at_end ? knots[count] : knots[0], norders - 1);
        for (int c = 0; c < dim; c++) { // place j: the j-th control point from the end
            double *end = coef + (size_t)c * (size_t)count + (at_end ? count - 1 : 0);
            int step = at_end ? -1 : 1;
            for (int k = 0; k < norders; k++) {
                const double *row = w + k * (degree + 1) + (at_end ? degree : 0);
                double sum = derivatives[k * dim + c];
                for (int j = 0; j < k; j++) sum -= row[j * step] * end[j * step];
                end[k * step] = sum / row[k * step];
            }
        }
    }
    kn_scratch_release(ctx, mark);
    return w ? KN_OK : KN_ENOMEM;
}
