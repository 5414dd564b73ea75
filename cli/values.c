// SPDX-License-Identifier: Apache-2.0
// Values that options of apply and keys of a recipe share.
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

bool cli_set_unit(const char *name, const char *text, double *unit_mm)
{
    static const struct {
        const char *unit;
        double mm;
    } units[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strcmp(text, units[i].unit) == 0) {
            *unit_mm = units[i].mm;
            return true;
        }
    cli_error("%s: expected mm, cm, m or in, got '%s'", name, text);
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
