// SPDX-License-Identifier: Apache-2.0
// The layers of a recipe, or the one that options describe, and what they are made of.
#include "cli/cli.h"

void cli_recipe_begin(cli_recipe *recipe)
{
    *recipe = (cli_recipe){.nlayers = 1};
    recipe->layer[0] = cli_job_defaults();
}

bool cli_recipe_set(cli_recipe *recipe, int option, const char *value)
{
    bool ok = true;
    for (int i = 0; i < recipe->nlayers && ok; i++) ok = cli_job_set(&recipe->layer[i], option, value);
    return ok;
}

int cli_recipe_base(cli_recipe *recipe, const char *path)
{
    if (cli_has_ending(path, "json")) return cli_read_recipe(recipe, path);
    recipe->layer[0].base = path;
    return EXIT_OK;
}

const char *cli_recipe_conflict(const cli_recipe *recipe)
{
    const char *conflict = NULL;
    for (int i = 0; i < recipe->nlayers && !conflict; i++) conflict = cli_job_conflict(&recipe->layer[i]);
    return conflict;
}

int cli_inputs_begin(cli_session *session, cli_inputs *inputs, cli_recipe *recipe)
{
    int code = EXIT_OK;
    for (int i = 0; i < recipe->nlayers && code == EXIT_OK; i++) {
        code = cli_read_job_tile(session, &inputs->tile[i], &recipe->layer[i]);
        if (code == EXIT_OK) code = cli_job_begin(session, &recipe->layer[i]);
    }
    if (code == EXIT_OK) code = cli_read_base(session, &inputs->base, recipe->layer[0].base, true);
    if (code == EXIT_OK) code = cli_choose_faces(session, recipe->layer, recipe->nlayers, &inputs->base);
    for (int i = 0; i < recipe->nlayers && code == EXIT_OK; i++) {
        kn_status status = cli_take_face_colors(cli_ctx(session), &recipe->layer[i], &inputs->tile[i], &inputs->base);
        if (status != KN_OK) code = cli_fail(session, status, false);
    }
    return code;
}

void cli_inputs_end(cli_session *session, cli_inputs *inputs, cli_recipe *recipe)
{
    cli_base_clear(session, &inputs->base);
    for (int i = 0; i < recipe->nlayers; i++) {
        kn_tile_clear(cli_ctx(session), &inputs->tile[i]);
        cli_job_end(session, &recipe->layer[i]);
    }
}
