// SPDX-License-Identifier: Apache-2.0
// T over a box of (u,v) as one polynomial or rational piece.
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "trivar/piece.h"

#include <math.h>

typedef kn_piece_box box;

void kn_shell_piece_clear(kn_ctx *ctx, kn_shell_piece *piece)
{
    for (int k = 0; k < piece->nterms; k++) kn_bezier_clear(ctx, &piece->term[k]);
    *piece = (kn_shell_piece){0};
}

static double between(double a, double b, double t)
{
    return t == 1.0 ? b : a + t * (b - a);
}

// kn_interval for an x that is likely in the interval `near`.
static int interval(const double *breaks, int n, double x, int near)
{
    bool below = near > 0 && x < breaks[near], above = near < n - 2 && x >= breaks[near + 1];
    return below || above ? kn_interval(breaks, n, x) : near;
}

// Some interior break strictly between lo and hi, but for slack.
static bool has_inside(const double *breaks, int n, double lo, double hi, double slack, int near)
{
    int k = interval(breaks, n, lo + slack, near) + 1; // the first break above lo + slack that has one below it
    return k < n - 1 && breaks[k] < hi - slack;
}

static double snap(const double *breaks, int n, double x, double slack, int near)
{
    int k = interval(breaks, n, x, near);
    for (int i = k; i <= k + 1; i++)
        if (fabs(x - breaks[i]) <= slack) return breaks[i];
    return x;
}

void kn_piece_place(box *b, const kn_shell *s, int v, int cell, double lo, double hi)
{
    int cells = s->nlines[v] - 1;
    if (s->closed[v]) {
        cell = (cell % cells + cells) % cells;
    } else {
        int end = cell < 0 ? 0 : cell >= cells ? cells - 1 : cell;
        lo += cell - end, hi += cell - end;
        cell = end;
    }
    const double *line = s->line[v];
    double first = line[0], last = line[cells];
    double a = between(line[cell], line[cell + 1], lo), c = between(line[cell], line[cell + 1], hi);
    if (s->closed[v] && a >= last) a -= last - first, c -= last - first;
    if (s->closed[v] && c <= first) a += last - first, c += last - first;
    b->slack[v] = fmin(0x1p-46 * (fabs(first) + fabs(last)), 1e-6 * (c - a));
    int near = kn_interval(s->cut[v], s->ncuts[v], a + 0.5 * (c - a));
    b->lo[v] = a = snap(s->cut[v], s->ncuts[v], a, b->slack[v], near);
    b->hi[v] = c = snap(s->cut[v], s->ncuts[v], c, b->slack[v], near);
    double middle = a + 0.5 * (c - a);
    b->span[v] = kn_interval(s->knot[v], s->nknots[v], middle);
    b->cut[v] = interval(s->cut[v], s->ncuts[v], middle, near);
    b->crosses[v] = has_inside(s->knot[v], s->nknots[v], a, c, b->slack[v], b->span[v]);
    bool inside = a >= first && c <= last;
    b->inside = b->inside && inside;
    b->knotless = b->knotless && !has_inside(s->cut[v], s->ncuts[v], a, c, b->slack[v], b->cut[v]);
    b->plain = b->plain && inside && b->knotless;
}

void kn_piece_local(double *lo, double *hi, const box *b, int v, const double *breaks, int at)
{
    double a = breaks[at], width = breaks[at + 1] - a;
    *lo = (b->lo[v] - a) / width;
    *hi = b->hi[v] == breaks[at + 1] ? 1.0 : (b->hi[v] - a) / width;
}

// The box in the coordinates of an interval.
static void to_local(double lo[2], double hi[2], const box *b, double *const breaks[2], const int at[2])
{
    for (int v = 0; v < 2; v++) kn_piece_local(&lo[v], &hi[v], b, v, breaks[v], at[v]);
}

// What restricts to a box, in scratch memory: S and n over one span, of one degree, have it in common.
typedef struct restrictions {
    double lo[2], hi[2];
    int degree[2];
    double *matrix[2]; // NULL: none yet
} restrictions;

static const double *restriction(kn_ctx *ctx, restrictions *r, int v, int degree, double lo, double hi)
{
    if (r->matrix[v] && r->degree[v] == degree && r->lo[v] == lo && r->hi[v] == hi) return r->matrix[v];
    size_t side = (size_t)degree + 1;
    r->matrix[v] = kn_scratch(ctx, side * side, sizeof *r->matrix[v]);
    if (r->matrix[v]) kn_bernstein_restriction(r->matrix[v], degree, lo, hi);
    r->degree[v] = degree, r->lo[v] = lo, r->hi[v] = hi;
    return r->matrix[v];
}

