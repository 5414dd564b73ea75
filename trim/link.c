// SPDX-License-Identifier: Apache-2.0
// Which parts of the lines {f = 0} lie in the region, and between which places of its boundary they run.
//
// Where f changes from negative to positive along the boundary (which has the region to its left), the line of zeros
// run with f < 0 to its left enters the region, and where f changes back it leaves. So along every line these nodes
// alternate, and what lies between an entry and the next exit is in the region. Lines that do not do so are refused.
#include "kernel/context.h"
#include "trim/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Nodes this near to a line lie on it, as far as its points go.
static const double on_line = 1e-11;

typedef struct linking {
    kn_trim_links *out;
    const kn_trim *trim;
    kn_solve_curve *lines; // run with f < 0 to their left
    size_t nlines;
    double tol;
    kn_trim_node **order; // nodes by line and place
} linking;

void kn_trim_links_clear(kn_ctx *ctx, kn_trim_links *links)
{
    for (int i = 0; i < links->ncurves; i++) kn_spline_clear(ctx, &links->curves[i]);
    kn_free(ctx, links->curves);
    kn_free(ctx, links->nodes);
    *links = (kn_trim_links){0};
}

static double distance(const double *a, const double *b)
{
    return hypot(a[0] - b[0], a[1] - b[1]);
}

static void run_backwards(kn_solve_curve *line)
{
    double *p = line->points;
    for (size_t i = 0, j = line->npoints - 1; i < j; i++, j--)
        for (size_t c = 0; c < 2; c++) {
            double t = p[2 * i + c];
            p[2 * i + c] = p[2 * j + c];
            p[2 * j + c] = t;
        }
}

// ---- nodes ----

static kn_status find_nodes(kn_ctx *ctx, kn_trim_links *out, const kn_trim_pieces *pieces)
{
    out->nodes = kn_alloc_zero(ctx, (size_t)pieces->n, sizeof *out->nodes);
    if (!out->nodes) return KN_ENOMEM;
    for (int i = 0, first = 0; i < pieces->nloops; first = pieces->loop_end[i++])
        for (int k = first; k < pieces->loop_end[i]; k++) {
            int next = k + 1 < pieces->loop_end[i] ? k + 1 : first;
            if (pieces->list[k].sign == pieces->list[next].sign) continue;
            kn_trim_node *node = &out->nodes[out->nnodes++];
            *node = (kn_trim_node){.from = k, .to = next, .enters = pieces->list[k].sign < 0};
            kn_trim_ends(&pieces->list[k].curve, NULL, node->at);
        }
    return KN_OK;
}

// The nearest place of all lines.
static double locate(kn_trim_node *node, const linking *l)
{
    double best = INFINITY;
    for (size_t k = 0; k < l->nlines; k++)
        for (size_t i = 0; i + 1 < l->lines[k].npoints; i++) {
            const double *a = l->lines[k].points + 2 * i, *b = a + 2;
            double d[2] = {b[0] - a[0], b[1] - a[1]}, length = d[0] * d[0] + d[1] * d[1];
            double t = length > 0.0 ? ((node->at[0] - a[0]) * d[0] + (node->at[1] - a[1]) * d[1]) / length : 0.0;
            t = fmin(fmax(t, 0.0), 1.0);
            double foot[2] = {a[0] + t * d[0], a[1] + t * d[1]}, far = distance(foot, node->at);
            if (far >= best) continue;
            best = far;
            node->curve = (int)k;
            node->where = (double)i + t;
        }
    return best;
}

static int compare(const void *a, const void *b)
{
    const kn_trim_node *x = *(kn_trim_node *const *)a, *y = *(kn_trim_node *const *)b;
    if (x->curve != y->curve) return x->curve < y->curve ? -1 : 1;
    return (x->where > y->where) - (x->where < y->where);
}

