// SPDX-License-Identifier: Apache-2.0
// The tiles of a cell: one of a lattice that may be shifted, staggered and mirrored, or those that were scattered.
//
// Tile (i,j) of a lattice lies at i + a, j + b with a = shift[0] + j stagger[0], b = shift[1] + i stagger[1]. Where S
// goes on it is a matter of naming which cell has it: (i + floor a, j + floor b), so that what is left of the shift is
// in [0,1) and few variants serve all cells. A patch that reaches into the next cell goes on there as any other does.
#include "job/placement.h"

#include <math.h>

enum { MAX_DENOMINATOR = 16, MOST_VARIANTS = 4 * MAX_DENOMINATOR * MAX_DENOMINATOR, MOST_CUTS = 96 };

// How a tile lies in its cell.
typedef struct posture {
    double shift[2]; // multiples of 2^-40, in [-1,1): below 0 the tile of the cell before, which this one has too
    bool mirror[2];
} posture;

struct kn_job_tiling {
    int over[2]; // stagger[d] = over[d] / under[d]
    int under[2];
    int extra[2]; // beyond the lower end of d there is no cell, and a tile that reaches in
    double turned[3][4];
    double cuts[2][MOST_CUTS]; // kn_job_take_cuts
    int ncuts[2];
    posture *postures; // of each variant
    int count;
};

static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

static bool same_posture(const posture *a, const posture *b)
{
    for (int d = 0; d < 2; d++)
        if (a->shift[d] != b->shift[d] || a->mirror[d] != b->mirror[d]) return false;
    return true;
}

// ---- what is asked for ----

// stagger = over / under to 1e-3, under as small as can be.
static kn_status find_fraction(kn_ctx *ctx, int *over, int *under, double stagger)
{
    for (int q = 1; q <= MAX_DENOMINATOR; q++) {
        double p = round(stagger * q);
        if (!(fabs(stagger - p / q) <= 1e-3)) continue;
        *over = (int)p - q * (int)floor(p / q);
        *under = q;
        return KN_OK;
    }
    return kn_fail(ctx, KN_EDOMAIN,
                   "job: stagger %g: a fraction with a denominator up to %d is needed, as 0.5 or 1/3", stagger,
                   MAX_DENOMINATOR);
}

static kn_status check_numbers(kn_ctx *ctx, const kn_job_placement *p)
{
    for (int d = 0; d < 2; d++) {
        if (!(fabs(p->shift[d]) <= KN_JOB_MAX_REACH) || !(fabs(p->stagger[d]) <= KN_JOB_MAX_REACH))
            return kn_fail(ctx, KN_EDOMAIN, "job: shift %g, stagger %g, in cells, at most %d", p->shift[d],
                           p->stagger[d], KN_JOB_MAX_REACH);
        if (p->border[d] != KN_BORDER_EXTEND && p->border[d] != KN_BORDER_CLIP && p->border[d] != KN_BORDER_CYCLIC)
            return kn_fail(ctx, KN_EDOMAIN, "job: border %d", (int)p->border[d]);
    }
    if (!isfinite(p->angle)) return kn_fail(ctx, KN_EDOMAIN, "job: angle %g", p->angle);
    if (!(p->scatter.distance >= 0.0) || isinf(p->scatter.distance))
        return kn_fail(ctx, KN_EDOMAIN, "job: scatter distance %g", p->scatter.distance);
    return KN_OK;
}

static kn_status check_placement(kn_ctx *ctx, const kn_job *job)
{
    const kn_job_placement *p = &job->options.placement;
    kn_status status = check_numbers(ctx, p);
    if (status != KN_OK) return status;
    bool lattice = p->mirror[0] || p->mirror[1];
    for (int d = 0; d < 2; d++) lattice = lattice || p->shift[d] != 0.0 || p->stagger[d] != 0.0;
    if (p->stagger[0] != 0.0 && p->stagger[1] != 0.0)
        return kn_fail(ctx, KN_EDOMAIN, "job: rows or columns can be staggered, not both");
    if (job->tile.covering && p->angle != 0.0)
        return kn_fail(ctx, KN_EDOMAIN,
                       "job: tile \"%s\" covers its cell, and turned by %g degrees it would not: take quarter turns "
                       "(--rotate 90), or a casual tile",
                       job->tile.name, p->angle * 57.295779513082321);
    if (p->scatter.distance == 0.0) return KN_OK;
    if (job->tile.covering)
        return kn_fail(ctx, KN_EDOMAIN, "job: tile \"%s\" covers its cell: only a casual tile can be scattered",
                       job->tile.name);
    if (lattice) return kn_fail(ctx, KN_EDOMAIN, "job: scattered tiles have no shift, stagger or mirror");
    return KN_OK;
}

