// SPDX-License-Identifier: Apache-2.0
// Reading options, numbers and names from the command line.
#include "cli/cli.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

void cli_error(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    fputs("knurl: ", stderr);
    vfprintf(stderr, format, list);
    fputc('\n', stderr);
    va_end(list);
}

void cli_usage_hint(const char *command)
{
    if (command)
        fprintf(stderr, "Try 'knurl %s --help'.\n", command);
    else
        fputs("Try 'knurl --help'.\n", stderr);
}

bool cli_has_ending(const char *path, const char *ending)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, ending) == 0;
}

// Levenshtein's distance of words of up to 31 letters, one row at a time; 99 for longer ones.
static int edit_distance(const char *a, const char *b)
{
    enum { MOST = 32 };
    int row[MOST];
    int na = (int)strnlen(a, MOST), nb = (int)strnlen(b, MOST);
    if (na == MOST || nb == MOST) return 99;
    for (int j = 0; j <= nb; j++) row[j] = j;
    for (int i = 1; i <= na; i++) {
        int diagonal = row[0];
        row[0] = i;
        for (int j = 1; j <= nb; j++) {
            int change = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            int step = (row[j] < row[j - 1] ? row[j] : row[j - 1]) + 1;
            row[j] = change < step ? change : step;
        }
    }
    return row[nb];
}

const char *cli_nearest(const char *word, const char *const *candidates, int n)
{
    const char *best = NULL;
    int least = (int)strlen(word) / 2 < 3 ? (int)strlen(word) / 2 : 3;
    for (int i = 0; i < n; i++) {
        int d = edit_distance(word, candidates[i]);
        if (d <= least) least = d - 1, best = candidates[i];
    }
    return best;
}

// Numbers of options are not without gaps: the themes of a job begin at multiples of CLI_THEME_OPTIONS.
static int end_of_options(const cli_args *args)
{
    return args->noptions + (args->job ? CLI_JOB_OPTIONS : 0);
}

// NULL: no option has this number.
static const cli_option *option_at(const cli_args *args, int i)
{
    if (!args->job) return &args->options[i];
    if (i >= CLI_JOB_OPTIONS) return &args->options[i - CLI_JOB_OPTIONS];
    const cli_theme *theme = cli_theme_of(i / CLI_THEME_OPTIONS);
    return i % CLI_THEME_OPTIONS < theme->noptions ? &theme->options[i % CLI_THEME_OPTIONS] : NULL;
}

static int unknown_option(const cli_args *args, const char *name, size_t length)
{
    enum { MOST = 128 };
    const char *names[MOST];
    char word[64];
    int n = 0;
    for (int i = 0; i < end_of_options(args) && n < MOST; i++)
        if (option_at(args, i)) names[n++] = option_at(args, i)->name;
    snprintf(word, sizeof word, "%.*s", (int)length, name);
    const char *nearest = cli_nearest(word, names, n);
    if (nearest)
        cli_error("%s: no option '--%s'; did you mean '--%s'?", args->command, word, nearest);
    else
        cli_error("%s: no option '%s%s'", args->command, length == 1 ? "-" : "--", word);
    cli_usage_hint(args->command);
    return CLI_BAD;
}

static int take_value(cli_args *args, int index, const char *attached, const char **value)
{
    const cli_option *option = option_at(args, index);
    if (option->takes == CLI_NOTHING) {
        if (!attached) return index;
        cli_error("%s: --%s takes no value", args->command, option->name);
        return CLI_BAD;
    }
    if (attached)
        *value = attached;
    else if (args->at < args->argc)
        *value = args->argv[args->at++];
    else {
        cli_error("%s: --%s needs a value", args->command, option->name);
        cli_usage_hint(args->command);
        return CLI_BAD;
    }
    return index;
}

int cli_next(cli_args *args, const char **value)
{
    *value = NULL;
    if (args->at >= args->argc) return CLI_END;
    const char *text = args->argv[args->at++];
    if (!args->only_positionals && strcmp(text, "--") == 0) {
        args->only_positionals = true;
        return cli_next(args, value);
    }
    if (args->only_positionals || text[0] != '-' || text[1] == '\0') {
        *value = text;
        return CLI_POSITIONAL;
    }
    if (text[1] != '-') {
        for (int i = 0; i < end_of_options(args); i++)
            if (option_at(args, i) && option_at(args, i)->letter == text[1])
                return take_value(args, i, text[2] ? text + 2 : NULL, value);
        return unknown_option(args, text + 1, 1);
    }
    const char *name = text + 2, *equals = strchr(name, '=');
    size_t length = equals ? (size_t)(equals - name) : strlen(name);
    for (int i = end_of_options(args); i-- > 0;) { // the command's own go before those of a job
        const cli_option *option = option_at(args, i);
        if (option && strlen(option->name) == length && strncmp(option->name, name, length) == 0)
            return take_value(args, i, equals ? equals + 1 : NULL, value);
    }
    return unknown_option(args, name, length);
}

// A number, or a fraction of two, such as 1/3; false: neither.
static bool take_number(const char *text, char **end, double *out)
{
    errno = 0;
    *out = strtod(text, end);
    if (*end == text) return false;
    if (**end == '/') {
        char *below = *end + 1;
        *out /= strtod(below, end);
        if (*end == below) return false;
    }
    return isfinite(*out) && errno != ERANGE;
}

int cli_list(const char *name, const char *text, double *out, int most)
{
    const char *p = text;
    for (int n = 0; n < most;) {
        char *end;
        if (!take_number(p, &end, &out[n])) break;
        n++;
        if (*end == '\0') return n;
        if (*end != ',') break;
        p = end + 1;
    }
    if (most == 1)
        cli_error("%s: expected a number, got '%s'", name, text);
    else
        cli_error("%s: expected at most %d numbers separated by commas, got '%s'", name, most, text);
    return 0;
}

bool cli_double(const char *name, const char *text, double *out)
{
    double value;
    if (!cli_list(name, text, &value, 1)) return false;
    *out = value;
    return true;
}

static bool whole(const char *name, const char *text, double value, int lo, int hi, int *out)
{
    if (value != floor(value) || value < lo || value > hi) {
        cli_error("%s: expected a whole number from %d to %d, got '%s'", name, lo, hi, text);
        return false;
    }
    *out = (int)value;
    return true;
}

bool cli_int(const char *name, const char *text, int lo, int hi, int *out)
{
    double value;
    return cli_double(name, text, &value) && whole(name, text, value, lo, hi, out);
}

bool cli_double_pair(const char *name, const char *text, double out[2])
{
    double pair[2];
    int n = cli_list(name, text, pair, 2);
    if (n == 0) return false;
    out[0] = pair[0];
    out[1] = pair[n - 1];
    return true;
}

bool cli_int_pair(const char *name, const char *text, int lo, int hi, int out[2])
{
    double pair[2];
    return cli_double_pair(name, text, pair) && whole(name, text, pair[0], lo, hi, &out[0]) &&
           whole(name, text, pair[1], lo, hi, &out[1]);
}
