// SPDX-License-Identifier: Apache-2.0
// Surfaces far from the origin, as parts lie in assemblies: normals, poles, seams and Jacobians do not depend on
// where a surface lies, but for the rounding that its coordinates carry.
#include "tests/support/surfaces.h"

#include <knurl/fold.h>

#include <math.h>
#include <stdio.h>

static const kn_normal_method methods[2] = {KN_NORMAL_FITTED, KN_NORMAL_EXACT_DIRECTION};

typedef struct solid {
    const char *name;
    void (*make)(kn_ctx *ctx, kn_spline *out);
    double radius;
    bool closed[2], poles; // poles: at both ends of v
    double (*outside)(const double p[3]);
} solid;

static double from_sphere(const double p[3])
{
    return hypot(hypot(p[0], p[1]), p[2]) - 2.0;
}

static double from_torus(const double p[3])
{
    return hypot(hypot(p[0], p[1]) - 3.0, p[2]) - 1.0;
}

static double from_cylinder(const double p[3])
{
    return hypot(p[0], p[1]) - 1.0;
}

static const solid solids[] = {
    {"sphere", make_sphere, 2.0, {true, false}, true, from_sphere},
    {"torus", make_torus, 1.0, {true, true}, false, from_torus},
    {"cylinder", make_cylinder, 1.0, {true, false}, false, from_cylinder},
};

typedef struct motion {
    double distance, scale;
    bool turned;
} motion;

static const motion motions[] = {
    {3700, 1, false},  {1e4, 1, true}, {1e6, 1, true},   {0, 1e-6, true},
    {1e4, 1e-6, true}, {0, 1e6, true}, {1e4, 1e6, true},
};

// p -> scale (R p + distance d), R a rotation by an angle of no special value about (1, 2, 2) / 3.
static void place(double matrix[9], double offset[3], const motion *m)
{
    const double axis[3] = {1.0 / 3, 2.0 / 3, 2.0 / 3},
                 way[3] = {m->turned ? 0.6 : 1.0, m->turned ? -0.48 : 0.0, m->turned ? 0.64 : 0.0};
    double c = cos(m->turned ? 0.7 : 0.0), s = sin(m->turned ? 0.7 : 0.0);
    for (int i = 0; i < 3; i++) {
        offset[i] = m->scale * m->distance * way[i];
        for (int j = 0; j < 3; j++) {
            double skew = i == j ? 0.0 : (j - i + 3) % 3 == 1 ? -axis[3 - i - j] : axis[3 - i - j];
            matrix[3 * i + j] = m->scale * ((i == j ? c : 0.0) + (1.0 - c) * axis[i] * axis[j] + s * skew);
        }
    }
}

// Where p was before: the transposed rotation.
static void back(double q[3], const double p[3], const double matrix[9], const double offset[3], double scale)
{
    for (int j = 0; j < 3; j++) {
        q[j] = 0.0;
        for (int i = 0; i < 3; i++) q[j] += matrix[3 * i + j] / scale * ((p[i] - offset[i]) / scale);
    }
}

static void check_shape(const solid *b, const kn_shell *shell, const char *where)
{
    bool closed[2];
    kn_shell_edge edge[2][2];
    kn_shell_closed(shell, closed);
    kn_shell_edges(shell, edge);
    for (int v = 0; v < 2; v++) {
        if (closed[v] != b->closed[v])
            fail_msg("%s, %s: variable %d is %sclosed", b->name, where, v, closed[v] ? "" : "not ");
        for (int e = 0; e < 2; e++) {
            bool pole = b->poles && v == 1;
            if (edge[v][e].kind != (pole ? KN_EDGE_POLE : KN_EDGE_CURVE) || edge[v][e].order != pole)
                fail_msg("%s, %s: edge %d of variable %d has kind %d and order %d", b->name, where, e, v,
                         (int)edge[v][e].kind, edge[v][e].order);
        }
    }
}

// One vector at a pole, bit for bit.
static void check_pole(const solid *b, const kn_shell *shell, const char *where)
{
    const kn_spline *n = kn_shell_normal(shell);
    size_t count = kn_spline_count(n), columns = (size_t)n->count[1];
    for (size_t k = 0; k < 3 * (size_t)n->count[0] && b->poles; k++)
        for (size_t end = 0; end < columns; end += columns - 1) {
            const double *c = n->coef + k / (size_t)n->count[0] * count + end;
            if (c[k % (size_t)n->count[0] * columns] != c[0])
                fail_msg("%s, %s: n differs along a pole", b->name, where);
        }
}

// |n - N/|N|| is at most the length error and the angle error together. Control points are within 8 units of their
// largest coordinate of where they belong, which turns the normal by at most 2 degree control points / |S_u| and
// moves T at |w| <= radius / 2 by some ten times as much; values of S and n take 2 (6 * 11 + 1) roundings: 300 units
// in all.
static void check_offset(kn_ctx *ctx, const solid *b, const kn_shell *shell, const motion *m, const char *where)
{
    kn_normal_certificate c = kn_shell_certificate(shell);
    double matrix[9], offset[3], lo[2], hi[2], p[3], q[3], units = 300.0 * 0x1p-53 * (m->distance + 4.0),
                                                           outward = 0.0;
    place(matrix, offset, m);
    for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(shell), v, &lo[v], &hi[v]);
    for (int i = 0; i <= 12; i++)
        for (int j = 0; j <= 12; j++)
            for (int k = -2; k <= 2; k++) {
                double u = lo[0] + (hi[0] - lo[0]) * i / 12, v = lo[1] + (hi[1] - lo[1]) * j / 12;
                double w = b->radius * k / 4;
                assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, u, v, w * m->scale), KN_OK);
                back(q, p, matrix, offset, m->scale);
                if (outward == 0.0) outward = b->outside(q) > 0.0 ? -1.0 : 1.0; // at the first, w < 0
                double off = b->outside(q) - outward * w, most = fabs(w) * (c.length_error + c.angle_error) + units;
                if (!(fabs(off) <= most))
                    fail_msg("%s, %s: T(%g, %g, %g) is off by %g, above %g", b->name, where, u, v, w, off, most);
            }
}

