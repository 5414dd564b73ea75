// SPDX-License-Identifier: Apache-2.0
// Pieces of any degree as splines of limited degree, within a certified tolerance: for receivers that end at degree
// 25, 15, 11 or 3.
//
// Along each variable a linear map keeps values and first derivatives at the ends of equal spans. So what becomes of
// an edge depends on the edge alone, what becomes of the first derivative across it on that derivative alone, and
// pieces that join C1 do so still where they have as many spans. An edge has no more spans than it needs by itself;
// where the inside needs more, the edge of the inside is replaced by it, with knots inserted, and the row beside it
// moves along, so that the derivative across stays.
#include "fit/limit.h"

#include <math.h>
#include <string.h>

#include "bezier/shape.h"
#include "kernel/bernstein.h"

enum { MOST_LEVEL = 10 };
static const double MOST_ANGLE = 0.8; // radians
static const double TILT_SHARE = 0.5; // what an edge's own tangents may take of the angle

typedef kn_limit_fit fit;

static size_t comps(const fit *f)
{
    return (size_t)f->a->ncomp;
}

// ---- the map, axis by axis ----

typedef size_t axis_size(const kn_limit_axis *x);
static size_t from_size(const kn_limit_axis *x)
{
    return (size_t)x->from + 1;
}
static size_t from_apart(const kn_limit_axis *x)
{
    return from_size(x) << x->level;
}

// Numbers of one component when axes before `var` have the size `after`, and the others `before`.
static void sizes(const fit *f, int var, axis_size *before, axis_size *after, size_t *outer, size_t *inner)
{
    *outer = comps(f), *inner = 1;
    for (int v = 0; v < f->a->nvars; v++) {
        if (v < var) *outer *= after(&f->axis[v]);
        if (v > var) *inner *= before(&f->axis[v]);
    }
}

static kn_status fitted(kn_ctx *ctx, double *out, const double *in, size_t outer, const kn_limit_axis *x,
                        size_t inner)
{
    double *matrix;
    kn_status status = kn_limit_matrix(ctx, &matrix, x);
    if (status == KN_OK) kn_bernstein_transform(out, in, outer, (int)kn_limit_count(x), x->from + 1, inner, matrix);
    return status;
}

static kn_status spread(kn_ctx *ctx, double *out, const double *in, size_t outer, const kn_limit_axis *x,
                        size_t inner)
{
    (void)ctx;
    kn_limit_spread(out, in, outer, x, inner);
    return KN_OK;
}

// *out, in scratch: `in` mapped along every axis on which anything changes.
static kn_status along_axes(kn_ctx *ctx, double **out, const double *in, const fit *f, axis_size *before,
                            axis_size *after, bool (*idle)(const kn_limit_axis *x),
                            kn_status (*map)(kn_ctx *, double *, const double *, size_t, const kn_limit_axis *,
                                             size_t))
{
    size_t outer, inner, all = comps(f);
    for (int v = 0; v < f->a->nvars; v++) all *= before(&f->axis[v]);
    *out = kn_scratch(ctx, all, sizeof **out);
    if (!*out) return KN_ENOMEM;
    memcpy(*out, in, all * sizeof **out);
    for (int v = 0; v < f->a->nvars; v++) {
        const kn_limit_axis *x = &f->axis[v];
        if (idle(x)) continue;
        sizes(f, v, before, after, &outer, &inner);
        double *next = kn_scratch(ctx, outer * after(x) * inner, sizeof *next);
        if (!next) return KN_ENOMEM;
        kn_status status = map(ctx, next, *out, outer, x, inner);
        if (status != KN_OK) return status;
        *out = next;
    }
    return KN_OK;
}

static bool is_kept(const kn_limit_axis *x)
{
    return x->from == x->to;
}
static bool is_one_span(const kn_limit_axis *x)
{
    return x->level == 0;
}

// ---- the certificate ----

