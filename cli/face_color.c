// SPDX-License-Identifier: Apache-2.0
// A tile to which nobody gave a colour has that of the face it lies on.
#include "cli/cli.h"
#include "kernel/context.h"

#include <string.h>

// Which of n colours each surface of a base has.
typedef struct cli_face_colors {
    double (*color)[3];
    int *of, n;
} cli_face_colors;

// The middle of its step, of n.
static double color_at(const void *user, const kn_place *place)
{
    const cli_face_colors *c = user;
    return (c->of[place->surface] + 0.5) / c->n;
}

static void find_colors(cli_face_colors *c, const cli_base *base, const double plain[3])
{
    for (int s = 0; s < base->nsurfaces; s++) {
        const kn_cad_face *face = &base->cad.faces[base->face[s]];
        const double *own = face->colored ? face->color : plain;
        int k = 0;
        while (k < c->n && memcmp(c->color[k], own, sizeof c->color[k]) != 0) k++;
        if (k == c->n) memcpy(c->color[c->n++], own, sizeof c->color[k]);
        c->of[s] = k;
    }
}

static bool any_color(const cli_base *base)
{
    for (int s = 0; s < base->nsurfaces; s++)
        if (base->cad.faces[base->face[s]].colored) return true;
    return false;
}

static const double *plain_color(const kn_tile *tile)
{
    for (int p = 0; p < tile->nparts; p++)
        if (tile->parts[p].plain) return tile->parts[p].material.base_color;
    return NULL;
}

static kn_status make_colors(kn_ctx *ctx, cli_face_colors **out, const cli_base *base, const double plain[3])
{
    cli_face_colors *c = kn_alloc_zero(ctx, 1, sizeof *c);
    if (!c) return KN_ENOMEM;
    c->color = kn_alloc_zero(ctx, (size_t)base->nsurfaces, sizeof *c->color);
    c->of = kn_alloc_zero(ctx, (size_t)base->nsurfaces, sizeof *c->of);
    *out = c;
    if (!c->color || !c->of) return KN_ENOMEM;
    find_colors(c, base, plain);
    return KN_OK;
}

kn_status cli_take_face_colors(kn_ctx *ctx, cli_job *job, kn_tile *tile, const cli_base *base)
{
    enum { MOST = 256 }; // steps of a rule
    const double *plain = plain_color(tile);
    if (!plain || base->cad.nfaces == 0 || job->on > 0 || job->color.nrules > 0 || !any_color(base)) return KN_OK;
    kn_status status = make_colors(ctx, &job->face_colors, base, plain);
    const cli_face_colors *c = job->face_colors;
    if (status != KN_OK || c->n > MOST) return status;
    int rules = 0;
    for (int p = 0; p < tile->nparts && rules < CLI_MAX_COLORED; p++) {
        kn_tile_part *part = &tile->parts[p];
        if (!part->plain) continue;
        if (c->n == 1)
            memcpy(part->material.base_color, c->color[0], sizeof c->color[0]);
        else
            job->color.rule[rules++] = (kn_job_color){.part = part->name,
                                                      .field = {.value = color_at, .user = c},
                                                      .palette = (const double(*)[3])c->color,
                                                      .npalette = c->n,
                                                      .steps = c->n};
    }
    job->options.color = rules > 0 ? job->color.rule : NULL;
    job->options.ncolor = rules;
    return KN_OK;
}

void cli_face_colors_free(kn_ctx *ctx, cli_face_colors *colors)
{
    if (!colors) return;
    kn_free(ctx, colors->color);
    kn_free(ctx, colors->of);
    kn_free(ctx, colors);
}
