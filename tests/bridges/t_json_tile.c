// SPDX-License-Identifier: Apache-2.0
// Tile descriptions in JSON: what they give, and the message for each slip of the pen.
#include "tests/support/support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include <knurl/io.h>

#include "bridges/jansson/text.h"
#include "bridges/jansson/tile.h"

// Splines by the library; a ".obj" is a triangle whose height is the file's first number.
static kn_status read_part(kn_ctx *ctx, void *user, kn_tile_part *part, const char *path)
{
    ++*(int *)user;
    if (!strstr(path, ".obj")) {
        kn_model model = {0};
        kn_status status = kn_read_model(ctx, &model, path);
        part->splines = model.splines;
        part->nsplines = model.nsplines;
        return status;
    }
    double position[9] = {0, 0, 0, 1, 0, 0, 0, 1, strstr(path, "high") ? 2 : 1};
    uint32_t triangle[3] = {0, 1, 2};
    kn_mesh mesh = {.nvertices = 3, .ntriangles = 1, .position = position, .triangle = triangle};
    kn_tile holder = {0};
    kn_status status = kn_tile_init(ctx, &holder, "x", 1);
    if (status == KN_OK) status = kn_tile_set_mesh(ctx, &holder, 0, &mesh);
    if (status == KN_OK) {
        part->mesh = holder.parts[0].mesh;
        holder.parts[0].mesh = (kn_mesh){0};
    }
    kn_tile_clear(ctx, &holder);
    return status;
}

static kn_status read_text(kn_ctx *ctx, kn_tile_file *out, const char *text)
{
    char path[TEST_PATH_BYTES];
    int files = 0;
    test_tmp_path(path, "tile.json");
    test_write_file(path, text, strlen(text));
    return kn_json_tile_read(ctx, out, path, read_part, &files);
}

