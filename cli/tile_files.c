// SPDX-License-Identifier: Apache-2.0
// Tiles from files: splines, meshes, and descriptions that name such files.
#include "cli/cli.h"
#include "kernel/context.h"

#include <string.h>
#include <unistd.h>

#include "bridges/jansson/tile.h"
#if KN_WITH_OPENMESH
#include "bridges/openmesh/read.h"
#endif
#if KN_WITH_LIB3MF
#include "bridges/lib3mf/read.h"
#endif
#if KN_WITH_TINYGLTF
#include "bridges/tinygltf/gltf.h"
#endif

// ---- meshes by their ending ----

#if !KN_WITH_OPENMESH || !KN_WITH_LIB3MF || !KN_WITH_TINYGLTF
static kn_status not_built(kn_ctx *ctx, const char *path, const char *library)
{
    return kn_fail(ctx, KN_ENOTBUILT, "%s: cannot be read: built without %s", path, library);
}
#endif

static kn_status read_openmesh(kn_ctx *ctx, kn_mesh *out, const char *path)
{
#if KN_WITH_OPENMESH
    return kn_openmesh_read(ctx, out, path);
#else
    (void)out;
    return not_built(ctx, path, "OpenMesh");
#endif
}

static kn_status read_3mf(kn_ctx *ctx, kn_mesh *out, const char *path)
{
#if KN_WITH_LIB3MF
    return kn_3mf_read(ctx, out, path);
#else
    (void)out;
    return not_built(ctx, path, "lib3mf");
#endif
}

#if KN_WITH_TINYGLTF
// glTF's y points upwards: (x, y, z) is (u, w, -v).
static void stand_up(double *xyz, size_t n)
{
    for (size_t i = 0; i < n; i++, xyz += 3) {
        double y = xyz[1];
        xyz[1] = -xyz[2];
        xyz[2] = y;
    }
}

static size_t copy_item(kn_mesh *mesh, const kn_mesh *item, size_t at[2], bool normals)
{
    memcpy(mesh->position + 3 * at[0], item->position, 3 * item->nvertices * sizeof(double));
    if (normals) memcpy(mesh->normal + 3 * at[0], item->normal, 3 * item->nvertices * sizeof(double));
    for (size_t i = 0; i < item->ntriangles; i++) {
        const uint32_t *t = item->triangle + 3 * i;
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        for (int k = 0; k < 3; k++) mesh->triangle[3 * at[1] + (size_t)k] = (uint32_t)at[0] + t[k];
        at[1]++;
    }
    return at[0] += item->nvertices;
}

// All primitives as one mesh; normals if all have some.
static kn_status join_scene(kn_ctx *ctx, kn_mesh *out, const kn_scene *scene, const char *path)
{
    size_t nv = 0, nt = 0, at[2] = {0, 0};
    bool normals = true;
    for (int i = 0; i < scene->nitems; i++) {
        nv += scene->items[i].mesh.nvertices;
        nt += scene->items[i].mesh.ntriangles;
        normals = normals && scene->items[i].mesh.normal;
    }
    if (nt == 0 || nv > UINT32_MAX) return kn_fail(ctx, KN_EPARSE, "%s: %zu triangles, %zu vertices", path, nt, nv);
    kn_mesh mesh = {.nvertices = nv, .vertex_room = nv, .triangle_room = nt};
    mesh.position = kn_alloc(ctx, nv, 3 * sizeof(double));
    mesh.normal = normals ? kn_alloc(ctx, nv, 3 * sizeof(double)) : NULL;
    mesh.triangle = kn_alloc(ctx, nt, 3 * sizeof(uint32_t));
    if (!mesh.position || !mesh.triangle || (normals && !mesh.normal)) {
        kn_mesh_clear(ctx, &mesh);
        return KN_ENOMEM;
    }
    for (int i = 0; i < scene->nitems; i++) copy_item(&mesh, &scene->items[i].mesh, at, normals);
    mesh.ntriangles = at[1];
    stand_up(mesh.position, nv);
    if (normals) stand_up(mesh.normal, nv);
    *out = mesh;
    return KN_OK;
}

static kn_status read_gltf(kn_ctx *ctx, kn_mesh *out, const char *path)
{
    kn_scene scene = {0};
    kn_status status = kn_gltf_read(ctx, &scene, path);
    if (status == KN_OK) status = join_scene(ctx, out, &scene, path);
    kn_scene_clear(ctx, &scene);
    return status;
}
#else
static kn_status read_gltf(kn_ctx *ctx, kn_mesh *out, const char *path)
{
    (void)out;
    return not_built(ctx, path, "tinygltf");
}
#endif

