// SPDX-License-Identifier: Apache-2.0
// The command line as scripts see it: exit codes, what goes to which stream, JSON keys, files made and not made.
#include "tests/cli/command.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static void usage_errors(void **state)
{
    (void)state;
    assert_int_equal(run(" "), 2);
    assert_int_equal(run("aply"), 2);
    assert_non_null(strstr(complained, "did you mean 'apply'"));
    assert_string_equal(printed, "");
    assert_int_equal(run("apply"), 2);
    assert_int_equal(run("apply data/teapot.bpt --tile chain"), 2);
    assert_int_equal(run("apply data/teapot.bpt --tile chian --dry-run"), 2);
    assert_non_null(strstr(complained, "did you mean 'chain'"));
    assert_int_equal(run("apply data/teapot.bpt --tile bump --cuont 3 --dry-run"), 2);
    assert_non_null(strstr(complained, "did you mean '--count'"));
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 0 --dry-run"), 2);
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 1e9 --dry-run"), 2);
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 65537 --dry-run"), 2);
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 2,2,2 --dry-run"), 2);
    assert_non_null(strstr(complained, "at most 2 numbers"));
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 2 --size 1 --dry-run"), 2);
    assert_int_equal(run("apply data/teapot.bpt --tile bump --height 0 --dry-run"), 2);
    assert_int_equal(run("apply data/teapot.bpt --tile bump --size nan --dry-run"), 2);
    assert_int_equal(run("apply data/teapot.bpt --tile bump -o x.dwg"), 2);
    assert_non_null(strstr(complained, ".step"));
    assert_int_equal(run("eval data/teapot.bpt"), 2);
    assert_int_equal(run("eval data/teapot.bpt --at 2,0.5"), 2);
    assert_int_equal(run("eval data/teapot.bpt --patch 32 --at 0,0"), 2);
    assert_int_equal(run("eval data/teapot.bpt --at 0.5,0.5,0 --normal-tol -1"), 2);
    assert_int_equal(run("info"), 2);
    assert_int_equal(run("tiles extra"), 2);
}

static void help_starts_with_examples(void **state)
{
    (void)state;
    static const char *const commands[] = {"apply", "check", "slice", "tiles", "info", "eval", "render", "animate"};
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        assert_int_equal(run("%s --help", commands[i]), 0);
        char example[64];
        snprintf(example, sizeof example, "\n\n  knurl %s ", commands[i]);
        assert_non_null(strstr(printed, example));
    }
    assert_int_equal(run("--help"), 0);
    assert_int_equal(run("--version"), 0);
    assert_string_equal(printed, "knurl " KN_VERSION_STRING "\n");
}

static void tiles_as_json(void **state)
{
    (void)state;
    assert_int_equal(run("tiles --json"), 0);
    json_t *tiles = json_loads(printed, 0, NULL);
    assert_true(json_is_array(tiles));
    static const char *const names[] = {"chain", "scale", "thorn", "knurl", "bump"};
    for (size_t n = 0; n < 5; n++) {
        bool found = false;
        for (size_t i = 0; i < json_array_size(tiles); i++)
            found |= strcmp(json_string_value(json_object_get(json_array_get(tiles, i), "name")), names[n]) == 0;
        assert_true(found);
    }
    const json_t *bend = json_array_get(json_object_get(json_array_get(tiles, 2), "parameters"), 0); // of thorn
    assert_string_equal(json_string_value(json_object_get(bend, "name")), "bend");
    assert_true(json_number_value(json_array_get(json_object_get(bend, "range"), 1)) == 1.0);
    json_decref(tiles);
}

