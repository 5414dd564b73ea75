// SPDX-License-Identifier: Apache-2.0
// Colours by a field, against the field at the middle of each cell, and against the job without them.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include "job/looks.h"
#include "job/run.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { NU = 9, NV = 6, SURFACES = 2 };

static const double warm[3][3] = {{0.25, 0, 0.125}, {1, 0.5, 0}, {1, 1, 0.75}};

// Two parts, a plate and a bump beside it, each one bilinear patch.
static void make_pair(kn_ctx *ctx, kn_tile *out)
{
    static const double coef[2][12] = {{0.1, 0.1, 0.9, 0.9, 0.1, 0.4, 0.1, 0.4, 0.2, 0.5, 0.7, 1},
                                       {0.1, 0.1, 0.9, 0.9, 0.6, 0.9, 0.6, 0.9, 0, 0.5, 0.25, 0}};
    const int degree[2] = {1, 1};
    assert_int_equal(kn_tile_init(ctx, out, "pair", 2), KN_OK);
    for (int p = 0; p < 2; p++) {
        kn_bezier b = {0};
        kn_spline s = {0};
        strcpy(out->parts[p].name, p == 0 ? "plate" : "bump");
        out->parts[p].material = (kn_material){{0.5, 0.25, 0.125 * p}, 0.5 * p, 0.75};
        assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
        memcpy(b.coef, coef[p], sizeof coef[p]);
        assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
        assert_int_equal(kn_tile_add(ctx, out, p, &s), KN_OK);
        kn_bezier_clear(ctx, &b);
        kn_spline_clear(ctx, &s);
    }
}

typedef struct setting {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline base[SURFACES], up;
    kn_tile tile;
    kn_job_color color[3];
    kn_job_options o;
} setting;

static void begin(setting *s, int threads)
{
    *s = (setting){.memory = TEST_MEMORY_INIT,
                   .o = {.count = {NU, NV}, .height = 0.1, .normal_tol = 1e-3, .spacing = KN_CELLS_UNIFORM}};
    s->ctx = test_ctx(&s->memory, threads);
    scene_spline(s->ctx, &s->base[0]);
    scene_bicubic(s->ctx, &s->base[1], 0.3);
    static const double line[4] = {0, 0, 1, 1}, z[12] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1};
    const double *const both[2] = {line, line};
    assert_int_equal(kn_spline_init(s->ctx, &s->up, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, both, z),
                     KN_OK);
    make_pair(s->ctx, &s->tile);
    s->o.color = s->color;
}

static void end(setting *s)
{
    kn_tile_clear(s->ctx, &s->tile);
    kn_spline_clear(s->ctx, &s->up);
    for (int i = 0; i < SURFACES; i++) kn_spline_clear(s->ctx, &s->base[i]);
    test_ctx_end(s->ctx, &s->memory);
}

static kn_job *make_job(setting *s)
{
    kn_job *job = NULL;
    if (kn_job_create(s->ctx, &job, s->base, SURFACES, &s->tile, &s->o) != KN_OK)
        fail_msg("%s", kn_ctx_message(s->ctx));
    return job;
}

// From below 0 to above 1.
static double wave(const void *user, const kn_place *place)
{
    const double *k = user;
    return 0.5 + k[0] * sin(5 * place->point[0] + place->point[1]) + k[1] * (place->uv[0] - place->uv[1]);
}

static double by_surface(const void *user, const kn_place *place)
{
    (void)user;
    return place->surface == 0 ? 0.0 : 0.5 * (1.0 + place->normal[2]);
}

// Where S(u,v) is at the middle of a cell, found from the cell's lines; uv in [0,1]^2.
static kn_place middle_of(kn_ctx *ctx, const kn_job *job, const kn_patch_id *id)
{
    kn_place place = {.surface = id->surface};
    const kn_spline *base = kn_shell_surface(kn_job_shell(job, id->surface));
    double at[2], lo, hi;
    for (int d = 0; d < 2; d++) {
        at[d] = (double)scene_parameter(job, id->surface, d, id->cell[d] + 0.5L);
        kn_spline_domain(base, d, &lo, &hi);
        place.uv[d] = (at[d] - lo) / (hi - lo);
    }
    assert_int_equal(kn_spline_eval(ctx, place.point, base, at), KN_OK);
    return place;
}

