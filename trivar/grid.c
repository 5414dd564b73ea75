// SPDX-License-Identifier: Apache-2.0
// One variable of the fitted normal: lines, continuity across them, knots, and the sites of interpolation.
#include "kernel/context.h"
#include "kernel/knots.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

// ---- does the normal go on across a knot line of S? ----

enum { PLACES = 9 }; // in each span along the line

// The largest distance between the unit normals on the two sides of interior knot k of variable var.
static double jump(const kn_shell *s, int var, int k)
{
    int other = 1 - var, along = s->nknots[other] - 1, columns = s->nknots[1] - 1;
    double worst = 0.0;
    for (int j = 0; j < along * PLACES; j++) {
        int below = var == 0 ? (k - 1) * columns + j / PLACES : j / PLACES * columns + k - 1;
        int above = below + (var == 0 ? columns : 1);
        double x[2], a[3], b[3], square = 0.0;
        x[other] = (double)(j % PLACES) / (PLACES - 1);
        x[var] = 1.0;
        bool there = kn_direction_unit(a, &s->direction[below].n, x);
        x[var] = 0.0;
        there = kn_direction_unit(b, &s->direction[above].n, x) && there;
        for (int c = 0; c < 3; c++) square += (a[c] - b[c]) * (a[c] - b[c]);
        worst = there ? fmax(worst, sqrt(square)) : INFINITY;
    }
    return worst;
}

// The largest order of a factor divided out along an end of the domain.
static int edge_order(const kn_shell *s, int var, int end)
{
    int columns = s->nknots[1] - 1, along = s->nknots[1 - var] - 1, row = end ? s->nknots[var] - 2 : 0, most = 0;
    for (int j = 0; j < along; j++) {
        int order = s->direction[var == 0 ? row * columns + j : j * columns + row].order[var][end];
        most = order > most ? order : most;
    }
    return most;
}

// An edge factor that was divided out on either side leaves nothing known of the derivatives across.
static bool divided(const kn_shell *s, int var, int k)
{
    int columns = s->nknots[1] - 1, along = s->nknots[1 - var] - 1;
    for (int j = 0; j < along; j++) {
        int below = var == 0 ? (k - 1) * columns + j : j * columns + k - 1;
        if (s->direction[below].order[var][1] > 0) return true;
        if (s->direction[below + (var == 0 ? columns : 1)].order[var][0] > 0) return true;
    }
    return false;
}

// An edge factor at the far side of either span is 1 on the line, but not constant: N/x goes on with N as C0 alone.
static bool divided_beyond(const kn_shell *s, int var, int k)
{
    return (k == 1 && edge_order(s, var, 0) > 0) || (k == s->nknots[var] - 2 && edge_order(s, var, 1) > 0) ||
           (k > 1 && divided(s, var, k - 1)) || (k < s->nknots[var] - 2 && divided(s, var, k + 1));
}

// S is C^(degree - times) there and n once less. Where that says nothing, S may still be smooth as a shape, as the
// arcs of a rational circle are: n is joined where both sides agree to a tenth of the tolerance. N m needs more, for
// m is as smooth as N is, which knows how fast S runs and not only where.
static int continuity(const kn_shell *s, int var, int k, int times)
{
    bool exact = s->method == KN_NORMAL_EXACT_DIRECTION;
    int smooth = s->surface.degree[var] - times - 1;
    if (exact && !kn_lengths_continue(s, var, k)) return -1;
    if (smooth >= 0 && !divided(s, var, k)) return exact && divided_beyond(s, var, k) ? 0 : smooth;
    return jump(s, var, k) <= 0.1 * s->normal_tol ? 0 : -1;
}

// ---- life ----

void kn_grid_clear(kn_ctx *ctx, kn_grid_axis *g)
{
    kn_free(ctx, g->cut);
    kn_free(ctx, g->smooth);
    kn_free(ctx, g->knots);
    kn_free(ctx, g->site);
    kn_free(ctx, g->site_span);
    kn_free(ctx, g->site_knot_span);
    *g = (kn_grid_axis){0};
}

