// SPDX-License-Identifier: Apache-2.0
// Binary STL, OBJ and the counting sink, fed by hand.
#include "tests/support/patches.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATCHES = 5 };

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_tile tile;
    kn_patch patch[PATCHES];
    kn_job_report report;
    char path[TEST_PATH_BYTES], library[TEST_PATH_BYTES];
} world;

static void world_make(world *w, const char *name)
{
    *w = (world){.memory = TEST_MEMORY_INIT, .report = test_report(PATCHES, 3, 3)};
    w->ctx = test_ctx(&w->memory, 1);
    test_rng rng = test_random(9);
    test_tile_make(&w->tile, 2);
    for (int i = 0; i < PATCHES; i++) {
        test_patch(w->ctx, &w->patch[i], &rng, 3, 2, i == 4, i, 0.1);
        w->patch[i].id.part = w->patch[i].look = i >= 3;
        w->patch[i].reversed = i == 2;
    }
    test_tmp_path(w->path, name);
    test_tmp_path(w->library, "out.mtl");
}

static void world_clear(world *w)
{
    for (int i = 0; i < PATCHES; i++) kn_bezier_clear(w->ctx, &w->patch[i].bezier);
    remove(w->path);
    remove(w->library);
    test_ctx_end(w->ctx, &w->memory);
}

typedef kn_status (*make_sink)(kn_ctx *ctx, kn_sink *out, const char *path);

static char *write_with(world *w, make_sink make, size_t block, size_t *bytes)
{
    kn_sink sink;
    assert_int_equal(make(w->ctx, &sink, w->path), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, &w->report, w->patch, PATCHES, block), KN_OK);
    *bytes = sink.bytes(sink.user);
    kn_sink_close(w->ctx, &sink);
    char *data = test_read_file(w->path, NULL);
    assert_non_null(data);
    return data;
}

// All patches in one mesh, as the tessellation itself makes it.
static void tessellate(world *w, kn_mesh *mesh)
{
    *mesh = (kn_mesh){0};
    for (int i = 0; i < PATCHES; i++)
        assert_int_equal(
            kn_mesh_add_patch(w->ctx, mesh, &w->patch[i].bezier, w->patch[i].segments, w->patch[i].reversed), KN_OK);
}

