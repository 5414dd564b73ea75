// SPDX-License-Identifier: Apache-2.0
// Several faces of a CAD file as one domain where they meet smoothly, and what is said of the edges between them.
#include "cli/cli.h"

#include <jansson.h>
#include <string.h>

static const double degree = 0.017453292519943295;

// Surfaces and trims of the base become those of the faces as they are joined.
static kn_status take_joined(kn_ctx *ctx, cli_base *base, kn_cad_joined *joined)
{
    bool trimmed = false;
    for (int i = 0; i < joined->n; i++) trimmed = trimmed || joined->trims[i].nloops > 0;
    for (int i = 0; i < joined->n; i++) {
        kn_spline_swap(&base->surfaces[i], &joined->surfaces[i]);
        kn_spline_clear(ctx, &joined->surfaces[i]);
        if (!trimmed) continue;
        kn_trim_clear(ctx, &base->trims[i]); // there are some where a face is trimmed
        base->trims[i] = joined->trims[i];
        joined->trims[i] = (kn_trim){0};
    }
    return KN_OK;
}

kn_status cli_join_faces(kn_ctx *ctx, cli_job *jobs, int njobs, cli_base *base)
{
    kn_cad_join_options o = {.angle = jobs[0].join_angle * degree, .none = jobs[0].no_join};
    if (base->cad.nfaces == 0 || base->nsurfaces < 2) return KN_OK;
    kn_status status = kn_cad_join(ctx, &base->joined, &base->cad, base->face, base->nsurfaces, &o);
    if (status == KN_OK) status = take_joined(ctx, base, &base->joined);
    bool apart = false;
    for (int i = 0; status == KN_OK && i < base->joined.nseams; i++) apart = apart || !base->joined.seams[i].joined;
    int option = cli_job_find_key("trimmed", CLI_OF_LAYER, NULL);
    for (int i = 0; i < njobs && status == KN_OK; i++) {
        jobs[i].joined = &base->joined;
        if (apart && jobs[i].on == 0 && !cli_job_was_given(&jobs[i], option))
            jobs[i].options.trimmed = KN_TRIMMED_TAPER; // so that what is closed stays closed
    }
    return status;
}

json_t *cli_joined_json(const kn_cad_joined *joined)
{
    json_t *array = json_array();
    for (int i = 0; joined && i < joined->nseams; i++) {
        const kn_cad_seam *s = &joined->seams[i];
        json_array_append_new(array,
                              json_pack("{s:[i,i],s:b,s:o,s:o,s:o}", "faces", s->face[0], s->face[1], "joined",
                                        s->joined, "why", s->why ? json_string(s->why) : json_null(), "angle_deg",
                                        cli_json_number(s->angle / degree), "moved_mm", cli_json_upper(s->moved)));
    }
    return array;
}

void cli_print_joined(const kn_cad_joined *joined)
{
    int joins = 0;
    for (int i = 0; joined && i < joined->nseams; i++) joins += joined->seams[i].joined;
    if (joins > 0)
        printf("faces joined over %d edge%s, moved by %.1e mm at most\n", joins, joins == 1 ? "" : "s",
               cli_outward(joined->moved, 1, CLI_TEXT_DIGITS));
    for (int i = 0; joined && i < joined->nseams; i++) {
        const kn_cad_seam *s = &joined->seams[i];
        if (!s->joined)
            printf("faces %d and %d stay apart: %s (%.3g degrees)\n", s->face[0], s->face[1], s->why,
                   s->angle / degree);
    }
}