// The step of n that a value has; where rounding (some ten operations on numbers up to 10) may decide, `other` too.
static int step_of(int *other, double value, int n)
{
    double x = fmin(fmax(value, 0.0), 1.0) * n, slack = 1000 * DBL_EPSILON * n;
    *other = (int)fmin(floor(x + slack), n - 1);
    return (int)fmin(floor(fmax(x - slack, 0)), n - 1);
}

static void each_cell_by_the_field_at_its_middle(void **state)
{
    (void)state;
    static const double size[2] = {0.6, 0.2};
    setting s;
    scene_result r = {0};
    bool used[7] = {false};
    begin(&s, 2);
    s.color[0] = (kn_job_color){NULL, {wave, size, KN_NEEDS_POINT}, warm, 3, 7};
    s.o.ncolor = 1;
    kn_job *job = make_job(&s);
    scene_run(s.ctx, job, &r);
    assert_int_equal(r.count, SURFACES * NU * NV * 2);
    for (size_t i = 0; i < r.count; i++) {
        const kn_patch *p = &r.patches[i];
        kn_place place = middle_of(s.ctx, job, &p->id);
        int other, step = step_of(&other, wave(size, &place), 7), got = p->look - 7 * p->id.part;
        assert_true(got == step || got == other);
        used[got] = true;
    }
    for (int k = 0; k < 7; k++) assert_true(used[k]);
    scene_result_clear(&r);
    kn_job_destroy(s.ctx, job);
    end(&s);
}

// The colours of steps are those of the palette where they are as many, and lie between them in equal shares else.
static void looks_of_parts(void **state)
{
    (void)state;
    setting s;
    begin(&s, 1);
    s.color[0] = (kn_job_color){"plate", {by_surface, NULL, KN_NEEDS_NORMAL}, warm, 3, 0};
    s.color[1] = (kn_job_color){NULL, {by_surface, NULL, KN_NEEDS_NORMAL}, warm, 3, 3};
    s.color[2] = (kn_job_color){"bump", {by_surface, NULL, KN_NEEDS_NORMAL}, warm, 2, 5};
    s.o.ncolor = 1;
    kn_job *job = make_job(&s);
    const kn_tile *looks = kn_job_look_tile(job);
    assert_int_equal(looks->nparts, 16 + 1);
    assert_string_equal(looks->parts[9].name, "plate.09");
    assert_string_equal(looks->parts[16].name, "bump"); // as it is
    assert_memory_equal(&looks->parts[16].material, &s.tile.parts[1].material, sizeof(kn_material));
    for (int k = 0; k < 16; k++) {
        const kn_material *m = &looks->parts[k].material;
        assert_true(m->metallic == s.tile.parts[0].material.metallic && m->roughness == 0.75);
        for (int c = 0; c < 3; c++) { // the exact value times 15, from small fractions; then three roundings
            int at = 2 * k, i = at >= 15 ? 1 : 0;
            double want = ((15 * (i + 1) - at) * warm[i][c] + (at - 15 * i) * warm[i + 1][c]) / 15;
            assert_true(fabs(m->base_color[c] - want) <= 4 * DBL_EPSILON);
        }
    }
    kn_job_destroy(s.ctx, job);

    s.o.ncolor = 2; // of two rules the last one holds
    job = make_job(&s);
    looks = kn_job_look_tile(job);
    assert_int_equal(looks->nparts, 6);
    for (int k = 0; k < 6; k++) assert_memory_equal(looks->parts[k].material.base_color, warm[k % 3], sizeof warm[0]);
    assert_string_equal(looks->parts[5].name, "bump.02");
    kn_job_destroy(s.ctx, job);
    s.o.ncolor = 3;
    job = make_job(&s);
    scene_result r = {0};
    scene_run(s.ctx, job, &r);
    assert_int_equal(kn_job_look_tile(job)->nparts, 3 + 5);
    for (size_t i = 0; i < r.count; i++) // nothing but the first step on surface 0, nothing of it where n_z > 0
        assert_true((r.patches[i].look == (r.patches[i].id.part == 0 ? 0 : 3)) == (r.patches[i].id.surface == 0));
    scene_result_clear(&r);
    kn_job_destroy(s.ctx, job);

    s.o.ncolor = 0;
    job = make_job(&s);
    assert_ptr_equal(kn_job_look_tile(job), kn_job_tile(job));
    kn_job_destroy(s.ctx, job);
    end(&s);
}

