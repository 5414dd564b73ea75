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

// Whether component c depends on variable `axis` alone; its coefficients then go to x[0 .. degree].
static bool depends_on(double *x, const kn_bezier *d, int c, int axis)
{
    size_t n = kn_bezier_count(d), row = (size_t)d->degree[1] + 1;
    for (int i = 0; i <= d->degree[axis]; i++)
        for (int j = 0; j <= d->degree[1 - axis]; j++) {
            size_t at = axis == 0 ? (size_t)i * row + (size_t)j : (size_t)j * row + (size_t)i;
            double value = d->coef[(size_t)c * n + at];
            if (j == 0)
                x[i] = value;
            else if (fabs(value - x[i]) > near_line)
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

// Coordinate c of the row at one end of variable `axis` becomes `line` exactly.
static void put_on_line(kn_bezier *d, int c, int axis, bool at_end, double line)
{
    size_t n = kn_bezier_count(d), row = (size_t)d->degree[1] + 1;
    size_t start = !at_end ? 0 : axis == 0 ? n - row : row - 1, step = axis == 0 ? 1 : row;
    for (int j = 0; j <= d->degree[1 - axis]; j++) d->coef[(size_t)c * n + start + (size_t)j * step] = line;
}

typedef struct builder {
    kn_job *job;
    int part, patch;
    int room;
} builder;

// Moves d into the cell it lies in and appends it. A patch that reaches over a line stays in the tile's own cell if
// it has any part there, and so does a wall along one of the cell's own lines, where n may jump.
static kn_status append(kn_ctx *ctx, builder *b, kn_bezier *d)
{
    kn_job *job = b->job;
    if (job->npatches == b->room) {
        int room = b->room > 0 ? 2 * b->room : 32;
        kn_job_patch *list = kn_resize(ctx, job->patches, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        job->patches = list;
        b->room = room;
    }
    kn_job_patch p = {.part = b->part, .patch = b->patch, .inside = true};
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
    kn_bezier_swap(&p.d, d);
    job->patches[job->npatches++] = p;
    return KN_OK;
}

static kn_status split(kn_ctx *ctx, builder *b, kn_bezier *d, int c, int halvings);

static kn_status split_at(kn_ctx *ctx, builder *b, kn_bezier *d, int c, int axis, double at, const double *line,
                          int halvings)
{
    kn_bezier left = {0}, right = {0};
    kn_status status = kn_bezier_subdivide(ctx, &left, &right, d, axis, at);
    if (status == KN_OK) {
        if (line) put_on_line(&left, c, axis, true, *line);
        if (line) put_on_line(&right, c, axis, false, *line);
        snap(&left);
        snap(&right);
        status = split(ctx, b, &left, c, halvings);
        if (status == KN_OK) status = split(ctx, b, &right, c, halvings);
    }
    kn_bezier_clear(ctx, &left);
    kn_bezier_clear(ctx, &right);
    return status;
}

// Cuts d at the lines that coordinate c crosses, c = u and then c = v, as far as it crosses them isoparametrically.
static kn_status split(kn_ctx *ctx, builder *b, kn_bezier *d, int c, int halvings)
{
    if (c == 2) return append(ctx, b, d);
    double lo, hi, x[KN_MAX_DEGREE + 1];
    range(&lo, &hi, d, c);
    double line = floor(lo) + 1.0;
    int first, axis = depends_on(x, d, c, 0) ? 0 : depends_on(x, d, c, 1) ? 1 : -1;
    if (axis < 0 || line >= hi) return split(ctx, b, d, c + 1, 0);
    int changes = sign_changes(x, d->degree[axis], line, &first);
    if (changes == 1) {
        double at = crossing(x, d->degree[axis], line, first);
        if (at > 0.0 && at < 1.0) return split_at(ctx, b, d, c, axis, at, &line, halvings);
    }
    if (halvings == MAX_HALVINGS) return split(ctx, b, d, c + 1, 0);
    return split_at(ctx, b, d, c, axis, 0.5, NULL, halvings + 1);
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

// w in [0,1] spans the height, on both sides from one end to the other.
static double place_w(const kn_job_options *o, double w)
{
    return o->offset + o->height * (o->side == KN_JOB_BOTH ? 2.0 * w - 1.0 : w);
}

kn_status kn_job_make_patches(kn_ctx *ctx, kn_job *job)
{
    builder b = {.job = job};
    kn_status status = KN_OK;
    for (b.part = 0; status == KN_OK && b.part < job->tile.nparts; b.part++) {
        const kn_tile_part *part = &job->tile.parts[b.part];
        b.patch = 0;
        for (int s = 0; status == KN_OK && s < part->nsplines; s++) {
            kn_bezier *pieces = NULL;
            size_t n = 0;
            status = kn_spline_to_bezier(ctx, &pieces, &n, &part->splines[s]);
            for (size_t i = 0; status == KN_OK && i < n; i++, b.patch++) {
                size_t count = kn_bezier_count(&pieces[i]);
                double *w = pieces[i].coef + 2 * count;
                for (size_t k = 0; k < count; k++) w[k] = place_w(&job->options, w[k]);
                snap(&pieces[i]);
                status = check_reach(ctx, &pieces[i]);
                if (status == KN_OK) status = split(ctx, &b, &pieces[i], 0, 0);
            }
            for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
            kn_free(ctx, pieces);
        }
    }
    return status;
}

int kn_job_tile_degree(const kn_job *job)
{
    int most = 1;
    for (int p = 0; p < job->tile.nparts; p++)
        for (int s = 0; s < job->tile.parts[p].nsplines; s++)
            for (int d = 0; d < 2; d++) {
                int degree = job->tile.parts[p].splines[s].degree[d];
                most = degree > most ? degree : most;
            }
    return most;
}
