// SPDX-License-Identifier: Apache-2.0
// The edges of a CAD file's faces, as patches tell them to sinks: so that faces share them in what is written.
#include "cli/cli.h"
#include "kernel/context.h"

#include <math.h>

kn_status cli_cad_bounds(kn_ctx *ctx, kn_patch_bounds *out, const kn_cad *cad, int face, int max_degree)
{
    const kn_cad_face *f = &cad->faces[face];
    kn_patch_edge *edges = kn_alloc_zero(ctx, (size_t)f->trim.ncurves, sizeof *edges);
    if (!edges) return KN_ENOMEM;
    bool solid = cad->bodies[f->body].solid || f->shell > 0; // a void is no solid by itself
    *out = (kn_patch_bounds){.edges = edges, .body = solid ? f->body : -1, .shell = f->shell};
    for (int k = 0; f->use && k < f->trim.ncurves; k++) {
        const kn_cad_edge *e = &cad->edges[f->edge[k]];
        const kn_spline *plane = &f->use[k].plane;
        if (plane->nvars == 0 ||
            (max_degree > 0 && (e->line.degree[0] > max_degree || plane->degree[0] > max_degree)))
            continue;
        // an edge of more than two faces is shared by none of them
        uint64_t alone = (uint64_t)cad->nedges + ((uint64_t)face << 32) + (uint64_t)k;
        edges[k] = (kn_patch_edge){.number = !e->more ? (uint64_t)f->edge[k] : alone,
                                   .curve = &e->line,
                                   .plane = plane,
                                   .against = f->use[k].against};
        for (int i = 0; i < 2; i++) {
            edges[k].vertex[i] = (uint64_t)e->vertex[i];
            edges[k].point[i] = cad->vertices[e->vertex[i]].at;
        }
        out->error = fmax(out->error, e->error);
    }
    return KN_OK;
}