static kn_status touches(kn_ctx *ctx, const double at[2])
{
    return kn_fail(ctx, KN_EUNDECIDED,
                   "trim: the cut touches the boundary of the region, or nearly does, at "
                   "(%.9g, %.9g)",
                   at[0], at[1]);
}

static kn_status order_nodes(kn_ctx *ctx, linking *l)
{
    int n = l->out->nnodes;
    l->order = kn_scratch(ctx, (size_t)n + 1, sizeof(kn_trim_node *));
    if (!l->order) return KN_ENOMEM;
    for (int i = 0; i < n; i++) {
        l->order[i] = &l->out->nodes[i];
        if (!(locate(l->order[i], l) <= 1.01 * l->tol + on_line)) return touches(ctx, l->order[i]->at);
    }
    qsort(l->order, (size_t)n, sizeof(kn_trim_node *), compare);
    return KN_OK;
}

// ---- parts of lines ----

// Whether a corner of a line, near a node inside the square, lies in the region, or too near to tell.
static kn_status is_inside(kn_ctx *ctx, bool *yes, const linking *l, const double *p)
{
    kn_answer answer = KN_YES;
    kn_status status = KN_OK;
    if (l->trim->nloops > 0) status = kn_trim_contains(ctx, &answer, l->trim, p);
    *yes = answer == KN_YES;
    return status;
}

// Corners that the part from a to b keeps: not those on a node, and near nodes inside the square, where the line may
// be off by tol, only those that lie in the region.
static kn_status keeps(kn_ctx *ctx, bool *yes, const linking *l, const kn_trim_node *a, const kn_trim_node *b,
                       const double *p)
{
    *yes = true;
    for (int k = 0; k < 2; k++) {
        const kn_trim_node *node = k == 0 ? a : b;
        bool border = false;
        for (int c = 0; c < 2; c++) border = border || node->at[c] == 0.0 || node->at[c] == 1.0;
        double far = distance(node->at, p);
        if (far < (border ? 1e-9 : fmin(2.0 * l->tol, 0.25 * distance(a->at, b->at)))) *yes = false;
        if (*yes && !border && far < 16.0 * l->tol) {
            kn_status status = is_inside(ctx, yes, l, p);
            if (status != KN_OK) return status;
        }
    }
    return KN_OK;
}

static kn_status make_part(kn_ctx *ctx, linking *l, kn_trim_node *a, kn_trim_node *b)
{
    const kn_solve_curve *line = &l->lines[a->curve];
    size_t corners = line->npoints - 1, first = (size_t)floor(a->where) + 1, last = (size_t)ceil(b->where);
    if (b->where <= a->where) last += corners; // over the start of a closed line
    kn_mark mark = kn_scratch_mark(ctx);
    double *points = kn_scratch(ctx, 2 * (corners + 4), sizeof *points);
    kn_status status = points ? KN_OK : KN_ENOMEM;
    size_t n = 0;
    if (status == KN_OK) memcpy(points, a->at, sizeof a->at), n = 1;
    for (size_t i = first; status == KN_OK && i < last; i++) {
        const double *p = line->points + 2 * (i % corners == 0 && !line->closed ? i : i % corners);
        bool yes;
        status = keeps(ctx, &yes, l, a, b, p);
        if (status == KN_OK && yes) memcpy(points + 2 * n++, p, 2 * sizeof *p);
    }
    if (status == KN_OK) {
        memcpy(points + 2 * n++, b->at, sizeof b->at);
        status = kn_trim_polyline(ctx, &l->out->curves[l->out->ncurves], points, n);
    }
    if (status == KN_OK) {
        a->link = b->link = l->out->ncurves++;
        a->other = (int)(b - l->out->nodes), b->other = (int)(a - l->out->nodes);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// order[0 .. n - 1]: the nodes of one line.
static kn_status link_line(kn_ctx *ctx, linking *l, kn_trim_node **order, int n)
{
    bool closed = l->lines[order[0]->curve].closed;
    if (n % 2 != 0) return touches(ctx, order[0]->at);
    int start = closed && !order[0]->enters ? 1 : 0;
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < n; i += 2) {
        kn_trim_node *a = order[(start + i) % n], *b = order[(start + i + 1) % n];
        if (!a->enters || b->enters) return touches(ctx, a->at);
        status = make_part(ctx, l, a, b);
    }
    return status;
}

// ---- lines without nodes ----

static double extent(const kn_solve_curve *line)
{
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < 2 * line->npoints; i++) {
        lo[i % 2] = fmin(lo[i % 2], line->points[i]);
        hi[i % 2] = fmax(hi[i % 2], line->points[i]);
    }
    return fmax(hi[0] - lo[0], hi[1] - lo[1]);
}