static void same_patches(const scene_result *a, const scene_result *b, bool looks)
{
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; i++) {
        const kn_patch *p = &a->patches[i], *q = &b->patches[i];
        assert_memory_equal(&p->id, &q->id, sizeof p->id);
        if (looks) assert_int_equal(p->look, q->look);
        assert_memory_equal(p->bezier.coef, q->bezier.coef,
                            (size_t)p->bezier.ncomp * kn_bezier_count(&p->bezier) * sizeof(double));
    }
}

// Cells that differ in colour alone are planned and composed as before; the same for any number of threads.
static void composed_as_without(void **state)
{
    (void)state;
    static const double size[2] = {0.3, 0.5};
    for (int own = 0; own < 2; own++) {
        setting s;
        scene_result r[3] = {{0}};
        size_t keys[3], lists[3], cells[3];
        for (int k = 0; k < 3; k++) {
            begin(&s, k == 1 ? 1 : 2);
            s.color[0] = (kn_job_color){"bump", {wave, size, KN_NEEDS_POINT}, warm, 3, 0};
            const kn_job_vary vary = {"height", {wave, size, KN_NEEDS_POINT}};
            s.o.ncolor = k > 0;
            s.o.vary = own ? &vary : NULL;
            s.o.nvary = own;
            kn_job *job = make_job(&s);
            scene_run(s.ctx, job, &r[k]);
            keys[k] = job->keys.count, lists[k] = job->lists.count, cells[k] = job->nalike;
            kn_job_destroy(s.ctx, job);
            end(&s);
        }
        same_patches(&r[0], &r[1], false);
        same_patches(&r[1], &r[2], true);
        for (int k = 1; k < 3; k++) assert_true(keys[k] == keys[0] && lists[k] == lists[0] && cells[k] == cells[0]);
        for (int k = 0; k < 3; k++) scene_result_clear(&r[k]);
    }
}

typedef struct seen {
    scene_result result; // first: what scene's sink has
    kn_tile_part part[8];
    int nparts;
} seen;

static kn_status note_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)ctx, (void)report;
    seen *s = user;
    s->result.begun++;
    s->nparts = tile->nparts;
    for (int p = 0; p < tile->nparts && p < 8; p++) s->part[p] = tile->parts[p];
    return KN_OK;
}

// Layers count looks on, and sinks see all of them.
static void looks_of_layers(void **state)
{
    (void)state;
    static const double size[2] = {0.5, 0};
    setting s;
    seen all = {0};
    scene_result one = {0};
    begin(&s, 2);
    s.color[0] = (kn_job_color){"plate", {wave, size, KN_NEEDS_POINT}, warm, 3, 2};
    s.o.ncolor = 1;
    kn_job *job = make_job(&s);
    const kn_job *const layers[2] = {job, job};
    kn_sink sink = scene_sink(&all.result);
    sink.begin = note_begin;
    assert_int_equal(kn_job_run_layers(s.ctx, layers, 2, &sink, 1), KN_OK);
    kn_sink_close(s.ctx, &sink);
    scene_run(s.ctx, job, &one);
    assert_int_equal(all.nparts, 6);
    assert_string_equal(all.part[1].name, "plate.01");
    assert_string_not_equal(all.part[4].name, "plate.01"); // taken
    assert_memory_equal(all.part[4].material.base_color, warm[2], sizeof warm[2]);
    assert_int_equal(all.result.count, 2 * one.count);
    for (size_t i = 0; i < all.result.count; i++)
        assert_int_equal(all.result.patches[i].look, one.patches[i % one.count].look + (i < one.count ? 0 : 3));
    scene_result_clear(&one);
    scene_result_clear(&all.result);
    kn_job_destroy(s.ctx, job);
    end(&s);
}

static double nothing(const void *user, const kn_place *place)
{
    (void)user;
    return place->uv[0] > 0.5 ? NAN : 0.5;
}

