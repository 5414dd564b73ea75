// SPDX-License-Identifier: Apache-2.0
// The region that a texture occupies: boxes of its patches in the cell, in a few groups, then in the shells. A box that
// spans its cell spans the shell, so that most textures need a few regions and not one for each patch of each cell.
#include "cli/check.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_PATCHES = 512 }; // boxes to gather; a tile of more is one box for each surface, or one for all

static const double thin = 0.02;  // what a box counts at least, each way: flat ones have a size, too
static const double loose = 1.25; // boxes are joined while that adds less than a quarter
static const double full = 0.98;  // a box that spans so much of the cell spans all of it
static const size_t most_regions = 20000;
static const double thickness = 1e-3; // the least extent of a region, of a cell and of the heights: no patch is flat
static const double nothing = 1e-12;  // of the heights: what rounding leaves of 0

typedef struct boxes {
    check_box box[4 * MOST_PATCHES];
    int n;
    double height; // of all, to compare w with u and v
} boxes;

// ---- gathering ----

static double size_of(const check_box *b, double height)
{
    double size = 1;
    for (int d = 0; d < 3; d++) {
        double side = (b->hi[d] - b->lo[d]) / (d == 2 ? height : 1);
        size *= side > thin ? side : thin;
    }
    return size;
}

static check_box both(const check_box *a, const check_box *b)
{
    check_box out;
    for (int d = 0; d < 3; d++) {
        out.lo[d] = fmin(a->lo[d], b->lo[d]);
        out.hi[d] = fmax(a->hi[d], b->hi[d]);
    }
    return out;
}

// Joins the two boxes that lose least by it, while they lose little or there are too many.
static void gather(boxes *all)
{
    while (all->n > 1) {
        double least = INFINITY;
        int a = 0, b = 1;
        for (int i = 0; i < all->n; i++)
            for (int j = i + 1; j < all->n; j++) {
                check_box u = both(&all->box[i], &all->box[j]);
                double waste = size_of(&u, all->height) /
                               (size_of(&all->box[i], all->height) + size_of(&all->box[j], all->height));
                if (waste < least) least = waste, a = i, b = j;
            }
        if (least > loose && all->n <= CHECK_BOXES) return;
        all->box[a] = both(&all->box[a], &all->box[b]);
        all->box[b] = all->box[--all->n];
    }
}

// ---- the tile's boxes in the unit cell ----

// What reaches into neighbouring cells comes back from the neighbours on the other side.
static void add_wrapped(boxes *all, const check_box *patch)
{
    check_box thick = *patch, *b = &thick; // an upright wall between two cells has room in both
    double first[2], last[2];
    for (int d = 0; d < 2; d++) {
        double lacks = 0.5 * (thickness - (b->hi[d] - b->lo[d]));
        if (lacks > 0) b->lo[d] -= lacks, b->hi[d] += lacks;
    }
    for (int d = 0; d < 2; d++) {
        first[d] = floor(b->lo[d]);
        last[d] = fmax(first[d], ceil(b->hi[d]) - 1);
    }
    for (double i = first[0]; i <= last[0]; i++)
        for (double j = first[1]; j <= last[1]; j++) {
            const double cell[2] = {i, j};
            check_box part = *b;
            for (int d = 0; d < 2; d++) {
                part.lo[d] = fmax(b->lo[d] - cell[d], 0.0);
                part.hi[d] = fmin(b->hi[d] - cell[d], 1.0);
            }
            if (all->n == (int)(sizeof all->box / sizeof *all->box)) gather(all);
            all->box[all->n++] = part;
        }
}

// Where w in [0,1] of the tile goes to.
static void set_heights(check_box *b, const check *c)
{
    const kn_job_options *o = &c->job.options;
    bool downwards = o->side == KN_JOB_BELOW || (o->side == KN_JOB_ABOVE && o->height < 0);
    double range[2], w[2] = {b->lo[2], b->hi[2]};
    cli_job_range(&c->job, range);
    double size = range[1] - range[0];
    b->lo[2] = downwards ? range[1] - w[1] * size : range[0] + w[0] * size;
    b->hi[2] = downwards ? range[1] - w[0] * size : range[0] + w[1] * size;
}

