// SPDX-License-Identifier: Apache-2.0
// Tiles over knot lines of C0, C1 and C2 bases: trimmed pieces against T(D) in long double, and against each other.
#include "tests/support/support.h"

#include "tests/support/kinds.h"
#include "tests/support/scene.h"
#include "tests/support/surfaces.h"

#include <math.h>
#include <string.h>

// ---- a sink that keeps patches with their trims ----

typedef struct kept {
    kn_patch_id id;
    kn_bezier b;
    kn_trim trim;
} kept;
typedef struct keeper {
    kept *list;
    size_t n;
} keeper;

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)product;
    keeper *k = user;
    for (size_t i = 0; i < block->count; i++) {
        k->list = test_realloc(k->list, (k->n + 1) * sizeof *k->list);
        kept *to = &k->list[k->n++];
        *to = (kept){.id = block->patches[i].id};
        assert_int_equal(kn_bezier_copy(ctx, &to->b, &block->patches[i].bezier), KN_OK);
        if (block->patches[i].trim) assert_int_equal(kn_trim_copy(ctx, &to->trim, block->patches[i].trim), KN_OK);
    }
    return KN_OK;
}

static void run(kn_ctx *ctx, keeper *k, const kn_job *job)
{
    *k = (keeper){0};
    kn_sink sink = {.user = k, .commit = commit};
    assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_OK);
}

static void keeper_clear(kn_ctx *ctx, keeper *k)
{
    for (size_t i = 0; i < k->n; i++) {
        kn_bezier_clear(ctx, &k->list[i].b);
        kn_trim_clear(ctx, &k->list[i].trim);
    }
    test_free(k->list);
}

// ---- bases and tiles ----

// Smooth to this order at its knots: 2 and 1 as they come, 0 with control points moved by chance. Spans of one length
// (even), or not: then maps from cells are bent at the knots.
static void make_base(kn_ctx *ctx, kn_spline *s, int smooth, bool even, test_rng *rng)
{
    if (smooth == 1)
        make_double_knots(ctx, s);
    else if (smooth == 2 && even)
        make_wavy(ctx, s);
    else
        scene_spline(ctx, s);
    if (smooth > 0) return;
    for (int var = 0; var < 2; var++) {
        double more[16];
        int n = 0;
        for (int i = 4; i < s->count[var]; i++)
            for (int k = 0; k < 2; k++) more[n++] = s->knots[var][i];
        assert_int_equal(kn_spline_insert_knots(ctx, s, s, var, more, n), KN_OK);
    }
    for (size_t i = 0; i < 3 * kn_spline_count(s); i++) s->coef[i] += test_uniform(rng, -0.05, 0.05);
}

// One patch of degrees 1 to 3, turned and shifted by chance, about `size` cells wide.
static void random_tile(kn_ctx *ctx, kn_tile *tile, test_rng *rng, double size)
{
    const int degree[2] = {test_int(rng, 1, 3), test_int(rng, 1, 3)};
    kn_bezier b = {0};
    kn_spline s = {0};
    double angle = test_uniform(rng, -3.0, 3.0), x = test_uniform(rng, 0.2, 0.8), y = test_uniform(rng, 0.2, 0.8);
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
    size_t n = kn_bezier_count(&b);
    for (int i = 0; i <= degree[0]; i++)
        for (int j = 0; j <= degree[1]; j++) {
            double p = size * ((double)i / degree[0] - 0.5) + test_uniform(rng, -0.06, 0.06);
            double q = size * ((double)j / degree[1] - 0.5) + test_uniform(rng, -0.06, 0.06);
            size_t at = (size_t)(i * (degree[1] + 1) + j);
            b.coef[at] = x + cos(angle) * p - sin(angle) * q;
            b.coef[n + at] = y + sin(angle) * p + cos(angle) * q;
            b.coef[2 * n + at] = test_uniform(rng, 0.0, 1.0);
        }
    assert_int_equal(kn_tile_init(ctx, tile, "random", 1), KN_OK);
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
    kn_bezier_clear(ctx, &b);
}

// ---- checks ----

typedef struct scene {
    kn_ctx *ctx;
    const kn_job *job;
    kn_shell_options shell;
    kn_job_report report;
    size_t values, seams;
    bool approximate; // patches may be off anywhere
    bool exact;       // a direction takes the place of n
    double worst, gap;
} scene;

