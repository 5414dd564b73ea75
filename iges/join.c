// SPDX-License-Identifier: Apache-2.0
// Faces of an IGES file with the edges and vertices that they share; bodies that are closed become solids at once.
//
// Each vertex is a vertex list (502) of its own, each edge an edge list (504) behind its curve: so their numbers are
// all that has to be kept of them.
#include "iges/write.h"

#include "io/color.h"
#include "kernel/context.h"

#include <stdio.h>
#include <string.h>

enum { LONG_TEXT = 1 << 20, COLOURED = 1, PLAIN = -1 };

// Subordinate to another entity, and what for (columns of the status number).
static const char independent[] = "00000000", dependent[] = "00010000", in_plane[] = "00010500",
                  definition[] = "00000200", property[] = "00010300";

typedef struct entity {
    int type, form, look; // look PLAIN: no colour
    const char *status;
    const char *label; // "": none
    int number;        // of the label
    size_t begin;      // of its lines in the parameters
} entity;

static uint64_t pointer(uint64_t e)
{
    return 2 * e + 1;
}

// Right-justified in a field.
static void put_field(char *field, int width, uint64_t n)
{
    for (int i = width - 1; i >= 0; i--) {
        field[i] = (char)('0' + n % 10);
        n /= 10;
        if (n == 0) break;
    }
}

// ---- directory ----

static void directory_line(kn_text *text, char line[KN_IGES_LINE_BYTES], uint64_t number)
{
    line[72] = 'D', line[KN_IGES_LINE_BYTES - 1] = '\n';
    put_field(line + 73, 7, number);
    kn_text_bytes(text, line, KN_IGES_LINE_BYTES);
}

// Type, first parameter line, status; then weight, colour, count of lines, form, label and its number.
static void put_directory(kn_iges_join *j, const entity *e, uint64_t lines)
{
    char one[KN_IGES_LINE_BYTES], two[KN_IGES_LINE_BYTES];
    memset(one, ' ', sizeof one), memset(two, ' ', sizeof two);
    uint64_t colour = e->look >= 0 ? j->looks[e->look].colour : 0;
    put_field(one, 8, (uint64_t)e->type), put_field(two, 8, (uint64_t)e->type);
    put_field(one + 8, 8, j->lines + 1);
    for (int f = 2; f < 8; f++) put_field(one + 8 * f, 8, 0);
    memcpy(one + 64, e->status, 8);
    put_field(two + 8, 8, 0);
    put_field(two + 16, 8, colour > 0 ? pointer(colour - 1) : 0);
    for (int i = 22; colour > 0 && two[i + 1] != '-'; i--) // a pointer, of seven digits at most
        if (two[i] == ' ') two[i] = '-';
    put_field(two + 24, 8, lines);
    put_field(two + 32, 8, (uint64_t)e->form);
    if (e->label[0]) {
        size_t n = strlen(e->label);
        if (n > 8) n = 8;
        for (size_t i = 0; i < n; i++) {
            char c = e->label[i];
            two[64 - n + i] = (char)(c >= 32 && c < 127 ? c : '_');
        }
        put_field(two + 64, 8, (uint64_t)e->number % 100000000);
    }
    directory_line(&j->directory, one, pointer(j->next));
    directory_line(&j->directory, two, pointer(j->next) + 1);
}

// ---- parameters ----

// Fills the numbers of whole lines from `begin` on; answers how many there are, `before` of this entity were filled.
static uint64_t number_lines(kn_iges_join *j, size_t begin, uint64_t before)
{
    char entity_field[7];
    uint64_t n = 0;
    kn_text *text = &j->parameters;
    if (text->failed) return 0;
    memset(entity_field, ' ', sizeof entity_field);
    put_field(entity_field, 7, pointer(j->next));
    for (size_t at = begin; at + KN_IGES_LINE_BYTES <= text->bytes; at += KN_IGES_LINE_BYTES, n++) {
        memcpy(text->data + at + 65, entity_field, sizeof entity_field);
        put_field(text->data + at + 73, 7, j->lines + before + n + 1);
    }
    return n;
}

