// SPDX-License-Identifier: Apache-2.0
// knurl eval: points and derivatives of a spline, or of the shell over a surface.
#include "cli/cli.h"

#include <jansson.h>
#include <stdlib.h>

enum { AT, PATCH, DERIVATIVES, NORMAL_TOL, JSON, HELP };
static const cli_option options[] = {
    [AT] = {"at", 0, CLI_TEXT},
    [PATCH] = {"patch", 0, CLI_TEXT},
    [DERIVATIVES] = {"derivatives", 0, CLI_TEXT},
    [NORMAL_TOL] = {"normal-tol", 0, CLI_TEXT},
    [JSON] = {"json", 0, CLI_NOTHING},
    [HELP] = {"help", 'h', CLI_NOTHING},
};

enum { MOST_POINTS = 1024, MOST_ORDER = 8 };

typedef struct point {
    double at[KN_MAX_VARS];
    int n;
} point;

typedef struct request {
    const char *file;
    point points[MOST_POINTS];
    int npoints, patch, order;
    double normal_tol;
    bool json;
} request;

static bool add_point(request *r, const char *text)
{
    if (r->npoints == MOST_POINTS) {
        cli_error("--at: more than %d points", MOST_POINTS);
        return false;
    }
    point *p = &r->points[r->npoints];
    p->n = cli_list("--at", text, p->at, KN_MAX_VARS);
    r->npoints += p->n > 0;
    return p->n > 0;
}

static void print_values(const point *p, const double *values, int n, int dim, json_t *all)
{
    if (!all) {
        for (int i = 0; i < n; i++)
            for (int c = 0; c < dim; c++) printf("%.17g%c", values[i * dim + c], c == dim - 1 ? '\n' : ' ');
        return;
    }
    json_t *at = json_array(), *rows = json_array();
    for (int i = 0; i < p->n; i++) json_array_append_new(at, json_real(p->at[i]));
    for (int i = 0; i < n; i++) {
        json_t *row = json_array();
        for (int c = 0; c < dim; c++) json_array_append_new(row, json_real(values[i * dim + c]));
        json_array_append_new(rows, row);
    }
    json_array_append_new(all, json_pack("{s:o,s:o}", "at", at, "values", rows));
}

static kn_status eval_spline(kn_ctx *ctx, const kn_spline *s, const point *p, int order, json_t *all)
{
    int n = kn_derivative_count(s->nvars, order), dim = kn_spline_dim(s);
    double *values = calloc((size_t)n * (size_t)dim, sizeof *values);
    kn_status status = values ? kn_spline_derivatives(ctx, values, s, p->at, order) : KN_ENOMEM;
    if (status == KN_OK) print_values(p, values, n, dim, all);
    free(values);
    return status;
}

// T(u,v,w) and, at order 1, its partials: the rows of the values are T, T_u, T_v, T_w.
static kn_status eval_shell(kn_ctx *ctx, const kn_shell *shell, const point *p, int order, json_t *all)
{
    double values[12], jacobian[9];
    kn_status status = kn_shell_eval(ctx, values, jacobian, shell, p->at[0], p->at[1], p->at[2]);
    for (int d = 0; d < 3; d++)
        for (int c = 0; c < 3; c++) values[3 * (d + 1) + c] = jacobian[3 * c + d];
    if (status == KN_OK) print_values(p, values, order > 0 ? 4 : 1, 3, all);
    return status;
}

static bool inside(const kn_spline *s, const point *p)
{
    for (int d = 0; d < s->nvars; d++) {
        double lo, hi;
        kn_spline_domain(s, d, &lo, &hi);
        if (p->at[d] < lo || p->at[d] > hi) {
            cli_error("--at: parameter %d is %g, outside the domain [%g, %g]", d + 1, p->at[d], lo, hi);
            return false;
        }
    }
    return true;
}

