// SPDX-License-Identifier: Apache-2.0
// kn_tile_coverage: what of a cell the tiling covers, seen along w.
#include "tile/cover.h"
#include "kernel/union_find.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_COPIES = 1 << 20 };

// A square of the cell, [i, i + 1] x [j, j + 1] / 2^level.
typedef struct square {
    int level;
    uint32_t index[2];
} square;

typedef struct search {
    const kn_tile_net *net;
    kn_tile_coverage_report *report;
    int depth, lag; // patches are quartered from level `lag` of the squares on
    size_t max_boxes, room;
} search;

void kn_tile_coverage_clear(kn_ctx *ctx, kn_tile_coverage_report *report)
{
    if (!report) return;
    kn_free(ctx, report->gaps);
    *report = (kn_tile_coverage_report){.covers = KN_UNKNOWN};
}

kn_tile_coverage_options kn_tile_coverage_defaults(void)
{
    return (kn_tile_coverage_options){.tolerance = 1e-12, .depth = 8, .max_boxes = (size_t)1 << 17};
}

static kn_status resolve(kn_ctx *ctx, kn_tile_coverage_options *o)
{
    kn_tile_coverage_options d = kn_tile_coverage_defaults();
    if (o->tolerance == 0.0) o->tolerance = d.tolerance;
    if (o->depth == 0) o->depth = d.depth;
    if (o->max_boxes == 0) o->max_boxes = d.max_boxes;
    if (!(o->tolerance > 0.0 && o->tolerance <= 1e-6))
        return kn_fail(ctx, KN_EDOMAIN, "coverage: tolerance %g", o->tolerance);
    if (o->depth < 1 || o->depth > 16) return kn_fail(ctx, KN_EDOMAIN, "coverage: depth %d", o->depth);
    return KN_OK;
}

// ---- whole sheets ----

// The integral of u_r v_t - u_t v_r.
static kn_status signed_area(kn_ctx *ctx, double *out, const kn_bezier *patch)
{
    kn_bezier u = {0}, v = {0}, a = {0}, b = {0};
    double first = 0.0, second = 0.0;
    kn_status status = kn_bezier_components(ctx, &u, patch, 0, 1);
    if (status == KN_OK) status = kn_bezier_components(ctx, &v, patch, 1, 1);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &a, &u, 0);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &b, &v, 1);
    if (status == KN_OK) status = kn_bezier_product(ctx, &a, &a, &b);
    if (status == KN_OK) status = kn_bezier_integral(ctx, &first, &a);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &a, &u, 1);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &b, &v, 0);
    if (status == KN_OK) status = kn_bezier_product(ctx, &a, &a, &b);
    if (status == KN_OK) status = kn_bezier_integral(ctx, &second, &a);
    if (status == KN_OK) *out = first - second;
    kn_bezier_clear(ctx, &u);
    kn_bezier_clear(ctx, &v);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &b);
    return status;
}

// A connected part of the tiling without open edges, whose patches face alike, covers every point of the plane
// equally often, counted with sign: as often as its area, over one cell, says.
static kn_status whole_sheet(kn_ctx *ctx, bool *yes, const kn_tile_net *net)
{
    int n = net->npieces;
    kn_mark mark = kn_scratch_mark(ctx);
    int *parent = kn_scratch(ctx, (size_t)n + 1, sizeof *parent);
    double *area = kn_scratch(ctx, (size_t)n + 1, sizeof *area);
    bool *closed = kn_scratch(ctx, (size_t)n + 1, sizeof *closed);
    kn_status status = parent && area && closed ? KN_OK : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < n; i++) parent[i] = i, area[i] = 0.0, closed[i] = true;
    for (int i = 0; status == KN_OK && i < 4 * n; i++)
        if (net->sides[i].mate >= 0) kn_class_unite(parent, i / 4, net->sides[i].mate / 4);
    for (int i = 0; status == KN_OK && i < 4 * n; i++) {
        const kn_tile_side *s = &net->sides[i];
        bool joined = s->point || (s->mate >= 0 && net->sides[s->mate].mate == i && kn_tile_side_agrees(net, i));
        if (!joined) closed[kn_class_root(parent, i / 4)] = false;
    }
    for (int i = 0; status == KN_OK && i < n; i++) {
        double one = 0.0;
        if (!closed[kn_class_root(parent, i)]) continue;
        status = signed_area(ctx, &one, &net->pieces[i].surface);
        area[kn_class_root(parent, i)] += net->pieces[i].inwards ? -one : one;
    }
    *yes = false;
    // A whole number, but for rounding and cracks far below a half.
    for (int i = 0; status == KN_OK && i < n; i++) *yes = *yes || (closed[i] && fabs(area[i]) > 0.5);
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- boxes ----