// How far (u, v) of a cell is from the nearest knot line of S.
static double from_line(const scene *s, const kn_patch_place *place, const double *uv)
{
    double near = INFINITY;
    const kn_spline *base = kn_shell_surface(kn_job_shell(s->job, place->surface));
    int cells[2];
    kn_shell_cells(kn_job_shell(s->job, place->surface), cells);
    for (int d = 0; d < 2; d++)
        for (int i = 1; i < cells[d]; i++) {
            double line = kn_job_lines(s->job, place->surface, d)[i];
            for (int k = base->degree[d] + 1; k < base->count[d]; k++)
                if (base->knots[d][k] == line) near = fmin(near, fabs(uv[d] + place->cell[d] - i));
        }
    return near;
}

static double distance(const double *a, const double *b)
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

static void evaluate(const scene *s, double p[3], const kept *k, const double at[2])
{
    assert_int_equal(kn_bezier_eval(s->ctx, p, &k->b, at), KN_OK);
}

// A value where the patch is: T(D) to 1e-12, and near a knot line within what the report says.
static void check_value(scene *s, const kept *k, const kn_bezier *d, const kn_patch_place *place, const double at[2])
{
    double p[3], q[3], uvw[3];
    long double t[3];
    assert_int_equal(kn_bezier_eval(s->ctx, uvw, d, at), KN_OK);
    int cells[2];
    kn_shell_cells(kn_job_shell(s->job, place->surface), cells);
    for (int v = 0; v < 2; v++) // beyond the domain n is a stand-in's (kn_job_report.stand_in_error)
        if (!s->exact && (place->cell[v] + uvw[v] < 0.0 || place->cell[v] + uvw[v] > cells[v])) return;
    evaluate(s, p, k, at);
    direct_kind(t, NULL, kn_job_shell(s->job, place->surface), &s->shell,
                scene_parameter(s->job, place->surface, 0, place->cell[0] + (long double)uvw[0]),
                scene_parameter(s->job, place->surface, 1, place->cell[1] + (long double)uvw[1]), uvw[2]);
    for (int c = 0; c < 3; c++) q[c] = (double)t[c];
    double off = distance(p, q);
    // 1e-12: the issue's; a trim is never coarser than 2^-8 of a cell (job/cross_trim.c)
    double allowed = 1e-12 + s->report.stand_in_error;
    if (s->approximate || from_line(s, place, uvw) <= 0x1p-8) allowed += s->report.crossing_error;
    if (from_line(s, place, uvw) > 0x1p-8) s->worst = fmax(s->worst, off);
    assert_true(off <= allowed);
    s->values++;
}

static bool same_source(const kn_bezier *a, const kn_bezier *b)
{
    size_t n = kn_bezier_count(a);
    return n == kn_bezier_count(b) && memcmp(a->coef, b->coef, 3 * n * sizeof *a->coef) == 0;
}

// Dense points of every curve that two pieces of one D share: both surfaces there.
static void check_seams(scene *s, const kept *a, const kept *b)
{
    for (int i = 0; i < a->trim.ncurves; i++)
        for (int j = 0; j < b->trim.ncurves; j++) {
            const kn_spline *c = &a->trim.curves[i], *e = &b->trim.curves[j];
            int n = c->count[0];
            if (e->count[0] != n || c->coef[0] != e->coef[n - 1] || c->coef[n] != e->coef[2 * n - 1] ||
                c->coef[n - 1] != e->coef[0] || c->coef[2 * n - 1] != e->coef[n])
                continue;
            double lo, hi;
            kn_spline_domain(c, 0, &lo, &hi);
            for (int k = 0; k <= 64; k++) {
                double at[2], p[3], q[3], x = lo + (hi - lo) * k / 64.0;
                assert_int_equal(kn_spline_eval(s->ctx, at, c, &x), KN_OK);
                evaluate(s, p, a, at);
                evaluate(s, q, b, at);
                s->gap = fmax(s->gap, distance(p, q));
                assert_true(distance(p, q) <= s->report.crossing_error);
                s->seams++;
            }
        }
}

