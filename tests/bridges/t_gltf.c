// SPDX-License-Identifier: Apache-2.0
// glTF: the file's structure parsed here byte by byte, read back through the reader, and bad files.
#include "tests/support/patches.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bridges/tinygltf/gltf.h"

// ---- a JSON walker of our own: enough for numbers inside arrays of objects ----

// Behind the value that starts at p.
static const char *skip_value(const char *p)
{
    int depth = 0;
    for (bool quoted = false; *p; p++) {
        if (quoted && *p == '\\')
            p++;
        else if (*p == '"')
            quoted = !quoted;
        else if (!quoted && (*p == '[' || *p == '{'))
            depth++;
        else if (!quoted && (*p == ']' || *p == '}' || *p == ',') && depth == 0)
            return p;
        else if (!quoted && (*p == ']' || *p == '}'))
            depth--;
    }
    return p;
}

// The value of a key of the object that starts at p; NULL if there is none.
static const char *member(const char *p, const char *key)
{
    size_t n = strlen(key);
    assert_int_equal(*p, '{');
    while (*p != '}') {
        p++;
        if (*p == '}') return NULL;
        assert_int_equal(*p, '"');
        bool found = !strncmp(p + 1, key, n) && p[n + 1] == '"';
        p = strchr(p + 1, '"') + 2; // keys here have no escapes; behind the colon
        if (found) return p;
        p = skip_value(p);
    }
    return NULL;
}

static const char *element(const char *p, int index)
{
    assert_non_null(p);
    assert_int_equal(*p, '[');
    for (p++; index > 0; index--) p = skip_value(p) + 1;
    return p;
}

static double number(const char *object, const char *key)
{
    const char *p = member(object, key);
    assert_non_null(p);
    return strtod(p, NULL);
}

// ---- a .glb as this test sees it ----

typedef struct glb {
    char *file, *json;
    const char *bin;
    size_t bin_bytes;
} glb;

static uint32_t word(const char *p)
{
    const unsigned char *b = (const unsigned char *)p;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static glb open_glb(const char *path)
{
    glb g = {0};
    size_t bytes;
    g.file = test_read_file(path, &bytes);
    assert_non_null(g.file);
    assert_true(bytes > 28);
    assert_memory_equal(g.file, "glTF", 4);
    assert_int_equal(word(g.file + 4), 2);
    assert_int_equal(word(g.file + 8), bytes);
    size_t json = word(g.file + 12);
    assert_memory_equal(g.file + 16, "JSON", 4);
    assert_int_equal(json % 4, 0);
    g.json = calloc(json + 1, 1);
    memcpy(g.json, g.file + 20, json);
    g.bin_bytes = word(g.file + 20 + json);
    assert_memory_equal(g.file + 24 + json, "BIN", 4);
    assert_int_equal(28 + json + g.bin_bytes, bytes);
    assert_int_equal(g.bin_bytes % 4, 0);
    g.bin = g.file + 28 + json;
    return g;
}

static void close_glb(glb *g)
{
    free(g->file);
    free(g->json);
}

static const char *accessor_data(const glb *g, const char *accessor, size_t *stride)
{
    const char *view = element(member(g->json, "bufferViews"), (int)number(accessor, "bufferView"));
    size_t offset = member(view, "byteOffset") ? (size_t)number(view, "byteOffset") : 0;
    size_t inner = member(accessor, "byteOffset") ? (size_t)number(accessor, "byteOffset") : 0;
    assert_true(offset + (size_t)number(view, "byteLength") <= g->bin_bytes);
    *stride = member(view, "byteStride") ? (size_t)number(view, "byteStride") : 0;
    return g->bin + offset + inner;
}

// ---- patches: z = x y / 32 over [x0, x0 + 2] x [0, 4]: every vertex is a small dyadic number ----

static kn_patch make_patch(kn_ctx *ctx, double x0, int part, int a, int b, bool reversed)
{
    kn_patch p = {.id.part = part, .look = part, .segments = {a, b}, .reversed = reversed, .exact = true};
    const double coef[12] = {x0, x0, x0 + 2, x0 + 2, 0, 4, 0, 4, 0, x0 / 8, 0, (x0 + 2) / 8};
    assert_int_equal(kn_bezier_init(ctx, &p.bezier, 2, 3, false, (int[2]){1, 1}), KN_OK);
    memcpy(p.bezier.coef, coef, sizeof coef);
    return p;
}

static void clear_patches(kn_ctx *ctx, kn_patch *p, int n)
{
    for (int i = 0; i < n; i++) kn_bezier_clear(ctx, &p[i].bezier);
}

static kn_status write_patches(kn_ctx *ctx, const char *path, const kn_patch *p, size_t n, int nparts,
                               const kn_gltf_options *options)
{
    test_tile tile;
    test_tile_make(&tile, nparts);
    kn_sink sink = {0};
    kn_job_report report = test_report(n, 1, 1);
    kn_status status = kn_gltf_sink(ctx, &sink, path, options);
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &tile.tile, &report, p, n, 2);
    if (status == KN_OK) {
        size_t bytes = 0;
        free(test_read_file(path, &bytes));
        assert_int_equal(sink.bytes(sink.user), bytes);
    }
    kn_sink_close(ctx, &sink);
    return status;
}

