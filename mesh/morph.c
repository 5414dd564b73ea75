// SPDX-License-Identifier: Apache-2.0
// kn_mesh_morph: one connectivity for two meshes.
//
// Closed ones meet on the sphere (mesh/closed.c). Disks are laid flat onto the unit disk (kn_mesh_flatten), each with
// the border vertex that lies farthest in the first coordinate at (1,0). Triangles of a are quartered there, and each
// vertex is looked up in b: on the border by its angle, inside by its barycentric coordinates in the triangle that
// has it.
#include "kernel/context.h"
#include "mesh/closed.h"
#include "mesh/edges.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROUNDS = 4 };

// A mesh with its place in the disk.
typedef struct flat {
    kn_mesh mesh;
    double *xy;
    bool *border;
} flat;

static void flat_clear(kn_ctx *ctx, flat *f)
{
    kn_mesh_clear(ctx, &f->mesh);
    kn_free(ctx, f->xy);
    kn_free(ctx, f->border);
    *f = (flat){0};
}

static kn_status find_border(kn_ctx *ctx, flat *f)
{
    size_t n = 3 * f->mesh.ntriangles;
    kn_mesh_side *sides = kn_mesh_sides(ctx, &f->mesh);
    f->border = kn_alloc_zero(ctx, f->mesh.nvertices, sizeof *f->border);
    for (size_t i = 0, group; sides && f->border && i < n; i += group)
        if ((group = kn_mesh_side_group(sides, n, i)) == 1) f->border[sides[i].from] = f->border[sides[i].to] = true;
    kn_free(ctx, sides);
    return sides && f->border ? KN_OK : KN_ENOMEM;
}

static kn_status lay_flat(kn_ctx *ctx, flat *out, const kn_mesh *mesh)
{
    kn_status status = kn_mesh_copy(ctx, &out->mesh, mesh);
    kn_free(ctx, out->mesh.normal); // of neither shape
    out->mesh.normal = NULL;
    if (status == KN_OK) status = find_border(ctx, out);
    out->xy = kn_alloc(ctx, mesh->nvertices, 2 * sizeof *out->xy);
    if (status != KN_OK || !out->xy) return KN_ENOMEM;
    uint32_t start = UINT32_MAX;
    for (size_t v = 0; v < mesh->nvertices; v++)
        if (out->border[v] && (start == UINT32_MAX || mesh->position[3 * v] > mesh->position[3 * (size_t)start]))
            start = (uint32_t)v;
    return kn_mesh_flatten(ctx, out->xy, mesh, start);
}

// ---- quartering ----

// The middle of a side; on the border of the disk that of the arc.
static void put_middle(flat *out, size_t to, const kn_mesh_side *s, bool on_border)
{
    const double *p = out->mesh.position + 3 * (size_t)s->from, *q = out->mesh.position + 3 * (size_t)s->to;
    const double *a = out->xy + 2 * (size_t)s->from, *b = out->xy + 2 * (size_t)s->to;
    for (int c = 0; c < 3; c++) out->mesh.position[3 * to + (size_t)c] = 0.5 * (p[c] + q[c]);
    double x = 0.5 * (a[0] + b[0]), y = 0.5 * (a[1] + b[1]), scale = on_border ? 1.0 / hypot(x, y) : 1.0;
    out->xy[2 * to] = x * scale;
    out->xy[2 * to + 1] = y * scale;
    out->border[to] = on_border;
}

