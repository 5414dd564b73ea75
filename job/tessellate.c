// SPDX-License-Identifier: Apache-2.0
// What a patch looks like: triangles of surfaces, of the outside of volumes and of mapped meshes, points of curves.
#include "kernel/context.h"

#include <knurl/job.h>

kn_status kn_patch_face(kn_ctx *ctx, kn_patch *out, const kn_patch *patch, int face)
{
    const kn_bezier *b = &patch->bezier;
    if (b->nvars != 3 || !b->coef) return kn_fail(ctx, KN_EDOMAIN, "patch: no volume, and so no faces");
    if (face < 0 || face > 5) return kn_fail(ctx, KN_EDOMAIN, "patch: face %d", face);
    int var = face / 2, end = face % 2, p = var == 0 ? 1 : 0, q = var == 2 ? 1 : 2;
    const int degree[2] = {b->degree[p], b->degree[q]};
    kn_patch made = *patch;
    made.bezier = (kn_bezier){0};
    kn_status status = kn_bezier_init(ctx, &made.bezier, 2, b->ncomp, b->rational, degree);
    if (status != KN_OK) return status;
    size_t stride[3] = {(size_t)(b->degree[1] + 1) * (size_t)(b->degree[2] + 1), (size_t)b->degree[2] + 1, 1};
    size_t first = end == 1 ? (size_t)b->degree[var] * stride[var] : 0, n = kn_bezier_count(b), at = 0;
    for (size_t c = 0; c < (size_t)b->ncomp; c++)
        for (size_t i = 0; i <= (size_t)degree[0]; i++)
            for (size_t j = 0; j <= (size_t)degree[1]; j++)
                made.bezier.coef[at++] = b->coef[c * n + first + i * stride[p] + j * stride[q]];
    // P_p x P_q looks along +var for var 0 and 2 in a right-handed volume, and back for 1
    made.reversed = patch->reversed != ((end == 0) != (var == 1));
    made.hidden = 0;
    made.trim = NULL;
    made.segments[0] = patch->segments[p];
    made.segments[1] = patch->segments[q];
    *out = made;
    return KN_OK;
}

static kn_status add_volume(kn_ctx *ctx, kn_mesh *mesh, const kn_patch *patch)
{
    kn_status status = KN_OK;
    for (int face = 0; status == KN_OK && face < 6; face++) {
        kn_patch side = {0};
        if (patch->hidden >> face & 1) continue;
        status = kn_patch_face(ctx, &side, patch, face);
        if (status == KN_OK) status = kn_mesh_add_patch(ctx, mesh, &side.bezier, side.segments, side.reversed);
        kn_bezier_clear(ctx, &side.bezier);
    }
    return status;
}

// The pieces of a spline one by one, each with its share of the segments; faces of volumes between two are not outside.
static kn_status add_spline(kn_ctx *ctx, kn_mesh *mesh, const kn_patch *patch)
{
    const kn_spline *s = patch->spline;
    kn_bezier *pieces = NULL;
    size_t npieces = 0, nvertices = mesh->nvertices, ntriangles = mesh->ntriangles;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &npieces, s);
    for (size_t i = 0; status == KN_OK && i < npieces; i++) {
        kn_patch one = *patch;
        size_t rest = i;
        one.spline = NULL;
        one.bezier = pieces[i];
        for (int d = s->nvars - 1; d >= 0; d--) {
            size_t spans = (size_t)kn_spline_spans(s, d), at = rest % spans;
            rest /= spans;
            one.segments[d] = 1 + (patch->segments[d] - 1) / (int)spans;
            if (at > 0) one.hidden = (uint8_t)(one.hidden | 1u << (2 * d));
            if (at + 1 < spans) one.hidden = (uint8_t)(one.hidden | 2u << (2 * d));
        }
        status = kn_patch_tessellate(ctx, mesh, &one);
    }
    if (status != KN_OK) mesh->nvertices = nvertices, mesh->ntriangles = ntriangles;
    for (size_t i = 0; i < npieces; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    return status;
}

kn_status kn_patch_tessellate(kn_ctx *ctx, kn_mesh *mesh, const kn_patch *patch)
{
    if (patch->mesh) return kn_mesh_append(ctx, mesh, patch->mesh);
    if (kn_patch_nvars(patch) == 1) return KN_OK;
    if (patch->spline && patch->trim)
        return kn_fail(ctx, KN_EDOMAIN,
                       "patch: triangles of a trimmed spline are made of its pieces: split it first");
    if (patch->spline) return add_spline(ctx, mesh, patch);
    if (patch->bezier.nvars == 3) {
        size_t nvertices = mesh->nvertices, ntriangles = mesh->ntriangles;
        kn_status status = add_volume(ctx, mesh, patch);
        if (status != KN_OK) mesh->nvertices = nvertices, mesh->ntriangles = ntriangles;
        return status;
    }
    if (patch->trim)
        return kn_mesh_add_trimmed(ctx, mesh, &patch->bezier, patch->trim, patch->segments, patch->reversed);
    return kn_mesh_add_patch(ctx, mesh, &patch->bezier, patch->segments, patch->reversed);
}

size_t kn_patch_line_points(const kn_patch *patch)
{
    return kn_patch_nvars(patch) == 1 && patch->segments[0] > 0 ? (size_t)patch->segments[0] + 1 : 0;
}

kn_status kn_patch_line(kn_ctx *ctx, double *points, const kn_patch *patch)
{
    size_t n = kn_patch_line_points(patch);
    if (n == 0) return kn_fail(ctx, KN_EDOMAIN, "patch: no curve");
    kn_mark mark = kn_scratch_mark(ctx);
    double *at = kn_scratch(ctx, n, sizeof *at);
    kn_status status = at ? KN_OK : KN_ENOMEM;
    double lo = 0.0, hi = 1.0;
    if (patch->spline) kn_spline_domain(patch->spline, 0, &lo, &hi); // models keep theirs (kn_stream_model)
    for (size_t i = 0; at && i < n; i++) {
        double x = (double)i / (double)(n - 1);
        at[i] = i + 1 < n ? lo + (hi - lo) * x : hi;
    }
    if (status == KN_OK && patch->spline) status = kn_spline_eval_batch(ctx, points, patch->spline, n, at);
    if (status == KN_OK && !patch->spline) status = kn_bezier_eval_batch(ctx, points, &patch->bezier, n, at);
    kn_scratch_release(ctx, mark);
    return status;
}
