// SPDX-License-Identifier: Apache-2.0
// Contours of trimmed patches: what two sides of a trim have is what the whole patch has, and ends meet; closed bases
// whose knot lines cross the tiles give closed contours that enclose what a fine mesh of them encloses.
#include "kernel/context.h"
#include "tests/support/support.h"
#include "tests/support/surfaces.h"

#include <knurl/io.h>
#include <knurl/mesh.h>
#include <knurl/slice.h>
#include <knurl/trim.h>

#include <math.h>

enum { LAYERS = 8 };

typedef struct seen {
    size_t layers, nloops[LAYERS], nopen[LAYERS], points[LAYERS];
    double area[LAYERS], length[LAYERS], z[LAYERS], gap, error;
} seen;

static kn_status look(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    (void)ctx;
    seen *s = user;
    size_t k = s->layers++;
    s->nloops[k] = layer->nloops, s->nopen[k] = layer->nopen, s->z[k] = layer->z;
    s->gap = fmax(s->gap, layer->gap), s->error = fmax(s->error, layer->error);
    for (size_t l = 0; l < layer->nloops; l++) {
        const kn_slice_loop *loop = &layer->loops[l];
        s->points[k] += loop->npoints;
        for (size_t i = 0; i + !loop->closed < loop->npoints; i++) {
            const double *a = loop->points + 2 * i, *b = loop->points + 2 * ((i + 1) % loop->npoints);
            s->area[k] += 0.5 * (a[0] * b[1] - b[0] * a[1]);
            s->length[k] += hypot(b[0] - a[0], b[1] - a[1]);
        }
    }
    return KN_OK;
}

static kn_status feed(kn_ctx *ctx, seen *s, const kn_patch *patches, size_t n, const kn_slice_options *o)
{
    kn_sink sink = {0};
    void *product = NULL;
    kn_patch_block block = {0, n, patches};
    kn_status status = kn_slice_sink(ctx, &sink, o, look, s);
    if (status == KN_OK) status = sink.work(ctx, sink.user, &block, &product);
    if (status == KN_OK) status = sink.commit(ctx, sink.user, &block, product);
    if (status == KN_OK) status = sink.end(ctx, sink.user);
    if (sink.user) kn_sink_close(ctx, &sink);
    return status;
}

// ---- one patch, cut into two ----

// A bicubic height field z = r + 0.3 (wave) over [0,3]^2.
static kn_status make_patch(kn_ctx *ctx, kn_bezier *p)
{
    const int degree[2] = {3, 3};
    kn_status status = kn_bezier_init(ctx, p, 2, 3, false, degree);
    for (int i = 0; status == KN_OK && i < 4; i++)
        for (int j = 0; j < 4; j++) {
            p->coef[4 * i + j] = i, p->coef[16 + 4 * i + j] = j;
            p->coef[32 + 4 * i + j] = i / 3.0 + 0.3 * ((i + 2 * j) % 3 - 1);
        }
    return status;
}

// A loop of `n` curves of the degree through given control points, the last of each the first of the next. backwards:
// turned, in reverse order.
static kn_status add_loop(kn_ctx *ctx, kn_trim *trim, int n, int degree, const double (*points)[2], bool backwards)
{
    kn_status status = KN_OK;
    int total = n * degree;
    for (int k = 0; status == KN_OK && k < n; k++) {
        int from = backwards ? n - 1 - k : k, d[] = {degree}, count[] = {degree + 1};
        kn_spline *c = &trim->curves[trim->ncurves];
        double knots[6] = {0}, coef[6];
        for (int i = 0; i <= degree; i++) {
            knots[degree + 1 + i] = 1.0;
            for (int v = 0; v < 2; v++) coef[v * (degree + 1) + i] = points[(from * degree + i) % total][v];
        }
        status = kn_spline_init(ctx, c, 1, 2, false, d, count, (const double *const[]){knots}, coef);
        if (status == KN_OK && backwards) kn_trim_turn(c);
        trim->ncurves += status == KN_OK;
    }
    trim->loop_end[trim->nloops++] = trim->ncurves;
    return status;
}

static const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

