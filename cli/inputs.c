// SPDX-License-Identifier: Apache-2.0
// Bases named on the command line.
#include "cli/cli.h"
#include "kernel/context.h"

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

// Surface i is a copy of face i's, trimmed as it is.
static kn_status copy_faces(kn_ctx *ctx, cli_base *out)
{
    const kn_cad *cad = &out->cad;
    size_t n = (size_t)cad->nfaces;
    bool trimmed = false;
    for (int i = 0; i < cad->nfaces; i++) trimmed = trimmed || !cad->faces[i].whole;
    out->surfaces = kn_alloc_zero(ctx, n, sizeof *out->surfaces);
    out->face = kn_alloc(ctx, n, sizeof *out->face);
    out->body = kn_alloc(ctx, n, sizeof *out->body);
    if (trimmed) out->trims = kn_alloc_zero(ctx, n, sizeof *out->trims);
    bool room = out->surfaces && out->face && out->body && (out->trims || !trimmed);
    kn_status status = room ? KN_OK : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < cad->nfaces; i++) {
        out->face[i] = i, out->body[i] = cad->faces[i].body;
        status = kn_spline_copy(ctx, &out->surfaces[out->nsurfaces++], &cad->faces[i].surface);
        if (status == KN_OK && !cad->faces[i].whole) status = kn_trim_copy(ctx, &out->trims[i], &cad->faces[i].trim);
    }
    return status;
}

static int read_cad_base(cli_session *session, cli_base *out, const char *path)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_status status = cli_read_cad(ctx, &out->cad, path);
    if (status == KN_OK) status = copy_faces(ctx, out);
    if (status == KN_OK) return EXIT_OK;
    cli_base_clear(session, out);
    return cli_fail(session, status, true);
}

int cli_read_base(cli_session *session, cli_base *out, const char *path, bool volumes)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_model model = {0};
    out->path = path;
    if (cli_is_cad(path)) return read_cad_base(session, out, path);
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
    for (int i = 0; base->trims && i < base->nsurfaces; i++) kn_trim_clear(cli_ctx(session), &base->trims[i]);
    kn_free(cli_ctx(session), base->surfaces);
    kn_free(cli_ctx(session), base->trims);
    kn_free(cli_ctx(session), base->face);
    kn_free(cli_ctx(session), base->body);
    kn_cad_clear(cli_ctx(session), &base->cad);
    kn_cad_joined_clear(cli_ctx(session), &base->joined);
    *base = (cli_base){0};
}

static kn_status find_faces(kn_ctx *ctx, bool *flags, const cli_job *job, const kn_cad *cad)
{
    kn_status status = KN_OK;
    for (int i = 0; i < job->nfaces && status == KN_OK; i++) {
        if (job->faces[i] >= cad->nfaces)
            status = kn_fail(ctx, KN_EDOMAIN, "faces: face %d; the file has 0 to %d", job->faces[i], cad->nfaces - 1);
        else
            flags[job->faces[i]] = true;
    }
    for (int i = 0; i < job->nface_texts && status == KN_OK; i++) {
        int *found = NULL, n = 0;
        status = kn_cad_find(ctx, &found, &n, cad, job->face_text[i]);
        for (int k = 0; k < n; k++) flags[found[k]] = true;
        kn_free(ctx, found);
    }
    return status;
}

// Keeps the surfaces of these faces. place: where each face went, -1: nowhere.
static void keep_faces(kn_ctx *ctx, cli_base *base, const bool *flags, int *place)
{
    int kept = 0;
    bool trimmed = false;
    for (int i = 0; i < base->nsurfaces; i++) {
        place[i] = flags[i] ? kept : -1;
        if (!flags[i]) {
            kn_spline_clear(ctx, &base->surfaces[i]);
            if (base->trims) kn_trim_clear(ctx, &base->trims[i]);
            continue;
        }
        kn_spline surface = base->surfaces[i];
        base->surfaces[i] = (kn_spline){0};
        base->surfaces[kept] = surface;
        kn_trim trim = base->trims ? base->trims[i] : (kn_trim){0};
        if (base->trims) base->trims[i] = (kn_trim){0};
        if (base->trims) base->trims[kept] = trim;
        trimmed = trimmed || trim.nloops > 0;
        base->body[kept] = base->body[i];
        base->face[kept++] = base->face[i];
    }
    base->nsurfaces = kept;
    if (!trimmed) {
        kn_free(ctx, base->trims);
        base->trims = NULL;
    }
}

// flags: nfaces of each job, one after the other, then those of all jobs.
static kn_status flag_faces(kn_ctx *ctx, bool *flags, cli_job *jobs, int njobs, const kn_cad *cad)
{
    size_t n = (size_t)cad->nfaces;
    kn_status status = KN_OK;
    for (int j = 0; status == KN_OK && j < njobs; j++) {
        bool *own = flags + (size_t)j * n, all = jobs[j].nfaces == 0 && jobs[j].nface_texts == 0;
        if (jobs[j].on > 0) continue; // its base is another layer
        status = find_faces(ctx, own, &jobs[j], cad);
        for (size_t i = 0; i < n; i++) {
            own[i] = own[i] || all;
            flags[(size_t)njobs * n + i] |= own[i];
        }
    }
    return status;
}

static kn_status choose(kn_ctx *ctx, cli_job *jobs, int njobs, cli_base *base)
{
    size_t n = (size_t)base->cad.nfaces;
    bool *flags = kn_alloc_zero(ctx, ((size_t)njobs + 1) * n, sizeof *flags);
    int *place = kn_alloc(ctx, n, sizeof *place);
    kn_status status = flags && place ? flag_faces(ctx, flags, jobs, njobs, &base->cad) : KN_ENOMEM;
    if (status == KN_OK) keep_faces(ctx, base, flags + (size_t)njobs * n, place);
    for (int j = 0; status == KN_OK && j < njobs; j++) {
        if (jobs[j].on > 0) continue;
        int *chosen = kn_alloc(ctx, n, sizeof *chosen), count = 0;
        status = chosen ? KN_OK : KN_ENOMEM;
        for (size_t i = 0; chosen && i < n; i++)
            if (flags[(size_t)j * n + i]) chosen[count++] = place[i];
        jobs[j].chosen = chosen;
        jobs[j].options.select.surfaces = chosen;
        jobs[j].options.select.nsurfaces = count;
        jobs[j].options.trims = base->trims;
        jobs[j].options.bodies = base->body;
    }
    kn_free(ctx, flags);
    kn_free(ctx, place);
    return status;
}

int cli_choose_faces(cli_session *session, cli_job *jobs, int njobs, cli_base *base)
{
    int nfaces = base->cad.nfaces;
    bool all = false;
    for (int j = 0; j < njobs; j++) {
        if (nfaces == 0 && jobs[j].nface_texts > 0) {
            cli_error("--faces: %s is no CAD file: its surfaces have numbers alone, got '%s'", base->path,
                      jobs[j].face_text[0]);
            return EXIT_USAGE;
        }
        all = all || (jobs[j].on == 0 && jobs[j].nfaces == 0 && jobs[j].nface_texts == 0);
    }
    if (nfaces == 0) return EXIT_OK;
    if (all && nfaces > 1)
        cli_warn(session, "%s: all its %d faces are meant; --faces chooses some, 'knurl info' lists them", base->path,
                 nfaces);
    kn_status status = choose(cli_ctx(session), jobs, njobs, base);
    if (status == KN_OK) status = cli_join_faces(cli_ctx(session), jobs, njobs, base);
    return status == KN_OK ? EXIT_OK : cli_fail_on(session, status, base->path, true);
}
