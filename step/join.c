// SPDX-License-Identifier: Apache-2.0
// Faces of a STEP file with the edges and vertices that they share; bodies that are closed become solids at once.
#include "step/join.h"
#include "step/line.h"

#include "kernel/context.h"

#include <limits.h>
#include <string.h>

enum { LONG_TEXT = 1 << 20 };

uint64_t kn_step_look_number(const kn_step_join *j, int look)
{
    return j->origin + KN_STEP_PARTS + KN_STEP_PART_NUMBERS * (uint64_t)look;
}

// "#number=" and the form, whose every '#' is the next one of the references.
void kn_step_put_references(kn_text *text, uint64_t number, const char *form, const uint64_t *references)
{
    kn_step_put_number(text, number);
    const char *from = form;
    for (; *form != '\0'; form++) {
        if (*form != '#') continue;
        kn_text_bytes(text, from, (size_t)(form - from));
        kn_text_reference(text, *references++);
        from = form + 1;
    }
    kn_text_put(text, from);
    kn_text_newline(text);
}

// ---- life ----

// An edge of the host as brep knows it.
static kn_status seed(kn_ctx *ctx, kn_step_join *j, const kn_step_seed *s, double mm)
{
    const kn_step_host *host = j->host;
    kn_patch_curve line = {0};
    bool turned, unused;
    if (s->shell < 0 || s->shell >= host->nshells || kn_spline_dim(&s->curve) != 3 || s->curve.nvars != 1)
        return kn_fail(ctx, KN_EDOMAIN, "STEP: edge #%u of the body: shell %d of %d, a curve of dimension %d",
                       s->edge, s->shell, host->nshells, kn_spline_dim(&s->curve));
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_patch_curve_load(ctx, &line, &s->curve, 0, mm, "STEP");
    if (status == KN_OK) {
        const double *end[2] = {line.point, line.point + (line.axis.n - 1) * line.step};
        kn_brep_edge e = {.key = kn_patch_curve_key(&turned, &line)};
        uint64_t vertex[2] = {s->vertex[turned], s->vertex[!turned]};
        e.forward = s->forward != turned;
        for (int k = 0; k < 2; k++) e.vertex[k] = kn_brep_hash(&unused, end[turned ? 1 - k : k], 3, 1, 1, 0);
        status = kn_brep_seed(ctx, j->brep, s->body, j->held[s->shell], &e, s->edge, vertex, s->along == turned);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status begin_host(kn_ctx *ctx, kn_step_join *j, double mm)
{
    const kn_step_host *host = j->host;
    j->held = kn_alloc(ctx, (size_t)host->nshells + 1, sizeof *j->held);
    kn_status status = j->held ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < host->nshells && status == KN_OK; i++) status = kn_brep_hold(ctx, j->brep, &j->held[i]);
    for (int i = 0; i < host->nseeds && status == KN_OK; i++) status = seed(ctx, j, &host->seeds[i], mm);
    return status;
}

kn_status kn_step_join_begin(kn_ctx *ctx, kn_step_join *j, const kn_tile *tile, double mm)
{
    j->looks = kn_alloc_zero(ctx, (size_t)tile->nparts, sizeof *j->looks);
    if (j->looks == NULL) return KN_ENOMEM;
    j->nlooks = tile->nparts;
    for (int i = 0; i < tile->nparts; i++) {
        memcpy(j->looks[i].name, tile->parts[i].name, sizeof j->looks[i].name);
        j->looks[i].name[KN_NAME_BYTES - 1] = '\0';
        j->looks[i].material = tile->parts[i].material;
        j->looks[i].loose = j->looks[i].curves = KN_BREP_NONE;
    }
    j->placed = KN_BREP_NONE;
    j->origin = j->host ? j->host->numbers : 0;
    j->next = kn_step_look_number(j, tile->nparts);
    kn_status status = kn_brep_create(ctx, &j->brep);
    if (status == KN_OK) status = kn_brep_open(ctx, j->brep, &j->solids);
    if (status == KN_OK) status = kn_brep_open(ctx, j->brep, &j->styled);
    return status == KN_OK && j->host ? begin_host(ctx, j, mm) : status;
}

void kn_step_join_put_begin(const kn_step_join *j, kn_text *out)
{
    if (j->host) {
        kn_text_bytes(out, j->host->entities, j->host->bytes);
        if (j->host->bytes > 0 && j->host->entities[j->host->bytes - 1] != '\n') kn_text_newline(out);
        return;
    }
    kn_step_put_product(out, j->origin, j->about);
    kn_step_put_units(out, j->origin, j->about);
}

void kn_step_join_clear(kn_ctx *ctx, kn_step_join *j)
{
    kn_brep_destroy(ctx, j->brep);
    kn_free(ctx, j->looks), kn_free(ctx, j->held);
    kn_closed_shells_clear(ctx, &j->closed);
    *j = (kn_step_join){0};
}

// ---- bodies ----

// "(#1,#2,..)" of a body's faces.
kn_status kn_step_join_put_list(const kn_brep *brep, int body, kn_text *out,
                                kn_status (*put)(void *user, kn_text *out), void *user)
{
    kn_status status = KN_OK;
    kn_brep_walk walk = kn_brep_faces(brep, body);
    for (bool first = true; status == KN_OK && kn_brep_step(brep, &walk); first = false) {
        if (!first) kn_text_comma(out);
        kn_text_reference(out, walk.number);
        if (put != NULL && out->bytes > LONG_TEXT) status = put(user, out);
    }
    return status;
}

kn_status kn_step_join_style(kn_ctx *ctx, kn_step_join *j, kn_text *out, uint64_t item, int look)
{
    j->looks[look].used = true;
    kn_step_put_styled(out, j->next, kn_step_look_number(j, look), item);
    j->nstyled++;
    return kn_brep_append(ctx, j->brep, j->styled, j->next++, 0);
}

kn_status kn_step_join_style_faces(kn_ctx *ctx, kn_step_join *j, kn_text *out, int body,
                                   kn_status (*put)(void *user, kn_text *out), void *user)
{
    kn_status status = KN_OK;
    kn_brep_walk walk = kn_brep_faces(j->brep, body);
    while (status == KN_OK && kn_brep_step(j->brep, &walk)) {
        status = kn_step_join_style(ctx, j, out, walk.number, walk.look);
        if (status == KN_OK && put != NULL && out->bytes > LONG_TEXT) status = put(user, out);
    }
    return status;
}

// The item, or where its faces have several looks each of them.
kn_status kn_step_join_style_body(kn_ctx *ctx, kn_step_join *j, kn_text *out, uint64_t item, int body)
{
    int look = kn_brep_look(j->brep, body);
    return look != KN_BREP_NONE ? kn_step_join_style(ctx, j, out, item, look)
                                : kn_step_join_style_faces(ctx, j, out, body, NULL, NULL);
}

// Voids look out of what is solid: their shells are not turned.
kn_status kn_step_join_put_solid(kn_ctx *ctx, kn_step_join *j, kn_text *out, const kn_patch_id *id, int look,
                                 const kn_closed_shell *shells, size_t n)
{
    char name[KN_FACE_NAME_BYTES];
    uint64_t first = j->next, voids = first + n, solid = voids + n - 1;
    kn_status status = KN_OK;
    j->next = solid + 1;
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        kn_step_put_number(out, first + i);
        kn_text_put(out, "CLOSED_SHELL('',(");
        status = kn_step_join_put_list(j->brep, shells[i].brep, out, NULL, NULL);
        kn_text_put(out, "));\n");
    }
    for (size_t i = 1; i < n; i++)
        kn_step_put_references(out, voids + i - 1, "ORIENTED_CLOSED_SHELL('',*,#,.T.);", (uint64_t[]){first + i});
    kn_step_put_number(out, solid);
    kn_text_put(out, n > 1 ? "BREP_WITH_VOIDS(" : "MANIFOLD_SOLID_BREP(");
    kn_naming_write(name, j->naming, id, j->looks[look].name, false, true);
    kn_text_step_string(out, name);
    kn_text_char(out, ',');
    kn_text_reference(out, first);
    for (size_t i = 1; i < n; i++) {
        kn_text_put(out, i == 1 ? ",(" : ",");
        kn_text_reference(out, voids + i - 1);
    }
    kn_text_put(out, n > 1 ? "));" : ");");
    kn_text_newline(out);
    if (status == KN_OK) status = kn_brep_append(ctx, j->brep, j->solids, solid, 0);
    int common = kn_brep_look(j->brep, shells[0].brep);
    for (size_t i = 1; i < n; i++)
        if (kn_brep_look(j->brep, shells[i].brep) != common) common = KN_BREP_NONE;
    if (status == KN_OK && common != KN_BREP_NONE) status = kn_step_join_style(ctx, j, out, solid, common);
    for (size_t i = 0; i < n && status == KN_OK && common == KN_BREP_NONE; i++)
        status = kn_step_join_style_faces(ctx, j, out, shells[i].brep, NULL, NULL);
    j->nsolids++;
    for (size_t i = 0; i < n; i++) kn_brep_drop(j->brep, shells[i].brep);
    return status;
}

