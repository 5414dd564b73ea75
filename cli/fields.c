// SPDX-License-Identifier: Apache-2.0
// Fields over a base: a vector or a number for all of it, or a spline from a file.
#include "cli/cli.h"

#include <stdlib.h>
#include <string.h>

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

bool cli_field_makes_sense(const char *name, cli_field_kind kind, const cli_field *field)
{
    const double *x = field->value;
    if (kind == CLI_FIELD_THICKNESS) return cli_above_zero(name, x[0]);
    if (kind != CLI_FIELD_DIRECTION || x[0] != 0 || x[1] != 0 || x[2] != 0) return true;
    cli_error("%s: 0,0,0 is no direction", name);
    return false;
}

cli_field_text cli_blamed_field(const cli_job *job, const char *message)
{
    cli_field_text out = {""};
    for (int f = 0; f < CLI_FIELDS; f++) {
        const char *name = name_of((cli_field_kind)f);
        if (!job->field[f].path || !strstr(message, name + 2)) continue;
        snprintf(out.text, sizeof out.text, "%s %.400s: ", name, job->field[f].path);
        break;
    }
    return out;
}

// Which face of a CAD file a surface is that a message names, for faces that are chosen are numbered anew.
static cli_field_text name_face(const cli_base *base, const char *message)
{
    cli_field_text out = {""};
    const char *at = strstr(message, "surface ");
    char *end = NULL;
    long s = at ? strtol(at + strlen("surface "), &end, 10) : -1;
    if (!base->face || !at || end == at + strlen("surface ") || s < 0 || s >= base->nsurfaces) return out;
    const char *name = base->cad.faces[base->face[s]].name;
    int n = snprintf(out.text, sizeof out.text, "; surface %ld is face %d of the file", s, base->face[s]);
    if (name[0]) snprintf(out.text + n, sizeof out.text - (size_t)n, ", \"%s\"", name);
    return out;
}

int cli_fail_on_job(cli_session *session, kn_status status, const cli_job *job, const cli_base *base)
{
    char message[512];
    snprintf(message, sizeof message, "%s", kn_ctx_message(cli_ctx(session)));
    cli_field_text field = cli_blamed_field(job, message), face = name_face(base, message);
    bool blame = status == KN_EDOMAIN || status == KN_ELIMIT || status == KN_EUNDEFINED;
    if ((!*field.text || !blame) && (!*face.text || (!blame && status != KN_EUNDECIDED)))
        return cli_fail_on(session, status, job->base, false);
    return cli_fail_at(session, status, "%s%s: %s%s", field.text, job->base, message, face.text);
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
static kn_status take_surface(kn_ctx *ctx, kn_spline *out, int n, const kn_spline *from)
{
    kn_status status = kn_spline_components(ctx, out, from, from->ncomp - n, n);
    for (int d = 0; d < 2 && status == KN_OK; d++) status = kn_spline_reparameterize(ctx, out, out, d, 0, 1);
    return status;
}

static int read_surface(cli_session *session, kn_spline *out, const char *path, const char *name, int n)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_model model = {0};
    kn_status status = kn_read_model(ctx, &model, path);
    int code = status == KN_OK ? EXIT_OK : cli_fail_on(session, status, path, true);
    if (code == EXIT_OK) {
        const kn_spline *s = model.nsplines == 1 ? &model.splines[0] : NULL;
        bool fits = s && s->nvars == 2 && !s->rational && (s->ncomp == 3 || s->ncomp == n);
        status = fits ? take_surface(ctx, out, n, s) : KN_OK;
        if (status != KN_OK) code = cli_fail_on(session, status, path, true);
        if (!fits) {
            cli_error("%s: %s: expected one polynomial surface of %s", name, path,
                      n == 1 ? "1 component (or 3, of which the last one counts)" : "3 components");
            code = EXIT_BAD_INPUT;
        }
    }
    kn_model_clear(ctx, &model);
    return code;
}

int cli_read_field(cli_session *session, cli_field *field, cli_field_kind kind)
{
    if (!field->given) return EXIT_OK;
    if (field->path) return read_surface(session, &field->spline, field->path, name_of(kind), components_of(kind));
    kn_status made = make_constant(cli_ctx(session), field, kind);
    return made == KN_OK ? EXIT_OK : cli_fail(session, made, false);
}

int cli_read_scalar_spline(cli_session *session, kn_spline *out, const char *path, const char *name)
{
    return read_surface(session, out, path, name, 1);
}
