// SPDX-License-Identifier: Apache-2.0
// What receivers of CAD files take: degrees, within which tolerance, and how well that worked.
#include "cli/plan.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// What merging may take of the tolerance.
static const double merge_share = 0.2;
enum { USUAL_DEGREE = 25, LEAST_DEGREE = 3, SAMPLED_CELLS = 4 };
static const double usual_tol_mm = 0.01, usual_angle = 1, one_degree = 0.017453292519943295;

bool cli_set_max_degree(const char *name, const char *text, int *degree)
{
    static const struct {
        const char *profile;
        int degree;
    } profiles[] = {{"occt", 25}, {"catia", 15}, {"vda", 11}, {"cubic", 3}, {"exact", KN_MAX_DEGREE}};
    for (size_t i = 0; i < sizeof profiles / sizeof *profiles; i++)
        if (strcmp(text, profiles[i].profile) == 0) {
            *degree = profiles[i].degree;
            return true;
        }
    char *end;
    double number = strtod(text, &end);
    if (end != text && *end == '\0' && number == floor(number) && number >= LEAST_DEGREE && number <= KN_MAX_DEGREE) {
        *degree = (int)number;
        return true;
    }
    cli_error("%s: expected a number from %d to %d, or occt (25), catia (15), vda (11), cubic (3) or exact, got '%s'",
              name, LEAST_DEGREE, KN_MAX_DEGREE, text);
    return false;
}

kn_limit_options cli_limits_of(const cli_job *job)
{
    const cli_length *tol = &job->mesh_tol;
    double unit = job->unit_mm > 0 ? job->unit_mm : 1;
    return (kn_limit_options){
        .max_degree = job->max_degree > 0 ? job->max_degree : USUAL_DEGREE,
        .tolerance = !(tol->value > 0)  ? usual_tol_mm / unit
                     : tol->unit_mm > 0 ? tol->value * (tol->unit_mm / unit)
                                        : tol->value,
        .seam_angle = (job->seam_angle > 0 ? job->seam_angle : usual_angle) * one_degree,
    };
}

kn_status cli_create_job(kn_ctx *ctx, kn_job **out, const kn_spline *surfaces, int n, const kn_tile *tile,
                         const cli_job *layer)
{
    kn_job_options o = layer->options;
    kn_status status = kn_job_create(ctx, out, surfaces, n, tile, &o);
    bool degree = (status == KN_EDOMAIN || status == KN_ELIMIT) && strstr(kn_ctx_message(ctx), "--max-degree");
    if (!degree || o.max_degree == KN_MAX_DEGREE) return status;
    o.max_degree = KN_MAX_DEGREE;
    kn_ctx_clear_error(ctx);
    return kn_job_create(ctx, out, surfaces, n, tile, &o);
}

// *out: one sink before n others, which are its own then; after a failure they are closed.
static kn_status wrap(kn_ctx *ctx, kn_sink *out, cli_fit *fit, const kn_sink *sinks, int n)
{
    kn_limit_options limits = fit->options;
    const kn_merge_options merge = {.tolerance = merge_share * fit->options.tolerance,
                                    .angle = 0.5 * merge_share * fit->options.seam_angle};
    kn_sink merged = {0};
    kn_status status = KN_OK;
    if (fit->merge) {
        limits.tolerance -= merge.tolerance;
        limits.seam_angle -= 2 * merge.angle;
        status = kn_merge_sink(ctx, &merged, sinks, n, &merge, &fit->merged);
    }
    if (status == KN_OK)
        status = kn_limit_sink(ctx, out, fit->merge ? &merged : sinks, fit->merge ? 1 : n, &limits, &fit->sum);
    if (status == KN_OK) return KN_OK;
    kn_sink rest[CLI_MAX_OUTPUTS];
    memcpy(rest, sinks, (size_t)n * sizeof *rest);
    if (merged.user)
        kn_sink_close(ctx, &merged);
    else
        for (int i = 0; i < n; i++) kn_sink_close(ctx, &rest[i]);
    return status;
}

kn_status cli_fit_sinks(kn_ctx *ctx, cli_fit *fit, const kn_sink *opened, const bool *cad, int n, const cli_job *job)
{
    kn_sink limited[CLI_MAX_OUTPUTS];
    int count = 0;
    fit->options = cli_limits_of(job);
    fit->merge = job->merge;
    fit->nsinks = 0;
    for (int i = 0; i < n; i++) {
        if (cad[i])
            limited[count++] = opened[i];
        else
            fit->sinks[fit->nsinks++] = opened[i];
    }
    if (count == 0) return KN_OK;
    kn_status status = wrap(ctx, &fit->sinks[fit->nsinks], fit, limited, count);
    fit->known = status == KN_OK;
    if (fit->known)
        fit->nsinks++;
    else
        for (int i = 0; i < fit->nsinks; i++) kn_sink_close(ctx, &fit->sinks[i]);
    return status;
}

// ---- estimates ----

