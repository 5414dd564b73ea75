// SPDX-License-Identifier: Apache-2.0 The boundary of a region, cut where f changes its sign.  Along each curve f is
// a function F of one parameter: along an edge of the square the polynomial of f's coefficients there, and elsewhere
// f(curve(s)). Both are taken in a direction that does not depend on how the curve is run, so that the two regions
// beside it find the same roots, bit for bit.
#include "kernel/context.h"
#include "trim/internal.h"

#include <knurl/compose.h>
#include <math.h>

enum { MAX_CUTS = 4 * KN_MAX_DEGREE };

typedef struct walk {
    kn_trim_pieces *out;
    const kn_bezier *f, *g;
} walk;

// A function of one parameter over the part [lo,hi] of its domain, and where it changes its sign there.
typedef struct signs {
    kn_spline f;
    double lo, hi;
    double *at; // n of them, in scratch; sign[i] to the left of at[i], sign[n] to the right of the last
    int *sign;
    int n;
} signs;

void kn_trim_pieces_clear(kn_ctx *ctx, kn_trim_pieces *pieces)
{
    for (int i = 0; i < pieces->n; i++) kn_spline_clear(ctx, &pieces->list[i].curve);
    kn_free(ctx, pieces->list);
    kn_free(ctx, pieces->loop_end);
    *pieces = (kn_trim_pieces){0};
}

static kn_status append(kn_ctx *ctx, kn_trim_pieces *p, kn_spline *curve, int sign)
{
    if (p->n == p->room) {
        int room = p->room > 0 ? 2 * p->room : 16;
        kn_trim_piece *list = kn_resize(ctx, p->list, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        p->list = list;
        p->room = room;
    }
    p->list[p->n] = (kn_trim_piece){.sign = sign};
    kn_spline_swap(&p->list[p->n++].curve, curve);
    return KN_OK;
}

static double largest(const kn_spline *f)
{
    double most = 0.0;
    for (int i = 0; i < f->count[0]; i++) most = fmax(most, fabs(f->coef[i]));
    return most;
}

// The sign of F between two neighbouring places of its list: of the value that is farthest from 0 among three.
static kn_status sign_between(kn_ctx *ctx, int *sign, const kn_spline *f, double lo, double hi)
{
    double most = 0.0;
    for (int k = 1; k <= 3; k++) {
        double at = lo + (hi - lo) * k / 4.0, value;
        kn_status status = kn_spline_eval(ctx, &value, f, &at);
        if (status != KN_OK) return status;
        if (fabs(value) > fabs(most)) most = value;
    }
    if (!(fabs(most) > 0x1p-60 * largest(f)))
        return kn_fail(ctx, KN_EUNDECIDED, "trim: the cut runs along the boundary of the region");
    *sign = most > 0.0 ? 1 : -1;
    return KN_OK;
}

// Roots nearer than SMALL to one another, or to an end, count as one, or as none; and so do those where F keeps its
// sign.
static kn_status find_signs(kn_ctx *ctx, signs *s, double grid)
{
    kn_root *roots = NULL;
    size_t n = 0;
    kn_solve_report report;
    double small = KN_TRIM_SMALL * fmax(s->hi - s->lo, KN_TRIM_SMALL);
    kn_status status = kn_solve_roots(ctx, &roots, &n, &report, &s->f, NULL);
    if (status == KN_OK && (report.curve_like || report.limited))
        status = kn_fail(ctx, KN_EUNDECIDED, "trim: the cut runs along the boundary of the region");
    s->n = 0;
    s->at = status == KN_OK ? kn_scratch(ctx, n + 1, sizeof *s->at) : NULL;
    s->sign = status == KN_OK ? kn_scratch(ctx, n + 1, sizeof *s->sign) : NULL;
    if (status == KN_OK && (!s->at || !s->sign)) status = KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        double at = grid > 0.0 ? rint(roots[i].at[0] / grid) * grid : roots[i].at[0];
        double last = s->n > 0 ? s->at[s->n - 1] : s->lo;
        if (at > last + small && at < s->hi - small) s->at[s->n++] = at;
        if (roots[i].hi[0] - roots[i].lo[0] > 1e-6 * (s->hi - s->lo) && at > s->lo && at < s->hi)
            status = kn_fail(ctx, KN_EUNDECIDED, "trim: the cut may touch the boundary of the region");
    }
    int kept = 0;
    for (int i = 0; status == KN_OK && i <= s->n; i++) {
        int sign = 0;
        status = sign_between(ctx, &sign, &s->f, i > 0 ? s->at[i - 1] : s->lo, i < s->n ? s->at[i] : s->hi);
        if (status != KN_OK) break;
        if (i > 0 && sign != s->sign[kept]) s->at[kept++] = s->at[i - 1];
        s->sign[kept] = sign;
    }
    s->n = kept;
    kn_free(ctx, roots);
    return status;
}

