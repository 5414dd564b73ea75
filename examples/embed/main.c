// SPDX-License-Identifier: Apache-2.0
// knurl in a program of your own: bumps on a quarter of a cylinder (a rational surface), written as STEP.
//
//     cc main.c $(pkg-config --cflags --libs knurl) -o embed && ./embed bumps.step
#include <knurl/knurl.h>
#include <stdio.h>

// Radius 20, height 30, the axis along z: an exact quarter circle of degree 2 swept linearly.
static kn_status quarter_cylinder(kn_ctx *ctx, kn_spline *out)
{
    const double w = 0.70710678118654752, r = 20.0, h = 30.0;
    const double u[] = {0, 0, 0, 1, 1, 1}, v[] = {0, 0, 1, 1};
    const double *const knots[] = {u, v};
    const double coef[] = {
        r, r, r * w, r * w, 0, 0, // x times weight: three points along u, two along v for each
        0, 0, r * w, r * w, r, r, // y times weight
        0, h, 0,     h * w, 0, h, // z times weight
        1, 1, w,     w,     1, 1, // weight
    };
    return kn_spline_init(ctx, out, 2, 4, true, (int[]){2, 1}, (int[]){3, 2}, knots, coef);
}

static kn_status texture(kn_ctx *ctx, const char *path)
{
    kn_spline surface = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_sink step = {0};
    kn_job_options options = kn_job_defaults();
    options.count[0] = 6, options.count[1] = 4, options.height = 1.0;

    kn_status status = quarter_cylinder(ctx, &surface);
    if (status == KN_OK) status = kn_builtin_tile(ctx, &tile, "bump");
    if (status == KN_OK) status = kn_job_create(ctx, &job, &surface, 1, &tile, &options);
    if (status == KN_OK) status = kn_step_sink(ctx, &step, path, NULL);
    if (status == KN_OK) status = kn_job_run(ctx, job, &step, 1);
    if (status == KN_OK) {
        kn_job_report report = kn_job_describe(job);
        printf("%zu cells, %zu patches of degree (%d, %d), %zu control points; normal within %.1e\n", report.cells,
               report.patches, report.degree[0], report.degree[1], report.control_points, report.normal.length_error);
    }
    kn_sink_close(ctx, &step); // removes the file again unless all went well
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &surface);
    return status;
}

int main(int argc, char **argv)
{
    kn_ctx *ctx = NULL;
    if (kn_ctx_create(&ctx, NULL) != KN_OK) return 1;
    kn_status status = texture(ctx, argc > 1 ? argv[1] : "bumps.step");
    if (status != KN_OK) fprintf(stderr, "%s: %s\n", kn_status_name(status), kn_ctx_message(ctx));
    kn_ctx_destroy(ctx);
    return status == KN_OK ? 0 : 1;
}
