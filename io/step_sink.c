// SPDX-License-Identifier: Apache-2.0
// A sink that writes patches as STEP AP214 while they are composed.
#include <knurl/io.h>

#include "io/out_file.h"
#include "io/step_face.h"
#include "io/step_runs.h"
#include "io/step_write.h"
#include "kernel/context.h"

#include <limits.h>
#include <string.h>

enum { FLUSH_BYTES = 1 << 20 };

typedef struct part {
    char name[KN_NAME_BYTES];
    kn_material material;
    kn_step_runs faces;
} part;

typedef struct step {
    kn_out_file *file;
    char *product, *time_stamp;
    double unit_mm, uncertainty_mm;
    part *parts;
    int nparts;
    int nslots; // parts in use: those of the tile, and once more for their curves where there are any
    int degree[2];
    uint64_t faces;                  // of a patch, at most
    uint64_t patches, first, stride; // face f of patches[k] is numbered from first + (k faces + f) stride
    const char *representation;
} step;

static kn_status copy_string(kn_ctx *ctx, char **out, const char *string)
{
    size_t bytes = strlen(string) + 1;
    *out = kn_alloc(ctx, bytes, 1);
    if (*out == NULL) return KN_ENOMEM;
    memcpy(*out, string, bytes);
    return KN_OK;
}

static kn_status flush(kn_ctx *ctx, step *s, kn_text *text)
{
    if (text->failed) return KN_ENOMEM;
    kn_status status = kn_out_write(ctx, s->file, text->data, text->bytes);
    text->bytes = text->line = 0;
    return status;
}

// ---- begin ----

static kn_status copy_parts(kn_ctx *ctx, step *s, const kn_tile *tile, const kn_job_report *report)
{
    int nslots = report->curves > 0 ? 2 * tile->nparts : tile->nparts;
    s->parts = kn_alloc_zero(ctx, (size_t)nslots, sizeof *s->parts);
    if (s->parts == NULL) return KN_ENOMEM;
    s->nparts = tile->nparts;
    s->nslots = nslots;
    for (int i = 0; i < nslots; i++) {
        const kn_tile_part *from = &tile->parts[i % tile->nparts];
        memcpy(s->parts[i].name, from->name, sizeof s->parts[i].name);
        s->parts[i].name[KN_NAME_BYTES - 1] = '\0';
        s->parts[i].material = from->material;
    }
    return KN_OK;
}

// Many readers keep entity numbers in 32 bits.
static kn_status number_patches(kn_ctx *ctx, step *s, const kn_job_report *report)
{
    s->degree[0] = report->degree[0], s->degree[1] = report->degree[1];
    s->patches = report->patches;
    s->first = KN_STEP_PARTS + KN_STEP_PART_NUMBERS * (uint64_t)s->nslots;
    s->faces = report->volumes > 0 ? 6 : 1;
    s->representation = report->curves == 0                 ? "MANIFOLD_SURFACE_SHAPE_REPRESENTATION"
                        : report->curves == report->patches ? "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION"
                                                            : "SHAPE_REPRESENTATION";
    if (report->meshes > 0)
        return kn_fail(ctx, KN_EDOMAIN,
                       "STEP: %zu of the patches are meshes, and faces are spline surfaces: write STL, OBJ or glTF",
                       report->meshes);
    s->stride = (uint64_t)(s->degree[0] + 1) * (uint64_t)(s->degree[1] + 1) + KN_STEP_FACE_NUMBERS;
    s->stride += kn_step_trim_room(report);
    if (s->patches <= (INT_MAX - s->first) / s->stride / s->faces) return KN_OK;
    return kn_fail(ctx, KN_ELIMIT, "STEP: %zu patches of degree %d,%d need entity numbers beyond %d", report->patches,
                   s->degree[0], s->degree[1], INT_MAX);
}