static void failures(void **state)
{
    (void)state;
    static const double bad[1][3] = {{0, 1.5, 0}}, worse[1][3] = {{0, NAN, 0}};
    setting s;
    begin(&s, 1);
    const kn_field field = {by_surface, NULL, KN_NEEDS_NORMAL};
    const struct {
        kn_job_color color;
        kn_status status;
        const char *says;
    } cases[] = {{{"lid", field, warm, 3, 0}, KN_EDOMAIN, "\"lid\""},
                 {{NULL, {NULL, NULL, 0}, warm, 3, 0}, KN_EDOMAIN, "no field"},
                 {{NULL, field, NULL, 3, 0}, KN_EDOMAIN, "palette"},
                 {{NULL, field, warm, 0, 0}, KN_EDOMAIN, "palette"},
                 {{NULL, field, warm, 3, -1}, KN_EDOMAIN, "steps"},
                 {{NULL, field, warm, 3, 257}, KN_ELIMIT, "257"},
                 {{NULL, field, bad, 1, 0}, KN_EDOMAIN, "1.5"},
                 {{NULL, field, worse, 1, 0}, KN_EDOMAIN, "nan"}};
    kn_job *job = NULL;
    s.o.ncolor = 1;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        s.color[0] = cases[i].color;
        assert_int_equal(kn_job_create(s.ctx, &job, s.base, SURFACES, &s.tile, &s.o), cases[i].status);
        assert_non_null(strstr(kn_ctx_message(s.ctx), cases[i].says));
        assert_null(job);
        kn_ctx_clear_error(s.ctx);
    }
    s.color[0] = (kn_job_color){NULL, field, warm, 3, 256};
    s.o.ncolor = -1;
    assert_int_equal(kn_job_create(s.ctx, &job, s.base, SURFACES, &s.tile, &s.o), KN_EDOMAIN);
    s.o.ncolor = 1, s.o.color = NULL;
    assert_int_equal(kn_job_create(s.ctx, &job, s.base, SURFACES, &s.tile, &s.o), KN_EDOMAIN);
    s.o.color = s.color;
    kn_ctx_clear_error(s.ctx);

    s.color[0] = (kn_job_color){NULL, {nothing, NULL, 0}, warm, 3, 0};
    scene_result r = {0};
    kn_sink sink = scene_sink(&r);
    job = make_job(&s);
    assert_int_equal(kn_job_run(s.ctx, job, &sink, 1), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(s.ctx), "colour"));
    assert_int_equal(r.ended, 0);
    kn_sink_close(s.ctx, &sink);
    scene_result_clear(&r);
    kn_job_destroy(s.ctx, job);
    kn_ctx_clear_error(s.ctx);
    end(&s);
}

// A run is not gone on with in other colours.
static void identity(void **state)
{
    (void)state;
    uint64_t id[4];
    for (int k = 0; k < 4; k++) {
        setting s;
        begin(&s, 1);
        s.color[0] = (kn_job_color){NULL, {by_surface, NULL, KN_NEEDS_NORMAL}, warm, k == 1 ? 2 : 3, k == 2 ? 8 : 0};
        s.o.ncolor = k < 3;
        kn_job *job = make_job(&s);
        id[k] = kn_job_identity(job, 0);
        for (int i = 0; i < k; i++) assert_true(id[i] != id[k]);
        kn_job_destroy(s.ctx, job);
        end(&s);
    }
}

static kn_status create_and_run(kn_ctx *ctx, void *user)
{
    const setting *s = user;
    kn_job *job = NULL;
    kn_job_options o = s->o;
    o.direction = &s->up; // in the normal's place: there is nothing to fit
    o.count[0] = 1, o.count[1] = 2;
    kn_sink sink = {0};
    kn_status status = kn_job_create(ctx, &job, &s->base[1], 1, &s->tile, &o);
    if (status == KN_OK) {
        scene_result r = {0};
        sink = scene_sink(&r);
        status = kn_job_run(ctx, job, &sink, 1);
        assert_true(status != KN_OK || r.count == 4);
        kn_sink_close(ctx, &sink);
        scene_result_clear(&r);
    } else
        assert_null(job);
    kn_job_destroy(ctx, job);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    static const double size[2] = {0.5, 0.5};
    setting s;
    begin(&s, 1);
    s.color[0] = (kn_job_color){"bump", {wave, size, KN_NEEDS_POINT}, warm, 3, 0};
    s.o.ncolor = 1;
    test_allocation_failures(create_and_run, &s);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_cell_by_the_field_at_its_middle),
        cmocka_unit_test(looks_of_parts),
        cmocka_unit_test(composed_as_without),
        cmocka_unit_test(looks_of_layers),
        cmocka_unit_test(failures),
        cmocka_unit_test(identity),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("job/color", tests, NULL, NULL);
}
