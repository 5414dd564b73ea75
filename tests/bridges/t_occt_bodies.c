// SPDX-License-Identifier: Apache-2.0
// Bodies in STEP as Open CASCADE sees them: what is closed, counts, volumes, names, colours; and as gmsh meshes them.
#include "tests/support/host.h"
#include "tests/support/integral.h"
#include "tests/support/patches.h"
#include "tests/support/scene.h"
#include "tests/support/surfaces.h"

#include <knurl/step.h>

#if KN_WITH_OCCT
#include "bridges/occt/occt_check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int count(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = strstr(text, word); at != NULL; at = strstr(at + 1, word)) n++;
    return n;
}

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_tile tile;
    kn_spline base;
    char path[TEST_PATH_BYTES];
    char *text;
    test_integrals ours;
    kn_occt_model *model;
    kn_occt_report found;
} scene;

// A built-in tile over a square of the plane, through a file. limit: 0, or the degree of a kn_limit_sink.
static void make_scene(scene *s, const char *tile, int cells, const kn_step_options *step, int limit)
{
    *s = (scene){.memory = TEST_MEMORY_INIT};
    s->ctx = test_ctx(&s->memory, 0);
    test_tmp_path(s->path, "bodies.step");
    make_plane(s->ctx, &s->base);
    assert_int_equal(kn_builtin_tile(s->ctx, &s->tile, tile), KN_OK);
    kn_job *job = NULL;
    kn_job_options options = {.count = {cells, cells}};
    assert_int_equal(kn_job_create(s->ctx, &job, &s->base, 1, &s->tile, &options), KN_OK);
    kn_sink sinks[2] = {{0}, test_integral_sink(&s->ours)}, limited = {0};
    kn_limit_options limits = {.max_degree = limit, .tolerance = 1e-3};
    assert_int_equal(kn_step_sink(s->ctx, &sinks[0], s->path, step), KN_OK);
    if (limit > 0) assert_int_equal(kn_limit_sink(s->ctx, &limited, sinks, 2, &limits, NULL), KN_OK);
    kn_status status = limit > 0 ? kn_job_run(s->ctx, job, &limited, 1) : kn_job_run(s->ctx, job, sinks, 2);
    assert_string_equal(kn_ctx_message(s->ctx), "");
    assert_int_equal(status, KN_OK);
    kn_sink_close(s->ctx, limit > 0 ? &limited : &sinks[0]);
    kn_job_destroy(s->ctx, job);
    s->text = test_read_file(s->path, NULL);
    assert_non_null(s->text);
    assert_int_equal(kn_occt_open_step(s->ctx, &s->model, s->path), KN_OK);
    assert_int_equal(kn_occt_check(s->ctx, &s->found, s->model), KN_OK);
}

static void scene_clear(scene *s)
{
    free(s->text);
    kn_occt_close(s->ctx, s->model);
    remove(s->path);
    kn_tile_clear(s->ctx, &s->tile);
    kn_spline_clear(s->ctx, &s->base);
    test_ctx_end(s->ctx, &s->memory);
}

// All that was written is there again, valid, and what is called closed is closed. points: edges collapsed to points,
// which OCCT counts as edges of their own.
static void expect_found(const scene *s, int points)
{
    const kn_occt_report *r = &s->found;
    int shells = count(s->text, "=CLOSED_SHELL("), open = count(s->text, "=OPEN_SHELL(");
    assert_int_equal(r->faces, s->ours.faces);
    assert_int_equal(r->first_invalid, -1);
    assert_true(r->valid);
    assert_int_equal(r->edges, count(s->text, "=EDGE_CURVE(") + points);
    assert_int_equal(r->vertices, count(s->text, "=VERTEX_POINT("));
    assert_int_equal(r->closed_shells, shells);
    assert_int_equal(r->solids, shells);
    assert_int_equal(r->shells, shells + open);
    assert_true(r->max_tolerance <= 1e-3); // what the file states
}

// The quadrature is exact, with the rounding of some thousand terms; OCCT's own is about as good.
static void expect_volume(const scene *s)
{
    assert_int_equal(s->found.free_edges, 0);
    assert_true(fabs(s->found.volume - s->ours.volume) <= 1e-6 * s->ours.volume);
}

static void volumes_in_rows(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, "cross", 2, NULL, 0);
    expect_found(&s, 0);
    assert_int_equal(s.found.solids, 1);
    expect_volume(&s);
    assert_true(fabs(s.ours.volume - 1.171875) <= 1e-12); // struts and nodes are boxes
    assert_int_equal(s.found.ncolours, 1);
    scene_clear(&s);
}

// Closed bodies with edges that are points: OCCT finds the others' curves in the surfaces' parameters as they are told.
static void reliefs(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, "bird", 1, NULL, 0);
    expect_found(&s, 4);
    assert_int_equal(s.found.solids, 1);
    expect_volume(&s);
    scene_clear(&s);
}

// Rings of one cell are closed; links to neighbours that are not there are open.
static void rings(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, "chain", 1, NULL, 0);
    expect_found(&s, 0);
    assert_int_equal(s.found.faces, 48);
    assert_true(s.found.closed_shells >= 1 && s.found.free_edges > 0);
    assert_int_equal(s.found.ncolours, s.tile.nparts);
    scene_clear(&s);
}

