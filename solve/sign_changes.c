// SPDX-License-Identifier: Apache-2.0
// Changes of sign of a polynomial in Bernstein form, zero counted as positive.
#include "solve/curves.h"

#include "kernel/bernstein.h"

#include <knurl/base.h>
#include <math.h>
#include <string.h>

enum { MAX_HALVINGS = 60 };

typedef struct search {
    kn_sign_changes *out;
    size_t *doubtful;
    const double *c, *scaled; // the whole function: crossings are those of its own values
    int degree;
} search;

static bool below(double x)
{
    return x < 0.0;
}

static int variations(const double *c, int degree)
{
    int n = 0;
    for (int i = 0; i < degree; i++) n += below(c[i]) != below(c[i + 1]);
    return n;
}

static double value(const search *s, double t)
{
    if (t <= 0.0) return s->c[0];
    if (t >= 1.0) return s->c[s->degree];
    return kn_bernstein_horner(s->scaled, s->degree, t);
}

// Narrows [lo,hi], at whose ends signs differ, by secants in which an end that stays counts half (Illinois), while
// that is faster than halving.
static void narrow(const search *s, double *lo, double *hi, bool rise)
{
    double below_at = value(s, rise ? *lo : *hi), above_at = value(s, rise ? *hi : *lo);
    for (int step = 0, stays = 0; step < 12 && *hi - *lo > 1e-12; step++) {
        double *negative = rise ? lo : hi, *positive = rise ? hi : lo;
        double x = *negative + (*positive - *negative) * (below_at / (below_at - above_at));
        if (!(x > *lo && x < *hi)) return;
        double f = value(s, x);
        if (below(f)) {
            *negative = x, below_at = f;
            if (stays < 0) above_at *= 0.5;
            stays = -1;
        } else {
            *positive = x, above_at = f;
            if (stays > 0) below_at *= 0.5;
            stays = 1;
        }
    }
}

// The end that is not below of neighbouring doubles between which f changes its sign.
static double bisect(const search *s, double lo, double hi, bool rise)
{
    if (!rise && lo <= 0.0 && s->c[0] == 0.0) return 0.0; // zero at the end itself, negative after it
    if (rise && hi >= 1.0 && s->c[s->degree] == 0.0) return 1.0;
    narrow(s, &lo, &hi, rise);
    for (;;) {
        double middle = lo + (hi - lo) / 2.0;
        if (middle <= lo || middle >= hi) return rise ? hi : lo;
        if (below(value(s, middle)) == rise)
            lo = middle;
        else
            hi = middle;
    }
}

static kn_status add(kn_ctx *ctx, kn_sign_changes *out, double at, bool rise)
{
    if (out->count == out->room) {
        size_t room = out->room > 0 ? 2 * out->room : 8;
        kn_sign_change *list = kn_resize(ctx, out->list, room, sizeof *list);
        if (!list) return KN_ENOMEM;
        out->list = list;
        out->room = room;
    }
    out->list[out->count++] = (kn_sign_change){at, rise};
    return KN_OK;
}

// c: the function over [lo,hi].
static kn_status find(kn_ctx *ctx, const search *s, const double *c, double lo, double hi, int depth)
{
    int n = variations(c, s->degree);
    if (n == 0) return KN_OK;
    bool rise = below(c[0]), single = n == 1;
    double middle = lo + (hi - lo) / 2.0;
    if (single || depth == MAX_HALVINGS || middle <= lo || middle >= hi) {
        if (!single) ++*s->doubtful;
        if (n % 2 == 0) return KN_OK;
        return add(ctx, s->out, bisect(s, lo, hi, rise), rise);
    }
    double left[KN_MAX_DEGREE + 1], right[KN_MAX_DEGREE + 1];
    kn_bernstein_split(left, right, c, 1, s->degree, 1, 0.5);
    kn_status status = find(ctx, s, left, lo, middle, depth + 1);
    return status == KN_OK ? find(ctx, s, right, middle, hi, depth + 1) : status;
}

kn_status kn_solve_sign_changes(kn_ctx *ctx, kn_sign_changes *out, size_t *doubtful, const double *c, int degree)
{
    double scaled[KN_MAX_DEGREE + 1];
    const search s = {out, doubtful, c, scaled, degree};
    if (variations(c, degree) == 0) return KN_OK;
    kn_bernstein_scale(scaled, c, degree);
    return find(ctx, &s, c, 0.0, 1.0, 0);
}
