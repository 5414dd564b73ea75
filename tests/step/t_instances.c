// SPDX-License-Identifier: Apache-2.0
// STEP files whose cells are instances of parts: which are found to be equal, and what cannot be a part.
#include "tests/support/patches.h"
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include <knurl/step.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int count(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = strstr(text, word); at != NULL; at = strstr(at + 1, word)) n++;
    return n;
}

// A tile on a base, to a file.
static kn_status write_file(kn_ctx *ctx, const char *path, const kn_spline *base, const kn_tile *tile,
                            const int cells[2], bool instances)
{
    kn_job *job = NULL;
    kn_sink sink = {0};
    kn_job_options options = {.count = {cells[0], cells[1]}};
    kn_status status = kn_job_create(ctx, &job, base, 1, tile, &options);
    if (status == KN_OK) status = kn_step_sink(ctx, &sink, path, &(kn_step_options){.instances = instances});
    if (status == KN_OK) status = kn_job_run(ctx, job, &sink, 1);
    if (sink.commit) kn_sink_close(ctx, &sink);
    kn_job_destroy(ctx, job);
    return status;
}

typedef struct scene {
    kn_ctx *ctx;
    kn_spline base;
    kn_tile tile;
    char path[TEST_PATH_BYTES];
} scene;

static void scene_make_of(scene *s, void (*base)(kn_ctx *, kn_spline *), void (*tile)(kn_ctx *, kn_tile *))
{
    *s = (scene){0};
    assert_int_equal(kn_ctx_create(&s->ctx, NULL), KN_OK);
    base(s->ctx, &s->base);
    tile(s->ctx, &s->tile);
    test_tmp_path(s->path, "instances.step");
}

static void scene_clear(scene *s)
{
    remove(s->path);
    kn_tile_clear(s->ctx, &s->tile);
    kn_spline_clear(s->ctx, &s->base);
    kn_ctx_destroy(s->ctx);
}

static void flat(kn_ctx *ctx, kn_spline *out)
{
    scene_multilinear(ctx, out, 2, (double[]){0, 0, 0, 0, 5, 0, 5, 0, 0, 5, 5, 0});
}

static void bent(kn_ctx *ctx, kn_spline *out)
{
    scene_bicubic(ctx, out, 0.4);
}

// On a plane all cells are one, shifted; on a cylinder of four quarters those that lie alike in them: two cells of a
// quarter are mirrored, and so two parts; elsewhere each cell is its own. In all of them there is one solid in a part.
static void parts(void **state)
{
    (void)state;
    static const struct {
        void (*base)(kn_ctx *, kn_spline *);
        int cells[2], parts;
    } cases[] = {{flat, {5, 5}, 1}, {scene_cylinder, {8, 3}, 2}, {scene_cylinder, {4, 2}, 1}, {bent, {2, 2}, 4}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        scene s;
        int n = cases[i].cells[0] * cases[i].cells[1];
        scene_make_of(&s, cases[i].base, scene_box);
        kn_status status = write_file(s.ctx, s.path, &s.base, &s.tile, cases[i].cells, true);
        assert_string_equal(kn_ctx_message(s.ctx), "");
        assert_int_equal(status, KN_OK);
        char *text = test_read_file(s.path, NULL);
        assert_int_equal(count(text, "=PRODUCT("), 1 + cases[i].parts);
        assert_int_equal(count(text, "=MANIFOLD_SOLID_BREP("), cases[i].parts);
        assert_int_equal(count(text, "=ADVANCED_BREP_SHAPE_REPRESENTATION("), cases[i].parts);
        assert_int_equal(count(text, "=ADVANCED_FACE("), 6 * cases[i].parts);
        assert_int_equal(count(text, "=NEXT_ASSEMBLY_USAGE_OCCURRENCE("), n);
        assert_int_equal(count(text, "=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION("), n);
        assert_int_equal(count(text, "SHELL_BASED_SURFACE_MODEL"), 0);
        free(text);
        scene_clear(&s);
    }
}

