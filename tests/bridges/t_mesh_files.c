// SPDX-License-Identifier: Apache-2.0
// Meshes from OBJ, STL, PLY, OFF and 3MF files, and grey levels of PNG files: values, and damaged files.
#include "tests/support/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bridges/lib3mf/read.h"
#include "bridges/openmesh/read.h"
#include "bridges/png/gray.h"
#include "bridges/png/png.h"

// A square of four vertices as two triangles, in each format; coordinates are exact in single precision.
static const char obj[] = "v 0 0 0\nv 2 0 0\nv 2 1 0.5\nv 0 1 0.5\nf 1 2 3 4\nf 1 1 2\n";
static const char off[] = "OFF\n4 1 0\n0 0 0\n2 0 0\n2 1 0.5\n0 1 0.5\n4 0 1 2 3\n";
static const char ply[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n2 0 0\n2 1 0.5\n0 1 0.5\n4 0 1 2 3\n";
static const char stl[] =
    "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 2 1 0.5\nendloop\n"
    "endfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 1 0.5\nvertex 0 1 0.5\n"
    "endloop\nendfacet\nendsolid s\n";

static double area(const kn_mesh *m)
{
    double sum = 0;
    for (size_t t = 0; t < m->ntriangles; t++) {
        const double *p[3];
        double n[3];
        for (int k = 0; k < 3; k++) p[k] = m->position + 3 * m->triangle[3 * t + (size_t)k];
        for (int c = 0; c < 3; c++) {
            int d = (c + 1) % 3, e = (c + 2) % 3;
            n[c] = (p[1][d] - p[0][d]) * (p[2][e] - p[0][e]) - (p[1][e] - p[0][e]) * (p[2][d] - p[0][d]);
        }
        sum += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
    return sum;
}

static void the_same_square(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
    } files[] = {{"square.obj", obj}, {"square.OFF", off}, {"square.ply", ply}, {"square.stl", stl}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh mesh = {0};
    char path[TEST_PATH_BYTES];
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        test_tmp_path(path, files[i].name);
        test_write_file(path, files[i].text, strlen(files[i].text));
        assert_int_equal(kn_openmesh_read(ctx, &mesh, path), KN_OK); // gives up what it held
        assert_int_equal(mesh.nvertices, 4);
        assert_int_equal(mesh.ntriangles, 2);
        assert_null(mesh.normal);
        assert_true(fabs(area(&mesh) - 2 * sqrt(1.25)) <= 1e-14);
        remove(path);
    }
    kn_mesh_clear(ctx, &mesh);
    test_ctx_end(ctx, &memory);
}

static void damaged_files(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
        kn_status status;
    } files[] = {
        {"bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n", KN_EPARSE},
        {"bad.obj", "v 0 0 0\nv 1 0 0\nv nan 0 0\nf 1 2 3\n", KN_EPARSE},
        {"bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", KN_EPARSE},
        {"bad.obj", "", KN_EPARSE},
        {"bad.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n", KN_EPARSE},
        {"bad.off", "not a mesh", KN_EPARSE},
        {"bad.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", KN_EPARSE},
        {"bad.stl", "solid s\nfacet", KN_EPARSE},
        {"bad.txt", "v 0 0 0\n", KN_EDOMAIN},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh mesh = {0};
    char path[TEST_PATH_BYTES], binary[134] = {0};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        test_tmp_path(path, files[i].name);
        test_write_file(path, files[i].text, strlen(files[i].text));
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_openmesh_read(ctx, &mesh, path), files[i].status);
        assert_non_null(strstr(kn_ctx_message(ctx), files[i].name));
        assert_null(mesh.position);
        remove(path);
    }
    memset(binary + 80, 0xff, 4); // 2^32 - 1 triangles, and bytes for one
    test_tmp_path(path, "many.stl");
    test_write_file(path, binary, sizeof binary);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_openmesh_read(ctx, &mesh, path), KN_EPARSE);
    assert_non_null(strstr(kn_ctx_message(ctx), "4294967295 triangles expected"));
    remove(path);
    assert_int_equal(kn_openmesh_read(ctx, &mesh, path), KN_EIO);
    test_write_file(path, "PK no archive", 13);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_3mf_read(ctx, &mesh, path), KN_EPARSE);
    assert_non_null(strstr(kn_ctx_message(ctx), "many.stl"));
    remove(path);
    assert_int_equal(kn_3mf_read(ctx, &mesh, path), KN_EIO);
    assert_null(mesh.position);
    test_ctx_end(ctx, &memory);
}

