// SPDX-License-Identifier: Apache-2.0
// Bands of rows with counts of their own, for surfaces side by side.
#include "cells/internal.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

static const double largest_ratio = 1.5; // of the lengths of rows in a band
static const double most_cells = 65536.0;

typedef struct bands {
    const kn_cells_along *along;
    int n, rows;
    const double *size;
    double **lines;       // of each member: rows + 1
    double *wanted;       // cells of each row, n x rows, in the direction of a member that is not reversed
    double *least, *most; // of the band at hand, for each member
    double **share;       // of each knot span of variable 0 in a member's lengths
    double *length;       // room for the lengths of spans
    int *first;           // the first row of each band
    int nbands;
} bands;

static kn_status length_at(kn_ctx *ctx, double *sum, double *length, const kn_spline *s, int var, double at)
{
    kn_status status = kn_cells_span_lengths(ctx, length, s, var, at);
    *sum = 0.0;
    for (int i = 0; status == KN_OK && i < kn_spline_spans(s, var); i++) *sum += length[i];
    return status;
}

static kn_status make_room(kn_ctx *ctx, bands *b)
{
    int most = 1;
    for (int m = 0; m < b->n; m++) {
        const kn_spline *s = b->along[m].surface;
        if (b->along[m].var != 1) return kn_fail(ctx, KN_EDOMAIN, "bands: variable %d", b->along[m].var);
        kn_status status = kn_cells_expect(ctx, "bands", s);
        if (status != KN_OK) return status;
        for (int v = 0; v < 2; v++) most = kn_spline_spans(s, v) > most ? kn_spline_spans(s, v) : most;
    }
    size_t n = (size_t)b->n;
    b->length = kn_scratch(ctx, (size_t)most, sizeof *b->length);
    b->share = kn_scratch(ctx, n, sizeof *b->share);
    b->least = kn_scratch(ctx, n, sizeof *b->least);
    b->most = kn_scratch(ctx, n, sizeof *b->most);
    bool room = b->length && b->share && b->least && b->most;
    for (int m = 0; room && m < b->n; m++) {
        b->share[m] = kn_scratch(ctx, (size_t)kn_spline_spans(b->along[m].surface, 0), sizeof **b->share);
        room = b->share[m];
    }
    return room ? KN_OK : KN_ENOMEM;
}

// The mean over variable 0 of the lengths along variable 1, of all members, with the sum of the nearest counts of the
// knot spans where that is within 15 %.
static kn_status count_rows(kn_ctx *ctx, bands *b)
{
    enum { CURVES = 9 };
    double sum = 0.0, suited = 0.0, length, lo, hi;
    int spans = kn_spline_spans(b->along[0].surface, 1);
    for (int m = 0; m < b->n; m++) {
        const kn_spline *s = b->along[m].surface;
        kn_spline_domain(s, 0, &lo, &hi);
        spans = kn_spline_spans(s, 1) > spans ? kn_spline_spans(s, 1) : spans;
        for (int i = 0; i < CURVES; i++) {
            kn_status status = length_at(ctx, &length, b->length, s, 1, lo + (hi - lo) * ((i + 0.5) / CURVES));
            if (status != KN_OK) return status;
            sum += length / b->size[1] / CURVES / b->n;
            for (int k = 0; k < kn_spline_spans(s, 1); k++)
                suited += fmax(1.0, round(b->length[k] / b->size[1])) / CURVES / b->n;
        }
    }
    double rows = fmax(spans, round(sum));
    if (fabs(suited - rows) <= 0.15 * rows) rows = fmax(spans, round(suited));
    if (!(rows <= most_cells))
        return kn_fail(ctx, KN_ELIMIT, "bands: %g rows of height %g, at most %g", rows, b->size[1], most_cells);
    b->rows = (int)rows;
    return KN_OK;
}

