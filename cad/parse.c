// SPDX-License-Identifier: Apache-2.0
// kn_cad_parse.
#include "cad/stream.h"
#include "io/state.h"
#include "kernel/context.h"

#include <string.h>

typedef struct source {
    kn_ctx *ctx;
    const char *name;
    size_t total;
    kn_state_reader at;
} source;

static kn_status bad(source *s, const char *what)
{
    return kn_fail(s->ctx, KN_EPARSE, "%s: byte %zu: %s", s->name, s->total - s->at.bytes, what);
}

static kn_status take(source *s, void *to, size_t bytes)
{
    return kn_state_take(&s->at, to, bytes) ? KN_OK : bad(s, "the end, and more is expected");
}

static kn_status take_u32(source *s, uint32_t *x)
{
    unsigned char b[4] = {0};
    kn_status status = take(s, b, sizeof b);
    *x = (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    return status;
}

// A number in [lo,hi].
static kn_status take_int(source *s, int *x, int lo, int hi, const char *what)
{
    uint32_t u;
    kn_status status = take_u32(s, &u);
    if (status != KN_OK) return status;
    int64_t value = u >= UINT32_C(0x80000000) ? (int64_t)u - (INT64_C(1) << 32) : (int64_t)u;
    if (value < lo || value > hi)
        return kn_fail(s->ctx, KN_EPARSE, "%s: byte %zu: %s, %lld", s->name, s->total - s->at.bytes - 4, what,
                       (long long)value);
    *x = (int)value;
    return KN_OK;
}

// A count of things that take `bytes` each, or more.
static kn_status take_count(source *s, int *n, size_t bytes, const char *what)
{
    kn_status status = take_int(s, n, 0, INT32_MAX, what);
    if (status == KN_OK && (size_t)*n > s->at.bytes / bytes) status = bad(s, what);
    return status;
}

static kn_status take_f64(source *s, double *x, size_t n)
{
    if (n > s->at.bytes / 8) return bad(s, "the end, and more numbers are expected");
    for (size_t k = 0; k < n; k++) {
        const unsigned char *b = s->at.data + 8 * k;
        uint64_t bits = 0;
        for (int i = 7; i >= 0; i--) bits = bits << 8 | b[i];
        memcpy(&x[k], &bits, sizeof bits);
    }
    s->at.data += 8 * n;
    s->at.bytes -= 8 * n;
    return KN_OK;
}

// The shape of a spline of one or two variables, and its knots.
static kn_status take_grid(source *s, kn_spline *a, size_t *n)
{
    int rational = 0;
    kn_status status = take_int(s, &a->nvars, 1, 2, "variables");
    if (status == KN_OK) status = take_int(s, &a->ncomp, 1, KN_MAX_COMPS, "components");
    if (status == KN_OK) status = take_int(s, &rational, 0, 1, "rational or not");
    a->rational = rational;
    *n = (size_t)a->ncomp;
    for (int d = 0; status == KN_OK && d < a->nvars; d++) {
        status = take_int(s, &a->degree[d], 0, KN_MAX_DEGREE, "degree");
        if (status == KN_OK) status = take_count(s, &a->count[d], 8, "control points");
        size_t knots = (size_t)a->count[d] + (size_t)a->degree[d] + 1;
        if (status == KN_OK && knots > s->at.bytes / 8) status = bad(s, "knots");
        if (status == KN_OK && !(a->knots[d] = kn_alloc(s->ctx, knots, sizeof(double)))) status = KN_ENOMEM;
        if (status == KN_OK) status = take_f64(s, a->knots[d], knots);
        if (status == KN_OK && a->count[d] > 0 && *n > s->at.bytes / 8 / (size_t)a->count[d])
            status = bad(s, "control points");
        *n *= (size_t)a->count[d];
    }
    return status;
}

static kn_status take_spline(source *s, kn_spline *out)
{
    kn_spline a = {0};
    size_t n = 0;
    kn_status status = take_grid(s, &a, &n);
    if (status == KN_OK && !(a.coef = kn_alloc(s->ctx, n, sizeof(double)))) status = KN_ENOMEM;
    if (status == KN_OK) status = take_f64(s, a.coef, n);
    if (status == KN_OK) status = kn_spline_check(s->ctx, &a);
    if (status == KN_OK) kn_spline_swap(out, &a);
    for (int d = 0; d < KN_MAX_VARS; d++) kn_free(s->ctx, a.knots[d]); // it may be half made
    kn_free(s->ctx, a.coef);
    return status;
}

static kn_status take_trim(source *s, kn_cad_face *f)
{
    enum { LEAST_SPLINE = 4 * (3 + 2) };
    int curves = 0, loops = 0;
    kn_status status = take_count(s, &curves, LEAST_SPLINE + 4, "curves of a trim");
    if (status == KN_OK) status = take_count(s, &loops, 4, "loops of a trim");
    if (status != KN_OK) return status;
    kn_trim *t = &f->trim;
    t->curves = kn_alloc_zero(s->ctx, (size_t)curves, sizeof *t->curves);
    t->loop_end = kn_alloc_zero(s->ctx, (size_t)loops, sizeof *t->loop_end);
    f->edge = kn_alloc_zero(s->ctx, (size_t)curves, sizeof *f->edge);
    if (!t->curves || !t->loop_end || !f->edge) return KN_ENOMEM; // counts are still 0: nothing in them is owned
    t->ncurves = curves;
    t->nloops = loops;
    for (int i = 0; status == KN_OK && i < loops; i++) status = take_int(s, &t->loop_end[i], 0, curves, "loop");
    for (int i = 0; status == KN_OK && i < curves; i++) status = take_int(s, &f->edge[i], 0, INT32_MAX, "edge");
    for (int i = 0; status == KN_OK && i < curves; i++) status = take_spline(s, &t->curves[i]);
    return status;
}

static kn_status take_uses(source *s, kn_cad_face *f)
{
    size_t n = (size_t)f->trim.ncurves;
    if (n > s->at.bytes / 4) return bad(s, "uses of edges");
    f->use = kn_alloc_zero(s->ctx, n, sizeof *f->use);
    kn_status status = f->use ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        int flags = 0;
        status = take_int(s, &flags, 0, KN_CAD_AGAINST | KN_CAD_HAS_PLANE, "flags of a use");
        f->use[i].against = flags & KN_CAD_AGAINST;
        if (status == KN_OK && flags & KN_CAD_HAS_PLANE) status = take_spline(s, &f->use[i].plane);
    }
    return status;
}

