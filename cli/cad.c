// SPDX-License-Identifier: Apache-2.0
// STEP, IGES and BREP files: knurl-cad reads them, a program of its own, so that no broken file can crash or hang
// this one, and what it makes of them comes through a pipe. Compressed ones are unpacked into a temporary file first.
#include "cli/cli.h"
#include "kernel/context.h"

#if KN_WITH_ZLIB
#include "bridges/zlib/gzip.h"
#endif

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { TEXT_BYTES = 16384, BLOCK_BYTES = 1 << 16, PATIENCE_MS = 50 };

bool cli_is_cad(const char *path)
{
    static const char *const endings[] = {"step", "stp", "stpz", "iges", "igs", "igz", "brep"};
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (cli_has_ending(path, endings[i])) return true;
    return false;
}

// A running knurl-cad: its two streams, and what came of them.
typedef struct child {
    pid_t pid;
    int pipe[2]; // standard output, error; -1: closed
    unsigned char *data;
    size_t bytes, room, most;
    char text[TEXT_BYTES]; // of standard error
    size_t text_bytes;
} child;

static void shut(int *file)
{
    if (*file >= 0) close(*file);
    *file = -1;
}

static kn_status start(kn_ctx *ctx, child *c, const char *const *arguments, const char *path, FILE *input)
{
    int out[2] = {-1, -1}, err[2] = {-1, -1};
    char program[CLI_PATH_BYTES];
    cli_find_program(program, "knurl-cad", "KNURL_CAD");
    if (pipe(out) != 0 || pipe(err) != 0) {
        for (int i = 0; i < 2; i++) shut(&out[i]), shut(&err[i]);
        return kn_fail(ctx, KN_EIO, "%s: no pipe: %s", path, strerror(errno));
    }
    for (int i = 0; i < 2; i++) { // nothing of them in the child but what is put in its place
        fcntl(out[i], F_SETFD, FD_CLOEXEC);
        fcntl(err[i], F_SETFD, FD_CLOEXEC);
    }
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t defaults;
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGPIPE);
    sigaddset(&defaults, SIGXFSZ);
    posix_spawn_file_actions_init(&actions);
    if (input) posix_spawn_file_actions_adddup2(&actions, fileno(input), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    int why = posix_spawnp(&c->pid, program, &actions, &attributes, (char *const *)arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    shut(&out[1]), shut(&err[1]);
    c->pipe[0] = out[0], c->pipe[1] = err[0];
    if (why == 0) return KN_OK;
    c->pid = 0;
    return kn_fail(ctx, why == ENOENT ? KN_ENOTBUILT : KN_EIO,
                   "%s: needs knurl-cad, which reads and writes CAD files with Open CASCADE: %s: %s", path, program,
                   strerror(why));
}

static kn_status grow(kn_ctx *ctx, child *c, const char *path)
{
    if (c->room - c->bytes >= BLOCK_BYTES) return KN_OK;
    size_t room = 2 * c->room + BLOCK_BYTES;
    if (c->bytes > c->most) return kn_fail(ctx, KN_ELIMIT, "%s: makes more than %zu bytes of splines", path, c->most);
    unsigned char *larger = kn_resize(ctx, c->data, room, 1);
    if (!larger) return KN_ENOMEM;
    c->data = larger;
    c->room = room;
    return KN_OK;
}

// What there is on one of the streams; the text of errors is kept as far as it fits.
static kn_status take(kn_ctx *ctx, child *c, int stream, const char *path)
{
    char rest[1024];
    kn_status status = stream == 0 ? grow(ctx, c, path) : KN_OK;
    if (status != KN_OK) return status;
    size_t left = sizeof c->text - 1 - c->text_bytes;
    bool full = left == 0;
    void *to = stream == 0 ? (void *)(c->data + c->bytes) : full ? (void *)rest : (void *)(c->text + c->text_bytes);
    ssize_t n = read(c->pipe[stream], to, stream == 0 ? BLOCK_BYTES : full ? sizeof rest : left);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) return KN_OK;
    if (n <= 0)
        shut(&c->pipe[stream]);
    else if (stream == 0)
        c->bytes += (size_t)n;
    else if (!full)
        c->text_bytes += (size_t)n;
    return KN_OK;
}

