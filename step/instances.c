// SPDX-License-Identifier: Apache-2.0
// Cells that are one another, moved, as instances of one part.
//
// The faces of a cell are kept until the cell ends. Where their control points are those of an earlier cell, turned and
// shifted, as all of them show, a placement of that cell's part is written; else they become a part of their own.
#include "step/instances.h"

#include "io/patch_net.h"
#include "kernel/context.h"
#include "kernel/hash.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// Cells that others are compared with: so many, with control points of so many bytes in all.
enum { PARTS = 1024, POINT_BYTES = 64 << 20 };

// Of the size of a cell: how far a control point may be from where the placement has it; of a weight: how far it may
// differ. Both together move no point of a face by more than 1.1e-9 of the size: weights that differ by a part e move a
// point by 4 e times the size.
static const double same_place = 1e-9, same_weight = 2e-11;

typedef struct frame {
    double e[3][3]; // orthonormal, right-handed
} frame;

typedef struct part {
    kn_brep_key key; // of the forms of its faces
    double *point;   // n times x, y, z, weight
    size_t n;
    size_t at[3]; // points far from each other
    double size, largest;
    frame frame;
    bool flat; // no three points make a frame
    uint64_t definition, representation;
} part;

struct kn_step_cells {
    kn_step_join *join;
    part *parts;
    int nparts;
    size_t bytes; // of their points
    uint64_t definitions, placements;
    // the cell that has not ended
    kn_patch_id id;
    kn_brep_key key;
    kn_step_item *items;
    size_t nitems, room;
    kn_text text;
    kn_step_points points;
};

// R x + t
typedef struct motion {
    double r[3][3], t[3];
} motion;

static double *reserve(kn_ctx *ctx, kn_step_points *p, size_t n)
{
    if (p->room - p->n < n) {
        size_t room = 2 * (p->n + n);
        double *more = kn_resize(ctx, p->x, room, sizeof *more);
        if (!more) return NULL;
        p->x = more, p->room = room;
    }
    return p->x + p->n;
}

// ---- faces ----

static kn_brep_key form_of(const kn_patch_net *net, const kn_step_item *item)
{
    kn_brep_key key = {0, 0};
    const double about[] = {item->look,     item->reversed,    item->exact, item->id.part,       item->id.patch,
                            item->id.piece, item->id.instance, net->n,      net->axis[0].degree, net->axis[1].degree};
    for (size_t i = 0; i < sizeof about / sizeof *about; i++) key = kn_brep_mix(key, about[i]);
    for (int v = 0; v < 2; v++) {
        const kn_patch_axis *axis = &net->axis[v];
        key = kn_brep_mix(key, axis->nbreaks);
        for (int k = 0; k < axis->nbreaks; k++) key = kn_brep_mix(kn_brep_mix(key, axis->times[k]), axis->breaks[k]);
    }
    return key;
}

kn_status kn_step_note_points(kn_ctx *ctx, kn_step_points *points, kn_step_item *item, const kn_patch *patch,
                              double mm)
{
    if (item->kind != KN_STEP_FACE)
        return kn_fail(ctx, KN_EDOMAIN,
                       "STEP: instances: surface %d, cell %d,%d, patch %d is %s: parts are closed bodies of whole "
                       "patches",
                       patch->id.surface, patch->id.cell[0], patch->id.cell[1], patch->id.patch,
                       item->kind == KN_STEP_CURVE ? "a curve" : "trimmed");
    kn_patch_net net;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_patch_net_load(ctx, &net, patch, mm, "STEP");
    if (status == KN_OK) {
        size_t n = 4 * (size_t)net.n;
        double *to = reserve(ctx, points, n);
        // weights that are equal but for rounding, or 1 where they are equal bit for bit, are all near 1
        for (size_t i = 0; to && i < n; i++) to[i] = i % 4 == 3 ? net.point[i] / net.point[3] : net.point[i];
        item->points = points->n, item->npoints = n;
        item->form = form_of(&net, item);
        points->n += to ? n : 0;
        status = to ? KN_OK : KN_ENOMEM;
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- congruence ----

static double distance(const double *a, const double *b)
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++) sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sqrt(sum);
}

