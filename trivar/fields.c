// SPDX-License-Identifier: Apache-2.0
// The fields that displace S: thickness, a direction in place of the normal, attraction.
#include "kernel/context.h"
#include "kernel/knots.h"
#include "trivar/internal.h"

#include <knurl/solve.h>

#include <math.h>

// ---- checks ----

static kn_status check_field(kn_ctx *ctx, const kn_spline *f, int dim, const kn_spline *surface, const char *name)
{
    kn_status status = kn_spline_check(ctx, f);
    if (status != KN_OK) return status;
    if (f->nvars != 2 || f->ncomp != dim || f->rational)
        return kn_fail(ctx, KN_EDOMAIN, "shell: %s has %d variables, %d components%s, and not 2, %d, polynomial",
                       name, f->nvars, f->ncomp, f->rational ? ", rational" : "", dim);
    for (int v = 0; v < 2; v++) {
        double lo, hi, a, b;
        kn_spline_domain(f, v, &lo, &hi);
        kn_spline_domain(surface, v, &a, &b);
        if (lo != a || hi != b)
            return kn_fail(ctx, KN_EDOMAIN, "shell: %s over [%g, %g] in variable %d, the surface over [%g, %g]", name,
                           lo, hi, v, a, b);
    }
    return KN_OK;
}

// Positive coefficients suffice; otherwise the sign of every piece, certified.
static kn_status check_positive(kn_ctx *ctx, const kn_spline *h)
{
    enum { DEPTH = 24 };
    bool positive = true;
    for (size_t i = 0; i < kn_spline_count(h); i++) positive = positive && h->coef[i] > 0.0;
    if (positive) return KN_OK;
    kn_bezier *piece = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &piece, &n, h);
    positive = true;
    for (size_t i = 0; i < n; i++) {
        kn_sign sign = KN_SIGN_UNKNOWN;
        if (status == KN_OK && positive) status = kn_solve_sign(ctx, &sign, &piece[i], NULL, NULL, DEPTH);
        positive = positive && sign == KN_SIGN_POSITIVE;
        kn_bezier_clear(ctx, &piece[i]);
    }
    kn_free(ctx, piece);
    if (status == KN_OK && !positive)
        status = kn_fail(ctx, KN_EDOMAIN, "shell: the thickness is not certainly positive");
    return status;
}

// ---- knots ----

// A knot of f within rounding of one of S is that knot.
static void snap_knots(kn_spline *f, const kn_spline *surface, int v)
{
    const double *t = surface->knots[v];
    int n = surface->count[v] + surface->degree[v];
    double close = 0x1p-48 * (fabs(t[0]) + fabs(t[n]));
    for (int i = 0, k = 0; i <= f->count[v] + f->degree[v]; i++) {
        while (k < n && t[k] < f->knots[v][i] - close) k++;
        if (fabs(t[k] - f->knots[v][i]) <= close) f->knots[v][i] = t[k];
    }
}

// The breaks of a that b does not have; out has room for all of a's.
static int missing(double *out, const double *a, int na, const double *b, int nb)
{
    int n = 0;
    for (int i = 0, k = 0; i < na; i++) {
        while (k < nb && b[k] < a[i]) k++;
        if (k == nb || b[k] != a[i]) out[n++] = a[i];
    }
    return n;
}

