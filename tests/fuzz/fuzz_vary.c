// SPDX-License-Identifier: Apache-2.0
// Fuzzes what varies: fields, tiles that turn into others, meshes laid flat, jobs with fields and their
// sensitivities.
#include "tests/fuzz/feed.h"

#include <knurl/knurl.h>
#include <string.h>

static void no_message_without_failure(feed *f, kn_status status)
{
    if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort();
    kn_ctx_clear_error(f->ctx);
}

static void fields(feed *f)
{
    kn_field field = {0};
    kn_place place = {.uv = {feed_number(f), feed_number(f)},
                      .point = {feed_number(f), feed_number(f), feed_number(f)}};
    kn_spline s;
    feed_spline(f, &s, 2);
    no_message_without_failure(f, kn_field_spline(f->ctx, &field, &s));
    if (field.value) (void)field.value(field.user, &place);
    kn_spline_clear(f->ctx, &s);
    kn_field_samples samples = {
        {feed_wild(f, 0, 4) % 100, feed_wild(f, 0, 4) % 100}, {false, feed_byte(f) % 2}, NULL};
    size_t n = samples.n[0] > 0 && samples.n[1] > 0 ? (size_t)samples.n[0] * (size_t)samples.n[1] : 0;
    samples.values = feed_numbers(f, n);
    field = (kn_field){0};
    no_message_without_failure(f, kn_field_grid(f->ctx, &field, &samples));
    if (field.value) (void)field.value(field.user, &place);
    const kn_field_octaves o = {feed_number(f), feed_wild(f, 0, 4), (uint64_t)feed_byte(f), 0.0, feed_number(f)};
    field = (kn_field){0};
    no_message_without_failure(f, kn_field_noise(f->ctx, &field, &o));
    if (field.value) (void)field.value(field.user, &place);
    double noise = kn_noise(place.point, (uint64_t)feed_byte(f));
    if (!(noise >= -1.0 && noise <= 1.0)) abort();
}

// A height field over a square, some triangles left out or turned over.
static void make_mesh(feed *f, kn_mesh *out)
{
    kn_bezier b;
    feed_bezier(f, &b, 2);
    int segments[2] = {feed_count(f, 1, 4), feed_count(f, 1, 4)};
    if (kn_mesh_add_patch(f->ctx, out, &b, segments, false) == KN_OK && out->ntriangles > 0 && feed_byte(f) % 4 == 0)
        out->triangle[(size_t)feed_byte(f) % (3 * out->ntriangles)] = (uint32_t)feed_byte(f);
    kn_bezier_clear(f->ctx, &b);
    kn_ctx_clear_error(f->ctx);
}

// A bipyramid over a few corners anywhere, some triangles turned over: closed, until then.
static void make_closed(feed *f, kn_mesh *out)
{
    enum { MOST = 9 };
    double position[3 * (MOST + 2)];
    uint32_t triangle[6 * MOST], n = 3 + (uint32_t)feed_byte(f) % (MOST - 2);
    for (uint32_t i = 0; i < 3 * (n + 2); i++) position[i] = feed_number(f);
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t two[6] = {n, i, (i + 1) % n, n + 1, (i + 1) % n, i};
        memcpy(triangle + 6 * i, two, sizeof two);
    }
    if (feed_byte(f) % 8 == 0) triangle[(uint32_t)feed_byte(f) % (6 * n)] = (uint32_t)feed_byte(f) % (n + 2);
    const kn_mesh m = {.nvertices = n + 2, .ntriangles = 2 * (size_t)n, .position = position, .triangle = triangle};
    feed_any(kn_mesh_copy(f->ctx, out, &m));
    kn_ctx_clear_error(f->ctx);
}

static void closed_meshes(feed *f)
{
    kn_mesh a = {0}, b = {0}, both = {0};
    double *target = NULL;
    make_closed(f, &a), make_closed(f, &b);
    double *xyz = feed_room(f, 3 * a.nvertices);
    no_message_without_failure(f, kn_mesh_to_sphere(f->ctx, xyz, &a));
    no_message_without_failure(f, kn_mesh_morph(f->ctx, &both, &target, &a, &b));
    for (size_t k = 0; k < 3 * both.ntriangles; k++)
        if (both.triangle[k] >= both.nvertices) abort();
    kn_free(f->ctx, target);
    kn_mesh_clear(f->ctx, &a), kn_mesh_clear(f->ctx, &b), kn_mesh_clear(f->ctx, &both);
}

