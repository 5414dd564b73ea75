// SPDX-License-Identifier: Apache-2.0
// A sink that writes patches as STEP while they are composed: solids where faces close, open shells elsewhere.
#include <knurl/step.h>

#include "io/announced.h"
#include "io/out_file.h"
#include "step/instances.h"
#include "step/join.h"
#include "kernel/context.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { FLUSH_BYTES = 1 << 18, ENTITIES = 9 }; // of a face, at least, beside its points: see number_patches

typedef struct step {
    kn_out_file *file;
    kn_step_about about;
    kn_naming naming;
    double unit_mm;
    kn_step_join join;
    kn_announced announced;
    bool instances;
    kn_step_cells *cells; // of instances
} step;

// What a thread makes of a block.
typedef struct written {
    kn_text text;
    kn_step_item *items;
    size_t nitems;
    kn_step_lists lists;
    kn_step_points points; // of instances
} written;

static kn_status copy_string(kn_ctx *ctx, char **out, const char *string)
{
    size_t bytes = strlen(string) + 1;
    *out = kn_alloc(ctx, bytes, 1);
    if (*out == NULL) return KN_ENOMEM;
    memcpy(*out, string, bytes);
    return KN_OK;
}

// ---- begin ----

// Gaps between neighbours, and how the faces that are not exact are known.
static void describe(step *s, const kn_job_report *r)
{
    kn_step_about *a = &s->about;
    double mm = s->unit_mm, off = r->stand_in_error + r->crossing_error + r->fit_tolerance;
    bool all = r->exact_patches == r->patches && r->fit_degree == 0;
    kn_naming_take_report(&s->naming, r);
    // two pieces side by side may each be off by as much
    double trimmed = r->trim_curves > 0 ? r->fit_tolerance : 0.0; // other edges of limited faces stay shared
    a->uncertainty_mm = fmax(a->uncertainty_mm, 2.0 * mm * (r->stand_in_error + r->crossing_error + trimmed));
    a->uncertainty_mm = fmax(a->uncertainty_mm, mm * (r->edge_error + trimmed)); // of a curve from each of its faces
    snprintf(a->text[0], sizeof a->text[0], "degree at most %d,%d; %s", r->degree[0], r->degree[1],
             all              ? "all faces are exact"
             : s->naming.mark ? "faces named .. ~ are approximations, all others exact"
                              : "all faces are approximations");
    if (all || !(off > 0.0)) return;
    snprintf(a->text[1], sizeof a->text[1], "certified distance from the exact texture: at most %.3g mm", mm * off);
    snprintf(a->text[2], sizeof a->text[2], "of it: stand-in of the normal %.3g, crossings %.3g, degree limit %.3g",
             mm * r->stand_in_error, mm * r->crossing_error, mm * r->fit_tolerance);
}

// Many readers keep entity numbers in 32 bits: what can never fit is refused before anything is composed.
static kn_status take_report(kn_ctx *ctx, step *s, const kn_job_report *report)
{
    kn_status status = kn_announced_take(ctx, &s->announced, report, "STEP");
    if (status != KN_OK) return status;
    describe(s, report);
    // hidden faces of volumes are not written, and limited patches are only estimated
    uint64_t points = report->volumes > 0 || report->fit_degree > 0 ? 0 : report->control_points;
    if (points < INT_MAX && report->patches <= (INT_MAX - points) / ENTITIES) return KN_OK;
    return kn_fail(ctx, KN_ELIMIT, "STEP: %zu patches of degree %d,%d need entity numbers beyond %d", report->patches,
                   report->degree[0], report->degree[1], INT_MAX);
}

static kn_status step_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    step *s = user;
    kn_text text = {.ctx = ctx};
    kn_status status = take_report(ctx, s, report);
    if (status == KN_OK) status = kn_step_join_begin(ctx, &s->join, tile, s->unit_mm);
    if (status == KN_OK && s->instances) status = kn_step_cells_create(ctx, &s->cells, &s->join);
    if (status == KN_OK) {
        kn_step_put_header(&text, &s->about);
        kn_step_join_put_begin(&s->join, &text);
        status = kn_out_flush(ctx, s->file, &text);
    }
    kn_text_clear(&text);
    return status;
}

