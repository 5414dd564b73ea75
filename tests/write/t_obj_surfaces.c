// SPDX-License-Identifier: Apache-2.0
// OBJ files with free-form surfaces, by a reader written from the format's description.
#include "tests/write/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 4096 };

// What one "curv", "curv2" or "surf" .. "end" says.
typedef struct element {
    char kind[8];
    bool rational;
    int degree[2], nknots[2], npoints;
    double range[4], knots[2][64], points[256][4];
    int nloops, loop_curves[4], curve[4][4]; // elements that loops are made of
    bool hole[4];
} element;

typedef struct obj {
    element list[64];
    int n, groups;
    double v[MOST][4], vp[MOST][2];
    int nv, nvp, curves2[64], ncurves2;
} obj;

static int take_numbers(const char *at, double *out, int most)
{
    int n = 0;
    for (char *end; n < most; n++, at = end) {
        double x = strtod(at, &end);
        if (end == at) break;
        out[n] = x;
    }
    return n;
}

static void take_element(obj *o, element *e, const char *line)
{
    double x[260];
    int n = take_numbers(strchr(line, ' '), x, 260), skip = 0;
    assert_int_equal(sscanf(line, "%7s", e->kind), 1);
    if (strcmp(e->kind, "curv") == 0) skip = 2;
    if (strcmp(e->kind, "surf") == 0) skip = 4;
    for (int i = 0; i < skip; i++) e->range[i] = x[i];
    e->npoints = n - skip;
    for (int i = 0; i < e->npoints; i++) {
        bool plane = strcmp(e->kind, "curv2") == 0;
        int at = (plane ? o->nvp : o->nv) + (int)x[skip + i];
        assert_true(x[skip + i] < 0 && at >= 0);
        for (int c = 0; c < (plane ? 2 : 4); c++) e->points[i][c] = plane ? o->vp[at][c] : o->v[at][c];
    }
}

static void take_loop(obj *o, element *e, const char *line)
{
    double x[12];
    int n = take_numbers(strchr(line, ' '), x, 12), loop = e->nloops++;
    assert_int_equal(n % 3, 0);
    e->hole[loop] = line[0] == 'h';
    e->loop_curves[loop] = n / 3;
    for (int i = 0; i < n / 3; i++) e->curve[loop][i] = o->curves2[o->ncurves2 + (int)x[3 * i + 2]];
}

static void take_line(obj *o, const char *line)
{
    element *e = &o->list[o->n];
    double x[3];
    if (strncmp(line, "v ", 2) == 0) {
        o->v[o->nv][3] = 1.0;
        assert_true(take_numbers(line + 2, o->v[o->nv++], 4) >= 3);
    }
    if (strncmp(line, "vp ", 3) == 0) assert_int_equal(take_numbers(line + 3, o->vp[o->nvp++], 2), 2);
    if (strncmp(line, "g ", 2) == 0) o->groups++;
    if (strncmp(line, "cstype", 6) == 0) e->rational = strstr(line, " rat bspline") != NULL;
    if (strncmp(line, "deg ", 4) == 0)
        for (int d = take_numbers(line + 4, x, 2) - 1; d >= 0; d--) e->degree[d] = (int)x[d];
    if (strncmp(line, "curv", 4) == 0 || strncmp(line, "surf", 4) == 0) take_element(o, e, line);
    if (strncmp(line, "parm ", 5) == 0)
        e->nknots[line[5] == 'v'] = take_numbers(line + 6, e->knots[line[5] == 'v'], 64);
    if (strncmp(line, "trim ", 5) == 0 || strncmp(line, "hole ", 5) == 0) take_loop(o, e, line);
    if (strcmp(line, "end") == 0 && strcmp(e->kind, "curv2") == 0) o->curves2[o->ncurves2++] = o->n;
    if (strcmp(line, "end") == 0) o->n++;
}

static obj *read_obj(char *text)
{
    obj *o = calloc(1, sizeof *o);
    assert_non_null(o);
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) take_line(o, line);
    free(text);
    return o;
}

// The same spline: knots bit for bit, and control points, of rational ones but for the division.
static void compare(const element *e, const kn_spline *s)
{
    size_t n = kn_spline_count(s);
    assert_string_equal(e->kind, s->nvars == 1 ? "curv" : "surf");
    assert_int_equal(e->rational, s->rational);
    assert_int_equal(e->npoints, n);
    for (int d = 0; d < s->nvars; d++) {
        assert_int_equal(e->degree[d], s->degree[d]);
        assert_int_equal(e->nknots[d], s->count[d] + s->degree[d] + 1);
        assert_memory_equal(e->knots[d], s->knots[d], (size_t)e->nknots[d] * sizeof(double));
        assert_true(e->range[2 * d] == s->knots[d][0] && e->range[2 * d + 1] == s->knots[d][e->nknots[d] - 1]);
    }
    for (size_t k = 0; k < n; k++) { // u runs fastest in the file, v in the spline
        size_t nu = (size_t)s->count[0], nv = s->nvars == 2 ? (size_t)s->count[1] : 1, at = k % nu * nv + k / nu;
        double weight = s->rational ? s->coef[3 * n + at] : 1.0;
        for (size_t c = 0; c < 3; c++) assert_true(e->points[k][c] == s->coef[c * n + at] / weight);
        assert_true(e->points[k][3] == weight);
    }
}

static void curves_and_surfaces(void **state)
{
    (void)state;
    world w;
    world_make(&w, "free.obj");
    obj *o = read_obj(world_write(&w, kn_obj_surfaces_sink, 0, 6, 2, NULL));
    assert_int_equal(o->n, 6);
    for (int i = 0; i < 6; i++) {
        kn_spline s;
        world_spline(&w, &s, i);
        compare(&o->list[i], &s);
        kn_spline_clear(w.ctx, &s);
    }
    assert_int_equal(o->groups, 6);
    free(o);
    world_clear(&w);
}

