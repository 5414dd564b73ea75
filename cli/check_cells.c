// SPDX-License-Identifier: Apache-2.0
// What a texture occupies cell by cell, where it does not do so alike everywhere: of cells that are chosen, of
// tiles that are placed, scattered or varied.
#include "cli/check.h"
#include "job/placement.h"
#include "kernel/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BOXES = 1 << 20, MOST_REGIONS = 20000 };
static const double thickness = 1e-3; // the least extent, of a cell and of the heights: no patch is flat

bool check_by_cell(const check *c)
{
    const kn_job_options *o = &c->job.options;
    const kn_job_selection *s = &o->select;
    const kn_job_placement *p = &o->placement;
    const kn_job_random *r = &o->random;
    bool chosen = s->surfaces || s->mask.value || s->cone || s->skip[0] > 1 || s->skip[1] > 1 || s->density > 0 ||
                  s->first > 0 || s->count > 0 || s->slab || s->view;
    bool placed = p->shift[0] != 0 || p->shift[1] != 0 || p->stagger[0] != 0 || p->stagger[1] != 0 || p->mirror[0] ||
                  p->mirror[1] || p->angle != 0 || p->border[0] || p->border[1] || p->scatter.distance > 0;
    return chosen || placed || o->nvary > 0 || o->taper > 0 || r->angle != 0 || r->shift != 0 || r->scale != 0 ||
           r->height != 0;
}

// The part of an extent's box that lies in the cell at `offset` from its place, closed directions wrapped.
static bool add_part(check *c, const kn_job_place *place, const kn_job_extent *e, const int offset[2])
{
    const check_shell *s = &c->shells[place->surface];
    bool closed[2];
    kn_shell_closed(s->shell, closed);
    check_cell_box b = {.shell = place->surface, .lo[2] = e->w[0], .hi[2] = e->w[1]};
    for (int d = 0; d < 2; d++) {
        int n = s->cells[d], cell = place->cell[d] + offset[d];
        b.cell[d] = closed[d] ? (cell % n + n) % n : cell;
        if (b.cell[d] < 0 || b.cell[d] >= n) return true; // beyond an open end: no cell's
        const double lo = e->lo[d] - offset[d], hi = e->hi[d] - offset[d];
        const double middle = fmin(fmax(0.5 * (lo + hi), 0.5 * thickness), 1 - 0.5 * thickness);
        b.lo[d] = fmax(fmin(lo, middle - 0.5 * thickness), 0);
        b.hi[d] = fmin(fmax(hi, middle + 0.5 * thickness), 1);
    }
    if (c->ncell_boxes == c->cell_boxes_room) {
        size_t room = c->cell_boxes_room ? 2 * c->cell_boxes_room : 256;
        check_cell_box *grown = realloc(c->cell_boxes, room * sizeof *grown);
        if (!grown) return false;
        c->cell_boxes = grown;
        c->cell_boxes_room = room;
    }
    c->cell_boxes[c->ncell_boxes++] = b;
    return true;
}

// All of the box: what no cell line cuts along a parameter line of its own may lie in several cells.
static bool add_box(check *c, const kn_job_place *place, const kn_job_extent *e)
{
    const double near = 1e-9;
    int first[2], last[2], at[2];
    for (int d = 0; d < 2; d++) {
        first[d] = (int)floor(e->lo[d] + near);
        last[d] = (int)fmax(first[d], ceil(e->hi[d] - near) - 1);
    }
    for (at[0] = first[0]; at[0] <= last[0]; at[0]++)
        for (at[1] = first[1]; at[1] <= last[1]; at[1]++)
            if (!add_part(c, place, e, at)) return false;
    return true;
}

static kn_status add_cell(kn_ctx *ctx, check *c, kn_job_extents *extents, int shell, const int cell[2])
{
    bool has = false;
    kn_status status = kn_job_has_cell(ctx, &has, c->plan, shell, cell);
    if (status != KN_OK || !has) return status;
    status = kn_job_cell_extents(ctx, extents, c->plan, shell, cell);
    for (int k = 0; status == KN_OK && k < extents->count; k++) {
        kn_job_place place;
        kn_job_extent e = extents->list[k];
        if (kn_job_place_extent(&place, &e, c->plan, shell, cell) && !add_box(c, &place, &e)) status = KN_ENOMEM;
    }
    if (status == KN_OK && c->ncell_boxes > MOST_BOXES)
        status = kn_fail(ctx, KN_ELIMIT, "check: tiles in more than %d cells that differ: check a --range of them",
                         MOST_BOXES);
    return status;
}

static int by_place(const void *a, const void *b)
{
    const check_cell_box *x = a, *y = b;
    if (x->shell != y->shell) return x->shell < y->shell ? -1 : 1;
    for (int d = 0; d < 2; d++)
        if (x->cell[d] != y->cell[d]) return x->cell[d] < y->cell[d] ? -1 : 1;
    return 0;
}