// Inside a loop, and outside of it.
static kn_status make_trims(kn_ctx *ctx, kn_trim trims[2], int n, int degree, const double (*points)[2])
{
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < 2; k++) {
        trims[k].curves = kn_alloc_zero(ctx, (size_t)n + 4, sizeof *trims[k].curves);
        trims[k].loop_end = kn_alloc_zero(ctx, 2, sizeof *trims[k].loop_end);
        if (!trims[k].curves || !trims[k].loop_end) return KN_ENOMEM;
        if (k == 1) status = add_loop(ctx, &trims[k], 4, 1, square, false);
        if (status == KN_OK) status = add_loop(ctx, &trims[k], n, degree, points, k == 1);
        if (status == KN_OK) status = kn_trim_check(ctx, &trims[k]);
    }
    return status;
}

// A polygon with a corner on the contours' way, and a rounded loop of parabolas.
static const double polygon[5][2] = {{0.2, 0.3}, {0.7, 0.1}, {0.9, 0.6}, {0.5, 0.45}, {0.3, 0.85}};
static const double rounded[8][2] = {{0.5, 0.2}, {0.8, 0.2}, {0.8, 0.5}, {0.8, 0.8},
                                     {0.5, 0.8}, {0.2, 0.8}, {0.2, 0.5}, {0.2, 0.2}};

static void two_sides(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier p = {0};
    assert_int_equal(make_patch(ctx, &p), KN_OK);
    kn_slice_options o = {0.05, 0.125, LAYERS, 1e-4, 0};
    for (int shape = 0; shape < 2; shape++) {
        kn_trim trims[2] = {{0}};
        assert_int_equal(make_trims(ctx, trims, shape ? 4 : 5, shape ? 2 : 1, shape ? rounded : polygon), KN_OK);
        const kn_patch whole = {.bezier = p},
                       parts[2] = {{.bezier = p, .trim = &trims[0]}, {.bezier = p, .trim = &trims[1]}};
        seen all = {0}, both = {0}, inside = {0};
        o.join = 0;
        assert_int_equal(feed(ctx, &all, &whole, 1, &o), KN_OK);
        if (shape == 0) o.join = 1e-300; // one polyline, cut alike on both sides: bit for bit
        assert_int_equal(feed(ctx, &both, parts, 2, &o), KN_OK);
        assert_int_equal(feed(ctx, &inside, parts, 1, &o), KN_OK);
        if (shape == 0) assert_true(both.gap == 0);
        size_t cut = 0;
        for (int k = 0; k < LAYERS; k++) {
            assert_int_equal(both.nloops[k], all.nloops[k]);
            assert_int_equal(both.nopen[k], all.nopen[k]);
            // both follow the contour within tol: a polyline within tol of another, with few points, is as long
            assert_true(fabs(both.length[k] - all.length[k]) <= 2e-3 * all.length[k] + 1e-9);
            assert_true(inside.length[k] <= both.length[k] + 1e-9);
            cut += inside.nopen[k];
        }
        assert_true(cut >= 4);
        assert_true(both.error <= 1e-4 && both.error > 0);
        for (int k = 0; k < 2; k++) kn_trim_clear(ctx, &trims[k]);
    }
    kn_bezier_clear(ctx, &p);
    test_ctx_end(ctx, &memory);
}

// z = r, so that contours are lines r = z; a trim that is a triangle: lengths are known.
static void known_lengths(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier p = {0};
    const int degree[2] = {1, 1};
    const double triangle[3][2] = {{0.0, 0.25}, {1.0, 0.25}, {1.0, 0.75}};
    assert_int_equal(kn_bezier_init(ctx, &p, 2, 3, false, degree), KN_OK);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) p.coef[2 * i + j] = i, p.coef[4 + 2 * i + j] = 2 * j, p.coef[8 + 2 * i + j] = i;
    kn_trim trims[2] = {{0}};
    assert_int_equal(make_trims(ctx, trims, 3, 1, triangle), KN_OK);
    kn_slice_options o = {0.1, 0.1, LAYERS, 1e-3, 0};
    for (int k = 0; k < 2; k++) {
        seen s = {0};
        kn_patch part = {.bezier = p, .trim = &trims[k]};
        assert_int_equal(feed(ctx, &s, &part, 1, &o), KN_OK);
        for (int i = 0; i < LAYERS; i++) {
            double z = s.z[i], within = 2 * (0.5 * z); // y = 2 t, t from 1/4 to 1/4 + z/2
            assert_int_equal(s.nloops[i], k == 0 ? 1 : 2);
            assert_true(fabs(s.length[i] - (k == 0 ? within : 2 - within)) <= 1e-14);
        }
        kn_trim_clear(ctx, &trims[k]);
    }
    kn_bezier_clear(ctx, &p);
    test_ctx_end(ctx, &memory);
}