// The folder of test files, where descriptions lie, holds a surface and its target.
static void write_surfaces(void)
{
    static const char text[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n4 0 0\n0 4 0\n4 4 %d\n";
    char path[TEST_PATH_BYTES], filled[256];
    for (int i = 0; i < 2; i++) {
        snprintf(filled, sizeof filled, text, 2 + 2 * i);
        test_tmp_path(path, i ? "sheet@up.g2" : "sheet.g2");
        test_write_file(path, filled, strlen(filled));
    }
}

// Names of this process alone.
static const char *local(const char *name, char path[TEST_PATH_BYTES])
{
    test_tmp_path(path, name);
    return strrchr(path, '/') + 1;
}

static void fill(char *text, size_t bytes)
{
    char a[TEST_PATH_BYTES], b[TEST_PATH_BYTES];
    snprintf(
        text, bytes,
        "{\"format\":1,\"kind\":\"tile\",\"name\":\"roof\",\"about\":\"two parts\",\"covering\":true,"
        "\"cell\":[0,0,4,4],\"height\":2,\"parts\":["
        "{\"name\":\"sheet\",\"file\":\"%s\",\"material\":{\"color\":[1,0.5,0],\"metallic\":1,\"roughness\":0.1}},"
        "{\"name\":\"top\",\"file\":\"low.obj\"}],"
        "\"parameters\":[{\"name\":\"up\",\"value\":1,\"target\":3,\"range\":[0,4],"
        "\"files\":{\"sheet\":\"%s\",\"top\":\"high.obj\"}}],"
        "\"defaults\":{\"size\":[\"3mm\",4],\"rows\":true,\"stretch\":false,\"stagger\":0.5}}",
        local("sheet.g2", a), local("sheet@up.g2", b));
}

static void a_tile_as_described(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile_file file = {0};
    char text[2048];
    write_surfaces();
    fill(text, sizeof text);
    assert_int_equal(read_text(ctx, &file, text), KN_OK);
    const kn_tile *t = &file.tile;
    assert_string_equal(t->name, "roof");
    assert_string_equal(t->about, "two parts");
    assert_true(t->covering && t->aspect == 0.5 && t->nparts == 2 && t->nparameters == 1);
    assert_string_equal(t->parts[0].name, "sheet");
    assert_true(t->parts[0].material.base_color[1] == 0.5 && t->parts[0].material.roughness == 0.1);
    assert_true(t->parts[1].material.roughness == 0.4); // the default
    assert_true(t->parts[0].splines[0].coef[11] == 1 && t->parts[0].targets[0].coef[11] == 2);
    assert_true(t->parts[1].mesh.position[8] == 0.5 && t->parts[1].mesh_targets[0][8] == 1);
    assert_true(t->parameters[0].value == 1 && t->parameters[0].target == 3 && t->parameters[0].hi == 4);
    assert_int_equal(file.ndefaults, 3); // a false flag is none
    assert_string_equal(file.defaults[0].key, "size");
    assert_string_equal(file.defaults[0].value, "3mm,4");
    assert_string_equal(file.defaults[1].key, "rows");
    assert_string_equal(file.defaults[2].value, "0.5");
    kn_tile_clear(ctx, &file.tile);
    test_ctx_end(ctx, &memory);
}

static void slips_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to, *message; // in the description above
    } slips[] = {
        {"\"format\":1", "\"format\":2", "\"format\": expected 1"},
        {"\"format\":1,", "", "\"format\": expected 1"},
        {"\"kind\":\"tile\"", "\"kind\":\"job\"", "\"kind\": expected \"tile\""},
        {"\"kind\":\"tile\",", "", "\"kind\""},
        {"\"name\":\"roof\",", "", "\"name\": expected a text"},
        {"\"about\":", "\"abuot\":", "unknown key \"abuot\""},
        {"\"covering\":true", "\"covering\":1", "\"covering\": expected true or false"},
        {"[0,0,4,4]", "[0,0,4]", "\"cell\": expected an array of 4 numbers"},
        {"[0,0,4,4]", "[0,0,0,4]", "u0 < u1"},
        {"\"height\":2", "\"height\":-2", "\"height\": expected a number above 0"},
        {"\"metallic\":1", "\"metallic\":2", "\"parts[0].metallic\": expected a number from 0 to 1"},
        {"[1,0.5,0]", "[1,0.5,2]", "\"parts[0].color\": expected three numbers from 0 to 1"},
        {"\"roughness\"", "\"rough\"", "unknown key \"parts[0].rough\""},
        {"{\"name\":\"top\",", "{", "\"parts[1].name\": expected a text"},
        {"\"name\":\"top\"", "\"name\":\"sheet\"", "\"parts[1].name\": expected a name that no other part has"},
        {"\"file\":\"low.obj\"", "\"flie\":\"low.obj\"", "unknown key \"parts[1].flie\""},
        {"\"file\":\"low.obj\"", "\"file\":3", "\"parts[1].file\": expected the path of a file"},
        {"\"file\":\"low.obj\"", "\"file\":\"low.g2\"", "low.g2: cannot open"},
        {"\"target\":3", "\"target\":1", "parameter"},
        {"\"value\":1", "\"value\":\"1\"", "\"parameters[0].value\": expected a number"},
        {"\"range\"", "\"ragne\"", "unknown key \"parameters[0].ragne\""},
        {"\"top\":\"high.obj\"", "\"topp\":\"high.obj\"", "\"parameters[0].files\": no part 'topp'"},
        {"\"top\":\"high.obj\"", "\"sheet\":\"high.obj\"", "duplicate"},
        {"\"rows\":true", "\"seed\":1", "unknown key \"defaults.seed\""},
        {"\"rows\":true", "\"count\":{}", "\"defaults.count\": expected a number, a text, or an array of them"},
        {"\"defaults\":{", "\"defaults\":[", "tile.json:1: "},
        {"\"parts\":[", "\"parts\":{},\"x\":[", "\"parts\": expected an array of objects"},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char good[2048], text[4096];
    write_surfaces();
    fill(good, sizeof good);
    for (size_t i = 0; i < sizeof slips / sizeof *slips; i++) {
        kn_tile_file file = {0};
        const char *at = strstr(good, slips[i].from);
        assert_non_null(at);
        snprintf(text, sizeof text, "%.*s%s%s", (int)(at - good), good, slips[i].to, at + strlen(slips[i].from));
        kn_ctx_clear_error(ctx);
        assert_int_not_equal(read_text(ctx, &file, text), KN_OK);
        if (!strstr(kn_ctx_message(ctx), slips[i].message)) fail_msg("%s: %s", slips[i].to, kn_ctx_message(ctx));
        assert_null(strchr(kn_ctx_message(ctx), '\n'));
        assert_null(file.tile.parts);
    }
    kn_tile_file file = {0};
    int files = 0;
    assert_int_equal(read_text(ctx, &file, ""), KN_EPARSE);
    assert_int_equal(read_text(ctx, &file, "[1]"), KN_EPARSE);
    assert_int_equal(kn_json_tile_read(ctx, &file, "no such folder/x.json", read_part, &files), KN_EIO);
    test_ctx_end(ctx, &memory);
}

static kn_status read_good(kn_ctx *ctx, void *text)
{
    kn_tile_file file = {0};
    kn_status status = read_text(ctx, &file, text);
    if (status != KN_OK) assert_null(file.tile.parts);
    kn_tile_clear(ctx, &file.tile);
    return status;
}

static void running_out_of_memory(void **state)
{
    (void)state;
    char text[2048];
    write_surfaces();
    fill(text, sizeof text);
    test_allocation_failures(read_good, text);
}

static void values_as_texts(void **state)
{
    (void)state;
    static const char *const cases[][2] = {{"[3]", "3"},
                                           {"[0.1]", "0.10000000000000001"},
                                           {"[[1,2.5]]", "1,2.5"},
                                           {"[\"a b\"]", "a b"},
                                           {"[[\"3mm\",4]]", "3mm,4"},
                                           {"[[]]", ""},
                                           {"[{}]", NULL},
                                           {"[true]", NULL},
                                           {"[[1,[2]]]", NULL},
                                           {"[null]", NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        json_t *array = json_loads(cases[i][0], 0, NULL);
        char *text = kn_json_text(json_array_get(array, 0));
        if (cases[i][1])
            assert_string_equal(text, cases[i][1]);
        else
            assert_null(text);
        free(text);
        json_decref(array);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tile_as_described),
        cmocka_unit_test(slips_are_named),
        cmocka_unit_test(running_out_of_memory),
        cmocka_unit_test(values_as_texts),
    };
    return cmocka_run_group_tests_name("bridges/json_tile", tests, NULL, NULL);
}
