// SPDX-License-Identifier: Apache-2.0
// Which cells there are: each is looked at once, before the plan, and has a bit afterwards.
#include "job/border.h"
#include "job/depth.h"
#include "job/vary.h"
#include "kernel/hash.h"
#include "kernel/parallel.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 4096 }; // cells of one task: whole words of job->there

typedef struct selecting {
    kn_job *job;
    const kn_job_selection *o;
    kn_job_bounds bounds; // for slab and view
    kn_job_camera camera;
    kn_job_depth depth;                 // what the base hides; of no level: nothing
    size_t (*dropped)[KN_DROP_REASONS]; // of each block
} selecting;

// ---- options ----

static kn_status check_selection(kn_ctx *ctx, const kn_job *job)
{
    const kn_job_selection *o = &job->options.select;
    if (o->nsurfaces < 0 || (o->nsurfaces > 0 && !o->surfaces))
        return kn_fail(ctx, KN_EDOMAIN, "job: a selection of %d surfaces", o->nsurfaces);
    for (int i = 0; o->surfaces && i < o->nsurfaces; i++)
        if (o->surfaces[i] < 0 || o->surfaces[i] >= job->report.nsurfaces)
            return kn_fail(ctx, KN_EDOMAIN, "job: no surface %d to select among %d", o->surfaces[i],
                           job->report.nsurfaces);
    if (o->skip[0] < 0 || o->skip[1] < 0)
        return kn_fail(ctx, KN_EDOMAIN, "job: every %d, %d-th cell", o->skip[0], o->skip[1]);
    if (!(o->density >= 0.0 && o->density <= 1.0)) return kn_fail(ctx, KN_EDOMAIN, "job: density %g", o->density);
    if (o->cone && !(o->cone_angle >= 0.0 && o->cone_angle <= 3.2))
        return kn_fail(ctx, KN_EDOMAIN, "job: a cone of %g radians", o->cone_angle);
    double axis = hypot(o->cone_axis[0], hypot(o->cone_axis[1], o->cone_axis[2]));
    if (o->cone && !(axis > 0.0 && isfinite(axis))) return kn_fail(ctx, KN_EDOMAIN, "job: a cone about no direction");
    if (o->slab && !(o->slab_z[0] <= o->slab_z[1]))
        return kn_fail(ctx, KN_EDOMAIN, "job: a slab from %g to %g", o->slab_z[0], o->slab_z[1]);
    if (o->view && o->view->hidden && (job->has_fields || !kn_shell_normal(job->surfaces[0].shell)->coef))
        return kn_fail(ctx, KN_EDOMAIN, "job: what is hidden is known of S + w n alone, without fields or volumes");
    return KN_OK;
}

// Whether a covering tile, which takes the base's place, has holes where there is no cell.
static bool leaves_holes(const kn_job_selection *o)
{
    return o->surfaces || o->mask.value || o->cone || o->skip[0] > 1 || o->skip[1] > 1 ||
           (o->density > 0.0 && o->density < 1.0) || o->first > 0 || o->count > 0 || o->slab ||
           (o->view && o->view->least_pixels > 0.0);
}

// ---- one cell ----

bool kn_job_selects(const kn_job_selection *o, int origin)
{
    if (!o->surfaces) return true;
    for (int i = 0; i < o->nsurfaces; i++)
        if (o->surfaces[i] == origin) return true;
    return false;
}

static bool skips(const kn_job_selection *o, const int at[2])
{
    for (int d = 0; d < 2; d++)
        if (o->skip[d] > 1 && at[d] % o->skip[d] != 0) return true;
    return false;
}

// What field and normal say at the middle.
static kn_status look(kn_ctx *ctx, kn_job_drop *why, const selecting *s, int surface, const int cell[2])
{
    const kn_job_selection *o = s->o;
    unsigned needs = (o->mask.value ? o->mask.needs : 0) | (o->cone ? KN_NEEDS_NORMAL : 0);
    if (!o->mask.value && !o->cone) return KN_OK;
    const kn_job_spot spot = {surface, {cell[0] + 0.5, cell[1] + 0.5}};
    kn_place place;
    kn_status status = kn_job_fill_spot(ctx, &place, s->job, &spot, needs);
    if (status != KN_OK) return status;
    if (o->mask.value) {
        double value = o->mask.value(o->mask.user, &place);
        if (isnan(value))
            return kn_fail(ctx, KN_EDOMAIN, "job: the mask is no number at %g, %g of surface %d", place.uv[0],
                           place.uv[1], place.surface);
        if (!(value > 0.5)) {
            *why = KN_DROP_MASK;
            return KN_OK;
        }
    }
    double dot = 0.0, length = hypot(o->cone_axis[0], hypot(o->cone_axis[1], o->cone_axis[2]));
    for (int c = 0; c < 3; c++) dot += place.normal[c] * o->cone_axis[c];
    if (o->cone && !(dot >= length * cos(fmin(o->cone_angle, acos(-1.0))))) *why = KN_DROP_CONE;
    return KN_OK;
}