// ---- a 3MF file, which is a ZIP archive: stored entries are enough ----

static uint32_t crc_of(const char *text, size_t n)
{
    uint32_t crc = 0xffffffffU;
    for (size_t i = 0; i < n; i++) {
        crc ^= (unsigned char)text[i];
        for (int k = 0; k < 8; k++) crc = crc & 1 ? crc >> 1 ^ 0xedb88320U : crc >> 1;
    }
    return ~crc;
}

static void put(char *out, size_t *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) out[(*at)++] = (char)(value >> 8 * i & 0xff);
}

// What the local header of an entry and its place in the directory share.
static void put_entry(char *out, size_t *at, const char *text)
{
    put(out, at, 20, 2), put(out, at, 0, 4), put(out, at, 0, 4); // version; flags, stored; time and date
    put(out, at, crc_of(text, strlen(text)), 4), put(out, at, strlen(text), 4), put(out, at, strlen(text), 4);
}

static size_t make_archive(char *out, const char *const (*files)[2], size_t n)
{
    size_t at = 0, start[4], directory;
    for (size_t i = 0; i < n; i++) {
        start[i] = at;
        put(out, &at, 0x04034b50, 4), put_entry(out, &at, files[i][1]);
        put(out, &at, strlen(files[i][0]), 2), put(out, &at, 0, 2);
        for (int k = 0; k < 2; k++) memcpy(out + at, files[i][k], strlen(files[i][k])), at += strlen(files[i][k]);
    }
    directory = at;
    for (size_t i = 0; i < n; i++) {
        put(out, &at, 0x02014b50, 4), put(out, &at, 20, 2), put_entry(out, &at, files[i][1]);
        put(out, &at, strlen(files[i][0]), 2), put(out, &at, 0, 6), put(out, &at, 0, 6), put(out, &at, start[i], 4);
        memcpy(out + at, files[i][0], strlen(files[i][0])), at += strlen(files[i][0]);
    }
    size_t size = at - directory;
    put(out, &at, 0x06054b50, 4), put(out, &at, 0, 4), put(out, &at, n, 2), put(out, &at, n, 2);
    put(out, &at, size, 4), put(out, &at, directory, 4), put(out, &at, 0, 2);
    return at;
}

// A tetrahedron, once as it is and once mirrored by its component and moved by its item.
static void a_3mf_file(void **state)
{
    (void)state;
    static const char *const files[][2] = {
        {"[Content_Types].xml",
         "<?xml version=\"1.0\" encoding=\"UTF-8\"?><Types "
         "xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"><Default Extension=\"rels\" "
         "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/><Default Extension=\"model\" "
         "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>"},
        {"_rels/.rels", "<?xml version=\"1.0\" encoding=\"UTF-8\"?><Relationships "
                        "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship "
                        "Target=\"/3D/3dmodel.model\" Id=\"rel0\" "
                        "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"},
        {"3D/3dmodel.model",
         "<?xml version=\"1.0\" encoding=\"UTF-8\"?><model unit=\"millimeter\" xml:lang=\"en-US\" "
         "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources><object id=\"1\" "
         "type=\"model\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"2\" y=\"0\" z=\"0\"/><vertex "
         "x=\"0\" y=\"1\" z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"0.5\"/></vertices><triangles><triangle v1=\"0\" "
         "v2=\"2\" "
         "v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/><triangle v1=\"0\" "
         "v2=\"3\" v3=\"2\"/></triangles></mesh></object><object id=\"2\" type=\"model\"><components><component "
         "objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/></components></object></resources><build><item "
         "objectid=\"1\"/><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 10 0 0\"/></build></model>"},
    };
    static char archive[8192];
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh mesh = {0};
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "two.3mf");
    test_write_file(path, archive, make_archive(archive, files, 3));
    kn_status status = kn_3mf_read(ctx, &mesh, path);
    if (status != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    assert_int_equal(mesh.nvertices, 8);
    assert_int_equal(mesh.ntriangles, 8);
    assert_true(mesh.position[3] == 2 && mesh.position[15] == 8); // 10 - 2
    double volume[2] = {0, 0};                                    // both face outwards
    for (size_t t = 0; t < 8; t++) {
        const double *a = mesh.position + 3 * mesh.triangle[3 * t], *b = mesh.position + 3 * mesh.triangle[3 * t + 1],
                     *c = mesh.position + 3 * mesh.triangle[3 * t + 2];
        volume[t / 4] += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0])) /
                         6;
    }
    assert_true(fabs(volume[0] - 1.0 / 6) <= 1e-14 && fabs(volume[1] - 1.0 / 6) <= 1e-14);
    kn_mesh_clear(ctx, &mesh);
    remove(path);
    test_ctx_end(ctx, &memory);
}

