// SPDX-License-Identifier: Apache-2.0
// Fuzzes cells: surfaces, lines and counts by bytes.
#include "tests/fuzz/feed.h"

#include <knurl/cells.h>
#include <math.h>

// A surface that is bent a little, or one of any shape and numbers.
static void make_surface(feed *f, kn_spline *out)
{
    if (feed_byte(f) % 4 == 0) {
        feed_spline(f, out, 2);
        return;
    }
    int degree[2], count[2];
    const double *knots[2];
    bool rational = feed_byte(f) % 3 == 0;
    for (int d = 0; d < 2; d++) {
        degree[d] = feed_int(f, 1, 3);
        count[d] = degree[d] + 1 + feed_int(f, 0, 2);
        knots[d] = feed_knots(f, degree[d], count[d], 0.0, 1.0);
    }
    size_t n = (size_t)count[0] * (size_t)count[1];
    double *coef = feed_room(f, 4 * n), bend = feed_byte(f) / 256.0;
    for (size_t i = 0; i < n; i++) {
        double w = rational ? 0.5 + feed_byte(f) / 256.0 : 1.0;
        coef[i] = w * ((double)(i / (size_t)count[1]) + bend * feed_finite(f));
        coef[n + i] = w * ((double)(i % (size_t)count[1]) + bend * feed_finite(f));
        coef[2 * n + i] = w * bend * feed_finite(f);
        coef[3 * n + i] = w;
    }
    *out = (kn_spline){0};
    if (kn_spline_init(f->ctx, out, 2, 3 + rational, rational, degree, count, knots, coef) != KN_OK)
        kn_ctx_clear_error(f->ctx);
}

static double *make_lines(feed *f, int *n)
{
    *n = feed_int(f, 1, 6);
    double *x = feed_parameters(f, (size_t)*n);
    for (int i = 0; i < *n && feed_byte(f) % 8; i++) x[i] = i / fmax(1.0, *n - 1.0);
    return x;
}

// Lines that no call refuses for its own sake must increase from one end to the other.
static void check_lines(const double *x, int n)
{
    for (int i = 0; i < n; i++)
        if (!(x[i] < x[i + 1])) abort();
}

static kn_status lines(feed *f, int call, const kn_spline s[2])
{
    double *made[2] = {NULL, NULL};
    int count = feed_wild(f, 1, 12), var = feed_wild(f, 0, 1);
    if (count > 1000) count = 1000;
    const kn_cells_along along[2] = {{&s[0], var, false}, {&s[feed_byte(f) % 2], var, feed_byte(f) % 2}};
    int n = call == 2 ? feed_count(f, 1, 2) : 1;
    kn_status status = call == 0   ? kn_cells_uniform_lines(f->ctx, made, &s[0], var, count)
                       : call == 1 ? kn_cells_even_lines(f->ctx, made, &s[0], var, count)
                                   : kn_cells_shared_lines(f->ctx, made, along, n, count);
    for (int k = 0; k < 2; k++) {
        if (made[k]) check_lines(made[k], count);
        kn_free(f->ctx, made[k]);
    }
    return status;
}

static kn_status sizes(feed *f, int call, const kn_spline s[2])
{
    kn_cells_grid grids[2] = {{.surface = &s[0]}, {.surface = &s[1]}};
    kn_cells_spread spread;
    for (int g = 0; g < 2; g++)
        for (int d = 0; d < 2; d++)
            if (feed_byte(f) % 2) grids[g].lines[d] = make_lines(f, &grids[g].nlines[d]);
    int var = feed_wild(f, 0, 1), spans = var == 0 || var == 1 ? kn_spline_spans(&s[0], var) : 0;
    feed_any(kn_cells_span_lengths(f->ctx, feed_room(f, (size_t)spans), &s[0], var, feed_number(f)));
    kn_ctx_clear_error(f->ctx);
    if (call == 0) return kn_cells_measure(f->ctx, &spread, &s[0], grids[0].lines, grids[0].nlines);
    kn_status status = kn_cells_measure_all(f->ctx, &spread, grids, feed_count(f, 1, 2));
    if (status == KN_OK && !(spread.area.min <= spread.area.max)) abort();
    return status;
}

