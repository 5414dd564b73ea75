// SPDX-License-Identifier: Apache-2.0
// Lists of pieces of contours.
#include "slice/internal.h"

#include <math.h>
#include <string.h>

void kn_slice_lines_clear(kn_ctx *ctx, kn_slice_lines *lines)
{
    kn_free(ctx, lines->points);
    kn_free(ctx, lines->list);
    kn_free(ctx, lines->notes);
    *lines = (kn_slice_lines){0};
}

static kn_status reserve_points(kn_ctx *ctx, kn_slice_lines *l, size_t more)
{
    if (l->npoints + more <= l->point_room) return KN_OK;
    size_t room = 2 * l->point_room > l->npoints + more ? 2 * l->point_room : l->npoints + more + 64;
    double *points = kn_resize(ctx, l->points, 2 * room, sizeof *points);
    if (!points) return KN_ENOMEM;
    l->points = points;
    l->point_room = room;
    return KN_OK;
}

static kn_status reserve_lines(kn_ctx *ctx, kn_slice_lines *l, size_t more)
{
    if (l->nlines + more <= l->line_room) return KN_OK;
    size_t room = 2 * l->line_room > l->nlines + more ? 2 * l->line_room : l->nlines + more + 16;
    kn_slice_line *list = kn_resize(ctx, l->list, room, sizeof *list);
    if (!list) return KN_ENOMEM;
    l->list = list;
    l->line_room = room;
    return KN_OK;
}

kn_status kn_slice_begin_line(kn_ctx *ctx, kn_slice_lines *l, size_t plane, const kn_patch_id *id)
{
    kn_status status = reserve_lines(ctx, l, 1);
    if (status == KN_OK)
        l->list[l->nlines++] = (kn_slice_line){plane, l->npoints, 0, id->part, id->layer, {false, false}};
    return status;
}

kn_status kn_slice_add_point(kn_ctx *ctx, kn_slice_lines *l, double x, double y)
{
    kn_slice_line *line = &l->list[l->nlines - 1];
    x += 0.0, y += 0.0; // no -0: ends are compared by their bits
    if (line->n > 0 && l->points[2 * l->npoints - 2] == x && l->points[2 * l->npoints - 1] == y) return KN_OK;
    kn_status status = reserve_points(ctx, l, 1);
    if (status != KN_OK) return status;
    l->points[2 * l->npoints] = x;
    l->points[2 * l->npoints + 1] = y;
    l->npoints++;
    line->n++;
    return KN_OK;
}

kn_status kn_slice_add_note(kn_ctx *ctx, kn_slice_lines *l, size_t plane, size_t doubtful, double error)
{
    if (l->nnotes == 0 || l->notes[l->nnotes - 1].plane != plane) {
        if (l->nnotes == l->note_room) {
            size_t room = 2 * l->note_room + 16;
            kn_slice_note *notes = kn_resize(ctx, l->notes, room, sizeof *notes);
            if (!notes) return KN_ENOMEM;
            l->notes = notes;
            l->note_room = room;
        }
        l->notes[l->nnotes++] = (kn_slice_note){plane, 0, 0.0};
    }
    kn_slice_note *note = &l->notes[l->nnotes - 1];
    note->doubtful += doubtful;
    note->error = fmax(note->error, error);
    return KN_OK;
}

kn_status kn_slice_append(kn_ctx *ctx, kn_slice_lines *a, const kn_slice_lines *b)
{
    kn_status status = reserve_points(ctx, a, b->npoints);
    if (status == KN_OK) status = reserve_lines(ctx, a, b->nlines);
    if (status != KN_OK) return status;
    if (b->npoints > 0) memcpy(a->points + 2 * a->npoints, b->points, 2 * b->npoints * sizeof *b->points);
    for (size_t i = 0; i < b->nlines; i++) {
        kn_slice_line line = b->list[i];
        line.first += a->npoints;
        a->list[a->nlines++] = line;
    }
    a->npoints += b->npoints;
    for (size_t i = 0; status == KN_OK && i < b->nnotes; i++)
        status = kn_slice_add_note(ctx, a, b->notes[i].plane, b->notes[i].doubtful, b->notes[i].error);
    return status;
}

double kn_slice_height(const kn_slice_options *o, size_t plane)
{
    return o->first + (double)plane * o->step;
}

void kn_slice_planes(const kn_slice_window *w, double lo, double hi, size_t *from, size_t *to)
{
    const kn_slice_options *o = &w->options;
    double a = ceil((lo - o->first) / o->step) - 1.0;
    *from = *to = w->end;
    if (!(a < (double)w->end)) return;
    *from = a > (double)w->first ? (size_t)a : w->first;
    while (*from < w->end && kn_slice_height(o, *from) <= lo) ++*from;
    for (*to = *from; *to < w->end && kn_slice_height(o, *to) <= hi;) ++*to;
}
