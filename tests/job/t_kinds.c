// SPDX-License-Identifier: Apache-2.0
// Jobs over shells of other kinds than S + w n, and over bases that are taken in parts.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <knurl/construct.h>
#include <knurl/io.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct run {
    test_memory memory;
    kn_ctx *ctx;
    kn_tile tile;
    kn_job *job;
    kn_job_report report;
    scene_result result;
} run;

static void run_begin(run *r, void (*make_tile)(kn_ctx *, kn_tile *))
{
    *r = (run){.memory = TEST_MEMORY_INIT};
    r->ctx = test_ctx(&r->memory, 1);
    make_tile(r->ctx, &r->tile);
}

static void run_job(run *r, const kn_spline *bases, int n, const kn_job_options *o)
{
    if (kn_job_create(r->ctx, &r->job, bases, n, &r->tile, o) != KN_OK) fail_msg("%s", kn_ctx_message(r->ctx));
    r->report = kn_job_describe(r->job);
    kn_sink sink = scene_sink(&r->result);
    assert_int_equal(kn_job_run(r->ctx, r->job, &sink, 1), KN_OK);
    kn_sink_close(r->ctx, &sink);
    assert_int_equal(r->result.count, r->report.patches);
    assert_true(r->report.normal.certified);
}

static void run_drop(run *r)
{
    scene_result_clear(&r->result);
    kn_job_destroy(r->ctx, r->job);
    r->job = NULL;
}

static void run_end(run *r)
{
    kn_tile_clear(r->ctx, &r->tile);
    test_ctx_end(r->ctx, &r->memory);
}

// T at (u, v, w) of a surface of the job, and how far the composed patch may be from it.
typedef void (*direct)(double t[3], double *bound, const run *r, int surface, const double at[2], double w,
                       const void *user);