// out (ncomp, size..) = the block of in (ncomp, of..) that begins at `at`.
static void block(double *out, const double *in, size_t ncomp, int nvars, const size_t *of, const size_t *at,
                  const size_t *size)
{
    size_t stride = 1, run = nvars > 0 ? size[nvars - 1] : 1, rows = ncomp;
    for (int v = 0; v < nvars; v++) {
        stride *= of[v];
        if (v < nvars - 1) rows *= size[v];
    }
    for (size_t r = 0; r < rows; r++) {
        size_t rest = r, place = 0, step = of[nvars - 1];
        for (int v = nvars - 2; v >= 0; v--) {
            place += (at[v] + rest % size[v]) * step;
            rest /= size[v];
            step *= of[v];
        }
        memcpy(out + r * run, in + rest * stride + place + at[nvars - 1], run * sizeof *out);
    }
}

// f->error = a bound over the span at place `span`: the largest coefficient, or a closer one where that is above
// `enough`, and not far above `most`. mine and theirs: all spans apart, of the fit and of the piece.
static kn_status compare_spans(kn_ctx *ctx, fit *f, double *least, double enough, double most, const double *mine,
                               const double *theirs, const size_t *span)
{
    const kn_bezier *a = f->a;
    size_t of[2][KN_MAX_VARS], at[2][KN_MAX_VARS], size[2][KN_MAX_VARS], all = comps(f);
    double steps = 4.0;
    for (int v = 0; v < a->nvars; v++) {
        const kn_limit_axis *x = &f->axis[v];
        size[0][v] = (size_t)x->to + 1, size[1][v] = from_size(x);
        of[0][v] = kn_limit_apart(x), of[1][v] = from_apart(x);
        for (int k = 0; k < 2; k++) at[k][v] = span[v] * size[k][v];
        all *= size[1][v];
        steps += x->level > 0 ? 5.0 * x->from + 2.0 : 0.0;
        steps += is_kept(x) ? 0.0 : fmin(x->from - x->to, x->to) + 3.0;
    }
    double *p = kn_scratch(ctx, all, sizeof *p), *q = kn_scratch(ctx, all, sizeof *q);
    kn_bezier d = *a;
    d.coef = kn_scratch(ctx, all, sizeof *d.coef);
    if (!p || !q || !d.coef) return KN_ENOMEM;
    block(p, theirs, comps(f), a->nvars, of[1], at[1], size[1]);
    block(q, mine, comps(f), a->nvars, of[0], at[0], size[0]);
    size_t outer = comps(f), n = all / comps(f), low = 1;
    for (int v = 0; v < a->nvars; v++) low *= size[0][v];
    kn_parts rounding = {kn_gamma_up(steps) * f->rough.coordinate, kn_gamma_up(steps) * f->rough.weight};
    kn_parts_add(&rounding, kn_gamma_up(steps), q, low, a->ncomp, a->rational); // no larger where it is raised
    for (int v = 0; v < a->nvars; v++) {                                        // q raised to the piece's degrees
        const kn_limit_axis *x = &f->axis[v];
        size_t inner = 1;
        for (int w = v + 1; w < a->nvars; w++) inner *= size[0][w];
        if (!is_kept(x)) {
            double *next = kn_scratch(ctx, outer * size[1][v] * inner, sizeof *next);
            if (!next) return KN_ENOMEM;
            kn_bernstein_elevate(next, q, outer, x->to, x->from, inner);
            q = next;
        }
        outer *= size[1][v];
    }
    for (size_t i = 0; i < all; i++) d.coef[i] = p[i] - q[i];
    kn_deviation deviation;
    if (!kn_deviation_of(&deviation, d.coef, n, a->ncomp, a->rational, p, n, q, n)) {
        f->error = INFINITY;
        return KN_OK;
    }
    int dim = a->ncomp - (deviation.radius >= 0.0);
    double bound = kn_round_up(kn_round_up(kn_largest_vector(&d, 0, dim)));
    if (dim < a->ncomp) bound += deviation.radius * kn_largest_vector(&d, dim, 1);
    double plain = kn_deviation_bound(&deviation, kn_round_up(bound), &rounding, a->ncomp);
    kn_status status = KN_OK;
    if (plain > enough && plain <= 4.0 * most) {
        bound = 0.0;
        status = kn_bezier_norm_bound(ctx, &bound, least, &d, deviation.radius);
        plain = kn_deviation_bound(&deviation, bound, &rounding, a->ncomp);
    }
    f->error = plain;
    return status;
}

