// SPDX-License-Identifier: Apache-2.0
// A run noted in a file, so that it can be gone on with after an interruption.
#include <knurl/io.h>

#include "io/in_file.h"
#include "io/io_error.h"
#include "io/out_file.h"
#include "kernel/context.h"

#include <errno.h>
#include <stdio.h>
#include <sys/stat.h>

typedef struct journal_file {
    const char *path;
    bool there;
} journal_file;

static kn_status note(kn_ctx *ctx, void *user, const unsigned char *state, size_t bytes)
{
    journal_file *journal = user;
    kn_out_file *file = NULL;
    kn_status status = kn_out_open(ctx, &file, journal->path);
    if (status != KN_OK) return status;
    status = kn_out_write(ctx, file, state, bytes);
    if (status == KN_OK) status = kn_out_commit(ctx, file);
    kn_out_close(ctx, file);
    journal->there = journal->there || status == KN_OK;
    return status;
}

kn_status kn_run_with_journal(kn_ctx *ctx, const kn_job *const *jobs, int njobs, kn_sink *sinks, int nsinks,
                              const char *journal, bool resume, double seconds, uint64_t identity)
{
    journal_file to = {.path = journal};
    kn_job_notes notes = {.user = &to, .note = note, .seconds = seconds, .identity = identity};
    struct stat there;
    char *text = NULL;
    size_t bytes = 0;
    kn_status status = KN_OK;
    if (resume && stat(journal, &there) == 0) {
        status = kn_in_read(ctx, &text, &bytes, journal);
        notes.state = (const unsigned char *)text;
        notes.bytes = bytes;
        to.there = true;
    }
    if (status == KN_OK)
        status = njobs == 1 ? kn_job_run_from(ctx, jobs[0], sinks, nsinks, &notes)
                            : kn_job_run_layers_from(ctx, jobs, njobs, sinks, nsinks, &notes);
    kn_free(ctx, text);
    for (int k = 0; k < nsinks && status != KN_OK && !to.there; k++)
        if (sinks[k].forget) sinks[k].forget(sinks[k].user);
    errno = 0;
    if (status == KN_OK && remove(journal) != 0 && errno != ENOENT)
        status = kn_fail_io(ctx, journal, "cannot remove", errno);
    return status;
}
