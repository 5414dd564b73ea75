// SPDX-License-Identifier: Apache-2.0
// The shells that `knurl check` looks at, and where each of them folds.
#include "cli/check.h"
#include "cli/plan.h"
#include "kernel/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- from a base ----

static bool add_room(check *c, int more)
{
    check_shell *grown = realloc(c->shells, (size_t)(c->nshells + more) * sizeof *grown);
    if (!grown) return false;
    memset(grown + c->nshells, 0, (size_t)more * sizeof *grown);
    c->shells = grown;
    return true;
}

static kn_status add_volume(kn_ctx *ctx, check *c, const kn_spline *volume, int surface)
{
    if (!add_room(c, 1)) return KN_ENOMEM;
    check_shell *s = &c->shells[c->nshells++];
    s->surface = surface;
    return kn_spline_copy(ctx, &s->spline, volume);
}

static kn_status add_surface(kn_ctx *ctx, check *c, const kn_spline *surface, int index)
{
    kn_spline *pieces = NULL;
    int counts[2] = {1, 1}, first[2] = {0, 0};
    if (c->job.options.direction) { // it goes on over a crease, and so does T
        if (!add_room(c, 1)) return KN_ENOMEM;
        c->shells[c->nshells].surface = index;
        return kn_spline_copy(ctx, &c->shells[c->nshells++].spline, surface);
    }
    kn_status status = kn_shell_split_creases(ctx, &pieces, counts, surface,
                                              cli_crease_angle(c->job.options.normal_tol));
    if (status != KN_OK) return status;
    if (!add_room(c, counts[0] * counts[1])) status = KN_ENOMEM;
    for (int i = 0; i < counts[0]; i++) {
        first[1] = 0;
        for (int j = 0; j < counts[1]; j++) {
            kn_spline *piece = &pieces[i * counts[1] + j];
            if (status == KN_OK) {
                check_shell *s = &c->shells[c->nshells++];
                s->surface = index;
                for (int d = 0; d < 2; d++) s->first_cell[d] = first[d];
                kn_spline_swap(&s->spline, piece);
                piece = &s->spline;
            }
            first[1] += kn_spline_spans(piece, 1);
            if (j == counts[1] - 1) first[0] += kn_spline_spans(piece, 0);
        }
    }
    for (int k = 0; k < counts[0] * counts[1]; k++) kn_spline_clear(ctx, &pieces[k]);
    kn_free(ctx, pieces);
    return status;
}

// A field of the whole base surface, over the part that a piece is.
static kn_status fit_field(kn_ctx *ctx, kn_spline *out, const kn_spline *field, const kn_spline *base,
                           const kn_spline *piece)
{
    kn_status status = kn_spline_copy(ctx, out, field);
    double lo[2], hi[2];
    for (int d = 0; d < 2 && status == KN_OK; d++) {
        kn_spline_domain(base, d, &lo[d], &hi[d]);
        status = kn_spline_reparameterize(ctx, out, out, d, lo[d], hi[d]);
    }
    for (int d = 0; d < 2; d++) kn_spline_domain(piece, d, &lo[d], &hi[d]);
    return status == KN_OK ? kn_spline_restrict(ctx, out, out, lo, hi) : status;
}

static kn_status make_shell(kn_ctx *ctx, const check *c, check_shell *s)
{
    const kn_job_options *job = &c->job.options;
    if (s->spline.nvars == 3) return kn_shell_from_volume(ctx, &s->own, &s->spline, NULL);
    kn_shell_options o = kn_shell_defaults();
    kn_spline field[CLI_FIELDS] = {0};
    kn_status status = KN_OK;
    for (int f = 0; f < CLI_FIELDS && status == KN_OK; f++)
        if (c->job.field[f].given)
            status = fit_field(ctx, &field[f], &c->job.field[f].spline, &c->base.surfaces[s->surface], &s->spline);
    o.normal = job->normal;
    o.normal_tol = job->normal_tol;
    o.attraction_power = job->attraction_power;
    if (job->direction) o.direction = &field[CLI_FIELD_DIRECTION];
    if (job->thickness) o.thickness = &field[CLI_FIELD_THICKNESS];
    if (job->attraction) o.attraction = &field[CLI_FIELD_ATTRACTION];
    if (status == KN_OK) status = kn_shell_create(ctx, &s->own, &s->spline, &o);
    for (int f = 0; f < CLI_FIELDS; f++) kn_spline_clear(ctx, &field[f]);
    return status;
}

static kn_status make_task(kn_ctx *ctx, void *user, size_t index)
{
    const check *c = user;
    check_shell *s = &c->shells[index];
    kn_status status = make_shell(ctx, c, s);
    if (status != KN_OK) snprintf(s->failure, sizeof s->failure, "%s", kn_ctx_message(ctx));
    return status;
}