// Wanted cells of each row, at its middle; never fewer than knot spans.
static kn_status count_columns(kn_ctx *ctx, bands *b)
{
    for (int m = 0; m < b->n; m++) {
        const kn_spline *s = b->along[m].surface;
        int spans = kn_spline_spans(s, 0);
        double length, all = 0.0;
        for (int i = 0; i < spans; i++) b->share[m][i] = 0.0;
        for (int r = 0; r < b->rows; r++) {
            kn_status status = length_at(ctx, &length, b->length, s, 0, 0.5 * (b->lines[m][r] + b->lines[m][r + 1]));
            if (status != KN_OK) return status;
            for (int i = 0; i < spans; i++) b->share[m][i] += b->length[i];
            all += length;
            double cells = fmax(spans, length / b->size[0]);
            if (!(cells <= most_cells))
                return kn_fail(ctx, KN_ELIMIT, "bands: %g cells of width %g, at most %g", cells, b->size[0],
                               most_cells);
            b->wanted[m * b->rows + (b->along[m].reversed ? b->rows - 1 - r : r)] = cells;
        }
        for (int i = 0; i < spans; i++) b->share[m][i] = all > 0.0 ? b->share[m][i] / all : 1.0 / spans;
        kn_status status = kn_progress(ctx, "bands", (m + 1.0) / b->n);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

// The nearest count to the geometric mean; where it is within 15 % the sum of the nearest counts of all knot spans,
// so that their cells are as wide.
static int band_count(const bands *b, int m, int first, int end)
{
    double least = INFINITY, most = 0.0;
    for (int r = first; r < end; r++) {
        least = fmin(least, b->wanted[m * b->rows + r]);
        most = fmax(most, b->wanted[m * b->rows + r]);
    }
    double count = sqrt(least * most), sum = 0.0;
    for (int i = 0; i < kn_spline_spans(b->along[m].surface, 0); i++) sum += fmax(1.0, round(count * b->share[m][i]));
    return (int)(fabs(sum - count) <= 0.15 * count ? sum : round(count));
}

// Takes row r into each member's range; false: one of them would be too wide.
static bool widen(const bands *b, int r, bool anew)
{
    bool fits = true;
    for (int m = 0; m < b->n; m++) {
        double w = b->wanted[m * b->rows + r];
        b->least[m] = anew ? w : fmin(b->least[m], w);
        b->most[m] = anew ? w : fmax(b->most[m], w);
        fits = fits && b->most[m] <= largest_ratio * b->least[m];
    }
    return fits;
}

// A row begins a band where any member's rows would differ too much otherwise; bands of one count are one.
static void cut(bands *b)
{
    b->nbands = 0;
    for (int r = 0; r < b->rows; r++)
        if (r == 0 || !widen(b, r, false)) {
            b->first[b->nbands++] = r;
            (void)widen(b, r, true);
        }
    int kept = 1;
    for (int k = 1; k < b->nbands; k++) {
        int end = k + 1 < b->nbands ? b->first[k + 1] : b->rows;
        bool same = true;
        for (int m = 0; same && m < b->n; m++)
            same = band_count(b, m, b->first[kept - 1], b->first[k]) == band_count(b, m, b->first[k], end);
        if (!same) b->first[kept++] = b->first[k];
    }
    b->nbands = kept;
}

static kn_cells_band *write_bands(kn_ctx *ctx, const bands *b)
{
    kn_cells_band *out = kn_alloc(ctx, (size_t)b->n * (size_t)b->nbands, sizeof *out);
    for (int m = 0; out && m < b->n; m++)
        for (int k = 0; k < b->nbands; k++) {
            int first = b->first[k], end = k + 1 < b->nbands ? b->first[k + 1] : b->rows, at = k, from = first;
            kn_cells_band band = {.count = {band_count(b, m, first, end), end - first}};
            if (b->along[m].reversed) at = b->nbands - 1 - k, from = b->rows - end;
            band.lo = b->lines[m][from];
            band.hi = b->lines[m][from + end - first];
            out[m * b->nbands + at] = band;
        }
    return out;
}

static kn_status find_bands(kn_ctx *ctx, bands *b)
{
    kn_status status = make_room(ctx, b);
    if (status == KN_OK) status = count_rows(ctx, b);
    if (status == KN_OK) status = kn_cells_shared_lines(ctx, b->lines, b->along, b->n, b->rows);
    if (status != KN_OK) return status;
    b->wanted = kn_scratch(ctx, (size_t)b->n * (size_t)b->rows, sizeof *b->wanted);
    b->first = kn_scratch(ctx, (size_t)b->rows, sizeof *b->first);
    status = b->wanted && b->first ? count_columns(ctx, b) : KN_ENOMEM;
    if (status == KN_OK) cut(b);
    return status;
}

kn_status kn_cells_shared_bands(kn_ctx *ctx, kn_cells_band **out, int *nbands, const kn_cells_along *along, int n,
                                const double size[2])
{
    if (n < 1) return kn_fail(ctx, KN_EDOMAIN, "bands: %d surfaces", n);
    for (int d = 0; d < 2; d++)
        if (!(size[d] > 0.0) || isinf(size[d])) return kn_fail(ctx, KN_EDOMAIN, "bands: cells of size %g", size[d]);
    kn_mark mark = kn_scratch_mark(ctx);
    bands b = {.along = along, .n = n, .size = size};
    b.lines = kn_scratch(ctx, (size_t)n, sizeof *b.lines);
    if (b.lines) memset(b.lines, 0, (size_t)n * sizeof *b.lines);
    kn_status status = b.lines ? find_bands(ctx, &b) : KN_ENOMEM;
    kn_cells_band *made = status == KN_OK ? write_bands(ctx, &b) : NULL;
    if (status == KN_OK && !made) status = KN_ENOMEM;
    if (status == KN_OK) {
        *out = made;
        *nbands = b.nbands;
    }
    for (int m = 0; b.lines && m < n; m++) kn_free(ctx, b.lines[m]);
    kn_scratch_release(ctx, mark);
    return status;
}
