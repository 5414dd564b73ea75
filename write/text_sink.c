// SPDX-License-Identifier: Apache-2.0
// What sinks of text have in common.
#include "write/text_sink.h"
#include "kernel/context.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// What a thread makes of a block.
typedef struct written {
    kn_text text;
    double lo[3], hi[3];
} written;

// ---- looks ----

kn_status kn_write_take_looks(kn_ctx *ctx, kn_write_look **looks, int *nlooks, const kn_tile *tile)
{
    kn_write_look *list = kn_alloc_zero(ctx, (size_t)tile->nparts, sizeof *list);
    if (!list) return KN_ENOMEM;
    for (int i = 0; i < tile->nparts; i++) {
        const kn_tile_part *part = &tile->parts[i];
        memcpy(list[i].name, part->name, sizeof list[i].name);
        if (part->name[0] == '\0') (void)snprintf(list[i].name, sizeof list[i].name, "part%d", i);
        list[i].material = part->material;
    }
    kn_free(ctx, *looks);
    *looks = list;
    *nlooks = tile->nparts;
    return KN_OK;
}

// ---- what a format holds ----

kn_status kn_write_check_report(kn_ctx *ctx, const kn_write_format *format, const kn_job_report *r)
{
    const struct {
        size_t count;
        unsigned kind;
        const char *name;
    } kinds[] = {{r->meshes, KN_WRITE_MESHES, "meshes"},
                 {r->curves, KN_WRITE_CURVES, "curves"},
                 {r->volumes, KN_WRITE_VOLUMES, "volumes"},
                 {r->trim_curves, KN_WRITE_TRIMMED, "trimmed surfaces"}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (kinds[i].count == 0 || (format->holds & kinds[i].kind)) continue;
        if (kinds[i].kind == KN_WRITE_TRIMMED)
            return kn_fail(ctx, KN_EDOMAIN, "%s: some patches are trimmed surfaces, which it does not hold",
                           format->name);
        return kn_fail(ctx, KN_EDOMAIN, "%s: %zu of the patches are %s, which it does not hold", format->name,
                       kinds[i].count, kinds[i].name);
    }
    return KN_OK;
}

kn_status kn_write_refuse(kn_ctx *ctx, const char *name, const kn_patch_id *id, const char *why)
{
    return kn_fail(ctx, KN_EDOMAIN, "%s: patch %d of part %d in cell %d,%d of surface %d %s", name, id->patch,
                   id->part, id->cell[0], id->cell[1], id->surface, why);
}

static kn_status refuse(kn_ctx *ctx, const kn_write_format *format, const kn_patch *patch, const char *why)
{
    return kn_write_refuse(ctx, format->name, &patch->id, why);
}

kn_status kn_write_check(kn_ctx *ctx, const kn_write_format *format, int nlooks, const kn_patch *patch)
{
    static const unsigned kinds[] = {KN_WRITE_MESHES, KN_WRITE_CURVES, KN_WRITE_SURFACES, KN_WRITE_VOLUMES};
    static const char *const not_held[] = {"is a mesh, which it does not hold", "is a curve, which it does not hold",
                                           "is a surface, which it does not hold",
                                           "is a volume, which it does not hold"};
    int nvars = kn_patch_nvars(patch);
    if (patch->look < 0 || patch->look >= nlooks)
        return kn_fail(ctx, KN_EDOMAIN, "%s: a patch of part %d, of %d", format->name, patch->look, nlooks);
    if (nvars > 3 || (nvars == 0 && !patch->mesh)) return refuse(ctx, format, patch, "has no or too many variables");
    if (!(format->holds & kinds[nvars])) return refuse(ctx, format, patch, not_held[nvars]);
    if (patch->trim && patch->trim->nloops > 0 && !(format->holds & KN_WRITE_TRIMMED))
        return refuse(ctx, format, patch, "is trimmed, which it does not hold");
    if (nvars == 0) return KN_OK;
    kn_spline s = kn_patch_spline(patch);
    if (kn_spline_dim(&s) != 3) return refuse(ctx, format, patch, "does not lie in space");
    size_t n = kn_spline_count(&s);
    for (size_t i = 0; i < n * (size_t)s.ncomp; i++)
        if (!isfinite(s.coef[i])) return refuse(ctx, format, patch, "has a control point that is not finite");
    for (size_t i = 0; s.rational && i < n; i++)
        if (!(s.coef[3 * n + i] > 0.0)) return refuse(ctx, format, patch, "has a weight that is not positive");
    return KN_OK;
}

// ---- items ----

