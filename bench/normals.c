// SPDX-License-Identifier: Apache-2.0
// How both unit normal constructions converge: degree, control points, spans, certified errors and time of
// kn_shell_create at 1e-3, 1e-6 and 1e-9 on five surfaces, as the table of docs/normals.md.
#include "bench/bench.h"

#include <knurl/construct.h>
#include <knurl/io.h>
#include <knurl/shell.h>

#include <math.h>

enum { RUNS = 3, MOST_PARTS = 32 }; // one run where it takes seconds

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
    bases[0] = (base){.name = "teapot"};
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
    int runs = 0;
    for (int run = 0; run < RUNS && (run == 0 || seconds[0] < 2.0); run++, runs++)
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
    l.seconds = bench_median(seconds, runs);
    return l;
}

// ---- the picture: errors against control points and against time, both axes logarithmic ----

enum { METHODS = 2, TOLERANCES = 3, PANELS = 2 };
static const char *const method_name[METHODS] = {"fitted", "direction-exact"};

typedef struct panel {
    const char *title;
    double left, width, lo, hi; // of x, as powers of ten
} panel;

static const double top = 86, height = 330, lowest = -10, highest = -2; // of y

static double x_of(const panel *p, double value)
{
    return p->left + p->width * (log10(value) - p->lo) / (p->hi - p->lo);
}

static double y_of(double error)
{
    return top + height * (highest - log10(error)) / (highest - lowest);
}

static void power(FILE *f, double x, double y, const char *anchor, int exponent)
{
    fprintf(f,
            "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">10<tspan dy=\"-5\" font-size=\"9\">%d</tspan></text>\n",
            x, y, anchor, exponent);
}

static void axes(FILE *f, const panel *p)
{
    for (int e = (int)lowest; e <= (int)highest; e += 2) {
        double y = y_of(pow(10, e));
        fprintf(f, "<path d=\"M%.1f %.1fH%.1f\" stroke=\"#e4e4e4\"/>\n", p->left, y, p->left + p->width);
        power(f, p->left - 8, y + 4, "end", e);
    }
    for (int e = (int)p->lo; e <= (int)p->hi; e++) {
        double x = x_of(p, pow(10, e));
        fprintf(f, "<path d=\"M%.1f %.1fV%.1f\" stroke=\"#e4e4e4\"/>\n", x, top, top + height);
        power(f, x, top + height + 20, "middle", e);
    }
    fprintf(f, "<path d=\"M%.1f %.1fV%.1fH%.1f\" fill=\"none\" stroke=\"#333\"/>\n", p->left, top, top + height,
            p->left + p->width);
    fprintf(f, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" font-size=\"14\">%s</text>\n",
            p->left + p->width / 2, top + height + 44, p->title);
}

static const char *const colour[BASES] = {"#c0392b", "#2471a3", "#1e8449", "#b7770d", "#7d3c98"};

static void curve(FILE *f, const panel *p, const line *l, const double value[TOLERANCES], int method,
                  const char *stroke)
{
    const char *dash = method ? " stroke-dasharray=\"6 4\"" : "";
    fprintf(f, "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"2\"%s points=\"", stroke, dash);
    for (int i = 0; i < TOLERANCES; i++)
        if (l[i].status == KN_OK) fprintf(f, "%.1f,%.1f ", x_of(p, value[i]), y_of(fmax(l[i].length, l[i].angle)));
    fprintf(f, "\"/>\n");
    for (int i = 0; i < TOLERANCES; i++)
        if (l[i].status == KN_OK)
            fprintf(f, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.6\" fill=\"%s\" stroke=\"%s\" stroke-width=\"1.6\"/>\n",
                    x_of(p, value[i]), y_of(fmax(l[i].length, l[i].angle)), method ? "#fff" : stroke, stroke);
}

static void legend(FILE *f, const base *bases)
{
    double x = 84;
    for (int k = 0; k < BASES; k++) {
        fprintf(f, "<path d=\"M%.1f 50h26\" stroke=\"%s\" stroke-width=\"3\"/><text x=\"%.1f\" y=\"54\">%s</text>\n",
                x, colour[k], x + 32, bases[k].name);
        x += 48 + 7.0 * (double)strlen(bases[k].name);
    }
    for (int m = 0; m < METHODS; m++) {
        fprintf(
            f,
            "<path d=\"M%.1f 50h30\" stroke=\"#333\" stroke-width=\"2\"%s/><circle cx=\"%.1f\" cy=\"50\" r=\"3.6\" "
            "fill=\"%s\" stroke=\"#333\" stroke-width=\"1.6\"/><text x=\"%.1f\" y=\"54\">%s</text>\n",
            x, m ? " stroke-dasharray=\"6 4\"" : "", x + 15, m ? "#fff" : "#333", x + 36, method_name[m]);
        x += 52 + 7.0 * (double)strlen(method_name[m]);
    }
}