static bool exists(const char *path)
{
    FILE *f = fopen(path, "rb");
    if (f) fclose(f);
    return f != NULL;
}

static void assert_nothing_at(const char *path)
{
    char temporary[TEST_PATH_BYTES + 16];
    snprintf(temporary, sizeof temporary, "%s.tmp-0", path);
    assert_false(exists(path));
    assert_false(exists(temporary));
}

// ---- structure ----

static void the_file_is_what_the_specification_says(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "structure.glb");
    kn_patch p[3] = {make_patch(ctx, 0, 0, 2, 1, false), make_patch(ctx, 2, 0, 2, 1, false),
                     make_patch(ctx, -8, 1, 4, 4, true)};
    assert_int_equal(write_patches(ctx, path, p, 3, 2, &(kn_gltf_options){.unit_mm = 10}), KN_OK);
    glb g = open_glb(path);

    // The two patches of part 0 share an edge of 2 points: 2 * 6 - 2 vertices, 2 * 4 triangles.
    const char *meshes = member(g.json, "meshes"), *accessors = member(g.json, "accessors");
    const char *primitive = element(member(element(meshes, 0), "primitives"), 0);
    const char *attributes = member(primitive, "attributes");
    const char *position = element(accessors, (int)number(attributes, "POSITION"));
    const char *normal = element(accessors, (int)number(attributes, "NORMAL"));
    const char *index = element(accessors, (int)number(primitive, "indices"));
    assert_true(number(position, "count") == 10 && number(normal, "count") == 10);
    assert_true(number(index, "count") == 24);
    assert_true(number(position, "componentType") == 5126 && number(index, "componentType") == 5123);
    const double lo[3] = {0, 0, 0}, hi[3] = {4, 4, 0.5};
    for (int c = 0; c < 3; c++) {
        assert_true(strtod(element(member(position, "min"), c), NULL) == lo[c]);
        assert_true(strtod(element(member(position, "max"), c), NULL) == hi[c]);
    }

    // Every vertex is on the surface, every normal along (-y, -x, 32), every index in range and used.
    size_t stride, narrow;
    const char *data = accessor_data(&g, position, &stride), *indices = accessor_data(&g, index, &narrow);
    assert_int_equal(narrow, 0);
    for (size_t i = 0; i < 10; i++) {
        float v[6];
        memcpy(v, data + i * stride, sizeof v);
        double x = (double)v[0], y = (double)v[1], length = sqrt(x * x + y * y + 1024.0);
        assert_true((double)v[2] == x * y / 32);
        // float32 rounds by 2^-25 at most below 1; what came before rounded in double precision
        assert_true(fabs((double)v[3] + y / length) < 0x1p-24);
        assert_true(fabs((double)v[4] + x / length) < 0x1p-24);
        assert_true(fabs((double)v[5] - 32.0 / length) < 0x1p-24);
    }
    unsigned used = 0;
    for (size_t k = 0; k < 24; k++) {
        uint16_t i;
        memcpy(&i, indices + 2 * k, 2);
        assert_true(i < 10);
        used |= 1u << i;
    }
    assert_int_equal(used, (1u << 10) - 1);

    // Root: centimetres to metres, a quarter turn about x; two children; materials by part.
    const char *root = element(member(g.json, "nodes"), 0);
    const char *children = member(root, "children");
    assert_true(strtod(element(children, 0), NULL) == 1 && strtod(element(children, 1), NULL) == 2);
    for (int c = 0; c < 3; c++) assert_true(strtod(element(member(root, "scale"), c), NULL) == 10 * 1e-3);
    const double half = 0.70710678118654752440, turn[4] = {-half, 0, 0, half};
    for (int c = 0; c < 4; c++)
        assert_true(fabs(strtod(element(member(root, "rotation"), c), NULL) - turn[c]) < 1e-15);
    assert_memory_equal(member(element(meshes, 1), "name"), "\"wire rod\"", 10);
    const char *material = member(element(member(g.json, "materials"), 1), "pbrMetallicRoughness");
    assert_true(strtod(element(member(material, "baseColorFactor"), 0), NULL) == 0.5);
    assert_true(number(material, "roughnessFactor") == 0.5);
    assert_null(member(material, "metallicFactor")); // 1 is the default
    close_glb(&g);
    clear_patches(ctx, p, 3);
    remove(path);
    test_ctx_end(ctx, &memory);
}