// (u,v) -> (v,u) turns the region inside out: curves run the other way, the last one first.
static kn_status swap_trim(kn_ctx *ctx, kn_trim *out, const kn_trim *trim)
{
    kn_trim made = {0};
    kn_status status = kn_trim_copy(ctx, &made, trim);
    for (int loop = 0, begin = 0; status == KN_OK && loop < made.nloops; begin = made.loop_end[loop++]) {
        for (int i = begin; i < made.loop_end[loop]; i++) {
            kn_spline *c = &made.curves[i];
            size_t n = (size_t)c->count[0];
            for (size_t k = 0; k < n; k++) {
                double u = c->coef[k];
                c->coef[k] = c->coef[n + k], c->coef[n + k] = u;
            }
            kn_trim_turn(c);
        }
        for (int i = begin, j = made.loop_end[loop] - 1; i < j; i++, j--)
            kn_spline_swap(&made.curves[i], &made.curves[j]);
    }
    if (status == KN_OK) *out = made;
    return status;
}

kn_status kn_write_item_init(kn_ctx *ctx, kn_write_item *out, const kn_patch *patch)
{
    static const int order[3] = {1, 0, 2};
    kn_write_item item = {.patch = patch, .spline = kn_patch_spline(patch)};
    kn_spline turned = {0};
    kn_status status = KN_OK;
    if (patch->trim) item.trim = *patch->trim;
    if (patch->reversed && item.spline.nvars >= 2) {
        status = kn_spline_permute(ctx, &turned, &item.spline, order);
        if (status == KN_OK && patch->trim) status = swap_trim(ctx, &item.trim, patch->trim);
        item.spline = turned;
    }
    if (status == KN_OK)
        *out = item;
    else
        kn_spline_clear(ctx, &turned);
    return status;
}

void kn_write_item_clear(kn_ctx *ctx, kn_write_item *item)
{
    if (item->patch && item->patch->reversed && item->spline.nvars >= 2) {
        kn_spline_clear(ctx, &item->spline);
        if (item->patch->trim) kn_trim_clear(ctx, &item->trim);
    }
    *item = (kn_write_item){0};
}

void kn_write_real(kn_text *text, double x)
{
    kn_text_char(text, ' ');
    kn_text_plain_real(text, x, 17);
}

size_t kn_write_place(const kn_spline *s, size_t k)
{
    size_t at = 0;
    size_t stride[3] = {1, 1, 1};
    for (int d = s->nvars - 2; d >= 0; d--) stride[d] = stride[d + 1] * (size_t)s->count[d + 1];
    for (int d = 0; d < s->nvars; k /= (size_t)s->count[d++]) at += k % (size_t)s->count[d] * stride[d];
    return at;
}

// ---- the sink ----

static kn_status flush(kn_ctx *ctx, kn_write_text *w, kn_text *text)
{
    kn_status status = kn_out_flush(ctx, w->file, text);
    kn_text_clear(text);
    return status;
}

static kn_status begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    kn_write_text *w = user;
    kn_text text = {.ctx = ctx};
    w->cell_size = report->cell_size;
    kn_status status = kn_write_check_report(ctx, w->format, report);
    if (status == KN_OK) status = kn_write_take_looks(ctx, &w->looks, &w->nlooks, tile);
    if (status == KN_OK && w->format->head) w->format->head(&text, w);
    if (status == KN_OK) status = flush(ctx, w, &text);
    kn_text_clear(&text);
    return status;
}

static void discard(kn_ctx *ctx, void *user, void *product)
{
    (void)user;
    written *made = product;
    if (!made) return;
    made->text.ctx = ctx; // the worker's own context may be gone
    kn_text_clear(&made->text);
    kn_free(ctx, made);
}

static void grow(double lo[3], double hi[3], const double p[3])
{
    for (int c = 0; c < 3; c++) {
        lo[c] = p[c] < lo[c] ? p[c] : lo[c];
        hi[c] = p[c] > hi[c] ? p[c] : hi[c];
    }
}

static void grow_box(written *made, const kn_write_item *item)
{
    const kn_mesh *mesh = item->patch->mesh;
    const kn_spline *s = &item->spline;
    size_t n = mesh ? mesh->nvertices : kn_spline_count(s);
    for (size_t i = 0; i < n; i++) {
        double p[3];
        for (size_t c = 0; c < 3; c++)
            p[c] = mesh          ? mesh->position[3 * i + c]
                   : s->rational ? s->coef[c * n + i] / s->coef[3 * n + i]
                                 : s->coef[c * n + i];
        grow(made->lo, made->hi, p);
    }
}

