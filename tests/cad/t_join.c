// SPDX-License-Identifier: Apache-2.0
// Faces that become one domain: sides bit for bit the same, moves no larger than what is said, and a texture over
// them whose patches share their edges.
#include "tests/support/support.h"

#include "kernel/context.h"
#include "tests/support/scene.h"

#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FACES = 3 };
static const double quarter = 1.5707963267948966;

// A model by hand: each face is the whole of its surface, its sides are edges of their own until they are linked.
typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_cad cad;
    kn_cad_joined joined;
} scene;

static void begin(scene *s)
{
    *s = (scene){.memory = TEST_MEMORY_INIT};
    s->ctx = test_ctx(&s->memory, 2);
    s->cad.faces = kn_alloc_zero(s->ctx, FACES, sizeof *s->cad.faces);
    s->cad.edges = kn_alloc_zero(s->ctx, (size_t)4 * FACES, sizeof *s->cad.edges);
    s->cad.bodies = kn_alloc_zero(s->ctx, 1, sizeof *s->cad.bodies);
    s->cad.nbodies = s->cad.bodies[0].instances = 1;
}

static void end(scene *s)
{
    kn_cad_joined_clear(s->ctx, &s->joined);
    kn_cad_clear(s->ctx, &s->cad);
    test_ctx_end(s->ctx, &s->memory);
}

// Curve k of a trim runs along this side; and the other way round.
static const int side_of_curve[4] = {2, 1, 3, 0}, curve_of_side[4] = {3, 1, 0, 2};

static void square(kn_ctx *ctx, kn_trim *trim)
{
    static const double x[5] = {0, 1, 1, 0, 0}, y[5] = {0, 0, 1, 1, 0}, knots[4] = {0, 0, 1, 1};
    trim->curves = kn_alloc_zero(ctx, 4, sizeof *trim->curves);
    trim->loop_end = kn_alloc(ctx, 1, sizeof *trim->loop_end);
    trim->loop_end[0] = trim->ncurves = 4;
    trim->nloops = 1;
    for (int k = 0; k < 4; k++) {
        const double coef[4] = {x[k], x[k + 1], y[k], y[k + 1]};
        assert_int_equal(kn_spline_init(ctx, &trim->curves[k], 1, 2, false, (const int[]){1}, (const int[]){2},
                                        (const double *const[]){knots}, coef),
                         KN_OK);
    }
}

// Takes the surface.
static int add_face(scene *s, kn_spline *surface)
{
    int f = s->cad.nfaces++;
    kn_cad_face *face = &s->cad.faces[f];
    kn_spline_swap(&face->surface, surface);
    square(s->ctx, &face->trim);
    face->whole = true;
    face->edge = kn_alloc(s->ctx, 4, sizeof *face->edge);
    for (int k = 0; k < 4; k++) {
        face->edge[k] = s->cad.nedges;
        s->cad.edges[s->cad.nedges++] = (kn_cad_edge){.face = {f, -1}, .curve = {k, 0}};
    }
    assert_int_equal(side_of_curve[curve_of_side[1]], 1);
    return f;
}

static int link(scene *s, int a, int side_a, int b, int side_b, double angle)
{
    int e = s->cad.faces[a].edge[curve_of_side[side_a]], old = s->cad.faces[b].edge[curve_of_side[side_b]];
    s->cad.edges[e].face[1] = b, s->cad.edges[e].curve[1] = curve_of_side[side_b];
    s->cad.edges[e].angle = angle;
    s->cad.faces[b].edge[curve_of_side[side_b]] = e;
    s->cad.nedges--; // the last one takes the free place
    if (old != s->cad.nedges) {
        kn_cad_edge *moved = &s->cad.edges[old];
        *moved = s->cad.edges[s->cad.nedges];
        for (int k = 0; k < 2; k++)
            if (moved->face[k] >= 0) s->cad.faces[moved->face[k]].edge[moved->curve[k]] = old;
    }
    return e == s->cad.nedges ? old : e;
}

// ---- surfaces ----

// About the z axis from `from` on, over `angle`, from z = 0 to 2; u runs around.
static void make_arc(kn_ctx *ctx, kn_spline *out, double from, double angle, double radius)
{
    kn_spline arc = {0};
    const double center[3] = {0, 0, 0}, x[3] = {radius * cos(from), radius * sin(from), 0},
                 y[3] = {-radius * sin(from), radius * cos(from), 0}, up[3] = {0, 0, 2};
    assert_int_equal(kn_construct_arc(ctx, &arc, center, x, y, angle), KN_OK);
    assert_int_equal(kn_construct_extruded(ctx, out, &arc, up), KN_OK);
    kn_spline_clear(ctx, &arc);
}

