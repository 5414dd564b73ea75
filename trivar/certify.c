// SPDX-License-Identifier: Apache-2.0
// How far a field m is from a unit normal N/|N|, bounded by Bernstein coefficients and never by samples.
//
// A polynomial on [0,1]^2 is a mean of its coefficients at every point, so that with e = max |coefficients of m.m -
// 1|
//     | |m| - 1 | <= 1 - sqrt(1 - e) = e / (1 + sqrt(1 - e)),
// and with sin(angle) = |m x N| / (|m| |N|), d any unit vector,
//     sin(angle) <= max |coefficients of m x N| / (min |m| min (coefficients of N) . d).
// Both converge quadratically under subdivision. The rounding of every step is added at the worst it can be.
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "kernel/convolve.h"
#include "trivar/internal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { DEPTH = 10 }; // halvings, both variables together: each box lies at most 5 deep in either

// m x N (3), N (3) and m.m - 1 (1), one behind the other, over a box.
typedef struct residual {
    int cross[2], normal[2], length[2]; // degrees
    size_t ncross, nnormal, nlength, size;
} residual;

typedef struct rounding {
    double cross, normal, length; // absolute, of the coefficients
} rounding;

typedef struct search {
    residual r;
    rounding error[DEPTH + 1]; // of boxes at this level
    const kn_certify_options *options;
    double *level[DEPTH + 1];
    double length, angle; // the worst so far
    bool failed;
} search;

static double largest_vector(const double *c, size_t count)
{
    double largest = 0.0;
    for (size_t i = 0; i < count; i++) {
        double square = c[i] * c[i] + c[count + i] * c[count + i] + c[2 * count + i] * c[2 * count + i];
        largest = square > largest ? square : largest;
    }
    return sqrt(largest) * (1.0 + 0x1p-50);
}

// A lower bound of |N|; may be negative.
static double smallest_vector(const double *n, size_t count)
{
    double d[3] = {0}, length = 0.0, smallest = INFINITY;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < count; i++) d[c] += n[(size_t)c * count + i];
        length += d[c] * d[c];
    }
    length = sqrt(length);
    if (!(length > 0.0)) return 0.0;
    for (size_t i = 0; i < count; i++) {
        double along = n[i] * d[0] + n[count + i] * d[1] + n[2 * count + i] * d[2];
        smallest = along < smallest ? along : smallest;
    }
    return smallest / length;
}

static double largest_number(const double *c, size_t count)
{
    double largest = 0.0;
    for (size_t i = 0; i < count; i++) largest = fabs(c[i]) > largest ? fabs(c[i]) : largest;
    return largest;
}

// The box at this level; the others are below it.
static void search_box(search *s, int level)
{
    const residual *r = &s->r;
    const kn_certify_options *o = s->options;
    const rounding *error = &s->error[level];
    double *box = s->level[level], *normal = box + 3 * r->ncross, *square = normal + 3 * r->nnormal;
    double e = largest_number(square, r->nlength) + error->length;
    double length = e < 1.0 ? e / (1.0 + sqrt(1.0 - e)) : INFINITY;
    double least = (smallest_vector(normal, r->nnormal) - error->normal) * (1.0 - length), angle = INFINITY;
    if (e < 0.5 && least > 0.0) {
        double sine = (largest_vector(box, r->ncross) + error->cross) / least;
        if (sine < 0.5) angle = asin(sine);
    }
    double floor = least > 0.0 ? 2.0 * error->cross / least : 0.0;
    bool enough = length <= o->target[0] + 2.0 * error->length && angle <= o->target[1] + floor;
    bool last = level == DEPTH || (o->work && *o->work < 0.0);
    if ((enough && length <= o->limit && angle <= o->limit) || last) {
        s->length = fmax(s->length, length);
        s->angle = fmax(s->angle, angle);
        s->failed = !(s->length <= o->limit && s->angle <= o->limit);
        return;
    }
    double *first = s->level[level + 1], *second = first + r->size;
    size_t at[3] = {0, 3 * r->ncross, 3 * (r->ncross + r->nnormal)}, comps[3] = {3, 3, 1};
    const int *degree[3] = {r->cross, r->normal, r->length};
    for (int f = 0; f < 3; f++) {
        size_t mu = (size_t)degree[f][0] + 1, mv = (size_t)degree[f][1] + 1;
        size_t outer = level % 2 == 0 ? comps[f] : comps[f] * mu, inner = level % 2 == 0 ? mv : 1;
        kn_bernstein_split(first + at[f], second + at[f], box + at[f], outer, degree[f][level % 2], inner, 0.5);
        if (o->work) *o->work -= 0.5 * (double)(comps[f] * mu * mv) * degree[f][level % 2];
    }
    search_box(s, level + 1);
    if (s->failed) return;
    // The first half is done with: the second takes its place.
    memcpy(first, second, r->size * sizeof *first);
    search_box(s, level + 1);
}

