// SPDX-License-Identifier: Apache-2.0
// The Bezier patches of a placed tile, cut where cell lines cross them isoparametrically.
#include "job/internal.h"
#include "kernel/bernstein.h"

#include <math.h>

// Coordinates this near to a cell line lie on it: 1e-13 of a cell is a few roundings of numbers near 1.
static const double near_line = 1e-13;

enum { MAX_HALVINGS = 6 };

static void snap(kn_bezier *d)
{
    size_t n = 2 * kn_bezier_count(d);
    for (size_t i = 0; i < n; i++) {
        double line = round(d->coef[i]);
        if (fabs(d->coef[i] - line) <= near_line) d->coef[i] = line;
    }
}

static void range(double *lo, double *hi, const kn_bezier *d, int c)
{
    size_t n = kn_bezier_count(d);
    const double *x = d->coef + (size_t)c * n;
    *lo = *hi = x[0];
    for (size_t i = 1; i < n; i++) {
        *lo = fmin(*lo, x[i]);
        *hi = fmax(*hi, x[i]);
    }
}

// Coefficients of d: flat index = (before * (degree[axis] + 1) + k) * after + rest.
static void strides(size_t *before, size_t *after, const kn_bezier *d, int axis)
{
    *before = *after = 1;
    for (int v = 0; v < d->nvars; v++)
        if (v != axis) *(v < axis ? before : after) *= (size_t)d->degree[v] + 1;
}

// Whether component c depends on variable `axis` alone; its coefficients then go to x[0 .. degree].
static bool depends_on(double *x, const kn_bezier *d, int c, int axis)
{
    size_t n = kn_bezier_count(d), row = (size_t)d->degree[axis] + 1, before, after;
    strides(&before, &after, d, axis);
    for (size_t i = 0; i < n; i++) {
        double value = d->coef[(size_t)c * n + i];
        size_t k = i / after % row;
        if (i % after == 0 && i / (after * row) == 0)
            x[k] = value;
        else if (fabs(value - x[k]) > near_line)
            return false;
    }
    return true;
}

// Changes of sign in x - line, zeros left out; *first is the sign of the first nonzero one.
static int sign_changes(const double *x, int degree, double line, int *first)
{
    int changes = 0, last = 0;
    *first = 0;
    for (int i = 0; i <= degree; i++) {
        int sign = (x[i] > line) - (x[i] < line);
        if (sign == 0) continue;
        if (*first == 0) *first = sign;
        changes += last != 0 && sign != last;
        last = sign;
    }
    return changes;
}

// The root of x - line, which has one change of sign and hence one root inside: bisection until the ends are
// neighbours.
static double crossing(const double *x, int degree, double line, int first)
{
    double lo = 0.0, hi = 1.0, basis[KN_MAX_DEGREE + 1], shifted[KN_MAX_DEGREE + 1];
    for (int i = 0; i <= degree; i++) shifted[i] = x[i] - line;
    for (;;) {
        double middle = lo + (hi - lo) / 2.0, value;
        if (middle <= lo || middle >= hi) return middle;
        kn_bernstein_basis(basis, degree, middle);
        kn_bernstein_contract(&value, shifted, 1, degree + 1, 1, basis);
        if (value == 0.0) return middle;
        if ((value > 0.0) == (first > 0))
            lo = middle;
        else
            hi = middle;
    }
}

// Coordinate c of the coefficients at one end of variable `axis` becomes `line` exactly.
static void put_on_line(kn_bezier *d, int c, int axis, bool at_end, double line)
{
    size_t n = kn_bezier_count(d), row = (size_t)d->degree[axis] + 1, before, after;
    strides(&before, &after, d, axis);
    for (size_t i = 0; i < before; i++)
        for (size_t j = 0; j < after; j++)
            d->coef[(size_t)c * n + (i * row + (at_end ? row - 1 : 0)) * after + j] = line;
}

// What is left of one Bezier patch of the tile.
typedef struct fragment {
    kn_bezier d;
    double lo[KN_JOB_VARS], hi[KN_JOB_VARS]; // of the Bezier patch's [0,1]^n
} fragment;

typedef struct builder {
    const kn_job_change *change;
    kn_job_patches *out;
    int part, spline, patch, bezier;
} builder;