static const struct {
    const char *ending;
    kn_status (*read)(kn_ctx *ctx, kn_mesh *out, const char *path);
} mesh_readers[] = {{"obj", read_openmesh}, {"stl", read_openmesh}, {"ply", read_openmesh}, {"off", read_openmesh},
                    {"glb", read_gltf},     {"gltf", read_gltf},    {"3mf", read_3mf}};
enum { MESH_READERS = sizeof mesh_readers / sizeof *mesh_readers };

static int find_mesh_reader(const char *path)
{
    int i = 0;
    while (i < MESH_READERS && !cli_has_ending(path, mesh_readers[i].ending)) i++;
    return i;
}

bool cli_is_mesh(const char *path)
{
    return find_mesh_reader(path) < MESH_READERS;
}

kn_status cli_read_mesh(kn_ctx *ctx, kn_mesh *out, const char *path)
{
    return mesh_readers[find_mesh_reader(path)].read(ctx, out, path);
}

// ---- tiles ----

static kn_status refuse_weights(kn_ctx *ctx, const kn_cad *cad, const char *path)
{
    for (int i = 0; i < cad->nfaces; i++)
        if (cad->faces[i].surface.rational)
            return kn_fail(ctx, KN_EDOMAIN,
                           "%s: face %d (%s) has weights; the faces of a tile are planes and splines without them",
                           path, i, kn_cad_type_name(cad->faces[i].type));
    return KN_OK;
}

// All faces, trimmed as they are; a trim that is the whole square is none.
static kn_status read_cad_part(kn_ctx *ctx, kn_tile_part *part, const char *path)
{
    kn_cad cad = {0};
    kn_status status = cli_read_cad(ctx, &cad, path);
    if (status == KN_OK) status = refuse_weights(ctx, &cad, path);
    size_t n = (size_t)cad.nfaces;
    if (status == KN_OK) {
        part->splines = kn_alloc_zero(ctx, n, sizeof *part->splines);
        part->trims = kn_alloc_zero(ctx, n, sizeof *part->trims);
        if (!part->splines || !part->trims) status = KN_ENOMEM;
    }
    for (int i = 0; status == KN_OK && i < cad.nfaces; i++) {
        kn_cad_face *face = &cad.faces[i];
        kn_spline_swap(&part->splines[i], &face->surface);
        if (!face->whole) part->trims[i] = face->trim;
        if (!face->whole) face->trim = (kn_trim){0};
        part->nsplines++;
    }
    kn_cad_clear(ctx, &cad);
    return status;
}

static kn_status read_part(kn_ctx *ctx, void *user, kn_tile_part *part, const char *path)
{
    (void)user;
    if (cli_is_mesh(path)) return cli_read_mesh(ctx, &part->mesh, path);
    if (cli_is_cad(path)) return read_cad_part(ctx, part, path);
    kn_model model = {0};
    kn_status status = kn_read_model(ctx, &model, path);
    part->splines = model.splines;
    part->nsplines = model.nsplines;
    part->mesh = model.mesh;
    return status;
}

void cli_name_of(char name[KN_NAME_BYTES], const char *path)
{
    const char *base = strrchr(path, '/'), *end = strrchr(path, '.');
    base = base ? base + 1 : path;
    snprintf(name, KN_NAME_BYTES, "%.*s", end > base ? (int)(end - base) : (int)strlen(base), base);
}

// A casual tile of one part; w stays as it is, and one unit of it looks as long as one of u and v.
static kn_status mesh_tile(kn_ctx *ctx, kn_tile *out, const char *path, const double *cell)
{
    static const double unit[4] = {0, 0, 1, 1};
    kn_tile tile = {0};
    char name[KN_NAME_BYTES];
    cli_name_of(name, path);
    kn_status status = kn_tile_init(ctx, &tile, name, 1);
    if (status != KN_OK) return status;
    snprintf(tile.about, sizeof tile.about, "from %.100s", path);
    memcpy(tile.parts[0].name, name, sizeof name);
    tile.parts[0].material = (kn_material){{0.6, 0.6, 0.6}, 0.0, 0.4};
    tile.parts[0].plain = true;
    status = read_part(ctx, NULL, &tile.parts[0], path);
    if (status == KN_OK) status = kn_tile_set_cell(ctx, &tile, cell ? cell : unit, 1);
    if (status == KN_OK) status = kn_tile_check(ctx, &tile);
    if (status == KN_OK)
        *out = tile;
    else
        kn_tile_clear(ctx, &tile);
    return status;
}

