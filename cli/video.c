// SPDX-License-Identifier: Apache-2.0
// A video of numbered pictures, by the program ffmpeg.
#include "cli/cli.h"
#include "kernel/context.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MAX_PATH = 2048 };

// Its exit status, or -1. A signal that cancels the command ends it too.
static int wait_for(kn_ctx *ctx, pid_t child, kn_status *status)
{
    int code = 0;
    while (waitpid(child, &code, 0) < 0) {
        if (errno != EINTR) return -1;
        *status = kn_progress(ctx, "video", 0.5);
        if (*status != KN_OK) kill(child, SIGKILL);
    }
    if (*status == KN_OK) *status = kn_progress(ctx, "video", 1.0); // it may have got the signal alone
    return WIFEXITED(code) ? WEXITSTATUS(code) : -1;
}

// '%' stands for the number of a picture, "%%" for itself.
static bool make_pattern(char out[MAX_PATH], const char *path)
{
    size_t n = (size_t)snprintf(out, MAX_PATH, "file:"), stem = strlen(path) - 4; // names may hold ":"
    for (size_t i = 0; i < stem && n < MAX_PATH - 16; i++) {
        if (path[i] == '%') out[n++] = '%';
        out[n++] = path[i];
    }
    (void)snprintf(out + n, MAX_PATH - n, "-%%04d.png");
    return n < MAX_PATH - 16;
}

int cli_make_video(cli_session *session, const char *out, double frames_per_second)
{
    extern char **environ;
    char pattern[MAX_PATH], rate[32], part[MAX_PATH];
    (void)snprintf(rate, sizeof rate, "%.6g", frames_per_second);
    int n = snprintf(part, sizeof part, "file:%s.%ld.tmp", out, (long)getpid());
    if (n < 0 || n >= MAX_PATH || !make_pattern(pattern, out)) {
        cli_error("animate: the name of '%s' is too long", out);
        return EXIT_FAILED;
    }
    char program[] = "ffmpeg", quiet[] = "-loglevel", error[] = "error", silent[] = "-nostdin", over[] = "-y",
         rates[] = "-framerate", kind[] = "-f", pictures[] = "image2", input[] = "-i", exact[] = "-bitexact",
         format[] = "-pix_fmt", yuv[] = "yuv420p", mp4[] = "mp4";
    char *argv[] = {program, quiet,   error, silent, over, kind, pictures, rates, rate,
                    input,   pattern, exact, format, yuv,  kind, mp4,      part,  NULL};
    pid_t child;
    if (posix_spawnp(&child, program, NULL, NULL, argv, environ) != 0) {
        cli_error("animate: no ffmpeg here to make '%s'; its frames are beside it", out);
        return EXIT_FAILED;
    }
    kn_status status = KN_OK;
    int code = wait_for(cli_ctx(session), child, &status);
    const char *made = part + strlen("file:");
    if (status == KN_OK && code == 0 && rename(made, out) == 0) return EXIT_OK;
    unlink(made);
    if (status != KN_OK) return cli_fail(session, status, false);
    cli_error("animate: %s '%s'; its frames are beside it",
              code == 0 ? "cannot rename a file to" : "ffmpeg could not make", out);
    return EXIT_FAILED;
}
