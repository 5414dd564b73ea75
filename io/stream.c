// SPDX-License-Identifier: Apache-2.0
// Models through the sinks of jobs, as patches.
#include <knurl/io.h>

#include "io/bend.h"
#include "io/split.h"
#include "kernel/context.h"

#include <math.h>
#include <stdio.h>

// What is made of a model: splines of its own, and patches of them.
typedef struct stream {
    kn_spline *splines;
    kn_patch *patches;
    kn_mesh mesh;
    size_t nsplines, room, npatches;
    double lo[3], hi[3];
    int segments; // of a span
} stream;

static void grow(stream *s, const double *p)
{
    for (int c = 0; c < 3; c++) {
        if (p[c] < s->lo[c]) s->lo[c] = p[c];
        if (p[c] > s->hi[c]) s->hi[c] = p[c];
    }
}

static kn_status keep(kn_ctx *ctx, stream *s, kn_spline *spline)
{
    if (s->nsplines == s->room) {
        size_t room = 2 * s->room + 8;
        kn_spline *larger = kn_resize(ctx, s->splines, room, sizeof *larger);
        if (!larger) return KN_ENOMEM;
        s->splines = larger, s->room = room;
    }
    s->splines[s->nsplines++] = *spline;
    *spline = (kn_spline){0};
    return KN_OK;
}

static kn_status keep_piece(kn_ctx *ctx, void *user, kn_spline *piece)
{
    return keep(ctx, user, piece);
}

static kn_status normalise(kn_ctx *ctx, kn_spline *s)
{
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < s->nvars; d++) {
        double lo, hi;
        kn_spline_domain(s, d, &lo, &hi);
        if (lo != 0.0 || hi != 1.0) status = kn_spline_reparameterize(ctx, s, s, d, 0.0, 1.0);
    }
    return status;
}

static bool is_above(const kn_spline *s, int degree)
{
    for (int d = 0; d < s->nvars; d++)
        if (s->degree[d] > degree) return true;
    return false;
}

static kn_status keep_pieces(kn_ctx *ctx, stream *s, const kn_spline *spline)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, spline);
    for (size_t i = 0; i < n; i++) {
        kn_spline piece = {0};
        if (status == KN_OK) status = kn_spline_of_bezier(ctx, &piece, &pieces[i]);
        if (status == KN_OK) status = keep(ctx, s, &piece);
        kn_spline_clear(ctx, &piece);
        kn_bezier_clear(ctx, &pieces[i]);
    }
    kn_free(ctx, pieces);
    return status;
}

// What lies in the plane is taken to lie in z = 0; what lies elsewhere, or has more variables, is left out.
static kn_status take(kn_ctx *ctx, stream *s, const kn_spline *from, const kn_stream_options *o)
{
    static const double lift[6] = {1, 0, 0, 1, 0, 0};
    int dim = kn_spline_dim(from);
    if (from->nvars < 1 || from->nvars > 3 || dim < 2 || dim > 3) return KN_OK;
    kn_spline own = {0};
    double lo[3], hi[3];
    kn_status status = dim == 2 ? kn_spline_affine(ctx, &own, from, 3, lift, NULL) : kn_spline_copy(ctx, &own, from);
    if (status == KN_OK && o->unit_domains) status = normalise(ctx, &own);
    if (status == KN_OK) status = kn_spline_box(ctx, lo, hi, &own);
    if (status == KN_OK) grow(s, lo), grow(s, hi);
    if (status == KN_OK && o->max_degree > 0 && is_above(&own, o->max_degree))
        status = keep_pieces(ctx, s, &own);
    else if (status == KN_OK)
        status = o->split ? kn_split_kinks(ctx, s, keep_piece, &own) : keep(ctx, s, &own);
    kn_spline_clear(ctx, &own);
    return status;
}

// ---- how finely a model is tessellated ----

// One number for all, so that neighbours meet.
static kn_status choose_segments(kn_ctx *ctx, stream *s, double tol)
{
    double most = 0.0;
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < s->nsplines; i++) {
        double one = 0.0;
        status = kn_spline_bend(ctx, &one, &s->splines[i]);
        most = fmax(most, one);
    }
    s->segments = kn_bend_segments(most, tol);
    return status;
}

// ---- meshes ----

// Sums of the normals of the triangles around a vertex, weighted by their areas.
static kn_status copy_mesh(kn_ctx *ctx, kn_mesh *out, const kn_mesh *mesh)
{
    kn_status status = kn_mesh_copy(ctx, out, mesh);
    if (status != KN_OK || out->normal) return status;
    out->normal = kn_alloc_zero(ctx, out->vertex_room ? out->vertex_room : 1, 3 * sizeof(double));
    if (!out->normal) return KN_ENOMEM;
    for (size_t t = 0; t < out->ntriangles; t++) {
        const uint32_t *v = out->triangle + 3 * t;
        const double *a = out->position + 3 * (size_t)v[0], *b = out->position + 3 * (size_t)v[1],
                     *c = out->position + 3 * (size_t)v[2];
        for (int k = 0; k < 3; k++) {
            int y = (k + 1) % 3, z = (k + 2) % 3;
            double n = (b[y] - a[y]) * (c[z] - a[z]) - (b[z] - a[z]) * (c[y] - a[y]);
            for (int i = 0; i < 3; i++) out->normal[3 * (size_t)v[i] + (size_t)k] += n;
        }
    }
    for (size_t i = 0; i < out->nvertices; i++) {
        double *n = out->normal + 3 * i, length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3; k++) n[k] = length > 0.0 ? n[k] / length : k == 2;
    }
    return KN_OK;
}