// As kn_bezier_restrict, whose bits it has.
static kn_status restricted(kn_ctx *ctx, restrictions *r, kn_bezier *out, const kn_bezier *a, const double lo[2],
                            const double hi[2])
{
    if (lo[0] == 0.0 && lo[1] == 0.0 && hi[0] == 1.0 && hi[1] == 1.0) return kn_bezier_copy(ctx, out, a);
    bool finite = isfinite(lo[0]) && isfinite(lo[1]) && isfinite(hi[0]) && isfinite(hi[1]);
    if (!finite || (lo[0] == 0.0 && hi[0] == 1.0) || (lo[1] == 0.0 && hi[1] == 1.0))
        return kn_bezier_restrict(ctx, out, a, lo, hi);
    int m = a->degree[0] + 1, n = a->degree[1] + 1;
    size_t outer = (size_t)a->ncomp;
    const double *u = restriction(ctx, r, 0, m - 1, lo[0], hi[0]), *v = restriction(ctx, r, 1, n - 1, lo[1], hi[1]);
    double *work = kn_scratch(ctx, outer * kn_bezier_count(a), sizeof *work);
    kn_bezier made = {0};
    kn_status status = u && v && work ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) status = kn_bezier_init(ctx, &made, 2, a->ncomp, a->rational, a->degree);
    if (status != KN_OK) return status;
    kn_bernstein_transform(work, a->coef, outer, m, m, (size_t)n, u);
    kn_bernstein_transform(made.coef, work, outer * (size_t)m, n, n, 1, v);
    kn_bezier_swap(out, &made);
    kn_bezier_clear(ctx, &made);
    return KN_OK;
}

// ---- the field over the box ----

// The shell's own spline, or its end piece extended when that is still within the tolerance.
static kn_status own_normal(kn_ctx *ctx, restrictions *r, kn_bezier *n, kn_shell_piece *p, bool *fits,
                            const kn_shell *s, const box *b, const kn_bezier *direction, double direction_error)
{
    double lo[2], hi[2];
    size_t at = (size_t)b->cut[0] * (size_t)(s->ncuts[1] - 1) + (size_t)b->cut[1];
    to_local(lo, hi, b, s->cut, b->cut);
    *fits = true;
    kn_status status = restricted(ctx, r, n, &s->normal_piece[at], lo, hi);
    p->exact = true;
    p->deviation = 0.0;
    p->normal = s->certificates[at];
    if (status != KN_OK || b->inside) return status;
    kn_certify_options o = {.limit = s->normal_tol, .target = {s->normal_tol, s->normal_tol}};
    o.direction_error = direction_error;
    o.normal_error = kn_gamma(32.0 * (n->degree[0] + n->degree[1] + 2)) *
                     kn_largest_vector(&s->normal_piece[at], 0, 3);
    status = kn_certify(ctx, &p->normal, n, direction, &o);
    *fits = p->normal.certified;
    return status;
}

static kn_status other_normal(kn_ctx *ctx, kn_bezier *n, kn_shell_piece *p, bool *fits, const kn_shell *s,
                              const kn_bezier *direction, double direction_error, int degree_sum)
{
    kn_status status = KN_OK;
    bool exact = s->method == KN_NORMAL_EXACT_DIRECTION;
    status = kn_stand_in(ctx, n, &p->normal, fits, direction, direction_error, s->normal_tol, degree_sum, exact);
    if (status == KN_OK && *fits) {
        p->exact = false;
        p->deviation = p->normal.length_error + p->normal.angle_error + s->certificate.length_error +
                       s->certificate.angle_error;
    }
    return status;
}