// What a patch occupies, a curve, a surface or a volume. Control points may lie far outside of it: the boxes of its
// parts do not.
static kn_status box_of(kn_ctx *ctx, check_box *out, const kn_bezier *patch)
{
    const int parts = patch->nvars == 3 ? 4 : 8;
    int n = 1;
    for (int d = 0; d < patch->nvars; d++) n *= parts;
    kn_status status = KN_OK;
    for (int k = 0; k < n && status == KN_OK; k++) {
        double at[3], to[3];
        for (int d = 0, i = k; d < patch->nvars; d++, i /= parts) {
            at[d] = (double)(i % parts) / parts;
            to[d] = at[d] + 1.0 / parts;
        }
        check_box b;
        status = kn_bezier_box(ctx, b.lo, b.hi, patch, at, to);
        if (status == KN_OK) *out = k ? both(out, &b) : b;
    }
    return status;
}

static void add_box(boxes *all, const check *c, check_box *b)
{
    set_heights(b, c);
    all->height = fmax(all->height, fmax(fabs(b->lo[2]), fabs(b->hi[2])));
    add_wrapped(all, b);
}

static kn_status add_spline(kn_ctx *ctx, boxes *all, const check *c, const kn_spline *spline)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, spline);
    for (size_t i = 0; i < n; i++) {
        check_box b = {0};
        if (status == KN_OK) status = box_of(ctx, &b, &pieces[i]);
        if (status == KN_OK) add_box(all, c, &b);
        kn_bezier_clear(ctx, &pieces[i]);
    }
    kn_free(ctx, pieces);
    return status;
}

// One box for all of it.
static void add_mesh(boxes *all, const check *c, const kn_mesh *mesh)
{
    check_box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < 3 * mesh->nvertices; i++) {
        b.lo[i % 3] = fmin(b.lo[i % 3], mesh->position[i]);
        b.hi[i % 3] = fmax(b.hi[i % 3], mesh->position[i]);
    }
    if (mesh->nvertices > 0) add_box(all, c, &b);
}

// Heights that rounding alone keeps from 0 are 0; flat boxes get thick, within the heights that the job occupies.
static void tidy_heights(check_box *b, const double range[2])
{
    double size = fmax(range[1] - range[0], fmax(fabs(range[0]), fabs(range[1])));
    for (int end = 0; end < 2; end++) {
        double *w = end ? &b->hi[2] : &b->lo[2];
        for (int to = 0; to < 2; to++)
            if (fabs(*w - range[to]) < nothing * size) *w = range[to];
        if (fabs(*w) < nothing * size) *w = 0;
    }
    double least = thickness * (range[1] - range[0]);
    if (b->hi[2] - b->lo[2] >= least) return;
    double lo = 0.5 * (b->lo[2] + b->hi[2] - least);
    b->lo[2] = fmin(b->lo[2], fmax(fmin(lo, range[1] - least), range[0]));
    b->hi[2] = fmax(b->hi[2], b->lo[2] + least);
}

static kn_status make_boxes(kn_ctx *ctx, check *c)
{
    const kn_tile *tile = kn_job_tile(c->plan);
    boxes *all = calloc(1, sizeof *all);
    kn_status status = all ? KN_OK : KN_ENOMEM;
    if (all) all->height = fabs(c->job.options.height);
    for (int p = 0; p < tile->nparts && status == KN_OK; p++) {
        for (int s = 0; s < tile->parts[p].nsplines && status == KN_OK; s++)
            status = add_spline(ctx, all, c, &tile->parts[p].splines[s]);
        if (status == KN_OK) add_mesh(all, c, &tile->parts[p].mesh);
    }
    if (status == KN_OK) {
        double range[2];
        cli_job_range(&c->job, range);
        gather(all);
        c->nboxes = all->n;
        for (int k = 0; k < all->n; k++) {
            c->box[k] = all->box[k];
            tidy_heights(&c->box[k], range);
            for (int d = 0; d < 2; d++)
                if (c->box[k].hi[d] - c->box[k].lo[d] >= full) c->box[k].lo[d] = 0, c->box[k].hi[d] = 1;
            c->range[0] = k ? fmin(c->range[0], c->box[k].lo[2]) : c->box[k].lo[2];
            c->range[1] = k ? fmax(c->range[1], c->box[k].hi[2]) : c->box[k].hi[2];
        }
    }
    free(all);
    return status;
}

// ---- in the shells ----

