// SPDX-License-Identifier: Apache-2.0
// The jobs of a recipe's layers, on the base or on each other, and one report of them all.
#include "cli/plan.h"

static bool is_base(const cli_recipe *recipe, int layer)
{
    for (int i = 0; i < recipe->nlayers; i++)
        if (recipe->layer[i].on == layer + 1) return true;
    return false;
}

// The composed patches of a layer, as a base.
static int collect(cli_session *session, cli_plan *plan, int layer)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_sink sink;
    kn_status status = kn_collect_sink(ctx, &sink, &plan->collected[layer]);
    if (status != KN_OK) return cli_fail(session, status, false);
    status = kn_job_run(ctx, plan->jobs[layer], &sink, 1);
    kn_sink_close(ctx, &sink);
    return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
}

static int plan_layer(cli_session *session, cli_plan *plan, const cli_recipe *recipe, const cli_inputs *inputs, int i)
{
    const cli_job *layer = &recipe->layer[i];
    const kn_spline *surfaces = inputs->base.surfaces;
    int n = inputs->base.nsurfaces;
    if (layer->on > 0) {
        surfaces = plan->collected[layer->on - 1].splines;
        n = plan->collected[layer->on - 1].nsplines;
    }
    kn_status status = cli_create_job(cli_ctx(session), &plan->jobs[i], surfaces, n, &inputs->tile[i], layer);
    if (status != KN_OK && layer->on > 0)
        return cli_fail_at(session, status, "%s: layer %d, on layer %d: %s", layer->base, i + 1, layer->on,
                           kn_ctx_message(cli_ctx(session)));
    if (status != KN_OK) return cli_fail_on_job(session, status, layer, &inputs->base);
    plan->njobs = i + 1;
    if (!layer->base_only) {
        plan->shown_layer[plan->nshown] = i;
        plan->shown[plan->nshown++] = plan->jobs[i];
    }
    return is_base(recipe, i) ? collect(session, plan, i) : EXIT_OK;
}

int cli_plan_begin(cli_session *session, cli_plan *plan, const cli_recipe *recipe, const cli_inputs *inputs)
{
    int code = EXIT_OK;
    plan->base = &inputs->base;
    for (int i = 0; i < recipe->nlayers && code == EXIT_OK; i++) {
        if (recipe->layer[i].on > 0 && !recipe->layer[i].base_only) plan->base = NULL;
        code = plan_layer(session, plan, recipe, inputs, i);
    }
    if (code == EXIT_OK) plan->report = kn_job_describe_layers(plan->shown, plan->nshown);
    return code;
}

void cli_plan_end(cli_session *session, cli_plan *plan)
{
    for (int i = 0; i < CLI_MAX_LAYERS; i++) {
        kn_job_destroy(cli_ctx(session), plan->jobs[i]);
        kn_model_clear(cli_ctx(session), &plan->collected[i]);
    }
    *plan = (cli_plan){0};
}
