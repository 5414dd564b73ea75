// SPDX-License-Identifier: Apache-2.0
// Normals through T against the tangents of composed patches, and the estimate where it is exact.
#include "tests/support/kinds.h"

#include <knurl/compose.h>

#include <math.h>

static kn_shell *shell_of(kn_ctx *ctx, const kn_spline *s, const kn_shell_options *o)
{
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

static void cross(long double out[3], const long double a[3], const long double b[3])
{
    for (int c = 0; c < 3; c++) out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static long double angle(const double a[3], const long double b[3])
{
    long double x[3], s = 0.0L, d = 0.0L;
    const long double la[3] = {a[0], a[1], a[2]};
    cross(x, la, b);
    for (int c = 0; c < 3; c++) s += x[c] * x[c], d += la[c] * b[c];
    return atan2l(sqrtl(s), d);
}

// Two random tangents a, b in texture space have the normal a x b; their images J a, J b the normal J a x J b, on the
// same side where det J > 0. J in long double.
static void against_tangents(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(61);
    for (int k = 0; k < 2 * SURFACE_CASES; k++) {
        kn_spline s, h, psi;
        surface_cases[k / 2].make(ctx, &s);
        make_field(ctx, &h, &rng, &s, 2, 1, 1.0, 0.2);
        make_field(ctx, &psi, &rng, &s, 2, 3, 0.0, 0.3);
        kn_shell_options o = {0};
        if (k % 2) o.thickness = &h, o.attraction = &psi, o.attraction_power = 3;
        o.normal_tol = 1e-4;
        kn_shell *shell = shell_of(ctx, &s, &o);
        double lo[2], hi[2];
        for (int v = 0; v < 2; v++) kn_spline_domain(&s, v, &lo[v], &hi[v]);
        for (int i = 0; i < test_scale(100); i++) {
            double at[3] = {test_uniform(&rng, lo[0], hi[0]), test_uniform(&rng, lo[1], hi[1]),
                            test_uniform(&rng, -0.3, 0.3)};
            long double t[3], j[9], a[3], b[3], ja[3], jb[3], n[3], image[3], size = 1.0L;
            long double longest = 0.0L, shortest = 1e9L;
            double normal[3], out[3];
            direct_kind(t, j, shell, &o, at[0], at[1], at[2]);
            for (int c = 0; c < 3; c++) a[c] = test_uniform(&rng, -1, 1), b[c] = test_uniform(&rng, -1, 1);
            for (int c = 0; c < 3; c++) {
                ja[c] = j[3 * c] * a[0] + j[3 * c + 1] * a[1] + j[3 * c + 2] * a[2];
                jb[c] = j[3 * c] * b[0] + j[3 * c + 1] * b[1] + j[3 * c + 2] * b[2];
            }
            cross(n, a, b);
            cross(image, ja, jb);
            for (int d = 0; d < 3; d++) {
                long double length = sqrtl(j[d] * j[d] + j[3 + d] * j[3 + d] + j[6 + d] * j[6 + d]);
                size *= length;
                longest = fmaxl(longest, length), shortest = fminl(shortest, length);
            }
            long double full = j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
                               j[2] * (j[3] * j[7] - j[4] * j[6]);
            for (int c = 0; c < 3; c++) normal[c] = (double)n[c], image[c] *= full > 0.0L ? 1.0L : -1.0L;
            if (fabsl(full) < 1e-6L * size) continue;
            assert_int_equal(kn_shell_map_normal(ctx, out, shell, at, normal), KN_OK);
            // J is known to 1e-12 of its columns (tests of kn_shell_eval), a x b was rounded; the condition of J
            long double turn = angle(out, image), bound = 1e-11L * size / fabsl(full) * longest / shortest;
            if (!(turn < bound)) fail_msg("%s: off by %Lg, bound %Lg", surface_cases[k / 2].name, turn, bound);
            assert_true(fabs(out[0] * out[0] + out[1] * out[1] + out[2] * out[2] - 1.0) < 1e-15 * 8);
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &h);
        kn_spline_clear(ctx, &psi);
    }
    test_ctx_end(ctx, &memory);
}

// A tile patch composed with a piece of T, its partial derivatives, and the tile's own normal sent through T.
static void against_composed_patch(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(62);
    kn_spline s;
    make_torus(ctx, &s);
    kn_shell *shell = shell_of(ctx, &s, NULL);
    const int cell[2] = {0, 2}, degree[2] = {2, 2};
    const double lo[2] = {0.0, 0.0}, hi[2] = {0.0625, 0.0625}; // inside one knot interval of n
    kn_shell_piece piece;
    bool fits = false;
    assert_int_equal(kn_shell_piece_init(ctx, &piece, &fits, shell, cell, lo, hi, 0), KN_OK);
    assert_true(fits && piece.exact);
    kn_bezier tile = {0}, patch = {0};
    assert_int_equal(kn_bezier_init(ctx, &tile, 2, 3, false, degree), KN_OK);
    for (int i = 0; i < 9; i++) {
        tile.coef[i] = 0.1 + 0.4 * (i / 3) + test_uniform(&rng, -0.05, 0.05);
        tile.coef[9 + i] = 0.1 + 0.4 * (i % 3) + test_uniform(&rng, -0.05, 0.05);
        tile.coef[18 + i] = test_uniform(&rng, -0.2, 0.2);
    }
    assert_int_equal(kn_compose_piece(ctx, &patch, &piece, &tile), KN_OK);
    for (int i = 0; i < test_scale(50); i++) {
        double at[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, d[9], image[9], uvw[3], n[3], out[3];
        assert_int_equal(kn_bezier_derivatives(ctx, d, &tile, at, 1), KN_OK);
        assert_int_equal(kn_bezier_derivatives(ctx, image, &patch, at, 1), KN_OK);
        // the box is 1/16 wide: the tile's tangents there
        for (int v = 0; v < 2; v++) {
            uvw[v] = cell[v] + 0.0625 * d[v];
            for (int k = 1; k < 3; k++) d[3 * k + v] *= 0.0625;
        }
        uvw[2] = d[2];
        for (int c = 0; c < 3; c++) {
            int a = (c + 1) % 3, b = (c + 2) % 3;
            n[c] = d[3 + a] * d[6 + b] - d[3 + b] * d[6 + a];
        }
        long double x[3], a[3] = {image[3], image[4], image[5]}, b[3] = {image[6], image[7], image[8]};
        cross(x, a, b);
        assert_int_equal(kn_shell_map_normal(ctx, out, shell, uvw, n), KN_OK);
        assert_true(angle(out, x) < 1e-10L); // composition and derivatives: some 1e-14, tangents 1/100 long
    }
    kn_bezier_clear(ctx, &tile);
    kn_bezier_clear(ctx, &patch);
    kn_shell_piece_clear(ctx, &piece);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// The plane of test surfaces has S_u = (2,0,0), S_v = (0,3,0). Scaled to unit length both are orthonormal with n, and
// T is a rigid motion: exact and estimate are the normal itself, at any height.
static void orthonormal(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(63);
    kn_spline s;
    make_plane(ctx, &s);
    kn_shell *uneven = shell_of(ctx, &s, NULL);
    assert_int_equal(kn_spline_reparameterize(ctx, &s, &s, 0, 0.0, 2.0), KN_OK);
    assert_int_equal(kn_spline_reparameterize(ctx, &s, &s, 1, 0.0, 3.0), KN_OK);
    kn_shell *shell = shell_of(ctx, &s, NULL);
    for (int i = 0; i < 50; i++) {
        double at[3] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1), test_uniform(&rng, -1, 1)}, n[3], a[3],
               b[3];
        for (int c = 0; c < 3; c++) n[c] = test_uniform(&rng, -1, 1);
        assert_int_equal(kn_shell_map_normal(ctx, a, shell, at, n), KN_OK);
        assert_int_equal(kn_shell_map_normal_estimate(ctx, b, shell, at, n), KN_OK);
        const long double want[3] = {n[0], n[1], n[2]};
        assert_true(angle(a, want) < 1e-13L && angle(b, want) < 1e-13L);
        // and where it is not: exact N_u / 2, N_v / 3, N_w, estimate 2 N_u, 3 N_v, N_w
        assert_int_equal(kn_shell_map_normal(ctx, a, uneven, at, n), KN_OK);
        assert_int_equal(kn_shell_map_normal_estimate(ctx, b, uneven, at, n), KN_OK);
        const long double exact[3] = {n[0] / 2.0L, n[1] / 3.0L, n[2]}, rough[3] = {2.0L * n[0], 3.0L * n[1], n[2]};
        assert_true(angle(a, exact) < 1e-13L && angle(b, rough) < 1e-13L);
    }
    kn_shell_destroy(ctx, shell);
    kn_shell_destroy(ctx, uneven);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// At a pole: what the normal tends to along the line u = const, seen from 1e-6 and 1e-7 beside it.
static void poles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(64);
    kn_spline s, h;
    make_sphere(ctx, &s);
    make_field(ctx, &h, &rng, &s, 2, 1, 1.0, 0.2);
    for (int k = 0; k < 2; k++) {
        kn_shell *shell = shell_of(ctx, &s, k ? &(kn_shell_options){.thickness = &h} : NULL);
        for (int i = 0; i < 40; i++) {
            double end = i % 2 ? 2.0 : 0.0, u = test_uniform(&rng, 0, 4), w = k ? 0.0 : test_uniform(&rng, -0.5, 0.5);
            double at[3] = {u, end, w}, n[3], limit[3], near[3];
            for (int c = 0; c < 3; c++) n[c] = test_uniform(&rng, -1, 1);
            if (i % 4 < 2) n[0] = 0.0;
            assert_int_equal(kn_shell_map_normal(ctx, limit, shell, at, n), KN_OK);
            for (double far = 1e-6; far > 1e-8; far *= 0.1) {
                at[1] = fabs(end - far);
                assert_int_equal(kn_shell_map_normal(ctx, near, shell, at, n), KN_OK);
                // T_u is far times some number below 10, against |N_u| above 1e-3 (or 0); curvature the same
                double reach = 100.0 * far / (n[0] == 0.0 ? 1.0 : fmin(fabs(n[0]), 1.0));
                assert_true(test_max_difference(limit, near, 3) < reach + 1e-8);
            }
        }
        kn_shell_destroy(ctx, shell);
    }
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &h);
    test_ctx_end(ctx, &memory);
}

// On a cylinder of radius 1 T folds at w = -1, and beyond det J < 0: normals stay on their side of the geometry.
static void beyond_the_fold(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_cylinder(ctx, &s);
    kn_shell *shell = shell_of(ctx, &s, NULL);
    const double along[3] = {0, 0, 1}, around[3] = {1, 0, 0};
    double a[3], b[3]; // n_u is known to 1e-6 over a knot interval of n, some 1e-5; T_u is half as long as S_u
    for (int i = 0; i < 2; i++) {
        const double at[3] = {0.0, 1.0, i ? -1.5 : -0.5};
        assert_int_equal(kn_shell_map_normal(ctx, a, shell, at, along), KN_OK); // to more w is to more x
        assert_true(fabs(a[0] - 1.0) < 1e-4 && fabs(a[1]) < 1e-4);
        assert_int_equal(kn_shell_map_normal(ctx, b, shell, at, around), KN_OK); // to more u turns over
        assert_true(fabs(b[1] - (i ? -1.0 : 1.0)) < 1e-4);
    }
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int one[3] = {1, 1, 1}, count[3] = {2, 2, 2};
    const double k[4] = {0, 0, 1, 1}, *knots[3] = {k, k, k};
    double coef[24] = {0}, out[3] = {7, 8, 9};
    for (int i = 0; i < 8; i++) coef[i] = i / 4, coef[8 + i] = i / 2 % 2, coef[16 + i] = i / 2 % 2;
    kn_spline volume; // (u, v, v): flat
    kn_shell *shell = NULL;
    assert_int_equal(kn_spline_init(ctx, &volume, 3, 3, false, one, count, knots, coef), KN_OK);
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &volume, NULL), KN_OK);
    const double at[3] = {0.5, 0.5, 0.5}, up[3] = {0, 0, 1}, none[3] = {0}, bad[3] = {NAN, 0, 0};
    assert_int_equal(kn_shell_map_normal(ctx, out, shell, at, up), KN_EUNDEFINED);
    assert_int_equal(kn_shell_map_normal(ctx, out, shell, at, none), KN_EDOMAIN);
    assert_int_equal(kn_shell_map_normal(ctx, out, shell, at, bad), KN_EDOMAIN);
    assert_int_equal(kn_shell_map_normal(ctx, out, shell, bad, up), KN_EDOMAIN);
    assert_int_equal(kn_shell_map_normal_estimate(ctx, out, shell, at, up), KN_EUNDEFINED);
    assert_int_equal(kn_shell_map_normal_estimate(ctx, out, shell, at, bad), KN_EDOMAIN);
    assert_int_equal(kn_shell_map_normal_estimate(ctx, out, shell, bad, up), KN_EDOMAIN);
    const double high[3] = {0.5, 0.5, INFINITY};
    assert_int_equal(kn_shell_map_normal_estimate(ctx, out, shell, high, up), KN_EDOMAIN);
    assert_true(out[0] == 7 && out[1] == 8 && out[2] == 9);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &volume);
    test_ctx_end(ctx, &memory);
}

static kn_status map_at_pole(kn_ctx *ctx, void *user)
{
    const double at[3] = {0.3, 0.0, 0.1}, n[3] = {0.0, 0.5, 1.0};
    double out[3] = {7, 8, 9};
    kn_status status = kn_shell_map_normal(ctx, out, user, at, n);
    if (status == KN_OK) status = kn_shell_map_normal_estimate(ctx, out, user, at, n);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_sphere(ctx, &s);
    kn_shell *shell = shell_of(ctx, &s, NULL);
    test_allocation_failures(map_at_pole, shell);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(against_tangents),    cmocka_unit_test(against_composed_patch),
        cmocka_unit_test(orthonormal),         cmocka_unit_test(poles),
        cmocka_unit_test(beyond_the_fold),     cmocka_unit_test(failures),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("trivar/map_normal", tests, NULL, NULL);
}
