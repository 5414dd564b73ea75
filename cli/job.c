// SPDX-License-Identifier: Apache-2.0
// A texture on a base as options describe it: apply composes it, check looks where it folds, slice cuts it.
#include "cli/cli.h"

#include <math.h>
#include <string.h>

const cli_theme *cli_theme_of(int theme)
{
    static const cli_theme *const themes[CLI_THEMES] = {
        &cli_texture_options,   &cli_placement_options, &cli_selection_options,
        &cli_view_options,      &cli_variation_options, &cli_color_options,
        &cli_exactness_options, &cli_body_options,      &cli_running_options};
    return themes[theme];
}

cli_job cli_job_defaults(void)
{
    return (cli_job){.options = kn_job_defaults(), .unit_mm = 1};
}

bool cli_job_set_key(cli_job *job, int option, const char *name, const char *value)
{
    int theme = option / CLI_THEME_OPTIONS, index = option % CLI_THEME_OPTIONS;
    job->given[theme] |= (uint64_t)1 << index;
    return cli_theme_of(theme)->set(job, name, index, value);
}

bool cli_job_set(cli_job *job, int option, const char *value)
{
    char name[64];
    const cli_theme *theme = cli_theme_of(option / CLI_THEME_OPTIONS);
    snprintf(name, sizeof name, "--%s", theme->options[option % CLI_THEME_OPTIONS].name);
    return cli_job_set_key(job, option, name, value);
}

static bool is_key_of(const char *key, const char *option)
{
    for (; *key && (*key == *option || (*key == '_' && *option == '-')); key++) option++;
    return *key == *option;
}

int cli_job_find_key(const char *key, cli_place place, const cli_option **option)
{
    for (int t = 0; t < CLI_THEMES; t++) {
        const cli_theme *theme = cli_theme_of(t);
        for (int i = 0; i < theme->noptions && theme->place == place; i++)
            if (is_key_of(key, theme->options[i].name)) {
                if (option) *option = &theme->options[i];
                return t * CLI_THEME_OPTIONS + i;
            }
    }
    return -1;
}

bool cli_job_was_given(const cli_job *job, int option)
{
    return job->given[option / CLI_THEME_OPTIONS] >> option % CLI_THEME_OPTIONS & 1;
}

const char *cli_job_conflict(const cli_job *job)
{
    const kn_job_options *o = &job->options;
    bool direction = job->field[CLI_FIELD_DIRECTION].given, attraction = job->field[CLI_FIELD_ATTRACTION].given;
    bool normal = cli_job_was_given(job, cli_job_find_key("normal", CLI_OF_RECIPE, NULL));
    bool view = job->view.pixels[0] > 0 || job->view.least_pixels > 0 || job->view.hidden;
    bool clips = o->placement.border[0] == KN_BORDER_CLIP || o->placement.border[1] == KN_BORDER_CLIP ||
                 o->trimmed != KN_TRIMMED_KEEP;
    bool power = cli_job_was_given(job, cli_job_find_key("attraction_power", CLI_OF_LAYER, NULL));
    return o->count[0] && job->has_size ? "--count and --size exclude each other"
           : direction && normal        ? "--normal and --direction exclude each other"
           : power && !attraction       ? "--attraction-power needs --attraction"
           : job->crossing_tol.value > 0 && o->crossing == KN_CROSSING_REFUSE && !clips
               ? "--crossing-tol needs --crossing trim or approximate, --border clip or --trimmed clip"
           : cli_color_lacks_field(&job->color) ? "--palette, --color-steps and --color-part need --color"
           : view && !job->has_camera           ? "--picture, --least-pixels and --hidden need --camera"
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

static void set_lengths(cli_job *job)
{
    kn_job_options *o = &job->options;
    o->height = in_base_units(job, job->height);
    o->offset = in_base_units(job, job->offset);
    o->cells_tol = in_base_units(job, job->cells_tol);
    o->mesh_tol = in_base_units(job, job->mesh_tol);
    o->crossing_tol = in_base_units(job, job->crossing_tol);
    o->taper = in_base_units(job, job->taper);
    o->placement.scatter.distance = in_base_units(job, job->scatter);
    for (int d = 0; d < 2 && job->has_size; d++) o->size[d] = in_base_units(job, job->size[d]);
    for (int d = 0; d < 2; d++) o->select.slab_z[d] = in_base_units(job, job->slab[d]);
}

static int set_shell_fields(cli_session *session, cli_job *job)
{
    kn_job_options *o = &job->options;
    int code = EXIT_OK;
    for (int f = 0; f < CLI_FIELDS && code == EXIT_OK; f++)
        code = cli_read_field(session, &job->field[f], (cli_field_kind)f);
    const kn_spline *fields[CLI_FIELDS];
    for (int f = 0; f < CLI_FIELDS; f++) fields[f] = job->field[f].given ? &job->field[f].spline : NULL;
    o->direction = fields[CLI_FIELD_DIRECTION];
    o->thickness = fields[CLI_FIELD_THICKNESS];
    o->attraction = fields[CLI_FIELD_ATTRACTION];
    return code;
}

static int set_scalars(cli_session *session, cli_job *job)
{
    kn_job_options *o = &job->options;
    uint64_t seed = o->select.seed;
    int code = cli_scalar_begin(session, &job->mask, "--mask", seed);
    o->select.mask = job->mask.field;
    for (int i = 0; i < job->nvary && code == EXIT_OK; i++) {
        char name[KN_NAME_BYTES + 16];
        snprintf(name, sizeof name, "--vary %s", job->vary[i].parameter);
        code = cli_scalar_begin(session, &job->vary[i].value, name, seed);
        job->varied[i] = (kn_job_vary){job->vary[i].parameter, job->vary[i].value.field};
    }
    o->vary = job->nvary > 0 ? job->varied : NULL;
    o->nvary = job->nvary;
    if (code == EXIT_OK) code = cli_color_begin(session, &job->color, seed);
    o->color = job->color.nrules > 0 ? job->color.rule : NULL;
    o->ncolor = job->color.nrules;
    return code;
}

int cli_job_begin(cli_session *session, cli_job *job)
{
    if (job->base && cli_is_cad(job->base) && job->unit_mm != 1) {
        cli_warn(session, "%s: CAD files are read in millimetres, whatever --unit says", job->base);
        job->unit_mm = 1;
    }
    set_lengths(job);
    job->options.select.surfaces = job->nfaces > 0 ? job->faces : NULL;
    job->options.select.nsurfaces = job->nfaces;
    if (job->has_camera) cli_make_view(job);
    job->options.select.view = job->has_camera ? &job->view : NULL;
    int code = set_shell_fields(session, job);
    return code == EXIT_OK ? set_scalars(session, job) : code;
}

void cli_job_end(cli_session *session, cli_job *job)
{
    for (int f = 0; f < CLI_FIELDS; f++) kn_spline_clear(cli_ctx(session), &job->field[f].spline);
    kn_free(cli_ctx(session), job->chosen);
    cli_face_colors_free(cli_ctx(session), job->face_colors);
    job->chosen = NULL, job->face_colors = NULL;
    cli_scalar_end(session, &job->mask);
    cli_scalar_end(session, &job->color.field);
    for (int i = 0; i < job->nvary; i++) cli_scalar_end(session, &job->vary[i].value);
}