static entity start(kn_iges_join *j, int type)
{
    entity e = {.type = type, .look = PLAIN, .status = dependent, .label = "", .begin = j->parameters.bytes};
    j->parameters.line = j->parameters.bytes;
    return e;
}

// Of what has the colour of its part, and for a label the name of that, or of its surface.
static entity start_item(kn_iges_join *j, int type, const kn_iges_item *item)
{
    entity e = start(j, type);
    e.look = item->look, e.number = item->id.patch;
    e.label = j->naming->plain && item->kind != KN_IGES_CURVE ? kn_naming_surface(j->naming, &item->id)
                                                              : j->looks[item->look].name;
    return e;
}

// Its lines are there; before: that were flushed already.
static kn_status finish(kn_ctx *ctx, kn_iges_join *j, const entity *e, uint64_t before)
{
    uint64_t lines = before + number_lines(j, e->begin, before);
    put_directory(j, e, lines);
    j->lines += lines;
    j->next++;
    if (j->lines > KN_IGES_MOST || 2 * j->next > KN_IGES_MOST)
        return kn_fail(ctx, KN_ELIMIT, "IGES: the patches need more than %d lines, which seven digits cannot count",
                       KN_IGES_MOST);
    return j->parameters.failed || j->directory.failed ? KN_ENOMEM : KN_OK;
}

// An entity of integers.
static kn_status put_list(kn_ctx *ctx, kn_iges_join *j, entity e, const uint64_t *n, int count)
{
    kn_iges_put_integer(&j->parameters, (uint64_t)e.type);
    for (int i = 0; i < count; i++) kn_iges_put_integer(&j->parameters, n[i]);
    kn_iges_end(&j->parameters);
    return finish(ctx, j, &e, 0);
}

// Behind the parameters of something with a name: no associativities, one property, the next entity.
static void put_property(kn_iges_join *j)
{
    kn_iges_put_integer(&j->parameters, 0);
    kn_iges_put_integer(&j->parameters, 1);
    kn_iges_put_integer(&j->parameters, pointer(j->next + 1));
}

// The end of what has a name, and the name; "": none.
static kn_status finish_named(kn_ctx *ctx, kn_iges_join *j, const entity *e, const char *name)
{
    if (name[0]) put_property(j);
    kn_iges_end(&j->parameters);
    kn_status status = finish(ctx, j, e, 0);
    if (status != KN_OK || !name[0]) return status;
    entity of = start(j, 406);
    of.form = 15, of.status = property;
    kn_iges_put_integer(&j->parameters, 406);
    kn_iges_put_integer(&j->parameters, 1);
    kn_iges_put_string(&j->parameters, name);
    kn_iges_end(&j->parameters);
    return finish(ctx, j, &of, 0);
}

static kn_status finish_item(kn_ctx *ctx, kn_iges_join *j, const entity *e, const kn_iges_item *item)
{
    char name[KN_FACE_NAME_BYTES];
    kn_naming_write(name, j->naming, &item->id, j->looks[item->look].name, item->kind != KN_IGES_CURVE, item->exact);
    return finish_named(ctx, j, e, name);
}

// 314: red, green and blue in percent, and a name.
static kn_status need_colour(kn_ctx *ctx, kn_iges_join *j, int look)
{
    kn_iges_look *l = &j->looks[look];
    if (l->colour > 0) return KN_OK;
    entity e = start(j, 314);
    e.status = definition;
    kn_iges_put_integer(&j->parameters, 314);
    for (int c = 0; c < 3; c++) kn_iges_put_real(&j->parameters, 100.0 * kn_color_srgb(l->material.base_color[c]));
    kn_iges_put_string(&j->parameters, l->name);
    kn_iges_end(&j->parameters);
    l->colour = j->next + 1;
    return finish(ctx, j, &e, 0);
}