static void wide_indices_where_they_are_needed(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "wide.glb");
    kn_patch p = make_patch(ctx, 0, 0, 256, 256, false); // 66,049 vertices
    assert_int_equal(write_patches(ctx, path, &p, 1, 1, NULL), KN_OK);
    kn_scene scene = {0};
    assert_int_equal(kn_gltf_read(ctx, &scene, path), KN_OK);
    assert_int_equal(scene.nitems, 1);
    assert_int_equal(scene.items[0].mesh.nvertices, 257 * 257);
    assert_int_equal(scene.items[0].mesh.ntriangles, 2 * 256 * 256);
    kn_scene_clear(ctx, &scene);
    clear_patches(ctx, &p, 1);
    remove(path);
    test_ctx_end(ctx, &memory);
}

// Curves of all blocks of a part are the segments of one primitive, beside its triangles or alone.
static kn_patch make_curve(kn_ctx *ctx, double x0, int part, int segments)
{
    kn_patch p = {.id.part = part, .look = part, .segments = {segments}, .exact = true};
    const double coef[6] = {x0, x0 + 2, 0, 4, 1, 1};
    assert_int_equal(kn_bezier_init(ctx, &p.bezier, 1, 3, false, (int[1]){1}), KN_OK);
    memcpy(p.bezier.coef, coef, sizeof coef);
    return p;
}

static void check_lines(const glb *g, const char *primitive, int curves, const double *x0)
{
    size_t stride;
    const char *accessors = member(g->json, "accessors");
    assert_true(number(primitive, "mode") == 1);
    const char *position = element(accessors, (int)number(member(primitive, "attributes"), "POSITION"));
    const char *indices = element(accessors, (int)number(primitive, "indices"));
    assert_true(number(position, "count") == 5 * curves && number(indices, "count") == 8 * curves);
    const char *data = accessor_data(g, position, &stride), *index = accessor_data(g, indices, &stride);
    for (int i = 0; i < 5 * curves; i++) {
        float p[3];
        memcpy(p, data + 12 * i, sizeof p);
        assert_true((double)p[0] == x0[i / 5] + 0.5 * (i % 5) && p[1] == (float)(i % 5) && p[2] == 1.0f);
    }
    for (int i = 0; i < 8 * curves; i++) {
        uint16_t at;
        memcpy(&at, index + 2 * i, sizeof at);
        assert_int_equal(at, i / 8 * 5 + i % 8 / 2 + i % 2);
    }
}

