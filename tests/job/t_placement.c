// SPDX-License-Identifier: Apache-2.0
// Where tiles lie: shift, stagger, mirror, angle and borders, and strips whose normal turns over at a seam.
#include "tests/support/support.h"

#include "tests/support/scene.h"
#include "tests/support/surfaces.h"

#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- bases and tiles ----

// z = 0 over [0,nu] x [0,nv], so that a cell is a unit square, and the result is the tile itself.
static void make_flat(kn_ctx *ctx, kn_spline *out, int nu, int nv)
{
    static const double line[] = {0, 0, 1, 1};
    const double *knots[2] = {line, line};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    const double coef[12] = {0, 0, nu, nu, 0, nv, 0, nv, 0, 0, 0, 0};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, degree, count, knots, coef), KN_OK);
}

// w = ramp(u) as a covering tile: 1/4 at u = 0 and 3/4 at u = 1, quadratic, the same at v = 0 and 1.
static double ramp(double u)
{
    return 0.25 * (1 - u) * (1 - u) + 0.75 * 2 * u * (1 - u) + 0.75 * u * u;
}
static void make_ramp(kn_ctx *ctx, kn_tile *out)
{
    static const double coef[18] = {0, 0, 0.5, 0.5, 1, 1, 0, 1, 0, 1, 0, 1, 0.25, 0.25, 0.75, 0.75, 0.75, 0.75};
    assert_int_equal(kn_tile_init(ctx, out, "ramp", 1), KN_OK);
    out->covering = true;
    scene_add_patch(ctx, out, 2, 1, coef);
}

// scene_dome over its cell.
static double dome(double u, double v)
{
    static const double lift[5] = {0, 0.3, 0.8, 0.3, 0};
    double w[2], at[2] = {u, v};
    for (int d = 0; d < 2; d++) {
        int half = at[d] >= 0.5;
        double t = 2 * at[d] - half;
        w[d] = lift[2 * half] * (1 - t) * (1 - t) + lift[2 * half + 1] * 2 * t * (1 - t) + lift[2 * half + 2] * t * t;
    }
    return w[0] * w[1];
}

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline base;
    kn_tile tile;
    kn_job *job;
    scene_result r;
} scene;

static void begin(scene *s, int threads)
{
    *s = (scene){.memory = TEST_MEMORY_INIT};
    s->ctx = test_ctx(&s->memory, threads);
}

