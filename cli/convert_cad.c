// SPDX-License-Identifier: Apache-2.0
// The faces of a CAD file as patches for sinks: trimmed surfaces, a part for each body and colour.
#include "cli/cli.h"
#include "io/bend.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

enum { PIECE_SEGMENTS = 12 }; // of a piece of a trimmed face, in each direction, at least: its border has no other

typedef struct faces {
    const kn_cad *cad;
    kn_tile tile;
    int *look;          // of each face
    kn_patch *patches;  // npatches, room
    kn_spline *splines; // behind them, one each
    kn_trim *trims;
    kn_patch_bounds *bounds;
    size_t npatches, room;
    int (*segments)[2]; // of a span of each face, that are within the tolerance
} faces;

// ---- parts ----

static bool same_color(const kn_material *m, const kn_cad_face *f)
{
    static const double plain[3] = {0.6, 0.6, 0.6};
    const double *c = f->colored ? f->color : plain;
    return m->base_color[0] == c[0] && m->base_color[1] == c[1] && m->base_color[2] == c[2];
}

// look[i]: of face i; the first face of each look in `first`. The number of looks.
static int find_looks(const kn_cad *cad, int *look, int *first)
{
    int n = 0;
    for (int i = 0; i < cad->nfaces; i++) {
        const kn_cad_face *f = &cad->faces[i];
        look[i] = 0;
        while (look[i] < n) {
            const kn_cad_face *g = &cad->faces[first[look[i]]];
            kn_material m = {.base_color = {0.6, 0.6, 0.6}};
            if (g->colored) memcpy(m.base_color, g->color, sizeof m.base_color);
            if (g->body == f->body && same_color(&m, f)) break;
            look[i]++;
        }
        if (look[i] == n) first[n++] = i;
    }
    return n;
}

static kn_status make_parts(kn_ctx *ctx, faces *f, const char *name)
{
    const kn_cad *cad = f->cad;
    int *first = kn_alloc(ctx, (size_t)cad->nfaces + 1, sizeof *first);
    f->look = kn_alloc(ctx, (size_t)cad->nfaces + 1, sizeof *f->look);
    kn_status status = first && f->look ? KN_OK : KN_ENOMEM;
    int n = status == KN_OK ? find_looks(cad, f->look, first) : 0;
    if (status == KN_OK) status = kn_tile_init(ctx, &f->tile, "model", n > 0 ? n : 1);
    for (int i = 0; status == KN_OK && i < n; i++) {
        const kn_cad_face *face = &cad->faces[first[i]];
        kn_tile_part *part = &f->tile.parts[i];
        const char *body = cad->bodies[face->body].name;
        snprintf(part->name, sizeof part->name, "%s", *body ? body : name);
        part->material = (kn_material){{0.6, 0.6, 0.6}, 0.0, 0.5};
        if (face->colored) memcpy(part->material.base_color, face->color, sizeof face->color);
    }
    kn_free(ctx, first);
    return status;
}

// ---- patches ----

// Takes the spline over, and a trim, empty where all of it is there.
static kn_status add(kn_ctx *ctx, faces *f, int face, kn_spline *s, kn_trim *trim)
{
    kn_status status = KN_OK;
    size_t at = f->npatches++;
    f->splines[at] = *s, f->trims[at] = *trim;
    *s = (kn_spline){0}, *trim = (kn_trim){0};
    kn_patch *p = &f->patches[at];
    *p = (kn_patch){.id = {.surface = face, .part = f->look[face]}, .look = f->look[face], .exact = true};
    p->body = f->cad->faces[face].body;
    const kn_spline *own = &f->splines[at];
    if (own->count[0] == own->degree[0] + 1 && own->count[1] == own->degree[1] + 1)
        p->bezier = (kn_bezier){.nvars = 2,
                                .ncomp = own->ncomp,
                                .rational = own->rational,
                                .degree = {own->degree[0], own->degree[1]},
                                .coef = own->coef};
    else
        p->spline = own;
    if (f->trims[at].nloops > 0) p->trim = &f->trims[at];
    if (f->bounds[at].edges) p->bounds = &f->bounds[at];
    for (int d = 0; status == KN_OK && d < 2; d++) {
        int n = f->segments[face][d];
        if (p->trim && n < PIECE_SEGMENTS) n = PIECE_SEGMENTS;
        status = kn_bend_total(ctx, &p->segments[d], own, d, n);
    }
    return status;
}