// ---- the lattice ----

// Counts of cells and tiles go over the whole of an origin.
static posture posture_of(const struct kn_job_tiling *t, const kn_job_placement *p, const int at[2],
                          const int beyond[2])
{
    posture out;
    for (int d = 0; d < 2; d++) {
        int row = at[1 - d] % t->under[d];
        double a = p->shift[d] +
                   (double)((t->over[d] * (row < 0 ? row + t->under[d] : row)) % t->under[d]) / t->under[d];
        int index = at[d] - (int)floor(a) - beyond[d];
        double part = a - floor(a);
        out.shift[d] = round(part * 0x1p40) * 0x1p-40 - beyond[d]; // so that 1 + shift is exact
        out.mirror[d] = p->mirror[d] && (index % 2 != 0);
    }
    return out;
}

static int find_posture(const struct kn_job_tiling *t, const posture *p)
{
    for (int k = 0; k < t->count; k++)
        if (same_posture(&t->postures[k], p)) return k;
    return -1;
}

// (u,v) of the tile as modelled -> turned -> mirrored -> shifted.
static void map_of(double map[3][4], const struct kn_job_tiling *t, const posture *p)
{
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 4; k++) map[c][k] = t->turned[c][k];
    for (int d = 0; d < 2; d++) {
        if (p->mirror[d]) {
            for (int k = 0; k < 3; k++) map[d][k] = -map[d][k];
            map[d][3] = 1.0 - map[d][3];
        }
        map[d][3] += p->shift[d];
    }
}

// All postures that cells can have, and their variants; what is as modelled is variant 0.
static kn_status add_postures(kn_ctx *ctx, kn_job *job, struct kn_job_tiling *t)
{
    const kn_job_placement *p = &job->options.placement;
    int period[2], at[2], beyond[2], variant;
    for (int d = 0; d < 2; d++) period[d] = 2 * t->under[1 - d];
    kn_status status = KN_OK;
    for (at[0] = 0; at[0] < period[0]; at[0]++)
        for (at[1] = 0; at[1] < period[1]; at[1]++)
            for (beyond[0] = 0; beyond[0] <= t->extra[0]; beyond[0]++)
                for (beyond[1] = 0; status == KN_OK && beyond[1] <= t->extra[1]; beyond[1]++) {
                    posture one = posture_of(t, p, at, beyond);
                    if (find_posture(t, &one) >= 0) continue;
                    double map[3][4];
                    map_of(map, t, &one);
                    t->postures[t->count++] = one; // in step with the variants
                    status = kn_job_add_variant(ctx, &variant, job, (const double(*)[4])map);
                }
    return status;
}

// Where the lattice meets itself over a seam, or another surface's over an edge, cell after cell along it: the tile
// must be the same from both sides.
static bool meets(const kn_job *job, const struct kn_job_tiling *t, int surface, int edge)
{
    static const int none[2] = {0, 0};
    const kn_job_surface *s = &job->surfaces[surface];
    int d = edge / 2, n = s->cells[1 - d];
    for (int k = 0; k < n && k < 2 * MAX_DENOMINATOR; k++) {
        int cell[2], offset[2] = {0, 0}, beyond[2], there[2];
        cell[d] = edge % 2 == 0 ? 0 : s->cells[d] - 1;
        cell[1 - d] = k;
        offset[d] = edge % 2 == 0 ? -1 : 1;
        kn_job_place place = kn_job_find_place(job, surface, cell, offset);
        const kn_job_surface *to = &job->surfaces[place.surface];
        if (place.turn != 0) return false;
        for (int v = 0; v < 2; v++) {
            int at = place.cell[v];
            beyond[v] = s->origin_cell[v] + cell[v] + offset[v];
            if (to->closed[v]) at = (at % to->cells[v] + to->cells[v]) % to->cells[v];
            there[v] = to->origin_cell[v] + at;
        }
        posture here = posture_of(t, &job->options.placement, beyond, none);
        posture other = posture_of(t, &job->options.placement, there, none);
        if (!same_posture(&here, &other)) return false;
    }
    return true;
}

