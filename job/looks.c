// SPDX-License-Identifier: Apache-2.0
// Colours by fields: a part that has one is several for the sinks, a look for each step of its palette.
#include "job/looks.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { DEFAULT_STEPS = 16, MAX_STEPS = 256 };

static kn_status check_color(kn_ctx *ctx, const kn_job_color *c)
{
    if (!c->field.value) return kn_fail(ctx, KN_EDOMAIN, "job: a colour by no field");
    if (c->steps < 0 || c->npalette < 1 || !c->palette)
        return kn_fail(ctx, KN_EDOMAIN, "job: %d steps of a palette of %d colours", c->steps, c->npalette);
    if (c->steps > MAX_STEPS)
        return kn_fail(ctx, KN_ELIMIT, "job: %d steps of colour, at most %d", c->steps, MAX_STEPS);
    for (int i = 0; i < 3 * c->npalette; i++) {
        double x = c->palette[i / 3][i % 3];
        if (!(x >= 0.0 && x <= 1.0))
            return kn_fail(ctx, KN_EDOMAIN, "job: colour %d of a palette has the component %g", i / 3, x);
    }
    return KN_OK;
}

// The last rule that is for the part; -1: none.
static int rule_of(const kn_job *job, const char *part)
{
    int rule = -1;
    for (int k = 0; k < job->options.ncolor; k++) {
        const kn_job_color *c = &job->options.color[k];
        if (!c->part || strcmp(c->part, part) == 0) rule = k;
    }
    return rule;
}

static kn_status check_parts(kn_ctx *ctx, const kn_job *job)
{
    for (int k = 0; k < job->options.ncolor; k++) {
        const char *name = job->options.color[k].part;
        bool found = !name;
        for (int p = 0; !found && p < job->tile.nparts; p++) found = strcmp(job->tile.parts[p].name, name) == 0;
        if (!found)
            return kn_fail(ctx, KN_EDOMAIN, "job: no part \"%s\" to colour in the tile %s (%s ..)", name,
                           job->tile.name, job->tile.parts[0].name);
    }
    return KN_OK;
}

static int steps_of(const kn_job_color *c)
{
    return c->steps > 0 ? c->steps : DEFAULT_STEPS;
}

// Step k of n has the palette's colour at k / (n - 1) of its length, linear between its colours; one step the middle.
static void color_of_step(double out[3], const kn_job_color *c, int k)
{
    int n = steps_of(c);
    double at = (n > 1 ? (double)k / (n - 1) : 0.5) * (c->npalette - 1);
    int i = (int)fmin(floor(at), fmax(c->npalette - 2, 0.0)), next = c->npalette > 1 ? i + 1 : i;
    for (int d = 0; d < 3; d++) {
        double a = c->palette[i][d], b = c->palette[next][d];
        out[d] = at - i == 1.0 ? b : a + (at - i) * (b - a);
    }
}

// Appends the looks of one part, which borrow its splines and mesh.
static void add_looks(kn_tile *looks, const kn_tile_part *part, const kn_job_color *color)
{
    int steps = color ? steps_of(color) : 1;
    for (int k = 0; k < steps; k++) {
        kn_tile_part *to = &looks->parts[looks->nparts++];
        *to = *part;
        to->targets = NULL;
        to->mesh_targets = NULL;
        if (!color) continue;
        (void)snprintf(to->name, sizeof to->name, "%.*s.%0*d", KN_NAME_BYTES - 16, part->name, steps > 100 ? 3 : 2,
                       k);
        color_of_step(to->material.base_color, color, k);
    }
}