// ---- from a job ----

static kn_status take_plan(kn_ctx *ctx, check *c)
{
    kn_status status = cli_create_job(ctx, &c->plan, c->base.surfaces, c->base.nsurfaces, &c->tile, &c->job);
    if (status != KN_OK) return status;
    kn_job_report report = kn_job_describe(c->plan);
    c->job.options.height = report.height;
    if (!add_room(c, report.nparts)) return KN_ENOMEM;
    for (int i = 0; i < report.nparts; i++) {
        check_shell *s = &c->shells[c->nshells++];
        s->shell = kn_job_shell(c->plan, i);
        s->surface = kn_job_origin(c->plan, i, s->first_cell);
    }
    return KN_OK;
}

// The first failure with the surface's name, which the library does not know.
static int fail(cli_session *session, const check *c, kn_status status)
{
    const check_shell *s = NULL;
    for (int i = 0; i < c->nshells && !s; i++)
        if (c->shells[i].failure[0]) s = &c->shells[i];
    bool blame = status == KN_EDOMAIN || status == KN_ELIMIT || status == KN_EUNDEFINED || status == KN_EUNDECIDED;
    if (!s || !blame) return cli_fail_on_job(session, status, &c->job, &c->base);
    cli_field_text field = cli_blamed_field(&c->job, s->failure);
    return cli_fail_at(session, status, "%s%s: surface %d: %s", field.text, c->job.base, s->surface, s->failure);
}

int check_make_shells(cli_session *session, check *c)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_status status = KN_OK;
    if (c->job.tile) {
        status = take_plan(ctx, c);
    } else {
        for (int i = 0; i < c->base.nsurfaces && status == KN_OK; i++) {
            const kn_spline *s = &c->base.surfaces[i];
            status = s->nvars == 3 ? add_volume(ctx, c, s, i) : add_surface(ctx, c, s, i);
        }
        if (status == KN_OK) status = kn_parallel(ctx, (size_t)c->nshells, make_task, c, "shell");
    }
    if (status != KN_OK) return fail(session, c, status);
    bool heights_of_job = c->job.options.height != 0;
    cli_job_range(&c->job, c->range);
    for (int i = 0; i < c->nshells; i++) {
        check_shell *s = &c->shells[i];
        double *heights = s->heights;
        if (s->own) s->shell = s->own;
        kn_shell_cells(s->shell, s->cells);
        kn_shell_heights(s->shell, heights);
        s->unit = isfinite(heights[1]) ? heights[1] - heights[0] : 1;
        for (int end = 0; end < 2; end++) s->range[end] = isfinite(heights[end]) ? heights[end] : c->range[end];
        if (!heights_of_job && s->range[1] > c->range[1]) c->range[1] = s->range[1]; // nothing but volumes
    }
    return EXIT_OK;
}

void check_clear(cli_session *session, check *c)
{
    kn_ctx *ctx = cli_ctx(session);
    for (int i = 0; i < c->nshells; i++) {
        kn_shell_destroy(ctx, c->shells[i].own);
        kn_spline_clear(ctx, &c->shells[i].spline);
        free(c->shells[i].cell_safe);
        free(c->shells[i].cell_folds);
    }
    free(c->shells);
    free(c->regions);
    free(c->cell_boxes);
    free(c->cells);
    kn_job_destroy(ctx, c->plan);
    kn_tile_clear(ctx, &c->tile);
    cli_base_clear(session, &c->base);
    cli_job_end(session, &c->job);
}

// ---- where they fold ----

static void box_of(const check_shell *s, double lo[3], double hi[3])
{
    for (int d = 0; d < 2; d++) kn_spline_domain(kn_shell_surface(s->shell), d, &lo[d], &hi[d]);
    lo[2] = s->range[0];
    hi[2] = s->range[1];
}

static bool fits(const kn_fold_heights *safe, const double range[2])
{
    return (range[1] <= 0 || range[1] < safe->above) && (range[0] >= 0 || -range[0] < safe->below);
}

// One more answer about a part of the same shell.
static void join(kn_fold_sign *all, const kn_fold_sign *more)
{
    if (more->value < all->value || all->verdict == KN_FOLD_POSITIVE) {
        memcpy(all->where, more->where, sizeof all->where);
        all->value = more->value;
    }
    bool both = all->verdict != more->verdict;
    bool open = all->verdict == KN_FOLD_UNDECIDED || more->verdict == KN_FOLD_UNDECIDED;
    bool mixed = all->verdict == KN_FOLD_MIXED || more->verdict == KN_FOLD_MIXED;
    all->verdict = mixed ? KN_FOLD_MIXED : open ? KN_FOLD_UNDECIDED : both ? KN_FOLD_MIXED : all->verdict;
}

