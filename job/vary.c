// SPDX-License-Identifier: Apache-2.0
// Tiles that vary over the base: parameters, heights and offsets by fields, and the taper.
//
// A control point P of the tile at the place (u, v) becomes
//     P + sum over parameters of b(x_k(place)) (target_k - P),   b(x) = (x - value) / (target - value),
// and its height w then offset + taper(place) f(place) (w - offset) + o(place). What tiles have in common they have
// at one place with one P and one set of targets, and so they still have it afterwards.
#include "job/vary.h"
#include "job/internal.h"
#include "tile/blend.h"

#include <math.h>
#include <string.h>

// ---- rules ----

static kn_status make_rule(kn_ctx *ctx, kn_job_rule *out, const kn_tile *tile, const kn_job_vary *vary)
{
    const char *name = vary->parameter ? vary->parameter : "";
    out->effect = strcmp(name, "height") == 0   ? KN_EFFECT_HEIGHT
                  : strcmp(name, "offset") == 0 ? KN_EFFECT_OFFSET
                                                : KN_EFFECT_PARAMETER;
    out->parameter = -1;
    out->field = vary->field;
    for (int k = 0; k < tile->nparameters; k++) // a tile's own parameter of such a name comes first
        if (strcmp(tile->parameters[k].name, name) == 0) out->effect = KN_EFFECT_PARAMETER, out->parameter = k;
    if (out->effect == KN_EFFECT_PARAMETER && out->parameter < 0)
        return kn_fail(ctx, KN_EDOMAIN, "job: tile \"%s\" has no parameter \"%s\" to vary", tile->name, name);
    if (!vary->field.value) return kn_fail(ctx, KN_EDOMAIN, "job: no field for parameter \"%s\"", name);
    return KN_OK;
}

static kn_status make_rules(kn_ctx *ctx, kn_job_varying *out, const kn_job *job)
{
    const kn_job_options *o = &job->options;
    out->rules = kn_alloc_zero(ctx, (size_t)o->nvary, sizeof *out->rules);
    kn_status status = out->rules ? KN_OK : KN_ENOMEM;
    for (int k = 0; status == KN_OK && k < o->nvary; k++) {
        kn_job_rule *rule = &out->rules[k];
        status = make_rule(ctx, rule, &job->tile, &o->vary[k]);
        for (int i = 0; status == KN_OK && i < k; i++)
            if (out->rules[i].effect == rule->effect && out->rules[i].parameter == rule->parameter)
                status = kn_fail(ctx, KN_EDOMAIN, "job: \"%s\" is varied twice", o->vary[k].parameter);
        out->needs |= rule->field.needs;
        out->nrules++;
    }
    return status;
}

// ---- moves ----

static double height_of_one(const kn_job_options *o)
{
    return o->height * (o->side == KN_JOB_BOTH ? 2.0 : 1.0);
}

// moves[patch * nrules] of the Bezier patches of one spline.
static kn_status make_moves(kn_ctx *ctx, kn_bezier *moves, const kn_job *job, int nrules, const kn_spline *spline,
                            const kn_spline *target)
{
    kn_bezier *from = NULL, *to = NULL;
    size_t nfrom = 0, nto = 0;
    kn_status status = kn_spline_to_bezier(ctx, &from, &nfrom, spline);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &to, &nto, target);
    for (size_t i = 0; status == KN_OK && i < nfrom && i < nto; i++) {
        size_t n = kn_bezier_count(&from[i]);
        for (size_t k = 0; k < 3 * n; k++) to[i].coef[k] -= from[i].coef[k];
        for (size_t k = 2 * n; k < 3 * n; k++) to[i].coef[k] *= height_of_one(&job->options);
        kn_bezier_swap(&moves[i * (size_t)nrules], &to[i]);
    }
    for (size_t i = 0; i < nfrom; i++) kn_bezier_clear(ctx, &from[i]);
    for (size_t i = 0; i < nto; i++) kn_bezier_clear(ctx, &to[i]);
    kn_free(ctx, from);
    kn_free(ctx, to);
    return status;
}

static kn_status make_all_moves(kn_ctx *ctx, kn_job_varying *out, const kn_job *job)
{
    const kn_tile *tile = &job->tile;
    int total = 0;
    out->first = kn_alloc(ctx, (size_t)tile->nparts, sizeof *out->first);
    if (!out->first) return KN_ENOMEM;
    for (int p = 0; p < tile->nparts; p++) {
        out->first[p] = total;
        for (int s = 0; s < tile->parts[p].nsplines; s++) total += kn_job_bezier_patches(&tile->parts[p].splines[s]);
    }
    size_t n = (size_t)total * (size_t)out->nrules;
    out->moves = kn_alloc_zero(ctx, n, sizeof *out->moves);
    kn_status status = out->moves ? KN_OK : KN_ENOMEM;
    out->nmoves = status == KN_OK ? n : 0;
    for (int p = 0; p < tile->nparts; p++) {
        const kn_tile_part *part = &tile->parts[p];
        size_t patch = (size_t)out->first[p];
        for (int s = 0; status == KN_OK && s < part->nsplines; s++) {
            for (int r = 0; status == KN_OK && r < out->nrules && part->targets; r++) {
                if (out->rules[r].effect != KN_EFFECT_PARAMETER) continue;
                const kn_spline *target = &part->targets[out->rules[r].parameter * part->nsplines + s];
                kn_bezier *to = out->moves + patch * (size_t)out->nrules + r;
                if (target->coef) status = make_moves(ctx, to, job, out->nrules, &part->splines[s], target);
            }
            patch += (size_t)kn_job_bezier_patches(&part->splines[s]);
        }
    }
    return status;
}