// A closed shell: a solid, or part of one of which others may come.
static kn_status take_closed(kn_ctx *ctx, kn_step_join *j, kn_text *out, const kn_step_item *item, int body)
{
    const kn_closed_shell closed = {
        .brep = body, .body = item->body, .shell = item->shell, .look = item->look, .id = item->id};
    if (item->body < 0) return kn_step_join_put_solid(ctx, j, out, &item->id, item->look, &closed, 1);
    return kn_closed_shells_add(ctx, &j->closed, closed);
}

// ---- items ----

// The edge, once all faces are known that use it: with what they call it in their own parameters.
void kn_step_join_put_edge(kn_step_join *j, kn_text *out, const kn_brep_name *name)
{
    uint64_t curve = name->edge - 1, pcurve[2] = {name->pcurve[0], name->pcurve[1]};
    if (pcurve[0] == 0) pcurve[0] = pcurve[1], pcurve[1] = 0;
    if (pcurve[0] > 0) {
        kn_step_put_references(out, j->next,
                               name->seam       ? "SEAM_CURVE('',#,(#,#),.CURVE_3D.);"
                               : pcurve[1] == 0 ? "SURFACE_CURVE('',#,(#),.CURVE_3D.);"
                                                : "SURFACE_CURVE('',#,(#,#),.CURVE_3D.);",
                               (uint64_t[]){curve, pcurve[0], pcurve[1]});
        curve = j->next++;
    }
    kn_step_put_references(out, name->edge, "EDGE_CURVE('',#,#,#,.T.);",
                           (uint64_t[]){name->vertex[0], name->vertex[1], curve});
}