static void range_of(double lo[2], double hi[2], square q)
{
    for (int c = 0; c < 2; c++) {
        lo[c] = ldexp(q.index[c], -q.level);
        hi[c] = ldexp(q.index[c] + 1.0, -q.level);
    }
}

static bool meets(const kn_tile_bit *b, const double lo[2], const double hi[2])
{
    for (int c = 0; c < 2; c++)
        if (b->hi[c] + b->cell[c] <= lo[c] || b->lo[c] + b->cell[c] >= hi[c]) return false;
    return true;
}

static kn_status add_gap(kn_ctx *ctx, search *s, square q)
{
    kn_tile_coverage_report *r = s->report;
    if (r->ngaps == s->room) {
        size_t room = s->room ? 2 * s->room : 16;
        kn_tile_rect *gaps = r->gaps ? kn_resize(ctx, r->gaps, room, sizeof *gaps)
                                     : kn_alloc(ctx, room, sizeof *gaps);
        if (!gaps) return KN_ENOMEM;
        r->gaps = gaps;
        s->room = room;
    }
    range_of(r->gaps[r->ngaps].lo, r->gaps[r->ngaps].hi, q);
    r->ngaps++;
    r->bare += ldexp(1.0, -2 * q.level);
    return KN_OK;
}

static kn_status look(kn_ctx *ctx, search *s, square q, const kn_tile_bit *bits, int n);

// The four quarters of a square, with the bits that meet each.
static kn_status divide(kn_ctx *ctx, search *s, square q, const kn_tile_bit *bits, int n)
{
    bool finer = q.level >= s->lag;
    int most = finer ? 4 * n : n;
    kn_status status = KN_OK;
    kn_tile_bit *next = kn_scratch(ctx, (size_t)most + 1, sizeof *next);
    kn_tile_bit *some = kn_scratch(ctx, (size_t)most + 1, sizeof *some);
    if (!next || !some) return KN_ENOMEM;
    for (int i = 0; i < n && status == KN_OK; i++) {
        if (finer)
            status = kn_tile_quarter(ctx, next + 4 * (size_t)i, s->net, &bits[i]);
        else
            next[i] = bits[i];
    }
    for (int k = 0; k < 4 && status == KN_OK; k++) {
        square part = {q.level + 1, {2 * q.index[0] + (uint32_t)(k & 1), 2 * q.index[1] + (uint32_t)(k >> 1)}};
        double lo[2], hi[2];
        int count = 0;
        range_of(lo, hi, part);
        for (int i = 0; i < most; i++)
            if (meets(&next[i], lo, hi)) some[count++] = next[i];
        status = look(ctx, s, part, some, count);
    }
    return status;
}

static kn_status look(kn_ctx *ctx, search *s, square q, const kn_tile_bit *bits, int n)
{
    kn_tile_coverage_report *r = s->report;
    double lo[2], hi[2];
    bool yes = false;
    if (n == 0) return add_gap(ctx, s, q);
    if (r->boxes >= s->max_boxes) return KN_OK;
    if (r->boxes++ % 64 == 0) {
        kn_status status = kn_progress(ctx, "coverage", r->covered + r->bare);
        if (status != KN_OK) return status;
    }
    range_of(lo, hi, q);
    int level = q.level > s->lag ? q.level - s->lag : 0;
    kn_status status = kn_tile_covers_box(ctx, &yes, s->net, bits, n, level, lo, hi);
    if (status != KN_OK) return status;
    if (yes) r->covered += ldexp(1.0, -2 * q.level);
    if (yes || q.level == s->depth) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    status = divide(ctx, s, q, bits, n);
    kn_scratch_release(ctx, mark);
    return status;
}