static void varying_destroy(kn_ctx *ctx, kn_job_varying *v)
{
    if (!v) return;
    for (size_t i = 0; i < v->nmoves; i++) kn_bezier_clear(ctx, &v->moves[i]);
    kn_job_taper_clear(ctx, &v->taper);
    kn_free(ctx, v->moves);
    kn_free(ctx, v->first);
    kn_free(ctx, v->rules);
    kn_free(ctx, v);
}

void kn_job_vary_clear(kn_ctx *ctx, kn_job *job)
{
    varying_destroy(ctx, job->varying);
    job->varying = NULL;
}

kn_status kn_job_vary_init(kn_ctx *ctx, kn_job *job)
{
    const kn_job_options *o = &job->options;
    if (!(o->taper >= 0.0) || isinf(o->taper) || o->nvary < 0)
        return kn_fail(ctx, KN_EDOMAIN, "job: taper over %g, %d varied parameters", o->taper, o->nvary);
    kn_status status = kn_job_check_chance(ctx, job);
    if (status != KN_OK || (o->nvary == 0 && o->taper == 0.0)) return status;
    kn_job_varying *v = job->varying = kn_alloc_zero(ctx, 1, sizeof *v);
    if (!v) return KN_ENOMEM;
    status = make_rules(ctx, v, job);
    if (status == KN_OK) status = make_all_moves(ctx, v, job);
    if (status == KN_OK && o->taper > 0.0) status = kn_job_make_taper(ctx, &v->taper, job);
    return status; // what is there belongs to the job
}

kn_status kn_job_vary_instance(kn_ctx *ctx, kn_job_instance *instance, const kn_job *job, int surface,
                               const int cell[2])
{
    (void)ctx;
    if (kn_job_has_chance(job)) kn_job_change_by_chance(instance, job, surface, cell);
    if (job->varying) instance->plain = false; // its map is there for plain ones too
    return KN_OK;
}

// ---- points ----

// What the rules give at one place.
typedef struct amounts {
    double *blend; // of each rule: of its target, 0 where it is no parameter
    double factor, offset;
} amounts;

// At the place where the instance puts the point p of the unvaried tile.
static kn_status find_amounts(kn_ctx *ctx, amounts *out, const kn_job *job, int surface, const int cell[2],
                              const kn_job_instance *instance, const double p[3])
{
    const kn_job_varying *v = job->varying;
    double uv[2];
    for (int d = 0; d < 2; d++) {
        const double *m = instance->map[d];
        uv[d] = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
    }
    kn_job_spot spot = kn_job_find_spot(job, surface, cell, uv);
    kn_place place;
    kn_status status = kn_job_fill_spot(ctx, &place, job, &spot, v->needs);
    out->factor = job->options.taper > 0.0 ? kn_job_taper_at(job, &spot) : 1.0;
    out->offset = 0.0;
    for (int k = 0; status == KN_OK && k < v->nrules; k++) {
        const kn_job_rule *rule = &v->rules[k];
        double x = rule->field.value(rule->field.user, &place);
        if (!isfinite(x))
            return kn_fail(ctx, KN_EDOMAIN, "job: the field for \"%s\" is %g at u %g, v %g of surface %d",
                           job->options.vary[k].parameter, x, place.uv[0], place.uv[1], place.surface);
        out->blend[k] = 0.0;
        if (rule->effect == KN_EFFECT_HEIGHT)
            out->factor *= x;
        else if (rule->effect == KN_EFFECT_OFFSET)
            out->offset = x;
        else
            out->blend[k] = kn_tile_blend(&job->tile.parameters[rule->parameter], x);
    }
    return status;
}

static double changed_height(const kn_job_options *o, const amounts *a, double w)
{
    return a->factor == 1.0 ? w + a->offset : o->offset + a->factor * (w - o->offset) + a->offset;
}

