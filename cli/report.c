// SPDX-License-Identifier: Apache-2.0
// What `knurl apply` prints when it is done: a few lines for people, or one JSON object (the contract).
#include "cli/body.h"
#include "cli/plan.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

json_t *cli_json_text(const char *text)
{
    json_t *out = json_string(text);
    size_t bytes = strlen(text) + 1;
    char *copy = out ? NULL : malloc(bytes);
    if (!copy) return out;
    memcpy(copy, text, bytes);
    for (char *p = copy; *p; p++)
        if ((unsigned char)*p > 127) *p = '?';
    out = json_string(copy);
    free(copy);
    return out;
}

json_t *cli_json_number(double x)
{
    return isfinite(x) ? json_real(x) : json_null();
}

double cli_outward(double x, int sign, int digits)
{
    char text[32];
    if (!isfinite(x)) return x;
    snprintf(text, sizeof text, "%.*e", digits - 1, x);
    long exponent = strtol(strchr(text, 'e') + 1, NULL, 10);
    double y = strtod(text, NULL), step = pow(10.0, (double)(exponent - (digits - 1)));
    return sign * y < sign * x ? y + sign * step : y;
}

json_t *cli_json_upper(double x)
{
    return cli_json_number(cli_outward(x, 1, CLI_JSON_DIGITS));
}

json_t *cli_json_lower(double x)
{
    return cli_json_number(cli_outward(x, -1, CLI_JSON_DIGITS));
}

static json_t *range_json(const kn_cells_range *r)
{
    json_t *histogram = json_array();
    for (int i = 0; i < KN_CELLS_BINS; i++)
        json_array_append_new(histogram, json_integer((json_int_t)r->histogram[i]));
    return json_pack("{s:o,s:o,s:o,s:o}", "min", cli_json_number(r->min), "mean", cli_json_number(r->mean), "max",
                     cli_json_number(r->max), "histogram", histogram);
}

static json_t *file_bytes(const cli_apply *a, const double *bytes)
{
    json_t *object = json_object();
    for (int i = 0; i < a->recipe.noutputs; i++) {
        json_t *key = cli_json_text(a->recipe.outputs[i]);
        json_object_set_new(object, json_string_value(key), json_integer((json_int_t)bytes[i]));
        json_decref(key);
    }
    return object;
}

static const char *const reasons[KN_DROP_REASONS] = {
    [KN_DROP_SURFACE] = "faces",   [KN_DROP_RANGE] = "range",  [KN_DROP_SKIP] = "skip",
    [KN_DROP_DENSITY] = "density", [KN_DROP_MASK] = "mask",    [KN_DROP_CONE] = "angle",
    [KN_DROP_TRIM] = "trim",       [KN_DROP_SLAB] = "slab",    [KN_DROP_OUTSIDE] = "outside",
    [KN_DROP_SMALL] = "small",     [KN_DROP_HIDDEN] = "hidden"};

// Cells that are not there, by what excluded them.
static json_t *dropped_json(const kn_job_report *r)
{
    json_t *o = json_object();
    for (int i = 0; i < KN_DROP_REASONS; i++)
        if (r->dropped[i] > 0) json_object_set_new(o, reasons[i], json_integer((json_int_t)r->dropped[i]));
    return o;
}

static void print_dropped(const kn_job_report *r)
{
    const char *before = "left out: ";
    for (int i = 0; i < KN_DROP_REASONS; i++) {
        if (r->dropped[i] == 0) continue;
        printf("%s%zu cells (%s)", before, r->dropped[i], reasons[i]);
        before = ", ";
    }
    if (*before == ',') putchar('\n');
}

// A direction that is given is exact, and no unit normal: there is nothing to certify.
static json_t *normal_json(const kn_job_options *o, const kn_job_report *r)
{
    if (o->direction)
        return json_pack("{s:s,s:n,s:n,s:n,s:n}", "method", "direction", "tolerance", "length_error",
                         "angle_error_rad", "certified");
    return json_pack("{s:s,s:o,s:o,s:o,s:b}", "method", o->normal == KN_NORMAL_FITTED ? "fitted" : "exact-direction",
                     "tolerance", cli_json_number(r->normal_tol), "length_error",
                     cli_json_upper(r->normal.length_error), "angle_error_rad", cli_json_upper(r->normal.angle_error),
                     "certified", r->normal.certified);
}

