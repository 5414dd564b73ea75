// SPDX-License-Identifier: Apache-2.0
// kn_occt_read.
#include <utility>

#include "bridges/occt/cad_model.hpp"
#include "bridges/occt/cad_read.h"
#include "bridges/occt/guard.hpp"

kn_status kn_occt_read(kn_ctx *ctx, kn_cad *out, const char *path)
{
    kn_cad cad = {};
    kn_status status = kn_occt::guarded(ctx, path, [&] {
        kn_occt::document d;
        kn_occt::read_document(ctx, &d, path);
        kn_occt::model_of(ctx, &cad, &d, path);
        return kn_cad_check(ctx, &cad);
    });
    if (status == KN_OK) std::swap(*out, cad);
    kn_cad_clear(ctx, &cad);
    return status;
}
