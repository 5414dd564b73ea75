// SPDX-License-Identifier: Apache-2.0
// Cells behind the object: what is dropped is looked for by rays, each against all triangles of what hides it.
#include "tests/support/support.h"

#include "tests/support/scene.h"
#include "tests/support/surfaces.h"

#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- tiles ----

// One that takes the base's place: 0 on the border of the cell.
static void make_roof(kn_ctx *ctx, kn_tile *out)
{
    scene_dome(ctx, out);
    out->covering = true;
}

// ---- views ----

typedef struct eye {
    double at[3];
    bool far;    // at is a direction
    double half; // of the picture's width, at distance 1 (or in space)
} eye;

// To the origin, z up.
static kn_job_view look_from(const eye *e)
{
    const double *at = e->at;
    kn_job_view v = {.pixels = {320, 240}, .hidden = true};
    double f[3], r[3], u[3], length = hypot(at[0], hypot(at[1], at[2]));
    for (int c = 0; c < 3; c++) f[c] = -at[c] / length;
    double flat = hypot(f[0], f[1]);
    r[0] = f[1] / flat, r[1] = -f[0] / flat, r[2] = 0;
    for (int c = 0; c < 3; c++) u[c] = r[(c + 1) % 3] * f[(c + 2) % 3] - r[(c + 2) % 3] * f[(c + 1) % 3];
    double *m = v.matrix;
    for (int c = 0; c < 3; c++) {
        m[c] = r[c] / e->half, m[4 + c] = u[c] / (0.75 * e->half);
        m[8 + c] = e->far ? 1e-3 * f[c] : 0, m[12 + c] = e->far ? 0 : f[c];
        for (int k = 0; k < 4 && !e->far; k++) m[4 * k + 3] -= m[4 * k + c] * at[c];
    }
    if (e->far) m[15] = 1;
    return v;
}

// ---- rays ----

static bool hits(const double p[3], const double d[3], const double *a, const double *b, const double *c)
{
    double e[3], g[3], s[3], h[3], q[3];
    for (int k = 0; k < 3; k++) e[k] = b[k] - a[k], g[k] = c[k] - a[k], s[k] = p[k] - a[k];
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        h[k] = d[i] * g[j] - d[j] * g[i];
        q[k] = s[i] * e[j] - s[j] * e[i];
    }
    double det = 0, x = 0, y = 0, t = 0;
    for (int k = 0; k < 3; k++) det += e[k] * h[k], x += s[k] * h[k], y += d[k] * q[k], t += g[k] * q[k];
    if (det == 0) return false;
    x /= det, y /= det, t /= det;
    return x >= 0 && y >= 0 && x + y <= 1 && t > 0 && t < 1;
}

// Whether something is between p and the eye.
static bool is_behind(const kn_mesh *m, const double p[3], const eye *e)
{
    double d[3];
    for (int c = 0; c < 3; c++) d[c] = e->far ? 100 * e->at[c] : e->at[c] - p[c];
    for (size_t i = 0; i < m->ntriangles; i++) {
        const uint32_t *v = m->triangle + 3 * i;
        if (hits(p, d, m->position + 3 * (size_t)v[0], m->position + 3 * (size_t)v[1],
                 m->position + 3 * (size_t)v[2]))
            return true;
    }
    return false;
}

static bool is_seen(const kn_job_view *v, const double p[3])
{
    double clip[4];
    for (int k = 0; k < 4; k++) {
        const double *m = v->matrix + 4 * k;
        clip[k] = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
    }
    for (int k = 0; k < 3; k++)
        if (fabs(clip[k]) > clip[3]) return false;
    return true;
}

// ---- scenes ----

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline *base;
    int n;
    kn_tile tile;
    kn_job_options o;
    kn_mesh stops;    // what stands in the way of rays
    scene_result all; // patches of all cells
} scene;

static kn_spline *add_base(scene *s)
{
    s->base = realloc(s->base, (size_t)(s->n + 1) * sizeof *s->base);
    assert_non_null(s->base);
    s->base[s->n] = (kn_spline){0};
    return &s->base[s->n++];
}

// The rectangle x = const, between two values of y and of z; turned: its normal is (-1,0,0).
static void add_wall(scene *s, double x, const double y[2], const double z[2], bool turned)
{
    const int a = turned, b = !turned; // y grows with u, z with v; turned the other way round
    const double coef[12] = {x, x, x, x, y[0], y[a], y[b], y[1], z[0], z[b], z[a], z[1]};
    const int degree[2] = {1, 1};
    kn_bezier flat = {0};
    assert_int_equal(kn_bezier_init(s->ctx, &flat, 2, 3, false, degree), KN_OK);
    memcpy(flat.coef, coef, sizeof coef);
    assert_int_equal(kn_spline_of_bezier(s->ctx, add_base(s), &flat), KN_OK);
    kn_bezier_clear(s->ctx, &flat);
}

