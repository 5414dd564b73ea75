// SPDX-License-Identifier: Apache-2.0
// Less distortion: the limited-memory method of Broyden, Fletcher, Goldfarb and Shanno, with steps that fold nothing.
// Corners are counted in the widths of their lines at the start, which makes them alike: the distortion is one of
// logarithms, and asks how much of its own width a cell changes.
// Source: Nocedal & Wright, Numerical Optimization, algorithms 3.1 and 7.5.
#include "cells/relax.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

enum { HISTORY = 12, HALVINGS = 40, CALM = 4 };

typedef struct search {
    size_t n;          // numbers: two a corner
    double *unit;      // of each
    double *gradient;  // in units
    double *direction; // in units
    double *trial, *room;
    double *step[HISTORY], *turn[HISTORY], weight[HISTORY]; // the last moves, and what they did to the gradient
    int moves;
    double energy;
} search;

static double inner(const double *a, const double *b, size_t n)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

static void add(double *a, double factor, const double *b, size_t n)
{
    for (size_t i = 0; i < n; i++) a[i] += factor * b[i];
}

static kn_status make_search(kn_ctx *ctx, search *s, const kn_corner_grid *g)
{
    *s = (search){.n = 2 * kn_corner_count(g)};
    double *all = kn_scratch(ctx, (4 + 2 * HISTORY) * s->n, sizeof *all);
    s->room = kn_scratch(ctx, kn_relax_room(g), sizeof *s->room);
    if (!all || !s->room) return KN_ENOMEM;
    double **to[4] = {&s->unit, &s->gradient, &s->direction, &s->trial};
    for (int k = 0; k < 4; k++) *to[k] = all + (size_t)k * s->n;
    for (int k = 0; k < HISTORY; k++) {
        s->step[k] = all + (size_t)(4 + 2 * k) * s->n;
        s->turn[k] = s->step[k] + s->n;
    }
    size_t row = (size_t)g->n[1] + 1;
    for (int i = 0; i <= g->n[0]; i++)
        for (int j = 0; j <= g->n[1]; j++) {
            size_t k = (size_t)i * row + (size_t)j;
            const int at[2] = {i, j};
            for (int d = 0; d < 2; d++) {
                size_t stride = d == 0 ? row : 1, low = at[d] > 0 ? k - stride : k;
                size_t high = at[d] < g->n[d] ? k + stride : k;
                double width = g->corners[2 * high + (size_t)d] - g->corners[2 * low + (size_t)d];
                s->unit[2 * k + (size_t)d] = width / (low < k && high > k ? 2.0 : 1.0);
            }
        }
    return KN_OK;
}

// direction = -(an estimate of the inverse of the second derivative) gradient: the two loops.
static void choose_direction(search *s)
{
    double *d = s->direction, alpha[HISTORY];
    int kept = s->moves < HISTORY ? s->moves : HISTORY;
    for (size_t i = 0; i < s->n; i++) d[i] = -s->gradient[i];
    for (int k = 0; k < kept; k++) {
        int m = (s->moves - 1 - k) % HISTORY;
        alpha[m] = s->weight[m] * inner(s->step[m], d, s->n);
        add(d, -alpha[m], s->turn[m], s->n);
    }
    if (kept > 0) {
        int last = (s->moves - 1) % HISTORY;
        double scale = 1.0 / (s->weight[last] * inner(s->turn[last], s->turn[last], s->n));
        for (size_t i = 0; i < s->n; i++) d[i] *= scale;
    }
    for (int k = kept - 1; k >= 0; k--) {
        int m = (s->moves - 1 - k) % HISTORY;
        add(d, alpha[m] - s->weight[m] * inner(s->turn[m], d, s->n), s->step[m], s->n);
    }
}

// trial = corners + t direction; the ends of a closed variable alike.
static void move(search *s, const kn_corner_grid *g, double t)
{
    for (size_t i = 0; i < s->n; i++) s->trial[i] = g->corners[i] + t * s->direction[i] * s->unit[i];
    size_t row = (size_t)g->n[1] + 1;
    for (int d = 0; d < 2; d++)
        for (int k = 0; g->closed[d] && k <= g->n[1 - d]; k++) {
            size_t low = d == 0 ? (size_t)k : (size_t)k * row;
            size_t high = low + (d == 0 ? (size_t)g->n[0] * row : (size_t)g->n[1]);
            s->trial[2 * high + (size_t)(1 - d)] = s->trial[2 * low + (size_t)(1 - d)];
        }
}

// The gradient in units, from that in parameters.
static void into_units(double *gradient, const search *s)
{
    for (size_t i = 0; i < s->n; i++) gradient[i] *= s->unit[i];
}

// One move: *moved is false where no step downhill was found. The history gets it where it is convex.
static kn_status advance(kn_ctx *ctx, search *s, kn_corner_grid *g, bool *moved)
{
    const double most = 0.5, enough = 1e-4; // of a line's width at once; of the decrease that the slope promises
    int slot = s->moves % HISTORY;
    double *step = s->step[slot], *turn = s->turn[slot], largest = 0.0;
    double slope = inner(s->direction, s->gradient, s->n), energy = INFINITY, t = 1.0;
    *moved = false;
    for (size_t i = 0; i < s->n; i++) largest = fmax(largest, fabs(s->direction[i]));
    if (!(slope < 0.0) || !(largest > 0.0) || isinf(largest)) return KN_OK;
    if (s->moves == 0 || largest > most) t = (s->moves == 0 ? 0.1 : most) / largest;
    for (int k = 0; k < HALVINGS; k++, t *= 0.5) {
        move(s, g, t);
        if (!kn_corners_unfolded(g, s->trial)) continue;
        kn_status status = kn_relax_energy(ctx, &energy, turn, g, s->trial, s->room);
        if (status != KN_OK) return status;
        if (energy <= s->energy + enough * t * slope) break;
        energy = INFINITY;
    }
    if (isinf(energy) || !(energy < s->energy)) return KN_OK;
    into_units(turn, s);
    for (size_t i = 0; i < s->n; i++) {
        double now = turn[i];
        step[i] = t * s->direction[i];
        turn[i] = now - s->gradient[i];
        s->gradient[i] = now;
    }
    memcpy(g->corners, s->trial, s->n * sizeof *g->corners);
    s->energy = energy;
    double bend = inner(step, turn, s->n);
    if (bend > 1e-12 * inner(turn, turn, s->n)) s->weight[slot] = 1.0 / bend, s->moves++;
    *moved = true;
    return KN_OK;
}

kn_status kn_relax_search(kn_ctx *ctx, kn_corner_grid *g, int iterations)
{
    const double little = 1e-5; // of the energy, in each of CALM moves: nothing more is to be had
    kn_mark mark = kn_scratch_mark(ctx);
    search s;
    kn_status status = make_search(ctx, &s, g);
    if (status == KN_OK) status = kn_relax_energy(ctx, &s.energy, s.gradient, g, g->corners, s.room);
    if (status == KN_OK) into_units(s.gradient, &s);
    bool moved = true;
    int calm = 0;
    for (int k = 0; status == KN_OK && k < iterations && calm < CALM && isfinite(s.energy); k++) {
        double before = s.energy;
        choose_direction(&s);
        status = advance(ctx, &s, g, &moved);
        if (status == KN_OK && !moved && s.moves == 0) break;
        if (!moved) s.moves = 0; // once more, straight down
        calm = before - s.energy <= little * before ? calm + 1 : 0;
        if (status == KN_OK) status = kn_progress(ctx, "relax", (k + 1.0) / iterations);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