static kn_status listen_to(kn_ctx *ctx, child *c, const char *path)
{
    kn_status status = KN_OK;
    while (status == KN_OK && (c->pipe[0] >= 0 || c->pipe[1] >= 0)) {
        struct pollfd polled[2] = {{.fd = c->pipe[0], .events = POLLIN}, {.fd = c->pipe[1], .events = POLLIN}};
        int n = poll(polled, 2, PATIENCE_MS);
        status = kn_progress(ctx, "read", 0.0);
        for (int i = 0; i < 2 && n > 0 && status == KN_OK; i++)
            if (polled[i].revents != 0) status = take(ctx, c, i, path);
    }
    return status;
}

// What comes behind "FILE: ", or the whole.
static const char *behind(const char *text, const char *file)
{
    size_t n = strlen(file);
    return strncmp(text, file, n) == 0 && strncmp(text + n, ": ", 2) == 0 ? text + n + 2 : text;
}

// Lines of standard error: the last that is no warning is the message. Warnings go to the log where all went well;
// else the first may say why not.
static const char *read_lines(kn_ctx *ctx, char *text, bool well, const char *path, const char *opened,
                              const char **warning)
{
    const char *message = "";
    *warning = NULL;
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        bool warns = strncmp(line, "warning: ", 9) == 0;
        if (!warns)
            message = line;
        else if (well)
            kn_log(ctx, KN_LOG_WARNING, "%s: %s", path, behind(line + 9, opened));
        else if (!*warning)
            *warning = line + 9;
    }
    return message;
}

// path: the file as messages name it; opened: as knurl-cad knows it.
static kn_status judge(kn_ctx *ctx, child *c, int how, const char *path, const char *opened)
{
    const char *warning;
    bool well = WIFEXITED(how) && WEXITSTATUS(how) == 0;
    c->text[c->text_bytes] = '\0';
    const char *message = read_lines(ctx, c->text, well, path, opened, &warning);
    if (well) return KN_OK;
    const char *why = warning ? behind(warning, opened) : "", *because = warning ? ": " : "";
    if (WIFSIGNALED(how) && (WTERMSIG(how) == SIGXCPU || WTERMSIG(how) == SIGKILL))
        return kn_fail(ctx, KN_EPARSE, "%s: the reader was ended: it took too long%s%s", path, because, why);
    if (WIFSIGNALED(how)) return kn_fail(ctx, KN_EPARSE, "%s: the reader crashed on it%s%s", path, because, why);
    kn_status status = WEXITSTATUS(how) == EXIT_BAD_INPUT ? KN_EPARSE : KN_EIO;
    if (*message) return kn_fail(ctx, status, "%s: %s", path, behind(message, opened));
    return kn_fail(ctx, status, "%s: the reader gave up on it%s%s", path, because, why);
}

// path: the file as messages name it; file_bytes: of what knurl-cad opens.
static kn_status run(kn_ctx *ctx, unsigned char **data, size_t *bytes, const char *const *arguments, const char *path,
                     size_t file_bytes, FILE *input)
{
    child *c = kn_alloc_zero(ctx, 1, sizeof *c);
    if (!c) return KN_ENOMEM;
    c->pipe[0] = c->pipe[1] = -1;
    c->most = ((size_t)256 << 20) + 64 * file_bytes;
    kn_status status = start(ctx, c, arguments, path, input);
    if (status == KN_OK) status = listen_to(ctx, c, path);
    if (c->pid > 0) {
        int how = 0;
        if (status != KN_OK) kill(c->pid, SIGKILL);
        while (waitpid(c->pid, &how, 0) < 0 && errno == EINTR) {
        }
        if (status == KN_OK) status = kn_progress(ctx, "read", 1.0); // Ctrl-C may have ended it, too
        if (status == KN_OK) status = judge(ctx, c, how, path, arguments[2]);
    }
    for (int i = 0; i < 2; i++) shut(&c->pipe[i]);
    if (status == KN_OK) {
        *data = c->data;
        *bytes = c->bytes;
        c->data = NULL;
    }
    kn_free(ctx, c->data);
    kn_free(ctx, c);
    return status;
}