static kn_status take_face(source *s, kn_cad_face *f)
{
    int type = 0, flags = 0;
    kn_status status = take(s, f->name, sizeof f->name);
    if (status == KN_OK) status = take_int(s, &type, 0, KN_CAD_TYPES - 1, "type of a face");
    f->type = (kn_cad_type)type;
    if (status == KN_OK) status = take_int(s, &f->body, 0, INT32_MAX, "body of a face");
    if (status == KN_OK) status = take_int(s, &f->shell, 0, INT32_MAX, "shell of a face");
    if (status == KN_OK)
        status = take_int(s, &flags, 0, KN_CAD_COLORED | KN_CAD_WHOLE | KN_CAD_USES, "flags of a face");
    f->colored = flags & KN_CAD_COLORED;
    f->whole = flags & KN_CAD_WHOLE;
    if (status == KN_OK) status = take_f64(s, f->color, 3);
    if (status == KN_OK) status = take_f64(s, &f->error, 1);
    if (status == KN_OK) status = take_f64(s, &f->trim_error, 1);
    if (status == KN_OK) status = take_spline(s, &f->surface);
    if (status == KN_OK) status = take_trim(s, f);
    return status == KN_OK && flags & KN_CAD_USES ? take_uses(s, f) : status;
}

static kn_status take_body(source *s, kn_cad_body *b)
{
    int solid = 0;
    kn_status status = take(s, b->name, sizeof b->name);
    if (status == KN_OK) status = take_int(s, &solid, 0, 1, "solid or not");
    b->solid = solid;
    if (status == KN_OK) status = take_int(s, &b->instances, 1, INT32_MAX, "instances of a body");
    return status == KN_OK ? take_f64(s, b->place, 12) : status;
}