static kn_status reserve(kn_ctx *ctx, kn_grid_axis *g, int ncuts)
{
    if (ncuts <= g->room) return KN_OK;
    int room = 2 * ncuts;
    double *cut = kn_resize(ctx, g->cut, (size_t)room, sizeof *cut);
    if (!cut) return KN_ENOMEM;
    g->cut = cut;
    int *smooth = kn_resize(ctx, g->smooth, (size_t)room, sizeof *smooth);
    if (!smooth) return KN_ENOMEM;
    g->smooth = smooth;
    g->room = room;
    return KN_OK;
}

static int most_cuts(const kn_shell *shell, int var)
{
    return KN_GRID_LINES + 2 * shell->nknots[var];
}

// Line j of n parts of `cells` cells, the same ones counted from either end: two surfaces that share an edge, whose
// lines meet there, choose the same.
static int spread_line(int cells, int n, int j)
{
    if (2 * j > n) return cells - spread_line(cells, n, n - j);
    return (int)((2 * (int64_t)j * cells + n) / (2 * (int64_t)n));
}

// All lines, or of each span of S a share of KN_GRID_LINES: so many suffice mostly, and n does not grow with the
// number of cells.
static int choose_lines(double *cut, const kn_shell *s, int var)
{
    const double *line = s->line[var], *knot = s->knot[var];
    int total = s->nlines[var] - 1, n = 0;
    for (int k = 0, first = 0, last; k + 1 < s->nknots[var]; k++, first = last) {
        for (last = first; line[last] < knot[k + 1];) last++;
        int cells = last - first, parts = cells;
        if (total > KN_GRID_LINES) {
            parts = (int)((2 * (int64_t)KN_GRID_LINES * cells + total) / (2 * (int64_t)total));
            parts = parts < 1 ? 1 : parts > cells ? cells : parts;
            if (parts % 2 == 0 && cells % 2 == 1) parts--; // no line is in the middle
        }
        for (int j = 0; j < parts; j++) cut[n++] = line[first + spread_line(cells, parts, j)];
    }
    cut[n++] = line[total];
    return n;
}

kn_status kn_grid_init(kn_ctx *ctx, kn_grid_axis *g, const kn_shell *shell, int var)
{
    const kn_spline *s = &shell->surface;
    int n = shell->nlines[var] < most_cuts(shell, var) ? shell->nlines[var] : most_cuts(shell, var);
    *g = (kn_grid_axis){.line = shell->line[var], .nlines = shell->nlines[var], .most = KN_SMOOTH};
    kn_mark mark = kn_scratch_mark(ctx);
    int *times = kn_scratch(ctx, (size_t)shell->nknots[var], sizeof *times);
    kn_status status = times ? reserve(ctx, g, n) : KN_ENOMEM;
    if (status == KN_OK) {
        kn_knots_breaks(NULL, times, s->knots[var], s->degree[var], s->count[var]);
        n = g->ncuts = choose_lines(g->cut, shell, var);
        for (int i = 0, k = 0; i < n; i++) {
            bool knot = k < shell->nknots[var] && g->cut[i] == shell->knot[var][k];
            bool interior = i > 0 && i < n - 1;
            g->smooth[i] = knot && interior ? continuity(shell, var, k, times[k]) : KN_SMOOTH;
            k += knot;
        }
    }
    kn_scratch_release(ctx, mark);
    if (status != KN_OK) kn_grid_clear(ctx, g);
    return status;
}

// The cell line between a and b that is nearest to their middle; that itself where there is none.
static double middle_line(const kn_grid_axis *g, double a, double b)
{
    double middle = a + 0.5 * (b - a), best = middle, off = INFINITY;
    int at = kn_interval(g->line, g->nlines, middle);
    for (int i = at; i <= at + 1 && i < g->nlines; i++) {
        double x = g->line[i];
        if (!(x > a && x < b) || !(fabs(x - middle) < off)) continue;
        off = fabs(x - middle);
        best = x;
    }
    return best;
}