// Rows from the top: black, white | red, 51 grey. Levels are v / 255 in double precision, u slowest, v upwards.
static void grey_levels(void **state)
{
    (void)state;
    static const uint8_t pixels[] = {0, 0, 0, 255, 255, 255, 255, 0, 0, 51, 51, 51};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_field_samples s = {0};
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "grey.png");
    assert_int_equal(kn_png_write(ctx, path, pixels, 2, 2, 3), KN_OK);
    assert_int_equal(kn_png_read_gray(ctx, &s, path), KN_OK);
    assert_true(s.n[0] == 2 && s.n[1] == 2 && !s.closed[0] && !s.closed[1]);
    static const double expected[] = {0.2126, 0, 0.2, 1};
    for (int i = 0; i < 4; i++) assert_true(fabs(s.values[i] - expected[i]) <= 1e-15);
    kn_free(ctx, (void *)s.values);
    assert_int_equal(kn_png_write(ctx, path, pixels + 9, 1, 1, 3), KN_OK); // one pixel is doubled
    assert_int_equal(kn_png_read_gray(ctx, &s, path), KN_OK);
    assert_true(s.n[0] == 2 && s.n[1] == 2 && fabs(s.values[3] - 0.2) <= 1e-15);
    kn_free(ctx, (void *)s.values);

    size_t bytes;
    char *file = test_read_file(path, &bytes);
    assert_non_null(file);
    for (size_t n = 0; n < bytes; n += 5) { // cut anywhere
        test_write_file(path, file, n);
        kn_ctx_clear_error(ctx);
        s = (kn_field_samples){0};
        assert_int_equal(kn_png_read_gray(ctx, &s, path), KN_EPARSE);
        assert_non_null(strstr(kn_ctx_message(ctx), "grey.png"));
        assert_null(s.values);
    }
    free(file);
    remove(path);
    assert_int_equal(kn_png_read_gray(ctx, &s, path), KN_EIO);
    test_ctx_end(ctx, &memory);
}

static kn_status read_obj(kn_ctx *ctx, void *path)
{
    kn_mesh mesh = {0};
    kn_status status = kn_openmesh_read(ctx, &mesh, path);
    if (status != KN_OK) assert_null(mesh.position);
    kn_mesh_clear(ctx, &mesh);
    return status;
}

static kn_status read_grey(kn_ctx *ctx, void *path)
{
    kn_field_samples s = {0};
    kn_status status = kn_png_read_gray(ctx, &s, path);
    if (status != KN_OK) assert_null(s.values);
    kn_free(ctx, (void *)s.values);
    return status;
}

static void running_out_of_memory(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "memory.obj");
    test_write_file(path, obj, strlen(obj));
    test_allocation_failures(read_obj, path);
    remove(path);
    test_tmp_path(path, "memory.png");
    assert_int_equal(kn_png_write(ctx, path, (const uint8_t[]){1, 2, 3}, 1, 1, 3), KN_OK);
    test_allocation_failures(read_grey, path);
    remove(path);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_square), cmocka_unit_test(damaged_files),         cmocka_unit_test(a_3mf_file),
        cmocka_unit_test(grey_levels),     cmocka_unit_test(running_out_of_memory),
    };
    return cmocka_run_group_tests_name("bridges/mesh_files", tests, NULL, NULL);
}
