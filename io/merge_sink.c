// SPDX-License-Identifier: Apache-2.0
// A sink before others that makes one surface of patches which lie in a grid.
#include <knurl/io.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/merge.h"
#include "kernel/context.h"

enum { USUAL_CELLS = 4, MOST_CELLS = 64, MOST_SIDE = 1 << 12 };
static const double MOST_ANGLE = 0.8;
static const int edge_of[4] = {2, 1, 3, 0}; // of kn_patch.edge, by side

typedef struct merge {
    kn_sink *sinks;
    int nsinks, cells;
    kn_merge_options limits;
    kn_merge_item *items; // that wait
    size_t nitems, room, sent;
    kn_merge_summary sum, *told;
} merge;

// ---- what goes on ----

static kn_status send(kn_ctx *ctx, merge *m, const kn_patch *patches, size_t n)
{
    kn_patch_block block = {m->sent, n, patches};
    kn_status status = KN_OK;
    for (int k = 0; k < m->nsinks && status == KN_OK && n > 0; k++) {
        const kn_sink *sink = &m->sinks[k];
        void *product = NULL;
        if (sink->work) status = sink->work(ctx, sink->user, &block, &product);
        if (status == KN_OK) status = sink->commit(ctx, sink->user, &block, product);
    }
    m->sent += n, m->sum.faces += n;
    return status;
}

static void clear_items(kn_ctx *ctx, merge *m)
{
    for (size_t i = 0; i < m->nitems; i++) {
        kn_spline_clear(ctx, &m->items[i].surface);
        for (int e = 0; e < 4; e++) kn_spline_clear(ctx, &m->items[i].edge[e]);
        kn_bezier_clear(ctx, &m->items[i].patch.bezier);
    }
    m->nitems = 0;
}

static kn_status send_item(kn_ctx *ctx, merge *m, kn_merge_item *item)
{
    kn_patch patch = item->patch;
    if (patch.bezier.coef == NULL) patch.spline = &item->surface;
    if (patch.edge) patch.edge = item->edge;
    item->done = true;
    return send(ctx, m, &patch, 1);
}

static kn_status send_merged(kn_ctx *ctx, merge *m, const int *list, const kn_merged *merged)
{
    kn_patch patch = m->items[list[0]].patch;
    patch.bezier = (kn_bezier){0};
    patch.spline = &merged->surface;
    patch.edge = merged->edge;
    patch.segments[0] = patch.segments[1] = 0;
    for (int i = 0; i < merged->columns * merged->rows; i++) {
        kn_merge_item *item = &m->items[list[i]];
        item->done = true;
        patch.exact = patch.exact && item->patch.exact;
        if (i < merged->columns) patch.segments[0] += item->patch.segments[item->turn % 2];
        if (i % merged->columns == 0) patch.segments[1] += item->patch.segments[1 - item->turn % 2];
    }
    m->sum.merged++;
    m->sum.error = fmax(m->sum.error, merged->error), m->sum.angle = fmax(m->sum.angle, merged->angle);
    m->sum.unknown_angles += (size_t)merged->unknown_angles;
    m->sum.singular_angles += (size_t)merged->singular_angles;
    if (merged->continuity[0] != 1 && merged->continuity[1] != 1) m->sum.c2++;
    return send(ctx, m, &patch, 1);
}

// ---- which item is beside which ----

typedef struct side_key {
    kn_brep_key key;
    int item, side;
} side_key;

static int by_key(const void *x, const void *y)
{
    const side_key *a = x, *b = y;
    if (a->key.a != b->key.a) return a->key.a < b->key.a ? -1 : 1;
    if (a->key.b != b->key.b) return a->key.b < b->key.b ? -1 : 1;
    return a->item != b->item ? (a->item < b->item ? -1 : 1) : a->side - b->side;
}