// Triangles of the base, or of covering tiles.
static void prepare(scene *s)
{
    kn_job *job = NULL;
    s->o.select = (kn_job_selection){0};
    if (kn_job_create(s->ctx, &job, s->base, s->n, &s->tile, &s->o) != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    scene_run(s->ctx, job, &s->all);
    kn_job_destroy(s->ctx, job);
    for (size_t i = 0; s->tile.covering && i < s->all.count; i++)
        assert_int_equal(kn_patch_tessellate(s->ctx, &s->stops, &s->all.patches[i]), KN_OK);
    for (int i = 0; !s->tile.covering && i < s->n; i++) {
        kn_bezier *pieces = NULL;
        size_t n = 0;
        assert_int_equal(kn_spline_to_bezier(s->ctx, &pieces, &n, &s->base[i]), KN_OK);
        const int fine[3] = {n > 4 ? 12 : 24, n > 4 ? 12 : 24, 0};
        for (size_t k = 0; k < n; k++) {
            const kn_patch p = {.bezier = pieces[k], .segments = {fine[0], fine[1]}};
            assert_int_equal(kn_patch_tessellate(s->ctx, &s->stops, &p), KN_OK);
            kn_bezier_clear(s->ctx, &pieces[k]);
        }
        kn_free(s->ctx, pieces);
    }
}

static void begin(scene *s, void (*tile)(kn_ctx *, kn_tile *))
{
    *s = (scene){.memory = TEST_MEMORY_INIT, .o = {.normal_tol = 1e-2, .max_degree = 40}};
    s->ctx = test_ctx(&s->memory, 2);
    tile(s->ctx, &s->tile);
}

static void end(scene *s)
{
    for (int i = 0; i < s->n; i++) kn_spline_clear(s->ctx, &s->base[i]);
    free(s->base);
    kn_mesh_clear(s->ctx, &s->stops);
    scene_result_clear(&s->all);
    kn_tile_clear(s->ctx, &s->tile);
    test_ctx_end(s->ctx, &s->memory);
}

static bool has_cell(const scene_result *r, const kn_patch_id *id)
{
    for (size_t i = 0; i < r->count; i++)
        if (r->patches[i].id.surface == id->surface && r->patches[i].id.cell[0] == id->cell[0] &&
            r->patches[i].id.cell[1] == id->cell[1])
            return true;
    return false;
}

// Runs with the view; no point of what is dropped can be seen. How many patches of the first surface are dropped, and
// cells of all.
static size_t look(scene *s, const eye *e, size_t *cells)
{
    kn_job *job = NULL;
    scene_result part;
    kn_job_view view = look_from(e);
    s->o.select.view = &view;
    if (kn_job_create(s->ctx, &job, s->base, s->n, &s->tile, &s->o) != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    scene_run(s->ctx, job, &part);
    *cells = kn_job_describe(job).dropped[KN_DROP_HIDDEN];
    size_t dropped = 0;
    kn_job_destroy(s->ctx, job);
    for (size_t i = 0; i < s->all.count; i++) {
        const kn_patch *p = &s->all.patches[i];
        if (has_cell(&part, &p->id)) continue;
        dropped += p->id.surface == 0;
        if (i % 3 > 0) continue; // enough of them
        for (int j = 0; j < 5; j++) {
            static const double at[5][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0.5, 0.5}};
            double point[3];
            assert_int_equal(kn_bezier_eval(s->ctx, point, &p->bezier, at[j]), KN_OK);
            if (!is_seen(&view, point) || is_behind(&s->stops, point, e)) continue;
            fail_msg("cell %d,%d of surface %d is seen from %g, %g, %g", p->id.cell[0], p->id.cell[1], p->id.surface,
                     e->at[0], e->at[1], e->at[2]);
        }
    }
    scene_result_clear(&part);
    s->o.select.view = NULL;
    return dropped;
}

// ---- tests ----

// From all sides: what is dropped cannot be seen, and there is much of it.
static void behind_a_torus(void **state)
{
    (void)state;
    static const eye eyes[] = {
        {{11, 0, 2}, false, 0.45}, {{6, 7, 1}, false, 0.5}, {{5, 2, 2}, true, 5}, {{1, 0, 9}, false, 0.5}};
    for (int covering = 0; covering < 2; covering++) {
        scene s;
        begin(&s, covering ? make_roof : scene_plate);
        make_torus(s.ctx, add_base(&s));
        s.o.count[0] = 32, s.o.count[1] = 12, s.o.height = 0.1, s.o.mesh_tol = 0.5;
        prepare(&s);
        for (size_t k = 0; k < (covering ? 2 : sizeof eyes / sizeof *eyes); k++) {
            size_t hidden;
            (void)look(&s, &eyes[k], &hidden);
            if (hidden < 32 * 12 / 8) fail_msg("only %zu cells are hidden from eye %zu", hidden, k);
        }
        end(&s);
    }
}

static void behind_a_teapot(void **state)
{
    (void)state;
    static const eye eyes[] = {{{8, -6, 3}, false, 0.5}, {{-9, 1, 2}, false, 0.5}};
    scene s;
    begin(&s, scene_plate);
    for (int i = 0; i < TEAPOT_PATCHES; i++)
        if (!make_teapot(s.ctx, add_base(&s), i)) skip();
    s.o.count[0] = s.o.count[1] = 6, s.o.height = 0.05, s.o.mesh_tol = 0.05;
    prepare(&s);
    for (size_t k = 0; k < 2; k++) {
        size_t hidden;
        (void)look(&s, &eyes[k], &hidden);
        if (hidden < TEAPOT_PATCHES * 36 / 4) fail_msg("only %zu cells are hidden from eye %zu", hidden, k);
    }
    end(&s);
}

// A plane behind a wall, which is one-sided and looks either way, or of two parts that share an edge.
static void behind_a_wall(void **state)
{
    (void)state;
    const eye front = {{10, 0.3, 0.2}, false, 0.5}, afar = {{1, 0.05, 0.02}, true, 4},
              back = {{-10, 0.3, 0.2}, false, 0.5};
    const eye between = {{1, 0.1, 0.1}, false, 1};
    const double small[2] = {-1, 1}, wide[2] = {-2, 2}, left[2] = {-2, 0.1}, right[2] = {0.1, 2}, far[2] = {0.4, 2};
    for (int k = 0; k < 5; k++) {
        scene s;
        begin(&s, scene_plate);
        add_wall(&s, -1, small, small, false);
        add_wall(&s, 2, k < 2 ? wide : left, wide, k == 1);
        if (k >= 2) add_wall(&s, 2, k == 2 ? right : k == 3 ? far : right, wide, k == 4);
        s.o.count[0] = s.o.count[1] = 8, s.o.height = 0.1;
        prepare(&s);
        size_t cells, hidden = look(&s, &front, &cells), from_afar = look(&s, &afar, &cells);
        if (k == 3) { // through the gap
            assert_true(hidden > 0 && hidden < 64 && from_afar > 0 && from_afar < 64);
        } else {
            assert_int_equal(hidden, 64);
            assert_int_equal(from_afar, 64);
        }
        (void)look(&s, &back, &cells);
        assert_true(cells > 16);                         // the plane hides its own, and some of the wall's
        assert_int_equal(look(&s, &between, &cells), 0); // the wall is behind the eye
        end(&s);
    }
}

static double half_of_it(const void *user, const kn_place *place)
{
    (void)user;
    return place->uv[0] < 0.5;
}

// Holes of a covering tile are looked through; and below the base something is, or it would not be wanted.
static void what_stays(void **state)
{
    (void)state;
    const eye front = {{10, 0.3, 0.2}, false, 0.5};
    const double small[2] = {-1, 1}, wide[2] = {-2, 2};
    for (int k = 0; k < 4; k++) {
        scene s;
        bool looked_through = k == 1 || k == 2; // where the mask is not, or where cells are small
        begin(&s, k < 3 ? make_roof : scene_plate);
        add_wall(&s, -1, small, small, false);
        add_wall(&s, 2, wide, wide, false);
        s.o.count[0] = s.o.count[1] = 8, s.o.height = k < 3 ? 0.1 : -0.1, s.o.mesh_tol = 0.05;
        prepare(&s);
        if (k == 1) s.o.select.mask = (kn_field){half_of_it, NULL, 0};
        kn_mesh all = s.stops;
        if (looked_through) s.stops = (kn_mesh){0}; // dropped by the selection, not looked for
        if (looked_through) {
            kn_job *job = NULL;
            kn_job_view view = look_from(&front);
            if (k == 2) view.least_pixels = 1e-3;
            s.o.select.view = &view;
            assert_int_equal(kn_job_create(s.ctx, &job, s.base, s.n, &s.tile, &s.o), KN_OK);
            assert_int_equal(kn_job_describe(job).dropped[KN_DROP_HIDDEN], 0);
            kn_job_destroy(s.ctx, job);
        } else {
            size_t cells;
            assert_int_equal(look(&s, &front, &cells), k == 0 ? 4 * 64 : 0);
        }
        s.stops = all;
        end(&s);
    }
}

// ---- memory ----

static void under_diamonds(kn_ctx *safe, kn_spline *base, kn_tile *tile)
{
    scene_bicubic(safe, base, 0.1);
    scene_diamond(safe, tile);
}

static void under_roofs(kn_ctx *safe, kn_spline *base, kn_tile *tile)
{
    scene_bicubic(safe, base, 0.1);
    make_roof(safe, tile);
}

static kn_status occludes(kn_ctx *ctx, void *user)
{
    const bool *covering = user;
    const eye above = {{1, 1, 20}, false, 0.4};
    kn_job_view view = look_from(&above);
    view.pixels[0] = view.pixels[1] = 20;
    kn_job_options o = {.count = {1, 2}, .height = 0.1, .normal_tol = 1e-2, .select = {.view = &view}};
    return scene_try_job(ctx, *covering ? under_roofs : under_diamonds, &o);
}

static void allocation(void **state)
{
    (void)state;
    bool covering = false;
    test_allocation_failures(occludes, &covering);
    covering = true;
    test_allocation_failures(occludes, &covering);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(behind_a_torus), cmocka_unit_test(behind_a_teapot),
                                       cmocka_unit_test(behind_a_wall), cmocka_unit_test(what_stays),
                                       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("job/hidden", tests, NULL, NULL);
}
