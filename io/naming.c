// SPDX-License-Identifier: Apache-2.0
// What faces and bodies are called in files for CAD systems.
#include "io/naming.h"

#include "kernel/context.h"

#include <stdio.h>
#include <string.h>

kn_status kn_naming_init(kn_ctx *ctx, kn_naming *naming, const char *const *names, int n, bool plain)
{
    *naming = (kn_naming){.plain = plain};
    if (!names || n == 0) return KN_OK;
    naming->surfaces = kn_alloc_zero(ctx, (size_t)n, sizeof *naming->surfaces);
    if (!naming->surfaces) return KN_ENOMEM;
    naming->nsurfaces = n;
    for (int i = 0; i < n; i++) {
        const char *from = names[i] ? names[i] : "";
        naming->surfaces[i] = kn_alloc(ctx, strlen(from) + 1, 1);
        if (!naming->surfaces[i]) return KN_ENOMEM;
        memcpy(naming->surfaces[i], from, strlen(from) + 1);
    }
    return KN_OK;
}

void kn_naming_clear(kn_ctx *ctx, kn_naming *naming)
{
    for (int i = 0; i < naming->nsurfaces; i++) kn_free(ctx, naming->surfaces[i]);
    kn_free(ctx, naming->surfaces);
    *naming = (kn_naming){0};
}

void kn_naming_take_report(kn_naming *naming, const kn_job_report *r)
{
    bool all = r->exact_patches == r->patches && r->fit_degree == 0, none = r->exact_patches == 0;
    naming->mark = !all && (!none || r->fit_degree > 0);
}

const char *kn_naming_surface(const kn_naming *naming, const kn_patch_id *id)
{
    return id->surface >= 0 && id->surface < naming->nsurfaces ? naming->surfaces[id->surface] : "";
}

void kn_naming_write(char name[KN_FACE_NAME_BYTES], const kn_naming *naming, const kn_patch_id *id, const char *part,
                     bool face, bool exact)
{
    size_t room = (size_t)KN_FACE_NAME_BYTES;
    const char *surface = kn_naming_surface(naming, id);
    if (naming->plain) {
        int length = snprintf(name, room, "%.*s", KN_NAME_BYTES - 1, face ? surface : part);
        if (face && naming->mark && !exact) snprintf(name + length, room - (size_t)length, " ~");
        return;
    }
    int n = surface[0] ? snprintf(name, room, "%.*s", KN_NAME_BYTES - 1, surface)
                       : snprintf(name, room, "s%d", id->surface);
    n += snprintf(name + n, room - (size_t)n, " c%d,%d %.*s", id->cell[0], id->cell[1], KN_NAME_BYTES - 1, part);
    if (!face) return;
    n += snprintf(name + n, room - (size_t)n, " %d", id->patch);
    if (id->piece > 0) n += snprintf(name + n, room - (size_t)n, ".%d", id->piece);
    if (naming->mark && !exact) snprintf(name + n, room - (size_t)n, " ~");
}
