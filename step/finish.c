// SPDX-License-Identifier: Apache-2.0
// The end of a STEP file: edges that stay open, shells, those of a host body, surface models and representations.
#include "step/join.h"

#include "kernel/context.h"

enum { LONG_TEXT = 1 << 20 };

typedef struct open_shell {
    uint64_t number;
    int look;
} open_shell;

bool kn_step_join_is_list(const kn_step_join *j, int body)
{
    bool is = body == j->solids || body == j->styled || body == j->placed;
    for (int i = 0; i < j->nlooks; i++) is = is || body == j->looks[i].curves;
    return is;
}

// Solids of the shells that waited for others of their bodies.
static kn_status put_solids(kn_ctx *ctx, kn_step_join *j, kn_text *out, kn_status (*put)(void *user, kn_text *out),
                            void *user)
{
    kn_status status = KN_OK;
    kn_closed_shells_sort(&j->closed);
    for (size_t at = 0, n = 0; status == KN_OK && kn_closed_shells_next(&j->closed, &at, &n);) {
        const kn_closed_shell *first = &j->closed.list[at];
        status = kn_step_join_put_solid(ctx, j, out, &first->id, first->look, first, n);
        if (status == KN_OK && out->bytes > LONG_TEXT) status = put(user, out);
    }
    return status;
}

// An open shell for each body that is not closed.
static kn_status put_shells(kn_ctx *ctx, kn_step_join *j, kn_text *out, open_shell **shells,
                            kn_status (*put)(void *user, kn_text *out), void *user)
{
    size_t room = 0;
    kn_status status = KN_OK;
    for (int body = KN_BREP_NONE; status == KN_OK && kn_brep_next_body(j->brep, &body);) {
        if (kn_step_join_is_list(j, body) || kn_brep_held(j->brep, body)) continue;
        if (j->nshells == room) {
            room = room > 0 ? 2 * room : 16;
            open_shell *more = kn_resize(ctx, *shells, room, sizeof *more);
            if (more == NULL) return KN_ENOMEM;
            *shells = more;
        }
        int look = kn_brep_look(j->brep, body);
        (*shells)[j->nshells++] = (open_shell){j->next, look};
        kn_step_put_number(out, j->next++);
        kn_text_put(out, "OPEN_SHELL(");
        kn_text_step_string(out, look != KN_BREP_NONE ? j->looks[look].name : "");
        kn_text_put(out, ",(");
        status = kn_step_join_put_list(j->brep, body, out, put, user);
        kn_text_put(out, "));\n");
        if (status == KN_OK && look == KN_BREP_NONE) status = kn_step_join_style_body(ctx, j, out, 0, body);
    }
    return status;
}

static kn_status check_shell(kn_ctx *ctx, const kn_step_join *j, int k)
{
    const kn_step_shell *shell = &j->host->shells[k];
    int root = kn_brep_root(j->brep, j->held[k]);
    bool odd;
    uint32_t open = kn_brep_waiting(j->brep, root, &odd);
    for (int i = 0; i < k; i++)
        if (kn_brep_root(j->brep, j->held[i]) == root)
            return kn_fail(ctx, KN_EDOMAIN, "STEP: patches join shells #%u and #%u of the body",
                           j->host->shells[i].number, shell->number);
    if (!shell->closed || (open == 0 && !odd)) return KN_OK;
    if (open == 0)
        return kn_fail(ctx, KN_EDOMAIN,
                       "STEP: patches look out of shell #%u of the body at one side of an edge, and "
                       "into it at the other",
                       shell->number);
    return kn_fail(ctx, KN_EDOMAIN, "STEP: shell #%u of the body would be open: %u edges have one face only",
                   shell->number, open);
}

