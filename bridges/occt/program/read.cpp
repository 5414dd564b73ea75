// SPDX-License-Identifier: Apache-2.0
// knurl-cad read FILE: the model as bytes on standard output.
#include <cstdio>

#include "bridges/occt/cad_read.h"
#include "bridges/occt/program/program.h"

int kn_cad_command_read(kn_ctx *ctx, int argc, char **argv)
{
    if (argc != 2) {
        std::fprintf(stderr, "knurl-cad read: one FILE\n");
        return KN_CAD_USAGE;
    }
    kn_cad cad = {};
    unsigned char *data = nullptr;
    size_t bytes = 0;
    kn_status status = kn_occt_read(ctx, &cad, argv[1]);
    if (status == KN_OK) status = kn_cad_write(ctx, &data, &bytes, &cad);
    if (status != KN_OK) return kn_cad_fail(ctx, status);
    bool written = std::fwrite(data, 1, bytes, stdout) == bytes && std::fflush(stdout) == 0;
    return written ? KN_CAD_OK : KN_CAD_FAILED;
}
