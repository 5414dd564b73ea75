// SPDX-License-Identifier: Apache-2.0
// A sink before others that end at some degree: patches above it become splines within a tolerance.
#include <knurl/fit.h>
#include <knurl/io.h>

#include <math.h>
#include <string.h>

#include "io/state.h"
#include "kernel/context.h"

enum { FACES = 6, OF_PATCH = 5 }; // splines of a limited patch: itself and its edges
static const double USUAL_ANGLE = 0.017453292519943295, MOST_ANGLE = 0.8; // radians

typedef struct limit {
    kn_sink *sinks;
    int nsinks;
    kn_fit_limits limits;
    bool volumes; // patches may be volumes above the limit: block->first counts six for each
    kn_limit_summary sum, *told;
} limit;

// What a thread makes of a block.
typedef struct limited {
    kn_patch_block block;
    kn_patch *patches;
    kn_spline *splines;
    kn_bezier *faces; // of volumes
    size_t nsplines, nfaces;
    kn_limit_summary sum;
    void **of_sink;
    int nworked;
} limited;

// ---- summaries ----

static void add_sums(kn_limit_summary *to, const kn_limit_summary *s)
{
    to->exact += s->exact, to->limited += s->limited;
    to->unknown_angles += s->unknown_angles, to->wide_angles += s->wide_angles;
    to->singular_angles += s->singular_angles;
    to->spans += s->spans, to->control_points += s->control_points;
    to->error = fmax(to->error, s->error), to->angle = fmax(to->angle, s->angle);
    for (int v = 0; v < 2; v++)
        if (s->degree[v] > to->degree[v]) to->degree[v] = s->degree[v];
}

static void note_patch(kn_limit_summary *sum, const kn_patch *patch, const kn_fit_limited *report)
{
    const kn_spline s = kn_patch_spline(patch);
    kn_limit_summary one = {.exact = !report, .limited = report != NULL};
    if (report) {
        one.error = report->error, one.angle = report->angle;
        one.unknown_angles = (size_t)report->unknown_angles, one.wide_angles = (size_t)report->wide_angles;
        one.singular_angles = (size_t)report->singular_angles;
    }
    for (int v = 0; v < s.nvars; v++)
        for (int k = 0; k < 2; k++)
            if ((s.nvars == 3 || v == k) && s.degree[v] > one.degree[k]) one.degree[k] = s.degree[v];
    if (s.nvars > 0) {
        one.spans = 1, one.control_points = kn_spline_count(&s);
        for (int v = 0; v < s.nvars; v++) one.spans *= (size_t)kn_spline_spans(&s, v);
    }
    add_sums(sum, &one);
}

// ---- begin ----

static kn_job_report report_of(limit *l, const kn_job_report *report)
{
    kn_job_report r = *report;
    int most = l->limits.max_degree;
    if (r.degree[0] <= most && r.degree[1] <= most) return r;
    r.fit_degree = most;
    r.fit_tolerance = l->limits.tolerance;
    r.exact_patches = 0;
    for (int v = 0; v < 2; v++) r.degree[v] = r.degree[v] < most ? r.degree[v] : most;
    l->volumes = r.volumes > 0;
    if (l->volumes) r.patches *= FACES;
    return r;
}

static kn_status limit_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    limit *l = user;
    kn_job_report r = report_of(l, report);
    kn_status status = KN_OK;
    for (int k = 0; k < l->nsinks && status == KN_OK; k++)
        if (l->sinks[k].begin) status = l->sinks[k].begin(ctx, l->sinks[k].user, tile, &r);
    return status;
}

// ---- blocks ----

static bool is_within(const limit *l, const kn_patch *patch)
{
    const kn_spline s = kn_patch_spline(patch);
    for (int v = 0; v < s.nvars; v++)
        if (s.degree[v] > l->limits.max_degree) return false;
    return true;
}

