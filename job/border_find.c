// SPDX-License-Identifier: Apache-2.0
// What of the border of a trimmed surface is near a box, and on which side of it places are.
#include "job/border.h"

#include <math.h>

bool kn_job_is_bordered(const kn_job *job, int surface)
{
    return job->borders && job->borders->trims[job->surfaces[surface].origin].nloops > 0;
}

// Whether a segment may touch the box: neither an axis nor the segment's own normal separates them by `off`.
static bool touches(const kn_job_segment *s, const double lo[2], const double hi[2], double off)
{
    double side[4], a = s->to[0] - s->from[0], b = s->to[1] - s->from[1], margin = off * (fabs(a) + fabs(b));
    for (int d = 0; d < 2; d++)
        if (fmax(s->from[d], s->to[d]) + off < lo[d] || fmin(s->from[d], s->to[d]) - off > hi[d]) return false;
    for (int k = 0; k < 4; k++)
        side[k] = a * ((k / 2 == 0 ? lo : hi)[1] - s->from[1]) - b * ((k % 2 == 0 ? lo : hi)[0] - s->from[0]);
    bool left = true, right = true;
    for (int k = 0; k < 4; k++) left = left && side[k] > margin, right = right && side[k] < -margin;
    return !left && !right;
}

static int column(const kn_job_border_list *b, double x)
{
    return (int)fmin(fmax(floor(x) - b->first, 0.0), b->ncolumns - 1);
}

size_t kn_job_border_take(kn_job_segment *out, size_t room, const kn_job *job, int surface, const double lo[2],
                          const double hi[2])
{
    size_t n = 0;
    if (!kn_job_is_bordered(job, surface)) return 0;
    const kn_job_border_list *b = &job->borders->surfaces[surface];
    int first = column(b, lo[0]), last = column(b, hi[0]);
    for (int k = first; k <= last; k++)
        for (size_t i = b->start[k]; i < b->start[k + 1]; i++) {
            const kn_job_segment *s = &b->list[b->index[i]];
            int begins = column(b, fmin(s->from[0], s->to[0]) - b->off);
            if (k != (begins > first ? begins : first) || !touches(s, lo, hi, b->off)) continue;
            if (n < room) out[n] = *s;
            n++;
        }
    return n;
}

bool kn_job_border_touches(const kn_job *job, int surface, const double lo[2], const double hi[2])
{
    return kn_job_border_take(NULL, 0, job, surface, lo, hi) > 0;
}

kn_status kn_job_border_side(kn_ctx *ctx, kn_answer *out, const kn_job *job, int surface, const double x[2])
{
    const kn_job_surface *s = &job->surfaces[surface];
    *out = KN_YES;
    if (!kn_job_is_bordered(job, surface)) return KN_OK;
    double uv[2];
    for (int d = 0; d < 2; d++) {
        double at = s->closed[d] ? x[d] - s->cells[d] * floor(x[d] / s->cells[d]) : x[d];
        at = fmin(fmax(at, 0.0), s->cells[d]);
        int cell = (int)fmin(floor(at), s->cells[d] - 1);
        double from = s->lines[d][cell], to = s->lines[d][cell + 1], first = s->lines[d][0];
        double part = (from + (at - cell) * (to - from) - first) / (s->lines[d][s->cells[d]] - first);
        uv[d] = fmin(s->box[0][d] + part * (s->box[1][d] - s->box[0][d]), 1.0);
    }
    return kn_trim_contains(ctx, out, &job->borders->trims[s->origin], uv);
}

kn_status kn_job_border_cell(kn_ctx *ctx, kn_answer *out, kn_job_border_memo *memo, const kn_job *job, int surface,
                             const int cell[2])
{
    const double lo[2] = {cell[0], cell[1]}, hi[2] = {cell[0] + 1.0, cell[1] + 1.0};
    *out = KN_YES;
    if (!kn_job_is_bordered(job, surface)) return KN_OK;
    kn_status status = KN_OK;
    if (kn_job_border_touches(job, surface, lo, hi)) {
        *out = KN_UNKNOWN;
    } else if (memo->surface == surface && memo->answer != KN_UNKNOWN && memo->cell[0] == cell[0] &&
               memo->cell[1] == cell[1] - 1) {
        *out = memo->answer; // no border in either of two neighbours: none between them
    } else {
        const double middle[2] = {cell[0] + 0.5, cell[1] + 0.5};
        status = kn_job_border_side(ctx, out, job, surface, middle);
    }
    *memo = (kn_job_border_memo){surface, {cell[0], cell[1]}, *out};
    return status;
}