// A shift is written without a turn; 5 cells over a side of 5: whole numbers, up to a rounding of each.
static void shifts(void **state)
{
    (void)state;
    scene s;
    scene_make_of(&s, flat, scene_box);
    assert_int_equal(write_file(s.ctx, s.path, &s.base, &s.tile, (int[2]){5, 5}, true), KN_OK);
    char *text = test_read_file(s.path, NULL);
    int n = 0;
    for (const char *at = strstr(text, "=AXIS2"); at; at = strstr(at + 1, "=AXIS2")) n++;
    assert_int_equal(n, 1 + 25);
    assert_int_equal(count(text, "=DIRECTION('',(0.,0.,1.));"), 1 + 25);
    assert_int_equal(count(text, "=DIRECTION('',(1.,0.,0.));"), 1 + 25);
    free(text);
    scene_clear(&s);
}

static void equal_bytes(void **state)
{
    (void)state;
    scene s;
    size_t bytes[2];
    char *text[2];
    scene_make_of(&s, scene_cylinder, scene_box);
    for (int i = 0; i < 2; i++) {
        kn_ctx *ctx;
        assert_int_equal(kn_ctx_create(&ctx, &(kn_ctx_options){.threads = i == 0 ? 1 : 3}), KN_OK);
        assert_int_equal(write_file(ctx, s.path, &s.base, &s.tile, (int[2]){8, 6}, true), KN_OK);
        text[i] = test_read_file(s.path, &bytes[i]);
        kn_ctx_destroy(ctx);
    }
    assert_int_equal(bytes[0], bytes[1]);
    assert_memory_equal(text[0], text[1], bytes[0]);
    free(text[0]), free(text[1]);
    scene_clear(&s);
}

static void refusals(void **state)
{
    (void)state;
    scene s;
    kn_sink sink;
    scene_make_of(&s, flat, scene_dome);
    assert_int_equal(write_file(s.ctx, s.path, &s.base, &s.tile, (int[2]){2, 2}, true), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(s.ctx), "instances: surface 0, cell 0,0: its faces do not close a body"));
    assert_int_not_equal(access(s.path, F_OK), 0);
    kn_ctx_clear_error(s.ctx);
    kn_step_options options = {.instances = true, .schema = KN_STEP_AP203};
    assert_int_equal(kn_step_sink(s.ctx, &sink, s.path, &options), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(s.ctx), "AP203"));
    kn_ctx_clear_error(s.ctx);
    options.schema = KN_STEP_AP242; // no journal can be kept of it
    assert_int_equal(kn_step_sink(s.ctx, &sink, s.path, &options), KN_OK);
    assert_true(!sink.save && !sink.restore);
    kn_sink_close(s.ctx, &sink);
    scene_clear(&s);
}

// Two cells, composed before memory is short.
typedef struct cells {
    scene s;
    kn_job *job;
    scene_result r;
} cells;

static kn_status starved(kn_ctx *ctx, void *user)
{
    cells *c = user;
    kn_sink sink;
    kn_job_report report = kn_job_describe(c->job);
    kn_status status = kn_step_sink(ctx, &sink, c->s.path, &(kn_step_options){.instances = true});
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &c->s.tile, &report, c->r.patches, c->r.count, 1);
    kn_sink_close(ctx, &sink);
    return status;
}

static void without_memory(void **state)
{
    (void)state;
    cells c = {0};
    scene_make_of(&c.s, flat, scene_box);
    kn_job_options options = {.count = {2, 1}};
    assert_int_equal(kn_job_create(c.s.ctx, &c.job, &c.s.base, 1, &c.s.tile, &options), KN_OK);
    scene_run(c.s.ctx, c.job, &c.r);
    test_allocation_failures(starved, &c);
    scene_result_clear(&c.r);
    kn_job_destroy(c.s.ctx, c.job);
    scene_clear(&c.s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts),    cmocka_unit_test(shifts),         cmocka_unit_test(equal_bytes),
        cmocka_unit_test(refusals), cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("step/instances", tests, NULL, NULL);
}