static double distance(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

// Every stride-th patch at random places against T by another way. Rounding: 1e-12 of numbers below `size`.
static void check(run *r, direct t_of, const void *user, size_t stride, double size)
{
    test_rng rng = test_random(71);
    for (size_t i = 0; i < r->result.count; i += stride) {
        const kn_patch *p = &r->result.patches[i];
        kn_bezier d = {0};
        kn_patch_place place;
        assert_int_equal(kn_job_source(r->ctx, &d, &place, r->job, &p->id), KN_OK);
        for (int k = 0; k < 3; k++) {
            double x[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, uvw[3], got[3], at[2], t[3],
                   bound = 0;
            assert_int_equal(kn_bezier_eval(r->ctx, uvw, &d, x), KN_OK);
            assert_int_equal(kn_bezier_eval(r->ctx, got, &p->bezier, x), KN_OK);
            for (int v = 0; v < 2; v++)
                at[v] = (double)scene_parameter(r->job, place.surface, v, place.cell[v] + uvw[v]);
            t_of(t, &bound, r, place.surface, at, uvw[2], user);
            if (!(distance(got, t) <= bound + 1e-12 * size))
                fail_msg("patch %zu is off by %g, not %g", i, distance(got, t), bound);
        }
        kn_bezier_clear(r->ctx, &d);
    }
}

// The shell's own T; that it is S + w h n + w^k psi is what the tests of shells are about.
static void by_shell(double t[3], double *bound, const run *r, int surface, const double at[2], double w,
                     const void *user)
{
    (void)user;
    assert_int_equal(kn_shell_eval(r->ctx, t, NULL, kn_job_shell(r->job, surface), at[0], at[1], w), KN_OK);
    *bound = r->report.stand_in_error;
}

static void make_field(kn_ctx *ctx, kn_spline *out, int degree, int spans, int ncomp, double middle, double radius)
{
    double knots[16], coef[300];
    const double *k[2] = {knots, knots};
    int count = degree + spans, n = 0;
    test_rng rng = test_random(72);
    for (int i = 0; i <= degree; i++) knots[n++] = 0;
    for (int i = 1; i < spans; i++) knots[n++] = (double)i / spans;
    for (int i = 0; i <= degree; i++) knots[n++] = 1;
    for (int i = 0; i < ncomp * count * count; i++) coef[i] = test_uniform(&rng, middle - radius, middle + radius);
    assert_int_equal(kn_spline_init(ctx, out, 2, ncomp, false, (const int[2]){degree, degree},
                                    (const int[2]){count, count}, k, coef),
                     KN_OK);
}

// Equal first and last rows and columns: over a torus the shell stays closed.
static void close_field(kn_spline *f)
{
    size_t n = (size_t)f->count[0], m = (size_t)f->count[1];
    for (size_t c = 0; c < (size_t)f->ncomp; c++) {
        double *x = f->coef + c * n * m;
        for (size_t j = 0; j < m; j++) x[(n - 1) * m + j] = x[j];
        for (size_t i = 0; i < n; i++) x[i * m + m - 1] = x[i * m];
    }
}

// ---- thickness ----

// A torus of radii 3 and 1 around z, by its closed form, with h over [0,1]^2.
static void thick_torus(double t[3], double *bound, const run *r, int surface, const double at[2], double w,
                        const void *user)
{
    const kn_spline *h = user, *s = kn_shell_surface(kn_job_shell(r->job, surface));
    double p[3], x[2], thick;
    assert_int_equal(kn_spline_eval(r->ctx, p, s, at), KN_OK);
    for (int v = 0; v < 2; v++) {
        double lo, hi;
        kn_spline_domain(s, v, &lo, &hi);
        x[v] = (at[v] - lo) / (hi - lo);
    }
    assert_int_equal(kn_spline_eval(r->ctx, &thick, h, x), KN_OK);
    double far = hypot(p[0], p[1]), n[3] = {p[0] - 3 * p[0] / far, p[1] - 3 * p[1] / far, p[2]};
    for (int c = 0; c < 3; c++) t[c] = p[c] + w * thick * n[c]; // |n| = 1, the small radius
    *bound = fabs(w) * thick * (r->report.normal.length_error + r->report.normal.angle_error) +
             r->report.stand_in_error;
}

static void torus_with_thickness(void **state)
{
    (void)state;
    const double center[3] = {0, 0, 0}, axis[3] = {0, 0, 1};
    for (int which = 0; which < 2; which++) {
        run r;
        kn_spline s = {0}, h = {0};
        run_begin(&r, which == 0 ? scene_dome : scene_strip);
        assert_int_equal(kn_construct_torus(r.ctx, &s, center, axis, 3, 1), KN_OK);
        make_field(r.ctx, &h, 2, 3, 1, 1.0, 0.5);
        close_field(&h);
        kn_job_options o = {.count = {8, 8}, .height = 0.25, .thickness = &h, .normal_tol = 1e-4, .max_degree = 40};
        run_job(&r, &s, 1, &o);
        bool closed[2];
        kn_shell_closed(kn_job_shell(r.job, 0), closed);
        assert_true(closed[0] && closed[1]);
        check(&r, thick_torus, &h, 3, 5);
        run_drop(&r);
        kn_spline_clear(r.ctx, &s), kn_spline_clear(r.ctx, &h);
        run_end(&r);
    }
}

// ---- exact degrees ----

// T = S + w d + w^k psi: no patch is subdivided or approximated, and where u runs along r alone and v along t alone,
// both by degree 1, and w by degree 2 along each, a term of degree p in u and in v and of power k composes to p + 2k.
// Symbolic composition gives the same patches, in the tile's degree times the largest sum of degrees and power.
static void exact_degrees(void **state)
{
    (void)state;
    const int degrees[6][4] = {// of d, of psi, k, and the largest of 3 + 3, 2 d + 1, 2 psi + k
                               {1, 0, 1, 6}, {1, 0, 7, 7}, {3, 2, 2, 7}, {1, 2, 3, 7}, {1, 3, 3, 9}, {3, 1, 8, 10}};
    for (int which = 0; which < 6; which++) {
        run r;
        kn_spline s = {0}, d = {0}, psi = {0};
        const int *g = degrees[which];
        int ofd = g[0] + 2, ofpsi = g[1] + 2 * g[2], most = ofd > ofpsi ? ofd : ofpsi;
        if (most < 3) most = 3;    // S
        run_begin(&r, scene_dome); // biquadratic
        scene_bicubic(r.ctx, &s, 0.2);
        make_field(r.ctx, &d, g[0], 1, 3, 0.4, 0.4);
        make_field(r.ctx, &psi, g[1], 1, 3, 0.0, 0.5);
        kn_job_options o = {
            .count = {3, 2}, .height = 0.7, .direction = &d, .attraction = &psi, .attraction_power = g[2]};
        run_job(&r, &s, 1, &o);
        assert_int_equal(r.report.patches, 4 * 6);
        assert_int_equal(r.report.exact_patches, 4 * 6);
        assert_true(r.report.stand_in_error == 0 && r.report.normal.angle_error == 0);
        for (size_t i = 0; i < r.result.count; i++)
            for (int v = 0; v < 2; v++) assert_int_equal(r.result.patches[i].bezier.degree[v], most);
        check(&r, by_shell, NULL, 1, 10);

        scene_result plain = r.result;
        r.result = (scene_result){0};
        kn_job_destroy(r.ctx, r.job);
        o.symbolic = true;
        run_job(&r, &s, 1, &o);
        for (size_t i = 0; i < plain.count; i++) {
            const kn_bezier *a = &plain.patches[i].bezier, *b = &r.result.patches[i].bezier;
            kn_bezier up = {0};
            for (int v = 0; v < 2; v++) assert_int_equal(b->degree[v], 2 * g[3]);
            assert_int_equal(kn_bezier_elevate(r.ctx, &up, a, b->degree), KN_OK);
            assert_true(test_max_difference(up.coef, b->coef, 3 * kn_bezier_count(b)) < 1e-12);
            kn_bezier_clear(r.ctx, &up);
        }
        scene_result_clear(&plain);
        o.max_degree = 2 * g[3] - 1; // no room: the message says what is needed
        kn_job *none = NULL;
        char need[32];
        (void)snprintf(need, sizeof need, "--max-degree %d ", 2 * g[3]);
        kn_ctx_clear_error(r.ctx);
        assert_int_equal(kn_job_create(r.ctx, &none, &s, 1, &r.tile, &o), KN_EDOMAIN);
        assert_non_null(strstr(kn_ctx_message(r.ctx), need));
        run_drop(&r);
        kn_spline_clear(r.ctx, &s), kn_spline_clear(r.ctx, &d), kn_spline_clear(r.ctx, &psi);
        run_end(&r);
    }
}

// A direction with knots of its own over a spline: tiles that reach into the next cell are cut there, and patches
// agree with T beyond the domain too, where S and d go on.
static void direction_with_knots(void **state)
{
    (void)state;
    for (int which = 0; which < 2; which++) {
        run r;
        kn_spline s = {0}, d = {0};
        run_begin(&r, scene_strip);
        if (which == 0) scene_spline(r.ctx, &s);
        if (which == 1) scene_cylinder(r.ctx, &s); // rational, and d is not closed: neither is the shell
        make_field(r.ctx, &d, 2, 3, 3, 0.3, 0.5);
        kn_job_options o = {.count = {12, 7}, .height = 0.5, .direction = &d, .max_degree = 30};
        run_job(&r, &s, 1, &o);
        assert_int_equal(r.report.nparts, 1);
        assert_int_equal(r.report.exact_patches, r.report.patches);
        check(&r, by_shell, NULL, 1, 10);
        run_drop(&r);
        kn_spline_clear(r.ctx, &s), kn_spline_clear(r.ctx, &d);
        run_end(&r);
    }
}

// ---- attraction ----

static void constant(kn_ctx *ctx, kn_spline *out, double x, double y, double z)
{
    const double k[2] = {0, 1}, coef[3] = {x, y, z}, *knots[2] = {k, k};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[2]){0, 0}, (const int[2]){1, 1}, knots, coef),
                     KN_OK);
}