static kn_status bands(feed *f, const kn_spline s[2])
{
    const double size[2] = {feed_number(f), feed_number(f)};
    const kn_cells_along along[2] = {{&s[0], 1, false}, {&s[feed_byte(f) % 2], 1, feed_byte(f) % 2}};
    kn_cells_band *list = NULL;
    int n = 0, members = feed_count(f, 1, 2);
    kn_status status = members == 1 ? kn_cells_bands(f->ctx, &list, &n, &s[0], size)
                                    : kn_cells_shared_bands(f->ctx, &list, &n, along, members, size);
    for (int k = 1; k < n; k++)
        if (list[k].lo != list[k - 1].hi) abort();
    kn_free(f->ctx, list);
    return status;
}

static kn_status stretch(feed *f, const kn_spline *s)
{
    double *line[2] = {NULL, NULL}, error;
    int n[2];
    kn_spline h = {0};
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < 2; d++) {
        int count = feed_int(f, 1, 6);
        n[d] = count + 1;
        status = kn_cells_uniform_lines(f->ctx, &line[d], s, d, count);
    }
    const double *const both[2] = {line[0], line[1]};
    kn_cells_stretch_options o = {.degree = feed_int(f, -1, 4)};
    if (feed_byte(f) % 4 == 0) o.mean = feed_number(f), o.tolerance = feed_number(f);
    if (status == KN_OK) status = kn_cells_stretch(f->ctx, &h, &error, s, both, n, &o);
    if (status == KN_OK && !(error >= 0.0)) abort();
    kn_spline_clear(f->ctx, &h);
    for (int d = 0; d < 2; d++) kn_free(f->ctx, line[d]);
    return status;
}

// Corners, then S of them: exactly, or fitted; or S of a map of any shape.
static kn_status free_corners(feed *f, const kn_spline *s)
{
    const int count[2] = {feed_int(f, 0, 6), feed_int(f, 0, 6)};
    const int flags = feed_byte(f);
    kn_cells_relax_options o = {.closed = {flags % 2, flags / 2 % 2},
                                .fixed = {{flags / 4 % 2, flags / 8 % 2}, {flags / 4 % 2}}};
    o.all_knots = flags / 64 % 2, o.smooth = flags / 16 % 2, o.iterations = feed_int(f, 1, 12);
    if (flags / 32 % 2 == 0) o.area = feed_number(f);
    kn_spline map = {0}, out = {0};
    double error = -1.0, tolerance = feed_byte(f) % 4 ? ldexp(1.0, -feed_int(f, 0, 30)) : feed_number(f);
    kn_status status = kn_cells_relax(f->ctx, &map, s, count, &o);
    if (status != KN_OK && feed_byte(f) % 2) { // what a caller may hand in
        kn_ctx_clear_error(f->ctx);
        feed_spline(f, &map, 2);
        kn_ctx_clear_error(f->ctx);
        status = KN_OK;
    }
    kn_cells_fit_options fit = {.tolerance = tolerance};
    if (flags / 128 % 2) fit.at_most = feed_number(f), fit.degree_sum = feed_int(f, 0, 16);
    if (status == KN_OK)
        status = feed_byte(f) % 2 ? kn_cells_compose(f->ctx, &out, s, &map)
                                  : kn_cells_fit(f->ctx, &out, &error, s, &map, &fit);
    if (status == KN_OK && !out.coef) abort();
    if (status == KN_OK && error != -1.0 && !(error >= 0.0 && error <= fmax(tolerance, fit.at_most))) abort();
    kn_spline_clear(f->ctx, &map), kn_spline_clear(f->ctx, &out);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    kn_spline s[2] = {{0}};
    int call = feed_byte(&f) % 12;
    for (int k = 0; k < 2; k++) make_surface(&f, &s[k]);
    kn_ctx_clear_error(f.ctx);
    kn_status status = call < 3   ? lines(&f, call, s)
                       : call < 5 ? sizes(&f, call - 3, s)
                       : call < 6 ? bands(&f, s)
                       : call < 8 ? stretch(&f, &s[0])
                                  : free_corners(&f, &s[0]);
    if ((status == KN_OK) != (kn_ctx_error(f.ctx) == KN_OK)) abort();
    for (int k = 0; k < 2; k++) kn_spline_clear(f.ctx, &s[k]);
    feed_end(&f);
    return 0;
}