static kn_status find_normal(kn_ctx *ctx, restrictions *r, kn_bezier *n, kn_shell_piece *p, bool *fits,
                             const kn_shell *s, const box *b, int degree_sum)
{
    const kn_direction *d = &s->direction[b->span[0] * (s->nknots[1] - 1) + b->span[1]];
    double lo[2], hi[2], growth = 1.0, error = d->error;
    kn_bezier direction = {0};
    kn_status status = KN_OK;
    *fits = false;
    if (!b->plain) {
        to_local(lo, hi, b, s->knot, b->span);
        status = kn_bezier_restrict(ctx, &direction, &d->n, lo, hi);
        // Beyond the span the polynomial grows by up to (1 + 2 reach)^degree, and so do errors.
        for (int v = 0; v < 2 && status == KN_OK; v++) {
            double reach = fmax(0.0, fmax(-lo[v], hi[v] - 1.0));
            growth *= pow(1.0 + 2.0 * reach, d->n.degree[v]);
        }
    }
    if (status == KN_OK && !b->plain)
        error = growth *
                (error + kn_gamma(8.0 * (d->n.degree[0] + d->n.degree[1] + 4)) * kn_largest_vector(&d->n, 0, 3));
    if (status == KN_OK && b->knotless) status = own_normal(ctx, r, n, p, fits, s, b, &direction, error);
    if (status == KN_OK && !*fits) status = other_normal(ctx, n, p, fits, s, &direction, error, degree_sum);
    kn_bezier_clear(ctx, &direction);
    return status;
}

// ---- T ----

// (W n, 0): then T = (P + w W n) / W in homogeneous coordinates. out may be n.
static kn_status with_weight(kn_ctx *ctx, kn_bezier *out, const kn_bezier *n, const kn_bezier *s)
{
    kn_bezier w = {0}, wn = {0}, term = {0};
    kn_status status = kn_bezier_components(ctx, &w, s, 3, 1);
    if (status == KN_OK) status = kn_bezier_product(ctx, &wn, &w, n);
    if (status == KN_OK) status = kn_bezier_init(ctx, &term, 2, 4, true, wn.degree);
    for (size_t i = 0; status == KN_OK && i < 3 * kn_bezier_count(&wn); i++) term.coef[i] = wn.coef[i];
    if (status == KN_OK) kn_bezier_swap(out, &term);
    kn_bezier_clear(ctx, &w);
    kn_bezier_clear(ctx, &wn);
    kn_bezier_clear(ctx, &term);
    return status;
}

// A field over the box: of the span that it lies in, extended. Coefficients along an edge are rows of the restriction
// that depend on where that edge lies alone: boxes that share it get the same ones, bit for bit.
static kn_status over_box(kn_ctx *ctx, restrictions *r, kn_bezier *out, const kn_bezier *span, const kn_shell *s,
                          const box *b)
{
    double lo[2], hi[2];
    to_local(lo, hi, b, s->knot, b->span);
    return restricted(ctx, r, out, &span[b->span[0] * (s->nknots[1] - 1) + b->span[1]], lo, hi);
}

// Appends f w^power.
static kn_status add_term(kn_ctx *ctx, kn_shell_piece *p, kn_bezier *f, int power, bool homogeneous)
{
    kn_status status = KN_OK;
    if (p->term[0].rational && !homogeneous) status = with_weight(ctx, f, f, &p->term[0]);
    if (status != KN_OK) return status;
    f->rational = p->term[0].rational;
    p->power[p->nterms] = power;
    kn_bezier_swap(&p->term[p->nterms++], f);
    return KN_OK;
}

// h n, and what that makes of n's deviation.
static kn_status thicken(kn_ctx *ctx, restrictions *r, kn_shell_piece *p, kn_bezier *n, const kn_shell *s,
                         const box *b)
{
    kn_bezier h = {0};
    kn_status status = over_box(ctx, r, &h, s->thickness.span, s, b);
    if (status == KN_OK) status = kn_bezier_product(ctx, n, &h, n);
    if (status == KN_OK) p->deviation *= kn_largest_vector(&h, 0, 1) * (1.0 + 0x1p-40); // and h's own rounding
    kn_bezier_clear(ctx, &h);
    return status;
}

static kn_status make_terms(kn_ctx *ctx, restrictions *r, kn_shell_piece *p, kn_bezier *n, const kn_shell *s,
                            const box *b)
{
    kn_bezier f = {0};
    kn_status status = over_box(ctx, r, &p->term[0], s->span, s, b);
    p->nterms = 1;
    if (status == KN_OK && n->coef && s->thickness.whole.coef) status = thicken(ctx, r, p, n, s, b);
    if (status == KN_OK && n->coef) status = add_term(ctx, p, n, 1, false);
    for (int k = 0; k < s->nfields && status == KN_OK; k++) {
        const kn_shell_field *field = &s->field[k];
        status = over_box(ctx, r, &f, field->span, s, b);
        if (status == KN_OK) status = add_term(ctx, p, &f, field->power, s->homogeneous);
    }
    kn_bezier_clear(ctx, &f);
    return status;
}

