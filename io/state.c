// SPDX-License-Identifier: Apache-2.0
// States as bytes.
#include "io/state.h"
#include "kernel/context.h"

#include <string.h>

void kn_state_put(kn_state *s, const void *data, size_t bytes)
{
    if (s->failed || bytes == 0) return;
    if (bytes > s->room - s->bytes) {
        size_t room = 2 * s->room > s->bytes + bytes ? 2 * s->room : s->bytes + bytes + 64;
        unsigned char *larger = kn_resize(s->ctx, s->data, room, 1);
        s->failed = larger == NULL;
        if (s->failed) return;
        s->data = larger;
        s->room = room;
    }
    memcpy(s->data + s->bytes, data, bytes);
    s->bytes += bytes;
}

void kn_state_put_block(kn_state *s, const void *data, size_t bytes)
{
    kn_state_put(s, &bytes, sizeof bytes);
    kn_state_put(s, data, bytes);
}

bool kn_state_take(kn_state_reader *r, void *to, size_t bytes)
{
    if (bytes > r->bytes) return false;
    if (bytes > 0) memcpy(to, r->data, bytes);
    r->data += bytes;
    r->bytes -= bytes;
    return true;
}

const void *kn_state_take_block(kn_state_reader *r, size_t *bytes)
{
    size_t n;
    if (!kn_state_take(r, &n, sizeof n) || n > r->bytes) return NULL;
    const void *block = r->data;
    r->data += n;
    r->bytes -= n;
    *bytes = n;
    return block;
}

kn_status kn_state_give(kn_state *s, unsigned char **data, size_t *bytes, kn_status status)
{
    if (status == KN_OK && s->failed) status = KN_ENOMEM;
    if (status == KN_OK) {
        *data = s->data;
        *bytes = s->bytes;
    } else {
        kn_free(s->ctx, s->data);
    }
    s->data = NULL;
    return status;
}

kn_status kn_state_fail(kn_ctx *ctx, const char *kind)
{
    return kn_fail(ctx, KN_EDOMAIN, "%s: the interrupted run had another sink, or its state is damaged", kind);
}
