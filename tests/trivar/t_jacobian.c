// SPDX-License-Identifier: Apache-2.0
// The Jacobian's coefficients over boxes and as splines, against determinants in long double.
#include "tests/support/kinds.h"

#include <knurl/construct.h>

#include <math.h>
#include <string.h>

static kn_shell *create(kn_ctx *ctx, const kn_spline *s, const kn_shell_options *o)
{
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

static long double determinant(const long double j[9])
{
    return j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
           j[2] * (j[3] * j[7] - j[4] * j[6]);
}

// det by differences of a volume: of the order of 1e-12 of third derivatives, 1e-13 of values.
static long double volume_determinant(const kn_spline *volume, const long double at[3])
{
    const long double step = 1e-6L;
    long double j[9], a[3], b[3];
    for (int d = 0; d < 3; d++) {
        long double x[3] = {at[0], at[1], at[2]}, y[3] = {at[0], at[1], at[2]};
        x[d] -= step, y[d] += step;
        direct_volume(a, volume, x);
        direct_volume(b, volume, y);
        for (int c = 0; c < 3; c++) j[3 * c + d] = (b[c] - a[c]) / (2 * step);
    }
    return determinant(j);
}

// What a piece says of det at x in [0,1]^nvars of its box, and how wrong that may be.
static long double from_piece(const kn_shell_jacobian_piece *p, const long double x[3], double w, long double *error)
{
    size_t n = kn_bezier_count(&p->j);
    long double sum = 0.0L, d = p->denominator.coef ? 0.0L : 1.0L, f = 1.0L, power = 1.0L,
                basis[3][KN_MAX_DEGREE + 1];
    for (int v = 0; v < p->j.nvars; v++) {
        int m = p->j.degree[v];
        for (int i = 0; i <= m; i++) {
            basis[v][i] = 1.0L;
            for (int k = 1; k <= i; k++) basis[v][i] *= x[v] * (m - k + 1) / k;
            for (int k = i; k < m; k++) basis[v][i] *= 1.0L - x[v];
        }
        for (int k = 0; k < p->order[v][0]; k++) f *= x[v];
        for (int k = 0; k < p->order[v][1]; k++) f *= 1.0L - x[v];
    }
    *error = 0.0L;
    for (int k = 0; k < p->j.ncomp; k++, power *= w) {
        *error += p->error[k] * fabsl(power);
        for (size_t i = 0; i < n; i++) {
            size_t at = i;
            long double b = power;
            for (int v = p->j.nvars - 1; v >= 0; v--) {
                b *= basis[v][at % (size_t)(p->j.degree[v] + 1)];
                at /= (size_t)(p->j.degree[v] + 1);
            }
            sum += b * p->j.coef[(size_t)k * n + i];
            if (k == 0 && p->denominator.coef) d += b / power * p->denominator.coef[i];
        }
    }
    *error *= f / d;
    return f * sum / d;
}

// Every box at some places: the difference within the bound that comes with it.
static void check_pieces(kn_ctx *ctx, const kn_shell *shell, const kn_shell_options *o, test_rng *rng,
                         const char *name)
{
    int grid[3];
    kn_shell_jacobian_grid(shell, grid);
    assert_int_equal(grid[2], 1);
    int step = 1 + grid[0] * grid[1] / test_scale(60);
    for (int k = 0; k < grid[0] * grid[1]; k += step) {
        const int at[3] = {k / grid[1], k % grid[1], 0};
        kn_shell_jacobian_piece p;
        if (kn_shell_jacobian_piece_init(ctx, &p, shell, at) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
        assert_true(p.lo[2] == -INFINITY && p.hi[2] == INFINITY && p.j.nvars == 2);
        for (int i = 0; i < 4; i++) {
            long double x[3] = {test_uniform(rng, 0, 1), test_uniform(rng, 0, 1), 0}, t[3], j[9], error;
            long double u = p.lo[0] + x[0] * ((long double)p.hi[0] - p.lo[0]);
            long double v = p.lo[1] + x[1] * ((long double)p.hi[1] - p.lo[1]);
            double w = test_uniform(rng, -1, 1);
            direct_kind(t, j, shell, o, u, v, w);
            long double det = determinant(j), found = from_piece(&p, x, w, &error);
            // 1e-17: of long double, of numbers that cancel to det
            if (!(fabsl(found - det) <= error + 1e-16L * (1.0L + fabsl(det))))
                fail_msg("%s: %.17Lg, directly %.17Lg, bound %Lg", name, found, det, error);
            if (!(error <= 1e-8L)) fail_msg("%s: a bound of %Lg tells nothing", name, error);
        }
        kn_shell_jacobian_piece_clear(ctx, &p);
    }
}

// Bounds over all cells contain every sample, and lie within a tenth of the samples' range outside them.
static void check_bounds(kn_ctx *ctx, const kn_shell *shell, const kn_shell_options *o, test_rng *rng)
{
    const double w0 = -0.3, w1 = 0.4;
    double lo[2], hi[2], least, most;
    long double below = INFINITY, above = -INFINITY, t[3], j[9];
    for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(shell), v, &lo[v], &hi[v]);
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &least, &most, shell, w0, w1), KN_OK);
    for (int i = 0; i < 3000; i++) {
        double u = test_uniform(rng, lo[0], hi[0]), v = test_uniform(rng, lo[1], hi[1]);
        if (i % 4 < 2) u = i % 4 ? lo[0] : hi[0]; // extremes are on edges mostly
        if (i % 16 < 8) v = i % 16 < 4 ? lo[1] : hi[1];
        direct_kind(t, j, shell, o, u, v, i % 3 == 0 ? w0 : i % 3 == 1 ? w1 : test_uniform(rng, w0, w1));
        below = fminl(below, determinant(j)), above = fmaxl(above, determinant(j));
    }
    long double slack = 0.1L * (above - below);
    if (!(below >= least && above <= most && below - least < slack && most - above < slack))
        fail_msg("[%g, %g] but samples in [%Lg, %Lg]", least, most, below, above);
}

