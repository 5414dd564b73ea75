// SPDX-License-Identifier: Apache-2.0
// Bases named on the command line.
#include "cli/cli.h"

// Keeps the surfaces of a model in their order, and volumes if wanted, and drops the rest.
static int keep_surfaces(kn_ctx *ctx, kn_model *model, bool volumes)
{
    int kept = 0;
    for (int i = 0; i < model->nsplines; i++) {
        kn_spline *s = &model->splines[i];
        if ((s->nvars == 2 || (volumes && s->nvars == 3)) && kn_spline_dim(s) == 3)
            kn_spline_swap(&model->splines[kept++], s);
        else
            kn_spline_clear(ctx, s);
    }
    return kept;
}

int cli_read_base(cli_session *session, cli_base *out, const char *path, bool volumes)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_model model = {0};
    kn_status status = kn_read_model(ctx, &model, path);
    if (status != KN_OK) return cli_fail(session, status, true);
    int found = model.nsplines;
    kn_mesh_clear(ctx, &model.mesh);
    out->nsurfaces = keep_surfaces(ctx, &model, volumes);
    out->surfaces = model.splines;
    if (out->nsurfaces > 0 && out->nsurfaces < found)
        cli_warn(session, "%s: %d of its %d splines are no surfaces in three dimensions and are left out", path,
                 found - out->nsurfaces, found);
    if (out->nsurfaces > 0) return EXIT_OK;
    cli_error("%s: no surface in three dimensions among its splines, of which there are %d", path, found);
    cli_base_clear(session, out);
    return EXIT_BAD_INPUT;
}

void cli_base_clear(cli_session *session, cli_base *base)
{
    for (int i = 0; i < base->nsurfaces; i++) kn_spline_clear(cli_ctx(session), &base->surfaces[i]);
    kn_free(cli_ctx(session), base->surfaces);
    base->surfaces = NULL;
    base->nsurfaces = 0;
}
