// SPDX-License-Identifier: Apache-2.0
// Formulas of products of splines: all pieces of each operand by one banded map along each axis, products piece by
// piece on the arrays themselves, and one banded map along each axis back to the minimal knots.
#include "spline/combine.h"

#include <limits.h>
#include <string.h>

#include "kernel/context.h"

kn_status kn_spline_overlap(kn_ctx *ctx, const char *call, double *lo, double *hi, const kn_spline *const *list,
                            int n)
{
    for (int i = 0; i < n; i++) {
        kn_status status = kn_spline_expect(ctx, call, list[i], 0);
        if (status != KN_OK) return status;
        if (list[i]->nvars != list[0]->nvars)
            return kn_fail(ctx, KN_EDOMAIN, "%s: %d and %d variables", call, list[0]->nvars, list[i]->nvars);
    }
    for (int d = 0; d < list[0]->nvars; d++) {
        kn_spline_domain(list[0], d, &lo[d], &hi[d]);
        for (int i = 1; i < n; i++) {
            double from, to;
            kn_spline_domain(list[i], d, &from, &to);
            lo[d] = from > lo[d] ? from : lo[d];
            hi[d] = to < hi[d] ? to : hi[d];
        }
        if (!(lo[d] < hi[d]))
            return kn_fail(ctx, KN_EDOMAIN, "%s: the domains of variable %d do not overlap", call, d);
    }
    return KN_OK;
}

// ---- grids ----
// Lowers continuity[i] to degree - multiplicity at the breaks that are knots of s.
static void lower_continuity(int *continuity, const double *breaks, int nbreaks, const kn_spline *s, int var)
{
    const double *knots = s->knots[var];
    int k = 0, last = s->count[var] + s->degree[var];
    for (int i = 0; i < nbreaks; i++) {
        int times = 0;
        while (k <= last && knots[k] < breaks[i]) k++;
        for (; k <= last && knots[k] == breaks[i]; k++) times++;
        if (times > 0 && s->degree[var] - times < continuity[i]) continuity[i] = s->degree[var] - times;
    }
}

// breaks = lo, the distinct knots of s between, hi. Returns how many.
static int breaks_between(double *breaks, const kn_spline *s, int var, double lo, double hi)
{
    const double *knots = s->knots[var];
    int n = 0;
    breaks[n++] = lo;
    for (int i = s->degree[var]; i <= s->count[var]; i++)
        if (knots[i] > breaks[n - 1] && knots[i] < hi) breaks[n++] = knots[i];
    breaks[n++] = hi;
    return n;
}

kn_status kn_spline_common_breaks(kn_ctx *ctx, kn_grid *grid, int var, const kn_spline *const *list, int n, double lo,
                                  double hi)
{
    double *all = NULL;
    int nall = 0;
    for (int i = 0; i < n; i++) {
        double *own = kn_scratch(ctx, (size_t)list[i]->count[var] + 3, sizeof *own);
        if (!own) return KN_ENOMEM;
        int nown = breaks_between(own, list[i], var, lo, hi), total = kn_knots_union(NULL, all, nall, own, nown);
        if (total == nown) {
            all = own, nall = nown;
        } else if (total > nall) {
            double *both = kn_scratch(ctx, (size_t)total, sizeof *both);
            if (!both) return KN_ENOMEM;
            kn_knots_union(both, all, nall, own, nown);
            all = both, nall = total;
        }
    }
    grid->breaks[var] = all, grid->nbreaks[var] = nall;
    grid->times[var] = kn_scratch(ctx, (size_t)nall, sizeof *grid->times[var]);
    if (!grid->times[var]) return KN_ENOMEM;
    for (int i = 0; i < nall; i++) grid->times[var][i] = INT_MAX;
    for (int i = 0; i < n; i++) lower_continuity(grid->times[var], all, nall, list[i], var);
    return KN_OK;
}

