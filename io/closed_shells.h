// SPDX-License-Identifier: Apache-2.0
// Inside io: closed shells of bodies whose other shells may still come, and the solids that they are in the end.
#ifndef IO_CLOSED_SHELLS_H
#define IO_CLOSED_SHELLS_H

#include <knurl/job.h>

#include "io/state.h"

typedef struct kn_closed_shell {
    int brep;        // its faces: a body of kn_brep
    int body, shell; // as kn_patch_bounds
    int look;        // of the patch that closed it, and which that is
    kn_patch_id id;
    size_t place; // the order in which they came
} kn_closed_shell;

typedef struct kn_closed_shells {
    kn_closed_shell *list;
    size_t n, room;
} kn_closed_shells;

void kn_closed_shells_clear(kn_ctx *ctx, kn_closed_shells *s);
KN_CHECKED kn_status kn_closed_shells_add(kn_ctx *ctx, kn_closed_shells *s, kn_closed_shell shell);
// Body by body, outer shells first; then solid after solid: shells *at .. *at + *n - 1 of the list, the outer one first.
// *at = *n = 0 before the first; false: no more. Voids belong to the one outer shell that their body has; where it has
// none, or several, they are left out.
void kn_closed_shells_sort(kn_closed_shells *s);
bool kn_closed_shells_next(const kn_closed_shells *s, size_t *at, size_t *n);
void kn_closed_shells_save(const kn_closed_shells *s, kn_state *state);
KN_CHECKED kn_status kn_closed_shells_restore(kn_ctx *ctx, kn_closed_shells *s, kn_state_reader *r,
                                              const char *format);

#endif