// A sheet with sixteen collapsed edges at the tips of four thorns.
static void sheet_with_tips(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, "thorn", 2, NULL, 0);
    expect_found(&s, 16);
    assert_int_equal(s.found.shells, 1);
    assert_int_equal(s.found.closed_shells, 0);
    scene_clear(&s);
}

// Cubics in the place of high degrees: the same topology, closed where the exact one is, names that tell.
static void limited(void **state)
{
    (void)state;
    scene exact, cubic;
    make_scene(&exact, "chain", 1, NULL, 0);
    make_scene(&cubic, "chain", 1, NULL, 5);
    expect_found(&cubic, 0);
    assert_true(cubic.found.max_degree <= 5 && exact.found.max_degree > 5);
    assert_int_equal(cubic.found.edges, exact.found.edges);
    assert_int_equal(cubic.found.vertices, exact.found.vertices);
    assert_int_equal(cubic.found.solids, exact.found.solids);
    // within the tolerance everywhere: the shell of that thickness about the closed bodies
    assert_true(fabs(cubic.found.volume - exact.found.volume) <= 1e-3 * exact.found.area);
    assert_non_null(strstr(cubic.text, "degree limit 0.001"));
    scene_clear(&exact), scene_clear(&cubic);
}

static void schemas(void **state)
{
    (void)state;
    static const struct {
        kn_step_schema schema;
        const char *name;
    } cases[] = {{KN_STEP_AP214, "AUTOMOTIVE_DESIGN"},
                 {KN_STEP_AP242, "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF"},
                 {KN_STEP_AP203, "CONFIG_CONTROL_DESIGN"}};
    const char *names[] = {"Deckel \xc3\xa4"};
    for (int i = 0; i < 3; i++) {
        scene s;
        char name[64];
        make_scene(&s, "cross", 1,
                   &(kn_step_options){.schema = cases[i].schema, .surface_names = names, .nsurfaces = 1}, 0);
        expect_found(&s, 0);
        assert_int_equal(s.found.solids, 1);
        assert_int_equal(s.found.ncolours, 1);
        assert_non_null(strstr(s.text, cases[i].name));
        assert_int_equal(kn_occt_face_name(s.ctx, name, sizeof name, s.model, 0), KN_OK);
        assert_ptr_equal(strstr(name, "Deckel "), name);
        scene_clear(&s);
    }
}

// ---- instances ----

// 24 boxes round a cylinder, one by one or as instances of two (a quarter of the cylinder has two cells): the same
// solids in the same places.
static void instances(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_occt_report r[2];
    size_t bytes[2];
    test_integrals ours = {0};
    scene_cylinder(ctx, &base);
    scene_box(ctx, &tile);
    for (int i = 0; i < 2; i++) {
        char path[TEST_PATH_BYTES];
        kn_job *job = NULL;
        kn_occt_model *model = NULL;
        kn_sink sinks[2] = {{0}, test_integral_sink(&ours)};
        test_tmp_path(path, "instances.step");
        assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &(kn_job_options){.count = {8, 3}}), KN_OK);
        assert_int_equal(kn_step_sink(ctx, &sinks[0], path, &(kn_step_options){.instances = i == 1}), KN_OK);
        assert_int_equal(kn_job_run(ctx, job, sinks, i == 0 ? 2 : 1), KN_OK);
        kn_sink_close(ctx, &sinks[0]);
        kn_job_destroy(ctx, job);
        free(test_read_file(path, &bytes[i]));
        assert_int_equal(kn_occt_open_step(ctx, &model, path), KN_OK);
        assert_int_equal(kn_occt_check(ctx, &r[i], model), KN_OK);
        assert_true(r[i].valid);
        assert_int_equal(r[i].free_edges, 0);
        assert_int_equal(r[i].placed_solids, 24);
        assert_int_equal(r[i].solids, i == 0 ? 24 : 2);
        assert_int_equal(r[i].faces, i == 0 ? 24 * 6 : 2 * 6);
        assert_int_equal(r[i].ncolours, 1);
        assert_true(fabs(r[i].volume - ours.volume) <= 1e-6 * ours.volume);
        kn_occt_close(ctx, model);
        remove(path);
    }
    assert_true(3 * bytes[1] < bytes[0]);
    // a cell that were elsewhere would change these; placements are good to 1e-9 of a cell, OCCT's integrals to 1e-6
    for (int c = 0; c < 3; c++) {
        assert_true(fabs(r[0].centre[c] - r[1].centre[c]) <= 1e-6);
        assert_true(fabs(r[0].inertia[c] - r[1].inertia[c]) <= 1e-6 * r[0].inertia[c]);
    }
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

// ---- in a body of another writer ----