// What is proved of a tile, and the exit code when it is torn or does not cover.
static void tiles_checked(void **state)
{
    (void)state;
    char torn[PATH_BYTES];
    assert_int_equal(run("tiles --check bump"), 0);
    assert_non_null(strstr(printed, "covers  yes"));
    assert_int_equal(run("tiles --check scale --json"), 0);
    json_t *o = json_loads(printed, 0, NULL);
    assert_true(json_is_true(json_object_get(o, "ok")));
    assert_true(json_is_true(json_object_get(o, "covering")));
    assert_true(json_is_object(json_object_get(o, "periodicity")));
    json_decref(o);
    // A sheet over the whole cell that rises along u: its border at u = 1 has no mate.
    test_tmp_path(torn, "torn.g2");
    FILE *f = fopen(torn, "w");
    assert_non_null(f);
    fputs("200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 1\n0 1 0\n1 1 1\n", f);
    assert_int_equal(fclose(f), 0);
    assert_int_equal(run("tiles --check '%s'", torn), 4);
    assert_non_null(strstr(complained, "torn"));
    assert_int_equal(run("tiles --check '%s' --json", torn), 4);
    assert_int_equal(run("tiles --check scal"), 2);
    assert_non_null(strstr(complained, "scale"));
    assert_int_equal(run("tiles --check no-such.g2"), 3);
    assert_int_equal(run("tiles --check '%s' --tile-cell 1,1,0,0", torn), 2);
}

// P(u,v) of patch 0 at (0,0) is its first control point, (1.4, 0, 2.4); T at w = 0 is S.
static void eval_values(void **state)
{
    (void)state;
    double x, y, z;
    assert_int_equal(run("eval data/teapot.bpt --at 0,0"), 0);
    assert_int_equal(sscanf(printed, "%lf %lf %lf", &x, &y, &z), 3);
    assert_true(x == 1.4 && y == 0.0 && z == 2.4);
    assert_int_equal(run("eval data/teapot.bpt --at 0.25,0.5 --at 0.25,0.5,0 --json"), 0);
    json_t *all = json_loads(printed, 0, NULL);
    assert_int_equal(json_array_size(all), 2);
    for (size_t c = 0; c < 3; c++) {
        double at[2];
        for (size_t i = 0; i < 2; i++)
            at[i] = json_number_value(
                json_array_get(json_array_get(json_object_get(json_array_get(all, i), "values"), 0), c));
        // One de Casteljau and one knot-inserted evaluation of numbers below 3: each within 1e-15 * 3 * a few steps.
        assert_true(at[0] - at[1] < 1e-13 && at[1] - at[0] < 1e-13);
    }
    json_decref(all);
    assert_int_equal(run("eval data/teapot.bpt --at 0.25,0.5 --derivatives 2"), 0);
    int lines = 0;
    for (const char *p = printed; *p; p++) lines += *p == '\n';
    assert_int_equal(lines, 6);
}

static void info_of_teapot(void **state)
{
    (void)state;
    assert_int_equal(run("info data/teapot.bpt --json"), 0);
    json_t *info = json_loads(printed, 0, NULL);
    assert_int_equal(json_integer_value(json_object_get(info, "surfaces")), 32);
    assert_int_equal(json_integer_value(json_object_get(info, "control_points")), 512);
    json_decref(info);
}

static void dry_run_reports_and_writes_nothing(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    test_tmp_path(path, "dry.step");
    assert_int_equal(
        run("apply data/teapot.bpt --tile bump --count 2 --normal-tol 1e-3 --dry-run --json -o '%s'", path), 0);
    assert_false(exists(path));
    json_t *r = json_loads(printed, 0, NULL);
    static const char *const keys[] = {"cells",  "patches", "faces",    "triangles", "degree",  "control_points",
                                       "normal", "fit",     "jacobian", "bytes",     "seconds", "peak_bytes"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) assert_non_null(json_object_get(r, keys[i]));
    assert_int_equal(json_integer_value(json_object_get(r, "cells")), 32 * 4);
    json_t *normal = json_object_get(r, "normal");
    assert_true(json_is_true(json_object_get(normal, "certified")));
    assert_true(json_number_value(json_object_get(normal, "length_error")) <= 1e-3);
    assert_true(json_number_value(json_object_get(normal, "angle_error_rad")) <= 1e-3);
    json_decref(r);
}