static void run(scene *s, const kn_job_options *o)
{
    if (kn_job_create(s->ctx, &s->job, &s->base, 1, &s->tile, o) != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    scene_run(s->ctx, s->job, &s->r);
    assert_int_equal(kn_job_describe(s->job).patches, s->r.count);
}

static void end(scene *s)
{
    scene_result_clear(&s->r);
    kn_job_destroy(s->ctx, s->job);
    kn_tile_clear(s->ctx, &s->tile);
    kn_spline_clear(s->ctx, &s->base);
    test_ctx_end(s->ctx, &s->memory);
}

// ---- the lattice, over a plane ----

static double part_of(double x)
{
    return x - floor(x);
}

// Points of all patches are on the graph that the placed tiles make, which is at `height` over (x,y); their area, seen
// from above, is `area`, and outward is up. 1e-12: some hundred roundings of numbers up to 10.
static void check_graph(const scene *s, double (*height)(double x, double y), double area)
{
    double sum = 0;
    for (size_t i = 0; i < s->r.count; i++) {
        const kn_patch *p = &s->r.patches[i];
        double box[2][2] = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
        for (int k = 0; k < 9; k++) {
            const double at[2] = {0.5 * (k / 3), 0.5 * (k % 3)};
            double point[3];
            assert_int_equal(kn_bezier_eval(s->ctx, point, &p->bezier, at), KN_OK);
            for (int d = 0; d < 2; d++) {
                box[0][d] = fmin(box[0][d], point[d]);
                box[1][d] = fmax(box[1][d], point[d]);
            }
        }
        // inside, where heights may not jump
        for (int k = 0; k < 9; k++) {
            const double at[2] = {0.1 + 0.4 * (k / 3), 0.1 + 0.4 * (k % 3)};
            double point[3];
            assert_int_equal(kn_bezier_eval(s->ctx, point, &p->bezier, at), KN_OK);
            assert_true(fabs(point[2] - height(point[0], point[1])) <= 1e-12);
        }
        sum += (box[1][0] - box[0][0]) * (box[1][1] - box[0][1]);
        double d[9];
        assert_int_equal(kn_bezier_derivatives(s->ctx, d, &p->bezier, (const double[]){0.5, 0.5}, 1), KN_OK);
        double up = d[3] * d[7] - d[4] * d[6];
        assert_true((up > 0) != p->reversed);
    }
    assert_true(fabs(sum - area) <= 1e-10);
}

static double staggered(double x, double y)
{
    return 0.5 * dome(part_of(x - 0.25 - 0.5 * floor(y)), part_of(y));
}
static double thirds(double x, double y)
{
    return 0.5 * dome(part_of(x), part_of(y - floor(x) / 3));
}
static double mirrored(double x, double y)
{
    (void)y;
    double u = part_of(x);
    return 0.5 * ramp(fmod(floor(x), 2) != 0 ? 1 - u : u);
}
static double mirrored_and_shifted(double x, double y)
{
    return mirrored(x - 0.25 + 4, y); // an even number of tiles to the left
}

static void lattices_lie_where_they_should(void **state)
{
    (void)state;
    const struct {
        kn_job_placement placement;
        bool ramp;
        double (*height)(double, double);
        double area;
    } cases[] = {
        {{.shift = {0.25}, .stagger = {0.5}, .border = {KN_BORDER_CLIP, KN_BORDER_CLIP}}, false, staggered, 12},
        {{.shift = {0.25}, .stagger = {0.5}, .border = {KN_BORDER_CYCLIC}}, false, staggered, 12},
        {{.shift = {0.25}, .stagger = {0.5}}, false, staggered, 15}, // one tile more in each of three rows
        {{.shift = {2.25}, .stagger = {-1.5}, .border = {KN_BORDER_CLIP}}, false, staggered, 12},
        {{.stagger = {0, 1.0 / 3}, .border = {KN_BORDER_EXTEND, KN_BORDER_CLIP}}, false, thirds, 12},
        {{.stagger = {0, 0.333}, .border = {KN_BORDER_EXTEND, KN_BORDER_CYCLIC}}, false, thirds, 12},
        {{.mirror = {true}}, true, mirrored, 12},
        {{.mirror = {true}, .shift = {0.25}, .border = {KN_BORDER_CLIP}}, true, mirrored_and_shifted, 12},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        scene s;
        begin(&s, 1);
        make_flat(s.ctx, &s.base, 4, 3);
        if (cases[k].ramp)
            make_ramp(s.ctx, &s.tile);
        else
            scene_dome(s.ctx, &s.tile);
        s.tile.covering = true;
        kn_job_options o = {.count = {4, 3}, .height = 0.5, .placement = cases[k].placement};
        run(&s, &o);
        check_graph(&s, cases[k].height, cases[k].area);
        end(&s);
    }
}

// ---- edges that match ----

// Of every edge of all patches that is no point: the number of others that run through the same control points, either
// way, within tol; how often it is not one.
static int unmatched(const scene *s, double tol)
{
    int wrong = 0;
    size_t n = 4 * s->r.count;
    double(*edge)[3][3] = malloc(n * sizeof *edge); // at its start, in the middle, at its end
    assert_non_null(edge);
    for (size_t e = 0; e < 3 * n; e++) {
        int side = (int)(e / 3 % 4);
        double at[2];
        at[side / 2] = side % 2;
        at[1 - side / 2] = 0.5 * (double)(e % 3);
        assert_int_equal(kn_bezier_eval(s->ctx, edge[e / 3][e % 3], &s->r.patches[e / 12].bezier, at), KN_OK);
    }
    for (size_t e = 0; e < n; e++) {
        int mates = 0;
        for (size_t f = 0; f < n; f++) {
            if (f == e || test_max_difference(edge[e][1], edge[f][1], 3) > tol) continue;
            bool same = true, back = true;
            for (int i = 0; i < 3; i += 2) {
                same = same && test_max_difference(edge[e][i], edge[f][i], 3) <= tol;
                back = back && test_max_difference(edge[e][i], edge[f][2 - i], 3) <= tol;
            }
            mates += same || back;
        }
        wrong += mates != 1;
    }
    free(edge);
    return wrong;
}

static void tilings_close_round_a_torus(void **state)
{
    (void)state;
    const kn_job_placement cases[] = {{.stagger = {0.5}},
                                      {.stagger = {0, 0.25}},
                                      {.mirror = {true, true}},
                                      {.mirror = {true}, .shift = {0.3, 0.7}}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        scene s;
        begin(&s, 2);
        make_torus(s.ctx, &s.base);
        scene_dome(s.ctx, &s.tile);
        s.tile.covering = true;
        kn_job_options o = {
            .count = {4, 4}, .height = 0.2, .normal_tol = 1e-3, .max_degree = 40, .placement = cases[k]};
        run(&s, &o);
        assert_int_equal(unmatched(&s, 1e-11), 0);
        end(&s);
    }
}

static void what_does_not_meet_is_refused(void **state)
{
    (void)state;
    const struct {
        kn_job_placement placement;
        int count[2];
        bool casual;
        const char *message;
    } cases[] = {
        {{.stagger = {0.5}}, {4, 5}, false, "multiple of 2"},
        {{.mirror = {true}}, {5, 4}, false, "multiple of 2"},
        {{.stagger = {0.382}}, {4, 4}, false, "denominator"},
        {{.stagger = {0.5, 0.5}}, {4, 4}, false, "not both"},
        {{.angle = 0.5}, {4, 4}, false, "--rotate 90"},
        {{.shift = {NAN}}, {4, 4}, true, "shift"},
        {{.stagger = {1000}}, {4, 4}, true, "stagger"},
        {{.border = {(kn_job_border)7}}, {4, 4}, true, "border"},
        {{.angle = INFINITY}, {4, 4}, true, "angle"},
        {{.scatter = {.distance = -1}}, {4, 4}, true, "distance"},
        {{.scatter = {.distance = 1}}, {4, 4}, false, "casual"},
        {{.scatter = {.distance = 1}, .shift = {0.5}}, {4, 4}, true, "no shift"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        scene s;
        begin(&s, 1);
        make_torus(s.ctx, &s.base);
        scene_dome(s.ctx, &s.tile);
        s.tile.covering = !cases[k].casual;
        kn_job_options o = {.count = {cases[k].count[0], cases[k].count[1]},
                            .height = 0.2,
                            .normal_tol = 1e-2,
                            .max_degree = 40,
                            .placement = cases[k].placement};
        assert_int_equal(kn_job_create(s.ctx, &s.job, &s.base, 1, &s.tile, &o), KN_EDOMAIN);
        assert_null(s.job);
        if (!strstr(kn_ctx_message(s.ctx), cases[k].message)) fail_msg("case %zu: %s", k, kn_ctx_message(s.ctx));
        end(&s);
    }
}

// Nor does it matter how tiles would meet at the seam of a surface that has none.
static void seams_of_what_is_not_selected(void **state)
{
    (void)state;
    scene s;
    kn_spline flat = {0};
    begin(&s, 1);
    make_torus(s.ctx, &s.base);
    make_flat(s.ctx, &flat, 2, 2);
    scene_dome(s.ctx, &s.tile);
    s.tile.covering = true;
    const kn_spline bases[2] = {s.base, flat}; // borrowed
    const int selected[1] = {1};
    kn_job_options o = {.count = {4, 5}, .height = 0.2, .normal_tol = 1e-2, .placement = {.stagger = {0.5}}};
    assert_int_equal(kn_job_create(s.ctx, &s.job, bases, 2, &s.tile, &o), KN_EDOMAIN);
    kn_ctx_clear_error(s.ctx);
    o.select.surfaces = selected, o.select.nsurfaces = 1;
    assert_int_equal(kn_job_create(s.ctx, &s.job, bases, 2, &s.tile, &o), KN_OK);
    kn_spline_clear(s.ctx, &flat);
    end(&s);
}

// A patch that crosses the end of the base, turned by 30 degrees, has no parameter line there: it is trimmed
// (t_border.c), where a trim can be as near the end as that.
static void clips_within_the_tolerance(void **state)
{
    (void)state;
    scene s;
    begin(&s, 1);
    make_flat(s.ctx, &s.base, 2, 2);
    scene_diamond(s.ctx, &s.tile);
    kn_job_options o = {.count = {2, 2}, .height = 1, .placement = {.border = {KN_BORDER_CLIP, KN_BORDER_EXTEND}}};
    run(&s, &o);
    assert_true(s.r.count > 4 - 1 && kn_job_describe(s.job).crossing_error > 0.0);
    end(&s);
}

// ---- angles ----

static void any_angle_for_casual_tiles(void **state)
{
    (void)state;
    scene s;
    begin(&s, 1);
    make_flat(s.ctx, &s.base, 2, 2);
    scene_strip(s.ctx, &s.tile);
    double angle = 0.3;
    kn_job_options o = {.count = {2, 2}, .height = 1, .placement = {.angle = angle}};
    run(&s, &o);
    assert_int_equal(s.r.count, 4);
    // the middle of the strip's end u = -1/4, in cell (1,0), turned about (1/2,1/2)
    double u = -0.75, x = 1.5 + cos(angle) * u, y = 0.5 + sin(angle) * u, p[3];
    assert_int_equal(s.r.patches[2].id.cell[0], 1);
    assert_int_equal(kn_bezier_eval(s.ctx, p, &s.r.patches[2].bezier, (const double[]){0, 0.5}), KN_OK);
    assert_true(fabs(p[0] - x) + fabs(p[1] - y) <= 1e-14 && p[2] == 0);
    end(&s);
}

// ---- a strip whose normal turns over ----

// A Moebius band of radius 2 as a quadratic B-spline, whose ends coincide when one is turned over: closed by control
// points at half angles beyond the ends.
static void make_moebius(kn_ctx *ctx, kn_spline *out)
{
    enum { N = 26 };
    double knots_u[N + 3], coef[2 * N * 3];
    static const double knots_v[] = {0, 0, 1, 1};
    const double *knots[2] = {knots_u, knots_v};
    const int degree[2] = {2, 1}, count[2] = {N, 2};
    double step = 2 * acos(-1.0) / (N - 2);
    for (int i = 0; i < N + 3; i++) knots_u[i] = i < 3 ? 0 : i > N - 1 ? N - 2 : i - 2;
    double c[N][2][3];
    for (int i = 0; i < N; i++)
        for (int j = 0; j < 2; j++) { // uniform control points, i + N - 2 the same as i turned over
            int k = i % (N - 2);
            double a = step * (k - 0.5), b = 0.5 * a, side = (i == k ? 1 : -1) * (j == 0 ? -0.4 : 0.4);
            c[i][j][0] = (2 + side * cos(b)) * cos(a);
            c[i][j][1] = (2 + side * cos(b)) * sin(a);
            c[i][j][2] = side * sin(b);
        }
    for (int i = 0; i < N; i++)
        for (int j = 0; j < 2; j++)
            for (int d = 0; d < 3; d++) { // clamped: the ends are middles of legs of the uniform control polygon
                double x = c[i][j][d];
                if (i == 0) x = 0.5 * (c[0][j][d] + c[1][j][d]);
                if (i == N - 1) x = 0.5 * (c[N - 2][j][d] + c[N - 1][j][d]);
                coef[d * 2 * N + 2 * i + j] = x;
            }
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, degree, count, knots, coef), KN_OK);
}

