// SPDX-License-Identifier: Apache-2.0
// Rhino .3dm files: as .g2 beside the output first, which a node program then turns into .3dm by McNeel's rhino3dm.
#include "cli/cli.h"
#include "kernel/context.h"

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

enum { TEXT_BYTES = 1024, PATIENCE_MS = 50 };

typedef struct rhino {
    kn_sink splines; // the .g2 file
    char *path, *between, *made;
    double unit_mm;
    size_t bytes;
} rhino;

static kn_status rhino_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    rhino *r = user;
    return r->splines.work(worker, r->splines.user, block, product);
}

static kn_status rhino_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    rhino *r = user;
    return r->splines.commit(ctx, r->splines.user, block, product);
}

static void rhino_discard(kn_ctx *ctx, void *user, void *product)
{
    rhino *r = user;
    r->splines.discard(ctx, r->splines.user, product);
}

// The program's exit; its first line on standard error is *text. A cancelled job ends it.
static kn_status attend(kn_ctx *ctx, pid_t pid, int error, char text[TEXT_BYTES], int *how)
{
    size_t bytes = 0;
    kn_status status = KN_OK;
    for (bool open = true; open && status == KN_OK;) {
        struct pollfd polled = {.fd = error, .events = POLLIN};
        int n = poll(&polled, 1, PATIENCE_MS);
        status = kn_progress(ctx, "write", 0.0);
        if (n <= 0) continue;
        char rest[256];
        bool full = bytes + 1 >= TEXT_BYTES;
        ssize_t got = full ? read(error, rest, sizeof rest) : read(error, text + bytes, TEXT_BYTES - 1 - bytes);
        open = got > 0 || (got < 0 && errno == EINTR);
        if (got > 0 && !full) bytes += (size_t)got;
    }
    if (status != KN_OK) kill(pid, SIGKILL);
    while (waitpid(pid, how, 0) < 0 && errno == EINTR) {
    }
    if (status == KN_OK) status = kn_progress(ctx, "write", 1.0); // Ctrl-C may have ended it, too
    text[bytes] = '\0';
    text[strcspn(text, "\n")] = '\0';
    return status;
}

// Runs the program on the .g2 file; or, to know before anything is composed that it can run, on nothing.
static kn_status run_program(kn_ctx *ctx, const rhino *r, bool on_nothing)
{
    char script[CLI_PATH_BYTES], unit[32], text[TEXT_BYTES];
    int error[2], how = 0;
    pid_t pid;
    cli_find_program(script, "knurl-3dm.cjs", "KNURL_3DM");
    if (access(script, R_OK) != 0 || !strchr(script, '/')) // what lies in the working folder is not knurl's
        return kn_fail(ctx, KN_ENOTBUILT, "%s: .3dm files need %s, which is not beside knurl", r->path, script);
    snprintf(unit, sizeof unit, "%.17g", r->unit_mm);
    const char *const arguments[] = {"node", script, on_nothing ? NULL : r->between, r->made, unit, NULL};
    if (pipe(error) != 0) return kn_fail(ctx, KN_EIO, "%s: no pipe: %s", r->path, strerror(errno));
    fcntl(error[0], F_SETFD, FD_CLOEXEC), fcntl(error[1], F_SETFD, FD_CLOEXEC);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, error[1], STDERR_FILENO);
    int why = posix_spawnp(&pid, "node", &actions, NULL, (char *const *)arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(error[1]);
    kn_status status = KN_OK;
    if (why != 0)
        status = kn_fail(ctx, KN_ENOTBUILT, "%s: .3dm files need node and its package rhino3dm: %s", r->path,
                         strerror(why));
    if (status == KN_OK) status = attend(ctx, pid, error[0], text, &how);
    close(error[0]);
    if (status == KN_OK && !(WIFEXITED(how) && WEXITSTATUS(how) == 0))
        status = kn_fail(ctx, KN_ENOTBUILT, "%s: rhino3dm: %s", r->path, *text ? text : "it ended before its time");
    return status;
}

static kn_status rhino_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    rhino *r = user;
    const char *what = report->volumes > 0 && report->fit_degree == 0 ? "volumes" // kn_limit_sink takes them apart
                       : report->meshes > 0                           ? "meshes"
                       : report->trim_curves > 0                      ? "trimmed surfaces"
                                                                      : NULL;
    if (what)
        return kn_fail(ctx, KN_EDOMAIN, "%s: some patches are %s, which knurl does not write to .3dm files", r->path,
                       what);
    kn_status status = run_program(ctx, r, true);
    return status == KN_OK ? r->splines.begin(ctx, r->splines.user, tile, report) : status;
}

static kn_status rhino_end(kn_ctx *ctx, void *user)
{
    rhino *r = user;
    struct stat file;
    kn_status status = r->splines.end(ctx, r->splines.user);
    if (status == KN_OK) status = run_program(ctx, r, false);
    if (status == KN_OK && (stat(r->made, &file) != 0 || rename(r->made, r->path) != 0))
        status = kn_fail(ctx, KN_EIO, "%s: cannot write: %s", r->path, strerror(errno));
    if (status == KN_OK) r->bytes = (size_t)file.st_size;
    return status;
}

static void rhino_close(kn_ctx *ctx, void *user)
{
    rhino *r = user;
    kn_sink_close(ctx, &r->splines);
    if (r->between) unlink(r->between);
    if (r->made) unlink(r->made);
    kn_free(ctx, r->path);
    kn_free(ctx, r->between);
    kn_free(ctx, r->made);
    kn_free(ctx, r);
}

static size_t rhino_bytes(const void *user)
{
    const rhino *r = user;
    return r->bytes;
}

static kn_status join_path(kn_ctx *ctx, char **out, const char *path, const char *end)
{
    size_t bytes = strlen(path) + strlen(end) + 32;
    *out = kn_alloc(ctx, bytes, 1);
    if (!*out) return KN_ENOMEM;
    if (*end)
        snprintf(*out, bytes, "%s.tmp-%ld%s", path, (long)getpid(), end);
    else
        memcpy(*out, path, strlen(path) + 1);
    return KN_OK;
}

// The file gets its name by being renamed, which would replace a pipe or a device.
static kn_status check_place(kn_ctx *ctx, const char *path)
{
    struct stat there;
    if (stat(path, &there) != 0 || S_ISREG(there.st_mode)) return KN_OK;
    return kn_fail(ctx, KN_EIO, "%s: cannot create: it is there, and no file", path);
}

kn_status cli_rhino_sink(kn_ctx *ctx, kn_sink *out, const char *path, double unit_mm)
{
    rhino *r = kn_alloc_zero(ctx, 1, sizeof *r);
    if (!r) return KN_ENOMEM;
    r->unit_mm = unit_mm > 0.0 ? unit_mm : 1.0;
    kn_status status = check_place(ctx, path);
    if (status == KN_OK) status = join_path(ctx, &r->path, path, "");
    if (status == KN_OK) status = join_path(ctx, &r->made, path, ".3dm");
    if (status == KN_OK) status = join_path(ctx, &r->between, path, ".g2");
    if (status == KN_OK) status = kn_g2_sink(ctx, &r->splines, r->between);
    if (status != KN_OK) {
        rhino_close(ctx, r);
        return status;
    }
    *out = (kn_sink){.user = r,
                     .begin = rhino_begin,
                     .work = rhino_work,
                     .commit = rhino_commit,
                     .discard = rhino_discard,
                     .end = rhino_end,
                     .close = rhino_close,
                     .bytes = rhino_bytes};
    return KN_OK;
}
