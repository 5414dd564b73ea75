// SPDX-License-Identifier: Apache-2.0
// The faces of one part of a STEP file, in few bytes.
#include "io/step_runs.h"
#include "kernel/context.h"

enum { MOST = 10 }; // bytes of one number of 64 bits

static void put(kn_step_runs *r, uint64_t x)
{
    for (; x > 127; x >>= 7) r->data[r->bytes++] = (unsigned char)(x | 128);
    r->data[r->bytes++] = (unsigned char)x;
}

static uint64_t take(const kn_step_runs *r, size_t *at)
{
    uint64_t x = 0;
    for (int shift = 0; *at < r->bytes; shift += 7) {
        uint64_t byte = r->data[(*at)++];
        x |= (byte & 127) << shift;
        if (byte < 128 || shift == 63) break;
    }
    return x;
}

static kn_status end_times(kn_ctx *ctx, kn_step_runs *r)
{
    if (r->times == 0) return KN_OK;
    if (r->room - r->bytes < 3 * MOST) {
        size_t room = 2 * r->room + 64;
        unsigned char *larger = kn_resize(ctx, r->data, room, 1);
        if (larger == NULL) return KN_ENOMEM;
        r->data = larger, r->room = room;
    }
    put(r, r->skip), put(r, r->count), put(r, r->times);
    r->times = 0;
    return KN_OK;
}

// The run that grew is whole: one more like the ones before it, or another one.
static kn_status end_run(kn_ctx *ctx, kn_step_runs *r, uint64_t stride)
{
    uint64_t count = r->grows_count, skip = r->grows_from - r->last;
    if (count == 0) return KN_OK;
    if (r->times == 0 || skip != r->skip || count != r->count) {
        kn_status status = end_times(ctx, r);
        if (status != KN_OK) return status;
        r->skip = skip, r->count = count;
    }
    r->times++;
    r->last = r->grows_from + (count - 1) * stride;
    r->grows_count = 0;
    return KN_OK;
}

kn_status kn_step_runs_add(kn_ctx *ctx, kn_step_runs *runs, uint64_t number, uint64_t stride)
{
    if (runs->grows_count > 0 && runs->grows_from + runs->grows_count * stride == number) {
        runs->grows_count++;
        return KN_OK;
    }
    kn_status status = end_run(ctx, runs, stride);
    if (status != KN_OK) return status;
    runs->grows_from = number, runs->grows_count = 1;
    return KN_OK;
}

kn_status kn_step_runs_end(kn_ctx *ctx, kn_step_runs *runs, uint64_t stride)
{
    kn_status status = end_run(ctx, runs, stride);
    return status == KN_OK ? end_times(ctx, runs) : status;
}

void kn_step_runs_clear(kn_ctx *ctx, kn_step_runs *runs)
{
    kn_free(ctx, runs->data);
    *runs = (kn_step_runs){0};
}

bool kn_step_runs_next(uint64_t *number, kn_step_place *place, const kn_step_runs *runs, uint64_t stride)
{
    if (place->left > 0) {
        place->left--;
        *number = place->number += stride;
        return true;
    }
    if (place->times == 0) {
        if (place->at >= runs->bytes) return false;
        place->skip = take(runs, &place->at);
        place->count = take(runs, &place->at);
        place->times = take(runs, &place->at);
        if (place->count == 0 || place->times == 0) return false; // not what add wrote
    }
    place->times--;
    place->left = place->count - 1;
    *number = place->number += place->skip;
    return true;
}
