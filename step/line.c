// SPDX-License-Identifier: Apache-2.0
// Curves of a STEP file on their own control points.
#include "step/line.h"

void kn_step_put_relative(kn_text *text, uint32_t k)
{
    kn_text_relative(text, k);
    kn_text_char(text, '=');
}

void kn_step_put_point(kn_text *text, uint32_t k, const double *x, int dim)
{
    kn_step_put_relative(text, k);
    kn_text_put(text, "CARTESIAN_POINT('',(");
    for (int c = 0; c < dim; c++) {
        if (c > 0) kn_text_char(text, ',');
        kn_text_step_real(text, x[c]);
    }
    kn_text_put(text, "));");
    kn_text_newline(text);
}

void kn_step_put_logical(kn_text *text, bool value)
{
    kn_text_put(text, value ? ".T." : ".F.");
}

void kn_step_put_times(kn_text *text, const kn_patch_axis *x, bool turned)
{
    kn_text_char(text, '(');
    for (int k = 0; k < x->nbreaks; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_integer(text, (uint64_t)x->times[turned ? x->nbreaks - 1 - k : k]);
    }
    kn_text_char(text, ')');
}

void kn_step_put_breaks(kn_text *text, const kn_patch_axis *x, bool turned)
{
    kn_text_char(text, '(');
    for (int k = 0; k < x->nbreaks; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_step_real(text, kn_patch_knot(x, k, turned));
    }
    kn_text_char(text, ')');
}

void kn_step_put_form(kn_text *text, uint32_t number, const char *form, const uint32_t *references)
{
    kn_step_put_relative(text, number);
    for (; *form; form++) {
        if (*form == '#')
            kn_text_relative(text, *references++);
        else
            kn_text_char(text, *form);
    }
    kn_text_newline(text);
}

static uint32_t point_number(const kn_patch_curve *line, int k)
{
    return (uint32_t)(line->first + k * line->by);
}

void kn_step_put_line_points(kn_text *text, const kn_patch_curve *line, int dim)
{
    for (int k = 0; k < line->axis.n; k++)
        kn_step_put_point(text, point_number(line, k), line->point + k * line->step, dim);
}

static void put_list(kn_text *text, const kn_patch_curve *line, bool turned, bool weights)
{
    int n = line->axis.n;
    kn_text_char(text, '(');
    for (int k = 0; k < n; k++) {
        int at = turned ? n - 1 - k : k;
        if (k > 0) kn_text_comma(text);
        if (weights)
            kn_text_step_real(text, line->point[at * line->step + 3]);
        else
            kn_text_relative(text, point_number(line, at));
    }
    kn_text_char(text, ')');
}

void kn_step_put_line(kn_text *text, const kn_patch_curve *line, bool turned, bool closed)
{
    kn_text_put(text, line->rational ? "(BOUNDED_CURVE()B_SPLINE_CURVE(" : "B_SPLINE_CURVE_WITH_KNOTS('',");
    kn_text_integer(text, (uint64_t)line->axis.degree);
    kn_text_char(text, ',');
    put_list(text, line, turned, false);
    kn_text_put(text, ",.UNSPECIFIED.,");
    kn_step_put_logical(text, closed);
    kn_text_put(text, line->rational ? ",.F.)B_SPLINE_CURVE_WITH_KNOTS(" : ",.F.,");
    kn_step_put_times(text, &line->axis, turned);
    kn_text_char(text, ',');
    kn_step_put_breaks(text, &line->axis, turned);
    kn_text_put(text, ",.UNSPECIFIED.");
    if (line->rational) {
        kn_text_char(text, ')');
        kn_text_newline(text);
        kn_text_put(text, "CURVE()GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE(");
        put_list(text, line, turned, true);
        kn_text_put(text, ")REPRESENTATION_ITEM('')");
    }
    kn_text_put(text, ");");
    kn_text_newline(text);
}
