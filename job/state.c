// SPDX-License-Identifier: Apache-2.0
// What a run is noted as between two commits: which job, how far, and the sinks.
#include "job/border.h"
#include "job/looks.h"
#include "job/run.h"
#include "kernel/hash.h"

#include <string.h>

// ---- identity ----

static void take(uint64_t *h, uint64_t x)
{
    *h = kn_hash_mix(*h * 0x9e3779b97f4a7c15u + x);
}

static void take_numbers(uint64_t *h, const double *x, size_t n)
{
    take(h, n);
    for (size_t i = 0; x && i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &x[i], sizeof bits);
        take(h, bits);
    }
}

static void take_spline(uint64_t *h, const kn_spline *s)
{
    take(h, (uint64_t)s->nvars << 8 | (uint64_t)s->ncomp);
    if (!s->coef) return;
    for (int v = 0; v < s->nvars; v++) {
        take(h, (uint64_t)s->degree[v]);
        take_numbers(h, s->knots[v], (size_t)(s->count[v] + s->degree[v] + 1));
    }
    take_numbers(h, s->coef, (size_t)s->ncomp * kn_spline_count(s));
}

static void take_surface(uint64_t *h, const kn_job_surface *s)
{
    take_spline(h, kn_shell_surface(s->shell));
    take_spline(h, kn_shell_normal(s->shell));
    take(h, (uint64_t)s->body);
    for (int v = 0; v < 2; v++) take_numbers(h, s->lines[v], (size_t)s->cells[v] + 1);
    take_numbers(h, s->jacobian, 2); // of T with its fields
}

static void take_borders(uint64_t *h, const struct kn_job_borders *b)
{
    for (int i = 0; i < b->ntrims; i++) {
        take(h, (uint64_t)b->trims[i].nloops);
        for (int k = 0; k < b->trims[i].ncurves; k++) take_spline(h, &b->trims[i].curves[k]);
    }
}

uint64_t kn_job_identity(const kn_job *job, uint64_t own)
{
    const kn_job_options *o = &job->options;
    uint64_t h = own;
    const double numbers[] = {o->height, o->offset, o->normal_tol, o->taper, o->crossing_tol, o->mesh_tol};
    take_numbers(&h, numbers, sizeof numbers / sizeof *numbers);
    take(&h, (uint64_t)o->side << 32 | (uint64_t)o->normal << 16 | (uint64_t)o->crossing << 8 |
                 (uint64_t)o->equal_edges << 1 | o->symbolic);
    take(&h, (uint64_t)job->segments << 8 | (uint64_t)o->trimmed);
    if (job->borders) take_borders(&h, job->borders);
    for (int s = 0; s < job->nsurfaces; s++) take_surface(&h, &job->surfaces[s]);
    for (int k = 0; k < job->npatches; k++) {
        const kn_bezier *d = &job->patches[k].d;
        take(&h, (uint64_t)job->patches[k].part << 32 | (uint64_t)job->patches[k].patch);
        take_numbers(&h, d->coef, (size_t)d->ncomp * kn_bezier_count(d));
    }
    for (int p = 0; job->looks && p < job->looks->tile.nparts; p++)
        take_numbers(&h, job->looks->tile.parts[p].material.base_color, 3);
    take(&h, job->keys.count);
    take(&h, job->lists.nrefs);
    for (size_t i = 0; i < job->nalike; i++) {
        take(&h, job->alike[i].first_cell);
        take(&h, (uint64_t)job->alike[i].list << 32 ^ job->alike[i].npatches ^ job->alike[i].numbers << 8);
    }
    take(&h, job->report.patches);
    take(&h, job->report.control_points);
    return h;
}

// ---- bytes ----

enum { WORDS = 5 };
static const uint64_t version = 0x6b6e75726c000001u;

// Of the bytes that follow it.
static uint64_t checksum(const unsigned char *data, size_t bytes)
{
    uint64_t h = bytes;
    for (size_t i = 0; i < bytes; i++) h = (h ^ data[i]) * 0x100000001b3u;
    return kn_hash_mix(h);
}

kn_status kn_job_save_state(kn_ctx *ctx, unsigned char **data, size_t *bytes, const kn_job_state *state,
                            kn_sink *sinks, int nsinks)
{
    uint64_t head[WORDS] = {0, version, state->identity, state->done, state->nblocks};
    size_t size = sizeof head;
    unsigned char *all = kn_alloc(ctx, size, 1);
    kn_status status = all ? KN_OK : KN_ENOMEM;
    for (int k = 0; status == KN_OK && k < nsinks; k++) {
        unsigned char *own = NULL, *larger = NULL;
        uint64_t length = 0;
        size_t n = 0;
        status = sinks[k].save(ctx, sinks[k].user, &own, &n);
        if (status == KN_OK) larger = kn_resize(ctx, all, size + sizeof length + n, 1);
        if (status == KN_OK && !larger) status = KN_ENOMEM;
        if (status == KN_OK) {
            all = larger;
            length = n;
            memcpy(all + size, &length, sizeof length);
            if (n > 0) memcpy(all + size + sizeof length, own, n);
            size += sizeof length + n;
        }
        kn_free(ctx, own);
    }
    if (status != KN_OK) {
        kn_free(ctx, all);
        return status;
    }
    memcpy(all, head, sizeof head);
    head[0] = checksum(all + sizeof *head, size - sizeof *head);
    memcpy(all, head, sizeof *head);
    *data = all;
    *bytes = size;
    return KN_OK;
}

static kn_status check_head(kn_ctx *ctx, const kn_job_state *state, const uint64_t head[WORDS])
{
    if (head[0] != checksum(state->data + sizeof *head, state->bytes - sizeof *head) || head[1] != version)
        return kn_fail(ctx, KN_EDOMAIN, "job: the state of the interrupted run is damaged, or of another version");
    if (head[2] != state->identity || head[4] != state->nblocks || head[3] > head[4])
        return kn_fail(ctx, KN_EDOMAIN, "job: the interrupted run was another job: remove its state to begin anew");
    return KN_OK;
}

kn_status kn_job_restore_state(kn_ctx *ctx, kn_job_state *state, const kn_job *job, kn_sink *sinks, int nsinks)
{
    uint64_t head[WORDS], length;
    size_t at = sizeof head;
    if (state->bytes < sizeof head) return kn_fail(ctx, KN_EDOMAIN, "job: no state of a run");
    memcpy(head, state->data, sizeof head);
    kn_status status = check_head(ctx, state, head);
    for (int k = 0; status == KN_OK && k < nsinks; k++) {
        bool there = state->bytes - at >= sizeof length;
        if (there) memcpy(&length, state->data + at, sizeof length);
        at += sizeof length;
        if (!there || length > state->bytes - at)
            return kn_fail(ctx, KN_EDOMAIN, "job: the interrupted run had %d sinks, not %d", k, nsinks);
        status = sinks[k].restore(ctx, sinks[k].user, kn_job_look_tile(job), &job->report, state->data + at,
                                  (size_t)length);
        at += (size_t)length;
    }
    if (status == KN_OK && at != state->bytes)
        status = kn_fail(ctx, KN_EDOMAIN, "job: the interrupted run had more than %d sinks", nsinks);
    if (status == KN_OK) state->done = (size_t)head[3];
    return status;
}