static json_t *layers_json(const cli_apply *a, const cli_plan *plan)
{
    json_t *array = json_array();
    for (int i = 0; i < plan->njobs; i++) {
        const kn_job_report r = kn_job_describe(plan->jobs[i]);
        const cli_job *layer = &a->recipe.layer[i];
        json_array_append_new(array,
                              json_pack("{s:o,s:i,s:b,s:I,s:I,s:I,s:o,s:o}", "tile", cli_json_text(layer->tile), "on",
                                        layer->on, "base_only", layer->base_only, "cells", (json_int_t)r.cells,
                                        "patches", (json_int_t)r.patches, "triangles", (json_int_t)r.triangles,
                                        "height", cli_json_number(r.height), "cells_dropped", dropped_json(&r)));
    }
    return array;
}

static void print_json(const cli_apply *a, const cli_plan *plan, const cli_fit *fit, const cli_body_run *body,
                       const double *bytes, const cli_timing *t, size_t peak_bytes)
{
    const kn_job_report *r = &plan->report;
    // stand_in.tolerance: a stand-in and n may each be off by it in length and in angle, at the tile's height; patches
    // that meet instead by four times that.
    double meeting = a->recipe.layer[0].options.equal_edges ? 4.0 : 1.0;
    json_t *o = json_object();
    json_object_set_new(o, "base", cli_json_text(a->recipe.layer[0].base));
    json_object_set_new(o, "tile", cli_json_text(a->recipe.layer[0].tile));
    json_object_set_new(o, "dry_run", json_boolean(a->dry_run));
    json_object_set_new(o, "surfaces", json_integer(r->nsurfaces));
    if (a->recipe.nlayers > 1) json_object_set_new(o, "layers", layers_json(a, plan));
    json_object_set_new(o, "cells", json_integer((json_int_t)r->cells));
    json_object_set_new(o, "cells_dropped", dropped_json(r));
    if (a->recipe.layer[0].joined) json_object_set_new(o, "edges", cli_joined_json(a->recipe.layer[0].joined));
    json_object_set_new(o, "patches", json_integer((json_int_t)r->patches));
    json_object_set_new(o, "exact_patches", json_integer((json_int_t)r->exact_patches));
    json_object_set_new(o, "faces", json_integer((json_int_t)(r->patches - r->curves - r->volumes - r->meshes)));
    json_object_set_new(o, "curves", json_integer((json_int_t)r->curves));
    json_object_set_new(o, "volumes", json_integer((json_int_t)r->volumes));
    json_object_set_new(o, "meshes", json_integer((json_int_t)r->meshes));
    json_object_set_new(o, "triangles", json_integer((json_int_t)r->triangles));
    json_object_set_new(o, "degree", json_pack("[ii]", r->degree[0], r->degree[1]));
    json_object_set_new(o, "control_points", json_integer((json_int_t)r->control_points));
    json_object_set_new(o, "cell_size", cli_json_number(r->cell_size));
    json_object_set_new(o, "height", cli_json_number(r->height));
    json_object_set_new(o, "normal", normal_json(&a->recipe.layer[0].options, r));
    json_object_set_new(o, "stand_in",
                        json_pack("{s:o,s:o}", "tolerance",
                                  cli_json_number(meeting * 4 * r->normal_tol * fabs(r->height)), "certified_error",
                                  cli_json_upper(r->stand_in_error)));
    json_object_set_new(o, "fit", cli_fit_json(fit));
    json_object_set_new(o, "body", cli_body_json(body));
    json_object_set_new(o, "crossing_error", cli_json_upper(r->crossing_error));
    json_object_set_new(o, "jacobian",
                        json_pack("{s:o,s:o,s:b}", "min", cli_json_lower(r->jacobian_lo), "max",
                                  cli_json_upper(r->jacobian_hi), "certified_positive", r->jacobian_lo > 0));
    json_object_set_new(o, "spread",
                        json_pack("{s:o,s:o,s:o,s:o,s:i}", "width", range_json(&r->spread.width), "height",
                                  range_json(&r->spread.height), "area", range_json(&r->spread.area),
                                  "reparameterization_error", cli_json_upper(r->cells_error), "even_instead",
                                  r->even_instead));
    json_object_set_new(o, "bytes", file_bytes(a, bytes));
    json_object_set_new(o, "bytes_estimated", json_boolean(a->dry_run));
    json_object_set_new(o, "seconds",
                        json_pack("{s:f,s:f,s:f,s:f}", "read", t->read, "plan", t->plan, "compose_and_write", t->run,
                                  "total", t->read + t->plan + t->run));
    json_object_set_new(o, "peak_bytes", json_integer((json_int_t)peak_bytes));
    json_dumpf(o, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(CLI_JSON_DIGITS));
    putchar('\n');
    json_decref(o);
}