static kn_status insert_breaks(kn_ctx *ctx, kn_spline *out, int v, const double *breaks, int nbreaks)
{
    int own = kn_knots_spans(out->knots[v], out->degree[v], out->count[v]) + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    double *have = kn_scratch(ctx, (size_t)own, sizeof *have), *more = kn_scratch(ctx, (size_t)nbreaks, sizeof *more);
    kn_status status = have && more ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        kn_knots_breaks(have, NULL, out->knots[v], out->degree[v], out->count[v]);
        int n = missing(more, breaks, nbreaks, have, own);
        if (n > 0) status = kn_spline_insert_knots(ctx, out, out, v, more, n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status insert_breaks_of(kn_ctx *ctx, kn_spline *surface, const kn_spline *f)
{
    kn_status status = KN_OK;
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        int n = kn_knots_spans(f->knots[v], f->degree[v], f->count[v]) + 1;
        kn_mark mark = kn_scratch_mark(ctx);
        double *breaks = kn_scratch(ctx, (size_t)n, sizeof *breaks);
        status = breaks ? KN_OK : KN_ENOMEM;
        if (breaks) kn_knots_breaks(breaks, NULL, f->knots[v], f->degree[v], f->count[v]);
        if (breaks) status = insert_breaks(ctx, surface, v, breaks, n);
        kn_scratch_release(ctx, mark);
    }
    return status;
}

// ---- taking ----

static kn_status take(kn_ctx *ctx, kn_shell *s, kn_shell_field *to, const kn_spline *f, int dim, const char *name)
{
    kn_status status = check_field(ctx, f, dim, &s->surface, name);
    if (status == KN_OK) status = kn_spline_copy(ctx, &to->whole, f);
    for (int v = 0; v < 2 && status == KN_OK; v++) snap_knots(&to->whole, &s->surface, v);
    if (status == KN_OK) status = kn_spline_check(ctx, &to->whole);
    if (status == KN_OK) status = insert_breaks_of(ctx, &s->surface, &to->whole);
    return status;
}

kn_status kn_shell_take_fields(kn_ctx *ctx, kn_shell *s, const kn_shell_options *o)
{
    kn_status status = KN_OK;
    if (o->attraction && (o->attraction_power < 0 || o->attraction_power > KN_MAX_DEGREE))
        return kn_fail(ctx, o->attraction_power < 0 ? KN_EDOMAIN : KN_ELIMIT, "shell: attraction with w^%d",
                       o->attraction_power);
    s->kind = o->direction ? KN_SHELL_DIRECTION : KN_SHELL_NORMAL;
    if (o->thickness) status = take(ctx, s, &s->thickness, o->thickness, 1, "the thickness");
    if (o->thickness && status == KN_OK) status = check_positive(ctx, &s->thickness.whole);
    if (o->direction && status == KN_OK) {
        kn_shell_field *to = &s->field[s->nfields++];
        to->power = 1;
        status = take(ctx, s, to, o->direction, 3, "the direction");
        if (o->thickness && status == KN_OK)
            status = kn_spline_product(ctx, &to->whole, &s->thickness.whole, &to->whole);
        kn_spline_clear(ctx, &s->thickness.whole);
    }
    if (o->attraction && status == KN_OK) {
        kn_shell_field *to = &s->field[s->nfields++];
        to->power = o->attraction_power > 0 ? o->attraction_power : 2;
        status = take(ctx, s, to, o->attraction, 3, "the attraction");
    }
    return status;
}

// ---- pieces ----

kn_status kn_shell_cut(kn_ctx *ctx, kn_bezier **span, const kn_shell *shell, const kn_spline *f)
{
    kn_spline fine = {0};
    size_t nspans = 0;
    kn_status status = kn_spline_copy(ctx, &fine, f);
    for (int v = 0; v < 2 && status == KN_OK; v++)
        status = insert_breaks(ctx, &fine, v, shell->knot[v], shell->nknots[v]);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, span, &nspans, &fine);
    kn_spline_clear(ctx, &fine);
    return status;
}

