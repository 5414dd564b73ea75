// SPDX-License-Identifier: Apache-2.0
// Knot insertion and degree elevation, one thread: 100 knots at once into a cubic curve of 100 points, and a bicubic
// surface of 20 x 20 points to bidegree 6. Rivals: SISL's s1018 and s1750 where it is installed (it elevates curves
// only: it gets the net as one curve of 3 * 20 components and one of 3 * 71, which is the surface's work but for
// turning the net in between), and the plain references of the same maps.
#include "bench/bench.h"

#include <knurl/spline.h>

#include "kernel/knots.h"

#ifdef KN_WITH_SISL
#include <sisl.h>
#endif

enum {
    POINTS = 100,
    NEW = 100,
    DEGREE = 3,
    KNOTS = POINTS + DEGREE + 1,
    SIDE = 20,
    HIGH = 6,
    REPEAT = 200,
    RIVALS = 4
};

typedef struct curve_data {
    kn_ctx *ctx;
    int dim;
    kn_spline s, out;
    double fresh[NEW];
    double to[KNOTS + NEW], *result, w[(POINTS + NEW) * (DEGREE + 1)];
    int first[POINTS + NEW];
    bool failed;
#ifdef KN_WITH_SISL
    SISLCurve *curve;
#endif
} curve_data;

