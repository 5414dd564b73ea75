// SPDX-License-Identifier: Apache-2.0
// Coefficients over a box of parameters, with bounds of their errors.
#include "bezier/bounds.h"
#include "kernel/bernstein.h"
#include "kernel/bounds.h"

#include <math.h>
#include <string.h>

static kn_status check_box(kn_ctx *ctx, const char *what, const kn_bezier *a, const double *lo, const double *hi)
{
    kn_status status = kn_bezier_check_operand(ctx, what, a);
    if (status != KN_OK) return status;
    if (!lo != !hi) return kn_fail(ctx, KN_EDOMAIN, "%s: a box with one end", what);
    for (int d = 0; d < a->nvars && lo; d++)
        if (!isfinite(lo[d]) || !isfinite(hi[d]) || lo[d] > hi[d])
            return kn_fail(ctx, KN_EDOMAIN, "%s: [%g, %g] in variable %d", what, lo[d], hi[d], d);
    return KN_OK;
}

typedef struct restriction {
    double *coef, *size, *work, *matrix; // size: what roundings are relative to
    double roundings, growth;
} restriction;

static void restrict_variable(restriction *r, const kn_bezier *a, int d, double lo, double hi)
{
    int m = a->degree[d] + 1;
    kn_axis x = kn_bezier_axis(a, d);
    size_t bytes = (size_t)a->ncomp * kn_bezier_count(a) * sizeof *r->coef;
    kn_bernstein_restriction(r->matrix, m - 1, lo, hi);
    memcpy(r->work, r->coef, bytes);
    kn_bernstein_transform(r->coef, r->work, x.outer, m, m, x.inner, r->matrix);
    if (lo < 0.0 || hi > 1.0) kn_bernstein_restriction_size(r->matrix, m - 1, lo, hi);
    memcpy(r->work, r->size, bytes);
    kn_bernstein_transform(r->size, r->work, x.outer, m, m, x.inner, r->matrix);
    r->roundings += 5.0 * a->degree[d] + 2.0;
    r->growth *= fmax(1.0, kn_row_growth(r->matrix, m, m));
}

kn_status kn_bezier_hull(kn_ctx *ctx, const char *what, kn_hull *out, const kn_bezier *a, const double *lo,
                         const double *hi)
{
    kn_status status = check_box(ctx, what, a, lo, hi);
    if (status != KN_OK) return status;
    *out = (kn_hull){.n = kn_bezier_count(a), .coef = a->coef};
    bool whole = true;
    for (int d = 0; d < a->nvars && lo; d++) whole &= lo[d] == 0.0 && hi[d] == 1.0;
    if (whole) return KN_OK;

    size_t all = (size_t)a->ncomp * out->n, side = KN_MAX_DEGREE + 1;
    restriction r = {.growth = 1.0};
    r.coef = kn_scratch(ctx, all, sizeof *r.coef);
    r.size = kn_scratch(ctx, all, sizeof *r.size);
    r.work = kn_scratch(ctx, all, sizeof *r.work);
    r.matrix = kn_scratch(ctx, side * side, sizeof *r.matrix);
    if (!r.coef || !r.size || !r.work || !r.matrix) return KN_ENOMEM;
    double most = 0.0;
    for (size_t i = 0; i < all; i++) {
        r.coef[i] = a->coef[i];
        r.size[i] = fabs(a->coef[i]);
        most = r.size[i] > most ? r.size[i] : most;
    }
    for (int d = 0; d < a->nvars; d++)
        if (lo[d] != 0.0 || hi[d] != 1.0) restrict_variable(&r, a, d, lo[d], hi[d]);
    kn_hull_errors(r.size, all, r.roundings, 0x1p-1040 * r.growth * (1.0 + most));
    out->coef = r.coef, out->error = r.size;
    return KN_OK;
}

kn_status kn_hull_box(kn_ctx *ctx, const char *what, double *lo, double *hi, const kn_hull *hull, int dim,
                      bool rational)
{
    size_t n = hull->n, last = (size_t)dim * n;
    const double *w = rational ? hull->coef + last : NULL, *ew = w && hull->error ? hull->error + last : NULL;
    if (w && !kn_hull_positive(n, w, ew)) return kn_fail(ctx, KN_EDOMAIN, "%s: a weight is not positive", what);
    for (size_t c = 0; c < (size_t)dim; c++)
        kn_hull_range(&lo[c], &hi[c], n, hull->coef + c * n, hull->error ? hull->error + c * n : NULL, w, ew);
    return KN_OK;
}