// ---- compressed files ----

#if KN_WITH_ZLIB
// A folder of this process's own for one file.
static kn_status unpack(kn_ctx *ctx, char folder[CLI_PATH_BYTES], char file[CLI_PATH_BYTES], const char *path,
                        size_t bytes)
{
    static const size_t room = (size_t)64 << 20, times = 32; // STEP packs to a tenth or more
    const char *where = getenv("TMPDIR");
    int n = snprintf(folder, CLI_PATH_BYTES, "%s/knurl-XXXXXX", where && *where ? where : "/tmp");
    bool made = n < CLI_PATH_BYTES - 8 && mkdtemp(folder);
    if (!made) {
        folder[0] = '\0';
        return kn_fail(ctx, KN_EIO, "%s: no folder to unpack it into: %s", path, strerror(errno));
    }
    snprintf(file, CLI_PATH_BYTES, "%.*s/part", CLI_PATH_BYTES - 8, folder);
    return kn_gunzip_file(ctx, file, path, room + times * bytes);
}

static bool is_packed(const char *path)
{
    return kn_gzip_is(path);
}
#else
static kn_status unpack(kn_ctx *ctx, char folder[CLI_PATH_BYTES], char file[CLI_PATH_BYTES], const char *path,
                        size_t bytes)
{
    (void)bytes;
    folder[0] = file[0] = '\0';
    return kn_fail(ctx, KN_ENOTBUILT, "%s: cannot be read: built without zlib", path);
}

static bool is_packed(const char *path)
{
    return cli_has_ending(path, "stpz") || cli_has_ending(path, "igz");
}
#endif

kn_status cli_run_cad(kn_ctx *ctx, unsigned char **data, size_t *bytes, const char *const *arguments,
                      const char *path, FILE *input)
{
    enum { MOST_ARGUMENTS = 8 };
    struct stat file;
    if (stat(path, &file) != 0) return kn_fail(ctx, KN_EIO, "%s: cannot open: %s", path, strerror(errno));
    size_t size = file.st_size > 0 ? (size_t)file.st_size : 0;
    if (!is_packed(path)) return run(ctx, data, bytes, arguments, path, size, input);
    char folder[CLI_PATH_BYTES], unpacked[CLI_PATH_BYTES];
    kn_status status = unpack(ctx, folder, unpacked, path, size);
    if (status == KN_OK) {
        const char *with[MOST_ARGUMENTS + 1] = {NULL};
        for (int i = 0; i < MOST_ARGUMENTS && arguments[i]; i++) with[i] = i == 2 ? unpacked : arguments[i];
        if (stat(unpacked, &file) == 0) size = (size_t)file.st_size;
        status = run(ctx, data, bytes, with, path, size, input);
    }
    if (*folder) unlink(unpacked), rmdir(folder);
    return status;
}

kn_status cli_read_cad(kn_ctx *ctx, kn_cad *out, const char *path)
{
    const char *const arguments[] = {"knurl-cad", "read", path, NULL};
    unsigned char *data = NULL;
    size_t bytes = 0;
    kn_status status = cli_run_cad(ctx, &data, &bytes, arguments, path, NULL);
    if (status == KN_OK) status = kn_cad_parse(ctx, out, path, data, bytes);
    kn_free(ctx, data);
    return status;
}

kn_status cli_read_model(kn_ctx *ctx, kn_model *out, const char *path)
{
    if (!cli_is_cad(path)) return kn_read_model(ctx, out, path);
    kn_cad cad = {0};
    kn_status status = cli_read_cad(ctx, &cad, path);
    kn_spline *splines = status == KN_OK ? kn_alloc_zero(ctx, (size_t)cad.nfaces, sizeof *splines) : NULL;
    if (splines) {
        for (int i = 0; i < cad.nfaces; i++) kn_spline_swap(&splines[i], &cad.faces[i].surface);
        kn_model_clear(ctx, out);
        *out = (kn_model){.splines = splines, .nsplines = cad.nfaces};
    } else if (status == KN_OK) {
        status = KN_ENOMEM;
    }
    kn_cad_clear(ctx, &cad);
    return status;
}
