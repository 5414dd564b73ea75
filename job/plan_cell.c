// SPDX-License-Identifier: Apache-2.0
// Which pieces of the shell one cell composes with which parts of the tile.
#include "job/border.h"

#include <math.h>

// Whether S is not one polynomial over the box: a line strictly inside it at which S has a knot, or the seam of a
// closed direction. Beyond open ends S's end pieces are extended.
static bool crosses_knot(const kn_job *job, const kn_job_place *place, const double lo[2], const double hi[2])
{
    for (int d = 0; d < 2; d++)
        for (double line = floor(lo[d]) + 1.0; line < hi[d]; line += 1.0)
            if (kn_job_is_knot(job, &job->surfaces[place->surface], place->cell, d, line)) return true;
    return false;
}

// Where patches may cross lines, those that lie wholly or partly in other cells are composed there (kn_job_cross).
static bool lies_beyond(const kn_job *job, const kn_bezier *d, const double lo[2], const double hi[2])
{
    if (job->options.crossing == KN_CROSSING_REFUSE || d->nvars > 2) return false;
    return lo[0] < 0.0 || lo[1] < 0.0 || hi[0] > 1.0 || hi[1] > 1.0;
}

static double spread(const kn_bezier *d)
{
    double lo[2], hi[2];
    kn_job_box(lo, hi, d);
    return (hi[0] - lo[0]) * (hi[0] - lo[0]) + (hi[1] - lo[1]) * (hi[1] - lo[1]);
}

// The variable whose bisection makes the two boxes smaller together.
static kn_status choose_cut(kn_ctx *ctx, int *var, const kn_bezier *d, kn_job_rect rect)
{
    kn_bezier left = {0}, right = {0};
    double size[KN_JOB_VARS] = {INFINITY, INFINITY, INFINITY};
    kn_status status = KN_OK;
    for (int v = 0; status == KN_OK && v < d->nvars; v++) {
        if (rect.level[v] == KN_JOB_MAX_DEPTH) continue;
        status = kn_bezier_subdivide(ctx, &left, &right, d, v, 0.5);
        if (status == KN_OK) size[v] = spread(&left) + spread(&right);
    }
    *var = 0;
    for (int v = 1; v < d->nvars; v++)
        if (size[v] < size[*var]) *var = v;
    kn_bezier_clear(ctx, &left);
    kn_bezier_clear(ctx, &right);
    return status;
}

// Where D lies as to the ends at which it is cut off.
static kn_job_clipped find_clipped(const kn_job *job, const kn_job_place *place, const kn_bezier *d)
{
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY}, end[2][2];
    size_t n = kn_bezier_count(d);
    for (size_t i = 0; i < 2 * n; i++) {
        lo[i / n] = fmin(lo[i / n], d->coef[i]);
        hi[i / n] = fmax(hi[i / n], d->coef[i]);
    }
    kn_job_clip_ends(end, job, place);
    return kn_job_clip_box(lo, hi, (const double(*)[2])end);
}

// What there is beyond the end of an open direction that D reaches over: NULL where it reaches over none.
static const char *find_beyond(const kn_job *job, const kn_job_place *place, const kn_bezier *d)
{
    const kn_job_surface *s = &job->surfaces[place->surface];
    kn_shell_edge edge[2][2];
    const char *found = NULL;
    kn_shell_edges(s->shell, edge);
    size_t n = kn_bezier_count(d);
    for (size_t i = 0; i < 2 * n && !found; i++) {
        size_t c = i / n;
        bool below = d->coef[i]<-place->cell[c], above = d->coef[i]> s->cells[c] - place->cell[c];
        if (s->closed[c] || (!below && !above)) continue;
        bool curve = edge[c][above].kind == KN_EDGE_CURVE, u = c == 0;
        found = above ? (curve ? (u ? "the upper end of u" : "the upper end of v")
                               : (u ? "the pole at the upper end of u" : "the pole at the upper end of v"))
                      : (curve ? (u ? "the lower end of u" : "the lower end of v")
                               : (u ? "the pole at the lower end of u" : "the pole at the lower end of v"));
    }
    return found;
}

