// SPDX-License-Identifier: Apache-2.0
// Fuzzes the reader of .itd files: any bytes give a status, and what is read obeys the rules of splines.
#include <knurl/io.h>

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    kn_ctx *ctx = NULL;
    kn_ctx_options options = {.threads = 1};
    if (kn_ctx_create(&ctx, &options) != KN_OK) abort();
    kn_model model = {0};
    if (kn_parse_itd(ctx, &model, "fuzz", (const char *)data, size) == KN_OK) {
        for (size_t i = 0; i < 3 * model.mesh.ntriangles; i++)
            if (model.mesh.triangle[i] >= model.mesh.nvertices) abort();
        for (int i = 0; i < model.nsplines; i++)
            if (kn_spline_check(ctx, &model.splines[i]) != KN_OK) abort();
    }
    kn_model_clear(ctx, &model);
    if (kn_ctx_counters(ctx).live_blocks != 0) abort();
    kn_ctx_destroy(ctx);
    return 0;
}
