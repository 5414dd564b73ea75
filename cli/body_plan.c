// SPDX-License-Identifier: Apache-2.0
// Where a texture's border meets the edges of a body whose faces it replaces.
#include "cli/body.h"
#include "kernel/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Of parameters in [0,1]: ends of edges that are equal up to what trims are known to.
static const double same = 1e-6;

// The faces with a texture, and their surfaces.
typedef struct textured {
    const kn_cad *cad;
    const int *face, *turn; // of each of n surfaces; turn NULL: none is turned
    int n;
    const cli_border *border;
} textured;

static int surface_of(const textured *t, int face)
{
    for (int s = 0; s < t->n; s++)
        if (t->face[s] == face) return s;
    return -1;
}

// ---- sides ----

// Where the use k of an edge by the face of a surface lies: a side of the surface, from a to b along it.
typedef struct use {
    int surface, side;
    double range[2];
    const cli_border_edge *edges; // n of the border's
    size_t n;
} use;

// false: along no side.
static bool find_side(use *out, const textured *t, int surface, int k)
{
    static const int next[4] = {2, 3, 1, 0}; // (u,v) -> (1 - v, u)
    const kn_spline *c = &t->cad->faces[t->face[surface]].trim.curves[k];
    int n = c->count[0];
    for (int v = 0; v < 2; v++) {
        const double *x = c->coef + v * n, *y = c->coef + (1 - v) * n;
        bool on = x[0] == 0.0 || x[0] == 1.0;
        for (int i = 1; i < n && on; i++) on = x[i] == x[0];
        if (!on) continue;
        *out = (use){surface, 2 * v + (x[0] == 1.0), {fmin(y[0], y[n - 1]), fmax(y[0], y[n - 1])}, NULL, 0};
        for (int i = 0; t->turn && i < t->turn[surface]; i++) {
            if (out->side < 2) { // along v, and then against u
                double lo = 1.0 - out->range[1];
                out->range[1] = 1.0 - out->range[0];
                out->range[0] = lo;
            }
            out->side = next[out->side];
        }
        return true;
    }
    return false;
}

static void find_edges(use *u, const cli_border *b)
{
    for (size_t i = 0; i < b->count; i++) {
        const cli_border_edge *e = &b->edges[i];
        if (e->surface != u->surface || e->side != u->side) continue;
        if (e->from < u->range[0] - same || e->to > u->range[1] + same) continue;
        if (u->n++ == 0) u->edges = e;
    }
}

static const char *side_name(int side)
{
    static const char *const names[] = {"u = 0", "u = 1", "v = 0", "v = 1"};
    return names[side];
}

// ---- sides beyond which a face stays ----

// The texture's edges are there one after the other and on the base; or why not.
static bool is_chain(char *why, size_t room, const textured *t, const use *u)
{
    double at = u->range[0];
    bool whole = u->n > 0, flat = true;
    for (size_t i = 0; i < u->n && whole; i++) {
        whole = fabs(u->edges[i].from - at) <= (i == 0 ? same : 1e-9);
        at = u->edges[i].to;
        flat = flat && u->edges[i].flat;
    }
    whole = whole && fabs(at - u->range[1]) <= same;
    if (whole && flat) return true;
    if (whole)
        snprintf(
            why, room,
            "the texture ends above face %d at %s, where another face goes on: give --taper, or a tile that comes "
            "down to the base there",
            t->face[u->surface], side_name(u->side));
    else
        snprintf(
            why, room,
            "the texture does not fill face %d to its edge at %s: a tile that ends along the lines between cells, "
            "or --border clip, would",
            t->face[u->surface], side_name(u->side));
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

// Counterclockwise the boundary of a square runs up along v = 0 and u = 1; a face beyond it runs the other way.
static kn_status add_use(kn_ctx *ctx, cli_body_plan *plan, int edge, const use *u)
{
    return add_chain(ctx, plan, &(cli_body_chain){edge, u->surface, u->edges, u->n, u->side == 0 || u->side == 3});
}

// ---- sides that the texture goes over ----

static int compare_keys(const void *a, const void *b)
{
    const kn_brep_key *x = a, *y = b;
    if (x->a != y->a) return x->a < y->a ? -1 : 1;
    return (x->b > y->b) - (x->b < y->b);
}

// Both have the same edges, bit for bit.
static kn_status are_joined(kn_ctx *ctx, bool *joined, const use *a, const use *b)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_brep_key *x = kn_scratch(ctx, a->n + b->n + 1, sizeof *x), *y = x ? x + a->n : NULL;
    *joined = x && a->n == b->n && a->n > 0;
    if (*joined) {
        for (size_t i = 0; i < a->n; i++) x[i] = a->edges[i].key, y[i] = b->edges[i].key;
        qsort(x, a->n, sizeof *x, compare_keys);
        qsort(y, b->n, sizeof *y, compare_keys);
        for (size_t i = 0; i < a->n && *joined; i++) *joined = compare_keys(&x[i], &y[i]) == 0;
    }
    kn_scratch_release(ctx, mark);
    return x ? KN_OK : KN_ENOMEM;
}