// One face of an item: its loops, and all that they have.
typedef struct bounds {
    const kn_step_item *item;
    const kn_step_loop *loops;
    const kn_step_edge *edges;
    size_t nloops;
    int nedges;
    uint64_t base;
    const char *data;
} bounds;

static void put_vertex(kn_step_join *j, kn_text *out, const bounds *b, const kn_step_edge *e, int end,
                       uint64_t number)
{
    uint64_t point = b->base + e->corner[end];
    if (!e->corners) {
        point = j->next++;
        kn_step_put_number(out, point);
        kn_text_put(out, "CARTESIAN_POINT('',(");
        for (int c = 0; c < 3; c++) {
            if (c > 0) kn_text_comma(out);
            kn_text_step_real(out, e->at[end][c]);
        }
        kn_text_put(out, "));");
        kn_text_newline(out);
    }
    kn_step_put_references(out, number, "VERTEX_POINT('',#);", (uint64_t[]){point});
}

// Edges that wait for another face are not written yet: kn_brep_next_edge.
static void put_edges(kn_step_join *j, kn_text *out, const bounds *b, const kn_brep_name *names)
{
    for (int i = 0; i < b->nedges; i++) {
        const kn_step_edge *e = &b->edges[i];
        for (int k = 0; k < 2; k++)
            if (names[i].new_vertex[k]) put_vertex(j, out, b, e, k, names[i].vertex[k]);
        if (names[i].last && !names[i].new_edge) kn_step_join_put_edge(j, out, &names[i]);
        if (!names[i].new_edge) continue;
        kn_text_expand(out, b->data + e->begin, e->curve_begin - e->begin, b->base);
        kn_step_put_number(out, names[i].edge - 1);
        kn_text_expand(out, b->data + e->curve_begin, e->curve_end - e->curve_begin, b->base);
        if (names[i].last) kn_step_join_put_edge(j, out, &names[i]);
    }
}

// Number of the loop: edges in order.
static uint64_t put_loop(kn_step_join *j, kn_text *out, const kn_step_edge *edges, const kn_brep_name *names,
                         uint64_t n)
{
    uint64_t first = j->next;
    for (uint64_t i = 0; i < n; i++)
        kn_step_put_references(out, first + i,
                               edges[i].along != names[i].against ? "ORIENTED_EDGE('',*,*,#,.T.);"
                                                                  : "ORIENTED_EDGE('',*,*,#,.F.);",
                               (uint64_t[]){names[i].edge});
    kn_step_put_number(out, first + n);
    kn_text_put(out, "EDGE_LOOP('',(");
    for (uint64_t i = 0; i < n; i++) {
        if (i > 0) kn_text_comma(out);
        kn_text_reference(out, first + i);
    }
    kn_text_put(out, "));");
    kn_text_newline(out);
    j->next += n + 1;
    return first + n;
}

