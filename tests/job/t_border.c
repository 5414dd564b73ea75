// SPDX-License-Identifier: Apache-2.0
// The border clip: patches, curves and meshes that reach over ends of the base, against T(D) in long double, against
// polygons, and against the ends themselves; and what reaches beyond where the border extends.
#include "tests/support/support.h"

#include "tests/support/kinds.h"
#include "tests/support/scene.h"

#include <math.h>
#include <string.h>

// ---- a sink that keeps patches, their trims and meshes ----

enum { ROOM = 400 };
typedef struct kept {
    kn_patch_id id;
    kn_bezier b;
    kn_trim trim;
    kn_mesh mesh;
} kept;
typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline base, up;
    kn_tile tile;
    kn_job *job;
    kn_job_report report;
    kept list[ROOM];
    size_t n;
} scene;

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)product;
    scene *s = user;
    for (size_t i = 0; i < block->count; i++) {
        assert_true(s->n < ROOM);
        const kn_patch *p = &block->patches[i];
        kept *to = &s->list[s->n++];
        *to = (kept){.id = p->id};
        if (p->mesh) assert_int_equal(kn_mesh_copy(ctx, &to->mesh, p->mesh), KN_OK);
        if (!p->mesh) assert_int_equal(kn_bezier_copy(ctx, &to->b, &p->bezier), KN_OK);
        if (p->trim) assert_int_equal(kn_trim_copy(ctx, &to->trim, p->trim), KN_OK);
    }
    return KN_OK;
}

static scene *begin(void)
{
    scene *s = test_realloc(NULL, sizeof *s);
    memset(s, 0, sizeof *s);
    s->memory = (test_memory)TEST_MEMORY_INIT;
    s->ctx = test_ctx(&s->memory, 2);
    return s;
}

static void run(scene *s, const kn_job_options *o)
{
    if (kn_job_create(s->ctx, &s->job, &s->base, 1, &s->tile, o) != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    kn_sink sink = {.user = s, .commit = commit};
    assert_int_equal(kn_job_run(s->ctx, s->job, &sink, 1), KN_OK);
    s->report = kn_job_describe(s->job);
    assert_int_equal(s->report.patches, s->n);
}

static void end(scene *s)
{
    for (size_t i = 0; i < s->n; i++) {
        kn_bezier_clear(s->ctx, &s->list[i].b);
        kn_trim_clear(s->ctx, &s->list[i].trim);
        kn_mesh_clear(s->ctx, &s->list[i].mesh);
    }
    kn_job_destroy(s->ctx, s->job);
    kn_tile_clear(s->ctx, &s->tile);
    kn_spline_clear(s->ctx, &s->base), kn_spline_clear(s->ctx, &s->up);
    test_ctx_end(s->ctx, &s->memory);
    test_free(s);
}

// ---- bases and tiles ----

// z = 0 over [0,n]^2: a cell is a unit square, and the result is the tile itself.
static void make_flat(kn_ctx *ctx, kn_spline *out, double n)
{
    static const double line[] = {0, 0, 1, 1};
    const double *knots[2] = {line, line};
    const double coef[12] = {0, 0, n, n, 0, n, 0, n, 0, 0, 0, 0};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (int[]){1, 1}, (int[]){2, 2}, knots, coef), KN_OK);
}

// A direction along z in the place of n: pieces are exact.
static void make_up(kn_ctx *ctx, kn_spline *out)
{
    const double ends[2] = {0.0, 1.0}, *const knots[2] = {ends, ends};
    const int degree[2] = {0, 0}, count[2] = {1, 1};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, degree, count, knots, (double[]){0.1, 0.0, 1.0}), KN_OK);
}