static kn_status quarter(kn_ctx *ctx, flat *f)
{
    size_t n = f->mesh.nvertices, nt = f->mesh.ntriangles, most = n + 3 * nt;
    if (most > UINT32_MAX) return kn_fail(ctx, KN_ELIMIT, "mesh: too many vertices");
    kn_mesh_side *sides = kn_mesh_sides(ctx, &f->mesh);
    uint32_t *middle = kn_alloc(ctx, 3 * nt, sizeof *middle);
    flat out = {.mesh = {.nvertices = n, .ntriangles = 4 * nt, .vertex_room = most, .triangle_room = 4 * nt}};
    out.mesh.position = kn_alloc(ctx, most, 3 * sizeof *out.mesh.position);
    out.mesh.triangle = kn_alloc(ctx, 4 * nt, 3 * sizeof *out.mesh.triangle);
    out.xy = kn_alloc(ctx, most, 2 * sizeof *out.xy);
    out.border = kn_alloc_zero(ctx, most, sizeof *out.border);
    kn_status status = sides && middle && out.mesh.position && out.mesh.triangle && out.xy && out.border ? KN_OK
                                                                                                         : KN_ENOMEM;
    if (status == KN_OK) {
        memcpy(out.mesh.position, f->mesh.position, 3 * n * sizeof *out.mesh.position);
        memcpy(out.xy, f->xy, 2 * n * sizeof *out.xy);
        memcpy(out.border, f->border, n * sizeof *out.border);
        for (size_t i = 0, group; i < 3 * nt; i += group) {
            group = kn_mesh_side_group(sides, 3 * nt, i);
            put_middle(&out, out.mesh.nvertices, &sides[i], group == 1);
            for (size_t k = i; k < i + group; k++)
                middle[3 * (size_t)sides[k].triangle + (size_t)sides[k].corner] = (uint32_t)out.mesh.nvertices;
            out.mesh.nvertices++;
        }
        for (size_t i = 0; i < nt; i++) {
            const uint32_t *t = f->mesh.triangle + 3 * i, *m = middle + 3 * i;
            const uint32_t four[12] = {t[0], m[0], m[2], t[1], m[1], m[0], t[2], m[2], m[1], m[0], m[1], m[2]};
            memcpy(out.mesh.triangle + 12 * i, four, sizeof four);
        }
        flat_clear(ctx, f);
        *f = out;
    } else
        flat_clear(ctx, &out);
    kn_free(ctx, sides);
    kn_free(ctx, middle);
    return status;
}

// ---- looking up ----

typedef struct corner {
    double angle;
    uint32_t vertex;
} corner;

// Triangles of b by the squares of a grid over [-1,1]^2 that their boxes touch: list[first[s] .. first[s + 1] - 1].
typedef struct finder {
    const flat *b;
    int side;
    size_t *first;
    uint32_t *list;
    corner *corner; // of the border, by angle
    size_t nring;
} finder;

static int by_angle(const void *a, const void *b)
{
    const corner *x = a, *y = b;
    return x->angle != y->angle ? (x->angle > y->angle) - (x->angle < y->angle)
                                : (x->vertex > y->vertex) - (x->vertex < y->vertex);
}

static int square_of(const finder *f, double x)
{
    int i = (int)((x + 1.0) * 0.5 * f->side);
    return i < 0 ? 0 : i >= f->side ? f->side - 1 : i;
}

static void box_of(const finder *f, size_t triangle, int lo[2], int hi[2])
{
    const uint32_t *t = f->b->mesh.triangle + 3 * triangle;
    for (int c = 0; c < 2; c++) {
        const double *xy = f->b->xy + c;
        double x = xy[2 * (size_t)t[0]], y = xy[2 * (size_t)t[1]], z = xy[2 * (size_t)t[2]];
        lo[c] = square_of(f, fmin(x, fmin(y, z)) - 1e-9);
        hi[c] = square_of(f, fmax(x, fmax(y, z)) + 1e-9);
    }
}

static kn_status finder_init(kn_ctx *ctx, finder *f, const flat *b)
{
    size_t nt = b->mesh.ntriangles;
    *f = (finder){.b = b, .side = (int)fmin(ceil(sqrt((double)nt)), 2048.0)};
    size_t squares = (size_t)f->side * (size_t)f->side;
    f->first = kn_alloc_zero(ctx, squares + 1, sizeof *f->first);
    f->corner = kn_alloc(ctx, b->mesh.nvertices, sizeof *f->corner);
    if (!f->first || !f->corner) return KN_ENOMEM;
    int lo[2], hi[2];
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < nt; i++) {
            box_of(f, i, lo, hi);
            for (int x = lo[0]; x <= hi[0]; x++)
                for (int y = lo[1]; y <= hi[1]; y++) {
                    size_t s = (size_t)x * (size_t)f->side + (size_t)y;
                    if (pass == 0)
                        f->first[s + 1]++;
                    else
                        f->list[f->first[s]++] = (uint32_t)i;
                }
        }
        if (pass == 1) break;
        for (size_t s = 0; s < squares; s++) f->first[s + 1] += f->first[s];
        f->list = kn_alloc(ctx, f->first[squares] + 1, sizeof *f->list);
        if (!f->list) return KN_ENOMEM;
    }
    memmove(f->first + 1, f->first, squares * sizeof *f->first); // the second pass moved each to its end
    f->first[0] = 0;
    for (size_t v = 0; v < b->mesh.nvertices; v++) {
        if (!b->border[v]) continue;
        double angle = atan2(b->xy[2 * v + 1], b->xy[2 * v]);
        f->corner[f->nring++] = (corner){angle, (uint32_t)v};
    }
    qsort(f->corner, f->nring, sizeof *f->corner, by_angle);
    return KN_OK;
}

