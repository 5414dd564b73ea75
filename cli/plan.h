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
    const cli_base *base; // on whose surfaces all that is written lies; NULL: some lies on another layer
} cli_plan;

// Plans every layer; composes those that others lie on. Exit code.
int cli_plan_begin(cli_session *session, cli_plan *plan, const cli_recipe *recipe, const cli_inputs *inputs);
void cli_plan_end(cli_session *session, cli_plan *plan);

// ---- cli/limits.c ----
// kn_job_create; where the degrees of the layer leave no room, with all that there are: CAD files are limited later.
kn_status cli_create_job(kn_ctx *ctx, kn_job **out, const kn_spline *surfaces, int n, const kn_tile *tile,
                         const cli_job *layer);
// Sinks of a run, with those of CAD files behind one that limits degrees, and what became of that.
typedef struct cli_fit {
    kn_sink sinks[CLI_MAX_OUTPUTS];
    int nsinks;
    kn_limit_options options;
    kn_limit_summary sum;
    kn_merge_summary merged;
    bool known, estimated, merge;
} cli_fit;
// in:     opened: n sinks, fit's from here on, which after a failure are closed; cad[i]: whether it is one of a CAD
//         file. The fit stays where it is until they are closed.
kn_status cli_fit_sinks(kn_ctx *ctx, cli_fit *fit, const kn_sink *opened, const bool *cad, int n, const cli_job *job);
// The same as an estimate, from a few cells of each layer that is written.
kn_status cli_estimate_fit(kn_ctx *ctx, cli_fit *fit, const cli_plan *plan, const cli_job *job);
struct json_t *cli_fit_json(const cli_fit *fit);
void cli_print_fit(const cli_fit *fit);

#endif