static void add_part(kn_ctx *ctx, kn_tile *tile, int nvars, const int *degree, const double *coef)
{
    kn_bezier b = {0};
    kn_spline s = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, nvars, 3, false, degree), KN_OK);
    memcpy(b.coef, coef, 3 * kn_bezier_count(&b) * sizeof *coef);
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    if (!tile->parts) assert_int_equal(kn_tile_init(ctx, tile, "part", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
    kn_bezier_clear(ctx, &b);
}

// A parallelogram: corner, and two sides.
static const double corner[2] = {0.7, -0.6}, side[2][2] = {{0.9, 0.5}, {-0.8, 1.1}};
static void make_sheet(kn_ctx *ctx, kn_tile *tile)
{
    double coef[12];
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 2; c++) coef[4 * c + k] = corner[c] + k / 2 * side[0][c] + k % 2 * side[1][c];
        coef[8 + k] = 0.3 * k;
    }
    add_part(ctx, tile, 2, (int[]){1, 1}, coef);
}

// ---- checks ----

// What is left of a polygon on one side of a line (Sutherland and Hodgman); the number of its points.
static int clip_polygon(double (*p)[2], int n, int axis, double line, double sign)
{
    double out[16][2];
    int m = 0;
    for (int i = 0; i < n; i++) {
        const double *a = p[i], *b = p[(i + 1) % n];
        double x = sign * (a[axis] - line), y = sign * (b[axis] - line);
        if (x <= 0.0) memcpy(out[m++], a, sizeof out[0]);
        if (x * y >= 0.0) continue;
        for (int c = 0; c < 2; c++) out[m][c] = a[c] + x / (x - y) * (b[c] - a[c]);
        m++;
    }
    memcpy(p, out, (size_t)m * sizeof *p);
    return m;
}

static double clipped_area(const double (*polygon)[2], int n, double size)
{
    double p[16][2], area = 0.0;
    memcpy(p, polygon, (size_t)n * sizeof *p);
    for (int k = 0; k < 4; k++) n = clip_polygon(p, n, k / 2, k % 2 * size, k % 2 == 0 ? -1.0 : 1.0);
    for (int i = 0; i < n; i++) area += 0.5 * (p[i][0] * p[(i + 1) % n][1] - p[(i + 1) % n][0] * p[i][1]);
    return fabs(area);
}

static double apart(const double *p, const double *q)
{
    return sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
}

// T at a place in cells of surface 0.
static void direct(const scene *s, double out[3], const double uvw[3])
{
    long double t[3];
    kn_shell_options o = {.direction = &s->up};
    direct_kind(t, NULL, kn_job_shell(s->job, 0), s->up.coef ? &o : &(kn_shell_options){0},
                scene_parameter(s->job, 0, 0, uvw[0]), scene_parameter(s->job, 0, 1, uvw[1]), uvw[2]);
    for (int c = 0; c < 3; c++) out[c] = (double)t[c];
}

static void source(const scene *s, double uvw[3], const kn_bezier *d, const kn_patch_place *place, const double *at)
{
    assert_int_equal(kn_bezier_eval(s->ctx, uvw, d, at), KN_OK);
    for (int c = 0; c < 2; c++) uvw[c] += place->cell[c];
}

// The end of the domain within 2^-8 of a place (trims are never coarser), or -1: 2 variable + (upper).
static int near_end(const scene *s, const double uvw[3])
{
    int cells[2], which = -1;
    kn_shell_cells(kn_job_shell(s->job, 0), cells);
    for (int k = 0; k < 4; k++)
        if (fabs(uvw[k / 2] - (k % 2 == 0 ? 0 : cells[k / 2])) <= 0x1p-8) which = k;
    return which;
}

// Curves of the trim along an end: T there is T on the end, to within what the report says. *seen counts points.
static void check_ends(const scene *s, const kept *k, const kn_bezier *d, const kn_patch_place *place, size_t *seen)
{
    enum { N = 24 };
    int cells[2];
    kn_shell_cells(kn_job_shell(s->job, 0), cells);
    for (int i = 0; i < k->trim.ncurves; i++) {
        double at[N + 1][2], uvw[N + 1][3], lo, hi;
        int which = -2;
        kn_spline_domain(&k->trim.curves[i], 0, &lo, &hi);
        for (int j = 0; j <= N; j++) {
            double x = lo + (hi - lo) * j / N;
            assert_int_equal(kn_spline_eval(s->ctx, at[j], &k->trim.curves[i], &x), KN_OK);
            source(s, uvw[j], d, place, at[j]);
            int one = near_end(s, uvw[j]);
            which = which == -2 || which == one ? one : -1;
        }
        for (int j = 0; which >= 0 && j <= N; j++, ++*seen) {
            double p[3], q[3], on[3] = {uvw[j][0], uvw[j][1], uvw[j][2]};
            on[which / 2] = which % 2 == 0 ? 0 : cells[which / 2];
            assert_int_equal(kn_bezier_eval(s->ctx, p, &k->b, at[j]), KN_OK);
            direct(s, q, on);
            assert_true(apart(p, q) <= s->report.crossing_error + s->report.stand_in_error + 1e-12);
        }
    }
}