// No piece fits any part of D.
static kn_status give_up(kn_ctx *ctx, const kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                         const kn_job_place *place, const kn_bezier *d, bool crosses)
{
    const kn_job_patch *p = kn_job_leaf_patch(plan, leaf);
    const char *name = plan->job->tile.parts[p->part].name, *beyond = find_beyond(plan->job, place, d);
    const kn_job_surface *s = &plan->job->surfaces[plan->surface];
    int cell[2] = {s->origin_cell[0] + plan->cell[0], s->origin_cell[1] + plan->cell[1]};
    kn_job_crossing way = plan->job->options.crossing;
    if (crosses && way == KN_CROSSING_REFUSE) {
        return kn_fail(ctx, KN_EDOMAIN,
                       "job: %s %d of tile part \"%s\" crosses a knot line of surface %d in cell %d,%d, and not "
                       "along a parameter line of its own: %s",
                       p->d.nvars == 3 ? "volume" : "patch", p->patch, name, s->origin, cell[0], cell[1],
                       p->d.nvars == 3
                           ? "--crossing approximate takes a polynomial for it, within --crossing-tol"
                           : "--crossing trim cuts it along the line, --crossing approximate keeps it whole");
    }
    if (crosses && p->d.nvars == 3)
        return kn_fail(
            ctx, KN_EUNDECIDED,
            "job: volume %d of tile part \"%s\" crosses a knot line of surface %d, or a line between cells "
            "of different widths, in cell %d,%d, and no few polynomials are within the tolerance of it: a "
            "--count for cells of one width, or a larger --crossing-tol, may do",
            p->patch, name, s->origin, cell[0], cell[1]);
    if (beyond)
        return kn_fail(ctx, KN_EUNDECIDED,
                       "job: patch %d of tile part \"%s\" in cell %d,%d of surface %d reaches beyond %s, where the "
                       "extended surface has no normal of low degree within the tolerance: --border clip cuts it off "
                       "there, a larger --normal-tol may do",
                       p->patch, name, cell[0], cell[1], s->origin, beyond);
    if (crosses)
        return kn_fail(ctx, KN_EUNDECIDED,
                       "job: patch %d of tile part \"%s\" crosses a knot line of surface %d in cell %d,%d: no pieces "
                       "within the tolerances after %d bisections each way; a larger --crossing-tol may do%s",
                       p->patch, name, s->origin, cell[0], cell[1], KN_JOB_MAX_DEPTH,
                       way == KN_CROSSING_APPROXIMATE ? ", or --crossing trim" : "");
    return kn_fail(ctx, KN_EUNDECIDED,
                   "job: no normal of low degree within the tolerance for patch %d of tile part \"%s\" in cell %d,%d "
                   "of surface %d, after %d bisections each way",
                   p->patch, name, cell[0], cell[1], s->origin, KN_JOB_MAX_DEPTH);
}

static kn_status refuse_clip(kn_ctx *ctx, const kn_job_cell_plan *plan, const kn_job_leaf *leaf)
{
    const kn_job_patch *p = kn_job_leaf_patch(plan, leaf);
    const kn_job_surface *s = &plan->job->surfaces[plan->surface];
    return kn_fail(ctx, KN_EDOMAIN,
                   "job: volume %d of tile part \"%s\" crosses the end of surface %d in cell %d,%d, and not along a "
                   "parameter line of its own: volumes cannot be trimmed; --border extend keeps it whole",
                   p->patch, plan->job->tile.parts[p->part].name, s->origin, s->origin_cell[0] + plan->cell[0],
                   s->origin_cell[1] + plan->cell[1]);
}

// What the trim of a tile's surface leaves of it, and the border of the base where that may cross it.
static kn_status add_leaf(kn_ctx *ctx, kn_job_cell_plan *plan, kn_job_leaf *leaf, const kn_job_place *place,
                          kn_answer border, const kn_bezier *d)
{
    bool any = true;
    kn_status status = KN_OK;
    if (kn_job_is_trimmed(plan, leaf)) status = kn_job_leaf_trim(ctx, &leaf->trim, &any, plan, leaf);
    if (status == KN_OK && any)
        status = border == KN_UNKNOWN ? kn_job_clip_leaf(ctx, plan, leaf, place, d)
                                      : kn_job_add_leaf(ctx, plan, leaf);
    kn_trim_clear(ctx, &leaf->trim);
    return status;
}

static kn_status plan_rect(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job_leaf *leaf, const kn_job_place *place);

static kn_status plan_halves(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job_leaf *leaf, const kn_job_place *place,
                             int var)
{
    kn_status status = KN_OK;
    for (int half = 0; status == KN_OK && half < 2; half++) {
        kn_job_leaf part = *leaf;
        part.key.rect.level[var]++;
        part.key.rect.index[var] = (uint16_t)(2 * leaf->key.rect.index[var] + half);
        status = plan_rect(ctx, plan, &part, place);
    }
    return status;
}