// Lines that a thread wrote.
static kn_status put_written(kn_ctx *ctx, kn_iges_join *j, int type, const char *status, const char *data,
                             uint32_t lines)
{
    entity e = start(j, type);
    e.status = status;
    kn_text_bytes(&j->parameters, data, (size_t)lines * KN_IGES_LINE_BYTES);
    return finish(ctx, j, &e, 0);
}

// The same, by itself: with colour and name.
static kn_status put_alone(kn_ctx *ctx, kn_iges_join *j, int type, const kn_iges_item *item, const char *data)
{
    entity e = start_item(j, type, item);
    e.status = independent;
    kn_text_bytes(&j->parameters, data, (size_t)item->surface_lines * KN_IGES_LINE_BYTES);
    kn_iges_reopen(&j->parameters);
    return finish_item(ctx, j, &e, item);
}

// ---- faces ----

static kn_status put_vertex(kn_ctx *ctx, kn_iges_join *j, const double *p)
{
    entity e = start(j, 502);
    e.form = 1;
    kn_iges_put_integer(&j->parameters, 502);
    kn_iges_put_integer(&j->parameters, 1);
    for (int c = 0; c < 3; c++) kn_iges_put_real(&j->parameters, p[c]);
    kn_iges_end(&j->parameters);
    return finish(ctx, j, &e, 0);
}

static kn_status put_edge(kn_ctx *ctx, kn_iges_join *j, const kn_brep_name *name)
{
    entity e = start(j, 504);
    e.form = 1;
    return put_list(
        ctx, j, e, (uint64_t[]){1, pointer(name->edge - 1), pointer(name->vertex[0]), 1, pointer(name->vertex[1]), 1},
        6);
}

// One face of an item: its loops, and all that they have.
typedef struct bounds {
    const kn_iges_item *item;
    const kn_iges_loop *loops;
    const kn_iges_edge *edges;
    size_t nloops;
    int nedges;
    const char *data; // lines of the edges' curves
} bounds;

// Entities of new vertices, then of curves and edges, in the order of their numbers.
static kn_status put_new(kn_ctx *ctx, kn_iges_join *j, const bounds *b, const kn_brep_name *names)
{
    kn_status status = KN_OK;
    for (int i = 0; i < b->nedges; i++)
        for (int k = 0; k < 2 && status == KN_OK; k++)
            if (names[i].new_vertex[k]) status = put_vertex(ctx, j, b->edges[i].vertex[k]);
    const char *curve = b->data;
    for (int i = 0; i < b->nedges && status == KN_OK; i++) {
        const kn_iges_edge *e = &b->edges[i];
        curve += (size_t)e->plane_lines * KN_IGES_LINE_BYTES;
        if (names[i].new_edge) status = put_written(ctx, j, 126, dependent, curve, e->lines);
        if (names[i].new_edge && status == KN_OK) status = put_edge(ctx, j, &names[i]);
        curve += (size_t)e->lines * KN_IGES_LINE_BYTES;
    }
    return status;
}

// Curves in the plane of those edges that have one; their entities: plane[i], 0: none.
static kn_status put_planes(kn_ctx *ctx, kn_iges_join *j, const bounds *b, uint64_t *plane)
{
    kn_status status = KN_OK;
    const char *data = b->data;
    for (int i = 0; i < b->nedges && status == KN_OK; i++) {
        const kn_iges_edge *e = &b->edges[i];
        plane[i] = e->plane_lines > 0 ? pointer(j->next) : 0;
        if (e->plane_lines > 0) status = put_written(ctx, j, 126, in_plane, data, e->plane_lines);
        data += (size_t)(e->plane_lines + e->lines) * KN_IGES_LINE_BYTES;
    }
    return status;
}