// S + w n + w^2 g, in patches whose degree gravity does not raise: within what plain patches are of S + w n.
static void gravity_on_the_teapot(void **state)
{
    (void)state;
    run r;
    kn_model model = {0};
    kn_spline g = {0};
    run_begin(&r, scene_dome);
    assert_int_equal(kn_read_bpt(r.ctx, &model, "data/teapot.bpt"), KN_OK);
    constant(r.ctx, &g, 0, 0, -1.5);
    kn_job_options o = {.count = {2, 2}, .height = 0.2, .normal_tol = 1e-3, .attraction = &g};
    int degree[2];
    run_job(&r, model.splines, 4, &o);
    memcpy(degree, r.report.degree, sizeof degree);
    check(&r, by_shell, NULL, 1, 10);
    size_t patches = r.report.patches;
    scene_result bent = r.result;
    r.result = (scene_result){0};
    kn_job_destroy(r.ctx, r.job);
    o.attraction = NULL;
    run_job(&r, model.splines, 4, &o);
    assert_int_equal(r.report.patches, patches);
    for (int v = 0; v < 2; v++) assert_int_equal(r.report.degree[v], degree[v]);
    for (size_t i = 0; i < patches; i += 5) { // the difference is w^2 g
        double x[2] = {0.3, 0.6}, a[3], b[3], uvw[3];
        kn_bezier d = {0};
        assert_int_equal(kn_job_source(r.ctx, &d, NULL, r.job, &r.result.patches[i].id), KN_OK);
        assert_int_equal(kn_bezier_eval(r.ctx, uvw, &d, x), KN_OK);
        assert_int_equal(kn_bezier_eval(r.ctx, a, &bent.patches[i].bezier, x), KN_OK);
        assert_int_equal(kn_bezier_eval(r.ctx, b, &r.result.patches[i].bezier, x), KN_OK);
        b[2] -= 1.5 * uvw[2] * uvw[2];
        assert_true(distance(a, b) < 1e-11);
        kn_bezier_clear(r.ctx, &d);
    }
    scene_result_clear(&bent);
    run_drop(&r);
    kn_model_clear(r.ctx, &model);
    kn_spline_clear(r.ctx, &g);
    run_end(&r);
}