// The six faces of a volume, less those that are hidden, look outside: the integral of x . n over all of them is three
// times the volume, which the integral of the Jacobian's determinant is, too.
static double flux(kn_ctx *ctx, const element *e)
{
    enum { N = 24 };
    double sum = 0;
    kn_spline s = {0};
    const double *const knots[2] = {e->knots[0], e->knots[1]};
    int count[2] = {e->nknots[0] - e->degree[0] - 1, e->nknots[1] - e->degree[1] - 1};
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, e->degree, count, knots, NULL), KN_OK);
    size_t n = kn_spline_count(&s);
    for (size_t k = 0; k < n; k++)
        for (size_t c = 0; c < 3; c++)
            s.coef[c * n + k % (size_t)count[0] * (size_t)count[1] + k / (size_t)count[0]] = e->points[k][c];
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) { // midpoints: exact for nothing, good to 1 / N^2
            double d[9], at[2] = {(i + 0.5) / N, (j + 0.5) / N};
            assert_int_equal(kn_spline_derivatives(ctx, d, &s, at, 1), KN_OK);
            for (int c = 0; c < 3; c++) {
                int y = (c + 1) % 3, z = (c + 2) % 3;
                sum += d[c] * (d[3 + y] * d[6 + z] - d[3 + z] * d[6 + y]) / (N * N);
            }
        }
    kn_spline_clear(ctx, &s);
    return sum;
}

static void volumes(void **state)
{
    (void)state;
    world w;
    world_make(&w, "volume.obj");
    const int degree[3] = {2, 1, 1};
    for (int reversed = 0; reversed < 2; reversed++) {
        kn_patch p = {.reversed = reversed};
        assert_int_equal(kn_bezier_init(w.ctx, &p.bezier, 3, 3, false, degree), KN_OK);
        for (int k = 0; k < 12; k++) { // a bent bar of section 1 x 2; mirrored when it is said to be
            int i = k / 4, j = k / 2 % 2, l = k % 2;
            p.bezier.coef[k] = i, p.bezier.coef[12 + k] = (reversed ? -1 : 1) * j + (i == 1);
            p.bezier.coef[24 + k] = 2 * l;
        }
        kn_patch kept = w.patch[0];
        w.patch[0] = p;
        obj *o = read_obj(world_write(&w, kn_obj_surfaces_sink, 0, 1, 1, NULL));
        double sum = 0;
        assert_int_equal(o->n, 6);
        for (int f = 0; f < 6; f++) sum += flux(w.ctx, &o->list[f]);
        assert_true(fabs(sum / 3 - 4) < 0.01); // sheared, not stretched: 2 x 1 x 2
        free(o);
        w.patch[0].hidden = 1 << 0 | 1 << 3; // where variable 0 begins, and variable 1 ends
        obj *some = read_obj(world_write(&w, kn_obj_surfaces_sink, 0, 1, 1, NULL));
        assert_int_equal(some->n, 4);
        for (int f = 0; f < 4; f++) {
            double least = INFINITY, most = -INFINITY, end = -INFINITY;
            for (int k = 0; k < some->list[f].npoints; k++) {
                const double *x = some->list[f].points[k];
                double y = x[1] - (x[0] == 1);
                least = fmin(least, x[0]), most = fmax(most, x[0]), end = fmax(end, -fabs(y));
            }
            assert_false(least == 0 && most == 0);   // not where variable 0 begins
            assert_false(least == 0 && end == -1.0); // nor where variable 1 ends
        }
        free(some);
        w.patch[0] = kept;
        kn_bezier_clear(w.ctx, &p.bezier);
    }
    world_clear(&w);
}

static void trims(void **state)
{
    (void)state;
    world w;
    kn_trim trim;
    world_make(&w, "trim.obj");
    world_make_trim(&w, &trim);
    w.patch[0].trim = &trim;
    obj *o = read_obj(world_write(&w, kn_obj_surfaces_sink, 0, 1, 1, NULL));
    assert_int_equal(o->n, 4);
    const element *surface = &o->list[3];
    assert_string_equal(surface->kind, "surf");
    assert_int_equal(surface->nloops, 1);
    assert_false(surface->hole[0]);
    assert_int_equal(surface->loop_curves[0], 3);
    for (int i = 0; i < 3; i++) {
        const element *c = &o->list[surface->curve[0][i]];
        const kn_spline *s = &trim.curves[i];
        size_t n = kn_spline_count(s);
        assert_string_equal(c->kind, "curv2");
        assert_int_equal(c->npoints, n);
        for (size_t k = 0; k < n; k++)
            assert_true(c->points[k][0] == s->coef[k] && c->points[k][1] == s->coef[n + k]);
    }
    free(o);
    kn_trim_clear(w.ctx, &trim);
    world_clear(&w);
}

static void refusals(void **state)
{
    (void)state;
    world w;
    kn_sink sink = {0};
    world_make(&w, "refused.obj");
    assert_int_equal(kn_obj_surfaces_sink(w.ctx, &sink, "/nowhere/x.obj"), KN_EIO);
    w.patch[2].bezier.coef[3 * 12] = -1.0;
    world_refused(&w, kn_obj_surfaces_sink, 0, 4, "a weight that is not positive");
    world_without_memory(&w, kn_obj_surfaces_sink, 4, 4);
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_and_surfaces),
        cmocka_unit_test(volumes),
        cmocka_unit_test(trims),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("write/obj_surfaces", tests, NULL, NULL);
}
