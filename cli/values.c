// SPDX-License-Identifier: Apache-2.0
// Values that options and keys of a recipe share.
#include "cli/cli.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool cli_set_rotation(const char *name, double degrees, kn_job_options *job)
{
    double turns = degrees / 90.0;
    if (turns != floor(turns) || fabs(turns) > 1000) {
        cli_error("%s: tiles turn by multiples of 90 degrees, got %g", name, degrees);
        return false;
    }
    job->quarter_turns = (((int)turns % 4) + 4) % 4;
    return true;
}

bool cli_set_max_degree(const char *name, const char *text, kn_job_options *job)
{
    static const struct {
        const char *profile;
        int degree;
    } profiles[] = {{"occt", 25}, {"catia", 15}, {"vda", 11}, {"cubic", 3}, {"exact", KN_MAX_DEGREE}};
    for (size_t i = 0; i < sizeof profiles / sizeof *profiles; i++)
        if (strcmp(text, profiles[i].profile) == 0) {
            job->max_degree = profiles[i].degree;
            return true;
        }
    char *end;
    double degree = strtod(text, &end);
    if (end != text && *end == '\0' && degree == floor(degree) && degree >= 1 && degree <= KN_MAX_DEGREE) {
        job->max_degree = (int)degree;
        return true;
    }
    cli_error("%s: expected a number from 1 to %d, or occt (25), catia (15), vda (11), cubic (3) or exact, got '%s'",
              name, KN_MAX_DEGREE, text);
    return false;
}

bool cli_set_cell(const char *name, const char *text, double cell[4])
{
    int n = cli_list(name, text, cell, 4);
    if (n == 4 && cell[0] < cell[2] && cell[1] < cell[3]) return true;
    if (n > 0) cli_error("%s: expected U0,V0,U1,V1 with U0 < U1 and V0 < V1, got '%s'", name, text);
    return false;
}

static const struct {
    const char *name;
    double mm;
} units[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}};
enum { UNITS = sizeof units / sizeof *units };

static bool find_unit(const char *text, double *mm)
{
    for (int i = 0; i < UNITS; i++)
        if (strcmp(text, units[i].name) == 0) {
            *mm = units[i].mm;
            return true;
        }
    return false;
}

bool cli_set_unit(const char *name, const char *text, double *unit_mm)
{
    if (find_unit(text, unit_mm)) return true;
    cli_error("%s: expected mm, cm, m or in, got '%s'", name, text);
    return false;
}

const char *cli_unit_name(double unit_mm)
{
    for (int i = 0; i < UNITS; i++)
        if (units[i].mm == unit_mm) return units[i].name;
    return "";
}

bool cli_length_of(const char *name, const char *text, cli_length *out)
{
    char *end;
    cli_length l = {.value = strtod(text, &end)};
    if (end != text && isfinite(l.value) && (*end == '\0' || find_unit(end, &l.unit_mm))) {
        *out = l;
        return true;
    }
    cli_error("%s: expected a length such as 3 or 3mm (mm, cm, m, in), got '%s'", name, text);
    return false;
}

bool cli_above_zero(const char *name, double value)
{
    if (value > 0) return true;
    cli_error("%s: expected a number above 0, got %g", name, value);
    return false;
}

// The place of text among n names, or -1 after a message.
static int choice(const char *name, const char *text, const char *const *names, int n, const char *expected)
{
    for (int i = 0; i < n; i++)
        if (strcmp(text, names[i]) == 0) return i;
    cli_error("%s: expected %s, got '%s'", name, expected, text);
    return -1;
}

bool cli_set_side(const char *name, const char *text, kn_job_options *job)
{
    static const char *const names[] = {[KN_JOB_ABOVE] = "above", [KN_JOB_BELOW] = "below", [KN_JOB_BOTH] = "both"};
    int i = choice(name, text, names, 3, "above, below or both");
    if (i >= 0) job->side = (kn_job_side)i;
    return i >= 0;
}

bool cli_set_normal(const char *name, const char *text, kn_job_options *job)
{
    static const char *const names[] = {
        [KN_NORMAL_FITTED] = "fitted", [KN_NORMAL_EXACT_DIRECTION] = "exact-direction"};
    int i = choice(name, text, names, 2, "fitted or exact-direction");
    if (i >= 0) job->normal = (kn_normal_method)i;
    return i >= 0;
}

bool cli_set_spacing(const char *name, const char *text, kn_job_options *job)
{
    static const char *const names[] = {[KN_CELLS_DEFAULT] = "default",
                                        [KN_CELLS_UNIFORM] = "uniform",
                                        [KN_CELLS_EVEN] = "even",
                                        [KN_CELLS_FREE] = "free"};
    int i = choice(name, text, names, 4, "default, uniform, even or free");
    if (i >= 0) job->spacing = (kn_cells_spacing)i;
    return i >= 0;
}

bool cli_set_field(const char *name, const char *text, cli_field_kind kind, cli_field *field)
{
    field->given = true;
    field->path = cli_has_ending(text, "g2") || cli_has_ending(text, "bpt") ? text : NULL;
    if (field->path) return true;
    int n = kind == CLI_FIELD_THICKNESS ? 1 : 3;
    int got = cli_list(name, text, field->value, n);
    if (got == n) return cli_field_makes_sense(name, kind, field);
    if (got > 0) cli_error("%s: expected X,Y,Z or a .g2 file, got '%s'", name, text);
    return false;
}

bool cli_add_output(cli_apply *apply, const char *name, const char *path)
{
    if (apply->noutputs == CLI_MAX_OUTPUTS) {
        cli_error("%s: more than %d outputs", name, CLI_MAX_OUTPUTS);
        return false;
    }
    if (!cli_can_write(path)) {
        const char *hint = cli_has_ending(path, "png") ? " (write a .glb, then 'knurl render' it)" : "";
        cli_error("%s: no writer for '%s'; endings: %s%s", name, path, cli_writable_endings(), hint);
        return false;
    }
    for (int i = 0; i < apply->noutputs; i++)
        if (strcmp(apply->outputs[i], path) == 0) {
            cli_error("%s: '%s' is given twice", name, path);
            return false;
        }
    apply->outputs[apply->noutputs++] = path;
    return true;
}
