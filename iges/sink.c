// SPDX-License-Identifier: Apache-2.0
// A sink that writes patches as IGES while they are composed. The directory section comes before the parameters:
// these wait in a file of their own.
#include <knurl/iges.h>

#include "iges/write.h"
#include "io/announced.h"
#include "io/out_file.h"
#include "kernel/context.h"

#include <stdio.h>
#include <string.h>

enum { FLUSH_BYTES = 1 << 18, STAMP_BYTES = 16, MOST_NAME = 256 };

typedef struct iges {
    kn_out_file *file, *parameters;
    char *product, time_stamp[STAMP_BYTES];
    double unit_mm, uncertainty_mm;
    kn_iges_join join;
    kn_naming naming;
    uint64_t lines[2]; // of the start and global sections
    kn_announced announced;
} iges;

// ---- begin ----

// What can never fit is refused before anything is composed: numbers take two columns at least, and a face five
// lines.
static kn_status take_report(kn_ctx *ctx, iges *s, const kn_job_report *report)
{
    kn_status status = kn_announced_take(ctx, &s->announced, report, "IGES");
    if (status != KN_OK) return status;
    kn_naming_take_report(&s->naming, report);
    uint64_t points = report->volumes > 0 ? 0 : report->control_points; // hidden faces of volumes are not written
    uint64_t faces = report->volumes > 0 || report->curves > 0 ? 0 : report->patches;
    if (points / 8 < KN_IGES_MOST && faces < KN_IGES_MOST / 5 && points / 8 + 5 * faces <= KN_IGES_MOST) return KN_OK;
    return kn_fail(ctx, KN_ELIMIT,
                   "IGES: %zu patches of degree %d,%d need more than %d lines, which seven digits "
                   "cannot count: write STEP",
                   report->patches, report->degree[0], report->degree[1], KN_IGES_MOST);
}

// The same lines again where a run goes on.
static void put_start(iges *s, kn_text *text)
{
    s->lines[0] = s->lines[1] = 0;
    kn_iges_put_start(text, s->product, s->time_stamp, s->uncertainty_mm, s->lines);
}

static kn_status iges_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    iges *s = user;
    kn_text text = {.ctx = ctx};
    kn_status status = take_report(ctx, s, report);
    if (status == KN_OK) status = kn_iges_join_begin(ctx, &s->join, tile);
    if (status == KN_OK) {
        put_start(s, &text);
        status = kn_out_flush(ctx, s->file, &text);
    }
    kn_text_clear(&text);
    return status;
}

// ---- blocks ----

typedef struct writing {
    const iges *s;
    kn_iges_written *w;
} writing;

static kn_status put_patch(void *user, const kn_patch *patch)
{
    const iges *s = ((writing *)user)->s;
    kn_iges_written *w = ((writing *)user)->w;
    if (kn_patch_nvars(patch) == 1) return kn_iges_put_line(w, patch, s->unit_mm);
    return patch->trim && patch->trim->nloops > 0 ? kn_iges_put_trimmed(w, patch, s->unit_mm, !s->join.surfaces)
                                                  : kn_iges_put_face(w, patch, s->unit_mm, !s->join.surfaces);
}

static void iges_discard(kn_ctx *ctx, void *user, void *product)
{
    (void)user;
    kn_iges_written *w = product;
    if (!w) return;
    w->text.ctx = ctx; // the worker's own context may be gone
    kn_text_clear(&w->text);
    kn_free(ctx, w->items);
    kn_free(ctx, w->loops);
    kn_free(ctx, w->lines);
    kn_free(ctx, w->edges);
    kn_free(ctx, w->pairs);
    kn_free(ctx, w);
}

