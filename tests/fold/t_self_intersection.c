// SPDX-License-Identifier: Apache-2.0
// Self-intersection of shells: closed forms, known clearances, and random sheets against crossing normals.
#include "tests/support/surfaces.h"

#include <knurl/construct.h>
#include <knurl/fit.h>
#include <knurl/fold.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

// ---- planar curves of lines and arcs, and the cylinders over them ----

enum { MOST_TURNS = 8, MOST_POINTS = 2 * MOST_TURNS * 4 + 1 };

typedef struct turtle {
    double at[2], heading;
    int n;
    double point[MOST_POINTS][3]; // x, y, weight
} turtle;

static void put(turtle *t, double x, double y, double w)
{
    memcpy(t->point[t->n++], (const double[3]){x, y, w}, 3 * sizeof(double));
}

static void line(turtle *t, double length)
{
    double x = t->at[0], y = t->at[1];
    t->at[0] += length * cos(t->heading), t->at[1] += length * sin(t->heading);
    put(t, 0.5 * (x + t->at[0]), 0.5 * (y + t->at[1]), 1.0);
    put(t, t->at[0], t->at[1], 1.0);
}

// To the left by an angle (to the right when negative), in pieces of at most a quarter.
static void arc(turtle *t, double radius, double angle)
{
    int pieces = (int)ceil(fabs(angle) / (0.5001 * PI));
    double step = angle / pieces, side = angle > 0.0 ? 1.0 : -1.0;
    for (int i = 0; i < pieces; i++) {
        double tangent = radius * tan(0.5 * fabs(step)), cx = t->at[0] - side * radius * sin(t->heading),
               cy = t->at[1] + side * radius * cos(t->heading);
        put(t, t->at[0] + tangent * cos(t->heading), t->at[1] + tangent * sin(t->heading), cos(0.5 * step));
        t->heading += step;
        t->at[0] = cx + side * radius * sin(t->heading), t->at[1] = cy - side * radius * cos(t->heading);
        put(t, t->at[0], t->at[1], 1.0);
    }
}

static turtle start(void)
{
    turtle t = {.n = 0};
    put(&t, 0.0, 0.0, 1.0);
    return t;
}

// The sheet over the curve, from z = 0 to z = 1, its normal to the left of the curve.
static void raise(kn_ctx *ctx, kn_spline *out, const turtle *t)
{
    double ku[MOST_POINTS + 3], coef[4 * 2 * MOST_POINTS];
    const double kv[4] = {0, 0, 1, 1}, *knots[2] = {kv, ku};
    int n = t->n;
    for (int i = 0; i < n + 3; i++)
        ku[i] = i < 3 ? 0.0 : (double)((i - 1) / 2 > (n - 1) / 2 ? (n - 1) / 2 : (i - 1) / 2);
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < n; i++) {
            const double *p = t->point[i], x[4] = {p[0] * p[2], p[1] * p[2], j * p[2], p[2]};
            for (int c = 0; c < 4; c++) coef[(c * 2 + j) * n + i] = x[c];
        }
    assert_int_equal(kn_spline_init(ctx, out, 2, 4, true, (const int[2]){1, 2}, (const int[2]){2, n}, knots, coef),
                     KN_OK);
}

// ---- asking ----

