// SPDX-License-Identifier: Apache-2.0
// How both unit normal constructions converge: degree, control points, spans, certified errors and time of
// kn_shell_create at 1e-3, 1e-6 and 1e-9 on five surfaces, as the table of docs/normals.md.
#include "bench/bench.h"

#include <knurl/construct.h>
#include <knurl/io.h>
#include <knurl/shell.h>

#include <math.h>

enum { RUNS = 3, MOST_PARTS = 32 };

typedef struct base {
    const char *name;
    int n;
    kn_spline part[MOST_PARTS];
} base;

static void need(kn_ctx *ctx, kn_status status)
{
    if (status == KN_OK) return;
    fprintf(stderr, "%s\n", kn_ctx_message(ctx));
    exit(1);
}

// ---- the surfaces ----

static void read_teapot(kn_ctx *ctx, base *b)
{
    kn_model model = {0};
    need(ctx, kn_read_bpt(ctx, &model, "data/teapot.bpt"));
    if (model.nsplines > MOST_PARTS) exit(1);
    for (; b->n < (int)model.nsplines; b->n++) need(ctx, kn_spline_copy(ctx, &b->part[b->n], &model.splines[b->n]));
    kn_model_clear(ctx, &model);
}

// A bicubic height field of 20 x 20 control points, about three waves each way.
static void make_waves(kn_ctx *ctx, kn_spline *out)
{
    enum { N = 20 };
    double knots[N + 4], coef[3 * N * N];
    const double *both[2] = {knots, knots};
    for (int i = 0; i < N + 4; i++) knots[i] = i < 4 ? 0.0 : i >= N ? N - 3 : i - 3;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            double *c = coef + N * i + j;
            c[0] = i, c[N * N] = j, c[2 * N * N] = 1.5 * sin(0.9 * i + 0.3 * j) * cos(0.8 * j - 0.2 * i);
        }
    need(ctx, kn_spline_init(ctx, out, 2, 3, false, (const int[2]){3, 3}, (const int[2]){N, N}, both, coef));
}

// A vase: a rational cubic profile with uneven weights, turned about z.
static void make_vase(kn_ctx *ctx, kn_spline *out)
{
    static const double knots[11] = {0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4};
    static const double profile[7][3] = {{1.0, 0, 1},     {2.2, 0.4, 0.8}, {2.4, 1.8, 1.3}, {1.0, 3.0, 0.9},
                                         {0.6, 3.8, 1.2}, {0.8, 4.6, 0.7}, {1.3, 5.0, 1}};
    const double *k[1] = {knots}, origin[3] = {0}, axis[3] = {0, 0, 1};
    double coef[4 * 7];
    kn_spline curve;
    for (int i = 0; i < 7; i++) {
        double w = profile[i][2];
        coef[i] = w * profile[i][0], coef[7 + i] = 0.0, coef[14 + i] = w * profile[i][1], coef[21 + i] = w;
    }
    need(ctx, kn_spline_init(ctx, &curve, 1, 4, true, (const int[1]){3}, (const int[1]){7}, k, coef));
    need(ctx, kn_construct_revolved(ctx, out, &curve, origin, axis, 8.0 * atan(1.0)));
    kn_spline_clear(ctx, &curve);
}

enum { BASES = 5 };

static void make_bases(kn_ctx *ctx, base bases[BASES])
{
    const double center[3] = {0}, axis[3] = {0, 0, 1};
    bases[0] = (base){.name = "teapot, 32 patches"};
    read_teapot(ctx, &bases[0]);
    bases[1] = (base){.name = "torus", .n = 1};
    need(ctx, kn_construct_torus(ctx, &bases[1].part[0], center, axis, 3.0, 1.0));
    bases[2] = (base){.name = "sphere", .n = 1};
    need(ctx, kn_construct_sphere(ctx, &bases[2].part[0], center, 1.0));
    bases[3] = (base){.name = "waves, 20 x 20", .n = 1};
    make_waves(ctx, &bases[3].part[0]);
    bases[4] = (base){.name = "vase, rational", .n = 1};
    make_vase(ctx, &bases[4].part[0]);
}

// ---- one line of the table ----

typedef struct line {
    int degree[2];
    size_t points, spans;
    double length, angle, seconds; // errors certified, the largest of all parts; time of all parts
    kn_status status;
} line;

static line measure(kn_ctx *ctx, const base *b, const kn_shell_options *o)
{
    line l = {.status = KN_OK};
    double seconds[RUNS] = {0};
    for (int run = 0; run < RUNS; run++)
        for (int k = 0; k < b->n && l.status == KN_OK; k++) {
            kn_shell *shell = NULL;
            double start = bench_now(BENCH_THREAD);
            l.status = kn_shell_create(ctx, &shell, &b->part[k], o);
            seconds[run] += bench_now(BENCH_THREAD) - start;
            if (l.status != KN_OK) break;
            const kn_spline *n = kn_shell_normal(shell);
            kn_normal_certificate c = kn_shell_certificate(shell);
            l.length = fmax(l.length, c.length_error), l.angle = fmax(l.angle, c.angle_error);
            for (int v = 0; v < 2; v++)
                if (n->degree[v] > l.degree[v]) l.degree[v] = n->degree[v];
            if (run == 0) {
                l.points += kn_spline_count(n);
                l.spans += (size_t)kn_spline_spans(n, 0) * (size_t)kn_spline_spans(n, 1);
            }
            kn_shell_destroy(ctx, shell);
        }
    l.seconds = bench_median(seconds, RUNS);
    return l;
}

int main(void)
{
    static const char *const method[2] = {"fitted", "direction-exact"};
    static base bases[BASES];
    kn_ctx *ctx = NULL;
    if (kn_ctx_create(&ctx, NULL) != KN_OK) return 1;
    make_bases(ctx, bases);
    printf("| method | surface | tolerance | degree | control points | spans | length error | angle error | ms |\n"
           "|---|---|---|---|---|---|---|---|---|\n");
    for (int m = 0; m < 2; m++)
        for (int k = 0; k < BASES; k++)
            for (double tol = 1e-3; tol > 5e-7; tol *= 1e-3) {
                kn_shell_options o = {.normal = m ? KN_NORMAL_EXACT_DIRECTION : KN_NORMAL_FITTED, .normal_tol = tol};
                line l = measure(ctx, &bases[k], &o);
                if (l.status == KN_OK)
                    printf("| %s | %s | %.0e | %d, %d | %zu | %zu | %.1e | %.1e | %.3g |\n", method[m], bases[k].name,
                           tol, l.degree[0], l.degree[1], l.points, l.spans, l.length, l.angle, 1e3 * l.seconds);
                else
                    printf("| %s | %s | %.0e | %s |\n", method[m], bases[k].name, tol, kn_ctx_message(ctx));
                kn_ctx_clear_error(ctx);
            }
    for (int k = 0; k < BASES; k++)
        for (int i = 0; i < bases[k].n; i++) kn_spline_clear(ctx, &bases[k].part[i]);
    kn_ctx_destroy(ctx);
    return 0;
}
