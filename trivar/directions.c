// SPDX-License-Identifier: Apache-2.0
// The direction of the normal over each knot span of S, and whether it is there everywhere.
#include "kernel/context.h"
#include "kernel/knots.h"
#include "trivar/internal.h"

#include <math.h>

// Far from the origin coordinates are mostly translation, which normals do not depend on: without it nothing is lost
// but what the coordinates have lost already. Nearer than this nothing is gained.
kn_status kn_spline_to_origin(kn_ctx *ctx, kn_spline *out, const kn_spline *s)
{
    const double far = 4.0;
    kn_extent e = kn_extent_of(s);
    size_t count = kn_spline_count(s);
    kn_status status = kn_spline_copy(ctx, out, s);
    for (size_t c = 0; c < 3 && status == KN_OK; c++) {
        double *x = out->coef + c * count;
        const double *w = s->rational ? s->coef + 3 * count : NULL;
        for (size_t i = 0; i < count && fabs(e.middle[c]) > far * e.size; i++)
            x[i] = w ? fma(-e.middle[c], w[i], x[i]) : x[i] - e.middle[c];
    }
    return status;
}

// The largest vector and the largest weight of the control points that act on span i, j of S.
static void find_acting(double acting[2], const kn_shell *s, size_t i, size_t j)
{
    const kn_spline *f = &s->local;
    size_t count = kn_spline_count(f), at[2] = {i, j}, first[2];
    acting[0] = acting[1] = 0.0;
    for (int v = 0; v < 2; v++)
        first[v] = (size_t)(kn_knots_span(f->knots[v], f->degree[v], f->count[v], s->knot[v][at[v]]) - f->degree[v]);
    for (size_t a = first[0]; a <= first[0] + (size_t)f->degree[0]; a++)
        for (size_t b = first[1]; b <= first[1] + (size_t)f->degree[1]; b++) {
            const double *c = f->coef + a * (size_t)f->count[1] + b;
            acting[0] = fmax(acting[0], hypot(hypot(c[0], c[count]), c[2 * count]));
            if (f->rational) acting[1] = fmax(acting[1], c[3 * count]);
        }
}

// Refuses a direction that vanishes, or that is not known not to, at a place of span i.
static kn_status expect_regular(kn_ctx *ctx, const kn_shell *s, size_t i, double *work)
{
    size_t columns = (size_t)s->nknots[1] - 1;
    const double *knot[2] = {s->knot[0] + i / columns, s->knot[1] + i % columns};
    kn_regularity answer;
    double at[2];
    kn_status status = kn_direction_regular(ctx, &answer, at, &s->direction[i], work);
    if (status != KN_OK || answer == KN_REGULAR) return status;
    for (int v = 0; v < 2; v++) at[v] = knot[v][0] + at[v] * (knot[v][1] - knot[v][0]);
    return kn_fail_normal(ctx, s, at, answer == KN_SINGULAR);
}

static kn_status no_area(kn_ctx *ctx, const kn_shell *s, size_t i)
{
    size_t columns = (size_t)s->nknots[1] - 1;
    const double *ku = s->knot[0] + i / columns, *kv = s->knot[1] + i % columns;
    return kn_fail(ctx, KN_EDOMAIN, "shell: the surface has no area on [%g, %g] x [%g, %g]", ku[0], ku[1], kv[0],
                   kv[1]);
}

kn_status kn_shell_make_directions(kn_ctx *ctx, kn_shell *s)
{
    size_t columns = (size_t)s->nknots[1] - 1, flat = 0;
    double work = KN_REGULAR_WORK;
    s->direction = kn_alloc_zero(ctx, s->nspans, sizeof *s->direction);
    if (!s->direction) return KN_ENOMEM;
    s->ndirections = s->nspans;
    for (size_t i = 0; i < s->nspans; i++) {
        bool zero = false;
        double acting[2];
        find_acting(acting, s, i / columns, i % columns);
        kn_status status = kn_direction_init(ctx, &s->direction[i], &zero, &s->local_span[i], acting, s->slack);
        flat += zero;
        if (status == KN_OK && zero && i > flat - 1) status = no_area(ctx, s, i);
        if (status == KN_OK && !zero) status = expect_regular(ctx, s, i, &work);
        if (status != KN_OK) return status;
    }
    if (flat == s->nspans) return kn_fail(ctx, KN_EDOMAIN, "shell: the surface has zero area");
    if (flat > 0) return kn_fail(ctx, KN_EDOMAIN, "shell: the surface has no area on its first %zu spans", flat);
    return KN_OK;
}

// The certificates multiply n with N, and n with itself where n = N m.
kn_status kn_shell_limit_degree(kn_ctx *ctx, int *max_degree, const kn_shell *s)
{
    bool exact = s->method == KN_NORMAL_EXACT_DIRECTION;
    int most = exact ? KN_MAX_DEGREE / 2 : KN_MAX_DEGREE;
    for (size_t i = 0; i < s->ndirections; i++)
        for (int v = 0; v < 2; v++) {
            int degree = s->direction[i].n.degree[v], room = most - degree;
            if (room < KN_LEAST_DEGREE)
                return kn_fail(ctx, KN_ELIMIT,
                               "shell: the normal's direction has degree %d in variable %d, above %d%s", degree, v,
                               most - KN_LEAST_DEGREE, exact ? ", too much for a normal of exact direction" : "");
            if (*max_degree > room) *max_degree = room;
        }
    return KN_OK;
}