// v less its parts along the first n vectors of the frame, as its vector n; its length.
static double next_vector(frame *f, int n, const double v[3])
{
    double x[3] = {v[0], v[1], v[2]}, length = 0.0;
    for (int k = 0; k < n; k++) {
        double dot = x[0] * f->e[k][0] + x[1] * f->e[k][1] + x[2] * f->e[k][2];
        for (int c = 0; c < 3; c++) x[c] -= dot * f->e[k][c];
    }
    for (int c = 0; c < 3; c++) length += x[c] * x[c];
    length = sqrt(length);
    for (int c = 0; c < 3; c++) f->e[n][c] = length > 0.0 ? x[c] / length : 0.0;
    return length;
}

// The third vector is the product of the other two: a mirrored cell has another frame than its image.
static double make_frame(frame *f, const double *p, const double *q, const double *r)
{
    double a[3], b[3];
    for (int c = 0; c < 3; c++) a[c] = q[c] - p[c], b[c] = r[c] - p[c];
    double first = next_vector(f, 0, a), second = next_vector(f, 1, b);
    for (int c = 0; c < 3; c++) {
        int i = (c + 1) % 3, k = (c + 2) % 3;
        f->e[2][c] = f->e[0][i] * f->e[1][k] - f->e[0][k] * f->e[1][i];
    }
    return fmin(first, second);
}

// Three points: the first one, that which is farthest from it, and that which is farthest from both.
static void measure(part *p)
{
    double far = -1.0;
    for (size_t i = 0; i < p->n; i++)
        for (int c = 0; c < 3; c++) p->largest = fmax(p->largest, fabs(p->point[4 * i + (size_t)c]));
    for (int pass = 1; pass < 3; pass++, far = -1.0)
        for (size_t i = 0; i < p->n; i++) {
            double d = distance(p->point + 4 * i, p->point);
            if (pass == 2) {
                frame f;
                const double *o = p->point, *x = p->point + 4 * i;
                d = make_frame(&f, o, p->point + 4 * p->at[1], x);
            }
            if (d > far) far = d, p->at[pass] = i;
        }
    p->size = distance(p->point, p->point + 4 * p->at[1]);
    double lever = make_frame(&p->frame, p->point, p->point + 4 * p->at[1], p->point + 4 * p->at[2]);
    p->flat = !(lever > 1e-3 * p->size);
}

static bool agrees(const part *p, const double *point, const motion *m, double tolerance)
{
    for (size_t i = 0; i < p->n; i++) {
        const double *x = p->point + 4 * i, *y = point + 4 * i;
        double moved[3];
        for (int c = 0; c < 3; c++) moved[c] = m->r[c][0] * x[0] + m->r[c][1] * x[1] + m->r[c][2] * x[2] + m->t[c];
        if (!(distance(moved, y) <= tolerance) || !(fabs(x[3] - y[3]) <= same_weight * x[3])) return false;
    }
    return true;
}

static void shift(motion *m, const double *x, const double *y)
{
    for (int c = 0; c < 3; c++) m->t[c] = y[c] - (m->r[c][0] * x[0] + m->r[c][1] * x[1] + m->r[c][2] * x[2]);
}

