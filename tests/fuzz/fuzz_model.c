// SPDX-License-Identifier: Apache-2.0
// Fuzzes what a tile can hold, what becomes of it over a flat base, and meshes through maps.
#include "tests/fuzz/feed.h"

#include <knurl/io.h>
#include <knurl/job.h>

// Eighths within the cell and a little beyond.
static double coordinate(feed *f)
{
    int b = feed_byte(f);
    return b >= 250 ? feed_number(f) : (b % 11) / 8.0 - 0.125;
}

static void make_spline(feed *f, kn_spline *out, int nvars)
{
    kn_bezier b = {0};
    int degree[3];
    for (int d = 0; d < nvars; d++) degree[d] = feed_int(f, 1, nvars == 3 ? 1 : 2);
    if (kn_bezier_init(f->ctx, &b, nvars, 3, false, degree) != KN_OK) abort();
    for (size_t i = 0; i < 3 * kn_bezier_count(&b); i++) b.coef[i] = coordinate(f);
    if (kn_spline_of_bezier(f->ctx, out, &b) != KN_OK) abort();
    kn_bezier_clear(f->ctx, &b);
}

static void fill_part(feed *f, kn_tile *tile, int part)
{
    kn_spline s = {0}, target = {0};
    kn_trim all = {0};
    make_spline(f, &s, feed_int(f, 1, 3));
    if (feed_byte(f) % 4 == 0)
        feed_any(kn_tile_add_trimmed(f->ctx, tile, part, &s, &all));
    else
        feed_any(kn_tile_add(f->ctx, tile, part, &s));
    if (feed_byte(f) % 4 == 0) feed_any(kn_tile_add_parameter(f->ctx, tile, "x", 0, feed_finite(f), -1, 1));
    if (kn_spline_copy(f->ctx, &target, &s) != KN_OK) abort();
    target.coef[0] = feed_number(f);
    feed_any(kn_tile_set_target(f->ctx, tile, feed_int(f, -1, 1), part, feed_int(f, -1, 2), &target));
    if (feed_byte(f) % 4 == 0) {
        double position[12];
        uint32_t triangle[6];
        for (int i = 0; i < 12; i++) position[i] = coordinate(f);
        for (int i = 0; i < 6; i++) triangle[i] = (uint32_t)feed_int(f, 0, feed_byte(f) == 7 ? 4 : 3);
        const kn_mesh mesh = {.nvertices = 4, .ntriangles = 2, .position = position, .triangle = triangle};
        feed_any(kn_tile_set_mesh(f->ctx, tile, part, &mesh));
        for (int i = 0; i < 12; i++) position[i] = coordinate(f);
        feed_any(kn_tile_set_mesh_target(f->ctx, tile, feed_int(f, -1, 1), part, position));
    }
    kn_spline_clear(f->ctx, &s), kn_spline_clear(f->ctx, &target);
}

// What every patch looks like.
static kn_status look(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)product;
    kn_mesh mesh = {0};
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < block->count; i++) {
        const kn_patch *p = &block->patches[i];
        size_t n = kn_patch_line_points(p);
        double *points = malloc((3 * n + 1) * sizeof *points);
        if (!points) abort();
        if (n > 0) status = kn_patch_line(ctx, points, p);
        free(points);
        if (status == KN_OK) status = kn_patch_tessellate(ctx, &mesh, p);
        const kn_spline view = kn_patch_spline(p);
        if (view.nvars != kn_patch_nvars(p) || (view.nvars > 0 && view.ncomp != 3)) abort();
        kn_patch face = {0};
        if (status == KN_OK && p->bezier.nvars == 3) status = kn_patch_face(ctx, &face, p, (int)(i % 6));
        kn_bezier_clear(ctx, &face.bezier);
        ++*(size_t *)user;
    }
    kn_mesh twice = {0};
    if (status == KN_OK) status = kn_mesh_copy(ctx, &twice, &mesh);
    if (status == KN_OK) status = kn_mesh_append(ctx, &twice, &mesh);
    if (status == KN_OK && twice.ntriangles != 2 * mesh.ntriangles) abort();
    kn_mesh_clear(ctx, &mesh), kn_mesh_clear(ctx, &twice);
    return status;
}

