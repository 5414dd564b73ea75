// SPDX-License-Identifier: Apache-2.0
// A shell's life, and what it tells of itself.
#include "kernel/context.h"
#include "kernel/knots.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

static const double default_tol = 1e-6;
enum { DEFAULT_DEGREE = 5, DEFAULT_SPANS = 4096, HIGHEST_DEGREE = 12, HIGHEST_OF_CELLS = 18, MOST_CELLS = 1 << 24 };

kn_shell_options kn_shell_defaults(void)
{
    return (kn_shell_options){.normal_tol = default_tol, .max_spans = DEFAULT_SPANS};
}

// ---- life ----

static void clear_pieces(kn_ctx *ctx, kn_bezier *pieces, size_t n)
{
    for (size_t i = 0; pieces && i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
}

static void clear_field(kn_ctx *ctx, const kn_shell *shell, kn_shell_field *f)
{
    kn_spline_clear(ctx, &f->whole);
    clear_pieces(ctx, f->span, shell->nspans);
}

void kn_shell_destroy(kn_ctx *ctx, kn_shell *shell)
{
    if (!shell) return;
    kn_spline_clear(ctx, &shell->surface);
    kn_spline_clear(ctx, &shell->normal);
    kn_spline_clear(ctx, &shell->volume);
    kn_spline_clear(ctx, &shell->local);
    clear_field(ctx, shell, &shell->thickness);
    for (int k = 0; k < shell->nfields; k++) clear_field(ctx, shell, &shell->field[k]);
    for (size_t i = 0; i < shell->ndirections; i++) kn_direction_clear(ctx, &shell->direction[i]);
    kn_free(ctx, shell->direction);
    clear_pieces(ctx, shell->span, shell->nspans);
    clear_pieces(ctx, shell->local_span, shell->nspans);
    clear_pieces(ctx, shell->normal_piece, shell->nnormal_pieces);
    kn_free(ctx, shell->certificates);
    for (int v = 0; v < 2; v++) {
        kn_free(ctx, shell->line[v]);
        kn_free(ctx, shell->knot[v]);
        kn_free(ctx, shell->cut[v]);
        kn_free(ctx, shell->box[v]);
    }
    kn_free(ctx, shell);
}

static kn_status check(kn_ctx *ctx, const kn_spline *s, const kn_shell_options *o)
{
    kn_status status = kn_spline_check(ctx, s);
    if (status != KN_OK) return status;
    if (s->nvars != 2 || kn_spline_dim(s) != 3)
        return kn_fail(ctx, KN_EDOMAIN, "shell: %d variables and %d components, not a surface in space", s->nvars,
                       kn_spline_dim(s));
    if (s->degree[0] < 1 || s->degree[1] < 1)
        return kn_fail(ctx, KN_EDOMAIN, "shell: degrees %d, %d: no surface", s->degree[0], s->degree[1]);
    if (o->max_degree < KN_LEAST_DEGREE)
        return kn_fail(ctx, KN_EDOMAIN, "shell: max_degree %d, at least %d", o->max_degree, (int)KN_LEAST_DEGREE);
    if (o->max_degree > HIGHEST_DEGREE)
        return kn_fail(ctx, KN_ELIMIT, "shell: max_degree %d above %d", o->max_degree, (int)HIGHEST_DEGREE);
    return KN_OK;
}

kn_status kn_shell_resolve(kn_ctx *ctx, kn_shell_options *out, const kn_shell_options *options)
{
    kn_shell_options o = options ? *options : kn_shell_defaults();
    if (o.normal_tol == 0.0) o.normal_tol = default_tol;
    if (o.max_degree == 0) o.max_degree = o.normal == KN_NORMAL_FITTED ? DEFAULT_DEGREE : KN_LEAST_DEGREE;
    if (o.max_spans == 0) o.max_spans = DEFAULT_SPANS;
    if (o.normal != KN_NORMAL_FITTED && o.normal != KN_NORMAL_EXACT_DIRECTION)
        return kn_fail(ctx, KN_EDOMAIN, "shell: normal %d is no method", (int)o.normal);
    if (!(o.normal_tol > 0.0 && o.normal_tol < 0.5))
        return kn_fail(ctx, KN_EDOMAIN, "shell: normal_tol %g: a number above 0 and below 0.5 is needed",
                       o.normal_tol);
    if (o.max_spans < 1) return kn_fail(ctx, KN_EDOMAIN, "shell: max_spans %d", o.max_spans);
    *out = o;
    return KN_OK;
}

// ---- lines ----

// A line within rounding of a knot is that knot.
static kn_status take_lines(kn_ctx *ctx, kn_shell *s, int v, const double *lines, int nlines)
{
    int nk = s->nknots[v], hit = 0;
    const double *knot = s->knot[v];
    double close = 0x1p-48 * (fabs(knot[0]) + fabs(knot[nk - 1]));
    s->line[v] = kn_alloc(ctx, (size_t)nlines, sizeof *s->line[v]);
    if (!s->line[v]) return KN_ENOMEM;
    s->nlines[v] = nlines;
    for (int i = 0; i < nlines; i++) {
        double x = lines[i];
        if (hit < nk && fabs(x - knot[hit]) <= close) x = knot[hit++];
        if (!isfinite(x) || (i > 0 && !(x > s->line[v][i - 1])))
            return kn_fail(ctx, KN_EDOMAIN, "shell: cell line %d of variable %d is %g, after %g", i, v, x,
                           i > 0 ? s->line[v][i - 1] : -INFINITY);
        if (hit < nk && x > knot[hit]) break;
        s->line[v][i] = x;
    }
    if (hit < nk) return kn_fail(ctx, KN_EDOMAIN, "shell: knot %.17g of variable %d is no cell line", knot[hit], v);
    if (s->line[v][0] != knot[0] || s->line[v][nlines - 1] != knot[nk - 1])
        return kn_fail(ctx, KN_EDOMAIN, "shell: the cell lines of variable %d do not end with the domain", v);
    return KN_OK;
}

static kn_status set_lines(kn_ctx *ctx, kn_shell *s, const kn_shell_options *o)
{
    for (int v = 0; v < 2; v++) {
        const kn_spline *f = &s->surface;
        s->nknots[v] = kn_knots_spans(f->knots[v], f->degree[v], f->count[v]) + 1;
        s->knot[v] = kn_alloc(ctx, (size_t)s->nknots[v], sizeof *s->knot[v]);
        if (!s->knot[v]) return KN_ENOMEM;
        kn_knots_breaks(s->knot[v], NULL, f->knots[v], f->degree[v], f->count[v]);
        bool given = o->lines[v] != NULL;
        int n = given ? o->nlines[v] : s->nknots[v];
        if (n < 2) return kn_fail(ctx, KN_EDOMAIN, "shell: %d cell lines in variable %d", n, v);
        if (s->nknots[v] - 1 > o->max_spans)
            return kn_fail(ctx, KN_ELIMIT, "shell: %d knot spans in variable %d above max_spans %d", s->nknots[v] - 1,
                           v, o->max_spans);
        if (n - 1 > MOST_CELLS) return kn_fail(ctx, KN_ELIMIT, "shell: %d cells in variable %d", n - 1, v);
        kn_status status = take_lines(ctx, s, v, given ? o->lines[v] : s->knot[v], n);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

// ---- pieces ----

static kn_status cut_field(kn_ctx *ctx, const kn_shell *s, kn_shell_field *f)
{
    return f->whole.coef ? kn_shell_cut(ctx, &f->span, s, &f->whole) : KN_OK;
}

static kn_status cut_all(kn_ctx *ctx, kn_shell *s)
{
    size_t spans = (size_t)(s->nknots[0] - 1) * (size_t)(s->nknots[1] - 1);
    kn_status status = kn_shell_cut(ctx, &s->span, s, &s->surface);
    if (status != KN_OK) return status;
    s->nspans = spans;
    status = cut_field(ctx, s, &s->thickness);
    for (int k = 0; k < s->nfields && status == KN_OK; k++) status = cut_field(ctx, s, &s->field[k]);
    return status;
}

static kn_status make_local(kn_ctx *ctx, kn_shell *s)
{
    const kn_spline *f = s->volume.coef ? &s->volume : &s->surface;
    size_t spans = 0;
    kn_extent e = kn_extent_of(f);
    s->size = e.size, s->slack = e.slack;
    kn_status status = kn_spline_to_origin(ctx, &s->local, f);
    if (status == KN_OK && f == &s->surface) status = kn_spline_to_bezier(ctx, &s->local_span, &spans, &s->local);
    return status;
}

// The ends of f across variable v, which meet but for rounding, meet bit for bit.
static void close_ends(kn_spline *f, int v)
{
    size_t count = kn_spline_count(f), inner = 1, n = (size_t)f->count[v];
    for (int d = v + 1; d < f->nvars; d++) inner *= (size_t)f->count[d];
    for (size_t i = 0; i < (size_t)f->ncomp * count / n; i++) {
        double *first = f->coef + i / inner * n * inner + i % inner;
        first[(n - 1) * inner] = first[0];
    }
}

static kn_status find_closed(kn_ctx *ctx, kn_shell *s)
{
    kn_status status = KN_OK;
    for (int v = 0; v < 2; v++) {
        bool meet = true;
        if (s->volume.coef) {
            status = kn_shell_ends_meet(ctx, &meet, &s->volume, v);
        } else {
            status = kn_shell_ends_meet(ctx, &meet, &s->surface, v);
            if (status == KN_OK && meet && s->thickness.whole.coef)
                status = kn_shell_ends_meet(ctx, &meet, &s->thickness.whole, v);
            for (int k = 0; k < s->nfields && status == KN_OK && meet; k++)
                status = kn_shell_ends_meet(ctx, &meet, &s->field[k].whole, v);
        }
        if (status != KN_OK) return status;
        s->closed[v] = meet;
        if (!meet || s->volume.coef) continue;
        close_ends(&s->surface, v);
        if (s->thickness.whole.coef) close_ends(&s->thickness.whole, v);
        for (int k = 0; k < s->nfields; k++) close_ends(&s->field[k].whole, v);
    }
    return KN_OK;
}

kn_status kn_shell_set_boxes(kn_ctx *ctx, kn_shell *s)
{
    for (int v = 0; v < 2; v++) {
        double *box = kn_alloc(ctx, (size_t)s->nlines[v] + (size_t)s->ncuts[v], sizeof *box);
        if (!box) return KN_ENOMEM;
        int n = 0;
        for (int i = 0, k = 0; i < s->nlines[v] || k < s->ncuts[v];) {
            double line = i < s->nlines[v] ? s->line[v][i] : INFINITY,
                   cut = k < s->ncuts[v] ? s->cut[v][k] : INFINITY;
            box[n++] = fmin(line, cut);
            i += line <= cut;
            k += cut <= line;
        }
        s->box[v] = box;
        s->nboxes[v] = n - 1;
    }
    return KN_OK;
}

kn_status kn_shell_set_grid(kn_ctx *ctx, kn_shell *shell, const kn_shell_options *options)
{
    kn_status status = set_lines(ctx, shell, options);
    if (status == KN_OK) status = find_closed(ctx, shell);
    if (status == KN_OK) status = cut_all(ctx, shell);
    if (status == KN_OK) status = make_local(ctx, shell);
    if (status != KN_OK || shell->kind == KN_SHELL_NORMAL) return status;
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        shell->cut[v] = kn_alloc(ctx, (size_t)shell->nknots[v], sizeof *shell->cut[v]);
        if (!shell->cut[v]) return KN_ENOMEM;
        memcpy(shell->cut[v], shell->knot[v], (size_t)shell->nknots[v] * sizeof *shell->cut[v]);
        shell->ncuts[v] = shell->nknots[v];
    }
    shell->certificate = (kn_normal_certificate){.certified = true};
    return kn_shell_set_boxes(ctx, shell);
}

kn_status kn_shell_create(kn_ctx *ctx, kn_shell **out, const kn_spline *surface, const kn_shell_options *options)
{
    kn_shell_options o;
    kn_status status = kn_shell_resolve(ctx, &o, options);
    if (status == KN_OK) status = check(ctx, surface, &o);
    if (status != KN_OK) return status;
    kn_shell *s = kn_alloc_zero(ctx, 1, sizeof *s);
    if (!s) return KN_ENOMEM;
    s->method = o.normal;
    s->normal_tol = o.normal_tol;
    status = kn_spline_copy(ctx, &s->surface, surface);
    if (status == KN_OK) kn_snap_edges(&s->surface);
    if (status == KN_OK) status = kn_shell_take_fields(ctx, s, &o);
    if (status == KN_OK) status = kn_shell_set_grid(ctx, s, &o);
    if (status == KN_OK && s->kind == KN_SHELL_NORMAL) {
        status = kn_shell_make_directions(ctx, s);
        int highest = HIGHEST_OF_CELLS;
        if (status == KN_OK) status = kn_shell_limit_degree(ctx, &highest, s);
        if (status == KN_OK) status = kn_refine_normal(ctx, s, &o, highest);
        if (status == KN_OK) status = kn_shell_set_boxes(ctx, s);
        if (status == KN_OK) kn_shell_open_seams(s);
    }
    if (status == KN_OK)
        *out = s;
    else
        kn_shell_destroy(ctx, s);
    return status;
}

// ---- what it tells ----

const kn_spline *kn_shell_surface(const kn_shell *shell)
{
    return &shell->surface;
}

const kn_spline *kn_shell_normal(const kn_shell *shell)
{
    return shell->kind == KN_SHELL_DIRECTION ? &shell->field[0].whole : &shell->normal;
}

kn_normal_certificate kn_shell_certificate(const kn_shell *shell)
{
    return shell->certificate;
}

void kn_shell_cells(const kn_shell *shell, int cells[2])
{
    for (int v = 0; v < 2; v++) cells[v] = shell->nlines[v] - 1;
}

void kn_shell_closed(const kn_shell *shell, bool closed[2])
{
    for (int v = 0; v < 2; v++) closed[v] = shell->closed[v];
}

void kn_shell_heights(const kn_shell *shell, double w[2])
{
    w[0] = -INFINITY, w[1] = INFINITY;
    if (shell->volume.coef) kn_spline_domain(&shell->volume, 2, &w[0], &w[1]);
}