// Values inside are T(D); nothing there lies beyond an end; *values and *seen count.
static void check_patch(const scene *s, const kept *k, const kn_bezier *d, const kn_patch_place *place, test_rng *rng,
                        size_t *values, size_t *seen)
{
    int cells[2];
    kn_shell_cells(kn_job_shell(s->job, 0), cells);
    for (int trial = 0; trial < 12; trial++) {
        const double at[2] = {test_uniform(rng, 0.0, 1.0), test_uniform(rng, 0.0, 1.0)};
        kn_answer answer = KN_YES;
        double p[3], q[3], uvw[3];
        bool knot = false;
        if (k->trim.nloops > 0) assert_int_equal(kn_trim_contains(s->ctx, &answer, &k->trim, at), KN_OK);
        if (answer != KN_YES) continue;
        source(s, uvw, d, place, at);
        for (int c = 0; c < 2; c++) {
            assert_true(uvw[c] >= -0x1p-8 && uvw[c] <= cells[c] + 0x1p-8);
            knot = knot || fabs(uvw[c] - round(uvw[c])) <= 0x1p-8;
        }
        if (knot) continue; // where trims may be off
        direct(s, q, uvw);
        assert_int_equal(kn_bezier_eval(s->ctx, p, &k->b, at), KN_OK);
        assert_true(apart(p, q) <= s->report.stand_in_error + 1e-12);
        ++*values;
    }
    check_ends(s, k, d, place, seen);
}

// ---- surfaces ----

// Over a plane the areas of all pieces are those of clipped parallelograms; over waves values and ends are T's, in
// every way of crossing; a base of one span needs none.
static void surfaces(void **state)
{
    (void)state;
    test_rng rng = test_random(12);
    for (int trial = 0; trial < 5; trial++) {
        scene *s = begin();
        size_t values = 0, seen = 0;
        if (trial == 0) make_flat(s->ctx, &s->base, 3.0);
        if (trial == 1) scene_bicubic(s->ctx, &s->base, 0.1);
        if (trial == 2) make_wavy(s->ctx, &s->base);
        if (trial == 3) scene_torus(s->ctx, &s->base);
        if (trial == 4) scene_spline(s->ctx, &s->base);
        if (trial != 3) make_up(s->ctx, &s->up);
        make_sheet(s->ctx, &s->tile);
        const kn_job_options o = {.count = {3, 3},
                                  .height = 0.2,
                                  .direction = trial == 3 ? NULL : &s->up,
                                  .placement = {.border = {KN_BORDER_CLIP, KN_BORDER_CLIP}},
                                  .crossing_tol = trial == 2 ? 2e-2 : 0.0,
                                  .crossing = trial < 2    ? KN_CROSSING_REFUSE
                                              : trial == 2 ? KN_CROSSING_APPROXIMATE
                                                           : KN_CROSSING_TRIM};
        run(s, &o);
        double area = 0.0, want = 0.0;
        for (size_t i = 0; i < s->n; i++) {
            double size[2] = {1.0, 1.0};
            kn_bezier d = {0};
            kn_patch_place place;
            assert_int_equal(kn_job_source(s->ctx, &d, &place, s->job, &s->list[i].id), KN_OK);
            if (trial != 2) check_patch(s, &s->list[i], &d, &place, &rng, &values, &seen);
            for (int c = 0; c < 2; c++) // of the part of the sheet: sides as d has them
                size[c] = hypot(d.coef[c == 0 ? 2 : 1] - d.coef[0], d.coef[4 + (c == 0 ? 2 : 1)] - d.coef[4]) /
                          hypot(side[c][0], side[c][1]);
            area += scene_trim_area(&s->list[i].trim) * size[0] * size[1] *
                    fabs(side[0][0] * side[1][1] - side[0][1] * side[1][0]);
            kn_bezier_clear(s->ctx, &d);
        }
        for (int cell = 0; cell < 9; cell++) {
            double p[4][2];
            for (int k = 0; k < 4; k++)
                for (int c = 0; c < 2; c++)
                    p[k][c] = corner[c] + (c == 0 ? cell / 3 : cell % 3) + (k == 1 || k == 2 ? side[0][c] : 0.0) +
                              (k >= 2 ? side[1][c] : 0.0);
            want += clipped_area((const double(*)[2])p, 4, 3.0);
        }
        // trims are off by 2^-8 at most, along less than 3 of each of some 30 lines; usually by far less
        assert_true(fabs(area - want) <= (trial == 0 ? 1e-3 : 0x1p-8 * 90));
        assert_true(s->report.crossing_error > 0.0 &&
                    s->report.crossing_error <= (trial == 2 ? 2e-2 : 1e-3 * s->report.cell_size));
        if (trial != 2) assert_true(values > 60 && seen > 60);
        end(s);
    }
}