static void run(feed *f, const kn_tile *tile)
{
    static double flat[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0.25, 0};
    const kn_bezier b = {.nvars = 2, .ncomp = 3, .degree = {1, 1}, .coef = flat};
    kn_spline base = {0};
    kn_job *job = NULL;
    kn_job_options o = kn_job_defaults();
    o.count[0] = 2, o.count[1] = 1, o.height = feed_byte(f) % 2 ? 0.1 : -0.1, o.mesh_tol = 0.5;
    if (kn_spline_of_bezier(f->ctx, &base, &b) != KN_OK) abort();
    kn_ctx_clear_error(f->ctx);
    if (kn_job_create(f->ctx, &job, &base, 1, tile, &o) == KN_OK) {
        const kn_job *const layers[2] = {job, job};
        size_t seen = 0;
        kn_model model = {0};
        kn_sink sinks[2] = {{.user = &seen, .commit = look}};
        if (kn_collect_sink(f->ctx, &sinks[1], &model) != KN_OK) abort();
        kn_status status = kn_job_run_layers(f->ctx, layers, 2, sinks, kn_job_describe(job).meshes > 0 ? 1 : 2);
        if (status == KN_OK && seen != kn_job_describe_layers(layers, 2).patches) abort();
        kn_sink_close(f->ctx, &sinks[1]);
        kn_model_clear(f->ctx, &model);
    }
    if (job) { // its shell, for a mesh
        double position[9];
        uint32_t triangle[3] = {0, 1, 2};
        kn_mesh mesh = {.nvertices = 3, .ntriangles = 1, .position = position, .triangle = triangle}, out = {0};
        kn_mesh_map_options m = kn_mesh_map_defaults();
        m.tolerance = feed_byte(f) / 64.0, m.estimate_normals = feed_byte(f) % 2, m.max_triangles = 1000;
        for (int i = 0; i < 9; i++) position[i] = coordinate(f);
        feed_any(kn_mesh_map(f->ctx, &out, NULL, &mesh, kn_job_shell(job, 0), &m));
        kn_mesh_clear(f->ctx, &out);
    }
    kn_job_destroy(f->ctx, job);
    kn_spline_clear(f->ctx, &base);
}

static kn_status bend(kn_ctx *ctx, void *user, double point[3], double *normal, const double from[3],
                      const double *from_normal)
{
    (void)ctx, (void)user, (void)from_normal;
    for (int c = 0; c < 3; c++) point[c] = from[c] * from[(c + 1) % 3];
    for (int c = 0; normal && c < 3; c++) normal[c] = 0.0;
    return KN_OK;
}

// A mesh cut along any segments: triangles have vertices still.
static void cut(feed *f, const kn_mesh *mesh)
{
    kn_mesh out = {0};
    kn_mesh_segment segments[6];
    int n = feed_int(f, 0, 6);
    for (int i = 0; i < n; i++) // often in a chain
        for (int d = 0; d < 2; d++) {
            segments[i].from[d] = i > 0 && feed_byte(f) % 4 ? segments[i - 1].to[d] : coordinate(f);
            segments[i].to[d] = coordinate(f);
        }
    if (kn_mesh_copy(f->ctx, &out, mesh) != KN_OK) abort();
    feed_any(kn_mesh_cut(f->ctx, &out, segments, (size_t)n, feed_byte(f) % 4 ? 1e-9 : feed_number(f)));
    for (size_t i = 0; i < 3 * out.ntriangles; i++)
        if (out.triangle[i] >= out.nvertices) abort();
    kn_mesh_clear(f->ctx, &out);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    kn_tile tile, copy = {0}, varied = {0};
    if (kn_tile_init(f.ctx, &tile, "tile", 2) != KN_OK) abort();
    for (int k = feed_int(&f, 0, 3); k > 0; k--) fill_part(&f, &tile, feed_byte(&f) % 2);
    double *values = feed_numbers(&f, (size_t)tile.nparameters);
    if (kn_tile_copy(f.ctx, &copy, &tile) != KN_OK) abort();
    if (kn_tile_vary(f.ctx, &varied, &tile, values) == KN_OK) kn_tile_clear(f.ctx, &varied);
    for (int p = 0; p < 2; p++)
        for (int s = 0; s < tile.parts[p].nsplines; s++) {
            kn_bezier *pieces = NULL;
            size_t n = 0;
            kn_tile_cover cover[6];
            if (kn_spline_to_bezier(f.ctx, &pieces, &n, &tile.parts[p].splines[s]) != KN_OK) continue;
            feed_any(kn_tile_cover_faces(f.ctx, cover, pieces, n > 0));
            for (size_t i = 0; i < n; i++) kn_bezier_clear(f.ctx, &pieces[i]);
            kn_free(f.ctx, pieces);
        }
    kn_mesh out = {0};
    const kn_mesh_map_options o = {.tolerance = 0.01, .max_triangles = 500};
    feed_any(kn_mesh_map_by(f.ctx, &out, NULL, &tile.parts[0].mesh, bend, NULL, &o));
    kn_mesh_clear(f.ctx, &out);
    run(&f, &copy);
    cut(&f, &tile.parts[0].mesh);
    kn_tile_clear(f.ctx, &tile), kn_tile_clear(f.ctx, &copy);
    feed_end(&f);
    return 0;
}