kn_status kn_grid_split(kn_ctx *ctx, kn_grid_axis *g, const char *split)
{
    int more = 0, n = g->ncuts;
    for (int i = 0; i + 1 < n; i++) more += split[i] != 0;
    kn_status status = reserve(ctx, g, n + more);
    if (status != KN_OK) return status;
    g->ncuts = n + more;
    for (int i = n - 1, to = n + more - 1; i >= 0; i--) {
        g->cut[to] = g->cut[i];
        g->smooth[to--] = g->smooth[i];
        if (i > 0 && split[i - 1]) {
            g->cut[to] = middle_line(g, g->cut[i - 1], g->cut[i]);
            g->smooth[to--] = KN_SMOOTH;
        }
    }
    return KN_OK;
}

// ---- what follows from a degree ----

static int continuity_of(const kn_grid_axis *g, int i, int degree)
{
    int smooth = g->most < g->smooth[i] ? g->most : g->smooth[i];
    return smooth < degree - 1 ? smooth : degree - 1;
}

int kn_grid_continuity(const kn_grid_axis *g, int i)
{
    return continuity_of(g, i, g->degree);
}

static int times_at(const kn_grid_axis *g, int i, int degree)
{
    return i == 0 || i == g->ncuts - 1 ? degree + 1 : degree - continuity_of(g, i, degree);
}

// Chebyshev-Lobatto sites in the intervals over which n is a polynomial for itself, and C0 or less at both ends: they
// serve any degree, where even ones fail from 10 on.
static void place_lobatto(kn_grid_axis *g)
{
    const double pi = 3.14159265358979323846;
    int p = g->degree;
    for (int i = 0, end = 0; i + 1 < g->ncuts; i++) { // end: of the knots at cut i
        int times = times_at(g, i, p);
        end += times;
        if (times < p || times_at(g, i + 1, p) < p) continue;
        for (int k = 1; k < p; k++)
            g->site[end - 1 - p + k] = g->cut[i] + (g->cut[i + 1] - g->cut[i]) * (0.5 - 0.5 * cos(pi * k / p));
    }
}

// Greville's sites: the ends are among them, so that the coefficients of an edge depend on that edge alone. Where n
// jumps two sites coincide, and each takes the polynomials of its own side.
static void place_sites(kn_grid_axis *g, const double *breaks, int nbreaks)
{
    int p = g->degree, n = g->count;
    const double *t = g->knots;
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int k = 1; k <= p; k++) sum += t[i + k] - t[i + 1];
        double x = t[i + 1] + sum / p; // exact where all are equal
        bool left = x >= t[i + p + 1]; // the last B-spline before a jump or the end
        int span = kn_knots_span(t, p, n, x), from = kn_interval(breaks, nbreaks, x);
        if (left && i < n - 1) {
            span = i; // knots i+1 .. i+p+1 coincide
            from -= 1;
        }
        g->site[i] = x;
        g->site_knot_span[i] = span;
        g->site_span[i] = from;
    }
    place_lobatto(g); // in the same spans
}

kn_status kn_grid_set_degree(kn_ctx *ctx, kn_grid_axis *g, int degree, const double *breaks, int nbreaks)
{
    int total = 0;
    for (int i = 0; i < g->ncuts; i++) total += times_at(g, i, degree);
    size_t count = (size_t)(total - degree - 1);
    double *knots = kn_alloc(ctx, (size_t)total, sizeof *knots), *site = kn_alloc(ctx, count, sizeof *site);
    int *span = kn_alloc(ctx, count, sizeof *span), *knot_span = kn_alloc(ctx, count, sizeof *knot_span);
    bool room = knots && site && span && knot_span;
    if (room) {
        kn_grid_axis old = *g;
        g->degree = degree;
        g->count = (int)count;
        g->knots = knots, g->site = site, g->site_span = span, g->site_knot_span = knot_span;
        knots = old.knots, site = old.site, span = old.site_span, knot_span = old.site_knot_span;
        for (int i = 0, to = 0; i < g->ncuts; i++)
            for (int k = times_at(g, i, degree); k > 0; k--) g->knots[to++] = g->cut[i];
        place_sites(g, breaks, nbreaks);
    }
    kn_free(ctx, knots);
    kn_free(ctx, site);
    kn_free(ctx, span);
    kn_free(ctx, knot_span);
    return room ? KN_OK : KN_ENOMEM;
}