// The same surface with (u,v) turned by quarter turns; side[k] becomes where side k lies then.
static void turn(kn_ctx *ctx, kn_spline *s, int turns, int side[4])
{
    static const int next[4] = {2, 3, 1, 0}; // (u,v) -> (1 - v, u): u = 0 becomes v = 0, v = 0 becomes u = 1
    for (int k = 0; k < 4; k++) side[k] = k;
    for (int t = 0; t < turns; t++) {
        assert_int_equal(kn_spline_permute(ctx, s, s, (const int[]){1, 0}), KN_OK);
        assert_int_equal(kn_spline_reverse(ctx, s, s, 0), KN_OK);
        for (int k = 0; k < 4; k++) side[k] = next[side[k]];
    }
}

// z = 0 from x = -3 to 0 and y = 0 to 2, u along x; degree 1 in v, or 2 with its middle control point at `middle`.
static void make_flat(kn_ctx *ctx, kn_spline *out, double middle)
{
    static const double line[4] = {0, 0, 1, 1}, parabola[6] = {0, 0, 0, 1, 1, 1};
    const double coef[18] = {-3, -3, -3, 0, 0, 0, 0, middle, 2, 0, middle, 2, 0, 0, 0, 0, 0, 0};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[]){1, 2}, (const int[]){2, 3},
                                    (const double *const[]){line, parabola}, coef),
                     KN_OK);
}

// The fillet that goes on from there, down by a quarter turn about (0, y, -1); v along y, with a knot of its own.
static void make_fillet(kn_ctx *ctx, kn_spline *out)
{
    kn_spline arc = {0};
    const double center[3] = {0, 0, -1}, x[3] = {0, 0, 1}, y[3] = {1, 0, 0}, along[3] = {0, 2, 0}, knot = 0.3;
    assert_int_equal(kn_construct_arc(ctx, &arc, center, x, y, quarter), KN_OK);
    assert_int_equal(kn_construct_extruded(ctx, out, &arc, along), KN_OK);
    assert_int_equal(kn_spline_insert_knots(ctx, out, out, 1, &knot, 1), KN_OK);
    kn_spline_clear(ctx, &arc);
}

// ---- what must hold ----

static size_t row_point(const kn_spline *s, int side, int i)
{
    int at[2];
    at[side / 2] = side % 2 == 0 ? 0 : s->count[side / 2] - 1;
    at[1 - side / 2] = i;
    return (size_t)at[0] * (size_t)s->count[1] + (size_t)at[1];
}

static bool same_row(const kn_spline *a, int side_a, const kn_spline *b, int side_b, bool backward)
{
    int n = a->count[1 - side_a / 2], var[2] = {1 - side_a / 2, 1 - side_b / 2}, m = n + a->degree[var[0]] + 1;
    if (b->count[var[1]] != n || a->degree[var[0]] != b->degree[var[1]] || a->rational != b->rational) return false;
    for (int i = 0; i < n; i++)
        for (int c = 0; c < a->ncomp; c++) {
            double x = a->coef[(size_t)c * kn_spline_count(a) + row_point(a, side_a, i)];
            double y = b->coef[(size_t)c * kn_spline_count(b) + row_point(b, side_b, backward ? n - 1 - i : i)];
            if (x != y) return false;
        }
    for (int i = 0; i < m; i++) {
        double x = a->knots[var[0]][i], y = b->knots[var[1]][i];
        if (x != (backward ? 1 - b->knots[var[1]][m - 1 - i] : y)) return false;
    }
    return true;
}

// Farthest that the joined surface is from the face's own, over a grid, turned as it may be.
static double farthest_turned(kn_ctx *ctx, const kn_spline *a, const kn_spline *b, int turns)
{
    double most = 0;
    for (int i = 0; i <= 40; i++)
        for (int k = 0; k <= 40; k++) {
            double p[2][3], lo, hi, at[2];
            const kn_spline *s[2] = {a, b};
            for (int m = 0; m < 2; m++) {
                for (int v = 0; v < 2; v++) {
                    kn_spline_domain(s[m], v, &lo, &hi);
                    int x = v == 0 ? i : k, y = v == 0 ? k : i; // (x,y) -> (1 - y, x) and so on
                    if (m == 1 && turns % 2 == 1) x = y;
                    if (m == 1 && (turns == 2 || turns == (v == 0 ? 1 : 3))) x = 40 - x;
                    at[v] = lo + x / 40.0 * (hi - lo);
                }
                assert_int_equal(kn_spline_eval(ctx, p[m], s[m], at), KN_OK);
            }
            most = fmax(most, hypot(p[0][0] - p[1][0], hypot(p[0][1] - p[1][1], p[0][2] - p[1][2])));
        }
    return most;
}