// ---- the products ----

// Scaled coefficients: times their binomials.
static double *scaled(kn_ctx *ctx, const kn_bezier *b)
{
    size_t count = kn_bezier_count(b);
    double *out = kn_scratch(ctx, 3 * count, sizeof *out), *weights = kn_scratch(ctx, count, sizeof *weights);
    if (!out || !weights) return NULL;
    kn_bernstein_weights(weights, 2, b->degree);
    for (size_t i = 0; i < 3 * count; i++) out[i] = b->coef[i] * weights[i % count];
    return out;
}

// m, n: scaled. weights: room for the larger of both products; work: for kn_convolve.
static void multiply(double *box, double *weights, double *work, const residual *r, const double *m, const int *dm,
                     const double *n, const kn_bezier *normal)
{
    size_t cm = kn_bernstein_count(2, dm), cn = r->nnormal;
    memset(box, 0, r->size * sizeof *box);
    kn_bernstein_weights(weights, 2, r->cross);
    for (size_t c = 0; c < 3; c++) {
        size_t a = (c + 1) % 3, b = (c + 2) % 3;
        double *to = box + c * r->ncross;
        kn_convolve(to, 2, m + a * cm, dm, n + b * cn, r->normal, 1.0, work);
        kn_convolve(to, 2, m + b * cm, dm, n + a * cn, r->normal, -1.0, work);
        for (size_t i = 0; i < r->ncross; i++) to[i] /= weights[i];
    }
    memcpy(box + 3 * r->ncross, normal->coef, 3 * cn * sizeof *box);
    double *square = box + 3 * (r->ncross + cn);
    for (size_t c = 0; c < 3; c++) kn_convolve(square, 2, m + c * cm, dm, m + c * cm, dm, 1.0, work);
    kn_bernstein_weights(weights, 2, r->length);
    for (size_t i = 0; i < r->nlength; i++) square[i] = square[i] / weights[i] - 1.0;
}

// Roundings of `level` halvings, in both variables by turns: one sum for each of the degree's steps.
static double halvings(const int degree[2], int level)
{
    return 2.0 * ((level + 1) / 2 * degree[0] + level / 2 * degree[1]);
}

// Each coefficient of a product is a mean of products, so gamma(k) of the largest product bounds its rounding.
static void bound_rounding(search *s, const kn_bezier *m, const kn_bezier *n)
{
    const kn_certify_options *o = s->options;
    const residual *r = &s->r;
    double big_m = kn_largest_vector(m, 0, 3), big_n = kn_largest_vector(n, 0, 3);
    double terms = (double)kn_bezier_count(m);
    for (int k = 0; k <= DEPTH; k++) {
        rounding *e = &s->error[k];
        e->cross = 2.0 * kn_gamma(2 * terms + 24 + halvings(r->cross, k)) * big_m * big_n;
        e->cross += 1.01 * (big_m * o->direction_error + big_n * o->normal_error);
        e->normal = kn_gamma(24 + halvings(r->normal, k)) * big_n + o->direction_error;
        e->length = kn_gamma(3 * terms + 24 + halvings(r->length, k)) * (big_m * big_m + 1.0);
        e->length += 2.02 * big_m * o->normal_error;
    }
}