static void check_fold(kn_ctx *ctx, const solid *b, const kn_shell *shell, const motion *m, const char *where)
{
    kn_fold_sign sign;
    double lo[3], hi[3];
    for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(shell), v, &lo[v], &hi[v]);
    lo[2] = -0.5 * b->radius * m->scale, hi[2] = 0.5 * b->radius * m->scale;
    if (kn_fold_jacobian_sign(ctx, &sign, shell, lo, hi) != KN_OK) fail_msg("%s: %s", where, kn_ctx_message(ctx));
    if (sign.verdict != KN_FOLD_POSITIVE)
        fail_msg("%s, %s: verdict %d, J from %g to %g, least %g at (%g, %g, %g)", b->name, where, (int)sign.verdict,
                 sign.lo, sign.hi, sign.value, sign.where[0], sign.where[1], sign.where[2]);
}

static void solids_far_away(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t k = 0; k < sizeof solids / sizeof *solids; k++)
        for (size_t i = 0; i < sizeof motions / sizeof *motions; i++) {
            const motion *m = &motions[i];
            kn_spline s;
            double matrix[9], offset[3];
            char where[64];
            (void)snprintf(where, sizeof where, "%g away, %g times as large", m->distance, m->scale);
            solids[k].make(ctx, &s);
            place(matrix, offset, m);
            assert_int_equal(kn_spline_affine(ctx, &s, &s, 3, matrix, offset), KN_OK);
            for (int method = 0; method < (i == 1 || i == 2 ? 2 : 1); method++) {
                kn_shell_options o = {.normal = methods[method], .normal_tol = 1e-6, .max_degree = 5};
                kn_shell *shell = NULL;
                if (kn_shell_create(ctx, &shell, &s, &o) != KN_OK)
                    fail_msg("%s, %s: %s", solids[k].name, where, kn_ctx_message(ctx));
                check_shape(&solids[k], shell, where);
                if (method == 0) check_pole(&solids[k], shell, where);
                check_offset(ctx, &solids[k], shell, m, where);
                if (method == 0 && i % 2 == 0) check_fold(ctx, &solids[k], shell, m, where);
                kn_shell_destroy(ctx, shell);
            }
            kn_spline_clear(ctx, &s);
        }
    test_ctx_end(ctx, &memory);
}

// The certificate is of the patch as it is given, rounded coordinates and all. Where it has a pole, it is of the
// patch whose edge has collapsed exactly, which direct evaluation does not see.
static void check_teapot(kn_ctx *ctx, const kn_spline *s, double distance, int patch)
{
    kn_shell *shell = NULL;
    kn_shell_edge edge[2][2];
    if (kn_shell_create(ctx, &shell, s, NULL) != KN_OK)
        fail_msg("patch %d, %g away: %s", patch, distance, kn_ctx_message(ctx));
    kn_normal_certificate c = kn_shell_certificate(shell);
    assert_true(c.certified && c.length_error <= 1e-6 && c.angle_error <= 1e-6);
    kn_shell_edges(shell, edge);
    bool collapsed = false;
    for (int e = 0; e < 4; e++) collapsed = collapsed || edge[e / 2][e % 2].kind != KN_EDGE_CURVE;
    // the lid's knob and the middle of the bottom
    assert_int_equal(collapsed, (patch >= 20 && patch < 24) || patch >= 28);
    for (int i = 0; i <= 8 && !collapsed; i++)
        for (int j = 0; j <= 8; j++) {
            long double length, angle;
            if (!direct_errors(&length, &angle, shell, i / 8.0L, j / 8.0L)) continue;
            if (!(length <= (long double)c.length_error && angle <= (long double)c.angle_error))
                fail_msg("patch %d, %g away: errors %Lg, %Lg above %g, %g", patch, distance, length, angle,
                         c.length_error, c.angle_error);
        }
    kn_shell_destroy(ctx, shell);
}

static void teapot_far_away(void **state)
{
    (void)state;
    static const double one[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (double distance = 1e4; distance < 2e6; distance *= 100.0)
        for (int patch = 0; patch<TEAPOT_PATCHES; patch += test_scale(1)> 1 ? 1 : 3) {
            const double offset[3] = {distance, -0.3 * distance, 0.7 * distance};
            kn_spline s;
            assert_true(make_teapot(ctx, &s, patch));
            assert_int_equal(kn_spline_affine(ctx, &s, &s, 3, one, offset), KN_OK);
            check_teapot(ctx, &s, distance, patch);
            kn_spline_clear(ctx, &s);
        }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(solids_far_away), cmocka_unit_test(teapot_far_away)};
    return cmocka_run_group_tests_name("trivar/far", tests, NULL, NULL);
}
