// SPDX-License-Identifier: Apache-2.0
// Writers by the ending of a path.
#include "cli/cli.h"

#include <string.h>

#if KN_WITH_TINYGLTF
#include "bridges/tinygltf/gltf.h"
#endif

// Bytes per control point of STEP text and per triangle of the others, and per patch and file: measured on the
// built-in tiles; good to a quarter.
typedef struct writer {
    const char *ending;
    kn_status (*open)(kn_ctx *ctx, kn_sink *out, const char *path, double unit_mm);
    double per_point, per_patch, per_triangle, per_file;
} writer;

static kn_status open_step(kn_ctx *ctx, kn_sink *out, const char *path, double unit_mm)
{
    return kn_step_sink(ctx, out, path, &(kn_step_options){.unit_mm = unit_mm});
}

static kn_status open_stl(kn_ctx *ctx, kn_sink *out, const char *path, double unit_mm)
{
    (void)unit_mm; // the format has no unit
    return kn_stl_sink(ctx, out, path);
}

static kn_status open_obj(kn_ctx *ctx, kn_sink *out, const char *path, double unit_mm)
{
    (void)unit_mm;
    return kn_obj_sink(ctx, out, path);
}

#if KN_WITH_TINYGLTF
static kn_status open_gltf(kn_ctx *ctx, kn_sink *out, const char *path, double unit_mm)
{
    return kn_gltf_sink(ctx, out, path, &(kn_gltf_options){.unit_mm = unit_mm});
}
#endif

static const writer writers[] = {
    {"step", open_step, 100, 1500, 0, 4000}, {"stp", open_step, 100, 1500, 0, 4000},
    {"stl", open_stl, 0, 0, 50, 84},         {"obj", open_obj, 0, 0, 75, 500},
#if KN_WITH_TINYGLTF
    {"glb", open_gltf, 0, 0, 26, 2000},      {"gltf", open_gltf, 0, 0, 35, 3000},
#endif
};

static const writer *find(const char *path)
{
    for (size_t i = 0; i < sizeof writers / sizeof *writers; i++)
        if (cli_has_ending(path, writers[i].ending)) return &writers[i];
    return NULL;
}

bool cli_can_write(const char *path)
{
    return find(path) != NULL;
}

const char *cli_writable_endings(void)
{
#if KN_WITH_TINYGLTF
    return ".step .stp .stl .obj .glb .gltf";
#else
    return ".step .stp .stl .obj (built without tinygltf: no .glb)";
#endif
}

kn_status cli_open_sink(kn_ctx *ctx, kn_sink *out, const char *path, double unit_mm)
{
    return find(path)->open(ctx, out, path, unit_mm);
}

double cli_estimate_bytes(const char *path, const kn_job_report *r)
{
    const writer *w = find(path);
    return w->per_file + w->per_point * (double)r->control_points + w->per_patch * (double)r->patches +
           w->per_triangle * (double)r->triangles;
}