static kn_status reserve(kn_ctx *ctx, kn_job_patches *out)
{
    if (out->n < out->room) return KN_OK;
    int room = out->room > 0 ? 2 * out->room : 32;
    kn_job_patch *list = kn_resize(ctx, out->list, (size_t)room, sizeof *list);
    if (!list) return KN_ENOMEM;
    out->list = list;
    out->room = room;
    return KN_OK;
}

// Moves the fragment into the cell it lies in and appends it. One that reaches over a line stays in the tile's own
// cell if it has any part there, and so does a wall along one of the cell's own lines, where n may jump.
static kn_status append(kn_ctx *ctx, builder *b, fragment *f)
{
    kn_status status = reserve(ctx, b->out);
    if (status != KN_OK) return status;
    kn_job_patch p = {.part = b->part, .spline = b->spline, .patch = b->patch, .bezier = b->bezier, .inside = true};
    kn_bezier *d = &f->d;
    size_t n = kn_bezier_count(d);
    double lo, hi;
    for (int c = 0; c < 2; c++) {
        range(&lo, &hi, d, c);
        if ((hi <= 0.0 && lo < 0.0) || (lo >= 1.0 && hi > 1.0)) p.offset[c] = (int)floor(lo + (hi - lo) / 2.0);
        for (size_t i = 0; i < n; i++) d->coef[(size_t)c * n + i] -= p.offset[c];
        range(&lo, &hi, d, c);
        p.inside = p.inside && lo >= 0.0 && hi <= 1.0;
    }
    range(&lo, &hi, d, 2);
    p.top = fmax(fabs(lo), fabs(hi));
    for (int v = 0; v < d->nvars; v++) p.lo[v] = f->lo[v], p.hi[v] = f->hi[v];
    kn_bezier_swap(&p.d, d);
    b->out->list[b->out->n++] = p;
    return KN_OK;
}

static kn_status split(kn_ctx *ctx, builder *b, fragment *f, int c, int halvings);

static kn_status split_at(kn_ctx *ctx, builder *b, const fragment *f, int c, int axis, double at, const double *line,
                          int halvings)
{
    fragment left = *f, right = *f;
    left.d = right.d = (kn_bezier){0};
    left.hi[axis] = right.lo[axis] = f->lo[axis] + at * (f->hi[axis] - f->lo[axis]);
    kn_status status = kn_bezier_subdivide(ctx, &left.d, &right.d, &f->d, axis, at);
    if (status == KN_OK) {
        if (line) put_on_line(&left.d, c, axis, true, *line);
        if (line) put_on_line(&right.d, c, axis, false, *line);
        snap(&left.d);
        snap(&right.d);
        status = split(ctx, b, &left, c, halvings);
        if (status == KN_OK) status = split(ctx, b, &right, c, halvings);
    }
    kn_bezier_clear(ctx, &left.d);
    kn_bezier_clear(ctx, &right.d);
    return status;
}

// The first line above lo.
static double next_line(const builder *b, int c, double lo)
{
    double line = floor(lo) + 1.0;
    for (int k = 0; b->change && k < b->change->ncuts[c]; k++) {
        double x = floor(lo) + b->change->cuts[c][k];
        line = fmin(line, x > lo ? x : x + 1.0);
    }
    return line;
}

// Cuts f at the lines that coordinate c crosses, c = u and then c = v, as far as it crosses them isoparametrically.
static kn_status split(kn_ctx *ctx, builder *b, fragment *f, int c, int halvings)
{
    if (c == 2) return append(ctx, b, f);
    const kn_bezier *d = &f->d;
    double lo, hi, x[KN_MAX_DEGREE + 1];
    range(&lo, &hi, d, c);
    double line = next_line(b, c, lo);
    int first, axis = -1;
    for (int v = d->nvars - 1; v >= 0; v--)
        if (depends_on(x, d, c, v)) axis = v;
    if (axis < 0 || line >= hi) return split(ctx, b, f, c + 1, 0);
    (void)depends_on(x, d, c, axis);
    int changes = sign_changes(x, d->degree[axis], line, &first);
    if (changes == 1) {
        double at = crossing(x, d->degree[axis], line, first);
        if (at > 0.0 && at < 1.0) return split_at(ctx, b, f, c, axis, at, &line, halvings);
    }
    if (halvings == MAX_HALVINGS) return split(ctx, b, f, c + 1, 0);
    return split_at(ctx, b, f, c, axis, 0.5, NULL, halvings + 1);
}

