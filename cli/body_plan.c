// SPDX-License-Identifier: Apache-2.0
// Where a texture's border meets the edges of a body whose faces it replaces.
#include "cli/body.h"
#include "kernel/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Of parameters in [0,1]: ends of edges that are equal up to what trims are known to.
static const double same = 1e-6;

// ---- sides ----

// Where curve k of a face lies: a side of its square, from a to b along it. false: along none.
static bool side_of(const kn_cad_face *face, int k, int *side, double range[2])
{
    const kn_spline *c = &face->trim.curves[k];
    int n = c->count[0];
    for (int v = 0; v < 2; v++) {
        const double *x = c->coef + v * n, *y = c->coef + (1 - v) * n;
        bool on = x[0] == 0.0 || x[0] == 1.0;
        for (int i = 1; i < n && on; i++) on = x[i] == x[0];
        if (!on) continue;
        *side = 2 * v + (x[0] == 1.0);
        range[0] = fmin(y[0], y[n - 1]), range[1] = fmax(y[0], y[n - 1]);
        return true;
    }
    return false;
}

// The border's edges within a range of a side.
static size_t find_edges(const cli_border *b, int surface, int side, const double range[2],
                         const cli_border_edge **first)
{
    size_t n = 0;
    for (size_t i = 0; i < b->count; i++) {
        const cli_border_edge *e = &b->edges[i];
        if (e->surface != surface || e->side != side) continue;
        if (e->from < range[0] - same || e->to > range[1] + same) continue;
        if (n++ == 0) *first = e;
    }
    return n;
}

static bool is_replaced(const cli_body_plan *plan, int face)
{
    for (int i = 0; i < plan->nreplaced; i++)
        if (plan->replaced[i] == face) return true;
    return false;
}

static const char *side_name(int side)
{
    static const char *const names[] = {"u = 0", "u = 1", "v = 0", "v = 1"};
    return names[side];
}

// ---- sides beyond which a face stays ----

// The edges are there one after the other and on the base, or plan->why says what is missing.
static bool is_chain(cli_body_plan *plan, int face, int side, const double range[2], const cli_border_edge *e,
                     size_t n)
{
    double at = range[0];
    bool whole = n > 0;
    for (size_t i = 0; i < n && whole; i++) {
        whole = fabs(e[i].from - at) <= (i == 0 ? same : 1e-9);
        at = e[i].to;
    }
    whole = whole && fabs(at - range[1]) <= same;
    bool flat = true;
    for (size_t i = 0; i < n; i++) flat = flat && e[i].flat;
    if (whole && flat) return true;
    if (whole)
        snprintf(
            plan->why, sizeof plan->why,
            "the texture ends above face %d at %s, where another face goes on: give --taper, or a tile that comes "
            "down to the base there",
            face, side_name(side));
    else
        snprintf(
            plan->why, sizeof plan->why,
            "the texture does not fill face %d to its edge at %s: a tile that ends along the lines between cells, "
            "or --border clip, would",
            face, side_name(side));
    return false;
}

static kn_status add_chain(kn_ctx *ctx, cli_body_plan *plan, const cli_body_chain *chain)
{
    if (plan->nchains == plan->room) {
        size_t room = plan->room > 0 ? 2 * plan->room : 16;
        cli_body_chain *more = kn_resize(ctx, plan->chains, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        plan->chains = more, plan->room = room;
    }
    plan->chains[plan->nchains++] = *chain;
    return KN_OK;
}

// ---- sides that the texture goes over ----

typedef struct mate {
    kn_brep_key key;
    int face;
} mate;
typedef struct mates {
    mate *list;
    size_t count;
} mates;

static int compare_mates(const void *a, const void *b)
{
    const mate *x = a, *y = b;
    if (x->key.a != y->key.a) return x->key.a < y->key.a ? -1 : 1;
    return (x->key.b > y->key.b) - (x->key.b < y->key.b);
}

// Each edge of the texture there belongs to two patches, bit for bit.
static void check_mates(cli_body_plan *plan, mates *m)
{
    if (m->count > 0) qsort(m->list, m->count, sizeof *m->list, compare_mates);
    for (size_t i = 0; i < m->count && !plan->why[0]; i += 2)
        if (i + 1 == m->count || compare_mates(&m->list[i], &m->list[i + 1]) != 0)
            snprintf(
                plan->why, sizeof plan->why,
                "the texture of face %d does not join the one beyond its edge (or at its seam): a whole number of "
                "cells round, equal cells, or --taper on each face make it close",
                m->list[i].face);
}

// ---- faces ----

static kn_status look_at_curve(kn_ctx *ctx, cli_body_plan *plan, mates *inside, const kn_cad *cad, int face, int k,
                               int surface, const cli_border *border)
{
    const kn_cad_face *f = &cad->faces[face];
    const kn_cad_edge *e = &cad->edges[f->edge[k]];
    const cli_border_edge *first = NULL;
    double range[2];
    int side;
    if (e->point || e->face[1] < 0 || !side_of(f, k, &side, range)) return KN_OK;
    if (e->more) {
        snprintf(plan->why, sizeof plan->why, "more than two faces meet at an edge of face %d", face);
        return KN_OK;
    }
    size_t n = find_edges(border, surface, side, range, &first);
    int other = e->face[0] == face ? e->face[1] : e->face[0];
    if (is_replaced(plan, other)) {
        for (size_t i = 0; i < n; i++) inside->list[inside->count++] = (mate){first[i].key, face};
        return KN_OK;
    }
    if (!is_chain(plan, face, side, range, first, n)) return KN_OK;
    // Counterclockwise the boundary of a square runs up along v = 0 and u = 1. The face beyond runs the other way.
    bool up = side == 2 || side == 1;
    return add_chain(ctx, plan, &(cli_body_chain){f->edge[k], surface, first, n, !up});
}

kn_status cli_body_plan_add(kn_ctx *ctx, cli_body_plan *out, const kn_cad *cad, const int *face, int nsurfaces,
                            const cli_border *border)
{
    mates inside = {0};
    if (!out->replaced) out->replaced = kn_alloc(ctx, (size_t)cad->nfaces, sizeof *out->replaced);
    inside.list = kn_alloc(ctx, border->count, sizeof *inside.list);
    kn_status status = out->replaced && inside.list ? KN_OK : KN_ENOMEM;
    for (int s = 0; s < nsurfaces && status == KN_OK; s++) {
        if (face[s] < 0) continue;
        if (is_replaced(out, face[s]))
            snprintf(out->why, sizeof out->why, "two textures are on face %d", face[s]);
        else
            out->replaced[out->nreplaced++] = face[s];
        if (!cad->faces[face[s]].whole)
            snprintf(out->why, sizeof out->why, "face %d is trimmed: its edges are no parameter lines of it",
                     face[s]);
    }
    if (border->trimmed)
        snprintf(out->why, sizeof out->why,
                 "the texture is cut off at the ends of its faces, and not along its tiles");
    for (int s = 0; s < nsurfaces && status == KN_OK && !out->why[0]; s++)
        for (int k = 0; face[s] >= 0 && k < cad->faces[face[s]].trim.ncurves && status == KN_OK && !out->why[0]; k++)
            status = look_at_curve(ctx, out, &inside, cad, face[s], k, s, border);
    if (status == KN_OK && !out->why[0]) check_mates(out, &inside);
    kn_free(ctx, inside.list);
    return status;
}

void cli_body_plan_clear(kn_ctx *ctx, cli_body_plan *plan)
{
    kn_free(ctx, plan->chains);
    kn_free(ctx, plan->replaced);
    *plan = (cli_body_plan){0};
}
