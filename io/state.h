// SPDX-License-Identifier: Apache-2.0
// Inside io: the state of a sink as bytes, for the same machine.
#ifndef IO_STATE_H
#define IO_STATE_H

#include <knurl/base.h>

typedef struct kn_state {
    kn_ctx *ctx;
    unsigned char *data;
    size_t bytes, room;
    bool failed; // out of memory: nothing more is put
} kn_state;
void kn_state_put(kn_state *state, const void *data, size_t bytes);

// Reads from the front.
typedef struct kn_state_reader {
    const unsigned char *data;
    size_t bytes;
} kn_state_reader;
bool kn_state_take(kn_state_reader *reader, void *to, size_t bytes); // false: there are not so many
// What put wrote with its length before it: NULL where that is not there. *bytes of it.
const void *kn_state_take_block(kn_state_reader *reader, size_t *bytes);
void kn_state_put_block(kn_state *state, const void *data, size_t bytes);

// What a sink's save answers: *data, for kn_free, where status and the state are well; else it is freed.
KN_CHECKED kn_status kn_state_give(kn_state *state, unsigned char **data, size_t *bytes, kn_status status);
// KN_EDOMAIN: the state is not that of a sink of this kind.
KN_CHECKED kn_status kn_state_fail(kn_ctx *ctx, const char *kind);

#endif