static bool draw(const char *path, const base *bases, line lines[METHODS][BASES][TOLERANCES])
{
    const panel panels[PANELS] = {{"control points", 84, 400, 2, 7}, {"milliseconds", 572, 400, 0, 5}};
    FILE *f = fopen(path, "w");
    if (!f) return false;
    fprintf(f, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1000\" height=\"480\" viewBox=\"0 0 1000 480\" "
               "font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#222\">\n"
               "<rect width=\"1000\" height=\"480\" fill=\"#fff\"/>\n"
               "<text x=\"84\" y=\"28\" font-size=\"16\">Certified error of the unit normal</text>\n");
    legend(f, bases);
    for (int p = 0; p < PANELS; p++) {
        axes(f, &panels[p]);
        for (int m = 0; m < METHODS; m++)
            for (int k = 0; k < BASES; k++) {
                double value[TOLERANCES];
                for (int i = 0; i < TOLERANCES; i++) {
                    const line *l = &lines[m][k][i];
                    value[i] = p == 0 ? (double)l->points : 1e3 * l->seconds;
                }
                curve(f, &panels[p], lines[m][k], value, m, colour[k]);
            }
    }
    fprintf(f, "</svg>\n");
    return fclose(f) == 0;
}

// ---- the table ----

static void print(const char *method, const char *name, double tol, const line *l, kn_ctx *ctx)
{
    if (l->status == KN_OK)
        printf("| %s | %s | %.0e | %d, %d | %zu | %zu | %.1e | %.1e | %.3g |\n", method, name, tol, l->degree[0],
               l->degree[1], l->points, l->spans, l->length, l->angle, 1e3 * l->seconds);
    else
        printf("| %s | %s | %.0e | %s |\n", method, name, tol, kn_ctx_message(ctx));
    fflush(stdout);
    kn_ctx_clear_error(ctx);
}

// What would take more than half a minute and a gigabyte.
static bool is_large(const base *b, int m, double tol)
{
    bool waves = strncmp(b->name, "waves", 5) == 0;
    return waves && ((m == 1 && tol < 1e-8) || (m == METHODS && tol < 1e-5));
}

// Both with degrees up to 5, of n and of m; N m with m cubic too, which is the default, down to 1e-6.
static void measure_all(kn_ctx *ctx, const base *bases, line lines[METHODS][BASES][TOLERANCES])
{
    static const double tolerance[TOLERANCES] = {1e-3, 1e-6, 1e-9};
    printf("| method | surface | tolerance | degree | control points | spans | length error | angle error | ms |\n"
           "|---|---|--:|---|--:|--:|--:|--:|--:|\n");
    for (int m = 0; m <= METHODS; m++)
        for (int k = 0; k < BASES; k++)
            for (int i = 0; i < (m == METHODS ? TOLERANCES - 1 : TOLERANCES); i++) {
                kn_shell_options o = {.normal = m ? KN_NORMAL_EXACT_DIRECTION : KN_NORMAL_FITTED};
                o.normal_tol = tolerance[i];
                o.max_degree = m < METHODS ? 5 : 3;
                line l = {.status = KN_ELIMIT};
                if (m < METHODS) lines[m][k][i] = l;
                if (is_large(&bases[k], m, tolerance[i])) continue;
                l = measure(ctx, &bases[k], &o);
                print(m < METHODS ? method_name[m] : "direction-exact, m cubic", bases[k].name, tolerance[i], &l,
                      ctx);
                if (m < METHODS) lines[m][k][i] = l;
            }
}

// An argument: where to draw the picture of docs/normals.md.
int main(int argc, char **argv)
{
    static base bases[BASES];
    static line lines[METHODS][BASES][TOLERANCES];
    kn_ctx *ctx = NULL;
    if (kn_ctx_create(&ctx, NULL) != KN_OK) return 1;
    make_bases(ctx, bases);
    measure_all(ctx, bases, lines);
    bool drawn = argc < 2 || draw(argv[1], bases, lines);
    for (int k = 0; k < BASES; k++)
        for (int i = 0; i < bases[k].n; i++) kn_spline_clear(ctx, &bases[k].part[i]);
    kn_ctx_destroy(ctx);
    return drawn ? 0 : 1;
}