static void pieces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(50);
    kn_shell_options o = {.normal_tol = 1e-4};
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = create(ctx, &s, &o);
        check_pieces(ctx, shell, &o, &rng, surface_cases[k].name);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Thickness, direction, attraction, all at once, over a polynomial and a rational surface.
static void fields(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(51);
    for (int k = 0; k < 8; k++) {
        kn_spline s, h, psi, d;
        surface_cases[k % 2 ? 1 : 4].make(ctx, &s);
        make_field(ctx, &h, &rng, &s, 2, 1, 1.0, 0.3);
        make_field(ctx, &psi, &rng, &s, 1 + k % 3, 3, 0.0, 0.2);
        make_field(ctx, &d, &rng, &s, 2, 3, 1.0, 0.2);
        kn_shell_options o = {.normal_tol = 1e-3, .attraction_power = 1 + k / 2};
        if (k % 3 != 1) o.thickness = &h;
        if (k % 3 != 2) o.attraction = &psi;
        if (k % 4 == 3) o.direction = &d;
        kn_shell *shell = create(ctx, &s, &o);
        check_pieces(ctx, shell, &o, &rng, "fields");
        check_bounds(ctx, shell, &o, &rng);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &h);
        kn_spline_clear(ctx, &psi);
        kn_spline_clear(ctx, &d);
    }
    test_ctx_end(ctx, &memory);
}

static void volumes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(52);
    for (int which = 0; which < VOLUME_CASES; which++) {
        kn_spline volume;
        kn_shell *shell = NULL;
        kn_spline *list = NULL;
        int grid[3], n, weight;
        make_volume(ctx, &volume, which);
        assert_int_equal(kn_shell_from_volume(ctx, &shell, &volume, NULL), KN_OK);
        kn_shell_jacobian_grid(shell, grid);
        assert_int_equal(grid[2], kn_spline_spans(&volume, 2));
        double begin, end;
        kn_spline_domain(&volume, 2, &begin, &end);
        assert_int_equal(kn_shell_jacobian(ctx, &list, &n, &weight, shell), KN_OK);
        assert_true(n == 1 && list[0].nvars == 3 && weight == (volume.rational ? 4 : 0));
        double least, most, from = 0.1 * (end - begin), to = 0.8 * (end - begin);
        assert_int_equal(kn_shell_jacobian_bounds(ctx, &least, &most, shell, from, to), KN_OK);
        for (int k = 0; k < grid[0] * grid[1] * grid[2]; k++) {
            const int at[3] = {k / grid[2] / grid[1], k / grid[2] % grid[1], k % grid[2]};
            kn_shell_jacobian_piece p;
            assert_int_equal(kn_shell_jacobian_piece_init(ctx, &p, shell, at), KN_OK);
            assert_true(p.j.nvars == 3 && p.j.ncomp == 1 && p.lo[2] >= 0.0 && p.hi[2] <= end - begin);
            for (int i = 0; i < 4; i++) {
                long double x[3], y[3], error;
                double whole, where[3], bottom[4] = {0};
                for (int v = 0; v < 3; v++) {
                    x[v] = test_uniform(&rng, 0.01, 0.99);
                    y[v] = p.lo[v] + x[v] * ((long double)p.hi[v] - p.lo[v]) + (v == 2 ? begin : 0.0);
                    where[v] = (double)y[v] - (v == 2 ? begin : 0.0);
                }
                long double det = volume_determinant(&volume, y), found = from_piece(&p, x, 0.0, &error);
                long double off = 1e-8L * (1.0L + fabsl(det)); // of the differences
                if (where[2] > from && where[2] < to) assert_true(det >= least - off && det <= most + off);
                if (!(fabsl(found - det) <= error + off))
                    fail_msg("volume %d: %.17Lg, directly %.17Lg, bound %Lg", which, found, det, error);
                // The spline of the whole, over the power of the weight.
                assert_int_equal(kn_spline_eval(ctx, &whole, &list[0], where), KN_OK);
                if (volume.rational) {
                    kn_spline w = {0};
                    where[2] += begin;
                    assert_int_equal(kn_spline_components(ctx, &w, &volume, 3, 1), KN_OK);
                    assert_int_equal(kn_spline_eval(ctx, bottom, &w, where), KN_OK);
                    kn_spline_clear(ctx, &w);
                    whole /= pow(bottom[0], weight);
                }
                assert_true(fabsl(whole - det) <= off + 1e-9L);
            }
            kn_shell_jacobian_piece_clear(ctx, &p);
        }
        kn_spline_clear(ctx, &list[0]);
        kn_free(ctx, list);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &volume);
    }
    test_ctx_end(ctx, &memory);
}

