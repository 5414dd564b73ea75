// SPDX-License-Identifier: Apache-2.0
// Existence and uniqueness of a root in a box: Krawczyk's test on the Bernstein coefficients of Y f.
//
// In the parameters s of a box X, g = Y f, K_i = sum_d max |(I - dg/ds)_id| <= kappa < 1 over X. For x, z in X
// |(x - z) - (g(x) - g(z))|_i <= K_i |x - z|: so g is injective, a root z in X has |x - z| <= |g(x)| / (1 - kappa)
// for any x in X, and when that ball around x lies in X, z -> z - g(z) maps it to itself: there is a root.
#include "solve/search.h"

#include "kernel/context.h"

enum { STEPS = 12, TIGHTENINGS = 12 };
static const double WIDER = 0.125, LARGEST_KAPPA = 0.8;

// Newton from the middle of the box that is loaded, held inside it; y is left as the inverse at the last point but
// one. False: no regular Jacobian on the way.
static bool newton(kn_finder *f, double *s)
{
    int n = f->net.nvars, m = f->net.ncomp;
    double value[KN_MAX_COMPS], jacobian[KN_MAX_COMPS * KN_MAX_VARS], last = INFINITY;
    for (int d = 0; d < n; d++) s[d] = 0.5;
    for (int step = 0; step < STEPS; step++) {
        double size = 0.0;
        kn_net_jacobian(&f->net, f->coef, s, value, jacobian, f->work);
        if (!kn_left_inverse(f->y, jacobian, m, n)) return false;
        for (int d = 0; d < n; d++) {
            double move = 0.0;
            for (int k = 0; k < m; k++) move += f->y[d * m + k] * value[k];
            double to = fmin(fmax(s[d] - move, 0.0), 1.0);
            size = fmax(size, fabs(to - s[d]));
            s[d] = to;
        }
        if (size < 1e-15 || (size < 1e-9 && size >= 0.5 * last)) break;
        last = size;
    }
    return true;
}

// Y f(c) and its error at the point c of the cell.
static void residual(kn_finder *f, size_t cell, const double *c, double *gc, double *slack)
{
    int n = f->net.nvars, m = f->net.ncomp;
    double value[KN_MAX_COMPS], error[KN_MAX_COMPS];
    kn_cell_value(f->cells, cell, c, value, error, f->work);
    for (int i = 0; i < n; i++) {
        double sum = 0.0, round = 0.0;
        for (int k = 0; k < m; k++) {
            double y = f->y[i * m + k], extra = m > n ? f->options.residual : 0.0;
            sum += y * value[k];
            round += fabs(y) * (error[k] + extra + kn_rounding(m + 1.0) * fabs(value[k]));
        }
        gc[i] = sum;
        slack[i] = round * (1.0 + 0x1p-40);
    }
}

// One more step with the twofold residual: c <- c - w Y f(c), as long as it helps.
static void polish(kn_finder *f, size_t cell, double *c, const double *width, double *gc, double *slack)
{
    int n = f->net.nvars;
    double to[KN_MAX_VARS], other[KN_MAX_VARS], error[KN_MAX_VARS], now = 0.0, then = 0.0;
    residual(f, cell, c, gc, slack);
    for (int step = 0; step < 3; step++) {
        now = then = 0.0;
        for (int d = 0; d < n; d++) to[d] = c[d] - width[d] * gc[d];
        residual(f, cell, to, other, error);
        for (int d = 0; d < n; d++) now = fmax(now, fabs(gc[d])), then = fmax(then, fabs(other[d]));
        if (!(then < now)) return;
        for (int d = 0; d < n; d++) c[d] = to[d], gc[d] = other[d], slack[d] = error[d];
    }
}

// r_i <= |Y f(c)|_i + sum_d K_id r_d, again and again from r = the radius of the ball.
static void tighten(const kn_finder *f, double *r, const double *gc, const double *slack, double radius)
{
    int n = f->net.nvars;
    double next[KN_MAX_VARS];
    for (int i = 0; i < n; i++) r[i] = radius;
    for (int step = 0; step < TIGHTENINGS; step++) {
        for (int i = 0; i < n; i++) {
            double sum = fabs(gc[i]) + slack[i];
            for (int d = 0; d < n; d++) sum += f->kappa[i * n + d] * r[d];
            next[i] = fmin(r[i], sum * (1.0 + 0x1p-40));
        }
        for (int i = 0; i < n; i++) r[i] = next[i];
    }
}

