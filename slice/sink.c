// SPDX-License-Identifier: Apache-2.0
// A sink that cuts patches with planes.
#include "slice/internal.h"

#include <math.h>
#include <stdlib.h>

typedef struct slicer {
    kn_slice_window window;
    kn_slice_fn fn;
    void *user;
    kn_slice_lines lines;
    kn_slice_note *notes; // of each layer of the window
} slicer;

// The faces that are to be seen.
static kn_status cut_volume(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *w, const kn_patch *p)
{
    kn_status status = KN_OK;
    for (int face = 0; status == KN_OK && face < 6; face++) {
        kn_patch side = {0};
        if (p->hidden >> face & 1) continue;
        status = kn_patch_face(ctx, &side, p, face);
        if (status == KN_OK) status = kn_slice_patch(ctx, out, w, &p->id, &side.bezier, NULL, side.reversed);
        kn_bezier_clear(ctx, &side.bezier);
    }
    return status;
}

static kn_status cut_patch(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *w, const kn_patch *p)
{
    if (p->mesh) return kn_slice_mesh(ctx, out, w, &p->id, p->mesh);
    if (p->bezier.nvars == 3) return cut_volume(ctx, out, w, p);
    if (p->bezier.nvars != 2) return KN_OK; // curves have no inside
    return kn_slice_patch(ctx, out, w, &p->id, &p->bezier, p->trim, p->reversed);
}

static kn_status work(kn_ctx *ctx, void *user, const kn_patch_block *block, void **product)
{
    const slicer *s = user;
    kn_slice_lines *lines = kn_alloc_zero(ctx, 1, sizeof *lines);
    kn_status status = lines ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < block->count; i++)
        status = cut_patch(ctx, lines, &s->window, &block->patches[i]);
    if (status == KN_OK) {
        *product = lines;
    } else if (lines) {
        kn_slice_lines_clear(ctx, lines);
        kn_free(ctx, lines);
    }
    return status;
}

static void discard(kn_ctx *ctx, void *user, void *product)
{
    (void)user;
    kn_slice_lines_clear(ctx, product);
    kn_free(ctx, product);
}

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)block;
    slicer *s = user;
    const kn_slice_lines *lines = product;
    kn_status status = kn_slice_append(ctx, &s->lines, lines);
    for (size_t i = 0; i < lines->nnotes; i++) {
        kn_slice_note *note = &s->notes[lines->notes[i].plane - s->window.first];
        note->doubtful += lines->notes[i].doubtful;
        note->error = fmax(note->error, lines->notes[i].error);
    }
    discard(ctx, user, product);
    return status;
}

static kn_status begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)ctx, (void)tile;
    slicer *s = user;
    kn_slice_meet(&s->window, report);
    return KN_OK;
}

// By plane, and as they came within one.
static int by_plane(const void *a, const void *b)
{
    const kn_slice_line *x = a, *y = b;
    if (x->plane != y->plane) return x->plane < y->plane ? -1 : 1;
    return (x->first > y->first) - (x->first < y->first);
}

static kn_status end(kn_ctx *ctx, void *user)
{
    slicer *s = user;
    kn_slice_lines *l = &s->lines;
    kn_status status = KN_OK;
    if (l->nlines > 0) qsort(l->list, l->nlines, sizeof *l->list, by_plane);
    for (size_t plane = s->window.first, at = 0; status == KN_OK && plane < s->window.end; plane++) {
        size_t n = 0;
        while (at + n < l->nlines && l->list[at + n].plane == plane) n++;
        status = kn_slice_chain(ctx, l, n > 0 ? l->list + at : NULL, n, &s->window,
                                &s->notes[plane - s->window.first], s->fn, s->user);
        at += n;
    }
    return status;
}

static void close_sink(kn_ctx *ctx, void *user)
{
    slicer *s = user;
    kn_slice_lines_clear(ctx, &s->lines);
    kn_free(ctx, s->notes);
    kn_free(ctx, s);
}

kn_status kn_slice_check(kn_ctx *ctx, const kn_slice_options *o)
{
    if (!isfinite(o->first) || !(o->step > 0.0) || !isfinite(o->first + (double)o->count * o->step))
        return kn_fail(ctx, KN_EDOMAIN, "slice: layers from %g by %g", o->first, o->step);
    if (o->count < 1 || o->count > (size_t)1 << 20) return kn_fail(ctx, KN_EDOMAIN, "slice: %zu layers", o->count);
    if (!(o->tol > 0.0) || !isfinite(o->tol) || !(o->join >= 0.0) || !isfinite(o->join))
        return kn_fail(ctx, KN_EDOMAIN, "slice: tolerance %g, joining %g", o->tol, o->join);
    return KN_OK;
}

// Two sides of a seam have their own n, each within its certificate of the unit normal; of a knot line, pieces that
// agree to the error of the crossing.
void kn_slice_meet(kn_slice_window *w, const kn_job_report *report)
{
    double normal = report->normal.length_error + report->normal.angle_error;
    double apart = report->crossing_error + 2.0 * report->stand_in_error + 2.0 * fabs(report->height) * normal;
    if (isfinite(apart)) w->apart = fmax(w->apart, apart);
    w->crossing = w->crossing || report->crossing_error > 0.0;
}

double kn_slice_reach(const kn_slice_window *w)
{
    return w->options.join > 0.0 ? w->options.join : fmax(w->options.tol, 2.0 * w->apart);
}

kn_status kn_slice_window_sink(kn_ctx *ctx, kn_sink *out, const kn_slice_window *window, kn_slice_fn fn, void *user)
{
    slicer *s = kn_alloc_zero(ctx, 1, sizeof *s);
    size_t n = window->end - window->first;
    kn_slice_note *notes = kn_alloc(ctx, n, sizeof *notes);
    if (!s || !notes) {
        kn_free(ctx, s);
        kn_free(ctx, notes);
        return KN_ENOMEM;
    }
    for (size_t i = 0; i < n; i++) notes[i] = (kn_slice_note){.plane = window->first + i};
    *s = (slicer){.window = *window, .fn = fn, .user = user, .notes = notes};
    *out = (kn_sink){.user = s,
                     .begin = begin,
                     .work = work,
                     .commit = commit,
                     .discard = discard,
                     .end = end,
                     .close = close_sink};
    return KN_OK;
}

kn_status kn_slice_sink(kn_ctx *ctx, kn_sink *out, const kn_slice_options *options, kn_slice_fn fn, void *user)
{
    kn_status status = kn_slice_check(ctx, options);
    kn_slice_window all = {*options, 0, options->count, 0.0, false};
    return status == KN_OK ? kn_slice_window_sink(ctx, out, &all, fn, user) : status;
}
