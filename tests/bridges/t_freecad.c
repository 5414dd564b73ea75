// SPDX-License-Identifier: Apache-2.0
// STEP and IGES as FreeCAD's own importer opens them, without a window, where it is installed (Debian: freecad-python3).
#include "tests/support/integral.h"
#include "tests/support/surfaces.h"

#include <knurl/iges.h>
#include <knurl/step.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEP, IGES, WRITERS };

// One job into a file of either format, with the integrals of what it holds.
static test_integrals write_files(char path[WRITERS][TEST_PATH_BYTES], const char *tile_name,
                                  void (*make)(kn_ctx *ctx, kn_spline *out), const kn_job_options *options)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 0);
    test_integrals ours = {0};
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_sink sinks[WRITERS + 1] = {{0}, {0}, test_integral_sink(&ours)};
    test_tmp_path(path[STEP], "freecad.step"), test_tmp_path(path[IGES], "freecad.igs");
    make(ctx, &base);
    assert_int_equal(kn_builtin_tile(ctx, &tile, tile_name), KN_OK);
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, options), KN_OK);
    assert_int_equal(kn_step_sink(ctx, &sinks[STEP], path[STEP], NULL), KN_OK);
    assert_int_equal(kn_iges_sink(ctx, &sinks[IGES], path[IGES], NULL), KN_OK);
    assert_int_equal(kn_job_run(ctx, job, sinks, WRITERS + 1), KN_OK);
    kn_sink_close(ctx, &sinks[STEP]), kn_sink_close(ctx, &sinks[IGES]);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
    return ours;
}

// The line "knurl FIELD.." that the script prints of the file; what FreeCAD says beside it is its own.
static void ask_freecad(const char *path, const test_integrals *ours)
{
    char command[4 * TEST_PATH_BYTES], line[512];
    bool found = false;
    (void)snprintf(command, sizeof command, "KNURL_FILE='%s' freecadcmd tests/bridges/in_freecad.py 2>&1", path);
    FILE *answers = popen(command, "r");
    assert_non_null(answers);
    while (fgets(line, sizeof line, answers)) {
        int solids, faces, valid;
        double volume;
        const char *at = strstr(line, "knurl ");
        if (!at || sscanf(at, "knurl %d %d %d %lf", &solids, &faces, &valid, &volume) != 4) continue;
        found = true;
        assert_int_equal(solids, 1);
        assert_int_equal(faces, ours->faces);
        assert_int_equal(valid, 1);
        assert_true(fabs(volume - ours->volume) <= 1e-6 * ours->volume); // by OCCT's quadrature
    }
    assert_int_equal(pclose(answers), 0);
    assert_true(found);
}

static void import(const char *tile, void (*make)(kn_ctx *ctx, kn_spline *out), const kn_job_options *options)
{
    char path[WRITERS][TEST_PATH_BYTES];
    if (system("command -v freecadcmd >/dev/null 2>&1") != 0) {
        print_message("no FreeCAD here\n");
        skip();
    }
    test_integrals ours = write_files(path, tile, make, options);
    for (int w = 0; w < WRITERS; w++) {
        ask_freecad(path[w], &ours);
        remove(path[w]);
    }
}

static void struts_on_a_plane(void **state)
{
    (void)state;
    import("cross", make_plane, &(kn_job_options){.count = { 2, 2 }});
}

static void struts_around_a_cylinder(void **state)
{
    (void)state;
    import("cross", make_cylinder, &(kn_job_options){.count = {8, 2}, .height = 0.3, .normal_tol = 1e-5});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(struts_on_a_plane),
        cmocka_unit_test(struts_around_a_cylinder),
    };
    return cmocka_run_group_tests_name("bridges/freecad", tests, NULL, NULL);
}
