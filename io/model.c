// SPDX-License-Identifier: Apache-2.0
// The life of a model, and what readers share.
#include <knurl/io.h>

#include "io/in_file.h"
#include "io/model.h"
#include "kernel/context.h"

void kn_model_clear(kn_ctx *ctx, kn_model *model)
{
    for (int i = 0; i < model->nsplines; i++) kn_spline_clear(ctx, &model->splines[i]);
    kn_free(ctx, model->splines);
    kn_mesh_clear(ctx, &model->mesh);
    *model = (kn_model){0};
}

void kn_model_move(kn_ctx *ctx, kn_model *out, kn_model *from)
{
    kn_model old = *out;
    *out = *from;
    *from = (kn_model){0};
    kn_model_clear(ctx, &old);
}

kn_status kn_model_append(kn_ctx *ctx, kn_model *model, kn_spline *spline)
{
    int n = model->nsplines;
    if ((n & (n + 1)) == 0) { // room doubles at 0, 1, 3, 7, ...: the count alone tells how much there is
        size_t room = 2 * (size_t)n + 1;
        kn_spline *larger = n == 0 ? kn_alloc(ctx, room, sizeof *larger)
                                   : kn_resize(ctx, model->splines, room, sizeof *larger);
        if (larger == NULL) return KN_ENOMEM;
        model->splines = larger;
    }
    model->splines[n] = *spline;
    *spline = (kn_spline){0};
    model->nsplines++;
    return KN_OK;
}

kn_status kn_read_with(kn_ctx *ctx, kn_model *out, const char *path, kn_model_parser *parse)
{
    char *text = NULL;
    size_t bytes = 0;
    kn_status status = kn_in_read(ctx, &text, &bytes, path);
    if (status == KN_OK) status = parse(ctx, out, path, text, bytes);
    kn_free(ctx, text);
    return status;
}
