// SPDX-License-Identifier: Apache-2.0
// Fields over a base: a vector or a number for all of it, or a spline from a file.
#include "cli/cli.h"

static int components_of(cli_field_kind kind)
{
    return kind == CLI_FIELD_THICKNESS ? 1 : 3;
}

static const char *name_of(cli_field_kind kind)
{
    static const char *const names[CLI_FIELDS] = {[CLI_FIELD_DIRECTION] = "--direction",
                                                  [CLI_FIELD_THICKNESS] = "--thickness",
                                                  [CLI_FIELD_ATTRACTION] = "--attraction"};
    return names[kind];
}

// Of degree 1, as everything that is differentiated later likes it.
static kn_status make_constant(kn_ctx *ctx, cli_field *field, cli_field_kind kind)
{
    static const double line[] = {0, 0, 1, 1};
    double coef[12];
    int n = components_of(kind);
    for (int i = 0; i < 4 * n; i++) coef[i] = field->value[i / 4];
    return kn_spline_init(ctx, &field->spline, 2, n, false, (const int[]){1, 1}, (const int[]){2, 2},
                          (const double *const[]){line, line}, coef);
}

// The file's surface over [0,1]^2. A thickness may also be drawn as a surface in space: its last coordinate counts.
static kn_status take_surface(kn_ctx *ctx, cli_field *field, cli_field_kind kind, const kn_spline *from)
{
    int n = components_of(kind);
    kn_status status = kn_spline_components(ctx, &field->spline, from, from->ncomp - n, n);
    for (int d = 0; d < 2 && status == KN_OK; d++)
        status = kn_spline_reparameterize(ctx, &field->spline, &field->spline, d, 0, 1);
    return status;
}

int cli_read_field(cli_session *session, cli_field *field, cli_field_kind kind)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_model model = {0};
    if (!field->given) return EXIT_OK;
    if (!field->path) {
        kn_status made = make_constant(ctx, field, kind);
        return made == KN_OK ? EXIT_OK : cli_fail(session, made, false);
    }
    kn_status status = kn_read_model(ctx, &model, field->path);
    int code = status == KN_OK ? EXIT_OK : cli_fail_on(session, status, field->path, true);
    if (code == EXIT_OK) {
        const kn_spline *s = model.nsplines == 1 ? &model.splines[0] : NULL;
        bool fits = s && s->nvars == 2 && !s->rational && (s->ncomp == 3 || s->ncomp == components_of(kind));
        status = fits ? take_surface(ctx, field, kind, s) : KN_OK;
        if (status != KN_OK) code = cli_fail_on(session, status, field->path, true);
        if (!fits) {
            cli_error("%s: %s: expected one polynomial surface of %s", name_of(kind), field->path,
                      kind == CLI_FIELD_THICKNESS ? "1 component (or 3, of which the last one counts)"
                                                  : "3 components");
            code = EXIT_BAD_INPUT;
        }
    }
    kn_model_clear(ctx, &model);
    return code;
}