// Pieces of one D, first .. last - 1: every point of it is in one of them.
static void check_pieces(scene *s, const keeper *k, size_t first, size_t last, const kn_bezier *d,
                         const kn_patch_place *place, test_rng *rng)
{
    for (int trial = 0; trial < 20; trial++) {
        const double at[2] = {test_uniform(rng, 0.0, 1.0), test_uniform(rng, 0.0, 1.0)};
        int times = 0;
        bool known = true;
        for (size_t i = first; i < last; i++) {
            kn_answer answer;
            assert_int_equal(kn_trim_contains(s->ctx, &answer, &k->list[i].trim, at), KN_OK);
            known = known && answer != KN_UNKNOWN;
            times += answer == KN_YES;
            if (answer == KN_YES) check_value(s, &k->list[i], d, place, at);
        }
        assert_true(times == 1 || !known);
    }
    for (size_t i = first; i < last; i++) {
        if (last - first > 1) assert_int_equal(kn_trim_check(s->ctx, &k->list[i].trim), KN_OK);
        for (size_t j = i + 1; j < last; j++) check_seams(s, &k->list[i], &k->list[j]);
    }
}

static void check_job(scene *s, test_rng *rng)
{
    keeper k;
    run(s->ctx, &k, s->job);
    s->report = kn_job_describe(s->job);
    assert_int_equal(k.n, s->report.patches);
    size_t step = s->approximate ? 1 + k.n / 8 : 0; // kn_job_source plans the cell anew, each time
    for (size_t first = 0, last; first < k.n; first = last + step) {
        kn_bezier d = {0}, e = {0};
        kn_patch_place place, other;
        assert_int_equal(kn_job_source(s->ctx, &d, &place, s->job, &k.list[first].id), KN_OK);
        for (last = first + 1; last < k.n && !s->approximate; last++) {
            if (k.list[last].id.piece == 0) break;
            assert_int_equal(kn_job_source(s->ctx, &e, &other, s->job, &k.list[last].id), KN_OK);
            if (!same_source(&d, &e)) break;
        }
        if (d.nvars == 2) check_pieces(s, &k, first, last, &d, &place, rng);
        kn_bezier_clear(s->ctx, &d);
        kn_bezier_clear(s->ctx, &e);
    }
    keeper_clear(s->ctx, &k);
}

// A direction along z in the place of n: all pieces are exact, and bases that are C0 are not taken apart.
static void make_up(kn_ctx *ctx, kn_spline *out)
{
    const double ends[2] = {0.0, 1.0}, *const knots[2] = {ends, ends};
    const int degree[2] = {0, 0}, count[2] = {1, 1};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, degree, count, knots, (double[]){0.1, 0.0, 1.0}), KN_OK);
}

static void trimmed(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    test_rng rng = test_random(5);
    size_t seams = 0;
    for (int smooth = 0; smooth <= 2; smooth++)
        for (int trial = 0; trial < test_scale(3); trial++) {
            kn_spline base = {0}, up = {0};
            kn_tile tile = {0};
            kn_job *job = NULL;
            make_base(ctx, &base, smooth, trial == 1, &rng);
            make_up(ctx, &up);
            random_tile(ctx, &tile, &rng, trial == 2 ? 2.6 : 0.9);
            const kn_job_options o = {
                .count = {3, 3}, .height = 0.2, .direction = &up, .crossing = KN_CROSSING_TRIM, .crossing_tol = 1e-3};
            kn_status made = kn_job_create(ctx, &job, &base, 1, &tile, &o);
            if (made != KN_OK) print_error("%s\n", kn_ctx_message(ctx));
            assert_int_equal(made, KN_OK);
            scene s = {.ctx = ctx, .job = job, .exact = true};
            check_job(&s, &rng);
            assert_true(s.report.crossing_error <= 1e-3 && s.report.exact_patches == s.report.patches);
            assert_true(s.values > 100);
            seams += s.seams;
            kn_job_destroy(ctx, job);
            kn_spline_clear(ctx, &base), kn_spline_clear(ctx, &up), kn_tile_clear(ctx, &tile);
        }
    assert_true(seams > 1000);
    test_ctx_end(ctx, &memory);
}

