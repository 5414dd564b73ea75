// SPDX-License-Identifier: Apache-2.0
// Options of a run: threads and what is said.
#include "cli/cli.h"

enum { THREADS, JSON, QUIET, OPTIONS };
static const cli_option options[OPTIONS] = {
    [THREADS] = {"threads", 'j', CLI_TEXT}, [JSON] = {"json", 0, CLI_NOTHING}, [QUIET] = {"quiet", 'q', CLI_NOTHING}};

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    switch (option) {
    case THREADS: return cli_int(name, text, 1, 1024, &job->threads);
    case JSON: return job->json = true;
    case QUIET: return job->quiet = true;
    default: return false;
    }
}

const cli_theme cli_running_options = {options, OPTIONS, CLI_OF_RUN, set};