static kn_fold_intersection ask_regions(kn_ctx *ctx, const kn_spline *s, int n, const kn_fold_region *regions,
                                        size_t nregions, double w0, double w1, size_t work)
{
    enum { MOST = 32 };
    kn_shell *shells[MOST];
    const kn_shell *list[MOST];
    kn_fold_intersection r = {.boxes = 0};
    const double w[2] = {w0, w1};
    const kn_fold_options options = {.work = work};
    for (int i = 0; i < n; i++) {
        if (kn_shell_create(ctx, &shells[i], &s[i], NULL) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
        list[i] = shells[i];
    }
    if (kn_fold_self_intersection(ctx, &r, list, n, regions, nregions, w, &options) != KN_OK)
        fail_msg("%s", kn_ctx_message(ctx));
    if (r.verdict == KN_FOLD_FOUND) { // two places, inside, with one image
        double p[2][3], gap = 0.0, away = 0.0;
        assert_int_equal(kn_shell_eval(ctx, p[0], NULL, list[r.a.shell], r.a.lo[0], r.a.lo[1], r.a.lo[2]), KN_OK);
        assert_int_equal(kn_shell_eval(ctx, p[1], NULL, list[r.b.shell], r.b.lo[0], r.b.lo[1], r.b.lo[2]), KN_OK);
        for (int k = 0; k < 3; k++) {
            gap = fmax(gap, fabs(p[0][k] - p[1][k]));
            away = fmax(away, fabs(r.a.lo[k] - r.b.lo[k]));
            assert_true(r.a.lo[k] == r.a.hi[k] && r.b.lo[k] == r.b.hi[k]);
        }
        assert_true(gap <= 1e-10);
        assert_true(r.a.shell != r.b.shell || away > 1e-5);
        assert_true(regions || (r.a.lo[2] >= w0 && r.a.lo[2] <= w1 && r.b.lo[2] >= w0 && r.b.lo[2] <= w1));
    }
    assert_true((r.verdict == KN_FOLD_OPEN) == (r.undecided > 0));
    for (int i = 0; i < n; i++) kn_shell_destroy(ctx, shells[i]);
    return r;
}

static kn_fold_global ask(kn_ctx *ctx, const kn_spline *s, double w0, double w1)
{
    return ask_regions(ctx, s, 1, NULL, 0, w0, w1, 60000).verdict;
}

static void u_bend(kn_ctx *ctx, kn_spline *s, double clearance)
{
    turtle t = start();
    line(&t, 1.0);
    arc(&t, 0.5 * clearance, PI);
    line(&t, 1.0);
    raise(ctx, s, &t);
}

// Two parallel legs that open into a ring: the legs meet first.
static void horseshoe(kn_ctx *ctx, kn_spline *s)
{
    turtle t = start();
    line(&t, 1.0);
    arc(&t, 0.5, -PI / 3.0);
    arc(&t, 1.0, 5.0 * PI / 3.0);
    arc(&t, 0.5, -PI / 3.0);
    line(&t, 1.0);
    raise(ctx, s, &t);
}

// ---- known answers ----

// raise puts the normal on the left or on the right: `side` is 1 where w > 0 lies to the left.
static double side_of(kn_ctx *ctx, const kn_spline *s)
{
    kn_shell *shell;
    double n[3];
    assert_int_equal(kn_shell_create(ctx, &shell, s, NULL), KN_OK);
    assert_int_equal(kn_shell_unit_normal(ctx, n, shell, 0.5, 0.0), KN_OK);
    kn_shell_destroy(ctx, shell);
    return n[1] > 0.0 ? 1.0 : -1.0;
}

static kn_fold_global ask_left(kn_ctx *ctx, const kn_spline *s, double height)
{
    double side = side_of(ctx, s);
    return ask(ctx, s, fmin(0.0, side * height), fmax(0.0, side * height));
}

static void bent_sheets(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    u_bend(ctx, &s, 0.2); // arms 0.2 apart: they meet at 0.1
    assert_int_equal(ask_left(ctx, &s, 0.099), KN_FOLD_NONE);
    assert_int_equal(ask_left(ctx, &s, 0.101), KN_FOLD_FOUND);
    assert_int_equal(ask_left(ctx, &s, -0.5), KN_FOLD_NONE); // outwards there is room
    kn_spline_clear(ctx, &s);
    horseshoe(ctx, &s); // legs 0.5 apart: the ring's center lies 0.25 above the first leg
    assert_int_equal(ask_left(ctx, &s, 0.2475), KN_FOLD_NONE);
    assert_int_equal(ask_left(ctx, &s, 0.2525), KN_FOLD_FOUND);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void closed_forms(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_plane(ctx, &s);
    assert_int_equal(ask(ctx, &s, -5.0, 5.0), KN_FOLD_NONE);
    kn_spline_clear(ctx, &s);
    make_cylinder(ctx, &s); // radius 1, a seam; the normal points outwards
    assert_int_equal(ask(ctx, &s, -0.99, 0.5), KN_FOLD_NONE);
    assert_int_equal(ask(ctx, &s, -1.01, 0.0), KN_FOLD_FOUND);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// With a coarse normal, which has few pieces: the shell is what it is, and near to the torus and the sphere.
static kn_fold_global ask_coarse(kn_ctx *ctx, const kn_spline *s, double w0, double w1)
{
    kn_shell *shell;
    const kn_shell *list;
    const kn_shell_options options = {.normal_tol = 1e-3};
    kn_fold_intersection r;
    const double w[2] = {w0, w1};
    assert_int_equal(kn_shell_create(ctx, &shell, s, &options), KN_OK);
    list = shell;
    assert_int_equal(kn_fold_self_intersection(ctx, &r, &list, 1, NULL, 0, w, NULL), KN_OK);
    kn_shell_destroy(ctx, shell);
    return r.verdict;
}

static void round_bodies(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_torus(ctx, &s); // radii 3 and 1: seams both ways
    assert_int_equal(ask_coarse(ctx, &s, 0.0, 0.5), KN_FOLD_NONE);
    assert_int_equal(ask_coarse(ctx, &s, -1.02, 0.0), KN_FOLD_FOUND);
    assert_int_equal(ask_coarse(ctx, &s, 0.0, 2.04), KN_FOLD_FOUND);
    kn_spline_clear(ctx, &s);
    make_sphere(ctx, &s); // radius 2: two poles and a seam
    assert_int_equal(ask_coarse(ctx, &s, -0.25, 0.25), KN_FOLD_NONE);
    assert_int_equal(ask_coarse(ctx, &s, -2.1, 0.0), KN_FOLD_FOUND);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// The answer for all pieces of a base that is cut at its creases.
static kn_fold_global ask_pieces(kn_ctx *ctx, const kn_spline *s, int n, double w0, double w1)
{
    return ask_regions(ctx, s, n, NULL, 0, w0, w1, 100000).verdict;
}

static void patch(kn_ctx *ctx, kn_spline *out, const double *o, const double *a, const double *b)
{
    static const double k[4] = {0, 0, 1, 1};
    const double *knots[2] = {k, k};
    double coef[12];
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 4; i++) coef[4 * c + i] = o[c] + (i / 2) * a[c] + (i % 2) * b[c];
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[2]){1, 1}, (const int[2]){2, 2}, knots, coef),
                     KN_OK);
}

