// SPDX-License-Identifier: Apache-2.0
// Options of a texture: which tile, in which cells, how high, over which shell.
#include "cli/cli.h"

#include <math.h>

enum {
    TILE,
    TILE_CELL,
    MORPH,
    COUNT,
    SIZE,
    SPACING,
    ROWS,
    STRETCH,
    HEIGHT,
    OFFSET,
    SIDE,
    ROTATE,
    DIRECTION,
    THICKNESS,
    ATTRACTION,
    ATTRACTION_POWER,
    OPTIONS
};
static const cli_option options[OPTIONS] = {
    [TILE] = {"tile", 't', CLI_FILE},
    [TILE_CELL] = {"tile-cell", 0, CLI_TEXT},
    [MORPH] = {"morph", 0, CLI_FILE},
    [COUNT] = {"count", 'c', CLI_TEXT},
    [SIZE] = {"size", 's', CLI_TEXT},
    [SPACING] = {"spacing", 0, CLI_TEXT},
    [ROWS] = {"rows", 0, CLI_NOTHING},
    [STRETCH] = {"stretch", 0, CLI_NOTHING},
    [HEIGHT] = {"height", 0, CLI_TEXT},
    [OFFSET] = {"offset", 0, CLI_TEXT},
    [SIDE] = {"side", 0, CLI_TEXT},
    [ROTATE] = {"rotate", 0, CLI_TEXT},
    [DIRECTION] = {"direction", 0, CLI_FILE},
    [THICKNESS] = {"thickness", 0, CLI_FILE},
    [ATTRACTION] = {"attraction", 0, CLI_FILE},
    [ATTRACTION_POWER] = {"attraction-power", 0, CLI_TEXT},
};

static bool set_size(cli_job *job, const char *name, const char *text)
{
    return job->has_size = cli_length_pair(name, text, job->size) && cli_above_zero(name, job->size[0].value) &&
                           cli_above_zero(name, job->size[1].value);
}

static bool set_height(cli_job *job, const char *name, const char *text)
{
    if (!cli_length_of(name, text, &job->height)) return false;
    if (job->height.value != 0) return true;
    cli_error("%s: a texture of height 0 is flat; with a tile leave it out for the tile's own proportions", name);
    return false;
}

static bool set_side(const char *name, const char *text, kn_job_options *job)
{
    static const char *const names[] = {[KN_JOB_ABOVE] = "above", [KN_JOB_BELOW] = "below", [KN_JOB_BOTH] = "both"};
    int i = cli_choice(name, text, names, 3, "above, below or both");
    if (i >= 0) job->side = (kn_job_side)i;
    return i >= 0;
}

static bool set_spacing(const char *name, const char *text, kn_job_options *job)
{
    static const char *const names[] = {[KN_CELLS_DEFAULT] = "default",
                                        [KN_CELLS_UNIFORM] = "uniform",
                                        [KN_CELLS_EVEN] = "even",
                                        [KN_CELLS_FREE] = "free"};
    int i = cli_choice(name, text, names, 4, "default, uniform, even or free");
    if (i >= 0) job->spacing = (kn_cells_spacing)i;
    return i >= 0;
}

// Quarter turns stay what they are: exact, and possible for tiles that cover. The rest is an angle.
static bool set_rotation(const char *name, const char *text, kn_job_options *job)
{
    double degrees, turns;
    if (!cli_double(name, text, &degrees)) return false;
    if (!(fabs(degrees) <= 36000)) {
        cli_error("%s: expected degrees from -36000 to 36000, got '%s'", name, text);
        return false;
    }
    turns = floor(degrees / 90.0);
    double rest = degrees - 90.0 * turns;
    job->quarter_turns = (((int)turns % 4) + 4) % 4;
    job->placement.angle = rest * (acos(-1.0) / 180.0);
    return true;
}

// "X,Y,Z" (thickness: one number) or the name of a spline file.
static bool set_field(cli_job *job, const char *name, const char *text, cli_field_kind kind)
{
    cli_field *field = &job->field[kind];
    field->given = true;
    field->path = cli_has_ending(text, "g2") || cli_has_ending(text, "bpt") ? text : NULL;
    if (field->path) return true;
    int n = kind == CLI_FIELD_THICKNESS ? 1 : 3;
    int got = cli_list(name, text, field->value, n);
    if (got == n) return cli_field_makes_sense(name, kind, field);
    if (got > 0) cli_error("%s: expected X,Y,Z or a .g2 file, got '%s'", name, text);
    return false;
}

// An option behind a recipe replaces the cells that the recipe asks for.
static void forget_cells(cli_job *job)
{
    if (!job->recipe_cells) return;
    job->options.count[0] = job->options.count[1] = 0;
    job->has_size = job->recipe_cells = false;
}

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    kn_job_options *o = &job->options;
    switch (option) {
    case TILE: return (job->tile = text) != NULL;
    case TILE_CELL: return job->has_cell = cli_set_cell(name, text, job->cell);
    case MORPH: return (job->morph = text) != NULL;
    case COUNT: forget_cells(job); return cli_int_pair(name, text, 1, CLI_MAX_COUNT, o->count);
    case SIZE: forget_cells(job); return set_size(job, name, text);
    case SPACING: return set_spacing(name, text, o);
    case ROWS: return o->rows = true;
    case STRETCH: return o->stretch = true;
    case HEIGHT: return set_height(job, name, text);
    case OFFSET: return cli_length_of(name, text, &job->offset);
    case SIDE: return set_side(name, text, o);
    case ROTATE: return set_rotation(name, text, o);
    case DIRECTION: return set_field(job, name, text, CLI_FIELD_DIRECTION);
    case THICKNESS: return set_field(job, name, text, CLI_FIELD_THICKNESS);
    case ATTRACTION: return set_field(job, name, text, CLI_FIELD_ATTRACTION);
    case ATTRACTION_POWER: return cli_int(name, text, 1, KN_MAX_DEGREE, &o->attraction_power);
    default: return false;
    }
}

const cli_theme cli_texture_options = {options, OPTIONS, CLI_OF_LAYER, set};
