// SPDX-License-Identifier: Apache-2.0
// Small bases and tiles, and a sink that keeps what it gets.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void surface(kn_ctx *ctx, kn_spline *out, bool rational, const int degree[2], const int count[2],
                    const double *u, const double *v, const double *coef)
{
    const double *knots[2] = {u, v};
    assert_int_equal(kn_spline_init(ctx, out, 2, rational ? 4 : 3, rational, degree, count, knots, coef), KN_OK);
}

void scene_bicubic(kn_ctx *ctx, kn_spline *out, double bend)
{
    static const double knots[] = {0, 0, 0, 0, 1, 1, 1, 1};
    const int degree[2] = {3, 3}, count[2] = {4, 4};
    double coef[48];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            coef[4 * i + j] = i + 0.1 * j;
            coef[16 + 4 * i + j] = j - 0.05 * i * i;
            coef[32 + 4 * i + j] = bend * ((i - 1.5) * (i - 1.5) + 0.5 * i * j);
        }
    surface(ctx, out, false, degree, count, knots, knots, coef);
}

// Quarter circles with weights 1, sqrt(1/2), 1 in both directions; radii 3 and 1.
void scene_torus(kn_ctx *ctx, kn_spline *out)
{
    static const double knots[] = {0, 0, 0, 1, 1, 1};
    const int degree[2] = {2, 2}, count[2] = {3, 3};
    const double c[3] = {1, 1, 0}, s[3] = {0, 1, 1}, w[3] = {1, sqrt(0.5), 1};
    double coef[36];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double f = w[i] * w[j], radius = 3 + c[j];
            coef[3 * i + j] = f * radius * c[i];
            coef[9 + 3 * i + j] = f * radius * s[i];
            coef[18 + 3 * i + j] = f * s[j];
            coef[27 + 3 * i + j] = f;
        }
    surface(ctx, out, true, degree, count, knots, knots, coef);
}

void scene_cylinder(kn_ctx *ctx, kn_spline *out)
{
    static const double u[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, v[] = {0, 0, 1, 1};
    static const double x[9] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, y[9] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
    const int degree[2] = {2, 1}, count[2] = {9, 2};
    double coef[72];
    for (int i = 0; i < 9; i++)
        for (int j = 0; j < 2; j++) {
            double f = i % 2 ? sqrt(0.5) : 1;
            coef[2 * i + j] = f * x[i];
            coef[18 + 2 * i + j] = f * y[i];
            coef[36 + 2 * i + j] = f * 2 * j;
            coef[54 + 2 * i + j] = f;
        }
    surface(ctx, out, true, degree, count, u, v, coef);
}

void scene_spline(kn_ctx *ctx, kn_spline *out)
{
    static const double u[] = {0, 0, 0, 0, 1, 3, 4, 4, 4, 4}, v[] = {-1, -1, -1, -1, 0.5, 2, 2, 2, 2};
    const int degree[2] = {3, 3}, count[2] = {6, 5};
    double coef[90];
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 5; j++) {
            coef[5 * i + j] = i;
            coef[30 + 5 * i + j] = j + 0.1 * sin(i);
            coef[60 + 5 * i + j] = 0.3 * cos(0.7 * i) * sin(0.5 * j);
        }
    surface(ctx, out, false, degree, count, u, v, coef);
}

// ---- tiles ----

void scene_multilinear(kn_ctx *ctx, kn_spline *out, int nvars, const double *corner)
{
    const int degree[3] = {1, 1, 1};
    kn_bezier b = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, nvars, 3, false, degree), KN_OK);
    size_t n = kn_bezier_count(&b);
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++) b.coef[c * n + i] = corner[3 * i + c];
    assert_int_equal(kn_spline_of_bezier(ctx, out, &b), KN_OK);
    kn_bezier_clear(ctx, &b);
}

void scene_add_patch(kn_ctx *ctx, kn_tile *tile, int m, int n, const double *coef)
{
    const int degree[2] = {m, n};
    kn_bezier b = {0};
    kn_spline s = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
    memcpy(b.coef, coef, 3 * kn_bezier_count(&b) * sizeof *coef);
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &s), KN_OK);
    kn_bezier_clear(ctx, &b), kn_spline_clear(ctx, &s);
}

