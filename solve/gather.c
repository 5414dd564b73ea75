// SPDX-License-Identifier: Apache-2.0
// From what was found in cells to roots of the domain: those on common faces are one.
#include "solve/search.h"

#include "kernel/context.h"

#include <stdlib.h>
#include <string.h>

enum { STEPS = 16 };
static const double STILL = 0x1p-51; // of a cell

// The box of a cell.
static const double *box_of(const kn_finder *f, size_t cell)
{
    return f->cells->box + cell * 2 * (size_t)f->net.nvars;
}

// lo + s (hi - lo) rounds three times, by at most 3u of the larger end; not at all for [0,1].
static double slack(double lo, double hi)
{
    return lo == 0.0 && hi == 1.0 ? 0.0 : 0x1p-51 * fmax(fabs(lo), fabs(hi));
}

static double to_domain(double lo, double hi, double s)
{
    return s == 1.0 ? hi : lo + s * (hi - lo);
}

// An end that is an end of the cell is exact.
kn_root kn_cells_root(const kn_cells *cells, const kn_found *r)
{
    int n = cells->net.nvars;
    const double *box = cells->box + r->cell * 2 * (size_t)n;
    kn_root out = {.kind = r->kind, .least = r->kind == KN_ROOT_UNIQUE, .most = r->kind == KN_ROOT_UNIQUE ? 1 : -1};
    for (int d = 0; d < n; d++) {
        double lo = box[d], hi = box[n + d], more = slack(lo, hi);
        out.lo[d] = to_domain(lo, hi, r->lo[d]) - (r->lo[d] == 0.0 || r->lo[d] == 1.0 ? 0.0 : more);
        out.hi[d] = to_domain(lo, hi, r->hi[d]) + (r->hi[d] == 0.0 || r->hi[d] == 1.0 ? 0.0 : more);
        out.at[d] = fmin(fmax(to_domain(lo, hi, r->at[d]), cells->lo[d]), cells->hi[d]);
        out.at_edge = out.at_edge || out.lo[d] <= cells->lo[d] || out.hi[d] >= cells->hi[d];
    }
    return out;
}

// Reaches a face of its cell that is not on the boundary of the domain.
static bool at_seam(const kn_finder *f, const kn_found *r)
{
    const double *box = box_of(f, r->cell);
    int n = f->net.nvars;
    for (int d = 0; d < n; d++)
        if ((r->lo[d] <= 0.0 && box[d] != f->cells->lo[d]) || (r->hi[d] >= 1.0 && box[n + d] != f->cells->hi[d]))
            return true;
    return false;
}

static bool touch(const kn_root *a, const kn_root *b, int n)
{
    for (int d = 0; d < n; d++)
        if (a->lo[d] > b->hi[d] || b->lo[d] > a->hi[d]) return false;
    return true;
}

// The part of a cell in the box [lo,hi] of the domain, in the cell's parameters; at the boundary of the domain the
// cell goes on. False: none.
static bool part_of(const kn_finder *f, size_t cell, const double *lo, const double *hi, double *s0, double *s1)
{
    const double *box = box_of(f, cell);
    int n = f->net.nvars;
    for (int d = 0; d < n; d++) {
        double width = box[n + d] - box[d];
        s0[d] = (lo[d] - box[d]) / width;
        s1[d] = (hi[d] - box[d]) / width;
        if (box[d] != f->cells->lo[d]) s0[d] = fmax(s0[d], 0.0);
        if (box[n + d] != f->cells->hi[d]) s1[d] = fmin(s1[d], 1.0);
        if (!(s0[d] < s1[d])) return false;
    }
    return true;
}

// max kappa over the parts of all cells in the box, with f->y. Infinite when cells are missing there: only a box that
// is covered lets the mean value theorem go from one cell to the next.
static double kappa_across(kn_finder *f, const double *lo, const double *hi)
{
    int n = f->net.nvars;
    double most = 0.0, covered = 0.0, s0[KN_MAX_VARS], s1[KN_MAX_VARS];
    for (size_t c = 0; c < f->cells->count; c++) {
        const double *box = box_of(f, c);
        double part = 1.0;
        if (!part_of(f, c, lo, hi, s0, s1)) continue;
        for (int d = 0; d < n; d++) {
            f->ratio[d] = (hi[d] - lo[d]) / ((s1[d] - s0[d]) * (box[n + d] - box[d]));
            part /= f->ratio[d];
        }
        covered += part;
        kn_finder_load(f, c, s0, s1);
        kn_finder_combine(f);
        most = fmax(most, kn_finder_kappa(f));
    }
    for (int d = 0; d < n; d++) f->ratio[d] = 1.0;
    return covered > 1.0 - 1e-9 ? most * (1.0 + 1e-9) : INFINITY;
}