static kn_status make_looks(kn_ctx *ctx, kn_job_looks *l, const kn_job *job)
{
    const kn_job_options *o = &job->options;
    size_t nparts = (size_t)job->tile.nparts, count = 0;
    l->field = kn_alloc(ctx, (size_t)o->ncolor, sizeof *l->field);
    l->steps = kn_alloc(ctx, (size_t)o->ncolor, sizeof *l->steps);
    l->rule = kn_alloc(ctx, nparts, sizeof *l->rule);
    l->first = kn_alloc(ctx, nparts, sizeof *l->first);
    if (!l->field || !l->steps || !l->rule || !l->first) return KN_ENOMEM;
    l->nrules = o->ncolor;
    for (int k = 0; k < o->ncolor; k++) {
        l->field[k] = o->color[k].field;
        l->steps[k] = steps_of(&o->color[k]);
        l->needs |= l->field[k].needs;
    }
    for (size_t p = 0; p < nparts; p++) {
        l->rule[p] = rule_of(job, job->tile.parts[p].name);
        l->first[p] = (int)count;
        count += l->rule[p] < 0 ? 1 : (size_t)l->steps[l->rule[p]];
    }
    l->tile = job->tile;
    l->tile.parameters = NULL;
    l->tile.nparameters = l->tile.nparts = 0;
    l->tile.parts = kn_alloc(ctx, count, sizeof *l->tile.parts);
    if (!l->tile.parts) return KN_ENOMEM;
    for (size_t p = 0; p < nparts; p++)
        add_looks(&l->tile, &job->tile.parts[p], l->rule[p] < 0 ? NULL : &o->color[l->rule[p]]);
    return KN_OK;
}

kn_status kn_job_looks_init(kn_ctx *ctx, kn_job *job)
{
    const kn_job_options *o = &job->options;
    if (o->ncolor < 0 || (o->ncolor > 0 && !o->color))
        return kn_fail(ctx, KN_EDOMAIN, "job: %d colours by fields", o->ncolor);
    if (o->ncolor == 0) return KN_OK;
    kn_status status = check_parts(ctx, job);
    for (int k = 0; status == KN_OK && k < o->ncolor; k++) status = check_color(ctx, &o->color[k]);
    if (status != KN_OK) return status;
    job->looks = kn_alloc_zero(ctx, 1, sizeof *job->looks);
    if (!job->looks) return KN_ENOMEM;
    status = make_looks(ctx, job->looks, job);
    job->options.color = NULL; // the caller's
    return status;
}

void kn_job_looks_clear(kn_ctx *ctx, kn_job *job)
{
    kn_job_looks *l = job->looks;
    if (!l) return;
    kn_free(ctx, l->field);
    kn_free(ctx, l->steps);
    kn_free(ctx, l->rule);
    kn_free(ctx, l->first);
    kn_free(ctx, l->tile.parts);
    kn_free(ctx, l);
    job->looks = NULL;
}

const kn_tile *kn_job_look_tile(const kn_job *job)
{
    return job->looks ? &job->looks->tile : &job->tile;
}

// Step k of n: k / n <= value < (k + 1) / n.
kn_status kn_job_find_steps(kn_ctx *ctx, int *step, const kn_job *job, int surface, const int cell[2])
{
    const kn_job_looks *l = job->looks;
    if (!l) return KN_OK;
    const kn_job_spot spot = {surface, {cell[0] + 0.5, cell[1] + 0.5}};
    kn_place place;
    kn_status status = kn_job_fill_spot(ctx, &place, job, &spot, l->needs);
    for (int k = 0; status == KN_OK && k < l->nrules; k++) {
        double value = l->field[k].value(l->field[k].user, &place);
        if (isnan(value))
            return kn_fail(ctx, KN_EDOMAIN, "job: the colour is no number at %g, %g of surface %d", place.uv[0],
                           place.uv[1], place.surface);
        step[k] = (int)fmin(floor(fmin(fmax(value, 0.0), 1.0) * l->steps[k]), l->steps[k] - 1);
    }
    return status;
}

int kn_job_look_of(const kn_job *job, int part, const int *step)
{
    const kn_job_looks *l = job->looks;
    if (!l) return part;
    return l->first[part] + (l->rule[part] < 0 ? 0 : step[l->rule[part]]);
}