static void apply_writes_what_it_reports(void **state)
{
    (void)state;
    char stl[PATH_BYTES], step[PATH_BYTES];
    test_tmp_path(stl, "bump.stl");
    test_tmp_path(step, "bump.step");
    assert_int_equal(
        run("apply data/teapot.bpt --tile bump --count 1 --normal-tol 1e-3 --json -o '%s' -o '%s'", stl, step), 0);
    for (const char *line = complained, *end; *line; line = end + 1) { // a slow machine may say how far it is
        end = strchr(line, '\n');
        assert_true(end && end - line > 14 && memcmp(line, "knurl: ", 7) == 0 && memcmp(end - 7, " s left", 7) == 0);
    }
    json_t *r = json_loads(printed, 0, NULL);
    struct stat info;
    assert_int_equal(stat(stl, &info), 0);
    assert_int_equal(json_integer_value(json_object_get(json_object_get(r, "bytes"), stl)), info.st_size);
    assert_int_equal(stat(step, &info), 0);
    assert_int_equal(json_integer_value(json_object_get(json_object_get(r, "bytes"), step)), info.st_size);
    json_decref(r);
}

static void same_bytes_for_any_threads(void **state)
{
    (void)state;
    char one[PATH_BYTES], two[PATH_BYTES], line[3 * PATH_BYTES];
    test_tmp_path(one, "one.step");
    test_tmp_path(two, "two.step");
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 1 --normal-tol 1e-3 -q -j 1 -o '%s'", one), 0);
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 1 --normal-tol 1e-3 -q -j 3 -o '%s'", two), 0);
    snprintf(line, sizeof line, "cmp '%s' '%s'", one, two);
    assert_int_equal(system(line), 0);
}

static void bad_input_is_3_and_keeps_the_old_file(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"", "bad.bpt"},
        {"1\n3 3\n0 0 0\n", "bad.bpt:"},
        {"1000000000\n3 3\n", "1000000000"},
        {"1\n1 1\n0 0 0\n1 0 0\n0 1 0\nnan 1 0\n", "bad.bpt:6"},
        {"1\n1 1\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n", "zero area"},
    };
    char bad[PATH_BYTES], out[PATH_BYTES];
    test_tmp_path(bad, "bad.bpt");
    test_tmp_path(out, "kept.stl");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_text(bad, cases[i].text);
        write_text(out, "precious");
        assert_int_equal(run("apply '%s' --tile bump --count 2 -o '%s'", bad, out), 3);
        assert_non_null(strstr(complained, cases[i].says));
        assert_int_equal(strchr(complained, '\n') - complained, strlen(complained) - 1); // one line
        slurp(out, printed);
        assert_string_equal(printed, "precious");
    }
    assert_int_equal(run("info /nonexistent/x.bpt"), 3);
    assert_int_equal(run("info data/teapot.xyz"), 3);
}

static void a_tolerance_out_of_reach_is_4(void **state)
{
    (void)state;
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 2 --normal-tol 1e-15 --dry-run"), 4);
}

static void a_folder_that_refuses_is_1(void **state)
{
    (void)state;
    assert_int_equal(run("apply data/teapot.bpt --tile bump --count 1 --normal-tol 1e-2 -o /nonexistent/x.stl"), 1);
    assert_non_null(strstr(complained, "/nonexistent/x.stl"));
}

static void full_standard_output_is_1(void **state)
{
    (void)state;
    if (!exists("/dev/full")) skip();
    char line[1024];
    snprintf(line, sizeof line, "'%s' tiles >/dev/full 2>/dev/null", getenv("KNURL"));
    assert_int_equal(WEXITSTATUS(system(line)), 1);
}