static kn_status take_whole(kn_ctx *ctx, linking *l, const kn_solve_curve *line)
{
    const double *first = line->points, *last = first + 2 * (line->npoints - 1);
    double size = extent(line);
    if (size < on_line || (!line->closed && distance(first, last) < on_line && size < 4.0 * l->tol)) return KN_OK;
    kn_answer answer = line->closed || l->trim->nloops > 0 ? KN_UNKNOWN : KN_YES;
    kn_status status = KN_OK;
    if (line->closed && l->trim->nloops == 0) answer = KN_YES;
    size_t half = line->npoints / 2;
    for (size_t i = 0; status == KN_OK && answer == KN_UNKNOWN && i < line->npoints; i++)
        status = kn_trim_contains(ctx, &answer, l->trim, first + 2 * ((half + i) % line->npoints));
    if (status != KN_OK || answer == KN_NO) return status;
    if (answer == KN_UNKNOWN || !line->closed) return touches(ctx, first + 2 * half);
    status = kn_trim_polyline(ctx, &l->out->curves[l->out->ncurves], line->points, line->npoints);
    if (status == KN_OK) l->out->ncurves++;
    return status;
}

static kn_status link_all(kn_ctx *ctx, linking *l)
{
    int n = l->out->nnodes;
    l->out->curves = kn_alloc_zero(ctx, (size_t)n + l->nlines + 1, sizeof *l->out->curves);
    bool *used = kn_scratch(ctx, l->nlines + 1, sizeof *used);
    if (!l->out->curves || !used) return KN_ENOMEM;
    memset(used, 0, l->nlines + 1);
    kn_status status = KN_OK;
    for (int i = 0, count; status == KN_OK && i < n; i += count) {
        for (count = 1; i + count < n && l->order[i + count]->curve == l->order[i]->curve;) count++;
        used[l->order[i]->curve] = true;
        status = link_line(ctx, l, l->order + i, count);
    }
    l->out->nlinks = l->out->ncurves;
    for (size_t k = 0; status == KN_OK && k < l->nlines; k++)
        if (!used[k]) status = take_whole(ctx, l, &l->lines[k]);
    return status;
}

kn_status kn_trim_link(kn_ctx *ctx, kn_trim_links *out, const kn_trim_pieces *pieces, const kn_trim *trim,
                       const kn_bezier *g, double tol)
{
    kn_trim_links made = {0};
    linking l = {.out = &made, .trim = trim, .tol = tol};
    kn_solve_report report;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_solve_curves_bezier(ctx, &l.lines, &l.nlines, &report, g, tol);
    if (status == KN_OK && report.limited)
        status = kn_fail(ctx, KN_EUNDECIDED, "trim: the cut is too long or too wild to be followed to within %g",
                         tol);
    for (size_t k = 0; status == KN_OK && k < l.nlines; k++) run_backwards(&l.lines[k]);
    if (status == KN_OK) status = find_nodes(ctx, &made, pieces);
    if (status == KN_OK) status = order_nodes(ctx, &l);
    if (status == KN_OK) status = link_all(ctx, &l);
    kn_free(ctx, l.lines);
    kn_scratch_release(ctx, mark);
    if (status == KN_OK)
        *out = made;
    else
        kn_trim_links_clear(ctx, &made);
    return status;
}
