// SPDX-License-Identifier: Apache-2.0
// Fuzzes constructors: numbers and splines by bytes, the results of one call the operands of the next.
#include "tests/fuzz/feed.h"

#include <knurl/construct.h>

enum { SLOTS = 4, MOST_CALLS = 6, MOST_COEFS = 2000, MOST_DEGREE = 10 };

typedef struct machine {
    feed f;
    kn_spline slot[SLOTS];
} machine;

static void settle(machine *m, kn_spline *s)
{
    bool large = s->nvars > 3 || (s->nvars && kn_spline_count(s) * (size_t)s->ncomp > MOST_COEFS);
    for (int d = 0; d < s->nvars; d++) large |= s->degree[d] > MOST_DEGREE;
    if (s->nvars && kn_spline_check(m->f.ctx, s) == KN_ELIMIT) abort();
    if (large) kn_spline_clear(m->f.ctx, s);
}

static kn_status from_numbers(machine *m, int call, kn_spline *out)
{
    feed *f = &m->f;
    int n = feed_count(f, 1, 6), dim = feed_count(f, 1, 4);
    size_t points = n < 0 ? 0 : (size_t)n, comps = dim < 0 ? 0 : (size_t)dim;
    const double *a = feed_numbers(f, 3), *b = feed_numbers(f, 3), *c = feed_numbers(f, 3);
    double r = feed_number(f), q = feed_number(f);
    switch (call) {
    case 0: return kn_construct_line(f->ctx, out, dim, feed_numbers(f, comps), feed_numbers(f, comps));
    case 1: return kn_construct_polyline(f->ctx, out, dim, n, feed_numbers(f, comps * points));
    case 2: return kn_construct_arc(f->ctx, out, a, b, c, r);
    case 3: return kn_construct_ellipse(f->ctx, out, a, b, c);
    case 4: return kn_construct_circle(f->ctx, out, a, b, r);
    case 5: return kn_construct_sphere(f->ctx, out, a, r);
    case 6: return kn_construct_torus(f->ctx, out, a, b, r, q);
    case 7: return kn_construct_cylinder(f->ctx, out, a, b, r);
    default: return kn_construct_cone(f->ctx, out, a, b, r, q);
    }
}

static kn_status from_splines(machine *m, int call, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    feed *f = &m->f;
    double estimate;
    const double *x = feed_numbers(f, 4), *y = feed_numbers(f, 3);
    switch (call) {
    case 0: return kn_construct_ruled(f->ctx, out, a, b);
    case 1: return kn_construct_extruded(f->ctx, out, a, feed_numbers(f, a->nvars ? (size_t)kn_spline_dim(a) : 0));
    case 2: return kn_construct_revolved(f->ctx, out, a, x, y, feed_number(f));
    case 3: return kn_construct_swept(f->ctx, out, a, b);
    case 4: return kn_construct_swept_frame(f->ctx, out, &estimate, a, b, y, 0.01 + fabs(feed_finite(f)));
    case 5: {
        int n = feed_count(f, 2, SLOTS);
        const double *sites = feed_byte(f) % 2 ? feed_numbers(f, n > 0 ? (size_t)n : 0) : NULL;
        return kn_construct_skinned(f->ctx, out, n, m->slot, feed_wild(f, 1, 3), sites);
    }
    default: {
        int nvars = feed_count(f, 1, 3);
        const kn_spline *faces[6];
        for (int i = 0; i < 6; i++) faces[i] = &m->slot[feed_int(f, 0, SLOTS - 1)];
        return kn_construct_coons(f->ctx, out, nvars, faces, feed_byte(f) % 2 ? 100.0 : feed_number(f));
    }
    }
}

enum { NUMBERS = 9, SPLINES = 7 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    machine m = {.f = feed_begin(data, size)};
    feed *f = &m.f;
    int nvars = feed_int(f, 1, 2);
    for (int i = 0; i < SLOTS; i++) feed_spline(f, &m.slot[i], nvars);
    feed_drop(f);
    kn_ctx_clear_error(f->ctx);
    for (int i = 0; i < MOST_CALLS && f->left > 0; i++) {
        int which = feed_byte(f) % (NUMBERS + SPLINES), place = feed_int(f, 0, SLOTS - 1);
        kn_spline *out = &m.slot[place];
        const kn_spline *a = &m.slot[feed_int(f, 0, SLOTS - 1)], *b = &m.slot[feed_int(f, 0, SLOTS - 1)];
        kn_status status = which < NUMBERS ? from_numbers(&m, which, out)
                                           : from_splines(&m, which - NUMBERS, out, a, b);
        if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort(); // a failure is recorded
        feed_drop(f);
        for (int k = 0; k < SLOTS; k++) settle(&m, &m.slot[k]);
        kn_ctx_clear_error(f->ctx);
    }
    for (int i = 0; i < SLOTS; i++) kn_spline_clear(f->ctx, &m.slot[i]);
    feed_end(f);
    return 0;
}