// Wind as a spline with knots, k = 1, 2, 3, and a thickness, over a surface with knots of its own.
static void wind(void **state)
{
    (void)state;
    for (int k = 1; k <= 3; k++) {
        run r;
        kn_spline s = {0}, psi = {0}, h = {0};
        run_begin(&r, scene_strip);
        scene_spline(r.ctx, &s);
        make_field(r.ctx, &psi, 1, 2, 3, 0.0, 0.4);
        make_field(r.ctx, &h, 1, 2, 1, 1.0, 0.3);
        kn_job_options o = {
            .count = {9, 6}, .height = 0.4, .attraction = &psi, .attraction_power = k, .thickness = &h};
        o.normal_tol = 1e-4;
        o.max_degree = 30;
        run_job(&r, &s, 1, &o);
        // beyond the domain a patch follows the normal there, and not n extended
        size_t inside = 0;
        for (size_t i = 0; i < r.result.count; i++) {
            const int *cell = r.result.patches[i].id.cell;
            if (cell[0] == 0 || cell[0] == 8) continue;
            if (i != inside) {
                kn_patch p = r.result.patches[i];
                r.result.patches[i] = r.result.patches[inside];
                r.result.patches[inside] = p;
            }
            inside++;
        }
        size_t all = r.result.count;
        r.result.count = inside;
        check(&r, by_shell, NULL, 1, 10);
        r.result.count = all;
        assert_true(inside > 40);
        run_drop(&r);
        kn_spline_clear(r.ctx, &s), kn_spline_clear(r.ctx, &psi), kn_spline_clear(r.ctx, &h);
        run_end(&r);
    }
}

// ---- volumes ----

// The volume itself, over [0,1] in w.
static void by_volume(double t[3], double *bound, const run *r, int surface, const double at[2], double w,
                      const void *user)
{
    const kn_spline *v = user;
    double lo, hi, uvw[3] = {at[0], at[1], 0};
    (void)surface;
    kn_spline_domain(v, 2, &lo, &hi);
    uvw[2] = lo + w * (hi - lo);
    assert_int_equal(kn_spline_eval(r->ctx, t, v, uvw), KN_OK);
    *bound = 0;
}

static void make_volume(kn_ctx *ctx, kn_spline *out, int which)
{
    kn_spline s = {0}, other = {0};
    const double along[3] = {0.3, 0.1, 1.5}, origin[3] = {0, -4, 0}, axis[3] = {-1, 0, 0};
    const double bend[12] = {0, 0.5, 0, 1, 0, 0.5, 1, 2, 0, 0, 0.75, 2}, k[8] = {2, 2, 2, 2, 5, 5, 5, 5},
                 *knots[1] = {k};
    kn_status status = KN_OK;
    *out = (kn_spline){0};
    scene_spline(ctx, &s);
    if (which == 0) {
        scene_spline(ctx, &other);
        for (size_t i = 0; i < kn_spline_count(&s); i++)
            other.coef[2 * kn_spline_count(&s) + i] += 1.0 + 0.1 * (double)i;
        status = kn_construct_ruled(ctx, out, &s, &other);
    }
    if (which == 1) status = kn_construct_extruded(ctx, out, &s, along);
    if (which == 2) {
        status = kn_spline_init(ctx, &other, 1, 3, false, (const int[1]){3}, (const int[1]){4}, knots, bend);
        if (status == KN_OK) status = kn_construct_swept(ctx, out, &s, &other);
    }
    if (which == 3) status = kn_construct_revolved(ctx, out, &s, origin, axis, 0.5); // rational
    if (status != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &other);
}

