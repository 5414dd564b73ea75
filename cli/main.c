// SPDX-License-Identifier: Apache-2.0
// knurl: geometry on geometry, from the command line.
#include "cli/cli.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

typedef struct command {
    const char *name;
    int (*run)(int argc, char **argv);
} command;

static const command commands[] = {
    {"apply", cli_command_apply}, {"tiles", cli_command_tiles},     {"info", cli_command_info},
    {"eval", cli_command_eval},   {"render", cli_command_render},   {"check", cli_command_check},
    {"slice", cli_command_slice}, {"animate", cli_command_animate}, {"convert", cli_command_convert},
};
enum { NCOMMANDS = sizeof commands / sizeof *commands };

static int unknown_command(const char *name)
{
    const char *names[NCOMMANDS];
    for (int i = 0; i < NCOMMANDS; i++) names[i] = commands[i].name;
    const char *nearest = cli_nearest(name, names, NCOMMANDS);
    if (nearest)
        cli_error("no command '%s'; did you mean '%s'?", name, nearest);
    else
        cli_error("no command '%s'", name);
    cli_usage_hint(NULL);
    return EXIT_USAGE;
}

// Output that did not reach its file (a full disk behind a redirection) must not look like success.
static int flush_stdout(int code)
{
    errno = 0;
    if (fflush(stdout) == 0 && !ferror(stdout)) return code;
    if (errno != EPIPE) cli_error("standard output: cannot write"); // who read it has seen enough, and knows
    return code == EXIT_OK ? EXIT_FAILED : code;
}

// A standard stream that the caller has closed must not become the number of an output file. Writing to the stand-in
// for standard output fails as it would have; messages are lost as they would have been.
static void fill_standard_streams(void)
{
    static const int modes[] = {O_WRONLY, O_RDONLY, O_WRONLY};
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) == -1 && errno == EBADF && open("/dev/null", modes[fd]) == -1) return;
}

int main(int argc, char **argv)
{
    fill_standard_streams();
    if (argc < 2) {
        cli_help(stderr, NULL);
        return EXIT_USAGE;
    }
    const char *name = argv[1];
    if (strcmp(name, "--version") == 0 || strcmp(name, "version") == 0) {
        printf("knurl %s\n", kn_version());
        return flush_stdout(EXIT_OK);
    }
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0)
        return flush_stdout(cli_help(stdout, argc > 2 ? argv[2] : NULL));
    for (int i = 0; i < NCOMMANDS; i++)
        if (strcmp(name, commands[i].name) == 0) return flush_stdout(commands[i].run(argc - 1, argv + 1));
    return unknown_command(name);
}
