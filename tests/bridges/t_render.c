// SPDX-License-Identifier: Apache-2.0
// kn_render: small pictures whose content is known, the same on any number of threads, and what it refuses.
#include "tests/support/support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bridges/embree/render.h"

enum { WIDTH = 64, HEIGHT = 48, BYTES = 3 * WIDTH * HEIGHT };

// A sphere of this radius as a grid of latitudes and longitudes, with its normals.
static void add_sphere(kn_mesh *mesh, const double centre[3], double radius, int n)
{
    const double pi = 3.14159265358979324;
    size_t row = (size_t)n + 1, nv = row * row, nt = 2 * (size_t)n * (size_t)n;
    for (size_t i = 0; i < nv; i++) {
        double a = pi * (double)(i / row) / n, b = 2 * pi * (double)(i % row) / n;
        const double d[3] = {sin(a) * cos(b), sin(a) * sin(b), cos(a)};
        for (size_t c = 0; c < 3; c++) {
            mesh->normal[3 * i + c] = d[c];
            mesh->position[3 * i + c] = centre[c] + radius * d[c];
        }
    }
    for (size_t k = 0; k < nt; k++) {
        size_t at = k / 2 / (size_t)n * row + k / 2 % (size_t)n;
        const size_t corner[2][3] = {{at, at + row, at + row + 1}, {at, at + row + 1, at + 1}};
        for (size_t c = 0; c < 3; c++) mesh->triangle[3 * k + c] = (uint32_t)corner[k % 2][c];
    }
    mesh->nvertices = nv, mesh->ntriangles = nt;
}

typedef struct ball {
    kn_scene_item item;
    kn_scene scene;
    double position[3 * 25 * 25], normal[3 * 25 * 25];
    uint32_t triangle[6 * 24 * 24];
} ball;

static void make_ball(ball *b, double x, double y, double z, double radius, kn_material material)
{
    *b = (ball){0};
    b->item.mesh.position = b->position, b->item.mesh.normal = b->normal, b->item.mesh.triangle = b->triangle;
    add_sphere(&b->item.mesh, (const double[3]){x, y, z}, radius, 24);
    b->item.material = material;
    b->scene = (kn_scene){&b->item, 1};
}

static const kn_material red = {{0.8, 0.05, 0.05}, 0.0, 0.6};
static const kn_material gold = {{1.0, 0.71, 0.29}, 1.0, 0.25};

static kn_render_options small(void)
{
    kn_render_options o = kn_render_defaults();
    o.width = WIDTH, o.height = HEIGHT, o.samples = 4, o.bounces = 3;
    return o;
}

static const uint8_t *pixel(const uint8_t *rgb, int x, int y)
{
    return rgb + 3 * (y * WIDTH + x);
}

static void a_red_ball_stands_in_the_middle(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    ball *b = malloc(sizeof *b);
    uint8_t rgb[BYTES];
    kn_render_options o = small();
    make_ball(b, 1e6, -3e5, 2e6, 1e3, red); // far from the origin, in any unit
    assert_int_equal(kn_render(ctx, rgb, &b->scene, &o), KN_OK);
    const uint8_t *middle = pixel(rgb, WIDTH / 2, HEIGHT / 2);
    assert_true(middle[0] > 60 && middle[0] > 2 * middle[1] && middle[0] > 2 * middle[2]);
    for (int k = 0; k < 4; k++) { // the corners: a grey backdrop that is neither black nor white
        const uint8_t *c = pixel(rgb, k % 2 ? WIDTH - 1 : 0, k / 2 ? HEIGHT - 1 : 0);
        assert_true(c[0] > 40 && c[0] < 220 && abs(c[0] - c[1]) < 24 && abs(c[1] - c[2]) < 24);
    }
    // Framed: the ball fills the height within the margin of 7 % on either side, and not less than 70 % of it.
    int first = HEIGHT, last = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            if (pixel(rgb, x, y)[0] > 2 * pixel(rgb, x, y)[1]) first = y < first ? y : first, last = y;
    assert_true(first >= 2 && last <= HEIGHT - 3 && last - first > HEIGHT * 7 / 10);
    free(b);
    test_ctx_end(ctx, &memory);
}