// The loop runs counterclockwise about r x t; that a patch is reversed is told where the shell lists its face.
static kn_status put_loop(kn_ctx *ctx, kn_iges_join *j, const kn_iges_edge *edges, const kn_brep_name *names,
                          const uint64_t *plane, uint32_t n)
{
    entity e = start(j, 508);
    e.form = 1;
    kn_iges_put_integer(&j->parameters, 508);
    kn_iges_put_integer(&j->parameters, n);
    for (uint32_t i = 0; i < n; i++) { // an edge, its list and place there, along it, curves in the plane
        kn_iges_put_integer(&j->parameters, 0);
        kn_iges_put_integer(&j->parameters, pointer(names[i].edge));
        kn_iges_put_integer(&j->parameters, 1);
        kn_iges_put_integer(&j->parameters, edges[i].along);
        kn_iges_put_integer(&j->parameters, plane[i] > 0);
        if (plane[i] == 0) continue;
        kn_iges_put_integer(&j->parameters, 0); // no parameter line
        kn_iges_put_integer(&j->parameters, plane[i]);
    }
    kn_iges_end(&j->parameters);
    return finish(ctx, j, &e, 0);
}

// Its loops are the entities from `first` on; the first of them is the outer one.
static kn_status put_face(kn_ctx *ctx, kn_iges_join *j, const kn_iges_item *item, uint64_t surface, uint64_t first,
                          size_t nloops)
{
    entity e = start_item(j, 510, item);
    e.form = 1;
    kn_iges_put_integer(&j->parameters, 510);
    kn_iges_put_integer(&j->parameters, pointer(surface));
    kn_iges_put_integer(&j->parameters, nloops);
    kn_iges_put_integer(&j->parameters, 1); // there is an outer one
    for (size_t i = 0; i < nloops; i++) kn_iges_put_integer(&j->parameters, pointer(first + i));
    return finish_item(ctx, j, &e, item);
}

// ---- shells ----

// 514: faces, and whether their surfaces look out. Long ones are flushed while they are put.
static kn_status put_shell(kn_ctx *ctx, kn_iges_join *j, int body, bool closed, kn_status (*put)(void *user),
                           void *user)
{
    entity e = start(j, 514);
    kn_brep_walk walk = kn_brep_faces(j->brep, body);
    uint64_t before = 0;
    kn_status status = KN_OK;
    e.form = closed ? 1 : 2, e.status = closed ? dependent : independent;
    kn_iges_put_integer(&j->parameters, 514);
    kn_iges_put_integer(&j->parameters, walk.left);
    while (status == KN_OK && kn_brep_step(j->brep, &walk)) {
        kn_iges_put_integer(&j->parameters, pointer(walk.number));
        kn_iges_put_integer(&j->parameters, walk.look % 2 == 0);
        if (!put || j->parameters.bytes < LONG_TEXT || j->parameters.failed) continue;
        kn_text *text = &j->parameters;
        char rest[KN_IGES_LINE_BYTES];
        size_t bytes = text->bytes - text->line; // of the line that is not full yet
        before += number_lines(j, e.begin, before);
        memcpy(rest, text->data + text->line, bytes);
        text->bytes = text->line;
        status = put(user);
        e.begin = text->bytes;
        kn_text_bytes(text, rest, bytes);
    }
    kn_iges_end(&j->parameters);
    return status == KN_OK ? finish(ctx, j, &e, before) : status;
}

// Of closed shells, the outer one first; drops them. Voids look out of what is solid, as the outer shell does.
static kn_status put_solid(kn_ctx *ctx, kn_iges_join *j, const kn_patch_id *id, int name,
                           const kn_closed_shell *shells, size_t n, kn_status (*put)(void *user), void *user)
{
    int look = kn_brep_look(j->brep, shells[0].brep);
    uint64_t *shell = kn_alloc(ctx, n, sizeof *shell);
    kn_status status = shell ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        status = put_shell(ctx, j, shells[i].brep, true, put, user);
        shell[i] = j->next - 1;
    }
    if (status == KN_OK) {
        entity e = start(j, 186);
        e.status = independent, e.look = look >= 0 ? look / 2 : PLAIN;
        e.label = j->looks[name].name, e.number = id->patch;
        kn_iges_put_integer(&j->parameters, 186);
        kn_iges_put_integer(&j->parameters, pointer(shell[0]));
        kn_iges_put_integer(&j->parameters, 1); // the shell looks out
        kn_iges_put_integer(&j->parameters, n - 1);
        for (size_t i = 1; i < n; i++) {
            kn_iges_put_integer(&j->parameters, pointer(shell[i]));
            kn_iges_put_integer(&j->parameters, 1);
        }
        char text[KN_FACE_NAME_BYTES];
        kn_naming_write(text, j->naming, id, j->looks[name].name, false, true);
        status = finish_named(ctx, j, &e, text);
    }
    for (size_t i = 0; i < n; i++) kn_brep_drop(j->brep, shells[i].brep);
    kn_free(ctx, shell);
    return status;
}