// The loop runs counterclockwise about r x t. A reversed patch turns both the face and the loop over.
static void put_bound(kn_step_join *j, kn_text *out, const kn_step_item *item, uint64_t loop, bool outer)
{
    kn_step_put_references(out, j->next++,
                           outer ? (item->reversed ? "FACE_OUTER_BOUND('',#,.F.);" : "FACE_OUTER_BOUND('',#,.T.);")
                                 : (item->reversed ? "FACE_BOUND('',#,.F.);" : "FACE_BOUND('',#,.T.);"),
                           (uint64_t[]){loop});
}

// Of bounds that end before the next number.
static void put_face(kn_step_join *j, kn_text *out, const kn_step_item *item, uint64_t base, const uint64_t *bound,
                     size_t n)
{
    char name[KN_FACE_NAME_BYTES];
    kn_naming_write(name, j->naming, &item->id, j->looks[item->look].name, true, item->exact);
    kn_step_put_number(out, j->next++);
    kn_text_put(out, "ADVANCED_FACE(");
    kn_text_step_string(out, name);
    kn_text_put(out, ",(");
    for (size_t i = 0; i < n; i++) {
        if (i > 0) kn_text_comma(out);
        kn_text_reference(out, bound[i]);
    }
    kn_text_put(out, "),");
    kn_text_reference(out, base + item->main);
    kn_text_char(out, ',');
    kn_text_put(out, item->reversed ? ".F.);" : ".T.);");
    kn_text_newline(out);
}

// A number in a list of its look.
static kn_status list(kn_ctx *ctx, kn_step_join *j, int *body, uint64_t number, int look)
{
    kn_status status = *body == KN_BREP_NONE ? kn_brep_open(ctx, j->brep, body) : KN_OK;
    return status == KN_OK ? kn_brep_append(ctx, j->brep, *body, number, look) : status;
}

// Faces in the place of a whole shell of the host.
static void tie(kn_step_join *j, const kn_step_item *item)
{
    const kn_step_host *host = j->host;
    if (!host || !host->shell_of || item->id.surface < 0 || item->id.surface >= host->nsurfaces) return;
    int shell = host->shell_of[item->id.surface];
    if (shell >= 0 && shell < host->nshells && host->shells[shell].nfaces == 0) kn_brep_tie(j->brep, j->held[shell]);
}

// A face whose whole boundary is a point.
static kn_status put_point_face(kn_ctx *ctx, kn_step_join *j, kn_text *out, const kn_step_item *item, uint64_t base)
{
    uint64_t first = j->next, bound = first + 2;
    kn_step_put_references(out, first, "VERTEX_POINT('',#);", (uint64_t[]){base});
    kn_step_put_references(out, first + 1, "VERTEX_LOOP('',#);", (uint64_t[]){first});
    j->next = bound;
    put_bound(j, out, item, first + 1, true);
    put_face(j, out, item, base, &bound, 1);
    return list(ctx, j, &j->looks[item->look].loose, j->next - 1, item->look);
}

static kn_status put_bounded(kn_ctx *ctx, kn_step_join *j, kn_text *out, const bounds *b,
                             const kn_brep_key (*pairs)[2])
{
    const kn_step_item *item = b->item;
    kn_mark mark = kn_scratch_mark(ctx);
    size_t n = (size_t)b->nedges;
    kn_brep_edge *edges = kn_scratch(ctx, n, sizeof *edges);
    kn_brep_name *names = kn_scratch(ctx, n, sizeof *names);
    uint64_t *bound = kn_scratch(ctx, b->nloops, sizeof *bound);
    kn_status status = edges && names && bound ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        edges[i] = b->edges[i].edge;
        edges[i].pcurve = b->edges[i].pcurve > 0 ? b->base + b->edges[i].pcurve : 0;
    }
    int closed = KN_BREP_NONE;
    if (status == KN_OK)
        status = kn_brep_add(ctx, j->brep, item->group, edges, b->nedges, pairs, item->npairs, &j->next, names);
    if (status == KN_OK) {
        put_edges(j, out, b, names);
        const kn_step_edge *e = b->edges;
        for (size_t i = 0; i < b->nloops; i++) {
            bound[i] = put_loop(j, out, e, names + (e - b->edges), b->loops[i].nedges);
            e += b->loops[i].nedges;
        }
        for (size_t i = 0; i < b->nloops; i++) {
            uint64_t loop = bound[i];
            bound[i] = j->next;
            put_bound(j, out, item, loop, b->loops[i].outer);
        }
        put_face(j, out, item, b->base, bound, b->nloops);
        tie(j, item);
        status = kn_brep_end_face(ctx, j->brep, j->next - 1, item->look, &closed);
    }
    if (status == KN_OK && closed != KN_BREP_NONE) status = take_closed(ctx, j, out, item, closed);
    kn_scratch_release(ctx, mark);
    return status;
}

