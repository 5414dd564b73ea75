// SPDX-License-Identifier: Apache-2.0
// What faces and bodies are called in files for CAD systems.
#ifndef IO_NAMING_H
#define IO_NAMING_H

#include <knurl/job.h>

typedef struct kn_naming {
    char **surfaces; // nsurfaces of them, of the base; "": none
    int nsurfaces;
    bool plain; // faces as their surfaces alone, bodies as their parts
    bool mark;  // what is not exact
} kn_naming;

// names: n of them, copied; NULL: none. fails: KN_ENOMEM; *naming is to be cleared.
KN_CHECKED kn_status kn_naming_init(kn_ctx *ctx, kn_naming *naming, const char *const *names, int n, bool plain);
void kn_naming_clear(kn_ctx *ctx, kn_naming *naming);
// Faces are marked where some are exact and others are not.
void kn_naming_take_report(kn_naming *naming, const kn_job_report *report);

// Of one of them; "": it has none.
const char *kn_naming_surface(const kn_naming *naming, const kn_patch_id *id);

// "s0 c3,4 ring", and for a face " 12" or " 12.1", and " ~".
enum { KN_FACE_NAME_BYTES = 2 * KN_NAME_BYTES + 96 };
void kn_naming_write(char name[KN_FACE_NAME_BYTES], const kn_naming *naming, const kn_patch_id *id, const char *part,
                     bool face, bool exact);

#endif