// The regions of a shell, as large as they are: bounds of the Jacobian, and whether it is positive on all of them.
static kn_status bound_regions(kn_ctx *ctx, const check *c, check_shell *s, int index, bool *positive)
{
    kn_status status = KN_OK;
    s->sign = (kn_fold_sign){.verdict = KN_FOLD_POSITIVE, .lo = INFINITY, .hi = -INFINITY};
    *positive = true;
    for (size_t k = 0; k < c->nregions && status == KN_OK; k++) {
        kn_fold_sign sign;
        if (c->regions[k].shell != index) continue;
        status = kn_fold_jacobian_sign(ctx, &sign, s->shell, c->regions[k].lo, c->regions[k].hi);
        if (status != KN_OK) continue;
        *positive &= sign.verdict == KN_FOLD_POSITIVE;
        s->sign.lo = fmin(s->sign.lo, sign.lo);
        s->sign.hi = fmax(s->sign.hi, sign.hi);
    }
    return status;
}

// Cells whose safe heights do not cover the tile's: its boxes there are looked at one by one.
static kn_status examine_regions(kn_ctx *ctx, const check *c, check_shell *s, int index)
{
    bool positive;
    kn_status status = bound_regions(ctx, c, s, index, &positive);
    const double bounds[2] = {s->sign.lo, s->sign.hi};
    for (int i = 0; i < s->cells[0] && status == KN_OK && !positive; i++)
        for (int j = 0; j < s->cells[1] && status == KN_OK; j++) {
            kn_fold_region box[CHECK_BOXES];
            int cell[2] = {i, j}, k = i * s->cells[1] + j, n = c->nboxes;
            if (fits(&s->cell_safe[k], s->range)) continue;
            if (check_by_cell(c))
                n = check_cell_region(c, index, cell, box);
            else
                check_cell_boxes(c, index, cell, box);
            for (int b = 0; b < n && status == KN_OK; b++) {
                kn_fold_sign sign;
                if (fits(&s->cell_safe[k], (double[2]){box[b].lo[2], box[b].hi[2]})) continue;
                status = kn_fold_jacobian_sign(ctx, &sign, s->shell, box[b].lo, box[b].hi);
                if (status != KN_OK) continue;
                s->cell_folds[k] |= sign.verdict != KN_FOLD_POSITIVE;
                join(&s->sign, &sign);
            }
        }
    // What is certain of the sign is certain of the bounds.
    s->sign.lo = s->sign.verdict == KN_FOLD_POSITIVE ? fmax(bounds[0], 0.0) : bounds[0];
    s->sign.hi = s->sign.verdict == KN_FOLD_NEGATIVE ? fmin(bounds[1], 0.0) : bounds[1];
    return status;
}

static kn_status examine_shell(kn_ctx *ctx, const check *c, check_shell *s, int index)
{
    size_t n = (size_t)s->cells[0] * (size_t)s->cells[1];
    s->cell_safe = calloc(n, sizeof *s->cell_safe);
    s->cell_folds = calloc(n, sizeof *s->cell_folds);
    if (!s->cell_safe || !s->cell_folds) return KN_ENOMEM;
    kn_status status = kn_fold_safe_heights(ctx, s->cell_safe, &s->safe, s->shell);
    if (status != KN_OK || c->job.tile) return status == KN_OK ? examine_regions(ctx, c, s, index) : status;
    double lo[3], hi[3];
    box_of(s, lo, hi);
    status = kn_fold_jacobian_sign(ctx, &s->sign, s->shell, lo, hi);
    for (size_t k = 0; k < n; k++)
        s->cell_folds[k] = s->sign.verdict != KN_FOLD_POSITIVE && !fits(&s->cell_safe[k], s->range);
    return status;
}

static kn_status examine_task(kn_ctx *ctx, void *user, size_t index)
{
    const check *c = user;
    check_shell *s = &c->shells[index];
    kn_status status = examine_shell(ctx, c, s, (int)index);
    if (status != KN_OK) snprintf(s->failure, sizeof s->failure, "%s", kn_ctx_message(ctx));
    return status;
}

static int by_room(const void *a, const void *b)
{
    const check_cell *x = a, *y = b;
    if (x->room != y->room) return x->room < y->room ? -1 : 1;
    if (x->shell != y->shell) return x->shell < y->shell ? -1 : 1;
    for (int d = 0; d < 2; d++)
        if (x->cell[d] != y->cell[d]) return x->cell[d] < y->cell[d] ? -1 : 1;
    return 0;
}

