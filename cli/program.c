// SPDX-License-Identifier: Apache-2.0
// Programs that knurl runs.
#include "cli/cli.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void cli_find_program(char out[CLI_PATH_BYTES], const char *name, const char *variable)
{
    static const char *const places[] = {"", "../libexec/knurl/"};
    const char *named = getenv(variable);
    if (named && *named) {
        snprintf(out, CLI_PATH_BYTES, "%s", named);
        return;
    }
    char self[CLI_PATH_BYTES];
    ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    self[n > 0 ? n : 0] = '\0';
    char *slash = strrchr(self, '/');
    for (size_t i = 0; slash && i < sizeof places / sizeof *places; i++) {
        int length = snprintf(out, CLI_PATH_BYTES, "%.*s%s%s", (int)(slash - self + 1), self, places[i], name);
        if (length < CLI_PATH_BYTES && access(out, R_OK) == 0) return;
    }
    snprintf(out, CLI_PATH_BYTES, "%s", name);
}
