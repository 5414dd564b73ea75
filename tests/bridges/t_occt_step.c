// SPDX-License-Identifier: Apache-2.0
// What Open CASCADE finds in the STEP files that the STEP sink writes.
#include "tests/support/patches.h"
#include <knurl/step.h>

#if KN_WITH_OCCT
#include "tests/bridges/occt_trip.h"

static void trip_through(trip *t, const kn_step_options *options, size_t block)
{
    kn_sink sink;
    assert_int_equal(kn_step_sink(t->ctx, &sink, t->path, options), KN_OK);
    trip_write(t, &sink, block);
    trip_read(t);
}

static void polynomial(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "polynomial.step", 1);
    trip_add(&t, 1, 1, false);
    trip_add(&t, 3, 3, false);
    trip_add(&t, 2, 5, false);
    trip_add(&t, 21, 14, false);
    trip_add(&t, 25, 25, false);
    trip_through(&t, NULL, 2);
    trip_expect_points(&t, 1.0);
    assert_int_equal(t.report.solids, 0);
    assert_int_equal(t.report.rational_faces, 0);
    assert_int_equal(t.report.max_degree, 25);
    trip_end(&t);
}

static void rational(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "rational.step", 1);
    trip_add(&t, 2, 2, true);
    trip_add(&t, 3, 1, true);
    trip_add(&t, 5, 4, true);
    kn_bezier *equal = &trip_add(&t, 2, 2, true)->bezier; // all weights 2: written as a polynomial
    size_t n = kn_bezier_count(equal);
    for (size_t k = 0; k < n; k++) {
        for (size_t c = 0; c < 3; c++) equal->coef[c * n + k] *= 2.0 / equal->coef[3 * n + k];
        equal->coef[3 * n + k] = 2.0;
    }
    trip_through(&t, NULL, 1);
    trip_expect_points(&t, 1.0);
    assert_int_equal(t.report.rational_faces, 3);
    trip_end(&t);
}

// Control point (i, j) of a patch becomes that of (0, j), or whatever edge: 0: t = 0, 1: r = 1, 2: t = 1, 3: r = 0.
static void collapse(kn_bezier *b, int edge)
{
    int nr = b->degree[0] + 1, nt = b->degree[1] + 1, length = edge % 2 == 0 ? nr : nt;
    size_t n = kn_bezier_count(b);
    for (int k = 0; k < length; k++) {
        int at = edge == 0 ? k * nt : edge == 1 ? (nr - 1) * nt + k : edge == 2 ? k * nt + nt - 1 : k;
        int to = edge == 0 ? 0 : edge == 1 ? (nr - 1) * nt : edge == 2 ? nt - 1 : 0;
        for (size_t c = 0; c < 3; c++) b->coef[c * n + (size_t)at] = b->coef[c * n + (size_t)to];
    }
}

static void collapsed_edges(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "collapsed.step", 1);
    for (int e = 0; e < 4; e++) collapse(&trip_add(&t, 3, 3, false)->bezier, e);
    for (int e = 0; e < 2; e++) { // two-cornered patches
        kn_bezier *b = &trip_add(&t, 3, 3, false)->bezier;
        collapse(b, e);
        collapse(b, e + 2);
    }
    trip_add(&t, 3, 3, false)->bezier.coef[0] += 1e-15; // nearly: what rounding leaves of a pole
    collapse(&t.patch[6].bezier, 2);
    t.patch[6].bezier.coef[3] += 1e-16;
    trip_through(&t, NULL, 3);
    trip_expect_points(&t, 1.0);
    trip_end(&t);
}

// A quarter-turn symmetric tube: the closed cubic (cos, sin)-like loop in one variable, straight in the other.
static void make_tube(kn_bezier *b, int around, double x0)
{
    static const double loop[7][2] = {{1, 0}, {1, 2}, {-2, 2}, {-3, 0}, {-2, -2}, {1, -2}, {1, 0}};
    size_t n = kn_bezier_count(b);
    int nt = b->degree[1] + 1;
    for (int i = 0; i <= b->degree[0]; i++)
        for (int j = 0; j < nt; j++) {
            size_t k = (size_t)(i * nt + j);
            int turn = around == 0 ? i : j, along = around == 0 ? j : i;
            b->coef[k] = x0 + 0.1 * loop[turn][0];
            b->coef[n + k] = 0.1 * loop[turn][1];
            b->coef[2 * n + k] = 0.5 * along;
        }
}

static void closed_patches(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "closed.step", 1);
    make_tube(&trip_add(&t, 6, 1, false)->bezier, 0, 0.0);
    make_tube(&trip_add(&t, 1, 6, false)->bezier, 1, 2.0);
    kn_bezier *cone = &trip_add(&t, 6, 1, false)->bezier; // closed, and one edge collapsed
    make_tube(cone, 0, 4.0);
    collapse(cone, 2);
    trip_through(&t, NULL, 4);
    trip_expect_points(&t, 1.0);
    trip_end(&t);
}