static kn_status name_patch(kn_ctx *ctx, kn_status status, const kn_patch *patch)
{
    char message[160];
    if (status != KN_EUNDECIDED && status != KN_EUNDEFINED) return status;
    strncpy(message, kn_ctx_message(ctx), sizeof message - 1);
    message[sizeof message - 1] = '\0';
    kn_ctx_clear_error(ctx);
    return kn_fail(ctx, status, "surface %d, cell %d,%d, patch %d: %s", patch->id.surface, patch->id.cell[0],
                   patch->id.cell[1], patch->id.patch, message);
}

// *piece: the patch in one piece, to be cleared when *own.
static kn_status one_piece(kn_ctx *ctx, kn_bezier *piece, bool *own, const kn_patch *patch)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    *piece = patch->bezier;
    *own = false;
    if (!patch->spline) return KN_OK;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, patch->spline);
    if (status != KN_OK) return status;
    if (n == 1) *piece = pieces[0], *own = true;
    for (size_t i = *own; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    if (*own) return KN_OK;
    return kn_fail(ctx, KN_EDOMAIN, "limits: a spline of %zu pieces and of degrees that need a limit: split it", n);
}

// patch: the next one of out, already a copy of what came.
static kn_status limit_patch(kn_ctx *ctx, const limit *l, limited *out, kn_patch *patch)
{
    kn_spline *s = out->splines + out->nsplines;
    kn_fit_limited report;
    kn_bezier piece;
    bool own;
    out->nsplines += OF_PATCH;
    kn_status status = one_piece(ctx, &piece, &own, patch);
    if (status == KN_OK) status = kn_fit_limit_degree(ctx, &s[0], &s[1], &report, &piece, &l->limits);
    if (own) kn_bezier_clear(ctx, &piece);
    if (status != KN_OK) return name_patch(ctx, status, patch);
    patch->bezier = (kn_bezier){0};
    patch->spline = &s[0];
    patch->edge = s[0].nvars == 2 ? &s[1] : NULL;
    patch->exact = false;
    note_patch(&out->sum, patch, &report);
    return KN_OK;
}

static kn_status add_patch(kn_ctx *ctx, const limit *l, limited *out, const kn_patch *patch)
{
    kn_patch *to = &out->patches[out->block.count++];
    *to = *patch;
    if (!is_within(l, patch)) return limit_patch(ctx, l, out, to);
    note_patch(&out->sum, to, NULL);
    return KN_OK;
}

static kn_status add_faces(kn_ctx *ctx, const limit *l, limited *out, const kn_patch *volume)
{
    kn_status status = KN_OK;
    for (int k = 0; k < FACES && status == KN_OK; k++) {
        kn_patch face = {0};
        if (volume->hidden >> k & 1) continue;
        status = kn_patch_face(ctx, &face, volume, k);
        if (status != KN_OK) return status;
        out->faces[out->nfaces++] = face.bezier;
        status = add_patch(ctx, l, out, &face);
    }
    return status;
}

static void limit_discard(kn_ctx *ctx, void *user, void *product);

static kn_status begin_product(kn_ctx *ctx, const limit *l, limited *out, const kn_patch_block *block)
{
    size_t patches = 0, limits = 0, faces = 0;
    for (size_t i = 0; i < block->count; i++) {
        const kn_patch *p = &block->patches[i];
        bool within = is_within(l, p);
        size_t n = !within && kn_patch_nvars(p) == 3 ? FACES : 1;
        patches += n;
        if (!within) limits += n, faces += n > 1 ? n : 0;
    }
    out->patches = kn_alloc_zero(ctx, patches + 1, sizeof *out->patches);
    out->splines = kn_alloc_zero(ctx, limits * OF_PATCH + 1, sizeof *out->splines);
    out->faces = kn_alloc_zero(ctx, faces + 1, sizeof *out->faces);
    out->of_sink = kn_alloc_zero(ctx, (size_t)l->nsinks, sizeof *out->of_sink);
    out->block.patches = out->patches;
    out->block.first = l->volumes ? FACES * block->first : block->first;
    return out->patches && out->splines && out->faces && out->of_sink ? KN_OK : KN_ENOMEM;
}