// Walls of a tube along u around the middle of the cell, from w = 0.2 to 0.8, closed in its cross section.
static void make_tube(kn_ctx *ctx, kn_tile *out)
{
    static const double v[5] = {0.2, 0.8, 0.8, 0.2, 0.2}, w[5] = {0.2, 0.2, 0.8, 0.8, 0.2};
    assert_int_equal(kn_tile_init(ctx, out, "tube", 1), KN_OK);
    for (int k = 0; k < 4; k++) { // r along u, t round: outward is r x t
        double coef[12] = {0, 0, 1, 1};
        for (int i = 0; i < 2; i++)
            for (int j = 0; j < 2; j++) coef[4 + 2 * i + j] = v[k + 1 - j], coef[8 + 2 * i + j] = w[k + 1 - j];
        scene_add_patch(ctx, out, 1, 1, coef);
    }
}

// A tile on both sides that is the same upside down closes over the flipped seam; one on one side ends there, on one
// side of the strip at one end and on the other at the other.
static void moebius_strips(void **state)
{
    (void)state;
    for (int both = 0; both < 2; both++) {
        scene s;
        begin(&s, 2);
        make_moebius(s.ctx, &s.base);
        make_tube(s.ctx, &s.tile);
        kn_job_options o = {
            .count = {24, 1}, .height = 0.1, .side = both ? KN_JOB_BOTH : KN_JOB_ABOVE, .normal_tol = 1e-3};
        run(&s, &o);
        assert_int_equal(s.r.count, 96);
        assert_int_equal(unmatched(&s, 1e-10), both ? 0 : 8);
        end(&s);
    }
}