static bool same_group(const merge *m, const kn_merge_item *a, const kn_merge_item *b)
{
    const kn_patch *p = &a->patch, *q = &b->patch;
    bool same = p->look == q->look && p->reversed == q->reversed && p->id.surface == q->id.surface;
    same = same && p->id.layer == q->id.layer && p->id.part == q->id.part;
    for (int v = 0; v < 2; v++) same = same && p->id.cell[v] / m->cells == q->id.cell[v] / m->cells;
    return same && a->surface.rational == b->surface.rational;
}

// Two items that alone share an edge are neighbours there.
static kn_status find_neighbours(kn_ctx *ctx, merge *m)
{
    size_t n = 4 * m->nitems;
    side_key *list = kn_alloc(ctx, n + 1, sizeof *list);
    if (!list) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) list[i] = (side_key){m->items[i / 4].side[i % 4], (int)(i / 4), (int)(i % 4)};
    qsort(list, n, sizeof *list, by_key);
    for (size_t i = 0, end; i < n; i = end) {
        for (end = i + 1; end < n && list[end].key.a == list[i].key.a && list[end].key.b == list[i].key.b;) end++;
        kn_merge_item *a = &m->items[list[i].item], *b = &m->items[list[end - 1].item];
        if (end - i != 2 || a == b || !same_group(m, a, b)) continue;
        a->next[list[i].side] = list[i + 1].item, a->next_side[list[i].side] = list[i + 1].side;
        b->next[list[i + 1].side] = list[i].item, b->next_side[list[i + 1].side] = list[i].side;
    }
    kn_free(ctx, list);
    return KN_OK;
}

// The derivative outwards at s along a side, counterclockwise.
static kn_status outwards(kn_ctx *ctx, double d[3], const kn_merge_item *item, int side, double s)
{
    const double at[4][2] = {{s, 0.0}, {1.0, s}, {1.0 - s, 1.0}, {0.0, 1.0 - s}};
    double x[9];
    kn_status status = kn_spline_derivatives(ctx, x, &item->surface, at[side], 1);
    for (int c = 0; c < 3; c++) d[c] = (side == 0 || side == 3 ? -1.0 : 1.0) * x[(side % 2 ? 3 : 6) + c];
    return status;
}

// Whether derivatives across the side are one multiple of those beyond it, at some places: others need no trial.
static kn_status look_at_seam(kn_ctx *ctx, const merge *m, kn_merge_item *item, int own)
{
    enum { PLACES = 7 };
    kn_merge_item *to = &m->items[item->next[own]];
    double d[PLACES][2][3], most = 0.0, ratio = 0.0;
    kn_status status = KN_OK;
    for (int k = 0; k < PLACES && status == KN_OK; k++) {
        double s = (double)k / (PLACES - 1);
        status = outwards(ctx, d[k][0], item, own, s);
        if (status == KN_OK) status = outwards(ctx, d[k][1], to, item->next_side[own], 1.0 - s);
        if (status != KN_OK) break;
        double a = hypot(hypot(d[k][0][0], d[k][0][1]), d[k][0][2]),
               b = hypot(hypot(d[k][1][0], d[k][1][1]), d[k][1][2]);
        if (a > most) most = a, ratio = b / a;
    }
    if (status == KN_EUNDEFINED) { // no point there: nothing to join, and no failure of the run
        kn_ctx_clear_error(ctx);
        status = KN_OK, ratio = 0.0;
    }
    // A control point beside the seam moves by the difference over the degree, less than half of it on each side.
    int degree = item->surface.degree[own % 2 ? 0 : 1];
    bool smooth = ratio > 1e-3 && ratio < 1e3 && status == KN_OK;
    for (int k = 0; k < PLACES && smooth; k++)
        for (int c = 0; c < 3; c++)
            smooth = smooth && fabs(d[k][1][c] + ratio * d[k][0][c]) <= 4.0 * degree * m->limits.tolerance;
    item->seam[own] = to->seam[item->next_side[own]] = smooth ? KN_SEAM_SMOOTH : KN_SEAM_SHARP;
    return status;
}