// ---- trimmed faces ----

// Of n curves from `first` on: the one, or a composite curve (102), which is the next entity.
static kn_status put_composite(kn_ctx *ctx, kn_iges_join *j, uint64_t *out, uint64_t first, uint32_t n, bool plane)
{
    *out = pointer(first);
    if (n == 1) return KN_OK;
    *out = pointer(j->next);
    entity e = start(j, 102);
    e.status = plane ? in_plane : dependent;
    kn_iges_put_integer(&j->parameters, 102);
    kn_iges_put_integer(&j->parameters, n);
    for (uint32_t k = 0; k < n; k++) kn_iges_put_integer(&j->parameters, pointer(first + k));
    kn_iges_end(&j->parameters);
    return finish(ctx, j, &e, 0);
}

// 142 of one loop: how it arose is not said; the curve in the plane is the exact one.
static kn_status put_boundary(kn_ctx *ctx, kn_iges_join *j, uint64_t surface, const kn_iges_loop *loop,
                              const uint32_t *lines, const char **data)
{
    uint64_t first = j->next, plane = 0, space = 0;
    kn_status status = KN_OK;
    for (uint32_t k = 0; k < 2 * loop->curves && status == KN_OK; k++) {
        status = put_written(ctx, j, 126, k < loop->curves ? in_plane : dependent, *data, lines[k]);
        *data += (size_t)lines[k] * KN_IGES_LINE_BYTES;
    }
    if (status == KN_OK) status = put_composite(ctx, j, &plane, first, loop->curves, true);
    if (status == KN_OK) status = put_composite(ctx, j, &space, first + loop->curves, loop->curves, false);
    if (status != KN_OK) return status;
    return put_list(ctx, j, start(j, 142), (uint64_t[]){0, pointer(surface), plane, space, 1}, 5);
}

// 144 for each outer loop, with the holes in it: the boundary of the square is not the outer one, where it begins.
static kn_status put_trimmed(kn_ctx *ctx, kn_iges_join *j, const kn_iges_written *w, const kn_iges_item *item)
{
    const char *data = w->text.data + item->begin;
    const kn_iges_loop *loops = w->loops + item->loops;
    const uint32_t *lines = w->lines + item->lines;
    uint64_t surface = j->next;
    uint64_t *boundary = kn_alloc(ctx, item->nloops, sizeof *boundary);
    kn_status status = boundary ? put_written(ctx, j, 128, dependent, data, item->surface_lines) : KN_ENOMEM;
    data += (size_t)item->surface_lines * KN_IGES_LINE_BYTES;
    for (size_t i = 0, end = 0; i < item->nloops && status == KN_OK; i = end) {
        for (end = i; status == KN_OK && end < item->nloops && (end == i || !loops[end].outer); end++) {
            status = put_boundary(ctx, j, surface, &loops[end], lines, &data);
            lines += 2 * (size_t)loops[end].curves;
            boundary[end] = j->next - 1;
        }
        if (status != KN_OK) break;
        entity e = start_item(j, 144, item);
        e.status = independent;
        kn_iges_put_integer(&j->parameters, 144);
        kn_iges_put_integer(&j->parameters, pointer(surface));
        kn_iges_put_integer(&j->parameters, 1);
        kn_iges_put_integer(&j->parameters, end - i - 1);
        for (size_t k = i; k < end; k++) kn_iges_put_integer(&j->parameters, pointer(boundary[k]));
        status = finish_item(ctx, j, &e, item);
    }
    kn_free(ctx, boundary);
    return status;
}