static void print_text(const cli_apply *a, const kn_job_report *r, const cli_fit *fit, const cli_body_run *body,
                       const double *bytes, const cli_timing *t)
{
    printf("%zu cells of about %.3g, height %.3g, on %d surface%s\n", r->cells, r->cell_size, r->height, r->nsurfaces,
           r->nsurfaces == 1 ? "" : "s");
    print_dropped(r);
    cli_print_joined(a->recipe.layer[0].joined);
    const kn_cells_spread *sp = &r->spread;
    if (sp->cells > 0)
        printf("cells %.3g to %.3g wide, %.3g to %.3g high; areas differ by a factor of %.3g\n", sp->width.min,
               sp->width.max, sp->height.min, sp->height.max, sp->area.max / sp->area.min);
    if (r->cells_error > 0)
        printf("cells follow free corners within %.1e (certified)\n", cli_outward(r->cells_error, 1, 2));
    if (r->even_instead > 0)
        printf("even lines instead of free corners on %d of %d surfaces: no fit within the tolerance and the degrees "
               "that --max-degree leaves\n",
               r->even_instead, r->nparts);
    printf("%zu patches of degree up to (%d,%d), %zu control points, %zu triangles\n", r->patches, r->degree[0],
           r->degree[1], r->control_points, r->triangles);
    if (r->curves + r->volumes + r->meshes > 0)
        printf("of them %zu curves, %zu volumes, %zu pieces of meshes\n", r->curves, r->volumes, r->meshes);
    if (r->crossing_error > 0)
        printf("pieces at knot lines and clipped ends within %.1e (certified)\n",
               cli_outward(r->crossing_error, 1, CLI_TEXT_DIGITS));
    if (a->recipe.layer[0].options.direction)
        printf("along the given direction\n");
    else
        printf("unit normal within %.1e in length and %.1e rad%s\n",
               cli_outward(r->normal.length_error, 1, CLI_TEXT_DIGITS),
               cli_outward(r->normal.angle_error, 1, CLI_TEXT_DIGITS), r->normal.certified ? " (certified)" : "");
    if (r->exact_patches == r->patches)
        printf("every patch is the exact composition\n");
    else
        printf("%zu patches exact, %zu within %.1e (certified)\n", r->exact_patches, r->patches - r->exact_patches,
               cli_outward(r->stand_in_error + r->crossing_error, 1, CLI_TEXT_DIGITS));
    cli_print_fit(fit);
    cli_print_body(body);
    if (!(r->jacobian_lo > 0))
        printf("the shell is not certified free of folds and poles (Jacobian >= %.2g)\n",
               cli_outward(r->jacobian_lo, -1, CLI_TEXT_DIGITS));
    for (int i = 0; i < a->recipe.noutputs; i++)
        printf("%s%s  %.1f MB\n", a->dry_run ? "would write about " : "", a->recipe.outputs[i], bytes[i] / 1e6);
    printf("%.2f s\n", t->read + t->plan + t->run);
}

void cli_print_apply(const cli_apply *apply, const cli_plan *plan, const cli_fit *fit, const cli_body_run *body,
                     const double *bytes, const cli_timing *timing, size_t peak_bytes)
{
    if (apply->recipe.layer[0].json)
        print_json(apply, plan, fit, body, bytes, timing, peak_bytes);
    else if (!apply->recipe.layer[0].quiet)
        print_text(apply, &plan->report, fit, body, bytes, timing);
}