// Krawczyk's test in the box [lo,hi] across cells, from the point of r. out: the enclosure.
static bool certain_in(kn_finder *f, const kn_found *r, const double *lo, const double *hi, kn_root *out)
{
    int n = f->net.nvars;
    const double *box = box_of(f, r->cell);
    double at[KN_MAX_VARS], s0[KN_MAX_VARS], s1[KN_MAX_VARS], s[KN_MAX_VARS], radius = 0.0;
    double value[KN_MAX_COMPS], error[KN_MAX_COMPS], jacobian[KN_MAX_COMPS * KN_MAX_VARS];
    if (!part_of(f, r->cell, lo, hi, s0, s1)) return false;
    for (int d = 0; d < n; d++) {
        at[d] = fmin(fmax(r->at[d], box[d] == f->cells->lo[d] ? r->at[d] : 0.0),
                     box[n + d] == f->cells->hi[d] ? r->at[d] : 1.0);
        s[d] = (at[d] - s0[d]) / (s1[d] - s0[d]);
    }
    kn_finder_load(f, r->cell, s0, s1);
    kn_net_jacobian(&f->net, f->coef, s, value, jacobian, f->work);
    for (int d = 0; d < n; d++) // in units of [lo,hi]
        for (int c = 0; c < n; c++)
            jacobian[c * n + d] *= (hi[d] - lo[d]) / ((s1[d] - s0[d]) * (box[n + d] - box[d]));
    if (!kn_left_inverse(f->y, jacobian, n, n)) return false;
    double kappa = kappa_across(f, lo, hi);
    if (!(kappa < 0.8)) return false;
    bool moves = true;
    for (int step = 0; step < STEPS && moves; step++) { // Newton's, inside the cell: boxes start from their middle
        kn_cell_value(f->cells, r->cell, at, value, error, f->work);
        moves = false;
        for (int i = 0; i < n && step < STEPS - 1; i++) {
            double move = 0.0, from = at[i];
            for (int k = 0; k < n; k++) move += f->y[i * n + k] * value[k];
            double to = fmin(fmax(from - move * (hi[i] - lo[i]) / (box[n + i] - box[i]), fmin(from, 0.0)),
                             fmax(from, 1.0));
            if (fabs(to - from) > STILL) at[i] = to, moves = true; // else value is good for this place
        }
    }
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int k = 0; k < n; k++) sum += fabs(f->y[i * n + k]) * (fabs(value[k]) * (1.0 + 0x1p-40) + error[k]);
        radius = fmax(radius, sum);
    }
    radius *= (1.0 + 0x1p-30) / (1.0 - kappa);
    for (int d = 0; d < n; d++) {
        double c = to_domain(box[d], box[n + d], at[d]),
               more = radius * (hi[d] - lo[d]) + 2.0 * slack(box[d], box[n + d]) + 0x1p-52 * fabs(c);
        out->at[d] = fmin(fmax(c, f->cells->lo[d]), f->cells->hi[d]);
        out->lo[d] = c - more;
        out->hi[d] = c + more;
        if (!(out->lo[d] > lo[d] && out->hi[d] < hi[d])) return false;
        out->at_edge = out->at_edge || out->lo[d] <= f->cells->lo[d] || out->hi[d] >= f->cells->hi[d];
    }
    return true;
}

// One root of several that touch on faces of their cells, or a box that may hold any number.
static void join(kn_finder *f, const kn_found *r, kn_root *hull)
{
    int n = f->net.nvars;
    const double *box = box_of(f, r->cell);
    double lo[KN_MAX_VARS], hi[KN_MAX_VARS];
    kn_root one = *hull;
    one.at_edge = false;
    for (double reach = 0x1p-6; reach > 0x1p-40 && f->net.ncomp == n && !f->cells->jumps; reach *= 0x1p-4) {
        for (int d = 0; d < n; d++) {
            double more = reach * (box[n + d] - box[d]) + 2.0 * (hull->hi[d] - hull->lo[d]);
            lo[d] = hull->lo[d] - more;
            hi[d] = hull->hi[d] + more;
        }
        if (!certain_in(f, r, lo, hi, &one)) continue;
        one.kind = KN_ROOT_UNIQUE;
        one.least = one.most = 1;
        *hull = one;
        return;
    }
    hull->kind = KN_ROOT_POSSIBLE;
    hull->least = 0;
    hull->most = -1;
}

