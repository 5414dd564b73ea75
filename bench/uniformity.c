// SPDX-License-Identifier: Apache-2.0
// How even cells are, before and after: the table of docs/uniformity.md. With a folder as its argument it also writes
// the histograms there, one SVG for each base.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <knurl/cells.h>
#include <knurl/io.h>

#include "bench/bench.h"

enum { UNIFORM, EVEN, FREE, ROWS, WAYS };
static const char *const way_name[WAYS] = {"uniform", "even", "free", "rows"};
enum { QUANTITIES = 3 };
static const char *const quantity_name[QUANTITIES] = {"width", "height", "area"};

typedef struct base {
    const char *name;
    int count[2];
} base;
static const base bases[] = {{"body", {48, 12}}, {"spout", {24, 32}}, {"cone", {32, 16}}};
enum { BASES = sizeof bases / sizeof *bases };

typedef struct result {
    kn_cells_spread spread;
    double seconds, error; // of the fit, in mean widths of cells
    int degree[2];         // of S in use
} result;

static void check(kn_ctx *ctx, kn_status status)
{
    if (status == KN_OK) return;
    fprintf(stderr, "uniformity: %s\n", kn_ctx_message(ctx));
    exit(1);
}

static kn_cells_range range_of(const kn_cells_spread *s, int quantity)
{
    return quantity == 0 ? s->width : quantity == 1 ? s->height : s->area;
}

static double ratio(const kn_cells_spread *s, int quantity)
{
    kn_cells_range r = range_of(s, quantity);
    return r.max / r.min;
}

// ---- the ways ----

static void by_lines(kn_ctx *ctx, result *r, const kn_spline *s, const int count[2], int way)
{
    double *lines[2], start = bench_now(BENCH_THREAD);
    for (int d = 0; d < 2; d++)
        check(ctx, way == UNIFORM ? kn_cells_uniform_lines(ctx, &lines[d], s, d, count[d])
                                  : kn_cells_even_lines(ctx, &lines[d], s, d, count[d]));
    r->seconds = bench_now(BENCH_THREAD) - start;
    const double *const both[2] = {lines[0], lines[1]};
    check(ctx, kn_cells_measure(ctx, &r->spread, s, both, (const int[]){count[0] + 1, count[1] + 1}));
    for (int d = 0; d < 2; d++) kn_free(ctx, lines[d]), r->degree[d] = s->degree[d];
}

static void by_corners(kn_ctx *ctx, result *r, const kn_spline *s, const int count[2], double width)
{
    kn_spline map = {0}, out = {0};
    const kn_cells_relax_options o = {.closed = {true, false}, .smooth = true};
    double start = bench_now(BENCH_THREAD);
    // the tolerance is that of jobs
    check(ctx, kn_cells_relax(ctx, &map, s, count, &o));
    check(ctx, kn_cells_fit(ctx, &out, &r->error, s, &map, &(kn_cells_fit_options){.tolerance = 1e-4 * width}));
    r->seconds = bench_now(BENCH_THREAD) - start;
    r->error /= width;
    check(ctx, kn_cells_measure(ctx, &r->spread, &out, NULL, NULL));
    for (int d = 0; d < 2; d++) r->degree[d] = out.degree[d];
    kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
}

static void by_rows(kn_ctx *ctx, result *r, const kn_spline *s, const double size[2])
{
    kn_cells_band *bands;
    int n;
    double start = bench_now(BENCH_THREAD);
    check(ctx, kn_cells_bands(ctx, &bands, &n, s, size));
    kn_spline *part = calloc((size_t)n, sizeof *part);
    kn_cells_grid *grid = calloc((size_t)n, sizeof *grid);
    double *(*lines)[2] = calloc((size_t)n, sizeof *lines);
    if (!part || !grid || !lines) exit(1);
    for (int k = 0; k < n; k++) {
        double lo[2], hi[2];
        kn_spline_domain(s, 0, &lo[0], &hi[0]);
        lo[1] = bands[k].lo, hi[1] = bands[k].hi;
        check(ctx, kn_spline_restrict(ctx, &part[k], s, lo, hi));
        grid[k].surface = &part[k];
        for (int d = 0; d < 2; d++) {
            check(ctx, kn_cells_even_lines(ctx, &lines[k][d], &part[k], d, bands[k].count[d]));
            grid[k].lines[d] = lines[k][d], grid[k].nlines[d] = bands[k].count[d] + 1;
        }
    }
    r->seconds = bench_now(BENCH_THREAD) - start;
    check(ctx, kn_cells_measure_all(ctx, &r->spread, grid, n));
    for (int k = 0; k < n; k++) {
        for (int d = 0; d < 2; d++) kn_free(ctx, lines[k][d]);
        kn_spline_clear(ctx, &part[k]);
    }
    for (int d = 0; d < 2; d++) r->degree[d] = s->degree[d];
    kn_free(ctx, bands);
    free(part), free(grid), free(lines);
}

