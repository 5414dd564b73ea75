// SPDX-License-Identifier: Apache-2.0
// Safe heights of the teapot's patches and of a wavy bicubic of 20 x 20 control points: guaranteed and within 1 %,
// beside an estimate by sampling, which guarantees nothing; and the Jacobian's coefficients by themselves.
#include "bench/bench.h"

#include <knurl/fold.h>
#include <knurl/io.h>

#include <math.h>

enum { MOST = 64, SIDE = 20, SAMPLES = 3, RIVALS = 2 };

typedef struct data {
    kn_ctx *ctx;
    kn_shell *shell[MOST];
    int n;
    double least[2], sampled[2]; // above and below: guaranteed, found at samples
    size_t boxes, coefficients, places;
    bool failed;
} data;

// ---- what runs ----

static void guaranteed(void *user)
{
    data *d = user;
    d->least[0] = d->least[1] = INFINITY;
    for (int k = 0; k < d->n; k++) {
        kn_fold_heights h;
        if (kn_fold_safe_heights(d->ctx, NULL, &h, d->shell[k]) != KN_OK) d->failed = true;
        d->least[0] = fmin(d->least[0], h.above);
        d->least[1] = fmin(d->least[1], h.below);
    }
}

// The first root in w of J, a quadratic through three heights, at SAMPLES^2 places of each box of the grid.
static void sample_place(data *d, const kn_shell *shell, const double at[2])
{
    double det[3], p[3], j[9];
    for (int m = 0; m < 3; m++) {
        if (kn_shell_eval(d->ctx, p, j, shell, at[0], at[1], m - 1.0) != KN_OK) d->failed = true;
        det[m] = j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
                 j[2] * (j[3] * j[7] - j[4] * j[6]);
    }
    double a = det[1], b = 0.5 * (det[2] - det[0]), c = 0.5 * (det[2] + det[0]) - det[1];
    double root = sqrt(fmax(0.0, b * b - 4.0 * a * c));
    for (int side = 0; side < 2; side++, b = -b)
        if (a > 0.0 && root - b > 0.0) d->sampled[side] = fmin(d->sampled[side], 2.0 * a / (root - b));
    d->places++;
}

static void sampled(void *user)
{
    data *d = user;
    d->sampled[0] = d->sampled[1] = INFINITY;
    d->places = 0;
    for (int k = 0; k < d->n; k++) {
        int grid[3];
        double lo[2], hi[2];
        kn_shell_jacobian_grid(d->shell[k], grid);
        for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(d->shell[k]), v, &lo[v], &hi[v]);
        int n[2] = {grid[0] * SAMPLES, grid[1] * SAMPLES};
        for (int i = 0; i < n[0] * n[1]; i++) {
            double at[2] = {lo[0] + (hi[0] - lo[0]) * (i / n[1] + 0.5) / n[0],
                            lo[1] + (hi[1] - lo[1]) * (i % n[1] + 0.5) / n[1]};
            sample_place(d, d->shell[k], at);
        }
    }
}

static void coefficients(void *user)
{
    data *d = user;
    d->boxes = d->coefficients = 0;
    for (int k = 0; k < d->n; k++) {
        int grid[3];
        kn_shell_jacobian_grid(d->shell[k], grid);
        for (int i = 0; i < grid[0] * grid[1]; i++) {
            const int at[3] = {i / grid[1], i % grid[1], 0};
            kn_shell_jacobian_piece p;
            if (kn_shell_jacobian_piece_init(d->ctx, &p, d->shell[k], at) != KN_OK) {
                d->failed = true;
                continue;
            }
            d->boxes++;
            d->coefficients += kn_bezier_count(&p.j) * (size_t)p.j.ncomp;
            kn_shell_jacobian_piece_clear(d->ctx, &p);
        }
    }
}

// ---- shells ----

static void add(data *d, const kn_spline *s, double tol)
{
    kn_shell_options o = {.normal_tol = tol};
    if (kn_shell_create(d->ctx, &d->shell[d->n], s, &o) == KN_OK)
        d->n++;
    else
        d->failed = true;
}

static void add_wavy(data *d)
{
    double knots[SIDE + 4], coef[3 * SIDE * SIDE];
    const double *k[2] = {knots, knots};
    for (int i = 0; i < SIDE + 4; i++) knots[i] = i < 4 ? 0 : i > SIDE ? SIDE - 3 : i - 3;
    for (int i = 0; i < SIDE * SIDE; i++) {
        double x = i / SIDE, y = i % SIDE;
        coef[i] = x, coef[SIDE * SIDE + i] = y;
        coef[2 * SIDE * SIDE + i] = sin(0.9 * x) * cos(0.7 * y + 0.2 * x);
    }
    kn_spline s;
    if (kn_spline_init(d->ctx, &s, 2, 3, false, (const int[2]){3, 3}, (const int[2]){SIDE, SIDE}, k, coef) != KN_OK) {
        d->failed = true;
        return;
    }
    add(d, &s, 1e-4);
    kn_spline_clear(d->ctx, &s);
}

static void add_teapot(data *d)
{
    kn_model model = {0};
    if (kn_read_bpt(d->ctx, &model, "data/teapot.bpt") != KN_OK) {
        d->failed = true;
        return;
    }
    for (int k = 0; k < model.nsplines && d->n < MOST; k++) add(d, &model.splines[k], 1e-6);
    kn_model_clear(d->ctx, &model);
}

static void measure(data *d, const char *name)
{
    bench_rival rivals[RIVALS] = {{.name = "guaranteed", .work = guaranteed, .user = d},
                                  {.name = "sampled", .work = sampled, .user = d}};
    bench_rival alone = {.name = "coefficients", .work = coefficients, .user = d};
    bench_compare(rivals, RIVALS, BENCH_THREAD);
    bench_compare(&alone, 1, BENCH_THREAD);
    printf("%s: %d shells, %zu boxes\n", name, d->n, d->boxes);
    printf("  guaranteed %8.1f ms, %5.1f us a box: above %.6g, below %.6g\n", 1e3 * rivals[0].seconds,
           1e6 * rivals[0].seconds / (double)d->boxes, d->least[0], d->least[1]);
    printf("  sampled    %8.1f ms, %zu places: above %.6g, below %.6g, no guarantee\n", 1e3 * rivals[1].seconds,
           d->places, d->sampled[0], d->sampled[1]);
    printf("  sampling takes %.2f times as long\n", rivals[1].ratio > 0.0 ? 1.0 / rivals[1].ratio : 0.0);
    printf("  coefficients of J alone %.1f ms, %.1f us a box, %.1f million/s\n", 1e3 * alone.seconds,
           1e6 * alone.seconds / (double)d->boxes, 1e-6 * (double)d->coefficients / alone.seconds);
    for (int k = 0; k < d->n; k++) kn_shell_destroy(d->ctx, d->shell[k]);
    d->n = 0;
}

int main(void)
{
    static data d;
    kn_ctx_options one = {.threads = 1};
    if (kn_ctx_create(&d.ctx, &one) != KN_OK) return 1;
    add_teapot(&d);
    measure(&d, "teapot, normals within 1e-6");
    add_wavy(&d);
    measure(&d, "wavy 20 x 20, normals within 1e-4");
    kn_ctx_destroy(d.ctx);
    return d.failed;
}