// ---- edges of the square ----

// The variable along the edge on which the curve lies: 0, 1; -1 for other curves.
static int edge_of(const kn_spline *curve, double start[2], double end[2])
{
    if (curve->degree[0] != 1 || curve->count[0] != 2) return -1;
    kn_trim_ends(curve, start, end);
    for (int v = 0; v < 2; v++)
        if (start[1 - v] == end[1 - v] && (start[1 - v] == 0.0 || start[1 - v] == 1.0)) return v;
    return -1;
}

// f along the edge; all zero: false.
static bool edge_row(double *row, const kn_bezier *f, int v, bool upper)
{
    int n = f->degree[v], m = f->degree[1 - v];
    bool any = false;
    for (int i = 0; i <= n; i++) {
        int across = upper ? m : 0;
        row[i] = v == 0 ? f->coef[i * (f->degree[1] + 1) + across] : f->coef[across * (f->degree[1] + 1) + i];
        any = any || row[i] != 0.0;
    }
    return any;
}

static bool is_backward(const double *row, int n)
{
    for (int i = 0; i <= n; i++)
        if (row[i] != row[n - i]) return row[i] > row[n - i];
    return false;
}

static kn_status edge_function(kn_ctx *ctx, kn_spline *out, bool *backward, const walk *w, int v, bool upper)
{
    double row[KN_MAX_DEGREE + 1], run[KN_MAX_DEGREE + 1];
    const kn_bezier *f = w->f;
    if (!edge_row(row, f, v, upper)) {
        f = w->g;
        if (!edge_row(row, f, v, upper))
            return kn_fail(ctx, KN_EUNDECIDED, "trim: the cut runs along the boundary of the region");
    }
    int n = f->degree[v];
    *backward = is_backward(row, n);
    for (int i = 0; i <= n; i++) run[i] = *backward ? row[n - i] : row[i];
    const kn_bezier edge = {.nvars = 1, .ncomp = 1, .degree = {n}, .coef = run};
    return kn_spline_of_bezier(ctx, out, &edge);
}

// Roots are rounded to 2^-53, so that 1 - t is exact.
static kn_status cut_edge(kn_ctx *ctx, walk *w, int v, const double start[2], const double end[2])
{
    signs s = {0};
    bool backward = false;
    kn_spline curve = {0};
    double across = start[1 - v], a = start[v], b = end[v];
    kn_status status = edge_function(ctx, &s.f, &backward, w, v, across == 1.0);
    if (backward) a = 1.0 - a, b = 1.0 - b;
    s.lo = fmin(a, b), s.hi = fmax(a, b);
    if (status == KN_OK) status = find_signs(ctx, &s, 0x1p-53);
    for (int i = 0; status == KN_OK && i <= s.n; i++) {
        int k = a < b ? i : s.n - i; // along the boundary
        double from = a < b ? (k > 0 ? s.at[k - 1] : a) : (k < s.n ? s.at[k] : a);
        double to = a < b ? (k < s.n ? s.at[k] : b) : (k > 0 ? s.at[k - 1] : b);
        double p[4] = {across, across, across, across};
        p[v] = backward ? 1.0 - from : from;
        p[2 + v] = backward ? 1.0 - to : to;
        if (i == 0) p[v] = start[v];
        if (i == s.n) p[2 + v] = end[v];
        status = kn_trim_polyline(ctx, &curve, p, 2);
        if (status == KN_OK) status = append(ctx, w->out, &curve, s.sign[k]);
    }
    kn_spline_clear(ctx, &curve);
    kn_spline_clear(ctx, &s.f);
    return status;
}