// ---- products ----
enum { MOST = 3 };

typedef struct product {
    int n;
    kn_spline s[MOST], out; // split
    kn_operand operand[MOST];
    kn_chain chain;
    kn_grid grid;
} product;

static void steps_of(size_t *step, const kn_spline *s)
{
    size_t n = 1;
    for (int d = s->nvars - 1; d >= 0; d--) step[d] = n, n *= (size_t)s->count[d];
}

// Where the piece `index` begins in s.
static size_t piece_place(const kn_spline *s, const size_t *step, const int *index)
{
    size_t place = 0;
    for (int d = 0; d < s->nvars; d++) place += (size_t)index[d] * ((size_t)s->degree[d] + 1) * step[d];
    return place;
}

// The operands' pieces, and room for the result's, all in scratch.
static kn_status prepare(kn_ctx *ctx, const char *call, product *w, const kn_formula *f)
{
    const int *degree[MOST];
    int comps[MOST];
    w->out = (kn_spline){.nvars = w->s[0].nvars, .ncomp = f->ncomp, .rational = f->rational};
    for (int i = 0; i < w->n; i++)
        for (int d = 0; d < w->out.nvars; d++) w->out.degree[d] += w->s[i].degree[d];
    kn_status status = kn_spline_pieces_in_scratch(ctx, call, &w->out, &w->grid);
    for (int i = 0; i < w->n && status == KN_OK; i++) status = kn_spline_split_on_grid(ctx, &w->s[i], &w->grid);
    if (status != KN_OK) return status;
    for (int i = 0; i < w->n; i++) {
        kn_operand *o = &w->operand[i];
        const kn_spline *s = &w->s[i];
        o->component = kn_spline_count(s), o->ncomp = s->ncomp, o->unscaled = false;
        o->with_one = kn_formula_wants_one(f, i, s->ncomp);
        steps_of(o->step, s);
        comps[i] = o->ncomp + o->with_one, degree[i] = s->degree;
    }
    return kn_chain_init(ctx, &w->chain, f, w->out.nvars, degree, comps);
}

static void multiply_pieces(product *w)
{
    int index[KN_MAX_VARS] = {0};
    size_t step[KN_MAX_VARS], all = kn_spline_count(&w->out);
    steps_of(step, &w->out);
    do {
        for (int i = 0; i < w->n; i++)
            w->operand[i].coef = w->s[i].coef + piece_place(&w->s[i], w->operand[i].step, index);
        kn_chain_run(&w->chain, w->operand, w->out.coef + piece_place(&w->out, step, index), all, step);
    } while (kn_grid_next(index, &w->grid, w->out.nvars));
}

kn_status kn_spline_multiply(kn_ctx *ctx, const char *call, kn_spline *out, const kn_spline *const *operands,
                             const kn_formula *f)
{
    double lo[KN_MAX_VARS] = {0}, hi[KN_MAX_VARS] = {0};
    product w;
    w.n = f->ninner > 0 ? 3 : 2;
    kn_status status = kn_spline_overlap(ctx, call, lo, hi, operands, w.n);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    int nvars = operands[0]->nvars;
    for (int i = 0; i < w.n; i++) w.s[i] = *operands[i];
    for (int d = 0; d < nvars && status == KN_OK; d++)
        status = kn_spline_common_breaks(ctx, &w.grid, d, operands, w.n, lo[d], hi[d]);
    if (status == KN_OK) status = prepare(ctx, call, &w, f);
    if (status == KN_OK) {
        multiply_pieces(&w);
        for (int d = 0; d < nvars; d++) kn_grid_multiplicities(&w.grid, d, w.out.degree[d]);
        status = kn_spline_join_on_grid(ctx, &w.out, &w.grid);
    }
    if (status == KN_OK) status = kn_spline_store(ctx, out, &w.out); // last: out may be an operand
    kn_scratch_release(ctx, mark);
    return status;
}
