// SPDX-License-Identifier: Apache-2.0
// Extrusion along a vector.
#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

kn_status kn_construct_extruded(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const double *vector)
{
    static const char call[] = "construct_extruded";
    kn_status status = kn_spline_expect(ctx, call, a, 0);
    if (status == KN_OK) status = kn_construct_finite(ctx, call, vector, kn_spline_dim(a));
    if (status != KN_OK) return status;
    kn_spline s;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_construct_extend(ctx, call, &s, a, 1, 2);
    if (status == KN_OK) {
        size_t n = kn_spline_count(a), dim = (size_t)kn_spline_dim(a);
        double *knots = s.knots[s.nvars - 1];
        knots[0] = knots[1] = 0.0, knots[2] = knots[3] = 1.0;
        for (size_t c = 0, k = 0; c < (size_t)a->ncomp; c++)
            for (size_t i = 0; i < n; i++, k++) { // moved by the vector: times the weight
                double weight = a->rational ? a->coef[n * dim + i] : 1.0;
                s.coef[2 * k] = a->coef[k];
                s.coef[2 * k + 1] = c < dim ? a->coef[k] + weight * vector[c] : a->coef[k];
            }
        status = kn_spline_store(ctx, out, &s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
