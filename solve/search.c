// SPDX-License-Identifier: Apache-2.0
// The search: generation by generation, so that a continuum of zeros shows as boxes of one size that become too many.
#include "solve/search.h"

#include "kernel/context.h"

#include <string.h>

enum { ROUNDS = 8 };
static const double GOOD_CUT = 0.7, WORTH_A_TEST = 0.9, OFF_CENTER = 0.4863, ASPECT = 0x1p-12, STEP = 0x1p-8,
                    LONG = 0x1p-6;

void kn_finder_load(kn_finder *f, size_t cell, const double *lo, const double *hi)
{
    size_t m = (size_t)f->net.ncomp, n = f->net.count;
    double extra = f->net.ncomp > f->net.nvars ? f->options.residual : 0.0;
    for (size_t k = 0; k < m; k++) f->error[k] = f->cells->error[cell * m + k];
    kn_net_restrict(f->coef, f->error, &f->net, f->cells->coef + cell * m * n, lo, hi, f->work);
    for (size_t k = 0; k < m && extra > 0.0; k++) f->error[k] = (f->error[k] + extra) * (1.0 + 0x1p-50);
}

kn_status kn_finder_keep(kn_ctx *ctx, kn_finder *f, const kn_found *found)
{
    if (f->nfound == f->room) {
        size_t room = 2 * f->room + 16;
        kn_found *more = f->found ? kn_resize(ctx, f->found, room, sizeof *more) : kn_alloc(ctx, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        f->found = more;
        f->room = room;
    }
    f->found[f->nfound++] = *found;
    return KN_OK;
}

static kn_status keep_box(kn_ctx *ctx, kn_finder *f, const kn_box *b)
{
    kn_found r = {.cell = b->cell, .kind = KN_ROOT_POSSIBLE};
    for (int d = 0; d < f->net.nvars; d++) {
        r.lo[d] = r.around_lo[d] = b->lo[d];
        r.hi[d] = r.around_hi[d] = b->hi[d];
        r.at[d] = b->lo[d] + 0.5 * (b->hi[d] - b->lo[d]);
    }
    return kn_finder_keep(ctx, f, &r);
}

// Lies in a box around a root that is known, which is the only one there.
static bool known(const kn_finder *f, const kn_box *b)
{
    for (size_t i = 0; i < f->nfound; i++) {
        const kn_found *r = &f->found[i];
        bool in = r->cell == b->cell && (r->kind == KN_ROOT_UNIQUE || f->net.ncomp > f->net.nvars);
        for (int d = 0; d < f->net.nvars && in; d++) in = r->around_lo[d] <= b->lo[d] && b->hi[d] <= r->around_hi[d];
        if (in) return true;
    }
    return false;
}

static double shortest(const double *t0, const double *t1, int n)
{
    double least = 1.0;
    for (int d = 0; d < n; d++) least = fmin(least, t1[d] - t0[d]);
    return least;
}

// Cuts off the ends, rounding outwards, but never so much that a side becomes far shorter than it was, or than the
// others: along such a side derivatives drown in the rounding, and no root can be certified. The least part that is
// left of a side.
static double cut(kn_box *b, const double *t0, const double *t1, int n, double aspect, double step)
{
    double longest = 0.0, least = 1.0;
    for (int d = 0; d < n; d++) longest = fmax(longest, (t1[d] - t0[d]) * (b->hi[d] - b->lo[d]));
    for (int d = 0; d < n; d++) {
        double lo = b->lo[d], width = b->hi[d] - lo, keep = fmax(aspect * longest, step * width);
        double more = fmax(0.5 * (keep - (t1[d] - t0[d]) * width), 0.0);
        if (t1[d] < 1.0) {
            double x = lo + t1[d] * width;
            b->hi[d] = fmin(b->hi[d], x + more + 0x1p-52 * fabs(x) + 0x1p-1060);
        }
        if (t0[d] > 0.0) {
            double x = lo + t0[d] * width;
            b->lo[d] = fmax(lo, x - more - 0x1p-52 * fabs(x) - 0x1p-1060);
        }
        least = fmin(least, (b->hi[d] - b->lo[d]) / width);
    }
    return least;
}

static bool narrow_enough(const kn_finder *f, const kn_box *b)
{
    bool all = true;
    for (int d = 0; d < f->net.nvars; d++) all = all && b->hi[d] - b->lo[d] <= f->options.tolerance;
    return all;
}

// A box that stays undecided may be as narrow as it will.
static kn_fate trim(kn_finder *f, kn_box *b)
{
    double t0[KN_MAX_VARS], t1[KN_MAX_VARS];
    for (int d = 0; d < f->net.nvars; d++) t0[d] = 0.0, t1[d] = 1.0;
    kn_finder_load(f, b->cell, b->lo, b->hi);
    if (!kn_net_narrow(&f->net, f->coef, f->error, t0, t1)) return KN_FATE_EMPTY;
    (void)cut(b, t0, t1, f->net.nvars, 0.0, 0.0);
    return KN_FATE_UNDECIDED;
}

// What becomes of one box. *var: along which it should be divided.
static kn_status examine(kn_ctx *ctx, kn_finder *f, kn_box *b, kn_fate *fate, int *var)
{
    int m = f->net.ncomp, n = f->net.nvars;
    double middle[KN_MAX_VARS], value[KN_MAX_COMPS], jacobian[KN_MAX_COMPS * KN_MAX_VARS];
    double t0[KN_MAX_VARS], t1[KN_MAX_VARS];
    for (int d = 0; d < n; d++) middle[d] = 0.5;
    *fate = KN_FATE_EMPTY;
    for (int round = 0; round < ROUNDS; round++) {
        kn_finder_load(f, b->cell, b->lo, b->hi);
        if (kn_net_excluded(&f->net, f->coef, f->error)) return KN_OK;
        bool square = false;
        for (int d = 0; d < n; d++) t0[d] = 0.0, t1[d] = 1.0;
        *var = kn_net_steepest(&f->net, f->coef, f->error);
        if (m >= n) {
            kn_net_jacobian(&f->net, f->coef, middle, value, jacobian, f->work);
            square = kn_left_inverse(f->y, jacobian, m, n);
        }
        if (square) {
            kn_finder_combine(f);
            if (kn_net_excluded(&f->square, f->g, f->g_error)) return KN_OK;
            if (!kn_net_narrow(&f->square, f->g, f->g_error, t0, t1)) return KN_OK;
            if (kn_finder_kappa(f) < WORTH_A_TEST) {
                kn_status status = kn_finder_certify(ctx, f, fate, b);
                if (status != KN_OK || *fate != KN_FATE_SPLIT) return status;
                *fate = KN_FATE_EMPTY;
                kn_finder_load(f, b->cell, b->lo, b->hi);
            }
        }
        if ((!square || shortest(t0, t1, n) > GOOD_CUT) && !kn_net_narrow(&f->net, f->coef, f->error, t0, t1))
            return KN_OK;
        if (cut(b, t0, t1, n, ASPECT, STEP) > GOOD_CUT) break;
    }
    *fate = *var < 0 || narrow_enough(f, b) ? trim(f, b) : KN_FATE_SPLIT;
    return KN_OK;
}

// Boxes of one generation, and the next: each box leaves two at most.
typedef struct generation {
    kn_box *box;
    size_t count, room;
} generation;

static kn_status push(kn_ctx *ctx, generation *g, const kn_box *b)
{
    if (g->count == g->room) {
        size_t room = 2 * g->room + 64;
        kn_box *more = g->box ? kn_resize(ctx, g->box, room, sizeof *more) : kn_alloc(ctx, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        g->box = more;
        g->room = room;
    }
    g->box[g->count++] = *b;
    return KN_OK;
}

static kn_status divide(kn_ctx *ctx, const kn_finder *f, generation *next, kn_box *b, int var, bool *limited)
{
    kn_box other = *b;
    double at = b->lo[var] + OFF_CENTER * (b->hi[var] - b->lo[var]);
    b->hi[var] = other.lo[var] = at;
    if (++b->depth >= f->options.max_depth || at <= b->lo[var] || at >= other.hi[var]) {
        *limited = *limited || b->depth >= f->options.max_depth;
        b->hi[var] = other.hi[var];
        return KN_EUNDECIDED; // not divided
    }
    other.depth = b->depth;
    kn_status status = push(ctx, next, b);
    return status == KN_OK ? push(ctx, next, &other) : status;
}

static kn_status one_generation(kn_ctx *ctx, kn_finder *f, const generation *now, generation *next,
                                kn_solve_report *report)
{
    kn_status status = KN_OK;
    size_t rhythm = kn_net_rhythm((size_t)f->net.ncomp * f->net.count);
    for (size_t i = 0; i < now->count && status == KN_OK; i++) {
        kn_box b = now->box[i];
        kn_fate fate = KN_FATE_EMPTY;
        int var = -1;
        if (++report->boxes % rhythm == 0)
            status = kn_progress(ctx, "zeros", fmin(1.0, (double)report->boxes / (double)f->options.max_boxes));
        if (status != KN_OK || known(f, &b)) continue;
        if (report->boxes > f->options.max_boxes) {
            report->limited = true;
            status = keep_box(ctx, f, &b);
            continue;
        }
        status = examine(ctx, f, &b, &fate, &var);
        if (status == KN_OK && fate == KN_FATE_SPLIT) {
            status = divide(ctx, f, next, &b, var, &report->limited);
            if (status == KN_EUNDECIDED) status = KN_OK, fate = KN_FATE_UNDECIDED;
        }
        if (status == KN_OK && fate == KN_FATE_UNDECIDED) status = keep_box(ctx, f, &b);
        for (int d = 0; d < f->net.nvars && fate == KN_FATE_UNDECIDED; d++)
            report->curve_like = report->curve_like || b.hi[d] - b.lo[d] > LONG;
    }
    return status;
}

// Possible boxes count as open: many of them are a continuum, too.
static kn_status generations(kn_ctx *ctx, kn_finder *f, generation g[2], kn_solve_report *report)
{
    kn_status status = KN_OK;
    for (size_t c = 0; c < f->cells->count && status == KN_OK; c++) {
        kn_box b = {.cell = c};
        for (int d = 0; d < f->net.nvars; d++) b.hi[d] = 1.0;
        status = push(ctx, &g[0], &b);
    }
    size_t first = g[0].count;
    for (int now = 0; g[now].count > 0 && status == KN_OK; now = !now) {
        g[!now].count = 0;
        status = one_generation(ctx, f, &g[now], &g[!now], report);
        if (status == KN_OK && g[!now].count + f->nfound > f->options.max_undecided + first) {
            report->curve_like = true;
            for (size_t i = 0; i < g[!now].count && status == KN_OK; i++)
                if (!known(f, &g[!now].box[i])) status = keep_box(ctx, f, &g[!now].box[i]);
            break;
        }
    }
    return status;
}

// All the memory of a search but its lists.
static kn_status prepare(kn_ctx *ctx, kn_finder *f, const kn_cells *cells, const kn_solve_options *options)
{
    int m = cells->net.ncomp, n = cells->net.nvars;
    size_t count = cells->net.count, most = (size_t)(m > n ? m : n);
    *f = (kn_finder){.cells = cells, .options = *options, .net = cells->net, .square = cells->net};
    f->square.ncomp = n;
    for (int d = 0; d < n; d++) f->ratio[d] = 1.0;
    size_t work = (size_t)m * count > (size_t)(n + 1) * count ? (size_t)m * count : (size_t)(n + 1) * count;
    f->coef = kn_scratch(ctx, (size_t)m * count, sizeof *f->coef);
    f->work = kn_scratch(ctx, work + 2 * count, sizeof *f->work); // twofold numbers, too
    f->g = kn_scratch(ctx, (size_t)n * count, sizeof *f->g);
    f->error = kn_scratch(ctx, 2 * most, sizeof *f->error);
    f->y = kn_scratch(ctx, (size_t)(m * n), sizeof *f->y);
    if (!f->coef || !f->work || !f->g || !f->error || !f->y) return KN_ENOMEM;
    f->g_error = f->error + most;
    return KN_OK;
}

kn_status kn_cells_solve(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report, kn_cells *cells,
                         const kn_solve_options *options)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_finder f;
    generation g[2] = {{0}};
    kn_solve_report r = {.curve_like = cells->net.ncomp < cells->net.nvars && cells->count > 0};
    kn_status status = prepare(ctx, &f, cells, options);
    if (status == KN_OK) status = generations(ctx, &f, g, &r);
    r.curve_like = r.curve_like && f.nfound > 0;
    if (status == KN_OK) status = kn_finder_gather(ctx, &f, roots, nroots, !r.curve_like);
    if (status == KN_OK && report) {
        for (size_t i = 0; i < *nroots; i++) r.possible += (*roots)[i].kind == KN_ROOT_POSSIBLE;
        *report = r;
    }
    for (int i = 0; i < 2; i++) kn_free(ctx, g[i].box);
    kn_free(ctx, f.found);
    kn_scratch_release(ctx, mark);
    return status;
}