// The light comes from the upper left, and the ground beside the ball is darker at the right than at the left.
static void light_and_shadow_fall_where_they_should(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    ball *b = malloc(sizeof *b);
    uint8_t rgb[BYTES];
    kn_render_options o = small();
    o.samples = 16;
    make_ball(b, 0, 0, 0, 1, (kn_material){{0.5, 0.5, 0.5}, 0.0, 0.8});
    assert_int_equal(kn_render(ctx, rgb, &b->scene, &o), KN_OK);
    int upper_left = 0, lower_right = 0, left = 0, right = 0;
    for (int i = -2; i <= 2; i++)
        for (int j = -2; j <= 2; j++) {
            upper_left += pixel(rgb, 25 + i, 14 + j)[1], lower_right += pixel(rgb, 39 + i, 35 + j)[1];
            left += pixel(rgb, 17 + i, 43 + j)[1], right += pixel(rgb, 47 + i, 43 + j)[1];
        }
    assert_true(upper_left > lower_right + 25 * 30);
    assert_true(left > right + 25 * 10);
    free(b);
    test_ctx_end(ctx, &memory);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    ball *b = malloc(sizeof *b);
    uint8_t one[BYTES], many[BYTES];
    kn_render_options o = small();
    make_ball(b, 0, 0, 0, 1, gold);
    for (int threads = 1; threads <= 3; threads++) {
        kn_ctx *ctx = test_ctx(&memory, threads);
        assert_int_equal(kn_render(ctx, threads == 1 ? one : many, &b->scene, &o), KN_OK);
        if (threads > 1) assert_memory_equal(one, many, BYTES);
        test_ctx_end(ctx, &memory);
    }
    kn_ctx *ctx = test_ctx(&memory, 1);
    o.seed = 1;
    assert_int_equal(kn_render(ctx, many, &b->scene, &o), KN_OK);
    assert_memory_not_equal(one, many, BYTES);
    test_ctx_end(ctx, &memory);
    free(b);
}

// A z-up scene and the same one turned y-up are one picture, but for the rounding of coordinates: a power of two
// apart nothing rounds differently.
static void both_axes_show_the_same(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    ball *b = malloc(sizeof *b);
    uint8_t z_up[BYTES], y_up[BYTES];
    kn_render_options o = small();
    make_ball(b, 0, 0, 0, 1, red);
    for (size_t i = 0; i < b->item.mesh.nvertices; i++) b->position[3 * i] *= 0.5; // an ellipsoid
    assert_int_equal(kn_render(ctx, z_up, &b->scene, &o), KN_OK);
    for (size_t i = 0; i < b->item.mesh.nvertices; i++) {
        double *p = b->position + 3 * i, *n = b->normal + 3 * i, py = p[1], ny = n[1];
        p[0] *= 4, p[1] = 4 * p[2], p[2] = -4 * py;
        n[1] = n[2], n[2] = -ny;
    }
    o.up = KN_UP_Y;
    assert_int_equal(kn_render(ctx, y_up, &b->scene, &o), KN_OK);
    assert_memory_equal(z_up, y_up, BYTES);
    free(b);
    test_ctx_end(ctx, &memory);
}

static void flat_triangles_are_drawn(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    ball *b = malloc(sizeof *b);
    uint8_t rgb[BYTES];
    kn_render_options o = small();
    for (int bad = 0; bad < 2; bad++) { // without normals; with normals that are none
        make_ball(b, 0, 0, 0, 1, red);
        for (size_t i = 0; i < 3 * b->item.mesh.nvertices; i++) b->normal[i] = i % 7 ? 0.0 : NAN;
        if (!bad) b->item.mesh.normal = NULL;
        assert_int_equal(kn_render(ctx, rgb, &b->scene, &o), KN_OK);
        const uint8_t *middle = pixel(rgb, WIDTH / 2, HEIGHT / 2);
        assert_true(middle[0] > 60 && middle[0] > 2 * middle[1]);
    }
    free(b);
    test_ctx_end(ctx, &memory);
}

