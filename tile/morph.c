// SPDX-License-Identifier: Apache-2.0
// kn_tile_morph: a tile that turns into another one.
#include "tile/internal.h"

#include <stdio.h>

static const char *const kinds[] = {"nothing", "curve", "surface", "volume"};

static const char *kind_of(const kn_spline *s)
{
    return kinds[s->nvars >= 1 && s->nvars <= 3 ? s->nvars : 0];
}

static bool is_trimmed(const kn_tile_part *p, int spline)
{
    return p->trims && p->trims[spline].ncurves > 0;
}

// What differs between two parts, if anything does.
static kn_status compare_parts(kn_ctx *ctx, const kn_tile_part *a, const kn_tile_part *b)
{
    if (a->nsplines != b->nsplines)
        return kn_fail(ctx, KN_EDOMAIN, "morph: part \"%s\" has %d splines, and part \"%s\" has %d", a->name,
                       a->nsplines, b->name, b->nsplines);
    for (int i = 0; i < a->nsplines; i++) {
        if (a->splines[i].nvars != b->splines[i].nvars)
            return kn_fail(ctx, KN_EDOMAIN, "morph: spline %d of part \"%s\" is a %s, and of part \"%s\" a %s", i,
                           a->name, kind_of(&a->splines[i]), b->name, kind_of(&b->splines[i]));
        if (is_trimmed(a, i) || is_trimmed(b, i))
            return kn_fail(ctx, KN_EDOMAIN, "morph: surface %d of part \"%s\" is trimmed", i,
                           is_trimmed(a, i) ? a->name : b->name);
    }
    if ((a->mesh.ntriangles > 0) != (b->mesh.ntriangles > 0))
        return kn_fail(ctx, KN_EDOMAIN, "morph: part \"%s\" has a mesh, and part \"%s\" has none",
                       a->mesh.ntriangles > 0 ? a->name : b->name, a->mesh.ntriangles > 0 ? b->name : a->name);
    return KN_OK;
}

static kn_status compare_tiles(kn_ctx *ctx, const kn_tile *a, const kn_tile *b)
{
    kn_status status = kn_tile_check(ctx, a);
    if (status == KN_OK) status = kn_tile_check(ctx, b);
    if (status == KN_OK && a->nparts != b->nparts)
        status = kn_fail(ctx, KN_EDOMAIN, "morph: tile \"%s\" has %d parts, and tile \"%s\" has %d", a->name,
                         a->nparts, b->name, b->nparts);
    for (int p = 0; status == KN_OK && p < a->nparts; p++) status = compare_parts(ctx, &a->parts[p], &b->parts[p]);
    return status;
}

// Both over [0,1] in each variable, of the same degrees and knots.
static kn_status make_pair(kn_ctx *ctx, kn_spline pair[2], const kn_spline *a, const kn_spline *b)
{
    kn_status status = kn_spline_copy(ctx, &pair[0], a);
    if (status == KN_OK) status = kn_spline_copy(ctx, &pair[1], b);
    for (int k = 0; k < 2; k++)
        for (int v = 0; status == KN_OK && v < pair[k].nvars; v++)
            status = kn_spline_reparameterize(ctx, &pair[k], &pair[k], v, 0.0, 1.0);
    return status == KN_OK ? kn_spline_make_compatible(ctx, pair, 2) : status;
}

static kn_status morph_splines(kn_ctx *ctx, kn_tile *out, int part, const kn_tile *a, const kn_tile *b)
{
    const kn_tile_part *from = &a->parts[part], *to = &b->parts[part];
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < from->nsplines; i++) {
        kn_spline pair[2] = {{0}, {0}};
        status = make_pair(ctx, pair, &from->splines[i], &to->splines[i]);
        if (status == KN_OK) status = kn_tile_add(ctx, out, part, &pair[0]);
        if (status == KN_OK) status = kn_tile_set_target(ctx, out, 0, part, i, &pair[1]);
        kn_spline_clear(ctx, &pair[0]);
        kn_spline_clear(ctx, &pair[1]);
    }
    return status;
}

static kn_status morph_meshes(kn_ctx *ctx, kn_tile *out, int part, const kn_tile *a, const kn_tile *b)
{
    const kn_mesh *from = &a->parts[part].mesh, *to = &b->parts[part].mesh;
    if (from->ntriangles == 0) return KN_OK;
    kn_mesh mesh = {0};
    double *target = NULL;
    kn_status status = kn_mesh_morph(ctx, &mesh, &target, from, to);
    if (status == KN_OK) status = kn_tile_set_mesh(ctx, out, part, &mesh);
    if (status == KN_OK) status = kn_tile_set_mesh_target(ctx, out, 0, part, target);
    kn_mesh_clear(ctx, &mesh);
    kn_free(ctx, target);
    return status;
}

kn_status kn_tile_morph(kn_ctx *ctx, kn_tile *out, const kn_tile *a, const kn_tile *b)
{
    kn_status status = compare_tiles(ctx, a, b);
    if (status != KN_OK) return status;
    kn_tile made = {0};
    char name[KN_NAME_BYTES];
    (void)snprintf(name, sizeof name, "%.28s to %.28s", a->name, b->name);
    status = kn_tile_init(ctx, &made, name, a->nparts);
    if (status != KN_OK) return status;
    made.covering = a->covering && b->covering;
    made.aspect = a->aspect;
    status = kn_tile_add_parameter(ctx, &made, "morph", 0.0, 1.0, 0.0, 1.0);
    for (int p = 0; status == KN_OK && p < a->nparts; p++) {
        (void)snprintf(made.parts[p].name, sizeof made.parts[p].name, "%s", a->parts[p].name);
        made.parts[p].material = a->parts[p].material;
        made.parts[p].plain = a->parts[p].plain;
        status = morph_splines(ctx, &made, p, a, b);
        if (status == KN_OK) status = morph_meshes(ctx, &made, p, a, b);
    }
    if (status == KN_OK)
        *out = made;
    else
        kn_tile_clear(ctx, &made);
    return status;
}