// Where the cell has its limit. A side without one has no place: then the cell's corner.
static kn_status locate(kn_ctx *ctx, const check *c, check_cell *cell)
{
    const check_shell *s = &c->shells[cell->shell];
    const kn_fold_heights *safe = &s->cell_safe[cell->cell[0] * s->cells[1] + cell->cell[1]];
    bool above = safe->above < INFINITY && s->range[1] > 0;
    if (above && s->range[0] < 0 && safe->below / -s->range[0] < safe->above / s->range[1]) above = false;
    bool below = !above && safe->below < INFINITY && s->range[0] < 0;
    for (int d = 0; d < 2; d++) {
        double hi;
        kn_spline_domain(kn_shell_surface(s->shell), d, &cell->at[d], &hi);
        if (above) cell->at[d] = safe->where_above[d];
        if (below) cell->at[d] = safe->where_below[d];
    }
    return kn_spline_eval(ctx, cell->point, kn_shell_surface(s->shell), cell->at);
}

static double share(double safe, double wanted)
{
    return wanted > 0 ? safe / wanted : INFINITY;
}

static bool is_used(const check *c, int shell, int k)
{
    const int n = c->shells[shell].cells[1], cell[2] = {k / n, k % n};
    kn_fold_region r;
    return !c->job.tile || !check_by_cell(c) || check_cell_region(c, shell, cell, &r);
}

// Of cells in which nothing is safe heights do not count.
static void forget_unused(const check *c, check_shell *s, int shell)
{
    if (!c->job.tile || !check_by_cell(c)) return;
    s->safe = (kn_fold_heights){.above = INFINITY, .below = INFINITY};
    for (int k = 0; k < s->cells[0] * s->cells[1]; k++) {
        const kn_fold_heights *h = &s->cell_safe[k];
        if (!is_used(c, shell, k)) continue;
        if (h->above < s->safe.above) {
            s->safe.above = h->above;
            memcpy(s->safe.where_above, h->where_above, sizeof h->where_above);
        }
        if (h->below < s->safe.below) {
            s->safe.below = h->below;
            memcpy(s->safe.where_below, h->where_below, sizeof h->where_below);
        }
    }
}

static kn_status rank_cells(kn_ctx *ctx, check *c)
{
    for (int i = 0; i < c->nshells; i++) c->ncells += (size_t)c->shells[i].cells[0] * (size_t)c->shells[i].cells[1];
    c->cells = calloc(c->ncells + 1, sizeof *c->cells);
    if (!c->cells) return KN_ENOMEM;
    check_cell *to = c->cells;
    for (int i = 0; i < c->nshells; i++) {
        const check_shell *s = &c->shells[i];
        for (int k = 0; k < s->cells[0] * s->cells[1]; k++) {
            if (!is_used(c, i, k)) continue;
            double room = fmin(share(s->cell_safe[k].above, s->range[1]), share(s->cell_safe[k].below, -s->range[0]));
            *to = (check_cell){
                .shell = i, .cell = {k / s->cells[1], k % s->cells[1]}, .room = room, .folds = s->cell_folds[k]};
            c->nfolding += to->folds;
            to++;
        }
    }
    c->ncells = (size_t)(to - c->cells);
    if (c->ncells > 0) qsort(c->cells, c->ncells, sizeof *c->cells, by_room);
    kn_status status = KN_OK;
    for (size_t k = 0; k < c->ncells && status == KN_OK; k++) status = locate(ctx, c, &c->cells[k]);
    return status;
}

// What all shells together say.
static void conclude(check *c)
{
    c->safe = (kn_fold_heights){.above = INFINITY, .below = INFINITY};
    c->jacobian[0] = INFINITY;
    c->jacobian[1] = -INFINITY;
    int seen[4] = {0};
    for (int i = 0; i < c->nshells; i++) {
        const check_shell *s = &c->shells[i];
        c->safe.above = fmin(c->safe.above, s->safe.above);
        c->safe.below = fmin(c->safe.below, s->safe.below);
        c->jacobian[0] = fmin(c->jacobian[0], s->sign.lo);
        c->jacobian[1] = fmax(c->jacobian[1], s->sign.hi);
        seen[s->sign.verdict]++;
    }
    c->verdict = seen[KN_FOLD_MIXED] || (seen[KN_FOLD_POSITIVE] && seen[KN_FOLD_NEGATIVE]) ? KN_FOLD_MIXED
                 : seen[KN_FOLD_UNDECIDED]                                                 ? KN_FOLD_UNDECIDED
                 : seen[KN_FOLD_NEGATIVE]                                                  ? KN_FOLD_NEGATIVE
                                                                                           : KN_FOLD_POSITIVE;
}

int check_examine(cli_session *session, check *c)
{
    kn_status status = kn_parallel(cli_ctx(session), (size_t)c->nshells, examine_task, c, "folds");
    if (status != KN_OK) return fail(session, c, status);
    for (int i = 0; i < c->nshells; i++) forget_unused(c, &c->shells[i], i);
    conclude(c);
    status = rank_cells(cli_ctx(session), c);
    return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
}