// All copies of all pieces that meet the cell, and how far pieces may wait until they are quartered.
static kn_status all_copies(kn_ctx *ctx, kn_tile_bit **out, int *count, search *s)
{
    const kn_tile_net *net = s->net;
    const double unit[2][2] = {{0, 0}, {1, 1}};
    double largest = 0.0, copies = 0.0;
    kn_tile_bit *list = NULL;
    for (int pass = 0; pass < 2; pass++) {
        if (pass == 1 && copies > MOST_COPIES)
            return kn_fail(ctx, KN_ELIMIT, "coverage: pieces reach over %.0f cells together", copies);
        if (pass == 1 && !(list = kn_scratch(ctx, (size_t)copies + 1, sizeof *list))) return KN_ENOMEM;
        for (int i = 0; i < net->npieces; i++) {
            kn_tile_bit b = {.piece = i, .coef = net->pieces[i].surface.coef};
            kn_tile_bound(&b, net);
            double first[2], cells[2];
            for (int c = 0; c < 2; c++) { // moved by whole cells between these it meets the unit cell
                largest = fmax(largest, b.hi[c] - b.lo[c]);
                first[c] = -ceil(b.hi[c]);
                cells[c] = 2.0 - floor(b.lo[c]) - first[c];
            }
            copies += cells[0] * cells[1];
            if (pass == 0) continue;
            for (double x = 0; x < cells[0]; x++)
                for (double y = 0; y < cells[1]; y++) {
                    b.cell[0] = (int)(first[0] + x), b.cell[1] = (int)(first[1] + y);
                    if (meets(&b, unit[0], unit[1])) list[(*count)++] = b;
                }
        }
    }
    for (s->lag = 0; s->lag < 16 && ldexp(largest, s->lag + 1) <= 1.0;) s->lag++;
    *out = list;
    return KN_OK;
}

// ---- gaps ----

static int compare(const double *a, const double *b, int n)
{
    for (int k = 0; k < n; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return 0;
}

static int by_row(const void *x, const void *y)
{
    const kn_tile_rect *a = x, *b = y;
    return compare((double[]){a->lo[1], a->hi[1], a->lo[0]}, (double[]){b->lo[1], b->hi[1], b->lo[0]}, 3);
}

static int by_column(const void *x, const void *y)
{
    const kn_tile_rect *a = x, *b = y;
    return compare((double[]){a->lo[0], a->hi[0], a->lo[1]}, (double[]){b->lo[0], b->hi[0], b->lo[1]}, 3);
}

// Neighbours along direction c of equal extent across become one.
static size_t merge(kn_tile_rect *list, size_t n, int c)
{
    size_t count = 0;
    qsort(list, n, sizeof *list, c == 0 ? by_row : by_column);
    for (size_t i = 0; i < n; i++) {
        kn_tile_rect *last = count ? &list[count - 1] : NULL;
        if (last && last->hi[c] == list[i].lo[c] && last->lo[1 - c] == list[i].lo[1 - c] &&
            last->hi[1 - c] == list[i].hi[1 - c])
            last->hi[c] = list[i].hi[c];
        else
            list[count++] = list[i];
    }
    return count;
}

static void merge_gaps(kn_tile_coverage_report *r)
{
    for (size_t before = r->ngaps + 1; r->ngaps > 0 && r->ngaps < before;) {
        before = r->ngaps;
        r->ngaps = merge(r->gaps, r->ngaps, 0);
        r->ngaps = merge(r->gaps, r->ngaps, 1);
    }
    if (r->ngaps > 0) qsort(r->gaps, r->ngaps, sizeof *r->gaps, by_row);
}

static kn_status look_at_all(kn_ctx *ctx, search *s)
{
    kn_tile_bit *list = NULL;
    int n = 0;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = all_copies(ctx, &list, &n, s);
    if (status == KN_OK) status = look(ctx, s, (square){0, {0, 0}}, list, n);
    kn_scratch_release(ctx, mark);
    if (status == KN_OK) merge_gaps(s->report);
    return status;
}

kn_status kn_tile_coverage(kn_ctx *ctx, kn_tile_coverage_report *report, const kn_tile *tile,
                           const kn_tile_coverage_options *options)
{
    kn_tile_coverage_options o = options ? *options : kn_tile_coverage_defaults();
    kn_tile_coverage_report r = {.covers = KN_UNKNOWN};
    kn_tile_net net = {0};
    bool whole = false;
    kn_status status = resolve(ctx, &o);
    if (status == KN_OK) status = kn_tile_net_make(ctx, &net, tile, o.tolerance);
    if (status == KN_OK) status = whole_sheet(ctx, &whole, &net);
    search s = {.net = &net, .report = &r, .depth = o.depth, .max_boxes = o.max_boxes};
    if (status == KN_OK && whole)
        r.covered = 1.0;
    else if (status == KN_OK)
        status = look_at_all(ctx, &s);
    if (status == KN_OK) r.covers = r.covered == 1.0 ? KN_YES : r.ngaps > 0 ? KN_NO : KN_UNKNOWN;
    if (net.unchecked > 0 && r.covers == KN_NO) r.covers = KN_UNKNOWN;
    kn_tile_net_clear(ctx, &net);
    if (status == KN_OK)
        *report = r;
    else
        kn_tile_coverage_clear(ctx, &r);
    return status;
}