// Where patches meet an end along a parameter line there is no trim, and no error; tiles in the middle are as ever.
static void along_parameter_lines(void **state)
{
    (void)state;
    scene *s = begin();
    make_flat(s->ctx, &s->base, 2.0);
    scene_strip(s->ctx, &s->tile); // from -0.25 to 1.25 in u
    kn_job_options o = {.count = {2, 2}, .height = 1, .placement = {.border = {KN_BORDER_CLIP, KN_BORDER_CLIP}}};
    run(s, &o);
    double least = INFINITY, most = -INFINITY;
    for (size_t i = 0; i < s->n; i++) {
        assert_int_equal(s->list[i].trim.nloops, 0);
        size_t n = kn_bezier_count(&s->list[i].b);
        for (size_t k = 0; k < n; k++) {
            least = fmin(least, s->list[i].b.coef[k]);
            most = fmax(most, s->list[i].b.coef[k]);
        }
    }
    // in each row two strips of 1.25: cut off at the end, and on over the neighbour in two pieces
    assert_true(least == 0.0 && most == 2.0 && s->n == 8 && s->report.crossing_error == 0.0);
    end(s);
}

// A cubic ends on the end of the base, and a volume is refused with its name.
static void curves_and_volumes(void **state)
{
    (void)state;
    scene *s = begin();
    make_flat(s->ctx, &s->base, 1.0);
    make_up(s->ctx, &s->up);
    const double cubic[12] = {-0.3, 0.9, 0.4, 1.2, 0.5, 2.5, -1.5, 0.5, 0.0, 0.3, 0.2, 0.6};
    add_part(s->ctx, &s->tile, 1, (int[]){3}, cubic);
    kn_job_options o = {.count = {1, 1}, .height = 0.2, .placement = {.border = {KN_BORDER_CLIP, KN_BORDER_CLIP}}};
    run(s, &o);
    kn_bezier whole = {.nvars = 1, .ncomp = 3, .degree = {3}, .coef = (double[12]){0}};
    memcpy(whole.coef, cubic, sizeof cubic);
    double length = 0.0, want = 0.0; // in the parameter: by counting, to a thousandth
    for (int k = 0; k < 1000; k++) {
        double p[3], at = (k + 0.5) / 1000;
        assert_int_equal(kn_bezier_eval(s->ctx, p, &whole, &at), KN_OK);
        want += p[0] >= 0.0 && p[0] <= 1.0 && p[1] >= 0.0 && p[1] <= 1.0 ? 1e-3 : 0.0;
    }
    int on = 0;
    for (size_t i = 0; i < s->n; i++) {
        kn_bezier d = {0};
        kn_patch_place place;
        assert_int_equal(kn_job_source(s->ctx, &d, &place, s->job, &s->list[i].id), KN_OK);
        const kn_bezier *b = &s->list[i].b;
        size_t n = kn_bezier_count(b);
        for (int e = 0; e < 2; e++)
            for (size_t c = 0; c < 2; c++) {
                double x = b->coef[c * n + (size_t)e * (n - 1)];
                assert_true(x >= -1e-12 && x <= 1.0 + 1e-12); // the root, and the restriction to it
                on += fabs(x) <= 1e-12 || fabs(x - 1.0) <= 1e-12;
            }
        // the third difference of u is the whole one's times the cube of the part
        double third = -d.coef[0] + 3 * d.coef[1] - 3 * d.coef[2] + d.coef[3], all = 0.3 + 3 * 0.9 - 3 * 0.4 + 1.2;
        length += cbrt(third / all);
        kn_bezier_clear(s->ctx, &d);
    }
    // three parts, each from end to end, one of them halved at r = 1/2 by what looks for parameter lines
    assert_true(s->n == 4 && on == 6 && fabs(length - want) <= 1e-2);
    end(s);

    s = begin();
    make_flat(s->ctx, &s->base, 2.0);
    double box[24];
    for (int k = 0; k < 8; k++) {
        box[k] = 0.6 + 0.5 * (k / 4) - 0.3 * (k / 2 % 2);
        box[8 + k] = 0.2 + 0.3 * (k / 4) + 0.5 * (k / 2 % 2);
        box[16 + k] = k % 2;
    }
    add_part(s->ctx, &s->tile, 3, (int[]){1, 1, 1}, box);
    o.count[0] = o.count[1] = 2;
    assert_int_equal(kn_job_create(s->ctx, &s->job, &s->base, 1, &s->tile, &o), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(s->ctx), "volumes cannot be trimmed; --border extend"));
    end(s);
}