// ---- heights ----

// The largest over the smallest proportion of a tile, its height over the root of its cell's area, between even
// lines: *before with one height everywhere, *after with kn_cells_stretch.
static void proportions(kn_ctx *ctx, double *before, double *after, const kn_spline *s, const int count[2])
{
    double *lines[2], error, low[2] = {INFINITY, INFINITY}, high[2] = {0.0, 0.0};
    kn_spline h = {0};
    const kn_cells_stretch_options o = {.degree = 3}; // whatever its error, which is measured here
    const int n[2] = {count[0] + 1, count[1] + 1};
    for (int d = 0; d < 2; d++) check(ctx, kn_cells_even_lines(ctx, &lines[d], s, d, count[d]));
    check(ctx, kn_cells_stretch(ctx, &h, &error, s, (const double *const[]){lines[0], lines[1]}, n, &o));
    for (int i = 0; i < count[0]; i++)
        for (int j = 0; j < count[1]; j++) {
            const double *u = lines[0] + i, *v = lines[1] + j, at[2] = {0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])};
            kn_cells_spread one;
            double height;
            check(ctx, kn_cells_measure(ctx, &one, s, (const double *const[]){u, v}, (const int[]){2, 2}));
            check(ctx, kn_spline_eval(ctx, &height, &h, at));
            const double x[2] = {1.0 / sqrt(one.area.mean), height / sqrt(one.area.mean)};
            for (int k = 0; k < 2; k++) low[k] = fmin(low[k], x[k]), high[k] = fmax(high[k], x[k]);
        }
    *before = high[0] / low[0], *after = high[1] / low[1];
    for (int d = 0; d < 2; d++) kn_free(ctx, lines[d]);
    kn_spline_clear(ctx, &h);
}

// ---- histograms ----

// One panel for each way and quantity; all of a base share both axes: sizes in units of the mean, roots of the shares
// of cells.
enum { WIDE = 190, TALL = 74, LEFT = 74, TOP = 46, GAP = 22, SHOWN = KN_CELLS_BINS * 2 / 3 }; // up to twice the mean

static double share(const kn_cells_range *r, int bin, size_t cells)
{
    size_t n = r->histogram[bin];
    for (int k = SHOWN; bin == SHOWN - 1 && k < KN_CELLS_BINS; k++) n += r->histogram[k];
    return (double)n / (double)cells;
}

static void panel(FILE *f, const result *r, int quantity, double x, double y, bool last)
{
    kn_cells_range range = range_of(&r->spread, quantity);
    double bar = (double)WIDE / SHOWN;
    fprintf(f, "<line class='axis' x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f'/>\n", x, y + TALL, x + WIDE, y + TALL);
    fprintf(f, "<line class='mean' x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f'/>\n", x + WIDE / 2.0, y, x + WIDE / 2.0,
            y + TALL);
    for (int k = 0; k < SHOWN; k++) {
        double high = TALL * sqrt(share(&range, k, r->spread.cells));
        if (high > 0.0)
            fprintf(f, "<rect class='bar' x='%.2f' y='%.2f' width='%.2f' height='%.2f'/>\n", x + k * bar + 0.5,
                    y + TALL - high, bar - 1.0, high);
    }
    fprintf(f, "<text class='ratio' x='%.1f' y='%.1f'>%.2f</text>\n", x + WIDE, y + 12.0, range.max / range.min);
    for (int k = 0; last && k <= 2; k++)
        fprintf(f, "<text class='tick' x='%.1f' y='%.1f'>%d</text>\n", x + k * WIDE / 2.0, y + TALL + 14.0, k);
}