static double farthest(kn_ctx *ctx, const kn_spline *a, const kn_spline *b)
{
    double least = INFINITY;
    for (int t = 0; t < 4; t++) least = fmin(least, farthest_turned(ctx, a, b, t));
    return least;
}

static void join(scene *s, const kn_cad_join_options *o)
{
    static const int faces[FACES] = {0, 1, 2};
    assert_int_equal(kn_cad_check(s->ctx, &s->cad), KN_OK);
    if (kn_cad_join(s->ctx, &s->joined, &s->cad, faces, s->cad.nfaces, o) != KN_OK)
        fail_msg("%s", kn_ctx_message(s->ctx));
    assert_int_equal(s->joined.n, s->cad.nfaces);
    for (int f = 0; f < s->joined.n; f++) {
        assert_int_equal(kn_spline_check(s->ctx, &s->joined.surfaces[f]), KN_OK);
        // roundings of elevation and knots beside the moves
        assert_true(farthest(s->ctx, &s->joined.surfaces[f], &s->cad.faces[f].surface) <= s->joined.moved + 1e-14);
    }
}

// Edges of patches that no other patch has, bit for bit, in either direction.
typedef struct edge_row {
    int n;
    double p[4 * 60];
} edge_row;

static int compare_rows(const void *a, const void *b)
{
    const edge_row *x = a, *y = b;
    return x->n != y->n ? x->n - y->n : memcmp(x->p, y->p, (size_t)x->n * sizeof *x->p);
}

static size_t open_edges(const scene_result *r)
{
    edge_row *rows = calloc(4 * r->count, sizeof *rows);
    assert_non_null(rows);
    size_t n = 0, open = 0;
    for (size_t k = 0; k < r->count; k++)
        for (int side = 0; side < 4; side++) {
            const kn_bezier *b = &r->patches[k].bezier;
            int var = side / 2, m = b->degree[1 - var] + 1, end = side % 2 == 0 ? 0 : b->degree[var];
            edge_row one = {.n = m * b->ncomp}, back = one;
            for (int i = 0; i < m; i++)
                for (int c = 0; c < b->ncomp; c++) {
                    size_t at = (size_t)c * kn_bezier_count(b) +
                                (size_t)(var == 0 ? end * (b->degree[1] + 1) + i : i * (b->degree[1] + 1) + end);
                    one.p[i * b->ncomp + c] = b->coef[at] + 0.0; // no -0
                    back.p[(m - 1 - i) * b->ncomp + c] = b->coef[at] + 0.0;
                }
            rows[n++] = compare_rows(&one, &back) < 0 ? one : back;
        }
    qsort(rows, n, sizeof *rows, compare_rows);
    for (size_t i = 0, k; i < n; i = k) {
        for (k = i + 1; k < n && compare_rows(&rows[i], &rows[k]) == 0;) k++;
        open += k - i == 1;
    }
    free(rows);
    return open;
}

// ---- tests ----

