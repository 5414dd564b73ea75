// SPDX-License-Identifier: Apache-2.0
// Curves of a STEP file on their own control points.
#include "step/line.h"
#include "kernel/context.h"

#include <math.h>

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

void kn_step_put_times(kn_text *text, const kn_step_axis *x, bool turned)
{
    kn_text_char(text, '(');
    for (int k = 0; k < x->nbreaks; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_integer(text, (uint64_t)x->times[turned ? x->nbreaks - 1 - k : k]);
    }
    kn_text_char(text, ')');
}

// Knot k of the curve that runs the other way over the same domain.
static double turned_break(const kn_step_axis *x, int k)
{
    double lo = x->breaks[0], hi = x->breaks[x->nbreaks - 1];
    return lo + (hi - x->breaks[x->nbreaks - 1 - k]);
}

void kn_step_put_breaks(kn_text *text, const kn_step_axis *x, bool turned)
{
    kn_text_char(text, '(');
    for (int k = 0; k < x->nbreaks; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_step_real(text, turned ? turned_break(x, k) : x->breaks[k]);
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

// ---- loading ----

kn_status kn_step_load_axis(kn_ctx *ctx, kn_step_axis *x, const kn_spline *s, int var)
{
    int degree = s->degree[var], count = s->count[var], n = 0;
    const double *knots = s->knots[var];
    int most = count - degree + 1;
    int *times = kn_scratch(ctx, (size_t)most, sizeof *times);
    double *breaks = kn_scratch(ctx, (size_t)most, sizeof *breaks);
    if (!times || !breaks) return KN_ENOMEM;
    for (int k = 0; k < count + degree + 1; k++) {
        if (k > 0 && knots[k] == knots[k - 1]) {
            times[n - 1]++;
            continue;
        }
        times[n] = 1, breaks[n++] = knots[k];
    }
    *x = (kn_step_axis){degree, count, n, times, breaks};
    return KN_OK;
}

kn_status kn_step_load_points(kn_ctx *ctx, double **out, bool *rational, double *largest, const kn_spline *s,
                              double mm, const char *what)
{
    size_t n = kn_spline_count(s);
    double *point = kn_scratch(ctx, 4 * n, sizeof *point), far = 0.0;
    if (!point) return KN_ENOMEM;
    bool good = true, differ = false;
    for (size_t k = 0; k < n && good; k++) {
        double weight = s->rational ? s->coef[3 * n + k] : 1.0;
        good = weight > 0.0 && isfinite(weight);
        for (size_t c = 0; c < 3 && good; c++) {
            double x = s->coef[c * n + k] / weight * mm;
            point[4 * k + c] = x;
            good = isfinite(x);
            far = fmax(far, fabs(x));
        }
        point[4 * k + 3] = weight;
        differ = differ || weight != point[3];
    }
    for (size_t k = 0; k < n && !differ; k++) point[4 * k + 3] = 1.0;
    *out = point, *rational = differ, *largest = far;
    return good ? KN_OK : kn_fail(ctx, KN_EUNDEFINED, "STEP: a control point of a %s is not finite", what);
}

kn_status kn_step_load_line(kn_ctx *ctx, kn_step_line *line, const kn_spline *s, double mm, uint32_t first)
{
    double *point = NULL, largest;
    *line = (kn_step_line){.step = 4, .own = true, .first = first, .next = 1};
    kn_status status = kn_step_load_axis(ctx, &line->axis, s, 0);
    if (status == KN_OK) status = kn_step_load_points(ctx, &point, &line->rational, &largest, s, mm, "curve");
    line->point = point;
    return status;
}

// ---- keys ----

// Inner knots count; those at the ends are the degree's.
kn_brep_key kn_step_line_key(bool *turned, const kn_step_line *line)
{
    const kn_step_axis *x = &line->axis;
    int ncomp = line->rational ? 4 : 3;
    kn_brep_key key = kn_brep_hash(turned, line->point, ncomp, 1, (size_t)x->n, line->step);
    double lo = x->breaks[0], length = x->breaks[x->nbreaks - 1] - lo;
    for (int k = 1; k + 1 < x->nbreaks; k++) {
        double at = ((*turned ? turned_break(x, k) : x->breaks[k]) - lo) / length;
        key = kn_brep_mix(key, at);
        key = kn_brep_mix(key, x->times[*turned ? x->nbreaks - 1 - k : k]);
    }
    return key;
}

// ---- text ----

void kn_step_put_line_points(kn_text *text, const kn_step_line *line)
{
    for (int k = 0; k < line->axis.n; k++)
        kn_step_put_point(text, line->first + (uint32_t)k * line->next, line->point + k * line->step, 3);
}

static void put_list(kn_text *text, const kn_step_line *line, bool turned, bool weights)
{
    int n = line->axis.n;
    kn_text_char(text, '(');
    for (int k = 0; k < n; k++) {
        int at = turned ? n - 1 - k : k;
        if (k > 0) kn_text_comma(text);
        if (weights)
            kn_text_step_real(text, line->point[at * line->step + 3]);
        else
            kn_text_relative(text, line->first + (uint32_t)at * line->next);
    }
    kn_text_char(text, ')');
}

void kn_step_put_line(kn_text *text, const kn_step_line *line, bool turned, bool closed)
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