static void approximated(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    test_rng rng = test_random(6);
    for (int smooth = 0; smooth <= 2; smooth++)
        for (int trial = 0; trial < test_scale(1); trial++) {
            kn_spline base = {0}, up = {0};
            kn_tile tile = {0};
            kn_job *job = NULL;
            make_base(ctx, &base, smooth, true, &rng);
            make_up(ctx, &up);
            random_tile(ctx, &tile, &rng, 0.9);
            kn_job_options o = {.count = {kn_spline_spans(&base, 0), kn_spline_spans(&base, 1)},
                                .height = 0.2,
                                .direction = &up,
                                .crossing = KN_CROSSING_APPROXIMATE,
                                .crossing_tol = smooth > 0 ? 1e-2 : 5e-2};
            assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
            scene s = {.ctx = ctx, .job = job, .approximate = true, .exact = true};
            check_job(&s, &rng);
            assert_true(s.report.crossing_error > 0.0 && s.report.crossing_error <= o.crossing_tol);
            kn_job_destroy(ctx, job);
            kn_spline_clear(ctx, &base), kn_spline_clear(ctx, &up), kn_tile_clear(ctx, &tile);
        }
    test_ctx_end(ctx, &memory);
}

// A scale of degrees (2, 2) that reaches over the one above it and both beside it, turned by `angle`.
static void make_scale(kn_ctx *ctx, kn_tile *tile, double angle)
{
    const int degree[2] = {2, 2};
    kn_bezier b = {0};
    kn_spline s = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
    for (int i = 0; i <= 2; i++)
        for (int j = 0; j <= 2; j++) {
            double p = 0.6 * (i - 1), q = 0.75 * j - 0.45 - 0.15 * (i == 1 ? 0.0 : j);
            b.coef[3 * i + j] = 0.5 + cos(angle) * p - sin(angle) * q;
            b.coef[9 + 3 * i + j] = 0.5 + sin(angle) * p + cos(angle) * q;
            b.coef[18 + 3 * i + j] = 0.4 * j + (i == 1 ? 0.2 : 0.0);
        }
    assert_int_equal(kn_tile_init(ctx, tile, "scale", 1), KN_OK);
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
    kn_bezier_clear(ctx, &b);
}

// Over 20 x 20 control points with the surface's own normals: some cells in the middle and some at a border.
static void scales_on_waves(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    test_rng rng = test_random(10);
    kn_spline waves = {0};
    make_waves(ctx, &waves);
    for (int trial = 0; trial < test_cases(4); trial++) {
        kn_tile tile = {0};
        kn_job *job = NULL;
        make_scale(ctx, &tile, trial % 2 == 0 ? 0.0 : 0.4);
        kn_job_options o = {.height = 0.05, .normal_tol = 1e-4, .crossing = KN_CROSSING_TRIM};
        for (int d = 0; d < 2; d++) o.count[d] = kn_spline_spans(&waves, d);
        o.select.first = trial < 2 ? 140 : 0, o.select.count = 2;
        assert_int_equal(kn_job_create(ctx, &job, &waves, 1, &tile, &o), KN_OK);
        scene s = {.ctx = ctx, .job = job};
        check_job(&s, &rng);
        assert_true(s.values > 20 && s.report.crossing_error <= 1e-3 * s.report.cell_size);
        if (trial == 1) assert_true(s.seams > 0); // the upright one is cut along its own parameter lines
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
    }
    kn_spline_clear(ctx, &waves);
    test_ctx_end(ctx, &memory);
}

// A cubic over knot lines in both directions is cut at its roots: every piece is T(D) from end to end.
static void curves(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(11);
    kn_spline base = {0}, up = {0}, c = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    keeper k;
    make_base(ctx, &base, 1, true, &rng);
    make_up(ctx, &up);
    kn_bezier b = {.nvars = 1, .ncomp = 3, .degree = {3}};
    b.coef = (double[]){-0.3, 0.9, 0.4, 1.2, 0.2, -0.4, 1.9, 0.8, 0.0, 0.3, 0.2, 0.6};
    assert_int_equal(kn_spline_of_bezier(ctx, &c, &b), KN_OK);
    assert_int_equal(kn_tile_init(ctx, &tile, "curve", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, &tile, 0, &c), KN_OK);
    const kn_job_options o = {.count = {2, 3}, .height = 0.2, .direction = &up};
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
    scene s = {.ctx = ctx, .job = job, .exact = true};
    run(ctx, &k, job);
    assert_true(k.n > 6); // cells
    for (size_t i = 0; i < k.n; i++) {
        kn_bezier d = {0};
        kn_patch_place place;
        assert_int_equal(kn_job_source(ctx, &d, &place, job, &k.list[i].id), KN_OK);
        assert_int_equal(d.nvars, 1);
        for (int t = 0; t <= 8; t++) check_value(&s, &k.list[i], &d, &place, (double[]){t / 8.0, 0.0});
        kn_bezier_clear(ctx, &d);
    }
    keeper_clear(ctx, &k);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base), kn_spline_clear(ctx, &up), kn_spline_clear(ctx, &c);
    test_ctx_end(ctx, &memory);
}

