// SPDX-License-Identifier: Apache-2.0
// Pieces of contours to loops: first where ends are equal bit for bit, then where they are near.
#include "slice/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const size_t none = SIZE_MAX;

// The start of a piece, for sorting.
typedef struct key {
    double at[2];
    size_t line;
} key;

typedef struct chains {
    const kn_slice_lines *from;
    const kn_slice_line *lines;
    size_t n;
    size_t *next, *before; // of each piece; none
    double gap;
    size_t doubtful;
} chains;

static const double *start_of(const chains *c, size_t i)
{
    return c->from->points + 2 * c->lines[i].first;
}

static const double *end_of(const chains *c, size_t i)
{
    return c->from->points + 2 * (c->lines[i].first + c->lines[i].n - 1);
}

static int by_place(const void *a, const void *b)
{
    const key *x = a, *y = b;
    for (int d = 0; d < 2; d++)
        if (x->at[d] != y->at[d]) return x->at[d] < y->at[d] ? -1 : 1;
    return (x->line > y->line) - (x->line < y->line);
}

static void link_up(chains *c, size_t from, size_t to)
{
    c->next[from] = to;
    c->before[to] = from;
}

// The first of the sorted keys that does not come before `at`.
static size_t lower(const key *keys, size_t n, double x, double y)
{
    size_t lo = 0, hi = n;
    while (lo < hi) {
        size_t middle = lo + (hi - lo) / 2;
        const double *p = keys[middle].at;
        if (p[0] < x || (p[0] == x && p[1] < y))
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}

// Ends that are some start, bit for bit. A piece that begins where it ends is closed in itself.
static void link_equal(chains *c, const key *keys)
{
    for (size_t i = 0; i < c->n; i++) {
        const double *end = end_of(c, i), *start = start_of(c, i);
        if (end[0] == start[0] && end[1] == start[1] && c->lines[i].n > 1) link_up(c, i, i);
    }
    for (size_t i = 0; i < c->n; i++) {
        if (c->next[i] != none) continue;
        const double *end = end_of(c, i);
        for (size_t k = lower(keys, c->n, end[0], end[1]); k < c->n; k++) {
            if (keys[k].at[0] != end[0] || keys[k].at[1] != end[1]) break;
            if (c->before[keys[k].line] != none || keys[k].line == i) continue;
            link_up(c, i, keys[k].line);
            break;
        }
    }
}

// A possible join of an end and a start.
typedef struct join {
    double distance;
    size_t from, to;
} join;

static int by_distance(const void *a, const void *b)
{
    const join *x = a, *y = b;
    if (x->distance != y->distance) return x->distance < y->distance ? -1 : 1;
    if (x->from != y->from) return x->from < y->from ? -1 : 1;
    return (x->to > y->to) - (x->to < y->to);
}

// All joins of loose ends within reach; of those on trims alone; list NULL: counted.
static size_t find_joins(join *list, const chains *c, const key *keys, double reach, bool cut)
{
    size_t n = 0;
    for (size_t i = 0; i < c->n; i++) {
        if (c->next[i] != none || (cut && !c->lines[i].cut[1])) continue;
        const double *end = end_of(c, i);
        for (size_t k = lower(keys, c->n, end[0] - reach, -INFINITY); k < c->n && keys[k].at[0] <= end[0] + reach;
             k++) {
            double distance = hypot(keys[k].at[0] - end[0], keys[k].at[1] - end[1]);
            if (c->before[keys[k].line] != none || distance > reach ||
                (cut && (!c->lines[keys[k].line].cut[0] || keys[k].line == i)))
                continue;
            if (list) list[n] = (join){distance, i, keys[k].line};
            n++;
        }
    }
    return n;
}

// The nearest first.
static kn_status link_near(kn_ctx *ctx, chains *c, const key *keys, double reach, bool cut)
{
    kn_mark mark = kn_scratch_mark(ctx);
    size_t n = find_joins(NULL, c, keys, reach, cut);
    join *joins = kn_scratch(ctx, n, sizeof *joins);
    if (!joins) return KN_ENOMEM;
    (void)find_joins(joins, c, keys, reach, cut);
    if (n > 0) qsort(joins, n, sizeof *joins, by_distance);
    for (size_t i = 0; i < n; i++) {
        if (c->next[joins[i].from] != none || c->before[joins[i].to] != none) continue;
        link_up(c, joins[i].from, joins[i].to);
        c->gap = fmax(c->gap, joins[i].distance);
        c->doubtful += cut;
    }
    kn_scratch_release(ctx, mark);
    return KN_OK;
}

// Ends on a trim have one on the other side of it. Where the contour runs nearly along the trim, or the surface is
// nearly level, it may be farther away than the two sides are, by some factor: beyond 8 ends stay open.
static kn_status link_trims(kn_ctx *ctx, chains *c, const key *keys, double reach)
{
    return link_near(ctx, c, keys, 8.0 * reach, true);
}

// Writes the pieces from `start` on, each without its first point where that is the last one's end.
static size_t write_chain(double *out, const chains *c, size_t start, bool *taken)
{
    size_t n = 0;
    for (size_t i = start; i != none && !taken[i]; i = c->next[i]) {
        const double *p = start_of(c, i);
        size_t skip = n > 0 && p[0] == out[2 * n - 2] && p[1] == out[2 * n - 1];
        memcpy(out + 2 * n, p + 2 * skip, 2 * (c->lines[i].n - skip) * sizeof *out);
        n += c->lines[i].n - skip;
        taken[i] = true;
    }
    return n;
}

static kn_status collect(kn_ctx *ctx, kn_slice *layer, const chains *c)
{
    size_t points = 0, at = 0;
    for (size_t i = 0; i < c->n; i++) points += c->lines[i].n;
    bool *taken = kn_scratch(ctx, c->n, sizeof *taken);
    double *all = kn_scratch(ctx, 2 * points, sizeof *all);
    kn_slice_loop *loops = kn_scratch(ctx, c->n, sizeof *loops);
    if (!taken || !all || !loops) return KN_ENOMEM;
    memset(taken, 0, c->n * sizeof *taken);
    for (int closed = 0; closed < 2; closed++) // what has a beginning first
        for (size_t i = 0; i < c->n; i++) {
            if (taken[i] || (!closed && c->before[i] != none)) continue;
            double *to = all + 2 * at;
            size_t n = write_chain(to, c, i, taken);
            if (closed && n > 1 && to[0] == to[2 * n - 2] && to[1] == to[2 * n - 1]) n--;
            if (n < 2) continue; // a point: a plane that touches
            loops[layer->nloops++] = (kn_slice_loop){to, n, closed, c->lines[i].part, c->lines[i].layer};
            layer->nopen += !closed;
            at += n;
        }
    layer->loops = loops;
    return KN_OK;
}

kn_status kn_slice_chain(kn_ctx *ctx, const kn_slice_lines *from, const kn_slice_line *lines, size_t n,
                         const kn_slice_window *w, const kn_slice_note *note, kn_slice_fn fn, void *user)
{
    kn_mark mark = kn_scratch_mark(ctx);
    const kn_slice_options *o = &w->options;
    double reach = kn_slice_reach(w);
    chains c = {.from = from, .lines = lines, .n = n};
    c.next = kn_scratch(ctx, n, sizeof *c.next);
    c.before = kn_scratch(ctx, n, sizeof *c.before);
    key *keys = kn_scratch(ctx, n, sizeof *keys);
    kn_status status = c.next && c.before && keys ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        const double *p = start_of(&c, i);
        c.next[i] = c.before[i] = none;
        keys[i] = (key){{p[0], p[1]}, i};
    }
    kn_slice layer = {.index = note->plane, .z = kn_slice_height(o, note->plane), .error = note->error};
    if (status == KN_OK) {
        if (n > 0) qsort(keys, n, sizeof *keys, by_place);
        link_equal(&c, keys);
        status = link_near(ctx, &c, keys, reach, false);
        if (status == KN_OK && w->crossing) status = link_trims(ctx, &c, keys, reach);
    }
    if (status == KN_OK) status = collect(ctx, &layer, &c);
    layer.gap = c.gap;
    layer.doubtful = note->doubtful + c.doubtful;
    if (status == KN_OK) status = fn(ctx, user, &layer);
    kn_scratch_release(ctx, mark);
    return status;
}