// What the description proposes and nobody has said otherwise. A count stands for a size, and the other way round.
static bool take_defaults(cli_job *job, const kn_tile_file *file, const char *path)
{
    bool cells = job->options.count[0] > 0 || job->has_size;
    for (int i = 0; i < file->ndefaults; i++) {
        const kn_tile_default *d = &file->defaults[i];
        char name[512];
        int option = cli_job_find_key(d->key, CLI_OF_LAYER, NULL);
        if (option < 0) option = cli_job_find_key(d->key, CLI_OF_RECIPE, NULL);
        if (option < 0 || cli_job_was_given(job, option)) continue;
        if (cells && (strcmp(d->key, "count") == 0 || strcmp(d->key, "size") == 0)) continue;
        snprintf(name, sizeof name, "%.400s: \"defaults.%s\"", path, d->key);
        if (!cli_job_set_key(job, option, name, d->value)) return false;
    }
    return true;
}

static int read_description(cli_session *session, kn_tile *out, const char *path, const double *cell, cli_job *job)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_tile_file file = {0};
    if (cell) {
        cli_error("--tile-cell: %s says itself what its cell is", path);
        return EXIT_USAGE;
    }
    kn_status status = kn_json_tile_read(ctx, &file, path, read_part, NULL);
    if (status != KN_OK) return cli_fail_on(session, status, path, true);
    *out = file.tile;
    return !job || take_defaults(job, &file, path) ? EXIT_OK : EXIT_BAD_INPUT;
}

static int read_file(cli_session *session, kn_tile *out, const char *path, const double *cell, cli_job *job)
{
    kn_ctx *ctx = cli_ctx(session);
    if (cli_has_ending(path, "json")) return read_description(session, out, path, cell, job);
    kn_status status = cli_is_mesh(path) || cli_is_cad(path) ? mesh_tile(ctx, out, path, cell)
                                                             : kn_read_tile(ctx, out, path, cell);
    return status == KN_OK ? EXIT_OK : cli_fail_on(session, status, path, true);
}

static int unknown_tile(const char *name)
{
    enum { MOST = 64 };
    const char *names[MOST];
    int n = 0;
    while (n < MOST && n < kn_builtin_tile_count()) names[n] = kn_builtin_tile_name(n), n++;
    const char *nearest = cli_nearest(name, names, n);
    if (nearest)
        cli_error("no tile '%s'; did you mean '%s'? ('knurl tiles' lists them)", name, nearest);
    else
        cli_error("no tile '%s', and no such file ('knurl tiles' lists the built-in ones)", name);
    return EXIT_USAGE;
}

static int read_tile(cli_session *session, kn_tile *out, const char *name, const double *cell, cli_job *job)
{
    kn_ctx *ctx = cli_ctx(session);
    for (int i = 0; i < kn_builtin_tile_count(); i++)
        if (strcmp(name, kn_builtin_tile_name(i)) == 0) {
            kn_status status = kn_builtin_tile(ctx, out, name);
            return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
        }
    if (!strchr(name, '.') && !strchr(name, '/') && access(name, F_OK) != 0) return unknown_tile(name);
    return read_file(session, out, name, cell, job);
}

int cli_read_tile(cli_session *session, kn_tile *out, const char *name, const double *cell)
{
    return read_tile(session, out, name, cell, NULL);
}

int cli_read_job_tile(cli_session *session, kn_tile *out, cli_job *job)
{
    const double *cell = job->has_cell ? job->cell : NULL;
    if (!job->morph) return read_tile(session, out, job->tile, cell, job);
    kn_tile from = {0}, to = {0};
    int code = read_tile(session, &from, job->tile, cell, job);
    if (code == EXIT_OK) code = read_tile(session, &to, job->morph, cell, NULL);
    if (code == EXIT_OK) {
        kn_status status = kn_tile_morph(cli_ctx(session), out, &from, &to);
        if (status != KN_OK) code = cli_fail(session, status, true);
    }
    kn_tile_clear(cli_ctx(session), &from);
    kn_tile_clear(cli_ctx(session), &to);
    return code;
}