// A sheet of 2 x 2 Bezier patches, turned, with a round hole, over knot lines: a point of it is in one output patch
// if the trim has it, and in none if not.
static void trimmed_tiles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(9);
    kn_spline base = {0}, up = {0}, sheet = {0};
    kn_bezier hole = {0}, d = {0};
    kn_trim whole = {0}, in = {0}, out = {0};
    kn_trim_cut_report cut;
    kn_tile tile = {0};
    kn_job *job = NULL;
    keeper k;
    make_base(ctx, &base, 1, true, &rng);
    make_up(ctx, &up);
    const double half = 0.5, square[3] = {0.25, -0.25, 0.25};
    assert_int_equal(kn_bezier_init(ctx, &hole, 2, 1, false, (int[]){2, 2}), KN_OK);
    for (int i = 0; i < 9; i++) hole.coef[i] = square[i / 3] + square[i % 3] - 0.09;
    assert_int_equal(kn_trim_cut(ctx, &in, &out, &cut, &whole, &hole, 1e-3), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &d, 2, 3, false, (int[]){1, 1}), KN_OK);
    const double corners[12] = {0.1, -0.2, 1.1, 0.8, 0.0, 1.0, 0.3, 1.3, 0.2, 0.2, 0.4, 0.4};
    memcpy(d.coef, corners, sizeof corners);
    assert_int_equal(kn_spline_of_bezier(ctx, &sheet, &d), KN_OK);
    for (int v = 0; v < 2; v++) assert_int_equal(kn_spline_insert_knots(ctx, &sheet, &sheet, v, &half, 1), KN_OK);
    assert_int_equal(kn_tile_init(ctx, &tile, "sheet", 1), KN_OK);
    assert_int_equal(kn_tile_add_trimmed(ctx, &tile, 0, &sheet, &out), KN_OK);
    const kn_job_options o = {.count = {2, 3}, .height = 0.2, .direction = &up, .crossing = KN_CROSSING_TRIM};
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
    run(ctx, &k, job);
    int inside = 0, outside = 0;
    for (int trial = 0; trial < 40; trial++) {
        const double at[2] = {test_uniform(&rng, 0.0, 1.0), test_uniform(&rng, 0.0, 1.0)};
        kn_answer want, is;
        double uvw[3], from[3];
        int times = 0;
        bool known = true;
        assert_int_equal(kn_trim_contains(ctx, &want, &out, at), KN_OK);
        assert_int_equal(kn_bezier_eval(ctx, uvw, &d, at), KN_OK);
        for (size_t i = 0; i < k.n; i++) { // in cell 1,1: where does the point lie in this patch's D?
            if (k.list[i].id.cell[0] != 1 || k.list[i].id.cell[1] != 1) continue;
            kn_bezier part = {0};
            kn_patch_place place;
            assert_int_equal(kn_job_source(ctx, &part, &place, job, &k.list[i].id), KN_OK);
            size_t n = kn_bezier_count(&part); // a parallelogram: two equations
            assert_int_equal(n, 4);
            const double *u = part.coef, *v = part.coef + n;
            double ur = u[2] - u[0], ut = u[1] - u[0], vr = v[2] - v[0], vt = v[1] - v[0], det = ur * vt - ut * vr;
            double x = uvw[0] + 1 - place.cell[0] - u[0], y = uvw[1] + 1 - place.cell[1] - v[0];
            const double local[2] = {(x * vt - y * ut) / det, (y * ur - x * vr) / det};
            kn_bezier_clear(ctx, &part);
            if (local[0] < 0.0 || local[0] > 1.0 || local[1] < 0.0 || local[1] > 1.0) continue;
            assert_int_equal(kn_trim_contains(ctx, &is, &k.list[i].trim, local), KN_OK);
            known = known && is != KN_UNKNOWN;
            times += is == KN_YES;
            assert_int_equal(kn_bezier_eval(ctx, from, &k.list[i].b, local), KN_OK);
        }
        if (!known || want == KN_UNKNOWN) continue;
        assert_int_equal(times, want == KN_YES ? 1 : 0);
        inside += want == KN_YES, outside += want == KN_NO;
    }
    assert_true(inside > 5 && outside > 5);
    keeper_clear(ctx, &k);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_trim_clear(ctx, &in), kn_trim_clear(ctx, &out);
    kn_bezier_clear(ctx, &hole), kn_bezier_clear(ctx, &d);
    kn_spline_clear(ctx, &base), kn_spline_clear(ctx, &up), kn_spline_clear(ctx, &sheet);
    test_ctx_end(ctx, &memory);
}