static int eval_all(cli_session *session, const request *r, const kn_spline *s)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_shell *shell = NULL;
    json_t *all = r->json ? json_array() : NULL;
    int code = EXIT_OK;
    for (int i = 0; i < r->npoints && code == EXIT_OK; i++) {
        const point *p = &r->points[i];
        bool on_shell = s->nvars == 2 && kn_spline_dim(s) == 3 && p->n == 3;
        kn_status status = KN_OK;
        if (p->n != s->nvars && !on_shell) {
            cli_error("--at: %d parameters for a spline of %d variables", p->n, s->nvars);
            code = EXIT_USAGE;
        } else if (on_shell && r->order > 1) {
            cli_error("--derivatives: at most 1 for the shell T(u,v,w), got %d", r->order);
            code = EXIT_USAGE;
        } else if (!inside(s, p))
            code = EXIT_USAGE;
        else if (!on_shell)
            status = eval_spline(ctx, s, p, r->order, all);
        else {
            if (!shell) status = kn_shell_create(ctx, &shell, s, &(kn_shell_options){.normal_tol = r->normal_tol});
            if (status == KN_OK) status = eval_shell(ctx, shell, p, r->order, all);
        }
        if (status != KN_OK) code = cli_fail_on(session, status, r->file, false);
    }
    if (r->json && code == EXIT_OK) {
        json_dumpf(all, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
        putchar('\n');
    }
    json_decref(all);
    kn_shell_destroy(ctx, shell);
    return code;
}

static int eval_file(const request *r)
{
    cli_session *session = cli_session_begin((cli_session_options){.threads = 1});
    if (!session) return EXIT_FAILED;
    kn_model model = {0};
    kn_status status = cli_read_model(cli_ctx(session), &model, r->file);
    int code = status == KN_OK ? EXIT_OK : cli_fail(session, status, true);
    if (code == EXIT_OK && (r->patch < 0 || r->patch >= model.nsplines)) {
        cli_error("--patch: '%s' has patches 0 to %d, got %d", r->file, model.nsplines - 1, r->patch);
        code = EXIT_USAGE;
    }
    if (code == EXIT_OK) code = eval_all(session, r, &model.splines[r->patch]);
    kn_model_clear(cli_ctx(session), &model);
    cli_session_end(session);
    return code;
}

static bool set_option(request *r, int option, const char *value)
{
    switch (option) {
    case AT: return add_point(r, value);
    case PATCH: return cli_int("--patch", value, 0, 1000000000, &r->patch);
    case DERIVATIVES: return cli_int("--derivatives", value, 0, MOST_ORDER, &r->order);
    case NORMAL_TOL:
        if (!cli_double("--normal-tol", value, &r->normal_tol)) return false;
        if (r->normal_tol > 0) return true;
        cli_error("--normal-tol: expected a number above 0, got %g", r->normal_tol);
        return false;
    case JSON: return r->json = true;
    default: return false;
    }
}

static int eval_arguments(request *r, int argc, char **argv)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .command = "eval",
                     .noptions = sizeof options / sizeof *options};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == HELP) return cli_help(stdout, "eval");
        if (option == CLI_BAD || (option >= 0 && !set_option(r, option, value))) return EXIT_USAGE;
        if (option == CLI_POSITIONAL && r->file) {
            cli_error("eval: one file at a time, got '%s' and '%s'", r->file, value);
            return EXIT_USAGE;
        }
        if (option == CLI_POSITIONAL) r->file = value;
    }
    if (r->file && r->npoints > 0) return eval_file(r);
    cli_error("eval: %s", r->file ? "--at U,V is missing" : "a FILE is missing");
    cli_usage_hint("eval");
    return EXIT_USAGE;
}

int cli_command_eval(int argc, char **argv)
{
    request *r = calloc(1, sizeof *r);
    if (!r) {
        cli_error("out of memory");
        return EXIT_FAILED;
    }
    int code = eval_arguments(r, argc, argv);
    free(r);
    return code;
}