static kn_status iges_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    const iges *s = user;
    size_t most = 0;
    for (size_t i = 0; i < block->count; i++) most += kn_patch_nvars(&block->patches[i]) == 3 ? 6 : 1;
    kn_iges_written *w = kn_alloc_zero(worker, 1, sizeof *w);
    if (!w) return KN_ENOMEM;
    w->text.ctx = worker;
    w->items = kn_alloc(worker, most, sizeof *w->items);
    kn_status status = w->items ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < block->count && status == KN_OK; i++) {
        const kn_patch *patch = &block->patches[i];
        uint64_t place = (uint64_t)block->first + i;
        status = kn_announced_check(worker, &s->announced, patch, place, s->join.nlooks, "IGES");
        if (status == KN_OK) status = kn_announced_each_face(worker, patch, put_patch, &(writing){s, w});
    }
    if (status == KN_OK) status = kn_text_fit(&w->text);
    if (status != KN_OK) {
        iges_discard(worker, user, w);
        return status;
    }
    *product = w;
    return KN_OK;
}

typedef struct emptying {
    kn_ctx *ctx;
    iges *s;
} emptying;

static kn_status empty(void *user)
{
    emptying *e = user;
    kn_status status = kn_out_flush(e->ctx, e->s->file, &e->s->join.directory);
    return status == KN_OK ? kn_out_flush(e->ctx, e->s->parameters, &e->s->join.parameters) : status;
}

static kn_status iges_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    iges *s = user;
    const kn_iges_written *w = product;
    kn_status status = KN_OK;
    (void)block;
    s->join.directory.ctx = s->join.parameters.ctx = ctx;
    for (size_t i = 0; i < w->nitems && status == KN_OK; i++) {
        status = kn_iges_join_item(ctx, &s->join, w, &w->items[i]);
        if (status == KN_OK && s->join.parameters.bytes > FLUSH_BYTES) status = empty(&(emptying){ctx, s});
    }
    if (status == KN_OK) status = empty(&(emptying){ctx, s});
    iges_discard(ctx, user, product);
    return status;
}

// ---- end ----

static kn_status iges_end(kn_ctx *ctx, void *user)
{
    iges *s = user;
    char line[KN_IGES_LINE_BYTES + 1];
    s->join.directory.ctx = s->join.parameters.ctx = ctx;
    kn_status status = kn_iges_join_end(ctx, &s->join, empty, &(emptying){ctx, s});
    if (status == KN_OK) status = kn_out_append(ctx, s->file, s->parameters);
    snprintf(line, sizeof line, "S%7lluG%7lluD%7lluP%7llu%40sT%7d\n", (unsigned long long)s->lines[0],
             (unsigned long long)s->lines[1], (unsigned long long)(2 * s->join.next),
             (unsigned long long)s->join.lines, "", 1);
    if (status == KN_OK) status = kn_out_write(ctx, s->file, line, KN_IGES_LINE_BYTES);
    if (status != KN_OK) return status;
    status = kn_out_commit(ctx, s->file);
    if (status != KN_OK) kn_out_forget(s->file); // nobody can go on without the parameters
    return status;
}

static void iges_close(kn_ctx *ctx, void *user)
{
    iges *s = user;
    kn_out_close(ctx, s->file);
    kn_out_close(ctx, s->parameters);
    kn_iges_join_clear(ctx, &s->join);
    kn_naming_clear(ctx, &s->naming);
    kn_free(ctx, s->product);
    kn_free(ctx, s);
}

static size_t iges_bytes(const void *user)
{
    const iges *s = user;
    return kn_out_bytes(s->file);
}

static kn_status iges_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    iges *s = user;
    kn_state state = {.ctx = ctx};
    kn_status status = kn_out_save(ctx, s->file, &state);
    if (status == KN_OK) status = kn_out_save(ctx, s->parameters, &state);
    kn_iges_join_save(&s->join, &state);
    return kn_state_give(&state, data, bytes, status);
}