static uint32_t u32(const char *at)
{
    const unsigned char *b = (const unsigned char *)at;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static float f32(const char *at)
{
    uint32_t bits = u32(at);
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static void stl(void **state)
{
    (void)state;
    world w;
    world_make(&w, "out.stl");
    size_t bytes, again;
    char *data = write_with(&w, kn_stl_sink, 2, &bytes), *other = write_with(&w, kn_stl_sink, 5, &again);
    assert_int_equal(bytes, again);
    assert_memory_equal(data, other, bytes);
    kn_mesh mesh;
    tessellate(&w, &mesh);
    assert_int_equal(bytes, 84 + 50 * mesh.ntriangles);
    assert_int_equal(u32(data + 80), mesh.ntriangles);
    assert_string_equal(data, "knurl");
    for (size_t t = 0; t < mesh.ntriangles; t++) {
        const char *at = data + 84 + 50 * t;
        double p[3][3], n[3];
        for (size_t k = 0; k < 3; k++)
            for (size_t c = 0; c < 3; c++) {
                p[k][c] = (double)f32(at + 12 * (k + 1) + 4 * c);
                assert_true(p[k][c] == (double)(float)mesh.position[3 * (size_t)mesh.triangle[3 * t + k] + c]);
            }
        for (int c = 0; c < 3; c++) { // right-handed, unit length
            int a = (c + 1) % 3, b = (c + 2) % 3;
            n[c] = (p[1][a] - p[0][a]) * (p[2][b] - p[0][b]) - (p[1][b] - p[0][b]) * (p[2][a] - p[0][a]);
        }
        double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (size_t c = 0; c < 3; c++) assert_true(fabs((double)f32(at + 4 * c) - n[c] / length) <= 1e-7);
        assert_true(at[48] == 0 && at[49] == 0);
    }
    kn_mesh_clear(w.ctx, &mesh);
    free(data);
    free(other);
    world_clear(&w);
}

// Corners that fall together in single precision: the triangle is gone, the count follows.
static void stl_degenerate(void **state)
{
    (void)state;
    world w;
    world_make(&w, "out.stl");
    kn_bezier *b = &w.patch[0].bezier;
    size_t n = kn_bezier_count(b);
    for (size_t k = 0; k < n; k++) { // a strip of width 1e-12 about x = 1
        size_t row = k / 3;
        b->coef[k] = 1.0 + 1e-12 * (double)row;
        b->coef[n + k] = (double)(k % 3);
        b->coef[2 * n + k] = 0.0;
    }
    kn_mesh mesh;
    tessellate(&w, &mesh);
    size_t bytes;
    char *data = write_with(&w, kn_stl_sink, PATCHES, &bytes);
    assert_int_equal(u32(data + 80), mesh.ntriangles - 24); // 2 * 4 * 3 of the strip
    assert_int_equal(bytes, 84 + 50 * (size_t)u32(data + 80));
    kn_mesh_clear(w.ctx, &mesh);
    free(data);
    world_clear(&w);
}

// Reads an OBJ of triangles with relative indices back into absolute ones.
typedef struct obj {
    double p[4096][3], n[4096][3];
    int np, nn, triangle[8192][3], nt, groups, part_of_last;
} obj;

static void read_obj(obj *o, const char *text)
{
    memset(o, 0, sizeof *o);
    for (const char *at = text; at != NULL && *at != '\0'; at = strchr(at, '\n'), at = at != NULL ? at + 1 : NULL) {
        double *v = NULL;
        if (strncmp(at, "v ", 2) == 0) v = o->p[o->np++];
        if (strncmp(at, "vn ", 3) == 0) v = o->n[o->nn++];
        if (v != NULL) assert_int_equal(sscanf(strchr(at, ' '), "%lf %lf %lf", &v[0], &v[1], &v[2]), 3);
        if (strncmp(at, "g ", 2) == 0) o->groups++;
        if (strncmp(at, "f ", 2) == 0) {
            int i[6], *t = o->triangle[o->nt++];
            assert_int_equal(sscanf(at, "f %d//%d %d//%d %d//%d", &i[0], &i[1], &i[2], &i[3], &i[4], &i[5]), 6);
            for (int k = 0; k < 3; k++) {
                assert_int_equal(i[2 * k], i[2 * k + 1]);
                t[k] = o->np + i[2 * k];
                assert_true(i[2 * k] < 0 && t[k] >= 0);
            }
        }
    }
}

static void obj_and_mtl(void **state)
{
    (void)state;
    world w;
    world_make(&w, "out.obj");
    size_t bytes, again;
    char *text = write_with(&w, kn_obj_sink, 2, &bytes);
    char *library = test_read_file(w.library, &again);
    assert_non_null(library);
    assert_int_equal(bytes, strlen(text) + again);
    kn_mesh mesh;
    tessellate(&w, &mesh);
    obj *o = malloc(sizeof *o);
    assert_non_null(o);
    read_obj(o, text);
    assert_int_equal(o->np, mesh.nvertices);
    assert_int_equal(o->nn, mesh.nvertices);
    assert_int_equal(o->nt, mesh.ntriangles);
    for (size_t i = 0; i < mesh.nvertices; i++)
        for (size_t c = 0; c < 3; c++) { // nine digits of a position, six decimals of a normal
            double p = mesh.position[3 * i + c];
            assert_true(fabs(o->p[i][c] - p) <= 0.51e-8 * fabs(p));
            assert_true(fabs(o->n[i][c] - mesh.normal[3 * i + c]) <= 0.51e-6);
        }
    for (size_t t = 0; t < mesh.ntriangles; t++)
        for (size_t k = 0; k < 3; k++) assert_int_equal(o->triangle[t][k], mesh.triangle[3 * t + k]);
    const char *name = strrchr(w.library, '/') + 1;
    char line[TEST_PATH_BYTES + 16];
    snprintf(line, sizeof line, "\nmtllib %s\n", name);
    assert_non_null(strstr(text, line));
    assert_non_null(strstr(text, "\ng link\nusemtl link\nv "));
    assert_non_null(strstr(text, "\ng wire_rod\nusemtl wire_rod\nv "));
    assert_non_null(strstr(library, "newmtl link\nKd 0.25 0.5 0.125\nPm 1\nPr 0.5\nnewmtl wire_rod\nKd 0.5 "));
    kn_mesh_clear(w.ctx, &mesh);
    free(o);
    free(text);
    free(library);
    world_clear(&w);
}

static void refusals(void **state)
{
    (void)state;
    world w;
    world_make(&w, "out.obj");
    kn_sink sink;
    assert_int_equal(kn_stl_sink(w.ctx, &sink, "/nowhere/x.stl"), KN_EIO);
    kn_ctx_clear_error(w.ctx);
    assert_int_equal(kn_obj_sink(w.ctx, &sink, "/nowhere/x.obj"), KN_EIO);
    kn_ctx_clear_error(w.ctx);
    assert_int_equal(kn_obj_sink(w.ctx, &sink, w.library), KN_EDOMAIN); // its own materials
    kn_ctx_clear_error(w.ctx);
    double *x = &w.patch[1].bezier.coef[0], kept = *x; // finite, but not in single precision
    *x = 1e39;
    assert_int_equal(kn_stl_sink(w.ctx, &sink, w.path), KN_OK);
    assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &w.report, w.patch, 2, 1), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(w.ctx), "beyond single precision"));
    kn_sink_close(w.ctx, &sink);
    assert_null(test_read_file(w.path, NULL));
    kn_ctx_clear_error(w.ctx);
    *x = kept;
    w.patch[0].look = 2;
    assert_int_equal(kn_obj_sink(w.ctx, &sink, w.path), KN_OK);
    assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &w.report, w.patch, 1, 1), KN_EDOMAIN);
    kn_sink_close(w.ctx, &sink);
    assert_null(test_read_file(w.path, NULL));
    assert_null(test_read_file(w.library, NULL));
    world_clear(&w);
}

