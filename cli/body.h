// SPDX-License-Identifier: Apache-2.0
// What becomes of the body that a CAD base is: its faces stay, and those with a texture are replaced or covered.
#ifndef CLI_BODY_H
#define CLI_BODY_H

#include "cli/border.h"

// A part of the border of a replaced face along one edge of the model, beyond which a face stays.
typedef struct cli_body_chain {
    int edge, surface;
    const cli_border_edge *edges; // n of them, one after the other, of the border
    size_t n;
    bool forward; // the boundary of the face that stays runs from the first one to the last
} cli_body_chain;

typedef struct cli_body_plan {
    cli_body_chain *chains;
    size_t nchains, room;
    int *replaced; // faces of the model, nreplaced of them
    int nreplaced;
    char why[512]; // not "": nothing can be replaced
} cli_body_plan;

// Which edges of the model the texture's border meets. face: of the model, for each of the base's surfaces (-1: none);
// turn: its quarter turns against that (NULL: none is turned);
// the border is sorted, and holds those of all layers. out: what holds before stays in it; cli_body_plan_clear.
kn_status cli_body_plan_add(kn_ctx *ctx, cli_body_plan *out, const kn_cad *cad, const int *face, const int *turn,
                            int nsurfaces, const cli_border *border);
void cli_body_plan_clear(kn_ctx *ctx, cli_body_plan *plan);

// What knurl-cad wrote, read; for kn_step_sink.
typedef struct cli_body {
    int replaced, kept; // faces
    double gap;         // mm, between the texture's border and the edges that it meets
    kn_step_host host;  // entities NULL: there is none
    char *text;         // what the rest is made of
    kn_step_shell *shells;
    uint32_t *faces;
    int *shell_of;
    kn_step_seed *seeds;
} cli_body;
// The request to knurl-cad, and its answer (text: *bytes of it, the body's from now on when all goes well). plan NULL:
// nothing is replaced.
kn_status cli_body_request(kn_ctx *ctx, char **text, size_t *bytes, const cli_body_plan *plan, double tolerance);
kn_status cli_body_parse(kn_ctx *ctx, cli_body *out, const char *name, char *text, size_t bytes,
                         const cli_body_plan *plan, const int *face, const cli_base *base);
void cli_body_clear(kn_ctx *ctx, cli_body *body);

// ---- cli/body_run.c: the body of a run ----
typedef struct cli_body_run {
    cli_body_mode mode; // CLI_BODY_NONE: there is no body, else replace or cover
    bool closed;        // all shells that patches take a place in
    cli_body body;
    cli_border border;
    cli_body_plan plan; // plan.why: why faces are covered that could have been replaced
    int *face;          // of the model, of each surface of the base that a covering tile is on; -1
} cli_body_run;
// What the recipe's outputs need. It stays where it is until cli_body_end. Exit code.
int cli_body_begin(cli_session *session, cli_body_run *run, const cli_apply *a, const struct cli_plan *plan,
                   const cli_inputs *inputs);
void cli_body_end(cli_session *session, cli_body_run *run);
struct json_t *cli_body_json(const cli_body_run *run);
void cli_print_body(const cli_body_run *run);

#endif
