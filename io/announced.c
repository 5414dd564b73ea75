// SPDX-License-Identifier: Apache-2.0
#include "io/announced.h"
#include "kernel/context.h"

kn_status kn_announced_take(kn_ctx *ctx, kn_announced *out, const kn_job_report *report, const char *format)
{
    const int *degree = report->degree;
    if (report->meshes > 0)
        return kn_fail(ctx, KN_EDOMAIN,
                       "%s: %zu of the patches are meshes, and faces are spline surfaces: write STL, OBJ or glTF",
                       format, report->meshes);
    *out = (kn_announced){.degree = {degree[0], degree[1]},
                          .volume_degree = report->volumes == 0    ? -1
                                           : degree[0] < degree[1] ? degree[0]
                                                                   : degree[1],
                          .curves = report->curves > 0,
                          .patches = report->patches};
    return KN_OK;
}

kn_status kn_announced_check(kn_ctx *ctx, const kn_announced *a, const kn_patch *patch, uint64_t place, int nlooks,
                             const char *format)
{
    const kn_spline b = kn_patch_spline(patch);
    bool fits = b.nvars == 1 && a->curves;
    if (b.nvars == 2) fits = b.degree[0] <= a->degree[0] && b.degree[1] <= a->degree[1];
    for (int v = 0; v < 3 && b.nvars == 3; v++) fits = (v == 0 || fits) && b.degree[v] <= a->volume_degree;
    if (fits && kn_spline_dim(&b) == 3 && patch->look >= 0 && patch->look < nlooks && place < a->patches)
        return KN_OK;
    return kn_fail(ctx, KN_EDOMAIN, "%s: patch %llu is not what the job's report announced", format,
                   (unsigned long long)place);
}

kn_status kn_announced_each_face(kn_ctx *ctx, const kn_patch *patch,
                                 kn_status (*put)(void *user, const kn_patch *face), void *user)
{
    kn_status status = KN_OK;
    if (kn_patch_nvars(patch) != 3) return put(user, patch);
    for (int k = 0; k < 6 && status == KN_OK; k++) {
        kn_patch face = {0};
        if (patch->hidden >> k & 1) continue;
        status = kn_patch_face(ctx, &face, patch, k);
        if (status == KN_OK) status = put(user, &face);
        kn_bezier_clear(ctx, &face.bezier);
    }
    return status;
}