void scene_plate(kn_ctx *ctx, kn_tile *out)
{
    static const double coef[12] = {0.1, 0.1, 0.9, 0.9, 0.1, 0.9, 0.1, 0.9, 0.2, 0.5, 0.7, 1};
    assert_int_equal(kn_tile_init(ctx, out, "plate", 1), KN_OK);
    scene_add_patch(ctx, out, 1, 1, coef);
}

void scene_box(kn_ctx *ctx, kn_tile *out)
{
    double corner[24];
    kn_spline box = {0};
    for (int k = 0; k < 8; k++) {
        corner[3 * k] = k & 4 ? 0.6 : 0.1;
        corner[3 * k + 1] = k & 2 ? 0.9 : 0.2;
        corner[3 * k + 2] = k & 1 ? 0.5 : 0.0;
    }
    scene_multilinear(ctx, &box, 3, corner);
    assert_int_equal(kn_tile_init(ctx, out, "box", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, out, 0, &box), KN_OK);
    kn_spline_clear(ctx, &box);
}

// Quarter k covers the square of the cell between the centre and a corner; r and t run along u and v, or the other
// way round and backwards, so that shared edges are met in all combinations; r x t always points up.
void scene_dome(kn_ctx *ctx, kn_tile *out)
{
    assert_int_equal(kn_tile_init(ctx, out, "dome", 1), KN_OK);
    static const double grid[5] = {0, 0.25, 0.5, 0.75, 1}, lift[5] = {0, 0.3, 0.8, 0.3, 0};
    for (int k = 0; k < 4; k++) {
        double coef[27];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                int a = k == 0 ? i : k == 1 ? 2 - j : k == 2 ? 2 - i : j; // quarter turns of the parameters
                int b = k == 0 ? j : k == 1 ? i : k == 2 ? 2 - j : 2 - i;
                int u = a + 2 * (k & 1), v = b + (k & 2);
                coef[3 * i + j] = grid[u];
                coef[9 + 3 * i + j] = grid[v];
                coef[18 + 3 * i + j] = lift[u] * lift[v];
            }
        scene_add_patch(ctx, out, 2, 2, coef);
    }
}

void scene_strip(kn_ctx *ctx, kn_tile *out)
{
    assert_int_equal(kn_tile_init(ctx, out, "strip", 1), KN_OK);
    static const double coef[18] = {-0.25, -0.25, 0.6,  0.6, 1.25, 1.25, 0.25, 0.75, 0.25,
                                    0.75,  0.25,  0.75, 0,   0,    0.9,  1,    0.1,  0.1};
    scene_add_patch(ctx, out, 2, 1, coef);
}

void scene_diamond(kn_ctx *ctx, kn_tile *out)
{
    assert_int_equal(kn_tile_init(ctx, out, "diamond", 1), KN_OK);
    double coef[12];
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) {
            double x = 0.55 * (2 * i - 1), y = 0.55 * (2 * j - 1);
            coef[2 * i + j] = 0.5 + 0.5 * sqrt(3) * x - 0.5 * y;
            coef[4 + 2 * i + j] = 0.5 + 0.5 * x + 0.5 * sqrt(3) * y;
            coef[8 + 2 * i + j] = 0.2 + 0.5 * i + 0.3 * j;
        }
    scene_add_patch(ctx, out, 1, 1, coef);
}

// ---- the sink ----

static kn_status begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)ctx, (void)tile, (void)report;
    ((scene_result *)user)->begun++;
    return KN_OK;
}

static void *copy_of(const void *from, size_t bytes)
{
    void *copy = malloc(bytes + 1);
    assert_non_null(copy);
    memcpy(copy, from, bytes);
    return copy;
}

static const kn_mesh *copy_mesh(const kn_mesh *from)
{
    kn_mesh *to = copy_of(from, sizeof *from);
    to->position = copy_of(from->position, 3 * from->nvertices * sizeof *from->position);
    to->normal = copy_of(from->normal, 3 * from->nvertices * sizeof *from->normal);
    to->triangle = copy_of(from->triangle, 3 * from->ntriangles * sizeof *from->triangle);
    return to;
}

