// SPDX-License-Identifier: Apache-2.0
// knurl-cad host FILE SCHEMA: a request on standard input, what bridges/occt/host.h says of it on standard output.
#include <cstdio>
#include <string>

#include "bridges/occt/host.h"
#include "bridges/occt/program/program.h"

int kn_cad_command_host(kn_ctx *ctx, int argc, char **argv)
{
    if (argc != 3) {
        std::fprintf(stderr, "knurl-cad host: FILE, and AP203, AP214 or AP242\n");
        return KN_CAD_USAGE;
    }
    std::string request;
    char block[1 << 16];
    for (size_t n; (n = std::fread(block, 1, sizeof block, stdin)) > 0;) request.append(block, n);
    char *text = nullptr;
    size_t bytes = 0;
    kn_status status = kn_occt_write_host(ctx, &text, &bytes, argv[1], request.data(), request.size(), argv[2]);
    if (status != KN_OK) return kn_cad_fail(ctx, status);
    bool written = std::fwrite(text, 1, bytes, stdout) == bytes && std::fflush(stdout) == 0;
    return written ? KN_CAD_OK : KN_CAD_FAILED;
}