static kn_status limit_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    const limit *l = user;
    limited *out = kn_alloc_zero(worker, 1, sizeof *out);
    if (!out) return KN_ENOMEM;
    kn_status status = begin_product(worker, l, out, block);
    for (size_t i = 0; i < block->count && status == KN_OK; i++) {
        const kn_patch *p = &block->patches[i];
        bool faces = kn_patch_nvars(p) == 3 && !is_within(l, p);
        status = faces ? add_faces(worker, l, out, p) : add_patch(worker, l, out, p);
    }
    for (; status == KN_OK && out->nworked < l->nsinks; out->nworked++) {
        const kn_sink *sink = &l->sinks[out->nworked];
        if (sink->work) status = sink->work(worker, sink->user, &out->block, &out->of_sink[out->nworked]);
    }
    if (status == KN_OK)
        *product = out;
    else
        limit_discard(worker, user, out);
    return status;
}

static void free_product(kn_ctx *ctx, const limit *l, limited *out, int first_sink)
{
    for (int k = first_sink; out->of_sink && k < out->nworked; k++)
        if (l->sinks[k].discard && out->of_sink[k]) l->sinks[k].discard(ctx, l->sinks[k].user, out->of_sink[k]);
    for (size_t i = 0; i < out->nsplines; i++) kn_spline_clear(ctx, &out->splines[i]);
    for (size_t i = 0; i < out->nfaces; i++) kn_bezier_clear(ctx, &out->faces[i]);
    kn_free(ctx, out->patches), kn_free(ctx, out->splines), kn_free(ctx, out->faces), kn_free(ctx, out->of_sink);
    kn_free(ctx, out);
}

static void limit_discard(kn_ctx *ctx, void *user, void *product)
{
    if (product) free_product(ctx, user, product, 0);
}

static kn_status limit_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    limit *l = user;
    limited *out = product;
    kn_status status = KN_OK;
    int k = 0;
    (void)block;
    for (; status == KN_OK && k < l->nsinks; k++)
        status = l->sinks[k].commit(ctx, l->sinks[k].user, &out->block, out->of_sink[k]);
    if (status == KN_OK) add_sums(&l->sum, &out->sum);
    if (l->told) *l->told = l->sum;
    free_product(ctx, l, out, k);
    return status;
}

// ---- end ----

static kn_status limit_end(kn_ctx *ctx, void *user)
{
    limit *l = user;
    kn_status status = KN_OK;
    if (l->told) *l->told = l->sum;
    for (int k = 0; k < l->nsinks && status == KN_OK; k++)
        if (l->sinks[k].end) status = l->sinks[k].end(ctx, l->sinks[k].user);
    return status;
}

static void limit_close(kn_ctx *ctx, void *user)
{
    limit *l = user;
    for (int k = 0; k < l->nsinks; k++) kn_sink_close(ctx, &l->sinks[k]);
    kn_free(ctx, l->sinks);
    kn_free(ctx, l);
}

static size_t limit_bytes(const void *user)
{
    const limit *l = user;
    size_t bytes = 0;
    for (int k = 0; k < l->nsinks; k++)
        if (l->sinks[k].bytes) bytes += l->sinks[k].bytes(l->sinks[k].user);
    return bytes;
}

// ---- journals ----

// What a run that goes on must ask for as it did.
typedef struct asked {
    double number[3];
} asked;
static asked asked_of(const limit *l)
{
    return (asked){{l->limits.max_degree, l->limits.tolerance, 2.0 * l->limits.angle}};
}

static kn_status limit_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    limit *l = user;
    kn_state state = {.ctx = ctx};
    kn_status status = KN_OK;
    const asked own = asked_of(l);
    kn_state_put(&state, &own, sizeof own);
    kn_state_put(&state, &l->sum, sizeof l->sum);
    for (int k = 0; k < l->nsinks && status == KN_OK; k++) {
        unsigned char *part = NULL;
        size_t n = 0;
        status = l->sinks[k].save(ctx, l->sinks[k].user, &part, &n);
        if (status == KN_OK) kn_state_put_block(&state, part, n);
        kn_free(ctx, part);
    }
    return kn_state_give(&state, data, bytes, status);
}

