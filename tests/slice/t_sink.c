// SPDX-License-Identifier: Apache-2.0
// Contours of surfaces that are known: spheres, tori, a cube; closed, oriented, within the tolerance.
#include "tests/support/support.h"

#include <knurl/construct.h>
#include <knurl/mesh.h>
#include <knurl/slice.h>

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

// What a test wants to know of each layer.
typedef struct seen {
    size_t count, nloops[64], nopen[64];
    double z[64], area[64], gap, least[64], most[64]; // signed area; distance of points from the z axis
    bool stop;
} seen;

static kn_status look(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    (void)ctx;
    seen *s = user;
    assert_int_equal(layer->index, s->count);
    if (s->stop) return KN_ECANCELLED;
    size_t k = s->count++;
    s->z[k] = layer->z, s->nloops[k] = layer->nloops, s->nopen[k] = layer->nopen;
    s->area[k] = 0, s->least[k] = INFINITY, s->most[k] = 0;
    s->gap = fmax(s->gap, layer->gap);
    for (size_t l = 0; l < layer->nloops; l++) {
        const kn_slice_loop *loop = &layer->loops[l];
        for (size_t i = 0; i < loop->npoints; i++) {
            const double *a = loop->points + 2 * i, *b = loop->points + 2 * ((i + 1) % loop->npoints);
            s->area[k] += 0.5 * (a[0] * b[1] - b[0] * a[1]);
            double r = hypot(a[0], a[1]), middle = hypot(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]));
            s->least[k] = fmin(s->least[k], fmin(r, loop->closed ? middle : r));
            s->most[k] = fmax(s->most[k], r);
        }
    }
    return KN_OK;
}

// Feeds patches to a sink as a job does.
static kn_status feed(kn_ctx *ctx, kn_sink *sink, const kn_patch *patches, size_t n)
{
    kn_patch_block block = {0, n, patches};
    void *product = NULL;
    kn_status status = sink->work(ctx, sink->user, &block, &product);
    return status == KN_OK ? sink->commit(ctx, sink->user, &block, product) : status;
}

static kn_status slice_spline(kn_ctx *ctx, seen *s, const kn_spline *surface, const kn_slice_options *o,
                              bool reversed)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    kn_sink sink = {0};
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, surface);
    if (status == KN_OK) status = kn_slice_sink(ctx, &sink, o, look, s);
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        kn_patch p = {.id = {.patch = (int)i}, .bezier = pieces[i], .reversed = reversed};
        status = feed(ctx, &sink, &p, 1);
    }
    if (status == KN_OK) status = sink.end(ctx, sink.user);
    if (sink.user) kn_sink_close(ctx, &sink);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    return status;
}

