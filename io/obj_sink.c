// SPDX-License-Identifier: Apache-2.0
// A sink that tessellates patches into a Wavefront OBJ file, with its materials in an .mtl file beside it.
#include <knurl/io.h>

#include "io/obj.h"
#include "io/out_file.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

// Digits of a position: finer than single precision, in which OBJ files are read. Equal points have equal text, so
// that shared edges stay shared.
enum { POSITION_DIGITS = 9, COLOUR_DIGITS = 6 };

// Normals are rounded to multiples of 1 / NORMAL_STEPS: directions need no more, and noise near zero no digits.
#define NORMAL_STEPS 1e6

typedef struct obj {
    kn_out_file *file, *materials;
    char *library;                // the name of the .mtl file, without its folder
    char (*names)[KN_NAME_BYTES]; // of parts, as groups and materials
    int nparts;
    kn_obj_patch *put; // NULL: triangles
} obj;

// Names end at white space in this format.
static void copy_name(char to[KN_NAME_BYTES], const char *from, int index)
{
    size_t n = 0;
    for (; n < KN_NAME_BYTES - 1 && from[n] != '\0'; n++)
        to[n] = (unsigned char)from[n] > ' ' && from[n] != 127 ? from[n] : '_';
    if (n == 0) to[n++] = (char)('a' + index % 26);
    to[n] = '\0';
}

static void put_material(kn_text *text, const char *name, const kn_material *material)
{
    kn_text_put(text, "newmtl ");
    kn_text_put(text, name);
    kn_text_put(text, "\nKd");
    for (int c = 0; c < 3; c++) {
        kn_text_char(text, ' ');
        kn_text_plain_real(text, material->base_color[c], COLOUR_DIGITS);
    }
    kn_text_put(text, "\nPm ");
    kn_text_plain_real(text, material->metallic, COLOUR_DIGITS);
    kn_text_put(text, "\nPr ");
    kn_text_plain_real(text, material->roughness, COLOUR_DIGITS);
    kn_text_newline(text);
}

static kn_status name_parts(kn_ctx *ctx, obj *o, const kn_tile *tile)
{
    o->names = kn_alloc_zero(ctx, (size_t)tile->nparts, sizeof *o->names);
    if (o->names == NULL) return KN_ENOMEM;
    o->nparts = tile->nparts;
    for (int i = 0; i < tile->nparts; i++) copy_name(o->names[i], tile->parts[i].name, i);
    return KN_OK;
}

static kn_status obj_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)report;
    obj *o = user;
    kn_status status = name_parts(ctx, o, tile);
    if (status != KN_OK) return status;
    kn_text text = {.ctx = ctx};
    kn_text_put(&text, "# knurl " KN_VERSION_STRING "\n");
    for (int i = 0; i < tile->nparts; i++) put_material(&text, o->names[i], &tile->parts[i].material);
    status = kn_out_flush(ctx, o->materials, &text);
    kn_text_put(&text, "# knurl " KN_VERSION_STRING "\nmtllib ");
    kn_text_put(&text, o->library);
    kn_text_newline(&text);
    if (status == KN_OK) status = kn_out_flush(ctx, o->file, &text);
    kn_text_clear(&text);
    return status;
}

static void put_vector(kn_text *text, const char *key, double x, double y, double z)
{
    const double v[3] = {x, y, z};
    kn_text_put(text, key);
    for (int c = 0; c < 3; c++) {
        kn_text_char(text, ' ');
        kn_text_plain_real(text, v[c], POSITION_DIGITS);
    }
    kn_text_newline(text);
}

static double round_normal(double x)
{
    return rint(x * NORMAL_STEPS) / NORMAL_STEPS;
}

// Indices count backwards from the last vertex, -1: a block's text does not depend on what comes before it.
static void put_mesh(kn_text *text, const kn_mesh *mesh)
{
    const double *p = mesh->position, *n = mesh->normal;
    for (size_t i = 0; i < mesh->nvertices; i++) put_vector(text, "v", p[3 * i], p[3 * i + 1], p[3 * i + 2]);
    for (size_t i = 0; i < mesh->nvertices; i++)
        put_vector(text, "vn", round_normal(n[3 * i]), round_normal(n[3 * i + 1]), round_normal(n[3 * i + 2]));
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        kn_text_char(text, 'f');
        for (size_t k = 0; k < 3; k++) {
            size_t back = mesh->nvertices - mesh->triangle[3 * t + k];
            kn_text_put(text, " -");
            kn_text_integer(text, back);
            kn_text_put(text, "//-");
            kn_text_integer(text, back);
        }
        kn_text_newline(text);
    }
}

// A curve as a polyline.
static kn_status put_line(kn_ctx *ctx, kn_text *text, const kn_patch *patch)
{
    size_t n = kn_patch_line_points(patch);
    kn_mark mark = kn_scratch_mark(ctx);
    double *p = kn_scratch(ctx, n, 3 * sizeof *p);
    kn_status status = p ? kn_patch_line(ctx, p, patch) : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++) put_vector(text, "v", p[3 * i], p[3 * i + 1], p[3 * i + 2]);
    kn_text_char(text, 'l');
    for (size_t i = 0; i < n; i++) {
        kn_text_put(text, " -");
        kn_text_integer(text, n - i);
    }
    kn_text_newline(text);
    kn_scratch_release(ctx, mark);
    return status;
}

static void put_group(kn_text *text, const char *name)
{
    kn_text_put(text, "g ");
    kn_text_put(text, name);
    kn_text_put(text, "\nusemtl ");
    kn_text_put(text, name);
    kn_text_newline(text);
}

