// SPDX-License-Identifier: Apache-2.0
// Edges of patches along the ends of the base's surfaces.
//
// Which edges these are is known from the tile patch D behind a patch (kn_job_source): one of D's parameters r, t is at
// its end, and there u or v is that of the end of the surface, in all control points. No distance is measured.
#include "cli/border.h"
#include "io/patch_net.h"
#include "kernel/context.h"

#include <math.h>
#include <stdlib.h>

// Of (u,v), in cells: what rounding leaves of a number of cells.
static const double near = 1e-11;

// Where a surface of the job lies in the surface of the base that it is a part of.
typedef struct cli_border_part {
    int base, first[2], cells[2]; // first: among the cells of all of it
    bool at[4];                   // it lies at this side of it
    double lo[2], hi[2];          // domain of all of it
} cli_border_part;

static int tile_reach(const kn_tile *tile)
{
    double reach = 0.0;
    for (int p = 0; p < tile->nparts; p++)
        for (int i = 0; i < tile->parts[p].nsplines; i++) {
            const kn_spline *s = &tile->parts[p].splines[i];
            size_t n = kn_spline_count(s);
            for (size_t k = 0; k < 2 * n; k++) reach = fmax(reach, fmax(-s->coef[k], s->coef[k] - 1.0));
        }
    return (int)ceil(fmin(reach, 1e6));
}

// ---- where a patch lies ----

static void find_parts(const kn_job *job, cli_border_part *parts, int n)
{
    for (int p = 0; p < n; p++) {
        cli_border_part *x = &parts[p];
        x->base = kn_job_origin(job, p, x->first);
        kn_shell_cells(kn_job_shell(job, p), x->cells);
        for (int d = 0; d < 2; d++) {
            const double *lines = kn_job_lines(job, p, d);
            x->lo[d] = lines[0], x->hi[d] = lines[x->cells[d]];
        }
    }
    for (int p = 0; p < n; p++)
        for (int d = 0; d < 2; d++) {
            int last = 0;
            double lo = parts[p].lo[d], hi = parts[p].hi[d];
            for (int q = 0; q < n; q++) {
                if (parts[q].base != parts[p].base) continue;
                if (parts[q].first[d] + parts[q].cells[d] > last) last = parts[q].first[d] + parts[q].cells[d];
                lo = fmin(lo, kn_job_lines(job, q, d)[0]);
                hi = fmax(hi, kn_job_lines(job, q, d)[parts[q].cells[d]]);
            }
            parts[p].at[2 * d] = parts[p].first[d] == 0;
            parts[p].at[2 * d + 1] = parts[p].first[d] + parts[p].cells[d] == last;
            parts[p].lo[d] = lo, parts[p].hi[d] = hi;
        }
}

// Whether a patch of this cell may touch an end of its surface.
static bool may_touch(const cli_border *b, const kn_patch_id *id)
{
    int n = kn_job_describe(b->job).nparts;
    for (int p = 0; p < n; p++) {
        const cli_border_part *x = &b->parts[p];
        for (int d = 0; d < 2 && x->base == id->surface; d++)
            if (id->cell[d] <= x->first[d] + b->reach || id->cell[d] >= x->first[d] + x->cells[d] - 1 - b->reach)
                return true;
    }
    return false;
}

// x, in cells of a part, in [0,1] of the whole domain of the surface.
static double place_along(const cli_border *b, int part, int var, double x)
{
    const cli_border_part *p = &b->parts[part];
    const double *lines = kn_job_lines(b->job, part, var);
    int i = (int)fmin(fmax(floor(x), 0.0), p->cells[var] - 1);
    double t = x - i == 1.0 ? lines[i + 1] : lines[i] + (x - i) * (lines[i + 1] - lines[i]);
    return t == p->hi[var] ? 1.0 : (t - p->lo[var]) / (p->hi[var] - p->lo[var]);
}

// ---- one edge of a patch ----

// By which the other face of the edge would know it.
static kn_status find_key(kn_ctx *ctx, kn_brep_key *key, const kn_spline *curve)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_patch_curve line;
    bool turned;
    kn_status status = kn_patch_curve_load(ctx, &line, curve, 0, 1.0, "texture");
    if (status == KN_OK) *key = kn_patch_curve_key(&turned, &line);
    kn_scratch_release(ctx, mark);
    return status;
}

// What two patches share goes in twice, and is gone. An edge that is a point has no other side.
static void count_edge(cli_border *b, const kn_patch_side *side, int body)
{
    if (side->collapsed) return;
    kn_brep_key key = kn_brep_mix(side->edge.key, body);
    b->odd.a ^= key.a;
    b->odd.b ^= key.b;
}

static const int side_of[4] = {3, 1, 0, 2}; // edge 2 var + end as patch_net.h counts it

