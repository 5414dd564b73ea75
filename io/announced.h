// SPDX-License-Identifier: Apache-2.0
// Inside io: what a job's report announced of its patches, for writers of faces.
#ifndef IO_ANNOUNCED_H
#define IO_ANNOUNCED_H

#include <knurl/job.h>

typedef struct kn_announced {
    int degree[2], volume_degree; // volume_degree -1: no volumes
    bool curves;
    uint64_t patches;
} kn_announced;

// format: for messages, as below. fails: KN_EDOMAIN meshes, which have no faces.
KN_CHECKED kn_status kn_announced_take(kn_ctx *ctx, kn_announced *out, const kn_job_report *report,
                                       const char *format);
// KN_EDOMAIN: the patch at this place in the job's order is not what was announced, or has none of nlooks looks.
KN_CHECKED kn_status kn_announced_check(kn_ctx *ctx, const kn_announced *a, const kn_patch *patch, uint64_t place,
                                        int nlooks, const char *format);
// put(user, face) for each face of a volume that lies outside; for the patch itself where it is none.
KN_CHECKED kn_status kn_announced_each_face(kn_ctx *ctx, const kn_patch *patch,
                                            kn_status (*put)(void *user, const kn_patch *face), void *user);

#endif