// ---- blocks ----

typedef struct writing {
    const step *s;
    written *w;
} writing;

static kn_status put_face(void *user, const kn_patch *patch)
{
    const step *s = ((writing *)user)->s;
    written *w = ((writing *)user)->w;
    kn_step_item *item = &w->items[w->nitems];
    size_t begin = w->text.bytes;
    kn_status status = kn_patch_nvars(patch) == 1 ? kn_step_put_curve(&w->text, item, patch, s->unit_mm)
                                                  : kn_step_put_face(&w->text, item, &w->lists, patch, s->unit_mm);
    if (status == KN_OK && s->instances)
        status = kn_step_note_points(w->text.ctx, &w->points, item, patch, s->unit_mm);
    item->text_begin = begin;
    w->nitems++;
    return status;
}

static void step_discard(kn_ctx *ctx, void *user, void *product)
{
    (void)user;
    written *w = product;
    if (w == NULL) return;
    w->text.ctx = ctx; // the worker's own context may be gone
    kn_text_clear(&w->text);
    kn_free(ctx, w->items), kn_free(ctx, w->points.x);
    kn_free(ctx, w->lists.loops), kn_free(ctx, w->lists.edges), kn_free(ctx, w->lists.pairs);
    kn_free(ctx, w);
}

static kn_status step_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    const step *s = user;
    size_t most = 0;
    for (size_t i = 0; i < block->count; i++) most += kn_patch_nvars(&block->patches[i]) == 3 ? 6 : 1;
    written *w = kn_alloc_zero(worker, 1, sizeof *w);
    if (w == NULL) return KN_ENOMEM;
    w->text.ctx = worker;
    w->items = kn_alloc(worker, most, sizeof *w->items);
    kn_status status = w->items != NULL ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < block->count && status == KN_OK; i++) {
        const kn_patch *patch = &block->patches[i];
        uint64_t place = (uint64_t)block->first + i;
        status = kn_announced_check(worker, &s->announced, patch, place, s->join.nlooks, "STEP");
        if (status == KN_OK) status = kn_announced_each_face(worker, patch, put_face, &(writing){s, w});
    }
    if (status == KN_OK) status = kn_text_fit(&w->text);
    if (status != KN_OK) {
        step_discard(worker, user, w);
        return status;
    }
    *product = w;
    return KN_OK;
}

static kn_status step_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    step *s = user;
    const written *w = product;
    kn_text text = {.ctx = ctx};
    kn_status status = KN_OK;
    (void)block;
    for (size_t i = 0; i < w->nitems && status == KN_OK; i++) {
        const kn_step_item *item = &w->items[i];
        size_t end = i + 1 < w->nitems ? w->items[i + 1].text_begin : w->text.bytes;
        status = s->cells ? kn_step_cells_add(ctx, s->cells, &text, item, w->text.data, end, w->points.x)
                          : kn_step_join_item(ctx, &s->join, &text, item, &w->lists, w->text.data);
        if (status == KN_OK && text.bytes > FLUSH_BYTES) status = kn_out_flush(ctx, s->file, &text);
    }
    if (status == KN_OK) status = kn_out_flush(ctx, s->file, &text);
    kn_text_clear(&text);
    step_discard(ctx, user, product);
    return status;
}

// ---- end ----

typedef struct ending {
    kn_ctx *ctx;
    step *s;
} ending;

static kn_status empty(void *user, kn_text *text)
{
    ending *e = user;
    return kn_out_flush(e->ctx, e->s->file, text);
}

static kn_status step_end(kn_ctx *ctx, void *user)
{
    step *s = user;
    kn_text text = {.ctx = ctx};
    kn_status status = s->cells ? kn_step_cells_end(ctx, s->cells, &text) : KN_OK;
    if (status == KN_OK) status = kn_step_join_end(ctx, &s->join, &text, empty, &(ending){ctx, s});
    kn_text_put(&text, "ENDSEC;\nEND-ISO-10303-21;\n");
    if (status == KN_OK) status = kn_out_flush(ctx, s->file, &text);
    if (status == KN_OK) status = kn_out_commit(ctx, s->file);
    kn_text_clear(&text);
    return status;
}