static kn_status look_at_seams(kn_ctx *ctx, merge *m)
{
    kn_status status = KN_OK;
    for (size_t i = 0; i < m->nitems; i++)
        for (int k = 0; k < 4 && status == KN_OK; k++)
            if (m->items[i].next[k] >= 0 && m->items[i].seam[k] == KN_SEAM_UNKNOWN)
                status = look_at_seam(ctx, m, &m->items[i], k);
    return status;
}

// The item at the grid's side i of this one, turned so that they lie side by side; NULL: none that is free and alike.
static kn_merge_item *beside(const merge *m, const kn_merge_item *item, int i, int *turn)
{
    int own = (i + item->turn) % 4, next = item->next[own];
    if (next < 0 || m->items[next].done || item->seam[own] != KN_SEAM_SMOOTH) return NULL;
    kn_merge_item *to = &m->items[next];
    *turn = (item->next_side[own] - (i + 2) + 8) % 4; // its side (i + 2 + turn) % 4 is the shared one
    for (int v = 0; v < 2; v++)
        if (item->surface.degree[(v + item->turn) % 2] != to->surface.degree[(v + *turn) % 2]) return NULL;
    return to;
}

// ---- rectangles ----

// Whether the item lies right of, and above, those that are in the list already; it is turned accordingly.
static bool fits(const merge *m, const int *list, int columns, int column, int row, int *found)
{
    int turn[2] = {0, 0};
    const kn_merge_item *left = column > 0 ? &m->items[list[row * columns + column - 1]] : NULL;
    const kn_merge_item *below = row > 0 ? &m->items[list[(row - 1) * columns + column]] : NULL;
    kn_merge_item *a = left ? beside(m, left, 1, &turn[0]) : NULL, *b = below ? beside(m, below, 2, &turn[1]) : NULL;
    if ((left && !a) || (below && !b) || (a && b && (a != b || turn[0] != turn[1]))) return false;
    kn_merge_item *to = a ? a : b;
    *found = (int)(to - m->items);
    for (int i = 0; i < row * columns + column; i++)
        if (list[i] == *found) return false; // round a closed surface
    to->turn = a ? turn[0] : turn[1];
    return true;
}

// list: an item and as many columns to its right as there are, then as many whole rows above it.
static void grow(const merge *m, int *list, int first, int most[2], int *columns, int *rows)
{
    *columns = *rows = 1;
    list[0] = first;
    while (*columns < most[0] && fits(m, list, MOST_SIDE, *columns, 0, &list[*columns])) (*columns)++;
    for (bool whole = true; whole && *rows < most[1];) {
        if ((size_t)(*rows + 1) * (size_t)*columns > m->nitems) break;
        for (int c = 0; c < *columns && whole; c++)
            whole = fits(m, list, *columns, c, *rows, &list[*rows * *columns + c]);
        if (whole) (*rows)++;
    }
}

// The largest rectangle from an item on that can be one surface: when it cannot, half of its longer side.
static kn_status merge_from(kn_ctx *ctx, merge *m, int *list, int first)
{
    int most[2] = {MOST_SIDE, MOST_SIDE}, columns, rows;
    m->items[first].turn = 0;
    for (;;) {
        kn_merged merged = {.columns = 0};
        bool good = false;
        grow(m, list, first, most, &columns, &rows);
        if (columns * rows == 1) return KN_OK;
        kn_status status = kn_merge_surface(ctx, &merged, &good, m->items, list, columns, rows, &m->limits);
        if (status == KN_OK && good) status = send_merged(ctx, m, list, &merged);
        kn_spline_clear(ctx, &merged.surface);
        for (int e = 0; e < 4; e++) kn_spline_clear(ctx, &merged.edge[e]);
        if (status != KN_OK || good) return status;
        if (columns >= rows)
            most[0] = columns / 2, most[1] = rows;
        else
            most[0] = columns, most[1] = rows / 2;
    }
}