// A cylinder as two halves, the second turned in all four ways: a ring over both seams.
static void halves_make_a_ring(void **state)
{
    (void)state;
    for (int turns = 0; turns < 4; turns++) {
        scene s;
        int side[4];
        begin(&s);
        kn_spline half[2] = {{0}, {0}};
        make_arc(s.ctx, &half[0], 0, 2 * quarter, 1);
        make_arc(s.ctx, &half[1], 2 * quarter, 2 * quarter, 1);
        turn(s.ctx, &half[1], turns, side);
        add_face(&s, &half[0]), add_face(&s, &half[1]);
        link(&s, 0, 1, 1, side[0], 0), link(&s, 0, 0, 1, side[1], 0);
        join(&s, NULL);
        assert_int_equal(s.joined.nseams, 2);
        assert_true(s.joined.moved < 1e-14); // cos pi and sin pi
        const kn_spline *a = &s.joined.surfaces[0], *b = &s.joined.surfaces[1];
        for (int k = 0; k < 2; k++) {
            assert_true(s.joined.seams[k].joined);
            assert_null(s.joined.seams[k].why);
            assert_true(s.joined.seams[k].angle < 1e-7);
        }
        assert_true(same_row(a, 1, b, 0, false) && same_row(a, 0, b, 1, false)); // u goes on

        kn_tile tile = {0};
        kn_job *job = NULL;
        scene_result r = {0};
        scene_dome(s.ctx, &tile);
        const kn_job_options o = {.size = {0.4, 0.4}, .height = 0.1, .normal_tol = 1e-4, .max_degree = 40};
        if (kn_job_create(s.ctx, &job, s.joined.surfaces, 2, &tile, &o) != KN_OK)
            fail_msg("%s", kn_ctx_message(s.ctx));
        scene_run(s.ctx, job, &r);
        const double *rim = kn_job_lines(job, 0, 0);
        int cells[2], around = 0;
        for (int f = 0; f < 2; f++) {
            kn_shell_cells(kn_job_shell(job, f), cells);
            around += cells[0];
        }
        assert_non_null(rim);
        assert_int_equal(open_edges(&r), 2 * 2 * around); // two halves of a dome at both rims
        kn_job_destroy(s.ctx, job);
        kn_tile_clear(s.ctx, &tile);
        scene_result_clear(&r);
        end(&s);
    }
}

// What was moved is said, and limited.
static void moves_are_bounded(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        scene s;
        begin(&s);
        kn_spline half[2] = {{0}, {0}};
        make_arc(s.ctx, &half[0], 0, 2 * quarter, 10);
        make_arc(s.ctx, &half[1], 2 * quarter, 2 * quarter, 10);
        double by = k == 0 ? 5e-4 : 5e-3;
        half[1].coef[0] += by;                                                           // u = 0, v = 0: weight 1
        for (size_t i = 0; i < 4 * kn_spline_count(&half[1]); i++) half[1].coef[i] *= 3; // the same surface
        add_face(&s, &half[0]), add_face(&s, &half[1]);
        link(&s, 0, 1, 1, 0, 0), link(&s, 0, 0, 1, 1, 0);
        join(&s, NULL);
        assert_int_equal(s.joined.seams[0].joined + s.joined.seams[1].joined, k == 0 ? 2 : 1);
        for (int e = 0; e < 2; e++) {
            const kn_cad_seam *seam = &s.joined.seams[e];
            if (!seam->joined) assert_string_equal(seam->why, "parameter lines");
            assert_true(seam->moved <= s.joined.moved);
        }
        assert_true(s.joined.moved < (k == 0 ? 1.01 * by : 1e-13));
        if (k == 0) assert_true(s.joined.moved >= 0.99 * by);
        assert_true(same_row(&s.joined.surfaces[0], 1, &s.joined.surfaces[1], 0, false) == (k == 0));
        assert_true(same_row(&s.joined.surfaces[0], 0, &s.joined.surfaces[1], 1, false));
        end(&s);
    }
}

// A plane goes on into a fillet: it becomes rational, and gets the fillet's knot.
static void plane_and_fillet(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        scene s;
        begin(&s);
        kn_spline flat = {0}, fillet = {0};
        make_flat(s.ctx, &flat, k == 0 ? 1 : 0.8);
        make_fillet(s.ctx, &fillet);
        add_face(&s, &flat), add_face(&s, &fillet);
        link(&s, 0, 1, 1, 0, 0);
        join(&s, NULL);
        assert_int_equal(s.joined.nseams, 1);
        assert_true(s.joined.seams[0].joined == (k == 0));
        if (k == 1) assert_string_equal(s.joined.seams[0].why, "parameter lines"); // y is no affine function of v
        if (k == 0) {
            const kn_spline *a = &s.joined.surfaces[0], *b = &s.joined.surfaces[1];
            assert_true(same_row(a, 1, b, 0, false));
            assert_int_equal(b->degree[1], 2);
            assert_true(a->rational && a->count[1] == b->count[1] && a->degree[0] == 1);
        }
        end(&s);
    }
}