// Ruled, extruded, swept and revolved volumes as bases: T is the volume, over all of it and over a part of its
// height, to the degree 3 + that in w times w's: u and v of the dome and of the strip run along one parameter each.
static void volumes(void **state)
{
    (void)state;
    for (int run_ = 0; run_ < 8; run_++) {
        run r;
        kn_spline v = {0};
        run_begin(&r, run_ < 4 ? scene_dome : scene_strip);
        make_volume(r.ctx, &v, run_ % 4);
        kn_job_options o = {
            .count = {5, 3}, .max_degree = 30, .height = run_ < 4 ? 0 : 0.5, .offset = run_ < 4 ? 0 : 0.25};
        run_job(&r, &v, 1, &o);
        assert_true(r.report.height == (run_ < 4 ? 1.0 : 0.5));
        assert_int_equal(r.report.degree[0], 3 * (run_ < 4 ? 1 : 2) + 2 * v.degree[2]);
        assert_int_equal(r.report.exact_patches, r.report.patches);
        check(&r, by_volume, &v, 1, 10);
        run_drop(&r);
        kn_spline_clear(r.ctx, &v);
        run_end(&r);
    }
}

// A trilinear block as .g2 text, class 700.
static void volume_from_a_file(void **state)
{
    (void)state;
    static const char text[] = "700 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n2 2\n0 0 2 2\n"
                               "0 0 0\n2 0 0\n0 3 0\n2 3 0\n0 0 1\n2 0 1\n0 3 1\n4 3 2\n";
    run r;
    kn_model model = {0};
    run_begin(&r, scene_dome);
    assert_int_equal(kn_parse_g2(r.ctx, &model, "block", text, sizeof text - 1), KN_OK);
    assert_int_equal(model.nsplines, 1);
    assert_int_equal(model.splines[0].nvars, 3);
    kn_job_options o = {.count = {2, 3}};
    run_job(&r, model.splines, 1, &o);
    assert_int_equal(r.report.degree[0], 1 + 2 * 1); // u by degree 1 and w by 2
    check(&r, by_volume, &model.splines[0], 1, 10);
    run_drop(&r);
    kn_model_clear(r.ctx, &model);
    run_end(&r);
}

// ---- sides ----

static void sides(void **state)
{
    (void)state;
    const struct {
        kn_job_side side;
        double height, lo, hi;
        bool reversed;
    } cases[5] = {{KN_JOB_ABOVE, 0.5, 0, 0.5, false},
                  {KN_JOB_ABOVE, -0.5, -0.5, 0, true},
                  {KN_JOB_BELOW, 0.5, -0.5, 0, true},
                  {KN_JOB_BELOW, -0.5, -0.5, 0, true},
                  {KN_JOB_BOTH, 0.5, -0.5, 0.5, false}};
    for (int k = 0; k < 5; k++) {
        run r;
        kn_spline s = {0};
        run_begin(&r, scene_dome);
        scene_bicubic(r.ctx, &s, 0.05);
        // the tile's top lies at 0.8^2 of the height
        kn_job_options o = {.count = {2, 2}, .height = cases[k].height, .side = cases[k].side, .normal_tol = 1e-4};
        run_job(&r, &s, 1, &o);
        double lo = INFINITY, hi = -INFINITY, bottom = cases[k].side == KN_JOB_BOTH ? -0.5 : 0;
        for (size_t i = 0; i < r.result.count; i++) {
            kn_bezier d = {0};
            assert_int_equal(r.result.patches[i].reversed, cases[k].reversed);
            assert_int_equal(kn_job_source(r.ctx, &d, NULL, r.job, &r.result.patches[i].id), KN_OK);
            size_t n = kn_bezier_count(&d);
            for (size_t j = 0; j < n; j++) lo = fmin(lo, d.coef[2 * n + j]), hi = fmax(hi, d.coef[2 * n + j]);
            kn_bezier_clear(r.ctx, &d);
        }
        double top = cases[k].side == KN_JOB_BOTH ? -0.5 + 0.64 : cases[k].reversed ? -0.32 : 0.32;
        assert_true(fabs(fmin(bottom, top) - lo) < 1e-15 && fabs(fmax(bottom, top) - hi) < 1e-15);
        check(&r, by_shell, NULL, 1, 5);
        run_drop(&r);
        kn_spline_clear(r.ctx, &s);
        run_end(&r);
    }
}