static void curves_are_lines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "curves.glb");
    kn_patch p[5] = {make_curve(ctx, 0, 0, 4), make_patch(ctx, 0, 0, 4, 2, false), make_curve(ctx, 2, 1, 4),
                     make_curve(ctx, 4, 1, 4), make_curve(ctx, 6, 0, 4)};
    assert_int_equal(write_patches(ctx, path, p, 5, 3, NULL), KN_OK);
    glb g = open_glb(path);
    const char *meshes = member(g.json, "meshes");
    const char *first = member(element(meshes, 0), "primitives"), *second = member(element(meshes, 1), "primitives");
    assert_true(number(element(first, 0), "mode") == 4);
    check_lines(&g, element(first, 1), 2, (const double[2]){0, 6});
    check_lines(&g, element(second, 0), 2, (const double[2]){2, 4});
    close_glb(&g);
    kn_scene scene = {0};
    assert_int_equal(kn_gltf_read(ctx, &scene, path), KN_OK); // triangles alone are read
    assert_int_equal(scene.nitems, 1);
    kn_scene_clear(ctx, &scene);
    clear_patches(ctx, p, 5);
    remove(path);
    test_ctx_end(ctx, &memory);
}

// ---- there and back ----

// Model coordinates in millimetres to metres with y up: (x, y, z) -> (x, z, -y) / 1000. The rotation read from a
// quaternion of rounded square roots is off by 2^-52 in each entry, and each of the products and sums rounds once.
static void assert_corner(const double *got, const double *p)
{
    const double want[3] = {p[0] * 1e-3, p[2] * 1e-3, -p[1] * 1e-3};
    double size = (fabs(p[0]) + fabs(p[1]) + fabs(p[2])) * 1e-3;
    for (int c = 0; c < 3; c++) assert_true(fabs(got[c] - want[c]) <= 8 * 0x1p-52 * size);
}

static void there_and_back(const char *name, bool keep)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, name);
    kn_patch p[4] = {make_patch(ctx, 0, 0, 4, 2, false), make_patch(ctx, 2, 1, 2, 2, true),
                     make_patch(ctx, 4, 0, 1, 8, false), make_patch(ctx, 6, 1, 2, 4, true)};
    assert_int_equal(write_patches(ctx, path, p, 4, 3, &(kn_gltf_options){.keep_duplicates = keep}), KN_OK);
    kn_scene scene = {0};
    assert_int_equal(kn_gltf_read(ctx, &scene, path), KN_OK);
    assert_int_equal(scene.nitems, 2); // the third part has nothing
    for (int part = 0; part < 2; part++) {
        kn_mesh want = {0};
        for (int i = part; i < 4; i += 2)
            assert_int_equal(kn_mesh_add_patch(ctx, &want, &p[i].bezier, p[i].segments, p[i].reversed), KN_OK);
        const kn_mesh *got = &scene.items[part].mesh;
        assert_int_equal(got->ntriangles, want.ntriangles);
        assert_true(keep ? got->nvertices == want.nvertices : got->nvertices <= want.nvertices);
        for (size_t k = 0; k < 3 * want.ntriangles; k++) {
            const double *n = got->normal + 3 * (size_t)got->triangle[k],
                         *m = want.normal + 3 * (size_t)want.triangle[k];
            assert_corner(got->position + 3 * (size_t)got->triangle[k], want.position + 3 * (size_t)want.triangle[k]);
            // float32 normals: 2^-25 a component before, as much again for the length made 1
            assert_true(fabs(n[0] - m[0]) < 0x1p-23 && fabs(n[1] - m[2]) < 0x1p-23 && fabs(n[2] + m[1]) < 0x1p-23);
        }
        assert_true(scene.items[part].material.base_color[0] == 0.25 + 0.25 * part);
        assert_true(scene.items[part].material.metallic == 1.0 && scene.items[part].material.roughness == 0.5);
        kn_mesh_clear(ctx, &want);
    }
    kn_scene_clear(ctx, &scene);
    clear_patches(ctx, p, 4);
    remove(path);
    test_ctx_end(ctx, &memory);
}

static void reading_gives_back_what_was_written(void **state)
{
    (void)state;
    there_and_back("back.glb", false);
    there_and_back("apart.glb", true);
    there_and_back("back.gltf", false);
}