// Contours lie within tol of the circle, so that areas differ by no more than its length times that.
static void spheres(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double center[3] = {0, 0, 0.125};
    assert_int_equal(kn_construct_sphere(ctx, &s, center, 2.0), KN_OK);
    for (int k = 0; k < 3; k++) { // tolerances
        double tol = pow(10, -1 - k);
        kn_slice_options o = {.first = -2.0, .step = 0.25, .count = 20, .tol = tol, .join = 1e-300};
        seen got = {0};
        assert_int_equal(slice_spline(ctx, &got, &s, &o, false), KN_OK);
        assert_int_equal(got.count, 20);
        assert_true(got.gap == 0);
        for (int i = 0; i < 20; i++) {
            double z = -2.0 + 0.25 * i - 0.125, rr = 4 - z * z, r = sqrt(fmax(rr, 0));
            assert_true(got.z[i] == -2.0 + 0.25 * i);
            if (rr <= 0) { // the equator of touching: the top pole is not below its own plane
                assert_int_equal(got.nloops[i], 0);
                continue;
            }
            assert_int_equal(got.nloops[i], 1);
            assert_int_equal(got.nopen[i], 0);
            assert_true(got.least[i] >= r - tol && got.most[i] <= r + tol);
            assert_true(fabs(got.area[i] - pi * rr) <= 2 * pi * r * tol + 1e-14);
        }
        seen inside = {0};
        assert_int_equal(slice_spline(ctx, &inside, &s, &o, true), KN_OK);
        for (int i = 0; i < 20; i++) assert_true(fabs(inside.area[i] + got.area[i]) <= 1e-12);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A lying torus: rings between two circles; and a standing one, through whose saddle planes go.
static void tori(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double origin[3] = {0, 0, 0}, up[3] = {0, 0, 1}, across[3] = {1, 0, 0};
    kn_slice_options o = {.first = -0.9, .step = 0.2, .count = 10, .tol = 1e-5, .join = 1e-300};
    seen got = {0};
    assert_int_equal(kn_construct_torus(ctx, &s, origin, up, 3.0, 1.0), KN_OK);
    assert_int_equal(slice_spline(ctx, &got, &s, &o, false), KN_OK);
    for (int i = 0; i < 10; i++) {
        double z = -0.9 + 0.2 * i, h = sqrt(1 - z * z);
        assert_int_equal(got.nloops[i], 2);
        assert_int_equal(got.nopen[i], 0);
        assert_true(fabs(got.area[i] - pi * ((3 + h) * (3 + h) - (3 - h) * (3 - h))) <= 2 * pi * 6 * 1e-5);
    }
    kn_spline_clear(ctx, &s);
    assert_int_equal(kn_construct_torus(ctx, &s, origin, across, 3.0, 1.0), KN_OK);
    o = (kn_slice_options){.first = -4.5, .step = 0.5, .count = 19, .tol = 1e-4, .join = 1e-300};
    got = (seen){0};
    assert_int_equal(slice_spline(ctx, &got, &s, &o, false), KN_OK);
    for (int i = 0; i < 19; i++) {
        double z = fabs(-4.5 + 0.5 * i);
        assert_int_equal(got.nopen[i], 0);
        if (z < 2) assert_int_equal(got.nloops[i], 2);
        if (z > 2 && z < 4) assert_int_equal(got.nloops[i], 1);
        if (z > 4) assert_int_equal(got.nloops[i], 0);
        if (z < 4 && z != 2) assert_true(got.area[i] > 0);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A cylinder without caps, cut along its axis: open contours, straight lines.
static void open_edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double base[3] = {-1, 0, 0}, axis[3] = {2, 0, 0};
    kn_slice_options o = {.first = -0.75, .step = 0.5, .count = 4, .tol = 1e-6};
    seen got = {0};
    assert_int_equal(kn_construct_cylinder(ctx, &s, base, axis, 1.0), KN_OK);
    assert_int_equal(slice_spline(ctx, &got, &s, &o, false), KN_OK);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(got.nloops[i], 2);
        assert_int_equal(got.nopen[i], 2);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A cube as a mesh, planes through its vertices among them.
static void meshes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double corners[24];
    for (int i = 0; i < 8; i++)
        for (int d = 0; d < 3; d++) corners[3 * i + d] = i >> d & 1;
    uint32_t t[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    kn_mesh mesh = {.nvertices = 8, .ntriangles = 12, .position = corners, .triangle = t};
    kn_slice_options o = {.first = -0.25, .step = 0.25, .count = 7, .tol = 1e-3};
    seen got = {0};
    kn_sink sink;
    kn_patch p = {.mesh = &mesh};
    assert_int_equal(kn_slice_sink(ctx, &sink, &o, look, &got), KN_OK);
    assert_int_equal(feed(ctx, &sink, &p, 1), KN_OK);
    assert_int_equal(sink.end(ctx, sink.user), KN_OK);
    kn_sink_close(ctx, &sink);
    assert_true(got.gap == 0);
    for (int i = 0; i < 7; i++) { // z = 0 is not above the bottom, z = 1 cuts just below the top
        bool inside = i >= 2 && i <= 5;
        assert_int_equal(got.nloops[i], inside);
        assert_true(got.area[i] == (inside ? 1.0 : 0.0));
    }
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    seen got = {0};
    kn_slice_options o = {.first = 0.1, .step = 0.5, .count = 2, .tol = 0.1};
    return slice_spline(ctx, &got, user, &o, false);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double origin[3] = {0, 0, 0};
    assert_int_equal(kn_construct_sphere(ctx, &s, origin, 1.0), KN_OK);
    test_allocation_failures(call, &s);
    kn_sink sink = {0};
    const kn_slice_options bad[] = {{0, 0, 1, 1, 0},   {0, 1, 0, 1, 0},        {0, 1, 1, 0, 0},
                                    {NAN, 1, 1, 1, 0}, {0, 1, 1, NAN, 0},      {0, -1, 1, 1, 0},
                                    {0, 1, 1, 1, -1},  {0, 1e308, 1000, 1, 0}, {0, 1, SIZE_MAX, 1, 0}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(kn_slice_sink(ctx, &sink, &bad[i], look, NULL), KN_EDOMAIN);
        assert_null(sink.commit);
    }
    kn_slice_options o = {.first = 0.1, .step = 0.5, .count = 2, .tol = 0.1};
    seen stopped = {.stop = true};
    assert_int_equal(slice_spline(ctx, &stopped, &s, &o, false), KN_ECANCELLED);
    s.coef[3 * kn_spline_count(&s)] = -1.0; // a weight
    kn_ctx_clear_error(ctx);
    seen got = {0};
    assert_int_equal(slice_spline(ctx, &got, &s, &o, false), KN_EUNDEFINED);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres), cmocka_unit_test(tori),     cmocka_unit_test(open_edges),
        cmocka_unit_test(meshes),  cmocka_unit_test(failures),
    };
    return cmocka_run_group_tests_name("slice/sink", tests, NULL, NULL);
}
