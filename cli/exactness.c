// SPDX-License-Identifier: Apache-2.0
// Options of exactness, for all layers: normals, degrees, tolerances, the unit, and tiles that cross knot lines.
#include "cli/cli.h"

enum {
    NORMAL,
    NORMAL_TOL,
    MAX_DEGREE,
    TOL,
    SEAM_ANGLE,
    CELLS_TOL,
    CROSSING,
    CROSSING_TOL,
    MERGE,
    STEP,
    INSTANCES,
    UNIT,
    OPTIONS
};
static const cli_option options[OPTIONS] = {
    [NORMAL] = {"normal", 0, CLI_TEXT},          [NORMAL_TOL] = {"normal-tol", 0, CLI_TEXT},
    [MAX_DEGREE] = {"max-degree", 0, CLI_TEXT},  [TOL] = {"tol", 0, CLI_TEXT},
    [SEAM_ANGLE] = {"seam-angle", 0, CLI_TEXT},  [CELLS_TOL] = {"cells-tol", 0, CLI_TEXT},
    [CROSSING] = {"crossing", 0, CLI_TEXT},      [CROSSING_TOL] = {"crossing-tol", 0, CLI_TEXT},
    [MERGE] = {"merge", 0, CLI_NOTHING},         [STEP] = {"step", 0, CLI_TEXT},
    [INSTANCES] = {"instances", 0, CLI_NOTHING}, [UNIT] = {"unit", 0, CLI_TEXT},
};

static bool set_normal(const char *name, const char *text, kn_job_options *job)
{
    static const char *const names[] = {
        [KN_NORMAL_FITTED] = "fitted", [KN_NORMAL_EXACT_DIRECTION] = "exact-direction"};
    int i = cli_choice(name, text, names, 2, "fitted or exact-direction");
    if (i >= 0) job->normal = (kn_normal_method)i;
    return i >= 0;
}

static bool set_crossing(const char *name, const char *text, kn_job_options *job)
{
    static const char *const names[] = {
        [KN_CROSSING_REFUSE] = "refuse", [KN_CROSSING_TRIM] = "trim", [KN_CROSSING_APPROXIMATE] = "approximate"};
    int i = cli_choice(name, text, names, 3, "refuse, trim or approximate");
    if (i >= 0) job->crossing = (kn_job_crossing)i;
    return i >= 0;
}

static bool set_step(const char *name, const char *text, kn_step_schema *schema)
{
    static const char *const names[] = {
        [KN_STEP_AP214] = "ap214", [KN_STEP_AP242] = "ap242", [KN_STEP_AP203] = "ap203"};
    int i = cli_choice(name, text, names, 3, "ap214, ap242 or ap203");
    if (i >= 0) *schema = (kn_step_schema)i;
    return i >= 0;
}

static bool set_seam_angle(const char *name, const char *text, double *degrees)
{
    if (!cli_double(name, text, degrees)) return false;
    if (*degrees >= 0.01 && *degrees <= 45) return true;
    cli_error("%s: expected degrees from 0.01 to 45, got '%s'", name, text);
    return false;
}

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    kn_job_options *o = &job->options;
    switch (option) {
    case NORMAL: return set_normal(name, text, o);
    case NORMAL_TOL: return cli_double(name, text, &o->normal_tol) && cli_above_zero(name, o->normal_tol);
    case MAX_DEGREE:
        if (!cli_set_max_degree(name, text, &job->max_degree)) return false;
        o->max_degree = job->max_degree > 25 ? job->max_degree : 0; // what is composed may be limited later
        return true;
    case SEAM_ANGLE: return set_seam_angle(name, text, &job->seam_angle);
    case TOL: return cli_positive_length(name, text, &job->mesh_tol);
    case CELLS_TOL: return cli_positive_length(name, text, &job->cells_tol);
    case CROSSING: return set_crossing(name, text, o);
    case CROSSING_TOL: return cli_positive_length(name, text, &job->crossing_tol);
    case MERGE: return job->merge = true;
    case INSTANCES: return job->instances = true;
    case STEP: return set_step(name, text, &job->step);
    case UNIT: return cli_set_unit(name, text, &job->unit_mm);
    default: return false;
    }
}

const cli_theme cli_exactness_options = {options, OPTIONS, CLI_OF_RECIPE, set};