static void finder_clear(kn_ctx *ctx, finder *f)
{
    kn_free(ctx, f->first);
    kn_free(ctx, f->list);
    kn_free(ctx, f->corner);
}

static void on_border(double out[3], const finder *f, const double xy[2])
{
    const double turn = 6.28318530717958648;
    double angle = atan2(xy[1], xy[0]);
    size_t lo = 0, hi = f->nring; // the first that lies beyond
    while (lo < hi) {
        size_t middle = (lo + hi) / 2;
        if (f->corner[middle].angle > angle)
            hi = middle;
        else
            lo = middle + 1;
    }
    size_t after = lo % f->nring, before = (lo + f->nring - 1) % f->nring;
    double start = f->corner[before].angle, length = f->corner[after].angle - start, way = angle - start;
    if (length <= 0.0) length += turn;
    if (way < 0.0) way += turn;
    double part = fmin(way / length, 1.0);
    const double *p = f->b->mesh.position + 3 * (size_t)f->corner[before].vertex,
                 *q = f->b->mesh.position + 3 * (size_t)f->corner[after].vertex;
    for (int c = 0; c < 3; c++) out[c] = (1.0 - part) * p[c] + part * q[c];
}

// The triangle whose least barycentric coordinate at xy is the largest; below 0: outside of all.
static double inside(double out[3], const finder *f, const double xy[2])
{
    size_t s = (size_t)square_of(f, xy[0]) * (size_t)f->side + (size_t)square_of(f, xy[1]);
    double best = -INFINITY;
    for (size_t k = f->first[s]; k < f->first[s + 1]; k++) {
        const uint32_t *t = f->b->mesh.triangle + 3 * (size_t)f->list[k];
        const double *a = f->b->xy + 2 * (size_t)t[0], *b = f->b->xy + 2 * (size_t)t[1],
                     *c = f->b->xy + 2 * (size_t)t[2];
        double area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]), w[3];
        w[1] = ((xy[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (xy[1] - a[1])) / area;
        w[2] = ((b[0] - a[0]) * (xy[1] - a[1]) - (xy[0] - a[0]) * (b[1] - a[1])) / area;
        w[0] = 1.0 - w[1] - w[2];
        double least = fmin(w[0], fmin(w[1], w[2]));
        if (!(least > best)) continue;
        best = least;
        for (int d = 0; d < 3; d++) {
            out[d] = 0.0;
            for (int i = 0; i < 3; i++) out[d] += w[i] * f->b->mesh.position[3 * (size_t)t[i] + (size_t)d];
        }
    }
    return best;
}

static kn_status look_up(kn_ctx *ctx, double *target, const flat *a, const flat *b)
{
    const double slack = 1e-9; // of barycentric coordinates: rounding between two triangles
    finder f;
    kn_status status = finder_init(ctx, &f, b);
    for (size_t v = 0; status == KN_OK && v < a->mesh.nvertices; v++) {
        const double *xy = a->xy + 2 * v;
        // between b's border and the circle lies the nearest border
        if (a->border[v] || inside(target + 3 * v, &f, xy) < -slack) on_border(target + 3 * v, &f, xy);
    }
    finder_clear(ctx, &f);
    return status;
}

// ---- the whole ----