static double uniform(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static void insert(void *user)
{
    curve_data *d = user;
    for (int i = 0; i < REPEAT; i++)
        if (kn_spline_insert_knots(d->ctx, &d->out, &d->s, 0, d->fresh, NEW) != KN_OK) d->failed = true;
}

static void insert_plainly(void *user)
{
    curve_data *d = user;
    kn_band band = {.rows = POINTS + NEW, .first = d->first, .w = d->w};
    for (int i = 0; i < REPEAT; i++) {
        kn_band_refine_plain(&band, d->s.knots[0], DEGREE, POINTS, d->to);
        kn_band_apply_plain(d->result, &band, d->s.coef, (size_t)d->dim, POINTS, 1);
    }
}

// What must be moved at least: the curve in, the refined curve out.
static void copy(void *user)
{
    curve_data *d = user;
    size_t n = (POINTS + NEW) * (size_t)d->dim * sizeof(double);
    for (int i = 0; i < REPEAT; i++) {
        memcpy(d->result, d->out.coef, n);
        __asm__ volatile("" : : "r"(d->result) : "memory");
    }
}

#ifdef KN_WITH_SISL
static void sisl_insert(void *user)
{
    curve_data *d = user;
    for (int i = 0; i < REPEAT; i++) {
        SISLCurve *out = NULL;
        int status = 0;
        s1018(d->curve, d->fresh, NEW, &out, &status);
        if (status < 0 || !out) d->failed = true;
        if (out) freeCurve(out);
    }
}
#endif

static bool make_curve(curve_data *d, kn_ctx *ctx, int dim)
{
    uint64_t seed = 1;
    double knots[KNOTS], coef[POINTS * 3];
    const double *const k[1] = {knots};
    const int degree = DEGREE, count = POINTS, spans = POINTS - DEGREE;
    *d = (curve_data){.ctx = ctx, .dim = dim};
    for (int i = 0; i < KNOTS; i++) knots[i] = i <= DEGREE ? 0 : i >= POINTS ? spans : i - DEGREE;
    for (int i = 0; i < POINTS * dim; i++) coef[i] = uniform(&seed);
    for (int i = 0; i < NEW; i++) d->fresh[i] = spans * (i + 0.4) / NEW;
    if (kn_spline_init(ctx, &d->s, 1, dim, false, &degree, &count, k, coef) != KN_OK) return false;
    d->result = malloc((POINTS + NEW) * (size_t)dim * sizeof *d->result);
    kn_knots_union(d->to, knots, KNOTS, d->fresh, NEW);
#ifdef KN_WITH_SISL
    double vertices[POINTS * 3];
    for (int i = 0; i < POINTS; i++)
        for (int c = 0; c < dim; c++) vertices[i * dim + c] = coef[c * POINTS + i];
    d->curve = newCurve(POINTS, DEGREE + 1, knots, vertices, 1, dim, 1);
    if (!d->curve) return false;
#endif
    return d->result != NULL;
}

static void clear_curve(curve_data *d)
{
    kn_spline_clear(d->ctx, &d->s);
    kn_spline_clear(d->ctx, &d->out);
    free(d->result);
#ifdef KN_WITH_SISL
    if (d->curve) freeCurve(d->curve);
#endif
}

static void print(const char *title, const bench_rival *rivals, int n, const char *first, size_t allocations)
{
    printf("%s\n%-28s %10s %10s\n", title, "", "us", first);
    for (int i = 0; i < n; i++)
        printf("%-28s %10.3f %10.2f\n", rivals[i].name, rivals[i].seconds / REPEAT * 1e6, rivals[i].ratio);
    printf("allocations in the steady state: %zu\n\n", allocations);
}

static bool bench_curve(kn_ctx *ctx, int dim)
{
    curve_data d;
    bench_rival rivals[RIVALS];
    int n = 0;
    char title[100];
    if (!make_curve(&d, ctx, dim)) return false;
    insert(&d);
    size_t before = kn_ctx_counters(ctx).allocations;
    insert(&d);
    size_t allocations = kn_ctx_counters(ctx).allocations - before;
#ifdef KN_WITH_SISL
    rivals[n++] = (bench_rival){"SISL s1018", sisl_insert, &d, 0, 0};
#endif
    rivals[n++] = (bench_rival){"plain reference, no knots", insert_plainly, &d, 0, 0};
    rivals[n++] = (bench_rival){"kn_spline_insert_knots", insert, &d, 0, 0};
    rivals[n++] = (bench_rival){"limit: copying the result", copy, &d, 0, 0};
    bench_compare(rivals, n, BENCH_THREAD);
    snprintf(title, sizeof title, "%d knots into a cubic curve of %d points, %d components", NEW, POINTS, dim);
    print(title, rivals, n, rivals[0].name[0] == 'S' ? "x SISL" : "x first", allocations);
    clear_curve(&d);
    return !d.failed;
}

typedef struct surface_data {
    kn_ctx *ctx;
    kn_spline s, out;
    double *copy;
    bool failed;
#ifdef KN_WITH_SISL
    SISLCurve *curve[2];
#endif
} surface_data;

static void elevate(void *user)
{
    surface_data *d = user;
    for (int i = 0; i < REPEAT; i++)
        if (kn_spline_elevate(d->ctx, &d->out, &d->s, (int[]){HIGH, HIGH}) != KN_OK) d->failed = true;
}

static void copy_surface(void *user)
{
    surface_data *d = user;
    for (int i = 0; i < REPEAT; i++) {
        memcpy(d->copy, d->out.coef, kn_spline_count(&d->out) * 3 * sizeof *d->copy);
        __asm__ volatile("" : : "r"(d->copy) : "memory");
    }
}

#ifdef KN_WITH_SISL
static void sisl_elevate(void *user)
{
    surface_data *d = user;
    for (int i = 0; i < REPEAT; i++)
        for (int k = 0; k < 2; k++) {
            SISLCurve *out = NULL;
            int status = 0;
            s1750(d->curve[k], HIGH + 1, &out, &status);
            if (status < 0 || !out) d->failed = true;
            if (out) freeCurve(out);
        }
}
#endif

static bool make_surface(surface_data *d, kn_ctx *ctx)
{
    enum { SIDE_KNOTS = SIDE + DEGREE + 1, WIDE = 3 * 71 };
    uint64_t seed = 2;
    double knots[SIDE_KNOTS], coef[SIDE * WIDE];
    const double *const k[2] = {knots, knots};
    *d = (surface_data){.ctx = ctx};
    for (int i = 0; i < SIDE_KNOTS; i++) knots[i] = i <= DEGREE ? 0 : i >= SIDE ? SIDE - DEGREE : i - DEGREE;
    for (int i = 0; i < SIDE * WIDE; i++) coef[i] = uniform(&seed);
    if (kn_spline_init(ctx, &d->s, 2, 3, false, (int[]){DEGREE, DEGREE}, (int[]){SIDE, SIDE}, k, coef) != KN_OK)
        return false;
    elevate(d);
    d->copy = malloc(kn_spline_count(&d->out) * 3 * sizeof *d->copy);
#ifdef KN_WITH_SISL
    d->curve[0] = newCurve(SIDE, DEGREE + 1, knots, coef, 1, 3 * SIDE, 1);
    d->curve[1] = newCurve(SIDE, DEGREE + 1, knots, coef, 1, WIDE, 1);
    if (!d->curve[0] || !d->curve[1]) return false;
#endif
    return d->copy != NULL;
}

static bool bench_surface(kn_ctx *ctx)
{
    surface_data d;
    bench_rival rivals[RIVALS];
    int n = 0;
    if (!make_surface(&d, ctx)) return false;
    size_t before = kn_ctx_counters(ctx).allocations;
    elevate(&d);
    size_t allocations = kn_ctx_counters(ctx).allocations - before;
#ifdef KN_WITH_SISL
    rivals[n++] = (bench_rival){"SISL s1750, as two curves", sisl_elevate, &d, 0, 0};
#endif
    rivals[n++] = (bench_rival){"kn_spline_elevate", elevate, &d, 0, 0};
    rivals[n++] = (bench_rival){"limit: copying the result", copy_surface, &d, 0, 0};
    bench_compare(rivals, n, BENCH_THREAD);
    print("bicubic 20 x 20 surface, 3 components, to bidegree 6", rivals, n,
          rivals[0].name[0] == 'S' ? "x SISL" : "x first", allocations);
    kn_spline_clear(ctx, &d.s);
    kn_spline_clear(ctx, &d.out);
    free(d.copy);
#ifdef KN_WITH_SISL
    for (int i = 0; i < 2; i++) freeCurve(d.curve[i]);
#endif
    return !d.failed;
}

int main(void)
{
    kn_ctx *ctx;
    kn_ctx_options options = kn_ctx_defaults();
    options.threads = 1;
    if (kn_ctx_create(&ctx, &options) != KN_OK) return 1;
    bool ok = bench_curve(ctx, 3) && bench_curve(ctx, 1) && bench_surface(ctx);
#ifndef KN_WITH_SISL
    printf("SISL: not built in (libsisl-dev), no ratio to it\n");
#endif
    const char *isa;
    double flops = bench_peak_flops(&isa), bytes = bench_peak_bytes();
    printf("peak of 1 thread, measured here: %.1f GFLOP/s (%s), %.1f GB/s; medians of %d paired runs\n", flops / 1e9,
           isa, bytes / 1e9, BENCH_ROUNDS);
    kn_ctx_destroy(ctx);
    return !ok;
}