// f->error = an upper bound of the distance between fit and piece, parameter by parameter. What is below `enough` is
// not looked at more closely, and nothing more where one span is above `most`.
static kn_status certify(kn_ctx *ctx, fit *f, double enough, double most)
{
    enum { MOST = 1 << 25 }; // numbers that are held at once
    double *mine = NULL, least = 0.8 * enough;
    size_t spans = 1, numbers = comps(f);
    for (int v = 0; v < f->a->nvars; v++) {
        size_t more = from_apart(&f->axis[v]);
        if (numbers > MOST / more)
            return kn_fail(ctx, KN_ELIMIT, "limits: a piece takes more than %d coefficients on its spans", MOST);
        numbers *= more;
    }
    kn_status status = KN_OK;
    if (!f->spans)
        status = along_axes(ctx, &f->spans, f->a->coef, f, from_size, from_apart, is_one_span, kn_limit_restrict);
    kn_mark mark = kn_scratch_mark(ctx);
    if (status == KN_OK)
        status = along_axes(ctx, &mine, f->coef, f, kn_limit_count, kn_limit_apart, is_one_span, spread);
    for (int v = 0; v < f->a->nvars; v++) spans <<= f->axis[v].level;
    double error = 0.0;
    size_t first = f->worst < spans ? f->worst : 0; // which tells how closely the others need to be looked at
    for (size_t i = 0; i < spans && status == KN_OK && error <= most; i++) {
        size_t s = (first + i) % spans, rest = s, span[KN_MAX_VARS];
        for (int v = f->a->nvars - 1; v >= 0; v--) {
            span[v] = rest & (((size_t)1 << f->axis[v].level) - 1);
            rest >>= f->axis[v].level;
        }
        kn_mark inner = kn_scratch_mark(ctx);
        status = compare_spans(ctx, f, &least, enough, most, mine, f->spans, span);
        kn_scratch_release(ctx, inner);
        if (!(f->error <= error)) error = f->error, f->worst = s;
    }
    f->error = error;
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- fits ----

// Whether the curve's derivative at an end is no more than rounding.
static bool stands(const fit *f, bool last)
{
    size_t n = (size_t)f->axis[0].from + 1, end = last ? n - 1 : 0, next = last ? n - 2 : 1;
    double most = 0.0;
    for (size_t c = 0; c < comps(f); c++) most = fmax(most, fabs(f->a->coef[c * n + next] - f->a->coef[c * n + end]));
    return most <= kn_gamma_up(26.0 * (double)n) * f->rough.coordinate;
}

// A curve onto the multiples of the quantum: then inserting knots halfway is exact, whatever side of an edge does it.
// Not its ends, nor a curve of low degree: these belong to neighbours, too, of which nothing may be limited.
static void round_off(const fit *f)
{
    double q = f->limits->quantum;
    size_t n = kn_limit_count(&f->axis[0]);
    if (q == 0.0 || f->a->nvars > 1 || f->a->rational || is_kept(&f->axis[0])) return;
    for (size_t c = 0; c < comps(f); c++)
        for (size_t i = 1; i < n - 1; i++) f->coef[c * n + i] = rint(f->coef[c * n + i] / q) * q;
    // A curve that sets out at no speed does so still, and in its direction: one point then, which halves exactly.
    for (int k = 0; k < 2; k++) {
        if (!stands(f, k)) continue;
        size_t end = k ? n - 1 : 0, next = k ? n - 2 : 1;
        for (size_t c = 0; c < comps(f); c++) f->coef[c * n + next] = f->coef[c * n + end];
    }
}

// Fits and certifies with the axes as they are, to below `most` or not; edges: NULL, or to be put in place.
static kn_status build(kn_ctx *ctx, fit *f, const kn_limit_edge *edges, double most)
{
    f->spans = NULL;
    kn_status status = along_axes(ctx, &f->coef, f->a->coef, f, from_size, kn_limit_count, is_kept, fitted);
    if (status != KN_OK) return status;
    round_off(f);
    if (edges) status = kn_limit_put_edges(ctx, f->coef, comps(f), f->axis, edges);
    return status == KN_OK ? certify(ctx, f, most, most) : status;
}

// More spans: as many as an error that falls by 2^(p + 1) at each halving lets expect, to get below `wanted`.
static kn_status halve(kn_ctx *ctx, const fit *f, kn_limit_axis *x, double error, double wanted)
{
    int most = f->limits->max_level, more = isfinite(error) ? (int)(log2(error / wanted) / (x->to + 1)) : 1;
    if (x->level < most && !is_kept(x)) {
        x->level += more < 1 ? 1 : more;
        if (x->level > most) x->level = most;
        return KN_OK;
    }
    return kn_fail(ctx, KN_EUNDECIDED, "limit_degree: not within %g of degree %d by degree %d on %d spans",
                   f->limits->tolerance, x->from, x->to, 1 << x->level);
}

// *error: with variable var alone fitted; not looked at closely where it is below `share`.
static kn_status try_axis(kn_ctx *ctx, double *error, const fit *f, int var, double share)
{
    fit alone = *f;
    for (int v = 0; v < f->a->nvars; v++)
        if (v != var) alone.axis[v] = (kn_limit_axis){f->axis[v].from, f->axis[v].from, 0};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = build(ctx, &alone, NULL, share);
    kn_scratch_release(ctx, mark);
    *error = alone.error;
    return status;
}

// The fewest spans of each axis alone within its share, then more where that is not enough together. f->coef lies in
// scratch.
static kn_status search(kn_ctx *ctx, fit *f, const kn_limit_edge *edges)
{
    int axes = 0;
    double share = f->limits->tolerance, alone[KN_MAX_VARS] = {0.0};
    kn_status status = KN_OK;
    for (int v = 0; v < f->a->nvars; v++) axes += !is_kept(&f->axis[v]);
    if (axes > 1) share *= 0.8 / axes;
    for (int v = 0; v < f->a->nvars && axes > 1; v++)
        while (!is_kept(&f->axis[v]) && status == KN_OK) {
            status = try_axis(ctx, &alone[v], f, v, share);
            if (status != KN_OK || alone[v] <= share) break;
            status = halve(ctx, f, &f->axis[v], alone[v], share);
        }
    while (status == KN_OK) {
        kn_mark mark = kn_scratch_mark(ctx);
        status = build(ctx, f, edges, f->limits->tolerance);
        if (status != KN_OK || f->error <= f->limits->tolerance) return status;
        kn_scratch_release(ctx, mark);
        int worst = 0;
        for (int v = 1; v < f->a->nvars; v++)
            if (is_kept(&f->axis[worst]) || (!is_kept(&f->axis[v]) && alone[v] > alone[worst])) worst = v;
        status = halve(ctx, f, &f->axis[worst], f->error, f->limits->tolerance);
        if (status == KN_OK && axes > 1) status = try_axis(ctx, &alone[worst], f, worst, share);
    }
    return status;
}

// The same, but where that takes too many spans, within `most` from the levels that there were.
static kn_status search_within(kn_ctx *ctx, fit *f, const kn_limit_edge *edges, kn_fit_limits *limits, double most)
{
    const fit before = *f;
    kn_status status = search(ctx, f, edges);
    if (status != KN_EUNDECIDED || !(limits->tolerance < most)) return status;
    kn_ctx_clear_error(ctx);
    *f = before;
    limits->tolerance = most;
    return search(ctx, f, edges);
}

static void begin(fit *f, const kn_bezier *a, const kn_fit_limits *limits)
{
    *f = (fit){.a = a, .limits = limits};
    kn_parts_add(&f->rough, 1.0, a->coef, kn_bezier_count(a), a->ncomp, a->rational);
    for (int v = 0; v < a->nvars; v++) {
        int d = a->degree[v];
        f->axis[v] = (kn_limit_axis){d, d > limits->max_degree ? limits->degree : d, 0};
    }
}

// ---- edges of surfaces ----

static bool is_in_space(const kn_bezier *a)
{
    return a->nvars == 2 && a->ncomp == 3 + a->rational;
}

// curve = the edge of a where variable var ends, in scratch, run through in the direction that its control points
// choose: the same for both of its neighbours. *turned: against the surface's.
static kn_status take_edge(kn_ctx *ctx, kn_bezier *curve, bool *turned, const kn_bezier *a, int var, bool at_end)
{
    size_t n[2] = {(size_t)a->degree[0] + 1, (size_t)a->degree[1] + 1}, m = n[1 - var];
    size_t step = var == 0 ? 1 : n[1], first = at_end ? (n[var] - 1) * (var == 0 ? n[1] : 1) : 0;
    *curve = (kn_bezier){.nvars = 1, .ncomp = a->ncomp, .rational = a->rational, .degree = {a->degree[1 - var]}};
    curve->coef = kn_scratch(ctx, m * (size_t)a->ncomp, sizeof *curve->coef);
    if (!curve->coef) return KN_ENOMEM;
    int order = 0;
    for (size_t i = 0; i < m && order == 0; i++)
        for (size_t c = 0; c < (size_t)a->ncomp && order == 0; c++) {
            const double *at = a->coef + c * n[0] * n[1] + first;
            order = (at[i * step] > at[(m - 1 - i) * step]) - (at[i * step] < at[(m - 1 - i) * step]);
        }
    *turned = order > 0;
    for (size_t c = 0; c < (size_t)a->ncomp; c++)
        for (size_t i = 0; i < m; i++)
            curve->coef[c * m + i] = a->coef[c * n[0] * n[1] + first + (*turned ? m - 1 - i : i) * step];
    return KN_OK;
}

// More spans until the tangents, too, are as the angle wants them.
static kn_status straighten(kn_ctx *ctx, fit *along)
{
    double share = TILT_SHARE * along->limits->angle, tilt = INFINITY, last = INFINITY;
    kn_limit_axis *x = &along->axis[0];
    kn_status status = KN_OK;
    for (int idle = 0; !is_kept(x) && share > 0.0 && status == KN_OK; last = tilt) {
        status = kn_limit_tilt(ctx, &tilt, along);
        idle = tilt < 0.5 * last ? 0 : idle + 1;
        if (status != KN_OK || tilt <= share || idle > 2) break;
        if (x->level >= KN_ANGLE_LEVEL || x->level >= along->limits->max_level) break;
        const fit before = *along;
        x->level++;
        status = search(ctx, along, NULL);
        if (status != KN_EUNDECIDED) continue;
        kn_ctx_clear_error(ctx);
        *along = before;
        return KN_OK;
    }
    return status;
}

// From the edge alone: its size and its tangents, too, are the same for both neighbours.
static kn_status fit_edge(kn_ctx *ctx, kn_limit_edge *edge, const fit *f, int e)
{
    kn_fit_limits limits = *f->limits;
    kn_bezier curve;
    fit along;
    limits.tolerance *= 0.25;
    kn_status status = take_edge(ctx, &curve, &edge->turned, f->a, e / 2, e % 2);
    if (status != KN_OK) return status;
    kn_limit_narrow(&limits, &edge->size, &curve);
    begin(&along, &curve, &limits);
    status = search_within(ctx, &along, NULL, &limits, 0.25 * f->limits->tolerance);
    if (status == KN_OK && edge->size > 0.0) status = straighten(ctx, &along);
    edge->axis = along.axis[0], edge->coef = along.coef, edge->error = along.error;
    return status;
}

// And what they ask of the surface: spans along them, and a tolerance that is a part of the shortest.
static kn_status fit_edges(kn_ctx *ctx, kn_limit_edge edges[4], fit *f, kn_fit_limits *limits)
{
    kn_status status = KN_OK;
    double least = INFINITY, error = 0.0;
    for (int e = 0; e < 4 && status == KN_OK; e++) {
        kn_limit_axis *along = &f->axis[1 - e / 2];
        status = fit_edge(ctx, &edges[e], f, e);
        if (edges[e].axis.level > along->level) along->level = edges[e].axis.level;
        if (edges[e].size > 0.0) least = fmin(least, edges[e].size);
        error = fmax(error, edges[e].error);
    }
    limits->tolerance = fmin(limits->tolerance, fmax(least / KN_SURFACE_PARTS, 2.0 * error));
    if (status == KN_OK && limits->angle > 0.0 && is_in_space(f->a)) status = kn_limit_raise_levels(ctx, f, edges);
    return status;
}

// ---- the spline ----

static kn_status to_spline(kn_ctx *ctx, kn_spline *out, const kn_bezier *a, int nvars, const kn_limit_axis *axis,
                           const double *coef)
{
    int degree[KN_MAX_VARS], count[KN_MAX_VARS];
    double *knots[KN_MAX_VARS];
    for (int v = 0; v < nvars; v++) {
        const kn_limit_axis *x = &axis[v];
        degree[v] = x->to, count[v] = (int)kn_limit_count(x);
        knots[v] = kn_scratch(ctx, (size_t)(degree[v] + count[v] + 1), sizeof *knots[v]);
        if (!knots[v]) return KN_ENOMEM;
        int at = 0, spans = 1 << x->level;
        for (int s = 0; s <= spans; s++)
            for (int k = 0; k < (s == 0 || s == spans ? x->to + 1 : x->to - 1); k++)
                knots[v][at++] = (double)s / spans;
    }
    return kn_spline_init(ctx, out, nvars, a->ncomp, a->rational, degree, count, (const double *const *)knots, coef);
}

// out: empty; the edge in the surface's direction.
static kn_status edge_spline(kn_ctx *ctx, kn_spline *out, const kn_bezier *a, const kn_limit_edge *edge)
{
    size_t n = kn_limit_count(&edge->axis);
    for (size_t c = 0; c < (size_t)a->ncomp && edge->turned; c++)
        for (size_t i = 0; i < n / 2; i++) {
            double *x = edge->coef + c * n, t = x[i];
            x[i] = x[n - 1 - i], x[n - 1 - i] = t;
        }
    return to_spline(ctx, out, a, 1, &edge->axis, edge->coef);
}

static kn_status check(kn_ctx *ctx, const kn_bezier *a, const kn_fit_limits *l)
{
    kn_status status = kn_bezier_check_operand(ctx, "limit_degree", a);
    if (status != KN_OK) return status;
    if (a->nvars < 1 || l->max_degree < 3)
        return kn_fail(ctx, KN_EDOMAIN, "limit_degree: %d variables, degree %d", a->nvars, l->max_degree);
    if (l->degree < 3 || l->degree > l->max_degree)
        return kn_fail(ctx, KN_EDOMAIN, "limit_degree: degree %d of at most %d", l->degree, l->max_degree);
    int e;
    if (!(l->tolerance > 0.0) || !isfinite(l->tolerance) || !(l->quantum >= 0.0) ||
        l->quantum > 0.25 * l->tolerance || (l->quantum > 0.0 && frexp(l->quantum, &e) != 0.5))
        return kn_fail(ctx, KN_EDOMAIN, "limit_degree: tolerance %g, quantum %g", l->tolerance, l->quantum);
    if (!(l->angle >= 0.0) || l->angle > MOST_ANGLE)
        return kn_fail(ctx, KN_EDOMAIN, "limit_degree: angle %g (at most %g)", l->angle, MOST_ANGLE);
    if (l->max_level < 0 || l->max_level > MOST_LEVEL)
        return kn_fail(ctx, KN_ELIMIT, "limit_degree: %d halvings", l->max_level);
    for (size_t i = 0, n = kn_bezier_count(a) * (size_t)a->ncomp; i < n; i++)
        if (!isfinite(a->coef[i])) return kn_fail(ctx, KN_EUNDEFINED, "limit_degree: a control point is not finite");
    return KN_OK;
}

static kn_status angles(kn_ctx *ctx, kn_fit_limited *report, const fit *f, const kn_limit_edge *edges)
{
    kn_status status = KN_OK;
    for (int e = 0; e < 4 && status == KN_OK; e++) {
        kn_limit_turn turn = {.goal = f->limits->angle};
        status = kn_limit_edge_angle(ctx, &turn, f, edges[e].error, e / 2, e % 2);
        report->edge_angle[e] = turn.unknown ? INFINITY : turn.angle;
        report->edge_singular[e] = turn.singular;
        report->unknown_angles += turn.unknown;
        report->singular_angles += turn.singular && !turn.unknown;
        if (turn.unknown) continue;
        report->angle = fmax(report->angle, turn.angle);
        report->wide_angles += f->limits->angle > 0.0 && turn.angle > f->limits->angle;
    }
    return status;
}

// The results, whole or not at all.
static kn_status give(kn_ctx *ctx, kn_spline *out, kn_spline *edges, kn_fit_limited *report, fit *f,
                      const kn_limit_edge *fitted_edges)
{
    kn_spline s = {0}, edge[4] = {{0}, {0}, {0}, {0}};
    kn_fit_limited r = {.error = 0.0};
    kn_status status = report ? certify(ctx, f, 0.0, INFINITY) : KN_OK; // as closely as can be
    r.error = f->error;
    for (int v = 0; v < f->a->nvars; v++) r.spans[v] = 1 << f->axis[v].level;
    if (status == KN_OK && report && is_in_space(f->a)) status = angles(ctx, &r, f, fitted_edges);
    if (status == KN_OK) status = to_spline(ctx, &s, f->a, f->a->nvars, f->axis, f->coef);
    for (int e = 0; e < 4 && edges && f->a->nvars == 2 && status == KN_OK; e++)
        status = edge_spline(ctx, &edge[e], f->a, &fitted_edges[e]);
    if (status == KN_OK) {
        kn_spline_swap(out, &s);
        for (int e = 0; e < 4 && edges; e++) kn_spline_swap(&edges[e], &edge[e]);
        if (report) *report = r;
    }
    kn_spline_clear(ctx, &s);
    for (int e = 0; e < 4; e++) kn_spline_clear(ctx, &edge[e]);
    return status;
}

kn_status kn_fit_limit_degree(kn_ctx *ctx, kn_spline *out, kn_spline *edges, kn_fit_limited *report,
                              const kn_bezier *a, const kn_fit_limits *options)
{
    kn_fit_limits limits = *options;
    if (limits.max_level == 0) limits.max_level = 8;
    if (limits.degree == 0) limits.degree = limits.max_degree < 5 ? limits.max_degree : 5;
    kn_status status = check(ctx, a, &limits);
    if (status != KN_OK) return status;
    fit f;
    bool exact = true;
    kn_limit_edge fitted_edges[4] = {{.coef = NULL}};
    begin(&f, a, &limits);
    for (int v = 0; v < a->nvars; v++) exact = exact && is_kept(&f.axis[v]);
    if (exact) {
        status = kn_spline_of_bezier(ctx, out, a);
        if (status != KN_OK) return status;
        for (int e = 0; e < 4 && edges; e++) kn_spline_clear(ctx, &edges[e]);
        if (report) *report = (kn_fit_limited){.exact = true};
        for (int v = 0; v < a->nvars && report; v++) report->spans[v] = 1;
        return KN_OK;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    if (a->nvars == 2) status = fit_edges(ctx, fitted_edges, &f, &limits);
    if (status == KN_OK)
        status = search_within(ctx, &f, a->nvars == 2 ? fitted_edges : NULL, &limits, options->tolerance);
    if (status == KN_OK) status = give(ctx, out, edges, report, &f, fitted_edges);
    kn_scratch_release(ctx, mark);
    return status;
}