static size_t find(size_t *parent, size_t i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

// Groups: boxes that touch, when both are undecided or one lies at a face of its cell.
static void group(const kn_finder *f, const kn_root *roots, const bool *seam, size_t *parent)
{
    for (size_t i = 0; i < f->nfound; i++)
        for (size_t j = 0; j < i; j++) {
            bool both = roots[i].kind == KN_ROOT_POSSIBLE && roots[j].kind == KN_ROOT_POSSIBLE;
            if ((both || seam[i] || seam[j]) && touch(&roots[i], &roots[j], f->net.nvars))
                parent[find(parent, i)] = find(parent, j);
        }
}

static void widen(kn_root *hull, const kn_root *r, int n)
{
    for (int d = 0; d < n; d++) {
        hull->lo[d] = fmin(hull->lo[d], r->lo[d]);
        hull->hi[d] = fmax(hull->hi[d], r->hi[d]);
    }
    hull->at_edge = hull->at_edge || r->at_edge;
}

static int by_place(const void *a, const void *b)
{
    const kn_root *x = a, *y = b;
    for (int d = 0; d < KN_MAX_VARS; d++)
        if (x->lo[d] != y->lo[d]) return x->lo[d] < y->lo[d] ? -1 : 1;
    for (int d = 0; d < KN_MAX_VARS; d++)
        if (x->hi[d] != y->hi[d]) return x->hi[d] < y->hi[d] ? -1 : 1;
    return 0;
}

// An undecided box inside the surroundings of a root that is certain holds that one or none.
static bool spurious(const kn_finder *f, const kn_found *p)
{
    for (size_t i = 0; i < f->nfound && p->kind == KN_ROOT_POSSIBLE; i++) {
        const kn_found *r = &f->found[i];
        bool in = r->kind == KN_ROOT_UNIQUE && r->cell == p->cell;
        for (int d = 0; d < f->net.nvars && in; d++) in = r->around_lo[d] <= p->lo[d] && p->hi[d] <= r->around_hi[d];
        if (in) return true;
    }
    return false;
}

static size_t joined(kn_finder *f, kn_root *roots, bool *seam, size_t *parent)
{
    size_t n = 0;
    for (size_t i = 0; i < f->nfound; i++) seam[i] = at_seam(f, &f->found[i]), parent[i] = i;
    group(f, roots, seam, parent);
    for (size_t i = 0; i < f->nfound; i++) parent[i] = find(parent, i);
    for (size_t i = 0; i < f->nfound; i++) { // the first of a group stands for it
        size_t id = parent[i], members = 0, certain = i;
        bool faces = false;
        if (id == f->nfound) continue; // has been taken
        for (size_t j = i; j < f->nfound; j++) {
            if (parent[j] != id) continue;
            if (members++ > 0) widen(&roots[i], &roots[j], f->net.nvars);
            faces = faces || seam[j];
            if (f->found[certain].kind != KN_ROOT_UNIQUE && f->found[j].kind == KN_ROOT_UNIQUE) certain = j;
            parent[j] = f->nfound;
        }
        kn_root out = roots[i];
        for (int d = 0; d < f->net.nvars && members > 1; d++)
            out.at[d] = fmin(fmax(0.5 * out.lo[d] + 0.5 * out.hi[d], f->cells->lo[d]), f->cells->hi[d]);
        if (faces || members > 1) join(f, &f->found[certain], &out);
        roots[n++] = out;
    }
    return n;
}

kn_status kn_finder_gather(kn_ctx *ctx, kn_finder *f, kn_root **roots, size_t *nroots, bool merge)
{
    size_t n = 0;
    for (size_t i = 0; i < f->nfound; i++)
        if (!spurious(f, &f->found[i])) f->found[n++] = f->found[i];
    f->nfound = n;
    kn_root *out = kn_alloc(ctx, n, sizeof *out);
    size_t *parent = kn_scratch(ctx, n + 1, sizeof *parent);
    bool *seam = kn_scratch(ctx, n + 1, sizeof *seam);
    if (!out || !parent || !seam) {
        kn_free(ctx, out);
        return KN_ENOMEM;
    }
    for (size_t i = 0; i < n; i++) out[i] = kn_cells_root(f->cells, &f->found[i]);
    if (merge) n = joined(f, out, seam, parent);
    qsort(out, n, sizeof *out, by_place);
    *roots = out;
    *nroots = n;
    return KN_OK;
}