static kn_status step_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    step *s = user;
    kn_text text = {.ctx = ctx};
    kn_status status = copy_parts(ctx, s, tile, report);
    if (status == KN_OK) status = number_patches(ctx, s, report);
    if (status == KN_OK) {
        kn_step_put_header(&text, s->product, s->time_stamp, s->uncertainty_mm);
        status = flush(ctx, s, &text);
    }
    kn_text_clear(&text);
    return status;
}

// ---- blocks ----

static kn_status check_patch(kn_ctx *ctx, const step *s, const kn_patch *patch, uint64_t place)
{
    const kn_bezier *b = &patch->bezier;
    int most = s->degree[0] < s->degree[1] ? s->degree[0] : s->degree[1];
    bool fits = b->nvars == 3 ? s->faces == 6 && b->degree[0] <= most && b->degree[1] <= most && b->degree[2] <= most
                : b->nvars == 2 ? b->degree[0] <= s->degree[0] && b->degree[1] <= s->degree[1]
                                : b->nvars == 1 && s->nslots > s->nparts && b->degree[0] <= s->degree[0];
    if (fits && kn_bezier_dim(b) == 3 && patch->look >= 0 && patch->look < s->nparts && place < s->patches)
        return KN_OK;
    return kn_fail(ctx, KN_EDOMAIN, "STEP: patch %llu is not what the job's report announced",
                   (unsigned long long)place);
}

// Faces of a volume that lie outside.
static kn_status put_volume(kn_ctx *ctx, const step *s, kn_text *text, const kn_patch *patch, uint64_t first)
{
    kn_status status = KN_OK;
    for (int k = 0; k < 6 && status == KN_OK; k++) {
        kn_patch face = {0};
        if (patch->hidden >> k & 1) continue;
        status = kn_patch_face(ctx, &face, patch, k);
        if (status == KN_OK)
            status = kn_step_put_face(text, &face, s->parts[patch->look].name, first + (uint64_t)k * s->stride,
                                      s->unit_mm);
        kn_bezier_clear(ctx, &face.bezier);
    }
    return status;
}

static kn_status put_patch(kn_ctx *ctx, const step *s, kn_text *text, const kn_patch *patch, uint64_t place)
{
    uint64_t first = s->first + place * s->faces * s->stride;
    if (patch->bezier.nvars == 1) return kn_step_put_curve(text, patch, first, s->unit_mm);
    if (patch->bezier.nvars == 3) return put_volume(ctx, s, text, patch, first);
    return kn_step_put_face(text, patch, s->parts[patch->look].name, first, s->unit_mm);
}

static kn_status step_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    const step *s = user;
    kn_text *text = kn_alloc_zero(worker, 1, sizeof *text);
    if (text == NULL) return KN_ENOMEM;
    text->ctx = worker;
    kn_status status = KN_OK;
    for (size_t i = 0; i < block->count && status == KN_OK; i++) {
        const kn_patch *patch = &block->patches[i];
        uint64_t place = (uint64_t)block->first + i;
        status = check_patch(worker, s, patch, place);
        if (status == KN_OK) status = put_patch(worker, s, text, patch, place);
    }
    if (status != KN_OK) {
        kn_text_clear(text);
        kn_free(worker, text);
        return status;
    }
    *product = text;
    return KN_OK;
}

// The faces or the curve of a patch numbered from `first`.
static kn_status add_patch(kn_ctx *ctx, step *s, const kn_patch *patch, uint64_t first)
{
    const kn_bezier *b = &patch->bezier;
    int slot = b->nvars == 1 ? s->nparts + patch->look : patch->look;
    kn_status status = KN_OK;
    if (b->nvars < 3) return kn_step_runs_add(ctx, &s->parts[slot].faces, kn_step_face(b, first), s->stride);
    for (int k = 0; k < 6 && status == KN_OK; k++) {
        if (patch->hidden >> k & 1) continue;
        kn_bezier face = {.nvars = 2, .degree = {b->degree[k / 2 == 0 ? 1 : 0], b->degree[k / 2 == 2 ? 1 : 2]}};
        uint64_t number = kn_step_face(&face, first + (uint64_t)k * s->stride);
        status = kn_step_runs_add(ctx, &s->parts[slot].faces, number, s->stride);
    }
    return status;
}