// ---- meshes ----

// An octahedron, closed, with its middle near a corner of the base.
static void make_octahedron(kn_ctx *ctx, kn_tile *tile)
{
    double at[6][3] = {{1.1, 0.2, 0.5},  {0.3, 0.9, 0.5}, {-0.5, 0.3, 0.5},
                       {0.4, -0.6, 0.5}, {0.3, 0.2, 1.0}, {0.3, 0.2, 0.0}};
    uint32_t face[24] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5};
    kn_mesh mesh = {.nvertices = 6, .ntriangles = 8};
    mesh.position = &at[0][0];
    mesh.triangle = face;
    assert_int_equal(kn_tile_init(ctx, tile, "octahedron", 1), KN_OK);
    assert_int_equal(kn_tile_set_mesh(ctx, tile, 0, &mesh), KN_OK);
}

// How many triangles have the edge from a to b, either way; *on: it lies on an end of the plane.
static int uses_of_edge(const kn_mesh *m, uint32_t a, uint32_t b, double size, bool *on)
{
    int uses = 0;
    for (size_t t = 0; t < m->ntriangles; t++)
        for (int k = 0; k < 3; k++) {
            uint32_t p = m->triangle[3 * t + (size_t)k], q = m->triangle[3 * t + (size_t)(k + 1) % 3];
            uses += (p == a && q == b) || (p == b && q == a);
        }
    *on = false;
    for (int c = 0; c < 2; c++) {
        double x = m->position[3 * a + (size_t)c], y = m->position[3 * b + (size_t)c];
        *on = *on || (x == y && (x == 0.0 || x == size));
    }
    return uses;
}