// How often segments may be halved: the chord of a tessellation grows fourfold each time.
static uint8_t detail_of(const selecting *s, const double lo[3], const double hi[3])
{
    double pixels = kn_job_pixel_scale(&s->camera, lo, hi) * s->job->options.mesh_tol;
    int halvings = 0;
    for (; pixels * 4.0 <= s->camera.view.chord_pixels && (s->job->segments >> halvings) > 1; halvings++)
        pixels *= 4.0;
    return (uint8_t)halvings;
}

// Behind the base anywhere, or by what is around the cell. What lies below the base is looked at through it.
static kn_status look_behind(kn_ctx *ctx, bool *hidden, const selecting *s, const kn_job_extents *extents,
                             int surface, const int cell[2], const double lo[3], const double hi[3])
{
    double top = -INFINITY;
    *hidden = false;
    if (s->depth.nlevels == 0) return KN_OK;
    for (int k = 0; k < extents->count; k++) top = fmax(top, extents->list[k].w[1]);
    if (s->job->tile.covering || top > 0.0) *hidden = kn_job_depth_hides(&s->depth, lo, hi);
    if (*hidden) return KN_OK;
    return kn_job_is_hidden(ctx, hidden, &s->bounds, &s->camera, surface, cell, extents, lo, hi);
}

static kn_status look_at_box(kn_ctx *ctx, kn_job_drop *why, const selecting *s, kn_job_extents *extents, int surface,
                             const int cell[2], size_t index)
{
    const kn_job_selection *o = s->o;
    double lo[3], hi[3];
    if (!o->slab && !o->view) return KN_OK;
    kn_status status = kn_job_cell_extents(ctx, extents, s->job, surface, cell);
    if (status == KN_OK) status = kn_job_bounds_cell(ctx, lo, hi, &s->bounds, surface, cell, extents);
    if (status != KN_OK) return status;
    if (extents->count == 0) { // scattered tiles, and none here
        if (s->job->detail) s->job->detail[index] = 0;
        return KN_OK;
    }
    if (o->slab && (hi[2] < o->slab_z[0] || lo[2] > o->slab_z[1])) {
        *why = KN_DROP_SLAB;
        return KN_OK;
    }
    if (!o->view) return KN_OK;
    bool hidden = false;
    s->job->detail[index] = detail_of(s, lo, hi);
    if (kn_job_out_of_view(&s->camera, lo, hi))
        *why = KN_DROP_OUTSIDE;
    else if (kn_job_pixels(&s->camera, lo, hi) < o->view->least_pixels)
        *why = KN_DROP_SMALL;
    else if (o->view->hidden)
        status = look_behind(ctx, &hidden, s, extents, surface, cell, lo, hi);
    if (hidden) *why = KN_DROP_HIDDEN;
    return status;
}

static void mark(uint64_t *bits, size_t index)
{
    bits[index / 64] |= (uint64_t)1 << index % 64;
}

// ---- trims ----

// Whether the border may touch what the tiles of a cell occupy.
static kn_status reaches_border(kn_ctx *ctx, bool *yes, const selecting *s, kn_job_extents *extents, int surface,
                                const int cell[2])
{
    *yes = false;
    kn_status status = kn_job_cell_extents(ctx, extents, s->job, surface, cell);
    for (int k = 0; status == KN_OK && !*yes && k < extents->count; k++) {
        kn_job_extent e = extents->list[k];
        kn_job_place place;
        double lo[2], hi[2];
        if (!kn_job_place_extent(&place, &e, s->job, surface, cell)) continue;
        for (int d = 0; d < 2; d++) lo[d] = place.cell[d] + e.lo[d], hi[d] = place.cell[d] + e.hi[d];
        *yes = kn_job_border_touches(s->job, place.surface, lo, hi);
    }
    return status;
}

// Whether a tile without height is the surface itself, and not nothing.
static bool is_covering_surface(const kn_tile *tile)
{
    bool yes = tile->covering;
    for (int p = 0; p < tile->nparts; p++) {
        yes = yes && tile->parts[p].mesh.ntriangles == 0;
        for (int s = 0; s < tile->parts[p].nsplines; s++) yes = yes && tile->parts[p].splines[s].nvars == 2;
    }
    return yes;
}

// A cell is beyond the border when its middle is, and the border touches neither it nor its tiles.
static kn_status look_at_trim(kn_ctx *ctx, kn_job_drop *why, const selecting *s, kn_job_extents *extents,
                              kn_job_border_memo *memo, int surface, const int cell[2], size_t index)
{
    const kn_job *job = s->job;
    kn_answer answer;
    bool reaches;
    if (!job->borders) return KN_OK;
    kn_status status = kn_job_border_cell(ctx, &answer, memo, job, surface, cell);
    if (status != KN_OK) return status;
    if (answer == KN_UNKNOWN) { // crossed
        if (job->options.trimmed == KN_TRIMMED_TAPER && !is_covering_surface(&job->tile)) *why = KN_DROP_TRIM;
        return KN_OK;
    }
    status = reaches_border(ctx, &reaches, s, extents, surface, cell);
    if (status != KN_OK || reaches) return status;
    if (answer == KN_NO)
        *why = KN_DROP_TRIM;
    else
        mark(job->borders->whole, index);
    return KN_OK;
}

