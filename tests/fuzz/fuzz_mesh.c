// SPDX-License-Identifier: Apache-2.0
// Fuzzes the tessellation of patches.
#include "tests/fuzz/feed.h"

#include <knurl/mesh.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    kn_mesh mesh = {0};
    for (int i = 0; i < 3; i++) {
        kn_bezier a, broken;
        feed_bezier(&f, &a, feed_byte(&f) < 240 ? 2 : 1);
        int segments[2] = {feed_count(&f, 1, 9), feed_count(&f, 1, 9)};
        bool is_broken = feed_byte(&f) >= 248;
        broken = feed_broken(&f, &a);
        kn_ctx_clear_error(f.ctx);
        kn_status status = kn_mesh_add_patch(f.ctx, &mesh, is_broken ? &broken : &a, segments, feed_byte(&f) % 2);
        if ((status == KN_OK) != (kn_ctx_error(f.ctx) == KN_OK)) abort();
        for (size_t k = 0; k < 3 * mesh.ntriangles; k++)
            if (mesh.triangle[k] >= mesh.nvertices) abort();
        kn_bezier_clear(f.ctx, &a);
    }
    kn_mesh_clear(f.ctx, &mesh);
    feed_end(&f);
    return 0;
}
