// SPDX-License-Identifier: Apache-2.0
// The search for self-intersections: a torus, a sphere and parts of the teapot at heights near and far from the
// largest ones, one thread: verdict, boxes and pairs looked at, time.
#include "bench/bench.h"

#include <knurl/construct.h>
#include <knurl/fold.h>
#include <knurl/io.h>

enum { MOST = 32 };

typedef struct data {
    kn_ctx *ctx;
    const char *name;
    kn_shell *shell[MOST];
    int n;
} data;

static void make(data *d, const kn_spline *s)
{
    const kn_shell_options coarse = {.normal_tol = 1e-4};
    if (kn_shell_create(d->ctx, &d->shell[d->n], s, &coarse) != KN_OK) {
        fprintf(stderr, "%s\n", kn_ctx_message(d->ctx));
        exit(1);
    }
    d->n++;
}

static void ask(data *d, double w0, double w1)
{
    static const char *const verdict[3] = {"none", "found", "open"};
    const kn_shell *list[MOST];
    const double w[2] = {w0, w1};
    const kn_fold_options options = {.work = 100000};
    kn_fold_intersection r;
    for (int i = 0; i < d->n; i++) list[i] = d->shell[i];
    double start = bench_now(BENCH_THREAD);
    if (kn_fold_self_intersection(d->ctx, &r, list, d->n, NULL, 0, w, &options) != KN_OK) {
        fprintf(stderr, "%s\n", kn_ctx_message(d->ctx));
        exit(1);
    }
    printf("%-16s [%5.2f, %5.2f]  %-5s %7zu boxes and pairs %9.1f ms\n", d->name, w0, w1, verdict[r.verdict], r.boxes,
           1e3 * (bench_now(BENCH_THREAD) - start));
}

static void drop(data *d)
{
    while (d->n > 0) kn_shell_destroy(d->ctx, d->shell[--d->n]);
}

static void teapot(data *d, const char *name, int first, int n)
{
    kn_model model = {0};
    if (kn_read_bpt(d->ctx, &model, "data/teapot.bpt") != KN_OK) return;
    d->name = name;
    for (int i = first; i < first + n; i++) make(d, &model.splines[i]);
    kn_model_clear(d->ctx, &model);
    ask(d, 0.0, 0.02);
    drop(d);
}

int main(void)
{
    data d = {.n = 0};
    kn_spline s = {0};
    const double center[3] = {0, 0, 0}, axis[3] = {0, 0, 1};
    if (kn_ctx_create(&d.ctx, NULL) != KN_OK) return 1;
    if (kn_construct_torus(d.ctx, &s, center, axis, 3.0, 1.0) != KN_OK) return 1;
    d.name = "torus 3, 1";
    make(&d, &s);
    ask(&d, 0.0, 0.5);
    ask(&d, -0.9, 0.0);
    ask(&d, -1.01, 0.0);
    ask(&d, 0.0, 2.02);
    drop(&d);
    if (kn_construct_sphere(d.ctx, &s, center, 2.0) != KN_OK) return 1;
    d.name = "sphere 2";
    make(&d, &s);
    ask(&d, 0.0, 0.5);
    ask(&d, -2.02, 0.0);
    drop(&d);
    teapot(&d, "teapot's bottom", 28, 4);
    teapot(&d, "teapot's lid", 20, 8);
    teapot(&d, "teapot", 0, 32);
    kn_spline_clear(d.ctx, &s);
    kn_ctx_destroy(d.ctx);
    return 0;
}