// The host's shells: faces that stay, then patches.
static kn_status put_host_shells(kn_ctx *ctx, kn_step_join *j, kn_text *out,
                                 kn_status (*put)(void *user, kn_text *out), void *user)
{
    kn_status status = KN_OK;
    for (int k = 0; j->host && k < j->host->nshells && status == KN_OK; k++) {
        const kn_step_shell *shell = &j->host->shells[k];
        int root = kn_brep_root(j->brep, j->held[k]);
        status = check_shell(ctx, j, k);
        if (status != KN_OK) return status;
        kn_step_put_number(out, shell->number);
        kn_text_put(out, shell->closed ? "CLOSED_SHELL('',(" : "OPEN_SHELL('',(");
        for (int i = 0; i < shell->nfaces; i++) {
            if (i > 0) kn_text_comma(out);
            kn_text_reference(out, shell->faces[i]);
        }
        kn_brep_walk walk = kn_brep_faces(j->brep, root);
        if (shell->nfaces > 0 && walk.left > 0) kn_text_comma(out);
        status = kn_step_join_put_list(j->brep, root, out, put, user);
        kn_text_put(out, "));\n");
        if (status == KN_OK) status = kn_step_join_style_faces(ctx, j, out, root, put, user);
    }
    return status;
}

// One surface model of all shells of a look, the last one of those that have several. *written: number, or 0.
static kn_status put_model(kn_step_join *j, kn_text *out, const open_shell *shells, int look, uint64_t number,
                           bool *written, kn_status (*put)(void *user, kn_text *out), void *user)
{
    kn_status status = KN_OK;
    *written = false;
    for (uint64_t i = 0; i < j->nshells && status == KN_OK; i++) {
        if (shells[i].look != look) continue;
        if (!*written) {
            kn_step_put_number(out, number);
            kn_text_put(out, "SHELL_BASED_SURFACE_MODEL(");
            kn_text_step_string(out, look != KN_BREP_NONE ? j->looks[look].name : "");
            kn_text_put(out, ",(");
        } else {
            kn_text_comma(out);
        }
        *written = true;
        kn_text_reference(out, shells[i].number);
        if (out->bytes > LONG_TEXT) status = put(user, out);
    }
    if (*written) kn_text_put(out, "));\n");
    return status;
}

// Curves of a look as a set, numbered behind its surface model.
static kn_status put_curves(kn_step_join *j, kn_text *out, int look, kn_status (*put)(void *user, kn_text *out),
                            void *user)
{
    kn_step_put_number(out, kn_step_look_number(j, look) + 1);
    kn_text_put(out, "GEOMETRIC_CURVE_SET(");
    kn_text_step_string(out, j->looks[look].name);
    kn_text_put(out, ",(");
    kn_status status = kn_step_join_put_list(j->brep, j->looks[look].curves, out, put, user);
    kn_text_put(out, "));\n");
    return status;
}

static const char *representation(const kn_step_join *j)
{
    if (j->placed != KN_BREP_NONE) return "SHAPE_REPRESENTATION";
    if (j->ncurves > 0)
        return j->nsolids + j->nshells > 0 ? "SHAPE_REPRESENTATION"
                                           : "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION";
    if (j->nsolids > 0) return j->nshells > 0 ? "SHAPE_REPRESENTATION" : "ADVANCED_BREP_SHAPE_REPRESENTATION";
    return "MANIFOLD_SURFACE_SHAPE_REPRESENTATION";
}

// "('',(" what is told, then the numbers of a list "),#15);"
static kn_status put_representation(const kn_step_join *j, kn_text *out, uint64_t number, const char *name,
                                    const uint64_t *items, int nitems, int body, uint64_t context,
                                    kn_status (*put)(void *user, kn_text *out), void *user)
{
    kn_step_put_number(out, number);
    kn_text_put(out, name);
    kn_text_put(out, "('',(");
    for (int i = 0; i < nitems; i++) {
        if (i > 0) kn_text_comma(out);
        kn_text_reference(out, items[i]);
    }
    kn_brep_walk walk = kn_brep_faces(j->brep, body);
    if (nitems > 0 && walk.left > 0) kn_text_comma(out);
    kn_status status = kn_step_join_put_list(j->brep, body, out, put, user);
    kn_text_put(out, "),");
    kn_text_reference(out, context);
    kn_text_put(out, ");");
    kn_text_newline(out);
    return status;
}

