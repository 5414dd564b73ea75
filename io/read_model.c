// SPDX-License-Identifier: Apache-2.0
// The reader chosen by the ending of the path.
#include "kernel/context.h"

#include <knurl/io.h>

#include <string.h>

// Letters of either case: other systems write .G2. ending is in small ones.
static bool ends_in(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    if (n < m) return false;
    for (size_t i = 0; i < m; i++) {
        char c = path[n - m + i];
        if ((c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c) != ending[i]) return false;
    }
    return true;
}

kn_status kn_read_model(kn_ctx *ctx, kn_model *out, const char *path)
{
    if (ends_in(path, ".bpt")) return kn_read_bpt(ctx, out, path);
    if (ends_in(path, ".g2")) return kn_read_g2(ctx, out, path);
    if (ends_in(path, ".itd")) return kn_read_itd(ctx, out, path);
    return kn_fail(ctx, KN_EDOMAIN, "%s: no reader for this ending; .bpt, .g2 and .itd are read", path);
}