// One part of a patch over the tight box around it, or, where no piece fits there, its halves.
static kn_status plan_rect(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job_leaf *leaf, const kn_job_place *place)
{
    // Where crossing is refused: along parameter lines that bisection finds. Volumes over a line have no end of parts.
    enum { CROSSING_DEPTH = 6, VOLUME_DEPTH = 9 };
    kn_bezier d = {0};
    const kn_job_rect *rect = &leaf->key.rect;
    kn_status status = kn_job_restrict(ctx, &d, kn_job_leaf_patch(plan, leaf), *rect, place->turn);
    if (status != KN_OK) return status;
    double lo[2], hi[2];
    kn_job_box(lo, hi, &d);
    int depth = rect->level[0] + rect->level[1] + rect->level[2], index = 0, var = 0;
    kn_answer border;
    status = kn_job_border_of_patch(ctx, &border, plan, place, &d);
    kn_job_clipped clipped = find_clipped(plan->job, place, &d);
    bool crosses = crosses_knot(plan->job, place, lo, hi);
    bool done = status != KN_OK || clipped == KN_CLIP_OUTSIDE || border == KN_NO;
    bool curve = border == KN_UNKNOWN && d.nvars == 1; // ends there
    if (!done && clipped == KN_CLIP_ACROSS && d.nvars == 3) {
        status = refuse_clip(ctx, plan, leaf);
    } else if (!done && border == KN_UNKNOWN && d.nvars == 3) {
        kn_job_leaf part = *leaf;
        status = kn_job_clip_leaf(ctx, plan, &part, place, &d); // refuses, too
    } else if (!done && (clipped == KN_CLIP_ACROSS || crosses || curve || lies_beyond(plan->job, &d, lo, hi))) {
        bool outline = plan->pieces.outline;
        plan->pieces.outline = false;
        status = kn_job_cross(ctx, &done, plan, leaf, place, &d);
        plan->pieces.outline = outline;
    } else if (!done) {
        status = kn_job_pieces_get(ctx, &index, &plan->pieces, place, lo, hi);
        if (status == KN_OK && plan->pieces.list[index].fits) {
            kn_job_leaf made = *leaf;
            made.piece = index;
            status = add_leaf(ctx, plan, &made, place, border, &d);
            done = true;
        }
    }
    if (status == KN_OK && !done) {
        bool refuse = crosses && plan->job->options.crossing == KN_CROSSING_REFUSE && d.nvars > 1;
        int most = refuse ? CROSSING_DEPTH : crosses && d.nvars == 3 ? VOLUME_DEPTH : d.nvars * KN_JOB_MAX_DEPTH;
        if (depth >= most)
            status = give_up(ctx, plan, leaf, place, &d, crosses);
        else
            status = choose_cut(ctx, &var, &d, *rect);
        if (status == KN_OK) status = plan_halves(ctx, plan, leaf, place, var);
    }
    kn_bezier_clear(ctx, &d);
    return status;
}

static kn_status plan_parts(kn_ctx *ctx, kn_job_cell_plan *plan, int patch, bool own, int instance)
{
    static const double zero[2] = {0.0, 0.0}, one[2] = {1.0, 1.0};
    kn_job_leaf leaf = {.key = {.patch = patch}, .own = own, .instance = instance, .piece = -1};
    const kn_job_patch *p = kn_job_leaf_patch(plan, &leaf);
    if (p->inside && kn_job_is_clipped(plan->job, plan->surface, plan->cell, p->offset)) return KN_OK;
    kn_job_place place = kn_job_find_place(plan->job, plan->surface, plan->cell, p->offset);
    leaf.key.turn = (uint8_t)place.turn;
    if (!p->inside) return plan_rect(ctx, plan, &leaf, &place);
    int index = 0;
    bool whole = false;
    kn_answer border = KN_YES;
    kn_bezier d = {0};
    kn_status status = KN_OK;
    if (kn_job_clips_trims(plan->job)) {
        status = kn_job_restrict(ctx, &d, p, leaf.key.rect, place.turn);
        if (status == KN_OK) status = kn_job_border_of_patch(ctx, &border, plan, &place, &d);
    }
    if (status == KN_OK && border != KN_NO && (border == KN_YES || p->d.nvars > 1)) {
        status = kn_job_pieces_get(ctx, &index, &plan->pieces, &place, zero, one);
        whole = status == KN_OK && plan->pieces.list[index].fits;
    }
    if (whole) {
        leaf.key.whole = true;
        leaf.piece = index;
        status = add_leaf(ctx, plan, &leaf, &place, border, &d);
    } else if (status == KN_OK && border != KN_NO) {
        status = plan_rect(ctx, plan, &leaf, &place);
    }
    kn_bezier_clear(ctx, &d);
    return status;
}

