// SPDX-License-Identifier: Apache-2.0
// How far from open ends of the base, and from borders of the mask and of trims, a place is: heights fall off there.
//
// Distances are shortest paths over the corners of cells, from each to its sixteen neighbours (a king's and a
// knight's moves), and over shared edges: along S, at most 2.8 % too long where cells are squares. Between corners
// they are bilinear. Only those below the taper's length are looked for. Source: Dijkstra, A note on two problems in
// connexion with graphs, Numer. Math. 1 (1959).
#include "job/border.h"
#include "job/vary.h"
#include "job/internal.h"

#include <math.h>
#include <string.h>

typedef struct entry {
    double distance;
    int surface;
    int at[2];
} entry;

typedef struct search {
    const kn_job *job;
    kn_job_taper *out;
    double **point; // of each surface: corners, 3 numbers each
    entry *heap;
    size_t count, room;
} search;

static size_t corner(const kn_job_surface *s, int i, int j)
{
    return (size_t)i * (size_t)(s->cells[1] + 1) + (size_t)j;
}

// ---- the heap: the nearest first, equals in the order of their places ----

static bool comes_first(const entry *a, const entry *b)
{
    if (a->distance != b->distance) return a->distance < b->distance;
    if (a->surface != b->surface) return a->surface < b->surface;
    return a->at[0] != b->at[0] ? a->at[0] < b->at[0] : a->at[1] < b->at[1];
}

// Takes a distance that is shorter than what the corner has.
static kn_status offer(kn_ctx *ctx, search *q, int surface, int i, int j, double distance)
{
    const kn_job_surface *s = &q->job->surfaces[surface];
    double *now = &q->out->distance[surface][corner(s, i, j)];
    if (!(distance < *now)) return KN_OK;
    *now = distance;
    if (q->count == q->room) {
        size_t room = q->room > 0 ? 2 * q->room : 256;
        entry *heap = kn_resize(ctx, q->heap, room, sizeof *heap);
        if (!heap) return KN_ENOMEM;
        q->heap = heap;
        q->room = room;
    }
    entry e = {distance, surface, {i, j}};
    size_t at = q->count++;
    for (; at > 0 && comes_first(&e, &q->heap[(at - 1) / 2]); at = (at - 1) / 2) q->heap[at] = q->heap[(at - 1) / 2];
    q->heap[at] = e;
    return KN_OK;
}

static entry take(search *q)
{
    entry first = q->heap[0], last = q->heap[--q->count];
    size_t at = 0;
    for (size_t child; (child = 2 * at + 1) < q->count; at = child) {
        if (child + 1 < q->count && comes_first(&q->heap[child + 1], &q->heap[child])) child++;
        if (!comes_first(&q->heap[child], &last)) break;
        q->heap[at] = q->heap[child];
    }
    q->heap[at] = last;
    return first;
}

// ---- where distance is 0 ----

// Nothing is there beyond it, or a surface that is not selected.
static bool is_open(const kn_job *job, const kn_job_surface *s, int d, int end)
{
    kn_shell_edge edges[2][2];
    int other = s->partner[2 * d + end].edge;
    kn_shell_edges(s->shell, edges);
    bool goes_on = other >= 0 && kn_job_selects(&job->options.select, job->surfaces[other / 4].origin);
    // a face that meets another one at an angle keeps its side
    if (job->options.trimmed == KN_TRIMMED_TAPER) goes_on = goes_on && s->partner[2 * d + end].goes_on;
    return !s->closed[d] && !goes_on && edges[d][end].kind == KN_EDGE_CURVE;
}

static kn_status offer_ends(kn_ctx *ctx, search *q, int surface)
{
    const kn_job_surface *s = &q->job->surfaces[surface];
    kn_status status = KN_OK;
    for (int d = 0; d < 2; d++)
        for (int end = 0; end < 2; end++) {
            int at[2];
            at[d] = end == 0 ? 0 : s->cells[d];
            if (!is_open(q->job, s, d, end)) continue;
            for (int k = 0; status == KN_OK && k <= s->cells[1 - d]; k++) {
                at[1 - d] = k;
                status = offer(ctx, q, surface, at[0], at[1], 0.0);
            }
        }
    return status;
}

// The mask at the cell's middle.
static kn_status in_mask(kn_ctx *ctx, bool *inside, const kn_job *job, int surface, const int cell[2])
{
    static const double middle[2] = {0.5, 0.5};
    const kn_field *mask = &job->options.select.mask;
    *inside = true;
    if (!mask->value) return KN_OK;
    kn_job_spot spot = kn_job_find_spot(job, surface, cell, middle);
    kn_place place;
    kn_status status = kn_job_fill_spot(ctx, &place, job, &spot, mask->needs);
    if (status == KN_OK) *inside = mask->value(mask->user, &place) > 0.5;
    return status;
}

// Where heights fall off towards trims, neither beyond the border nor where it runs through the cell: all that it
// crosses lies flat.
static kn_status in_trim(kn_ctx *ctx, bool *inside, kn_job_border_memo *memo, const kn_job *job, int surface,
                         const int cell[2])
{
    kn_answer answer = KN_YES;
    kn_status status = KN_OK;
    if (job->options.trimmed == KN_TRIMMED_TAPER) status = kn_job_border_cell(ctx, &answer, memo, job, surface, cell);
    *inside = answer == KN_YES;
    return status;
}