// Above a ridge shells part and have the edge alone in common; below they overlap, next to it already.
static void ridges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const double ku[5] = {0, 0, 1, 2, 2}, kv[4] = {0, 0, 1, 1}, *roof_knots[2] = {kv, ku};
    static const double roof_coef[18] = {-1, 0, 1, -1, 0, 1, 0, 0, 0, 2, 2, 2, 0, 1, 0, 0, 1, 0};
    kn_spline roof, *pieces, box[6];
    int counts[2];
    assert_int_equal(
        kn_spline_init(ctx, &roof, 2, 3, false, (const int[2]){1, 1}, (const int[2]){2, 3}, roof_knots, roof_coef),
        KN_OK);
    assert_int_equal(kn_shell_split_creases(ctx, &pieces, counts, &roof, 0.01), KN_OK);
    assert_int_equal(counts[0] * counts[1], 2);
    double n[3];
    kn_shell *shell;
    assert_int_equal(kn_shell_create(ctx, &shell, &pieces[0], NULL), KN_OK);
    assert_int_equal(kn_shell_unit_normal(ctx, n, shell, 0.5, 0.5), KN_OK);
    kn_shell_destroy(ctx, shell);
    double up = n[2] > 0.0 ? 1.0 : -1.0; // of the heights, so that they lie above the roof
    for (int i = 0; i < 3; i++) {
        double h = up * (i == 0 ? 0.01 : i == 1 ? 0.1 : 5.0);
        assert_int_equal(ask_pieces(ctx, pieces, 2, fmin(h, 0.0), fmax(h, 0.0)), KN_FOLD_NONE);
    }
    assert_int_equal(ask_pieces(ctx, pieces, 2, fmin(-0.1 * up, 0.0), fmax(-0.1 * up, 0.0)), KN_FOLD_FOUND);
    for (int i = 0; i < 2; i++) kn_spline_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    kn_spline_clear(ctx, &roof);

    // six faces, normals outwards: three shells meet in each corner
    const double o[3] = {0, 0, 0}, x[3] = {2, 0, 0}, y[3] = {0, 3, 0}, z[3] = {0, 0, 1};
    const double *side[6][3] = {{o, y, x}, {z, x, y}, {o, x, z}, {y, z, x}, {o, z, y}, {x, y, z}};
    for (int i = 0; i < 6; i++) patch(ctx, &box[i], side[i][0], side[i][1], side[i][2]);
    assert_int_equal(kn_shell_create(ctx, &shell, &box[0], NULL), KN_OK);
    assert_int_equal(kn_shell_unit_normal(ctx, n, shell, 0.5, 0.5), KN_OK);
    kn_shell_destroy(ctx, shell);
    up = n[2] < 0.0 ? 1.0 : -1.0; // the first face is the bottom
    assert_int_equal(ask_pieces(ctx, box, 6, fmin(0.3 * up, 0.0), fmax(0.3 * up, 0.0)), KN_FOLD_NONE);
    assert_int_equal(ask_pieces(ctx, box, 6, fmin(-0.3 * up, 0.0), fmax(-0.3 * up, 0.0)), KN_FOLD_FOUND);
    assert_int_equal(ask_pieces(ctx, box, 6, fmin(-0.002 * up, 0.0), fmax(-0.002 * up, 0.0)), KN_FOLD_FOUND);
    for (int i = 0; i < 6; i++) kn_spline_clear(ctx, &box[i]);
    test_ctx_end(ctx, &memory);
}