// ---- creases ----

// A square tube of biquadratic sides, 3 x 2 x 4, C0 at its corners.
static void make_tube(kn_ctx *ctx, kn_spline *out)
{
    kn_spline line = {0};
    const double corners[15] = {0, 0, 0, 3, 0, 0, 3, 2, 0, 0, 2, 0, 0, 0, 0}, up[3] = {0, 0, 4};
    *out = (kn_spline){0};
    assert_int_equal(kn_construct_polyline(ctx, &line, 3, 5, corners), KN_OK);
    assert_int_equal(kn_construct_extruded(ctx, out, &line, up), KN_OK);
    assert_int_equal(kn_spline_elevate(ctx, out, out, (const int[2]){2, 2}), KN_OK);
    kn_spline_clear(ctx, &line);
}

// On side k of the tube T is affine: (u, v, w) go to the side's own plane, also beyond its corners.
static void tube_side(double t[3], double *bound, const run *r, int surface, const double at[2], double w,
                      const void *user)
{
    static const double from[4][2] = {{0, 0}, {3, 0}, {3, 2}, {0, 2}},
                        along[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const double *line = kn_job_lines(r->job, surface, 0);
    int cells[2];
    (void)user;
    kn_shell_cells(kn_job_shell(r->job, surface), cells);
    double length = surface % 2 == 0 ? 3 : 2, x = length * (at[0] - line[0]) / (line[cells[0]] - line[0]);
    t[0] = from[surface][0] + x * along[surface][0] + w * along[surface][1]; // the normal is a quarter turn clockwise
    t[1] = from[surface][1] + x * along[surface][1] - w * along[surface][0];
    t[2] = 4 * at[1];
    *bound = fabs(w) * (r->report.normal.length_error + r->report.normal.angle_error);
}

// Patches of a tile that reaches a quarter cell over the creases on both sides: each side is a shell of its own, and
// the parts of one tile patch, cut at the lines, join.
static void creases_do_not_tear(void **state)
{
    (void)state;
    run r;
    kn_spline s;
    run_begin(&r, scene_strip);
    make_tube(r.ctx, &s);
    kn_job_options o = {.count = {11, 3}, .height = 0.3};
    run_job(&r, &s, 1, &o);
    assert_int_equal(r.report.nsurfaces, 1);
    assert_int_equal(r.report.nparts, 4);
    assert_int_equal(r.report.cells, 33);
    check(&r, tube_side, NULL, 1, 5);

    // Cells are numbered over the whole tube, each once; parts get their share by length in u, here 1 each: 3 3 3 2.
    int seen[11][3] = {{0}}, first[2], cells[2], sum = 0;
    for (int k = 0; k < 4; k++) {
        assert_int_equal(kn_job_origin(r.job, k, first), 0);
        assert_int_equal(first[0], sum);
        assert_int_equal(first[1], 0);
        kn_shell_cells(kn_job_shell(r.job, k), cells);
        assert_true(cells[0] == 2 || cells[0] == 3);
        sum += cells[0];
    }
    assert_int_equal(sum, 11);
    assert_int_equal(kn_job_origin(r.job, 4, first), -1);
    assert_int_equal(kn_job_origin(r.job, -1, NULL), -1);
    assert_null(kn_job_shell(r.job, 4));
    double end[3] = {0};
    for (size_t i = 0; i < r.result.count; i++) {
        const kn_patch *p = &r.result.patches[i];
        assert_int_equal(p->id.surface, 0);
        int *count = &seen[p->id.cell[0]][p->id.cell[1]];
        double a[3], b[3];
        assert_int_equal(kn_bezier_eval(r.ctx, a, &p->bezier, (const double[2]){0, 0.5}), KN_OK);
        assert_int_equal(kn_bezier_eval(r.ctx, b, &p->bezier, (const double[2]){1, 0.5}), KN_OK);
        if (*count > 0) assert_true(distance(a, end) < 1e-12); // patches of a cell follow one another along u
        memcpy(end, b, sizeof b);
        ++*count;
    }
    for (int i = 0; i < 33; i++) assert_int_equal(seen[i / 3][i % 3], 3);
    kn_bezier d = {0};
    assert_int_equal(kn_job_source(r.ctx, &d, NULL, r.job, &(kn_patch_id){.surface = 0, .cell = {11, 0}}),
                     KN_EDOMAIN);
    assert_int_equal(kn_job_source(r.ctx, &d, NULL, r.job, &(kn_patch_id){.surface = 1}), KN_EDOMAIN);

    // Fewer cells than sides; and by size, where every side is measured by itself.
    kn_job *none = NULL;
    o.count[0] = 3;
    kn_ctx_clear_error(r.ctx);
    assert_int_equal(kn_job_create(r.ctx, &none, &s, 1, &r.tile, &o), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(r.ctx), "at least 4"));
    run_drop(&r);
    o = (kn_job_options){.size = {0.5, 0.5}, .height = 0.3};
    run_job(&r, &s, 1, &o);
    assert_int_equal(r.report.cells, (6 + 4 + 6 + 4) * 8);
    for (int k = 0; k < 4; k++) {
        kn_shell_cells(kn_job_shell(r.job, k), cells);
        assert_int_equal(cells[0], k % 2 == 0 ? 6 : 4);
    }
    run_drop(&r);
    kn_spline_clear(r.ctx, &s);
    run_end(&r);
}