static void recipes(void **state)
{
    (void)state;
    char path[PATH_BYTES], out[PATH_BYTES], text[4096], root[PATH_BYTES];
    test_tmp_path(path, "recipe.json");
    test_tmp_path(out, "recipe.stl");
    const char *name = strrchr(out, '/') + 1;
    assert_non_null(getcwd(root, sizeof root));
    snprintf(text, sizeof text,
             "{\"format\":1,\"base\":\"%.400s/data/teapot.bpt\",\"layers\":[{\"tile\":\"bump\",\"count\":[2,1]}],"
             "\"normal_tol\":1e-3,\"outputs\":[\"%.100s\"]}",
             root, name);
    write_text(path, text);
    assert_int_equal(run("apply '%s' -q", path), 0);
    assert_true(exists(out)); // beside the recipe
    static const char *const wrong[] = {
        "{\"format\":2,\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\"}]}",
        "{\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\"}]}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\",\"heigth\":1}]}",
        "{\"format\":1,\"base\":\"x.bpt\",\"colour\":1,\"layers\":[{\"tile\":\"bump\"}]}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\",\"count\":1e9}]}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[]}",
        "{\"format\":1,\"base\":\"x.bpt\"}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[{\"count\":1}]}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\",\"count\":2,\"size\":1}]}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\",\"rotate\":\"left\"}]}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\"}],\"max_degree\":\"vsa\"}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\"}],\"unit\":\"ft\"}",
        "{\"format\":1,\"base\":\"x.bpt\",\"layers\":[{\"tile\":\"bump\"}],\"outputs\":[\"x.dwg\"]}",
        "{\"format\":1,",
        "",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        write_text(path, wrong[i]);
        assert_int_equal(run("apply '%s' --dry-run", path), 3);
        assert_non_null(strstr(complained, "recipe.json"));
        assert_int_equal(strchr(complained, '\n') - complained, strlen(complained) - 1); // one line
    }
}

// Options behind a recipe override it, count and size each other too.
static void options_override_a_recipe(void **state)
{
    (void)state;
    char path[PATH_BYTES], text[1024], root[PATH_BYTES];
    test_tmp_path(path, "override.json");
    assert_non_null(getcwd(root, sizeof root));
    snprintf(text, sizeof text,
             "{\"format\":1,\"base\":\"%.400s/data/teapot.bpt\",\"layers\":[{\"tile\":\"bump\",\"size\":0.3}],"
             "\"normal_tol\":1e-2}",
             root);
    write_text(path, text);
    assert_int_equal(run("apply '%s' --count 1 --dry-run --json", path), 0);
    json_t *r = json_loads(printed, 0, NULL);
    assert_int_equal(json_integer_value(json_object_get(r, "cells")), 32);
    json_decref(r);
    assert_int_equal(run("apply '%s' --count 1 --size 1 --dry-run", path), 2);
}