static void a_job_of_nothing_is_a_valid_file(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "nothing.glb");
    assert_int_equal(write_patches(ctx, path, NULL, 0, 2, NULL), KN_OK);
    kn_scene scene = {0};
    assert_int_equal(kn_gltf_read(ctx, &scene, path), KN_OK);
    assert_int_equal(scene.nitems, 0);
    remove(path);
    test_ctx_end(ctx, &memory);
}

// ---- what the writer refuses ----

static void the_sink_refuses(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    kn_sink sink = {0};
    test_tmp_path(path, "refused.stl");
    assert_int_equal(kn_gltf_sink(ctx, &sink, path, NULL), KN_EDOMAIN);
    test_tmp_path(path, "refused.glb");
    assert_int_equal(kn_gltf_sink(ctx, &sink, path, &(kn_gltf_options){.unit_mm = -1}), KN_EDOMAIN);
    assert_int_equal(kn_gltf_sink(ctx, &sink, path, &(kn_gltf_options){.unit_mm = NAN}), KN_EDOMAIN);
    test_tmp_path(path, "no such folder/refused.glb");
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_gltf_sink(ctx, &sink, path, NULL), KN_EIO);
    assert_non_null(strstr(kn_ctx_message(ctx), "no such folder/refused.glb"));
    assert_null(sink.user);

    test_tmp_path(path, "beyond.glb");
    const double wild[3] = {NAN, INFINITY, 1e39};
    for (int i = 0; i < 3; i++) {
        kn_patch p = make_patch(ctx, 0, 0, 1, 1, false);
        p.bezier.coef[3] = wild[i];
        assert_int_equal(write_patches(ctx, path, &p, 1, 1, NULL), KN_EDOMAIN);
        assert_nothing_at(path);
        clear_patches(ctx, &p, 1);
    }
    assert_int_equal(kn_gltf_sink(ctx, &sink, path, NULL), KN_OK);
    kn_sink_close(ctx, &sink); // never ended
    assert_nothing_at(path);
    test_ctx_end(ctx, &memory);
}

// /dev/full refuses every byte; it is written to directly, so the ending comes from a link.
static void a_full_disk_is_reported(void **state)
{
    (void)state;
    FILE *full = fopen("/dev/full", "wb");
    if (!full) skip();
    fclose(full);
    char path[TEST_PATH_BYTES], command[2 * TEST_PATH_BYTES];
    test_tmp_path(path, "full.glb");
    snprintf(command, sizeof command, "ln -s /dev/full '%s'", path);
    if (system(command) != 0) skip();
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_patch p = make_patch(ctx, 0, 0, 64, 64, false);
    assert_int_equal(write_patches(ctx, path, &p, 1, 1, NULL), KN_EIO);
    clear_patches(ctx, &p, 1);
    remove(path);
    test_ctx_end(ctx, &memory);
}

// ---- what the reader refuses ----

static kn_status read_bytes(kn_ctx *ctx, kn_scene *out, const void *data, size_t bytes)
{
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "bad.gltf");
    test_write_file(path, data, bytes);
    kn_ctx_clear_error(ctx);
    kn_status status = kn_gltf_read(ctx, out, path);
    if (status == KN_EPARSE) {
        assert_non_null(strstr(kn_ctx_message(ctx), "bad.gltf: "));
        assert_null(strchr(kn_ctx_message(ctx), '\n'));
    }
    remove(path);
    return status;
}

static kn_status read_text(kn_ctx *ctx, kn_scene *out, const char *text)
{
    return read_bytes(ctx, out, text, strlen(text));
}

// One triangle (0,0,0), (1,0,0), (0,1,0), then the indices 0, 1, 2 as bytes and a zero: 40 bytes in base64.
#define TRIANGLE                                                                                                     \
    "\"buffers\":[{\"byteLength\":40,\"uri\":\"data:application/octet-stream;base64,"                                \
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA==\"}],"
#define VIEWS "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":3}],"
#define ACCESSORS                                                                                                    \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"                        \
    "{\"bufferView\":1,\"componentType\":5121,\"count\":3,\"type\":\"SCALAR\"}],"
#define MESH(more) "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}" more "}]}],"
#define NODE "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}"
#define HEAD "{\"asset\":{\"version\":\"2.0\"},"