// As one patch that meets its neighbours, where n has knots in cells.
static kn_status plan_patch(kn_ctx *ctx, kn_job_cell_plan *plan, int patch, bool own, int instance)
{
    kn_job_leaf leaf = {.key = {.patch = patch}, .own = own, .instance = instance, .piece = -1};
    const kn_job_patch *p = kn_job_leaf_patch(plan, &leaf);
    kn_job_place place = kn_job_find_place(plan->job, plan->surface, plan->cell, p->offset);
    for (int v = 0; v < 2; v++) { // over the seam
        const kn_job_surface *s = &plan->job->surfaces[place.surface];
        if (s->closed[v]) place.cell[v] = (place.cell[v] % s->cells[v] + s->cells[v]) % s->cells[v];
    }
    bool can = p->inside && !kn_job_clips_trims(plan->job) && kn_job_may_meet(plan, &place) &&
               !kn_job_is_trimmed(plan, &leaf);
    bool met = false;
    int number = plan->asked++;
    leaf.key.turn = (uint8_t)place.turn;
    if (kn_job_notes_meeting(plan->job)) return kn_job_note_meeting(ctx, plan, &leaf, &place, can);
    kn_status status = can ? kn_job_meet(ctx, &met, plan, &leaf, &place, number) : KN_OK;
    return status == KN_OK && !met ? plan_parts(ctx, plan, patch, own, instance) : status;
}

// ---- instances of their own ----

typedef struct change {
    const kn_job *job;
    int surface;
    const int *cell;
    const kn_job_instance *instance;
} change;

static kn_status change_patch(kn_ctx *ctx, void *user, kn_bezier *d, const kn_tile *tile, int part, int spline,
                              int patch)
{
    (void)tile;
    const change *c = user;
    const kn_job_instance *instance = c->instance;
    kn_status status = kn_job_vary_patch(ctx, d, c->job, c->surface, c->cell, instance, part, spline, patch);
    if (status == KN_OK) kn_job_map_patch(d, instance->map);
    return status;
}

kn_status kn_job_cut_own(kn_ctx *ctx, kn_job_patches *out, const kn_job *job, int surface, const int cell[2],
                         const kn_job_instance *instance)
{
    change c = {job, surface, cell, instance};
    kn_job_change changes = {.user = &c, .apply = change_patch};
    kn_job_take_cuts(&changes, job);
    int first = out->n;
    kn_status status = kn_job_cut_patches(ctx, out, &job->tile, &job->options, &changes);
    bool mirrored = kn_job_map_mirrors(instance->map);
    for (int k = first; status == KN_OK && k < out->n; k++) out->list[k].mirrored = mirrored;
    return status;
}

static kn_status plan_own(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job_instance *instance)
{
    int first = plan->own.n;
    kn_status status = kn_job_cut_own(ctx, &plan->own, plan->job, plan->surface, plan->cell, instance);
    for (int k = first; status == KN_OK && k < plan->own.n; k++)
        status = plan_patch(ctx, plan, k, true, instance->id);
    return status;
}

static kn_status plan_instance(kn_ctx *ctx, kn_job_cell_plan *plan, kn_job_instance *instance)
{
    const kn_job *job = plan->job;
    kn_status status = kn_job_vary_instance(ctx, instance, job, plan->surface, plan->cell);
    if (status != KN_OK) return status;
    if (instance->plain) {
        const kn_job_variant *v = &job->variants[instance->variant];
        for (int k = v->first; status == KN_OK && k < v->first + v->count; k++)
            status = plan_patch(ctx, plan, k, false, instance->id);
    } else {
        status = plan_own(ctx, plan, instance);
    }
    bool outline = plan->pieces.outline;
    plan->pieces.outline = false;
    if (status == KN_OK) status = kn_job_map_meshes(ctx, plan, instance);
    plan->pieces.outline = outline;
    return status;
}

kn_status kn_job_plan_cell(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job *job, size_t index, bool outline)
{
    kn_job_instance_list instances = {0};
    *plan = (kn_job_cell_plan){.job = job, .shared = true, .normal = {.certified = true}};
    kn_job_locate(job, index, &plan->surface, plan->cell);
    plan->pieces.job = job;
    plan->pieces.outline = outline;
    kn_status status = kn_job_has_cell(ctx, &plan->there, job, plan->surface, plan->cell);
    if (status == KN_OK && plan->there) status = kn_job_instances(ctx, &instances, job, plan->surface, plan->cell);
    for (int i = 0; status == KN_OK && i < instances.count; i++)
        status = plan_instance(ctx, plan, &instances.list[i]);
    kn_free(ctx, instances.list);
    if (status != KN_OK) kn_job_cell_plan_clear(ctx, plan);
    return status;
}
