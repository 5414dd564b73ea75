// SPDX-License-Identifier: Apache-2.0
// A texture on a base as options describe it: apply composes it, check looks where it folds.
#include "cli/cli.h"

#include <math.h>
#include <string.h>

const cli_option cli_job_options[CLI_JOB_OPTIONS] = {
    [CLI_TILE] = {"tile", 't', true},
    [CLI_TILE_CELL] = {"tile-cell", 0, true},
    [CLI_COUNT] = {"count", 'c', true},
    [CLI_SIZE] = {"size", 's', true},
    [CLI_SPACING] = {"spacing", 0, true},
    [CLI_ROWS] = {"rows", 0, false},
    [CLI_STRETCH] = {"stretch", 0, false},
    [CLI_HEIGHT] = {"height", 0, true},
    [CLI_OFFSET] = {"offset", 0, true},
    [CLI_SIDE] = {"side", 0, true},
    [CLI_ROTATE] = {"rotate", 0, true},
    [CLI_NORMAL] = {"normal", 0, true},
    [CLI_NORMAL_TOL] = {"normal-tol", 0, true},
    [CLI_DIRECTION] = {"direction", 0, true},
    [CLI_THICKNESS] = {"thickness", 0, true},
    [CLI_ATTRACTION] = {"attraction", 0, true},
    [CLI_ATTRACTION_POWER] = {"attraction-power", 0, true},
    [CLI_UNIT] = {"unit", 0, true},
    [CLI_THREADS] = {"threads", 'j', true},
    [CLI_JSON] = {"json", 0, false},
    [CLI_QUIET] = {"quiet", 'q', false},
};

cli_job cli_job_defaults(void)
{
    return (cli_job){.options = kn_job_defaults(), .unit_mm = 1};
}

// "L" for both directions, or "L,L".
static bool set_size(cli_job *job, const char *text)
{
    char first[64];
    const char *comma = strchr(text, ',');
    size_t length = comma ? (size_t)(comma - text) : strlen(text);
    snprintf(first, sizeof first, "%.*s", (int)(length < sizeof first ? length : sizeof first - 1), text);
    job->has_size = cli_length_of("--size", first, &job->size[0]) &&
                    cli_length_of("--size", comma ? comma + 1 : first, &job->size[1]) &&
                    cli_above_zero("--size", job->size[0].value) && cli_above_zero("--size", job->size[1].value);
    return job->has_size;
}

static bool set_height(cli_job *job, const char *text)
{
    if (!cli_length_of("--height", text, &job->height)) return false;
    if (job->height.value != 0) return true;
    cli_error("--height: a texture of height 0 is flat; with a tile leave it out for the tile's own proportions");
    return false;
}

bool cli_job_set(cli_job *job, int option, const char *value)
{
    kn_job_options *o = &job->options;
    double number;
    if ((option == CLI_COUNT || option == CLI_SIZE) && job->recipe_cells) {
        o->count[0] = o->count[1] = 0;
        job->has_size = job->recipe_cells = false;
    }
    switch (option) {
    case CLI_TILE: job->tile = value; return true;
    case CLI_TILE_CELL: return job->has_cell = cli_set_cell("--tile-cell", value, job->cell);
    case CLI_COUNT: return cli_int_pair("--count", value, 1, CLI_MAX_COUNT, o->count);
    case CLI_SIZE: return set_size(job, value);
    case CLI_SPACING: return cli_set_spacing("--spacing", value, o);
    case CLI_ROWS: return o->rows = true;
    case CLI_STRETCH: return o->stretch = true;
    case CLI_HEIGHT: return set_height(job, value);
    case CLI_OFFSET: return cli_length_of("--offset", value, &job->offset);
    case CLI_SIDE: return cli_set_side("--side", value, o);
    case CLI_ROTATE: return cli_double("--rotate", value, &number) && cli_set_rotation("--rotate", number, o);
    case CLI_NORMAL: return job->has_normal = cli_set_normal("--normal", value, o);
    case CLI_NORMAL_TOL:
        return cli_double("--normal-tol", value, &o->normal_tol) && cli_above_zero("--normal-tol", o->normal_tol);
    case CLI_DIRECTION:
        return cli_set_field("--direction", value, CLI_FIELD_DIRECTION, &job->field[CLI_FIELD_DIRECTION]);
    case CLI_THICKNESS:
        return cli_set_field("--thickness", value, CLI_FIELD_THICKNESS, &job->field[CLI_FIELD_THICKNESS]);
    case CLI_ATTRACTION:
        return cli_set_field("--attraction", value, CLI_FIELD_ATTRACTION, &job->field[CLI_FIELD_ATTRACTION]);
    case CLI_ATTRACTION_POWER:
        return job->has_power = cli_int("--attraction-power", value, 1, KN_MAX_DEGREE, &o->attraction_power);
    case CLI_UNIT: return cli_set_unit("--unit", value, &job->unit_mm);
    case CLI_THREADS: return cli_int("--threads", value, 1, 1024, &job->threads);
    case CLI_JSON: return job->json = true;
    case CLI_QUIET: return job->quiet = true;
    default: return false;
    }
}

const char *cli_job_conflict(const cli_job *job)
{
    bool direction = job->field[CLI_FIELD_DIRECTION].given, attraction = job->field[CLI_FIELD_ATTRACTION].given;
    return job->options.count[0] && job->has_size ? "--count and --size exclude each other"
           : direction && job->has_normal         ? "--normal and --direction exclude each other"
           : job->has_power && !attraction        ? "--attraction-power needs --attraction"
                                                  : NULL;
}

double cli_crease_angle(double normal_tol)
{
    if (normal_tol == 0) normal_tol = kn_shell_defaults().normal_tol;
    return fmax(0.1 * normal_tol, 1e-11);
}

static double in_base_units(const cli_job *job, cli_length length)
{
    return length.unit_mm > 0 ? length.value * (length.unit_mm / job->unit_mm) : length.value;
}

void cli_job_range(const cli_job *job, double range[2])
{
    const kn_job_options *o = &job->options;
    double h = fabs(o->height);
    range[0] = o->side == KN_JOB_ABOVE ? fmin(0.0, o->height) : -h;
    range[1] = o->side == KN_JOB_ABOVE ? fmax(0.0, o->height) : o->side == KN_JOB_BOTH ? h : 0.0;
    for (int end = 0; end < 2; end++) range[end] += o->offset;
}

int cli_job_begin(cli_session *session, cli_job *job)
{
    kn_job_options *o = &job->options;
    int code = EXIT_OK;
    o->height = in_base_units(job, job->height);
    o->offset = in_base_units(job, job->offset);
    o->cells_tol = in_base_units(job, job->cells_tol);
    o->mesh_tol = in_base_units(job, job->mesh_tol);
    for (int d = 0; d < 2 && job->has_size; d++) o->size[d] = in_base_units(job, job->size[d]);
    for (int f = 0; f < CLI_FIELDS && code == EXIT_OK; f++)
        code = cli_read_field(session, &job->field[f], (cli_field_kind)f);
    const kn_spline *fields[CLI_FIELDS];
    for (int f = 0; f < CLI_FIELDS; f++) fields[f] = job->field[f].given ? &job->field[f].spline : NULL;
    o->direction = fields[CLI_FIELD_DIRECTION];
    o->thickness = fields[CLI_FIELD_THICKNESS];
    o->attraction = fields[CLI_FIELD_ATTRACTION];
    return code;
}

void cli_job_end(cli_session *session, cli_job *job)
{
    for (int f = 0; f < CLI_FIELDS; f++) kn_spline_clear(cli_ctx(session), &job->field[f].spline);
}