// A cone's apex is one place of the base; above it the shell opens, and below it runs into itself at once.
static void apices(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double base[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        const double axis[3] = {0, 0, i == 0 ? 2.0 : i == 1 ? 0.5 : 4.0};
        kn_spline s;
        kn_shell *shell;
        double n[3];
        assert_int_equal(kn_construct_cone(ctx, &s, base, axis, 1.0, 0.0), KN_OK);
        assert_int_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_OK);
        double lo[2], hi[2];
        for (int d = 0; d < 2; d++) kn_spline_domain(&s, d, &lo[d], &hi[d]);
        assert_int_equal(kn_shell_unit_normal(ctx, n, shell, lo[0], 0.5 * lo[1] + 0.5 * hi[1]), KN_OK);
        kn_shell_destroy(ctx, shell);
        double up = n[2] > 0.0 ? 1.0 : -1.0;
        static const double height[3] = {0.02, 0.2, 3.0};
        for (int k = 0; k < 3; k++)
            assert_int_equal(ask(ctx, &s, fmin(up * height[k], 0.0), fmax(up * height[k], 0.0)), KN_FOLD_NONE);
        assert_int_equal(ask(ctx, &s, fmin(-0.01 * up, 0.0), fmax(-0.01 * up, 0.0)), KN_FOLD_FOUND);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// The verdict and the work do not depend on the unit of length, and a thin shell is no harder than a thick one.
static void any_unit(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const double knots[8] = {0, 0, 0, 0, 1, 1, 1, 1}, *both[2] = {knots, knots};
    static const double cases[][2] = {
        {1, 0.1}, {1e-9, 0.1}, {1e9, 0.1}, {1, 1e-5}, {1, 1e-9}}; // unit, height in units
    size_t boxes = 0;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        double coef[48], unit = cases[k][0], w[2] = {0.0, cases[k][1] * unit};
        for (int i = 0; i < 16; i++) {
            coef[i] = i / 4 * unit;
            coef[16 + i] = i % 4 * unit;
            coef[32 + i] = 0.3 * ((i / 4 * 5 + i % 4 * 3) % 4) * unit;
        }
        kn_spline s;
        kn_shell *shell;
        kn_fold_intersection out;
        kn_shell_options o = {.normal_tol = 1e-4};
        assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[2]){3, 3}, (const int[2]){4, 4}, both, coef),
                         KN_OK);
        assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
        const kn_shell *one = shell;
        assert_int_equal(kn_fold_self_intersection(ctx, &out, &one, 1, NULL, 0, w, NULL), KN_OK);
        assert_int_equal(out.verdict, KN_FOLD_NONE);
        if (k == 0) boxes = out.boxes;
        assert_true(out.boxes <= 2 * boxes);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// A strip of half width b around a circle of radius 2 that makes half a turn: interpolated over three turns, of which