// The box over cells first .. last of both variables.
static kn_fold_region place(const check *c, int shell, const check_box *b, const int first[2], const int last[2])
{
    const check_shell *s = &c->shells[shell];
    kn_fold_region r = {.shell = shell, .lo = {0, 0, s->unit * b->lo[2]}, .hi = {0, 0, s->unit * b->hi[2]}};
    // a volume ends where it ends, whatever the rounding of a height says
    if (r.lo[2] < s->heights[0] && r.hi[2] > s->heights[0]) r.lo[2] = s->heights[0];
    if (r.hi[2] > s->heights[1] && r.lo[2] < s->heights[1]) r.hi[2] = s->heights[1];
    for (int d = 0; d < 2; d++) {
        const double *lines = kn_job_lines(c->plan, shell, d);
        r.lo[d] = lines[first[d]] + b->lo[d] * (lines[first[d] + 1] - lines[first[d]]);
        r.hi[d] = b->hi[d] == 1 ? lines[last[d] + 1]
                                : lines[last[d]] + b->hi[d] * (lines[last[d] + 1] - lines[last[d]]);
    }
    return r;
}

void check_cell_boxes(const check *c, int shell, const int cell[2], kn_fold_region *out)
{
    for (int b = 0; b < c->nboxes; b++) out[b] = place(c, shell, &c->box[b], cell, cell);
}

// Steps of a box along variable d: one for all cells if it spans them.
static int steps(const check_shell *s, const check_box *b, int d, bool coarse)
{
    return coarse || (b->lo[d] == 0 && b->hi[d] == 1) ? 1 : s->cells[d];
}

static size_t count_regions(const check *c, bool coarse)
{
    size_t n = 0;
    for (int i = 0; i < c->nshells; i++)
        for (int b = 0; b < c->nboxes; b++)
            n += (size_t)steps(&c->shells[i], &c->box[b], 0, coarse) *
                 (size_t)steps(&c->shells[i], &c->box[b], 1, coarse);
    return n;
}

static void fill_regions(check *c, bool coarse)
{
    for (int i = 0; i < c->nshells; i++)
        for (int k = 0; k < c->nboxes; k++) {
            check_box b = c->box[k];
            int n[2], last[2];
            for (int d = 0; d < 2; d++) {
                n[d] = steps(&c->shells[i], &b, d, coarse);
                if (coarse) b.lo[d] = 0, b.hi[d] = 1;
            }
            for (int u = 0; u < n[0]; u++)
                for (int v = 0; v < n[1]; v++) {
                    const int first[2] = {u, v};
                    for (int d = 0; d < 2; d++) last[d] = n[d] == 1 ? c->shells[i].cells[d] - 1 : first[d];
                    c->regions[c->nregions++] = place(c, i, &b, first, last);
                }
        }
}

// Volumes end where they end, whatever the heights of surfaces beside them are.
static kn_status whole_shells(check *c)
{
    bool volumes = false;
    for (int i = 0; i < c->nshells; i++) volumes |= c->shells[i].spline.nvars == 3;
    if (!volumes) return KN_OK;
    c->regions = calloc((size_t)c->nshells, sizeof *c->regions);
    if (!c->regions) return KN_ENOMEM;
    c->nregions = (size_t)c->nshells;
    for (int i = 0; i < c->nshells; i++) {
        kn_fold_region *r = &c->regions[i];
        r->shell = i;
        for (int d = 0; d < 2; d++) kn_spline_domain(kn_shell_surface(c->shells[i].shell), d, &r->lo[d], &r->hi[d]);
        r->lo[2] = c->shells[i].range[0];
        r->hi[2] = c->shells[i].range[1];
    }
    return KN_OK;
}

kn_status check_make_regions(kn_ctx *ctx, check *c)
{
    if (!c->job.tile) return whole_shells(c);
    if (check_by_cell(c)) return check_make_cell_regions(ctx, c);
    kn_status status = make_boxes(ctx, c);
    if (status != KN_OK) return status;
    for (int i = 0; i < c->nshells; i++)
        for (int end = 0; end < 2; end++) c->shells[i].range[end] = c->shells[i].unit * c->range[end];
    size_t n = count_regions(c, false);
    bool coarse = n > most_regions;
    if (coarse) n = count_regions(c, true);
    c->regions = calloc(n + 1, sizeof *c->regions);
    if (!c->regions) return KN_ENOMEM;
    fill_regions(c, coarse);
    return KN_OK;
}