static kn_status check_seams(kn_ctx *ctx, const kn_job *job, const struct kn_job_tiling *t)
{
    for (int i = 0; i < job->nsurfaces; i++)
        for (int e = 0; e < 4; e++) {
            const kn_job_surface *s = &job->surfaces[i];
            int d = e / 2;
            if ((!s->closed[d] && !s->partner[e].goes_on) || meets(job, t, i, e)) continue;
            int other = s->closed[d] ? s->origin : job->surfaces[s->partner[e].edge / 4].origin;
            if (!kn_job_selects(&job->options.select, s->origin) || !kn_job_selects(&job->options.select, other))
                continue;
            int rows = d == 0 ? t->under[1] : t->under[0];
            bool mirror = job->options.placement.mirror[d];
            if (s->closed[d])
                return kn_fail(ctx, KN_EDOMAIN,
                               "job: %d cells in %s around surface %d: tiles that are staggered or mirrored meet at "
                               "the seam with a multiple of %d",
                               s->cells[d], d == 0 ? "u" : "v", s->origin, mirror && rows % 2 != 0 ? 2 * rows : rows);
            return kn_fail(ctx, KN_EDOMAIN,
                           "job: covering tiles that are shifted, staggered or mirrored do not meet at the edge of "
                           "surfaces %d and %d, whose cells are numbered otherwise there",
                           s->origin, job->surfaces[s->partner[e].edge / 4].origin);
        }
    return KN_OK;
}

// A covering tile that is shifted away from the lower end of an open direction leaves a gap there, which the tile
// before it fills.
static void find_extra(struct kn_job_tiling *t, const kn_job *job)
{
    const kn_job_placement *p = &job->options.placement;
    for (int d = 0; d < 2; d++) {
        bool shifted = p->stagger[d] != 0.0 || p->shift[d] != floor(p->shift[d]);
        t->extra[d] = shifted && p->border[d] != KN_BORDER_CYCLIC &&
                      (job->tile.covering || p->border[d] == KN_BORDER_CLIP);
    }
}

static void add_cut(struct kn_job_tiling *t, int d, double at)
{
    at -= floor(at);
    if (at >= 1.0 - 1e-12) at = 0.0;
    for (int k = 0; k < t->ncuts[d]; k++)
        if (fabs(t->cuts[d][k] - at) <= 1e-12) return;
    if (t->ncuts[d] < MOST_CUTS) t->cuts[d][t->ncuts[d]++] = round(at * 0x1p40) * 0x1p-40;
}

// A corner of the tile at b on the line between two rows meets the other row at b plus multiples of 1 / under: there
// every tile is cut, so that neighbours share their edges from end to end.
static void add_cuts_at(struct kn_job_tiling *t, const kn_job_placement *p, int d, double b)
{
    for (int k = 0; k < t->under[d]; k++) {
        double a = p->shift[d] + (double)k / t->under[d];
        add_cut(t, d, a + b);
        if (p->mirror[d]) add_cut(t, d, a - b);
    }
}

static void find_cuts(struct kn_job_tiling *t, const kn_job *job, int d)
{
    const kn_job_placement *p = &job->options.placement;
    if (t->under[d] < 2) return;
    add_cuts_at(t, p, d, 0.0);
    for (int k = 0; k < job->variants[0].count; k++) {
        const kn_bezier *patch = &job->patches[k].d;
        size_t n = kn_bezier_count(patch);
        for (int corner = 0; corner < 1 << patch->nvars; corner++) {
            size_t at = 0;
            for (int v = 0; v < patch->nvars; v++)
                at = at * ((size_t)patch->degree[v] + 1) + (corner >> v & 1 ? (size_t)patch->degree[v] : 0);
            double across = patch->coef[(size_t)(1 - d) * n + at];
            if (across == 0.0 || across == 1.0) add_cuts_at(t, p, d, patch->coef[(size_t)d * n + at]);
        }
    }
}

void kn_job_take_cuts(kn_job_change *change, const kn_job *job)
{
    for (int d = 0; d < 2; d++) {
        change->cuts[d] = job->tiling ? job->tiling->cuts[d] : NULL;
        change->ncuts[d] = job->tiling ? job->tiling->ncuts[d] : 0;
    }
}

static kn_status make_tiling(kn_ctx *ctx, kn_job *job, struct kn_job_tiling *t)
{
    const kn_job_placement *p = &job->options.placement;
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < 2; d++)
        status = find_fraction(ctx, &t->over[d], &t->under[d], p->stagger[d]);
    if (status != KN_OK) return status;
    double c = cos(p->angle), s = sin(p->angle);
    const double turned[3][4] = {
        {c, -s, 0, 0.5 - 0.5 * c + 0.5 * s}, {s, c, 0, 0.5 - 0.5 * s - 0.5 * c}, {0, 0, 1, 0}};
    for (int k = 0; k < 12; k++) t->turned[k / 4][k % 4] = (p->angle != 0.0 ? turned : identity)[k / 4][k % 4];
    find_extra(t, job);
    for (int d = 0; d < 2 && job->tile.covering; d++) find_cuts(t, job, d);
    t->postures = kn_alloc(ctx, MOST_VARIANTS, sizeof *t->postures);
    if (!t->postures) return KN_ENOMEM;
    t->postures[t->count++] = (posture){{0.0, 0.0}, {false, false}};
    bool otherwise = p->angle != 0.0 || t->ncuts[0] > 0 || t->ncuts[1] > 0;
    if (otherwise) t->postures[0].shift[0] = INFINITY; // no cell has it as modelled
    status = add_postures(ctx, job, t);
    return status == KN_OK && job->tile.covering ? check_seams(ctx, job, t) : status;
}

