// SPDX-License-Identifier: Apache-2.0
// Splines in the making, in scratch.
#include "spline/in_scratch.h"

#include <limits.h>
#include <string.h>

#include "kernel/context.h"

// Each break of the knots once more.
static int raise_knots(double *to, const double *knots, int nknots)
{
    int n = 0;
    for (int i = 0; i < nknots; i++) {
        to[n++] = knots[i];
        if (i + 1 == nknots || knots[i + 1] > knots[i]) to[n++] = knots[i];
    }
    return n;
}

// sum = the band `then` after the band `now`, weights and divisors multiplied. No weight is negative, so a zero is
// exact; by uniqueness of coefficients what is not zero fits into `then`'s span of the first spline, width wide.
static void compose(kn_band *both, const kn_band *then, const kn_band *now, int width)
{
    double sum[2 * KN_MAX_DEGREE + 3];
    both->rows = then->rows, both->width = width;
    both->divisor = (then->divisor != 0.0 ? then->divisor : 1.0) * (now->divisor != 0.0 ? now->divisor : 1.0);
    for (int i = 0; i < then->rows; i++) {
        const double *w = then->w + (size_t)i * (size_t)then->width;
        int lowest = INT_MAX, end = 0;
        for (int k = 0; k < then->terms[i]; k++) {
            int row = then->first[i] + k, first = now->first[row], last = first + now->terms[row];
            lowest = first < lowest ? first : lowest;
            end = last > end ? last : end;
        }
        for (int k = 0; k < end - lowest; k++) sum[k] = 0.0;
        for (int k = 0; k < then->terms[i]; k++) {
            int row = then->first[i] + k, n = now->terms[row];
            const double *v = now->w + (size_t)row * (size_t)now->width;
            double factor = n == 1 ? w[k] * now->divisor : w[k]; // a copy's weight 1 stands for the divisor
            for (int q = 0; q < n; q++) sum[now->first[row] - lowest + q] += factor * v[q];
        }
        both->first[i] = lowest, both->terms[i] = end - lowest;
        if (both->terms[i] == 1) sum[0] = 1.0;
        memcpy(both->w + (size_t)i * (size_t)width, sum, (size_t)both->terms[i] * sizeof *sum);
    }
}

// Two lists of knots and two bands take turns.
kn_status kn_spline_elevation_band(kn_ctx *ctx, kn_band *band, double **to, double *knots, int p, int count,
                                   int degree)
{
    double *list[2] = {NULL, NULL};
    kn_band step = {0}, both[2] = {{0}, {0}};
    int n = count + p + 1, rise = degree - p, breaks = kn_knots_spans(knots, p, count) + 1;
    if (breaks > (INT_MAX - n) / rise) return kn_fail(ctx, KN_ELIMIT, "spline: too many knots");
    int nknots = n + rise * breaks, rows = nknots - degree - 1;
    kn_status status = rise > 1 ? kn_spline_refining_band(ctx, &step, rows, degree) : KN_OK;
    for (int i = 0; i < 2 && i < rise && status == KN_OK; i++) {
        status = kn_spline_refining_band(ctx, &both[i], rows, p + 1);
        list[i] = kn_scratch(ctx, (size_t)nknots, sizeof *list[i]);
        if (!list[i]) status = KN_ENOMEM;
    }
    for (int q = p; q < degree && status == KN_OK; q++) {
        int turn = (q - p) % 2;
        kn_band *once = q == p ? &both[0] : &step;
        n = raise_knots(list[turn], knots, n);
        once->rows = n - q - 2, once->width = q + 1;
        kn_band_elevate(once, knots, q, count, list[turn]);
        if (q > p) compose(&both[turn], &step, &both[1 - turn], p + 1);
        knots = *to = list[turn], count = once->rows, *band = both[turn];
    }
    return status;
}

int kn_spline_elevated_count(const kn_spline *s, int var, int degree)
{
    size_t count = (size_t)s->count[var] + (size_t)(degree - s->degree[var]) * (size_t)kn_spline_spans(s, var);
    return count < INT_MAX ? (int)count : INT_MAX;
}

