// SPDX-License-Identifier: Apache-2.0
#include <knurl/cad.h>

void kn_cad_clear(kn_ctx *ctx, kn_cad *cad)
{
    if (!cad) return;
    for (int i = 0; i < cad->nfaces; i++) {
        kn_spline_clear(ctx, &cad->faces[i].surface);
        kn_trim_clear(ctx, &cad->faces[i].trim);
        kn_free(ctx, cad->faces[i].edge);
    }
    kn_free(ctx, cad->faces);
    kn_free(ctx, cad->edges);
    kn_free(ctx, cad->bodies);
    *cad = (kn_cad){0};
}