// What belongs to no shell of a host: the product's representation, and its own beginning where a host has the file's.
static kn_status put_product(kn_step_join *j, kn_text *out, const uint64_t *items, int nitems,
                             kn_status (*put)(void *user, kn_text *out), void *user)
{
    uint64_t context = j->origin + KN_STEP_GEOMETRY_CONTEXT;
    if (j->host && j->nsolids + j->nshells + j->ncurves == 0) return KN_OK;
    if (j->host) {
        kn_step_put_product(out, j->origin, j->about);
        kn_step_put_units(out, j->origin, j->about);
    }
    return put_representation(j, out, j->origin + KN_STEP_REPRESENTATION, representation(j), items, nitems, j->solids,
                              context, put, user);
}

static kn_status put_end(kn_ctx *ctx, kn_step_join *j, kn_text *out, open_shell **shells, uint64_t *items,
                         kn_status (*put)(void *user, kn_text *out), void *user)
{
    int nitems = 0;
    bool written;
    items[nitems++] = j->origin + KN_STEP_PLACEMENT;
    kn_brep_open_edge open;
    kn_status status = KN_OK;
    for (size_t at = 0; status == KN_OK && kn_brep_next_edge(j->brep, &at, &open);) {
        kn_step_join_put_edge(
            j, out,
            &(kn_brep_name){.vertex = {open.vertex[0], open.vertex[1]}, .edge = open.edge, .pcurve = {open.pcurve}});
        if (out->bytes > LONG_TEXT) status = put(user, out);
    }
    if (status == KN_OK) status = put_host_shells(ctx, j, out, put, user);
    if (status == KN_OK) status = put_solids(ctx, j, out, put, user);
    if (status == KN_OK) status = put_shells(ctx, j, out, shells, put, user);
    for (int i = 0; i < j->nlooks && status == KN_OK; i++) {
        uint64_t first = kn_step_look_number(j, i);
        status = put_model(j, out, *shells, i, first, &written, put, user);
        if (written) items[nitems++] = first;
        if (status == KN_OK && written) status = kn_step_join_style(ctx, j, out, first, i);
        if (status == KN_OK && j->looks[i].curves != KN_BREP_NONE) {
            items[nitems++] = first + 1;
            status = put_curves(j, out, i, put, user);
        }
        if (j->looks[i].used) kn_step_put_style(out, &j->looks[i].material, first);
    }
    if (status == KN_OK) status = put_model(j, out, *shells, KN_BREP_NONE, j->next, &written, put, user);
    if (status == KN_OK && written) items[nitems++] = j->next++;
    if (status == KN_OK) status = put_product(j, out, items, nitems, put, user);
    if (status == KN_OK && j->nstyled > 0)
        status = put_representation(j, out, j->origin + KN_STEP_PRESENTATION,
                                    "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION", NULL, 0, j->styled,
                                    j->host ? j->host->context : j->origin + KN_STEP_GEOMETRY_CONTEXT, put, user);
    return status;
}

kn_status kn_step_join_end(kn_ctx *ctx, kn_step_join *j, kn_text *out, kn_status (*put)(void *user, kn_text *out),
                           void *user)
{
    open_shell *shells = NULL;
    uint64_t *items = kn_alloc(ctx, 2 * (size_t)j->nlooks + 2, sizeof *items);
    kn_status status = items ? put_end(ctx, j, out, &shells, items, put, user) : KN_ENOMEM;
    kn_free(ctx, items), kn_free(ctx, shells);
    return status == KN_OK && out->failed ? KN_ENOMEM : status;
}
