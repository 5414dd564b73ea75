// SPDX-License-Identifier: Apache-2.0
// What Open CASCADE finds in the IGES files that the IGES sink writes.
#include "tests/support/integral.h"
#include "tests/support/patches.h"
#include <knurl/iges.h>

#if KN_WITH_OCCT
#include "tests/bridges/occt_trip.h"

#include <math.h>
#include <stdio.h>

static void trip_through(trip *t, const kn_iges_options *options)
{
    kn_sink sink;
    assert_int_equal(kn_iges_sink(t->ctx, &sink, t->path, options), KN_OK);
    trip_write(t, &sink, 2);
    trip_read(t);
}

static void kinds(void **state)
{
    (void)state;
    for (int surfaces = 0; surfaces < 2; surfaces++) {
        trip t;
        trip_start(&t, "trip.igs", 1);
        trip_add(&t, 1, 1, false);
        trip_add(&t, 2, 5, false);
        trip_add(&t, 21, 14, false);
        trip_add(&t, 2, 2, true);
        trip_add(&t, 5, 4, true);
        trip_through(&t, &(kn_iges_options){.unit_mm = 25.4, .surfaces = surfaces});
        trip_expect_points(&t, 25.4);
        assert_int_equal(t.report.solids, 0);
        assert_int_equal(t.report.rational_faces, 2);
        assert_int_equal(t.report.max_degree, 21);
        assert_int_equal(t.report.edges, 20);
        assert_int_equal(t.report.vertices, 20);
        trip_end(&t);
    }
}

// A patch that is a spline: two of them side by side, with edges fitted by themselves in fewer knots.
static void splines(void **state)
{
    (void)state;
    trip t;
    kn_spline s[2] = {{0}}, edge[2][4] = {{{0}}};
    const double half = 0.5;
    trip_start(&t, "trip.igs", 1);
    for (int i = 0; i < 2; i++) {
        kn_patch *patch = trip_add(&t, 3, 3, false);
        for (int k = 0; k < 4; k++) // r = 1 of the first is r = 0 of the second
            for (int c = 0; c < 3 && i == 1; c++)
                patch->bezier.coef[16 * c + k] = t.patch[0].bezier.coef[16 * c + 12 + k];
        assert_int_equal(kn_spline_of_bezier(t.ctx, &s[i], &patch->bezier), KN_OK);
        for (int e = 0; e < 4; e++)
            assert_int_equal(kn_spline_isoparametric(t.ctx, &edge[i][e], &s[i], e / 2, e % 2), KN_OK);
        for (int v = 0; v <= i; v++) // knots that the edges do not have
            assert_int_equal(kn_spline_insert_knots(t.ctx, &s[i], &s[i], v, &half, 1), KN_OK);
    }
    for (int i = 0; i < 2; i++) {
        kn_bezier_clear(t.ctx, &t.patch[i].bezier);
        t.patch[i].spline = &s[i], t.patch[i].edge = edge[i];
    }
    trip_through(&t, NULL);
    trip_expect_points(&t, 1.0);
    assert_int_equal(t.report.edges, 7);
    assert_int_equal(t.report.vertices, 6);
    assert_int_equal(t.report.shells, 1);
    for (int i = 0; i < 2; i++) {
        kn_spline_clear(t.ctx, &s[i]);
        for (int e = 0; e < 4; e++) kn_spline_clear(t.ctx, &edge[i][e]);
    }
    trip_end(&t);
}

// The closed cubic-like loop in one variable, straight in the other; top: the other end is a point.
static void make_tube(kn_bezier *b, double x0, bool top)
{
    static const double loop[7][2] = {{1, 0}, {1, 2}, {-2, 2}, {-3, 0}, {-2, -2}, {1, -2}, {1, 0}};
    for (int i = 0; i < 7; i++)
        for (int j = 0; j < 2; j++) {
            double wide = top && j == 1 ? 0.0 : 0.1;
            b->coef[2 * i + j] = x0 + wide * loop[i][0];
            b->coef[14 + 2 * i + j] = wide * loop[i][1];
            b->coef[28 + 2 * i + j] = 0.5 * j;
        }
}

static void seams_and_poles(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "trip.igs", 1);
    make_tube(&trip_add(&t, 6, 1, false)->bezier, 0.0, false);
    make_tube(&trip_add(&t, 6, 1, false)->bezier, 4.0, true);
    kn_bezier *b = &trip_add(&t, 3, 3, false)->bezier;
    for (int k = 1; k < 4; k++)
        for (int c = 0; c < 3; c++) b->coef[16 * c + k] = b->coef[16 * c]; // edge r = 0
    trip_through(&t, NULL);
    trip_expect_points(&t, 1.0);
    trip_end(&t);
}

// Biquadratic faces on a lattice of 3 x 3 x 3 points that are moved by chance: a cube with bent faces, bit for bit
// closed. turned: r and t exchanged, which the face tells.
static void add_cube(trip *t, int nfaces, int turned)
{
    double lattice[27][3];
    for (int k = 0; k < 27; k++)
        for (int c = 0; c < 3; c++) {
            int at = c == 0 ? k / 9 : c == 1 ? k / 3 % 3 : k % 3;
            lattice[k][c] = 10.0 * at + test_uniform(&t->rng, -1.5, 1.5);
        }
    for (int f = 0; f < nfaces; f++) {
        kn_patch *patch = trip_add(t, 2, 2, false);
        int axis = f / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        bool swap = (f % 2 == 0) != (f == turned); // r x t points along the axis unless swapped
        for (int k = 0; k < 9; k++) {
            int at[3];
            at[axis] = f % 2 == 0 ? 0 : 2;
            at[u] = swap ? k % 3 : k / 3, at[v] = swap ? k / 3 : k % 3;
            for (int c = 0; c < 3; c++) patch->bezier.coef[9 * c + k] = lattice[9 * at[0] + 3 * at[1] + at[2]][c];
        }
        patch->look = patch->id.part = f == 5 ? 2 : 0;
        patch->id.patch = f;
        patch->reversed = f == turned;
    }
}