static kn_status take_edge(source *s, kn_cad_edge *e)
{
    int flags = 0;
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < 2; k++)
        status = take_int(s, &e->face[k], -1, INT32_MAX, "face of an edge");
    for (int k = 0; status == KN_OK && k < 2; k++)
        status = take_int(s, &e->curve[k], -1, INT32_MAX, "curve of an edge");
    if (status == KN_OK)
        status = take_int(s, &flags, 0, KN_CAD_MORE | KN_CAD_POINT | KN_CAD_HAS_LINE, "flags of an edge");
    e->more = flags & KN_CAD_MORE;
    e->point = flags & KN_CAD_POINT;
    if (status == KN_OK) status = take_f64(s, &e->angle, 1);
    if (!(flags & KN_CAD_HAS_LINE)) return status;
    for (int k = 0; status == KN_OK && k < 2; k++)
        status = take_int(s, &e->vertex[k], 0, INT32_MAX, "vertex of an edge");
    if (status == KN_OK) status = take_f64(s, &e->error, 1);
    return status == KN_OK ? take_spline(s, &e->line) : status;
}

static kn_status take_head(source *s, int *nbodies, int *nvertices, int *nedges, int *nfaces)
{
    unsigned char head[8];
    kn_status status = take(s, head, sizeof head);
    if (status != KN_OK) return status;
    if (memcmp(head, "KNCAD\0\0", 7) != 0) return bad(s, "this is no model as knurl writes it");
    if (head[7] != KN_CAD_VERSION)
        return kn_fail(s->ctx, KN_EPARSE, "%s: byte 7: version %d, not %d", s->name, head[7], KN_CAD_VERSION);
    status = take_count(s, nbodies, KN_CAD_BODY_BYTES, "bodies");
    if (status == KN_OK) status = take_count(s, nvertices, KN_CAD_VERTEX_BYTES, "vertices");
    if (status == KN_OK) status = take_count(s, nedges, KN_CAD_EDGE_BYTES, "edges");
    if (status == KN_OK) status = take_count(s, nfaces, KN_CAD_FACE_BYTES, "faces");
    return status;
}

static kn_status take_all(source *s, kn_cad *cad)
{
    int nbodies = 0, nvertices = 0, nedges = 0, nfaces = 0;
    kn_status status = take_head(s, &nbodies, &nvertices, &nedges, &nfaces);
    if (status != KN_OK) return status;
    cad->bodies = kn_alloc_zero(s->ctx, (size_t)nbodies, sizeof *cad->bodies);
    cad->vertices = kn_alloc_zero(s->ctx, (size_t)nvertices, sizeof *cad->vertices);
    cad->edges = kn_alloc_zero(s->ctx, (size_t)nedges, sizeof *cad->edges);
    cad->faces = kn_alloc_zero(s->ctx, (size_t)nfaces, sizeof *cad->faces);
    if (!cad->bodies || !cad->vertices || !cad->edges || !cad->faces) return KN_ENOMEM;
    cad->nbodies = nbodies, cad->nvertices = nvertices, cad->nedges = nedges, cad->nfaces = nfaces;
    for (int i = 0; status == KN_OK && i < nbodies; i++) status = take_body(s, &cad->bodies[i]);
    for (int i = 0; status == KN_OK && i < nvertices; i++) status = take_f64(s, cad->vertices[i].at, 3);
    for (int i = 0; status == KN_OK && i < nedges; i++) status = take_edge(s, &cad->edges[i]);
    for (int i = 0; status == KN_OK && i < nfaces; i++) status = take_face(s, &cad->faces[i]);
    if (status == KN_OK && s->at.bytes > 0) status = bad(s, "bytes after the end");
    return status == KN_OK ? kn_cad_check(s->ctx, cad) : status;
}

kn_status kn_cad_parse(kn_ctx *ctx, kn_cad *out, const char *name, const unsigned char *data, size_t bytes)
{
    source s = {.ctx = ctx, .name = name, .total = bytes, .at = {.data = data, .bytes = bytes}};
    kn_cad cad = {0};
    kn_status status = take_all(&s, &cad);
    if (status == KN_OK) {
        kn_cad old = *out;
        *out = cad;
        cad = old;
    }
    kn_cad_clear(ctx, &cad);
    return status;
}