kn_status kn_job_instances_init(kn_ctx *ctx, kn_job *job)
{
    const kn_job_placement *p = &job->options.placement;
    kn_status status = check_placement(ctx, job);
    if (status != KN_OK) return status;
    if (p->scatter.distance > 0.0) return kn_job_scatter_tiles(ctx, job);
    bool plain = p->angle == 0.0;
    for (int d = 0; d < 2; d++) plain = plain && p->shift[d] == 0.0 && p->stagger[d] == 0.0 && !p->mirror[d];
    if (plain) return KN_OK;
    job->tiling = kn_alloc_zero(ctx, 1, sizeof *job->tiling);
    return job->tiling ? make_tiling(ctx, job, job->tiling) : KN_ENOMEM;
}

void kn_job_instances_clear(kn_ctx *ctx, kn_job *job)
{
    if (job->tiling) kn_free(ctx, job->tiling->postures);
    kn_free(ctx, job->tiling);
    kn_free(ctx, job->darts);
    job->tiling = NULL;
    job->darts = NULL;
}

// ---- the tiles of a cell ----

kn_status kn_job_add_instance(kn_ctx *ctx, kn_job_instance_list *list, const kn_job_instance *instance)
{
    if (list->count == list->room) {
        int room = list->room > 0 ? 2 * list->room : 4;
        kn_job_instance *more = kn_resize(ctx, list->list, (size_t)room, sizeof *more);
        if (!more) return KN_ENOMEM;
        list->list = more;
        list->room = room;
    }
    list->list[list->count++] = *instance;
    return KN_OK;
}

static kn_status add_plain(kn_ctx *ctx, kn_job_instance_list *out, int variant, const double map[3][4])
{
    kn_job_instance one = {.id = out->count, .plain = true, .variant = variant};
    for (int k = 0; k < 12; k++) one.map[k / 4][k % 4] = map[k / 4][k % 4];
    return kn_job_add_instance(ctx, out, &one);
}

// The middle of the tile comes to the dart.
static kn_status add_scattered(kn_ctx *ctx, kn_job_instance_list *out, const kn_job *job, size_t index)
{
    double c = cos(job->options.placement.angle), s = sin(job->options.placement.angle);
    kn_status status = KN_OK;
    for (size_t k = kn_job_first_dart(job, index); k < job->ndarts && job->darts[k].cell == index; k++) {
        const double *at = job->darts[k].at;
        const kn_job_instance one = {
            .id = out->count,
            .map = {{c, -s, 0, at[0] - 0.5 * c + 0.5 * s}, {s, c, 0, at[1] - 0.5 * s - 0.5 * c}, {0, 0, 1, 0}}};
        status = kn_job_add_instance(ctx, out, &one);
        if (status != KN_OK) break;
    }
    return status;
}

kn_status kn_job_instances(kn_ctx *ctx, kn_job_instance_list *out, const kn_job *job, int surface, const int cell[2])
{
    const kn_job_surface *s = &job->surfaces[surface];
    size_t index = s->first_cell + (size_t)cell[0] * (size_t)s->cells[1] + (size_t)cell[1];
    if (job->options.placement.scatter.distance > 0.0) return add_scattered(ctx, out, job, index);
    const struct kn_job_tiling *t = job->tiling;
    if (!t) return add_plain(ctx, out, 0, identity);
    int at[2], most[2], beyond[2];
    for (int d = 0; d < 2; d++) {
        at[d] = s->origin_cell[d] + cell[d];
        most[d] = t->extra[d] && cell[d] == 0 && !s->closed[d] && !s->partner[2 * d].goes_on;
    }
    kn_status status = KN_OK;
    for (beyond[0] = 0; beyond[0] <= most[0]; beyond[0]++)
        for (beyond[1] = 0; status == KN_OK && beyond[1] <= most[1]; beyond[1]++) {
            posture one = posture_of(t, &job->options.placement, at, beyond);
            bool reaches = true;
            for (int d = 0; d < 2; d++) reaches = reaches && (beyond[d] == 0 || one.shift[d] > -1.0);
            if (!reaches) continue; // it ends where the domain begins
            double map[3][4];
            map_of(map, t, &one);
            status = add_plain(ctx, out, find_posture(t, &one), (const double(*)[4])map);
        }
    return status;
}
