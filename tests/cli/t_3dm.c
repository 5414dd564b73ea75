// SPDX-License-Identifier: Apache-2.0
// Rhino files: what McNeel's rhino3dm reads in them (where node and the package are there), and what is refused.
#include "tests/cli/command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char reader[] =
    "require('rhino3dm')().then(r => {"
    "const f = r.File3dm.fromByteArray(new Uint8Array(require('fs').readFileSync(process.argv[1])));"
    "const o = f.objects(), g = o.get(0).geometry(), c = o.get(0).attributes().objectColor, p = g.pointAt(0.25, "
    "0.75);"
    "let valid = 0; for (let i = 0; i < o.count; i++) valid += o.get(i).geometry().isValid ? 1 : 0;"
    "console.log(JSON.stringify({count: o.count, valid: valid, mm: f.settings().modelUnitSystem ==="
    "r.UnitSystem.Millimeters, point: p, color: [c.r, c.g, c.b]})); })";

static bool has_rhino3dm(void)
{
    return system("node -e \"require('rhino3dm')\" >/dev/null 2>&1") == 0;
}

// {..} that the reader prints of a file.
static json_t *read_back(const char *path)
{
    char command[4096], text[TEXT_BYTES];
    (void)snprintf(command, sizeof command, "node -e \"%s\" %s", reader, path);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    size_t n = fread(text, 1, sizeof text - 1, pipe);
    text[n] = '\0';
    assert_int_equal(pclose(pipe), 0);
    json_t *o = json_loads(text, 0, NULL);
    assert_non_null(o);
    return o;
}

static void surfaces_come_back(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    if (!has_rhino3dm()) skip();
    test_tmp_path(path, "pot.3dm");
    assert_int_equal(run("convert data/teapot.bpt -o %s -q", path), 0);
    json_t *o = read_back(path);
    assert_int_equal(json_integer_value(json_object_get(o, "count")), 32);
    assert_int_equal(json_integer_value(json_object_get(o, "valid")), 32);
    assert_true(json_is_true(json_object_get(o, "mm")));
    assert_int_equal(run("eval data/teapot.bpt --at 0.25,0.75 --patch 0 --json"), 0);
    json_t *ours = printed_json();
    const json_t *point = json_array_get(json_object_get(json_array_get(ours, 0), "values"), 0);
    assert_int_equal(json_array_size(point), 3);
    // both sides round some 30 times at most, on numbers below 4
    for (size_t c = 0; c < 3; c++)
        assert_true(fabs(json_real_value(json_array_get(point, c)) -
                         json_number_value(json_array_get(json_object_get(o, "point"), c))) < 30 * 4 * 1.2e-16);
    json_decref(o), json_decref(ours);
    remove(path);
}

// What rhino3dm does not take is said, and nothing is left behind.
static void refusals(void **state)
{
    (void)state;
    char path[PATH_BYTES], command[2 * PATH_BYTES];
    test_tmp_path(path, "never.3dm");
    assert_int_equal(setenv("KNURL_3DM", "/nowhere/knurl-3dm.cjs", 1), 0);
    assert_int_equal(run("convert data/teapot.bpt -o %s -q", path), 1);
    assert_non_null(strstr(complained, "never.3dm: "));
    assert_int_equal(unsetenv("KNURL_3DM"), 0);
    assert_false(exists(path));
    (void)snprintf(command, sizeof command, "! ls %s.tmp* >/dev/null 2>&1", path);
    assert_int_equal(system(command), 0);
}

// Before anything is composed: what .3dm files do not hold, a program that is not there or only in the working folder,
// a name that is taken by what is no file.
static void early_refusals(void **state)
{
    (void)state;
    char path[PATH_BYTES], folder[PATH_BYTES];
    test_tmp_path(path, "early.3dm"), test_tmp_path(folder, "taken.3dm");
    assert_int_equal(
        run("apply data/cone.g2 --tile cross --count 4,2 --height 0.1 --max-degree exact -o %s -q", path), 3);
    assert_non_null(strstr(complained, "early.3dm: some patches are volumes"));
    assert_int_equal(mkfifo(folder, 0600), 0);
    assert_int_equal(run("convert data/teapot.bpt -o %s -q", folder), 1);
    assert_non_null(strstr(complained, "it is there, and no file"));
    struct stat there;
    assert_int_equal(stat(folder, &there), 0);
    assert_true(S_ISFIFO(there.st_mode));
    assert_int_equal(setenv("KNURL_3DM", "README.md", 1), 0); // a name without a folder
    assert_int_equal(run("convert data/teapot.bpt -o %s -q", path), 1);
    assert_non_null(strstr(complained, "which is not beside knurl"));
    assert_int_equal(unsetenv("KNURL_3DM"), 0);
    assert_false(exists(path));
    remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_come_back),
        cmocka_unit_test(refusals),
        cmocka_unit_test(early_refusals),
    };
    return cmocka_run_group_tests_name("cli/3dm", tests, NULL, NULL);
}
