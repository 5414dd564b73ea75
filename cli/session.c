// SPDX-License-Identifier: Apache-2.0
// A command's context: progress on stderr, Ctrl-C as cancellation, errors as exit codes.
#include "cli/cli.h"

#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

struct cli_session {
    kn_ctx *ctx;
    bool quiet, terminal, line_open;
    char stage[32];
    double stage_began, last_shown;
};

static volatile sig_atomic_t interrupted;

static void on_signal(int number)
{
    (void)number;
    interrupted = 1;
}

double cli_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void end_line(cli_session *s)
{
    if (s->line_open) fputs("\r\033[K", stderr);
    s->line_open = false;
}

// On a terminal one line that changes; elsewhere a line every ten seconds of long work, and nothing for short work.
static void show(cli_session *s, const char *stage, double fraction)
{
    double now = cli_seconds();
    if (strncmp(stage, s->stage, sizeof s->stage - 1) != 0) {
        snprintf(s->stage, sizeof s->stage, "%s", stage);
        s->stage_began = s->last_shown = now;
    }
    double elapsed = now - s->stage_began;
    if (now - s->last_shown < (s->terminal ? 0.1 : 10.0) || fraction <= 0) return;
    s->last_shown = now;
    double left = fraction < 1 ? elapsed * (1 - fraction) / fraction : 0;
    if (s->terminal)
        fprintf(stderr, "\r\033[K%s %3.0f %%, %.0f s left", stage, 100 * fraction, left), s->line_open = true;
    else
        fprintf(stderr, "knurl: %s %.0f %%, about %.0f s left\n", stage, 100 * fraction, left);
    fflush(stderr);
}

static int on_progress(void *user, const char *stage, double fraction)
{
    cli_session *s = user;
    if (!s->quiet) show(s, stage, fraction);
    return interrupted != 0;
}

static void on_log(void *user, kn_log_level level, const char *message)
{
    cli_session *s = user;
    if (s->quiet || level < KN_LOG_WARNING) return;
    end_line(s);
    fprintf(stderr, "knurl: warning: %s\n", message);
}

void cli_warn(cli_session *s, const char *format, ...)
{
    char message[1024];
    va_list list;
    va_start(list, format);
    vsnprintf(message, sizeof message, format, list);
    va_end(list);
    on_log(s, KN_LOG_WARNING, message);
}

cli_session *cli_session_begin(cli_session_options options)
{
    cli_session *s = calloc(1, sizeof *s);
    kn_ctx_options o = kn_ctx_defaults();
    o.log = on_log;
    o.progress = on_progress;
    o.user = s;
    o.threads = options.threads;
    if (!s || kn_ctx_create(&s->ctx, &o) != KN_OK) {
        cli_error("out of memory");
        free(s);
        return NULL;
    }
    s->quiet = options.quiet;
    const char *kind = getenv("TERM");
    s->terminal = isatty(STDERR_FILENO) && !(kind && strcmp(kind, "dumb") == 0);
    struct sigaction action = {.sa_handler = on_signal}, before;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    bool keeps = sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler == SIG_IGN; // under nohup
    if (!keeps) sigaction(SIGHUP, &action, NULL);
    // A file-size limit, a pipe without a reader: they then show as a failed write, which cleans up after itself.
    signal(SIGXFSZ, SIG_IGN);
    signal(SIGPIPE, SIG_IGN);
    return s;
}

void cli_session_end(cli_session *session)
{
    if (!session) return;
    end_line(session);
    kn_ctx_destroy(session->ctx);
    free(session);
}

kn_ctx *cli_ctx(cli_session *session)
{
    return session->ctx;
}

static void print_failure(cli_session *session, kn_status status, const char *path)
{
    end_line(session);
    const char *message = kn_ctx_message(session->ctx);
    if (path && strncmp(message, path, strlen(path)) == 0) path = NULL; // named already
    cli_error("%s%s%s", path ? path : "", path ? ": " : "", *message ? message : kn_status_name(status));
}

static int exit_code(kn_status status, bool reading)
{
    switch (status) {
    case KN_OK: return EXIT_OK;
    case KN_EPARSE:
    case KN_EDOMAIN:
    case KN_ELIMIT:
    case KN_EUNDEFINED: return EXIT_BAD_INPUT;
    case KN_EUNDECIDED: return EXIT_CHECK_FAILED;
    case KN_ECANCELLED: return EXIT_CANCELLED;
    case KN_EIO: return reading ? EXIT_BAD_INPUT : EXIT_FAILED;
    case KN_ENOMEM:
    case KN_ENOTBUILT: return EXIT_FAILED;
    }
    return EXIT_FAILED;
}

int cli_fail(cli_session *session, kn_status status, bool reading)
{
    print_failure(session, status, NULL);
    return exit_code(status, reading);
}

int cli_fail_at(cli_session *session, kn_status status, const char *format, ...)
{
    char message[1024];
    va_list list;
    va_start(list, format);
    vsnprintf(message, sizeof message, format, list);
    va_end(list);
    end_line(session);
    cli_error("%s", message);
    return exit_code(status, false);
}

int cli_fail_on(cli_session *session, kn_status status, const char *path, bool reading)
{
    bool blame = status == KN_EDOMAIN || status == KN_ELIMIT || status == KN_EUNDEFINED || status == KN_EUNDECIDED;
    print_failure(session, status, blame ? path : NULL);
    return exit_code(status, reading);
}