// J_k as splines: their sum over W^3 is det.
static void splines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(53);
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s, weight = {0}, *list = NULL;
        int n = 0, power = 0;
        double lo[2], hi[2];
        surface_cases[k].make(ctx, &s);
        kn_shell_options o = {.normal_tol = 1e-3};
        kn_shell *shell = create(ctx, &s, &o);
        assert_int_equal(kn_shell_jacobian(ctx, &list, &n, &power, shell), KN_OK);
        assert_int_equal(n, 3);
        assert_int_equal(power, s.rational ? 3 : 0);
        if (s.rational) assert_int_equal(kn_spline_components(ctx, &weight, &s, 3, 1), KN_OK);
        for (int v = 0; v < 2; v++) kn_spline_domain(&s, v, &lo[v], &hi[v]);
        for (int i = 0; i < test_scale(200); i++) {
            double at[2] = {test_uniform(&rng, lo[0], hi[0]), test_uniform(&rng, lo[1], hi[1])}, sum = 0.0, x;
            double w = test_uniform(&rng, -1, 1), wk = 1.0;
            long double t[3], j[9];
            for (int c = 0; c < n; c++, wk *= w) {
                assert_int_equal(kn_spline_eval(ctx, &x, &list[c], at), KN_OK);
                sum += wk * x;
            }
            if (s.rational) {
                assert_int_equal(kn_spline_eval(ctx, &x, &weight, at), KN_OK);
                sum /= x * x * x;
            }
            direct_kind(t, j, shell, &o, at[0], at[1], w);
            // 1e-13 for each factor below 30, and a hundred roundings of evaluation
            assert_true(fabsl(sum - determinant(j)) < 1e-8L);
        }
        for (int c = 0; c < n; c++) kn_spline_clear(ctx, &list[c]);
        kn_free(ctx, list);
        kn_spline_clear(ctx, &weight);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// ---- poles ----

