// SPDX-License-Identifier: Apache-2.0
// How many straight segments a spline needs to look like itself.
#include "io/bend.h"

#include "kernel/context.h"

#include <math.h>

enum { MOST_SEGMENTS = 128, MOST_TOTAL = 1 << 30 };

// Over a box of 1/n of a piece in each direction the surface is within p (p - 1) / 8 |D2| / n^2 of what is linear
// along a variable of degree p, and p q / 4 |D11| / n^2 of what is bilinear, the D second differences of control
// points. Of rational pieces projected points stand for these: about right.
// bend[d]: those of variable d, and half of those that it shares: |D11| / (n m) <= (|D11| / n^2 + |D11| / m^2) / 2.
static double bend_of(const kn_bezier *b, double bend[3])
{
    size_t n = kn_bezier_count(b), stride[3] = {1, 1, 1};
    double sum = 0.0;
    for (int d = b->nvars - 2; d >= 0; d--) stride[d] = stride[d + 1] * (size_t)(b->degree[d + 1] + 1);
    for (int d = 0; d < b->nvars; d++)
        for (int e = d; e < b->nvars; e++) {
            double most = 0.0, p = b->degree[d], q = b->degree[e];
            for (size_t k = 0; k < n; k++) {
                int i = (int)(k / stride[d]) % (b->degree[d] + 1), j = (int)(k / stride[e]) % (b->degree[e] + 1);
                if (i + 1 + (d == e) > b->degree[d] || j + 1 > b->degree[e]) continue;
                size_t at[4] = {k, k + stride[d], k + stride[e], k + stride[d] + stride[e]};
                double square = 0.0;
                for (size_t c = 0; c < 3; c++) {
                    double x[4];
                    for (int m = 0; m < 4; m++)
                        x[m] = b->coef[c * n + at[m]] / (b->rational ? b->coef[3 * n + at[m]] : 1.0);
                    square += (x[0] - x[1] - x[2] + x[3]) * (x[0] - x[1] - x[2] + x[3]);
                }
                most = fmax(most, sqrt(square));
            }
            double part = d == e ? p * (p - 1.0) / 8.0 * most : p * q / 4.0 * most;
            sum += part;
            bend[d] += 0.5 * part, bend[e] += 0.5 * part;
        }
    return sum;
}

// The largest of all pieces, of all variables together and of each.
static kn_status most_of(kn_ctx *ctx, double *all, double each[3], const kn_spline *s)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, s);
    *all = each[0] = each[1] = each[2] = 0.0;
    for (size_t i = 0; i < n; i++) {
        double own[3] = {0.0, 0.0, 0.0};
        *all = fmax(*all, bend_of(&pieces[i], own));
        for (int d = 0; d < 3; d++) each[d] = fmax(each[d], own[d]);
        kn_bezier_clear(ctx, &pieces[i]);
    }
    kn_free(ctx, pieces);
    return status;
}

kn_status kn_spline_bend(kn_ctx *ctx, double *out, const kn_spline *s)
{
    double all, each[3];
    kn_status status = most_of(ctx, &all, each, s);
    if (status == KN_OK) *out = all;
    return status;
}

kn_status kn_spline_bends(kn_ctx *ctx, double out[3], const kn_spline *s)
{
    double all, each[3];
    kn_status status = most_of(ctx, &all, each, s);
    for (int d = 0; status == KN_OK && d < 3; d++) out[d] = each[d];
    return status;
}

int kn_bend_segments(double bend, double tol)
{
    double segments = ceil(sqrt(bend / tol));
    return segments > MOST_SEGMENTS ? MOST_SEGMENTS : segments >= 1.0 ? (int)segments : 1;
}

kn_status kn_bend_total(kn_ctx *ctx, int *out, const kn_spline *s, int var, int segments)
{
    size_t spans = (size_t)kn_spline_spans(s, var), n = (size_t)segments;
    if (spans > MOST_TOTAL / n)
        return kn_fail(ctx, KN_ELIMIT, "a spline of %zu spans, each as %zu segments: more than %d", spans, n,
                       MOST_TOTAL);
    *out = (int)(spans * n);
    return KN_OK;
}