// A box, turned, over knot lines in both directions: refused with the option that helps; and where patches may cross,
// one volume within what the report says of T(D), its faces among it.
static void volumes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    test_rng rng = test_random(14);
    for (int trial = 0; trial < test_cases(2); trial++) {
        kn_spline base = {0}, up = {0}, box = {0};
        kn_tile tile = {0};
        kn_job *job = NULL;
        keeper k;
        make_base(ctx, &base, 2, true, &rng);
        make_up(ctx, &up);
        double coef[24];
        for (int i = 0; i < 8; i++) {
            coef[i] = 0.7 + 0.5 * (i / 4) - 0.3 * (i / 2 % 2);
            coef[8 + i] = 0.7 + 0.3 * (i / 4) + 0.5 * (i / 2 % 2);
            coef[16 + i] = i % 2;
        }
        const kn_bezier b = {.nvars = 3, .ncomp = 3, .degree = {1, 1, 1}, .coef = coef};
        assert_int_equal(kn_spline_of_bezier(ctx, &box, &b), KN_OK);
        assert_int_equal(kn_tile_init(ctx, &tile, "box", 1), KN_OK);
        assert_int_equal(kn_tile_add(ctx, &tile, 0, &box), KN_OK);
        kn_job_options o = {.count = {kn_spline_spans(&base, 0), kn_spline_spans(&base, 1)},
                            .height = 0.2,
                            .direction = &up,
                            .crossing_tol = 5e-2};
        o.select.count = 1;
        assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_EDOMAIN);
        assert_non_null(strstr(kn_ctx_message(ctx), "volume 0 of tile part"));
        assert_non_null(strstr(kn_ctx_message(ctx), "--crossing approximate"));
        kn_ctx_clear_error(ctx);
        o.crossing = trial == 0 ? KN_CROSSING_TRIM : KN_CROSSING_APPROXIMATE; // volumes have no trims: the same
        assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
        run(ctx, &k, job);
        scene s = {.ctx = ctx, .job = job, .report = kn_job_describe(job), .approximate = true, .exact = true};
        for (size_t i = 0; i < k.n; i++) {
            kn_bezier d = {0};
            kn_patch_place place;
            assert_int_equal(kn_job_source(ctx, &d, &place, job, &k.list[i].id), KN_OK);
            assert_true(d.nvars == 3 && k.list[i].b.nvars == 3 && k.list[i].trim.nloops == 0);
            for (int point = 0; point < 30; point++) {
                double at[3];
                for (int v = 0; v < 3; v++) at[v] = point % 4 == v ? point % 2 : test_uniform(&rng, 0.0, 1.0);
                check_value(&s, &k.list[i], &d, &place, at);
            }
            kn_bezier_clear(ctx, &d);
        }
        assert_true(s.values >= 30 && s.report.crossing_error > 1e-9 && s.report.crossing_error <= o.crossing_tol);
        keeper_clear(ctx, &k);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
        kn_spline_clear(ctx, &base), kn_spline_clear(ctx, &up), kn_spline_clear(ctx, &box);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(trimmed),         cmocka_unit_test(approximated),
                                       cmocka_unit_test(trimmed_tiles),   cmocka_unit_test(curves),
                                       cmocka_unit_test(scales_on_waves), cmocka_unit_test(volumes)};
    return cmocka_run_group_tests_name("job/cross", tests, NULL, NULL);
}
