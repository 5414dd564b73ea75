// SPDX-License-Identifier: Apache-2.0
// The jobs of a recipe's layers, on the base or on each other.
#ifndef CLI_PLAN_H
#define CLI_PLAN_H

#include "cli/cli.h"

// Zero is empty; cli_plan_end ends it.
typedef struct cli_plan {
    kn_job *jobs[CLI_MAX_LAYERS]; // of all layers
    int njobs;
    const kn_job *shown[CLI_MAX_LAYERS]; // those that are written
    int shown_layer[CLI_MAX_LAYERS];     // which layers they are
    int nshown;
    kn_model collected[CLI_MAX_LAYERS]; // what other layers lie on
    kn_job_report report;               // of those that are written, in one
} cli_plan;

// Plans every layer; composes those that others lie on. Exit code.
int cli_plan_begin(cli_session *session, cli_plan *plan, const cli_recipe *recipe, const cli_inputs *inputs);
void cli_plan_end(cli_session *session, cli_plan *plan);

#endif