static void in_a_body(void **state)
{
    (void)state;
    for (int degree = 1; degree <= 2; degree++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        test_host h;
        test_tile tile;
        kn_patch patch[4];
        kn_occt_model *model = NULL;
        kn_occt_report r;
        kn_sink sink;
        char path[TEST_PATH_BYTES];
        kn_job_report report = test_report(4, degree, degree);
        test_tmp_path(path, "host.step");
        test_tile_make(&tile, 1);
        test_host_make(ctx, &h, degree);
        for (int k = 0; k < 4; k++) patch[k] = (kn_patch){.id = {.patch = k}, .bezier = h.lid[k], .exact = true};
        assert_int_equal(kn_step_sink(ctx, &sink, path, &(kn_step_options){.host = &h.host}), KN_OK);
        kn_status status = test_feed(ctx, &sink, &tile.tile, &report, patch, 4, 3);
        assert_string_equal(kn_ctx_message(ctx), "");
        assert_int_equal(status, KN_OK);
        kn_sink_close(ctx, &sink);
        assert_int_equal(kn_occt_open_step(ctx, &model, path), KN_OK);
        assert_int_equal(kn_occt_check(ctx, &r, model), KN_OK);
        assert_true(r.valid);
        assert_int_equal(r.solids, 1);
        assert_int_equal(r.closed_shells, 1);
        assert_int_equal(r.free_edges, 0);
        assert_int_equal(r.faces, 9);
        assert_int_equal(r.edges, 4 + 4 + 8 + 4);
        assert_int_equal(r.vertices, 4 + 8 + 1);
        assert_int_equal(r.ncolours, 1);
        // four boxes of 2 x 2 x 2, and four quarters of the roof, each 2 x 2 and a quarter high on average
        assert_true(fabs(r.volume - 36.0) <= 36e-9);
        kn_occt_close(ctx, model);
        remove(path);
        test_host_clear(ctx, &h);
        test_ctx_end(ctx, &memory);
    }
}

// ---- gmsh ----

// The volume of the tetrahedra of a mesh in gmsh's format 2; negative: it is none.
static double mesh_volume(const char *path)
{
    char line[256];
    long n = 0, id;
    double(*x)[3] = NULL, volume = -1.0;
    FILE *f = fopen(path, "r");
    if (!f) return -1.0;
    while (fgets(line, sizeof line, f) && strncmp(line, "$Nodes", 6) != 0) {
    }
    if (fscanf(f, "%ld", &n) == 1 && n > 0 && n < 10000000) x = calloc((size_t)n + 1, sizeof *x);
    for (long i = 0; x && i < n; i++) {
        double p[3];
        if (fscanf(f, "%ld %lf %lf %lf", &id, &p[0], &p[1], &p[2]) != 4 || id < 1 || id > n) break;
        memcpy(x[id], p, sizeof p);
    }
    while (fgets(line, sizeof line, f) && strncmp(line, "$Elements", 9) != 0) {
    }
    if (x && fscanf(f, "%ld\n", &n) == 1) volume = 0.0;
    while (volume >= 0.0 && fgets(line, sizeof line, f)) {
        long type, tags, t[2], v[4];
        if (sscanf(line, "%ld %ld %ld %ld %ld %ld %ld %ld %ld", &id, &type, &tags, &t[0], &t[1], &v[0], &v[1], &v[2],
                   &v[3]) != 9 ||
            type != 4 || tags != 2)
            continue;
        double d[3][3];
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++) d[k][c] = x[v[k + 1]][c] - x[v[0]][c];
        volume += fabs(d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                       d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                       d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0])) /
                  6.0;
    }
    free(x);
    fclose(f);
    return volume;
}

// Without repair and without an error; the body's faces are planes, so that its mesh has its volume.
static void meshed(void **state)
{
    (void)state;
    scene s;
    char command[4 * TEST_PATH_BYTES], mesh[TEST_PATH_BYTES], log[TEST_PATH_BYTES];
    if (system("command -v gmsh >/dev/null 2>&1") != 0) {
        print_message("no gmsh here\n");
        skip();
    }
    make_scene(&s, "cross", 1, NULL, 0);
    test_tmp_path(mesh, "body.msh"), test_tmp_path(log, "gmsh.log");
    snprintf(command, sizeof command, "gmsh -3 -format msh2 -v 3 -o '%s' '%s' >'%s' 2>&1", mesh, s.path, log);
    assert_int_equal(system(command), 0);
    char *said = test_read_file(log, NULL);
    assert_non_null(said);
    assert_null(strstr(said, "Error"));
    assert_null(strstr(said, "Warning"));
    double volume = mesh_volume(mesh);
    assert_true(fabs(volume - s.ours.volume) <= 1e-6 * s.ours.volume);
    free(said);
    remove(mesh), remove(log);
    scene_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(volumes_in_rows), cmocka_unit_test(rings),     cmocka_unit_test(reliefs),
        cmocka_unit_test(sheet_with_tips), cmocka_unit_test(limited),   cmocka_unit_test(schemas),
        cmocka_unit_test(instances),       cmocka_unit_test(in_a_body), cmocka_unit_test(meshed),
    };
    return cmocka_run_group_tests_name("bridges/occt_bodies", tests, NULL, NULL);
}
#else
static void without_occt(void **state)
{
    (void)state;
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(without_occt)};
    return cmocka_run_group_tests_name("bridges/occt_bodies", tests, NULL, NULL);
}
#endif