// On a plane of 2 x 2: nothing lies beyond, meshes are open along the ends alone, seen from above the upper half has
// the area of the clipped outline, and those inside are whole.
static void meshes(void **state)
{
    (void)state;
    scene *s = begin();
    make_flat(s->ctx, &s->base, 2.0);
    make_octahedron(s->ctx, &s->tile);
    const kn_job_options o = {
        .count = {2, 2}, .height = 0.5, .placement = {.border = {KN_BORDER_CLIP, KN_BORDER_CLIP}}};
    run(s, &o);
    assert_int_equal(s->n, 4);
    double area = 0.0, want = 0.0;
    for (size_t i = 0; i < s->n; i++) {
        const kn_mesh *m = &s->list[i].mesh;
        for (size_t v = 0; v < 3 * m->nvertices; v++)
            assert_true(v % 3 == 2 || (m->position[v] >= 0.0 && m->position[v] <= 2.0));
        for (size_t t = 0; t < m->ntriangles; t++) {
            const double *p[3];
            for (size_t k = 0; k < 3; k++) p[k] = m->position + 3 * (size_t)m->triangle[3 * t + k];
            double twice = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
            area += fmax(0.5 * twice, 0.0);
            for (size_t k = 0; k < 3; k++) {
                bool on;
                int uses = uses_of_edge(m, m->triangle[3 * t + k], m->triangle[3 * t + (k + 1) % 3], 2.0, &on);
                assert_true(uses == 2 || (uses == 1 && on));
            }
        }
        double p[4][2] = {{1.1, 0.2}, {0.3, 0.9}, {-0.5, 0.3}, {0.4, -0.6}};
        for (int k = 0; k < 4; k++) p[k][0] += s->list[i].id.cell[0], p[k][1] += s->list[i].id.cell[1];
        want += clipped_area((const double(*)[2])p, 4, 2.0);
    }
    assert_true(fabs(area - want) <= 1e-12); // some dozen roundings of numbers up to 2
    end(s);
}

// ---- extended borders ----

// A foot that turns fast beyond its end, as profiles of turned bodies do: what lies beyond needs a normal of its own,
// in all ways of crossing, and what lies inside is T.
static void beyond_a_foot(void **state)
{
    (void)state;
    test_rng rng = test_random(13);
    static const double radius[7] = {1.5, 1.75, 2.0, 2.0, 2.0, 1.5, 1.5},
                        z[7] = {2.4, 1.875, 1.35, 0.9, 0.45, 0.225, 0.15};
    static const double u[] = {0, 0, 0, 0, 1, 1, 1, 1}, v[] = {0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2};
    for (kn_job_crossing way = KN_CROSSING_TRIM; way <= KN_CROSSING_APPROXIMATE; way++)
        for (int clip = 0; clip < 2; clip++) {
            scene *s = begin();
            size_t values = 0, seen = 0;
            double coef[84], arc[2][4] = {{1, 1, 0.55, 0}, {0, 0.55, 1, 1}};
            for (int i = 0; i < 28; i++) {
                for (int c = 0; c < 2; c++) coef[28 * c + i] = arc[c][i / 7] * radius[i % 7];
                coef[56 + i] = z[i % 7];
            }
            const double *knots[2] = {u, v};
            assert_int_equal(kn_spline_init(s->ctx, &s->base, 2, 3, false, (int[]){3, 3}, (int[]){4, 7}, knots, coef),
                             KN_OK);
            make_sheet(s->ctx, &s->tile);
            kn_job_options o = {.count = {2, 8}, .height = 0.05, .crossing = way};
            if (clip) o.placement.border[0] = o.placement.border[1] = KN_BORDER_CLIP;
            o.select.first = 7, o.select.count = 1; // the last cell of the first column
            run(s, &o);
            assert_true(s->n > 0);
            for (size_t i = 0; i < s->n && clip && way == KN_CROSSING_TRIM; i++) {
                kn_bezier d = {0};
                kn_patch_place place;
                assert_int_equal(kn_job_source(s->ctx, &d, &place, s->job, &s->list[i].id), KN_OK);
                check_patch(s, &s->list[i], &d, &place, &rng, &values, &seen);
                kn_bezier_clear(s->ctx, &d);
            }
            if (clip && way == KN_CROSSING_TRIM) assert_true(values > 20 && seen > 20);
            end(s);
        }
}

// ---- failures ----

static void clipped(kn_ctx *safe, kn_spline *base, kn_tile *tile)
{
    make_flat(safe, base, 1.0);
    make_octahedron(safe, tile);
    make_sheet(safe, tile);
}

static kn_status clips(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_job_options o = {.count = {1, 1}, .height = 0.5, .placement = {.border = {KN_BORDER_CLIP, KN_BORDER_CLIP}}};
    return scene_try_job(ctx, clipped, &o);
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(clips, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(surfaces),           cmocka_unit_test(along_parameter_lines),
                                       cmocka_unit_test(curves_and_volumes), cmocka_unit_test(meshes),
                                       cmocka_unit_test(beyond_a_foot),      cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("job/border", tests, NULL, NULL);
}
