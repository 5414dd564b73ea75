// SPDX-License-Identifier: Apache-2.0
// Fuzzes predicates and systems of equations, with little room for work: whatever comes, a call ends.
#include "tests/fuzz/feed.h"

#include <knurl/solve.h>

static kn_status predicates(feed *f, int call)
{
    kn_bezier a;
    feed_bezier(f, &a, feed_int(f, 0, 3));
    size_t nvars = a.nvars > 0 ? (size_t)a.nvars : 0;
    const double *lo = NULL, *hi = NULL;
    if (feed_byte(f) % 2) lo = feed_parameters(f, nvars), hi = feed_parameters(f, nvars);
    int depth = feed_wild(f, 0, 6);
    if (depth > 6 && depth <= KN_SOLVE_MAX_DEPTH) depth = 6; // boxes double with each
    kn_sign sign;
    kn_answer answer;
    kn_bezier broken = feed_broken(f, &a);
    const kn_bezier *piece = feed_byte(f) >= 248 ? &broken : &a;
    kn_ctx_clear_error(f->ctx);
    kn_status status = call == 0   ? kn_solve_sign(f->ctx, &sign, piece, lo, hi, depth)
                       : call == 1 ? kn_solve_nonzero(f->ctx, &answer, piece, lo, hi, depth)
                                   : kn_solve_monotone(f->ctx, &sign, piece, feed_wild(f, 0, 2), lo, hi, depth);
    if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort();
    kn_bezier_clear(f->ctx, &a);
    return status;
}

static kn_solve_options make_options(feed *f)
{
    kn_solve_options options = kn_solve_defaults();
    options.max_boxes = 1 + (size_t)feed_int(f, 0, 200);
    options.max_undecided = 1 + (size_t)feed_int(f, 0, 40);
    options.max_depth = feed_wild(f, 1, 60);
    if (feed_byte(f) % 4 == 0) options.tolerance = feed_number(f);
    if (feed_byte(f) % 4 == 0) options.residual = feed_number(f);
    return options;
}

static void check(feed *f, kn_status status, kn_root *roots, size_t n, int nvars)
{
    if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort();
    for (size_t i = 0; status == KN_OK && i < n; i++)
        for (int d = 0; d < nvars; d++)
            if (!(roots[i].lo[d] <= roots[i].at[d] && roots[i].at[d] <= roots[i].hi[d])) abort();
    kn_free(f->ctx, roots);
}

static void systems_of_pieces(feed *f)
{
    kn_bezier a[4];
    int nvars = feed_int(f, 1, 3), n = feed_count(f, 1, 4);
    for (int i = 0; i < 4; i++) feed_bezier(f, &a[i], nvars);
    kn_solve_options options = make_options(f);
    kn_root *roots = NULL;
    size_t nroots = 0;
    kn_solve_report report;
    kn_ctx_clear_error(f->ctx);
    kn_status status = kn_solve_zeros_bezier(f->ctx, &roots, &nroots, &report, a, n, &options);
    check(f, status, roots, nroots, a[0].nvars);
    for (int i = 0; i < 4; i++) kn_bezier_clear(f->ctx, &a[i]);
}

// Call 0: zeros; the others: one function, intersections.
static void systems_of_splines(feed *f, int call)
{
    kn_spline a[4];
    int nvars = call == 0 ? feed_int(f, 1, 3) : 1, n = feed_count(f, 1, 4);
    const double *point = feed_numbers(f, 3), *direction = feed_numbers(f, 3);
    for (int i = 0; i < 4; i++) feed_spline(f, &a[i], call > 1 && i == 1 ? 2 : nvars);
    kn_solve_options options = make_options(f);
    kn_root *roots = NULL;
    size_t nroots = 0;
    kn_solve_report report;
    kn_ctx_clear_error(f->ctx);
    kn_status status;
    switch (call) {
    case 0: status = kn_solve_zeros(f->ctx, &roots, &nroots, &report, a, n, &options); break;
    case 1: status = kn_solve_roots(f->ctx, &roots, &nroots, &report, a, &options); break;
    case 2:
        status = kn_solve_intersect_line_surface(f->ctx, &roots, &nroots, &report, a + 1, point, direction, &options);
        break;
    case 3: status = kn_solve_intersect_curve_surface(f->ctx, &roots, &nroots, &report, a, a + 1, &options); break;
    default: status = kn_solve_intersect_curves(f->ctx, &roots, &nroots, &report, a, a + 2, &options); break;
    }
    check(f, status, roots, nroots, call == 0 ? a[0].nvars : call == 1 ? 1 : call == 3 ? 3 : 2);
    for (int i = 0; i < 4; i++) kn_spline_clear(f->ctx, &a[i]);
}

// Points come nearest first, from the domain, and each repeats the distance of its own point.
static void closest_points(feed *f)
{
    kn_spline s;
    feed_spline(f, &s, feed_int(f, 1, 3));
    int dim = s.nvars ? kn_spline_dim(&s) : 1;
    const double *point = feed_numbers(f, (size_t)dim);
    kn_solve_options options = make_options(f);
    kn_closest *found = NULL;
    size_t n = 0;
    double lower = 0.0;
    kn_solve_report report;
    bool quiet = feed_byte(f) % 4 == 0;
    kn_ctx_clear_error(f->ctx);
    kn_status status = kn_solve_closest(f->ctx, &found, &n, quiet ? NULL : &lower, quiet ? NULL : &report, &s, point,
                                        &options);
    if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort();
    if (status == KN_OK && (n == 0 || !(lower >= 0.0))) abort();
    for (size_t i = 0; i < n; i++) {
        if (!(found[i].distance >= (i ? found[i - 1].distance : 0.0))) abort();
        for (int d = 0; d < s.nvars; d++) {
            double lo, hi;
            kn_spline_domain(&s, d, &lo, &hi);
            if (!(lo <= found[i].at[d] && found[i].at[d] <= hi)) abort();
        }
    }
    kn_free(f->ctx, found);
    kn_spline_clear(f->ctx, &s);
}

// Curves of a small function, whose points lie in the square.
static void curves(feed *f)
{
    kn_bezier a = {0};
    kn_solve_curve *list = NULL;
    size_t n = 0;
    feed_bezier(f, &a, 2);
    double tol = feed_byte(f) % 8 == 0 ? feed_number(f) : 0.02;
    if (tol < 1e-3) tol = 1e-3;
    kn_ctx_clear_error(f->ctx);
    kn_status status = kn_solve_curves_bezier(f->ctx, &list, &n, NULL, &a, tol);
    if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort();
    for (size_t c = 0; status == KN_OK && c < n; c++)
        for (size_t i = 0; i < 2 * list[c].npoints; i++)
            if (!(list[c].points[i] >= 0.0 && list[c].points[i] <= 1.0)) abort();
    kn_free(f->ctx, list);
    kn_bezier_clear(f->ctx, &a);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    int call = feed_byte(&f) % 14;
    if (call >= 12)
        curves(&f);
    else if (call >= 10)
        closest_points(&f);
    else if (call < 3)
        (void)predicates(&f, call);
    else if (call == 3)
        systems_of_pieces(&f);
    else
        systems_of_splines(&f, call - 4 < 5 ? call - 4 : 0);
    feed_end(&f);
    return 0;
}