static void orientation(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "reversed.step", 1);
    for (int i = 0; i < 4; i++) {
        kn_patch *patch = trip_add(&t, 3, 2, i >= 2);
        patch->reversed = i % 2 == 1;
    }
    trip_through(&t, NULL, 4);
    trip_expect_points(&t, 1.0);
    for (int i = 0; i < 4; i++) { // the patches are nearly flat: r x t points up
        double point[3], normal[3];
        assert_int_equal(kn_occt_eval(t.ctx, point, normal, t.model, i, 0.5, 0.5), KN_OK);
        assert_true(i % 2 == 1 ? normal[2] < -0.5 : normal[2] > 0.5);
    }
    trip_end(&t);
}

// Several parts: a colour each; names; units.
static void parts_names_units(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "parts.step", 3);
    for (int i = 0; i < 6; i++) {
        kn_patch *patch = trip_add(&t, 2, 2, false);
        patch->id.part = patch->look = i % 2 == 0 ? 0 : 2; // part 1 has no patch
        patch->id.piece = i == 5 ? 3 : 0;
    }
    trip_through(&t, &(kn_step_options){.product = "Teapot's \\ \xc3\xa9", .unit_mm = 25.4}, 4);
    char name[128];
    assert_int_equal(kn_occt_face_name(t.ctx, name, sizeof name, t.model, 1), KN_OK);
    assert_string_equal(name, "s2 c1,7 it's 12");
    assert_int_equal(kn_occt_face_name(t.ctx, name, sizeof name, t.model, 5), KN_OK);
    assert_string_equal(name, "s2 c5,7 it's 12.3");
    trip_expect_points(&t, 25.4);

    // four digits of sRGB, back to linear: at most 5e-5 times the steepest slope (3.3) of the inverse, and OCCT
    // keeps colours in single precision
    assert_int_equal(t.report.ncolours, 2);
    for (int i = 0; i < 2; i++) {
        const double *found = t.report.colour[i], red = found[0] < 0.5 ? 0.25 : 0.75;
        const double expected[3] = {red, 0.5, 0.125};
        assert_true(test_max_difference(found, expected, 3) <= 2e-4);
    }
    trip_end(&t);
}

static void failures(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "bad.step", 1);
    double point[3];
    char name[16];
    assert_int_equal(kn_occt_open_step(t.ctx, &t.model, "/nowhere/bad.step"), KN_EIO);
    kn_ctx_clear_error(t.ctx);
    test_write_file(t.path, "not STEP at all", 15);
    assert_int_equal(kn_occt_open_step(t.ctx, &t.model, t.path), KN_EPARSE);
    assert_null(t.model);
    kn_ctx_clear_error(t.ctx);
    trip_add(&t, 1, 1, false);
    trip_through(&t, NULL, 1);
    assert_int_equal(kn_occt_eval(t.ctx, point, NULL, t.model, 1, 0.0, 0.0), KN_EDOMAIN);
    assert_int_equal(kn_occt_eval(t.ctx, point, NULL, t.model, -1, 0.0, 0.0), KN_EDOMAIN);
    assert_int_equal(kn_occt_face_name(t.ctx, name, sizeof name, t.model, 1), KN_EDOMAIN);
    trip_end(&t);
}

// Cuts with the lines {f = 0} of random functions: a face for each side, some with holes; each one valid, on the
// patch's own surface, and on the side of the cut where it belongs by its bounding box.
static void trimmed_faces(void **state)
{
    (void)state;
    enum { CUTS = 6 };
    trip t;
    kn_trim side[2 * CUTS] = {0};
    trip_start(&t, "trimmed.step", 1);
    trip_add_cuts(&t, side, CUTS);
    trip_add(&t, 3, 3, false);
    trip_through(&t, NULL, 3);
    trip_expect_points(&t, 1.0);
    // curves in space are cubics through the trim's points, with the surface's derivatives there: far nearer than this
    assert_true(t.report.max_tolerance < 1e-3);
    for (int k = 0; k < 2 * CUTS; k++) kn_trim_clear(t.ctx, &side[k]);
    trip_end(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(polynomial),     cmocka_unit_test(rational),      cmocka_unit_test(collapsed_edges),
        cmocka_unit_test(closed_patches), cmocka_unit_test(orientation),   cmocka_unit_test(parts_names_units),
        cmocka_unit_test(failures),       cmocka_unit_test(trimmed_faces),
    };
    return cmocka_run_group_tests_name("bridges/occt_step", tests, NULL, NULL);
}
#else
static void without_occt(void **state)
{
    (void)state;
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(without_occt)};
    return cmocka_run_group_tests_name("bridges/occt_step", tests, NULL, NULL);
}
#endif