static const char square[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";

// What lies in a base but is no surface is mentioned; what is wrong with a surface is said with the file's name.
static void bases_are_named(void **state)
{
    (void)state;
    char path[PATH_BYTES], text[1024];
    test_tmp_path(path, "mixed.g2");
    snprintf(text, sizeof text, "100 1 0 0\n3 0\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n%s", square);
    write_text(path, text);
    assert_int_equal(run("apply '%s' --tile bump --count 1 --dry-run", path), 0);
    assert_non_null(strstr(complained, "mixed.g2: 1 of its 2 splines"));
    assert_int_equal(run("apply '%s' --tile bump --count 1 --dry-run -q", path), 0);
    assert_string_equal(complained, "");

    test_tmp_path(path, "cusp.g2"); // turns back on itself: S_u vanishes along a line inside
    write_text(path, "200 1 0 0\n3 0\n4 4\n0 0 0 0 1 1 1 1\n2 2\n0 0 1 1\n"
                     "0 0 0\n20 0 0\n-10 0 0\n10 0 0\n0 9 0\n20 9 0\n-10 9 0\n10 9 0\n");
    assert_int_equal(run("apply '%s' --tile bump --count 1 --dry-run", path), 3);
    assert_non_null(strstr(complained, "cusp.g2: "));

    test_tmp_path(path, "line.g2");                                   // as a tile
    write_text(path, "100 1 0 0\n3 0\n2 2\n0 0 1 1\n1 0 0\n1 0 0\n"); // no length
    assert_int_equal(run("apply data/teapot.bpt --tile '%s' --dry-run", path), 3);
    assert_non_null(strstr(complained, "line.g2: "));
    assert_int_equal(run("apply data/teapot.bpt --tile '%s.x' --dry-run", path), 3);
    assert_null(strstr(strstr(complained, "line.g2.x") + 1, "line.g2.x")); // once
}

// A unit square of cells that CAD systems cannot tell apart in the unit that was said.
static void cells_too_small_for_step(void **state)
{
    (void)state;
    char in[PATH_BYTES];
    test_tmp_path(in, "square.g2");
    write_text(in, square);
    assert_int_equal(run("apply '%s' --tile bump --count 200 --dry-run -o x.step", in), 0);
    assert_non_null(strstr(complained, "is --unit right?"));
    assert_int_equal(run("apply '%s' --tile bump --count 200 --unit m --dry-run -o x.step", in), 0);
    assert_string_equal(complained, "");
    assert_int_equal(run("apply '%s' --tile bump --count 200 --dry-run -o x.stl", in), 0);
    assert_string_equal(complained, "");
}

static void endings_in_capitals(void **state)
{
    (void)state;
    char in[PATH_BYTES], out[PATH_BYTES];
    test_tmp_path(in, "SQUARE.G2");
    test_tmp_path(out, "SQUARE.GLB");
    write_text(in, square);
    assert_int_equal(run("apply '%s' --tile bump --count 1 -q -o '%s'", in, out), 0);
    assert_int_equal(run("info '%s'", out), 0);
}

// A file's name may be any bytes, JSON only UTF-8.
static void json_of_a_name_that_is_no_text(void **state)
{
    (void)state;
    char in[PATH_BYTES], out[PATH_BYTES];
    test_tmp_path(in, "b\xff.g2");
    test_tmp_path(out, "b\xff.stl");
    write_text(in, square);
    assert_int_equal(run("info '%s' --json", in), 0);
    json_t *info = json_loads(printed, 0, NULL);
    assert_non_null(strstr(json_string_value(json_object_get(info, "file")), "b?.g2"));
    json_decref(info);
    assert_int_equal(run("apply '%s' --tile bump --count 1 --json -o '%s'", in, out), 0);
    json_t *r = json_loads(printed, 0, NULL);
    assert_non_null(json_object_get(r, "base"));
    assert_int_equal(json_object_size(json_object_get(r, "bytes")), 1);
    json_decref(r);
}

// The reader of a pipe goes away while the job runs: a failure that cleans up, not a death that leaves pieces.
static void a_pipe_without_a_reader_leaves_nothing(void **state)
{
    (void)state;
    char folder[PATH_BYTES], line[4 * PATH_BYTES];
    test_tmp_path(folder, "pipe");
    assert_int_equal(mkdir(folder, 0777), 0);
    snprintf(line, sizeof line,
             "cd '%s' && mkfifo p.stl && { head -c 10 p.stl >/dev/null & } && "
             "'%s' apply \"$OLDPWD\"/data/teapot.bpt --tile bump --count 2 --normal-tol 1e-2 -q -o x.step -o p.stl "
             "2>/dev/null; code=$?; rm p.stl; cd .. && rmdir '%s' && exit $code",
             folder, getenv("KNURL"), folder);
    assert_int_equal(WEXITSTATUS(system(line)), 1);
    assert_false(exists(folder));
}

// Messages must not end up in a file that has taken the number of a closed standard error.
static void closed_standard_streams(void **state)
{
    (void)state;
    char in[PATH_BYTES], one[PATH_BYTES], two[PATH_BYTES], line[8 * PATH_BYTES];
    test_tmp_path(in, "streams.g2");
    test_tmp_path(one, "streams1.step");
    test_tmp_path(two, "streams2.step");
    snprintf(line, sizeof line, "100 1 0 0\n3 0\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n%s", square); // makes a warning
    write_text(in, line);
    snprintf(line, sizeof line,
             "'%s' apply '%s' --tile bump --count 1 -q -o '%s' && "
             "'%s' apply '%s' --tile bump --count 1 -o '%s' <&- 2>&- >/dev/null && cmp '%s' '%s'",
             getenv("KNURL"), in, one, getenv("KNURL"), in, two, one, two);
    assert_int_equal(system(line), 0);
    snprintf(line, sizeof line, "'%s' tiles >&- 2>/dev/null", getenv("KNURL"));
    assert_int_equal(WEXITSTATUS(system(line)), 1);
}

// nohup: a hangup is ignored because the caller said so. Terminates all the same.
static void nohup_is_respected(void **state)
{
    (void)state;
    char out[PATH_BYTES];
    test_tmp_path(out, "nohup.step");
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        signal(SIGHUP, SIG_IGN);
        execl(getenv("KNURL"), "knurl", "apply", "data/teapot.bpt", "--tile", "chain", "--count", "24", "-q",
              "--normal-tol", "1e-2", "-o", out, (char *)NULL);
        _exit(127);
    }
    nanosleep(&(struct timespec){.tv_nsec = 500000000}, NULL);
    kill(child, SIGHUP);
    int status;
    nanosleep(&(struct timespec){.tv_nsec = 500000000}, NULL);
    assert_int_equal(waitpid(child, &status, WNOHANG), 0); // still at work
    kill(child, SIGTERM);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 5);
    assert_false(exists(out));
}