static void hand_written_files_are_read(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_scene scene = {0};
    const double corner[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    static const char *const modes[] = {"", ",\"indices\":1", ",\"mode\":5", ",\"mode\":6,\"indices\":1"};
    static const int first[] = {0, 0, 0, 1}; // a fan's triangle starts at its second corner
    char text[4096];
    for (int m = 0; m < 4; m++) {
        snprintf(text, sizeof text, "%s%s",
                 HEAD TRIANGLE VIEWS ACCESSORS "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}",
                 modes[m]);
        strcat(text, "}]}]," NODE);
        assert_int_equal(read_text(ctx, &scene, text), KN_OK);
        assert_int_equal(scene.nitems, 1);
        const kn_mesh *mesh = &scene.items[0].mesh;
        assert_int_equal(mesh->ntriangles, 1);
        assert_null(mesh->normal);
        for (int k = 0; k < 3; k++)
            assert_memory_equal(mesh->position + 3 * mesh->triangle[k], corner[(first[m] + k) % 3], 24);
        assert_true(scene.items[0].material.metallic == 1.0 && scene.items[0].material.base_color[2] == 1.0);
    }
    // Nested nodes: translate by (1, 2, 3), then mirror y by a matrix: triangles turn over.
    assert_int_equal(read_text(ctx, &scene,
                               HEAD TRIANGLE VIEWS ACCESSORS MESH(
                                   "") "\"nodes\":[{\"translation\":[1,2,3],\"children\":[1]},{\"mesh\":0,"
                                       "\"matrix\":[2,0,0,0, 0,-2,0,0, 0,0,2,0, 0,0,0,1]}]}"),
                     KN_OK);
    const double moved[3][3] = {{1, 2, 3}, {3, 2, 3}, {1, 0, 3}};
    const int order[3] = {0, 2, 1};
    for (int k = 0; k < 3; k++)
        assert_memory_equal(scene.items[0].mesh.position + 3 * scene.items[0].mesh.triangle[k], moved[order[k]], 24);
    // Points are left out.
    assert_int_equal(read_text(ctx, &scene, HEAD TRIANGLE VIEWS ACCESSORS MESH(",\"mode\":0") NODE), KN_OK);
    assert_int_equal(scene.nitems, 0);
    kn_scene_clear(ctx, &scene);
    test_ctx_end(ctx, &memory);
}

static void bad_structure_is_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",
        "not glTF at all",
        "{}",
        "[1,2,3]",
        "{\"asset\":{\"version\":\"2.0\"}",
        "{\"asset\":{\"version\":\"1.0\"}}",
        HEAD "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}",
        // a node that is its own child, two roots that share a child, a node and a mesh that are not there
        HEAD TRIANGLE VIEWS ACCESSORS MESH(
            "") "\"nodes\":[{\"mesh\":0,\"children\":[0]}],\"scenes\":[{\"nodes\":[0]}]}",
        HEAD "\"nodes\":[{\"children\":[2]},{\"children\":[2]},{}],\"scenes\":[{\"nodes\":[0,1]}]}",
        HEAD "\"nodes\":[{}],\"scenes\":[{\"nodes\":[1]}]}",
        HEAD "\"nodes\":[{}],\"scenes\":[{\"nodes\":[-1]}]}",
        HEAD "\"nodes\":[{\"mesh\":7}],\"scenes\":[{\"nodes\":[0]}]}",
        // accessors: counts beyond the buffer, of a billion, that would overflow, none at all
        HEAD TRIANGLE VIEWS
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":1000000000,\"type\":\"VEC3\"}]," MESH("")
            NODE,
        HEAD TRIANGLE VIEWS "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":6148914691236517206,"
                            "\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":-3,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":0,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS "\"accessors\":[{\"bufferView\":0,\"byteOffset\":18446744073709551600,\"componentType\":"
                            "5126,\"count\":3,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS
        "\"accessors\":[{\"bufferView\":9,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS "\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5123,\"count\":3,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}]," MESH("") NODE,
        HEAD TRIANGLE VIEWS ACCESSORS MESH(",\"indices\":5") NODE,
        HEAD TRIANGLE VIEWS ACCESSORS MESH(",\"indices\":0") NODE,
        // views and buffers
        HEAD TRIANGLE
        "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":8,\"byteLength\":36}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE
        "\"bufferViews\":[{\"buffer\":3,\"byteLength\":36}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD TRIANGLE
        "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":18446744073709551600,\"byteLength\":36}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]," MESH("") NODE,
        HEAD "\"buffers\":[{\"byteLength\":36}]," VIEWS ACCESSORS MESH("") NODE,
        HEAD "\"buffers\":[{\"byteLength\":36,\"uri\":\"no such file.bin\"}]," VIEWS ACCESSORS MESH("") NODE,
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_scene scene = {0};
    assert_int_equal(read_text(ctx, &scene, HEAD TRIANGLE VIEWS ACCESSORS MESH("") NODE), KN_OK);
    const kn_scene_item *before = scene.items;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        kn_status status = read_text(ctx, &scene, bad[i]);
        if (status != KN_EPARSE) fail_msg("bad file %zu: %s", i, kn_status_name(status));
        assert_ptr_equal(scene.items, before);
    }
    // Nesting that would exhaust a recursive parser's stack.
    enum { DEEP = 200000 };
    char *deep = malloc(2 * DEEP + 64);
    int n = sprintf(deep, "{\"extras\":");
    memset(deep + n, '[', DEEP);
    memset(deep + n + DEEP, ']', DEEP);
    strcpy(deep + n + 2 * DEEP, "}");
    assert_int_equal(read_text(ctx, &scene, deep), KN_EPARSE);
    free(deep);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "not there.glb");
    assert_int_equal(kn_gltf_read(ctx, &scene, path), KN_EIO);
    kn_scene_clear(ctx, &scene);
    test_ctx_end(ctx, &memory);
}