// A face for each outer loop, with its holes.
static kn_status put_trimmed(kn_ctx *ctx, kn_step_join *j, kn_text *out, const kn_step_item *item,
                             const kn_step_lists *lists, uint64_t base, const char *data)
{
    const kn_step_loop *loop = lists->loops + item->loops, *end = loop + item->nloops;
    bounds b = {.item = item, .edges = lists->edges + item->edges, .base = base, .data = data};
    kn_status status = KN_OK;
    while (loop < end && status == KN_OK) {
        b.loops = loop, b.nloops = 0, b.nedges = 0;
        do {
            b.nedges += (int)loop->nedges;
            b.nloops++, loop++;
        } while (loop < end && !loop->outer);
        status = put_bounded(ctx, j, out, &b, (const kn_brep_key(*)[2])(lists->pairs + item->pairs));
        b.edges += b.nedges;
    }
    return status;
}

kn_status kn_step_join_item(kn_ctx *ctx, kn_step_join *j, kn_text *out, const kn_step_item *item,
                            const kn_step_lists *lists, const char *data)
{
    kn_step_look *look = &j->looks[item->look];
    kn_status status = KN_OK;
    uint64_t base = j->next;
    j->next += item->numbers;
    size_t begin = item->text_begin;
    kn_text_expand(out, data + begin, item->text_end - begin, base);
    if (item->kind == KN_STEP_CURVE) {
        status = list(ctx, j, &look->curves, base + item->main, item->look);
        j->ncurves++;
    } else if (item->kind == KN_STEP_TRIMMED) {
        status = put_trimmed(ctx, j, out, item, lists, base, data);
    } else if (item->nedges == 0) {
        status = put_point_face(ctx, j, out, item, base);
    } else {
        const kn_step_loop loop = {.nedges = (uint32_t)item->nedges, .outer = true};
        const bounds b = {item, &loop, item->edge, 1, item->nedges, base, data};
        status = put_bounded(ctx, j, out, &b, item->pair);
    }
    if (status == KN_OK && j->next > INT_MAX)
        return kn_fail(ctx, KN_ELIMIT, "STEP: the patches need entity numbers beyond %d", INT_MAX);
    return status == KN_OK && out->failed ? KN_ENOMEM : status;
}

// ---- journals ----

void kn_step_join_save(const kn_step_join *j, kn_state *state)
{
    kn_state_put(state, &j->next, sizeof j->next);
    kn_state_put(state, &j->nsolids, sizeof j->nsolids);
    kn_state_put(state, &j->nstyled, sizeof j->nstyled);
    kn_state_put(state, &j->ncurves, sizeof j->ncurves);
    for (int i = 0; i < j->nlooks; i++) {
        kn_state_put(state, &j->looks[i].loose, sizeof j->looks[i].loose);
        kn_state_put(state, &j->looks[i].curves, sizeof j->looks[i].curves);
        kn_state_put(state, &j->looks[i].used, sizeof j->looks[i].used);
    }
    kn_closed_shells_save(&j->closed, state);
    kn_brep_save(j->brep, state);
}

kn_status kn_step_join_restore(kn_ctx *ctx, kn_step_join *j, kn_state_reader *r)
{
    bool good = kn_state_take(r, &j->next, sizeof j->next) && kn_state_take(r, &j->nsolids, sizeof j->nsolids) &&
                kn_state_take(r, &j->nstyled, sizeof j->nstyled) && kn_state_take(r, &j->ncurves, sizeof j->ncurves);
    for (int i = 0; i < j->nlooks && good; i++)
        good = kn_state_take(r, &j->looks[i].loose, sizeof j->looks[i].loose) &&
               kn_state_take(r, &j->looks[i].curves, sizeof j->looks[i].curves) &&
               kn_state_take(r, &j->looks[i].used, sizeof j->looks[i].used);
    if (!good) return kn_state_fail(ctx, "STEP");
    kn_status status = kn_closed_shells_restore(ctx, &j->closed, r, "STEP");
    return status == KN_OK ? kn_brep_restore(ctx, j->brep, r) : status;
}