kn_status kn_shell_ends_meet(kn_ctx *ctx, bool *meet, const kn_spline *f, int var)
{
    double lo[KN_MAX_COMPS], hi[KN_MAX_COMPS], size = 0.0, far = 0.0, worst = 0.0;
    kn_status status = kn_spline_box(ctx, lo, hi, f);
    if (status != KN_OK) return status;
    int dim = kn_spline_dim(f), n = f->count[var];
    for (int c = 0; c < dim; c++) size = fmax(size, hi[c] - lo[c]), far = fmax(far, fmax(-lo[c], hi[c]));
    for (int c = 0; c < dim && size == 0.0; c++)
        size = fmax(size, fabs(hi[c])); // a constant: rounding against itself
    size_t count = kn_spline_count(f), inner = 1;
    for (int d = var + 1; d < f->nvars; d++) inner *= (size_t)f->count[d];
    size_t outer = count / inner / (size_t)n;
    for (size_t i = 0; i < outer * inner; i++) {
        size_t a = i / inner * (size_t)n * inner + i % inner, b = a + (size_t)(n - 1) * inner;
        const double *w = f->coef + (size_t)dim * count;
        double wa = f->rational ? w[a] : 1.0, wb = f->rational ? w[b] : 1.0;
        for (int c = 0; c < dim; c++) {
            const double *x = f->coef + (size_t)c * count;
            worst = fmax(worst, fabs(x[a] / wa - x[b] / wb));
        }
        worst = fmax(worst, size * fabs(wa - wb) / fmax(wa, wb));
    }
    *meet = worst <= 1e-12 * size + 2.0 * 0x1p-49 * far; // as kn_extent has it
    return KN_OK;
}

// n's coefficients along an edge are of the normal there: two edges on the same knots agree where these do.
void kn_shell_open_seams(kn_shell *s)
{
    size_t count = kn_spline_count(&s->normal);
    for (int v = 0; v < 2; v++) {
        size_t other = (size_t)s->normal.count[1 - v], across = v == 0 ? 1 : (size_t)s->normal.count[1];
        size_t far = v == 0 ? count - other : (size_t)s->normal.count[1] - 1;
        double worst = 0.0;
        for (size_t i = 0; i < 3 * other; i++) {
            const double *c = s->normal.coef + i / other * count + i % other * across;
            worst = fmax(worst, fabs(c[0] - c[far]));
        }
        s->closed[v] = s->closed[v] && worst <= 10.0 * s->normal_tol;
    }
}

// ---- T as a sum of powers of w ----

int kn_shell_nterms(const kn_shell *shell)
{
    return 1 + (shell->normal.coef != NULL) + shell->nfields;
}

// (W f, 0): in homogeneous coordinates it adds f to P/W.
static kn_status with_weight(kn_ctx *ctx, kn_spline *f, const kn_spline *surface)
{
    static const double into[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    kn_spline w = {0};
    kn_status status = kn_spline_components(ctx, &w, surface, 3, 1);
    if (status == KN_OK) status = kn_spline_product(ctx, &w, &w, f);
    if (status == KN_OK) status = kn_spline_affine(ctx, &w, &w, 4, into, NULL);
    if (status == KN_OK) kn_spline_swap(f, &w);
    kn_spline_clear(ctx, &w);
    return status;
}

kn_status kn_shell_term(kn_ctx *ctx, kn_spline *out, int *power, const kn_shell *shell, int t)
{
    kn_spline f = {0};
    int at = t - 1 - (shell->normal.coef != NULL);
    *power = t == 0 ? 0 : at < 0 ? 1 : shell->field[at].power;
    kn_status status = KN_OK;
    if (t == 0)
        status = kn_spline_components(ctx, &f, &shell->surface, 0, shell->surface.ncomp);
    else if (at >= 0)
        status = kn_spline_copy(ctx, &f, &shell->field[at].whole);
    else if (shell->thickness.whole.coef)
        status = kn_spline_product(ctx, &f, &shell->thickness.whole, &shell->normal);
    else
        status = kn_spline_copy(ctx, &f, &shell->normal);
    if (status == KN_OK && t > 0 && shell->surface.rational && !shell->homogeneous)
        status = with_weight(ctx, &f, &shell->surface);
    if (status == KN_OK) kn_spline_swap(out, &f);
    kn_spline_clear(ctx, &f);
    return status;
}