static kn_status write_items(kn_ctx *worker, const kn_write_text *w, const kn_write_item *items, size_t n,
                             written *made)
{
    const kn_write_format *f = w->format;
    kn_status status = KN_OK;
    for (size_t i = 0; i < n; i++) grow_box(made, &items[i]);
    if (f->block && n > 0) status = f->block(worker, &made->text, w, items, n);
    for (size_t i = 0; status == KN_OK && !f->block && i < n; i++)
        status = f->patch(worker, &made->text, w, &items[i]);
    return status == KN_OK && made->text.failed ? KN_ENOMEM : status;
}

static kn_status write_block(kn_ctx *worker, const kn_write_text *w, const kn_patch_block *block, written *made)
{
    kn_write_item *items = kn_alloc_zero(worker, block->count + 1, sizeof *items);
    kn_status status = items ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < block->count; i++) {
        const kn_patch *patch = &block->patches[i];
        status = kn_write_check(worker, w->format, w->nlooks, patch);
        if (status == KN_OK) status = kn_write_item_init(worker, &items[i], patch);
        if (status != KN_OK) break;
        items[i].look = &w->looks[patch->look];
    }
    if (status == KN_OK) status = write_items(worker, w, items, block->count, made);
    for (size_t i = 0; items && i < block->count; i++) kn_write_item_clear(worker, &items[i]);
    kn_free(worker, items);
    return status;
}

static kn_status work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    written *made = kn_alloc_zero(worker, 1, sizeof *made);
    if (!made) return KN_ENOMEM;
    made->text.ctx = worker;
    for (int c = 0; c < 3; c++) made->lo[c] = INFINITY, made->hi[c] = -INFINITY;
    kn_status status = write_block(worker, user, block, made);
    if (status == KN_OK) status = kn_text_fit(&made->text);
    if (status == KN_OK)
        *product = made;
    else
        discard(worker, user, made);
    return status;
}

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)block;
    kn_write_text *w = user;
    const written *made = product;
    kn_status status = kn_out_write(ctx, w->file, made->text.data, made->text.bytes);
    grow(w->lo, w->hi, made->lo);
    grow(w->lo, w->hi, made->hi);
    discard(ctx, user, product);
    return status;
}

static kn_status end(kn_ctx *ctx, void *user)
{
    kn_write_text *w = user;
    kn_text text = {.ctx = ctx};
    if (w->format->tail) w->format->tail(&text, w);
    kn_status status = flush(ctx, w, &text);
    return status == KN_OK ? kn_out_commit(ctx, w->file) : status;
}

static void close(kn_ctx *ctx, void *user)
{
    kn_write_text *w = user;
    kn_out_close(ctx, w->file);
    kn_free(ctx, w->looks);
    kn_free(ctx, w);
}

static size_t bytes_so_far(const void *user)
{
    const kn_write_text *w = user;
    return kn_out_bytes(w->file);
}

static kn_status save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    kn_write_text *w = user;
    kn_state state = {.ctx = ctx};
    kn_status status = kn_out_save(ctx, w->file, &state);
    kn_state_put(&state, w->lo, sizeof w->lo);
    kn_state_put(&state, w->hi, sizeof w->hi);
    return kn_state_give(&state, data, bytes, status);
}

static kn_status restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                         const unsigned char *data, size_t bytes)
{
    kn_write_text *w = user;
    kn_state_reader r = {data, bytes};
    double lo[3], hi[3];
    w->cell_size = report->cell_size;
    kn_status status = kn_write_take_looks(ctx, &w->looks, &w->nlooks, tile);
    if (status == KN_OK) status = kn_out_restore(ctx, w->file, &r);
    if (status != KN_OK) return status;
    if (!kn_state_take(&r, lo, sizeof lo) || !kn_state_take(&r, hi, sizeof hi) || r.bytes > 0)
        return kn_state_fail(ctx, w->format->name);
    memcpy(w->lo, lo, sizeof lo), memcpy(w->hi, hi, sizeof hi);
    return KN_OK;
}

static void forget(void *user)
{
    kn_write_text *w = user;
    kn_out_forget(w->file);
}

kn_status kn_write_text_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_write_format *format)
{
    kn_write_text *w = kn_alloc_zero(ctx, 1, sizeof *w);
    if (!w) return KN_ENOMEM;
    w->format = format;
    for (int c = 0; c < 3; c++) w->lo[c] = INFINITY, w->hi[c] = -INFINITY;
    kn_status status = kn_out_open(ctx, &w->file, path);
    if (status == KN_OK)
        *out = (kn_sink){w, begin, work, commit, discard, end, close, bytes_so_far, save, restore, forget};
    else
        kn_free(ctx, w);
    return status;
}