static bool same_triangles(const kn_mesh *a, const kn_mesh *b)
{
    return a->ntriangles > 0 && a->nvertices == b->nvertices && a->ntriangles == b->ntriangles &&
           memcmp(a->triangle, b->triangle, 3 * a->ntriangles * sizeof *a->triangle) == 0;
}

static kn_status copy_both(kn_ctx *ctx, kn_mesh *mesh, double **target, const kn_mesh *a, const kn_mesh *b)
{
    double *t = kn_alloc(ctx, b->nvertices, 3 * sizeof *t);
    kn_status status = t ? kn_mesh_copy(ctx, mesh, a) : KN_ENOMEM;
    if (status != KN_OK) {
        kn_free(ctx, t);
        return status;
    }
    memcpy(t, b->position, 3 * b->nvertices * sizeof *t);
    kn_free(ctx, mesh->normal);
    mesh->normal = NULL;
    *target = t;
    return KN_OK;
}

// A mesh of one piece each of whose edges has its two triangles or lies on the border, all of them on the same side.
static bool is_surface(const kn_mesh_topology *t)
{
    return t->components == 1 && t->irregular == 0;
}

static bool is_disk(const kn_mesh_topology *t)
{
    return is_surface(t) && t->loops == 1 && t->euler == 1;
}

static bool is_sphere(const kn_mesh_topology *t)
{
    return is_surface(t) && t->loops == 0 && t->euler == 2;
}

static kn_status refuse(kn_ctx *ctx, const kn_mesh_topology *t, const char *which)
{
    const char *why = t->loops > 0 ? "is open, and the other one is closed" : "is closed, and the other one is open";
    if (t->irregular > 0)
        why = "is no surface that can be oriented";
    else if (t->components != 1)
        why = "is not in one piece";
    else if (t->loops > 1)
        why = "has holes";
    else if (t->euler != 2 - t->loops)
        why = "has handles";
    return kn_fail(
        ctx, KN_EDOMAIN,
        "mesh: the %s has %d components, %d border loops, genus %ld and %zu irregular edges: it %s; a common "
        "parameterization is found for two disks (1, 1, 0, 0) and for two closed surfaces (1, 0, 0, 0)",
        which, t->components, t->loops, is_surface(t) ? (2 - t->loops - t->euler) / 2 : 0L, t->irregular, why);
}

static kn_status morph_disks(kn_ctx *ctx, kn_mesh *out, double **target, const kn_mesh *a, const kn_mesh *b)
{
    flat from = {0}, to = {0};
    kn_status status = lay_flat(ctx, &from, a);
    if (status == KN_OK) status = lay_flat(ctx, &to, b);
    for (int k = 0; k < MOST_ROUNDS && status == KN_OK && from.mesh.ntriangles < b->ntriangles; k++)
        status = quarter(ctx, &from);
    double *place = status == KN_OK ? kn_alloc(ctx, from.mesh.nvertices, 3 * sizeof *place) : NULL;
    if (status == KN_OK) status = place ? look_up(ctx, place, &from, &to) : KN_ENOMEM;
    if (status == KN_OK) {
        kn_mesh_clear(ctx, out);
        *out = from.mesh;
        from.mesh = (kn_mesh){0};
        *target = place;
    } else
        kn_free(ctx, place);
    flat_clear(ctx, &from);
    flat_clear(ctx, &to);
    return status;
}

kn_status kn_mesh_morph(kn_ctx *ctx, kn_mesh *out, double **target, const kn_mesh *a, const kn_mesh *b)
{
    if (same_triangles(a, b)) return copy_both(ctx, out, target, a, b);
    kn_mesh_topology t[2];
    kn_status status = kn_mesh_survey(ctx, &t[0], a);
    if (status == KN_OK) status = kn_mesh_survey(ctx, &t[1], b);
    if (status != KN_OK) return status;
    if (is_sphere(&t[0]) && is_sphere(&t[1])) return kn_mesh_morph_closed(ctx, out, target, a, b);
    if (is_disk(&t[0]) && is_disk(&t[1])) return morph_disks(ctx, out, target, a, b);
    bool first = is_disk(&t[0]) || is_sphere(&t[0]), second = is_disk(&t[1]) || is_sphere(&t[1]);
    return first && !second ? refuse(ctx, &t[1], "second") : refuse(ctx, &t[0], "first");
}