static void counting(void **state)
{
    (void)state;
    world w;
    world_make(&w, "unused");
    kn_sink sink;
    assert_int_equal(kn_null_sink(w.ctx, &sink), KN_OK);
    assert_int_equal(test_feed(w.ctx, &sink, &w.tile.tile, &w.report, w.patch, PATCHES, 2), KN_OK);
    assert_int_equal(sink.bytes(sink.user), (4 * 12 * 3 + 12 * 4) * 8); // coefficients, as doubles
    kn_sink_close(w.ctx, &sink);
    assert_null(test_read_file(w.path, NULL));
    world_clear(&w);
}

typedef struct trial {
    world *w;
    make_sink make;
} trial;

static kn_status feed_sink(kn_ctx *ctx, void *user)
{
    trial *t = user;
    kn_sink sink;
    kn_status status = t->make(ctx, &sink, t->w->path);
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &t->w->tile.tile, &t->w->report, t->w->patch, PATCHES, 2);
    kn_sink_close(ctx, &sink);
    if (status != KN_OK) assert_null(test_read_file(t->w->path, NULL));
    return status;
}

static kn_status make_null(kn_ctx *ctx, kn_sink *out, const char *path)
{
    (void)path;
    return kn_null_sink(ctx, out);
}

static void without_memory(void **state)
{
    (void)state;
    world w;
    world_make(&w, "out.obj");
    test_allocation_failures(feed_sink, &(trial){&w, kn_stl_sink});
    remove(w.path);
    test_allocation_failures(feed_sink, &(trial){&w, kn_obj_sink});
    remove(w.path);
    test_allocation_failures(feed_sink, &(trial){&w, make_null});
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stl),      cmocka_unit_test(stl_degenerate), cmocka_unit_test(obj_and_mtl),
        cmocka_unit_test(refusals), cmocka_unit_test(counting),       cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("io/mesh_sinks", tests, NULL, NULL);
}