// the middle one is taken, so that the ends of the data are not felt at its own.
static void moebius(kn_ctx *ctx, kn_spline *out, double b)
{
    enum { TURN = 16, SITES = 3 * TURN + 1 };
    double site[SITES], across[2] = {-1.0, 1.0}, value[SITES][2][3], ku[SITES + 4];
    const double kv[4] = {-1, -1, 1, 1}, *knots[2] = {ku, kv}, *sites[2] = {site, across};
    for (int i = 0; i < SITES; i++) {
        double t = site[i] = 2.0 * PI * (i - TURN) / TURN;
        for (int j = 0; j < 2; j++) {
            double r = 2.0 + across[j] * b * cos(0.5 * t);
            value[i][j][0] = r * cos(t), value[i][j][1] = r * sin(t), value[i][j][2] = across[j] * b * sin(0.5 * t);
        }
    }
    for (int i = 0; i < SITES + 4; i++) ku[i] = site[i < 4 ? 0 : i >= SITES ? SITES - 1 : i - 2];
    assert_int_equal(kn_fit_interpolate(ctx, out, 2, 3, (const int[2]){3, 1}, (const int[2]){SITES, 2}, knots, sites,
                                        &value[0][0][0]),
                     KN_OK);
    const double lo[2] = {0.0, -1.0}, hi[2] = {2.0 * PI, 1.0};
    assert_int_equal(kn_spline_restrict(ctx, out, out, lo, hi), KN_OK);
}