kn_status kn_job_vary_patch(kn_ctx *ctx, kn_bezier *d, const kn_job *job, int surface, const int cell[2],
                            const kn_job_instance *instance, int part, int spline, int patch)
{
    const kn_job_varying *v = job->varying;
    (void)spline; // patches are counted over all splines of the part
    if (!v) return KN_OK;
    size_t n = kn_bezier_count(d);
    const kn_bezier *moves = v->moves + (size_t)(v->first[part] + patch) * (size_t)v->nrules;
    kn_mark mark = kn_scratch_mark(ctx);
    double *to = kn_scratch(ctx, 3 * n, sizeof *to);
    amounts a = {.blend = kn_scratch(ctx, (size_t)v->nrules, sizeof *a.blend)};
    kn_status status = to && a.blend ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        const double p[3] = {d->coef[i], d->coef[n + i], d->coef[2 * n + i]};
        status = find_amounts(ctx, &a, job, surface, cell, instance, p);
        for (size_t c = 0; status == KN_OK && c < 3; c++) {
            double x = d->coef[c * n + i];
            for (int k = 0; k < v->nrules; k++)
                if (moves[k].coef) x += a.blend[k] * moves[k].coef[c * n + i];
            to[c * n + i] = c < 2 ? x : changed_height(&job->options, &a, x);
        }
    }
    if (status == KN_OK) memcpy(d->coef, to, 3 * n * sizeof *to);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_job_vary_mesh(kn_ctx *ctx, double *position, const kn_job *job, int surface, const int cell[2],
                           const kn_job_instance *instance, int part)
{
    const kn_job_varying *v = job->varying;
    const kn_tile_part *from = &job->tile.parts[part];
    if (!v) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    amounts a = {.blend = kn_scratch(ctx, (size_t)v->nrules, sizeof *a.blend)};
    double *to = kn_scratch(ctx, 3 * from->mesh.nvertices, sizeof *to);
    kn_status status = a.blend && to ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < from->mesh.nvertices; i++) {
        const double *rest = from->mesh.position + 3 * i;
        status = find_amounts(ctx, &a, job, surface, cell, instance, position + 3 * i);
        for (size_t c = 0; status == KN_OK && c < 3; c++) {
            double x = position[3 * i + c], scale = c < 2 ? 1.0 : height_of_one(&job->options);
            for (int k = 0; k < v->nrules && from->mesh_targets; k++) {
                const double *target = v->rules[k].effect == KN_EFFECT_PARAMETER
                                           ? from->mesh_targets[v->rules[k].parameter]
                                           : NULL;
                if (target) x += a.blend[k] * scale * (target[3 * i + c] - rest[c]);
            }
            to[3 * i + c] = c < 2 ? x : changed_height(&job->options, &a, x);
        }
    }
    if (status == KN_OK) memcpy(position, to, 3 * from->mesh.nvertices * sizeof *to);
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- how control points move with a parameter ----

// The Bezier patch numbered `patch` of a spline; out: initialised, overwritten.
static kn_status take_patch(kn_ctx *ctx, kn_bezier *out, const kn_spline *spline, int patch)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, spline);
    for (size_t i = 0; i < n; i++) {
        if (status == KN_OK && i == (size_t)patch) kn_bezier_swap(out, &pieces[i]);
        kn_bezier_clear(ctx, &pieces[i]);
    }
    kn_free(ctx, pieces);
    return status;
}

kn_status kn_job_vary_slope(kn_ctx *ctx, kn_bezier *out, const kn_job *job, int surface, const int cell[2],
                            const kn_job_instance *instance, int part, int spline, int patch, int parameter)
{
    const kn_tile_part *from = &job->tile.parts[part];
    const kn_tile_parameter *p = &job->tile.parameters[parameter];
    const kn_spline *target = from->targets ? &from->targets[parameter * from->nsplines + spline] : NULL;
    const kn_job_options *o = &job->options;
    kn_bezier rest = {0}, move = {0};
    amounts a = {.factor = 1.0};
    for (int s = 0; s < spline; s++) patch -= kn_job_bezier_patches(&from->splines[s]);
    kn_status status = take_patch(ctx, &rest, &from->splines[spline], patch);
    if (status == KN_OK)
        status = target && target->coef ? take_patch(ctx, &move, target, patch) : kn_bezier_copy(ctx, &move, &rest);
    kn_mark mark = kn_scratch_mark(ctx);
    if (status == KN_OK && job->varying) {
        a.blend = kn_scratch(ctx, (size_t)job->varying->nrules, sizeof *a.blend);
        if (!a.blend) status = KN_ENOMEM;
    }
    size_t n = status == KN_OK ? kn_bezier_count(&rest) : 0;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        double w = rest.coef[2 * n + i];
        const double at[3] = {rest.coef[i], rest.coef[n + i],
                              o->offset + o->height * (o->side == KN_JOB_BOTH ? 2.0 * w - 1.0 : w)};
        if (job->varying) status = find_amounts(ctx, &a, job, surface, cell, instance, at);
        for (size_t c = 0; c < 3; c++) {
            double scale = c < 2 ? 1.0 : a.factor * height_of_one(o);
            move.coef[c * n + i] = scale * (move.coef[c * n + i] - rest.coef[c * n + i]) / (p->target - p->value);
        }
    }
    kn_scratch_release(ctx, mark);
    if (status == KN_OK) kn_bezier_swap(out, &move);
    kn_bezier_clear(ctx, &rest);
    kn_bezier_clear(ctx, &move);
    return status;
}