static void obj_discard(kn_ctx *ctx, void *user, void *product)
{
    (void)user;
    kn_text *text = product;
    if (text == NULL) return;
    text->ctx = ctx; // the worker's own context may be gone
    kn_text_clear(text);
    kn_free(ctx, text);
}

static kn_status put_triangles(kn_ctx *worker, kn_text *text, kn_mesh *mesh, const kn_patch *patch)
{
    mesh->nvertices = mesh->ntriangles = 0;
    kn_status status = kn_patch_tessellate(worker, mesh, patch);
    if (status == KN_OK) put_mesh(text, mesh);
    return status == KN_OK && kn_patch_line_points(patch) > 0 ? put_line(worker, text, patch) : status;
}

static kn_status format(kn_ctx *worker, const obj *o, const kn_patch_block *block, kn_text *text)
{
    kn_mesh mesh = {0};
    kn_status status = KN_OK;
    int part = -1;
    for (size_t i = 0; i < block->count && status == KN_OK; i++) {
        const kn_patch *patch = &block->patches[i];
        if (patch->look < 0 || patch->look >= o->nparts)
            status = kn_fail(worker, KN_EDOMAIN, "OBJ: a patch of part %d, of %d", patch->look, o->nparts);
        if (status == KN_OK && patch->look != part) put_group(text, o->names[patch->look]);
        part = patch->look;
        if (status == KN_OK && o->put && !patch->mesh)
            status = o->put(worker, text, patch);
        else if (status == KN_OK)
            status = put_triangles(worker, text, &mesh, patch);
    }
    kn_mesh_clear(worker, &mesh);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}

static kn_status obj_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    kn_text *text = kn_alloc_zero(worker, 1, sizeof *text);
    if (text == NULL) return KN_ENOMEM;
    text->ctx = worker;
    kn_status status = format(worker, user, block, text);
    if (status == KN_OK)
        *product = text;
    else
        obj_discard(worker, user, text);
    return status;
}

static kn_status obj_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)block;
    obj *o = user;
    const kn_text *text = product;
    kn_status status = kn_out_write(ctx, o->file, text->data, text->bytes);
    obj_discard(ctx, user, product);
    return status;
}

static kn_status obj_end(kn_ctx *ctx, void *user)
{
    obj *o = user;
    kn_status status = kn_out_commit(ctx, o->materials); // first: the other file refers to it
    if (status != KN_OK) return status;
    status = kn_out_commit(ctx, o->file);
    if (status != KN_OK) kn_out_forget(o->file); // nobody can go on without the other
    return status;
}

static void obj_close(kn_ctx *ctx, void *user)
{
    obj *o = user;
    kn_out_close(ctx, o->file);
    kn_out_close(ctx, o->materials);
    kn_free(ctx, o->library);
    kn_free(ctx, o->names);
    kn_free(ctx, o);
}

static size_t obj_bytes(const void *user)
{
    const obj *o = user;
    return kn_out_bytes(o->file) + kn_out_bytes(o->materials);
}

static kn_status obj_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    obj *o = user;
    kn_state state = {.ctx = ctx};
    kn_status status = kn_out_save(ctx, o->file, &state);
    if (status == KN_OK) status = kn_out_save(ctx, o->materials, &state);
    return kn_state_give(&state, data, bytes, status);
}

static kn_status obj_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                             const unsigned char *data, size_t bytes)
{
    (void)report;
    obj *o = user;
    kn_state_reader r = {data, bytes};
    kn_status status = name_parts(ctx, o, tile);
    if (status == KN_OK) status = kn_out_restore(ctx, o->file, &r);
    if (status == KN_OK) status = kn_out_restore(ctx, o->materials, &r);
    return status == KN_OK && r.bytes > 0 ? kn_state_fail(ctx, "OBJ") : status;
}

static void obj_forget(void *user)
{
    obj *o = user;
    kn_out_forget(o->file), kn_out_forget(o->materials);
}

// path with its ending replaced by .mtl (added, when it has none) in *whole, and the place of its last part.
static kn_status library_name(kn_ctx *ctx, char **whole, size_t *last, const char *path)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    const char *name = slash != NULL ? slash + 1 : path;
    size_t length = dot != NULL && dot > name ? (size_t)(dot - path) : strlen(path);
    *whole = kn_alloc(ctx, length + 5, 1);
    if (*whole == NULL) return KN_ENOMEM;
    memcpy(*whole, path, length);
    memcpy(*whole + length, ".mtl", 5);
    *last = (size_t)(name - path);
    return KN_OK;
}

kn_status kn_obj_open(kn_ctx *ctx, kn_sink *out, const char *path, kn_obj_patch *put)
{
    size_t last = 0;
    obj *o = kn_alloc_zero(ctx, 1, sizeof *o);
    if (o == NULL) return KN_ENOMEM;
    o->put = put;
    kn_status status = library_name(ctx, &o->library, &last, path);
    if (status == KN_OK && strcmp(o->library, path) == 0)
        status = kn_fail(ctx, KN_EDOMAIN, "%s: the name is taken by the materials of the OBJ file", path);
    if (status == KN_OK) status = kn_out_open(ctx, &o->file, path);
    if (status == KN_OK) status = kn_out_open(ctx, &o->materials, o->library);
    if (status != KN_OK) {
        obj_close(ctx, o);
        return status;
    }
    memmove(o->library, o->library + last, strlen(o->library + last) + 1);
    *out = (kn_sink){o,         obj_begin, obj_work, obj_commit,  obj_discard, obj_end,
                     obj_close, obj_bytes, obj_save, obj_restore, obj_forget};
    return KN_OK;
}

kn_status kn_obj_sink(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return kn_obj_open(ctx, out, path, NULL);
}