// What some cells of a job come to, in the place of all of them.
static kn_status sample(kn_ctx *ctx, kn_limit_summary *sum, const kn_job *job, const kn_limit_options *limits)
{
    kn_job_report r = kn_job_describe(job);
    kn_cell_range ranges[SAMPLED_CELLS];
    size_t n = r.cells < SAMPLED_CELLS ? r.cells : SAMPLED_CELLS;
    kn_sink inner = {0}, sink = {0};
    for (size_t i = 0; i < n; i++) ranges[i] = (kn_cell_range){i * r.cells / n, 1};
    kn_status status = kn_null_sink(ctx, &inner);
    if (status != KN_OK) return status;
    status = kn_limit_sink(ctx, &sink, &inner, 1, limits, sum);
    if (status != KN_OK) {
        kn_sink_close(ctx, &inner);
        return status;
    }
    status = kn_job_run_cells(ctx, job, ranges, n, &sink, 1);
    kn_sink_close(ctx, &sink);
    if (status != KN_OK || n == 0) return status;
    double share = (double)r.cells / (double)n;
    size_t *const counts[] = {&sum->exact,          &sum->limited,     &sum->spans,          &sum->control_points,
                              &sum->unknown_angles, &sum->wide_angles, &sum->singular_angles};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        *counts[i] = (size_t)((double)*counts[i] * share + 0.5);
    return KN_OK;
}

kn_status cli_estimate_fit(kn_ctx *ctx, cli_fit *fit, const cli_plan *plan, const cli_job *job)
{
    kn_status status = KN_OK;
    fit->options = cli_limits_of(job);
    fit->known = fit->estimated = true;
    for (int i = 0; i < plan->nshown && status == KN_OK; i++) {
        kn_limit_summary one = {0}, *to = &fit->sum;
        kn_job_report r = kn_job_describe(plan->shown[i]);
        if (r.degree[0] <= fit->options.max_degree && r.degree[1] <= fit->options.max_degree) {
            one.exact = r.patches, one.control_points = r.control_points;
            for (int v = 0; v < 2; v++) one.degree[v] = r.degree[v];
        } else {
            status = sample(ctx, &one, plan->shown[i], &fit->options);
        }
        to->exact += one.exact, to->limited += one.limited, to->spans += one.spans;
        to->control_points += one.control_points, to->unknown_angles += one.unknown_angles;
        to->wide_angles += one.wide_angles, to->singular_angles += one.singular_angles;
        to->error = fmax(to->error, one.error), to->angle = fmax(to->angle, one.angle);
        for (int v = 0; v < 2; v++)
            if (one.degree[v] > to->degree[v]) to->degree[v] = one.degree[v];
    }
    return status;
}

// ---- reports ----

// Each of two faces may turn.
static double turn_of(const cli_fit *fit)
{
    return 2 * (fit->sum.angle + fit->merged.angle);
}

json_t *cli_fit_json(const cli_fit *fit)
{
    const kn_limit_summary *s = &fit->sum;
    json_t *o = json_pack("{s:i,s:o,s:o,s:b}", "max_degree", fit->options.max_degree, "tolerance",
                          cli_json_number(fit->options.tolerance), "seam_angle_asked_rad",
                          cli_json_number(fit->options.seam_angle), "estimated", fit->estimated);
    static const char *const keys[] = {"certified_error", "exact_faces",    "limited_faces",
                                       "degree",          "control_points", "seam_angle_rad",
                                       "unknown_angles",  "wide_angles",    "singular_angles"};
    if (!fit->known) {
        for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) json_object_set_new(o, keys[i], json_null());
        return o;
    }
    // An estimate certifies nothing but what is asked for.
    double error = fit->estimated && s->limited > 0 ? fit->options.tolerance : s->error + fit->merged.error;
    json_object_set_new(o, keys[0], cli_json_upper(error));
    json_object_set_new(o, keys[1], json_integer((json_int_t)s->exact));
    json_object_set_new(o, keys[2], json_integer((json_int_t)s->limited));
    json_object_set_new(o, keys[3], json_pack("[ii]", s->degree[0], s->degree[1]));
    json_object_set_new(o, keys[4], json_integer((json_int_t)s->control_points));
    json_object_set_new(o, keys[5], cli_json_upper(turn_of(fit)));
    json_object_set_new(o, keys[6], json_integer((json_int_t)(s->unknown_angles + fit->merged.unknown_angles)));
    json_object_set_new(o, keys[7], json_integer((json_int_t)s->wide_angles));
    json_object_set_new(o, keys[8], json_integer((json_int_t)(s->singular_angles + fit->merged.singular_angles)));
    if (fit->merge && !fit->estimated)
        json_object_set_new(o, "merge",
                            json_pack("{s:I,s:I,s:I,s:o}", "faces", (json_int_t)fit->merged.faces, "merged",
                                      (json_int_t)fit->merged.merged, "c2", (json_int_t)fit->merged.c2,
                                      "certified_error", cli_json_upper(fit->merged.error)));
    return o;
}

void cli_print_fit(const cli_fit *fit)
{
    const kn_limit_summary *s = &fit->sum;
    if (fit->merge && fit->known && !fit->estimated)
        printf("merged into %zu faces, %zu of them of several patches, within %.1e (certified)\n", fit->merged.faces,
               fit->merged.merged, cli_outward(fit->merged.error, 1, CLI_TEXT_DIGITS));
    if (!fit->known || s->limited == 0) return;
    printf("for CAD %s%zu patches of degree up to %d within %.1e%s, %zu as composed; %zu control points in all",
           fit->estimated ? "about " : "", s->limited, fit->options.max_degree,
           cli_outward(fit->estimated ? fit->options.tolerance : s->error, 1, CLI_TEXT_DIGITS),
           fit->estimated ? "" : " (certified)", s->exact, s->control_points);
    if (!fit->estimated)
        printf("; smooth seams stay so within %.1e rad%s", cli_outward(turn_of(fit), 1, CLI_TEXT_DIGITS),
               s->unknown_angles > 0 ? " where normals are certified" : "");
    putchar('\n');
}