static void step_discard(kn_ctx *ctx, void *user, void *product)
{
    (void)user;
    kn_text *text = product;
    if (text == NULL) return;
    text->ctx = ctx; // the worker's own context may be gone
    kn_text_clear(text);
    kn_free(ctx, text);
}

static kn_status step_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    step *s = user;
    const kn_text *text = product;
    kn_status status = kn_out_write(ctx, s->file, text->data, text->bytes);
    for (size_t i = 0; i < block->count && status == KN_OK; i++) {
        const kn_patch *patch = &block->patches[i];
        status = add_patch(ctx, s, patch, s->first + ((uint64_t)block->first + i) * s->faces * s->stride);
    }
    step_discard(ctx, user, product);
    return status;
}

// ---- end ----

// The shell's faces could be millions: the text goes out in pieces.
static kn_status put_shell(kn_ctx *ctx, step *s, kn_text *text, const part *p, uint64_t first)
{
    kn_status status = KN_OK;
    bool curves = p >= s->parts + s->nparts;
    kn_step_put_number(text, curves ? first + 1 : first);
    kn_text_put(text, curves ? "GEOMETRIC_CURVE_SET(" : "OPEN_SHELL(");
    kn_text_step_string(text, p->name);
    kn_text_put(text, ",(");
    kn_step_place place = {0};
    uint64_t face;
    for (bool any = false; status == KN_OK && kn_step_runs_next(&face, &place, &p->faces, s->stride); any = true) {
        if (any) kn_text_comma(text);
        kn_text_reference(text, face);
        if (text->bytes > FLUSH_BYTES) status = flush(ctx, s, text);
    }
    kn_text_put(text, "));\n");
    if (curves) return status;
    kn_step_put_number(text, first + 1);
    kn_text_put(text, "SHELL_BASED_SURFACE_MODEL(");
    kn_text_step_string(text, p->name);
    kn_text_put(text, ",(");
    kn_text_reference(text, first);
    kn_text_put(text, "));");
    kn_text_newline(text);
    return status;
}

// "#number=NAME('',(" items of the parts that have faces "),#15);", each of them `offset` into its part's numbers.
static void put_representation(kn_text *text, const step *s, uint64_t representation, const char *name,
                               bool placement, uint64_t offset)
{
    bool written = placement;
    kn_step_put_number(text, representation);
    kn_text_put(text, name);
    kn_text_put(text, "('',(");
    if (placement) kn_text_reference(text, KN_STEP_PLACEMENT);
    for (int i = 0; i < (placement ? s->nslots : s->nparts); i++) { // curves have no colour of their own
        if (s->parts[i].faces.bytes == 0) continue;
        if (written) kn_text_comma(text);
        kn_text_reference(text, KN_STEP_PARTS + KN_STEP_PART_NUMBERS * (uint64_t)i + offset);
        written = true;
    }
    kn_text_put(text, "),");
    kn_text_reference(text, KN_STEP_GEOMETRY_CONTEXT);
    kn_text_put(text, ");");
    kn_text_newline(text);
}

static kn_status step_end(kn_ctx *ctx, void *user)
{
    step *s = user;
    kn_text text = {.ctx = ctx};
    kn_status status = KN_OK;
    bool any = false;
    for (int i = 0; i < s->nslots && status == KN_OK; i++) {
        uint64_t first = KN_STEP_PARTS + KN_STEP_PART_NUMBERS * (uint64_t)i;
        status = kn_step_runs_end(ctx, &s->parts[i].faces, s->stride);
        if (status != KN_OK || s->parts[i].faces.bytes == 0) continue;
        status = put_shell(ctx, s, &text, &s->parts[i], first);
        if (i >= s->nparts) continue;
        kn_step_put_style(&text, &s->parts[i].material, first);
        any = true;
    }
    put_representation(&text, s, KN_STEP_REPRESENTATION, s->representation, true, 1);
    if (any)
        put_representation(&text, s, KN_STEP_PRESENTATION, "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION",
                           false, 2);
    kn_text_put(&text, "ENDSEC;\nEND-ISO-10303-21;\n");
    if (status == KN_OK) status = flush(ctx, s, &text);
    if (status == KN_OK) status = kn_out_commit(ctx, s->file);
    kn_text_clear(&text);
    return status;
}