static void write_histograms(const char *folder, const base *b, const result r[WAYS])
{
    char path[4096];
    snprintf(path, sizeof path, "%s/uniformity-%s.svg", folder, b->name);
    FILE *f = fopen(path, "w");
    if (!f) exit(1);
    int width = LEFT + QUANTITIES * (WIDE + GAP), height = TOP + WAYS * (TALL + GAP) + 20;
    fprintf(f, "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' width='%d' height='%d'>\n", width, height,
            width, height);
    fputs("<style>text{font:12px sans-serif;fill:#333}.title{font-weight:bold}.tick{text-anchor:middle;fill:#777}"
          ".ratio{text-anchor:end;font-weight:bold}.bar{fill:#2b6f8f}.axis{stroke:#999}"
          ".mean{stroke:#ccc;stroke-dasharray:2 3}</style>\n<rect width='100%' height='100%' fill='#fff'/>\n",
          f);
    for (int q = 0; q < QUANTITIES; q++)
        fprintf(f, "<text class='title' x='%d' y='26'>%s</text>\n", LEFT + q * (WIDE + GAP), quantity_name[q]);
    for (int w = 0; w < WAYS; w++) {
        double y = TOP + w * (TALL + GAP);
        fprintf(f, "<text x='10' y='%.1f'>%s</text>\n", y + TALL - 4.0, way_name[w]);
        for (int q = 0; q < QUANTITIES; q++) panel(f, &r[w], q, LEFT + q * (WIDE + GAP), y, w == WAYS - 1);
    }
    fputs("</svg>\n", f);
    if (fclose(f) != 0) exit(1);
}

int main(int argc, char **argv)
{
    kn_ctx *ctx;
    double before[BASES], after[BASES];
    if (kn_ctx_create(&ctx, NULL) != KN_OK) return 1;
    printf("| base | cells | way | width | height | area | degree of S | distance | ms |\n"
           "|---|--:|---|--:|--:|--:|---|--:|--:|\n");
    for (int b = 0; b < BASES; b++) {
        char path[64];
        kn_model model = {0};
        result r[WAYS] = {{.seconds = 0.0}};
        snprintf(path, sizeof path, "data/%s.g2", bases[b].name);
        check(ctx, kn_read_model(ctx, &model, path));
        const kn_spline *s = &model.splines[0];
        by_lines(ctx, &r[UNIFORM], s, bases[b].count, UNIFORM);
        by_lines(ctx, &r[EVEN], s, bases[b].count, EVEN);
        const double size[2] = {r[EVEN].spread.width.mean, r[EVEN].spread.height.mean};
        by_corners(ctx, &r[FREE], s, bases[b].count, size[0]);
        by_rows(ctx, &r[ROWS], s, size);
        for (int w = 0; w < WAYS; w++) {
            printf("| %s | %zu | %s |", bases[b].name, r[w].spread.cells, way_name[w]);
            for (int q = 0; q < QUANTITIES; q++) {
                double now = ratio(&r[w].spread, q), gain = ratio(&r[UNIFORM].spread, q) / now;
                w == UNIFORM ? printf(" %.2f |", now) : printf(" %.2f (%.2f x) |", now, gain);
            }
            printf(" %d, %d | ", r[w].degree[0], r[w].degree[1]);
            w == FREE ? printf("%.1e", r[w].error) : printf("0");
            printf(" | %.1f |\n", 1e3 * r[w].seconds);
        }
        proportions(ctx, &before[b], &after[b], s, bases[b].count);
        if (argc > 1) write_histograms(argv[1], &bases[b], r);
        kn_model_clear(ctx, &model);
    }
    printf("\n| base | one height | stretch |\n|---|--:|--:|\n");
    for (int b = 0; b < BASES; b++)
        printf("| %s | %.2f | %.2f (%.1f x) |\n", bases[b].name, before[b], after[b], before[b] / after[b]);
    kn_ctx_destroy(ctx);
    return 0;
}