static kn_status judge(kn_ctx *ctx, kn_job_drop *why, const selecting *s, kn_job_extents *extents,
                       kn_job_border_memo *memo, size_t index)
{
    const kn_job_selection *o = s->o;
    int surface, cell[2];
    kn_job_locate(s->job, index, &surface, cell);
    const kn_job_surface *from = &s->job->surfaces[surface];
    const int at[2] = {from->origin_cell[0] + cell[0], from->origin_cell[1] + cell[1]};
    *why = KN_DROP_REASONS;
    if (!kn_job_selects(o, from->origin)) {
        *why = KN_DROP_SURFACE;
    } else if (index < o->first || (o->count > 0 && index - o->first >= o->count)) {
        *why = KN_DROP_RANGE;
    } else if (skips(o, at)) {
        *why = KN_DROP_SKIP;
    } else if (o->density > 0.0 && o->density < 1.0) {
        uint64_t h = kn_hash_add(kn_hash_mix(o->seed), (uint64_t)from->origin);
        h = kn_hash_add(h, (uint64_t)at[0] << 32 | (uint64_t)at[1]);
        if (kn_hash_unit(h) >= o->density) *why = KN_DROP_DENSITY;
    }
    kn_status status = KN_OK;
    if (*why == KN_DROP_REASONS) status = look(ctx, why, s, surface, cell);
    if (status == KN_OK && *why == KN_DROP_REASONS)
        status = look_at_trim(ctx, why, s, extents, memo, surface, cell, index);
    if (status == KN_OK && *why == KN_DROP_REASONS) status = look_at_box(ctx, why, s, extents, surface, cell, index);
    return status;
}

static kn_status judge_block(kn_ctx *ctx, void *user, size_t block)
{
    selecting *s = user;
    kn_job_extents extents = {0};
    kn_job_border_memo memo = {.surface = -1};
    size_t first = block * BLOCK, end = first + BLOCK < s->job->ncells ? first + BLOCK : s->job->ncells;
    kn_status status = KN_OK;
    for (size_t i = first; status == KN_OK && i < end; i++) {
        kn_job_drop why;
        status = judge(ctx, &why, s, &extents, &memo, i);
        if (status != KN_OK) break;
        if (why == KN_DROP_REASONS)
            mark(s->job->there, i);
        else
            s->dropped[block][why]++;
    }
    kn_job_extents_clear(ctx, &extents);
    return status;
}

// ---- all cells ----

static bool selects(const kn_job *job)
{
    return leaves_holes(&job->options.select) || job->options.select.view || job->borders;
}

kn_status kn_job_select_init(kn_ctx *ctx, kn_job *job)
{
    kn_status status = check_selection(ctx, job);
    if (status != KN_OK || !selects(job)) return status;
    size_t blocks = (job->ncells + BLOCK - 1) / BLOCK;
    selecting s = {.job = job, .o = &job->options.select};
    job->there = kn_alloc_zero(ctx, (job->ncells + 63) / 64, sizeof *job->there);
    s.dropped = kn_alloc_zero(ctx, blocks, sizeof *s.dropped);
    if (s.o->view) job->detail = kn_alloc_zero(ctx, job->ncells, sizeof *job->detail);
    if (!job->there || !s.dropped || (s.o->view && !job->detail)) status = KN_ENOMEM;
    if (status == KN_OK && s.o->view) status = kn_job_camera_init(ctx, &s.camera, s.o->view);
    if (status == KN_OK && (s.o->slab || s.o->view)) status = kn_job_bounds_init(ctx, &s.bounds, job);
    bool hides = s.o->view && s.o->view->hidden && !(job->tile.covering && leaves_holes(s.o)) &&
                 !job->borders; // where a base is trimmed there is nothing that could hide
    if (status == KN_OK && hides) status = kn_job_occlude(ctx, &s.depth, &s.bounds, &s.camera);
    if (status == KN_OK) status = kn_parallel(ctx, blocks, judge_block, &s, "select");
    for (size_t b = 0; status == KN_OK && b < blocks; b++)
        for (int k = 0; k < KN_DROP_REASONS; k++) job->report.dropped[k] += s.dropped[b][k];
    kn_job_depth_clear(ctx, &s.depth);
    kn_job_bounds_clear(ctx, &s.bounds);
    kn_free(ctx, s.dropped);
    return status;
}

void kn_job_select_clear(kn_ctx *ctx, kn_job *job)
{
    kn_free(ctx, job->there);
    kn_free(ctx, job->detail);
    job->there = NULL;
    job->detail = NULL;
}

kn_status kn_job_has_cell(kn_ctx *ctx, bool *has, const kn_job *job, int surface, const int cell[2])
{
    (void)ctx;
    const kn_job_surface *s = &job->surfaces[surface];
    size_t i = s->first_cell + (size_t)cell[0] * (size_t)s->cells[1] + (size_t)cell[1];
    *has = !job->there || (job->there[i / 64] >> i % 64 & 1);
    return KN_OK;
}
