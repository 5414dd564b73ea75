// SPDX-License-Identifier: Apache-2.0
// Options of placement: where in their cells, and beyond them, tiles lie.
#include "cli/cli.h"

#include <string.h>

enum { SHIFT, STAGGER, MIRROR, BORDER, SCATTER, TRIMMED, OPTIONS };
static const cli_option options[OPTIONS] = {
    [SHIFT] = {"shift", 0, CLI_TEXT},   [STAGGER] = {"stagger", 0, CLI_TEXT}, [MIRROR] = {"mirror", 0, CLI_TEXT},
    [BORDER] = {"border", 0, CLI_TEXT}, [SCATTER] = {"scatter", 0, CLI_TEXT}, [TRIMMED] = {"trimmed", 0, CLI_TEXT},
};

static bool set_mirror(const char *name, const char *text, kn_job_placement *p)
{
    static const char *const names[] = {"u", "v", "uv"};
    int i = cli_choice(name, text, names, 3, "u, v or uv");
    p->mirror[0] = i == 0 || i == 2;
    p->mirror[1] = i == 1 || i == 2;
    return i >= 0;
}

// "WORD" for both directions, or "WORD,WORD".
static bool set_border(const char *name, const char *text, kn_job_placement *p)
{
    static const char *const names[] = {
        [KN_BORDER_EXTEND] = "extend", [KN_BORDER_CLIP] = "clip", [KN_BORDER_CYCLIC] = "cyclic"};
    const char *comma = strchr(text, ','), *part[2] = {text, comma ? comma + 1 : text};
    for (int d = 0; d < 2; d++) {
        char word[16];
        size_t length = d == 0 && comma ? (size_t)(comma - text) : strlen(part[d]);
        snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), part[d]);
        int i = cli_choice(name, word, names, 3,
                           "extend, clip or cyclic, for both directions or for each (clip,extend)");
        if (i < 0) return false;
        p->border[d] = (kn_job_border)i;
    }
    return true;
}

static bool set_trimmed(const char *name, const char *text, kn_job_options *o)
{
    static const char *const names[] = {
        [KN_TRIMMED_KEEP] = "keep", [KN_TRIMMED_CLIP] = "clip", [KN_TRIMMED_TAPER] = "taper"};
    int i = cli_choice(name, text, names, 3, "keep, clip or taper");
    if (i >= 0) o->trimmed = (kn_job_trimmed)i;
    return i >= 0;
}

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    kn_job_placement *p = &job->options.placement;
    switch (option) {
    case SHIFT: return cli_shift_pair(name, text, p->shift);
    case STAGGER: return cli_shift_pair(name, text, p->stagger);
    case MIRROR: return set_mirror(name, text, p);
    case BORDER: return set_border(name, text, p);
    case TRIMMED: return set_trimmed(name, text, &job->options);
    case SCATTER: return cli_positive_length(name, text, &job->scatter);
    default: return false;
    }
}

const cli_theme cli_placement_options = {options, OPTIONS, CLI_OF_LAYER, set};
