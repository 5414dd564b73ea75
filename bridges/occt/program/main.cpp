// SPDX-License-Identifier: Apache-2.0
// knurl-cad COMMAND ..: sets limits on itself and runs the command.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>

#include <sys/resource.h>
#include <sys/stat.h>

#include "bridges/occt/program/program.h"

namespace
{

struct command {
    const char *name;
    int (*run)(kn_ctx *ctx, int argc, char **argv);
};
const command commands[] = {{"read", kn_cad_command_read}, {"host", kn_cad_command_host}};

// A number of the environment in place of the default.
rlim_t wanted(const char *name, rlim_t or_else)
{
    const char *text = std::getenv(name);
    char *end = nullptr;
    unsigned long long value = text ? std::strtoull(text, &end, 10) : 0;
    return text && *text && *end == '\0' && value > 0 ? static_cast<rlim_t>(value) : or_else;
}

void limit(int resource, rlim_t most)
{
    struct rlimit now;
    if (getrlimit(resource, &now) != 0) return;
    if (now.rlim_max != RLIM_INFINITY && most > now.rlim_max) most = now.rlim_max;
    now.rlim_cur = most;
    setrlimit(resource, &now);
}

// Memory and time go with the size of the file: OCCT takes some hundred bytes for one of a STEP file. Environment:
// KNURL_CAD_BYTES, KNURL_CAD_SECONDS.
void set_limits(const char *path)
{
    struct stat file;
    rlim_t bytes = path && stat(path, &file) == 0 && file.st_size > 0 ? static_cast<rlim_t>(file.st_size) : 0;
#if !defined(__SANITIZE_ADDRESS__) // which reserves terabytes
    limit(RLIMIT_AS, wanted("KNURL_CAD_BYTES", (static_cast<rlim_t>(2) << 30) + 400 * bytes));
#endif
    limit(RLIMIT_CPU, wanted("KNURL_CAD_SECONDS", 60 + bytes / 20000));
    limit(RLIMIT_CORE, 0);
}

void warn(void *, kn_log_level level, const char *message)
{
    if (level == KN_LOG_WARNING) std::fprintf(stderr, "warning: %s\n", message);
}

} // namespace

int kn_cad_fail(kn_ctx *ctx, kn_status status)
{
    std::fprintf(stderr, "%s\n", kn_ctx_message(ctx));
    return status == KN_EIO || status == KN_ENOMEM || status == KN_ECANCELLED ? KN_CAD_FAILED : KN_CAD_BAD_INPUT;
}

int main(int argc, char **argv)
{
    for (const command &c : commands)
        if (argc >= 3 && std::strcmp(argv[1], c.name) == 0) {
            set_limits(argv[2]);
            std::cout.rdbuf(nullptr); // where OCCT says what it finds, in between what goes to knurl
            std::cerr.rdbuf(nullptr);
            kn_ctx *ctx = nullptr;
            kn_ctx_options options = kn_ctx_defaults();
            options.log = warn;
            options.threads = 1;
            if (kn_ctx_create(&ctx, &options) != KN_OK) return KN_CAD_FAILED;
            int code = c.run(ctx, argc - 1, argv + 1);
            std::fflush(stdout);
            std::_Exit(code); // what OCCT holds goes with the process
        }
    std::fprintf(stderr, "knurl-cad: a part of knurl; it takes: read FILE, host FILE SCHEMA\n");
    return KN_CAD_USAGE;
}
