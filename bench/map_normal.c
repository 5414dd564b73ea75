// SPDX-License-Identifier: Apache-2.0
// The angle between exact normals of mapped geometry, J^-T N, and the estimate of equation (4), N_u S_u + N_v S_v +
// N_w n: of three built-in tiles on three bases, at heights 0, H/2 and H, as the table of docs/normals.md; and what
// each costs. The estimate wants S_u and S_v as long as n: it is taken in S's own parameters, and in parameters
// scaled so that S_u and S_v have unit length in the mean over each surface.
#include "bench/bench.h"

#include <knurl/construct.h>
#include <knurl/io.h>
#include <knurl/shell.h>

#include <math.h>

enum { MOST_PARTS = 32, TILES = 3, HEIGHTS = 3, GRID = 3, MOST = 400000 };

typedef struct base {
    const char *name;
    int n, cells[2]; // of each surface
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
    for (; b->n < (int)model.nsplines && b->n < MOST_PARTS; b->n++)
        need(ctx, kn_spline_copy(ctx, &b->part[b->n], &model.splines[b->n]));
    kn_model_clear(ctx, &model);
}

// Radii 3 and 1; u = (t + t^2) / 2 and v = 1.4 t - 0.4 t^2 run three and 2.3 times as fast at one end as at the
// other.
static void make_torus(kn_ctx *ctx, kn_spline *out)
{
    const double center[3] = {0}, axis[3] = {0, 0, 1}, knots[6] = {0, 0, 0, 1, 1, 1}, *k[1] = {knots};
    const double fast[2][3] = {{0.0, 0.25, 1.0}, {0.0, 0.7, 1.0}};
    need(ctx, kn_construct_torus(ctx, out, center, axis, 3.0, 1.0));
    for (int v = 0; v < 2; v++) {
        kn_spline f = {0};
        need(ctx, kn_spline_init(ctx, &f, 1, 1, false, (const int[1]){2}, (const int[1]){3}, k, fast[v]));
        need(ctx, kn_spline_substitute(ctx, out, out, v, &f));
        kn_spline_clear(ctx, &f);
    }
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

// ---- samples ----

typedef struct sample {
    double at[3], normal[3], scaled[3]; // scaled: of the estimate in parameters of unit speed
} sample;

typedef struct table {
    double *angle[2][HEIGHTS]; // [scaled][height]
    size_t n[HEIGHTS], singular;
    double height; // H, the mean over the surfaces
} table;

typedef struct placing {
    const kn_shell *shell;
    const kn_tile *tile;
    double lo[2], step[2], speed[2], height;
} placing;

static void mean_speed(kn_ctx *ctx, placing *p, const int cells[2])
{
    enum { N = 16 };
    double hi[2], point[3], j[9];
    const kn_spline *s = kn_shell_surface(p->shell);
    for (int v = 0; v < 2; v++) {
        kn_spline_domain(s, v, &p->lo[v], &hi[v]);
        p->step[v] = (hi[v] - p->lo[v]) / cells[v];
        p->speed[v] = 0.0;
    }
    for (int k = 0; k < N * N; k++) {
        double u = p->lo[0] + (hi[0] - p->lo[0]) * (k / N + 0.5) / N;
        double v = p->lo[1] + (hi[1] - p->lo[1]) * (k % N + 0.5) / N;
        need(ctx, kn_shell_eval(ctx, point, j, p->shell, u, v, 0.0));
        for (int d = 0; d < 2; d++) p->speed[d] += hypot(hypot(j[d], j[3 + d]), j[6 + d]) / (N * N);
    }
    p->height = p->tile->aspect * 0.5 * (p->speed[0] * p->step[0] + p->speed[1] * p->step[1]);
}

static double turn(const double a[3], const double b[3])
{
    double x[3], s = 0.0, d = 0.0;
    for (int c = 0; c < 3; c++) {
        x[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
        s += x[c] * x[c], d += a[c] * b[c];
    }
    return atan2(sqrt(s), d) * 57.29577951308232;
}

static void add(kn_ctx *ctx, table *t, const placing *p, const sample *s)
{
    for (int h = 0; h < HEIGHTS; h++) {
        const double at[3] = {s->at[0], s->at[1], p->height * h / (HEIGHTS - 1)};
        double exact[3], rough[3];
        kn_status status = kn_shell_map_normal(ctx, exact, p->shell, at, s->normal);
        if (status == KN_EUNDEFINED || t->n[h] == MOST) {
            kn_ctx_clear_error(ctx);
            t->singular++;
            continue;
        }
        need(ctx, status);
        for (int k = 0; k < 2; k++) {
            need(ctx, kn_shell_map_normal_estimate(ctx, rough, p->shell, at, k ? s->scaled : s->normal));
            t->angle[k][h][t->n[h]] = turn(exact, rough);
        }
        t->n[h]++;
    }
}

// The normals of one surface of the tile on a grid, in one cell.
static void sample_tile(kn_ctx *ctx, table *t, const placing *p, const kn_spline *tile, int i, int j)
{
    for (int k = 0; k < GRID * GRID; k++) {
        double lo[2], hi[2], r[2], d[9], length = 0.0;
        sample s;
        for (int v = 0; v < 2; v++) {
            kn_spline_domain(tile, v, &lo[v], &hi[v]);
            r[v] = lo[v] + (hi[v] - lo[v]) * ((v ? k % GRID : k / GRID) + 0.5) / GRID;
        }
        need(ctx, kn_spline_derivatives(ctx, d, tile, r, 1));
        for (int c = 0; c < 3; c++) {
            int a = (c + 1) % 3, b = (c + 2) % 3;
            s.normal[c] = d[3 + a] * d[6 + b] - d[3 + b] * d[6 + a];
            length += s.normal[c] * s.normal[c];
        }
        if (!(length > 1e-20)) continue;
        for (int v = 0; v < 2; v++) {
            s.at[v] = p->lo[v] + p->step[v] * ((v ? j : i) + fmin(fmax(d[v], 0.0), 1.0));
            s.normal[v] /= p->step[v];
            s.scaled[v] = s.normal[v] / (p->speed[v] * p->speed[v]);
        }
        s.normal[2] /= p->height;
        s.scaled[2] = s.normal[2];
        add(ctx, t, p, &s);
    }
}

static void measure(kn_ctx *ctx, table *t, const base *b, const kn_tile *tile)
{
    for (int k = 0; k < b->n; k++) {
        kn_shell *shell = NULL;
        need(ctx, kn_shell_create(ctx, &shell, &b->part[k], NULL));
        placing p = {.shell = shell, .tile = tile};
        mean_speed(ctx, &p, b->cells);
        t->height += p.height / b->n;
        for (int i = 0; i < b->cells[0]; i++)
            for (int j = 0; j < b->cells[1]; j++)
                for (int part = 0; part < tile->nparts; part++)
                    for (int s = 0; s < tile->parts[part].nsplines; s++)
                        sample_tile(ctx, t, &p, &tile->parts[part].splines[s], i, j);
        kn_shell_destroy(ctx, shell);
    }
}

static void print(const char *name, const char *tile, const table *t)
{
    for (int h = 0; h < HEIGHTS; h++) {
        printf("| %s | %s | %.2g |", h ? "" : name, h ? "" : tile, t->height * h / (HEIGHTS - 1));
        for (int k = 1; k >= 0; k--) {
            double *x = t->angle[k][h];
            size_t n = t->n[h];
            qsort(x, n, sizeof *x, bench_by_value);
            printf(" %.1f / %.1f / %.0f |", x[n / 2], x[n - 1 - n / 20], x[n - 1]);
        }
        printf("\n");
    }
}

static void time_both(kn_ctx *ctx, const base *b)
{
    enum { N = 20000 };
    kn_shell *shell = NULL;
    double out[3], seconds[2];
    need(ctx, kn_shell_create(ctx, &shell, &b->part[0], NULL));
    for (int k = 0; k < 2; k++) {
        double start = bench_now(BENCH_THREAD);
        for (int i = 0; i < N; i++) {
            const double at[3] = {0.1 + 0.8 * i / N, 0.5, 0.01}, n[3] = {0.3, -0.2, 1.0};
            need(ctx, (k ? kn_shell_map_normal_estimate : kn_shell_map_normal)(ctx, out, shell, at, n));
        }
        seconds[k] = bench_now(BENCH_THREAD) - start;
    }
    printf("\nexact %.2f us, estimate %.2f us a normal (bicubic)\n", 1e6 * seconds[0] / N, 1e6 * seconds[1] / N);
    kn_shell_destroy(ctx, shell);
}

int main(void)
{
    static const char *const tiles[TILES] = {"chain", "scale", "knurl"};
    static base bases[3] = {{.name = "teapot", .cells = {3, 3}},
                            {.name = "torus, uneven", .n = 1, .cells = {24, 12}},
                            {.name = "waves", .n = 1, .cells = {17, 17}}};
    kn_ctx *ctx = NULL;
    if (kn_ctx_create(&ctx, NULL) != KN_OK) return 1;
    read_teapot(ctx, &bases[0]);
    make_torus(ctx, &bases[1].part[0]);
    make_waves(ctx, &bases[2].part[0]);
    double *room = malloc(2 * HEIGHTS * sizeof *room * MOST);
    if (!room) return 1;
    printf("| base | tile | w | unit speed: median / 95 %% / largest | S's parameters |\n|---|---|--:|---|---|\n");
    size_t singular = 0, all = 0;
    for (int b = 0; b < 3; b++)
        for (int k = 0; k < TILES; k++) {
            kn_tile tile;
            table t = {.n = {0}};
            for (int i = 0; i < 2 * HEIGHTS; i++) t.angle[i / HEIGHTS][i % HEIGHTS] = room + (size_t)i * MOST;
            need(ctx, kn_builtin_tile(ctx, &tile, tiles[k]));
            measure(ctx, &t, &bases[b], &tile);
            print(bases[b].name, tiles[k], &t);
            singular += t.singular, all += t.n[0] + t.n[1] + t.n[2];
            kn_tile_clear(ctx, &tile);
        }
    printf("\n%zu normals; J is singular at %zu more\n", all, singular);
    time_both(ctx, &bases[0]);
    free(room);
    for (int b = 0; b < 3; b++)
        for (int k = 0; k < bases[b].n; k++) kn_spline_clear(ctx, &bases[b].part[k]);
    kn_ctx_destroy(ctx);
    return 0;
}
