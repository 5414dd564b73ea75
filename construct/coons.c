// SPDX-License-Identifier: Apache-2.0
// Boolean sums. P_d interpolates linearly between the two faces of variable d. On control points that is
// (P_d c)_i = (1 - g_i) c_first + g_i c_last along variable d, g the Greville sites from 0 to 1: the control points of
// the identity. With c the faces in their places and anything inside, c - (1 - P_0)(1 - P_1) .. c is the Boolean sum, and
// does not depend on what is inside: zeros.
#include <math.h>
#include <string.h>

#include <knurl/fit.h>

#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

static const char call[] = "construct_coons";

// The faces of which variable d runs along: all but its own two; in them it has this index.
static int index_in_face(int d, int face)
{
    return d < face / 2 ? d : d - 1;
}

static kn_status prepare(kn_ctx *ctx, kn_spline *face, int nvars, const kn_spline *const *faces)
{
    bool rational = false;
    kn_status status = KN_OK;
    for (int f = 0; f < 2 * nvars; f++) rational = rational || faces[f]->rational;
    for (int f = 0; f < 2 * nvars && status == KN_OK; f++) {
        status = kn_construct_operand(ctx, call, &face[f], faces[f], rational);
        if (status == KN_OK && (face[f].nvars != nvars - 1 || face[f].ncomp != face[0].ncomp))
            status = kn_fail(ctx, KN_EDOMAIN, "%s: face %d has %d variables and dimension %d", call, f, face[f].nvars,
                             kn_spline_dim(&face[f]));
    }
    for (int d = 0; d < nvars && status == KN_OK; d++) {
        kn_spline along[2 * KN_MAX_VARS];
        int var[2 * KN_MAX_VARS], n = 0;
        for (int f = 0; f < 2 * nvars; f++)
            if (f / 2 != d) along[n] = face[f], var[n++] = index_in_face(d, f);
        status = kn_construct_unite(ctx, call, along, var, n, 1);
        n = 0;
        for (int f = 0; f < 2 * nvars; f++)
            if (f / 2 != d) face[f] = along[n++];
    }
    return status;
}

// The place of control point `at` of s in face f, which it lies on.
static size_t place_in_face(const kn_spline *s, size_t at, int f)
{
    size_t place = 0, stride = 1;
    for (int d = s->nvars - 1; d >= 0; d--) {
        if (d != f / 2) place += at % (size_t)s->count[d] * stride, stride *= (size_t)s->count[d];
        at /= (size_t)s->count[d];
    }
    return place;
}

// The faces' control points in their places, zero inside. Where faces meet the lowest wins.
static kn_status put_faces(kn_ctx *ctx, kn_spline *s, const kn_spline *face, double tolerance)
{
    size_t n = kn_spline_count(s);
    for (size_t at = 0; at < n; at++) {
        int owner = -1;
        size_t rest = at, k[KN_MAX_VARS];
        for (int d = s->nvars - 1; d >= 0; d--) k[d] = rest % (size_t)s->count[d], rest /= (size_t)s->count[d];
        for (size_t c = 0; c < (size_t)s->ncomp; c++) s->coef[c * n + at] = 0.0;
        for (int f = 0; f < 2 * s->nvars; f++) {
            if (k[f / 2] != (f % 2 ? (size_t)s->count[f / 2] - 1 : 0)) continue;
            size_t from = place_in_face(s, at, f), nf = kn_spline_count(&face[f]);
            for (size_t c = 0; c < (size_t)s->ncomp; c++) {
                double x = face[f].coef[c * nf + from], *to = &s->coef[c * n + at];
                if (owner >= 0 && !(fabs(x - *to) <= tolerance))
                    return kn_fail(ctx, KN_EDOMAIN, "%s: faces %d and %d do not meet: %.17g and %.17g", call, owner,
                                   f, *to, x);
                if (owner < 0) *to = x;
            }
            if (owner < 0) owner = f;
        }
    }
    return KN_OK;
}

// r = (1 - P_d) r, in place.
static kn_status take_linear_part(kn_ctx *ctx, double *r, const kn_spline *s, int d)
{
    size_t n = (size_t)s->count[d], inner = kn_spline_inner(s, d), outer = kn_spline_outer(s, d);
    double *g = kn_scratch(ctx, n, sizeof *g), lo, hi;
    if (!g) return KN_ENOMEM;
    kn_status status = kn_fit_greville(ctx, g, s->knots[d], s->degree[d], s->count[d]);
    if (status != KN_OK) return status;
    kn_spline_domain(s, d, &lo, &hi);
    for (size_t o = 0; o < outer; o++)
        for (size_t q = 0; q < inner; q++) {
            double *line = r + o * n * inner + q, first = line[0], last = line[(n - 1) * inner];
            for (size_t i = 0; i < n; i++) {
                double up = (g[i] - lo) / (hi - lo), down = (hi - g[i]) / (hi - lo);
                line[i * inner] -= down * first + up * last;
            }
        }
    return KN_OK;
}

static kn_status boolean_sum(kn_ctx *ctx, kn_spline *s, int nvars, const kn_spline *const *faces, double tolerance)
{
    kn_spline face[2 * KN_MAX_VARS];
    kn_status status = prepare(ctx, face, nvars, faces);
    if (status != KN_OK) return status;
    *s = (kn_spline){.nvars = nvars, .ncomp = face[0].ncomp, .rational = face[0].rational};
    for (int d = 0; d < nvars; d++) {
        const kn_spline *from = &face[d == 0 ? 2 : 0];
        int e = index_in_face(d, d == 0 ? 2 : 0);
        s->degree[d] = from->degree[e], s->count[d] = from->count[e];
    }
    status = kn_spline_in_scratch(ctx, call, s);
    for (int d = 0; d < nvars && status == KN_OK; d++)
        memcpy(s->knots[d], face[d == 0 ? 2 : 0].knots[index_in_face(d, d == 0 ? 2 : 0)],
               (size_t)(s->count[d] + s->degree[d] + 1) * sizeof **s->knots);
    if (status == KN_OK) status = put_faces(ctx, s, face, tolerance);
    if (status != KN_OK) return status;
    size_t n = kn_spline_count(s) * (size_t)s->ncomp;
    double *r = kn_scratch(ctx, n, sizeof *r);
    if (!r) return KN_ENOMEM;
    memcpy(r, s->coef, n * sizeof *r);
    for (int d = 0; d < nvars && status == KN_OK; d++) status = take_linear_part(ctx, r, s, d);
    for (size_t i = 0; i < n && status == KN_OK; i++) s->coef[i] -= r[i]; // on the faces r is exactly zero
    return status == KN_OK ? kn_construct_check_weights(ctx, call, s) : status;
}

kn_status kn_construct_coons(kn_ctx *ctx, kn_spline *out, int nvars, const kn_spline *const *faces, double tolerance)
{
    if (nvars < 2 || !(tolerance >= 0.0))
        return kn_fail(ctx, KN_EDOMAIN, "%s: %d variables, tolerance %g", call, nvars, tolerance);
    if (nvars > KN_MAX_VARS) return kn_fail(ctx, KN_ELIMIT, "%s: %d variables", call, nvars);
    kn_spline s;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = boolean_sum(ctx, &s, nvars, faces, tolerance);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
