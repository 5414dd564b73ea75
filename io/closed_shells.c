// SPDX-License-Identifier: Apache-2.0
// Closed shells of bodies, and solids.
#include "io/closed_shells.h"

#include "kernel/context.h"

#include <stdlib.h>
#include <string.h>

void kn_closed_shells_clear(kn_ctx *ctx, kn_closed_shells *s)
{
    kn_free(ctx, s->list);
    *s = (kn_closed_shells){0};
}

kn_status kn_closed_shells_add(kn_ctx *ctx, kn_closed_shells *s, kn_closed_shell shell)
{
    if (s->n == s->room) {
        size_t room = 2 * s->room + 16;
        kn_closed_shell *more = kn_resize(ctx, s->list, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        s->list = more, s->room = room;
    }
    shell.place = s->n;
    s->list[s->n++] = shell;
    return KN_OK;
}

static int by_body(const void *a, const void *b)
{
    const kn_closed_shell *x = a, *y = b;
    if (x->body != y->body) return x->body < y->body ? -1 : 1;
    if ((x->shell == 0) != (y->shell == 0)) return x->shell == 0 ? -1 : 1;
    return x->place < y->place ? -1 : x->place > y->place;
}

void kn_closed_shells_sort(kn_closed_shells *s)
{
    if (s->n > 0) qsort(s->list, s->n, sizeof *s->list, by_body);
}

bool kn_closed_shells_next(const kn_closed_shells *s, size_t *at, size_t *n)
{
    const kn_closed_shell *list = s->list;
    size_t i = *at + *n;
    while (i < s->n && list[i].shell != 0) i++;
    if (i == s->n) return false;
    size_t end = i + 1;
    bool one = (i == 0 || list[i - 1].body != list[i].body);
    one = one && !(end < s->n && list[end].body == list[i].body && list[end].shell == 0);
    while (one && end < s->n && list[end].body == list[i].body) end++;
    *at = i, *n = end - i;
    return true;
}

void kn_closed_shells_save(const kn_closed_shells *s, kn_state *state)
{
    kn_state_put_block(state, s->list, s->n * sizeof *s->list);
}

kn_status kn_closed_shells_restore(kn_ctx *ctx, kn_closed_shells *s, kn_state_reader *r, const char *format)
{
    size_t bytes = 0;
    const void *from = kn_state_take_block(r, &bytes);
    if (!from || bytes % sizeof *s->list != 0) return kn_state_fail(ctx, format);
    kn_closed_shells fresh = {.n = bytes / sizeof *s->list, .room = bytes / sizeof *s->list};
    if (bytes > 0) {
        fresh.list = kn_alloc(ctx, fresh.n, sizeof *fresh.list);
        if (!fresh.list) return KN_ENOMEM;
        memcpy(fresh.list, from, bytes);
    }
    kn_closed_shells_clear(ctx, s);
    *s = fresh;
    return KN_OK;
}