static kn_status add(kn_ctx *ctx, cli_border *b, const kn_patch *patch, int edge, const cli_border_edge *e)
{
    if (b->count == b->room) {
        size_t room = b->room > 0 ? 2 * b->room : 64;
        cli_border_edge *more = kn_resize(ctx, b->edges, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        b->edges = more, b->room = room;
    }
    cli_border_edge *out = &b->edges[b->count];
    *out = *e;
    out->curve = (kn_spline){0};
    kn_status status = kn_patch_side_spline(ctx, &out->curve, patch, side_of[edge]);
    if (status != KN_OK) return status;
    b->count++;
    return find_key(ctx, &out->key, &out->curve);
}

// Whether coordinate c is constant along edge 2 var + end of D: *value; where it begins and ends in any case.
static bool is_constant(const kn_bezier *d, int edge, int c, double *value, double *begin, double *finish)
{
    int var = edge / 2, other = 1 - var, n = d->degree[other] + 1;
    int step = other == 1 ? 1 : d->degree[1] + 1;
    int at = edge % 2 == 0 ? 0 : d->degree[var] * (var == 1 ? 1 : d->degree[1] + 1);
    const double *x = d->coef + (size_t)c * kn_bezier_count(d) + at;
    *value = *begin = x[0], *finish = x[(n - 1) * step];
    for (int k = 1; k < n; k++)
        if (!(fabs(x[k * step] - x[0]) <= near)) return false;
    return true;
}

static kn_status look_at_edge(kn_ctx *ctx, cli_border *b, const kn_patch *patch, const kn_patch_net *net,
                              const kn_bezier *d, const kn_patch_place *place, int edge)
{
    const cli_border_part *p = &b->parts[place->surface];
    for (int v = 0; v < 2; v++) {
        double value, begin, finish, w, from, to;
        if (!is_constant(d, edge, v, &value, &begin, &finish)) continue;
        double x = value + place->cell[v];
        int side = fabs(x) <= near && p->at[2 * v]                     ? 2 * v
                   : fabs(x - p->cells[v]) <= near && p->at[2 * v + 1] ? 2 * v + 1
                                                                       : -1;
        if (side < 0) continue;
        (void)is_constant(d, edge, 1 - v, &value, &begin, &finish);
        begin = place_along(b, place->surface, 1 - v, begin + place->cell[1 - v]);
        finish = place_along(b, place->surface, 1 - v, finish + place->cell[1 - v]);
        if (begin == finish) continue;
        bool flat = is_constant(d, edge, 2, &w, &from, &to) && w == 0.0 && from == 0.0 && to == 0.0;
        cli_border_edge e = {.surface = p->base,
                             .side = side,
                             .from = fmin(begin, finish),
                             .to = fmax(begin, finish),
                             .flat = flat,
                             .along = begin < finish,
                             .id = patch->id};
        count_edge(b, &net->side[side_of[edge]], patch->body); // what becomes of it is for the plan to find
        kn_status status = add(ctx, b, patch, edge, &e);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

static kn_status look_at(kn_ctx *ctx, cli_border *b, const kn_patch *patch)
{
    bool touches = may_touch(b, &patch->id);
    if (kn_patch_nvars(patch) != 2 || patch->trim) {
        b->trimmed = b->trimmed || touches;
        return KN_OK;
    }
    kn_bezier d = {0};
    kn_patch_place place;
    kn_patch_net net;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_patch_net_load(ctx, &net, patch, 1.0, "texture");
    for (int e = 0; status == KN_OK && e < 4; e++) count_edge(b, &net.side[e], patch->body);
    if (status == KN_OK && touches) status = kn_job_source(ctx, &d, &place, b->job, &patch->id);
    for (int edge = 0; status == KN_OK && touches && edge < 4; edge++)
        status = look_at_edge(ctx, b, patch, &net, &d, &place, edge);
    kn_scratch_release(ctx, mark);
    kn_bezier_clear(ctx, &d);
    return status;
}

// ---- the sink ----

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)product;
    kn_status status = KN_OK;
    for (size_t i = 0; i < block->count && status == KN_OK; i++) status = look_at(ctx, user, &block->patches[i]);
    return status;
}

static void close_sink(kn_ctx *ctx, void *user)
{
    (void)ctx, (void)user;
}

kn_status cli_border_sink(kn_ctx *ctx, kn_sink *out, cli_border *border, const kn_job *job)
{
    int n = kn_job_describe(job).nparts;
    *border = (cli_border){.job = job, .reach = tile_reach(kn_job_tile(job))};
    border->parts = kn_alloc(ctx, (size_t)n, sizeof *border->parts);
    if (!border->parts) return KN_ENOMEM;
    find_parts(job, border->parts, n);
    *out = (kn_sink){.user = border, .commit = commit, .close = close_sink};
    return KN_OK;
}

kn_status cli_border_move(kn_ctx *ctx, cli_border *to, cli_border *from)
{
    cli_border_edge *more = kn_resize(ctx, to->edges, to->count + from->count + 1, sizeof *more);
    if (!more) return KN_ENOMEM;
    for (size_t i = 0; i < from->count; i++) more[to->count + i] = from->edges[i];
    to->edges = more, to->count += from->count, to->room = to->count + 1;
    to->trimmed = to->trimmed || from->trimmed;
    to->apart = to->apart || from->odd.a != 0 || from->odd.b != 0;
    from->count = 0;
    return KN_OK;
}

static int compare(const void *a, const void *b)
{
    const cli_border_edge *x = a, *y = b;
    if (x->surface != y->surface) return x->surface < y->surface ? -1 : 1;
    if (x->side != y->side) return x->side < y->side ? -1 : 1;
    if (x->from != y->from) return x->from < y->from ? -1 : 1;
    return (x->to > y->to) - (x->to < y->to);
}

void cli_border_sort(cli_border *border)
{
    if (border->count > 0) qsort(border->edges, border->count, sizeof *border->edges, compare);
}

void cli_border_clear(kn_ctx *ctx, cli_border *border)
{
    for (size_t i = 0; i < border->count; i++) kn_spline_clear(ctx, &border->edges[i].curve);
    kn_free(ctx, border->edges);
    kn_free(ctx, border->parts);
    *border = (cli_border){0};
}