// ---- closed objects ----

// Twice the signed area of what triangles enclose at height z: the integral of x dy - y dx along their sections.
static double section_area(const kn_mesh *mesh, double z, double *length)
{
    double area = 0.0;
    *length = 0.0;
    for (size_t i = 0; i < mesh->ntriangles; i++) {
        double in[2] = {0}, out[2] = {0};
        int n = 0;
        for (int k = 0; k < 3; k++) {
            const double *a = mesh->position + 3 * (size_t)mesh->triangle[3 * i + (size_t)k];
            const double *b = mesh->position + 3 * (size_t)mesh->triangle[3 * i + (size_t)(k + 1) % 3];
            if ((a[2] >= z) == (b[2] >= z)) continue;
            double s = (z - a[2]) / (b[2] - a[2]), *to = a[2] >= z ? in : out; // what is above lies to the left
            to[0] = a[0] + s * (b[0] - a[0]), to[1] = a[1] + s * (b[1] - a[1]);
            n++;
        }
        if (n < 2) continue;
        area += in[0] * out[1] - out[0] * in[1];
        *length += hypot(out[0] - in[0], out[1] - in[1]);
    }
    return 0.5 * area;
}

typedef struct triangles {
    kn_mesh *mesh;
    size_t *trimmed;
} triangles;

static kn_status tessellate(kn_ctx *ctx, void *user, const kn_patch_block *block, void **product)
{
    triangles *t = user;
    kn_status status = KN_OK;
    *product = NULL;
    for (size_t i = 0; status == KN_OK && i < block->count; i++) {
        *t->trimmed += block->patches[i].trim != NULL;
        status = kn_patch_tessellate(ctx, t->mesh, &block->patches[i]);
    }
    return status;
}

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx, (void)user, (void)block, (void)product;
    return KN_OK;
}

// A torus, closed both ways, shifted so that its knot lines lie inside of cells.
static void closed_over_knots(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    make_torus(ctx, &base);
    assert_int_equal(kn_builtin_tile(ctx, &tile, "knurl"), KN_OK);
    kn_job_options o = {.count = {4, 4}, .height = 0.15, .normal_tol = 2e-2, .max_degree = 40};
    o.placement.shift[0] = 0.35;
    o.crossing = KN_CROSSING_TRIM, o.crossing_tol = 1e-3, o.mesh_tol = 2e-3;
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
    const kn_job *jobs[] = {job};
    kn_slice_options s = {-0.95, 0.9, 2, 2e-3, 0};
    seen got = {0};
    assert_int_equal(kn_slice_job(ctx, jobs, 1, &s, look, &got, NULL), KN_OK);
    kn_mesh mesh = {0};
    size_t trimmed = 0;
    triangles t = {&mesh, &trimmed};
    kn_sink sink = {.user = &t, .work = tessellate, .commit = commit};
    assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_OK);
    assert_true(trimmed > 20);
    assert_int_equal(got.layers, 2);
    assert_true(got.error <= 2e-3);
    for (int k = 0; k < 2; k++) {
        double length, area = section_area(&mesh, got.z[k], &length);
        assert_int_equal(got.nopen[k], 0);
        assert_int_equal(got.nloops[k], 2);
        // both are within their tolerances of the surface; here a section moves by at most four times that
        assert_true(fabs(got.area[k] - area) <= (2e-3 + 4e-3 + got.gap) * length);
    }
    kn_mesh_clear(ctx, &mesh);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_bezier p = {0};
    kn_trim trims[2] = {{0}};
    seen s = {0};
    kn_slice_options o = {0.05, 0.5, 2, 1e-2, 0};
    kn_status status = make_patch(ctx, &p);
    if (status == KN_OK) status = make_trims(ctx, trims, 4, 2, rounded);
    kn_patch part = {.bezier = p, .trim = &trims[1]};
    if (status == KN_OK) status = feed(ctx, &s, &part, 1, &o);
    for (int k = 0; k < 2; k++) kn_trim_clear(ctx, &trims[k]);
    kn_bezier_clear(ctx, &p);
    return status;
}

static void failures(void **state)
{
    (void)state;
    test_allocation_failures(call, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(two_sides), cmocka_unit_test(known_lengths),
                                       cmocka_unit_test(closed_over_knots), cmocka_unit_test(failures)};
    return cmocka_run_group_tests_name("slice/trim", tests, NULL, NULL);
}