// An index that is out of range, and a vertex that is not a number, in a file that is sound otherwise.
static void bad_data_is_refused(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "data.glb");
    kn_patch p = make_patch(ctx, 0, 0, 1, 1, false);
    kn_scene scene = {0};
    for (int what = 0; what < 2; what++) {
        assert_int_equal(write_patches(ctx, path, &p, 1, 1, NULL), KN_OK);
        size_t bytes;
        char *file = test_read_file(path, &bytes), *bin = file + 28 + word(file + 12);
        const float nan = NAN;
        const uint16_t beyond = 4;
        if (what == 0) memcpy(bin + 4, &nan, 4);
        if (what == 1) memcpy(bin + 4 * 24, &beyond, 2); // behind 4 vertices
        assert_int_equal(read_bytes(ctx, &scene, file, bytes), KN_EPARSE);
        free(file);
    }
    clear_patches(ctx, &p, 1);
    remove(path);
    test_ctx_end(ctx, &memory);
}

// Every truncation is refused; bytes changed at random never do harm.
static void damaged_files_do_no_harm(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "damaged.glb");
    kn_patch p = make_patch(ctx, 0, 0, 1, 1, false);
    assert_int_equal(write_patches(ctx, path, &p, 1, 1, NULL), KN_OK);
    size_t bytes;
    char *file = test_read_file(path, &bytes);
    kn_scene scene = {0};
    for (size_t n = 0; n < bytes; n += n < 32 ? 1 : 37) assert_int_equal(read_bytes(ctx, &scene, file, n), KN_EPARSE);
    test_rng rng = test_random(7);
    for (int i = 0; i < test_scale(300); i++) {
        char *copy = malloc(bytes);
        memcpy(copy, file, bytes);
        for (int k = test_int(&rng, 1, 4); k > 0; k--)
            copy[test_int(&rng, 0, (int)bytes - 1)] = (char)test_int(&rng, -128, 127);
        kn_status status = read_bytes(ctx, &scene, copy, bytes);
        assert_true(status == KN_OK || status == KN_EPARSE);
        free(copy);
    }
    kn_scene_clear(ctx, &scene);
    free(file);
    clear_patches(ctx, &p, 1);
    remove(path);
    test_ctx_end(ctx, &memory);
}

// ---- memory ----