static kn_status flush(kn_ctx *ctx, merge *m)
{
    kn_status status = find_neighbours(ctx, m);
    if (status == KN_OK) status = look_at_seams(ctx, m);
    int *list = kn_alloc(ctx, m->nitems + MOST_SIDE, sizeof *list);
    if (!list) status = KN_ENOMEM;
    for (size_t i = 0; i < m->nitems && status == KN_OK; i++) {
        if (m->items[i].done) continue;
        status = merge_from(ctx, m, list, (int)i);
        if (status == KN_OK && !m->items[i].done) status = send_item(ctx, m, &m->items[i]);
    }
    kn_free(ctx, list);
    clear_items(ctx, m);
    return status;
}

// ---- what comes ----

static kn_status edge_of_surface(kn_ctx *ctx, kn_spline *out, const kn_patch *patch, int e)
{
    const kn_spline s = kn_patch_spline(patch);
    if (patch->edge) return kn_spline_copy(ctx, out, &patch->edge[e]);
    int var = e / 2, along = 1 - var;
    size_t n = (size_t)s.count[0] * (size_t)s.count[1], m = (size_t)s.count[along],
           step = var == 0 ? 1 : (size_t)s.count[1];
    size_t first = e % 2 ? ((size_t)s.count[var] - 1) * (var == 0 ? (size_t)s.count[1] : 1) : 0;
    kn_mark mark = kn_scratch_mark(ctx);
    double *coef = kn_scratch(ctx, m * (size_t)s.ncomp, sizeof *coef);
    kn_status status = coef ? KN_OK : KN_ENOMEM;
    for (size_t c = 0; coef && c < (size_t)s.ncomp; c++)
        for (size_t i = 0; i < m; i++) coef[c * m + i] = s.coef[c * n + first + i * step];
    if (status == KN_OK)
        status = kn_spline_init(ctx, out, 1, s.ncomp, s.rational, &s.degree[along], &s.count[along],
                                (const double *const[]){s.knots[along]}, coef);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status take(kn_ctx *ctx, merge *m, const kn_patch *patch)
{
    if (m->nitems == m->room) {
        size_t room = m->room > 0 ? 2 * m->room : 64;
        kn_merge_item *more = kn_resize(ctx, m->items, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        m->items = more, m->room = room;
    }
    kn_merge_item *item = &m->items[m->nitems++];
    const kn_spline s = kn_patch_spline(patch);
    *item = (kn_merge_item){.patch = *patch, .next = {-1, -1, -1, -1}};
    item->patch.bezier = (kn_bezier){0};
    item->patch.spline = NULL;
    kn_status status = kn_spline_copy(ctx, &item->surface, &s);
    if (status == KN_OK && !patch->spline) status = kn_bezier_copy(ctx, &item->patch.bezier, &patch->bezier);
    for (int i = 0; i < 4 && status == KN_OK; i++) {
        kn_spline *e = &item->edge[edge_of[i]];
        bool turned;
        status = edge_of_surface(ctx, e, patch, edge_of[i]);
        if (status != KN_OK) break;
        size_t n = kn_spline_count(e);
        item->side[i] = kn_brep_hash(&turned, e->coef, e->ncomp, n, n, 1);
    }
    return status;
}

// Cells come column by column: a new band of columns, or another surface, and what waits cannot grow any more.
static bool ends_band(const merge *m, const kn_patch *patch)
{
    if (m->nitems == 0) return false;
    const kn_patch_id *a = &m->items[0].patch.id, *b = &patch->id;
    return a->surface != b->surface || a->layer != b->layer || a->cell[0] / m->cells != b->cell[0] / m->cells;
}

static kn_status merge_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    merge *m = user;
    kn_status status = KN_OK;
    (void)product;
    for (size_t i = 0; i < block->count && status == KN_OK; i++) {
        const kn_patch *p = &block->patches[i];
        m->sum.patches++;
        if (ends_band(m, p)) status = flush(ctx, m);
        if (status != KN_OK) break;
        status = kn_patch_nvars(p) == 2 && !p->trim && !p->mesh ? take(ctx, m, p) : send(ctx, m, p, 1);
    }
    if (m->told) *m->told = m->sum;
    return status;
}

static kn_status merge_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    merge *m = user;
    kn_job_report r = *report;
    kn_status status = KN_OK;
    r.crossing_error += m->limits.tolerance; // of gaps: an edge and the end of a merged surface are so near
    for (int v = 0; v < 2; v++)              // patches may be turned
        if (report->degree[1 - v] > r.degree[v]) r.degree[v] = report->degree[1 - v];
    for (int k = 0; k < m->nsinks && status == KN_OK; k++)
        if (m->sinks[k].begin) status = m->sinks[k].begin(ctx, m->sinks[k].user, tile, &r);
    return status;
}