// A drop's wall: closed, and its only crease is at the seam. Nothing goes on over it, and nothing is torn.
static void a_crease_at_the_seam(void **state)
{
    (void)state;
    const double k[8] = {0, 0, 0, 0, 1, 1, 1, 1}, coef[12] = {0, 3, -3, 0, 0, 3, 3, 0, 0, 0, 0, 0}, up[3] = {0, 0, 2};
    const double *knots[1] = {k};
    run r;
    kn_spline line = {0}, s = {0};
    run_begin(&r, scene_strip);
    assert_int_equal(kn_spline_init(r.ctx, &line, 1, 3, false, (const int[1]){3}, (const int[1]){4}, knots, coef),
                     KN_OK);
    assert_int_equal(kn_construct_extruded(r.ctx, &s, &line, up), KN_OK);
    kn_job_options o = {.count = {8, 2}, .height = 0.05, .normal_tol = 1e-4};
    run_job(&r, &s, 1, &o);
    bool closed[2];
    kn_shell_closed(kn_job_shell(r.job, 0), closed);
    assert_int_equal(r.report.nparts, 1);
    assert_false(closed[0] || closed[1]);
    double end[3] = {0};
    for (size_t i = 0; i < r.result.count; i++) { // parts of one tile patch follow one another along u
        const kn_patch *p = &r.result.patches[i];
        bool first = i == 0 || memcmp(p->id.cell, r.result.patches[i - 1].id.cell, sizeof p->id.cell) != 0;
        double a[3], b[3];
        assert_int_equal(kn_bezier_eval(r.ctx, a, &p->bezier, (const double[2]){0, 0.5}), KN_OK);
        assert_int_equal(kn_bezier_eval(r.ctx, b, &p->bezier, (const double[2]){1, 0.5}), KN_OK);
        // both sides have a normal within the tolerance, each its own
        if (!first) assert_true(distance(a, end) <= 2 * 0.05 * 2e-4 + 1e-12);
        memcpy(end, b, sizeof b);
    }
    run_drop(&r);
    kn_spline_clear(r.ctx, &s), kn_spline_clear(r.ctx, &line);
    run_end(&r);
}

// Over a direction that goes on there is nothing to take apart: the tile follows T over the crease.
static void a_direction_over_creases(void **state)
{
    (void)state;
    run r;
    kn_spline s, d = {0};
    run_begin(&r, scene_strip);
    make_tube(r.ctx, &s);
    make_field(r.ctx, &d, 2, 1, 3, 0.2, 0.5);
    close_field(&d);
    kn_job_options o = {.count = {8, 3}, .height = 0.3, .direction = &d};
    run_job(&r, &s, 1, &o);
    assert_int_equal(r.report.nparts, 1);
    check(&r, by_shell, NULL, 1, 5);
    run_drop(&r);
    kn_spline_clear(r.ctx, &s), kn_spline_clear(r.ctx, &d);
    run_end(&r);
}

// ---- failures ----

static void expect(run *r, kn_status status, const char *word, const kn_spline *bases, int n, const kn_job_options *o)
{
    kn_ctx_clear_error(r->ctx);
    assert_int_equal(kn_job_create(r->ctx, &r->job, bases, n, &r->tile, o), status);
    assert_null(r->job);
    if (!strstr(kn_ctx_message(r->ctx), word)) fail_msg("\"%s\" does not say \"%s\"", kn_ctx_message(r->ctx), word);
}

