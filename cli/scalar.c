// SPDX-License-Identifier: Apache-2.0
// A number at every place of a base: a number, an expression, a picture, or a spline from a file.
#include "cli/cli.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if KN_WITH_PNG
#include "bridges/png/gray.h"
#endif
#if KN_WITH_MUPARSER
#include "bridges/muparser/expression.h"
#endif

bool cli_scalar_is_file(const char *text)
{
    return cli_has_ending(text, "png") || cli_has_ending(text, "g2") || cli_has_ending(text, "bpt") ||
           cli_has_ending(text, "itd");
}

static double value_of_constant(const void *user, const kn_place *place)
{
    (void)place;
    return *(const double *)user;
}

static bool is_number(const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*value);
}

#if KN_WITH_PNG
static int begin_picture(cli_session *session, cli_scalar *scalar)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_status status = kn_png_read_gray(ctx, &scalar->samples, scalar->text);
    if (status != KN_OK) return cli_fail_on(session, status, scalar->text, true);
    status = kn_field_grid(ctx, &scalar->field, &scalar->samples);
    return status == KN_OK ? EXIT_OK : cli_fail_on(session, status, scalar->text, true);
}
#else
static int begin_picture(cli_session *session, cli_scalar *scalar)
{
    (void)session;
    cli_error("%s: cannot read pictures: built without libpng", scalar->text);
    return EXIT_FAILED;
}
#endif

#if KN_WITH_MUPARSER
static int begin_expression(cli_session *session, cli_scalar *scalar, const char *name, uint64_t seed)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_status status = kn_expression_create(ctx, &scalar->expression, scalar->text, seed);
    if (status != KN_OK) return cli_fail_at(session, status, "%s: %s", name, kn_ctx_message(ctx));
    scalar->field = kn_expression_field(scalar->expression);
    return EXIT_OK;
}

static void end_expression(cli_session *session, cli_scalar *scalar)
{
    kn_expression_destroy(cli_ctx(session), scalar->expression);
    scalar->expression = NULL;
}
#else
static int begin_expression(cli_session *session, cli_scalar *scalar, const char *name, uint64_t seed)
{
    (void)session, (void)seed;
    cli_error("%s: cannot read the expression '%s': built without muparser", name, scalar->text);
    return EXIT_FAILED;
}

static void end_expression(cli_session *session, cli_scalar *scalar)
{
    (void)session, (void)scalar;
}
#endif

static int begin_spline(cli_session *session, cli_scalar *scalar, const char *name)
{
    kn_ctx *ctx = cli_ctx(session);
    int code = cli_read_scalar_spline(session, &scalar->spline, scalar->text, name);
    kn_status status = code == EXIT_OK ? kn_field_spline(ctx, &scalar->field, &scalar->spline) : KN_OK;
    return status == KN_OK ? code : cli_fail_on(session, status, scalar->text, true);
}

int cli_scalar_begin(cli_session *session, cli_scalar *scalar, const char *name, uint64_t seed)
{
    if (!scalar->text) return EXIT_OK;
    if (is_number(scalar->text, &scalar->constant)) {
        scalar->field = (kn_field){value_of_constant, &scalar->constant, 0};
        return EXIT_OK;
    }
    if (cli_has_ending(scalar->text, "png")) return begin_picture(session, scalar);
    if (cli_scalar_is_file(scalar->text)) return begin_spline(session, scalar, name);
    return begin_expression(session, scalar, name, seed);
}

void cli_scalar_end(cli_session *session, cli_scalar *scalar)
{
    kn_spline_clear(cli_ctx(session), &scalar->spline);
    kn_free(cli_ctx(session), (void *)scalar->samples.values);
    end_expression(session, scalar);
    *scalar = (cli_scalar){.text = scalar->text};
}