// What is one piece over the unit box is said to be one.
static kn_status set_patch(kn_ctx *ctx, kn_patch *p, const kn_spline *s, int segments)
{
    bool piece = true;
    kn_status status = KN_OK;
    p->bezier = (kn_bezier){.nvars = s->nvars, .ncomp = s->ncomp, .rational = s->rational, .coef = s->coef};
    for (int d = 0; status == KN_OK && d < s->nvars; d++) {
        double lo, hi;
        kn_spline_domain(s, d, &lo, &hi);
        piece = piece && s->count[d] == s->degree[d] + 1 && lo == 0.0 && hi == 1.0;
        p->bezier.degree[d] = s->degree[d];
        status = kn_bend_total(ctx, &p->segments[d], s, d, segments);
    }
    if (piece) return status;
    p->bezier = (kn_bezier){0};
    p->spline = s;
    return status;
}

static kn_status make_patches(kn_ctx *ctx, stream *s)
{
    s->npatches = s->nsplines + (s->mesh.ntriangles > 0);
    s->patches = kn_alloc_zero(ctx, s->npatches ? s->npatches : 1, sizeof *s->patches);
    if (!s->patches) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < s->npatches; i++) {
        kn_patch *p = &s->patches[i];
        p->exact = true;
        p->id.surface = (int)i;
        if (i == s->nsplines) {
            p->mesh = &s->mesh;
            continue;
        }
        status = set_patch(ctx, p, &s->splines[i], s->segments);
    }
    return status;
}

static void clear(kn_ctx *ctx, stream *s)
{
    for (size_t i = 0; i < s->nsplines; i++) kn_spline_clear(ctx, &s->splines[i]);
    kn_free(ctx, s->splines);
    kn_free(ctx, s->patches);
    kn_mesh_clear(ctx, &s->mesh);
}

static kn_status run(kn_ctx *ctx, stream *s, const char *name, kn_sink *sinks, int nsinks)
{
    kn_tile tile = {0};
    double size = 0.0;
    for (int c = 0; c < 3; c++) size = fmax(size, s->hi[c] - s->lo[c]);
    kn_status status = kn_tile_init(ctx, &tile, "model", 1);
    if (status == KN_OK) {
        (void)snprintf(tile.parts[0].name, sizeof tile.parts[0].name, "%s", name);
        tile.parts[0].material = (kn_material){{0.60, 0.60, 0.60}, 0.0, 0.5};
        status = kn_stream_patches(ctx, &tile, s->patches, s->npatches, size, sinks, nsinks);
    }
    kn_tile_clear(ctx, &tile);
    return status;
}

kn_status kn_stream_model(kn_ctx *ctx, const kn_model *model, const char *name, const kn_stream_options *options,
                          kn_sink *sinks, int nsinks)
{
    kn_stream_options o = options ? *options : (kn_stream_options){0};
    if (!(o.mesh_tol >= 0.0 && isfinite(o.mesh_tol)))
        return kn_fail(ctx, KN_EDOMAIN, "stream: tolerance %g", o.mesh_tol);
    stream s = {.lo = {INFINITY, INFINITY, INFINITY}, .hi = {-INFINITY, -INFINITY, -INFINITY}};
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < model->nsplines; i++) status = take(ctx, &s, &model->splines[i], &o);
    for (size_t i = 0; i < model->mesh.nvertices; i++) grow(&s, model->mesh.position + 3 * i);
    if (status == KN_OK && model->mesh.ntriangles > 0) status = copy_mesh(ctx, &s.mesh, &model->mesh);
    if (status == KN_OK && s.nsplines == 0 && s.mesh.ntriangles == 0)
        status = kn_fail(ctx, KN_EDOMAIN, "stream: %s: nothing that lies in space", name);
    double diagonal = sqrt(pow(s.hi[0] - s.lo[0], 2) + pow(s.hi[1] - s.lo[1], 2) + pow(s.hi[2] - s.lo[2], 2));
    double tol = o.mesh_tol > 0.0 ? o.mesh_tol : 1e-3 * diagonal;
    if (status == KN_OK) status = choose_segments(ctx, &s, tol);
    if (status == KN_OK) status = make_patches(ctx, &s);
    if (status == KN_OK) status = run(ctx, &s, name, sinks, nsinks);
    clear(ctx, &s);
    return status;
}