// A strip that reaches over the seam goes on there on the other side of the surface: where it was cut, both pieces
// have one edge.
static void tiles_go_on_over_a_flipped_seam(void **state)
{
    (void)state;
    scene s;
    begin(&s, 1);
    make_moebius(s.ctx, &s.base);
    scene_strip(s.ctx, &s.tile);
    kn_job_options o = {.count = {24, 1}, .height = 0.1, .normal_tol = 1e-4, .max_degree = 40};
    run(&s, &o);
    int beyond = 0;
    for (size_t i = 0; i < s.r.count; i++) {
        const kn_patch *p = &s.r.patches[i];
        kn_bezier d = {0};
        kn_patch_place place;
        assert_int_equal(kn_job_source(s.ctx, &d, &place, s.job, &p->id), KN_OK);
        double at[2] = {0.3, 0.6}, uvw[3], got[3], want[3];
        assert_int_equal(kn_bezier_eval(s.ctx, uvw, &d, at), KN_OK);
        assert_int_equal(kn_bezier_eval(s.ctx, got, &p->bezier, at), KN_OK);
        bool seam = abs(place.cell[0] - p->id.cell[0]) > 12;
        if (seam) { // the strip is above in its own cell: w > 0 there, and below here
            assert_true(uvw[2] < 0);
            beyond++;
        }
        assert_int_equal(
            kn_shell_eval(s.ctx, want, NULL, kn_job_shell(s.job, 0), place.cell[0] + uvw[0], uvw[1], uvw[2]), KN_OK);
        assert_true(test_max_difference(got, want, 3) <= 1e-3 * 0.2); // a tenth of it w, which normal_tol turns
        kn_bezier_clear(s.ctx, &d);
    }
    assert_int_equal(beyond, 2); // one at each end
    // of three pieces of each strip: two long edges each, and the ends of the strip
    assert_int_equal(unmatched(&s, 1e-4), 24 * (3 * 2 + 2));
    end(&s);
}

// ---- memory ----

static void ramps(kn_ctx *safe, kn_spline *base, kn_tile *tile)
{
    make_flat(safe, base, 2, 2);
    make_ramp(safe, tile);
}

static kn_status staggers(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_job_options o = {.count = {2, 2}, .height = 0.5, .placement = {.stagger = {0.5}, .mirror = {true}}};
    return scene_try_job(ctx, ramps, &o);
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(staggers, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lattices_lie_where_they_should),
                                       cmocka_unit_test(tilings_close_round_a_torus),
                                       cmocka_unit_test(what_does_not_meet_is_refused),
                                       cmocka_unit_test(seams_of_what_is_not_selected),
                                       cmocka_unit_test(clips_within_the_tolerance),
                                       cmocka_unit_test(any_angle_for_casual_tiles),
                                       cmocka_unit_test(moebius_strips),
                                       cmocka_unit_test(tiles_go_on_over_a_flipped_seam),
                                       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("job/placement", tests, NULL, NULL);
}