// ---- other curves ----

static kn_status cut_curve(kn_ctx *ctx, walk *w, const kn_spline *curve)
{
    signs s = {0};
    kn_spline f = {0}, left = {0}, rest = {0};
    kn_spline_domain(curve, 0, &s.lo, &s.hi);
    bool turned = s.lo + s.hi < 0.0;
    kn_status status = kn_spline_copy(ctx, &rest, curve);
    if (status == KN_OK && turned) kn_trim_turn(&rest);
    if (status == KN_OK) kn_spline_domain(&rest, 0, &s.lo, &s.hi);
    if (status == KN_OK) status = kn_spline_of_bezier(ctx, &f, w->f);
    if (status == KN_OK) status = kn_spline_compose(ctx, &s.f, &f, &rest);
    if (status == KN_OK) status = find_signs(ctx, &s, 0.0);
    int first = w->out->n;
    for (int i = 0; status == KN_OK && i <= s.n; i++) {
        if (i < s.n)
            status = kn_spline_subdivide(ctx, &left, &rest, &rest, 0, s.at[i]);
        else
            kn_spline_swap(&left, &rest);
        if (status == KN_OK) status = append(ctx, w->out, &left, s.sign[i]);
    }
    for (int i = first, j = w->out->n - 1; status == KN_OK && turned && i <= j; i++, j--) {
        kn_trim_piece t = w->out->list[i];
        w->out->list[i] = w->out->list[j];
        w->out->list[j] = t;
        kn_trim_turn(&w->out->list[i].curve);
        if (i < j) kn_trim_turn(&w->out->list[j].curve);
    }
    kn_spline_clear(ctx, &f);
    kn_spline_clear(ctx, &left);
    kn_spline_clear(ctx, &rest);
    kn_spline_clear(ctx, &s.f);
    return status;
}

static kn_status walk_square(kn_ctx *ctx, walk *w)
{
    static const double corner[5][2] = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}, {0.0, 0.0}};
    kn_status status = KN_OK;
    for (int e = 0; status == KN_OK && e < 4; e++) status = cut_edge(ctx, w, e % 2, corner[e], corner[e + 1]);
    w->out->loop_end[0] = w->out->n;
    return status;
}

static kn_status walk_loops(kn_ctx *ctx, walk *w, const kn_trim *trim)
{
    kn_status status = KN_OK;
    for (int i = 0, k = 0; status == KN_OK && i < trim->nloops; i++) {
        for (; status == KN_OK && k < trim->loop_end[i]; k++) {
            double start[2], end[2];
            int v = edge_of(&trim->curves[k], start, end);
            kn_mark mark = kn_scratch_mark(ctx);
            status = v >= 0 ? cut_edge(ctx, w, v, start, end) : cut_curve(ctx, w, &trim->curves[k]);
            kn_scratch_release(ctx, mark);
        }
        w->out->loop_end[i] = w->out->n;
    }
    return status;
}

kn_status kn_trim_boundary(kn_ctx *ctx, kn_trim_pieces *out, const kn_trim *trim, const kn_bezier *f,
                           const kn_bezier *g)
{
    kn_trim_pieces made = {.nloops = trim->nloops > 0 ? trim->nloops : 1};
    walk w = {&made, f, g};
    made.loop_end = kn_alloc_zero(ctx, (size_t)made.nloops, sizeof *made.loop_end);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = made.loop_end ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) status = trim->nloops > 0 ? walk_loops(ctx, &w, trim) : walk_square(ctx, &w);
    kn_scratch_release(ctx, mark);
    if (status == KN_OK)
        *out = made;
    else
        kn_trim_pieces_clear(ctx, &made);
    return status;
}
