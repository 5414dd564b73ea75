// SPDX-License-Identifier: Apache-2.0
// An operation on a spline piece by piece: split at the breaks, operate, join on the knots that are needed.
#include <limits.h>

#include "bezier/shape.h"
#include "kernel/context.h"
#include "spline/calculus.h"

kn_status kn_spline_split_in_scratch(kn_ctx *ctx, kn_spline *s)
{
    kn_status status = KN_OK;
    for (int d = 0; d < s->nvars && status == KN_OK; d++) {
        int p = s->degree[d], n = kn_spline_spans(s, d) + 1;
        double *breaks = kn_scratch(ctx, (size_t)n, sizeof *breaks);
        double *to = kn_scratch(ctx, (size_t)n * (size_t)(p + 1), sizeof *to);
        if (!breaks || !to) return KN_ENOMEM;
        kn_knots_breaks(breaks, NULL, s->knots[d], p, s->count[d]);
        for (int i = 0; i < n; i++)
            for (int k = 0; k <= p; k++) to[(size_t)i * (size_t)(p + 1) + (size_t)k] = breaks[i];
        status = kn_spline_refine_in_scratch(ctx, s, d, to, (n - 1) * (p + 1));
    }
    return status;
}

// The result with every break at multiplicity degree + 1, for pieces of this shape; its knots are not filled.
static kn_status result_in_scratch(kn_ctx *ctx, const char *call, kn_spline *r, const kn_spline *a,
                                   const kn_bezier *shape)
{
    *r = (kn_spline){.nvars = a->nvars, .ncomp = shape->ncomp, .rational = shape->rational};
    for (int d = 0; d < a->nvars; d++) {
        int spans = kn_spline_spans(a, d);
        r->degree[d] = shape->degree[d];
        if (spans > INT_MAX / (r->degree[d] + 1))
            return kn_fail(ctx, KN_ELIMIT, "%s: %d pieces of degree %d", call, spans, r->degree[d]);
        r->count[d] = spans * (r->degree[d] + 1);
    }
    return kn_spline_in_scratch(ctx, call, r);
}

static kn_status operate(kn_ctx *ctx, kn_spline *r, const kn_spline *split, kn_bezier *piece, kn_bezier *value,
                         kn_piece_op op, const void *user)
{
    int index[KN_MAX_VARS] = {0}, first[KN_MAX_VARS];
    double size[KN_MAX_VARS];
    for (;;) {
        for (int d = 0; d < split->nvars; d++) {
            first[d] = index[d] * (split->degree[d] + 1);
            size[d] = split->knots[d][first[d] + split->degree[d] + 1] - split->knots[d][first[d]];
        }
        kn_spline_get_piece(piece, split, first);
        kn_status status = op(ctx, value, piece, size, user);
        if (status != KN_OK) return status;
        for (int d = 0; d < split->nvars; d++) first[d] = index[d] * (r->degree[d] + 1);
        kn_spline_put_piece(r, value, first);
        int d = split->nvars - 1;
        while (d >= 0 && ++index[d] == split->count[d] / (split->degree[d] + 1)) index[d--] = 0;
        if (d < 0) return KN_OK;
    }
}

// A knot of multiplicity m at degree p, continuity p - m, gets q - (p - m), one more where it is rough, at degree q.
static kn_status join(kn_ctx *ctx, kn_spline *r, const kn_spline *a, int var, bool rough)
{
    int p = a->degree[var], q = r->degree[var], n = kn_spline_spans(a, var) + 1;
    double *breaks = kn_scratch(ctx, (size_t)n, sizeof *breaks);
    int *times = kn_scratch(ctx, (size_t)n, sizeof *times);
    double *to = kn_scratch(ctx, (size_t)n * (size_t)(q + 1), sizeof *to);
    if (!breaks || !times || !to) return KN_ENOMEM;
    kn_knots_breaks(breaks, times, a->knots[var], p, a->count[var]);
    for (int i = 0; i < n; i++) {
        times[i] += q - p + rough;
        if (times[i] > q + 1 || i == 0 || i == n - 1) times[i] = q + 1;
    }
    int rows = kn_knots_repeat(to, breaks, times, n) - q - 1;
    kn_band band;
    kn_status status = kn_spline_band(ctx, &band, rows, q + 1);
    if (status != KN_OK) return status;
    kn_band_join(&band, breaks, n, q, to);
    return kn_spline_map_in_scratch(ctx, r, var, q, to, &band);
}

kn_status kn_spline_by_pieces(kn_ctx *ctx, const char *call, kn_spline *out, const kn_spline *a,
                              const kn_bezier *shape, kn_piece_op op, const void *user, int rough)
{
    kn_status status = kn_spline_expect(ctx, call, a, 0);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline split = *a, r;
    kn_bezier value = *shape, piece = {.nvars = a->nvars, .ncomp = a->ncomp, .rational = a->rational};
    for (int d = 0; d < a->nvars; d++) piece.degree[d] = a->degree[d];
    status = kn_bezier_scratch(ctx, &piece, call);
    if (status == KN_OK) status = kn_bezier_scratch(ctx, &value, call);
    if (status == KN_OK) status = kn_spline_split_in_scratch(ctx, &split);
    if (status == KN_OK) status = result_in_scratch(ctx, call, &r, a, shape);
    if (status == KN_OK) status = operate(ctx, &r, &split, &piece, &value, op, user);
    for (int d = 0; d < a->nvars && status == KN_OK; d++)
        status = join(ctx, &r, a, d, d == rough || rough == KN_EVERY_VAR);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &r); // last: out may be a
    kn_scratch_release(ctx, mark);
    return status;
}