static void one_sided_strip(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    moebius(ctx, &s, 0.3);
    assert_int_equal(ask(ctx, &s, 0.0, 0.1), KN_FOLD_NONE);
    assert_int_equal(ask(ctx, &s, -0.1, 0.1), KN_FOLD_NONE);
    assert_int_equal(ask(ctx, &s, -2.5, 2.5), KN_FOLD_FOUND); // across the hole in the middle
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void teapot(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s[TEAPOT_PATCHES];
    int n = 0;
    while (n < TEAPOT_PATCHES && make_teapot(ctx, &s[n], n)) n++;
    if (n < TEAPOT_PATCHES) skip();
    // the bottom, four patches around a pole: certified
    assert_int_equal(ask_regions(ctx, s + 28, 4, NULL, 0, 0.0, 0.02, 60000).verdict, KN_FOLD_NONE);
    // the handle (12 to 15) and the spout (16 to 19) run into the body (4 to 11), even the bases themselves
    kn_fold_intersection r = ask_regions(ctx, s + 4, 16, NULL, 0, 0.0, 0.01, 60000);
    assert_int_equal(r.verdict, KN_FOLD_FOUND);
    int low = r.a.shell < r.b.shell ? r.a.shell : r.b.shell, high = r.a.shell + r.b.shell - low;
    assert_true(low < 8 && high >= 8);
    for (int i = 0; i < n; i++) kn_spline_clear(ctx, &s[i]);
    test_ctx_end(ctx, &memory);
}

static void regions_count(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    u_bend(ctx, &s, 0.2);
    double side = side_of(ctx, &s), h[2] = {side > 0 ? 0.0 : -0.15, side > 0 ? 0.15 : 0.0};
    // one arm and its neighbourhood: four boxes that share faces, and one of them twice
    kn_fold_region r[5] = {{0, {0.0, 0.0, h[0]}, {0.5, 0.5, h[1]}},
                           {0, {0.5, 0.0, h[0]}, {1.0, 0.5, h[1]}},
                           {0, {0.0, 0.5, h[0]}, {0.5, 1.0, h[1]}},
                           {0, {0.5, 0.5, h[0]}, {1.0, 1.0, h[1]}},
                           {0, {0.25, 0.25, h[0]}, {0.75, 1.0, h[1]}}};
    assert_int_equal(ask_regions(ctx, &s, 1, r, 5, 0, 0, 20000).verdict, KN_FOLD_NONE);
    // the other arm across from the first box, and not across from it
    r[1] = (kn_fold_region){0, {0.0, 3.5, h[0]}, {0.5, 4.0, h[1]}};
    assert_int_equal(ask_regions(ctx, &s, 1, r, 2, 0, 0, 20000).verdict, KN_FOLD_FOUND);
    r[1] = (kn_fold_region){0, {0.0, 3.0, h[0]}, {1.0, 3.45, h[1]}};
    assert_int_equal(ask_regions(ctx, &s, 1, r, 2, 0, 0, 20000).verdict, KN_FOLD_NONE);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// ---- random sheets ----

enum { SAMPLES = 160 };

// A planar curve at samples: points and unit normals to the left.
typedef struct profile {
    double p[SAMPLES][2], n[SAMPLES][2];
} profile;

static void sample(kn_ctx *ctx, profile *out, const kn_spline *curve)
{
    for (int i = 0; i < SAMPLES; i++) {
        double t = (double)i / (SAMPLES - 1), d[6];
        assert_int_equal(kn_spline_derivatives(ctx, d, curve, &t, 1), KN_OK);
        double l = hypot(d[2], d[3]);
        out->p[i][0] = d[0], out->p[i][1] = d[1], out->n[i][0] = -d[3] / l, out->n[i][1] = d[2] / l;
    }
}

// Whether the normals of two samples cross at heights in [0,h].
static bool cross(const profile *f, int i, int j, double h)
{
    double dx = f->p[j][0] - f->p[i][0], dy = f->p[j][1] - f->p[i][1],
           det = f->n[i][1] * f->n[j][0] - f->n[i][0] * f->n[j][1];
    if (dx * dx + dy * dy > 4.0 * h * h || det == 0.0) return false;
    double a = (dy * f->n[j][0] - dx * f->n[j][1]) / det, b = (f->n[i][0] * dy - f->n[i][1] * dx) / det;
    return a >= 0.0 && a <= h && b >= 0.0 && b <= h;
}

static bool meets_itself(const profile *f, double h)
{
    for (int i = 0; i < SAMPLES; i++)
        for (int j = i + 1; j < SAMPLES; j++)
            if (cross(f, i, j, h)) return true;
    return false;
}

// Whether the polyline of samples crosses itself.
static bool base_crosses(const profile *f)
{
    for (int i = 0; i + 1 < SAMPLES; i++)
        for (int j = i + 2; j + 1 < SAMPLES; j++) {
            const double *a = f->p[i], *b = f->p[i + 1], *c = f->p[j], *d = f->p[j + 1];
            double s = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            double t = (b[0] - a[0]) * (d[1] - a[1]) - (b[1] - a[1]) * (d[0] - a[0]);
            double u = (d[0] - c[0]) * (a[1] - c[1]) - (d[1] - c[1]) * (a[0] - c[0]);
            double v = (d[0] - c[0]) * (b[1] - c[1]) - (d[1] - c[1]) * (b[0] - c[0]);
            if (s * t <= 0.0 && u * v <= 0.0) return true;
        }
    return false;
}

// The height at which normals begin to cross, at most 2; 0 where the base crosses itself.
static double critical(const profile *f)
{
    double lo = 0.0, hi = 2.0;
    if (base_crosses(f)) return 0.0;
    if (!meets_itself(f, hi)) return hi;
    for (int i = 0; i < 20; i++) {
        double mid = 0.5 * (lo + hi);
        if (meets_itself(f, mid))
            hi = mid;
        else
            lo = mid;
    }
    return hi;
}

static void random_curve(kn_ctx *ctx, kn_spline *out, test_rng *rng)
{
    int n = test_int(rng, 4, 7);
    double knots[16], coef[2 * 8];
    const double *all[1] = {knots};
    for (int i = 0; i < n + 4; i++) knots[i] = i < 4 ? 0.0 : i >= n ? 1.0 : (double)(i - 3) / (n - 3);
    for (int i = 0; i < n; i++)
        coef[i] = 0.6 * i + test_uniform(rng, -0.7, 0.7), coef[n + i] = test_uniform(rng, -1.0, 1.0);
    assert_int_equal(kn_spline_init(ctx, out, 1, 2, false, (const int[1]){3}, &n, all, coef), KN_OK);
}

// The sheet over the curve, in (x, y) from z = 0 to z = 1, or turned about the line x = -3, z = 0 by a quarter.
static void make_sheet(kn_ctx *ctx, kn_spline *out, const kn_spline *curve, bool turned)
{
    static const double to_space[6] = {1, 0, 0, 1, 0, 0}, up[3] = {0, 0, 1}, axis[3] = {0, 1, 0},
                        origin[3] = {-3, 0, 0};
    kn_spline c = {0};
    assert_int_equal(kn_spline_affine(ctx, &c, curve, 3, to_space, NULL), KN_OK);
    kn_status status = turned ? kn_construct_revolved(ctx, out, &c, origin, axis, 0.5 * PI)
                              : kn_construct_extruded(ctx, out, &c, up);
    assert_int_equal(status, KN_OK);
    kn_spline_clear(ctx, &c);
}

static void random_sheets(void **state)
{
    (void)state;
    test_rng rng = test_random(77);
    static const double factor[5] = {0.5, 0.9, 0.97, 1.03, 1.2};
    int count[3] = {0}, wrong = 0, total = test_scale(200);
    for (int k = 0; k < total; k++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        kn_spline curve = {0}, s = {0};
        profile f;
        kn_shell *shell = NULL;
        random_curve(ctx, &curve, &rng);
        make_sheet(ctx, &s, &curve, k % 4 == 3);
        sample(ctx, &f, &curve);
        // beyond 2 nothing is known of where normals cross
        // a cusp between two samples is not seen: below 0.02 there is a crossing, and no more is known
        double least = critical(&f), h = least >= 2.0 ? 1.8 : least > 0.02 ? least * factor[k % 5] : 0.05, n[3];
        double w[2] = {0.0, h};
        bool crosses = h > least;
        // a coarse normal: it moves crossings by about 1e-3 of the height
        const kn_shell_options coarse = {.normal_tol = 1e-3};
        const kn_fold_options options = {.work = 700};
        if (kn_shell_create(ctx, &shell, &s, &coarse) == KN_OK) {
            const kn_shell *list = shell;
            kn_fold_intersection r;
            assert_int_equal(kn_shell_unit_normal(ctx, n, shell, 0.0, 0.0), KN_OK);
            if (n[0] * f.n[0][0] + n[1] * f.n[0][1] < 0.0) w[0] = -h, w[1] = 0.0;
            assert_int_equal(kn_fold_self_intersection(ctx, &r, &list, 1, NULL, 0, w, &options), KN_OK);
            count[r.verdict]++;
            if (r.verdict == (crosses ? KN_FOLD_NONE : KN_FOLD_FOUND)) wrong++;
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &curve);
        kn_spline_clear(ctx, &s);
        test_ctx_end(ctx, &memory);
    }
    print_message("# random sheets: %d injective, %d not, %d undecided, %d wrong\n", count[0], count[1], count[2],
                  wrong);
    assert_int_equal(wrong, 0);
    assert_true(count[0] > total / 4 && count[1] > total / 8);
}

// ---- refusals ----

static void refuses(kn_ctx *ctx, const kn_shell *const *shells, int n, const kn_fold_region *r, size_t nr,
                    const double *w, const kn_fold_options *o, const char *says)
{
    kn_fold_intersection out = {.boxes = 12345};
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_fold_self_intersection(ctx, &out, shells, n, r, nr, w, o), KN_EDOMAIN);
    if (!strstr(kn_ctx_message(ctx), says)) fail_msg("\"%s\" without \"%s\"", kn_ctx_message(ctx), says);
    assert_true(out.boxes == 12345);
}

static void bad_arguments(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    kn_shell *shell;
    make_plane(ctx, &s);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_OK);
    const kn_shell *list = shell;
    const double w[2] = {0, 1}, none[2] = {1, 1}, nan[2] = {0, NAN};
    const kn_fold_options coarse = {.size = 0.5}, negative = {.size = -1.0};
    const kn_fold_region other = {1, {0, 0, 0}, {1, 1, 1}}, empty = {0, {0, 0.5, 0}, {1, 0.5, 1}},
                         outside = {0, {0, 0, 0}, {1, 2, 1}};
    refuses(ctx, &list, 0, NULL, 0, w, NULL, "0 shells");
    refuses(ctx, &list, 1, NULL, 0, NULL, NULL, "1 shells");
    refuses(ctx, &list, 1, &other, 0, w, NULL, "0 regions");
    refuses(ctx, &list, 1, NULL, 0, none, NULL, "variable 2");
    refuses(ctx, &list, 1, NULL, 0, nan, NULL, "variable 2");
    refuses(ctx, &list, 1, NULL, 0, w, &coarse, "size");
    refuses(ctx, &list, 1, NULL, 0, w, &negative, "size");
    refuses(ctx, &list, 1, &other, 1, w, NULL, "shell 1 of 1");
    refuses(ctx, &list, 1, &empty, 1, w, NULL, "variable 1");
    refuses(ctx, &list, 1, &outside, 1, w, NULL, "variable 1");
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static int stop(void *user, const char *stage, double fraction)
{
    (void)fraction;
    *(int *)user += strcmp(stage, "self-intersection") == 0;
    return *(int *)user > 0;
}

static void gives_up_and_stops(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1), *stopping;
    kn_spline s;
    int called = 0;
    u_bend(ctx, &s, 0.2);
    double side = side_of(ctx, &s), w[2] = {side > 0 ? 0.0 : -0.0999, side > 0 ? 0.0999 : 0.0};
    kn_fold_intersection r = ask_regions(ctx, &s, 1, NULL, 0, w[0], w[1], 40), again;
    assert_int_equal(r.verdict, KN_FOLD_OPEN);
    assert_true(r.a.shell == 0 && r.b.shell == 0 && r.a.lo[1] < r.a.hi[1] && r.b.lo[2] >= w[0] && r.b.hi[2] <= w[1]);
    again = ask_regions(ctx, &s, 1, NULL, 0, w[0], w[1], 40);
    assert_true(again.boxes == r.boxes && again.undecided == r.undecided && again.a.lo[0] == r.a.lo[0]);
    kn_spline_clear(ctx, &s);

    const kn_ctx_options options = {
        .allocator = test_allocator(&memory), .progress = stop, .user = &called, .threads = 1};
    assert_int_equal(kn_ctx_create(&stopping, &options), KN_OK);
    kn_shell *shell;
    make_plane(stopping, &s);
    assert_int_equal(kn_shell_create(stopping, &shell, &s, NULL), KN_OK);
    const kn_shell *list = shell;
    assert_int_equal(kn_fold_self_intersection(stopping, &r, &list, 1, NULL, 0, (const double[2]){0, 1}, NULL),
                     KN_ECANCELLED);
    assert_true(called > 0 && r.boxes == again.boxes);
    kn_shell_destroy(stopping, shell);
    kn_spline_clear(stopping, &s);
    kn_ctx_destroy(stopping);
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    (void)user;
    static const double k[4] = {0, 0, 1, 1}, coef[12] = {0, 0, 2, 2, 0, 3, 0, 3, 1, 1, 1, 1.5};
    const double *knots[2] = {k, k}, w[2] = {0, 0.1};
    kn_spline s = {0};
    kn_shell *shell = NULL;
    kn_fold_intersection r = {.boxes = 12345};
    const kn_shell_options coarse = {.normal_tol = 0.1};
    kn_status status = kn_spline_init(ctx, &s, 2, 3, false, (const int[2]){1, 1}, (const int[2]){2, 2}, knots, coef);
    if (status == KN_OK) status = kn_shell_create(ctx, &shell, &s, &coarse);
    const kn_shell *list = shell;
    if (status == KN_OK) status = kn_fold_self_intersection(ctx, &r, &list, 1, NULL, 0, w, NULL);
    if (status == KN_OK)
        assert_int_equal(r.verdict, KN_FOLD_NONE);
    else
        assert_true(r.boxes == 12345);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_allocation_failures(call, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bent_sheets),
        cmocka_unit_test(closed_forms),
        cmocka_unit_test(round_bodies),
        cmocka_unit_test(one_sided_strip),
        cmocka_unit_test(ridges),
        cmocka_unit_test(apices),
        cmocka_unit_test(any_unit),
        cmocka_unit_test(teapot),
        cmocka_unit_test(regions_count),
        cmocka_unit_test(random_sheets),
        cmocka_unit_test(bad_arguments),
        cmocka_unit_test(gives_up_and_stops),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("fold/self_intersection", tests, NULL, NULL);
}
