// SPDX-License-Identifier: Apache-2.0
// Inside step: what threads wrote of the patches of a STEP file, put together in the job's order.
#ifndef STEP_JOIN_H
#define STEP_JOIN_H

#include "io/closed_shells.h"
#include "io/naming.h"
#include "step/write.h"

typedef struct kn_step_look {
    char name[KN_NAME_BYTES];
    kn_material material;
    int loose, curves; // bodies of the faces that meet nobody, and of the curves; KN_BREP_NONE: none yet
    bool used;         // something has its style
} kn_step_look;

typedef struct kn_step_join {
    kn_brep *brep;
    const kn_naming *naming;
    const kn_step_about *about;
    const kn_step_host *host; // or NULL
    int *held;                // bodies of its shells
    uint64_t origin;          // from which the fixed numbers count
    uint64_t next;            // number that is free
    kn_step_look *looks;
    int nlooks;
    int solids, styled; // lists of numbers
    int placed;         // list of the placements of instances, KN_BREP_NONE: there are none
    uint64_t nsolids, nstyled, nshells, ncurves;
    kn_closed_shells closed;
} kn_step_join;

// naming, about and host (NULL: none) are set before; mm: of a length unit.
// fails: KN_EDOMAIN (the host).
kn_status kn_step_join_begin(kn_ctx *ctx, kn_step_join *j, const kn_tile *tile, double mm);
// Entities that come before all others.
void kn_step_join_put_begin(const kn_step_join *j, kn_text *out);
void kn_step_join_clear(kn_ctx *ctx, kn_step_join *j);
// Appends one item to out: data has its text and that of its edges, from the end of the item before it on; lists: of a
// trimmed one. Where it closes a body, the solid follows. fails: KN_ENOMEM; KN_ELIMIT numbers that readers do not keep.
kn_status kn_step_join_item(kn_ctx *ctx, kn_step_join *j, kn_text *out, const kn_step_item *item,
                            const kn_step_lists *lists, const char *data);
// Shells that are open, curves, styles, the representations. put(user) empties the text where it has become long.
kn_status kn_step_join_end(kn_ctx *ctx, kn_step_join *j, kn_text *out, kn_status (*put)(void *user, kn_text *out),
                           void *user);
void kn_step_join_save(const kn_step_join *j, kn_state *state);
kn_status kn_step_join_restore(kn_ctx *ctx, kn_step_join *j, kn_state_reader *r);

// ---- what join.c, finish.c and instances.c share; put NULL: the text may become as long as it wants ----
uint64_t kn_step_look_number(const kn_step_join *j, int look); // first of a look's numbers
// "#number=" and the form, whose every '#' is the next one of the references.
void kn_step_put_references(kn_text *text, uint64_t number, const char *form, const uint64_t *references);
// "#1,#2,.." of a body's faces, or of a list.
kn_status kn_step_join_put_list(const kn_brep *brep, int body, kn_text *out,
                                kn_status (*put)(void *user, kn_text *out), void *user);
kn_status kn_step_join_style(kn_ctx *ctx, kn_step_join *j, kn_text *out, uint64_t item, int look);
kn_status kn_step_join_style_faces(kn_ctx *ctx, kn_step_join *j, kn_text *out, int body,
                                   kn_status (*put)(void *user, kn_text *out), void *user);
// The item, or where its faces have several looks each of them.
kn_status kn_step_join_style_body(kn_ctx *ctx, kn_step_join *j, kn_text *out, uint64_t item, int body);
// The edge, once all faces are known that use it: with what they call it in their own parameters.
void kn_step_join_put_edge(kn_step_join *j, kn_text *out, const kn_brep_name *name);
// A solid of closed shells of brep, the outer one first; it drops them.
kn_status kn_step_join_put_solid(kn_ctx *ctx, kn_step_join *j, kn_text *out, const kn_patch_id *id, int look,
                                 const kn_closed_shell *shells, size_t n);
bool kn_step_join_is_list(const kn_step_join *j, int body); // and no body

#endif