// A face as its pieces, each with what of the trim is in it: triangles of trimmed surfaces are made piece by piece.
static kn_status add_pieces(kn_ctx *ctx, faces *f, int face, const kn_spline *s, const kn_trim *trim)
{
    kn_bezier *pieces = NULL;
    size_t n = 0, spans = (size_t)kn_spline_spans(s, 1), at[2] = {0, 0};
    double *breaks[2] = {NULL, NULL};
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, s);
    for (int d = 0; status == KN_OK && d < 2; d++) {
        breaks[d] = kn_alloc(ctx, (size_t)s->count[d] + 2, sizeof(double));
        if (!breaks[d]) status = KN_ENOMEM;
        for (int i = s->degree[d]; status == KN_OK && i <= s->count[d]; i++)
            if (i == s->degree[d] || s->knots[d][i] != s->knots[d][i - 1]) breaks[d][at[d]++] = s->knots[d][i];
    }
    for (size_t i = 0; i < n; i++) {
        kn_spline piece = {0};
        kn_trim part = {0};
        bool any = true;
        if (status == KN_OK) {
            const double lo[2] = {breaks[0][i / spans], breaks[1][i % spans]};
            const double hi[2] = {breaks[0][i / spans + 1], breaks[1][i % spans + 1]};
            status = kn_trim_restrict(ctx, &part, &any, trim, lo, hi);
        }
        if (status == KN_OK && any) status = kn_spline_of_bezier(ctx, &piece, &pieces[i]);
        if (status == KN_OK && any) status = add(ctx, f, face, &piece, &part);
        kn_spline_clear(ctx, &piece), kn_trim_clear(ctx, &part);
        kn_bezier_clear(ctx, &pieces[i]);
    }
    kn_free(ctx, pieces), kn_free(ctx, breaks[0]), kn_free(ctx, breaks[1]);
    return status;
}

static kn_status add_face(kn_ctx *ctx, faces *f, int face, const cli_cad_options *o)
{
    const kn_cad_face *from = &f->cad->faces[face];
    bool trimmed = !from->whole || (o->edges && from->use);
    kn_spline s = {0};
    kn_trim trim = {0};
    kn_status status = kn_spline_copy(ctx, &s, &from->surface);
    for (int d = 0; status == KN_OK && d < 2; d++) {
        double lo, hi;
        kn_spline_domain(&s, d, &lo, &hi);
        if (lo != 0.0 || hi != 1.0) status = kn_spline_reparameterize(ctx, &s, &s, d, 0.0, 1.0);
    }
    if (status == KN_OK && trimmed) status = kn_trim_copy(ctx, &trim, &from->trim);
    if (status == KN_OK && trimmed && o->edges)
        status = cli_cad_bounds(ctx, &f->bounds[f->npatches], f->cad, face, o->max_degree);
    if (status == KN_OK && trimmed && !o->trims)
        status = add_pieces(ctx, f, face, &s, &trim);
    else if (status == KN_OK)
        status = add(ctx, f, face, &s, &trim);
    kn_spline_clear(ctx, &s), kn_trim_clear(ctx, &trim);
    return status;
}

static kn_status make_patches(kn_ctx *ctx, faces *f, const cli_cad_options *o)
{
    kn_status status = KN_OK;
    for (int i = 0; i < f->cad->nfaces; i++) {
        const kn_spline *s = &f->cad->faces[i].surface;
        f->room += (size_t)kn_spline_spans(s, 0) * (size_t)kn_spline_spans(s, 1);
    }
    f->patches = kn_alloc_zero(ctx, f->room + 1, sizeof *f->patches);
    f->splines = kn_alloc_zero(ctx, f->room + 1, sizeof *f->splines);
    f->trims = kn_alloc_zero(ctx, f->room + 1, sizeof *f->trims);
    f->bounds = kn_alloc_zero(ctx, f->room + 1, sizeof *f->bounds);
    if (!f->patches || !f->splines || !f->trims || !f->bounds) return KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < f->cad->nfaces; i++) status = add_face(ctx, f, i, o);
    return status;
}

// The largest side of the box of all faces, and how finely they are tessellated; tol 0: a thousandth of its diagonal.
static kn_status measure(kn_ctx *ctx, faces *f, double *size, double tol)
{
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, square = 0.0;
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < f->cad->nfaces; i++) {
        double from[3], to[3];
        status = kn_spline_box(ctx, from, to, &f->cad->faces[i].surface);
        for (int c = 0; status == KN_OK && c < 3; c++) lo[c] = fmin(lo[c], from[c]), hi[c] = fmax(hi[c], to[c]);
    }
    *size = 0.0;
    for (int c = 0; status == KN_OK && c < 3; c++) {
        *size = fmax(*size, hi[c] - lo[c]);
        square += (hi[c] - lo[c]) * (hi[c] - lo[c]);
    }
    if (status != KN_OK) return status;
    return cli_cad_segments(ctx, &f->segments, f->cad, tol > 0.0 ? tol : fmax(1e-3 * sqrt(square), 1e-300));
}

kn_status cli_stream_cad(kn_ctx *ctx, const kn_cad *cad, const char *name, const cli_cad_options *options,
                         kn_sink *sinks, int nsinks)
{
    faces f = {.cad = cad};
    double size = 0.0;
    kn_status status = make_parts(ctx, &f, name);
    if (status == KN_OK) status = measure(ctx, &f, &size, options->mesh_tol);
    if (status == KN_OK) status = make_patches(ctx, &f, options);
    if (status == KN_OK) status = kn_stream_patches(ctx, &f.tile, f.patches, f.npatches, size, sinks, nsinks);
    for (size_t i = 0; i < f.npatches; i++) {
        kn_spline_clear(ctx, &f.splines[i]);
        kn_trim_clear(ctx, &f.trims[i]);
    }
    for (size_t i = 0; f.bounds && i <= f.room; i++) kn_free(ctx, (void *)f.bounds[i].edges);
    kn_free(ctx, f.bounds), kn_free(ctx, f.patches), kn_free(ctx, f.splines), kn_free(ctx, f.trims),
        kn_free(ctx, f.look), kn_free(ctx, f.segments);
    kn_tile_clear(ctx, &f.tile);
    return status;
}