// Lines are counted one by one and in ints, and cut recursively.
static kn_status check_reach(kn_ctx *ctx, const kn_bezier *d)
{
    for (int c = 0; c < 2; c++) {
        double lo, hi;
        range(&lo, &hi, d, c);
        if (lo < -KN_JOB_MAX_REACH || hi > KN_JOB_MAX_REACH + 1)
            return kn_fail(ctx, KN_ELIMIT, "job: the tile reaches from %g to %g cells, more than %d beyond its own",
                           lo, hi, KN_JOB_MAX_REACH);
    }
    return KN_OK;
}

// On both sides from one end to the other.
double kn_job_place_w(const kn_job_options *o, double w)
{
    return o->offset + o->height * (o->side == KN_JOB_BOTH ? 2.0 * w - 1.0 : w);
}

static kn_status cut_bezier(kn_ctx *ctx, builder *b, kn_bezier *d, const kn_tile *tile, const kn_job_options *o,
                            const kn_job_change *change)
{
    fragment f = {.hi = {1.0, 1.0, 1.0}};
    size_t n = kn_bezier_count(d);
    double *w = d->coef + 2 * n;
    for (size_t k = 0; k < n; k++) w[k] = kn_job_place_w(o, w[k]);
    kn_status status = change ? change->apply(ctx, change->user, d, tile, b->part, b->spline, b->patch) : KN_OK;
    if (status != KN_OK) return status;
    snap(d);
    status = check_reach(ctx, d);
    kn_bezier_swap(&f.d, d);
    if (status == KN_OK) status = split(ctx, b, &f, 0, 0);
    kn_bezier_clear(ctx, &f.d);
    return status;
}

static kn_status cut_spline(kn_ctx *ctx, builder *b, const kn_tile *tile, const kn_job_options *o,
                            const kn_job_change *change)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, &tile->parts[b->part].splines[b->spline]);
    for (size_t i = 0; status == KN_OK && i < n; i++, b->patch++, b->bezier++)
        status = cut_bezier(ctx, b, &pieces[i], tile, o, change);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    return status;
}

kn_status kn_job_cut_patches(kn_ctx *ctx, kn_job_patches *out, const kn_tile *tile, const kn_job_options *options,
                             const kn_job_change *change)
{
    builder b = {.out = out, .change = change};
    kn_status status = KN_OK;
    int before = out->n;
    for (b.part = 0; status == KN_OK && b.part < tile->nparts; b.part++) {
        b.patch = 0;
        for (b.spline = 0; status == KN_OK && b.spline < tile->parts[b.part].nsplines; b.spline++)
            status = cut_spline(ctx, &b, tile, options, change);
    }
    if (status == KN_OK) status = kn_job_cover_faces(ctx, out, before);
    while (status != KN_OK && out->n > before) kn_bezier_clear(ctx, &out->list[--out->n].d);
    return status;
}

void kn_job_patches_clear(kn_ctx *ctx, kn_job_patches *patches)
{
    for (int k = 0; k < patches->n; k++) kn_bezier_clear(ctx, &patches->list[k].d);
    kn_free(ctx, patches->list);
    *patches = (kn_job_patches){0};
}

kn_status kn_job_make_patches(kn_ctx *ctx, kn_job *job)
{
    kn_job_patches made = {0};
    kn_status status = kn_job_cut_patches(ctx, &made, &job->tile, &job->options, NULL);
    job->patches = made.list;
    job->npatches = made.n;
    if (status == KN_OK && !(job->variants = kn_alloc(ctx, 1, sizeof *job->variants))) status = KN_ENOMEM;
    if (status != KN_OK) return status;
    job->variants[job->nvariants++] = (kn_job_variant){0, made.n};
    return KN_OK;
}

int kn_job_bezier_patches(const kn_spline *s)
{
    int n = 1;
    for (int d = 0; d < s->nvars; d++) n *= kn_spline_spans(s, d);
    return n;
}

int kn_job_tile_degree(const kn_job *job)
{
    int most = 1;
    for (int p = 0; p < job->tile.nparts; p++)
        for (int s = 0; s < job->tile.parts[p].nsplines; s++) {
            const kn_spline *spline = &job->tile.parts[p].splines[s];
            for (int d = 0; d < spline->nvars; d++) most = spline->degree[d] > most ? spline->degree[d] : most;
        }
    return most;
}