// Where two textures do not go on over the edge between them, both have to lie on it.
static kn_status look_between(kn_ctx *ctx, cli_body_plan *plan, const textured *t, int edge, const use *a,
                              const use *b)
{
    char why[sizeof plan->why];
    bool joined = false;
    kn_status status = are_joined(ctx, &joined, a, b);
    if (status != KN_OK || joined) return status;
    if (a->n == b->n && is_chain(why, sizeof why, t, a) && is_chain(why, sizeof why, t, b)) {
        status = add_use(ctx, plan, edge, a);
        return status == KN_OK ? add_use(ctx, plan, edge, b) : status;
    }
    snprintf(
        plan->why, sizeof plan->why,
        "the textures of faces %d and %d neither go on over the edge between them bit for bit nor come down to it: "
        "narrower cells (a larger --count), equal on both, make them go on, --taper makes them come down",
        t->face[a->surface], t->face[b->surface]);
    return KN_OK;
}

// ---- faces ----

static kn_status look_at_curve(kn_ctx *ctx, cli_body_plan *plan, const textured *t, int surface, int k)
{
    int face = t->face[surface], edge = t->cad->faces[face].edge[k];
    const kn_cad_edge *e = &t->cad->edges[edge];
    bool second = e->face[1] == face && e->curve[1] == k;
    int other = second ? -1 : surface_of(t, e->face[1]);
    use u, v;
    if (e->point || e->face[1] < 0 || !find_side(&u, t, surface, k)) return KN_OK;
    if (e->more) {
        snprintf(plan->why, sizeof plan->why, "more than two faces meet at an edge of face %d", face);
        return KN_OK;
    }
    if (second && surface_of(t, e->face[0]) >= 0) return KN_OK; // seen from the other side
    if (second) other = -1;
    find_edges(&u, t->border);
    if (other >= 0 && find_side(&v, t, other, e->curve[1])) {
        find_edges(&v, t->border);
        return look_between(ctx, plan, t, edge, &u, &v);
    }
    return is_chain(plan->why, sizeof plan->why, t, &u) ? add_use(ctx, plan, edge, &u) : KN_OK;
}

kn_status cli_body_plan_add(kn_ctx *ctx, cli_body_plan *out, const kn_cad *cad, const int *face, const int *turn,
                            int nsurfaces, const cli_border *border)
{
    const textured t = {cad, face, turn, nsurfaces, border};
    if (!out->replaced) out->replaced = kn_alloc(ctx, (size_t)cad->nfaces, sizeof *out->replaced);
    kn_status status = out->replaced ? KN_OK : KN_ENOMEM;
    for (int s = 0; s < nsurfaces && status == KN_OK; s++) {
        if (face[s] < 0) continue;
        out->replaced[out->nreplaced++] = face[s];
        if (!cad->faces[face[s]].whole)
            snprintf(out->why, sizeof out->why,
                     "face %d is trimmed: its edges, of holes too, are no parameter lines of it, where a texture "
                     "could end",
                     face[s]);
    }
    if (border->trimmed)
        snprintf(out->why, sizeof out->why,
                 "the texture is cut off at the ends of its faces, and not along its tiles");
    for (int s = 0; s < nsurfaces && status == KN_OK && !out->why[0]; s++)
        for (int k = 0; face[s] >= 0 && k < cad->faces[face[s]].trim.ncurves && status == KN_OK && !out->why[0]; k++)
            status = look_at_curve(ctx, out, &t, s, k);
    // Last: edges that end nowhere have no partner either.
    if (border->apart && !out->why[0])
        snprintf(
            out->why, sizeof out->why,
            "patches side by side do not meet bit for bit, for the normal is another polynomial in each: a larger "
            "--normal-tol, narrower cells or --normal exact-direction make it one");
    return status;
}

void cli_body_plan_clear(kn_ctx *ctx, cli_body_plan *plan)
{
    kn_free(ctx, plan->chains);
    kn_free(ctx, plan->replaced);
    *plan = (cli_body_plan){0};
}