// One box for all that is in a cell.
static void join(check *c)
{
    size_t n = 0;
    if (c->ncell_boxes > 0) qsort(c->cell_boxes, c->ncell_boxes, sizeof *c->cell_boxes, by_place);
    for (size_t i = 0; i < c->ncell_boxes; i++) {
        check_cell_box *to = n > 0 ? &c->cell_boxes[n - 1] : NULL, *b = &c->cell_boxes[i];
        if (!to || by_place(to, b) != 0) {
            c->cell_boxes[n++] = *b;
            continue;
        }
        for (int d = 0; d < 3; d++) to->lo[d] = fmin(to->lo[d], b->lo[d]), to->hi[d] = fmax(to->hi[d], b->hi[d]);
    }
    c->ncell_boxes = n;
}

static kn_fold_region region(const check *c, const check_cell_box *b)
{
    kn_fold_region r = {.shell = b->shell, .lo[2] = b->lo[2], .hi[2] = b->hi[2]};
    const check_shell *s = &c->shells[b->shell];
    for (int d = 0; d < 2; d++) {
        const double *line = kn_job_lines(c->plan, b->shell, d) + b->cell[d];
        r.lo[d] = line[0] + b->lo[d] * (line[1] - line[0]);
        r.hi[d] = b->hi[d] == 1 ? line[1] : line[0] + b->hi[d] * (line[1] - line[0]);
    }
    r.lo[2] = fmin(fmax(r.lo[2], s->heights[0]), s->heights[1]); // a volume ends where it ends
    r.hi[2] = fmin(fmax(r.hi[2], s->heights[0]), s->heights[1]);
    return r;
}

// Flat boxes get thick, upwards, or down where a volume ends; ranges of all shells.
static void tidy(check *c)
{
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < c->ncell_boxes; i++) {
        lo = fmin(lo, c->cell_boxes[i].lo[2] / c->shells[c->cell_boxes[i].shell].unit);
        hi = fmax(hi, c->cell_boxes[i].hi[2] / c->shells[c->cell_boxes[i].shell].unit);
    }
    double size = lo < hi ? hi - lo : fmax(fabs(hi), 1e-9);
    for (size_t i = 0; i < c->ncell_boxes; i++) {
        check_cell_box *b = &c->cell_boxes[i];
        double least = thickness * size * c->shells[b->shell].unit, lacks = least - (b->hi[2] - b->lo[2]);
        if (lacks > 0 && b->hi[2] + lacks <= c->shells[b->shell].heights[1])
            b->hi[2] += lacks;
        else if (lacks > 0)
            b->lo[2] -= lacks;
        hi = fmax(hi, b->hi[2] / c->shells[b->shell].unit);
    }
    if (c->ncell_boxes == 0) lo = hi = 0;
    c->range[0] = lo, c->range[1] = hi;
    for (int i = 0; i < c->nshells; i++)
        for (int end = 0; end < 2; end++) c->shells[i].range[end] = c->shells[i].unit * c->range[end];
}

kn_status check_make_cell_regions(kn_ctx *ctx, check *c)
{
    kn_job_extents extents = {0};
    kn_status status = KN_OK;
    for (int s = 0; status == KN_OK && s < c->nshells; s++)
        for (int i = 0; status == KN_OK && i < c->shells[s].cells[0]; i++)
            for (int j = 0; status == KN_OK && j < c->shells[s].cells[1]; j++)
                status = add_cell(ctx, c, &extents, s, (const int[2]){i, j});
    kn_job_extents_clear(ctx, &extents);
    if (status != KN_OK) return status;
    join(c);
    tidy(c);
    bool coarse = c->ncell_boxes > MOST_REGIONS; // then all cells of a shell in one
    c->regions = calloc(c->ncell_boxes + 1, sizeof *c->regions);
    if (!c->regions) return KN_ENOMEM;
    for (size_t i = 0; i < c->ncell_boxes; i++) {
        kn_fold_region r = region(c, &c->cell_boxes[i]), *to = c->nregions > 0 ? &c->regions[c->nregions - 1] : NULL;
        if (!to || !coarse || to->shell != r.shell) {
            c->regions[c->nregions++] = r;
            continue;
        }
        for (int d = 0; d < 3; d++) to->lo[d] = fmin(to->lo[d], r.lo[d]), to->hi[d] = fmax(to->hi[d], r.hi[d]);
    }
    return KN_OK;
}

bool check_cell_region(const check *c, int shell, const int cell[2], kn_fold_region *out)
{
    const check_cell_box key = {.shell = shell, .cell = {cell[0], cell[1]}};
    const check_cell_box *b = c->ncell_boxes > 0 ? bsearch(&key, c->cell_boxes, c->ncell_boxes, sizeof key, by_place)
                                                 : NULL;
    if (b) *out = region(c, b);
    return b != NULL;
}
