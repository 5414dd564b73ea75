// SPDX-License-Identifier: Apache-2.0
// Options of variation: what changes from tile to tile and along each.
#include "cli/cli.h"

#include <math.h>
#include <string.h>

enum { VARY, SET, TAPER, JITTER, OPTIONS };
static const cli_option options[OPTIONS] = {
    [VARY] = {"vary", 0, CLI_FILES},
    [SET] = {"set", 0, CLI_PAIRS},
    [TAPER] = {"taper", 0, CLI_TEXT},
    [JITTER] = {"jitter", 0, CLI_PAIRS},
};

// "NAME=VALUE": the value, and the name in out; NULL after a message.
static const char *split(const char *name, const char *text, char out[KN_NAME_BYTES], const char *what)
{
    const char *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) : 0;
    if (length == 0 || length >= KN_NAME_BYTES || !equals[1]) {
        cli_error("%s: expected NAME=%s, got '%s'", name, what, text);
        return NULL;
    }
    memcpy(out, text, length);
    out[length] = '\0';
    return equals + 1;
}

// A parameter that is given again is replaced.
static bool add(cli_job *job, const char *name, const char *parameter, const char *value)
{
    int i = 0;
    while (i < job->nvary && strcmp(job->vary[i].parameter, parameter) != 0) i++;
    if (i == CLI_MAX_VARY) {
        cli_error("%s: more than %d parameters", name, CLI_MAX_VARY);
        return false;
    }
    if (i == job->nvary) job->nvary++;
    snprintf(job->vary[i].parameter, sizeof job->vary[i].parameter, "%s", parameter);
    job->vary[i].value = (cli_scalar){.text = value};
    return true;
}

static bool set_vary(cli_job *job, const char *name, const char *text)
{
    char parameter[KN_NAME_BYTES];
    const char *value = split(name, text, parameter, "EXPRESSION or NAME=FILE");
    return value && add(job, name, parameter, value);
}

static bool set_constant(cli_job *job, const char *name, const char *text)
{
    char parameter[KN_NAME_BYTES];
    double number;
    const char *value = split(name, text, parameter, "NUMBER");
    return value && cli_double(name, value, &number) && add(job, name, parameter, value);
}

// "angle=10,shift=0.1,scale=0.2,height=0.3", any of them; degrees, cells, and relative.
static bool set_jitter(kn_job_random *random, const char *name, const char *text)
{
    static const char *const names[] = {"angle", "shift", "scale", "height"};
    double *const to[] = {&random->angle, &random->shift, &random->scale, &random->height};
    for (const char *at = text; at;) {
        char item[128], which[KN_NAME_BYTES];
        const char *comma = strchr(at, ',');
        size_t length = comma ? (size_t)(comma - at) : strlen(at);
        snprintf(item, sizeof item, "%.*s", (int)(length < sizeof item ? length : sizeof item - 1), at);
        const char *value = split(name, item, which, "NUMBER (angle, shift, scale or height)");
        int i = value ? cli_choice(name, which, names, 4, "angle, shift, scale or height") : -1;
        double most = i == 0 ? 360 : 1, number;
        if (i < 0 || !cli_double(name, value, &number)) return false;
        bool scale = i == 2; // of nothing there would be nothing
        if (!(number >= 0 && number <= most) || (scale && number == most)) {
            cli_error("%s: expected %s from 0 %s %g, got '%s'", name, which, scale ? "to below" : "to", most, value);
            return false;
        }
        *to[i] = i == 0 ? number * (acos(-1.0) / 180.0) : number;
        at = comma ? comma + 1 : NULL;
    }
    return true;
}

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    switch (option) {
    case VARY: return set_vary(job, name, text);
    case SET: return set_constant(job, name, text);
    case TAPER: return cli_positive_length(name, text, &job->taper);
    case JITTER: return set_jitter(&job->options.random, name, text);
    default: return false;
    }
}

const cli_theme cli_variation_options = {options, OPTIONS, CLI_OF_LAYER, set};