static bool prepare(kn_ctx *ctx, search *s, const kn_bezier *m, const kn_bezier *n)
{
    residual *r = &s->r;
    for (int v = 0; v < 2; v++) {
        r->cross[v] = m->degree[v] + n->degree[v];
        r->normal[v] = n->degree[v];
        r->length[v] = 2 * m->degree[v];
        assert(r->cross[v] <= KN_MAX_DEGREE && r->length[v] <= KN_MAX_DEGREE);
    }
    r->ncross = kn_bernstein_count(2, r->cross);
    r->nnormal = kn_bernstein_count(2, r->normal);
    r->nlength = kn_bernstein_count(2, r->length);
    r->size = 3 * (r->ncross + r->nnormal) + r->nlength;
    size_t work = kn_convolve_work(2, m->degree, n->degree), own = kn_convolve_work(2, m->degree, m->degree);
    double *sm = scaled(ctx, m), *sn = scaled(ctx, n), *room = kn_scratch(ctx, work > own ? work : own, sizeof *room);
    if (!sm || !sn || !room) return false;
    double *levels = kn_scratch(ctx, (2 * DEPTH + 1) * r->size, sizeof *levels);
    double *weights = kn_scratch(ctx, r->ncross > r->nlength ? r->ncross : r->nlength, sizeof *weights);
    if (!levels || !weights) return false;
    s->level[0] = levels;
    for (int k = 1; k <= DEPTH; k++) s->level[k] = levels + (size_t)(2 * k - 1) * r->size;
    multiply(levels, weights, room, r, sm, m->degree, sn, n);
    double products = 6.0 * (double)r->nnormal + 3.0 * (double)kn_bezier_count(m);
    if (s->options->work) *s->options->work -= products * (double)kn_bezier_count(m) + 4.0 * (double)r->size;
    bound_rounding(s, m, n);
    return true;
}

// sin(angle) < 1 everywhere keeps m.N from changing its sign, so one corner decides between 0 and pi.
static bool same_side(const kn_bezier *m, const kn_bezier *n)
{
    size_t cm = kn_bezier_count(m), cn = kn_bezier_count(n);
    return m->coef[0] * n->coef[0] + m->coef[cm] * n->coef[cn] + m->coef[2 * cm] * n->coef[2 * cn] > 0.0;
}

kn_status kn_certify(kn_ctx *ctx, kn_normal_certificate *out, const kn_bezier *m, const kn_bezier *direction,
                     const kn_certify_options *options)
{
    search s = {.options = options};
    kn_mark mark = kn_scratch_mark(ctx);
    bool room = prepare(ctx, &s, m, direction);
    if (room) {
        search_box(&s, 0);
        bool good = !s.failed && same_side(m, direction);
        double inflate = 1.0 + 0x1p-40; // square roots, quotients and the arc sine above
        *out = good ? (kn_normal_certificate){s.length * inflate, s.angle * inflate, true}
                    : (kn_normal_certificate){INFINITY, INFINITY, false};
    }
    kn_scratch_release(ctx, mark);
    return room ? KN_OK : KN_ENOMEM;
}

// Places that are the sites of no interpolation at equal or symmetric sites.
void kn_sample_errors(double *length, double *angle, const kn_bezier *m, const kn_bezier *direction)
{
    static const double places[4] = {0.11, 0.37, 0.63, 0.89};
    double bm[KN_MAX_DEGREE + 1], bn[KN_MAX_DEGREE + 1], row_m[3 * (KN_MAX_DEGREE + 1)],
        row_n[3 * (KN_MAX_DEGREE + 1)];
    *length = *angle = 0.0;
    for (int k = 0; k < 16; k++) {
        double a[3], b[3], x[3], mm = 0.0, nn = 0.0, cross = 0.0;
        if (k % 4 == 0) {
            kn_bernstein_basis(bm, m->degree[0], places[k / 4]);
            kn_bernstein_basis(bn, direction->degree[0], places[k / 4]);
            kn_bernstein_contract(row_m, m->coef, 3, m->degree[0] + 1, (size_t)m->degree[1] + 1, bm);
            kn_bernstein_contract(row_n, direction->coef, 3, direction->degree[0] + 1,
                                  (size_t)direction->degree[1] + 1, bn);
        }
        kn_bernstein_basis(bm, m->degree[1], places[k % 4]);
        kn_bernstein_basis(bn, direction->degree[1], places[k % 4]);
        kn_bernstein_contract(a, row_m, 3, m->degree[1] + 1, 1, bm);
        kn_bernstein_contract(b, row_n, 3, direction->degree[1] + 1, 1, bn);
        for (int c = 0; c < 3; c++) {
            x[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
            mm += a[c] * a[c], nn += b[c] * b[c], cross += x[c] * x[c];
        }
        *length = fmax(*length, fabs(sqrt(mm) - 1.0));
        double sine = sqrt(cross / (mm * nn)); // not finite where either vanishes: then no error is small enough
        *angle = sine < 1.0 ? fmax(*angle, asin(sine)) : INFINITY;
    }
}