// ---- what is known without coefficients ----

static void add_outline(kn_shell_piece *p, const int degree[2], int power, bool homogeneous)
{
    const kn_bezier *s = &p->term[0];
    kn_bezier *t = &p->term[p->nterms];
    bool times_weight = p->nterms > 0 && s->rational && !homogeneous;
    *t = (kn_bezier){.nvars = 2, .ncomp = s->rational ? 4 : 3, .rational = s->rational};
    for (int v = 0; v < 2; v++) t->degree[v] = degree[v] + (times_weight ? s->degree[v] : 0);
    p->power[p->nterms++] = power;
}

static void make_outline(kn_shell_piece *p, const kn_shell *s, const box *b)
{
    size_t span = (size_t)b->span[0] * (size_t)(s->nknots[1] - 1) + (size_t)b->span[1];
    p->term[0].rational = s->span[span].rational;
    add_outline(p, s->span[span].degree, 0, false);
    if (s->kind == KN_SHELL_NORMAL) {
        size_t cut = (size_t)b->cut[0] * (size_t)(s->ncuts[1] - 1) + (size_t)b->cut[1];
        int degree[2];
        for (int v = 0; v < 2; v++)
            degree[v] = s->normal_piece[cut].degree[v] +
                        (s->thickness.whole.coef ? s->thickness.span[span].degree[v] : 0);
        p->normal = s->certificates[cut];
        add_outline(p, degree, 1, false);
    }
    for (int k = 0; k < s->nfields; k++)
        add_outline(p, s->field[k].span[span].degree, s->field[k].power, s->homogeneous);
}

static kn_status find_box(kn_ctx *ctx, box *b, const kn_shell *shell, const int cell[2], const double lo[2],
                          const double hi[2])
{
    *b = KN_PIECE_BOX;
    if (!kn_shell_has_terms(shell)) return kn_fail(ctx, KN_EDOMAIN, "shell piece: the volume has knots in w");
    for (int v = 0; v < 2; v++) {
        if (!(lo[v] < hi[v]) || !isfinite(hi[v] - lo[v]))
            return kn_fail(ctx, KN_EDOMAIN, "shell piece: box [%g, %g] in variable %d", lo[v], hi[v], v);
        kn_piece_place(b, shell, v, cell[v], lo[v], hi[v]);
        if (b->crosses[v])
            return kn_fail(ctx, KN_EDOMAIN, "shell piece: [%g, %g] of cell %d has a knot of the surface inside",
                           lo[v], hi[v], cell[v]);
    }
    return KN_OK;
}

static kn_status make_piece(kn_ctx *ctx, kn_shell_piece *out, bool *fits, const kn_shell *shell, const box *b,
                            int degree_sum)
{
    kn_shell_piece p = {.exact = true, .normal = shell->certificate};
    kn_bezier n = {0};
    bool found = true;
    restrictions r = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = KN_OK;
    if (shell->kind == KN_SHELL_NORMAL) status = find_normal(ctx, &r, &n, &p, &found, shell, b, degree_sum);
    if (status == KN_OK && found) status = make_terms(ctx, &r, &p, &n, shell, b);
    kn_scratch_release(ctx, mark);
    kn_bezier_clear(ctx, &n);
    if (status == KN_OK) *fits = found;
    if (status == KN_OK && found)
        *out = p;
    else
        kn_shell_piece_clear(ctx, &p);
    return status;
}

kn_status kn_shell_piece_outline(kn_ctx *ctx, kn_shell_piece *out, bool *fits, const kn_shell *shell,
                                 const int cell[2], const double lo[2], const double hi[2], int degree_sum)
{
    box b;
    kn_status status = find_box(ctx, &b, shell, cell, lo, hi);
    if (status != KN_OK) return status;
    if (!b.plain) return make_piece(ctx, out, fits, shell, &b, degree_sum);
    *out = (kn_shell_piece){.exact = true, .normal = shell->certificate};
    make_outline(out, shell, &b);
    *fits = true;
    return KN_OK;
}

kn_status kn_shell_piece_init(kn_ctx *ctx, kn_shell_piece *out, bool *fits, const kn_shell *shell, const int cell[2],
                              const double lo[2], const double hi[2], int degree_sum)
{
    box b;
    kn_status status = find_box(ctx, &b, shell, cell, lo, hi);
    return status == KN_OK ? make_piece(ctx, out, fits, shell, &b, degree_sum) : status;
}