static void reasons(void **state)
{
    (void)state;
    static const char *const why[] = {"angle", "angle", "part of a side", "more faces", "a point", "not wanted"};
    for (int k = 0; k < 6; k++) {
        scene s;
        begin(&s);
        kn_spline flat = {0}, fillet = {0};
        make_flat(s.ctx, &flat, 1);
        if (k == 1) { // up instead: a right angle
            for (size_t i = 0; i < 3; i++) flat.coef[i] = 0;
            for (size_t i = 0; i < 3; i++) flat.coef[12 + i] = -3;
        }
        make_fillet(s.ctx, &fillet);
        add_face(&s, &flat), add_face(&s, &fillet);
        int e = link(&s, 0, 1, 1, 0, k == 0 ? 0.1 : 0);
        if (k == 2) { // a narrower one
            kn_trim *t = &s.cad.faces[0].trim;
            t->curves[0].coef[2] = t->curves[0].coef[3] = t->curves[1].coef[2] = 0.25;
            t->curves[3].coef[3] = 0.25;
            s.cad.faces[0].whole = false;
        }
        s.cad.edges[e].more = k == 3;
        s.cad.edges[e].point = k == 4;
        const kn_cad_join_options o = {.none = k == 5};
        join(&s, &o);
        assert_int_equal(s.joined.nseams, 1);
        assert_false(s.joined.seams[0].joined);
        assert_string_equal(s.joined.seams[0].why, why[k]);
        assert_int_equal(s.joined.trims[0].nloops, k == 2);
        for (int f = 0; f < 2; f++) // nothing was touched
            assert_memory_equal(s.joined.surfaces[f].coef, s.cad.faces[f].surface.coef,
                                kn_spline_count(&s.joined.surfaces[f]) * 3 * sizeof(double));
        end(&s);
    }
}

// A strip of two that comes back turned over: one of its edges stays apart.
static void turned_round(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    const double k[4] = {0, 0, 1, 1}, a[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0.1},
                 b[12] = {1, 1, 0, 0, 0, 1, 1, 0, 0, 0.1, 0, 0};
    const double *const coef[2] = {a, b};
    for (int f = 0; f < 2; f++) {
        kn_spline surface = {0};
        assert_int_equal(kn_spline_init(s.ctx, &surface, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2},
                                        (const double *const[]){k, k}, coef[f]),
                         KN_OK);
        add_face(&s, &surface);
    }
    link(&s, 0, 1, 1, 0, 0), link(&s, 0, 0, 1, 1, 0);
    const kn_cad_join_options o = {.angle = 3.2};
    join(&s, &o);
    assert_int_equal(s.joined.seams[0].joined + s.joined.seams[1].joined, 1);
    const kn_cad_seam *apart = &s.joined.seams[s.joined.seams[0].joined ? 1 : 0];
    assert_string_equal(apart->why, "turned round");
    end(&s);
}

static void bad_faces(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    kn_spline flat = {0};
    make_flat(s.ctx, &flat, 1);
    add_face(&s, &flat);
    const int none[1] = {1}, twice[2] = {0, 0}, one[1] = {0};
    const kn_cad_join_options bad = {.angle = NAN};
    assert_int_equal(kn_cad_join(s.ctx, &s.joined, &s.cad, none, 1, NULL), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(s.ctx), "no face 1"));
    kn_ctx_clear_error(s.ctx);
    assert_int_equal(kn_cad_join(s.ctx, &s.joined, &s.cad, twice, 2, NULL), KN_EDOMAIN);
    kn_ctx_clear_error(s.ctx);
    assert_int_equal(kn_cad_join(s.ctx, &s.joined, &s.cad, one, 0, NULL), KN_EDOMAIN);
    kn_ctx_clear_error(s.ctx);
    assert_int_equal(kn_cad_join(s.ctx, &s.joined, &s.cad, one, 1, &bad), KN_EDOMAIN);
    assert_int_equal(s.joined.n, 0);
    end(&s);
}

static kn_status starved(kn_ctx *ctx, void *user)
{
    static const int faces[2] = {0, 1};
    kn_cad_joined joined = {0};
    kn_status status = kn_cad_join(ctx, &joined, user, faces, 2, NULL);
    if (status != KN_OK) assert_int_equal(joined.n, 0);
    kn_cad_joined_clear(ctx, &joined);
    return status;
}

static void allocations(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    kn_spline flat = {0}, fillet = {0};
    make_flat(s.ctx, &flat, 1);
    make_fillet(s.ctx, &fillet);
    add_face(&s, &flat), add_face(&s, &fillet);
    link(&s, 0, 1, 1, 0, 0);
    test_allocation_failures(starved, &s.cad);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halves_make_a_ring), cmocka_unit_test(moves_are_bounded),
        cmocka_unit_test(plane_and_fillet),   cmocka_unit_test(reasons),
        cmocka_unit_test(turned_round),       cmocka_unit_test(bad_faces),
        cmocka_unit_test(allocations),
    };
    return cmocka_run_group_tests_name("cad/join", tests, NULL, NULL);
}