// Fills in the enclosure around the point c. True: the box [lo,hi] holds exactly one root, in the enclosure. Also
// sets *apart: the box has no root in [inner_lo,inner_hi].
static bool enclose(const kn_finder *f, kn_found *r, const double *width, const double *gc, const double *slack,
                    double kappa, const kn_box *inner, bool *apart)
{
    int n = f->net.nvars;
    double radius = 0.0, near[KN_MAX_VARS];
    bool inside = true;
    for (int i = 0; i < n; i++) radius = fmax(radius, fabs(gc[i]) + slack[i]);
    radius *= (1.0 + 0x1p-40) / (1.0 - kappa);
    tighten(f, near, gc, slack, radius);
    *apart = false;
    for (int i = 0; i < n; i++) {
        double c = r->at[i], ball = width[i] * radius * (1.0 + 0x1p-40) + 0x1p-1000;
        double tight = width[i] * near[i] * (1.0 + 0x1p-40) + 0x1p-52 * fabs(c) + 0x1p-1000;
        inside = inside && c - ball > r->around_lo[i] && c + ball < r->around_hi[i];
        r->lo[i] = c - tight;
        r->hi[i] = c + tight;
        *apart = *apart || c + ball * 1.001 < inner->lo[i] || c - ball * 1.001 > inner->hi[i];
    }
    return inside;
}

// A new root, or one that is known, or none in the cell.
static kn_status settle(kn_ctx *ctx, kn_finder *f, kn_fate *fate, kn_found *r)
{
    int n = f->net.nvars;
    *fate = KN_FATE_EMPTY;
    for (int d = 0; d < n; d++)
        if (r->hi[d] < 0.0 || r->lo[d] > 1.0) return KN_OK;
    if (f->net.ncomp > n) { // the equations that were not solved
        kn_finder_load(f, r->cell, r->lo, r->hi);
        if (kn_net_excluded(&f->net, f->coef, f->error)) return KN_OK;
    }
    *fate = KN_FATE_ROOT;
    r->kind = f->net.ncomp > n ? KN_ROOT_POSSIBLE : KN_ROOT_UNIQUE;
    for (size_t i = 0; i < f->nfound; i++) {
        const kn_found *k = &f->found[i];
        bool new_in_old = k->cell == r->cell, old_in_new = new_in_old;
        for (int d = 0; d < n; d++) {
            new_in_old = new_in_old && k->around_lo[d] <= r->lo[d] && r->hi[d] <= k->around_hi[d];
            old_in_new = old_in_new && r->around_lo[d] <= k->lo[d] && k->hi[d] <= r->around_hi[d];
        }
        if (k->kind == r->kind && (new_in_old || old_in_new)) return KN_OK;
    }
    return kn_finder_keep(ctx, f, r);
}

kn_status kn_finder_certify(kn_ctx *ctx, kn_finder *f, kn_fate *fate, const kn_box *b)
{
    int n = f->net.nvars;
    double s[KN_MAX_VARS], width[KN_MAX_VARS], gc[KN_MAX_VARS], slack[KN_MAX_VARS];
    kn_found r = {.cell = b->cell};
    bool apart = false;
    *fate = KN_FATE_SPLIT;
    for (int d = 0; d < n; d++) {
        double more = WIDER * (b->hi[d] - b->lo[d]) + 0x1p-48;
        r.around_lo[d] = b->lo[d] - more;
        r.around_hi[d] = b->hi[d] + more;
        width[d] = r.around_hi[d] - r.around_lo[d];
    }
    kn_finder_load(f, b->cell, r.around_lo, r.around_hi);
    if (!newton(f, s)) return KN_OK;
    kn_finder_combine(f);
    if (kn_net_excluded(&f->square, f->g, f->g_error)) {
        *fate = KN_FATE_EMPTY;
        return KN_OK;
    }
    double kappa = kn_finder_kappa(f);
    if (!(kappa < LARGEST_KAPPA)) return KN_OK;
    for (int d = 0; d < n; d++) r.at[d] = r.around_lo[d] + s[d] * width[d];
    residual(f, b->cell, r.at, gc, slack);
    polish(f, b->cell, r.at, width, gc, slack);
    for (int d = 0; d < n; d++) // polishing must not leave the box
        if (!(r.at[d] >= r.around_lo[d] && r.at[d] <= r.around_hi[d])) return KN_OK;
    bool one = enclose(f, &r, width, gc, slack, kappa, b, &apart);
    if (apart) *fate = KN_FATE_EMPTY;
    return one ? settle(ctx, f, fate, &r) : KN_OK;
}