static kn_status offer_mask(kn_ctx *ctx, search *q, int surface)
{
    const kn_job_surface *s = &q->job->surfaces[surface];
    kn_job_border_memo memo = {.surface = -1};
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < s->cells[0]; i++)
        for (int j = 0; status == KN_OK && j < s->cells[1]; j++) {
            bool inside;
            status = in_trim(ctx, &inside, &memo, q->job, surface, (int[2]){i, j});
            if (status == KN_OK && inside) status = in_mask(ctx, &inside, q->job, surface, (int[2]){i, j});
            for (int k = 0; status == KN_OK && !inside && k < 4; k++)
                status = offer(ctx, q, surface, i + k % 2, j + k / 2, 0.0);
        }
    return status;
}

// ---- the search ----

static double apart(const double *p, const double *q)
{
    return sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
}

static kn_status visit(kn_ctx *ctx, search *q, const entry *e)
{
    static const int step[16][2] = {{1, 0}, {-1, 0}, {0, 1},  {0, -1},  {1, 1}, {1, -1}, {-1, 1}, {-1, -1},
                                    {1, 2}, {1, -2}, {-1, 2}, {-1, -2}, {2, 1}, {2, -1}, {-2, 1}, {-2, -1}};
    const kn_job_surface *s = &q->job->surfaces[e->surface];
    const double *point = q->point[e->surface];
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < 16; k++) {
        int i = e->at[0] + step[k][0], j = e->at[1] + step[k][1];
        if (i < 0 || j < 0 || i > s->cells[0] || j > s->cells[1]) continue;
        double way = apart(point + 3 * corner(s, e->at[0], e->at[1]), point + 3 * corner(s, i, j));
        if (e->distance + way < q->job->options.taper) status = offer(ctx, q, e->surface, i, j, e->distance + way);
    }
    kn_job_spot names[8], here = {e->surface, {e->at[0], e->at[1]}};
    int n = kn_job_spot_names(names, q->job, here, 8);
    for (int k = 1; status == KN_OK && k < n; k++)
        status = offer(ctx, q, names[k].surface, (int)names[k].x[0], (int)names[k].x[1], e->distance);
    return status;
}

static kn_status make_corners(kn_ctx *ctx, search *q, int surface)
{
    const kn_job_surface *s = &q->job->surfaces[surface];
    const size_t n[2] = {(size_t)s->cells[0] + 1, (size_t)s->cells[1] + 1};
    const double *lines[2] = {s->lines[0], s->lines[1]};
    q->point[surface] = kn_alloc(ctx, n[0] * n[1], 3 * sizeof(double));
    q->out->distance[surface] = kn_alloc(ctx, n[0] * n[1], sizeof(double));
    if (!q->point[surface] || !q->out->distance[surface]) return KN_ENOMEM;
    for (size_t i = 0; i < n[0] * n[1]; i++) q->out->distance[surface][i] = q->job->options.taper;
    return kn_spline_eval_grid(ctx, q->point[surface], kn_shell_surface(s->shell), n, lines);
}

kn_status kn_job_make_taper(kn_ctx *ctx, kn_job_taper *out, const kn_job *job)
{
    enum { AT_ONCE = 1 << 16 };
    search q = {.job = job, .out = out};
    size_t n = (size_t)job->nsurfaces;
    out->nsurfaces = job->nsurfaces;
    out->distance = kn_alloc_zero(ctx, n, sizeof *out->distance);
    q.point = kn_alloc_zero(ctx, n, sizeof *q.point);
    kn_status status = out->distance && q.point ? KN_OK : KN_ENOMEM;
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) status = make_corners(ctx, &q, s);
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) {
        status = offer_ends(ctx, &q, s);
        if (status == KN_OK) status = offer_mask(ctx, &q, s);
    }
    for (size_t k = 0; status == KN_OK && q.count > 0; k++) {
        entry e = take(&q);
        const kn_job_surface *s = &job->surfaces[e.surface];
        if (e.distance > out->distance[e.surface][corner(s, e.at[0], e.at[1])]) continue; // a shorter way came later
        status = visit(ctx, &q, &e);
        if (status == KN_OK && k % AT_ONCE == 0) status = kn_progress(ctx, "taper", 0.0);
    }
    for (int s = 0; q.point && s < job->nsurfaces; s++) kn_free(ctx, q.point[s]);
    kn_free(ctx, q.point);
    kn_free(ctx, q.heap);
    return status; // what is there of *out belongs to the caller
}

void kn_job_taper_clear(kn_ctx *ctx, kn_job_taper *taper)
{
    for (int s = 0; taper->distance && s < taper->nsurfaces; s++) kn_free(ctx, taper->distance[s]);
    kn_free(ctx, taper->distance);
    *taper = (kn_job_taper){0};
}

double kn_job_taper_at(const kn_job *job, const kn_job_spot *spot)
{
    const kn_job_surface *s = &job->surfaces[spot->surface];
    const double *distance = job->varying->taper.distance[spot->surface];
    double part[2], row[2];
    int cell[2];
    for (int d = 0; d < 2; d++) {
        cell[d] = (int)fmin(spot->x[d], s->cells[d] - 1);
        part[d] = spot->x[d] - cell[d];
    }
    for (int k = 0; k < 2; k++) {
        const double *at = distance + corner(s, cell[0] + k, cell[1]);
        row[k] = (1.0 - part[1]) * at[0] + part[1] * at[1];
    }
    double x = fmin(((1.0 - part[0]) * row[0] + part[0] * row[1]) / job->options.taper, 1.0);
    return x * x * (3.0 - 2.0 * x);
}