static kn_status limit_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                               const unsigned char *data, size_t bytes)
{
    limit *l = user;
    kn_state_reader r = {data, bytes};
    kn_job_report told = report_of(l, report);
    asked then = {{0.0}}, own = asked_of(l);
    kn_status status = kn_state_take(&r, &then, sizeof then) && kn_state_take(&r, &l->sum, sizeof l->sum)
                           ? KN_OK
                           : kn_state_fail(ctx, "limited degrees");
    if (status == KN_OK && memcmp(&then, &own, sizeof own) != 0)
        status = kn_fail(ctx, KN_EDOMAIN,
                         "limits: begun with degree %g, tolerance %g and seam angle %g, not %g, %g, %g",
                         then.number[0], then.number[1], then.number[2], own.number[0], own.number[1], own.number[2]);
    for (int k = 0; k < l->nsinks && status == KN_OK; k++) {
        size_t n = 0;
        const unsigned char *part = kn_state_take_block(&r, &n);
        status = part ? l->sinks[k].restore(ctx, l->sinks[k].user, tile, &told, part, n)
                      : kn_state_fail(ctx, "limited degrees");
    }
    if (status == KN_OK && r.bytes > 0) return kn_state_fail(ctx, "limited degrees");
    if (l->told) *l->told = l->sum;
    return status;
}

static void limit_forget(void *user)
{
    const limit *l = user;
    for (int k = 0; k < l->nsinks; k++)
        if (l->sinks[k].forget) l->sinks[k].forget(l->sinks[k].user);
}

// ---- life ----

static kn_status check(kn_ctx *ctx, const kn_sink *sinks, int n, const kn_limit_options *o)
{
    if (o->max_degree < 3 || o->max_degree > KN_MAX_DEGREE || !(o->tolerance > 0.0) || !isfinite(o->tolerance))
        return kn_fail(ctx, KN_EDOMAIN, "limits: degree %d (3 to %d), tolerance %g", o->max_degree, KN_MAX_DEGREE,
                       o->tolerance);
    if (!(o->seam_angle >= 0.0 && o->seam_angle <= MOST_ANGLE))
        return kn_fail(ctx, KN_EDOMAIN, "limits: seam angle %g (at most %g)", o->seam_angle, MOST_ANGLE);
    if (n < 1) return kn_fail(ctx, KN_EDOMAIN, "limits: %d sinks", n);
    for (int k = 0; k < n; k++)
        if (!sinks[k].commit) return kn_fail(ctx, KN_EDOMAIN, "limits: sink %d is closed, or has no commit", k);
    return KN_OK;
}

kn_status kn_limit_sink(kn_ctx *ctx, kn_sink *out, const kn_sink *sinks, int n, const kn_limit_options *options,
                        kn_limit_summary *summary)
{
    kn_status status = check(ctx, sinks, n, options);
    if (status != KN_OK) return status;
    limit *l = kn_alloc_zero(ctx, 1, sizeof *l);
    kn_sink *copies = kn_alloc(ctx, (size_t)n, sizeof *copies);
    if (!l || !copies) {
        kn_free(ctx, l), kn_free(ctx, copies);
        return KN_ENOMEM;
    }
    bool can_save = true;
    memcpy(copies, sinks, (size_t)n * sizeof *copies);
    for (int k = 0; k < n; k++) can_save = can_save && sinks[k].save && sinks[k].restore;
    *l = (limit){.sinks = copies, .nsinks = n, .told = summary};
    l->limits = (kn_fit_limits){.max_degree = options->max_degree, .tolerance = options->tolerance};
    l->limits.angle = 0.5 * (options->seam_angle > 0.0 ? options->seam_angle : USUAL_ANGLE);
    l->limits.quantum = fmax(exp2(floor(log2(options->tolerance / 1024.0))), 0x1p-1000);
    if (summary) *summary = l->sum;
    *out = (kn_sink){.user = l,
                     .begin = limit_begin,
                     .work = limit_work,
                     .commit = limit_commit,
                     .discard = limit_discard,
                     .end = limit_end,
                     .close = limit_close,
                     .bytes = limit_bytes,
                     .save = can_save ? limit_save : NULL,
                     .restore = can_save ? limit_restore : NULL,
                     .forget = limit_forget};
    return KN_OK;
}
