// SPDX-License-Identifier: Apache-2.0
// Options of selection: which cells there are.
#include "cli/cli.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MASK, FACES, WITHIN_ANGLE, SKIP, DENSITY, SEED, SLAB, RANGE, JOIN_ANGLE, NO_JOIN, OPTIONS };
static const cli_option options[OPTIONS] = {
    [MASK] = {"mask", 0, CLI_FILE},
    [FACES] = {"faces", 0, CLI_TEXT},
    [WITHIN_ANGLE] = {"within-angle", 0, CLI_TEXT},
    [SKIP] = {"skip", 0, CLI_TEXT},
    [DENSITY] = {"density", 0, CLI_TEXT},
    [SEED] = {"seed", 0, CLI_TEXT},
    [SLAB] = {"slab", 0, CLI_TEXT},
    [RANGE] = {"range", 0, CLI_TEXT},
    [JOIN_ANGLE] = {"join-angle", 0, CLI_TEXT},
    [NO_JOIN] = {"no-join", 0, CLI_NOTHING},
};

// A whole number at *at, which moves behind it.
static bool take_whole(const char **at, unsigned long long most, unsigned long long *out)
{
    char *end;
    if (**at < '0' || **at > '9') return false;
    errno = 0;
    *out = strtoull(*at, &end, 10);
    *at = end;
    return errno == 0 && *out <= most;
}

// "0,3,5-9": numbers and ranges of the base's surfaces.
static bool add_numbers(cli_job *job, const char *name, const char *text)
{
    const char *at = text;
    unsigned long long lo, hi;
    for (bool more = true; more; more = *at == ',', at += more) {
        if (!take_whole(&at, 1 << 30, &lo)) break;
        hi = lo;
        if (*at == '-' && (at++, !take_whole(&at, 1 << 30, &hi))) break;
        if (hi < lo) break;
        if (hi - lo >= (unsigned)(CLI_MAX_FACES - job->nfaces)) {
            cli_error("%s: more than %d surfaces", name, CLI_MAX_FACES);
            return false;
        }
        for (; lo <= hi; lo++) job->faces[job->nfaces++] = (int)lo;
        if (*at == '\0') return true;
    }
    cli_error("%s: expected numbers of surfaces, from 0, such as 0,3,5-9; or of faces of a CAD file also name:TEXT, "
              "body:TEXT, type:TYPE, color:#rrggbb or near:X,Y,Z; got '%s'",
              name, text);
    return false;
}

// Several of them add up; an option replaces what a recipe says.
static bool set_faces(cli_job *job, const char *name, const char *text)
{
    bool recipe = strncmp(name, "--", 2) != 0;
    if (recipe || job->recipe_faces) job->nfaces = job->nface_texts = 0;
    job->recipe_faces = recipe;
    if (!strchr(text, ':')) return add_numbers(job, name, text);
    if (job->nface_texts == CLI_MAX_FACE_TEXTS) {
        cli_error("%s: more than %d of them; '+' joins several", name, CLI_MAX_FACE_TEXTS);
        return false;
    }
    job->face_text[job->nface_texts++] = text;
    return true;
}

// The axis: x, y, z, -x, -y, -z, or three numbers.
static int read_axis(const char *text, double out[4], const char **rest)
{
    const char *p = text + (*text == '-');
    *rest = text;
    if (*p < 'x' || *p > 'z' || p[1] != ',') return 0;
    for (int c = 0; c < 3; c++) out[c] = c == *p - 'x' ? (p > text ? -1.0 : 1.0) : 0.0;
    *rest = p + 2;
    return 3;
}

// "AXIS,DEG".
static bool set_cone(kn_job_selection *s, const char *name, const char *text)
{
    double x[4];
    const char *rest;
    int n = read_axis(text, x, &rest), got = cli_list(name, rest, x + n, 4 - n);
    if (got == 0) return false;
    if (got != 4 - n || !(x[3] > 0) || x[3] > 180 || (x[0] == 0 && x[1] == 0 && x[2] == 0)) {
        cli_error("%s: expected an axis (x, -z, or X,Y,Z) and degrees up to 180, such as z,30; got '%s'", name, text);
        return false;
    }
    s->cone = true;
    s->cone_angle = x[3] * (acos(-1.0) / 180.0);
    for (int c = 0; c < 3; c++) s->cone_axis[c] = x[c];
    return true;
}

static bool set_density(kn_job_selection *s, const char *name, const char *text)
{
    if (!cli_double(name, text, &s->density)) return false;
    if (s->density > 0 && s->density <= 1) return true;
    cli_error("%s: expected a share above 0 and up to 1, got '%s'", name, text);
    return false;
}

// One seed for all that is left to chance.
static bool set_seed(cli_job *job, const char *name, const char *text)
{
    unsigned long long seed;
    const char *at = text;
    if (!take_whole(&at, UINT64_MAX, &seed) || *at) {
        cli_error("%s: expected a whole number from 0 to 18446744073709551615, got '%s'", name, text);
        return false;
    }
    job->options.select.seed = job->options.random.seed = job->options.placement.scatter.seed = seed;
    return true;
}

static bool set_range(kn_job_selection *s, const char *name, const char *text)
{
    unsigned long long first, count = 0;
    const char *at = text;
    if (!take_whole(&at, SIZE_MAX, &first) || (*at && (*at++ != ',' || !take_whole(&at, SIZE_MAX, &count) || *at)) ||
        (strchr(text, ',') && count == 0)) {
        cli_error("%s: expected FIRST or FIRST,COUNT (cells, from 0), got '%s'", name, text);
        return false;
    }
    s->first = (size_t)first, s->count = (size_t)count;
    return true;
}

static bool set_slab(cli_job *job, const char *name, const char *text)
{
    if (!strchr(text, ',')) {
        cli_error("%s: expected Z0,Z1, got '%s'", name, text);
        return false;
    }
    return job->options.select.slab = cli_length_pair(name, text, job->slab);
}

static bool set_join_angle(cli_job *job, const char *name, const char *text)
{
    if (!cli_double(name, text, &job->join_angle)) return false;
    if (job->join_angle > 0 && job->join_angle <= 180) return true;
    cli_error("%s: expected degrees above 0 and up to 180, got '%s'", name, text);
    return false;
}

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    kn_job_selection *s = &job->options.select;
    switch (option) {
    case MASK: return (job->mask.text = text) != NULL;
    case FACES: return set_faces(job, name, text);
    case WITHIN_ANGLE: return set_cone(s, name, text);
    case SKIP: return cli_int_pair(name, text, 1, CLI_MAX_COUNT, s->skip);
    case DENSITY: return set_density(s, name, text);
    case SEED: return set_seed(job, name, text);
    case SLAB: return set_slab(job, name, text);
    case JOIN_ANGLE: return set_join_angle(job, name, text);
    case NO_JOIN: return job->no_join = true;
    case RANGE: return set_range(s, name, text);
    default: return false;
    }
}

const cli_theme cli_selection_options = {options, OPTIONS, CLI_OF_LAYER, set};