static void bad_scenes_and_options_are_refused(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    ball *b = malloc(sizeof *b);
    uint8_t rgb[BYTES];
    kn_render_options o = small();
    kn_scene nothing = {0};
    assert_int_equal(kn_render(ctx, rgb, &nothing, &o), KN_EDOMAIN);
    make_ball(b, 0, 0, 0, 1, red);
    b->item.mesh.ntriangles = 0;
    assert_int_equal(kn_render(ctx, rgb, &b->scene, &o), KN_EDOMAIN);
    const double wild[2] = {NAN, INFINITY};
    for (int i = 0; i < 2; i++) {
        make_ball(b, 0, 0, 0, 1, red);
        b->position[100] = wild[i];
        assert_int_equal(kn_render(ctx, rgb, &b->scene, &o), KN_EDOMAIN);
    }
    make_ball(b, 3, 4, 5, 0, red); // a point
    assert_int_equal(kn_render(ctx, rgb, &b->scene, &o), KN_EDOMAIN);
    make_ball(b, 0, 0, 0, 1, red);
    b->triangle[50] = 25 * 25;
    assert_int_equal(kn_render(ctx, rgb, &b->scene, &o), KN_EDOMAIN);
    make_ball(b, 0, 0, 0, 1, red);
    struct {
        kn_render_options o;
        kn_status status;
    } bad[] = {{small(), KN_EDOMAIN}, {small(), KN_EDOMAIN}, {small(), KN_EDOMAIN}, {small(), KN_EDOMAIN},
               {small(), KN_EDOMAIN}, {small(), KN_ELIMIT},  {small(), KN_ELIMIT},  {small(), KN_ELIMIT}};
    bad[0].o.width = -1, bad[1].o.elevation = 90, bad[2].o.fov = 120, bad[3].o.azimuth = NAN;
    bad[4].o.up = 2;
    bad[5].o.height = KN_RENDER_MAX_SIDE + 1, bad[6].o.samples = KN_RENDER_MAX_SAMPLES + 1;
    bad[7].o.bounces = KN_RENDER_MAX_BOUNCES + 1;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(kn_render(ctx, rgb, &b->scene, &bad[i].o), bad[i].status);
    free(b);
    test_ctx_end(ctx, &memory);
}

static int cancel_half_way(void *user, const char *stage, double fraction)
{
    *(double *)user = fraction;
    assert_string_equal(stage, "render");
    return fraction >= 0.5;
}

static void a_picture_can_be_cancelled(void **state)
{
    (void)state;
    double reached = -1.0;
    kn_ctx *ctx;
    kn_ctx_options options = kn_ctx_defaults();
    // one thread: of several, the caller's hears of progress only after each piece of its own
    options.progress = cancel_half_way, options.user = &reached, options.threads = 1;
    assert_int_equal(kn_ctx_create(&ctx, &options), KN_OK);
    ball *b = malloc(sizeof *b);
    uint8_t rgb[BYTES];
    kn_render_options o = small();
    make_ball(b, 0, 0, 0, 1, gold);
    assert_int_equal(kn_render(ctx, rgb, &b->scene, &o), KN_ECANCELLED);
    assert_true(reached >= 0.5 && reached < 1.0);
    kn_counters left = kn_ctx_counters(ctx);
    assert_int_equal(left.live_blocks, 0);
    free(b);
    kn_ctx_destroy(ctx);
}

static kn_status draw_tiny(kn_ctx *ctx, void *user)
{
    ball *b = user;
    uint8_t rgb[3 * 4 * 4];
    kn_render_options o = {.width = 4, .height = 4, .samples = 1, .bounces = 1};
    return kn_render(ctx, rgb, &b->scene, &o);
}

static void running_out_of_memory_leaves_nothing(void **state)
{
    (void)state;
    ball *b = malloc(sizeof *b);
    make_ball(b, 0, 0, 0, 1, red);
    test_allocation_failures(draw_tiny, b);
    free(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_red_ball_stands_in_the_middle), cmocka_unit_test(light_and_shadow_fall_where_they_should),
        cmocka_unit_test(threads_change_nothing),          cmocka_unit_test(both_axes_show_the_same),
        cmocka_unit_test(flat_triangles_are_drawn),        cmocka_unit_test(bad_scenes_and_options_are_refused),
        cmocka_unit_test(a_picture_can_be_cancelled),      cmocka_unit_test(running_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests_name("bridges/render", tests, NULL, NULL);
}