static kn_status write_two(kn_ctx *ctx, void *path)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *own = test_ctx(&memory, 1); // the patches are not what is tested
    kn_patch p[4] = {make_patch(own, 0, 0, 2, 2, false), make_patch(own, 2, 1, 2, 2, false),
                     make_patch(own, 4, 0, 2, 2, false), make_curve(own, 6, 1, 4)};
    kn_status status = write_patches(ctx, path, p, 4, 2, NULL);
    if (status != KN_OK) assert_nothing_at(path);
    clear_patches(own, p, 4);
    test_ctx_end(own, &memory);
    return status;
}

static kn_status read_two(kn_ctx *ctx, void *path)
{
    kn_scene scene = {0};
    kn_status status = kn_gltf_read(ctx, &scene, path);
    if (status != KN_OK) assert_true(scene.items == NULL && scene.nitems == 0);
    kn_scene_clear(ctx, &scene);
    return status;
}

static void running_out_of_memory_leaves_nothing(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "memory.glb");
    test_allocation_failures(write_two, path);
    test_allocation_failures(read_two, path);
    remove(path);
}

// ---- scenes with colours ----

static void colors_come_back(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "colors.glb");
    double position[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, normal[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    uint32_t triangle[3] = {0, 1, 2};
    float color[9] = {0.25F, 0.5F, 0.75F, 0, 1, 0, 1, 0, 0.125F};
    kn_scene_item item = {
        .mesh = {.nvertices = 3, .ntriangles = 1, .position = position, .normal = normal, .triangle = triangle},
        .material = {{1, 1, 1}, 0, 0.5},
        .color = color};
    kn_gltf_options o = {.unit_mm = 1000, .extras = "{\"legend\":{\"unit\":\"mm\",\"stops\":[1,2.5,true]}}"};
    assert_int_equal(kn_gltf_write(ctx, path, &(kn_scene){&item, 1}, &o), KN_OK);
    kn_scene scene = {0};
    assert_int_equal(kn_gltf_read(ctx, &scene, path), KN_OK);
    assert_int_equal(scene.nitems, 1);
    assert_memory_equal(scene.items[0].color, color, sizeof color);
    assert_int_equal(scene.items[0].mesh.ntriangles, 1);
    assert_true(scene.items[0].material.roughness == 0.5);
    glb g = open_glb(path);
    assert_non_null(member(g.json, "asset"));
    const char *extras = member(member(g.json, "asset"), "extras");
    assert_non_null(extras);
    assert_true(strtod(element(member(member(extras, "legend"), "stops"), 1), NULL) == 2.5);
    close_glb(&g);

    // What is refused leaves nothing.
    remove(path);
    triangle[1] = 3;
    assert_int_equal(kn_gltf_write(ctx, path, &(kn_scene){&item, 1}, NULL), KN_EDOMAIN);
    triangle[1] = 1;
    item.mesh.normal = NULL;
    assert_int_equal(kn_gltf_write(ctx, path, &(kn_scene){&item, 1}, NULL), KN_EDOMAIN);
    item.mesh.normal = normal;
    assert_int_equal(kn_gltf_write(ctx, path, &(kn_scene){&item, 1}, &(kn_gltf_options){.extras = "{"}), KN_EIO);
    assert_nothing_at(path);
    assert_int_equal(kn_gltf_write(ctx, "x.stl", &(kn_scene){&item, 1}, NULL), KN_EDOMAIN);
    kn_scene_clear(ctx, &scene);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colors_come_back),
        cmocka_unit_test(the_file_is_what_the_specification_says),
        cmocka_unit_test(wide_indices_where_they_are_needed),
        cmocka_unit_test(curves_are_lines),
        cmocka_unit_test(reading_gives_back_what_was_written),
        cmocka_unit_test(a_job_of_nothing_is_a_valid_file),
        cmocka_unit_test(the_sink_refuses),
        cmocka_unit_test(a_full_disk_is_reported),
        cmocka_unit_test(hand_written_files_are_read),
        cmocka_unit_test(bad_structure_is_refused),
        cmocka_unit_test(bad_data_is_refused),
        cmocka_unit_test(damaged_files_do_no_harm),
        cmocka_unit_test(running_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests_name("bridges/gltf", tests, NULL, NULL);
}