static void meshes(feed *f)
{
    kn_mesh a = {0}, b = {0}, both = {0};
    kn_mesh_topology t;
    double *target = NULL;
    make_mesh(f, &a), make_mesh(f, &b);
    no_message_without_failure(f, kn_mesh_survey(f->ctx, &t, &a));
    double *xy = feed_room(f, 2 * a.nvertices);
    no_message_without_failure(f, kn_mesh_flatten(f->ctx, xy, &a, (uint32_t)feed_byte(f)));
    no_message_without_failure(f, kn_mesh_morph(f->ctx, &both, &target, &a, &b));
    for (size_t k = 0; k < 3 * both.ntriangles; k++)
        if (both.triangle[k] >= both.nvertices) abort();
    kn_free(f->ctx, target);
    kn_mesh_clear(f->ctx, &a), kn_mesh_clear(f->ctx, &b), kn_mesh_clear(f->ctx, &both);
}

static void make_tile(feed *f, kn_tile *out)
{
    kn_spline s;
    feed_spline(f, &s, 2);
    if (kn_spline_dim(&s) == 3 && !s.rational)
        for (size_t i = 0; i < 3 * kn_spline_count(&s); i++) s.coef[i] = 0.5 + s.coef[i] / 64.0;
    if (kn_tile_init(f->ctx, out, "fuzz", 1) == KN_OK) feed_any(kn_tile_add(f->ctx, out, 0, &s));
    kn_spline_clear(f->ctx, &s);
}

static double by_place(const void *user, const kn_place *p)
{
    (void)user;
    return p->uv[0] + p->point[2] + p->normal[0] + p->curvature[1];
}

static void jobs(feed *f, const kn_tile *tile)
{
    static const double knots[] = {0, 0, 0, 1, 1, 1};
    const double *both[2] = {knots, knots};
    const int degree[2] = {2, 2}, count[2] = {3, 3}, index[2] = {feed_wild(f, 0, 2) % 9, 1};
    kn_spline base = {0};
    double coef[27];
    for (int i = 0; i < 27; i++) coef[i] = (i < 9 ? i / 3 : i < 18 ? i % 3 : 0) + feed_number(f) / 64.0;
    const kn_job_vary vary[2] = {{feed_byte(f) % 4 ? "morph" : "offset", {by_place, NULL, 7}},
                                 {"height", {by_place, NULL, (unsigned)feed_byte(f) % 8}}};
    const double palette[2][3] = {{0, feed_byte(f) / 200.0, 1}, {1, 0, 0}};
    const kn_job_color color = {
        feed_byte(f) % 4 ? NULL : "fuzz", {by_place, NULL, 7}, palette, 2, feed_wild(f, 0, 9)};
    kn_job_options o = {.count = {1, 2}, .height = 0.1, .normal_tol = 0.1, .vary = vary, .nvary = feed_byte(f) % 3};
    o.taper = feed_byte(f) % 2 ? 0.0 : feed_number(f);
    o.color = &color, o.ncolor = feed_byte(f) % 2;
    kn_job *job = NULL;
    if (kn_spline_init(f->ctx, &base, 2, 3, false, degree, count, both, coef) == KN_OK &&
        kn_job_create(f->ctx, &job, &base, 1, tile, &o) == KN_OK) {
        const kn_patch_id id = {.cell = {0, feed_byte(f) % 2}, .patch = feed_byte(f) % 2};
        kn_bezier d = {0};
        kn_sink sink = {0};
        if (kn_job_look_tile(job)->nparts < 1) abort();
        if (kn_null_sink(f->ctx, &sink) == KN_OK) feed_any(kn_job_run(f->ctx, job, &sink, 1));
        kn_sink_close(f->ctx, &sink);
        feed_any(kn_job_parameter_sensitivity(f->ctx, &d, job, &id, feed_byte(f) % 2));
        feed_any(kn_job_base_sensitivity(f->ctx, &d, job, &id, 0, index));
        kn_bezier_clear(f->ctx, &d);
    }
    kn_job_destroy(f->ctx, job);
    kn_spline_clear(f->ctx, &base);
    kn_ctx_clear_error(f->ctx);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    int what = feed_byte(&f) % 4;
    if (what == 0) fields(&f);
    if (what == 1) meshes(&f);
    if (what == 3) closed_meshes(&f);
    if (what == 2) {
        kn_tile a = {0}, b = {0}, m = {0};
        make_tile(&f, &a), make_tile(&f, &b);
        kn_ctx_clear_error(f.ctx);
        no_message_without_failure(&f, kn_tile_morph(f.ctx, &m, &a, feed_byte(&f) % 2 ? &a : &b));
        if (m.nparts > 0) jobs(&f, &m);
        kn_tile_clear(f.ctx, &a), kn_tile_clear(f.ctx, &b), kn_tile_clear(f.ctx, &m);
    }
    feed_end(&f);
    return 0;
}
