// SPDX-License-Identifier: Apache-2.0
// Options of colours by a field: which field, which palette, of which parts.
#include "cli/cli.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COLOR, PALETTE, COLOR_STEPS, COLOR_PART, OPTIONS };
static const cli_option options[OPTIONS] = {
    [COLOR] = {"color", 0, CLI_FILE},
    [PALETTE] = {"palette", 0, CLI_TEXT},
    [COLOR_STEPS] = {"color-steps", 0, CLI_TEXT},
    [COLOR_PART] = {"color-part", 0, CLI_TEXT},
};

// Dark to light, but for the last two; the first is the default.
static const struct {
    const char *name, *colors;
} palettes[] = {
    {"ember", "2b0b12,7a1420,c8401c,f08c2e,fbd983"},  {"gray", "1c1c1c,8c8c8c,f2f2f2"},
    {"gold", "33200a,8a5a14,d9a62e,fbe7a1"},          {"copper", "2e130c,8b3f22,d07a4a,f0c39a"},
    {"moss", "18240f,44612a,8ba152,d9d79a"},          {"sea", "0a1c3a,12527f,2a9d9a,9fe0c4"},
    {"coral", "3f1238,a1285a,ea5d62,ffb88a"},         {"ivory", "5a4636,a88a66,dcc8a2,f7efdc"},
    {"autumn", "5c6b22,c9a227,d9691e,9b2217,4a1420"}, {"rainbow", "c8323c,e88a2c,e6d23c,4ea64e,2f7fc4,6a48a8"},
};
enum { PALETTES = sizeof palettes / sizeof *palettes };

// Six digits: the last bits of pow differ between C libraries.
double cli_linear_of_srgb(double x)
{
    return rint((x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4)) * 1e6) / 1e6;
}

// rrggbb or rgb, perhaps behind a '#'.
static bool read_color(const char *text, size_t length, double rgb[3])
{
    if (length > 0 && *text == '#') text++, length--;
    if (length != 6 && length != 3) return false;
    for (size_t c = 0; c < 3; c++) {
        const char digits[3] = {text[c * (length / 3)], length == 6 ? text[2 * c + 1] : text[c], '\0'};
        if (!isxdigit((unsigned char)digits[0]) || !isxdigit((unsigned char)digits[1])) return false;
        rgb[c] = cli_linear_of_srgb((double)strtol(digits, NULL, 16) / 255.0);
    }
    return true;
}

static int read_colors(const char *text, double (*palette)[3])
{
    int n = 0;
    for (const char *at = text; at; n++) {
        const char *comma = strchr(at, ',');
        size_t length = comma ? (size_t)(comma - at) : strlen(at);
        if (n == CLI_MAX_PALETTE || !read_color(at, length, palette[n])) return 0;
        at = comma ? comma + 1 : NULL;
    }
    return n;
}

static bool set_palette(cli_color *color, const char *name, const char *text)
{
    const char *colors = text;
    for (int i = 0; i < PALETTES; i++)
        if (strcmp(text, palettes[i].name) == 0) colors = palettes[i].colors;
    color->npalette = read_colors(colors, color->palette);
    if (color->npalette > 0) return true;
    char known[256] = "";
    for (int i = 0; i < PALETTES; i++) {
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s, ", palettes[i].name);
    }
    cli_error("%s: expected %sor up to %d colours as rrggbb,rrggbb,.., got '%s'", name, known, CLI_MAX_PALETTE, text);
    return false;
}

// "A" or "A,B,..".
static bool set_parts(cli_color *color, const char *name, const char *text)
{
    int n = 0;
    for (const char *at = text; at; n++) {
        const char *comma = strchr(at, ',');
        size_t length = comma ? (size_t)(comma - at) : strlen(at);
        if (length == 0 || length >= KN_NAME_BYTES || n == CLI_MAX_COLORED) {
            cli_error("%s: expected up to %d names of parts, got '%s'", name, CLI_MAX_COLORED, text);
            return false;
        }
        memcpy(color->part[n], at, length);
        color->part[n][length] = '\0';
        at = comma ? comma + 1 : NULL;
    }
    color->nparts = n;
    return true;
}

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    cli_color *color = &job->color;
    switch (option) {
    case COLOR: color->field = (cli_scalar){.text = text}; return true;
    case PALETTE: return set_palette(color, name, text);
    case COLOR_STEPS: return cli_int(name, text, 1, 256, &color->steps);
    case COLOR_PART: return set_parts(color, name, text);
    default: return false;
    }
}

bool cli_color_lacks_field(const cli_color *color)
{
    return !color->field.text && (color->npalette > 0 || color->steps > 0 || color->nparts > 0);
}

int cli_color_begin(cli_session *session, cli_color *color, uint64_t seed)
{
    if (!color->field.text) return EXIT_OK;
    int code = cli_scalar_begin(session, &color->field, "--color", seed);
    if (color->npalette == 0) color->npalette = read_colors(palettes[0].colors, color->palette);
    color->nrules = color->nparts > 0 ? color->nparts : 1;
    for (int i = 0; i < color->nrules; i++)
        color->rule[i] = (kn_job_color){.part = color->nparts > 0 ? color->part[i] : NULL,
                                        .field = color->field.field,
                                        .palette = (const double(*)[3])color->palette,
                                        .npalette = color->npalette,
                                        .steps = color->steps};
    return code;
}

const cli_theme cli_color_options = {options, OPTIONS, CLI_OF_LAYER, set};
