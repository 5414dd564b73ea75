// SPDX-License-Identifier: Apache-2.0
// A sink that tessellates patches into a binary STL file.
#include <knurl/io.h>

#include "io/out_file.h"
#include "kernel/context.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { HEADER_BYTES = 80, COUNT_BYTES = 4, TRIANGLE_BYTES = 50 };

typedef struct stl {
    kn_out_file *file;
    uint64_t triangles;
} stl;

typedef struct product {
    unsigned char *data;
    size_t triangles, room;
} product;

// The format is little-endian whatever the machine is.
static void put_u32(unsigned char *to, uint32_t value)
{
    for (int i = 0; i < 4; i++) to[i] = (unsigned char)(value >> (8 * i));
}

static void put_float(unsigned char *to, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_u32(to, bits);
}

static bool equal(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

// The unit normal of the triangle as it is stored; zero where it has no area.
static void triangle_normal(float normal[3], float p[3][3])
{
    double a[3], b[3], n[3], length;
    for (int c = 0; c < 3; c++) a[c] = (double)p[1][c] - p[0][c], b[c] = (double)p[2][c] - p[0][c];
    for (int c = 0; c < 3; c++) n[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int c = 0; c < 3; c++) normal[c] = length > 0.0 ? (float)(n[c] / length) : 0.0f;
}

static kn_status stl_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)tile;
    (void)report;
    stl *s = user;
    unsigned char header[HEADER_BYTES + COUNT_BYTES] = "knurl"; // the count is known at the end
    return kn_out_write(ctx, s->file, header, sizeof header);
}

static kn_status beyond_range(kn_ctx *ctx, const kn_patch *patch, double x)
{
    return kn_fail(ctx, KN_EDOMAIN, "STL: a coordinate %g in cell %d, %d of surface %d is beyond single precision", x,
                   patch->id.cell[0], patch->id.cell[1], patch->id.surface);
}

// Triangles of which two corners fall together in single precision are left out.
static kn_status append(kn_ctx *ctx, product *p, const kn_mesh *mesh, const kn_patch *patch)
{
    size_t needed = p->triangles + mesh->ntriangles;
    if (needed > p->room) {
        size_t room = needed + p->room;
        unsigned char *larger = p->data == NULL ? kn_alloc(ctx, room, TRIANGLE_BYTES)
                                                : kn_resize(ctx, p->data, room, TRIANGLE_BYTES);
        if (larger == NULL) return KN_ENOMEM;
        p->data = larger, p->room = room;
    }
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        float corner[3][3], normal[3];
        for (size_t k = 0; k < 3; k++)
            for (size_t c = 0; c < 3; c++) {
                double x = mesh->position[3 * (size_t)mesh->triangle[3 * t + k] + c];
                if (!(fabs(x) <= (double)FLT_MAX)) return beyond_range(ctx, patch, x);
                corner[k][c] = (float)x;
            }
        if (equal(corner[0], corner[1]) || equal(corner[1], corner[2]) || equal(corner[2], corner[0])) continue;
        triangle_normal(normal, corner);
        unsigned char *to = p->data + TRIANGLE_BYTES * p->triangles++;
        for (int c = 0; c < 3; c++) put_float(to + 4 * c, normal[c]);
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++) put_float(to + 12 * (k + 1) + 4 * c, corner[k][c]);
        to[48] = to[49] = 0;
    }
    return KN_OK;
}

static void stl_discard(kn_ctx *ctx, void *user, void *made)
{
    (void)user;
    product *p = made;
    if (p == NULL) return;
    kn_free(ctx, p->data);
    kn_free(ctx, p);
}

static kn_status stl_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **made)
{
    kn_mesh mesh = {0};
    product *p = kn_alloc_zero(worker, 1, sizeof *p);
    kn_status status = p != NULL ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < block->count && status == KN_OK; i++) {
        const kn_patch *patch = &block->patches[i];
        mesh.nvertices = mesh.ntriangles = 0;
        status = kn_patch_tessellate(worker, &mesh, patch);
        if (status == KN_OK) status = append(worker, p, &mesh, patch);
    }
    kn_mesh_clear(worker, &mesh);
    if (status == KN_OK)
        *made = p;
    else
        stl_discard(worker, user, p);
    return status;
}

static kn_status stl_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *made)
{
    (void)block;
    stl *s = user;
    const product *p = made;
    s->triangles += p->triangles;
    kn_status status = s->triangles <= UINT32_MAX
                           ? kn_out_write(ctx, s->file, p->data, TRIANGLE_BYTES * p->triangles)
                           : kn_fail(ctx, KN_ELIMIT, "STL: more than %u triangles", (unsigned)UINT32_MAX);
    stl_discard(ctx, user, made);
    return status;
}

static kn_status stl_end(kn_ctx *ctx, void *user)
{
    stl *s = user;
    unsigned char count[COUNT_BYTES];
    put_u32(count, (uint32_t)s->triangles);
    kn_status status = kn_out_rewrite(ctx, s->file, HEADER_BYTES, count, sizeof count);
    return status == KN_OK ? kn_out_commit(ctx, s->file) : status;
}

static void stl_close(kn_ctx *ctx, void *user)
{
    stl *s = user;
    kn_out_close(ctx, s->file);
    kn_free(ctx, s);
}

static size_t stl_bytes(const void *user)
{
    const stl *s = user;
    return kn_out_bytes(s->file);
}

static kn_status stl_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    stl *s = user;
    kn_state state = {.ctx = ctx};
    kn_status status = kn_out_save(ctx, s->file, &state);
    kn_state_put(&state, &s->triangles, sizeof s->triangles);
    return kn_state_give(&state, data, bytes, status);
}

static kn_status stl_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                             const unsigned char *data, size_t bytes)
{
    (void)tile, (void)report;
    stl *s = user;
    kn_state_reader r = {data, bytes};
    uint64_t triangles;
    kn_status status = kn_out_restore(ctx, s->file, &r);
    if (status != KN_OK) return status;
    if (!kn_state_take(&r, &triangles, sizeof triangles) || r.bytes > 0) return kn_state_fail(ctx, "STL");
    s->triangles = triangles;
    return KN_OK;
}

static void stl_forget(void *user)
{
    stl *s = user;
    kn_out_forget(s->file);
}

kn_status kn_stl_sink(kn_ctx *ctx, kn_sink *out, const char *path)
{
    stl *s = kn_alloc_zero(ctx, 1, sizeof *s);
    if (s == NULL) return KN_ENOMEM;
    kn_status status = kn_out_open(ctx, &s->file, path);
    if (status == KN_OK)
        *out = (kn_sink){s,         stl_begin, stl_work, stl_commit,  stl_discard, stl_end,
                         stl_close, stl_bytes, stl_save, stl_restore, stl_forget};
    else
        kn_free(ctx, s);
    return status;
}