static void free_mesh(const kn_mesh *mesh)
{
    free(mesh->position);
    free(mesh->normal);
    free(mesh->triangle);
    free((void *)mesh);
}

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx, (void)product;
    scene_result *r = user;
    assert_int_equal(block->first, r->count);
    if (r->count + block->count > r->room) {
        r->room = 2 * (r->count + block->count);
        r->patches = realloc(r->patches, r->room * sizeof *r->patches);
        assert_non_null(r->patches);
    }
    for (size_t i = 0; i < block->count; i++) {
        kn_patch *to = &r->patches[r->count++];
        *to = block->patches[i];
        size_t n = (size_t)to->bezier.ncomp * kn_bezier_count(&to->bezier);
        double *copy = malloc((n + 1) * sizeof *copy); // n is 0 for a mesh
        assert_non_null(copy);
        if (n > 0) memcpy(copy, to->bezier.coef, n * sizeof *copy);
        to->bezier.coef = copy;
        if (to->mesh) to->mesh = copy_mesh(to->mesh);
    }
    return KN_OK;
}

static kn_status finish(kn_ctx *ctx, void *user)
{
    (void)ctx;
    ((scene_result *)user)->ended++;
    return KN_OK;
}

static void close_sink(kn_ctx *ctx, void *user)
{
    (void)ctx;
    ((scene_result *)user)->closed++;
}

kn_sink scene_sink(scene_result *result)
{
    *result = (scene_result){0};
    return (kn_sink){.user = result, .begin = begin, .commit = commit, .end = finish, .close = close_sink};
}

void scene_result_clear(scene_result *result)
{
    for (size_t i = 0; i < result->count; i++) {
        free(result->patches[i].bezier.coef);
        if (result->patches[i].mesh) free_mesh(result->patches[i].mesh);
    }
    free(result->patches);
    *result = (scene_result){0};
}

void scene_run(kn_ctx *ctx, const kn_job *job, scene_result *r)
{
    kn_sink sink = scene_sink(r);
    if (kn_job_run(ctx, job, &sink, 1) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    assert_int_equal(r->begun, 1);
    assert_int_equal(r->ended, 1);
    kn_sink_close(ctx, &sink);
    assert_int_equal(r->closed, 1);
}

long double scene_parameter(const kn_job *job, int surface, int var, long double cells)
{
    const double *line = kn_job_lines(job, surface, var);
    int count[2];
    bool closed[2];
    kn_shell_cells(kn_job_shell(job, surface), count);
    kn_shell_closed(kn_job_shell(job, surface), closed);
    int n = count[var];
    if (closed[var]) cells -= n * floorl(cells / n);
    int i = (int)floorl(cells);
    i = i < 0 ? 0 : i > n - 1 ? n - 1 : i;
    return line[i] + (cells - i) * ((long double)line[i + 1] - line[i]);
}

kn_status scene_try_job(kn_ctx *ctx, scene_make make, const kn_job_options *options)
{
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *safe = test_ctx(&memory, 1);
    make(safe, &base, &tile);
    kn_status status = kn_job_create(ctx, &job, &base, 1, &tile, options);
    assert_true((status == KN_OK) == (job != NULL));
    kn_job_destroy(ctx, job);
    kn_tile_clear(safe, &tile);
    kn_spline_clear(safe, &base);
    test_ctx_end(safe, &memory);
    return status;
}

double scene_trim_area(const kn_trim *trim)
{
    double area = 0.0;
    if (trim->nloops == 0) return 1.0;
    for (int i = 0; i < trim->ncurves; i++) {
        const kn_spline *c = &trim->curves[i];
        int n = c->count[0];
        assert_int_equal(c->degree[0], 1);
        for (int k = 0; k + 1 < n; k++)
            area += 0.5 * (c->coef[k] * c->coef[n + k + 1] - c->coef[k + 1] * c->coef[n + k]);
    }
    return area;
}