static kn_status iges_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                              const unsigned char *data, size_t bytes)
{
    iges *s = user;
    kn_state_reader r = {data, bytes};
    kn_text text = {.ctx = ctx};
    kn_status status = take_report(ctx, s, report);
    put_start(s, &text);
    if (status == KN_OK && text.failed) status = KN_ENOMEM;
    kn_text_clear(&text);
    if (status == KN_OK) status = kn_iges_join_begin(ctx, &s->join, tile);
    if (status == KN_OK) status = kn_out_restore(ctx, s->file, &r);
    if (status == KN_OK) status = kn_out_restore(ctx, s->parameters, &r);
    if (status == KN_OK) status = kn_iges_join_restore(ctx, &s->join, &r);
    return status == KN_OK && r.bytes > 0 ? kn_state_fail(ctx, "IGES") : status;
}

static void iges_forget(void *user)
{
    iges *s = user;
    kn_out_forget(s->file), kn_out_forget(s->parameters);
}

// "2026-01-02T03:04:05" as "20260102.030405".
static kn_status take_stamp(kn_ctx *ctx, char out[STAMP_BYTES], const char *stamp)
{
    static const char form[] = "dddd-dd-ddTdd:dd:dd";
    size_t n = 0;
    for (size_t i = 0; i < sizeof form - 1; i++) {
        bool digit = stamp[i] >= '0' && stamp[i] <= '9';
        if (form[i] == 'd' ? !digit : stamp[i] != form[i])
            return kn_fail(ctx, KN_EDOMAIN, "IGES: time stamp \"%.40s\" is not like 2026-01-02T03:04:05", stamp);
        if (digit) out[n++] = stamp[i];
        if (form[i] == 'T') out[n++] = '.';
    }
    out[n] = '\0';
    return KN_OK;
}

static kn_status take_options(kn_ctx *ctx, iges *s, const kn_iges_options *o)
{
    const char *product = o->product ? o->product : "knurl";
    if (!(o->unit_mm >= 0.0 && o->unit_mm < 1e12 && o->uncertainty_mm >= 0.0 && o->uncertainty_mm < 1e12))
        return kn_fail(ctx, KN_EDOMAIN, "IGES: unit %g mm, uncertainty %g mm", o->unit_mm, o->uncertainty_mm);
    if (o->nsurfaces < 0) return kn_fail(ctx, KN_EDOMAIN, "IGES: %d names of surfaces", o->nsurfaces);
    size_t bytes = strlen(product) + 1;
    if (bytes > MOST_NAME) return kn_fail(ctx, KN_EDOMAIN, "IGES: a product name of %zu bytes", bytes - 1);
    s->unit_mm = o->unit_mm > 0.0 ? o->unit_mm : 1.0;
    s->uncertainty_mm = o->uncertainty_mm > 0.0 ? o->uncertainty_mm : 1e-3;
    s->join.surfaces = o->surfaces, s->join.naming = &s->naming;
    s->product = kn_alloc(ctx, bytes, 1);
    if (!s->product) return KN_ENOMEM;
    memcpy(s->product, product, bytes);
    if (kn_naming_init(ctx, &s->naming, o->surface_names, o->nsurfaces, o->plain_names) != KN_OK) return KN_ENOMEM;
    return take_stamp(ctx, s->time_stamp, o->time_stamp ? o->time_stamp : "1970-01-01T00:00:00");
}

kn_status kn_iges_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_iges_options *options)
{
    kn_iges_options o = options ? *options : (kn_iges_options){0};
    iges *s = kn_alloc_zero(ctx, 1, sizeof *s);
    if (!s) return KN_ENOMEM;
    kn_status status = take_options(ctx, s, &o);
    if (status == KN_OK) status = kn_out_open(ctx, &s->file, path);
    if (status == KN_OK) status = kn_out_open_beside(ctx, &s->parameters, s->file, ".parameters");
    if (status != KN_OK) {
        iges_close(ctx, s);
        return status;
    }
    *out = (kn_sink){s,          iges_begin, iges_work, iges_commit,  iges_discard, iges_end,
                     iges_close, iges_bytes, iges_save, iges_restore, iges_forget};
    return KN_OK;
}