static void step_close(kn_ctx *ctx, void *user)
{
    step *s = user;
    kn_out_close(ctx, s->file);
    for (int i = 0; i < s->nslots; i++) kn_step_runs_clear(ctx, &s->parts[i].faces);
    kn_free(ctx, s->parts);
    kn_free(ctx, s->product);
    kn_free(ctx, s->time_stamp);
    kn_free(ctx, s);
}

static size_t step_bytes(const void *user)
{
    const step *s = user;
    return kn_out_bytes(s->file);
}

static kn_status step_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    step *s = user;
    kn_state state = {.ctx = ctx};
    kn_status status = kn_out_save(ctx, s->file, &state);
    for (int i = 0; i < s->nslots; i++) {
        kn_step_runs faces = s->parts[i].faces;
        faces.data = NULL, faces.room = 0; // not of the state
        kn_state_put(&state, &faces, sizeof faces);
        kn_state_put_block(&state, s->parts[i].faces.data, faces.bytes);
    }
    return kn_state_give(&state, data, bytes, status);
}

static kn_status restore_part(kn_ctx *ctx, part *p, kn_state_reader *r)
{
    kn_step_runs faces;
    size_t bytes = 0;
    const void *data = kn_state_take(r, &faces, sizeof faces) ? kn_state_take_block(r, &bytes) : NULL;
    if (data == NULL || bytes != faces.bytes) return kn_state_fail(ctx, "STEP");
    faces.data = kn_alloc(ctx, bytes + 1, 1);
    if (faces.data == NULL) return KN_ENOMEM;
    memcpy(faces.data, data, bytes);
    faces.room = bytes;
    p->faces = faces;
    return KN_OK;
}

static kn_status step_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                              const unsigned char *data, size_t bytes)
{
    step *s = user;
    kn_state_reader r = {data, bytes};
    kn_status status = copy_parts(ctx, s, tile, report);
    if (status == KN_OK) status = number_patches(ctx, s, report);
    if (status == KN_OK) status = kn_out_restore(ctx, s->file, &r);
    for (int i = 0; i < s->nslots && status == KN_OK; i++) status = restore_part(ctx, &s->parts[i], &r);
    return status == KN_OK && r.bytes > 0 ? kn_state_fail(ctx, "STEP") : status;
}

kn_status kn_step_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_step_options *options)
{
    kn_step_options o = options != NULL ? *options : (kn_step_options){0};
    if (!(o.unit_mm >= 0.0 && o.unit_mm < 1e12 && o.uncertainty_mm >= 0.0 && o.uncertainty_mm < 1e12))
        return kn_fail(ctx, KN_EDOMAIN, "STEP: unit %g mm, uncertainty %g mm", o.unit_mm, o.uncertainty_mm);
    step *s = kn_alloc_zero(ctx, 1, sizeof *s);
    if (s == NULL) return KN_ENOMEM;
    s->unit_mm = o.unit_mm > 0.0 ? o.unit_mm : 1.0;
    s->uncertainty_mm = o.uncertainty_mm > 0.0 ? o.uncertainty_mm : 1e-3;
    kn_status status = copy_string(ctx, &s->product, o.product != NULL ? o.product : "knurl");
    if (status == KN_OK)
        status = copy_string(ctx, &s->time_stamp, o.time_stamp != NULL ? o.time_stamp : "1970-01-01T00:00:00");
    if (status == KN_OK) status = kn_out_open(ctx, &s->file, path);
    if (status != KN_OK) {
        step_close(ctx, s);
        return status;
    }
    *out = (kn_sink){s,        step_begin, step_work,  step_commit, step_discard,
                     step_end, step_close, step_bytes, step_save,   step_restore};
    return KN_OK;
}