// *m moves the part to where the points are, all of them.
static bool find_motion(motion *m, const part *p, const double *point)
{
    double largest = p->largest;
    const double *x[3], *y[3];
    for (int k = 0; k < 3; k++) x[k] = p->point + 4 * p->at[k], y[k] = point + 4 * p->at[k];
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++) largest = fmax(largest, fabs(y[k][c]));
    double tolerance = same_place * p->size + 16.0 * DBL_EPSILON * largest; // that of the check's own rounding
    for (int k = 0; k < 3; k++)
        if (fabs(distance(x[k], x[(k + 1) % 3]) - distance(y[k], y[(k + 1) % 3])) > 2.0 * tolerance) return false;
    *m = (motion){.r = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    shift(m, x[0], y[0]);
    if (agrees(p, point, m, tolerance)) return true;
    frame f;
    if (p->flat || !(make_frame(&f, y[0], y[1], y[2]) > 0.0)) return false;
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++) {
            m->r[i][c] = 0.0;
            for (int k = 0; k < 3; k++) m->r[i][c] += f.e[k][i] * p->frame.e[k][c];
        }
    shift(m, x[0], y[0]);
    return agrees(p, point, m, tolerance);
}

// ---- parts ----

static void name_cell(char name[KN_FACE_NAME_BYTES], const kn_step_cells *cells)
{
    kn_naming_write(name, cells->join->naming, &cells->id, "", false, true);
    size_t n = strlen(name);
    if (n > 0 && name[n - 1] == ' ') name[n - 1] = '\0';
}

static void put_triple(kn_text *out, uint64_t number, const char *entity, const double x[3])
{
    kn_step_put_number(out, number);
    kn_text_put(out, entity);
    for (int c = 0; c < 3; c++) {
        kn_text_put(out, c == 0 ? "('',(" : ",");
        kn_text_step_real(out, x[c]);
    }
    kn_text_put(out, "));");
    kn_text_newline(out);
}