static void failures(void **state)
{
    (void)state;
    run r;
    kn_spline both[2] = {{0}, {0}}, h = {0}, far = {0};
    run_begin(&r, scene_dome);
    scene_spline(r.ctx, &both[0]);
    make_volume(r.ctx, &both[1], 1);
    make_field(r.ctx, &h, 1, 1, 1, 1, 0.1);
    assert_int_equal(kn_spline_reparameterize(r.ctx, &far, &h, 0, 0, 2), KN_OK);
    const int c[2] = {5, 5};
    expect(&r, KN_EDOMAIN, "volumes among", both, 2, &(kn_job_options){.count = {c[0], c[1]}});
    expect(&r, KN_EDOMAIN, "its own thickness", &both[1], 1,
           &(kn_job_options){.count = {c[0], c[1]}, .thickness = &h});
    expect(&r, KN_EDOMAIN, "thickness", both, 1, &(kn_job_options){.count = {c[0], c[1]}, .thickness = &far});
    expect(&r, KN_EDOMAIN, "direction", both, 1, &(kn_job_options){.count = {c[0], c[1]}, .direction = &h});
    expect(&r, KN_EDOMAIN, "attraction", both, 1, &(kn_job_options){.count = {c[0], c[1]}, .attraction = &h});
    expect(&r, KN_EDOMAIN, "w^-2", both, 1, &(kn_job_options){.count = {c[0], c[1]}, .attraction_power = -2});
    expect(&r, KN_ELIMIT, "w^99", both, 1, &(kn_job_options){.count = {c[0], c[1]}, .attraction_power = 99});
    expect(&r, KN_EDOMAIN, "side", both, 1, &(kn_job_options){.count = {c[0], c[1]}, .side = (kn_job_side)3});
    assert_int_equal(kn_spline_insert_knots(r.ctx, &both[1], &both[1], 2, (const double[1]){0.5}, 1), KN_OK);
    expect(&r, KN_EDOMAIN, "knots in w", &both[1], 1, &(kn_job_options){.count = {c[0], c[1]}});
    kn_spline_clear(r.ctx, &both[0]), kn_spline_clear(r.ctx, &both[1]);
    kn_spline_clear(r.ctx, &h), kn_spline_clear(r.ctx, &far);
    run_end(&r);
}

typedef struct call {
    const kn_spline *base;
    const kn_tile *tile;
    const kn_job_options *o;
} call;

static kn_status job_call(kn_ctx *ctx, void *user)
{
    const call *c = user;
    kn_job *job = NULL;
    kn_status status = kn_job_create(ctx, &job, c->base, 1, c->tile, c->o);
    assert_true((status == KN_OK) == (job != NULL));
    kn_job_destroy(ctx, job);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    for (int which = 0; which < 3; which++) {
        run r;
        kn_spline s = {0}, h = {0}, psi = {0};
        run_begin(&r, scene_dome);
        make_field(r.ctx, &h, 1, 1, 1, 1, 0.1);
        make_field(r.ctx, &psi, 1, 1, 3, 0, 0.1);
        kn_job_options o = {.count = {1, 1}, .height = 0.2, .normal_tol = 1e-2};
        if (which == 0) scene_bicubic(r.ctx, &s, 0);
        if (which == 0) o.thickness = &h, o.attraction = &psi;
        if (which == 1) make_volume(r.ctx, &s, 1), o.count[0] = 3, o.count[1] = 2;
        if (which == 2) make_tube(r.ctx, &s), o.count[0] = 4;
        call c = {&s, &r.tile, &o};
        test_allocation_failures(job_call, &c);
        kn_spline_clear(r.ctx, &s), kn_spline_clear(r.ctx, &h), kn_spline_clear(r.ctx, &psi);
        run_end(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(torus_with_thickness),
        cmocka_unit_test(exact_degrees),
        cmocka_unit_test(direction_with_knots),
        cmocka_unit_test(gravity_on_the_teapot),
        cmocka_unit_test(wind),
        cmocka_unit_test(volumes),
        cmocka_unit_test(volume_from_a_file),
        cmocka_unit_test(sides),
        cmocka_unit_test(creases_do_not_tear),
        cmocka_unit_test(a_direction_over_creases),
        cmocka_unit_test(a_crease_at_the_seam),
        cmocka_unit_test(failures),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