// A big job, interrupted while it runs: exit code 5 and no file of any name.
static void interrupted_is_5(void **state)
{
    (void)state;
    char folder[PATH_BYTES], out[PATH_BYTES + 16], line[2 * PATH_BYTES];
    test_tmp_path(folder, "interrupted");
    assert_int_equal(mkdir(folder, 0777), 0);
    snprintf(out, sizeof out, "%s/big.step", folder);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        execl(getenv("KNURL"), "knurl", "apply", "data/teapot.bpt", "--tile", "chain", "--count", "24", "-q",
              "--normal-tol", "1e-2", "-o", out, (char *)NULL);
        _exit(127);
    }
    nanosleep(&(struct timespec){.tv_sec = 1, .tv_nsec = 500000000}, NULL);
    kill(child, SIGINT);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 5);
    snprintf(line, sizeof line, "rmdir '%s'", folder); // fails when anything is left in it
    assert_int_equal(system(line), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(usage_errors),
        cmocka_unit_test(help_starts_with_examples),
        cmocka_unit_test(tiles_as_json),
        cmocka_unit_test(tiles_checked),
        cmocka_unit_test(eval_values),
        cmocka_unit_test(info_of_teapot),
        cmocka_unit_test(dry_run_reports_and_writes_nothing),
        cmocka_unit_test(apply_writes_what_it_reports),
        cmocka_unit_test(same_bytes_for_any_threads),
        cmocka_unit_test(bad_input_is_3_and_keeps_the_old_file),
        cmocka_unit_test(a_tolerance_out_of_reach_is_4),
        cmocka_unit_test(a_folder_that_refuses_is_1),
        cmocka_unit_test(full_standard_output_is_1),
        cmocka_unit_test(recipes),
        cmocka_unit_test(interrupted_is_5),
        cmocka_unit_test(options_override_a_recipe),
        cmocka_unit_test(bases_are_named),
        cmocka_unit_test(cells_too_small_for_step),
        cmocka_unit_test(endings_in_capitals),
        cmocka_unit_test(json_of_a_name_that_is_no_text),
        cmocka_unit_test(a_pipe_without_a_reader_leaves_nothing),
        cmocka_unit_test(closed_standard_streams),
        cmocka_unit_test(nohup_is_respected),
    };
    return cmocka_run_group_tests_name("cli/cli", tests, NULL, NULL);
}