// ---- items ----

// A closed shell: a solid, or part of one of which others may come.
static kn_status take_closed(kn_ctx *ctx, kn_iges_join *j, const kn_iges_item *item, int body)
{
    const kn_closed_shell closed = {
        .brep = body, .body = item->body, .shell = item->shell, .look = item->look, .id = item->id};
    if (item->body < 0) return put_solid(ctx, j, &item->id, item->look, &closed, 1, NULL, NULL);
    return kn_closed_shells_add(ctx, &j->closed, closed);
}

static kn_status put_bounded(kn_ctx *ctx, kn_iges_join *j, const bounds *b, uint64_t surface,
                             const kn_brep_key (*pairs)[2])
{
    const kn_iges_item *item = b->item;
    size_t n = (size_t)b->nedges;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_brep_edge *edges = kn_scratch(ctx, n, sizeof *edges);
    kn_brep_name *names = kn_scratch(ctx, n, sizeof *names);
    uint64_t *plane = kn_scratch(ctx, n, sizeof *plane);
    int closed = KN_BREP_NONE;
    kn_status status = edges && names && plane ? put_planes(ctx, j, b, plane) : KN_ENOMEM;
    for (size_t i = 0; i < n && status == KN_OK; i++) edges[i] = b->edges[i].edge;
    uint64_t end = j->next;
    if (status == KN_OK)
        status = kn_brep_add(ctx, j->brep, item->group, edges, b->nedges, pairs, item->npairs, &end, names);
    if (status == KN_OK) status = put_new(ctx, j, b, names);
    if (status == KN_OK && j->next != end)
        status = kn_fail(ctx, KN_EUNDECIDED, "IGES: number %llu belongs to nothing", (unsigned long long)j->next);
    uint64_t first = j->next;
    size_t at = 0;
    for (size_t i = 0; i < b->nloops && status == KN_OK; i++) {
        status = put_loop(ctx, j, b->edges + at, names + at, plane + at, b->loops[i].curves);
        at += b->loops[i].curves;
    }
    uint64_t face = j->next;
    if (status == KN_OK) status = put_face(ctx, j, item, surface, first, b->nloops);
    if (status == KN_OK) status = kn_brep_end_face(ctx, j->brep, face, 2 * item->look + item->reversed, &closed);
    if (status == KN_OK && closed != KN_BREP_NONE) status = take_closed(ctx, j, item, closed);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status put_plain(kn_ctx *ctx, kn_iges_join *j, const kn_iges_item *item, const char *data)
{
    uint64_t surface = j->next;
    const kn_iges_loop loop = {.curves = (uint32_t)item->nedges, .outer = true};
    kn_status status = put_written(ctx, j, 128, dependent, data, item->surface_lines);
    data += (size_t)item->surface_lines * KN_IGES_LINE_BYTES;
    const bounds b = {item, &loop, item->edge, 1, item->nedges, data};
    return status == KN_OK ? put_bounded(ctx, j, &b, surface, item->pair) : status;
}

// A face for each outer loop, with its holes.
static kn_status put_joined(kn_ctx *ctx, kn_iges_join *j, const kn_iges_written *w, const kn_iges_item *item)
{
    const char *data = w->text.data + item->begin;
    const kn_iges_loop *loop = w->loops + item->loops, *end = loop + item->nloops;
    uint64_t surface = j->next;
    kn_status status = put_written(ctx, j, 128, dependent, data, item->surface_lines);
    bounds b = {.item = item, .edges = w->edges + item->edges};
    b.data = data + (size_t)item->surface_lines * KN_IGES_LINE_BYTES;
    while (loop < end && status == KN_OK) {
        b.loops = loop, b.nloops = 0, b.nedges = 0;
        do {
            b.nedges += (int)loop->curves;
            b.nloops++, loop++;
        } while (loop < end && !loop->outer);
        status = put_bounded(ctx, j, &b, surface, (const kn_brep_key(*)[2])(w->pairs + item->pairs));
        for (int i = 0; i < b.nedges; i++)
            b.data += (size_t)(b.edges[i].plane_lines + b.edges[i].lines) * KN_IGES_LINE_BYTES;
        b.edges += b.nedges;
    }
    return status;
}

kn_status kn_iges_join_item(kn_ctx *ctx, kn_iges_join *j, const kn_iges_written *w, const kn_iges_item *item)
{
    const char *data = w->text.data + item->begin;
    kn_status status = need_colour(ctx, j, item->look);
    if (status != KN_OK) return status;
    if (item->kind == KN_IGES_CURVE) return put_alone(ctx, j, 126, item, data);
    if (item->kind == KN_IGES_TRIMMED)
        return j->surfaces ? put_trimmed(ctx, j, w, item) : put_joined(ctx, j, w, item);
    return item->nedges > 0 ? put_plain(ctx, j, item, data) : put_alone(ctx, j, 128, item, data);
}

kn_status kn_iges_join_end(kn_ctx *ctx, kn_iges_join *j, kn_status (*put)(void *user), void *user)
{
    kn_status status = KN_OK;
    kn_closed_shells_sort(&j->closed);
    for (size_t at = 0, n = 0; status == KN_OK && kn_closed_shells_next(&j->closed, &at, &n);) {
        const kn_closed_shell *first = &j->closed.list[at];
        status = put_solid(ctx, j, &first->id, first->look, first, n, put, user);
    }
    for (int body = KN_BREP_NONE; status == KN_OK && kn_brep_next_body(j->brep, &body);) {
        status = put_shell(ctx, j, body, false, put, user);
        if (status == KN_OK && j->parameters.bytes + j->directory.bytes > LONG_TEXT) status = put(user);
    }
    return status == KN_OK ? put(user) : status;
}

// ---- life ----

kn_status kn_iges_join_begin(kn_ctx *ctx, kn_iges_join *j, const kn_tile *tile)
{
    j->looks = kn_alloc_zero(ctx, (size_t)tile->nparts, sizeof *j->looks);
    if (!j->looks) return KN_ENOMEM;
    j->nlooks = tile->nparts;
    for (int i = 0; i < tile->nparts; i++) {
        memcpy(j->looks[i].name, tile->parts[i].name, sizeof j->looks[i].name);
        j->looks[i].name[KN_NAME_BYTES - 1] = '\0';
        j->looks[i].material = tile->parts[i].material;
    }
    j->directory.ctx = j->parameters.ctx = ctx;
    return kn_brep_create(ctx, &j->brep);
}

void kn_iges_join_clear(kn_ctx *ctx, kn_iges_join *j)
{
    kn_brep_destroy(ctx, j->brep);
    kn_closed_shells_clear(ctx, &j->closed);
    j->directory.ctx = j->parameters.ctx = ctx;
    kn_text_clear(&j->directory);
    kn_text_clear(&j->parameters);
    kn_free(ctx, j->looks);
    *j = (kn_iges_join){0};
}

// ---- journals ----

void kn_iges_join_save(const kn_iges_join *j, kn_state *state)
{
    kn_state_put(state, &j->next, sizeof j->next);
    kn_state_put(state, &j->lines, sizeof j->lines);
    for (int i = 0; i < j->nlooks; i++) kn_state_put(state, &j->looks[i].colour, sizeof j->looks[i].colour);
    kn_closed_shells_save(&j->closed, state);
    kn_brep_save(j->brep, state);
}

kn_status kn_iges_join_restore(kn_ctx *ctx, kn_iges_join *j, kn_state_reader *r)
{
    bool good = kn_state_take(r, &j->next, sizeof j->next) && kn_state_take(r, &j->lines, sizeof j->lines);
    for (int i = 0; i < j->nlooks && good; i++)
        good = kn_state_take(r, &j->looks[i].colour, sizeof j->looks[i].colour);
    if (!good) return kn_state_fail(ctx, "IGES");
    kn_status status = kn_closed_shells_restore(ctx, &j->closed, r, "IGES");
    return status == KN_OK ? kn_brep_restore(ctx, j->brep, r) : status;
}