static kn_status put_placement(kn_ctx *ctx, kn_step_cells *cells, kn_text *out, const part *p, const motion *m)
{
    kn_step_join *j = cells->join;
    char name[KN_FACE_NAME_BYTES];
    uint64_t n = j->next, o = j->origin;
    const double axis[3] = {m->r[0][2], m->r[1][2], m->r[2][2]}, first[3] = {m->r[0][0], m->r[1][0], m->r[2][0]};
    name_cell(name, cells);
    put_triple(out, n, "CARTESIAN_POINT", m->t);
    put_triple(out, n + 1, "DIRECTION", axis);
    put_triple(out, n + 2, "DIRECTION", first);
    kn_step_put_references(out, n + 3, "AXIS2_PLACEMENT_3D('',#,#,#);", (uint64_t[]){n, n + 1, n + 2});
    kn_step_put_references(out, n + 4, "ITEM_DEFINED_TRANSFORMATION('','',#,#);",
                           (uint64_t[]){o + KN_STEP_PLACEMENT, n + 3});
    kn_step_put_number(out, n + 5);
    kn_text_put(out, "NEXT_ASSEMBLY_USAGE_OCCURRENCE('");
    kn_text_integer(out, ++cells->placements);
    kn_text_put(out, "',");
    kn_text_step_string(out, name);
    kn_text_put(out, ",'',");
    kn_text_reference(out, o + KN_STEP_DEFINITION);
    kn_text_char(out, ',');
    kn_text_reference(out, p->definition);
    kn_text_put(out, ",$);\n");
    kn_step_put_references(out, n + 6, "PRODUCT_DEFINITION_SHAPE('Placement','',#);", (uint64_t[]){n + 5});
    kn_step_put_references(out, n + 7,
                           "(REPRESENTATION_RELATIONSHIP('','',#,#)REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#)"
                           "SHAPE_REPRESENTATION_RELATIONSHIP());",
                           (uint64_t[]){p->representation, o + KN_STEP_REPRESENTATION, n + 4});
    kn_step_put_references(out, n + 8, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#,#);", (uint64_t[]){n + 7, n + 6});
    j->next += 9;
    return kn_brep_append(ctx, j->brep, j->placed, n + 3, 0);
}

// Product, definition and shape of the bodies in j->solids.
static kn_status put_part(kn_step_cells *cells, kn_text *out, part *p)
{
    kn_step_join *j = cells->join;
    char name[KN_FACE_NAME_BYTES];
    uint64_t n = j->next, o = j->origin;
    name_cell(name, cells);
    kn_step_put_number(out, n);
    kn_text_put(out, "PRODUCT('part ");
    kn_text_integer(out, ++cells->definitions);
    kn_text_put(out, "',");
    kn_text_step_string(out, name);
    kn_text_put(out, ",'',(");
    kn_text_reference(out, o + KN_STEP_PRODUCT_CONTEXT);
    kn_text_put(out, "));\n");
    kn_step_put_references(out, n + 1, "PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#));", (uint64_t[]){n});
    kn_step_put_references(out, n + 2, "PRODUCT_DEFINITION_FORMATION('','',#);", (uint64_t[]){n});
    kn_step_put_references(out, n + 3, "PRODUCT_DEFINITION('design','',#,#);",
                           (uint64_t[]){n + 2, o + KN_STEP_DEFINITION_CONTEXT});
    kn_step_put_references(out, n + 4, "PRODUCT_DEFINITION_SHAPE('','',#);", (uint64_t[]){n + 3});
    kn_step_put_references(out, n + 5, "SHAPE_DEFINITION_REPRESENTATION(#,#);", (uint64_t[]){n + 4, n + 6});
    kn_step_put_number(out, n + 6);
    kn_text_put(out, "ADVANCED_BREP_SHAPE_REPRESENTATION('',(");
    kn_text_reference(out, o + KN_STEP_PLACEMENT);
    kn_text_char(out, ',');
    kn_status status = kn_step_join_put_list(j->brep, j->solids, out, NULL, NULL);
    kn_text_put(out, "),");
    kn_text_reference(out, o + KN_STEP_GEOMETRY_CONTEXT);
    kn_text_put(out, ");");
    kn_text_newline(out);
    p->definition = n + 3, p->representation = n + 6;
    j->next += 7;
    return status;
}

// All faces of the cell are in bodies that they close.
static kn_status check_closed(kn_ctx *ctx, const kn_step_cells *cells)
{
    const kn_step_join *j = cells->join;
    for (int body = KN_BREP_NONE; kn_brep_next_body(j->brep, &body);) {
        bool odd;
        if (kn_step_join_is_list(j, body) || kn_brep_held(j->brep, body)) continue;
        return kn_fail(
            ctx, KN_EDOMAIN,
            "STEP: instances: surface %d, cell %d,%d: its faces do not close a body (%u edges have one face): "
            "only tiles whose bodies end within their cell can be parts",
            cells->id.surface, cells->id.cell[0], cells->id.cell[1], kn_brep_waiting(j->brep, body, &odd));
    }
    return KN_OK;
}

static kn_status write_bodies(kn_ctx *ctx, kn_step_cells *cells, kn_text *out)
{
    kn_step_join *j = cells->join;
    kn_brep_drop(j->brep, j->solids);
    kn_status status = kn_brep_open(ctx, j->brep, &j->solids);
    for (size_t i = 0; i < cells->nitems && status == KN_OK; i++)
        status = kn_step_join_item(ctx, j, out, &cells->items[i], NULL, cells->text.data);
    return status == KN_OK ? check_closed(ctx, cells) : status;
}

// The points go to the part, as long as there is room for it.
static void keep(kn_step_cells *cells, const part *p)
{
    size_t bytes = 4 * p->n * sizeof *p->point;
    if (cells->nparts == PARTS || cells->bytes + bytes > POINT_BYTES) return;
    cells->parts[cells->nparts++] = *p;
    cells->bytes += bytes;
    cells->points.x = NULL, cells->points.room = 0;
}

static kn_status end_cell(kn_ctx *ctx, kn_step_cells *cells, kn_text *out)
{
    motion m = {.r = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    kn_status status = KN_OK;
    const part *found = NULL;
    if (cells->nitems == 0) return KN_OK;
    if (cells->text.failed) return KN_ENOMEM;
    for (int i = 0; i < cells->nparts && !found; i++) {
        const part *p = &cells->parts[i];
        if (kn_brep_same(p->key, cells->key) && 4 * p->n == cells->points.n && find_motion(&m, p, cells->points.x))
            found = p;
    }
    if (found) {
        status = put_placement(ctx, cells, out, found, &m);
    } else {
        part p = {.key = cells->key, .point = cells->points.x, .n = cells->points.n / 4};
        m = (motion){.r = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
        status = write_bodies(ctx, cells, out);
        if (status == KN_OK) status = put_part(cells, out, &p);
        if (status == KN_OK) status = put_placement(ctx, cells, out, &p, &m);
        if (status == KN_OK) measure(&p), keep(cells, &p);
    }
    cells->nitems = cells->points.n = 0;
    cells->text.bytes = cells->text.line = 0;
    return status;
}

kn_status kn_step_cells_add(kn_ctx *ctx, kn_step_cells *cells, kn_text *out, const kn_step_item *item,
                            const char *data, size_t end, const double *points)
{
    const kn_patch_id *a = &item->id, *b = &cells->id;
    bool same = a->surface == b->surface && a->cell[0] == b->cell[0] && a->cell[1] == b->cell[1] &&
                a->layer == b->layer;
    kn_status status = same ? KN_OK : end_cell(ctx, cells, out);
    if (status != KN_OK) return status;
    if (cells->nitems == 0) cells->id = *a, cells->key = (kn_brep_key){0, 0};
    if (cells->nitems == cells->room) {
        size_t room = cells->room > 0 ? 2 * cells->room : 64;
        kn_step_item *more = kn_resize(ctx, cells->items, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        cells->items = more, cells->room = room;
    }
    double *to = reserve(ctx, &cells->points, item->npoints);
    if (!to) return KN_ENOMEM;
    memcpy(to, points + item->points, item->npoints * sizeof *to);
    cells->points.n += item->npoints;
    kn_step_item *x = &cells->items[cells->nitems++];
    size_t from = item->text_begin, at = cells->text.bytes;
    *x = *item;
    x->text_begin = at, x->text_end = item->text_end - from + at;
    for (int e = 0; e < x->nedges; e++) {
        x->edge[e].begin = item->edge[e].begin - from + at;
        x->edge[e].curve_begin = item->edge[e].curve_begin - from + at;
        x->edge[e].curve_end = item->edge[e].curve_end - from + at;
    }
    cells->text.ctx = ctx;
    kn_text_bytes(&cells->text, data + from, end - from);
    cells->key.a = kn_hash_add(cells->key.a, item->form.a);
    cells->key.b = kn_hash_add(cells->key.b, item->form.b);
    return cells->text.failed ? KN_ENOMEM : KN_OK;
}

kn_status kn_step_cells_end(kn_ctx *ctx, kn_step_cells *cells, kn_text *out)
{
    kn_status status = end_cell(ctx, cells, out);
    kn_step_join *j = cells->join;
    kn_brep_drop(j->brep, j->solids);
    j->solids = j->placed;
    return status;
}

// ---- life ----

kn_status kn_step_cells_create(kn_ctx *ctx, kn_step_cells **out, kn_step_join *join)
{
    kn_step_cells *cells = kn_alloc_zero(ctx, 1, sizeof *cells);
    if (!cells) return KN_ENOMEM;
    cells->join = join;
    cells->parts = kn_alloc(ctx, PARTS, sizeof *cells->parts);
    kn_status status = cells->parts ? kn_brep_open(ctx, join->brep, &join->placed) : KN_ENOMEM;
    if (status == KN_OK)
        *out = cells;
    else
        kn_step_cells_destroy(ctx, cells);
    return status;
}

void kn_step_cells_destroy(kn_ctx *ctx, kn_step_cells *cells)
{
    if (!cells) return;
    for (int i = 0; i < cells->nparts; i++) kn_free(ctx, cells->parts[i].point);
    cells->text.ctx = ctx;
    kn_text_clear(&cells->text);
    kn_free(ctx, cells->parts), kn_free(ctx, cells->items), kn_free(ctx, cells->points.x);
    kn_free(ctx, cells);
}
