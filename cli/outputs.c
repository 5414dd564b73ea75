// SPDX-License-Identifier: Apache-2.0
// Writers by the ending of a path.
#include "cli/cli.h"
#include "kernel/context.h"

#include <stdio.h>
#include <string.h>

#if KN_WITH_ZLIB
#include "bridges/zlib/gzip.h"
#endif
#if KN_WITH_TINYGLTF
#include "bridges/tinygltf/gltf.h"
#endif

// What a file takes for each control point, each control point of a volume's outside included, patch and triangle, and
// itself: measured on the built-in tiles; good to a quarter.
typedef struct writer {
    const char *ending;
    kn_status (*open)(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o);
    kn_status (*plain)(kn_ctx *ctx, kn_sink *out, const char *path); // in its place where there are no options
    double per_point, per_patch, per_triangle, per_file;
    bool cad; // wants faces that are C1 inside
} writer;

static double uncertainty(const cli_output_options *o)
{
    const double usual = 1e-3;
    return o->gap_mm > usual ? o->gap_mm : usual;
}

// What surfaces are called in a file for CAD systems, in scratch.
typedef struct surface_names {
    const char **list;
    int n;
    bool plain;
} surface_names;

// Those of a CAD base: the names of its faces, or their numbers in its file.
static kn_status name_surfaces(kn_ctx *ctx, surface_names *out, const cli_base *base)
{
    const size_t room = KN_NAME_BYTES;
    if (!base || base->cad.nfaces == 0 || !base->face) return KN_OK;
    size_t n = (size_t)base->nsurfaces;
    const char **names = kn_scratch(ctx, n, sizeof *names);
    char *texts = kn_scratch(ctx, n, room);
    if (!names || !texts) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) {
        const char *name = base->cad.faces[base->face[i]].name;
        char *text = texts + i * room;
        names[i] = name[0] ? name : text;
        snprintf(text, room, "face %d", base->face[i]);
    }
    *out = (surface_names){names, base->nsurfaces, false};
    return KN_OK;
}

// The faces of a CAD file itself.
static kn_status name_faces(kn_ctx *ctx, surface_names *out, const kn_cad *cad)
{
    const char **names = kn_scratch(ctx, (size_t)cad->nfaces, sizeof *names);
    if (!names) return KN_ENOMEM;
    for (int i = 0; i < cad->nfaces; i++) names[i] = cad->faces[i].name;
    *out = (surface_names){names, cad->nfaces, true};
    return KN_OK;
}

static kn_status find_names(kn_ctx *ctx, surface_names *out, const cli_output_options *o)
{
    *out = (surface_names){0};
    return o->cad ? name_faces(ctx, out, o->cad) : name_surfaces(ctx, out, o->base);
}

static kn_status open_step_file(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o,
                                const kn_filter *filter)
{
    kn_step_options options = {.unit_mm = o->unit_mm, .host = o->host, .uncertainty_mm = uncertainty(o)};
    options.schema = o->schema;
    options.filter = filter;
    options.instances = o->instances;
    surface_names names;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = find_names(ctx, &names, o);
    options.surface_names = names.list, options.nsurfaces = names.n, options.plain_names = names.plain;
    if (status == KN_OK) status = kn_step_sink(ctx, out, path, &options);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status open_step(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o)
{
    return open_step_file(ctx, out, path, o, NULL);
}

#if KN_WITH_ZLIB
static kn_status open_stpz(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o)
{
    kn_filter filter = kn_gzip_filter(0);
    return open_step_file(ctx, out, path, o, &filter);
}
#endif

static kn_status open_iges(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o)
{
    kn_iges_options options = {.unit_mm = o->unit_mm, .uncertainty_mm = uncertainty(o)};
    surface_names names;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = find_names(ctx, &names, o);
    options.surface_names = names.list, options.nsurfaces = names.n, options.plain_names = names.plain;
    if (status == KN_OK) status = kn_iges_sink(ctx, out, path, &options);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status open_obj(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o)
{
    return o->obj_surfaces ? kn_obj_surfaces_sink(ctx, out, path) : kn_obj_sink(ctx, out, path);
}

static kn_status open_rhino(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o)
{
    return cli_rhino_sink(ctx, out, path, o->unit_mm);
}

#if KN_WITH_TINYGLTF
static kn_status open_gltf(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o)
{
    return kn_gltf_sink(ctx, out, path, &(kn_gltf_options){.unit_mm = o->unit_mm});
}
#endif

static const writer writers[] = {
    {"step", open_step, NULL, 100, 1500, 0, 4000, true},  {"stp", open_step, NULL, 100, 1500, 0, 4000, true},
    {"igs", open_iges, NULL, 100, 2500, 0, 500, true},    {"iges", open_iges, NULL, 100, 2500, 0, 500, true},
    {"g2", NULL, kn_g2_sink, 58, 90, 0, 0, false},        {"itd", NULL, kn_itd_sink, 62, 70, 0, 20, false},
    {"vtu", NULL, kn_vtu_sink, 53.4, 90, 0, 1500, false}, {"mesh", NULL, kn_mfem_sink, 60, 200, 0, 300, false},
    {"pov", NULL, kn_pov_sink, 0, 100, 61, 1500, false},  {"stl", NULL, kn_stl_sink, 0, 0, 50, 84, false},
    {"obj", open_obj, NULL, 0, 0, 75, 500, false},        {"3dm", open_rhino, NULL, 34, 700, 0, 6000, true},
#if KN_WITH_ZLIB
    {"stpz", open_stpz, NULL, 41, 160, 0, 1800, true},
#endif
#if KN_WITH_TINYGLTF
    {"glb", open_gltf, NULL, 0, 0, 26, 2000, false},      {"gltf", open_gltf, NULL, 0, 0, 35, 3000, false},
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

bool cli_writes_cad(const char *path)
{
    return find(path)->cad;
}

bool cli_holds_trims(const char *path)
{
    if (cli_has_ending(path, "3dm")) return false;
    return cli_writes_cad(path) || cli_has_ending(path, "g2") || cli_has_ending(path, "itd");
}

const char *cli_writable_endings(void)
{
    return ".step .stp .igs .iges .g2 .itd .3dm .vtu .mesh .pov .stl .obj"
#if KN_WITH_ZLIB
           " .stpz"
#else
           " (built without zlib: no .stpz)"
#endif
#if KN_WITH_TINYGLTF
           " .glb .gltf";
#else
           " (built without tinygltf: no .glb)";
#endif
}

kn_status cli_open_sink(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *o)
{
    const writer *w = find(path);
    return w->plain ? w->plain(ctx, out, path) : w->open(ctx, out, path, o);
}

double cli_estimate_bytes(const char *path, const kn_job_report *r)
{
    const writer *w = find(path);
    return w->per_file + w->per_point * (double)r->control_points + w->per_patch * (double)r->patches +
           w->per_triangle * (double)r->triangles;
}