static void bodies(void **state)
{
    (void)state;
    for (int lack = 0; lack < 3; lack++) {
        trip t;
        trip_start(&t, "trip.igs", 3);
        add_cube(&t, lack == 1 ? 5 : 6, lack == 2 ? 3 : -1);
        const char *const surfaces[3] = {"", NULL, "the grip"};
        trip_through(&t, lack == 2 ? &(kn_iges_options){.surface_names = surfaces, .nsurfaces = 3} : NULL);
        assert_int_equal(t.report.edges, 12);
        assert_int_equal(t.report.vertices, 8);
        assert_int_equal(t.report.shells, 1);
        assert_int_equal(t.report.closed_shells, lack != 1);
        assert_int_equal(t.report.solids, lack != 1);
        assert_int_equal(t.report.free_edges, lack == 1 ? 4 : 0);
        double volume = 0.0, area = 0.0;
        for (size_t i = 0; i < t.count; i++) test_add_integrals(t.ctx, &volume, &area, &t.patch[i]);
        if (lack != 1) assert_true(fabs(t.report.volume - volume) <= 1e-9 * volume); // both by Gauss, exact here
        for (size_t i = 0; i < t.count; i++) {
            char name[64], expected[64];
            double p[3], n[3], out = 0.0;
            snprintf(expected, sizeof expected, "%s c%zu,7 %s %zu", lack == 2 ? "the grip" : "s2", i,
                     t.tile.part[t.patch[i].look].name, i);
            assert_int_equal(kn_occt_face_name(t.ctx, name, sizeof name, t.model, (int)i), KN_OK);
            assert_string_equal(name, expected);
            assert_int_equal(kn_occt_eval(t.ctx, p, n, t.model, (int)i, 0.5, 0.5), KN_OK);
            for (int c = 0; c < 3; c++) out += n[c] * (p[c] - 10.0);
            assert_true(out > 0.0); // the faces look out
        }
        // four digits of sRGB, back to linear: at most 5e-5 times the steepest slope (3.3) of the inverse
        assert_int_equal(t.report.ncolours, lack == 1 ? 1 : 2);
        for (int i = 0; i < t.report.ncolours; i++) {
            const double *a = t.report.colour[i], *x = t.tile.part[0].material.base_color;
            const double *y = t.tile.part[2].material.base_color;
            assert_true(fmin(test_max_difference(a, x, 3), test_max_difference(a, y, 3)) <= 2e-4);
        }
        trip_end(&t);
    }
}

// A circle and lines that bend: a face for each side, one with a hole; valid, on the patch's own surface.
static void trimmed_faces(void **state)
{
    (void)state;
    enum { CUTS = 4 };
    trip t;
    kn_trim side[2 * CUTS] = {0};
    trip_start(&t, "trip.igs", 1);
    trip_add_cuts(&t, side, CUTS);
    trip_through(&t, NULL);
    assert_true(t.report.max_tolerance < 2e-3); // that of the cut, and what cubics in space are off
    double area = t.report.area, ours = 0.0, unused = 0.0;
    for (size_t i = 0; i < t.count; i += 2) test_add_integrals(t.ctx, &unused, &ours, &t.patch[i]);
    for (size_t i = 1; i < t.count; i += 2) test_add_integrals(t.ctx, &unused, &ours, &t.patch[i]);
    assert_true(area > 0.4 * ours && area < 0.6 * ours); // two sides of each, of patches much alike
    for (int i = 6; i < 8; i++) {                        // turned round: nearly flat, they look down
        double point[3], normal[3];
        assert_int_equal(kn_occt_eval(t.ctx, point, normal, t.model, i, 0.5, 0.5), KN_OK);
        assert_true(normal[2] < -0.5);
    }
    for (int k = 0; k < 2 * CUTS; k++) kn_trim_clear(t.ctx, &side[k]);
    trip_end(&t);
}

static void failures(void **state)
{
    (void)state;
    trip t;
    trip_start(&t, "trip.igs", 1);
    assert_int_equal(kn_occt_open_iges(t.ctx, &t.model, "/nowhere/bad.igs"), KN_EIO);
    kn_ctx_clear_error(t.ctx);
    test_write_file(t.path, "not IGES at all", 15);
    assert_int_equal(kn_occt_open_iges(t.ctx, &t.model, t.path), KN_EPARSE);
    assert_null(t.model);
    trip_end(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kinds),  cmocka_unit_test(splines),       cmocka_unit_test(seams_and_poles),
        cmocka_unit_test(bodies), cmocka_unit_test(trimmed_faces), cmocka_unit_test(failures),
    };
    return cmocka_run_group_tests_name("bridges/occt_iges", tests, NULL, NULL);
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
    return cmocka_run_group_tests_name("bridges/occt_iges", tests, NULL, NULL);
}
#endif