kn_status kn_spline_elevate_in_scratch(kn_ctx *ctx, kn_spline *s, int var, int degree)
{
    kn_band band = {0};
    double *to = NULL;
    if (degree <= s->degree[var]) return KN_OK;
    kn_spline shape = *s;
    shape.count[var] = kn_spline_elevated_count(s, var, degree), shape.degree[var] = degree;
    kn_status status = kn_spline_shape(ctx, "spline", s->nvars, s->ncomp, s->rational, shape.degree, shape.count);
    if (status != KN_OK) return status;
    status = kn_spline_elevation_band(ctx, &band, &to, s->knots[var], s->degree[var], s->count[var], degree);
    return status == KN_OK ? kn_spline_map_in_scratch(ctx, s, var, degree, to, &band) : status;
}

kn_status kn_spline_unite_in_scratch(kn_ctx *ctx, kn_spline *s, int var, const double *more, int n)
{
    int p = s->degree[var], have = s->count[var] + p + 1;
    int total = kn_knots_union(NULL, s->knots[var], have, more, n);
    if (total == have) return KN_OK;
    double *to = kn_scratch(ctx, (size_t)total, sizeof *to);
    if (!to) return KN_ENOMEM;
    kn_knots_union(to, s->knots[var], have, more, n);
    return kn_spline_refine_in_scratch(ctx, s, var, to, total - p - 1);
}

kn_status kn_spline_unite_all_in_scratch(kn_ctx *ctx, kn_spline *s, const int *var, int n, int least)
{
    int degree = least;
    for (int i = 0; i < n; i++) degree = s[i].degree[var[i]] > degree ? s[i].degree[var[i]] : degree;
    kn_status status = KN_OK;
    for (int i = 0; i < n && status == KN_OK; i++) status = kn_spline_elevate_in_scratch(ctx, &s[i], var[i], degree);
    if (status != KN_OK) return status;
    const double *all = s[0].knots[var[0]];
    int nall = s[0].count[var[0]] + degree + 1;
    for (int i = 1; i < n; i++) {
        const double *own = s[i].knots[var[i]];
        int have = s[i].count[var[i]] + degree + 1, total = kn_knots_union(NULL, all, nall, own, have);
        if (total == nall) continue;
        double *more = kn_scratch(ctx, (size_t)total, sizeof *more);
        if (!more) return KN_ENOMEM;
        kn_knots_union(more, all, nall, own, have);
        all = more, nall = total;
    }
    for (int i = 0; i < n && status == KN_OK; i++) status = kn_spline_unite_in_scratch(ctx, &s[i], var[i], all, nall);
    return status;
}

static bool same_sizes(const kn_spline *a, const kn_spline *b)
{
    if (a->nvars != b->nvars || a->ncomp != b->ncomp) return false;
    for (int d = 0; d < a->nvars; d++)
        if (a->degree[d] != b->degree[d] || a->count[d] != b->count[d]) return false;
    return true;
}

// What needs new arrays gets them aside, before anything changes; what fits is written in place, which cannot fail;
// old arrays go last, because others may still borrow them.
kn_status kn_spline_store_all(kn_ctx *ctx, kn_spline *const *outs, const kn_spline *s, int n)
{
    kn_status status = KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline *made = kn_scratch(ctx, (size_t)n, sizeof *made);
    if (!made) return KN_ENOMEM;
    memset(made, 0, (size_t)n * sizeof *made);
    for (int i = 0; i < n && status == KN_OK; i++)
        if (!same_sizes(outs[i], &s[i])) status = kn_spline_store(ctx, &made[i], &s[i]);
    for (int i = 0; i < n && status == KN_OK; i++)
        if (made[i].nvars == 0) status = kn_spline_store(ctx, outs[i], &s[i]);
    for (int i = 0; i < n; i++) {
        if (status == KN_OK && made[i].nvars > 0) kn_spline_swap(outs[i], &made[i]);
        kn_spline_clear(ctx, &made[i]);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