static void step_close(kn_ctx *ctx, void *user)
{
    step *s = user;
    kn_out_close(ctx, s->file);
    kn_step_cells_destroy(ctx, s->cells);
    kn_step_join_clear(ctx, &s->join);
    kn_free(ctx, s->about.product);
    kn_free(ctx, s->about.time_stamp);
    kn_naming_clear(ctx, &s->naming);
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
    kn_step_join_save(&s->join, &state);
    return kn_state_give(&state, data, bytes, status);
}

static kn_status step_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                              const unsigned char *data, size_t bytes)
{
    step *s = user;
    kn_state_reader r = {data, bytes};
    kn_status status = take_report(ctx, s, report);
    if (status == KN_OK) status = kn_step_join_begin(ctx, &s->join, tile, s->unit_mm);
    if (status == KN_OK) status = kn_out_restore(ctx, s->file, &r);
    if (status == KN_OK) status = kn_step_join_restore(ctx, &s->join, &r);
    return status == KN_OK && r.bytes > 0 ? kn_state_fail(ctx, "STEP") : status;
}

static void step_forget(void *user)
{
    step *s = user;
    kn_out_forget(s->file);
}

static kn_status copy_options(kn_ctx *ctx, step *s, const kn_step_options *o)
{
    kn_step_about *about = &s->about;
    s->unit_mm = o->unit_mm > 0.0 ? o->unit_mm : 1.0;
    about->uncertainty_mm = o->uncertainty_mm > 0.0 ? o->uncertainty_mm : 1e-3;
    about->schema = o->schema;
    s->instances = o->instances;
    s->join.host = o->host, s->join.about = about, s->join.naming = &s->naming;
    kn_status status = copy_string(ctx, &about->product, o->product != NULL ? o->product : "knurl");
    if (status == KN_OK)
        status = copy_string(ctx, &about->time_stamp, o->time_stamp != NULL ? o->time_stamp : "1970-01-01T00:00:00");
    if (status == KN_OK) status = kn_naming_init(ctx, &s->naming, o->surface_names, o->nsurfaces, o->plain_names);
    return status;
}

kn_status kn_step_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_step_options *options)
{
    kn_step_options o = options != NULL ? *options : (kn_step_options){0};
    if (!(o.unit_mm >= 0.0 && o.unit_mm < 1e12 && o.uncertainty_mm >= 0.0 && o.uncertainty_mm < 1e12))
        return kn_fail(ctx, KN_EDOMAIN, "STEP: unit %g mm, uncertainty %g mm", o.unit_mm, o.uncertainty_mm);
    if ((int)o.schema < 0 || o.schema > KN_STEP_AP203 || o.nsurfaces < 0)
        return kn_fail(ctx, KN_EDOMAIN, "STEP: schema %d, %d names of surfaces", (int)o.schema, o.nsurfaces);
    if (o.instances && o.schema == KN_STEP_AP203)
        return kn_fail(ctx, KN_EDOMAIN, "STEP: instances: AP203 controls each part of an assembly: AP214 or AP242");
    step *s = kn_alloc_zero(ctx, 1, sizeof *s);
    if (s == NULL) return KN_ENOMEM;
    kn_status status = copy_options(ctx, s, &o);
    if (status == KN_OK) status = kn_out_open(ctx, &s->file, path);
    if (status == KN_OK && o.filter) status = kn_out_set_filter(ctx, s->file, o.filter);
    if (status != KN_OK) {
        step_close(ctx, s);
        return status;
    }
    *out = (kn_sink){s,          step_begin, step_work, step_commit,  step_discard, step_end,
                     step_close, step_bytes, step_save, step_restore, step_forget};
    if (o.instances) out->save = NULL, out->restore = NULL;
    return KN_OK;
}
