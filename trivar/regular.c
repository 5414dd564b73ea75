// SPDX-License-Identifier: Apache-2.0
// Does a direction vanish somewhere? Coefficients against their mean direction, with subdivision where undecided.
// Wild surfaces, whose direction turns many times, need more boxes than anyone wants to wait for: work is limited.
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

enum {
    DEPTH = 52,
    ROUNDS = 6,
    FREE = 16,    // halvings of each span that do not count as work
    OVERHEAD = 64 // of each other one
};

// n vanishes nowhere where all its coefficients lie strictly on one side of a plane through the origin. The plane's
// normal d is their mean first, then a point of their hull that is nearer to the origin (Gilbert, SIAM J. Control 4,
// 1966): it helps where n is small, but does not vanish, along a curve across which it turns over.
static bool one_sided(const double *n, size_t count, double error)
{
    double d[3] = {0};
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < count; i++) d[c] += n[(size_t)c * count + i];
        d[c] /= (double)count;
    }
    for (int round = 0; round < ROUNDS; round++) {
        double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), least = INFINITY, along = 0.0, square = 0.0;
        size_t at = 0;
        if (!(length > error) || !isfinite(length)) return false;
        for (size_t i = 0; i < count; i++) {
            double x = n[i] * d[0] + n[count + i] * d[1] + n[2 * count + i] * d[2];
            if (!(x >= least)) least = x, at = i;
        }
        if (least > error * length) return true;
        for (size_t c = 0; c < 3; c++) {
            double step = n[c * count + at] - d[c];
            along -= step * d[c], square += step * step;
        }
        double t = fmin(fmax(along / square, 0.0), 1.0);
        for (size_t c = 0; c < 3; c++) d[c] += t * (n[c * count + at] - d[c]);
    }
    return false;
}

typedef struct stack {
    double *data; // level k >= 1 keeps its halves at 2k - 1 (first) and 2k (second); level 0 is the whole
    size_t size;
    int mu, mv, depth;
    double lo[DEPTH + 1][2], width[2];
    int var[DEPTH + 1]; // in which a level was halved
    bool second[DEPTH + 1];
} stack;

static double *top(const stack *s)
{
    return s->data + (s->depth == 0 ? 0 : (size_t)(2 * s->depth - (s->second[s->depth] ? 0 : 1))) * s->size;
}

// The variable in which n varies more: the largest step between neighbours times the degree.
static int steeper(const stack *s)
{
    const double *n = top(s);
    size_t row = (size_t)s->mv + 1;
    double most[2] = {0.0, 0.0};
    for (size_t i = 0; i < s->size; i++) {
        if (i % row > 0) most[1] = fmax(most[1], fabs(n[i] - n[i - 1]));
        if (i / row % ((size_t)s->mu + 1) > 0) most[0] = fmax(most[0], fabs(n[i] - n[i - row]));
    }
    return most[1] * s->mv > most[0] * s->mu;
}

static void descend(stack *s)
{
    int var = steeper(s);
    double *first = s->data + (size_t)(2 * s->depth + 1) * s->size;
    if (var == 0) kn_bernstein_split(first, first + s->size, top(s), 3, s->mu, (size_t)s->mv + 1, 0.5);
    if (var == 1) kn_bernstein_split(first, first + s->size, top(s), 3 * ((size_t)s->mu + 1), s->mv, 1, 0.5);
    memcpy(s->lo[s->depth + 1], s->lo[s->depth], sizeof s->lo[0]);
    s->width[var] *= 0.5;
    s->second[++s->depth] = false;
    s->var[s->depth] = var;
}

// False when this was the last box.
static bool advance(stack *s)
{
    while (s->depth > 0 && s->second[s->depth]) s->width[s->var[s->depth--]] *= 2.0;
    if (s->depth == 0) return false;
    int var = s->var[s->depth];
    s->second[s->depth] = true;
    s->lo[s->depth][var] += s->width[var];
    return true;
}

static void place(double at[2], const stack *s)
{
    for (int v = 0; v < 2; v++) at[v] = s->lo[s->depth][v] + 0.5 * s->width[v];
}

kn_status kn_direction_regular(kn_ctx *ctx, kn_regularity *answer, double at[2], const kn_direction *d, double *work)
{
    size_t count = kn_bezier_count(&d->n);
    stack s = {.size = 3 * count, .mu = d->n.degree[0], .mv = d->n.degree[1], .width = {1.0, 1.0}};
    double error = d->error + kn_gamma(4.0 * (s.mu + s.mv + 2) * DEPTH) * kn_largest_vector(&d->n, 0, 3);
    kn_mark mark = kn_scratch_mark(ctx);
    s.data = kn_scratch(ctx, (2 * DEPTH + 1) * s.size, sizeof *s.data);
    if (!s.data) return KN_ENOMEM;
    memcpy(s.data, d->n.coef, s.size * sizeof *s.data);
    *answer = KN_REGULAR;
    for (int splits = 0;;) {
        if (one_sided(top(&s), count, error)) {
            if (!advance(&s)) break;
            continue;
        }
        if (s.depth == DEPTH || *work < 0.0) {
            *answer = s.depth == DEPTH ? KN_SINGULAR : KN_UNDECIDED;
            place(at, &s);
            break;
        }
        if (splits++ >= FREE) *work -= OVERHEAD + 0.25 * (double)s.size * (s.mu + s.mv);
        descend(&s);
    }
    kn_scratch_release(ctx, mark);
    return KN_OK;
}