// Boxes at a pole have its factor divided out, and what is left does not vanish there; others have none.
static void poles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int which = 0; which < 4; which++) { // sphere, the same elsewhere, the teapot's lid, a cone
        kn_spline s = {0};
        const double base[3] = {0, 0, 0}, axis[3] = {0, 0, 1}, far[3] = {10, 20, -30};
        if (which == 0) assert_int_equal(kn_construct_sphere(ctx, &s, base, 2.0), KN_OK);
        if (which == 1) assert_int_equal(kn_construct_sphere(ctx, &s, far, 2.0), KN_OK);
        if (which == 2 && !make_teapot(ctx, &s, 20)) skip();
        if (which == 3) assert_int_equal(kn_construct_cone(ctx, &s, base, axis, 1.0, 0.0), KN_OK);
        kn_shell_options o = {.normal_tol = 1e-5};
        kn_shell *shell = create(ctx, &s, &o);
        int grid[3], orders = 0, flats = 0;
        kn_shell_jacobian_grid(shell, grid);
        for (int k = 0; k < grid[0] * grid[1]; k++) {
            const int at[3] = {k / grid[1], k % grid[1], 0};
            kn_shell_jacobian_piece p;
            assert_int_equal(kn_shell_jacobian_piece_init(ctx, &p, shell, at), KN_OK);
            assert_true(p.order[0][0] + p.order[0][1] == 0 && !p.flat[0][0] && !p.flat[0][1]);
            assert_true((p.order[1][0] == 0 || at[1] == 0) && (p.order[1][1] == 0 || at[1] == grid[1] - 1));
            orders += p.order[1][0] + p.order[1][1];
            flats += p.flat[1][0] + p.flat[1][1];
            for (size_t i = 0; i < kn_bezier_count(&p.j); i++) {
                bool edge = p.flat[1][1] && (i + 1) % (size_t)(p.j.degree[1] + 1) == 0;
                if (edge)
                    assert_true(p.j.coef[i] == 0.0);
                else
                    assert_true(p.j.coef[i] > p.error[0]); // J_0 of these shapes: its coefficients are positive
            }
            kn_shell_jacobian_piece_clear(ctx, &p);
        }
        assert_int_equal(orders, which < 2 ? 2 * grid[0] : which == 2 ? grid[0] : 0);
        assert_int_equal(flats, which == 3 ? grid[0] : 0);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// ---- failures ----

static void bad_arguments(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(54);
    kn_spline s, psi, *list = NULL;
    kn_shell_jacobian_piece p = {.cell = {7, 7}};
    int n = 7, weight = 7;
    make_plane(ctx, &s);
    make_field(ctx, &psi, &rng, &s, 1, 3, 0.0, 0.1);
    kn_shell_options o = {.attraction = &psi, .attraction_power = 20}; // powers up to 59
    kn_shell *shell = create(ctx, &s, &o);
    assert_int_equal(kn_shell_jacobian(ctx, &list, &n, &weight, shell), KN_ELIMIT);
    assert_int_equal(kn_shell_jacobian_piece_init(ctx, &p, shell, (const int[3]){0, 0, 0}), KN_ELIMIT);
    kn_shell_destroy(ctx, shell);
    o.attraction_power = 19;
    shell = create(ctx, &s, &o);
    static const int outside[4][3] = {{-1, 0, 0}, {0, 1000000, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int k = 0; k < 4; k++)
        assert_int_equal(kn_shell_jacobian_piece_init(ctx, &p, shell, outside[k]), KN_EDOMAIN);
    assert_true(list == NULL && n == 7 && weight == 7 && p.cell[0] == 7);
    assert_int_equal(kn_shell_jacobian_piece_init(ctx, &p, shell, (const int[3]){0, 0, 0}), KN_OK);
    assert_int_equal(p.j.ncomp, 57);
    kn_shell_jacobian_piece_clear(ctx, &p);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &psi);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef struct held {
    kn_shell *shell; // made in another context; only read
} held;

static kn_status compute(kn_ctx *ctx, void *user)
{
    const held *h = user;
    kn_spline *list = NULL;
    kn_shell_jacobian_piece p = {.cell = {7, 7}};
    int n = 7, weight = 7;
    kn_status status = kn_shell_jacobian(ctx, &list, &n, &weight, h->shell);
    if (status != KN_OK) {
        assert_true(list == NULL && n == 7 && weight == 7);
        return status;
    }
    for (int k = 0; k < n; k++) kn_spline_clear(ctx, &list[k]);
    kn_free(ctx, list);
    status = kn_shell_jacobian_piece_init(ctx, &p, h->shell, (const int[3]){0, 0, 0});
    if (status != KN_OK) assert_int_equal(p.cell[1], 7);
    if (status == KN_OK) kn_shell_jacobian_piece_clear(ctx, &p);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int k = 0; k < 2; k++) {
        kn_spline s;
        held h = {0};
        if (k == 0) {
            kn_shell_options o = {.normal_tol = 0.05};
            make_cylinder(ctx, &s);
            h.shell = create(ctx, &s, &o);
        } else {
            make_volume(ctx, &s, 3);
            assert_int_equal(kn_shell_from_volume(ctx, &h.shell, &s, NULL), KN_OK);
        }
        test_allocation_failures(compute, &h);
        kn_shell_destroy(ctx, h.shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces),
        cmocka_unit_test(fields),
        cmocka_unit_test(volumes),
        cmocka_unit_test(splines),
        cmocka_unit_test(poles),
        cmocka_unit_test(bad_arguments),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("trivar/jacobian", tests, NULL, NULL);
}
