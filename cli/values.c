// SPDX-License-Identifier: Apache-2.0
// Values that options and keys of a recipe share.
#include "cli/cli.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

int cli_choice(const char *name, const char *text, const char *const *names, int n, const char *expected)
{
    for (int i = 0; i < n; i++)
        if (strcmp(text, names[i]) == 0) return i;
    cli_error("%s: expected %s, got '%s'", name, expected, text);
    return -1;
}

bool cli_positive_length(const char *name, const char *text, cli_length *out)
{
    return cli_length_of(name, text, out) && cli_above_zero(name, out->value);
}

bool cli_length_pair(const char *name, const char *text, cli_length out[2])
{
    char first[64];
    const char *comma = strchr(text, ',');
    size_t length = comma ? (size_t)(comma - text) : strlen(text);
    snprintf(first, sizeof first, "%.*s", (int)(length < sizeof first ? length : sizeof first - 1), text);
    return cli_length_of(name, first, &out[0]) && cli_length_of(name, comma ? comma + 1 : first, &out[1]);
}

bool cli_shift_pair(const char *name, const char *text, double out[2])
{
    double pair[2] = {0, 0};
    if (cli_list(name, text, pair, 2) == 0) return false;
    memcpy(out, pair, sizeof pair);
    return true;
}

bool cli_add_output(cli_recipe *recipe, const char *name, const char *path)
{
    if (!cli_can_write(path)) {
        const char *hint = cli_has_ending(path, "png") ? " (write a .glb, then 'knurl render' it)" : "";
        cli_error("%s: no writer for '%s'; endings: %s%s", name, path, cli_writable_endings(), hint);
        return false;
    }
    return cli_take_output(name, recipe->outputs, &recipe->noutputs, CLI_MAX_OUTPUTS, path);
}
