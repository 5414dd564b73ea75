// SPDX-License-Identifier: Apache-2.0
#include <knurl/cad.h>

void kn_cad_clear(kn_ctx *ctx, kn_cad *cad)
{
    if (!cad) return;
    for (int i = 0; i < cad->nfaces; i++) {
        kn_spline_clear(ctx, &cad->faces[i].surface);
        for (int k = 0; cad->faces[i].use && k < cad->faces[i].trim.ncurves; k++)
            kn_spline_clear(ctx, &cad->faces[i].use[k].plane);
        kn_trim_clear(ctx, &cad->faces[i].trim);
        kn_free(ctx, cad->faces[i].edge), kn_free(ctx, cad->faces[i].use);
    }
    for (int i = 0; i < cad->nedges; i++) kn_spline_clear(ctx, &cad->edges[i].line);
    kn_free(ctx, cad->faces);
    kn_free(ctx, cad->edges);
    kn_free(ctx, cad->vertices);
    kn_free(ctx, cad->bodies);
    *cad = (kn_cad){0};
}