static kn_status merge_end(kn_ctx *ctx, void *user)
{
    merge *m = user;
    kn_status status = flush(ctx, m);
    if (m->told) *m->told = m->sum;
    for (int k = 0; k < m->nsinks && status == KN_OK; k++)
        if (m->sinks[k].end) status = m->sinks[k].end(ctx, m->sinks[k].user);
    return status;
}

static void merge_close(kn_ctx *ctx, void *user)
{
    merge *m = user;
    for (int k = 0; k < m->nsinks; k++) kn_sink_close(ctx, &m->sinks[k]);
    clear_items(ctx, m);
    kn_free(ctx, m->items), kn_free(ctx, m->sinks);
    kn_free(ctx, m);
}

static size_t merge_bytes(const void *user)
{
    const merge *m = user;
    size_t bytes = 0;
    for (int k = 0; k < m->nsinks; k++)
        if (m->sinks[k].bytes) bytes += m->sinks[k].bytes(m->sinks[k].user);
    return bytes;
}

kn_status kn_merge_sink(kn_ctx *ctx, kn_sink *out, const kn_sink *sinks, int n, const kn_merge_options *options,
                        kn_merge_summary *summary)
{
    if (!(options->tolerance > 0.0) || !isfinite(options->tolerance) || options->cells < 0 ||
        options->cells > MOST_CELLS)
        return kn_fail(ctx, KN_EDOMAIN, "merge: tolerance %g, %d cells (at most %d)", options->tolerance,
                       options->cells, (int)MOST_CELLS);
    if (!(options->angle >= 0.0 && options->angle <= MOST_ANGLE))
        return kn_fail(ctx, KN_EDOMAIN, "merge: angle %g (at most %g)", options->angle, MOST_ANGLE);
    if (n < 1) return kn_fail(ctx, KN_EDOMAIN, "merge: %d sinks", n);
    for (int k = 0; k < n; k++)
        if (!sinks[k].commit) return kn_fail(ctx, KN_EDOMAIN, "merge: sink %d is closed, or has no commit", k);
    merge *m = kn_alloc_zero(ctx, 1, sizeof *m);
    kn_sink *copies = kn_alloc(ctx, (size_t)n, sizeof *copies);
    if (!m || !copies) {
        kn_free(ctx, m), kn_free(ctx, copies);
        return KN_ENOMEM;
    }
    memcpy(copies, sinks, (size_t)n * sizeof *copies);
    *m = (merge){.sinks = copies, .nsinks = n, .limits = *options, .told = summary};
    m->cells = options->cells > 0 ? options->cells : USUAL_CELLS;
    if (summary) *summary = m->sum;
    *out = (kn_sink){.user = m,
                     .begin = merge_begin,
                     .commit = merge_commit,
                     .end = merge_end,
                     .close = merge_close,
                     .bytes = merge_bytes};
    return KN_OK;
}
